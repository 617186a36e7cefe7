//! One entry of a dictionary: its name, its value in words, the bits of a word, and what the device refuses to take.

use super::node::Learned;
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::dictionary::Place;
use crate::can_bus::canopen::pdo::mapping::MappingWord;
use crate::can_bus::canopen::value::ValueKind;
use crate::can_bus::canopen::{Abort, Address, DataType, Entry, Value};
use crate::can_bus::cia402::{Command, Controlword, State, Statusword, axis};
use crate::devices::ag03::param;
use crate::explain::field::Bits;
use crate::explain::{Field, hex, value};

/// `6041h:00 Statusword`, `2410h:05 Controller parameters: v-Pos rpm`; an unknown entry has only its address.
pub(super) fn named(node: &Learned, at: Address) -> String {
    match name(node, at) {
        Some(name) => format!("{at} {name}"),
        None => at.to_string(),
    }
}

/// The name of an entry, with that of its object if it has more than one.
pub(super) fn name(node: &Learned, at: Address) -> Option<String> {
    let object = node.object(at)?;
    let entry = object.entry(at.sub)?;
    Some(match object.entries {
        [_] => entry.name.to_string(),
        [..] => format!("{}: {}", object.name, entry.name),
    })
}

/// A value in words: with its unit, what a number stands for, the bits that are 1.
pub(super) fn in_words(node: &Learned, at: Address, octets: &[u8]) -> String {
    let words = node.words();
    let decoded = node.entry(at).ok().and_then(|entry| entry.data.decode(octets));
    let Some(decoded) = decoded else { return format!("{} (low octet first)", hex(octets)) };
    let Some(number) = decoded.number() else { return decoded.to_string() };
    if let Some(names) = (words.bits)(at, node.mode(at)) {
        return word_in_words(at, low_word(octets), &names, octets.len());
    }
    if let Some(meaning) = (words.choice)(at, number) {
        return format!("{number} ({meaning})");
    }
    if let Some(parameter) = (words.parameter)(at) {
        return value::in_words(parameter, of_parameter(parameter, number), node.lengths);
    }
    let bits = u32::try_from(number).unwrap_or_default();
    match at.pair() {
        (0x1005 | 0x1014, 0) | (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => cob_id(CobId(bits)),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 1..) => mapped(node, bits),
        (0.., 0..) if at.takes_signature() => signature(octets),
        (0x1001, 0) => register(node, bits.to_le_bytes()[0]),
        (0x1003, 1..) | (0x603F, 0) => {
            let [low, high, a, b] = bits.to_le_bytes();
            emcy(node, u16::from_le_bytes([low, high]), [a, b, 0, 0, 0])
        }
        (0x1000..=0x1FFF, _) if matches!(decoded, Value::U32(_)) => format!("{bits:08X}h"),
        (0.., 0..) => number.to_string(),
    }
}

/// A field of a value with its words, and of a word of bits with a part for each bit.
pub(super) fn field(node: &Learned, at: Address, place: usize, octets: &[u8]) -> Field {
    let label = name(node, at).unwrap_or_else(|| "value".into());
    let field = Field::octets(label, place, octets, in_words(node, at, octets));
    match ((node.words().bits)(at, node.mode(at)), octets) {
        (Some(names), [_, _]) => field.with(bits(&names, place, low_word(octets))),
        (Some(_), [..]) | (None, [..]) => field,
    }
}

/// Why the device refuses to take `octets` into an entry; `None` as far as anybody can tell. Without a device nothing can
/// be told.
pub(super) fn refusal(node: &Learned, at: Address, octets: &[u8]) -> Option<String> {
    let device = node.vocabulary.filter(|words| words.complete)?.name;
    let refused = |abort: Abort| Some(format!("the {device} refuses: {abort}"));
    let entry = match node.entry(at) {
        Ok(entry) => entry,
        Err(abort) => return refused(abort),
    };
    if !entry.is_writable() {
        return refused(Abort::READ_ONLY);
    }
    let (fewest, most) = entry.lengths();
    if !(fewest..=most).contains(&octets.len()) {
        return Some(format!(
            "the {device} refuses it: {} is {}, got {}",
            entry.name,
            a_type(entry),
            octets_of(octets.len())
        ));
    }
    let decoded = entry.data.decode(octets)?;
    match entry.place(decoded) {
        Place::Inside => None,
        Place::Below | Place::Above | Place::Gap => Some(format!("the {device} refuses it: out of range")),
    }
}

/// Why the device refuses to tell an entry.
pub(super) fn read_refusal(node: &Learned, at: Address) -> Option<String> {
    let device = node.vocabulary.filter(|words| words.complete)?.name;
    let abort = match node.entry(at) {
        Ok(entry) if entry.readable() => return None,
        Ok(_) => Abort::WRITE_ONLY,
        Err(abort) => abort,
    };
    Some(format!("the {device} refuses: {abort}"))
}

/// What an EMCY code means, with its number.
pub(super) fn emcy(node: &Learned, code: u16, more: [u8; 5]) -> String {
    match (node.words().errors.emcy)(code, more) {
        Some(meaning) => format!("{code:04X}h, {meaning}"),
        None => format!("{code:04X}h"),
    }
}

/// The bits of the error register that are 1.
pub(super) fn register(node: &Learned, bits: u8) -> String {
    let set: Vec<_> = node.words().errors.set_in(bits).collect();
    if set.is_empty() { format!("{bits:02X}h, no error") } else { format!("{bits:02X}h, {}", set.join(", ")) }
}

