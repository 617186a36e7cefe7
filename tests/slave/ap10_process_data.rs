//! The AP10 by PDO: set points, status word, remote requests, supervision (`canopen-ap10.md` 5, 6 and 18).

use profidrive::can_bus::canopen::NmtState;
use profidrive::devices::CanopenDevice;
use profidrive::devices::ap10::canopen::Quirks;
use profidrive::devices::ap10::{Key, StatusBit};

use crate::ap10_node::Rig;

/// The bits of a status word.
fn word(bits: &[StatusBit]) -> u16 {
    bits.iter().fold(0, |word, bit| word | 1 << *bit as u8)
}

#[test]
fn derived_frames_of_the_reference() {
    let mut rig = Rig::new(125);
    rig.write(0x1800, 5, 10, 2).unwrap();
    rig.start();
    rig.steps(98);
    assert!(rig.data(0x27D, &[0x64, 0, 0, 0, 0, 0, 0x04, 0]).is_empty());
    assert_eq!(rig.pass(10), [(10, "1FD#62 00 00 00 00 00 34 00".to_owned())]);
    rig.steps(110);
    assert_eq!(rig.data(0x080, &[]), ["2FD#6E 00 00 00 00 00 56 00"]);
    rig.write(0x5F1B, 2, 3, 1).unwrap();
    rig.data(0x27D, &[0x48, 0x41, 0x4C, 0x4C, 0x4F, 0x31, 0x84, 0x00]);
    assert_eq!(rig.rows(), ["HALLO1", "---"]);
}

#[test]
fn pp_01_tpdo1_by_time_and_tpdo2_by_every_nth_sync() {
    let mut rig = Rig::new(125);
    rig.write(0x6200, 0, 50, 2).unwrap();
    assert_eq!(rig.read(0x1800, 5), Ok(50), "one value");
    rig.write(0x1800, 5, 20, 2).unwrap();
    assert_eq!(rig.read(0x6200, 0), Ok(20));
    assert!(rig.pass(1000).is_empty(), "not in PRE-OPERATIONAL");
    rig.start();
    let seen = rig.pass(100);
    let expected: Vec<_> = (1..=5).map(|n| (20 * n, "1FD#00 00 00 00 00 00 00 00".to_owned())).collect();
    assert_eq!(seen, expected);
    rig.steps(-2);
    assert!(rig.drain().is_empty(), "a change sends nothing");
    rig.write(0x1800, 5, 0, 2).unwrap();
    assert!(rig.pass(1000).is_empty());
    for n in [1_u8, 2, 240] {
        rig.write(0x1801, 2, n.into(), 1).unwrap();
        for _ in 0..2 {
            for count in 1..=n {
                let seen = rig.data(0x080, &[]);
                let expected: &[&str] = if count == n { &["2FD#FE FF FF FF 00 00 00 00"] } else { &[] };
                assert_eq!(seen, expected, "SYNC {count} of {n}");
            }
        }
    }
}

#[test]
fn pp_02_every_pdo_is_read_by_remote_request() {
    let mut rig = Rig::operational();
    rig.steps(7);
    rig.set_point_1(100, 0x0004);
    rig.set_point_2(-3, 0x0204);
    // Valid 1 and 2; the newer one, -3, counts: below it is 7 units away.
    let status = word(&[
        StatusBit::SetPoint1Valid,
        StatusBit::SetPoint2Valid,
        StatusBit::AboveSetPoint,
        StatusBit::CounterClockwise,
    ]);
    assert_eq!(status, 0x0446);
    assert_eq!(rig.remote(0x1FD), ["1FD#07 00 00 00 00 00 46 04"]);
    assert_eq!(rig.remote(0x2FD), ["2FD#07 00 00 00 00 00 46 04"]);
    assert_eq!(rig.remote(0x27D), ["27D#64 00 00 00 00 00 46 04"]);
    assert_eq!(rig.remote(0x37D), ["37D#FD FF FF FF 00 00 46 04"]);
    for (index, kind) in [(0x1800, 0xFD), (0x1801, 0xFC)] {
        rig.write(index, 2, kind, 1).unwrap();
    }
    assert!(rig.data(0x080, &[]).is_empty(), "FCh is only sent on request");
    assert_eq!(rig.remote(0x2FD).len(), 1);
    rig.data(0x000, &[0x80, 0]);
    assert!(rig.remote(0x1FD).is_empty() && rig.remote(0x27D).is_empty(), "only in OPERATIONAL");
    rig.write(0x1800, 1, 0x8000_01FD, 4).unwrap();
    rig.write(0x1800, 1, 0x4000_01FD, 4).unwrap();
    rig.start();
    assert!(rig.remote(0x1FD).is_empty(), "bit 30 forbids it (CN-129)");
}

