//! Error control and emergencies (`canopen-link.md` 4 and 7; page `docs/canopen-conformance.md`).

use std::time::Duration;

use profidrive::can_bus::canopen::emcy::Emergency;
use profidrive::can_bus::canopen::nmt::NmtState::{Operational, PreOperational, Stopped};
use profidrive::can_bus::canopen::policy::ErrorControlRule;
use profidrive::can_bus::canopen::{Abort, Event, NodeId, Notice, Policy, Request};

use crate::canopen_device::rig::Rig;

fn raise(rig: &mut Rig, emergency: Emergency) -> Vec<String> {
    rig.device.requests.push_back(Request::Emergency(emergency));
    rig.change()
}

#[test]
fn e_01_the_heartbeat_has_its_period_and_0_is_silence() {
    for millis in [10_u64, 100, 1000] {
        let mut rig = Rig::new(Policy::CIA_301);
        rig.write(0x1017, 0, u32::try_from(millis).unwrap(), 2).unwrap();
        let seen = rig.pass(Duration::from_millis(millis * 5));
        let expected: Vec<_> = (1..=5).map(|n| (n * millis * 1000, "705#7F".to_owned())).collect();
        assert_eq!(seen, expected);
        rig.pass(Duration::from_millis(millis / 2));
        rig.write(0x1017, 0, u32::try_from(millis).unwrap(), 2).unwrap();
        let seen = rig.pass(Duration::from_millis(millis));
        assert_eq!(seen, [(millis * 1000, "705#7F".to_owned())], "a write restarts the period");
        rig.write(0x1017, 0, 0, 2).unwrap();
        assert!(rig.pass(Duration::from_secs(10)).is_empty());
    }
}

#[test]
fn e_02_the_next_heartbeat_shows_the_state() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1017, 0, 100, 2).unwrap();
    for (command, octet) in [(0x01, "05"), (0x02, "04"), (0x80, "7F")] {
        rig.data(0x000, &[command, 5]);
        let seen = rig.pass(Duration::from_millis(100));
        assert_eq!(seen, [(100_000, format!("705#{octet}"))]);
    }
}

#[test]
fn e_03_the_toggle_bit_alternates_over_everything_but_a_reset() {
    let mut rig = Rig::new(Policy::CIA_301);
    let states = [(0x01, 0x05), (0x02, 0x04), (0x80, 0x7F)];
    for request in 0..300_u32 {
        let (command, state) = states[usize::try_from(request / 7).unwrap() % 3];
        rig.data(0x000, &[command, 5]);
        let octet = state | if request % 2 == 1 { 0x80 } else { 0 };
        assert_eq!(rig.remote(0x705, 1).last(), Some(&format!("705#{octet:02X}")), "request {request}");
    }
    rig.remote(0x705, 1);
    for reset in [0x82, 0x81] {
        rig.data(0x000, &[reset, 5]);
        assert_eq!(rig.remote(0x705, 0), ["705#7F"], "0 again after {reset:02X}");
    }
    rig.write(0x100C, 0, 100, 2).unwrap();
    assert_eq!(rig.remote(0x705, 8), ["705#FF"], "not by a write of 100Ch, and with any DLC");
    assert!(rig.extended(0x705, &[]).is_empty());
    assert!(rig.remote(0x706, 1).is_empty());
}

#[test]
fn e_03_guarding_beside_heartbeat_and_without_times_as_the_device_has_it() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1017, 0, 1000, 2).unwrap();
    assert!(rig.remote(0x705, 1).is_empty(), "the heartbeat wins");
    rig.write(0x1017, 0, 0, 2).unwrap();
    assert_eq!(rig.remote(0x705, 1), ["705#7F"]);
    let mut rig = Rig::new(Policy { guarding_without_times: false, ..Policy::CIA_301 });
    assert!(rig.remote(0x705, 1).is_empty());
    rig.write(0x100C, 0, 100, 2).unwrap();
    rig.write(0x100D, 0, 3, 1).unwrap();
    assert_eq!(rig.remote(0x705, 1), ["705#7F"]);
}

