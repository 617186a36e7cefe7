//! Every value that can be set, as data. One value has one place, whatever names it has on a bus or on the keypad.

use super::Level::{Full, Half};
use super::on_canopen::Form::{HighWord, LowWord, Rates, Shutdown, Tenth};
use super::on_canopen::{Name, object};
use super::plant::Motor;
use super::stored;
use crate::face::DataType::{I8, I16, I32, U8, U16, U32};

/// What of a value survives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Keeping {
    /// Nothing.
    Volatile,
    /// Power-off, once stored.
    Stored,
    /// As stored; and with P3-12.Z = 0 its default comes back with each start.
    Reloaded,
    /// Power-off, once stored; restoring the defaults leaves it, as the drive would leave its network (keypad).
    Address,
}

/// Declares every value once: default, lowest and highest, keeping, meaning, its names in the object dictionary.
macro_rules! settings {
    ($($name:ident = $default:expr, $range:expr, $keeping:ident, $doc:literal, $names:expr;)*) => {
        /// A value that can be set.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Setting {
            $(#[doc = $doc] $name,)*
        }

        impl Setting {
            /// Every value.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// Its value before anything is set.
            pub const fn default(self) -> i64 {
                match self { $(Self::$name => $default,)* }
            }

            /// Its lowest and highest value.
            pub const fn range(self) -> (i64, i64) {
                match self { $(Self::$name => $range,)* }
            }

            /// What of it survives.
            pub(crate) const fn keeping(self) -> Keeping {
                match self { $(Self::$name => Keeping::$keeping,)* }
            }

            /// Its names in the object dictionary.
            pub(crate) const fn names(self) -> &'static [Name] {
                match self { $(Self::$name => const { &$names },)* }
            }
        }

        const COUNT: usize = Setting::ALL.len();
    };
}

const U16_MAX: i64 = u16::MAX as i64;
const U32_MAX: i64 = u32::MAX as i64;
const I32_RANGE: (i64, i64) = (i32::MIN as i64, i32::MAX as i64);
/// A digit that takes every value.
const ANY: (u8, u8) = (0, 15);
const I16_RANGE: (i64, i64) = (i16::MIN as i64, i16::MAX as i64);

