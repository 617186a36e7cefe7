//! The control words of the manual's flow charts (figures 13 and 14), made of their bits, and the status words that
//! follow.
//!
//! | word | for |
//! | --- | --- |
//! | 000B | enabled; a motion is stopped |
//! | 003B, 007B | ready for a travel job; with start bit 1 |
//! | 005B | intermediate stop of a job that the change to 007B has started |
//! | 010B, 020B, 820B | inching 1, inching 2 positive, inching 2 negative |
//! | 004B | setpoint released (velocity mode) |
//! | 0003, 0083 | disabled, the motor stays in control; acknowledge |
//!
//! Source: `docs/reference/ag03.md` 4 and 7.

use super::bits::StwBit;
use crate::devices::ag03::drive::Mode;
use crate::profibus::ppo::ZswPattern;

/// ON and no OFF2, not enabled: an enabled drive brakes and its motor stays in control.
pub(crate) const DISABLED: u16 = StwBit::On.mask() | StwBit::NoOff2.mask();
/// As [`DISABLED`], with the acknowledge bit.
pub(crate) const ACKNOWLEDGING: u16 = DISABLED | StwBit::Acknowledge.mask();
/// OFF1 alone, which ends turn-on disabled.
pub(crate) const OFF1: u16 = StwBit::NoOff2.mask();
/// Operation enabled. A travel job is stopped with maximum deceleration and discarded.
pub(crate) const ENABLED: u16 = DISABLED | StwBit::EnableOperation.mask();
/// Operation enabled, and each change of the start bit starts a travel job.
pub(crate) const TRAVEL: u16 = ENABLED | StwBit::NoStop.mask() | StwBit::NoIntermediateStop.mask();
/// Intermediate stop of a travel job.
pub(crate) const PAUSED: u16 = ENABLED | StwBit::NoStop.mask();
/// Stop of a travel job, with intermediate stop not given.
pub(crate) const STOPPED: u16 = ENABLED | StwBit::NoIntermediateStop.mask();
/// Inching 1: once by delta inch.
pub(crate) const INCHING_1: u16 = ENABLED | StwBit::Inching1.mask();
/// Inching 2 in positive direction.
pub(crate) const INCHING_2_POSITIVE: u16 = ENABLED | StwBit::Inching2.mask();
/// Inching 2 in negative direction.
pub(crate) const INCHING_2_NEGATIVE: u16 = INCHING_2_POSITIVE | StwBit::Inching2Negative.mask();
/// The setpoint is released (velocity mode).
pub(crate) const VELOCITY: u16 = ENABLED | START;
/// The start bit alone. In positioning mode its changes start a job, so it rests where the last job left it.
pub(crate) const START: u16 = StwBit::Start.mask();

/// The words that enable operation, as the flow charts print them.
pub(crate) const PRINTED: [u16; 7] =
    [ENABLED, TRAVEL, TRAVEL | START, INCHING_1, INCHING_2_POSITIVE, INCHING_2_NEGATIVE, VELOCITY];

/// ZSW ready-to-run: supplied, not enabled, standing still. Both manuals print the patterns character for character the
/// same.
pub(crate) const fn ready_to_run(mode: Mode) -> ZswPattern {
    match mode {
        Mode::Positioning => ZswPattern::printed("0x1x 1x11 x01x 0011"),
        Mode::Velocity => ZswPattern::printed("0011 111x x01x 0011"),
    }
}

/// ZSW operation enabled, standing still.
pub(crate) const fn operation_enabled(mode: Mode) -> ZswPattern {
    match mode {
        Mode::Positioning => ZswPattern::printed("xx1x 1x11 x011 0111"),
        Mode::Velocity => ZswPattern::printed("x011 111x x011 0111"),
    }
}

/// ZSW ready-to-travel. In positioning mode an interrupted travel job looks the same (`ag03.md` C-05).
pub(crate) const fn ready_to_travel(mode: Mode) -> ZswPattern {
    match mode {
        Mode::Positioning => ZswPattern::printed("101x 1x11 x011 0111"),
        Mode::Velocity => ZswPattern::printed("1011 111x x011 0111"),
    }
}

/// ZSW while inching 1 or 2 is active (positioning).
pub(crate) const INCHES: ZswPattern = ZswPattern::printed("0x0x 1x1x x011 0111");
/// ZSW while a travel job is active (positioning).
pub(crate) const TRAVELS: ZswPattern = ZswPattern::printed("000x 1x1x x011 0111");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_are_those_that_the_manual_prints() {
        assert_eq!(PRINTED, [0x000B, 0x003B, 0x007B, 0x010B, 0x020B, 0x820B, 0x004B]);
        assert_eq!(
            [DISABLED, ACKNOWLEDGING, OFF1, PAUSED, STOPPED],
            [0x0003, 0x0083, 0x0002, 0x001B, 0x002B]
        );
        assert_eq!([PAUSED | START, STOPPED | START], [0x005B, 0x006B]);
    }
}
