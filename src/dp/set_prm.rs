//! Set_Prm (SAP 61): the parameters of the slave.
//!
//! ```text
//! octet 1   b7 Lock_Req  b6 Unlock_Req  b5 Sync_Req  b4 Freeze_Req  b3 WD_On  b2..b0 reserved, 0
//! octet 2   WD_Fact_1, 1..=255          watchdog time = 10 ms * WD_Fact_1 * WD_Fact_2
//! octet 3   WD_Fact_2, 1..=255
//! octet 4   min T_SDR in T_bit, 0 = keep
//! octet 5,6 Ident_Number, high octet first
//! octet 7   Group_Ident, one bit a group
//! octet 8.. User_Prm_Data
//! ```
//!
//! Source: `dp-v0.md` 5.1.

use core::time::Duration;

use nom::Parser;
use nom::combinator::rest;
use nom::error::Error;
use nom::number::complete::{be_u8, be_u16};
use thiserror::Error;

/// Octets before the user parameters.
pub const FIXED_LEN: usize = 7;

const LOCK_REQ: u8 = 0x80;
const UNLOCK_REQ: u8 = 0x40;
const SYNC_REQ: u8 = 0x20;
const FREEZE_REQ: u8 = 0x10;
const WD_ON: u8 = 0x08;
const RESERVED: u8 = 0x07;

/// A Set_Prm request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetPrm<'a> {
    station_status: u8,
    wd_factors: (u8, u8),
    min_tsdr: u8,
    ident: u16,
    group: u8,
    user_prm: &'a [u8],
}

impl<'a> SetPrm<'a> {
    /// Reads the octets of a request.
    ///
    /// # Errors
    /// [`PrmFault::Length`] with fewer than seven octets.
    pub fn parse(octets: &'a [u8]) -> Result<Self, PrmFault> {
        let got = octets.len();
        let mut fields = (be_u8::<_, Error<_>>, (be_u8, be_u8), be_u8, be_u16, be_u8, rest);
        match fields.parse(octets) {
            Ok((_, (station_status, wd_factors, min_tsdr, ident, group, user_prm))) => {
                Ok(Self { station_status, wd_factors, min_tsdr, ident, group, user_prm })
            }
            Err(_) => Err(PrmFault::Length { expected: FIXED_LEN, got }),
        }
    }

    /// The master wants the slave for itself.
    pub const fn lock_req(self) -> bool {
        self.station_status & LOCK_REQ != 0
    }

    /// The master releases the slave. Wins over [`SetPrm::lock_req`].
    pub const fn unlock_req(self) -> bool {
        self.station_status & UNLOCK_REQ != 0
    }

    /// The master will use Sync.
    pub const fn sync_req(self) -> bool {
        self.station_status & SYNC_REQ != 0
    }

    /// The master will use Freeze.
    pub const fn freeze_req(self) -> bool {
        self.station_status & FREEZE_REQ != 0
    }

    /// The watchdog time, `None` if it is off. Zero with a factor of zero, which [`SetPrm::check`] refuses.
    pub const fn watchdog(self) -> Option<Duration> {
        if self.station_status & WD_ON == 0 {
            return None;
        }
        Some(Duration::from_millis(10 * self.wd_factors.0 as u64 * self.wd_factors.1 as u64))
    }

    /// The new min T_SDR in T_bit, `None` to keep the old one.
    pub const fn min_tsdr(self) -> Option<u8> {
        if self.min_tsdr == 0 { None } else { Some(self.min_tsdr) }
    }

    /// The groups of the slave, bit 0 = group 1.
    pub const fn group_ident(self) -> u8 {
        self.group
    }

    /// Checks a locking request against the slave's ident number and the number of user parameter octets it
    /// takes (`dp-v0.md` 5.2 steps 5, 6, 8 and 9).
    ///
    /// # Errors
    /// The first fault found.
    pub fn check(self, ident: u16, user_prm_len: usize) -> Result<(), PrmFault> {
        if self.ident != ident {
            return Err(PrmFault::Ident { expected: ident, got: self.ident });
        }
        if self.station_status & RESERVED != 0 {
            return Err(PrmFault::ReservedBits { got: self.station_status & RESERVED });
        }
        if self.watchdog() == Some(Duration::ZERO) {
            return Err(PrmFault::WatchdogFactor { factors: self.wd_factors });
        }
        if self.user_prm.len() != user_prm_len {
            let got = FIXED_LEN + self.user_prm.len();
            return Err(PrmFault::Length { expected: FIXED_LEN + user_prm_len, got });
        }
        Ok(())
    }
}

