//! The object dictionary of the ASDA-A2, one table for each level of CANopen (P1-01).

use super::links::Link;
use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::value::DataType;
use crate::can_bus::canopen::value::DataType::{I8, I16, I32, U8, U16, U32};
use crate::can_bus::canopen::{Address, Entry, Object};
use crate::devices::asda_a2::settings::Keeping;
use crate::devices::asda_a2::{Level, Setting};

/// The objects of a level.
pub(super) const fn of(level: Level) -> &'static [Object] {
    match level {
        Level::Half => &HALF,
        Level::Full => &FULL,
    }
}

static HALF: [Object; COUNT] = objects(Level::Half);
static FULL: [Object; COUNT] = objects(Level::Full);

/// Transmission types; 241 to 253 are not offered (CN-203).
const TYPES: &[(i64, i64)] = &[(0, 240), (254, 255)];

/// What the electronic data sheet says besides the objects.
pub const SHEET: Sheet<'static> = Sheet {
    file_name: "asda-a2.eds",
    file_version: 1,
    file_revision: 0,
    description: "Emulated servo drive Delta ASDA-A2",
    time: "08:00AM",
    date: "11-22-2026",
    created_by: "profidrive",
    vendor_name: "Delta Electronics (emulated)",
    vendor_number: VENDOR,
    product_name: "ASDA-A2",
    product_number: PRODUCT,
    revision_number: 0,
    order_code: "ASD-A2",
    kilobits: &[125, 250, 500, 1000],
    granularity: 8,
};

/// 1018h:1.
const VENDOR: u32 = 0x1DD;
/// 1018h:2.
const PRODUCT: u32 = 0x6000;

const fn highest(sub: i64) -> Entry {
    Entry::ro(0, "Highest sub-index", U8).number(sub)
}

/// An entry that is a setting: default, limits and keeping are those of the setting, as far as the type goes.
const fn setting(index: u16, sub: u8, name: &'static str, data: DataType) -> Entry {
    level_setting(Level::Full, index, sub, name, data)
}

const fn level_setting(level: Level, index: u16, sub: u8, name: &'static str, data: DataType) -> Entry {
    let Some(link) = Link::of(level, Address::new(index, sub)) else {
        panic!("no setting is linked to this entry")
    };
    let setting = link.setting();
    let entry = Entry::rw(sub, name, data).number(link.of_setting(setting.default())).to_pdo();
    let (low, high) = limits(level, link);
    let (least, most) = match data.range() {
        Some(range) => range,
        None => (low, high),
    };
    let entry = entry.range(if low < least { least } else { low }, if high > most { most } else { high });
    match setting.keeping() {
        Keeping::Volatile => entry,
        Keeping::Stored | Keeping::Reloaded | Keeping::Address => entry.stored(),
    }
}

/// The limits of an entry in its own unit. Homing speeds of half CANopen are in rpm (CN-225); 60C0h = -2 is for half.
const fn limits(level: Level, link: Link) -> (i64, i64) {
    let (low, high) = link.setting().range();
    match (link, level) {
        (Link::Whole(Setting::HomingSpeedSwitch | Setting::HomingSpeedZero), Level::Half) => (low, high / 10),
        (Link::Whole(Setting::InterpolationSubMode), Level::Full) => (-1, high),
        (Link::Whole(_) | Link::Rates, _) => (low, high),
        (Link::Tenth(_), _) => (low / 10, high / 10),
        (Link::Shutdown, _) => (-1, 0),
        (Link::LowWord(_) | Link::HighWord(_), _) => (0, 0xFFFF),
    }
}

const fn rpdo(base: u32) -> [Entry; 6] {
    [
        highest(5),
        Entry::rw(1, "COB-ID", U32).node_id(base).node().stored(),
        Entry::rw(2, "Reception type", U8).number(0).ranges(TYPES).node().stored(),
        Entry::rw(3, "Inhibit time", U16).number(0).node().stored(),
        Entry::rw(4, "Compatibility entry", U8).number(0).node().stored(),
        Entry::rw(5, "Event timer", U16).number(0).node().stored(),
    ]
}

