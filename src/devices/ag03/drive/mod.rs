//! The drive, bus-neutral: state machine and motion of an AG03 or AG03/1.
//!
//! It knows rpm, increments, user units and named flags, but no control words, bits or telegrams: a bus builds a
//! [`Command`] from its control word and composes its status words from [`Status`]. Parameters come in as
//! [`Settings`], the world around the drive as [`Inputs`].
//!
//! ```text
//! Command ──▶ requests ──▶ states ──▶ motion ──▶ plant ──▶ status ──▶ Status
//!              edges,       rows of    where the   where    flags
//!              refusals     section 8  shaft       it is
//!                                      shall be
//! ```
//!
//! ```
//! use core::time::Duration;
//! use profidrive::devices::ag03::drive::{Command, Drive, Operation, Settings};
//! use profidrive::devices::ag03::param::{Gear, Model, Store};
//!
//! let settings = Settings::read(&Store::new(Model::Ag03_1, Gear::Ratio48));
//! let mut drive = Drive::new(Model::Ag03_1, Gear::Ratio48, &settings);
//! let run = Command { operation: Operation::Run, ..Command::default() };
//! drive.step(Duration::from_millis(1), &run, &settings);
//! assert!(drive.status().operation_enabled);
//! ```
//!
//! Faults, warnings and torque follow from the [plant] and its [`Inputs`]. Where the manuals are silent the
//! choices of `ag03.md` (INF, C-nn) hold; the names are cited where they are made, and [`Quirks`] has the others.

mod action;
mod command;
mod event;
mod faults;
mod inputs;
mod lapse;
pub mod leds;
mod memory;
mod motion;
pub mod plant;
mod quirks;
mod refusal;
mod requests;
mod scale;
mod settings;
mod states;
mod status;
mod supplies;

use core::time::Duration;

use thiserror::Error;

use crate::devices::ag03::param::{Gear, Lengths, Model, Parameter};

pub use command::{Command, Operation};
pub use event::{DisableCause, Event, Inch, Travel, Velocity, Warning};
pub use faults::{Fault, FaultBuffer, FaultSet};
pub use inputs::{InputChange, Inputs};
pub use leds::StatusLed;
pub use memory::Memory;
pub use quirks::Quirks;
pub use refusal::{Reason, Refusal, Request};
pub use scale::INCREMENTS_PER_REVOLUTION;
pub use settings::{Limits, Mode, PosType, SenseOfRotation, Settings, StopMode};
pub use states::{Direction, DirectionChange, Inching, Key, Motor, State};
pub use status::{Measured, Status};

use lapse::Lapse;
use motion::{Motion, rpm};
use plant::{Constants, Plant};
use requests::Job;
use scale::Scale;
use states::{Conditions, Reached};
use supplies::Supplies;

/// How a drive behaves where the manuals leave it open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Config {
    /// Alternatives of the state machine.
    pub quirks: Quirks,
    /// Numbers of motor, gear, output stage and encoder.
    pub constants: Constants,
}

/// Calibration was asked for during a travel job (manual chapter 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("calibration is only possible when no travel job, inching or velocity is active or paused")]
pub struct CalibrationError;

