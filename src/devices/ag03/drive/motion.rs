//! Motion of the output shaft: phases of constant acceleration, evaluated from the exact elapsed time.
//!
//! A plan is laid once, when something changes (a job starts, pauses, resumes, stops; the motor is released; a load
//! kept the shaft from following), from the position and velocity of that moment. Steps only look up where the plan is by now, so the length of a step
//! changes nothing but how often one looks, and errors do not add up. The last phase of each travel is computed
//! backwards from its end: the shaft arrives exactly and cannot overshoot by rounding.

use super::lapse::Lapse;
use super::scale::INCREMENTS_PER_REVOLUTION;

/// 100 % acceleration, 4 rev/s^2, in increments/s^2 (manual chapter 6, no. 4).
const FULL_ACCELERATION: f64 = 4.0 * INCREMENTS_PER_REVOLUTION;

/// Distances below this many increments are rounding, not motion.
const ROUNDING: f64 = 1e-6;

/// Speed and accelerations of one travel, latched when it starts. Increments and seconds, all above zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dynamics {
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) deceleration: f64,
}

/// An acceleration in % of 4 rev/s^2 as increments/s^2, limited to 1..=100 %.
pub(super) fn acceleration(percent: u16) -> f64 {
    f64::from(percent.clamp(1, 100)) / 100.0 * FULL_ACCELERATION
}

/// A velocity in rpm as increments/s.
pub(super) fn velocity(rpm: i32) -> f64 {
    f64::from(rpm) * INCREMENTS_PER_REVOLUTION / 60.0
}

/// A velocity in increments/s as rpm.
pub(super) fn rpm(velocity: f64) -> f64 {
    velocity * 60.0 / INCREMENTS_PER_REVOLUTION
}

/// What a plan is to end with.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aim {
    /// At rest at this place.
    Target { target: f64, dynamics: Dynamics },
    /// At rest as soon as this deceleration allows.
    Rest { deceleration: f64 },
    /// With this velocity, held.
    Velocity { velocity: f64, acceleration: f64 },
}

/// The shaft: where it is, how fast it turns, and the plan it follows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    position: f64,
    velocity: f64,
    aim: Aim,
    plan: Plan,
    /// How far into the plan the shaft is: whole nanoseconds, and seconds left over from the plan before.
    elapsed: u64,
    carried: f64,
}

impl Motion {
    /// A shaft at rest.
    pub(super) const fn at(position: f64) -> Self {
        let aim = Aim::Rest { deceleration: FULL_ACCELERATION };
        Self { position, velocity: 0.0, aim, plan: Plan::from(position, 0.0), elapsed: 0, carried: 0.0 }
    }

    /// Angle of the shaft in increments.
    pub(super) fn position(&self) -> f64 {
        self.position
    }

    /// Speed of the shaft in increments/s, signed.
    pub(super) fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Whether the plan has ended and the shaft stands.
    pub(super) fn at_rest(&self) -> bool {
        self.plan.end <= 0.0
    }

    /// The velocity the plan ends with, increments/s: 0 unless one is held.
    pub(super) fn final_velocity(&self) -> f64 {
        self.plan.velocity
    }

    /// Whether the plan leads to `target` with these dynamics.
    pub(super) fn leads_to(&self, target: f64, dynamics: Dynamics) -> bool {
        self.aim == Aim::Target { target, dynamics }
    }

    /// The shaft is at `position` and turns with `velocity`: from there a new plan leads to what the old one led to,
    /// with the same speed and accelerations.
    pub(super) fn begin_anew(&mut self, position: f64, velocity: f64) {
        self.position = position;
        self.velocity = velocity;
        match self.aim {
            Aim::Target { target, dynamics } => self.travel_to(target, dynamics),
            Aim::Rest { deceleration } => self.brake(deceleration),
            Aim::Velocity { velocity, acceleration } => self.ramp_to(velocity, acceleration),
        }
    }

    /// Moves the plan and the place in it by `way` increments.
    pub(super) fn shift(&mut self, way: f64) {
        self.position += way;
        self.plan.position += way;
        if let Aim::Target { target, .. } = &mut self.aim {
            *target += way;
        }
        for phase in &mut self.plan.phases {
            phase.position += way;
        }
    }

    /// Lets `lapse` pass. If the plan ends within it, returns how many seconds before the end of `lapse`.
    pub(super) fn advance(&mut self, lapse: Lapse) -> Option<f64> {
        if self.at_rest() {
            return None;
        }
        self.elapsed = self.elapsed.saturating_add(lapse.nanos());
        self.follow()
    }

