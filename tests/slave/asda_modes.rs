//! The modes of operation of the ASDA-A2 (`canopen-asda-a2.md` 9, 15).

use profidrive::can_bus::cia402::{Mode, State};
use profidrive::devices::asda_a2::canopen::Quirks;
use profidrive::devices::asda_a2::plant::INCREMENTS_PER_REVOLUTION;
use profidrive::devices::asda_a2::{Axis, Config, Inputs, Level, Switches};

use crate::asda_a2_node::{NODE, Rig, millis};

const REACHED: u16 = 1 << 10;
const BIT_12: u16 = 1 << 12;
const BIT_13: u16 = 1 << 13;
const BIT_14: u16 = 1 << 14;

/// One revolution is 1 280 000 PUU as long as 6093h is 1:1.
const REV: i64 = 1_280_000;

fn in_pp() -> Rig {
    let mut rig = Rig::full();
    rig.set(0x6081, 0, 10 * REV);
    rig.enable(Mode::ProfilePosition);
    rig
}

fn travel(rig: &mut Rig, target: i64, bits: u16) {
    rig.set(0x607A, 0, target);
    rig.control(0x0F);
    rig.control(0x0F | bits);
}

#[test]
fn dp_01_single_set_points_wait_for_each_other() {
    let mut rig = in_pp();
    travel(&mut rig, 2 * REV, 0x10);
    assert_eq!(rig.status() & (REACHED | BIT_12), BIT_12, "taken, not there");
    travel(&mut rig, REV, 0x10);
    rig.control(0x0F);
    assert_eq!(rig.status() & BIT_12, BIT_12, "one runs, one waits: no room");
    let mut most = 0;
    for _ in 0..2000 {
        rig.pass(millis(1));
        most = most.max(rig.position());
    }
    assert_eq!((most, rig.position()), (2 * REV as i32, REV as i32));
    assert_eq!(rig.status() & (REACHED | BIT_12), REACHED);
}

#[test]
fn dp_01_change_immediately_leaves_the_running_set_point() {
    let mut rig = in_pp();
    travel(&mut rig, 20 * REV, 0x10);
    rig.pass(millis(500));
    travel(&mut rig, -REV, 0x30);
    rig.until(REACHED, REACHED, millis(5000));
    assert_eq!(rig.position(), -REV as i32);
}

#[test]
fn dp_01_relative_set_points_add_up() {
    let mut rig = in_pp();
    for turn in 1..=3 {
        travel(&mut rig, -REV / 2, 0x50);
        rig.pass(millis(5));
        rig.until(REACHED, REACHED, millis(1000));
        assert_eq!(rig.position(), (-REV / 2 * turn) as i32);
    }
}

/// 6086h: the same travel and speed without corners, each ramp 50 ms longer.
#[test]
fn the_motion_profile_type_rounds_the_ramps() {
    for (mode, profile, first, end) in [
        (Mode::ProfilePosition, 0, 150, 1000),
        (Mode::ProfilePosition, 1, 9, 1050),
        (Mode::ProfilePosition, -1, 150, 1000),
        (Mode::ProfileVelocity, 0, 150, 133),
        (Mode::ProfileVelocity, 3, 9, 183),
    ] {
        let mut rig = Rig::full();
        for (index, value) in [(0x6081, 10 * REV), (0x6083, 1000), (0x6084, 1000), (0x6086, profile)] {
            rig.set(index, 0, value);
        }
        rig.enable(mode);
        let context = format!("{mode:?}, 6086h = {profile}");
        let is_position = mode == Mode::ProfilePosition;
        if is_position {
            travel(&mut rig, 8 * REV, 0x10);
        } else {
            rig.set(0x60FF, 0, 6000);
        }
        rig.pass(millis(5));
        let demand = rig.signed(0x606B);
        assert!((first / 3..=first).contains(&demand), "{context}: 0.1 rpm after 5 ms: {demand}");
        rig.pass(millis(495));
        assert_eq!(rig.signed(0x606B), 6000, "{context}");
        let mut time = 500;
        if !is_position {
            rig.set(0x60FF, 0, 2000);
            time = 0;
        }
        let rest = if is_position { 0 } else { 2000 };
        while rig.signed(0x606B) != rest {
            rig.pass(millis(1));
            time += 1;
            assert!(time < 3000, "{context}");
        }
        assert!((end - 15..=end + 15).contains(&time), "{context}: {time} ms");
        if is_position {
            rig.until(REACHED, REACHED, millis(100));
            assert_eq!(rig.position(), 8 * REV as i32, "{context}");
        }
    }
}

