//! Times and ways of travels, ramps and stops against closed formulas, through the whole drive.

use proptest::prelude::*;

use super::*;

/// Ramp time in s and way in increments from or to `rpm` at `percent` (`ag03.md` 9).
fn ramp(rpm: f64, percent: f64) -> (f64, f64) {
    let (speed, acceleration) = (rpm / 60.0 * 1600.0, percent / 100.0 * 4.0 * 1600.0);
    (speed / acceleration, speed * speed / (2.0 * acceleration))
}

/// Time in s of a travel over `way` increments from rest to rest.
fn travel_time(way: f64, rpm: f64, up: f64, down: f64) -> f64 {
    let ((up_time, up_way), (down_time, down_way)) = (ramp(rpm, up), ramp(rpm, down));
    if way >= up_way + down_way {
        return up_time + down_time + (way - up_way - down_way) / (rpm / 60.0 * 1600.0);
    }
    let (a, d) = (up * 64.0, down * 64.0);
    let peak = (2.0 * way * a * d / (a + d)).sqrt();
    peak / a + peak / d
}

fn scaled(pitch: u16, numerator: u16, denominator: u16, reversed: bool) -> Settings {
    defaults()
        .with_spindle_pitch(pitch)
        .with_gear_numerator(numerator)
        .with_gear_denominator(denominator)
        .with_sense(if reversed { SenseOfRotation::E } else { SenseOfRotation::I })
        .with_limits(Limits::new(0, 0))
}

/// Increments of the shaft for `units`.
fn increments(units: i32, settings: &Settings) -> f64 {
    let unit = if settings.word(Parameter::SpindlePitch) == 0 {
        1600.0
    } else {
        f64::from(settings.word(Parameter::SpindlePitch))
    };
    f64::from(units).abs() * 1600.0 * f64::from(settings.word(Parameter::GearNumerator))
        / (unit * f64::from(settings.word(Parameter::GearDenominator)))
}

fn with_gear(settings: Settings, gear: Gear) -> Rig {
    Rig::made(Model::Ag03_1, gear, settings, Config::default())
}

/// Cycles until the shaft stands.
fn cycles(rig: &mut Rig) -> f64 {
    let mut cycles = 0;
    while rig.status().moving {
        rig.run(1);
        cycles += 1;
    }
    f64::from(cycles)
}

