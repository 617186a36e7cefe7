//! What a person sees and presses at an AP10 (`canopen-ap10.md` 9 and 10).

use profidrive::can_bus::canopen::NodeId;
use profidrive::devices::CanopenDevice;
use profidrive::devices::ap10;
use profidrive::devices::ap10::canopen::Quirks;
use profidrive::devices::ap10::{Arrow, Fault, Key};

use crate::ap10_node::Rig;

#[test]
fn leds_and_arrows_show_the_way() {
    let mut rig = Rig::operational();
    assert_eq!(rig.display().to_string(), "[       0] [     ---], LED left off, right off");
    rig.set_point_1(100, 0x0004);
    assert_eq!(
        rig.display().to_string(),
        "[       0] [     100], arrow clockwise, LED left off, right red on"
    );
    rig.steps(97);
    assert_eq!(rig.display().to_string(), "[      97] [     100], LED left green on, right green on");
    rig.steps(200);
    assert_eq!(
        rig.display().to_string(),
        "[     200] [     100], arrow counter-clockwise, LED left red on, right off"
    );
    rig.write(0x5F1F, 0, 1, 1).unwrap();
    assert_eq!(rig.display().arrow, Some(Arrow::Clockwise), "inverted");
    rig.write(0x5F1F, 0, 2, 1).unwrap();
    assert_eq!(rig.display().arrow, None);
    assert_eq!(rig.leds(), "left red on, right off", "LEDs are another matter");
    rig.write(0x5F12, 1, 1, 1).unwrap();
    assert!(rig.display().rotated);
    rig.write(0x5F21, 1, 100, 2).unwrap();
    rig.write(0x5F21, 2, 1, 1).unwrap();
    assert_eq!(rig.leds(), "left red blinking, right off", "the outer zone (CN-109)");
}

#[test]
fn leds_without_their_basic_function_follow_the_control_word() {
    let mut rig = Rig::operational();
    for sub in 2..=5 {
        rig.write(0x5F12, sub, 0, 1).unwrap();
    }
    for (control, leds) in [
        (0x0804, "left green on, right off"),
        (0x1004, "left off, right green on"),
        (0x2004, "left off, right red on"),
        (0x4004, "left red on, right off"),
        (0xC804, "left green blinking and red blinking, right off"),
    ] {
        rig.set_point_1(100, control);
        assert_eq!(rig.leds(), leds, "{control:04X}h");
    }
    for sub in 2..=6 {
        rig.write(0x5F12, sub, 1, 1).unwrap();
    }
    assert_eq!(rig.leds(), "left off, right red blinking", "5F12h:6");
}

#[test]
fn modes_show_what_they_say() {
    let mut rig = Rig::operational();
    rig.steps(370);
    rig.set_point_1(100, 0x0004);
    for (mode, rows) in [(0, ["370", "100"]), (1, ["370", "270"]), (2, ["10", "100"])] {
        rig.write(0x5F1B, 2, mode, 1).unwrap();
        assert_eq!(rig.rows(), rows, "mode {mode}");
    }
    rig.write(0x5F0D, 2, 1, 1).unwrap();
    rig.write(0x5F1B, 2, 1, 1).unwrap();
    assert_eq!(rig.rows(), ["370", "-270"]);
    assert_eq!(rig.read(0x5F0D, 1), Ok((-270_i32).cast_unsigned()), "CN-116");
    rig.write(0x5F0B, 0, 1, 1).unwrap();
    assert_eq!(rig.rows(), ["370", ""], "5F0Bh");
    rig.write(0x5F0B, 0, 0, 1).unwrap();
    // The printed ranges of the angle.
    rig.write(0x5F1B, 2, 2, 1).unwrap();
    for (places, last, first) in [
        (0, "359", "0"),
        (1, "35.9", "0.0"),
        (2, "3.59", "0.00"),
        (3, "0.359", "0.000"),
        (4, "0.0359", "0.0000"),
    ] {
        rig.write(0x5F11, 0, places, 1).unwrap();
        rig.steps(359);
        assert_eq!(rig.rows()[0], last);
        rig.steps(-1);
        assert_eq!(rig.rows()[0], last, "below 0 it begins from above");
        rig.steps(360);
        assert_eq!(rig.rows()[0], first);
    }
}

