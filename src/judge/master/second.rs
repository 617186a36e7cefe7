//! A second master, played by the judge: it enters the ring of the master under test, works there, and leaves it. Sans-I/O.
//!
//! | file | holds |
//! | --- | --- |
//! | `course` | [`Course`]: what it does with each token, as data |
//! | `owner` | `Owned`: a slave of the master of class 1, while one of class 2 is judged |
//! | `station` | [`Second`]: the station of the data link layer |
//! | `heard` | what it makes of telegrams and of silence |
//! | `evidence` | [`Evidence`]: what that says of a row |
//! | `telegrams` | what it sends |

mod course;
mod evidence;
mod heard;
mod owner;
mod station;
mod telegrams;

pub use course::{Course, Duty};
pub(super) use evidence::Evidence;
pub(super) use station::{Second, Surroundings};
