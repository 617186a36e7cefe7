//! The drive state machine of 6040h and 6041h (`canopen-ag03.md` 9), by the numbers of the transitions in the manual.
//!
//! NOT READY TO SWITCH ON (transitions 0 and 1) is over before the node can be asked, so it is no state here.
//!
//! ```text
//!        ┌──────────────────────────── 7, 9, 10, 12: disable voltage ────────────────────────────┐
//!        ▼                                                                                       │
//! SWITCH ON DISABLED ─2 shutdown─▶ READY TO SWITCH ON ─3 switch on─▶ SWITCHED ON ─4 enable─▶ OPERATION ENABLED
//!        ▲                             ▲   ◀──────────── 6 ──────────────┘  ◀───── 5 ──────────────┘ │  │
//!        │ 14 fault reset              └──────────────────────────── 8 shutdown ─────────────────────┘  11 quick stop
//!      FAULT ◀─13─ any                                                                    QUICK STOP ACTIVE ◀┘
//! ```

use crate::can_bus::cia402;
use core::fmt;

use strum::VariantArray;

use super::words::{ControlWord, CwBit, SwBit};
use crate::face::DriveState;

/// A state of the drive on CANopen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray)]
pub enum State {
    /// The motor is released.
    SwitchOnDisabled,
    /// The motor is released.
    ReadyToSwitchOn,
    /// The motor is released.
    SwitchedOn,
    /// Travel commands are accepted.
    OperationEnabled,
    /// The shaft brakes with maximum deceleration and is held.
    QuickStopActive,
    /// A fault is latched; the motor is released.
    Fault,
}

/// What the low octet of a control word asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Request {
    /// x110.
    Shutdown,
    /// 0111: switch on, or disable operation.
    SwitchOn,
    /// xx0x.
    DisableVoltage,
    /// x01x.
    QuickStop,
    /// 1111.
    EnableOperation,
    /// Bit 7 is 1: none of the others.
    None,
}

impl Request {
    /// What a control word asks for, by bits 7 and 3 to 0.
    pub(crate) const fn of(word: ControlWord) -> Self {
        if word.has(CwBit::FaultReset) {
            return Self::None;
        }
        let bits = (
            word.has(CwBit::EnableVoltage),
            word.has(CwBit::NoQuickStop),
            word.has(CwBit::SwitchOn),
            word.has(CwBit::EnableOperation),
        );
        match bits {
            (false, _, _, _) => Self::DisableVoltage,
            (true, false, _, _) => Self::QuickStop,
            (true, true, false, _) => Self::Shutdown,
            (true, true, true, false) => Self::SwitchOn,
            (true, true, true, true) => Self::EnableOperation,
        }
    }
}

impl State {
    /// Every state.
    pub const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// The state after a request. Only a listed transition changes it (CN-44).
    #[must_use]
    pub(crate) const fn after(self, request: Request) -> Self {
        match (self, request) {
            // 2
            (Self::SwitchOnDisabled, Request::Shutdown) => Self::ReadyToSwitchOn,
            // 3
            (Self::ReadyToSwitchOn, Request::SwitchOn) => Self::SwitchedOn,
            // 4
            (Self::SwitchedOn, Request::EnableOperation) => Self::OperationEnabled,
            // 5
            (Self::OperationEnabled, Request::SwitchOn) => Self::SwitchedOn,
            // 6, 8
            (Self::SwitchedOn | Self::OperationEnabled, Request::Shutdown) => Self::ReadyToSwitchOn,
            // 7, 9, 10, 12
            (
                Self::ReadyToSwitchOn | Self::OperationEnabled | Self::SwitchedOn | Self::QuickStopActive,
                Request::DisableVoltage,
            ) => Self::SwitchOnDisabled,
            // 11
            (Self::OperationEnabled, Request::QuickStop) => Self::QuickStopActive,
            (
                Self::SwitchOnDisabled,
                Request::SwitchOn
                | Request::DisableVoltage
                | Request::QuickStop
                | Request::EnableOperation
                | Request::None,
            )
            | (
                Self::ReadyToSwitchOn,
                Request::Shutdown | Request::QuickStop | Request::EnableOperation | Request::None,
            )
            | (Self::SwitchedOn, Request::SwitchOn | Request::QuickStop | Request::None)
            | (Self::OperationEnabled, Request::EnableOperation | Request::None)
            | (
                Self::QuickStopActive,
                Request::Shutdown
                | Request::SwitchOn
                | Request::QuickStop
                | Request::EnableOperation
                | Request::None,
            )
            | (
                Self::Fault,
                Request::Shutdown
                | Request::SwitchOn
                | Request::DisableVoltage
                | Request::QuickStop
                | Request::EnableOperation
                | Request::None,
            ) => self,
        }
    }

