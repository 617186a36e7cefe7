//! Which value of the drive an object is: the second half of the parameter mapping rule of the guide.

use crate::can_bus::canopen::Address;
use crate::devices::asda_a2::{Digit, Level, Setting, Settings};

/// How the value of an object is made of a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// It is the setting.
    Whole(Setting),
    /// It is a tenth of the setting: rpm of 0.1 rpm.
    Tenth(Setting),
    /// 605Bh: 0 and -1 for the digit Y = 1 and 0 of P1-32.
    Shutdown,
    /// P3-01: only digit Z can be written (CN-201).
    Rates,
    /// 60C1h:1 in half CANopen.
    LowWord(Setting),
    /// 60C1h:2 in half CANopen.
    HighWord(Setting),
}

impl Link {
    /// The link of an object.
    #[rustfmt::skip]
    pub(super) const fn of(level: Level, at: Address) -> Option<Self> {
        use Setting as S;
        Some(match (at.pair(), level) {
            ((0x1006, 0), _) => Self::Whole(S::CyclePeriod),
            ((0x1029, 1), _) => Self::Whole(S::ErrorBehaviour),
            ((0x2101, 0), _) => Self::Whole(S::ControlMode),
            ((0x2120, 0), _) => Self::Whole(S::StopMode),
            ((0x2122, 0) | (0x6083, 0), _) => Self::Whole(S::Acceleration),
            // CN-202.
            ((0x2123, 0) | (0x6084, 0), _) => Self::Whole(S::Deceleration),
            ((0x2124, 0) | (0x6087, 0), _) => Self::Whole(S::TorqueSlope),
            ((0x2126, 0) | (0x606F, 0), _) => Self::Whole(S::ZeroSpeed),
            ((0x212C, 0) | (0x6093, 1), _) => Self::Whole(S::GearNumerator),
            ((0x212D, 0) | (0x6093, 2), _) => Self::Whole(S::GearDenominator),
            ((0x212F, 0), _) => Self::Tenth(S::VelocityWindow),
            ((0x2131, 0) | (0x606E, 0), _) => Self::Whole(S::VelocityWindowTime),
            ((0x2137, 0) | (0x6080, 0), _) => Self::Whole(S::MaxMotorSpeed),
            ((0x2208, 0), _) => Self::Whole(S::SpecialWrite),
            ((0x2223, 0) | (0x6065, 0), _) => Self::Whole(S::FollowingErrorWindow),
            ((0x2300, 0), _) => Self::Whole(S::NodeNumber),
            ((0x2301, 0), _) => Self::Rates,
            ((0x2309, 0), _) => Self::Whole(S::SyncAdjustment),
            ((0x230A, 0), _) => Self::Whole(S::CanEnable),
            ((0x230B, 0), _) => Self::Whole(S::PdoToEeprom),
            ((0x230C, 0), _) => Self::Whole(S::QuickStopOptions),
            ((0x605B, 0), _) => Self::Shutdown,
            ((0x605E, 0), _) => Self::Whole(S::FaultReaction),
            ((0x6060, 0), _) => Self::Whole(S::Mode),
            ((0x6067, 0), _) => Self::Whole(S::PositionWindow),
            ((0x6068, 0), _) => Self::Whole(S::PositionWindowTime),
            ((0x606D, 0), _) => Self::Whole(S::VelocityWindow),
            ((0x6071, 0), _) => Self::Whole(S::TargetTorque),
            ((0x607A, 0), _) => Self::Whole(S::TargetPosition),
            ((0x607C, 0), _) => Self::Whole(S::HomeOffset),
            ((0x607D, 1), _) => Self::Whole(S::ReverseSoftLimit),
            ((0x607D, 2), _) => Self::Whole(S::ForwardSoftLimit),
            ((0x607F, 0), _) => Self::Whole(S::MaxProfileVelocity),
            ((0x6081, 0), _) => Self::Whole(S::ProfileVelocity),
            ((0x6085, 0), _) => Self::Whole(S::QuickStopDeceleration),
            ((0x6086, 0), _) => Self::Whole(S::ProfileType),
            ((0x6098, 0), _) => Self::Whole(S::HomingMethod),
            ((0x6099, 1), _) => Self::Whole(S::HomingSpeedSwitch),
            ((0x6099, 2), _) => Self::Whole(S::HomingSpeedZero),
            ((0x609A, 0), _) => Self::Whole(S::HomingAcceleration),
            ((0x60B0, 0), _) => Self::Whole(S::PositionOffset),
            ((0x60B1, 0), _) => Self::Whole(S::VelocityOffset),
            ((0x60B2, 0), _) => Self::Whole(S::TorqueOffset),
            ((0x60C0, 0), _) => Self::Whole(S::InterpolationSubMode),
            ((0x60C1, 1), Level::Half) => Self::LowWord(S::InterpolationPosition),
            ((0x60C1, 2), Level::Half) => Self::HighWord(S::InterpolationPosition),
            ((0x60C1, 1), Level::Full) => Self::Whole(S::InterpolationPosition),
            ((0x60C1, 2), Level::Full) | ((0x60C1, 3), Level::Half) => Self::Whole(S::InterpolationDifference),
            ((0x60C2, 1), _) => Self::Whole(S::CycleUnits),
            ((0x60C2, 2), _) => Self::Whole(S::CycleIndex),
            ((0x60C5, 0), _) => Self::Whole(S::MaxAcceleration),
            ((0x60C6, 0), _) => Self::Whole(S::MaxDeceleration),
            ((0x60F2, 0), _) => Self::Whole(S::PositioningOption),
            ((0x60FF, 0), _) => Self::Whole(S::TargetVelocity),
            ((0.., 0..), Level::Half | Level::Full) => return None,
        })
    }

