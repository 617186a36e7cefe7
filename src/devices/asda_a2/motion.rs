//! What each mode demands of the plant in a step.

use core::time::Duration;

use super::alarm::Alarm;
use super::homing::{Homing, HomingState, Method, Progress, Speeds};
use super::inputs::{Axis, Closed, Switches};
use super::interpolation::{Interpolation, Point};
use super::plant::{Drive, Gains, approach, rpm};
use super::position::{From, Here, SetPoint, SetPoints};
use super::profile::{Demand, Ramp, acceleration};
use super::settings::{Digit, Setting};
use super::smooth::Smooth;
use super::{Level, Servo};
use crate::can_bus::cia402::{Controlword, Mode};
use crate::devices::servo::news::News;
use crate::devices::servo::pace::STEP_SECONDS;
use crate::time::Instant;

/// The motion of the mode in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    /// No mode, or a quick stop: the shaft is held.
    Hold,
    Position(SetPoints),
    Velocity,
    Torque,
    Homing(HomingState),
    Interpolation(Interpolation),
}

/// Periods of 1006h for interpolation (CN-235), us.
const CYCLE_MICROS: core::ops::RangeInclusive<i64> = 1000..=20_000;

impl Servo {
    pub(super) const fn motion_of(&self, mode: Option<Mode>) -> Motion {
        match mode {
            None
            | Some(Mode::Velocity | Mode::CyclicPosition | Mode::CyclicVelocity | Mode::CyclicTorque) => {
                Motion::Hold
            }
            Some(Mode::ProfilePosition) => Motion::Position(SetPoints::resting(self.demand.position)),
            Some(Mode::ProfileVelocity) => Motion::Velocity,
            Some(Mode::ProfileTorque) => Motion::Torque,
            Some(Mode::Homing) => Motion::Homing(HomingState::Ready),
            Some(Mode::InterpolatedPosition) => Motion::Interpolation(Interpolation::Waiting),
        }
    }

    /// The shaft came to rest after a change of the mode: relative set-points count from here, unless one was taken
    /// in the meantime.
    pub(super) const fn rest_here(&mut self) {
        if let Motion::Position(points) = self.motion
            && points.is_done()
        {
            self.motion = Motion::Position(SetPoints::resting(self.demand.position));
        }
    }

    /// Bits 4 to 6 of a controlword in operation enabled.
    pub(super) fn control_mode_bits(&mut self, word: Controlword, before: Controlword) {
        let rises = word.rises(before, Controlword::NEW_SET_POINT);
        let set_point = self.set_point(word.has(Controlword::RELATIVE));
        let here = Here { demand: self.demand.position, shaft: self.plant.position };
        match &mut self.motion {
            Motion::Position(points) => {
                if rises {
                    self.targets.take(self.settings.of(Setting::TargetPosition));
                    points.take(set_point, word.has(Controlword::CHANGE_IMMEDIATELY), here);
                    self.in_window = 0;
                } else if !word.has(Controlword::NEW_SET_POINT) {
                    points.release();
                }
            }
            Motion::Homing(HomingState::Ready | HomingState::Attained | HomingState::Failed) if rises => {
                self.start_homing();
            }
            Motion::Homing(_)
            | Motion::Hold
            | Motion::Velocity
            | Motion::Torque
            | Motion::Interpolation(_) => {}
        }
    }

    fn set_point(&self, relative: bool) -> SetPoint {
        let target = self.settings.of(Setting::TargetPosition) as f64 * self.gear();
        let (target, from) = if relative {
            (target, From::of_option(self.settings.of(Setting::PositioningOption)))
        } else {
            (target + self.origin, From::Zero)
        };
        let velocity =
            (self.settings.of(Setting::ProfileVelocity) as f64 * self.gear()).min(self.top_speed());
        let (acceleration, deceleration) = self.accelerations();
        let ramp = Ramp { velocity: velocity.max(1.0), acceleration, deceleration };
        SetPoint { target, from, ramp }
    }

