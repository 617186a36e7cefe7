//! What is mistaken about a job or a reply, as far as its words tell.
//!
//! Whether a drive takes a job is asked of the parameter channel of an emulated one, so that explanation and drive
//! cannot differ. How to do it right, and the mistakes that public texts spread, stand here
//! (`docs/reference/profidrive-v2.md` 1 to 4).

use super::{known, named, standard_name};
use crate::devices::ag03::param::{Entry, Gear, Kind, Model, Pnu, Store, Width, entry};
use crate::devices::ag03::profibus::JobText;
use crate::explain::context::Learned;
use crate::explain::field::{Field, Mark};
use crate::profibus::pkw::{Config, Engine, ErrorNumber, JobError};
use crate::profibus::ppo::{JobId, Pke, Pkw, ReplyId};

/// Marks and hints on a job.
pub(in crate::explain) fn judge(pkw: Pkw, field: &mut Field) {
    let job = pkw.pke.job();
    if job == JobId::NoJob {
        if pkw != Pkw::ZERO {
            hint(field, Mark::Plain, "job 0 is no job; the other words are ignored".into());
        }
        return;
    }
    if let Some((number, text)) = refusal(pkw) {
        hint(field, Mark::Mistake, format!("the drive answers {number}: {text}"));
    }
    if pkw.pke.spm() {
        hint(field, Mark::Mistake, SPM_OF_A_JOB.into());
    }
    lost_value(pkw, field);
    index(pkw, field);
    public_mistakes(pkw, field);
}

/// Marks and hints on a reply.
pub(in crate::explain) fn judge_reply(pkw: Pkw, learned: &Learned, field: &mut Field) {
    let pnu = pkw.pke.pnu();
    match pkw.pke.reply() {
        ReplyId::NoReply => return,
        ReplyId::Word | ReplyId::DoubleWord | ReplyId::ElementWord | ReplyId::ElementDoubleWord => {
            let double = matches!(pkw.pke.reply(), ReplyId::DoubleWord | ReplyId::ElementDoubleWord);
            let width = if double { Width::Double } else { Width::Word };
            match known(pnu) {
                Some(Entry { kind: Kind::LoadParameterSet, .. }) if double => {
                    let text = "an AG03/1 confirms this command as a double word (manual, footnote to PNU 970), \
                                so job and reply have the same PKE: only PWE = 0 tells them apart";
                    hint(field, Mark::Plain, text.into());
                }
                Some(entry) if entry.width != width => {
                    hint(field, Mark::Mistake, format!("{} is a {}", named(pnu), entry.width));
                }
                Some(_) | None => {}
            }
        }
        ReplyId::NotExecutable if pkw.word() == 0 && known(pnu).is_some() => {
            let text =
                "these drives have this parameter and would not answer error 0; a job 7 writes an array word";
            hint(field, Mark::Mistake, text.into());
        }
        ReplyId::Description | ReplyId::NoControlRights => {
            hint(field, Mark::Plain, "these drives never send this reply".into());
        }
        ReplyId::Reserved(_) => {
            let text = "bit 11 is inverted with each spontaneous message, and the channel is blocked until the master \
                        sends the same bit 11";
            let spontaneous = pkw.pke.ak() <= super::LAST_SPONTANEOUS;
            hint(field, Mark::Mistake, if spontaneous { text } else { "no drive sends it" }.into());
        }
        ReplyId::ElementCount | ReplyId::NotExecutable => {}
    }
    if pkw.pke.spm() && !matches!(pkw.pke.reply(), ReplyId::Reserved(_)) {
        hint(field, Mark::Mistake, "bit 11 (SPM) is set, which these drives never do".into());
    }
    if learned.answers(pkw) == Some(false) {
        let asked = learned.job.map_or(0, |job| job.pke.pnu());
        let (asked, count) = (named(asked), learned.unanswered);
        // A reply never comes in the exchange of its own job, and a drive may take a while.
        if count <= MOST_UNANSWERED {
            let text = format!("still the previous reply; the one to the last job, for {asked}, comes later");
            hint(field, Mark::Plain, text);
        } else {
            let text = format!("{count} replies since the last job, which was for {asked}, and none to it");
            hint(field, Mark::Trouble, text);
        }
    }
    public_mistakes(pkw, field);
}

/// After more replies than this that are not to the job something is wrong. How long the real drive takes is not public
/// (`ag03.md` 16); this is a tenth of a second in exchanges of 1 ms.
const MOST_UNANSWERED: u32 = 100;

const SPM_OF_A_JOB: &str = "bit 11 is the toggle bit of spontaneous messages (SPM), not part of the number: PNU has \
                            the 11 bits 10..0 and reaches 2047 without it; send 0";

fn hint(field: &mut Field, mark: Mark, text: String) {
    field.mark = field.mark.max(mark);
    field.hints.push(text);
}

