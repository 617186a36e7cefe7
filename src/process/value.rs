//! Values in octets. Words are big-endian, as on the wire.
//!
//! ```text
//! bitN                   bit N of the octet, 0 = lowest
//! unsigned8/16/32        1, 2, 4 octets
//! signed8/16/32          the same in two's complement
//! float32                4 octets, IEEE 754
//! ```

use core::fmt;
use core::str::FromStr;

use thiserror::Error;

/// How octets are read as a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueType {
    /// A bit of an octet, 0..=7.
    Bit(u8),
    /// An octet.
    Unsigned8,
    /// Two octets.
    Unsigned16,
    /// Four octets.
    Unsigned32,
    /// An octet in two's complement.
    Signed8,
    /// Two octets in two's complement.
    Signed16,
    /// Four octets in two's complement.
    Signed32,
    /// Four octets, IEEE 754.
    Float32,
}

/// Why a value cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ValueError {
    /// The slot has too few octets.
    #[error("{kind} at octet {offset} needs {needed} octets, the slot has {got}")]
    Outside {
        /// What was to be written.
        kind: ValueType,
        /// Where, from 0.
        offset: usize,
        /// Octets needed, those before it included.
        needed: usize,
        /// Octets of the slot.
        got: usize,
    },
    /// The value does not fit.
    #[error("{got} does not fit, expected {least} to {most}")]
    Range {
        /// The least value.
        least: f64,
        /// The greatest value.
        most: f64,
        /// The value.
        got: f64,
    },
    /// A whole number is needed.
    #[error("{got} is no whole number, as {kind} needs")]
    NotWhole {
        /// What was to be written.
        kind: ValueType,
        /// The value.
        got: f64,
    },
}

impl ValueType {
    /// Every type but the bits, with its name.
    const NAMES: [(&'static str, Self); 7] = [
        ("unsigned8", Self::Unsigned8),
        ("unsigned16", Self::Unsigned16),
        ("unsigned32", Self::Unsigned32),
        ("signed8", Self::Signed8),
        ("signed16", Self::Signed16),
        ("signed32", Self::Signed32),
        ("float32", Self::Float32),
    ];

    /// Every type.
    #[cfg(test)]
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        (0..8).map(Self::Bit).chain(Self::NAMES.map(|(_, kind)| kind))
    }

    /// How many octets it has.
    pub(crate) const fn octets(self) -> usize {
        match self {
            Self::Bit(_) | Self::Unsigned8 | Self::Signed8 => 1,
            Self::Unsigned16 | Self::Signed16 => 2,
            Self::Unsigned32 | Self::Signed32 | Self::Float32 => 4,
        }
    }

    /// The least and the greatest value.
    pub(crate) const fn range(self) -> (f64, f64) {
        match self {
            Self::Bit(_) => (0.0, 1.0),
            Self::Unsigned8 => (0.0, u8::MAX as f64),
            Self::Unsigned16 => (0.0, u16::MAX as f64),
            Self::Unsigned32 => (0.0, u32::MAX as f64),
            Self::Signed8 => (i8::MIN as f64, i8::MAX as f64),
            Self::Signed16 => (i16::MIN as f64, i16::MAX as f64),
            Self::Signed32 => (i32::MIN as f64, i32::MAX as f64),
            Self::Float32 => (f32::MIN as f64, f32::MAX as f64),
        }
    }

    /// The value at an offset; `None` if the octets are not there. A bit is 0 or 1.
    pub(crate) fn read(self, octets: &[u8], offset: usize) -> Option<f64> {
        let field = octets.get(offset..)?.get(..self.octets())?;
        let word = field.iter().fold(0_u32, |word, octet| word << 8 | u32::from(*octet));
        let unsigned = f64::from(word);
        let signed = |bits: u32| f64::from((word << (32 - bits)).cast_signed() >> (32 - bits));
        Some(match self {
            Self::Bit(bit) => f64::from(word >> bit.min(7) & 1),
            Self::Unsigned8 | Self::Unsigned16 | Self::Unsigned32 => unsigned,
            Self::Signed8 => signed(8),
            Self::Signed16 => signed(16),
            Self::Signed32 => signed(32),
            Self::Float32 => f32::from_bits(word).into(),
        })
    }

