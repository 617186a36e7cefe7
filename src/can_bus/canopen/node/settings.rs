//! Reads and writes of the objects that the node keeps: what they accept, and what follows from a write.

use super::Node;
use super::heartbeat::{Consumer, supervised};
use super::rpdo::Rpdo;
use super::tpdo::Tpdo;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::abort::Abort;
use crate::can_bus::canopen::address::{Address, Sub};
use crate::can_bus::canopen::application::{Application, Notice, Written};
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::dictionary::{Entry, Limits};
use crate::can_bus::canopen::event::{Identified, NoEffect};
use crate::can_bus::canopen::nmt::NmtState;
use crate::can_bus::canopen::parameter::{Parameter, PdoField, PdoParameters};
use crate::can_bus::canopen::pdo;
use crate::can_bus::canopen::pdo::TransmissionType;
use crate::can_bus::canopen::pdo::mapping::{self, Direction};
use crate::can_bus::canopen::policy::{Storing, SyncProducer};
use crate::can_bus::canopen::refusal::{Broken, Rule};
use crate::time::Instant;

/// `save` as 1010h takes it, the letter s in the low octet.
pub(crate) const SAVE: u32 = 0x6576_6173;
/// `load` as 1011h takes it.
pub(crate) const LOAD: u32 = 0x6461_6F6C;

/// An identifier that CiA 301 has for something else.
const RESERVED: Rule = Rule::But("its identifier is reserved by CiA 301");

/// An identifier that has too many bits.
const TOO_WIDE: Rule = Rule::But(
    "its identifier has more than 11 bits, or bit 29 is 1: the device has no identifiers of 29 bits",
);

const fn without_bit_30(value: u32) -> Result<u32, Broken> {
    if CobId(value).bit_30() {
        return Err(Broken::rule(Abort::RANGE, Rule::But("bit 30 must be 0")));
    }
    Ok(value)
}

impl Node {
    /// The value of an object that the node keeps.
    pub(super) fn parameter(&self, parameter: Parameter) -> Result<u32, Abort> {
        match parameter {
            Parameter::ErrorRegister => Ok(self.errors.register().into()),
            Parameter::HistoryCount => Ok(self.errors.count()),
            Parameter::History(sub) => match (self.errors.entry(sub), self.policy.empty_history) {
                (Some(entry), _) => Ok(entry),
                (None, None) => Ok(0),
                (None, Some(code)) => Err(code),
            },
            Parameter::Store(_) | Parameter::LoadDefaults(_) => Ok(self.policy.store_reads),
            Parameter::SyncId
            | Parameter::SyncPeriod
            | Parameter::SyncWindow
            | Parameter::SyncCounter
            | Parameter::GuardTime
            | Parameter::LifeTimeFactor
            | Parameter::EmcyId
            | Parameter::EmcyInhibit
            | Parameter::Consumer(_)
            | Parameter::Heartbeat
            | Parameter::ErrorBehaviour
            | Parameter::Rpdo(..)
            | Parameter::Tpdo(..) => Ok(self.values.value(parameter)),
        }
    }

    /// Writes an object that the node keeps and does what follows from it.
    pub(super) fn write_parameter(
        &mut self,
        now: Instant,
        parameter: Parameter,
        entry: &'static Entry,
        value: u32,
        app: &mut dyn Application,
    ) -> Result<Written, Broken> {
        let value = self.judge_parameter(parameter, value)?;
        match parameter {
            Parameter::HistoryCount => {
                self.errors.clear_history();
                app.notice(now, Notice::HistoryCleared);
                if entry.stored {
                    self.storage.changed();
                }
                return Ok(Written::Done);
            }
            Parameter::Store(group) => return Ok(self.store(now, Sub(group), app)?),
            Parameter::LoadDefaults(group) => return Ok(self.load_defaults(now, Sub(group), app)?),
            Parameter::ErrorRegister | Parameter::History(_) => return Err(Abort::READ_ONLY.into()),
            Parameter::SyncId
            | Parameter::SyncPeriod
            | Parameter::SyncWindow
            | Parameter::SyncCounter
            | Parameter::GuardTime
            | Parameter::LifeTimeFactor
            | Parameter::EmcyId
            | Parameter::EmcyInhibit
            | Parameter::Consumer(_)
            | Parameter::Heartbeat
            | Parameter::ErrorBehaviour
            | Parameter::Rpdo(..)
            | Parameter::Tpdo(..) => self.values.set(parameter, value),
        }
        self.follow(now, parameter, app);
        if self.state == Some(NmtState::Operational) && parameter.is_identifier() {
            self.judge_identifiers();
        }
        if entry.stored && self.policy.storing == Storing::OnWrite {
            self.keep(parameter, value);
        }
        Ok(Written::Done)
    }

