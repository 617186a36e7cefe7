//! The value that an entry has after power-up (`eds.md` 2 and 3).

use super::number::{self, Number};
use crate::can_bus::canopen::value::{DataType, ValueKind};
use crate::can_bus::canopen::{NodeId, Value};
use crate::device_file::CodePage;

/// The value of an entry after power-up.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Content {
    /// The file gives none: 0, or nothing where values differ in length.
    #[default]
    None,
    /// A whole number, or one that depends on the node-ID.
    Whole(Number),
    /// A number of IEEE 754.
    Real(f64),
    /// A text, as in the file, or octets.
    Octets(Vec<u8>),
}

impl Content {
    /// The octets on the bus at a node, low octet first.
    pub(super) fn octets(&self, data: DataType, node: NodeId) -> Vec<u8> {
        match self {
            Self::None => data.zero().with_octets(<[u8]>::to_vec),
            Self::Whole(number) => {
                // What does not fit is cut: $NODEID+FFh of an UNSIGNED8.
                let all = number.at(node).to_le_bytes();
                all.get(..data.octets().unwrap_or(0)).unwrap_or_default().to_vec()
            }
            #[expect(clippy::cast_possible_truncation, reason = "to the precision that the type has")]
            Self::Real(number) if data == DataType::Real32 => {
                Value::Real32(*number as f32).with_octets(<[u8]>::to_vec)
            }
            Self::Real(number) => Value::Real64(*number).with_octets(<[u8]>::to_vec),
            Self::Octets(octets) => octets.clone(),
        }
    }

    /// Reads the text of a default that is not blank, with what is odd in it; what cannot be read is none.
    pub(super) fn read(text: &str, data: DataType, page: CodePage) -> (Self, Option<String>) {
        match data.kind() {
            ValueKind::Boolean | ValueKind::Signed | ValueKind::Unsigned => match whole(text, data) {
                Ok((number, odd)) => (Self::Whole(number), odd.map(Into::into)),
                Err(why) => (Self::None, Some(format!("'{text}' {why}: the value is 0"))),
            },
            ValueKind::Real => match number::real(text, data.octets().unwrap_or_default()) {
                Some((number, odd)) => (Self::Real(number), odd.map(Into::into)),
                None => (Self::None, Some(format!("'{text}' is no number: the value is 0"))),
            },
            ValueKind::Text => (Self::Octets(page.encode(text)), None),
            ValueKind::Octets if data == DataType::UnicodeString => {
                (Self::Octets(text.encode_utf16().flat_map(u16::to_le_bytes).collect()), None)
            }
            ValueKind::Octets => octets(text, data, page),
        }
    }
}

