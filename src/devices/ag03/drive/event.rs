//! What has happened in the drive, told from its status before and after a step.
//!
//! Nothing is collected while the drive runs: only a step that has changed the [status](Status) is looked at.

use core::fmt;

use super::motion::rpm;
use super::states::{Direction, Inching, Key, Motor, State};
use super::{Command, Drive, Limits, Mode, Operation, Status};
use crate::devices::ag03::param::Position;

/// Something that has happened in the drive, without words of a bus. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// Operation is enabled.
    Enabled(Motor),
    /// Operation is no longer enabled.
    Disabled {
        /// Why.
        cause: DisableCause,
        /// What the output stage does with the motor now.
        motor: Motor,
    },
    /// The operating mode has changed.
    Mode(Mode),
    /// A travel job has started.
    TravelStarted(Travel),
    /// The travel job is interrupted and kept.
    Paused {
        /// By the torque deactivation instead of the bus.
        torque: bool,
    },
    /// The travel job goes on.
    Resumed {
        /// Its target.
        target: Position,
    },
    /// The travel job has ended in the position window of its target.
    TargetReached {
        /// Actual position.
        position: Position,
        /// The target.
        target: Position,
    },
    /// The travel job has ended without reaching its target.
    Discarded {
        /// Its target.
        target: Position,
        /// Actual position.
        position: Position,
        /// It is beyond a limit that was programmed during the job.
        beyond_limit: bool,
    },
    /// A shaft that had to brake stands.
    Stands {
        /// Actual position.
        position: Position,
    },
    /// Inching has started or changed its direction.
    InchingStarted(Inch),
    /// Inching has ended.
    InchingEnded {
        /// Actual position.
        position: Position,
    },
    /// The shaft turns with the velocity setpoint.
    VelocityStarted(Velocity),
    /// The velocity setpoint has changed while the shaft turns with it. Told at most once a second, the last value always.
    VelocityChanged(Velocity),
    /// The velocity setpoint is no longer released and the shaft has run down.
    VelocityEnded,
    /// A fault was acknowledged: turning on is disabled.
    Acknowledged,
    /// Turning on is no longer disabled.
    Rearmed,
    /// A supply is missing: the drive is not ready.
    NotReady,
    /// All supplies are there: the drive is ready to run.
    Ready,
    /// A warning has come or gone.
    Warning {
        /// Which.
        warning: Warning,
        /// It has come.
        present: bool,
    },
}

/// Why operation is no longer enabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum DisableCause {
    /// The command wants this instead.
    Command(Operation),
    /// The drive went to fault.
    Fault,
    /// A supply is missing.
    Supply,
}

/// A travel job that has started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Where it leads to.
    pub target: Position,
    /// Actual position.
    pub position: Position,
    /// The limits in force, in user units.
    pub limits: Limits,
    /// The speed of the job.
    pub rpm: i32,
}

/// A velocity setpoint, positive in counting direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Velocity {
    /// As it was commanded, in rpm.
    pub setpoint: i32,
    /// Limited to what the gear allows, in rpm.
    pub rpm: i32,
}

/// Which inching.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Inch {
    /// Inching 1, once by delta inch.
    One(Direction),
    /// Inching 2, as long as it is asked for.
    Two(Direction),
    /// With a key of the housing.
    Key(Key),
}

/// What is not in order and does not stop the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Warning {
    /// Battery of the encoder below its limit.
    BatteryLow,
    /// Motor current out of range.
    CurrentOutOfRange,
    /// The load is too high for the commanded speed.
    LagError,
}

impl Warning {
    /// Every warning.
    pub(crate) const ALL: [Self; 3] = [Self::BatteryLow, Self::CurrentOutOfRange, Self::LagError];
}

impl Drive {
    /// The setpoint that the shaft turns with; `None`: it does not turn with one.
    #[inline]
    pub(crate) fn velocity_in_force(&self, command: &Command) -> Option<Velocity> {
        let velocity = || Velocity { setpoint: command.setpoint, rpm: self.velocity_setpoint(command) };
        (self.state == State::VelocityTravelling && command.turn).then(velocity)
    }

    /// A position in user units, with the unit that is in force.
    pub(super) const fn place(&self, position: i32) -> Position {
        self.frame.lengths.position(position as i64)
    }

    /// Says what the last step, whose command was `command`, has changed between `before` and `after`.
    #[inline]
    pub(crate) fn tell(&self, before: &Status, after: &Status, command: &Command, say: impl FnMut(Event)) {
        if !unchanged(before, after) {
            self.tell_changes(before, after, command, say);
        }
    }

