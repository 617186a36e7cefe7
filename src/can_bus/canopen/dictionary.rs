//! The object dictionary as data: `const` tables of a device, sorted, that everything else reads.
//!
//! ```
//! use profidrive::can_bus::canopen::dictionary::{Entry, Home, Object};
//! use profidrive::can_bus::canopen::value::DataType::{U8, U16, U32};
//!
//! const OBJECTS: &[Object] = &[
//!     Object::var(0x1000, &[Entry::ro(0, "Device type", U32).number(0x0000_0192)]),
//!     Object::var(0x1001, &[Entry::ro(0, "Error register", U8).home(Home::Node)]),
//!     Object::var(0x1017, &[Entry::rw(0, "Producer heartbeat time", U16).number(0).home(Home::Node)]),
//!     Object::record(0x1018, "Identity", &[
//!         Entry::ro(0, "Highest sub-index", U8).number(1),
//!         Entry::ro(1, "Vendor", U32).number(0x195),
//!     ]),
//!     Object::var(0x6041, &[Entry::ro(0, "Statusword", U16).home(Home::Application).to_tpdo()]),
//! ];
//! ```

use super::abort::Abort;
use super::address::{Address, Index, NodeId, Sub};
use super::value::{DataType, Value};

/// An object: an index with its entries.
#[derive(Debug)]
pub struct Object {
    /// Its index.
    pub index: Index,
    /// Its name; of a VAR that of its entry.
    pub name: &'static str,
    /// What it is built of.
    pub object_type: ObjectType,
    /// Its entries by ascending sub-index.
    pub entries: &'static [Entry],
}

/// How an object is built (object codes of CiA 301).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ObjectType {
    /// One value, sub-index 0.
    Var,
    /// Values of one type; sub-index 0 is the highest sub-index.
    Array,
    /// Values of different types; sub-index 0 is the highest sub-index.
    Record,
}

impl ObjectType {
    /// The object code in EDS files.
    pub(crate) const fn code(self) -> u8 {
        match self {
            Self::Var => 7,
            Self::Array => 8,
            Self::Record => 9,
        }
    }
}

impl Object {
    /// A single value: one entry with sub-index 0.
    pub const fn var(index: u16, entries: &'static [Entry; 1]) -> Self {
        let [entry] = entries;
        Self { index: Index(index), name: entry.name, object_type: ObjectType::Var, entries }
    }

    /// Values of one type.
    pub const fn array(index: u16, name: &'static str, entries: &'static [Entry]) -> Self {
        Self { index: Index(index), name, object_type: ObjectType::Array, entries }
    }

    /// Values of different types.
    pub const fn record(index: u16, name: &'static str, entries: &'static [Entry]) -> Self {
        Self { index: Index(index), name, object_type: ObjectType::Record, entries }
    }

    /// The entry with that sub-index.
    pub fn entry(&self, sub: Sub) -> Option<&'static Entry> {
        self.entries.get(self.place(sub)?)
    }

    /// The place of the entry with that sub-index.
    pub(crate) fn place(&self, sub: Sub) -> Option<usize> {
        // Most objects have their entries without gaps.
        let likely = usize::from(sub.0);
        match self.entries.get(likely) {
            Some(entry) if entry.sub == sub => Some(likely),
            Some(_) | None => self.entries.binary_search_by_key(&sub, |entry| entry.sub).ok(),
        }
    }
}

/// A sorted table of objects, and of objects of one entry by their index in any order, as one sorted table. For tables that
/// the compiler makes.
#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
pub(crate) const fn with_singles<const N: usize>(
    objects: &[Object],
    singles: &'static [(u16, [Entry; 1])],
) -> [Object; N] {
    assert!(objects.len() + singles.len() == N, "another number of objects");
    let mut table = [const { Object::array(0, "", &[]) }; N];
    let (mut object, mut before, mut count) = (0, 0, 0);
    while count < N {
        let (mut next, mut place) = (u16::MAX, 0);
        let mut single = 0;
        while single < singles.len() {
            if singles[single].0 > before && singles[single].0 < next {
                (next, place) = (singles[single].0, single);
            }
            single += 1;
        }
        if object < objects.len() && objects[object].index.0 < next {
            table[count] = Object { ..objects[object] };
            object += 1;
        } else {
            table[count] = Object::var(next, &singles[place].1);
            before = next;
        }
        count += 1;
    }
    table
}

