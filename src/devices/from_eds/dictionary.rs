//! The tables of a node from its file.
//!
//! A node reads tables that live as long as the program. Those of a file are made once and held until the program ends; who
//! makes them limits how many.

use super::drive::{self, Axis};
use super::encoder::Part;
use super::io::Point;
use super::names::Names;
use crate::can_bus::canopen::address::Sub;
use crate::can_bus::canopen::dictionary::{
    self, Access, Default, Home, Limits, Mapping, Object, ObjectType, Writable,
};
use crate::can_bus::canopen::parameter::Parameter;
use crate::can_bus::canopen::pdo::{self, MAX_PDOS, PdoNumber};
use crate::can_bus::canopen::policy::{OutOfRange, Policy, SyncProducer};
use crate::can_bus::canopen::value::{DataType, ValueKind};
use crate::can_bus::canopen::{Abort, Address, NodeId, Value};
use crate::can_bus::cia402::axis;
use crate::devices::cia402_drive::{Actual, Setting};
use crate::devices::vocabulary::{self, Vocabulary};
use crate::eds::{self, Content, Eds, Limit, Profile, Rights};
use crate::face::surroundings::{Input, InputKind};

/// The most octets of a string, unless its default has more.
const MOST_TEXT: usize = 1024;
/// The most octets of a domain.
const MOST_DOMAIN: usize = 1 << 20;
/// Objects below are of the communication; the others are the device's own.
pub(super) const FIRST_OWN: u16 = 0x2000;
const STORE: u16 = 0x1010;
/// Values that a list of devices shows.
const HEADLINES: usize = 2;
/// Values with a curve.
const CURVES: usize = 8;

/// The tables of a node, from its file.
#[derive(Debug)]
pub struct Dictionary {
    /// The file.
    pub eds: &'static Eds,
    /// Its objects, for the node.
    pub objects: &'static [Object],
    /// What its frames are called.
    pub vocabulary: Vocabulary,
    /// What the device behind the values is.
    pub(super) profile: Profile,
    /// Whose image it is.
    pub(super) product: String,
    /// All entries in the order of the objects, with what the table of the node cannot say.
    pub(super) rows: Vec<Row>,
    /// The row of the first entry of each object.
    starts: Vec<usize>,
    /// What the axes of a drive call their values and inputs.
    pub(super) axes: Vec<Names>,
    /// Entries that are words of bits.
    pub(super) words: Vec<Address>,
    /// Whether application objects have a group of 1010h that manufacturer objects have no part in.
    pub(super) has_manufacturer_group: bool,
}

/// An entry.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) at: Address,
    pub(super) table: &'static dictionary::Entry,
    pub(super) file: &'static eds::Entry,
    /// The table has no such limits: the device judges.
    pub(super) judged_here: bool,
    /// What it is to the device behind the values.
    pub(super) role: Role,
    /// What can be set from outside.
    pub(super) input: Option<Input>,
    /// Its name for programs, of those that are shown.
    pub(super) key: Option<&'static str>,
    pub(super) headline: bool,
    pub(super) curve: bool,
}

/// What an entry is to the device behind the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Nothing: a value.
    Value,
    /// What the drive of an axis is told.
    Setting(u8, Setting),
    /// What it tells.
    Actual(u8, Actual),
    /// Of inputs and outputs.
    Io(Point),
    /// Of an encoder.
    Encoder(Part),
}

impl Role {
    fn of((profile, axes): (Profile, u8), eds: &Eds, at: Address, table: &dictionary::Entry) -> Self {
        match profile {
            Profile::Drive => drive::role(eds, axes, at, table),
            Profile::InputsOutputs => Point::of(at, table).map_or(Self::Value, Self::Io),
            Profile::Encoder => Part::of(at, table).map_or(Self::Value, Self::Encoder),
            Profile::Other(_) | Profile::None => Self::Value,
        }
    }

    /// Whether the value of an object that a master cannot write comes from outside.
    fn is_outside(self) -> bool {
        match self {
            Self::Value => true,
            Self::Setting(..) | Self::Actual(..) => false,
            Self::Io(point) => point.is_input(),
            Self::Encoder(part) => part.is_input(),
        }
    }
}

