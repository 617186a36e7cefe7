//! What each mode demands of the plant in a step.

use super::Drive;
use super::settings::{OFF, Setting};
use crate::can_bus::cia402::{Controlword, Mode, Stop};
use crate::devices::servo::homing::{Homing, HomingState, Method, Progress, Speeds};
use crate::devices::servo::inputs::{Axis, Closed, Switches};
use crate::devices::servo::news::News;
use crate::devices::servo::pace::STEP_SECONDS;
use crate::devices::servo::plant::{self, Gains, INCREMENTS_PER_REVOLUTION, Motor, approach, rpm};
use crate::devices::servo::position::{From, Here, SetPoint, SetPoints};
use crate::devices::servo::profile::{Demand, Ramp};
use crate::time::Instant;

/// The motion of the mode in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    /// No mode, or a quick stop: the shaft is held.
    Hold,
    /// pp.
    Position(SetPoints),
    /// pv.
    Velocity,
    /// vl.
    Vl,
    /// tq.
    Torque,
    /// hm.
    Homing(HomingState),
    /// csp and ip.
    Cyclic,
    /// csv.
    CyclicVelocity,
    /// cst.
    CyclicTorque,
}

/// Turns/s and turns/s^2 where the objects say 0.
const VELOCITY: f64 = 10.0 * INCREMENTS_PER_REVOLUTION;
const ACCELERATION: f64 = 100.0 * INCREMENTS_PER_REVOLUTION;
const HOMING: f64 = 2.0 * INCREMENTS_PER_REVOLUTION;

/// Bits 4 to 6 of the controlword in vl: all of them, and the ramp follows 6042h.
const RAMP: Controlword = Controlword::NEW_SET_POINT;
const UNLOCK: Controlword = Controlword::CHANGE_IMMEDIATELY;
const REFERENCE: Controlword = Controlword::RELATIVE;

impl Motion {
    pub(super) const fn is_torque(&self) -> bool {
        matches!(self, Self::Torque | Self::CyclicTorque)
    }
}

