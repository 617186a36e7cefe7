//! A node of each kind, and a master that makes mistakes.

use core::time::Duration;
use std::collections::{BTreeMap, BTreeSet};

use super::{Told, expect_none, walks};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{self, NmtState};
use crate::chance::Random;
use crate::devices::CanopenEvent;
use crate::host::can::{CanParticipant, NodeWatch, Numbers, StoredNode};
use crate::host::list::{Group, Spec};
use crate::time::Instant;

const NODE: u8 = 5;
/// A control word is looked at after so long.
const HELD: Duration = Duration::from_millis(150);

/// A node, and whether it is a drive of CiA 402.
pub(super) struct Target {
    pub(super) name: &'static str,
    spec: &'static str,
    pub(super) drive: bool,
}

pub(super) const TARGETS: &[Target] = &[
    Target { name: "ag03-1", spec: "5", drive: true },
    Target { name: "ap10", spec: "5,device=ap10", drive: false },
    Target { name: "asda-a2", spec: "5,device=asda-a2", drive: true },
    Target { name: "servo", spec: "5,eds=EDS/servo.dcf", drive: true },
    Target { name: "drive", spec: "5,eds=EDS/drive.eds", drive: true },
    Target { name: "terminal", spec: "5,eds=EDS/terminal.eds", drive: false },
    Target { name: "pump", spec: "5,eds=EDS/pump.eds", drive: false },
];

pub(super) struct Bus {
    pub(super) target: &'static Target,
    node: StoredNode,
    watch: NodeWatch,
    pub(super) now: Instant,
    replies: Vec<Frame>,
    news: Vec<String>,
    /// The same with everything else, since it was taken.
    pub(super) events: Vec<(Instant, CanopenEvent)>,
    story: Vec<String>,
    /// What was told and is told once for its kind, until something changes.
    once: BTreeSet<String>,
}

pub(super) fn frame(id: u32, octets: &[u8]) -> Frame {
    Frame::data(Id::base(id.try_into().unwrap()).unwrap(), octets).unwrap()
}

impl Bus {
    pub(super) fn of(target: &'static Target) -> Self {
        let now = Instant::from_millis(1);
        let files = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds");
        let spec = Spec::parse(Group::Node, &target.spec.replace("EDS", files)).unwrap();
        let device = spec.product().unwrap().make(spec.node(), &spec.choices, Eeprom::Internal, now);
        let node = StoredNode::new(device, now);
        let (replies, news, story, once) = (Vec::new(), Vec::new(), Vec::new(), BTreeSet::new());
        let (watch, events) = (NodeWatch::inside(), Vec::new());
        let mut bus = Self { target, node, watch, now, replies, news, events, story, once };
        bus.wait(Duration::from_millis(500));
        bus.news.clear();
        bus
    }

    fn hear(&mut self) {
        while let Some(frame) = self.node.poll_transmit(self.now) {
            self.replies.push(frame);
        }
        while let Some(event) = self.node.poll_event() {
            let text = event.to_string();
            self.events.push((self.now, event.clone()));
            if event.is_detail() {
                self.story.push(format!("      ({text})"));
            } else {
                self.say(text);
            }
        }
    }

    fn say(&mut self, text: String) {
        self.story.push(format!("      {text}"));
        let kinds = [
            "SDO request ignored",
            "SDO request for",
            "node 9 is",
            "NMT command",
            "SDO request of",
            "NMT command of",
            "RPDO1",
            "RPDO2",
            "RPDO3",
            "RPDO4",
            "29 bits",
            "TPDO",
            "guarding",
            "has no effect in",
            "homing",
            "is not taken",
        ];
        if text.contains("ignored: the node is") || text.contains("it is off or has another") {
            self.once.extend((1..=4).map(|pdo| format!("RPDO{pdo}")));
        }
        self.once.extend(kinds.iter().filter(|kind| text.contains(**kind)).map(|kind| (*kind).to_owned()));
        self.news.push(text);
    }

