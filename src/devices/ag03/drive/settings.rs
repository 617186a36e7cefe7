//! The parameters of chapter 6 of the manual as the drive uses them: in the manual's units, and typed where a number is
//! a choice.

use crate::devices::ag03::param::{POSITIONING_MODE, Parameter, Store, VELOCITY_MODE};

use super::Motor;

/// Parameters the drive works with, read from the [`Store`] once after each change.
///
/// The values are those that the store checked; values outside the documented ranges do no harm, the motion limits them
/// (an acceleration of 0 % counts as 1 %, `ag03.md` C-02), and a value without a meaning reads as its default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    values: [i32; Parameter::COUNT],
}

impl Settings {
    /// Takes every parameter out of `store`.
    pub fn read(store: &Store) -> Self {
        let mut values = [0; Parameter::COUNT];
        for (value, parameter) in values.iter_mut().zip(Parameter::all()) {
            *value = store.value(parameter);
        }
        Self { values }
    }

    /// The same with another value of a parameter.
    #[must_use]
    pub fn with(mut self, parameter: Parameter, value: i32) -> Self {
        if let Some(place) = self.values.get_mut(parameter as usize) {
            *place = value;
        }
        self
    }

    /// The value of a parameter.
    pub(crate) fn number(&self, parameter: Parameter) -> i32 {
        self.values.get(parameter as usize).copied().unwrap_or_default()
    }

    /// The value of a parameter that is a word without sign; 0 if it is none.
    pub(crate) fn word(&self, parameter: Parameter) -> u16 {
        u16::try_from(self.number(parameter)).unwrap_or_default()
    }

    /// Parameter no. 20.
    pub(super) fn mode(&self) -> Mode {
        Mode::of_number(self.word(Parameter::OperatingMode)).unwrap_or(Mode::Positioning)
    }

    /// The deceleration of travel jobs, % of 4 rev/s^2; `None` = as a-Pos (101, and every AG03).
    pub(super) fn d_pos(&self) -> Option<u16> {
        Some(self.word(Parameter::DPos)).filter(|&percent| percent <= 100)
    }

    /// The counting direction.
    pub(super) fn sense(&self) -> SenseOfRotation {
        if self.number(Parameter::SenseOfRotation) == 1 { SenseOfRotation::E } else { SenseOfRotation::I }
    }

    /// The side that a target is approached from.
    pub(super) fn pos_type(&self) -> PosType {
        match self.number(Parameter::PosType) {
            1 => PosType::LoopPlus,
            2 => PosType::LoopMinus,
            ..=0 | 3.. => PosType::Direct,
        }
    }

    /// The travel range.
    pub(super) fn limits(&self) -> Limits {
        Limits::new(self.number(Parameter::Limit1), self.number(Parameter::Limit2))
    }

    /// Limit 1 and limit 2. They are compared in each application cycle of a shaft that turns.
    #[inline]
    pub(super) fn programmed_limits(&self) -> [i32; 2] {
        [self.number(Parameter::Limit1), self.number(Parameter::Limit2)]
    }

    /// How inching 2 stops.
    pub(super) fn stop_mode_inch_2(&self) -> StopMode {
        if self.number(Parameter::StopModeInch2) == 1 { StopMode::Ramp } else { StopMode::Maximum }
    }

    /// What the motor does at the target: hold the position, short its windings, or nothing.
    pub(super) fn inpos(&self) -> Motor {
        match self.number(Parameter::InposMode) {
            1 => Motor::Shorted,
            2 => Motor::Released,
            ..=0 | 3.. => Motor::InControl,
        }
    }

    /// The threshold of the torque, %; `None` = off (125).
    pub(super) fn torque_deactivation(&self) -> Option<i32> {
        match self.number(Parameter::TorqueDeactivation) {
            percent @ 0..125 => Some(percent),
            ..0 | 125.. => None,
        }
    }
}

/// Operating mode (parameter no. 20).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// The setpoint is a velocity in rpm (stored value 1).
    Velocity,
    /// The setpoint is a position (stored value 2, default).
    Positioning,
}

impl Mode {
    /// The mode of this value of PNU 930.
    pub(crate) const fn of_number(number: u16) -> Option<Self> {
        match number {
            VELOCITY_MODE => Some(Self::Velocity),
            POSITIONING_MODE => Some(Self::Positioning),
            _neither => None,
        }
    }

    /// The value of PNU 930.
    pub(crate) const fn number(self) -> u16 {
        match self {
            Self::Velocity => VELOCITY_MODE,
            Self::Positioning => POSITIONING_MODE,
        }
    }
}

