//! The state machine of the profile (`profidrive-v2.md` 8).
//!
//! ```text
//!        power on, OFF2 from any state, OFF3 at standstill, acknowledged
//!                      │
//!                      ▼                          OFF1 at standstill
//!        S1 switching on inhibited      ┌──────────────────────────────┐
//!                      │ OFF1           ▼                              │
//!                      └───▶ S2 ready for switching on                 │
//!                                       │ ON  ▲ OFF1                   │
//!                                       ▼     │                        │
//!                            S3 ready ◀───────────┐                    │
//!                                       │         │ disable            │
//!                                       ▼ enable  │                    │
//!                            S4 operation ── OFF1, OFF3 ──▶ S5 switching off
//! ```

use core::fmt;

use super::Command;

/// Where a drive is. A fault can come in each and leads to [`State::Fault`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum State {
    /// S1: OFF1 must be given once.
    #[default]
    SwitchingOnInhibited,
    /// S2: waits for ON.
    ReadyToSwitchOn,
    /// S3: switched on, the motor is released.
    Ready,
    /// S4: the motor follows.
    Operation,
    /// S5: the motor brakes.
    SwitchingOff(Off),
    /// A fault is not acknowledged; the motor is released.
    Fault,
}

/// How a drive brakes in S5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Off {
    /// OFF1: on the ramp.
    Off1,
    /// OFF3: with the quick-stop time.
    Off3,
}

impl State {
    /// Every state.
    pub const ALL: [Self; 7] = [
        Self::SwitchingOnInhibited,
        Self::ReadyToSwitchOn,
        Self::Ready,
        Self::Operation,
        Self::SwitchingOff(Off::Off1),
        Self::SwitchingOff(Off::Off3),
        Self::Fault,
    ];

    /// The state after one cycle under this command. `stands`: the shaft stands. A fault and its end are no matter of the
    /// command: see [`Drive`](super::Drive).
    #[must_use]
    pub(crate) const fn next(self, command: &Command, stands: bool) -> Self {
        let Command { on, no_off2, no_off3, enable_operation, .. } = *command;
        match self {
            // Rows 1 and 2.
            Self::SwitchingOnInhibited if !on && no_off2 && no_off3 => Self::ReadyToSwitchOn,
            Self::SwitchingOnInhibited => Self::SwitchingOnInhibited,
            // Rows 3 to 5.
            Self::ReadyToSwitchOn if !no_off2 || !no_off3 => Self::SwitchingOnInhibited,
            Self::ReadyToSwitchOn if on => Self::Ready,
            Self::ReadyToSwitchOn => Self::ReadyToSwitchOn,
            // Rows 6 to 9.
            Self::Ready if !no_off2 || !no_off3 => Self::SwitchingOnInhibited,
            Self::Ready if !on => Self::ReadyToSwitchOn,
            Self::Ready if enable_operation => Self::Operation,
            Self::Ready => Self::Ready,
            // Rows 10 to 14.
            Self::Operation if !no_off2 => Self::SwitchingOnInhibited,
            Self::Operation if !no_off3 => Self::SwitchingOff(Off::Off3),
            Self::Operation if !enable_operation => Self::Ready,
            Self::Operation if !on => Self::SwitchingOff(Off::Off1),
            Self::Operation => Self::Operation,
            // Rows 15 to 19.
            Self::SwitchingOff(_) if !no_off2 => Self::SwitchingOnInhibited,
            Self::SwitchingOff(Off::Off1) if !no_off3 => Self::SwitchingOff(Off::Off3),
            Self::SwitchingOff(Off::Off1) if !enable_operation || stands => Self::ReadyToSwitchOn,
            Self::SwitchingOff(Off::Off3) if !enable_operation || stands => Self::SwitchingOnInhibited,
            Self::SwitchingOff(off) => Self::SwitchingOff(off),
            // Row 20.
            Self::Fault => Self::Fault,
        }
    }

