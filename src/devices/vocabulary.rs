//! What a device on CANopen calls what it says, for those who explain its frames: names of objects, of bits, of errors.

use crate::can_bus::canopen::dictionary::{Entry, Object};
use crate::can_bus::canopen::value::DataType::{I8, I32, U8, U16, U32};
use crate::can_bus::canopen::{Address, ErrorNames};
use crate::can_bus::cia402::{Controlword, Mode, Statusword, axis};
use crate::devices::ag03::param;

/// The words of one device.
#[derive(Clone, Copy, Debug)]
pub struct Vocabulary {
    /// Its name for people: `AG03/1`.
    pub name: &'static str,
    /// Its object dictionary.
    pub objects: &'static [Object],
    /// Whether an object that is not in the dictionary does not exist.
    pub complete: bool,
    /// The parameter of the drive that an entry is, with its unit.
    pub parameter: fn(Address) -> Option<&'static param::Entry>,
    /// What a number in an entry stands for.
    pub choice: fn(Address, i64) -> Option<&'static str>,
    /// The names of the bits of an entry in the mode 6060h of its axis, bit 0 first, empty for a bit without one; `None` if it is no
    /// word of bits.
    pub bits: fn(Address, i64) -> Option<[&'static str; 16]>,
    /// What it calls its errors.
    pub errors: ErrorNames,
}

/// What CiA 301 and CiA 402 say of any device: the communication objects, the words of the state machine, and the PDOs 1, 3
/// and 4 of a drive.
pub(crate) const CIA_402: Vocabulary = Vocabulary {
    name: "CiA 402",
    objects: OBJECTS,
    complete: false,
    parameter: |_| None,
    choice: cia_402_choice,
    bits: cia_402_bits,
    errors: ErrorNames::CIA_301,
};

/// The bits of 6040h and 6041h as CiA 402 has them.
pub(crate) fn cia_402_bits(at: Address, mode: i64) -> Option<[&'static str; 16]> {
    let mode = i8::try_from(mode).ok().and_then(Mode::of);
    match (axis::of_first(at.index.0).1, at.sub.0) {
        (0x6040, 0) => Some(Controlword::names(mode)),
        (0x6041, 0) => Some(Statusword::names(mode)),
        (0.., 0..) => None,
    }
}

/// The modes of operation of CiA 402.
pub(crate) fn cia_402_choice(at: Address, number: i64) -> Option<&'static str> {
    if !matches!((axis::of_first(at.index.0).1, at.sub.0), (0x6060 | 0x6061, 0)) {
        return None;
    }
    match i8::try_from(number).ok().and_then(Mode::of)? {
        Mode::ProfilePosition => Some("profile position"),
        Mode::Velocity => Some("velocity"),
        Mode::ProfileVelocity => Some("profile velocity"),
        Mode::ProfileTorque => Some("profile torque"),
        Mode::Homing => Some("homing"),
        Mode::InterpolatedPosition => Some("interpolated position"),
        Mode::CyclicPosition => Some("cyclic synchronous position"),
        Mode::CyclicVelocity => Some("cyclic synchronous velocity"),
        Mode::CyclicTorque => Some("cyclic synchronous torque"),
    }
}

const OBJECTS: &[Object] = &[
    Object::var(0x1000, &[Entry::ro(0, "Device type", U32)]),
    Object::var(0x1001, &[Entry::ro(0, "Error register", U8)]),
    Object::var(0x1002, &[Entry::ro(0, "Manufacturer status register", U32)]),
    Object::var(0x1005, &[Entry::rw(0, "COB-ID SYNC", U32).number(0x80)]),
    Object::var(0x1006, &[Entry::rw(0, "Communication cycle period", U32)]),
    Object::var(0x1007, &[Entry::rw(0, "Synchronous window length", U32)]),
    Object::var(0x100C, &[Entry::rw(0, "Guard time", U16)]),
    Object::var(0x100D, &[Entry::rw(0, "Life time factor", U8)]),
    Object::var(0x1014, &[Entry::rw(0, "COB-ID EMCY", U32).node_id(0x80)]),
    Object::var(0x1015, &[Entry::rw(0, "Inhibit time EMCY", U16)]),
    Object::var(0x1017, &[Entry::rw(0, "Producer heartbeat time", U16)]),
    Object::record(0x1600, "RPDO 1 mapping parameter", const { &mapping([0x6040_0010, 0]) }),
    Object::record(0x1602, "RPDO 3 mapping parameter", const { &mapping([0x6040_0010, 0x607A_0020]) }),
    Object::record(0x1603, "RPDO 4 mapping parameter", const { &mapping([0x6040_0010, 0x60FF_0020]) }),
    Object::record(0x1A00, "TPDO 1 mapping parameter", const { &mapping([0x6041_0010, 0]) }),
    Object::record(0x1A02, "TPDO 3 mapping parameter", const { &mapping([0x6041_0010, 0x6064_0020]) }),
    Object::record(0x1A03, "TPDO 4 mapping parameter", const { &mapping([0x6041_0010, 0x606C_0020]) }),
    Object::var(0x603F, &[Entry::ro(0, "Error code", U16)]),
    Object::var(0x6040, &[Entry::rw(0, "Controlword", U16).to_rpdo()]),
    Object::var(0x6041, &[Entry::ro(0, "Statusword", U16).to_tpdo()]),
    Object::var(0x6060, &[Entry::rw(0, "Modes of operation", I8).to_rpdo()]),
    Object::var(0x6061, &[Entry::ro(0, "Modes of operation display", I8).to_tpdo()]),
    Object::var(0x6064, &[Entry::ro(0, "Position actual value", I32).to_tpdo()]),
    Object::var(0x606C, &[Entry::ro(0, "Velocity actual value", I32).to_tpdo()]),
    Object::var(0x607A, &[Entry::rw(0, "Target position", I32).to_rpdo()]),
    Object::var(0x60FF, &[Entry::rw(0, "Target velocity", I32).to_rpdo()]),
];

const fn mapping([first, second]: [i64; 2]) -> [Entry; 3] {
    [
        Entry::rw(0, "Number of mapped objects", U8).number(if second == 0 { 1 } else { 2 }),
        Entry::rw(1, "Mapping 1", U32).number(first),
        Entry::rw(2, "Mapping 2", U32).number(second),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can_bus::canopen::dictionary;
    use crate::can_bus::canopen::pdo::mapping::MappingWord;

    #[test]
    fn every_mapping_word_names_an_entry_of_the_table() {
        assert!(OBJECTS.is_sorted_by_key(|object| object.index));
        for object in OBJECTS.iter().filter(|object| matches!(object.index.0, 0x1600..=0x1BFF)) {
            for entry in object.entries.iter().filter(|entry| entry.sub.0 > 0) {
                let word = entry.default_value(crate::can_bus::canopen::NodeId::MIN).number().unwrap();
                if word != 0 {
                    let at = MappingWord::decode(word.try_into().unwrap()).at;
                    assert!(dictionary::entry(OBJECTS, at).is_ok(), "{at}");
                }
            }
        }
    }
}
