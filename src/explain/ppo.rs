//! The words of Data_Exchange: parameter channel, control and status word, setpoint and actual value; in a telegram
//! or alone.

use super::context::Learned;
use super::field::{Field, Mark};
use super::pkw::{self, known};
use super::words;
use super::{Explanation, Kind, Sender};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::{Gear, LOAD_PARAMETER_SET, Width};
use crate::devices::ag03::profibus::bits::{StwBit, Word, ZswBit};
use crate::devices::ag03::profibus::flow_charts;
use crate::profibus::ppo::{JobId, PPO_LEN, Pkw};

/// The 14 octets of a PPO from octet `at` on: its fields, and all in a few words.
pub(super) fn ppo(
    octets: &[u8; PPO_LEN],
    sender: Sender,
    at: usize,
    learned: &mut Learned,
) -> (Vec<Field>, String) {
    let &[a, b, c, d, e, f, g, h, ref rest @ ..] = octets;
    let channel = channel(Pkw::from_octets([a, b, c, d, e, f, g, h]), sender, at, learned);
    let (mut fields, words) = pzd(rest, sender, at + PKW_LEN, learned);
    fields.insert(0, channel.field);
    (fields, format!("{}; {words}", channel.summary))
}

/// Words without a telegram around them.
pub(super) fn bare(octets: &[u8], sender: Option<Sender>, learned: &mut Learned) -> Option<Explanation> {
    let sender = sender.unwrap_or_else(|| guess(octets, learned));
    let (kind, fields, summary) = match octets.len() {
        PPO_LEN => {
            let (fields, summary) = ppo(octets.first_chunk()?, sender, 0, learned);
            let which = match sender {
                Sender::Master => "PPO outputs",
                Sender::Slave => "PPO inputs",
            };
            (Kind::Ppo, fields, format!("{which}: {summary}"))
        }
        PKW_LEN => {
            let said = channel(Pkw::from_octets(*octets.first_chunk()?), sender, 0, learned);
            let summary = format!("{}: {}", said.field.name, said.summary);
            (Kind::Pkw, Vec::from([said.field]), summary)
        }
        PZD_LEN => {
            let (fields, summary) = pzd(octets.first_chunk()?, sender, 0, learned);
            (Kind::Pzd, fields, format!("PZD: {summary}"))
        }
        2 => {
            let (field, summary) = word_5(u16::from_be_bytes(*octets.first_chunk()?), sender, 0, learned);
            (Kind::Word, Vec::from([field]), summary)
        }
        _ => return None,
    };
    let octets = Vec::from(octets);
    let sender = Some(sender);
    Some(Explanation { kind, id: None, sender, from: None, to: None, service: None, summary, octets, fields })
}

const PKW_LEN: usize = 8;
const PZD_LEN: usize = 6;

fn channel(pkw: Pkw, sender: Sender, at: usize, learned: &mut Learned) -> pkw::Said {
    learned.last = Some(sender);
    match sender {
        Sender::Master => {
            learned.hear_job(pkw);
            pkw::job(pkw, at, learned)
        }
        Sender::Slave => {
            learned.hear_reply(pkw);
            pkw::reply(pkw, at, learned)
        }
    }
}

fn pzd(octets: &[u8; PZD_LEN], sender: Sender, at: usize, learned: &mut Learned) -> (Vec<Field>, String) {
    let &[a, b, c, d, e, f] = octets;
    let (first, words) = word_5(u16::from_be_bytes([a, b]), sender, at, learned);
    let (second, value) = main_value(i32::from_be_bytes([c, d, e, f]), sender, at + 2, learned);
    (Vec::from([first, second]), format!("{words}; {value}"))
}

