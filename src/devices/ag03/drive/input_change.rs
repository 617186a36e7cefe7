//! What has changed in the world around the drive, one quantity at a time.

use core::fmt;

use super::Inputs;
use super::states::Key;

/// One quantity of [`Inputs`] and its new value. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum InputChange {
    /// Supply of the control in V.
    ControlSupply(f64),
    /// Supply of the output stage in V.
    OutputSupply(f64),
    /// The enable input is active.
    EnableInput(bool),
    /// Battery of the encoder in V.
    Battery(f64),
    /// Torque of the load, clockwise, in Nm.
    LoadTorque(f64),
    /// Torque against turns in both directions in Nm.
    FrictionTorque(f64),
    /// The shaft is blocked.
    Blocked(bool),
    /// Temperature of the air in degC.
    Ambient(f64),
    /// Temperature of the output stage in degC; `None`: it follows from the current.
    StageTemperature(Option<f64>),
    /// Voltage of the intermediate circuit in V; `None`: it follows from the supply.
    DcLink(Option<f64>),
    /// SIN/COS monitoring finds an error.
    EncoderFault(bool),
    /// The drive finds an internal error.
    InternalFault(bool),
    /// A key is held.
    KeyHeld(Key, bool),
}

impl InputChange {
    /// Everything that differs between `before` and `after`.
    pub(crate) fn between(before: &Inputs, after: &Inputs) -> impl Iterator<Item = Self> + use<> {
        let differs = |was: f64, is: f64| (was != is).then_some(is);
        let switched = |was: bool, is: bool| (was != is).then_some(is);
        let set = |was: Option<f64>, is: Option<f64>| (was != is).then_some(is);
        let (b, a) = (before, after);
        let keys = [
            (Key::Clockwise, switched(b.key_clockwise, a.key_clockwise)),
            (Key::CounterClockwise, switched(b.key_counter_clockwise, a.key_counter_clockwise)),
        ];
        let [key_1, key_2] = keys.map(|(key, held)| held.map(|held| Self::KeyHeld(key, held)));
        [
            differs(b.control_supply, a.control_supply).map(Self::ControlSupply),
            differs(b.output_supply, a.output_supply).map(Self::OutputSupply),
            switched(b.enable_input, a.enable_input).map(Self::EnableInput),
            differs(b.battery, a.battery).map(Self::Battery),
            differs(b.load_torque, a.load_torque).map(Self::LoadTorque),
            differs(b.friction_torque, a.friction_torque).map(Self::FrictionTorque),
            switched(b.blocked, a.blocked).map(Self::Blocked),
            differs(b.ambient, a.ambient).map(Self::Ambient),
            set(b.stage_temperature, a.stage_temperature).map(Self::StageTemperature),
            set(b.dc_link, a.dc_link).map(Self::DcLink),
            switched(b.encoder_fault, a.encoder_fault).map(Self::EncoderFault),
            switched(b.internal_fault, a.internal_fault).map(Self::InternalFault),
            key_1,
            key_2,
        ]
        .into_iter()
        .flatten()
    }
}

impl fmt::Display for InputChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ControlSupply(volts) => write!(f, "control supply {volts} V"),
            Self::OutputSupply(volts) => write!(f, "supply of the output stage {volts} V"),
            Self::EnableInput(true) => f.write_str("enable input active"),
            Self::EnableInput(false) => f.write_str("enable input not active"),
            Self::Battery(volts) => write!(f, "battery {volts} V"),
            Self::LoadTorque(torque) => write!(f, "load torque {torque} Nm"),
            Self::FrictionTorque(torque) => write!(f, "friction torque {torque} Nm"),
            Self::Blocked(true) => f.write_str("shaft blocked"),
            Self::Blocked(false) => f.write_str("shaft free"),
            Self::Ambient(temperature) => write!(f, "ambient temperature {temperature} degC"),
            Self::StageTemperature(Some(temperature)) => {
                write!(f, "temperature of the output stage set to {temperature} degC")
            }
            Self::StageTemperature(None) => {
                f.write_str("temperature of the output stage follows from the current")
            }
            Self::DcLink(Some(volts)) => write!(f, "intermediate circuit set to {volts} V"),
            Self::DcLink(None) => f.write_str("intermediate circuit follows from the supply"),
            Self::EncoderFault(true) => f.write_str("error of the SIN/COS monitoring"),
            Self::EncoderFault(false) => f.write_str("SIN/COS monitoring without error"),
            Self::InternalFault(true) => f.write_str("internal error"),
            Self::InternalFault(false) => f.write_str("no internal error"),
            Self::KeyHeld(key, true) => write!(f, "{key} key pressed"),
            Self::KeyHeld(key, false) => write!(f, "{key} key released"),
        }
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::devices::ag03::drive::Fault;

    #[test]
    fn only_what_differs_is_told() {
        let before = Inputs::default();
        let told = |after: Inputs| -> Vec<_> {
            InputChange::between(&before, &after).map(|change| change.to_string()).collect()
        };
        assert!(told(before).is_empty());
        assert_eq!(told(before.provoking(Fault::B)), ["shaft blocked"]);
        assert_eq!(
            told(before.provoking(Fault::A)),
            ["control supply 17 V", "supply of the output stage 17 V"]
        );
        let held = Inputs { key_clockwise: true, dc_link: Some(36.0), ..before };
        assert_eq!(told(held), ["intermediate circuit set to 36 V", "clockwise key pressed"]);
    }
}
