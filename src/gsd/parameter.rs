//! User parameters: fields, ranges, texts, and the octets of Set_Prm they make (`gsd.md` 4).
//!
//! ```text
//! Set_Prm  7 octets, station part, part of the module in the first slot, of that in the second, ...
//! part     zeros; constants from their offset; then the default of each reference, by its bits
//! ```

use core::fmt;

use super::Gsd;

/// The most octets of user parameters.
pub(super) const MAX_USER_PRM_LEN: usize = 237;

/// ExtUserPrmData: a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type.
    pub field: FieldType,
    /// Its default.
    pub default: i64,
    /// What it may be.
    pub allowed: Allowed,
    /// Prm_Text_Ref.
    pub text_ref: Option<u32>,
    /// Changeable.
    pub changeable: bool,
    /// Visible.
    pub visible: bool,
}

/// The bits of a parameter. Words are big-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldType {
    /// One bit of an octet.
    Bit(u8),
    /// The bits from the first to the second, of an octet as a rule.
    BitArea(u8, u8),
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
}

impl FieldType {
    /// How many octets it lies in: 1, 2 or 4. The highest bit of an area decides.
    pub(crate) const fn octets(self) -> usize {
        match self {
            Self::Bit(last) | Self::BitArea(_, last) => match last {
                0..=7 => 1,
                8..=15 => 2,
                16.. => 4,
            },
            Self::Unsigned8 | Self::Signed8 => 1,
            Self::Unsigned16 | Self::Signed16 => 2,
            Self::Unsigned32 | Self::Signed32 => 4,
        }
    }

    /// Its lowest bit, and how many it has.
    fn bits(self) -> (u32, u32) {
        match self {
            Self::Bit(bit) => (bit.into(), 1),
            Self::BitArea(first, last) => (first.into(), u32::from(last.saturating_sub(first)) + 1),
            Self::Unsigned8 | Self::Signed8 => (0, 8),
            Self::Unsigned16 | Self::Signed16 => (0, 16),
            Self::Unsigned32 | Self::Signed32 => (0, 32),
        }
    }

    const fn signed(self) -> bool {
        match self {
            Self::Signed8 | Self::Signed16 | Self::Signed32 => true,
            Self::Bit(_) | Self::BitArea(..) | Self::Unsigned8 | Self::Unsigned16 | Self::Unsigned32 => false,
        }
    }

    /// Writes a value at an offset and keeps the other bits. Octets that are not there are left out.
    pub(super) fn write(self, octets: &mut [u8], offset: usize, value: i64) {
        let (first, count) = self.bits();
        let mask = ((1_u64 << count.min(32)) - 1) << first.min(31);
        let bits = (value.cast_unsigned() << first.min(31)) & mask;
        let Some(field) = octets.get_mut(offset..).and_then(|rest| rest.get_mut(..self.octets())) else {
            return;
        };
        for (place, octet) in field.iter_mut().rev().enumerate() {
            let byte = |word: u64| word.to_le_bytes().get(place).copied().unwrap_or(0);
            *octet = (*octet & !byte(mask)) | byte(bits);
        }
    }

    /// The value at an offset, `None` if the octets are not there.
    pub(super) fn read(self, octets: &[u8], offset: usize) -> Option<i64> {
        let (first, count) = self.bits();
        let field = octets.get(offset..)?.get(..self.octets())?;
        let word = field.iter().fold(0_u64, |word, octet| word << 8 | u64::from(*octet));
        let value = (word >> first.min(31)) & ((1_u64 << count.min(32)) - 1);
        let value = i64::try_from(value).ok()?;
        let negative = self.signed() && value >> (count - 1) & 1 == 1;
        Some(if negative { value - (1_i64 << count) } else { value })
    }
}

impl fmt::Display for FieldType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bit(bit) => write!(f, "Bit({bit})"),
            Self::BitArea(first, last) => write!(f, "BitArea({first}-{last})"),
            Self::Unsigned8 => f.write_str("Unsigned8"),
            Self::Unsigned16 => f.write_str("Unsigned16"),
            Self::Unsigned32 => f.write_str("Unsigned32"),
            Self::Signed8 => f.write_str("Signed8"),
            Self::Signed16 => f.write_str("Signed16"),
            Self::Signed32 => f.write_str("Signed32"),
        }
    }
}

/// The values of a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// The file does not say.
    Any,
    /// From the first to the second.
    Range(i64, i64),
    /// These.
    Set(Vec<i64>),
}

impl Allowed {
    /// Whether it is one of them.
    pub(crate) fn contains(&self, value: i64) -> bool {
        match self {
            Self::Any => true,
            Self::Range(least, most) => (*least..=*most).contains(&value),
            Self::Set(values) => values.contains(&value),
        }
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("any value"),
            Self::Range(least, most) if least == most => write!(f, "{least}"),
            Self::Range(least, most) => write!(f, "{least}..{most}"),
            Self::Set(values) => {
                for (place, value) in values.iter().enumerate() {
                    write!(f, "{}{value}", if place == 0 { "" } else { ", " })?;
                }
                Ok(())
            }
        }
    }
}