    /// Those of a profile: 6083h and 6084h, no steeper than 60C5h and 60C6h. Homing, quick stop and faults have their own.
    fn accelerations(&self) -> (f64, f64) {
        let limited =
            |ramp: Setting, limit: Setting| acceleration(self.settings.of(ramp).max(self.settings.of(limit)));
        (
            limited(Setting::Acceleration, Setting::MaxAcceleration),
            limited(Setting::Deceleration, Setting::MaxDeceleration),
        )
    }

    fn start_homing(&mut self) {
        let number = self.settings.of(Setting::HomingMethod);
        self.in_window = 0;
        if number == 35 {
            self.home_at(self.demand.position);
            return;
        }
        let Some(method) = Method::of(number) else {
            self.motion = Motion::Homing(HomingState::Failed);
            self.news.push(News::HomingRefused { method: number });
            return;
        };
        let per_rpm = match self.level {
            Level::Half => rpm(1.0),
            Level::Full => rpm(0.1),
        };
        let speeds = Speeds {
            switch: self.settings.of(Setting::HomingSpeedSwitch) as f64 * per_rpm,
            zero: self.settings.of(Setting::HomingSpeedZero) as f64 * per_rpm,
            ramp: acceleration(self.settings.of(Setting::HomingAcceleration)),
        };
        if self.inputs.switches == Switches::WhileHoming {
            self.homing_axis = Some(Axis::around(self.plant.position, method.home_switch()));
        }
        let homing = Homing::begin(method, speeds, self.plant.position, self.switches_closed());
        self.motion = Motion::Homing(HomingState::Running(homing));
    }

    /// Position `home` is 607Ch from now on.
    fn home_at(&mut self, home: f64) {
        self.origin = home - self.settings.of(Setting::HomeOffset) as f64 * self.gear();
        self.homing_axis = None;
        self.motion = Motion::Homing(HomingState::Attained);
    }

    pub(super) const fn is_homing(&self) -> bool {
        matches!(self.motion, Motion::Homing(HomingState::Running(_)))
    }

    pub(super) fn switches_closed(&self) -> Closed {
        self.inputs.closed(self.plant.position, self.homing_axis)
    }

    /// SYNC: the position of 60C1h is the next one.
    pub(crate) fn sync(&mut self, now: Instant) {
        let Motion::Interpolation(before) = self.motion else { return };
        let on = self.is_on();
        let Some(cycle) = self.cycle() else {
            self.raise(if on { Alarm::SyncPeriod } else { Alarm::SyncPeriodOff });
            return;
        };
        // Without a position from the host there is nowhere to go.
        if !on || self.stopping.is_some() || !self.has_point {
            return;
        }
        if self.config.early_sync_alarm && before.expected_at().is_some_and(|due| self.is_early(now, due)) {
            self.raise(Alarm::SyncEarly);
            return;
        }
        let gear = self.gear();
        let position = self.settings.of(Setting::InterpolationPosition) as f64 * gear + self.origin;
        let difference = self.settings.of(Setting::InterpolationDifference) as f64 * gear;
        let with_difference = match (self.level, self.settings.of(Setting::InterpolationSubMode)) {
            (Level::Half, sub_mode) => sub_mode != -2,
            (Level::Full, sub_mode) => sub_mode == -1,
        };
        let slope = with_difference.then_some(difference / cycle.as_secs_f64());
        let mut next = before;
        next.sync(now, cycle, self.demand, Point { position, slope });
        let begin = next.demand(now).unwrap_or_default();
        let end = next.demand(now.saturating_add(cycle)).unwrap_or_default();
        if (end.position - begin.position).abs() > self.motor_speed() * cycle.as_secs_f64() {
            self.raise(Alarm::IpCommand);
            return;
        }
        self.motion = Motion::Interpolation(next);
        self.pace.wake();
    }

    fn is_early(&self, now: Instant, due: Instant) -> bool {
        let [_, high, ..] = self.settings.of(Setting::SyncAdjustment).to_le_bytes();
        let range = Duration::from_micros(u64::from(high >> 4) * 10);
        due.saturating_since(now) > range
    }

    /// The period of SYNC in force, `None` where it is not valid.
    pub(super) fn cycle(&self) -> Option<Duration> {
        let micros = match self.level {
            Level::Half => {
                let micros = self.settings.of(Setting::CyclePeriod);
                if !CYCLE_MICROS.contains(&micros) || micros % 1000 != 0 {
                    return None;
                }
                micros
            }
            // 60C2h:2 is always -3.
            Level::Full => self.settings.of(Setting::CycleUnits) * 1000,
        };
        u64::try_from(micros).ok().map(Duration::from_micros)
    }