#[test]
fn pp_02_the_read_out_of_set_points_says_whether_they_are_characters() {
    let mut rig = Rig::operational();
    rig.write(0x5F1B, 2, 3, 1).unwrap();
    rig.data(0x27D, &[0x48, 0x41, 0x4C, 0x4C, 0x4F, 0x31, 0x84, 0x00]);
    rig.data(0x37D, &[0x07, 0, 0, 0, 0, 0, 0x04, 0x02]);
    assert_eq!(rig.remote(0x27D), ["27D#48 41 4C 4C 4F 31 04 06"]);
    assert_eq!(rig.remote(0x37D), ["37D#07 00 00 00 00 00 04 04"]);
    assert_eq!(rig.remote(0x1FD), ["1FD#00 00 00 00 00 00 04 04"], "else bit 9 is 0");
    assert_eq!(rig.read(0x5F16, 3), Ok(0x4C4C_4148));
    assert_eq!(rig.read(0x5F16, 4), Ok(0x314F));
    assert_eq!(rig.read(0x5F16, 1), Ok(7));
}

#[test]
fn pp_03_set_points_windows_and_acknowledgement() {
    let mut rig = Rig::operational();
    assert_eq!(rig.status(), 0, "nothing is monitored without a valid set point");
    rig.set_point_1(100, 0x0000);
    assert_eq!((rig.status(), rig.rows()), (0, ["0".to_owned(), "---".to_owned()]));
    rig.set_point_1(100, 0x0004);
    let valid = word(&[StatusBit::SetPoint1Valid]);
    let was = word(&[StatusBit::Window1Static]);
    let inside = word(&[StatusBit::Window1]);
    let above = word(&[StatusBit::AboveSetPoint]);
    let (cw, ccw) = (word(&[StatusBit::Clockwise]), word(&[StatusBit::CounterClockwise]));
    let near = word(&[StatusBit::Window2]);
    assert_eq!(rig.status(), valid | cw);
    for (steps, expected) in [
        (94, valid | cw),
        (95, valid | was | inside),
        (100, valid | was | inside | near),
        (105, valid | was | inside | above),
        (106, valid | was | ccw | above),
    ] {
        rig.steps(steps);
        assert_eq!(rig.status(), expected, "at {steps}");
    }
    rig.set_point_1(100, 0x0014);
    assert_eq!(rig.status(), valid | ccw | above, "acknowledged");
    rig.steps(105);
    assert_eq!(rig.status(), valid | was | inside | above, "entered anew (CN-133)");
    rig.set_point_1(100, 0x0014);
    assert_eq!(rig.status(), valid | inside | above, "inside it stays away");
    rig.set_point_1(100, 0x0004);
    assert_eq!(rig.status(), valid | inside | above);
    // RPDO2: the set point received last counts, if it is valid.
    rig.set_point_2(200, 0x0204);
    assert_eq!(rig.rows(), ["105", "200"]);
    assert_eq!(
        rig.status(),
        word(&[StatusBit::SetPoint1Valid, StatusBit::SetPoint2Valid, StatusBit::Clockwise])
    );
    rig.set_point_1(50, 0x0200);
    assert_eq!(rig.rows(), ["105", "200"], "set point 1 is not valid any more");
    assert_eq!(rig.read(0x5F0C, 0), Ok(0x0200));
    rig.set_point_2(200, 0x0000);
    assert_eq!(rig.rows(), ["105", "---"]);
    assert_eq!(rig.status(), 0);
}