/// A part of the user parameters: the station's or a module's.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrmPart {
    /// Ext_Module_Prm_Data_Len.
    pub len: Option<u8>,
    /// Ext_User_Prm_Data_Const: offset and octets.
    pub constants: Vec<(u8, Vec<u8>)>,
    /// Ext_User_Prm_Data_Ref.
    pub references: Vec<Reference>,
}

/// A parameter at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reference {
    /// The octet in its part, from 0.
    pub offset: u8,
    /// The number of the parameter.
    pub id: u32,
}

impl PrmPart {
    /// Whether nothing is said about it.
    pub(crate) fn is_empty(&self) -> bool {
        self.constants.is_empty() && self.references.is_empty()
    }

    /// Its octets: its length, if the file says it, or as far as constants and references go.
    pub(crate) fn extent(&self, gsd: &Gsd) -> usize {
        let constants = self.constants.iter().map(|(offset, octets)| usize::from(*offset) + octets.len());
        let fields = self.fields(gsd).map(|(offset, parameter)| offset + parameter.field.octets());
        let extent = constants.chain(fields).max().unwrap_or(0).max(self.len.unwrap_or(0).into());
        extent.min(MAX_USER_PRM_LEN)
    }

    /// Its parameters with their offsets.
    pub(crate) fn fields<'a>(&'a self, gsd: &'a Gsd) -> impl Iterator<Item = (usize, &'a Parameter)> {
        let known =
            |reference: &Reference| Some((usize::from(reference.offset), gsd.parameters.get(&reference.id)?));
        self.references.iter().filter_map(known)
    }

    /// The bits that no parameter changes that the file has as changeable.
    pub(super) fn constant_bits(&self, gsd: &Gsd) -> Vec<u8> {
        let mut octets = vec![0xFF; self.extent(gsd)];
        for (offset, parameter) in self.fields(gsd).filter(|(_, parameter)| parameter.changeable) {
            parameter.field.write(&mut octets, offset, 0);
        }
        octets
    }

    /// Constants, and over them the default of every parameter.
    pub(crate) fn default_octets(&self, gsd: &Gsd) -> Vec<u8> {
        let mut octets = vec![0; self.extent(gsd)];
        for (offset, constant) in &self.constants {
            for (octet, value) in octets.iter_mut().skip((*offset).into()).zip(constant) {
                *octet = *value;
            }
        }
        for (offset, parameter) in self.fields(gsd) {
            parameter.field.write(&mut octets, offset, parameter.default);
        }
        octets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_keeps_the_bits_of_the_others() {
        use FieldType::{Bit, BitArea, Signed8, Signed16, Signed32, Unsigned16, Unsigned32};
        for (field, value, ones, zeros) in [
            (Bit(3), 0, [0xFF, 0xF7, 0xFF, 0xFF, 0xFF], [0; 5]),
            (Bit(3), 1, [0xFF; 5], [0, 0x08, 0, 0, 0]),
            (BitArea(4, 6), 5, [0xFF, 0xDF, 0xFF, 0xFF, 0xFF], [0, 0x50, 0, 0, 0]),
            (BitArea(6, 9), 5, [0xFF, 0xFD, 0x7F, 0xFF, 0xFF], [0, 0x01, 0x40, 0, 0]),
            (Unsigned16, 0x1234, [0xFF, 0x12, 0x34, 0xFF, 0xFF], [0, 0x12, 0x34, 0, 0]),
            (Signed8, -2, [0xFF, 0xFE, 0xFF, 0xFF, 0xFF], [0, 0xFE, 0, 0, 0]),
            (Signed16, -2, [0xFF, 0xFF, 0xFE, 0xFF, 0xFF], [0, 0xFF, 0xFE, 0, 0]),
            (Signed32, -2, [0xFF, 0xFF, 0xFF, 0xFF, 0xFE], [0, 0xFF, 0xFF, 0xFF, 0xFE]),
            (Unsigned32, 0xFFFF_FFFF, [0xFF; 5], [0, 0xFF, 0xFF, 0xFF, 0xFF]),
            (BitArea(0, 31), 0xFFFF_FFFF, [0xFF; 5], [0, 0xFF, 0xFF, 0xFF, 0xFF]),
            (Bit(31), 1, [0xFF; 5], [0, 0x80, 0, 0, 0]),
        ] {
            for (start, expected) in [(0xFF, ones), (0, zeros)] {
                let mut octets = [start; 5];
                field.write(&mut octets, 1, value);
                assert_eq!(octets, expected, "{field}");
                assert_eq!(field.read(&octets, 1), Some(value), "{field}");
            }
            assert_eq!(field.read(&[0; 5], 5), None);
        }
    }
}
