//! Numbers of a CANopen network: nodes, and places in an object dictionary.

use core::fmt;

use thiserror::Error;

/// The number of a node, 1 to 127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// The lowest number.
    pub const MIN: Self = Self(1);
    /// The highest number.
    pub(crate) const MAX: Self = Self(127);

    /// The node `number`.
    ///
    /// # Errors
    /// [`NodeIdError`] outside 1 to 127.
    pub const fn new(number: u8) -> Result<Self, NodeIdError> {
        match number {
            1..=127 => Ok(Self(number)),
            0 | 128.. => Err(NodeIdError { got: number }),
        }
    }

    /// 1 to 127.
    pub const fn number(self) -> u8 {
        self.0
    }
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// No number of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("node number {got} is not in 1 to 127")]
pub struct NodeIdError {
    /// The number given.
    pub got: u8,
}

/// The index of an object, 0000h to FFFFh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Index(pub u16);

impl fmt::Display for Index {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h", self.0)
    }
}

/// The sub-index of an entry of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Sub(pub u8);

impl fmt::Display for Sub {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02X}", self.0)
    }
}

/// One entry of an object dictionary (the multiplexer of CiA 301).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// The object.
    pub index: Index,
    /// The entry in it.
    pub sub: Sub,
}

impl Address {
    /// Entry `sub` of object `index`.
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index: Index(index), sub: Sub(sub) }
    }

    /// Index and sub-index as plain numbers, to match on.
    pub const fn pair(self) -> (u16, u8) {
        (self.index.0, self.sub.0)
    }

    /// Whether it is of 1010h or 1011h: a signature is written there, and what the device can is read.
    #[cfg(feature = "std")]
    pub(crate) const fn takes_signature(self) -> bool {
        matches!(self.pair(), (0x1010 | 0x1011, 1..))
    }
}

impl fmt::Display for Address {
    /// As in manuals: `1018h:04`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.index, self.sub)
    }
}
