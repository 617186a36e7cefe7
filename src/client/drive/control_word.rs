//! The control words the manual prints (`ag03.md` 4), by what they ask for.

use crate::devices::ag03::drive::Direction;
use crate::devices::ag03::profibus::flow_charts;
use crate::profibus::ppo::Stw;

/// What STW asks for, without the start bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum ControlWord {
    /// Nothing: OFF1, OFF2 and disable. Motor released.
    Off,
    /// OFF1 alone, which leaves turn-on disabled.
    Off1,
    /// On and not enabled: an enabled drive brakes and is held.
    Disabled,
    /// As [`ControlWord::Disabled`], with the acknowledge bit.
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

impl ControlWord {
    /// The control word. `start` is STW.6 as it rests in positioning mode, where only its edges count; it is 0 in words
    /// that do not enable operation.
    pub(super) const fn stw(self, start: bool) -> Stw {
        let word = match self {
            Self::Off => 0,
            Self::Off1 => flow_charts::OFF1,
            Self::Disabled => flow_charts::DISABLED,
            Self::Acknowledging => flow_charts::ACKNOWLEDGING,
            Self::Enabled => flow_charts::ENABLED,
            Self::Travel => flow_charts::TRAVEL,
            Self::Paused => flow_charts::PAUSED,
            Self::Inch => flow_charts::INCHING_1,
            Self::Jog(Direction::Positive) => flow_charts::INCHING_2_POSITIVE,
            Self::Jog(Direction::Negative) => flow_charts::INCHING_2_NEGATIVE,
            Self::Turn => flow_charts::VELOCITY,
        };
        Stw::from_raw(if start && self.enables() { word | flow_charts::START } else { word })
    }

    /// Whether it enables operation.
    pub(super) const fn enables(self) -> bool {
        match self {
            Self::Off | Self::Off1 | Self::Disabled | Self::Acknowledging => false,
            Self::Enabled | Self::Travel | Self::Paused | Self::Inch | Self::Jog(_) | Self::Turn => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::ag03::profibus::bits::StwBit;

    #[test]
    fn only_words_that_enable_carry_the_start_bit() {
        assert_eq!(ControlWord::Travel.stw(true).raw(), 0x007B);
        assert_eq!(ControlWord::Enabled.stw(true).raw(), 0x004B);
        for control_word in
            [ControlWord::Off, ControlWord::Off1, ControlWord::Disabled, ControlWord::Acknowledging]
        {
            assert!(!control_word.enables() && !StwBit::EnableOperation.is_set(control_word.stw(false)));
            assert_eq!(control_word.stw(true), control_word.stw(false));
        }
    }
}
