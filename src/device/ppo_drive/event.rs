//! News of a drive of the profile.

use core::fmt;

use crate::{pkw, ppo_drive};

/// What happened in a drive of the profile.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// In the drive.
    Drive(ppo_drive::Event),
    /// A PKW job was answered with an error number.
    JobRefused(pkw::Refusal),
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drive(event) => event.fmt(f),
            Self::JobRefused(refusal) => refusal.fmt(f),
        }
    }
}
