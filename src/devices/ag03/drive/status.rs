//! What the drive reports: named flags and values for every bus to compose its words from.

use super::faults::Fault;
use super::motion::rpm;
use super::scale::round;
use super::settings::Mode;
use super::states::{Motor, State};
use super::supplies::{Supplies, word};
use super::{Drive, StatusLed};

/// Speeds below this many rpm count as standstill in [`Status::travelling`] (manual Table 1, bit 4).
pub(super) const STANDSTILL_RPM: f64 = 2.0;

/// State of the drive after a step. The names in brackets say which bit of `ag03.md` sections 5 and 6 shows it.
///
/// Flags that a bus shows as fixed values in one of the modes are noted; they are composed there, not here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// State of section 8.
    pub state: State,
    /// Operating mode in effect. A mode written during a motion takes effect when the shaft stands.
    pub mode: Mode,
    /// Supplies present (ZSW.0, ZSW.1), also in fault and turn-on disabled (C-09). AG03: supply; AG03/1: supply of
    /// control and output stage.
    pub supply_ok: bool,
    /// Operation enabled (ZSW.2).
    pub operation_enabled: bool,
    /// The latched fault, of several the latest (ZSW.3, SSW.8, blink code).
    pub fault: Option<Fault>,
    /// Turn-on disabled (ZSW.6).
    pub turn_on_disabled: bool,
    /// One of [`Self::battery_low`], [`Self::current_out_of_range`], [`Self::lag_error`] (ZSW.7).
    pub warning: bool,
    /// The load is too high for the commanded speed (SSW.15; positioning: ZSW.8 inverted). Only while a motion is
    /// commanded.
    pub lag_error: bool,
    /// Positioning: position within the window of the programmed setpoint. Velocity: velocity within the window of
    /// the target, which is 0 while no setpoint is released (SSW.3; velocity: ZSW.8).
    pub in_window: bool,
    /// A job or inching 1 since power-on has set a setpoint.
    pub setpoint_programmed: bool,
    /// In the window of a setpoint that a job or inching 1 since power-on has set, and none in progress (ZSW.10,
    /// C-35). Means nothing in velocity mode, where ZSW.10 is fixed.
    pub target_reached: bool,
    /// Travel jobs accepted since power-on, modulo 256: each bus has its own way to acknowledge them (ZSW.12, C-07).
    pub jobs: u8,
    /// Positioning: no job, inching or braking is in progress; when a job is interrupted, as soon as the shaft stands
    /// (manual Table 12). A released shaft that runs out shows in [`Self::travelling`]. Velocity: the shaft stands
    /// (manual Table 14). ZSW.13.
    pub standstill: bool,
    /// Position above the upper limit (SSW.5, part of ZSW.14). Velocity: never.
    pub above_upper_limit: bool,
    /// Position below the lower limit (SSW.6, part of ZSW.14). Velocity: never.
    pub below_lower_limit: bool,
    /// Ready-to-travel (ZSW.15): [`Self::start_conditions_met`] with operation enabled. Positioning: not while a
    /// coasting shaft that was caught still brakes. Velocity: only while start is not given and the shaft stands
    /// (C-11).
    pub ready_to_travel: bool,
    /// No fault, no active positioning, output stage supplied or enabled, within the limits (SSW.11 inverted, as
    /// manual Table 1 lists it: without operation enabled).
    pub start_conditions_met: bool,
    /// The shaft turns with 2 rpm or more, driven or coasting (SSW.4).
    pub travelling: bool,
    /// The shaft turns at all; not shown on the bus, decides about writing parameters.
    pub moving: bool,
    /// A travel job is active, paused or being stopped, or inching is, or a velocity setpoint is released or still
    /// runs down; not shown on the bus, decides about writing parameters and calibrating (manual chapter 3).
    pub job_active: bool,
    /// Released shows in SSW.7.
    pub motor: Motor,
    /// A loop travel has not been at its loop point yet (SSW.9).
    pub approach_reversed: bool,
    /// AG03/1: supply of the output stage present. AG03: enable input active (SSW.10 inverted, PNU 1031.4).
    pub output_stage_ok: bool,
    /// Battery below its limit (SSW.12).
    pub battery_low: bool,
    /// Motor current out of range (SSW.13).
    pub current_out_of_range: bool,
    /// A positioning or inching is in progress (SSW.14). Velocity: never.
    pub positioning_active: bool,
    /// The torque deactivation interrupted the job (PNU 1031.7).
    pub torque_tripped: bool,
    /// Actual position in user units, rounded half away from zero, saturating (PNU 1036, HIW in positioning mode).
    pub position: i32,
    /// Actual velocity of the output shaft in rpm, positive in counting direction (HIW in velocity mode).
    pub velocity: i32,
    /// The green LED.
    pub led: StatusLed,
}

