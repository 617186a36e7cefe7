//! When a fault on purpose is injected: counted, or by chance, and the same each time; between two times.

use core::time::Duration;

use crate::time::Instant;

/// On which occasions a fault is injected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct When {
    /// From which on, counted from 1.
    pub at: u32,
    /// How often at most; `None`: without limit.
    pub count: Option<u32>,
    /// With which probability at each, above 0 and at most 1.
    pub rate: f64,
    /// What chance begins with: the same seed injects the same faults.
    pub seed: u64,
    /// Not before so long after the fault was added. What happens earlier is not counted.
    pub from: Duration,
    /// Only until so long after the fault was added; `None`: without end.
    pub until: Option<Duration>,
}

impl When {
    /// At every occasion.
    pub const ALWAYS: Self =
        Self { at: 1, count: None, rate: 1.0, seed: 1, from: Duration::ZERO, until: None };

    /// At one occasion, counted from 1.
    pub const fn once(at: u32) -> Self {
        Self { at, count: Some(1), ..Self::ALWAYS }
    }
}

/// The occasions of one fault.
#[derive(Clone, Debug)]
pub(crate) struct Chance {
    pub(crate) random: Random,
    when: When,
    added: Instant,
    occasions: u32,
    injected: u32,
}

impl Chance {
    /// No occasion yet of a fault that is added now.
    pub(crate) const fn new(when: When, now: Instant) -> Self {
        Self { random: Random(when.seed), when, added: now, occasions: 0, injected: 0 }
    }

    /// Whether its times allow it now.
    pub(crate) fn is_open(&self, now: Instant) -> bool {
        let When { from, until, .. } = self.when;
        now >= self.added.saturating_add(from)
            && until.is_none_or(|until| now < self.added.saturating_add(until))
    }

    /// When that changes next behind `now`.
    #[cfg(feature = "std")]
    pub(crate) fn next_change(&self, now: Instant) -> Option<Instant> {
        let When { from, until, .. } = self.when;
        let at = |after| self.added.saturating_add(after);
        [Some(at(from)), until.map(at)].into_iter().flatten().filter(|change| *change > now).min()
    }

    /// Counts an occasion, and says whether the fault is injected now.
    pub(crate) fn strikes(&mut self) -> bool {
        let When { at, count, rate, .. } = self.when;
        self.occasions = self.occasions.saturating_add(1);
        if self.occasions < at || count.is_some_and(|count| self.injected >= count) {
            return false;
        }
        if rate < 1.0 && self.random.fraction() >= rate {
            return false;
        }
        self.injected = self.injected.saturating_add(1);
        true
    }

    /// How often it was injected.
    pub(crate) const fn injected(&self) -> u32 {
        self.injected
    }
}

/// A sequence of numbers that looks random and is always the same for one seed (SplitMix64).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Random(u64);

impl Random {
    #[cfg(feature = "std")]
    pub(crate) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// 0 to below 1.
    pub(crate) fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[cfg(feature = "std")]
    /// 0 to below `end`, 0 if that is 0.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        let end = u64::try_from(end).unwrap_or(u64::MAX);
        usize::try_from(self.next().checked_rem(end).unwrap_or(0)).unwrap_or(0)
    }

    #[cfg(feature = "std")]
    pub(crate) fn octet(&mut self) -> u8 {
        let [octet, ..] = self.next().to_be_bytes();
        octet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published sequence of SplitMix64 for this seed.
    #[test]
    fn numbers_are_those_of_splitmix64() {
        let mut random = Random(1_234_567);
        let numbers: [u64; 5] = core::array::from_fn(|_| random.next());
        let published = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
            4_593_380_528_125_082_431,
            16_408_922_859_458_223_821,
        ];
        assert_eq!(numbers, published);
    }
}
