//! A value over time.

use core::time::Duration;
use std::collections::VecDeque;

use super::{Source, SourceError};
use crate::time::Instant;

/// Changes that wait for their delay at most; of more the oldest are skipped.
const MAX_WAITING: usize = 4096;

/// So near to what it follows a lag has arrived.
const ARRIVED: f64 = 1e-6;

/// A value that follows a source. It knows no bus: whoever asks for it reads the values elsewhere, which `R` names.
#[derive(Clone, Debug)]
pub struct Signal<R> {
    source: Source<R>,
    /// The first call.
    since: Option<Instant>,
    /// The last call.
    last: Option<Instant>,
    /// Changes seen elsewhere, and when they are to be shown.
    waiting: VecDeque<(Instant, f64)>,
    shown: f64,
}

impl<R> Signal<R> {
    /// A value that follows `source`.
    ///
    /// # Errors
    /// [`SourceError`].
    pub fn new(source: Source<R>) -> Result<Self, SourceError> {
        source.check()?;
        Ok(Self { source, since: None, last: None, waiting: VecDeque::new(), shown: 0.0 })
    }

    /// What it follows.
    pub(crate) const fn source(&self) -> &Source<R> {
        &self.source
    }

    /// The value now, and when it may change though nothing that it reads does. `read` reads a value elsewhere; one that is
    /// not there is 0.
    pub fn value(&mut self, now: Instant, read: &dyn Fn(&R) -> Option<f64>) -> (f64, Option<Instant>) {
        let since = *self.since.get_or_insert(now);
        if let Some(said) = self.source.at(now.saturating_since(since)) {
            return (said.value, said.next.map(|next| since.saturating_add(next)));
        }
        let seen = |of: &R| read(of).unwrap_or_default();
        let truth = |holds: bool| (f64::from(u8::from(holds)), None);
        match &self.source {
            Source::Follow { of, delay } => {
                let (seen, delay) = (seen(of), *delay);
                self.later(now, seen, delay)
            }
            Source::Lag { of, time } => {
                let (seen, time) = (seen(of), *time);
                self.lagging(now, seen, time)
            }
            Source::Scale { of, factor, offset } => (factor * seen(of) + offset, None),
            Source::Compare { of, condition } => truth(condition.holds(seen(of))),
            Source::Not(of) => truth(seen(of) == 0.0),
            Source::And(all) => truth(all.iter().all(|of| seen(of) != 0.0)),
            Source::Or(all) => truth(all.iter().any(|of| seen(of) != 0.0)),
            Source::Constant(_)
            | Source::Count { .. }
            | Source::Ramp { .. }
            | Source::Sine { .. }
            | Source::Square { .. }
            | Source::Random { .. }
            | Source::Table { .. } => (self.shown, None),
        }
    }

    fn later(&mut self, now: Instant, seen: f64, delay: Duration) -> (f64, Option<Instant>) {
        if delay.is_zero() && self.waiting.is_empty() {
            self.shown = seen;
            return (seen, None);
        }
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
        (self.shown, self.waiting.front().map(|waiting| waiting.0))
    }