    /// Begins the plan `seconds` in the past. Returns as [`Motion::advance`].
    pub(super) fn skip(&mut self, seconds: f64) -> Option<f64> {
        if self.at_rest() {
            return None;
        }
        self.carried = seconds;
        self.follow()
    }

    /// Travels to `target` and stands there.
    ///
    /// Only a shaft that already turns and cannot stop in time (a coasting one that is caught) runs past the
    /// target, brakes and comes back.
    pub(super) fn travel_to(&mut self, target: f64, dynamics: Dynamics) {
        let mut plan = Plan::from(self.position, self.velocity);
        let away = (target - self.position) * self.velocity < 0.0;
        let stopping = plan.stopping_distance(dynamics.deceleration);
        if away || stopping > (target - self.position).abs() + ROUNDING {
            plan.ramp(0.0, dynamics.deceleration);
        }
        plan.travel(target, dynamics);
        self.begin(Aim::Target { target, dynamics }, plan);
    }

    /// Brakes to standstill with `deceleration` in increments/s^2.
    pub(super) fn brake(&mut self, deceleration: f64) {
        let mut plan = Plan::from(self.position, self.velocity);
        let distance = plan.stopping_distance(deceleration);
        plan.rest_at(self.position + sign(self.velocity) * distance);
        self.begin(Aim::Rest { deceleration }, plan);
    }

    /// Takes on `velocity` (increments/s) with `acceleration` (increments/s^2) and holds it.
    pub(super) fn ramp_to(&mut self, velocity: f64, acceleration: f64) {
        let mut plan = Plan::from(self.position, self.velocity);
        plan.ramp(velocity, acceleration);
        if velocity != 0.0 {
            plan.hold();
        }
        self.begin(Aim::Velocity { velocity, acceleration }, plan);
    }

    fn begin(&mut self, aim: Aim, plan: Plan) {
        self.aim = aim;
        self.plan = plan;
        self.elapsed = 0;
        self.carried = 0.0;
        if self.at_rest() {
            self.stand();
        }
    }

    /// Brings position and velocity up to the elapsed time.
    fn follow(&mut self) -> Option<f64> {
        let now = self.elapsed as f64 * 1e-9 + self.carried;
        if now >= self.plan.end {
            let left = now - self.plan.end;
            self.stand();
            return Some(left);
        }
        if let Some(phase) = self.plan.phases.iter().rfind(|phase| phase.from <= now) {
            let time = now - phase.anchor;
            self.position = phase.position + (phase.velocity + 0.5 * phase.acceleration * time) * time;
            self.velocity = phase.velocity + phase.acceleration * time;
        }
        None
    }

    fn stand(&mut self) {
        *self = Self { aim: self.aim, ..Self::at(self.plan.position) };
    }
}

/// Phases of constant acceleration, one after the other, and where they lead.
#[derive(Clone, Debug, PartialEq)]
struct Plan {
    /// Unused ones begin never.
    phases: [Phase; 4],
    /// When the plan ends, s after its beginning: 0 = nothing to do, infinite = the last velocity is held.
    end: f64,
    /// Position and velocity at the end of the last phase laid.
    position: f64,
    velocity: f64,
}

/// A stretch of constant acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Phase {
    /// When it begins, s after the beginning of the plan.
    from: f64,
    /// When it has the position and velocity below, s: at its beginning, or at its end if that is a standstill.
    anchor: f64,
    position: f64,
    velocity: f64,
    acceleration: f64,
}

impl Plan {
    const fn from(position: f64, velocity: f64) -> Self {
        let never = Phase { from: f64::INFINITY, anchor: 0.0, position, velocity, acceleration: 0.0 };
        Self { phases: [never; 4], end: 0.0, position, velocity }
    }

    /// The way to standstill from the velocity at the end of the plan.
    fn stopping_distance(&self, deceleration: f64) -> f64 {
        self.velocity * self.velocity / (2.0 * deceleration)
    }

    /// From the end of the plan so far to standstill at `target`. The plan ends at rest, or slow enough towards it.
    fn travel(&mut self, target: f64, dynamics: Dynamics) {
        let Dynamics { speed, acceleration, deceleration } = dynamics;
        let distance = (target - self.position).abs();
        let direction = sign(target - self.position);
        let entry = self.velocity.abs();
        // Acceleration from `entry` to `peak` and braking from `peak` fill the distance:
        // (peak^2 - entry^2) / 2a + peak^2 / 2d = distance.
        let peak = libm::sqrt(
            deceleration * (2.0 * acceleration * distance + entry * entry) / (acceleration + deceleration),
        );
        if entry > speed {
            self.ramp(direction * speed, deceleration);
        } else {
            self.ramp(direction * peak.max(entry).min(speed), acceleration);
        }
        let cruise = (target - self.position) * direction - self.stopping_distance(deceleration);
        if cruise > 0.0 && self.velocity != 0.0 {
            let duration = cruise / self.velocity.abs();
            self.lay(duration, 0.0, self.position + direction * cruise, self.velocity);
        }
        self.rest_at(target);
    }

