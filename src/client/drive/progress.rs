//! A goal under way: what ends each of its steps, and what is commanded between them.

use super::commanded::Commanded;
use super::control_word::ControlWord;
use super::course::{acknowledging, enabling};
use super::goal::Goal;
use super::job::{TravelJob, stands_at_target};
use super::obstacle::{Findings, Obstacle, Obstacles};
use super::question::Question;
use super::seen::Seen;
use super::standstill::{is_at_speed, is_halted};
use super::step::{Act, Step, When};
use crate::client::course::{Course, Shown, Then};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::devices::ag03::profibus::flow_charts;
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
    /// HIW where inching began.
    from: i32,
    /// The velocity window.
    window: u32,
}

impl GoalProgress {
    pub(super) fn new(goal: Goal, deadline: Instant) -> Self {
        let step = Step::Look;
        Self {
            goal,
            step,
            question: step.fork().ask,
            answer: None,
            findings: Findings::default(),
            deadline,
            silence: deadline,
            from: 0,
            window: 0,
        }
    }
}

impl GoalProgress {
    /// What the newest status word makes of the step. Sets the control word of the step that follows.
    pub(super) fn advance(&mut self, now: Instant, commanded: &mut Commanded, seen: &Seen) -> Then<Step> {
        let Some(zsw) = seen.zsw else {
            return Then::Stay;
        };
        let goal = self.goal;
        // Whatever else is asked, a drive with a fault only takes the acknowledge. ZSW.3 cannot be an old one: the
        // acknowledge before it ended with ZSW.3 = 0.
        if ZswBit::Fault.is_set(zsw) && !matches!(goal, Goal::Acknowledge | Goal::Stop | Goal::Disable) {
            return Then::Refused;
        }
        // Operation was enabled when the goal began.
        let begun = self.step != Step::Look;
        if begun
            && goal.moves()
            && !(ZswBit::OperationEnabled.is_set(zsw) && ZswBit::ReadyToTurnOn.is_set(zsw))
        {
            return Then::Refused;
        }
        if matches!(self.step, Step::Start { .. }) && commanded.job == TravelJob::Active {
            return Then::Go(Step::Travel);
        }
        if self.question.is_some() {
            return Then::Stay;
        }
        if self.step == Step::Look {
            return self.begin(commanded, zsw);
        }
        if let Step::State(course) = self.step {
            return self.change_state(commanded, course, zsw);
        }
        let fork = self.step.fork();
        let Some(row) = fork.row(|when| self.holds(when, now, commanded, seen, zsw)) else {
            return Then::Stay;
        };
        if let Some(act) = row.act {
            self.act(act, commanded, seen, zsw);
        }
        row.then
    }

    fn holds(&self, when: When, now: Instant, commanded: &Commanded, seen: &Seen, zsw: Zsw) -> bool {
        let Self { goal, ref findings, .. } = *self;
        let blocked_by = |obstacle| self.obstacles().contains(obstacle);
        let moves = !ZswBit::Standstill.is_set(zsw);
        match when {
            When::Always => true,
            When::Moves => moves,
            When::Travels => findings.travels(),
            When::Moved => moves || seen.hiw != self.from,
            When::NotHalted => !(seen.rests(now) && is_halted(goal, findings.mode, zsw)),
            // It stands at its target: it ended before the pause was seen.
            When::Paused => {
                goal == Goal::Pause && commanded.job == TravelJob::Active && !stands_at_target(zsw)
            }
            When::Pausing => goal == Goal::Pause,
            When::NoOutputStage => blocked_by(Obstacle::NoOutputStage),
            When::NoTravel => self.obstacles().rule_out_travel(),
            When::TargetBeyondLimits => blocked_by(Obstacle::TargetBeyondLimits),
            When::LimitExceeded => ZswBit::LimitExceeded.is_set(zsw),
            When::ReadyToStart => flow_charts::ready_to_travel(Mode::Positioning).matches(zsw),
            When::StandsInWindow => {
                let away = goal.target().map(|target| target.abs_diff(seen.hiw));
                let arrived = away.zip(self.answer).is_some_and(|(away, window)| away <= window);
                arrived && stands_at_target(zsw)
            }
            When::TargetReached => ZswBit::TargetReached.is_set(zsw),
            When::NotArrived => !(ZswBit::TargetReached.is_set(zsw) && ZswBit::OperationEnabled.is_set(zsw)),
            When::ReadyToTravel => ZswBit::ReadyToTravel.is_set(zsw),
            When::Jogging => matches!(goal, Goal::Jog(_)),
            When::Jogs => (findings.travels() || seen.hiw != self.from) && flow_charts::INCHES.matches(zsw),
            When::NoWay => self.answer == Some(0),
            When::BeyondGear => blocked_by(Obstacle::BeyondGear),
            When::Stands => !moves && goal.rpm().is_some_and(|rpm| rpm != 0),
            When::AtSpeed => is_at_speed(seen, goal.rpm().unwrap_or(0), self.window, zsw),
        }
    }

