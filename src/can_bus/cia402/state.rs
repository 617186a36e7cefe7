//! States of a drive and the table of transitions.

use core::fmt;

use strum::VariantArray;

use super::words::Statusword;

/// A state of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray)]
pub enum State {
    /// The drive initialises itself.
    NotReadyToSwitchOn,
    /// Parameters may be set; the power part must not be switched on.
    SwitchOnDisabled,
    /// The power part may be switched on.
    ReadyToSwitchOn,
    /// The power part is on, the motor has no torque.
    SwitchedOn,
    /// The motor has torque.
    OperationEnabled,
    /// A quick stop runs or holds the motor.
    QuickStopActive,
    /// A fault happened, its reaction runs.
    FaultReactionActive,
    /// A fault waits for its reset; the motor has no torque.
    Fault,
}

/// A command of the controlword.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// xxxx x110.
    Shutdown,
    /// xxxx 0111. In [`State::OperationEnabled`] it is disable operation.
    SwitchOn,
    /// xxxx 1111.
    EnableOperation,
    /// xxxx xx0x.
    DisableVoltage,
    /// xxxx x01x.
    QuickStop,
    /// Bit 7 rises.
    FaultReset,
}

/// What moves the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// The drive is initialised.
    Initialised,
    /// The controlword says so.
    Command(Command),
    /// A quick stop that does not stay is done.
    QuickStopDone,
    /// A fault happened.
    Fault,
    /// The reaction to it is done.
    FaultReactionDone,
}

/// A transition with its number in CiA 402. Number 0 and 1 are the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Transition(pub u8);

impl State {
    /// Every state.
    pub const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// The transition that `event` causes, `None` if the drive stays where it is.
    pub(crate) const fn next(self, event: Event) -> Option<(Transition, Self)> {
        let (number, to) = match (self, event) {
            (Self::NotReadyToSwitchOn, Event::Initialised) => (1, Self::SwitchOnDisabled),
            (Self::SwitchOnDisabled, Event::Command(Command::Shutdown)) => (2, Self::ReadyToSwitchOn),
            (Self::ReadyToSwitchOn, Event::Command(Command::SwitchOn)) => (3, Self::SwitchedOn),
            (Self::SwitchedOn, Event::Command(Command::EnableOperation)) => (4, Self::OperationEnabled),
            (Self::OperationEnabled, Event::Command(Command::SwitchOn)) => (5, Self::SwitchedOn),
            (Self::SwitchedOn, Event::Command(Command::Shutdown)) => (6, Self::ReadyToSwitchOn),
            (Self::ReadyToSwitchOn, Event::Command(Command::QuickStop | Command::DisableVoltage)) => {
                (7, Self::SwitchOnDisabled)
            }
            (Self::OperationEnabled, Event::Command(Command::Shutdown)) => (8, Self::ReadyToSwitchOn),
            (Self::OperationEnabled, Event::Command(Command::DisableVoltage)) => (9, Self::SwitchOnDisabled),
            (Self::SwitchedOn, Event::Command(Command::QuickStop | Command::DisableVoltage)) => {
                (10, Self::SwitchOnDisabled)
            }
            (Self::OperationEnabled, Event::Command(Command::QuickStop)) => (11, Self::QuickStopActive),
            (Self::QuickStopActive, Event::Command(Command::DisableVoltage) | Event::QuickStopDone) => {
                (12, Self::SwitchOnDisabled)
            }
            (
                Self::NotReadyToSwitchOn
                | Self::SwitchOnDisabled
                | Self::ReadyToSwitchOn
                | Self::SwitchedOn
                | Self::OperationEnabled
                | Self::QuickStopActive,
                Event::Fault,
            ) => (13, Self::FaultReactionActive),
            (Self::FaultReactionActive, Event::FaultReactionDone) => (14, Self::Fault),
            (Self::Fault, Event::Command(Command::FaultReset)) => (15, Self::SwitchOnDisabled),
            (Self::QuickStopActive, Event::Command(Command::EnableOperation)) => (16, Self::OperationEnabled),
            (
                Self::NotReadyToSwitchOn
                | Self::SwitchOnDisabled
                | Self::ReadyToSwitchOn
                | Self::SwitchedOn
                | Self::OperationEnabled
                | Self::QuickStopActive
                | Self::FaultReactionActive
                | Self::Fault,
                Event::Initialised
                | Event::Command(
                    Command::Shutdown
                    | Command::SwitchOn
                    | Command::EnableOperation
                    | Command::DisableVoltage
                    | Command::QuickStop
                    | Command::FaultReset,
                )
                | Event::QuickStopDone
                | Event::Fault
                | Event::FaultReactionDone,
            ) => return None,
        };
        Some((Transition(number), to))
    }

