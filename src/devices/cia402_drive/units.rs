//! Units of the user, by the encoder (608Fh), gear (6091h), feed (6092h), factors (6093h, 6096h, 6097h) and polarity (607Eh).
//!
//! ```text
//! position = increments of the plant / position unit,   position unit = revolution * gear / feed
//! ```

use super::settings::{Setting, Settings};
use crate::devices::servo::plant::{INCREMENTS_PER_REVOLUTION, rpm};

/// What the units of the objects are in increments of the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// A position.
    pub(super) position: f64,
    /// A velocity, increments/s.
    pub(super) velocity: f64,
    /// An acceleration, increments/s^2, without sign.
    pub(super) acceleration: f64,
    /// A velocity of vl (604Ch), increments/s.
    pub(super) vl: f64,
    /// An increment of the encoder.
    pub(super) encoder: f64,
}

/// 60A9h: revolutions in a minute, with any power of ten.
const RPM: i64 = 0xB447;

impl Units {
    pub(super) fn of(settings: &Settings) -> Self {
        let ratio = |above: Setting, below: Setting, otherwise: f64| {
            settings.above_zero(above, otherwise) / settings.above_zero(below, 1.0)
        };
        // Files say 1/1 where nobody set it, here and below: one increment in a revolution is no encoder.
        let is_one = |above, below| settings.of(above) > 0 && settings.of(above) == settings.of(below);
        let encoder = if is_one(Setting::EncoderIncrements, Setting::EncoderRevolutions) {
            10_000.0
        } else {
            ratio(Setting::EncoderIncrements, Setting::EncoderRevolutions, 10_000.0)
        };
        let gear = ratio(Setting::GearMotor, Setting::GearShaft, 1.0);
        let feed = match (settings.of(Setting::Feed), settings.of(Setting::FeedRevolutions)) {
            (feed, revolutions) if feed <= 0 || feed == revolutions => encoder,
            (_, _) => ratio(Setting::Feed, Setting::FeedRevolutions, 1.0),
        };
        let (above, below) = (Setting::PositionNumerator, Setting::PositionDivisor);
        let position = if settings.of(above) > 0 && !is_one(above, below) {
            INCREMENTS_PER_REVOLUTION / encoder * ratio(above, below, 1.0)
        } else {
            INCREMENTS_PER_REVOLUTION * gear / feed
        };
        let unit = settings.of(Setting::VelocityUnit);
        let velocity = if unit >> 8 & 0xFFFF == RPM {
            let [_, _, _, power, ..] = unit.to_le_bytes();
            rpm(libm::pow(10.0, f64::from(power.cast_signed())))
        } else {
            position
        };
        let factor = ratio(Setting::VelocityNumerator, Setting::VelocityDivisor, 1.0);
        let acceleration =
            velocity * ratio(Setting::AccelerationNumerator, Setting::AccelerationDivisor, 1.0);
        let velocity = velocity * factor;
        let sign = |bit: i64| if settings.of(Setting::Polarity) & bit == 0 { 1.0 } else { -1.0 };
        Self {
            position: position * sign(0x80),
            velocity: velocity * sign(0x40),
            acceleration,
            vl: rpm(ratio(Setting::VlNumerator, Setting::VlDenominator, 1.0)),
            encoder: INCREMENTS_PER_REVOLUTION / encoder,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn units(rows: &[(Setting, i64)]) -> [f64; 3] {
        let mut settings = Settings::new();
        rows.iter().for_each(|(setting, value)| settings.set(*setting, *value));
        let units = Units::of(&settings);
        [INCREMENTS_PER_REVOLUTION / units.position, units.velocity / rpm(1.0), units.acceleration / rpm(1.0)]
    }

    #[test]
    fn a_revolution_of_the_motor_in_units_of_the_user() {
        use Setting::*;
        assert_eq!(units(&[])[0], 10_000.0);
        assert_eq!(units(&[(EncoderIncrements, 4096)])[0], 4096.0);
        assert_eq!(units(&[(GearMotor, 10)])[0], 1000.0);
        // 5 mm of feed in micrometres behind a gear of 2.
        assert_eq!(units(&[(Feed, 5000), (GearMotor, 4), (GearShaft, 2)])[0], 2500.0);
        assert_eq!(units(&[(Feed, 1), (FeedRevolutions, 1), (EncoderIncrements, 2000)])[0], 2000.0);
        assert_eq!(units(&[(Polarity, 0x80)])[0], -10_000.0);
        // Nobody has an encoder with one increment.
        assert_eq!(units(&[(EncoderIncrements, 1), (EncoderRevolutions, 1)])[0], 10_000.0);
        assert_eq!(units(&[(PositionNumerator, 5), (PositionDivisor, 2)])[0], 4000.0);
        assert_eq!(units(&[(PositionNumerator, 1), (GearMotor, 10)])[0], 1000.0);
        // What is blank in a file divides nothing.
        assert_eq!(units(&[(EncoderRevolutions, 0), (GearMotor, 0), (FeedRevolutions, 0)])[0], 10_000.0);
    }

    #[test]
    fn velocities_are_positions_in_a_second_or_rpm() {
        use Setting::*;
        assert_eq!(units(&[])[1..], [0.006, 0.006]);
        assert_eq!(units(&[(VelocityUnit, 0x00B4_4700)])[1..], [1.0, 1.0]);
        assert_eq!(units(&[(VelocityUnit, 0xFDB4_4700), (Polarity, 0x40)])[1..], [-0.001, 0.001]);
        let factors = [(VelocityNumerator, 4), (VelocityDivisor, 2), (AccelerationNumerator, 4)];
        assert_eq!(units(&factors)[1..], [0.012, 0.024]);
    }
}
