//! Random masters, plants and settings.

use proptest::prelude::*;

use super::words::assert_invariants;
use super::*;

#[derive(Clone, Debug)]
struct Act {
    stw: u16,
    setpoint: i32,
    connected: bool,
    inputs: Option<Inputs>,
    settings: Option<Settings>,
    micros: u64,
    steps: u8,
    calibrate: Option<i32>,
}

/// Mostly control words that get somewhere.
fn stw() -> impl Strategy<Value = u16> {
    prop_oneof![
        6 => prop::sample::select(std::vec![
            0x0000u16, 0x000b, 0x003b, 0x007b, 0x005b, 0x006b, 0x0073, 0x007a, 0x0079, 0x00bb, 0x010b, 0x020b,
            0x820b, 0x004b, 0x000a, 0x001b,
        ]),
        1 => any::<u16>(),
    ]
}

fn inputs() -> impl Strategy<Value = Inputs> {
    let mostly = |nominal: f64| prop_oneof![6 => Just(nominal), 1 => 0.0..60.0f64, 1 => any::<f64>()];
    let rarely = || prop::bool::weighted(0.05);
    let load = || prop_oneof![4 => Just(0.0), 4 => -8.0..8.0f64, 1 => any::<f64>()];
    let forced = || prop::option::weighted(0.1, prop_oneof![0.0..120.0f64, any::<f64>()]);
    (
        (mostly(24.0), mostly(24.0), prop::bool::weighted(0.9), mostly(3.0)),
        (load(), load(), rarely(), mostly(25.0), forced(), forced()),
        (rarely(), rarely(), any::<bool>(), any::<bool>()),
    )
        .prop_map(|(supply, load, rest)| Inputs {
            control_supply: supply.0,
            output_supply: supply.1,
            enable_input: supply.2,
            battery: supply.3,
            load_torque: load.0,
            friction_torque: load.1,
            blocked: load.2,
            ambient: load.3,
            stage_temperature: load.4,
            dc_link: load.5,
            encoder_fault: rest.0,
            internal_fault: rest.1,
            key_clockwise: rest.2,
            key_counter_clockwise: rest.3,
        })
}

/// Settings inside and outside the ranges of the store.
fn settings() -> impl Strategy<Value = Settings> {
    let percent = || prop_oneof![4 => 1..=100u16, 1 => any::<u16>()];
    let mode = prop::sample::select(std::vec![Mode::Positioning, Mode::Velocity]);
    let sense = prop::sample::select(std::vec![SenseOfRotation::I, SenseOfRotation::E]);
    let pos_type = prop::sample::select(std::vec![PosType::Direct, PosType::LoopPlus, PosType::LoopMinus]);
    let inpos = prop::sample::select(std::vec![Motor::InControl, Motor::Shorted, Motor::Released]);
    let stop = prop::sample::select(std::vec![StopMode::Maximum, StopMode::Ramp]);
    let limit = || prop_oneof![Just(1_000_000), Just(0), -9_999_999..9_999_999i32, any::<i32>()];
    let small = || prop_oneof![Just(0u16), Just(1), any::<u16>()];
    (
        (mode, percent(), percent(), prop::option::of(percent()), percent(), percent(), percent(), percent()),
        (small(), small(), small(), small(), small(), sense, pos_type),
        (limit(), limit(), any::<i32>(), stop, inpos, prop::option::of(20..125u16)),
    )
        .prop_map(|(dynamics, scale, rest)| {
            let (mode, a_pos, v_pos, d_pos, a_rot, a_inch, v_inch, offset_inch_2) = dynamics;
            let (window, gear_numerator, gear_denominator, spindle_pitch, loop_length, sense, pos_type) =
                scale;
            let (limit_1, limit_2, delta_inch, stop_mode_inch_2, inpos, torque_deactivation) = rest;
            defaults()
                .with_mode(mode)
                .with_a_pos(a_pos)
                .with_v_pos(v_pos)
                .with_d_pos(d_pos)
                .with_a_rot(a_rot)
                .with_a_inch(a_inch)
                .with_v_inch(v_inch)
                .with_offset_inch_2(offset_inch_2)
                .with_window(window)
                .with_gear_numerator(gear_numerator)
                .with_gear_denominator(gear_denominator)
                .with_spindle_pitch(spindle_pitch)
                .with_sense(sense)
                .with_pos_type(pos_type)
                .with_limits(Limits::new(limit_1, limit_2))
                .with_delta_inch(delta_inch)
                .with_stop_mode_inch_2(stop_mode_inch_2)
                .with_inpos(inpos)
                .with_loop_length(loop_length)
                .with_torque_deactivation(torque_deactivation)
        })
}

