//! A job in words of parameters, its PKW, and which replies are replies to it.

use core::fmt;

use thiserror::Error;

use super::error::{ErrorCode, PkwError};
use super::profile::{ArrayJobs, Memory, Profile, SubindexPlace, WriteReply};
use crate::devices::ag03::param::{Pnu, Subindex, Value, Width};
use crate::profibus::ppo::{Ind, Pke, Pkw, ReplyId};

/// One job for the parameter channel.
///
/// ```
/// use profidrive::client::Job;
/// use profidrive::devices::ag03::param::{Parameter, Pnu, Subindex, Value, Width};
///
/// let position = Job::read(Pnu::new(1036)?).expecting(Width::Double);
/// let limit = Job::write(Parameter::Limit1.entry().pnu, Value::of(Width::Double, 250_000));
/// let fault = Job::read_element(Pnu::new(945)?, Subindex(0)).expecting(Width::Word);
/// assert_eq!(limit.to_string(), "write double word 250000 to PNU 1016");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Job {
    pnu: Pnu,
    element: Option<Subindex>,
    task: Task,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Task {
    /// The width the reply must have.
    Read(Option<Width>),
    /// `None`: wherever the usual jobs write to.
    Write(Value, Option<Memory>),
    CountElements,
    ReadDescription,
}

/// What a job that was carried out brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reply {
    /// The value read, or the value the drive has after the write. 0 after a command.
    Value(Value),
    /// How many elements the array has.
    ElementCount(u16),
    /// The element of the description: up to four octets, right-aligned (`profidrive-v2.md` 6 lists types).
    Description(u32),
}

/// A job the client does not take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NotSubmitted {
    /// A job is under way, or the outcome of the last one was not taken.
    #[error("the parameter channel is busy with another job")]
    Busy,
    /// The drives of this profile have no job for it.
    #[error("the profile of the drive has no job to {job}")]
    NoSuchJob {
        /// The job.
        job: Job,
    },
}

impl Job {
    /// Reads a parameter that is no array.
    pub const fn read(pnu: Pnu) -> Self {
        Self { pnu, element: None, task: Task::Read(None) }
    }

    /// Writes a parameter that is no array. The width of `value` must be that of the parameter.
    pub const fn write(pnu: Pnu, value: Value) -> Self {
        Self { pnu, element: None, task: Task::Write(value, None) }
    }

    /// Reads an element of an array. What the first one is numbered is the drive's affair: 0 on these drives, 1 on
    /// most others.
    pub const fn read_element(pnu: Pnu, element: Subindex) -> Self {
        Self { pnu, element: Some(element), task: Task::Read(None) }
    }

    /// Writes an element of an array.
    pub const fn write_element(pnu: Pnu, element: Subindex, value: Value) -> Self {
        Self { pnu, element: Some(element), task: Task::Write(value, None) }
    }

    /// Asks how many elements an array has.
    pub const fn element_count(pnu: Pnu) -> Self {
        Self { pnu, element: None, task: Task::CountElements }
    }

    /// Reads an element of the parameter's description (PBE).
    pub const fn description(pnu: Pnu, element: Subindex) -> Self {
        Self { pnu, element: Some(element), task: Task::ReadDescription }
    }

    /// The same read, of a value known to have this width: a reply of the other width is not taken for the reply.
    /// Without it a drive that wrongly answers with a word cuts a double word short. Changes no other job.
    #[must_use]
    pub const fn expecting(self, width: Width) -> Self {
        match self.task {
            Task::Read(_) => Self { task: Task::Read(Some(width)), ..self },
            Task::Write(..) | Task::CountElements | Task::ReadDescription => self,
        }
    }

    /// The same write, into this memory. Changes no other job.
    #[must_use]
    pub const fn to_memory(self, memory: Memory) -> Self {
        match self.task {
            Task::Write(value, _) => Self { task: Task::Write(value, Some(memory)), ..self },
            Task::Read(_) | Task::CountElements | Task::ReadDescription => self,
        }
    }

    /// The parameter.
    pub const fn pnu(&self) -> Pnu {
        self.pnu
    }

    /// Whether it changes something in the drive.
    pub const fn is_write(&self) -> bool {
        match self.task {
            Task::Write(..) => true,
            Task::Read(_) | Task::CountElements | Task::ReadDescription => false,
        }
    }

    /// The words that ask for it.
    pub(in crate::client) fn request(&self, profile: &Profile) -> Result<Pkw, NotSubmitted> {
        let none = NotSubmitted::NoSuchJob { job: *self };
        let as_array = match profile.array_jobs {
            ArrayJobs::ForElements => self.element.is_some(),
            ArrayJobs::Never => false,
            ArrayJobs::Always => true,
        };
        let (ak, pwe): (u16, u32) = match self.task {
            Task::Read(_) => (if as_array { 6 } else { 1 }, 0),
            Task::Write(value, memory) => {
                let other = match memory {
                    Some(wanted) if profile.writes != Some(wanted) => {
                        // Without knowing where the usual jobs write to, the other memory is not known either.
                        if profile.writes.is_none() || !profile.jobs_11_to_14 {
                            return Err(none);
                        }
                        true
                    }
                    Some(_) | None => false,
                };
                let ak = match (value.width(), as_array, other) {
                    (Width::Word, false, false) => 2,
                    (Width::Double, false, false) => 3,
                    (Width::Word, true, false) => 7,
                    (Width::Double, true, false) => 8,
                    (Width::Double, true, true) => 11,
                    (Width::Word, true, true) => 12,
                    (Width::Double, false, true) => 13,
                    (Width::Word, false, true) => 14,
                };
                (ak, value.bits())
            }
            Task::CountElements if profile.array_jobs == ArrayJobs::Never => return Err(none),
            Task::CountElements => (9, 0),
            Task::ReadDescription => (4, 0),
        };
        let pke = Pke::from_raw(ak << 12 | self.pnu.number());
        let Subindex(element) = self.element.unwrap_or(Subindex(0));
        let ind = match profile.subindex {
            SubindexPlace::HighOctet => Ind::in_high_octet(element),
            SubindexPlace::LowOctet => Ind::from_raw(u16::from(element)),
        };
        Ok(Pkw::new(pke, ind, pwe))
    }

