//! Every parameter of both models as data (`ag03.md` 3.1; manual chapter 6 and table 15), one row each: its number on
//! PROFIBUS and its place in the object dictionary (`canopen-ag03.md` 11).
//!
//! Decided where the manuals contradict themselves: the I gain is 0 to 500 on both models (`ag03.md` C-01),
//! the accelerations of an AG03 may be 0 (C-02). Numbers that are reserved or not listed have no entry.

use core::fmt;

use super::entry::{Entry, Group, Kind, Limits, Models, Range, Setting, Unit, WritableWhen};
use super::{FAULT_BUFFER_LEN, Model, Pnu, Width};
use crate::face::{DataType, ObjectEntry};

/// Every parameter of either model, in the order of the numbers.
pub static TABLE: &[Entry] = &STORED;

/// The rows with their number, which only this file counts.
static STORED: [Entry; ROWS.len()] = entries();

/// A parameter on both buses. Only the compiler has it: each bus takes its part.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) entry: Entry,
    pub(super) object: Option<ObjectEntry>,
}

/// The parameter `pnu` of a model, if it has one. Takes the same short time for every number.
pub fn entry(model: Model, pnu: Pnu) -> Option<&'static Entry> {
    let offset = pnu.number().checked_sub(FIRST_PNU)?;
    let row = *ROW_OF_PNU.get(usize::from(offset))?;
    STORED.get(usize::from(row)).filter(|entry| entry.models.contain(model))
}

/// The parameters a model has, in the order of their numbers.
pub fn parameters(model: Model) -> impl Iterator<Item = &'static Entry> {
    TABLE.iter().filter(move |entry| entry.models.contain(model))
}

/// A stored parameter of manual chapter 6, in the order of the internal numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Parameter {
    /// No. 1, PNU 1000: P gain of the controller.
    ControllerP,
    /// No. 2, PNU 1001: I gain of the controller.
    ControllerI,
    /// No. 3, PNU 1002: D gain of the controller.
    ControllerD,
    /// No. 4, PNU 1003: acceleration of travel jobs, in % of 4 rev/s^2.
    APos,
    /// No. 5, PNU 1004: speed of travel jobs in rpm.
    VPos,
    /// No. 6, PNU 1005: acceleration in velocity mode, in % of 4 rev/s^2.
    ARot,
    /// No. 8, PNU 1007: acceleration of inching, in % of 4 rev/s^2.
    AInch,
    /// No. 9, PNU 1008: speed of inching in rpm.
    VInch,
    /// No. 10, PNU 1009: window around the setpoint, in increments or 0.01 mm, in velocity mode in rpm.
    PosWindow,
    /// No. 11, PNU 1010: numerator of an external gear.
    GearNumerator,
    /// No. 12, PNU 1011: denominator of an external gear.
    GearDenominator,
    /// No. 13, PNU 1012: spindle pitch in 0.01 mm per turn; 0 = positions are increments.
    SpindlePitch,
    /// No. 14, PNU 1018: the position calibration sets, in increments or 0.01 mm.
    CalibrationValue,
    /// No. 15, PNU 1016: one end of the travel range, in increments or 0.01 mm.
    Limit1,
    /// No. 16, PNU 1017: the other end of the travel range, in increments or 0.01 mm.
    Limit2,
    /// No. 17, PNU 1019: distance of inching 1, in increments or 0.01 mm; the sign is the direction.
    DeltaInch,
    /// No. 18, PNU 1013: counting direction, 0 = i, 1 = e.
    SenseOfRotation,
    /// No. 19, PNU 1014: 0 = direct, 1 = loop +, 2 = loop -.
    PosType,
    /// No. 20, PNU 930: 1 = velocity mode, 2 = positioning mode.
    OperatingMode,
    /// No. 25, PNU 1021: inching 2 stops 0 = with maximum deceleration, 1 = with a-Inch.
    StopModeInch2,
    /// No. 26, PNU 1022: at the target 0 = hold position, 1 = short the windings, 2 = release the motor.
    InposMode,
    /// No. 27, PNU 1023: length of the loop, always in increments.
    LoopLength,
    /// No. 29, PNU 1032: torque threshold in %; 125 = off.
    TorqueDeactivation,
    /// No. 30, PNU 1035: speed of inching 2 in % of v-Inch; 100 after each power-on.
    OffsetInch2,
    /// No. 31, PNU 1039: deceleration of travel jobs in % of 4 rev/s^2; 101 = as a-Pos (`ag03.md` C-29). Only
    /// an AG03/1 has it; on an AG03 the value stays 101.
    DPos,
}

