//! Increments of the shaft and the user's units.
//!
//! Inside the drive a position is the angle of the output shaft in increments (1600 per revolution), positive
//! counter-clockwise seen on the clamping ring. Users see increments or 0.01 mm behind an external gear, counted in
//! the direction the sense of rotation says (`ag03.md` 9, rows "scaling", "gear", "sense of rotation"):
//!
//! ```text
//! user units = (shaft - zero) / 1600 * unit * denominator / numerator      unit = 1600, or the spindle pitch
//! ```

use super::settings::{SenseOfRotation, Settings};
use crate::devices::ag03::param::Parameter;

/// Increments per revolution of the output shaft (manual chapter 2.6).
pub const INCREMENTS_PER_REVOLUTION: f64 = 1600.0;

/// The factor between increments and user units, with the sense of rotation as its sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    units_per_increment: f64,
}

impl Scale {
    /// The scale of spindle pitch, gear and sense of rotation. A gear factor of 0 counts as 1.
    pub(super) fn new(settings: &Settings) -> Self {
        let unit = match settings.word(Parameter::SpindlePitch) {
            0 => 1.0,
            pitch => f64::from(pitch) / INCREMENTS_PER_REVOLUTION,
        };
        let reduction = f64::from(settings.word(Parameter::GearDenominator).max(1))
            / f64::from(settings.word(Parameter::GearNumerator).max(1));
        let magnitude = unit * reduction;
        Self {
            units_per_increment: match settings.sense() {
                SenseOfRotation::I => magnitude,
                SenseOfRotation::E => -magnitude,
            },
        }
    }

    /// A distance of the shaft in user units.
    pub(super) fn units(self, increments: f64) -> f64 {
        increments * self.units_per_increment
    }

    /// A distance in user units as increments of the shaft.
    pub(super) fn increments(self, units: f64) -> f64 {
        units / self.units_per_increment
    }

    /// +1 if the user counts counter-clockwise turns up, -1 if down. Also the sign of a velocity.
    pub(super) fn sign(self) -> f64 {
        if self.units_per_increment < 0.0 { -1.0 } else { 1.0 }
    }
}

/// The nearest whole number, halves away from zero, saturating at the ends of `i32`; 0 for what is no number.
///
/// Several times quicker than `libm::round`, which every step needs for each of its measured values.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "meant: towards zero; it saturates, and NaN gives 0")]
pub(super) fn round(value: f64) -> i32 {
    // With 0.5 itself, the number below 0.5 would become 1 by the rounding of the sum. With the number below 0.5, the sum
    // of 0.5 and it is rounded to 1, as it shall be, and so is that of every half.
    const BELOW_HALF: f64 = 0.5_f64.next_down();
    (value + BELOW_HALF.copysign(value)) as i32
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::settings::defaults;
    use super::*;

    fn position_after(revolutions: f64, settings: &Settings) -> i32 {
        round(Scale::new(settings).units(revolutions * INCREMENTS_PER_REVOLUTION))
    }

    #[test]
    fn one_revolution_is_1600_increments_or_the_spindle_pitch_behind_the_gear() {
        let spindle = defaults().with_spindle_pitch(200);
        let reduced = defaults().with_gear_numerator(5);
        let odd = spindle.with_gear_numerator(378).with_gear_denominator(100);
        let reversed = defaults().with_sense(SenseOfRotation::E);
        assert_eq!(position_after(1.0, &defaults()), 1600);
        assert_eq!(position_after(1.0, &spindle), 200);
        assert_eq!(position_after(5.0, &reduced), 1600);
        assert_eq!(position_after(3.78, &odd), 200);
        assert_eq!(position_after(1.0, &reversed), -1600);
    }

    #[test]
    fn user_units_survive_the_way_to_increments_and_back() {
        for (pitch, numerator, denominator) in [(0, 1, 1), (1, 10_000, 1), (1000, 1, 10_000), (7, 378, 100)] {
            for sense in [SenseOfRotation::I, SenseOfRotation::E] {
                let scale = Scale::new(
                    &defaults()
                        .with_spindle_pitch(pitch)
                        .with_gear_numerator(numerator)
                        .with_gear_denominator(denominator)
                        .with_sense(sense),
                );
                for units in [0, 1, -1, 9_999_999, -9_999_999, i32::MAX, i32::MIN] {
                    assert_eq!(round(scale.units(scale.increments(f64::from(units)))), units);
                }
            }
        }
    }

    #[test]
    fn rounding_goes_away_from_zero_and_saturates() {
        for (value, whole) in [
            (0.5, 1),
            (-0.5, -1),
            (0.499_999_999_999_999_94, 0),
            (2_147_483_646.5, i32::MAX),
            (2_147_483_647.5, i32::MAX),
            (1e30, i32::MAX),
            (-2_147_483_647.5, i32::MIN),
            (-2_147_483_648.5, i32::MIN),
            (f64::NEG_INFINITY, i32::MIN),
            (f64::NAN, 0),
        ] {
            assert_eq!(round(value), whole, "{value}");
        }
    }

    proptest! {
        #[test]
        fn rounding_is_that_of_libm(value in -2e9..2e9f64, whole in -2_000_000_000..2_000_000_000i32) {
            let half = f64::from(whole) + 0.5;
            for value in [value, half, half.next_down(), half.next_up(), value / 1e9] {
                prop_assert_eq!(f64::from(round(value)), libm::round(value));
            }
        }
    }
}
