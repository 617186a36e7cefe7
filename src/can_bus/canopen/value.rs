//! Values of objects and their octets, low octet first (`canopen-link.md` 8).

use core::fmt;

/// What the values of a type are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ValueKind {
    /// True or false.
    Boolean,
    /// A whole number with sign.
    Signed,
    /// A whole number without sign.
    Unsigned,
    /// A number of IEEE 754.
    Real,
    /// Characters.
    Text,
    /// Octets without a meaning that is known here.
    Octets,
}

impl ValueKind {
    /// Whether its values are whole numbers; a BOOLEAN is 0 or 1.
    pub(crate) const fn is_whole(self) -> bool {
        matches!(self, Self::Boolean | Self::Signed | Self::Unsigned)
    }
}

/// `/// Text` `Variant = number, "NAME", ValueKind, octets of a value (0: they differ);`
macro_rules! data_types {
    ($($(#[$doc:meta])* $data:ident = $number:literal, $name:literal, $kind:ident, $octets:literal;)*) => {
        /// The type of an entry.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum DataType {
            $($(#[$doc])* $data,)*
        }

        impl DataType {
            /// The number of the type in dictionaries and EDS files.
            pub const fn number(self) -> u16 {
                match self {
                    $(Self::$data => $number,)*
                }
            }

            /// The type with that number.
            pub(crate) const fn of_number(number: u16) -> Option<Self> {
                match number {
                    $($number => Some(Self::$data),)*
                    _other => None,
                }
            }

            /// Its name in CiA 301.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$data => $name,)*
                }
            }

            /// What its values are.
            pub const fn kind(self) -> ValueKind {
                match self {
                    $(Self::$data => ValueKind::$kind,)*
                }
            }

            /// Octets of a value, `None` where values differ in length.
            pub const fn octets(self) -> Option<usize> {
                match self {
                    $(Self::$data => if $octets == 0 { None } else { Some($octets) },)*
                }
            }
        }
    };
}

data_types! {
    /// 1 bit, sent as one octet 0 or 1.
    Boolean = 0x01, "BOOLEAN", Boolean, 1;
    /// 8 bits with sign.
    I8 = 0x02, "INTEGER8", Signed, 1;
    /// 16 bits with sign.
    I16 = 0x03, "INTEGER16", Signed, 2;
    /// 32 bits with sign.
    I32 = 0x04, "INTEGER32", Signed, 4;
    /// 8 bits.
    U8 = 0x05, "UNSIGNED8", Unsigned, 1;
    /// 16 bits.
    U16 = 0x06, "UNSIGNED16", Unsigned, 2;
    /// 32 bits.
    U32 = 0x07, "UNSIGNED32", Unsigned, 4;
    /// IEEE 754, 32 bits.
    Real32 = 0x08, "REAL32", Real, 4;
    /// Characters 20h to 7Eh, without terminator.
    VisibleString = 0x09, "VISIBLE_STRING", Text, 0;
    /// Octets.
    OctetString = 0x0A, "OCTET_STRING", Octets, 0;
    /// UTF-16, low octet first, without terminator.
    UnicodeString = 0x0B, "UNICODE_STRING", Octets, 0;
    /// Milliseconds since midnight (28 bits) and days since 1 January 1984 (16 bits).
    TimeOfDay = 0x0C, "TIME_OF_DAY", Octets, 6;
    /// Milliseconds (28 bits) and days (16 bits).
    TimeDifference = 0x0D, "TIME_DIFFERENCE", Octets, 6;
    /// Octets of a program or a file.
    Domain = 0x0F, "DOMAIN", Octets, 0;
    /// 24 bits with sign.
    I24 = 0x10, "INTEGER24", Signed, 3;
    /// IEEE 754, 64 bits.
    Real64 = 0x11, "REAL64", Real, 8;
    /// 40 bits with sign.
    I40 = 0x12, "INTEGER40", Signed, 5;
    /// 48 bits with sign.
    I48 = 0x13, "INTEGER48", Signed, 6;
    /// 56 bits with sign.
    I56 = 0x14, "INTEGER56", Signed, 7;
    /// 64 bits with sign.
    I64 = 0x15, "INTEGER64", Signed, 8;
    /// 24 bits.
    U24 = 0x16, "UNSIGNED24", Unsigned, 3;
    /// 40 bits.
    U40 = 0x18, "UNSIGNED40", Unsigned, 5;
    /// 48 bits.
    U48 = 0x19, "UNSIGNED48", Unsigned, 6;
    /// 56 bits.
    U56 = 0x1A, "UNSIGNED56", Unsigned, 7;
    /// 64 bits.
    U64 = 0x1B, "UNSIGNED64", Unsigned, 8;
}

impl DataType {
    /// The lowest and the highest value of a whole number, `None` for other types and for an UNSIGNED64.
    pub const fn range(self) -> Option<(i64, i64)> {
        match (self.kind(), self.octets()) {
            (ValueKind::Boolean, _) => Some((0, 1)),
            (ValueKind::Signed, Some(octets)) => {
                Some((i64::MIN >> (64 - 8 * octets), i64::MAX >> (64 - 8 * octets)))
            }
            (ValueKind::Unsigned, Some(octets)) if octets < 8 => Some((0, i64::MAX >> (63 - 8 * octets))),
            (
                ValueKind::Signed
                | ValueKind::Unsigned
                | ValueKind::Real
                | ValueKind::Text
                | ValueKind::Octets,
                _,
            ) => None,
        }
    }

    /// Zeros, as many as a value has; where values differ in length none.
    pub(crate) fn zero(self) -> Value<'static> {
        const ZEROS: &[u8] = &[0; 8];
        let octets = self.octets().and_then(|len| ZEROS.get(..len)).unwrap_or_default();
        self.decode(octets).unwrap_or(Value::Octets(octets))
    }

    /// The value that `octets` are, `None` if their number is wrong for the type. Of a BOOLEAN bit 0 counts.
    pub fn decode(self, octets: &[u8]) -> Option<Value<'_>> {
        if self.octets().is_some_and(|expected| expected != octets.len()) {
            return None;
        }
        let low = || octets.iter().rev().fold(0, |number, octet| number << 8 | u64::from(*octet));
        Some(match self.kind() {
            ValueKind::Boolean | ValueKind::Unsigned => Value::whole(self, low().cast_signed())?,
            ValueKind::Signed => {
                let unused = u32::try_from(octets.len())
                    .ok()?
                    .checked_mul(8)
                    .and_then(|bits| 64_u32.checked_sub(bits))?;
                Value::whole(self, low().checked_shl(unused)?.cast_signed() >> unused)?
            }
            ValueKind::Real => match octets.try_into() {
                Ok(octets) => Value::Real32(f32::from_le_bytes(octets)),
                Err(_) => Value::Real64(f64::from_le_bytes(octets.try_into().ok()?)),
            },
            ValueKind::Text | ValueKind::Octets => Value::Octets(octets),
        })
    }
}