impl Parameter {
    /// How many there are.
    pub(crate) const COUNT: usize = 25;
    /// How many of them the EEPROM keeps.
    pub(crate) const KEPT: usize = kept();

    /// Everything known about it.
    #[expect(
        clippy::indexing_slicing,
        reason = "one slot per variant; the compiler built and checked the rows"
    )]
    pub fn entry(self) -> &'static Entry {
        &STORED[usize::from(ROW_OF_PARAMETER[self as usize])]
    }

    /// What manual chapter 6 says about it.
    #[expect(clippy::indexing_slicing, reason = "one slot per variant")]
    pub fn setting(self) -> &'static Setting {
        &SETTINGS[self as usize]
    }

    /// The stored parameters in the order of the internal numbers.
    pub fn all() -> impl Iterator<Item = Self> {
        SETTINGS.iter().map(|setting| setting.parameter)
    }
}

/// A value the drive only shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reading {
    /// PNU 918, station address, set by DIP switches.
    Address,
    /// PNU 945, codes of the last ten faults.
    FaultBuffer,
    /// PNU 952, number of faults so far.
    FaultCount,
    /// PNU 961, tells the gear.
    HardwareVersion,
    /// PNU 965, 0x0101 = 1.01 (`ag03.md` C-34: not the profile number).
    SoftwareVersion,
    /// PNU 1020, system status word SSW.
    SystemStatus,
    /// PNU 1027, temperature of the output stage.
    Temperature,
    /// PNU 1029, motor current.
    MotorCurrent,
    /// PNU 1031, general status register.
    GeneralStatus,
    /// PNU 1033, serial number.
    SerialNumber,
    /// PNU 1034, date of production.
    ProductionDate,
    /// PNU 1036, position value.
    Position,
    /// PNU 1040, supply voltage of the output stage.
    OutputStageVoltage,
    /// PNU 1041, supply voltage of the control.
    ControlVoltage,
    /// PNU 1042, battery voltage.
    BatteryVoltage,
}

impl Reading {
    /// How many there are.
    pub(crate) const COUNT: usize = Self::BatteryVoltage as usize + 1;

    /// Everything known about it.
    #[expect(
        clippy::indexing_slicing,
        reason = "one slot per variant; the compiler built and checked the rows"
    )]
    pub fn entry(self) -> &'static Entry {
        &STORED[usize::from(ROW_OF_READING[self as usize])]
    }
}

impl fmt::Display for Parameter {
    /// The name in the English manual.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.entry().name)
    }
}

/// PNU 970, which takes commands.
pub(crate) const LOAD_PARAMETER_SET: Pnu = Pnu(970);
/// The command of PNU 970 that clears fault buffer and fault counter.
pub(crate) const CLEAR_FAULTS: u16 = 4;
/// The command of PNU 970 that calibrates.
pub const CALIBRATE: u16 = 5;

/// The operating mode of which the setpoint is a velocity, PNU 930.
pub(crate) const VELOCITY_MODE: u16 = 1;
/// The operating mode of which the setpoint is a position, PNU 930.
pub(crate) const POSITIONING_MODE: u16 = 2;

const MODES: &[(u16, &str)] = &[(VELOCITY_MODE, "velocity mode"), (POSITIONING_MODE, "positioning mode")];
const GEARS: &[(u16, &str)] = &[(2, "gear 24:1"), (3, "gear 48:1")];
const LOAD_COMMANDS: &[(u16, &str)] = &[
    (1, "load all defaults"),
    (2, "load standard defaults"),
    (3, "load controller defaults"),
    (CLEAR_FAULTS, "clear faults"),
    (CALIBRATE, "calibrate"),
];
const SENSES: &[(u16, &str)] = &[(0, "i"), (1, "e")];
const POS_TYPES: &[(u16, &str)] = &[(0, "direct"), (1, "loop +"), (2, "loop -")];
const STOP_MODES: &[(u16, &str)] = &[(0, "maximum deceleration"), (1, "programmed deceleration")];
const INPOS_MODES: &[(u16, &str)] =
    &[(0, "position control"), (1, "windings shorted"), (2, "motor released")];

