//! The bits of STW, ZSW, SSW and the general status register in words, once, by operating mode.
//!
//! Names and meanings are those of manual tables 1 and 11 to 14 (`ag03.md` 4, 5 and 6; where the English manual lost
//! a word in translation, those of the German one, C-04 and C-22). What the drive does at each bit is in
//! [`device::words`](crate::device::words).
//!
//! ```
//! use profidrive::drive::Mode;
//! use profidrive::explain::words::{Word, bits, changes, said};
//! use profidrive::param::Model;
//!
//! // Bit by bit, for a table of a program's own.
//! let start = bits(Word::Stw, Mode::Positioning, Some(Model::Ag03))[6];
//! assert_eq!((start.key, start.name), ("start", "activate travel job"));
//!
//! // In one line: what a control word changes, what a status word says.
//! assert_eq!(changes(Word::Stw, Mode::Positioning, 0x007B, 0x005B), "intermediate stop");
//! assert_eq!(said(Mode::Positioning, 0xAB37, 0x1B37), "enabled, job taken over");
//! ```

use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use super::field::{Bits, Field};
use crate::drive::Mode;
use crate::param::Model;

/// One of the words of bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Word {
    /// Control word STW, manual tables 11 and 13.
    Stw,
    /// Status word ZSW, manual tables 12 and 14.
    Zsw,
    /// System status word SSW, PNU 1020, manual table 1.
    Ssw,
    /// General status register, PNU 1031.
    GeneralStatus,
}

impl Word {
    /// `STW`, `ZSW`, `SSW`, `GSR`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stw => "STW",
            Self::Zsw => "ZSW",
            Self::Ssw => "SSW",
            Self::GeneralStatus => "GSR",
        }
    }

    const fn rows(self) -> &'static [Row; 16] {
        match self {
            Self::Stw => &STW,
            Self::Zsw => &ZSW,
            Self::Ssw => &SSW,
            Self::GeneralStatus => &GENERAL_STATUS,
        }
    }
}

/// One bit of a word, in one operating mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bit {
    /// A short name for programs and command lines, `no-off2`. Empty for a bit that is not used.
    pub key: &'static str,
    /// What the manual calls it, in the column of the profile.
    pub name: &'static str,
    /// What 1 means.
    pub one: &'static str,
    /// What 0 means.
    pub zero: &'static str,
    /// What to know about it; empty where nothing is left to say.
    pub note: &'static str,
    /// How the bit carries its meaning.
    pub role: Role,
}

impl Bit {
    /// What the bit means with this value.
    pub const fn meaning(&self, set: bool) -> &'static str {
        if set { self.one } else { self.zero }
    }
}

/// How a bit carries its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Role {
    /// By being 0 or 1.
    Level,
    /// By changing.
    Edge,
    /// Not at all: it always has this value.
    Fixed(bool),
    /// Not at all: it is not evaluated, or 0.
    Unused,
}

/// The bits of a word in an operating mode, bit 0 first. What releases the output stage (SSW.10, GSR.4) is the enable
/// input on an AG03 and a supply on an AG03/1; without a `model` the words are for either.
pub fn bits(word: Word, mode: Mode, model: Option<Model>) -> [&'static Bit; 16] {
    word.rows().each_ref().map(|row| row.of(mode, model))
}

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

/// The bits that are 1, `nothing` if there are none with a meaning.
pub fn on(word: Word, mode: Mode, raw: u16) -> String {
    let words: Vec<&str> = (0..16)
        .zip(bits(word, mode, None))
        .filter(|(n, bit)| raw >> n & 1 != 0 && bit.role == Role::Level)
        .map(|(_, bit)| bit.one)
        .collect();
    if words.is_empty() { "nothing".into() } else { words.join(", ") }
}

/// What a drive says with a status word ZSW after `before`: the bits that tell something new to somebody who knows
/// what is fixed and what follows from other bits.
pub fn said(mode: Mode, before: u16, now: u16) -> String {
    let set = |bit: u8| now >> bit & 1 != 0;
    let implied = |bit: u8| IMPLIED.iter().any(|row| set(row.0) && row.1 == bit);
    let bits = bits(Word::Zsw, mode, None);
    let of = |n: u8| bits.get(usize::from(n)).filter(|bit| bit.role == Role::Level);
    let mut words: Vec<&str> = TELLING
        .iter()
        .filter(|n| set(**n) && !implied(**n))
        .filter_map(|n| of(*n).map(|bit| bit.one))
        .collect();
    if mode == Mode::Positioning && (before ^ now) >> JOB_TOGGLE & 1 != 0 {
        words.push("job taken over");
    }
    if words.is_empty() { "nothing".into() } else { words.join(", ") }
}

