//! Clocks: one that runs, one that a test moves.

use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use std::sync::Arc;

use super::Clock;
use crate::time::{Instant, nanos};

/// The monotonic clock of the operating system, counted from the moment this value was made.
#[derive(Clone, Copy, Debug)]
pub struct SystemClock {
    origin: std::time::Instant,
}

impl SystemClock {
    /// A clock that reads [`Instant::ZERO`] now.
    pub fn new() -> Self {
        Self { origin: std::time::Instant::now() }
    }
}

impl Default for SystemClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for SystemClock {
    fn now(&self) -> Instant {
        Instant::ZERO.saturating_add(self.origin.elapsed())
    }
}

/// A clock that stands still until it is moved. Clones show the same time.
#[derive(Clone, Debug, Default)]
pub struct ManualClock {
    nanos: Arc<AtomicU64>,
}

impl ManualClock {
    /// A clock that reads [`Instant::ZERO`].
    pub fn new() -> Self {
        Self::default()
    }

    /// Moves the clock, and every clone of it, forward.
    pub fn advance(&self, duration: Duration) {
        let later = |now: u64| Some(now.saturating_add(nanos(duration)));
        // The closure never says `None`, so the update cannot fail.
        let _ = self.nanos.fetch_update(Ordering::SeqCst, Ordering::SeqCst, later);
    }

    /// Moves the clock to `instant`; a clock that is already there or later does not move.
    pub fn advance_to(&self, instant: Instant) {
        self.nanos.fetch_max(instant.as_nanos(), Ordering::SeqCst);
    }
}

impl Clock for ManualClock {
    fn now(&self) -> Instant {
        Instant::from_nanos(self.nanos.load(Ordering::SeqCst))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_of_a_manual_clock_share_one_time_that_never_runs_back() {
        let clock = ManualClock::new();
        let other = clock.clone();
        clock.advance(Duration::from_millis(3));
        assert_eq!(other.now(), Instant::from_millis(3));
        other.advance_to(Instant::from_millis(2));
        assert_eq!(clock.now(), Instant::from_millis(3));
        other.advance_to(Instant::from_millis(7));
        clock.advance(Duration::MAX);
        assert_eq!(other.now(), Instant::from_nanos(u64::MAX));
    }

    #[test]
    fn the_system_clock_never_runs_back() {
        let clock = SystemClock::new();
        let earlier = clock.now();
        assert!(clock.now() >= earlier);
    }
}
