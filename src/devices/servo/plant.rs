//! The plant: a servo motor with its load, advanced in steps of the position loop.
//!
//! ```text
//! inertia * acceleration = torque of the motor - load - friction against the motion
//! ```
//!
//! The motor gives the torque that brings the shaft to the demand within the step, at most the limit of the drive.
//! What no manual states is in [`Constants`]; motor and amplifier are of the 400 W class.

use super::inputs::Inputs;

/// Increments that positions are counted in, per revolution; the encoder of the ASDA-A2 has as many.
pub const INCREMENTS_PER_REVOLUTION: f64 = 1_280_000.0;

/// The gain of what a velocity loop is behind, 1/s.
pub(crate) const VELOCITY_GAIN: f64 = 200.0;

/// The motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motor;

impl Motor {
    /// Maximum speed in rpm.
    pub(crate) const MAX_RPM: i64 = 5000;
    /// Rated current in mA.
    pub(crate) const RATED_CURRENT: u32 = 2600;
    /// Rated torque in mNm.
    pub(crate) const RATED_TORQUE: u32 = 1270;
}

/// What no manual states about the plant. All above zero; other values count as the smallest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Rated torque in Nm.
    pub rated_torque: f64,
    /// The most torque, in parts of the rated one. Default 3.
    pub peak: f64,
    /// Inertia of motor and load in kg m^2. Default 1e-4.
    pub inertia: f64,
    /// Inertia of the brake: damping of a motor whose windings are shorted, Nm s/rad. Default 0.01.
    pub dynamic_brake: f64,
    /// How long the peak torque may last before AL006, s. Default 8.
    pub overload_time: f64,
}

impl Constants {
    /// The defaults named with each field.
    pub(crate) const DEFAULT: Self =
        Self { rated_torque: 1.27, peak: 3.0, inertia: 1e-4, dynamic_brake: 0.01, overload_time: 8.0 };

    #[expect(clippy::manual_clamp, reason = "what is no number shall be the smallest one")]
    fn positive(self) -> Self {
        let positive = |value: f64| value.max(1e-9).min(1e9);
        Self {
            rated_torque: positive(self.rated_torque),
            peak: positive(self.peak),
            inertia: positive(self.inertia),
            dynamic_brake: positive(self.dynamic_brake),
            overload_time: positive(self.overload_time),
        }
    }
}

impl Default for Constants {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The gains of the position loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gains {
    /// Of the following error, 1/s.
    pub(crate) error: f64,
    /// Of the velocity demanded.
    pub(crate) forward: f64,
}

impl Gains {
    /// Of a loop that follows a velocity.
    pub(crate) const OF_VELOCITY: Self = Self { error: VELOCITY_GAIN, forward: 1.0 };
}

/// What the drive wants of the motor during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drive {
    /// Go this way from this position; increments.
    Position { from: f64, way: f64, gains: Gains },
    /// Give this torque in parts of the rated one, below this speed in increments/s.
    Torque { torque: f64, speed: f64 },
    /// No torque.
    Free,
    /// No torque, windings shorted.
    Brake,
}

/// Motor and load.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plant {
    constants: Constants,
    /// Increments from where the shaft was when the plant was made.
    pub(crate) position: f64,
    /// Increments/s.
    pub(crate) velocity: f64,
    /// Torque of the motor in parts of the rated one.
    pub(crate) torque: f64,
    /// The most torque that the drive gives now, in parts of the rated one; above the peak it is the peak.
    pub(crate) limit: f64,
    /// How much of the overload time is used, 1 is all of it.
    pub(crate) heat: f64,
}

impl Plant {
    pub(crate) fn new(constants: Constants) -> Self {
        Self {
            constants: constants.positive(),
            position: 0.0,
            velocity: 0.0,
            torque: 0.0,
            limit: f64::INFINITY,
            heat: 0.0,
        }
    }

    /// Whether nothing changes by itself.
    pub(crate) fn rests(&self) -> bool {
        self.velocity == 0.0 && self.heat == 0.0
    }

    /// Whether the shaft stands: what moves it less than an increment in a second is held by its friction.
    pub(crate) fn comes_to_rest(&mut self) -> bool {
        let stands = self.velocity.abs() < 1.0;
        if stands {
            self.velocity = 0.0;
        }
        stands
    }

