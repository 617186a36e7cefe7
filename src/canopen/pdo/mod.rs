//! Process data (`canopen-link.md` 6).

use core::fmt;

/// The most PDOs of a node in one direction.
pub const MAX_PDOS: usize = 8;

/// The most entries in one PDO.
pub const MAX_MAPPED: usize = 8;

/// The number of a PDO of one direction, 1 to 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PdoNumber(u8);

impl PdoNumber {
    /// Every number, the lowest first.
    pub const ALL: [Self; MAX_PDOS] =
        [Self(1), Self(2), Self(3), Self(4), Self(5), Self(6), Self(7), Self(8)];

    /// PDO `number`, `None` outside 1 to 8.
    pub const fn new(number: u8) -> Option<Self> {
        match number {
            1..=8 => Some(Self(number)),
            0 | 9.. => None,
        }
    }

    /// 1 to 8.
    pub const fn number(self) -> u8 {
        self.0
    }

    /// Its place in tables.
    pub(in crate::canopen) const fn place(self) -> usize {
        self.0 as usize - 1
    }
}

impl fmt::Display for PdoNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
