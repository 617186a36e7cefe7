//! The travel job of the client: from the edge of STW.6 to its end.

use super::DriveClient;
use super::obstacle::{Obstacle, Obstacles};
use super::posture::Posture;
use super::pursuit::{Next, Pursuit, Step};
use super::question::Question;
use super::zsw::ZswPattern;
use crate::device::bits::ZswBit;
use crate::drive::Mode;
use crate::ppo::Zsw;

/// What became of the last edge of STW.6 in positioning mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TravelJob {
    /// There is no job: none was asked for, or it ended or was discarded.
    None,
    /// The edge is in the outputs and not acknowledged. ZSW.12 was so before.
    Asked { acknowledge: bool },
    /// Acknowledged: under way or interrupted.
    Active,
}

/// What is asked while a start is not acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Doubt {
    /// The answer shows that the drive has seen the edge.
    Status,
    Limit1,
    Limit2,
    Window,
}

impl Doubt {
    pub(super) const fn question(self) -> Question {
        match self {
            Self::Status => Question::SystemStatus,
            Self::Limit1 => Question::Limit1,
            Self::Limit2 => Question::Limit2,
            Self::Window => Question::Window,
        }
    }
}

impl TravelJob {
    /// Whether the drive may have one.
    pub(super) const fn is_possible(self) -> bool {
        match self {
            Self::None => false,
            Self::Asked { .. } | Self::Active => true,
        }
    }

    /// What a new status word makes of it, with the control word that is sent.
    pub(super) fn seen(self, posture: Posture, zsw: Zsw) -> Self {
        match self {
            Self::None => Self::None,
            Self::Asked { acknowledge }
                if ZswBit::JobToggle.is_set(zsw) != acknowledge || ZswPattern::TRAVEL_JOB.matches(zsw) =>
            {
                Self::Active
            }
            Self::Asked { acknowledge } => Self::Asked { acknowledge },
            // An interrupted job may rest in its window.
            Self::Active if posture == Posture::Travel && stands_at_target(zsw) => Self::None,
            Self::Active => Self::Active,
        }
    }
}

pub(super) fn stands_at_target(zsw: Zsw) -> bool {
    ZswBit::Standstill.is_set(zsw) && ZswBit::TargetReached.is_set(zsw)
}

impl DriveClient {
    /// Changes STW.6: row 20.
    pub(super) fn start_job(&mut self, zsw: Zsw, again: bool) -> Next {
        self.start = !self.start;
        self.job = TravelJob::Asked { acknowledge: ZswBit::JobToggle.is_set(zsw) };
        Next::Step(Step::Start { doubt: Doubt::Status, again })
    }

    /// The drive has seen the edge and has not acknowledged it, as far as it shows.
    pub(super) fn doubt_start(&mut self, pursuit: &Pursuit, doubt: Doubt, again: bool, zsw: Zsw) -> Next {
        let obstacles = Obstacles::of(pursuit.goal, pursuit.findings);
        if obstacles.rule_out_travel() || obstacles.contains(Obstacle::TargetBeyondLimits) {
            return Next::Refused;
        }
        let next = |doubt| Next::Step(Step::Start { doubt, again });
        match doubt {
            Doubt::Status => next(Doubt::Limit1),
            Doubt::Limit1 => next(Doubt::Limit2),
            // Perhaps only one of the two edges starts a job (C-32). If both do, this one would be refused too.
            Doubt::Limit2 if !again => self.start_job(zsw, true),
            Doubt::Limit2 => next(Doubt::Window),
            Doubt::Window => {
                let away = pursuit.goal.target().map(|target| target.abs_diff(self.hiw));
                let arrived = away.zip(pursuit.answer).is_some_and(|(away, window)| away <= window);
                // Where ZSW.12 mirrors STW.6 (C-07) it may show nothing of so short a travel.
                if arrived && stands_at_target(zsw) { Next::Step(Step::Travel) } else { Next::Stay }
            }
        }
    }

    /// What no travel can begin with, by the answer to [`Question::SystemStatus`].
    pub(super) fn prepared(&mut self, pursuit: &Pursuit, zsw: Zsw) -> Next {
        if ZswBit::LimitExceeded.is_set(zsw)
            || Obstacles::of(pursuit.goal, pursuit.findings).rule_out_travel()
        {
            return Next::Refused;
        }
        if ZswPattern::ready_to_travel(Mode::Positioning).matches(zsw) {
            self.start_job(zsw, false)
        } else {
            Next::Stay
        }
    }
}

impl Obstacles {
    /// By SSW: no edge would start a job.
    fn rule_out_travel(&self) -> bool {
        [Obstacle::NoOutputStage, Obstacle::AboveUpperLimit, Obstacle::BelowLowerLimit]
            .into_iter()
            .any(|obstacle| self.contains(obstacle))
    }
}
