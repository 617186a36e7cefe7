//! Whether the drive stands or turns as the goal promises.
//!
//! ZSW.13 is not enough: in positioning mode it is 1 while a released shaft runs out, and a drive that follows the flow
//! chart to the letter may show it as soon as a job is interrupted (`ag03.md` C-05). The shaft itself shows in SSW.4, from 2 rpm on, and in the actual value.

use super::course::bits;
use super::goal::Goal;
use super::obstacle::Findings;
use super::seen::Seen;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::{SswBit, ZswBit};
use crate::devices::ag03::profibus::flow_charts::{operation_enabled, ready_to_run};
use crate::profibus::ppo::{Zsw, ZswPattern};

impl Findings {
    /// SSW.4, as last read.
    pub(super) fn travels(&self) -> bool {
        self.ssw.is_some_and(|ssw| SswBit::Travels.is_set(ssw))
    }
}

/// Whether the shaft turns with the velocity, or stands if it is 0 (rows 40 to 42).
pub(super) fn is_at_speed(seen: &Seen, rpm: i32, window: u32, zsw: Zsw) -> bool {
    // A wide window holds standstill and the other direction too.
    let moves = match rpm {
        0 => ZswBit::Standstill.is_set(zsw) && seen.hiw.unsigned_abs() < 2,
        _ => seen.hiw.signum() == rpm.signum() && seen.hiw.unsigned_abs() >= rpm.unsigned_abs().min(2),
    };
    let at_speed = rpm.abs_diff(seen.hiw) <= window && ZswBit::NoLagError.is_set(zsw);
    moves && at_speed && !ZswBit::ReadyToTravel.is_set(zsw)
}

/// Whether the status word is one that the goal ends with.
pub(super) fn is_halted(goal: Goal, mode: Option<Mode>, zsw: Zsw) -> bool {
    let is = |pattern: fn(Mode) -> ZswPattern| {
        mode.is_some_and(|mode| bits(pattern(mode), mode).matches(zsw.raw()))
    };
    let off =
        ZswBit::TurnOnDisabled.is_set(zsw) || ZswBit::Fault.is_set(zsw) || !ZswBit::ReadyToTurnOn.is_set(zsw);
    match goal {
        // Without supply, with a fault or with turning on disabled, the drive is not ready-to-run and yet disabled.
        Goal::Disable => is(ready_to_run) || off && !ZswBit::OperationEnabled.is_set(zsw),
        Goal::Stop if ZswBit::OperationEnabled.is_set(zsw) => is(operation_enabled),
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
