//! The state machine of `ag03.md` section 8: states, what moves them, and one match arm per row.
//!
//! Three functions, asked once each per step in this order, which is also the order of priority:
//!
//! 1. [`State::on_plant`]: supplies, faults, torque (rows 1-3b, 9, 27, 27b: torque in inching and under a key);
//! 2. [`State::on_command`]: what the master or the keys ask for, at most one transition per step (rows 4-53);
//! 3. [`State::on_motion`]: what the shaft has reached (the second half of rows 8, 23, 24, 26, 27, 29-34b, 42, 53).
//!
//! They are pure: they say the next state and the [`Action`] that goes with it; [`super::Drive`] carries it out.
//! Within a function the arms stand in the order of their priority. Rows 21, 22, 25b, 35 and 36 (refused requests)
//! have no arm of their own: a request with an unmet condition is not in [`Asked`] at all, see [`super::refusal`].

use core::fmt;

/// State of the drive, both operating modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// No control supply.
    Off,
    /// A supply is missing (AG03/1: that of the output stage).
    NotReady,
    /// Ready-to-run. The motor is released (R), or in control or shorted (C) after operation was disabled.
    ReadyToRun(Motor),
    /// Operation enabled and no job; ready-to-travel when the start conditions are met. The motor is released or
    /// shorted by the inpos mode, or released because the AG03's enable input is not active.
    OperationEnabled(Motor),
    /// Operation was disabled, the shaft still brakes.
    Disabling,
    /// A travel job is being executed (positioning).
    TravelActive,
    /// The travel job was interrupted but is kept, the shaft still brakes (positioning).
    Pausing {
        /// Interrupted by the torque deactivation instead of the master.
        torque_tripped: bool,
    },
    /// The travel job is interrupted but kept, the shaft stands (positioning).
    Paused {
        /// Interrupted by the torque deactivation instead of the master.
        torque_tripped: bool,
    },
    /// The travel job was discarded, the shaft still brakes (positioning).
    Stopping,
    /// Inching 1 or 2 (positioning).
    Inching(Inching),
    /// The setpoint is released, or the shaft still runs down from it (velocity).
    VelocityTravelling,
    /// Manual setup mode: a key is held while the keys are free (positioning).
    KeyInching(Key),
    /// The key was released or locked, the shaft still brakes.
    KeyInchingEnding,
    /// A fault is latched.
    Fault,
    /// A fault was acknowledged; operation cannot be enabled before the bus has armed it again ([`super::Command::rearm`]).
    TurnOnDisabled,
}

/// What the output stage does with the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Motor {
    /// Without torque, turns freely (German *freigeschaltet*, C-04).
    Released,
    /// In position or velocity control.
    InControl,
    /// Control off, windings shorted.
    Shorted,
}

/// Which inching.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Inching {
    /// Once by delta inch.
    One,
    /// As long as requested.
    Two(Direction),
    /// It was ended; the shaft still brakes.
    Ending,
}

/// A direction in user units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Positions grow.
    Positive,
    /// Positions shrink.
    Negative,
}

/// A key of the manual setup mode, by the direction of the shaft seen on the clamping ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// Key 1, right.
    Clockwise,
    /// Key 2, left.
    CounterClockwise,
}

/// What a change of the direction (STW.15) does to inching 2 under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DirectionChange {
    /// The shaft brakes with a-Inch and turns in the new direction.
    #[default]
    Reverses,
    /// Inching ends as if it were taken back; a new one needs another edge.
    Ends,
    /// Nothing: the direction counts when inching begins.
    IsIgnored,
}

/// What goes with a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// Nothing.
    None,
    /// Power-on initialisation (row 1).
    PowerOn,
    /// Output stage off: the shaft runs out, the job is lost.
    Release,
    /// Control on: the shaft is held, or caught with maximum deceleration if it turns.
    TakeControl,
    /// Brake with maximum deceleration.
    BrakeMaximum,
    /// Brake with maximum deceleration, the torque deactivation has tripped.
    TorqueBrake,
    /// Brake with the deceleration of the job or inching.
    BrakeProgrammed,
    /// Brake inching 2 or a key as the stop mode says (PNU 1021).
    BrakeStopMode,
    /// Latch the requested job and start it.
    StartTravel,
    /// Continue the kept job.
    ResumeTravel,
    /// Travel once by delta inch.
    StartInching1,
    /// Take a-Inch and turn in the direction.
    StartInching2(Direction),
    /// Follow v-Inch times offset (PNU 1035 acts at once).
    FollowInching2(Direction),
    /// Take a-Inch and turn as the key says.
    StartKey(Key),
    /// Follow v-Inch times offset.
    FollowKey(Key),
    /// Follow the velocity setpoint.
    FollowVelocity,
}

