//! What surrounds the servo, and what is seen of it.

use super::AsdaA2;
use crate::can_bus::canopen::Address;
use crate::can_bus::cia402::Mode;
use crate::devices::asda_a2::{Alarm, Inputs};
use crate::face::surroundings::{Declined, Face, Input, InputKind, Level, Provocable, Surroundings};
use crate::face::{DriveState, Why};
use crate::time::Instant;

const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);

/// The largest torque of a load, Nm.
const MOST_TORQUE: f64 = 1000.0;

const BLOCKED: Input = Input { name: "blocked", about: "the shaft cannot turn", kind: InputKind::Switch };
const LOAD: Input = Input {
    name: "load_torque_newton_metres",
    about: "load against forward motion",
    kind: InputKind::Number { low: -MOST_TORQUE, high: MOST_TORQUE, own: false },
};
const FRICTION: Input = Input {
    name: "friction_torque_newton_metres",
    about: "friction in both directions",
    kind: InputKind::Number { low: 0.0, high: MOST_TORQUE, own: false },
};
const MAIN_CIRCUIT: Input =
    Input { name: "main_circuit", about: "the main circuit is supplied", kind: InputKind::Switch };
const EMERGENCY_STOP: Input = Input {
    name: "emergency_stop_released",
    about: "the emergency stop is released",
    kind: InputKind::Switch,
};
const NEGATIVE_LIMIT: Input = Input {
    name: "negative_limit_switch",
    about: "the negative limit switch is pressed, wherever the shaft is",
    kind: InputKind::Switch,
};
const POSITIVE_LIMIT: Input = Input {
    name: "positive_limit_switch",
    about: "the positive limit switch is pressed, wherever the shaft is",
    kind: InputKind::Switch,
};
const HOME: Input = Input {
    name: "home_switch",
    about: "the home switch is pressed, wherever the shaft is",
    kind: InputKind::Switch,
};

/// Each input with its level.
fn each_level(inputs: &Inputs, tell: &mut dyn FnMut(&Input, Level)) {
    let Inputs {
        blocked, load_torque, friction_torque, main_circuit, emergency_stop_released, pressed, ..
    } = *inputs;
    tell(&BLOCKED, Level::Switch(blocked));
    tell(&LOAD, Level::Number(load_torque));
    tell(&FRICTION, Level::Number(friction_torque));
    tell(&MAIN_CIRCUIT, Level::Switch(main_circuit));
    tell(&EMERGENCY_STOP, Level::Switch(emergency_stop_released));
    tell(&NEGATIVE_LIMIT, Level::Switch(pressed.negative_limit));
    tell(&POSITIVE_LIMIT, Level::Switch(pressed.positive_limit));
    tell(&HOME, Level::Switch(pressed.home));
}

impl Surroundings for AsdaA2 {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        for alarm in Alarm::ALL {
            let present = self.servo().alarms().contains(alarm);
            tell(Provocable {
                name: &format_args!("{:03X}", alarm.number()),
                text: &alarm.text(),
                present,
                provoked: present,
            });
        }
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let alarm = Alarm::parse(fault).ok_or(Declined::Unknown)?;
        if self.node.state().is_none() {
            return Err(Declined::SwitchedOff);
        }
        Self::provoke(self, now, alarm);
        Ok(())
    }

    fn take_back(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let alarm = Alarm::parse(fault).ok_or(Declined::Unknown)?;
        self.take_back_alarm(now, alarm);
        Ok(())
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        each_level(self.inputs(), tell);
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        let mut found = None;
        each_level(&Inputs::NOMINAL, &mut |input, level| {
            if input.name == name {
                found = Some(level);
            }
        });
        found
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        let mut inputs = *self.inputs();
        match level {
            Level::Switch(on) if name == BLOCKED.name => inputs.blocked = on,
            Level::Switch(on) if name == MAIN_CIRCUIT.name => inputs.main_circuit = on,
            Level::Switch(on) if name == EMERGENCY_STOP.name => inputs.emergency_stop_released = on,
            Level::Switch(on) if name == NEGATIVE_LIMIT.name => inputs.pressed.negative_limit = on,
            Level::Switch(on) if name == POSITIVE_LIMIT.name => inputs.pressed.positive_limit = on,
            Level::Switch(on) if name == HOME.name => inputs.pressed.home = on,
            Level::Number(torque) if name == LOAD.name => {
                inputs.load_torque = torque.clamp(-MOST_TORQUE, MOST_TORQUE);
            }
            Level::Number(torque) if name == FRICTION.name => {
                inputs.friction_torque = torque.clamp(0.0, MOST_TORQUE);
            }
            Level::Switch(_) | Level::Number(_) | Level::Own => return,
        }
        self.set_inputs(now, inputs);
    }

    fn make_nominal(&mut self, now: Instant) {
        self.set_inputs(now, Inputs { switches: self.inputs().switches, ..Inputs::NOMINAL });
    }

    fn face(&self, _now: Instant) -> Face {
        use core::fmt::Write;
        let mut digits = heapless::String::<8>::new();
        if self.node.state().is_some() {
            let _ = write!(digits, "{}", self.servo().panel());
        }
        Face::default().row(&digits, false)
    }

    fn words(&self) -> &'static [Address] {
        &[CONTROLWORD, STATUSWORD]
    }

    fn mode(&self) -> i64 {
        self.servo().mode().map_or(0, Mode::code).into()
    }

    fn is_drive(&self) -> bool {
        true
    }

    fn drive_state(&self) -> Option<DriveState> {
        Some(match self.node.state() {
            Some(_) => self.servo().state().into(),
            None => DriveState::Off,
        })
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self)
    }
}
