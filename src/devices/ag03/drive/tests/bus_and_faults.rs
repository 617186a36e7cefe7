//! Rows 1-14 and 50-53.

use super::*;

const READY: State = State::ReadyToRun(Motor::Released);
const ENABLED: State = State::OperationEnabled(Motor::InControl);

#[test]
fn row_1_power_on_forgets_everything_but_position_and_fault_buffer() {
    let mut rig = Rig::in_fault(Fault::F);
    rig.causes([]).run(2000);
    assert_eq!(rig.status().jobs, 1);
    let position = rig.position();
    rig.inputs(|inputs| inputs.control_supply = 0.0);
    assert_eq!((rig.state(), rig.status().motor), (State::Off, Motor::Released));
    rig.stw = 0;
    rig.inputs(|inputs| inputs.control_supply = 24.0);
    assert_eq!((rig.state(), rig.status().fault), (READY, None));
    assert!(rig.status().jobs == 0 && !rig.status().target_reached);
    assert_eq!(rig.position(), position);
    assert_eq!(rig.drive.faults().count(), 1);
}

#[test]
fn row_1_power_failure_lets_a_travelling_shaft_run_out() {
    let mut rig = Rig::travelling(100_000);
    rig.inputs(|inputs| inputs.control_supply = 0.0);
    assert!(rig.status().moving);
    rig.run(2000);
    assert!(!rig.status().moving);
}

#[test]
fn row_2_ready_to_run_once_both_supplies_are_there() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.output_stage(false);
    assert_eq!((rig.state(), rig.zsw() & 0x0003), (State::NotReady, 0));
    rig.output_stage(true);
    assert_eq!((rig.state(), rig.zsw() & 0x0003), (READY, 3));
}

#[test]
fn row_3_a_lost_output_stage_supply_cancels_everything_but_a_fault() {
    for stw in [0x0000, 0x000b, 0x003b, 0x010b, 0x020b] {
        let mut rig = Rig::new(Model::Ag03_1);
        rig.stw(stw).output_stage(false);
        assert_eq!(rig.state(), State::NotReady);
        assert!(!rig.status().output_stage_ok);
    }
    let mut rig = Rig::travelling(100_000);
    rig.output_stage(false);
    assert_eq!((rig.state(), rig.status().motor), (State::NotReady, Motor::Released));
    assert!(rig.status().travelling && !rig.status().job_active);
    let mut rig = Rig::in_fault(Fault::G);
    rig.output_stage(false);
    assert_eq!((rig.state(), rig.zsw() & 0x000b), (State::Fault, 0x0008));
}

#[test]
fn row_3b_a_lost_enable_input_releases_an_ag03_at_once_and_keeps_operation_enabled() {
    let mut rig = Rig::new(Model::Ag03);
    rig.stw(0x003b).travel(100_000).run(500);
    rig.output_stage(false);
    assert_eq!(rig.state(), State::OperationEnabled(Motor::Released));
    assert_eq!(rig.zsw() & 0x8007, 0x0007);
    assert!(rig.status().travelling, "it coasts");
    rig.drive.take_refusal();
    rig.travel(0);
    assert_eq!(
        rig.refusal_text(),
        "travel to 0 inc refused: the enable input is not active; the shaft still turns"
    );
    rig.output_stage(true);
    assert_eq!((rig.state(), rig.status().ready_to_travel), (ENABLED, false));
    assert_eq!(rig.travel(0).reasons(), [Reason::ShaftTurns], "it is caught first");
    assert!(rig.run(125).status().ready_to_travel);
    assert_eq!(rig.travel(0).state(), State::TravelActive);
}

#[test]
fn row_3b_also_releases_a_motor_left_in_control() {
    let mut rig = Rig::new(Model::Ag03);
    rig.stw(0x000b).stw(0x0003);
    assert_eq!(rig.state(), State::ReadyToRun(Motor::InControl));
    rig.output_stage(false);
    assert_eq!(rig.state(), READY);
}

#[test]
fn row_4_bits_0_1_and_3_enable_whatever_the_others_say() {
    for others in [0x0000, 0x0004, 0x0030, 0x0400, 0x7c34] {
        let mut rig = Rig::new(Model::Ag03_1);
        assert_eq!(rig.stw(0x000b | others).state(), ENABLED, "{others:04x}");
    }
}

#[test]
fn row_4_a_coasting_shaft_is_caught() {
    let mut rig = Rig::travelling(100_000);
    rig.stw(0x0000);
    assert_eq!((rig.state(), rig.status().travelling), (READY, true));
    rig.stw(0x000b);
    assert_eq!(rig.state(), ENABLED);
    rig.run(125);
    assert!(!rig.status().moving, "30 rpm at 4 rev/s^2 take 125 ms");
}

