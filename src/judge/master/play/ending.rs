//! How a judgement ends.

use core::fmt;

use crate::judge::master::rows::Row;
use crate::judge::requirement::{Conclusion, Standing};
use crate::profibus::fdl::Address;
use crate::profibus::fdl::foreign::Foreign;

/// How a judgement ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Everything was tried.
    Done,
    /// A recording was read to its end.
    Read,
    /// A recording is cut off; what is in front of that was judged.
    Cut {
        /// Where and how.
        why: String,
    },
    /// No master came.
    NoMaster,
    /// The master said nothing more.
    Silent {
        /// What was being tried.
        during: String,
        /// The rows that failed by it.
        rows: Vec<Row>,
    },
    /// Nothing but octets that are no telegrams.
    Noise,
    /// Another protocol.
    Foreign(Foreign),
    /// After telegrams, octets without end that are none.
    Flood,
    /// Data exchange with a station was never reached.
    NoExchange {
        /// Which station.
        station: Address,
        /// What the telegrams say of it.
        why: String,
    },
    /// A master of class 2 reads no station.
    NotRead {
        /// What it does instead.
        why: String,
        /// What had been tried; `None`: it never did.
        after: Option<String>,
    },
    /// Data exchange with a station did not come back.
    Lost {
        /// Which station.
        station: Address,
        /// What had been tried.
        after: String,
    },
    /// A row was broken, and the first breach was to end it.
    Breach,
    /// The time was over.
    TimeOver,
    /// Somebody stopped it.
    Stopped,
}

impl Ending {
    /// Whether everything that was to be tried was tried, and a recording was read to its end.
    pub(crate) fn is_complete(&self) -> bool {
        matches!(self.standing(), Standing::Tried | Standing::Read)
    }
}

impl Conclusion for Ending {
    fn standing(&self) -> Standing {
        match self {
            Self::Done => Standing::Tried,
            Self::Read => Standing::Read,
            Self::NoMaster
            | Self::Noise
            | Self::Foreign(_)
            | Self::NoExchange { .. }
            | Self::NotRead { after: None, .. } => Standing::Nothing,
            Self::Cut { .. }
            | Self::Silent { .. }
            | Self::Flood
            | Self::NotRead { after: Some(_), .. }
            | Self::Lost { .. }
            | Self::Breach
            | Self::TimeOver
            | Self::Stopped => Standing::Partial,
        }
    }

    fn explains(&self, id: &str) -> bool {
        match self {
            Self::Silent { rows, .. } => rows.iter().any(|row| row.id() == id),
            Self::Done
            | Self::Read
            | Self::Cut { .. }
            | Self::NoMaster
            | Self::Noise
            | Self::Foreign(_)
            | Self::Flood
            | Self::NoExchange { .. }
            | Self::NotRead { .. }
            | Self::Lost { .. }
            | Self::Breach
            | Self::TimeOver
            | Self::Stopped => false,
        }
    }
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("everything was tried"),
            Self::Read => f.write_str("the capture was read to its end"),
            Self::Cut { why } => write!(f, "the capture is cut off, and was judged as far as it goes: {why}"),
            Self::NoMaster => f.write_str("no master was heard"),
            Self::Silent { during, .. } => {
                write!(f, "the master said nothing more for ten seconds: {during}")
            }
            Self::Noise => f.write_str(
                "only octets that are no telegrams were heard: the sender has another rate or no even parity, or is no PROFIBUS master",
            ),
            Self::Foreign(foreign) => write!(f, "no DP master was heard: {foreign}; {}", foreign.cure()),
            Self::Flood => f.write_str("the master sent telegrams at first and then octets without end that are none"),
            Self::NoExchange { station, why } => {
                write!(f, "data exchange with station {station} was not reached: {why}")
            }
            Self::NotRead { why, after: None } => write!(f, "no station was read: {why}"),
            Self::NotRead { why, after: Some(after) } => {
                write!(f, "no station was read again within the time after: {after}: {why}")
            }
            Self::Lost { station, after } => {
                write!(f, "data exchange with station {station} was not reached again within the time after: {after}")
            }
            Self::Breach => f.write_str("a row was broken, and the first breach was to end it"),
            Self::TimeOver => f.write_str("the time for the judgement was over"),
            Self::Stopped => f.write_str("the judgement was stopped"),
        }
    }
}
