//! A ramp to rest, and what follows at its end.

use super::plant::Plant;
use crate::can_bus::cia402::state;

/// So many steps a drive that goes off waits for its shaft behind the ramp: a load may turn it for ever.
const PATIENCE: u16 = 1000;

/// A ramp to rest, whatever the mode wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stopping {
    /// Increments/s^2.
    pub(crate) deceleration: f64,
    then: Then,
    /// How long its end still waits for the shaft, in steps.
    patience: u16,
}

/// What follows at the end of the ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Then {
    /// The mode goes on.
    GoOn,
    /// The motor holds.
    Hold,
    /// The state machine goes on by this event.
    Tell(state::Event),
}

impl Stopping {
    pub(crate) const fn new(deceleration: f64, then: Then) -> Self {
        Self { deceleration, then, patience: PATIENCE }
    }

    /// Whether the drive goes off behind it by a command, which another command may take back.
    pub(crate) const fn leaves(&self) -> bool {
        matches!(self.then, Then::Tell(state::Event::Command(_)))
    }

    /// The ramp came to rest: what follows. `None` while a drive that goes off waits for the shaft, which would coast
    /// otherwise.
    pub(crate) fn end(&mut self, plant: &mut Plant) -> Option<Then> {
        let goes_off = matches!(self.then, Then::Tell(_));
        if goes_off && self.patience > 0 && !plant.comes_to_rest() {
            self.patience -= 1;
            return None;
        }
        Some(self.then)
    }

    /// Whether it has to come to rest yet, at this velocity.
    pub(crate) fn is_under_way(&self, velocity: f64) -> bool {
        self.then != Then::Hold || velocity != 0.0
    }
}
