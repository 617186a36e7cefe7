//! What is being tried, and how a judgement ends.

use core::fmt;
use core::time::Duration;
use std::string::String;

use crate::profibus::fdl::Address;

/// What is being tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The number of the scenario, from 1 on.
    pub number: usize,
    /// How many there are.
    pub of: usize,
    /// What is tried.
    pub name: String,
    /// How long all that is left takes, about.
    pub left: Duration,
}

/// How a judgement ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Everything was tried.
    Done,
    /// No master came.
    NoMaster,
    /// The master said nothing more.
    Silent {
        /// What was being tried.
        during: String,
    },
    /// Nothing but octets that are no telegrams.
    Noise,
    /// After telegrams, octets without end that are none.
    Flood,
    /// Data exchange with a station was not reached, or did not come back.
    NoExchange {
        /// Which station.
        station: Address,
        /// What had been tried.
        after: String,
    },
    /// The time was over.
    TimeOver,
    /// Somebody stopped it.
    Stopped,
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("everything was tried"),
            Self::NoMaster => f.write_str("no master was heard"),
            Self::Silent { during } => write!(f, "the master said nothing more for ten seconds: {during}"),
            Self::Noise => f.write_str(
                "only octets that are no telegrams were heard: the sender has another rate or no even parity, or is no PROFIBUS master",
            ),
            Self::Flood => f.write_str("the master sent telegrams at first and then octets without end that are none"),
            Self::NoExchange { station, after } => {
                write!(f, "data exchange with station {station} was not reached within the time: {after}")
            }
            Self::TimeOver => f.write_str("the time for the judgement was over"),
            Self::Stopped => f.write_str("the judgement was stopped"),
        }
    }
}
