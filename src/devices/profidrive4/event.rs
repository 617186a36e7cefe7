//! News of the drive.

use core::fmt;

use super::{Fault, Warnings};
use crate::devices::ppo_drive::State;

/// Something that happened in the drive. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The state is another one.
    State(State),
    /// A fault came.
    Fault(Fault),
    /// The faults were acknowledged.
    Acknowledged,
    /// A warning came.
    Warning(u16),
    /// ON came while the drive brakes with OFF1.
    OnWhileSwitchingOff,
    /// Jogging was asked for and is not begun: the shaft turns, or the setpoint is not locked.
    JogRefused,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State(state) => write!(f, "state: {state}"),
            Self::Fault(fault) => write!(
                f,
                "fault {fault}; next: remove its cause, acknowledge it (STW1 bit 7 from 0 to 1), then OFF1"
            ),
            Self::Acknowledged => f.write_str("faults acknowledged; next: OFF1 (STW1 bit 0 = 0), then ON"),
            Self::Warning(number) => write!(f, "warning {number}: {}", Warnings::words(*number)),
            Self::OnWhileSwitchingOff => f.write_str(
                "ON came while the drive switches off (OFF1): it switches on again when the shaft stands; next: OFF1 (STW1 \
                 bit 0 = 0) if it shall stay off",
            ),
            Self::JogRefused => {
                f.write_str("jogging is not begun: the shaft must stand and STW1 bits 4, 5, 6 must be 0")
            }
        }
    }
}
