//! The bits of ZSW a master looks at, and the patterns the manual prints (`ag03.md` 5).

use core::fmt;

use crate::drive::Mode;
use crate::ppo::Zsw;

/// Bits of ZSW as the client asks for them; `device::words` draws the whole word.
pub(super) mod bit {
    pub(in super::super) const READY: u8 = 0;
    pub(in super::super) const OPERATION_ENABLED: u8 = 2;
    pub(in super::super) const FAULT: u8 = 3;
    pub(in super::super) const TURN_ON_DISABLED: u8 = 6;
    /// Positioning: no lag error. Velocity: actual velocity in the window of the target.
    pub(in super::super) const NO_LAG_OR_AT_SPEED: u8 = 8;
    pub(in super::super) const TARGET_REACHED: u8 = 10;
    pub(in super::super) const JOB_ACKNOWLEDGE: u8 = 12;
    pub(in super::super) const STANDSTILL: u8 = 13;
    pub(in super::super) const LIMIT_EXCEEDED: u8 = 14;
    pub(in super::super) const READY_TO_TRAVEL: u8 = 15;
}

/// What ZSW looks like in a state of the drive: some bits have a value, the others may be anything.
///
/// The flow charts of both manuals print them (figures 13 and 14), character for character the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ZswPattern {
    /// The bits that matter.
    pub mask: u16,
    /// Their values.
    pub value: u16,
}

impl ZswPattern {
    /// Ready-to-run: supplied, not enabled, standing still.
    pub const fn ready_to_run(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::new(0xAB6F, 0x2B23),
            Mode::Velocity => Self::new(0xFE6F, 0x3E23),
        }
    }

    /// Operation enabled, standing still.
    pub const fn operation_enabled(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::new(0x2B7F, 0x2B37),
            Mode::Velocity => Self::new(0x7E7F, 0x3E37),
        }
    }

    /// Ready-to-travel. In positioning mode an interrupted travel job looks the same (`ag03.md` C-05).
    pub const fn ready_to_travel(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::new(0xEB7F, 0xAB37),
            Mode::Velocity => Self::new(0xFE7F, 0xBE37),
        }
    }

    /// Inching 1 or 2 is active (positioning).
    pub const INCHING: Self = Self::new(0xAA7F, 0x0A37);
    /// A travel job is active (positioning).
    pub const TRAVEL_JOB: Self = Self::new(0xEA7F, 0x0A37);
    /// The setpoint is released (velocity).
    pub const TRAVELLING: Self = Self::new(0xDE7F, 0x1E37);

    const fn new(mask: u16, value: u16) -> Self {
        Self { mask, value }
    }

    /// Whether a status word looks like it.
    pub const fn matches(self, zsw: Zsw) -> bool {
        zsw.raw() & self.mask == self.value
    }

    /// As [`matches`](Self::matches), with any ZSW.14 in velocity mode: one table has 1 there, the charts have 0 (C-03).
    pub(super) const fn is_met(self, mode: Mode, zsw: Zsw) -> bool {
        let mask = match mode {
            Mode::Positioning => self.mask,
            Mode::Velocity => self.mask & !(1 << bit::LIMIT_EXCEEDED),
        };
        Self { mask, ..self }.matches(zsw)
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
    use std::string::ToString;

    use super::*;

    #[test]
    fn the_patterns_are_those_of_the_flow_charts() {
        let (positioning, velocity) = (Mode::Positioning, Mode::Velocity);
        for (pattern, printed) in [
            (ZswPattern::ready_to_run(positioning), "0x1x 1x11 x01x 0011"),
            (ZswPattern::operation_enabled(positioning), "xx1x 1x11 x011 0111"),
            (ZswPattern::INCHING, "0x0x 1x1x x011 0111"),
            (ZswPattern::ready_to_travel(positioning), "101x 1x11 x011 0111"),
            (ZswPattern::TRAVEL_JOB, "000x 1x1x x011 0111"),
            (ZswPattern::ready_to_run(velocity), "0011 111x x01x 0011"),
            (ZswPattern::operation_enabled(velocity), "x011 111x x011 0111"),
            (ZswPattern::ready_to_travel(velocity), "1011 111x x011 0111"),
            (ZswPattern::TRAVELLING, "00x1 111x x011 0111"),
        ] {
            assert_eq!(pattern.to_string(), printed);
        }
        assert!(ZswPattern::ready_to_run(positioning).matches(Zsw::from_raw(0x2B23)));
        assert!(!ZswPattern::ready_to_run(positioning).matches(Zsw::from_raw(0xAB37)));
    }
}
