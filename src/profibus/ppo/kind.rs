//! The types of PPO: which words each has, and how a master asks for it.

use core::fmt;

/// A type of PPO, and its configuration identifiers (`profidrive-v2.md` 1, read back to their vendors' manuals).
///
/// The order of the types is no order of size, and the four lengths do not tell the six types apart: PPO 1 and PPO 4 have
/// twelve octets both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PpoType {
    /// PKW and 2 words of process data.
    Ppo1,
    /// PKW and 6 words of process data.
    Ppo2,
    /// 2 words of process data.
    Ppo3,
    /// 6 words of process data.
    Ppo4,
    /// PKW and 10 words of process data.
    Ppo5,
    /// PKW and 3 words of process data: seven words, none of the profile's types.
    SevenWords,
}

impl PpoType {
    /// Every type.
    pub const ALL: [Self; 6] = [Self::Ppo1, Self::Ppo2, Self::Ppo3, Self::Ppo4, Self::Ppo5, Self::SevenWords];

    /// Whether it has the parameter channel, four words ahead of the process data.
    pub const fn has_pkw(self) -> bool {
        match self {
            Self::Ppo1 | Self::Ppo2 | Self::Ppo5 | Self::SevenWords => true,
            Self::Ppo3 | Self::Ppo4 => false,
        }
    }

    /// Words of process data, STW or ZSW and the main setpoint or actual value included.
    pub const fn pzd_words(self) -> usize {
        match self {
            Self::Ppo1 | Self::Ppo3 => 2,
            Self::SevenWords => 3,
            Self::Ppo2 | Self::Ppo4 => 6,
            Self::Ppo5 => 10,
        }
    }

    /// Octets in each direction, 4 to 28.
    #[expect(clippy::len_without_is_empty, reason = "no PPO is empty")]
    pub const fn len(self) -> usize {
        let pkw = if self.has_pkw() { 4 } else { 0 };
        2 * (pkw + self.pzd_words())
    }

    /// What the master sends in Chk_Cfg: one identifier per module, inputs and outputs, consistent over the module.
    ///
    /// ```text
    /// bit  7            6      5 4                 3 2 1 0
    ///      consistent   words  inputs and outputs  words - 1
    /// ```
    ///
    /// Usual, not prescribed: the GSD of the drive has the last word. Those of the seven words follow from
    /// the others.
    pub const fn configuration(self) -> &'static [u8] {
        match self {
            Self::Ppo1 => &[0xF3, 0xF1],
            Self::Ppo2 => &[0xF3, 0xF5],
            Self::Ppo3 => &[0xF1],
            Self::Ppo4 => &[0xF5],
            Self::Ppo5 => &[0xF3, 0xF9],
            Self::SevenWords => &[0xF3, 0xF2],
        }
    }

    /// Its number in the profile; `None`: the seven words have none.
    pub(crate) const fn number(self) -> Option<u8> {
        match self {
            Self::Ppo1 => Some(1),
            Self::Ppo2 => Some(2),
            Self::Ppo3 => Some(3),
            Self::Ppo4 => Some(4),
            Self::Ppo5 => Some(5),
            Self::SevenWords => None,
        }
    }
}

impl fmt::Display for PpoType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.number() {
            Some(number) => write!(f, "PPO {number}"),
            None => f.write_str("PPO of seven words"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_types_are_those_of_the_table() {
        // `profidrive-v2.md` 1: PKW words, PZD words, octets.
        let table = [(4, 2, 12), (4, 6, 20), (0, 2, 4), (0, 6, 12), (4, 10, 28), (4, 3, 14)];
        for (kind, (pkw, pzd, octets)) in PpoType::ALL.into_iter().zip(table) {
            assert_eq!((kind.has_pkw(), kind.pzd_words(), kind.len()), (pkw == 4, pzd, octets), "{kind}");
        }
    }

    #[test]
    fn the_identifiers_say_the_words_and_name_one_type() {
        for kind in PpoType::ALL {
            let identifiers = kind.configuration();
            // `dp-v0.md`: 0xF0 = consistent, words, inputs and outputs.
            assert!(identifiers.iter().all(|identifier| identifier & 0xF0 == 0xF0));
            let words: usize = identifiers.iter().map(|identifier| usize::from(identifier & 0x0F) + 1).sum();
            assert_eq!(2 * words, kind.len(), "{kind}");
            let same = PpoType::ALL.into_iter().filter(|other| other.configuration() == identifiers);
            assert_eq!(same.count(), 1, "{kind}");
        }
    }
}
