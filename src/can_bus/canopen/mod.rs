//! CANopen: a node by CiA 301 without I/O, for any device.
//!
//! ```text
//!  frame ──▶ Node ──▶ nmt │ sdo │ pdo │ sync │ guarding │ heartbeat
//!                      │ address, octets
//!                      ▼
//!                    access: tables of the device judge ──▶ node keeps it: settings
//!                                                      └──▶ Application: read, write
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `address` | node numbers, index and sub-index |
//! | [`value`] | types and values with their octets |
//! | [`dictionary`] | the object dictionary as `const` tables |
//! | [`check`] | whether the tables agree with themselves |
//! | [`eds`] | the data sheet of CiA 306 from the tables |
//! | `application` | the trait a device implements |
//! | [`policy`] | where devices and readings of the standard differ |
//! | [`node`] | the node: a file for each of its services |
//! | [`faults`] | faults on purpose |
//! | `event` | what it tells its user |
//! | [`nmt`] | states and commands |
//! | [`sdo`] | service data |
//! | `pdo` | process data |
//! | [`emcy`] | emergencies |
//! | [`cob_id`] | identifiers and the objects that hold them |
//! | [`parameter`] | communication objects that the node keeps |
//! | `abort` | abort codes |
//! | [`refusal`] | a refused request with its value and the rule it broke |

pub(crate) mod abort;
pub(crate) mod address;
pub(crate) mod application;
pub mod check;
pub mod cob_id;
pub mod dictionary;
pub mod eds;
pub mod emcy;
pub(crate) mod event;
pub mod faults;
pub mod nmt;
pub mod node;
pub mod parameter;
pub(crate) mod pdo;
pub mod policy;
pub mod refusal;
pub mod sdo;
pub mod value;

pub use abort::Abort;
pub use address::{Address, Index, NodeId, NodeIdError, Sub};
pub use application::{Application, NmtCause, Notice, Part, Request, Source, Written};
pub use dictionary::{Entry, Home, Object};
pub use emcy::{Emergency, ErrorNames};
pub use event::{AwaitsSync, Event, Identified, LssRefusal, NoEffect};
pub use nmt::{NmtState, Reset};
pub use node::{Node, Service};
pub use pdo::PdoNumber;
pub use policy::Policy;
pub use refusal::{Change, Refusal, Rule};
pub use value::{DataType, Value};
