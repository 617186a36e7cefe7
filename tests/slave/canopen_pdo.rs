//! Process data and SYNC (`canopen-link.md` 6; page `docs/canopen-conformance.md`).

use std::time::Duration;

use profidrive::can_bus::canopen::policy::{EventRule, RtrAnswer, SyncProducer, TypeZero};
use profidrive::can_bus::canopen::{
    Abort, Address, Event, NoEffect, Notice, PdoNumber, Policy, Request, Value,
};

use crate::canopen_device::rig::Rig;

const INPUT: Address = Address::new(0x6000, 1);
const OUTPUT: Address = Address::new(0x6200, 1);

fn input(rig: &mut Rig, value: u8) {
    rig.device.set(INPUT, Value::U8(value));
}

fn output(rig: &Rig) -> u8 {
    rig.device.ram[&OUTPUT][0]
}

/// A rig whose TPDO 1 has this type; still in PRE-OPERATIONAL.
fn with_type(policy: Policy, kind: u8) -> Rig {
    let mut rig = Rig::new(policy);
    rig.write(0x1800, 2, kind.into(), 1).unwrap();
    rig.write(0x1801, 1, 0x8000_0285, 4).unwrap();
    rig
}

#[test]
fn y_01_no_pdo_either_way_outside_operational() {
    for stop in [None, Some(0x02), Some(0x80)] {
        let mut rig = with_type(Policy::CIA_301, 1);
        if let Some(command) = stop {
            rig.start();
            rig.data(0x000, &[command, 5]);
        }
        assert!(rig.data(0x205, &[0xAA, 0xBB]).is_empty());
        assert!(rig.sync().is_empty());
        assert!(rig.remote(0x185, 2).is_empty());
        input(&mut rig, 1);
        assert!(rig.change().is_empty());
        assert_eq!(output(&rig), 0);
    }
}

#[test]
fn y_02_types_1_to_240_count_syncs_exactly_from_entry_into_operational() {
    for kind in [1, 2, 7, 240] {
        let mut rig = with_type(Policy::CIA_301, kind);
        rig.sync();
        assert!(rig.start().is_empty());
        for sync in 1..=3 * u32::from(kind) {
            let expected = usize::from(sync % u32::from(kind) == 0);
            assert_eq!(rig.sync().len(), expected, "type {kind}, SYNC {sync}");
        }
    }
}

#[test]
fn y_02_type_0_is_sent_after_a_sync_if_something_changed_or_after_every_sync() {
    let mut rig = with_type(Policy::CIA_301, 0);
    rig.start();
    assert!(rig.sync().is_empty());
    input(&mut rig, 3);
    assert!(rig.change().is_empty(), "not before the SYNC");
    assert_eq!(rig.sync(), ["185#03 00"]);
    assert!(rig.sync().is_empty());
    rig.device.requests.push_back(Request::Tpdo(PdoNumber::new(1).unwrap()));
    assert!(rig.change().is_empty());
    assert_eq!(rig.sync(), ["185#03 00"], "an event of the device counts as well");

    let mut rig = with_type(Policy { type_0: TypeZero::EverySync, ..Policy::CIA_301 }, 0);
    rig.start();
    for _ in 0..3 {
        assert_eq!(rig.sync(), ["185#00 00"]);
    }
}

#[test]
fn y_03_remote_requests_of_tpdos() {
    for kind in [0, 1, 240, 253, 254, 255] {
        let mut rig = with_type(Policy::CIA_301, kind);
        assert!(rig.remote(0x185, 2).is_empty(), "PRE-OPERATIONAL");
        rig.start();
        input(&mut rig, 0x42);
        rig.change();
        for dlc in [0, 2, 8] {
            assert_eq!(rig.remote(0x185, dlc), ["185#42 00"], "type {kind}, DLC {dlc}");
        }
    }
    let mut rig = with_type(Policy::CIA_301, 253);
    rig.write(0x1800, 1, 0xC000_0185, 4).unwrap();
    rig.write(0x1800, 1, 0x4000_0185, 4).unwrap();
    rig.start();
    assert!(rig.remote(0x185, 2).is_empty(), "bit 30");
    let mut rig = with_type(Policy { tpdo_rtr: false, ..Policy::CIA_301 }, 253);
    rig.start();
    assert!(rig.remote(0x185, 2).is_empty(), "a device without RTR");
}

