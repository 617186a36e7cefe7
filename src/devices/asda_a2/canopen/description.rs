//! What the servo tells of itself besides its objects.

use core::fmt;

use super::AsdaA2;
use crate::face::Description;
use crate::face::description::{Amount, Curve, Group, Value};

fn tenths(number: impl Into<f64>) -> Amount<'static> {
    Amount::Number(number.into() / 10.0)
}

impl Description for AsdaA2 {
    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        say(&self.servo().state());
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        if let Some(alarm) = self.servo().alarms().last() {
            tell(&format_args!("{:03X}", alarm.number()), &alarm.text());
        }
    }

    fn each_value(&self, tell: &mut dyn FnMut(Value<'_>)) {
        let servo = self.servo();
        let value = |key, name, amount| Value::new(key, name, Group::Motion, amount);
        let puu = |number: i32| Amount::Number(number.into());
        let position = value("position", "Position", puu(servo.position_actual())).unit("PUU");
        tell(position.curve(Curve::Own).headline());
        let speed = value("speed", "Speed", tenths(servo.velocity_actual())).unit("rpm").digits(1);
        tell(speed.curve(Curve::Own).headline());
        let torque = value("torque", "Torque", tenths(servo.torque_actual())).unit("%").digits(1);
        tell(torque.curve(Curve::Own));
        let target = value("target", "Position demanded", puu(servo.position_demand())).unit("PUU");
        tell(target.curve(Curve::SetpointOf("position")));
        let setpoint = value("speed_setpoint", "Speed demanded", tenths(servo.velocity_demand())).unit("rpm");
        tell(setpoint.digits(1).curve(Curve::SetpointOf("speed")));
        tell(value("following_error", "Following error", puu(servo.following_error_puu())).unit("PUU"));
    }
}
