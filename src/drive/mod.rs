//! The drive, bus-neutral: state machine and motion of an AG03 or AG03/1.
//!
//! It knows rpm, increments, user units and named flags, but no control words, bits or telegrams: a bus builds a
//! [`Command`] from its control word and composes its status words from [`Status`]. Parameters come in as
//! [`Settings`], the world around the drive as [`Inputs`].
//!
//! ```text
//! Command ──▶ requests ──▶ states ──▶ motion ──▶ status ──▶ Status
//!              edges,       rows of    where       flags
//!              refusals     section 8  the shaft is
//! ```
//!
//! ```
//! use core::time::Duration;
//! use profidrive::drive::{Command, Drive, Settings};
//! use profidrive::param::{Gear, Model, Store};
//!
//! let settings = Settings::read(&Store::new(Model::Ag03_1, Gear::Ratio48));
//! let mut drive = Drive::new(Model::Ag03_1, Gear::Ratio48, &settings);
//! let enable = Command { on: true, no_off2: true, enable_operation: true, ..Command::default() };
//! drive.step(Duration::from_millis(1), Some(&enable), &settings);
//! assert!(drive.status().operation_enabled);
//! ```
//!
//! The shaft is ideal: it is always where the profile says. Faults, warnings and torque are inputs. Where the manuals
//! are silent the choices of `ag03.md` (INF, C-nn) hold; the names are cited where they are made.

mod faults;
mod memory;
mod motion;
mod refusal;
mod requests;
mod scale;
mod settings;
mod states;
mod status;

use core::time::Duration;

use thiserror::Error;

use crate::param::{Gear, Model};

pub use faults::{Fault, FaultBuffer, FaultSet};
pub use memory::Memory;
pub use refusal::{Reason, Refusal, Request};
pub use settings::{Limits, Mode, PosType, SenseOfRotation, Settings, StopMode};
pub use states::{Direction, Inching, Key, Motor, State};
pub use status::Status;

use motion::{COAST_DECELERATION, MAXIMUM_DECELERATION, Motion, acceleration, rpm, velocity};
use requests::Job;
use scale::Scale;
use states::{Action, Plant, Reached};

/// What a master asks for, without bit positions (manual chapters 7.5.1 and 7.5.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Command {
    /// STW.0: 1 = ON, 0 = OFF1.
    pub on: bool,
    /// STW.1: 1 = no OFF2, 0 = OFF2.
    pub no_off2: bool,
    /// STW.3: 1 = enable operation.
    pub enable_operation: bool,
    /// STW.4 (positioning): 0 = stop, discard the job.
    pub no_stop: bool,
    /// STW.5 (positioning): 0 = intermediate stop.
    pub no_intermediate_stop: bool,
    /// STW.6: positioning: each change starts a travel job; velocity: 1 = setpoint released.
    pub start: bool,
    /// STW.7: rising edge acknowledges a fault.
    pub acknowledge: bool,
    /// STW.8 (positioning): rising edge starts inching 1, 0 ends it.
    pub inch_1: bool,
    /// STW.9 (positioning): rising edge starts inching 2, 0 ends it.
    pub inch_2: bool,
    /// STW.15: direction of inching 2 is negative.
    pub inch_2_negative: bool,
    /// HSW: target position in user units, or target velocity in rpm (limited to what the gear allows).
    pub setpoint: i32,
}

impl Command {
    /// Whether the command enables operation (row 4).
    const fn enables(&self) -> bool {
        self.on && self.no_off2 && self.enable_operation
    }
}

/// The world around the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inputs {
    /// Supply of the control; on an AG03 the only supply.
    pub control_supply: bool,
    /// AG03/1: supply of the output stage. AG03: enable input.
    pub output_stage: bool,
    /// Key 1 (AG03: right) is held.
    pub key_clockwise: bool,
    /// Key 2 (AG03: left) is held.
    pub key_counter_clockwise: bool,
    /// Causes of faults that are present. Those the model does not know are ignored.
    pub causes: FaultSet,
    /// Battery below its limit (warning).
    pub battery_low: bool,
    /// Motor current out of range (warning).
    pub current_out_of_range: bool,
    /// The shaft cannot follow (warning, while a motion is commanded).
    pub lag_error: bool,
    /// Torque in %, compared with the torque deactivation (PNU 1032).
    pub torque: u16,
}

