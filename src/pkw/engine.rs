//! Takes the newest job once per application cycle, runs it once, keeps its reply.

use core::fmt;

use super::code::{ErrorNumber, JobError};
use crate::param::{Access, Effect, Kind, Live, Model, Pnu, Store, Subindex, Value, Width, WriteContext};
use crate::ppo::{Ind, JobId, Pke, Pkw, ReplyId};

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
    /// Reading a parameter that is a command, PNU 970, is refused instead of answered with 0 (C-17).
    pub refuse_command_read: bool,
    /// An AG03/1 confirms a write of PNU 970 as a word, as an AG03 does, instead of a double word (C-15).
    pub confirm_load_as_word: bool,
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
    const fn subindex(self, ind: Ind) -> Subindex {
        match self {
            Self::HighElseLow if ind.high_octet() == 0 => Subindex(ind.low_octet()),
            Self::HighElseLow | Self::High => Subindex(ind.high_octet()),
            Self::Low => Subindex(ind.low_octet()),
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
/// * A write whose value must be safe before it is acknowledged is [held](Self::hold): it has been executed, but
///   the previous reply stands until [`stored`](Self::stored) or [`store_failed`](Self::store_failed).
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
    /// What the drive has to do now. Not [`Effect::None`] in at most one cycle per job.
    pub effect: Effect,
    /// This cycle executed a write to what the EEPROM keeps, once per job, even if it changed nothing.
    pub stores: bool,
    /// The job this cycle refused, once per job.
    pub refusal: Option<Refusal>,
}

/// A job that was not executed, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The job as the master sent it.
    pub job: Pkw,
    /// What the master is told.
    pub number: ErrorNumber,
    /// What is wrong, with the values expected and found.
    pub cause: JobError,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { job, number, cause } = self;
        write!(f, "job {job} ({}, PNU {}) refused with {number}: {cause}", job.pke.job(), job.pke.pnu())
    }
}

impl Engine {
    /// A parameter channel that has not seen a job.
    pub const fn new(config: Config) -> Self {
        Self { config, state: State::START }
    }

    /// How it behaves.
    pub const fn config(&self) -> Config {
        self.config
    }

    /// Data_Exchange was left or entered again: the reply is zero until a job is seen, and a job that was
    /// waiting is forgotten (rule 6).
    pub const fn reset(&mut self) {
        self.state = State::START;
    }

