//! States, option codes and faults.

use super::motion::Motion;
use super::settings::Setting;
use super::{Drive, Event, Fault};
use crate::can_bus::cia402::state;
use crate::can_bus::cia402::{
    Command, Controlword, Disabling, FaultReaction, Halt, Mode, QuickStop, State, Stop,
};
use crate::devices::servo::news::News;
use crate::devices::servo::plant::{INCREMENTS_PER_REVOLUTION, rpm};
use crate::devices::servo::profile::Demand;
use crate::devices::servo::stopping::{Stopping, Then};

/// The deceleration at the limit of the current: peak torque over inertia.
const STEEPEST: f64 = 6000.0 * INCREMENTS_PER_REVOLUTION;

/// 6007h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AbortConnection {
    Nothing,
    Fault,
    DisableVoltage,
    QuickStop,
}

impl Drive {
    /// The state of the machine.
    pub(crate) const fn state(&self) -> State {
        self.state
    }

    /// Whether the motor has torque.
    pub(crate) const fn is_on(&self) -> bool {
        self.state.is_powered()
    }

    /// The controlword last taken.
    pub(crate) const fn controlword(&self) -> Controlword {
        self.control
    }

    /// The fault present.
    pub(crate) const fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Takes a controlword.
    pub(super) fn control(&mut self, word: Controlword) {
        let before = core::mem::replace(&mut self.control, word);
        let was = self.state;
        self.command(word.command(before));
        if let Some(news) = News::of_command((word, before), (was, self.state), self.inputs.main_circuit) {
            self.news.push(news);
        }
        if self.state == State::OperationEnabled {
            self.control_mode_bits(word, before);
        }
    }

    fn option(&self, setting: Setting) -> i16 {
        i16::try_from(self.settings.of(setting)).unwrap_or_default()
    }

    fn quick_stop_option(&self) -> QuickStop {
        let usual = QuickStop { stop: Stop::QuickStopRamp, stays: false };
        QuickStop::of(self.option(Setting::QuickStopOption)).unwrap_or(usual)
    }

    fn command(&mut self, command: Command) {
        match (self.state, command) {
            // A drive that is enabled again on its way off stays on.
            (State::OperationEnabled, Command::EnableOperation) => {
                self.stopping.take_if(|stopping| stopping.leaves());
            }
            (State::OperationEnabled, Command::SwitchOn) => self.disable(Setting::DisableOption, command),
            (State::OperationEnabled, Command::Shutdown) => self.disable(Setting::ShutdownOption, command),
            // Transition 16 is of those that stay.
            (State::QuickStopActive, Command::EnableOperation) if !self.quick_stop_option().stays => {}
            (State::SwitchedOn, Command::EnableOperation) if !self.inputs.main_circuit => {}
            (State::Fault, Command::FaultReset) => {
                if !self.has_cause() {
                    self.fault = None;
                    self.go(state::Event::Command(command));
                    self.tell(Event::Cleared);
                    self.news.push(News::Cleared);
                }
            }
            (
                State::NotReadyToSwitchOn
                | State::SwitchOnDisabled
                | State::ReadyToSwitchOn
                | State::SwitchedOn
                | State::OperationEnabled
                | State::QuickStopActive
                | State::FaultReactionActive
                | State::Fault,
                Command::Shutdown
                | Command::SwitchOn
                | Command::EnableOperation
                | Command::DisableVoltage
                | Command::QuickStop
                | Command::FaultReset,
            ) => self.go(state::Event::Command(command)),
        }
    }

    /// 605Bh and 605Ch.
    fn disable(&mut self, option: Setting, command: Command) {
        let shuts_down = option == Setting::ShutdownOption;
        let usual = if shuts_down { Stop::Coast } else { Stop::SlowDownRamp };
        let stop = Disabling::of(self.option(option)).map_or(usual, |Disabling(stop)| stop);
        self.stop_by(stop, Then::Tell(state::Event::Command(command)));
    }

