//! The start of a travel job: ready to travel, the edge of STW.6, and whether the drive has taken it.

use super::commanded::Commanded;
use super::job::{TravelJob, stands_at_target};
use super::obstacle::Obstacle;
use super::progress::GoalProgress;
use super::seen::Seen;
use super::step::{Next, StartCheck, Step};
use super::zsw::ZswPattern;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::profibus::ppo::Zsw;

impl GoalProgress {
    /// The drive has seen the edge and has not acknowledged it, as far as it shows.
    pub(super) fn check_start(
        &self,
        commanded: &mut Commanded,
        seen: &Seen,
        check: StartCheck,
        again: bool,
        zsw: Zsw,
    ) -> Next {
        let obstacles = self.obstacles();
        if obstacles.rule_out_travel() || obstacles.contains(Obstacle::TargetBeyondLimits) {
            return Next::Refused;
        }
        let next = |check| Next::Step(Step::Start { check, again });
        match check {
            StartCheck::Status => next(StartCheck::Limit1),
            StartCheck::Limit1 => next(StartCheck::Limit2),
            // Perhaps only one of the two edges starts a job (C-32). If both do, this one would be refused too.
            StartCheck::Limit2 if !again => start(commanded, zsw, true),
            StartCheck::Limit2 => next(StartCheck::Window),
            StartCheck::Window => {
                let away = self.goal.target().map(|target| target.abs_diff(seen.hiw));
                let arrived = away.zip(self.answer).is_some_and(|(away, window)| away <= window);
                // Where ZSW.12 mirrors STW.6 (C-07) it may show nothing of so short a travel.
                if arrived && stands_at_target(zsw) { Next::Step(Step::Travel) } else { Next::Stay }
            }
        }
    }

    /// What no travel can begin with, by the answer to [`Question::SystemStatus`](super::question::Question::SystemStatus).
    pub(super) fn start_when_ready(&self, commanded: &mut Commanded, zsw: Zsw) -> Next {
        if ZswBit::LimitExceeded.is_set(zsw) || self.obstacles().rule_out_travel() {
            return Next::Refused;
        }
        if ZswPattern::ready_to_travel(Mode::Positioning).matches(zsw) {
            start(commanded, zsw, false)
        } else {
            Next::Stay
        }
    }
}

/// Changes the start bit (STW.6): an edge starts a job (row 20).
fn start(commanded: &mut Commanded, zsw: Zsw, again: bool) -> Next {
    commanded.start = !commanded.start;
    commanded.job = TravelJob::Asked { acknowledge: ZswBit::JobToggle.is_set(zsw) };
    Next::Step(Step::Start { check: StartCheck::Status, again })
}
