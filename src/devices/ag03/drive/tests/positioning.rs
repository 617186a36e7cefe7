//! Rows 20-36.

use super::*;

const ENABLED: State = State::OperationEnabled(Motor::InControl);

#[test]
fn row_20_either_edge_of_start_begins_a_job_and_toggles_the_acknowledge_bit() {
    let mut rig = Rig::enabled();
    for (setpoint, acknowledge) in [(1600, true), (-1600, false), (0, true)] {
        rig.travel(setpoint);
        assert_eq!((rig.state(), rig.status().jobs & 1 != 0), (State::TravelActive, acknowledge));
        assert!(rig.status().positioning_active && !rig.status().target_reached);
        rig.until(ENABLED);
        assert_eq!(rig.position(), setpoint);
    }
}

#[test]
fn row_20_a_v_and_d_are_latched_when_the_job_starts() {
    let mut rig = Rig::enabled();
    rig.travel(1600);
    rig.settings = rig.settings.with_a_pos(1);
    rig.settings = rig.settings.with_v_pos(100);
    rig.settings = rig.settings.with_d_pos(Some(1));
    assert_eq!(rig.until(ENABLED), 2250 - 1);
}

#[test]
fn row_20_travels_take_the_time_of_the_closed_formula() {
    for (setpoint, cycles) in [(1600, 2250), (16_000, 20_250), (-48_000, 60_250)] {
        let mut rig = Rig::enabled();
        rig.travel(setpoint);
        let taken = rig.until(ENABLED) + 1;
        assert!(taken.abs_diff(cycles) <= 1, "{taken} for {cycles}");
        assert_eq!((rig.position(), rig.status().target_reached), (setpoint, true));
    }
}

#[test]
fn row_20_d_pos_brakes_otherwise_than_a_pos_accelerates() {
    let mut rig = Rig::enabled();
    rig.settings = rig.settings.with_d_pos(Some(100));
    rig.travel(1600);
    // 0.25 s, 100 increments up; 0.125 s, 50 increments down; 1450 increments at 800/s
    assert_eq!(rig.until(ENABLED) + 1, 250 + 125 + 1813);
}

#[test]
fn row_20_positions_are_scaled_by_pitch_gear_and_sense() {
    let settings = defaults().with_spindle_pitch(200).with_gear_numerator(5).with_sense(SenseOfRotation::E);
    let mut rig = Rig::with(Model::Ag03_1, settings).calibrated(-77);
    rig.stw(0x003b).travel(-117).run(1000);
    assert_eq!(rig.status().velocity, -30);
    // 40/100 mm behind 5:1 and 2 mm per revolution are one revolution
    assert_eq!(rig.until(ENABLED) + 1 + 1000, 2250);
    assert_eq!(rig.position(), -117);
}

#[test]
fn row_20_without_limits_any_setpoint_the_encoder_can_tell_is_accepted() {
    let mut rig = Rig::enabled();
    rig.settings = rig.settings.with_limits(Limits::new(0, 0));
    assert_eq!(rig.travel(i32::MAX).reasons(), [Reason::BeyondEncoder]);
    assert_eq!(rig.travel(52_000_000).state(), State::TravelActive);
}

#[test]
fn row_21_each_missing_condition_refuses_the_job_and_says_why() {
    let refused = |rig: &mut Rig, setpoint: i32, text: &str| {
        let before = rig.status();
        rig.travel(setpoint);
        assert_eq!(rig.refusal_text(), std::format!("travel to {setpoint} inc refused: {text}"));
        assert_eq!(rig.status().jobs, before.jobs);
        assert_eq!((rig.status().moving, rig.status().state), (false, before.state));
        assert_eq!(rig.run(3).drive.take_refusal(), None, "each edge reports once");
    };
    refused(&mut Rig::enabled(), 1_200_000, "setpoint is above the upper limit (1000000 inc)");
    refused(&mut Rig::enabled(), -1_000_001, "setpoint is below the lower limit (-1000000 inc)");
    refused(Rig::enabled().stw(0x002b), 5, "stop is given");
    refused(Rig::enabled().stw(0x001b), 5, "intermediate stop is given");
    refused(Rig::enabled().stw(0x000b), 5, "stop is given; intermediate stop is given");
    refused(
        &mut Rig::enabled().calibrated(1_000_250),
        5,
        "actual position 1000250 inc is above the upper limit (1000000 inc): \
         only inching in negative direction is possible",
    );
    refused(
        &mut Rig::enabled().calibrated(-1_000_250),
        5,
        "actual position -1000250 inc is below the lower limit (-1000000 inc): \
         only inching in positive direction is possible",
    );
    refused(
        &mut Rig::new(Model::Ag03_1),
        5,
        "operation is not asked for; operation is not enabled; \
         stop is given; intermediate stop is given",
    );
}

