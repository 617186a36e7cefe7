//! Interpolated position mode: the way from one position to the next, from SYNC to SYNC.
//!
//! ```text
//!  SYNC i-1       SYNC i        SYNC i+1
//!    | X(i-2)..X(i-1) | X(i-1)..X(i) |        no buffer: one cycle behind the host
//! ```
//!
//! A late SYNC is bridged with the last acceleration; after two cycles without one the command ends.

use core::time::Duration;

use super::profile::Demand;
use crate::time::Instant;

/// Where the interpolation stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Interpolation {
    /// No SYNC yet since the mode was entered.
    Waiting,
    /// SYNCs come.
    Running(Segment),
}

/// The way of one cycle. Increments, increments/s, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    begin: Instant,
    cycle: Duration,
    from: f64,
    to: f64,
    /// Velocities at both ends; `None` for a straight line.
    slopes: Option<(f64, f64)>,
    /// The change of velocity since the cycle before.
    acceleration: f64,
}

/// A position of the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) position: f64,
    /// Velocity there, increments/s, where the host gives it.
    pub(super) slope: Option<f64>,
}

impl Interpolation {
    /// A SYNC came with the next point.
    pub(super) fn sync(&mut self, now: Instant, cycle: Duration, demand: Demand, point: Point) {
        let (from, slope, velocity) = match *self {
            Self::Waiting => (demand.position, 0.0, 0.0),
            Self::Running(last) => (last.to, last.slopes.map_or(0.0, |slopes| slopes.1), last.velocity()),
        };
        let mut segment = Segment {
            begin: now,
            cycle,
            from,
            to: point.position,
            slopes: point.slope.map(|next| (slope, next)),
            acceleration: 0.0,
        };
        segment.acceleration = (segment.velocity() - velocity) / cycle.as_secs_f64();
        *self = Self::Running(segment);
    }

    /// The demand at `now`; `None` while the host has given nothing.
    pub(super) fn demand(&self, now: Instant) -> Option<Demand> {
        match self {
            Self::Waiting => None,
            Self::Running(segment) => Some(segment.demand(now)),
        }
    }

    /// When the SYNC is so late that the drive stops.
    pub(super) fn fails_at(&self) -> Option<Instant> {
        match self {
            Self::Waiting => None,
            Self::Running(segment) => Some(segment.begin.saturating_add(segment.cycle * 2)),
        }
    }

    /// When the next SYNC is expected.
    pub(super) fn expected_at(&self) -> Option<Instant> {
        match self {
            Self::Waiting => None,
            Self::Running(segment) => Some(segment.begin.saturating_add(segment.cycle)),
        }
    }
}

impl Segment {
    fn velocity(&self) -> f64 {
        (self.to - self.from) / self.cycle.as_secs_f64()
    }

    fn demand(&self, now: Instant) -> Demand {
        let time = now.saturating_since(self.begin).as_secs_f64();
        let cycle = self.cycle.as_secs_f64();
        if time > cycle {
            let late = time - cycle;
            let begin = self.slopes.map_or(self.velocity(), |slopes| slopes.1);
            let velocity = begin + self.acceleration * late;
            return Demand { position: self.to + (begin + velocity) * 0.5 * late, velocity };
        }
        let part = time / cycle;
        match self.slopes {
            None => Demand { position: self.from + (self.to - self.from) * part, velocity: self.velocity() },
            Some((first, last)) => self.cubic(part, first * cycle, last * cycle, cycle),
        }
    }

    /// The cubic through both ends with these slopes per cycle.
    fn cubic(&self, part: f64, first: f64, last: f64, cycle: f64) -> Demand {
        let way = self.to - self.from;
        let (b, c) = (3.0 * way - 2.0 * first - last, first + last - 2.0 * way);
        let position = self.from + part * (first + part * (b + part * c));
        let velocity = (first + part * (2.0 * b + part * 3.0 * c)) / cycle;
        Demand { position, velocity }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Duration = Duration::from_millis(4);

    fn at(millis: u64) -> Instant {
        Instant::from_millis(millis)
    }

    #[test]
    fn positions_are_reached_one_cycle_after_their_sync() {
        let mut way = Interpolation::Waiting;
        assert_eq!(way.demand(at(0)), None);
        way.sync(at(0), CYCLE, Demand::default(), Point { position: 100.0, slope: None });
        assert_eq!(way.demand(at(1)).map(|demand| demand.position), Some(25.0));
        way.sync(at(4), CYCLE, Demand::default(), Point { position: 300.0, slope: None });
        assert_eq!(way.demand(at(4)).map(|demand| demand.position), Some(100.0));
        assert_eq!(way.demand(at(8)).map(|demand| demand.position), Some(300.0));
    }

    #[test]
    fn a_late_sync_is_bridged_with_the_last_acceleration() {
        let mut way = Interpolation::Waiting;
        for (cycle, position) in [(0, 0.0), (1, 4.0), (2, 12.0)] {
            way.sync(at(4 * cycle), CYCLE, Demand::default(), Point { position, slope: None });
        }
        // 1000, then 2000 increments/s: 250000 increments/s^2.
        let late = way.demand(at(16)).map(|demand| demand.position).unwrap_or_default();
        assert!((late - (12.0 + 2000.0 * 0.004 + 0.5 * 250_000.0 * 0.004 * 0.004)).abs() < 1e-9, "{late}");
        assert_eq!(way.fails_at(), Some(at(16)));
    }

    #[test]
    fn with_differences_the_velocity_has_no_steps() {
        let mut way = Interpolation::Waiting;
        let slope = |velocity| Some(velocity);
        way.sync(at(0), CYCLE, Demand::default(), Point { position: 2.0, slope: slope(1000.0) });
        let before = way.demand(at(4));
        way.sync(at(4), CYCLE, Demand::default(), Point { position: 6.0, slope: slope(1000.0) });
        let after = way.demand(at(4));
        for demand in [before, after] {
            let demand = demand.unwrap_or_default();
            assert!((demand.velocity - 1000.0).abs() < 1e-6 && (demand.position - 2.0).abs() < 1e-9);
        }
    }
}
