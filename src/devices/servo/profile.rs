//! Motion with limited velocity and accelerations, step by step.

use super::plant::{VELOCITY_GAIN, approach, rpm, sign};

/// The way that a velocity may lose and still catch up: that of 100 rpm at the gain of the position loop.
const MOST_LOST: f64 = rpm(100.0) / VELOCITY_GAIN;

/// What a motion may do; increments/s, increments/s^2, all above zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ramp {
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) deceleration: f64,
}

/// What the drive demands of the shaft: increments, increments/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Demand {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
}

impl Demand {
    /// One step of `time` seconds towards `target`. Returns whether it is there, at rest.
    pub(crate) fn step_to(&mut self, target: f64, ramp: Ramp, time: f64) -> bool {
        let left = target - self.position;
        let direction = sign(left);
        let (a, d) = (ramp.acceleration * time, ramp.deceleration * time);
        if self.velocity * direction < 0.0 || direction == 0.0 && self.velocity.abs() > d {
            // Away from the target, or through it too fast: brake first.
            self.velocity = approach(self.velocity, 0.0, d);
            self.position += self.velocity * time;
            return false;
        }
        let speed = self.velocity * direction;
        let top = if speed > ramp.velocity {
            (speed - d).max(ramp.velocity)
        } else {
            (speed + a).min(ramp.velocity)
        };
        let speed = top.min(braking_speed(left.abs(), ramp.deceleration, time)).max(speed - d).max(0.0);
        let way = speed * time;
        // The last step is what is left of the way.
        if speed <= d * (1.0 + 1e-9) && (way >= left.abs() || left.abs() < 1e-3) {
            *self = Self { position: target, velocity: 0.0 };
            return true;
        }
        self.velocity = direction * speed;
        self.position += direction * way;
        false
    }

    /// One step towards a velocity.
    pub(crate) fn step_velocity(&mut self, target: f64, acceleration: f64, deceleration: f64, time: f64) {
        let faster = target.abs() > self.velocity.abs() && target * self.velocity >= 0.0;
        let rate = if faster { acceleration } else { deceleration };
        let end = if target * self.velocity < 0.0 { 0.0 } else { target };
        self.velocity = approach(self.velocity, end, rate * time);
        self.position += self.velocity * time;
    }

    /// One step towards a velocity, at most to the limit of the position in its direction. Returns whether that holds it
    /// back.
    pub(crate) fn step_velocity_within(
        &mut self,
        (low, high): (f64, f64),
        target: f64,
        (acceleration, deceleration): (f64, f64),
        time: f64,
    ) -> bool {
        let limit = if target > 0.0 { high } else { low };
        if target == 0.0 || limit.is_infinite() || self.velocity * target < 0.0 {
            self.step_velocity(target, acceleration, deceleration, time);
            return false;
        }
        // Beyond the limit there is no way back to it: the shaft stays.
        if (self.position - limit) * target > 0.0 {
            self.step_velocity(0.0, deceleration, deceleration, time);
            return true;
        }
        self.step_to(limit, Ramp { velocity: target.abs(), acceleration, deceleration }, time)
    }

    /// A velocity is no way to go: what the shaft lost while it could not follow is not caught up.
    pub(crate) fn forget_lost_way(&mut self, shaft: f64) {
        let lost = self.position - shaft;
        self.position = shaft + lost.clamp(-MOST_LOST, MOST_LOST);
    }
}

/// The speed of a step of `time` after which steps, each slower by `deceleration * time`, end after `way`: the root of
/// `v^2 / 2d + v * time / 2 = way`.
fn braking_speed(way: f64, deceleration: f64, time: f64) -> f64 {
    let half = 0.5 * deceleration * time;
    libm::sqrt(half * half + 2.0 * deceleration * way) - half
}

/// Increments/s^2 of a ramp of so many ms from 0 to 3000 rpm; 0 is at once.
pub(crate) fn acceleration(millis: i64) -> f64 {
    let increments_per_second = rpm(3000.0);
    #[expect(clippy::cast_precision_loss, reason = "at most 32 bits")]
    let millis = if millis <= 0 { 1e-6 } else { millis as f64 };
    increments_per_second * 1000.0 / millis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_travel_ends_exactly_at_its_target_within_its_limits() {
        for way in [1.0, -3.0, 1000.0, -1.28e6, 3.3e7, 0.0] {
            for millis in [1, 200, 5000] {
                let accel = acceleration(millis);
                let ramp = Ramp { velocity: 2.0e6, acceleration: accel, deceleration: 0.5 * accel };
                let mut demand = Demand::default();
                let mut steps = 0;
                while !demand.step_to(way, ramp, 0.001) {
                    assert!(demand.velocity.abs() <= ramp.velocity);
                    assert!(demand.position.abs() <= way.abs() + 1e-6, "{way} {millis} {demand:?}");
                    steps += 1;
                    assert!(steps < 100_000, "{way} {millis} {demand:?}");
                }
                assert_eq!(demand, Demand { position: way, velocity: 0.0 });
                let least = way.abs() / ramp.velocity;
                assert!(f64::from(steps) * 0.001 >= least - 0.002);
            }
        }
    }

    #[test]
    fn a_target_behind_is_reached_after_braking() {
        let ramp = Ramp { velocity: 1e6, acceleration: 1e7, deceleration: 1e7 };
        let mut demand = Demand { position: 0.0, velocity: 1e6 };
        let mut steps = 0;
        while !demand.step_to(100.0, ramp, 0.001) {
            steps += 1;
            assert!(steps < 10_000);
        }
        assert_eq!(demand.position, 100.0);
    }
}