/// One drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    model: Model,
    gear: Gear,
    quirks: Quirks,
    inputs: Inputs,
    /// What the inputs are to the drive.
    supplies: Supplies,
    inputs_changed: bool,
    /// The causes of faults that the bus sees.
    bus_causes: FaultSet,
    /// Whether the output stage was live at the previous step.
    previous_output_stage: bool,
    /// The key held at the previous step.
    previous_key: Option<Key>,
    /// The command of the previous step.
    previous: Command,
    state: State,
    frame: Frame,
    /// Positioning or velocity window; acts at once.
    window: u16,
    motion: Motion,
    plant: Plant,
    /// Shaft position with the user position 0, increments.
    zero: f64,
    /// The job being executed or kept.
    job: Job,
    /// Programmed setpoint: that of the last job or inching 1, user units.
    setpoint: i32,
    setpoint_programmed: bool,
    /// Travel jobs accepted since power-on.
    jobs: u8,
    /// Start may take effect: it was 0 since the operating mode changed.
    start_armed: bool,
    /// The torque deactivation stopped a motion, and none has begun since.
    torque_tripped: bool,
    /// The limits were changed since the last travel job began.
    limits_changed: bool,
    faults: FaultBuffer,
    /// The faults entered since the last acknowledgement.
    entered: FaultSet,
    /// The latest of them.
    latched: Option<Fault>,
    refusal: Option<Refusal>,
    settled: bool,
    /// How long the last step was.
    lapse: Lapse,
    /// The last step did nothing but carry a travel job on, and the shaft still turns.
    only_moved: bool,
}

/// Settings that say what positions mean; a motion or a kept job must not change them under way, so that they are taken
/// over while the shaft stands. Only the limits are monitored as they are programmed, at any time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Frame {
    mode: Mode,
    scale: Scale,
    limits: Limits,
    /// Limit 1 and limit 2, of which they were made.
    programmed_limits: [i32; 2],
    /// What positions are counted in.
    lengths: Lengths,
}

impl Frame {
    fn of(settings: &Settings) -> Self {
        let lengths = Lengths::of_spindle_pitch(settings.word(Parameter::SpindlePitch).into());
        Self {
            mode: settings.mode(),
            scale: Scale::new(settings),
            limits: settings.limits(),
            programmed_limits: settings.programmed_limits(),
            lengths,
        }
    }
}

impl Drive {
    /// A drive that was just powered on (row 1), with nominal [`Inputs`] and its shaft at position 0.
    pub fn new(model: Model, gear: Gear, settings: &Settings) -> Self {
        Self::with(model, gear, settings, Config::default())
    }

    /// As [`Drive::new`], with other quirks or another plant.
    pub(crate) fn with(model: Model, gear: Gear, settings: &Settings, config: Config) -> Self {
        let inputs = Inputs::default();
        let plant = Plant::new(model, gear, config.constants, &inputs);
        Self {
            model,
            gear,
            quirks: config.quirks,
            inputs,
            supplies: Supplies::of(model, &plant, &inputs),
            inputs_changed: false,
            bus_causes: FaultSet::empty(),
            previous_output_stage: true,
            previous_key: None,
            previous: Command::default(),
            state: State::powered(true),
            frame: Frame::of(settings),
            window: settings.word(Parameter::PosWindow),
            motion: Motion::at(0.0),
            plant,
            zero: 0.0,
            job: Job::NONE,
            setpoint: 0,
            setpoint_programmed: false,
            jobs: 0,
            start_armed: true,
            torque_tripped: false,
            limits_changed: false,
            faults: FaultBuffer::default(),
            entered: FaultSet::empty(),
            latched: None,
            refusal: None,
            settled: false,
            lapse: Lapse::NONE,
            only_moved: false,
        }
    }

    /// Lets `dt` pass under `command`.
    ///
    /// Inputs, command and settings act at the beginning of `dt`, then the shaft moves. Steps of 0.1 ms to 100 ms
    /// are meant; any length works, and a length of zero only evaluates.
    #[inline]
    pub fn step(&mut self, dt: Duration, command: &Command, settings: &Settings) {
        self.step_under(dt, command, *command == self.previous, settings);
    }

    /// As [`Drive::step`], under the command of the step before, whose edges are over; returns it.
    #[inline]
    pub(crate) fn hold(&mut self, dt: Duration, settings: &Settings) -> Command {
        let command = self.held();
        self.step_under(dt, &command, !self.previous.enable && !self.previous.travel, settings);
        command
    }

    /// The command of the last step without its edges.
    pub(crate) const fn held(&self) -> Command {
        // Copied whole: field by field takes three times as long.
        let mut command = self.previous;
        (command.enable, command.travel) = (false, false);
        command
    }