#[test]
fn numbers_outside_the_display_overflow() {
    let mut rig = Rig::operational();
    rig.write(0x5F13, 2, 1, 1).unwrap();
    for (value, standard, extended) in [
        (99_999, "99999", "99999"),
        (100_000, "FULL", "100000"),
        (999_999, "FULL", "999999"),
        (1_000_000, "FULL", "FULL"),
        (-19_999, "-19999", "-19999"),
        (-20_000, "FULL", "-20000"),
        (-199_999, "FULL", "-199999"),
        (-200_000, "FULL", "-200000"),
        (-999_999, "FULL", "-999999"),
        (-1_000_000, "FULL", "FULL"),
    ] {
        rig.steps(value);
        rig.set_point_1(0, 0x0000);
        assert_eq!(rig.rows()[0], standard);
        rig.set_point_1(0, 0x0008);
        assert_eq!(rig.rows()[0], extended);
        let alternates = rig.display().rows[0].alternating;
        assert_eq!(alternates, (-999_999..-199_999).contains(&value), "{value}");
    }
    rig.write(0x5F11, 0, 4, 1).unwrap();
    rig.steps(-5);
    assert_eq!(rig.rows()[0], "-0.0005");
    let indicator = ap10::Quirks { overflow: "EEE", ..ap10::Quirks::DEFAULT };
    let mut rig = Rig::with(125, Quirks { indicator, ..Quirks::DEFAULT });
    rig.steps(100_000);
    assert_eq!(rig.rows()[0], "EEE", "CN-108");
}

#[test]
fn the_loop_leads_beyond_the_set_point() {
    let mut rig = Rig::operational();
    rig.write(0x5F15, 0, 1, 1).unwrap();
    rig.write(0x5F14, 0, 50, 2).unwrap();
    rig.steps(200);
    rig.set_point_1(100, 0x0004);
    for (steps, arrow) in [
        (200, Some(Arrow::CounterClockwise)),
        (100, Some(Arrow::CounterClockwise)),
        (52, Some(Arrow::Clockwise)),
        (90, Some(Arrow::Clockwise)),
        (100, None),
    ] {
        rig.steps(steps);
        assert_eq!(rig.display().arrow, arrow, "at {steps}");
    }
    rig.set_point_1(300, 0x0004);
    assert_eq!(rig.display().arrow, Some(Arrow::Clockwise), "from below it is the way itself");
}

#[test]
fn messages_wait_for_their_acknowledgement() {
    let mut rig = Rig::operational();
    rig.write(0x5F1B, 2, 3, 1).unwrap();
    let flashing = |rig: &Rig| rig.display().rows.map(|row| row.flashing);
    assert_eq!(rig.rows(), ["", "---"]);
    assert_eq!(rig.leds(), "left off, right off");
    rig.data(0x27D, b"HALLO1\x84\x00");
    assert_eq!((rig.rows(), flashing(&rig)), (["HALLO1".to_owned(), "---".to_owned()], [true, false]));
    assert_eq!(rig.leds(), "left red on, right off");
    rig.data(0x37D, b"WELT  \x84\x02");
    rig.tap(Key::Star);
    assert_eq!(flashing(&rig), [false; 2], "both with one key");
    assert_eq!(rig.leds(), "left green on, right green on");
    assert_eq!(rig.status(), 0x042C);
    rig.data(0x27D, b"HALLO1\x84\x02");
    assert_eq!(flashing(&rig), [false; 2], "the same again is no news");
    rig.data(0x27D, b"HALLO2\x84\x02");
    assert_eq!(flashing(&rig), [true, false]);
    rig.data(0x27D, b"HALLO2\x84\x06");
    assert_eq!(flashing(&rig), [false; 2], "by control bit 10");
    rig.data(0x37D, b"\x2A\0\0\0\0\0\x44\x02");
    assert_eq!((rig.rows(), flashing(&rig)), (["HALLO2".to_owned(), "42".to_owned()], [false; 2]), "bit 6");
    rig.write(0x5F1C, 0, 2, 1).unwrap();
    rig.data(0x27D, b"a\x00\xFFd\0\0\x84\x02");
    rig.data(0x37D, b"b\0\0\0\0\0\x84\x02");
    assert_eq!(rig.rows()[0], "a  d  ");
    assert_eq!(flashing(&rig), [true; 2]);
    rig.tap(Key::Star);
    assert_eq!(flashing(&rig), [true; 2]);
    rig.tap(Key::Up);
    assert_eq!(flashing(&rig), [false, true]);
    rig.tap(Key::Left);
    assert_eq!(flashing(&rig), [false; 2]);
    rig.data(0x37D, b"c\0\0\0\0\0\x84\x02");
    rig.write(0x5F1C, 1, 1, 1).unwrap();
    assert_eq!(flashing(&rig), [false; 2], "steady");
    assert_eq!(rig.leds(), "left green on, right red on");
    let indicator = ap10::Quirks { ascii_reversed: true, ..ap10::Quirks::DEFAULT };
    let mut rig = Rig::with(125, Quirks { indicator, ..Quirks::DEFAULT });
    rig.write(0x5F1B, 2, 3, 1).unwrap();
    rig.start();
    rig.data(0x27D, b"HALLO1\x84\x00");
    assert_eq!(rig.rows()[0], "1OLLAH", "CN-105");
}