#[test]
fn y_04_types_252_and_253_are_sent_on_request_only() {
    for kind in [252, 253] {
        let mut rig = with_type(Policy::CIA_301, kind);
        rig.write(0x1800, 5, 10, 2).unwrap();
        assert!(rig.start().is_empty());
        input(&mut rig, 9);
        assert!(rig.change().is_empty());
        assert!(rig.pass(Duration::from_secs(1)).is_empty());
        let before_sync = if kind == 252 { "185#00 00" } else { "185#09 00" };
        assert_eq!(rig.remote(0x185, 2), [before_sync], "type {kind}: sampled at SYNC or at the request");
        assert!(rig.sync().is_empty());
        assert_eq!(rig.remote(0x185, 2), ["185#09 00"]);
    }
}

#[test]
fn y_05_events_under_the_inhibit_time_and_the_event_timer() {
    for kind in [254, 255] {
        let mut rig = with_type(Policy::CIA_301, kind);
        rig.write(0x1800, 3, 100, 2).unwrap();
        rig.write(0x1800, 5, 50, 2).unwrap();
        assert_eq!(rig.start(), ["185#00 00"], "entering OPERATIONAL sends once");
        input(&mut rig, 1);
        assert!(rig.change().is_empty(), "inside the inhibit time");
        input(&mut rig, 2);
        assert!(rig.change().is_empty());
        let seen = rig.pass(Duration::from_millis(111));
        assert_eq!(
            seen,
            [
                (10_000, "185#02 00".to_owned()),
                (60_000, "185#02 00".to_owned()),
                (110_000, "185#02 00".to_owned())
            ],
            "sent once at the end of the inhibit time with the newest data, then by the timer"
        );
        let _ = rig.pass(Duration::from_millis(20));
        input(&mut rig, 3);
        assert_eq!(rig.change(), ["185#03 00"], "outside the inhibit time at once");
        let seen = rig.pass(Duration::from_millis(50));
        assert_eq!(seen, [(50_000, "185#03 00".to_owned())], "every transmission restarts the timer");
    }
}

#[test]
fn y_05_devices_whose_types_254_and_255_follow_other_rules() {
    let policy = Policy { type_255: EventRule::TIMER, ..Policy::CIA_301 };
    let mut rig = with_type(policy, 255);
    rig.write(0x1800, 5, 100, 2).unwrap();
    assert!(rig.start().is_empty());
    input(&mut rig, 1);
    assert!(rig.change().is_empty());
    let seen = rig.pass(Duration::from_millis(250));
    let times: Vec<u64> = seen.iter().map(|(at, _)| *at).collect();
    assert_eq!(times, [100_000, 200_000]);
    rig.write(0x1800, 5, 0, 2).unwrap();
    assert!(rig.pass(Duration::from_secs(1)).is_empty(), "timer off");
}

#[test]
fn y_06_bit_31_switches_a_pdo_off_with_its_rtr() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1800, 1, 0x8000_0185, 4).unwrap();
    rig.write(0x1801, 1, 0x8000_0285, 4).unwrap();
    rig.write(0x1400, 1, 0x8000_0205, 4).unwrap();
    assert!(rig.start().is_empty());
    input(&mut rig, 7);
    assert!(rig.change().is_empty());
    assert!(rig.remote(0x185, 2).is_empty());
    assert!(rig.data(0x205, &[1, 2]).is_empty());
    assert_eq!(output(&rig), 0);
    rig.write(0x1400, 1, 0x205, 4).unwrap();
    rig.data(0x205, &[1, 2]);
    assert_eq!(output(&rig), 1, "and on again");
}

#[test]
fn y_07_a_cob_id_changes_only_while_its_pdo_is_off() {
    for (index, id) in [(0x1800, 0x185), (0x1400, 0x205), (0x1014, 0x085)] {
        let mut rig = Rig::new(Policy::CIA_301);
        let sub = u8::from(index != 0x1014);
        let wrong_state = Err(Abort::DEVICE_STATE.code());
        assert_eq!(rig.write(index, sub, 0x333, 4), wrong_state, "while it is on");
        assert_eq!(rig.read(index, sub), Ok(id));
        rig.write(index, sub, id, 4).expect("the same identifier");
        rig.write(index, sub, id | 1 << 31, 4).expect("off");
        rig.write(index, sub, 0x8000_0333, 4).expect("changed while it is off");
        rig.write(index, sub, 0x333, 4).expect("on");
        assert_eq!(rig.read(index, sub), Ok(0x333));
        rig.write(index, sub, 0x8000_0333, 4).unwrap();
        for restricted in [
            0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x77F, 0x780,
            0x7FF,
        ] {
            assert_eq!(rig.write(index, sub, restricted, 4), Err(Abort::RANGE.code()), "{restricted:03X}h");
        }
        assert_eq!(rig.write(index, sub, 0x800, 4), Err(Abort::RANGE.code()), "12 bits without bit 29");
        let bit_30 = rig.write(index, sub, 0x4000_0334, 4);
        assert_eq!(bit_30.is_ok(), index == 0x1800, "bit 30 is for TPDOs");
    }
    let mut rig = Rig::new(Policy { change_while_valid: None, ..Policy::CIA_301 });
    rig.write(0x1800, 1, 0x333, 4).expect("a device that does not ask for bit 31");
    assert_eq!(rig.remote(0x333, 2).len(), 0);
    rig.start();
    assert_eq!(rig.remote(0x333, 2), ["333#00 00"]);
}

