//! Masters of both classes beside Data_Exchange, at random: telegrams and replies are lost and repeated, connections aborted,
//! masters silent, the power off, at every point; and every reply is one that the reference allows.

mod connections;
mod model;
mod server;

use std::collections::{BTreeMap, HashMap};
use std::time::Duration;

use connections::Phase;
use model::Model;
use profidrive::profibus::dp::State;
use profidrive::profibus::dpv1::{AlarmState, AlarmType, Ms2Offer, Offer, Specifier, StatusType};
use profidrive::profibus::fdl::{FrameCount, Service};
use server::Contents;

use crate::dpv1_line::{CFG, FULL, OTHER, OWNER, Record, Request, V1Line, global_control};
use crate::long::long;
use crate::slave_line::{Answer, answer};

/// Masters that may own the slave, and masters of class 2. One is both.
const OWNERS: [u8; 2] = [OWNER, 4];
const CLASS_2: [u8; 4] = [OTHER, 9, 17, OWNER];

/// Set_Prm: type mode; sequence mode with two alarms of two types; with eight, no watchdog; without DP-V1.
const PRMS: [[u8; 10]; 4] = [
    [0x88, 3, 10, 11, 0xC0, 0xDE, 0, 0x80, 0xFC, 0x00],
    [0x88, 3, 10, 11, 0xC0, 0xDE, 0, 0x80, 0x60, 0x01],
    [0x80, 1, 1, 11, 0xC0, 0xDE, 0, 0x80, 0xFC, 0x04],
    [0x88, 3, 10, 11, 0xC0, 0xDE, 0, 0x00, 0x00, 0x00],
];

const INITIATE: [u8; 20] = [0x57, 0, 0, 0, 0, 20, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];

/// The same numbers for the same seed (xorshift).
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as usize % limit
    }

    fn one_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    fn octets(&mut self, len: usize) -> Vec<u8> {
        (0..len).map(|_| self.below(256) as u8).collect()
    }
}

struct Walk {
    dice: Dice,
    offer: Offer,
    line: V1Line,
    model: Model,
    counts: HashMap<u8, FrameCount>,
    /// How often each thing happened.
    seen: BTreeMap<String, usize>,
    /// What happened last.
    story: Vec<String>,
}

impl Walk {
    fn new(seed: u64) -> Self {
        let (ms1, max_data) = if seed.is_multiple_of(3) { (32, 100) } else { (240, 240) };
        let ms2 = Ms2Offer { max_data, ..FULL.ms2.unwrap() };
        let offer = Offer { ms1: Some(ms1), ms2: Some(ms2), ..FULL };
        let mut line = V1Line::new(offer);
        let record = |len: u8| Record { data: (0..len).collect(), ..Record::default() };
        let slow = |milliseconds: u64| Duration::from_millis(milliseconds);
        line.put(1, 11, Record { read_only: true, ..record(2) });
        line.put(1, 12, Record { write_only: true, ..record(3) });
        line.put(1, 13, Record { delay: slow(15), ..record(4) });
        line.put(2, 14, Record { delay: slow(250), ..record(4) });
        line.put(2, 240, record(240));
        let model = Model::new(offer, Contents::new(&line.records.records));
        let dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        Self { dice, offer, line, model, counts: HashMap::new(), seen: BTreeMap::new(), story: Vec::new() }
    }

    fn note(&mut self, what: impl Into<String>) {
        *self.seen.entry(what.into()).or_default() += 1;
    }

    fn step(&mut self) {
        let dice = &mut self.dice;
        match (self.model.state, self.model.owner) {
            (State::WaitPrm, _) if dice.one_in(3) => {
                let (master, prm) = (dice.of(&OWNERS), dice.of(&PRMS));
                return self.dp(master, 61, &prm);
            }
            (State::WaitCfg, Some(owner)) if dice.one_in(2) => return self.dp(owner, 62, &CFG),
            (State::WaitPrm | State::WaitCfg | State::DataExch, _) => {}
        }
        let owner = self.model.owner.filter(|_| !dice.one_in(8)).unwrap_or_else(|| dice.of(&OWNERS));
        match dice.below(44) {
            0..8 => {
                let outputs = if dice.one_in(40) { 3 } else { 2 };
                let outputs = dice.octets(outputs);
                self.send(owner, None, &outputs);
            }
            8..12 => self.dp(owner, 60, &[]),
            12 => self.dp(OTHER, 60, &[]),
            13 => {
                let command = dice.of(&[0, 2]);
                assert_eq!(self.line.send(&global_control(owner, command)), None);
                self.model.hear_control(self.line.heard);
            }
            14 => self.start_up(owner),
            15..18 => self.send(owner, Some((51, 51)), &[]),
            18..22 => {
                let pdu = self.pdu();
                self.send(owner, Some((51, 51)), &pdu);
            }
            22 => self.send(owner, Some((50, 51)), &[]),
            23..26 => self.acknowledge(owner),
            26..29 => self.manager(),
            29..37 => self.connection(),
            37..40 => self.alarm(),
            40 => self.record_changes(),
            41..43 => self.wait(),
            43 if dice.one_in(6) => self.power_cycle(),
            _ => self.dp(owner, 60, &[]),
        }
    }

