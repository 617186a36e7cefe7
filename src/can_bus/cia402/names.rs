//! What the bits of the words are called, by mode of operation; empty for a bit that CiA 402 leaves to the device or keeps
//! for later.

use super::mode::Mode;
use super::words::{Controlword, Statusword};

impl Controlword {
    /// The names of the bits, bit 0 first. Without a mode those of the mode have none.
    pub(crate) const fn names(mode: Option<Mode>) -> [&'static str; 16] {
        let [four, five, six] = match mode {
            Some(Mode::ProfilePosition) => ["new set-point", "change set immediately", "relative"],
            Some(Mode::Homing) => ["homing operation start", "", ""],
            Some(Mode::InterpolatedPosition) => ["enable interpolation", "", ""],
            Some(Mode::ProfileVelocity | Mode::ProfileTorque) | None => ["", "", ""],
        };
        [
            "switch on",
            "enable voltage",
            "no quick stop",
            "enable operation",
            four,
            five,
            six,
            "fault reset",
            "halt",
            "",
            "",
            "",
            "",
            "",
            "",
            "",
        ]
    }
}

impl Statusword {
    /// The names of the bits, bit 0 first. Without a mode those of the mode have none.
    pub(crate) const fn names(mode: Option<Mode>) -> [&'static str; 16] {
        let [twelve, thirteen] = match mode {
            Some(Mode::ProfilePosition) => ["set-point acknowledge", "following error"],
            Some(Mode::Homing) => ["homing attained", "homing error"],
            Some(Mode::InterpolatedPosition) => ["interpolation active", ""],
            Some(Mode::ProfileVelocity) => ["speed is zero", "maximum slippage"],
            Some(Mode::ProfileTorque) | None => ["", ""],
        };
        [
            "ready to switch on",
            "switched on",
            "operation enabled",
            "fault",
            "voltage enabled",
            "no quick stop",
            "switch on disabled",
            "warning",
            "",
            "remote",
            "target reached",
            "internal limit active",
            twelve,
            thirteen,
            "",
            "",
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(control[mask.trailing_zeros() as usize], name);
        }
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