    /// A change to `velocity`.
    fn ramp(&mut self, velocity: f64, acceleration: f64) {
        let change = velocity - self.velocity;
        let duration = change.abs() / acceleration;
        let position = self.position + 0.5 * (self.velocity + velocity) * duration;
        self.lay(duration, sign(change) * acceleration, position, velocity);
    }

    /// Even braking that ends at rest exactly at `target`.
    fn rest_at(&mut self, target: f64) {
        let distance = (target - self.position).abs();
        let from = self.end;
        if distance > 0.0 && self.velocity != 0.0 {
            self.end += 2.0 * distance / self.velocity.abs();
            let acceleration = -self.velocity * self.velocity.abs() / (2.0 * distance);
            self.push(Phase { from, anchor: self.end, position: target, velocity: 0.0, acceleration });
        }
        self.position = target;
        self.velocity = 0.0;
    }

    /// The last velocity for ever.
    fn hold(&mut self) {
        self.lay(f64::INFINITY, 0.0, self.position, self.velocity);
    }

    fn lay(&mut self, duration: f64, acceleration: f64, position: f64, velocity: f64) {
        if duration > 0.0 {
            let from = self.end;
            self.push(Phase {
                from,
                anchor: from,
                position: self.position,
                velocity: self.velocity,
                acceleration,
            });
            self.end += duration;
        }
        self.position = position;
        self.velocity = velocity;
    }

    /// At most four fit: catch, ramp, cruise, brake.
    fn push(&mut self, phase: Phase) {
        if let Some(free) = self.phases.iter_mut().find(|phase| phase.from.is_infinite()) {
            *free = phase;
        }
    }
}

