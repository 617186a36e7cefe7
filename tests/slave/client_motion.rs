//! `DriveClient` and the motion of the shaft: nothing turns again by itself, what is done stands or turns as promised,
//! and a goal replaces another at any exchange.

use std::time::Duration;

use profidrive::client::{Goal, GoalError, Job, Limits, NotSubmitted, Obstacle, Reply};
use profidrive::devices::ag03::drive::{Direction, Fault, Inputs};
use profidrive::devices::ag03::param::{Model, Pnu, Value, Width};
use profidrive::face::Description;
use profidrive::face::description::{Amount, ParameterPlace};
use profidrive::profibus::ppo;

use crate::drive_rig::{MODELS, Rig};
use crate::long::one_in_turn;

/// Takes the enable input or the supply of the output stage away and gives it back, and nothing may turn then.
fn lose_and_return(rig: &mut Rig) {
    rig.set_inputs(Inputs::default().with_output_stage(false));
    rig.exchanges(4000);
    assert!(!rig.moves(), "it has run out");
    rig.set_inputs(Inputs::default());
    let before = rig.line.device.status().position;
    rig.exchanges(1000);
    assert_eq!(rig.line.device.status().position, before, "{}", rig.stw());
    assert!(!rig.moves());
}

#[test]
fn a_velocity_does_not_come_back_with_the_enable_or_the_supply() {
    for model in MODELS {
        // After the goal, in the middle of it, and after another goal that it goes on under.
        for (exchanges, then) in
            [(1000, None), (60, None), (1000, Some(Goal::Enable)), (20, Some(Goal::Enable))]
        {
            let mut rig = Rig::in_velocity_mode(model);
            rig.begin(Goal::Velocity(60));
            rig.exchanges(exchanges);
            if let Some(goal) = then {
                rig.pursue(goal).unwrap();
            }
            lose_and_return(&mut rig);
            assert_eq!(rig.stw(), "000B");
        }
        // Inching 2 is a level, too.
        let mut rig = Rig::new(model);
        rig.pursue(Goal::Enable).unwrap();
        rig.pursue(Goal::Jog(Direction::Negative)).unwrap();
        lose_and_return(&mut rig);
        assert_eq!(rig.stw(), "000B");
    }
}

#[test]
fn a_dip_too_short_to_stop_the_shaft_ends_a_velocity_also_while_jobs_are_asked() {
    let read = Job::read(Pnu::new(1018).unwrap());
    for model in MODELS {
        for asks in [false, true] {
            let mut rig = Rig::in_velocity_mode(model);
            rig.pursue(Goal::Velocity(45)).unwrap();
            for dip in [false, true, false] {
                rig.set_inputs(Inputs::default().with_output_stage(!dip));
                let end = rig.line.now.saturating_add(Duration::from_millis(20));
                while rig.line.now < end {
                    if asks {
                        assert_eq!(rig.job(read), Ok(Reply::Value(Value::Double(0))));
                    } else {
                        rig.exchange();
                    }
                }
                assert!(rig.moves(), "a dip of 20 ms stops no shaft");
            }
            assert_eq!(rig.stw(), "000B", "{model} {asks}");
            rig.exchanges(2000);
            assert!(!rig.moves());
            // What the shaft does not turn by is not watched.
            assert_eq!(ppo::Outputs::new(&rig.client.outputs()).pkw().pke.raw(), 0);
        }
    }
}

#[test]
fn a_velocity_without_enable_or_supply_is_refused_with_the_reason_and_never_begins() {
    for model in MODELS {
        for rpm in [8, 50] {
            let mut rig = Rig::in_velocity_mode(model);
            rig.set_inputs(Inputs::default().with_output_stage(false));
            rig.exchanges(20);
            let missing: &[Obstacle] = match model {
                Model::Ag03 => &[Obstacle::NoOutputStage],
                Model::Ag03_1 => &[Obstacle::NoSupply, Obstacle::NotEnabled, Obstacle::NoOutputStage],
            };
            let begun = rig.line.now;
            rig.refused(Goal::Velocity(rpm), missing);
            assert!(rig.line.now.saturating_since(begun) < Duration::from_secs(1));
            assert!(!rig.words.contains(&"004B".to_owned()), "{:?}", rig.words);
            lose_and_return(&mut rig);
        }
        // The same loss while it accelerates.
        let mut rig = Rig::in_velocity_mode(model);
        rig.begin(Goal::Velocity(50));
        rig.exchanges(30);
        assert!(rig.moves());
        rig.set_inputs(Inputs::default().with_output_stage(false));
        let Err(GoalError::Refused(obstacles)) = rig.outcome().result else { panic!("{model}") };
        assert!(obstacles.contains(Obstacle::NoOutputStage), "{obstacles}");
        lose_and_return(&mut rig);
    }
}