/// The plant as the state machine sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions {
    /// The control has supply.
    pub(super) control_supply: bool,
    /// All supplies that `supply_ok` (ZSW.0) asks for.
    pub(super) supply_ok: bool,
    /// AG03/1: output stage supplied, AG03: enable input active.
    pub(super) output_stage: bool,
    /// The output stage came back with this step.
    pub(super) output_stage_returned: bool,
    /// A cause of a fault is present.
    pub(super) fault_cause: bool,
    /// The torque is above the deactivation threshold, in positioning mode.
    pub(super) torque_exceeded: bool,
    /// C-13: the job is not kept then.
    pub(super) torque_discards_job: bool,
}

/// What is asked of the drive, levels and edges separately, refused requests left out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// The motor shall be without torque.
    pub(super) release: bool,
    /// Operation shall be enabled; if not, and the motor is not released, the shaft is held.
    pub(super) enable: bool,
    /// What releases from turn-on disabled.
    pub(super) turn_on_again: bool,
    /// As in [`Conditions`].
    pub(super) output_stage: bool,
    pub(super) stop: bool,
    pub(super) intermediate_stop: bool,
    /// The intermediate stop was just taken back.
    pub(super) resume: bool,
    /// A travel job whose conditions are all met.
    pub(super) travel: bool,
    /// Inching 1 whose conditions are all met, and its level.
    pub(super) inch_1: bool,
    pub(super) inch_1_held: bool,
    /// Inching 2 whose conditions are all met, and its level.
    pub(super) inch_2: bool,
    pub(super) inch_2_held: bool,
    pub(super) inch_2_direction: Direction,
    /// What a change of the direction does while inching 2 goes on.
    pub(super) inch_2_change: DirectionChange,
    /// The velocity setpoint is released and nothing is in the way.
    pub(super) velocity: bool,
    /// A fault acknowledgement whose conditions are all met.
    pub(super) acknowledge: bool,
    /// A key pressed just now whose conditions are all met.
    pub(super) key: Option<Key>,
    /// The key held; none while the keys are locked.
    pub(super) key_held: Option<Key>,
}

/// What the motion has reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    pub(super) at_rest: bool,
    /// The position is in the window of the setpoint.
    pub(super) in_window: bool,
    /// Beyond a limit and moving outward.
    pub(super) crossed_limit: bool,
    /// The velocity setpoint is released.
    pub(super) velocity_released: bool,
    /// What inpos mode does with the motor.
    pub(super) inpos: Motor,
    /// Inpos mode acts in the window already, and the window is that of this leg.
    pub(super) inpos_in_window: bool,
    /// The torque deactivation made it brake.
    pub(super) torque_tripped: bool,
}

impl State {
    /// Whether operation is enabled (ZSW.2).
    pub(crate) const fn operation_enabled(self) -> bool {
        match self {
            Self::OperationEnabled(_)
            | Self::TravelActive
            | Self::Pausing { .. }
            | Self::Paused { .. }
            | Self::Stopping
            | Self::Inching(_)
            | Self::VelocityTravelling => true,
            Self::Off
            | Self::NotReady
            | Self::ReadyToRun(_)
            | Self::Disabling
            | Self::KeyInching(_)
            | Self::KeyInchingEnding
            | Self::Fault
            | Self::TurnOnDisabled => false,
        }
    }

    /// What the output stage does with the motor in this state.
    pub(crate) const fn motor(self) -> Motor {
        match self {
            Self::ReadyToRun(motor) | Self::OperationEnabled(motor) => motor,
            Self::Disabling
            | Self::TravelActive
            | Self::Pausing { .. }
            | Self::Paused { .. }
            | Self::Stopping
            | Self::Inching(_)
            | Self::VelocityTravelling
            | Self::KeyInching(_)
            | Self::KeyInchingEnding => Motor::InControl,
            Self::Off | Self::NotReady | Self::Fault | Self::TurnOnDisabled => Motor::Released,
        }
    }

