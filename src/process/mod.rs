//! What lies behind the inputs and outputs of a slave: values in its process image, and who makes them.
//!
//! | file | holds |
//! | --- | --- |
//! | `value.rs` | [`ValueType`]: bits, integers and floats in octets |
//! | `source.rs` | [`Source`]: what a value follows over time |
//! | `signal.rs` | [`Signal`]: the value, for any bus |
//! | `condition.rs` | [`Condition`]: what must hold of a value |
//! | `table.rs` | [`Table`]: times and values from a CSV file |
//! | `input.rs` | [`Input`]: an input of a slave that shows a signal |
//!
//! No clock and no file: time and outputs in, inputs out. A machine of one's own is a [`Process`]:
//!
//! ```
//! use profidrive::process::{Image, Point, Process, Slot, ValueType};
//! use profidrive::time::Instant;
//!
//! /// A conveyor: while output bit 0 is set, the counter in the inputs goes up with every call.
//! struct Conveyor(u16);
//!
//! impl Process for Conveyor {
//!     fn step(&mut self, _: Instant, image: &mut Image<'_>) -> Option<Instant> {
//!         if image.output(Point { slot: 1, offset: 0, kind: ValueType::Bit(0) }) == Some(1.0) {
//!             self.0 = self.0.wrapping_add(1);
//!         }
//!         let counter = Point { slot: 2, offset: 0, kind: ValueType::Unsigned16 };
//!         image.set_input(counter, self.0.into()).ok();
//!         None
//!     }
//! }
//!
//! let slots = [Slot { number: 1, inputs: 0..0, outputs: 0..1 }, Slot { number: 2, inputs: 0..2, outputs: 1..1 }];
//! let mut inputs = [0; 2];
//! let mut image = Image { slots: &slots, outputs: &[1], inputs: &mut inputs, others: &|_| None };
//! Conveyor(6).step(Instant::ZERO, &mut image);
//! assert_eq!(inputs, [0, 7]);
//! ```

mod condition;
mod input;
mod signal;
mod source;
mod table;
mod value;

pub use condition::Condition;
pub use input::{Input, Origin};
pub use signal::Signal;
pub use source::{AtEnd, Source, SourceError};
pub use table::{Table, TableError};
pub use value::{ValueError, ValueType};

use core::ops::Range;

use crate::time::Instant;

/// A machine behind a slave. It has no clock: it is called with the time.
pub trait Process: Send {
    /// Called when the outputs have changed, when the configuration has, and at the instant it asked for last. Writes
    /// inputs and says when to call it again; `None`: only when something changes.
    fn step(&mut self, now: Instant, image: &mut Image<'_>) -> Option<Instant>;
}

/// The octets of a module in the process image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// The number of the slot.
    pub number: u16,
    /// Its octets among the inputs of the slave.
    pub inputs: Range<usize>,
    /// Its octets among the outputs of the slave.
    pub outputs: Range<usize>,
}

/// A value in the octets of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Point {
    /// The number of the slot.
    pub slot: u16,
    /// Its first octet in the slot, from 0.
    pub offset: usize,
    /// How the octets are read.
    pub kind: ValueType,
}

/// A value of another device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Elsewhere {
    /// The number of its line, from 1; `None`: the same line.
    pub line: Option<u16>,
    /// Its address there, or its node number.
    pub station: u8,
    /// Which of its values.
    pub what: What,
}

/// A value that a device shows to others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum What {
    /// An output of a slave with slots.
    Output(Point),
    /// What it tells of itself under this name.
    Value(String),
}

/// The value of another device; `None`: there is none.
pub(crate) type Others<'a> = &'a dyn Fn(&Elsewhere) -> Option<f64>;

/// Inputs and outputs of a slave, slot by slot.
pub struct Image<'a> {
    /// Its slots, in the order of the configuration.
    pub slots: &'a [Slot],
    /// What the master sent; zeros in the safe state.
    pub outputs: &'a [u8],
    /// What the master gets.
    pub inputs: &'a mut [u8],
    /// The values of other devices.
    pub others: Others<'a>,
}

impl core::fmt::Debug for Image<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Image")
            .field("outputs", &self.outputs)
            .field("inputs", &self.inputs)
            .finish_non_exhaustive()
    }
}

impl Image<'_> {
    /// An output; `None` if the slot does not have it.
    pub fn output(&self, point: Point) -> Option<f64> {
        let slot = self.slots.iter().find(|slot| slot.number == point.slot)?;
        point.kind.read(self.outputs.get(slot.outputs.clone())?, point.offset)
    }

    /// An input as it is now; `None` if the slot does not have it.
    pub fn input(&self, point: Point) -> Option<f64> {
        let slot = self.slots.iter().find(|slot| slot.number == point.slot)?;
        point.kind.read(self.inputs.get(slot.inputs.clone())?, point.offset)
    }

    /// Writes an input.
    ///
    /// # Errors
    /// [`ValueError`] if the slot does not have it, or the value does not fit. Nothing is written then.
    pub fn set_input(&mut self, point: Point, value: f64) -> Result<(), ValueError> {
        let slot = self.slots.iter().find(|slot| slot.number == point.slot);
        let octets = slot.and_then(|slot| self.inputs.get_mut(slot.inputs.clone())).unwrap_or_default();
        point.kind.write(octets, point.offset, value)
    }
}