    /// One step of the motion.
    pub(super) fn demand_of_step(&mut self) -> Drive {
        if !self.is_on() {
            self.demand = Demand { position: self.plant.position, velocity: 0.0 };
            let brake = self.settings.digit(Setting::StopMode, Digit::Y) == 0;
            self.smooth = None;
            return if brake { Drive::Brake } else { Drive::Free };
        }
        if self.motion == Motion::Velocity {
            let before = self.demand.position;
            self.demand.forget_lost_way(self.plant.position);
            if let Some(smooth) = &mut self.smooth {
                smooth.linear.position += self.demand.position - before;
            }
        }
        let from = self.demand.position;
        if let Some(stopping) = self.stopping {
            self.smooth = None;
            self.brake(stopping.deceleration);
            if self.demand.velocity == 0.0 {
                self.stopped();
            }
            if !self.is_on() {
                return Drive::Free;
            }
            return self.follow(from);
        }
        let demand = self.demand;
        match self.has_corners() {
            true => self.smooth = None,
            false => self.demand = self.smooth.get_or_insert_with(|| Smooth::of(demand)).linear,
        }
        if let Some(drive) = self.linear_step() {
            return drive;
        }
        if let Some(smooth) = &mut self.smooth {
            self.demand = smooth.step(demand, self.demand);
        }
        self.follow(from)
    }

    /// 6086h: 1 to 3 are the ramps of CiA 402 without corners (sin2, jerk-free, jerk-limited).
    fn has_corners(&self) -> bool {
        let linear = !matches!(self.settings.of(Setting::ProfileType), 1..=3);
        linear || !matches!(self.motion, Motion::Position(_) | Motion::Velocity)
    }

    /// One step with linear ramps. A torque is demanded without a position.
    fn linear_step(&mut self) -> Option<Drive> {
        let halted = self.control.has(Controlword::HALT);
        match self.motion {
            Motion::Hold => self.brake(self.accelerations().1),
            Motion::Position(_) | Motion::Velocity | Motion::Homing(HomingState::Running(_)) if halted => {
                self.brake(self.accelerations().1);
            }
            Motion::Position(mut points) => {
                let limits = self.soft_limits();
                let was_done = points.is_done();
                let before = self.demand;
                let here = self.plant.position;
                let side = points.step(&mut self.demand, here, limits, STEP_SECONDS);
                self.motion = Motion::Position(points);
                if !was_done {
                    self.at_soft_limit(side);
                }
                self.keep_off_switches(before);
            }
            Motion::Velocity => self.step_velocity(),
            Motion::Torque => return Some(self.step_torque(halted)),
            Motion::Homing(HomingState::Running(homing)) => self.step_homing(homing),
            Motion::Homing(HomingState::Ready | HomingState::Attained | HomingState::Failed) => {
                self.brake(acceleration(self.settings.of(Setting::HomingAcceleration)));
            }
            Motion::Interpolation(interpolation) => self.step_interpolation(interpolation),
        }
        None
    }

    fn follow(&self, from: f64) -> Drive {
        let gains = match self.mode {
            Some(Mode::ProfileVelocity) => Gains::OF_VELOCITY,
            Some(_) | None => Gains {
                error: self.settings.of(Setting::PositionGain) as f64,
                forward: self.settings.of(Setting::FeedForward) as f64 / 100.0,
            },
        };
        Drive::Position { from, way: self.demand.position - from, gains }
    }

    fn brake(&mut self, deceleration: f64) {
        self.demand.step_velocity(0.0, deceleration, deceleration, STEP_SECONDS);
    }

    fn step_velocity(&mut self) {
        let top = self.top_speed();
        let target = (rpm(0.1) * self.settings.of(Setting::TargetVelocity) as f64).clamp(-top, top);
        let before = self.demand;
        let (limits, ramps) = (self.soft_limits(), self.accelerations());
        let side = if target > 0.0 { 1 } else { -1 };
        let held = self.demand.step_velocity_within(limits, target, ramps, STEP_SECONDS);
        self.at_soft_limit(if held { side } else { 0 });
        self.keep_off_switches(before);
    }

