//! What the drive keeps while it is switched off: its address, and the parameters as they were stored (PNU 971).

use super::application::TelegramOnly;
use super::records::Records;
use super::{Event, ProfidriveDevice};
use crate::devices::{BusDrive, KeptValue, StationEvent, write_reply};
use crate::profibus::dp::{Application, Station, StoredAddress};
use crate::profibus::fdl::{MAX_TELEGRAM_LEN, Telegram};
use crate::time::{BaudRate, Instant};

impl<A: Application> ProfidriveDevice<TelegramOnly<A>> {
    /// PNU 971: without a host that keeps them the parameters are stored at once.
    pub(super) fn store(&mut self) {
        let values = self.parameters.kept(&self.known());
        if self.is_kept {
            (self.changed, self.parameters.storing, self.storing) = (true, true, Some(values));
        } else {
            self.stored = values;
            self.outbox.push(Event::Stored);
        }
    }
}

impl<A: Application + 'static> BusDrive for ProfidriveDevice<TelegramOnly<A>> {
    type Application = TelegramOnly<A>;

    fn station(&self) -> &Station<TelegramOnly<A>> {
        &self.station
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.baud = baud;
        self.station.set_baud(baud);
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        self.advance(now, news);
        let known = self.known();
        let told = self.outbox.len();
        let Self { station, acyclic, parameters, pending, identification, outbox, .. } = self;
        let mut records = Records { parameters, pending, known, identification, told: outbox };
        let outcome = acyclic.handle_telegram(station, &mut records, now, telegram);
        if let Some(event) = outcome.event {
            news(StationEvent::Dp(event));
        }
        self.tell_acyclic(news);
        if self.outbox.len() > told {
            self.cycles.wake(now);
        }
        self.carry_out(now);
        self.empty_outbox(news);
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
        let services = Instant::first_of(self.station.poll_timeout(), self.acyclic.poll_timeout());
        Instant::first_of(services, self.cycles.next())
    }

    fn keep_parameters(&mut self) {
        self.is_kept = true;
    }

    fn take_changed(&mut self) -> bool {
        core::mem::replace(&mut self.changed, false)
    }

    /// Those that are being stored, else those stored before.
    fn to_keep(&self) -> Vec<KeptValue> {
        self.storing.as_ref().unwrap_or(&self.stored).clone()
    }

    fn recall(&mut self, (address, rem_slave_data): (StoredAddress, &[u8]), kept: Vec<KeptValue>) {
        self.station.recall(address, rem_slave_data);
        if !kept.is_empty() {
            self.parameters.recall(&self.known(), &kept);
            self.stored = self.parameters.kept(&self.known());
        }
    }

    /// If it could not be kept, what was stored before stays.
    fn handle_stored(&mut self, now: Instant, stored: bool) {
        let Some(values) = self.storing.take() else { return };
        self.parameters.storing = false;
        if stored {
            self.stored = values;
        }
        self.outbox.push(if stored { Event::Stored } else { Event::NotStored });
        self.cycles.wake(now);
    }
}
