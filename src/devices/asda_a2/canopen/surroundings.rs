//! What surrounds the servo, and what is seen of it.

use super::AsdaA2;
use crate::can_bus::canopen::Address;
use crate::can_bus::cia402::Mode;
use crate::devices::asda_a2::keypad::{Key, Seen};
use crate::devices::asda_a2::{Alarm, Inputs};
use crate::face::surroundings::{Declined, Face, Input, Level, Provocable, Surroundings};
use crate::face::{DriveState, Turning, Why};
use crate::time::Instant;

const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);

/// The digit of a value that the keys change, from the right.
const DIGITS: [&str; 10] = [
    "digit 1", "digit 2", "digit 3", "digit 4", "digit 5", "digit 6", "digit 7", "digit 8", "digit 9",
    "digit 10",
];

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
        self.inputs().each_level(tell);
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        Inputs::NOMINAL.level(name)
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        let mut inputs = *self.inputs();
        if inputs.change(name, level) {
            self.set_inputs(now, inputs);
        }
    }

    fn make_nominal(&mut self, now: Instant) {
        self.set_inputs(now, Inputs { switches: self.inputs().switches, ..Inputs::NOMINAL });
    }

    fn each_key(&self, tell: &mut dyn FnMut(&'static str, bool)) {
        for key in Key::ALL {
            tell(key.name(), self.keypad.is_held(key));
        }
    }

    fn press(&mut self, now: Instant, key: &str, down: bool) -> Result<(), Declined> {
        let key = Key::from_name(key).ok_or(Declined::Unknown)?;
        match (down, self.node.state()) {
            (false, _) => self.keypad.release(key),
            (true, None) => return Err(Declined::SwitchedOff),
            (true, Some(_)) => self.press_key(now, key),
        }
        Ok(())
    }

    fn face(&self, now: Instant) -> Face {
        let Seen { text, negative, digit } = self.seen(now);
        let digit = digit.and_then(|digit| DIGITS.get(usize::from(digit)));
        let face = Face::default().row(&text, false).sign("below zero (points lit)", negative);
        digit.into_iter().fold(face, |face, digit| face.sign(digit, true))
    }

    fn words(&self) -> &'static [Address] {
        &[CONTROLWORD, STATUSWORD]
    }

    fn mode(&self) -> i64 {
        self.servo().mode().map_or(0, Mode::code).into()
    }

    fn turning(&self) -> Option<Turning> {
        let (mode, target) = (Mode::ProfileVelocity, Address::new(0x60FF, 0));
        Some(Turning { mode, target, unit: "0.1 rpm", range: (i32::MIN, i32::MAX), inching: None })
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
