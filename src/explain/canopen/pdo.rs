//! Process data: the entries that a mapping puts into a PDO.

use super::Said;
use super::entry::{field, in_words, named, octets_of, step_left_out};
use super::node::{Learned, RPDO_MAPPING, TPDO_MAPPING};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::NmtState;
use crate::can_bus::canopen::pdo::mapping::MappingWord;
use crate::explain::Field;

/// A TPDO: from the node, or the request for it.
pub(super) fn transmit(node: &mut Learned, number: u8, pdo: u16, frame: &Frame) -> Said {
    if frame.is_remote() {
        let said = Said::new("PDO", format!("request of TPDO {pdo} of {number}"), frame).to(number);
        return in_operation(node, said, "sends");
    }
    let (summary, fields, _) = content(node, TPDO_MAPPING, pdo, frame);
    Said::new("PDO", format!("TPDO {pdo} of {number}: {summary}"), frame).from(number).with(fields)
}

/// An RPDO: to the node.
pub(super) fn rpdo(node: &mut Learned, number: u8, pdo: u16, frame: &Frame) -> Said {
    if frame.is_remote() {
        let summary = format!("request of RPDO {pdo} of {number}");
        return Said::new("PDO", summary, frame).to(number).ignored("an RPDO is received: no node answers");
    }
    let (summary, fields, mistake) = content(node, RPDO_MAPPING, pdo, frame);
    let said = Said::new("PDO", format!("RPDO {pdo} to {number}: {summary}"), frame).to(number).with(fields);
    let said = match mistake {
        Some(why) => said.ignored(why),
        None => said,
    };
    in_operation(node, said, "takes")
}

/// Says so if the node is known to be in a state without PDOs.
fn in_operation(node: &Learned, said: Said, does: &str) -> Said {
    match node.nmt {
        Some(state @ (NmtState::Stopped | NmtState::PreOperational)) => {
            said.ignored(format!("the node was last seen in {state}: it {does} PDOs in OPERATIONAL only"))
        }
        Some(NmtState::Operational) | None => said,
    }
}

/// What the octets are by the mapping, and what is wrong with an RPDO.
fn content(node: &mut Learned, base: u16, pdo: u16, frame: &Frame) -> (String, Vec<Field>, Option<String>) {
    let octets = frame.octets();
    let raw = |octets: &[u8]| match octets {
        [] => Vec::new(),
        octets => Vec::from([Field::octets("data", 0, octets, "")]),
    };
    let unknown = || (format!("{}, mapping not known", octets_of(octets.len())), raw(octets), None);
    let Some(mapping) = node.mapping(base + pdo - 1) else { return unknown() };
    // Of pieces that are no whole octets nobody makes a mapping here.
    if mapping.iter().any(|word| !word.bits.is_multiple_of(8) || word.bits == 0) {
        return unknown();
    }
    let long: usize = mapping.iter().map(|word| usize::from(word.bits / 8)).sum();
    // The mapping of CiA 402 is a guess: it counts where it fits.
    let guessed = node.vocabulary.is_none()
        && node.heard(crate::can_bus::canopen::Address::new(base + pdo - 1, 0)).is_none();
    if guessed && long != octets.len() {
        return unknown();
    }
    if octets.len() < long {
        let why = format!("it has {}, the mapping {long}: the node ignores it", octets_of(octets.len()));
        return ("too short for its mapping".into(), raw(octets), Some(why));
    }
    let (mut fields, mut said, mut at) = (Vec::new(), Vec::new(), 0);
    let mut mistake = None;
    for MappingWord { at: entry, bits } in mapping {
        let len = usize::from(bits / 8);
        let part = octets.get(at..at + len).unwrap_or_default();
        let word = MappingWord { at: entry, bits };
        if word.is_dummy() {
            fields.push(Field::octets("dummy", at, part, "not taken"));
        } else {
            let one = field(node, entry, at, part);
            said.push(format!("{} = {}", named(node, entry), in_words(node, entry, part)));
            let left_out = match (entry.pair(), part) {
                ((0x6040, 0), [low, high]) => step_left_out(node, u16::from_le_bytes([*low, *high])),
                ((0.., 0..), [..]) => None,
            };
            mistake = mistake.or(left_out.map(String::from));
            node.hear(entry, part);
            fields.push(one);
        }
        at += len;
    }
    if let Some(surplus) = octets.get(at..).filter(|surplus| !surplus.is_empty()) {
        fields.push(Field::octets("surplus", at, surplus, "behind the mapping, not taken"));
    }
    (said.join("; "), fields, mistake)
}
