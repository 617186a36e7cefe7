//! Whether the tables of a device agree with themselves: for its tests, before a tool finds out.

use thiserror::Error;

use super::address::{Address, Index, NodeId};
use super::dictionary::{self, Default, Entry, Home, Limits, Object, ObjectType, Place};
use super::parameter::Parameter;
use super::pdo::MappingWord;
use super::sdo::MAX_VALUE_LEN;
use super::value::DataType;

/// The longest name of an entry.
const MAX_NAME_LEN: usize = 241;

/// What is wrong with a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Problem {
    /// Objects are not sorted by index.
    #[error("object {0} does not stand behind a lower index")]
    ObjectOrder(Index),
    /// Entries are not sorted by sub-index.
    #[error("entry {0} does not stand behind a lower sub-index")]
    EntryOrder(Address),
    /// An object without which there is no CANopen device.
    #[error("mandatory object {0} is missing")]
    Missing(Index),
    /// Sub-index 0 does not say the highest sub-index.
    #[error("sub-index 0 of {index} says {says}, the highest one is {highest}")]
    Highest {
        /// The object.
        index: Index,
        /// The default of sub-index 0.
        says: i64,
        /// The last entry.
        highest: u8,
    },
    /// A VAR with more than sub-index 0.
    #[error("VAR {0} has other entries than sub-index 0")]
    Var(Index),
    /// The default does not fit the type or the limits.
    #[error("default of {0} does not fit its type or its limits")]
    Default(Address),
    /// The limits do not fit the type.
    #[error("limits of {0} do not fit its type")]
    Limits(Address),
    /// Marked as kept by the node, which knows no such object.
    #[error("the node keeps no object {0}")]
    NotOfNode(Address),
    /// Can be written, but nobody takes the value.
    #[error("nobody takes what is written to {0}")]
    Homeless(Address),
    /// The other name leads nowhere, to another name or to another type.
    #[error("{0} is another name of nothing")]
    Alias(Address),
    /// A default mapping names what cannot be mapped there.
    #[error("default mapping {0} names what cannot be mapped there")]
    Mapping(Address),
    /// The name is empty or too long.
    #[error("name of {0} is empty or longer than 241 characters")]
    Name(Address),
    /// Values can be longer than a transfer.
    #[error("values of {0} are longer than a transfer takes")]
    TooLong(Address),
}

/// Calls `report` with every problem of a table.
pub fn each_problem(objects: &'static [Object], report: &mut dyn FnMut(Problem)) {
    for index in [0x1000, 0x1001, 0x1018].map(Index) {
        if dictionary::object(objects, index).is_none() {
            report(Problem::Missing(index));
        }
    }
    let mut before = None;
    for object in objects {
        if before.is_some_and(|before| before >= object.index) {
            report(Problem::ObjectOrder(object.index));
        }
        before = Some(object.index);
        check_object(object, report);
        for entry in object.entries {
            check_entry(objects, Address { index: object.index, sub: entry.sub }, entry, report);
        }
    }
}

fn check_object(object: &Object, report: &mut dyn FnMut(Problem)) {
    let mut before = None;
    for entry in object.entries {
        if before.is_some_and(|before| before >= entry.sub) {
            report(Problem::EntryOrder(Address { index: object.index, sub: entry.sub }));
        }
        before = Some(entry.sub);
    }
    let (first, last) = (object.entries.first(), object.entries.last());
    match (object.object_type, first, last) {
        (ObjectType::Var, Some(first), _) if first.sub.0 == 0 && object.entries.len() == 1 => {}
        (ObjectType::Var, _, _) => report(Problem::Var(object.index)),
        // Sub-index 0 that can be written is a count of its own: mappings, histories.
        (ObjectType::Array | ObjectType::Record, Some(first), Some(last))
            if first.sub.0 == 0 && !first.is_writable() =>
        {
            let says = first.default_value(NodeId::MIN).number().unwrap_or(-1);
            if says != i64::from(last.sub.0) && !is_mapping(object.index.0) {
                report(Problem::Highest { index: object.index, says, highest: last.sub.0 });
            }
        }
        (ObjectType::Array | ObjectType::Record, Some(_), Some(_)) => {}
        (ObjectType::Array | ObjectType::Record, None, _) | (_, _, None) => {
            report(Problem::Highest { index: object.index, says: -1, highest: 0 });
        }
    }
}

const fn is_mapping(index: u16) -> bool {
    matches!(index, 0x1600..=0x17FF | 0x1A00..=0x1BFF)
}

fn check_entry(
    objects: &'static [Object],
    at: Address,
    entry: &'static Entry,
    report: &mut dyn FnMut(Problem),
) {
    if entry.name.is_empty() || entry.name.len() > MAX_NAME_LEN {
        report(Problem::Name(at));
    }
    if entry.lengths().1 > MAX_VALUE_LEN {
        report(Problem::TooLong(at));
    }
    if !limits_fit(entry) {
        report(Problem::Limits(at));
    }
    if !default_fits(entry) {
        report(Problem::Default(at));
    }
    match entry.home {
        Home::Default if entry.is_writable() => report(Problem::Homeless(at)),
        Home::Node if Parameter::of(at).is_none() => report(Problem::NotOfNode(at)),
        Home::Alias(to) => match dictionary::entry(objects, to) {
            Ok(target) if target.data == entry.data && !matches!(target.home, Home::Alias(_)) => {}
            Ok(_) | Err(_) => report(Problem::Alias(at)),
        },
        Home::Default | Home::Node | Home::Application => {}
    }
    if is_mapping(at.index.0) && at.sub.0 != 0 && !mapping_fits(objects, at, entry) {
        report(Problem::Mapping(at));
    }
}

fn limits_fit(entry: &Entry) -> bool {
    let inside = |number: i64| entry.data.range().is_none_or(|(low, high)| (low..=high).contains(&number));
    match entry.limits {
        Limits::Type => true,
        Limits::MaxLen(_) => entry.data.octets().is_none(),
        Limits::Range(low, high) => low <= high && inside(low) && inside(high),
        Limits::Ranges(ranges) => {
            !ranges.is_empty()
                && ranges.iter().all(|&(low, high)| low <= high && inside(low) && inside(high))
                && ranges.is_sorted_by(|one, next| one.1 < next.0)
        }
    }
}

fn default_fits(entry: &'static Entry) -> bool {
    let is_text = entry.data.octets().is_none();
    match entry.default {
        Default::None => true,
        Default::Text(text) => is_text && (entry.lengths().0..=entry.lengths().1).contains(&text.len()),
        Default::Real(_) => entry.data == DataType::Real32,
        Default::NodeId(_) => entry.data == DataType::U32 || entry.data == DataType::U16,
        Default::Number(number) => {
            !is_text
                && entry.data.range().is_none_or(|(low, high)| (low..=high).contains(&number))
                && entry.place(entry.default_value(NodeId::MIN)) == Place::Inside
        }
    }
}

/// Static mappings may take less than the whole entry.
fn mapping_fits(objects: &'static [Object], at: Address, entry: &Entry) -> bool {
    let Default::Number(word @ 1..) = entry.default else { return true };
    let Ok(word) = u32::try_from(word) else { return false };
    let word = MappingWord::decode(word);
    if word.is_dummy() {
        return at.index.0 < 0x1800;
    }
    let Ok(mapped) = dictionary::entry(objects, word.at) else { return false };
    let fits = mapped.data.octets().is_some_and(|octets| usize::from(word.bits) <= octets * 8);
    let direction = if at.index.0 < 0x1800 { mapped.receivable() } else { mapped.sendable() };
    fits && direction && word.bits.is_multiple_of(8)
}
