//! A judge of the other side of a fieldbus: says row by row what a master, a slave or a node does right and wrong.
//!
//! | module | holds |
//! | --- | --- |
//! | `master` | a judge of DP masters: plays slaves, does things wrong on purpose, and watches |
//! | [`device`] | a judge of devices: a master that tries a slave or a node |
//! | `requirement` | [`Requirement`]: what a report must know of a row |
//! | `verdict` | [`Verdict`], [`JudgementOf`]: what is said of a row |
//! | `moment` | [`Moment`]: one sending on the line; [`Telegram`]: one that is shown |
//! | `figures` | [`Figures`]: the cycle, retries, losses |
//! | `progress` | [`Progress`]: what is tried |
//! | `report` | [`ReportOf`]: a table for a terminal, JSON, JUnit, a page with diagrams |

pub mod device;
mod figures;
mod master;
mod moment;
mod progress;
pub(crate) mod report;
mod requirement;
mod verdict;

pub use figures::{Figures, Spread};
pub use master::{
    Act, Ending, Judge, Judgement, MasterClass, Operator, Recording, Report, Row, Scenario, Setup, Slave,
    at_rates, live, rows, rows_at_each, scenario, simulated, simulated_until_breach, simulated_with, soaked,
};
pub use moment::{Moment, Side, Telegram};
pub use progress::Progress;
pub use report::{Outcome, ReportOf};
pub use requirement::{Conclusion, Confidence, Requirement, Standing};
pub use verdict::{JudgementOf, Verdict};
