//! The outputs of the stations of a bus, for those that follow them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::process::{Point, Slot};
use crate::profibus::fdl::Address;

/// The outputs of stations as they are now. A clone is the same board.
#[derive(Clone, Debug, Default)]
pub struct OutputBoard(Arc<Mutex<BTreeMap<u8, Published>>>);

#[derive(Debug, Default)]
struct Published {
    slots: Vec<Slot>,
    outputs: Vec<u8>,
}

impl OutputBoard {
    /// A station has these outputs now.
    pub(super) fn publish(&self, address: Address, slots: &[Slot], outputs: &[u8]) {
        let mut board = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let published = board.entry(address.number()).or_default();
        if published.slots != slots {
            published.slots = slots.to_vec();
        }
        published.outputs.clear();
        published.outputs.extend_from_slice(outputs);
    }

    /// The station is gone.
    pub(super) fn withdraw(&self, address: Address) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).remove(&address.number());
    }

    /// An output of a station; `None` if there is no such station or no such output.
    pub fn output(&self, address: Address, point: Point) -> Option<f64> {
        let board = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let published = board.get(&address.number())?;
        let slot = published.slots.iter().find(|slot| slot.number == point.slot)?;
        point.kind.read(published.outputs.get(slot.outputs.clone())?, point.offset)
    }
}
