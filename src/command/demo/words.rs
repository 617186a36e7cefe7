//! Control word and status word, bit by bit in words, in the positioning mode.

use profidrive::ppo::{Stw, Zsw};

/// Bits of the control word, in words for 1 and for 0. The bits of inching do not occur here.
const STW: [(u8, &str, &str); 7] = [
    (0, "ON", "OFF1"),
    (1, "no OFF2", "OFF2"),
    (3, "enable operation", "disable operation"),
    (4, "no stop", "stop"),
    (5, "no intermediate stop", "intermediate stop"),
    (6, "start bit 1", "start bit 0"),
    (7, "acknowledge", "acknowledge over"),
];

/// Bits of the status word that change. 5, 9 and 11 are always 1, 1 is equal to 0, 8 is 1 without lag error.
const ZSW: [(u8, &str); 9] = [
    (0, "ready to turn on"),
    (2, "enabled"),
    (15, "ready to travel"),
    (3, "FAULT"),
    (6, "turn-on disabled"),
    (7, "warning"),
    (14, "beyond a limit"),
    (10, "target reached"),
    (13, "stands still"),
];

/// A word that says more makes another superfluous: an enabled drive is ready to turn on, one that is ready to travel
/// stands still. And nobody wants to read that a drive in fault is ready to turn on, which only means its supplies.
const IMPLIED: [(u8, u8); 4] = [(2, 0), (15, 13), (3, 0), (6, 0)];

/// The bit that toggles with each job taken over.
const JOB_TOGGLE: u8 = 12;

/// What a master changes with a control word after `before`.
pub(super) fn stw(before: Stw, now: Stw) -> String {
    let changed = STW.iter().filter(|row| before.bit(row.0) != now.bit(row.0));
    let words: Vec<&str> = changed.map(|row| if now.bit(row.0) { row.1 } else { row.2 }).collect();
    if words.is_empty() { "no change".into() } else { words.join(", ") }
}

/// What a drive says with a status word after `before`.
pub(super) fn zsw(before: Zsw, now: Zsw) -> String {
    let implied = |bit: u8| IMPLIED.iter().any(|row| now.bit(row.0) && row.1 == bit);
    let mut words: Vec<&str> =
        ZSW.iter().filter(|row| now.bit(row.0) && !implied(row.0)).map(|row| row.1).collect();
    if before.bit(JOB_TOGGLE) != now.bit(JOB_TOGGLE) {
        words.push("job taken over");
    }
    if words.is_empty() { "nothing".into() } else { words.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_word_reads_as_what_it_changes() {
        for (before, now, words) in [
            (0x0000, 0x000B, "ON, no OFF2, enable operation"),
            (0x007B, 0x005B, "intermediate stop"),
            (0x003B, 0x003A, "OFF1"),
            (0x003B, 0x003B, "no change"),
        ] {
            assert_eq!(stw(Stw::from_raw(before), Stw::from_raw(now)), words);
        }
    }

    #[test]
    fn a_status_word_reads_as_the_bits_that_say_something() {
        for (before, now, words) in [
            (0x0000, 0x2B23, "ready to turn on, stands still"),
            (0x2B23, 0xAB37, "enabled, ready to travel"),
            (0xAB37, 0x1B37, "enabled, job taken over"),
            (0x3F3B, 0x3F3B, "FAULT, target reached, stands still"),
            (0x0A20, 0x0A20, "nothing"),
        ] {
            assert_eq!(zsw(Zsw::from_raw(before), Zsw::from_raw(now)), words);
        }
    }
}
