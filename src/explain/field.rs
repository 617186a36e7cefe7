//! What an explanation is made of: named fields over ranges of octets, as a tree.

use core::fmt;

/// One field of a telegram or word and, within it, smaller ones.
///
/// The fields of one level lie beside each other in the order of the octets (bits: the highest first) and leave
/// nothing out, so that every octet has a name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Field {
    /// Name in the standard or the manual: `DA`, `PKE`, `Prm_Req`.
    pub name: String,
    /// First octet, counted from 0 at the beginning of what is explained.
    pub at: usize,
    /// How many octets.
    pub len: usize,
    /// Which bits of the octets, read as one big-endian number, on CANopen as a little-endian one; `None`: all.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub bits: Option<Bits>,
    /// The value as it is: octets in hexadecimal, bits as binary digits.
    pub raw: String,
    /// What the value means; may be empty where the fields within say it.
    pub meaning: String,
    /// Whether it is in order.
    pub mark: Mark,
    /// What somebody who wrote or reads this should know.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub hints: Vec<String>,
    /// The parts of this field.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub fields: Vec<Self>,
}

/// A range of bits within a number; the lowest bit is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bits {
    /// The highest bit.
    pub high: u8,
    /// The lowest bit.
    pub low: u8,
}

impl fmt::Display for Bits {
    /// `bit 3`, `bits 15..12`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.high == self.low {
            write!(f, "bit {}", self.low)
        } else {
            write!(f, "bits {}..{}", self.high, self.low)
        }
    }
}

/// Whether something is in order. The greatest of several counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum Mark {
    /// In order.
    #[default]
    Plain,
    /// In order, and tells of trouble: a refused job, a fault, a diagnosis that is not good.
    Trouble,
    /// A mistake of whoever sent it: the drive refuses or ignores it. The hints say why.
    Mistake,
    /// No telegram: the format is broken here.
    Invalid,
}

impl Field {
    /// A field over `len` octets from `at` on.
    pub(crate) fn new(
        name: impl Into<String>,
        at: usize,
        len: usize,
        raw: impl Into<String>,
        meaning: impl Into<String>,
    ) -> Self {
        let (name, raw, meaning) = (name.into(), raw.into(), meaning.into());
        Self { name, at, len, raw, meaning, ..Self::default() }
    }

    /// One octet.
    pub(crate) fn octet(name: impl Into<String>, at: usize, value: u8, meaning: impl Into<String>) -> Self {
        Self::new(name, at, 1, format!("{value:02X}"), meaning)
    }

    /// A big-endian word.
    pub(crate) fn word(name: impl Into<String>, at: usize, value: u16, meaning: impl Into<String>) -> Self {
        Self::new(name, at, 2, format!("{value:04X}"), meaning)
    }

    /// Any number of octets.
    pub(crate) fn octets(
        name: impl Into<String>,
        at: usize,
        octets: &[u8],
        meaning: impl Into<String>,
    ) -> Self {
        Self::new(name, at, octets.len(), hex(octets), meaning)
    }

    /// Bits of the octet or word `value`, of which the whole is `len` octets.
    pub(crate) fn bits(
        name: impl Into<String>,
        (at, len): (usize, usize),
        bits: Bits,
        value: u16,
        meaning: impl Into<String>,
    ) -> Self {
        let width = usize::from(bits.high.saturating_sub(bits.low)) + 1;
        let part = u32::from(value) >> bits.low.min(15) & ((1 << width.min(16)) - 1);
        Self { bits: Some(bits), ..Self::new(name, at, len, format!("{part:0width$b}"), meaning) }
    }

    /// One bit of the octet `value` at `at`.
    pub(crate) fn bit(
        name: impl Into<String>,
        at: usize,
        bit: u8,
        value: u8,
        one: impl Into<String>,
        zero: impl Into<String>,
    ) -> Self {
        let set = value >> bit.min(7) & 1 != 0;
        let meaning = if set { one.into() } else { zero.into() };
        Self::bits(name, (at, 1), Bits { high: bit, low: bit }, value.into(), meaning)
    }

    /// The same with these parts.
    #[must_use]
    pub(crate) fn with(mut self, fields: Vec<Self>) -> Self {
        self.fields = fields;
        self
    }

    /// The same, marked if it is not marked higher.
    #[must_use]
    pub(crate) fn marked(mut self, mark: Mark) -> Self {
        self.mark = self.mark.max(mark);
        self
    }

    /// The same, marked `mark` if `applies`.
    #[must_use]
    pub(crate) fn marked_if(self, mark: Mark, applies: bool) -> Self {
        if applies { self.marked(mark) } else { self }
    }

    /// The same with a hint.
    #[must_use]
    pub(crate) fn hinted(mut self, hint: impl ToString) -> Self {
        self.hints.push(hint.to_string());
        self
    }

    /// The same with a hint that says what is a mistake about it.
    #[must_use]
    pub(crate) fn mistaken(self, hint: impl ToString) -> Self {
        self.marked(Mark::Mistake).hinted(hint)
    }

    /// The highest mark of the field and all within it.
    pub(crate) fn worst(&self) -> Mark {
        self.fields.iter().map(Self::worst).fold(self.mark, Mark::max)
    }

    /// The field and all within it, from the outside in.
    pub(crate) fn walk<'a>(&'a self, visit: &mut dyn FnMut(usize, &'a Self)) {
        self.walk_at(0, visit);
    }

    fn walk_at<'a>(&'a self, depth: usize, visit: &mut dyn FnMut(usize, &'a Self)) {
        visit(depth, self);
        for field in &self.fields {
            field.walk_at(depth + 1, visit);
        }
    }
}

/// Octets in hexadecimal, a space between two.
pub fn hex(octets: &[u8]) -> String {
    let mut text = String::with_capacity(octets.len() * 3);
    for (n, octet) in octets.iter().enumerate() {
        let space = if n == 0 { "" } else { " " };
        text.push_str(&format!("{space}{octet:02X}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_show_as_binary_digits_of_their_width() {
        let ak = Field::bits("AK", (0, 2), Bits { high: 15, low: 12 }, 0x13FA, "");
        assert_eq!((ak.raw.as_str(), ak.bits.unwrap().to_string().as_str()), ("0001", "bits 15..12"));
        let pnu = Field::bits("PNU", (0, 2), Bits { high: 10, low: 0 }, 0x13FA, "");
        assert_eq!(pnu.raw, "01111111010");
        assert_eq!(Field::bit("x", 0, 7, 0x80, "one", "zero").meaning, "one");
    }

    #[test]
    fn the_worst_mark_is_found_at_any_depth() {
        let inner = Field::octet("b", 1, 0, "").mistaken("no").marked(Mark::Trouble);
        assert_eq!(inner.mark, Mark::Mistake, "never marked down");
        let outer = Field::octets("a", 0, &[1, 0], "").with(Vec::from([inner]));
        assert_eq!((outer.mark, outer.worst()), (Mark::Plain, Mark::Mistake));
        assert_eq!(outer.raw, "01 00");
    }
}
