//! A servo drive as PROFIdrive version 3 and 4 describe one, without a bus (`dp-v1.md` 9).
//!
//! The control word is a [`Command`] here, the status word a [`Status`]; `profibus` has their bits, the telegrams and the
//! parameters. Where the profile leaves something to the maker, `docs/profidrive.md` says what this drive does.
//!
//! | file | holds |
//! | --- | --- |
//! | `axis`, `block` | positioning: jogging, referencing, MDI, traversing blocks |
//! | `command` | [`Command`]: what a master commands |
//! | `encoder` | [`Encoder`]: actual values of the position, as an encoder gives them |
//! | `event` | [`Event`]: news of the drive |
//! | `fault` | [`Fault`], [`Warnings`] |
//! | `setting` | [`Setting`], [`Settings`] |
//! | `speed` | what a speed setpoint asks of the motor |
//!
//! The states are those of version 2, [`State`]. A fault is no state of its own: the drive is in S1, switching on inhibited,
//! until it is acknowledged.
//!
//! ```
//! use profidrive::devices::ppo_drive::State;
//! use profidrive::devices::profidrive4::{Command, Drive};
//! use profidrive::time::Instant;
//!
//! let mut drive = Drive::new(Instant::ZERO);
//! let mut off = Command::run(0.0);
//! off.control.on = false;
//! drive.step(Instant::from_millis(1), Some(&off));
//! for millis in 2..2000 {
//!     drive.step(Instant::from_millis(millis), Some(&Command::run(0.5)));
//! }
//! assert_eq!(drive.status().state, State::Operation);
//! assert!((drive.status().speed - 1500.0).abs() < 1.0);
//! ```

mod axis;
mod block;
mod command;
mod encoder;
mod event;
mod fault;
pub mod profibus;
mod setting;
mod speed;

pub use axis::{AxisStatus, Origin};
pub use command::{Command, Mdi, Setpoint, Task};
pub use encoder::{Encoder, EncoderCommand, EncoderStatus};
pub use event::Event;
pub use fault::{Fault, Occurrence, Reaction, Warnings};
pub use setting::{Setting, SettingKind, Settings};

use axis::Axis;
pub(crate) use block::{BlockField, Blocks};

use crate::devices::ppo_drive::{self, FaultBuffer, Off, State};
use crate::devices::servo::inputs::Inputs;
use crate::devices::servo::pace::STEP_SECONDS;
use crate::devices::servo::plant::{self, Constants, Gains, INCREMENTS_PER_REVOLUTION, Plant, rpm};
use crate::devices::servo::profile::Demand;
use crate::time::Instant;
use crate::untold::Untold;

/// The shaft stands below it, rpm.
const STANDSTILL: f64 = 0.5;
/// A shaft that stands while the torque is at its limit is blocked behind so many steps.
const BLOCKED_AFTER: u32 = 2000;
/// The overload time is used so far: a warning.
const OVERLOAD_WARNING: f64 = 0.3;
/// The torque is at its limit from this part of it on.
const AT_LIMIT: f64 = 0.999;
/// Events that wait.
const MAX_EVENTS: usize = 16;

/// A drive of the profile. It owns no clock: [`Drive::step`] is one millisecond.
#[derive(Clone, Debug)]
pub struct Drive {
    settings: Settings,
    inputs: Inputs,
    /// The measuring probes.
    probes: [bool; 2],
    plant: Plant,
    /// What is demanded of the shaft.
    demand: Demand,
    state: State,
    /// What is commanded, with what the terminals and a fault make of it.
    control: ppo_drive::Command,
    command: Command,
    jog: Option<ppo_drive::Inching>,
    faults: FaultBuffer<Occurrence>,
    /// A fault is not acknowledged.
    faulted: bool,
    warnings: Warnings,
    encoder: Encoder,
    axis: Axis,
    blocks: Blocks,
    /// How many steps the shaft stands at the limit of the torque.
    blocked: u32,
    began: Instant,
    now: Instant,
    events: Untold<Event, MAX_EVENTS>,
    at_rest: bool,
}

