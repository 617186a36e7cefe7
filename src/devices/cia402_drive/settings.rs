//! The objects of the profile: what a master sets, and what a drive tells.

/// `Name = index, sub-index, what a drive without the object has, what it is;`
macro_rules! settings {
    ($($name:ident = $index:literal, $sub:literal, $default:expr, $doc:literal;)*) => {
        /// What a master sets.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Setting {
            $(#[doc = $doc] $name,)*
        }

        impl Setting {
            const ALL: &'static [Self] = &[$(Self::$name),*];

            /// That of an object.
            pub(crate) const fn of(index: u16, sub: u8) -> Option<Self> {
                match (index, sub) {
                    $(($index, $sub) => Some(Self::$name),)*
                    (_, _) => None,
                }
            }

            /// What a drive without the object has.
            const fn default(self) -> i64 {
                match self { $(Self::$name => $default,)* }
            }
        }
    };
}

/// `Name = index, sub-index, what it is;`
macro_rules! actuals {
    ($($name:ident = $index:literal, $sub:literal, $doc:literal;)*) => {
        /// What a drive tells.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Actual {
            $(#[doc = $doc] $name,)*
        }

        impl Actual {
            /// That of an object.
            pub(crate) const fn of(index: u16, sub: u8) -> Option<Self> {
                match (index, sub) {
                    $(($index, $sub) => Some(Self::$name),)*
                    (_, _) => None,
                }
            }
        }
    };
}

/// Of windows: nothing is supervised.
pub(super) const OFF: i64 = 0xFFFF_FFFF;

