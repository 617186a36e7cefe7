//! The AG03/1 on CANopen moves: printed examples, stops, inching, loop travel (`canopen-ag03.md` 10, 13, 17; page
//! `docs/canopen-conformance.md`).

use std::time::Duration;

use profidrive::devices::ag03::canopen::state::State;
use profidrive::devices::ag03::drive::Motor;

use crate::ag03_node::Rig;

const READY: &str = "0000 0x11 0011 0111";
const RUNS: &str = "110x 0x10 0011 0111";
const PAUSED: &str = "010x 0x10 0011 0111";

#[test]
fn am_01_the_printed_positioning_example() {
    let mut rig = Rig::new();
    // P1 to P4
    rig.data(0x000, &[0x01, 0x05]);
    assert_eq!(rig.sw(), 0x0270);
    for (octets, sw) in [([0x06, 0x01], 0x0231), ([0x07, 0x01], 0x0233), ([0x0F, 0x01], 0x0337)] {
        rig.data(0x205, &octets);
        assert_eq!(rig.sw(), sw);
    }
    assert!(rig.fits(READY));
    // P5 to P7
    rig.data(0x405, &[0x1F, 0x00, 0x88, 0x13, 0x00, 0x00]);
    rig.pass_ms(200);
    assert!(rig.fits(RUNS));
    assert_eq!(rig.sw(), 0xD237);
    rig.until("target", |node| node.status_word() == 0x1737);
    assert_eq!(rig.position(), 5000);
    rig.data(0x205, &[0x0F, 0x01]);
    assert_eq!(rig.sw(), 0x0737);
    // P8 to P12
    rig.data(0x405, &[0x1F, 0x00, 0x78, 0xEC, 0xFF, 0xFF]);
    rig.pass_ms(500);
    assert_eq!(rig.sw(), 0xD237);
    rig.data(0x205, &[0x1F, 0x01]);
    rig.until("standstill", |node| node.status_word() == 0x5237);
    assert!(rig.fits(PAUSED));
    rig.data(0x205, &[0x1F, 0x00]);
    rig.until("travel", |node| node.status_word() == 0xD237);
    rig.until("target", |node| node.status_word() == 0x1737);
    assert_eq!(rig.position(), -5000);
    rig.data(0x205, &[0x0F, 0x01]);
    assert_eq!(rig.sw(), 0x0737);
    // P13 to P16
    for (octets, sw) in [([0x07, 0x01], 0x0633), ([0x06, 0x01], 0x0631), ([0x00, 0x01], 0x0670)] {
        rig.data(0x205, &octets);
        assert_eq!(rig.sw(), sw);
        assert_eq!(rig.node.status().motor, Motor::Released);
    }
    rig.data(0x000, &[0x80, 0x05]);
    assert_eq!(rig.sw(), 0x0470);
}

#[test]
fn am_02_the_printed_velocity_example() {
    let mut rig = Rig::new();
    assert_eq!(rig.sdo([0x2F, 0x60, 0x60, 0, 2, 0, 0, 0]), [0x60, 0x60, 0x60, 0, 0, 0, 0, 0]);
    rig.data(0x000, &[0x01, 0x05]);
    assert_eq!(rig.sw() & 0xFBFF, 0x1270);
    for (word, sw) in [(0x0106, 0x1231), (0x0107, 0x1233), (0x010F, 0x1337)] {
        rig.word(word);
        assert_eq!(rig.sw() & 0xFBFF, sw);
    }
    assert!(rig.fits("0001 0x11 0011 0111"));
    let runs = |rig: &mut Rig, rpm: i32| {
        rig.pass_ms(60);
        assert_eq!(rig.sw(), 0x0237);
        rig.until("speed", |node| node.status().velocity == rpm);
        assert_eq!(rig.sw(), 0x0637);
        assert!(rig.fits("0000 0x10 0011 0111"));
    };
    let stops = |rig: &mut Rig| {
        rig.word(0x010F);
        rig.until("standstill", |node| node.status_word() & 0xFBFF == 0x1337);
    };
    rig.data(0x505, &[0x0F, 0x00, 0x44, 0x00, 0x00, 0x00]);
    runs(&mut rig, 68);
    rig.data(0x505, &[0x0F, 0x00, 0x1E, 0x00, 0x00, 0x00]);
    runs(&mut rig, 30);
    stops(&mut rig);
    rig.data(0x505, &[0x0F, 0x00, 0xB8, 0xFF, 0xFF, 0xFF]);
    runs(&mut rig, -72);
    stops(&mut rig);
    for (word, sw) in [(0x0107, 0x1233), (0x0106, 0x1231), (0x0100, 0x1270)] {
        rig.word(word);
        assert_eq!(rig.sw() & 0xFBFF, sw);
    }
    rig.nmt(0x80);
    assert_eq!(rig.sw() & 0xFBFF, 0x1070);
}

