//! The devices. Each is one folder: the device without a bus, and a folder for each bus that it is served on.
//!
//! | module | holds |
//! | --- | --- |
//! | [`ag03`] | the positioning drives SIKO AG03 and AG03/1 |
//! | [`ap10`] | the position indicator SIKO AP10 |
//! | [`asda_a2`] | the servo Delta ASDA-A2 |
//! | `from_eds` | any node on CANopen that an EDS, a DCF or an XDD describes |
//! | `cia402_drive` | any drive of CiA 402, without a bus |
//! | [`ppo_drive`] | any drive with variable speed of PROFIDRIVE version 2 |
//! | [`profidrive4`] | a servo drive of PROFIdrive version 3 and 4, with DP-V1 |
//! | `servo` | motor, load and motion of any servo drive |
//! | `bus_drive` | `BusDrive`: what a host asks of any drive of the profile on PROFIBUS |
//! | `node` | [`CanopenDevice`]: what a host asks of any device on CANopen |
//! | `plain_node` | [`PlainNode`]: any device on CANopen that has no clock of its own |
//! | `plain_station` | [`PlainStation`]: any device on PROFIBUS that makes inputs of outputs |
//! | `vocabulary` | what a device on CANopen calls what it says |
//! | `drive_state` | the states of CiA 402 in the words that all devices share |
//! | `station_event` | [`StationEvent`]: news of any station on PROFIBUS |
//! | `named_word` | words of bits by the names of their bits and states |
//! | `story` | what happens in the story that `profidrive demo` tells of a device |
//! | `reasons` | what keeps a device from moving whatever it is |

pub mod ag03;
pub mod ap10;
pub mod asda_a2;
#[cfg(feature = "std")]
mod bus_drive;
#[cfg(feature = "std")]
pub(crate) mod cia402_drive;
mod drive_state;
#[cfg(feature = "eds")]
pub mod from_eds;
pub(crate) mod named_word;
mod node;
mod plain_node;
mod plain_station;
pub mod ppo_drive;
#[cfg(feature = "std")]
pub mod profidrive4;
pub(crate) mod reasons;
mod servo;
mod station_event;
pub(crate) mod story;
pub(crate) mod vocabulary;

#[cfg(feature = "std")]
pub use bus_drive::{BusDrive, KeptValue};
pub use node::{CanopenDevice, CanopenEvent, RecallError};
pub use plain_node::PlainNode;
pub use plain_station::{PlainStation, SlaveDevice};
pub use station_event::StationEvent;
pub(crate) use station_event::write_reply;
pub use vocabulary::Vocabulary;
