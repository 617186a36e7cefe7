//! What a drive keeps while it is switched off: the values that were written to its parameters.

use crate::map::Map;

use super::{PpoDrive, parameters::Access};
use crate::devices::{BusDrive, KeptValue, StationEvent, write_reply};
use crate::profibus::dp::{Application, Station, StoredAddress};
use crate::profibus::fdl::{MAX_TELEGRAM_LEN, Telegram};
use crate::profibus::pkw::{Parameters, Value};
use crate::time::{BaudRate, Instant};

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

impl<A: Application + 'static> BusDrive for PpoDrive<A> {
    type Application = A;

    fn station(&self) -> &Station<A> {
        &self.station
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.station.set_baud(baud);
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        self.advance(now, news);
        if let Some(event) = self.station.handle_telegram(now, telegram).event {
            news(StationEvent::Dp(event));
        }
        self.wake(now);
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        self.advance(now, news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        write_reply(self.station.poll_transmit(now), buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.station.poll_timeout(), self.cycles.next())
    }

    fn keep_parameters(&mut self) {
        self.memory.get_or_insert_default();
    }

    /// Until it is reported, the job that wrote something has no reply.
    fn take_changed(&mut self) -> bool {
        self.memory.as_mut().is_some_and(|memory| core::mem::take(&mut memory.changed))
    }

    fn to_keep(&self) -> Vec<KeptValue> {
        let written = self.memory.iter().flat_map(|memory| &memory.written);
        written.map(|((pnu, element), bits)| ((*pnu, element.unwrap_or(0)), *bits)).collect()
    }

    fn recall(&mut self, (address, rem_slave_data): (StoredAddress, &[u8]), kept: Vec<KeptValue>) {
        self.station.recall(address, rem_slave_data);
        for ((pnu, element), bits) in kept {
            let at = (pnu, Some(element).filter(|element| *element != 0));
            if self.set(at, bits)
                && let Some(memory) = &mut self.memory
            {
                memory.written.insert(at, bits);
            }
        }
    }

    /// If it could not be stored, the parameter is as before and the job gets error 18.
    fn handle_stored(&mut self, _: Instant, stored: bool) {
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
}

impl<A: Application> PpoDrive<A> {
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
