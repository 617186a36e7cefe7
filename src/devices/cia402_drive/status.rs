//! Statusword, windows and actual values.

use super::motion::Motion;
use super::settings::{Actual, OFF, Setting};
use super::{Drive, Fault};
use crate::can_bus::cia402::{Controlword, Mode, State, Statusword};
use crate::devices::servo::homing::HomingState;
use crate::devices::servo::plant::rpm;

/// For how long values have been where they are supervised, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Windows {
    /// In the window of the target.
    target: u32,
    /// Below the threshold of the speed.
    zero: u32,
    /// Beyond the window of the following error.
    beyond: u32,
    following_error: bool,
}

impl Windows {
    pub(super) const fn begin_anew(&mut self) {
        self.target = 0;
    }
}

impl Drive {
    /// 6041h.
    pub(crate) fn statusword(&self) -> Statusword {
        let mut word = self.state.bits() | Statusword::REMOTE;
        word |= Statusword::VOLTAGE_ENABLED.when(self.inputs.main_circuit);
        word |= Statusword::TARGET_REACHED.when(self.target_reached());
        word |= Statusword::INTERNAL_LIMIT.when(self.is_on() && self.is_limited());
        let supervised = matches!(
            self.mode,
            Some(Mode::ProfilePosition | Mode::CyclicPosition | Mode::InterpolatedPosition)
        );
        word |= Statusword::FOLLOWING_ERROR.when(supervised && self.windows.following_error);
        if self.state != State::OperationEnabled {
            return word;
        }
        let follows = self.stopping.is_none() && !self.control.has(Controlword::HALT);
        word | match self.motion {
            Motion::Hold | Motion::Vl | Motion::Torque => Statusword::NONE,
            Motion::Position(points) => Statusword::SET_POINT_ACKNOWLEDGE.when(points.acknowledges()),
            Motion::Velocity => {
                let time = self.settings.of(Setting::VelocityThresholdTime);
                let is_zero = self.is_zero_speed() && i64::from(self.windows.zero) >= time;
                let slippage = self.settings.of(Setting::MaxSlippage);
                let off = (self.demand.velocity - self.plant.velocity) / self.units.velocity;
                let slips = slippage > 0 && off.abs() > slippage as f64;
                Statusword::ZERO_SPEED.when(is_zero) | Statusword::FOLLOWING_ERROR.when(slips)
            }
            Motion::Homing(HomingState::Attained) => Statusword::HOMING_ATTAINED,
            Motion::Homing(HomingState::Failed) => Statusword::HOMING_ERROR,
            Motion::Homing(HomingState::Ready | HomingState::Running(_)) => Statusword::NONE,
            Motion::Cyclic => {
                let active =
                    self.cyclic.demand(self.pace.now()).is_some() || self.mode == Some(Mode::CyclicPosition);
                Statusword::FOLLOWS_COMMAND.when(follows && active)
            }
            Motion::CyclicVelocity | Motion::CyclicTorque => Statusword::FOLLOWS_COMMAND.when(follows),
        }
    }

    /// Whether a limit holds the motion back.
    pub(crate) fn is_limited(&self) -> bool {
        let torque = self.torque_limit().min(3.0);
        self.limited || self.plant.torque.abs() >= torque * (1.0 - 1e-9)
    }

    fn target_reached(&self) -> bool {
        let stands = self.demand.velocity == 0.0;
        match self.state {
            State::OperationEnabled => {}
            State::QuickStopActive => return stands,
            State::NotReadyToSwitchOn
            | State::SwitchOnDisabled
            | State::ReadyToSwitchOn
            | State::SwitchedOn
            | State::FaultReactionActive
            | State::Fault => return false,
        }
        if self.control.has(Controlword::HALT) {
            return stands;
        }
        match self.motion {
            Motion::Hold | Motion::Cyclic | Motion::CyclicVelocity | Motion::CyclicTorque => false,
            Motion::Position(points) => points.is_done() && self.window_is_full(),
            Motion::Velocity | Motion::Vl => self.window_is_full(),
            Motion::Torque => (self.torque_demand - self.torque_target()).abs() < 1e-9,
            Motion::Homing(HomingState::Attained | HomingState::Failed) => stands,
            Motion::Homing(HomingState::Ready | HomingState::Running(_)) => false,
        }
    }

    fn is_in_window(&self) -> bool {
        // Units of the user, or rpm.
        let near = |target: f64| {
            let window = match self.settings.of(Setting::VelocityWindow) {
                ..=0 => rpm(5.0),
                window => window as f64 * self.units.velocity.abs(),
            };
            (target - self.plant.velocity).abs() <= window
        };
        match self.motion {
            Motion::Velocity => near(self.velocity_target()),
            Motion::Vl => near(self.vl_target()),
            Motion::Position(points) => match self.settings.of(Setting::PositionWindow) {
                OFF => true,
                window => {
                    let left = (points.target() - self.plant.position) / self.units.position;
                    libm::round(left).abs() <= window as f64
                }
            },
            Motion::Hold
            | Motion::Torque
            | Motion::Homing(_)
            | Motion::Cyclic
            | Motion::CyclicVelocity
            | Motion::CyclicTorque => false,
        }
    }

