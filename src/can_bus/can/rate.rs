//! Bit rates and bit times.

use core::fmt;
use core::num::NonZeroU32;
use core::time::Duration;

use thiserror::Error;

/// The rate of a bus in bits per second, 1..=1000000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BitRate(NonZeroU32);

impl BitRate {
    /// 125 kbit/s.
    pub const K125: Self = Self::of(125_000);
    /// 250 kbit/s.
    pub const K250: Self = Self::of(250_000);
    /// 500 kbit/s.
    pub const K500: Self = Self::of(500_000);
    /// 1 Mbit/s, the highest of classical CAN.
    pub const K1000: Self = Self::of(Self::MAX);

    const MAX: u32 = 1_000_000;

    /// Only for the constants above: 0 would become 1.
    const fn of(bits: u32) -> Self {
        match NonZeroU32::new(bits) {
            Some(bits) => Self(bits),
            None => Self(NonZeroU32::MIN),
        }
    }

    /// `bits` per second.
    ///
    /// # Errors
    /// [`BitRateError`] for 0 and above 1000000.
    pub(crate) const fn from_bits_per_second(bits: u32) -> Result<Self, BitRateError> {
        match NonZeroU32::new(bits) {
            Some(rate) if bits <= Self::MAX => Ok(Self(rate)),
            Some(_) | None => Err(BitRateError { got: bits }),
        }
    }

    /// Bits per second.
    pub(crate) const fn bits_per_second(self) -> u32 {
        self.0.get()
    }

    /// How long `bits` bits last, rounded up to whole nanoseconds.
    pub(crate) const fn bit_times(self, bits: u32) -> Duration {
        Duration::from_nanos((bits as u64 * 1_000_000_000).div_ceil(self.0.get() as u64))
    }
}

impl fmt::Display for BitRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bit/s", self.0)
    }
}

/// A rate that classical CAN does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("bit rate {got} is outside 1..1000000")]
pub struct BitRateError {
    /// The rate found.
    pub got: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_end_at_a_megabit() {
        assert_eq!(BitRate::from_bits_per_second(1_000_000), Ok(BitRate::K1000));
        assert_eq!(BitRate::from_bits_per_second(1_000_001), Err(BitRateError { got: 1_000_001 }));
        assert_eq!(BitRate::from_bits_per_second(0), Err(BitRateError { got: 0 }));
    }

    #[test]
    fn bit_times_are_rounded_up() {
        assert_eq!(BitRate::K1000.bit_times(135), Duration::from_micros(135));
        assert_eq!(BitRate::K125.bit_times(1), Duration::from_micros(8));
        let third = BitRate::from_bits_per_second(300_000).unwrap();
        assert_eq!(third.bit_times(1), Duration::from_nanos(3334));
        assert_eq!(BitRate::K1000.bit_times(u32::MAX), Duration::from_micros(u64::from(u32::MAX)));
    }
}