    /// What `pkw` says if it is a reply to this job; `None` if it is not.
    ///
    /// A refusal is recognised by the parameter alone: no manual says that IND is repeated in it.
    pub(super) fn answered_by(&self, pkw: Pkw, profile: &Profile) -> Option<Result<Reply, PkwError>> {
        if pkw.pke.pnu() != self.pnu.number() {
            return None;
        }
        let reply = pkw.pke.reply();
        match (reply, self.task) {
            (ReplyId::NotExecutable, _) => Some(Err(PkwError::Refused(ErrorCode::from_number(pkw.word())))),
            (ReplyId::NoControlRights, _) => Some(Err(PkwError::NoControlRights)),
            (ReplyId::ElementCount, Task::CountElements) => Some(Ok(Reply::ElementCount(pkw.word()))),
            (ReplyId::Description, Task::ReadDescription) if self.is_of_element(pkw.ind, profile) => {
                Some(Ok(Reply::Description(pkw.double_word())))
            }
            (
                ReplyId::Word | ReplyId::DoubleWord | ReplyId::ElementWord | ReplyId::ElementDoubleWord,
                Task::Read(_) | Task::Write(..),
            ) if self.is_of_element(pkw.ind, profile) => {
                let value = self.value(pkw, profile)?;
                self.accepts(value, profile).then_some(Ok(Reply::Value(value)))
            }
            (
                ReplyId::NoReply
                | ReplyId::Word
                | ReplyId::DoubleWord
                | ReplyId::Description
                | ReplyId::ElementWord
                | ReplyId::ElementDoubleWord
                | ReplyId::ElementCount
                | ReplyId::Reserved(_),
                _,
            ) => None,
        }
    }

    /// Whether a positive reply may show another value in the next image, because the drive reads it anew.
    pub(super) const fn is_refreshed(&self) -> bool {
        matches!(self.task, Task::Read(_))
    }

    /// The value in a positive reply, if the reply is of the kind the job asks for.
    fn value(&self, pkw: Pkw, profile: &Profile) -> Option<Value> {
        let element = match profile.array_jobs {
            ArrayJobs::ForElements => Some(self.element.is_some()),
            // Both ways of asking are one to such drives.
            ArrayJobs::Never | ArrayJobs::Always => None,
        };
        let (value, of_element) = match pkw.pke.reply() {
            ReplyId::Word => (Value::Word(pkw.word()), false),
            ReplyId::DoubleWord => (Value::Double(pkw.double_word()), false),
            ReplyId::ElementWord => (Value::Word(pkw.word()), true),
            ReplyId::ElementDoubleWord => (Value::Double(pkw.double_word()), true),
            ReplyId::NoReply
            | ReplyId::Description
            | ReplyId::ElementCount
            | ReplyId::NotExecutable
            | ReplyId::NoControlRights
            | ReplyId::Reserved(_) => return None,
        };
        element.is_none_or(|element| element == of_element).then_some(value)
    }

    /// Whether this value can be the one of the reply.
    fn accepts(&self, value: Value, profile: &Profile) -> bool {
        match self.task {
            Task::Read(width) => width.is_none_or(|width| width == value.width()),
            Task::Write(..) if profile.commands.contains(&self.pnu) => value.bits() == 0,
            Task::Write(written, _) => match profile.write_reply {
                WriteReply::Mirrored => value == written,
                WriteReply::AsRead => value.width() == written.width(),
            },
            Task::CountElements | Task::ReadDescription => false,
        }
    }

    /// Whether the sub-index in a reply is that of the job. Without a sub-index IND means nothing.
    fn is_of_element(&self, ind: Ind, profile: &Profile) -> bool {
        let got = match profile.subindex {
            SubindexPlace::HighOctet => ind.high_octet(),
            SubindexPlace::LowOctet => ind.low_octet(),
        };
        self.element.is_none_or(|element| element == Subindex(got))
    }
}

impl fmt::Display for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(value) => fmt::Display::fmt(value, f),
            Self::ElementCount(count) => write!(f, "{count} elements"),
            Self::Description(octets) => write!(f, "{octets:08X}"),
        }
    }
}

impl fmt::Display for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pnu, element, task } = *self;
        match task {
            Task::Read(_) => write!(f, "read PNU {pnu}")?,
            Task::Write(value, memory) => {
                // The drive knows whether its parameter has a sign.
                let width = match value.width() {
                    Width::Word => "word",
                    Width::Double => "double word",
                };
                write!(f, "write {width} {value} to PNU {pnu}")?;
                match memory {
                    Some(Memory::Permanent) => f.write_str(" permanently")?,
                    Some(Memory::Volatile) => f.write_str(" until power-off")?,
                    None => {}
                }
            }
            Task::CountElements => write!(f, "read the number of elements of PNU {pnu}")?,
            Task::ReadDescription => write!(f, "read the description of PNU {pnu}")?,
        }
        match element {
            Some(element) => write!(f, ", sub-index {element}"),
            None => Ok(()),
        }
    }
}
