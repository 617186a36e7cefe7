//! The steps on the way to a goal as a table: what is asked in each, and what comes by the answer and the image.
//!
//! | goal | steps |
//! | --- | --- |
//! | enable, acknowledge | look, then the words of `course` |
//! | move to | look, (lower,) prepare, start, travel (, settle) |
//! | pause, stop, disable | look, halt (, run out) |
//! | resume | look, resume, travel (, settle) |
//! | inch | look, check, start inching (, inching way), inch (, settle) |
//! | jog | look, check, jog |
//! | velocity | look, range, window, release, turn (, stalled) |

use super::control_word::ControlWord;
use super::question::Question;
use crate::client::course;
use crate::client::course::{Course, Then};

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
    StartInching,
    /// The way of inching 1, which did not move the drive yet.
    InchingWay,
    /// Until inching 1 ends.
    Inch,
    /// STW.9 until the drive turns.
    Jog,
    /// The gear, for the largest velocity.
    Range,
    /// The velocity window.
    Window,
    /// Whether the drive can turn.
    Release,
    /// STW.6 until the velocity is reached.
    Turn,
    /// STW.6, and the shaft stands: it begins to turn, or passes through standstill, or cannot turn.
    Stalled,
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

/// What an image and the answer show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum When {
    Always,
    /// ZSW.13 = 0.
    Moves,
    /// SSW.4, as last read.
    Travels,
    /// The actual value is not where the motion began, or ZSW.13 = 0.
    Moved,
    /// The shaft does not rest, or ZSW is none that the goal ends with.
    NotHalted,
    /// A pause, and the drive has kept its job.
    Paused,
    Pausing,
    NoOutputStage,
    /// What no travel can begin with.
    NoTravel,
    TargetBeyondLimits,
    LimitExceeded,
    ReadyToStart,
    /// Where ZSW.12 mirrors STW.6 (C-07) it may show nothing of so short a travel.
    StandsInWindow,
    TargetReached,
    /// The motion ended elsewhere than at its target.
    NotArrived,
    /// An AG03 that lost its enable input runs out with ZSW.13 = 1, but is not ready to travel (row 3b).
    ReadyToTravel,
    Jogging,
    Jogs,
    /// The answer is 0.
    NoWay,
    BeyondGear,
    /// ZSW.13 = 1, and a velocity is asked for.
    Stands,
    AtSpeed,
}

/// What is commanded or noted between two steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Act {
    /// 003B with the target.
    Prepare,
    /// The edge of STW.6.
    Start,
    /// The end of a motion that reached its target.
    Leave,
    /// There is no job to pause.
    ForgetJob,
    /// STW.8 or STW.9, from here.
    Inch,
    /// The answer is the velocity window.
    KeepWindow,
    /// STW.6 with the velocity.
    Turn,
}

pub(super) type Fork = course::Fork<Question, When, Act, Step>;
type Row = course::Row<When, Act, Step>;

const fn go(when: When, to: Step) -> Row {
    Row::new(when, Then::Go(to))
}

const fn refused(when: When) -> Row {
    Row::new(when, Then::Refused)
}

const HALT: &[Row] = &[
    go(When::Travels, Step::RunOut),
    go(When::NotHalted, Step::Halt),
    Row::new(When::Paused, Then::Done),
    Row::act(When::Pausing, Act::ForgetJob, Then::Refused),
    Row::new(When::Always, Then::Done),
];
const LOWER: &[Row] = &[Row::act(When::Always, Act::Prepare, Then::Go(Step::Prepare))];
const PREPARE: &[Row] = &[
    refused(When::LimitExceeded),
    refused(When::NoTravel),
    Row::act(
        When::ReadyToStart,
        Act::Start,
        Then::Go(Step::Start { check: StartCheck::Status, again: false }),
    ),
];
const START_WINDOW: &[Row] =
    &[refused(When::NoTravel), refused(When::TargetBeyondLimits), go(When::StandsInWindow, Step::Travel)];