impl Default for Inputs {
    /// Supplied and enabled, nothing wrong, no key, no torque.
    fn default() -> Self {
        Self {
            control_supply: true,
            output_stage: true,
            key_clockwise: false,
            key_counter_clockwise: false,
            causes: FaultSet::EMPTY,
            battery_low: false,
            current_out_of_range: false,
            lag_error: false,
            torque: 0,
        }
    }
}

impl Inputs {
    /// The key held; both together are none.
    const fn key(&self) -> Option<Key> {
        match (self.key_clockwise, self.key_counter_clockwise) {
            (true, false) => Some(Key::Clockwise),
            (false, true) => Some(Key::CounterClockwise),
            (true, true) | (false, false) => None,
        }
    }
}

/// Calibration was asked for during a travel job (manual chapter 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("calibration is only possible when no travel job or inching is active or paused")]
pub struct CalibrationError;

/// One drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    model: Model,
    gear: Gear,
    inputs: Inputs,
    inputs_changed: bool,
    /// The output stage input at the previous step.
    previous_output_stage: bool,
    /// The key held at the previous step.
    previous_key: Option<Key>,
    previous_connected: bool,
    /// The command of the previous step, all-zero outside Data_Exchange.
    previous: Command,
    state: State,
    frame: Frame,
    /// Positioning or velocity window; acts at once.
    window: u16,
    motion: Motion,
    /// Shaft position with the user position 0, increments.
    zero: f64,
    /// The job being executed or kept.
    job: Job,
    /// Programmed setpoint: that of the last job or inching 1, user units.
    setpoint: i32,
    setpoint_programmed: bool,
    job_acknowledge: bool,
    /// Start may take effect: it was 0 since the operating mode changed.
    start_armed: bool,
    faults: FaultBuffer,
    /// The faults entered since the last acknowledgement.
    entered: FaultSet,
    /// The latest of them.
    latched: Option<Fault>,
    refusal: Option<Refusal>,
    settled: bool,
}

/// Settings that a motion or a kept job must not change under way; taken over while the shaft stands.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Frame {
    mode: Mode,
    scale: Scale,
    limits: Limits,
}

impl Frame {
    fn of(settings: &Settings) -> Self {
        Self { mode: settings.mode, scale: Scale::new(settings), limits: settings.limits }
    }
}

impl Drive {
    /// A drive that was just powered on (row 1), with both supplies present and its shaft at position 0.
    pub fn new(model: Model, gear: Gear, settings: &Settings) -> Self {
        Self {
            model,
            gear,
            inputs: Inputs::default(),
            inputs_changed: false,
            previous_output_stage: true,
            previous_key: None,
            previous_connected: false,
            previous: Command::default(),
            state: State::powered(true),
            frame: Frame::of(settings),
            window: settings.window,
            motion: Motion::at(0.0),
            zero: 0.0,
            job: Job::NONE,
            setpoint: 0,
            setpoint_programmed: false,
            job_acknowledge: false,
            start_armed: true,
            faults: FaultBuffer::default(),
            entered: FaultSet::EMPTY,
            latched: None,
            refusal: None,
            settled: false,
        }
    }

    /// Lets `dt` pass under `command`; `None` = not in Data_Exchange, which acts as all-zero (row 50) and frees the
    /// keys (row 52).
    ///
    /// Inputs, command and settings act at the beginning of `dt`, then the shaft moves. Steps of 0.1 ms to 100 ms
    /// are meant; any length works, and a length of zero only evaluates.
    pub fn step(&mut self, dt: Duration, command: Option<&Command>, settings: &Settings) {
        let connected = command.is_some();
        let command = command.copied().unwrap_or_default();
        let state = self.state;
        let stood = self.motion.at_rest();
        let same = !self.inputs_changed
            && command == self.previous
            && connected == self.previous_connected
            && self.window == settings.window;
        self.inputs_changed = false;

        let same = !self.take_settings(settings) && same;
        self.on_plant(settings);
        self.on_command(&command, connected, settings);
        self.advance(dt);
        self.on_motion(settings);

        self.settled = same && stood && self.motion.at_rest() && self.state == state;
    }