    /// Holds back the reply to the write that [`cycle`](Self::cycle) has just executed; `previous` stands meanwhile.
    /// Nothing is held if the last cycle left no finished job.
    pub fn hold(&mut self, previous: Pkw) {
        match self.state {
            State::Answered { job, reply } => self.state = State::Storing { job, reply, previous },
            State::Waiting { .. } | State::Reading { .. } | State::Storing { .. } | State::Stored { .. } => {}
        }
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
    pub fn store_failed(&mut self) -> Option<Refusal> {
        let (job, _) = self.held()?;
        let (reply, refusal) = refuse(job, JobError::NotStored);
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

    /// Whether a cycle with this request would do more than read a held value anew. If not, and nothing a
    /// held read shows has changed, the cycle may be left out.
    #[must_use]
    pub fn has_work(&self, request: Pkw) -> bool {
        match self.state {
            State::Waiting { .. } | State::Stored { .. } => true,
            State::Storing { .. } => false,
            State::Answered { job, .. } | State::Reading { job, .. } => !same_job(request, job),
        }
    }

    /// Whether a cycle with this request may read a parameter. If not, it does not look at [`Live`].
    #[must_use]
    pub fn may_read(&self, request: Pkw) -> bool {
        match self.state {
            State::Reading { .. } => true,
            State::Waiting { .. } | State::Answered { .. } | State::Storing { .. } | State::Stored { .. } => {
                self.has_work(request)
            }
        }
    }

    /// Runs one application cycle with the newest request of the master.
    pub fn cycle(&mut self, request: Pkw, store: &mut Store, live: &Live, context: &WriteContext) -> Outcome {
        match self.state {
            State::Waiting { job, cycles, previous } if cycles > 1 => self.wait(job, cycles - 1, previous),
            State::Waiting { job, .. } => self.run(job, store, live, context),
            State::Storing { previous, .. } => unchanged(previous),
            State::Stored { job, reply } => {
                self.state = State::Answered { job, reply };
                unchanged(reply)
            }
            State::Answered { job, reply } if same_job(request, job) => unchanged(reply),
            State::Reading { job, .. } if same_job(request, job) => self.run(job, store, live, context),
            State::Answered { reply, .. } | State::Reading { reply, .. } => match self.config.latency {
                0 => self.run(request, store, live, context),
                cycles => self.wait(request, cycles, reply),
            },
        }
    }

    const fn wait(&mut self, job: Pkw, cycles: u16, previous: Pkw) -> Outcome {
        self.state = State::Waiting { job, cycles, previous };
        unchanged(previous)
    }

    fn run(&mut self, job: Pkw, store: &mut Store, live: &Live, context: &WriteContext) -> Outcome {
        match self.execute(job, store, live, context) {
            Ok((reply, effect)) => {
                let (state, stores) = match job.pke.job() {
                    JobId::Read | JobId::ReadElement => (State::Reading { job, reply }, false),
                    JobId::WriteWord
                    | JobId::WriteDoubleWord
                    | JobId::WriteDescription
                    | JobId::WriteElementWord
                    | JobId::WriteElementDoubleWord => (State::Answered { job, reply }, is_kept(job, store)),
                    JobId::NoJob | JobId::ReadDescription | JobId::ReadElementCount | JobId::Reserved(_) => {
                        (State::Answered { job, reply }, false)
                    }
                };
                self.state = state;
                Outcome { reply, effect, stores, refusal: None }
            }
            Err(cause) => {
                let (reply, refusal) = refuse(job, cause);
                self.state = State::Answered { job, reply };
                Outcome { reply, effect: Effect::None, stores: false, refusal: Some(refusal) }
            }
        }
    }

    /// The reply to a job and its effect (`ag03.md` 2.2, manual table 8).
    fn execute(
        &self,
        job: Pkw,
        store: &mut Store,
        live: &Live,
        context: &WriteContext,
    ) -> Result<(Pkw, Effect), JobError> {
        let pnu = Pnu::from_low_bits(job.pke.pnu());
        let element = Some(self.config.subindex.subindex(job.ind));
        let word = Value::Word(job.word());
        let double = Value::Double(job.double_word());
        match job.pke.job() {
            JobId::NoJob => Ok((Pkw::ZERO, Effect::None)),
            JobId::Read => {
                let by_element = self.config.read_element_by_plain_job && store.element_count(pnu).is_ok();
                self.read(job, pnu, element.filter(|_| by_element), store, live)
            }
            JobId::WriteWord => self.write(job, pnu, None, word, store, context),
            JobId::WriteDoubleWord => self.write(job, pnu, None, double, store, context),
            JobId::ReadDescription => {
                store.entry(pnu)?;
                Err(JobError::NoDescription)
            }
            JobId::WriteDescription => {
                store.entry(pnu)?;
                Err(JobError::DescriptionReadOnly)
            }
            JobId::ReadElement => self.read(job, pnu, element, store, live),
            JobId::WriteElementWord => self.write(job, pnu, element, word, store, context),
            JobId::WriteElementDoubleWord => self.write(job, pnu, element, double, store, context),
            JobId::ReadElementCount => {
                let count = store.element_count(pnu)?;
                Ok((answer(job, ReplyId::ElementCount, u32::from(count)), Effect::None))
            }
            JobId::Reserved(id) => Err(JobError::UnknownJob(id)),
        }
    }

    fn read(
        &self,
        job: Pkw,
        pnu: Pnu,
        element: Option<Subindex>,
        store: &Store,
        live: &Live,
    ) -> Result<(Pkw, Effect), JobError> {
        let value = store.read(pnu, element, live)?;
        if self.config.refuse_command_read && store.entry(pnu)?.access() == Access::WriteOnly {
            return Err(JobError::WriteOnly);
        }
        Ok((answer(job, value_id(value, element), value.bits()), Effect::None))
    }

    fn write(
        &self,
        job: Pkw,
        pnu: Pnu,
        element: Option<Subindex>,
        value: Value,
        store: &mut Store,
        context: &WriteContext,
    ) -> Result<(Pkw, Effect), JobError> {
        let kind = store.entry(pnu)?.kind;
        let effect = store.write(pnu, element, value, context)?;
        let reply = match (kind, store.model()) {
            (Kind::Setting(_) | Kind::Reading(_), _) => answer(job, value_id(value, element), value.bits()),
            // A command is 0 after it was executed; the AG03/1 confirms it as a double word (C-15).
            (Kind::LoadParameterSet, Model::Ag03_1) if !self.config.confirm_load_as_word => {
                answer(job, ReplyId::DoubleWord, 0)
            }
            (Kind::LoadParameterSet, Model::Ag03 | Model::Ag03_1) => answer(job, ReplyId::Word, 0),
        };
        Ok((reply, effect))
    }
}

/// Whether the EEPROM keeps what the job writes. The commands of PNU 970 all change something it keeps.
fn is_kept(job: Pkw, store: &Store) -> bool {
    let entry = store.entry(Pnu::from_low_bits(job.pke.pnu()));
    entry.is_ok_and(|entry| entry.persistent || entry.access() == Access::WriteOnly)
}

/// The reply to a job that is not executed, and why.
fn refuse(job: Pkw, cause: JobError) -> (Pkw, Refusal) {
    let number = ErrorNumber::from(cause);
    let reply = answer(job, ReplyId::NotExecutable, u32::from(number.number()));
    (reply, Refusal { job, number, cause })
}

/// A reply to a job: the parameter's number and IND are the job's.
const fn answer(job: Pkw, id: ReplyId, pwe: u32) -> Pkw {
    Pkw::new(Pke::of_reply(id, job.pke.pnu()), job.ind, pwe)
}

const fn value_id(value: Value, element: Option<Subindex>) -> ReplyId {
    match (value.width(), element) {
        (Width::Word, None) => ReplyId::Word,
        (Width::Double, None) => ReplyId::DoubleWord,
        (Width::Word, Some(_)) => ReplyId::ElementWord,
        (Width::Double, Some(_)) => ReplyId::ElementDoubleWord,
    }
}

const fn unchanged(reply: Pkw) -> Outcome {
    Outcome { reply, effect: Effect::None, stores: false, refusal: None }
}

fn same_job(a: Pkw, b: Pkw) -> bool {
    let without_spm = |pkw: Pkw| Pkw { pke: pkw.pke.without_spm(), ..pkw };
    without_spm(a) == without_spm(b)
}

#[cfg(test)]
mod tests;
