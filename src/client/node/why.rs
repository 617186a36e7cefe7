//! What keeps a drive on CANopen from moving, as its master can see it: NMT state, status word, control word, mode.

use crate::can_bus::canopen::NmtState;
use crate::can_bus::cia402::{Controlword, State, Statusword};
use crate::devices::reasons;
use crate::face::{Reason, Why};

/// What a master knows of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NodeSigns {
    /// Its NMT state; `None`: it does not tell.
    pub nmt: Option<NmtState>,
    /// 6041h.
    pub status: Statusword,
    /// 6040h; `None`: it cannot be read.
    pub control: Option<Controlword>,
    /// 6060h; `None`: it cannot be read.
    pub mode: Option<i64>,
}

const FAULT: Reason<'static> = Reason::new(
    "Fault",
    &"fault (bit 3 of 6041h), 1003h:01 says which: remove its cause, then acknowledge it",
);
const NO_VOLTAGE: Reason<'static> =
    Reason::new("NoVoltage", &"the power part has no supply (bit 4 of 6041h)");
const INTERNAL_LIMIT: Reason<'static> =
    Reason::new("InternalLimit", &"a limit in the drive is active (bit 11 of 6041h)");

impl Why for NodeSigns {
    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        let &Self { nmt, status, control, mode } = self;
        let state = State::of(status).unwrap_or(State::NotReadyToSwitchOn);
        let enabled = state == State::OperationEnabled;
        let halt = control.is_some_and(|word| word.has(Controlword::HALT));
        if let Some(nmt) = nmt {
            reasons::of_node(nmt, None, tell);
        }
        let mut tell_if = |holds: bool, reason: Reason<'_>| {
            if holds {
                tell(reason);
            }
        };
        tell_if(matches!(state, State::Fault | State::FaultReactionActive), FAULT);
        tell_if(!status.has(Statusword::VOLTAGE_ENABLED), NO_VOLTAGE);
        tell_if(mode == Some(0), reasons::NO_MODE);
        let cure = state.to_enable();
        tell_if(!enabled, Reason::new("NotEnabled", &format_args!("drive state '{state}': {cure}")));
        tell_if(enabled && halt, reasons::HALT);
        tell_if(status.has(Statusword::INTERNAL_LIMIT), INTERNAL_LIMIT);
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
        let of = |signs: NodeSigns| {
            let mut names = std::vec::Vec::new();
            signs.each_reason(&mut |reason| names.push(reason.name));
            names
        };
        assert_eq!(of(moving), [""; 0]);
        let untold = NodeSigns { nmt: None, control: None, mode: None, ..moving };
        assert_eq!(of(untold), [""; 0]);
        let fresh = NodeSigns {
            nmt: Some(NmtState::PreOperational),
            status: Statusword(0x0040),
            control: Some(Controlword(0)),
            mode: Some(0),
        };
        assert_eq!(of(fresh), ["NmtState", "NoVoltage", "NoMode", "NotEnabled"]);
        let fault = NodeSigns { status: Statusword(0x0218), ..moving };
        assert_eq!(of(fault), ["Fault", "NotEnabled"]);
        let halted = NodeSigns { control: Some(Controlword(0x010F)), status: Statusword(0x0A37), ..moving };
        assert_eq!(of(halted), ["Halt", "InternalLimit"]);
    }
}
