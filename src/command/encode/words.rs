//! Control and status words from names.

use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::{Role, StwBit, Word, ZswBit, bits};
use crate::devices::ag03::profibus::flow_charts::{
    DISABLED, ENABLED, INCHING_1, INCHING_2_NEGATIVE, INCHING_2_POSITIVE, PAUSED, START, STOPPED, TRAVEL,
    VELOCITY,
};

use crate::command::Failure;
use crate::command::args;

/// A word of bits and the states of the manual's flow charts in it.
#[derive(Clone, Copy)]
pub(super) struct Vocabulary {
    word: Word,
    states: &'static [State],
}

/// Name of a state, its word in positioning and in velocity mode, if it exists there.
type State = (&'static str, Option<u16>, Option<u16>);

/// Control words (`ag03.md` 4 and 7).
pub(super) const STW: Vocabulary = Vocabulary {
    word: Word::Stw,
    states: &[
        ("off", Some(0), Some(0)),
        ("enable", Some(ENABLED), Some(ENABLED)),
        ("prepare", Some(TRAVEL), None),
        ("start", Some(TRAVEL | START), None),
        ("run", None, Some(VELOCITY)),
        // These follow start: its bit 6 stays, for a change would be another job.
        ("pause", Some(PAUSED | START), None),
        ("resume", Some(TRAVEL | START), None),
        ("stop", Some(STOPPED | START), Some(ENABLED)),
        ("disable", Some(DISABLED), Some(DISABLED)),
        ("off1", Some(ENABLED & !StwBit::On.mask()), Some(ENABLED & !StwBit::On.mask())),
        ("off2", Some(ENABLED & !StwBit::NoOff2.mask()), Some(ENABLED & !StwBit::NoOff2.mask())),
        (
            "acknowledge",
            Some(ENABLED | StwBit::Acknowledge.mask()),
            Some(ENABLED | StwBit::Acknowledge.mask()),
        ),
        ("inch1", Some(INCHING_1), None),
        ("jog+", Some(INCHING_2_POSITIVE), None),
        ("jog-", Some(INCHING_2_NEGATIVE), None),
    ],
};

/// Status words (`ag03.md` 5), without OFF2, warning and limit.
pub(super) const ZSW: Vocabulary = Vocabulary {
    word: Word::Zsw,
    states: &[
        ("ready-to-run", Some(STANDS), Some(STANDS_IN_VELOCITY_MODE)),
        ("ready-to-travel", Some(STANDS | READY), Some(STANDS_IN_VELOCITY_MODE | READY)),
        ("travelling", Some(TRAVELS), Some(TRAVELS_IN_VELOCITY_MODE)),
        ("arrived", Some(STANDS | READY | ZswBit::TargetReached.mask()), None),
        ("fault", Some(STANDS | FAULT), Some(STANDS_IN_VELOCITY_MODE | FAULT)),
        (
            "turn-on-disabled",
            Some(STANDS | TURN_ON_DISABLED),
            Some(STANDS_IN_VELOCITY_MODE | TURN_ON_DISABLED),
        ),
    ],
};

/// Ready to turn on, no OFF2, standing still.
const STANDS: u16 = NOT_ENABLED | ZswBit::NoLagError.mask() | ZswBit::Standstill.mask();
const STANDS_IN_VELOCITY_MODE: u16 = NOT_ENABLED | FIXED_IN_VELOCITY_MODE | ZswBit::Standstill.mask();
const TRAVELS: u16 = NOT_ENABLED | ZswBit::NoLagError.mask() | ENABLED_NOW;
const TRAVELS_IN_VELOCITY_MODE: u16 = NOT_ENABLED | FIXED_IN_VELOCITY_MODE | ENABLED_NOW;
const READY: u16 = ENABLED_NOW | ZswBit::ReadyToTravel.mask();
const FAULT: u16 = ZswBit::Fault.mask();
const TURN_ON_DISABLED: u16 = ZswBit::TurnOnDisabled.mask();

const ENABLED_NOW: u16 = ZswBit::OperationEnabled.mask();
const FIXED_IN_VELOCITY_MODE: u16 = ZswBit::TargetReached.mask() | ZswBit::JobToggle.mask();
/// Supplies present, no OFF2, and what is always 1.
const NOT_ENABLED: u16 = ZswBit::ReadyToTurnOn.mask()
    | ZswBit::Ready.mask()
    | ZswBit::NoOff2.mask()
    | ZswBit::NoOff3.mask()
    | ZswBit::ControlRequested.mask()
    | ZswBit::ReferencePointSet.mask();

/// The octets of the word and, if it is given, of the value behind it.
pub(super) fn build(vocabulary: Vocabulary, args: &args::Word, mode: Mode) -> Result<Vec<u8>, Failure> {
    let word = word_of(vocabulary, &args.terms, mode)?;
    let mut octets = Vec::from(word.to_be_bytes());
    if let Some(value) = args.value {
        octets.extend(value.to_be_bytes());
    }
    Ok(octets)
}

/// The word that the terms make, one after the other.
pub(super) fn word_of(vocabulary: Vocabulary, terms: &[String], mode: Mode) -> Result<u16, Failure> {
    terms.iter().try_fold(0, |word, term| apply(vocabulary, word, term, mode)).map_err(Failure::Usage)
}

fn apply(vocabulary: Vocabulary, word: u16, term: &str, mode: Mode) -> Result<u16, String> {
    if let Some((bit, value)) = term.split_once('=') {
        let mask = 1 << bit_of(vocabulary.word, bit, mode)?;
        return match value {
            "1" => Ok(word | mask),
            "0" => Ok(word & !mask),
            _ => Err(format!("'{term}': a bit is 0 or 1, for example {bit}=1")),
        };
    }
    if let Some((name, positioning, velocity)) = vocabulary.states.iter().find(|state| state.0 == term) {
        let of_mode = match mode {
            Mode::Positioning => *positioning,
            Mode::Velocity => *velocity,
        };
        return of_mode.ok_or_else(|| format!("'{name}' belongs to the other operating mode; see --mode"));
    }
    let digits = term.strip_prefix("0x").unwrap_or(term);
    if digits.len() == 4
        && let Ok(word) = u16::from_str_radix(digits, 16)
    {
        return Ok(word);
    }
    if bit_of(vocabulary.word, term, mode).is_ok() {
        return Err(format!("'{term}' is a bit; say {term}=0 or {term}=1"));
    }
    let states: Vec<&str> = vocabulary.states.iter().map(|state| state.0).collect();
    Err(format!("'{term}' is no state, bit or word of four digits; states are {}", states.join(", ")))
}

/// The number of a bit with this key or number.
fn bit_of(word: Word, name: &str, mode: Mode) -> Result<u8, String> {
    if let Ok(number @ 0..=15) = name.parse() {
        return Ok(number);
    }
    let used = || (0..).zip(bits(word, mode, None)).filter(|(_, bit)| bit.role != Role::Unused);
    used().find(|(_, bit)| bit.key == name).map(|(n, _)| n).ok_or_else(|| {
        let keys: Vec<&str> = used().map(|(_, bit)| bit.key).collect();
        format!("'{name}' is no bit of {}; bits are 0 to 15 or {}", word.name(), keys.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(vocabulary: Vocabulary, terms: &str, mode: Mode) -> Result<u16, String> {
        let terms: Vec<String> = terms.split(' ').map(String::from).collect();
        word_of(vocabulary, &terms, mode).map_err(|failure| match failure {
            Failure::Usage(line) | Failure::Other(line) => line,
        })
    }

    #[test]
    fn terms_change_the_word_one_after_the_other() {
        use Mode::{Positioning, Velocity};
        for (vocabulary, terms, mode, expected) in [
            (STW, "off", Positioning, 0x0000),
            (STW, "enable", Positioning, 0x000B),
            (STW, "prepare start=1", Positioning, 0x007B),
            (STW, "007B no-intermediate-stop=0", Positioning, 0x005B),
            (STW, "0x003B 6=1 0=0", Positioning, 0x007A),
            (STW, "jog-", Positioning, 0x820B),
            (STW, "run", Velocity, 0x004B),
            (STW, "enable start=1", Velocity, 0x004B),
            (ZSW, "ready-to-travel", Positioning, 0xAB37),
            (ZSW, "travelling job-toggle=1", Positioning, 0x1B37),
            (ZSW, "ready-to-travel", Velocity, 0xBE37),
        ] {
            assert_eq!(word(vocabulary, terms, mode), Ok(expected), "{terms}");
        }
    }

    #[test]
    fn what_is_no_term_says_what_there_is() {
        use Mode::{Positioning, Velocity};
        for (terms, mode, says) in [
            (
                "enabel",
                Positioning,
                "'enabel' is no state, bit or word of four digits; states are off, enable,",
            ),
            ("start=2", Positioning, "a bit is 0 or 1, for example start=1"),
            ("nothing=1", Positioning, "'nothing' is no bit of STW; bits are 0 to 15 or on, no-off2"),
            ("16=1", Positioning, "'16' is no bit of STW"),
            ("no-stop", Positioning, "'no-stop' is a bit; say no-stop=0 or no-stop=1"),
            ("run", Positioning, "'run' belongs to the other operating mode"),
            ("inch2=1", Velocity, "'inch2' is no bit of STW"),
        ] {
            let error = word(STW, terms, mode).unwrap_err();
            assert!(error.contains(says), "{terms}: {error}");
        }
    }

    #[test]
    fn every_state_is_one_that_the_explanation_finds_no_mistake_in() {
        use crate::explain::{Context, Mark, Sender};
        for (vocabulary, sender) in [(STW, Sender::Master), (ZSW, Sender::Slave)] {
            for (name, positioning, velocity) in vocabulary.states {
                for (mode, word) in [(Mode::Positioning, positioning), (Mode::Velocity, velocity)] {
                    let Some(word) = word else { continue };
                    let explained = Context::with_mode(mode).bare(&word.to_be_bytes(), Some(sender)).unwrap();
                    assert!(explained.mark() < Mark::Mistake, "{name}: {:?}", explained.hints());
                    assert!(explained.hints().is_empty(), "{name}: {:?}", explained.hints());
                }
            }
        }
    }
}
