//! What a drive is set to.

/// Settings in physical units. A table of parameters fills them ([`Quantity`](super::Quantity)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The speed that a setpoint of 4000h stands for, rpm.
    pub reference_speed: f64,
    /// The highest speed either way, rpm.
    pub max_speed: f64,
    /// From standstill to the reference speed, s.
    pub ramp_up: f64,
    /// From the reference speed to standstill, s.
    pub ramp_down: f64,
    /// From the reference speed to standstill with OFF3, s.
    pub quick_stop: f64,
    /// Inching speed 1, rpm; its sign is the direction.
    pub inching_1: f64,
    /// Inching speed 2, rpm.
    pub inching_2: f64,
    /// From this speed on "speed reached" is shown, rpm.
    pub comparison_speed: f64,
    /// The current at rated torque, A.
    pub rated_current: f64,
    /// The torque that the machine takes, in % of the rated torque. It acts against the motion.
    pub load: f64,
    /// From standstill to the reference speed with the rated torque and no load, s: the inertia.
    pub run_up: f64,
}

impl Settings {
    /// A small motor of 1500 rpm that runs up in 10 s.
    pub const DEFAULT: Self = Self {
        reference_speed: 1500.0,
        max_speed: 3000.0,
        ramp_up: 10.0,
        ramp_down: 10.0,
        quick_stop: 1.0,
        inching_1: 150.0,
        inching_2: -150.0,
        comparison_speed: 1500.0,
        rated_current: 2.0,
        load: 10.0,
        run_up: 0.1,
    };

    /// The speed of a setpoint, rpm.
    pub(super) fn speed_of(&self, setpoint: i16) -> f64 {
        self.limited(f64::from(setpoint) / FULL * self.reference_speed)
    }

    /// A speed as far as the drive goes.
    pub(super) fn limited(&self, speed: f64) -> f64 {
        speed.min(self.max_speed).max(-self.max_speed)
    }

    /// A speed as the actual value shows it: 4000h is the reference speed; saturates.
    pub(super) fn shown(&self, speed: f64) -> i16 {
        let value = libm::round(speed / self.reference_speed * FULL);
        #[expect(clippy::cast_possible_truncation, reason = "`as` saturates, and NaN is 0")]
        let value = value as i16;
        value
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// 4000h, 100 %.
const FULL: f64 = 16384.0;
