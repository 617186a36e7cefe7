//! What the object dictionary of a node tells: words of bits, PDOs, the error history.

use super::objects::whole;
use super::station::{BitState, Entry, Past, Process, WordState};
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::pdo::mapping::MappingWord;
use crate::can_bus::canopen::pdo::{self, MAX_PDOS};
use crate::can_bus::canopen::{Address, dictionary};
use crate::can_bus::cia402::axis;
use crate::devices::{CanopenDevice, Vocabulary};
use crate::face::description::{Amount, ExchangeEntry};
use crate::host::can::number;

/// The control word and the status word.
pub(super) fn words<'a>(
    vocabulary: &'a Vocabulary,
    device: &'a dyn CanopenDevice,
) -> impl Iterator<Item = WordState> + 'a {
    device.description().words().iter().copied().filter_map(move |at| word(vocabulary, device, at))
}

fn word(vocabulary: &Vocabulary, device: &dyn CanopenDevice, at: Address) -> Option<WordState> {
    let value = u16::try_from(whole(device, at)?).ok()?;
    let object = dictionary::object(device.application().objects(), at.index)?;
    let mode = match axis::of_first(at.index.0).0 {
        0 => device.description().mode(),
        further => whole(device, Address::new(axis::index(further, 0x6061), 0)).unwrap_or_default(),
    };
    let names = (vocabulary.bits)(at, mode);
    let bit = |bit: u8| {
        let name = names.and_then(|names| names.get(usize::from(bit)).copied()).unwrap_or_default();
        let set = value >> bit & 1 == 1;
        let bad = ["fault", "error"].iter().any(|word| name.contains(word)) && !name.contains("reset");
        BitState { bit, set, name, used: !name.is_empty(), alarm: set && bad, ..BitState::default() }
    };
    let (key, name) = (format!("{:04X}", at.index.0), format!("{at} {}", object.name));
    Some(WordState { key, name, value, bits: (0..16).map(bit).collect() })
}

/// The PDOs that the device has; RPDOs first.
pub(super) fn pdos(device: &dyn CanopenDevice) -> impl Iterator<Item = Process> {
    let objects = device.application().objects();
    let kinds = [("RPDO", 0x1400), ("TPDO", 0x1800)];
    kinds.into_iter().flat_map(move |(name, first)| {
        let indices = objects.iter().map(|object| object.index.0);
        let of_kind =
            indices.filter(move |index| (first..first + pdo::OBJECTS).contains(index)).take(MAX_PDOS);
        of_kind.filter_map(move |index| pdo(device, (name, index - first), index))
    })
}

fn pdo(device: &dyn CanopenDevice, (name, place): (&str, u16), index: u16) -> Option<Process> {
    let id = u32::try_from(whole(device, Address::new(index, 1))?).ok()?;
    let kind = whole(device, Address::new(index, 2))?;
    let mapping = index + 0x200;
    let count = whole(device, Address::new(mapping, 0)).and_then(|count| u8::try_from(count).ok());
    let entries = (1..=count.unwrap_or(0)).filter_map(|sub| entry(device, Address::new(mapping, sub)));
    let key = format!("{name}{}", place + 1);
    let off = if CobId(id).is_valid() { "" } else { " off" };
    Some(Process {
        name: format!("{key}, COB-ID {:03X}h{off}, type {kind}", id & 0x1FFF_FFFF),
        key,
        from_master: name == "RPDO",
        slot: None,
        octets_hex: String::new(),
        forced_hex: None,
        details: None,
        entries: entries.collect(),
    })
}

fn entry(device: &dyn CanopenDevice, mapped: Address) -> Option<Entry> {
    let word = MappingWord::decode(u32::try_from(whole(device, mapped)?).ok()?);
    let name = dictionary::entry(device.application().objects(), word.at).map_or("dummy", |entry| entry.name);
    let amount = Amount::from(number(device, word.at));
    Some(Entry::of(&ExchangeEntry { name, place: &word.at, amount, unit: "" }))
}

/// 1003h, the newest first.
pub(super) fn history<'a>(
    vocabulary: &'a Vocabulary,
    device: &'a dyn CanopenDevice,
) -> impl Iterator<Item = Past> + 'a {
    let count = whole(device, Address::new(0x1003, 0)).and_then(|count| u8::try_from(count).ok());
    (1..=count.unwrap_or(0)).filter_map(move |sub| {
        let entry = u32::try_from(whole(device, Address::new(0x1003, sub))?).ok()?;
        let [code_low, code_high, low, high] = entry.to_le_bytes();
        let code = u16::from_le_bytes([code_low, code_high]);
        Some(Past {
            code: format!("{code:04X}h"),
            text: (vocabulary.errors.emcy)(code, [low, high, 0, 0, 0]).unwrap_or_default().into(),
            when: Some(format!("{high:02X}{low:02X}h")),
        })
    })
}