#[test]
fn row_5_any_missing_bit_keeps_it_ready_to_run() {
    for stw in [0x0000, 0x0001, 0x0002, 0x0003, 0x0008, 0x0009, 0x000a] {
        let mut rig = Rig::new(Model::Ag03_1);
        rig.stw(stw);
        assert_eq!(rig.state(), READY);
        let reasons = rig.reasons();
        assert_eq!(reasons.contains(&Reason::NotAsked), stw & 8 == 8, "{stw:04x}");
    }
}

#[test]
fn row_5_off_releases_a_motor_left_in_control() {
    for stw in [0x0000, 0x0001, 0x0002] {
        let mut rig = Rig::enabled();
        rig.stw(0x0003);
        assert_eq!(rig.state(), State::ReadyToRun(Motor::InControl));
        assert_eq!(rig.stw(stw).state(), READY);
    }
}

#[test]
fn row_6_off2_cancels_the_job_and_lets_the_shaft_coast() {
    let mut rig = Rig::travelling(100_000);
    rig.stw(0x0079);
    assert_eq!(rig.state(), READY);
    assert_eq!(rig.status().motor, Motor::Released);
    rig.run(498);
    assert!(rig.status().moving, "30 rpm at 1 rev/s^2 take 500 ms");
    rig.run(1);
    assert!(!rig.status().moving);
    rig.stw(0x007b).run(10);
    assert_eq!((rig.state(), rig.status().moving), (ENABLED, false));
}

#[test]
fn row_7_off1_cancels_the_job_and_lets_the_shaft_coast() {
    let mut rig = Rig::travelling(100_000);
    rig.stw(0x007a);
    assert_eq!(rig.state(), READY);
    assert_eq!((rig.status().motor, rig.status().travelling), (Motor::Released, true));
}

#[test]
fn row_8_disabling_brakes_hard_and_stays_in_control() {
    let mut rig = Rig::travelling(100_000);
    rig.stw(0x0073);
    assert_eq!((rig.state(), rig.status().motor), (State::Disabling, Motor::InControl));
    assert_eq!(rig.zsw() & 0xa06f, 0x0023);
    rig.stw(0x007b);
    assert_eq!(rig.state(), State::Disabling, "enabling waits");
    rig.stw(0x0073);
    assert_eq!(rig.until(State::ReadyToRun(Motor::InControl)), 125 - 3);
    assert_eq!(rig.stw(0x007b).state(), ENABLED);
    rig.run(100);
    assert!(!rig.status().moving, "the job is gone");
}

#[test]
fn row_8_disabling_a_standing_drive_takes_one_cycle() {
    let mut rig = Rig::enabled();
    assert_eq!(rig.stw(0x0033).state(), State::ReadyToRun(Motor::InControl));
}

#[test]
fn row_8_off2_during_the_braking_releases() {
    let mut rig = Rig::travelling(100_000);
    assert_eq!(rig.stw(0x0073).stw(0x0000).state(), READY);
}

#[test]
fn row_9_a_fault_releases_the_motor_and_is_entered_once() {
    let mut rig = Rig::in_fault(Fault::E);
    assert_eq!((rig.state(), rig.status().fault), (State::Fault, Some(Fault::E)));
    assert_eq!((rig.status().motor, rig.status().travelling), (Motor::Released, true));
    rig.run(5).causes([]).causes([Fault::E]);
    assert_eq!(
        (rig.drive.faults().count(), rig.drive.faults().codes()[..2].to_vec()),
        (1, [0x45, 0].to_vec())
    );
    rig.causes([Fault::E, Fault::D]);
    assert_eq!(
        (rig.drive.faults().count(), rig.drive.faults().codes()[..2].to_vec()),
        (2, [0x44, 0x45].to_vec())
    );
    assert_eq!(rig.status().fault, Some(Fault::D), "the latest");
    rig.drive.clear_faults();
    assert_eq!((rig.drive.faults(), rig.state()), (&FaultBuffer::default(), State::Fault));
}

#[test]
fn row_9_faults_the_model_does_not_know_are_ignored() {
    let mut rig = Rig::new(Model::Ag03);
    assert_eq!(rig.causes([Fault::E, Fault::J]).state(), READY);
    assert_eq!(rig.causes([Fault::F]).state(), State::Fault);
}

