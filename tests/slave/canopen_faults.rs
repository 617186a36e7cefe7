//! Faults on purpose (`canopen-link.md` 15): each spoils what it says and nothing else.

use std::time::Duration;

use profidrive::can::{Frame, Id};
use profidrive::canopen::faults::{BootUpFault, Faults, HeartbeatFault, SdoFault, Spoiler, TpdoFault};
use profidrive::canopen::{Abort, Address, Policy, Value};
use profidrive::time::Instant;

use crate::canopen_device::Plain;
use crate::canopen_device::rig::Rig;

struct Spoiled {
    rig: Rig,
    spoiler: Spoiler,
}

impl Spoiled {
    fn new(faults: Faults) -> Self {
        let mut spoiled = Self { rig: Rig::off(Policy::CIA_301, Plain::new(5)), spoiler: Spoiler::new() };
        spoiled.spoiler.set(spoiled.rig.now, faults);
        spoiled
    }

    fn power_on(&mut self) -> Vec<String> {
        self.rig.node.power_on(self.rig.now, &mut self.rig.device);
        self.drain()
    }

    fn on(faults: Faults) -> Self {
        let mut spoiled = Self::new(faults);
        spoiled.power_on();
        spoiled
    }

    fn data(&mut self, id: u16, octets: &[u8]) -> Vec<String> {
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.rig.node.handle_frame(self.rig.now, &frame, &mut self.rig.device);
        self.drain()
    }

    fn remote(&mut self, id: u16) -> Vec<String> {
        let frame = Frame::remote(Id::base(id).unwrap(), 1).unwrap();
        self.rig.node.handle_frame(self.rig.now, &frame, &mut self.rig.device);
        self.drain()
    }

    fn pass(&mut self, time: Duration) -> Vec<(u128, String)> {
        let begin = self.rig.now;
        let end = begin.saturating_add(time);
        let mut seen = Vec::new();
        while let Some(due) = Instant::first_of(self.rig.node.poll_timeout(), self.spoiler.poll_timeout())
            && due <= end
        {
            self.rig.now = self.rig.now.max(due);
            self.rig.node.handle_timeout(self.rig.now, &mut self.rig.device);
            let at = self.rig.now.saturating_since(begin).as_millis();
            seen.extend(self.drain().into_iter().map(|frame| (at, frame)));
        }
        self.rig.now = end;
        seen
    }

    fn drain(&mut self) -> Vec<String> {
        while let Some(frame) = self.rig.node.poll_transmit() {
            self.spoiler.handle_frame(self.rig.now, frame, &self.rig.node);
        }
        self.spoiler.handle_timeout(self.rig.now, &self.rig.node);
        std::iter::from_fn(|| self.spoiler.poll_transmit()).map(|frame| frame.to_string()).collect()
    }
}

const READ: [u8; 8] = [0x40, 0x01, 0x10, 0, 0, 0, 0, 0];
const ANSWER: &str = "585#4F 01 10 00 00 00 00 00";

#[test]
fn without_faults_everything_passes() {
    let mut node = Spoiled::new(Faults::NONE);
    assert_eq!(node.power_on(), ["705#00"]);
    assert_eq!(node.data(0x605, &READ), [ANSWER]);
    assert_eq!(node.remote(0x705), ["705#7F"]);
    assert_eq!(node.remote(0x705), ["705#FF"]);
}

#[test]
fn boot_up_missing_or_twice() {
    let mut node = Spoiled::new(Faults { boot_up: Some(BootUpFault::Missing), ..Faults::NONE });
    assert!(node.power_on().is_empty());
    let mut node = Spoiled::new(Faults { boot_up: Some(BootUpFault::Twice), ..Faults::NONE });
    assert_eq!(node.power_on(), ["705#00", "705#00"]);
}

#[test]
fn sdo_answers() {
    let with = |fault| Spoiled::on(Faults { sdo: Some(fault), ..Faults::NONE });
    let mut node = with(SdoFault::Late(Duration::from_millis(500)));
    assert!(node.data(0x605, &READ).is_empty());
    assert_eq!(node.pass(Duration::from_secs(1)), [(500, ANSWER.to_owned())]);
    let mut node = with(SdoFault::Lost);
    assert!(node.data(0x605, &READ).is_empty());
    assert!(node.pass(Duration::from_secs(1)).is_empty());
    assert_eq!(with(SdoFault::Twice).data(0x605, &READ), [ANSWER, ANSWER]);
    assert_eq!(with(SdoFault::OtherIndex).data(0x605, &READ), ["585#4F 00 10 00 00 00 00 00"]);
    assert_eq!(with(SdoFault::Abort(Abort::GENERAL)).data(0x605, &READ), ["585#80 01 10 00 00 00 00 08"]);
    let mut node = with(SdoFault::WrongToggle);
    assert_eq!(node.data(0x605, &READ), [ANSWER]);
    node.data(0x605, &[0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(node.data(0x605, &[0x60, 0, 0, 0, 0, 0, 0, 0]), ["585#10 48 65 6C 6C 6F 20 57"]);
}

#[test]
fn heartbeats() {
    let with = |fault| {
        let mut node = Spoiled::on(Faults { heartbeat: Some(fault), ..Faults::NONE });
        node.data(0x605, &[0x2B, 0x17, 0x10, 0, 100, 0, 0, 0]);
        node.pass(Duration::from_millis(450))
    };
    let times = |seen: Vec<(u128, String)>| seen.into_iter().map(|(at, _)| at).collect::<Vec<_>>();
    assert_eq!(times(with(HeartbeatFault::Jitter(Duration::from_millis(30)))), [100, 230, 300, 430]);
    assert!(with(HeartbeatFault::Lost).is_empty());
    let seen = with(HeartbeatFault::Stuck(0x05));
    assert!(seen.len() == 4 && seen.iter().all(|(_, frame)| frame == "705#05"));
}

#[test]
fn the_toggle_bit_of_guarding() {
    let mut node = Spoiled::on(Faults { guarding_toggle_stuck: true, ..Faults::NONE });
    for _ in 0..3 {
        assert_eq!(node.remote(0x705), ["705#7F"]);
    }
}

#[test]
fn tpdos() {
    for (fault, expected) in [(TpdoFault::Short, "185#07"), (TpdoFault::Stale, "185#00 00")] {
        let mut node = Spoiled::on(Faults { tpdo: Some(fault), ..Faults::NONE });
        node.data(0x000, &[0x01, 5]);
        node.rig.device.set(Address::new(0x6000, 1), Value::U8(7));
        node.rig.node.handle_change(node.rig.now, &mut node.rig.device);
        assert_eq!(node.drain(), [expected]);
    }
}

#[test]
fn an_emcy_storm() {
    let period = Duration::from_millis(10);
    let mut node = Spoiled::on(Faults { emcy_storm: Some(period), ..Faults::NONE });
    let seen = node.pass(Duration::from_millis(100));
    assert_eq!(seen.len(), 10);
    assert!(seen.iter().all(|(_, frame)| frame == "085#00 FF 81 00 00 00 00 00"));
}