/// A whole number of a type; hexadecimal digits may be the two's complement of a number with sign.
pub(super) fn whole(text: &str, data: DataType) -> Result<(Number, Option<&'static str>), &'static str> {
    let written = number::read(text).ok_or("is no number")?;
    let bits = 8 * data.octets().unwrap_or_default();
    let (low, high): (i128, i128) = match data.kind() {
        ValueKind::Boolean => (0, 1),
        ValueKind::Signed => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
        ValueKind::Unsigned | ValueKind::Real | ValueKind::Text | ValueKind::Octets => (0, (1 << bits) - 1),
    };
    let Number { offset, node_id } = written.number;
    let complement = offset.saturating_sub(1 << bits);
    if (low..=high).contains(&offset) {
        Ok((written.number, written.odd))
    } else if written.hexadecimal && data.kind() == ValueKind::Signed && (low..0).contains(&complement) {
        Ok((Number { offset: complement, node_id }, written.odd))
    } else {
        Err("is beyond its type")
    }
}

/// The octets of an OCTET_STRING, a DOMAIN or a time: two hexadecimal digits each.
fn octets(text: &str, data: DataType, page: CodePage) -> (Content, Option<String>) {
    let digits: Vec<u8> = text.bytes().filter(|octet| !octet.is_ascii_whitespace()).collect();
    let nibble = |digit: u8| char::from(digit).to_digit(16).and_then(|nibble| u8::try_from(nibble).ok());
    let pair = |pair: &[u8]| match pair {
        [high, low] => Some(nibble(*high)? << 4 | nibble(*low)?),
        _single => None,
    };
    let octets: Option<Vec<u8>> = digits.chunks(2).map(pair).collect();
    match (octets, data.octets()) {
        (Some(octets), Some(len)) if octets.len() != len => {
            (Content::None, Some(format!("'{text}' has {} octets, expected {len}: they are 0", octets.len())))
        }
        (Some(octets), _) => (Content::Octets(octets), None),
        // Files say 0 for a domain without contents.
        (None, _) if text == "0" => (Content::None, None),
        (None, Some(_)) => (Content::None, Some(format!("'{text}' is no octets in hexadecimal: they are 0"))),
        (None, None) => {
            let odd = format!("'{text}' is no octets in hexadecimal: its characters are the value");
            (Content::Octets(page.encode(text)), Some(odd))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_5(text: &str, data: DataType) -> (Vec<u8>, bool) {
        let (content, odd) = Content::read(text, data, CodePage::Ascii);
        (content.octets(data, NodeId::new(5).unwrap()), odd.is_some())
    }

    #[test]
    fn eds_05_without_a_default_zero_of_its_size() {
        for (data, len) in [
            (DataType::U8, 1),
            (DataType::I24, 3),
            (DataType::Real64, 8),
            (DataType::TimeOfDay, 6),
            (DataType::VisibleString, 0),
        ] {
            assert_eq!(Content::None.octets(data, NodeId::new(1).unwrap()), vec![0; len], "{}", data.name());
        }
    }

    #[test]
    fn eds_08_eds_09_numbers_have_the_octets_of_their_type() {
        for (text, data, octets) in [
            ("0xFFFF", DataType::I16, &[0xFF, 0xFF][..]),
            ("-1", DataType::I24, &[0xFF, 0xFF, 0xFF]),
            ("0x80000000", DataType::I32, &[0, 0, 0, 0x80]),
            ("$NODEID+0x180", DataType::U32, &[0x85, 0x01, 0, 0]),
            ("0xFFFFFFFFFFFFFFFF", DataType::U64, &[0xFF; 8]),
            ("1", DataType::Boolean, &[1]),
            ("1.5", DataType::Real32, &[0, 0, 0xC0, 0x3F]),
            ("1,5", DataType::Real64, &[0, 0, 0, 0, 0, 0, 0xF8, 0x3F]),
            ("0x010203", DataType::U24, &[3, 2, 1]),
        ] {
            assert_eq!(at_5(text, data), (octets.to_vec(), false), "{text}");
        }
        for (text, data, len) in [
            ("256", DataType::U8, 1),
            ("-1", DataType::U16, 2),
            ("40000", DataType::I16, 2),
            ("0x1FFFF", DataType::I16, 2),
            ("on", DataType::Boolean, 1),
            ("-", DataType::Real32, 4),
        ] {
            assert_eq!(at_5(text, data), (vec![0; len], true), "{text}");
        }
    }

    #[test]
    fn eds_10_eds_11_texts_and_octets() {
        assert_eq!(at_5("Pump 7", DataType::VisibleString), (b"Pump 7".to_vec(), false));
        assert_eq!(
            Content::read("f\u{fc}r \u{20AC}", DataType::VisibleString, CodePage::Cp1252).0,
            Content::Octets(b"f\xFCr \x80".to_vec())
        );
        assert_eq!(
            Content::read("f\u{fc}r", DataType::VisibleString, CodePage::Utf8).0,
            Content::Octets(b"f\xC3\xBCr".to_vec())
        );
        assert_eq!(at_5("AB", DataType::UnicodeString), (vec![0x41, 0, 0x42, 0], false));
        assert_eq!(at_5("01 A1 05", DataType::OctetString), (vec![1, 0xA1, 5], false));
        assert_eq!(at_5("0", DataType::Domain), (vec![], false));
        assert_eq!(at_5("text", DataType::OctetString), (b"text".to_vec(), true));
        assert_eq!(at_5("010203040506", DataType::TimeOfDay), (vec![1, 2, 3, 4, 5, 6], false));
        assert_eq!(at_5("01", DataType::TimeOfDay), (vec![0; 6], true));
    }
}