/// Counting direction of the measuring system (parameter no. 18).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SenseOfRotation {
    /// Counter-clockwise, seen on the clamping ring, counts positive (stored value 0).
    I,
    /// Counter-clockwise counts negative (stored value 1).
    E,
}

/// From which side a target is approached (parameter no. 19).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PosType {
    /// Straight to the target (stored value 0).
    Direct,
    /// Always in positive direction (stored value 1).
    LoopPlus,
    /// Always in negative direction (stored value 2).
    LoopMinus,
}

/// How inching 2 and the keys stop (parameter no. 25).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopMode {
    /// With maximum deceleration (stored value 0).
    Maximum,
    /// With a-Inch (stored value 1).
    Ramp,
}

/// The travel range in user units (parameters nos. 15 and 16).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Limits {
    lower: i32,
    upper: i32,
}

impl Limits {
    /// The range between limit 1 and limit 2 in any order; two equal limits switch the monitoring off.
    pub(crate) const fn new(limit_1: i32, limit_2: i32) -> Self {
        if limit_1 < limit_2 {
            Self { lower: limit_1, upper: limit_2 }
        } else {
            Self { lower: limit_2, upper: limit_1 }
        }
    }

    /// The lower of the two limits.
    pub(crate) const fn lower(self) -> i32 {
        self.lower
    }

    /// The higher of the two limits.
    pub(crate) const fn upper(self) -> i32 {
        self.upper
    }

    /// Whether the limits are monitored: they are not equal.
    pub(crate) const fn are_monitored(self) -> bool {
        self.lower != self.upper
    }

    /// Whether `position` is above the range.
    pub(crate) const fn is_above(self, position: i32) -> bool {
        self.are_monitored() && position > self.upper
    }

    /// Whether `position` is below the range.
    pub(crate) const fn is_below(self, position: i32) -> bool {
        self.are_monitored() && position < self.lower
    }
}

/// Settings of a new drive.
#[cfg(test)]
pub(super) fn defaults() -> Settings {
    use crate::devices::ag03::param::{Gear, Model};
    Settings::read(&Store::new(Model::Ag03_1, Gear::Ratio48))
}

/// Settings of tests: `with_` and the name, the value as the drive has it.
#[cfg(test)]
macro_rules! settings_of_tests {
    ($($name:ident($value:ident: $kind:ty) = $($parameter:ident $number:expr),+;)*) => {
        impl Settings {
            $(pub(super) fn $name(self, $value: $kind) -> Self {
                self$(.with(Parameter::$parameter, $number))+
            })*
        }
    };
}

#[cfg(test)]
settings_of_tests! {
    with_mode(mode: Mode) = OperatingMode mode.number().into();
    with_a_pos(percent: u16) = APos percent.into();
    with_v_pos(rpm: u16) = VPos rpm.into();
    with_d_pos(percent: Option<u16>) = DPos percent.unwrap_or(101).into();
    with_a_rot(percent: u16) = ARot percent.into();
    with_a_inch(percent: u16) = AInch percent.into();
    with_v_inch(rpm: u16) = VInch rpm.into();
    with_offset_inch_2(percent: u16) = OffsetInch2 percent.into();
    with_window(window: u16) = PosWindow window.into();
    with_gear_numerator(number: u16) = GearNumerator number.into();
    with_gear_denominator(number: u16) = GearDenominator number.into();
    with_spindle_pitch(pitch: u16) = SpindlePitch pitch.into();
    with_sense(sense: SenseOfRotation) = SenseOfRotation sense as i32;
    with_pos_type(pos_type: PosType) = PosType pos_type as i32;
    with_limits(limits: Limits) = Limit1 limits.upper(), Limit2 limits.lower();
    with_delta_inch(delta: i32) = DeltaInch delta;
    with_stop_mode_inch_2(stop: StopMode) = StopModeInch2 stop as i32;
    with_inpos(motor: Motor) = InposMode match motor {
        Motor::InControl => 0,
        Motor::Shorted => 1,
        Motor::Released => 2,
    };
    with_loop_length(length: u16) = LoopLength length.into();
    with_torque_deactivation(percent: Option<u16>) = TorqueDeactivation percent.unwrap_or(125).into();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_the_limits_is_irrelevant_and_equal_limits_are_off() {
        assert_eq!(Limits::new(-5, 7), Limits::new(7, -5));
        let range = Limits::new(7, -5);
        assert!(range.is_above(8) && !range.is_above(7) && range.is_below(-6) && !range.is_below(-5));
        let off = Limits::new(3, 3);
        assert!(!off.is_above(i32::MAX) && !off.is_below(i32::MIN));
    }
}
