//! A drive of CiA 402 from its file, as a master drives it (`eds.md` 6, E-53 to E-60).
#![cfg(feature = "eds")]

use profidrive::devices::CanopenDevice;
use profidrive::face::DriveState;
use profidrive::face::surroundings::Level;

use crate::file_drive::{BIT_12, BIT_13, Drive, ENABLED, FAULT, LIMIT, REACHED};
use crate::file_node::NODE;

#[test]
fn eds_53_the_states_of_the_profile() {
    let mut drive = Drive::new();
    assert_eq!(drive.state(), 0x40, "switch on disabled, whatever the file says of 6041h");
    assert_eq!(drive.why(), ["NoMode", "NotEnabled"]);
    for (word, state) in [
        (0x07, 0x40),
        (0x06, 0x21),
        (0x0F, 0x21),
        (0x07, 0x23),
        (0x0F, 0x27),
        (0x07, 0x23),
        (0x06, 0x21),
        (0x07, 0x23),
        (0x0F, 0x27),
        (0x06, 0x21),
        (0x00, 0x40),
        (0x06, 0x21),
        (0x02, 0x40),
        (0x06, 0x21),
        (0x07, 0x23),
        (0x0F, 0x27),
        (0x02, 0x40),
        (0x06, 0x21),
        (0x07, 0x23),
        (0x0F, 0x27),
        (0x0D, 0x40),
    ] {
        drive.word(word);
        drive.millis(5);
        assert_eq!(drive.state(), state, "after {word:02X}h");
        assert_eq!(drive.0.number(0x6040, 0), u32::from(word));
    }
}

#[test]
fn eds_53_option_codes_say_how_a_turning_motor_stops() {
    // Object, code, control word; the state in the end, and whether the speed falls on a ramp.
    for (option, code, word, state, ramp) in [
        (0x605A, 0, 0x02, 0x40, false),
        (0x605A, 1, 0x02, 0x40, true),
        (0x605A, 2, 0x02, 0x40, true),
        (0x605A, 3, 0x02, 0x40, true),
        (0x605A, 5, 0x02, 0x07, true),
        (0x605A, 6, 0x02, 0x07, true),
        (0x605A, 8, 0x02, 0x07, true),
        (0x605B, 0, 0x06, 0x21, false),
        (0x605B, 1, 0x06, 0x21, true),
        (0x605C, 0, 0x07, 0x23, false),
        (0x605C, 1, 0x07, 0x23, true),
    ] {
        let mut drive = Drive::new();
        drive.put(option, 0, code);
        drive.enable(3);
        drive.put(0x60FF, 0, 20_000);
        drive.until(REACHED);
        drive.word(word);
        let case = format!("{option:04X}h = {code}");
        drive.millis(1);
        assert_eq!(drive.state() == state, !ramp || state == 0x07, "{case}");
        let mut turned = 0;
        while drive.speed() != 0 {
            drive.millis(10);
            turned += 10;
            assert!(turned < 60_000, "{case}");
        }
        assert_eq!(drive.state(), state, "{case}");
        // A motor without torque runs out by its friction alone.
        assert_eq!(turned > 1000, !ramp, "{case}: {turned} ms");
    }
    let mut drive = Drive::new();
    drive.put(0x605A, 0, 6);
    drive.enable(3);
    drive.word(0x02);
    drive.millis(5);
    drive.word(0x0F);
    assert_eq!(drive.state(), ENABLED, "transition 16");
    for (option, code) in [(0x605A, 9), (0x605B, 2), (0x605C, 2), (0x605D, 5), (0x605E, 5), (0x6098, 36)] {
        let len = drive.0.read(option, 0).unwrap().len();
        assert_eq!(drive.0.write(option, 0, &[code, 0][..len]), Err(0x0609_0030), "{option:04X}h");
    }
}

#[test]
fn eds_54_modes_are_those_of_6502h_or_of_the_objects() {
    let mut drive = Drive::new();
    for mode in 0..=11_u8 {
        let is_mode = !matches!(mode, 5 | 11);
        let written = drive.0.write(0x6060, 0, &[mode]);
        assert_eq!(written, if is_mode { Ok(()) } else { Err(0x0609_0030) }, "mode {mode}");
        if is_mode {
            assert_eq!(drive.0.number(0x6061, 0), u32::from(mode));
        }
    }
    let mut drive = Drive::without(&[0x6502]);
    assert_eq!(drive.0.write(0x6060, 0, &[10]), Ok(()));
    let mut drive = Drive::without(&[0x6502, 0x60C1, 0x60C2, 0x6042, 0x6071]);
    for (mode, is_there) in [(1, true), (2, false), (3, true), (4, false), (6, true), (7, false), (8, false)]
    {
        assert_eq!(drive.0.write(0x6060, 0, &[mode]).is_ok(), is_there, "mode {mode}");
    }
}

