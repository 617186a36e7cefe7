//! Set_Prm (SAP 61): the parameters of the slave.
//!
//! ```text
//! octet 1   b7 Lock_Req  b6 Unlock_Req  b5 Sync_Req  b4 Freeze_Req  b3 WD_On  b2..b0 reserved, 0
//! octet 2   WD_Fact_1, 1..=255          watchdog time = 10 ms * WD_Fact_1 * WD_Fact_2
//! octet 3   WD_Fact_2, 1..=255
//! octet 4   min T_SDR in T_bit, 0 = keep
//! octet 5,6 Ident_Number, high octet first
//! octet 7   Group_Ident, one bit a group
//! octet 8.. User_Prm_Data, up to 237 octets
//!
//! With Description::dpv1_status octets 8 to 10 come first:
//! octet 8   DPV1_Status_1, see dpv1_status
//! octet 9   DPV1_Status_2
//! octet 10  DPV1_Status_3
//! ```
//!
//! Source: `dp-v0.md` 5.1.

use core::time::Duration;

use nom::Parser;
use nom::combinator::rest;
use nom::error::Error;
use nom::number::complete::{be_u8, be_u16};
use thiserror::Error;

use super::dpv1_status::{self, Status1};
use super::octet_bits::octet_bits;
use super::policy::{NotSupported, Policy, ShortMinTsdr, WatchdogFactorZero};
use super::{Application, Description, Refusal};

/// Octets before the user parameters.
pub(crate) const FIXED_LEN: usize = 7;

/// The most octets of a request.
pub(crate) const MAX_LEN: usize = 244;

/// What the watchdog factors count.
const WD_BASE: Duration = Duration::from_millis(10);

