//! Time on the bus: instants, bit times and baud rates. This module owns no clock.

use core::fmt;
use core::ops::Add;
use core::time::Duration;

use thiserror::Error;

/// A point in time in nanoseconds since an origin the host chooses.
///
/// Nanoseconds because one bit at 12 Mbit/s lasts 83.3 ns. Arithmetic saturates and never panics: an earlier
/// instant minus a later one is zero, not a plausible number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instant(u64);

impl Instant {
    /// The origin of the host's clock.
    pub const ZERO: Self = Self(0);

    /// An instant `nanos` nanoseconds after the origin.
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// An instant `micros` microseconds after the origin.
    pub const fn from_micros(micros: u64) -> Self {
        Self(micros.saturating_mul(1_000))
    }

    /// An instant `millis` milliseconds after the origin.
    pub const fn from_millis(millis: u64) -> Self {
        Self(millis.saturating_mul(1_000_000))
    }

    /// Nanoseconds since the origin.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// The time since `earlier`, zero if `earlier` is later than `self`.
    pub const fn saturating_since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }

    /// The earlier of two deadlines, `None` if there is none. What each telegram asks for several times, so without
    /// the copies that iterators over arrays of options cost.
    #[must_use]
    pub const fn first_of(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (one, other) {
            (Some(one), Some(other)) if one.0 <= other.0 => Some(one),
            (Some(_) | None, Some(other)) => Some(other),
            (one, None) => one,
        }
    }

    /// `duration` later, at most the end of time (584 years after the origin).
    pub const fn saturating_add(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(nanos(duration)))
    }
}

impl Add<Duration> for Instant {
    type Output = Self;

    /// [`Instant::saturating_add`].
    fn add(self, duration: Duration) -> Self {
        self.saturating_add(duration)
    }
}

impl fmt::Display for Instant {
    /// Seconds with six decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:06}", self.0 / 1_000_000_000, self.0 % 1_000_000_000 / 1_000)
    }
}

/// A duration in whole nanoseconds, saturating after 584 years.
pub(crate) const fn nanos(duration: Duration) -> u64 {
    duration.as_secs().saturating_mul(1_000_000_000).saturating_add(duration.subsec_nanos() as u64)
}

/// The ten transmission rates of PROFIBUS-DP on RS-485 (`dp-v0.md` 1.1), and that of PROFIBUS PA.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "the names say it: kilobits per second")]
pub enum BaudRate {
    K9_6,
    K19_2,
    K31_25,
    K45_45,
    K93_75,
    K187_5,
    K500,
    K1500,
    K3000,
    K6000,
    K12000,
}

impl BaudRate {
    /// Every rate, slowest first.
    pub const ALL: [Self; 11] = [
        Self::K9_6,
        Self::K19_2,
        Self::K31_25,
        Self::K45_45,
        Self::K93_75,
        Self::K187_5,
        Self::K500,
        Self::K1500,
        Self::K3000,
        Self::K6000,
        Self::K12000,
    ];

    /// The rate of `bits` bits per second.
    ///
    /// # Errors
    /// [`BaudRateError`] if PROFIBUS-DP knows no such rate.
    pub fn from_bits_per_second(bits: u32) -> Result<Self, BaudRateError> {
        Self::ALL.into_iter().find(|rate| rate.bits_per_second() == bits).ok_or(BaudRateError { got: bits })
    }

    /// Bits per second.
    pub const fn bits_per_second(self) -> u32 {
        match self {
            Self::K9_6 => 9_600,
            Self::K19_2 => 19_200,
            Self::K31_25 => 31_250,
            Self::K45_45 => 45_450,
            Self::K93_75 => 93_750,
            Self::K187_5 => 187_500,
            Self::K500 => 500_000,
            Self::K1500 => 1_500_000,
            Self::K3000 => 3_000_000,
            Self::K6000 => 6_000_000,
            Self::K12000 => 12_000_000,
        }
    }

    /// How long `bits` bit times (T_bit) last, rounded up to whole nanoseconds.
    pub const fn bit_times(self, bits: u32) -> Duration {
        Duration::from_nanos((bits as u64 * 1_000_000_000).div_ceil(self.bits_per_second() as u64))
    }

    /// How long `octets` characters of 11 bits last on the line.
    pub const fn octet_times(self, octets: u32) -> Duration {
        self.bit_times(octets.saturating_mul(BITS_PER_OCTET))
    }

    /// The customary latest start of a reply, max T_SDR, in T_bit after the request (`dp-v0.md` 1.1).
    pub const fn max_tsdr_bits(self) -> u16 {
        match self {
            Self::K9_6 | Self::K19_2 | Self::K31_25 | Self::K45_45 | Self::K93_75 | Self::K187_5 => 60,
            Self::K500 => 100,
            Self::K1500 => 150,
            Self::K3000 => 250,
            Self::K6000 => 450,
            Self::K12000 => 800,
        }
    }
}

impl BaudRate {
    /// The customary slot time of masters, T_SL, in T_bit: how long they wait for a reply to begin (`dp-v0.md` 1.1).
    pub const fn slot_bits(self) -> u16 {
        match self {
            Self::K9_6 | Self::K19_2 | Self::K31_25 | Self::K45_45 | Self::K93_75 | Self::K187_5 => 100,
            Self::K500 => 200,
            Self::K1500 => 300,
            Self::K3000 => 400,
            Self::K6000 => 600,
            Self::K12000 => 1000,
        }
    }
}

impl fmt::Display for BaudRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bit/s", self.bits_per_second())
    }
}

/// Bits of one character on the line: start, eight data, even parity, stop.
pub(crate) const BITS_PER_OCTET: u32 = 11;

/// The idle time before every request, T_SYN, in T_bit.
pub const SYN_BITS: u32 = 33;

/// A number that is none of the PROFIBUS-DP rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "{got} bit/s is no PROFIBUS-DP rate; expected 9600, 19200, 31250, 45450, 93750, 187500, 500000, 1500000, 3000000, 6000000 or 12000000"
)]
pub struct BaudRateError {
    /// The number found, in bit/s.
    pub got: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_saturates_at_both_ends() {
        let early = Instant::from_millis(1);
        let late = Instant::from_millis(5);
        assert_eq!(early.saturating_since(late), Duration::ZERO);
        assert_eq!(late.saturating_since(early), Duration::from_millis(4));
        assert_eq!(early + Duration::from_millis(4), late);
        assert_eq!(
            Instant::from_nanos(u64::MAX).saturating_add(Duration::MAX),
            Instant::from_nanos(u64::MAX)
        );
    }

    #[test]
    fn bit_times_of_the_reference_table() {
        assert_eq!(BaudRate::K12000.bit_times(11), Duration::from_nanos(917));
        assert_eq!(BaudRate::K500.bit_times(33), Duration::from_micros(66));
        assert_eq!(BaudRate::K9_6.octet_times(1), Duration::from_nanos(1_145_834));
    }

    #[test]
    fn every_rate_is_found_by_its_number_and_no_other_is() {
        for rate in BaudRate::ALL {
            assert_eq!(BaudRate::from_bits_per_second(rate.bits_per_second()), Ok(rate));
        }
        assert_eq!(BaudRate::from_bits_per_second(115_200), Err(BaudRateError { got: 115_200 }));
    }

    #[test]
    fn an_instant_reads_as_seconds() {
        assert_eq!(std::format!("{}", Instant::from_micros(1_250_042)), "1.250042");
    }
}
