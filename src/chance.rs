//! When a fault on purpose injected: counted, or by chance, and the same each time.

/// The occasions of one fault.
#[derive(Clone, Debug)]
pub(crate) struct Chance {
    pub(crate) random: Random,
    occasions: u32,
    injected: u32,
}

impl Chance {
    /// No occasion yet; chance begins with `seed`.
    pub(crate) const fn new(seed: u64) -> Self {
        Self { random: Random(seed), occasions: 0, injected: 0 }
    }

    /// Counts an occasion, and says whether the fault injected that does so from number `at` on, at most `count` times,
    /// with probability `rate`.
    pub(crate) fn injected(&mut self, at: u32, count: Option<u32>, rate: f64) -> bool {
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
    pub(crate) const fn struck(&self) -> u32 {
        self.injected
    }
}

/// A sequence of numbers that looks random and is always the same for one seed (SplitMix64).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Random(u64);

impl Random {
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