/// Each documented way to stop: STW, deceleration in %, and whether the motor is released.
const STOPS: [(&str, u16, Option<f64>, bool); 6] = [
    ("stop, STW.4 = 0", 0x006b, Some(100.0), false),
    ("intermediate stop, STW.5 = 0", 0x005b, None, false),
    ("disable, STW.3 = 0", 0x0073, Some(100.0), false),
    ("OFF1", 0x007a, Some(25.0), true),
    ("OFF2", 0x0079, Some(25.0), true),
    ("STW 0000", 0x0000, Some(25.0), true),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_travel_takes_the_time_of_the_closed_formula_in_any_unit(
        up in 1..=100u16, down in prop::option::of(1..=100u16), rpm in 1..=200u16, units in -3000..=3000i32,
        pitch in prop_oneof![Just(0u16), 50..=1000u16], numerator in 1..=20u16, denominator in 1..=20u16,
        reversed in any::<bool>(), wide in any::<bool>(),
    ) {
        let gear = if wide { Gear::Ratio24 } else { Gear::Ratio48 };
        let rpm = rpm.min(gear.max_rpm());
        let scale = scaled(pitch, numerator, denominator, reversed);
        let settings = scale.with_a_pos(up).with_d_pos(down).with_v_pos(rpm);
        let way = increments(units, &settings);
        let expected = travel_time(way, f64::from(rpm), f64::from(up), f64::from(down.unwrap_or(up)));
        prop_assume!(expected < 10.0);
        let mut rig = with_gear(settings, gear);
        rig.stw(0x003b).travel(units);
        let millis = cycles(&mut rig) + 1.0;
        if units != 0 {
            prop_assert!((millis - expected * 1000.0).abs() <= 1.0 + 1e-6, "{} ms, {} s", millis, expected);
        }
        prop_assert_eq!(rig.position(), units);
        prop_assert!((rig.drive.shaft_position().abs() - way).abs() < 1e-3);
        prop_assert!(rig.status().target_reached);
    }

    #[test]
    fn each_way_to_stop_takes_the_time_and_way_of_its_ramp(
        which in 0..STOPS.len(), rpm in 2..=200u16, up in 20..=100u16, down in prop::option::of(5..=100u16),
        reversed in any::<bool>(), positive in any::<bool>(),
    ) {
        let (name, stw, deceleration, released) = STOPS[which];
        let settings = scaled(0, 1, 1, reversed).with_a_pos(up).with_d_pos(down).with_v_pos(rpm);
        let mut rig = with_gear(settings, Gear::Ratio24);
        rig.stw(0x003b).travel(if positive { 5_000_000 } else { -5_000_000 }).run(5000);
        let from = rig.drive.shaft_position();
        rig.stw(stw);
        let millis = cycles(&mut rig) + 1.0;
        let (time, way) = ramp(f64::from(rpm), deceleration.unwrap_or(f64::from(down.unwrap_or(up))));
        prop_assert!((millis - time * 1000.0).abs() <= 1.0 + 1e-6, "{}: {} ms, {} s", name, millis, time);
        prop_assert!(((rig.drive.shaft_position() - from).abs() - way).abs() < 1e-6, "{}", name);
        prop_assert_eq!(rig.status().motor == Motor::Released, released, "{}", name);
    }

    #[test]
    fn velocity_ramps_take_the_time_and_way_of_a_rot(
        rpm in prop_oneof![-200..=-1i32, 1..=200i32], percent in 1..=100u16, reversed in any::<bool>(),
    ) {
        let settings = scaled(0, 1, 1, reversed).with_mode(Mode::Velocity).with_a_rot(percent);
        let mut rig = with_gear(settings, Gear::Ratio24);
        rig.setpoint = rpm;
        rig.stw(0x000b).stw(0x004b);
        let (time, way) = ramp(f64::from(rpm.abs()), f64::from(percent));
        let mut millis = 1.0;
        while rig.status().velocity != rpm || rig.drive.motion.velocity().abs() < f64::from(rpm.abs()) / 60.0 * 1600.0 - 1e-6 {
            rig.run(1);
            millis += 1.0;
            prop_assert!(millis < time * 1000.0 + 2.0);
        }
        prop_assert!((millis - time * 1000.0).abs() <= 1.0 + 1e-6);
        let from = rig.drive.shaft_position();
        rig.stw(0x000b);
        let millis = cycles(&mut rig) + 1.0;
        prop_assert!((millis - time * 1000.0).abs() <= 1.0 + 1e-6, "{} ms", millis);
        prop_assert!(((rig.drive.shaft_position() - from).abs() - way).abs() < 1e-6);
    }
}

#[test]
fn every_other_documented_way_to_stop_is_one_of_the_ramps() {
    // what is done to a drive that travels at 30 rpm with 50 %, milliseconds until it stands, state then
    type Way = (&'static str, fn(&mut Rig), u32, State);
    let released = State::ReadyToRun(Motor::Released);
    let ways: [Way; 6] = [
        ("output stage supply lost", |rig| _ = rig.output_stage(false), 500, State::NotReady),
        ("power failure", |rig| _ = rig.inputs(|inputs| inputs.control_supply = 0.0), 500, State::Off),
        ("fault", |rig| _ = rig.causes([Fault::F]), 500, State::Fault),
        (
            "Data_Exchange left",
            |rig| {
                rig.connected = false;
                rig.run(1);
            },
            500,
            released,
        ),
        (
            "torque deactivation",
            |rig| {
                rig.settings = rig.settings.with_torque_deactivation(Some(50));
                rig.inputs(|inputs| inputs.friction_torque = 3.0).run(1);
            },
            125,
            State::Pausing { torque_tripped: true },
        ),
        ("blocked shaft", |rig| _ = rig.inputs(|inputs| inputs.blocked = true), 0, State::TravelActive),
    ];
    for (name, stop, millis, state) in ways {
        let mut rig = Rig::travelling(100_000);
        stop(&mut rig);
        let mut count = 1;
        while rig.status().velocity != 0 {
            rig.run(1);
            count += 1;
        }
        assert_eq!(rig.state(), state, "{name}");
        // The last rpm, rounded to none, takes up to half of 33 ms.
        assert!(count <= millis + 1 && count + 20 > millis, "{name}: {count} ms");
    }
    let mut rig = Rig::with(Model::Ag03, defaults());
    rig.stw(0x003b).travel(100_000).run(500).output_stage(false);
    assert_eq!(rig.state(), State::OperationEnabled(Motor::Released), "enable input of an AG03");
    assert!((470.0..=500.0).contains(&cycles(&mut rig)));
}
