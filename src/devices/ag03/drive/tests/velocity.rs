//! Rows 40-42.

use super::*;

const ENABLED: State = State::OperationEnabled(Motor::InControl);

fn enabled() -> Rig {
    let mut rig = Rig::with(Model::Ag03_1, defaults().with_mode(Mode::Velocity));
    rig.stw(0x000b);
    assert_eq!(rig.state(), ENABLED);
    rig
}

fn turning(setpoint: i32) -> Rig {
    let mut rig = enabled();
    rig.setpoint = setpoint;
    rig.stw(0x004b).run(2000);
    rig
}

#[test]
fn row_40_a_released_setpoint_is_reached_with_a_rot() {
    let mut rig = enabled();
    rig.setpoint = 60;
    rig.stw(0x004b).run(249);
    assert_eq!((rig.state(), rig.status().velocity), (State::VelocityTravelling, 30));
    assert!(!rig.status().in_window);
    rig.run(250);
    assert_eq!((rig.status().velocity, rig.status().in_window), (60, true));
    assert!(!rig.status().standstill && !rig.status().positioning_active);
}

#[test]
fn row_40_is_a_level_and_follows_enabling_by_itself() {
    let mut rig = Rig::with(Model::Ag03_1, defaults().with_mode(Mode::Velocity));
    rig.setpoint = -72;
    rig.stw(0x004b).run(1000);
    assert_eq!((rig.status().velocity, rig.drive.take_refusal()), (-72, None));
}

#[test]
fn row_40_without_enable_input_the_setpoint_is_refused() {
    let mut rig = Rig::with(Model::Ag03, defaults().with_mode(Mode::Velocity));
    rig.output_stage(false).stw(0x000b);
    rig.setpoint = 20;
    rig.stw(0x004b).run(10);
    assert_eq!(rig.refusal_text(), "velocity 20 rpm refused: the enable input is not active");
    assert!(!rig.status().moving);
}

#[test]
fn row_40_start_held_over_a_change_of_mode_does_not_turn_the_shaft() {
    let mut rig = Rig::enabled();
    rig.travel(0);
    rig.settings = rig.settings.with_mode(Mode::Velocity);
    rig.setpoint = 50;
    rig.run(100);
    assert_eq!((rig.state(), rig.status().moving), (ENABLED, false));
    rig.stw(0x003b).stw(0x007b);
    assert_eq!(rig.state(), State::VelocityTravelling);
}

#[test]
fn row_40_the_setpoint_is_limited_to_what_the_gear_allows() {
    assert_eq!(turning(i32::MAX).status().velocity, 100);
    assert_eq!(turning(-101).status().velocity, -100);
    let mut rig = enabled();
    rig.drive.gear = Gear::Ratio24;
    rig.setpoint = i32::MIN;
    assert_eq!(rig.stw(0x004b).run(3000).status().velocity, -200);
}

#[test]
fn row_41_a_new_setpoint_acts_at_once_even_through_zero() {
    let mut rig = turning(30);
    rig.setpoint = -30;
    assert_eq!(rig.run(250).status().velocity, 0);
    assert_eq!(rig.run(250).status().velocity, -30);
    assert_eq!(rig.state(), State::VelocityTravelling);
}

#[test]
fn row_42_a_withdrawn_setpoint_runs_down_and_then_is_ready() {
    let mut rig = turning(60);
    rig.stw(0x000b);
    assert_eq!((rig.state(), rig.zsw() & 0xde7f), (State::VelocityTravelling, 0x1e37));
    assert_eq!(rig.until(ENABLED), 499);
    assert_eq!((rig.zsw(), rig.status().motor), (0xbf37, Motor::InControl));
}

#[test]
fn row_42_a_setpoint_of_zero_stands_but_stays_released() {
    let mut rig = turning(60);
    rig.setpoint = 0;
    rig.run(600);
    assert_eq!((rig.state(), rig.status().standstill), (State::VelocityTravelling, true));
    assert!(!rig.status().ready_to_travel && !rig.status().moving);
    assert!(rig.run(60_000).drive.is_at_rest(), "once the output stage has cooled");
}

#[test]
fn row_8_disabling_in_velocity_mode_brakes_hard() {
    let mut rig = turning(60);
    rig.stw(0x0043);
    assert_eq!(rig.zsw(), 0x1e33);
    assert_eq!(rig.until(State::ReadyToRun(Motor::InControl)), 249);
}

#[test]
fn limits_do_not_exist_in_velocity_mode() {
    let mut rig = turning(60);
    rig.settings = rig.settings.with_limits(Limits::new(-1, 1));
    rig.stw(0x000b).run(600);
    assert!(!rig.status().above_upper_limit && rig.status().ready_to_travel);
}

#[test]
fn a_mode_written_while_the_shaft_turns_waits_for_standstill() {
    let mut rig = turning(60);
    rig.settings = rig.settings.with_mode(Mode::Positioning);
    rig.run(10);
    assert_eq!((rig.status().mode, rig.status().velocity), (Mode::Velocity, 60));
    rig.stw(0x000b).run(500);
    assert_eq!(rig.run(1).status().mode, Mode::Positioning);
}
