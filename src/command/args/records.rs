//! What `profidrive master record`, `param` and `im` take.

use core::fmt;
use core::str::FromStr;

use clap::Subcommand;

use crate::host::octets_of_hex;
use crate::profibus::dpv1::base_mode::{Attribute, ParameterAddress};

/// What is done with a record.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum RecordAction {
    /// Reads a record
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 7 record read 1 10")]
    Read {
        /// 0: the station; from 1: its modules
        #[arg(value_parser = clap::value_parser!(u8).range(..255))]
        slot: u8,
        /// The index of the record
        index: u8,
    },
    /// Writes a record
    #[command(
        after_help = "Example:\n  profidrive master --link /tmp/bus --address 7 record write 1 10 01020304"
    )]
    Write {
        /// 0: the station; from 1: its modules
        #[arg(value_parser = clap::value_parser!(u8).range(..255))]
        slot: u8,
        /// The index of the record
        index: u8,
        /// As many octets as it has, hexadecimal: "01 02 FF" or 0102FF
        data: Octets,
    },
}

/// Octets in hexadecimal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Octets(pub(crate) Vec<u8>);

impl FromStr for Octets {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let octets = octets_of_hex(text).filter(|octets| (1..=240).contains(&octets.len()));
        octets.map(Self).ok_or_else(|| {
            "expected 1 to 240 octets, two hexadecimal digits each, such as \"01 02 FF\"".into()
        })
    }
}

/// What is done with parameters.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum ParamAction {
    /// Reads parameters, all in one request
    #[command(
        after_help = "Example:\n  profidrive master --link /tmp/bus --address 7 param read 922 964.0-5"
    )]
    Read {
        /// Number, with a sub-index or several behind a point: 922, 944.1, 964.0-5
        #[arg(value_name = "PNU[.SUB[-LAST]]", required = true)]
        places: Vec<ParamPlace>,
        #[command(flatten)]
        reach: Reach,
    },
    /// Changes parameters, all in one request: each in the format that it has
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 7 param write 927=0")]
    Write {
        /// Number and new value: 927=1, 2900.0=-12.5
        #[arg(value_name = "PNU[.SUB]=VALUE", required = true)]
        changes: Vec<ParamChange>,
        #[command(flatten)]
        reach: Reach,
    },
    /// Reads the descriptions of parameters
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 7 param describe 930")]
    Describe {
        /// Number, with the element of the description behind a point; without: all of it
        #[arg(value_name = "PNU[.SUB[-LAST]]", required = true)]
        places: Vec<ParamPlace>,
        #[command(flatten)]
        reach: Reach,
    },
    /// Reads the texts of parameters
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 7 param text 922.0")]
    Text {
        /// Number, with the text behind a point
        #[arg(value_name = "PNU[.SUB[-LAST]]", required = true)]
        places: Vec<ParamPlace>,
        #[command(flatten)]
        reach: Reach,
    },
}

/// Which drive of the slave.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Reach {
    /// The slot whose record 47 is used
    #[arg(long, default_value = "0", value_name = "N", value_parser = clap::value_parser!(u8).range(..255))]
    pub(crate) slot: u8,
    /// The axis, of a slave with several drives its DO-ID
    #[arg(long, default_value = "0", value_name = "N")]
    pub(crate) axis: u8,
}

/// A parameter, or some elements of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ParamPlace {
    pnu: u16,
    /// The first element and how many.
    elements: Option<(u16, u8)>,
}

impl ParamPlace {
    pub(crate) fn address(self, attribute: Attribute) -> ParameterAddress {
        let (subindex, elements) = match self.elements {
            Some((subindex, 1)) => (subindex, 0),
            Some((subindex, elements)) => (subindex, elements),
            None => (0, 0),
        };
        ParameterAddress { attribute, elements, pnu: self.pnu, subindex }
    }
}

impl FromStr for ParamPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}' is no parameter; expected 922, 944.1 or 964.0-5");
        let (pnu, elements) = match text.split_once('.') {
            Some((pnu, elements)) => (pnu, Some(elements)),
            None => (text, None),
        };
        let pnu = pnu.parse().ok().filter(|pnu| *pnu > 0).ok_or_else(wrong)?;
        let range = |elements: &str| {
            let (first, last) = elements.split_once('-').unwrap_or((elements, elements));
            let (first, last) = (first.parse::<u16>().ok()?, last.parse::<u16>().ok()?);
            let count = u8::try_from(last.checked_sub(first)?.checked_add(1)?).ok()?;
            (count <= 234).then_some((first, count))
        };
        let elements = elements.map(|elements| range(elements).ok_or_else(wrong)).transpose()?;
        Ok(Self { pnu, elements })
    }
}

impl fmt::Display for ParamPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PNU {}", self.pnu)?;
        match self.elements {
            None => Ok(()),
            Some((first, 1)) => write!(f, ".{first}"),
            Some((first, count)) => write!(f, ".{first}-{}", u32::from(first) + u32::from(count) - 1),
        }
    }
}

/// A new value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ParamChange {
    pub(crate) place: ParamPlace,
    pub(crate) value: f64,
}

impl FromStr for ParamChange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}' is no change; expected 927=1 or 2900.0=-12.5");
        let (place, value) = text.split_once('=').ok_or_else(wrong)?;
        let place: ParamPlace = place.parse()?;
        let hexadecimal = value.strip_prefix("0x").map(|digits| u32::from_str_radix(digits, 16));
        let number = match hexadecimal {
            Some(number) => number.ok().map(f64::from),
            None => value.parse().ok().filter(|number: &f64| number.is_finite()),
        };
        let one = place.elements.is_none_or(|(_, count)| count == 1);
        Ok(Self { place, value: number.filter(|_| one).ok_or_else(wrong)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_and_changes_are_read_as_they_are_written() {
        let place = |pnu, elements| ParamPlace { pnu, elements };
        for (text, expected) in [
            ("922", place(922, None)),
            ("944.1", place(944, Some((1, 1)))),
            ("964.0-5", place(964, Some((0, 6)))),
        ] {
            assert_eq!(text.parse(), Ok(expected));
            assert_eq!(expected.to_string(), format!("PNU {text}"));
        }
        for wrong in ["", "0", "x", "1.", "1.5-4", "1.0-234", "65536", "1.a"] {
            assert!(wrong.parse::<ParamPlace>().is_err(), "{wrong}");
        }
        let change: ParamChange = "2900.0=-12.5".parse().unwrap();
        assert_eq!((change.place, change.value), (place(2900, Some((0, 1))), -12.5));
        assert_eq!("927=0x10".parse::<ParamChange>().unwrap().value, 16.0);
        for wrong in ["927", "927=", "927=x", "927=nan", "964.0-5=1", "=1"] {
            assert!(wrong.parse::<ParamChange>().is_err(), "{wrong}");
        }
        assert_eq!("01 fF".parse(), Ok(Octets(vec![1, 255])));
        assert!("".parse::<Octets>().is_err() && "1".parse::<Octets>().is_err());
        let simple = place(922, None).address(Attribute::Value);
        assert_eq!((simple.elements, simple.subindex), (0, 0));
    }
}
