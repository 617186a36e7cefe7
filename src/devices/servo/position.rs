//! Profile position mode: set-points, one running and one waiting.

use super::profile::{Demand, Ramp};

/// A target with what belongs to it, taken when the controlword says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SetPoint {
    /// Increments.
    pub(crate) target: f64,
    /// What the target counts from.
    pub(crate) from: From,
    pub(crate) ramp: Ramp,
}

/// What a target counts from; of a relative one 60F2h says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum From {
    /// The zero of the encoder.
    Zero,
    /// The target before.
    Target,
    /// The position that is demanded when it begins.
    Demand,
    /// The position of the shaft when it begins.
    Shaft,
}

impl From {
    /// That of bits 0 and 1 of 60F2h (CiA 402); 3 is reserved.
    pub(crate) const fn of_option(code: i64) -> Self {
        match code & 0b11 {
            1 => Self::Demand,
            2 => Self::Shaft,
            _ => Self::Target,
        }
    }
}

/// Where drive and shaft are when a set-point begins, increments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Here {
    pub(crate) demand: f64,
    pub(crate) shaft: f64,
}

/// The set-points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SetPoints {
    running: Option<SetPoint>,
    waiting: Option<SetPoint>,
    /// Where the last set-point leads.
    target: f64,
    /// Bit 4 of the controlword was taken and is still set.
    taken: bool,
}

impl SetPoints {
    /// Rest at `position`.
    pub(crate) const fn resting(position: f64) -> Self {
        Self { running: None, waiting: None, target: position, taken: false }
    }

    /// Bit 4 rises. Returns whether the set-point was taken: not if one waits already.
    pub(crate) const fn take(&mut self, set_point: SetPoint, at_once: bool, here: Here) -> bool {
        if at_once {
            self.begin(set_point, here);
            self.waiting = None;
        } else if self.running.is_none() {
            self.begin(set_point, here);
        } else if self.waiting.is_none() {
            self.waiting = Some(set_point);
        } else {
            return false;
        }
        self.taken = true;
        true
    }

    /// Bit 4 falls.
    pub(crate) const fn release(&mut self) {
        self.taken = false;
    }

    /// Bit 12: the drive cannot take a set-point now, or its host has not released the last one.
    pub(crate) const fn acknowledges(&self) -> bool {
        self.taken || self.waiting.is_some()
    }

    /// Where the shaft shall be in the end.
    pub(crate) const fn target(&self) -> f64 {
        self.target
    }

    /// No set-point runs.
    pub(crate) const fn is_done(&self) -> bool {
        self.running.is_none()
    }

    /// One step; the shaft keeps between `limits`. Returns the limit that ended it, -1 or 1, else 0.
    pub(crate) fn step(&mut self, demand: &mut Demand, shaft: f64, limits: (f64, f64), time: f64) -> i8 {
        let Some(running) = self.running else { return 0 };
        let target = self.target.clamp(limits.0, limits.1);
        if !demand.step_to(target, running.ramp, time) {
            return 0;
        }
        let beyond = if self.target > limits.1 {
            1
        } else if self.target < limits.0 {
            -1
        } else {
            0
        };
        self.running = None;
        if let Some(next) = self.waiting.take() {
            self.begin(next, Here { demand: demand.position, shaft });
        }
        beyond
    }

    const fn begin(&mut self, set_point: SetPoint, here: Here) {
        self.target = match set_point.from {
            From::Zero => set_point.target,
            From::Target => self.target + set_point.target,
            From::Demand => here.demand + set_point.target,
            From::Shaft => here.shaft + set_point.target,
        };
        self.running = Some(set_point);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    const HERE: Here = Here { demand: 0.0, shaft: 0.0 };

    fn to(target: f64, relative: bool) -> SetPoint {
        let from = if relative { From::Target } else { From::Zero };
        let ramp = Ramp { velocity: 1e5, acceleration: 1e6, deceleration: 1e6 };
        SetPoint { target, from, ramp }
    }

    #[test]
    fn one_runs_one_waits_and_a_third_is_refused_until_there_is_room() {
        let mut points = SetPoints::resting(0.0);
        let mut demand = Demand::default();
        assert!(points.take(to(100.0, false), false, HERE));
        assert!(points.acknowledges());
        points.release();
        assert!(!points.acknowledges());
        assert!(points.take(to(50.0, true), false, HERE));
        points.release();
        assert!(points.acknowledges(), "no room");
        assert!(!points.take(to(7.0, false), false, HERE));
        while points.target() == 100.0 {
            points.step(&mut demand, 0.0, FREE, 0.001);
        }
        assert_eq!((points.target(), demand.position), (150.0, 100.0));
        assert!(!points.acknowledges());
        assert!(points.take(to(-10.0, false), true, HERE), "at once");
        while !points.is_done() {
            points.step(&mut demand, 0.0, FREE, 0.001);
        }
        assert_eq!(demand.position, -10.0);
    }

    #[test]
    fn a_limit_ends_the_travel_on_it() {
        let mut points = SetPoints::resting(0.0);
        let mut demand = Demand::default();
        points.take(to(1e4, false), false, HERE);
        let mut beyond = 0;
        while !points.is_done() {
            beyond = points.step(&mut demand, 0.0, (-1e3, 2e3), 0.001);
        }
        assert_eq!((beyond, demand.position), (1, 2e3));
    }
}