#[test]
fn am_02_a_target_of_0_stops_a_new_one_starts_and_without_edge_nothing_turns() {
    let mut rig = Rig::new();
    rig.write(0x6060, 0, 2, 1).unwrap();
    rig.nmt(0x01);
    for word in [0x0006, 0x0007, 0x000F] {
        rig.turn(word, 50);
    }
    rig.pass_ms(500);
    assert_eq!(rig.node.status().velocity, 0, "OPERATION ENABLED was entered with CW.8 = 0");
    rig.word(0x010F);
    rig.word(0x000F);
    rig.until("speed", |node| node.status().velocity == 50);
    rig.write(0x60FF, 0, 0, 4).unwrap();
    rig.until("standstill", |node| node.status_word() & 0xFBFF == 0x1337);
    rig.write(0x60FF, 0, 20, 4).unwrap();
    rig.until("speed", |node| node.status().velocity == 20);
    // CN-35: 48:1 turns with 100 rpm at most.
    rig.turn(0x000F, 5000);
    assert_eq!(rig.read(0x60FF, 0), Ok(100));
    rig.until("speed", |node| node.status().velocity == 100);
}

#[test]
fn am_03_a_setpoint_during_a_job_beyond_limits_or_twice_without_clearing() {
    let mut rig = Rig::enabled();
    rig.travel(0x001F, 5000);
    rig.pass_ms(300);
    rig.travel(0x000F, 9000);
    rig.travel(0x001F, 9000);
    rig.until("end", |node| node.status_word() & 0x4000 == 0);
    assert_eq!(rig.position(), 5000, "neither a second job nor another target");
    // Twice without clearing.
    rig.travel(0x001F, 7000);
    rig.pass_ms(500);
    assert_eq!(rig.position(), 5000);
    // Beyond the limits: no acknowledge.
    rig.travel(0x000F, 2_000_000);
    assert_eq!(rig.sw() & 0x1000, 0);
    rig.travel(0x001F, 2_000_000);
    rig.pass_ms(100);
    assert_eq!((rig.sw() & 0x5000, rig.position()), (0, 5000));
    // CN-35: outside the range of 607Ah, although nothing monitors limits; it reads back what came.
    rig.write(0x607D, 1, 0, 4).unwrap();
    rig.write(0x607D, 2, 0, 4).unwrap();
    rig.events();
    rig.travel(0x000F, 10_000_000);
    rig.travel(0x001F, 10_000_000);
    rig.pass_ms(100);
    assert_eq!((rig.sw() & 0x5000, rig.position()), (0, 5000));
    assert_eq!(rig.read(0x607A, 0), Ok(10_000_000));
    assert!(
        rig.events().iter().any(|event| event.to_string()
            == "travel refused: target 607Ah is 10000000, expected -9999999 to 9999999")
    );
    // CN-52
    rig.travel(0x010F, 6000);
    rig.travel(0x011F, 6000);
    rig.pass_ms(100);
    assert_eq!((rig.sw() & 0x5000, rig.position()), (0, 5000));
}

#[test]
fn am_04_cancel_quick_stop_and_disable_voltage() {
    for (word, state, motor) in [
        (0x0007, State::SwitchedOn, Motor::Released),
        (0x0006, State::ReadyToSwitchOn, Motor::Released),
        (0x0000, State::SwitchOnDisabled, Motor::Released),
        (0x0002, State::QuickStopActive, Motor::InControl),
    ] {
        let mut rig = Rig::enabled();
        rig.travel(0x001F, 50_000);
        rig.pass_ms(1000);
        assert!(rig.fits(RUNS));
        rig.word(word);
        assert_eq!((rig.node.state(), rig.node.status().motor), (state, motor), "{word:04X}h");
        assert_eq!(rig.sw() & 0x4000, 0, "the job is gone");
        rig.until("standstill", |node| !node.status().moving);
        assert_eq!(rig.node.status().motor, motor);
        assert!(rig.position() < 40_000);
        if state == State::QuickStopActive {
            assert!(rig.fits("xxxx xxxx x00x 0111"));
            rig.word(0x000F);
            assert_eq!(rig.node.state(), state, "there is no transition 16");
            rig.word(0x0000);
            assert_eq!(rig.node.status().motor, Motor::Released);
        }
    }
}

#[test]
fn am_05_inching_1_by_its_distance_and_until_its_bit_is_0() {
    let mut rig = Rig::enabled();
    rig.word(0x200F);
    rig.until("end", |node| node.status_word() & 0x4000 == 0);
    assert_eq!(rig.position(), 1600);
    rig.pass_ms(500);
    rig.word(0x000F);
    rig.word(0x200F);
    rig.pass_ms(300);
    rig.word(0x000F);
    rig.until("end", |node| node.status_word() & 0x4000 == 0);
    assert!((1601..3200).contains(&rig.position()), "CN-50: {}", rig.position());
}

