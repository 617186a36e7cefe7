//! Whether the drive stands: what ends the goals that promise it, and what notices that a motion ended by itself.
//!
//! ZSW.13 is not enough: in positioning mode it is 1 while a released shaft runs out, and a drive that follows the flow
//! chart to the letter may show it as soon as a job is interrupted (`ag03.md` C-05). The shaft itself shows in SSW.4, from 2 rpm on, and in the actual value.

use core::time::Duration;

use super::goal::Goal;
use super::job::{TravelJob, stands_at_target};
use super::obstacle::Findings;
use super::posture::Posture;
use super::pursuit::{Next, Pursuit, Step, done_if};
use super::zsw::{ZswPattern, bit};
use super::{Activity, DriveClient, Instant};
use crate::drive::Mode;
use crate::ppo::Zsw;

/// So long the actual value must rest: a shaft that slows down below 2 rpm with the smallest deceleration stands then.
const REST: Duration = Duration::from_millis(200);
/// So much of the actual value is position control, not motion.
const JITTER: u32 = 2;

/// Since when the actual value rests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    hiw: i32,
    since: Instant,
}

impl Rest {
    pub(super) fn seen(rest: Option<Self>, now: Instant, hiw: i32) -> Self {
        rest.filter(|rest| rest.hiw.abs_diff(hiw) <= JITTER).unwrap_or(Self { hiw, since: now })
    }

    fn is_long_enough(self, now: Instant) -> bool {
        now.saturating_since(self.since) >= REST
    }
}

impl Findings {
    /// SSW.4, as last read.
    pub(super) fn travels(&self) -> bool {
        self.ssw.is_some_and(|ssw| ssw >> 4 & 1 == 1)
    }
}

impl DriveClient {
    /// Stop, pause and disable, each time SSW was read.
    pub(super) fn halted(&mut self, now: Instant, pursuit: &Pursuit, zsw: Zsw) -> Next {
        let Pursuit { goal, ref findings, .. } = *pursuit;
        if findings.travels() {
            return Next::Step(Step::RunOut);
        }
        let rests = self.rest.is_some_and(|rest| rest.is_long_enough(now));
        if !(rests && is_halted(goal, findings.mode, zsw)) {
            return Next::Step(Step::Halt);
        }
        match (goal, self.job) {
            // It stands at its target: it ended before the pause was seen.
            (Goal::Pause, TravelJob::Active) if !stands_at_target(zsw) => Next::Done,
            (Goal::Pause, TravelJob::None | TravelJob::Asked { .. } | TravelJob::Active) => {
                self.job = TravelJob::None;
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

    /// A travel job or inching 1 shows its end (rows 23, 29).
    pub(super) fn arrived(&mut self, zsw: Zsw) -> Next {
        if !(zsw.bit(bit::TARGET_REACHED) && zsw.bit(bit::OPERATION_ENABLED)) {
            return Next::Refused;
        }
        // An AG03 that lost its enable input runs out with ZSW.13 = 1, but is not ready to travel (row 3b).
        if zsw.bit(bit::READY_TO_TRAVEL) { self.leave() } else { Next::Step(Step::Settle) }
    }

    /// The end of a motion that reached its target.
    pub(super) fn leave(&mut self) -> Next {
        self.job = TravelJob::None;
        if self.posture == Posture::Inch {
            self.posture = Posture::Enabled;
        }
        Next::Done
    }

    /// Whether the shaft turns with the velocity, or stands if it is 0 (rows 40 to 42).
    pub(super) fn turned(&self, rpm: i32, window: u32, zsw: Zsw) -> Next {
        let stands = zsw.bit(bit::STANDSTILL);
        if stands && rpm != 0 {
            return Next::Step(Step::Stalled { window });
        }
        // A wide window holds standstill and the other direction too.
        let moves = match rpm {
            0 => stands && self.hiw.unsigned_abs() < 2,
            _ => self.hiw.signum() == rpm.signum() && self.hiw.unsigned_abs() >= rpm.unsigned_abs().min(2),
        };
        let at_speed = rpm.abs_diff(self.hiw) <= window && zsw.bit(bit::NO_LAG_OR_AT_SPEED);
        done_if(moves && at_speed && !zsw.bit(bit::READY_TO_TRAVEL))
    }

    /// Takes the control word back to 000B when a motion ends by what happens to the drive: what a level of STW asks
    /// for would begin again by itself when the supply or the enable input comes back.
    pub(super) fn note_lost_motion(&mut self, zsw: Zsw) {
        let enabled = zsw.bit(bit::OPERATION_ENABLED) && !zsw.bit(bit::FAULT);
        let ended = zsw.bit(bit::STANDSTILL) && !self.begins_motion();
        let lost = match self.posture {
            Posture::Off | Posture::Off1 | Posture::Disabled | Posture::Acknowledging | Posture::Enabled => {
                !enabled && self.job != TravelJob::None
            }
            // Only an edge begins these, and STW.5 continues only a job that the drive still has.
            Posture::Travel | Posture::Paused | Posture::Inch => !enabled,
            Posture::Jog(_) => !enabled || ended,
            Posture::Turn => !enabled || ended && self.setpoint != 0,
        };
        if lost {
            self.halt();
        }
    }

    /// Whether a motion is about to begin, or passes through standstill.
    fn begins_motion(&self) -> bool {
        match self.activity {
            Activity::Pursuing(Pursuit { step, .. }) => step.begins_turning(),
            Activity::None | Activity::Explaining(_) | Activity::Over(_) => false,
        }
    }
}

/// Whether the status word is one that the goal ends with.
fn is_halted(goal: Goal, mode: Option<Mode>, zsw: Zsw) -> bool {
    let is = |pattern: fn(Mode) -> ZswPattern| mode.is_some_and(|mode| pattern(mode).is_met(mode, zsw));
    let off = zsw.bit(bit::TURN_ON_DISABLED) || zsw.bit(bit::FAULT) || !zsw.bit(bit::READY);
    match goal {
        // Without supply, with a fault or with turning on disabled, the drive is not ready-to-run and yet disabled.
        Goal::Disable => is(ZswPattern::ready_to_run) || off && !zsw.bit(bit::OPERATION_ENABLED),
        Goal::Stop if zsw.bit(bit::OPERATION_ENABLED) => is(ZswPattern::operation_enabled),
        Goal::Stop
        | Goal::Pause
        | Goal::Enable
        | Goal::Acknowledge
        | Goal::MoveTo(_)
        | Goal::Resume
        | Goal::Inch
        | Goal::Jog(_)
        | Goal::Velocity(_) => zsw.bit(bit::STANDSTILL),
    }
}
