//! What a station from a GSD tells of its records and alarms, and what is done to them by hand.

use super::GsdStation;
use crate::face::acyclic::{NewAlarm, NewStatus, OwnersChannel, Record, SERVICE_REFUSED};
use crate::face::description::Denied;
use crate::face::{Acyclic, Reason};
use crate::host::ByHand;
use crate::profibus::dpv1::{AlarmHead, AlarmState, AlarmType, Link, NotRaised};
use crate::time::Instant;

/// The types that the standard names; those of the manufacturer count as one.
const TYPES: [AlarmType; 7] = [
    AlarmType::Diagnostic,
    AlarmType::Process,
    AlarmType::Pull,
    AlarmType::Plug,
    AlarmType::Status,
    AlarmType::Update,
    AlarmType::Manufacturer(32),
];

impl Acyclic for GsdStation {
    fn channel(&self) -> OwnersChannel {
        let services = self.services();
        services
            .map(|services| OwnersChannel { open: services.is_open(), busy: services.is_busy() })
            .unwrap_or_default()
    }

    fn each_obstacle(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        let Some(acyclic) = &self.acyclic else { return };
        let slave = self.station.slave();
        acyclic.services.each_obstacle(slave, &mut |obstacle| tell(Reason::new(obstacle.name(), &obstacle)));
        if let Some(event) = acyclic.refused.event() {
            tell(Reason::new(SERVICE_REFUSED, event));
        }
    }

    fn each_link(&self, tell: &mut dyn FnMut(Link)) {
        if let Some(services) = self.services() {
            services.links().for_each(tell);
        }
    }

    fn most_links(&self) -> u8 {
        self.services().and_then(|services| services.offer().ms2).map_or(0, |ms2| ms2.connections)
    }

    fn each_record(&self, tell: &mut dyn FnMut(Record<'_>)) {
        for ((slot, index), record) in self.records().into_iter().flat_map(|records| records.iter()) {
            tell(Record { slot, index, data: &record.data, read: record.read, write: record.write });
        }
    }

    fn change_record(&mut self, now: Instant, (slot, index): (u8, u8), data: &[u8]) -> Result<(), Denied> {
        self.now = now;
        let records = self.records_mut().ok_or(Denied::Unknown)?;
        records.record(slot, index).ok_or(Denied::Unknown)?;
        if !records.change(slot, index, data) {
            return Err(Denied::Value);
        }
        self.tell(ByHand::RecordChanged { slot, index });
        Ok(())
    }

    fn each_identification(&self, tell: &mut dyn FnMut(u16, &[u8; 64], bool)) {
        let Some(records) = self.records() else { return };
        if let Some(identification) = &records.identification {
            tell(0, &identification.octets(), false);
        }
        for (block, octets) in &records.blocks {
            tell(*block, octets, true);
        }
    }

    fn each_alarm_type(&self, tell: &mut dyn FnMut(AlarmType)) {
        let Some(services) = self.services() else { return };
        TYPES.into_iter().filter(|kind| services.offer().alarms.has(*kind)).for_each(tell);
    }

    fn each_alarm(&self, tell: &mut dyn FnMut(AlarmHead, &[u8], AlarmState)) {
        for alarm in self.services().map(|services| services.alarms()).unwrap_or_default() {
            tell(alarm.head, &alarm.data, alarm.state);
        }
    }

    fn raise_alarm(&mut self, now: Instant, new: &NewAlarm<'_>) -> Result<AlarmHead, NotRaised> {
        self.now = now;
        let about = (new.slot, new.specifier, new.additional_ack);
        let alarm = Self::raise_alarm(self, new.kind, about, new.data)?;
        self.tell(ByHand::AlarmRaised { alarm });
        Ok(alarm)
    }

    fn forget_alarms(&mut self, now: Instant) {
        self.now = now;
        Self::forget_alarms(self);
        self.tell(ByHand::AlarmsForgotten);
    }

    fn send_status(&mut self, now: Instant, new: &NewStatus<'_>) -> Result<(), NotRaised> {
        self.now = now;
        let NewStatus { kind, slot, specifier, data } = *new;
        let Self { acyclic, station, .. } = self;
        let acyclic = acyclic.as_mut().ok_or(NotRaised::NotEnabled)?;
        acyclic.services.send_status(station, kind, slot, specifier, data)?;
        self.tell(ByHand::StatusSent { kind, slot });
        Ok(())
    }
}
