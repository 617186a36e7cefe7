//! Maximum speeds and ramps under a load that comes and goes, and the torque deactivation in inching: every model and
//! gear, at several ramps.

use super::*;
use crate::devices::ag03::drive::motion::{acceleration, velocity};

const ENABLED: State = State::OperationEnabled(Motor::InControl);
const RAMPS: [u16; 4] = [1, 10, 50, 100];

fn rigs(settings: Settings) -> impl Iterator<Item = Rig> {
    let kinds = [Model::Ag03, Model::Ag03_1].into_iter();
    let kinds = kinds.flat_map(|model| [Gear::Ratio24, Gear::Ratio48].map(|gear| (model, gear)));
    kinds.map(move |(model, gear)| Rig::made(model, gear, settings, Config::default()))
}

/// Runs and checks in each cycle that the shaft is no faster than `rpm` and accelerates with no more than `percent`.
fn run_within(rig: &mut Rig, cycles: u32, rpm: u16, percent: u16) {
    for _ in 0..cycles {
        let before = rig.drive.shaft_velocity();
        rig.run(1);
        let now = rig.drive.shaft_velocity();
        assert!(now.abs() <= velocity(rpm.into()) + 1e-6, "{rpm} rpm, {percent} %: {now}");
        let faster = now.abs() - before.abs();
        assert!(faster <= acceleration(percent) * 0.001 + 1e-6, "{rpm} rpm, {percent} %: {before} to {now}");
    }
}

#[test]
fn a_travel_keeps_v_pos_and_a_pos_when_the_shaft_is_blocked_and_freed() {
    for a_pos in RAMPS {
        for v_pos in [10, 30, 100] {
            for mut rig in rigs(defaults().with_a_pos(a_pos).with_v_pos(v_pos)) {
                rig.stw(0x003b).travel(3000).run(700);
                rig.inputs(|inputs| inputs.blocked = true).run(450);
                assert_eq!(rig.status().velocity, 0);
                rig.inputs(|inputs| inputs.blocked = false);
                run_within(&mut rig, 3000, v_pos, a_pos);
                rig.until(ENABLED);
                assert_eq!((rig.position(), rig.status().fault), (3000, None));
            }
        }
    }
}

#[test]
fn inching_and_velocity_keep_their_speed_and_ramp_when_a_load_goes() {
    for ramp in RAMPS {
        let inching = defaults().with_a_inch(ramp).with_v_inch(60);
        let turning = defaults().with_a_rot(ramp).with_mode(Mode::Velocity);
        for (settings, stw) in [(inching, 0x020b), (turning, 0x004b)] {
            for mut rig in rigs(settings) {
                rig.setpoint = 60;
                rig.stw(0x000b).stw(stw).run(27_000);
                assert_eq!(rig.status().velocity, 60);
                let heavy = if rig.drive.gear == Gear::Ratio24 { 2.8 } else { 5.6 };
                rig.inputs(|inputs| inputs.friction_torque = heavy).run(2000);
                assert!(rig.status().velocity < 40 && rig.status().lag_error);
                rig.inputs(|inputs| inputs.friction_torque = 0.0);
                run_within(&mut rig, 27_000, 60, ramp);
                assert_eq!((rig.status().velocity, rig.status().lag_error), (60, false));
            }
        }
    }
}

#[test]
fn row_27b_the_torque_deactivation_stops_inching_in_control() {
    for a_inch in RAMPS {
        for stw in [0x010b, 0x020b, 0x820b] {
            for mut rig in rigs(defaults().with_a_inch(a_inch).with_torque_deactivation(Some(60))) {
                rig.stw(0x000b).stw(stw).run(500);
                let friction = if rig.drive.gear == Gear::Ratio24 { 1.5 } else { 3.0 };
                rig.inputs(|inputs| inputs.friction_torque = friction).run(1);
                assert_eq!(
                    (rig.state(), rig.status().torque_tripped),
                    (State::Inching(Inching::Ending), true)
                );
                assert!(rig.until(ENABLED) <= 125);
                assert_eq!((rig.run(2000).state(), rig.status().fault), (ENABLED, None));
                assert!(rig.status().torque_tripped && !rig.status().moving);
                rig.inputs(|inputs| inputs.friction_torque = 0.0);
                assert!(!rig.stw(0x000b).stw(stw).status().torque_tripped, "reset with the next one");
            }
        }
    }
}

#[test]
fn row_27b_the_torque_deactivation_stops_a_key_and_the_motor_is_in_control_while_it_is_held() {
    for a_inch in RAMPS {
        for mut rig in rigs(defaults().with_a_inch(a_inch).with_torque_deactivation(Some(60))) {
            rig.connected = false;
            rig.run(1).inputs(|inputs| inputs.key_clockwise = true).run(500);
            rig.inputs(|inputs| inputs.blocked = true).run(2000);
            assert_eq!((rig.state(), rig.status().fault), (State::ReadyToRun(Motor::InControl), None));
            assert!(rig.status().torque_tripped);
            rig.inputs(|inputs| (inputs.blocked, inputs.key_clockwise) = (false, false));
            assert_eq!(rig.state(), State::ReadyToRun(Motor::Released));
            rig.inputs(|inputs| inputs.key_clockwise = true);
            assert!(!rig.status().torque_tripped && rig.state() == State::KeyInching(Key::Clockwise));
        }
    }
}

#[test]
fn row_24_a_travel_that_pauses_shows_that_the_shaft_turns_until_it_stands() {
    for a_pos in RAMPS {
        for mut rig in rigs(defaults().with_a_pos(a_pos)) {
            rig.stw(0x003b).travel(90_000).run(13_000).stw(0x005b);
            while rig.status().moving {
                assert_eq!(rig.state(), State::Pausing { torque_tripped: false });
                let status = rig.status();
                assert!(!status.standstill && !status.ready_to_travel && status.positioning_active);
                rig.run(1);
            }
            assert_eq!(rig.state(), State::Paused { torque_tripped: false });
            assert_eq!(rig.stw(0x007b).state(), State::TravelActive);
        }
    }
}
