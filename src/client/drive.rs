//! The control words of an AG03 or AG03/1 as goals.
//!
//! | file | holds |
//! | --- | --- |
//! | `goal` | [`Goal`], [`GoalOutcome`], [`Limits`] |
//! | `progress` | `GoalProgress`: a goal under way, what ends its steps and is commanded between them |
//! | `step` | the steps as a table |
//! | `standstill` | whether the shaft stands or turns as it should |
//! | `commanded` | what the outputs command; motions that end by themselves |
//! | `control_word` | the control words |
//! | `course` | enabling and acknowledging as words and bits |
//! | `job` | the travel job, from the edge of STW.6 to its end |
//! | `seen` | what the images show |
//! | `channel` | the parameter channel, shared with the user's jobs |
//! | `obstacle` | [`Obstacles`]: what is in the way, in words |
//! | `question` | the parameters the client reads |

mod channel;
mod commanded;
mod control_word;
mod course;
mod goal;
mod job;
mod obstacle;
mod progress;
mod question;
mod seen;
mod standstill;
mod step;
mod why;

pub use channel::Ag03Channel;
pub use goal::{Goal, GoalError, GoalOutcome, Limits};
pub use obstacle::{Findings, Obstacle, Obstacles};
pub use why::Why;

use core::time::Duration;

use channel::Channel;
use commanded::Commanded;
use control_word::ControlWord;
use job::TravelJob;
use progress::GoalProgress;
use question::Question;
use seen::Seen;
use step::Step;

use super::course::Then;
use super::pkw::{Job, NotSubmitted, Outcome, PkwError};
use crate::profibus::ppo::{Inputs, Outputs, PPO_LEN, Zsw};
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
/// waits for the ZSW patterns that belong to them (`ZswPattern`), and ends with one [`GoalOutcome`]. A new goal takes
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
/// In velocity mode an AG03 whose enable input goes and comes back before the shaft stands shows this in no bit of ZSW,
/// and turns on (`ag03.md` rows 3b and 40). So the client reads SSW again and again while a velocity lasts. A dip that
/// is shorter than two such reads is not noticed.
///
/// A goal that fails leaves nothing that could start later: the control word goes back to 000B (enabled, any motion is
/// stopped), after a failed [`Goal::Enable`] or [`Goal::Acknowledge`] to 0000. A failed [`Goal::Stop`],
/// [`Goal::Pause`] or [`Goal::Disable`] goes on being asked for; without a job to pause, a pause is a stop.
///
/// After [`handle_data_exchange_lost`](Self::handle_data_exchange_lost) the control word is 0000 until a goal enables
/// the drive again.
#[derive(Clone, Debug)]
pub struct DriveClient {
    limits: Limits,
    channel: Channel,
    commanded: Commanded,
    seen: Seen,
    diagnosis: Option<[u8; 2]>,
    activity: Activity,
}

#[derive(Clone, Copy, Debug)]
enum Activity {
    None,
    Pursuing(GoalProgress),
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
    /// With the default [`Ag03Channel`] and [`Limits`].
    fn default() -> Self {
        Self::new(Ag03Channel::DEFAULT, Limits::default())
    }
}

impl DriveClient {
    /// A client for an AG03 or AG03/1 that is not in Data_Exchange yet.
    ///
    /// Its first control word is 0000: a drive that is in motion for another master program is released.
    pub const fn new(channel: Ag03Channel, limits: Limits) -> Self {
        Self {
            limits,
            channel: Channel::new(channel),
            commanded: Commanded::NOTHING,
            seen: Seen::NOTHING,
            diagnosis: None,
            activity: Activity::None,
        }
    }

    /// Begins to pursue a goal. Its time runs from `now` on.
    pub fn pursue(&mut self, now: Instant, goal: Goal) {
        let deadline = now.saturating_add(self.limits.reaction);
        if self.commanded.turns() {
            self.seen.forget_rest();
        }
        self.commanded.begin(goal, self.begins_turning());
        self.channel.next_step();
        self.activity = Activity::Pursuing(GoalProgress::new(goal, deadline));
        self.ask(now);
    }