// It may be at its target already.
const RESUME: &[Row] = &[go(When::Moves, Step::Travel), go(When::TargetReached, Step::Travel)];
const TRAVEL: &[Row] = &[
    Row::new(When::Moves, Then::Stay),
    refused(When::NotArrived),
    Row::act(When::ReadyToTravel, Act::Leave, Then::Done),
    go(When::Always, Step::Settle),
];
const SETTLE: &[Row] = &[
    refused(When::NoOutputStage),
    go(When::Travels, Step::Settle),
    Row::act(When::Always, Act::Leave, Then::Done),
];
// What moves now is not the inching that is to begin.
const CHECK: &[Row] = &[
    refused(When::NoOutputStage),
    go(When::Moves, Step::Check),
    go(When::Travels, Step::Check),
    Row::act(When::Jogging, Act::Inch, Then::Go(Step::Jog)),
    Row::act(When::Always, Act::Inch, Then::Go(Step::StartInching)),
];
// So short a way that no image shows it moving counts, too.
const START_INCHING: &[Row] = &[go(When::Moved, Step::Inch), go(When::Always, Step::InchingWay)];
const INCHING_WAY: &[Row] = &[go(When::Moved, Step::Inch), Row::act(When::NoWay, Act::Leave, Then::Done)];
const JOG: &[Row] = &[Row::new(When::Jogs, Then::Done), go(When::Always, Step::Jog)];
const RANGE: &[Row] = &[refused(When::BeyondGear), go(When::Always, Step::Window)];
const WINDOW: &[Row] = &[Row::act(When::Always, Act::KeepWindow, Then::Go(Step::Release))];
const RELEASE: &[Row] =
    &[refused(When::NoOutputStage), Row::act(When::Always, Act::Turn, Then::Go(Step::Turn))];
const TURN: &[Row] = &[go(When::Stands, Step::Stalled), Row::new(When::AtSpeed, Then::Done)];
const STALLED: &[Row] = &[refused(When::NoOutputStage), go(When::Always, Step::Turn)];

/// The drive has seen the edge and has not acknowledged it, as far as it shows.
const fn start(next: Row) -> [Row; 3] {
    [refused(When::NoTravel), refused(When::TargetBeyondLimits), next]
}

const fn start_check(check: StartCheck, again: bool) -> Row {
    go(When::Always, Step::Start { check, again })
}

/// Perhaps only one of the two edges starts a job (C-32). If both do, this one would be refused too.
const SECOND_EDGE: Row =
    Row::act(When::Always, Act::Start, Then::Go(Step::Start { check: StartCheck::Status, again: true }));

impl Step {
    /// What is asked in it, its time, and what comes. Enabling and acknowledging have a course of their own.
    pub(super) const fn fork(self) -> Fork {
        const STATUS: Option<Question> = Some(Question::SystemStatus);
        match self {
            Self::Look => Fork::new(Some(Question::OperatingMode), &[]),
            Self::State(course) => match course.step() {
                Some(step) if step.until.is_empty() => Fork::new(STATUS, &[]),
                Some(_) | None => Fork::new(None, &[]),
            },
            Self::Halt => Fork::new(STATUS, HALT),
            Self::RunOut => Fork::moving(STATUS, HALT),
            Self::Lower => Fork::new(STATUS, LOWER),
            Self::Prepare => Fork::new(STATUS, PREPARE),
            Self::Start { check, again } => Fork::new(Some(check.question()), check.rows(again)),
            Self::Resume => Fork::new(STATUS, RESUME),
            Self::Travel | Self::Inch => Fork::moving(None, TRAVEL),
            Self::Settle => Fork::new(STATUS, SETTLE),
            Self::Check => Fork::new(STATUS, CHECK),
            Self::StartInching => Fork::new(STATUS, START_INCHING),
            Self::InchingWay => Fork::new(Some(Question::DeltaInch), INCHING_WAY),
            Self::Jog => Fork::new(STATUS, JOG),
            Self::Range => Fork::new(Some(Question::HardwareVersion), RANGE),
            Self::Window => Fork::new(Some(Question::Window), WINDOW),
            Self::Release => Fork::new(STATUS, RELEASE),
            Self::Turn => Fork::moving(None, TURN),
            Self::Stalled => Fork::moving(STATUS, STALLED),
        }
    }

    /// Whether a level of STW has been set to turn the shaft, which need not turn yet.
    pub(super) const fn begins_turning(self) -> bool {
        matches!(self, Self::Jog | Self::Turn | Self::Stalled)
    }
}

impl StartCheck {
    const fn question(self) -> Question {
        match self {
            Self::Status => Question::SystemStatus,
            Self::Limit1 => Question::Limit1,
            Self::Limit2 => Question::Limit2,
            Self::Window => Question::Window,
        }
    }

    const fn rows(self, again: bool) -> &'static [Row] {
        match (self, again) {
            (Self::Status, false) => const { &start(start_check(Self::Limit1, false)) },
            (Self::Status, true) => const { &start(start_check(Self::Limit1, true)) },
            (Self::Limit1, false) => const { &start(start_check(Self::Limit2, false)) },
            (Self::Limit1, true) => const { &start(start_check(Self::Limit2, true)) },
            (Self::Limit2, false) => const { &start(SECOND_EDGE) },
            (Self::Limit2, true) => const { &start(start_check(Self::Window, true)) },
            (Self::Window, _) => START_WINDOW,
        }
    }
}
