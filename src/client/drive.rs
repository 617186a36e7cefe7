//! The control words of an AG03 or AG03/1 as goals.
//!
//! | file | holds |
//! | --- | --- |
//! | `goal` | [`Goal`], [`GoalOutcome`], [`Limits`] |
//! | `pursuit` | the steps to each goal, and what ends each step |
//! | `job` | the travel job, from the edge of STW.6 to its end |
//! | `standstill` | whether the shaft stands; motions that end by themselves |
//! | `obstacle` | [`Obstacles`]: what is in the way, in words |
//! | `question` | the parameters the client reads |
//! | `posture` | the control words |
//! | `zsw` | the patterns of the status word |

mod goal;
mod job;
mod obstacle;
mod posture;
mod pursuit;
mod question;
mod standstill;
mod zsw;

pub use goal::{Goal, GoalError, GoalOutcome, Limits};
pub use obstacle::{Findings, Obstacle, Obstacles};
pub use zsw::ZswPattern;

use core::time::Duration;

use job::TravelJob;
use posture::Posture;
use pursuit::{Next, Pursuit, Step};
use question::Question;
use standstill::Rest;

use super::pkw::{Job, NotSubmitted, Outcome, PkwClient, PkwError, Profile};
use crate::ppo::{Inputs, Outputs, PPO_LEN, Zsw};
use crate::time::Instant;

/// The master's end of a whole drive: its control words, its setpoint and its parameter channel.
///
/// **Feed each new input image to [`handle_inputs`](Self::handle_inputs), then put [`outputs`](Self::outputs) into the
/// next output image; take [`poll_outcome`](Self::poll_outcome) and [`poll_job`](Self::poll_job). While no images
/// come, call [`handle_timeout`](Self::handle_timeout) when [`poll_timeout`](Self::poll_timeout) has come.**
///
/// `docs/first-drive.md` shows it with a whole bus.
///
/// # Goals
///
/// [`pursue`](Self::pursue) takes a [`Goal`]. The client goes through the control words of the manual's flow charts,
/// waits for the ZSW patterns that belong to them ([`ZswPattern`]), and ends with one [`GoalOutcome`]. A new goal takes
/// the place of one under way, which then has no outcome: [`Goal::Stop`] and [`Goal::Disable`] act with the next output
/// image.
///
/// A status word says nothing about how old it is. So the client reads a parameter with each new control word: job and
/// control word travel in one image, and once the reply is there, the status words that follow are younger than the
/// control word. One travel job is one edge of STW.6, and it counts as started when ZSW.12 or the pattern of the active
/// job acknowledges it. A drive that has seen the edge and does not acknowledge it gets one more, the other way, unless
/// the target is beyond a limit: perhaps only rising edges start a job (`ag03.md` C-32).
///
/// # When it ends
///
/// A goal that promises standstill is done when the shaft stands: ZSW.13, SSW.4 and for 200 ms the same HIW.
///
/// Everything but motion has [`Limits::reaction`], the motion of [`Goal::MoveTo`], [`Goal::Resume`], [`Goal::Inch`] and
/// [`Goal::Velocity`] has [`Limits::motion`], and so has running down to a stop. A goal that is not reached then, or that
/// the drive refuses by what it shows, ends with [`Obstacles`]: the client reads SSW and what else may be in the way,
/// for at most [`Limits::explanation`]. So does a goal for which no image comes during [`Limits::reaction`].
///
/// No motion begins again by itself: a velocity or inching 2 that ends by a fault, a missing supply or enable input,
/// or a limit takes the control word back to 000B, also when its goal was reached long ago or replaced. There is no
/// outcome then; [`zsw`](Self::zsw) shows it. A velocity that was not reached ends when another goal than a velocity
/// takes its place.
///
/// A goal that fails leaves nothing that could start later: the control word goes back to 000B (enabled, any motion is
/// stopped), after a failed [`Goal::Enable`] or [`Goal::Acknowledge`] to 0000. A failed [`Goal::Stop`],
/// [`Goal::Pause`] or [`Goal::Disable`] goes on being asked for; without a job to pause, a pause is a stop.
///
/// After [`handle_data_exchange_lost`](Self::handle_data_exchange_lost) the control word is 0000 until a goal enables
/// the drive again.
#[derive(Clone, Debug)]
pub struct DriveClient {
    pkw: PkwClient,
    limits: Limits,
    posture: Posture,
    /// STW.6 as it rests in positioning mode.
    start: bool,
    setpoint: i32,
    job: TravelJob,
    zsw: Option<Zsw>,
    hiw: i32,
    /// `None` without an image.
    rest: Option<Rest>,
    diagnosis: Option<[u8; 2]>,
    activity: Activity,
    /// For which step the question under way was asked; `None` if the parameter channel is not ours.
    asking: Option<u32>,
    /// Counts the steps.
    steps: u32,
    job_outcome: Option<Outcome>,
}

