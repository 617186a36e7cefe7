//! The shaft under load: how it falls behind, what it draws, and that it comes back.

use proptest::prelude::*;

use super::*;

const ENABLED: State = State::OperationEnabled(Motor::InControl);

fn measured(rig: &Rig) -> Measured {
    rig.drive.measured()
}

fn fast(rpm: u16) -> Rig {
    let mut rig = Rig::with(Model::Ag03_1, defaults().with_v_pos(rpm).with_a_pos(100));
    rig.stw(0x003b);
    rig
}

#[test]
fn without_load_the_shaft_is_exactly_on_the_profile() {
    for rpm in [1, 30, 100] {
        let mut rig = fast(rpm);
        rig.travel(3000);
        let mut profile = rig.drive.motion.clone();
        while rig.state() == State::TravelActive {
            assert!(!rig.status().lag_error);
            assert_eq!(rig.drive.shaft_position(), profile.position());
            rig.run(1);
            profile.advance(super::super::lapse::Lapse::of(MILLISECOND));
        }
        assert_eq!(rig.position(), 3000);
    }
}

#[test]
fn current_is_idle_current_load_and_acceleration() {
    let mut rig = fast(100);
    rig.travel(50_000).run(100);
    assert_eq!(measured(&rig).current, 600, "0.1 A idle, 0.5 A for 100 % acceleration");
    rig.run(1000);
    assert_eq!(measured(&rig).current, 100);
    rig.inputs(|inputs| inputs.friction_torque = 2.0);
    assert_eq!(measured(&rig).current, 1100, "2 Nm take 1 A with 48:1");
    rig.inputs(|inputs| inputs.load_torque = 1.0);
    assert_eq!(measured(&rig).current, 1600, "the load hinders the counter-clockwise turn");
    rig.inputs(|inputs| inputs.load_torque = -1.0);
    assert_eq!(measured(&rig).current, 600, "and helps it");
}

#[test]
fn the_24_to_1_gear_has_half_the_torque() {
    let config = Config::default();
    let mut rig = Rig::made(Model::Ag03, Gear::Ratio24, defaults().with_v_pos(200), config);
    rig.stw(0x003b).travel(90_000).run(3000);
    assert_eq!(rig.status().velocity, 200);
    rig.inputs(|inputs| inputs.friction_torque = 1.0);
    assert_eq!(measured(&rig).current, 1100);
}

#[test]
fn a_load_above_the_available_torque_slows_the_shaft_until_c_comes() {
    let mut rig = fast(100);
    rig.travel(500_000).run(1000);
    rig.inputs(|inputs| inputs.friction_torque = 5.0).run(1000);
    let status = rig.status();
    assert!((30..=50).contains(&status.velocity), "{} rpm", status.velocity);
    assert!(status.lag_error && status.current_out_of_range && status.warning, "{status:?}");
    assert_eq!(rig.state(), State::TravelActive, "a warning does not influence the operation");
    rig.run(4000);
    assert_eq!((rig.state(), rig.status().fault), (State::Fault, Some(Fault::C)));
}

#[test]
fn a_shaft_freed_in_time_catches_up_and_ends_at_its_target_without_overshoot() {
    let mut rig = fast(100);
    rig.travel(8000).run(1000);
    rig.inputs(|inputs| inputs.friction_torque = 5.0).run(1500);
    assert!(rig.status().lag_error);
    rig.inputs(|inputs| inputs.friction_torque = 0.0).run(2000);
    assert!(!rig.status().lag_error && !rig.status().warning);
    while rig.state() == State::TravelActive {
        assert!(rig.position() <= 8000);
        rig.run(1);
    }
    assert_eq!((rig.state(), rig.position()), (ENABLED, 8000));
}

#[test]
fn a_freed_shaft_goes_no_faster_than_v_pos() {
    let mut rig = fast(90);
    rig.travel(8000).run(1000);
    rig.inputs(|inputs| inputs.friction_torque = 5.0).run(1500);
    rig.inputs(|inputs| inputs.friction_torque = 0.0);
    let mut top = 0;
    while rig.state() == State::TravelActive {
        rig.run(1);
        top = top.max(rig.status().velocity);
    }
    assert_eq!(top, 90, "manual chapter 6, no. 5: maximum speed in positioning mode");
}