    /// Whether the value is accepted; the value that is kept.
    fn judge_parameter(&self, parameter: Parameter, value: u32) -> Result<u32, Broken> {
        match parameter {
            Parameter::HistoryCount if value != 0 => {
                Err(Broken::rule(Abort::RANGE, Rule::Limits(Limits::Range(0, 0))))
            }
            Parameter::SyncId => self.judge_sync_id(value),
            Parameter::SyncCounter => self.judge_sync_counter(value),
            Parameter::EmcyId => {
                let value = self.judge_cob_id(
                    self.values.emcy_id,
                    value,
                    Rule::But("EMCY is on: write 1014h with bit 31 = 1 first"),
                )?;
                without_bit_30(value)
            }
            Parameter::Consumer(place) => self.judge_consumer(place, value),
            Parameter::Store(_) if value != SAVE => {
                Err(Broken::rule(self.policy.wrong_signature, Rule::But("only \"save\" is taken, 65766173h")))
            }
            Parameter::LoadDefaults(_) if value != LOAD => {
                Err(Broken::rule(self.policy.wrong_signature, Rule::But("only \"load\" is taken, 64616F6Ch")))
            }
            Parameter::Rpdo(pdo, field) => {
                self.judge_pdo(Direction::Receive, self.values.rpdos.of(pdo), field, value)
            }
            Parameter::Tpdo(pdo, field) => {
                self.judge_pdo(Direction::Transmit, self.values.tpdos.of(pdo), field, value)
            }
            Parameter::ErrorRegister
            | Parameter::HistoryCount
            | Parameter::History(_)
            | Parameter::SyncPeriod
            | Parameter::SyncWindow
            | Parameter::GuardTime
            | Parameter::LifeTimeFactor
            | Parameter::Store(_)
            | Parameter::LoadDefaults(_)
            | Parameter::EmcyInhibit
            | Parameter::Heartbeat
            | Parameter::ErrorBehaviour => Ok(value),
        }
    }

    fn judge_sync_id(&self, value: u32) -> Result<u32, Broken> {
        let value = match self.policy.sync_producer {
            SyncProducer::Dropped => value & !CobId::BIT_30,
            SyncProducer::Refused | SyncProducer::Produced => value,
        };
        let (id, old) = (CobId(value), CobId(self.values.sync_id));
        match self.policy.sync_producer {
            SyncProducer::Refused | SyncProducer::Dropped if id.bit_30() || !id.is_valid() => {
                return Err(Broken::rule(Abort::RANGE, Rule::But("bits 30 and 31 must be 0")));
            }
            SyncProducer::Produced if id.bit_30() && old.bit_30() && id.id() != old.id() => {
                return Err(Broken::rule(
                    self.policy.wrong_state,
                    Rule::But("the node produces SYNC (bit 30 is 1)"),
                ));
            }
            SyncProducer::Refused | SyncProducer::Dropped | SyncProducer::Produced => {}
        }
        self.judge_width(id)?;
        if id.is_restricted() {
            return Err(Broken::rule(Abort::RANGE, RESERVED));
        }
        Ok(value)
    }

    /// The highest SYNC counter: 0 none, 2 to 240.
    fn judge_sync_counter(&self, value: u32) -> Result<u32, Broken> {
        if self.values.sync_period != 0 && value != u32::from(self.values.sync_counter) {
            let rule = Rule::But("SYNC has a period (1006h is not 0)");
            return Err(Broken::rule(self.policy.wrong_state, rule));
        }
        match value {
            0 | 2..=240 => Ok(value),
            1 | 241.. => Err(Broken::rule(Abort::RANGE, Rule::But("it must be 0 or 2 to 240"))),
        }
    }

