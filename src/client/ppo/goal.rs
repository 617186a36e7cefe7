//! What can be asked of such a drive, and what comes of it.

use core::fmt;
use core::time::Duration;

use thiserror::Error;

use crate::devices::ppo_drive::profile::reasons;
use crate::profibus::ppo::{Stw, Zsw};

/// Something the drive shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PpoGoal {
    /// Operation enabled with setpoint 0: the motor holds zero speed. Done when ZSW shows it.
    Enable,
    /// Turns with this setpoint, 4000h is 100 % of the reference speed, until another goal comes. Done when the actual value
    /// is within 3 % of the reference speed of it.
    Run(i16),
    /// OFF1: brakes on the ramp. Done when the drive is no longer ready or in operation, also with a fault.
    Disable,
    /// The fault acknowledged. Done when ZSW shows no fault, at once if there is none.
    Acknowledge,
}

impl PpoGoal {
    /// The setpoint it leads to.
    pub(super) const fn setpoint(self) -> i16 {
        match self {
            Self::Run(setpoint) => setpoint,
            Self::Enable | Self::Disable | Self::Acknowledge => 0,
        }
    }
}

impl fmt::Display for PpoGoal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Enable => f.write_str("enable"),
            Self::Run(setpoint) => write!(f, "run with setpoint {setpoint} (16384 is 100 %)"),
            Self::Disable => f.write_str("disable"),
            Self::Acknowledge => f.write_str("acknowledge"),
        }
    }
}

/// A goal that is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PpoOutcome {
    /// The goal as given.
    pub goal: PpoGoal,
    /// The actual value when it was reached.
    pub result: Result<i16, PpoGoalError>,
}

/// Why a goal was not reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PpoGoalError {
    /// The drive is in fault.
    #[error("the drive is in fault: read PNU 947.1, remove the cause, acknowledge it")]
    Fault,
    /// The drive has left operation.
    #[error("the drive has left operation by itself: ZSW {zsw}")]
    Ended {
        /// What it shows.
        zsw: Zsw,
    },
    /// It was not done in time.
    #[error("not in time: {}", Shown(*.stw, *.zsw, *.actual))]
    TimedOut {
        /// The control word.
        stw: Stw,
        /// The status word.
        zsw: Zsw,
        /// The actual value.
        actual: i16,
    },
    /// No input image came.
    #[error("no inputs came: the drive is not in Data_Exchange")]
    NoInputs,
    /// Data_Exchange was lost.
    #[error("Data_Exchange was lost")]
    Interrupted,
}

/// The words, and what they say against it.
struct Shown(Stw, Zsw, i16);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(stw, zsw, actual) = *self;
        write!(f, "STW {stw}, ZSW {zsw}, actual value {actual}")?;
        reasons(stw, zsw).try_for_each(|reason| write!(f, "; {reason}"))
    }
}

/// How long goals may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PpoLimits {
    /// A change of state.
    pub reaction: Duration,
    /// To the speed of a setpoint, and to run down on the ramp.
    pub motion: Duration,
}

impl Default for PpoLimits {
    /// 5 s and 10 min.
    fn default() -> Self {
        Self { reaction: Duration::from_secs(5), motion: Duration::from_secs(600) }
    }
}