    /// A travel job is active, paused or being stopped, or inching is: no other can start, nothing that changes
    /// what a position means may be written.
    pub(crate) const fn job_active(self) -> bool {
        matches!(self, Self::Paused { .. }) || self.positioning_active()
    }

    /// A positioning is being executed, braked or inched, so that no other can start (SSW.14). A paused one shows as
    /// not active, as in the flow chart (C-05).
    pub(crate) const fn positioning_active(self) -> bool {
        match self {
            Self::TravelActive
            | Self::Pausing { .. }
            | Self::Stopping
            | Self::Inching(_)
            | Self::KeyInching(_)
            | Self::KeyInchingEnding => true,
            Self::Off
            | Self::NotReady
            | Self::ReadyToRun(_)
            | Self::OperationEnabled(_)
            | Self::Disabling
            | Self::Paused { .. }
            | Self::VelocityTravelling
            | Self::Fault
            | Self::TurnOnDisabled => false,
        }
    }

    /// Power, faults, torque.
    #[inline]
    pub(super) fn on_plant(self, plant: Conditions) -> (Self, Action) {
        match self {
            // row 1
            Self::Off if plant.control_supply => (Self::powered(plant.supply_ok), Action::PowerOn),
            Self::Off => (Self::Off, Action::None),
            // manual 2.6, power failure; row 1 follows when the supply returns
            _powered if !plant.control_supply => (Self::Off, Action::Release),

            // row 9; further faults while one is latched are only entered in the buffer
            Self::Fault => (Self::Fault, Action::None),
            _any if plant.fault_cause => (Self::Fault, Action::Release),

            // row 2
            Self::NotReady if plant.supply_ok => (Self::ReadyToRun(Motor::Released), Action::None),
            Self::NotReady => (Self::NotReady, Action::None),
            // row 3, AG03/1
            _supplied if !plant.supply_ok => (Self::NotReady, Action::Release),

            // row 3b, AG03
            live if !plant.output_stage && live.motor() != Motor::Released => {
                let next = if live.operation_enabled() { Self::OperationEnabled } else { Self::ReadyToRun };
                (next(Motor::Released), Action::Release)
            }
            // row 3b, the way back, like row 4
            Self::OperationEnabled(Motor::Released) if plant.output_stage_returned => {
                (Self::OperationEnabled(Motor::InControl), Action::TakeControl)
            }

            // row 27
            Self::TravelActive if plant.torque_exceeded && plant.torque_discards_job => {
                (Self::Stopping, Action::TorqueBrake)
            }
            Self::TravelActive | Self::Pausing { torque_tripped: false } if plant.torque_exceeded => {
                (Self::Pausing { torque_tripped: true }, Action::TorqueBrake)
            }
            // row 27b
            Self::Inching(Inching::One | Inching::Two(_)) if plant.torque_exceeded => {
                (Self::Inching(Inching::Ending), Action::TorqueBrake)
            }
            Self::KeyInching(_) if plant.torque_exceeded => (Self::KeyInchingEnding, Action::TorqueBrake),

            Self::ReadyToRun(_)
            | Self::OperationEnabled(_)
            | Self::Disabling
            | Self::TravelActive
            | Self::Pausing { .. }
            | Self::Paused { .. }
            | Self::Stopping
            | Self::Inching(_)
            | Self::VelocityTravelling
            | Self::KeyInching(_)
            | Self::KeyInchingEnding
            | Self::TurnOnDisabled => (self, Action::None),
        }
    }

    /// The state after power-on (row 1).
    pub(super) const fn powered(supply_ok: bool) -> Self {
        if supply_ok { Self::ReadyToRun(Motor::Released) } else { Self::NotReady }
    }

