//! The object dictionary of the ASDA-A2, one table for each level of CANopen (P1-01).

use super::links::{LINKS, Link};
use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::value::DataType::{I8, I16, I32, U8, U16, U32};
use crate::can_bus::canopen::{Entry, Object};
use crate::devices::asda_a2::Level;
use crate::devices::asda_a2::on_canopen::Name;
use crate::devices::asda_a2::settings::Keeping;
use crate::devices::asda_a2::stored::STORED;
use crate::face::ObjectEntry;

/// The objects of a level, with the parameters without effect or without them.
pub(super) const fn of(level: Level, stored: bool) -> &'static [Object] {
    match (level, stored) {
        (Level::Half, true) => &HALF,
        (Level::Full, true) => &FULL,
        (Level::Half, false) => &HALF_ALONE,
        (Level::Full, false) => &FULL_ALONE,
    }
}

static HALF: [Object; 105 + STORED.len()] = objects(Level::Half, OTHERS_HALF, &STORED_ENTRIES);
static FULL: [Object; 105 + STORED.len()] = objects(Level::Full, OTHERS_FULL, &STORED_ENTRIES);
static HALF_ALONE: [Object; 105] = objects(Level::Half, OTHERS_HALF, &[]);
static FULL_ALONE: [Object; 105] = objects(Level::Full, OTHERS_FULL, &[]);

const OTHERS_HALF: &[Object] = &others(Level::Half);
const OTHERS_FULL: &[Object] = &others(Level::Full);

/// The entry of each link.
static ENTRIES: [[Entry; 1]; LINKS.len()] = entries();

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn entries() -> [[Entry; 1]; LINKS.len()] {
    let mut entries = [const { [highest(0)] }; LINKS.len()];
    let mut place = 0;
    while place < LINKS.len() {
        entries[place] = [entry(&LINKS[place])];
        place += 1;
    }
    entries
}

static STORED_ENTRIES: [[Entry; 1]; STORED.len()] = stored_entries();

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn stored_entries() -> [[Entry; 1]; STORED.len()] {
    let mut entries = [const { [highest(0)] }; STORED.len()];
    let mut place = 0;
    while place < STORED.len() {
        let ObjectEntry { at: (_, sub), data, name } = STORED[place];
        entries[place] = [Entry::rw(sub, name, data).number(0).to_pdo().stored()];
        place += 1;
    }
    entries
}

/// The settings and the parameters without effect among the other objects, sorted by index.
#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn objects<const N: usize>(
    level: Level,
    others: &[Object],
    stored: &'static [[Entry; 1]],
) -> [Object; N] {
    const END: u16 = u16::MAX;
    let mut objects = [const { Object::array(0, "", &[]) }; N];
    let (mut count, mut other, mut link, mut place) = (0, 0, 0, 0);
    while count < N {
        while link < LINKS.len() && !LINKS[link].is_alone(level) {
            link += 1;
        }
        let a = if other < others.len() { others[other].index.0 } else { END };
        let b = if link < LINKS.len() { LINKS[link].name.object.at.0 } else { END };
        let c = if place < stored.len() { STORED[place].at.0 } else { END };
        if a < b && a < c {
            objects[count] = Object { ..others[other] };
            other += 1;
        } else if b < c {
            objects[count] = Object::var(b, &ENTRIES[link]);
            link += 1;
        } else {
            objects[count] = Object::var(c, &stored[place]);
            place += 1;
        }
        count += 1;
    }
    assert!(other == others.len() && place == stored.len(), "another number of objects");
    objects
}

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

