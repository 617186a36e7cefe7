//! `DriveClient` against the emulated drives, exchange by exchange: every goal, the control words it takes, and what it
//! says when the drive refuses.

use profidrive::client::{Goal, GoalError, Job, Limits, Obstacle, Reply};
use profidrive::devices::ag03::drive::{Direction, Fault, Inputs};
use profidrive::devices::ag03::param::{Model, Pnu, Value, Width};

use crate::drive_rig::{MODELS, Rig};

#[test]
fn a_day_of_a_positioning_drive_with_the_words_of_the_flow_chart() {
    for model in MODELS {
        let mut rig = Rig::new(model);
        rig.pursue(Goal::Enable).unwrap();
        assert_eq!(rig.words, ["0000", "000B"]);
        assert_eq!(rig.pursue(Goal::MoveTo(5000)), Ok(5000));
        assert_eq!(rig.words, ["000B", "003B", "007B"]);
        assert_eq!(rig.pursue(Goal::MoveTo(-800)), Ok(-800));
        assert_eq!(rig.words, ["007B", "003B"], "the other edge");
        assert_eq!(rig.pursue(Goal::MoveTo(-800)), Ok(-800), "where it stands");
        assert_eq!(rig.words, ["003B", "007B"]);
        assert_eq!(rig.pursue(Goal::Inch), Ok(800));
        assert_eq!(rig.words, ["007B", "014B"]);
        assert_eq!(rig.client.outputs()[8..10], [0x00, 0x4B]);
        rig.pursue(Goal::Jog(Direction::Negative)).unwrap();
        assert_eq!(rig.words, ["004B", "824B"]);
        rig.exchanges(500);
        let there = rig.pursue(Goal::Stop).unwrap();
        assert_eq!(rig.words, ["004B"]);
        assert!(there < 700, "{there}");
        rig.pursue(Goal::Disable).unwrap();
        assert_eq!(rig.words, ["0003"]);
        assert_eq!(rig.client.zsw().unwrap().raw() & 0xAB6F, 0x2B23);
        rig.pursue(Goal::Enable).unwrap();
        assert_eq!(rig.words, ["0003", "000B"]);
        assert!(
            rig.line.events.iter().all(|event| !event.to_string().contains("refused")),
            "{:?}",
            rig.line.events
        );
    }
}

#[test]
fn a_travel_job_is_interrupted_continued_and_discarded() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.pursue(Goal::Enable).unwrap();
    rig.client.pursue(rig.line.now, Goal::MoveTo(8000));
    rig.exchanges(600);
    let there = rig.pursue(Goal::Pause).unwrap();
    assert_eq!(rig.words, ["005B"]);
    rig.exchanges(1000);
    assert!(there > 0 && rig.client.hiw() < 8000);
    assert_eq!(rig.pursue(Goal::Resume), Ok(8000));
    assert_eq!(rig.words, ["007B"]);
    rig.refused(Goal::Resume, &[Obstacle::NoJob]);

    rig.pursue(Goal::Enable).unwrap();
    rig.client.pursue(rig.line.now, Goal::MoveTo(0));
    rig.exchanges(600);
    let there = rig.pursue(Goal::Stop).unwrap();
    assert!(there > 0 && there < 8000, "{there}");
    rig.refused(Goal::Pause, &[Obstacle::NoJob]);
    // A new target while it travels: stop, then go.
    rig.client.pursue(rig.line.now, Goal::MoveTo(0));
    rig.exchanges(600);
    assert_eq!(rig.pursue(Goal::MoveTo(8000)), Ok(8000));
    assert_eq!(rig.words, ["004B", "007B", "003B"], "stop, prepare, go");
}