    /// Set_Prm and Chk_Cfg, right and wrong, of this master.
    fn start_up(&mut self, master: u8) {
        let dice = &mut self.dice;
        let mut prm = dice.of(&PRMS).to_vec();
        match dice.below(10) {
            0 => prm[0] = 0x40,
            1 => prm[0] = 0,
            2 => prm[5] = 0xDF,
            3 => prm.truncate(dice.of(&[6, 7, 9])),
            4 => return self.dp(master, 62, &[0x30]),
            5 => return self.dp(master, 62, &CFG),
            _ => {}
        }
        self.dp(master, 61, &prm);
    }

    /// A request at SAP 51 or of a connection.
    fn pdu(&mut self) -> Vec<u8> {
        let dice = &mut self.dice;
        let (slot, index) =
            dice.of(&[(1, 10), (1, 10), (1, 11), (1, 12), (1, 13), (2, 14), (2, 240), (1, 99), (9, 10)]);
        let whole = self.model.contents.records.get(&(slot, index)).map_or(4, |record| record.data.len());
        match dice.below(16) {
            0..5 => vec![0x5E, slot, index, dice.of(&[1, 2, 4, 32, 240])],
            5..8 => [&[0x5F, slot, index, whole as u8][..], &dice.octets(whole)].concat(),
            8 => vec![0x5F, 1, 10, 3, 1, 2, 3],
            9 => dice.of(&[&[0x5E, 1, 10, 0][..], &[0x5F, 1, 10, 0], &[0x5E, 255, 10, 4]]).to_vec(),
            10 => dice.of(&[&[0x5E, 1][..], &[0x5E, 1, 10, 4, 0], &[0x5F, 1, 10, 4, 1], &[0x5F]]).to_vec(),
            11 => vec![dice.of(&[0x01, 0x44, 0x59, 0x60, 0xDE, 0xFF]), 1, 10, 4],
            12 | 13 => vec![0x5E, 0, 255, dice.of(&[4, 68, 240])],
            14 => vec![0x5F, dice.of(&[0, 0, 0, 1]), 255, 4, 8, 0, 0xFD, 0xE8 + dice.below(4) as u8],
            _ => {
                let (number, len) = (0xE8 + dice.below(4) as u8, dice.of(&[63, 64, 64]));
                [&[0x5F, 0, 255, 4 + len as u8, 8, 0, 0xFD, number][..], &dice.octets(len)].concat()
            }
        }
    }

    /// Alarm_Ack at SAP 51 or 50: of an alarm, of one that was not read, of none.
    fn acknowledge(&mut self, owner: u8) {
        let dice = &mut self.dice;
        let known = self.model.alarms.len();
        let head = if known == 0 { [2, 1, 1] } else { self.model.alarms[dice.below(known)].head };
        let [kind, mut slot, mut specifier] = head;
        match dice.below(8) {
            0 => slot ^= 1,
            1 => specifier ^= 0x08,
            // Add_Ack and the specifier are not compared.
            2 => specifier ^= 0x07,
            _ => {}
        }
        let sap = dice.of(&[50, 51]);
        self.send(owner, Some((sap, 51)), &[0x5C, slot, kind, specifier]);
    }

    /// Initiate, or a poll, at SAP 49.
    fn manager(&mut self) {
        let dice = &mut self.dice;
        let mut initiate = INITIATE.to_vec();
        initiate[5] = dice.of(&[10, 20, 100]);
        match dice.below(24) {
            0 => initiate[5] = 9,
            1 => initiate[6] = 0,
            2 => initiate[12] = 1,
            3 => initiate[18] = 1,
            4 => initiate.truncate(19),
            5 => initiate = vec![0x5E, 1, 10, 4],
            6 => initiate[10..12].copy_from_slice(&[0x3A, 0]),
            7 if self.model.connections.list.iter().any(|link| link.phase == Phase::Free) => {
                initiate.resize(53, 0);
            }
            _ => {}
        }
        let offered = self.model.connections.list.iter().find(|link| link.phase == Phase::Offered);
        let master = offered.map(|link| link.master).filter(|_| !dice.one_in(4));
        let master = master.unwrap_or_else(|| dice.of(&CLASS_2));
        let data = if offered.is_some() && !dice.one_in(4) { Vec::new() } else { initiate };
        self.send(master, Some((49, 50)), &data);
    }

