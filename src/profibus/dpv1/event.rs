//! News of the services of DP-V1, each a line of plain English.

use core::fmt;

use super::connection::AbortReason;
use super::identification::FIRST;
use super::{AlarmHead, CALL_INDEX, Channel, ErrorCode, Failure, Function, WithCure};
use crate::profibus::fdl::Address;

/// Something that the log or the application wants to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// A record was read.
    Read {
        /// By whom.
        master: Address,
        /// On which way.
        channel: Channel,
        /// Which slot.
        slot: u8,
        /// Which record.
        index: u8,
        /// How many octets.
        len: u8,
    },
    /// A record was written.
    Written {
        /// By whom.
        master: Address,
        /// On which way.
        channel: Channel,
        /// Which slot.
        slot: u8,
        /// Which record.
        index: u8,
        /// How many octets.
        len: u8,
    },
    /// A block of identification was asked for, read or written.
    Identified {
        /// By whom.
        master: Address,
        /// Which slot.
        slot: u8,
        /// Which block, 0 for I&M0.
        block: u16,
        /// It was written.
        written: bool,
    },
    /// A service was refused.
    Refused {
        /// To whom.
        master: Address,
        /// On which way.
        channel: Channel,
        /// The function number asked for.
        function: u8,
        /// Slot and index, if the service has them.
        place: Option<(u8, u8)>,
        /// Why.
        failure: Failure,
    },
    /// The owner has read an alarm.
    AlarmDelivered {
        /// The owner.
        master: Address,
        /// Which.
        alarm: AlarmHead,
    },
    /// The owner has acknowledged an alarm.
    AlarmAcknowledged {
        /// The owner.
        master: Address,
        /// Which.
        alarm: AlarmHead,
    },
    /// A connection is open.
    Opened {
        /// Whose.
        master: Address,
        /// Its SAP.
        sap: u8,
    },
    /// A connection has ended.
    Ended {
        /// Whose.
        master: Address,
        /// Its SAP.
        sap: u8,
        /// Why.
        why: Closed,
    },
    /// The owner sent parameters with Set_Ext_Prm.
    ExtPrm {
        /// The owner.
        master: Address,
        /// How many octets.
        len: u8,
        /// Where the first block is whose length does not fit: the slave waits for Set_Prm then. `None`: all fit.
        wrong: Option<u8>,
    },
    /// No connection is free.
    NoConnection {
        /// For whom.
        master: Address,
        /// How many there are.
        connections: usize,
    },
}

/// Why a connection has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Closed {
    /// The master ended it.
    Aborted(AbortReason),
    /// The slave refused its Initiate.
    Refused(AbortReason),
    /// The master sent nothing for three times its Send_Timeout.
    Silent,
    /// The master did not fetch the answer to its Initiate.
    NotFetched,
}

impl Event {
    /// Whether it is detail: a log leaves it out unless asked for more.
    pub const fn is_detail(&self) -> bool {
        match self {
            Self::Read { .. } | Self::Identified { written: false, .. } => true,
            Self::Written { .. }
            | Self::Refused { .. }
            | Self::ExtPrm { .. }
            | Self::Identified { written: true, .. }
            | Self::AlarmDelivered { .. }
            | Self::AlarmAcknowledged { .. }
            | Self::Opened { .. }
            | Self::Ended { .. }
            | Self::NoConnection { .. } => false,
        }
    }

    /// Whether a service was refused.
    pub const fn is_refusal(&self) -> bool {
        matches!(self, Self::Refused { .. } | Self::NoConnection { .. } | Self::ExtPrm { wrong: Some(_), .. })
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { master, channel, slot, index, len } => {
                write!(f, "master {master} read record {index} of slot {slot}, {}{channel}", Octets(*len))
            }
            Self::Written { master, channel, slot, index, len } => {
                write!(f, "master {master} wrote record {index} of slot {slot}, {}{channel}", Octets(*len))
            }
            Self::Identified { master, slot, block, written } => {
                let what = if *written { "wrote" } else { "read" };
                write!(f, "master {master} {what} I&M{block} ({}) of slot {slot}", FIRST.wrapping_add(*block))
            }
            Self::Refused { master, channel, function, place, failure } => {
                let asked = Asked(*function, *place);
                write!(f, "refused {asked} of master {master}{channel}: ")?;
                if *function == Function::AlarmAck.number() && failure.code == ErrorCode::STATE_CONFLICT {
                    return write!(
                        f,
                        "{failure}: no alarm waits for this acknowledgement; send it once, with slot, type and sequence number of the \
                         alarm in Slave_Diag"
                    );
                }
                WithCure(*failure).fmt(f)
            }
            Self::AlarmDelivered { master, alarm } => write!(f, "master {master} has read the {alarm}"),
            Self::AlarmAcknowledged { master, alarm } => {
                write!(f, "master {master} has acknowledged the {alarm}")
            }
            Self::Opened { master, sap } => write!(f, "opened a connection for master {master} at SAP {sap}"),
            Self::Ended { master, sap, why } => {
                write!(f, "the connection of master {master} at SAP {sap} has ended: ")?;
                match why {
                    Closed::Aborted(AbortReason(0)) => f.write_str("the master closed it"),
                    Closed::Aborted(reason) => write!(f, "Abort of the master ({})", reason.words()),
                    Closed::Refused(reason) => write!(f, "its Initiate was refused ({})", reason.words()),
                    Closed::Silent => f.write_str("nothing from the master for three times its Send_Timeout"),
                    Closed::NotFetched => f.write_str("the master did not fetch the answer to Initiate"),
                }
            }
            Self::ExtPrm { master, len, wrong: None } => {
                write!(f, "Set_Ext_Prm of master {master}, {}", Octets(*len))
            }
            Self::ExtPrm { master, len, wrong: Some(at) } => write!(
                f,
                "refused Set_Ext_Prm of master {master}: the length of the block at octet {at} is none from 4 to the end of {}; the slave waits for Set_Prm",
                Octets(*len)
            ),
            Self::NoConnection { master, connections } => write!(
                f,
                "refused a connection of master {master}: all {connections} are open; end another one first"
            ),
        }
    }
}

/// What a master asked for: the function, and of which slot and index.
pub(crate) struct Asked(pub(crate) u8, pub(crate) Option<(u8, u8)>);

impl fmt::Display for Asked {
    /// `Read of record 10 of slot 1`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(function, place) = *self;
        match Function::numbered(function) {
            Some(known) => f.write_str(known.name())?,
            None => write!(f, "function number {function:02X}")?,
        }
        match place {
            Some((slot, CALL_INDEX)) => write!(f, " of I&M (record {CALL_INDEX}) of slot {slot}"),
            Some((slot, index)) => write!(f, " of record {index} of slot {slot}"),
            None => Ok(()),
        }
    }
}

/// `1 octet`, `4 octets`
struct Octets(u8);

impl fmt::Display for Octets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.0, if self.0 == 1 { "octet" } else { "octets" })
    }
}