#[test]
fn velocity_mode_runs_changes_direction_and_stops() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.pursue(Goal::Enable).unwrap();
    assert_eq!(
        rig.refused(Goal::Velocity(50), &[Obstacle::PositioningMode]),
        "velocity 50 rpm is not possible: the drive is in positioning mode: write 1 to PNU 930 first"
    );
    rig.pursue(Goal::MoveTo(100)).unwrap();
    // STW.6 rests at 1, and would turn the shaft in velocity mode.
    rig.write(930, Value::Word(1));
    rig.exchanges(100);
    assert_eq!(rig.client.hiw(), 0);
    for rpm in [72, -72, 10, 0] {
        let reached = rig.pursue(Goal::Velocity(rpm)).unwrap();
        assert!(reached.abs_diff(rpm) <= 10, "{reached}");
    }
    rig.pursue(Goal::Velocity(-100)).unwrap();
    let reached = rig.pursue(Goal::Stop).unwrap();
    assert_eq!((reached, &rig.words[..]), (0, &["000B".to_owned()][..]));
    let text = rig.refused(Goal::Velocity(101), &[Obstacle::BeyondGear]);
    assert_eq!(
        text,
        "velocity 101 rpm is not possible: the velocity is more than the gear allows (PNU 961): at most 100 rpm"
    );
    rig.refused(Goal::MoveTo(0), &[Obstacle::VelocityMode]);
    rig.pursue(Goal::Disable).unwrap();
}

#[test]
fn a_fault_is_named_acknowledged_and_left_behind() {
    for model in MODELS {
        let mut rig = Rig::new(model);
        assert_eq!(rig.pursue(Goal::Acknowledge), Ok(0), "nothing to acknowledge");
        rig.pursue(Goal::Enable).unwrap();
        rig.client.pursue(rig.line.now, Goal::MoveTo(5000));
        rig.exchanges(300);
        rig.set_inputs(Inputs::default().provoking(Fault::D));
        let outcome = loop {
            rig.exchange();
            if let Some(outcome) = rig.client.poll_outcome() {
                break outcome;
            }
        };
        let text = outcome.result.unwrap_err().to_string();
        assert!(text.starts_with(
            "move to 5000 is not possible: a fault is latched (ZSW.3 = 1): remove its cause, then \
             acknowledge it (STW.7 from 0 to 1): D (output"
        ));
        rig.refused(Goal::Enable, &[Obstacle::Fault, Obstacle::ShaftTurns]);
        rig.refused(Goal::Acknowledge, &[Obstacle::FaultCause]);
        rig.set_inputs(Inputs::default());
        rig.pursue(Goal::Acknowledge).unwrap();
        assert_eq!(rig.words, ["0000", "0003", "0083", "0003", "0002"]);
        rig.pursue(Goal::Enable).unwrap();
        assert_eq!(rig.pursue(Goal::MoveTo(5000)), Ok(5000));
    }
}

#[test]
fn what_is_missing_for_a_travel_is_said() {
    for model in MODELS {
        let mut rig = Rig::new(model);
        assert_eq!(
            rig.refused(Goal::MoveTo(1), &[Obstacle::NotEnabled]),
            "move to 1 is not possible: operation is not enabled (ZSW.2 = 0)"
        );
        rig.pursue(Goal::Enable).unwrap();
        assert_eq!(
            rig.refused(Goal::MoveTo(1_200_000), &[Obstacle::TargetBeyondLimits]),
            "move to 1200000 is not possible: the target is beyond a limit (PNU 1016, 1017): the limits are -1000000 and 1000000"
        );
        rig.exchanges(2000);
        assert_eq!(rig.client.hiw(), 0, "nothing starts later");

        rig.set_inputs(Inputs::default().with_output_stage(false));
        let missing: &[Obstacle] = match model {
            Model::Ag03 => &[Obstacle::NoOutputStage],
            Model::Ag03_1 => &[Obstacle::NoSupply, Obstacle::NotEnabled, Obstacle::NoOutputStage],
        };
        rig.exchanges(5);
        rig.refused(Goal::Inch, missing);
        rig.refused(Goal::MoveTo(100), missing);
        rig.set_inputs(Inputs::default());
        rig.exchanges(2000);
        assert_eq!(rig.client.hiw(), 0, "nor when the supply is back");
        rig.pursue(Goal::Enable).unwrap();
        rig.write(1016, Value::of(Width::Double, -100));
        rig.write(1017, Value::of(Width::Double, -200));
        let text = rig.refused(Goal::MoveTo(-150), &[Obstacle::AboveUpperLimit]);
        assert!(text.contains("only inching in negative direction"), "{text}");
        rig.refused(Goal::Jog(Direction::Positive), &[Obstacle::AboveUpperLimit]);
        rig.refused(Goal::Inch, &[Obstacle::AboveUpperLimit]);
        rig.write(1019, Value::of(Width::Double, -150));
        assert_eq!(rig.pursue(Goal::Inch), Ok(-150));
        assert_eq!(rig.pursue(Goal::MoveTo(-120)), Ok(-120));
        rig.write(1014, Value::Word(1));
        rig.refused(Goal::MoveTo(-190), &[Obstacle::LoopPoint]);
    }
}

