//! What a station from a GSD tells of itself: its modules octet by octet, and what its diagnosis reports.

use core::fmt;

use super::{GsdStation, OutputsAre};
use crate::face::description::Exchange;
use crate::face::{Description, Surroundings};
use crate::time::Instant;

impl OutputsAre {
    /// Why the outputs are what they are, in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Unowned => "no master exchanges data",
            Self::Live => "Data_Exchange",
            Self::Cleared => "outputs cleared by the master",
            Self::FailSafe => "Fail_Safe: no outputs",
            Self::WatchdogExpired => "watchdog expired",
        }
    }
}

impl Surroundings for GsdStation {
    /// Its inputs belong to what moves them by itself.
    fn make_nominal(&mut self, _now: Instant) {
        self.release_all();
    }
}

impl Description for GsdStation {
    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        say(&self.outputs_are().words());
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        if !self.raised().is_empty() {
            tell(&"diagnosis", &"raised");
        }
    }

    fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        match self.outputs_are() {
            OutputsAre::Unowned | OutputsAre::Live => {}
            warned @ (OutputsAre::Cleared | OutputsAre::FailSafe | OutputsAre::WatchdogExpired) => {
                say(&warned.words());
            }
        }
    }

    fn each_exchange(&self, tell: &mut dyn FnMut(Exchange<'_>)) {
        for placed in self.layout() {
            let number = placed.slot.number;
            let name = format!("Slot {number}: {}", placed.name(self.gsd()));
            let (inputs, outputs) = (self.inputs(&placed.slot), self.outputs(&placed.slot));
            let (of_inputs, of_outputs) = (format!("slot{number} inputs"), format!("slot{number} outputs"));
            let exchange = Exchange {
                key: &of_inputs,
                name: &name,
                from_master: false,
                octets: &inputs,
                forced: Some((number, self.forced(&placed.slot))),
                details: None,
                each_entry: &|_| {},
            };
            if !inputs.is_empty() || outputs.is_empty() {
                tell(exchange);
            }
            if !outputs.is_empty() {
                let forced = Some((number, &[][..]));
                tell(Exchange { key: &of_outputs, from_master: true, octets: outputs, forced, ..exchange });
            }
        }
    }
}
