//! The control words the manual prints (`ag03.md` 4), by what they ask for.

use crate::drive::Direction;
use crate::ppo::Stw;

/// What STW asks for, without the start bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Posture {
    /// Nothing: OFF1, OFF2 and disable. Motor released.
    Off,
    /// OFF1 alone, which leaves turn-on disabled.
    Off1,
    /// On and not enabled: an enabled drive brakes and is held.
    Disabled,
    /// As [`Posture::Disabled`], with the acknowledge bit.
    Acknowledging,
    /// Operation enabled. A travel job is discarded with maximum deceleration.
    Enabled,
    /// A travel job may start or goes on.
    Travel,
    /// Intermediate stop of a travel job.
    Paused,
    /// Inching 1.
    Inch,
    /// Inching 2.
    Jog(Direction),
    /// The setpoint is released (velocity mode).
    Turn,
}

impl Posture {
    /// The control word. `start` is STW.6 as it rests in positioning mode, where only its edges count; it is 0 in words
    /// that do not enable operation.
    pub(super) const fn stw(self, start: bool) -> Stw {
        let (word, enabled) = match self {
            Self::Off => (0x0000, false),
            Self::Off1 => (0x0002, false),
            Self::Disabled => (0x0003, false),
            Self::Acknowledging => (0x0083, false),
            Self::Enabled => (0x000B, true),
            Self::Travel => (0x003B, true),
            Self::Paused => (0x001B, true),
            Self::Inch => (0x010B, true),
            Self::Jog(Direction::Positive) => (0x020B, true),
            Self::Jog(Direction::Negative) => (0x820B, true),
            Self::Turn => (0x004B, true),
        };
        let stw = Stw::from_raw(word);
        if start && enabled { stw.with_bit(6, true) } else { stw }
    }

    /// Whether it enables operation.
    pub(super) const fn enables(self) -> bool {
        self.stw(false).bit(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_words_that_enable_carry_the_start_bit() {
        assert_eq!(Posture::Travel.stw(true).raw(), 0x007B);
        assert_eq!(Posture::Enabled.stw(true).raw(), 0x004B);
        for posture in [Posture::Off, Posture::Off1, Posture::Disabled, Posture::Acknowledging] {
            assert!(!posture.enables());
            assert_eq!(posture.stw(true), posture.stw(false));
        }
    }
}
