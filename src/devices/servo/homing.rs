//! Homing: every method of 6098h as data, and one sequence for all.
//!
//! ```text
//!  seek (fast) ──▶ leave or step back ──▶ cross the edge (slow) ──▶ [index (slow)] ──▶ back to it
//!    │ limit: reverse once, or fail
//! ```

use super::inputs::{Closed, HomeSwitch};
use super::plant::{INCREMENTS_PER_REVOLUTION, approach, sign};
use super::profile::{Demand, Ramp};

/// A switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Switch {
    NegativeLimit,
    PositiveLimit,
    Home,
}

/// How the switch changes where the home position is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Edge {
    /// It opens.
    Leaving,
    /// It closes.
    Entering,
}

/// Where homing stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HomingState {
    /// Not started since the mode was entered.
    Ready,
    Running(Homing),
    Attained,
    Failed,
}

/// A method of 6098h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Method {
    /// `None`: only the index counts.
    switch: Option<(Switch, Edge)>,
    /// The first way, while the switch is open: -1 or 1.
    seek: f64,
    /// The way over the edge and to the index: -1 or 1.
    cross: f64,
    /// The index pulse behind the edge is home, not the edge.
    index: bool,
    /// A limit switch on the way makes the drive turn round.
    reverses: bool,
    home_switch: HomeSwitch,
}

const NEGATIVE: f64 = -1.0;
const POSITIVE: f64 = 1.0;

impl Method {
    /// The method of a number; `None` for 0, for numbers that are reserved and for 35, which moves nothing.
    pub(crate) const fn of(number: i64) -> Option<Self> {
        use Edge::{Entering, Leaving};
        use Switch::{Home, NegativeLimit, PositiveLimit};
        let (number, index) = match number {
            1..=14 => (number, true),
            17..=30 => (number - 16, false),
            33 => return Some(Self::to_index(NEGATIVE)),
            34 => return Some(Self::to_index(POSITIVE)),
            ..=0 | 15 | 16 | 31 | 32 | 35.. => return None,
        };
        let (switch, edge, seek, cross) = match number {
            1 => (NegativeLimit, Leaving, NEGATIVE, POSITIVE),
            2 => (PositiveLimit, Leaving, POSITIVE, NEGATIVE),
            3 => (Home, Leaving, POSITIVE, NEGATIVE),
            4 => (Home, Entering, POSITIVE, POSITIVE),
            5 => (Home, Leaving, NEGATIVE, POSITIVE),
            6 => (Home, Entering, NEGATIVE, NEGATIVE),
            7 => (Home, Leaving, POSITIVE, NEGATIVE),
            8 => (Home, Entering, POSITIVE, POSITIVE),
            9 => (Home, Entering, POSITIVE, NEGATIVE),
            10 => (Home, Leaving, POSITIVE, POSITIVE),
            11 => (Home, Leaving, NEGATIVE, POSITIVE),
            12 => (Home, Entering, NEGATIVE, NEGATIVE),
            13 => (Home, Entering, NEGATIVE, POSITIVE),
            14 => (Home, Leaving, NEGATIVE, NEGATIVE),
            ..=0 | 15.. => return None,
        };
        let home_switch = match number {
            3 | 4 => HomeSwitch::PositiveSide,
            5 | 6 => HomeSwitch::NegativeSide,
            ..=2 | 7.. => HomeSwitch::Cam,
        };
        let reverses = number >= 7;
        Some(Self { switch: Some((switch, edge)), seek, cross, index, reverses, home_switch })
    }

    const fn to_index(cross: f64) -> Self {
        Self { switch: None, seek: cross, cross, index: true, reverses: false, home_switch: HomeSwitch::Cam }
    }

    /// What the home switch is on an axis made for this method.
    pub(crate) const fn home_switch(&self) -> HomeSwitch {
        self.home_switch
    }
}

/// Speeds and ramp; increments/s, increments/s^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Speeds {
    pub(crate) switch: f64,
    pub(crate) zero: f64,
    pub(crate) ramp: f64,
}

/// A homing that runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Homing {
    method: Method,
    speeds: Speeds,
    phase: Phase,
    turned: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Until the switch closes.
    Seek { direction: f64 },
    /// Until it opens again, to cross the edge slowly. `ready`: it was closed on this way, not only before braking.
    StepBack { ready: bool },
    /// Until it changes as the method wants it. `ready`: it was the other way round on this way.
    Cross { ready: bool },
    /// Until the index pulse after the position `last`.
    Index { last: f64 },
    /// Back to where home was seen.
    Return { home: f64 },
}