/// Why a control word leads nowhere, from the status word seen last: operation is enabled step by step.
pub(super) fn step_left_out(node: &Learned, word: u16) -> Option<&'static str> {
    let state = State::of(Statusword(node.status?))?;
    let before = Controlword(node.control.unwrap_or_default());
    match (state, Controlword(word).command(before)) {
        (State::SwitchOnDisabled, Command::SwitchOn | Command::EnableOperation) => {
            Some("the drive is in switch on disabled and stays there: send shutdown (0006h) first")
        }
        (State::ReadyToSwitchOn, Command::EnableOperation) => {
            Some("the drive is in ready to switch on and stays there: send switch on (0007h) first")
        }
        (
            State::NotReadyToSwitchOn
            | State::SwitchOnDisabled
            | State::ReadyToSwitchOn
            | State::SwitchedOn
            | State::OperationEnabled
            | State::QuickStopActive
            | State::FaultReactionActive
            | State::Fault,
            Command::Shutdown
            | Command::SwitchOn
            | Command::EnableOperation
            | Command::DisableVoltage
            | Command::QuickStop
            | Command::FaultReset,
        ) => None,
    }
}

fn word_in_words(at: Address, word: u16, names: &[&'static str; 16], octets: usize) -> String {
    let mut said = Vec::from([if octets == 1 { format!("{word:02X}h") } else { format!("{word:04X}h") }]);
    // The state says what bits 0 to 3, 5 and 6 do, the command what bits 0 to 3 and 7 do.
    let told: u16 = match (axis::of_first(at.index.0).1, at.sub.0) {
        (0x6041, 0) => match State::of(Statusword(word)) {
            Some(state) => {
                said.push(state.to_string());
                0x006F
            }
            None => 0,
        },
        (0x6040, 0) => {
            said.push(command(word).into());
            0x008F
        }
        (0.., 0..) => 0,
    };
    let set = (0..16).zip(names).filter(|(n, name)| (word & !told) >> n & 1 == 1 && !name.is_empty());
    said.extend(set.map(|(_, name)| (*name).to_string()));
    said.join(", ")
}

const fn command(word: u16) -> &'static str {
    // Bit 7 counts when it rises; of one word alone that is taken so.
    match Controlword(word).command(Controlword(0)) {
        Command::Shutdown => "shutdown",
        Command::SwitchOn => "switch on or disable operation",
        Command::EnableOperation => "enable operation",
        Command::DisableVoltage => "disable voltage",
        Command::QuickStop => "quick stop",
        Command::FaultReset => "fault reset",
    }
}

/// A part for each bit of a word, the highest first. Bits without a name that lie beside each other share one.
fn bits(names: &[&'static str; 16], at: usize, word: u16) -> Vec<Field> {
    let mut fields: Vec<Field> = Vec::new();
    for (n, name) in (0..16_u8).zip(names).rev() {
        let digit = if word >> n & 1 == 1 { '1' } else { '0' };
        if let Some(field) = fields.last_mut().filter(|field| name.is_empty() && field.name == NOT_USED)
            && let Some(place) = &mut field.bits
        {
            place.low = n;
            field.raw.push(digit);
            continue;
        }
        let name = if name.is_empty() { NOT_USED } else { name };
        let mut field = Field::new(name, at, 2, digit, "");
        field.bits = Some(Bits { high: n, low: n });
        fields.push(field);
    }
    fields
}

const NOT_USED: &str = crate::devices::ag03::profibus::bits::NOT_USED;

fn low_word(octets: &[u8]) -> u16 {
    match *octets {
        [low, high, ..] => u16::from_le_bytes([low, high]),
        [low] => low.into(),
        [] => 0,
    }
}

fn of_parameter(parameter: &param::Entry, number: i64) -> param::Value {
    param::Value::of(parameter.width, i32::try_from(number).unwrap_or_default())
}

fn cob_id(value: CobId) -> String {
    let mut said = Vec::new();
    said.push(match value.id() {
        Some(id) => format!("{id}h"),
        None => format!("{:08X}h, no identifier", value.0),
    });
    if !value.is_valid() {
        said.push("off".into());
    }
    if value.bit_30() {
        said.push("bit 30 set (of a TPDO: no remote requests)".into());
    }
    said.join(", ")
}

fn mapped(node: &Learned, word: u32) -> String {
    if word == 0 {
        return "0, empty".into();
    }
    let MappingWord { at, bits } = MappingWord::decode(word);
    format!("{}, {bits} bits", named(node, at))
}

fn signature(octets: &[u8]) -> String {
    match octets {
        b"save" => "\"save\"".into(),
        b"load" => "\"load\"".into(),
        _other => format!("{}, neither \"save\" nor \"load\"", hex(octets)),
    }
}

fn a_type(entry: &Entry) -> String {
    let data = entry.data;
    let name = match data.kind() {
        ValueKind::Text => "a string".into(),
        ValueKind::Octets if data == DataType::OctetString => "octets".into(),
        ValueKind::Octets if data == DataType::Domain => "a domain".into(),
        ValueKind::Signed | ValueKind::Unsigned | ValueKind::Octets => format!("an {}", data.name()),
        ValueKind::Boolean | ValueKind::Real => format!("a {}", data.name()),
    };
    match entry.data.octets() {
        Some(len) => format!("{name} of {}", octets_of(len)),
        None => name,
    }
}

pub(super) fn octets_of(count: usize) -> String {
    if count == 1 { "1 octet".into() } else { format!("{count} octets") }
}