    pub(super) fn wait(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        while let Some(due) = self.node.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due).saturating_add(Duration::from_nanos(1));
            self.node.handle_timeout(self.now);
            self.hear();
        }
        self.now = self.now.max(end);
        self.node.handle_timeout(self.now);
        self.hear();
    }

    /// Sends a frame: what the node sends soon.
    pub(super) fn send(&mut self, sent: &Frame) -> Vec<Frame> {
        self.wait(Duration::from_millis(1));
        self.replies.clear();
        let ours = self.node.node_id();
        if let Some(hint) = self.watch.heard(self.now, sent, || Numbers::of([ours])) {
            self.say(hint.to_string());
        }
        self.node.handle_frame(self.now, sent);
        self.hear();
        self.wait(Duration::from_millis(2));
        let replies = core::mem::take(&mut self.replies);
        self.story.push(format!("  {sent}"));
        replies
    }

    pub(super) fn take_news(&mut self) -> Vec<String> {
        core::mem::take(&mut self.news)
    }

    pub(super) fn sdo(&mut self, octets: &[u8]) -> Option<[u8; 8]> {
        let replies = self.send(&frame(0x600 + u32::from(NODE), octets));
        let from = frame(0x580 + u32::from(NODE), &[]).id();
        replies.iter().find(|reply| reply.id() == from).and_then(|reply| reply.octets().try_into().ok())
    }

    pub(super) fn write(&mut self, index: u16, sub: u8, value: i64, octets: usize) -> Option<[u8; 8]> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d, ..] = value.to_le_bytes();
        let command = 0x23 | u8::try_from(4 - octets.min(4)).unwrap() << 2;
        self.sdo(&[command, low, high, sub, a, b, c, d])
    }

    /// What an entry holds, without the bus.
    fn value(&self, index: u16, sub: u8) -> Option<i64> {
        let device = self.node.as_device();
        let at = canopen::Address::new(index, sub);
        let octets = device.node().read_with(at, device.application(), |octets| Ok(octets.to_vec())).ok()?;
        let mut all = if octets.last().is_some_and(|last| last & 0x80 != 0) { [0xFF; 8] } else { [0; 8] };
        all.get_mut(..octets.len())?.copy_from_slice(&octets);
        Some(i64::from_le_bytes(all))
    }

    pub(super) fn nmt(&mut self, command: u8) {
        self.send(&frame(0, &[command, NODE]));
    }

    pub(super) fn why(&self) -> Option<String> {
        self.node.why().map(|why| why.to_string())
    }

    /// The first fault that the device can be made to have.
    pub(super) fn provoke(&mut self) {
        let mut faults = Vec::new();
        self.node.as_device().description().each_fault(&mut |fault| faults.push(fault.name.to_string()));
        let now = self.now;
        self.node.act(now, |device, now| {
            device.act(now, &mut |device| {
                faults.first().into_iter().for_each(|fault| _ = device.provoke(now, fault));
            });
        });
        self.hear();
    }

    pub(super) fn make_nominal(&mut self) {
        let now = self.now;
        self.node.act(now, |device, now| device.act(now, &mut |device| device.make_nominal(now)));
        self.hear();
    }

    fn state(&self) -> Option<NmtState> {
        self.node.as_device().node().state()
    }

    fn word(&self) -> u16 {
        self.value(0x6040, 0).unwrap_or_default() as u16
    }

    fn status(&self) -> u16 {
        self.value(0x6041, 0).unwrap_or_default() as u16
    }
}

struct Walk {
    bus: Bus,
    random: Random,
    told: Told,
    silences: BTreeMap<String, String>,
}

/// Objects that masters write, how many octets they have, and values.
const WRITES: &[(u16, u8, usize, &[i64])] = &[
    (0x6040, 0, 2, &[0, 6, 7, 0xF, 0x1F, 0x3F, 0x0F, 0x1F, 0x80, 0x0B, 0x10F, 0x11F, 2]),
    (0x6060, 0, 1, &[0, 1, 3, 4, 6, 7, 8, 9, 2, 99]),
    (0x607A, 0, 4, &[0, 1000, -1000, 90_000, 2_000_000_000]),
    (0x60FF, 0, 4, &[0, 100, -100, 100_000]),
    (0x6071, 0, 2, &[0, 100, 2000]),
    (0x6098, 0, 1, &[0, 1, 17, 35, 77]),
    (0x1017, 0, 2, &[0, 200]),
    (0x1016, 1, 4, &[0, 0x0001_00C8]),
    (0x100C, 0, 2, &[0, 100]),
    (0x100D, 0, 1, &[0, 3]),
    (0x1400, 1, 4, &[0x205, 0x8000_0205, 0x8000_0000, 0x181]),
    (0x1400, 2, 1, &[255, 1, 0, 241]),
    (0x1600, 0, 1, &[0, 1, 2, 9]),
    (0x1800, 1, 4, &[0x185, 0x8000_0185, 0x4000_0185]),
    (0x1800, 2, 1, &[255, 1, 0, 253, 254]),
    (0x1A00, 0, 1, &[0, 1]),
    (0x6041, 0, 2, &[1]),
    (0x5FFF, 0, 1, &[1]),
    (0x6200, 1, 1, &[0, 0xFF]),
    (0x1010, 1, 4, &[0x6576_6173, 1]),
    (0x1005, 0, 4, &[0x80, 0x90]),
];

