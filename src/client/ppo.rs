//! The control words of a drive with variable speed of PROFIDRIVE version 2 as goals.
//!
//! | file | holds |
//! | --- | --- |
//! | `course` | the steps to each goal |
//! | `goal` | [`PpoGoal`], [`PpoOutcome`], [`PpoLimits`], and why a goal is not reached |

mod course;
mod goal;

pub use goal::{PpoGoal, PpoGoalError, PpoLimits, PpoOutcome};

use course::{Act, OFF1, RUN};

use super::course::{Course, Shown, Step, Time};
use super::pkw::{Job, NotSubmitted, Outcome, PkwClient, Profile};
use crate::devices::ppo_drive::profile::ZswBit;
use crate::profibus::ppo::{Pkw, PpoType, Stw, Zsw};
use crate::time::Instant;

/// Input images that may be older than the control word they come after.
const STALE_IMAGES: u32 = 3;

/// The setpoint of 100 %.
const FULL: i32 = 0x4000;
/// The speed is reached within this part of 100 %, 3 %.
const TOLERANCE: i32 = FULL * 3 / 100;

/// The master's end of a drive with variable speed of PROFIDRIVE version 2: its control words, its setpoint and, with PPO 1, 2
/// and 5, its parameter channel.
///
/// Used as [`DriveClient`](super::DriveClient) is: **feed each new input image to [`handle_inputs`](Self::handle_inputs), then
/// put [`outputs`](Self::outputs) into the next output image; take [`poll_outcome`](Self::poll_outcome) and
/// [`poll_job`](Self::poll_job). While no images come, call [`handle_timeout`](Self::handle_timeout) when
/// [`poll_timeout`](Self::poll_timeout) has come.**
///
/// ```
/// use profidrive::client::{PpoClient, PpoGoal, PpoLimits, Profile};
/// use profidrive::profibus::ppo::PpoType;
/// use profidrive::time::Instant;
///
/// let mut client = PpoClient::new(PpoType::Ppo3, Profile::PROFIDRIVE, PpoLimits::default());
/// client.pursue(Instant::ZERO, PpoGoal::Run(0x2000));
/// assert_eq!(client.outputs(&mut [0; PpoClient::MOST]), [0x04, 0x7E, 0, 0], "OFF1 comes first");
/// ```
///
/// A new goal takes the place of one under way, which then has no outcome. The first control word is OFF1 (047E), which the
/// profile wants after switching on and after a fault; a drive that turns for another master brakes.
///
/// A status word says nothing about how old it is: the first three images after a change of the control word count for
/// nothing. Words of process data behind the second are sent as 0.
///
/// When Data_Exchange is lost, and when a goal fails, the control word is OFF1 again: nothing starts by itself. A drive that is
/// in operation brakes on its ramp then.
#[derive(Clone, Debug)]
pub struct PpoClient {
    kind: PpoType,
    limits: PpoLimits,
    stw: Stw,
    setpoint: i16,
    channel: PkwClient,
    seen: Option<Seen>,
    activity: Activity,
}

/// What the last image showed.
#[derive(Clone, Copy, Debug)]
struct Seen {
    zsw: Zsw,
    actual: i16,
    /// Images since the control word was changed.
    images: u32,
}

#[derive(Clone, Copy, Debug)]
enum Activity {
    None,
    Pursuing(Pursuit),
    Over(PpoOutcome),
}

/// A goal under way.
#[derive(Clone, Copy, Debug)]
struct Pursuit {
    goal: PpoGoal,
    course: Course<Act, ()>,
    deadline: Instant,
    /// A drive that still runs down is waited for as long as this.
    until: Instant,
}

/// What the last image makes of a step.
enum Look {
    Wait,
    Next(i16),
    Over(Result<i16, PpoGoalError>),
}

impl PpoClient {
    /// Octets of the longest PPO.
    pub const MOST: usize = PpoType::Ppo5.len();

    /// A client for a drive with this PPO that is not in Data_Exchange yet. `profile` says how its parameter channel is.
    pub const fn new(kind: PpoType, profile: Profile, limits: PpoLimits) -> Self {
        Self {
            kind,
            limits,
            stw: Stw::from_raw(OFF1),
            setpoint: 0,
            channel: PkwClient::new(profile),
            seen: None,
            activity: Activity::None,
        }
    }

