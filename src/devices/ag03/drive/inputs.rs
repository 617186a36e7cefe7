//! What acts on the drive from outside, in physical quantities, and the words for each that changes.

use core::fmt;

use crate::devices::ag03::param::Model;

use super::faults::Fault;
use super::states::Key;

/// The world around the drive. The plant turns it into motion, currents, warnings and faults.
///
/// ```
/// use profidrive::devices::ag03::drive::{Fault, Inputs};
///
/// // A load of 5.5 Nm on a supply that has dropped to 20 V.
/// let strained = Inputs { load_torque: 5.5, output_supply: 20.0, ..Inputs::default() };
/// // Whatever it takes to make fault D.
/// let hot = Inputs::default().provoking(Fault::D);
/// assert_eq!(hot.stage_temperature, Some(95.0));
/// # assert_ne!(strained, hot);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// Supply of the control in V, 0..=60; on an AG03 the only supply. Below
    /// [`Constants::supply_present`](super::plant::Constants::supply_present) it counts as missing.
    pub control_supply: f64,
    /// AG03/1: supply of the output stage in V, 0..=60. Without meaning on an AG03.
    pub output_supply: f64,
    /// AG03: the enable input is active. Without meaning on an AG03/1.
    pub enable_input: bool,
    /// Battery of the encoder in V, 0..=10.
    pub battery: f64,
    /// Torque with which the load pulls the output shaft clockwise (seen on the clamping ring) in Nm, -1000..=1000:
    /// it hinders counter-clockwise turns and drives clockwise ones, like a hanging weight. Negative: the other way.
    pub load_torque: f64,
    /// Torque with which the load hinders turns in both directions in Nm, 0..=1000.
    pub friction_torque: f64,
    /// The output shaft is blocked.
    pub blocked: bool,
    /// Temperature of the air in degC, -50..=200.
    pub ambient: f64,
    /// Temperature of the output stage in degC, -50..=200, instead of the one that follows from the current.
    pub stage_temperature: Option<f64>,
    /// Voltage of the intermediate circuit in V, 0..=100, instead of the one that follows from supply and braking.
    pub dc_link: Option<f64>,
    /// SIN/COS monitoring of the encoder finds an error (AG03/1).
    pub encoder_fault: bool,
    /// The drive finds an internal error.
    pub internal_fault: bool,
    /// Key 1 (AG03: right) is held.
    pub key_clockwise: bool,
    /// Key 2 (AG03: left) is held.
    pub key_counter_clockwise: bool,
}

impl Default for Inputs {
    /// Nominal: 24 V, enabled, a good battery, no load, 25 degC, nothing wrong, no key.
    fn default() -> Self {
        Self {
            control_supply: 24.0,
            output_supply: 24.0,
            enable_input: true,
            battery: 3.0,
            load_torque: 0.0,
            friction_torque: 0.0,
            blocked: false,
            ambient: 25.0,
            stage_temperature: None,
            dc_link: None,
            encoder_fault: false,
            internal_fault: false,
            key_clockwise: false,
            key_counter_clockwise: false,
        }
    }
}

impl Inputs {
    /// The inputs with what makes `fault`. D, E, F, G and J follow at once, A, B and C once the shaft is commanded to turn.
    ///
    /// The change for C holds for a 48:1 gear with the default constants of the plant; it makes B with 24:1.
    /// [`Drive::provoking`](super::Drive::provoking) knows the drive.
    #[must_use]
    pub const fn provoking(mut self, fault: Fault) -> Self {
        match fault {
            Fault::A => (self.control_supply, self.output_supply) = (17.0, 17.0),
            Fault::B => self.blocked = true,
            Fault::C => self.friction_torque = 5.0,
            Fault::D => self.stage_temperature = Some(95.0),
            Fault::E => self.encoder_fault = true,
            Fault::F => self.internal_fault = true,
            Fault::G => self.dc_link = Some(36.0),
            Fault::J => self.battery = 2.1,
            // Not by what acts on the drive, but by its bus.
            Fault::H | Fault::I => {}
        }
        self
    }

    /// The inputs with output stage supplied (AG03/1) and enabled (AG03), or not.
    #[must_use]
    pub const fn with_output_stage(mut self, live: bool) -> Self {
        self.output_supply = if live { 24.0 } else { 0.0 };
        self.enable_input = live;
        self
    }

    /// The supply the motor runs on, V.
    pub(super) const fn motor_supply(&self, model: Model) -> f64 {
        match model {
            Model::Ag03 => self.control_supply,
            Model::Ag03_1 => self.output_supply,
        }
    }

    /// The lowest of the supplies the model has, V.
    pub(super) const fn lowest_supply(&self, model: Model) -> f64 {
        match model {
            Model::Ag03 => self.control_supply,
            Model::Ag03_1 => self.control_supply.min(self.output_supply),
        }
    }

    /// The key held; both together are none.
    pub(super) const fn key(&self) -> Option<Key> {
        match (self.key_clockwise, self.key_counter_clockwise) {
            (true, false) => Some(Key::Clockwise),
            (false, true) => Some(Key::CounterClockwise),
            (true, true) | (false, false) => None,
        }
    }

    /// Within the ranges of the fields; what is no number is the lowest value.
    pub(crate) fn limited(self) -> Self {
        let limit = |value: f64, low: f64, high: f64| value.max(low).min(high);
        Self {
            control_supply: limit(self.control_supply, 0.0, 60.0),
            output_supply: limit(self.output_supply, 0.0, 60.0),
            battery: limit(self.battery, 0.0, 10.0),
            load_torque: limit(self.load_torque, -1000.0, 1000.0),
            friction_torque: limit(self.friction_torque, 0.0, 1000.0),
            ambient: limit(self.ambient, -50.0, 200.0),
            stage_temperature: self.stage_temperature.map(|value| limit(value, -50.0, 200.0)),
            dc_link: self.dc_link.map(|value| limit(value, 0.0, 100.0)),
            ..self
        }
    }
}

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

    #[test]
    fn inputs_beyond_their_range_are_limited_and_no_number_is_the_lowest() {
        let wild = Inputs { control_supply: 1e9, battery: -1.0, load_torque: f64::NAN, ..Inputs::default() };
        let tame = wild.limited();
        assert_eq!((tame.control_supply, tame.battery, tame.load_torque), (60.0, 0.0, -1000.0));
        assert_eq!(Inputs::default().limited(), Inputs::default());
    }

    #[test]
    fn two_keys_are_none() {
        let both = Inputs { key_clockwise: true, key_counter_clockwise: true, ..Inputs::default() };
        assert_eq!(both.key(), None);
    }

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
