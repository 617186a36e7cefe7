//! The drive alone, step by step.

use super::*;

mod axis;

struct Rig {
    drive: Drive,
    millis: u64,
}

impl Rig {
    fn new() -> Self {
        Self { drive: Drive::new(Instant::ZERO), millis: 0 }
    }

    /// In operation, standing.
    fn operating() -> Self {
        let mut rig = Self::new();
        rig.run(2, Some(off()));
        rig.run(2, Some(Command::run(0.0)));
        assert_eq!(rig.drive.status().state, State::Operation);
        rig
    }

    fn run(&mut self, millis: u64, command: Option<Command>) -> Status {
        for _ in 0..millis {
            self.millis += 1;
            self.drive.step(Instant::from_millis(self.millis), command.as_ref());
        }
        self.drive.status()
    }

    fn told(&mut self) -> Vec<Event> {
        core::iter::from_fn(|| self.drive.poll_event()).collect()
    }
}

/// OFF1.
fn off() -> Command {
    with(|control| control.on = false)
}

fn with(change: impl FnOnce(&mut ppo_drive::Command)) -> Command {
    let mut command = Command::run(0.0);
    change(&mut command.control);
    command
}

#[test]
fn it_ramps_to_its_setpoint_and_off1_brakes_on_the_ramp() {
    let mut rig = Rig::operating();
    let half = rig.run(500, Some(Command::run(1.0)));
    assert!((half.speed - 1500.0).abs() < 40.0, "{half:?}");
    assert!((half.demand - 1500.0).abs() < 4.0 && !half.ramp_done);
    let full = rig.run(600, Some(Command::run(1.0)));
    assert!((full.speed - 3000.0).abs() < 1.0 && full.speed_reached && full.in_tolerance && full.ramp_done);
    let braking = rig.run(500, Some(off()));
    assert_eq!(braking.state, State::SwitchingOff(Off::Off1));
    assert!((braking.speed - 1500.0).abs() < 40.0);
    assert_eq!(rig.run(700, Some(off())).state, State::ReadyToSwitchOn);
    assert!(rig.run(5000, Some(off())).stands && rig.drive.is_at_rest());
}

#[test]
fn off2_coasts_and_off3_brakes_fast_and_both_inhibit_switching_on() {
    for (change, millis) in [
        ((|control| control.no_off2 = false) as fn(&mut ppo_drive::Command), 1000),
        (|control| control.no_off3 = false, 190),
    ] {
        let mut rig = Rig::operating();
        rig.run(1200, Some(Command::run(1.0)));
        let after = rig.run(millis, Some(with(change)));
        assert!(after.speed > 50.0, "{after:?}");
        let after = rig.run(9000, Some(with(change)));
        assert!(after.stands && after.state == State::SwitchingOnInhibited, "{after:?}");
        assert_eq!(rig.run(10, Some(Command::run(1.0))).state, State::SwitchingOnInhibited);
    }
}

#[test]
fn a_fault_is_buffered_with_its_time_and_value_and_acknowledged_by_an_edge() {
    let mut rig = Rig::operating();
    rig.run(1200, Some(Command::run(1.0)));
    rig.drive.raise(Fault::Raised(70), -5);
    let after = rig.run(1, Some(Command::run(1.0)));
    assert_eq!((after.state, after.fault), (State::SwitchingOnInhibited, true));
    let first = rig.drive.faults().noted(0).unwrap();
    assert_eq!((first.number, first.value, first.millis), (70, -5, 1204));
    // While it stands OFF1 does not lead to S2.
    assert_eq!(rig.run(5, Some(off())).state, State::SwitchingOnInhibited);
    let mut acknowledge = Command::run(1.0);
    acknowledge.control.acknowledge = true;
    let after = rig.run(5, Some(acknowledge));
    assert_eq!((after.state, after.fault), (State::SwitchingOnInhibited, false), "ON is still set");
    assert_eq!(rig.drive.faults().noted(8).unwrap().number, 70);
    assert_eq!(rig.run(2, Some(off())).state, State::ReadyToSwitchOn);
    // Bit 7 that stays set acknowledges nothing more.
    rig.drive.raise(Fault::Raised(71), 0);
    acknowledge.control.on = false;
    rig.run(1, Some(off()));
    rig.run(1, Some(acknowledge));
    rig.drive.raise(Fault::Raised(72), 0);
    assert!(rig.run(5, Some(acknowledge)).fault);
}