/// A word at octet `at`, with a field for each bit. Bits beside each other that are not used share one.
pub fn field(word: Word, mode: Mode, model: Option<Model>, at: usize, raw: u16) -> Field {
    let mut fields: Vec<Field> = Vec::new();
    for (n, bit) in (0..16_u8).zip(bits(word, mode, model)).rev() {
        let set = raw >> n & 1 != 0;
        let unused = |field: &Field| bit.key.is_empty() && field.name == UNUSED;
        if let Some(field) = fields.last_mut().filter(|field| unused(field))
            && let Some(place) = &mut field.bits
        {
            place.low = n;
            field.raw.push(if set { '1' } else { '0' });
            continue;
        }
        let name = if bit.key.is_empty() { UNUSED } else { bit.name };
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
const TELLING: [u8; 9] = [0, 2, 15, 3, 6, 7, 14, 10, 13];

/// A bit that says more makes another superfluous: an enabled drive is ready to turn on, one that is ready to travel
/// stands still. And nobody wants to read that a drive in fault is ready to turn on, which only means its supplies.
const IMPLIED: [(u8, u8); 4] = [(2, 0), (15, 13), (3, 0), (6, 0)];

/// The bit of the status word that toggles with each job taken over.
const JOB_TOGGLE: u8 = 12;

const UNUSED: &str = "not used";

/// A bit in both operating modes.
struct Row {
    positioning: Bit,
    velocity: Bit,
    /// The bit of an AG03 and of an AG03/1 where they differ, in both operating modes.
    models: Option<[Bit; 2]>,
}

impl Row {
    fn of(&self, mode: Mode, model: Option<Model>) -> &Bit {
        match (&self.models, model) {
            (Some([ag03, _]), Some(Model::Ag03)) => ag03,
            (Some([_, ag03_1]), Some(Model::Ag03_1)) => ag03_1,
            (None, _) | (Some(_), None) => match mode {
                Mode::Positioning => &self.positioning,
                Mode::Velocity => &self.velocity,
            },
        }
    }

    const fn velocity(self, velocity: Bit) -> Self {
        Self { velocity, ..self }
    }

    const fn models(self, ag03: Bit, ag03_1: Bit) -> Self {
        Self { models: Some([ag03, ag03_1]), ..self }
    }
}

const fn bit(
    key: &'static str,
    name: &'static str,
    one: &'static str,
    zero: &'static str,
    note: &'static str,
) -> Bit {
    Bit { key, name, one, zero, note, role: Role::Level }
}

const fn both(
    key: &'static str,
    name: &'static str,
    one: &'static str,
    zero: &'static str,
    note: &'static str,
) -> Row {
    let bit = bit(key, name, one, zero, note);
    Row { positioning: bit, velocity: bit, models: None }
}

const fn edge(bit: Bit) -> Bit {
    Bit { role: Role::Edge, ..bit }
}

const fn fixed(key: &'static str, name: &'static str, value: bool) -> Bit {
    let (one, zero) = if value { ("always 1", "0, which it never is") } else { ("1, must be 0", "always 0") };
    Bit { key, name, one, zero, note: "", role: Role::Fixed(value) }
}

const fn always(key: &'static str, name: &'static str, value: bool) -> Row {
    let bit = fixed(key, name, value);
    Row { positioning: bit, velocity: bit, models: None }
}

const NOT_USED: Bit =
    Bit { key: "", name: UNUSED, one: "no meaning", zero: "no meaning", note: "", role: Role::Unused };
const NONE: Row = Row { positioning: NOT_USED, velocity: NOT_USED, models: None };

#[rustfmt::skip] // one row per bit
const STW: [Row; 16] = [
    both("on", "ON / OFF1", "ON", "OFF1", "0 cancels the job, releases the motor, and ends turn-on disabled"),
    both("no-off2", "no OFF2", "no OFF2", "OFF2", "0 cancels the job and releases the motor"),
    always("off3", "OFF3", false),
    both("enable-operation", "enable operation", "enable operation", "disable operation", "0 brakes with maximum deceleration; the motor stays in control"),
    both("no-stop", "stop", "no stop", "stop", "0 brakes with maximum deceleration and discards the job").velocity(NOT_USED),
    both("no-intermediate-stop", "intermediate stop", "no intermediate stop", "intermediate stop", "0 brakes as programmed and keeps the job, 1 continues it").velocity(NOT_USED),
    Row {
        positioning: edge(bit("start", "activate travel job", "start bit 1", "start bit 0", "each change starts a job to the setpoint")),
        velocity: bit("start", "enable target value", "setpoint released", "setpoint not released", "1 turns with the setpoint, 0 runs down as programmed"),
        models: None,
    },
    both("acknowledge", "acknowledge", "acknowledge", "acknowledge over", "0 to 1 acknowledges a fault; turn-on disabled follows"),
    both("inch1", "inching 1", "inching 1", "inching 1 off", "travels once by delta inch").velocity(NOT_USED),
    both("inch2", "inching 2", "inching 2", "inching 2 off", "travels while 1").velocity(NOT_USED),
    NONE, NONE, NONE, NONE, NONE,
    both("inch2-negative", "direction of inching 2", "negative direction", "positive direction", "").velocity(NOT_USED),
];

#[rustfmt::skip] // one row per bit
const ZSW: [Row; 16] = [
    both("ready-to-turn-on", "ready to turn on", "ready to turn on", "not ready to turn on", "supplies present"),
    both("ready", "ready", "ready", "not ready", "identical with bit 0"),
    both("operation-enabled", "operation enabled", "enabled", "operation disabled", ""),
    both("fault", "fault", "FAULT", "no fault", ""),
    both("no-off2", "no OFF2", "no OFF2", "OFF2 given", ""),
    always("no-off3", "no OFF3", true),
    both("turn-on-disabled", "turn-on disabled", "turn-on disabled", "turn-on not disabled", ""),
    both("warning", "warning", "warning", "no warning", ""),
    both("no-lag-error", "no lag error", "no lag error", "lag error", "")
        .velocity(bit("in-window", "required and actual value within tolerance", "velocity in the window", "velocity outside the window", "")),
    always("control-requested", "control requested", true),
    both("target-reached", "target position reached", "target reached", "target not reached", "")
        .velocity(fixed("n-reached", "f or n reached", true)),
    always("reference-point-set", "reference point set", true)
        .velocity(fixed("device-specific-11", "device-specific", true)),
    Row {
        positioning: edge(bit("job-toggle", "acknowledgement of target value", "job bit 1", "job bit 0", "each change tells that a job was taken over")),
        velocity: fixed("device-specific-12", "device-specific", true),
        models: None,
    },
    both("standstill", "drive stands still", "stands still", "travels", ""),
    both("limit-exceeded", "limiting value exceeded", "beyond a limit", "within the limits", "")
        .velocity(fixed("device-specific-14", "device-specific", false)),
    both("ready-to-travel", "ready to travel", "ready to travel", "not ready to travel", ""),
];

#[rustfmt::skip] // one row per bit
const SSW: [Row; 16] = [
    NONE, NONE, NONE,
    both("in-position", "in position", "position in the window", "position outside the window", "")
        .velocity(bit("in-position", "in position", "velocity in the window", "velocity outside the window", "")),
    both("travels", "drive travels", "travels", "stands still", "standstill is below 2 rpm"),
    both("above-upper-limit", "upper limit", "above the upper limit", "not above the upper limit", "").velocity(NOT_USED),
    both("below-lower-limit", "lower limit", "below the lower limit", "not below the lower limit", "").velocity(NOT_USED),
    both("motor-released", "driver state", "motor released", "motor in control", ""),
    both("fault", "fault", "FAULT", "no fault", ""),
    both("loop-travel", "loop travel", "travels against the approach direction", "travels in the approach direction", "").velocity(NOT_USED),
    both("no-output-stage", "enable input or supply of the output stage", "output stage not enabled or not supplied", "output stage enabled and supplied", "AG03: enable input, AG03/1: supply").models(
        bit("no-output-stage", "enable input", "enable input not active", "enable input active", ""),
        bit("no-output-stage", "supply of the output stage", "output stage not supplied", "output stage supplied", ""),
    ),
    both("not-ready-to-travel", "ready to travel", "not ready to travel", "ready to travel", "1 means not"),
    both("battery-low", "battery voltage", "battery low", "battery in order", "replace it within half a year"),
    both("current-out-of-range", "motor current", "motor current out of range", "motor current in range", "fault C after 4 s"),
    both("positioning-active", "positioning", "positioning active", "no positioning active", "").velocity(NOT_USED),
    both("lag-error", "lag error", "lag error", "no lag error", ""),
];

#[rustfmt::skip] // one row per bit
const GENERAL_STATUS: [Row; 16] = [
    NONE, NONE, NONE, NONE,
    both("output-stage", "enable input or supply of the output stage", "output stage enabled and supplied", "output stage not enabled or not supplied", "AG03: enable input, AG03/1: supply").models(
        bit("output-stage", "enable input", "enable input active", "enable input not active", ""),
        bit("output-stage", "supply of the output stage", "output stage supplied", "output stage not supplied", ""),
    ),
    NONE, NONE,
    both("torque-deactivation", "torque deactivation", "torque deactivation has tripped", "torque deactivation has not tripped", "ends when the job is resumed"),
    NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE,
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::device::words::EVALUATED;

    const WORDS: [Word; 4] = [Word::Stw, Word::Zsw, Word::Ssw, Word::GeneralStatus];
    const MODES: [Mode; 2] = [Mode::Positioning, Mode::Velocity];

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
            (Mode::Positioning, 0xAB37, 0x1B37, "enabled, job taken over"),
            (Mode::Positioning, 0x3F3B, 0x3F3B, "FAULT, target reached, stands still"),
            (Mode::Positioning, 0x0A20, 0x0A20, "nothing"),
            (Mode::Velocity, 0x3E23, 0xBE37, "enabled, ready to travel"),
            (Mode::Velocity, 0xBE37, 0x1F37, "enabled"),
        ] {
            assert_eq!(said(mode, before, now), words, "{before:04X} {now:04X}");
        }
    }

    #[test]
    fn every_used_bit_has_a_key_of_its_own_and_words_for_both_values() {
        let models = [None, Some(Model::Ag03), Some(Model::Ag03_1)];
        let modes = MODES.into_iter().flat_map(|mode| models.map(|model| (mode, model)));
        for (word, (mode, model)) in
            WORDS.into_iter().flat_map(|word| modes.clone().map(move |of| (word, of)))
        {
            let used = bits(word, mode, model).into_iter().filter(|bit| bit.role != Role::Unused);
            let mut keys = BTreeSet::new();
            for bit in used {
                assert!(keys.insert(bit.key), "{word:?} {mode:?}: {} twice", bit.key);
                assert!(!bit.one.is_empty() && bit.one != bit.zero, "{word:?} {}", bit.key);
            }
        }
    }

    #[test]
    fn what_releases_the_output_stage_has_the_name_it_has_on_the_model() {
        for (model, missing, there) in [
            (Some(Model::Ag03), "enable input not active", "enable input active"),
            (Some(Model::Ag03_1), "output stage not supplied", "output stage supplied"),
            (None, "output stage not enabled or not supplied", "output stage enabled and supplied"),
        ] {
            for mode in MODES {
                let (ssw, gsr) =
                    (bits(Word::Ssw, mode, model)[10], bits(Word::GeneralStatus, mode, model)[4]);
                assert_eq!((ssw.meaning(true), ssw.meaning(false)), (missing, there));
                assert_eq!((gsr.meaning(false), gsr.meaning(true)), (missing, there));
                assert_eq!((ssw.key, gsr.key), ("no-output-stage", "output-stage"), "one key for programs");
            }
        }
    }

    #[test]
    fn the_control_bits_with_words_are_those_the_drive_evaluates() {
        for (n, bit) in (0..16).zip(bits(Word::Stw, Mode::Positioning, None)) {
            let evaluated = EVALUATED & 1 << n != 0;
            assert_eq!(matches!(bit.role, Role::Level | Role::Edge), evaluated, "STW.{n}");
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