#[test]
fn without_data_exchange_the_diagnosis_says_why_and_after_a_loss_nothing_starts_by_itself() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.client.handle_diagnosis(&[0x42, 0x05, 0, 0xFF, 0x0A, 0xC5]);
    rig.client.pursue(rig.line.now, Goal::Enable);
    let due = rig.client.poll_timeout().unwrap();
    assert_eq!(due, rig.line.now.saturating_add(Limits::default().reaction));
    rig.client.handle_timeout(due);
    assert_eq!(
        rig.client.poll_outcome().unwrap().result.unwrap_err().to_string(),
        "enable was not done within 5s: there is no Data_Exchange with the drive; it refused Set_Prm (Slave_Diag octet 1 \
         bit 6, Prm_Fault = 1): the ident number must be 0AC5; it is not ready for Data_Exchange (Slave_Diag octet 1 bit \
         1, Station_Not_Ready = 1)"
    );

    rig.pursue(Goal::Enable).unwrap();
    rig.client.pursue(rig.line.now, Goal::MoveTo(5000));
    rig.exchanges(300);
    rig.client.handle_data_exchange_lost();
    assert_eq!(rig.client.poll_outcome().unwrap().result, Err(GoalError::Interrupted));
    assert_eq!(rig.client.outputs(), [[0; 10].as_slice(), &[0, 0, 0x13, 0x88]].concat()[..]);
    rig.line.start_up();
    rig.exchanges(3000);
    let there = rig.client.hiw();
    rig.exchanges(100);
    assert_eq!(rig.client.hiw(), there);
    assert!(there < 5000);
    rig.pursue(Goal::Enable).unwrap();
    assert_eq!(rig.pursue(Goal::MoveTo(5000)), Ok(5000));
}

#[test]
fn a_tripped_torque_deactivation_ends_the_travel_with_its_name() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.write(1032, Value::Word(20));
    rig.pursue(Goal::Enable).unwrap();
    rig.client.pursue(rig.line.now, Goal::MoveTo(5000));
    rig.exchanges(300);
    rig.set_inputs(Inputs { friction_torque: 3.0, ..Inputs::default() });
    let outcome = loop {
        rig.exchange();
        if let Some(outcome) = rig.client.poll_outcome() {
            break outcome;
        }
    };
    let Err(GoalError::Refused(obstacles)) = outcome.result else { panic!("{outcome:?}") };
    assert!(obstacles.contains(Obstacle::TorqueTripped), "{obstacles}");
}

#[test]
fn parameters_and_goals_share_the_channel() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.pursue(Goal::Enable).unwrap();
    rig.client.pursue(rig.line.now, Goal::MoveTo(2000));
    assert!(
        rig.client.submit(rig.line.now, Job::read(Pnu::new(1004).unwrap())).is_err(),
        "needed for the goal"
    );
    rig.exchanges(100);
    let mut last = 0;
    loop {
        let position = Job::read(Pnu::new(1036).unwrap()).expecting(Width::Double);
        let Reply::Value(Value::Double(position)) = rig.job(position).unwrap() else { panic!() };
        assert!(position >= last, "{position} after {last}");
        last = position;
        if let Some(outcome) = rig.client.poll_outcome() {
            assert_eq!(outcome.result, Ok(2000));
            break;
        }
    }
    assert!(last > 1000, "read while it travelled");
}
