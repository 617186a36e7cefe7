//! Whether the drive stands or turns as the goal promises.
//!
//! ZSW.13 is not enough: in positioning mode it is 1 while a released shaft runs out, and a drive that follows the flow
//! chart to the letter may show it as soon as a job is interrupted (`ag03.md` C-05). The shaft itself shows in SSW.4, from 2 rpm on, and in the actual value.

use super::commanded::Commanded;
use super::control_word::ControlWord;
use super::goal::Goal;
use super::job::{TravelJob, stands_at_target};
use super::obstacle::Findings;
use super::progress::GoalProgress;
use super::seen::Seen;
use super::step::{Next, Step, done_if};
use super::zsw::ZswPattern;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::{SswBit, ZswBit};
use crate::profibus::ppo::Zsw;
use crate::time::Instant;

impl Findings {
    /// SSW.4, as last read.
    pub(super) fn travels(&self) -> bool {
        self.ssw.is_some_and(|ssw| SswBit::Travels.is_set(ssw))
    }
}

impl GoalProgress {
    /// Stop, pause and disable, each time SSW was read.
    pub(super) fn halted(&self, now: Instant, commanded: &mut Commanded, seen: &Seen, zsw: Zsw) -> Next {
        let Self { goal, ref findings, .. } = *self;
        if findings.travels() {
            return Next::Step(Step::RunOut);
        }
        if !(seen.rests(now) && is_halted(goal, findings.mode, zsw)) {
            return Next::Step(Step::Halt);
        }
        match (goal, commanded.job) {
            // It stands at its target: it ended before the pause was seen.
            (Goal::Pause, TravelJob::Active) if !stands_at_target(zsw) => Next::Done,
            (Goal::Pause, TravelJob::None | TravelJob::Asked { .. } | TravelJob::Active) => {
                commanded.job = TravelJob::None;
                Next::Refused
            }
            (
                Goal::Stop
                | Goal::Disable
                | Goal::Enable
                | Goal::Acknowledge
                | Goal::MoveTo(_)
                | Goal::Resume
                | Goal::Inch
                | Goal::Jog(_)
                | Goal::Velocity(_),
                TravelJob::None | TravelJob::Asked { .. } | TravelJob::Active,
            ) => Next::Done,
        }
    }
}

/// A travel job or inching 1 shows its end (rows 23, 29).
pub(super) fn arrived(commanded: &mut Commanded, zsw: Zsw) -> Next {
    if !(ZswBit::TargetReached.is_set(zsw) && ZswBit::OperationEnabled.is_set(zsw)) {
        return Next::Refused;
    }
    // An AG03 that lost its enable input runs out with ZSW.13 = 1, but is not ready to travel (row 3b).
    if ZswBit::ReadyToTravel.is_set(zsw) { leave(commanded) } else { Next::Step(Step::Settle) }
}

/// The end of a motion that reached its target.
pub(super) fn leave(commanded: &mut Commanded) -> Next {
    commanded.job = TravelJob::None;
    if commanded.word == ControlWord::Inch {
        commanded.word = ControlWord::Enabled;
    }
    Next::Done
}

/// Whether the shaft turns with the velocity, or stands if it is 0 (rows 40 to 42).
pub(super) fn turned(seen: &Seen, rpm: i32, window: u32, zsw: Zsw) -> Next {
    let stands = ZswBit::Standstill.is_set(zsw);
    if stands && rpm != 0 {
        return Next::Step(Step::Stalled { window });
    }
    // A wide window holds standstill and the other direction too.
    let moves = match rpm {
        0 => stands && seen.hiw.unsigned_abs() < 2,
        _ => seen.hiw.signum() == rpm.signum() && seen.hiw.unsigned_abs() >= rpm.unsigned_abs().min(2),
    };
    let at_speed = rpm.abs_diff(seen.hiw) <= window && ZswBit::NoLagError.is_set(zsw);
    done_if(moves && at_speed && !ZswBit::ReadyToTravel.is_set(zsw))
}

/// Whether the status word is one that the goal ends with.
fn is_halted(goal: Goal, mode: Option<Mode>, zsw: Zsw) -> bool {
    let is = |pattern: fn(Mode) -> ZswPattern| {
        mode.is_some_and(|mode| pattern(mode).bits(mode).matches(zsw.raw()))
    };
    let off =
        ZswBit::TurnOnDisabled.is_set(zsw) || ZswBit::Fault.is_set(zsw) || !ZswBit::ReadyToTurnOn.is_set(zsw);
    match goal {
        // Without supply, with a fault or with turning on disabled, the drive is not ready-to-run and yet disabled.
        Goal::Disable => is(ZswPattern::ready_to_run) || off && !ZswBit::OperationEnabled.is_set(zsw),
        Goal::Stop if ZswBit::OperationEnabled.is_set(zsw) => is(ZswPattern::operation_enabled),
        Goal::Stop
        | Goal::Pause
        | Goal::Enable
        | Goal::Acknowledge
        | Goal::MoveTo(_)
        | Goal::Resume
        | Goal::Inch
        | Goal::Jog(_)
        | Goal::Velocity(_) => ZswBit::Standstill.is_set(zsw),
    }
}