#[test]
fn without_a_master_it_brakes_and_says_so() {
    let mut rig = Rig::operating();
    rig.run(1200, Some(Command::run(1.0)));
    rig.told();
    assert_eq!(rig.run(50, None).state, State::SwitchingOff(Off::Off3));
    let after = rig.run(500, None);
    assert_eq!((after.state, after.fault, after.stands), (State::SwitchingOnInhibited, true, true));
    let faults = rig.told().into_iter().filter(|event| matches!(event, Event::Fault(_)));
    assert_eq!(faults.collect::<Vec<_>>(), [Event::Fault(Fault::Communication)]);
}

#[test]
fn jogging_wants_a_locked_setpoint_and_a_shaft_at_rest() {
    let jog = |locked: bool| {
        with(|control| {
            (control.enable_ramp, control.run_ramp, control.enable_setpoint) = (!locked, !locked, !locked);
            control.inching_2 = true;
        })
    };
    let mut rig = Rig::operating();
    rig.run(10, Some(jog(false)));
    assert!(rig.told().contains(&Event::JogRefused));
    let locked = with(|control| {
        (control.enable_ramp, control.run_ramp, control.enable_setpoint) = (false, false, false);
    });
    rig.run(10, Some(locked));
    let turning = rig.run(200, Some(jog(true)));
    assert!((turning.speed + 150.0).abs() < 2.0, "{turning:?}");
    assert!(rig.run(2000, Some(locked)).stands);
}

#[test]
fn bits_4_5_and_6_set_the_ramp_to_zero_hold_it_and_let_it_run_out() {
    let mut rig = Rig::operating();
    rig.run(500, Some(Command::run(1.0)));
    let hold = |control: &mut ppo_drive::Command| control.run_ramp = false;
    let mut held = Command::run(1.0);
    hold(&mut held.control);
    let before = rig.run(1, Some(held)).demand;
    assert_eq!(rig.run(300, Some(held)).demand, before);
    let mut locked = Command::run(1.0);
    locked.control.enable_setpoint = false;
    let after = rig.run(250, Some(locked)).demand;
    assert!((before - after - 750.0).abs() < 4.0, "{before} {after}");
    let mut zero = Command::run(1.0);
    zero.control.enable_ramp = false;
    assert_eq!(rig.run(1, Some(zero)).demand, 0.0);
}

#[test]
fn a_load_beyond_its_torque_is_a_warning_and_a_fault_and_a_blocked_shaft_too() {
    let mut rig = Rig::operating();
    rig.run(1200, Some(Command::run(0.5)));
    rig.drive.inputs_mut().load_torque = 3.0;
    let after = rig.run(6000, Some(Command::run(0.5)));
    assert!(after.warning && !after.fault, "{after:?}");
    let after = rig.run(30_000, Some(Command::run(0.5)));
    assert!(after.fault);
    assert_eq!(rig.drive.standing_faults().next().unwrap().number, Fault::Overload.number());

    let mut rig = Rig::operating();
    rig.drive.inputs_mut().blocked = true;
    assert!(!rig.run(1500, Some(Command::run(0.5))).fault);
    assert!(rig.run(2000, Some(Command::run(0.5))).fault);
    assert_eq!(rig.drive.standing_faults().next().unwrap().number, Fault::Blocked.number());
}

#[test]
fn the_torque_can_be_reduced() {
    let mut rig = Rig::operating();
    let mut reduced = Command::run(1.0);
    reduced.torque_reduction = 1.0;
    let after = rig.run(300, Some(reduced));
    assert!(after.stands && after.torque == 0.0, "{after:?}");
}

#[test]
fn the_terminals_act_as_off2_and_off3() {
    let mut rig = Rig::operating();
    rig.run(1200, Some(Command::run(1.0)));
    rig.drive.inputs_mut().emergency_stop_released = false;
    let after = rig.run(20, Some(Command::run(1.0)));
    assert_eq!((after.state, after.no_off3, after.fault), (State::SwitchingOff(Off::Off3), false, false));
    rig.drive.inputs_mut().emergency_stop_released = true;
    rig.drive.inputs_mut().main_circuit = false;
    let after = rig.run(1, Some(Command::run(1.0)));
    assert_eq!((after.state, after.no_off2, after.fault), (State::SwitchingOnInhibited, false, true));
}
