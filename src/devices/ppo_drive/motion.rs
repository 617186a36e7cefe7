//! Ramp generator and plant, one fixed step at a time.

use super::{Inching, Settings};

/// The torque that the drive can give, in rated torques.
const MOST_TORQUE: f64 = 1.5;
/// Below this part of the reference speed the shaft stands.
const STANDSTILL: f64 = 0.002;

/// What the motor shall do in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Demand {
    /// Nothing: it is not supplied and runs out.
    Released,
    /// Follow the ramp generator towards a speed.
    Ramp(f64),
    /// Hold what the ramp generator gives.
    Hold,
    /// Zero at once: the ramp generator is not enabled.
    Zero,
    /// Turn with an inching speed, on the ramp.
    Inch(Inching),
    /// Brake on the ramp.
    Off1,
    /// Brake with the quick-stop time.
    Off3,
}

/// Speeds and torque of the shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    /// What the ramp generator gives, rpm.
    pub(super) ramp: f64,
    /// How fast the shaft turns, rpm.
    pub(super) speed: f64,
    /// In rated torques.
    pub(super) torque: f64,
    /// The torque is at its limit.
    pub(super) limited: bool,
}

impl Motion {
    pub(super) fn step(&mut self, seconds: f64, demand: Demand, settings: &Settings) {
        let Settings { reference_speed, ramp_up, ramp_down, quick_stop, inching_1, inching_2, .. } =
            *settings;
        let supplied = demand != Demand::Released;
        let ramped = |target: f64, down: f64| {
            let slower = target.abs() < self.ramp.abs() || target * self.ramp < 0.0;
            let time = if slower { down } else { ramp_up };
            let most = reference_speed / time * seconds;
            // The time may be 0: then the step is without limit.
            if time <= 0.0 { target } else { self.ramp + (target - self.ramp).clamp(-most, most) }
        };
        self.ramp = match demand {
            // Caught at the speed it has when it is supplied again.
            Demand::Released => self.speed,
            Demand::Ramp(target) => ramped(target, ramp_down),
            Demand::Hold => self.ramp,
            Demand::Zero => 0.0,
            Demand::Inch(Inching::One) => ramped(settings.limited(inching_1), ramp_down),
            Demand::Inch(Inching::Two) => ramped(settings.limited(inching_2), ramp_down),
            Demand::Off1 => ramped(0.0, ramp_down),
            Demand::Off3 => ramped(0.0, quick_stop),
        };
        self.turn(seconds, supplied, settings);
        if !supplied {
            self.ramp = self.speed;
        }
    }

    /// The plant: an inertia, and a load that acts against the motion and holds what stands.
    fn turn(&mut self, seconds: f64, supplied: bool, settings: &Settings) {
        let load = settings.load / 100.0;
        // Torque per acceleration, in rated torques per rpm/s.
        let inertia = settings.run_up / settings.reference_speed;
        let way = if self.speed != 0.0 { self.speed.signum() } else { self.ramp.signum() };
        let wanted = if self.speed == 0.0 && self.ramp == 0.0 {
            0.0
        } else {
            (self.ramp - self.speed) / seconds * inertia + way * load
        };
        self.limited = supplied && wanted.abs() > MOST_TORQUE;
        self.torque = if supplied { wanted.clamp(-MOST_TORQUE, MOST_TORQUE) } else { 0.0 };
        if supplied && !self.limited {
            self.speed = self.ramp;
            return;
        }
        if self.speed == 0.0 && self.torque.abs() <= load {
            return;
        }
        let before = self.speed;
        self.speed += (self.torque - way * load) * seconds / inertia;
        // A load brakes until the shaft stands and never turns it.
        if before * self.speed < 0.0 && self.torque * self.speed <= 0.0 {
            self.speed = 0.0;
        }
    }

    pub(super) fn stands(&self, settings: &Settings) -> bool {
        self.speed.abs() <= STANDSTILL * settings.reference_speed
    }

    /// Nothing moves, and a released motor changes nothing about it.
    pub(super) fn is_still(&self) -> bool {
        self.speed == 0.0 && self.ramp == 0.0 && self.torque == 0.0
    }
}