settings! {
    AbortConnection = 0x6007, 0, 1, "Abort connection option code.";
    Controlword = 0x6040, 0, 0, "Controlword.";
    VlTarget = 0x6042, 0, 0, "vl: target velocity, rpm.";
    VlMin = 0x6046, 1, 0, "vl: least amount of the velocity, rpm.";
    VlMax = 0x6046, 2, 0, "vl: largest amount, rpm; 0: that of the motor.";
    VlAccelerationSpeed = 0x6048, 1, 0, "vl: acceleration, rpm.";
    VlAccelerationTime = 0x6048, 2, 0, "vl: in so many seconds.";
    VlDecelerationSpeed = 0x6049, 1, 0, "vl: deceleration, rpm.";
    VlDecelerationTime = 0x6049, 2, 0, "vl: in so many seconds.";
    VlQuickStopSpeed = 0x604A, 1, 0, "vl: quick stop, rpm.";
    VlQuickStopTime = 0x604A, 2, 0, "vl: in so many seconds.";
    VlNumerator = 0x604C, 1, 1, "vl: rpm in a unit; 0: 1.";
    VlDenominator = 0x604C, 2, 1, "vl: divides them; 0: 1.";
    QuickStopOption = 0x605A, 0, 2, "Quick stop option code.";
    ShutdownOption = 0x605B, 0, 0, "Shutdown option code.";
    DisableOption = 0x605C, 0, 1, "Disable operation option code.";
    HaltOption = 0x605D, 0, 1, "Halt option code.";
    FaultOption = 0x605E, 0, 2, "Fault reaction option code.";
    Mode = 0x6060, 0, 0, "Modes of operation.";
    FollowingWindow = 0x6065, 0, OFF, "Following error window; 0: none.";
    FollowingTime = 0x6066, 0, 0, "Following error time out, ms.";
    PositionWindow = 0x6067, 0, OFF, "Position window.";
    PositionWindowTime = 0x6068, 0, 0, "Position window time, ms.";
    VelocityWindow = 0x606D, 0, 0, "Velocity window; 0: 5 rpm.";
    VelocityWindowTime = 0x606E, 0, 0, "Velocity window time, ms.";
    VelocityThreshold = 0x606F, 0, 0, "Below it the speed is zero; 0: 5 rpm.";
    VelocityThresholdTime = 0x6070, 0, 0, "For so long, ms.";
    TargetTorque = 0x6071, 0, 0, "Target torque, thousandths of the rated one.";
    MaxTorque = 0x6072, 0, 0, "Max torque; 0: that of the motor.";
    TargetPosition = 0x607A, 0, 0, "Target position.";
    RangeMin = 0x607B, 1, 0, "Position range limit; both the same: none.";
    RangeMax = 0x607B, 2, 0, "Position range limit: beyond it positions begin anew.";
    HomeOffset = 0x607C, 0, 0, "Home offset.";
    LimitMin = 0x607D, 1, 0, "Software position limit; both 0: none.";
    LimitMax = 0x607D, 2, 0, "Software position limit.";
    Polarity = 0x607E, 0, 0, "Polarity: bit 7 positions, bit 6 velocities.";
    MaxProfileVelocity = 0x607F, 0, 0, "Max profile velocity; 0: that of the motor.";
    MaxMotorSpeed = 0x6080, 0, 0, "Max motor speed, rpm; 0: that of the motor.";
    ProfileVelocity = 0x6081, 0, 0, "Profile velocity; 0: 10 turns in a second.";
    Acceleration = 0x6083, 0, 0, "Profile acceleration; 0: 100 turns in a second squared.";
    Deceleration = 0x6084, 0, 0, "Profile deceleration; 0: as the acceleration.";
    QuickStopDeceleration = 0x6085, 0, 0, "Quick stop deceleration; 0: 500 turns in a second squared.";
    TorqueSlope = 0x6087, 0, 0, "Torque slope, thousandths in a second; 0: at once.";
    EncoderIncrements = 0x608F, 1, 10_000, "Position encoder resolution: increments.";
    EncoderRevolutions = 0x608F, 2, 1, "Position encoder resolution: in so many revolutions of the motor.";
    GearMotor = 0x6091, 1, 1, "Gear ratio: revolutions of the motor.";
    GearShaft = 0x6091, 2, 1, "Gear ratio: revolutions of the shaft.";
    Feed = 0x6092, 1, 0, "Feed constant: units; 0, and 1 in 1 revolution: increments of the encoder.";
    FeedRevolutions = 0x6092, 2, 1, "Feed constant: in so many revolutions of the shaft.";
    PositionNumerator = 0x6093, 1, 0, "Position factor: increments of the encoder in a unit; 0, and 1 in 1: by gear and feed.";
    PositionDivisor = 0x6093, 2, 1, "Position factor: divides them.";
    VelocityNumerator = 0x6096, 1, 1, "Velocity factor; 0: 1.";
    VelocityDivisor = 0x6096, 2, 1, "Velocity factor: divides it; 0: 1.";
    AccelerationNumerator = 0x6097, 1, 1, "Acceleration factor; 0: 1.";
    AccelerationDivisor = 0x6097, 2, 1, "Acceleration factor: divides it; 0: 1.";
    HomingMethod = 0x6098, 0, 0, "Homing method.";
    HomingFast = 0x6099, 1, 0, "Speed to the switch; 0: 2 turns in a second.";
    HomingSlow = 0x6099, 2, 0, "Speed to zero; 0: a tenth of the other one.";
    HomingAcceleration = 0x609A, 0, 0, "Homing acceleration; 0: that of the profile.";
    VelocityUnit = 0x60A9, 0, 0, "Unit of velocities; what is no rpm: positions in a second.";
    VelocityOffset = 0x60B1, 0, 0, "csv: is added to the target velocity.";
    TorqueOffset = 0x60B2, 0, 0, "cst: is added to the target torque.";
    PositionOffset = 0x60B0, 0, 0, "csp: is added to the target position.";
    ProbeFunction = 0x60B8, 0, 0, "Touch probe function.";
    IpTarget = 0x60C1, 1, 0, "ip: the next position.";
    CycleUnits = 0x60C2, 1, 0, "Interpolation time period; 0: as the master sends.";
    CycleExponent = 0x60C2, 2, -3, "Its unit: so many powers of ten of a second.";
    MaxAcceleration = 0x60C5, 0, 0, "Max acceleration; 0: none.";
    MaxDeceleration = 0x60C6, 0, 0, "Max deceleration; 0: none.";
    PositiveTorque = 0x60E0, 0, 0, "Positive torque limit; 0: none.";
    NegativeTorque = 0x60E1, 0, 0, "Negative torque limit; 0: none.";
    PositioningOption = 0x60F2, 0, 0, "What relative positions count from.";
    MaxSlippage = 0x60F8, 0, 0, "pv: largest deviation of the velocity; 0: any.";
    TargetVelocity = 0x60FF, 0, 0, "Target velocity.";
}

