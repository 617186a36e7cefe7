//! When a fault may act at all: between two times, or while something holds.

use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

use crate::time::Instant;

/// What somebody else turns on and off. A clone is the same switch. It is off at first.
#[derive(Clone, Debug, Default)]
pub struct Switch(Arc<AtomicBool>);

impl Switch {
    /// Turns it on or off.
    pub fn set(&self, on: bool) {
        self.0.store(on, Ordering::Relaxed);
    }

    /// Whether it is on.
    pub fn is_on(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// When a fault may act. Outside of it nothing is counted. It is looked at when a request is heard and holds for the
/// reply, too.
#[derive(Clone, Debug, Default)]
pub struct Gate {
    /// Not earlier; `None`: from the beginning.
    pub from: Option<Instant>,
    /// Earlier than this; `None`: for ever.
    pub until: Option<Instant>,
    /// Only while it is on; `None`: always.
    pub switch: Option<Switch>,
}

impl Gate {
    /// Whether the fault may act now.
    pub(super) fn is_open(&self, now: Instant) -> bool {
        self.from.is_none_or(|from| now >= from)
            && self.until.is_none_or(|until| now < until)
            && self.switch.as_ref().is_none_or(Switch::is_on)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gate_is_open_between_its_times_while_its_switch_is_on() {
        let at = Instant::from_micros;
        let switch = Switch::default();
        let gate = Gate { from: Some(at(10)), until: Some(at(20)), switch: Some(switch.clone()) };
        let open = |gate: &Gate| [9, 10, 19, 20].map(|time| gate.is_open(at(time)));
        assert_eq!(open(&gate), [false; 4], "the switch is off");
        switch.set(true);
        assert_eq!(open(&gate), [false, true, true, false]);
        switch.set(false);
        assert_eq!(open(&gate), [false; 4]);
        assert_eq!(open(&Gate::default()), [true; 4]);
    }
}
