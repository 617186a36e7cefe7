//! The steps to each goal, and what ends each step.
//!
//! | goal | steps |
//! | --- | --- |
//! | enable | look, (raise OFF1, lower OFF1,) enable |
//! | acknowledge | look, drop, acknowledge, raise OFF1, lower OFF1 |
//! | move to | look, (lower,) prepare, start, travel (, settle) |
//! | pause, stop, disable | look, halt (, run out) |
//! | resume | look, resume, travel (, settle) |
//! | inch | look, check, start inching (, inching way), inch (, settle) |
//! | jog | look, check, jog |
//! | velocity | look, range, window, release, turn (, stalled) |

use super::goal::Goal;
use super::job::{Doubt, TravelJob};
use super::obstacle::{Findings, Obstacle, Obstacles};
use super::posture::Posture;
use super::question::Question;
use super::zsw::ZswPattern;
use super::{DriveClient, Instant};
use crate::device::bits::ZswBit;
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
    /// No image by then: there is no Data_Exchange.
    pub(super) silence: Instant,
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
    /// As long as the shaft turns on the way there.
    RunOut,
    /// 000B after 004B, so that STW.6 falls where it starts nothing in either mode.
    Lower,
    /// 003B with the target, until the drive is ready to travel.
    Prepare,
    /// The edge of STW.6, until it is acknowledged; `again`: the second one.
    Start { doubt: Doubt, again: bool },
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

impl Pursuit {
    pub(super) fn new(goal: Goal, deadline: Instant) -> Self {
        let step = Step::Look;
        let question = step.question();
        Self {
            goal,
            step,
            question,
            answer: None,
            findings: Findings::default(),
            deadline,
            silence: deadline,
        }
    }
}

impl Step {
    pub(super) const fn question(self) -> Option<Question> {
        match self {
            Self::Look => Some(Question::OperatingMode),
            Self::Drop
            | Self::RaiseOff1
            | Self::Halt
            | Self::RunOut
            | Self::Lower
            | Self::Prepare
            | Self::Resume
            | Self::Settle
            | Self::Check
            | Self::StartInching { .. }
            | Self::Jog { .. }
            | Self::Release { .. }
            | Self::Stalled { .. } => Some(Question::SystemStatus),
            Self::Start { doubt, .. } => Some(doubt.question()),
            Self::InchingWay { .. } => Some(Question::DeltaInch),
            Self::Range => Some(Question::HardwareVersion),
            Self::Window => Some(Question::Window),
            Self::Acknowledge
            | Self::LowerOff1
            | Self::Enable
            | Self::Travel
            | Self::Inch
            | Self::Turn { .. } => None,
        }
    }

    /// Whether it has the time of a motion.
    pub(super) const fn is_motion(self) -> bool {
        match self {
            Self::RunOut | Self::Travel | Self::Inch | Self::Turn { .. } | Self::Stalled { .. } => true,
            Self::Look
            | Self::Drop
            | Self::Acknowledge
            | Self::RaiseOff1
            | Self::LowerOff1
            | Self::Enable
            | Self::Halt
            | Self::Lower
            | Self::Prepare
            | Self::Start { .. }
            | Self::Resume
            | Self::Settle
            | Self::Check
            | Self::StartInching { .. }
            | Self::InchingWay { .. }
            | Self::Jog { .. }
            | Self::Range
            | Self::Window
            | Self::Release { .. } => false,
        }
    }

    /// Whether a level of STW has been set to turn the shaft, which need not turn yet.
    pub(super) const fn begins_turning(self) -> bool {
        match self {
            Self::Jog { .. } | Self::Turn { .. } | Self::Stalled { .. } => true,
            Self::Look
            | Self::Drop
            | Self::Acknowledge
            | Self::RaiseOff1
            | Self::LowerOff1
            | Self::Enable
            | Self::Halt
            | Self::RunOut
            | Self::Lower
            | Self::Prepare
            | Self::Start { .. }
            | Self::Resume
            | Self::Travel
            | Self::Settle
            | Self::Check
            | Self::StartInching { .. }
            | Self::InchingWay { .. }
            | Self::Inch
            | Self::Range
            | Self::Window
            | Self::Release { .. } => false,
        }
    }
}

