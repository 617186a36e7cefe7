//! What a PDO carries: mapping words, their check when written, and the table that frames are built and taken by.
//!
//! ```text
//! bits 31..16 index   bits 15..8 sub-index   bits 7..0 length in bits
//! ```
//!
//! Indices 0001h to 0007h are types: dummies of that length in an RPDO.

use heapless::Vec;

use super::MAX_MAPPED;
use crate::can_bus::canopen::abort::Abort;
use crate::can_bus::canopen::address::Address;
use crate::can_bus::canopen::dictionary;
use crate::can_bus::canopen::dictionary::{Entry, Object};
use crate::can_bus::canopen::refusal::{Broken, Rule};
use crate::can_bus::canopen::value::DataType;

/// The most octets of a PDO.
const MAX_OCTETS: u32 = 8;

/// Which way a PDO goes, seen from the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Direction {
    /// RPDO.
    Receive,
    /// TPDO.
    Transmit,
}

/// A mapping word taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MappingWord {
    /// The entry.
    pub at: Address,
    /// How many bits of it, the low ones.
    pub bits: u8,
}

impl MappingWord {
    /// The word of an object.
    pub(crate) const fn decode(word: u32) -> Self {
        let [bits, sub, low, high] = word.to_le_bytes();
        Self { at: Address::new(u16::from_le_bytes([low, high]), sub), bits }
    }

    /// Whether it stands for octets of an RPDO that nobody takes.
    pub(crate) const fn is_dummy(self) -> bool {
        self.dummy_bits().is_some()
    }

    /// Bits of a dummy, `None` if it is an entry.
    const fn dummy_bits(self) -> Option<u8> {
        match self.at.pair() {
            (0x0001, 0) => Some(1),
            (0x0002 | 0x0005, 0) => Some(8),
            (0x0003 | 0x0006, 0) => Some(16),
            (0x0004 | 0x0007, 0) => Some(32),
            (0.., 0..) => None,
        }
    }
}

/// One piece of a PDO.
#[derive(Clone, Copy, Debug)]
pub(in crate::can_bus::canopen) struct Piece {
    pub(in crate::can_bus::canopen) at: Address,
    /// `None` for a dummy.
    pub(in crate::can_bus::canopen) entry: Option<&'static Entry>,
    /// How many of its low bits. They follow one another, the low one first.
    pub(in crate::can_bus::canopen) bits: u32,
}

impl Piece {
    /// Its bits at their place in a PDO.
    pub(in crate::can_bus::canopen) fn place(&self, value: u64, begin: u32) -> u64 {
        (value & self.mask()).checked_shl(begin).unwrap_or(0)
    }

    /// Its bits from their place in a PDO.
    pub(in crate::can_bus::canopen) fn take(&self, data: u64, begin: u32) -> u64 {
        data.checked_shr(begin).unwrap_or(0) & self.mask()
    }

    const fn mask(&self) -> u64 {
        if self.bits < 64 { (1 << self.bits) - 1 } else { u64::MAX }
    }
}

/// The pieces of a PDO, in their order in the frame.
pub(in crate::can_bus::canopen) type Pieces = Vec<Piece, MAX_MAPPED>;

/// The table of a mapping. Words that name nothing are left out: they come from faulty default tables only.
pub(in crate::can_bus::canopen) fn pieces(objects: &'static [Object], words: &[u32]) -> Pieces {
    let mut pieces = Pieces::new();
    for word in words {
        let word = MappingWord::decode(*word);
        let entry = match word.dummy_bits() {
            Some(_) => None,
            None => match dictionary::entry(objects, word.at) {
                Ok(entry) => Some(entry),
                Err(_) => continue,
            },
        };
        let _ = pieces.push(Piece { at: word.at, entry, bits: word.bits.into() });
    }
    pieces
}

/// Octets of all pieces.
pub(in crate::can_bus::canopen) fn octets(pieces: &Pieces) -> usize {
    let bits: u32 = pieces.iter().map(|piece| piece.bits).sum();
    usize::try_from(bits.div_ceil(8)).unwrap_or(8).min(8)
}

/// Whether one word may be written to a mapping. Zero is an empty place.
pub(in crate::can_bus::canopen) fn judge_word(
    objects: &'static [Object],
    direction: Direction,
    word: u32,
    dummies: u8,
) -> Result<(), Broken> {
    if word == 0 {
        return Ok(());
    }
    let word = MappingWord::decode(word);
    if let (Some(bits), Direction::Receive) = (word.dummy_bits(), direction) {
        let allowed = dummies.checked_shr(word.at.index.0.into()).is_some_and(|dummies| dummies & 1 == 1);
        return if bits == word.bits && allowed { Ok(()) } else { Err(Abort::NOT_MAPPABLE.into()) };
    }
    let entry = dictionary::entry(objects, word.at)?;
    let mappable = match direction {
        Direction::Receive => entry.receivable(),
        Direction::Transmit => entry.sendable(),
    };
    let bits = entry.data.octets().map(|octets| octets * 8);
    let fits = bits == Some(usize::from(word.bits)) || entry.data == DataType::Boolean && word.bits == 1;
    match bits {
        _ if mappable && fits => Ok(()),
        Some(bits) if mappable => Err(Broken::rule(Abort::NOT_MAPPABLE, Rule::Bits(bits))),
        Some(_) | None => Err(Abort::NOT_MAPPABLE.into()),
    }
}

/// Whether so many words make a PDO.
pub(in crate::can_bus::canopen) fn judge_count(
    objects: &'static [Object],
    direction: Direction,
    words: &[u32],
    dummies: u8,
) -> Result<(), Broken> {
    let mut bits = 0;
    for (sub, word) in (1..).zip(words) {
        if *word == 0 {
            return Err(Broken::rule(Abort::NO_OBJECT, Rule::NotMapped(sub)));
        }
        judge_word(objects, direction, *word, dummies)?;
        bits += u32::from(MappingWord::decode(*word).bits);
    }
    if bits > MAX_OCTETS * 8 { Err(Abort::PDO_LENGTH.into()) } else { Ok(()) }
}
