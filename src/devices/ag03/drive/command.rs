//! What a bus wants of the drive.

use super::Direction;

/// What a bus wants of the drive in one step. All fields but `enable` and `travel` are levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Command {
    /// What the motor shall do.
    pub operation: Operation,
    /// Operation was asked for just now: if something stands against it, that is reported as a [`Refusal`](super::Refusal).
    pub enable: bool,
    /// Positioning: a travel job to `setpoint` is asked for just now.
    pub travel: bool,
    /// Velocity: the setpoint is released.
    pub turn: bool,
    /// Target position in user units, or target velocity in rpm (limited to what the gear allows).
    pub setpoint: i32,
    /// Positioning: brake with maximum deceleration and discard the job. No job starts.
    pub stop: bool,
    /// Positioning: brake with the deceleration of the job and keep it; taken back, the job goes on. No job starts.
    pub pause: bool,
    /// Becoming true starts inching 1, becoming false ends it.
    pub inch_1: bool,
    /// A direction starts inching 2, none ends it.
    pub inch_2: Option<Direction>,
    /// Becoming true acknowledges a fault.
    pub acknowledge: bool,
    /// After an acknowledged fault: operation may be enabled again.
    pub rearm: bool,
    /// The keys on the housing are free (manual setup mode).
    pub keys: bool,
}

impl Command {
    /// No bus wants anything: the motor is released, the keys are free.
    pub(crate) const UNATTENDED: Self = Self { rearm: true, keys: true, ..Self::RELEASE };

    /// The motor is released, nothing else.
    pub(super) const RELEASE: Self = Self {
        operation: Operation::Release,
        enable: false,
        travel: false,
        turn: false,
        setpoint: 0,
        stop: false,
        pause: false,
        inch_1: false,
        inch_2: None,
        acknowledge: false,
        rearm: false,
        keys: false,
    };
}

/// What the motor shall do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Operation {
    /// No torque: a turning shaft runs out.
    #[default]
    Release,
    /// If operation is enabled: brake with maximum deceleration. Release when the shaft stands.
    BrakeAndRelease,
    /// If operation is enabled: brake with maximum deceleration, then hold the shaft (quick stop, disable operation).
    BrakeAndHold,
    /// Operation enabled: jobs are executed.
    Run,
}
