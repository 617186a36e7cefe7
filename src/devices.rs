//! The devices. Each is one folder: the device without a bus, and a folder for each bus that it is served on.

pub mod ag03;
pub mod ap10;
pub mod asda_a2;
mod drive_state;
#[cfg(feature = "std")]
mod error_kind;
mod node;
mod plain_node;
pub mod ppo_drive;
pub mod vocabulary;

#[cfg(feature = "std")]
pub use error_kind::ErrorKind;
pub use node::{CanopenDevice, CanopenEvent, RecallError};
pub use plain_node::PlainNode;
pub use vocabulary::Vocabulary;
