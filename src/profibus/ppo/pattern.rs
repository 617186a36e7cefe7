//! What a status word must look like.

use core::fmt;

use super::Zsw;

/// What ZSW looks like in a state of a drive: some bits have a value, the others may be anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ZswPattern {
    /// The bits that matter.
    pub(crate) mask: u16,
    /// Their values.
    pub(crate) value: u16,
}

impl ZswPattern {
    /// Every status word.
    pub(crate) const ANY: Self = Self { mask: 0, value: 0 };

    /// The same pattern in which bit `n`, 0 to 15, matters too.
    #[must_use]
    pub(crate) const fn with(self, n: u8, set: bool) -> Self {
        let mask = 1 << (n & 15);
        let value = if set { self.value | mask } else { self.value & !mask };
        Self { mask: self.mask | mask, value }
    }

    /// The pattern as flow charts print it, bit 15 first: `101x 1x11 x011 0111`; `x` is any value.
    pub(crate) const fn printed(chart: &str) -> Self {
        let (mut mask, mut value) = (0, 0);
        let mut rest = chart.as_bytes();
        while let [digit, behind @ ..] = rest {
            rest = behind;
            if *digit != b' ' {
                mask = mask << 1 | (*digit != b'x') as u16;
                value = value << 1 | (*digit == b'1') as u16;
            }
        }
        Self { mask, value }
    }

    /// Whether a status word looks like it.
    pub(crate) const fn matches(self, zsw: Zsw) -> bool {
        zsw.raw() & self.mask == self.value
    }
}

impl fmt::Display for ZswPattern {
    /// Bits 15 to 0 as flow charts print them: `101x 1x11 x011 0111`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for n in (0..16).rev() {
            let (mask, value) = (self.mask >> n & 1, self.value >> n & 1);
            f.write_str(match (mask, value) {
                (0, _) => "x",
                (_, 0) => "0",
                (_, _) => "1",
            })?;
            if n % 4 == 0 && n > 0 {
                f.write_str(" ")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_is_read_and_printed_as_in_the_flow_charts() {
        let ready = ZswPattern::printed("0x1x 1x11 x01x 0011");
        assert_eq!(ready, ZswPattern { mask: 0xAB6F, value: 0x2B23 });
        assert_eq!(ready.to_string(), "0x1x 1x11 x01x 0011");
        assert!(ready.matches(Zsw::from_raw(0x2B23)));
        assert!(!ready.matches(Zsw::from_raw(0xAB37)));
        let faulted = ready.with(3, true);
        assert_eq!((faulted.mask, faulted.value), (0xAB6F, 0x2B2B));
        assert_eq!(faulted.with(3, false), ready);
        assert!(ZswPattern::ANY.matches(Zsw::from_raw(0xFFFF)));
    }
}