#[test]
fn e_04_the_life_time_is_supervised_from_the_first_request_on() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x100C, 0, 100, 2).unwrap();
    rig.write(0x100D, 0, 3, 1).unwrap();
    rig.write(0x1801, 1, 0x8000_0285, 4).unwrap();
    rig.write(0x1800, 1, 0x8000_0185, 4).unwrap();
    rig.start();
    assert!(rig.pass(Duration::from_secs(10)).is_empty(), "no request, no event");
    assert_eq!(rig.node.state(), Some(Operational));
    for _ in 0..3 {
        rig.remote(0x705, 1);
        assert!(rig.pass(Duration::from_millis(299)).is_empty());
    }
    let seen = rig.pass(Duration::from_millis(2));
    assert_eq!(seen, [(1_000, "085#30 81 11 00 00 00 00 00".to_owned())]);
    assert_eq!(rig.node.state(), Some(PreOperational), "1029h:1 = 0");
    assert!(rig.device.notices.contains(&Notice::LifeGuardingExpired(Duration::from_millis(300))));
    assert!(rig.pass(Duration::from_secs(10)).is_empty(), "once");
    assert_eq!(rig.read(0x1001, 0), Ok(0x11));
    let seen = rig.remote(0x705, 1);
    assert_eq!(seen, ["705#FF", "085#00 00 00 00 00 00 00 00"], "the next request ends it");
    assert!(rig.device.notices.contains(&Notice::LifeGuardingBack));
    assert_eq!(rig.read(0x1001, 0), Ok(0));
}

#[test]
fn e_04_a_device_that_reacts_to_life_guarding_itself() {
    let quiet = ErrorControlRule { emcy: false, behaviour: false };
    let mut rig = Rig::new(Policy { life_guarding_error: quiet, ..Policy::CIA_301 });
    rig.write(0x100C, 0, 10, 2).unwrap();
    rig.write(0x100D, 0, 1, 1).unwrap();
    rig.start();
    rig.remote(0x705, 1);
    assert!(rig.pass(Duration::from_millis(100)).is_empty());
    assert_eq!(rig.node.state(), Some(Operational));
    assert!(
        rig.events()
            .contains(&Event::LifeGuardingExpired { guard_time: Duration::from_millis(10), factor: 1 })
    );
}

#[test]
fn e_05_the_heartbeat_consumer() {
    let node = NodeId::new(9).unwrap();
    for (behaviour, state) in [(0, PreOperational), (1, Operational), (2, Stopped)] {
        let mut rig = Rig::new(Policy::CIA_301);
        for pdo in [0x1800, 0x1801] {
            let id = rig.read(pdo, 1).unwrap();
            rig.write(pdo, 1, id | 1 << 31, 4).unwrap();
        }
        rig.write(0x1016, 1, 0x0009_0064, 4).unwrap();
        rig.write(0x1029, 1, behaviour, 1).unwrap();
        rig.start();
        assert!(rig.pass(Duration::from_secs(10)).is_empty(), "never heard: no event");
        rig.data(0x709, &[0x00]);
        for _ in 0..5 {
            assert!(rig.pass(Duration::from_millis(99)).is_empty());
            rig.data(0x709, &[0x05]);
            rig.data(0x70A, &[0x05]);
        }
        let seen = rig.pass(Duration::from_millis(101));
        assert_eq!(seen, [(100_000, "085#30 81 11 00 00 00 00 00".to_owned())], "stops: event");
        assert_eq!(rig.node.state(), Some(state), "1029h:1 = {behaviour}");
        assert!(rig.device.notices.contains(&Notice::HeartbeatLost(node)));
        let seen = rig.data(0x709, &[0x7F]);
        let silent = state == Stopped;
        let expected: &[&str] = if silent { &[] } else { &["085#00 00 00 00 00 00 00 00"] };
        assert_eq!(seen, expected, "returns");
        assert!(rig.device.notices.contains(&Notice::HeartbeatBack(node)));
    }
}

#[test]
fn e_05_two_entries_for_one_node_are_refused() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1016, 1, 0x0009_0064, 4).unwrap();
    assert_eq!(rig.write(0x1016, 2, 0x0009_00C8, 4), Err(Abort::PARAMETER.code()));
    rig.write(0x1016, 2, 0x000A_00C8, 4).unwrap();
    rig.write(0x1016, 1, 0x0009_00C8, 4).expect("the same entry");
    assert_eq!(rig.write(0x1016, 1, 0x0080_0064, 4), Err(Abort::RANGE.code()), "no node 128");
    rig.write(0x1016, 1, 0, 4).unwrap();
    rig.write(0x1016, 2, 0x0009_0064, 4).expect("free again");
}

