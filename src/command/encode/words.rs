//! Control and status words from names.

use crate::devices::named_word::NamedWord;
use crate::explain::Mode;

use crate::command::Failure;
use crate::command::args;

/// The octets of the word and, if it is given, of the value behind it.
pub(super) fn build(named: &NamedWord, args: &args::Word, mode: Mode) -> Result<Vec<u8>, Failure> {
    let word = word_of(named, &args.terms, mode)?;
    let mut octets = Vec::from(word.to_be_bytes());
    if let Some(value) = args.value {
        octets.extend(value.to_be_bytes());
    }
    Ok(octets)
}

/// The word that the terms make, one after the other.
pub(super) fn word_of(named: &NamedWord, terms: &[String], mode: Mode) -> Result<u16, Failure> {
    terms.iter().try_fold(0, |word, term| apply(named, word, term, mode)).map_err(Failure::Usage)
}

fn apply(named: &NamedWord, word: u16, term: &str, mode: Mode) -> Result<u16, String> {
    if let Some((bit, value)) = term.split_once('=') {
        let mask = 1 << bit_of(named, bit, mode)?;
        return match value {
            "1" => Ok(word | mask),
            "0" => Ok(word & !mask),
            _ => Err(format!("'{term}': a bit is 0 or 1, for example {bit}=1")),
        };
    }
    if let Some((name, positioning, velocity)) = named.states.iter().find(|state| state.0 == term) {
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
    if bit_of(named, term, mode).is_ok() {
        return Err(format!("'{term}' is a bit; say {term}=0 or {term}=1"));
    }
    let states: Vec<&str> = named.states.iter().map(|state| state.0).collect();
    Err(format!("'{term}' is no state, bit or word of four digits; states are {}", states.join(", ")))
}

/// The number of a bit with this key or number.
fn bit_of(named: &NamedWord, name: &str, mode: Mode) -> Result<u8, String> {
    if let Ok(number @ 0..=15) = name.parse() {
        return Ok(number);
    }
    let keys = (named.bits)(mode);
    let found = (0..).zip(keys).find(|(_, key)| *key == Some(name));
    found.map(|(number, _)| number).ok_or_else(|| {
        let keys: Vec<&str> = keys.into_iter().flatten().collect();
        format!("'{name}' is no bit of {}; bits are 0 to 15 or {}", named.name, keys.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::encode::words_of_list;

    fn stw() -> &'static NamedWord {
        &words_of_list().unwrap().stw
    }

    fn zsw() -> &'static NamedWord {
        &words_of_list().unwrap().zsw
    }

    fn word(named: &NamedWord, terms: &str, mode: Mode) -> Result<u16, String> {
        let terms: Vec<String> = terms.split(' ').map(String::from).collect();
        word_of(named, &terms, mode).map_err(|failure| match failure {
            Failure::Usage(line) | Failure::Other(line) => line,
        })
    }

    #[test]
    fn terms_change_the_word_one_after_the_other() {
        use Mode::{Positioning, Velocity};
        for (named, terms, mode, expected) in [
            (stw(), "off", Positioning, 0x0000),
            (stw(), "enable", Positioning, 0x000B),
            (stw(), "prepare start=1", Positioning, 0x007B),
            (stw(), "007B no-intermediate-stop=0", Positioning, 0x005B),
            (stw(), "0x003B 6=1 0=0", Positioning, 0x007A),
            (stw(), "jog-", Positioning, 0x820B),
            (stw(), "run", Velocity, 0x004B),
            (stw(), "enable start=1", Velocity, 0x004B),
            (zsw(), "ready-to-travel", Positioning, 0xAB37),
            (zsw(), "travelling job-toggle=1", Positioning, 0x1B37),
            (zsw(), "ready-to-travel", Velocity, 0xBE37),
        ] {
            assert_eq!(word(named, terms, mode), Ok(expected), "{terms}");
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
            let error = word(stw(), terms, mode).unwrap_err();
            assert!(error.contains(says), "{terms}: {error}");
        }
    }

    #[test]
    fn every_state_is_one_that_the_explanation_finds_no_mistake_in() {
        use crate::explain::{Context, Mark, Sender};
        for (named, sender) in [(stw(), Sender::Master), (zsw(), Sender::Slave)] {
            for (name, positioning, velocity) in named.states {
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