    /// The setting behind it.
    pub(super) const fn setting(self) -> Setting {
        match self {
            Self::Whole(setting)
            | Self::Tenth(setting)
            | Self::LowWord(setting)
            | Self::HighWord(setting) => setting,
            Self::Shutdown => Setting::StopMode,
            Self::Rates => Setting::Rates,
        }
    }

    /// The value of the object where the setting is `value`.
    pub(super) const fn of_setting(self, value: i64) -> i64 {
        let [first, second, third, fourth, ..] = value.to_le_bytes();
        match self {
            Self::Whole(_) | Self::Rates => value,
            Self::Tenth(_) => value / 10,
            Self::Shutdown => (value >> 4 & 0xF != 0) as i64 - 1,
            Self::LowWord(_) => u16::from_le_bytes([first, second]) as i64,
            Self::HighWord(_) => u16::from_le_bytes([third, fourth]) as i64,
        }
    }

    /// The value of the object.
    pub(super) fn read(self, settings: &Settings) -> i64 {
        self.of_setting(settings.of(self.setting()))
    }

    /// The setting after `value` was written to the object.
    pub(super) fn write(self, settings: &Settings, value: i64) -> i64 {
        let before = settings.of(self.setting());
        match self {
            Self::Whole(_) => value,
            Self::Tenth(_) => value * 10,
            Self::Shutdown => before & !0xF0 | i64::from(value == 0) << 4,
            Self::Rates => before & !0xF00 | value & 0xF00,
            Self::LowWord(_) => before & !0xFFFF | value,
            Self::HighWord(_) => {
                let [low, high, ..] = before.to_le_bytes();
                let [third, fourth, ..] = value.to_le_bytes();
                i32::from_le_bytes([low, high, third, fourth]).into()
            }
        }
    }

    /// What [`accepts`](Self::accepts) looks at, as the end of "1 was written, but".
    pub(super) const fn needs(self) -> Option<&'static str> {
        match self {
            Self::Rates => Some("digit Z of P3-01, the bit rate, must be 0 to 4"),
            Self::Whole(Setting::QuickStopOptions) => Some("digits X, Y and Z of P3-12 must be 0 or 1"),
            Self::Whole(_) | Self::Tenth(_) | Self::Shutdown | Self::LowWord(_) | Self::HighWord(_) => None,
        }
    }

    /// Whether the value can be written: P3-01 has only five rates of CAN.
    pub(super) fn accepts(self, settings: &Settings, value: i64) -> bool {
        let after = self.write(settings, value);
        match self {
            Self::Rates => after >> 8 & 0xF <= i64::from(MAX_RATE),
            Self::Whole(setting) if matches!(setting, Setting::QuickStopOptions) => {
                [Digit::X, Digit::Y, Digit::Z].into_iter().all(|digit| {
                    let mut probe = settings.clone();
                    probe.set(setting, value);
                    probe.digit(setting, digit) <= 1
                })
            }
            Self::Whole(_) | Self::Tenth(_) | Self::Shutdown | Self::LowWord(_) | Self::HighWord(_) => true,
        }
    }
}

/// P3-01.Z of 1 Mbit/s.
const MAX_RATE: u8 = 4;