/// The entry of a setting that both levels have alike.
const fn setting(index: u16, sub: u8) -> Entry {
    level_setting(Level::Full, index, sub)
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn level_setting(level: Level, index: u16, sub: u8) -> Entry {
    let mut place = 0;
    while place < LINKS.len() {
        let name = &LINKS[place].name;
        if name.object.at.0 == index && name.object.at.1 == sub && name.is_of(level) {
            return entry(&LINKS[place]);
        }
        place += 1;
    }
    panic!("no setting has this name")
}

/// The entry of a setting: default, limits and keeping are those of the setting, as far as the type goes.
const fn entry(link: &Link) -> Entry {
    let Link { setting, name: Name { object: ObjectEntry { at: (_, sub), data, name }, form, .. } } = *link;
    let entry = Entry::rw(sub, name, data).number(form.of_setting(setting.default()));
    let (low, high) = form.limits(setting.range());
    let (least, most) = match data.range() {
        Some(range) => range,
        None => (low, high),
    };
    let entry = match link.name.within {
        Some(ranges) => entry.ranges(ranges),
        None => entry.range(if low < least { least } else { low }, if high > most { most } else { high }),
    };
    let entry = if link.name.mappable { entry.to_pdo() } else { entry };
    match setting.keeping() {
        Keeping::Volatile => entry,
        Keeping::Stored | Keeping::Reloaded | Keeping::Address => entry.stored(),
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

/// An actual value, with its default where the guide prints one.
macro_rules! actual {
    ($index:literal, $name:literal, $data:ident, $default:literal) => {
        Object::var($index, const { &[Entry::ro(0, $name, $data).number($default).live().to_tpdo()] })
    };
    ($index:literal, $name:literal, $data:ident) => {
        Object::var($index, const { &[Entry::ro(0, $name, $data).live().to_tpdo()] })
    };
}

macro_rules! entries {
    ($($entry:expr),* $(,)?) => { const { &[$($entry),*] } };
}

const OTHERS: usize = 53;

/// The objects that are no setting, and those that hold several.
#[rustfmt::skip]
const fn others(level: Level) -> [Object; OTHERS] {
    [
        Object::var(0x1000, entries![Entry::ro(0, "Device type", U32).number(0x0402_0192)]),
        Object::var(0x1001, entries![Entry::ro(0, "Error register", U8).number(0).node().to_tpdo()]),
        Object::array(0x1003, "Pre-defined error field", entries![
            Entry::rw(0, "Number of errors", U8).number(0).range(0, 5).node(),
            error_field(1), error_field(2), error_field(3), error_field(4), error_field(5),
        ]),
        Object::var(0x1005, entries![Entry::rw(0, "COB-ID SYNC", U32).number(0x80).node().stored()]),
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
            highest(1), setting(0x1029, 1),
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
        actual!(0x603F, "Error code", U16, 0),
        Object::var(0x6040, match level {
            Level::Half => entries![Entry::rw(0, "Controlword", U16).number(0).to_pdo()],
            Level::Full => entries![Entry::rw(0, "Controlword", U16).number(4).to_pdo()],
        }),
        actual!(0x6041, "Statusword", U16, 0),
        actual!(0x6061, "Modes of operation display", I8, 0),
        actual!(0x6062, "Position demand value", I32, 0),
        actual!(0x6063, "Position actual value in increments", I32, 0),
        actual!(0x6064, "Position actual value", I32, 0),
        actual!(0x606B, "Velocity demand value", I32),
        actual!(0x606C, "Velocity actual value", I32),
        actual!(0x6074, "Torque demand value", I16),
        actual!(0x6075, "Motor rated current", U32),
        actual!(0x6076, "Motor rated torque", U32),
        actual!(0x6077, "Torque actual value", I16),
        actual!(0x6078, "Current actual value", I16),
        Object::array(0x607D, "Software position limit", entries![
            highest(2), setting(0x607D, 1), setting(0x607D, 2),
        ]),
        Object::array(0x6093, "Position factor", entries![
            highest(2), setting(0x6093, 1), setting(0x6093, 2),
        ]),
        Object::array(0x6099, "Homing speeds", match level {
            Level::Half => entries![
                highest(2),
                level_setting(Level::Half, 0x6099, 1),
                level_setting(Level::Half, 0x6099, 2),
            ],
            Level::Full => entries![
                highest(2),
                level_setting(Level::Full, 0x6099, 1),
                level_setting(Level::Full, 0x6099, 2),
            ],
        }),
        Object::record(0x60C1, "Interpolation data record", match level {
            Level::Half => entries![
                highest(3),
                level_setting(Level::Half, 0x60C1, 1),
                level_setting(Level::Half, 0x60C1, 2),
                level_setting(Level::Half, 0x60C1, 3),
            ],
            Level::Full => entries![
                highest(2),
                level_setting(Level::Full, 0x60C1, 1),
                level_setting(Level::Full, 0x60C1, 2),
            ],
        }),
        Object::record(0x60C2, "Interpolation time period", entries![
            highest(2), setting(0x60C2, 1), setting(0x60C2, 2),
        ]),
        actual!(0x60F4, "Following error actual value", I32),
        actual!(0x60FC, "Position demand value in increments", I32),
        actual!(0x60FD, "Digital inputs", U32),
        Object::var(0x6502, entries![Entry::ro(0, "Supported drive modes", U32).number(0x6D).to_tpdo()]),
    ]
}
