//! One job of the parameter channel at a time, held until its own reply.
//!
//! | file | holds |
//! | --- | --- |
//! | `job` | [`Job`], its words, and which replies are replies to it |
//! | `profile` | [`Profile`]: what drives do differently |
//! | `unanswered` | which probe nobody can mistake for an older one |
//! | `error` | [`PkwError`] |

mod error;
mod job;
mod profile;
mod unanswered;

pub use error::{ErrorCode, Limit, PkwError, Stage};
pub use job::{Job, NotSubmitted, Reply};
pub use profile::{ArrayJobs, Images, Memory, Profile, SubindexPlace, WriteReply};

use self::unanswered::Unanswered;
use crate::devices::ag03::param::{Pnu, Value};
use crate::profibus::ppo::{Ind, JobId, Pke, Pkw, ReplyId};
use crate::time::Instant;

/// The master's end of the parameter channel of one drive.
///
/// **Feed each new input image to [`handle_input`](Self::handle_input), then put [`output`](Self::output) into the
/// next output image; take [`poll_outcome`](Self::poll_outcome) until it is `Some`. While no images come, call
/// [`handle_timeout`](Self::handle_timeout) when [`poll_timeout`](Self::poll_timeout) has come.**
///
/// ```
/// use profidrive::client::{Job, PkwClient, Profile, Reply};
/// use profidrive::devices::ag03::param::{Gear, Model, Pnu, Store, Value};
/// use profidrive::profibus::pkw::{Config, Engine};
/// use profidrive::profibus::ppo::Pkw;
/// use profidrive::time::Instant;
///
/// // The drive's end of the channel stands for a whole drive on a bus.
/// let mut drive = Engine::new(Config::default());
/// let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
/// let mut exchange = |job: Pkw| {
///     drive.cycle(job, &mut store).reply
/// };
///
/// let mut client = PkwClient::new(Profile::AG03);
/// let now = Instant::ZERO;
/// client.submit(now, Job::read(Pnu::new(1004)?))?;
/// let outcome = loop {
///     let inputs = exchange(client.output());
///     client.handle_input(now, inputs);
///     if let Some(outcome) = client.poll_outcome() {
///         break outcome;
///     }
/// };
/// assert_eq!(outcome.result, Ok(Reply::Value(Value::Word(30))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # How it knows that a reply is the reply to its job
///
/// A reply names the parameter and perhaps the element, but not the job. So the reply to an earlier job about the same
/// parameter looks the same: an old value would be taken for a fresh one, or the reply to a read for the confirmation of
/// a write. The client sends a job only when no such reply can come any more:
///
/// - *The last job was about another parameter*, and its reply was seen: it is sent at once.
/// - *The last job was about the same parameter*, and its reply was seen: job 0 is sent first until reply 0 is
///   seen. That also makes an identical job a new one for the drive. Between jobs it sends job 0 anyway.
/// - *What was asked before is not known*: at the beginning, after a job without reply, after a loss of Data_Exchange.
///   Job 0 is sent until reply 0 is seen; but that may be an old one, from before a job the drive has not answered
///   yet. So then a probe is sent, a read of a parameter that nobody waits for an answer about ([`Profile::probes`]).
///   Once the probe is answered, with a value or an error, every job before it is over.
///
/// A job is never changed before its reply was seen, except when it has timed out or was interrupted; then job 0
/// is sent, and the job is never sent a second time.
///
/// # What is guaranteed, and what cannot be
///
/// A success is reported only for a reply the drive gave to this very job, and a write goes to the drive once, if
///
/// 1. the drive works at one job at a time, in the order it sees them, and its replies arrive in that order (an image
///    may be skipped, repeated or late, but not overtake another; late by so much that as many jobs as there are
///    [`Profile::probes`] have ended without a reply is too late);
/// 2. a reply tells the parameter, the element and the kind of reply it is for. A drive that answers job 1018 with the
///    value of 1017 cannot be found out; a reply that does not fit the job is not taken;
/// 3. the four words of an output image reach the drive together (consistency, F3), and those of an input image as
///    [`Profile::images`] says;
/// 4. the drive sees the outputs as given here: the caller says when it does not, with
///    [`handle_data_exchange_lost`](Self::handle_data_exchange_lost).
///
/// The protocol cannot tell whether a job was carried out whose reply never came: [`PkwError::is_certain`].
/// Spontaneous messages (replies 9 to 12) are not acknowledged; a drive must have them switched off (PNU 917).
///
/// # Timeouts
///
/// A job ends at the latest [`Profile::time`] after its submission or with that many input images
/// ([`Profile::exchanges`]), whichever comes first, with whatever must be done before it included.
#[derive(Clone, Debug)]
pub struct PkwClient {
    profile: Profile,
    channel: Channel,
    /// The parameters asked about since it was last known that every job is over.
    unanswered: Unanswered,
    work: Work,
}

/// A job that is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// The job as submitted.
    pub job: Job,
    /// What it brought.
    pub result: Result<Reply, PkwError>,
}

