//! What keeps the drive behind a node from moving now, in words of CANopen.

use core::fmt;

use super::state::State;
use super::{Ag03Node, Power};
use crate::can_bus::cia402::{self, Controlword};
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::why::of_power;
use crate::devices::reasons;
use crate::face::{Reason, Why};

impl Why for Ag03Node {
    fn is_moving(&self) -> Option<bool> {
        Some(self.status().moving)
    }

    fn waits(&self) -> Option<&dyn fmt::Display> {
        let mode = match self.status().mode {
            Mode::Positioning => cia402::Mode::ProfilePosition,
            Mode::Velocity => cia402::Mode::ProfileVelocity,
        };
        Some(reasons::waits_for(Some(mode), Controlword(0)))
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        of_power(self.power(), tell);
        let (Power::On, Some(nmt)) = (self.power(), self.nmt_state()) else { return };
        reasons::of_node(nmt, self.node.sync_missing(), tell);
        let state = self.state();
        if state != State::OperationEnabled {
            tell(Reason::new("NotEnabled", &format_args!("drive state {state}: {}", to_enable(state))));
        }
        let refusal = self.unit().start_refusal().filter(|_| !self.status().job_active);
        if let Some(refusal) = &refusal {
            for reason in refusal.reasons().filter(|reason| !is_of_state(*reason)) {
                tell(Reason::new(reason.name(), &format_args!("{}{}", refusal.text(reason), cure(reason))));
            }
        }
    }
}

/// What to send until operation is enabled.
const fn to_enable(state: State) -> &'static str {
    match state {
        State::SwitchOnDisabled
        | State::ReadyToSwitchOn
        | State::SwitchedOn
        | State::OperationEnabled
        | State::QuickStopActive => state.of_profile().to_enable(),
        State::Fault => {
            "a fault is latched (1001h, 603Fh): remove the cause, then send 6040h = 0000h, then 0080h (bit 7), then \
             0006h, then 0007h, then 000Fh"
        }
    }
}

/// Whether the state says it already.
const fn is_of_state(reason: drive::Reason) -> bool {
    matches!(
        reason,
        drive::Reason::NotAsked
            | drive::Reason::NotEnabled
            | drive::Reason::TurnOnDisabled
            | drive::Reason::FaultLatched
    )
}

/// What to do about a reason, with the bits and objects of CANopen.
const CURES: &[(drive::Reason, &str)] = &[
    (drive::Reason::NotAsked, ": send 6040h = 0006h, then 0007h, then 000Fh"),
    (drive::Reason::NotEnabled, ": send 6040h = 0006h, then 0007h, then 000Fh"),
    (drive::Reason::FaultLatched, ": remove its cause, then 6040h bit 7 from 0 to 1"),
    (drive::Reason::FaultCause, ": remove it, then acknowledge again"),
    (drive::Reason::Stop, " (6040h bit 8 = 1)"),
    (drive::Reason::IntermediateStop, " (6040h bit 8 = 1)"),
    (drive::Reason::AboveUpperLimit, ", or change the limits (607Dh)"),
    (drive::Reason::BelowLowerLimit, ", or change the limits (607Dh)"),
    (drive::Reason::SetpointAboveUpperLimit, ": give another target (607Ah), or change the limits (607Dh)"),
    (drive::Reason::SetpointBelowLowerLimit, ": give another target (607Ah), or change the limits (607Dh)"),
    (drive::Reason::LoopPointAboveUpperLimit, ": give another target (607Ah), or change the limits (607Dh)"),
    (drive::Reason::LoopPointBelowLowerLimit, ": give another target (607Ah), or change the limits (607Dh)"),
    (drive::Reason::BothInching, ": set only one of 6040h bits 13, 14 and 15"),
    (drive::Reason::ShaftTurns, ": wait until it stands"),
    (drive::Reason::NoSupply, ": switch it on"),
    (drive::Reason::NoOutputStage, ": switch it on"),
];

/// Empty where the words of the drive say what to do.
fn cure(reason: drive::Reason) -> &'static str {
    CURES.iter().find(|(of, _)| *of == reason).map_or("", |(_, cure)| cure)
}

/// A refused command in one line, with the bits and objects of CANopen.
pub(super) struct Refused<'a>(pub(super) &'a drive::Refusal);

impl fmt::Display for Refused<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(refusal) = self;
        write!(f, "{} refused", refusal.asked())?;
        for (place, reason) in refusal.reasons().enumerate() {
            let gap = if place == 0 { ": " } else { "; " };
            write!(f, "{gap}{}{}", refusal.text(reason), cure(reason))?;
        }
        Ok(())
    }
}
