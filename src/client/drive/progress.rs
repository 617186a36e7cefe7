//! The steps to each goal, and what ends each step.
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

use super::commanded::Commanded;
use super::control_word::ControlWord;
use super::course::{acknowledging, enabling};
use super::goal::Goal;
use super::job::TravelJob;
use super::obstacle::{Findings, Obstacle, Obstacles};
use super::question::Question;
use super::seen::Seen;
use super::standstill::{arrived, leave, turned};
use super::step::{Next, Step};
use super::zsw::ZswPattern;
use crate::client::course::{Course, Shown};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::profibus::ppo::Zsw;
use crate::time::Instant;

/// A goal under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct GoalProgress {
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

impl GoalProgress {
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

impl GoalProgress {
    /// What the newest status word makes of the step. Sets the control word of the step that follows.
    pub(super) fn advance(&self, now: Instant, commanded: &mut Commanded, seen: &Seen) -> Next {
        let Some(zsw) = seen.zsw else {
            return Next::Stay;
        };
        let goal = self.goal;
        // Whatever else is asked, a drive with a fault only takes the acknowledge. ZSW.3 cannot be an old one: the
        // acknowledge before it ended with ZSW.3 = 0.
        if ZswBit::Fault.is_set(zsw) && !matches!(goal, Goal::Acknowledge | Goal::Stop | Goal::Disable) {
            return Next::Refused;
        }
        // Operation was enabled when the goal began.
        let begun = self.step != Step::Look;
        if begun
            && goal.moves()
            && !(ZswBit::OperationEnabled.is_set(zsw) && ZswBit::ReadyToTurnOn.is_set(zsw))
        {
            return Next::Refused;
        }
        if matches!(self.step, Step::Start { .. }) && commanded.job == TravelJob::Active {
            return Next::Step(Step::Travel);
        }
        if self.question.is_some() {
            return Next::Stay;
        }
        match self.step {
            Step::Look => self.begin(commanded, zsw),
            Step::State(course) => self.change_state(commanded, course, zsw),
            Step::Halt | Step::RunOut => self.halted(now, commanded, seen, zsw),
            Step::Lower => self.prepare(commanded),
            Step::Prepare => self.start_when_ready(commanded, zsw),
            Step::Start { check, again } => self.check_start(commanded, seen, check, again, zsw),
            // It may be at its target already.
            Step::Resume if !ZswBit::Standstill.is_set(zsw) || ZswBit::TargetReached.is_set(zsw) => {
                Next::Step(Step::Travel)
            }
            Step::Resume => Next::Stay,
            Step::Travel | Step::Inch if !ZswBit::Standstill.is_set(zsw) => Next::Stay,
            Step::Travel | Step::Inch => arrived(commanded, zsw),
            Step::Settle if self.lacks_output_stage() => Next::Refused,
            Step::Settle if self.findings.travels() => Next::Step(Step::Settle),
            Step::Settle => leave(commanded),
            Step::Check if self.lacks_output_stage() => Next::Refused,
            // What moves now is not the inching that is to begin.
            Step::Check if !ZswBit::Standstill.is_set(zsw) || self.findings.travels() => {
                Next::Step(Step::Check)
            }
            Step::Check => self.begin_inching(commanded, seen.hiw),
            Step::StartInching { from } | Step::InchingWay { from }
                // The second: so short that no image shows it moving.
                if !ZswBit::Standstill.is_set(zsw) || seen.hiw != from =>
            {
                Next::Step(Step::Inch)
            }
            Step::StartInching { from } => Next::Step(Step::InchingWay { from }),
            Step::InchingWay { .. } if self.answer == Some(0) => leave(commanded),
            Step::InchingWay { .. } => Next::Stay,
            Step::Jog { from } => {
                let turns = self.findings.travels() || seen.hiw != from;
                if turns && ZswPattern::INCHING.matches(zsw) {
                    Next::Done
                } else {
                    Next::Step(Step::Jog { from })
                }
            }
            Step::Range if self.obstacles().contains(Obstacle::BeyondGear) => {
                Next::Refused
            }
            Step::Range => Next::Step(Step::Window),
            Step::Window => Next::Step(Step::Release { window: self.answer.unwrap_or(0) }),
            Step::Release { .. } | Step::Stalled { .. } if self.lacks_output_stage() => Next::Refused,
            Step::Release { window } => {
                commanded.word = ControlWord::Turn;
                commanded.setpoint = goal.rpm().unwrap_or(0);
                Next::Step(Step::Turn { window })
            }
            Step::Turn { window } => turned(seen, goal.rpm().unwrap_or(0), window, zsw),
            Step::Stalled { window } => Next::Step(Step::Turn { window }),
        }
    }