    /// The PPO.
    pub(crate) const fn kind(&self) -> PpoType {
        self.kind
    }

    /// Begins to pursue a goal. Its time runs from `now` on.
    pub fn pursue(&mut self, now: Instant, goal: PpoGoal) {
        let in_operation = self.stw.raw() == RUN && self.shows(ZswBit::OperationEnabled);
        let until = now.saturating_add(self.limits.motion);
        self.begin(now, Pursuit { goal, course: goal.course(in_operation), deadline: now, until }, 0);
        self.go_on(now);
    }

    /// Takes a job for the parameter channel. Its outcome comes from [`poll_job`](Self::poll_job).
    ///
    /// # Errors
    /// [`NotSubmitted`] as from [`PkwClient::submit`]; with PPO 3 and 4, which have no parameter channel,
    /// [`NotSubmitted::NoSuchJob`].
    pub fn submit(&mut self, now: Instant, job: Job) -> Result<(), NotSubmitted> {
        if !self.kind.has_pkw() {
            return Err(NotSubmitted::NoSuchJob { job });
        }
        self.channel.submit(now, job)
    }

    /// A new input image: one call for each exchange whose inputs the caller gets to see. `false`: it has not the octets of
    /// the PPO, and is ignored.
    pub fn handle_inputs(&mut self, now: Instant, inputs: &[u8]) -> bool {
        if inputs.len() != self.kind.len() {
            return false;
        }
        let (pkw, pzd) = if self.kind.has_pkw() {
            let Some((pkw, pzd)) = inputs.split_first_chunk() else { return false };
            (Some(Pkw::from_octets(*pkw)), pzd)
        } else {
            (None, inputs)
        };
        let Some([a, b, c, d]) = pzd.first_chunk() else { return false };
        let (zsw, actual) = (Zsw::from_raw(u16::from_be_bytes([*a, *b])), i16::from_be_bytes([*c, *d]));
        let images = self.seen.map_or(0, |seen| seen.images).saturating_add(1);
        self.seen = Some(Seen { zsw, actual, images });
        if let Some(pkw) = pkw {
            self.channel.handle_input(now, pkw);
        }
        self.go_on(now);
        true
    }