#[test]
fn e_06_emergencies_each_once_with_register_and_history() {
    let mut rig = Rig::new(Policy::CIA_301);
    assert_eq!(rig.read(0x1003, 1), Err(Abort::NO_DATA.code()));
    let first = Emergency { information: 0x0011, octets: [1, 2, 3, 4, 5], ..Emergency::new(0x7305, 0x80) };
    assert_eq!(raise(&mut rig, first), ["085#05 73 81 01 02 03 04 05"]);
    assert!(rig.change().is_empty());
    assert_eq!(raise(&mut rig, Emergency::new(0x3120, 0x84)), ["085#20 31 85 00 00 00 00 00"]);
    assert_eq!(rig.read(0x1001, 0), Ok(0x85));
    assert_eq!(rig.read(0x1003, 0), Ok(2));
    assert_eq!(rig.read(0x1003, 1), Ok(0x3120), "the newest first");
    assert_eq!(rig.read(0x1003, 2), Ok(0x0011_7305));
    assert_eq!(rig.read(0x1003, 3), Err(Abort::NO_DATA.code()));
    assert_eq!(raise(&mut rig, Emergency::gone(0x04)), ["085#00 00 05 00 00 00 00 00"]);
    assert_eq!(raise(&mut rig, Emergency::gone(0)), ["085#00 00 00 00 00 00 00 00"]);
    assert_eq!(rig.read(0x1003, 0), Ok(2), "the end of an error is no entry");
    for code in 1..=5 {
        raise(&mut rig, Emergency::new(0xFF00 | code, 0x80));
    }
    assert_eq!(rig.read(0x1003, 0), Ok(4), "older ones drop out");
    assert_eq!(rig.read(0x1003, 1), Ok(0xFF05));
    assert_eq!(rig.read(0x1003, 4), Ok(0xFF02));
    for value in [1, 255] {
        assert_eq!(rig.write(0x1003, 0, value, 1), Err(Abort::RANGE.code()));
    }
    rig.write(0x1003, 0, 0, 1).unwrap();
    assert_eq!(rig.read(0x1003, 0), Ok(0));
    assert_eq!(rig.read(0x1001, 0), Ok(0x81), "the register stays");
    let mut rig = Rig::new(Policy { empty_history: None, ..Policy::CIA_301 });
    assert_eq!(rig.read(0x1003, 1), Ok(0));
}

#[test]
fn e_06_the_inhibit_time_keeps_emergencies_apart() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1015, 0, 100, 2).unwrap();
    assert_eq!(raise(&mut rig, Emergency::new(0x1000, 0x80)), ["085#00 10 81 00 00 00 00 00"]);
    assert!(raise(&mut rig, Emergency::new(0x2000, 0x80)).is_empty());
    assert!(raise(&mut rig, Emergency::gone(0)).is_empty());
    let seen = rig.pass(Duration::from_millis(50));
    let expected = [(10_000, "085#00 20 81 00 00 00 00 00"), (20_000, "085#00 00 00 00 00 00 00 00")];
    assert_eq!(seen, expected.map(|(at, frame)| (at, frame.to_owned())));
}

#[test]
fn e_07_a_fault_in_stopped_is_not_sent_then_or_later() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.data(0x000, &[0x02, 5]);
    assert!(raise(&mut rig, Emergency::new(0x2310, 0x02)).is_empty());
    assert!(rig.data(0x000, &[0x80, 5]).is_empty());
    assert!(rig.pass(Duration::from_secs(1)).is_empty());
    assert_eq!(rig.read(0x1003, 1), Ok(0x2310));
    assert_eq!(rig.read(0x1001, 0), Ok(0x03));
}

#[test]
fn e_08_1014h_moves_and_silences_emcy() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1014, 0, 0x8000_0085, 4).unwrap();
    assert!(raise(&mut rig, Emergency::new(0x1000, 0x80)).is_empty());
    assert_eq!(rig.read(0x1003, 0), Ok(1));
    rig.write(0x1014, 0, 0x0A5, 4).unwrap();
    assert_eq!(raise(&mut rig, Emergency::new(0x1000, 0x80)), ["0A5#00 10 81 00 00 00 00 00"]);
    assert_eq!(rig.write(0x1014, 0, 0, 4), Err(Abort::RANGE.code()));
}