    /// The same state of CiA 402.
    pub(super) const fn of_profile(self) -> cia402::State {
        match self {
            Self::SwitchOnDisabled => cia402::State::SwitchOnDisabled,
            Self::ReadyToSwitchOn => cia402::State::ReadyToSwitchOn,
            Self::SwitchedOn => cia402::State::SwitchedOn,
            Self::OperationEnabled => cia402::State::OperationEnabled,
            Self::QuickStopActive => cia402::State::QuickStopActive,
            Self::Fault => cia402::State::Fault,
        }
    }

    /// The bits of the status word that show the state.
    pub(super) const fn bits(self) -> u16 {
        let on = SwBit::ReadyToSwitchOn.mask();
        let switched = on | SwBit::SwitchedOn.mask();
        let enabled = switched | SwBit::OperationEnabled.mask();
        let no_quick_stop = SwBit::NoQuickStop.mask();
        match self {
            Self::SwitchOnDisabled => SwBit::SwitchOnDisabled.mask() | no_quick_stop,
            Self::ReadyToSwitchOn => on | no_quick_stop,
            Self::SwitchedOn => switched | no_quick_stop,
            Self::OperationEnabled => enabled | no_quick_stop,
            Self::QuickStopActive => enabled,
            Self::Fault => SwBit::Fault.mask() | no_quick_stop,
        }
    }
}

impl fmt::Display for State {
    /// As the manual writes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SwitchOnDisabled => "SWITCH ON DISABLED",
            Self::ReadyToSwitchOn => "READY TO SWITCH ON",
            Self::SwitchedOn => "SWITCHED ON",
            Self::OperationEnabled => "OPERATION ENABLED",
            Self::QuickStopActive => "QUICK STOP ACTIVE",
            Self::Fault => "FAULT",
        })
    }
}

impl From<State> for DriveState {
    fn from(state: State) -> Self {
        match state {
            State::SwitchOnDisabled => Self::Inhibited,
            State::ReadyToSwitchOn | State::SwitchedOn => Self::Ready,
            State::OperationEnabled | State::QuickStopActive => Self::Enabled,
            State::Fault => Self::Fault,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_01_the_whole_transition_table() {
        use Request as R;
        use State as S;
        let listed = [
            (S::SwitchOnDisabled, R::Shutdown, S::ReadyToSwitchOn),
            (S::ReadyToSwitchOn, R::SwitchOn, S::SwitchedOn),
            (S::SwitchedOn, R::EnableOperation, S::OperationEnabled),
            (S::OperationEnabled, R::SwitchOn, S::SwitchedOn),
            (S::SwitchedOn, R::Shutdown, S::ReadyToSwitchOn),
            (S::ReadyToSwitchOn, R::DisableVoltage, S::SwitchOnDisabled),
            (S::OperationEnabled, R::Shutdown, S::ReadyToSwitchOn),
            (S::OperationEnabled, R::DisableVoltage, S::SwitchOnDisabled),
            (S::SwitchedOn, R::DisableVoltage, S::SwitchOnDisabled),
            (S::OperationEnabled, R::QuickStop, S::QuickStopActive),
            (S::QuickStopActive, R::DisableVoltage, S::SwitchOnDisabled),
        ];
        for &state in S::ALL {
            for word in 0..=0xFF {
                let request = R::of(ControlWord(word));
                let found = listed.iter().find(|row| (row.0, row.1) == (state, request));
                assert_eq!(state.after(request), found.map_or(state, |row| row.2), "{state} {word:02X}");
            }
        }
    }

    #[test]
    fn requests_by_their_patterns() {
        for (word, request) in [
            (0x0106, Request::Shutdown),
            (0x010E, Request::Shutdown),
            (0x0107, Request::SwitchOn),
            (0x010F, Request::EnableOperation),
            (0x0002, Request::QuickStop),
            (0x000B, Request::QuickStop),
            (0x0000, Request::DisableVoltage),
            (0x000D, Request::DisableVoltage),
            (0x0086, Request::None),
            (0x0080, Request::None),
        ] {
            assert_eq!(Request::of(ControlWord(word)), request, "{word:04X}");
        }
    }
}