#[test]
fn eds_55_profile_position() {
    let mut drive = Drive::new();
    drive.enable(1);
    drive.go_to(20_000, 0x1F);
    // 2 s at 10 000/s, 0.1 s of each ramp counts half, 20 ms in the window.
    let time = drive.until(REACHED);
    assert!((2100..2160).contains(&time), "{time} ms");
    assert_eq!((drive.position(), drive.speed()), (20_000, 0));
    assert_eq!(drive.why(), [""; 0]);
    drive.go_to(-5000, 0x5F);
    drive.until(REACHED);
    assert_eq!(drive.position(), 15_000, "relative");
    drive.go_to(30_000, 0x1F);
    drive.millis(500);
    assert!((9900..10_100).contains(&drive.speed()), "{}", drive.speed());
    drive.word(0x10F);
    drive.millis(150);
    assert_eq!((drive.speed(), drive.status() & REACHED), (0, REACHED), "halt");
    assert_eq!(drive.why(), ["Halt"]);
    assert!(drive.position() < 25_000);
    drive.word(0x0F);
    drive.until(REACHED);
    assert_eq!(drive.position(), 30_000, "goes on");
    // A set-point waits behind another, one more is refused, the next replaces both at once.
    drive.go_to(40_000, 0x1F);
    drive.put(0x607A, 0, 50_000);
    drive.word(0x1F);
    drive.word(0x0F);
    assert_eq!(drive.status() & BIT_12, BIT_12, "no room");
    drive.put(0x607A, 0, 31_000);
    drive.word(0x3F);
    drive.word(0x0F);
    drive.until(REACHED);
    assert_eq!(drive.position(), 31_000);
}

#[test]
fn eds_55_a_profile_of_zeros_moves_all_the_same() {
    let mut drive = Drive::new();
    [0x6081, 0x6083, 0x6084].into_iter().for_each(|index| drive.put(index, 0, 0));
    drive.enable(1);
    drive.go_to(10_000, 0x1F);
    assert!(drive.until(REACHED) < 1500);
}

#[test]
fn eds_56_profile_velocity_and_vl() {
    let mut drive = Drive::new();
    drive.enable(3);
    for speed in [10_000, -10_000] {
        drive.put(0x60FF, 0, speed);
        drive.millis(1);
        assert_eq!(drive.status() & REACHED, 0);
        drive.until(REACHED);
        drive.millis(5);
        assert!((drive.speed() - speed).abs() < 20, "{}", drive.speed());
        assert_eq!(drive.status() & BIT_12, 0, "the speed is not zero");
    }
    drive.word(0x10F);
    drive.millis(200);
    assert_eq!((drive.speed(), drive.status() & BIT_12), (0, BIT_12));
    let mut drive = Drive::new();
    drive.enable(2);
    drive.put(0x6042, 0, 300);
    drive.millis(500);
    assert_eq!(drive.signed(0x6044), 0);
    assert_eq!(drive.why(), ["RampDisabled"]);
    drive.word(0x7F);
    drive.millis(1000);
    assert_eq!(drive.signed(0x6044), 300);
    drive.word(0x5F);
    drive.put(0x6042, 0, 100);
    drive.millis(500);
    assert_eq!(drive.signed(0x6044), 300, "locked");
    drive.word(0x3F);
    drive.millis(500);
    assert_eq!(drive.signed(0x6044), 0, "no reference");
}

#[test]
fn eds_57_homing() {
    for (method, offset) in
        [(35, 0), (37, 1234), (1, 0), (2, 5), (17, -3), (18, 0), (33, 0), (34, 9), (7, 1), (23, 0)]
    {
        let mut drive = Drive::new();
        drive.put(0x6098, 0, method);
        drive.put(0x607C, 0, offset);
        drive.enable(6);
        drive.word(0x1F);
        drive.until(BIT_12 | REACHED);
        assert!((drive.position() - offset).abs() <= 1, "method {method}: {}", drive.position());
        assert_eq!(drive.status() & BIT_13, 0);
    }
    let mut drive = Drive::new();
    drive.put(0x6098, 0, 0);
    drive.enable(6);
    drive.word(0x1F);
    drive.until(BIT_13);
}

