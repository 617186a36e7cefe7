//! Why a job brought nothing.

use core::fmt;
use core::time::Duration;

use thiserror::Error;

use crate::profibus::pkw::ErrorNumber;
use crate::profibus::ppo::Pkw;

/// Why a job was not carried out, or why that is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PkwError {
    /// The drive refused it, reply 7. Nothing was changed.
    #[error("the drive refused the job: {0}")]
    Refused(ErrorCode),
    /// The drive gives the bus no right to change parameters, reply 8. Nothing was changed.
    #[error("the drive refused the job: the parameter channel has no control rights")]
    NoControlRights,
    /// The reply did not come within the limit. At [`Stage::Reply`] the drive may have carried the job out, or may
    /// still do so: read a written value back.
    #[error("{stage} did not come {limit}{}", Last(*.last))]
    TimedOut {
        /// What was waited for.
        stage: Stage,
        /// Which limit of the [`Profile`](super::Profile) ended the job.
        limit: Limit,
        /// The last PKW seen since the job was submitted.
        last: Option<Pkw>,
    },
    /// Data_Exchange was lost before the reply. The drive may have carried the job out: read a written value back.
    #[error("Data_Exchange was lost before the drive replied")]
    Interrupted,
}

impl PkwError {
    /// Whether it is certain that the drive did not carry the job out and will not do so later.
    pub const fn is_certain(self) -> bool {
        match self {
            Self::Refused(_) | Self::NoControlRights => true,
            Self::TimedOut { stage: Stage::NoReply | Stage::Probe, .. } => true,
            Self::TimedOut { stage: Stage::Reply, .. } | Self::Interrupted => false,
        }
    }
}

/// What a job waits for, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// For reply 0 to job 0. The job itself was not sent yet.
    NoReply,
    /// For the reply to a probe. The job itself was not sent yet.
    Probe,
    /// For the reply to the job.
    Reply,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoReply => "the empty reply to job 0, before the job was sent,",
            Self::Probe => "the reply to a probe, before the job was sent,",
            Self::Reply => "the reply to the job",
        })
    }
}

/// What ended a job that was not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limit {
    /// The time of the profile.
    Time(Duration),
    /// The number of input images of the profile.
    Exchanges(u32),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(time) => write!(f, "within {time:?}"),
            Self::Exchanges(exchanges) => write!(f, "within {exchanges} exchanges"),
        }
    }
}

/// The end of the text of a timeout.
struct Last(Option<Pkw>);

impl fmt::Display for Last {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(pkw) => write!(f, "; the last PKW was {pkw} ({}, PNU {})", pkw.pke.reply(), pkw.pke.pnu()),
            None => f.write_str("; there was no input image at all"),
        }
    }
}

/// The number in a reply "job not executable".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorCode {
    /// One of PROFIDRIVE version 2, 0 to 19.
    Known(ErrorNumber),
    /// A number of the vendor, or of a later profile.
    Vendor(u16),
}

impl ErrorCode {
    /// The code with this number.
    pub(crate) fn from_number(number: u16) -> Self {
        ErrorNumber::from_number(number).map_or(Self::Vendor(number), Self::Known)
    }

    /// The number in word 4.
    pub const fn number(self) -> u16 {
        match self {
            Self::Known(known) => known.number(),
            Self::Vendor(number) => number,
        }
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(known) => fmt::Display::fmt(known, f),
            Self::Vendor(number) => {
                write!(
                    f,
                    "error {number}, which PROFIDRIVE version 2 does not define: see the drive's manual"
                )
            }
        }
    }
}
