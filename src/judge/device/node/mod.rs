//! A judge of CANopen nodes.
//!
//! | file | holds |
//! | --- | --- |
//! | `setup` | [`Setup`]: what is known of the node, and what may be done to it |
//! | `wire` | the bus: frames out, frames in until a time |
//! | `port` | [`Port`]: a bus in virtual time |
//! | `tester` | [`Tester`]: the node, its state, what was written to it |
//! | `sdo` | transfers of a client, with every octet looked at |
//! | `objects` | what the data sheet says, or the node itself |
//! | `pdo` | its PDOs: identifiers, types, mappings |
//! | `rows` | the table, group by group |
//! | `run` | [`live()`], [`simulated()`] |

mod objects;
mod pdo;
mod port;
mod rows;
mod run;
mod sdo;
mod setup;
mod tester;
mod wire;

pub use port::Port;
pub use run::{Live, live, simulated};
pub use setup::Setup;
pub use tester::Tester;

use crate::judge::report::ReportOf;

/// A row of the table of nodes.
pub type Row = super::Row<Tester>;
/// The verdicts on a node.
pub type Report = ReportOf<Row>;