#[derive(Clone, Copy, Debug)]
enum Activity {
    None,
    Pursuing(Pursuit),
    Explaining(Explaining),
    Over(GoalOutcome),
}

/// A goal that failed, while the client finds out why.
#[derive(Clone, Copy, Debug)]
struct Explaining {
    obstacles: Obstacles,
    question: Option<Question>,
    deadline: Instant,
}

impl Default for DriveClient {
    /// With [`Profile::AG03`] and the default [`Limits`].
    fn default() -> Self {
        Self::new(Profile::AG03, Limits::default())
    }
}

impl DriveClient {
    /// A client for a drive that is not in Data_Exchange yet.
    ///
    /// Its first control word is 0000: a drive that is in motion for another master program is released.
    pub const fn new(profile: Profile, limits: Limits) -> Self {
        Self {
            pkw: PkwClient::new(profile),
            limits,
            posture: Posture::Off,
            start: false,
            setpoint: 0,
            job: TravelJob::None,
            zsw: None,
            hiw: 0,
            rest: None,
            diagnosis: None,
            activity: Activity::None,
            asking: None,
            steps: 0,
            job_outcome: None,
        }
    }

    /// Begins to pursue a goal. Its time runs from `now` on.
    pub fn pursue(&mut self, now: Instant, goal: Goal) {
        let deadline = now.saturating_add(self.limits.reaction);
        let pursuit = Pursuit::new(goal, deadline);
        self.adopt_at_once(goal);
        self.enter(pursuit);
        self.ask(now);
    }

    /// Takes a job for the parameter channel. Its outcome comes from [`poll_job`](Self::poll_job).
    ///
    /// A write of the operating mode (PNU 930) takes the control word back to 000B, so that STW.6 does not rest at 1:
    /// it ends inching 2 and a velocity.
    ///
    /// # Errors
    /// [`NotSubmitted`] as from [`PkwClient::submit`]; also busy while the client itself needs the channel for a goal.
    /// A write of PNU 930 is busy during every goal, and while a travel job is under way or interrupted.
    pub fn submit(&mut self, now: Instant, job: Job) -> Result<(), NotSubmitted> {
        let sets_mode = job.is_write() && job.pnu() == Question::OperatingMode.job().pnu();
        let in_use = self.asking.is_some() || self.question().is_some() || self.job_outcome.is_some();
        if in_use || sets_mode && (self.goal().is_some() || self.job.is_possible()) {
            return Err(NotSubmitted::Busy);
        }
        self.pkw.submit(now, job)?;
        if sets_mode {
            // STW.6 is an edge in one mode and a level in the other: a resting 1 would turn the shaft. With bits 4
            // and 5 = 0 its falling edge starts nothing.
            self.halt();
            self.start = false;
        }
        Ok(())
    }