#[test]
fn a_blocked_shaft_stands_at_once_and_b_follows_the_lag_error() {
    for (rpm, target) in [(100, 50_000), (1, 50_000), (30, 3)] {
        let mut rig = fast(rpm);
        if target > 3 {
            rig.travel(target).run(1000);
        }
        let place = rig.inputs(|inputs| inputs.blocked = true).position();
        if target == 3 {
            rig.travel(target);
        }
        rig.run(110);
        assert!(rig.status().lag_error, "{rpm}");
        assert_eq!((rig.state(), rig.status().velocity, rig.position()), (State::TravelActive, 0, place));
        rig.run(600);
        assert_eq!(rig.status().fault, Some(Fault::B), "{rpm}");
        assert_eq!(rig.position(), place);
    }
}

#[test]
fn a_blocked_shaft_in_velocity_mode_does_not_make_up_for_the_way_it_lost() {
    let mut rig = Rig::with(Model::Ag03_1, defaults().with_mode(Mode::Velocity));
    rig.setpoint = 60;
    rig.stw(0x004b).run(1000);
    let place = rig.inputs(|inputs| inputs.blocked = true).run(300).position();
    rig.inputs(|inputs| inputs.blocked = false);
    for _ in 0..2000 {
        rig.run(1);
        assert!(rig.status().velocity <= 60);
    }
    assert_eq!(rig.status().velocity, 60);
    assert!(!rig.status().lag_error && rig.position() > place);
}

#[test]
fn a_low_supply_limits_speed_and_torque() {
    let mut rig = fast(100);
    rig.inputs(|inputs| inputs.output_supply = 19.0).travel(500_000).run(1000);
    assert_eq!(rig.status().velocity, 100, "without load it is enough");
    rig.inputs(|inputs| inputs.friction_torque = 3.0).run(2000);
    let velocity = rig.status().velocity;
    assert!((70..80).contains(&velocity), "19 V - 1.6 A * 8 ohm leave 77.5 rpm, not {velocity}");
    assert_eq!(rig.state(), State::TravelActive);
}

#[test]
fn holding_a_load_takes_current_and_the_other_inpos_modes_take_none() {
    for (inpos, current) in [(Motor::InControl, 1500), (Motor::Shorted, 0), (Motor::Released, 0)] {
        let mut rig = Rig::with(Model::Ag03_1, defaults().with_inpos(inpos));
        rig.stw(0x003b).inputs(|inputs| inputs.load_torque = -3.0).travel(100);
        rig.until(State::OperationEnabled(inpos));
        rig.run(10);
        assert_eq!(measured(&rig).current, current, "{inpos:?}");
        assert_eq!(rig.position(), 100, "the gear holds it");
    }
}

#[test]
fn the_output_stage_warms_with_the_current_and_cools_again() {
    let mut rig = fast(100);
    assert_eq!(measured(&rig).temperature, 250);
    rig.inputs(|inputs| inputs.friction_torque = 3.8).travel(500_000).run(60_000);
    assert_eq!(measured(&rig).temperature, 650, "25 degC and 10 K/A^2 at 2 A");
    rig.stw(0x0000).run(60_000);
    assert_eq!(measured(&rig).temperature, 250);
}

#[test]
fn a_hanging_weight_on_its_way_down_raises_the_intermediate_circuit() {
    let mut rig = fast(100);
    rig.inputs(|inputs| inputs.load_torque = -3.0).travel(500_000).run(3000);
    let volts = measured(&rig).dc_link;
    assert!((310..330).contains(&volts), "24 V + 0.25 V/W * 31.4 W, not {volts}");
    assert_eq!(measured(&rig).output_supply, 240);
    rig.stw(0x0033).run(5000);
    assert_eq!(measured(&rig).dc_link, 240);
}

#[test]
fn braking_alone_raises_the_intermediate_circuit_a_little() {
    let mut rig = fast(100);
    rig.travel(50_000).run(1000).stw(0x006b).run(200);
    let volts = measured(&rig).dc_link;
    assert!((241..270).contains(&volts), "{volts}");
}

#[test]
fn an_idle_drive_parks_within_a_bounded_time_after_any_load() {
    let mut rig = fast(100);
    rig.inputs(|inputs| inputs.friction_torque = 4.0).travel(8000).run(20_000);
    rig.inputs(|inputs| inputs.friction_torque = 0.0);
    assert_eq!(rig.state(), ENABLED);
    let mut cycles = 0;
    while !rig.drive.is_at_rest() {
        rig.run(1);
        cycles += 1;
        assert!(cycles < 60_000, "60 s");
    }
}

