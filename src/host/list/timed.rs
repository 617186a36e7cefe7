//! The diagnosis of a station on the time line.

use core::time::Duration;
use std::collections::BTreeMap;

use super::signals::whole;
use super::{Given, Wrong};
use crate::gsd::{ChannelFault, ModuleState, Raised, Station};
use crate::host::fault::{duration, no_time};
use crate::host::reported::{InSlot, Timed};
use crate::profibus::dp::Application as _;
use crate::profibus::dp::ext_diag::{ChannelError, Direction, Width};

/// The keys of a row.
pub(crate) const KEYS: &[&str] = &[
    "from",
    "until",
    "bits",
    "areas",
    "identifiers",
    "invalid",
    "wrong",
    "missing",
    "channels",
    "octets",
    "not-valid",
];

/// So many of them say when.
#[cfg(all(test, feature = "emulator"))]
pub(crate) const TIMES: usize = 2;

/// The keys of a fault of a channel, and of a value of an area.
pub(crate) const CHANNEL: &[&str] = &["slot", "channel", "direction", "width", "error"];
pub(crate) const AREA: &[&str] = &["first-bit", "value"];

/// The words of a direction and of a width.
pub(crate) const DIRECTIONS: [(&str, Direction); 3] =
    [("input", Direction::Input), ("output", Direction::Output), ("both", Direction::Both)];
pub(crate) const WIDTHS: [(&str, Width); 6] = [
    ("bit", Width::Bit),
    ("two-bits", Width::TwoBits),
    ("four-bits", Width::FourBits),
    ("octet", Width::Octet),
    ("word", Width::Word),
    ("two-words", Width::TwoWords),
];

/// The rows of a station.
///
/// # Errors
/// [`Wrong`] says which row and which key.
pub(super) fn rows(key: &str, given: &[Given], station: &Station) -> Result<Vec<Timed>, Wrong> {
    let row = |(number, given): (usize, &Given)| {
        row(given, station).map_err(|wrong| wrong.under(&[key, &number.to_string()]))
    };
    given.iter().enumerate().map(row).collect()
}

pub(super) type Table = [(String, Given)];

fn row(given: &Given, station: &Station) -> Result<Timed, Wrong> {
    let table = table(given, KEYS)?;
    let from = time(table, "from")?.unwrap_or_default();
    let until = time(table, "until")?;
    if until.is_some_and(|until| until <= from) {
        return Err(Wrong::at("until", "until must be later than from"));
    }
    let mut raised = Raised {
        bits: numbers(table, "bits")?.into_iter().collect(),
        areas: list(table, "areas", area)?.into_iter().collect(),
        identifiers: numbers(table, "identifiers")?.into_iter().collect(),
        channels: list(table, "channels", channel)?,
        octets: numbers(table, "octets")?,
        not_valid: flag(table, "not-valid"),
        ..Raised::default()
    };
    raised.modules =
        numbers(table, "invalid")?.into_iter().map(|slot| (slot, ModuleState::Invalid)).collect();
    let mut in_slots = BTreeMap::new();
    for (key, what) in [("wrong", InSlot::Other), ("missing", InSlot::Empty)] {
        in_slots.extend(numbers(table, key)?.into_iter().map(|slot| (slot, what)));
    }
    if raised.is_empty() && in_slots.is_empty() {
        return Err(Wrong::whole("the diagnosis reports nothing; add bits, missing or octets, for example"));
    }
    // Where the master chooses the modules, the slots may be there.
    let layout = station.layout(station.configuration(None), None);
    let checked = if station.is_fixed() { raised.clone() } else { raised.clone().within(&layout) };
    checked.blocks(station.gsd(), &layout).map_err(Wrong::whole)?;
    Ok(Timed { from, until, raised, slots: in_slots })
}

pub(super) fn table<'a>(given: &'a Given, known: &[&str]) -> Result<&'a Table, Wrong> {
    let Given::Table(table) = given else {
        return Err(Wrong::whole(format!("{given} is no table; expected {}", known.join(", "))));
    };
    match table.iter().find(|(key, _)| !known.contains(&&**key)) {
        Some((key, _)) => Err(Wrong::key(key, format!("'{key}' is unknown; expected {}", known.join(", ")))),
        None => Ok(table),
    }
}

pub(super) fn find<'a>(table: &'a Table, key: &str) -> Option<&'a Given> {
    table.iter().find(|(known, _)| known == key).map(|(_, given)| given)
}

/// Whether a flag is set.
pub(super) fn flag(table: &Table, key: &str) -> bool {
    find(table, key).is_some_and(|on| *on == Given::Flag(true))
}

pub(super) fn time(table: &Table, key: &str) -> Result<Option<Duration>, Wrong> {
    let Some(given) = find(table, key) else { return Ok(None) };
    let text = given.to_string();
    duration(&text).map(Some).ok_or_else(|| Wrong::at(key, no_time(&text)))
}

fn list<T>(table: &Table, key: &str, one: impl Fn(&Given) -> Result<T, Wrong>) -> Result<Vec<T>, Wrong> {
    match find(table, key) {
        None => Ok(Vec::new()),
        Some(Given::List(all)) => {
            let one = |(place, given): (usize, &Given)| {
                one(given).map_err(|wrong| wrong.under(&[key, &place.to_string()]))
            };
            all.iter().enumerate().map(one).collect()
        }
        Some(other) => Err(Wrong::at(key, format!("{key}: expected a list, not {other}"))),
    }
}

fn numbers<N: TryFrom<u32>>(table: &Table, key: &str) -> Result<Vec<N>, Wrong> {
    list(table, key, |given| whole(key, given).map_err(|wrong| Wrong { path: Vec::new(), ..wrong }))
}

pub(super) fn needed<'a>(table: &'a Table, key: &str) -> Result<&'a Given, Wrong> {
    find(table, key).ok_or_else(|| Wrong::whole(format!("'{key}' is missing")))
}

fn area(given: &Given) -> Result<(u16, u32), Wrong> {
    let table = table(given, AREA)?;
    Ok((whole("first-bit", needed(table, "first-bit")?)?, whole("value", needed(table, "value")?)?))
}

fn channel(given: &Given) -> Result<ChannelFault, Wrong> {
    let table = table(given, CHANNEL)?;
    let error: u8 = whole("error", needed(table, "error")?)?;
    Ok(ChannelFault {
        slot: whole("slot", needed(table, "slot")?)?,
        channel: whole("channel", needed(table, "channel")?)?,
        direction: word(table, "direction", &DIRECTIONS)?,
        width: word(table, "width", &WIDTHS)?,
        error: ChannelError::numbered(error).ok_or_else(|| {
            let words = "expected 1 to 9 of the standard or 16 to 31 of the GSD";
            Wrong::at("error", format!("{error} is no error of a channel; {words}"))
        })?,
    })
}

/// One of the words of a key; the first unless given.
pub(super) fn word<T: Copy>(table: &Table, key: &str, known: &[(&str, T)]) -> Result<T, Wrong> {
    let first = known.first().map(|(_, value)| *value);
    let value = match find(table, key) {
        None => first,
        Some(given) => {
            let text = given.to_string();
            known.iter().find(|(word, _)| *word == text).map(|(_, value)| *value)
        }
    };
    value.ok_or_else(|| {
        let words: Vec<_> = known.iter().map(|(word, _)| *word).collect();
        Wrong::at(key, format!("{key}: expected {}", super::choice::one_of(&words)))
    })
}
