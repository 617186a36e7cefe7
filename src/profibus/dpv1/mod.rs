//! DP-V1: records that a master reads and writes beside the exchange of data, alarms, identification.
//!
//! ```text
//! SAP 53           the owner sends blocks of parameters                           in WAIT-CFG
//! SAP 51     MS1   the owner reads and writes records and acknowledges alarms     in DATA-EXCH, if Set_Prm enables it
//! SAP 50     MS1   the owner acknowledges alarms                                  as SAP 51
//! SAP 49     MS2   any master asks for a connection                               always
//! SAP 48..0  MS2   the connections                                                while they are open
//! ```
//!
//! Source: `dp-v1.md`. A request is answered with SC; the master polls with empty requests at the same SAP until the
//! response is there. Each SAP carries out one request at a time.
//!
//! A slave of DP-V0 stays what it is: [`Acyclic`] stands beside its [`Station`](super::dp::Station) and sees each
//! telegram first. What is in the records, an implementation of [`Records`] knows.

mod acyclic;
mod alarm;
pub mod base_mode;
pub mod connection;
mod error;
mod event;
pub mod identification;
mod job;
mod ms2;
mod obstacle;
mod offer;
pub(crate) mod pdu;
mod queue;
mod records;

pub use acyclic::Acyclic;
pub use alarm::{AlarmHead, AlarmType, Specifier, StatusType, TypedBlock};
pub use error::{ErrorCode, ErrorDecode, Failure, WithCure};
pub(crate) use event::Asked;
pub use event::{Closed, Event};
pub use identification::{Identification, Revision, Text};
pub use job::{Channel, Job};
pub use ms2::Link;
pub use obstacle::{LastRefused, Obstacle};
pub use offer::{AlarmOffer, Ms2Offer, Offer};
pub use pdu::{PduError, RequestPdu, ResponsePdu};
pub use queue::{Alarm, AlarmState, Many, NotRaised};
pub use records::{NoRecords, NotDone, Records};

/// The most octets of data in one PDU.
pub const MAX_DATA: u8 = 240;

/// The most octets of a PDU.
pub const MAX_PDU: usize = MAX_DATA as usize + 4;

/// Where the owner sends blocks of parameters.
pub(crate) const EXT_PRM_SAP: u8 = 53;

/// Where the owner reads and writes records.
pub(crate) const MS1_SAP: u8 = 51;

/// Where the owner may acknowledge alarms.
pub(crate) const ALARM_SAP: u8 = 50;

/// Where connections are asked for; theirs lie below it.
pub(crate) const RESOURCE_MANAGER_SAP: u8 = 49;

/// The record of identification and maintenance.
pub const CALL_INDEX: u8 = 255;

/// The record of parameters of a drive.
pub const PARAMETER_INDEX: u8 = 47;

macro_rules! functions {
    ($($function:ident = $number:literal: $name:literal;)*) => {
        /// The service of a PDU, its first octet.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Function {
            $(
                #[doc = concat!($name, ".")]
                $function,
            )*
        }

        impl Function {
            /// Every function.
            pub const ALL: &[Self] = &[$(Self::$function),*];

            /// Its number, bit 7 clear.
            pub const fn number(self) -> u8 {
                match self { $(Self::$function => $number,)* }
            }

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$function => $name,)* }
            }

            /// The function of a number, bit 7 clear.
            pub const fn numbered(number: u8) -> Option<Self> {
                match number {
                    $($number => Some(Self::$function),)*
                    _ => None,
                }
            }
        }
    };
}

functions! {
    Idle = 0x48: "Idle";
    DataTransport = 0x51: "Data_Transport";
    ResourceManager = 0x56: "RM";
    Initiate = 0x57: "Initiate";
    Abort = 0x58: "Abort";
    AlarmAck = 0x5C: "Alarm_Ack";
    Read = 0x5E: "Read";
    Write = 0x5F: "Write";
}

impl Function {
    /// Set in the first octet of a negative response.
    pub const NEGATIVE: u8 = 0x80;
}
