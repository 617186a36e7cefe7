//! The object dictionary of the AG03/1 (manual chapter 7.12; `canopen-ag03.md` 12, `canopen-od.tsv`), and which entry is
//! which parameter of the unit.

use crate::can_bus::canopen::Address;
use crate::can_bus::canopen::dictionary;
use crate::can_bus::canopen::dictionary::{Entry, Object};
use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::value::DataType::{I32, U8, U16, U32, VisibleString};
use crate::devices::ag03::param::on_canopen;
use crate::devices::ag03::param::{Gear, Model, Parameter, Quirks, Reading};
use crate::face::ObjectEntry;

use super::access::mode;

/// What the electronic data sheet says besides the objects (`canopen-link.md` 9, `canopen-ag03.md` 1).
pub(crate) const SHEET: Sheet<'static> = Sheet {
    file_name: "ag03-1.eds",
    file_version: 1,
    file_revision: 0,
    description: "Emulated positioning drive SIKO AG03/1",
    time: "08:00AM",
    date: "11-22-2026",
    created_by: "profidrive",
    vendor_name: "SIKO (emulated)",
    vendor_number: VENDOR,
    product_name: "AG03/1",
    product_number: 0,
    revision_number: 0,
    order_code: "AG03/1",
    kilobits: &[20, 50, 125, 250, 500, 1000],
    granularity: 0,
};

/// 2102h, which tells the gear of a real drive.
pub(crate) const HARDWARE_VERSION: Address = Address::new(0x2102, 0);

/// 1018h:1.
const VENDOR: u32 = 0x195;

/// The dictionary of a drive with this gear: it decides about the largest speeds.
pub const fn objects(gear: Gear) -> &'static [Object] {
    match gear {
        Gear::Ratio24 => Table::<24>::OBJECTS,
        Gear::Ratio48 => Table::<48>::OBJECTS,
    }
}

/// The parameter of the unit at an index and sub-index, if it is one. 6060h has another coding.
pub(super) fn parameter(pair: (u16, u8)) -> Option<Parameter> {
    on_canopen::PARAMETERS.iter().find(|row| row.0 == pair).map(|row| row.1)
}

/// The read-out at an index and sub-index, if it is one that PROFIBUS has, too.
pub(super) fn reading(pair: (u16, u8)) -> Option<Reading> {
    on_canopen::READINGS.iter().find(|row| row.0 == pair).map(|row| row.1)
}

/// The entry of a stored parameter: all of it is in the row of the parameter.
const fn kept(parameter: Parameter, gear: Gear) -> Entry {
    let (setting, stored, ObjectEntry { at: (_, sub), data, name }) = parameter.on_canopen();
    let range = setting.limits.range(Model::Ag03_1, gear, Quirks::NONE);
    let is_mode = matches!(parameter, Parameter::OperatingMode);
    let default = if is_mode { mode(setting.default) } else { setting.default };
    let entry = Entry::rw(sub, name, data).number(default as i64);
    Entry { stored, ..entry.range(range.low as i64, range.high as i64) }
}

/// The entry of a read-out.
const fn shown(reading: Reading) -> Entry {
    let ObjectEntry { at: (_, sub), data, name } = reading.on_canopen();
    Entry::ro(sub, name, data).live()
}

/// The largest target position in either direction.
pub(crate) const MAX_TARGET: i32 = 9_999_999;

/// Transmission types of TPDOs.
const TPDO_TYPES: &[(i64, i64)] = &[(0, 240), (253, 255)];
/// Transmission types of RPDOs.
const RPDO_TYPES: &[(i64, i64)] = &[(0, 240), (254, 255)];

const fn error_field(sub: u8) -> Entry {
    Entry::ro(sub, "Standard error field", U32).number(0).live()
}

/// Of RPDO 3 and 4.
const fn rpdo(name: &'static str, base: u32) -> [Entry; 5] {
    [
        Entry::ro(0, "Largest sub-index", U8).number(5),
        Entry::rw(1, name, U32).node_id(base).pre_operational().node(),
        Entry::rw(2, "Transmission type", U8).number(255).ranges(RPDO_TYPES).pre_operational().node(),
        Entry::ro(3, "Inhibit time", U16).number(0),
        Entry::ro(5, "Event timer", U16).number(0),
    ]
}

