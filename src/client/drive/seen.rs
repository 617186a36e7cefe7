//! What the newest image shows, and since when the shaft rests.

use core::time::Duration;

use crate::profibus::ppo::{Inputs, Zsw};
use crate::time::Instant;

/// What the images have shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// `None` without Data_Exchange.
    pub(super) zsw: Option<Zsw>,
    /// The last one, also when Data_Exchange is lost.
    pub(super) hiw: i32,
    /// `None` without an image, and after a command that turns the shaft.
    rest: Option<Rest>,
}

impl Seen {
    pub(super) const NOTHING: Self = Self { zsw: None, hiw: 0, rest: None };

    pub(super) fn note(&mut self, now: Instant, inputs: Inputs<'_>) {
        let hiw = inputs.hiw();
        *self = Self { zsw: Some(inputs.zsw()), hiw, rest: Some(Rest::seen(self.rest, now, hiw)) };
    }

    pub(super) fn lost(&mut self) {
        *self = Self { hiw: self.hiw, ..Self::NOTHING };
    }

    /// A shaft that has just begun to turn has hardly left its place: its rest does not count.
    pub(super) fn forget_rest(&mut self) {
        self.rest = None;
    }

    pub(super) fn rests(&self, now: Instant) -> bool {
        self.rest.is_some_and(|rest| rest.is_long_enough(now))
    }
}

/// So long the actual value must rest: a shaft that slows down below 2 rpm with the smallest deceleration stands then.
const REST: Duration = Duration::from_millis(200);
/// So much of the actual value is position control, not motion.
const JITTER: u32 = 2;

/// Since when the actual value rests.
#[derive(Clone, Copy, Debug)]
struct Rest {
    hiw: i32,
    since: Instant,
}

impl Rest {
    fn seen(rest: Option<Self>, now: Instant, hiw: i32) -> Self {
        rest.filter(|rest| rest.hiw.abs_diff(hiw) <= JITTER).unwrap_or(Self { hiw, since: now })
    }

    fn is_long_enough(self, now: Instant) -> bool {
        now.saturating_since(self.since) >= REST
    }
}
