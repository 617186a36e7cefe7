//! Process data: entries of the dictionary in frames without protocol (`canopen-link.md` 6).
//!
//! | type | TPDO | RPDO |
//! | --- | --- | --- |
//! | 0 | after a SYNC, if something changed | taken at the next SYNC |
//! | 1..=240 | after every n-th SYNC | taken at the next SYNC |
//! | 252 | on request, sampled at SYNC | |
//! | 253 | on request | |
//! | 254, 255 | on events and by the event timer | taken at once |
//!
//! | file | holds |
//! | --- | --- |
//! | [`mapping`] | which entries a PDO carries |

pub(crate) mod mapping;

pub(crate) use mapping::MappingWord;

use core::fmt;

use super::address::Index;

/// The most PDOs of a node in one direction. Those of a file are more than those of our devices.
pub(crate) const MAX_PDOS: usize = if cfg!(feature = "std") { 64 } else { 8 };

/// What a node has for each PDO of a direction, [`MAX_PDOS`] at most: with `std` no more room than the PDOs need.
#[cfg(feature = "std")]
pub(super) type PerPdo<T> = std::vec::Vec<T>;
#[cfg(not(feature = "std"))]
pub(super) type PerPdo<T> = heapless::Vec<T, MAX_PDOS>;

/// Adds one at the end; `false`: there is no room.
pub(super) fn add<T>(list: &mut PerPdo<T>, one: T) -> bool {
    let room = list.len() < MAX_PDOS;
    if room {
        #[cfg(feature = "std")]
        list.push(one);
        #[cfg(not(feature = "std"))]
        return list.push(one).is_ok();
    }
    room
}

/// Objects of communication, or of mappings, in one direction.
pub(crate) const OBJECTS: u16 = 0x200;

/// The most entries in one PDO.
pub(crate) const MAX_MAPPED: usize = 8;

/// The number of a PDO of one direction, 1 to 512.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PdoNumber(u16);

impl PdoNumber {
    /// PDO 1.
    pub const P1: Self = Self(1);
    /// PDO 2.
    pub const P2: Self = Self(2);
    /// PDO 3.
    pub const P3: Self = Self(3);
    /// PDO 4.
    pub const P4: Self = Self(4);

    /// PDO `number`, `None` outside 1 to 512.
    pub const fn new(number: u16) -> Option<Self> {
        match number {
            1..=OBJECTS => Some(Self(number)),
            0 | 513.. => None,
        }
    }

    /// 1 to 512.
    pub(crate) const fn number(self) -> u16 {
        self.0
    }

    /// Its object; `first` is that of PDO 1.
    pub(in crate::can_bus::canopen) const fn object(self, first: u16) -> Index {
        Index(first + self.0 - 1)
    }
}

impl fmt::Display for PdoNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Sub-index 2 of the communication objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TransmissionType(pub u8);

impl TransmissionType {
    /// Whether the type exists; 241 to 251 are reserved.
    pub(crate) const fn exists(self) -> bool {
        !matches!(self.0, 241..=251)
    }

    /// Whether an RPDO of this type waits for SYNC.
    pub(crate) const fn is_synchronous(self) -> bool {
        self.0 <= 240
    }

    /// What makes a node send a TPDO of this type; reserved types are sent on request only.
    pub(super) const fn trigger(self) -> Trigger {
        match self.0 {
            0 => Trigger::SyncAfterEvent,
            n @ 1..=240 => Trigger::EverySync(n),
            252 => Trigger::RequestSampledAtSync,
            241..=251 | 253 => Trigger::Request,
            254 => Trigger::Event254,
            255 => Trigger::Event255,
        }
    }
}

/// What makes a node send a TPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trigger {
    /// Type 0.
    SyncAfterEvent,
    /// Types 1 to 240.
    EverySync(u8),
    /// Type 252.
    RequestSampledAtSync,
    /// Type 253.
    Request,
    /// Type 254: the manufacturer's rule.
    Event254,
    /// Type 255: the profile's rule.
    Event255,
}

impl Trigger {
    pub(super) const fn is_event(self) -> bool {
        match self {
            Self::Event254 | Self::Event255 => true,
            Self::SyncAfterEvent | Self::EverySync(_) | Self::RequestSampledAtSync | Self::Request => false,
        }
    }
}
