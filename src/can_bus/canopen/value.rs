//! Values of objects and their octets, low octet first (`canopen-link.md` 8).

use core::fmt;

/// The type of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DataType {
    /// 1 bit, sent as one octet 0 or 1.
    Boolean,
    /// 8 bits with sign.
    I8,
    /// 16 bits with sign.
    I16,
    /// 32 bits with sign.
    I32,
    /// 8 bits.
    U8,
    /// 16 bits.
    U16,
    /// 32 bits.
    U32,
    /// IEEE 754, 32 bits.
    Real32,
    /// Characters 20h to 7Eh, without terminator.
    VisibleString,
    /// Octets.
    OctetString,
    /// Octets of a program or a file.
    Domain,
    /// 64 bits with sign.
    I64,
    /// 64 bits.
    U64,
}

impl DataType {
    /// The number of the type in dictionaries and EDS files.
    pub const fn number(self) -> u16 {
        match self {
            Self::Boolean => 0x01,
            Self::I8 => 0x02,
            Self::I16 => 0x03,
            Self::I32 => 0x04,
            Self::U8 => 0x05,
            Self::U16 => 0x06,
            Self::U32 => 0x07,
            Self::Real32 => 0x08,
            Self::VisibleString => 0x09,
            Self::OctetString => 0x0A,
            Self::Domain => 0x0F,
            Self::I64 => 0x15,
            Self::U64 => 0x1B,
        }
    }

    /// Its name in CiA 301.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Boolean => "BOOLEAN",
            Self::I8 => "INTEGER8",
            Self::I16 => "INTEGER16",
            Self::I32 => "INTEGER32",
            Self::U8 => "UNSIGNED8",
            Self::U16 => "UNSIGNED16",
            Self::U32 => "UNSIGNED32",
            Self::Real32 => "REAL32",
            Self::VisibleString => "VISIBLE_STRING",
            Self::OctetString => "OCTET_STRING",
            Self::Domain => "DOMAIN",
            Self::I64 => "INTEGER64",
            Self::U64 => "UNSIGNED64",
        }
    }

    /// Octets of a value, `None` where values differ in length.
    pub const fn octets(self) -> Option<usize> {
        match self {
            Self::Boolean | Self::I8 | Self::U8 => Some(1),
            Self::I16 | Self::U16 => Some(2),
            Self::I32 | Self::U32 | Self::Real32 => Some(4),
            Self::I64 | Self::U64 => Some(8),
            Self::VisibleString | Self::OctetString | Self::Domain => None,
        }
    }

    /// The lowest and the highest value of a whole number, `None` for other types.
    pub const fn range(self) -> Option<(i64, i64)> {
        match self {
            Self::Boolean => Some((0, 1)),
            Self::I8 => Some((i8::MIN as i64, i8::MAX as i64)),
            Self::I16 => Some((i16::MIN as i64, i16::MAX as i64)),
            Self::I32 => Some((i32::MIN as i64, i32::MAX as i64)),
            Self::U8 => Some((0, u8::MAX as i64)),
            Self::U16 => Some((0, u16::MAX as i64)),
            Self::U32 => Some((0, u32::MAX as i64)),
            Self::Real32 | Self::VisibleString | Self::OctetString | Self::Domain | Self::I64 | Self::U64 => {
                None
            }
        }
    }

    /// The value that `octets` are, `None` if their number is wrong for the type. Of a BOOLEAN bit 0 counts.
    pub fn decode(self, octets: &[u8]) -> Option<Value<'_>> {
        Some(match self {
            Self::Boolean => Value::Boolean(u8::from_le_bytes(octets.try_into().ok()?) & 1 == 1),
            Self::I8 => Value::I8(i8::from_le_bytes(octets.try_into().ok()?)),
            Self::I16 => Value::I16(i16::from_le_bytes(octets.try_into().ok()?)),
            Self::I32 => Value::I32(i32::from_le_bytes(octets.try_into().ok()?)),
            Self::U8 => Value::U8(u8::from_le_bytes(octets.try_into().ok()?)),
            Self::U16 => Value::U16(u16::from_le_bytes(octets.try_into().ok()?)),
            Self::U32 => Value::U32(u32::from_le_bytes(octets.try_into().ok()?)),
            Self::Real32 => Value::Real32(f32::from_le_bytes(octets.try_into().ok()?)),
            Self::I64 => Value::I64(i64::from_le_bytes(octets.try_into().ok()?)),
            Self::U64 => Value::U64(u64::from_le_bytes(octets.try_into().ok()?)),
            Self::VisibleString | Self::OctetString | Self::Domain => Value::Octets(octets),
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
    /// A string or a domain.
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
            DataType::U8 => Self::U8(number as u8),
            DataType::U16 => Self::U16(number as u16),
            DataType::U32 => Self::U32(number as u32),
            DataType::I64 => Self::I64(number),
            DataType::U64 => Self::U64(number as u64),
            DataType::Real32 | DataType::VisibleString | DataType::OctetString | DataType::Domain => {
                return None;
            }
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
            Self::I64(number) => Some(number),
            Self::U64(number) if number <= i64::MAX as u64 => Some(number.cast_signed()),
            Self::U64(_) | Self::Real32(_) | Self::Octets(_) => None,
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
            Self::Octets(octets) => match core::str::from_utf8(octets) {
                Ok(text) => write!(f, "{text:?}"),
                Err(_) => write!(f, "{octets:02X?}"),
            },
        }
    }
}
