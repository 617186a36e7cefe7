//! Each bit of the words, once.

use core::ops::{BitOr, BitOrAssign};

use super::mode::Mode;
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
    /// Whether all bits of `mask` are set.
    pub(crate) const fn has(self, mask: Self) -> bool {
        self.0 & mask.0 == mask.0
    }

    /// Whether the bits of `mask` are set now and were not `before`.
    pub(crate) const fn rises(self, before: Self, mask: Self) -> bool {
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

/// The bits of a word, each once: its constant, its number and its name, of one mode of operation or of all.
macro_rules! bits {
    ($word:ident { $($bit:ident = $n:literal: $name:literal $(in $mode:ident)? $(, $other:literal in $of:ident)*;)* }) => {
        impl $word {
            $(
                #[doc = concat!("Bit ", $n, ": ", $name, ".")]
                pub const $bit: Self = Self(1 << $n);
            )*

            /// The names of the bits, bit 0 first; empty for a bit that CiA 402 leaves to the device or keeps for later, and,
            /// without a mode, for those of the mode.
            pub(crate) fn names(mode: Option<Mode>) -> [&'static str; 16] {
                let mut names = [""; 16];
                $(
                    if true $(&& mode == Some(Mode::$mode))? {
                        names[$n] = $name;
                    }
                    $(
                        if mode == Some(Mode::$of) {
                            names[$n] = $other;
                        }
                    )*
                )*
                names
            }
        }
    };
}

bits! { Controlword {
    SWITCH_ON = 0: "switch on";
    ENABLE_VOLTAGE = 1: "enable voltage";
    QUICK_STOP = 2: "no quick stop";
    ENABLE_OPERATION = 3: "enable operation";
    NEW_SET_POINT = 4: "new set-point" in ProfilePosition, "homing operation start" in Homing,
        "enable interpolation" in InterpolatedPosition, "enable ramp" in Velocity;
    CHANGE_IMMEDIATELY = 5: "change set immediately" in ProfilePosition, "unlock ramp" in Velocity;
    RELATIVE = 6: "relative" in ProfilePosition, "reference ramp" in Velocity;
    FAULT_RESET = 7: "fault reset";
    HALT = 8: "halt";
} }

bits! { Statusword {
    READY_TO_SWITCH_ON = 0: "ready to switch on";
    SWITCHED_ON = 1: "switched on";
    OPERATION_ENABLED = 2: "operation enabled";
    FAULT = 3: "fault";
    VOLTAGE_ENABLED = 4: "voltage enabled";
    QUICK_STOP = 5: "no quick stop";
    SWITCH_ON_DISABLED = 6: "switch on disabled";
    WARNING = 7: "warning";
    REMOTE = 9: "remote";
    TARGET_REACHED = 10: "target reached";
    INTERNAL_LIMIT = 11: "internal limit active";
    SET_POINT_ACKNOWLEDGE = 12: "set-point acknowledge" in ProfilePosition;
    HOMING_ATTAINED = 12: "homing attained" in Homing;
    IP_ACTIVE = 12: "interpolation active" in InterpolatedPosition;
    ZERO_SPEED = 12: "speed is zero" in ProfileVelocity;
    FOLLOWS_COMMAND = 12: "drive follows the command" in CyclicPosition, "drive follows the command" in CyclicVelocity,
        "drive follows the command" in CyclicTorque;
    FOLLOWING_ERROR = 13: "following error" in ProfilePosition, "maximum slippage" in ProfileVelocity,
        "following error" in CyclicPosition;
    HOMING_ERROR = 13: "homing error" in Homing;
} }

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

    #[test]
    fn a_name_stands_at_the_number_of_its_bit() {
        let control = Controlword::names(Some(Mode::ProfilePosition));
        for (mask, name) in [
            (Controlword::SWITCH_ON, "switch on"),
            (Controlword::NEW_SET_POINT, "new set-point"),
            (Controlword::RELATIVE, "relative"),
            (Controlword::FAULT_RESET, "fault reset"),
            (Controlword::HALT, "halt"),
        ] {
            assert_eq!(control[mask.0.trailing_zeros() as usize], name);
        }
        assert_eq!(Controlword::names(Some(Mode::Homing))[4], "homing operation start");
        assert_eq!(Controlword::names(None)[4], "");
        let status = Statusword::names(Some(Mode::ProfilePosition));
        for (mask, name) in [
            (Statusword::FAULT, "fault"),
            (Statusword::SWITCH_ON_DISABLED, "switch on disabled"),
            (Statusword::REMOTE, "remote"),
            (Statusword::INTERNAL_LIMIT, "internal limit active"),
            (Statusword::SET_POINT_ACKNOWLEDGE, "set-point acknowledge"),
            (Statusword::FOLLOWING_ERROR, "following error"),
        ] {
            assert_eq!(status[mask.0.trailing_zeros() as usize], name);
        }
    }
}