    /// The rules of COB-IDs of PDOs and EMCY: a service that is on keeps its identifier. `on` says that it is on.
    fn judge_cob_id(&self, old: u32, new: u32, on: Rule) -> Result<u32, Broken> {
        let (old, id) = (CobId(old), CobId(new));
        self.judge_width(id)?;
        if id.is_valid() && id.is_restricted() {
            return Err(Broken::rule(Abort::RANGE, RESERVED));
        }
        match self.policy.change_while_valid {
            Some(code) if old.is_valid() && id.is_valid() && old.id() != id.id() => {
                Err(Broken::rule(code, on))
            }
            Some(_) | None => Ok(new),
        }
    }

    fn judge_width(&self, id: CobId) -> Result<(), Broken> {
        let fits = id.id().is_some() && (self.policy.extended_ids || !id.is_extended());
        if fits { Ok(()) } else { Err(Broken::rule(Abort::RANGE, TOO_WIDE)) }
    }

    fn judge_consumer(&self, place: u8, value: u32) -> Result<u32, Broken> {
        let [_, _, node, high] = value.to_le_bytes();
        if high != 0 || node > 127 {
            return Err(Broken::rule(
                Abort::RANGE,
                Rule::But("bits 16 to 31 must be a node number, 0 to 127"),
            ));
        }
        let Some((node, _)) = supervised(value) else { return Ok(value) };
        let others = self.values.consumers.iter().enumerate();
        let mut others = others.filter(|(other, _)| *other != usize::from(place));
        let twice = others.find(|(_, entry)| supervised(**entry).is_some_and(|(other, _)| other == node));
        if let Some((other, _)) = twice {
            let sub = u8::try_from(other + 1).unwrap_or(u8::MAX);
            let rule = Rule::Supervised(Address::new(0x1016, sub));
            return Err(Broken::rule(Abort::PARAMETER, rule));
        }
        Ok(value)
    }

    fn judge_pdo(
        &self,
        direction: Direction,
        values: &PdoParameters,
        field: PdoField,
        value: u32,
    ) -> Result<u32, Broken> {
        let on = CobId(values.cob_id).is_valid();
        let first = match direction {
            Direction::Receive => 0x1400,
            Direction::Transmit => 0x1800,
        };
        // What is in the way of another identifier or another mapping.
        let is_on = Rule::PdoOn(Address { index: values.number.object(first), sub: Sub(1) });
        match (field, direction) {
            (PdoField::CobId, Direction::Receive) => {
                let value = self.judge_cob_id(values.cob_id, value, is_on)?;
                without_bit_30(value)
            }
            (PdoField::CobId, Direction::Transmit) => {
                let value = if self.policy.tpdo_rtr { value } else { value & !CobId::BIT_30 };
                self.judge_cob_id(values.cob_id, value, is_on)
            }
            (PdoField::Type, Direction::Receive | Direction::Transmit) => {
                let exists = u8::try_from(value).is_ok_and(|kind| TransmissionType(kind).exists());
                let reserved = Rule::Limits(Limits::Ranges(&[(0, 240), (252, 255)]));
                if exists { Ok(value) } else { Err(Broken::rule(Abort::RANGE, reserved)) }
            }
            (PdoField::Count, direction) => {
                if on {
                    return Err(Broken::rule(self.policy.wrong_state, is_on));
                }
                let count = usize::try_from(value).unwrap_or(usize::MAX);
                let words = values.mapped.get(..count).ok_or(Abort::PDO_LENGTH)?;
                mapping::judge_count(self.objects, direction, words, self.policy.dummies)?;
                Ok(value)
            }
            (PdoField::Mapped(_), direction) => {
                let in_use = Rule::But("the mapping is in use: write its sub-index 0 = 0 first");
                let rule = if on { is_on } else { in_use };
                if on || values.count != 0 {
                    return Err(Broken::rule(self.policy.wrong_state, rule));
                }
                mapping::judge_word(self.objects, direction, value, self.policy.dummies)?;
                Ok(value)
            }
            (
                PdoField::Inhibit | PdoField::Reserved | PdoField::EventTimer | PdoField::SyncStart,
                Direction::Receive | Direction::Transmit,
            ) => Ok(value),
        }
    }

