//! Numbers and formulas with `$NODEID` (`eds.md` 1, Numbers and Formulas).

use core::fmt;

use crate::can_bus::canopen::NodeId;

/// A whole number, or the node-ID and a whole number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Number {
    /// What stands beside `$NODEID`, or alone.
    pub offset: i128,
    /// Whether the node-ID is added.
    pub node_id: bool,
}

impl Number {
    /// Its value at a node.
    pub fn at(self, node: NodeId) -> i128 {
        if self.node_id { self.offset.saturating_add(node.number().into()) } else { self.offset }
    }
}

impl fmt::Display for Number {
    /// `385`, `$NODEID+0x180`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self { offset, node_id: false } => offset.fmt(f),
            Self { offset: 0, node_id: true } => f.write_str("$NODEID"),
            Self { offset, node_id: true } => write!(f, "$NODEID+0x{offset:X}"),
        }
    }
}

/// A number as it was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Written {
    pub(super) number: Number,
    /// Its digits are hexadecimal: the two's complement of a number with sign may be meant.
    pub(super) hexadecimal: bool,
    /// What the author should write otherwise.
    pub(super) odd: Option<&'static str>,
}

/// Reads a number or a formula; `None` if the text is neither.
pub(super) fn read(text: &str) -> Option<Written> {
    let text = text.trim();
    let Some(dollar) = text.find('$') else { return literal(text) };
    let (before, variable) = text.split_at(dollar);
    let end = variable.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '$'));
    let (variable, behind) = variable.split_at(end.unwrap_or(variable.len()));
    let odd_name = if variable.eq_ignore_ascii_case("$NODEID") {
        None
    } else if variable.to_ascii_lowercase().contains("node") {
        Some("the variable is called $NODEID")
    } else {
        return None;
    };
    let (number, odd) = match (before.trim(), behind.trim()) {
        ("", "") => (None, None),
        ("", behind) => (Some(behind.strip_prefix('+')?), None),
        (before, "") => (Some(before.strip_suffix('+')?), Some("$NODEID stands in front: $NODEID+number")),
        (_, _) => return None,
    };
    let number = match number {
        Some(number) => literal(number.trim())?,
        None => literal("0")?,
    };
    let node_id = Number { node_id: true, ..number.number };
    Some(Written { number: node_id, odd: odd_name.or(odd).or(number.odd), ..number })
}

/// Decimal, `0x` hexadecimal, octal with a leading zero, each with a sign.
fn literal(text: &str) -> Option<Written> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    // The digits of an i128 without its sign; from_str_radix takes a sign of its own.
    let whole = |digits: &str, radix| {
        let all = digits.bytes().all(|octet| octet.is_ascii_alphanumeric());
        i128::from_str_radix(digits, radix).ok().filter(|_| all && digits.len() <= 39)
    };
    let hexadecimal = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X"));
    let (number, odd) = match hexadecimal {
        Some(digits) => (whole(digits, 16)?, None),
        None => match digits.strip_prefix('0') {
            Some("") => (0, None),
            Some(octal) if octal.bytes().all(|octet| octet.is_ascii_digit()) => match whole(octal, 8) {
                Some(number) => (number, None),
                None => (whole(octal, 10)?, Some("a leading 0 makes a number octal: write it without")),
            },
            Some(_) | None => match whole(digits, 10) {
                Some(number) => (number, None),
                None => (with_fraction(digits)?, Some("a whole number has no decimal point")),
            },
        },
    };
    let offset = if negative { -number } else { number };
    Some(Written { number: Number { offset, node_id: false }, hexadecimal: hexadecimal.is_some(), odd })
}

/// `0.0`: a whole number all the same.
fn with_fraction(digits: &str) -> Option<i128> {
    let (whole, fraction) = digits.split_once(['.', ','])?;
    let is_whole = fraction.bytes().all(|octet| octet == b'0');
    whole.parse::<u64>().ok().map(i128::from).filter(|_| is_whole && !whole.starts_with('+'))
}

/// Reads a number of IEEE 754: decimal text with point or comma, or `0x` and its bits.
pub(super) fn real(text: &str, octets: usize) -> Option<(f64, Option<&'static str>)> {
    if let Some(Written { number, hexadecimal: true, .. }) = literal(text) {
        let bits = u64::try_from(number.offset).ok()?;
        let value = match octets {
            4 => f32::from_bits(u32::try_from(bits).ok()?).into(),
            _wide => f64::from_bits(bits),
        };
        return Some((value, Some("hexadecimal digits are taken as the bits of the number")));
    }
    let value = text.replacen(',', ".", 1).parse::<f64>().ok()?;
    value.is_finite().then_some((value, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> Option<(i128, bool, bool)> {
        read(text).map(|Written { number, odd, .. }| (number.offset, number.node_id, odd.is_some()))
    }

    #[test]
    fn eds_08_numbers_in_every_form_that_files_have() {
        for (text, expected) in [
            ("385", 385),
            ("0x181", 385),
            ("0X181", 385),
            ("-5", -5),
            ("0", 0),
            ("00", 0),
            ("000", 0),
            ("017", 15),
            ("001", 1),
            ("-0x10", -16),
            ("+7", 7),
            ("0xFFFFFFFFFFFFFFFF", u64::MAX.into()),
        ] {
            assert_eq!(number(text), Some((expected, false, false)), "{text}");
        }
        for (text, expected) in [("08", 8), ("0019", 19), ("0.0", 0), ("12.00", 12), ("3,0", 3)] {
            assert_eq!(number(text), Some((expected, false, true)), "{text}");
        }
        for text in [
            "",
            "-",
            "0x",
            "x",
            "1 2",
            "1.5",
            "0xG",
            "--1",
            "0x-1",
            "1e3",
            "$",
            "0x10000000000000000000000000000000000000000",
        ] {
            assert_eq!(number(text), None, "{text}");
        }
    }

    #[test]
    fn eds_06_formulas_in_every_form_that_files_have() {
        for (text, odd) in [
            ("$NODEID+0x180", false),
            ("$NodeID + 384", false),
            ("$nodeid +0x180", false),
            ("0x180+$NODEID", true),
            ("384 + $NodeId", true),
            ("$MY_NODE_ID+0x180", true),
        ] {
            assert_eq!(number(text), Some((0x180, true, odd)), "{text}");
        }
        assert_eq!(number("$NODEID"), Some((0, true, false)));
        for text in
            ["$NODEID-1", "$NODEID+", "$NODEID 1", "1+$NODEID+1", "$OTHER+1", "2*$NODEID", "$NODEID+$NODEID"]
        {
            assert_eq!(number(text), None, "{text}");
        }
        let node = NodeId::new(5).unwrap();
        assert_eq!(read("$NODEID+0x80000180").unwrap().number.at(node), 0x8000_0185);
        assert_eq!(read("$NODEID+0x180").unwrap().number.to_string(), "$NODEID+0x180");
    }

    #[test]
    fn eds_09_reals_as_text_and_as_bits() {
        assert_eq!(real("1.5", 4), Some((1.5, None)));
        assert_eq!(real("-2,25e1", 8), Some((-22.5, None)));
        assert_eq!(real("0x3FC00000", 4).map(|(value, odd)| (value, odd.is_some())), Some((1.5, true)));
        assert_eq!(real("0x3FF8000000000000", 8).map(|(value, _)| value), Some(1.5));
        for text in ["", "x", "inf", "NaN", "1.5.5"] {
            assert_eq!(real(text, 4), None, "{text}");
        }
    }
}
