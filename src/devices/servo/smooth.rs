//! Ramps without corners: a motion with linear ramps, averaged over the last steps. It ends where the linear one ends.

use super::pace::STEP_SECONDS;
use super::profile::Demand;

/// So many steps are averaged: each ramp is so many ms longer.
const STEPS: usize = 50;

/// The linear motion, and its newest ways.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Smooth {
    /// The motion with linear ramps.
    pub(crate) linear: Demand,
    ways: [f64; STEPS],
    oldest: usize,
}

impl Smooth {
    /// Goes on as `demand` moves.
    pub(crate) fn of(demand: Demand) -> Self {
        let way = demand.velocity * STEP_SECONDS;
        // The average is behind by this much.
        let ahead = way * (STEPS - 1) as f64 / 2.0;
        let linear = Demand { position: demand.position + ahead, ..demand };
        Self { linear, ways: [way; STEPS], oldest: 0 }
    }

    /// The linear motion went on to `linear`: how `demand` goes on.
    pub(crate) fn step(&mut self, demand: Demand, linear: Demand) -> Demand {
        if let Some(way) = self.ways.get_mut(self.oldest) {
            *way = linear.position - self.linear.position;
        }
        self.oldest = (self.oldest + 1) % STEPS;
        self.linear = linear;
        if self.ways.iter().all(|way| *way == 0.0) {
            return linear;
        }
        let way = self.ways.iter().sum::<f64>() / STEPS as f64;
        Demand { position: demand.position + way, velocity: way / STEP_SECONDS }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::servo::profile::{Ramp, acceleration};

    #[test]
    fn it_ends_exactly_where_the_linear_motion_ends_and_has_no_corner() {
        let ramp = Ramp { velocity: 2.0e6, acceleration: acceleration(200), deceleration: acceleration(100) };
        for begin in [Demand::default(), Demand { position: 3.0, velocity: -1.0e6 }] {
            let (mut demand, mut smooth) = (begin, Smooth::of(begin));
            let (mut before, mut steps) = (0.0, 0);
            while demand != (Demand { position: 5.0e5, velocity: 0.0 }) {
                let mut linear = smooth.linear;
                linear.step_to(5.0e5, ramp, STEP_SECONDS);
                let next = smooth.step(demand, linear);
                let faster = (next.velocity - demand.velocity) / STEP_SECONDS;
                let jerk = (faster - before) / STEP_SECONDS;
                let most = 1.01 * ramp.deceleration / (STEPS as f64 * STEP_SECONDS);
                assert!(jerk.abs() <= 2.0 * most, "step {steps}: {jerk} of {most}");
                (before, demand, steps) = (faster, next, steps + 1);
                assert!(steps < 10_000, "{demand:?}");
            }
        }
    }
}