#[test]
fn pause_stop_and_disable_are_done_when_the_shaft_stands() {
    for model in MODELS {
        for goal in [Goal::Pause, Goal::Stop, Goal::Disable] {
            let mut rig = Rig::new(model);
            rig.write(1004, Value::Word(100));
            rig.write(1003, Value::Word(10));
            rig.pursue(Goal::Enable).unwrap();
            rig.begin(Goal::MoveTo(100_000));
            rig.exchanges(3000);
            let position = rig.pursue(goal).unwrap();
            assert!(!rig.moves(), "{goal}");
            rig.exchanges(1000);
            assert_eq!(rig.client.hiw(), position, "{goal}");
            // Not while a job is interrupted.
            let written = rig.client.submit(rig.line.now, Job::write(Pnu::new(930).unwrap(), Value::Word(2)));
            assert_eq!(written.is_ok(), goal != Goal::Pause, "{goal}");
        }
        // A shaft that was released runs out.
        for goal in [Goal::Stop, Goal::Disable] {
            let mut rig = Rig::new(model);
            rig.pursue(Goal::Enable).unwrap();
            rig.begin(Goal::MoveTo(100_000));
            rig.exchanges(3000);
            rig.client.handle_data_exchange_lost();
            assert_eq!(rig.client.poll_outcome().unwrap().result, Err(GoalError::Interrupted));
            rig.exchange();
            assert!(rig.moves());
            rig.pursue(goal).unwrap();
            assert!(!rig.moves(), "{goal}");
        }
    }
}

#[test]
fn a_slow_ramp_has_the_time_of_a_motion() {
    let mut rig = Rig::in_velocity_mode(Model::Ag03_1);
    rig.write(1005, Value::Word(5));
    rig.pursue(Goal::Velocity(100)).unwrap();
    let begun = rig.line.now;
    assert_eq!(rig.pursue(Goal::Stop), Ok(0));
    assert!(rig.line.now.saturating_since(begun) > Limits::default().reaction);
    assert!(!rig.moves());
}

#[test]
fn a_goal_takes_over_at_any_exchange() {
    for exchanges in 0..40 {
        for model in one_in_turn(exchanges, MODELS) {
            let mut rig = Rig::new(model);
            rig.pursue(Goal::Enable).unwrap();
            for (goal, there) in [(Goal::MoveTo(-100), -100..=-100), (Goal::Inch, 1600..=8000)] {
                rig.begin(Goal::MoveTo(8000));
                rig.exchanges(exchanges);
                let reached = rig.pursue(goal).unwrap();
                assert!(there.contains(&reached), "{goal} after {exchanges}: {reached}");
                rig.pursue(Goal::MoveTo(0)).unwrap();
            }
            rig.begin(Goal::MoveTo(8000));
            rig.exchanges(exchanges);
            rig.pursue(Goal::Jog(Direction::Negative)).unwrap();
            rig.exchanges(200);
            assert!(rig.line.device.status().velocity < 0, "after {exchanges}");
            rig.pursue(Goal::Stop).unwrap();
            assert!(!rig.moves());

            // A job that was started is interrupted and can be continued; before, there is none.
            rig.pursue(Goal::MoveTo(0)).unwrap();
            rig.begin(Goal::MoveTo(8000));
            rig.exchanges(exchanges);
            match rig.pursue(Goal::Pause) {
                Ok(_) => {
                    assert!(rig.line.device.status().job_active, "after {exchanges}");
                    assert_eq!(rig.pursue(Goal::Resume), Ok(8000), "after {exchanges}");
                }
                Err(GoalError::Refused(obstacles)) => {
                    assert!(obstacles.iter().eq([Obstacle::NoJob]), "after {exchanges}: {obstacles}");
                    assert!(!rig.line.device.status().job_active, "after {exchanges}");
                }
                Err(error) => panic!("{error}"),
            }
        }
    }
}

#[test]
fn a_velocity_replaces_another_without_a_stop_and_ends_with_any_other_goal() {
    let mut rig = Rig::in_velocity_mode(Model::Ag03_1);
    rig.begin(Goal::Velocity(60));
    rig.exchanges(60);
    rig.pursue(Goal::Velocity(90)).unwrap();
    assert_eq!(rig.words, ["004B"]);
    // What was reached goes on.
    rig.pursue(Goal::Enable).unwrap();
    assert_eq!(rig.stw(), "004B");
    rig.begin(Goal::Velocity(-60));
    rig.exchanges(60);
    rig.pursue(Goal::Stop).unwrap();
    rig.begin(Goal::Velocity(60));
    rig.exchanges(60);
    rig.begin(Goal::Acknowledge);
    assert_eq!(rig.stw(), "000B");
}

