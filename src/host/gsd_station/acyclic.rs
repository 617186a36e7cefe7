//! DP-V1 of a station from a GSD: what its keywords promise, beside its slave.

use super::GsdStation;
use super::records::StationRecords;
use crate::devices::StationEvent;
use crate::gsd::{Gsd, Placed};
use crate::profibus::dp::{self, ExtDiag};
use crate::profibus::dpv1::{
    self, AlarmHead, AlarmType, Identification, LastRefused, NotRaised, Specifier, Text,
};
use crate::profibus::fdl::Telegram;
use crate::time::Instant;

/// The most connections that a GSD can have.
const CONNECTIONS: usize = 49;

/// The most alarms that a master takes.
const ALARMS: usize = 32;

/// Services of DP-V1 and the records behind them.
pub(super) struct Acyclic {
    pub(super) services: dpv1::Acyclic<CONNECTIONS, ALARMS>,
    pub(super) records: StationRecords,
    pub(super) refused: LastRefused,
}

impl Acyclic {
    /// What a file promises; `None`: nothing.
    pub(super) fn of(gsd: &Gsd, mut records: StationRecords) -> Option<Box<Self>> {
        let offer = gsd.acyclic.offer(records.min_send_timeout);
        if !gsd.flags.dpv1 || offer.is_none() && !gsd.flags.prm_blocks {
            return None;
        }
        if gsd.acyclic.identification && records.identification.is_none() {
            let order = if gsd.order_number.is_empty() { &gsd.model } else { &gsd.order_number };
            records.identification =
                Some(Identification { order_id: Text::of(order), ..Identification::PLAIN });
        }
        let services = dpv1::Acyclic::new(offer);
        let services = if gsd.flags.prm_blocks { services.with_ext_prm() } else { services };
        Some(Box::new(Self { services, records, refused: LastRefused::default() }))
    }

    /// The slots of a configuration: 0 is the station, its modules count from 1, whatever displays show.
    pub(super) fn lay_out(&mut self, gsd: &Gsd, layout: &[Placed]) {
        let first = gsd.slot_offset;
        let numbers = layout.iter().map(|placed| placed.slot.number.saturating_sub(first).saturating_add(1));
        self.records.slots = numbers.filter_map(|number| u8::try_from(number).ok()).collect();
    }
}

impl GsdStation {
    /// The same station with these records.
    #[must_use]
    pub fn with_records(mut self, records: StationRecords) -> Self {
        self.acyclic = Acyclic::of(self.gsd(), records);
        let Self { acyclic, station, layout, .. } = &mut self;
        if let Some(acyclic) = acyclic {
            acyclic.lay_out(station.slave().application().gsd(), layout);
        }
        self.report(self.now);
        self
    }

    /// Its services of DP-V1; `None`: it has none.
    pub fn services(&self) -> Option<&dpv1::Acyclic<CONNECTIONS, ALARMS>> {
        self.acyclic.as_ref().map(|acyclic| &acyclic.services)
    }

    /// Its records; `None`: it has no services of DP-V1.
    pub fn records(&self) -> Option<&StationRecords> {
        self.acyclic.as_ref().map(|acyclic| &acyclic.records)
    }

    /// Its records, to be changed.
    pub fn records_mut(&mut self) -> Option<&mut StationRecords> {
        self.acyclic.as_mut().map(|acyclic| &mut acyclic.records)
    }

    /// Raises an alarm.
    ///
    /// # Errors
    /// [`NotRaised`]
    pub fn raise_alarm(
        &mut self,
        kind: AlarmType,
        (slot, specifier, additional_ack): (u8, Specifier, bool),
        data: &[u8],
    ) -> Result<AlarmHead, NotRaised> {
        let Self { acyclic, station, .. } = self;
        let acyclic = acyclic.as_mut().ok_or(NotRaised::NotOffered(kind))?;
        acyclic.services.raise(station, kind, (slot, specifier, additional_ack), data)
    }

    /// Forgets every alarm, as if none had been raised.
    pub(crate) fn forget_alarms(&mut self) {
        let Self { acyclic, station, .. } = self;
        if let Some(acyclic) = acyclic {
            acyclic.services.forget_alarms(station);
        }
    }

    /// Hands a telegram to the slave and to what is beside it.
    pub(super) fn hear(&mut self, now: Instant, telegram: &Telegram<'_>) -> dp::Outcome {
        let Self { acyclic, station, .. } = self;
        match acyclic {
            Some(acyclic) => acyclic.services.handle_telegram(station, &mut acyclic.records, now, telegram),
            None => station.handle_telegram(now, telegram),
        }
    }

    /// Tells both that time has passed.
    pub(super) fn pass(&mut self, now: Instant) -> Option<dp::Event> {
        let Self { acyclic, station, .. } = self;
        match acyclic {
            Some(acyclic) => acyclic.services.handle_timeout(station, now),
            None => station.handle_timeout(now),
        }
    }

    /// Tells what happened in its services.
    pub(super) fn tell_services(&mut self, news: &mut dyn FnMut(StationEvent)) {
        let Some(acyclic) = &mut self.acyclic else { return };
        while let Some(event) = acyclic.services.poll_event() {
            acyclic.refused.notice(&event);
            news(StationEvent::Acyclic(event));
        }
    }

    /// When a connection ends.
    pub(super) fn service_timeout(&self) -> Option<Instant> {
        self.acyclic.as_ref()?.services.poll_timeout()
    }

    /// Files what the diagnosis reports.
    pub(super) fn file(&mut self, diagnosis: &ExtDiag) {
        let Self { acyclic, station, .. } = self;
        match acyclic {
            Some(acyclic) => acyclic.services.file_diagnosis(station, diagnosis),
            None => station.file_diagnosis(diagnosis),
        }
    }
}