#[test]
fn am_05_inching_1_runs_to_its_end_as_a_quirk() {
    let mut config = crate::ag03_node::config();
    config.set_quirk("inching-1", "runs").unwrap();
    let mut rig = Rig::with(config);
    rig.enable();
    for end in [1600, 3200] {
        rig.word(0x200F);
        rig.pass_ms(100);
        rig.word(0x000F);
        rig.until("end", |node| node.status_word() & 0x4000 == 0);
        assert_eq!(rig.position(), end);
    }
}

#[test]
fn am_05_inching_2_in_both_directions_at_its_speed_and_not_with_both_bits() {
    let mut rig = Rig::enabled();
    rig.write(0x2410, 9, 50, 1).unwrap();
    rig.write(0x2450, 0, 47, 1).unwrap();
    for (word, rpm) in [(0x400F, 24), (0x800F, -24)] {
        rig.word(word);
        rig.until("speed", |node| node.status().velocity == rpm);
        rig.word(0x000F);
        rig.until("end", |node| node.status_word() & 0x4000 == 0);
    }
    // CN-51
    let position = rig.position();
    rig.word(0xC00F);
    rig.pass_ms(200);
    assert_eq!(rig.position(), position);
    rig.word(0x400F);
    rig.pass_ms(200);
    assert_eq!(rig.position(), position, "CW.14 did not change from 0 to 1");
}

#[test]
fn am_06_loop_travel_comes_from_the_chosen_side() {
    for (kind, target, beyond) in [(1, -3000, -3800), (2, 3000, 3800)] {
        let mut rig = Rig::enabled();
        rig.write(0x2413, 0, kind, 1).unwrap();
        rig.travel(0x001F, target);
        rig.pass_ms(100);
        assert_eq!(rig.read(0x1002, 0).unwrap() & 1 << 9, 1 << 9);
        rig.until("loop point", |node| !node.status().approach_reversed);
        assert!(rig.position().abs_diff(beyond) <= 2, "{}", rig.position());
        assert_eq!(rig.read(0x1002, 0).unwrap() & 1 << 9, 0);
        rig.until("target", |node| node.status_word() & 0x4000 == 0);
        assert_eq!(rig.position(), target);
    }
}

#[test]
fn am_07_speed_and_ramps_of_a_move_are_those_of_its_parameters() {
    let mut rig = Rig::enabled();
    rig.write(0x2410, 4, 25, 1).unwrap();
    rig.write(0x2410, 5, 60, 1).unwrap();
    rig.write(0x2410, 0x0A, 50, 1).unwrap();
    let start = rig.now;
    rig.travel(0x001F, 8000);
    rig.until("speed", |node| node.status().velocity == 60);
    // 1 rev/s at 1 rev/s^2
    let ramp = rig.now.saturating_since(start);
    assert!(ramp.abs_diff(Duration::from_secs(1)) < Duration::from_millis(30), "{ramp:?}");
    assert_eq!(rig.write(0x2410, 0x0A, 20, 1), Err(0x0800_0022), "d-Pos during a job");
    rig.until("end", |node| node.status_word() & 0x4000 == 0);
    // 5 rev: 0.5 up, 0.25 down at 2 rev/s^2, the rest at 1 rev/s
    let whole = rig.now.saturating_since(start);
    assert!(
        whole.abs_diff(Duration::from_millis(1000 + 500 + 4250)) < Duration::from_millis(60),
        "{whole:?}"
    );
}

#[test]
fn am_03_limits_written_during_a_job_are_monitored_at_once() {
    let mut rig = Rig::enabled();
    rig.travel(0x001F, 50_000);
    rig.pass_ms(1000);
    let now = rig.position();
    rig.write(0x607D, 2, now + 2000, 4).unwrap();
    assert_eq!((rig.read(0x607D, 2), rig.sw() & 0x4800), (Ok(now.unsigned_abs() + 2000), 0x4000));
    rig.events();
    rig.until("limit", |node| node.status_word() & 0x0800 != 0);
    rig.until("standstill", |node| node.status_word() & 0x4000 == 0);
    assert!((1..=55).contains(&(rig.position() - now - 2000)), "{}", rig.position());
    assert!(
        rig.events()
            .iter()
            .any(|event| { event.to_string().ends_with("inc, beyond the limit that was changed meanwhile") })
    );
    // What positions mean stays as it is.
    rig.write(0x607D, 2, 1_000_000, 4).unwrap();
    rig.word(0x000F);
    rig.travel(0x001F, 50_000);
    rig.pass_ms(500);
    for (index, sub, value, len) in
        [(0x2412, 0, 400, 2), (0x607E, 0, 1, 1), (0x6091, 1, 2, 2), (0x6060, 0, 2, 1)]
    {
        assert_eq!(rig.write(index, sub, value, len), Err(0x0800_0022), "{index:04X}h");
    }
}