/// Measured values, in the units of the parameters that show them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measured {
    /// Output stage in 0.1 degC (PNU 1027).
    pub temperature: i16,
    /// Motor current in mA, without sign (PNU 1029).
    pub current: i16,
    /// Supply of the output stage in 0.1 V (PNU 1040); on an AG03 its only supply.
    pub output_supply: u16,
    /// Supply of the control in 0.1 V (PNU 1041).
    pub control_supply: u16,
    /// Battery in 0.01 V (PNU 1042).
    pub battery: u16,
    /// Intermediate circuit in 0.1 V; no parameter shows it.
    pub dc_link: u16,
}

/// What a shaft that turns can change while nothing else happens; the rest of [`Status`] follows from it, the state and
/// the settings.
struct Turning {
    position: i32,
    velocity: i32,
    flags: TurningFlags,
}

#[derive(Clone, Copy, PartialEq, Eq)]
struct TurningFlags {
    in_window: bool,
    above_upper_limit: bool,
    below_lower_limit: bool,
    travelling: bool,
    lag_error: bool,
    current_out_of_range: bool,
    approach_reversed: bool,
    moving: bool,
}

impl TurningFlags {
    const fn of(status: &Status) -> Self {
        Self {
            in_window: status.in_window,
            above_upper_limit: status.above_upper_limit,
            below_lower_limit: status.below_lower_limit,
            travelling: status.travelling,
            lag_error: status.lag_error,
            current_out_of_range: status.current_out_of_range,
            approach_reversed: status.approach_reversed,
            moving: status.moving,
        }
    }
}

impl Drive {
    /// Brings a status that was composed before the last step up to date, if that takes nothing but a new position and
    /// velocity; says whether it did. That is nearly all that a travelling drive reports, and spares composing the rest.
    #[inline]
    pub(crate) fn has_only_moved(&self, status: &mut Status) -> bool {
        if !self.only_moved || status.state != State::TravelActive {
            return false;
        }
        let Turning { position, velocity, flags } = self.turning();
        let only_moved = flags == TurningFlags::of(status);
        if only_moved {
            (status.position, status.velocity) = (position, velocity);
        }
        only_moved
    }

    #[inline(always)]
    fn turning(&self) -> Turning {
        let limits = self.frame.limits;
        let position = self.position();
        let rpm = rpm(self.shaft_velocity()) * self.frame.scale.sign();
        let positioning = self.frame.mode == Mode::Positioning;
        Turning {
            position,
            velocity: round(rpm),
            flags: TurningFlags {
                in_window: self.in_window(position, rpm),
                above_upper_limit: positioning && limits.is_above(position),
                below_lower_limit: positioning && limits.is_below(position),
                travelling: rpm >= STANDSTILL_RPM || rpm <= -STANDSTILL_RPM,
                lag_error: self.plant.lag_error() && self.motion_commanded(),
                current_out_of_range: self.plant.overcurrent(),
                approach_reversed: matches!(
                    self.state,
                    State::TravelActive | State::Pausing { .. } | State::Paused { .. }
                ) && self.job.via.is_some(),
                moving: !self.stands(),
            },
        }
    }