#[test]
fn row_21_an_edge_together_with_enabling_comes_too_early() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.setpoint = 1600;
    rig.stw(0x007b);
    assert_eq!((rig.state(), rig.reasons()), (ENABLED, [Reason::NotEnabled].to_vec()));
    assert_eq!(rig.run(5).state(), ENABLED);
}

#[test]
fn row_21_start_held_over_a_change_of_mode_must_be_taken_back() {
    let mut rig = Rig::enabled();
    rig.settings = rig.settings.with_mode(Mode::Velocity);
    rig.run(1);
    rig.stw = 0x007b;
    rig.run(1);
    assert_eq!(rig.state(), State::VelocityTravelling);
    rig.settings = rig.settings.with_mode(Mode::Positioning);
    assert_eq!(rig.run(1).state(), ENABLED);
    assert_eq!(rig.travel(1600).reasons(), [Reason::StartHeld]);
    assert_eq!(rig.travel(1600).state(), State::TravelActive);
}

#[test]
fn row_22_an_edge_during_the_job_is_ignored() {
    let mut rig = Rig::travelling(16_000);
    let before = rig.status();
    rig.travel(-500);
    assert_eq!((rig.state(), rig.status().jobs), (State::TravelActive, before.jobs));
    assert_eq!(rig.reasons(), [Reason::JobActive]);
    rig.until(ENABLED);
    assert_eq!(rig.position(), 16_000);
}

#[test]
fn row_23_the_end_of_the_job_is_reported_and_inpos_mode_acts() {
    for (inpos, released) in [(Motor::InControl, false), (Motor::Shorted, false), (Motor::Released, true)] {
        let mut rig = Rig::enabled();
        rig.settings = rig.settings.with_inpos(inpos);
        rig.travel(1600);
        rig.until(State::OperationEnabled(inpos));
        let status = rig.status();
        assert!(status.target_reached && status.standstill && status.ready_to_travel && status.in_window);
        assert!(!status.positioning_active && !status.moving);
        assert_eq!(status.motor == Motor::Released, released);
        assert_eq!(rig.travel(0).status().motor, Motor::InControl);
    }
}

#[test]
fn row_23_the_window_is_live_after_the_job() {
    let mut rig = Rig::enabled();
    rig.travel(1600);
    rig.until(ENABLED);
    rig.drive.calibrate(1611).unwrap();
    assert!(!rig.run(1).status().target_reached);
    rig.settings = rig.settings.with_window(11);
    assert!(rig.run(1).status().target_reached);
}

#[test]
fn row_24_intermediate_stop_brakes_and_keeps_the_job() {
    let mut rig = Rig::travelling(16_000);
    rig.stw(0x005b);
    assert_eq!(rig.state(), State::Pausing { torque_tripped: false });
    assert_eq!(rig.zsw() & 0xea7f, 0x0a37, "Table 12, bit 13");
    assert!(rig.status().positioning_active && rig.status().job_active && rig.status().travelling);
    rig.run(248);
    assert!(rig.status().moving);
    rig.run(1);
    assert!(!rig.status().moving, "30 rpm at 2 rev/s^2 take 250 ms");
    assert_eq!(rig.state(), State::Paused { torque_tripped: false });
    assert_eq!(rig.zsw() & 0xeb7f, 0xab37, "C-05");
    assert!(!rig.status().positioning_active && rig.status().job_active);
    assert_eq!((rig.position(), rig.status().motor), (300 + 100, Motor::InControl));
}

#[test]
fn row_25_taking_the_intermediate_stop_back_continues_to_the_same_target() {
    let mut rig = Rig::travelling(16_000);
    rig.stw(0x005b).run(1000);
    rig.setpoint = -5;
    rig.stw(0x007b);
    assert_eq!((rig.state(), rig.status().jobs), (State::TravelActive, 1));
    rig.until(ENABLED);
    assert_eq!(rig.position(), 16_000);
}

