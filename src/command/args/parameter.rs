//! A parameter by number or by name.

use core::str::FromStr;

use crate::devices::ag03::param::{Entry, Subindex, TABLE};
use crate::host::list::named::find;

/// A parameter of either model, and an element if it is an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ParameterSpec {
    pub(crate) entry: &'static Entry,
    pub(crate) element: Option<Subindex>,
}

impl FromStr for ParameterSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (entry, element) = find(TABLE.iter(), text)?;
        Ok(Self { entry, element: element.map(Subindex) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pnu(text: &str) -> Result<(u16, Option<u8>), String> {
        let spec: ParameterSpec = text.parse()?;
        Ok((spec.entry.pnu.number(), spec.element.map(|element| element.0)))
    }

    #[test]
    fn a_parameter_is_its_number_or_its_name_however_written() {
        for (text, found) in [
            ("1004", (1004, None)),
            ("v-Pos", (1004, None)),
            ("VPOS", (1004, None)),
            ("limit 1", (1016, None)),
            ("limit_2", (1017, None)),
            ("0x3EC", (1004, None)),
            ("3ech", (1004, None)),
            ("3B1h.2", (945, Some(2))),
            ("945.9", (945, Some(9))),
            ("fault-buffer.0", (945, Some(0))),
        ] {
            assert_eq!(pnu(text), Ok(found), "{text}");
        }
        for entry in TABLE {
            let suffix = if entry.elements.is_some() { ".0" } else { "" };
            assert_eq!(pnu(&format!("{}{suffix}", entry.name)).map(|found| found.0), Ok(entry.pnu.number()));
        }
    }

    #[test]
    fn what_is_no_parameter_is_answered_with_those_close_to_it() {
        for (text, says) in [
            ("999", "there is no parameter 999; near it are 1000 Controller parameter P"),
            ("2048", "there is no parameter 2048; near it are 1042 Battery voltage"),
            ("0x3E7", "there is no parameter 999; near it are 1000"),
            ("v-Poss", "close to it are 1004 v-Pos"),
            ("limit", "close to it are 1016 Limit 1, 1017 Limit 2"),
            ("tempreature", "1027 Device temperature"),
            ("", "there is no parameter ''"),
            ("945", "is an array of 10; name the element, for example 945.0"),
            ("945.10", "has the elements 0 to 9, not 10"),
            ("945.x", "has the elements 0 to 9, not x"),
            ("1004.1", "is no array; leave '.1' out"),
        ] {
            let error = pnu(text).unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