    /// What the drive reports now.
    pub fn status(&self) -> Status {
        self.compose()
    }

    /// Whether another step with the same command, inputs and settings would change nothing.
    pub fn is_at_rest(&self) -> bool {
        self.settled
    }

    /// The world around the drive as last set.
    pub fn inputs(&self) -> Inputs {
        self.inputs
    }

    /// Changes the world around the drive; the next step reacts.
    pub fn set_inputs(&mut self, inputs: Inputs) {
        let inputs = Inputs { causes: inputs.causes.known_to(self.model), ..inputs };
        if inputs != self.inputs {
            self.inputs = inputs;
            self.inputs_changed = true;
            self.settled = false;
        }
    }

    /// Makes the present position `value` in user units (PNU 970 = 5).
    ///
    /// # Errors
    /// [`CalibrationError`] while a travel job or inching is active or paused.
    pub fn calibrate(&mut self, value: i32) -> Result<(), CalibrationError> {
        if self.state.job_active() {
            return Err(CalibrationError);
        }
        self.zero = self.motion.position() - self.frame.scale.increments(f64::from(value));
        self.settled = false;
        Ok(())
    }

    /// Fault buffer and fault counter.
    pub fn faults(&self) -> &FaultBuffer {
        &self.faults
    }

    /// Clears fault buffer and fault counter (PNU 970 = 4). A latched fault stays latched.
    pub fn clear_faults(&mut self) {
        self.faults = FaultBuffer::default();
    }

    /// The last request that was refused, once. A newer refusal replaces one that was not taken.
    pub fn take_refusal(&mut self) -> Option<Refusal> {
        self.refusal.take()
    }

    /// Takes over what may change now. Returns whether that was anything.
    fn take_settings(&mut self, settings: &Settings) -> bool {
        self.window = settings.window;
        if !self.motion.at_rest() || self.state.job_active() {
            return false;
        }
        let before = self.frame;
        self.frame = Frame::of(settings);
        if before.mode != self.frame.mode {
            // A level in one mode is an edge in the other: start must be taken back once (`ag03.md` 3.4).
            self.start_armed = false;
            if self.state == State::VelocityTravelling {
                self.state = State::OperationEnabled(Motor::InControl);
            }
        }
        before != self.frame
    }

    fn on_plant(&mut self, settings: &Settings) {
        let plant = Plant {
            control_supply: self.inputs.control_supply,
            supply_ok: self.supply_ok(),
            output_stage: self.inputs.output_stage,
            output_stage_returned: self.inputs.output_stage && !self.previous_output_stage,
            fault_cause: !self.inputs.causes.is_empty(),
            torque_exceeded: settings.torque_deactivation.is_some_and(|percent| self.inputs.torque > percent),
        };
        self.previous_output_stage = self.inputs.output_stage;
        let (next, action) = self.state.on_plant(plant);
        if next == State::Fault {
            self.enter_faults();
        }
        self.enact(next, action, &Command::default(), settings);
    }

    /// Row 9: each cause once until it is acknowledged.
    fn enter_faults(&mut self) {
        for fault in self.inputs.causes.minus(self.entered).iter() {
            self.faults.enter(fault);
            self.entered = self.entered.with(fault);
            self.latched = Some(fault);
        }
    }

    fn on_command(&mut self, command: &Command, connected: bool, settings: &Settings) {
        let asked = self.asked(command, connected, settings);
        let (next, action) = self.state.on_command(&asked);
        self.enact(next, action, command, settings);
        self.start_armed |= !command.start;
        self.previous = *command;
        self.previous_connected = connected;
    }

