//! COB-IDs: the identifiers of the predefined connection set, and the words of objects that hold one.
//!
//! ```text
//! bit 31   1 = the service is off             (1005h: reserved)
//! bit 30   TPDO: 1 = no RTR; 1005h: 1 = the node produces SYNC; else 0
//! bit 29   1 = identifier of 29 bits
//! bits 28..0 the identifier, of 11 bits in bits 10..0 with 28..11 zero
//! ```

use super::address::NodeId;
use crate::can_bus::can::{BaseId, ExtendedId, Id};

/// NMT commands.
pub(crate) const NMT: u16 = 0x000;
/// The same as an identifier.
pub(crate) const NMT_ID: Id = match Id::base(NMT) {
    Ok(id) => id,
    Err(_) => Id::Base(BaseId::MAX),
};
/// SYNC unless 1005h says otherwise.
pub(crate) const SYNC: u16 = 0x080;
/// EMCY, plus the node number, unless 1014h says otherwise.
pub(crate) const EMCY: u16 = 0x080;
/// SDO answers, plus the node number.
pub(crate) const SDO_SERVER: u16 = 0x580;
/// The usual identifier of the first TPDO, plus the node number.
pub(crate) const TPDO_1: u16 = 0x180;
/// The usual identifier of the first RPDO, plus the node number.
pub(crate) const RPDO_1: u16 = 0x200;
/// SDO requests, plus the node number.
pub(crate) const SDO_CLIENT: u16 = 0x600;
/// Boot-up, heartbeat, guarding, plus the node number.
pub(crate) const ERROR_CONTROL: u16 = 0x700;

/// Answers of LSS.
pub(crate) const LSS_SLAVE: u16 = 0x7E4;
/// Requests of LSS.
pub(crate) const LSS_MASTER: u16 = 0x7E5;

/// The identifier `service` of node `node`.
pub(crate) const fn of_node(service: u16, node: NodeId) -> Id {
    // Services end at 700h, nodes at 127: always 11 bits.
    match BaseId::new(service + node.number() as u16) {
        Ok(id) => Id::Base(id),
        Err(_) => Id::Base(BaseId::MAX),
    }
}

/// The value of an object that holds a COB-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CobId(pub u32);

impl CobId {
    /// Bit 31.
    pub(crate) const INVALID: u32 = 1 << 31;
    /// Bit 30.
    pub(crate) const BIT_30: u32 = 1 << 30;
    /// Bit 29.
    pub(crate) const EXTENDED: u32 = 1 << 29;
    /// Bits 28..0.
    const IDENTIFIER: u32 = Self::EXTENDED - 1;

    /// Whether the service is on.
    pub(crate) const fn is_valid(self) -> bool {
        self.0 & Self::INVALID == 0
    }

    /// Bit 30.
    pub(crate) const fn bit_30(self) -> bool {
        self.0 & Self::BIT_30 != 0
    }

    /// Whether the identifier has 29 bits.
    pub(crate) const fn is_extended(self) -> bool {
        self.0 & Self::EXTENDED != 0
    }

    /// The identifier, whether the service is on or off; `None` if bits above bit 10 are set without bit 29.
    pub(crate) const fn id(self) -> Option<Id> {
        let number = self.0 & Self::IDENTIFIER;
        if self.is_extended() {
            match ExtendedId::new(number) {
                Ok(id) => Some(Id::Extended(id)),
                Err(_) => None,
            }
        } else if number <= BaseId::MAX.number() as u32 {
            #[expect(clippy::cast_possible_truncation, reason = "at most 7FFh")]
            match BaseId::new(number as u16) {
                Ok(id) => Some(Id::Base(id)),
                Err(_) => None,
            }
        } else {
            None
        }
    }

    /// The identifier if the service is on.
    pub(crate) const fn active(self) -> Option<Id> {
        if self.is_valid() { self.id() } else { None }
    }

    /// Whether the identifier is one that CiA 301 keeps for itself. Identifiers of 29 bits are free.
    pub const fn is_restricted(self) -> bool {
        if self.is_extended() {
            return false;
        }
        matches!(
            self.0 & Self::IDENTIFIER,
            0x000..=0x07F
                | 0x101..=0x180
                | 0x581..=0x5FF
                | 0x601..=0x67F
                | 0x6E0..=0x6FF
                | 0x701..=0x77F
                | 0x780..=0x7FF
        )
    }
}