#[test]
fn row_25_pause_and_resume_anywhere_end_on_the_target_without_overshoot() {
    for pause_at in (0..2300).step_by(13) {
        for braking in [1, 100, 400] {
            let mut rig = Rig::enabled();
            rig.travel(1600).run(pause_at);
            rig.stw(0x005b).run(braking).stw(0x007b);
            for _ in 0..4000 {
                assert!(rig.run(1).position() <= 1600);
            }
            assert_eq!((rig.position(), rig.state()), (1600, ENABLED));
        }
    }
}

#[test]
fn row_25b_an_edge_during_the_intermediate_stop_is_ignored() {
    let mut rig = Rig::travelling(16_000);
    rig.stw(0x005b).travel(5);
    assert_eq!(rig.state(), State::Pausing { torque_tripped: false });
    assert_eq!(rig.reasons(), [Reason::IntermediateStop, Reason::JobPaused]);
    rig.stw(0x003b).until(ENABLED);
    assert_eq!(rig.position(), 16_000);
}

#[test]
fn row_26_stop_brakes_hard_and_discards_the_job() {
    let mut rig = Rig::travelling(16_000);
    rig.stw(0x006b);
    assert_eq!((rig.state(), rig.status().motor), (State::Stopping, Motor::InControl));
    assert_eq!(rig.travel(0).reasons(), [Reason::Stop, Reason::ShaftTurns]);
    assert_eq!(rig.until(ENABLED), 125 - 2);
    rig.stw(rig.stw | 0x0010).run(100);
    assert!(!rig.status().moving && !rig.status().target_reached);
    assert_eq!(rig.travel(0).state(), State::TravelActive);
}

#[test]
fn row_26_stop_discards_a_paused_job() {
    let mut rig = Rig::travelling(16_000);
    rig.stw(0x005b).run(1000).stw(0x004b);
    assert_eq!(rig.state(), ENABLED);
    assert!(!rig.stw(0x007b).run(10).status().moving);
}

fn tripped() -> Rig {
    let mut rig = Rig::travelling(16_000);
    rig.settings = rig.settings.with_torque_deactivation(Some(80));
    rig.inputs(|inputs| inputs.friction_torque = 3.19);
    assert_eq!(rig.state(), State::TravelActive);
    rig.inputs(|inputs| inputs.friction_torque = 3.21).inputs(|inputs| inputs.friction_torque = 0.0);
    assert_eq!(rig.state(), State::Pausing { torque_tripped: true });
    rig
}

#[test]
fn row_27_torque_deactivation_brakes_hard_without_a_fault_until_resumed() {
    let mut rig = tripped();
    assert!(rig.status().torque_tripped && rig.status().fault.is_none());
    assert_eq!(rig.status().motor, Motor::InControl);
    rig.run(123);
    assert!(rig.status().moving);
    assert!(!rig.run(1).status().moving);
    assert_eq!(rig.state(), State::Paused { torque_tripped: true });
    rig.stw(0x005b).stw(0x007b);
    assert_eq!((rig.state(), rig.status().torque_tripped), (State::TravelActive, false));
    rig.until(ENABLED);
    assert_eq!(rig.position(), 16_000);
}

#[test]
fn row_27_a_new_edge_starts_a_new_job_instead() {
    let mut rig = tripped();
    rig.run(200).travel(0);
    assert_eq!((rig.state(), rig.status().jobs), (State::TravelActive, 2));
    rig.until(ENABLED);
    assert_eq!(rig.position(), 0);
}

#[test]
fn row_27_is_off_without_a_threshold() {
    let mut rig = Rig::travelling(16_000);
    assert_eq!(rig.inputs(|inputs| inputs.friction_torque = 4.5).state(), State::TravelActive);
}

fn prepared() -> Rig {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.stw(0x000b);
    rig
}

#[test]
fn row_28_inching_1_travels_by_delta_inch() {
    let mut rig = prepared();
    rig.settings = rig.settings.with_delta_inch(-800);
    rig.stw(0x010b);
    assert_eq!(rig.state(), State::Inching(Inching::One));
    assert_eq!(rig.zsw() & 0xaa7f, 0x0a37);
    assert_eq!(rig.status().jobs, 0, "it is no travel job");
    rig.until(ENABLED);
    assert_eq!(rig.position(), -800);
}

