//! Values of parameters with their unit, as a person reads them.
//!
//! ```
//! use profidrive::explain::value::{Lengths, in_words};
//! use profidrive::devices::ag03::param::{Parameter, Value};
//!
//! let limit = Parameter::Limit1.entry();
//! assert_eq!(in_words(limit, Value::Double(250_000), Lengths::Increments), "250000 inc");
//! assert_eq!(in_words(limit, Value::Double(250_000), Lengths::HundredthMillimetres), "2500.00 mm");
//! ```

use crate::devices::ag03::drive::Fault;
use crate::devices::ag03::param::{Entry, Unit, Value};

pub use crate::devices::ag03::param::Lengths;

/// The value of a parameter with its unit, or what it stands for.
pub fn in_words(entry: &Entry, value: Value, lengths: Lengths) -> String {
    if entry.unit == Unit::Ascii {
        return fault(value.bits());
    }
    entry.in_words(entry.number(value), lengths).to_string()
}

/// An element of the fault buffer, PNU 945: `A (supply voltage too low)`.
pub(crate) fn fault(code: u32) -> String {
    let known = Fault::ALL.into_iter().find(|fault| u32::from(fault.code()) == code);
    match (known, code) {
        (Some(fault), _) => format!("fault {fault}"),
        (None, 0) => "no fault".into(),
        (None, 0x48 | 0x49) => format!("{code:02X}h (a fault of the CANopen drive)"),
        (None, _) => format!("{code:02X}h (no fault code)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::ag03::param::{Model, Parameter, Pnu, entry};

    #[test]
    fn every_unit_has_its_way_to_be_written() {
        for (pnu, value, words) in [
            (918, Value::Word(5), "5"),
            (930, Value::Word(2), "2 (positioning mode)"),
            (930, Value::Word(7), "7"),
            (945, Value::Word(0x41), "fault A (supply voltage too low)"),
            (945, Value::Word(0), "no fault"),
            (945, Value::Word(0x48), "48h (a fault of the CANopen drive)"),
            (965, Value::Word(0x0101), "1.01"),
            (1003, Value::Word(50), "50 % of 4 rev/s^2"),
            (1004, Value::Word(30), "30 rpm"),
            (1012, Value::Word(0), "0 (positions are increments)"),
            (1012, Value::Word(200), "2.00 mm a turn"),
            (1016, Value::Double(0xFFF0_BDC0), "-1000000 inc or 0.01 mm"),
            (1020, Value::Word(0x2948), "2948h"),
            (1023, Value::Word(800), "800 inc"),
            (1027, Value::Word(0xFFF6), "-1.0 degC"),
            (1029, Value::Word(250), "250 mA"),
            (1032, Value::Word(125), "125 % (off)"),
            (1032, Value::Word(20), "20 %"),
            (1033, Value::Double(1_234_567), "1234567"),
            (1034, Value::Double(0x1507_2009), "15.07.2009"),
            (1039, Value::Word(101), "101 (as a-Pos)"),
            (1039, Value::Word(100), "100 % of 4 rev/s^2"),
            (1040, Value::Word(240), "24.0 V"),
            (1042, Value::Word(305), "3.05 V"),
        ] {
            let entry = entry(Model::Ag03_1, Pnu::new(pnu).unwrap()).unwrap();
            assert_eq!(in_words(entry, value, Lengths::Unknown), words, "PNU {pnu}");
        }
    }

    #[test]
    fn positions_follow_the_spindle_pitch() {
        let limit = Parameter::Limit1.entry();
        let window = Parameter::PosWindow.entry();
        for (lengths, position, width) in [
            (Lengths::Unknown, "-5 inc or 0.01 mm", "10 inc, 0.01 mm or rpm"),
            (Lengths::Increments, "-5 inc", "10 inc or rpm in velocity mode"),
            (Lengths::HundredthMillimetres, "-0.05 mm", "0.10 mm or rpm in velocity mode"),
        ] {
            assert_eq!(in_words(limit, Value::Double(0xFFFF_FFFB), lengths), position);
            assert_eq!(in_words(window, Value::Word(10), lengths), width);
        }
    }
}