impl DriveClient {
    /// What the newest status word makes of the step. Sets the control word of the step that follows.
    pub(super) fn advance(&mut self, now: Instant, pursuit: &Pursuit) -> Next {
        let Some(zsw) = self.zsw else {
            return Next::Stay;
        };
        let goal = pursuit.goal;
        // Whatever else is asked, a drive with a fault only takes the acknowledge. ZSW.3 cannot be an old one: the
        // acknowledge before it ended with ZSW.3 = 0.
        if ZswBit::Fault.is_set(zsw) && !matches!(goal, Goal::Acknowledge | Goal::Stop | Goal::Disable) {
            return Next::Refused;
        }
        // Operation was enabled when the goal began.
        let begun = pursuit.step != Step::Look;
        if begun
            && goal.moves()
            && !(ZswBit::OperationEnabled.is_set(zsw) && ZswBit::ReadyToTurnOn.is_set(zsw))
        {
            return Next::Refused;
        }
        if matches!(pursuit.step, Step::Start { .. }) && self.job == TravelJob::Active {
            return Next::Step(Step::Travel);
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
            Step::Acknowledge if ZswBit::Fault.is_set(zsw) => Next::Stay,
            Step::Acknowledge => {
                self.posture = Posture::Disabled;
                Next::Step(Step::RaiseOff1)
            }
            Step::RaiseOff1 => {
                self.posture = Posture::Off1;
                Next::Step(Step::LowerOff1)
            }
            Step::LowerOff1 if ZswBit::TurnOnDisabled.is_set(zsw) => Next::Stay,
            Step::LowerOff1 if goal == Goal::Enable => {
                self.posture = Posture::Enabled;
                Next::Step(Step::Enable)
            }
            Step::LowerOff1 => {
                self.posture = Posture::Off;
                Next::Done
            }
            Step::Enable => {
                done_if(mode.is_some_and(|mode| ZswPattern::operation_enabled(mode).is_met(mode, zsw)))
            }
            Step::Halt | Step::RunOut => self.halted(now, pursuit, zsw),
            Step::Lower => self.prepare(goal),
            Step::Prepare => self.prepared(pursuit, zsw),
            Step::Start { doubt, again } => self.doubt_start(pursuit, doubt, again, zsw),
            // It may be at its target already.
            Step::Resume if !ZswBit::Standstill.is_set(zsw) || ZswBit::TargetReached.is_set(zsw) => {
                Next::Step(Step::Travel)
            }
            Step::Resume => Next::Stay,
            Step::Travel | Step::Inch if !ZswBit::Standstill.is_set(zsw) => Next::Stay,
            Step::Travel | Step::Inch => self.arrived(zsw),
            Step::Settle if self.lacks_output_stage(pursuit) => Next::Refused,
            Step::Settle if pursuit.findings.travels() => Next::Step(Step::Settle),
            Step::Settle => self.leave(),
            Step::Check if self.lacks_output_stage(pursuit) => Next::Refused,
            // What moves now is not the inching that is to begin.
            Step::Check if !ZswBit::Standstill.is_set(zsw) || pursuit.findings.travels() => {
                Next::Step(Step::Check)
            }
            Step::Check => self.begin_inching(goal),
            Step::StartInching { from } | Step::InchingWay { from }
                // The second: so short that no image shows it moving.
                if !ZswBit::Standstill.is_set(zsw) || self.hiw != from =>
            {
                Next::Step(Step::Inch)
            }
            Step::StartInching { from } => Next::Step(Step::InchingWay { from }),
            Step::InchingWay { .. } if pursuit.answer == Some(0) => self.leave(),
            Step::InchingWay { .. } => Next::Stay,
            Step::Jog { from } => {
                let turns = pursuit.findings.travels() || self.hiw != from;
                if turns && ZswPattern::INCHING.matches(zsw) {
                    Next::Done
                } else {
                    Next::Step(Step::Jog { from })
                }
            }
            Step::Range if Obstacles::of(goal, pursuit.findings).contains(Obstacle::BeyondGear) => {
                Next::Refused
            }
            Step::Range => Next::Step(Step::Window),
            Step::Window => Next::Step(Step::Release { window: pursuit.answer.unwrap_or(0) }),
            Step::Release { .. } | Step::Stalled { .. } if self.lacks_output_stage(pursuit) => Next::Refused,
            Step::Release { window } => {
                self.posture = Posture::Turn;
                self.setpoint = goal.rpm().unwrap_or(0);
                Next::Step(Step::Turn { window })
            }
            Step::Turn { window } => self.turned(goal.rpm().unwrap_or(0), window, zsw),
            Step::Stalled { window } => Next::Step(Step::Turn { window }),
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
        if goal.moves() && !(self.posture.enables() && ZswBit::OperationEnabled.is_set(zsw)) {
            return Next::Refused;
        }
        match goal {
            Goal::Enable if ZswBit::TurnOnDisabled.is_set(zsw) => {
                self.adopt(Posture::Disabled);
                Next::Step(Step::RaiseOff1)
            }
            // What it does at the moment goes on.
            Goal::Enable if self.posture.enables() && ZswBit::OperationEnabled.is_set(zsw) => Next::Done,
            Goal::Enable => {
                self.adopt(Posture::Enabled);
                Next::Step(Step::Enable)
            }
            Goal::Acknowledge if ZswBit::Fault.is_set(zsw) => {
                self.adopt(Posture::Disabled);
                Next::Step(Step::Drop)
            }
            Goal::Acknowledge if ZswBit::TurnOnDisabled.is_set(zsw) => {
                self.adopt(Posture::Disabled);
                Next::Step(Step::RaiseOff1)
            }
            Goal::Acknowledge => Next::Done,
            Goal::MoveTo(_) if self.posture == Posture::Turn => {
                self.halt();
                Next::Step(Step::Lower)
            }
            Goal::MoveTo(_) => self.prepare(goal),
            Goal::Pause if self.job.is_possible() => Next::Step(Step::Halt),
            Goal::Resume if self.job.is_possible() => Next::Step(Step::Resume),
            Goal::Pause | Goal::Resume => Next::Refused,
            Goal::Stop | Goal::Disable => Next::Step(Step::Halt),
            Goal::Inch | Goal::Jog(_) => Next::Step(Step::Check),
            Goal::Velocity(_) => Next::Step(Step::Range),
        }
    }

    fn begin_inching(&mut self, goal: Goal) -> Next {
        let (posture, step) = match goal {
            Goal::Jog(direction) => (Posture::Jog(direction), Step::Jog { from: self.hiw }),
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

    fn prepare(&mut self, goal: Goal) -> Next {
        self.posture = Posture::Travel;
        self.setpoint = goal.target().unwrap_or(self.setpoint);
        Next::Step(Step::Prepare)
    }

    fn lacks_output_stage(&self, pursuit: &Pursuit) -> bool {
        Obstacles::of(pursuit.goal, pursuit.findings).contains(Obstacle::NoOutputStage)
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
            Question::NewestFault => ZswBit::Fault.is_set(zsw),
            Question::Limit1 | Question::Limit2 | Question::PosType => self.goal.target().is_some(),
            Question::OperatingMode | Question::HardwareVersion | Question::Window | Question::DeltaInch => {
                false
            }
        })
    }
}

pub(super) const fn done_if(done: bool) -> Next {
    if done { Next::Done } else { Next::Stay }
}
