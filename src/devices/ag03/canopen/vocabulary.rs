//! What the AG03/1 calls what it says on CANopen.

use super::errors;
use super::objects::{objects, parameter, reading};
use super::words::{CwBit, SwBit};
use crate::can_bus::canopen::{Address, ErrorNames};
use crate::devices::Vocabulary;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param;
use crate::devices::ag03::param::{Gear, Model, Parameter, Reading};
use crate::devices::ag03::profibus::bits;
use crate::devices::ag03::profibus::bits::Word;

/// The words of the AG03/1.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "AG03/1",
    objects: objects(Gear::Ratio24),
    complete: true,
    parameter: entry,
    choice,
    bits,
    errors: ERRORS,
};

/// What it calls its errors.
pub(super) const ERRORS: ErrorNames = ErrorNames {
    emcy: |code, _| errors::meaning(code),
    register: [
        "generic error",
        "current",
        "voltage",
        "temperature",
        "communication",
        "shaft blocked",
        "0",
        "manufacturer",
    ],
};

/// The parameter of the drive that an entry is. Not 6060h: its numbers are other ones.
pub(super) fn entry(at: Address) -> Option<&'static param::Entry> {
    match parameter(at.pair()) {
        Some(Parameter::OperatingMode) => return None,
        Some(parameter) => return Some(parameter.entry()),
        None => {}
    }
    // A target is counted as the position is.
    let pair = if at.pair() == (0x607A, 0) { (0x6064, 0) } else { at.pair() };
    reading(pair).map(Reading::entry)
}

const fn choice(at: Address, number: i64) -> Option<&'static str> {
    match (at.pair(), number) {
        ((0x6060, 0), 1) => Some("positioning mode"),
        ((0x6060, 0), 2) => Some("velocity mode"),
        ((0x2102, 0), 2) => Some("gear 24:1"),
        ((0x2102, 0), 3) => Some("gear 48:1"),
        ((0.., 0..), _) => None,
    }
}

fn bits(at: Address, mode: i64) -> Option<[&'static str; 16]> {
    let mode = if mode == 2 { Mode::Velocity } else { Mode::Positioning };
    let mut names = [""; 16];
    let mut put = |number: u8, name: &'static str| {
        if let Some(place) = names.get_mut(usize::from(number)) {
            *place = name;
        }
    };
    match at.pair() {
        (0x6040, 0) => {
            CwBit::ALL.iter().filter(|bit| bit.acts_in(mode)).for_each(|bit| put(bit.number(), bit.name()))
        }
        (0x6041, 0) => SwBit::ALL.iter().for_each(|bit| put(bit.number(), bit.name_in(mode))),
        (0x1002, 0) => of(Word::Ssw, mode, &mut put),
        (0x2420, 0) => of(Word::GeneralStatus, mode, &mut put),
        (0.., 0..) => return None,
    }
    Some(names)
}

/// The bits of a word that both buses have.
fn of(word: Word, mode: Mode, put: &mut dyn FnMut(u8, &'static str)) {
    for (number, bit) in (0..).zip(bits::bits(word, mode, Some(Model::Ag03_1))) {
        if !bit.key.is_empty() {
            put(number, bit.name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can_bus::canopen::dictionary;
    use crate::devices::ag03::param::on_canopen;

    #[test]
    fn a_parameter_or_reading_is_where_the_dictionary_has_an_entry() {
        for (pair, reading) in on_canopen::READINGS {
            let at = Address::new(pair.0, pair.1);
            let object = dictionary::entry(VOCABULARY.objects, at).unwrap();
            assert_eq!(object.name, reading.on_canopen().name, "{at}");
            assert_eq!(entry(at), Some(reading.entry()));
        }
        assert!(entry(Address::new(0x6060, 0)).is_none());
        assert_eq!(choice(Address::new(0x6060, 0), 2), Some("velocity mode"));
    }

    #[test]
    fn bits_have_the_names_of_the_mode() {
        let names = |index, mode| bits(Address::new(index, 0), mode).unwrap();
        assert_eq!((names(0x6040, 1)[4], names(0x6040, 2)[4]), ("new setpoint", ""));
        assert_eq!((names(0x6041, 1)[12], names(0x6041, 2)[12]), ("setpoint acknowledged", "standstill"));
        assert!(names(0x1002, 1).iter().any(|name| !name.is_empty()));
        assert_eq!(bits(Address::new(0x6064, 0), 1), None);
    }
}