    /// `same_command`: it is that of the step before.
    fn step_under(&mut self, dt: Duration, command: &Command, same_command: bool, settings: &Settings) {
        self.lapse.set(dt);
        let state = self.state;
        let stood = self.stands();
        let faults = self.entered;
        // Only a drive that stands may come to rest.
        let held = !self.inputs_changed && same_command;
        let same = stood && held && self.window == settings.word(Parameter::PosWindow);
        self.inputs_changed = false;

        let same = !self.take_settings(settings) && same;
        self.on_plant(settings);
        // What is held asks nothing new of a travel job; edges are edges each time.
        let goes_on = held && self.state == State::TravelActive && !command.travel && !command.enable;
        if !goes_on {
            self.on_command(command, settings);
        }
        let plant = same.then(|| self.plant.clone());
        self.advance(self.lapse);
        self.on_motion(settings);
        self.only_moved = goes_on && self.state == State::TravelActive && !self.stands();

        self.settled = same
            && self.stands()
            && self.state == state
            && self.entered == faults
            && plant.is_some_and(|plant| plant == self.plant);
    }

    /// What the drive reports now.
    #[inline]
    pub fn status(&self) -> Status {
        self.compose()
    }

    /// What the drive measures now.
    pub fn measured(&self) -> Measured {
        self.measure()
    }

    /// The target of the travel job or of inching 1 that is carried out or paused, in user units, whatever setpoint the
    /// bus gives meanwhile; `None` without one.
    pub(crate) const fn target(&self) -> Option<i32> {
        let has_one = matches!(
            self.state,
            State::TravelActive | State::Pausing { .. } | State::Paused { .. } | State::Inching(Inching::One)
        );
        if has_one { Some(self.setpoint) } else { None }
    }

    /// What its positions are counted in. A new spindle pitch acts when the shaft stands.
    pub(crate) const fn lengths(&self) -> Lengths {
        self.frame.lengths
    }

