//! The communication objects that a node keeps itself, and their values.
//!
//! | objects | hold |
//! | --- | --- |
//! | 1001h, 1003h | error register, history |
//! | 1005h, 1006h, 1007h | SYNC: COB-ID, period, window |
//! | 100Ch, 100Dh | guarding: time, life time factor |
//! | 1010h, 1011h | store, load defaults |
//! | 1014h, 1015h | EMCY: COB-ID, inhibit time |
//! | 1016h, 1017h | heartbeat: consumers, producer |
//! | 1019h | SYNC counter |
//! | 1029h | error behaviour |
//! | 1400h, 1600h | RPDOs: communication, mapping |
//! | 1800h, 1A00h | TPDOs: communication, mapping |

use super::address::{Address, NodeId};
use super::dictionary::{Home, Object};
use super::pdo;
use super::pdo::{MAX_MAPPED, PdoNumber, PerPdo};

/// The most nodes under heartbeat supervision.
pub(crate) const MAX_CONSUMERS: usize = 8;

/// One value that the node keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// 1001h.
    ErrorRegister,
    /// 1003h:0.
    HistoryCount,
    /// 1003h:n, the newest is 1.
    History(u8),
    /// 1005h.
    SyncId,
    /// 1006h in microseconds.
    SyncPeriod,
    /// 1007h in microseconds.
    SyncWindow,
    /// 100Ch in milliseconds.
    GuardTime,
    /// 100Dh.
    LifeTimeFactor,
    /// 1010h:n.
    Store(u8),
    /// 1011h:n.
    LoadDefaults(u8),
    /// 1014h.
    EmcyId,
    /// 1015h in 100 microseconds.
    EmcyInhibit,
    /// 1016h:n, places from 0.
    Consumer(u8),
    /// 1017h in milliseconds.
    Heartbeat,
    /// 1019h.
    SyncCounter,
    /// 1029h:1.
    ErrorBehaviour,
    /// 14xxh and 16xxh.
    Rpdo(PdoNumber, PdoField),
    /// 18xxh and 1Axxh.
    Tpdo(PdoNumber, PdoField),
}

/// A value of one PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PdoField {
    /// Sub-index 1.
    CobId,
    /// Sub-index 2.
    Type,
    /// Sub-index 3 in 100 microseconds.
    Inhibit,
    /// Sub-index 4.
    Reserved,
    /// Sub-index 5 in milliseconds.
    EventTimer,
    /// Sub-index 6.
    SyncStart,
    /// Mapping, sub-index 0.
    Count,
    /// Mapping, sub-index n, places from 0.
    Mapped(u8),
}

impl Parameter {
    /// Whether it says which identifier a service has.
    pub(super) const fn is_identifier(self) -> bool {
        matches!(
            self,
            Self::SyncId | Self::EmcyId | Self::Rpdo(_, PdoField::CobId) | Self::Tpdo(_, PdoField::CobId)
        )
    }

    /// What the node keeps at `at`, if anything.
    pub(crate) const fn of(at: Address) -> Option<Self> {
        let (index, sub) = at.pair();
        Some(match (index, sub) {
            (0x1001, 0) => Self::ErrorRegister,
            (0x1003, 0) => Self::HistoryCount,
            (0x1003, 1..) => Self::History(sub),
            (0x1005, 0) => Self::SyncId,
            (0x1006, 0) => Self::SyncPeriod,
            (0x1007, 0) => Self::SyncWindow,
            (0x100C, 0) => Self::GuardTime,
            (0x100D, 0) => Self::LifeTimeFactor,
            (0x1010, 1..) => Self::Store(sub),
            (0x1011, 1..) => Self::LoadDefaults(sub),
            (0x1014, 0) => Self::EmcyId,
            (0x1015, 0) => Self::EmcyInhibit,
            (0x1016, 1..=8) => Self::Consumer(sub - 1),
            (0x1017, 0) => Self::Heartbeat,
            (0x1019, 0) => Self::SyncCounter,
            (0x1029, 1) => Self::ErrorBehaviour,
            (0x1400..=0x15FF, 1..=6) => match (pdo_number(index), communication(sub)) {
                (Some(pdo), Some(field)) => Self::Rpdo(pdo, field),
                (None, _) | (_, None) => return None,
            },
            (0x1800..=0x19FF, 1..=6) => match (pdo_number(index), communication(sub)) {
                (Some(pdo), Some(field)) => Self::Tpdo(pdo, field),
                (None, _) | (_, None) => return None,
            },
            (0x1600..=0x17FF, 0..=8) => match pdo_number(index) {
                Some(pdo) => Self::Rpdo(pdo, mapping(sub)),
                None => return None,
            },
            (0x1A00..=0x1BFF, 0..=8) => match pdo_number(index) {
                Some(pdo) => Self::Tpdo(pdo, mapping(sub)),
                None => return None,
            },
            (0.., 0..) => return None,
        })
    }
}