#[test]
fn pp_03_rpdos_at_sync() {
    let mut rig = Rig::operational();
    rig.write(0x1400, 2, 1, 1).unwrap();
    rig.write(0x1801, 2, 0xFC, 1).unwrap();
    rig.set_point_1(100, 0x0004);
    assert_eq!(rig.status(), 0);
    rig.data(0x080, &[]);
    assert_eq!(rig.status(), word(&[StatusBit::SetPoint1Valid, StatusBit::Clockwise]));
    assert!(rig.data(0x27D, &[1, 0, 0, 0, 0, 0, 4]).is_empty(), "too short: neither taken nor an EMCY");
    rig.data(0x080, &[]);
    assert_eq!(rig.read(0x5F16, 3), Ok(100));
}

#[test]
fn pp_04_the_guarding_bit_comes_back_in_the_next_tpdo() {
    let mut rig = Rig::operational();
    for _ in 0..3 {
        rig.set_point_1(0, 0x0100);
        assert_eq!(rig.data(0x080, &[]), ["2FD#00 00 00 00 00 00 00 01"]);
        rig.set_point_2(0, 0x0000);
        assert_eq!(rig.data(0x080, &[]), ["2FD#00 00 00 00 00 00 00 00"]);
    }
}

#[test]
fn pp_05_the_silence_of_the_master_ends_operational() {
    for (source, own, other) in [(0, 0x27D, 0x080), (1, 0x080, 0x27D)] {
        let mut rig = Rig::new(125);
        let frame: &[u8] = &[0; 8];
        let octets = |id| if id == 0x080 { &[] } else { frame };
        rig.write(0x1801, 2, 0xFC, 1).unwrap();
        rig.write(0x5F09, 1, 100, 2).unwrap();
        rig.write(0x5F09, 2, source, 1).unwrap();
        rig.pass(10_000);
        rig.start();
        for _ in 0..3 {
            rig.pass(99);
            rig.data(own, octets(own));
            assert_eq!(rig.device.node().state(), Some(NmtState::Operational));
        }
        rig.pass(50);
        rig.data(other, octets(other));
        rig.pass(49);
        assert_eq!(rig.device.node().state(), Some(NmtState::Operational));
        assert!(rig.pass(1).is_empty(), "no EMCY");
        assert_eq!(rig.device.node().state(), Some(NmtState::PreOperational), "source {source}");
        rig.start();
        rig.pass(99);
        assert_eq!(rig.device.node().state(), Some(NmtState::Operational));
        rig.pass(1);
        assert_eq!(rig.device.node().state(), Some(NmtState::PreOperational), "from the entry on (CN-130)");
        rig.start();
        rig.write(0x5F09, 1, 0, 2).unwrap();
        rig.pass(1_000_000);
        assert_eq!(rig.device.node().state(), Some(NmtState::Operational));
    }
}

#[test]
fn the_supervision_of_the_master_can_begin_with_its_first_rpdo() {
    let quirks = Quirks { heartbeat_from_first: true, ..Quirks::DEFAULT };
    let mut rig = Rig::with(125, quirks);
    rig.write(0x1801, 2, 0xFC, 1).unwrap();
    rig.write(0x5F09, 1, 100, 2).unwrap();
    rig.start();
    rig.pass(10_000);
    assert_eq!(rig.device.node().state(), Some(NmtState::Operational), "nothing came yet (CN-130)");
    rig.data(0x27D, &[0; 8]);
    rig.pass(99);
    assert_eq!(rig.device.node().state(), Some(NmtState::Operational));
    rig.pass(1);
    assert_eq!(rig.device.node().state(), Some(NmtState::PreOperational));
}

#[test]
fn keys_and_incremental_measurement_are_in_the_status_word() {
    let mut rig = Rig::operational();
    for (key, bit) in [(Key::Star, StatusBit::StarKey), (Key::Up, StatusBit::UpKey)] {
        rig.device.press(rig.now, key);
        assert_eq!(rig.status(), word(&[bit]));
        rig.device.release(rig.now, key);
        assert_eq!(rig.status(), 0);
    }
    rig.steps(500);
    rig.device.press(rig.now, Key::Left);
    assert_eq!(rig.status(), word(&[StatusBit::LeftKey, StatusBit::Incremental]));
    rig.device.release(rig.now, Key::Left);
    rig.steps(520);
    assert_eq!(rig.data(0x080, &[]), ["2FD#14 00 00 00 00 00 00 02"]);
    rig.tap(Key::Left);
    assert_eq!(rig.position(), 520);
}
