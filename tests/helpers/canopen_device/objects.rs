//! The object dictionary of the test device: an input and output module after CiA 401, and one object of each kind.

use profidrive::can_bus::canopen::Address;
use profidrive::can_bus::canopen::dictionary::{Entry, Home, Object};
use profidrive::can_bus::canopen::value::DataType::{
    Boolean, Domain, I8, I16, I32, I64, OctetString, Real32, U8, U16, U32, U64, VisibleString,
};

/// Transmission types of TPDOs.
const TPDO_TYPES: &[(i64, i64)] = &[(0, 240), (252, 255)];
/// Transmission types of RPDOs.
const RPDO_TYPES: &[(i64, i64)] = &[(0, 240), (254, 255)];

const fn highest(sub: i64) -> Entry {
    Entry::ro(0, "Highest sub-index supported", U8).number(sub)
}

const fn rpdo(base: u32, off: bool) -> [Entry; 5] {
    [
        highest(5),
        cob_id(base, off),
        Entry::rw(2, "Transmission type", U8).number(255).ranges(RPDO_TYPES).node().stored(),
        Entry::rw(3, "Inhibit time", U16).number(0).node().stored(),
        Entry::rw(5, "Event timer", U16).number(0).node().stored(),
    ]
}

const fn tpdo(base: u32, off: bool) -> [Entry; 6] {
    [
        highest(6),
        cob_id(base, off),
        Entry::rw(2, "Transmission type", U8).number(255).ranges(TPDO_TYPES).node().stored(),
        Entry::rw(3, "Inhibit time", U16).number(0).node().stored(),
        Entry::rw(5, "Event timer", U16).number(0).node().stored(),
        Entry::rw(6, "SYNC start value", U8).number(0).node().stored(),
    ]
}

const fn cob_id(base: u32, off: bool) -> Entry {
    let base = if off { base | 1 << 31 } else { base };
    Entry::rw(1, "COB-ID", U32).node_id(base).node().stored()
}

const fn mapping(mapped: [i64; 4]) -> [Entry; 9] {
    let [a, b, c, d] = mapped;
    let count = (a != 0) as i64 + (b != 0) as i64 + (c != 0) as i64 + (d != 0) as i64;
    [
        Entry::rw(0, "Number of mapped objects", U8).number(count).range(0, 8).node().stored(),
        mapped_entry(1, a),
        mapped_entry(2, b),
        mapped_entry(3, c),
        mapped_entry(4, d),
        mapped_entry(5, 0),
        mapped_entry(6, 0),
        mapped_entry(7, 0),
        mapped_entry(8, 0),
    ]
}

const fn mapped_entry(sub: u8, mapped: i64) -> Entry {
    Entry::rw(sub, "Mapped object", U32).number(mapped).node().stored()
}

