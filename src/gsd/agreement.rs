//! How user parameters agree with the parts of modules: what decides among modules with equal identifiers (G-07).

use core::ops::{BitAnd, BitOr};

use super::{Gsd, PrmPart};

/// How far user parameters agree with modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Agreement {
    /// They are not asked, or have another length.
    Open,
    /// They have the length.
    Length,
    /// Every parameter has a value that its file allows, too.
    Values,
    /// What no parameter changes is as in the file, too. Masters set bits there, so nothing is refused for it.
    Constants,
}

impl Agreement {
    pub(super) const BEST_FIRST: [Self; 4] = [Self::Constants, Self::Values, Self::Length, Self::Open];
}

/// The user parameters of a Set_Prm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UserPrm<'a> {
    pub(super) octets: &'a [u8],
    /// Where the part of the first module begins.
    pub(super) start: usize,
}

impl UserPrm<'_> {
    /// Whether they are those of these parts.
    pub(super) fn agrees<'g>(
        self,
        gsd: &Gsd,
        parts: impl Iterator<Item = &'g PrmPart>,
        agreement: Agreement,
    ) -> bool {
        let mut at = Positions::one(self.start);
        for part in parts {
            let octets = part.extent(gsd);
            at = match agreement {
                Agreement::Open => at,
                Agreement::Length | Agreement::Values | Agreement::Constants => {
                    self.places(gsd, part, agreement, at).up(octets)
                }
            };
        }
        at & self.end(agreement) != Positions::NONE
    }

    /// Where the last part may end.
    pub(super) fn end(self, agreement: Agreement) -> Positions {
        match agreement {
            Agreement::Open => Positions::ALL,
            Agreement::Length | Agreement::Values | Agreement::Constants => Positions::one(self.octets.len()),
        }
    }

    /// At which of these octets a part may begin.
    pub(super) fn places(
        self,
        gsd: &Gsd,
        part: &PrmPart,
        agreement: Agreement,
        within: Positions,
    ) -> Positions {
        match agreement {
            Agreement::Open | Agreement::Length => return within,
            Agreement::Values | Agreement::Constants => {}
        }
        let (constant, default) = (part.constant_bits(gsd), part.default_octets(gsd));
        let agrees = |at: &usize| {
            let own = self.octets.get(*at..).and_then(|rest| rest.get(..default.len()));
            let Some(own) = own.filter(|_| within.contains(*at)) else { return false };
            let values = || {
                let allowed = |(offset, parameter): (usize, &super::Parameter)| {
                    parameter.field.read(own, offset).is_none_or(|value| parameter.allowed.contains(value))
                };
                part.fields(gsd).all(allowed)
            };
            let constants = || {
                let differs = |((got, default), mask): ((&u8, &u8), &u8)| (got ^ default) & mask != 0;
                !own.iter().zip(&default).zip(&constant).any(differs)
            };
            (agreement != Agreement::Constants || constants()) && values()
        };
        let places = (self.start..=self.octets.len()).filter(agrees);
        places.fold(Positions::NONE, |places, at| places | Positions::one(at))
    }
}

/// A set of octets of Set_Prm, 0..=255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Positions {
    low: u128,
    high: u128,
}

impl Positions {
    pub(super) const NONE: Self = Self { low: 0, high: 0 };
    pub(super) const ALL: Self = Self { low: u128::MAX, high: u128::MAX };

    pub(super) fn one(at: usize) -> Self {
        Self { low: 1, high: 0 }.up(at)
    }

    fn contains(self, at: usize) -> bool {
        self & Self::one(at) != Self::NONE
    }

    /// Each of them so many octets later.
    pub(super) fn up(self, octets: usize) -> Self {
        match octets {
            0 => self,
            1..128 => {
                Self { low: self.low << octets, high: self.high << octets | self.low >> (128 - octets) }
            }
            128..256 => Self { low: 0, high: self.low << (octets - 128) },
            _ => Self::NONE,
        }
    }

    /// Each of them so many octets earlier.
    pub(super) fn down(self, octets: usize) -> Self {
        match octets {
            0 => self,
            1..128 => {
                Self { low: self.low >> octets | self.high << (128 - octets), high: self.high >> octets }
            }
            128..256 => Self { low: self.high >> (octets - 128), high: 0 },
            _ => Self::NONE,
        }
    }
}

impl BitAnd for Positions {
    type Output = Self;

    fn bitand(self, other: Self) -> Self {
        Self { low: self.low & other.low, high: self.high & other.high }
    }
}

impl BitOr for Positions {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self { low: self.low | other.low, high: self.high | other.high }
    }
}