    /// The master and the keys.
    #[inline]
    pub(super) fn on_command(self, asked: &Asked) -> (Self, Action) {
        match self {
            // rows 1, 2 wait for supplies, whatever is asked
            Self::Off | Self::NotReady => (self, Action::None),

            // row 10
            Self::Fault if asked.acknowledge => (Self::TurnOnDisabled, Action::None),
            // rows 11, 12
            Self::Fault => (Self::Fault, Action::None),
            // row 13
            Self::TurnOnDisabled if asked.turn_on_again => (Self::ReadyToRun(Motor::Released), Action::None),
            // row 14
            Self::TurnOnDisabled => (Self::TurnOnDisabled, Action::None),

            // row 4; the AG03 is enabled without its enable input too, but gets no torque (row 3b)
            Self::ReadyToRun(_) if asked.enable && asked.output_stage => {
                (Self::OperationEnabled(Motor::InControl), Action::TakeControl)
            }
            Self::ReadyToRun(_) if asked.enable => (Self::OperationEnabled(Motor::Released), Action::None),
            Self::ReadyToRun(motor) => match asked.key {
                // row 52
                Some(key) => (Self::KeyInching(key), Action::StartKey(key)),
                // row 5; OFF1 and OFF2 also release a motor that row 8 left in control, or row 27b under a held key
                None if motor != Motor::Released && asked.release && asked.key_held.is_none() => {
                    (Self::ReadyToRun(Motor::Released), Action::Release)
                }
                // row 5
                None => (Self::ReadyToRun(motor), Action::None),
            },
            // row 53
            Self::KeyInching(key) if asked.key_held != Some(key) => {
                (Self::KeyInchingEnding, Action::BrakeStopMode)
            }
            Self::KeyInching(key) => (Self::KeyInching(key), Action::FollowKey(key)),
            Self::KeyInchingEnding => (Self::KeyInchingEnding, Action::None),

            // rows 6, 7; rows 50, 51: so does the end of the bus (C-24)
            _enabled_or_disabling if asked.release => (Self::ReadyToRun(Motor::Released), Action::Release),
            // row 8; enabling again waits until the shaft stands
            Self::Disabling => (Self::Disabling, Action::None),
            // row 8, a motor that is not in control stays so
            Self::OperationEnabled(motor @ (Motor::Released | Motor::Shorted)) if !asked.enable => {
                (Self::ReadyToRun(motor), Action::None)
            }
            // row 8
            _enabled if !asked.enable => (Self::Disabling, Action::BrakeMaximum),

            // row 26
            Self::TravelActive | Self::Pausing { .. } | Self::Paused { .. } if asked.stop => {
                (Self::Stopping, Action::BrakeMaximum)
            }
            // row 24
            Self::TravelActive if asked.intermediate_stop => {
                (Self::Pausing { torque_tripped: false }, Action::BrakeProgrammed)
            }
            // row 22: an edge during the job is refused before it gets here
            Self::TravelActive => (Self::TravelActive, Action::None),
            // row 25
            Self::Pausing { .. } | Self::Paused { .. } if asked.resume => {
                (Self::TravelActive, Action::ResumeTravel)
            }
            // C-13: after a torque deactivation a new edge starts a new job
            Self::Paused { torque_tripped: true } if asked.travel => {
                (Self::TravelActive, Action::StartTravel)
            }
            // row 24, the shaft still brakes
            Self::Pausing { torque_tripped } => (Self::Pausing { torque_tripped }, Action::None),
            // row 25b
            Self::Paused { torque_tripped } => (Self::Paused { torque_tripped }, Action::None),
            // row 26
            Self::Stopping => (Self::Stopping, Action::None),

            // row 20
            Self::OperationEnabled(_) if asked.travel => (Self::TravelActive, Action::StartTravel),
            // row 28
            Self::OperationEnabled(_) if asked.inch_1 => (Self::Inching(Inching::One), Action::StartInching1),
            // row 31
            Self::OperationEnabled(_) if asked.inch_2 => {
                let direction = asked.inch_2_direction;
                (Self::Inching(Inching::Two(direction)), Action::StartInching2(direction))
            }
            // row 40
            Self::OperationEnabled(_) if asked.velocity => (Self::VelocityTravelling, Action::FollowVelocity),
            // rows 21, 35, 36: what is refused changes nothing
            Self::OperationEnabled(motor) => (Self::OperationEnabled(motor), Action::None),

            // row 30
            Self::Inching(Inching::One) if !asked.inch_1_held => {
                (Self::Inching(Inching::Ending), Action::BrakeProgrammed)
            }
            // row 29
            Self::Inching(Inching::One) => (self, Action::None),
            // row 32
            Self::Inching(Inching::Two(_)) if !asked.inch_2_held => {
                (Self::Inching(Inching::Ending), Action::BrakeStopMode)
            }
            // row 33
            Self::Inching(Inching::Two(direction)) if asked.inch_2_direction != direction => {
                let other = asked.inch_2_direction;
                match asked.inch_2_change {
                    DirectionChange::Reverses => {
                        (Self::Inching(Inching::Two(other)), Action::FollowInching2(other))
                    }
                    DirectionChange::Ends => (Self::Inching(Inching::Ending), Action::BrakeStopMode),
                    DirectionChange::IsIgnored => (self, Action::FollowInching2(direction)),
                }
            }
            // row 31, PNU 1035 acts while inching
            Self::Inching(Inching::Two(direction)) => (self, Action::FollowInching2(direction)),
            Self::Inching(Inching::Ending) => (self, Action::None),

            // rows 41, 42
            Self::VelocityTravelling => (Self::VelocityTravelling, Action::FollowVelocity),
        }
    }

