//! A CANopen node as its electronic data sheet (EDS) or device configuration file (DCF) describes it, or the XML of them
//! (XDD, XDC): the file read and typed (CiA 306 and 311, `eds.md`).
//!
//! | file | holds |
//! | --- | --- |
//! | `lines.rs` | text to sections of keys and values |
//! | `xdd.rs` | XML to the same sections |
//! | `number.rs` | numbers and formulas with `$NODEID` |
//! | `content.rs` | the value that an entry has after power-up |
//! | `object.rs` | objects and their entries |
//! | `info.rs` | what the file says of itself, of the device and of its commissioning |
//! | `reader.rs`, `reader/` | sections to an [`Eds`] |
//! | `mandatory.rs` | what every node has, whatever its file forgets |
//! | `check.rs` | what contradicts something else in the file |
//! | `profile.rs` | what kind of device it is |
//! | `error.rs` | what makes a file useless |
//!
//! Real files have every mistake that a text can have, so a mistake costs the value that it stands in and no more;
//! each is in [`Eds::hints`] with its line and with what was made of it.
//!
//! ```
//! use profidrive::can_bus::canopen::NodeId;
//! use profidrive::eds::Eds;
//!
//! let file = b"[1017]\nParameterName=Producer heartbeat time\nObjectType=7\nDataType=6\nAccessType=rw\nDefaultValue=500\n";
//! let eds = Eds::read(file)?;
//! let entry = eds.entry(0x1017, 0).ok_or("no such entry")?;
//! let node = NodeId::new(5)?;
//! assert_eq!((entry.name.as_str(), entry.octets(node)), ("Producer heartbeat time", vec![0xF4, 0x01]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod content;
mod error;
mod info;
mod lines;
mod mandatory;
mod number;
mod object;
mod profile;
mod reader;
#[cfg(test)]
mod tests;
mod xdd;

pub use content::Content;
pub use error::ReadError;
pub use info::{Commissioning, DeviceInfo, FileInfo};
pub use number::Number;
pub use object::{Entry, Group, Limit, Object, Rights};
pub use profile::Profile;

use std::collections::BTreeMap;

use crate::device_file::{CodePage, Hint};

/// The longest file that is read, in octets.
pub(crate) const MAX_FILE_LEN: usize = 16 << 20;

/// The most entries of one file, those that CompactSubObj stands for included. Real files have some thousands.
pub(crate) const MAX_ENTRIES: usize = 100_000;

/// What an EDS or a DCF says.
#[derive(Clone, Debug, PartialEq)]
pub struct Eds {
    /// How its octets were read.
    pub code_page: CodePage,
    /// Section FileInfo.
    pub file: FileInfo,
    /// Section DeviceInfo.
    pub device: DeviceInfo,
    /// Section DeviceComissioning: the file is a DCF.
    pub commissioning: Option<Commissioning>,
    /// Section DummyUsage: the data types 1 to 7 that an RPDO may map as a gap, bit n for type n.
    pub dummies: u8,
    /// The objects from 1000h on.
    pub objects: BTreeMap<u16, Object>,
    /// What is odd, in the order of the file.
    pub hints: Vec<Hint>,
}

impl Eds {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ReadError`] if it is no EDS at all. Never panics.
    pub fn read(octets: &[u8]) -> Result<Self, ReadError> {
        reader::read(octets)
    }

    /// The entry with that index and sub-index.
    pub fn entry(&self, index: u16, sub: u8) -> Option<&Entry> {
        self.objects.get(&index)?.entries.get(&sub)
    }

    /// What kind of device it is.
    pub fn profile(&self) -> Profile {
        Profile::of(self)
    }

    /// The default of an entry that is a number without `$NODEID`.
    pub(crate) fn number(&self, index: u16, sub: u8) -> Option<i128> {
        match self.entry(index, sub)?.content {
            Content::Whole(Number { offset, node_id: false }) => Some(offset),
            Content::Whole(_) | Content::None | Content::Real(_) | Content::Octets(_) => None,
        }
    }
}