const fn tpdo(base: u32) -> [Entry; 6] {
    [
        highest(5),
        Entry::rw(1, "COB-ID", U32).node_id(base).node().stored(),
        Entry::rw(2, "Transmission type", U8).number(0).ranges(TYPES).node().stored(),
        Entry::rw(3, "Inhibit time", U16).number(0).node().stored(),
        Entry::rw(4, "Reserved", U8).number(0).node().stored(),
        Entry::rw(5, "Event timer", U16).number(0).node().stored(),
    ]
}

const fn mapped(sub: u8) -> Entry {
    Entry::rw(sub, "Mapping entry", U32).number(0).node().stored()
}

const MAPPING: &[Entry] = &[
    Entry::rw(0, "Number of mapped objects", U8).number(0).range(0, 8).node().stored(),
    mapped(1),
    mapped(2),
    mapped(3),
    mapped(4),
    mapped(5),
    mapped(6),
    mapped(7),
    mapped(8),
];

const fn error_field(sub: u8) -> Entry {
    Entry::ro(sub, "Standard error field", U32).number(0).node()
}

/// An object of one entry that is a setting.
macro_rules! var {
    ($index:literal, $name:literal, $data:ident) => {
        Object::var($index, const { &[setting($index, 0, $name, $data)] })
    };
}

/// The same, not to be mapped into PDOs.
macro_rules! unmapped {
    ($index:literal, $name:literal, $data:ident) => {
        Object::var($index, const { &[fixed(setting($index, 0, $name, $data))] })
    };
}

const fn fixed(entry: Entry) -> Entry {
    Entry { mapping: crate::can_bus::canopen::dictionary::Mapping::No, ..entry }
}

/// An actual value.
macro_rules! actual {
    ($index:literal, $name:literal, $data:ident) => {
        Object::var($index, const { &[Entry::ro(0, $name, $data).live().to_tpdo()] })
    };
}

macro_rules! entries {
    ($($entry:expr),* $(,)?) => { const { &[$($entry),*] } };
}

const COUNT: usize = 103;

