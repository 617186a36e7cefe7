//! An input of a slave that moves by itself.

use super::{Elsewhere, Image, Point, Process, Signal, Source};
use crate::time::Instant;

/// Where a signal of a slave reads.
#[derive(Clone, Debug, PartialEq)]
pub enum Origin {
    /// An output of the same slave.
    Output(Point),
    /// An input of the same slave, as it is without what is forced.
    Input(Point),
    /// A value of another device.
    Elsewhere(Elsewhere),
}

/// An input and the signal that it shows. Values that do not fit into the octets become the nearest that does.
#[derive(Clone, Debug)]
pub struct Input {
    to: Point,
    signal: Signal<Origin>,
}

impl Input {
    /// `to` shows `signal`.
    pub const fn new(to: Point, signal: Signal<Origin>) -> Self {
        Self { to, signal }
    }

    /// The input.
    pub(crate) const fn point(&self) -> Point {
        self.to
    }

    /// The values of other devices that it reads.
    pub(crate) fn elsewhere(&self) -> impl Iterator<Item = &Elsewhere> {
        self.signal.source().read_values().iter().filter_map(|origin| match origin {
            Origin::Elsewhere(elsewhere) => Some(elsewhere),
            Origin::Output(_) | Origin::Input(_) => None,
        })
    }

    /// Whether nobody tells of a change of what it reads.
    fn looks(&self) -> bool {
        self.signal.source().read_values().iter().any(|origin| match origin {
            Origin::Output(_) => false,
            Origin::Input(_) | Origin::Elsewhere(_) => true,
        })
    }
}

impl Process for Input {
    fn step(&mut self, now: Instant, image: &mut Image<'_>) -> Option<Instant> {
        let read = |origin: &Origin| match origin {
            Origin::Output(point) => image.output(*point),
            Origin::Input(point) => image.input(*point),
            Origin::Elsewhere(elsewhere) => (image.others)(elsewhere),
        };
        let (value, next) = self.signal.value(now, &read);
        // A configuration without this slot has nothing to show.
        let _ = image.set_input(self.to, self.to.kind.nearest(value));
        let look = self.looks().then(|| now.saturating_add(Source::<Origin>::tick()));
        Instant::first_of(next, look)
    }
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use super::super::{Slot, ValueType, What};
    use super::*;

    const SLOT: Slot = Slot { number: 1, inputs: 0..4, outputs: 0..2 };
    const WORD: Point = Point { slot: 1, offset: 0, kind: ValueType::Unsigned16 };

    fn input(to: Point, source: Source<Origin>) -> Input {
        Input::new(to, Signal::new(source).unwrap())
    }

    fn follow(of: Origin) -> Source<Origin> {
        Source::Follow { of, delay: Duration::ZERO }
    }

    fn step(signal: &mut Input, ms: u64, outputs: &[u8], other: f64) -> ([u8; 4], Option<Instant>) {
        let mut inputs = [0, 0, 0, 9];
        let others = |of: &Elsewhere| (of.station == 9).then_some(other);
        let mut image = Image { slots: &[SLOT], outputs, inputs: &mut inputs, others: &others };
        let next = signal.step(Instant::from_micros(ms * 1000), &mut image);
        (inputs, next)
    }

    #[test]
    fn an_input_shows_an_output_of_its_slave() {
        let mut mirror = input(WORD, follow(Origin::Output(WORD)));
        assert_eq!(step(&mut mirror, 0, &[1, 2], 0.0), ([1, 2, 0, 9], None));
        assert_eq!(step(&mut mirror, 5, &[0, 0], 0.0), ([0, 0, 0, 9], None));
        let elsewhere = Point { slot: 2, ..WORD };
        let mut mirror = input(WORD, follow(Origin::Output(elsewhere)));
        assert_eq!(step(&mut mirror, 0, &[1, 2], 0.0), ([0, 0, 0, 9], None), "no such slot");
        let mut constant = input(elsewhere, Source::Constant(1.0));
        assert_eq!(step(&mut constant, 0, &[1, 2], 0.0), ([0, 0, 0, 9], None), "no such slot");
        let mut constant = input(WORD, Source::Constant(1e9));
        assert_eq!(step(&mut constant, 0, &[], 0.0).0, [0xFF, 0xFF, 0, 9]);
    }

    #[test]
    fn what_others_show_and_own_inputs_are_looked_at_again_and_again() {
        let soon = Some(Instant::from_micros(10_000));
        let other = |station| Elsewhere { line: None, station, what: What::Output(WORD) };
        let mut signal = input(WORD, follow(Origin::Elsewhere(other(9))));
        assert_eq!(step(&mut signal, 0, &[], 5.0), ([0, 5, 0, 9], soon));
        let mut signal = input(WORD, follow(Origin::Elsewhere(other(8))));
        assert_eq!(step(&mut signal, 0, &[], 5.0), ([0, 0, 0, 9], soon), "there is none");
        let own = Point { slot: 1, offset: 3, kind: ValueType::Unsigned8 };
        let mut signal = input(WORD, follow(Origin::Input(own)));
        assert_eq!(step(&mut signal, 0, &[], 0.0), ([0, 9, 0, 9], soon));
    }
}
