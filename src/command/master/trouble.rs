//! [`Trouble`]: why a command of `profidrive master` has failed.

use crate::client::PkwError;
use crate::master::{DriveError, SessionError};
use thiserror::Error;

#[derive(Debug, Error)]
pub(super) enum Trouble {
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// What the drive says, which is not what was asked of it.
    #[error("the drive no longer does it: {0}")]
    Ended(String),
    /// Somebody else changed what it was checked for: nothing was begun.
    #[error("{0}")]
    Changed(String),
    /// It was not seen to stand.
    #[error("{0}")]
    StillTurns(String),
}

impl Trouble {
    /// Whether the drive can no longer be reached.
    pub(super) fn is_loss(&self) -> bool {
        match self {
            Self::Drive(error) => error.is_loss(),
            Self::Ended(_) | Self::Changed(_) | Self::StillTurns(_) => false,
        }
    }

    /// Why a job failed, if it was one.
    pub(super) const fn job(&self) -> Option<PkwError> {
        match self {
            Self::Drive(DriveError::Job(error)) => Some(*error),
            Self::Drive(_) | Self::Ended(_) | Self::Changed(_) | Self::StillTurns(_) => None,
        }
    }
}

impl From<SessionError> for Trouble {
    fn from(error: SessionError) -> Self {
        Self::Drive(error.into())
    }
}
