//! The steps to each goal, and what ends each step.
//!
//! | goal | steps |
//! | --- | --- |
//! | enable | look, (raise OFF1, lower OFF1,) enable |
//! | acknowledge | look, drop, acknowledge, raise OFF1, lower OFF1 |
//! | move to | look, prepare, start, travel |
//! | pause, stop, disable | look, halt |
//! | resume | look, resume, travel |
//! | inch | look, check, start inching, inch |
//! | jog | look, check, jog |
//! | velocity | look, range, window, turn |

use super::goal::Goal;
use super::obstacle::{Findings, Obstacle, Obstacles};
use super::posture::Posture;
use super::question::Question;
use super::zsw::{ZswPattern, bit};
use super::{DriveClient, Instant};
use crate::drive::Mode;
use crate::ppo::Zsw;

/// A goal under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pursuit {
    pub(super) goal: Goal,
    pub(super) step: Step,
    /// What is asked in this step; the step goes on when it is answered.
    pub(super) question: Option<Question>,
    /// The answer.
    pub(super) answer: Option<u32>,
    pub(super) findings: Findings,
    pub(super) deadline: Instant,
}

/// Where a goal stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The drive is asked for its operating mode and so shows that it sees the outputs.
    Look,
    /// STW without enable, before the acknowledge.
    Drop,
    /// STW.7 until ZSW.3 goes.
    Acknowledge,
    /// STW.0 = 1, so that it can fall.
    RaiseOff1,
    /// STW.0 = 0 until ZSW.6 goes.
    LowerOff1,
    /// 000B until operation is enabled.
    Enable,
    /// Until the drive stands.
    Halt,
    /// 003B with the target, until the drive is ready to travel.
    Prepare,
    /// The edge of STW.6, until it is acknowledged. ZSW.12 was so before.
    Start { acknowledge: bool },
    /// STW.5 until the job goes on.
    Resume,
    /// Until the travel job ends.
    Travel,
    /// Whether inching is possible.
    Check,
    /// STW.8 until the drive moves.
    StartInching { from: i32 },
    /// Until inching 1 ends.
    Inch,
    /// STW.9 until the drive turns.
    Jog,
    /// The gear, for the largest velocity.
    Range,
    /// The velocity window.
    Window,
    /// STW.6 until the velocity is reached.
    Turn { window: u32 },
}

/// What an image or an answer makes of a step.
pub(super) enum Next {
    Stay,
    Step(Step),
    Done,
    /// By what the drive shows.
    Refused,
}

impl Pursuit {
    pub(super) fn new(goal: Goal, deadline: Instant) -> Self {
        let step = Step::Look;
        Self { goal, step, question: step.question(), answer: None, findings: Findings::default(), deadline }
    }
}

impl Step {
    pub(super) const fn question(self) -> Option<Question> {
        match self {
            Self::Look => Some(Question::OperatingMode),
            Self::Drop
            | Self::RaiseOff1
            | Self::Prepare
            | Self::Check
            | Self::StartInching { .. }
            | Self::Jog => Some(Question::SystemStatus),
            Self::Range => Some(Question::HardwareVersion),
            Self::Window => Some(Question::Window),
            Self::Acknowledge
            | Self::LowerOff1
            | Self::Enable
            | Self::Halt
            | Self::Start { .. }
            | Self::Resume
            | Self::Travel
            | Self::Inch
            | Self::Turn { .. } => None,
        }
    }

    pub(super) const fn is_motion(self) -> bool {
        match self {
            Self::Travel | Self::Inch | Self::Turn { .. } => true,
            Self::Look
            | Self::Drop
            | Self::Acknowledge
            | Self::RaiseOff1
            | Self::LowerOff1
            | Self::Enable
            | Self::Halt
            | Self::Prepare
            | Self::Start { .. }
            | Self::Resume
            | Self::Check
            | Self::StartInching { .. }
            | Self::Jog
            | Self::Range
            | Self::Window => false,
        }
    }
}