#[rustfmt::skip] // one row per line
pub(super) const ROWS: [Row; 41] = {
    use DataType as C;
    use Parameter as P;
    use Reading as R;
    use Unit as U;
    use WritableWhen::Standstill;
    [
        only_profibus(word(918, "Profibus address", U::None, shown(R::Address))),
        on_canopen(word(930, "Operating mode", U::Choice(MODES), standard(P::OperatingMode, 20, to(1, 2), 2)).writable(Standstill), 0x6060, 0, C::U8, "Modes of operation"),
        only_profibus(word(945, "Fault buffer", U::Ascii, shown(R::FaultBuffer)).array(FAULT_BUFFER_LEN).persistent(true)),
        only_profibus(word(952, "Number of faults", U::None, shown(R::FaultCount)).persistent(true)),
        on_canopen(word(961, "Hardware version", U::Choice(GEARS), shown(R::HardwareVersion)), 0x2102, 0, C::U8, "Gear reduction"),
        only_profibus(word(965, "Software version", U::Version, shown(R::SoftwareVersion))),
        only_profibus(word(LOAD_PARAMETER_SET.0, "Load parameter data record", U::Choice(LOAD_COMMANDS), Kind::LoadParameterSet)),
        on_canopen(word(1000, "Controller parameter P", U::None, controller(P::ControllerP, 1, to(1, 500), 100)), 0x2410, 1, C::U16, "Controller P"),
        on_canopen(word(1001, "Controller parameter I", U::None, controller(P::ControllerI, 2, Limits::IGain, 5)), 0x2410, 2, C::U16, "Controller I"),
        on_canopen(word(1002, "Controller parameter D", U::None, controller(P::ControllerD, 3, to(0, 500), 0)), 0x2410, 3, C::U16, "Controller D"),
        on_canopen(word(1003, "a-Pos", U::PercentOfAcceleration, controller(P::APos, 4, Limits::Acceleration, 50)), 0x2410, 4, C::U8, "a-Pos %"),
        on_canopen(word(1004, "v-Pos", U::Rpm, controller(P::VPos, 5, Limits::Speed, 30)), 0x2410, 5, C::U8, "v-Pos rpm"),
        on_canopen(word(1005, "a-Rot", U::PercentOfAcceleration, controller(P::ARot, 6, Limits::Acceleration, 50)), 0x2410, 6, C::U8, "a-Rot %"),
        on_canopen(word(1007, "a-Inch", U::PercentOfAcceleration, controller(P::AInch, 8, Limits::Acceleration, 50)), 0x2410, 8, C::U8, "a-Inch %"),
        on_canopen(word(1008, "v-Inch", U::Rpm, controller(P::VInch, 9, Limits::Speed, 30)).writable(Standstill), 0x2410, 9, C::U8, "v-Inch rpm"),
        on_canopen(word(1009, "Pos window", U::Window, standard(P::PosWindow, 10, to(0, 1000), 10)), 0x6067, 0, C::U16, "Position window"),
        on_canopen(word(1010, "Gear numerator", U::None, standard(P::GearNumerator, 11, to(1, 10_000), 1)).writable(Standstill), 0x6091, 1, C::U16, "Gear numerator"),
        on_canopen(word(1011, "Gear denominator", U::None, standard(P::GearDenominator, 12, to(1, 10_000), 1)).writable(Standstill), 0x6091, 2, C::U16, "Gear denominator"),
        on_canopen(word(1012, "Spindle pitch", U::SpindlePitch, standard(P::SpindlePitch, 13, to(0, 1000), 0)).writable(Standstill), 0x2412, 0, C::U16, "Spindle pitch 1/100 mm"),
        on_canopen(word(1013, "Sense of rotation", U::Choice(SENSES), standard(P::SenseOfRotation, 18, to(0, 1), 0)).writable(Standstill), 0x607E, 0, C::U8, "Polarity"),
        on_canopen(word(1014, "Pos type", U::Choice(POS_TYPES), standard(P::PosType, 19, to(0, 2), 0)), 0x2413, 0, C::U8, "Positioning type"),
        on_canopen(double(1016, "Limit 1", U::Position, standard(P::Limit1, 15, to(-9_999_999, 9_999_999), 1_000_000)), 0x607D, 2, C::I32, "Limit 1 (upper)"),
        on_canopen(double(1017, "Limit 2", U::Position, standard(P::Limit2, 16, to(-9_999_999, 9_999_999), -1_000_000)), 0x607D, 1, C::I32, "Limit 2 (lower)"),
        on_canopen(double(1018, "Calibration value", U::Position, standard(P::CalibrationValue, 14, to(-999_999, 999_999), 0)), 0x607C, 0, C::I32, "Calibration value"),
        on_canopen(double(1019, "Delta inch", U::Position, standard(P::DeltaInch, 17, to(-1_000_000, 1_000_000), 1600)), 0x2415, 0, C::I32, "Delta inch"),
        on_canopen(word(1020, "System status word", U::Bits, shown(R::SystemStatus)), 0x1002, 0, C::U32, "Manufacturer status register"),
        on_canopen(word(1021, "Stop mode inch 2", U::Choice(STOP_MODES), standard(P::StopModeInch2, 25, to(0, 1), 0)), 0x2416, 0, C::U8, "Stop mode inching 2"),
        on_canopen(word(1022, "Inpos mode", U::Choice(INPOS_MODES), standard(P::InposMode, 26, to(0, 2), 0)), 0x2417, 0, C::U8, "Inpos mode"),
        on_canopen(word(1023, "Loop length", U::Increments, standard(P::LoopLength, 27, to(0, 10_000), 800)), 0x2418, 0, C::U16, "Loop length inc"),
        on_canopen(word(1027, "Device temperature", U::TenthDegrees, shown(R::Temperature)).signed(true).only_ag03_1(), 0x241C, 0, C::I16, "Output-stage temperature 0.1 C"),
        on_canopen(word(1029, "Motor current", U::Milliamperes, shown(R::MotorCurrent)).signed(true).only_ag03_1(), 0x241E, 0, C::I16, "Motor current mA"),
        only_profibus(word(1031, "General status register", U::Bits, shown(R::GeneralStatus))),
        on_canopen(word(1032, "Torque deactivation", U::Percent, standard(P::TorqueDeactivation, 29, to(20, 125), 125)), 0x2421, 0, C::U8, "Torque deactivation %"),
        on_canopen(double(1033, "Serial number", U::None, shown(R::SerialNumber)).signed(false), 0x1018, 4, C::U32, "Serial number"),
        on_canopen(double(1034, "Date of production", U::Date, shown(R::ProductionDate)).signed(false), 0x2500, 0, C::U32, "Production date DDMMYYYY"),
        on_canopen(word(1035, "Offset inching 2", U::Percent, standard(P::OffsetInch2, 30, to(10, 100), 100)).persistent(false), 0x2450, 0, C::U8, "Inching 2 offset %"),
        on_canopen(double(1036, "Position value", U::Position, shown(R::Position)), 0x6064, 0, C::I32, "Position actual value"),
        on_canopen(word(1039, "d-Pos", U::PercentOfAcceleration, controller(P::DPos, 31, to(1, 101), 101)).only_ag03_1(), 0x2410, 0x0A, C::U8, "d-Pos %"),
        on_canopen(word(1040, "Supply voltage output stage", U::TenthVolts, shown(R::OutputStageVoltage)).only_ag03_1(), 0x241B, 1, C::U16, "Supply output stage 0.1 V"),
        on_canopen(word(1041, "Supply voltage control", U::TenthVolts, shown(R::ControlVoltage)).only_ag03_1(), 0x241B, 2, C::U16, "Supply control 0.1 V"),
        on_canopen(word(1042, "Battery voltage", U::HundredthVolts, shown(R::BatteryVoltage)).only_ag03_1(), 0x2423, 0, C::I16, "Battery voltage 0.01 V"),
    ]
};

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn kept() -> usize {
    let (mut count, mut row) = (0, 0);
    while row < ROWS.len() {
        let Entry { kind, persistent, .. } = ROWS[row].entry;
        count += (persistent && matches!(kind, Kind::Setting(_))) as usize;
        row += 1;
    }
    count
}