/// A value of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say it: the types of DataType")]
pub enum Value<'a> {
    Boolean(bool),
    I8(i8),
    I16(i16),
    I32(i32),
    U8(u8),
    U16(u16),
    U32(u32),
    Real32(f32),
    I64(i64),
    U64(u64),
    Real64(f64),
    /// A whole number of 3, 5, 6 or 7 octets.
    Wide {
        number: i64,
        octets: u8,
    },
    /// A string, a time or a domain.
    Octets(&'a [u8]),
}

impl<'a> Value<'a> {
    /// The characters of a VISIBLE_STRING.
    pub(crate) const fn text(text: &'a str) -> Self {
        Self::Octets(text.as_bytes())
    }

    /// A whole number of type `data`, cut to its width; `None` for types that are no whole numbers.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cut to its width, as said")]
    pub(crate) const fn whole(data: DataType, number: i64) -> Option<Self> {
        Some(match data {
            DataType::Boolean => Self::Boolean(number & 1 == 1),
            DataType::I8 => Self::I8(number as i8),
            DataType::I16 => Self::I16(number as i16),
            DataType::I32 => Self::I32(number as i32),
            DataType::I64 => Self::I64(number),
            DataType::U8 => Self::U8(number as u8),
            DataType::U16 => Self::U16(number as u16),
            DataType::U32 => Self::U32(number as u32),
            DataType::U64 => Self::U64(number as u64),
            DataType::I24 => Self::Wide { number: number << 40 >> 40, octets: 3 },
            DataType::I40 => Self::Wide { number: number << 24 >> 24, octets: 5 },
            DataType::I48 => Self::Wide { number: number << 16 >> 16, octets: 6 },
            DataType::I56 => Self::Wide { number: number << 8 >> 8, octets: 7 },
            DataType::U24 => Self::Wide { number: number & 0xFF_FFFF, octets: 3 },
            DataType::U40 => Self::Wide { number: number & 0xFF_FFFF_FFFF, octets: 5 },
            DataType::U48 => Self::Wide { number: number & 0xFFFF_FFFF_FFFF, octets: 6 },
            DataType::U56 => Self::Wide { number: number & 0xFF_FFFF_FFFF_FFFF, octets: 7 },
            DataType::Real32
            | DataType::Real64
            | DataType::VisibleString
            | DataType::OctetString
            | DataType::UnicodeString
            | DataType::TimeOfDay
            | DataType::TimeDifference
            | DataType::Domain => return None,
        })
    }

