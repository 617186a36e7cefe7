//! The object dictionary of the AG03/1 (manual chapter 7.12; `canopen-ag03.md` 12, `canopen-od.tsv`), and which entry is
//! which parameter of the unit.

use crate::can_bus::canopen::dictionary::{Entry, Object};
use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::value::DataType::{I16, I32, U8, U16, U32, VisibleString};
use crate::devices::ag03::param::{Gear, Parameter};

/// What the electronic data sheet says besides the objects (`canopen-link.md` 9, `canopen-ag03.md` 1).
pub const SHEET: Sheet<'static> = Sheet {
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

/// 1018h:1.
const VENDOR: u32 = 0x195;

/// The dictionary of a drive with this gear: it decides about the largest speeds.
pub const fn objects(gear: Gear) -> &'static [Object] {
    match gear {
        Gear::Ratio24 => Table::<{ Gear::Ratio24.max_rpm() as i64 }>::OBJECTS,
        Gear::Ratio48 => Table::<{ Gear::Ratio48.max_rpm() as i64 }>::OBJECTS,
    }
}

/// The parameter of the unit at an index and sub-index, if it is one.
pub fn parameter(pair: (u16, u8)) -> Option<Parameter> {
    PARAMETERS.iter().find(|row| row.0 == pair).map(|row| row.1)
}

/// The entries that are parameters of the unit (`canopen-ag03.md` 11). 6060h has another coding.
pub const PARAMETERS: [((u16, u8), Parameter); Parameter::COUNT] = [
    ((0x2410, 0x01), Parameter::ControllerP),
    ((0x2410, 0x02), Parameter::ControllerI),
    ((0x2410, 0x03), Parameter::ControllerD),
    ((0x2410, 0x04), Parameter::APos),
    ((0x2410, 0x05), Parameter::VPos),
    ((0x2410, 0x06), Parameter::ARot),
    ((0x2410, 0x08), Parameter::AInch),
    ((0x2410, 0x09), Parameter::VInch),
    ((0x2410, 0x0A), Parameter::DPos),
    ((0x2412, 0x00), Parameter::SpindlePitch),
    ((0x2413, 0x00), Parameter::PosType),
    ((0x2415, 0x00), Parameter::DeltaInch),
    ((0x2416, 0x00), Parameter::StopModeInch2),
    ((0x2417, 0x00), Parameter::InposMode),
    ((0x2418, 0x00), Parameter::LoopLength),
    ((0x2421, 0x00), Parameter::TorqueDeactivation),
    ((0x2450, 0x00), Parameter::OffsetInch2),
    ((0x6060, 0x00), Parameter::OperatingMode),
    ((0x6067, 0x00), Parameter::PosWindow),
    ((0x607C, 0x00), Parameter::CalibrationValue),
    ((0x607D, 0x01), Parameter::Limit2),
    ((0x607D, 0x02), Parameter::Limit1),
    ((0x607E, 0x00), Parameter::SenseOfRotation),
    ((0x6091, 0x01), Parameter::GearNumerator),
    ((0x6091, 0x02), Parameter::GearDenominator),
];

/// The largest target position in either direction.
pub const MAX_TARGET: i32 = 9_999_999;

/// Transmission types of TPDOs.
const TPDO_TYPES: &[(i64, i64)] = &[(0, 240), (253, 255)];
/// Transmission types of RPDOs.
const RPDO_TYPES: &[(i64, i64)] = &[(0, 240), (254, 255)];

/// The dictionary of a drive that turns with at most so many rpm.
struct Table<const RPM: i64>;