#[test]
fn y_08_rpdos_act_at_once_or_at_the_next_sync() {
    for kind in [254, 255] {
        let mut rig = Rig::new(Policy::CIA_301);
        rig.write(0x1400, 2, kind, 1).unwrap();
        rig.start();
        rig.data(0x205, &[0x11, 0x22]);
        assert_eq!(output(&rig), 0x11, "type {kind}");
        assert_eq!(rig.device.ram[&Address::new(0x6200, 2)], [0x22]);
    }
    for kind in [0, 1, 240] {
        let mut rig = Rig::new(Policy::CIA_301);
        rig.write(0x1400, 2, kind, 1).unwrap();
        rig.start();
        rig.data(0x205, &[0x11, 0x22]);
        rig.data(0x205, &[0x33, 0x44]);
        assert_eq!(output(&rig), 0, "type {kind}");
        rig.sync();
        assert_eq!(output(&rig), 0x33, "type {kind}: the newest frame");
        rig.device.set(OUTPUT, Value::U8(9));
        rig.sync();
        assert_eq!(output(&rig), 9, "taken once");
        rig.data(0x205, &[0x55, 0x66]);
        rig.data(0x000, &[0x80, 5]);
        rig.start();
        rig.sync();
        assert_eq!(output(&rig), 9, "what waited is forgotten with OPERATIONAL");
    }
}

#[test]
fn y_08_synchronous_rpdos_behind_the_sync_window_are_dropped() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1400, 2, 1, 1).unwrap();
    rig.write(0x1007, 0, 500, 4).unwrap();
    rig.start();
    rig.data(0x205, &[1, 0]);
    rig.sync();
    assert_eq!(output(&rig), 1, "no window before the first SYNC");
    rig.pass(Duration::from_micros(500));
    rig.data(0x205, &[2, 0]);
    rig.sync();
    assert_eq!(output(&rig), 2, "inside");
    rig.pass(Duration::from_micros(501));
    rig.data(0x205, &[3, 0]);
    rig.sync();
    assert_eq!(output(&rig), 2, "outside");
}

#[test]
fn y_09_rpdos_that_are_too_short_too_long_or_remote() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1801, 1, 0x8000_0285, 4).unwrap();
    rig.start();
    assert_eq!(rig.data(0x205, &[1]), ["085#10 82 11 00 00 00 00 00"], "8210h once");
    assert!(rig.data(0x205, &[]).is_empty());
    assert_eq!(output(&rig), 0);
    let pdo = PdoNumber::new(1).unwrap();
    assert!(rig.device.notices.contains(&Notice::RpdoLength { pdo, expected: 2, got: 1 }));
    assert_eq!(
        rig.data(0x205, &[5, 6, 7, 8, 9]),
        ["085#00 00 00 00 00 00 00 00"],
        "surplus ignored, error over"
    );
    assert_eq!(output(&rig), 5);
    assert!(rig.remote(0x205, 2).is_empty());
    assert_eq!(output(&rig), 5);
}

#[test]
fn y_09_a_device_that_answers_remote_requests_of_rpdos() {
    let pdo = PdoNumber::new(1).unwrap();
    let policy = Policy {
        rpdo_rtr: &[RtrAnswer { pdo: PdoNumber::P1, mapping: &[0x6200_0108, 0x1001_0008] }],
        ..Policy::CIA_301
    };
    let mut rig = Rig::new(policy);
    assert!(rig.remote(0x205, 2).is_empty());
    rig.start();
    rig.data(0x205, &[0x77, 0]);
    assert!(rig.device.notices.contains(&Notice::RpdoTaken(pdo)));
    assert_eq!(rig.remote(0x205, 2), ["205#77 00"]);
}