    fn lagging(&mut self, now: Instant, seen: f64, time: Duration) -> (f64, Option<Instant>) {
        let Some(last) = self.last.replace(now) else {
            self.shown = seen;
            return (seen, None);
        };
        let part = now.saturating_since(last).as_secs_f64() / time.as_secs_f64();
        self.shown += (seen - self.shown) * (1.0 - libm::exp(-part));
        if libm::fabs(seen - self.shown) <= ARRIVED * libm::fabs(seen).max(1.0) {
            self.shown = seen;
        }
        let next = (self.shown != seen).then(|| now.saturating_add(Source::<R>::tick()));
        (self.shown, next)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Condition;
    use super::*;

    const fn ms(ms: u64) -> Instant {
        Instant::from_micros(ms * 1000)
    }

    /// The place of a value in a list.
    type Of = usize;

    fn value(signal: &mut Signal<Of>, at: u64, values: &[f64]) -> (f64, Option<Instant>) {
        signal.value(ms(at), &|of| values.get(*of).copied())
    }

    #[test]
    fn a_change_is_followed_after_its_delay() {
        let delay = Duration::from_millis(100);
        let mut signal = Signal::new(Source::Follow { of: 0, delay }).unwrap();
        for (at, other, shown, next) in [
            (0, 5.0, 0.0, Some(100)),
            (50, 6.0, 0.0, Some(100)),
            (99, 6.0, 0.0, Some(100)),
            (100, 6.0, 5.0, Some(150)),
            (149, 6.0, 5.0, Some(150)),
            (150, 7.0, 6.0, Some(250)),
            (250, 7.0, 7.0, None),
        ] {
            assert_eq!(value(&mut signal, at, &[other]), (shown, next.map(ms)), "{at}");
        }
        let mut signal = Signal::new(Source::Follow { of: 1, delay: Duration::ZERO }).unwrap();
        assert_eq!(value(&mut signal, 0, &[3.0]), (0.0, None), "no such value");
        assert_eq!(value(&mut signal, 1, &[3.0, 4.0]), (4.0, None));
    }

    #[test]
    fn changes_that_wait_are_bounded() {
        let source = Source::Follow { of: 0, delay: Duration::from_secs(3600) };
        let mut signal = Signal::new(source).unwrap();
        for at in 0..10_000 {
            value(&mut signal, at, &[at as f64 + 1.0]);
        }
        assert_eq!(signal.waiting.len(), MAX_WAITING);
    }

    #[test]
    fn a_lag_is_63_percent_on_its_way_after_its_time_however_often_it_is_asked() {
        for step in [1, 10, 250] {
            let mut signal = Signal::new(Source::Lag { of: 0, time: Duration::from_secs(1) }).unwrap();
            assert_eq!(value(&mut signal, 0, &[0.0]), (0.0, None));
            let mut shown = 0.0;
            for at in (step..=1000).step_by(step.try_into().unwrap()) {
                let (now, next) = value(&mut signal, at, &[100.0]);
                assert_eq!(next, Some(ms(at + 10)));
                assert!(now > shown, "{now}");
                shown = now;
            }
            assert!((63.2..63.3).contains(&shown), "{step}: {shown}");
            assert_eq!(value(&mut signal, 100_000, &[100.0]), (100.0, None), "it arrives");
        }
    }

    #[test]
    fn values_elsewhere_are_scaled_compared_and_combined() {
        for (source, values, shown) in [
            (Source::Scale { of: 0, factor: -2.0, offset: 5.0 }, &[3.0][..], -1.0),
            (Source::Compare { of: 0, condition: Condition::Above(2.0) }, &[3.0], 1.0),
            (Source::Compare { of: 0, condition: Condition::Above(2.0) }, &[2.0], 0.0),
            (Source::Compare { of: 0, condition: Condition::Below(2.0) }, &[1.0], 1.0),
            (Source::Compare { of: 0, condition: Condition::Is(2.0) }, &[2.0], 1.0),
            (Source::Not(0), &[0.0], 1.0),
            (Source::Not(0), &[4.0], 0.0),
            (Source::And(vec![0, 1]), &[1.0, 2.0], 1.0),
            (Source::And(vec![0, 1]), &[1.0, 0.0], 0.0),
            (Source::And(vec![0, 1]), &[1.0], 0.0),
            (Source::Or(vec![0, 1]), &[0.0, 2.0], 1.0),
            (Source::Or(vec![0, 1]), &[0.0, 0.0], 0.0),
        ] {
            let mut signal = Signal::new(source.clone()).unwrap();
            assert_eq!(value(&mut signal, 0, values), (shown, None), "{source:?}");
        }
    }
}
