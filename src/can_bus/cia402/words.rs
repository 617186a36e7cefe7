//! Each bit of the words, once.

use core::ops::{BitOr, BitOrAssign};

use super::state::Command;

/// The controlword, 6040h.
///
/// ```text
/// bit  15..11 of the device   10..9 reserved   8 halt   7 fault reset
///      6..4 of the mode   3 enable operation   2 quick stop (low active)   1 enable voltage   0 switch on
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Controlword(pub u16);

impl Controlword {
    /// Bit 0.
    pub(crate) const SWITCH_ON: u16 = 1 << 0;
    /// Bit 1.
    pub(crate) const ENABLE_VOLTAGE: u16 = 1 << 1;
    /// Bit 2, low active: 0 is a quick stop.
    pub(crate) const QUICK_STOP: u16 = 1 << 2;
    /// Bit 3.
    pub(crate) const ENABLE_OPERATION: u16 = 1 << 3;
    /// Bit 4 in profile position mode: take the set-point, with the rising edge.
    pub(crate) const NEW_SET_POINT: u16 = 1 << 4;
    /// Bit 5 in profile position mode: do not wait for the end of the running set-point.
    pub(crate) const CHANGE_IMMEDIATELY: u16 = 1 << 5;
    /// Bit 6 in profile position mode: the target is a distance.
    pub(crate) const RELATIVE: u16 = 1 << 6;
    /// Bit 7, with the rising edge.
    pub(crate) const FAULT_RESET: u16 = 1 << 7;
    /// Bit 8.
    pub(crate) const HALT: u16 = 1 << 8;

    /// Whether all bits of `mask` are set.
    pub(crate) const fn has(self, mask: u16) -> bool {
        self.0 & mask == mask
    }

    /// Whether the bits of `mask` are set now and were not `before`.
    pub(crate) const fn rises(self, before: Self, mask: u16) -> bool {
        self.has(mask) && !before.has(mask)
    }

    /// The command to the state machine, after the word `before`.
    ///
    /// ```text
    /// bits 3 2 1 0   x x 0 x disable voltage   x 0 1 x quick stop   x 1 1 0 shutdown
    ///                0 1 1 1 switch on or disable operation   1 1 1 1 enable operation   bit 7 0 -> 1 fault reset
    /// ```
    pub(crate) const fn command(self, before: Self) -> Command {
        if self.rises(before, Self::FAULT_RESET) {
            Command::FaultReset
        } else if !self.has(Self::ENABLE_VOLTAGE) {
            Command::DisableVoltage
        } else if !self.has(Self::QUICK_STOP) {
            Command::QuickStop
        } else if !self.has(Self::SWITCH_ON) {
            Command::Shutdown
        } else if !self.has(Self::ENABLE_OPERATION) {
            Command::SwitchOn
        } else {
            Command::EnableOperation
        }
    }
}

/// The statusword, 6041h.
///
/// ```text
/// bit  15..14 of the device   13..12 of the mode   11 internal limit   10 target reached   9 remote   8 of the device
///      7 warning   6 switch on disabled   5 quick stop (low active)   4 voltage enabled
///      3 fault   2 operation enabled   1 switched on   0 ready to switch on
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Statusword(pub u16);

impl Statusword {
    /// Bit 0.
    pub const READY_TO_SWITCH_ON: Self = Self(1 << 0);
    /// Bit 1.
    pub const SWITCHED_ON: Self = Self(1 << 1);
    /// Bit 2.
    pub const OPERATION_ENABLED: Self = Self(1 << 2);
    /// Bit 3.
    pub const FAULT: Self = Self(1 << 3);
    /// Bit 4: the power part is supplied.
    pub const VOLTAGE_ENABLED: Self = Self(1 << 4);
    /// Bit 5, low active.
    pub const QUICK_STOP: Self = Self(1 << 5);
    /// Bit 6.
    pub const SWITCH_ON_DISABLED: Self = Self(1 << 6);
    /// Bit 7.
    pub const WARNING: Self = Self(1 << 7);
    /// Bit 9: the drive follows the bus.
    pub const REMOTE: Self = Self(1 << 9);
    /// Bit 10.
    pub const TARGET_REACHED: Self = Self(1 << 10);
    /// Bit 11.
    pub const INTERNAL_LIMIT: Self = Self(1 << 11);
    /// Bit 12 in profile position mode.
    pub const SET_POINT_ACKNOWLEDGE: Self = Self(1 << 12);
    /// Bit 12 in homing mode.
    pub const HOMING_ATTAINED: Self = Self(1 << 12);
    /// Bit 12 in interpolated position mode.
    pub const IP_ACTIVE: Self = Self(1 << 12);
    /// Bit 12 in profile velocity mode.
    pub const ZERO_SPEED: Self = Self(1 << 12);
    /// Bit 13 in profile position mode.
    pub const FOLLOWING_ERROR: Self = Self(1 << 13);
    /// Bit 13 in homing mode.
    pub const HOMING_ERROR: Self = Self(1 << 13);

    /// No bit.
    pub const NONE: Self = Self(0);

    /// Whether all bits of `mask` are set.
    pub const fn has(self, mask: Self) -> bool {
        self.0 & mask.0 == mask.0
    }

    /// These bits if `holds`, else none.
    #[must_use]
    pub(crate) const fn when(self, holds: bool) -> Self {
        if holds { self } else { Self::NONE }
    }
}

impl BitOr for Statusword {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Statusword {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_controlword_is_one_command() {
        let before = Controlword(0);
        for word in 0..=u16::MAX {
            let bits = word & 0x8F;
            let expected = match bits {
                0x80.. => Command::FaultReset,
                _ if bits & 0x2 == 0 => Command::DisableVoltage,
                _ if bits & 0x4 == 0 => Command::QuickStop,
                0x6 | 0xE => Command::Shutdown,
                0x7 => Command::SwitchOn,
                _ => Command::EnableOperation,
            };
            assert_eq!(Controlword(word).command(before), expected, "{word:04X}h");
        }
    }

    #[test]
    fn fault_reset_is_an_edge() {
        assert_eq!(Controlword(0x80).command(Controlword(0x0F)), Command::FaultReset);
        assert_eq!(Controlword(0x8F).command(Controlword(0x80)), Command::EnableOperation);
    }
}
