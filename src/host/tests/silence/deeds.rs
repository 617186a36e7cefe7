//! What a person does with a correct master, one thing after the other, and how many lines are told of it at most: one for
//! each state that the device comes to by it, and one for the beginning and one for the end of a motion.

use core::time::Duration;

use super::exam::{enable_node, job, word};
use super::nodes::{self, Bus};
use super::slaves::{self, CYCLE, Line, MASTER};
use super::words::Kind;
use crate::devices::CanopenEvent;
use crate::host::BusEvent;
use crate::time::Instant;

/// A thing that a person does at a slave, and how many lines it is at most.
type AtSlave = (&'static str, usize, fn(&mut Line));
/// The same at a node.
type AtNode = (&'static str, usize, fn(&mut Bus));

fn setpoint(line: &mut Line, octets: &[u8]) {
    let at = line.target.kind.stw().unwrap() + 2;
    line.outputs[at..at + octets.len()].copy_from_slice(octets);
    line.exchange(12);
}

const AT_SLAVE: &[AtSlave] = &[
    ("starts the master", 2, |line| {
        assert!(line.start_up());
        line.exchange(5);
    }),
    ("enables the drive", 3, |line| match line.target.kind {
        Kind::Ag03 => [0x3A, 0x3B].into_iter().for_each(|stw| word(line, stw)),
        Kind::Ppo | Kind::Profidrive => [0x47E, 0x47F].into_iter().for_each(|stw| word(line, stw)),
        Kind::Station => {}
    }),
    ("moves it", 2, |line| match line.target.kind {
        Kind::Ag03 => {
            setpoint(line, &[0, 0, 0x03, 0xE8]);
            word(line, 0x7B);
            line.exchange(300);
        }
        Kind::Ppo | Kind::Profidrive => {
            setpoint(line, &[0x10, 0]);
            line.exchange(300);
        }
        Kind::Station => setpoint_of_station(line, 0xFF),
    }),
    ("stops it", 1, |line| match line.target.kind {
        Kind::Ag03 => {}
        Kind::Ppo | Kind::Profidrive => {
            setpoint(line, &[0, 0]);
            line.exchange(300);
        }
        Kind::Station => setpoint_of_station(line, 0),
    }),
    ("writes a parameter", 1, |line| match line.target.kind {
        Kind::Ag03 => {
            job(line, 0x23EC, 0, 20);
            job(line, 0, 0, 0);
        }
        Kind::Ppo | Kind::Profidrive | Kind::Station => {}
    }),
    ("disables it", 2, |line| match line.target.kind {
        Kind::Ag03 => word(line, 0x3A),
        Kind::Ppo | Kind::Profidrive => {
            word(line, 0x47E);
            line.exchange(300);
        }
        Kind::Station => {}
    }),
    ("stops the PLC", 2, |line| {
        line.outputs.fill(0);
        line.exchange(3);
        line.control(MASTER, &[0x02, 0]);
        line.exchange(3);
        let unlock = [&[0x40], &line.prm()[1..]].concat();
        line.ask(MASTER, crate::profibus::dp::Service::SetPrm, &unlock);
    }),
    ("starts the PLC again", 2, |line| {
        assert!(line.start_up());
        line.exchange(5);
    }),
];

fn setpoint_of_station(line: &mut Line, octet: u8) {
    line.outputs.fill(octet);
    line.exchange(5);
}

/// Whether it is a drive with positions.
fn positions(bus: &Bus) -> bool {
    bus.target.drive && bus.target.name != "servo"
}

const AT_NODE: &[AtNode] = &[
    ("starts the node", 1, |bus| bus.nmt(1)),
    ("chooses a mode", 1, |bus| {
        if positions(bus) {
            bus.write(0x6060, 0, 1, 1);
        }
    }),
    ("enables the drive", 4, |bus| {
        if bus.target.drive {
            enable_node(bus);
        }
    }),
    ("moves it", 2, |bus| {
        if positions(bus) {
            bus.write(0x607A, 0, 1000, 4);
            [0x1F, 0x0F].into_iter().for_each(|word| _ = bus.write(0x6040, 0, word, 2));
            bus.wait(Duration::from_secs(3));
        }
    }),
    ("writes an object", 1, |bus| _ = bus.write(0x1017, 0, 500, 2)),
    ("disables it", 2, |bus| {
        if bus.target.drive {
            bus.write(0x6040, 0, 6, 2);
            bus.wait(Duration::from_secs(2));
        }
    }),
    ("stops the PLC", 2, |bus| bus.nmt(0x80)),
    ("resets the node", 1, |bus| {
        bus.nmt(0x81);
        bus.wait(Duration::from_secs(2));
    }),
    ("starts the PLC again", 1, |bus| bus.nmt(1)),
];

/// Every thing at every slave: what was told of it.
pub(crate) fn at_slaves(tell: &mut dyn FnMut(String, usize, Vec<(Instant, BusEvent)>)) {
    for target in slaves::TARGETS {
        let mut line = Line::of(target);
        line.events.clear();
        for (deed, most, act) in AT_SLAVE {
            act(&mut line);
            line.wait(CYCLE * 500);
            tell(format!("{}: a person {deed}", target.name), *most, core::mem::take(&mut line.events));
        }
    }
}

/// The same at every node.
pub(crate) fn at_nodes(tell: &mut dyn FnMut(String, usize, Vec<(Instant, CanopenEvent)>)) {
    for target in nodes::TARGETS {
        let mut bus = Bus::of(target);
        bus.events.clear();
        for (deed, most, act) in AT_NODE {
            act(&mut bus);
            bus.wait(CYCLE * 500);
            tell(format!("{}: a person {deed}", target.name), *most, core::mem::take(&mut bus.events));
        }
    }
}