#[test]
fn row_28_pos_type_does_not_matter_to_inching() {
    let mut rig = prepared();
    rig.settings = rig.settings.with_pos_type(PosType::LoopPlus);
    rig.settings = rig.settings.with_delta_inch(-800);
    rig.stw(0x010b);
    let cycles = rig.until(ENABLED);
    assert_eq!((rig.position(), cycles + 1), (-800, 250 + 250 + 750));
}

#[test]
fn row_29_the_end_shows_in_the_window_and_the_next_needs_a_new_edge() {
    let mut rig = prepared();
    rig.stw(0x010b).until(ENABLED);
    assert!(rig.status().in_window && rig.status().standstill);
    rig.run(100);
    assert_eq!((rig.state(), rig.position()), (ENABLED, 1600));
    rig.stw(0x000b).stw(0x010b).until(ENABLED);
    assert_eq!(rig.position(), 3200);
}

#[test]
fn row_30_taking_inching_1_back_brakes_with_a_inch() {
    let mut rig = prepared();
    rig.settings = rig.settings.with_a_inch(25);
    rig.stw(0x010b).run(599).stw(0x000b);
    assert_eq!(rig.state(), State::Inching(Inching::Ending));
    assert_eq!(rig.until(ENABLED), 500 - 1);
    assert!(!rig.status().in_window);
}

#[test]
fn row_31_inching_2_runs_while_asked_with_v_inch_times_offset() {
    for (v_inch, offset, rpm) in [(50, 47, 24), (30, 47, 14), (1, 10, 1), (30, 100, 30)] {
        let mut rig = prepared();
        rig.settings = rig.settings.with_v_inch(v_inch);
        rig.settings = rig.settings.with_offset_inch_2(offset);
        rig.stw(0x020b).run(3000);
        assert_eq!(rig.state(), State::Inching(Inching::Two(Direction::Positive)));
        assert_eq!(rig.status().velocity, rpm, "{v_inch} rpm, {offset} %");
        rig.settings = rig.settings.with_offset_inch_2(100);
        assert_eq!(rig.run(1000).status().velocity, i32::from(v_inch), "the offset acts at once");
    }
    assert_eq!(prepared().stw(0x820b).run(1000).status().velocity, -30);
}

#[test]
fn row_32_inching_2_stops_by_stop_mode() {
    for (stop_mode_inch_2, cycles) in [(StopMode::Maximum, 125), (StopMode::Ramp, 500)] {
        let mut rig = prepared();
        rig.settings = defaults().with_a_inch(25).with_stop_mode_inch_2(stop_mode_inch_2);
        rig.stw(0x020b).run(1000).stw(0x000b);
        assert_eq!(rig.state(), State::Inching(Inching::Ending));
        assert_eq!(rig.until(ENABLED), cycles - 1);
    }
}

#[test]
fn row_33_a_change_of_direction_turns_the_shaft_with_a_inch() {
    let mut rig = prepared();
    rig.stw(0x020b).run(1000).stw(0x820b);
    assert_eq!(rig.state(), State::Inching(Inching::Two(Direction::Negative)));
    assert_eq!(rig.run(249).status().velocity, 0, "30 rpm at 2 rev/s^2 take 250 ms");
    assert_eq!(rig.run(250).status().velocity, -30);
    assert_eq!(rig.stw(0x000b).until(ENABLED), 124);
}

#[test]
fn row_33_a_change_of_direction_outward_beyond_a_limit_ends_inching() {
    let mut rig = prepared();
    rig.settings = rig.settings.with_limits(Limits::new(500, -500));
    let mut rig = rig.calibrated(900);
    rig.run(1).stw(0x820b).run(300).stw(0x020b);
    assert_eq!(
        (rig.state(), rig.reasons()),
        (State::Inching(Inching::Ending), [Reason::AboveUpperLimit].to_vec())
    );
    rig.until(ENABLED);
    assert!(!rig.run(100).status().moving && (501..900).contains(&rig.position()));
}

