//! What the drive is set to: each setting once, with its parameter number, unit, limits and first value.

macro_rules! settings {
    ($($(#[$doc:meta])* $setting:ident = $pnu:literal: $name:literal, $unit:literal, $kind:ident, $low:literal, $high:literal, $first:literal;)*) => {
        /// A setting.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Setting {
            $(
                #[doc = concat!($name, ".")]
                $(#[doc = ""] #[$doc])*
                $setting,
            )*
        }

        impl Setting {
            /// Every setting.
            pub const ALL: &'static [Self] = &[$(Self::$setting),*];

            /// The number of its parameter.
            pub const fn pnu(self) -> u16 {
                match self { $(Self::$setting => $pnu,)* }
            }

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$setting => $name,)* }
            }

            /// Its unit; empty for a number.
            pub(crate) const fn unit(self) -> &'static str {
                match self { $(Self::$setting => $unit,)* }
            }

            /// What its octets are.
            pub const fn kind(self) -> SettingKind {
                match self { $(Self::$setting => SettingKind::$kind,)* }
            }

            /// The least and the greatest value.
            pub const fn limits(self) -> (f64, f64) {
                match self { $(Self::$setting => ($low, $high),)* }
            }

            /// The value of a new drive.
            pub const fn first(self) -> f64 {
                match self { $(Self::$setting => $first,)* }
            }
        }
    };
}

/// What the octets of a setting are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingKind {
    /// IEEE 754, 32 bits.
    Float,
    /// 16 bits.
    Word,
    /// 32 bits with sign.
    Signed,
    /// 32 bits.
    Double,
}

settings! {
    /// Torque of the motor at `ReferenceCurrent`.
    ReferenceTorque = 2003: "Reference torque", "Nm", Float, 0.01, 1e6, 1.27;
    /// 4000h of a speed, 40000000h of one in two words.
    ReferenceSpeed = 2000: "Reference speed", "rpm", Float, 6.0, 210_000.0, 3000.0;
    ReferenceVoltage = 2001: "Reference voltage", "V", Float, 10.0, 100_000.0, 1000.0;
    ReferenceCurrent = 2002: "Reference current", "A", Float, 0.1, 100_000.0, 2.6;
    ReferencePower = 2004: "Reference power", "kW", Float, 0.01, 100_000.0, 0.4;
    ReferenceAngle = 2005: "Reference angle", "°", Float, 90.0, 180.0, 90.0;
    ReferenceTemperature = 2006: "Reference temperature", "°C", Float, 50.0, 300.0, 100.0;
    Jog1 = 1058: "Jog 1 speed", "rpm", Float, -210_000.0, 210_000.0, 150.0;
    Jog2 = 1059: "Jog 2 speed", "rpm", Float, -210_000.0, 210_000.0, -150.0;
    MaxSpeed = 1082: "Maximum speed", "rpm", Float, 0.0, 210_000.0, 4500.0;
    /// From standstill to the reference speed.
    RampUp = 1120: "Ramp-up time", "s", Float, 0.0, 999_999.0, 1.0;
    /// From the reference speed to standstill, with OFF1 too.
    RampDown = 1121: "Ramp-down time", "s", Float, 0.0, 999_999.0, 1.0;
    /// From the reference speed to standstill with OFF3.
    QuickStop = 1135: "OFF3 ramp-down time", "s", Float, 0.0, 600.0, 0.2;
    /// From it on bit 10 of ZSW1 is set.
    ComparisonSpeed = 2141: "Comparison speed", "rpm", Float, 0.0, 210_000.0, 2990.0;
    /// Within it bit 8 of ZSW1 is set.
    ToleratedDeviation = 2163: "Tolerated deviation of the speed", "rpm", Float, 0.0, 210_000.0, 90.0;
    /// Up to it bit 3 of MELDW is set.
    SpeedThreshold2 = 2155: "Speed threshold 2", "rpm", Float, 0.0, 210_000.0, 900.0;
    /// Below it the shaft stands: bit 2 of MELDW, bit 13 of ZSW1 of a positioning drive.
    SpeedThreshold3 = 2161: "Speed threshold 3", "rpm", Float, 0.0, 210_000.0, 5.0;
    /// Positions are counted in LU.
    LuPerRevolution = 2506: "LU per revolution", "LU", Double, 1.0, 2_147_483_647.0, 10_000.0;
    /// Shaft and target agree within it.
    Window = 2544: "Positioning window", "LU", Double, 0.0, 2_147_483_647.0, 40.0;
    /// More is a fault; 0: it is not watched.
    FollowingError = 2546: "Most following error", "LU", Double, 0.0, 2_147_483_647.0, 1000.0;
    /// Up to it bit 8 of POS_ZSW2 is set.
    CamPosition1 = 2547: "Cam position 1", "LU", Signed, -2_147_482_648.0, 2_147_482_647.0, 0.0;
    /// Up to it bit 9 of POS_ZSW2 is set.
    CamPosition2 = 2548: "Cam position 2", "LU", Signed, -2_147_482_648.0, 2_147_482_647.0, 0.0;
    /// 1: a limit switch stops the axis.
    SwitchesOn = 2568: "Limit switches on", "", Word, 0.0, 1.0, 0.0;
    MaxVelocity = 2571: "Maximum velocity", "1000 LU/min", Double, 1.0, 40_000_000.0, 30_000.0;
    MaxAcceleration = 2572: "Maximum acceleration", "1000 LU/s²", Double, 1.0, 2_000_000.0, 1000.0;
    MaxDeceleration = 2573: "Maximum deceleration", "1000 LU/s²", Double, 1.0, 2_000_000.0, 1000.0;
    LimitMinus = 2580: "Software limit minus", "LU", Signed, -2_147_482_648.0, 2_147_482_647.0, -2_147_482_648.0;
    LimitPlus = 2581: "Software limit plus", "LU", Signed, -2_147_482_648.0, 2_147_482_647.0, 2_147_482_647.0;
    /// 1: the software limits hold once the position has a reference.
    LimitsOn = 2582: "Software limits on", "", Word, 0.0, 1.0, 0.0;
    JogVelocity1 = 2585: "Jog 1 velocity", "1000 LU/min", Signed, -40_000_000.0, 40_000_000.0, -300.0;
    JogVelocity2 = 2586: "Jog 2 velocity", "1000 LU/min", Signed, -40_000_000.0, 40_000_000.0, 300.0;
    JogWay1 = 2587: "Jog 1 way", "LU", Double, 0.0, 2_147_482_647.0, 1000.0;
    JogWay2 = 2588: "Jog 2 way", "LU", Double, 0.0, 2_147_482_647.0, 1000.0;
    ReferencePosition = 2599: "Reference position", "LU", Signed, -2_147_482_648.0, 2_147_482_647.0, 0.0;
    /// Flying referencing corrects no less.
    InnerWindow = 2601: "Inner window", "LU", Double, 0.0, 2_147_482_647.0, 0.0;
    /// Flying referencing corrects no more; 0: anything.
    OuterWindow = 2602: "Outer window", "LU", Double, 0.0, 2_147_482_647.0, 0.0;
    /// 1: referencing begins backward.
    HomingBackward = 2604: "Referencing backward", "", Word, 0.0, 1.0, 0.0;
    HomingVelocity = 2605: "Velocity to the reference cam", "1000 LU/min", Double, 1.0, 40_000_000.0, 5000.0;
    /// 0: referencing looks for the zero mark alone.
    HomingCam = 2607: "Reference cam", "", Word, 0.0, 1.0, 1.0;
    ZeroMarkVelocity = 2608: "Velocity to the zero mark", "1000 LU/min", Double, 1.0, 40_000_000.0, 300.0;
    /// 65535: the sign of life is not watched.
    SignOfLifeFailures = 925: "Sign-of-life failures tolerated", "", Word, 0.0, 65535.0, 65535.0;
}