#[test]
fn y_10_the_mapping_procedure_and_each_way_it_is_refused() {
    let mut rig = Rig::new(Policy::CIA_301);
    let state = Err(Abort::DEVICE_STATE.code());
    assert_eq!(rig.write(0x1A00, 0, 0, 1), state, "the PDO is on");
    assert_eq!(rig.write(0x1A00, 1, 0x200A_0010, 4), state);
    rig.write(0x1800, 1, 0x8000_0185, 4).unwrap();
    assert_eq!(rig.write(0x1A00, 1, 0x200A_0010, 4), state, "the count is not 0");
    rig.write(0x1A00, 0, 0, 1).unwrap();
    for (word, code) in [
        (0x5555_0008, Abort::NO_OBJECT),
        (0x6000_0908, Abort::NO_SUB),
        (0x2010_0008, Abort::NOT_MAPPABLE),
        (0x200C_0010, Abort::NOT_MAPPABLE),
        (0x200A_0008, Abort::NOT_MAPPABLE),
        (0x0005_0008, Abort::NO_OBJECT),
    ] {
        assert_eq!(rig.write(0x1A00, 1, word, 4), Err(code.code()), "{word:08X}h");
        assert_eq!(rig.read(0x1A00, 1), Ok(0x6000_0108), "unchanged");
    }
    for (sub, word) in [(1, 0x200A_0010), (2, 0x200B_0020), (3, 0x6000_0108), (4, 0x6000_0208)] {
        rig.write(0x1A00, sub, word, 4).unwrap();
    }
    assert_eq!(rig.write(0x1A00, 0, 9, 1), Err(Abort::RANGE.code()));
    assert_eq!(rig.write(0x1A00, 0, 5, 1), Err(Abort::NO_OBJECT.code()), "the fifth place is empty");
    rig.write(0x1A00, 0, 4, 1).expect("64 bits");
    rig.write(0x1800, 1, 0x185, 4).unwrap();
    rig.write(0x1801, 1, 0x8000_0285, 4).unwrap();
    input(&mut rig, 0xAB);
    assert_eq!(rig.start(), ["185#E8 03 70 11 01 00 AB 00"]);
    assert_eq!(rig.write(0x1A00, 0, 0, 1), state, "on again");
    rig.data(0x000, &[0x80, 5]);
    rig.write(0x1800, 1, 0x8000_0185, 4).unwrap();
    rig.write(0x1A00, 0, 0, 1).unwrap();
    rig.write(0x1A00, 5, 0x6000_0108, 4).unwrap();
    assert_eq!(rig.write(0x1A00, 0, 5, 1), Err(Abort::PDO_LENGTH.code()), "the ninth octet");

    // RPDO with a dummy in front; entries that cannot be received.
    rig.write(0x1402, 1, 0x8000_0405, 4).unwrap();
    assert_eq!(rig.write(0x1602, 1, 0x6000_0108, 4), Err(Abort::NOT_MAPPABLE.code()), "wrong direction");
    assert_eq!(
        rig.write(0x1602, 1, 0x0005_0010, 4),
        Err(Abort::NOT_MAPPABLE.code()),
        "a dummy of wrong length"
    );
    rig.write(0x1602, 1, 0x0006_0010, 4).unwrap();
    rig.write(0x1602, 2, 0x6200_0108, 4).unwrap();
    rig.write(0x1602, 0, 2, 1).unwrap();
    rig.write(0x1402, 1, 0x405, 4).unwrap();
    rig.data(0x000, &[0x01, 5]);
    rig.data(0x405, &[0xFF, 0xFF, 0x5A]);
    assert_eq!(output(&rig), 0x5A);
}

#[test]
fn y_11_identifiers_of_29_bits() {
    let mut rig = Rig::new(Policy::CIA_301);
    for (index, id) in [(0x1400, 0x205), (0x1800, 0x185)] {
        rig.write(index, 1, id | 1 << 31, 4).unwrap();
        rig.write(index, 1, id | 1 << 29, 4).unwrap();
    }
    rig.write(0x1801, 1, 0x8000_0285, 4).unwrap();
    assert_eq!(rig.start(), ["00000185#00 00"]);
    rig.data(0x205, &[1, 1]);
    assert_eq!(output(&rig), 0, "only from extended frames");
    rig.extended(0x205, &[2, 2]);
    assert_eq!(output(&rig), 2);
    assert!(rig.remote(0x185, 2).is_empty());

    let mut rig = Rig::new(Policy { extended_ids: false, ..Policy::CIA_301 });
    rig.write(0x1400, 1, 0x8000_0205, 4).unwrap();
    assert_eq!(rig.write(0x1400, 1, 0x2000_0205, 4), Err(Abort::RANGE.code()));
    let mut rig = Rig::operational();
    assert!(rig.extended(0x205, &[3, 3]).is_empty());
    assert_eq!(output(&rig), 0, "and not the other way round");
}