#[rustfmt::skip] // a row is what it is on its own, then each of its names
settings! {
    ControlMode = 0x0C, (0, 0x110F), Address, "P1-01: digits B A are the mode, 0Bh CANopen half, 0Ch full.",
        [object(0x2101, 0, I16, "P1-01 control mode")];
    NodeNumber = 0x7F, (1, 0x7F), Address, "P3-00.",
        [object(0x2300, 0, I16, "P3-00 node number")];
    Rates = 0x0203, (0, 0x0405), Address, "P3-01: digit Z is the rate of CAN.",
        [object(0x2301, 0, I16, "P3-01 rates").form(Rates)
            .digits([ANY, (0, 4), ANY, ANY], "digit Z of P3-01, the bit rate, must be 0 to 4")];
    StopMode = 0x10, I16_RANGE, Reloaded, "P1-32: digit Y = 0 dynamic brake, 1 none (605Bh = -1, 0).",
        [
            object(0x2120, 0, I16, "P1-32 stop mode"),
            object(0x605B, 0, I16, "Shutdown option code").form(Shutdown).unmapped(),
        ];
    MaxMotorSpeed = Motor::MAX_RPM, (0, U32_MAX), Stored, "6080h, P1-55 in rpm.",
        [object(0x2137, 0, I16, "P1-55 maximum speed in rpm"), object(0x6080, 0, U32, "Max motor speed")];
    SpecialWrite = 0, I16_RANGE, Volatile, "P2-08.",
        [object(0x2208, 0, I16, "P2-08 special write")];
    PositionGain = 200, (0, 2047), Stored, "P2-00: the gain of the position loop in rad/s; of a tuned drive.",
        [object(0x2200, 0, I16, "P2-00 position loop gain in rad/s")];
    FeedForward = 100, (0, 100), Stored, "P2-02: how much of the velocity is demanded beside the position loop, in %.",
        [object(0x2202, 0, I16, "P2-02 position feed forward gain in %")];
    SyncAdjustment = 0x5055, I16_RANGE, Stored, "P3-09: digits E range, T target, D dead zone, M correction.",
        [object(0x2309, 0, I16, "P3-09 SYNC adjustment")
            .digits([(1, 9), (0, 9), ANY, (1, 15)], "of P3-09 digit E must be 1 to 9, T 0 to 9, M 1 to F")];
    CanEnable = 0, I16_RANGE, Stored, "P3-10: digit Y = 1 servo off on errors of the bus.",
        [object(0x230A, 0, I16, "P3-10 CANopen enable")
            .digits([(0, 0), (0, 0), (0, 1), (0, 1)], "of P3-10 digits X and Y must be 0 or 1, the others 0")];
    PdoToEeprom = 0, I16_RANGE, Stored, "P3-11: models M and F only.",
        [object(0x230B, 0, I16, "P3-11 CANopen options")
            .digits([(0, 0), (0, 0), ANY, (0, 1)], "of P3-11 digit X must be 0 or 1, Z and U 0")];
    QuickStopOptions = 0, (0, 0x0111), Stored, "P3-12: digits Z, Y, X.",
        [object(0x230C, 0, I16, "P3-12 quick stop options")
            .digits([(0, 0), (0, 1), (0, 1), (0, 1)], "digits X, Y and Z of P3-12 must be 0 or 1")];
    FaultReaction = 2, (0, 2), Stored, "605Eh.",
        [object(0x605E, 0, I16, "Fault reaction option code").unmapped()];
    Mode = 0, (0, 7), Stored, "6060h.",
        [object(0x6060, 0, I8, "Modes of operation").within(&[(0, 1), (3, 4), (6, 7)])];
    FollowingErrorWindow = 3_840_000, (0, U32_MAX), Reloaded, "6065h, P2-35 in PUU.",
        [
            object(0x2223, 0, I32, "P2-35 excessive deviation in PUU").within(&[(1, i32::MAX as i64)]),
            object(0x6065, 0, U32, "Following error window"),
        ];
    PositionWindow = 100, (0, U32_MAX), Stored, "6067h in PUU.",
        [object(0x6067, 0, U32, "Position window")];
    PositionWindowTime = 0, (0, U16_MAX), Stored, "6068h in ms.",
        [object(0x6068, 0, U16, "Position window time")];
    VelocityWindow = 100, (0, 3000), Reloaded, "606Dh in 0.1 rpm, P1-47 in rpm.",
        [
            object(0x212F, 0, I16, "P1-47 speed reached in rpm").form(Tenth),
            object(0x606D, 0, U16, "Velocity window"),
        ];
    VelocityWindowTime = 0, (0, U16_MAX), Reloaded, "606Eh, P1-49 in ms.",
        [
            object(0x2131, 0, I16, "P1-49 speed reached time in ms"),
            object(0x606E, 0, U16, "Velocity window time"),
        ];
    ZeroSpeed = 100, (0, 2000), Reloaded, "606Fh, P1-38 in 0.1 rpm.",
        [object(0x2126, 0, I16, "P1-38 zero speed in 0.1 rpm"), object(0x606F, 0, U16, "Velocity threshold")];
    TargetTorque = 0, (-3000, 3000), Volatile, "6071h in 0.1 % of the rated torque.",
        [object(0x6071, 0, I16, "Target torque")];
    TargetPosition = 0, I32_RANGE, Volatile, "607Ah in PUU.",
        [object(0x607A, 0, I32, "Target position")];
    HomeOffset = 0, I32_RANGE, Stored, "607Ch in PUU.",
        [object(0x607C, 0, I32, "Home offset")];
    ReverseSoftLimit = i32::MIN as i64, I32_RANGE, Stored, "607Dh:1 in PUU.",
        [object(0x607D, 1, I32, "Reverse")];
    ForwardSoftLimit = i32::MAX as i64, I32_RANGE, Stored, "607Dh:2 in PUU.",
        [object(0x607D, 2, I32, "Forward")];
    MaxProfileVelocity = Motor::MAX_RPM * 10, (0, U32_MAX), Stored, "607Fh in 0.1 rpm.",
        [object(0x607F, 0, U32, "Max profile velocity")];
    ProfileVelocity = 10_000, (0, U32_MAX), Stored, "6081h in PUU/s.",
        [object(0x6081, 0, U32, "Profile velocity")];
    Acceleration = 200, (1, U32_MAX), Reloaded, "6083h, P1-34 in ms from 0 to 3000 rpm.",
        [
            object(0x2122, 0, I16, "P1-34 acceleration time in ms"),
            object(0x6083, 0, U32, "Profile acceleration"),
        ];
    Deceleration = 200, (1, U32_MAX), Reloaded, "6084h, P1-35 in ms from 3000 rpm to 0.",
        [
            object(0x2123, 0, I16, "P1-35 deceleration time in ms"),
            object(0x6084, 0, U32, "Profile deceleration"),
        ];
    QuickStopDeceleration = 0, (0, U32_MAX), Stored, "6085h in ms from 3000 rpm to 0; 0 is at once.",
        [object(0x6085, 0, U32, "Quick stop deceleration")];
    ProfileType = 0, I16_RANGE, Stored, "6086h: 0 linear ramps, 1 to 3 ramps without corners.",
        [object(0x6086, 0, I16, "Motion profile type")];
    TorqueSlope = 200, (0, U32_MAX), Reloaded, "6087h, P1-36 in ms from 0 to the rated torque; 0 is at once.",
        [object(0x2124, 0, I16, "P1-36 slope time in ms"), object(0x6087, 0, U32, "Torque slope")];
    GearNumerator = 1, (1, U32_MAX), Reloaded, "6093h:1, P1-44.",
        [object(0x212C, 0, I32, "P1-44 gear numerator"), object(0x6093, 1, U32, "Numerator")];
    GearDenominator = 1, (1, U32_MAX), Reloaded, "6093h:2, P1-45.",
        [object(0x212D, 0, I32, "P1-45 gear denominator"), object(0x6093, 2, U32, "Feed constant")];
    HomingMethod = 0, (0, 35), Stored, "6098h.",
        [object(0x6098, 0, I8, "Homing method")];
    HomingSpeedSwitch = 100, (1, 20_000), Stored, "6099h:1 in rpm (half) or 0.1 rpm (full).",
        [
            object(0x6099, 1, U32, "Speed for switch").within(&[(1, 2000)]).only(Half),
            object(0x6099, 1, U32, "Speed for switch").only(Full),
        ];
    HomingSpeedZero = 20, (1, 5000), Stored, "6099h:2 in rpm (half) or 0.1 rpm (full).",
        [
            object(0x6099, 2, U32, "Speed for zero").within(&[(1, 500)]).only(Half),
            object(0x6099, 2, U32, "Speed for zero").only(Full),
        ];
    HomingAcceleration = 100, (0, U32_MAX), Stored, "609Ah in ms from 0 to 3000 rpm; 0 is at once.",
        [object(0x609A, 0, U32, "Homing acceleration")];
    PositionOffset = 0, I32_RANGE, Volatile, "60B0h, without effect.",
        [object(0x60B0, 0, I32, "Position offset")];
    VelocityOffset = 0, I32_RANGE, Volatile, "60B1h, without effect.",
        [object(0x60B1, 0, I32, "Velocity offset")];
    TorqueOffset = 0, I16_RANGE, Volatile, "60B2h, without effect.",
        [object(0x60B2, 0, I16, "Torque offset")];
    InterpolationSubMode = 0, (-2, 0), Stored, "60C0h.",
        [
            object(0x60C0, 0, I16, "Interpolation sub mode select").only(Half),
            object(0x60C0, 0, I16, "Interpolation sub mode select").within(&[(-1, 0)]).only(Full),
        ];
    InterpolationPosition = 0, I32_RANGE, Volatile, "60C1h: the next position in PUU.",
        [
            object(0x60C1, 1, U16, "Position, low word").form(LowWord).only(Half),
            object(0x60C1, 2, U16, "Position, high word").form(HighWord).only(Half),
            object(0x60C1, 1, I32, "Position").only(Full),
        ];
    InterpolationDifference = 0, I16_RANGE, Volatile, "60C1h: its symmetrical difference in PUU per cycle.",
        [
            object(0x60C1, 3, I16, "Symmetrical difference").only(Half),
            object(0x60C1, 2, I16, "Symmetrical difference").only(Full),
        ];
    CyclePeriod = 0, (0, U32_MAX), Stored, "1006h in us.",
        [object(0x1006, 0, U32, "Communication cycle period").unmapped()];
    CycleUnits = 1, (1, 20), Stored, "60C2h:1.",
        [object(0x60C2, 1, U8, "Time units")];
    CycleIndex = -3, (-128, 63), Stored, "60C2h:2: the exponent of ten.",
        [object(0x60C2, 2, I8, "Time index")];
    MaxAcceleration = 200, (0, U32_MAX), Stored, "60C5h in ms from 0 to 3000 rpm, as all ramps: 6083h is no steeper.",
        [object(0x60C5, 0, U32, "Max acceleration")];
    MaxDeceleration = 200, (0, U32_MAX), Stored, "60C6h in ms from 3000 rpm to 0: 6084h is no steeper.",
        [object(0x60C6, 0, U32, "Max deceleration")];
    PositioningOption = 0, (0, U16_MAX), Stored, "60F2h: bits 0 and 1 say what a relative target counts from.",
        [object(0x60F2, 0, U16, "Positioning option code")];
    TargetVelocity = 0, I32_RANGE, Volatile, "60FFh in 0.1 rpm.",
        [object(0x60FF, 0, I32, "Target velocity")];
    ErrorBehaviour = 0, (0, 2), Stored, "1029h:1.",
        [object(0x1029, 1, U8, "Communication error").unmapped()];
}

