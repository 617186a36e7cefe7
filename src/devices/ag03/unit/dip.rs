//! The ten DIP switches under the cover as switches (manual chapters 2.4, 7.8 and 7.10; `ag03.md` 11). A bus makes its
//! own number of them.

use core::fmt;

use crate::devices::ag03::param::DefaultSet;

/// The positions of the ten DIP switches, read when the drive is switched on.
///
/// ```text
/// SW1 SW2 SW3 SW4 SW5 SW6 SW7   a number, 2^0 to 2^6: the address on a bus
/// SW8                           OFF in normal operation, ON for the factory reset
/// SW9 SW10                      bus terminator: both ON = active, both OFF = not
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct DipSwitches(u16);

/// SW8 is weight 2^7, as SW1 is 2^0.
const SW8: u16 = 1 << 7;
const SW9: u16 = 1 << 8;
const SW10: u16 = 1 << 9;
const ALL: u16 = SW10 | (SW10 - 1);

impl DipSwitches {
    /// Switches from a number: bit 0 = SW1 to bit 9 = SW10, 1 = ON. There are no more than ten.
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits & ALL)
    }

    /// The positions as a number, as [`from_bits`](Self::from_bits) takes it.
    pub(crate) const fn bits(self) -> u16 {
        self.0
    }

    /// The switches with SW8, for the factory reset, ON or OFF.
    #[must_use]
    pub const fn with_reset(self, on: bool) -> Self {
        Self(if on { self.0 | SW8 } else { self.0 & !SW8 })
    }

    /// The switches with SW9 and SW10, for the bus terminator, both ON or both OFF.
    #[must_use]
    pub const fn with_terminator(self, on: bool) -> Self {
        Self(if on { self.0 | SW9 | SW10 } else { self.0 & !(SW9 | SW10) })
    }

    /// The number on SW1 to SW7, 0 to 127.
    pub(crate) const fn number(self) -> u8 {
        let [_, low] = (self.0 & !SW8).to_be_bytes();
        low
    }

    /// Whether SW8 is ON.
    pub(crate) const fn reset(self) -> bool {
        self.0 & SW8 != 0
    }

    /// What SW9 and SW10 make of the bus terminator.
    pub const fn terminator(self) -> Terminator {
        match (self.0 & SW9 != 0, self.0 & SW10 != 0) {
            (false, false) => Terminator::Inactive,
            (true, true) => Terminator::Active,
            (true, false) | (false, true) => Terminator::Half,
        }
    }
}

impl fmt::Display for DipSwitches {
    /// `1010000 0 00`: SW1 first, 1 = ON.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for switch in 0..10 {
            let gap = if switch == 7 || switch == 8 { " " } else { "" };
            write!(f, "{gap}{}", self.0 >> switch & 1)?;
        }
        Ok(())
    }
}

/// The bus terminator inside the drive. Only shown: the emulated line has no reflections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Terminator {
    /// SW9 and SW10 are OFF.
    Inactive,
    /// SW9 and SW10 are ON.
    Active,
    /// Only one of them is ON: half a terminator, which the manual warns of (chapter 7.10).
    Half,
}

/// What SW1 to SW7 must show, with SW8 ON, for each factory reset (manual chapter 2.4).
///
/// The manual shows the patterns in pictures that are lost (`ag03.md` 16 no. 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ResetPatterns {
    /// Every parameter.
    pub all: u8,
    /// The standard parameters.
    pub standard: u8,
    /// The controller parameters.
    pub controller: u8,
}

impl ResetPatterns {
    /// Assumed, for want of the pictures: the number of the command of PNU 970 that loads the same defaults.
    pub(crate) const ASSUMED: Self = Self { all: 1, standard: 2, controller: 3 };

    /// The other reading: SW1, SW2 or SW3 alone.
    pub(crate) const ONE_SWITCH: Self = Self { all: 1, standard: 2, controller: 4 };

    /// The factory reset the switches ask for. SW8 ON with none of the patterns asks for none.
    pub const fn requested(self, switches: DipSwitches) -> Option<DefaultSet> {
        let number = switches.number();
        if !switches.reset() {
            None
        } else if number == self.all {
            Some(DefaultSet::All)
        } else if number == self.standard {
            Some(DefaultSet::Standard)
        } else if number == self.controller {
            Some(DefaultSet::Controller)
        } else {
            None
        }
    }
}

impl Default for ResetPatterns {
    fn default() -> Self {
        Self::ASSUMED
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_terminator_needs_both_switches() {
        let switches = DipSwitches::default();
        assert_eq!(switches.terminator(), Terminator::Inactive);
        assert_eq!(switches.with_terminator(true).terminator(), Terminator::Active);
        assert_eq!(DipSwitches::from_bits(SW9).terminator(), Terminator::Half);
        assert_eq!(DipSwitches::from_bits(SW10 | 5).terminator(), Terminator::Half);
        assert_eq!(switches.with_terminator(true).with_terminator(false), switches);
    }

    #[test]
    fn a_factory_reset_needs_switch_8_and_a_pattern() {
        let patterns = ResetPatterns { all: 127, standard: 85, controller: 42 };
        for (number, set) in [
            (127, Some(DefaultSet::All)),
            (85, Some(DefaultSet::Standard)),
            (42, Some(DefaultSet::Controller)),
            (5, None),
        ] {
            let switches = DipSwitches::from_bits(number);
            assert_eq!(patterns.requested(switches.with_reset(true)), set, "{number}");
            assert_eq!(patterns.requested(switches), None, "{number}");
        }
        assert_eq!(ResetPatterns::default(), ResetPatterns { all: 1, standard: 2, controller: 3 });
    }
}
