//! What every device can be asked by a person or a program, whatever its bus. A face (panel, command, metrics, documents)
//! shows what a device says here, and knows no device.

pub mod acyclic;
mod bits;
pub mod description;
mod device_event;
mod drive_state;
mod event;
pub(crate) mod hint;
mod object_entry;
#[cfg(feature = "std")]
pub(crate) mod operation;
mod quirk;
pub mod surroundings;
mod turning;
mod why;

#[cfg(test)]
pub(crate) use quirk::check;

pub use acyclic::Acyclic;
pub(crate) use bits::bits_of_word;
pub use description::Description;
pub use device_event::{AnyDeviceEvent, DeviceEvent};
pub use drive_state::DriveState;
pub use event::{Again, ErrorKind, EventKind};
pub(crate) use object_entry::{DataType, ObjectEntry};
#[cfg(feature = "std")]
pub(crate) use operation::Operation;
pub use quirk::{Quirk, QuirkError};
pub use surroundings::Surroundings;
pub use turning::Turning;
pub use why::{Reason, Why};