/// A digit of a parameter, X is the lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Digit {
    /// Bits 3..0.
    X,
    /// Bits 7..4.
    Y,
    /// Bits 11..8.
    Z,
}

impl Digit {
    /// It in a value.
    pub(crate) const fn of(self, value: i64) -> u8 {
        let [low, high, ..] = value.to_le_bytes();
        match self {
            Self::X => low & 0xF,
            Self::Y => low >> 4,
            Self::Z => high & 0xF,
        }
    }
}

/// All values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    values: [i64; COUNT],
    stored: [i32; stored::COUNT],
}

impl Settings {
    /// As delivered.
    pub(crate) fn new() -> Self {
        let mut settings = Self { values: [0; COUNT], stored: [0; stored::COUNT] };
        for &setting in Setting::ALL {
            settings.set(setting, setting.default());
        }
        settings
    }

    /// The value of a setting.
    pub(crate) fn of(&self, setting: Setting) -> i64 {
        self.values.get(setting as usize).copied().unwrap_or_default()
    }

    /// Sets a value; one outside its range becomes the nearest inside.
    pub(crate) fn set(&mut self, setting: Setting, value: i64) {
        let (low, high) = setting.range();
        if let Some(place) = self.values.get_mut(setting as usize) {
            *place = value.clamp(low, high);
        }
    }