/// The object with that index in a sorted table.
pub(crate) fn object(objects: &'static [Object], index: Index) -> Option<&'static Object> {
    let place = objects.binary_search_by_key(&index, |object| object.index).ok()?;
    objects.get(place)
}

/// The entry at an address.
///
/// # Errors
/// [`Abort::NO_OBJECT`] or [`Abort::NO_SUB`].
pub fn entry(objects: &'static [Object], at: Address) -> Result<&'static Entry, Abort> {
    object(objects, at.index).ok_or(Abort::NO_OBJECT)?.entry(at.sub).ok_or(Abort::NO_SUB)
}

/// One value of an object and all that is said about it.
#[derive(Debug)]
pub struct Entry {
    /// Its sub-index.
    pub sub: Sub,
    /// Its name, at most 241 characters.
    pub name: &'static str,
    /// Its type.
    pub data: DataType,
    /// What a client may do with it.
    pub access: Access,
    /// In which states it may be written.
    pub writable: Writable,
    /// Its value before anything is written or stored.
    pub default: Default,
    /// What may be written.
    pub limits: Limits,
    /// Whether it may be mapped into PDOs.
    pub mapping: Mapping,
    /// Whether it survives power-off once stored.
    pub stored: bool,
    /// Who holds the value.
    pub home: Home,
}

/// What a client may do with an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum Access {
    /// Read; never changes.
    Const,
    /// Read.
    Ro,
    /// Write.
    Wo,
    /// Both.
    Rw,
}

/// In which NMT states an entry may be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Writable {
    /// Wherever SDOs are served.
    Always,
    /// Only in PRE-OPERATIONAL.
    PreOperational,
}

/// The value of an entry before anything is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    /// Nothing said: 0, or no octets.
    None,
    /// A whole number.
    Number(i64),
    /// `$NODEID` plus this.
    NodeId(u32),
    /// A real number.
    Real(f32),
    /// A string.
    Text(&'static str),
}

/// What may be written to an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limits {
    /// What the type holds; of a string or a domain as many octets as its default has.
    Type,
    /// From the lowest to the highest value.
    Range(i64, i64),
    /// Several such ranges, ascending.
    Ranges(&'static [(i64, i64)]),
    /// A string or a domain of at most so many octets.
    MaxLen(usize),
}

/// Whether an entry may be mapped into PDOs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mapping {
    /// Never.
    No,
    /// The node may send it.
    Tpdo,
    /// The node may receive it.
    Rpdo,
    /// Both.
    Both,
}

/// Who holds the value of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// Nobody: it is its default for ever.
    Default,
    /// The node: communication objects of CiA 301 that [`super::parameter::Parameter`] lists.
    Node,
    /// The [`Application`](super::Application).
    Application,
    /// It is another name of the entry there; the access and the limits of both hold.
    Alias(Address),
}

impl Entry {
    const fn new(sub: u8, name: &'static str, data: DataType, access: Access) -> Self {
        Self {
            sub: Sub(sub),
            name,
            data,
            access,
            writable: Writable::Always,
            default: Default::None,
            limits: Limits::Type,
            mapping: Mapping::No,
            stored: false,
            home: Home::Default,
        }
    }

    /// An entry to be read that never changes.
    pub const fn constant(sub: u8, name: &'static str, data: DataType) -> Self {
        Self::new(sub, name, data, Access::Const)
    }

    /// An entry to be read.
    pub const fn ro(sub: u8, name: &'static str, data: DataType) -> Self {
        Self::new(sub, name, data, Access::Ro)
    }

    /// An entry to be written.
    pub const fn wo(sub: u8, name: &'static str, data: DataType) -> Self {
        Self { home: Home::Application, ..Self::new(sub, name, data, Access::Wo) }
    }

    /// An entry to be read and written, held by the application.
    pub const fn rw(sub: u8, name: &'static str, data: DataType) -> Self {
        Self { home: Home::Application, ..Self::new(sub, name, data, Access::Rw) }
    }

    /// With a whole number as default.
    #[must_use]
    pub const fn number(self, number: i64) -> Self {
        Self { default: Default::Number(number), ..self }
    }

    /// With `$NODEID` plus `base` as default.
    #[must_use]
    pub const fn node_id(self, base: u32) -> Self {
        Self { default: Default::NodeId(base), ..self }
    }

    /// With a string as default.
    #[must_use]
    pub const fn text(self, text: &'static str) -> Self {
        Self { default: Default::Text(text), ..self }
    }

    /// With the lowest and the highest value.
    #[must_use]
    pub const fn range(self, low: i64, high: i64) -> Self {
        Self { limits: Limits::Range(low, high), ..self }
    }

