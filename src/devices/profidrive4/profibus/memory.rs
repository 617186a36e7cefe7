//! What the drive keeps while it is switched off: its address, and the parameters as they were stored (PNU 971).

use super::application::TelegramOnly;
use super::{Event, ProfidriveDevice};
use crate::profibus::dp::{Application, StoredAddress};
use crate::time::Instant;

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

    /// The host keeps what is stored from now on: see [`ProfidriveDevice::take_changed`].
    pub(crate) const fn keep_parameters(&mut self) {
        self.is_kept = true;
    }

    /// Whether there is something new to be kept, which the host reports with [`ProfidriveDevice::handle_stored`].
    pub(crate) const fn take_changed(&mut self) -> bool {
        core::mem::replace(&mut self.changed, false)
    }

    /// Every value to be kept: those that are being stored, else those stored before.
    pub(crate) fn to_keep(&self) -> Vec<((u16, u8), u32)> {
        self.storing.as_ref().unwrap_or(&self.stored).clone()
    }

    /// The address that Set_Slave_Add gave it.
    pub(crate) const fn stored_address(&self) -> StoredAddress {
        self.station.stored_address()
    }

    /// The drive is as it was before it was switched off. Values that its table does not take any more are left out.
    pub(crate) fn recall(
        &mut self,
        (address, rem_slave_data): (StoredAddress, &[u8]),
        stored: Vec<((u16, u8), u32)>,
    ) {
        self.station.recall(address, rem_slave_data);
        if !stored.is_empty() {
            self.parameters.recall(&self.known(), &stored);
            self.stored = self.parameters.kept(&self.known());
        }
    }

    /// What was kept is safe, or could not be kept: then what was stored before stays.
    pub(crate) fn handle_stored(&mut self, now: Instant, stored: bool) {
        let Some(values) = self.storing.take() else { return };
        self.parameters.storing = false;
        if stored {
            self.stored = values;
        }
        self.outbox.push(if stored { Event::Stored } else { Event::NotStored });
        self.cycles.wake(now);
    }
}