#[test]
fn y_12_sync_with_data_and_sync_on_another_identifier() {
    let mut rig = with_type(Policy::CIA_301, 1);
    rig.start();
    for octets in [&[][..], &[1], &[1, 2, 3, 4, 5, 6, 7, 8]] {
        assert_eq!(rig.data(0x080, octets), ["185#00 00"]);
    }
    assert!(rig.remote(0x080, 0).is_empty());
    rig.write(0x1005, 0, 0x0A0, 4).unwrap();
    assert!(rig.sync().is_empty(), "the old one");
    assert_eq!(rig.data(0x0A0, &[]), ["185#00 00"]);
    rig.write(0x1005, 0, 0x2000_00A0, 4).unwrap();
    assert!(rig.data(0x0A0, &[]).is_empty());
    assert_eq!(rig.extended(0x0A0, &[]), ["185#00 00"]);
    assert_eq!(rig.write(0x1005, 0, 0x4000_0080, 4), Err(Abort::RANGE.code()), "no producer");
    let mut rig = Rig::new(Policy { sync_producer: SyncProducer::Dropped, ..Policy::CIA_301 });
    rig.write(0x1005, 0, 0x4000_0080, 4).unwrap();
    assert_eq!(rig.read(0x1005, 0), Ok(0x80));
}

#[test]
fn y_13_a_sync_each_millisecond_for_10_s_in_foreign_traffic_loses_nothing() {
    let mut rig = with_type(Policy::CIA_301, 1);
    rig.write(0x1017, 0, 100, 2).unwrap();
    rig.start();
    let mut heartbeats = Vec::new();
    for millis in 1..=10_000_u64 {
        for (at, frame) in rig.pass(Duration::from_millis(1)) {
            assert_eq!(frame, "705#05");
            heartbeats.push((millis - 1) * 1000 + at);
        }
        for id in [0x186, 0x206, 0x306, 0x486, 0x586, 0x606, 0x7E5] {
            assert!(rig.data(id, &[0xA5; 8]).is_empty());
        }
        assert_eq!(rig.sync(), ["185#00 00"], "at {millis} ms");
    }
    let expected: Vec<u64> = (1..=100).map(|count| count * 100_000).collect();
    assert_eq!(heartbeats, expected, "no drift");
}

#[test]
fn reserved_transmission_types_are_refused() {
    let mut rig = Rig::new(Policy::CIA_301);
    for kind in 241..=251 {
        assert_eq!(rig.write(0x1800, 2, kind, 1), Err(Abort::RANGE.code()));
    }
    for kind in 241..=253 {
        assert_eq!(rig.write(0x1400, 2, kind, 1), Err(Abort::RANGE.code()));
    }
}

#[test]
fn a_value_of_an_rpdo_out_of_range_is_refused_by_the_table_or_left_to_the_device() {
    let pdo = PdoNumber::new(2).unwrap();
    let at = Address::new(0x6411, 2);
    let frame = [1, 0, 0xFF, 0x7F, 3, 0, 4, 0];
    let mut rig = Rig::operational();
    rig.data(0x305, &frame);
    assert!(rig.device.notices.contains(&Notice::RpdoRefused { pdo, at, abort: Abort::RANGE }));
    let told = rig.events();
    assert!(
        told.iter().any(|event| matches!(event, Event::RpdoRefused { pdo: of, .. } if *of == pdo)),
        "{told:?}"
    );
    assert_eq!(rig.device.ram[&at], [0, 0]);
    assert_eq!(rig.device.ram[&Address::new(0x6411, 4)], [4, 0], "the others are taken");
    let mut rig = Rig::new(Policy { rpdo_limits: false, ..Policy::CIA_301 });
    rig.start();
    rig.data(0x305, &frame);
    assert_eq!(rig.device.ram[&at], [0xFF, 0x7F]);
}

/// A master that never uses PDOs may leave synchronous ones as they are: only what it has set up since the last reset is missed.
#[test]
fn a_missing_sync_is_told_until_a_reset_forgets_who_set_the_pdo_up() {
    let mut rig = with_type(Policy::CIA_301, 1);
    rig.write(0x1010, 1, 0x6576_6173, 4).unwrap();
    let missed = |rig: &mut Rig| {
        rig.start();
        rig.events();
        rig.pass(Duration::from_secs(4));
        rig.events().iter().any(|event| matches!(event, Event::NoEffect(NoEffect::SyncMissing { .. })))
    };
    assert!(missed(&mut rig));
    for reset in [0x82, 0x81] {
        rig.data(0x000, &[reset, 5]);
        assert_eq!(rig.read(0x1800, 2), Ok(1), "it is kept");
        assert!(!missed(&mut rig), "{reset:02X}");
    }
}