fn act() -> impl Strategy<Value = Act> {
    let setpoint = prop_oneof![-5000..5000i32, -200..200i32, any::<i32>()];
    (
        stw(),
        setpoint,
        prop::bool::weighted(0.9),
        prop::option::weighted(0.2, inputs()),
        prop::option::weighted(0.1, settings()),
        100..=100_000u64,
        1..40u8,
        prop::option::weighted(0.05, any::<i32>()),
    )
        .prop_map(|(stw, setpoint, connected, inputs, settings, micros, steps, calibrate)| Act {
            stw,
            setpoint,
            connected,
            inputs,
            settings,
            micros,
            steps,
            calibrate,
        })
}

proptest! {
    #[test]
    fn no_master_plant_or_setting_breaks_the_invariants(
        ag03 in any::<bool>(), wide in any::<bool>(), acts in prop::collection::vec(act(), 1..60),
    ) {
        let model = if ag03 { Model::Ag03 } else { Model::Ag03_1 };
        let gear = if wide { Gear::Ratio24 } else { Gear::Ratio48 };
        let mut settings = defaults();
        let mut drive = Drive::new(model, gear, &settings);
        let mut last = 0;
        for act in acts {
            settings = act.settings.unwrap_or(settings);
            if let Some(inputs) = act.inputs {
                drive.set_inputs(inputs);
            }
            if let Some(value) = act.calibrate {
                let job = drive.status().job_active;
                prop_assert_eq!(drive.calibrate(value).is_err(), job);
            }
            let stw = if act.connected { act.stw } else { 0 };
            let word = act.connected.then_some(act.stw);
            for _ in 0..act.steps {
                let before = drive.clone();
                let command = command(last, word, act.setpoint);
                last = stw;
                drive.step(Duration::from_micros(act.micros), &command, &settings);
                let status = drive.status();
                assert_invariants(&before.status(), &status, stw);
                prop_assert!(drive.motion.position().is_finite() && drive.motion.velocity().is_finite());
                prop_assert!(status.velocity.abs() <= 200);
                if let Some(refusal) = drive.take_refusal() {
                    prop_assert!(refusal.reasons().count() > 0 && refusal.to_string().contains(" refused: "));
                }
                if drive.is_at_rest() {
                    let mut next = drive.clone();
                    next.step(Duration::from_micros(act.micros), &command, &settings);
                    prop_assert_eq!(&next, &drive, "at rest, but a step changes something");
                }
            }
        }
    }

    #[test]
    fn every_undisturbed_job_ends_at_its_setpoint(
        start in -300_000..=300_000i32, setpoint in -300_000..=300_000i32, millis in 1..=100u64,
        pitch in prop_oneof![Just(0u16), 100..=1000u16], loops in 0..3usize, reversed in any::<bool>(),
    ) {
        let settings = defaults().with_spindle_pitch(pitch).with_pos_type([PosType::Direct, PosType::LoopPlus, PosType::LoopMinus][loops]).with_sense(if reversed { SenseOfRotation::E } else { SenseOfRotation::I }).with_limits(Limits::new(0, 0)).with_v_pos(200);
        let dt = Duration::from_millis(millis);
        let mut drive = Drive::new(Model::Ag03_1, Gear::Ratio24, &settings);
        drive.calibrate(start).unwrap();
        drive.step(dt, &command(0, Some(0x003b), 0), &settings);
        drive.step(dt, &command(0x003b, Some(0x007b), setpoint), &settings);
        let mut steps = 0;
        while !drive.is_at_rest() {
            drive.step(dt, &command(0x007b, Some(0x007b), setpoint), &settings);
            steps += 1;
            prop_assert!(steps < 3_000_000);
        }
        prop_assert_eq!(drive.status().position, setpoint);
        prop_assert!(drive.status().target_reached && drive.status().jobs == 1);
    }
}

#[test]
fn a_drive_is_small() {
    assert!(size_of::<Drive>() < 1200, "{} bytes", size_of::<Drive>());
}