/// What a drive shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Its state.
    pub state: State,
    /// A fault is not acknowledged.
    pub fault: bool,
    /// No OFF2 is commanded.
    pub no_off2: bool,
    /// No OFF3 is commanded.
    pub no_off3: bool,
    /// A warning stands.
    pub warning: bool,
    /// Setpoint and actual speed agree.
    pub in_tolerance: bool,
    /// The comparison speed is reached.
    pub speed_reached: bool,
    /// The torque is at its limit.
    pub at_limit: bool,
    /// The ramp generator has reached its setpoint.
    pub ramp_done: bool,
    /// The shaft stands.
    pub stands: bool,
    /// How fast the shaft turns, rpm.
    pub speed: f64,
    /// What the ramp generator gives, rpm.
    pub demand: f64,
    /// Torque of the motor, Nm.
    pub torque: f64,
    /// Current of the motor, A.
    pub current: f64,
    /// Power at the shaft, kW.
    pub power: f64,
}

/// Increments/s as rpm.
fn as_rpm(velocity: f64) -> f64 {
    velocity / INCREMENTS_PER_REVOLUTION * 60.0
}

impl Drive {
    /// A drive that is switched on at `now`, its shaft at rest.
    pub fn new(now: Instant) -> Self {
        Self {
            settings: Settings::default(),
            inputs: Inputs::NOMINAL,
            probes: [false; 2],
            plant: Plant::new(Constants::DEFAULT),
            demand: Demand::default(),
            state: State::default(),
            control: ppo_drive::Command::default(),
            command: Command::default(),
            jog: None,
            faults: FaultBuffer::default(),
            faulted: false,
            warnings: Warnings::default(),
            encoder: Encoder::default(),
            axis: Axis::default(),
            blocks: Blocks::default(),
            blocked: 0,
            began: now,
            now,
            events: Untold::new(),
            at_rest: false,
        }
    }

    /// The same drive switched off and on again, with these settings: the shaft stays where it is and turns on.
    pub(crate) fn restart(&mut self, now: Instant) {
        let Self { inputs, probes, plant, settings, blocks, .. } = core::mem::replace(self, Self::new(now));
        (self.inputs, self.plant, self.settings, self.blocks) = (inputs, plant, settings, blocks);
        self.probes = probes;
        self.demand = Demand { position: self.plant.position, velocity: self.plant.velocity };
    }

    /// What it shows.
    pub fn status(&self) -> Status {
        let Self { settings, state, plant, control, .. } = self;
        let torque = plant.torque * Constants::DEFAULT.rated_torque;
        let per_torque = settings.of(Setting::ReferenceCurrent) / settings.of(Setting::ReferenceTorque);
        let (speed, demand) = (as_rpm(plant.velocity), as_rpm(self.demand.velocity));
        Status {
            state: *state,
            fault: self.faulted,
            no_off2: control.no_off2,
            no_off3: control.no_off3,
            warning: !self.warnings.standing().is_empty(),
            in_tolerance: (demand - speed).abs() <= settings.of(Setting::ToleratedDeviation),
            speed_reached: speed.abs() >= settings.of(Setting::ComparisonSpeed),
            at_limit: self.is_at_limit(),
            ramp_done: self.ramp_is_done(),
            stands: self.stands(),
            speed,
            demand,
            torque,
            current: torque.abs() * per_torque,
            power: torque * speed * core::f64::consts::TAU / 60.0 / 1000.0,
        }
    }

    /// Its settings.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Its settings, to be changed.
    pub(crate) const fn settings_mut(&mut self) -> &mut Settings {
        self.at_rest = false;
        &mut self.settings
    }

    /// Its traversing blocks.
    pub(crate) const fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// Its traversing blocks, to be changed.
    pub(crate) const fn blocks_mut(&mut self) -> &mut Blocks {
        &mut self.blocks
    }

    /// What is around it.
    pub const fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// What is around it, to be changed.
    pub(crate) const fn inputs_mut(&mut self) -> &mut Inputs {
        self.at_rest = false;
        &mut self.inputs
    }