#[test]
fn pp_keeps_its_speed_and_its_ramps() {
    let mut rig = in_pp();
    rig.set(0x6083, 0, 1000);
    rig.set(0x6084, 0, 500);
    travel(&mut rig, 20 * REV, 0x10);
    rig.pass(millis(100));
    let speed = rig.signed(0x606C);
    assert!((2950..=3050).contains(&speed), "300 rpm after 100 of 1000 ms: {speed}");
    rig.pass(millis(400));
    let speed = rig.signed(0x606C);
    assert!((5990..=6010).contains(&speed), "10 rev/s are 600 rpm: {speed}");
    rig.until(REACHED, REACHED, millis(5000));
    assert_eq!(i64::from(rig.position()), 20 * REV);
}

#[test]
fn the_greatest_acceleration_and_deceleration_limit_the_ramps_of_profiles() {
    let speeds = |limits: [i64; 2]| {
        let mut rig = Rig::full();
        rig.set(0x6083, 0, 200);
        rig.set(0x6084, 0, 200);
        rig.set(0x60C5, 0, limits[0]);
        rig.set(0x60C6, 0, limits[1]);
        rig.enable(Mode::ProfileVelocity);
        rig.set(0x60FF, 0, 10_000);
        rig.pass(millis(30));
        let up = rig.signed(0x606C);
        rig.pass(millis(1000));
        assert!((9_990..=10_010).contains(&rig.signed(0x606C)));
        rig.set(0x60FF, 0, 0);
        rig.pass(millis(30));
        (up, 10_000 - rig.signed(0x606C))
    };
    // 30 of 200 ms are 450 rpm, of 1000 ms 90 rpm.
    for (limits, up, down) in
        [([200, 200], 4500, 4500), ([1000, 200], 900, 4500), ([200, 1000], 4500, 900), ([1, 1], 4500, 4500)]
    {
        let got = speeds(limits);
        assert!((got.0 - up).abs() <= 200 && (got.1 - down).abs() <= 200, "{limits:?}: {got:?}");
    }
    let time = |limit: i64| {
        let mut rig = in_pp();
        rig.set(0x60C5, 0, limit);
        travel(&mut rig, 20 * REV, 0x10);
        rig.pass(millis(30));
        rig.signed(0x606C)
    };
    assert!((4300..=4700).contains(&time(1)) && (800..=1000).contains(&time(1000)), "PP, too");
}

#[test]
fn the_gear_makes_puu() {
    let mut rig = Rig::full();
    rig.set(0x6093, 1, 128);
    rig.set(0x6093, 2, 10);
    rig.set(0x6081, 0, 1_000_000);
    rig.enable(Mode::ProfilePosition);
    travel(&mut rig, 250_000, 0x10);
    rig.pass(millis(5));
    rig.until(REACHED, REACHED, millis(2000));
    assert_eq!((rig.position(), rig.signed(0x6063)), (250_000, 3_200_000), "100000 PUU per revolution");
    assert_eq!([rig.signed(0x6062), rig.signed(0x60FC), rig.signed(0x60F4)], [250_000, 3_200_000, 0]);
}

#[test]
fn the_positioning_option_says_what_a_relative_target_counts_from() {
    for (option, expected) in [(0, 21), (1, 16), (2, 16)] {
        let mut rig = in_pp();
        rig.set(0x60F2, 0, option);
        travel(&mut rig, 20 * REV, 0x10);
        while i64::from(rig.position()) < 15 * REV {
            rig.pass(millis(1));
        }
        travel(&mut rig, REV, 0x70);
        rig.until(REACHED, REACHED, millis(10_000));
        let turns = (f64::from(rig.position()) / REV as f64).round();
        assert_eq!(turns as i64, expected, "60F2h = {option}");
    }
}