octet_bits! {
    /// A bit of octet 1, Station_Status.
    PrmBit {
        LockReq = 7: "Lock_Req", "the slave is locked for other masters", "no lock";
        UnlockReq = 6: "Unlock_Req", "the slave is released", "no release";
        SyncReq = 5: "Sync_Req", "Sync will be used", "no Sync";
        FreezeReq = 4: "Freeze_Req", "Freeze will be used", "no Freeze";
        WdOn = 3: "WD_On", "watchdog on", "watchdog off";
    }
}

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
    pub(crate) fn parse(octets: &'a [u8]) -> Result<Self, PrmFault> {
        let got = octets.len();
        let mut fields = (be_u8::<_, Error<_>>, (be_u8, be_u8), be_u8, be_u16, be_u8, rest);
        match fields.parse(octets) {
            Ok((_, (station_status, wd_factors, min_tsdr, ident, group, user_prm))) => {
                Ok(Self { station_status, wd_factors, min_tsdr, ident, group, user_prm })
            }
            Err(_) => Err(PrmFault::Length { expected: (FIXED_LEN, MAX_LEN), got }),
        }
    }

    /// The master wants the slave for itself.
    pub(crate) const fn lock_req(self) -> bool {
        PrmBit::LockReq.is_set(self.station_status)
    }

    /// The master releases the slave. Wins over [`SetPrm::lock_req`].
    pub(crate) const fn unlock_req(self) -> bool {
        PrmBit::UnlockReq.is_set(self.station_status)
    }

    /// The master will use Sync.
    pub(crate) const fn sync_req(self) -> bool {
        PrmBit::SyncReq.is_set(self.station_status)
    }

    /// The master will use Freeze.
    pub(crate) const fn freeze_req(self) -> bool {
        PrmBit::FreezeReq.is_set(self.station_status)
    }

    /// The watchdog time, `None` if it is off: a factor of zero turns it off too, unless [`SetPrm::check`] refuses
    /// it.
    pub(crate) fn watchdog(self) -> Option<Duration> {
        self.watchdog_of(WD_BASE)
    }

    /// The watchdog time of a slave with DPV1_Status octets, the first of which chooses the base.
    pub(crate) fn dpv1_watchdog(self) -> Option<Duration> {
        let short = self.user_prm.first().is_some_and(|status| Status1::WdBase1ms.is_set(*status));
        self.watchdog_of(if short { Duration::from_millis(1) } else { WD_BASE })
    }

    fn watchdog_of(self, base: Duration) -> Option<Duration> {
        let (first, second) = self.wd_factors;
        let factors = u32::from(first) * u32::from(second);
        (PrmBit::WdOn.is_set(self.station_status) && factors != 0).then_some(base * factors)
    }

    /// The new min T_SDR in T_bit, `None` to keep the old one.
    pub(crate) const fn min_tsdr(self) -> Option<u8> {
        if self.min_tsdr == 0 { None } else { Some(self.min_tsdr) }
    }

    /// The groups of the slave, bit 0 = group 1.
    pub(crate) const fn group_ident(self) -> u8 {
        self.group
    }

    /// Checks a locking request against what the slave is and lets the application judge the user parameters
    /// (`dp-v0.md` 5.2 steps 5 to 9).
    ///
    /// # Errors
    /// The first fault found.
    pub(crate) fn check(
        self,
        description: &Description,
        application: &impl Application,
        policy: &Policy,
    ) -> Result<(), PrmFault> {
        // 5
        if self.ident != description.ident {
            return Err(PrmFault::Ident { expected: description.ident, got: self.ident });
        }
        // 6
        if policy.check_reserved_prm_bits && self.station_status & PrmBit::RESERVED != 0 {
            return Err(PrmFault::ReservedBits { got: self.station_status & PrmBit::RESERVED });
        }
        // 7
        match policy.sync_freeze_not_supported {
            NotSupported::Fault if self.not_supported(description) => {
                let supported = if description.sync_mode { PrmBit::SyncReq.mask() } else { 0 }
                    | if description.freeze_mode { PrmBit::FreezeReq.mask() } else { 0 };
                let got = self.station_status & (PrmBit::SyncReq.mask() | PrmBit::FreezeReq.mask());
                return Err(PrmFault::NotSupported { supported, got });
            }
            NotSupported::Fault | NotSupported::GoOn => {}
        }
        // 8
        let (first, second) = self.wd_factors;
        match policy.watchdog_factor_zero {
            WatchdogFactorZero::Fault
                if PrmBit::WdOn.is_set(self.station_status) && (first == 0 || second == 0) =>
            {
                return Err(PrmFault::WatchdogFactor { factors: self.wd_factors });
            }
            WatchdogFactorZero::Fault | WatchdogFactorZero::Off => {}
        }
        match (policy.short_min_tsdr, self.min_tsdr) {
            (ShortMinTsdr::Fault, got @ 1..=10) => return Err(PrmFault::MinTsdr { got }),
            (ShortMinTsdr::Fault, 0 | 11..) | (ShortMinTsdr::Lengthen, _) => {}
        }
        // 9
        self.check_user_prm(description)?;
        application.judge_prm(self.user_prm).map_err(PrmFault::UserPrm)
    }

    /// Whether Sync or Freeze is asked for and the slave lacks it.
    pub(crate) const fn not_supported(self, description: &Description) -> bool {
        self.sync_req() && !description.sync_mode || self.freeze_req() && !description.freeze_mode
    }

    fn check_user_prm(self, description: &Description) -> Result<(), PrmFault> {
        let dpv1_len = if description.dpv1_status.is_some() { dpv1_status::LEN } else { 0 };
        let least = dpv1_len + usize::from(description.user_prm_len);
        let most = least.max(dpv1_len + usize::from(description.max_user_prm_len));
        let len = self.user_prm.len();
        if len < least || len > most {
            let (expected, got) = ((FIXED_LEN + least, FIXED_LEN + most), FIXED_LEN + len);
            return Err(PrmFault::Length { expected, got });
        }
        let (status, _) = self.user_prm.split_at_checked(dpv1_len).unwrap_or_default();
        for (index, (got, supported)) in
            status.iter().zip(description.dpv1_status.iter().flatten()).enumerate()
        {
            if got & !supported != 0 {
                let octet = FIXED_LEN + 1 + index;
                return Err(PrmFault::Dpv1Status { octet, supported: *supported, got: *got });
            }
        }
        let fail_safe = status.first().map(|status| Status1::FailSafe.is_set(*status));
        let wrong = |got: &bool| *got != description.fail_safe && (*got || !description.fail_safe_optional);
        if let Some(got) = fail_safe.filter(wrong) {
            return Err(PrmFault::FailSafe { expected: description.fail_safe, got });
        }
        Ok(())
    }
}

