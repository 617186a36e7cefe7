//! Frames of CANopen that are neither SDO nor PDO, in words: NMT, SYNC, time, error control and emergencies.

use super::entry::{emcy as emcy_in_words, register};
use super::node::Learned;
use super::{Network, Said};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::NmtState;
use crate::explain::field::Bits;
use crate::explain::{Field, Mark, Sender};

/// Frame 000h: a command to one node or to all.
pub(super) fn nmt(network: &mut Network, frame: &Frame) -> Said {
    let said = Said { sender: Some(Sender::Master), ..Said::new("NMT", "NMT", frame) };
    let &[command, node] = frame.octets() else {
        let why = "an NMT command is a data frame of 2 octets: command and node; nodes ignore this one";
        return Said { summary: "NMT, not valid".into(), ..said }.ignored(why);
    };
    let name = match command {
        0x01 => Some("start: to OPERATIONAL"),
        0x02 => Some("stop: to STOPPED"),
        0x80 => Some("to PRE-OPERATIONAL"),
        0x81 => Some("reset node"),
        0x82 => Some("reset communication"),
        0x00 | 0x03..=0x7F | 0x83.. => None,
    };
    let target = match node {
        0 => "all nodes".to_string(),
        1..=127 => format!("node {node}"),
        128.. => format!("{node}, which is no node"),
    };
    let first = Field::octet("command", 0, command, name.unwrap_or("no command"));
    let second = Field::octet("node", 1, node, target.clone());
    let to = (1..=127).contains(&node).then_some(node);
    let summary = format!("NMT to {target}: {}", name.unwrap_or("unknown command"));
    let (first, second) = match (name, node) {
        (None, _) => (first.mistaken("nodes ignore it: 01h, 02h, 80h, 81h and 82h are commands"), second),
        (Some(_), 128..) => (first, second.mistaken("nodes have the numbers 1 to 127; 0 means all")),
        (Some(_), 0..=127) => {
            if matches!(command, 0x81 | 0x82) {
                let nodes: Vec<u8> =
                    to.map_or_else(|| network.nodes.keys().copied().collect(), |node| [node].into());
                nodes.into_iter().for_each(|node| network.reset(node));
            }
            (first, second)
        }
    };
    Said { node: to, summary, ..said }.with(Vec::from([first, second]))
}

/// SYNC, with a counter if CiA 301 V4.1 is used.
pub(super) fn sync(frame: &Frame) -> Said {
    let said = Said { sender: Some(Sender::Master), ..Said::new("SYNC", "SYNC", frame) };
    match frame.octets() {
        _ if frame.is_remote() => said.ignored("a remote request of SYNC is ignored"),
        [] => said,
        [counter] => {
            let field = Field::octet("counter", 0, *counter, "");
            Said { summary: format!("SYNC, counter {counter}"), ..said }.with(Vec::from([field]))
        }
        [..] => said,
    }
}

/// TIME: milliseconds since midnight and days since 1984-01-01.
pub(super) fn time(frame: &Frame) -> Said {
    let said = Said::new("TIME", "time stamp", frame);
    let &[a, b, c, d, low, high] = frame.octets() else {
        return said.ignored("a time stamp has 6 octets");
    };
    let millis = u32::from_le_bytes([a, b, c, d]) & 0x0FFF_FFFF;
    let days = u16::from_le_bytes([low, high]);
    let fields = Vec::from([
        Field::octets("time of day", 0, &[a, b, c, d], format!("{millis} ms since midnight")),
        Field::octets("days", 4, &[low, high], format!("{days} days since 1984-01-01")),
    ]);
    Said { summary: format!("time stamp: day {days}, {millis} ms"), ..said }.with(fields)
}

/// Boot-up, heartbeat, guarding: a state, or the request for it.
pub(super) fn error_control(node: &mut Learned, number: u8, frame: &Frame) -> Said {
    let said = |summary: String| Said::new("error control", summary, frame);
    if frame.is_remote() {
        return said(format!("guarding request to {number}")).to(number);
    }
    let &[octet] = frame.octets() else {
        let summary = format!("error control of {number}, not valid");
        return said(summary).from(number).ignored("error control has 1 octet: toggle bit and state");
    };
    if octet == 0 {
        node.nmt = Some(NmtState::PreOperational);
        node.reset();
        let field = Field::octet("state", 0, octet, "boot-up");
        return said(format!("boot-up of {number}")).from(number).with(Vec::from([field]));
    }
    let state = NmtState::from_octet(octet);
    node.nmt = state;
    let name = state.map_or_else(|| "unknown state".into(), |state| state.to_string());
    let toggle = octet >> 7;
    let kind = if toggle == 1 { "guarding answer" } else { "heartbeat or guarding answer" };
    let place = |high, low| Bits { high, low };
    let state_field = Field::bits("state", (0, 1), place(6, 0), octet.into(), name.clone());
    let fields = Vec::from([
        Field::bits("toggle", (0, 1), place(7, 7), octet.into(), ""),
        if state.is_none() { state_field.marked(Mark::Invalid) } else { state_field },
    ]);
    let whole = Field::octet("error control", 0, octet, "").with(fields);
    said(format!("{kind} of {number}: {name}")).from(number).with(Vec::from([whole]))
}

/// An emergency: code, error register, octets of the device.
pub(super) fn emcy(node: &Learned, number: u8, frame: &Frame) -> Said {
    let said =
        |summary: String| Said::new("EMCY", format!("EMCY of {number}: {summary}"), frame).from(number);
    let &[low, high, bits, a, b, c, d, e] = frame.octets() else {
        return said("not valid".into()).ignored("an emergency has 8 octets");
    };
    let code = u16::from_le_bytes([low, high]);
    let meaning = emcy_in_words(node, code, [a, b, c, d, e]);
    let set = register(node, bits);
    let mark = if code == 0 { Mark::Plain } else { Mark::Trouble };
    let names = node.words().errors.register;
    let parts = (0..8_u8)
        .zip(names)
        .rev()
        .map(|(n, name)| Field::bits(name, (2, 1), Bits { high: n, low: n }, bits.into(), ""))
        .collect();
    let fields = Vec::from([
        Field::octets("error code", 0, &[low, high], meaning.clone()).marked(mark),
        Field::octet("error register", 2, bits, set.clone()).with(parts),
        Field::octets("of the device", 3, &[a, b, c, d, e], ""),
    ]);
    said(format!("{meaning}; error register {set}")).with(fields)
}
