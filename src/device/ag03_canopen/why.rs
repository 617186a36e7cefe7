//! What keeps the drive behind a node from moving now, in words of CANopen.

use core::fmt;

use super::state::State;
use super::words::CwBit;
use super::{Ag03Node, Power};
use crate::canopen::NmtState;
use crate::drive;

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
            let told = move |reason: &drive::Reason| refusal.contains(*reason) && !is_of_state(*reason);
            drive::Reason::ALL
                .into_iter()
                .filter(told)
                .map(move |reason| Hindrance::Drive { refusal, reason })
        });
        power.into_iter().chain(nmt).chain(state.map(Hindrance::State)).chain(reasons)
    }
}

/// Whether [`Hindrance::State`] says it already.
const fn is_of_state(reason: drive::Reason) -> bool {
    matches!(reason, drive::Reason::NotAsked | drive::Reason::NotEnabled | drive::Reason::TurnOnDisabled)
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
                        "remove the cause, then send 6040h = 0000h, then 0080h (bit {}), then 0006h, then 0007h, then \
                         000Fh",
                        CwBit::FaultReset.number()
                    ),
                    State::OperationEnabled => f.write_str("operation is enabled"),
                }
            }
            Self::Drive { refusal, reason } => refusal.text(*reason).fmt(f),
        }
    }
}