    /// The number, `None` for other values and for a U64 above the range of `i64`.
    pub const fn number(self) -> Option<i64> {
        match self {
            Self::Boolean(flag) => Some(flag as i64),
            Self::I8(number) => Some(number as i64),
            Self::I16(number) => Some(number as i64),
            Self::I32(number) => Some(number as i64),
            Self::U8(number) => Some(number as i64),
            Self::U16(number) => Some(number as i64),
            Self::U32(number) => Some(number as i64),
            Self::I64(number) | Self::Wide { number, .. } => Some(number),
            Self::U64(number) if number <= i64::MAX as u64 => Some(number.cast_signed()),
            Self::U64(_) | Self::Real32(_) | Self::Real64(_) | Self::Octets(_) => None,
        }
    }

    /// Calls `take` with the octets as on the bus.
    pub fn with_octets<R>(self, take: impl FnOnce(&[u8]) -> R) -> R {
        match self {
            Self::Boolean(flag) => take(&[u8::from(flag)]),
            Self::I8(number) => take(&number.to_le_bytes()),
            Self::I16(number) => take(&number.to_le_bytes()),
            Self::I32(number) => take(&number.to_le_bytes()),
            Self::U8(number) => take(&number.to_le_bytes()),
            Self::U16(number) => take(&number.to_le_bytes()),
            Self::U32(number) => take(&number.to_le_bytes()),
            Self::Real32(number) => take(&number.to_le_bytes()),
            Self::I64(number) => take(&number.to_le_bytes()),
            Self::U64(number) => take(&number.to_le_bytes()),
            Self::Real64(number) => take(&number.to_le_bytes()),
            Self::Wide { number, octets } => {
                let all = number.to_le_bytes();
                take(all.get(..usize::from(octets)).unwrap_or(&all))
            }
            Self::Octets(octets) => take(octets),
        }
    }
}

impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean(flag) => u8::from(*flag).fmt(f),
            Self::I8(number) => number.fmt(f),
            Self::I16(number) => number.fmt(f),
            Self::I32(number) => number.fmt(f),
            Self::U8(number) => number.fmt(f),
            Self::U16(number) => number.fmt(f),
            Self::U32(number) => number.fmt(f),
            Self::Real32(number) => number.fmt(f),
            Self::I64(number) => number.fmt(f),
            Self::U64(number) => number.fmt(f),
            Self::Real64(number) => number.fmt(f),
            Self::Wide { number, .. } => number.fmt(f),
            Self::Octets(octets) => match core::str::from_utf8(octets) {
                Ok(text) => write!(f, "{text:?}"),
                Err(_) => write!(f, "{octets:02X?}"),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_reads_what_it_writes_and_nothing_of_another_length() {
        let all: std::vec::Vec<_> = (0..=0xFF).filter_map(DataType::of_number).collect();
        assert_eq!(all.len(), 25);
        for data in all {
            assert_eq!(DataType::of_number(data.number()), Some(data));
            let Some(len) = data.octets() else { continue };
            let octets: std::vec::Vec<u8> = (0x81..).take(len).collect();
            let value = data.decode(&octets).unwrap();
            if data != DataType::Boolean {
                value.with_octets(|written| assert_eq!(written, octets, "{}", data.name()));
            }
            for wrong in [len - 1, len + 1] {
                assert_eq!(data.decode(&std::vec![0; wrong]), None, "{} of {wrong} octets", data.name());
            }
            if let (Some((low, high)), true) = (data.range(), data.kind().is_whole()) {
                for number in [low, high, 0, 1] {
                    let value = Value::whole(data, number).unwrap();
                    assert_eq!(value.number(), Some(number), "{}", data.name());
                    value.with_octets(|octets| assert_eq!(data.decode(octets), Some(value)));
                }
            }
        }
    }

    #[test]
    fn the_odd_widths_are_low_octet_first_with_their_sign() {
        for (data, octets, number) in [
            (DataType::I24, &[0xFE, 0xFF, 0xFF][..], -2),
            (DataType::U24, &[0x01, 0x02, 0x03], 0x03_0201),
            (DataType::I40, &[0, 0, 0, 0, 0x80], -0x80_0000_0000),
            (DataType::U56, &[0xFF; 7], 0xFF_FFFF_FFFF_FFFF),
            (DataType::I64, &[0xFF; 8], -1),
        ] {
            assert_eq!(data.decode(octets).and_then(Value::number), Some(number), "{}", data.name());
        }
        assert_eq!(DataType::U64.decode(&[0xFF; 8]), Some(Value::U64(u64::MAX)));
        assert_eq!(DataType::I24.range(), Some((-0x80_0000, 0x7F_FFFF)));
        assert_eq!(DataType::U48.range(), Some((0, 0xFFFF_FFFF_FFFF)));
        assert_eq!(Value::whole(DataType::I24, 0xFF_FFFE).and_then(Value::number), Some(-2));
    }
}
