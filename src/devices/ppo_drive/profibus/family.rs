//! How a family of drives numbers its parameters on the bus (`profidrive-v2.md` 2).

use strum::{IntoStaticStr, VariantArray};

use crate::profibus::pkw::{Config, Pages, SubindexOctet};

/// A family of drives of PROFIDRIVE version 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Family {
    /// As the profile has it: the sub-index in the high octet of IND, from 1. Parameters 1 to 2047.
    #[default]
    Profile,
    /// MICROMASTER 4: the sub-index in the high octet of IND, from 0. Bit 7 of the low octet: parameters from 2000 on. Jobs
    /// 11 to 14 write and keep.
    Micromaster,
    /// SIMODRIVE 611 universal: the sub-index in the low octet of IND, from 0. Parameters 1 to 2047.
    #[strum(serialize = "611u")]
    Simodrive611u,
}

impl Family {
    /// The family of this name.
    #[cfg(feature = "std")]
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::VARIANTS.iter().copied().find(|family| <&str>::from(family) == name)
    }

    /// The family of a drive, by what its device file calls it.
    #[cfg(feature = "std")]
    pub(crate) fn of_model(model: &str) -> Self {
        let model = model.to_uppercase();
        match () {
            () if model.contains("MICROMASTER 4") => Self::Micromaster,
            () if model.contains("611U") || model.contains("611 U") => Self::Simodrive611u,
            () => Self::Profile,
        }
    }

    /// The highest parameter that a job can name.
    pub(crate) const fn highest(self) -> u16 {
        match self {
            Self::Profile | Self::Simodrive611u => 2047,
            Self::Micromaster => 3999,
        }
    }

    /// How its parameter channel behaves.
    pub(super) const fn channel(self) -> Config {
        let (subindex, pages, from_zero) = match self {
            Self::Profile => (SubindexOctet::High, Pages::None, false),
            Self::Micromaster => (SubindexOctet::High, Pages::Of2000, true),
            Self::Simodrive611u => (SubindexOctet::Low, Pages::Ignored, true),
        };
        let keeping_jobs = matches!(self, Self::Micromaster);
        Config {
            latency: 0,
            subindex,
            read_element_by_plain_job: false,
            pages,
            from_zero,
            keeping_jobs,
            same_jobs: false,
        }
    }
}