    /// Something at the SAP of a connection.
    fn connection(&mut self) {
        let dice = &mut self.dice;
        let at = dice.below(self.model.connections.list.len() + 1);
        let known = self.model.connections.list.get(at);
        let owner = known.map(|link| link.master).filter(|_| !dice.one_in(10));
        let master = owner.unwrap_or_else(|| dice.of(&CLASS_2));
        let ssap = if dice.one_in(20) { 51 } else { 50 };
        let phase = known.map_or(Phase::Free, |link| link.phase);
        let data = match self.dice.below(12) {
            0..5 => Vec::new(),
            5 => vec![0x48],
            6 => {
                if Some(master) == known.map(|link| link.master) && ssap == 50 {
                    let busy = known.is_some_and(|link| link.server.is_busy());
                    self.note(format!("Abort while {phase:?}, busy {busy}"));
                }
                self.dice.of(&[&[0x58, 0, 0x20][..], &[0x58, 1, 0x13, 0]]).to_vec()
            }
            7 => self.dice.of(&[&[0x51, 1, 10, 1, 5][..], &[0x5C, 1, 2, 1], &INITIATE]).to_vec(),
            _ => self.pdu(),
        };
        self.send(master, Some((48 - at as u8, ssap)), &data);
    }

    /// The application raises an alarm, or sends a status message.
    fn alarm(&mut self) {
        self.pause(Duration::from_millis(1));
        let dice = &mut self.dice;
        let (slot, data) = (dice.below(3) as u8, dice.octets(2));
        let (_, specifier) = dice.of(&Specifier::NAMED);
        let Self { line, model, .. } = self;
        if dice.one_in(4) {
            let block = [&[0x81, slot, specifier as u8], &data[..]].concat();
            let V1Line { acyclic, station, .. } = line;
            let sent = acyclic.send_status(station, StatusType::Message, slot, specifier, &data);
            assert_eq!(model.send_status(block), sent.is_ok(), "{sent:?}");
            return;
        }
        let kind = dice.of(&[1, 2, 2, 3, 4, 5, 6, 32]);
        let additional = dice.one_in(4);
        let V1Line { acyclic, station, .. } = line;
        let alarm = (slot, specifier, additional);
        let raised = acyclic.raise(station, AlarmType::numbered(kind), alarm, &data);
        assert_eq!(model.may_raise(kind), raised.is_ok(), "{raised:?}");
        match raised {
            Ok(head) => {
                let octet = head.sequence << 3 | u8::from(additional) << 2 | specifier as u8;
                model.raised([kind, slot, octet], &data);
                self.note("alarm raised");
            }
            Err(_) => self.note("alarm not raised"),
        }
    }

    /// The device changes a record by itself.
    fn record_changes(&mut self) {
        let data = self.dice.octets(4);
        for records in [&mut self.line.records.records, &mut self.model.contents.records] {
            records.get_mut(&(1, 10)).unwrap().data.clone_from(&data);
        }
    }

    fn wait(&mut self) {
        let dice = &mut self.dice;
        let milliseconds = match dice.below(10) {
            0..6 => dice.below(30),
            6..9 => dice.below(320),
            _ => dice.below(3500),
        };
        self.pause(Duration::from_millis(milliseconds as u64));
    }

    /// Nobody speaks for so long.
    fn pause(&mut self, time: Duration) {
        self.line.wait(time);
        let busy = self.model.ms1.is_busy();
        if self.model.pass(self.line.now) {
            self.note(format!("watchdog, MS1 busy {busy}"));
        }
    }

    fn power_cycle(&mut self) {
        let busy = self.model.ms1.is_busy();
        let alarms = !self.model.alarms.is_empty();
        let links = self.model.connections.open().len();
        self.note(format!("power off, MS1 busy {busy}, alarms {alarms}, connections {links}"));
        let mut line = V1Line::new(self.offer);
        line.now = self.line.now;
        core::mem::swap(&mut line.records, &mut self.line.records);
        self.line = line;
        self.model.power_cycle();
    }

    fn dp(&mut self, master: u8, sap: u8, data: &[u8]) {
        self.send(master, Some((sap, 62)), data);
    }