    /// Writes a value at an offset and keeps all other bits.
    ///
    /// # Errors
    /// [`ValueError`]; nothing is written then.
    pub(crate) fn write(self, octets: &mut [u8], offset: usize, value: f64) -> Result<(), ValueError> {
        let bits = self.bits(value)?;
        let got = octets.len();
        let needed = offset.saturating_add(self.octets());
        let field = octets.get_mut(offset..).and_then(|rest| rest.get_mut(..self.octets()));
        let field = field.ok_or(ValueError::Outside { kind: self, offset, needed, got })?;
        let mask = self.mask();
        for (place, octet) in field.iter_mut().rev().enumerate() {
            let part = |word: u32| word.to_le_bytes().get(place).copied().unwrap_or(0);
            *octet = (*octet & !part(mask)) | part(bits);
        }
        Ok(())
    }

    /// The unsigned integer of so many octets: 1, 2 or 4.
    pub(crate) const fn of_octets(octets: usize) -> Self {
        match octets {
            ..=1 => Self::Unsigned8,
            2 => Self::Unsigned16,
            3.. => Self::Unsigned32,
        }
    }

    /// The nearest value that it can hold; 0 for what is no number.
    pub(crate) fn nearest(self, value: f64) -> f64 {
        let (least, most) = self.range();
        match self {
            _ if value.is_nan() => 0.0,
            Self::Float32 => value.clamp(least, most),
            Self::Bit(_)
            | Self::Unsigned8
            | Self::Unsigned16
            | Self::Unsigned32
            | Self::Signed8
            | Self::Signed16
            | Self::Signed32 => libm::round(value).clamp(least, most),
        }
    }

    /// The bits of its octets that are its own, as a big-endian word.
    pub(crate) const fn mask(self) -> u32 {
        match self {
            Self::Bit(bit) => 1 << if bit < 8 { bit } else { 7 },
            Self::Unsigned8 | Self::Signed8 => 0xFF,
            Self::Unsigned16 | Self::Signed16 => 0xFFFF,
            Self::Unsigned32 | Self::Signed32 | Self::Float32 => 0xFFFF_FFFF,
        }
    }

    /// Its bits in the octets of a slot, from the lowest of the first octet on.
    pub(crate) const fn places(self, offset: usize) -> core::ops::Range<usize> {
        let first = offset.saturating_mul(8);
        match self {
            Self::Bit(bit) => first + bit as usize..first + bit as usize + 1,
            Self::Unsigned8
            | Self::Signed8
            | Self::Unsigned16
            | Self::Signed16
            | Self::Unsigned32
            | Self::Signed32
            | Self::Float32 => first..first + self.octets() * 8,
        }
    }

    /// The value as bits within its mask.
    fn bits(self, value: f64) -> Result<u32, ValueError> {
        let (least, most) = self.range();
        if !(least..=most).contains(&value) {
            return Err(ValueError::Range { least, most, got: value });
        }
        if let Self::Float32 = self {
            return Ok(single(value).to_bits());
        }
        if libm::trunc(value) != value {
            return Err(ValueError::NotWhole { kind: self, got: value });
        }
        let word = whole(value);
        Ok(match self {
            Self::Bit(bit) => word << bit.min(7),
            Self::Unsigned8
            | Self::Unsigned16
            | Self::Unsigned32
            | Self::Signed8
            | Self::Signed16
            | Self::Signed32
            | Self::Float32 => word & self.mask(),
        })
    }
}

#[expect(clippy::cast_possible_truncation, reason = "within the range of f32: the nearest one is wanted")]
const fn single(value: f64) -> f32 {
    value as f32
}

/// The low 32 bits of a whole number of -2^31 to 2^32 - 1 in two's complement.
#[expect(clippy::cast_possible_truncation, reason = "the low bits are wanted")]
const fn whole(value: f64) -> u32 {
    (value as i64).cast_unsigned() as u32
}

impl fmt::Display for ValueType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Self::Bit(bit) = self {
            return write!(f, "bit{bit}");
        }
        let name = Self::NAMES.iter().find(|(_, kind)| kind == self).map(|(name, _)| *name);
        f.write_str(name.unwrap_or_default())
    }
}

/// No name of a type.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "'{0}' is no type; expected bit0 to bit7, unsigned8, unsigned16, unsigned32, signed8, signed16, signed32 or float32"
)]
pub struct NoValueType(String);