/// How far a homing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Progress {
    Running,
    /// The shaft stands at home, increments.
    Done(f64),
    /// A switch is not where it should be.
    Failed,
}

impl Homing {
    /// Begins where the switches say `closed`.
    pub(crate) fn begin(method: Method, speeds: Speeds, position: f64, closed: Closed) -> Self {
        let phase = match method.switch {
            None => Phase::Index { last: position },
            Some((switch, edge)) => Self::after_switch(method, edge, is_closed(switch, closed)),
        };
        Self { method, speeds, phase, turned: false }
    }

    const fn after_switch(method: Method, edge: Edge, closed: bool) -> Phase {
        match (closed, edge) {
            (false, Edge::Leaving | Edge::Entering) => Phase::Seek { direction: method.seek },
            (true, Edge::Leaving) => Phase::Cross { ready: false },
            (true, Edge::Entering) => Phase::StepBack { ready: false },
        }
    }

    /// One step. `position` is where the shaft is.
    pub(crate) fn step(&mut self, demand: &mut Demand, position: f64, closed: Closed, time: f64) -> Progress {
        let method = self.method;
        let at_switch = method.switch.map(|(switch, edge)| (switch, edge, is_closed(switch, closed)));
        let velocity = match (self.phase, at_switch) {
            (Phase::Seek { direction }, Some((switch, _, false))) => {
                match self.seek_at_limit(switch, direction, closed) {
                    Some(direction) => {
                        self.phase = Phase::Seek { direction };
                        direction * self.speeds.switch
                    }
                    None => return Progress::Failed,
                }
            }
            (Phase::Seek { .. }, Some((_, edge, true))) => {
                self.phase = Self::after_switch(method, edge, true);
                0.0
            }
            (Phase::StepBack { ready }, Some((_, _, is_closed))) => {
                let on_its_way = sign(demand.velocity) == -method.cross;
                self.phase = match (is_closed, ready) {
                    (true, ready) => Phase::StepBack { ready: ready || on_its_way },
                    (false, true) => Phase::Cross { ready: false },
                    (false, false) => Phase::StepBack { ready },
                };
                -method.cross * self.speeds.switch
            }
            (Phase::Cross { ready }, Some((_, edge, is_closed))) => {
                let on_its_way = sign(demand.velocity) == method.cross;
                let is_beyond = is_closed == (edge == Edge::Entering);
                self.phase = match (is_beyond, ready) {
                    (false, ready) => Phase::Cross { ready: ready || on_its_way },
                    (true, false) => Phase::Cross { ready },
                    (true, true) if method.index => Phase::Index { last: position },
                    (true, true) => Phase::Return { home: position },
                };
                method.cross * self.speeds.zero
            }
            (Phase::Index { last }, _) => {
                self.phase = match index_between(last, position, method.cross) {
                    Some(home) => Phase::Return { home },
                    None => Phase::Index { last: position },
                };
                method.cross * self.speeds.zero
            }
            (Phase::Return { home }, _) => return self.step_back_home(home, demand, time),
            // Without a switch there is only the index.
            (Phase::Seek { .. } | Phase::StepBack { .. } | Phase::Cross { .. }, None) => {
                return Progress::Failed;
            }
        };
        demand.velocity = approach(demand.velocity, velocity, self.speeds.ramp * time);
        demand.position += demand.velocity * time;
        Progress::Running
    }

    /// The direction to go on with; `None` where the switch cannot be found.
    fn seek_at_limit(&mut self, switch: Switch, direction: f64, closed: Closed) -> Option<f64> {
        let ahead = if direction > 0.0 { Switch::PositiveLimit } else { Switch::NegativeLimit };
        if ahead == switch || !is_closed(ahead, closed) {
            return Some(direction);
        }
        if self.turned || !self.method.reverses {
            return None;
        }
        self.turned = true;
        Some(-direction)
    }

    fn step_back_home(&self, home: f64, demand: &mut Demand, time: f64) -> Progress {
        let ramp = Ramp {
            velocity: self.speeds.zero,
            acceleration: self.speeds.ramp,
            deceleration: self.speeds.ramp,
        };
        if demand.step_to(home, ramp, time) { Progress::Done(home) } else { Progress::Running }
    }
}

const fn is_closed(switch: Switch, closed: Closed) -> bool {
    match switch {
        Switch::NegativeLimit => closed.negative_limit,
        Switch::PositiveLimit => closed.positive_limit,
        Switch::Home => closed.home,
    }
}

