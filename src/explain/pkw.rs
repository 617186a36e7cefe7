//! The parameter channel: what a job asks, what a reply says.

mod hints;
mod numbers;

use super::context::Learned;
use super::field::{Bits, Field, Mark};
use super::value;
use super::words;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::{Entry, Kind, Model, Models, Pnu, Value, Width, entry};
use crate::devices::ag03::profibus::bits::Word;
use crate::profibus::pkw::ErrorNumber;
use crate::profibus::ppo::{JobId, Pkw, ReplyId};

pub(super) use hints::judge;
pub(super) use numbers::standard_name;

/// A word channel explained: its field, and in a few words.
pub(super) struct Said {
    pub(super) field: Field,
    pub(super) summary: String,
}

/// The parameter as far as one of the models has it. The AG03/1 has all that the AG03 has.
pub(super) fn known(pnu: u16) -> Option<&'static Entry> {
    entry(Model::Ag03_1, Pnu::from_low_bits(pnu))
}

/// Number and name: `PNU 1018 Calibration value`.
pub(super) fn named(pnu: u16) -> String {
    match (known(pnu), standard_name(pnu)) {
        (Some(entry), _) => format!("PNU {pnu} {}", entry.name),
        (None, Some(name)) => format!("PNU {pnu} ({name} in the profile)"),
        (None, None) => format!("PNU {pnu}"),
    }
}

/// A job, the four words of a master from octet `at` on.
pub(super) fn job(pkw: Pkw, at: usize, learned: &Learned) -> Said {
    let job = pkw.pke.job();
    let parameter = named(pkw.pke.pnu());
    let (summary, value) = match job {
        JobId::NoJob => ("no job".into(), Pwe::none()),
        JobId::Read => (format!("read {parameter}"), Pwe::none()),
        JobId::WriteWord => write_job(&parameter, pkw, Width::Word, learned),
        JobId::WriteDoubleWord => write_job(&parameter, pkw, Width::Double, learned),
        JobId::ReadDescription => {
            (format!("read the description of {parameter}, element {}", subindex(pkw)), Pwe::none())
        }
        JobId::WriteDescription => {
            let pwe = Pwe::double(pkw.double_word().to_string());
            (format!("write the description of {parameter}, element {}", subindex(pkw)), pwe)
        }
        JobId::ReadElement => (format!("read element {} of {parameter}", subindex(pkw)), Pwe::none()),
        JobId::WriteElementWord | JobId::WriteElementDoubleWord => {
            let width = if job == JobId::WriteElementWord { Width::Word } else { Width::Double };
            write_job(&format!("element {} of {parameter}", subindex(pkw)), pkw, width, learned)
        }
        JobId::ReadElementCount => (format!("read how many elements {parameter} has"), Pwe::none()),
        JobId::Reserved(_) => (format!("{job} for {parameter}"), Pwe::double("not judged".into())),
    };
    let array = match job {
        JobId::ReadElement | JobId::WriteElementWord | JobId::WriteElementDoubleWord => true,
        JobId::NoJob
        | JobId::Read
        | JobId::WriteWord
        | JobId::WriteDoubleWord
        | JobId::ReadDescription
        | JobId::WriteDescription
        | JobId::ReadElementCount
        | JobId::Reserved(_) => false,
    };
    let mut field = Field::octets("PKW job", at, &pkw.to_octets(), "").with(Vec::from([
        pke_field(pkw, at, job.to_string()),
        ind_field(pkw, at + 2, array),
        value.field(pkw, at + 4),
    ]));
    judge(pkw, &mut field);
    field.meaning.clone_from(&summary);
    Said { field, summary }
}

