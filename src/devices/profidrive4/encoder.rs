//! The encoder as a master sees it: G1_STW, G1_ZSW, G1_XIST1, G1_XIST2, without their places in a telegram.
//!
//! 2048 lines per revolution and 4096 revolutions. XIST1 counts 2^11 steps per line, XIST2 2^9.

use crate::devices::servo::plant::INCREMENTS_PER_REVOLUTION;

/// Lines per revolution (PNU 979).
pub(crate) const LINES: u32 = 2048;
/// Revolutions that it tells apart (PNU 979).
pub(crate) const REVOLUTIONS: u32 = 4096;
/// Bits of a line in XIST1 (PNU 979).
pub(crate) const SHIFT_1: u32 = 11;
/// Bits of a line in XIST2 (PNU 979).
pub(crate) const SHIFT_2: u32 = 9;

/// A command that the encoder does not have.
const NOT_SUPPORTED: u32 = 0x0F01;

/// What a master asks of an encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderCommand {
    /// The functions, bit 0 for the first.
    pub functions: u8,
    /// 1: begin, 2: read, 3: end; else nothing.
    pub action: u8,
    /// Measure on the fly instead of looking for the zero mark.
    pub on_the_fly: bool,
    /// The absolute value in XIST2.
    pub absolute: bool,
    /// Do not look at the encoder.
    pub park: bool,
    /// Acknowledge an error.
    pub acknowledge: bool,
}

/// What the encoder says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderStatus {
    /// The functions that run, bit 0 for the first.
    pub running: u8,
    /// The functions whose value is there.
    pub ready: u8,
    /// An error is being acknowledged.
    pub acknowledging: bool,
    /// XIST2 is the absolute value.
    pub absolute: bool,
    /// It is parked.
    pub parked: bool,
    /// XIST2 is the number of an error.
    pub error: bool,
    /// The actual value.
    pub xist1: u32,
    /// The second actual value.
    pub xist2: u32,
}

/// An encoder on the shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoder {
    command: EncoderCommand,
    /// The zero mark is looked for, and where the shaft was.
    search: Option<f64>,
    found: Option<u32>,
    error: Option<u32>,
}

impl Encoder {
    /// A cycle with the shaft at `position` increments.
    pub(crate) fn step(&mut self, command: EncoderCommand, position: f64) {
        let begins = command != self.command;
        self.command = command;
        if command.acknowledge {
            self.error = None;
        }
        if command.park {
            (self.search, self.found, self.error) = (None, None, None);
            return;
        }
        match command.action {
            // The zero mark is the first function.
            1 if begins && (command.on_the_fly || command.functions & !1 != 0) => {
                self.error = Some(NOT_SUPPORTED)
            }
            1 if begins && command.functions == 1 => (self.search, self.found) = (Some(position), None),
            3 => (self.search, self.found) = (None, None),
            _ => {}
        }
        if let Some(last) = self.search {
            let turn = |position: f64| libm::floor(position / INCREMENTS_PER_REVOLUTION);
            let passed = turn(position).max(turn(last));
            if turn(position) != turn(last) {
                self.found = Some(steps(passed * INCREMENTS_PER_REVOLUTION, SHIFT_1));
                self.search = None;
            } else {
                self.search = Some(position);
            }
        }
    }

    /// What it says with the shaft at `position` increments.
    pub fn status(&self, position: f64) -> EncoderStatus {
        let Self { command, search, found, error } = *self;
        if command.park {
            return EncoderStatus { parked: true, ..EncoderStatus::default() };
        }
        let reads = command.action == 2 && command.functions == 1;
        let xist2 = match (error, found) {
            (Some(error), _) => error,
            (None, Some(found)) if reads => found,
            (None, _) if command.absolute => steps(position, SHIFT_2),
            (None, _) => 0,
        };
        EncoderStatus {
            running: u8::from(search.is_some()),
            ready: u8::from(found.is_some()),
            acknowledging: command.acknowledge,
            absolute: command.absolute && error.is_none() && !(reads && found.is_some()),
            parked: false,
            error: error.is_some(),
            xist1: steps(position, SHIFT_1),
            xist2,
        }
    }
}

/// Steps of `1 << shift` per line; of too many the low 32 bits.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the low 32 bits are meant")]
fn steps(position: f64, shift: u32) -> u32 {
    let per_revolution = f64::from(LINES << shift);
    libm::floor(position / INCREMENTS_PER_REVOLUTION * per_revolution) as i64 as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    const REV: f64 = INCREMENTS_PER_REVOLUTION;

    #[test]
    fn both_actual_values_count_in_their_steps_and_wrap() {
        let mut encoder = Encoder::default();
        encoder.step(EncoderCommand { absolute: true, ..EncoderCommand::default() }, 1.5 * REV);
        let status = encoder.status(1.5 * REV);
        assert_eq!((status.xist1, status.xist2, status.absolute), (0x0060_0000, 0x0018_0000, true));
        assert_eq!(encoder.status(-REV / 2.0).xist1, 0xFFE0_0000);
        assert_eq!(encoder.status(f64::from(REVOLUTIONS) * REV).xist2, 0);
        encoder.step(EncoderCommand { park: true, ..EncoderCommand::default() }, REV);
        assert_eq!(encoder.status(REV), EncoderStatus { parked: true, ..EncoderStatus::default() });
    }

    #[test]
    fn the_zero_mark_is_found_where_the_shaft_passes_it_and_read() {
        let command = |action| EncoderCommand { functions: 1, action, ..EncoderCommand::default() };
        for (way, found) in [([0.4, 0.9, 1.2], 0x0040_0000), ([1.4, 1.1, 0.9], 0x0040_0000)] {
            let mut encoder = Encoder::default();
            let [a, b, c] = way.map(|revolutions| revolutions * REV);
            encoder.step(command(1), a);
            encoder.step(command(1), b);
            assert_eq!((encoder.status(b).running, encoder.status(b).ready), (1, 0));
            encoder.step(command(1), c);
            assert_eq!((encoder.status(c).running, encoder.status(c).ready), (0, 1));
            encoder.step(command(2), c);
            assert_eq!(encoder.status(c).xist2, found);
            encoder.step(command(3), c);
            assert_eq!(encoder.status(c).ready, 0);
        }
    }

    #[test]
    fn what_it_does_not_have_is_an_error_until_it_is_acknowledged() {
        let mut encoder = Encoder::default();
        let on_the_fly =
            EncoderCommand { functions: 1, action: 1, on_the_fly: true, ..EncoderCommand::default() };
        encoder.step(on_the_fly, 0.0);
        assert_eq!((encoder.status(0.0).error, encoder.status(0.0).xist2), (true, 0x0F01));
        encoder.step(EncoderCommand { acknowledge: true, ..EncoderCommand::default() }, 0.0);
        assert!(encoder.status(0.0).acknowledging && !encoder.status(0.0).error);
    }
}