#[test]
fn row_9_comes_from_every_powered_state() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.output_stage(false);
    assert_eq!(rig.causes([Fault::F]).state(), State::Fault);
    rig.causes([]).stw(0x0080).run(1);
    assert_eq!(rig.state(), State::NotReady, "turn-on disabled, then row 3");
}

#[test]
fn row_10_acknowledging_leads_to_turn_on_disabled() {
    let mut rig = Rig::in_fault(Fault::G);
    rig.causes([]).stw(0x00fb);
    assert_eq!((rig.state(), rig.status().fault), (State::TurnOnDisabled, None));
    assert_eq!(rig.zsw() & 0x004f, 0x0043);
    assert_eq!(rig.drive.faults().count(), 1);
}

#[test]
fn row_11_a_persisting_cause_cannot_be_acknowledged() {
    let mut rig = Rig::in_fault(Fault::D);
    rig.stw(0x00fb);
    assert_eq!(rig.state(), State::Fault);
    assert_eq!(
        rig.refusal_text(),
        "acknowledging refused: the cause of fault D (output stage too hot) is still present"
    );
    rig.causes([]).run(5);
    assert_eq!(rig.state(), State::Fault, "the edge is spent");
    assert_eq!(rig.stw(0x007b).stw(0x00fb).state(), State::TurnOnDisabled);
}

#[test]
fn row_12_an_acknowledge_bit_that_was_already_set_does_nothing() {
    let mut rig = Rig::enabled();
    rig.stw(0x00bb).causes([Fault::F]).causes([]).run(5);
    assert_eq!(rig.state(), State::Fault);
    assert_eq!(rig.stw(0x003b).stw(0x00bb).state(), State::TurnOnDisabled);
}

#[test]
fn row_13_off1_leaves_turn_on_disabled() {
    let mut rig = Rig::in_fault(Fault::G);
    rig.causes([]).stw(0x00fb).stw(0x000a);
    assert_eq!(rig.state(), READY);
    assert_eq!(rig.stw(0x000b).state(), ENABLED);
}

#[test]
fn row_14_without_off1_turning_on_stays_disabled() {
    let mut rig = Rig::in_fault(Fault::G);
    rig.causes([]).stw(0x0083).run(5);
    assert_eq!(rig.state(), State::TurnOnDisabled);
    rig.drive.take_refusal();
    rig.stw(0x000b).run(5);
    assert_eq!(rig.state(), State::TurnOnDisabled);
    assert_eq!(rig.reasons(), [Reason::TurnOnDisabled]);
}

#[test]
fn row_50_leaving_data_exchange_acts_as_all_zero() {
    let mut rig = Rig::travelling(100_000);
    rig.connected = false;
    rig.run(1);
    assert_eq!(rig.state(), READY);
    assert_eq!(rig.status().motor, Motor::Released);
    assert_eq!(rig.drive.take_refusal(), None, "the falling start bit is no request");
    rig.connected = true;
    rig.run(1);
    assert_eq!(rig.state(), ENABLED, "C-36");
    assert_eq!(rig.reasons(), [Reason::NotEnabled], "the start edge came too early");
}

#[test]
fn row_50_an_acknowledge_bit_in_the_first_telegram_is_an_edge() {
    let mut rig = Rig::in_fault(Fault::G);
    rig.causes([]);
    rig.stw = 0x0080;
    rig.connected = false;
    assert_eq!(rig.run(1).state(), State::Fault);
    rig.connected = true;
    assert_eq!(rig.run(1).state(), State::TurnOnDisabled);
}

#[test]
fn row_51_all_zero_outputs_release_the_motor() {
    let mut rig = Rig::travelling(100_000);
    rig.stw(0x0000);
    assert_eq!((rig.state(), rig.status().motor), (READY, Motor::Released));
    assert_eq!(rig.drive.take_refusal(), None);
}

fn with_keys(settings: Settings) -> Rig {
    let mut rig = Rig::with(Model::Ag03_1, settings);
    rig.connected = false;
    rig.run(1);
    rig
}

#[test]
fn row_52_keys_turn_the_shaft_outside_data_exchange() {
    for (sense, clockwise) in [(SenseOfRotation::I, -30), (SenseOfRotation::E, 30)] {
        let mut rig = with_keys(defaults().with_sense(sense));
        rig.inputs(|inputs| inputs.key_clockwise = true).run(300);
        assert_eq!((rig.state(), rig.status().velocity), (State::KeyInching(Key::Clockwise), clockwise));
        rig.inputs(|inputs| inputs.key_clockwise = false).run(300);
        rig.inputs(|inputs| inputs.key_counter_clockwise = true).run(300);
        assert_eq!(rig.status().velocity, -clockwise);
    }
}

