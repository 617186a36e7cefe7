//! CAN 2.0: frames, their time on the bus, and the text of an adapter.
//!
//! | file | holds |
//! | --- | --- |
//! | [`frame`] | identifiers, frames, who wins the bus |
//!
//! Nothing here knows what an identifier means: that is CANopen's.

pub mod frame;

pub use frame::{BaseId, Content, ExtendedId, Frame, FrameError, Id, IdError, MAX_OCTETS, Priority};