/// Which replies can still come to what was asked before the present job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    /// Any.
    Unknown,
    /// Reply 0 was seen since, but it may be an old one.
    Quiet,
    /// The reply to the last job, about this parameter, still stands.
    Standing(u16),
    /// None.
    Clear,
}

#[derive(Clone, Copy, Debug)]
enum Work {
    None,
    Under(Underway),
    Over(Outcome),
}

/// A job that is not over.
#[derive(Clone, Copy, Debug)]
struct Underway {
    job: Job,
    request: Pkw,
    stage: Stage,
    /// The parameter of the probe, if one is needed.
    probe: Pnu,
    deadline: Instant,
    exchanges: u32,
    last: Option<Pkw>,
    /// The last image if it was a reply to the job.
    seen: Option<Seen>,
}

#[derive(Clone, Copy, Debug)]
struct Seen {
    reply: Pkw,
    /// So many images in a row had its words 1 to 3.
    images: u8,
}

impl PkwClient {
    /// A client for a drive of this kind that knows nothing of what was asked before.
    pub const fn new(profile: Profile) -> Self {
        Self { profile, channel: Channel::Unknown, unanswered: Unanswered::NONE, work: Work::None }
    }

    /// How the drive is asked.
    pub(crate) const fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Takes a job. Its time runs from `now` on.
    ///
    /// # Errors
    /// [`NotSubmitted`] while another job is under way or its outcome was not taken, or if the profile has no job for
    /// it.
    pub fn submit(&mut self, now: Instant, job: Job) -> Result<(), NotSubmitted> {
        match self.work {
            Work::None => {}
            Work::Under(_) | Work::Over(_) => return Err(NotSubmitted::Busy),
        }
        let request = job.request(&self.profile)?;
        let mut underway = Underway {
            job,
            request,
            stage: Stage::NoReply,
            probe: self.unanswered.next_probe(&self.profile, job.pnu()),
            deadline: now.saturating_add(self.profile.time),
            exchanges: 0,
            last: None,
            seen: None,
        };
        underway.stage = self.next_stage(&underway);
        self.work = Work::Under(underway);
        Ok(())
    }

    /// The PKW for the next output image. Changes with [`submit`](Self::submit) and every `handle_*`.
    #[must_use]
    pub fn output(&self) -> Pkw {
        match &self.work {
            Work::None | Work::Over(_) => Pkw::ZERO,
            Work::Under(underway) => match underway.stage {
                Stage::NoReply => Pkw::ZERO,
                Stage::Probe => {
                    Pkw::new(Pke::of_job(JobId::Read, underway.probe.number()), Ind::default(), 0)
                }
                Stage::Reply => underway.request,
            },
        }
    }

    /// The PKW of a new input image. One call for each exchange whose inputs the caller gets to see.
    ///
    /// An image given twice counts as two exchanges, and passes for two images where [`Images::MayBeTorn`] wants two.
    pub fn handle_input(&mut self, now: Instant, reply: Pkw) {
        let mut underway = match self.work {
            Work::Under(underway) => underway,
            Work::None | Work::Over(_) => return self.note_no_reply(reply),
        };
        underway.last = Some(reply);
        underway.exchanges = underway.exchanges.saturating_add(1);
        match underway.stage {
            Stage::NoReply => {
                self.note_no_reply(reply);
                underway.stage = self.next_stage(&underway);
            }
            Stage::Probe => {
                if is_reply(reply) && reply.pke.pnu() == underway.probe.number() {
                    self.channel = Channel::Standing(reply.pke.pnu());
                    // Another master may have left a read of the same parameter: the next probe is about another one.
                    self.unanswered = Unanswered::NONE;
                    self.unanswered.add(&self.profile, underway.probe);
                    underway.stage = self.next_stage(&underway);
                }
            }
            Stage::Reply => {
                if let Some(result) = self.answer(&mut underway, reply) {
                    self.channel = Channel::Standing(underway.job.pnu().number());
                    self.unanswered = Unanswered::NONE;
                    self.work = Work::Over(Outcome { job: underway.job, result });
                    return;
                }
            }
        }
        self.work = Work::Under(underway);
        self.expire(now);
    }

