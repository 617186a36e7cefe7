//! Faults on purpose (`canopen-link.md` 15): each changes what it says and nothing else.

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::faults::{
    Action, BootUpFault, FaultInjector, HeartbeatFault, Kind, MAX_FAULTS, SdoFault, TooMany, TpdoFault, When,
};
use profidrive::can_bus::canopen::{Abort, Address, Policy, Value};
use profidrive::time::Instant;

use crate::canopen_device::Plain;
use crate::canopen_device::rig::Rig;

struct Faulty {
    rig: Rig,
    injector: FaultInjector,
}

impl Faulty {
    fn new(faults: &[(Kind, When)]) -> Self {
        let mut faulty =
            Self { rig: Rig::off(Policy::CIA_301, Plain::new(5)), injector: FaultInjector::new() };
        for (number, (kind, when)) in (1..).zip(faults) {
            faulty.injector.add(faulty.rig.now, number, *kind, *when).unwrap();
        }
        faulty
    }

    fn power_on(&mut self) -> Vec<String> {
        self.rig.node.power_on(self.rig.now, &mut self.rig.device);
        self.drain()
    }

    fn on(kind: Kind) -> Self {
        Self::with(kind, When::ALWAYS)
    }

    fn with(kind: Kind, when: When) -> Self {
        let mut faulty = Self::new(&[(kind, when)]);
        faulty.power_on();
        faulty
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
        while let Some(due) = Instant::first_of(self.rig.node.poll_timeout(), self.injector.poll_timeout())
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
            self.injector.handle_frame(self.rig.now, frame, &self.rig.node);
        }
        self.injector.handle_timeout(self.rig.now, &self.rig.node);
        std::iter::from_fn(|| self.injector.poll_transmit()).map(|frame| frame.to_string()).collect()
    }
}

const READ: [u8; 8] = [0x40, 0x01, 0x10, 0, 0, 0, 0, 0];
const ANSWER: &str = "585#4F 01 10 00 00 00 00 00";

#[test]
fn without_faults_everything_passes() {
    let mut node = Faulty::new(&[]);
    assert_eq!(node.power_on(), ["705#00"]);
    assert_eq!(node.data(0x605, &READ), [ANSWER]);
    assert_eq!(node.remote(0x705), ["705#7F"]);
    assert_eq!(node.remote(0x705), ["705#FF"]);
}

#[test]
fn boot_up_missing_or_twice() {
    let mut node = Faulty::new(&[(Kind::BootUp(BootUpFault::Missing), When::ALWAYS)]);
    assert!(node.power_on().is_empty());
    let mut node = Faulty::new(&[(Kind::BootUp(BootUpFault::Twice), When::ALWAYS)]);
    assert_eq!(node.power_on(), ["705#00", "705#00"]);
}

#[test]
fn sdo_answers() {
    let with = |fault| Faulty::on(Kind::Sdo(fault));
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
        let mut node = Faulty::on(Kind::Heartbeat(fault));
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
    let mut node = Faulty::on(Kind::GuardingToggleStuck);
    for _ in 0..3 {
        assert_eq!(node.remote(0x705), ["705#7F"]);
    }
}

#[test]
fn tpdos() {
    for (fault, expected) in [(TpdoFault::Short, "185#07"), (TpdoFault::Stale, "185#00 00")] {
        let mut node = Faulty::on(Kind::Tpdo(fault));
        node.data(0x000, &[0x01, 5]);
        node.rig.device.set(Address::new(0x6000, 1), Value::U8(7));
        node.rig.node.handle_change(node.rig.now, &mut node.rig.device);
        assert_eq!(node.drain(), [expected]);
    }
}

#[test]
fn an_emcy_in_each_period() {
    let period = Duration::from_millis(10);
    let mut node = Faulty::on(Kind::EmcyEach(period));
    let seen = node.pass(Duration::from_millis(100));
    assert_eq!(seen.len(), 10);
    assert!(seen.iter().all(|(_, frame)| frame == "085#00 FF 81 00 00 00 00 00"));
}

#[test]
fn occasions_are_counted_and_the_first_fault_of_a_frame_acts() {
    let lost = Kind::Sdo(SdoFault::Lost);
    let mut node = Faulty::with(lost, When::once(3));
    let answers: Vec<_> = (0..5).map(|_| node.data(0x605, &READ).len()).collect();
    assert_eq!((answers, node.injector.injected(1)), (vec![1, 1, 0, 1, 1], 1));

    let mut node = Faulty::with(lost, When { at: 2, count: Some(2), ..When::ALWAYS });
    let answers: Vec<_> = (0..5).map(|_| node.data(0x605, &READ).len()).collect();
    assert_eq!(answers, [1, 0, 0, 1, 1]);

    let by_chance = |seed| {
        let mut node = Faulty::with(lost, When { rate: 0.5, seed, ..When::ALWAYS });
        (0..64).map(|_| node.data(0x605, &READ).len()).collect::<Vec<_>>()
    };
    assert_eq!(by_chance(7), by_chance(7));
    assert_ne!(by_chance(7), by_chance(8));
    let lost_of_64 = by_chance(7).iter().filter(|answers| **answers == 0).count();
    assert!((16..=48).contains(&lost_of_64), "{lost_of_64}");

    let mut node = Faulty::new(&[(lost, When::once(1)), (Kind::Sdo(SdoFault::Twice), When::ALWAYS)]);
    node.power_on();
    assert!(node.data(0x605, &READ).is_empty());
    assert_eq!(node.data(0x605, &READ).len(), 2, "the next in the list");
    node.injector.remove(2);
    assert_eq!((node.data(0x605, &READ).len(), node.injector.injected(2)), (1, 0));
}

#[test]
fn a_node_has_so_many_faults_and_no_more() {
    let mut node = Faulty::new(&[(Kind::GuardingToggleStuck, When::ALWAYS); MAX_FAULTS]);
    let more = node.injector.add(node.rig.now, 99, Kind::GuardingToggleStuck, When::ALWAYS);
    assert_eq!(more, Err(TooMany));
}

#[test]
fn two_tpdos_change_places() {
    let mut node = Faulty::with(Kind::Tpdo(TpdoFault::Swapped), When::once(1));
    assert_eq!(node.data(0x000, &[0x01, 5]), ["285#00 00 00 00 00 00 00 00", "185#00 00"]);
    node.rig.device.set(Address::new(0x6000, 1), Value::U8(7));
    node.rig.node.handle_change(node.rig.now, &mut node.rig.device);
    assert_eq!(node.drain(), ["185#07 00"]);
}

#[test]
fn what_the_host_is_asked_to_do() {
    let mut node = Faulty::with(Kind::LeaveOperational, When::once(1));
    assert_eq!(node.data(0x000, &[0x01, 5]).len(), 2);
    assert_eq!(node.injector.poll_action(node.rig.now), Some(Action::LeaveOperational));
    assert_eq!(node.injector.poll_action(node.rig.now), None);

    let mut node = Faulty::with(Kind::BrownOut(Duration::from_millis(30)), When::once(2));
    assert!(node.data(0x605, &READ).is_empty());
    let now = node.rig.now;
    assert_eq!(node.injector.poll_action(now), Some(Action::Off));
    assert_eq!(node.injector.poll_timeout(), Some(now.saturating_add(Duration::from_millis(30))));
    assert_eq!(node.injector.poll_action(now.saturating_add(Duration::from_millis(29))), None);
    assert_eq!(node.injector.poll_action(now.saturating_add(Duration::from_millis(30))), Some(Action::On));
    assert_eq!(node.data(0x605, &READ), [ANSWER]);
}