    fn is_zero_speed(&self) -> bool {
        let threshold = match self.settings.of(Setting::VelocityThreshold) {
            ..=0 => rpm(5.0),
            threshold => threshold as f64 * self.units.velocity.abs(),
        };
        self.plant.velocity.abs() < threshold
    }

    fn window_time(&self) -> i64 {
        let is_speed = matches!(self.motion, Motion::Velocity | Motion::Vl);
        self.settings.of(if is_speed { Setting::VelocityWindowTime } else { Setting::PositionWindowTime })
    }

    fn window_is_full(&self) -> bool {
        self.is_in_window() && i64::from(self.windows.target) >= self.window_time()
    }

    pub(super) fn windows_are_settled(&self) -> bool {
        let waits = self.is_zero_speed()
            && i64::from(self.windows.zero) < self.settings.of(Setting::VelocityThresholdTime);
        !self.is_on() || (!self.is_in_window() || self.window_is_full()) && !waits
    }

    /// Counts a step; says whether the following error has been beyond its window for its time out.
    pub(super) fn count_windows(&mut self) -> bool {
        let count = |holds: bool, count: u32| if holds { count.saturating_add(1) } else { 0 };
        let (in_window, is_zero) = (self.is_in_window(), self.is_zero_speed());
        let windows = &mut self.windows;
        windows.target = count(in_window, windows.target);
        windows.zero = count(is_zero, windows.zero);
        let window = self.settings.of(Setting::FollowingWindow);
        let is_position = matches!(self.motion, Motion::Position(_) | Motion::Cyclic | Motion::Homing(_));
        let minded = self.is_on() && is_position && window > 0 && window < OFF;
        let beyond = minded && self.following_error().abs() > window;
        self.windows.beyond = count(beyond, self.windows.beyond);
        let time = self.settings.of(Setting::FollowingTime);
        let is_error = i64::from(self.windows.beyond) > time;
        self.windows.following_error = is_error || self.fault == Some(Fault::FOLLOWING);
        is_error
    }

    /// 60F4h.
    fn following_error(&self) -> i64 {
        whole((self.demand.position - self.plant.position) / self.units.position)
    }

    /// A position in units of the user, counted from home.
    pub(super) fn user_position(&self, increments: f64) -> i64 {
        whole(self.in_range(increments - self.origin) / self.units.position)
    }

    /// 6061h.
    pub(crate) const fn mode(&self) -> Option<Mode> {
        self.mode
    }

    /// Revolutions of the motor in a minute.
    pub(crate) fn motor_rpm(&self) -> f64 {
        self.plant.velocity / rpm(1.0)
    }

    /// The torque of the motor in per cent of the rated one.
    pub(crate) const fn torque_percent(&self) -> f64 {
        self.plant.torque * 100.0
    }

    /// Whether it moves.
    pub(crate) fn is_moving(&self) -> bool {
        self.is_on() && (self.demand.velocity != 0.0 || !self.is_zero_speed())
    }

    /// The number of an object.
    pub(crate) fn actual(&self, actual: Actual) -> i64 {
        let (demand, plant) = (&self.demand, &self.plant);
        let internal = |position: f64| whole((position - self.origin) / self.units.encoder);
        let side = 1.0_f64.copysign(self.units.velocity);
        let torque = if self.motion.is_torque() { self.torque_demand } else { plant.torque * side };
        let [first, second] = self.probes.positions();
        match actual {
            Actual::ErrorCode => self.fault.map_or(0, |fault| fault.0.into()),
            Actual::Statusword => self.statusword().0.into(),
            Actual::VlDemand => whole(demand.velocity / self.units.vl),
            Actual::VlVelocity => whole(plant.velocity / self.units.vl),
            Actual::ModeDisplay => self.mode.map_or(0, Mode::code).into(),
            Actual::PositionDemand => self.user_position(demand.position),
            Actual::PositionInternal => internal(plant.position),
            Actual::Position => self.user_position(plant.position),
            Actual::VelocityDemand => whole(demand.velocity / self.units.velocity),
            Actual::Velocity => whole(plant.velocity / self.units.velocity),
            Actual::TorqueDemand => whole(torque * 1000.0),
            Actual::Torque | Actual::Current => whole(plant.torque * side * 1000.0),
            Actual::ProbeStatus => self.probes.status(),
            Actual::Probe1Rising => first.0,
            Actual::Probe1Falling => first.1,
            Actual::Probe2Rising => second.0,
            Actual::Probe2Falling => second.1,
            Actual::FollowingError => self.following_error(),
            Actual::PositionDemandInternal => internal(demand.position),
            Actual::DigitalInputs => self.switches_closed().word().into(),
            Actual::SupportedModes => self.modes.into(),
        }
    }
}

/// The nearest whole number.
#[expect(clippy::cast_possible_truncation, reason = "saturates")]
fn whole(value: f64) -> i64 {
    libm::round(value) as i64
}
