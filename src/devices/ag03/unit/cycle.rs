//! When the next application cycle runs.

use core::num::NonZeroU64;
use core::time::Duration;

use thiserror::Error;

use crate::time::{Instant, nanos};

/// How often a drive runs unless set otherwise. The manuals state no time.
pub const DEFAULT_APPLICATION_CYCLE: Duration = Duration::from_millis(1);

/// A late unit makes up for at most this much time; a process that slept longer has slept, not travelled.
const MOST_TIME_MADE_UP: Duration = Duration::from_secs(60);

/// How often a unit runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ApplicationCycle(Duration);

impl ApplicationCycle {
    /// Every [`DEFAULT_APPLICATION_CYCLE`].
    pub const DEFAULT: Self = Self(DEFAULT_APPLICATION_CYCLE);

    /// Once after each exchange of the bus, for tests that count exchanges. [`DEFAULT_APPLICATION_CYCLE`] passes for the
    /// drive each time.
    pub const EACH_EXCHANGE: Self = Self(Duration::ZERO);

    /// The shortest: a device that is called late makes up for up to 60 s, 600 000 cycles
    /// at most, which take well under a second on a computer.
    pub(crate) const SHORTEST: Duration = Duration::from_micros(100);

    /// A cycle of this time.
    ///
    /// # Errors
    /// [`CycleTooShort`] below `ApplicationCycle::SHORTEST`.
    pub const fn every(time: Duration) -> Result<Self, CycleTooShort> {
        if time.as_nanos() < Self::SHORTEST.as_nanos() {
            return Err(CycleTooShort { got: time });
        }
        Ok(Self(time))
    }

    /// From one cycle to the next; `None`: the bus decides when a cycle runs.
    pub(crate) const fn period(self) -> Option<Duration> {
        if self.0.is_zero() { None } else { Some(self.0) }
    }

    /// How much time passes for the drive in one cycle.
    pub(crate) const fn step(self) -> Duration {
        if self.0.is_zero() { DEFAULT_APPLICATION_CYCLE } else { self.0 }
    }
}

/// An application cycle that no computer keeps up with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the application cycle is {got:?}, expected {:?} or more", ApplicationCycle::SHORTEST)]
pub struct CycleTooShort {
    /// The time found.
    pub got: Duration,
}

/// The grid of application cycles since a unit was made. While nothing can change there is no next one.
#[derive(Clone, Debug)]
pub(crate) struct Cycles {
    cycle: ApplicationCycle,
    start: Instant,
    next: Option<Instant>,
}

impl Cycles {
    /// A grid of these cycles that starts at `start`; the first is due one cycle later.
    pub(crate) fn new(cycle: ApplicationCycle, start: Instant) -> Self {
        let mut cycles = Self { cycle, start, next: None };
        cycles.wake(start);
        cycles
    }

    /// Where the grid starts.
    pub(crate) const fn start(&self) -> Instant {
        self.start
    }

    /// Whether there is no grid.
    pub(crate) const fn is_manual(&self) -> bool {
        self.cycle.period().is_none()
    }

    /// How much time passes for the drive in one cycle.
    pub(crate) const fn step(&self) -> Duration {
        self.cycle.step()
    }

    /// When the next cycle is due; `None` while nothing can change.
    pub(crate) const fn next(&self) -> Option<Instant> {
        self.next
    }

    /// Something has changed: the next point of the grid after `now` is due, unless one is due already.
    #[inline]
    pub(crate) fn wake(&mut self, now: Instant) {
        if self.next.is_some() {
            return;
        }
        let Some(length) = self.cycle.period().and_then(|period| NonZeroU64::new(nanos(period))) else {
            return;
        };
        let elapsed = nanos(now.saturating_since(self.start));
        let next = (elapsed / length + 1).saturating_mul(length.get());
        self.next = Some(self.start.saturating_add(Duration::from_nanos(next)));
    }

    /// The cycle that was due at `due` has run.
    pub(crate) const fn ran(&mut self, due: Instant, at_rest: bool) {
        self.next = match self.cycle.period() {
            Some(period) if !at_rest => Some(due.saturating_add(period)),
            Some(_) | None => None,
        };
    }

    /// Moves a cycle that is overdue beyond all measure up to the time that is made up for. Says whether there was one.
    #[inline]
    pub(crate) fn forfeit(&mut self, now: Instant) -> bool {
        let overdue = self.next.is_some_and(|due| due.saturating_add(MOST_TIME_MADE_UP) < now);
        if overdue {
            self.next = None;
            self.wake(Instant::from_nanos(now.as_nanos().saturating_sub(nanos(MOST_TIME_MADE_UP))));
        }
        overdue
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn a_cycle_below_the_shortest_is_refused() {
        for nanos in [0, 1, 99_999] {
            let got = Duration::from_nanos(nanos);
            assert_eq!(ApplicationCycle::every(got), Err(CycleTooShort { got }));
        }
        let error = ApplicationCycle::every(Duration::from_nanos(1)).unwrap_err();
        assert_eq!(error.to_string(), "the application cycle is 1ns, expected 100µs or more");
        assert!(ApplicationCycle::every(ApplicationCycle::SHORTEST).is_ok());
        assert!(ApplicationCycle::every(Duration::MAX).is_ok());
    }
}