impl Walk {
    fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.random.below(of.len())]
    }

    fn judge(&mut self, what: &str, acted: bool) {
        let news = core::mem::take(&mut self.bus.news);
        let off = self.bus.state().is_none();
        if !self.told.covers(what, &news) && !acted && !off && !self.bus.once.contains(what) {
            self.note(what, "");
        }
    }

    fn note(&mut self, what: &str, rest: &str) {
        let from = self.bus.story.len().saturating_sub(12);
        let why = self.bus.why().map(|why| format!("  why: {why}"));
        let story = self.bus.story[from..].join("\n");
        self.silences
            .entry(format!("{}: {what}", self.bus.target.name))
            .or_insert_with(|| format!("{story}\n{}\n{rest}", why.unwrap_or_default()));
    }

    fn step(&mut self) {
        // What is told too often is counted: that is another test.
        self.bus.node.forget_told();
        match self.random.below(20) {
            0..=6 => self.write(),
            7 => self.odd_sdo(),
            8 => self.nmt(),
            9..=11 => self.rpdo(),
            12 => self.remote(),
            13 => self.other_frames(),
            14 => {
                let time = Duration::from_millis(*self.pick(&[10, 300, 3000]));
                self.bus.wait(time);
                self.bus.news.clear();
            }
            15 => self.outside(),
            _ => {
                self.bus.nmt(1);
                for word in [0, 0x80, 6, 7, 0xF] {
                    if self.bus.target.drive {
                        self.bus.write(0x6040, 0, word, 2);
                    }
                }
                self.bus.news.clear();
            }
        }
        self.names_a_reason();
    }

    fn write(&mut self) {
        let (index, sub, octets, values) = *self.pick(WRITES);
        let value = *self.pick(values);
        let octets = if self.random.below(12) == 0 { 1 + self.random.below(4) } else { octets };
        let (word, status, mode) = (self.bus.word(), self.bus.status(), self.bus.value(0x6060, 0));
        let place = self.bus.value(0x6064, 0);
        let reply = self.bus.write(index, sub, value, octets);
        let positive = reply.is_some_and(|reply| reply[0] == 0x60);
        if index == 0x6040 && positive && self.bus.target.drive {
            self.bus.wait(HELD);
            return self.commanded(word, status, mode, place);
        }
        let what = if self.bus.state() == Some(NmtState::Stopped) {
            "SDO request ignored".to_owned()
        } else {
            "SDO request for".to_owned()
        };
        self.judge(&what, positive);
    }

    /// A control word came: did it get what it asks for?
    fn commanded(&mut self, before: u16, was: u16, mode: Option<i64>, place: Option<i64>) {
        let (word, status) = (self.bus.word(), self.bus.status());
        let level = |status: u16| match status & 0x6F {
            0x21 => 1,
            0x23 => 2,
            0x27 => 3,
            _ => 0,
        };
        let wanted = match word & 0x8F {
            _ if word & 0x80 != 0 => 0,
            word if word & 0xF == 0xF => 3,
            word if word & 0x7 == 7 => 2,
            word if word & 0x7 == 6 => 1,
            _ => 0,
        };
        let news = core::mem::take(&mut self.bus.news);
        let moved = self.bus.value(0x6064, 0) != place;
        let starts = word & !before & 0x10 != 0 && status & 0x6F == 0x27;
        let mut wants = vec![
            (format!("6040h for level {wanted}"), word != before, level(status) >= wanted),
            ("fault reset".to_owned(), word & !before & 0x80 != 0 && was & 0x4F == 8, status & 8 == 0),
        ];
        match mode {
            Some(1) => wants.push(("set-point".to_owned(), starts, status & 0x1000 != 0 || moved)),
            Some(6) => wants.push(("homing start".to_owned(), starts, moved || status & 0x1000 != 0)),
            _ => {}
        }
        for (what, asked, met) in wants {
            let what = format!("{what}, mode {mode:?}, status {:02X}", was & 0x6F);
            let once = self.bus.once.contains("has no effect in");
            if asked && !met && !self.told.covers(&what, &news) && !once {
                self.note(&what, "");
            }
        }
    }

    fn odd_sdo(&mut self) {
        const REQUESTS: &[&[u8]] = &[
            &[0x40, 0x00, 0x10, 0],
            &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0],
            &[0x40, 0xFE, 0x5F, 1, 0, 0, 0, 0],
            &[0x60, 0, 0, 0, 0, 0, 0, 0],
            &[0x70, 0, 0, 0, 0, 0, 0, 0],
            &[0x00, 1, 2, 3, 4, 5, 6, 7],
            &[0xE0, 0, 0, 0, 0, 0, 0, 0],
            &[0x21, 0x08, 0x10, 0, 4, 0, 0, 0],
            &[0xC6, 0x08, 0x10, 0, 4, 0, 0, 0],
            &[0xA4, 0x08, 0x10, 0, 0x7F, 0, 0, 0],
            &[0x40, 0x18, 0x10, 9, 0, 0, 0, 0],
        ];
        let octets = *self.pick(REQUESTS);
        let reply = self.bus.sdo(octets);
        let ok = reply.is_some_and(|reply| reply[0] != 0x80);
        let stopped = self.bus.state() == Some(NmtState::Stopped);
        let what = match octets.len() {
            _ if stopped => "SDO request ignored".to_owned(),
            8 if reply.is_some() => "SDO request for".to_owned(),
            8 => format!("SDO {:02X} {:02X}{:02X}", octets[0], octets[2], octets[1]),
            _ => "SDO request of".to_owned(),
        };
        // An abort ends what there is, and is not answered.
        let aborts = octets[0] == 0x80;
        self.judge(&what, ok || aborts);
    }

    fn nmt(&mut self) {
        let (command, node) =
            (*self.pick(&[1, 1, 1, 2, 0x80, 0x81, 0x82, 7, 0]), *self.pick(&[0, NODE, NODE, 9]));
        let before = self.bus.state();
        let short = self.random.below(8) == 0;
        let replies = self.bus.send(&frame(0, [command, node].get(..2 - usize::from(short)).unwrap()));
        let same = matches!(
            (command, before),
            (1, Some(NmtState::Operational))
                | (2, Some(NmtState::Stopped))
                | (0x80, Some(NmtState::PreOperational))
        );
        let acted = self.bus.state() != before || !replies.is_empty() || same && !short;
        let what = if short {
            "NMT command of".to_owned()
        } else {
            if node == 9 { "node 9 is".to_owned() } else { "NMT command".to_owned() }
        };
        self.judge(&what, acted);
    }

    fn rpdo(&mut self) {
        let pdo = self.random.below(4);
        let id = 0x205 + 0x100 * u32::try_from(pdo).unwrap();
        let words: [u16; 8] = [0, 6, 7, 0xF, 0x1F, 0x3F, 0x0F, 0x80];
        let word = words[self.random.below(words.len())].to_le_bytes();
        let value = i32::try_from(self.random.below(3000)).unwrap().to_le_bytes();
        let octets = [word[0], word[1], value[0], value[1], value[2], value[3], 0, 0];
        let len = *self.pick(&[8, 8, 8, 6, 2, 1, 0]);
        let is_on = self.bus.node.as_device().node().takes_rpdo(frame(id, &[]).id());
        let (word, status, mode) = (self.bus.word(), self.bus.status(), self.bus.value(0x6060, 0));
        let place = self.bus.value(0x6064, 0);
        self.bus.send(&frame(id, &octets[..len]));
        self.bus.wait(HELD);
        let waits =
            self.bus.value(0x1400 + u16::try_from(pdo).unwrap(), 2).is_some_and(|kind| (kind & 0xFF) <= 240);
        if is_on && waits && self.bus.state() == Some(NmtState::Operational) {
            // No SYNC: told when it goes on.
            for _ in 0..12 {
                self.bus.send(&frame(id, &octets[..len]));
            }
        }
        let operational = self.bus.state() == Some(NmtState::Operational);
        if is_on && operational && !waits && self.bus.word() != word && self.bus.target.drive {
            return self.commanded(word, status, mode, place);
        }
        let acted = is_on && operational && !waits && self.bus.news.is_empty();
        self.judge(&format!("RPDO{}", pdo + 1), acted);
    }

    fn remote(&mut self) {
        let id = *self.pick(&[0x185, 0x285, 0x385, 0x485, 0x705]);
        let remote = Frame::remote(Id::base(id).unwrap(), 8).unwrap();
        // TPDOs are sent in OPERATIONAL.
        let rests = id != 0x705 && self.bus.state() != Some(NmtState::Operational);
        let replies = self.bus.send(&remote);
        let answered = rests || replies.iter().any(|reply| reply.id() == remote.id());
        self.judge(if id == 0x705 { "guarding" } else { "TPDO" }, answered);
    }

    fn other_frames(&mut self) {
        match self.random.below(4) {
            0 => {
                let wide = Id::extended(0x605).unwrap();
                self.bus.send(&Frame::data(wide, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).unwrap());
                self.judge("29 bits", false);
            }
            1 => {
                self.bus.send(&frame(0x609, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]));
                self.judge("node 9 is", false);
            }
            2 => {
                for _ in 0..5 {
                    self.bus.send(&frame(0x80, &[]));
                }
                self.bus.news.clear();
            }
            _ => {
                self.bus.send(&frame(0x701, &[5]));
                self.bus.news.clear();
            }
        }
    }

    fn outside(&mut self) {
        let mut faults = Vec::new();
        self.bus.node.as_device().description().each_fault(&mut |fault| faults.push(fault.name.to_string()));
        let which = self.random.below(5);
        let fault = if faults.is_empty() { String::new() } else { self.pick(&faults).clone() };
        self.bus.story.push(format!("  outside: {which} {fault}"));
        let now = self.bus.now;
        self.bus.node.act(now, |device, now| match which {
            0 => device.power_off(now),
            1 => device.power_on(now),
            2 => device.act(now, &mut |device| _ = device.provoke(now, &fault)),
            _ => device.act(now, &mut |device| device.make_nominal(now)),
        });
        self.bus.wait(HELD);
        self.bus.news.clear();
    }

    /// A drive that stands has a reason, or waits for something.
    fn names_a_reason(&mut self) {
        if !self.bus.target.drive {
            return;
        }
        let Some(why) = self.bus.node.why() else { return };
        let (moves, text) = (why.is_moving() == Some(true), why.to_string());
        let named = text.contains("does not move: ") || text.contains("it waits for ");
        if !moves && !named {
            self.note(&format!("why: {text}"), "");
        }
    }
}

