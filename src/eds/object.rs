//! Objects and their entries.

use std::collections::BTreeMap;

use super::content::Content;
use super::number::Number;
use crate::can_bus::canopen::dictionary::ObjectType;
use crate::can_bus::canopen::value::DataType;
use crate::can_bus::canopen::{Index, NodeId};
use crate::device_file::Place;

/// An object with its entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its index, 1000h or above.
    pub index: Index,
    /// ParameterName.
    pub name: String,
    /// Denotation: its name in this machine (DCF).
    pub denotation: String,
    /// ObjectType. A DOMAIN is a VAR of that data type.
    pub kind: ObjectType,
    /// The list that names it.
    pub group: Option<Group>,
    /// ObjFlags bit 0: a download of a configuration leaves it out.
    pub refuses_download: bool,
    /// ObjFlags bit 1: a scan leaves it out.
    pub refuses_scan: bool,
    /// Its entries by sub-index.
    pub entries: BTreeMap<u8, Entry>,
    /// Its section.
    pub(super) place: Place,
}

/// The lists of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// MandatoryObjects.
    Mandatory,
    /// OptionalObjects.
    Optional,
    /// ManufacturerObjects.
    Manufacturer,
}

impl Group {
    pub(crate) const ALL: [Self; 3] = [Self::Mandatory, Self::Optional, Self::Manufacturer];

    /// Its section.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Mandatory => "MandatoryObjects",
            Self::Optional => "OptionalObjects",
            Self::Manufacturer => "ManufacturerObjects",
        }
    }
}

/// One value of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// ParameterName.
    pub name: String,
    /// DataType.
    pub data: DataType,
    /// AccessType.
    pub rights: Rights,
    /// ParameterValue if it is not blank, else DefaultValue.
    pub content: Content,
    /// PDOMapping.
    pub mappable: bool,
    /// LowLimit.
    pub low: Option<Limit>,
    /// HighLimit.
    pub high: Option<Limit>,
    /// UploadFile or DownloadFile: the file with the contents of a domain, in the folder of this one.
    pub file: Option<String>,
    /// Its section.
    pub(crate) place: Place,
}

impl Entry {
    /// The octets of its value after power-up at a node, as on the bus.
    pub fn octets(&self, node: NodeId) -> Vec<u8> {
        self.content.octets(self.data, node)
    }
}

/// The end of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// A whole number, or one that depends on the node-ID.
    Whole(Number),
    /// A number of IEEE 754.
    Real(f64),
}

/// What a client may do with an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rights {
    /// `ro`: read.
    ReadOnly,
    /// `wo`: write.
    WriteOnly,
    /// `rw`: both.
    ReadWrite,
    /// `rwr`: both; in PDOs only to be sent.
    ReadWriteSent,
    /// `rww`: both; in PDOs only to be received.
    ReadWriteReceived,
    /// `const`: read; it never changes.
    Const,
}

impl Rights {
    /// All of them.
    const ALL: [Self; 6] = [
        Self::ReadOnly,
        Self::WriteOnly,
        Self::ReadWrite,
        Self::ReadWriteSent,
        Self::ReadWriteReceived,
        Self::Const,
    ];

    /// As files write it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ReadOnly => "ro",
            Self::WriteOnly => "wo",
            Self::ReadWrite => "rw",
            Self::ReadWriteSent => "rwr",
            Self::ReadWriteReceived => "rww",
            Self::Const => "const",
        }
    }

    /// In any case.
    pub(super) fn read(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rights| rights.name().eq_ignore_ascii_case(text))
    }

    /// Whether a client may write.
    pub const fn is_writable(self) -> bool {
        match self {
            Self::WriteOnly | Self::ReadWrite | Self::ReadWriteSent | Self::ReadWriteReceived => true,
            Self::ReadOnly | Self::Const => false,
        }
    }

    /// Whether a client may read.
    pub const fn is_readable(self) -> bool {
        !matches!(self, Self::WriteOnly)
    }
}