/// What is wrong with a Set_Prm, and what to change in the master's project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PrmFault {
    /// Too short, too long, or other user parameters than the slave takes.
    #[error(
        "Set_Prm has {got} octets, expected {}: check the user parameters in the master's project", Span(*expected)
    )]
    Length {
        /// The fewest and the most octets expected.
        expected: (usize, usize),
        /// Octets found.
        got: usize,
    },
    /// Octets 5 and 6 name another device.
    #[error(
        "Set_Prm octets 5-6: ident number 0x{got:04X}, expected 0x{expected:04X}: {}",
        other_device(*expected, *got)
    )]
    Ident {
        /// The slave's ident number.
        expected: u16,
        /// The one found.
        got: u16,
    },
    /// Octet 1 has reserved bits set.
    #[error(
        "Set_Prm octet 1: reserved bits 0x{got:02X} are set, expected 0x00: the master's project or the master itself is at fault"
    )]
    ReservedBits {
        /// The bits found.
        got: u8,
    },
    /// The watchdog is on and a factor is zero.
    #[error(
        "Set_Prm octets 2-3: watchdog on with factors {} and {}, expected 1..255 each: set a watchdog time in the master's project or turn the watchdog off",
        factors.0,
        factors.1
    )]
    WatchdogFactor {
        /// WD_Fact_1 and WD_Fact_2.
        factors: (u8, u8),
    },
    /// Octet 1 asks for Sync (b5) or Freeze (b4), which the slave lacks.
    #[error(
        "Set_Prm octet 1: asks for Sync (0x{:02X}) and Freeze (0x{:02X}) with 0x{got:02X}, expected bits within 0x{supported:02X}: take the slave out of the Sync or Freeze groups of the master's project",
        PrmBit::SyncReq.mask(),
        PrmBit::FreezeReq.mask()
    )]
    NotSupported {
        /// The bits supported.
        supported: u8,
        /// The bits found.
        got: u8,
    },
    /// Octet 4 is shorter than the standard knows.
    #[error(
        "Set_Prm octet 4: min T_SDR {got} T_bit, expected 0 or 11..255: correct the bus parameters in the master's project"
    )]
    MinTsdr {
        /// The value found.
        got: u8,
    },
    /// DPV1_Status_1, 2 or 3 asks for what the slave lacks.
    #[error(
        "Set_Prm octet {octet}: 0x{got:02X}, expected bits within 0x{supported:02X}: turn the DP-V1 functions off in the master's project"
    )]
    Dpv1Status {
        /// Which octet, 8..=10.
        octet: usize,
        /// The bits supported.
        supported: u8,
        /// The octet found.
        got: u8,
    },
    /// DPV1_Status_1.Fail_Safe is not what the slave does.
    #[error(
        "Set_Prm octet 8: Fail_Safe {}, expected {}: the master's project was made with another GSD", u8::from(*got), u8::from(*expected)
    )]
    FailSafe {
        /// Whether the slave has Fail_Safe.
        expected: bool,
        /// The bit found.
        got: bool,
    },
    /// The application refuses the user parameters.
    #[error("{}", Refused(.0))]
    UserPrm(Refusal),
}

/// A refusal, as a person reads it.
struct Refused<'a>(&'a Refusal);

impl core::fmt::Display for Refused<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.write(f, "Set_Prm", FIXED_LEN + 1)
    }
}

/// What another ident number means.
const fn other_device(expected: u16, got: u16) -> &'static str {
    if got == expected.swap_bytes() {
        "the two octets are exchanged, the high one comes first"
    } else {
        "the master's project has another device at this address"
    }
}

/// "7" or "7..12".
struct Span((usize, usize));

impl core::fmt::Display for Span {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self((least, most)) = *self;
        if least == most { write!(f, "{least}") } else { write!(f, "{least}..{most}") }
    }
}

#[cfg(test)]
mod tests {
    use core::ops::RangeInclusive;

    use super::*;
    use crate::profibus::dp::Fixed;
    use crate::profibus::dp::application::{Expected, Reason};

    const GOOD: [u8; 7] = [0x88, 10, 10, 11, 0x12, 0x34, 0x22];

    const PLAIN: Description = Description { ident: 0x1234, ..Description::PLAIN };

    fn check(octets: &[u8], description: &Description) -> Result<(), PrmFault> {
        judge(octets, description, &[])
    }

    fn judge(
        octets: &[u8],
        description: &Description,
        user_prm: &[RangeInclusive<u8>],
    ) -> Result<(), PrmFault> {
        let application = Fixed { user_prm, prm_advice: "correct it", ..Fixed::PLAIN };
        SetPrm::parse(octets).unwrap().check(description, &application, &Policy::PROPOSED)
    }

    fn refused(index: usize, expected: (u8, u8), got: u8) -> Result<(), PrmFault> {
        let expected = Expected::Range(expected.0, expected.1);
        let reason = Reason::Text("correct it");
        Err(PrmFault::UserPrm(Refusal { index, expected, got: Some(got), reason }))
    }

