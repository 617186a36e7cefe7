//! Positioning, step by step.

use super::super::{BlockField, Mdi, Origin, Task};
use super::*;

fn at(task: Task) -> Command {
    Command { setpoint: Setpoint::Position(task), ..Command::run(0.0) }
}

/// Bits 4 and 5 are set; `begin` is bit 6.
fn commanded(task: Task, begin: bool) -> Command {
    let mut command = at(task);
    command.control.enable_setpoint = begin;
    command
}

const ABSOLUTE: Mdi = Mdi {
    absolute: true,
    forward: false,
    backward: false,
    set_up: false,
    continuous: false,
    target: 0,
    velocity: 6000.0,
    acceleration: 1.0,
    deceleration: 1.0,
};

fn mdi(mdi: Mdi) -> Task {
    Task { mdi: Some(mdi), ..Task::default() }
}

impl Rig {
    /// In operation, standing, with a reference.
    fn referenced() -> Self {
        let mut rig = Self::operating();
        rig.run(2, Some(commanded(Task::default(), false)));
        rig.run(2, Some(commanded(Task { set_reference: true, ..Task::default() }, false)));
        assert!(rig.drive.is_referenced());
        rig
    }

    fn go(&mut self, task: Task, millis: u64) -> AxisStatus {
        self.run(2, Some(commanded(task, false)));
        self.run(millis, Some(commanded(task, true)));
        self.drive.axis()
    }
}

#[test]
fn a_target_is_reached_absolute_and_relative_and_says_so() {
    let mut rig = Rig::referenced();
    let on_the_way = rig.go(mdi(Mdi { target: 50_000, ..ABSOLUTE }), 100);
    assert!(on_the_way.accepted && !on_the_way.target_reached && on_the_way.direction == 1);
    assert_eq!((on_the_way.by, on_the_way.accelerates), (Some(Origin::Mdi), true));
    rig.run(2000, Some(commanded(mdi(Mdi { target: 50_000, ..ABSOLUTE }), true)));
    let there = rig.drive.axis();
    assert!(there.target_reached && (there.position - 50_000.0).abs() < 1.0, "{there:?}");
    let back = rig.go(mdi(Mdi { absolute: false, target: -20_000, ..ABSOLUTE }), 2000);
    assert!(back.target_reached && (back.position - 30_000.0).abs() < 1.0, "{back:?}");
    // A new target on the way.
    rig.go(mdi(Mdi { target: 90_000, ..ABSOLUTE }), 200);
    let there = rig.go(mdi(Mdi { target: 10_000, ..ABSOLUTE }), 3000);
    assert!(there.target_reached && (there.position - 10_000.0).abs() < 1.0, "{there:?}");
}

#[test]
fn an_intermediate_stop_holds_the_task_and_a_rejection_ends_it() {
    let mut rig = Rig::referenced();
    let task = mdi(Mdi { target: 100_000, ..ABSOLUTE });
    rig.go(task, 200);
    let mut stop = commanded(task, true);
    stop.control.run_ramp = false;
    rig.run(500, Some(stop));
    let held = rig.drive.axis();
    assert!(held.setpoint_stands && held.by.is_some() && held.accepted);
    rig.run(3000, Some(commanded(task, true)));
    assert!(rig.drive.axis().target_reached);
    rig.go(mdi(Mdi { target: 0, ..ABSOLUTE }), 200);
    let mut reject = commanded(task, true);
    reject.control.enable_ramp = false;
    rig.run(500, Some(reject));
    let ended = rig.drive.axis();
    assert!(ended.setpoint_stands && ended.by.is_none() && !ended.accepted && !ended.target_reached);
}

#[test]
fn without_a_reference_an_absolute_target_is_refused_and_limits_hold() {
    let mut rig = Rig::operating();
    rig.go(mdi(Mdi { target: 1000, ..ABSOLUTE }), 100);
    assert!(rig.told().contains(&Event::NotReferenced) && !rig.drive.axis().accepted);
    let mut rig = Rig::referenced();
    rig.drive.settings_mut().set(Setting::LimitPlus, 20_000.0);
    let limited = |target| Task { software_limits: true, ..mdi(Mdi { target, ..ABSOLUTE }) };
    rig.go(limited(20_001), 100);
    assert!(rig.told().contains(&Event::BeyondLimit));
    let set_up = Mdi { set_up: true, forward: true, ..ABSOLUTE };
    let there = rig.go(Task { software_limits: true, ..mdi(set_up) }, 4000);
    assert!((there.position - 20_000.0).abs() < 1.0 && there.at_software_limits.1, "{there:?}");
}

