//! The words of bits in one line and bit by bit: what a control word changes, what a status word says.
//!
//! The bits themselves, with their names and meanings, are those of [`device::bits`](crate::devices::ag03::profibus::bits).
//!
//! ```
//! use profidrive::devices::ag03::profibus::bits::Word;
//! use profidrive::devices::ag03::drive::Mode;
//! use profidrive::explain::words::{changes, said};
//!
//! assert_eq!(changes(Word::Stw, Mode::Positioning, 0x007B, 0x005B), "intermediate stop");
//! assert_eq!(said(Mode::Positioning, 0xAB37, 0x1B37), "enabled, job accepted");
//! ```

use super::field::{Bits, Field};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::Model;
use crate::devices::ag03::profibus::bits::{NOT_USED, Role, Word, ZswBit, bits};

/// What a word changes after `before`, `no change` if nothing. Bits without a meaning are not mentioned.
pub fn changes(word: Word, mode: Mode, before: u16, now: u16) -> String {
    let changed = before ^ now;
    let words: Vec<&str> = (0..16)
        .zip(bits(word, mode, None))
        .filter(|(n, bit)| changed >> n & 1 != 0 && matches!(bit.role, Role::Level | Role::Edge))
        .map(|(n, bit)| bit.meaning(now >> n & 1 != 0))
        .collect();
    if words.is_empty() { "no change".into() } else { words.join(", ") }
}

/// What a control word STW commands after `before`: see [`changes`].
pub(crate) fn commanded(mode: Mode, before: u16, now: u16) -> String {
    changes(Word::Stw, mode, before, now)
}

/// The bits that are 1, `nothing` if there are none with a meaning.
pub(crate) fn on(word: Word, mode: Mode, raw: u16) -> String {
    let words: Vec<&str> = (0..16)
        .zip(bits(word, mode, None))
        .filter(|(n, bit)| raw >> n & 1 != 0 && bit.role == Role::Level)
        .map(|(_, bit)| bit.one)
        .collect();
    if words.is_empty() { "nothing".into() } else { words.join(", ") }
}

/// What a drive says with a status word ZSW after `before`: the bits that say something new to somebody who knows
/// what is fixed and what follows from other bits.
pub fn said(mode: Mode, before: u16, now: u16) -> String {
    let implied = |bit: ZswBit| IMPLIED.iter().any(|row| row.0.is_set(now) && row.1 == bit);
    let bits = bits(Word::Zsw, mode, None);
    let of = |bit: ZswBit| bits.get(usize::from(bit.number())).filter(|bit| bit.role == Role::Level);
    let mut words: Vec<&str> = TELLING
        .iter()
        .filter(|bit| bit.is_set(now) && !implied(**bit))
        .filter_map(|bit| of(*bit).map(|bit| bit.one))
        .collect();
    if mode == Mode::Positioning && ZswBit::JobToggle.is_set(before ^ now) {
        words.push("job accepted");
    }
    if words.is_empty() { "nothing".into() } else { words.join(", ") }
}

/// A word at octet `at`, with a field for each bit. Bits beside each other that are not used share one.
pub(crate) fn field(word: Word, mode: Mode, model: Option<Model>, at: usize, raw: u16) -> Field {
    let mut fields: Vec<Field> = Vec::new();
    for (n, bit) in (0..16_u8).zip(bits(word, mode, model)).rev() {
        let set = raw >> n & 1 != 0;
        let unused = |field: &Field| bit.key.is_empty() && field.name == NOT_USED;
        if let Some(field) = fields.last_mut().filter(|field| unused(field))
            && let Some(place) = &mut field.bits
        {
            place.low = n;
            field.raw.push(if set { '1' } else { '0' });
            continue;
        }
        let name = if bit.key.is_empty() { NOT_USED } else { bit.name };
        let mut meaning = bit.meaning(set).to_string();
        if !bit.note.is_empty() {
            meaning = format!("{meaning} ({})", bit.note);
        }
        let mut field = Field::new(name, at, 2, u8::from(set).to_string(), meaning);
        field.bits = Some(Bits { high: n, low: n });
        fields.push(field);
    }
    Field::new(word.name(), at, 2, format!("{raw:04X}"), "").with(fields)
}

