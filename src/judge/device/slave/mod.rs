//! A judge of DP slaves.
//!
//! | file | holds |
//! | --- | --- |
//! | `setup` | [`Setup`]: what is known of the slave |
//! | `wire` | the line: octets out at a time, octets in until a time |
//! | `request`, `answer` | telegrams of a master, right and wrong; what came back |
//! | `tester` | [`Tester`]: services, start-up, the state of the slave |
//! | `notes` | what is noticed while other rows are judged |
//! | `rows` | the table, group by group |
//! | `run` | [`live()`], [`simulated()`] |

mod answer;
mod notes;
mod request;
mod rows;
mod run;
mod setup;
mod tester;
mod wire;

pub use run::{Live, live, simulated};
pub use setup::Setup;
pub use tester::Tester;
pub use wire::Sight;

use crate::judge::report::ReportOf;

/// A row of the table of slaves.
pub type Row = super::Row<Tester>;
/// The verdicts on a slave.
pub type Report = ReportOf<Row>;
