//! What a face shows of the AP10 besides its objects: fault, warning, position and speed.

use core::fmt;

use super::Ap10;
use crate::devices::ap10::Fault;
use crate::face::Description;
use crate::face::description::{Amount, Curve, Group, Value};

impl Description for Ap10 {
    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        let errors = [Fault::BatteryEmpty, Fault::Speed];
        if let Some(fault) = errors.into_iter().find(|fault| self.indicator().has(*fault)) {
            tell(&fault.name(), &fault.text());
        }
    }

    fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        if self.indicator().has(Fault::BatteryCritical) {
            say(&Fault::BatteryCritical.text());
        }
    }

    fn each_value(&self, tell: &mut dyn FnMut(Value<'_>)) {
        let value = |key, name, number| Value::new(key, name, Group::Motion, Amount::Number(number));
        let indicator = self.indicator();
        tell(value("position", "Position", indicator.position().into()).curve(Curve::Own).headline());
        tell(value("difference", "To go", indicator.difference().into()));
        tell(value("speed", "Speed", self.rpm()).unit("rpm").digits(1).curve(Curve::Own));
        tell(value("shaft", "Shaft", indicator.shaft().revolutions()).unit("turns").digits(2));
    }
}