#[test]
fn eds_58_cyclic_modes_follow_sync_and_pdo() {
    let mut drive = Drive::new();
    drive.enable(8);
    let mut target = 0;
    for _ in 0..100 {
        target += 50;
        drive.put(0x607A, 0, target);
        drive.0.sync();
        drive.millis(10);
    }
    assert_eq!(drive.status() & (BIT_12 | BIT_13), BIT_12);
    assert!((drive.position() - target).abs() <= 50, "{}", drive.position());
    drive.millis(20);
    assert_eq!(drive.position(), target);
    // Without SYNC each PDO acts.
    let mut drive = Drive::new();
    drive.enable(8);
    for _ in 0..20 {
        let [a, b, c, d] = 40_i32.to_le_bytes();
        drive.0.data(0x200 + u16::from(NODE), &[0x0F, 0, a, b, c, d]);
        drive.millis(10);
    }
    drive.millis(10);
    assert_eq!(drive.position(), 40);
    let mut drive = Drive::new();
    drive.enable(7);
    drive.put(0x60C1, 1, 30);
    drive.0.sync();
    drive.millis(30);
    assert_eq!((drive.position(), drive.status() & BIT_12), (0, 0));
    assert_eq!(drive.why(), ["IpDisabled"]);
    drive.word(0x1F);
    drive.0.sync();
    drive.millis(30);
    assert_eq!((drive.position(), drive.status() & BIT_12), (30, BIT_12));
    let mut drive = Drive::new();
    drive.enable(9);
    drive.put(0x60FF, 0, 5000);
    drive.millis(20);
    assert!((drive.speed() - 5000).abs() < 20, "at once: {}", drive.speed());
}

#[test]
fn eds_58_torque_turns_the_shaft_and_a_load_holds_against_it() {
    for mode in [4, 10] {
        let mut drive = Drive::new();
        drive.set("load_torque_newton_metres", Level::Number(0.635));
        drive.enable(mode);
        drive.put(0x6071, 0, 600);
        drive.millis(10);
        let [torque, speed] = [0x6077, 0x606C].map(|index| drive.signed(index));
        assert_eq!((torque, speed > 0), (600, true), "mode {mode}: {speed}");
        drive.put(0x6071, 0, 0);
        drive.millis(1000);
        assert!(drive.speed() < 0, "the load turns it back");
    }
    let mut drive = Drive::new();
    drive.put(0x6087, 0, 1000);
    drive.enable(4);
    drive.put(0x6071, 0, 500);
    drive.millis(250);
    assert!((200..300).contains(&drive.signed(0x6077)), "slope: {}", drive.signed(0x6077));
    drive.millis(300);
    assert_eq!(drive.status() & REACHED, REACHED);
}

#[test]
fn eds_59_limits() {
    let mut drive = Drive::new();
    drive.put(0x607D, 1, -1000);
    drive.put(0x607D, 2, 2000);
    drive.enable(1);
    drive.go_to(5000, 0x1F);
    drive.millis(10);
    assert_eq!(drive.status() & LIMIT, LIMIT);
    drive.millis(1000);
    assert_eq!(drive.position(), 2000);
    drive.mode(3);
    drive.put(0x60FF, 0, -10_000);
    drive.millis(1000);
    assert_eq!((drive.position(), drive.status() & LIMIT), (-1000, LIMIT));
    let mut drive = Drive::new();
    drive.enable(3);
    drive.put(0x60FF, 0, 10_000);
    drive.millis(200);
    drive.set("positive_limit_switch", Level::Switch(true));
    drive.millis(200);
    assert_eq!((drive.speed(), drive.status() & LIMIT), (0, LIMIT));
    assert_eq!(drive.signed(0x60FD), 2);
    drive.put(0x60FF, 0, -10_000);
    drive.millis(200);
    assert!(drive.speed() < -9000, "back from the switch");
}

