//! The steps on the way to a goal, and what an image or an answer makes of them.

use super::control_word::ControlWord;
use super::question::Question;
use crate::client::course::Course;

/// Where a goal stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The drive is asked for its operating mode and so shows that it sees the outputs.
    Look,
    /// Enabling or acknowledging.
    State(Course<ControlWord, ()>),
    /// Until the drive stands.
    Halt,
    /// As long as the shaft turns on the way there.
    RunOut,
    /// 000B after 004B, so that STW.6 falls where it starts nothing in either mode.
    Lower,
    /// 003B with the target, until the drive is ready to travel.
    Prepare,
    /// The edge of STW.6, until it is acknowledged; `again`: the second one.
    Start { check: StartCheck, again: bool },
    /// STW.5 until the job goes on.
    Resume,
    /// Until the travel job ends.
    Travel,
    /// At the target, until the shaft stands.
    Settle,
    /// Whether inching is possible.
    Check,
    /// STW.8 until the drive moves.
    StartInching { from: i32 },
    /// The way of inching 1, which did not move the drive yet.
    InchingWay { from: i32 },
    /// Until inching 1 ends.
    Inch,
    /// STW.9 until the drive turns.
    Jog { from: i32 },
    /// The gear, for the largest velocity.
    Range,
    /// The velocity window.
    Window,
    /// Whether the drive can turn.
    Release { window: u32 },
    /// STW.6 until the velocity is reached.
    Turn { window: u32 },
    /// STW.6, and the shaft stands: it begins to turn, or passes through standstill, or cannot turn.
    Stalled { window: u32 },
}

/// What an image or an answer makes of a step.
pub(super) enum Next {
    Stay,
    Step(Step),
    Done,
    /// By what the drive shows.
    Refused,
}

/// What kind of step it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Everything but motion.
    Change,
    /// A motion.
    Motion,
    /// A level of STW has been set to turn the shaft, which need not turn yet.
    Begin,
    /// Both.
    Turn,
}

impl Step {
    /// What is asked in it, and its kind.
    const fn row(self) -> (Option<Question>, Kind) {
        const STATUS: Option<Question> = Some(Question::SystemStatus);
        match self {
            Self::Look => (Some(Question::OperatingMode), Kind::Change),
            Self::State(course) => match course.step() {
                Some(step) if step.until.is_empty() => (STATUS, Kind::Change),
                Some(_) | None => (None, Kind::Change),
            },
            Self::Halt
            | Self::Lower
            | Self::Prepare
            | Self::Resume
            | Self::Settle
            | Self::Check
            | Self::StartInching { .. }
            | Self::Release { .. } => (STATUS, Kind::Change),
            Self::RunOut => (STATUS, Kind::Motion),
            Self::Jog { .. } => (STATUS, Kind::Begin),
            Self::Stalled { .. } => (STATUS, Kind::Turn),
            Self::Start { check, .. } => (Some(check.question()), Kind::Change),
            Self::InchingWay { .. } => (Some(Question::DeltaInch), Kind::Change),
            Self::Range => (Some(Question::HardwareVersion), Kind::Change),
            Self::Window => (Some(Question::Window), Kind::Change),
            Self::Travel | Self::Inch => (None, Kind::Motion),
            Self::Turn { .. } => (None, Kind::Turn),
        }
    }

    pub(super) const fn question(self) -> Option<Question> {
        self.row().0
    }

    /// Whether it has the time of a motion.
    pub(super) const fn is_motion(self) -> bool {
        matches!(self.row().1, Kind::Motion | Kind::Turn)
    }

    /// Whether a level of STW has been set to turn the shaft, which need not turn yet.
    pub(super) const fn begins_turning(self) -> bool {
        matches!(self.row().1, Kind::Begin | Kind::Turn)
    }
}

/// What is asked while a start is not acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StartCheck {
    /// The answer shows that the drive has seen the edge.
    Status,
    Limit1,
    Limit2,
    Window,
}

impl StartCheck {
    pub(super) const fn question(self) -> Question {
        match self {
            Self::Status => Question::SystemStatus,
            Self::Limit1 => Question::Limit1,
            Self::Limit2 => Question::Limit2,
            Self::Window => Question::Window,
        }
    }
}

pub(super) const fn done_if(done: bool) -> Next {
    if done { Next::Done } else { Next::Stay }
}