impl DriveClient {
    /// What the newest status word makes of the step. Sets the control word of the step that follows.
    pub(super) fn advance(&mut self, pursuit: &Pursuit) -> Next {
        let Some(zsw) = self.zsw else {
            return Next::Stay;
        };
        let goal = pursuit.goal;
        // Whatever is asked, a drive with a fault only takes the acknowledge. ZSW.3 cannot be an old one: the
        // acknowledge before it ended with ZSW.3 = 0.
        if zsw.bit(bit::FAULT) && goal != Goal::Acknowledge {
            return Next::Refused;
        }
        if pursuit.question.is_some() {
            return Next::Stay;
        }
        let mode = pursuit.findings.mode;
        match pursuit.step {
            Step::Look => self.begin(goal, mode, zsw),
            Step::Drop => {
                self.posture = Posture::Acknowledging;
                Next::Step(Step::Acknowledge)
            }
            Step::Acknowledge if zsw.bit(bit::FAULT) => Next::Stay,
            Step::Acknowledge => {
                self.posture = Posture::Disabled;
                Next::Step(Step::RaiseOff1)
            }
            Step::RaiseOff1 => {
                self.posture = Posture::Off1;
                Next::Step(Step::LowerOff1)
            }
            Step::LowerOff1 if zsw.bit(bit::TURN_ON_DISABLED) => Next::Stay,
            Step::LowerOff1 if goal == Goal::Enable => {
                self.posture = Posture::Enabled;
                Next::Step(Step::Enable)
            }
            Step::LowerOff1 => {
                self.posture = Posture::Off;
                Next::Done
            }
            Step::Enable => {
                done_if(mode.is_some_and(|mode| ZswPattern::operation_enabled(mode).matches(zsw)))
            }
            Step::Halt => self.halted(goal, mode, zsw),
            Step::Prepare if ZswPattern::ready_to_travel(Mode::Positioning).matches(zsw) => {
                self.start = !self.start;
                Next::Step(Step::Start { acknowledge: zsw.bit(bit::JOB_ACKNOWLEDGE) })
            }
            Step::Prepare => Next::Stay,
            Step::Start { acknowledge }
                if zsw.bit(bit::JOB_ACKNOWLEDGE) != acknowledge || ZswPattern::TRAVEL_JOB.matches(zsw) =>
            {
                self.job = true;
                Next::Step(Step::Travel)
            }
            Step::Start { .. } => Next::Stay,
            // It may be at its target already.
            Step::Resume if !zsw.bit(bit::STANDSTILL) || zsw.bit(bit::TARGET_REACHED) => {
                Next::Step(Step::Travel)
            }
            Step::Resume => Next::Stay,
            Step::Travel | Step::Inch if !zsw.bit(bit::STANDSTILL) => Next::Stay,
            Step::Travel if zsw.bit(bit::TARGET_REACHED) && zsw.bit(bit::OPERATION_ENABLED) => {
                self.job = false;
                Next::Done
            }
            Step::Travel => Next::Refused,
            Step::Check if Obstacles::of(goal, pursuit.findings).contains(Obstacle::NoOutputStage) => {
                Next::Refused
            }
            // What moves now is not the inching that is to begin.
            Step::Check if !zsw.bit(bit::STANDSTILL) => Next::Stay,
            Step::Check => self.begin_inching(goal),
            Step::StartInching { .. } if !zsw.bit(bit::STANDSTILL) => Next::Step(Step::Inch),
            // So short that no image shows it moving.
            Step::StartInching { from } if self.hiw != from => Next::Step(Step::Inch),
            Step::StartInching { .. } => Next::Stay,
            Step::Inch if zsw.bit(bit::TARGET_REACHED) => {
                self.posture = Posture::Enabled;
                Next::Done
            }
            Step::Inch => Next::Refused,
            Step::Jog => done_if(ZswPattern::INCHING.matches(zsw)),
            Step::Range if Obstacles::of(goal, pursuit.findings).contains(Obstacle::BeyondGear) => {
                Next::Refused
            }
            Step::Range => Next::Step(Step::Window),
            Step::Window => {
                self.posture = Posture::Turn;
                self.setpoint = goal.rpm().unwrap_or(0);
                Next::Step(Step::Turn { window: pursuit.answer.unwrap_or(0) })
            }
            Step::Turn { window } => {
                let near = goal.rpm().is_some_and(|rpm| rpm.abs_diff(self.hiw) <= window);
                done_if(near && zsw.bit(bit::NO_LAG_OR_AT_SPEED) && !zsw.bit(bit::READY_TO_TRAVEL))
            }
        }
    }