    /// The value of a parameter without effect.
    pub(crate) fn stored(&self, place: usize) -> i32 {
        self.stored.get(place).copied().unwrap_or_default()
    }

    pub(super) fn set_stored(&mut self, place: usize, value: i32) {
        if let Some(stored) = self.stored.get_mut(place) {
            *stored = value;
        }
    }

    /// P2-10 to P2-22: 0.
    pub(super) fn forget_inputs_and_outputs(&mut self) {
        for place in (0x220A..=0x2216).filter_map(|index| stored::place((index, 0))) {
            self.set_stored(place, 0);
        }
    }

    /// A digit of a value.
    pub(crate) fn digit(&self, setting: Setting, digit: Digit) -> u8 {
        digit.of(self.of(setting))
    }

    /// Values as they are after a start, from those that are kept.
    pub(super) fn start(&mut self, kept: &Self) {
        self.stored = kept.stored;
        let keeps_all = kept.digit(Setting::QuickStopOptions, Digit::Z) == 1;
        for &setting in Setting::ALL {
            let value = match setting.keeping() {
                Keeping::Stored | Keeping::Address => kept.of(setting),
                Keeping::Reloaded if keeps_all => kept.of(setting),
                Keeping::Volatile | Keeping::Reloaded => setting.default(),
            };
            self.set(setting, value);
        }
    }

    /// Takes over what can be stored.
    pub(super) fn keep(&mut self, values: &Self) {
        self.stored = values.stored;
        for &setting in Setting::ALL {
            match setting.keeping() {
                Keeping::Stored | Keeping::Reloaded | Keeping::Address => {
                    self.set(setting, values.of(setting))
                }
                Keeping::Volatile => {}
            }
        }
    }

    /// Brings the defaults back.
    pub(super) fn restore(&mut self) {
        self.stored = [0; stored::COUNT];
        for &setting in Setting::ALL {
            match setting.keeping() {
                Keeping::Stored | Keeping::Reloaded | Keeping::Volatile => {
                    self.set(setting, setting.default())
                }
                Keeping::Address => {}
            }
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_in_their_range() {
        for &setting in Setting::ALL {
            let (low, high) = setting.range();
            assert!((low..=high).contains(&setting.default()), "{setting:?}");
        }
    }

    #[test]
    fn digit_z_of_p3_12_decides_whether_the_objects_of_canopen_are_reloaded() {
        for (word, expected) in [(0x000, 200), (0x100, 777)] {
            let mut kept = Settings::new();
            kept.set(Setting::QuickStopOptions, word);
            kept.set(Setting::Acceleration, 777);
            kept.set(Setting::ProfileVelocity, 555);
            let mut settings = Settings::new();
            settings.start(&kept);
            assert_eq!(settings.of(Setting::Acceleration), expected);
            assert_eq!(settings.of(Setting::ProfileVelocity), 555);
        }
    }
}