    /// A new input image: one call for each exchange whose inputs the caller gets to see.
    pub fn handle_inputs(&mut self, now: Instant, inputs: Inputs<'_>) {
        let (zsw, hiw) = (inputs.zsw(), inputs.hiw());
        (self.zsw, self.hiw) = (Some(zsw), hiw);
        self.rest = Some(Rest::seen(self.rest, now, hiw));
        self.job = self.job.seen(self.posture, zsw);
        self.note_lost_motion(zsw);
        if let Activity::Pursuing(pursuit) = &mut self.activity {
            pursuit.silence = now.saturating_add(self.limits.reaction);
        }
        self.pkw.handle_input(now, inputs.pkw());
        self.go_on(now);
    }

    /// The answer of the drive to Slave_Diag, six octets and more. It only serves to explain why there is no
    /// Data_Exchange (`ag03.md` 12); bits the master sets itself (octet 1 bits 0, 5 and 7) count too.
    pub fn handle_diagnosis(&mut self, octets: &[u8]) {
        self.diagnosis = octets.first_chunk().copied();
    }

    /// Time has passed without an image. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        self.pkw.handle_timeout(now);
        self.go_on(now);
    }

    /// The drive may have seen other outputs than [`outputs`](Self::outputs) gave, or none, as
    /// [`PkwClient::handle_data_exchange_lost`] says. Must be called before the next exchange, or the drive may take
    /// the outputs for new commands.
    pub fn handle_data_exchange_lost(&mut self) {
        self.pkw.handle_data_exchange_lost();
        self.posture = Posture::Off;
        self.start = false;
        self.job = TravelJob::None;
        self.zsw = None;
        self.rest = None;
        match self.activity {
            Activity::Pursuing(Pursuit { goal, .. })
            | Activity::Explaining(Explaining { obstacles: Obstacles { goal, .. }, .. }) => {
                self.finish(goal, Err(GoalError::Interrupted));
            }
            Activity::None | Activity::Over(_) => {}
        }
        self.take_job_outcome();
    }

    /// The octets of the next output image. Change with every call that takes `&mut self`.
    #[must_use]
    pub fn outputs(&self) -> [u8; PPO_LEN] {
        Outputs::octets(self.pkw.output(), self.posture.stw(self.start), self.setpoint)
    }

    /// When to call [`handle_timeout`](Self::handle_timeout) if no image comes before.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let goal = match &self.activity {
            Activity::Pursuing(pursuit) => Some(pursuit.deadline.min(pursuit.silence)),
            Activity::Explaining(explaining) => Some(explaining.deadline),
            Activity::None | Activity::Over(_) => None,
        };
        [goal, self.pkw.poll_timeout()].into_iter().flatten().min()
    }

    /// How the goal ended; once for each goal whose place no other took.
    #[must_use]
    pub fn poll_outcome(&mut self) -> Option<GoalOutcome> {
        match self.activity {
            Activity::Over(outcome) => {
                self.activity = Activity::None;
                Some(outcome)
            }
            Activity::None | Activity::Pursuing(_) | Activity::Explaining(_) => None,
        }
    }

    /// How the job of [`submit`](Self::submit) ended; once for each job.
    #[must_use]
    pub fn poll_job(&mut self) -> Option<Outcome> {
        self.job_outcome.take()
    }

    /// The goal under way.
    pub const fn goal(&self) -> Option<Goal> {
        match &self.activity {
            Activity::Pursuing(pursuit) => Some(pursuit.goal),
            Activity::Explaining(explaining) => Some(explaining.obstacles.goal),
            Activity::None | Activity::Over(_) => None,
        }
    }

    /// The last status word; `None` without Data_Exchange.
    pub const fn zsw(&self) -> Option<Zsw> {
        self.zsw
    }

    /// The last main actual value HIW: the position, in velocity mode the velocity in rpm.
    pub const fn hiw(&self) -> i32 {
        self.hiw
    }

    /// What cannot wait for anything.
    fn adopt_at_once(&mut self, goal: Goal) {
        if self.job.is_possible() || matches!(self.posture, Posture::Inch | Posture::Jog(_) | Posture::Turn) {
            // A shaft that has just begun to turn has hardly left its place.
            self.rest = None;
        }
        match goal {
            Goal::Stop => self.halt(),
            // The drive takes no job while it has one.
            Goal::MoveTo(_) | Goal::Inch | Goal::Jog(_) if self.job.is_possible() => self.halt(),
            Goal::Disable if self.posture != Posture::Off => self.adopt(Posture::Disabled),
            Goal::Pause if self.job.is_possible() => self.posture = Posture::Paused,
            Goal::Resume if self.job.is_possible() => self.posture = Posture::Travel,
            // Another velocity takes over without a stop.
            Goal::Velocity(_) if self.posture == Posture::Turn => {}
            // Inching ends, and so does a velocity that was not reached; a travel job or a velocity goes on until the
            // new goal changes it.
            Goal::Enable
            | Goal::Acknowledge
            | Goal::MoveTo(_)
            | Goal::Pause
            | Goal::Resume
            | Goal::Inch
            | Goal::Jog(_)
            | Goal::Velocity(_)
                if matches!(self.posture, Posture::Inch | Posture::Jog(_)) || self.is_turning_up() =>
            {
                self.posture = Posture::Enabled;
            }
            Goal::Enable
            | Goal::Acknowledge
            | Goal::MoveTo(_)
            | Goal::Pause
            | Goal::Resume
            | Goal::Inch
            | Goal::Jog(_)
            | Goal::Velocity(_)
            | Goal::Disable => {}
        }
    }

    /// Whether a velocity is released and not reached yet.
    fn is_turning_up(&self) -> bool {
        let begins = match self.activity {
            Activity::Pursuing(Pursuit { step, .. }) => step.begins_turning(),
            Activity::None | Activity::Explaining(_) | Activity::Over(_) => false,
        };
        begins && self.posture == Posture::Turn
    }

    /// Back to "enabled and nothing else", if operation is enabled at all.
    fn halt(&mut self) {
        self.job = TravelJob::None;
        if self.posture.enables() {
            self.posture = Posture::Enabled;
        }
    }

    /// A control word that ends every job.
    fn adopt(&mut self, posture: Posture) {
        self.posture = posture;
        self.start &= posture.enables();
        self.job = TravelJob::None;
    }

    fn enter(&mut self, pursuit: Pursuit) {
        self.steps = self.steps.wrapping_add(1);
        self.activity = Activity::Pursuing(pursuit);
    }

    /// The question that waits for the parameter channel or for its answer.
    const fn question(&self) -> Option<Question> {
        match &self.activity {
            Activity::Pursuing(pursuit) => pursuit.question,
            Activity::Explaining(explaining) => explaining.question,
            Activity::None | Activity::Over(_) => None,
        }
    }

    fn ask(&mut self, now: Instant) {
        // Without images nobody answers.
        if let Some(question) = self.question()
            && self.zsw.is_some()
            && self.asking.is_none()
            && self.pkw.submit(now, question.job()).is_ok()
        {
            self.asking = Some(self.steps);
        }
    }

    /// Keeps the outcome of the user's job; gives that of a question of the present step.
    fn take_job_outcome(&mut self) -> Option<Outcome> {
        let outcome = self.pkw.poll_outcome()?;
        match self.asking.take() {
            None => self.job_outcome = Some(outcome),
            Some(step) if step == self.steps => return Some(outcome),
            // The goal it was asked for has been replaced.
            Some(_) => {}
        }
        None
    }

    fn go_on(&mut self, now: Instant) {
        let answer = self.take_job_outcome();
        match self.activity {
            Activity::None | Activity::Over(_) => {}
            Activity::Pursuing(pursuit) => self.go_on_pursuing(now, pursuit, answer),
            Activity::Explaining(explaining) => self.go_on_explaining(now, explaining, answer),
        }
        self.ask(now);
    }

    fn go_on_pursuing(&mut self, now: Instant, mut pursuit: Pursuit, answer: Option<Outcome>) {
        if let (Some(question), Some(outcome)) = (pursuit.question, answer) {
            match outcome.result {
                Ok(reply) => {
                    pursuit.question = None;
                    pursuit.answer = pursuit.findings.note(question, reply);
                }
                Err(PkwError::Interrupted) => {}
                Err(error) => {
                    return self.fail_without_explanation(pursuit.goal, GoalError::Parameter(error));
                }
            }
            self.activity = Activity::Pursuing(pursuit);
        }
        match self.advance(now, &pursuit) {
            Next::Stay | Next::Step(_) if now >= pursuit.silence => {
                let unheard = Findings { diagnosis: self.diagnosis, ..pursuit.findings };
                self.give_up(now, pursuit.goal, Some(self.limits.reaction), unheard);
            }
            Next::Stay => self.stay(now, pursuit),
            Next::Step(step) => {
                let (before, after) = (pursuit.step.is_motion(), step.is_motion());
                if before != after {
                    pursuit.deadline = now.saturating_add(self.limits.of(after));
                }
                pursuit.step = step;
                pursuit.question = step.question();
                pursuit.answer = None;
                self.steps = self.steps.wrapping_add(1);
                self.stay(now, pursuit);
            }
            Next::Done => self.finish(pursuit.goal, Ok(self.hiw)),
            Next::Refused => self.fail(now, &pursuit, None),
        }
    }

    fn stay(&mut self, now: Instant, pursuit: Pursuit) {
        if now >= pursuit.deadline {
            self.fail(now, &pursuit, Some(self.limits.of(pursuit.step.is_motion())));
        } else {
            self.activity = Activity::Pursuing(pursuit);
        }
    }

    fn go_on_explaining(&mut self, now: Instant, mut explaining: Explaining, answer: Option<Outcome>) {
        if let (Some(question), Some(outcome)) = (explaining.question, answer) {
            if let Ok(reply) = outcome.result {
                explaining.obstacles.findings.note(question, reply);
            }
            explaining.question = explaining.obstacles.question_after(Some(question));
            self.steps = self.steps.wrapping_add(1);
        }
        let goal = explaining.obstacles.goal;
        if explaining.question.is_none() || now >= explaining.deadline {
            return self.finish(goal, Err(GoalError::Refused(explaining.obstacles)));
        }
        self.activity = Activity::Explaining(explaining);
    }

    fn fail(&mut self, now: Instant, pursuit: &Pursuit, waited: Option<Duration>) {
        // What did not go on in all the time was no job of the drive.
        let job = self.job == TravelJob::Active && pursuit.step != Step::Resume;
        let findings = Findings { zsw: self.zsw, diagnosis: self.diagnosis, job, ..pursuit.findings };
        self.give_up(now, pursuit.goal, waited, findings);
    }

    /// Makes the drive safe, and begins to find out why the goal was not reached.
    fn give_up(&mut self, now: Instant, goal: Goal, waited: Option<Duration>, findings: Findings) {
        self.make_safe(goal);
        let obstacles = Obstacles { goal, waited, findings };
        let question = obstacles.question_after(None);
        let deadline = now.saturating_add(self.limits.explanation);
        self.steps = self.steps.wrapping_add(1);
        self.activity = Activity::Explaining(Explaining { obstacles, question, deadline });
        if question.is_none() {
            self.finish(goal, Err(GoalError::Refused(obstacles)));
        }
    }

    fn fail_without_explanation(&mut self, goal: Goal, error: GoalError) {
        self.make_safe(goal);
        self.finish(goal, Err(error));
    }

    fn make_safe(&mut self, goal: Goal) {
        match goal {
            Goal::Enable | Goal::Acknowledge => self.adopt(Posture::Off),
            Goal::MoveTo(_) | Goal::Resume | Goal::Inch | Goal::Jog(_) | Goal::Velocity(_) => self.halt(),
            // Whoever wants to pause what cannot be paused wants it to stop.
            Goal::Pause if self.job != TravelJob::Active => self.halt(),
            Goal::Pause | Goal::Stop | Goal::Disable => {}
        }
    }

    fn finish(&mut self, goal: Goal, result: Result<i32, GoalError>) {
        self.activity = Activity::Over(GoalOutcome { goal, result });
    }
}