/// The error an emulated AG03/1 at rest refuses the job with, and what to do instead. Its gear is 24:1, which allows
/// the higher speeds.
fn refusal(pkw: Pkw) -> Option<(ErrorNumber, String)> {
    let mut store = Store::new(Model::Ag03_1, Gear::Ratio24);
    let mut engine = Engine::new(Config::default());
    // Bit 11 is judged apart.
    let job = Pkw { pke: pkw.pke.without_spm(), ..pkw };
    let outcome = engine.cycle(job, &mut store);
    let refusal = outcome.refusal?;
    let text = JobText { job, cause: refusal.cause };
    let standard = match refusal.cause {
        JobError::UnknownParameter { .. } => standard_name(job.pke.pnu()),
        JobError::UnknownJob(_)
        | JobError::NoPage { .. }
        | JobError::NamesNone { .. }
        | JobError::NoDescription
        | JobError::DescriptionReadOnly
        | JobError::WriteOnly
        | JobError::NotStored
        | JobError::OnlyZero
        | JobError::NoRight
        | JobError::ReadOnly
        | JobError::OutOfRange { .. }
        | JobError::SubindexOutOfRange { .. }
        | JobError::NoElement { .. }
        | JobError::Outside { .. }
        | JobError::NameTooLong
        | JobError::DescriptionTooLong
        | JobError::NotAnArray
        | JobError::IsArray { .. }
        | JobError::WrongWidth { .. }
        | JobError::NotNow(_) => None,
    };
    Some((
        refusal.number,
        match standard {
            Some(name) => format!("{text} (in the profile it is '{name}')"),
            None => format!("{text}"),
        },
    ))
}

/// A word job looks at word 4 only.
fn lost_value(pkw: Pkw, field: &mut Field) {
    let word_job = matches!(pkw.pke.job(), JobId::WriteWord | JobId::WriteElementWord);
    if word_job && pkw.pwe_high != 0 {
        let text = if pkw.pwe_low == 0 {
            "the value is in word 3; a word belongs in word 4, the low word of PWE"
        } else {
            "word 3 is ignored: a word has its value in word 4"
        };
        hint(field, Mark::Mistake, text.into());
    }
}

/// IND is for arrays, its sub-index in the high octet.
fn index(pkw: Pkw, field: &mut Field) {
    let (ind, job) = (pkw.ind, pkw.pke.job());
    if ind.raw() == 0 {
        return;
    }
    match job {
        JobId::Read | JobId::WriteWord | JobId::WriteDoubleWord => {
            hint(field, Mark::Plain, format!("job {} ignores IND; IND is for arrays", job.ak()));
        }
        JobId::ReadElement | JobId::WriteElementWord | JobId::WriteElementDoubleWord
            if ind.high_octet() == 0 =>
        {
            let text = "the sub-index is in the low octet of IND: PROFIDRIVE version 2 has it in the high octet; \
                        these drives take either";
            hint(field, Mark::Plain, text.into());
        }
        JobId::NoJob
        | JobId::ReadDescription
        | JobId::WriteDescription
        | JobId::ReadElement
        | JobId::WriteElementWord
        | JobId::WriteElementDoubleWord
        | JobId::ReadElementCount
        | JobId::Reserved(_) => {}
    }
}

/// Words that public manuals and articles print and that do not mean what is said there.
fn public_mistakes(pkw: Pkw, field: &mut Field) {
    let raw = pkw.pke.raw();
    if known(pkw.pke.pnu()).is_none()
        && let Some(text) = decimal_digits(pkw.pke).or_else(|| swapped(pkw.pke))
    {
        hint(field, Mark::Mistake, text);
    }
    let text = match (raw, pkw.pke.pnu()) {
        (_, 0x3BB) => "3BBh is 955; some documents write it for PNU 947, which is 3B3h",
        (0xAC1A, _) => "a manual prints AC1A for a message about PNU 538, which would be AA1A (538 = 21Ah)",
        (0x1C08, _) => "a manual prints 1C08 for PNU 520, which would be 1A08 with bit 11 set (520 = 208h)",
        (_, _) => return,
    };
    hint(field, Mark::Mistake, text.into());
}

/// A decimal number written as hexadecimal digits: `1018` for PNU 1018, `1930` for reading PNU 930.
fn decimal_digits(pke: Pke) -> Option<String> {
    let digits = format!("{:04X}", pke.raw());
    let number = |digits: &str| {
        let pnu = Pnu::new(digits.parse().ok()?).ok()?;
        entry(Model::Ag03_1, pnu)
    };
    let entry = number(&digits).or_else(|| number(digits.get(1..)?))?;
    let pnu = entry.pnu.number();
    Some(format!(
        "{pnu} here are decimal digits: PNU {pnu} is {pnu:03X}h, and reading {} is PKE {:04X}",
        entry.name,
        Pke::of_job(JobId::Read, pnu).raw()
    ))
}

/// A word with its low octet first that would make sense the other way round.
fn swapped(pke: Pke) -> Option<String> {
    let swapped = Pke::from_raw(pke.raw().swap_bytes());
    let sensible = !swapped.spm() && (1..=9).contains(&swapped.ak()) && known(swapped.pnu()).is_some();
    let text = || {
        let (raw, name) = (swapped.raw(), named(swapped.pnu()));
        format!("with its octets exchanged PKE is {raw:04X}, {name}: the high octet of a word comes first")
    };
    sensible.then(text)
}