    /// A telegram of a master, as often as it takes: it is lost before the slave, or its reply behind it, or for good.
    fn send(&mut self, sa: u8, saps: Option<(u8, u8)>, data: &[u8]) {
        let count = match self.counts.get(&sa) {
            None => FrameCount::First,
            Some(FrameCount::First | FrameCount::Odd | FrameCount::Unused) => FrameCount::Even,
            Some(FrameCount::Even) => FrameCount::Odd,
        };
        self.counts.insert(sa, count);
        let service = self.dice.of(&[Service::SrdLow, Service::SrdHigh]);
        let request = Request { sa, saps, service, count, data: data.to_vec() };
        let (repeats, answered) = match self.dice.below(16) {
            0 => (1, true),
            1 => (2, true),
            2 => (0, false),
            3 => (3, false),
            _ => (0, true),
        };
        // Nobody repeats the first telegram.
        let repeats = if count == FrameCount::First { 0 } else { repeats };
        if !answered {
            // The master gives up, and begins to count anew.
            self.counts.remove(&sa);
            self.note(if repeats == 0 { "lost before the slave" } else { "every reply lost" });
            if repeats == 0 {
                return;
            }
        }
        let got = self.exchange(&request);
        for _ in 0..repeats {
            assert_eq!(self.exchange(&request), got, "{request:02X?} again\n{}", self.told());
            self.note("repeated");
        }
        let sap = saps.map_or(0, |(dsap, _)| dsap);
        let kind = match &got {
            Answer::Low(octets) | Answer::High(octets) => format!("{:02X}", octets[0]),
            got => format!("{got:?}"),
        };
        if (49..=51).contains(&sap) || saps.is_some_and(|(dsap, _)| dsap < 49) {
            self.note(format!("SAP {} {kind}", sap.clamp(48, 51)));
        }
    }

    fn exchange(&mut self, request: &Request) -> Answer {
        let octets = self.line.send(&request.octets());
        let got = answer(octets);
        let expected = self.model.hear(self.line.heard, request);
        self.story.push(format!("{:?} {request:02X?} {got:02X?}", self.line.heard));
        assert!(expected.contains(&got), "expected {expected:02X?}, got {got:02X?}\n{}", self.told());
        got
    }

    fn told(&self) -> String {
        self.story[self.story.len().saturating_sub(25)..].join("\n")
    }

    /// What is shown of the slave is what the model has.
    fn compare(&self) {
        let Self { line: V1Line { station, acyclic, records, .. }, model, .. } = self;
        let slave = station.slave();
        let owner = slave.owner().map(|owner| owner.number());
        assert_eq!((slave.state(), owner), (model.state, model.owner), "{}", self.told());
        assert_eq!(acyclic.is_open(), model.is_open(), "{}", self.told());
        assert_eq!(acyclic.is_busy(), model.ms1.is_busy(), "{}", self.told());
        let links: Vec<_> = acyclic.links().map(|link| (link.sap, link.master.number())).collect();
        assert_eq!(links, model.connections.open(), "{}", self.told());
        let alarms = acyclic.alarms().iter().zip(&model.alarms);
        assert_eq!(acyclic.alarms().len(), model.alarms.len(), "{}", self.told());
        for (alarm, raised) in alarms {
            assert_eq!(alarm.head.sequence, raised.head[2] >> 3);
            assert_eq!(alarm.state == AlarmState::Delivered, raised.delivered, "{}", self.told());
        }
        assert_eq!(records.runs, model.contents.runs, "{}", self.told());
        for (place, record) in &model.contents.records {
            assert_eq!(records.records[place].data, record.data, "{place:?}\n{}", self.told());
        }
    }
}

/// Of these, each happens in every run.
const WANTED: &[&str] = &[
    "repeated",
    "every reply lost",
    "lost before the slave",
    "alarm raised",
    "alarm not raised",
    "watchdog, MS1 busy true",
    "watchdog, MS1 busy false",
    "power off, MS1 busy true, alarms true",
    "Abort while Answering, busy false",
    "Abort while Open, busy true",
    "Abort while Open, busy false",
    "SAP 48 57",
    "SAP 48 58",
    "SAP 48 48",
    "SAP 48 5E",
    "SAP 48 5F",
    "SAP 48 DE",
    "SAP 48 DF",
    "SAP 49 56",
    "SAP 50 5C",
    "SAP 50 DC",
    "SAP 51 5C",
    "SAP 51 DC",
    "SAP 51 5E",
    "SAP 51 5F",
    "SAP 51 DE",
    "SAP 51 DF",
];

/// Forty walks of 2500 steps, with `PROFIDRIVE_LONG` two thousand; `SEED` walks one.
#[test]
fn masters_of_both_classes_find_what_the_reference_says_whatever_is_lost() {
    let only = std::env::var("SEED").ok().and_then(|seed| seed.parse().ok());
    let seeds = only.map_or(1..=if long() { 2000 } else { 40 }, |seed| seed..=seed);
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for seed in seeds {
        let mut walk = Walk::new(seed);
        println!("SEED={seed}");
        for _ in 0..2500 {
            walk.step();
            walk.compare();
        }
        for (what, times) in walk.seen {
            *seen.entry(what).or_default() += times;
        }
    }
    println!("{seen:#?}");
    let happened = |wanted: &&&str| seen.keys().any(|what| what.starts_with(**wanted));
    let missing: Vec<_> = WANTED.iter().filter(|wanted| !happened(wanted)).collect();
    assert!(only.is_some() || missing.is_empty(), "{missing:?}");
}
