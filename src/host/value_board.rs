//! What the devices of all lines show to signals that follow them.

use crate::map::Map;
use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::face::Description;
use crate::face::description::Amount;
use crate::process::{Elsewhere, Point, Slot, What};
use crate::profibus::fdl::Address;

/// Outputs of stations, and values of other devices that somebody follows, as they are now. A clone is the same board, seen
/// from the same line.
#[derive(Clone, Debug, Default)]
pub struct ValueBoard {
    /// From which line it is seen.
    line: u16,
    all: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    /// Somebody follows a value of a device that tells of itself.
    follows: AtomicBool,
    board: Mutex<Board>,
}

/// By line and address.
#[derive(Debug, Default)]
struct Board {
    outputs: Map<(u16, u8), Published>,
    values: Map<(u16, u8), Vec<Followed>>,
}

#[derive(Debug, Default)]
struct Published {
    slots: Vec<Slot>,
    outputs: Vec<u8>,
}

/// A value of a device that tells of itself.
#[derive(Debug)]
struct Followed {
    key: String,
    value: Option<f64>,
    /// It was told that the device has no such value.
    told: bool,
}

impl ValueBoard {
    /// The same board, seen from the line of this number.
    #[must_use]
    pub fn of_line(&self, line: u16) -> Self {
        Self { line, all: Arc::clone(&self.all) }
    }

    fn board(&self) -> MutexGuard<'_, Board> {
        self.all.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A station has these outputs now.
    pub(super) fn publish(&self, address: Address, slots: &[Slot], outputs: &[u8]) {
        let mut board = self.board();
        let published = board.outputs.or_default((self.line, address.number()));
        if published.slots != slots {
            published.slots = slots.to_vec();
        }
        published.outputs.clear();
        published.outputs.extend_from_slice(outputs);
    }

    /// Who was there is gone.
    pub(super) fn withdraw(&self, place: u8) {
        let mut board = self.board();
        board.outputs.remove(&(self.line, place));
        for followed in board.values.get_mut(&(self.line, place)).into_iter().flatten() {
            followed.value = None;
        }
    }

    /// Somebody of this line follows a value.
    pub(super) fn follow(&self, Elsewhere { line, station, what }: &Elsewhere) {
        let What::Value(key) = what else { return };
        let mut board = self.board();
        let followed = board.values.or_default((line.unwrap_or(self.line), *station));
        if followed.iter().all(|known| known.key != *key) {
            followed.push(Followed { key: key.clone(), value: None, told: false });
        }
        self.all.follows.store(true, Ordering::Relaxed);
    }

    /// Takes what is followed of a device as it is now.
    #[inline]
    pub(super) fn show<'a>(&self, place: u8, description: &dyn Fn() -> Option<&'a dyn Description>) {
        if self.all.follows.load(Ordering::Relaxed)
            && let Some(description) = description()
        {
            self.take(place, description);
        }
    }

    fn take(&self, place: u8, description: &dyn Description) {
        let mut board = self.board();
        let Some(followed) = board.values.get_mut(&(self.line, place)) else { return };
        let mut known: Vec<&'static str> = Vec::new();
        description.each_value(&mut |value| {
            known.push(value.key);
            if let Some(followed) = followed.iter_mut().find(|followed| followed.key == value.key) {
                followed.value = match value.amount {
                    Amount::Number(number) => Some(number),
                    Amount::Flag(on) => Some(f64::from(u8::from(on))),
                    Amount::Unknown | Amount::Text(_) => None,
                };
            }
        });
        for followed in followed.iter_mut().filter(|followed| !known.contains(&&*followed.key)) {
            followed.value = None;
            // One that is off tells less.
            if !known.is_empty() && !core::mem::replace(&mut followed.told, true) {
                let (key, known) = (&followed.key, known.join(", "));
                tracing::warn!(
                    "an input follows '{key}' of station {place}, which has no such value: {known}"
                );
            }
        }
    }

    /// A value of a device; `None` if there is no such device or value.
    pub fn value(&self, Elsewhere { line, station, what }: &Elsewhere) -> Option<f64> {
        let place = (line.unwrap_or(self.line), *station);
        let board = self.board();
        match what {
            What::Output(Point { slot, offset, kind }) => {
                let published = board.outputs.get(&place)?;
                let slot = published.slots.iter().find(|known| known.number == *slot)?;
                kind.read(published.outputs.get(slot.outputs.clone())?, *offset)
            }
            What::Value(key) => board.values.get(&place)?.iter().find(|known| known.key == *key)?.value,
        }
    }
}
