//! What is read and written behind the node.

use super::Behaviour;
use super::FromEds;
use super::dictionary::{FIRST_OWN, Role, Row};
use crate::can_bus::canopen::address::Sub;
use crate::can_bus::canopen::application::MAX_BESIDE;
use crate::can_bus::canopen::dictionary::Object;
use crate::can_bus::canopen::{
    Abort, Address, Application, NodeId, Notice, Part, Request, Reset, Source, Value, Written,
};
use crate::time::Instant;

impl FromEds {
    fn row(&self, at: Address) -> Result<(usize, &'static Row), Abort> {
        let dictionary = self.dictionary;
        let place = dictionary.place(at).ok_or(Abort::INTERNAL)?;
        Ok((place, dictionary.rows.get(place).ok_or(Abort::INTERNAL)?))
    }
}

impl Application for FromEds {
    fn objects(&self) -> &'static [Object] {
        self.dictionary.objects
    }

    fn node_id(&self) -> NodeId {
        self.node
    }

    fn read(&self, at: Address) -> Result<Value<'_>, Abort> {
        let (place, row) = self.row(at)?;
        match self.told(row) {
            Some(value) => Ok(value),
            None => self.memory.read(place, row).ok_or(Abort::INTERNAL),
        }
    }

    fn write(
        &mut self,
        now: Instant,
        at: Address,
        value: Value<'_>,
        source: Source,
    ) -> Result<Written, Abort> {
        let (place, row) = self.row(at)?;
        row.judge(value, self.node)?;
        self.judge_driven(row, value)?;
        self.judge_encoder(row, value)?;
        value.with_octets(|octets| match source {
            Source::Image => {
                self.memory.keep(place, octets);
                Ok(())
            }
            Source::Sdo | Source::Rpdo(_) => self.memory.set(place, row, octets),
        })?;
        match (row.role, source) {
            (Role::Value | Role::Actual(..), _) | (_, Source::Image) => {}
            (Role::Setting(..), _) => self.drive_written(now, row, value, source),
            (Role::Io(point), _) => self.io_written(point, value),
            (Role::Encoder(part), _) => self.encoder_written(part, value),
        }
        Ok(Written::Done)
    }

    fn write_part(
        &mut self,
        _: Instant,
        at: Address,
        Part { offset, octets, last }: Part<'_>,
    ) -> Result<Written, Abort> {
        let (place, row) = self.row(at)?;
        if let Some(whole) = self.memory.take_part(offset, octets, last)? {
            self.memory.set(place, row, &whole)?;
        }
        Ok(Written::Done)
    }

    fn notice(&mut self, now: Instant, notice: Notice) {
        if let Notice::Reset(reset) = notice {
            if reset == Reset::PowerOn {
                self.next = self.kept;
            }
            self.node = self.next;
            self.memory.at_node(self.node);
        }
        match notice {
            // What is set from outside stays as it is.
            Notice::Reset(Reset::PowerOn | Reset::Node) => {
                self.memory.restore(self.dictionary, |row| row.input.is_none());
            }
            Notice::Reset(Reset::Communication) => {
                self.memory.restore(self.dictionary, |row| row.at.index.0 < FIRST_OWN);
            }
            Notice::Nmt { .. }
            | Notice::Sync
            | Notice::RpdoTaken(_)
            | Notice::RpdoRefused { .. }
            | Notice::RpdoLength { .. }
            | Notice::LifeGuardingExpired(_)
            | Notice::LifeGuardingBack
            | Notice::HeartbeatLost(_)
            | Notice::HeartbeatBack(_)
            | Notice::SyncMissing(_)
            | Notice::HistoryCleared
            | Notice::NotStored => {}
        }
        match self.behaviour {
            Behaviour::Memory => {}
            Behaviour::Drive(_) => self.notice_driven(now, notice),
            Behaviour::Io(_) => self.notice_io(notice),
            Behaviour::Encoder(_) => self.notice_encoder(notice),
        }
    }

    fn advance(&mut self, now: Instant) {
        match &mut self.behaviour {
            Behaviour::Memory => {}
            Behaviour::Drive(driven) => driven.advance(now),
            Behaviour::Io(_) => self.advance_io(now),
            Behaviour::Encoder(encoder) => encoder.advance(now),
        }
    }

    fn poll_timeout(&self) -> Option<Instant> {
        match &self.behaviour {
            Behaviour::Memory => None,
            Behaviour::Drive(driven) => driven.poll_timeout(),
            Behaviour::Io(io) => io.due(),
            Behaviour::Encoder(encoder) => encoder.due(),
        }
    }

    fn power_off(&mut self) {
        match &mut self.behaviour {
            Behaviour::Drive(driven) => driven.power_off(),
            Behaviour::Io(io) => io.requests.clear(),
            Behaviour::Memory | Behaviour::Encoder(_) => {}
        }
    }

    fn poll_request(&mut self) -> Option<Request> {
        match &mut self.behaviour {
            Behaviour::Drive(driven) => driven.poll_request(),
            Behaviour::Io(io) => io.requests.pop_front(),
            Behaviour::Memory | Behaviour::Encoder(_) => None,
        }
    }

    fn read_by_client(&mut self, at: Address) {
        if let Behaviour::Io(_) = self.behaviour
            && let Ok((_, Row { role: Role::Io(point), .. })) = self.row(at)
        {
            self.io_read(*point);
        }
    }

    fn tells_changes(&self, at: Address) -> bool {
        match &self.behaviour {
            Behaviour::Io(_) => {
                matches!(self.row(at), Ok((_, Row { role: Role::Io(point), .. })) if point.is_input())
            }
            Behaviour::Memory | Behaviour::Drive(_) | Behaviour::Encoder(_) => false,
        }
    }

    fn store(&mut self, _: Instant, group: Sub) -> Result<Written, Abort> {
        self.memory.store(self.dictionary, group)?;
        if let Behaviour::Encoder(encoder) = &mut self.behaviour {
            encoder.keep(group);
        }
        Ok(Written::Done)
    }

    fn load_defaults(&mut self, _: Instant, group: Sub) -> Result<Written, Abort> {
        self.memory.forget(self.dictionary, group);
        if let Behaviour::Encoder(encoder) = &mut self.behaviour {
            encoder.forget(group);
        }
        Ok(Written::Done)
    }

    fn lss_rates(&self) -> Option<[bool; 9]> {
        // 750 and 100 kbit/s are not in the table, 5 is reserved.
        const RATES: [u16; 9] = [1000, 800, 500, 250, 125, 0, 50, 20, 10];
        let device = &self.dictionary.eds.device;
        device.lss.then(|| RATES.map(|rate| device.kilobits.contains(&rate)))
    }

    fn change_node_id(&mut self, node: NodeId) -> bool {
        self.next = node;
        true
    }

    fn keep_node_id(&mut self) {
        self.kept = self.next;
    }

    fn kept_beside(&self, into: &mut [u8; MAX_BESIDE]) -> usize {
        let number = self.dictionary.eds.device.lss.then(|| self.kept.number());
        let offset = match &self.behaviour {
            Behaviour::Encoder(encoder) => Some(encoder.kept_offset()),
            Behaviour::Memory | Behaviour::Drive(_) | Behaviour::Io(_) => None,
        };
        let octets = number.into_iter().chain(offset.into_iter().flatten());
        into.iter_mut().zip(octets).map(|(into, octet)| *into = octet).count()
    }

    fn recall_beside(&mut self, octets: &[u8]) {
        let (number, rest) = match octets.split_first() {
            Some((number, rest)) if self.dictionary.eds.device.lss => (Some(*number), rest),
            Some(_) | None => (None, octets),
        };
        if let Some(Ok(node)) = number.map(NodeId::new) {
            self.kept = node;
        }
        if let (Behaviour::Encoder(encoder), Ok(offset)) = (&mut self.behaviour, rest.try_into()) {
            encoder.recall_offset(offset);
        }
    }

    fn product(&self) -> &str {
        &self.dictionary.product
    }

    fn kept(&self, at: Address) -> Result<Value<'_>, Abort> {
        let (place, row) = self.row(at)?;
        // What is not kept is the default of the file, also of the next one.
        self.memory.kept(place, row).filter(|_| row.is_stored()).ok_or(Abort::NO_DATA)
    }
}
