//! An input that moves by itself.

use std::collections::VecDeque;

use super::{Image, Point, Process, Source, SourceError};
use crate::time::Instant;

/// Changes that wait for their delay at most; of more the oldest are skipped.
const MAX_WAITING: usize = 4096;

/// An input and what it follows. Values that do not fit into the octets become the nearest that does.
#[derive(Clone, Debug)]
pub struct Signal {
    to: Point,
    source: Source,
    /// The first call.
    since: Option<Instant>,
    /// Changes seen at another slave, and when they are to be shown.
    waiting: VecDeque<(Instant, f64)>,
    shown: f64,
}

impl Signal {
    /// `to` follows `source`.
    ///
    /// # Errors
    /// [`SourceError`].
    pub fn new(to: Point, source: Source) -> Result<Self, SourceError> {
        source.check()?;
        Ok(Self { to, source, since: None, waiting: VecDeque::new(), shown: 0.0 })
    }

    /// The value now, and when it may change.
    fn value(&mut self, now: Instant, image: &Image<'_>) -> (f64, Option<Instant>) {
        let since = *self.since.get_or_insert(now);
        if let Some(said) = self.source.at(now.saturating_since(since)) {
            return (said.value, said.next.map(|next| since.saturating_add(next)));
        }
        match self.source {
            Source::Mirror(of) => (image.output(of).unwrap_or_default(), None),
            Source::Follow { station, of, delay } => {
                let seen = (image.others)(station, of).unwrap_or_default();
                let last = self.waiting.back().map_or(self.shown, |waiting| waiting.1);
                if seen != last {
                    if self.waiting.len() >= MAX_WAITING {
                        self.waiting.pop_front();
                    }
                    self.waiting.push_back((now.saturating_add(delay), seen));
                }
                while let Some((_, value)) = self.waiting.front().copied().filter(|(due, _)| *due <= now) {
                    self.shown = value;
                    self.waiting.pop_front();
                }
                (self.shown, Some(now.saturating_add(Source::tick())))
            }
            Source::Constant(_)
            | Source::Count { .. }
            | Source::Ramp { .. }
            | Source::Sine { .. }
            | Source::Table { .. } => (self.shown, None),
        }
    }
}

impl Process for Signal {
    fn step(&mut self, now: Instant, image: &mut Image<'_>) -> Option<Instant> {
        let (value, next) = self.value(now, image);
        // A configuration without this slot has nothing to show.
        let _ = image.set_input(self.to, self.to.kind.nearest(value));
        next
    }
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use super::super::{Slot, ValueType};
    use super::*;
    use crate::profibus::fdl::Address;

    const SLOT: Slot = Slot { number: 1, inputs: 0..2, outputs: 0..2 };
    const WORD: Point = Point { slot: 1, offset: 0, kind: ValueType::Unsigned16 };

    fn step(signal: &mut Signal, ms: u64, outputs: &[u8], other: f64) -> ([u8; 2], Option<Instant>) {
        let mut inputs = [0; 2];
        let others = |station: Address, _: Point| (station.number() == 9).then_some(other);
        let mut image = Image { slots: &[SLOT], outputs, inputs: &mut inputs, others: &others };
        let next = signal.step(Instant::from_micros(ms * 1000), &mut image);
        (inputs, next)
    }

    #[test]
    fn an_input_mirrors_an_output() {
        let mut signal = Signal::new(WORD, Source::Mirror(WORD)).unwrap();
        assert_eq!(step(&mut signal, 0, &[1, 2], 0.0), ([1, 2], None));
        assert_eq!(step(&mut signal, 5, &[0, 0], 0.0), ([0, 0], None));
        let elsewhere = Point { slot: 2, ..WORD };
        let mut signal = Signal::new(WORD, Source::Mirror(elsewhere)).unwrap();
        assert_eq!(step(&mut signal, 0, &[1, 2], 0.0), ([0, 0], None), "no such slot");
        let mut signal = Signal::new(elsewhere, Source::Constant(1.0)).unwrap();
        assert_eq!(step(&mut signal, 0, &[1, 2], 0.0), ([0, 0], None), "no such slot");
    }

    #[test]
    fn an_input_follows_the_output_of_another_slave_after_a_delay() {
        let station = Address::station(9).unwrap();
        let delay = Duration::from_millis(100);
        let mut signal = Signal::new(WORD, Source::Follow { station, of: WORD, delay }).unwrap();
        for (ms, other, shown) in [
            (0, 5.0, 0),
            (50, 6.0, 0),
            (99, 6.0, 0),
            (100, 6.0, 5),
            (149, 6.0, 5),
            (150, 7.0, 6),
            (250, 7.0, 7),
        ] {
            let (inputs, next) = step(&mut signal, ms, &[0, 0], other);
            assert_eq!(inputs, [0, shown], "{ms}");
            assert_eq!(next, Some(Instant::from_micros((ms + 10) * 1000)));
        }
    }

    #[test]
    fn changes_that_wait_are_bounded_and_values_beyond_the_octets_are_the_nearest() {
        let station = Address::station(9).unwrap();
        let source = Source::Follow { station, of: WORD, delay: Duration::from_secs(3600) };
        let mut signal = Signal::new(WORD, source).unwrap();
        for ms in 0..10_000 {
            step(&mut signal, ms, &[], ms as f64 + 1.0);
        }
        assert_eq!(signal.waiting.len(), MAX_WAITING);
        let mut signal = Signal::new(WORD, Source::Constant(1e9)).unwrap();
        assert_eq!(step(&mut signal, 0, &[], 0.0).0, [0xFF, 0xFF]);
    }
}