#[test]
fn row_34_inching_out_of_the_limits_stops() {
    for stw in [0x010b, 0x020b] {
        let mut rig = prepared();
        rig.settings = rig.settings.with_limits(Limits::new(500, -500));
        rig.run(1).stw(stw).until(ENABLED);
        assert!((501..=551).contains(&rig.position()), "{}", rig.position());
        assert!(rig.status().above_upper_limit && !rig.status().ready_to_travel);
        assert_eq!(rig.zsw() & 0xeb7f, 0x6b37);
    }
}

#[test]
fn row_35_beyond_a_limit_only_inching_inward_is_possible() {
    for (position, outward, inward) in [(600, 0x020b, 0x820b), (-600, 0x820b, 0x020b)] {
        let mut rig = prepared();
        rig.settings = rig.settings.with_limits(Limits::new(500, -500));
        let mut rig = rig.calibrated(position);
        rig.run(1).stw(outward);
        assert_eq!((rig.state(), rig.status().moving), (ENABLED, false));
        assert_eq!(rig.reasons().len(), 1);
        rig.stw(0x000b).stw(inward).run(500);
        assert!(rig.position().abs() < 500);
        assert_eq!(rig.drive.take_refusal(), None);
    }
    let mut rig = prepared().calibrated(1_000_250);
    assert_eq!(
        rig.stw(0x010b).refusal_text(),
        "inching 1 in positive direction refused: actual position 1000250 inc is above the upper limit (1000000 inc): \
         only inching in negative direction is possible"
    );
}

#[test]
fn row_36_both_inchings_together_are_refused() {
    let mut rig = prepared();
    assert_eq!(rig.stw(0x030b).state(), ENABLED);
    assert_eq!(rig.reasons(), [Reason::BothInching]);
}

#[test]
fn inching_is_refused_during_a_job_and_in_velocity_mode() {
    let mut rig = Rig::travelling(16_000);
    assert_eq!(rig.stw(0x017b).reasons(), [Reason::JobActive]);
    let mut rig = prepared();
    rig.settings = rig.settings.with_mode(Mode::Velocity);
    assert_eq!(rig.run(1).stw(0x010b).reasons(), [Reason::VelocityMode]);
    assert_eq!(rig.state(), ENABLED);
}

#[test]
fn loop_travel_approaches_from_its_side() {
    // pos. type, start, target, loop point
    for (pos_type, start, target, via) in [
        (PosType::LoopPlus, 0, 1600, None),
        (PosType::LoopPlus, 1600, 0, Some(-800)),
        (PosType::LoopMinus, 0, -1600, None),
        (PosType::LoopMinus, -1600, 0, Some(800)),
    ] {
        for sense in [SenseOfRotation::I, SenseOfRotation::E] {
            let settings = defaults().with_pos_type(pos_type).with_sense(sense);
            let mut rig = Rig::with(Model::Ag03_1, settings).calibrated(start);
            rig.stw(0x003b).travel(target);
            let approach = if pos_type == PosType::LoopPlus { 1 } else { -1 };
            let mut passed = std::collections::BTreeSet::from([start]);
            let mut cycles = 1;
            while rig.state() == State::TravelActive {
                let direction = rig.status().velocity.signum();
                if direction != 0 {
                    assert_eq!(rig.status().approach_reversed, direction != approach);
                }
                passed.insert(rig.position());
                rig.run(1);
                cycles += 1;
            }
            assert_eq!((rig.position(), rig.status().approach_reversed), (target, false));
            // 2400 increments, then 800
            assert_eq!(cycles, if via.is_some() { 3250 + 1250 } else { 2250 });
            let turn = if approach > 0 { passed.first() } else { passed.last() };
            assert_eq!(turn.copied(), via.or(Some(start)));
        }
    }
}

#[test]
fn a_loop_travel_to_the_actual_position_is_reached_at_once() {
    let mut rig = Rig::enabled();
    rig.settings = rig.settings.with_pos_type(PosType::LoopPlus);
    rig.travel(0);
    assert_eq!((rig.state(), rig.zsw()), (ENABLED, 0xbf37));
}

