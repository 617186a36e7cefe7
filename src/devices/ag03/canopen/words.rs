//! Control word 6040h and status word 6041h: every bit once, and the words from and to what the drive knows
//! (`canopen-ag03.md` 9.1 and 9.2).
//!
//! ```text
//! 6040h  15    14    13   12..9  8      7      6 5  4      3       2      1        0
//!        inch- inch+ inch1  -    pause  reset   -   start  enable  /quick voltage  switch on
//! 6041h  15    14    13   12     11     10     9    8      7       6      5        4     3      2    1    0
//!        moves job   0    ack    limit  target rem  ready  warning SOD    /quick   volt  fault  OE   SO   RTSO
//! ```

use super::state::State;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Direction, Mode, Status};
use crate::face::bits_of_word;

bits_of_word! {
    /// A bit of the control word.
    CwBit {
        SwitchOn = 0: "switch on";
        /// Enable voltage (printed "disable voltage").
        EnableVoltage = 1: "enable voltage";
        /// Quick stop, active at 0.
        NoQuickStop = 2: "no quick stop";
        EnableOperation = 3: "enable operation";
        /// Positioning: a change from 0 to 1 starts a travel job.
        NewSetpoint = 4: "new setpoint";
        /// A change from 0 to 1 acknowledges a fault.
        FaultReset = 7: "fault reset";
        /// Positioning: intermediate stop. Velocity: stop; a change from 1 to 0 starts.
        Stop = 8: "stop";
        /// Positioning: a change from 0 to 1 starts inching 1.
        Inching1 = 13: "inching 1";
        /// Positioning: inching 2 in positive direction.
        Inching2Positive = 14: "inching 2 positive";
        /// Positioning: inching 2 in negative direction.
        Inching2Negative = 15: "inching 2 negative";
    }
}

impl CwBit {
    /// Whether the bit means something in a mode.
    pub(crate) const fn acts_in(self, mode: Mode) -> bool {
        match self {
            Self::SwitchOn
            | Self::EnableVoltage
            | Self::NoQuickStop
            | Self::EnableOperation
            | Self::FaultReset
            | Self::Stop => true,
            Self::NewSetpoint | Self::Inching1 | Self::Inching2Positive | Self::Inching2Negative => {
                matches!(mode, Mode::Positioning)
            }
        }
    }
}

bits_of_word! {
    /// A bit of the status word.
    SwBit {
        ReadyToSwitchOn = 0: "ready to switch on";
        SwitchedOn = 1: "switched on";
        OperationEnabled = 2: "operation enabled";
        Fault = 3: "fault";
        /// The supplies are within their tolerance.
        VoltageEnabled = 4: "voltage enabled";
        /// 0: quick stop is active.
        NoQuickStop = 5: "no quick stop";
        SwitchOnDisabled = 6: "switch on disabled";
        /// A warning is pending.
        Warning = 7: "warning";
        Ready = 8: "ready to travel";
        /// The master has control: NMT is OPERATIONAL or STOPPED.
        Remote = 9: "remote";
        /// Positioning: the shaft stands at the target. Velocity: the speed is in the window.
        TargetReached = 10: "target reached";
        /// Positioning: a limit is exceeded.
        LimitExceeded = 11: "limit exceeded";
        /// Positioning: the setpoint is acknowledged. Velocity: the shaft stands.
        Acknowledge = 12: "setpoint acknowledged";
        /// Positioning: a job is active.
        JobActive = 14: "job active";
        /// Positioning: the shaft moves.
        Moves = 15: "shaft moves";
    }
}

impl SwBit {
    /// What the bit says in a mode.
    pub(crate) const fn name_in(self, mode: Mode) -> &'static str {
        match (mode, self) {
            (Mode::Velocity, Self::TargetReached) => "speed in window",
            (Mode::Velocity, Self::Acknowledge) => "standstill",
            (Mode::Positioning | Mode::Velocity, _) => self.name(),
        }
    }
}

/// The control word 6040h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct ControlWord(pub u16);

impl ControlWord {
    /// Whether a bit is 1.
    pub(crate) const fn has(self, bit: CwBit) -> bool {
        self.0 >> bit.number() & 1 == 1
    }

    /// Whether a bit changed from 0 to 1.
    pub(crate) const fn rises(self, before: Self, bit: CwBit) -> bool {
        self.has(bit) && !before.has(bit)
    }

    /// Whether a bit changed from 1 to 0.
    pub(crate) const fn falls(self, before: Self, bit: CwBit) -> bool {
        before.rises(self, bit)
    }

    /// The direction of inching 2: exactly one of bits 14 and 15.
    pub(crate) const fn inching_2(self) -> Option<(CwBit, Direction)> {
        match (self.has(CwBit::Inching2Positive), self.has(CwBit::Inching2Negative)) {
            (true, false) => Some((CwBit::Inching2Positive, Direction::Positive)),
            (false, true) => Some((CwBit::Inching2Negative, Direction::Negative)),
            (true, true) | (false, false) => None,
        }
    }
}

/// The status word 6041h. `remote`: NMT is OPERATIONAL or STOPPED. `acknowledge`: bit 12 in positioning mode.
pub(crate) fn status_word(state: State, status: &Status, remote: bool, acknowledge: bool) -> u16 {
    let positioning = status.mode == Mode::Positioning;
    let enabled = state == State::OperationEnabled;
    state.bits()
        | SwBit::VoltageEnabled.when(status.supply_ok)
        | SwBit::Warning.when(status.warning)
        | SwBit::Ready.when(enabled && status.ready_to_travel && !is_paused(status))
        | SwBit::Remote.when(remote)
        | SwBit::TargetReached.when(if positioning { status.target_reached } else { status.in_window })
        | SwBit::LimitExceeded.when(status.above_upper_limit || status.below_lower_limit)
        | SwBit::Acknowledge.when(if positioning { acknowledge } else { !status.travelling })
        | SwBit::JobActive.when(positioning && is_active(status))
        | SwBit::Moves.when(positioning && status.travelling)
}

/// Whether a job is active; a paused one counts, too.
pub(crate) fn is_active(status: &Status) -> bool {
    status.positioning_active || is_paused(status)
}

const fn is_paused(status: &Status) -> bool {
    matches!(status.state, drive::State::Pausing { .. } | drive::State::Paused { .. })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_distinct_and_in_order() {
        assert!(CwBit::ALL.windows(2).all(|pair| pair[0].number() < pair[1].number()));
        assert!(SwBit::ALL.windows(2).all(|pair| pair[0].number() < pair[1].number()));
        assert_eq!(SwBit::ALL.iter().fold(0, |word, bit| word | bit.mask()), 0xDFFF, "bit 13 is 0");
    }

    #[test]
    fn edges_and_inching_2() {
        let (low, high) = (ControlWord(0x000F), ControlWord(0x001F));
        assert!(high.rises(low, CwBit::NewSetpoint) && low.falls(high, CwBit::NewSetpoint));
        assert!(!high.rises(high, CwBit::NewSetpoint));
        assert_eq!(ControlWord(0xC00F).inching_2(), None);
        assert_eq!(ControlWord(0x800F).inching_2(), Some((CwBit::Inching2Negative, Direction::Negative)));
    }
}