    pub(super) fn compose(&self) -> Status {
        let Supplies { output_stage, battery_low, ok: supply_ok, .. } = self.supplies;
        let Turning { position, velocity, flags } = self.turning();
        let TurningFlags {
            in_window,
            above_upper_limit,
            below_lower_limit,
            travelling,
            lag_error,
            current_out_of_range,
            approach_reversed,
            moving,
        } = flags;
        let state = self.state;
        let mode = self.frame.mode;
        let positioning_active = mode == Mode::Positioning && state.positioning_active();
        let start_conditions_met = state != State::Fault
            && !positioning_active
            && output_stage
            && !above_upper_limit
            && !below_lower_limit;
        let ready_to_travel = match mode {
            Mode::Positioning => state.operation_enabled() && start_conditions_met && self.stands(),
            Mode::Velocity => {
                let stands = matches!(state, State::OperationEnabled(_)) && self.stands();
                let idle = stands || state.operation_enabled() && self.quirks.ready_while_running_down;
                idle && start_conditions_met && !self.previous.turn
            }
        };
        Status {
            state,
            mode,
            supply_ok,
            operation_enabled: state.operation_enabled(),
            fault: self.latched,
            turn_on_disabled: state == State::TurnOnDisabled,
            warning: battery_low || current_out_of_range || lag_error,
            lag_error,
            in_window,
            setpoint_programmed: self.setpoint_programmed,
            target_reached: in_window
                && self.setpoint_programmed
                && !state.job_active()
                && !positioning_active,
            jobs: self.jobs,
            standstill: match mode {
                Mode::Positioning => !self.motion_commanded(),
                Mode::Velocity => self.stands(),
            },
            above_upper_limit,
            below_lower_limit,
            ready_to_travel,
            start_conditions_met,
            travelling,
            moving,
            job_active: self.job_active(),
            motor: state.motor(),
            approach_reversed,
            output_stage_ok: output_stage,
            battery_low,
            current_out_of_range,
            positioning_active,
            torque_tripped: self.torque_tripped,
            position,
            velocity,
            led: match self.latched {
                Some(fault) => StatusLed::Blinking(fault),
                None if state != State::Off && supply_ok && output_stage => StatusLed::On,
                None => StatusLed::Off,
            },
        }
    }

    pub(super) fn measure(&self) -> Measured {
        let inputs = &self.inputs;
        let signed = |value: f64| i16::try_from(round(value)).unwrap_or(i16::MAX);
        Measured {
            temperature: signed(self.plant.temperature(inputs) * 10.0),
            current: signed(self.plant.current() * 1000.0),
            output_supply: self.supplies.motor_decivolts,
            control_supply: self.supplies.control_decivolts,
            battery: self.supplies.battery_centivolts,
            dc_link: word(self.plant.dc_link(inputs) * 10.0),
        }
    }

    /// Whether the actual value is in the window of the setpoint, by operating mode.
    pub(super) fn in_window(&self, position: i32, rpm: f64) -> bool {
        match self.frame.mode {
            Mode::Positioning => position.abs_diff(self.setpoint) <= u32::from(self.window),
            Mode::Velocity => {
                let turns = self.state == State::VelocityTravelling;
                let target = if turns { self.velocity_setpoint(&self.previous) } else { 0 };
                (rpm - f64::from(target)).abs() <= f64::from(self.window)
            }
        }
    }

    /// What calibration waits for, and d-Pos by one reading of the manuals: a released velocity setpoint is a travel
    /// job too (manual Table 13, bit 0).
    pub(super) fn job_active(&self) -> bool {
        self.state.job_active() || self.state == State::VelocityTravelling
    }

    /// A job, inching, velocity or braking is being executed.
    fn motion_commanded(&self) -> bool {
        match self.state {
            State::TravelActive
            | State::Pausing { .. }
            | State::Stopping
            | State::Disabling
            | State::Inching(_)
            | State::VelocityTravelling
            | State::KeyInching(_)
            | State::KeyInchingEnding => true,
            State::Off
            | State::NotReady
            | State::ReadyToRun(_)
            | State::OperationEnabled(_)
            | State::Paused { .. }
            | State::Fault
            | State::TurnOnDisabled => false,
        }
    }
}