#[test]
fn gain_and_feed_forward_of_the_position_loop_make_the_following_error() {
    // 600 rpm: 12.8e6 increments/s, of which the loop makes what is not fed forward.
    for (gain, forward, error) in
        [(200, 100, 0), (35, 100, 0), (200, 50, 32_000), (35, 50, 182_857), (35, 0, 365_714)]
    {
        let mut rig = in_pp();
        rig.set(0x2200, 0, gain);
        rig.set(0x2202, 0, forward);
        travel(&mut rig, 20 * REV, 0x10);
        rig.pass(millis(1000));
        let got = i64::from(rig.signed(0x60F4));
        assert!((got - error).abs() <= 15_000, "P2-00 = {gain}, P2-02 = {forward}: {got}, not {error}");
        rig.until(REACHED, REACHED, millis(5000));
        assert!((i64::from(rig.position()) - 20 * REV).abs() <= 100, "within 6067h");
        rig.set(0x6065, 0, 100_000);
        travel(&mut rig, 0, 0x10);
        rig.pass(millis(1000));
        assert_eq!(
            rig.servo().alarms().is_empty(),
            error < 100_000,
            "AL009 of the error that 6065h does not allow"
        );
    }
}

#[test]
fn home_is_attained_when_the_shaft_is_there_too() {
    let mut rig = Rig::full();
    rig.set(0x2200, 0, 35);
    rig.set(0x2202, 0, 50);
    rig.set(0x607C, 0, 4711);
    rig.set(0x6098, 0, 1);
    rig.enable(Mode::Homing);
    rig.control(0x1F);
    rig.until(BIT_12, BIT_12, millis(60_000));
    assert!((rig.position() - 4711).abs() <= 100, "{}", rig.position());
}

#[test]
fn dp_02_the_following_error_is_bit_13_and_al009() {
    let mut rig = in_pp();
    rig.start();
    rig.device.set_inputs(rig.now, Inputs { blocked: true, ..Inputs::NOMINAL });
    travel(&mut rig, 10 * REV, 0x10);
    let seen = rig.until(0x4F, 0x08, millis(1000));
    assert_eq!(seen, ["0FF#11 86 21 09 00 00 00 00"]);
    assert_eq!(rig.status() & BIT_13, BIT_13);
    assert_eq!(rig.read(0x603F, 0), Ok(0x8611));
    assert_eq!(rig.servo().panel().to_string(), "AL009");
}

#[test]
fn the_following_error_window_is_for_the_profile_position_mode() {
    let mut rig = Rig::full();
    rig.enable(Mode::ProfileVelocity);
    rig.set(0x6065, 0, 1000);
    rig.device.set_inputs(rig.now, Inputs { blocked: true, ..Inputs::NOMINAL });
    rig.set(0x60FF, 0, 10_000);
    rig.pass(millis(1000));
    assert_eq!(rig.servo().alarms(), [], "the guide has 6065h in PP only");
    rig.device.set_inputs(rig.now, Inputs::NOMINAL);
    let mut top = 0;
    for _ in 0..100 {
        rig.pass(millis(1));
        top = top.max(rig.signed(0x606C));
    }
    assert!((10_000..11_500).contains(&top), "{top}: what was lost while it was blocked is not caught up");
}

#[test]
fn position_window_and_its_time() {
    let mut rig = in_pp();
    rig.set(0x6068, 0, 50);
    travel(&mut rig, REV, 0x10);
    while rig.position() != REV as i32 {
        rig.pass(millis(1));
    }
    assert_eq!(rig.status() & REACHED, 0);
    rig.pass(millis(60));
    assert_eq!(rig.status() & REACHED, REACHED);
}

#[test]
fn after_a_change_of_the_mode_relative_set_points_count_from_where_the_shaft_came_to_rest() {
    let mut rig = Rig::full();
    rig.set(0x6081, 0, 10 * REV);
    rig.enable(Mode::ProfileVelocity);
    rig.set(0x60FF, 0, 6000);
    rig.pass(millis(500));
    rig.set(0x6060, 0, 1);
    rig.pass(millis(300));
    assert_eq!(rig.status() & REACHED, REACHED);
    let stands = rig.position();
    travel(&mut rig, 1000, 0x50);
    rig.pass(millis(300));
    assert_eq!(rig.position(), stands + 1000);
}

