//! Set_Prm, octet by octet.

use core::time::Duration;

use crate::profibus::dp::dpv1_status;

/// Bits of Station_Status.
pub(in super::super) const LOCK: u8 = 0x80;
pub(in super::super) const UNLOCK: u8 = 0x40;
pub(in super::super) const SYNC: u8 = 0x20;
pub(in super::super) const FREEZE: u8 = 0x10;
const WD_ON: u8 = 0x08;

/// min T_SDR as masters set it.
const MIN_TSDR: u8 = 11;
/// The unit of the watchdog.
const UNIT_MILLIS: u64 = 10;

/// What Set_Prm says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) struct Prm {
    pub(in super::super) status: u8,
    pub(in super::super) factors: [u8; 2],
    pub(in super::super) min_tsdr: u8,
    pub(in super::super) ident: u16,
    pub(in super::super) groups: u8,
    pub(in super::super) user: Vec<u8>,
}

impl Prm {
    /// Lock, no watchdog.
    pub(in super::super) const fn lock(ident: u16, user: Vec<u8>) -> Self {
        Self { status: LOCK, factors: [0, 0], min_tsdr: MIN_TSDR, ident, groups: 0, user }
    }

    /// Unlock.
    pub(in super::super) fn unlock(ident: u16, user: Vec<u8>) -> Self {
        Self { status: UNLOCK, min_tsdr: 0, ..Self::lock(ident, user) }
    }

    /// With these factors of the watchdog.
    #[must_use]
    pub(in super::super) fn watched(self, factors: [u8; 2]) -> Self {
        Self { status: self.status | WD_ON, factors, ..self }
    }

    /// With more bits of Station_Status.
    #[must_use]
    pub(in super::super) fn with(self, bits: u8) -> Self {
        Self { status: self.status | bits, ..self }
    }

    /// With bits of DPV1_Status 1, 2 or 3, at 0, 1 or 2, set and others cleared.
    #[must_use]
    pub(in super::super) fn status(mut self, octet: usize, set: u8, clear: u8) -> Self {
        self.user.resize(self.user.len().max(dpv1_status::LEN), 0);
        if let Some(status) = self.user.get_mut(octet) {
            *status = *status & !clear | set;
        }
        self
    }

    /// The watchdog time.
    pub(in super::super) fn watchdog(&self) -> Duration {
        let [one, other] = self.factors;
        Duration::from_millis(UNIT_MILLIS * u64::from(one) * u64::from(other))
    }

    /// Its octets.
    pub(in super::super) fn octets(&self) -> Vec<u8> {
        let [high, low] = self.ident.to_be_bytes();
        let [one, other] = self.factors;
        let mut octets = vec![self.status, one, other, self.min_tsdr, high, low, self.groups];
        octets.extend(&self.user);
        octets
    }
}
