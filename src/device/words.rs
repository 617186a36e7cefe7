//! The words of bits on the bus, from and to what the drive knows: STW is taken apart, ZSW, SSW and the general status
//! register are put together. Which bit is where, and what it means, is in [`bits`](super::bits).
//!
//! Sources: manual tables 11 to 14 and 1 (`docs/reference/ag03.md` 4, 5 and 6).

use super::bits::{GeneralStatusBit, SswBit, StwBit, ZswBit};
use crate::drive::{Command, Mode, Motor, Status};
use crate::ppo::{Stw, Zsw};

/// Where the manuals leave the bits open; each is off by default (`ag03.md` 15).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// ZSW.14 is 1 in velocity mode, not 0 (C-03).
    pub velocity_bit_14: bool,
    /// STW.2 = 1 takes operation enabled away instead of being ignored (C-21, C-37).
    pub bit_2_must_be_0: bool,
}

impl Quirks {
    /// [`command`] with these quirks.
    pub fn command(self, stw: Stw, hsw: i32) -> Command {
        let command = command(stw, hsw);
        let forbidden = self.bit_2_must_be_0 && StwBit::Off3.is_set(stw);
        Command { enable_operation: command.enable_operation && !forbidden, ..command }
    }

    /// [`zsw`] with these quirks.
    pub fn zsw(self, status: &Status) -> Zsw {
        let bit_14 = self.velocity_bit_14 && status.mode == Mode::Velocity;
        Zsw::from_raw(zsw(status).raw() | ZswBit::LimitExceeded.when(bit_14))
    }
}

/// What the control word and the setpoint ask of the drive.
pub fn command(stw: Stw, hsw: i32) -> Command {
    Command {
        on: StwBit::On.is_set(stw),
        no_off2: StwBit::NoOff2.is_set(stw),
        enable_operation: StwBit::EnableOperation.is_set(stw),
        no_stop: StwBit::NoStop.is_set(stw),
        no_intermediate_stop: StwBit::NoIntermediateStop.is_set(stw),
        start: StwBit::Start.is_set(stw),
        acknowledge: StwBit::Acknowledge.is_set(stw),
        inch_1: StwBit::Inching1.is_set(stw),
        inch_2: StwBit::Inching2.is_set(stw),
        inch_2_negative: StwBit::Inching2Negative.is_set(stw),
        setpoint: hsw,
    }
}

/// The status word of a drive.
pub fn zsw(status: &Status) -> Zsw {
    let positioning = status.mode == Mode::Positioning;
    Zsw::from_raw(
        ZswBit::ReadyToTurnOn.when(status.supply_ok)
            | ZswBit::Ready.when(status.supply_ok)
            | ZswBit::OperationEnabled.when(status.operation_enabled)
            | ZswBit::Fault.when(status.fault.is_some())
            | ZswBit::NoOff2.when(status.no_off2)
            | ZswBit::NoOff3.mask()
            | ZswBit::TurnOnDisabled.when(status.turn_on_disabled)
            | ZswBit::Warning.when(status.warning)
            | ZswBit::NoLagError.when(if positioning { !status.lag_error } else { status.in_window })
            | ZswBit::ControlRequested.mask()
            | ZswBit::TargetReached.when(if positioning { status.target_reached } else { true })
            | ZswBit::ReferencePointSet.mask()
            | ZswBit::JobToggle.when(if positioning { status.job_acknowledge } else { true })
            | ZswBit::Standstill.when(status.standstill)
            | ZswBit::LimitExceeded.when(status.above_upper_limit || status.below_lower_limit)
            | ZswBit::ReadyToTravel.when(status.ready_to_travel),
    )
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
    SswBit::InPosition.when(status.in_window)
        | SswBit::Travels.when(status.travelling)
        | SswBit::AboveUpperLimit.when(status.above_upper_limit)
        | SswBit::BelowLowerLimit.when(status.below_lower_limit)
        | SswBit::MotorReleased.when(status.motor == Motor::Released)
        | SswBit::Fault.when(status.fault.is_some())
        | SswBit::LoopTravel.when(status.approach_reversed)
        | SswBit::NoOutputStage.when(!status.output_stage_ok)
        | SswBit::NotReadyToTravel.when(!status.start_conditions_met)
        | SswBit::BatteryLow.when(status.battery_low)
        | SswBit::CurrentOutOfRange.when(status.current_out_of_range)
        | SswBit::PositioningActive.when(status.positioning_active)
        | SswBit::LagError.when(status.lag_error)
}

/// The general status register, PNU 1031: enable input (AG03) or output stage supply (AG03/1), and whether the torque
/// deactivation has tripped.
pub fn general_status(status: &Status) -> u16 {
    GeneralStatusBit::OutputStage.when(status.output_stage_ok)
        | GeneralStatusBit::TorqueDeactivation.when(status.torque_tripped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::bits::Word;

    #[test]
    fn bits_without_a_meaning_ask_for_nothing_and_every_other_bit_for_something() {
        for stw in 0..=u16::MAX {
            let meaning = stw & !Word::Stw.without_meaning(Mode::Positioning);
            assert_eq!(command(Stw::from_raw(stw), 7), command(Stw::from_raw(meaning), 7));
        }
        let none = command(Stw::from_raw(0), 7);
        for bit in StwBit::ALL.iter().filter(|bit| **bit != StwBit::Off3) {
            assert_ne!(command(Stw::from_raw(bit.mask()), 7), none, "{bit:?}");
        }
    }
}