#[test]
fn the_position_jumps_at_the_end_of_the_encoder_and_no_travel_leads_there() {
    let constants = plant::Constants { encoder_revolutions: 10.0, ..plant::Constants::DEFAULT };
    let limits = Limits::new(0, 0);
    let config = Config { constants, ..Config::default() };
    let mut rig = Rig::made(Model::Ag03_1, Gear::Ratio48, defaults().with_limits(limits), config);
    rig.stw(0x003b).travel(8001);
    assert_eq!(
        rig.refusal_text(),
        "travel to 8001 inc refused: the travel would leave the range of the absolute encoder"
    );
    rig.stw(0x023b);
    let mut last = rig.position();
    let jump = loop {
        rig.run(1);
        if rig.position() < last {
            break rig.position() - last;
        }
        last = rig.position();
    };
    assert!((-16_000..=-15_998).contains(&jump), "{last} to {}", rig.position());
    assert!((7999..=8000).contains(&last));
    assert_eq!(rig.run(1000).status().velocity, 30, "the shaft turns on");
    rig.stw(0x003b).until(ENABLED);
    rig.travel(-7000);
    rig.until(ENABLED);
    assert_eq!(rig.position(), -7000);
}

#[test]
fn inching_over_the_end_of_the_encoder_ends_in_its_window() {
    let constants = plant::Constants { encoder_revolutions: 1.0, ..plant::Constants::DEFAULT };
    let limits = Limits::new(0, 0);
    let config = Config { constants, ..Config::default() };
    let mut rig = Rig::made(Model::Ag03, Gear::Ratio48, defaults().with_limits(limits), config);
    rig.stw(0x000b).stw(0x010b);
    rig.until(ENABLED);
    assert_eq!(rig.position(), 0, "one turn of an encoder of one turn");
    assert!(rig.status().target_reached);
}

fn stopped_by(stw: u16) -> (i32, u32) {
    let mut rig = fast(100);
    rig.travel(50_000).run(1000);
    rig.inputs(|inputs| inputs.friction_torque = 5.0).run(500);
    rig.stw(stw);
    let place = rig.position();
    let mut cycles = 0;
    while rig.status().moving {
        rig.run(1);
        cycles += 1;
        assert!(cycles < 5000);
    }
    (rig.position() - place, cycles)
}

#[test]
fn a_shaft_that_lags_stops_from_where_it_is() {
    for stw in [0x006b, 0x0073, 0x005b] {
        let (way, cycles) = stopped_by(stw);
        assert!((0..400).contains(&way) && cycles < 500, "{stw:04x}: {way} in {cycles} ms");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_the_load_does_for_a_while_the_target_is_reached_and_never_passed(
        target in -3000..3000i32, rpm in 5..=100u16, percent in 1..=100u16, reversed in any::<bool>(),
        loads in prop::collection::vec((0.0..5.9f64, -4.0..4.0f64, 14.0..40.0f64, 1..300u32), 0..5),
        millis in 5..=50u64,
    ) {
        let sense = if reversed { SenseOfRotation::E } else { SenseOfRotation::I };
        let settings = defaults().with_v_pos(rpm).with_a_pos(percent).with_sense(sense);
        let mut rig = Rig::with(Model::Ag03_1, settings);
        rig.stw(0x003b);
        rig.travel(target);
        let command = command(0x007b, Some(0x007b), target);
        let dt = Duration::from_millis(millis);
        for (friction, load, supply, cycles) in loads {
            rig.drive.set_inputs(Inputs {
                friction_torque: friction, load_torque: load, output_supply: supply, ..Inputs::default()
            });
            for _ in 0..cycles {
                rig.drive.step(dt, &command, &settings);
                let past = (rig.position() - target) * target.signum();
                // A fault lets it run out.
                prop_assert!(past <= 0 || rig.state() == State::Fault, "passed by {}", past);
            }
        }
        rig.drive.set_inputs(Inputs::default());
        let faulted = rig.state() == State::Fault || !rig.drive.causes().is_empty();
        let mut steps = 0;
        while rig.state() == State::TravelActive && !faulted {
            rig.drive.step(dt, &command, &settings);
            prop_assert!((rig.position() - target) * target.signum() <= 0);
            steps += 1;
            prop_assert!(steps < 400_000);
        }
        if rig.state() != State::Fault && !faulted {
            prop_assert_eq!(rig.position(), target);
        }
    }
}
