//! Takes the newest job once per application cycle, runs it once, keeps its reply.

use core::fmt;

use super::code::{ErrorNumber, JobError};
use super::table::{Parameters, Value, Width, Written};
use crate::profibus::ppo::{Ind, JobId, Pke, Pkw, ReplyId};

/// How the parameter channel behaves where the manuals leave it open. The reasons for each default are in
/// `docs/reference/ag03.md` 15.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Config {
    /// Application cycles from the one that takes a job to the one that replies; 0 = the same cycle
    /// (`ag03.md` 2.4 rule 5).
    pub latency: u16,
    /// Where a sub-index is looked for (C-14).
    pub subindex: SubindexOctet,
    /// Job 1 on an array reads the element in IND instead of being refused (C-16).
    pub read_element_by_plain_job: bool,
    /// What the other octet of IND means.
    pub pages: Pages,
    /// A sub-index counts from 0 on the bus, and from 1 in the table.
    pub from_zero: bool,
    /// Jobs 11 to 14 are 8, 7, 3 and 2, the value to be kept.
    pub keeping_jobs: bool,
    /// Jobs 1, 2 and 3 are 6, 7 and 8 for an array, and the other way round for a single value.
    pub same_jobs: bool,
}

/// What the octet of IND without the sub-index means (`profidrive-v2.md` 2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pages {
    /// Nothing: it is not looked at.
    #[default]
    Ignored,
    /// Nothing: a job in which it is not 0 means a parameter of another drive, and is refused.
    None,
    /// Bit 7 of the low octet: the parameters from 2000 on.
    Of2000,
    /// The low octet is one of those that drives of one maker have for the parameters from 2000 on.
    OfMaker,
}

/// The pages of [`Pages::OfMaker`]: the low octet of IND, and the first parameter.
const MAKERS_PAGES: [(u8, u16); 8] = [
    (0x80, 2000),
    (0x90, 6000),
    (0x20, 8000),
    (0xA0, 10_000),
    (0x50, 20_000),
    (0x70, 29_000),
    (0xF0, 30_000),
    (0x74, 60_000),
];

impl Pages {
    /// The parameter that a job names.
    fn parameter(self, job: Pkw) -> Result<u16, JobError> {
        let (pnu, page) = (job.pke.pnu(), job.ind.low_octet());
        match (self, page) {
            (Self::Ignored, _) | (Self::None | Self::Of2000 | Self::OfMaker, 0) => Ok(pnu),
            (Self::Of2000, 0x80) => Ok(pnu.saturating_add(2000)),
            (Self::None | Self::Of2000, got) => Err(JobError::NoPage { got }),
            (Self::OfMaker, got) => {
                let first = MAKERS_PAGES.iter().find(|(octet, _)| *octet == got);
                first.map(|(_, first)| pnu.saturating_add(*first)).ok_or(JobError::NoPage { got })
            }
        }
    }
}

/// Which octet of IND carries the sub-index (`ag03.md` C-14).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SubindexOctet {
    /// The high octet, or the low octet if the high one is 0.
    #[default]
    HighElseLow,
    /// The high octet, as PROFIDRIVE version 2 has it.
    High,
    /// The low octet.
    Low,
}

impl SubindexOctet {
    const fn subindex(self, ind: Ind) -> u8 {
        match self {
            Self::HighElseLow if ind.high_octet() == 0 => ind.low_octet(),
            Self::HighElseLow | Self::High => ind.high_octet(),
            Self::Low => ind.low_octet(),
        }
    }
}

