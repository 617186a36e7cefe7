//! The shaft and its encoder: from turns to the position value.
//!
//! ```text
//! position = measured + preset + offset        measured = steps since calibration, scaled, with the sense of rotation
//! ```
//!
//! The battery keeps the count and the zero point. The preset counts from the calibration on (manual 4.5.1); after a
//! restart the stored one counts.

use super::settings::{Setting, Settings};

/// Steps of one revolution that the sensor tells apart (6501h).
pub(crate) const RESOLUTION: u32 = 880;

/// Half of the counting range: 0A000000h steps in all, as 650Ah says.
const HALF_RANGE: i64 = 83_886_080;

const MICRO: i64 = 1_000_000;

/// An angle of the shaft in millionths of a turn, clockwise seen on the display, absolute.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Turns(i64);

impl Turns {
    /// Millionths of a turn.
    pub(crate) const fn from_micros(micros: i64) -> Self {
        Self(micros)
    }

    /// Turns; what is no number is 0, what is too large is the largest angle.
    #[expect(clippy::cast_possible_truncation, reason = "float to integer saturates")]
    pub const fn from_revolutions(revolutions: f64) -> Self {
        Self((revolutions * 1e6 + if revolutions < 0.0 { -0.5 } else { 0.5 }) as i64)
    }

    /// Turns.
    #[expect(clippy::cast_precision_loss, reason = "exact for 9 thousand million turns")]
    pub(crate) const fn revolutions(self) -> f64 {
        self.0 as f64 / 1e6
    }

    /// Millionths of a turn.
    pub(crate) const fn micros(self) -> i64 {
        self.0
    }

    /// Steps of the sensor, to the nearest, in its counting range.
    fn steps(self) -> i64 {
        let (turns, rest) = (self.0.div_euclid(MICRO), self.0.rem_euclid(MICRO));
        let resolution = i64::from(RESOLUTION);
        wrap(turns * resolution + (rest * resolution + MICRO / 2) / MICRO)
    }
}

/// The count overflows as that of the device.
const fn wrap(steps: i64) -> i64 {
    steps.wrapping_add(HALF_RANGE).rem_euclid(2 * HALF_RANGE) - HALF_RANGE
}

/// The battery-buffered counter and what was set on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Encoder {
    shaft: Turns,
    /// Steps at calibration.
    pub(super) zero: i32,
    /// Whether calibration took place.
    pub(super) calibrated: bool,
    /// The calibration value in force.
    preset: i32,
    /// Where the incremental measurement began, while it is on.
    incremental: Option<i64>,
}

impl Encoder {
    pub(super) const fn turn_to(&mut self, shaft: Turns) {
        self.shaft = shaft;
    }

    /// The shaft turned while nothing counted: the position stays.
    #[expect(clippy::cast_possible_truncation, reason = "the counting range has 28 bits")]
    pub(super) fn turn_uncounted(&mut self, shaft: Turns) {
        self.zero = wrap(i64::from(self.zero) + shaft.steps() - self.shaft.steps()) as i32;
        self.shaft = shaft;
    }

    pub(super) const fn shaft(&self) -> Turns {
        self.shaft
    }

    /// The parameters were loaded from the EEPROM; the count stays.
    pub(super) fn restart(&mut self, settings: &Settings) {
        self.preset = settings.value(Setting::Preset);
        self.incremental = None;
    }

    #[expect(clippy::cast_possible_truncation, reason = "the counting range has 28 bits")]
    pub(super) fn calibrate(&mut self, settings: &Settings) {
        self.zero = self.shaft.steps() as i32;
        self.calibrated = true;
        self.preset = settings.value(Setting::Preset);
    }

    /// Switches the incremental measurement on, from 0, or off.
    pub(super) fn toggle_incremental(&mut self) {
        self.incremental = match self.incremental {
            Some(_) => None,
            None => Some(self.shaft.steps()),
        };
    }

    pub(super) const fn is_incremental(&self) -> bool {
        self.incremental.is_some()
    }

    /// The position in display steps, before the divisor.
    pub(super) fn position(&self, settings: &Settings) -> i64 {
        match self.incremental {
            Some(begin) => scaled(self.shaft.steps() - begin, settings),
            None => {
                let measured = scaled(self.shaft.steps() - i64::from(self.zero), settings);
                measured + i64::from(self.preset) + i64::from(settings.value(Setting::ApplicationOffset))
            }
        }
    }
}

/// Steps of the sensor as display steps, to the nearest, with the sense of rotation.
fn scaled(steps: i64, settings: &Settings) -> i64 {
    let display = wrap(steps) * i64::from(settings.value(Setting::StepsPerRevolution));
    let resolution = i64::from(RESOLUTION);
    let display = (display + resolution / 2).div_euclid(resolution);
    if settings.rises_clockwise() { display } else { -display }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(encoder: &mut Encoder, revolutions: f64, settings: &Settings) -> i64 {
        encoder.turn_to(Turns::from_revolutions(revolutions));
        encoder.position(settings)
    }

    #[test]
    fn one_turn_is_880_steps_or_as_many_as_are_set_and_the_sense_turns_them() {
        let mut settings = Settings::default();
        let mut encoder = Encoder::default();
        assert_eq!(at(&mut encoder, 1.0, &settings), 880);
        assert_eq!(at(&mut encoder, 100.0 / 880.0, &settings), 100);
        assert_eq!(at(&mut encoder, -0.5, &settings), -440);
        settings.set(Setting::StepsPerRevolution, 720);
        assert_eq!(at(&mut encoder, 2.5, &settings), 1800);
        settings.set(Setting::OperatingParameters, 5);
        assert_eq!(at(&mut encoder, 2.5, &settings), -1800);
    }

    #[test]
    fn the_count_has_190650_turns_and_overflows() {
        let settings = Settings::default();
        let mut encoder = Encoder::default();
        assert_eq!(at(&mut encoder, 95_325.0, &settings), 83_886_000);
        assert_eq!(at(&mut encoder, 95_326.0, &settings), -83_885_280);
        for shaft in [f64::NAN, f64::INFINITY, f64::MIN] {
            at(&mut encoder, shaft, &settings);
        }
        encoder.turn_to(Turns::from_micros(i64::MIN));
        encoder.position(&settings);
    }

    #[test]
    fn calibration_adopts_the_preset_and_the_offset_counts_at_once() {
        let mut settings = Settings::default();
        let mut encoder = Encoder::default();
        settings.set(Setting::Preset, 510);
        assert_eq!(at(&mut encoder, 3.0, &settings), 2640, "not before calibration");
        encoder.calibrate(&settings);
        assert_eq!(encoder.position(&settings), 510);
        settings.set(Setting::ApplicationOffset, -10);
        assert_eq!(encoder.position(&settings), 500);
        assert_eq!(at(&mut encoder, 4.0, &settings), 1380);
        encoder.toggle_incremental();
        assert_eq!(encoder.position(&settings), 0);
        assert_eq!(at(&mut encoder, 3.0, &settings), -880);
        encoder.toggle_incremental();
        assert_eq!(encoder.position(&settings), 500);
    }
}
