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