/// The parameter channel of one slave (`ag03.md` 2.4).
///
/// Call [`cycle`](Self::cycle) once per application cycle with the newest outputs, and [`reset`](Self::reset)
/// when Data_Exchange is left or entered again.
///
/// * A job is new when any of its four words differs from the job taken before; the toggle bit SPM does not
///   count. A write that is held is executed once; to repeat it the master sends job 0 or something else in
///   between.
/// * While a read is held its value is read anew in each cycle, without latency.
/// * Job 0 is a job like any other, answered with four zero words.
/// * One job at a time: what the master sends while a job is waiting for its latency or for the EEPROM is not
///   looked at before the reply to that job has been the answer of one cycle.
/// * A write whose value must be safe before it is acknowledged ([`Written::waits`]) is held: it has been executed, but
///   the previous reply stands until [`stored`](Self::stored) or `store_failed`.
#[derive(Clone, Debug)]
pub struct Engine {
    config: Config,
    state: State,
}

#[derive(Clone, Copy, Debug)]
enum State {
    /// The job is taken and runs after that many more cycles; until then the previous reply stands.
    Waiting { job: Pkw, cycles: u16, previous: Pkw },
    /// The job is done, the reply stands until another job comes.
    Answered { job: Pkw, reply: Pkw },
    /// The job was a successful read: as long as it is held it runs in each cycle.
    Reading { job: Pkw, reply: Pkw },
    /// The job is executed, its reply waits for the EEPROM; until then the previous reply stands.
    Storing { job: Pkw, reply: Pkw, previous: Pkw },
    /// The EEPROM is done; the reply is the answer of the next cycle.
    Stored { job: Pkw, reply: Pkw },
}

impl State {
    /// As if job 0 had just been answered.
    const START: Self = Self::Answered { job: Pkw::ZERO, reply: Pkw::ZERO };
}

/// What one application cycle made of the parameter channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub struct Outcome {
    /// The PKW to publish in the inputs.
    pub reply: Pkw,
    /// The job this cycle refused, once per job.
    pub refusal: Option<Refusal>,
}

/// A job that was not executed, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The job as the master sent it.
    pub job: Pkw,
    /// The parameter that it names.
    pub pnu: u16,
    /// What the master is told.
    pub number: ErrorNumber,
    /// What is wrong, with the values expected and found.
    pub cause: JobError,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { job, pnu, number, cause } = self;
        write!(f, "job {job} ({}, PNU {pnu}) refused with {number}: {cause}", job.pke.job())
    }
}

impl Engine {
    /// A parameter channel that has not seen a job.
    pub const fn new(config: Config) -> Self {
        Self { config, state: State::START }
    }

    /// Data_Exchange was left or entered again: the reply is zero until a job is seen, and a job that was
    /// waiting is forgotten (rule 6).
    pub const fn reset(&mut self) {
        self.state = State::START;
    }

    /// What the held job wrote is safe: its reply is the answer of the next cycle. Says whether a job was held.
    pub fn stored(&mut self) -> bool {
        let held = self.held();
        if let Some((job, reply)) = held {
            self.state = State::Stored { job, reply };
        }
        held.is_some()
    }

    /// What the held job wrote is lost: the answer of the next cycle is error 18. Returns the refusal if a job was
    /// held; to undo the write is the caller's business.
    #[must_use]
    pub(crate) fn store_failed(&mut self) -> Option<Refusal> {
        let (job, _) = self.held()?;
        let (reply, refusal) = self.refuse(job, JobError::NotStored);
        self.state = State::Stored { job, reply };
        Some(refusal)
    }

    const fn held(&self) -> Option<(Pkw, Pkw)> {
        match self.state {
            State::Storing { job, reply, .. } => Some((job, reply)),
            State::Waiting { .. } | State::Answered { .. } | State::Reading { .. } | State::Stored { .. } => {
                None
            }
        }
    }

    /// Whether a cycle with this request would do more than read a held value anew. If not, and nothing that a held read
    /// shows has changed, the cycle may be left out.
    #[must_use]
    pub fn has_work(&self, request: Pkw) -> bool {
        match self.state {
            State::Waiting { .. } | State::Stored { .. } => true,
            State::Storing { .. } => false,
            State::Answered { job, .. } | State::Reading { job, .. } => !same_job(request, job),
        }
    }