    /// Puts a written value into effect.
    fn follow(&mut self, now: Instant, parameter: Parameter, app: &dyn Application) {
        match parameter {
            Parameter::Heartbeat => self.restart_heartbeat(now),
            Parameter::Consumer(place) => {
                self.set_consumer(place.into(), Consumer::Waiting);
            }
            Parameter::SyncWindow => self.sync_window_ends = None,
            Parameter::SyncId | Parameter::SyncPeriod | Parameter::SyncCounter => self.restart_sync(now),
            Parameter::Rpdo(pdo, _) => {
                self.pdos_are_used(now);
                if let Some(place) = self.values.rpdos.place(pdo) {
                    self.set_up_rpdo(place);
                }
            }
            Parameter::Tpdo(pdo, PdoField::EventTimer) => {
                if let Some(place) = self.values.tpdos.place(pdo) {
                    self.restart_event_timer(now, place);
                }
            }
            Parameter::Tpdo(_, PdoField::Inhibit | PdoField::Reserved | PdoField::SyncStart) => {}
            Parameter::Tpdo(
                pdo,
                PdoField::CobId | PdoField::Type | PdoField::Count | PdoField::Mapped(_),
            ) => {
                self.pdos_are_used(now);
                if let Some(place) = self.values.tpdos.place(pdo) {
                    self.set_up_tpdo(now, place, app);
                }
            }
            Parameter::ErrorRegister
            | Parameter::HistoryCount
            | Parameter::History(_)
            | Parameter::GuardTime
            | Parameter::LifeTimeFactor
            | Parameter::Store(_)
            | Parameter::LoadDefaults(_)
            | Parameter::EmcyId
            | Parameter::EmcyInhibit
            | Parameter::ErrorBehaviour => {}
        }
    }

    /// A service whose identifier can be written, while it is on: SYNC, EMCY, the RPDOs, the TPDOs.
    fn identified(&self, place: usize) -> Option<(Identified, Id)> {
        let rpdo = place.wrapping_sub(2);
        let tpdo = rpdo.wrapping_sub(self.rpdos.len());
        match place {
            0 => Some((Identified::Sync, CobId(self.values.sync_id).id()?)),
            1 => Some((Identified::Emcy, CobId(self.values.emcy_id).active()?)),
            _ => match (self.rpdos.get(rpdo), self.tpdos.get(tpdo)) {
                (Some(it), _) => Some((Identified::Rpdo(self.values.rpdos.at(rpdo).number), it.id?)),
                (None, Some(it)) => Some((Identified::Tpdo(self.values.tpdos.at(tpdo).number), it.id?)),
                (None, None) => None,
            },
        }
    }

    /// In OPERATIONAL: tells of two services that have one identifier.
    pub(super) fn judge_identifiers(&mut self) {
        let all = 2 + self.rpdos.len() + self.tpdos.len();
        for place in 2..all {
            let Some((pdo, id)) = self.identified(place) else { continue };
            let mut others = (0..place).filter_map(|place| self.identified(place));
            if let Some((other, _)) = others.find(|(_, other)| *other == id) {
                return self.no_effect(NoEffect::SameIdentifier { pdo, other, id: id.number() });
            }
        }
    }

    /// Puts all values into effect, after a reset.
    pub(super) fn follow_all(&mut self, now: Instant, app: &dyn Application) {
        self.restart_heartbeat(now);
        self.restart_sync(now);
        self.sync_window_ends = None;
        self.consumers = [Consumer::Waiting; crate::can_bus::canopen::parameter::MAX_CONSUMERS];
        self.consumer_due = None;
        // As many as the dictionary has.
        self.rpdos.clear();
        for _ in 0..self.values.rpdos.len() {
            pdo::add(&mut self.rpdos, Rpdo::OFF);
        }
        self.tpdos.clear();
        for _ in 0..self.values.tpdos.len() {
            pdo::add(&mut self.tpdos, Tpdo::OFF);
        }
        (0..self.rpdos.len()).for_each(|place| self.set_up_rpdo(place));
        (0..self.tpdos.len()).for_each(|place| self.set_up_tpdo(now, place, app));
    }
}