#[test]
fn eds_60_a_controlword_acts_behind_the_whole_pdo() {
    let mut drive = Drive::new();
    drive.enable(1);
    let [a, b, c, d] = 300_i32.to_le_bytes();
    let seen = drive.0.data(0x200 + u16::from(NODE), &[0x1F, 0, a, b, c, d]);
    assert_eq!(seen, ["185#3712"], "acknowledged");
    drive.0.data(0x200 + u16::from(NODE), &[0x0F, 0, a, b, c, d]);
    let seen = drive.millis(1000);
    assert_eq!(drive.position(), 300, "the target of the same PDO");
    assert_eq!(seen.last().map(String::as_str), Some("185#3706"), "{seen:?}");
}

#[test]
fn a_blocked_shaft_is_a_following_error_with_emcy_until_its_reset() {
    let mut drive = Drive::new();
    drive.put(0x6065, 0, 500);
    drive.put(0x6066, 0, 10);
    drive.enable(1);
    drive.set("blocked", Level::Switch(true));
    drive.go_to(20_000, 0x1F);
    let seen = drive.millis(1000);
    assert!(seen.contains(&"085#1186210000000000".to_owned()), "{seen:?}");
    assert_eq!((drive.state(), drive.status() & BIT_13), (FAULT, BIT_13));
    assert_eq!((drive.0.number(0x603F, 0), drive.0.number(0x1001, 0)), (0x8611, 0x21));
    assert_eq!(drive.0.device.description().drive_state(), Some(DriveState::Fault));
    assert_eq!(drive.why(), ["Fault", "NotEnabled", "Blocked"]);
    drive.set("blocked", Level::Switch(false));
    drive.word(0);
    drive.0.write(0x6040, 0, &[0x80, 0]).unwrap();
    assert_eq!((drive.state(), drive.0.number(0x603F, 0), drive.0.number(0x1001, 0)), (0x40, 0, 0));
}

#[test]
fn a_fault_is_provoked_by_its_code() {
    let mut drive = Drive::new();
    drive.enable(3);
    drive.put(0x60FF, 0, 10_000);
    drive.until(REACHED);
    let now = drive.0.now;
    drive.0.device.act(now, &mut |device| device.provoke(now, "4310").unwrap());
    assert!(drive.0.drain().contains(&"085#1043090000000000".to_owned()));
    assert_eq!(drive.state(), 0x0F, "the reaction runs, 605Eh");
    drive.millis(500);
    assert_eq!((drive.state(), drive.speed()), (FAULT, 0));
    let seen = drive.0.write(0x6040, 0, &[0x80, 0]);
    assert_eq!((seen, drive.state()), (Ok(()), 0x40));
    // A fault with a cause stays.
    drive.set("emergency_stop_released", Level::Switch(false));
    drive.millis(2);
    assert_eq!(drive.0.number(0x603F, 0), 0x9000);
    drive.word(0);
    drive.word(0x80);
    assert_eq!(drive.state(), FAULT);
    drive.set("emergency_stop_released", Level::Switch(true));
    drive.word(0);
    drive.word(0x80);
    assert_eq!(drive.state(), 0x40);
    let mut unknown = None;
    drive.0.device.act(now, &mut |device| unknown = Some(device.provoke(now, "1234")));
    assert!(unknown.unwrap().is_err());
}

#[test]
fn units_of_the_user_and_polarity() {
    let mut drive = Drive::new();
    drive.put(0x6091, 1, 10);
    drive.put(0x607E, 0, 0xC0);
    drive.enable(1);
    drive.go_to(1000, 0x1F);
    drive.until(REACHED);
    assert_eq!(drive.position(), 1000);
    // 10 revolutions of the motor, backwards: 10 000 increments of the encoder.
    drive.put(0x6091, 1, 1);
    drive.put(0x607E, 0, 0);
    assert_eq!(drive.position(), -10_000);
}

#[test]
fn a_master_that_is_lost_is_a_fault_by_6007h() {
    for (option, state) in [(0, ENABLED), (1, FAULT), (2, 0x40), (3, 0x40)] {
        let mut drive = Drive::new();
        drive.put(0x6007, 0, option);
        drive.enable(3);
        drive.0.data(0, &[2, NODE]);
        drive.millis(50);
        drive.0.data(0, &[0x80, NODE]);
        assert_eq!(drive.state(), state, "6007h = {option}");
    }
}

#[test]
fn a_touch_probe_keeps_the_position_of_an_edge() {
    let mut drive = Drive::new();
    drive.put(0x60B8, 0, 0x11);
    drive.enable(1);
    drive.go_to(700, 0x1F);
    drive.until(REACHED);
    drive.set("touch_probe_1", Level::Switch(true));
    assert_eq!((drive.0.number(0x60B9, 0), drive.signed(0x60BA)), (3, 700));
}