actuals! {
    ErrorCode = 0x603F, 0, "Error code.";
    Statusword = 0x6041, 0, "Statusword.";
    VlDemand = 0x6043, 0, "vl: velocity demand, rpm.";
    VlVelocity = 0x6044, 0, "vl: velocity, rpm.";
    ModeDisplay = 0x6061, 0, "Modes of operation display.";
    PositionDemand = 0x6062, 0, "Position demand.";
    PositionInternal = 0x6063, 0, "Position in increments of the encoder.";
    Position = 0x6064, 0, "Position.";
    VelocityDemand = 0x606B, 0, "Velocity demand.";
    Velocity = 0x606C, 0, "Velocity.";
    TorqueDemand = 0x6074, 0, "Torque demand.";
    Torque = 0x6077, 0, "Torque.";
    Current = 0x6078, 0, "Current.";
    ProbeStatus = 0x60B9, 0, "Touch probe status.";
    Probe1Rising = 0x60BA, 0, "Touch probe 1: position at its rising edge.";
    Probe1Falling = 0x60BB, 0, "Touch probe 1: position at its falling edge.";
    Probe2Rising = 0x60BC, 0, "Touch probe 2: position at its rising edge.";
    Probe2Falling = 0x60BD, 0, "Touch probe 2: position at its falling edge.";
    FollowingError = 0x60F4, 0, "Following error.";
    PositionDemandInternal = 0x60FC, 0, "Position demand in increments of the encoder.";
    DigitalInputs = 0x60FD, 0, "Digital inputs.";
    SupportedModes = 0x6502, 0, "Supported drive modes.";
}

const COUNT: usize = Setting::ALL.len();

/// The values of all settings.
#[derive(Clone, Debug)]
pub(super) struct Settings([i64; COUNT]);

impl Settings {
    pub(super) fn new() -> Self {
        let mut values = [0; COUNT];
        for (value, setting) in values.iter_mut().zip(Setting::ALL) {
            *value = setting.default();
        }
        Self(values)
    }

    pub(super) fn of(&self, setting: Setting) -> i64 {
        self.0.get(setting as usize).copied().unwrap_or_default()
    }

    pub(super) fn set(&mut self, setting: Setting, value: i64) {
        if let Some(place) = self.0.get_mut(setting as usize) {
            *place = value;
        }
    }

    /// A number above zero, else what stands for it.
    pub(super) fn above_zero(&self, setting: Setting, otherwise: f64) -> f64 {
        match self.of(setting) {
            ..=0 => otherwise,
            value => value as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_setting_has_a_place_of_its_own_and_begins_with_its_default() {
        let mut settings = Settings::new();
        for (place, setting) in (1000..).zip(Setting::ALL) {
            assert_eq!(settings.of(*setting), setting.default());
            settings.set(*setting, place);
        }
        for (place, setting) in (1000..).zip(Setting::ALL) {
            assert_eq!(settings.of(*setting), place, "{setting:?}");
        }
        assert_eq!(settings.above_zero(Setting::AbortConnection, 7.0), 1000.0);
        settings.set(Setting::AbortConnection, 0);
        assert_eq!(settings.above_zero(Setting::AbortConnection, 7.0), 7.0);
    }

    #[test]
    fn an_object_is_set_or_told() {
        for index in 0x6000..=0x6FFF {
            for sub in 0..=255 {
                assert!(Setting::of(index, sub).is_none() || Actual::of(index, sub).is_none());
            }
        }
        assert_eq!(Setting::of(0x607D, 2), Some(Setting::LimitMax));
        assert_eq!(Actual::of(0x6041, 0), Some(Actual::Statusword));
    }
}
