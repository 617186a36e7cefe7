//! Test: lines with every kind of device, whose memories are kept, against a model. Random sequences of adding, removing, moving
//! (Set_Slave_Add, DIP switches, 5F0Ah:1, 2300h), switching off and on, writing, saving, factory resets by DIP switches, failing
//! disks, kills, power failures and restarts: no device loses a value that is on the disk, and none has one that nobody wrote.
//! For 10 000 sequences set `PROFIDRIVE_LONG`.
#![cfg(feature = "eds")]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]

use core::time::Duration;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use proptest::prelude::*;

use crate::can_bus::can::{BaseId, Frame, Id};
use crate::can_bus::canopen;
use crate::face::description::{ParameterAccess, ParameterPlace, Switches};
use crate::host::can::{CanParticipant, StoredNode};
use crate::host::list::{Device, Ground, Group, MakeError, Spec};
use crate::host::{Bus, Refusals, StateDir, StateDirError, ValueBoard};
use crate::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Timing};
use crate::time::{BaudRate, Instant};
use faulty_disk::{Failing, FaultyDisk};
use operations::{
    AP10, ASDA_A2, FROM_NODE, KINDS, NO_1010H, NO_SAVE, Op, PARTS, PROFIDRIVE, Part, RESET_ALL, SAVE, SAVED,
    STORE, TO_NODE, number_object, object, op,
};

#[path = "../../../tests/line/faulty_disk.rs"]
mod faulty_disk;
mod operations;

enum Unit {
    /// At this address of the bus.
    Slave(Address),
    Node(Box<StoredNode>),
}

struct World {
    disk: FaultyDisk,
    state: Option<StateDir>,
    now: Instant,
    bus: Bus,
    units: BTreeMap<usize, Unit>,
    /// The values that each device may have after it has been off, the one that is safe first.
    known: BTreeMap<(usize, Part), Vec<u32>>,
    /// The value of each device from the factory.
    fresh: BTreeMap<usize, u32>,
    last: u32,
    /// The disk has refused something since the last start: a station tries it again with the next change only.
    refused: bool,
}

fn files() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gsd/modular.gsd");
        let text = fs::read_to_string(gsd).unwrap();
        let text = text.replace("0x0A02", "0x0A02\nSet_Slave_Add_supp = 1");
        fs::write(folder.path().join("io.gsd"), text).unwrap();
        let own = "[[parameter]]\npnu = 600\nname = \"own\"\ntype = \"uint16\"\nmin = 100\nmax = 60000\ndefault = 150\n";
        fs::write(folder.path().join("own.toml"), own).unwrap();
        folder
    });
    folder.path()
}