/// What is wrong with a Set_Prm, and what to change in the master's project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PrmFault {
    /// Too short, too long, or other user parameters than the slave takes.
    #[error(
        "Set_Prm has {got} octets, expected {expected}: check the user parameters in the master's project"
    )]
    Length {
        /// Octets expected.
        expected: usize,
        /// Octets found.
        got: usize,
    },
    /// Octets 5 and 6 name another device.
    #[error(
        "Set_Prm octets 5-6: ident number 0x{got:04X}, expected 0x{expected:04X}: the master's project has another device at this address"
    )]
    Ident {
        /// The slave's ident number.
        expected: u16,
        /// The one found.
        got: u16,
    },
    /// Octet 1 has reserved bits set.
    #[error("Set_Prm octet 1: reserved bits 0x{got:02X} are set, expected 0x00")]
    ReservedBits {
        /// The bits found.
        got: u8,
    },
    /// The watchdog is on and a factor is zero.
    #[error("Set_Prm octets 2-3: watchdog on with factors {} and {}, expected 1..255 each", factors.0, factors.1)]
    WatchdogFactor {
        /// WD_Fact_1 and WD_Fact_2.
        factors: (u8, u8),
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: [u8; 7] = [0x88, 10, 10, 11, 0x12, 0x34, 0x22];

    #[test]
    fn the_worked_example_is_read_field_by_field() {
        let prm = SetPrm::parse(&GOOD).unwrap();
        assert!(prm.lock_req() && !prm.unlock_req() && !prm.sync_req() && !prm.freeze_req());
        assert_eq!(prm.watchdog(), Some(Duration::from_secs(1)));
        assert_eq!((prm.min_tsdr(), prm.group_ident()), (Some(11), 0x22));
        assert_eq!(prm.check(0x1234, 0), Ok(()));
    }

    #[test]
    fn a_request_seen_on_a_real_bus() {
        let prm = SetPrm::parse(&[0xB8, 0x01, 0x63, 0x0B, 0x05, 0xAA, 0x22]).unwrap();
        assert!(prm.lock_req() && prm.sync_req() && prm.freeze_req());
        assert_eq!(prm.watchdog(), Some(Duration::from_millis(990)));
    }

    #[test]
    fn w_04_the_watchdog_time_is_ten_milliseconds_times_both_factors() {
        for (first, second, millis) in [(1, 1, 10), (1, 255, 2_550), (255, 1, 2_550), (255, 255, 650_250)] {
            let prm = SetPrm { wd_factors: (first, second), ..SetPrm::parse(&GOOD).unwrap() };
            assert_eq!(prm.watchdog(), Some(Duration::from_millis(millis)));
        }
    }

    #[test]
    fn every_fault_is_named_with_expected_and_got() {
        let with = |at: usize, value: u8| {
            let mut octets = GOOD;
            octets[at] = value;
            SetPrm::parse(&octets).unwrap().check(0x1234, 0)
        };
        for len in 0..7 {
            assert_eq!(SetPrm::parse(&GOOD[..len]), Err(PrmFault::Length { expected: 7, got: len }));
        }
        assert_eq!(with(4, 0x13), Err(PrmFault::Ident { expected: 0x1234, got: 0x1334 }));
        assert_eq!(with(0, 0x89), Err(PrmFault::ReservedBits { got: 1 }));
        assert_eq!(with(1, 0), Err(PrmFault::WatchdogFactor { factors: (0, 10) }));
        assert_eq!(with(2, 0), Err(PrmFault::WatchdogFactor { factors: (10, 0) }));
        let long = [GOOD.as_slice(), &[1, 2, 3]].concat();
        let long = SetPrm::parse(&long).unwrap();
        assert_eq!(long.check(0x1234, 0), Err(PrmFault::Length { expected: 7, got: 10 }));
        assert_eq!(long.check(0x1234, 3), Ok(()));
    }
}