/// Bits of the status word worth reading, most telling first. 5, 9 and 11 are always 1, 1 is equal to 0, 8 is 1
/// without lag error.
const TELLING: [ZswBit; 9] = [
    ZswBit::ReadyToTurnOn,
    ZswBit::OperationEnabled,
    ZswBit::ReadyToTravel,
    ZswBit::Fault,
    ZswBit::TurnOnDisabled,
    ZswBit::Warning,
    ZswBit::LimitExceeded,
    ZswBit::TargetReached,
    ZswBit::Standstill,
];

/// The first bit says more and makes the second superfluous: an enabled drive is ready to turn on, one that is ready to
/// travel stands still. In fault and turn-on disabled, ready to turn on only means that the supplies are present.
const IMPLIED: [(ZswBit, ZswBit); 4] = [
    (ZswBit::OperationEnabled, ZswBit::ReadyToTurnOn),
    (ZswBit::ReadyToTravel, ZswBit::Standstill),
    (ZswBit::Fault, ZswBit::ReadyToTurnOn),
    (ZswBit::TurnOnDisabled, ZswBit::ReadyToTurnOn),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_word_reads_as_what_it_changes() {
        for (mode, before, now, words) in [
            (Mode::Positioning, 0x0000, 0x000B, "ON, no OFF2, enable operation"),
            (Mode::Positioning, 0x007B, 0x005B, "intermediate stop"),
            (Mode::Positioning, 0x003B, 0x003A, "OFF1"),
            (Mode::Positioning, 0x003B, 0x003B, "no change"),
            (Mode::Positioning, 0x000B, 0x820B, "inching 2, negative direction"),
            (Mode::Positioning, 0x000B, 0x040F, "no change"),
            (Mode::Velocity, 0x000B, 0x004B, "setpoint released"),
            (Mode::Velocity, 0x004B, 0x837B, "no change"),
        ] {
            assert_eq!(changes(Word::Stw, mode, before, now), words, "{before:04X} {now:04X}");
        }
    }

    #[test]
    fn a_status_word_reads_as_the_bits_that_say_something() {
        for (mode, before, now, words) in [
            (Mode::Positioning, 0x0000, 0x2B23, "ready to turn on, stands still"),
            (Mode::Positioning, 0x2B23, 0xAB37, "enabled, ready to travel"),
            (Mode::Positioning, 0xAB37, 0x1B37, "enabled, job accepted"),
            (Mode::Positioning, 0x3F3B, 0x3F3B, "FAULT, target reached, stands still"),
            (Mode::Positioning, 0x0A20, 0x0A20, "nothing"),
            (Mode::Velocity, 0x3E23, 0xBE37, "enabled, ready to travel"),
            (Mode::Velocity, 0xBE37, 0x1F37, "enabled"),
        ] {
            assert_eq!(said(mode, before, now), words, "{before:04X} {now:04X}");
        }
    }

    #[test]
    fn a_field_lists_every_bit_and_joins_those_without_a_meaning() {
        let stw = field(Word::Stw, Mode::Positioning, None, 8, 0x820B);
        assert_eq!((stw.at, stw.len, stw.raw.as_str()), (8, 2, "820B"));
        let bits: Vec<(u8, u8)> =
            stw.fields.iter().map(|field| field.bits.unwrap()).map(|bits| (bits.high, bits.low)).collect();
        assert_eq!(bits.first(), Some(&(15, 15)));
        assert!(bits.contains(&(14, 10)), "{bits:?}");
        assert_eq!(bits.iter().map(|bits| bits.0 - bits.1 + 1).sum::<u8>(), 16);
        let raw: String = stw.fields.iter().map(|field| field.raw.as_str()).collect();
        assert_eq!(raw, "1000001000001011");
    }
}
