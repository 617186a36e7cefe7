//! Reads and writes of the objects that the node keeps: what they accept, and what follows from a write.

use super::abort::Abort;
use super::address::Sub;
use super::application::{Application, Notice, Written};
use super::cob_id::CobId;
use super::dictionary::Entry;
use super::heartbeat::{Consumer, supervised};
use super::node::Node;
use super::parameter::{Parameter, PdoField, PdoParameters};
use super::pdo::mapping::{self, Direction};
use super::pdo::{PdoNumber, TransmissionType};
use super::policy::Storing;
use crate::time::Instant;

/// `save` as 1010h takes it, the letter s in the low octet.
pub const SAVE: u32 = 0x6576_6173;
/// `load` as 1011h takes it.
pub const LOAD: u32 = 0x6461_6F6C;

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
    ) -> Result<Written, Abort> {
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
            Parameter::Store(group) => return self.store(now, Sub(group), app),
            Parameter::LoadDefaults(group) => return self.load_defaults(now, Sub(group), app),
            Parameter::ErrorRegister | Parameter::History(_) => return Err(Abort::READ_ONLY),
            Parameter::SyncId
            | Parameter::SyncPeriod
            | Parameter::SyncWindow
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
        if entry.stored && self.policy.storing == Storing::OnWrite {
            self.keep(parameter, value);
        }
        Ok(Written::Done)
    }

    /// Whether the value is accepted; the value that is kept.
    fn judge_parameter(&self, parameter: Parameter, value: u32) -> Result<u32, Abort> {
        match parameter {
            Parameter::HistoryCount if value != 0 => Err(Abort::RANGE),
            Parameter::SyncId => self.judge_sync_id(value),
            Parameter::EmcyId => {
                let value = self.judge_cob_id(self.values.emcy_id, value)?;
                if CobId(value).bit_30() { Err(Abort::RANGE) } else { Ok(value) }
            }
            Parameter::Consumer(place) => self.judge_consumer(place, value),
            Parameter::Store(_) if value != SAVE => Err(self.policy.wrong_signature),
            Parameter::LoadDefaults(_) if value != LOAD => Err(self.policy.wrong_signature),
            Parameter::Rpdo(pdo, field) => {
                self.judge_pdo(Direction::Receive, self.values.rpdo(pdo), field, value)
            }
            Parameter::Tpdo(pdo, field) => {
                self.judge_pdo(Direction::Transmit, self.values.tpdo(pdo), field, value)
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

    fn judge_sync_id(&self, value: u32) -> Result<u32, Abort> {
        let value = if self.policy.drop_sync_producer_bit { value & !CobId::BIT_30 } else { value };
        let id = CobId(value);
        if id.bit_30() || !id.is_valid() || !self.is_identifier(id) || id.is_restricted() {
            return Err(Abort::RANGE);
        }
        Ok(value)
    }

    /// The rules of COB-IDs of PDOs and EMCY: a service that is on keeps its identifier.
    fn judge_cob_id(&self, old: u32, new: u32) -> Result<u32, Abort> {
        let (old, id) = (CobId(old), CobId(new));
        if !self.is_identifier(id) || id.is_valid() && id.is_restricted() {
            return Err(Abort::RANGE);
        }
        match self.policy.change_while_valid {
            Some(code) if old.is_valid() && id.is_valid() && old.id() != id.id() => Err(code),
            Some(_) | None => Ok(new),
        }
    }

    fn is_identifier(&self, id: CobId) -> bool {
        id.id().is_some() && (self.policy.extended_ids || !id.is_extended())
    }

    fn judge_consumer(&self, place: u8, value: u32) -> Result<u32, Abort> {
        let [_, _, node, high] = value.to_le_bytes();
        if high != 0 || node > 127 {
            return Err(Abort::RANGE);
        }
        let Some((node, _)) = supervised(value) else { return Ok(value) };
        let others = self.values.consumers.iter().enumerate();
        let mut others = others.filter(|(other, _)| *other != usize::from(place));
        let twice = others.any(|(_, entry)| supervised(*entry).is_some_and(|(other, _)| other == node));
        if twice { Err(Abort::PARAMETER) } else { Ok(value) }
    }

    fn judge_pdo(
        &self,
        direction: Direction,
        values: &PdoParameters,
        field: PdoField,
        value: u32,
    ) -> Result<u32, Abort> {
        let on = CobId(values.cob_id).is_valid();
        match (field, direction) {
            (PdoField::CobId, Direction::Receive) => {
                let value = self.judge_cob_id(values.cob_id, value)?;
                if CobId(value).bit_30() { Err(Abort::RANGE) } else { Ok(value) }
            }
            (PdoField::CobId, Direction::Transmit) => {
                let value = if self.policy.tpdo_rtr { value } else { value & !CobId::BIT_30 };
                self.judge_cob_id(values.cob_id, value)
            }
            (PdoField::Type, Direction::Receive | Direction::Transmit) => {
                let exists = u8::try_from(value).is_ok_and(|kind| TransmissionType(kind).exists());
                if exists { Ok(value) } else { Err(Abort::RANGE) }
            }
            (PdoField::Count, direction) => {
                if on {
                    return Err(self.policy.wrong_state);
                }
                let count = usize::try_from(value).unwrap_or(usize::MAX);
                let words = values.mapped.get(..count).ok_or(Abort::PDO_LENGTH)?;
                mapping::judge_count(self.objects, direction, words)?;
                Ok(value)
            }
            (PdoField::Mapped(_), direction) => {
                if on || values.count != 0 {
                    return Err(self.policy.wrong_state);
                }
                mapping::judge_word(self.objects, direction, value)?;
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
                if let Some(consumer) = self.consumers.get_mut(usize::from(place)) {
                    *consumer = Consumer::Waiting;
                }
            }
            Parameter::SyncWindow => self.sync_window_ends = None,
            Parameter::Rpdo(pdo, _) => self.set_up_rpdo(pdo),
            Parameter::Tpdo(pdo, PdoField::EventTimer) => self.restart_event_timer(now, pdo),
            Parameter::Tpdo(_, PdoField::Inhibit | PdoField::Reserved | PdoField::SyncStart) => {}
            Parameter::Tpdo(
                pdo,
                PdoField::CobId | PdoField::Type | PdoField::Count | PdoField::Mapped(_),
            ) => self.set_up_tpdo(now, pdo, app),
            Parameter::ErrorRegister
            | Parameter::HistoryCount
            | Parameter::History(_)
            | Parameter::SyncId
            | Parameter::SyncPeriod
            | Parameter::GuardTime
            | Parameter::LifeTimeFactor
            | Parameter::Store(_)
            | Parameter::LoadDefaults(_)
            | Parameter::EmcyId
            | Parameter::EmcyInhibit
            | Parameter::ErrorBehaviour => {}
        }
    }

    /// Puts all values into effect, after a reset.
    pub(super) fn follow_all(&mut self, now: Instant, app: &dyn Application) {
        self.restart_heartbeat(now);
        self.sync_window_ends = None;
        self.consumers = [Consumer::Waiting; super::parameter::MAX_CONSUMERS];
        for pdo in PdoNumber::ALL {
            self.set_up_rpdo(pdo);
            self.set_up_tpdo(now, pdo, app);
        }
    }
}
