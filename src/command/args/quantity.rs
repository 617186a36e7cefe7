//! A number with a unit behind it, as a person writes it: `800`, `800inc`, `8.25mm`, `60rpm`, `0x1F4`.

use core::fmt;
use core::str::FromStr;

/// A number that was written, and its unit if one was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quantity {
    /// Thousandths, so that `8.25` is a number too.
    thousandths: i64,
    /// One of [`UNITS`].
    unit: Option<&'static str>,
}

/// The units that people write.
const UNITS: [&str; 5] = ["inc", "mm", "rpm", "%", "mA"];

impl FromStr for Quantity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "'{text}' is no number; expected a number such as 60, -250000 or 0x1F4, a unit may follow: 8.25mm, 800inc, 60rpm"
            )
        };
        let known = UNITS.into_iter().find_map(|unit| {
            let number = text.strip_suffix(unit).filter(|number| !number.contains("0x"))?;
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
            Some(unit) => write!(f, " {unit}"),
            None => Ok(()),
        }
    }
}

impl Quantity {
    /// The unit, if one was written.
    pub(crate) const fn unit(&self) -> Option<&'static str> {
        self.unit
    }

    /// The number of what counts in one of these units, `name`.
    ///
    /// # Errors
    /// Another unit, or a fraction of its smallest step.
    pub(crate) fn number_in(&self, name: &str, units: &[&str]) -> Result<i64, String> {
        if let Some(unit) = self.unit.filter(|unit| !units.contains(unit)) {
            let expected = if units.is_empty() { "no unit".into() } else { units.join(" or ") };
            return Err(format!("{name} has not the unit {unit}; expected {expected}, got {self}"));
        }
        self.steps().map_err(|line| format!("{name}: {line}"))
    }

    /// The number of a position.
    ///
    /// # Errors
    /// As [`Quantity::number_in`].
    pub(crate) fn position(&self) -> Result<i32, String> {
        match self.unit {
            None | Some("inc" | "mm") => {
                let steps = self.steps()?;
                i32::try_from(steps)
                    .map_err(|_| format!("a position is from {} to {}, got {self}", i32::MIN, i32::MAX))
            }
            Some(_) => Err(format!("a position is in inc or mm, got {self}")),
        }
    }

    /// Without a unit: for what has none here.
    ///
    /// # Errors
    /// There is a unit or a fraction.
    pub(crate) fn plain(&self) -> Result<i64, String> {
        match self.unit {
            None => self.steps(),
            Some(unit) => Err(format!("a value is given without unit here; leave {unit} out of {self}")),
        }
    }

    /// A number without unit, with what is behind the point.
    ///
    /// # Errors
    /// There is a unit.
    pub(crate) fn number(&self) -> Result<f64, String> {
        match self.unit {
            None => Ok(self.thousandths as f64 / 1000.0),
            Some(unit) => Err(format!("a value is given without unit here; leave {unit} out of {self}")),
        }
    }

    /// In steps of its unit, of 0.01 mm if these are millimetres.
    fn steps(&self) -> Result<i64, String> {
        let (step, name) = match self.unit {
            Some("mm") => (10, "0.01 mm"),
            None | Some(_) => (1000, "1"),
        };
        if self.thousandths % step != 0 {
            return Err(format!("the smallest step is {name}, got {self}"));
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
        let lengths = &["inc", "mm"][..];
        for (text, units, number) in [
            ("250000", lengths, Ok(250_000)),
            ("-800inc", lengths, Ok(-800)),
            ("8.25mm", lengths, Ok(825)),
            ("8 mm", lengths, Ok(800)),
            ("8.125mm", lengths, Err("x: the smallest step is 0.01 mm, got 8.125 mm")),
            ("0x1F4", lengths, Ok(500)),
            ("-0x10", lengths, Ok(-16)),
            ("2.5", lengths, Err("x: the smallest step is 1, got 2.5")),
            ("60rpm", &["rpm"], Ok(60)),
            ("60mm", &["rpm"], Err("x has not the unit mm; expected rpm, got 60 mm")),
            ("4mm", &["mm"], Ok(400)),
            ("1inc", &[], Err("x has not the unit inc; expected no unit, got 1 inc")),
        ] {
            assert_eq!(quantity(text).number_in("x", units), number.map_err(str::to_owned), "{text}");
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
    fn a_position_has_its_units_and_a_plain_number_none() {
        assert_eq!(quantity("8mm").position(), Ok(800));
        assert!(quantity("8rpm").position().is_err() && quantity("8mm").plain().is_err());
        assert!(quantity("99999999999").position().is_err());
    }
}