    /// A limit switch stops the motion towards it.
    fn keep_off_switches(&mut self, before: Demand) {
        let closed = self.switches_closed();
        let velocity = self.demand.velocity;
        if velocity > 0.0 && closed.positive_limit || velocity < 0.0 && closed.negative_limit {
            self.demand = before;
            self.brake(acceleration(self.settings.of(Setting::QuickStopDeceleration)));
            if let Motion::Position(_) = self.motion {
                self.motion = Motion::Position(SetPoints::resting(self.demand.position));
            }
        }
    }

    fn step_torque(&mut self, halted: bool) -> Drive {
        let target = if halted { 0.0 } else { self.settings.of(Setting::TargetTorque) as f64 / 1000.0 };
        self.torque_demand = match self.settings.of(Setting::TorqueSlope) {
            ..=0 => target,
            millis => approach(self.torque_demand, target, 1.0 / millis as f64),
        };
        self.demand = Demand { position: self.plant.position, velocity: self.plant.velocity };
        Drive::Torque { torque: self.torque_demand, speed: self.motor_speed() }
    }

    fn step_homing(&mut self, mut homing: Homing) {
        let closed = self.switches_closed();
        match homing.step(&mut self.demand, self.plant.position, closed, STEP_SECONDS) {
            Progress::Running => self.motion = Motion::Homing(HomingState::Running(homing)),
            Progress::Done(home) => self.home_at(home),
            Progress::Failed => {
                self.homing_axis = None;
                self.motion = Motion::Homing(HomingState::Failed);
            }
        }
    }

    fn step_interpolation(&mut self, interpolation: Interpolation) {
        let Some(demand) = interpolation.demand(self.pace.now()) else { return };
        if interpolation.fails_at().is_some_and(|fails| self.pace.now() >= fails) {
            self.motion = Motion::Interpolation(Interpolation::Waiting);
            self.raise(Alarm::SyncTimeout);
            return;
        }
        self.demand = demand;
    }

    /// Increments per PUU.
    pub(super) fn gear(&self) -> f64 {
        let numerator = self.settings.of(Setting::GearNumerator) as f64;
        let denominator = self.settings.of(Setting::GearDenominator) as f64;
        numerator / denominator.max(1.0)
    }

    /// 607Dh as increments; without end as delivered.
    fn soft_limits(&self) -> (f64, f64) {
        let limit = |setting: Setting, none: f64| {
            let value = self.settings.of(setting);
            if value == setting.default() { none } else { value as f64 * self.gear() + self.origin }
        };
        let reverse = limit(Setting::ReverseSoftLimit, f64::NEG_INFINITY);
        let forward = limit(Setting::ForwardSoftLimit, f64::INFINITY);
        (reverse, forward.max(reverse))
    }

    /// The highest speed of a profile, increments/s.
    fn top_speed(&self) -> f64 {
        let profile = rpm(0.1) * self.settings.of(Setting::MaxProfileVelocity) as f64;
        profile.min(self.motor_speed())
    }

    /// 6080h, increments/s.
    fn motor_speed(&self) -> f64 {
        rpm(self.settings.of(Setting::MaxMotorSpeed) as f64)
    }

    /// Whether nothing changes by itself.
    pub(super) fn rests(&self) -> bool {
        let done = match self.motion {
            Motion::Hold | Motion::Velocity => true,
            Motion::Position(points) => points.is_done() || self.control.has(Controlword::HALT),
            Motion::Torque => self.torque_demand == 0.0 && self.settings.of(Setting::TargetTorque) == 0,
            Motion::Homing(state) => !matches!(state, HomingState::Running(_)),
            Motion::Interpolation(interpolation) => interpolation == Interpolation::Waiting,
        };
        let velocity = self.motion == Motion::Velocity && self.settings.of(Setting::TargetVelocity) != 0;
        let near = (self.demand.position - self.plant.position).abs() < 0.5;
        let idle = done && !velocity && near && self.demand.velocity == 0.0 && !self.is_stopping();
        self.plant.rests() && (!self.is_on() || idle) && self.window_is_settled()
    }
}
