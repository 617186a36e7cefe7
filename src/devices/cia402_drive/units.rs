//! Units of the user, by the encoder (608Fh), gear (6091h), feed (6092h) and polarity (607Eh).
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
        let encoder = ratio(Setting::EncoderIncrements, Setting::EncoderRevolutions, 10_000.0);
        let gear = ratio(Setting::GearMotor, Setting::GearShaft, 1.0);
        // Files say 1/1 where nobody set it: one unit in a revolution is nobody's unit.
        let feed = match (settings.of(Setting::Feed), settings.of(Setting::FeedRevolutions)) {
            (feed, revolutions) if feed <= 0 || feed == revolutions => encoder,
            (_, _) => ratio(Setting::Feed, Setting::FeedRevolutions, 1.0),
        };
        let position = INCREMENTS_PER_REVOLUTION * gear / feed;
        let unit = settings.of(Setting::VelocityUnit);
        let velocity = if unit >> 8 & 0xFFFF == RPM {
            let [_, _, _, power, ..] = unit.to_le_bytes();
            rpm(libm::pow(10.0, f64::from(power.cast_signed())))
        } else {
            position
        };
        let sign = |bit: i64| if settings.of(Setting::Polarity) & bit == 0 { 1.0 } else { -1.0 };
        Self {
            position: position * sign(0x80),
            velocity: velocity * sign(0x40),
            acceleration: velocity,
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
        // What is blank in a file divides nothing.
        assert_eq!(units(&[(EncoderRevolutions, 0), (GearMotor, 0), (FeedRevolutions, 0)])[0], 10_000.0);
    }

    #[test]
    fn velocities_are_positions_in_a_second_or_rpm() {
        use Setting::*;
        assert_eq!(units(&[])[1..], [0.006, 0.006]);
        assert_eq!(units(&[(VelocityUnit, 0x00B4_4700)])[1..], [1.0, 1.0]);
        assert_eq!(units(&[(VelocityUnit, 0xFDB4_4700), (Polarity, 0x40)])[1..], [-0.001, 0.001]);
    }
}
