//! What the drive tells of itself besides its objects.

use core::fmt;

use super::Ag03Node;
use crate::devices::ag03::description::{Observed, memory, tell_switches};
use crate::devices::ag03::drive::State;
use crate::devices::ag03::param::Model;
use crate::devices::ag03::unit::DipSwitches;
use crate::face::Description;
use crate::face::description::{Switches, Value};

impl Ag03Node {
    fn observed(&self) -> Observed<'_> {
        let released = self.status().state == State::VelocityTravelling;
        Observed {
            model: Model::Ag03_1,
            drive: self.unit().drive(),
            status: self.status(),
            released_rpm: released.then(|| self.unit().drive().held().setpoint),
        }
    }
}

impl Description for Ag03Node {
    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        say(&self.state());
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        self.observed().tell_fault(tell);
    }

    fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        self.observed().say_warning(say);
    }

    fn each_value(&self, tell: &mut dyn FnMut(Value<'_>)) {
        self.observed().each_value(tell);
    }

    fn tell_switches(&self, tell: &mut dyn FnMut(Switches<'_>)) {
        let (switches, in_force) = (self.unit().switches(), self.part.node_id.number());
        let number = ("node number", switches.node_id().number(), in_force);
        tell_switches(switches, self.config().reset_patterns, number, tell);
    }

    fn set_switches(&mut self, positions: u16) {
        Self::set_switches(self, DipSwitches::from_bits(positions));
    }

    fn memory(&self) -> Option<&'static str> {
        Some(memory(self.unit().eeprom_state()))
    }
}