#[rustfmt::skip]
const fn objects(level: Level) -> [Object; COUNT] {
    [
        Object::var(0x1000, entries![Entry::ro(0, "Device type", U32).number(0x0402_0192)]),
        Object::var(0x1001, entries![Entry::ro(0, "Error register", U8).number(0).node().to_tpdo()]),
        Object::array(0x1003, "Pre-defined error field", entries![
            Entry::rw(0, "Number of errors", U8).number(0).range(0, 5).node(),
            error_field(1), error_field(2), error_field(3), error_field(4), error_field(5),
        ]),
        Object::var(0x1005, entries![Entry::rw(0, "COB-ID SYNC", U32).number(0x80).node().stored()]),
        unmapped!(0x1006, "Communication cycle period", U32),
        Object::var(0x100C, entries![Entry::rw(0, "Guard time", U16).number(0).node().stored()]),
        Object::var(0x100D, entries![Entry::rw(0, "Life time factor", U8).number(0).node().stored()]),
        Object::array(0x1010, "Store parameters", entries![
            highest(1), Entry::rw(1, "Save all parameters", U32).number(1).node(),
        ]),
        Object::array(0x1011, "Restore default parameters", entries![
            highest(1), Entry::rw(1, "Restore all defaults", U32).number(1).node(),
        ]),
        Object::var(0x1014, entries![Entry::ro(0, "COB-ID EMCY", U32).node_id(0x80).node()]),
        Object::array(0x1016, "Consumer heartbeat time", entries![
            highest(1),
            Entry::rw(1, "Consumer heartbeat time", U32).number(0).range(0, 0x7F_FFFF).node().stored(),
        ]),
        Object::var(0x1017, entries![Entry::rw(0, "Producer heartbeat time", U16).number(0).node().stored()]),
        Object::record(0x1018, "Identity object", entries![
            highest(3),
            Entry::ro(1, "Vendor ID", U32).number(VENDOR as i64),
            Entry::ro(2, "Product code", U32).number(PRODUCT as i64),
            // The guide gives no revision.
            Entry::ro(3, "Revision number", U32).number(0),
        ]),
        Object::array(0x1029, "Error behaviour", entries![
            highest(1), fixed(setting(0x1029, 1, "Communication error", U8)),
        ]),
        Object::record(0x1200, "SDO server parameter", entries![
            highest(2),
            Entry::ro(1, "COB-ID client to server", U32).node_id(0x600),
            Entry::ro(2, "COB-ID server to client", U32).node_id(0x580),
        ]),
        Object::record(0x1400, "RPDO 1 communication parameter", const { &rpdo(0x200) }),
        Object::record(0x1401, "RPDO 2 communication parameter", const { &rpdo(0x300) }),
        Object::record(0x1402, "RPDO 3 communication parameter", const { &rpdo(0x400) }),
        Object::record(0x1403, "RPDO 4 communication parameter", const { &rpdo(0x500) }),
        Object::record(0x1600, "RPDO 1 mapping parameter", MAPPING),
        Object::record(0x1601, "RPDO 2 mapping parameter", MAPPING),
        Object::record(0x1602, "RPDO 3 mapping parameter", MAPPING),
        Object::record(0x1603, "RPDO 4 mapping parameter", MAPPING),
        Object::record(0x1800, "TPDO 1 communication parameter", const { &tpdo(0x180) }),
        Object::record(0x1801, "TPDO 2 communication parameter", const { &tpdo(0x280) }),
        Object::record(0x1802, "TPDO 3 communication parameter", const { &tpdo(0x380) }),
        Object::record(0x1803, "TPDO 4 communication parameter", const { &tpdo(0x480) }),
        Object::record(0x1A00, "TPDO 1 mapping parameter", MAPPING),
        Object::record(0x1A01, "TPDO 2 mapping parameter", MAPPING),
        Object::record(0x1A02, "TPDO 3 mapping parameter", MAPPING),
        Object::record(0x1A03, "TPDO 4 mapping parameter", MAPPING),
        var!(0x2101, "P1-01 control mode", I16),
        var!(0x2120, "P1-32 stop mode", I16),
        var!(0x2122, "P1-34 acceleration time in ms", I16),
        var!(0x2123, "P1-35 deceleration time in ms", I16),
        var!(0x2124, "P1-36 slope time in ms", I16),
        var!(0x2126, "P1-38 zero speed in 0.1 rpm", I16),
        var!(0x212C, "P1-44 gear numerator", I32),
        var!(0x212D, "P1-45 gear denominator", I32),
        var!(0x212F, "P1-47 speed reached in rpm", I16),
        var!(0x2131, "P1-49 speed reached time in ms", I16),
        var!(0x2137, "P1-55 maximum speed in rpm", I16),
        var!(0x2208, "P2-08 special write", I16),
        Object::var(0x2223, entries![
            setting(0x2223, 0, "P2-35 excessive deviation in PUU", I32).range(1, i32::MAX as i64),
        ]),
        var!(0x2300, "P3-00 node number", I16),
        var!(0x2301, "P3-01 rates", I16),
        var!(0x2309, "P3-09 SYNC adjustment", I16),
        var!(0x230A, "P3-10 CANopen enable", I16),
        var!(0x230B, "P3-11 CANopen options", I16),
        var!(0x230C, "P3-12 quick stop options", I16),
        actual!(0x603F, "Error code", U16),
        Object::var(0x6040, match level {
            Level::Half => entries![Entry::rw(0, "Controlword", U16).number(0).to_pdo()],
            Level::Full => entries![Entry::rw(0, "Controlword", U16).number(4).to_pdo()],
        }),
        actual!(0x6041, "Statusword", U16),
        unmapped!(0x605B, "Shutdown option code", I16),
        unmapped!(0x605E, "Fault reaction option code", I16),
        Object::var(0x6060, entries![
            setting(0x6060, 0, "Modes of operation", I8).ranges(&[(0, 1), (3, 4), (6, 7)]),
        ]),
        actual!(0x6061, "Modes of operation display", I8),
        actual!(0x6062, "Position demand value", I32),
        actual!(0x6063, "Position actual value in increments", I32),
        actual!(0x6064, "Position actual value", I32),
        var!(0x6065, "Following error window", U32),
        var!(0x6067, "Position window", U32),
        var!(0x6068, "Position window time", U16),
        actual!(0x606B, "Velocity demand value", I32),
        actual!(0x606C, "Velocity actual value", I32),
        var!(0x606D, "Velocity window", U16),
        var!(0x606E, "Velocity window time", U16),
        var!(0x606F, "Velocity threshold", U16),
        var!(0x6071, "Target torque", I16),
        actual!(0x6074, "Torque demand value", I16),
        actual!(0x6075, "Motor rated current", U32),
        actual!(0x6076, "Motor rated torque", U32),
        actual!(0x6077, "Torque actual value", I16),
        actual!(0x6078, "Current actual value", I16),
        var!(0x607A, "Target position", I32),
        var!(0x607C, "Home offset", I32),
        Object::array(0x607D, "Software position limit", entries![
            highest(2), setting(0x607D, 1, "Reverse", I32), setting(0x607D, 2, "Forward", I32),
        ]),
        var!(0x607F, "Max profile velocity", U32),
        var!(0x6080, "Max motor speed", U32),
        var!(0x6081, "Profile velocity", U32),
        var!(0x6083, "Profile acceleration", U32),
        var!(0x6084, "Profile deceleration", U32),
        var!(0x6085, "Quick stop deceleration", U32),
        var!(0x6086, "Motion profile type", I16),
        var!(0x6087, "Torque slope", U32),
        Object::array(0x6093, "Position factor", entries![
            highest(2), setting(0x6093, 1, "Numerator", U32), setting(0x6093, 2, "Feed constant", U32),
        ]),
        var!(0x6098, "Homing method", I8),
        Object::array(0x6099, "Homing speeds", match level {
            Level::Half => entries![
                highest(2),
                level_setting(Level::Half, 0x6099, 1, "Speed for switch", U32),
                level_setting(Level::Half, 0x6099, 2, "Speed for zero", U32),
            ],
            Level::Full => entries![
                highest(2),
                level_setting(Level::Full, 0x6099, 1, "Speed for switch", U32),
                level_setting(Level::Full, 0x6099, 2, "Speed for zero", U32),
            ],
        }),
        var!(0x609A, "Homing acceleration", U32),
        var!(0x60B0, "Position offset", I32),
        var!(0x60B1, "Velocity offset", I32),
        var!(0x60B2, "Torque offset", I16),
        Object::var(0x60C0, match level {
            Level::Half => entries![level_setting(Level::Half, 0x60C0, 0, "Interpolation sub mode select", I16)],
            Level::Full => entries![level_setting(Level::Full, 0x60C0, 0, "Interpolation sub mode select", I16)],
        }),
        Object::record(0x60C1, "Interpolation data record", match level {
            Level::Half => entries![
                highest(3),
                level_setting(Level::Half, 0x60C1, 1, "Position, low word", U16),
                level_setting(Level::Half, 0x60C1, 2, "Position, high word", U16),
                level_setting(Level::Half, 0x60C1, 3, "Symmetrical difference", I16),
            ],
            Level::Full => entries![
                highest(2),
                level_setting(Level::Full, 0x60C1, 1, "Position", I32),
                level_setting(Level::Full, 0x60C1, 2, "Symmetrical difference", I16),
            ],
        }),
        Object::record(0x60C2, "Interpolation time period", entries![
            highest(2), setting(0x60C2, 1, "Time units", U8), setting(0x60C2, 2, "Time index", I8),
        ]),
        var!(0x60C5, "Max acceleration", U32),
        var!(0x60C6, "Max deceleration", U32),
        var!(0x60F2, "Positioning option code", U16),
        actual!(0x60F4, "Following error actual value", I32),
        actual!(0x60FC, "Position demand value in increments", I32),
        actual!(0x60FD, "Digital inputs", U32),
        var!(0x60FF, "Target velocity", I32),
        Object::var(0x6502, entries![Entry::ro(0, "Supported drive modes", U32).number(0x6D).to_tpdo()]),
    ]
}
