//! A number with a unit behind it, as a person writes it: `800`, `800inc`, `8.25mm`, `60rpm`, `0x1F4`.

use core::fmt;
use core::str::FromStr;

use crate::devices::ag03::param::{Entry, Parameter, Unit};
use crate::explain::value::Lengths;

/// A number that was written, and its unit if one was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quantity {
    /// Thousandths, so that `8.25` is a number too.
    thousandths: i64,
    unit: Option<Written>,
}

/// The units that people write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Written {
    Increments,
    Millimetres,
    Rpm,
    Percent,
    Milliamperes,
}

impl Written {
    const ALL: [(&'static str, Self); 5] = [
        ("inc", Self::Increments),
        ("mm", Self::Millimetres),
        ("rpm", Self::Rpm),
        ("%", Self::Percent),
        ("mA", Self::Milliamperes),
    ];

    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, unit)| *unit == self).map_or("", |(name, _)| name)
    }
}

impl FromStr for Quantity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "'{text}' is no number; expected a number such as 60, -250000 or 0x1F4, a unit may follow: 8.25mm, 800inc, 60rpm"
            )
        };
        let known = Written::ALL.into_iter().find_map(|(name, unit)| {
            let number = text.strip_suffix(name).filter(|number| !number.contains("0x"))?;
            Some((number.trim_end(), unit))
        });
        let (number, unit) = known.map_or((text, None), |(number, unit)| (number, Some(unit)));
        let (sign, size) = number.strip_prefix('-').map_or((1, number), |size| (-1, size));
        let thousandths = match size.strip_prefix("0x") {
            Some(digits) => hexadecimal(digits).map(|size| i64::from(size) * 1000),
            None => decimal(size),
        };
        let thousandths = thousandths.ok_or_else(expected)? * sign;
        Ok(Self { thousandths, unit })
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.thousandths < 0 { "-" } else { "" };
        let (whole, fraction) =
            (self.thousandths.unsigned_abs() / 1000, self.thousandths.unsigned_abs() % 1000);
        write!(f, "{sign}{whole}")?;
        if fraction != 0 {
            write!(f, ".{}", format!("{fraction:03}").trim_end_matches('0'))?;
        }
        match self.unit {
            Some(unit) => write!(f, " {}", unit.name()),
            None => Ok(()),
        }
    }
}

impl Quantity {
    /// The number of the parameter.
    ///
    /// # Errors
    /// Another unit than that of the parameter, or a fraction of its smallest step.
    pub(crate) fn number_of(&self, entry: &Entry) -> Result<i64, String> {
        let name = format!("{} (PNU {})", entry.name, entry.pnu);
        let units: &[Written] = match entry.unit {
            Unit::Percent | Unit::PercentOfAcceleration => &[Written::Percent],
            Unit::Rpm => &[Written::Rpm],
            Unit::Position => &[Written::Increments, Written::Millimetres],
            Unit::Window => &[Written::Increments, Written::Millimetres, Written::Rpm],
            Unit::Increments => &[Written::Increments],
            Unit::SpindlePitch => &[Written::Millimetres],
            Unit::Milliamperes => &[Written::Milliamperes],
            Unit::None
            | Unit::TenthDegrees
            | Unit::TenthVolts
            | Unit::HundredthVolts
            | Unit::Bits
            | Unit::Ascii
            | Unit::Version
            | Unit::Date
            | Unit::Choice(_) => &[],
        };
        if let Some(unit) = self.unit.filter(|unit| !units.contains(unit)) {
            let units: Vec<_> = units.iter().map(|unit| unit.name()).collect();
            let expected = if units.is_empty() { "no unit".into() } else { units.join(" or ") };
            return Err(format!(
                "{name} has not the unit {}; expected {expected}, got {}",
                unit.name(),
                self
            ));
        }
        self.steps().map_err(|line| format!("{name}: {line}"))
    }

    /// The number of a position.
    ///
    /// # Errors
    /// As [`Quantity::number_of`].
    pub(crate) fn position(&self) -> Result<i32, String> {
        match self.unit {
            None | Some(Written::Increments | Written::Millimetres) => {
                let steps = self.steps()?;
                i32::try_from(steps)
                    .map_err(|_| format!("a position is from {} to {}, got {}", i32::MIN, i32::MAX, self))
            }
            Some(Written::Rpm | Written::Percent | Written::Milliamperes) => {
                Err(format!("a position is in inc or mm, got {}", self))
            }
        }
    }

