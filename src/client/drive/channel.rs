//! The parameter channel, which the user's jobs and the questions of a goal share.

use crate::client::pkw::{Images, Job, NotSubmitted, Outcome, PkwClient, Profile};
use crate::profibus::ppo::Pkw;
use crate::time::Instant;
use core::time::Duration;

use super::question::Question;

/// What may differ in the parameter channel of an AG03 or AG03/1 from one installation to another. The rest is
/// [`Profile::AG03`]: other drives have other control words, for which [`PkwClient`] alone is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ag03Channel {
    /// Whether the four words of an input image belong together.
    pub images: Images,
    /// How long a job may take.
    pub time: Duration,
    /// How many input images a job may take.
    pub exchanges: u32,
}

impl Ag03Channel {
    /// As in [`Profile::AG03`].
    pub const DEFAULT: Self =
        Self { images: Profile::AG03.images, time: Profile::AG03.time, exchanges: Profile::AG03.exchanges };

    const fn profile(self) -> Profile {
        Profile { images: self.images, time: self.time, exchanges: self.exchanges, ..Profile::AG03 }
    }
}

impl Default for Ag03Channel {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The channel of a drive.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    pkw: PkwClient,
    /// For which step the question under way was asked; `None` if it is not the goal's.
    asking: Option<u32>,
    /// Counts the steps.
    steps: u32,
    /// The user's job, until the question under way is over.
    waiting: Option<Job>,
    /// Of the user's job.
    outcome: Option<Outcome>,
}

impl Channel {
    pub(super) const fn new(channel: Ag03Channel) -> Self {
        Self { pkw: PkwClient::new(channel.profile()), asking: None, steps: 0, waiting: None, outcome: None }
    }

    pub(super) fn output(&self) -> Pkw {
        self.pkw.output()
    }

    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        self.pkw.poll_timeout()
    }

    pub(super) fn handle_input(&mut self, now: Instant, pkw: Pkw) {
        self.pkw.handle_input(now, pkw);
    }

    pub(super) fn handle_timeout(&mut self, now: Instant) {
        self.pkw.handle_timeout(now);
    }

    pub(super) fn handle_data_exchange_lost(&mut self) {
        self.pkw.handle_data_exchange_lost();
    }

    /// Whether a job of the user waits, or its outcome waits to be taken.
    pub(super) const fn is_in_use(&self) -> bool {
        self.waiting.is_some() || self.outcome.is_some()
    }

    /// A job of the user. It waits for the question under way.
    pub(super) fn submit(&mut self, now: Instant, job: Job) -> Result<(), NotSubmitted> {
        if self.asking.is_none() {
            return self.pkw.submit(now, job);
        }
        job.request(self.pkw.profile())?;
        self.waiting = Some(job);
        Ok(())
    }

    /// The job of the user that waits, as soon as the channel is free.
    pub(super) fn send_waiting(&mut self, now: Instant) {
        if let Some(job) = self.waiting
            && self.asking.is_none()
            && self.pkw.submit(now, job).is_ok()
        {
            self.waiting = None;
        }
    }

    pub(super) fn poll_job(&mut self) -> Option<Outcome> {
        self.outcome.take()
    }

    /// A question of the present step, as soon as the channel is free.
    pub(super) fn ask(&mut self, now: Instant, question: Question) {
        if self.asking.is_none() && self.pkw.submit(now, question.job()).is_ok() {
            self.asking = Some(self.steps);
        }
    }

    /// A new step: what was asked before is not its answer.
    pub(super) const fn next_step(&mut self) {
        self.steps = self.steps.wrapping_add(1);
    }

    /// Keeps the outcome of the user's job; gives that of a question of the present step.
    pub(super) fn take_answer(&mut self) -> Option<Outcome> {
        let outcome = self.pkw.poll_outcome()?;
        match self.asking.take() {
            None => self.outcome = Some(outcome),
            Some(step) if step == self.steps => return Some(outcome),
            // The goal it was asked for has been replaced.
            Some(_) => {}
        }
        None
    }
}