/// The index pulse that the shaft passed on the way in `direction`.
fn index_between(from: f64, to: f64, direction: f64) -> Option<f64> {
    if sign(to - from) != direction {
        return None;
    }
    let turns = |position: f64| libm::floor(position / INCREMENTS_PER_REVOLUTION);
    if direction > 0.0 {
        (turns(to) > turns(from)).then(|| turns(to) * INCREMENTS_PER_REVOLUTION)
    } else {
        let (from, to) = (-from, -to);
        (turns(to) > turns(from)).then(|| -turns(to) * INCREMENTS_PER_REVOLUTION)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::servo::inputs::Axis;

    const REV: f64 = INCREMENTS_PER_REVOLUTION;

    /// Where a homing ends in revolutions.
    fn home(number: i64, begin: f64, axis: Axis) -> Option<f64> {
        let method = Method::of(number).expect("a method");
        let speeds = Speeds { switch: 2.0 * REV, zero: 0.2 * REV, ramp: 40.0 * REV };
        let mut demand = Demand { position: begin * REV, velocity: 0.0 };
        let mut homing = Homing::begin(method, speeds, demand.position, axis.closed(demand.position));
        for _ in 0..100_000 {
            let position = demand.position;
            match homing.step(&mut demand, position, axis.closed(position), 0.001) {
                Progress::Running => {}
                Progress::Done(home) => {
                    assert_eq!(demand, Demand { position: home, velocity: 0.0 });
                    return Some(home / REV);
                }
                Progress::Failed => return None,
            }
        }
        panic!("method {number} from {begin} does not end");
    }

    /// Limits at -5.3 and 5.3, home switch from 1.4 to 2.6 revolutions.
    const CAM: Axis =
        Axis { negative_limit: -5.3 * REV, positive_limit: 5.3 * REV, home: (1.4 * REV, 2.6 * REV) };

    /// Method, home from the left, from inside, from the right of the switch; in revolutions.
    const CAM_ROWS: [(i64, f64); 12] = [
        (1, -5.0),
        (2, 5.0),
        (7, 1.0),
        (8, 2.0),
        (9, 2.0),
        (10, 3.0),
        (11, 3.0),
        (12, 2.0),
        (13, 2.0),
        (14, 1.0),
        (17, -5.3),
        (18, 5.3),
    ];

    #[test]
    fn methods_with_a_cam_find_the_same_home_from_everywhere() {
        for (number, expected) in CAM_ROWS {
            for begin in [-5.5, -1.0, 2.1, 4.0, 5.5] {
                let found = home(number, begin, CAM).expect("home");
                assert!((found - expected).abs() < 0.001, "method {number} from {begin}: {found}");
            }
        }
        for (number, edge) in
            [(23, 1.4), (24, 1.4), (25, 2.6), (26, 2.6), (27, 2.6), (28, 2.6), (29, 1.4), (30, 1.4)]
        {
            for begin in [-1.0, 2.1, 4.0] {
                let found = home(number, begin, CAM).expect("home");
                assert!((found - edge).abs() < 0.001, "method {number} from {begin}: {found}");
            }
        }
    }

    #[test]
    fn methods_with_a_home_switch_on_one_side() {
        let positive = Axis { home: (1.4 * REV, f64::INFINITY), ..CAM };
        let negative = Axis { home: (f64::NEG_INFINITY, 1.4 * REV), ..CAM };
        let rows = [(3, positive, 1.0), (4, positive, 2.0), (5, negative, 2.0), (6, negative, 1.0)];
        for (number, axis, expected) in rows {
            for begin in [0.3, 2.1] {
                let found = home(number, begin, axis).expect("home");
                assert!((found - expected).abs() < 0.001, "method {number} from {begin}: {found}");
                let edge = home(number + 16, begin, axis).expect("home");
                assert!((edge - 1.4).abs() < 0.001, "method {} from {begin}: {edge}", number + 16);
            }
        }
    }

    #[test]
    fn the_next_index_on_either_side() {
        assert_eq!(home(33, 0.5, CAM), Some(0.0));
        assert_eq!(home(34, 0.5, CAM), Some(1.0));
    }

    #[test]
    fn without_the_switch_the_homing_fails() {
        let none = Axis { home: (f64::INFINITY, f64::INFINITY), ..CAM };
        for number in [3, 4, 5, 6, 7, 10, 11, 14, 19, 23] {
            assert_eq!(home(number, 0.0, none), None, "method {number}");
        }
    }

    #[test]
    fn numbers_that_are_no_method() {
        let known = |number: &i64| Method::of(*number).is_some();
        let numbers: std::vec::Vec<_> = (-128..128).filter(known).collect();
        let expected: std::vec::Vec<_> = (1..=14).chain(17..=30).chain(33..=34).collect();
        assert_eq!(numbers, expected);
    }
}
