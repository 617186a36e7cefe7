//! How a master turns a drive of CiA 402 without a target position.

use crate::can_bus::canopen::Address;
use crate::can_bus::cia402::Mode;

/// What a master sends to a drive on CANopen for a velocity and for inching.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turning {
    /// 6060h for a velocity.
    pub mode: Mode,
    /// The entry of the velocity.
    pub target: Address,
    /// The unit of that entry; empty: as the file of the device says.
    pub unit: &'static str,
    /// The least and the most of it.
    pub range: (i32, i32),
    /// The control words by which it inches in mode 1, in positive and in negative direction; `None`: it does not.
    pub inching: Option<[u16; 2]>,
}
