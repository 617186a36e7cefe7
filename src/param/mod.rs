//! Bus-neutral parameters (interface sketch; the types below are fixed by agreement, bodies to come).

/// Which of the two drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// SIKO AG03 (firmware 3.00 and later).
    Ag03,
    /// SIKO AG03/1 (firmware 1.00 and later).
    Ag03_1,
}

/// Reduction of the internal gear, PNU 961.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gear {
    /// 24:1, up to 200 rpm.
    Ratio24,
    /// 48:1, up to 100 rpm.
    Ratio48,
}

/// A stored parameter of chapter 6 of the manual, in the order of its internal numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "sketch")]
pub enum Parameter {
    ControllerP,
    ControllerI,
    ControllerD,
    APos,
    VPos,
    ARot,
    AInch,
    VInch,
    PosWindow,
    GearNumerator,
    GearDenominator,
    SpindlePitch,
    CalibrationValue,
    Limit1,
    Limit2,
    DeltaInch,
    SenseOfRotation,
    PosType,
    OperatingMode,
    StopModeInch2,
    InposMode,
    LoopLength,
    TorqueDeactivation,
    OffsetInch2,
    DPos,
}

/// What a drive is doing, as far as write permissions depend on it (`ag03.md` 3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteContext {
    /// The shaft or its profile is in motion (travel, inching, braking, coasting).
    pub moving: bool,
    /// A travel job is active or paused.
    pub job_active: bool,
}

/// What a successful write asks the drive to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing beyond the stored value.
    None,
    /// Stored values changed: the drive reads them anew.
    SettingsChanged,
    /// PNU 970 = 4: clear fault buffer and fault counter.
    ClearFaults,
    /// PNU 970 = 5: set the position to the calibration value.
    Calibrate,
}

/// Values that live in the drive and are only read over the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Live {
    /// PNU 918, station address.
    pub address: u8,
    /// PNU 945, fault codes, newest first, 0 = unused.
    pub fault_buffer: [u8; 10],
    /// PNU 952, number of faults.
    pub fault_count: u16,
    /// PNU 1020, system status word SSW.
    pub system_status: u16,
    /// PNU 1027, output stage temperature in 0.1 degC.
    pub temperature: i16,
    /// PNU 1029, motor current in mA.
    pub motor_current: i16,
    /// PNU 1031, general status register.
    pub general_status: u16,
    /// PNU 1036, position in increments or 0.01 mm.
    pub position: i32,
    /// PNU 1040, supply voltage of the output stage in 0.1 V.
    pub output_stage_voltage: u16,
    /// PNU 1041, supply voltage of the control in 0.1 V.
    pub control_voltage: u16,
    /// PNU 1042, battery voltage in 0.01 V.
    pub battery_voltage: u16,
}

/// All stored parameters of one drive.
#[derive(Clone, Debug)]
pub struct Store {
    model: Model,
    gear: Gear,
}

impl Store {
    /// Every parameter at its default.
    pub fn new(model: Model, gear: Gear) -> Self {
        Self { model, gear }
    }
    /// The drive's model.
    pub fn model(&self) -> Model {
        self.model
    }
    /// The drive's gear.
    pub fn gear(&self) -> Gear {
        self.gear
    }
    /// The value of a stored parameter (signed where the table says so).
    pub fn value(&self, _parameter: Parameter) -> i32 {
        0
    }
}