impl Setting {
    const fn place(self) -> usize {
        self as usize
    }

    /// Whether it can be changed at standstill only: all that is counted in it would jump.
    pub(crate) const fn wants_standstill(self) -> bool {
        matches!(self, Self::ReferenceSpeed | Self::LuPerRevolution)
    }
}

/// The value of each setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings([f64; Setting::ALL.len()]);

impl Default for Settings {
    fn default() -> Self {
        let mut values = [0.0; Setting::ALL.len()];
        for (value, setting) in values.iter_mut().zip(Setting::ALL) {
            *value = setting.first();
        }
        Self(values)
    }
}

impl Settings {
    /// The value of one.
    pub fn of(&self, setting: Setting) -> f64 {
        self.0.get(setting.place()).copied().unwrap_or_default()
    }

    /// Sets one. `false`: the value is outside of its limits, and nothing is changed.
    pub fn set(&mut self, setting: Setting, value: f64) -> bool {
        let (low, high) = setting.limits();
        let fits = (low..=high).contains(&value);
        if let (true, Some(place)) = (fits, self.0.get_mut(setting.place())) {
            *place = value;
        }
        fits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_setting_has_its_own_number_and_a_first_value_within_its_limits() {
        for (at, setting) in Setting::ALL.iter().enumerate() {
            let (low, high) = setting.limits();
            assert!((low..=high).contains(&setting.first()), "{setting:?}");
            assert!(Setting::ALL[..at].iter().all(|other| other.pnu() != setting.pnu()), "{setting:?}");
        }
        let mut settings = Settings::default();
        assert!(settings.set(Setting::RampUp, 2.5) && !settings.set(Setting::RampUp, -1.0));
        assert!(!settings.set(Setting::RampUp, f64::NAN));
        assert_eq!(settings.of(Setting::RampUp), 2.5);
    }
}