    fn go(&mut self, event: state::Event) {
        let Some((_, to)) = self.state.next(event) else { return };
        let from = core::mem::replace(&mut self.state, to);
        self.news.push(News::State { from, to });
        match (from.is_powered(), to) {
            (false, State::OperationEnabled) => self.switch_on(),
            (true, State::QuickStopActive) => {
                let QuickStop { stop, stays } = self.quick_stop_option();
                let then = if stays { Then::Hold } else { Then::Tell(state::Event::QuickStopDone) };
                self.stop_by(stop, then);
            }
            // Transition 16.
            (true, State::OperationEnabled) => {
                self.stopping = None;
                self.motion = self.motion_of(self.mode);
            }
            (_, State::FaultReactionActive) => {
                let code = self.option(Setting::FaultOption);
                let stop = FaultReaction::of(code).map_or(Stop::QuickStopRamp, |FaultReaction(stop)| stop);
                let stop = if from.is_powered() { stop } else { Stop::Coast };
                self.stop_by(stop, Then::Tell(state::Event::FaultReactionDone));
            }
            (true, State::SwitchOnDisabled | State::ReadyToSwitchOn | State::SwitchedOn | State::Fault) => {
                self.release();
            }
            (true, State::NotReadyToSwitchOn)
            | (
                false,
                State::NotReadyToSwitchOn
                | State::SwitchOnDisabled
                | State::ReadyToSwitchOn
                | State::SwitchedOn
                | State::QuickStopActive
                | State::Fault,
            ) => {}
        }
    }

    /// The command starts from where the shaft is.
    fn switch_on(&mut self) {
        self.stopping = None;
        self.demand = Demand { position: self.plant.position, velocity: 0.0 };
        self.torque_demand = 0.0;
        self.cyclic.begin_anew();
        self.motion = self.motion_of(self.mode);
    }

    /// The motor is free.
    pub(super) fn release(&mut self) {
        self.stopping = None;
        self.homing_axis = None;
        self.torque_demand = 0.0;
        self.demand = Demand { position: self.plant.position, velocity: 0.0 };
        self.motion = self.motion_of(self.mode);
    }

    /// How fast the drive brakes on that ramp, increments/s^2.
    pub(super) fn deceleration(&self, stop: Stop) -> f64 {
        match (stop, self.mode) {
            (Stop::SlowDownRamp, Some(Mode::Velocity)) => {
                self.vl_ramp(Setting::VlDecelerationSpeed, Setting::VlDecelerationTime)
            }
            (Stop::SlowDownRamp, Some(Mode::Homing)) => self.homing_acceleration(),
            (Stop::SlowDownRamp, _) => self.profile_deceleration(),
            (Stop::QuickStopRamp, Some(Mode::Velocity))
                if self.settings.of(Setting::VlQuickStopSpeed) > 0 =>
            {
                self.vl_ramp(Setting::VlQuickStopSpeed, Setting::VlQuickStopTime)
            }
            (Stop::QuickStopRamp, _) => self.acceleration(
                Setting::QuickStopDeceleration,
                500.0 * INCREMENTS_PER_REVOLUTION,
                Setting::MaxDeceleration,
            ),
            (Stop::CurrentLimit | Stop::VoltageLimit | Stop::Coast, _) => STEEPEST,
        }
    }

    /// On which ramp halt brakes, 605Dh.
    pub(super) fn halt_deceleration(&self) -> f64 {
        let stop = Halt::of(self.option(Setting::HaltOption)).map_or(Stop::SlowDownRamp, |Halt(stop)| stop);
        self.deceleration(stop)
    }

    fn stop_by(&mut self, stop: Stop, then: Then) {
        match (stop, then) {
            (Stop::Coast, Then::Tell(event)) => {
                self.stopping = None;
                self.go(event);
            }
            (
                Stop::Coast
                | Stop::SlowDownRamp
                | Stop::QuickStopRamp
                | Stop::CurrentLimit
                | Stop::VoltageLimit,
                Then::GoOn | Then::Hold | Then::Tell(_),
            ) => {
                if self.stopping.is_none() && self.motion.is_torque() {
                    self.demand = Demand { position: self.plant.position, velocity: self.plant.velocity };
                }
                let deceleration = self.deceleration(stop);
                self.stopping = Some(Stopping::new(deceleration, then));
            }
        }
    }

