//! What surrounds the drive, and what is seen of it.

use core::fmt;

use super::{Device, Power};
use crate::devices::ag03::surroundings;
use crate::face::surroundings::{Declined, Face, Glow, Input, Level, Provocable, Surroundings};
use crate::face::{DriveState, Why};
use crate::profibus::dp;
use crate::time::Instant;

impl Surroundings for Device {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        let (drive, inputs) = (self.drive(), self.inputs());
        let causes = [drive.causes(), drive.provoked_by(inputs)];
        surroundings::each_fault(self.config().model, causes, tell);
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = surroundings::fault(self.config().model, fault)?;
        let inputs = self.drive().provoking(self.inputs(), fault);
        self.set_inputs(now, inputs);
        Ok(())
    }

    fn take_back(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = surroundings::fault(self.config().model, fault)?;
        self.set_inputs(now, surroundings::taken_back(self.inputs(), fault));
        Ok(())
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        surroundings::each_input(self.config().model, self.inputs(), tell);
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        if let Some(inputs) = surroundings::with_input(self.config().model, self.inputs(), name, level) {
            self.set_inputs(now, inputs);
        }
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        surroundings::nominal_level(name)
    }

    fn calculated(&self, name: &str) -> Option<f64> {
        surroundings::calculated(self.drive(), name)
    }

    fn make_nominal(&mut self, now: Instant) {
        self.set_inputs(now, surroundings::nominal(self.inputs()));
    }

    fn each_lack(&self, name: &str, say: &mut dyn FnMut(&dyn fmt::Display)) {
        surroundings::each_lack(self.config().model, name, say);
    }

    fn each_key(&self, tell: &mut dyn FnMut(&'static str, bool)) {
        surroundings::each_key(self.inputs(), tell);
    }

    fn press(&mut self, now: Instant, key: &str, down: bool) -> Result<(), Declined> {
        self.set_inputs(now, surroundings::with_key(self.inputs(), key, down)?);
        Ok(())
    }

    fn face(&self, _now: Instant) -> Face {
        let (status, bus) = match (self.power(), self.dp_state()) {
            (Power::Off, _) => (Glow::Off, Glow::Off),
            (Power::FactoryReset(_), _) => (Glow::Alternating, Glow::Alternating),
            (Power::On, dp::State::DataExch) => (surroundings::glow(self.status().led), Glow::On),
            (Power::On, dp::State::WaitPrm | dp::State::WaitCfg) => {
                (surroundings::glow(self.status().led), Glow::Off)
            }
        };
        Face::default().led("status green", status).led("bus orange", bus)
    }

    fn is_drive(&self) -> bool {
        true
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self)
    }

    fn drive_state(&self) -> Option<DriveState> {
        Some(Self::drive_state(self))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;
    use crate::devices::ag03::drive::Inputs;
    use crate::devices::ag03::param::Model;
    use crate::profibus::fdl::Address;

    fn device(model: Model) -> Device {
        let config = Config { model, ..Config::new(Address::station(5).unwrap()) };
        Device::new(config, Instant::ZERO)
    }

    fn lacks(device: &Device, name: &str) -> String {
        let mut said = String::new();
        device.each_lack(name, &mut |sentence| said = sentence.to_string());
        said
    }

    #[test]
    fn each_model_has_its_inputs_and_faults_and_says_what_the_other_has() {
        for (model, none, some, faults) in [
            (Model::Ag03, "output_supply_volts", "enable", "ABCDFG"),
            (Model::Ag03_1, "enable", "output_supply_volts", "ABCDEFGJ"),
        ] {
            let device = device(model);
            let mut inputs = Vec::new();
            device.each_input(&mut |input, _| inputs.push(input.name));
            assert!(!inputs.contains(&none) && inputs.contains(&some), "{inputs:?}");
            let mut letters = String::new();
            device.each_fault(&mut |fault| letters += &fault.name.to_string());
            assert_eq!(letters, faults);
            assert!(lacks(&device, none).starts_with("an AG03"), "{}", lacks(&device, none));
            assert_eq!(lacks(&device, some), "");
        }
        let sentence = "an AG03 has no fault J (battery empty); an AG03/1 has";
        assert_eq!(lacks(&device(Model::Ag03), "J"), sentence);
        assert_eq!(lacks(&device(Model::Ag03_1), "J"), "");
    }

    #[test]
    fn what_is_done_acts_on_the_inputs_and_nominal_is_as_made() {
        let now = Instant::ZERO;
        let mut device = device(Model::Ag03_1);
        device.set_input(now, "blocked", Level::Switch(true));
        device.set_input(now, "enable", Level::Switch(false));
        let expected = Inputs { blocked: true, ..Inputs::default() };
        assert_eq!(*device.inputs(), expected);
        assert_eq!(device.provoke(now, "D"), Ok(()));
        assert_eq!(*device.inputs(), Inputs { stage_temperature: Some(95.0), ..expected });
        assert_eq!(
            (device.provoke(now, "H"), device.press(now, "key_1", true)),
            (Err(Declined::Unknown), Ok(()))
        );
        device.make_nominal(now);
        assert_eq!(*device.inputs(), Inputs { key_clockwise: true, ..Inputs::default() });
        assert_eq!(device.face(now).to_string(), "LED status green on, LED bus orange off");
    }
}
