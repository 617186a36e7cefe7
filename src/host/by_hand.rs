//! What a user does to a station that a file describes, as news.

use core::fmt;

use crate::process::Point;
use crate::profibus::dpv1::{AlarmHead, StatusType};

/// Something that was done by hand. `Display` is one line of plain English; the texts of a raised diagnosis follow as the
/// words of [`Refusals`](super::Refusals).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ByHand {
    /// An input has this value until it is released.
    Forced {
        /// Which.
        point: Point,
        /// Its value.
        value: f64,
    },
    /// An input belongs to what moves it again.
    Released {
        /// Which.
        point: Point,
    },
    /// All inputs do.
    AllReleased,
    /// The diagnosis reports something.
    Raised {
        /// The number of its words.
        number: u16,
    },
    /// The diagnosis reports nothing that was raised.
    Ended,
    /// The module of a slot is pulled.
    Pulled {
        /// The number of the slot.
        slot: u16,
    },
    /// A module that is not that of the configuration is plugged in a slot.
    PluggedOther {
        /// The number of the slot.
        slot: u16,
    },
    /// The module of the configuration is plugged in a slot.
    Plugged {
        /// The number of the slot.
        slot: u16,
    },
    /// The device has other octets in a record.
    RecordChanged {
        /// The slot of the record.
        slot: u8,
        /// Its index.
        index: u8,
    },
    /// An alarm waits for the master.
    AlarmRaised {
        /// Which.
        alarm: AlarmHead,
    },
    /// Every alarm is forgotten.
    AlarmsForgotten,
    /// A status message waits for the master.
    StatusSent {
        /// What kind.
        kind: StatusType,
        /// Of which slot.
        slot: u8,
    },
}

impl fmt::Display for ByHand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Forced { point: Point { slot, offset, kind }, value } => {
                write!(f, "input {kind} in octet {offset} of slot {slot} is forced to {value}")
            }
            Self::Released { point: Point { slot, offset, kind } } => {
                write!(f, "input {kind} in octet {offset} of slot {slot} is no longer forced")
            }
            Self::AllReleased => f.write_str("no input is forced any more"),
            Self::Raised { .. } => f.write_str("diagnosis raised by hand"),
            Self::Pulled { slot } => write!(f, "the module of slot {slot} is pulled"),
            Self::PluggedOther { slot } => write!(f, "another module is plugged in slot {slot}"),
            Self::Plugged { slot } => write!(f, "the module of slot {slot} is plugged"),
            Self::RecordChanged { slot, index } => {
                write!(f, "record {index} of slot {slot} is changed by the device")
            }
            Self::AlarmRaised { alarm } => write!(f, "raised the {alarm}"),
            Self::AlarmsForgotten => f.write_str("every alarm is forgotten"),
            Self::StatusSent { kind, slot } => write!(f, "sends a {kind} of slot {slot}"),
            Self::Ended => f.write_str("no diagnosis is raised by hand any more"),
        }
    }
}
