//! Breaches of the rules of the bus.

use core::time::Duration;

use thiserror::Error;

use super::Sender;
use crate::profibus::fdl::Address;
use crate::time::{BaudRate, Instant};

/// A rule of the bus that somebody on a [`Line`](super::Line) has broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Breach {
    /// Two send at the same time.
    #[error("at {at}: the {by} sends while another still does")]
    Collision {
        /// When the second began.
        at: Instant,
        /// Who is the second.
        by: Sender,
    },
    /// A request or token without enough silence before it.
    #[error("at {at}: a request after {idle:?} of silence, expected T_SYN, {expected:?}")]
    NoSyn {
        /// When it began.
        at: Instant,
        /// The silence before it.
        idle: Duration,
        /// T_SYN.
        expected: Duration,
    },
    /// A request or token although a reply can still come.
    #[error("at {at}: a request {waited:?} after one without reply, expected the slot time, {expected:?}")]
    NoSlotTime {
        /// When it began.
        at: Instant,
        /// Time since the end of the request before.
        waited: Duration,
        /// The slot time.
        expected: Duration,
    },
    /// A reply although no request waits for one.
    #[error("at {at}: a reply that nobody asked for")]
    Unasked {
        /// When it began.
        at: Instant,
    },
    /// A reply from a station that was not asked, or to a master that did not ask.
    #[error("at {at}: a reply from station {got}, expected one from {expected} to the master that asked")]
    WrongStation {
        /// When it began.
        at: Instant,
        /// Who replied.
        got: Address,
        /// Who was asked.
        expected: Address,
    },
    /// A reply before min T_SDR.
    #[error("at {at}: a reply {after:?} after its request, expected not before min T_SDR, {expected:?}")]
    TooEarly {
        /// When it began.
        at: Instant,
        /// Time since the end of the request.
        after: Duration,
        /// min T_SDR, 11 T_bit.
        expected: Duration,
    },
    /// A reply after max T_SDR.
    #[error("at {at}: a reply {after:?} after its request, expected at most max T_SDR, {expected:?}")]
    TooLate {
        /// When it began.
        at: Instant,
        /// Time since the end of the request.
        after: Duration,
        /// max T_SDR by the customary table.
        expected: Duration,
    },
    /// Octets that are not one telegram.
    #[error("at {at}: the {by} sends what is not one telegram")]
    NoTelegram {
        /// When it began.
        at: Instant,
        /// Who sent them.
        by: Sender,
    },
    /// A station sent at another rate than that of the line: its search for the rate was not over.
    #[error("at {at}: a station sends at {got}, expected {expected}")]
    WrongRate {
        /// When it began.
        at: Instant,
        /// Its rate.
        got: BaudRate,
        /// The rate of the line.
        expected: BaudRate,
    },
}

impl Breach {}