impl Dictionary {
    /// The tables of a file, for as long as the program runs.
    pub fn hold(eds: Eds) -> &'static Self {
        let profile = match eds.profile() {
            Profile::Drive if !drive::is_driven(&eds) => Profile::None,
            profile @ (Profile::InputsOutputs
            | Profile::Drive
            | Profile::Encoder
            | Profile::Other(_)
            | Profile::None) => profile,
        };
        Self::with_profile(eds, profile)
    }

    /// The same, of a node that does nothing by itself: its values are a memory.
    pub(crate) fn hold_as_memory(eds: Eds) -> &'static Self {
        Self::with_profile(eds, Profile::None)
    }

    fn with_profile(mut eds: Eds, profile: Profile) -> &'static Self {
        let axes = if profile == Profile::Drive { drive::axes(&eds) } else { 0 };
        drive::fill(&mut eds, axes);
        let eds: &'static Eds = Box::leak(Box::new(eds));
        let served = Served::of(eds);
        let has_store = eds.objects.contains_key(&STORE);
        let (mut objects, mut starts, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        // The drive has its own.
        let (mut headlines, mut curves) =
            if profile == Profile::Drive { (0..0, 0..0) } else { (0..HEADLINES, 0..CURVES) };
        for object in eds.objects.values() {
            let entries: Vec<_> = object
                .entries
                .iter()
                .map(|(sub, entry)| {
                    let (table, judged) = table_entry(object, *sub, entry, (has_store, &served));
                    let at = Address { index: object.index, sub: table.sub };
                    let home = if is_cyclic_timer(profile, eds, at) { CYCLIC_TIMER } else { table.home };
                    (dictionary::Entry { home, ..table }, judged)
                })
                .collect();
            let (entries, judged): (Vec<_>, Vec<_>) = entries.into_iter().unzip();
            let entries: &'static [dictionary::Entry] = entries.leak();
            starts.push(rows.len());
            for ((table, file), judged_here) in entries.iter().zip(object.entries.values()).zip(judged) {
                let at = Address { index: object.index, sub: table.sub };
                let is_number =
                    table.data.kind() != ValueKind::Text && table.data.kind() != ValueKind::Octets;
                let is_own = object.index.0 >= FIRST_OWN && is_number;
                let is_shown = is_own && file.mappable;
                let role = Role::of((profile, axes), eds, at, table);
                let is_measured = is_own
                    && file.rights == Rights::ReadOnly
                    && role.is_outside()
                    && !is_count(object, table.sub);
                let key = (is_shown || is_measured).then(|| key(object, at));
                let input = key.filter(|_| is_measured).map(|key| input(key, name(object, table), table));
                rows.push(Row {
                    at,
                    table,
                    file,
                    judged_here,
                    role,
                    input,
                    key: key.filter(|_| is_shown),
                    headline: is_shown && is_measured && headlines.next().is_some(),
                    curve: is_shown && is_measured && curves.next().is_some(),
                });
            }
            objects.push(Object {
                index: object.index,
                name: &object.name,
                object_type: kind(object),
                entries,
            });
        }
        let objects: &'static [Object] = objects.leak();
        let is_word = |index: &u16| {
            eds.entry(*index, 0).is_some_and(|entry| entry.data == DataType::U16 && entry.mappable)
        };
        let is_drive = eds.profile() == Profile::Drive;
        let words = (0..axes.max(1)).flat_map(|axis| [0x6040, 0x6041].map(|word| axis::index(axis, word)));
        let words = words.filter(|index| is_drive && is_word(index));
        Box::leak(Box::new(Self {
            eds,
            objects,
            vocabulary: vocabulary(eds, objects, is_drive),
            profile,
            product: product(eds),
            rows,
            starts,
            words: words.map(|index| Address::new(index, 0)).collect(),
            axes: (0..axes).map(|number| Names::of(&Axis::of(eds, number))).collect(),
            has_manufacturer_group: eds.entry(STORE, 4).is_some(),
        }))
    }

    /// How the node behaves.
    pub(super) const fn policy(&self) -> Policy {
        Policy {
            block: true,
            out_of_range: OutOfRange::TooHighTooLow,
            sync_producer: SyncProducer::Produced,
            dummies: self.eds.dummies,
            ..Policy::CIA_301
        }
    }

    /// The place of an entry in the rows.
    pub(super) fn place(&self, at: Address) -> Option<usize> {
        let object = self.objects.binary_search_by_key(&at.index, |object| object.index).ok()?;
        Some(self.starts.get(object)? + self.objects.get(object)?.place(at.sub)?)
    }
}

impl Row {
    /// Whether a number is within the limits of the file, where the table of the node does not say them.
    pub(super) fn judge(&self, value: Value<'_>, node: NodeId) -> Result<(), Abort> {
        if !self.judged_here {
            return Ok(());
        }
        let below = |limit: &Limit| match (*limit, value) {
            (Limit::Real(limit), Value::Real32(value)) => f64::from(value) < limit,
            (Limit::Real(limit), Value::Real64(value)) => value < limit,
            (Limit::Whole(limit), value) => whole(value).is_some_and(|value| value < limit.at(node)),
            (Limit::Real(_), _) => false,
        };
        let above = |limit: &Limit| match (*limit, value) {
            (Limit::Real(limit), Value::Real32(value)) => f64::from(value) > limit,
            (Limit::Real(limit), Value::Real64(value)) => value > limit,
            (Limit::Whole(limit), value) => whole(value).is_some_and(|value| value > limit.at(node)),
            (Limit::Real(_), _) => false,
        };
        match (&self.file.low, &self.file.high) {
            (Some(low), _) if below(low) => Err(Abort::TOO_LOW),
            (_, Some(high)) if above(high) => Err(Abort::TOO_HIGH),
            (_, _) => Ok(()),
        }
    }