#[test]
fn a_job_that_ended_can_neither_be_paused_nor_resumed() {
    for model in MODELS {
        let mut rig = Rig::new(model);
        rig.pursue(Goal::Enable).unwrap();
        rig.begin(Goal::MoveTo(300));
        rig.exchanges(50);
        rig.pursue(Goal::Enable).unwrap();
        rig.exchanges(3000);
        rig.refused(Goal::Pause, &[Obstacle::NoJob]);
        rig.refused(Goal::Resume, &[Obstacle::NoJob]);

        rig.begin(Goal::MoveTo(9000));
        rig.exchanges(500);
        rig.pursue(Goal::Pause).unwrap();
        lose_and_return(&mut rig);
        rig.pursue(Goal::Enable).unwrap();
        rig.refused(Goal::Resume, &[Obstacle::NoJob]);
        assert_eq!(rig.pursue(Goal::MoveTo(0)), Ok(0));
    }
}

#[test]
fn the_start_bit_does_not_rest_over_a_change_of_the_mode() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.pursue(Goal::Enable).unwrap();
    rig.begin(Goal::MoveTo(3000));
    rig.exchanges(300);
    rig.pursue(Goal::Enable).unwrap();
    let mode = Job::write(Pnu::new(930).unwrap(), Value::Word(1));
    assert_eq!(rig.client.submit(rig.line.now, mode), Err(NotSubmitted::Busy), "it travels");
    rig.exchanges(6000);
    assert_eq!(rig.stw(), "007B");
    rig.write(930, Value::Word(1));
    assert_eq!(rig.stw(), "000B");

    // The other way, also past the client's eyes: 004B has bit 6, and 003B must not be its edge.
    rig.pursue(Goal::Velocity(0)).unwrap();
    assert_eq!(
        rig.job(Job::write(Pnu::new(970).unwrap(), Value::Word(2))),
        Ok(Reply::Value(Value::Double(0)))
    );
    assert_eq!(rig.pursue(Goal::MoveTo(500)).map_err(|error| error.to_string()), Ok(500));
    assert_eq!(rig.words, ["004B", "000B", "003B", "007B"].map(str::to_owned));
    rig.write(930, Value::Word(1));
    rig.pursue(Goal::Velocity(0)).unwrap();
    rig.write(930, Value::Word(2));
    assert_eq!(rig.stw(), "000B");
}

#[test]
fn a_blocked_shaft_neither_jogs_nor_turns() {
    for model in MODELS {
        let mut rig = Rig::in_velocity_mode(model);
        rig.set_inputs(Inputs { blocked: true, ..Inputs::default() });
        rig.refused(Goal::Velocity(8), &[Obstacle::Fault, Obstacle::NotEnabled]);
        let mut rig = Rig::new(model);
        rig.pursue(Goal::Enable).unwrap();
        rig.set_inputs(Inputs { blocked: true, ..Inputs::default() });
        rig.refused(Goal::Jog(Direction::Positive), &[Obstacle::Fault, Obstacle::NotEnabled]);
        // In a wide window every velocity is near enough, but not every direction.
        let mut rig = Rig::in_velocity_mode(model);
        rig.write(1009, Value::Word(1000));
        for rpm in [100, -100] {
            assert!(rig.pursue(Goal::Velocity(rpm)).unwrap().signum() == rpm.signum());
            assert_eq!(rig.line.device.status().velocity.signum(), rpm.signum());
        }
        rig.pursue(Goal::Velocity(0)).unwrap();
        assert!(!rig.moves());
    }
}

#[test]
fn a_drive_that_cannot_be_enabled_can_be_stopped_and_disabled() {
    for model in MODELS {
        for inputs in [Inputs::default().provoking(Fault::D), Inputs::default().with_output_stage(false)] {
            for goal in [Goal::Stop, Goal::Disable] {
                let mut rig = Rig::new(model);
                rig.pursue(Goal::Enable).unwrap();
                rig.begin(Goal::MoveTo(5000));
                rig.exchanges(600);
                rig.set_inputs(inputs);
                rig.exchanges(2);
                rig.pursue(goal).unwrap();
                assert!(!rig.moves(), "{goal}");
            }
        }
    }
}