/// Of TPDO 3 and 4.
const fn tpdo(name: &'static str, base: u32) -> [Entry; 5] {
    [
        Entry::ro(0, "Largest sub-index", U8).number(5),
        Entry::rw(1, name, U32).node_id(base).pre_operational().node(),
        Entry::rw(2, "Transmission type", U8).number(253).ranges(TPDO_TYPES).pre_operational().node(),
        Entry::rw(3, "Inhibit time x100 us", U16).number(100).pre_operational().node(),
        Entry::rw(5, "Event timer ms", U16).number(100).pre_operational().node(),
    ]
}

/// Of a PDO 2, which stands for compatibility only.
const fn unused_pdo(id: i64, timer: i64) -> [Entry; 5] {
    [
        Entry::ro(0, "Largest sub-index", U8).number(5),
        Entry::ro(1, "COB-ID", U32).number(id),
        Entry::ro(2, "Transmission type", U8).number(255),
        Entry::ro(3, "Inhibit time", U16).number(0),
        Entry::ro(5, "Event timer", U16).number(timer),
    ]
}

/// How many objects are no parameter, or hold several.
const OTHERS: usize = 49;
/// How many parameters are an object of their own: their rows are all of it.
const SINGLES: usize = count_singles();

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn count_singles() -> usize {
    let (mut count, mut row) = (0, 0);
    while row < on_canopen::PARAMETERS.len() {
        count += (on_canopen::PARAMETERS[row].0.1 == 0) as usize;
        row += 1;
    }
    count
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn singles(gear: Gear) -> [(u16, [Entry; 1]); SINGLES] {
    let mut singles = [const { (0, [error_field(0)]) }; SINGLES];
    let (mut count, mut row) = (0, 0);
    while row < on_canopen::PARAMETERS.len() {
        if let ((index, 0), parameter) = on_canopen::PARAMETERS[row] {
            singles[count] = (index, [kept(parameter, gear)]);
            count += 1;
        }
        row += 1;
    }
    singles
}

/// The dictionary of a drive with an internal gear of this ratio.
struct Table<const RATIO: u16>;

impl<const RATIO: u16> Table<RATIO> {
    const GEAR: Gear = match RATIO {
        24 => Gear::Ratio24,
        _ => Gear::Ratio48,
    };
    const RPM: i64 = Self::GEAR.max_rpm() as i64;

    const SINGLES: [(u16, [Entry; 1]); SINGLES] = singles(Self::GEAR);
    const TABLE: [Object; OTHERS + SINGLES] = dictionary::with_singles(&Self::OTHERS, &Self::SINGLES);
    const OBJECTS: &'static [Object] = &Self::TABLE;

    /// The objects that are no parameter, and those that hold several.
    const OTHERS: [Object; OTHERS] = [
        Object::var(0x1000, &[Entry::ro(0, "Device type", U32).number(0x0000_0192)]),
        Object::var(0x1001, &[Entry::ro(0, "Error register", U8).number(0).node()]),
        Object::var(0x1002, &[shown(Reading::SystemStatus)]),
        Object::array(
            0x1003,
            "Predefined error field",
            &[
                Entry::rw(0, "Number of errors", U8).number(0).range(0, 0).stored(),
                error_field(1),
                error_field(2),
                error_field(3),
                error_field(4),
                error_field(5),
                error_field(6),
                error_field(7),
                error_field(8),
                error_field(9),
                error_field(10),
            ],
        ),
        Object::var(0x1005, &[Entry::rw(0, "COB-ID SYNC", U32).number(0x0000_0080).pre_operational().node()]),
        Object::var(0x1008, &[Entry::ro(0, "Manufacturer device name", VisibleString).text("AG03")]),
        Object::var(0x100A, &[Entry::ro(0, "Manufacturer software version", VisibleString).text("4.01")]),
        Object::var(0x100C, &[Entry::rw(0, "Guard time ms", U16).number(0).node()]),
        Object::var(0x100D, &[Entry::rw(0, "Life time factor", U8).number(0).node()]),
        Object::array(
            0x1011,
            "Restore default parameters",
            &[
                Entry::ro(0, "Number of entries", U8).number(4),
                Entry::wo(1, "Restore all parameters", U32).node(),
                Entry::wo(2, "Restore standard parameters", U32).node(),
                Entry::wo(3, "Restore controller parameters", U32).node(),
                Entry::wo(4, "Calibrate", U32).node(),
            ],
        ),
        Object::var(0x1014, &[Entry::rw(0, "COB-ID EMCY", U32).node_id(0x80).pre_operational().node()]),
        Object::var(0x1017, &[Entry::rw(0, "Producer heartbeat time ms", U16).number(0).node()]),
        Object::record(
            0x1018,
            "Identity",
            &[
                Entry::ro(0, "Number of entries", U8).number(4),
                Entry::ro(1, "Vendor ID", U32).number(VENDOR as i64),
                Entry::ro(2, "Product code", U32).number(0),
                Entry::ro(3, "Revision number", U32).number(0),
                shown(Reading::SerialNumber),
            ],
        ),
        Object::record(
            0x1200,
            "SDO server parameter",
            &[
                Entry::ro(0, "Number of entries", U8).number(2),
                Entry::ro(1, "COB-ID client to server", U32).node_id(0x600),
                Entry::ro(2, "COB-ID server to client", U32).node_id(0x580),
            ],
        ),
        Object::record(
            0x1400,
            "RPDO1 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::rw(1, "COB-ID RPDO1", U32).node_id(0x200).pre_operational().node(),
                Entry::rw(2, "Transmission type", U8).number(255).ranges(RPDO_TYPES).pre_operational().node(),
                Entry::rw(3, "Inhibit time", U16).number(100).pre_operational().node(),
                Entry::rw(5, "Event timer", U16).number(0).pre_operational().node(),
            ],
        ),
        Object::record(0x1401, "RPDO2 communication parameter", &unused_pdo(0x0000_0301, 0)),
        Object::record(0x1402, "RPDO3 communication parameter", &rpdo("COB-ID RPDO3", 0x400)),
        Object::record(0x1403, "RPDO4 communication parameter", &rpdo("COB-ID RPDO4", 0x500)),
        Object::record(
            0x1600,
            "RPDO1 mapping parameter",
            &[
                Entry::ro(0, "Mapped objects RPDO1", U8).number(1).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6040_0010).node(),
            ],
        ),
        Object::record(
            0x1601,
            "RPDO2 mapping parameter",
            &[Entry::ro(0, "Mapped objects RPDO2", U8).number(0)],
        ),
        Object::record(
            0x1602,
            "RPDO3 mapping parameter",
            &[
                Entry::ro(0, "Mapped objects RPDO3", U8).number(2).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6040_0010).node(),
                Entry::ro(2, "Mapping 2", U32).number(0x607A_0020).node(),
            ],
        ),
        Object::record(
            0x1603,
            "RPDO4 mapping parameter",
            &[
                Entry::ro(0, "Mapped objects RPDO4", U8).number(2).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6040_0010).node(),
                Entry::ro(2, "Mapping 2", U32).number(0x60FF_0020).node(),
            ],
        ),
        Object::record(
            0x1800,
            "TPDO1 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::rw(1, "COB-ID TPDO1", U32).node_id(0x180).pre_operational().node(),
                Entry::rw(2, "Transmission type", U8).number(255).ranges(TPDO_TYPES).pre_operational().node(),
                Entry::rw(3, "Inhibit time x100 us", U16).number(100).pre_operational().node(),
                Entry::rw(5, "Event timer ms", U16).number(100).pre_operational().stored().node(),
            ],
        ),
        Object::record(0x1801, "TPDO2 communication parameter", &unused_pdo(0x0000_0281, 100)),
        Object::record(0x1802, "TPDO3 communication parameter", &tpdo("COB-ID TPDO3", 0x380)),
        Object::record(0x1803, "TPDO4 communication parameter", &tpdo("COB-ID TPDO4", 0x480)),
        Object::record(
            0x1A00,
            "TPDO1 mapping parameter",
            &[
                Entry::ro(0, "Mapped objects TPDO1", U8).number(1).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6041_0010).node(),
            ],
        ),
        Object::record(
            0x1A01,
            "TPDO2 mapping parameter",
            &[Entry::ro(0, "Mapped objects TPDO2", U8).number(0)],
        ),
        Object::record(
            0x1A02,
            "TPDO3 mapping parameter",
            &[
                Entry::ro(0, "Mapped objects TPDO3", U8).number(2).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6041_0010).node(),
                Entry::ro(2, "Mapping 2", U32).number(0x6064_0020).node(),
            ],
        ),
        Object::record(
            0x1A03,
            "TPDO4 mapping parameter",
            &[
                Entry::ro(0, "Mapped objects TPDO4", U8).number(2).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6041_0010).node(),
                Entry::ro(2, "Mapping 2", U32).number(0x606C_0020).node(),
            ],
        ),
        Object::var(
            0x2100,
            &[Entry::rw(0, "CAN baud rate", U8).number(10).range(0, 11).pre_operational().stored()],
        ),
        Object::var(0x2101, &[Entry::ro(0, "Node-ID", U8).number(1).live()]),
        Object::var(0x2102, &[shown(Reading::HardwareVersion)]),
        Object::record(
            0x2410,
            "Controller parameters",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(10),
                kept(Parameter::ControllerP, Self::GEAR),
                kept(Parameter::ControllerI, Self::GEAR),
                kept(Parameter::ControllerD, Self::GEAR),
                kept(Parameter::APos, Self::GEAR),
                kept(Parameter::VPos, Self::GEAR),
                kept(Parameter::ARot, Self::GEAR),
                kept(Parameter::AInch, Self::GEAR),
                kept(Parameter::VInch, Self::GEAR),
                kept(Parameter::DPos, Self::GEAR),
            ],
        ),
        Object::array(
            0x241B,
            "Supply voltages",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(2),
                shown(Reading::OutputStageVoltage),
                shown(Reading::ControlVoltage),
            ],
        ),
        Object::var(0x241C, &[shown(Reading::Temperature)]),
        Object::var(0x241E, &[shown(Reading::MotorCurrent)]),
        Object::var(0x2420, &[Entry::ro(0, "Generic status register", U8).live()]),
        Object::var(0x2422, &[Entry::ro(0, "Torque deactivation state", U8).live()]),
        Object::var(0x2423, &[shown(Reading::BatteryVoltage)]),
        Object::var(0x2500, &[shown(Reading::ProductionDate)]),
        Object::var(0x6040, &[Entry::rw(0, "Controlword", U16).number(0).to_rpdo()]),
        Object::var(0x6041, &[Entry::ro(0, "Statusword", U16).to_tpdo().live()]),
        Object::var(0x6064, &[shown(Reading::Position).to_tpdo()]),
        Object::var(0x606C, &[Entry::ro(0, "Velocity actual value rpm", I32).to_tpdo().live()]),
        Object::var(
            0x607A,
            &[Entry::rw(0, "Target position", I32).number(0).range(-9_999_999, 9_999_999).to_rpdo()],
        ),
        Object::array(
            0x607D,
            "Software position limits",
            &[
                Entry::ro(0, "Number of entries", U8).number(2),
                kept(Parameter::Limit2, Self::GEAR),
                kept(Parameter::Limit1, Self::GEAR),
            ],
        ),
        Object::array(
            0x6091,
            "Gear ratio",
            &[
                Entry::ro(0, "Number of entries", U8).number(2),
                kept(Parameter::GearNumerator, Self::GEAR),
                kept(Parameter::GearDenominator, Self::GEAR),
            ],
        ),
        Object::var(
            0x60FF,
            &[Entry::rw(0, "Target velocity rpm", I32).number(0).range(-Self::RPM, Self::RPM).to_rpdo()],
        ),
    ];
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::can_bus::canopen::dictionary::{Access, Limits};
    use crate::can_bus::canopen::{Address, NodeId, check, dictionary};

    #[test]
    fn the_table_agrees_with_itself() {
        for gear in Gear::ALL {
            let mut problems = Vec::new();
            check::each_problem(objects(gear), &mut |problem| problems.push(problem));
            assert!(problems.is_empty(), "{problems:?}");
        }
    }

    #[test]
    fn ranges_and_defaults_are_those_of_the_parameters() {
        for gear in Gear::ALL {
            for ((index, sub), parameter) in on_canopen::PARAMETERS {
                let entry = dictionary::entry(objects(gear), Address::new(index, sub)).unwrap();
                assert_eq!(entry.access, Access::Rw, "{parameter}");
                assert_eq!(entry.stored, parameter.entry().persistent, "{parameter}");
                if parameter == Parameter::OperatingMode {
                    continue;
                }
                let range = parameter.entry().range(Model::Ag03_1, gear, Quirks::default()).unwrap();
                assert_eq!(entry.limits, Limits::Range(range.low.into(), range.high.into()), "{parameter}");
                let default = entry.default_value(NodeId::MIN).number();
                assert_eq!(default, Some(parameter.setting().default.into()), "{parameter}");
            }
        }
    }
}