    /// After the look: the first control word of the goal.
    fn begin(&mut self, goal: Goal, mode: Option<Mode>, zsw: Zsw) -> Next {
        if mode == Some(Mode::Velocity) {
            // An edge rests there no longer.
            self.start = false;
        }
        if goal.mode().is_some() && goal.mode() != mode {
            return Next::Refused;
        }
        if goal.moves() && !(self.posture.enables() && zsw.bit(bit::OPERATION_ENABLED)) {
            return Next::Refused;
        }
        match goal {
            Goal::Enable if zsw.bit(bit::TURN_ON_DISABLED) => {
                self.adopt(Posture::Disabled);
                Next::Step(Step::RaiseOff1)
            }
            // What it does at the moment goes on.
            Goal::Enable if self.posture.enables() && zsw.bit(bit::OPERATION_ENABLED) => Next::Done,
            Goal::Enable => {
                self.adopt(Posture::Enabled);
                Next::Step(Step::Enable)
            }
            Goal::Acknowledge if zsw.bit(bit::FAULT) => {
                self.adopt(Posture::Disabled);
                Next::Step(Step::Drop)
            }
            Goal::Acknowledge if zsw.bit(bit::TURN_ON_DISABLED) => {
                self.adopt(Posture::Disabled);
                Next::Step(Step::RaiseOff1)
            }
            Goal::Acknowledge => Next::Done,
            Goal::MoveTo(target) => {
                self.posture = Posture::Travel;
                self.setpoint = target;
                Next::Step(Step::Prepare)
            }
            Goal::Pause if self.job => Next::Step(Step::Halt),
            Goal::Resume if self.job => Next::Step(Step::Resume),
            Goal::Pause | Goal::Resume => Next::Refused,
            Goal::Stop | Goal::Disable => Next::Step(Step::Halt),
            Goal::Inch | Goal::Jog(_) => Next::Step(Step::Check),
            Goal::Velocity(_) => Next::Step(Step::Range),
        }
    }

    fn begin_inching(&mut self, goal: Goal) -> Next {
        let (posture, step) = match goal {
            Goal::Jog(direction) => (Posture::Jog(direction), Step::Jog),
            Goal::Inch
            | Goal::Enable
            | Goal::Acknowledge
            | Goal::MoveTo(_)
            | Goal::Pause
            | Goal::Resume
            | Goal::Stop
            | Goal::Velocity(_)
            | Goal::Disable => (Posture::Inch, Step::StartInching { from: self.hiw }),
        };
        self.posture = posture;
        Next::Step(step)
    }

    /// Whether the drive stands as the goal wants it.
    fn halted(&self, goal: Goal, mode: Option<Mode>, zsw: Zsw) -> Next {
        let is = |pattern: fn(Mode) -> ZswPattern| mode.is_some_and(|mode| pattern(mode).matches(zsw));
        done_if(match goal {
            // Without supply, or with turning on disabled, the drive is not ready-to-run and yet disabled.
            Goal::Disable => {
                let off = zsw.bit(bit::TURN_ON_DISABLED) || !zsw.bit(bit::READY);
                is(ZswPattern::ready_to_run) || off && !zsw.bit(bit::OPERATION_ENABLED)
            }
            Goal::Stop if self.posture.enables() => is(ZswPattern::operation_enabled),
            Goal::Stop
            | Goal::Pause
            | Goal::Enable
            | Goal::Acknowledge
            | Goal::MoveTo(_)
            | Goal::Resume
            | Goal::Inch
            | Goal::Jog(_)
            | Goal::Velocity(_) => zsw.bit(bit::STANDSTILL),
        })
    }
}

impl Obstacles {
    pub(super) const fn of(goal: Goal, findings: Findings) -> Self {
        Self { goal, waited: None, findings }
    }

    /// What to ask next to find out why the goal was not reached.
    pub(super) fn question_after(&self, question: Option<Question>) -> Option<Question> {
        const ALL: [Question; 6] = [
            Question::SystemStatus,
            Question::GeneralStatus,
            Question::NewestFault,
            Question::Limit1,
            Question::Limit2,
            Question::PosType,
        ];
        // Without Data_Exchange nobody would answer.
        let zsw = self.findings.zsw?;
        let asked = question.and_then(|question| ALL.iter().position(|other| *other == question));
        let rest = ALL.into_iter().skip(asked.map_or(0, |index| index + 1));
        rest.into_iter().find(|question| match question {
            Question::SystemStatus | Question::GeneralStatus => true,
            Question::NewestFault => zsw.bit(bit::FAULT),
            Question::Limit1 | Question::Limit2 | Question::PosType => self.goal.target().is_some(),
            Question::OperatingMode | Question::HardwareVersion | Question::Window => false,
        })
    }
}

const fn done_if(done: bool) -> Next {
    if done { Next::Done } else { Next::Stay }
}
