//! What a master commands, without bits.

use crate::devices::ppo_drive;

/// What is commanded in one application cycle. `default()` commands nothing: OFF1, OFF2 and OFF3 together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// The switches of STW1. Its setpoint of 16 bits is not looked at, that of `setpoint` is.
    pub control: ppo_drive::Command,
    /// What the drive shall do.
    pub setpoint: Setpoint,
    /// By how much the torque is reduced: 0 by nothing, 1 to nothing.
    pub torque_reduction: f64,
}

/// What the drive shall do while it operates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setpoint {
    /// Turn with this speed: 1 is the reference speed.
    Speed(f64),
    /// Position the axis. Bits 4 to 6 of STW1 are: no rejection of the task, no intermediate stop, begin (edge).
    Position(Task),
}

/// What a positioning drive shall do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Reference the axis: begins with the edge, ends when it goes.
    pub home: bool,
    /// The edge takes the next traversing block.
    pub change_block: bool,
    /// The edge makes the position that of the reference.
    pub set_reference: bool,
    /// The axis is on the reference cam.
    pub cam: bool,
    /// The setpoint follows the shaft.
    pub track: bool,
    /// Jogging goes a way, not on and on.
    pub incremental: bool,
    /// The software limits hold.
    pub software_limits: bool,
    /// The limit switches hold.
    pub limit_switches: bool,
    /// Referencing begins backward.
    pub home_backward: bool,
    /// Referencing is flying: by the edge of a probe, beside everything else.
    pub fly: bool,
    /// Its probe is the second.
    pub second_probe: bool,
    /// Its edge is the falling one.
    pub falling_edge: bool,
    /// The number of the traversing block.
    pub block: u8,
    /// The master's own target, in place of a block.
    pub mdi: Option<Mdi>,
    /// The part of each velocity, 1 is all of it.
    pub velocity_part: f64,
}

impl Default for Task {
    fn default() -> Self {
        Self {
            home: false,
            change_block: false,
            set_reference: false,
            cam: false,
            track: false,
            incremental: false,
            software_limits: false,
            limit_switches: false,
            home_backward: false,
            fly: false,
            second_probe: false,
            falling_edge: false,
            block: 0,
            mdi: None,
            velocity_part: 1.0,
        }
    }
}

/// The master's own target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mdi {
    /// Its position counts from the reference.
    pub absolute: bool,
    /// Setting up goes forward.
    pub forward: bool,
    /// Setting up goes backward.
    pub backward: bool,
    /// Set up: go on and on.
    pub set_up: bool,
    /// A change is taken over at once.
    pub continuous: bool,
    /// LU.
    pub target: i32,
    /// 1000 LU/min.
    pub velocity: f64,
    /// The part of the most acceleration.
    pub acceleration: f64,
    /// The part of the most deceleration.
    pub deceleration: f64,
}

impl Default for Setpoint {
    fn default() -> Self {
        Self::Speed(0.0)
    }
}

impl Command {
    /// Everything released, with this speed: 1 is the reference speed.
    pub const fn run(speed: f64) -> Self {
        Self { control: ppo_drive::Command::run(0), setpoint: Setpoint::Speed(speed), torque_reduction: 0.0 }
    }
}
