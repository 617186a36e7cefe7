//! Every bit position of STW, ZSW, SSW and the general status register, once.
//!
//! ```text
//! STW   positioning                  velocity            ZSW   positioning                velocity
//!  0    ON / OFF1                    same                 0    ready to turn on           same
//!  1    no OFF2                      same                 1    ready, = bit 0             same
//!  2    not evaluated (C-21)         same                 2    operation enabled          same
//!  3    enable operation             same                 3    fault                      same
//!  4    0 = stop                     -                    4    no OFF2 = STW.1            same
//!  5    0 = intermediate stop        -                    5    1                          same
//!  6    edge: start travel job       setpoint released    6    turn-on disabled           same
//!  7    edge: acknowledge            same                 7    warning                    same
//!  8    inching 1                    -                    8    no lag error               velocity in window
//!  9    inching 2                    -                    9    1                          1
//! 10    -                            -                   10    target position reached    1
//! 11    -                            -                   11    1                          1
//! 12    -                            -                   12    toggles per accepted job   1
//! 13    -                            -                   13    stands still               stands still
//! 14    -                            -                   14    beyond a limit             0 (C-03)
//! 15    inching 2 negative           -                   15    ready to travel            ready to travel
//! ```
//!
//! Sources: manual tables 11 to 14 and 1, `ag03.md` 4, 5 and 6.

use crate::drive::{Command, Mode, Motor, Status};
use crate::ppo::{Stw, Zsw};

/// Where the manuals leave the bits open; each is off by default (`ag03.md` 15).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// C-03: ZSW.14 is 1 in velocity mode, not 0.
    pub velocity_bit_14: bool,
    /// C-21, C-37: STW.2 = 1 takes operation enabled away instead of being ignored.
    pub bit_2_must_be_0: bool,
}

impl Quirks {
    /// [`command`] with these quirks.
    pub fn command(self, stw: Stw, hsw: i32) -> Command {
        let command = command(stw, hsw);
        let forbidden = self.bit_2_must_be_0 && stw.bit(2);
        Command { enable_operation: command.enable_operation && !forbidden, ..command }
    }

    /// [`zsw`] with these quirks.
    pub fn zsw(self, status: &Status) -> Zsw {
        let bit_14 = self.velocity_bit_14 && status.mode == Mode::Velocity;
        Zsw::from_raw(zsw(status).raw() | u16::from(bit_14) << 14)
    }
}

/// What the control word and the setpoint ask of the drive.
pub fn command(stw: Stw, hsw: i32) -> Command {
    Command {
        on: stw.bit(0),
        no_off2: stw.bit(1),
        enable_operation: stw.bit(3),
        no_stop: stw.bit(4),
        no_intermediate_stop: stw.bit(5),
        start: stw.bit(6),
        acknowledge: stw.bit(7),
        inch_1: stw.bit(8),
        inch_2: stw.bit(9),
        inch_2_negative: stw.bit(15),
        setpoint: hsw,
    }
}

/// The status word of a drive.
pub fn zsw(status: &Status) -> Zsw {
    let positioning = status.mode == Mode::Positioning;
    word([
        status.supply_ok,
        status.supply_ok,
        status.operation_enabled,
        status.fault.is_some(),
        status.no_off2,
        true,
        status.turn_on_disabled,
        status.warning,
        if positioning { !status.lag_error } else { status.in_window },
        true,
        if positioning { status.target_reached } else { true },
        true,
        if positioning { status.job_acknowledge } else { true },
        status.standstill,
        status.above_upper_limit || status.below_lower_limit,
        status.ready_to_travel,
    ])
}

/// The actual value HIW: position in positioning mode, velocity in rpm in velocity mode.
pub fn hiw(status: &Status) -> i32 {
    match status.mode {
        Mode::Positioning => status.position,
        Mode::Velocity => status.velocity,
    }
}

/// The system status word SSW, PNU 1020.
pub fn system_status(status: &Status) -> u16 {
    word([
        false,
        false,
        false,
        status.in_window,
        status.travelling,
        status.above_upper_limit,
        status.below_lower_limit,
        status.motor == Motor::Released,
        status.fault.is_some(),
        status.approach_reversed,
        !status.output_stage_ok,
        !status.start_conditions_met,
        status.battery_low,
        status.current_out_of_range,
        status.positioning_active,
        status.lag_error,
    ])
    .raw()
}

/// The general status register, PNU 1031: bit 4 enable input (AG03) or output stage supply (AG03/1), bit 7
/// torque deactivation has tripped.
pub fn general_status(status: &Status) -> u16 {
    u16::from(status.output_stage_ok) << 4 | u16::from(status.torque_tripped) << 7
}

/// The word with these bits, bit 0 first.
fn word(bits: [bool; 16]) -> Zsw {
    Zsw::from_raw(bits.iter().rev().fold(0, |word, bit| word << 1 | u16::from(*bit)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_without_a_meaning_ask_for_nothing_and_every_other_bit_for_something() {
        for stw in 0..=u16::MAX {
            let meaning = stw & !0x7C04;
            assert_eq!(command(Stw::from_raw(stw), 7), command(Stw::from_raw(meaning), 7));
        }
        let none = command(Stw::from_raw(0), 7);
        for bit in [0, 1, 3, 4, 5, 6, 7, 8, 9, 15] {
            assert_ne!(command(Stw::from_raw(1 << bit), 7), none, "STW.{bit}");
        }
    }
}
