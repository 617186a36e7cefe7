//! What surrounds the drive, and what is seen of it.

use super::Device;
use crate::devices::ag03::drive::Inputs;
use crate::devices::ag03::param::Model;
use crate::devices::ag03::surroundings::BehindBus;
use crate::devices::ag03::unit::Unit;
use crate::face::DriveState;
use crate::face::surroundings::Glow;
use crate::profibus::dp;
use crate::time::Instant;

impl BehindBus for Device {
    const BOTH_MODELS: bool = true;

    fn unit(&self) -> &Unit {
        Self::unit(self)
    }

    fn model(&self) -> Model {
        self.config().model
    }

    fn change_inputs(&mut self, now: Instant, inputs: Inputs) {
        self.set_inputs(now, inputs);
    }

    fn bus_led(&self) -> Glow {
        match self.dp_state() {
            dp::State::DataExch => Glow::On,
            dp::State::WaitPrm | dp::State::WaitCfg => Glow::Off,
        }
    }

    fn state_on_bus(&self) -> DriveState {
        self.drive_state()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;
    use crate::face::Surroundings;
    use crate::face::surroundings::{Declined, Level};
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