/// -1, 0 or 1.
pub(super) fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use proptest::prelude::*;

    use super::*;

    const MILLISECOND: Duration = Duration::from_millis(1);

    fn dynamics(rpm: i32, up: u16, down: u16) -> Dynamics {
        Dynamics { speed: velocity(rpm), acceleration: acceleration(up), deceleration: acceleration(down) }
    }

    /// Time of a travel from rest to rest, by the textbook.
    fn closed_formula(distance: f64, Dynamics { speed, acceleration: a, deceleration: d }: Dynamics) -> f64 {
        let ramps = speed * speed / (2.0 * a) + speed * speed / (2.0 * d);
        if distance >= ramps {
            speed / a + speed / d + (distance - ramps) / speed
        } else {
            let peak = (2.0 * distance * a * d / (a + d)).sqrt();
            peak / a + peak / d
        }
    }

    /// Steps until standstill; checks that the target is never passed.
    fn cycles_to(target: f64, motion: &mut Motion, dt: Duration) -> f64 {
        let direction = sign(target - motion.position());
        let mut cycles = 0.0;
        while !motion.at_rest() {
            let before = motion.position();
            motion.advance(Lapse::of(dt));
            cycles += 1.0;
            assert!((motion.position() - before) * direction >= -ROUNDING, "moved backwards");
            assert!((target - motion.position()) * direction >= 0.0, "overshot {target}");
        }
        cycles
    }

    #[test]
    fn ramps_take_the_time_and_way_of_the_reference() {
        for (speed, percent, time, way) in
            [(30, 50, 0.25, 100.0), (100, 100, 0.4167, 555.6), (200, 100, 0.8333, 2222.2)]
        {
            let mut motion = Motion::at(0.0);
            motion.ramp_to(velocity(speed), acceleration(percent));
            motion.advance(Lapse::of(Duration::from_secs_f64(time - 0.001)));
            assert!(motion.velocity() < velocity(speed));
            motion.advance(Lapse::of(MILLISECOND));
            assert!((motion.velocity() - velocity(speed)).abs() < 1.0);
            assert!((motion.position() - way).abs() < 0.3, "{} for {way}", motion.position());
            motion.brake(acceleration(percent));
            while !motion.at_rest() {
                motion.advance(Lapse::of(MILLISECOND));
            }
            assert!((motion.position() - 2.0 * way).abs() < 0.6);
        }
    }

    #[test]
    fn travels_at_the_defaults_take_the_time_of_the_closed_formula() {
        for (target, seconds) in [(1600.0, 2.25), (16000.0, 20.25), (-48000.0, 60.25)] {
            assert!((closed_formula(f64::abs(target), dynamics(30, 50, 50)) - seconds).abs() < 1e-9);
            let mut motion = Motion::at(0.0);
            motion.travel_to(target, dynamics(30, 50, 50));
            let cycles = cycles_to(target, &mut motion, MILLISECOND);
            assert!((cycles / 1000.0 - seconds).abs() <= 0.001, "{cycles} cycles for {seconds} s");
            assert_eq!(motion.position(), target);
        }
    }

    #[test]
    fn the_length_of_the_step_does_not_change_the_travel() {
        for dt in [Duration::from_micros(100), Duration::from_micros(3700), Duration::from_millis(100)] {
            let mut motion = Motion::at(0.0);
            motion.travel_to(-1600.0, dynamics(30, 50, 50));
            let seconds = cycles_to(-1600.0, &mut motion, dt) * dt.as_secs_f64();
            assert!((0.0..=dt.as_secs_f64() * 1.001).contains(&(seconds - 2.25 + 1e-9)), "{seconds}");
        }
    }

    #[test]
    fn a_caught_shaft_that_cannot_stop_in_time_comes_back() {
        let mut motion = Motion::at(0.0);
        motion.ramp_to(velocity(30), acceleration(100));
        motion.advance(Lapse::of(Duration::from_secs(1)));
        let target = motion.position() + 1.0;
        motion.travel_to(target, dynamics(30, 50, 50));
        motion.advance(Lapse::of(Duration::from_millis(250)));
        assert!(motion.position() > target);
        motion.advance(Lapse::of(Duration::from_secs(10)));
        assert!(motion.at_rest());
        assert_eq!(motion.position(), target);
    }

    #[test]
    fn time_left_over_at_the_end_of_a_plan_is_handed_on() {
        let mut motion = Motion::at(0.0);
        motion.travel_to(1600.0, dynamics(30, 50, 50));
        assert_eq!(motion.advance(Lapse::of(Duration::from_secs(2))), None);
        let left =
            motion.advance(Lapse::of(Duration::from_secs(1))).expect("the travel ends within this second");
        assert!((left - 0.75).abs() < 1e-9);
        motion.travel_to(0.0, dynamics(30, 50, 50));
        assert_eq!(motion.skip(left), None);
        assert!((motion.position() - (1600.0 - 100.0 - 0.5 * 800.0)).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn every_travel_takes_the_time_of_the_closed_formula_and_ends_at_its_target(
            start in -1e6..1e6f64, distance in -20_000.0..20_000.0f64,
            rpm in 10..=200i32, up in 1..=100u16, down in 1..=100u16, millis in 1..=100u64,
        ) {
            let dynamics = dynamics(rpm, up, down);
            let dt = Duration::from_millis(millis);
            let mut motion = Motion::at(start);
            motion.travel_to(start + distance, dynamics);
            let seconds = cycles_to(start + distance, &mut motion, dt) * dt.as_secs_f64();
            let expected = closed_formula(distance.abs(), dynamics);
            prop_assert!(seconds >= expected - 1e-6 && seconds <= expected + dt.as_secs_f64() + 1e-6);
            prop_assert_eq!(motion.position(), start + distance);
        }

        #[test]
        fn a_travel_paused_and_resumed_anywhere_ends_at_its_target_without_overshoot(
            distance in -5000.0..5000.0f64, rpm in 1..=200i32, up in 1..=100u16, down in 1..=100u16,
            pauses in proptest::collection::vec((0..2000u64, 0..2000u64), 1..6),
        ) {
            let dynamics = dynamics(rpm, up, down);
            let mut motion = Motion::at(0.0);
            motion.travel_to(distance, dynamics);
            for (travelling, braking) in pauses {
                motion.advance(Lapse::of(Duration::from_millis(travelling)));
                motion.brake(dynamics.deceleration);
                motion.advance(Lapse::of(Duration::from_millis(braking)));
                prop_assert!((distance - motion.position()) * sign(distance) >= -ROUNDING);
                motion.travel_to(distance, dynamics);
            }
            if (distance - motion.position()).abs() > ROUNDING {
                cycles_to(distance, &mut motion, Duration::from_millis(10));
            }
            motion.advance(Lapse::of(Duration::from_secs(10_000)));
            prop_assert_eq!(motion.position(), distance);
        }
    }
}
