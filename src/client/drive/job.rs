//! The travel job of the client: from the edge of STW.6 to its end.

use super::control_word::ControlWord;
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::devices::ag03::profibus::flow_charts;
use crate::profibus::ppo::Zsw;

/// What became of the last edge of STW.6 in positioning mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TravelJob {
    /// There is no job: none was asked for, or it ended or was discarded.
    None,
    /// The edge is in the outputs and not acknowledged. ZSW.12 was so before.
    Asked { acknowledge: bool },
    /// Acknowledged: under way or interrupted.
    Active,
}

impl TravelJob {
    /// Whether the drive may have one.
    pub(super) const fn is_possible(self) -> bool {
        match self {
            Self::None => false,
            Self::Asked { .. } | Self::Active => true,
        }
    }

    /// What a new status word makes of it, with the control word that was sent.
    pub(super) fn seen(self, sent: ControlWord, zsw: Zsw) -> Self {
        match self {
            Self::None => Self::None,
            Self::Asked { acknowledge }
                if ZswBit::JobToggle.is_set(zsw) != acknowledge || flow_charts::TRAVELS.matches(zsw) =>
            {
                Self::Active
            }
            Self::Asked { acknowledge } => Self::Asked { acknowledge },
            // An interrupted job may rest in its window.
            Self::Active if sent == ControlWord::Travel && stands_at_target(zsw) => Self::None,
            Self::Active => Self::Active,
        }
    }
}

pub(super) fn stands_at_target(zsw: Zsw) -> bool {
    ZswBit::Standstill.is_set(zsw) && ZswBit::TargetReached.is_set(zsw)
}