    /// Whether a client can change it and it is kept once stored.
    pub(super) fn is_stored(&self) -> bool {
        self.table.stored && self.table.home == Home::Application
    }
}

/// 6200h of CiA 406 is the event timer of TPDO 1.
const CYCLIC_TIMER: Home = Home::Alias(Address::new(0x1800, 5));

fn is_cyclic_timer(profile: Profile, eds: &Eds, at: Address) -> bool {
    let is_timer = |index, sub| eds.entry(index, sub).is_some_and(|entry| entry.data == DataType::U16);
    profile == Profile::Encoder && at.pair() == (0x6200, 0) && is_timer(0x6200, 0) && is_timer(0x1800, 5)
}

fn whole(value: Value<'_>) -> Option<i128> {
    if let Value::U64(number) = value { Some(number.into()) } else { value.number().map(i128::from) }
}

/// The PDOs of a file that the node has; the others are values only.
struct Served {
    received: Vec<u16>,
    sent: Vec<u16>,
}

impl Served {
    fn of(eds: &Eds) -> Self {
        let from = |first: u16| {
            let objects = eds.objects.range(first..first + pdo::OBJECTS);
            objects.take(MAX_PDOS).map(|(index, _)| index - first + 1).collect()
        };
        Self { received: from(0x1400), sent: from(0x1800) }
    }

    fn has(&self, parameter: Parameter) -> bool {
        let is_of = |all: &[u16], pdo: PdoNumber| all.binary_search(&pdo.number()).is_ok();
        match parameter {
            Parameter::Rpdo(pdo, _) => is_of(&self.received, pdo),
            Parameter::Tpdo(pdo, _) => is_of(&self.sent, pdo),
            Parameter::ErrorRegister
            | Parameter::HistoryCount
            | Parameter::History(_)
            | Parameter::SyncId
            | Parameter::SyncPeriod
            | Parameter::SyncWindow
            | Parameter::GuardTime
            | Parameter::LifeTimeFactor
            | Parameter::Store(_)
            | Parameter::LoadDefaults(_)
            | Parameter::EmcyId
            | Parameter::EmcyInhibit
            | Parameter::Consumer(_)
            | Parameter::Heartbeat
            | Parameter::SyncCounter
            | Parameter::ErrorBehaviour => true,
        }
    }
}

/// The entry for the node, and whether its limits are left to the device.
fn table_entry(
    object: &'static eds::Object,
    sub: u8,
    entry: &'static eds::Entry,
    (has_store, served): (bool, &Served),
) -> (dictionary::Entry, bool) {
    let at = Address { index: object.index, sub: Sub(sub) };
    let home = match Parameter::of(at).filter(|parameter| served.has(*parameter)) {
        Some(_) if entry.data.kind().is_whole() && entry.data.octets().is_some_and(|len| len <= 4) => {
            Home::Node
        }
        Some(_) | None => Home::Application,
    };
    let (limits, judged_here) = limits(entry);
    let is_service = matches!(object.index.0, 0x1000..=0x1003 | 0x1010 | 0x1011);
    let table = dictionary::Entry {
        sub: at.sub,
        name: if entry.name.is_empty() { &object.name } else { &entry.name },
        data: entry.data,
        access: match entry.rights {
            Rights::ReadOnly => Access::Ro,
            Rights::WriteOnly => Access::Wo,
            Rights::ReadWrite | Rights::ReadWriteSent | Rights::ReadWriteReceived => Access::Rw,
            Rights::Const => Access::Const,
        },
        writable: Writable::Always,
        default: default(entry),
        limits,
        mapping: match entry.rights {
            _ if !entry.mappable => Mapping::No,
            Rights::ReadOnly | Rights::ReadWriteSent | Rights::Const => Mapping::Tpdo,
            Rights::WriteOnly | Rights::ReadWriteReceived => Mapping::Rpdo,
            Rights::ReadWrite => Mapping::Both,
        },
        stored: has_store && entry.rights.is_writable() && !is_service,
        home,
    };
    (table, judged_here)
}

