//! `DriveClient` and drives that read their manual otherwise (`docs/quirks.md`): a day's work with each of the values.

use profidrive::client::{Goal, GoalError, Obstacle};
use profidrive::devices::ag03::drive::{Direction, Fault, Inputs};
use profidrive::devices::ag03::param::{Model, Value};
use profidrive::devices::ag03::profibus::QUIRKS;

use crate::drive_rig::{MODELS, Rig};
use crate::long::one_in_turn;

/// Travels in both directions, to where it is, refused ones, interrupted ones; inching; velocities; a fault.
fn work(rig: &mut Rig) {
    rig.pursue(Goal::Enable).unwrap();
    for target in [5, 600, 600, 590, -400, -400, 0, 0, 0, 20, 15] {
        assert_eq!(rig.pursue(Goal::MoveTo(target)), Ok(target));
    }
    for target in [15, 15, 300, 300] {
        rig.refused(Goal::MoveTo(2_000_000), &[Obstacle::TargetBeyondLimits]);
        assert_eq!(rig.pursue(Goal::MoveTo(target)), Ok(target));
    }
    for _ in 0..3 {
        rig.pursue(Goal::Disable).unwrap();
        rig.pursue(Goal::Enable).unwrap();
        assert_eq!(rig.pursue(Goal::MoveTo(300)), Ok(300));
    }
    for target in [3000, 0, 3000, 0] {
        rig.begin(Goal::MoveTo(target));
        rig.exchanges(500);
        let there = rig.pursue(Goal::Pause).unwrap();
        assert!(!rig.moves() && (1..3000).contains(&there));
        assert_eq!(rig.pursue(Goal::Resume), Ok(target));
    }
    assert_eq!(rig.pursue(Goal::Inch), Ok(1600));
    rig.pursue(Goal::Jog(Direction::Negative)).unwrap();
    rig.pursue(Goal::Stop).unwrap();
    rig.begin(Goal::MoveTo(0));
    rig.exchanges(200);
    rig.set_inputs(Inputs::default().provoking(Fault::D));
    let Err(GoalError::Refused(obstacles)) = rig.outcome().result else { panic!("no fault") };
    assert!(obstacles.contains(Obstacle::Fault) && !obstacles.contains(Obstacle::NoSupply), "{obstacles}");
    rig.set_inputs(Inputs::default());
    rig.pursue(Goal::Acknowledge).unwrap();
    rig.pursue(Goal::Disable).unwrap();

    rig.write(930, Value::Word(1));
    rig.pursue(Goal::Enable).unwrap();
    for rpm in [60, -60, 0, 30] {
        assert!(rig.pursue(Goal::Velocity(rpm)).unwrap().abs_diff(rpm) <= 10);
    }
    rig.pursue(Goal::Stop).unwrap();
    rig.pursue(Goal::Disable).unwrap();
    rig.write(930, Value::Word(2));
    rig.pursue(Goal::Enable).unwrap();
    assert_eq!(rig.pursue(Goal::MoveTo(10)), Ok(10));
}

#[test]
fn the_client_works_with_every_reading_of_the_manuals() {
    let readings = QUIRKS.iter().flat_map(|quirk| quirk.values.iter().map(move |value| (quirk, value)));
    for (i, (quirk, value)) in readings.enumerate() {
        for model in one_in_turn(i, MODELS) {
            let mut rig = Rig::quirky(model, &[(quirk.name, value)]);
            let day = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(&mut rig)));
            assert!(day.is_ok(), "{model}, {}={value}", quirk.name);
        }
    }
}

#[test]
fn it_also_works_where_only_rising_edges_start_and_the_acknowledge_mirrors_them() {
    for model in MODELS {
        work(&mut Rig::quirky(model, &[("start-edge", "rising"), ("zsw12", "mirror")]));
    }
}

#[test]
fn each_job_is_started_once_by_one_edge_and_no_edge_is_refused_if_any_edge_starts() {
    for model in MODELS {
        let mut rig = Rig::new(model);
        let mut acknowledge = rig.line.device.zsw().raw() & 0x1000 != 0;
        rig.pursue(Goal::Enable).unwrap();
        for target in [500, 0, 0, 500, 500] {
            rig.pursue(Goal::MoveTo(target)).unwrap();
            assert_ne!(rig.line.device.zsw().raw() & 0x1000 != 0, acknowledge);
            acknowledge = !acknowledge;
        }
        assert!(rig.line.events.iter().all(|event| !event.to_string().contains("refused")));
    }
}

#[test]
fn where_only_rising_edges_start_the_falling_one_is_followed_by_another() {
    let mut rig = Rig::quirky(Model::Ag03, &[("start-edge", "rising")]);
    rig.pursue(Goal::Enable).unwrap();
    rig.pursue(Goal::MoveTo(500)).unwrap();
    assert_eq!(rig.words, ["000B", "003B", "007B"]);
    rig.pursue(Goal::MoveTo(0)).unwrap();
    assert_eq!(rig.words, ["007B", "003B", "007B"]);
}

#[test]
fn the_letter_of_a_fault_says_where_it_was_read() {
    let mut rig = Rig::quirky(Model::Ag03_1, &[("fault-order", "oldest")]);
    for fault in [Fault::G, Fault::D] {
        rig.pursue(Goal::Enable).unwrap();
        rig.set_inputs(Inputs::default().provoking(fault));
        rig.exchanges(50);
        let text = rig.refused(Goal::MoveTo(5), &[Obstacle::Fault, Obstacle::NotEnabled]);
        assert!(
            text.contains("acknowledge it (STW.7 from 0 to 1): G (")
                && text.contains("says element 0 of PNU 945")
        );
        rig.set_inputs(Inputs::default());
        rig.exchanges(50);
        rig.pursue(Goal::Acknowledge).unwrap();
    }
}