    /// What the shaft has reached.
    pub(super) fn on_motion(self, reached: Reached) -> (Self, Action) {
        match self {
            // row 8
            Self::Disabling if reached.at_rest => (Self::ReadyToRun(Motor::InControl), Action::None),
            // row 24, row 27
            Self::Pausing { torque_tripped } if reached.at_rest => {
                (Self::Paused { torque_tripped }, Action::None)
            }
            // row 23 with inpos mode in the window: a motor in control goes on to the setpoint
            Self::TravelActive
                if reached.in_window && reached.inpos_in_window && reached.inpos != Motor::InControl =>
            {
                (Self::OperationEnabled(reached.inpos), Action::Release)
            }
            // row 23
            Self::TravelActive if reached.at_rest && reached.in_window => {
                (Self::OperationEnabled(reached.inpos), Action::None)
            }
            // row 34b
            Self::TravelActive if reached.crossed_limit => (Self::Stopping, Action::BrakeMaximum),
            // row 26
            Self::Stopping if reached.at_rest => (Self::OperationEnabled(Motor::InControl), Action::None),
            // rows 29, 30, 32, 33
            Self::Inching(_) if reached.at_rest => (Self::OperationEnabled(Motor::InControl), Action::None),
            // row 34
            Self::Inching(Inching::One | Inching::Two(_)) if reached.crossed_limit => {
                (Self::Inching(Inching::Ending), Action::BrakeMaximum)
            }
            Self::KeyInching(_) if reached.crossed_limit => (Self::KeyInchingEnding, Action::BrakeMaximum),
            // row 42
            Self::VelocityTravelling if reached.at_rest && !reached.velocity_released => {
                (Self::OperationEnabled(Motor::InControl), Action::None)
            }
            // row 27b
            Self::KeyInchingEnding if reached.at_rest && reached.torque_tripped => {
                (Self::ReadyToRun(Motor::InControl), Action::None)
            }
            // row 53
            Self::KeyInchingEnding if reached.at_rest => (Self::ReadyToRun(Motor::Released), Action::None),

            Self::Off
            | Self::NotReady
            | Self::ReadyToRun(_)
            | Self::OperationEnabled(_)
            | Self::Disabling
            | Self::TravelActive
            | Self::Pausing { .. }
            | Self::Paused { .. }
            | Self::Stopping
            | Self::Inching(_)
            | Self::VelocityTravelling
            | Self::KeyInching(_)
            | Self::KeyInchingEnding
            | Self::Fault
            | Self::TurnOnDisabled => (self, Action::None),
        }
    }
}

impl Direction {
    pub(super) const fn negative_if(negative: bool) -> Self {
        if negative { Self::Negative } else { Self::Positive }
    }

    /// The direction of a way in user units; that of none is positive.
    pub(super) const fn of(way: i32) -> Self {
        Self::negative_if(way < 0)
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Positive => "positive",
            Self::Negative => "negative",
        })
    }
}
