//! CAN 2.0: frames, their time on the bus, and the text of an adapter.
//!
//! | file | holds |
//! | --- | --- |
//! | `frame` | identifiers, frames, who wins the bus |
//! | `rate` | bit rates |
//! | [`timing`] | how many bits a frame is, stuff bits and CRC included |
//! | `confinement` | error counters, error passive, bus off |
//! | [`slcan`] | the ASCII text between a master and its adapter |
//!
//! Nothing here knows what an identifier means: that is CANopen's. A bus on which stations meet is in
//! `host::can` (feature `std`): it needs an allocator.

pub(crate) mod confinement;
pub(crate) mod frame;
pub(crate) mod rate;
pub mod slcan;
pub mod timing;

pub use confinement::{Confinement, ErrorState};
pub use frame::{BaseId, Content, ExtendedId, Frame, FrameError, Id, IdError};
pub(crate) use frame::{MAX_OCTETS, Priority};
pub use rate::{BitRate, BitRateError};