    /// Takes a job for the parameter channel. Its outcome comes from [`poll_job`](Self::poll_job).
    ///
    /// A write of the operating mode (PNU 930) takes the control word back to 000B, so that STW.6 does not rest at 1:
    /// it ends inching 2 and a velocity.
    ///
    /// # Errors
    /// [`NotSubmitted`] as from [`PkwClient::submit`](crate::client::PkwClient::submit); also busy while the client
    /// itself needs the channel for a goal.
    /// A write of PNU 930 is busy during every goal, and while a travel job is under way or interrupted.
    ///
    /// A job that finds the channel with a question nobody waits for any more, or with the SSW read while a velocity
    /// lasts, waits for its end. Its time runs from there on.
    pub fn submit(&mut self, now: Instant, job: Job) -> Result<(), NotSubmitted> {
        let sets_mode = job.is_write() && job.pnu() == Question::OperatingMode.job().pnu();
        let goal_asks = self.goal().is_some() && self.question().is_some();
        let in_use = self.channel.is_in_use() || goal_asks;
        if in_use || sets_mode && (self.goal().is_some() || self.commanded.job.is_possible()) {
            return Err(NotSubmitted::Busy);
        }
        self.channel.submit(now, job)?;
        if sets_mode {
            // STW.6 is an edge in one mode and a level in the other: a resting 1 would turn the shaft. With bits 4
            // and 5 = 0 its falling edge starts nothing.
            self.commanded.halt();
            self.commanded.start = false;
        }
        Ok(())
    }

    /// A new input image: one call for each exchange whose inputs the caller gets to see.
    pub fn handle_inputs(&mut self, now: Instant, inputs: Inputs<'_>) {
        let zsw = inputs.zsw();
        self.seen.note(now, inputs);
        self.commanded.job = self.commanded.job.seen(self.commanded.word, zsw);
        self.commanded.note_lost_motion(zsw, self.begins_turning());
        if let Activity::Pursuing(progress) = &mut self.activity {
            progress.silence = now.saturating_add(self.limits.reaction);
        }
        self.channel.handle_input(now, inputs.pkw());
        self.go_on(now);
    }

    /// The answer of the drive to Slave_Diag, six octets and more. It only serves to explain why there is no
    /// Data_Exchange (`ag03.md` 12); bits the master sets itself (octet 1 bits 0, 5 and 7) count too.
    pub fn handle_diagnosis(&mut self, octets: &[u8]) {
        self.diagnosis = octets.first_chunk().copied();
    }