const fn pdo_number(index: u16) -> Option<PdoNumber> {
    PdoNumber::new((index & 0x1FF) + 1)
}

const fn communication(sub: u8) -> Option<PdoField> {
    Some(match sub {
        1 => PdoField::CobId,
        2 => PdoField::Type,
        3 => PdoField::Inhibit,
        4 => PdoField::Reserved,
        5 => PdoField::EventTimer,
        6 => PdoField::SyncStart,
        0 | 7.. => return None,
    })
}

const fn mapping(sub: u8) -> PdoField {
    match sub {
        0 => PdoField::Count,
        1.. => PdoField::Mapped(sub - 1),
    }
}

/// The values of all parameters that can be kept over power-off. Those an object dictionary lacks are zero, and off.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Communication {
    pub(super) sync_id: u32,
    pub(super) sync_period: u32,
    pub(super) sync_window: u32,
    pub(super) sync_counter: u8,
    pub(super) guard_time: u16,
    pub(super) life_time_factor: u8,
    pub(super) emcy_id: u32,
    pub(super) emcy_inhibit: u16,
    pub(super) consumers: [u32; MAX_CONSUMERS],
    pub(super) heartbeat: u16,
    pub(super) error_behaviour: u8,
    pub(super) rpdos: PdoTable,
    pub(super) tpdos: PdoTable,
}

/// The PDOs of one direction, by ascending number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PdoTable(PerPdo<PdoParameters>);

/// The values of one PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PdoParameters {
    pub(super) number: PdoNumber,
    pub(super) cob_id: u32,
    pub(super) kind: u8,
    pub(super) inhibit: u16,
    pub(super) reserved: u8,
    pub(super) event_timer: u16,
    pub(super) sync_start: u8,
    pub(super) count: u8,
    pub(super) mapped: [u32; MAX_MAPPED],
}

/// A PDO that the dictionary lacks.
const ABSENT: PdoParameters = PdoParameters {
    number: PdoNumber::P1,
    cob_id: super::cob_id::CobId::INVALID,
    kind: 255,
    inhibit: 0,
    reserved: 0,
    event_timer: 0,
    sync_start: 0,
    count: 0,
    mapped: [0; MAX_MAPPED],
};

impl Communication {
    /// Before anything is known of the dictionary: every service is off.
    pub(super) const OFF: Self = Self {
        sync_id: super::cob_id::SYNC as u32,
        sync_period: 0,
        sync_window: 0,
        sync_counter: 0,
        guard_time: 0,
        life_time_factor: 0,
        emcy_id: super::cob_id::CobId::INVALID,
        emcy_inhibit: 0,
        consumers: [0; MAX_CONSUMERS],
        heartbeat: 0,
        error_behaviour: 0,
        rpdos: PdoTable(PerPdo::new()),
        tpdos: PdoTable(PerPdo::new()),
    };

    /// The defaults of the dictionary at node `node`.
    pub(super) fn defaults(objects: &'static [Object], node: NodeId) -> Self {
        let mut values = Self::OFF;
        for (parameter, value) in defaults(objects, node) {
            values.set(parameter, value);
        }
        values
    }

    /// The value of a parameter; zero for those that are kept elsewhere.
    pub(super) fn value(&self, parameter: Parameter) -> u32 {
        match parameter {
            Parameter::SyncId => self.sync_id,
            Parameter::SyncPeriod => self.sync_period,
            Parameter::SyncWindow => self.sync_window,
            Parameter::SyncCounter => self.sync_counter.into(),
            Parameter::GuardTime => self.guard_time.into(),
            Parameter::LifeTimeFactor => self.life_time_factor.into(),
            Parameter::EmcyId => self.emcy_id,
            Parameter::EmcyInhibit => self.emcy_inhibit.into(),
            Parameter::Consumer(place) => self.consumers.get(usize::from(place)).copied().unwrap_or_default(),
            Parameter::Heartbeat => self.heartbeat.into(),
            Parameter::ErrorBehaviour => self.error_behaviour.into(),
            Parameter::Rpdo(pdo, field) => self.rpdos.of(pdo).value(field),
            Parameter::Tpdo(pdo, field) => self.tpdos.of(pdo).value(field),
            Parameter::ErrorRegister
            | Parameter::HistoryCount
            | Parameter::History(_)
            | Parameter::Store(_)
            | Parameter::LoadDefaults(_) => 0,
        }
    }

