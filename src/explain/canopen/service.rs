//! Which service of which node an identifier is.

use super::Network;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::Address;
use crate::can_bus::canopen::cob_id::CobId;

/// A service, with its node and the number of its PDO, from 1 on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Service {
    Nmt,
    Sync,
    Time,
    Emcy(u8),
    Tpdo(u8, u16),
    Rpdo(u8, u16),
    SdoRequest(u8),
    SdoResponse(u8),
    ErrorControl(u8),
}

impl Service {
    /// The service of the predefined connection set (CiA 301): the function code in bits 10..7, the node in bits 6..0.
    fn predefined(id: Id) -> Option<Self> {
        let Id::Base(id) = id else { return None };
        let number = id.number();
        let node = number.to_le_bytes()[0] & 0x7F;
        Some(match (number >> 7, node) {
            (0, 0) => Self::Nmt,
            (1, 0) => Self::Sync,
            (2, 0) => Self::Time,
            (_, 0) => return None,
            (1, node) => Self::Emcy(node),
            (3, node) => Self::Tpdo(node, 1),
            (4, node) => Self::Rpdo(node, 1),
            (5, node) => Self::Tpdo(node, 2),
            (6, node) => Self::Rpdo(node, 2),
            (7, node) => Self::Tpdo(node, 3),
            (8, node) => Self::Rpdo(node, 3),
            (9, node) => Self::Tpdo(node, 4),
            (10, node) => Self::Rpdo(node, 4),
            (11, node) => Self::SdoResponse(node),
            (12, node) => Self::SdoRequest(node),
            (14, node) => Self::ErrorControl(node),
            (_, _) => return None,
        })
    }

    /// The object that holds the identifier, of services that can have another.
    const fn object(self) -> Option<(u8, Address)> {
        match self {
            Self::Emcy(node) => Some((node, Address::new(0x1014, 0))),
            Self::Tpdo(node, pdo) => Some((node, Address::new(0x17FF + pdo, 1))),
            Self::Rpdo(node, pdo) => Some((node, Address::new(0x13FF + pdo, 1))),
            Self::Nmt
            | Self::Sync
            | Self::Time
            | Self::SdoRequest(_)
            | Self::SdoResponse(_)
            | Self::ErrorControl(_) => None,
        }
    }

    /// The service of node `node` whose identifier the object at `at` holds.
    pub(super) fn of_object(node: u8, at: Address) -> Option<Self> {
        match at.pair() {
            (0x1005, 0) => Some(Self::Sync),
            (0x1014, 0) => Some(Self::Emcy(node)),
            (index @ 0x1400..=0x15FF, 1) => Some(Self::Rpdo(node, index - 0x13FF)),
            (index @ 0x1800..=0x19FF, 1) => Some(Self::Tpdo(node, index - 0x17FF)),
            (0.., 0..) => None,
        }
    }
}

impl Network {
    /// The service of an identifier: as heard, else as CiA 301 gives it.
    pub(super) fn service(&self, id: Id) -> Option<Service> {
        if let Some(service) = self.moved.get(&id) {
            return Some(*service);
        }
        let service = Service::predefined(id)?;
        let elsewhere = service.object().is_some_and(|(node, at)| {
            let heard = self.nodes.get(&node).and_then(|learned| learned.heard(at));
            heard.is_some_and(|value| CobId(value).active() != Some(id))
        });
        (!elsewhere).then_some(service)
    }

    /// The object at `at` of a node was written or read: an identifier may be another one.
    pub(super) fn place(&mut self, node: u8, at: Address) {
        let Some(service) = Service::of_object(node, at) else { return };
        let Some(value) = self.nodes.get(&node).and_then(|learned| learned.heard(at)) else { return };
        // Every node hears SYNC on its own identifier: those of others stay.
        if service != Service::Sync {
            self.moved.retain(|_, known| *known != service);
        }
        let Some(id) = CobId(value).active() else { return };
        let is_predefined = Service::predefined(id) == Some(service);
        // NMT and SDO cannot be taken away.
        let is_fixed = matches!(
            Service::predefined(id),
            Some(Service::Nmt | Service::SdoRequest(_) | Service::SdoResponse(_) | Service::ErrorControl(_))
        );
        // A node that listens to the TPDO of another: it stays that of the other.
        let is_linked =
            matches!((service, Service::predefined(id)), (Service::Rpdo(..), Some(Service::Tpdo(..))));
        if !is_predefined && !is_fixed && !is_linked && self.moved.len() < MOST_MOVED {
            self.moved.insert(id, service);
        }
    }

    /// After a reset of its communication a node has the identifiers of its memory, which nobody tells: those of the
    /// connection set are the best guess.
    pub(super) fn reset(&mut self, node: u8) {
        self.moved.retain(|_, service| service.object().is_none_or(|(of, _)| of != node));
        if let Some(learned) = self.nodes.get_mut(&node) {
            learned.reset();
        }
    }
}

/// Identifiers that are remembered: of every node all PDOs that are looked at.
const MOST_MOVED: usize = 127 * 66;