/// A parameter with its place in the object dictionary of the AG03/1.
const fn on_canopen(entry: Entry, index: u16, sub: u8, data: DataType, name: &'static str) -> Row {
    Row { entry, object: Some(ObjectEntry { at: (index, sub), data, name }) }
}

/// A parameter that the object dictionary does not have.
const fn only_profibus(entry: Entry) -> Row {
    Row { entry, object: None }
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn entries() -> [Entry; ROWS.len()] {
    let mut entries = [ROWS[0].entry; ROWS.len()];
    let mut row = 1;
    while row < ROWS.len() {
        entries[row] = ROWS[row].entry;
        row += 1;
    }
    entries
}

/// A word: unsigned, kept in the EEPROM if it is a setting, known to both models.
const fn word(pnu: u16, name: &'static str, unit: Unit, kind: Kind) -> Entry {
    let persistent = matches!(kind, Kind::Setting(_));
    let (width, elements, models) = (Width::Word, None, Models::Both);
    Entry { pnu: Pnu(pnu), name, width, elements, signed: false, unit, persistent, models, kind }
}

/// A double word: as a word, but signed.
const fn double(pnu: u16, name: &'static str, unit: Unit, kind: Kind) -> Entry {
    Entry { width: Width::Double, signed: true, ..word(pnu, name, unit, kind) }
}

const fn shown(reading: Reading) -> Kind {
    Kind::Reading(reading)
}

const fn controller(parameter: Parameter, number: u8, limits: Limits, default: i32) -> Kind {
    setting(parameter, number, limits, default, Group::Controller)
}

const fn standard(parameter: Parameter, number: u8, limits: Limits, default: i32) -> Kind {
    setting(parameter, number, limits, default, Group::Standard)
}

const fn setting(parameter: Parameter, number: u8, limits: Limits, default: i32, group: Group) -> Kind {
    let writable = WritableWhen::Always;
    Kind::Setting(Setting { parameter, number, limits, default, group, writable })
}

const fn to(low: i32, high: i32) -> Limits {
    Limits::Fixed(Range { low, high })
}

/// The row of each number from [`FIRST_PNU`] on, [`NO_ROW`] where there is none.
static ROW_OF_PNU: [u8; PNUS] = rows_by_pnu();
static ROW_OF_PARAMETER: [u8; Parameter::COUNT] = rows_by_parameter();
static ROW_OF_READING: [u8; Reading::COUNT] = rows_by_reading();
static SETTINGS: [Setting; Parameter::COUNT] = settings();

const FIRST_PNU: u16 = 918;
const LAST_PNU: u16 = 1042;
const PNUS: usize = (LAST_PNU - FIRST_PNU + 1) as usize;
const NO_ROW: u8 = u8::MAX;

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn rows_by_pnu() -> [u8; PNUS] {
    let mut rows = [NO_ROW; PNUS];
    let mut row = 0;
    while (row as usize) < ROWS.len() {
        rows[(ROWS[row as usize].entry.pnu.0 - FIRST_PNU) as usize] = row;
        row += 1;
    }
    rows
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
pub(super) const fn rows_by_parameter() -> [u8; Parameter::COUNT] {
    let mut rows = [NO_ROW; Parameter::COUNT];
    let mut row = 0;
    while (row as usize) < ROWS.len() {
        if let Kind::Setting(setting) = ROWS[row as usize].entry.kind {
            rows[setting.parameter as usize] = row;
        }
        row += 1;
    }
    rows
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
pub(super) const fn rows_by_reading() -> [u8; Reading::COUNT] {
    let mut rows = [NO_ROW; Reading::COUNT];
    let mut row = 0;
    while (row as usize) < ROWS.len() {
        if let Kind::Reading(reading) = ROWS[row as usize].entry.kind {
            rows[reading as usize] = row;
        }
        row += 1;
    }
    let mut slot = 0;
    while slot < rows.len() {
        assert!(rows[slot] != NO_ROW, "a reading without a row");
        slot += 1;
    }
    rows
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn settings() -> [Setting; Parameter::COUNT] {
    let rows = rows_by_parameter();
    let mut settings = [setting_of(rows[0]); Parameter::COUNT];
    let mut slot = 0;
    while slot < rows.len() {
        settings[slot] = setting_of(rows[slot]);
        slot += 1;
    }
    settings
}

/// Does not compile for a [`Parameter`] without a row.
#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn setting_of(row: u8) -> Setting {
    match ROWS[row as usize].entry.kind {
        Kind::Setting(setting) => setting,
        Kind::Reading(_) | Kind::LoadParameterSet => panic!("the row of a stored parameter holds none"),
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::devices::ag03::param::{Access, Gear, Quirks, Value};

    #[test]
    fn the_models_have_the_numbers_of_the_reference() {
        let both = [
            918, 930, 945, 952, 961, 965, 970, 1000, 1001, 1002, 1003, 1004, 1005, 1007, 1008, 1009, 1010,
            1011, 1012, 1013, 1014, 1016, 1017, 1018, 1019, 1020, 1021, 1022, 1023, 1031, 1032, 1033, 1034,
            1035, 1036,
        ];
        let only_ag03_1 = [1027, 1029, 1039, 1040, 1041, 1042];
        for number in 0..=2047 {
            let pnu = Pnu::new(number).unwrap();
            let found = Model::ALL.map(|model| entry(model, pnu).is_some());
            let expected = [both.contains(&number), both.contains(&number) || only_ag03_1.contains(&number)];
            assert_eq!(found, expected, "PNU {number}");
        }
        assert_eq!(parameters(Model::Ag03).count(), 35);
        assert_eq!(parameters(Model::Ag03_1).count(), 41);
    }

    #[test]
    fn an_entry_is_found_under_its_own_number() {
        assert!(TABLE.is_sorted_by_key(|entry| entry.pnu));
        for row in TABLE {
            assert_eq!(entry(Model::Ag03_1, row.pnu), Some(row));
        }
    }

    #[test]
    fn the_names_of_stored_parameters_follow_the_internal_numbers() {
        let numbers: Vec<u8> = Parameter::all().map(|parameter| parameter.setting().number).collect();
        let expected =
            [1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 25, 26, 27, 29, 30, 31];
        assert_eq!(numbers, expected);
        for parameter in Parameter::all() {
            assert_eq!(parameter.entry().kind, Kind::Setting(*parameter.setting()));
        }
    }

    #[test]
    fn defaults_are_within_the_range_of_every_drive() {
        for parameter in Parameter::all() {
            let setting = parameter.setting();
            for (model, gear) in Model::ALL.into_iter().flat_map(|model| Gear::ALL.map(|gear| (model, gear)))
            {
                assert!(
                    setting.limits.range(model, gear, Quirks::default()).contains(setting.default),
                    "{parameter}"
                );
            }
        }
    }

    #[test]
    fn writable_words_are_unsigned_and_writable_double_words_are_signed() {
        for row in TABLE.iter().filter(|row| row.access() != Access::ReadOnly) {
            assert_eq!(row.signed, row.width == Width::Double, "{}", row.name);
            let range = row.range(Model::Ag03, Gear::Ratio24, Quirks::default()).unwrap();
            assert!(row.signed || range.low >= 0 && range.high <= 0xFFFF, "{}", row.name);
        }
    }

    #[test]
    fn the_eeprom_keeps_what_the_reference_marks() {
        let volatile: Vec<u16> = Parameter::all()
            .map(Parameter::entry)
            .filter(|entry| !entry.persistent)
            .map(|entry| entry.pnu.number())
            .collect();
        assert_eq!(volatile, [1035]);
        let kept: Vec<u16> = TABLE
            .iter()
            .filter(|entry| entry.access() == Access::ReadOnly && entry.persistent)
            .map(|entry| entry.pnu.number())
            .collect();
        assert_eq!(kept, [945, 952]);
    }

    #[test]
    fn the_controller_parameters_are_those_with_one_star() {
        let controller: Vec<u8> = Parameter::all()
            .map(|parameter| *parameter.setting())
            .filter(|setting| setting.group == Group::Controller)
            .map(|setting| setting.number)
            .collect();
        assert_eq!(controller, [1, 2, 3, 4, 5, 6, 8, 9, 31]);
    }

    #[test]
    fn a_value_becomes_the_number_it_stands_for() {
        let number =
            |pnu, value| entry(Model::Ag03_1, Pnu::new(pnu).unwrap()).map(|entry| entry.number(value));
        assert_eq!(number(1017, Value::Double(0xFFF0_BDC0)), Some(-1_000_000));
        assert_eq!(number(1033, Value::Double(0xFFFF_FFFF)), Some(4_294_967_295));
        assert_eq!(number(1027, Value::Word(0xFFF6)), Some(-10));
        assert_eq!(number(952, Value::Word(0xFFF6)), Some(65_526));
    }

    #[test]
    fn names_and_units_are_those_of_the_manual() {
        assert_eq!(Parameter::VInch.to_string(), "v-Inch");
        assert_eq!(Parameter::VInch.entry().unit.to_string(), "rpm");
        assert_eq!(
            Parameter::Limit1
                .entry()
                .range(Model::Ag03, Gear::Ratio24, Quirks::default())
                .unwrap()
                .to_string(),
            "-9999999..9999999"
        );
    }
}
