//! What surrounds the servo, and what is seen of it.

use super::AsdaA2;
use crate::can_bus::canopen::Address;
use crate::can_bus::cia402::Mode;
use crate::devices::asda_a2::{Alarm, Inputs};
use crate::face::surroundings::{Declined, Face, Input, Level, Provocable, Surroundings};
use crate::face::{DriveState, Why};
use crate::time::Instant;

const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);

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
