//! Values of parameters with their unit, as a person reads them.
//!
//! ```
//! use profidrive::explain::value::{Lengths, in_words};
//! use profidrive::param::{Parameter, Value};
//!
//! let limit = Parameter::Limit1.entry();
//! assert_eq!(in_words(limit, Value::Double(250_000), Lengths::Increments), "250000 inc");
//! assert_eq!(in_words(limit, Value::Double(250_000), Lengths::HundredthMillimetres), "2500.00 mm");
//! ```

use std::format;
use std::string::{String, ToString};

use crate::drive::Fault;
use crate::param::{Entry, Kind, Parameter, Unit, Value};

/// What a drive counts positions in: PNU 1012, spindle pitch, decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Lengths {
    /// Not known.
    #[default]
    Unknown,
    /// Increments, 1600 per turn of the output shaft: the spindle pitch is 0.
    Increments,
    /// 0.01 mm: a spindle pitch is set.
    HundredthMillimetres,
}

impl Lengths {
    /// What a drive with this spindle pitch (PNU 1012) counts positions in.
    pub const fn of_spindle_pitch(pitch: u32) -> Self {
        match pitch {
            0 => Self::Increments,
            _set => Self::HundredthMillimetres,
        }
    }

    /// A position as the drive counts it, with its unit.
    pub fn position(self, number: i64) -> String {
        match self {
            Self::Unknown => format!("{number} inc or 0.01 mm"),
            Self::Increments => format!("{number} inc"),
            Self::HundredthMillimetres => format!("{} mm", decimal(number, 2)),
        }
    }
}

/// The value of a parameter with its unit, or what it stands for.
pub fn in_words(entry: &Entry, value: Value, lengths: Lengths) -> String {
    let number = entry.number(value);
    match entry.unit {
        Unit::None => number.to_string(),
        Unit::Percent if is(entry, Parameter::TorqueDeactivation) && number == 125 => "125 % (off)".into(),
        Unit::PercentOfAcceleration if is(entry, Parameter::DPos) && number == 101 => "101 (as a-Pos)".into(),
        Unit::Percent | Unit::PercentOfAcceleration | Unit::Rpm | Unit::Increments | Unit::Milliamperes => {
            format!("{number} {}", entry.unit)
        }
        Unit::Position => lengths.position(number),
        Unit::Window => match lengths {
            Lengths::Unknown => format!("{number} {}", entry.unit),
            Lengths::Increments | Lengths::HundredthMillimetres => {
                format!("{} or rpm in velocity mode", lengths.position(number))
            }
        },
        Unit::SpindlePitch if number == 0 => "0 (positions are increments)".into(),
        Unit::SpindlePitch => format!("{} mm a turn", decimal(number, 2)),
        Unit::TenthDegrees => format!("{} degC", decimal(number, 1)),
        Unit::TenthVolts => format!("{} V", decimal(number, 1)),
        Unit::HundredthVolts => format!("{} V", decimal(number, 2)),
        Unit::Bits => format!("{:04X}h", value.bits()),
        Unit::Ascii => fault(value.bits()),
        Unit::Version => {
            let [.., high, low] = value.bits().to_be_bytes();
            format!("{high:X}.{low:02X}")
        }
        Unit::Date => date(value.bits()),
        Unit::Choice(choices) => {
            let chosen = choices.iter().find(|choice| i64::from(choice.0) == number);
            match chosen {
                Some((_, meaning)) => format!("{number} ({meaning})"),
                None => number.to_string(),
            }
        }
    }
}

/// An element of the fault buffer, PNU 945: `A (supply voltage too low)`.
pub fn fault(code: u32) -> String {
    let known = Fault::ALL.into_iter().find(|fault| u32::from(fault.code()) == code);
    match (known, code) {
        (Some(fault), _) => format!("fault {fault}"),
        (None, 0) => "no fault".into(),
        (None, 0x48 | 0x49) => format!("{code:02X}h (a fault of the CANopen drive)"),
        (None, _) => format!("{code:02X}h (no fault code)"),
    }
}

/// `DDMMYYYY` in BCD. The manual prints 15072009 for 15 July 2009.
fn date(bcd: u32) -> String {
    let digits = format!("{bcd:08X}");
    match (digits.get(..2), digits.get(2..4), digits.get(4..)) {
        (Some(day), Some(month), Some(year)) => format!("{day}.{month}.{year}"),
        (_, _, _) => digits,
    }
}

/// `number` with `places` decimal places.
fn decimal(number: i64, places: u32) -> String {
    let unit = 10_u64.pow(places);
    let sign = if number < 0 { "-" } else { "" };
    let number = number.unsigned_abs();
    let width = usize::try_from(places).unwrap_or(0);
    format!("{sign}{}.{:0width$}", number / unit, number % unit)
}

fn is(entry: &Entry, parameter: Parameter) -> bool {
    matches!(entry.kind, Kind::Setting(setting) if setting.parameter == parameter)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::param::{Model, Pnu, entry};

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