/// A reply, the four words of a drive from octet `at` on. What it answers is in `learned`.
pub(super) fn reply(pkw: Pkw, at: usize, learned: &Learned) -> Said {
    let reply = pkw.pke.reply();
    let parameter = named(pkw.pke.pnu());
    let (summary, value) = match reply {
        ReplyId::NoReply => ("no reply".into(), Pwe::none()),
        ReplyId::Word => value_reply(&parameter, pkw, Width::Word, learned),
        ReplyId::DoubleWord => value_reply(&parameter, pkw, Width::Double, learned),
        ReplyId::Description => {
            let pwe = Pwe::double(pkw.double_word().to_string());
            (format!("description of {parameter}, element {}", subindex(pkw)), pwe)
        }
        ReplyId::ElementWord | ReplyId::ElementDoubleWord => {
            let width = if reply == ReplyId::ElementWord { Width::Word } else { Width::Double };
            value_reply(&format!("element {} of {parameter}", subindex(pkw)), pkw, width, learned)
        }
        ReplyId::ElementCount => {
            let text = format!("{} elements", pkw.word());
            (format!("{parameter} has {text}"), Pwe::word(text))
        }
        ReplyId::NotExecutable => {
            let text = match ErrorNumber::from_number(pkw.word()) {
                Some(error) => error.to_string(),
                None => format!(
                    "error {}, not in the manual's table: another drive or a later profile",
                    pkw.word()
                ),
            };
            (format!("{parameter} refused: {text}"), Pwe { mark: Mark::Trouble, ..Pwe::word(text) })
        }
        ReplyId::NoControlRights => {
            let summary = format!("{parameter} refused: the parameter channel has no control rights");
            (summary, Pwe { mark: Mark::Trouble, ..Pwe::none() })
        }
        ReplyId::Reserved(_) => {
            let text = if pkw.pke.ak() <= LAST_SPONTANEOUS {
                "spontaneous message, which these drives do not send"
            } else {
                "reserved reply"
            };
            (format!("{text}: {parameter}"), Pwe::double(pkw.double_word().to_string()))
        }
    };
    let array = matches!(reply, ReplyId::ElementWord | ReplyId::ElementDoubleWord);
    let mut field = Field::octets("PKW reply", at, &pkw.to_octets(), summary.clone()).with(Vec::from([
        pke_field(pkw, at, reply.to_string()),
        ind_field(pkw, at + 2, array),
        value.field(pkw, at + 4),
    ]));
    hints::judge_reply(pkw, learned, &mut field);
    Said { field, summary }
}

/// What PWE holds: in which of its words, and in words.
struct Pwe {
    width: Option<Width>,
    text: String,
    mark: Mark,
    bits: Option<(Word, Mode, Option<Model>)>,
}

impl Pwe {
    const fn none() -> Self {
        Self { width: None, text: String::new(), mark: Mark::Plain, bits: None }
    }

    fn word(text: String) -> Self {
        Self { width: Some(Width::Word), text, ..Self::none() }
    }

    fn double(text: String) -> Self {
        Self { width: Some(Width::Double), text, ..Self::none() }
    }

    /// Words 3 and 4.
    fn field(self, pkw: Pkw, at: usize) -> Field {
        let [_, _, _, _, a, b, c, d] = pkw.to_octets();
        match self.width {
            None => Field::octets("PWE", at, &[a, b, c, d], "not used").marked(self.mark),
            Some(Width::Double) => Field::octets("PWE", at, &[a, b, c, d], self.text).marked(self.mark),
            Some(Width::Word) => {
                let high = Field::word("PWE high", at, pkw.pwe_high, "not used");
                let mut low = Field::word("PWE low", at + 2, pkw.pwe_low, self.text.clone());
                if let Some((word, mode, model)) = self.bits {
                    low.fields = words::field(word, mode, model, at + 2, pkw.pwe_low).fields;
                }
                Field::octets("PWE", at, &[a, b, c, d], "").with(Vec::from([high, low.marked(self.mark)]))
            }
        }
    }
}

fn write_job(parameter: &str, pkw: Pkw, width: Width, learned: &Learned) -> (String, Pwe) {
    let pwe = valued(pkw, width, learned);
    (format!("write {parameter} = {}", pwe.text), pwe)
}

fn value_reply(parameter: &str, pkw: Pkw, width: Width, learned: &Learned) -> (String, Pwe) {
    let pwe = valued(pkw, width, learned);
    (format!("{parameter} = {}", pwe.text), pwe)
}

