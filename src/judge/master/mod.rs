//! A judge of DP masters: plays slaves, watches every telegram, does things wrong on purpose, and says row by row what
//! the master made of it.
//!
//! ```text
//!            moments                                         faults, acts
//!  line ───────────────▶ observer ─▶ findings    play ─────────────────────▶ stations, Faults
//!  (live, virtual,                      │          ▲ scenarios
//!   recorded)                           └─▶ report └─ setup
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `rows` | [`Row`]: the table of what is required, as data |
//! | `setup` | [`Setup`]: what is configured in the master |
//! | `admitted` | what the master's own device file admits of it |
//! | `observer` | telegrams in, evidence for each row out |
//! | `findings` | evidence weighed |
//! | `scenario` | [`Scenario`]: what the stations do on purpose, as data |
//! | `second` | a second master, and what it does |
//! | `station` | what is done to the slaves |
//! | `played` | a slave that is played |
//! | `play` | [`Judge`]: the run, sans-I/O |
//! | `live` | [`live()`]: on a link of the operating system |
//! | `simulated` | [`simulated()`]: over any [`bench::Master`](crate::bench::Master), in virtual time |
//! | `rates` | [`at_rates()`]: the same at several rates |
//! | `recorded` | [`Recording`]: telegrams of a capture |
//!
//! The observer is the same in all three ways. What a scenario provokes it sees like everything else: a row about lost
//! replies is judged wherever a reply is lost. A row that cannot be judged says so with its reason; nothing is guessed.

mod admitted;
mod findings;
mod live;
mod observer;
mod play;
mod played;
mod rates;
mod recorded;
pub mod rows;
pub mod scenario;
mod second;
mod setup;
mod simulated;
mod station;

use super::report::ReportOf;
use super::verdict::JudgementOf;

pub use live::{Operator, live};
pub use play::{Ending, Judge};
pub use rates::{at_rates, rows_at_each};
pub use recorded::Recording;
pub use rows::Row;
pub use scenario::Scenario;
pub use setup::{MasterClass, Setup, Slave};
pub use simulated::{simulated, simulated_until_breach, simulated_with, soaked};
pub use station::Act;

/// The verdict on a row of the table of masters.
pub type Judgement = JudgementOf<Row>;
/// The verdicts on a master.
pub type Report = ReportOf<Row>;