    /// Lets `time` seconds pass.
    pub(crate) fn advance(&mut self, time: f64, drive: Drive, inputs: &Inputs) {
        // Nm per increment/s^2.
        let inertia = self.constants.inertia * core::f64::consts::TAU / INCREMENTS_PER_REVOLUTION;
        let peak = self.constants.peak.min(self.limit.max(0.0)) * self.constants.rated_torque;
        let friction = inputs.friction_torque.max(0.0);
        let before = self.velocity;
        let (motor, damping, top) = match drive {
            Drive::Position { from, way, gains } => {
                let wanted = gains.forward * way / time + gains.error * (from - self.position);
                let hindrance = inputs.load_torque + friction * sign(wanted);
                let needed = inertia * (wanted - before) / time + hindrance;
                (needed.clamp(-peak, peak), 0.0, None)
            }
            Drive::Torque { torque, speed } => {
                ((torque * self.constants.rated_torque).clamp(-peak, peak), 0.0, Some(speed))
            }
            Drive::Free => (0.0, 0.0, None),
            Drive::Brake => {
                (0.0, self.constants.dynamic_brake * core::f64::consts::TAU / INCREMENTS_PER_REVOLUTION, None)
            }
        };
        let free = before + (motor - inputs.load_torque) / inertia * time;
        // Friction stops a shaft, it never turns it.
        let free = toward_zero(free, friction / inertia * time);
        let free = free / (1.0 + damping / inertia * time);
        let free = match top {
            Some(speed) => free.clamp(-speed, speed),
            None => free,
        };
        self.velocity = if inputs.blocked || free.abs() < 1e-6 { 0.0 } else { free };
        self.position += match drive {
            Drive::Position { .. } => self.velocity * time,
            Drive::Torque { .. } | Drive::Free | Drive::Brake => 0.5 * (before + self.velocity) * time,
        };
        // At the limit of the speed the motor gives only what holds it.
        let holds =
            top.is_some_and(|speed| self.velocity.abs() >= speed && sign(self.velocity) == sign(motor));
        let torque = if holds { inputs.load_torque + friction * sign(self.velocity) } else { motor };
        self.torque = torque / self.constants.rated_torque;
        let over = self.torque * self.torque - 1.0;
        let full = self.constants.peak * self.constants.peak - 1.0;
        self.heat = (self.heat + over / full / self.constants.overload_time * time).clamp(0.0, 1.0);
    }
}

/// Increments/s of so many revolutions in a minute.
pub(crate) const fn rpm(speed: f64) -> f64 {
    speed * INCREMENTS_PER_REVOLUTION / 60.0
}

pub(crate) fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// `value` nearer to zero by `step`, at most to zero.
pub(crate) fn toward_zero(value: f64, step: f64) -> f64 {
    approach(value, 0.0, step)
}

/// `value` nearer to `end` by `step`, at most to it.
pub(crate) fn approach(value: f64, end: f64, step: f64) -> f64 {
    if (end - value).abs() <= step { end } else { value + step * sign(end - value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(plant: &mut Plant, seconds: f64, inputs: &Inputs, mut drive: impl FnMut(f64) -> Drive) {
        let mut time = 0.0;
        while time < seconds {
            time += 0.001;
            plant.advance(0.001, drive(time), inputs);
        }
    }

    #[test]
    fn a_shaft_with_enough_torque_is_on_the_demand() {
        let mut plant = Plant::new(Constants::DEFAULT);
        let velocity = 1e6;
        run(&mut plant, 0.5, &Inputs::NOMINAL, |time| Drive::Position {
            from: velocity * (time - 0.001),
            way: velocity * 0.001,
            gains: Gains::OF_VELOCITY,
        });
        assert!((plant.position - 0.5e6).abs() < 1.0, "{}", plant.position);
        assert!(plant.torque.abs() < 0.01);
    }

    #[test]
    fn load_beyond_the_peak_carries_the_shaft_away_and_overheats_the_motor() {
        let mut plant = Plant::new(Constants::DEFAULT);
        let inputs = Inputs { load_torque: 5.0, ..Inputs::NOMINAL };
        run(&mut plant, 9.0, &inputs, |_| Drive::Position { from: 0.0, way: 0.0, gains: Gains::OF_VELOCITY });
        assert!(plant.velocity < 0.0);
        assert_eq!(plant.heat, 1.0);
    }

    #[test]
    fn a_free_shaft_runs_out_by_friction_and_sooner_with_the_brake() {
        let inputs = Inputs { friction_torque: 0.02, ..Inputs::NOMINAL };
        let way = |drive| {
            let mut plant = Plant::new(Constants::DEFAULT);
            plant.velocity = 64e6;
            run(&mut plant, 5.0, &inputs, |_| drive);
            assert_eq!(plant.velocity, 0.0);
            plant.position
        };
        assert!(way(Drive::Brake) < way(Drive::Free));
    }
}
