//! Control word and status word, bit by bit in words, in the positioning mode.

use profidrive::ppo::{Stw, Zsw};

/// Bits of the control word that a person looks for; the rest is rare.
const STW: [(u8, &str); 7] = [
    (0, "ON"),
    (1, "no OFF2"),
    (3, "enable operation"),
    (4, "no stop"),
    (5, "no intermediate stop"),
    (6, "start bit"),
    (7, "acknowledge"),
];

/// Bits of the status word that change; 5, 9 and 11 are always 1, 1 is equal to 0, 8 is 1 without lag error.
const ZSW: [(u8, &str); 10] = [
    (0, "ready to turn on"),
    (2, "operation enabled"),
    (3, "FAULT"),
    (6, "turn-on disabled"),
    (7, "warning"),
    (10, "target reached"),
    (12, "job toggle"),
    (13, "stands still"),
    (14, "beyond a limit"),
    (15, "ready to travel"),
];

/// What a master asks with this control word.
pub(super) fn stw(stw: Stw) -> String {
    in_words(&STW, |bit| stw.bit(bit))
}

/// What a drive says with this status word.
pub(super) fn zsw(zsw: Zsw) -> String {
    in_words(&ZSW, |bit| zsw.bit(bit))
}

fn in_words(table: &[(u8, &str)], set: impl Fn(u8) -> bool) -> String {
    let words: Vec<&str> = table.iter().filter(|row| set(row.0)).map(|row| row.1).collect();
    if words.is_empty() { "nothing".into() } else { words.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_reads_as_its_bits() {
        assert_eq!(stw(Stw::from_raw(0x000B)), "ON, no OFF2, enable operation");
        assert_eq!(stw(Stw::from_raw(0)), "nothing");
        assert_eq!(
            zsw(Zsw::from_raw(0xAB37)),
            "ready to turn on, operation enabled, stands still, ready to travel"
        );
        assert_eq!(zsw(Zsw::from_raw(0x2B2B)), "ready to turn on, FAULT, stands still");
    }
}
