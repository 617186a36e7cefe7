//! What is asked of a drive on CANopen, and what comes of it.

use core::time::Duration;

use thiserror::Error;

use crate::can_bus::canopen::{Abort, Address};
use crate::can_bus::cia402::{Mode, State};

/// How long what may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeLimits {
    /// An answer to SDO.
    pub answer: Duration,
    /// A state, an acknowledge.
    pub reaction: Duration,
    /// A travel, and running down.
    pub motion: Duration,
    /// The life time that the node supervises while the drive is enabled.
    pub life: Duration,
}

impl Default for NodeLimits {
    /// 500 ms, 2 s, 10 minutes, 1 s.
    fn default() -> Self {
        Self {
            answer: Duration::from_millis(500),
            reaction: Duration::from_secs(2),
            motion: Duration::from_secs(600),
            life: Duration::from_secs(1),
        }
    }
}

/// What is wanted of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeGoal {
    /// Operation enabled and guarded, in the mode that the drive has.
    Enable,
    /// Its shaft at this position, standing.
    MoveTo(i32),
    /// Homed by the method in 6098h; the mode is put back by [`Leave`](Self::Leave).
    Home,
    /// Turning with this velocity until something else is asked; the mode is put back by [`Leave`](Self::Leave).
    Turn {
        /// 6060h of it.
        mode: Mode,
        /// The entry of the velocity: 60FFh, or 6042h with 16 bits.
        target: Address,
        /// In the unit of that entry.
        velocity: i32,
    },
    /// Inching until something else is asked, in mode 1; the mode is put back by [`Leave`](Self::Leave).
    Inch {
        /// The control word by which the device inches.
        word: u16,
    },
    /// No fault: it is acknowledged.
    Acknowledge,
    /// Quick stop, standing, then without torque.
    Stop,
    /// Everything as before: no torque, no guarding, the NMT state.
    Leave,
}

/// What has come of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeOutcome {
    /// The value of an entry: octets, the first so many.
    Read([u8; MOST_OCTETS], usize),
    /// The entry has the value.
    Written,
    /// The goal is reached.
    Done,
    /// It cannot be done.
    Failed(NodeTrouble),
}

/// The most octets of a value that [`NodeOutcome::Read`] gives; longer ones are cut.
pub(crate) const MOST_OCTETS: usize = 64;

/// Why something cannot be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NodeTrouble {
    /// The node refuses an entry.
    #[error("{at} is refused: {code}")]
    Refused {
        /// Which.
        at: Address,
        /// Why.
        code: Abort,
    },
    /// No answer to SDO.
    #[error("no answer to the access to {at}: is the node there, and not in STOPPED?")]
    NoAnswer {
        /// Which entry.
        at: Address,
    },
    /// The node does not follow NMT.
    #[error("the node does not become OPERATIONAL")]
    NotOperational,
    /// The drive has a fault.
    #[error("the drive has a fault, status word {status:04X}h: clear it first")]
    Fault {
        /// 6041h.
        status: u16,
    },
    /// The drive does not go to positions.
    #[error("the drive is in mode {mode}, which cannot travel to a position: write 1 to 6060h first")]
    Mode {
        /// 6060h.
        mode: i8,
    },
    /// A state did not come.
    #[error("the drive stays in '{state}', status word {status:04X}h: is its supply there?")]
    Stays {
        /// Where it is.
        state: State,
        /// 6041h.
        status: u16,
    },
    /// The travel is not begun.
    #[error(
        "the drive does not acknowledge the target, status word {status:04X}h: it may be beyond a limit, or the drive is not ready to travel"
    )]
    NotAcknowledged {
        /// 6041h.
        status: u16,
    },
    /// The target was not reached.
    #[error("the target was not reached in time, status word {status:04X}h")]
    NotReached {
        /// 6041h.
        status: u16,
    },
    /// The homing ended with an error.
    #[error("the homing failed, status word {status:04X}h: 6098h says by which method, 0 is none")]
    Homing {
        /// 6041h.
        status: u16,
    },
    /// The drive left operation during a travel.
    #[error("the drive has left operation and is in '{state}', status word {status:04X}h")]
    Ended {
        /// Where it is.
        state: State,
        /// 6041h.
        status: u16,
    },
}
