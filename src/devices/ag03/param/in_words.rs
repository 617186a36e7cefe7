//! The value of a parameter with its unit, without an allocator.

use core::fmt;

use super::{Entry, Kind, Parameter, Unit};

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
    pub(crate) const fn of_spindle_pitch(pitch: u32) -> Self {
        match pitch {
            0 => Self::Increments,
            _set => Self::HundredthMillimetres,
        }
    }

    /// A position as the drive counts it, with its unit: `-5 inc`, `-0.05 mm`.
    pub(crate) const fn position(self, number: i64) -> Position {
        Position { number, lengths: self }
    }
}

/// A position with its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    number: i64,
    lengths: Lengths,
}

impl Position {
    /// What it counts.
    pub(crate) const fn lengths(self) -> Lengths {
        self.lengths
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.lengths {
            Lengths::Unknown => write!(f, "{} inc or 0.01 mm", self.number),
            Lengths::Increments => write!(f, "{} inc", self.number),
            Lengths::HundredthMillimetres => write!(f, "{} mm", Decimal(self.number, 2)),
        }
    }
}

impl Entry {
    /// A value with its unit, or what it stands for: `2500.00 mm`, `30 rpm`, `2 (positioning)`.
    pub(crate) const fn in_words(&self, number: i64, lengths: Lengths) -> InWords<'_> {
        InWords { entry: self, number, lengths }
    }

    fn is(&self, parameter: Parameter) -> bool {
        matches!(self.kind, Kind::Setting(setting) if setting.parameter == parameter)
    }
}

/// A value of a parameter in words ([`Entry::in_words`]).
#[derive(Clone, Copy, Debug)]
pub(crate) struct InWords<'a> {
    entry: &'a Entry,
    number: i64,
    lengths: Lengths,
}

impl fmt::Display for InWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { entry, number, lengths } = *self;
        match entry.unit {
            Unit::None => write!(f, "{number}"),
            Unit::Percent if entry.is(Parameter::TorqueDeactivation) && number == 125 => {
                f.write_str("125 % (off)")
            }
            Unit::PercentOfAcceleration if entry.is(Parameter::DPos) && number == 101 => {
                f.write_str("101 (as a-Pos)")
            }
            Unit::Percent
            | Unit::PercentOfAcceleration
            | Unit::Rpm
            | Unit::Increments
            | Unit::Milliamperes => {
                write!(f, "{number} {}", entry.unit)
            }
            Unit::Position => lengths.position(number).fmt(f),
            Unit::Window => match lengths {
                Lengths::Unknown => write!(f, "{number} {}", entry.unit),
                Lengths::Increments | Lengths::HundredthMillimetres => {
                    write!(f, "{} or rpm in velocity mode", lengths.position(number))
                }
            },
            Unit::SpindlePitch if number == 0 => f.write_str("0 (positions are increments)"),
            Unit::SpindlePitch => write!(f, "{} mm a turn", Decimal(number, 2)),
            Unit::TenthDegrees => write!(f, "{} degC", Decimal(number, 1)),
            Unit::TenthVolts => write!(f, "{} V", Decimal(number, 1)),
            Unit::HundredthVolts => write!(f, "{} V", Decimal(number, 2)),
            Unit::Bits => write!(f, "{:04X}h", self.bits()),
            Unit::Ascii => write!(f, "{:02X}h", self.bits()),
            Unit::Version => {
                let [.., high, low] = self.bits().to_be_bytes();
                write!(f, "{high:X}.{low:02X}")
            }
            // `DDMMYYYY` in BCD. The manual prints 15072009 for 15 July 2009.
            Unit::Date => {
                let bits = self.bits();
                write!(f, "{:02X}.{:02X}.{:04X}", bits >> 24, bits >> 16 & 0xFF, bits & 0xFFFF)
            }
            Unit::Choice(choices) => {
                let chosen = choices.iter().find(|choice| i64::from(choice.0) == number);
                match chosen {
                    Some((_, meaning)) => write!(f, "{number} ({meaning})"),
                    None => write!(f, "{number}"),
                }
            }
        }
    }
}

impl InWords<'_> {
    /// The value as it is on the bus.
    fn bits(&self) -> u32 {
        let [_, _, _, _, low @ ..] = self.number.to_be_bytes();
        u32::from_be_bytes(low)
    }
}

/// A number with so many decimal places.
struct Decimal(i64, u32);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(number, places) = *self;
        let unit = 10_u64.pow(places);
        let sign = if number < 0 { "-" } else { "" };
        let number = number.unsigned_abs();
        let width = usize::try_from(places).unwrap_or(0);
        write!(f, "{sign}{}.{:0width$}", number / unit, number % unit)
    }
}