#[test]
fn a_goal_ends_when_no_images_come_any_more() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.pursue(Goal::Enable).unwrap();
    rig.begin(Goal::MoveTo(5000));
    rig.exchanges(300);
    let due = rig.client.poll_timeout().unwrap();
    assert_eq!(due, rig.line.now.saturating_add(Limits::default().reaction));
    rig.client.handle_timeout(due);
    assert_eq!(
        rig.client.poll_outcome().unwrap().result.unwrap_err().to_string(),
        "move to 5000 was not done within 5s: there is no Data_Exchange with the drive"
    );
    assert_eq!(rig.stw(), "004B", "the job is discarded when the images come again");
}

#[test]
fn what_ran_out_of_time_says_so() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.pursue(Goal::Enable).unwrap();
    let text = rig.refused(Goal::MoveTo(100_000), &[Obstacle::PositioningActive, Obstacle::ShaftTurns]);
    assert_eq!(
        text,
        "move to 100000 was not done within 30s: a positioning is active (SSW.14 = 1): wait for its end, or stop it (STW.4 = \
         0); the shaft turns (ZSW.13 = 0 or SSW.4 = 1): wait until it stands"
    );
}

#[test]
fn what_a_limit_forbids_is_refused_at_once() {
    for model in MODELS {
        let mut rig = Rig::new(model);
        rig.pursue(Goal::Enable).unwrap();
        let begun = rig.line.now;
        rig.refused(Goal::MoveTo(1_200_000), &[Obstacle::TargetBeyondLimits]);
        rig.write(1016, Value::of(Width::Double, -100));
        rig.write(1017, Value::of(Width::Double, -200));
        rig.refused(Goal::MoveTo(-150), &[Obstacle::AboveUpperLimit]);
        assert!(rig.line.now.saturating_since(begun) < Duration::from_secs(1));
        // Where the limits do not matter, so that no way is none.
        rig.write(1016, Value::of(Width::Double, 0));
        rig.write(1017, Value::of(Width::Double, 0));
        rig.write(1019, Value::of(Width::Double, 0));
        let begun = rig.line.now;
        assert_eq!(rig.pursue(Goal::Inch), Ok(0));
        assert!(rig.line.now.saturating_since(begun) < Duration::from_secs(1));
    }
}

#[test]
fn an_outcome_that_nobody_takes_stops_no_goal() {
    let mut rig = Rig::new(Model::Ag03_1);
    rig.pursue(Goal::Enable).unwrap();
    rig.client.submit(rig.line.now, Job::read(Pnu::new(1004).unwrap()).expecting(Width::Word)).unwrap();
    rig.exchanges(100);
    assert_eq!(rig.pursue(Goal::MoveTo(100)), Ok(100));
    assert_eq!(rig.client.poll_job().unwrap().result, Ok(Reply::Value(Value::Word(30))));
}

#[test]
fn a_pause_right_behind_a_start_is_done_when_the_shaft_stands() {
    for exchanges in 0..30 {
        let mut rig = Rig::new(Model::Ag03_1);
        rig.pursue(Goal::Enable).unwrap();
        rig.exchanges(300);
        rig.client.pursue(rig.line.now, Goal::MoveTo(-200));
        rig.exchanges(exchanges);
        let paused = rig.pursue(Goal::Pause).is_ok();
        let status = rig.line.device.status();
        assert!(!status.moving && status.job_active == paused, "{exchanges}");
    }
}

/// How a drive describes its position: the number in the unit that it gives.
fn described_position(rig: &Rig) -> (f64, String) {
    let mut found = None;
    rig.line.device.each_value(&mut |value| {
        if let ("position", Amount::Number(number)) = (value.key, value.amount) {
            found = Some((number, value.unit.to_string()));
        }
    });
    found.unwrap()
}

const PITCH: ParameterPlace = ParameterPlace { number: 1012, element: None };

#[test]
fn a_position_keeps_its_unit_until_a_new_spindle_pitch_acts() {
    for model in MODELS {
        let mut rig = Rig::new(model);
        rig.pursue(Goal::Enable).unwrap();
        rig.pursue(Goal::MoveTo(16_000)).unwrap();
        let device: &mut dyn Description = &mut rig.line.device;
        device.write_parameter(rig.line.now, PITCH, 500.0, &mut |_| {}).unwrap();
        assert_eq!(described_position(&rig), (16_000.0, "inc".into()), "the drive has not acted on it");
        rig.exchange();
        assert_eq!(described_position(&rig), (50.0, "mm".into()));
    }
}
