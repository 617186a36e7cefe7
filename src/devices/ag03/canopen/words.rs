//! Control word 6040h and status word 6041h: every bit once, and the words from and to what the drive knows
//! (`canopen-ag03.md` 9.1 and 9.2).
//!
//! ```text
//! 6040h  15    14    13   12..9  8      7      6 5  4      3       2      1        0
//!        inch- inch+ inch1  -    pause  reset   -   start  enable  /quick voltage  switch on
//! 6041h  15    14    13   12     11     10     9    8      7       6      5        4     3      2    1    0
//!        moves job   0    ack    limit  target rem  ready  warning SOD    /quick   volt  fault  OE   SO   RTSO
//! ```

use strum::VariantArray;

use super::state::State;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Direction, Mode, Status};

/// A bit of the control word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray)]
pub(crate) enum CwBit {
    /// Switch on.
    SwitchOn,
    /// Enable voltage (printed "disable voltage").
    EnableVoltage,
    /// Quick stop, active at 0.
    NoQuickStop,
    /// Enable operation.
    EnableOperation,
    /// Positioning: a change from 0 to 1 starts a travel job.
    NewSetpoint,
    /// A change from 0 to 1 acknowledges a fault.
    FaultReset,
    /// Positioning: intermediate stop. Velocity: stop; a change from 1 to 0 starts.
    Stop,
    /// Positioning: a change from 0 to 1 starts inching 1.
    Inching1,
    /// Positioning: inching 2 in positive direction.
    Inching2Positive,
    /// Positioning: inching 2 in negative direction.
    Inching2Negative,
}

impl CwBit {
    /// Every bit, the lowest first.
    pub(crate) const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// The number of the bit, 0 to 15.
    pub(crate) const fn number(self) -> u8 {
        match self {
            Self::SwitchOn => 0,
            Self::EnableVoltage => 1,
            Self::NoQuickStop => 2,
            Self::EnableOperation => 3,
            Self::NewSetpoint => 4,
            Self::FaultReset => 7,
            Self::Stop => 8,
            Self::Inching1 => 13,
            Self::Inching2Positive => 14,
            Self::Inching2Negative => 15,
        }
    }

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

    /// What the manual calls it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::SwitchOn => "switch on",
            Self::EnableVoltage => "enable voltage",
            Self::NoQuickStop => "no quick stop",
            Self::EnableOperation => "enable operation",
            Self::NewSetpoint => "new setpoint",
            Self::FaultReset => "fault reset",
            Self::Stop => "stop",
            Self::Inching1 => "inching 1",
            Self::Inching2Positive => "inching 2 positive",
            Self::Inching2Negative => "inching 2 negative",
        }
    }
}

/// A bit of the status word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray)]
pub(crate) enum SwBit {
    /// Ready to switch on.
    ReadyToSwitchOn,
    /// Switched on.
    SwitchedOn,
    /// Operation enabled.
    OperationEnabled,
    /// Fault.
    Fault,
    /// The supplies are within their tolerance.
    VoltageEnabled,
    /// 0: quick stop is active.
    NoQuickStop,
    /// Switch on disabled.
    SwitchOnDisabled,
    /// A warning is pending.
    Warning,
    /// Ready to travel.
    Ready,
    /// The master has control: NMT is OPERATIONAL or STOPPED.
    Remote,
    /// Positioning: the shaft stands at the target. Velocity: the speed is in the window.
    TargetReached,
    /// Positioning: a limit is exceeded.
    LimitExceeded,
    /// Positioning: the setpoint is acknowledged. Velocity: the shaft stands.
    Acknowledge,
    /// Positioning: a job is active.
    JobActive,
    /// Positioning: the shaft moves.
    Moves,
}

impl SwBit {
    /// Every bit, the lowest first.
    pub(crate) const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// The number of the bit, 0 to 15.
    pub(crate) const fn number(self) -> u8 {
        match self {
            Self::ReadyToSwitchOn => 0,
            Self::SwitchedOn => 1,
            Self::OperationEnabled => 2,
            Self::Fault => 3,
            Self::VoltageEnabled => 4,
            Self::NoQuickStop => 5,
            Self::SwitchOnDisabled => 6,
            Self::Warning => 7,
            Self::Ready => 8,
            Self::Remote => 9,
            Self::TargetReached => 10,
            Self::LimitExceeded => 11,
            Self::Acknowledge => 12,
            Self::JobActive => 14,
            Self::Moves => 15,
        }
    }

    /// What the bit says in a mode.
    pub(crate) const fn name(self, mode: Mode) -> &'static str {
        match (self, mode) {
            (Self::ReadyToSwitchOn, _) => "ready to switch on",
            (Self::SwitchedOn, _) => "switched on",
            (Self::OperationEnabled, _) => "operation enabled",
            (Self::Fault, _) => "fault",
            (Self::VoltageEnabled, _) => "voltage enabled",
            (Self::NoQuickStop, _) => "no quick stop",
            (Self::SwitchOnDisabled, _) => "switch on disabled",
            (Self::Warning, _) => "warning",
            (Self::Ready, _) => "ready to travel",
            (Self::Remote, _) => "remote",
            (Self::TargetReached, Mode::Positioning) => "target reached",
            (Self::TargetReached, Mode::Velocity) => "speed in window",
            (Self::LimitExceeded, _) => "limit exceeded",
            (Self::Acknowledge, Mode::Positioning) => "setpoint acknowledged",
            (Self::Acknowledge, Mode::Velocity) => "standstill",
            (Self::JobActive, _) => "job active",
            (Self::Moves, _) => "shaft moves",
        }
    }

    /// The mask of the bit.
    pub(crate) const fn mask(self) -> u16 {
        1 << self.number()
    }

    const fn when(self, set: bool) -> u16 {
        if set { self.mask() } else { 0 }
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
