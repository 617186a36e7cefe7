//! News of the drive.

use core::fmt;

use super::{Fault, Origin, Warnings};
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
    /// Referencing begins.
    Homing,
    /// The position has a reference.
    Referenced,
    /// The reference is not set: the axis has something to do.
    ReferenceRefused,
    /// The edge of the probe came too far from the reference position: nothing is corrected.
    MarkOutside,
    /// A motion to a target begins.
    Travel {
        /// Who asked for it.
        by: Origin,
    },
    /// The setpoint is at its target.
    Arrived,
    /// A task is not begun: the axis jogs or is being referenced.
    TaskRefused,
    /// A task is not begun: the position has no reference.
    NotReferenced,
    /// A task is not begun: its target is beyond a software limit.
    BeyondLimit,
    /// There is no traversing block of this number, or blocks follow each other without end and without motion.
    NoBlock {
        /// Which.
        number: i32,
    },
    /// A traversing block ended and the master did not ask for the next one.
    NoChange {
        /// Which.
        number: i32,
    },
}

impl Event {
    /// Whether the drive does not do what it was asked for.
    pub(crate) const fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::JogRefused
                | Self::ReferenceRefused
                | Self::MarkOutside
                | Self::TaskRefused
                | Self::NotReferenced
                | Self::BeyondLimit
                | Self::NoBlock { .. }
                | Self::NoChange { .. }
        )
    }
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
            Self::JogRefused => f.write_str(
                "jogging is not begun: the shaft must stand, with a speed setpoint STW1 bits 4, 5, 6 must be 0; a positioning \
                 drive must have no task",
            ),
            Self::Homing => f.write_str("referencing begins"),
            Self::Referenced => f.write_str("the position has a reference"),
            Self::ReferenceRefused => {
                f.write_str("the reference is not set: the axis must stand and have no task; next: end the task")
            }
            Self::MarkOutside => f.write_str(
                "flying referencing: the probe is farther from the reference position than the outer window, nothing is corrected; \
                 next: check PNU 2599 and 2602",
            ),
            Self::Travel { by: Origin::Mdi } => f.write_str("travel to the target of the master"),
            Self::Travel { by: Origin::Jog } => f.write_str("travel of a jog"),
            Self::Travel { by: Origin::Block(number) } => write!(f, "travel of traversing block {number}"),
            Self::Arrived => f.write_str("the travel is done"),
            Self::TaskRefused => f.write_str(
                "the task is not begun: the axis jogs or is being referenced; next: end that (STW1 bits 8, 9, 11 = 0)",
            ),
            Self::NotReferenced => f.write_str(
                "the task is not begun: the position has no reference; next: reference the axis (STW1 bit 11) or set the \
                 reference",
            ),
            Self::BeyondLimit => f.write_str(
                "the task is not begun: its target is beyond a software limit (PNU 2580, 2581); next: send another target",
            ),
            Self::NoBlock { number } => write!(
                f,
                "the task is not begun: there is no traversing block {number}, or no motion behind it; next: check PNU 2616 \
                 and 2621"
            ),
            Self::NoChange { number } => write!(
                f,
                "traversing block {number} ended and no external change was asked for (STW1 bit 13); next: begin again"
            ),
        }
    }
}