    /// Whether a cycle with this request would do nothing at all, and answer as the cycle before.
    pub(crate) fn is_settled(&self, request: Pkw) -> bool {
        match self.state {
            State::Answered { job, .. } => same_job(request, job),
            State::Waiting { .. } | State::Reading { .. } | State::Storing { .. } | State::Stored { .. } => {
                false
            }
        }
    }

    /// Runs one application cycle with the newest request of the master.
    pub fn cycle(&mut self, request: Pkw, table: &mut impl Parameters) -> Outcome {
        match self.state {
            State::Waiting { job, cycles, previous } if cycles > 1 => self.wait(job, cycles - 1, previous),
            State::Waiting { job, previous, .. } => self.run(job, previous, table),
            State::Storing { previous, .. } => unchanged(previous),
            State::Stored { job, reply } => {
                self.state = State::Answered { job, reply };
                unchanged(reply)
            }
            State::Answered { job, reply } if same_job(request, job) => unchanged(reply),
            State::Reading { job, reply } if same_job(request, job) => self.run(job, reply, table),
            State::Answered { reply, .. } | State::Reading { reply, .. } => match self.config.latency {
                0 => self.run(request, reply, table),
                cycles => self.wait(request, cycles, reply),
            },
        }
    }

    const fn wait(&mut self, job: Pkw, cycles: u16, previous: Pkw) -> Outcome {
        self.state = State::Waiting { job, cycles, previous };
        unchanged(previous)
    }

    fn run(&mut self, job: Pkw, previous: Pkw, table: &mut impl Parameters) -> Outcome {
        let (state, outcome) = match self.execute(job, table) {
            Ok(Done::Answer(reply)) => (State::Answered { job, reply }, unchanged(reply)),
            Ok(Done::Reading(reply)) => (State::Reading { job, reply }, unchanged(reply)),
            Ok(Done::Storing(reply)) => (State::Storing { job, reply, previous }, unchanged(previous)),
            Err(cause) => {
                let (reply, refusal) = self.refuse(job, cause);
                (State::Answered { job, reply }, Outcome { reply, refusal: Some(refusal) })
            }
        };
        self.state = state;
        outcome
    }

    /// Executes a job (`ag03.md` 2.2, manual table 8).
    fn execute(&self, job: Pkw, table: &mut impl Parameters) -> Result<Done, JobError> {
        let subindex = self.config.subindex.subindex(job.ind);
        let element = Some(if self.config.from_zero { subindex.saturating_add(1) } else { subindex });
        let word = Value::Word(job.word());
        let double = Value::Double(job.double_word());
        let mut id = job.pke.job();
        if id == JobId::NoJob {
            return Ok(Done::Answer(Pkw::ZERO));
        }
        if let (JobId::Reserved(reserved), true) = (id, self.config.keeping_jobs) {
            id = reserved.keeping().ok_or(JobError::UnknownJob(reserved))?;
        }
        let pnu = self.config.pages.parameter(job)?;
        if self.config.same_jobs {
            id = same(id, table.elements(pnu)?.is_some(), subindex)?;
        }
        match id {
            JobId::NoJob => Ok(Done::Answer(Pkw::ZERO)),
            JobId::Read => {
                let by_element =
                    self.config.read_element_by_plain_job && matches!(table.elements(pnu), Ok(Some(_)));
                read((job, pnu), element.filter(|_| by_element), table)
            }
            JobId::WriteWord => write((job, pnu), None, word, table),
            JobId::WriteDoubleWord => write((job, pnu), None, double, table),
            JobId::ReadDescription => {
                let described = table.describe(pnu, subindex)?;
                Ok(Done::Answer(answer(job, ReplyId::Description, described)))
            }
            JobId::WriteDescription => table.elements(pnu).and(Err(JobError::DescriptionReadOnly)),
            JobId::ReadElement => self.in_array(subindex, read((job, pnu), element, table)),
            JobId::WriteElementWord => self.in_array(subindex, write((job, pnu), element, word, table)),
            JobId::WriteElementDoubleWord => {
                self.in_array(subindex, write((job, pnu), element, double, table))
            }
            JobId::ReadElementCount => {
                let count = table.elements(pnu)?.ok_or(JobError::NotAnArray)?;
                Ok(Done::Answer(answer(job, ReplyId::ElementCount, u32::from(count))))
            }
            JobId::Reserved(id) => Err(JobError::UnknownJob(id)),
        }
    }

