//! What contradicts something else in the file (`eds.md` 2).

use super::lines::{Key, Section};
use super::object::{Entry, Object};
use super::{Content, Eds, number};
use crate::can_bus::canopen::value::DataType;
use crate::device_file::{Hint, Level, Place};

/// Objects that every node has.
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];

/// Receive and transmit PDOs: the key of DeviceInfo, and the first communication parameter.
const PDOS: [(&str, u16); 2] = [("NrOfRXPDO", 0x1400), ("NrOfTXPDO", 0x1800)];

/// From a communication parameter to its mapping.
const TO_MAPPING: u16 = 0x200;

/// The most PDOs of one direction.
const MOST_PDOS: u16 = 0x200;

/// Bit 31 of a COB-ID: the PDO is off.
const OFF: i128 = 1 << 31;

/// What contradicts something else.
pub(super) fn contradictions(eds: &Eds, device: Option<&Section<'_>>) -> Vec<Hint> {
    let mut hints = Vec::new();
    let first_line = Place { line: 1, column: 1 };
    for index in MANDATORY.iter().filter(|index| !eds.objects.contains_key(index)) {
        hints.push(warning(
            first_line,
            format!("{index:04X}h is missing: every node has it, so it is served"),
        ));
    }
    if let Some(device) = device {
        identity(eds, device, &mut hints);
        counts(eds, device, &mut hints);
    }
    for (_, first) in PDOS {
        for (index, object) in eds.objects.range(first..first + MOST_PDOS) {
            identifier(*index, object, &mut hints);
        }
        let mappings = first + TO_MAPPING..first + TO_MAPPING + MOST_PDOS;
        for (index, object) in eds.objects.range(mappings) {
            mapping(eds, *index, object, &mut hints);
        }
    }
    hints
}

fn warning(place: Place, text: String) -> Hint {
    Hint { place, level: Level::Warning, text }
}

/// 1018h and DeviceInfo: 1018h is what a master reads.
fn identity(eds: &Eds, device: &Section<'_>, hints: &mut Vec<Hint>) {
    for (name, sub) in [("VendorNumber", 1), ("ProductNumber", 2), ("RevisionNumber", 3)] {
        let Some((key, number)) = number_of(device, name) else { continue };
        if let Some(entry) = eds.number(0x1018, sub).filter(|entry| *entry != number) {
            let text = format!("{name} is {number:X}h, but 1018h:{sub} is {entry:X}h: 1018h:{sub} holds");
            hints.push(warning(key.place, text));
        }
    }
}

fn counts(eds: &Eds, device: &Section<'_>, hints: &mut Vec<Hint>) {
    for (name, first) in PDOS {
        let Some((key, number)) = number_of(device, name) else { continue };
        let count = eds.objects.range(first..first + MOST_PDOS).count();
        if i128::try_from(count).ok() != Some(number) {
            hints.push(warning(
                key.place,
                format!("{name} is {number}, but {count} have communication parameters: these count"),
            ));
        }
    }
}

fn number_of<'a>(section: &Section<'a>, name: &str) -> Option<(Key<'a>, i128)> {
    let key = *section.key(name)?;
    let written = number::read(key.bare()).filter(|written| !written.number.node_id)?;
    Some((key, written.number.offset))
}

/// An identifier with a node-ID baked in is that of one node only.
fn identifier(index: u16, object: &Object, hints: &mut Vec<Hint>) {
    let Some(entry) = object.entries.get(&1) else { return };
    if let Some(number) = literal(entry).filter(|number| number & OFF == 0 && (0x181..0x580).contains(number))
    {
        let text = format!(
            "{index:04X}h:01 is {number:X}h at every node-ID: of nodes with other numbers it is the identifier of another PDO; \
             $NODEID+0x{:X} follows the node",
            number & !0x7F
        );
        hints.push(Hint { place: entry.place, level: Level::Note, text });
    }
}

/// The default mapping of a PDO works as it is; the same mapping written by a master may be refused.
fn mapping(eds: &Eds, index: u16, object: &Object, hints: &mut Vec<Hint>) {
    for (sub, entry) in object.entries.range(1..) {
        let Some(word) = literal(entry).and_then(|word| u32::try_from(word).ok()).filter(|word| *word != 0)
        else {
            continue;
        };
        let [high, low, mapped_sub, bits] = word.to_be_bytes();
        let mapped_index = u16::from_be_bytes([high, low]);
        let what = format!("{index:04X}h:{sub:02X} maps {mapped_index:04X}h:{mapped_sub:02X}");
        let text = match eds.entry(mapped_index, mapped_sub) {
            None if (1..=7).contains(&mapped_index) => {
                let is_allowed = eds.dummies & 1 << mapped_index != 0;
                (!is_allowed).then(|| format!("{what}, a gap that DummyUsage does not allow"))
            }
            None => Some(format!("{what}, which the file does not have")),
            Some(mapped) if !mapped.mappable => Some(format!("{what}, whose PDOMapping is 0")),
            Some(mapped) => lengths(mapped.data).filter(|lengths| !lengths.contains(&bits)).map(|lengths| {
                let expected: Vec<_> = lengths.iter().map(ToString::to_string).collect();
                format!("{what} with {bits} bits, expected {}", expected.join(" or "))
            }),
        };
        hints.extend(text.map(|text| warning(entry.place, text)));
    }
}

/// The default of an entry that is a number without `$NODEID`.
fn literal(entry: &Entry) -> Option<i128> {
    match &entry.content {
        Content::Whole(number) if !number.node_id => Some(number.offset),
        Content::Whole(_) | Content::None | Content::Real(_) | Content::Octets(_) => None,
    }
}

/// The bits that a value has in a PDO.
fn lengths(data: DataType) -> Option<Vec<u8>> {
    let bits = u8::try_from(data.octets()?.checked_mul(8)?).ok()?;
    Some(if data == DataType::Boolean { vec![1, bits] } else { vec![bits] })
}
