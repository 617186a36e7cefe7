//! The rates a station knows.

use crate::time::BaudRate;

/// The rates at which a station can be spoken to, each with its max T_SDR in T_bit: the latest start of its replies
/// (GSD `<rate>_supp` and `MaxTsdr_<rate>`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rates([Option<u16>; BaudRate::ALL.len()]);

impl Rates {
    /// No rate at all, to begin with.
    pub const NONE: Self = Self([None; BaudRate::ALL.len()]);

    /// Every rate of RS-485 with the customary max T_SDR ([`BaudRate::max_tsdr_bits`]): all but that of PROFIBUS PA.
    pub const CUSTOMARY: Self = Self([
        Some(BaudRate::K9_6.max_tsdr_bits()),
        Some(BaudRate::K19_2.max_tsdr_bits()),
        None,
        Some(BaudRate::K45_45.max_tsdr_bits()),
        Some(BaudRate::K93_75.max_tsdr_bits()),
        Some(BaudRate::K187_5.max_tsdr_bits()),
        Some(BaudRate::K500.max_tsdr_bits()),
        Some(BaudRate::K1500.max_tsdr_bits()),
        Some(BaudRate::K3000.max_tsdr_bits()),
        Some(BaudRate::K6000.max_tsdr_bits()),
        Some(BaudRate::K12000.max_tsdr_bits()),
    ]);

    /// The same and `rate` with this max T_SDR.
    #[must_use]
    pub(crate) const fn with(mut self, rate: BaudRate, max_tsdr: u16) -> Self {
        *self.of(rate) = Some(max_tsdr);
        self
    }

    /// The same less `rate`.
    #[must_use]
    pub const fn without(mut self, rate: BaudRate) -> Self {
        *self.of(rate) = None;
        self
    }

    /// The max T_SDR at `rate` in T_bit; `None`: the station does not know the rate.
    pub const fn max_tsdr(mut self, rate: BaudRate) -> Option<u16> {
        *self.of(rate)
    }

    /// Whether the station knows the rate.
    pub const fn contains(self, rate: BaudRate) -> bool {
        self.max_tsdr(rate).is_some()
    }

    /// The rates it knows, slowest first.
    pub fn iter(self) -> impl DoubleEndedIterator<Item = BaudRate> {
        BaudRate::ALL.into_iter().filter(move |rate| self.contains(*rate))
    }

    /// The rates that one of them knows, with the longer max T_SDR where both do.
    #[must_use]
    pub(crate) fn union(self, other: Self) -> Self {
        other.iter().fold(self, |union, rate| match union.max_tsdr(rate).max(other.max_tsdr(rate)) {
            Some(max_tsdr) => union.with(rate, max_tsdr),
            None => union,
        })
    }

    const fn of(&mut self, rate: BaudRate) -> &mut Option<u16> {
        let [k9_6, k19_2, k31_25, k45_45, k93_75, k187_5, k500, k1500, k3000, k6000, k12000] = &mut self.0;
        match rate {
            BaudRate::K9_6 => k9_6,
            BaudRate::K19_2 => k19_2,
            BaudRate::K31_25 => k31_25,
            BaudRate::K45_45 => k45_45,
            BaudRate::K93_75 => k93_75,
            BaudRate::K187_5 => k187_5,
            BaudRate::K500 => k500,
            BaudRate::K1500 => k1500,
            BaudRate::K3000 => k3000,
            BaudRate::K6000 => k6000,
            BaudRate::K12000 => k12000,
        }
    }
}

impl Default for Rates {
    fn default() -> Self {
        Self::CUSTOMARY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_rate_is_taken_away_and_given_back_by_itself() {
        for rate in Rates::CUSTOMARY.iter() {
            let without = Rates::CUSTOMARY.without(rate);
            assert!(!without.contains(rate));
            assert_eq!(without.iter().count(), BaudRate::ALL.len() - 2);
            assert_eq!(without.with(rate, rate.max_tsdr_bits()), Rates::CUSTOMARY);
            assert_eq!(Rates::NONE.with(rate, 15).max_tsdr(rate), Some(15));
            assert_eq!(without.union(Rates::NONE.with(rate, 9999)).max_tsdr(rate), Some(9999));
            assert_eq!(without.union(without), without);
        }
        assert_eq!(Rates::NONE.iter().next(), None);
        let customary = BaudRate::ALL.into_iter().filter(|rate| *rate != BaudRate::K31_25);
        assert!(Rates::CUSTOMARY.iter().eq(customary), "31.25 kbit/s is not of RS-485");
        let pa = Rates::NONE.with(BaudRate::K31_25, 120);
        assert_eq!(
            (pa.iter().collect::<std::vec::Vec<_>>(), pa.max_tsdr(BaudRate::K31_25)),
            (std::vec![BaudRate::K31_25], Some(120))
        );
    }
}