    /// After the look: the first control word of the goal.
    fn begin(&self, commanded: &mut Commanded, zsw: Zsw) -> Next {
        let Self { goal, findings: Findings { mode, .. }, .. } = *self;
        if mode == Some(Mode::Velocity) {
            // An edge rests there no longer.
            commanded.start = false;
        }
        if goal.mode().is_some() && goal.mode() != mode {
            return Next::Refused;
        }
        if goal.moves() && !(commanded.word.enables() && ZswBit::OperationEnabled.is_set(zsw)) {
            return Next::Refused;
        }
        let (fault, inhibited) = (ZswBit::Fault.is_set(zsw), ZswBit::TurnOnDisabled.is_set(zsw));
        match goal {
            // What it does at the moment goes on.
            Goal::Enable
                if !inhibited && commanded.word.enables() && ZswBit::OperationEnabled.is_set(zsw) =>
            {
                Next::Done
            }
            Goal::Enable => change(commanded, enabling(mode.unwrap_or(Mode::Positioning), inhibited)),
            Goal::Acknowledge if fault || inhibited => change(commanded, acknowledging(fault)),
            Goal::Acknowledge => Next::Done,
            Goal::MoveTo(_) if commanded.word == ControlWord::Turn => {
                commanded.halt();
                Next::Step(Step::Lower)
            }
            Goal::MoveTo(_) => self.prepare(commanded),
            Goal::Pause if commanded.job.is_possible() => Next::Step(Step::Halt),
            Goal::Resume if commanded.job.is_possible() => Next::Step(Step::Resume),
            Goal::Pause | Goal::Resume => Next::Refused,
            Goal::Stop | Goal::Disable => Next::Step(Step::Halt),
            Goal::Inch | Goal::Jog(_) => Next::Step(Step::Check),
            Goal::Velocity(_) => Next::Step(Step::Range),
        }
    }

    /// Goes through the words that change the state.
    fn change_state(&self, commanded: &mut Commanded, course: Course<ControlWord, ()>, zsw: Zsw) -> Next {
        if course.step().is_some_and(|step| step.shown(zsw.raw()) == Shown::Wait) {
            return Next::Stay;
        }
        let course = course.next();
        match course.step() {
            Some(step) => {
                commanded.word = step.act;
                Next::Step(Step::State(course))
            }
            None => {
                if self.goal == Goal::Acknowledge {
                    commanded.word = ControlWord::Off;
                }
                Next::Done
            }
        }
    }

    fn begin_inching(&self, commanded: &mut Commanded, from: i32) -> Next {
        let (word, step) = match self.goal {
            Goal::Jog(direction) => (ControlWord::Jog(direction), Step::Jog { from }),
            Goal::Inch
            | Goal::Enable
            | Goal::Acknowledge
            | Goal::MoveTo(_)
            | Goal::Pause
            | Goal::Resume
            | Goal::Stop
            | Goal::Velocity(_)
            | Goal::Disable => (ControlWord::Inch, Step::StartInching { from }),
        };
        commanded.word = word;
        Next::Step(step)
    }

    fn prepare(&self, commanded: &mut Commanded) -> Next {
        commanded.word = ControlWord::Travel;
        commanded.setpoint = self.goal.target().unwrap_or(commanded.setpoint);
        Next::Step(Step::Prepare)
    }

    fn lacks_output_stage(&self) -> bool {
        self.obstacles().contains(Obstacle::NoOutputStage)
    }

    pub(super) const fn obstacles(&self) -> Obstacles {
        Obstacles::of(self.goal, self.findings)
    }
}

/// The first word of a change of state.
fn change(commanded: &mut Commanded, course: Course<ControlWord, ()>) -> Next {
    if let Some(step) = course.step() {
        commanded.end_job_with(step.act);
    }
    Next::Step(Step::State(course))
}