impl FromStr for ValueType {
    type Err = NoValueType;

    fn from_str(name: &str) -> Result<Self, NoValueType> {
        let bit = name.strip_prefix("bit").and_then(|bit| bit.parse().ok()).filter(|bit| *bit < 8);
        let named = Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind);
        named.or(bit.map(Self::Bit)).ok_or_else(|| NoValueType(name.into()))
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use ValueType::{Bit, Float32, Signed8, Signed16, Signed32, Unsigned8, Unsigned16, Unsigned32};

    #[test]
    fn golden_octets_of_every_type_and_the_bits_of_others_are_kept() {
        for (kind, value, ones, zeros) in [
            (Bit(0), 0.0, [0xFF, 0xFE, 0xFF, 0xFF, 0xFF], [0; 5]),
            (Bit(7), 1.0, [0xFF; 5], [0, 0x80, 0, 0, 0]),
            (Unsigned8, 200.0, [0xFF, 0xC8, 0xFF, 0xFF, 0xFF], [0, 0xC8, 0, 0, 0]),
            (Unsigned16, 4660.0, [0xFF, 0x12, 0x34, 0xFF, 0xFF], [0, 0x12, 0x34, 0, 0]),
            (Unsigned32, 4_294_967_295.0, [0xFF; 5], [0, 0xFF, 0xFF, 0xFF, 0xFF]),
            (Signed8, -2.0, [0xFF, 0xFE, 0xFF, 0xFF, 0xFF], [0, 0xFE, 0, 0, 0]),
            (Signed16, -2.0, [0xFF, 0xFF, 0xFE, 0xFF, 0xFF], [0, 0xFF, 0xFE, 0, 0]),
            (Signed32, -2_147_483_648.0, [0xFF, 0x80, 0, 0, 0], [0, 0x80, 0, 0, 0]),
            (Float32, -1.5, [0xFF, 0xBF, 0xC0, 0, 0], [0, 0xBF, 0xC0, 0, 0]),
        ] {
            for (start, expected) in [(0xFF, ones), (0, zeros)] {
                let mut octets = [start; 5];
                kind.write(&mut octets, 1, value).unwrap();
                assert_eq!(octets, expected, "{kind}");
                assert_eq!(kind.read(&octets, 1), Some(value), "{kind}");
            }
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_and_changes_nothing() {
        for (kind, offset, value, words) in [
            (Unsigned8, 0, 256.0, "256 does not fit, expected 0 to 255"),
            (Signed16, 0, -32769.0, "-32769 does not fit, expected -32768 to 32767"),
            (Bit(3), 0, 2.0, "2 does not fit, expected 0 to 1"),
            (Unsigned8, 0, f64::NAN, "NaN does not fit, expected 0 to 255"),
            (Unsigned16, 0, 0.5, "0.5 is no whole number, as unsigned16 needs"),
            (Unsigned32, 1, 0.0, "unsigned32 at octet 1 needs 5 octets, the slot has 4"),
            (
                Bit(0),
                usize::MAX,
                0.0,
                "bit0 at octet 18446744073709551615 needs 18446744073709551615 octets, the slot has 4",
            ),
        ] {
            let mut octets = [7; 4];
            assert_eq!(kind.write(&mut octets, offset, value).unwrap_err().to_string(), words);
            assert_eq!(octets, [7; 4]);
        }
        assert!(Float32.write(&mut [0; 4], 0, f64::INFINITY).is_err());
        assert_eq!(Signed8.read(&[0; 4], 4), None);
        for name in ["bit8", "bit", "word", "", "Signed8"] {
            assert!(name.parse::<ValueType>().is_err(), "{name}");
        }
    }

    #[test]
    fn the_nearest_value_always_fits() {
        for kind in [Bit(1), Unsigned8, Signed8, Unsigned16, Signed16, Unsigned32, Signed32, Float32] {
            for value in [f64::NAN, f64::INFINITY, -1e300, 0.4, 127.6, -3.5] {
                assert_eq!(kind.write(&mut [0; 4], 0, kind.nearest(value)), Ok(()), "{kind} {value}");
            }
        }
        assert_eq!((Signed8.nearest(1.6), Unsigned8.nearest(-1.0)), (2.0, 0.0));
    }
}