    /// With several ranges.
    #[must_use]
    pub const fn ranges(self, ranges: &'static [(i64, i64)]) -> Self {
        Self { limits: Limits::Ranges(ranges), ..self }
    }

    /// With a greatest length in octets.
    #[must_use]
    pub const fn max_len(self, octets: usize) -> Self {
        Self { limits: Limits::MaxLen(octets), ..self }
    }

    /// Can be sent in a PDO.
    #[must_use]
    pub const fn to_tpdo(self) -> Self {
        Self { mapping: Mapping::Tpdo, ..self }
    }

    /// Can be received in a PDO.
    #[must_use]
    pub const fn to_rpdo(self) -> Self {
        Self { mapping: Mapping::Rpdo, ..self }
    }

    /// Can be sent and received in PDOs.
    #[must_use]
    pub const fn to_pdo(self) -> Self {
        Self { mapping: Mapping::Both, ..self }
    }

    /// Survives power-off once stored.
    #[must_use]
    pub const fn stored(self) -> Self {
        Self { stored: true, ..self }
    }

    /// To be written in PRE-OPERATIONAL only.
    #[must_use]
    pub const fn pre_operational(self) -> Self {
        Self { writable: Writable::PreOperational, ..self }
    }

    /// Held there.
    #[must_use]
    pub const fn home(self, home: Home) -> Self {
        Self { home, ..self }
    }

    /// Held by the node.
    #[must_use]
    pub const fn node(self) -> Self {
        self.home(Home::Node)
    }

    /// Held by the application.
    #[must_use]
    pub const fn live(self) -> Self {
        self.home(Home::Application)
    }

    /// Whether a client may read it.
    pub(crate) const fn readable(&self) -> bool {
        match self.access {
            Access::Const | Access::Ro | Access::Rw => true,
            Access::Wo => false,
        }
    }

    /// Whether a client may write it.
    pub const fn is_writable(&self) -> bool {
        match self.access {
            Access::Wo | Access::Rw => true,
            Access::Const | Access::Ro => false,
        }
    }

    /// Whether the node may send it in a PDO.
    pub const fn sendable(&self) -> bool {
        matches!(self.mapping, Mapping::Tpdo | Mapping::Both)
    }

    /// Whether the node may receive it in a PDO.
    pub const fn receivable(&self) -> bool {
        matches!(self.mapping, Mapping::Rpdo | Mapping::Both)
    }

    /// The default as a value at node `node`.
    pub fn default_value(&self, node: NodeId) -> Value<'static> {
        let number = match self.default {
            Default::None => 0,
            Default::Number(number) => number,
            Default::NodeId(base) => i64::from(base) + i64::from(node.number()),
            Default::Real(number) => return Value::Real32(number),
            Default::Text(text) => return Value::text(text),
        };
        Value::whole(self.data, number).unwrap_or_else(|| self.data.zero())
    }

    /// The fewest and the most octets a value written may have.
    pub(crate) const fn lengths(&self) -> (usize, usize) {
        match (self.data.octets(), self.limits) {
            (Some(len), _) => (len, len),
            (None, Limits::MaxLen(most)) => (0, most),
            (None, Limits::Type | Limits::Range(..) | Limits::Ranges(_)) => match self.default {
                Default::Text(text) => (text.len(), text.len()),
                Default::None | Default::Number(_) | Default::NodeId(_) | Default::Real(_) => (0, 0),
            },
        }
    }

    /// Where a value lies in the range.
    pub(crate) fn place(&self, value: Value<'_>) -> Place {
        let Some(number) = value.number() else { return Place::Inside };
        match self.limits {
            Limits::Type | Limits::MaxLen(_) => Place::Inside,
            Limits::Range(low, high) => Place::of(number, low, high),
            Limits::Ranges(ranges) => match (ranges.first(), ranges.last()) {
                (Some(&(low, _)), Some(&(_, high))) => match Place::of(number, low, high) {
                    Place::Inside if !ranges.iter().any(|&(low, high)| (low..=high).contains(&number)) => {
                        Place::Gap
                    }
                    place @ (Place::Inside | Place::Below | Place::Above | Place::Gap) => place,
                },
                (None, _) | (_, None) => Place::Gap,
            },
        }
    }
}

/// Where a value lies in the range of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// In it.
    Inside,
    /// Below the lowest value.
    Below,
    /// Above the highest value.
    Above,
    /// Between two ranges.
    Gap,
}

impl Place {
    const fn of(number: i64, low: i64, high: i64) -> Self {
        if number < low {
            Self::Below
        } else if number > high {
            Self::Above
        } else {
            Self::Inside
        }
    }
}