#[test]
fn halt_stops_and_lets_go_on() {
    let mut rig = in_pp();
    travel(&mut rig, 10 * REV, 0x10);
    rig.pass(millis(300));
    rig.control(0x011F);
    rig.pass(millis(300));
    let stands = rig.position();
    assert_eq!((rig.signed(0x606C), rig.status() & REACHED), (0, REACHED));
    rig.pass(millis(300));
    assert_eq!(rig.position(), stands);
    rig.control(0x001F);
    rig.pass(millis(5));
    rig.until(REACHED, REACHED, millis(5000));
    assert_eq!(i64::from(rig.position()), 10 * REV);
}

#[test]
fn software_limits_end_a_motion_with_a_warning() {
    let mut rig = in_pp();
    rig.set(0x607D, 1, -REV);
    rig.set(0x607D, 2, 2 * REV);
    travel(&mut rig, 5 * REV, 0x10);
    rig.pass(millis(1500));
    assert_eq!(i64::from(rig.position()), 2 * REV);
    assert_eq!(rig.servo().panel().to_string(), "AL283");
    assert_eq!(rig.status() & 0x008F, 0x0087, "a warning: the servo stays on");
    travel(&mut rig, 0, 0x10);
    rig.pass(millis(1500));
    assert!(rig.servo().alarms().is_empty(), "the way back clears it");
    rig.set(0x6060, 0, 3);
    rig.set(0x60FF, 0, -6000);
    rig.pass(millis(1500));
    assert_eq!((i64::from(rig.position()), rig.servo().panel().to_string()), (-REV, "AL285".to_owned()));
}

#[test]
fn limit_switches_of_an_axis_stop_the_motion_towards_them() {
    let mut rig = in_pp();
    let rev = INCREMENTS_PER_REVOLUTION;
    let axis = Axis { negative_limit: -3.0 * rev, positive_limit: 3.0 * rev, home: (0.5 * rev, 0.6 * rev) };
    rig.device.set_inputs(rig.now, Inputs { switches: Switches::Fixed(axis), ..Inputs::NOMINAL });
    travel(&mut rig, 10 * REV, 0x10);
    rig.pass(millis(2000));
    let stands = rig.position();
    assert!((3 * REV..4 * REV).contains(&stands.into()), "{stands}");
    assert_eq!((rig.servo().panel().to_string(), rig.read(0x60FD, 0)), ("AL015".to_owned(), Ok(2)));
    travel(&mut rig, 0, 0x10);
    rig.pass(millis(2000));
    assert_eq!((rig.position(), rig.servo().alarms().len()), (0, 0), "the way out is free");
}

#[test]
fn dv_01_velocity_with_ramps_window_and_zero_speed() {
    let mut rig = Rig::full();
    rig.set(0x60FF, 0, 5000);
    rig.enable(Mode::ProfileVelocity);
    assert_eq!(rig.signed(0x60FF), 0, "cleared by servo on");
    rig.pass(millis(5));
    assert_eq!(rig.status() & (BIT_12 | REACHED), BIT_12 | REACHED, "stands still as told");
    rig.set(0x6083, 0, 1000);
    rig.set(0x6084, 0, 500);
    rig.set(0x606E, 0, 20);
    rig.set(0x60FF, 0, 15_000);
    rig.pass(millis(250));
    assert!((7450..=7550).contains(&rig.signed(0x606C)), "half way up");
    assert_eq!(rig.status() & (BIT_12 | REACHED), 0);
    rig.pass(millis(300));
    assert_eq!((rig.signed(0x606C), rig.signed(0x606B)), (15_000, 15_000));
    assert_eq!(rig.status() & (BIT_12 | REACHED), REACHED);
    rig.set(0x60FF, 0, 0);
    rig.pass(millis(125));
    assert!((7450..=7550).contains(&rig.signed(0x606C)), "half way down");
    rig.pass(millis(200));
    assert_eq!((rig.signed(0x606C), rig.status() & BIT_12), (0, BIT_12));
    rig.set(0x60FF, 0, -3000);
    rig.pass(millis(200));
    rig.control(0x06);
    assert_eq!(rig.signed(0x60FF), 0, "cleared by servo off");
    rig.enable(Mode::ProfileVelocity);
    rig.set(0x60FF, 0, 3000);
    rig.set(0x6060, 0, 4);
    assert_eq!(rig.signed(0x60FF), 0, "cleared by another mode");
}

