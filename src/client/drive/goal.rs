//! What can be asked of the drive, and what comes of it.

use core::fmt;
use core::time::Duration;

use thiserror::Error;

use super::obstacle::Obstacles;
use crate::client::PkwError;
use crate::client::course::Time;
use crate::devices::ag03::drive::{Direction, Mode};

/// Something the drive shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Goal {
    /// Operation enabled: the motor holds its position. Done when ZSW shows it. Leaves turn-on disabled if need be.
    Enable,
    /// The fault acknowledged and turn-on disabled left: ready-to-run, with STW = 0000. Done at once if there is no
    /// fault. Enabling comes after.
    Acknowledge,
    /// A travel job to a position (positioning mode; increments, or 0.01 mm with a spindle pitch). Done when the drive
    /// stands in the window of the target.
    MoveTo(i32),
    /// The travel job interrupted: the drive brakes with its programmed deceleration and keeps the job. Done when the
    /// shaft stands.
    Pause,
    /// The interrupted travel job continued. Done as [`Goal::MoveTo`] is.
    Resume,
    /// Standing still: a travel job is discarded with maximum deceleration, inching ends, a velocity runs down, and
    /// operation stays enabled if it was. A released shaft runs out. Done when the shaft stands, also with a fault.
    Stop,
    /// Inching 1: once by delta inch, PNU 1019, whose sign is the direction (positioning mode). Done when it stands.
    Inch,
    /// Inching 2: turns with v-Inch until another goal comes (positioning mode). Done when the shaft turns.
    Jog(Direction),
    /// Turns with a velocity in rpm until it shall stop, be disabled, or turn otherwise (velocity mode). Done when it is
    /// at speed: within PNU 1009 of it, and in its direction; with 0 when the shaft stands.
    Velocity(i32),
    /// Operation no longer enabled: brakes with maximum deceleration and stands, held. Done when the shaft stands in
    /// ready-to-run, or as little enabled with a fault, turn-on disabled or no supply.
    Disable,
}

impl Goal {
    /// The operating mode it needs.
    pub(super) const fn mode(self) -> Option<Mode> {
        match self {
            Self::MoveTo(_) | Self::Pause | Self::Resume | Self::Inch | Self::Jog(_) => {
                Some(Mode::Positioning)
            }
            Self::Velocity(_) => Some(Mode::Velocity),
            Self::Enable | Self::Acknowledge | Self::Stop | Self::Disable => None,
        }
    }

    /// Whether it puts the shaft in motion, so that operation must be enabled before.
    pub(super) const fn moves(self) -> bool {
        match self {
            Self::MoveTo(_) | Self::Resume | Self::Inch | Self::Jog(_) | Self::Velocity(_) => true,
            Self::Enable | Self::Acknowledge | Self::Pause | Self::Stop | Self::Disable => false,
        }
    }

    /// The position it leads to.
    pub(super) const fn target(self) -> Option<i32> {
        match self {
            Self::MoveTo(target) => Some(target),
            Self::Enable
            | Self::Acknowledge
            | Self::Pause
            | Self::Resume
            | Self::Stop
            | Self::Inch
            | Self::Jog(_)
            | Self::Velocity(_)
            | Self::Disable => None,
        }
    }

    /// The velocity it leads to.
    pub(super) const fn rpm(self) -> Option<i32> {
        match self {
            Self::Velocity(rpm) => Some(rpm),
            Self::Enable
            | Self::Acknowledge
            | Self::MoveTo(_)
            | Self::Pause
            | Self::Resume
            | Self::Stop
            | Self::Inch
            | Self::Jog(_)
            | Self::Disable => None,
        }
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Enable => f.write_str("enable"),
            Self::Acknowledge => f.write_str("acknowledge"),
            Self::MoveTo(target) => write!(f, "move to {target}"),
            Self::Pause => f.write_str("pause"),
            Self::Resume => f.write_str("resume"),
            Self::Stop => f.write_str("stop"),
            Self::Inch => f.write_str("inch"),
            Self::Jog(direction) => write!(f, "jog in {direction} direction"),
            Self::Velocity(rpm) => write!(f, "velocity {rpm} rpm"),
            Self::Disable => f.write_str("disable"),
        }
    }
}

/// A goal that is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GoalOutcome {
    /// The goal as given.
    pub goal: Goal,
    /// HIW when it was reached: the position, in velocity mode the velocity in rpm.
    pub result: Result<i32, GoalError>,
}

/// Why a goal was not reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum GoalError {
    /// The drive did not do it. [`Obstacles`] says what is in the way, as far as it shows.
    #[error(transparent)]
    Refused(#[from] Obstacles),
    /// Data_Exchange was lost. A drive that loses it switches off; nothing starts by itself when it returns.
    #[error("Data_Exchange was lost")]
    Interrupted,
    /// The parameter channel, which the client needs for it, does not work.
    #[error("the parameter channel does not work: {0}")]
    Parameter(PkwError),
}

/// How long goals may take. [`DriveClient`](super::DriveClient) says what happens then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// To everything but the motion itself: preparing it, its start, enabling. Also how long images may stay away
    /// while a goal is pursued.
    pub reaction: Duration,
    /// From the start of a motion to its end, or to its speed; to run down for a stop. A last resort: a travel through
    /// the default limits takes 42 min with the default v-Pos.
    pub motion: Duration,
    /// To find out why a goal was not reached.
    pub explanation: Duration,
}

impl Limits {
    pub(super) const fn of(&self, time: Time) -> Duration {
        match time {
            Time::Reaction => self.reaction,
            Time::Motion => self.motion,
        }
    }
}

impl Default for Limits {
    /// 5 s, 1 h and 2 s.
    fn default() -> Self {
        Self {
            reaction: Duration::from_secs(5),
            motion: Duration::from_secs(3600),
            explanation: Duration::from_secs(2),
        }
    }
}