    fn act(&mut self, act: Act, commanded: &mut Commanded, seen: &Seen, zsw: Zsw) {
        match act {
            Act::Prepare => {
                commanded.word = ControlWord::Travel;
                commanded.setpoint = self.goal.target().unwrap_or(commanded.setpoint);
            }
            // An edge starts a job (row 20).
            Act::Start => {
                commanded.start = !commanded.start;
                commanded.job = TravelJob::Asked { acknowledge: ZswBit::JobToggle.is_set(zsw) };
            }
            Act::Leave => {
                commanded.job = TravelJob::None;
                if commanded.word == ControlWord::Inch {
                    commanded.word = ControlWord::Enabled;
                }
            }
            Act::ForgetJob => commanded.job = TravelJob::None,
            Act::Inch => {
                commanded.word = ControlWord::Inch;
                if let Goal::Jog(direction) = self.goal {
                    commanded.word = ControlWord::Jog(direction);
                }
                self.from = seen.hiw;
            }
            Act::KeepWindow => self.window = self.answer.unwrap_or(0),
            Act::Turn => {
                commanded.word = ControlWord::Turn;
                commanded.setpoint = self.goal.rpm().unwrap_or(0);
            }
        }
    }

    /// After the look: the first control word of the goal.
    fn begin(&self, commanded: &mut Commanded, zsw: Zsw) -> Then<Step> {
        let Self { goal, findings: Findings { mode, .. }, .. } = *self;
        if mode == Some(Mode::Velocity) {
            // An edge rests there no longer.
            commanded.start = false;
        }
        if goal.mode().is_some() && goal.mode() != mode {
            return Then::Refused;
        }
        if goal.moves() && !(commanded.word.enables() && ZswBit::OperationEnabled.is_set(zsw)) {
            return Then::Refused;
        }
        let (fault, inhibited) = (ZswBit::Fault.is_set(zsw), ZswBit::TurnOnDisabled.is_set(zsw));
        match goal {
            // What it does at the moment goes on.
            Goal::Enable
                if !inhibited && commanded.word.enables() && ZswBit::OperationEnabled.is_set(zsw) =>
            {
                Then::Done
            }
            Goal::Enable => change(commanded, enabling(mode.unwrap_or(Mode::Positioning), inhibited)),
            Goal::Acknowledge if fault || inhibited => change(commanded, acknowledging(fault)),
            Goal::Acknowledge => Then::Done,
            Goal::MoveTo(_) if commanded.word == ControlWord::Turn => {
                commanded.halt();
                Then::Go(Step::Lower)
            }
            Goal::MoveTo(target) => {
                commanded.word = ControlWord::Travel;
                commanded.setpoint = target;
                Then::Go(Step::Prepare)
            }
            Goal::Pause if commanded.job.is_possible() => Then::Go(Step::Halt),
            Goal::Resume if commanded.job.is_possible() => Then::Go(Step::Resume),
            Goal::Pause | Goal::Resume => Then::Refused,
            Goal::Stop | Goal::Disable => Then::Go(Step::Halt),
            Goal::Inch | Goal::Jog(_) => Then::Go(Step::Check),
            Goal::Velocity(_) => Then::Go(Step::Range),
        }
    }

    /// Goes through the words that change the state.
    fn change_state(
        &self,
        commanded: &mut Commanded,
        course: Course<ControlWord, ()>,
        zsw: Zsw,
    ) -> Then<Step> {
        if course.step().is_some_and(|step| step.shown(zsw.raw()) == Shown::Wait) {
            return Then::Stay;
        }
        let course = course.next();
        match course.step() {
            Some(step) => {
                commanded.word = step.act;
                Then::Go(Step::State(course))
            }
            None => {
                if self.goal == Goal::Acknowledge {
                    commanded.word = ControlWord::Off;
                }
                Then::Done
            }
        }
    }

    pub(super) const fn obstacles(&self) -> Obstacles {
        Obstacles::of(self.goal, self.findings)
    }
}

/// The first word of a change of state.
fn change(commanded: &mut Commanded, course: Course<ControlWord, ()>) -> Then<Step> {
    if let Some(step) = course.step() {
        commanded.end_job_with(step.act);
    }
    Then::Go(Step::State(course))
}