/// The value of a word or double word, by what is known of the parameter.
fn valued(pkw: Pkw, width: Width, learned: &Learned) -> Pwe {
    let value = match width {
        Width::Word => Value::Word(pkw.word()),
        Width::Double => Value::Double(pkw.double_word()),
    };
    let text = match known(pkw.pke.pnu()) {
        // The command's acknowledge, `ag03.md` 3.3.
        Some(entry) if matches!(entry.kind, Kind::LoadParameterSet) && value.bits() == 0 => {
            "0 (carried out)".into()
        }
        Some(entry) if entry.width == width => value::in_words(entry, value, learned.lengths),
        Some(entry) => entry.number(value).to_string(),
        None => match width {
            Width::Word => value.bits().to_string(),
            Width::Double => value.bits().cast_signed().to_string(),
        },
    };
    let bits = match (pkw.pke.pnu(), width) {
        (SYSTEM_STATUS, Width::Word) => Some((Word::Ssw, learned.mode(), learned.model)),
        (GENERAL_STATUS, Width::Word) => Some((Word::GeneralStatus, learned.mode(), learned.model)),
        (_, _) => None,
    };
    Pwe { width: Some(width), text, mark: Mark::Plain, bits }
}

/// Replies 9 to this one are spontaneous messages (`profidrive-v2.md` 3).
const LAST_SPONTANEOUS: u8 = 12;
const SYSTEM_STATUS: u16 = 1020;
const GENERAL_STATUS: u16 = 1031;

fn pke_field(pkw: Pkw, at: usize, id: String) -> Field {
    let (raw, pke) = (pkw.pke.raw(), pkw.pke);
    let bits =
        |name: &str, high, low, meaning: String| Field::bits(name, (at, 2), Bits { high, low }, raw, meaning);
    let spm = if pke.spm() { "spontaneous message" } else { "no spontaneous message" };
    Field::word("PKE", at, raw, "").with(Vec::from([
        bits("AK", 15, 12, format!("{}, {id}", pke.ak())),
        bits("SPM", 11, 11, spm.into()),
        bits("PNU", 10, 0, format!("{} = {:03X}h{}", pke.pnu(), pke.pnu(), about(pke.pnu()))),
    ]))
}

/// What there is to know about a parameter, behind its number.
fn about(pnu: u16) -> String {
    match (pnu, known(pnu), standard_name(pnu)) {
        (0, _, _) => String::new(),
        (_, Some(entry), _) => {
            let array = entry.elements.map_or(String::new(), |count| format!("array of {count}, "));
            let model = match entry.models {
                Models::Both => "",
                Models::OnlyAg03_1 => ", AG03/1 only",
            };
            format!(", {} ({array}{}, {}{model})", entry.name, entry.width, entry.access())
        }
        (_, None, Some(name)) => format!(", {name} in the profile; these drives do not have it"),
        (_, None, None) => ", which these drives do not have".into(),
    }
}

fn ind_field(pkw: Pkw, at: usize, array: bool) -> Field {
    let (high, low) = (pkw.ind.high_octet(), pkw.ind.low_octet());
    let meaning = if array { "sub-index" } else { "not used" };
    let (high_meaning, low_meaning) = match (array, high, low) {
        (false, _, _) => ("not used".into(), "not used".into()),
        // `subindex` takes it from there.
        (true, 0, 1..) => ("0: the low octet counts".into(), format!("sub-index {low}")),
        (true, _, _) => (format!("sub-index {high}"), "not used".into()),
    };
    Field::word("IND", at, pkw.ind.raw(), meaning).with(Vec::from([
        Field::octet("high octet", at, high, high_meaning),
        Field::octet("low octet", at + 1, low, low_meaning),
    ]))
}

/// The sub-index as these drives read it: the high octet, if that is 0 the low one (`ag03.md` C-14).
fn subindex(pkw: Pkw) -> u8 {
    match pkw.ind.high_octet() {
        0 => pkw.ind.low_octet(),
        high => high,
    }
}

#[cfg(test)]
mod tests;