    #[test]
    fn the_worked_example_is_read_field_by_field() {
        let prm = SetPrm::parse(&GOOD).unwrap();
        assert!(prm.lock_req() && !prm.unlock_req() && !prm.sync_req() && !prm.freeze_req());
        assert_eq!(prm.watchdog(), Some(Duration::from_secs(1)));
        assert_eq!((prm.min_tsdr(), prm.group_ident()), (Some(11), 0x22));
        assert_eq!(check(&GOOD, &PLAIN), Ok(()));
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
            check(&octets, &PLAIN)
        };
        for len in 0..7 {
            assert_eq!(SetPrm::parse(&GOOD[..len]), Err(PrmFault::Length { expected: (7, 244), got: len }));
        }
        assert_eq!(with(4, 0x13), Err(PrmFault::Ident { expected: 0x1234, got: 0x1334 }));
        assert_eq!(with(0, 0x89), Err(PrmFault::ReservedBits { got: 1 }));
        assert_eq!(with(1, 0), Err(PrmFault::WatchdogFactor { factors: (0, 10) }));
        assert_eq!(with(2, 0), Err(PrmFault::WatchdogFactor { factors: (10, 0) }));
        let long = [GOOD.as_slice(), &[1, 2, 3]].concat();
        assert_eq!(check(&long, &PLAIN), Err(PrmFault::Length { expected: (7, 7), got: 10 }));
        assert_eq!(check(&long, &Description { user_prm_len: 3, ..PLAIN }), Ok(()));
    }

    #[test]
    fn user_parameters_are_measured_and_each_octet_is_compared() {
        let device = Description { user_prm_len: 2, max_user_prm_len: 4, ..PLAIN };
        for (user_prm, expected) in [
            (&[0, 5][..], Ok(())),
            (&[3, 5, 255], Ok(())),
            (&[3, 5, 255, 0], Ok(())),
            (&[3], Err(PrmFault::Length { expected: (9, 11), got: 8 })),
            (&[3, 5, 0, 0, 0], Err(PrmFault::Length { expected: (9, 11), got: 12 })),
            (&[4, 5], refused(0, (0, 3), 4)),
            (&[0, 6], refused(1, (5, 5), 6)),
        ] {
            let octets = [&GOOD, user_prm].concat();
            assert_eq!(judge(&octets, &device, &[0..=3, 5..=5]), expected, "{user_prm:02X?}");
        }
        let fault = refused(0, (0, 3), 4).unwrap_err();
        assert_eq!(fault.to_string(), "Set_Prm octet 8: 0x04, expected 0x00..0x03: correct it");
        let fault = PrmFault::Length { expected: (9, 11), got: 8 };
        assert!(fault.to_string().starts_with("Set_Prm has 8 octets, expected 9..11: "), "{fault}");
    }

    #[test]
    fn p_17_the_dpv1_octets_are_checked_where_the_slave_has_them() {
        let device = Description { dpv1_status: Some([0xC4, 0x01, 0x00]), fail_safe: true, ..PLAIN };
        for (status, expected) in [
            (&[0xC4, 0x01, 0x00][..], Ok(())),
            (&[0x40, 0x00, 0x00], Ok(())),
            (&[0x80, 0x00, 0x00], Err(PrmFault::FailSafe { expected: true, got: false })),
            (&[0x60, 0x00, 0x00], Err(PrmFault::Dpv1Status { octet: 8, supported: 0xC4, got: 0x60 })),
            (&[0x40, 0x03, 0x00], Err(PrmFault::Dpv1Status { octet: 9, supported: 0x01, got: 0x03 })),
            (&[0x40, 0x00, 0x80], Err(PrmFault::Dpv1Status { octet: 10, supported: 0x00, got: 0x80 })),
            (&[0x40, 0x00], Err(PrmFault::Length { expected: (10, 10), got: 9 })),
        ] {
            assert_eq!(check(&[&GOOD, status].concat(), &device), expected, "{status:02X?}");
        }
        let with_user_prm = Description { user_prm_len: 1, ..device };
        let octets = [&GOOD[..], &[0x40, 0x00, 0x00, 4]].concat();
        let ranges = [0..=255, 0..=255, 0..=255, 0..=3];
        assert_eq!(judge(&octets, &with_user_prm, &ranges), refused(3, (0, 3), 4), "octet 11");
        let watchdog = |status: u8| {
            let octets = [&GOOD[..], &[status, 0, 0]].concat();
            SetPrm::parse(&octets).unwrap().dpv1_watchdog()
        };
        assert_eq!(watchdog(0x04), Some(Duration::from_millis(100)));
        assert_eq!(watchdog(0x00), Some(Duration::from_secs(1)));
    }
}
