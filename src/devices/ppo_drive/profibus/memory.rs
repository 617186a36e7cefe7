//! What a drive keeps while it is switched off: the values that were written to its parameters.

use crate::map::Map;

use super::{PpoDrive, parameters::Access};
use crate::profibus::dp::{Application, StoredAddress};
use crate::profibus::pkw::{Parameters, Value};

/// A parameter, and of an array the element from 1.
pub(super) type Place = (u16, Option<u8>);

/// The values written, for a host that keeps them.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    written: Map<Place, u32>,
    undo: Option<Undo>,
    changed: bool,
}

/// What the write found that waits for the host.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undo {
    pub(super) at: Place,
    kept: Option<u32>,
    before: u32,
}

impl Memory {
    /// A value was written. Says whether it has to wait until it is safe.
    pub(super) fn note(&mut self, at: Place, before: u32, bits: u32) -> bool {
        let kept = self.written.insert(at, bits);
        if kept == Some(bits) && !self.changed && self.undo.is_none() {
            return false;
        }
        // Of two writes that wait for one image the first found what was safe.
        self.undo = self.undo.filter(|first| first.at == at).or(Some(Undo { at, kept, before }));
        self.changed = true;
        true
    }

    /// What a write without a job must not touch, to be given back with [`Memory::hold`].
    pub(super) const fn held(&mut self) -> Option<Undo> {
        self.undo.take()
    }

    /// What the job that waits has found.
    pub(super) const fn hold(&mut self, undo: Option<Undo>) {
        self.undo = undo;
    }
}

impl<A: Application> PpoDrive<A> {
    /// The host keeps what is written to parameters from now on: see [`PpoDrive::take_changed`].
    pub(crate) fn keep_parameters(&mut self) {
        self.memory.get_or_insert_default();
    }

    /// Whether there is something new to be kept, which the host reports with [`PpoDrive::handle_stored`]. Until then the
    /// job that wrote it has no reply.
    pub(crate) fn take_changed(&mut self) -> bool {
        self.memory.as_mut().is_some_and(|memory| core::mem::take(&mut memory.changed))
    }

    /// Every value that was written: parameter, element from 0, bits.
    pub(crate) fn written(&self) -> impl Iterator<Item = ((u16, u8), u32)> {
        let written = self.memory.iter().flat_map(|memory| &memory.written);
        written.map(|((pnu, element), bits)| ((*pnu, element.unwrap_or(0)), *bits))
    }

    /// The address that Set_Slave_Add gave it, to be kept with [`Slave::rem_slave_data`](crate::profibus::dp::Slave::rem_slave_data).
    pub(crate) const fn stored_address(&self) -> StoredAddress {
        self.station.stored_address()
    }

    /// The drive is as it was before it was switched off. Values that its table does not take any more are left out.
    pub(crate) fn recall(
        &mut self,
        (address, rem_slave_data): (StoredAddress, &[u8]),
        written: impl IntoIterator<Item = ((u16, u8), u32)>,
    ) {
        self.station.recall(address, rem_slave_data);
        for ((pnu, element), bits) in written {
            let at = (pnu, Some(element).filter(|element| *element != 0));
            if self.set(at, bits)
                && let Some(memory) = &mut self.memory
            {
                memory.written.insert(at, bits);
            }
        }
    }

    /// What was written is safe, or could not be stored: then the parameter is as before and the job gets error 18.
    pub(crate) fn handle_stored(&mut self, stored: bool) {
        let undo = self.memory.as_mut().and_then(|memory| memory.undo.take());
        if stored {
            self.engine.stored();
            return;
        }
        let _told_by_the_reply = self.engine.store_failed();
        if let Some(Undo { at, kept, before }) = undo {
            self.set(at, before);
            if let Some(memory) = &mut self.memory {
                match kept {
                    Some(bits) => memory.written.insert(at, bits),
                    None => memory.written.remove(&at),
                };
            }
        }
    }

    /// Sets a parameter without keeping it. Says whether it took the value.
    fn set(&mut self, (pnu, element): Place, bits: u32) -> bool {
        let Some(row) = self.table.row(pnu) else { return false };
        let [_, _, high, low] = bits.to_be_bytes();
        let value = if row.kind.is_double() {
            Value::Double(bits)
        } else {
            Value::Word(u16::from_be_bytes([high, low]))
        };
        let known = self.known(self.ppo());
        let Self { table, drive, .. } = self;
        Access { table, drive, known, memory: None }.write(pnu, element, value).is_ok()
    }
}