    /// Time has passed without an image. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        self.expire(now);
    }

    /// The drive may have seen other outputs than [`output`](Self::output) gave, or none: Data_Exchange was left, the
    /// master was in Stop or Clear, the drive was switched off.
    ///
    /// Must be called before the next exchange: a write that is still in the output image when Data_Exchange begins
    /// again is a new job to the drive. The job under way ends with [`PkwError::Interrupted`] unless it was not sent
    /// yet.
    pub fn handle_data_exchange_lost(&mut self) {
        self.channel = Channel::Unknown;
        let Work::Under(mut underway) = self.work else {
            return;
        };
        self.abandon(&underway);
        self.work = match underway.stage {
            Stage::NoReply | Stage::Probe => {
                underway.stage = Stage::NoReply;
                underway.probe = self.unanswered.next_probe(&self.profile, underway.job.pnu());
                Work::Under(underway)
            }
            Stage::Reply => Work::Over(Outcome { job: underway.job, result: Err(PkwError::Interrupted) }),
        };
    }

    /// When to call [`handle_timeout`](Self::handle_timeout) if no image comes before; `None` without a job. Changes
    /// with [`submit`](Self::submit) and with the end of a job.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        match &self.work {
            Work::Under(underway) => Some(underway.deadline),
            Work::None | Work::Over(_) => None,
        }
    }

    /// How the job ended; once for each job.
    #[must_use]
    pub fn poll_outcome(&mut self) -> Option<Outcome> {
        match self.work {
            Work::Over(outcome) => {
                self.work = Work::None;
                Some(outcome)
            }
            Work::None | Work::Under(_) => None,
        }
    }

    /// The job under way.
    pub const fn job(&self) -> Option<&Job> {
        match &self.work {
            Work::Under(underway) => Some(&underway.job),
            Work::None | Work::Over(_) => None,
        }
    }

    /// What has to be seen next before or for this job.
    fn next_stage(&self, underway: &Underway) -> Stage {
        match self.channel {
            Channel::Unknown => Stage::NoReply,
            Channel::Quiet => Stage::Probe,
            Channel::Standing(pnu) if pnu == underway.job.pnu().number() => Stage::NoReply,
            Channel::Standing(_) | Channel::Clear => Stage::Reply,
        }
    }

    /// Whatever is being asked is not waited for any more; its reply may still come.
    fn abandon(&mut self, underway: &Underway) {
        let asked = match underway.stage {
            Stage::NoReply => return,
            Stage::Probe => underway.probe,
            Stage::Reply => underway.job.pnu(),
        };
        self.unanswered.add(&self.profile, asked);
        self.channel = Channel::Unknown;
    }

    /// While job 0 is sent: looks whether it was answered.
    fn note_no_reply(&mut self, reply: Pkw) {
        if reply.pke.reply() == ReplyId::NoReply {
            self.channel = match self.channel {
                Channel::Unknown | Channel::Quiet => Channel::Quiet,
                Channel::Standing(_) | Channel::Clear => Channel::Clear,
            };
        }
    }

    /// How the job ends with this image, if it does.
    fn answer(&self, underway: &mut Underway, reply: Pkw) -> Option<Result<Reply, PkwError>> {
        let reply = Pkw { pke: reply.pke.without_spm(), ..reply };
        let previous = underway.seen.take();
        let answer = underway.job.answered_by(reply, &self.profile)?;
        let seen = match previous {
            Some(seen) if same_high_words(seen.reply, reply) => {
                Seen { reply, images: seen.images.saturating_add(1) }
            }
            Some(_) | None => Seen { reply, images: 1 },
        };
        underway.seen = Some(seen);
        match self.profile.images {
            Images::Consistent => Some(answer),
            Images::MayBeTorn => {
                let previous = previous?.reply;
                if previous == reply {
                    return Some(answer);
                }
                if answer.is_err() || !underway.job.is_refreshed() || previous.pke != reply.pke {
                    return None;
                }
                // One word is whole, and the image before had its PKE already.
                if matches!(answer, Ok(Reply::Value(Value::Word(_)))) {
                    return Some(answer);
                }
                // Three images with one high word: the value of the middle one did not change it.
                if seen.images < 3 {
                    return None;
                }
                underway.job.answered_by(previous, &self.profile)
            }
        }
    }

    /// Ends the job that has used up one of its limits.
    fn expire(&mut self, now: Instant) {
        let Work::Under(underway) = self.work else {
            return;
        };
        let limit = if now >= underway.deadline {
            Limit::Time(self.profile.time)
        } else if underway.exchanges >= self.profile.exchanges {
            Limit::Exchanges(self.profile.exchanges)
        } else {
            return;
        };
        self.abandon(&underway);
        let Underway { job, stage, last, .. } = underway;
        self.work = Work::Over(Outcome { job, result: Err(PkwError::TimedOut { stage, limit, last }) });
    }
}

/// Whether it is a reply to some job: neither empty nor a spontaneous message.
const fn is_reply(pkw: Pkw) -> bool {
    match pkw.pke.reply() {
        ReplyId::NoReply | ReplyId::Reserved(_) => false,
        ReplyId::Word
        | ReplyId::DoubleWord
        | ReplyId::Description
        | ReplyId::ElementWord
        | ReplyId::ElementDoubleWord
        | ReplyId::ElementCount
        | ReplyId::NotExecutable
        | ReplyId::NoControlRights => true,
    }
}

/// Whether words 1 to 3 are the same.
fn same_high_words(a: Pkw, b: Pkw) -> bool {
    (a.pke, a.ind, a.pwe_high) == (b.pke, b.ind, b.pwe_high)
}

#[cfg(test)]
mod tests;
