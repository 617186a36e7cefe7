//! The steps in which a drive lives while something moves.

use core::time::Duration;

use crate::time::Instant;

/// The time of a step.
const STEP: Duration = Duration::from_millis(1);
/// The same in seconds.
pub(crate) const STEP_SECONDS: f64 = 0.001;
/// A host that was away for longer has lost the motion before.
const MOST_AT_ONCE: Duration = Duration::from_secs(10);

/// Until when a drive has lived, and whether something moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    now: Instant,
    awake: bool,
}

impl Pace {
    /// Nothing moves.
    pub(crate) const fn resting(now: Instant) -> Self {
        Self { now, awake: false }
    }

    /// The time of the newest step.
    pub(crate) const fn now(&self) -> Instant {
        self.now
    }

    /// Something may move from now on.
    pub(crate) const fn wake(&mut self) {
        self.awake = true;
    }

    /// Nothing moves any more.
    pub(crate) const fn rest(&mut self) {
        self.awake = false;
    }

    /// When the next step is due; `None` while nothing moves.
    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        self.awake.then(|| self.now.saturating_add(STEP))
    }

    /// Whether a step is due up to `now`; then it is to be made.
    pub(crate) fn begin_step(&mut self, now: Instant) -> bool {
        if !self.awake {
            self.now = self.now.max(now);
            return false;
        }
        let missed = now.saturating_since(self.now);
        if missed > MOST_AT_ONCE {
            self.now = self.now.saturating_add(missed - MOST_AT_ONCE);
        }
        let next = self.now.saturating_add(STEP);
        let due = next <= now;
        if due {
            self.now = next;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_made_while_something_moves_and_of_ten_seconds_at_most() {
        let at = Instant::from_millis;
        let mut pace = Pace::resting(at(0));
        assert!(!pace.begin_step(at(5)) && pace.now() == at(5) && pace.poll_timeout().is_none());
        pace.wake();
        assert_eq!(pace.poll_timeout(), Some(at(6)));
        assert!(pace.begin_step(at(7)) && pace.begin_step(at(7)) && !pace.begin_step(at(7)));
        let mut steps = 0;
        while pace.begin_step(at(60_007)) {
            steps += 1;
        }
        assert_eq!((steps, pace.now()), (10_000, at(60_007)));
        pace.rest();
        assert!(!pace.begin_step(at(70_000)) && pace.now() == at(70_000));
    }
}