    /// Its measuring probes.
    pub(crate) const fn probes(&self) -> [bool; 2] {
        self.probes
    }

    /// Closes or opens its measuring probes.
    pub(crate) const fn set_probes(&mut self, probes: [bool; 2]) {
        self.at_rest = false;
        self.probes = probes;
    }

    /// Its fault buffer.
    pub const fn faults(&self) -> &FaultBuffer<Occurrence> {
        &self.faults
    }

    /// Forgets the faults that were acknowledged.
    pub(crate) fn clear_faults(&mut self) {
        self.faults.clear();
    }

    /// Its warnings.
    pub const fn warnings(&self) -> &Warnings {
        &self.warnings
    }

    /// What is commanded now.
    pub(crate) const fn command(&self) -> &Command {
        &self.command
    }

    /// What its encoder says.
    pub fn encoder(&self) -> EncoderStatus {
        self.encoder.status(self.plant.position)
    }

    /// The place of the shaft, increments.
    pub(crate) const fn shaft(&self) -> f64 {
        self.plant.position
    }

    /// What a master asks of the encoder in this cycle.
    pub(crate) fn command_encoder(&mut self, command: EncoderCommand) {
        self.encoder.step(command, self.plant.position);
    }

    /// One application cycle that ends at `now`; `None`: no master exchanges data.
    pub fn step(&mut self, now: Instant, command: Option<&Command>) {
        self.now = now;
        let is_led = command.is_some();
        if !is_led && self.state.is_switched_on() {
            self.raise(Fault::Communication, 0);
        }
        let command = command.copied().unwrap_or_default();
        if !self.inputs.main_circuit && self.state.is_switched_on() {
            self.raise(Fault::MainCircuit, 0);
        }
        if command.control.acknowledge && !self.command.control.acknowledge && self.faulted {
            self.faulted = false;
            self.faults.acknowledge();
            self.tell(Event::Acknowledged);
        }
        if self.state == State::SwitchingOff(Off::Off1) && command.control.on && !self.command.control.on {
            self.tell(Event::OnWhileSwitchingOff);
        }
        let news = command != self.command;
        let before = self.state;
        let control = self.controlled(&command);
        self.change(
            self.state.next(&self.held(control, is_led), self.stands() && self.demand.velocity == 0.0),
        );
        let way = self.follow(&command);
        (self.command, self.control) = (command, control);
        self.plant.limit = Constants::DEFAULT.peak * (1.0 - command.torque_reduction.clamp(0.0, 1.0));
        self.plant.advance(STEP_SECONDS, way, &self.inputs);
        self.watch();
        let near = (self.demand.position - self.plant.position).abs() < 0.5;
        let still = self.plant.rests() && self.demand.velocity == 0.0 && (near || !self.state.is_supplied());
        // At the end of braking the next step changes the state.
        let brakes = matches!(self.state, State::SwitchingOff(_));
        let is_done = self.jog.is_none() && self.ramp_is_done();
        self.at_rest = still && !news && !brakes && before == self.state && is_done;
    }

    /// Whether another step under the same command changes nothing.
    pub(crate) const fn is_at_rest(&self) -> bool {
        self.at_rest
    }

    /// What is commanded, with what the terminals of the drive say.
    const fn controlled(&self, command: &Command) -> ppo_drive::Command {
        let Inputs { main_circuit, emergency_stop_released, .. } = self.inputs;
        let ppo_drive::Command { no_off2, no_off3, .. } = command.control;
        ppo_drive::Command {
            no_off2: no_off2 && main_circuit,
            no_off3: no_off3 && emergency_stop_released,
            ..command.control
        }
    }

    /// The same with what a fault makes of it: the drive brakes if it does, also without a master, and is in S1 then.
    const fn held(&self, control: ppo_drive::Command, is_led: bool) -> ppo_drive::Command {
        let brakes = matches!(self.state, State::SwitchingOff(_));
        if brakes && !is_led {
            return ppo_drive::Command::run(0);
        }
        ppo_drive::Command { no_off2: control.no_off2 && (!self.faulted || brakes), ..control }
    }