#[test]
fn after_power_off_the_drive_begins_anew_where_its_shaft_is() {
    let mut drive = Drive::new();
    drive.enable(1);
    drive.go_to(500, 0x1F);
    drive.until(REACHED);
    drive.0.device.power_off(drive.0.now);
    assert_eq!(drive.0.device.description().drive_state(), Some(DriveState::Off));
    assert_eq!(drive.why(), ["SwitchedOff"]);
    drive.millis(100);
    drive.0.device.power_on(drive.0.now);
    drive.0.start();
    assert_eq!((drive.state(), drive.position(), drive.0.number(0x6061, 0)), (0x40, 500, 0));
}

#[test]
fn positions_begin_anew_at_the_end_of_607bh_and_60f2h_says_which_way() {
    let range: &[(u16, &str)] = &[(4, "0"), (4, "3599")];
    let mut drive = Drive::with(&[(0x60F2, 6, "rw", "")], &[(0x607B, range)]);
    drive.enable(1);
    let mut go = |target: i32, option: i32| {
        drive.put(0x60F2, 0, option);
        drive.go_to(target, 0x1F);
        drive.until(REACHED);
        (drive.position(), drive.0.number(0x6063, 0).cast_signed())
    };
    assert_eq!(go(3000, 0), (3000, 3000));
    assert_eq!(go(100, 0x80), (100, 3700), "forwards");
    assert_eq!(go(3500, 0xC0), (3500, 3500), "the shorter way");
    assert_eq!(go(3550, 0x40), (3550, -50), "backwards");
    assert_eq!(go(10, 0), (10, -3590), "within the range");
}

#[test]
fn vl_counts_in_the_unit_of_604ch_and_pv_tells_a_slippage_beyond_60f8h() {
    let factor: &[(u16, &str)] = &[(4, "60"), (4, "1")];
    let mut drive = Drive::with(&[(0x60F8, 4, "rw", "DefaultValue=100")], &[(0x604C, factor)]);
    drive.enable(2);
    drive.word(0x7F);
    drive.put(0x6042, 0, 10);
    drive.until(REACHED);
    drive.millis(100);
    assert_eq!(drive.signed(0x6044), 10);
    assert!((drive.speed() - 10_000).abs() < 100, "600 rpm are {} increments/s", drive.speed());
    drive.word(0x0F);
    drive.millis(2000);
    drive.mode(3);
    drive.put(0x60FF, 0, 1000);
    drive.until(REACHED);
    assert_eq!(drive.status() & BIT_13, 0);
    drive.set("blocked", Level::Switch(true));
    drive.millis(20);
    assert_ne!(drive.status() & BIT_13, 0);
}

#[test]
fn homing_methods_are_those_of_60e3h() {
    let mut drive = Drive::with(&[], &[(0x60E3, &[(2, "35"), (2, "17")])]);
    assert_eq!(drive.0.write(0x6098, 0, &[17]), Ok(()));
    assert_eq!(drive.0.write(0x6098, 0, &[1]), Err(0x0609_0030));
    let mut drive = Drive::with(&[], &[(0x60E3, &[(2, ""), (2, "")])]);
    assert_eq!((drive.0.number(0x60E3, 1), drive.0.number(0x60E3, 2)), (1, 2), "those that it has");
}

#[test]
fn a_stop_of_the_master_is_told_as_fault_8130h_too() {
    let mut drive = Drive::new();
    drive.enable(3);
    let mut seen = drive.0.data(0, &[0x82, NODE]);
    seen.extend(drive.millis(10));
    assert_eq!(drive.0.number(0x603F, 0), 0x8130);
    // Code, 1001h (generic and communication), nothing of the maker.
    assert_eq!(
        seen.iter().filter(|frame| frame.starts_with("085#")).collect::<Vec<_>>(),
        ["085#3081110000000000"]
    );
    let mut stopped = Drive::new();
    stopped.enable(3);
    stopped.0.data(0, &[2, NODE]);
    stopped.0.data(0, &[0x80, NODE]);
    assert_eq!(stopped.0.number(0x603F, 0), 0x8130, "{seen:?}");
    assert_ne!(stopped.0.number(0x1001, 0), 0);
}