impl Drive {
    pub(super) const fn motion_of(&self, mode: Option<Mode>) -> Motion {
        match mode {
            None => Motion::Hold,
            Some(Mode::ProfilePosition) => Motion::Position(SetPoints::resting(self.demand.position)),
            Some(Mode::Velocity) => Motion::Vl,
            Some(Mode::ProfileVelocity) => Motion::Velocity,
            Some(Mode::ProfileTorque) => Motion::Torque,
            Some(Mode::Homing) => Motion::Homing(HomingState::Ready),
            Some(Mode::InterpolatedPosition | Mode::CyclicPosition) => Motion::Cyclic,
            Some(Mode::CyclicVelocity) => Motion::CyclicVelocity,
            Some(Mode::CyclicTorque) => Motion::CyclicTorque,
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
                    self.windows.begin_anew();
                } else if !word.has(Controlword::NEW_SET_POINT) {
                    points.release();
                }
            }
            Motion::Homing(HomingState::Ready | HomingState::Attained | HomingState::Failed) if rises => {
                self.start_homing();
            }
            // Without bit 4 a homing ends where it is.
            Motion::Homing(HomingState::Running(_)) if !word.has(Controlword::NEW_SET_POINT) => {
                self.homing_axis = None;
                self.motion = Motion::Homing(HomingState::Ready);
            }
            Motion::Homing(_)
            | Motion::Hold
            | Motion::Velocity
            | Motion::Vl
            | Motion::Torque
            | Motion::Cyclic
            | Motion::CyclicVelocity
            | Motion::CyclicTorque => {}
        }
    }

    fn set_point(&self, relative: bool) -> SetPoint {
        let target = self.settings.of(Setting::TargetPosition) as f64 * self.units.position;
        let (target, from) = if relative {
            (target, From::of_option(self.settings.of(Setting::PositioningOption)))
        } else {
            (target + self.origin + self.turns_to(target), From::Zero)
        };
        let velocity = self.speed(Setting::ProfileVelocity, VELOCITY).min(self.top_speed());
        let ramp = Ramp {
            velocity: velocity.max(1.0),
            acceleration: self.profile_acceleration(),
            deceleration: self.profile_deceleration(),
        };
        SetPoint { target, from, ramp }
    }

    /// 607Bh: how far positions run before they begin anew, increments.
    pub(super) fn position_range(&self) -> Option<(f64, f64)> {
        let (min, max) = (self.settings.of(Setting::RangeMin), self.settings.of(Setting::RangeMax));
        let units = max - min + 1;
        let is_range = max > min && units <= OFF;
        is_range.then_some((min as f64 * self.units.position, units as f64 * self.units.position))
    }

    /// Whole ranges of 607Bh from an absolute target to where it is meant, by bits 6 and 7 of 60F2h: within the range that the
    /// shaft is in, backwards, forwards, or the shorter way.
    fn turns_to(&self, target: f64) -> f64 {
        let Some((_, range)) = self.position_range() else { return 0.0 };
        let from = self.demand.position - self.origin;
        let here = self.in_range(from);
        let way = target - here;
        let size = range.abs();
        let more = match self.settings.of(Setting::PositioningOption) >> 6 & 3 {
            1 if way > 0.0 => -size,
            2 if way < 0.0 => size,
            3 if way > size / 2.0 => -size,
            3 if way < -size / 2.0 => size,
            _ => 0.0,
        };
        from - here + more
    }

    /// A position within 607Bh, counted from home.
    pub(super) fn in_range(&self, position: f64) -> f64 {
        let Some((min, range)) = self.position_range() else { return position };
        let turns = libm::floor((position - min) / range);
        position - turns * range
    }

    fn start_homing(&mut self) {
        let number = self.settings.of(Setting::HomingMethod);
        self.windows.begin_anew();
        if matches!(number, 35 | 37) {
            self.home_at(self.demand.position);
            return;
        }
        let Some(method) = Method::of(number) else {
            self.motion = Motion::Homing(HomingState::Failed);
            self.news.push(News::HomingRefused { method: number });
            return;
        };
        let switch = self.speed(Setting::HomingFast, HOMING).min(self.motor_speed());
        let zero = self.speed(Setting::HomingSlow, 0.1 * switch).min(self.motor_speed());
        let speeds = Speeds { switch, zero, ramp: self.homing_acceleration() };
        if self.inputs.switches == Switches::WhileHoming {
            self.homing_axis = Some(Axis::around(self.plant.position, method.home_switch()));
        }
        let homing = Homing::begin(method, speeds, self.plant.position, self.switches_closed());
        self.motion = Motion::Homing(HomingState::Running(homing));
    }

    /// Position `home` is 607Ch from now on.
    fn home_at(&mut self, home: f64) {
        self.origin = home - self.settings.of(Setting::HomeOffset) as f64 * self.units.position;
        self.homing_axis = None;
        self.motion = Motion::Homing(HomingState::Attained);
    }

    pub(super) fn switches_closed(&self) -> Closed {
        self.inputs.closed(self.plant.position, self.homing_axis)
    }

    /// SYNC: the position of csp and ip is the next one.
    pub(crate) fn sync(&mut self, now: Instant) {
        self.cyclic.sync(now);
        self.next_point(now);
    }

    /// A position of csp or ip was written.
    pub(super) fn cyclic_written(&mut self) {
        if self.cyclic.is_without_sync(self.pace.now()) {
            self.next_point(self.pace.now());
        }
    }

    fn next_point(&mut self, now: Instant) {
        let Some(target) = self.cyclic_target() else { return };
        let enabled = self.state == crate::can_bus::cia402::State::OperationEnabled;
        let (low, high) = self.soft_limits();
        if enabled && self.stopping.is_none() {
            self.cyclic.point(now, self.demand, target.clamp(low, high), &self.settings);
            self.pace.wake();
        }
    }

    /// Where csp or ip want the shaft; `None`: another mode, or bit 4 of 6040h keeps ip from it.
    fn cyclic_target(&self) -> Option<f64> {
        let units = match self.mode {
            Some(Mode::CyclicPosition) => {
                self.settings.of(Setting::TargetPosition) + self.settings.of(Setting::PositionOffset)
            }
            Some(Mode::InterpolatedPosition) if self.control.has(Controlword::NEW_SET_POINT) => {
                self.settings.of(Setting::IpTarget)
            }
            _ => return None,
        };
        let target = units as f64 * self.units.position;
        // Through the end of 607Bh it goes on, the shorter way.
        let turns = self.position_range().map_or(0.0, |(_, range)| {
            libm::round((self.demand.position - self.origin - target) / range) * range
        });
        Some(target + turns + self.origin)
    }

    /// One step of the motion.
    pub(super) fn demand_of_step(&mut self) -> plant::Drive {
        if !self.is_on() {
            self.demand = Demand { position: self.plant.position, velocity: 0.0 };
            return plant::Drive::Free;
        }
        if matches!(self.motion, Motion::Velocity | Motion::Vl | Motion::CyclicVelocity) {
            self.demand.forget_lost_way(self.plant.position);
        }
        let from = self.demand.position;
        if let Some(stopping) = self.stopping {
            self.brake(stopping.deceleration);
            if self.demand.velocity == 0.0 {
                self.stopped();
            }
            return if self.is_on() { self.follow(from) } else { plant::Drive::Free };
        }
        let before = self.demand;
        if self.control.has(Controlword::HALT) {
            if self.motion.is_torque() {
                return self.step_torque(0.0);
            }
            self.brake(self.halt_deceleration());
            return self.follow(from);
        }
        match self.motion {
            Motion::Hold => self.brake(self.deceleration(Stop::SlowDownRamp)),
            Motion::Position(mut points) => {
                let limits = self.soft_limits();
                self.limited = points.target() < limits.0 || points.target() > limits.1;
                points.step(&mut self.demand, self.plant.position, limits, STEP_SECONDS);
                self.motion = Motion::Position(points);
            }
            Motion::Velocity => {
                let target = self.velocity_target().clamp(-self.top_speed(), self.top_speed());
                let (up, down) = (self.profile_acceleration(), self.profile_deceleration());
                self.step_velocity(target, up, down);
            }
            Motion::Vl => self.step_vl(),
            Motion::CyclicVelocity => {
                let target = self.velocity_target();
                let top = self.motor_speed();
                self.step_velocity(target.clamp(-top, top), f64::INFINITY, f64::INFINITY);
            }
            Motion::Torque | Motion::CyclicTorque => return self.step_torque(self.torque_target()),
            Motion::Homing(HomingState::Running(homing)) => self.step_homing(homing),
            Motion::Homing(HomingState::Ready | HomingState::Attained | HomingState::Failed) => {
                self.brake(self.homing_acceleration());
            }
            Motion::Cyclic if self.cyclic_target().is_none() => {
                self.brake(self.profile_deceleration());
                self.cyclic.begin_anew();
            }
            Motion::Cyclic => {
                if let Some(demand) = self.cyclic.demand(self.pace.now()) {
                    self.demand = demand;
                }
            }
        }
        self.keep_off_switches(before);
        self.follow(from)
    }

    fn follow(&self, from: f64) -> plant::Drive {
        plant::Drive::Position { from, way: self.demand.position - from, gains: Gains::OF_VELOCITY }
    }

    pub(super) fn brake(&mut self, deceleration: f64) {
        self.demand.step_velocity(0.0, deceleration, deceleration, STEP_SECONDS);
    }

    /// 60FFh, with 60B1h in csv; increments/s.
    pub(super) fn velocity_target(&self) -> f64 {
        let offset = self.offset(Mode::CyclicVelocity, Setting::VelocityOffset);
        (self.settings.of(Setting::TargetVelocity) + offset) as f64 * self.units.velocity
    }

    /// 6042h within 6046h; increments/s.
    pub(super) fn vl_target(&self) -> f64 {
        let target = self.settings.of(Setting::VlTarget) as f64;
        let most = self.settings.above_zero(Setting::VlMax, f64::INFINITY);
        let least = self.settings.above_zero(Setting::VlMin, 0.0).min(most);
        let amount = if target == 0.0 { 0.0 } else { target.abs().clamp(least, most) };
        (amount.copysign(target) * self.units.vl).clamp(-self.motor_speed(), self.motor_speed())
    }

    fn step_vl(&mut self) {
        let up = self.vl_ramp(Setting::VlAccelerationSpeed, Setting::VlAccelerationTime);
        let down = self.vl_ramp(Setting::VlDecelerationSpeed, Setting::VlDecelerationTime);
        let word = self.control;
        match (word.has(RAMP), word.has(UNLOCK), word.has(REFERENCE)) {
            (true, true, true) => self.step_velocity(self.vl_target(), up, down),
            // Locked: the speed stays as it is.
            (true, false, _) => self.step_velocity(self.demand.velocity, up, down),
            (true, true, false) | (false, _, _) => self.brake(down),
        }
    }

    /// Towards a velocity, at most to the limit of the position.
    fn step_velocity(&mut self, target: f64, acceleration: f64, deceleration: f64) {
        let (limits, ramps) = (self.soft_limits(), (acceleration, deceleration));
        self.limited = self.demand.step_velocity_within(limits, target, ramps, STEP_SECONDS);
    }

    /// A limit switch stops the motion towards it.
    fn keep_off_switches(&mut self, before: Demand) {
        if matches!(self.motion, Motion::Homing(_)) {
            return;
        }
        let closed = self.switches_closed();
        let velocity = self.demand.velocity;
        if velocity > 0.0 && closed.positive_limit || velocity < 0.0 && closed.negative_limit {
            self.demand = before;
            self.limited = true;
            self.brake(self.deceleration(Stop::QuickStopRamp));
            if let Motion::Position(_) = self.motion {
                self.motion = Motion::Position(SetPoints::resting(self.demand.position));
            }
        }
    }

    /// 6071h, with 60B2h in cst; in parts of the rated torque, by the direction of the user.
    pub(super) fn torque_target(&self) -> f64 {
        let offset = self.offset(Mode::CyclicTorque, Setting::TorqueOffset);
        (self.settings.of(Setting::TargetTorque) + offset) as f64 / 1000.0
    }

    /// What is added to the target in this mode.
    fn offset(&self, mode: Mode, offset: Setting) -> i64 {
        if self.mode == Some(mode) { self.settings.of(offset) } else { 0 }
    }

    fn step_torque(&mut self, target: f64) -> plant::Drive {
        let slope = match (self.motion, self.settings.of(Setting::TorqueSlope)) {
            (Motion::CyclicTorque, _) | (_, ..=0) => f64::INFINITY,
            (_, slope) => slope as f64 / 1000.0 * STEP_SECONDS,
        };
        let limit = self.torque_limit();
        self.torque_demand = approach(self.torque_demand, target.clamp(-limit, limit), slope);
        self.demand = Demand { position: self.plant.position, velocity: self.plant.velocity };
        let torque = self.torque_demand.copysign(self.torque_demand * self.units.velocity);
        plant::Drive::Torque { torque, speed: self.motor_speed() }
    }

    /// 6072h, 60E0h and 60E1h, in parts of the rated torque.
    pub(super) fn torque_limit(&self) -> f64 {
        let limit = |setting| self.settings.above_zero(setting, f64::INFINITY) / 1000.0;
        let ahead = self.plant.torque * self.units.velocity >= 0.0;
        let by_side = if ahead { Setting::PositiveTorque } else { Setting::NegativeTorque };
        limit(Setting::MaxTorque).min(limit(by_side)).min(1e6)
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

    /// 607Dh as increments; none while both are the same.
    pub(super) fn soft_limits(&self) -> (f64, f64) {
        let (min, max) = (self.settings.of(Setting::LimitMin), self.settings.of(Setting::LimitMax));
        if min >= max {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        let [one, other] = [min, max].map(|limit| limit as f64 * self.units.position + self.origin);
        (one.min(other), one.max(other))
    }

    fn speed(&self, setting: Setting, otherwise: f64) -> f64 {
        match self.settings.of(setting) {
            ..=0 => otherwise,
            speed => speed as f64 * self.units.velocity.abs(),
        }
    }

    /// The highest speed of a profile, increments/s.
    fn top_speed(&self) -> f64 {
        self.speed(Setting::MaxProfileVelocity, f64::INFINITY).min(self.motor_speed())
    }

    /// 6080h, increments/s.
    fn motor_speed(&self) -> f64 {
        let most = Motor::MAX_RPM as f64;
        rpm(self.settings.above_zero(Setting::MaxMotorSpeed, most).min(most))
    }

    /// A ramp below its limit, increments/s^2.
    pub(super) fn acceleration(&self, setting: Setting, otherwise: f64, most: Setting) -> f64 {
        let of = |setting, none: f64| match self.settings.of(setting) {
            ..=0 | OFF => none,
            value => value as f64 * self.units.acceleration.abs(),
        };
        of(setting, otherwise).min(of(most, f64::INFINITY))
    }

    fn profile_acceleration(&self) -> f64 {
        self.acceleration(Setting::Acceleration, ACCELERATION, Setting::MaxAcceleration)
    }

    pub(super) fn profile_deceleration(&self) -> f64 {
        let up = self.profile_acceleration();
        self.acceleration(Setting::Deceleration, up, Setting::MaxDeceleration)
    }

    pub(super) fn homing_acceleration(&self) -> f64 {
        let up = self.profile_acceleration();
        self.acceleration(Setting::HomingAcceleration, up, Setting::MaxAcceleration)
    }

    /// Whether nothing changes by itself.
    pub(super) fn rests(&self) -> bool {
        let halted = self.control.has(Controlword::HALT);
        let done = match self.motion {
            Motion::Hold => true,
            Motion::Position(points) => points.is_done() || halted,
            Motion::Velocity | Motion::CyclicVelocity => self.velocity_target() == 0.0 || halted,
            Motion::Vl => self.settings.of(Setting::VlTarget) == 0 || halted,
            Motion::Torque | Motion::CyclicTorque => {
                self.torque_demand == 0.0 && (self.torque_target() == 0.0 || halted)
            }
            Motion::Homing(state) => !matches!(state, HomingState::Running(_)) || halted,
            Motion::Cyclic => self.cyclic.is_done(self.pace.now()),
        };
        let near = (self.demand.position - self.plant.position).abs() < 0.5;
        let idle = done && near && self.demand.velocity == 0.0 && !self.is_stopping();
        self.plant.rests() && (!self.is_on() || idle) && self.windows_are_settled()
    }
}