/// The default where the table of a node can say it; the others are in the memory only.
fn default(entry: &'static eds::Entry) -> Default {
    match &entry.content {
        Content::Whole(number) if number.node_id => {
            u32::try_from(number.offset).map_or(Default::None, Default::NodeId)
        }
        Content::Whole(number) => i64::try_from(number.offset).map_or(Default::None, Default::Number),
        Content::Octets(octets) if entry.data.kind() == ValueKind::Text => {
            core::str::from_utf8(octets).map_or(Default::None, Default::Text)
        }
        #[expect(clippy::cast_possible_truncation, reason = "to the precision that the type has")]
        Content::Real(number) if entry.data == DataType::Real32 => Default::Real(*number as f32),
        Content::None | Content::Real(_) | Content::Octets(_) => Default::None,
    }
}

fn limits(entry: &eds::Entry) -> (Limits, bool) {
    if entry.data.octets().is_none() {
        let len = match &entry.content {
            Content::Octets(octets) => octets.len(),
            Content::None | Content::Whole(_) | Content::Real(_) => 0,
        };
        let most = if entry.data == DataType::Domain { MOST_DOMAIN } else { MOST_TEXT };
        return (Limits::MaxLen(len.max(most)), false);
    }
    if entry.low.is_none() && entry.high.is_none() {
        return (Limits::Type, false);
    }
    let plain = |limit: &Option<Limit>, none: i64| match limit {
        None => Some(none),
        Some(Limit::Whole(number)) if !number.node_id => i64::try_from(number.offset).ok(),
        Some(Limit::Whole(_) | Limit::Real(_)) => None,
    };
    let range = entry.data.range().and_then(|(low, high)| {
        let (low, high) = (plain(&entry.low, low)?, plain(&entry.high, high)?);
        Some(Limits::Range(low, high))
    });
    range.map_or((Limits::Type, true), |range| (range, false))
}

/// A VAR has one entry with sub-index 0; what has others is a RECORD whatever its file calls it.
fn kind(object: &eds::Object) -> ObjectType {
    match object.kind {
        ObjectType::Var if object.entries.len() > 1 => ObjectType::Record,
        kind @ (ObjectType::Var | ObjectType::Array | ObjectType::Record) => kind,
    }
}

/// Sub-index 0 of an ARRAY or a RECORD.
fn is_count(object: &eds::Object, sub: Sub) -> bool {
    sub.0 == 0 && kind(object) != ObjectType::Var
}

/// `6064h`, `6401h:01`
fn key(object: &eds::Object, at: Address) -> &'static str {
    let key = match kind(object) {
        ObjectType::Var => at.index.to_string(),
        ObjectType::Array | ObjectType::Record => at.to_string(),
    };
    key.leak()
}

/// The name of the object with that of its entry.
fn name(object: &'static eds::Object, entry: &dictionary::Entry) -> &'static str {
    match kind(object) {
        ObjectType::Var => entry.name,
        ObjectType::Array | ObjectType::Record => format!("{}, {}", object.name, entry.name).leak(),
    }
}

#[expect(clippy::cast_precision_loss, reason = "limits of a control, not values")]
fn input(name: &'static str, about: &'static str, entry: &dictionary::Entry) -> Input {
    let range = match entry.limits {
        Limits::Range(low, high) => Some((low as f64, high as f64)),
        Limits::Type | Limits::Ranges(_) | Limits::MaxLen(_) => match entry.data.kind() {
            ValueKind::Real => Some((f64::from(f32::MIN), f64::from(f32::MAX))),
            ValueKind::Boolean
            | ValueKind::Signed
            | ValueKind::Unsigned
            | ValueKind::Text
            | ValueKind::Octets => entry.data.range().map(|(low, high)| (low as f64, high as f64)),
        },
    };
    let (low, high) = range.unwrap_or((0.0, u64::MAX as f64));
    let kind = if entry.data == DataType::Boolean {
        InputKind::Switch
    } else {
        InputKind::Number { low, high, own: false }
    };
    Input { name, about, kind }
}

fn vocabulary(eds: &'static Eds, objects: &'static [Object], is_drive: bool) -> Vocabulary {
    let plain = Vocabulary { name: &eds.device.product, objects, complete: true, ..vocabulary::CIA_402 };
    if is_drive { plain } else { Vocabulary { choice: |_, _| None, bits: |_, _| None, ..plain } }
}

/// `eds-` and what tells it from other devices: the identity, and the names for those that have none.
fn product(eds: &Eds) -> String {
    let number = |sub| eds.number(0x1018, sub).unwrap_or_default();
    let names = format!("{}\n{}", eds.device.vendor, eds.device.product);
    format!("eds-{:x}-{:x}-{:08x}", number(1), number(2), crate::image::crc32(names.as_bytes()))
}