#[test]
fn dt_01_torque_with_its_slope() {
    let mut rig = Rig::full();
    rig.set(0x6071, 0, 500);
    rig.enable(Mode::ProfileTorque);
    assert_eq!(rig.signed(0x6071), 0, "cleared by servo on");
    rig.device.set_inputs(rig.now, Inputs { blocked: true, ..Inputs::NOMINAL });
    rig.set(0x6087, 0, 1000);
    rig.set(0x6071, 0, 500);
    rig.pass(millis(250));
    assert_eq!((rig.signed(0x6074), rig.signed(0x6077), rig.status() & REACHED), (250, 250, 0));
    rig.pass(millis(300));
    assert_eq!((rig.signed(0x6074), rig.status() & REACHED), (500, REACHED));
    rig.device.set_inputs(rig.now, Inputs { friction_torque: 0.1, ..Inputs::NOMINAL });
    rig.pass(millis(2000));
    assert_eq!(rig.signed(0x606C), 50_000, "as fast as the motor may");
    rig.control(0x0B);
    assert_eq!(rig.signed(0x6071), 0, "cleared by a quick stop");
}

fn home(method: i64, offset: i64) -> Rig {
    let mut rig = Rig::full();
    rig.set(0x607C, 0, offset);
    rig.set(0x6098, 0, method);
    rig.set(0x6099, 1, 2000);
    rig.set(0x6099, 2, 500);
    rig.enable(Mode::Homing);
    assert_eq!(rig.status() & (BIT_12 | BIT_13), 0);
    rig.control(0x1F);
    rig
}

#[test]
fn dh_01_every_method_attains_home_at_607ch() {
    for method in (1..=14).chain(17..=30).chain(33..=35) {
        let mut rig = home(method, 4711);
        rig.until(BIT_12 | REACHED, BIT_12 | REACHED, millis(60_000));
        assert_eq!((rig.position(), rig.status() & BIT_13), (4711, 0), "method {method}");
        assert_eq!(rig.read(0x60FD, 0), Ok(0), "the switches of the bench are gone");
    }
}

#[test]
fn dh_02_a_method_that_is_none_is_a_homing_error() {
    for method in [0, 15, 16, 31, 32] {
        let mut rig = home(method, 0);
        rig.pass(millis(5));
        assert_eq!(rig.status() & (BIT_12 | BIT_13), BIT_13, "method {method}");
        rig.set(0x6098, 0, 35);
        rig.control(0x0F);
        rig.control(0x1F);
        assert_eq!(rig.status() & (BIT_12 | BIT_13), BIT_12, "the next one starts anew");
    }
}

#[test]
fn a_homing_without_its_switch_fails_at_the_limit() {
    let rev = INCREMENTS_PER_REVOLUTION;
    let axis = Axis { negative_limit: -rev, positive_limit: rev, home: (9.0 * rev, 9.1 * rev) };
    let mut rig = Rig::full();
    rig.device.set_inputs(rig.now, Inputs { switches: Switches::Fixed(axis), ..Inputs::NOMINAL });
    rig.set(0x6098, 0, 7);
    rig.set(0x6099, 1, 2000);
    rig.enable(Mode::Homing);
    rig.control(0x1F);
    rig.until(BIT_13, BIT_13, millis(20_000));
}

/// A rig in IP with a cycle of so many ms and RPDO 1 as chapter 6 of the reference has it.
fn in_ip(level: Level, cycle: i64) -> Rig {
    let mut rig = Rig::new(level);
    let mapped: &[i64] = match level {
        Level::Half => &[0x60C1_0110, 0x60C1_0210, 0x60C1_0310, 0x6040_0010],
        Level::Full => &[0x60C1_0120, 0x60C1_0210, 0x6040_0010],
    };
    rig.set(0x1400, 1, 0x8000_027F);
    for (entry, sub) in mapped.iter().zip(1..) {
        rig.set(0x1600, sub, *entry);
    }
    rig.set(0x1600, 0, mapped.len() as i64);
    rig.set(0x1400, 2, 1);
    rig.set(0x1400, 1, 0x27F);
    match level {
        Level::Half => rig.set(0x1006, 0, 1000 * cycle),
        Level::Full => rig.set(0x60C2, 1, cycle),
    }
    rig.start();
    rig.enable(Mode::InterpolatedPosition);
    rig
}

