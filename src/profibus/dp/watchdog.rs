//! Someone who must be heard again within a time.

use core::time::Duration;

use crate::time::Instant;

/// The monitoring of the owner (`dp-v0.md` 8, DP_CONTROL) or of the application.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watchdog {
    pub(super) time: Duration,
    pub(super) heard: Instant,
}

impl Watchdog {
    pub(super) const fn expires(&self) -> Instant {
        self.heard.saturating_add(self.time)
    }

    /// The time, if it is over at `now`.
    pub(super) fn expired(self, now: Instant) -> Option<Duration> {
        (self.expires() <= now).then_some(self.time)
    }
}