/// Holds the star key for the enable time.
fn open_menu(rig: &mut Rig) {
    rig.device.press(rig.now, Key::Star);
    rig.pass(5_000);
    rig.device.release(rig.now, Key::Star);
}

/// Enters a number of digits, from the right.
fn enter(rig: &mut Rig, from: &str, to: &str) {
    for (from, to) in from.bytes().rev().zip(to.bytes().rev()) {
        for _ in 0..(to + 10 - from) % 10 {
            rig.tap(Key::Up);
        }
        rig.tap(Key::Left);
    }
    assert_eq!(rig.rows()[1], to);
}

#[test]
fn the_star_key_shows_number_and_rate_and_opens_the_menu() {
    let mut rig = Rig::new(125);
    rig.device.press(rig.now, Key::Star);
    assert_eq!(rig.rows(), ["ID 125", "AUTO"]);
    rig.pass(4_999);
    assert_eq!(rig.rows(), ["ID 125", "AUTO"]);
    rig.pass(1);
    assert_eq!(rig.rows(), ["ID", "125"]);
    rig.device.release(rig.now, Key::Star);
    enter(&mut rig, "125", "007");
    rig.tap(Key::Star);
    assert_eq!(rig.rows(), ["KBAUD", "AUTO"]);
    for rate in ["125", "250", "500", "800", "1000", "AUTO", "125"] {
        rig.tap(Key::Up);
        assert_eq!(rig.rows(), ["KBAUD", rate]);
    }
    rig.tap(Key::Star);
    assert_eq!(rig.rows(), ["CODE", "000000"]);
    rig.tap(Key::Star);
    assert_eq!(rig.rows(), ["0", "---"]);
    assert_eq!((rig.read(0x5F0A, 1), rig.read(0x5F0A, 3)), (Ok(7), Ok(1)));
    assert_eq!(rig.device.node().node_id(), NodeId::new(125).unwrap(), "in force after the next start");
    assert_eq!(rig.power_cycle(), ["707#00"]);
    // An illegal number is not taken.
    open_menu(&mut rig);
    enter(&mut rig, "007", "128");
    rig.tap(Key::Star);
    assert_eq!(rig.read(0x5F0A, 1), Ok(7));
}

#[test]
fn codes_bring_factory_values_and_the_list_of_errors() {
    let code = |rig: &mut Rig, code| {
        open_menu(rig);
        rig.tap(Key::Star);
        rig.tap(Key::Star);
        enter(rig, "000000", code);
        rig.tap(Key::Star);
        rig.pass(1000).into_iter().map(|(_, frame)| frame).collect::<Vec<_>>()
    };
    for (number, window, node) in [("011100", 5, 125), ("011102", 5, 9), ("011105", 7, 125)] {
        let mut rig = Rig::new(9);
        rig.write(0x5F10, 0, 7, 2).unwrap();
        rig.save(1);
        assert_eq!(code(&mut rig, number), [format!("{:03X}#00", 0x700 + node)], "{number}");
        assert_eq!(rig.read(0x5F10, 0), Ok(window), "{number}");
    }
    let mut rig = Rig::new(9);
    assert!(code(&mut rig, "011101").is_empty(), "no such code");
    assert_eq!(rig.rows(), ["0", "---"]);
    code(&mut rig, "200000");
    assert_eq!(rig.rows(), ["0 0", "---"], "no errors");
    rig.tap(Key::Star);
    for fault in [Fault::Speed, Fault::BatteryEmpty, Fault::Speed] {
        rig.device.provoke(rig.now, fault);
        rig.device.make_nominal(rig.now);
    }
    rig.drain();
    rig.tap(Key::Up);
    code(&mut rig, "200000");
    assert_eq!(rig.rows(), ["1 2", "SPEED"], "the newest, twice");
    rig.tap(Key::Up);
    assert_eq!(rig.rows(), ["2 1", "BAT"]);
    rig.tap(Key::Up);
    assert_eq!(rig.rows(), ["1 2", "SPEED"]);
    rig.tap(Key::Star);
    assert_eq!(rig.rows(), ["0", "---"]);
}
