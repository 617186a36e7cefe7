//! What the status word looks like in each state of the drive: the patterns that the manual prints.

use core::fmt;

use crate::client::course::Bits;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::profibus::ppo::Zsw;

/// What ZSW looks like in a state of the drive: some bits have a value, the others may be anything.
///
/// The flow charts of both manuals print them (figures 13 and 14), character for character the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ZswPattern {
    /// The bits that matter.
    pub mask: u16,
    /// Their values.
    pub value: u16,
}

impl ZswPattern {
    /// Ready-to-run: supplied, not enabled, standing still.
    pub(crate) const fn ready_to_run(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::printed("0x1x 1x11 x01x 0011"),
            Mode::Velocity => Self::printed("0011 111x x01x 0011"),
        }
    }

    /// Operation enabled, standing still.
    pub(crate) const fn operation_enabled(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::printed("xx1x 1x11 x011 0111"),
            Mode::Velocity => Self::printed("x011 111x x011 0111"),
        }
    }

    /// Ready-to-travel. In positioning mode an interrupted travel job looks the same (`ag03.md` C-05).
    pub(crate) const fn ready_to_travel(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::printed("101x 1x11 x011 0111"),
            Mode::Velocity => Self::printed("1011 111x x011 0111"),
        }
    }

    /// Inching 1 or 2 is active (positioning).
    pub(crate) const INCHING: Self = Self::printed("0x0x 1x1x x011 0111");
    /// A travel job is active (positioning).
    pub(crate) const TRAVEL_JOB: Self = Self::printed("000x 1x1x x011 0111");

    /// Every status word.
    pub(crate) const ANY: Self = Self { mask: 0, value: 0 };

    /// The same pattern in which this bit matters too.
    #[must_use]
    pub(crate) const fn with(self, bit: ZswBit, set: bool) -> Self {
        let others = self.value & !bit.mask();
        Self { mask: self.mask | bit.mask(), value: others | bit.when(set) }
    }

    /// The pattern as the flow charts print it, bit 15 first; `x` is any value.
    const fn printed(chart: &str) -> Self {
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

    /// Its bits, with any ZSW.14 in velocity mode: one table has 1 there, the charts have 0 (C-03).
    pub(super) const fn bits(self, mode: Mode) -> Bits {
        let mask = match mode {
            Mode::Positioning => self.mask,
            Mode::Velocity => self.mask & !ZswBit::LimitExceeded.mask(),
        };
        Bits { mask, value: self.value & mask }
    }
}

impl fmt::Display for ZswPattern {
    /// Bits 15 to 0 as the flow charts print them: `101x 1x11 x011 0111`.
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
        let positioning = Mode::Positioning;
        let ready = ZswPattern::ready_to_run(positioning);
        assert_eq!(ready, ZswPattern { mask: 0xAB6F, value: 0x2B23 });
        assert_eq!(ready.to_string(), "0x1x 1x11 x01x 0011");
        assert!(ZswPattern::ready_to_run(positioning).matches(Zsw::from_raw(0x2B23)));
        assert!(!ZswPattern::ready_to_run(positioning).matches(Zsw::from_raw(0xAB37)));
    }
}