    /// What is asked of the motor in this step.
    fn follow(&mut self, command: &Command) -> plant::Drive {
        let from = self.demand.position;
        match self.state {
            State::Operation => match command.setpoint {
                Setpoint::Speed(speed) => {
                    self.give_up();
                    self.follow_speed(&command.control, speed);
                }
                Setpoint::Position(task) => self.follow_task(&command.control, &task),
            },
            State::SwitchingOff(off) => {
                self.jog = None;
                self.give_up();
                self.brake(match off {
                    Off::Off1 => Setting::RampDown,
                    Off::Off3 => Setting::QuickStop,
                });
            }
            State::SwitchingOnInhibited | State::ReadyToSwitchOn | State::Ready | State::Fault => {
                self.jog = None;
                self.give_up();
                // Caught at the speed it has when it is supplied again.
                self.demand = Demand { position: self.plant.position, velocity: self.plant.velocity };
                return plant::Drive::Free;
            }
        }
        plant::Drive::Position { from, way: self.demand.position - from, gains: Gains::OF_VELOCITY }
    }

    /// Overload, a shaft that is blocked.
    fn watch(&mut self) {
        let overloaded = self.plant.heat >= OVERLOAD_WARNING;
        self.warn(Warnings::OVERLOAD, overloaded);
        let is_blocked = self.state.is_supplied() && self.is_at_limit() && self.stands();
        self.blocked = if is_blocked { self.blocked.saturating_add(1) } else { 0 };
        if self.plant.heat >= 1.0 && self.state.is_supplied() {
            self.raise(Fault::Overload, 0);
        }
        if self.blocked >= BLOCKED_AFTER {
            self.blocked = 0;
            self.raise(Fault::Blocked, 0);
        }
    }

    fn is_at_limit(&self) -> bool {
        self.state.is_supplied() && self.plant.torque.abs() >= self.plant.limit * AT_LIMIT
    }

    fn stands(&self) -> bool {
        self.plant.velocity.abs() < rpm(STANDSTILL)
    }

    /// A fault comes; one that stands already does not come again.
    pub(crate) fn raise(&mut self, fault: Fault, value: i32) {
        let stands = self.standing_faults().any(|occurrence| occurrence.number == fault.number());
        if stands && self.faulted {
            return;
        }
        let millis = self.now.saturating_since(self.began).as_millis();
        let millis = u32::try_from(millis).unwrap_or(u32::MAX);
        self.faults.note(Occurrence { number: fault.number(), millis, value });
        self.faulted = true;
        self.at_rest = false;
        self.tell(Event::Fault(fault));
        match (fault.reaction(), self.state) {
            (Reaction::QuickStop, State::Operation | State::SwitchingOff(_)) => {
                self.change(State::SwitchingOff(Off::Off3));
            }
            (Reaction::Coast | Reaction::QuickStop, _) => self.change(State::SwitchingOnInhibited),
        }
    }

    /// The faults that are not acknowledged.
    pub fn standing_faults(&self) -> impl Iterator<Item = Occurrence> {
        (0..8).filter_map(|place| self.faults.noted(place)).filter(|fault| fault.number != 0)
    }

    /// A warning stands or does not from now on.
    pub(crate) fn warn(&mut self, number: u16, stands: bool) {
        if self.warnings.set(number, stands) {
            self.at_rest = false;
            self.tell(Event::Warning(number));
        }
    }

    /// Warnings that were raised on purpose stand no more.
    pub(crate) fn end_raised_warnings(&mut self) {
        self.warnings.end_raised();
        self.at_rest = false;
    }

    /// The oldest event not taken yet.
    pub(crate) fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn change(&mut self, state: State) {
        if state != self.state {
            self.state = state;
            self.tell(Event::State(state));
        }
    }

    fn tell(&mut self, event: Event) {
        self.events.push(event);
    }
}

#[cfg(test)]
mod tests;
