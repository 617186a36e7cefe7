//! A judge of DP-V0 masters: plays slaves, watches every telegram, does things wrong on purpose, and says row by row what
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
//! | `moment` | [`Moment`]: one sending on the line |
//! | `observer` | telegrams in, evidence for each row out |
//! | `findings` | [`Verdict`], [`Judgement`]: evidence weighed |
//! | `figures` | [`Figures`]: the cycle, retries, losses |
//! | `scenario` | [`Scenario`]: what the stations do on purpose, as data |
//! | `second` | a second master, and what it does |
//! | `station` | the slaves, and what is done to them |
//! | `play` | [`Judge`]: the run, sans-I/O |
//! | `live` | [`live()`]: on a link of the operating system |
//! | `simulated` | [`simulated()`]: over any [`bench::Master`](crate::bench::Master), in virtual time |
//! | `rates` | [`at_rates()`]: the same at several rates |
//! | `recorded` | [`Recording`]: telegrams of a capture |
//! | `report` | [`Report`]: a table for a terminal, JSON, JUnit, a page with diagrams |
//!
//! The observer is the same in all three ways. What a scenario provokes it sees like everything else: a row about lost
//! replies is judged wherever a reply is lost. A row that cannot be judged says so with its reason; nothing is guessed.

mod admitted;
mod figures;
mod findings;
mod live;
mod moment;
mod observer;
mod play;
mod rates;
mod recorded;
mod report;
pub mod rows;
pub mod scenario;
mod second;
mod setup;
mod simulated;
mod station;

pub use figures::{Figures, Spread};
pub use findings::{Judgement, Verdict};
pub use live::{Operator, live};
pub use moment::{Moment, Side, Telegram};
pub use play::{Ending, Judge, Progress};
pub use rates::{at_rates, rows_at_each};
pub use recorded::Recording;
pub use report::{Outcome, Report};
pub use rows::Row;
pub use scenario::Scenario;
pub use setup::{MasterClass, Setup, Slave};
pub use simulated::{simulated, simulated_until_breach, simulated_with, soaked};
pub use station::Act;