    /// The ramp came to rest.
    pub(super) fn stopped(&mut self) {
        let Some(stopping) = &mut self.stopping else { return };
        match stopping.end(&mut self.plant) {
            None => {}
            Some(Then::GoOn) => {
                self.stopping = None;
                self.rest_here();
            }
            Some(Then::Hold) => self.motion = Motion::Hold,
            Some(Then::Tell(event)) => {
                self.stopping = None;
                self.go(event);
            }
        }
    }

    /// Whether a ramp has to come to rest yet.
    pub(super) fn is_stopping(&self) -> bool {
        self.stopping.is_some_and(|stopping| stopping.is_under_way(self.demand.velocity))
    }

    /// 6060h was written, or the drive starts.
    pub(super) fn enter_mode(&mut self) {
        let code = i8::try_from(self.settings.of(Setting::Mode)).unwrap_or_default();
        let mode = Mode::of(code);
        if mode == self.mode {
            return;
        }
        self.homing_axis = None;
        let was_torque = self.motion.is_torque();
        self.mode = mode;
        self.torque_demand = 0.0;
        self.cyclic.begin_anew();
        self.windows = super::Windows::default();
        if self.is_on() && was_torque {
            self.demand = Demand { position: self.plant.position, velocity: self.plant.velocity };
        }
        self.motion = self.motion_of(mode);
        let goes_on =
            matches!(self.motion, Motion::Velocity | Motion::Vl | Motion::Torque | Motion::CyclicTorque);
        if self.state == State::OperationEnabled && self.stopping.is_none() && !goes_on {
            self.stop_by(Stop::SlowDownRamp, Then::GoOn);
        }
    }

    /// A fault that the bus, the plant or a person causes.
    pub(crate) fn raise(&mut self, fault: Fault) {
        if self.fault.is_some() {
            return;
        }
        self.pace.wake();
        self.fault = Some(fault);
        self.tell(Event::Raised(fault));
        self.news.push(News::Raised { what: fault, is_fault: true });
        self.go(state::Event::Fault);
    }

    /// The fault has no cause any more; it is there until it is reset.
    fn has_cause(&self) -> bool {
        !self.inputs.emergency_stop_released
    }

    /// The master is lost, or has stopped the node: 6007h.
    pub(crate) fn connection_aborted(&mut self) {
        if !self.is_on() {
            return;
        }
        let reaction = match self.settings.of(Setting::AbortConnection) {
            1 => AbortConnection::Fault,
            2 => AbortConnection::DisableVoltage,
            3 => AbortConnection::QuickStop,
            _ => AbortConnection::Nothing,
        };
        self.pace.wake();
        match reaction {
            AbortConnection::Nothing => {}
            AbortConnection::Fault => self.raise(Fault::CONNECTION),
            AbortConnection::DisableVoltage => self.command(Command::DisableVoltage),
            AbortConnection::QuickStop => self.command(Command::QuickStop),
        }
    }

    /// Looks for causes of faults outside the plant.
    pub(super) fn watch(&mut self) {
        if self.has_cause() {
            self.raise(Fault::EXTERNAL);
        }
        if self.is_on() && !self.inputs.main_circuit {
            self.raise(Fault::NO_VOLTAGE);
        }
    }

    /// Looks at the plant after a step.
    pub(super) fn watch_plant(&mut self) {
        if self.plant.heat >= 1.0 {
            self.raise(Fault::OVERLOAD);
        }
        if self.count_windows() {
            self.raise(Fault::FOLLOWING);
        }
    }

    /// vl: so many rpm in so many seconds.
    pub(super) fn vl_ramp(&self, speed: Setting, time: Setting) -> f64 {
        let speed = match self.settings.of(speed) {
            ..=0 => rpm(6000.0),
            speed => speed as f64 * self.units.vl,
        };
        speed / self.settings.above_zero(time, 1.0)
    }
}