    /// Time has passed without an image. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        self.channel.handle_timeout(now);
        self.go_on(now);
    }

    /// The drive may have seen other outputs than [`outputs`](Self::outputs) gave, or none, as
    /// [`PkwClient::handle_data_exchange_lost`](crate::client::PkwClient::handle_data_exchange_lost) says. Must be
    /// called before the next exchange, or the drive may take
    /// the outputs for new commands.
    pub fn handle_data_exchange_lost(&mut self) {
        self.channel.handle_data_exchange_lost();
        self.commanded.end_job_with(ControlWord::Off);
        self.seen.lost();
        match self.activity {
            Activity::Pursuing(GoalProgress { goal, .. })
            | Activity::Explaining(Explaining { obstacles: Obstacles { goal, .. }, .. }) => {
                self.finish(goal, Err(GoalError::Interrupted));
            }
            Activity::None | Activity::Over(_) => {}
        }
        // An interrupted question has no answer.
        let _ = self.channel.take_answer();
    }

    /// The octets of the next output image. Change with every call that takes `&mut self`.
    #[must_use]
    pub fn outputs(&self) -> [u8; PPO_LEN] {
        Outputs::octets(self.channel.output(), self.commanded.stw(), self.commanded.setpoint)
    }

    /// When to call [`handle_timeout`](Self::handle_timeout) if no image comes before.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let goal = match &self.activity {
            Activity::Pursuing(progress) => Some(progress.deadline.min(progress.silence)),
            Activity::Explaining(explaining) => Some(explaining.deadline),
            Activity::None | Activity::Over(_) => None,
        };
        [goal, self.channel.poll_timeout()].into_iter().flatten().min()
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
        self.channel.poll_job()
    }

    /// The goal under way.
    pub const fn goal(&self) -> Option<Goal> {
        match &self.activity {
            Activity::Pursuing(progress) => Some(progress.goal),
            Activity::Explaining(explaining) => Some(explaining.obstacles.goal),
            Activity::None | Activity::Over(_) => None,
        }
    }

    /// The last status word; `None` without Data_Exchange.
    pub const fn zsw(&self) -> Option<Zsw> {
        self.seen.zsw
    }

    /// The last main actual value HIW: the position, in velocity mode the velocity in rpm.
    pub const fn hiw(&self) -> i32 {
        self.seen.hiw
    }

    /// Whether a level of STW has been set to turn the shaft, which need not turn yet.
    const fn begins_turning(&self) -> bool {
        match &self.activity {
            Activity::Pursuing(progress) => progress.step.begins_turning(),
            Activity::None | Activity::Explaining(_) | Activity::Over(_) => false,
        }
    }

    /// The question that waits for the parameter channel or for its answer.
    const fn question(&self) -> Option<Question> {
        match &self.activity {
            Activity::Pursuing(progress) => progress.question,
            Activity::Explaining(explaining) => explaining.question,
            // A loss of the output stage would not show otherwise.
            Activity::None | Activity::Over(_) if self.commanded.is_velocity() => {
                Some(Question::SystemStatus)
            }
            Activity::None | Activity::Over(_) => None,
        }
    }

    fn ask(&mut self, now: Instant) {
        self.channel.send_waiting(now);
        // Without images nobody answers.
        if let Some(question) = self.question()
            && self.seen.zsw.is_some()
        {
            self.channel.ask(now, question);
        }
    }

    fn go_on(&mut self, now: Instant) {
        let question = self.question();
        let answer = self.channel.take_answer();
        if let (Some(Question::SystemStatus), Some(outcome)) = (question, answer) {
            self.commanded.note_output_stage(outcome);
        }
        match self.activity {
            Activity::None | Activity::Over(_) => {}
            Activity::Pursuing(progress) => self.go_on_pursuing(now, progress, answer),
            Activity::Explaining(explaining) => self.go_on_explaining(now, explaining, answer),
        }
        self.ask(now);
    }

    fn go_on_pursuing(&mut self, now: Instant, mut progress: GoalProgress, answer: Option<Outcome>) {
        if let (Some(question), Some(outcome)) = (progress.question, answer) {
            match outcome.result {
                Ok(reply) => {
                    progress.question = None;
                    progress.answer = progress.findings.note(question, reply);
                }
                Err(PkwError::Interrupted) => {}
                Err(error) => {
                    return self.fail_without_explanation(progress.goal, GoalError::Parameter(error));
                }
            }
            self.activity = Activity::Pursuing(progress);
        }
        match progress.advance(now, &mut self.commanded, &self.seen) {
            Then::Stay | Then::Go(_) if now >= progress.silence => {
                let unheard = Findings { diagnosis: self.diagnosis, ..progress.findings };
                self.give_up(now, progress.goal, Some(self.limits.reaction), unheard);
            }
            Then::Stay => self.stay(now, progress),
            Then::Go(step) => {
                let (before, after) = (progress.step.fork(), step.fork());
                if before.time != after.time {
                    progress.deadline = now.saturating_add(self.limits.of(after.time));
                }
                progress.step = step;
                progress.question = after.ask;
                progress.answer = None;
                self.channel.next_step();
                self.stay(now, progress);
            }
            Then::Done => self.finish(progress.goal, Ok(self.seen.hiw)),
            Then::Refused => self.fail(now, &progress, None),
        }
    }

    fn stay(&mut self, now: Instant, progress: GoalProgress) {
        if now >= progress.deadline {
            self.fail(now, &progress, Some(self.limits.of(progress.step.fork().time)));
        } else {
            self.activity = Activity::Pursuing(progress);
        }
    }

    fn go_on_explaining(&mut self, now: Instant, mut explaining: Explaining, answer: Option<Outcome>) {
        if let (Some(question), Some(outcome)) = (explaining.question, answer) {
            if let Ok(reply) = outcome.result {
                explaining.obstacles.findings.note(question, reply);
            }
            explaining.question = explaining.obstacles.question_after(Some(question));
            self.channel.next_step();
        }
        let goal = explaining.obstacles.goal;
        if explaining.question.is_none() || now >= explaining.deadline {
            return self.finish(goal, Err(GoalError::Refused(explaining.obstacles)));
        }
        self.activity = Activity::Explaining(explaining);
    }

    fn fail(&mut self, now: Instant, progress: &GoalProgress, waited: Option<Duration>) {
        // What did not go on in all the time was no job of the drive.
        let job = self.commanded.job == TravelJob::Active && progress.step != Step::Resume;
        let findings = Findings { zsw: self.seen.zsw, diagnosis: self.diagnosis, job, ..progress.findings };
        self.give_up(now, progress.goal, waited, findings);
    }

    /// Makes the drive safe, and begins to find out why the goal was not reached.
    fn give_up(&mut self, now: Instant, goal: Goal, waited: Option<Duration>, findings: Findings) {
        self.make_safe(goal);
        let obstacles = Obstacles { goal, waited, findings };
        let question = obstacles.question_after(None);
        let deadline = now.saturating_add(self.limits.explanation);
        self.channel.next_step();
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
            Goal::Enable | Goal::Acknowledge => self.commanded.end_job_with(ControlWord::Off),
            Goal::MoveTo(_) | Goal::Resume | Goal::Inch | Goal::Jog(_) | Goal::Velocity(_) => {
                self.commanded.halt()
            }
            // Whoever wants to pause what cannot be paused wants it to stop.
            Goal::Pause if self.commanded.job != TravelJob::Active => self.commanded.halt(),
            Goal::Pause | Goal::Stop | Goal::Disable => {}
        }
    }

    fn finish(&mut self, goal: Goal, result: Result<i32, GoalError>) {
        self.channel.next_step();
        self.activity = Activity::Over(GoalOutcome { goal, result });
    }
}
