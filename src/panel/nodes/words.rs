//! The words of bits of a node, its PDOs, and its error history.

use serde::Serialize;
use utoipa::ToSchema;

use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::pdo::MAX_PDOS;
use crate::can_bus::canopen::pdo::mapping::MappingWord;
use crate::can_bus::canopen::{Address, dictionary};
use crate::devices::{CanopenDevice, Vocabulary};

/// A control or status word.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct NodeWord {
    /// `6041h:00`
    object: String,
    name: &'static str,
    #[schema(minimum = 0, maximum = 65535)]
    value: u16,
    /// Bit 0 first.
    bits: Vec<NodeBit>,
}

/// One bit with what it means in the mode in force.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct NodeBit {
    bit: u8,
    set: bool,
    /// Empty for a bit that means nothing.
    name: &'static str,
}

/// A PDO as it is configured now.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Pdo {
    /// `TPDO1` or `RPDO1`, seen from the node.
    pdo: String,
    /// Whether it is on.
    valid: bool,
    /// Its COB-ID without the upper bits, hexadecimal.
    cob_id: String,
    transmission_type: u8,
    entries: Vec<PdoEntry>,
}

/// An entry in a PDO.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct PdoEntry {
    /// `6041h:00`
    object: String,
    name: &'static str,
    bits: u8,
    /// The value now; of an RPDO what came last. `null`: a dummy, or not to be read.
    value: Option<i64>,
}

/// An entry of the error history 1003h.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct HistoryEntry {
    /// The EMCY code, hexadecimal.
    code: String,
    /// Bits 31 to 16, of the device; hexadecimal.
    information: String,
    text: &'static str,
}

/// A whole number of the dictionary.
pub(super) fn whole(device: &dyn CanopenDevice, at: Address) -> Option<i64> {
    let app = device.application();
    let entry = dictionary::entry(app.objects(), at).ok()?;
    let read = device
        .node()
        .read_with(at, app, |octets| Ok(entry.data.decode(octets).and_then(|value| value.number())));
    read.ok().flatten()
}

/// The control word and the status word; none while the node is off.
pub(super) fn words(vocabulary: &Vocabulary, device: &dyn CanopenDevice) -> Vec<NodeWord> {
    let word = |at: Address| {
        let value = u16::try_from(whole(device, at)?).ok()?;
        let name = dictionary::object(device.application().objects(), at.index)?.name;
        let names = (vocabulary.bits)(at, device.mode());
        let bit = |bit: u8| NodeBit {
            bit,
            set: value >> bit & 1 == 1,
            name: names.and_then(|names| names.get(usize::from(bit)).copied()).unwrap_or_default(),
        };
        Some(NodeWord { object: at.to_string(), name, value, bits: (0..16).map(bit).collect() })
    };
    device.words().iter().copied().filter_map(word).collect()
}

/// The PDOs that the device has; RPDOs first.
pub(super) fn pdos(device: &dyn CanopenDevice) -> Vec<Pdo> {
    let places = 0..u16::try_from(MAX_PDOS).unwrap_or(u16::MAX);
    let kinds = [("RPDO", 0x1400), ("TPDO", 0x1800)];
    let all = kinds
        .into_iter()
        .flat_map(|(name, first)| places.clone().map(move |place| (name, first + place, place)));
    all.filter_map(|(name, index, place)| {
        let cob_id = u32::try_from(whole(device, Address::new(index, 1))?).ok()?;
        let mapping = index + 0x200;
        let count = whole(device, Address::new(mapping, 0)).and_then(|count| u8::try_from(count).ok());
        let entries = (1..=count.unwrap_or(0)).filter_map(|sub| entry(device, Address::new(mapping, sub)));
        Some(Pdo {
            pdo: format!("{name}{}", place + 1),
            valid: CobId(cob_id).is_valid(),
            cob_id: format!("{:03X}", cob_id & 0x1FFF_FFFF),
            transmission_type: u8::try_from(whole(device, Address::new(index, 2))?).ok()?,
            entries: entries.collect(),
        })
    })
    .collect()
}

fn entry(device: &dyn CanopenDevice, mapped: Address) -> Option<PdoEntry> {
    let word = MappingWord::decode(u32::try_from(whole(device, mapped)?).ok()?);
    let name = dictionary::entry(device.application().objects(), word.at).map_or("dummy", |entry| entry.name);
    Some(PdoEntry { object: word.at.to_string(), name, bits: word.bits, value: whole(device, word.at) })
}

/// 1003h, the newest first.
pub(super) fn history(vocabulary: &Vocabulary, device: &dyn CanopenDevice) -> Vec<HistoryEntry> {
    let count = whole(device, Address::new(0x1003, 0)).and_then(|count| u8::try_from(count).ok());
    let entry = |sub: u8| {
        let entry = u32::try_from(whole(device, Address::new(0x1003, sub))?).ok()?;
        let [code_low, code_high, low, high] = entry.to_le_bytes();
        let code = u16::from_le_bytes([code_low, code_high]);
        Some(HistoryEntry {
            code: format!("{code:04X}"),
            information: format!("{high:02X}{low:02X}"),
            text: (vocabulary.emcy)(code, [low, high, 0, 0, 0]).unwrap_or_default(),
        })
    };
    (1..=count.unwrap_or(0)).filter_map(entry).collect()
}
