//! How a judgement of a device ends.

use core::fmt;

use crate::judge::requirement::{Conclusion, Standing};

/// How a judgement of a device ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Everything was tried.
    Done,
    /// Nobody answered.
    NoDevice,
    /// The device answers, and never exchanges data.
    NoExchange {
        /// What it does instead.
        why: String,
    },
    /// The device said nothing more.
    Died {
        /// The row that was tried.
        during: &'static str,
    },
    /// The device sends without end and without being asked.
    Babbles {
        /// The row that was tried.
        during: &'static str,
    },
    /// The device could not be brought back to where a row begins.
    Stuck {
        /// The row that was tried.
        during: &'static str,
    },
    /// The line no longer works.
    Broken {
        /// What the operating system says of it.
        why: String,
    },
    /// The time was over.
    TimeOver,
    /// Somebody stopped it.
    Stopped,
}

impl Conclusion for Ending {
    fn standing(&self) -> Standing {
        match self {
            Self::Done => Standing::Tried,
            Self::NoDevice | Self::NoExchange { .. } => Standing::Nothing,
            Self::Died { .. }
            | Self::Stuck { .. }
            | Self::Babbles { .. }
            | Self::Broken { .. }
            | Self::TimeOver
            | Self::Stopped => Standing::Partial,
        }
    }
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("everything was tried"),
            Self::NoDevice => f.write_str("nobody answered at this address"),
            Self::NoExchange { why } => write!(f, "data exchange was not reached: {why}"),
            Self::Died { during } => write!(f, "the device said nothing more when {during} was tried"),
            Self::Babbles { during } => {
                write!(f, "the device sent without end and without being asked when {during} was tried")
            }
            Self::Stuck { during } => {
                write!(f, "the device could not be brought back to its beginning after {during} was tried")
            }
            Self::Broken { why } => write!(f, "the line no longer works: {why}"),
            Self::TimeOver => f.write_str("the time for the judgement was over"),
            Self::Stopped => f.write_str("the judgement was stopped"),
        }
    }
}