    /// A refused element as the bus counts it.
    fn in_array(&self, subindex: u8, done: Result<Done, JobError>) -> Result<Done, JobError> {
        match done {
            Err(JobError::NoElement { count, .. }) if self.config.from_zero => {
                Err(JobError::SubindexOutOfRange { count, got: subindex })
            }
            Ok(_) | Err(_) => done,
        }
    }

    /// The reply to a job that is not executed, and why.
    fn refuse(&self, job: Pkw, cause: JobError) -> (Pkw, Refusal) {
        let (number, pnu) = (ErrorNumber::from(cause), self.config.pages.parameter(job));
        let reply = answer(job, ReplyId::NotExecutable, u32::from(number.number()));
        (reply, Refusal { job, pnu: pnu.unwrap_or_else(|_| job.pke.pnu()), number, cause })
    }
}

/// The job that does what `id` asks of an array, or of a single value.
const fn same(id: JobId, is_array: bool, subindex: u8) -> Result<JobId, JobError> {
    Ok(match (id, is_array) {
        (JobId::Read, true) => JobId::ReadElement,
        (JobId::WriteWord, true) => JobId::WriteElementWord,
        (JobId::WriteDoubleWord, true) => JobId::WriteElementDoubleWord,
        (JobId::ReadElement | JobId::WriteElementWord | JobId::WriteElementDoubleWord, false)
            if subindex != 0 =>
        {
            return Err(JobError::NotAnArray);
        }
        (JobId::ReadElement, false) => JobId::Read,
        (JobId::WriteElementWord, false) => JobId::WriteWord,
        (JobId::WriteElementDoubleWord, false) => JobId::WriteDoubleWord,
        (id, _) => id,
    })
}

/// What becomes of the reply to an executed job.
enum Done {
    /// It stands.
    Answer(Pkw),
    /// It stands, and is read anew while the job is held.
    Reading(Pkw),
    /// It waits for the EEPROM.
    Storing(Pkw),
}

fn read((job, pnu): (Pkw, u16), element: Option<u8>, table: &impl Parameters) -> Result<Done, JobError> {
    let value = table.read(pnu, element)?;
    let reply = answer(job, value_id(value, element), value.bits());
    Ok(Done::Reading(reply))
}

fn write(
    (job, pnu): (Pkw, u16),
    element: Option<u8>,
    value: Value,
    table: &mut impl Parameters,
) -> Result<Done, JobError> {
    let Written { shown, waits } = table.write(pnu, element, value)?;
    let reply = answer(job, value_id(shown, element), shown.bits());
    Ok(if waits { Done::Storing(reply) } else { Done::Answer(reply) })
}

/// A reply to a job: the parameter's number and IND are the job's.
const fn answer(job: Pkw, id: ReplyId, pwe: u32) -> Pkw {
    Pkw::new(Pke::of_reply(id, job.pke.pnu()), job.ind, pwe)
}

const fn value_id(value: Value, element: Option<u8>) -> ReplyId {
    match (value.width(), element) {
        (Width::Word, None) => ReplyId::Word,
        (Width::Double, None) => ReplyId::DoubleWord,
        (Width::Word, Some(_)) => ReplyId::ElementWord,
        (Width::Double, Some(_)) => ReplyId::ElementDoubleWord,
    }
}

const fn unchanged(reply: Pkw) -> Outcome {
    Outcome { reply, refusal: None }
}

fn same_job(a: Pkw, b: Pkw) -> bool {
    let without_spm = |pkw: Pkw| Pkw { pke: pkw.pke.without_spm(), ..pkw };
    without_spm(a) == without_spm(b)
}
