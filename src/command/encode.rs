//! `profidrive encode`: words and telegrams from names, with their derivation.
//!
//! What is built is explained by `crate::explain`, as `decode` does: that is the derivation, and it says what is a
//! mistake.

mod pkw;
mod telegram;
mod words;

use std::io::{self, Write};

use crate::devices::named_word::NamedWords;
use crate::explain::{Context, Explanation, HexText, Kind, Mark, Mode, Sender, hex};
use crate::host::list::{DEVICES, Device};
use crate::profibus::fdl::Address;
use crate::profibus::ppo::Pkw;
use serde::Serialize;

use super::Failure;
use super::args::{Encode, What};

/// Prints what is asked for.
pub(crate) fn encode(args: &Encode) -> Result<(), Failure> {
    let explanation = build(args)?;
    let text = match (args.json, args.octets) {
        (true, _) => {
            let built = Built {
                words: words_of(&explanation).collect(),
                mark: explanation.mark(),
                hints: explanation.hints(),
                explanation: &explanation,
            };
            let object = serde_json::to_string(&built);
            format!("{}\n", object.map_err(|error| Failure::from_error(&error))?)
        }
        (false, true) => format!("{}\n", hex(&explanation.octets)),
        (false, false) => derivation(&explanation),
    };
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Other(format!("cannot write to stdout: {error}")))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}

/// The object of `--json`.
#[derive(Serialize)]
struct Built<'a> {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    words: Vec<String>,
    mark: Mark,
    hints: Vec<&'a str>,
    #[serde(flatten)]
    explanation: &'a Explanation,
}

fn build(args: &Encode) -> Result<Explanation, Failure> {
    let mode = args.mode;
    let explanation = match &args.what {
        What::Pkw(what) => {
            let (pkw, sender) = pkw::build(what, args.force)?;
            bare(&pkw.to_octets(), sender, mode)?
        }
        What::Stw(word) => {
            bare(&words::build(&words_of_list()?.stw, word, mode)?, Some(Sender::Master), mode)?
        }
        What::Zsw(word) => {
            bare(&words::build(&words_of_list()?.zsw, word, mode)?, Some(Sender::Slave), mode)?
        }
        What::Telegram(telegram) => {
            let octets = telegram::build(telegram, mode)?;
            let mut context = Context::with_mode(mode);
            // Whoever asks for a telegram asks for one that such a drive takes.
            context.know_named(Address::from_octet(telegram.address), mode);
            context.telegram(&octets)
        }
    };
    match reason_against(&explanation)? {
        Some(why) if !args.force => Err(Failure::Usage(format!("{why}; --force builds it nevertheless"))),
        Some(_) | None => Ok(explanation),
    }
}

/// What is mistaken about it, or which bits of a control word the drive does not look at.
fn reason_against(explanation: &Explanation) -> Result<Option<String>, Failure> {
    let control_word = words_of_list()?.stw.name;
    let mut reason = None;
    explanation.walk(&mut |_, field| {
        let against = field.mark >= Mark::Mistake || field.name == control_word;
        if reason.is_none() && against {
            reason = field.hints.first().cloned();
        }
    });
    Ok(reason.or_else(|| (explanation.mark() >= Mark::Mistake).then(|| explanation.summary.clone())))
}

/// The words of the first device in the list that writes them in names.
fn words_of_list() -> Result<&'static NamedWords, Failure> {
    let words = DEVICES.iter().find_map(Device::words);
    words.ok_or_else(|| Failure::Other("no device writes its words in names".into()))
}

fn bare(octets: &[u8], sender: Option<Sender>, mode: Mode) -> Result<Explanation, Failure> {
    let explanation = Context::with_mode(mode).bare(octets, sender);
    explanation.ok_or_else(|| Failure::Other(format!("{} octets are no words", octets.len())))
}

/// Words, octets, and how they come about.
fn derivation(explanation: &Explanation) -> String {
    let words: Vec<String> = words_of(explanation).collect();
    let words = if words.is_empty() { String::new() } else { format!("words   {}\n", words.join(" ")) };
    format!("{words}octets  {}\n\n{explanation}", hex(&explanation.octets))
}

/// What consists of words, as words.
fn words_of(explanation: &Explanation) -> impl Iterator<Item = String> {
    let octets: &[u8] = match explanation.kind {
        Kind::Ppo | Kind::Pkw | Kind::Pzd | Kind::Word => &explanation.octets,
        Kind::Telegram | Kind::Token | Kind::Frame | Kind::ErrorFrame | Kind::Noise => &[],
    };
    octets.as_chunks().0.iter().map(|word| format!("{:04X}", u16::from_be_bytes(*word)))
}

/// The octets of arguments in hexadecimal.
fn octets_of(arguments: &[String]) -> Result<Vec<u8>, Failure> {
    let octets = HexText::default().octets(&arguments.join(" "));
    octets.map_err(|error| Failure::Usage(error.to_string()))
}

/// Four words in hexadecimal.
fn pkw_of(words: &str) -> Result<Pkw, Failure> {
    let octets = octets_of(&[words.to_owned()])?;
    let got = octets.len();
    let octets = octets.try_into();
    octets.map(Pkw::from_octets).map_err(|_| {
        Failure::Usage(format!(
            "'{words}' has {got} octets; a PKW has four words, for example 13FA 0000 0000 0000"
        ))
    })
}