/// Sorted by index.
pub(crate) const OBJECTS: &[Object] = &[
    Object::var(0x1000, &[Entry::ro(0, "Device type", U32).number(0x000F_0191)]),
    Object::var(0x1001, &[Entry::ro(0, "Error register", U8).number(0).node().to_tpdo()]),
    Object::var(0x1002, &[Entry::ro(0, "Manufacturer status register", U32).number(0x55AA).live().to_tpdo()]),
    Object::array(
        0x1003,
        "Pre-defined error field",
        &[
            Entry::rw(0, "Number of errors", U8).number(0).range(0, 0).node().stored(),
            Entry::ro(1, "Standard error field", U32).number(0).node().stored(),
            Entry::ro(2, "Standard error field", U32).number(0).node().stored(),
            Entry::ro(3, "Standard error field", U32).number(0).node().stored(),
            Entry::ro(4, "Standard error field", U32).number(0).node().stored(),
        ],
    ),
    Object::var(0x1005, &[Entry::rw(0, "COB-ID SYNC", U32).number(0x80).node().stored()]),
    Object::var(0x1006, &[Entry::rw(0, "Communication cycle period", U32).number(0).node().stored()]),
    Object::var(0x1007, &[Entry::rw(0, "Synchronous window length", U32).number(0).node().stored()]),
    Object::var(
        0x1008,
        &[Entry::constant(0, "Manufacturer device name", VisibleString).text("Plain test node")],
    ),
    Object::var(0x1009, &[Entry::constant(0, "Manufacturer hardware version", VisibleString).text("A1")]),
    Object::var(0x100A, &[Entry::constant(0, "Manufacturer software version", VisibleString).text("1.00")]),
    Object::var(0x100C, &[Entry::rw(0, "Guard time", U16).number(0).node().stored()]),
    Object::var(0x100D, &[Entry::rw(0, "Life time factor", U8).number(0).node().stored()]),
    Object::array(
        0x1010,
        "Store parameters",
        &[
            highest(3),
            Entry::rw(1, "Save all parameters", U32).number(1).node(),
            Entry::rw(2, "Save communication parameters", U32).number(1).node(),
            Entry::rw(3, "Save application parameters", U32).number(1).node(),
        ],
    ),
    Object::array(
        0x1011,
        "Restore default parameters",
        &[
            highest(3),
            Entry::rw(1, "Restore all default parameters", U32).number(1).node(),
            Entry::rw(2, "Restore communication default parameters", U32).number(1).node(),
            Entry::rw(3, "Restore application default parameters", U32).number(1).node(),
        ],
    ),
    Object::var(0x1014, &[Entry::rw(0, "COB-ID EMCY", U32).node_id(0x80).node().stored()]),
    Object::var(0x1015, &[Entry::rw(0, "Inhibit time EMCY", U16).number(0).node().stored()]),
    Object::array(
        0x1016,
        "Consumer heartbeat time",
        &[
            highest(2),
            Entry::rw(1, "Consumer heartbeat time", U32).number(0).range(0, 0x7F_FFFF).node().stored(),
            Entry::rw(2, "Consumer heartbeat time", U32).number(0).range(0, 0x7F_FFFF).node().stored(),
        ],
    ),
    Object::var(0x1017, &[Entry::rw(0, "Producer heartbeat time", U16).number(0).node().stored()]),
    Object::record(
        0x1018,
        "Identity object",
        &[
            highest(4),
            Entry::ro(1, "Vendor-ID", U32).number(0),
            Entry::ro(2, "Product code", U32).number(0x401),
            Entry::ro(3, "Revision number", U32).number(0x0001_0002),
            Entry::ro(4, "Serial number", U32).number(4711).live(),
        ],
    ),
    Object::array(
        0x1029,
        "Error behaviour",
        &[highest(1), Entry::rw(1, "Communication error", U8).number(0).range(0, 2).node().stored()],
    ),
    Object::record(
        0x1200,
        "SDO server parameter",
        &[
            highest(2),
            Entry::ro(1, "COB-ID client to server", U32).node_id(0x600),
            Entry::ro(2, "COB-ID server to client", U32).node_id(0x580),
        ],
    ),
    Object::record(0x1400, "RPDO 1 communication parameter", &rpdo(0x200, false)),
    Object::record(0x1401, "RPDO 2 communication parameter", &rpdo(0x300, false)),
    Object::record(0x1402, "RPDO 3 communication parameter", &rpdo(0x400, true)),
    Object::record(0x1403, "RPDO 4 communication parameter", &rpdo(0x500, true)),
    Object::record(0x1600, "RPDO 1 mapping parameter", &mapping([0x6200_0108, 0x6200_0208, 0, 0])),
    Object::record(
        0x1601,
        "RPDO 2 mapping parameter",
        &mapping([0x6411_0110, 0x6411_0210, 0x6411_0310, 0x6411_0410]),
    ),
    Object::record(0x1602, "RPDO 3 mapping parameter", &mapping([0; 4])),
    Object::record(0x1603, "RPDO 4 mapping parameter", &mapping([0; 4])),
    Object::record(0x1800, "TPDO 1 communication parameter", &tpdo(0x180, false)),
    Object::record(0x1801, "TPDO 2 communication parameter", &tpdo(0x280, false)),
    Object::record(0x1802, "TPDO 3 communication parameter", &tpdo(0x380, true)),
    Object::record(0x1803, "TPDO 4 communication parameter", &tpdo(0x480, true)),
    Object::record(0x1A00, "TPDO 1 mapping parameter", &mapping([0x6000_0108, 0x6000_0208, 0, 0])),
    Object::record(
        0x1A01,
        "TPDO 2 mapping parameter",
        &mapping([0x6401_0110, 0x6401_0210, 0x6401_0310, 0x6401_0410]),
    ),
    Object::record(0x1A02, "TPDO 3 mapping parameter", &mapping([0; 4])),
    Object::record(0x1A03, "TPDO 4 mapping parameter", &mapping([0; 4])),
    Object::var(0x2000, &[Entry::rw(0, "Text", VisibleString).text("Hello World").max_len(64).stored()]),
    Object::var(0x2001, &[Entry::rw(0, "Program", Domain).max_len(200).stored()]),
    Object::var(0x2002, &[Entry::rw(0, "Counter", U64).number(0x0102_0304_0506_0708).stored()]),
    Object::var(0x2003, &[Entry::rw(0, "Energy", I64).number(-1).stored()]),
    Object::var(0x2004, &[Entry::rw(0, "Gain", Real32).stored()]),
    Object::var(0x2005, &[Entry::rw(0, "Switch", Boolean).number(0).range(0, 1).stored()]),
    Object::var(0x2006, &[Entry::rw(0, "Small signed", I8).number(-3).range(-100, 100).stored()]),
    Object::var(0x2007, &[Entry::rw(0, "Signed", I16).number(-300).range(-1000, 1000).to_pdo().stored()]),
    Object::var(
        0x2008,
        &[Entry::rw(0, "Large signed", I32).number(-70000).range(-100_000, 100_000).to_pdo()],
    ),
    Object::var(0x2009, &[Entry::rw(0, "Small", U8).number(7).range(1, 200).to_pdo().stored()]),
    Object::var(0x200A, &[Entry::rw(0, "Word", U16).number(1000).range(10, 60_000).to_pdo().stored()]),
    Object::var(0x200B, &[Entry::rw(0, "Long", U32).number(70_000).range(0, 0x7FFF_FFFF).to_pdo().stored()]),
    Object::var(0x200C, &[Entry::wo(0, "Command", U16)]),
    Object::var(0x200D, &[Entry::rw(0, "Key", OctetString).max_len(6).stored()]),
    Object::var(0x200E, &[Entry::rw(0, "Answered after a key press", U8).number(0)]),
    Object::var(
        0x200F,
        &[Entry::rw(0, "Event timer of TPDO 1", U16).home(Home::Alias(Address::new(0x1800, 5)))],
    ),
    Object::var(0x2010, &[Entry::rw(0, "Set-up", U8).number(1).range(0, 9).pre_operational()]),
    Object::record(
        0x2011,
        "With gaps",
        &[highest(9), Entry::rw(2, "Second", U8).number(2), Entry::rw(9, "Ninth", U8).number(9)],
    ),
    Object::array(
        0x6000,
        "Read input 8-bit",
        &[
            highest(2),
            Entry::ro(1, "Inputs 1 to 8", U8).number(0).live().to_tpdo(),
            Entry::ro(2, "Inputs 9 to 16", U8).number(0).live().to_tpdo(),
        ],
    ),
    Object::array(
        0x6200,
        "Write output 8-bit",
        &[
            highest(2),
            Entry::rw(1, "Outputs 1 to 8", U8).number(0).to_pdo(),
            Entry::rw(2, "Outputs 9 to 16", U8).number(0).to_pdo(),
        ],
    ),
    Object::array(
        0x6401,
        "Read analogue input 16-bit",
        &[
            highest(4),
            Entry::ro(1, "Input 1", I16).number(0).live().to_tpdo(),
            Entry::ro(2, "Input 2", I16).number(0).live().to_tpdo(),
            Entry::ro(3, "Input 3", I16).number(0).live().to_tpdo(),
            Entry::ro(4, "Input 4", I16).number(0).live().to_tpdo(),
        ],
    ),
    Object::array(
        0x6411,
        "Write analogue output 16-bit",
        &[
            highest(4),
            Entry::rw(1, "Output 1", I16).number(0).range(-20_000, 20_000).to_pdo(),
            Entry::rw(2, "Output 2", I16).number(0).range(-20_000, 20_000).to_pdo(),
            Entry::rw(3, "Output 3", I16).number(0).range(-20_000, 20_000).to_pdo(),
            Entry::rw(4, "Output 4", I16).number(0).range(-20_000, 20_000).to_pdo(),
        ],
    ),
];
