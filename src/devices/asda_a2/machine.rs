//! States and alarms, and what they do to the motion.

use super::alarm::{Alarm, Clearing, Effect, InWords};
use super::profile::{Demand, acceleration};
use super::settings::{Digit, Setting};
use super::{Event, Level, Servo};
use crate::can_bus::cia402::state;
use crate::can_bus::cia402::{Command, Controlword, FaultReaction, Mode, State, Stop};
use crate::devices::servo::news::News;
use crate::devices::servo::stopping::{Stopping, Then};

/// Warnings whose cause is present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Causes {
    reverse_limit: bool,
    forward_limit: bool,
    reverse_soft_limit: bool,
    forward_soft_limit: bool,
    overload: bool,
}

impl Servo {
    /// The state of the machine.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Whether the motor has torque.
    pub const fn is_on(&self) -> bool {
        self.state.is_powered()
    }

    /// The controlword last taken.
    pub(crate) const fn controlword(&self) -> Controlword {
        self.control
    }

    /// Takes a controlword.
    pub(crate) fn control(&mut self, word: Controlword) {
        let before = core::mem::replace(&mut self.control, word);
        let was = self.state;
        self.pace.wake();
        let command = word.command(before);
        if command == Command::FaultReset {
            self.reset_alarms();
        }
        match self.level {
            Level::Full => self.command(command),
            Level::Half => self.command_half(word, command),
        }
        if let Level::Full = self.level
            && let Some(news) = News::of_command((word, before), (was, self.state), self.inputs.main_circuit)
        {
            self.news.push(news);
        }
        if self.state == State::OperationEnabled {
            self.control_mode_bits(word, before);
        }
    }

    /// Half CANopen: one word leads through all states. P3-12.X = 0: bit 3 alone switches the servo on, and without it
    /// off; a quick stop by bit 2 exists with P3-12.X = 1 only.
    fn command_half(&mut self, word: Controlword, command: Command) {
        let by_bit_3 = self.settings.digit(Setting::QuickStopOptions, Digit::X) == 0;
        let command = match command {
            Command::FaultReset => command,
            Command::Shutdown
            | Command::SwitchOn
            | Command::EnableOperation
            | Command::DisableVoltage
            | Command::QuickStop
                if by_bit_3 && word.has(Controlword::ENABLE_OPERATION) =>
            {
                Command::EnableOperation
            }
            Command::QuickStop if by_bit_3 => Command::DisableVoltage,
            Command::Shutdown
            | Command::SwitchOn
            | Command::EnableOperation
            | Command::DisableVoltage
            | Command::QuickStop => command,
        };
        if command == Command::EnableOperation {
            self.command(Command::Shutdown);
            self.command(Command::SwitchOn);
        }
        self.command(command);
    }