#[test]
fn setting_up_follows_direction_and_override_until_mdi_goes() {
    let mut rig = Rig::referenced();
    let set_up = |forward: bool, part: f64| Task {
        velocity_part: part,
        ..mdi(Mdi { set_up: true, forward, backward: !forward, velocity: 600.0, ..ABSOLUTE })
    };
    let forward = rig.go(set_up(true, 1.0), 1000);
    assert!(forward.endless && (rig.drive.status().speed - 60.0).abs() < 1.0, "{:?}", rig.drive.status());
    rig.run(1000, Some(commanded(set_up(true, 0.5), true)));
    assert!((rig.drive.status().speed - 30.0).abs() < 1.0);
    rig.run(1000, Some(commanded(set_up(false, 1.0), true)));
    assert!((rig.drive.status().speed + 60.0).abs() < 1.0);
    rig.run(500, Some(commanded(Task::default(), true)));
    assert!(rig.drive.axis().by.is_none() && rig.drive.axis().setpoint_stands);
}

#[test]
fn jogging_goes_on_or_a_way() {
    let mut rig = Rig::referenced();
    let jog = |incremental: bool| {
        let mut command = commanded(Task { incremental, ..Task::default() }, false);
        command.control.inching_2 = true;
        command
    };
    rig.run(1000, Some(jog(false)));
    assert!((rig.drive.status().speed - 30.0).abs() < 1.0, "{:?}", rig.drive.status());
    rig.run(500, Some(commanded(Task::default(), false)));
    let begin = rig.drive.axis().position;
    rig.run(1500, Some(jog(true)));
    let end = rig.drive.axis();
    assert!((end.position - begin - 1000.0).abs() < 1.0 && end.target_reached, "{end:?}");
}

#[test]
fn referencing_finds_cam_and_zero_mark_both_ways_and_is_ended_with_its_command() {
    for backward in [0.0, 1.0] {
        for cam in [1.0, 0.0] {
            let mut rig = Rig::operating();
            let settings = rig.drive.settings_mut();
            settings.set(Setting::HomingBackward, backward);
            settings.set(Setting::HomingCam, cam);
            settings.set(Setting::ReferencePosition, 500.0);
            let home = Task { home: true, ..Task::default() };
            rig.run(2, Some(commanded(Task::default(), false)));
            rig.run(50, Some(commanded(home, false)));
            assert!(rig.drive.axis().homing);
            rig.run(30_000, Some(commanded(home, false)));
            let axis = rig.drive.axis();
            assert!(
                axis.referenced && !axis.homing && (axis.position - 500.0).abs() < 1.0,
                "{backward} {cam} {axis:?}"
            );
        }
    }
    let mut rig = Rig::operating();
    rig.run(2, Some(commanded(Task::default(), false)));
    rig.run(50, Some(commanded(Task { home: true, ..Task::default() }, false)));
    rig.run(500, Some(commanded(Task::default(), false)));
    assert!(!rig.drive.axis().homing && rig.drive.axis().setpoint_stands && !rig.drive.is_referenced());
}

#[test]
fn traversing_blocks_follow_each_other() {
    let mut rig = Rig::referenced();
    let rows: [[i32; 5]; 5] = [
        // number, position, task, parameter, mode
        [1, 20_000, 1, 0, 0x10],
        [2, 0, 5, 300, 0x10],
        [3, 0, 7, 1, 0x10],
        [4, -5_000, 1, 0, 0x120],
        [5, 0, 1, 0, 0x00],
    ];
    for (place, [number, position, task, parameter, mode]) in rows.into_iter().enumerate() {
        let block = &mut rig.drive.blocks_mut().0[place];
        for (field, value) in [
            (BlockField::Number, number),
            (BlockField::Position, position),
            (BlockField::Velocity, 6000),
            (BlockField::Task, task),
            (BlockField::Parameter, parameter),
            (BlockField::Mode, mode),
        ] {
            block.set(field, value);
        }
    }
    let blocks = Task { block: 1, ..Task::default() };
    let mut seen = Vec::new();
    rig.run(2, Some(commanded(blocks, false)));
    for _ in 0..4000 {
        rig.run(1, Some(commanded(blocks, true)));
        if let Some(Origin::Block(number)) = rig.drive.axis().by
            && seen.last() != Some(&number)
        {
            seen.push(number);
        }
    }
    assert_eq!(seen, [1, 2, 4, 5]);
    let axis = rig.drive.axis();
    assert!(axis.target_reached && axis.position.abs() < 1.0 && axis.outputs == 1, "{axis:?}");
    // There is none of this number.
    rig.told();
    rig.go(Task { block: 9, ..Task::default() }, 10);
    assert!(rig.told().contains(&Event::NoBlock { number: 9 }));
}