/// Control word or status word.
fn word_5(raw: u16, sender: Sender, at: usize, learned: &mut Learned) -> (Field, String) {
    let mode = learned.mode();
    let (word, before) = match sender {
        Sender::Master => (Word::Stw, &mut learned.stw),
        Sender::Slave => (Word::Zsw, &mut learned.zsw),
    };
    let said = match sender {
        Sender::Master => words::on(word, mode, raw),
        Sender::Slave => words::said(mode, *before, raw),
    };
    let meaning = match sender {
        Sender::Master => match words::changes(word, mode, *before, raw).as_str() {
            "no change" => said.clone(),
            changes if changes == said => said.clone(),
            changes => format!("{said}; new: {changes}"),
        },
        Sender::Slave => said.clone(),
    };
    *before = raw;
    let mut field = words::field(word, mode, learned.model, at, raw);
    field.meaning = format!("{meaning} ({} mode)", mode_name(mode));
    let field = match sender {
        Sender::Master => judge_stw(field, mode, raw),
        Sender::Slave => judge_zsw(field, raw),
    };
    (field, format!("{} {raw:04X} ({said})", word.name()))
}

fn main_value(value: i32, sender: Sender, at: usize, learned: &Learned) -> (Field, String) {
    let name = match sender {
        Sender::Master => "HSW",
        Sender::Slave => "HIW",
    };
    let (text, what) = match (learned.mode(), sender) {
        (Mode::Positioning, Sender::Master) => {
            (learned.lengths.position(value.into()).to_string(), "target position")
        }
        (Mode::Positioning, Sender::Slave) => {
            (learned.lengths.position(value.into()).to_string(), "actual position")
        }
        (Mode::Velocity, Sender::Master) => (format!("{value} rpm"), "target velocity"),
        (Mode::Velocity, Sender::Slave) => (format!("{value} rpm"), "actual velocity"),
    };
    let short = match sender {
        Sender::Master => "setpoint",
        Sender::Slave => "actual value",
    };
    let mut field = Field::octets(name, at, &value.to_be_bytes(), format!("{what} {text}"));
    if learned.mode() == Mode::Velocity
        && value.unsigned_abs() > Gear::FASTEST.max_rpm().into()
        && sender == Sender::Master
    {
        let of = |gear: Gear| format!("{} rpm ({gear}:1)", gear.max_rpm());
        let most: Vec<String> = Gear::ALL.into_iter().map(of).collect();
        field = field.mistaken(format!("no gear turns faster than {}", most.join(" or ")));
    }
    (field, format!("{short} {value}"))
}

const fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Positioning => "positioning",
        Mode::Velocity => "velocity",
    }
}

fn judge_stw(mut field: Field, mode: Mode, raw: u16) -> Field {
    if flow_charts::PRINTED.contains(&raw.swap_bytes()) && !flow_charts::PRINTED.contains(&raw) {
        let text = format!(
            "with its octets exchanged it is {:04X}: the high octet of a word comes first",
            raw.swap_bytes()
        );
        field = field.mistaken(text);
    }
    if StwBit::Off3.is_set(raw) {
        let text = "bit 2 (OFF3) is not implemented and must be 0 by the manual: 047E, 047F and 000F of Siemens' \
                    examples are 000A and 000B here";
        field = field.hinted(text);
    }
    if raw & Word::Stw.without_meaning(Mode::Positioning) & !StwBit::Off3.mask() != 0 {
        let also = if raw & CONTROL_BY_PLC != 0 { "; bit 10, control by PLC, is not needed" } else { "" };
        field = field.hinted(format!("bits 10 to 14 are not supported{also}"));
    }
    match mode {
        Mode::Positioning if raw & INCHING == INCHING => {
            field.mistaken("inching 1 and inching 2 exclude each other")
        }
        Mode::Velocity if raw & (INCHING | StwBit::Inching2Negative.mask()) != 0 => {
            field.hinted("inching needs the positioning mode")
        }
        Mode::Positioning | Mode::Velocity => field,
    }
}