    /// What a master sends in this state until operation is enabled, in words.
    pub(crate) const fn to_enable(self) -> &'static str {
        match self {
            Self::NotReadyToSwitchOn | Self::SwitchOnDisabled => "send 6040h = 0006h, then 0007h, then 000Fh",
            Self::ReadyToSwitchOn => "send 6040h = 0007h, then 000Fh",
            Self::SwitchedOn => "send 6040h = 000Fh",
            Self::OperationEnabled => "operation is enabled",
            Self::QuickStopActive => "send 6040h = 0000h, then 0006h, then 0007h, then 000Fh",
            Self::FaultReactionActive | Self::Fault => "send 6040h = 0080h (bit 7 from 0 to 1)",
        }
    }

    /// Bits 0 to 3, 5 and 6 of the statusword.
    pub(crate) const fn bits(self) -> Statusword {
        Statusword(match self {
            Self::NotReadyToSwitchOn => 0x00,
            Self::SwitchOnDisabled => 0x40,
            Self::ReadyToSwitchOn => 0x21,
            Self::SwitchedOn => 0x23,
            Self::OperationEnabled => 0x27,
            Self::QuickStopActive => 0x07,
            Self::FaultReactionActive => 0x0F,
            Self::Fault => 0x08,
        })
    }

    /// The state that a statusword tells; `None` for a pattern that is none.
    pub(crate) const fn of(word: Statusword) -> Option<Self> {
        Some(match (word.0 & 0x4F, word.0 & 0x6F) {
            (0x00, _) => Self::NotReadyToSwitchOn,
            (0x40, _) => Self::SwitchOnDisabled,
            (0x0F, _) => Self::FaultReactionActive,
            (0x08, _) => Self::Fault,
            (_, 0x21) => Self::ReadyToSwitchOn,
            (_, 0x23) => Self::SwitchedOn,
            (_, 0x27) => Self::OperationEnabled,
            (_, 0x07) => Self::QuickStopActive,
            (_, _) => return None,
        })
    }

    /// Whether the motor has torque.
    pub(crate) const fn is_powered(self) -> bool {
        match self {
            Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive => true,
            Self::NotReadyToSwitchOn
            | Self::SwitchOnDisabled
            | Self::ReadyToSwitchOn
            | Self::SwitchedOn
            | Self::Fault => false,
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotReadyToSwitchOn => "not ready to switch on",
            Self::SwitchOnDisabled => "switch on disabled",
            Self::ReadyToSwitchOn => "ready to switch on",
            Self::SwitchedOn => "switched on",
            Self::OperationEnabled => "operation enabled",
            Self::QuickStopActive => "quick stop active",
            Self::FaultReactionActive => "fault reaction active",
            Self::Fault => "fault",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVENTS: [Event; 10] = [
        Event::Initialised,
        Event::Command(Command::Shutdown),
        Event::Command(Command::SwitchOn),
        Event::Command(Command::EnableOperation),
        Event::Command(Command::DisableVoltage),
        Event::Command(Command::QuickStop),
        Event::Command(Command::FaultReset),
        Event::QuickStopDone,
        Event::Fault,
        Event::FaultReactionDone,
    ];

    /// Rows: states as in `State::ALL`. Columns: events as in `EVENTS`. The letter is the state that follows, the
    /// number the transition; `-` stays.
    const TABLE: &str = "
              init  shut  on    enab  volt  quick reset qdone fault rdone
        N     D1    -     -     -     -     -     -     -     X13   -
        D     -     R2    -     -     -     -     -     -     X13   -
        R     -     -     S3    -     D7    D7    -     -     X13   -
        S     -     R6    -     E4    D10   D10   -     -     X13   -
        E     -     R8    S5    -     D9    Q11   -     -     X13   -
        Q     -     -     -     E16   D12   -     -     D12   X13   -
        X     -     -     -     -     -     -     -     -     -     F14
        F     -     -     -     -     -     -     D15   -     -     -
    ";

    #[test]
    fn the_whole_table_of_transitions() {
        let state = |letter: &str| State::ALL["NDRSEQXF".find(letter).unwrap()];
        let rows: std::vec::Vec<_> = TABLE.lines().filter(|line| !line.trim().is_empty()).skip(1).collect();
        assert_eq!(rows.len(), State::ALL.len());
        for row in rows {
            let mut cells = row.split_whitespace();
            let from = state(cells.next().unwrap());
            for event in EVENTS {
                let expected = match cells.next().unwrap() {
                    "-" => None,
                    cell => Some((Transition(cell[1..].parse().unwrap()), state(&cell[..1]))),
                };
                assert_eq!(from.next(event), expected, "{from}, {event:?}");
            }
        }
    }

    #[test]
    fn a_statusword_tells_its_state() {
        for state in State::ALL {
            for other in [0x0000, 0xFF90] {
                assert_eq!(State::of(Statusword(state.bits().0 | other)), Some(*state));
            }
        }
        assert_eq!(State::of(Statusword(0x0001)), None);
    }

    #[test]
    fn the_bits_of_each_state_tell_it_apart() {
        for &state in State::ALL {
            let mask = match state {
                State::NotReadyToSwitchOn
                | State::SwitchOnDisabled
                | State::FaultReactionActive
                | State::Fault => 0x4F,
                State::ReadyToSwitchOn
                | State::SwitchedOn
                | State::OperationEnabled
                | State::QuickStopActive => 0x6F,
            };
            for &other in State::ALL {
                assert_eq!(other.bits().0 & mask == state.bits().0, other == state, "{state}, {other}");
            }
        }
    }
}
