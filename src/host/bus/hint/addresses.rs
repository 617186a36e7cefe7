//! A set of addresses.

use core::fmt;

use crate::host::ranges::Ranges;
use crate::profibus::fdl::Address;

/// A set of addresses. `Display`: `3, 5 to 8`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Addresses(pub(super) u128);

impl Addresses {
    pub(super) const NONE: Self = Self(0);

    /// These.
    pub(crate) fn of(addresses: impl IntoIterator<Item = Address>) -> Self {
        let mut all = Self::NONE;
        addresses.into_iter().for_each(|address| all.add(address));
        all
    }

    /// Whether this one is among them.
    pub(crate) const fn contains(self, address: Address) -> bool {
        self.0 >> address.number() & 1 == 1
    }

    pub(super) const fn add(&mut self, address: Address) {
        self.0 |= 1 << address.number();
    }
}

impl fmt::Display for Addresses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Ranges(self.0).fmt(f)
    }
}