const INCHING: u16 = StwBit::Inching1.mask() | StwBit::Inching2.mask();
/// Bit 10 of the standard's control word, which these drives do not have.
const CONTROL_BY_PLC: u16 = 0x0400;

fn judge_zsw(field: Field, raw: u16) -> Field {
    let trouble = ZswBit::Fault.is_set(raw) || ZswBit::TurnOnDisabled.is_set(raw);
    let field = field.marked_if(Mark::Trouble, trouble);
    if is_status(raw) || raw == 0 {
        field
    } else {
        field.mistaken("bits 5, 9 and 11 are always 1 in the status word of these drives: check that this is a status word")
    }
}

/// Whether 6 or 14 octets can be words: the control word without a bit that these drives do not support, or a status
/// word.
pub(super) fn makes_sense(octets: &[u8]) -> bool {
    let word = match *octets {
        [high, low, _, _, _, _] | [_, _, _, _, _, _, _, _, high, low, _, _, _, _] => {
            u16::from_be_bytes([high, low])
        }
        _ => return false,
    };
    is_status(word) || word & Word::Stw.without_meaning(Mode::Positioning) == 0
}

/// Whether the bits are 1 that are 1 in every status word, and all together in no control word.
fn is_status(word: u16) -> bool {
    word & Word::Zsw.always_1() == Word::Zsw.always_1()
}

/// Who says such words. A status word has bits that are always 1 and that no control word has all set; of a parameter
/// channel alone the job before, the direction of its numbers and its value tell.
fn guess(octets: &[u8], learned: &Learned) -> Sender {
    let by_status = |word: u16| if is_status(word) { Sender::Slave } else { Sender::Master };
    match *octets {
        [high, low] => by_status(u16::from_be_bytes([high, low])),
        [high, low, _, _, _, _] => by_status(u16::from_be_bytes([high, low])),
        [_, _, _, _, _, _, _, _, high, low, _, _, _, _] => by_status(u16::from_be_bytes([high, low])),
        [a, b, c, d, e, f, g, h] => guess_pkw(Pkw::from_octets([a, b, c, d, e, f, g, h]), learned),
        _ => Sender::Master,
    }
}

fn guess_pkw(pkw: Pkw, learned: &Learned) -> Sender {
    let pnu = pkw.pke.pnu();
    let double = known(pnu).map(|entry| entry.width == Width::Double);
    let array = known(pnu).is_some_and(|entry| entry.elements.is_some());
    let answers = learned.last == Some(Sender::Master) && learned.answers(pkw) == Some(true);
    let reply = match pkw.pke.job() {
        JobId::NoJob => false,
        // As a reply: a word. A value of 0 reads like the job; only a job before it tells.
        JobId::Read => double != Some(true) && (pkw.double_word() != 0 || answers),
        // As a reply: a double word. Of PNU 970 only the value tells (`ag03.md` C-15).
        JobId::WriteWord if pnu == LOAD_PARAMETER_SET.number() => pkw.double_word() == 0,
        JobId::WriteWord => double == Some(true),
        JobId::WriteDoubleWord => false,
        // As replies: an array word, an array double word, a number of elements.
        JobId::ReadDescription | JobId::WriteDescription => array,
        JobId::ReadElement => pkw.double_word() != 0,
        // As a reply: an error, which for a parameter that exists is not 0 ("no such number").
        JobId::WriteElementWord => {
            pkw.pwe_high == 0 && pkw.word() <= MOST_ERROR && (pkw.word() != 0 || known(pnu).is_none())
        }
        // As a reply: no control rights.
        JobId::WriteElementDoubleWord => answers && pkw.double_word() == 0,
        JobId::ReadElementCount => false,
        JobId::Reserved(_) => pkw.pke.ak() <= 12,
    };
    if reply { Sender::Slave } else { Sender::Master }
}

/// The highest error number of the manual's table.
const MOST_ERROR: u16 = 19;

#[cfg(test)]
mod tests;
