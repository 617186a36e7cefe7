//! What keeps a drive on CANopen from moving, as its master can see it: NMT state, status word, control word, mode.

use core::fmt;

use crate::can_bus::canopen::NmtState;
use crate::can_bus::cia402::{Controlword, State, Statusword};

/// What a master knows of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeSigns {
    /// Its NMT state; `None`: it does not tell.
    pub nmt: Option<NmtState>,
    /// 6041h.
    pub status: Statusword,
    /// 6040h; `None`: it cannot be read.
    pub control: Option<Controlword>,
    /// 6060h; `None`: it cannot be read.
    pub mode: Option<i64>,
}

/// One thing that keeps a drive from moving. `Display` is a sentence: what, where, and what to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NodeHindrance {
    /// In this NMT state PDOs are not carried out.
    Nmt(NmtState),
    /// Bit 3 of 6041h: the newest entry of 1003h says which fault.
    Fault,
    /// Bit 4 of 6041h is 0: the power part has no supply.
    NoVoltage,
    /// 6060h is 0.
    NoMode,
    /// Not operation enabled.
    State(State),
    /// Bit 8 of 6040h.
    Halt,
    /// Bit 11 of 6041h.
    InternalLimit,
}

impl NodeSigns {
    /// What keeps it from moving, the most important first. None: it moves, or waits for a start.
    pub fn hindrances(&self) -> impl Iterator<Item = NodeHindrance> {
        let &Self { nmt, status, control, mode } = self;
        let state = State::of(status).unwrap_or(State::NotReadyToSwitchOn);
        let enabled = state == State::OperationEnabled;
        let nmt = nmt.filter(|state| *state != NmtState::Operational).map(NodeHindrance::Nmt);
        let halt = control.is_some_and(|word| word.has(Controlword::HALT));
        let when = |holds: bool, hindrance| holds.then_some(hindrance);
        [
            nmt,
            when(matches!(state, State::Fault | State::FaultReactionActive), NodeHindrance::Fault),
            when(!status.has(Statusword::VOLTAGE_ENABLED), NodeHindrance::NoVoltage),
            when(mode == Some(0), NodeHindrance::NoMode),
            when(!enabled, NodeHindrance::State(state)),
            when(enabled && halt, NodeHindrance::Halt),
            when(status.has(Statusword::INTERNAL_LIMIT), NodeHindrance::InternalLimit),
        ]
        .into_iter()
        .flatten()
    }
}

impl fmt::Display for NodeHindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nmt(state) => {
                write!(f, "NMT state {state}, PDOs are not carried out: send NMT start (01h)")
            }
            Self::Fault => f.write_str(
                "fault (bit 3 of 6041h), 1003h:01 says which: remove its cause, then acknowledge it",
            ),
            Self::NoVoltage => f.write_str("the power part has no supply (bit 4 of 6041h)"),
            Self::NoMode => f.write_str("no mode of operation is chosen: write 6060h"),
            Self::State(state) => {
                write!(f, "drive state '{state}': ")?;
                f.write_str(match state {
                    State::OperationEnabled => "operation is enabled",
                    State::Fault | State::FaultReactionActive => "send 6040h = 0080h (bit 7 from 0 to 1)",
                    State::QuickStopActive => "send 6040h = 0000h, then 0006h",
                    State::NotReadyToSwitchOn | State::SwitchOnDisabled => {
                        "send 6040h = 0006h, then 0007h, then 000Fh"
                    }
                    State::ReadyToSwitchOn => "send 6040h = 0007h, then 000Fh",
                    State::SwitchedOn => "send 6040h = 000Fh",
                })
            }
            Self::Halt => f.write_str("bit 8 of 6040h is 1: halt"),
            Self::InternalLimit => f.write_str("a limit in the drive is active (bit 11 of 6041h)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sign_is_a_hindrance_and_without_one_there_is_none() {
        let moving = NodeSigns {
            nmt: Some(NmtState::Operational),
            status: Statusword(0x0237),
            control: Some(Controlword(0x000F)),
            mode: Some(1),
        };
        let of = |signs: NodeSigns| signs.hindrances().collect::<std::vec::Vec<_>>();
        assert_eq!(of(moving), []);
        let untold = NodeSigns { nmt: None, control: None, mode: None, ..moving };
        assert_eq!(of(untold), []);
        let fresh = NodeSigns {
            nmt: Some(NmtState::PreOperational),
            status: Statusword(0x0040),
            control: Some(Controlword(0)),
            mode: Some(0),
        };
        assert_eq!(
            of(fresh),
            [
                NodeHindrance::Nmt(NmtState::PreOperational),
                NodeHindrance::NoVoltage,
                NodeHindrance::NoMode,
                NodeHindrance::State(State::SwitchOnDisabled),
            ]
        );
        let fault = NodeSigns { status: Statusword(0x0218), ..moving };
        assert_eq!(of(fault), [NodeHindrance::Fault, NodeHindrance::State(State::Fault)]);
        let halted = NodeSigns { control: Some(Controlword(0x010F)), status: Statusword(0x0A37), ..moving };
        assert_eq!(of(halted), [NodeHindrance::Halt, NodeHindrance::InternalLimit]);
    }
}
