//! How much time passes in a step.

use core::time::Duration;

use crate::time::nanos;

/// A time that passes for the drive, as its parts count it. Worked out when it changes, not in each step: that takes two
/// multiplications, two conversions and a division, and all steps of a drive are as long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lapse {
    time: Duration,
    nanos: u64,
    seconds: f64,
}

impl Lapse {
    pub(super) const NONE: Self = Self { time: Duration::ZERO, nanos: 0, seconds: 0.0 };

    pub(super) fn of(time: Duration) -> Self {
        Self { time, nanos: nanos(time), seconds: time.as_secs_f64() }
    }

    /// Of this time, if it is another one.
    #[inline]
    pub(super) fn set(&mut self, time: Duration) {
        if self.time != time {
            *self = Self::of(time);
        }
    }

    /// In ns, at most 584 years.
    pub(super) const fn nanos(self) -> u64 {
        self.nanos
    }

    /// In s.
    pub(super) const fn seconds(self) -> f64 {
        self.seconds
    }
}
