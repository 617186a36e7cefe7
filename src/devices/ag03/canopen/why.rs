//! What keeps the drive behind a node from moving now, in words of CANopen.

use core::fmt;

use super::state::State;
use super::words::CwBit;
use super::{Ag03Node, Power};
use crate::can_bus::canopen::NmtState;
use crate::devices::ag03::drive;

/// One thing that keeps the drive from moving. `Display` is a sentence: what, where, and what to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hindrance {
    /// Without control supply.
    SwitchedOff,
    /// Switched on with the DIP switches of a factory reset.
    FactoryReset,
    /// PDOs are not carried out in this NMT state.
    Nmt(NmtState),
    /// Not OPERATION ENABLED.
    State(State),
    /// What the drive itself has against a start.
    Drive {
        /// Everything it has.
        refusal: drive::Refusal,
        /// Which of that.
        reason: drive::Reason,
    },
}

impl Ag03Node {
    /// What keeps the drive from moving now, the most important first. None: it moves, or waits for a start.
    pub fn why(&self) -> impl Iterator<Item = Hindrance> {
        let power = match self.power() {
            Power::Off => Some(Hindrance::SwitchedOff),
            Power::FactoryReset(_) => Some(Hindrance::FactoryReset),
            Power::On => None,
        };
        let on = power.is_none();
        let nmt = self.nmt_state().filter(|state| on && *state != NmtState::Operational).map(Hindrance::Nmt);
        let state = Some(self.state()).filter(|state| on && *state != State::OperationEnabled);
        let refusal = self.unit().start_refusal().filter(|_| on && !self.status().job_active);
        let reasons = refusal.into_iter().flat_map(move |refusal| {
            let told = refusal.reasons().filter(|reason| !is_of_state(*reason));
            told.map(move |reason| Hindrance::Drive { refusal, reason })
        });
        power.into_iter().chain(nmt).chain(state.map(Hindrance::State)).chain(reasons)
    }
}

/// Whether [`Hindrance::State`] says it already.
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

impl fmt::Display for Hindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SwitchedOff => f.write_str("the drive is switched off: switch its supply on"),
            Self::FactoryReset => {
                f.write_str("the drive is in a factory reset: switch it off, put SW8 to OFF and switch it on")
            }
            Self::Nmt(state) => {
                write!(f, "NMT state {state}, PDOs are not carried out: send NMT start (01h)")
            }
            Self::State(state) => {
                write!(f, "drive state {state}: ")?;
                match state {
                    State::SwitchOnDisabled => f.write_str("send 6040h = 0006h, then 0007h, then 000Fh"),
                    State::ReadyToSwitchOn => f.write_str("send 6040h = 0007h, then 000Fh"),
                    State::SwitchedOn => f.write_str("send 6040h = 000Fh"),
                    State::QuickStopActive => {
                        f.write_str("send 6040h = 0000h, then 0006h, then 0007h, then 000Fh")
                    }
                    State::Fault => write!(
                        f,
                        "a fault is latched (1001h, 603Fh): remove the cause, then send 6040h = 0000h, then 0080h (bit {}), then 0006h, then 0007h, then \
                         000Fh",
                        CwBit::FaultReset.number()
                    ),
                    State::OperationEnabled => f.write_str("operation is enabled"),
                }
            }
            Self::Drive { refusal, reason } => write!(f, "{}{}", refusal.text(*reason), cure(*reason)),
        }
    }
}