impl<const RPM: i64> Table<RPM> {
    const OBJECTS: &'static [Object] = &[
        Object::var(0x1000, &[Entry::ro(0, "Device type", U32).number(0x0000_0192)]),
        Object::var(0x1001, &[Entry::ro(0, "Error register", U8).number(0).node()]),
        Object::var(0x1002, &[Entry::ro(0, "Manufacturer status register", U32).live()]),
        Object::array(
            0x1003,
            "Predefined error field",
            &[
                Entry::rw(0, "Number of errors", U8).number(0).range(0, 0).stored(),
                Entry::ro(1, "Standard error field", U32).number(0).live(),
                Entry::ro(2, "Standard error field", U32).number(0).live(),
                Entry::ro(3, "Standard error field", U32).number(0).live(),
                Entry::ro(4, "Standard error field", U32).number(0).live(),
                Entry::ro(5, "Standard error field", U32).number(0).live(),
                Entry::ro(6, "Standard error field", U32).number(0).live(),
                Entry::ro(7, "Standard error field", U32).number(0).live(),
                Entry::ro(8, "Standard error field", U32).number(0).live(),
                Entry::ro(9, "Standard error field", U32).number(0).live(),
                Entry::ro(0x0A, "Standard error field", U32).number(0).live(),
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
                Entry::ro(4, "Serial number", U32).live(),
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
        Object::record(
            0x1401,
            "RPDO2 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::ro(1, "COB-ID", U32).number(0x0000_0301),
                Entry::ro(2, "Transmission type", U8).number(255),
                Entry::ro(3, "Inhibit time", U16).number(0),
                Entry::ro(5, "Event timer", U16).number(0),
            ],
        ),
        Object::record(
            0x1402,
            "RPDO3 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::rw(1, "COB-ID RPDO3", U32).node_id(0x400).pre_operational().node(),
                Entry::rw(2, "Transmission type", U8).number(255).ranges(RPDO_TYPES).pre_operational().node(),
                Entry::ro(3, "Inhibit time", U16).number(0),
                Entry::ro(5, "Event timer", U16).number(0),
            ],
        ),
        Object::record(
            0x1403,
            "RPDO4 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::rw(1, "COB-ID RPDO4", U32).node_id(0x500).pre_operational().node(),
                Entry::rw(2, "Transmission type", U8).number(255).ranges(RPDO_TYPES).pre_operational().node(),
                Entry::ro(3, "Inhibit time", U16).number(0),
                Entry::ro(5, "Event timer", U16).number(0),
            ],
        ),
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
        Object::record(
            0x1801,
            "TPDO2 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::ro(1, "COB-ID", U32).number(0x0000_0281),
                Entry::ro(2, "Transmission type", U8).number(255),
                Entry::ro(3, "Inhibit time", U16).number(0),
                Entry::ro(5, "Event timer", U16).number(100),
            ],
        ),
        Object::record(
            0x1802,
            "TPDO3 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::rw(1, "COB-ID TPDO3", U32).node_id(0x380).pre_operational().node(),
                Entry::rw(2, "Transmission type", U8).number(253).ranges(TPDO_TYPES).pre_operational().node(),
                Entry::rw(3, "Inhibit time x100 us", U16).number(100).pre_operational().node(),
                Entry::rw(5, "Event timer ms", U16).number(100).pre_operational().node(),
            ],
        ),
        Object::record(
            0x1803,
            "TPDO4 communication parameter",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(5),
                Entry::rw(1, "COB-ID TPDO4", U32).node_id(0x480).pre_operational().node(),
                Entry::rw(2, "Transmission type", U8).number(253).ranges(TPDO_TYPES).pre_operational().node(),
                Entry::rw(3, "Inhibit time x100 us", U16).number(100).pre_operational().node(),
                Entry::rw(5, "Event timer ms", U16).number(100).pre_operational().node(),
            ],
        ),
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
        Object::var(0x2102, &[Entry::ro(0, "Gear reduction", U8).live()]),
        Object::record(
            0x2410,
            "Controller parameters",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(10),
                Entry::rw(1, "Controller P", U16).number(100).range(1, 500).stored(),
                Entry::rw(2, "Controller I", U16).number(5).range(0, 500).stored(),
                Entry::rw(3, "Controller D", U16).number(0).range(0, 500).stored(),
                Entry::rw(4, "a-Pos %", U8).number(50).range(1, 100).stored(),
                Entry::rw(5, "v-Pos rpm", U8).number(30).range(1, RPM).stored(),
                Entry::rw(6, "a-Rot %", U8).number(50).range(1, 100).stored(),
                Entry::rw(8, "a-Inch %", U8).number(50).range(1, 100).stored(),
                Entry::rw(9, "v-Inch rpm", U8).number(30).range(1, RPM).stored(),
                Entry::rw(0x0A, "d-Pos %", U8).number(101).range(1, 101).stored(),
            ],
        ),
        Object::var(0x2412, &[Entry::rw(0, "Spindle pitch 1/100 mm", U16).number(0).range(0, 1000).stored()]),
        Object::var(0x2413, &[Entry::rw(0, "Positioning type", U8).number(0).range(0, 2).stored()]),
        Object::var(
            0x2415,
            &[Entry::rw(0, "Delta inch", I32).number(1600).range(-1_000_000, 1_000_000).stored()],
        ),
        Object::var(0x2416, &[Entry::rw(0, "Stop mode inching 2", U8).number(0).range(0, 1).stored()]),
        Object::var(0x2417, &[Entry::rw(0, "Inpos mode", U8).number(0).range(0, 2).stored()]),
        Object::var(0x2418, &[Entry::rw(0, "Loop length inc", U16).number(800).range(0, 10_000).stored()]),
        Object::array(
            0x241B,
            "Supply voltages",
            &[
                Entry::ro(0, "Largest sub-index", U8).number(2),
                Entry::ro(1, "Supply output stage 0.1 V", U16).live(),
                Entry::ro(2, "Supply control 0.1 V", U16).live(),
            ],
        ),
        Object::var(0x241C, &[Entry::ro(0, "Output-stage temperature 0.1 C", I16).live()]),
        Object::var(0x241E, &[Entry::ro(0, "Motor current mA", I16).live()]),
        Object::var(0x2420, &[Entry::ro(0, "Generic status register", U8).live()]),
        Object::var(0x2421, &[Entry::rw(0, "Torque deactivation %", U8).number(125).range(20, 125).stored()]),
        Object::var(0x2422, &[Entry::ro(0, "Torque deactivation state", U8).live()]),
        Object::var(0x2423, &[Entry::ro(0, "Battery voltage 0.01 V", I16).live()]),
        Object::var(0x2450, &[Entry::rw(0, "Inching 2 offset %", U8).number(100).range(10, 100)]),
        Object::var(0x2500, &[Entry::ro(0, "Production date DDMMYYYY", U32).live()]),
        Object::var(0x6040, &[Entry::rw(0, "Controlword", U16).number(0).to_rpdo()]),
        Object::var(0x6041, &[Entry::ro(0, "Statusword", U16).to_tpdo().live()]),
        Object::var(0x6060, &[Entry::rw(0, "Modes of operation", U8).number(1).range(1, 2).stored()]),
        Object::var(0x6064, &[Entry::ro(0, "Position actual value", I32).to_tpdo().live()]),
        Object::var(0x6067, &[Entry::rw(0, "Position window", U16).number(10).range(0, 1000).stored()]),
        Object::var(0x606C, &[Entry::ro(0, "Velocity actual value rpm", I32).to_tpdo().live()]),
        Object::var(
            0x607A,
            &[Entry::rw(0, "Target position", I32).number(0).range(-9_999_999, 9_999_999).to_rpdo()],
        ),
        Object::var(
            0x607C,
            &[Entry::rw(0, "Calibration value", I32).number(0).range(-999_999, 999_999).stored()],
        ),
        Object::array(
            0x607D,
            "Software position limits",
            &[
                Entry::ro(0, "Number of entries", U8).number(2),
                Entry::rw(1, "Limit 2 (lower)", I32).number(-1_000_000).range(-9_999_999, 9_999_999).stored(),
                Entry::rw(2, "Limit 1 (upper)", I32).number(1_000_000).range(-9_999_999, 9_999_999).stored(),
            ],
        ),
        Object::var(0x607E, &[Entry::rw(0, "Polarity", U8).number(0).range(0, 1).stored()]),
        Object::array(
            0x6091,
            "Gear ratio",
            &[
                Entry::ro(0, "Number of entries", U8).number(2),
                Entry::rw(1, "Gear numerator", U16).number(1).range(1, 10_000).stored(),
                Entry::rw(2, "Gear denominator", U16).number(1).range(1, 10_000).stored(),
            ],
        ),
        Object::var(0x60FF, &[Entry::rw(0, "Target velocity rpm", I32).number(0).range(-RPM, RPM).to_rpdo()]),
    ];
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::can_bus::canopen::dictionary::{Access, Limits};
    use crate::can_bus::canopen::{Address, NodeId, check, dictionary};
    use crate::devices::ag03::param::{Model, Quirks};

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
            for ((index, sub), parameter) in PARAMETERS {
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
