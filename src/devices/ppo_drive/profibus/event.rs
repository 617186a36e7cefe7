//! News of a drive of the profile.

use core::fmt;

use crate::devices::ppo_drive;
use crate::devices::ppo_drive::profile::NotFollowed;
use crate::face::{DeviceEvent, EventKind, Reason};
use crate::profibus::pkw;
use crate::profibus::pkw::JobError;

/// What happened in a drive of the profile.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// In the drive.
    Drive(ppo_drive::Event),
    /// A control word was not followed.
    NotFollowed(NotFollowed),
    /// A PKW job was answered with an error number.
    JobRefused(pkw::Refusal),
    /// A word of process data did not get into the parameter that PNU 915 ties to it.
    NotSet {
        /// Which of the words behind the first two, from 0.
        place: usize,
        /// The parameter.
        pnu: u16,
        /// The value.
        value: u16,
        /// Why.
        cause: JobError,
    },
}

impl DeviceEvent for Event {
    fn kind(&self) -> EventKind {
        match self {
            Self::Drive(ppo_drive::Event::Fault(_)) => EventKind::Fault,
            Self::NotFollowed(word) => word.kind(),
            Self::Drive(ppo_drive::Event::InchingRefused) | Self::NotSet { .. } => EventKind::CommandRefused,
            Self::Drive(_) => EventKind::Drive,
            Self::JobRefused(_) => EventKind::JobRefused,
        }
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        if let Self::NotFollowed(word) = self {
            word.each_reason(tell);
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drive(event) => event.fmt(f),
            Self::NotFollowed(word) => word.fmt(f),
            Self::JobRefused(refusal) => refusal.fmt(f),
            Self::NotSet { place, pnu, value, cause } => write!(
                f,
                "process data word {} ({value}) is not set in PNU {pnu}, whose value stays: {cause}; send another value, or \
                 name another parameter in PNU 915.{}",
                place.saturating_add(3),
                place.saturating_add(1)
            ),
        }
    }
}
