//! Every value that can be set, as data. One value has one place, whatever names it has on a bus or on the keypad.

use super::plant::Motor;

/// What of a value survives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Keeping {
    /// Nothing.
    Volatile,
    /// Power-off, once stored.
    Stored,
    /// As stored; and with P3-12.Z = 0 its default comes back with each start.
    Reloaded,
    /// Power-off, once stored; restoring the defaults leaves it, as the drive would leave its network (keypad).
    Address,
}

/// Declares every value once: name, default, lowest, highest, keeping, meaning.
macro_rules! settings {
    ($($name:ident = $default:expr, $low:expr, $high:expr, $keeping:ident, $doc:literal;)*) => {
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
                match self { $(Self::$name => ($low, $high),)* }
            }

            /// What of it survives.
            pub(crate) const fn keeping(self) -> Keeping {
                match self { $(Self::$name => Keeping::$keeping,)* }
            }
        }

        const COUNT: usize = [$(Setting::$name),*].len();
    };
}

const U16: i64 = u16::MAX as i64;
const U32: i64 = u32::MAX as i64;
const I32: (i64, i64) = (i32::MIN as i64, i32::MAX as i64);
const I16: (i64, i64) = (i16::MIN as i64, i16::MAX as i64);

settings! {
    ControlMode = 0x0C, 0, 0x110F, Address, "P1-01: digits B A are the mode, 0Bh CANopen half, 0Ch full.";
    NodeNumber = 0x7F, 1, 0x7F, Address, "P3-00.";
    Rates = 0x0203, 0, 0x0405, Address, "P3-01: digit Z is the rate of CAN.";
    StopMode = 0x10, I16.0, I16.1, Reloaded, "P1-32: digit Y = 0 dynamic brake, 1 none (605Bh = -1, 0).";
    MaxMotorSpeed = Motor::MAX_RPM, 0, U32, Stored, "6080h, P1-55 in rpm.";
    SpecialWrite = 0, I16.0, I16.1, Volatile, "P2-08.";
    SyncAdjustment = 0x5055, I16.0, I16.1, Stored, "P3-09: digits E range, T target, D dead zone, M correction.";
    CanEnable = 0, I16.0, I16.1, Stored, "P3-10: digit Y = 1 servo off on errors of the bus.";
    PdoToEeprom = 0, I16.0, I16.1, Stored, "P3-11: models M and F only.";
    QuickStopOptions = 0, 0, 0x0111, Stored, "P3-12: digits Z, Y, X.";
    FaultReaction = 2, 0, 2, Stored, "605Eh.";
    Mode = 0, 0, 7, Stored, "6060h.";
    FollowingErrorWindow = 3_840_000, 0, U32, Reloaded, "6065h, P2-35 in PUU.";
    PositionWindow = 100, 0, U32, Stored, "6067h in PUU.";
    PositionWindowTime = 0, 0, U16, Stored, "6068h in ms.";
    VelocityWindow = 100, 0, 3000, Reloaded, "606Dh in 0.1 rpm, P1-47 in rpm.";
    VelocityWindowTime = 0, 0, U16, Reloaded, "606Eh, P1-49 in ms.";
    ZeroSpeed = 100, 0, 2000, Reloaded, "606Fh, P1-38 in 0.1 rpm.";
    TargetTorque = 0, -3000, 3000, Volatile, "6071h in 0.1 % of the rated torque.";
    TargetPosition = 0, I32.0, I32.1, Volatile, "607Ah in PUU.";
    HomeOffset = 0, I32.0, I32.1, Stored, "607Ch in PUU.";
    ReverseSoftLimit = I32.0, I32.0, I32.1, Stored, "607Dh:1 in PUU.";
    ForwardSoftLimit = I32.1, I32.0, I32.1, Stored, "607Dh:2 in PUU.";
    MaxProfileVelocity = Motor::MAX_RPM * 10, 0, U32, Stored, "607Fh in 0.1 rpm.";
    ProfileVelocity = 10_000, 0, U32, Stored, "6081h in PUU/s.";
    Acceleration = 200, 1, U32, Reloaded, "6083h, P1-34 in ms from 0 to 3000 rpm.";
    Deceleration = 200, 1, U32, Reloaded, "6084h, P1-35 in ms from 3000 rpm to 0.";
    QuickStopDeceleration = 0, 0, U32, Stored, "6085h in ms from 3000 rpm to 0; 0 is at once.";
    ProfileType = 0, I16.0, I16.1, Stored, "6086h, without effect.";
    TorqueSlope = 200, 0, U32, Reloaded, "6087h, P1-36 in ms from 0 to the rated torque; 0 is at once.";
    GearNumerator = 1, 1, U32, Reloaded, "6093h:1, P1-44.";
    GearDenominator = 1, 1, U32, Reloaded, "6093h:2, P1-45.";
    HomingMethod = 0, 0, 35, Stored, "6098h.";
    HomingSpeedSwitch = 100, 1, 20_000, Stored, "6099h:1 in rpm (half) or 0.1 rpm (full).";
    HomingSpeedZero = 20, 1, 5000, Stored, "6099h:2 in rpm (half) or 0.1 rpm (full).";
    HomingAcceleration = 100, 0, U32, Stored, "609Ah in ms from 0 to 3000 rpm; 0 is at once.";
    PositionOffset = 0, I32.0, I32.1, Volatile, "60B0h, without effect.";
    VelocityOffset = 0, I32.0, I32.1, Volatile, "60B1h, without effect.";
    TorqueOffset = 0, I16.0, I16.1, Volatile, "60B2h, without effect.";
    InterpolationSubMode = 0, -2, 0, Stored, "60C0h.";
    InterpolationPosition = 0, I32.0, I32.1, Volatile, "60C1h: the next position in PUU.";
    InterpolationDifference = 0, I16.0, I16.1, Volatile, "60C1h: its symmetrical difference in PUU per cycle.";
    CyclePeriod = 0, 0, U32, Stored, "1006h in us.";
    CycleUnits = 1, 1, 20, Stored, "60C2h:1.";
    CycleIndex = -3, -128, 63, Stored, "60C2h:2: the exponent of ten.";
    MaxAcceleration = 200, 0, U32, Stored, "60C5h, without effect: no unit is given.";
    MaxDeceleration = 200, 0, U32, Stored, "60C6h, without effect: no unit is given.";
    PositioningOption = 0, 0, U16, Stored, "60F2h, without effect.";
    TargetVelocity = 0, I32.0, I32.1, Volatile, "60FFh in 0.1 rpm.";
    ErrorBehaviour = 0, 0, 2, Stored, "1029h:1.";
}

/// A digit of a parameter, X is the lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Digit {
    /// Bits 3..0.
    X,
    /// Bits 7..4.
    Y,
    /// Bits 11..8.
    Z,
}

/// All values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    values: [i64; COUNT],
}

impl Settings {
    /// As delivered.
    pub(crate) fn new() -> Self {
        let mut settings = Self { values: [0; COUNT] };
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

    /// A digit of a value.
    pub(crate) fn digit(&self, setting: Setting, digit: Digit) -> u8 {
        let [low, high, ..] = self.of(setting).to_le_bytes();
        match digit {
            Digit::X => low & 0xF,
            Digit::Y => low >> 4,
            Digit::Z => high & 0xF,
        }
    }

    /// Values as they are after a start, from those that are kept.
    pub(super) fn start(&mut self, kept: &Self) {
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