#[test]
fn a_loop_travel_is_paused_and_continued_on_both_legs() {
    for pause_at in (1..4400).step_by(37) {
        let mut rig = Rig::enabled().calibrated(1600);
        rig.settings = rig.settings.with_pos_type(PosType::LoopPlus);
        rig.travel(0).run(pause_at).stw(0x005b).run(300).stw(0x007b);
        let mut lowest = i32::MAX;
        while rig.state() == State::TravelActive {
            lowest = lowest.min(rig.position());
            rig.run(1);
        }
        assert_eq!(rig.position(), 0);
        assert!(lowest >= -800 && (lowest == -800 || pause_at > 3000), "{lowest}");
    }
}

#[test]
fn a_loop_point_outside_the_limits_refuses_the_job() {
    let mut rig = Rig::enabled();
    rig.settings = rig.settings.with_pos_type(PosType::LoopPlus);
    rig.settings = rig.settings.with_limits(Limits::new(-1000, 1000));
    rig.run(1).travel(-300);
    assert_eq!(
        rig.refusal_text(),
        "travel to -300 inc refused: loop point -1100 inc is below the lower limit (-1000 inc)"
    );
    assert_eq!(rig.travel(-200).state(), State::TravelActive);
}

#[test]
fn calibration_is_possible_without_a_job_only() {
    let mut rig = Rig::travelling(16_000);
    assert_eq!(rig.drive.calibrate(5), Err(CalibrationError));
    rig.stw(0x005b);
    assert_eq!(rig.drive.calibrate(5), Err(CalibrationError));
    rig.stw(0x004b);
    assert_eq!((rig.state(), rig.drive.calibrate(5)), (State::Stopping, Err(CalibrationError)));
    rig.until(ENABLED);
    assert_eq!(rig.drive.calibrate(-999_999), Ok(()));
    assert_eq!(rig.position(), -999_999);
}

#[test]
fn a_scale_written_during_a_job_waits_for_its_end() {
    let mut rig = Rig::travelling(16_000);
    rig.settings = rig.settings.with_gear_numerator(2);
    rig.run(1);
    assert_eq!(rig.zsw() & 0xea7f, 0x0a37);
    rig.until(ENABLED);
    assert_eq!(rig.position(), 16_000);
    assert_eq!(rig.run(1).position(), 8000);
}

#[test]
fn row_34b_a_travel_stops_at_a_limit_that_is_programmed_under_way() {
    for (target, limit) in [(16_000, Limits::new(2000, -5)), (-16_000, Limits::new(5, -2000))] {
        let mut rig = Rig::travelling(target);
        rig.settings = rig.settings.with_limits(limit);
        rig.run(1);
        assert_eq!((rig.state(), rig.zsw() & 0x4000), (State::TravelActive, 0));
        rig.until(State::Stopping);
        assert_eq!((rig.position().abs(), rig.zsw() & 0x4000), (2001, 0x4000));
        rig.until(ENABLED);
        assert!((2001..=2051).contains(&rig.position().abs()), "{}", rig.position());
        assert!(!rig.status().ready_to_travel && rig.status().motor == Motor::InControl);
        assert_eq!(rig.travel(0).reasons().len(), 1, "only inching is possible");
    }
}

#[test]
fn row_34b_beyond_a_limit_that_is_programmed_under_way_only_the_way_back_goes_on() {
    for (target, state) in [(0, State::TravelActive), (12_000, State::Stopping)] {
        let mut rig = Rig::enabled().calibrated(6000);
        rig.travel(target).run(500);
        rig.settings = rig.settings.with_limits(Limits::new(5000, -5000));
        rig.run(1);
        assert_eq!((rig.state(), rig.status().above_upper_limit), (state, true));
        rig.until(ENABLED);
        assert_eq!(rig.position() == target, target == 0);
    }
    // A job that is kept shows it, too, and moves no farther.
    let mut rig = Rig::travelling(16_000);
    rig.stw(0x005b).until(State::Paused { torque_tripped: false });
    rig.settings = rig.settings.with_limits(Limits::new(5, -5));
    assert!(rig.run(1).status().above_upper_limit);
    let position = rig.position();
    rig.stw(0x007b).until(ENABLED);
    assert!(rig.position() - position <= 1);
    // Equal limits are none.
    let mut rig = Rig::travelling(16_000);
    rig.settings = rig.settings.with_limits(Limits::new(5, 5));
    rig.until(ENABLED);
    assert_eq!(rig.position(), 16_000);
}