    /// Whether a drive that counts positions in `lengths` takes it.
    ///
    /// # Errors
    /// It counts in another unit.
    pub(crate) fn fits(&self, lengths: Lengths) -> Result<(), String> {
        let pitch = Parameter::SpindlePitch.entry().pnu;
        match (self.unit, lengths) {
            (Some(Written::Millimetres), Lengths::Increments) => Err(format!(
                "the drive counts positions in increments, because its spindle pitch (PNU {pitch}) is 0; give inc, or write \
                 the pitch first; got {self}"
            )),
            (Some(Written::Increments), Lengths::HundredthMillimetres) => Err(format!(
                "the drive counts positions in 0.01 mm, because its spindle pitch (PNU {pitch}) is set; give mm, got {self}"
            )),
            (Some(_) | None, Lengths::Increments | Lengths::HundredthMillimetres | Lengths::Unknown) => {
                Ok(())
            }
        }
    }

    /// Without a unit: for what has none here.
    ///
    /// # Errors
    /// There is a unit or a fraction.
    pub(crate) fn plain(&self) -> Result<i64, String> {
        match self.unit {
            None => self.steps(),
            Some(unit) => {
                Err(format!("a value is given without unit here; leave {} out of {}", unit.name(), self))
            }
        }
    }

    /// A number without unit, with what is behind the point.
    ///
    /// # Errors
    /// There is a unit.
    pub(crate) fn number(&self) -> Result<f64, String> {
        match self.unit {
            None => Ok(self.thousandths as f64 / 1000.0),
            Some(unit) => {
                Err(format!("a value is given without unit here; leave {} out of {}", unit.name(), self))
            }
        }
    }

    /// In steps of its unit, of 0.01 mm if these are millimetres.
    fn steps(&self) -> Result<i64, String> {
        let (step, name) = match self.unit {
            Some(Written::Millimetres) => (10, "0.01 mm"),
            None | Some(Written::Increments | Written::Rpm | Written::Percent | Written::Milliamperes) => {
                (1000, "1")
            }
        };
        if self.thousandths % step != 0 {
            return Err(format!("the smallest step is {name}, got {}", self));
        }
        Ok(self.thousandths / step)
    }
}

fn decimal(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
    if !digits(whole) || !digits(fraction) || whole.len() > 12 || fraction.len() > 3 {
        return None;
    }
    let whole: i64 = whole.parse().ok()?;
    let fraction: i64 = format!("{fraction:0<3}").parse().ok()?;
    Some(whole * 1000 + fraction)
}

fn hexadecimal(digits: &str) -> Option<u32> {
    u32::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(text: &str) -> Quantity {
        text.parse().unwrap()
    }

    #[test]
    fn a_number_may_have_its_unit() {
        for (text, parameter, number) in [
            ("250000", Parameter::Limit1, Ok(250_000)),
            ("-800inc", Parameter::Limit2, Ok(-800)),
            ("8.25mm", Parameter::Limit1, Ok(825)),
            ("8 mm", Parameter::Limit1, Ok(800)),
            ("8.125mm", Parameter::Limit1, Err("the smallest step is 0.01 mm, got 8.125 mm")),
            ("0x1F4", Parameter::Limit1, Ok(500)),
            ("-0x10", Parameter::Limit1, Ok(-16)),
            ("2.5", Parameter::Limit1, Err("the smallest step is 1, got 2.5")),
            ("60rpm", Parameter::VPos, Ok(60)),
            ("60mm", Parameter::VPos, Err("has not the unit mm; expected rpm, got 60 mm")),
            ("4mm", Parameter::SpindlePitch, Ok(400)),
            ("1inc", Parameter::OperatingMode, Err("expected no unit, got 1 inc")),
        ] {
            let got = quantity(text).number_of(parameter.entry());
            match number {
                Ok(number) => assert_eq!(got, Ok(number), "{text}"),
                Err(says) => assert!(got.as_ref().is_err_and(|line| line.contains(says)), "{text}: {got:?}"),
            }
        }
        for wrong in [
            "",
            "mm",
            "five",
            "--5",
            "-",
            "0x",
            "0x100000000",
            "0x10mm",
            "1e3",
            "1.2345",
            "8 m",
            "+5",
            "0x+5",
        ] {
            assert!(wrong.parse::<Quantity>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_drive_takes_the_unit_that_it_counts_in() {
        let (pitch, none) = (Lengths::HundredthMillimetres, Lengths::Increments);
        assert_eq!(quantity("8mm").position(), Ok(800));
        assert!(quantity("8mm").fits(pitch).is_ok() && quantity("8inc").fits(none).is_ok());
        assert!(quantity("8").fits(pitch).is_ok() && quantity("8").fits(none).is_ok());
        assert!(quantity("8mm").fits(none).is_err_and(|line| line.contains("spindle pitch")));
        assert!(quantity("8inc").fits(pitch).is_err_and(|line| line.contains("give mm")));
        assert!(quantity("8rpm").position().is_err() && quantity("8mm").plain().is_err());
        assert!(quantity("99999999999").position().is_err());
    }
}