    /// Whether the motor is supplied: its torque follows the speed controller.
    pub(crate) const fn is_supplied(self) -> bool {
        match self {
            Self::Operation | Self::SwitchingOff(_) => true,
            Self::SwitchingOnInhibited | Self::ReadyToSwitchOn | Self::Ready | Self::Fault => false,
        }
    }

    /// Whether the drive is switched on, so that it misses a master that goes.
    pub(crate) const fn is_switched_on(self) -> bool {
        match self {
            Self::Ready | Self::Operation | Self::SwitchingOff(_) => true,
            Self::SwitchingOnInhibited | Self::ReadyToSwitchOn | Self::Fault => false,
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SwitchingOnInhibited => "switching on inhibited",
            Self::ReadyToSwitchOn => "ready for switching on",
            Self::Ready => "switched on",
            Self::Operation => "operation enabled",
            Self::SwitchingOff(Off::Off1) => "switching off, OFF1",
            Self::SwitchingOff(Off::Off3) => "switching off, OFF3",
            Self::Fault => "fault",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INHIBITED: State = State::SwitchingOnInhibited;
    const TO_SWITCH_ON: State = State::ReadyToSwitchOn;
    const OFF1: State = State::SwitchingOff(Off::Off1);
    const OFF3: State = State::SwitchingOff(Off::Off3);

    /// State, then ON, no OFF2, no OFF3, enable operation, stands (`x` = either), and the state that follows. Of the rows
    /// of a state the first that fits holds.
    const TABLE: [(State, &str, State); 23] = [
        (INHIBITED, "011xx", TO_SWITCH_ON),
        (INHIBITED, "xxxxx", INHIBITED),
        (TO_SWITCH_ON, "x0xxx", INHIBITED),
        (TO_SWITCH_ON, "xx0xx", INHIBITED),
        (TO_SWITCH_ON, "1xxxx", State::Ready),
        (TO_SWITCH_ON, "0xxxx", TO_SWITCH_ON),
        (State::Ready, "x0xxx", INHIBITED),
        (State::Ready, "xx0xx", INHIBITED),
        (State::Ready, "0xxxx", TO_SWITCH_ON),
        (State::Ready, "1xx1x", State::Operation),
        (State::Ready, "1xx0x", State::Ready),
        (State::Operation, "x0xxx", INHIBITED),
        (State::Operation, "xx0xx", OFF3),
        (State::Operation, "xxx0x", State::Ready),
        (State::Operation, "0xx1x", OFF1),
        (State::Operation, "1111x", State::Operation),
        (OFF1, "x0xxx", INHIBITED),
        (OFF1, "x10xx", OFF3),
        (OFF1, "x110x", TO_SWITCH_ON),
        (OFF1, "x1111", TO_SWITCH_ON),
        (OFF1, "x1110", OFF1),
        (OFF3, "x1x10", OFF3),
        (State::Fault, "xxxxx", State::Fault),
    ];

    fn expected(state: State, digits: &str) -> Option<State> {
        let fits = |pattern: &str| pattern.chars().zip(digits.chars()).all(|(p, d)| p == 'x' || p == d);
        TABLE.iter().find(|(from, pattern, _)| *from == state && fits(pattern)).map(|row| row.2)
    }

    #[test]
    fn the_whole_transition_table() {
        for state in State::ALL {
            for bits in 0..32_u8 {
                let digits = format!("{bits:05b}");
                let bit = |n: usize| digits.as_bytes()[n] == b'1';
                let command = Command {
                    on: bit(0),
                    no_off2: bit(1),
                    no_off3: bit(2),
                    enable_operation: bit(3),
                    ..Command::default()
                };
                // What no row of OFF3 has inhibits switching on: OFF2, disable operation, standstill.
                let row = expected(state, &digits).unwrap_or(INHIBITED);
                assert_eq!(state.next(&command, bit(4)), row, "{state}: {digits}");
            }
        }
    }
}