    /// Whether another step with the same command, inputs and settings would change nothing.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.settled
    }

    /// The world around the drive as last set.
    pub(crate) fn inputs(&self) -> Inputs {
        self.inputs
    }

    /// Changes the world around the drive, limited to the ranges of [`Inputs`]; the next step reacts.
    pub fn set_inputs(&mut self, inputs: Inputs) {
        let inputs = inputs.limited();
        if inputs != self.inputs {
            self.inputs = inputs;
            self.supplies = Supplies::of(self.model, &self.plant, &inputs);
            self.inputs_changed = true;
            self.settled = false;
        }
    }

    /// Makes the present position `value` in user units (PNU 970 = 5).
    ///
    /// # Errors
    /// [`CalibrationError`] while [`Status::job_active`]. Whether a shaft that runs out may be calibrated is decided
    /// where PNU 970 is written ([`crate::devices::ag03::param::Quirks::calibrate_while_moving`]).
    pub fn calibrate(&mut self, value: i32) -> Result<(), CalibrationError> {
        if self.job_active() {
            return Err(CalibrationError);
        }
        self.zero = self.shaft_position() - self.frame.scale.increments(f64::from(value));
        self.settled = false;
        Ok(())
    }

    /// Fault buffer and fault counter.
    pub(crate) fn faults(&self) -> &FaultBuffer {
        &self.faults
    }

    /// The causes of faults that are present now.
    pub(crate) fn causes(&self) -> FaultSet {
        self.plant.causes(&self.inputs, &self.supplies) | self.bus_causes
    }

    /// Which causes of faults a bus sees now, of [`Fault::OF_BUS`]; the next step reacts.
    pub(crate) fn set_bus_causes(&mut self, causes: FaultSet) {
        if self.bus_causes != causes {
            self.bus_causes = causes;
            self.inputs_changed = true;
            self.settled = false;
        }
    }

    /// Clears fault buffer and fault counter (PNU 970 = 4). A latched fault stays latched.
    pub(crate) fn clear_faults(&mut self) {
        self.faults = FaultBuffer::default();
    }

    /// The last request that was refused, once. A newer refusal replaces one that was not taken.
    pub(crate) fn take_refusal(&mut self) -> Option<Refusal> {
        self.refusal.take()
    }

    /// Takes over what may change now. Returns whether that was anything.
    fn take_settings(&mut self, settings: &Settings) -> bool {
        if !self.stands() || self.state.job_active() {
            let programmed = settings.programmed_limits();
            if programmed == self.frame.programmed_limits {
                return false;
            }
            let limits = settings.limits();
            let changed = limits != self.frame.limits;
            (self.frame.limits, self.frame.programmed_limits) = (limits, programmed);
            self.limits_changed |= changed;
            return changed;
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
        let Supplies { control: control_supply, ok: supply_ok, output_stage, .. } = self.supplies;
        let causes = self.causes();
        let torque_exceeded = settings
            .torque_deactivation()
            .is_some_and(|percent| self.plant.torque_percent() > f64::from(percent));
        let supplied = supply_ok && output_stage && self.previous_output_stage;
        let in_order = supplied && causes.is_empty() && !torque_exceeded;
        if in_order && !matches!(self.state, State::Off | State::NotReady) {
            return;
        }
        let conditions = Conditions {
            control_supply,
            supply_ok,
            output_stage,
            output_stage_returned: output_stage && !self.previous_output_stage,
            fault_cause: !causes.is_empty(),
            torque_exceeded,
            torque_discards_job: self.quirks.torque_discards_job,
        };
        self.previous_output_stage = output_stage;
        let (next, action) = self.state.on_plant(conditions);
        if next == State::Fault {
            self.enter_faults(causes);
        }
        self.enact(next, action, &Command::RELEASE, settings);
    }

    /// Row 9: each cause once until it is acknowledged.
    fn enter_faults(&mut self, causes: FaultSet) {
        for fault in causes & !self.entered {
            self.faults.enter(fault);
            self.entered |= fault;
            self.latched = Some(fault);
        }
    }

    fn on_command(&mut self, command: &Command, settings: &Settings) {
        let asked = self.asked(command, settings);
        let (next, action) = self.state.on_command(&asked);
        self.enact(next, action, command, settings);
        self.start_armed |= !command.turn;
        self.previous = *command;
    }

    fn on_motion(&mut self, settings: &Settings) {
        let inpos_in_window = self.quirks.inpos_acts_in_window && self.job.via.is_none();
        // A shaft that turns can only reach a window or a limit, which few states look at. A travel job leads to no place
        // beyond the limits that were in force when it began.
        let looks = inpos_in_window
            || self.limits_changed
            || matches!(self.state, State::Inching(_) | State::KeyInching(_));
        if !looks && !self.stands() {
            return;
        }
        self.window = settings.word(Parameter::PosWindow);
        let position = self.position();
        let velocity = self.shaft_velocity() * self.frame.scale.sign();
        let limits = self.frame.limits;
        let reached = Reached {
            at_rest: self.stands(),
            in_window: self.in_window(position, rpm(velocity)),
            crossed_limit: (limits.is_above(position) && velocity > 0.0)
                || (limits.is_below(position) && velocity < 0.0),
            velocity_released: self.previous.turn,
            inpos: settings.inpos(),
            inpos_in_window,
            torque_tripped: self.torque_tripped,
        };
        let (next, action) = self.state.on_motion(reached);
        self.enact(next, action, &Command::RELEASE, settings);
    }

    /// Angle of the output shaft in increments.
    fn shaft_position(&self) -> f64 {
        self.motion.position()
    }

    /// Speed of the output shaft in increments/s, signed.
    fn shaft_velocity(&self) -> f64 {
        self.motion.velocity()
    }

    /// The profile has ended and the shaft is there.
    fn stands(&self) -> bool {
        self.motion.at_rest()
    }
}

#[cfg(test)]
mod tests;
