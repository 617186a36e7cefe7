//! The parameters of chapter 6 of the manual as the drive uses them: typed, in the manual's units.

use crate::devices::ag03::param::{Model, POSITIONING_MODE, Parameter, Store, VELOCITY_MODE};

use super::Motor;

/// Parameters the drive works with, read from the [`Store`] once after each change.
///
/// The fields hold what the store checked; values outside the documented ranges do no harm, the motion limits them
/// (an acceleration of 0 % counts as 1 %, `ag03.md` C-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Parameter no. 20, PNU 930.
    pub mode: Mode,
    /// a-Pos (no. 4), % of 4 rev/s^2, 1..=100.
    pub a_pos: u16,
    /// v-Pos (no. 5), rpm of the output shaft, 1..=100 (48:1) or 1..=200 (24:1).
    pub v_pos: u16,
    /// d-Pos (no. 31, AG03/1), % of 4 rev/s^2, 1..=100. `None` = as a-Pos (stored value 101, and every AG03).
    pub d_pos: Option<u16>,
    /// a-Rot (no. 6), % of 4 rev/s^2, 1..=100.
    pub a_rot: u16,
    /// a-Inch (no. 8), % of 4 rev/s^2, 1..=100.
    pub a_inch: u16,
    /// v-Inch (no. 9), rpm, as `v_pos`.
    pub v_inch: u16,
    /// Offset inching 2 (no. 30), % of v-Inch, 10..=100.
    pub offset_inch_2: u16,
    /// Positioning window in user units, velocity window in rpm (no. 10), 0..=1000.
    pub window: u16,
    /// Gear numerator (no. 11), 1..=10000.
    pub gear_numerator: u16,
    /// Gear denominator (no. 12), 1..=10000.
    pub gear_denominator: u16,
    /// Spindle pitch (no. 13), 0.01 mm per revolution, 0 = positions count increments.
    pub spindle_pitch: u16,
    /// Sense of rotation (no. 18).
    pub sense: SenseOfRotation,
    /// Pos. type (no. 19).
    pub pos_type: PosType,
    /// Limits 1 and 2 (nos. 15, 16).
    pub limits: Limits,
    /// Delta inch (no. 17), user units, the sign is the direction.
    pub delta_inch: i32,
    /// Stop mode inching 2 (no. 25).
    pub stop_mode_inch_2: StopMode,
    /// What the motor does at the target (no. 26): hold position, windings shorted, or released.
    pub inpos: Motor,
    /// Loop length (no. 27), always increments, 0..=10000.
    pub loop_length: u16,
    /// Torque deactivation (no. 29), %, 20..=124. `None` = off (stored value 125).
    pub torque_deactivation: Option<u16>,
}

impl Settings {
    /// Takes every parameter the drive needs out of `store`. A value without a meaning reads as its default.
    pub fn read(store: &Store) -> Self {
        let signed = |parameter| store.value(parameter);
        let unsigned = |parameter| {
            let value = store.value(parameter).clamp(0, i32::from(u16::MAX));
            u16::try_from(value).unwrap_or(u16::MAX)
        };
        Self {
            mode: Mode::of_number(unsigned(Parameter::OperatingMode)).unwrap_or(Mode::Positioning),
            a_pos: unsigned(Parameter::APos),
            v_pos: unsigned(Parameter::VPos),
            d_pos: match store.model() {
                Model::Ag03 => None,
                Model::Ag03_1 => Some(unsigned(Parameter::DPos)).filter(|&percent| percent <= 100),
            },
            a_rot: unsigned(Parameter::ARot),
            a_inch: unsigned(Parameter::AInch),
            v_inch: unsigned(Parameter::VInch),
            offset_inch_2: unsigned(Parameter::OffsetInch2),
            window: unsigned(Parameter::PosWindow),
            gear_numerator: unsigned(Parameter::GearNumerator),
            gear_denominator: unsigned(Parameter::GearDenominator),
            spindle_pitch: unsigned(Parameter::SpindlePitch),
            sense: if signed(Parameter::SenseOfRotation) == 1 {
                SenseOfRotation::E
            } else {
                SenseOfRotation::I
            },
            pos_type: match signed(Parameter::PosType) {
                1 => PosType::LoopPlus,
                2 => PosType::LoopMinus,
                ..=0 | 3.. => PosType::Direct,
            },
            limits: Limits::new(signed(Parameter::Limit1), signed(Parameter::Limit2)),
            delta_inch: signed(Parameter::DeltaInch),
            stop_mode_inch_2: if signed(Parameter::StopModeInch2) == 1 {
                StopMode::Ramp
            } else {
                StopMode::Maximum
            },
            inpos: match signed(Parameter::InposMode) {
                1 => Motor::Shorted,
                2 => Motor::Released,
                ..=0 | 3.. => Motor::InControl,
            },
            loop_length: unsigned(Parameter::LoopLength),
            torque_deactivation: Some(unsigned(Parameter::TorqueDeactivation))
                .filter(|&percent| percent < 125),
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

/// Settings at the defaults of the manual's Table 6.
#[cfg(test)]
pub(super) const DEFAULTS: Settings = Settings {
    mode: Mode::Positioning,
    a_pos: 50,
    v_pos: 30,
    d_pos: None,
    a_rot: 50,
    a_inch: 50,
    v_inch: 30,
    offset_inch_2: 100,
    window: 10,
    gear_numerator: 1,
    gear_denominator: 1,
    spindle_pitch: 0,
    sense: SenseOfRotation::I,
    pos_type: PosType::Direct,
    limits: Limits::new(1_000_000, -1_000_000),
    delta_inch: 1600,
    stop_mode_inch_2: StopMode::Maximum,
    inpos: Motor::InControl,
    loop_length: 800,
    torque_deactivation: None,
};

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