    /// Sets a parameter to a value that its type holds.
    #[expect(clippy::cast_possible_truncation, reason = "values were checked against the type of the entry")]
    pub(super) fn set(&mut self, parameter: Parameter, value: u32) {
        match parameter {
            Parameter::SyncId => self.sync_id = value,
            Parameter::SyncPeriod => self.sync_period = value,
            Parameter::SyncWindow => self.sync_window = value,
            Parameter::SyncCounter => self.sync_counter = value as u8,
            Parameter::GuardTime => self.guard_time = value as u16,
            Parameter::LifeTimeFactor => self.life_time_factor = value as u8,
            Parameter::EmcyId => self.emcy_id = value,
            Parameter::EmcyInhibit => self.emcy_inhibit = value as u16,
            Parameter::Consumer(place) => {
                if let Some(consumer) = self.consumers.get_mut(usize::from(place)) {
                    *consumer = value;
                }
            }
            Parameter::Heartbeat => self.heartbeat = value as u16,
            Parameter::ErrorBehaviour => self.error_behaviour = value as u8,
            Parameter::Rpdo(pdo, field) => self.rpdos.set(pdo, field, value),
            Parameter::Tpdo(pdo, field) => self.tpdos.set(pdo, field, value),
            Parameter::ErrorRegister
            | Parameter::HistoryCount
            | Parameter::History(_)
            | Parameter::Store(_)
            | Parameter::LoadDefaults(_) => {}
        }
    }
}

impl PdoTable {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// The place of a PDO.
    pub(super) fn place(&self, pdo: PdoNumber) -> Option<usize> {
        self.search(pdo).ok()
    }

    /// Where a PDO is, or belongs. Most devices have them without gaps.
    fn search(&self, pdo: PdoNumber) -> Result<usize, usize> {
        let likely = usize::from(pdo.number()) - 1;
        match self.0.get(likely) {
            Some(values) if values.number == pdo => Ok(likely),
            Some(_) | None => self.0.binary_search_by_key(&pdo, |values| values.number),
        }
    }

    /// The values at a place.
    pub(super) fn at(&self, place: usize) -> &PdoParameters {
        self.0.get(place).unwrap_or(&ABSENT)
    }

    pub(super) fn of(&self, pdo: PdoNumber) -> &PdoParameters {
        self.place(pdo).map_or(&ABSENT, |place| self.at(place))
    }

    /// What has no room does nothing.
    fn set(&mut self, number: PdoNumber, field: PdoField, value: u32) {
        let place = match self.search(number) {
            Ok(place) => place,
            Err(place) => {
                if !pdo::add(&mut self.0, PdoParameters { number, ..ABSENT }) {
                    return;
                }
                // From the end to its place.
                for behind in (place + 1..self.0.len()).rev() {
                    if let Some([low, high]) = self.0.get_mut(behind - 1..=behind) {
                        core::mem::swap(low, high);
                    }
                }
                place
            }
        };
        if let Some(values) = self.0.get_mut(place) {
            values.set(field, value);
        }
    }
}

impl PdoParameters {
    fn value(&self, field: PdoField) -> u32 {
        match field {
            PdoField::CobId => self.cob_id,
            PdoField::Type => self.kind.into(),
            PdoField::Inhibit => self.inhibit.into(),
            PdoField::Reserved => self.reserved.into(),
            PdoField::EventTimer => self.event_timer.into(),
            PdoField::SyncStart => self.sync_start.into(),
            PdoField::Count => self.count.into(),
            PdoField::Mapped(place) => self.mapped.get(usize::from(place)).copied().unwrap_or_default(),
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "values were checked against the type of the entry")]
    fn set(&mut self, field: PdoField, value: u32) {
        match field {
            PdoField::CobId => self.cob_id = value,
            PdoField::Type => self.kind = value as u8,
            PdoField::Inhibit => self.inhibit = value as u16,
            PdoField::Reserved => self.reserved = value as u8,
            PdoField::EventTimer => self.event_timer = value as u16,
            PdoField::SyncStart => self.sync_start = value as u8,
            PdoField::Count => self.count = value as u8,
            PdoField::Mapped(place) => {
                if let Some(entry) = self.mapped.get_mut(usize::from(place)) {
                    *entry = value;
                }
            }
        }
    }

    /// The mapping that is in force.
    pub(super) fn mapping(&self) -> &[u32] {
        self.mapped.get(..usize::from(self.count)).unwrap_or_default()
    }
}

/// Every parameter that the node keeps for this dictionary, with its default at node `node`.
pub(super) fn defaults(objects: &'static [Object], node: NodeId) -> impl Iterator<Item = (Parameter, u32)> {
    kept(objects).filter_map(move |(parameter, entry)| {
        let number = entry.default_value(node).number()?;
        Some((parameter, u32::try_from(number).ok()?))
    })
}

/// Every parameter that the node keeps for this dictionary, with its entry.
pub(super) fn kept(
    objects: &'static [Object],
) -> impl Iterator<Item = (Parameter, &'static super::dictionary::Entry)> {
    let communication = objects.iter().take_while(|object| object.index.0 < 0x2000);
    communication.flat_map(|object| {
        object.entries.iter().filter_map(move |entry| {
            let parameter = Parameter::of(Address { index: object.index, sub: entry.sub })?;
            (entry.home == Home::Node).then_some((parameter, entry))
        })
    })
}