    #[inline(never)]
    fn tell_changes(&self, before: &Status, after: &Status, command: &Command, mut say: impl FnMut(Event)) {
        self.tell_power(before, after, &mut say);
        if before.state != State::Off && after.state != State::Off && before.mode != after.mode {
            say(Event::Mode(after.mode));
        }
        if !before.operation_enabled && after.operation_enabled {
            say(Event::Enabled(after.motor));
        }
        self.tell_travel(before, after, command, &mut say);
        self.tell_inching(before, after, &mut say);
        self.tell_velocity(before, after, command, &mut say);
        if before.operation_enabled && !after.operation_enabled && after.state != State::Off {
            let cause = match after.state {
                State::Fault => DisableCause::Fault,
                State::NotReady => DisableCause::Supply,
                State::Off
                | State::ReadyToRun(_)
                | State::OperationEnabled(_)
                | State::Disabling
                | State::TravelActive
                | State::Pausing { .. }
                | State::Paused { .. }
                | State::Stopping
                | State::Inching(_)
                | State::VelocityTravelling
                | State::KeyInching(_)
                | State::KeyInchingEnding
                | State::TurnOnDisabled => DisableCause::Command(command.operation),
            };
            say(Event::Disabled { cause, motor: after.motor });
        }
        let stood = matches!(before.state, State::Disabling) && matches!(after.state, State::ReadyToRun(_));
        let stopped = before.state == State::Stopping && matches!(after.state, State::OperationEnabled(_));
        let paused =
            matches!(before.state, State::Pausing { .. }) && matches!(after.state, State::Paused { .. });
        if stood || stopped || paused {
            say(Event::Stands { position: self.place(after.position) });
        }
        for (warning, was, is) in [
            (Warning::BatteryLow, before.battery_low, after.battery_low),
            (Warning::CurrentOutOfRange, before.current_out_of_range, after.current_out_of_range),
            (Warning::LagError, before.lag_error, after.lag_error),
        ] {
            if was != is && after.state != State::Off {
                say(Event::Warning { warning, present: is });
            }
        }
    }

    fn tell_power(&self, before: &Status, after: &Status, say: &mut impl FnMut(Event)) {
        if before.state == after.state {
            return;
        }
        if after.state == State::NotReady {
            say(Event::NotReady);
        }
        if before.state == State::NotReady && matches!(after.state, State::ReadyToRun(_)) {
            say(Event::Ready);
        }
        if before.state == State::Fault && matches!(after.state, State::TurnOnDisabled | State::ReadyToRun(_))
        {
            say(Event::Acknowledged);
        }
        if before.state == State::TurnOnDisabled && matches!(after.state, State::ReadyToRun(_)) {
            say(Event::Rearmed);
        }
    }

    fn tell_travel(&self, before: &Status, after: &Status, command: &Command, say: &mut impl FnMut(Event)) {
        let travels =
            |state| matches!(state, State::TravelActive | State::Pausing { .. } | State::Paused { .. });
        let started = before.state != State::Off && after.state != State::Off && before.jobs != after.jobs;
        let position = self.place(after.position);
        let target = self.place(self.setpoint);
        if started {
            let limits = self.frame.limits;
            let rpm = super::scale::round(rpm(self.job.dynamics.speed));
            let position = self.place(before.position);
            say(Event::TravelStarted(Travel { target, position, limits, rpm }));
        } else if travels(before.state) && after.state == State::TravelActive && before.state != after.state {
            say(Event::Resumed { target });
        }
        let ran = travels(before.state) || started;
        if ran && !travels(after.state) {
            let reached = after.target_reached && after.operation_enabled && !command.stop;
            let beyond_limit = self.limits_changed
                && after.state == State::Stopping
                && (after.above_upper_limit || after.below_lower_limit);
            say(match reached {
                true => Event::TargetReached { position, target },
                false => Event::Discarded { target, position, beyond_limit },
            });
        }
        match (before.state, after.state) {
            (State::Pausing { .. } | State::Paused { .. }, _) => {}
            (_, State::Pausing { torque_tripped } | State::Paused { torque_tripped }) => {
                say(Event::Paused { torque: torque_tripped });
            }
            (_, _) => {}
        }
    }

    fn tell_inching(&self, before: &Status, after: &Status, say: &mut impl FnMut(Event)) {
        if before.state == after.state || after.state == State::Off {
            return;
        }
        let way = self.setpoint.saturating_sub(before.position);
        let inch = match after.state {
            State::Inching(Inching::One) => Some(Inch::One(Direction::of(way))),
            State::Inching(Inching::Two(direction)) => Some(Inch::Two(direction)),
            State::KeyInching(key) => Some(Inch::Key(key)),
            State::Inching(Inching::Ending)
            | State::KeyInchingEnding
            | State::Off
            | State::NotReady
            | State::ReadyToRun(_)
            | State::OperationEnabled(_)
            | State::Disabling
            | State::TravelActive
            | State::Pausing { .. }
            | State::Paused { .. }
            | State::Stopping
            | State::VelocityTravelling
            | State::Fault
            | State::TurnOnDisabled => None,
        };
        if let Some(inch) = inch {
            say(Event::InchingStarted(inch));
        }
        let inches =
            |state| matches!(state, State::Inching(_) | State::KeyInching(_) | State::KeyInchingEnding);
        if inches(before.state) && !inches(after.state) {
            say(Event::InchingEnded { position: self.place(after.position) });
        }
    }