#[test]
fn row_52_keys_do_nothing_in_data_exchange_with_a_fault_without_supply_or_in_velocity_mode() {
    let press = |inputs: &mut Inputs| inputs.key_clockwise = true;
    let mut rig = Rig::new(Model::Ag03_1);
    assert_eq!(rig.inputs(press).state(), READY);
    rig.connected = false;
    assert_eq!(rig.run(5).state(), READY, "it was pressed before");
    assert_eq!(with_keys(defaults()).causes([Fault::F]).inputs(press).state(), State::Fault);
    let mut rig = with_keys(defaults());
    rig.output_stage(false).inputs(press);
    assert_eq!(rig.state(), State::NotReady);
    assert_eq!(with_keys(defaults().with_mode(Mode::Velocity)).inputs(press).state(), READY);
    let both = |inputs: &mut Inputs| (inputs.key_clockwise, inputs.key_counter_clockwise) = (true, true);
    assert_eq!(with_keys(defaults()).inputs(both).state(), READY);
}

#[test]
fn row_52_keys_only_turn_inward_beyond_a_limit() {
    let mut rig = with_keys(defaults().with_limits(Limits::new(-100, 100))).calibrated(150);
    rig.inputs(|inputs| inputs.key_counter_clockwise = true);
    assert_eq!(rig.state(), READY);
    rig.inputs(|inputs| inputs.key_counter_clockwise = false);
    rig.inputs(|inputs| inputs.key_clockwise = true).run(500);
    assert_eq!(rig.until(State::KeyInchingEnding), 0, "and stop at the other limit");
    assert!((-150..=-100).contains(&rig.position()), "{}", rig.position());
}

#[test]
fn row_53_a_released_key_or_data_exchange_stops() {
    for by_key in [true, false] {
        let mut rig = with_keys(defaults());
        rig.inputs(|inputs| inputs.key_clockwise = true).run(300);
        rig.stw = 0x000b;
        if by_key {
            rig.inputs(|inputs| inputs.key_clockwise = false);
        } else {
            rig.connected = true;
            rig.run(1);
        }
        assert_eq!(rig.state(), State::KeyInchingEnding);
        assert_eq!(rig.until(READY), 124, "30 rpm at 4 rev/s^2");
        rig.connected = true;
        assert_eq!(rig.run(1).state(), ENABLED);
    }
}

#[test]
fn what_stands_against_a_start_is_what_the_start_is_then_refused_with() {
    let no_supply = |mut rig: Rig| {
        rig.output_stage(false);
        rig
    };
    let beyond = defaults().with_limits(Limits::new(-100, 100));
    let velocity = defaults().with_mode(Mode::Velocity);
    for (mut rig, refused) in [
        (Rig::new(Model::Ag03_1).run(1).clone(), true),
        (Rig::enabled(), false),
        (no_supply(Rig::enabled()), true),
        (Rig::travelling(100_000), true),
        (Rig::in_fault(Fault::J), true),
        (Rig::with(Model::Ag03, beyond).calibrated(150).run(1).clone(), true),
        (Rig::with(Model::Ag03_1, velocity).run(1).clone(), true),
    ] {
        let foretold = rig.drive.start_refusal(&rig.settings);
        rig.drive.take_refusal();
        rig.stw(rig.stw ^ 0x0040);
        let foretold: Vec<_> = foretold.iter().flat_map(Refusal::reasons).collect();
        assert_eq!(rig.reasons(), foretold);
        assert_eq!(foretold.is_empty(), !refused);
    }
}

#[test]
fn fault_a_is_provoked_in_steady_travel_and_taken_back() {
    for gear in [Gear::Ratio24, Gear::Ratio48] {
        let mut rig = Rig::made(Model::Ag03_1, gear, defaults(), Config::default());
        rig.stw(0x003b).travel(100_000).run(2000);
        let before = rig.drive.inputs();
        let provoked = rig.drive.provoking(&before, Fault::A);
        rig.inputs(|inputs| *inputs = provoked).run(10);
        assert_eq!((rig.state(), rig.status().fault), (State::Fault, Some(Fault::A)), "{gear:?}");
        assert_eq!(rig.drive.relieved(&provoked, Fault::A), before);
        // A load of the user's own stays.
        let loaded = Inputs { friction_torque: 1.5, ..before };
        let provoked = rig.drive.provoking(&loaded, Fault::A);
        assert_eq!((provoked.friction_torque, rig.drive.relieved(&provoked, Fault::A)), (1.5, loaded));
    }
}