#[test]
fn a_shaft_that_does_not_follow_and_a_limit_switch_are_faults() {
    let mut rig = Rig::referenced();
    rig.drive.inputs_mut().blocked = true;
    rig.go(mdi(Mdi { target: 50_000, ..ABSOLUTE }), 500);
    assert_eq!(rig.drive.standing_faults().next().unwrap().number, Fault::FollowingError.number());
    let mut rig = Rig::referenced();
    rig.go(mdi(Mdi { target: 50_000, ..ABSOLUTE }), 100);
    rig.drive.inputs_mut().pressed.positive_limit = true;
    let mut task = mdi(Mdi { target: 50_000, ..ABSOLUTE });
    rig.run(10, Some(commanded(task, true)));
    assert_eq!(
        rig.drive.axis().limit_switches,
        (false, false),
        "they do not hold until they are switched on"
    );
    assert_eq!(rig.drive.standing_faults().count(), 0);
    task.limit_switches = true;
    assert!(rig.run(1000, Some(commanded(task, true))).stands);
    assert_eq!(rig.drive.axis().limit_switches, (false, true));
    assert_eq!(rig.drive.standing_faults().next().unwrap().number, Fault::LimitSwitch.number());
}

#[test]
fn from_the_cam_referencing_goes_back_to_the_zero_mark() {
    for (backward, by_master) in [(false, false), (true, false), (true, true)] {
        let mut rig = Rig::operating();
        rig.drive.settings_mut().set(Setting::HomingBackward, f64::from(u8::from(backward && !by_master)));
        let home = Task { home: true, home_backward: by_master, ..Task::default() };
        rig.run(2, Some(commanded(Task::default(), false)));
        rig.run(30_000, Some(commanded(home, false)));
        // The cam is 0.1 to 0.2 revolutions ahead, there is a zero mark in each revolution.
        let mark = if backward { INCREMENTS_PER_REVOLUTION } else { 0.0 };
        assert!(
            rig.drive.is_referenced() && (rig.drive.shaft() - mark).abs() < 1.0,
            "{backward} {}",
            rig.drive.shaft()
        );
    }
}

#[test]
fn flying_referencing_corrects_the_position_by_the_edge_of_a_probe() {
    let mut rig = Rig::referenced();
    rig.drive.settings_mut().set(Setting::OuterWindow, 2000.0);
    rig.drive.settings_mut().set(Setting::InnerWindow, 50.0);
    let to = |target, fly| Task { home: fly, fly, ..mdi(Mdi { target, ..ABSOLUTE }) };
    let there = rig.go(to(1000, true), 1500);
    assert!(there.flying && there.target_reached && (there.position - 1000.0).abs() < 1.0, "{there:?}");
    // The reference position is here: what was 1000 LU is 0, and the target is still where it was told.
    rig.drive.set_probes([true, false]);
    rig.run(2, Some(commanded(to(1000, true), true)));
    assert!(rig.drive.axis().position.abs() < 1.0 && !rig.drive.axis().mark_outside);
    // Neither the falling edge, nor the other probe, nor one within the inner window.
    let at = |rig: &mut Rig, probes, target| {
        rig.drive.set_probes(probes);
        rig.go(to(target, true), 1500).position
    };
    assert!((at(&mut rig, [false, false], 1500) - 1500.0).abs() < 1.0);
    assert!((at(&mut rig, [false, true], 20) - 20.0).abs() < 1.0);
    assert!((at(&mut rig, [true, true], 20) - 20.0).abs() < 1.0);
    // On the way: an absolute target keeps its number.
    rig.drive.set_probes([false; 2]);
    rig.go(to(1900, true), 60);
    let before = rig.drive.axis().position;
    rig.drive.set_probes([true, false]);
    rig.run(1, Some(commanded(to(1900, true), true)));
    assert!(rig.drive.axis().position < before.min(100.0), "{before}");
    rig.run(2000, Some(commanded(to(1900, true), true)));
    assert!((rig.drive.axis().position - 1900.0).abs() < 1.0);
    // Outside of the outer window nothing is corrected.
    rig.drive.set_probes([false; 2]);
    rig.go(to(5000, true), 1500);
    rig.drive.set_probes([true, false]);
    rig.run(2, Some(commanded(to(5000, true), true)));
    let outside = rig.drive.axis();
    assert!(outside.mark_outside && (outside.position - 5000.0).abs() < 1.0, "{outside:?}");
    rig.run(2, Some(commanded(to(5000, false), true)));
    assert!(!rig.drive.axis().flying && !rig.drive.axis().mark_outside);
}