    fn on_motion(&mut self, settings: &Settings) {
        let position = self.position();
        let velocity = self.motion.velocity() * self.frame.scale.sign();
        let limits = self.frame.limits;
        let reached = Reached {
            at_rest: self.motion.at_rest(),
            in_window: self.in_window(position, rpm(velocity)),
            crossed_limit: (limits.is_above(position) && velocity > 0.0)
                || (limits.is_below(position) && velocity < 0.0),
            velocity_released: self.previous.start,
            inpos: settings.inpos,
        };
        let (next, action) = self.state.on_motion(reached);
        self.enact(next, action, &Command::default(), settings);
    }

    /// Goes to a state and does what belongs to the transition.
    fn enact(&mut self, next: State, action: Action, command: &Command, settings: &Settings) {
        if next != State::Fault {
            self.entered = FaultSet::EMPTY;
            self.latched = None;
        }
        self.state = next;
        match action {
            Action::None => {}
            Action::PowerOn => {
                self.setpoint = 0;
                self.setpoint_programmed = false;
                self.job_acknowledge = false;
                self.previous = Command::default();
                self.start_armed = true;
            }
            Action::Release => self.motion.brake(COAST_DECELERATION),
            Action::TakeControl | Action::BrakeMaximum => self.motion.brake(MAXIMUM_DECELERATION),
            Action::BrakeProgrammed => self.motion.brake(self.job.dynamics.deceleration),
            Action::BrakeStopMode => self.motion.brake(match settings.stop_mode_inch_2 {
                StopMode::Maximum => MAXIMUM_DECELERATION,
                StopMode::Ramp => self.job.dynamics.deceleration,
            }),
            Action::StartTravel => {
                self.job = self.job_to(command.setpoint, settings);
                self.setpoint = self.job.setpoint;
                self.setpoint_programmed = true;
                self.job_acknowledge = !self.job_acknowledge;
                self.start_leg();
            }
            Action::ResumeTravel => self.start_leg(),
            Action::StartInching1 => {
                self.job = self.inching_job(settings);
                self.setpoint = self.job.setpoint;
                self.setpoint_programmed = true;
                self.start_leg();
            }
            Action::StartInching2(direction) => {
                self.job = self.inching_job(settings);
                self.follow_inching_2(direction, settings);
            }
            Action::FollowInching2(direction) => self.follow_inching_2(direction, settings),
            Action::StartKey(key) => {
                self.job = self.inching_job(settings);
                self.follow_inching_2(self.key_direction(key), settings);
            }
            Action::FollowKey(key) => self.follow_inching_2(self.key_direction(key), settings),
            Action::FollowVelocity => {
                let target = velocity(self.velocity_setpoint(command)) * self.frame.scale.sign();
                self.follow(target, acceleration(settings.a_rot));
            }
        }
    }

    fn advance(&mut self, dt: Duration) {
        let left = self.motion.advance(dt);
        if let Some(left) = left
            && self.state == State::TravelActive
            && self.job.via.take().is_some()
        {
            self.start_leg();
            self.motion.skip(left);
        }
    }

    /// Travels to the loop point, or if there is none or the shaft is there, to the target.
    fn start_leg(&mut self) {
        if let Some(via) = self.job.via {
            self.motion.travel_to(via, self.job.dynamics);
            if !self.motion.at_rest() {
                return;
            }
            self.job.via = None;
        }
        self.motion.travel_to(self.job.target, self.job.dynamics);
    }

    fn follow_inching_2(&mut self, direction: Direction, settings: &Settings) {
        let speed = self.inching_2_speed(settings) * self.frame.scale.sign();
        let target = match direction {
            Direction::Positive => speed,
            Direction::Negative => -speed,
        };
        self.follow(target, self.job.dynamics.acceleration);
    }

    /// Lays a new ramp only if the target is new.
    fn follow(&mut self, target: f64, acceleration: f64) {
        if target != self.motion.final_velocity() {
            self.motion.ramp_to(target, acceleration);
        }
    }

    fn supply_ok(&self) -> bool {
        match self.model {
            Model::Ag03 => self.inputs.control_supply,
            Model::Ag03_1 => self.inputs.control_supply && self.inputs.output_stage,
        }
    }
}

#[cfg(test)]
mod tests;