    fn command(&mut self, command: Command) {
        let was = self.state;
        match (was, command) {
            // A servo that is enabled again on its way off stays on.
            (State::OperationEnabled, Command::EnableOperation) => {
                self.stopping.take_if(|stopping| stopping.leaves());
            }
            // Half CANopen passes these states on its way up only.
            (State::OperationEnabled, Command::Shutdown | Command::SwitchOn)
                if self.level == Level::Half && self.control.has(Controlword::ENABLE_OPERATION) => {}
            // 6084h first, then off (CN-229).
            (State::OperationEnabled, Command::SwitchOn) => {
                self.stop(self.ramp(Setting::Deceleration), Then::Tell(state::Event::Command(command)));
            }
            // There is no transition 16; P3-12.Y: a fault reset ends the quick stop.
            (State::QuickStopActive, Command::EnableOperation) => {}
            (State::QuickStopActive, Command::FaultReset) => {
                if self.settings.digit(Setting::QuickStopOptions, Digit::Y) == 1 {
                    self.go(state::Event::QuickStopDone);
                }
            }
            // The main circuit is not supplied: the servo does not go on.
            (State::SwitchedOn, Command::EnableOperation) if !self.inputs.main_circuit => {}
            (State::Fault, Command::FaultReset) if self.has_fault() => {}
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

    fn go(&mut self, event: state::Event) {
        let Some((_, to)) = self.state.next(event) else { return };
        let from = core::mem::replace(&mut self.state, to);
        match (from.is_powered(), to) {
            (false, State::OperationEnabled) => self.switch_on(),
            (true, State::QuickStopActive) => {
                self.clear_targets();
                self.stop(self.ramp(Setting::QuickStopDeceleration), Then::Hold);
            }
            (_, State::FaultReactionActive) => self.react(from),
            (true, State::SwitchOnDisabled | State::ReadyToSwitchOn | State::SwitchedOn | State::Fault) => {
                self.switch_off();
            }
            (true, State::OperationEnabled | State::NotReadyToSwitchOn)
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
        self.news.push(News::State { from, to });
    }

    /// The command starts from where the shaft is; 60FFh and 6071h begin at zero.
    fn switch_on(&mut self) {
        self.clear_targets();
        self.stopping = None;
        self.demand = Demand { position: self.plant.position, velocity: 0.0 };
        self.torque_demand = 0.0;
        self.motion = self.motion_of(self.mode);
    }

    /// The supply is switched off: the motor is free, without an alarm.
    pub(crate) fn power_off(&mut self) {
        self.state = State::SwitchOnDisabled;
        self.switch_off();
        self.pace.wake();
    }

    fn switch_off(&mut self) {
        self.clear_targets();
        self.stopping = None;
        self.homing_axis = None;
        self.torque_demand = 0.0;
        self.motion = self.motion_of(self.mode);
    }

    fn clear_targets(&mut self) {
        self.settings.set(Setting::TargetVelocity, 0);
        self.settings.set(Setting::TargetTorque, 0);
    }

    /// 605Eh.
    fn react(&mut self, from: State) {
        let code = i16::try_from(self.settings.of(Setting::FaultReaction)).unwrap_or_default();
        let stop = match FaultReaction::of(code) {
            Some(FaultReaction(stop)) if from.is_powered() => stop,
            Some(_) | None => Stop::Coast,
        };
        let done = Then::Tell(state::Event::FaultReactionDone);
        match stop {
            Stop::Coast => self.go(state::Event::FaultReactionDone),
            Stop::SlowDownRamp => self.stop(self.ramp(Setting::Deceleration), done),
            Stop::QuickStopRamp | Stop::CurrentLimit | Stop::VoltageLimit => {
                self.stop(self.ramp(Setting::QuickStopDeceleration), done);
            }
        }
    }

    fn ramp(&self, setting: Setting) -> f64 {
        acceleration(self.settings.of(setting))
    }

    fn stop(&mut self, deceleration: f64, then: Then) {
        if self.mode == Some(Mode::ProfileTorque) && self.stopping.is_none() {
            self.demand = Demand { position: self.plant.position, velocity: self.plant.velocity };
        }
        self.stopping = Some(Stopping::new(deceleration, then));
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
            Some(Then::Hold) => self.motion = super::Motion::Hold,
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
        // P1-01.C; no default of a mode is documented but 0.
        if self.mode.is_some() && self.settings.of(Setting::ControlMode) >> 12 == 1 {
            self.settings.forget_inputs_and_outputs();
        }
        self.clear_targets();
        self.homing_axis = None;
        if self.state == State::OperationEnabled && self.stopping.is_none() {
            self.stop(self.ramp(Setting::Deceleration), Then::GoOn);
        }
        self.mode = mode;
        self.has_point = false;
        self.torque_demand = 0.0;
        self.motion = self.motion_of(mode);
    }

    /// P2-08: 10 clears AL201, and so do 30 and then 28.
    pub(super) fn special_write(&mut self, before: i64, value: i64) {
        if value == 10 || (before, value) == (30, 28) {
            self.clear(|alarm| alarm.clearing() == Clearing::SpecialWrite);
        }
    }

    /// An alarm that the bus or a person causes.
    pub(crate) fn raise(&mut self, alarm: Alarm) {
        if self.alarms.contains(&alarm) || self.alarms.push(alarm).is_err() {
            return;
        }
        self.pace.wake();
        self.error_code = alarm.code();
        self.tell(Event::Raised(alarm));
        let is_fault = self.effect(alarm) == Effect::Fault;
        self.news.push(News::Raised { what: InWords(alarm), is_fault });
        match self.effect(alarm) {
            Effect::Fault => self.go(state::Event::Fault),
            // The servo goes off without a ramp (CN-224).
            Effect::Warning if alarm.is_of_bus() && self.config.bus_error_coasts => {
                self.go(state::Event::Command(Command::DisableVoltage));
            }
            Effect::Warning => {}
        }
    }

    /// The cause of an alarm that needs no reset is gone.
    pub(crate) fn end(&mut self, alarm: Alarm) {
        if self.effect(alarm) == Effect::Warning {
            self.clear(|present| present == alarm);
        }
    }

    /// An alarm is not there any more, whatever it needs otherwise.
    pub(super) fn take_back(&mut self, alarm: Alarm) {
        self.clear(|present| present == alarm);
    }

    /// The alarms present, oldest first.
    pub fn alarms(&self) -> &[Alarm] {
        &self.alarms
    }

    /// What an alarm does to this drive. P3-10.Y = 0: errors of the bus leave the servo on (CN-224).
    fn effect(&self, alarm: Alarm) -> Effect {
        match (alarm.is_of_bus(), self.settings.digit(Setting::CanEnable, Digit::Y)) {
            (true, 1) => Effect::Fault,
            (true, _) => Effect::Warning,
            (false, _) => alarm.effect(),
        }
    }

    pub(super) fn has_fault(&self) -> bool {
        self.alarms.iter().any(|alarm| self.effect(*alarm) == Effect::Fault)
    }

    pub(super) fn has_warning(&self) -> bool {
        self.alarms.iter().any(|alarm| self.effect(*alarm) == Effect::Warning)
    }

    /// What is left of the error register.
    pub(crate) fn error_register(&self) -> u8 {
        self.alarms.iter().fold(0, |bits, alarm| bits | alarm.register())
    }

    fn reset_alarms(&mut self) {
        self.following_error = false;
        self.causes = Causes::default();
        self.clear(|alarm| alarm.clearing() == Clearing::Reset);
    }

    fn clear(&mut self, gone: impl Fn(Alarm) -> bool) {
        let before = self.alarms.len();
        self.alarms.retain(|alarm| !gone(*alarm));
        if self.alarms.len() != before {
            if self.alarms.is_empty() {
                self.error_code = 0;
            }
            self.tell(Event::Cleared(self.error_register()));
            self.news.push(News::Cleared);
        }
    }

    /// Looks for causes of alarms outside the plant.
    pub(super) fn watch(&mut self) {
        if !self.inputs.emergency_stop_released {
            self.raise(Alarm::EmergencyStop);
        }
        if self.is_on() && !self.inputs.main_circuit {
            self.raise(Alarm::Undervoltage);
        }
        let closed = self.switches_closed();
        // A homing looks for them.
        let minded = !self.is_homing();
        let now = Causes {
            reverse_limit: minded && closed.negative_limit,
            forward_limit: minded && closed.positive_limit,
            overload: self.plant.heat > 0.5,
            ..self.causes
        };
        self.warn(now);
    }

    /// Looks at the plant after a step.
    pub(super) fn watch_plant(&mut self) {
        if self.plant.heat >= 1.0 {
            self.raise(Alarm::Overload);
        }
        let window = self.settings.of(Setting::FollowingErrorWindow);
        let minded = self.is_on() && self.mode == Some(Mode::ProfilePosition);
        if minded && i64::from(self.following_error_puu()).abs() > window {
            self.following_error = true;
            self.raise(Alarm::Deviation);
        }
        self.count_window();
    }

    /// A software limit ended a motion: -1 the reverse one, 1 the forward one, 0 none.
    pub(super) fn at_soft_limit(&mut self, side: i8) {
        let now = Causes { reverse_soft_limit: side < 0, forward_soft_limit: side > 0, ..self.causes };
        self.warn(now);
    }

    /// Raises warnings whose cause begins, ends those whose cause is gone.
    fn warn(&mut self, now: Causes) {
        let before = core::mem::replace(&mut self.causes, now);
        let rows = [
            (Alarm::ReverseLimit, before.reverse_limit, now.reverse_limit),
            (Alarm::ForwardLimit, before.forward_limit, now.forward_limit),
            (Alarm::ReverseSoftLimit, before.reverse_soft_limit, now.reverse_soft_limit),
            (Alarm::ForwardSoftLimit, before.forward_soft_limit, now.forward_soft_limit),
            (Alarm::OverloadWarning, before.overload, now.overload),
        ];
        for (alarm, before, now) in rows {
            match (before, now) {
                (false, true) => {
                    self.raise(alarm);
                    self.protective_stop(alarm);
                }
                (true, false) => self.clear(|gone| gone == alarm),
                (false, false) | (true, true) => {}
            }
        }
    }

    /// P3-12.Y = 1: a stop by a limit is a quick stop that needs a fault reset.
    fn protective_stop(&mut self, alarm: Alarm) {
        let asked = self.settings.digit(Setting::QuickStopOptions, Digit::Y) == 1;
        if asked && alarm != Alarm::OverloadWarning {
            self.go(state::Event::Command(Command::QuickStop));
        }
    }
}