    fn tell_velocity(&self, before: &Status, after: &Status, command: &Command, say: &mut impl FnMut(Event)) {
        match (before.state == State::VelocityTravelling, after.state == State::VelocityTravelling) {
            (false, true) => {
                let rpm = self.velocity_setpoint(command);
                say(Event::VelocityStarted(Velocity { setpoint: command.setpoint, rpm }));
            }
            (true, false) if after.state != State::Off => say(Event::VelocityEnded),
            (true, false) | (false, false) | (true, true) => {}
        }
    }
}

/// Whether nothing that an event tells of has changed.
#[inline]
fn unchanged(before: &Status, after: &Status) -> bool {
    before.state == after.state
        && before.jobs == after.jobs
        && before.mode == after.mode
        && before.battery_low == after.battery_low
        && before.current_out_of_range == after.current_out_of_range
        && before.lag_error == after.lag_error
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Enabled(motor) => write!(f, "operation enabled, {motor}"),
            Self::Disabled { cause, motor } => write!(f, "operation disabled, {motor}: {cause}"),
            Self::Mode(Mode::Positioning) => f.write_str("positioning mode"),
            Self::Mode(Mode::Velocity) => f.write_str("velocity mode"),
            Self::TravelStarted(travel) => travel.fmt(f),
            Self::Paused { torque: false } => f.write_str("travel paused by intermediate stop"),
            Self::Paused { torque: true } => f.write_str("travel interrupted by the torque deactivation"),
            Self::Resumed { target } => write!(f, "travel to {target} goes on"),
            Self::TargetReached { position, target } => {
                write!(f, "target {target} reached, position {position}")
            }
            Self::Discarded { target, position, beyond_limit } => {
                write!(f, "travel to {target} discarded at position {position}")?;
                f.write_str(if *beyond_limit { ", beyond the limit that was changed meanwhile" } else { "" })
            }
            Self::Stands { position } => write!(f, "the shaft stands at position {position}"),
            Self::InchingStarted(Inch::One(direction)) => {
                write!(f, "inching 1 in {direction} direction started")
            }
            Self::InchingStarted(Inch::Two(direction)) => {
                write!(f, "inching 2 in {direction} direction started")
            }
            Self::InchingStarted(Inch::Key(key)) => write!(f, "inching started with the {key} key"),
            Self::InchingEnded { position } => write!(f, "inching ended at position {position}"),
            Self::VelocityStarted(velocity) => write!(f, "turning with {velocity}"),
            Self::VelocityChanged(velocity) => write!(f, "velocity setpoint changed: {velocity}"),
            Self::VelocityEnded => f.write_str("no longer turning with the setpoint"),
            Self::Acknowledged => f.write_str("fault acknowledged, turning on is disabled"),
            Self::Rearmed => f.write_str("turning on is no longer disabled: operation can be enabled again"),
            Self::NotReady => f.write_str("not ready: a supply voltage is missing"),
            Self::Ready => f.write_str("ready to run: all supply voltages are there"),
            Self::Warning { warning, present: true } => {
                write!(f, "warning: {}, {}", warning.name(), warning.advice())
            }
            Self::Warning { warning, present: false } => write!(f, "warning ended: {}", warning.name()),
        }
    }
}

impl fmt::Display for Travel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { target, position, limits, rpm } = self;
        write!(f, "travel to {target} started from {position} with {rpm} rpm, ")?;
        if limits.are_monitored() {
            let place = |limit: i32| position.lengths().position(limit.into());
            write!(f, "limits {} to {}", place(limits.lower()), place(limits.upper()))
        } else {
            f.write_str("no limits: both are equal")
        }
    }
}

impl fmt::Display for Velocity {
    /// `20 rpm`, with the setpoint if that is not possible.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { setpoint, rpm } = self;
        write!(f, "{rpm} rpm")?;
        if setpoint == rpm {
            return Ok(());
        }
        write!(f, ", the setpoint {setpoint} rpm is limited: the gear allows at most {} rpm", rpm.abs())
    }
}

impl fmt::Display for DisableCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Command(Operation::Release) => "the command is to release it",
            Self::Command(Operation::BrakeAndRelease) => "the command is to brake, then release it",
            Self::Command(Operation::BrakeAndHold) => "the command is to brake, then hold",
            Self::Command(Operation::Run) => "the drive cannot run",
            Self::Fault => "fault",
            Self::Supply => "a supply voltage is missing",
        })
    }
}

impl fmt::Display for Motor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Released => "motor released",
            Self::InControl => "motor in control",
            Self::Shorted => "motor windings shorted",
        })
    }
}

impl fmt::Display for Key {
    /// `clockwise`, as in "the clockwise key".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Clockwise => "clockwise",
            Self::CounterClockwise => "counter-clockwise",
        })
    }
}

impl Warning {
    const fn name(self) -> &'static str {
        match self {
            Self::BatteryLow => "the battery of the encoder is low",
            Self::CurrentOutOfRange => "motor current out of range",
            Self::LagError => "lag error",
        }
    }

    /// What follows, or what to do while it is present.
    const fn advice(self) -> &'static str {
        match self {
            Self::BatteryLow => "replace it",
            Self::CurrentOutOfRange => "fault C follows if it stays",
            Self::LagError => "the load is too high for the commanded speed",
        }
    }
}