    /// Time has passed without an image. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        self.channel.handle_timeout(now);
        self.go_on(now);
    }

    /// The drive may have seen other outputs than [`outputs`](Self::outputs) gave, or none. Must be called before the next
    /// exchange.
    pub(crate) fn handle_data_exchange_lost(&mut self) {
        self.channel.handle_data_exchange_lost();
        self.command(OFF1);
        self.seen = None;
        if let Activity::Pursuing(Pursuit { goal, .. }) = self.activity {
            self.activity = Activity::Over(PpoOutcome { goal, result: Err(PpoGoalError::Interrupted) });
        }
    }

    /// The octets of the next output image, as many as the PPO has. Change with every call that takes `&mut self`.
    #[must_use]
    pub fn outputs<'b>(&self, buf: &'b mut [u8; Self::MOST]) -> &'b [u8] {
        let pkw = self.kind.has_pkw().then(|| self.channel.output().to_octets());
        let words = [self.stw.raw(), self.setpoint.cast_unsigned()].map(u16::to_be_bytes);
        let octets = pkw.iter().flatten().chain(words.as_flattened()).copied();
        let octets = octets.chain(core::iter::repeat(0));
        buf.iter_mut().zip(octets).for_each(|(place, octet)| *place = octet);
        buf.get(..self.kind.len()).unwrap_or(buf)
    }

    /// When to call [`handle_timeout`](Self::handle_timeout) if no image comes before.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let goal = match &self.activity {
            Activity::Pursuing(pursuit) => Some(pursuit.deadline),
            Activity::None | Activity::Over(_) => None,
        };
        Instant::first_of(goal, self.channel.poll_timeout())
    }

    /// How the goal ended; once for each goal whose place no other took.
    #[must_use]
    pub const fn poll_outcome(&mut self) -> Option<PpoOutcome> {
        match self.activity {
            Activity::Over(outcome) => {
                self.activity = Activity::None;
                Some(outcome)
            }
            Activity::None | Activity::Pursuing(_) => None,
        }
    }

    /// How the job of [`submit`](Self::submit) ended; once for each job.
    #[must_use]
    pub fn poll_job(&mut self) -> Option<Outcome> {
        self.channel.poll_outcome()
    }

    /// The control word that is sent.
    pub(crate) const fn stw(&self) -> Stw {
        self.stw
    }

    /// The last status word; `None` without Data_Exchange.
    pub(crate) fn zsw(&self) -> Option<Zsw> {
        self.seen.map(|seen| seen.zsw)
    }

    /// The last actual value: 4000h is 100 % of the reference speed; 0 without Data_Exchange.
    pub(crate) fn actual(&self) -> i16 {
        self.seen.map_or(0, |seen| seen.actual)
    }

    fn shows(&self, bit: ZswBit) -> bool {
        self.seen.is_some_and(|seen| bit.is_set(seen.zsw))
    }

    /// Another control word; its setpoint is 0.
    const fn command(&mut self, stw: u16) {
        if self.stw.raw() == stw {
            return;
        }
        if let Some(seen) = &mut self.seen {
            seen.images = 0;
        }
        self.stw = Stw::from_raw(stw);
        self.setpoint = 0;
    }

    /// Begins the present step; behind the last the goal is reached.
    fn begin(&mut self, now: Instant, pursuit: Pursuit, actual: i16) {
        let Some(step) = pursuit.course.step() else { return self.finish(pursuit.goal, Ok(actual)) };
        match step.act {
            Act::Word(word) => self.command(word),
            Act::Setpoint => self.setpoint = pursuit.goal.setpoint(),
        }
        let limit = match step.time {
            Time::Reaction => self.limits.reaction,
            Time::Motion => self.limits.motion,
        };
        self.activity = Activity::Pursuing(Pursuit { deadline: now.saturating_add(limit), ..pursuit });
    }

    fn go_on(&mut self, now: Instant) {
        let Activity::Pursuing(pursuit) = self.activity else { return };
        let Some(step) = pursuit.course.step() else { return };
        match self.look(pursuit.goal, step) {
            Look::Over(result) => self.finish(pursuit.goal, result),
            Look::Next(actual) => {
                self.begin(now, Pursuit { course: pursuit.course.next(), ..pursuit }, actual);
            }
            // It runs down on its ramp.
            Look::Wait if step.act == Act::Word(OFF1) && self.shows(ZswBit::Ready) && now < pursuit.until => {
                let deadline = now.saturating_add(self.limits.reaction);
                self.activity = Activity::Pursuing(Pursuit { deadline, ..pursuit });
            }
            Look::Wait if now >= pursuit.deadline => {
                let error = match self.seen {
                    Some(seen) => {
                        PpoGoalError::TimedOut { stw: self.stw, zsw: seen.zsw, actual: seen.actual }
                    }
                    None => PpoGoalError::NoInputs,
                };
                self.finish(pursuit.goal, Err(error));
            }
            Look::Wait => {}
        }
    }

    fn look(&self, goal: PpoGoal, step: &Step<Act, ()>) -> Look {
        let Some(Seen { zsw, actual, .. }) = self.seen.filter(|seen| seen.images > STALE_IMAGES) else {
            return Look::Wait;
        };
        if ZswBit::Fault.is_set(zsw) && goal != PpoGoal::Acknowledge {
            // A drive in fault stands or runs out: that is what Disable is about.
            return Look::Over(if goal == PpoGoal::Disable { Ok(actual) } else { Err(PpoGoalError::Fault) });
        }
        let apart = i32::from(actual).abs_diff(self.setpoint.into());
        match step.shown(zsw.raw()) {
            Shown::Wait => Look::Wait,
            Shown::Lost => Look::Over(Err(PpoGoalError::Ended { zsw })),
            Shown::Done if step.act == Act::Setpoint && apart > TOLERANCE.unsigned_abs() => Look::Wait,
            Shown::Done => Look::Next(actual),
        }
    }

    fn finish(&mut self, goal: PpoGoal, result: Result<i16, PpoGoalError>) {
        if result.is_err() || goal == PpoGoal::Acknowledge {
            self.command(OFF1);
        }
        if goal == PpoGoal::Enable {
            self.setpoint = 0;
        }
        self.activity = Activity::Over(PpoOutcome { goal, result });
    }
}

#[cfg(test)]
mod tests;