fn cycle(rig: &mut Rig, time: u64, position: i32, difference: i16) {
    let [a, b, c, d] = position.to_le_bytes();
    let [e, f] = difference.to_le_bytes();
    assert!(rig.data(0x27F, &[a, b, c, d, e, f, 0x0F, 0x00]).is_empty());
    assert!(rig.sync().is_empty());
    rig.pass(millis(time));
}

#[test]
fn di_01_interpolation_follows_its_host() {
    for level in [Level::Half, Level::Full] {
        for (sub_mode, time) in [(0, 1), (0, 2), (-1, 1), (-1, 2), (-1, 20)] {
            let mut rig = in_ip(level, time);
            rig.set(0x60C0, 0, sub_mode);
            assert_eq!(rig.status() & (BIT_12 | BIT_14), 0);
            for step in 0..500 {
                // From rest to 10000 PUU per cycle and on.
                let (position, speed) = if step < 100 {
                    (50 * step * step, 100 * step)
                } else {
                    (500_000 + 10_000 * (step - 100), 10_000)
                };
                cycle(&mut rig, time as u64, position, speed as i16);
                assert_eq!(rig.status() & (BIT_12 | BIT_14), BIT_12 | BIT_14);
                let away = (rig.signed(0x6062) - position).abs();
                assert!(away <= 1, "{level:?} {sub_mode} step {step}: {away}");
                let lag = rig.signed(0x60F4).abs();
                assert!(lag <= 20_000, "step {step}: {lag}");
            }
        }
    }
}

#[test]
fn di_02_without_sync_the_drive_extrapolates_and_stops_after_two_cycles() {
    let mut rig = in_ip(Level::Full, 2);
    for step in 0..50 {
        cycle(&mut rig, 2, 10_000 * step, 10_000);
    }
    let before = rig.signed(0x6062);
    let seen = rig.pass(millis(1));
    assert!(seen.is_empty());
    assert_eq!(rig.signed(0x6062), before + 5000, "on at the same speed");
    assert_eq!(rig.status() & (BIT_12 | BIT_14), BIT_12);
    let seen = rig.pass(millis(5));
    assert_eq!(seen.first(), Some(&(1000, "0FF#00 62 11 03 03 00 00 00".to_owned())));
    assert_eq!((rig.servo().panel().to_string(), rig.servo().state()), ("AL303".to_owned(), State::Fault));
}

#[test]
fn without_a_position_of_the_host_a_sync_moves_nothing() {
    let mut rig = Rig::full();
    rig.set(0x6081, 0, 10 * REV);
    rig.enable(Mode::ProfilePosition);
    travel(&mut rig, 2 * REV, 0x10);
    rig.pass(millis(1000));
    rig.start();
    rig.set(0x6060, 0, 7);
    rig.pass(millis(5));
    for _ in 0..10 {
        rig.sync();
        rig.pass(millis(1));
    }
    assert_eq!((rig.position(), rig.status() & BIT_12), (2 * REV as i32, 0));
    assert!(rig.servo().alarms().is_empty());
}

#[test]
fn a_sync_that_comes_too_early_is_al302_where_it_is_wanted() {
    for wanted in [false, true] {
        let config = Config { early_sync_alarm: wanted, ..Config::new(NODE) };
        let mut rig = Rig::with(config, Quirks::default());
        rig.set(0x60C2, 1, 4);
        rig.start();
        rig.enable(Mode::InterpolatedPosition);
        rig.set(0x60C1, 1, 0);
        for wait in [4, 4, 3, 4] {
            rig.sync();
            rig.pass(millis(wait));
        }
        assert_eq!(rig.servo().panel().to_string() == "AL302", wanted);
    }
}

#[test]
fn a_sync_period_that_is_not_valid_is_al305_and_a_jump_is_al304() {
    let mut rig = in_ip(Level::Half, 2);
    rig.set(0x1006, 0, 1500);
    rig.sync();
    assert_eq!(rig.servo().panel().to_string(), "AL305");
    let mut rig = in_ip(Level::Full, 2);
    rig.set(0x60C1, 1, 50 * REV);
    rig.sync();
    assert_eq!(rig.servo().panel().to_string(), "AL304");
}
