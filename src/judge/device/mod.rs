//! A judge of devices: a master that says row by row what a slave or a node does right and wrong.
//!
//! ```text
//!  rows ──▶ play ──▶ a row: sends, listens, compares ──▶ Ok, or why it stops
//!            │                        │
//!            └─▶ judgements           └─▶ the line: a link of the operating system, or a line in virtual time
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `row` | [`Row`]: an entry of a table, with the function that judges it |
//! | `course` | how a row stops before its end |
//! | `play` | the run: rows one after the other, and what one says of the others |
//! | `ending` | [`Ending`]: how a judgement of a device ends |
//! | `attendant` | [`Attendant`]: who does by hand what the bus cannot |
//! | `soak` | [`Soak`]: rows that are tried again at random |
//! | [`node`] | CANopen nodes |
//! | [`slave`] | DP slaves |
//!
//! A row is one function. It begins where `settle` has left the device, and ends with `Ok` if it held. What it sends and
//! hears is kept and shown if it did not. A device that no longer answers ends the judgement.

mod attendant;
mod course;
mod ending;
pub mod node;
mod play;
mod row;
pub mod slave;
mod soak;

pub use attendant::Attendant;
pub use ending::Ending;
pub use row::Row;
pub use soak::Soak;