fn spec(which: usize) -> Spec {
    let (group, text) = KINDS[which];
    let gsd = files().join("io.gsd").display().to_string();
    let text = text
        .replace("GSD", &gsd)
        .replace("OWN", &files().join("own.toml").display().to_string())
        .replace("TABLE", concat!(env!("CARGO_MANIFEST_DIR"), "/examples/ppo_drive.toml"))
        .replace("EDS", concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds/pump.eds"));
    Spec::parse(group, &text).unwrap()
}

/// The parameter that is written: one that is kept, and the least and the greatest value.
fn parameter(bus: &Bus, at: Address) -> Option<(u16, u32, u32)> {
    let mut found = None;
    bus.description(at)?.each_parameter(&mut |parameter| {
        let (low, high) = (parameter.low.unwrap_or(0.0).max(1.0), parameter.high.unwrap_or(0.0));
        let fits =
            parameter.kept && parameter.access == ParameterAccess::ReadWrite && parameter.elements.is_none();
        // The fault counter takes 0 only; that of the file is wanted, not one of every drive.
        let is_own = parameter.number == 600 || at.number() < 60;
        let fits = fits && parameter.number != 952 && is_own;
        if found.is_none() && fits && high - low >= 50.0 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small and above 0")]
            let limits = (low as u32, high.min(60_000.0) as u32);
            found = Some((parameter.number, limits.0, limits.1));
        }
    });
    found
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small and above 0")]
fn value_of_parameter(bus: &Bus, at: Address, number: u16) -> u32 {
    let mut found = None;
    bus.description(at).unwrap().each_parameter(&mut |parameter| {
        if parameter.number == number {
            found = (parameter.value)(None);
        }
    });
    found.unwrap() as u32
}

fn value_of_node(node: &StoredNode, at: canopen::Address) -> u32 {
    let device = node.as_device();
    let octets = device.node().read_with(at, device.application(), |octets| Ok(octets.to_vec())).unwrap();
    octets.iter().rev().fold(0, |value, octet| value << 8 | u32::from(*octet))
}

impl World {
    fn new() -> Self {
        let mut world = Self {
            disk: FaultyDisk::default(),
            state: None,
            now: Instant::from_millis(1),
            bus: Bus::on(BaudRate::K500, Timing::Untrue),
            units: BTreeMap::new(),
            known: BTreeMap::new(),
            fresh: BTreeMap::new(),
            last: 0,
            refused: false,
        };
        world.start();
        world
    }

    fn start(&mut self) {
        self.state = Some(StateDir::on(Path::new("memory"), Box::new(self.disk.clone())).unwrap());
    }

    fn state(&self) -> &StateDir {
        self.state.as_ref().unwrap()
    }

    fn pass(&mut self) {
        self.now = self.now.saturating_add(Duration::from_millis(5));
        self.bus.handle_timeout(self.now);
        while self.bus.poll_event().is_some() {}
        for unit in self.units.values_mut() {
            if let Unit::Node(node) = unit {
                node.handle_timeout(self.now);
                while node.poll_event().is_some() {}
            }
        }
    }

    fn apply(&mut self, op: Op) {
        match op {
            Op::Add(which) => self.add(which),
            Op::Remove(which) => self.remove(which),
            Op::Switch(which) => self.switch(which),
            Op::Write(which) => self.write(which),
            Op::Renumber(which) => self.renumber(which),
            Op::Readdress(which) => self.readdress(which),
            Op::Reset(which) => self.reset(which),
            Op::Save(which) => _ = self.sdo(which, SAVE),
            Op::Disk(failing) => {
                self.disk.fail(failing);
                self.refused |= failing != Failing::default();
            }
            Op::Writer(images) => (0..images).for_each(|_| _ = self.state().write_next()),
            Op::Settle => self.settle(),
            Op::Kill { calls, power } => self.kill(calls, power),
            Op::Restart => self.restart(),
        }
        self.pass();
    }

    fn add(&mut self, which: usize) {
        let spec = spec(which);
        let made = self.make(&spec);
        let unit = match made {
            Ok(unit) => unit,
            Err(StateDirError::Owned { .. }) => return assert!(self.units.contains_key(&which), "{which}"),
            // Its first image could not be stored.
            Err(StateDirError::File { .. }) => return,
            Err(error) => panic!("{which}: {error}"),
        };
        assert!(!self.units.contains_key(&which), "two have one file: {which}");
        self.units.insert(which, unit);
        for part in PARTS {
            if let Some(found) = self.part(which, part) {
                self.known.entry((which, part)).or_insert_with(|| vec![found]);
            }
        }
        let found = self.value(which).unwrap();
        self.fresh.entry(which).or_insert(found);
        self.check(which);
    }

    fn make(&mut self, spec: &Spec) -> Result<Unit, StateDirError> {
        if let Device::Node(_) | Device::NodeFile(_) = spec.device {
            let product = spec.product().unwrap();
            let node = self.state().load_node(product, spec.node(), &spec.choices, self.now)?;
            return Ok(Unit::Node(Box::new(node)));
        }
        let (refusals, board) = (Refusals::default(), ValueBoard::default());
        let (state, rate) = (self.state.as_ref(), BaudRate::K500);
        let ground = Ground { now: self.now, rate, state, refusals: &refusals, board: &board };
        let station = match spec.prepare().unwrap().make(&ground) {
            Ok(station) => station,
            Err(MakeError::State(error)) => return Err(error),
            Err(error) => panic!("{error}"),
        };
        let address = station.address();
        self.bus.connect(self.now, station, false).unwrap();
        Ok(Unit::Slave(address))
    }

    /// The value that is kept of a device; `None`: it is not there.
    fn value(&self, which: usize) -> Option<u32> {
        self.part(which, Part::Value)
    }

    /// The same of the node number; `None`: there is no such device, or no object.
    fn part(&self, which: usize, part: Part) -> Option<u32> {
        if part == Part::Number {
            let (Some(Unit::Node(node)), Some((at, _))) = (self.units.get(&which), number_object(which))
            else {
                return None;
            };
            return Some(value_of_node(node, at));
        }
        Some(match self.units.get(&which)? {
            Unit::Node(node) => value_of_node(node, object(which)),
            Unit::Slave(address) if KINDS[which].0 == Group::Station => address.number().into(),
            Unit::Slave(address) => {
                let (number, ..) = parameter(&self.bus, *address).unwrap();
                value_of_parameter(&self.bus, *address, number)
            }
        })
    }

    fn remove(&mut self, which: usize) {
        if let Some(Unit::Slave(address)) = self.units.remove(&which) {
            assert!(self.bus.remove(address).is_some(), "{which}");
        }
    }

    fn switch(&mut self, which: usize) {
        match self.units.get_mut(&which) {
            None => {}
            Some(Unit::Node(node)) => {
                node.act(self.now, |device, now| device.power_off(now));
                node.act(self.now, |device, now| device.power_on(now));
            }
            Some(Unit::Slave(address)) => {
                let address = *address;
                for on in [false, true] {
                    let now = self.now;
                    self.bus.with_description(address, |device| device.switch_supply(now, on));
                }
                self.find(which);
            }
        }
        self.check(which);
    }

    /// A station may have another address now, one of its own.
    fn find(&mut self, which: usize) {
        let base = spec(which).place;
        let own = base..base + 9;
        let there = self.bus.addresses().find(|address| own.contains(&address.number())).unwrap();
        self.units.insert(which, Unit::Slave(there));
    }

    /// The DIP switches; `None`: it has none.
    fn switches(&self, which: usize) -> Option<u16> {
        let mut positions = None;
        let mut tell = |switches: Switches<'_>| positions = Some(switches.positions);
        match self.units.get(&which)? {
            Unit::Node(node) => node.as_device().description().tell_switches(&mut tell),
            Unit::Slave(address) => self.bus.description(*address)?.tell_switches(&mut tell),
        }
        positions
    }

    fn set_switches(&mut self, which: usize, positions: u16) {
        match self.units.get_mut(&which) {
            None => {}
            Some(Unit::Node(node)) => {
                node.act(self.now, |device, now| {
                    device.act(now, &mut |device| device.set_switches(positions))
                });
            }
            Some(Unit::Slave(address)) => {
                self.bus.with_description(*address, |device| device.set_switches(positions));
            }
        }
    }

    fn readdress(&mut self, which: usize) {
        if self.switches(which).is_none() {
            return;
        }
        self.last += 1;
        let to = u16::from(spec(which).place) + u16::try_from(self.last % 9).unwrap();
        self.set_switches(which, to);
        self.switch(which);
        let found = match &self.units[&which] {
            Unit::Node(node) => node.node_id().number(),
            Unit::Slave(address) => address.number(),
        };
        assert_eq!(u16::from(found), to, "{:?} by its switches", KINDS[which]);
    }

    fn reset(&mut self, which: usize) {
        let Some(positions) = self.switches(which) else { return };
        let fresh = self.fresh[&which];
        self.known.entry((which, Part::Value)).or_default().push(fresh);
        for positions in [RESET_ALL, positions] {
            self.set_switches(which, positions);
            self.switch(which);
        }
    }

    /// Writes a node number, which acts with the next start.
    fn renumber(&mut self, which: usize) {
        let (Some(_), Some((at, command))) = (self.units.get(&which), number_object(which)) else { return };
        self.last += 1;
        let number = spec(which).place + u8::try_from(10 * (self.last % 9)).unwrap();
        let [index_low, index_high] = at.index.0.to_le_bytes();
        self.sdo(which, [command, index_low, index_high, at.sub.0, number, 0, 0, 0]);
        let value = self.part(which, Part::Number).unwrap();
        self.known.entry((which, Part::Number)).or_default().push(value);
    }

    fn write(&mut self, which: usize) {
        self.last += 1;
        let last = self.last;
        match self.units.get(&which) {
            None => return,
            Some(Unit::Node(_)) => {
                let value = if which == NO_1010H { 1 + last % 90 } else { 1000 + last % 50_000 };
                let [low, high, ..] = value.to_le_bytes();
                let at = object(which);
                let [index_low, index_high] = at.index.0.to_le_bytes();
                // One octet or two.
                let command = if which == NO_1010H { 0x2F } else { 0x2B };
                self.sdo(which, [command, index_low, index_high, at.sub.0, low, high, 0, 0]);
            }
            Some(Unit::Slave(address)) if KINDS[which].0 == Group::Station => {
                let address = *address;
                self.set_slave_add(which, address);
            }
            Some(Unit::Slave(address)) => {
                let address = *address;
                let (number, low, high) = parameter(&self.bus, address).unwrap();
                let (now, value) = (self.now, low + last % (high - low));
                let place = ParameterPlace { number, element: None };
                self.bus.with_description(address, |device| {
                    // Refused while a job waits for the disk.
                    let _ = device.write_parameter(now, place, value.into(), &mut |_| {});
                });
                self.store(which);
            }
        }
        let value = self.value(which).unwrap();
        self.known.entry((which, Part::Value)).or_default().push(value);
    }

    /// PNU 971 of a drive of PROFIdrive.
    fn store(&mut self, which: usize) {
        let Some(Unit::Slave(address)) = self.units.get(&which).filter(|_| which == PROFIDRIVE) else {
            return;
        };
        let (now, place) = (self.now, ParameterPlace { number: STORE, element: None });
        self.bus.with_description(*address, |device| {
            device.write_parameter(now, place, 1.0, &mut |_| {}).unwrap();
        });
    }

    /// Sends it to the next address of its own.
    fn set_slave_add(&mut self, which: usize, from: Address) {
        let base = spec(which).place;
        let to = base + u8::try_from(self.last % 9).unwrap();
        let body = [from.number() | 0x80, 0x82, 0x6D, 55, 62, to, 0x0A, 0x02, 0];
        let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
        let len = u8::try_from(body.len()).unwrap();
        let octets = [&[0x68, len, len, 0x68][..], &body, &[sum, 0x16]].concat();
        self.bus.handle_bytes(self.now, &octets);
        for _ in 0..20 {
            self.now = self.now.saturating_add(Duration::from_micros(100));
            self.bus.handle_timeout(self.now);
            if self.bus.poll_transmit(self.now, &mut [0; MAX_TELEGRAM_LEN]).is_some() {
                break;
            }
        }
        self.find(which);
    }

    /// Sends an SDO to a node: the reply, if one came.
    fn sdo(&mut self, which: usize, request: [u8; 8]) -> Option<[u8; 8]> {
        let now = self.now;
        let Some(Unit::Node(node)) = self.units.get_mut(&which) else { return None };
        let number = u16::from(node.node_id().number());
        let id = |base: u16| Id::Base(BaseId::new(base + number).unwrap());
        node.handle_frame(now, &Frame::data(id(TO_NODE), &request).unwrap());
        self.reply(which)
    }

    fn reply(&mut self, which: usize) -> Option<[u8; 8]> {
        let now = self.now;
        let Some(Unit::Node(node)) = self.units.get_mut(&which) else { return None };
        node.handle_timeout(now);
        let from = FROM_NODE + u16::from(node.node_id().number());
        let mut reply = None;
        while let Some(frame) = node.poll_transmit(now) {
            if frame.id() == Id::Base(BaseId::new(from).unwrap()) {
                reply = frame.octets().try_into().ok();
            }
        }
        reply
    }

    /// What a device has now is one of the values that it may have.
    fn check(&self, which: usize) {
        for part in PARTS {
            if let Some(found) = self.part(which, part) {
                let known = &self.known[&(which, part)];
                let kind = KINDS[which];
                assert!(known.contains(&found), "{part:?} of {kind:?} is {found}, expected one of {known:?}");
            }
        }
    }

    /// A disk that works has everything.
    fn drain(&mut self) {
        self.disk.fail(Failing::default());
        for _ in 0..4 {
            self.pass();
            while self.state().write_next() {}
        }
        self.pass();
    }

    /// What is acknowledged is what may be found, and nothing else.
    fn settle(&mut self) {
        self.drain();
        for which in 0..KINDS.len() {
            if let Some(Unit::Node(_)) = self.units.get(&which) {
                let _earlier = self.reply(which);
                let mut reply = self.sdo(which, SAVE);
                self.drain();
                reply = reply.or_else(|| self.reply(which));
                let done = reply == Some(SAVED) || reply == Some(NO_SAVE);
                assert!(done, "{:?}: {reply:02X?}", KINDS[which]);
            }
            self.store(which);
            self.drain();
            for part in PARTS {
                if self.is_safe(which)
                    && let Some(value) = self.part(which, part)
                {
                    self.known.insert((which, part), vec![value]);
                }
            }
        }
    }

    /// Whether the memory of a device says that it is on the disk, or "save" was answered: an image that a disk refused is
    /// tried again with the next change, or when the device is switched off.
    fn is_safe(&self, which: usize) -> bool {
        let memory = match self.units.get(&which) {
            None => None,
            Some(Unit::Slave(address)) => self.bus.description(*address).and_then(|device| device.memory()),
            Some(Unit::Node(node)) => node.as_device().description().memory(),
        };
        let is_node = matches!(self.units.get(&which), Some(Unit::Node(_)));
        let is_saved = is_node && which != NO_1010H || which == PROFIDRIVE;
        memory.map_or(is_saved || !self.refused, |memory| memory == "in its file")
    }

    fn remove_all(&mut self) {
        (0..KINDS.len()).for_each(|which| self.remove(which));
    }

    fn kill(&mut self, calls: u32, power: Option<usize>) {
        self.disk.kill_after(calls);
        for _ in 0..calls {
            self.state().write_next();
            self.pass();
        }
        self.disk.kill();
        self.remove_all();
        if let Some(chance) = power {
            self.disk.power_failure(chance);
        }
        self.begin_again();
    }

    fn restart(&mut self) {
        self.settle();
        let both = (0..KINDS.len()).flat_map(|which| PARTS.map(|part| (which, part)));
        let safe = |(which, part)| self.part(which, part).filter(|_| self.is_safe(which));
        let before: Vec<_> = both.filter_map(|of| Some((of, safe(of)?))).collect();
        self.remove_all();
        self.drain();
        self.begin_again();
        for ((which, part), before) in before {
            let found = self.part(which, part);
            assert_eq!(found, Some(before), "{part:?} of {:?} ended properly", KINDS[which]);
        }
    }

    fn begin_again(&mut self) {
        (self.state, self.refused) = (None, false);
        self.disk.revive();
        self.start();
        for which in self.fresh.keys().copied().collect::<Vec<_>>() {
            self.add(which);
            // Read from the disk: it stays.
            for part in PARTS {
                if let Some(found) = self.part(which, part) {
                    self.known.insert((which, part), vec![found]);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: if std::env::var_os("PROFIDRIVE_LONG").is_some() { 10_000 } else { 60 },
        ..ProptestConfig::default()
    })]
    #[test]
    fn no_device_of_any_kind_loses_or_invents_a_value(ops in proptest::collection::vec(op(), 1..80)) {
        let mut world = World::new();
        for op in ops {
            world.apply(op);
        }
        world.kill(0, Some(0));
        world.restart();
    }
}

/// The sequences write something in each device, and it is kept.
#[test]
fn each_kind_is_written_and_has_its_value_after_a_restart() {
    let mut world = World::new();
    for which in 0..KINDS.len() {
        world.add(which);
        let before = world.value(which).unwrap();
        world.write(which);
        let written = world.value(which).unwrap();
        assert_ne!(written, before, "{:?}", KINDS[which]);
        world.restart();
        assert_eq!(world.value(which), Some(written), "{:?}", KINDS[which]);
    }
}

/// They get other numbers, by the bus and by switches, and those of the bus are kept; a reset by switches is kept, too.
#[test]
fn each_kind_is_renumbered_and_reset_as_its_device_is() {
    let mut world = World::new();
    let (mut renumbered, mut reset) = (Vec::new(), Vec::new());
    for which in 0..KINDS.len() {
        world.add(which);
        let before = world.part(which, Part::Number);
        world.renumber(which);
        let written = world.part(which, Part::Number);
        world.restart();
        assert_eq!(world.part(which, Part::Number), written, "{:?}", KINDS[which]);
        if written != before {
            let Unit::Node(node) = &world.units[&which] else { panic!("no node") };
            assert_eq!(Some(u32::from(node.node_id().number())), written, "{:?}", KINDS[which]);
            renumbered.push(which);
        }
        if world.switches(which).is_some() {
            world.write(which);
            assert_ne!(world.value(which), Some(world.fresh[&which]), "{:?}", KINDS[which]);
            world.readdress(which);
            world.settle();
            world.reset(which);
            assert_eq!(world.value(which), Some(world.fresh[&which]), "{:?}", KINDS[which]);
            world.restart();
            assert_eq!(world.value(which), Some(world.fresh[&which]), "{:?}", KINDS[which]);
            reset.push(which);
        }
    }
    assert_eq!((renumbered, reset), (vec![AP10, ASDA_A2], vec![0, 1, NO_1010H]));
}