#[test]
fn no_frame_of_a_wrong_master_is_without_effect_and_without_a_word() {
    let mut silences = BTreeMap::new();
    for target in TARGETS {
        for seed in 1..=walks() {
            let (bus, random, told) = (Bus::of(target), Random::new(seed), Told::default());
            let mut walk = Walk { bus, random, told, silences: core::mem::take(&mut silences) };
            (0..80).for_each(|_| walk.step());
            silences = walk.silences;
        }
    }
    expect_none(&silences);
}

#[test]
fn a_pdo_that_waits_for_sync_is_told_by_why_and_ends_with_its_advice() {
    for cure in ["send SYNC", "type 255"] {
        let mut bus = Bus::of(&TARGETS[0]);
        let transmission_type = |bus: &mut Bus, kind| {
            bus.write(0x1800, 1, 0x8000_0185, 4);
            bus.write(0x1800, 2, kind, 1);
            bus.write(0x1800, 1, 0x185, 4);
        };
        transmission_type(&mut bus, 1);
        assert!(bus.why().unwrap().contains("NMT state PRE-OPERATIONAL"));
        bus.nmt(1);
        bus.wait(Duration::from_secs(4));
        let why = bus.why().unwrap();
        assert!(why.contains("TPDO1 is not sent: it waits for SYNC"), "{why}");
        assert!(
            why.contains("send SYNC, or set the transmission type of the PDO to 255 (1800h:02)"),
            "{why}"
        );
        if cure == "send SYNC" {
            bus.send(&frame(0x80, &[]));
        } else {
            bus.nmt(0x80);
            transmission_type(&mut bus, 255);
            bus.nmt(1);
            bus.wait(Duration::from_secs(4));
        }
        let why = bus.why().unwrap();
        assert!(!why.contains("waits for SYNC") && !why.contains("NMT state"), "{why}");
    }
}
