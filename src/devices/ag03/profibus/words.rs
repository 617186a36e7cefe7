//! The words of bits on the bus, from and to what the drive knows: STW is taken apart, ZSW, SSW and the general status
//! register are put together. Which bit is where, and what it means, is in [`bits`](super::bits).
//!
//! Sources: manual tables 11 to 14 and 1 (`docs/reference/ag03.md` 4, 5 and 6).

use super::bits::{GeneralStatusBit, SswBit, StwBit, ZswBit};
use crate::devices::ag03::drive::{Command, Direction, Mode, Motor, Operation, State, Status};
use crate::profibus::ppo::{Stw, Zsw};

/// Where the manuals leave the bits open; each is off by default (`ag03.md` 15).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WordQuirks {
    /// ZSW.14 is 1 in velocity mode, not 0 (C-03).
    pub velocity_bit_14: bool,
    /// A paused job counts as active positioning: not ready-to-travel (ZSW.15 = 0, SSW.14 = 1) (C-05).
    pub paused_is_active: bool,
    /// Turn-on disabled is left only by a change of STW.0 from 1 to 0, not by its being 0 (C-06).
    pub off1_needs_edge: bool,
    /// ZSW.12 takes the level of STW.6 when a job is accepted, instead of toggling (C-07).
    pub acknowledge_mirrors_start: bool,
    /// Ready to turn on (ZSW.0, ZSW.1) is 0 in fault and turn-on disabled (C-09).
    pub not_ready_in_fault: bool,
    /// PNU 945 lists the oldest fault first (C-18).
    pub oldest_fault_first: bool,
    /// STW.2 = 1 takes operation enabled away instead of being ignored (C-21, C-37).
    pub bit_2_must_be_0: bool,
    /// OFF1 brakes with maximum deceleration and then releases the motor, instead of releasing at once (C-23).
    pub off1_brakes: bool,
    /// OFF1, OFF2 and disable together (STW = 0) brake with maximum deceleration and then release (C-24).
    pub all_zero_brakes: bool,
    /// Only a change of STW.6 from 0 to 1 starts a travel job (C-32).
    pub start_needs_rising_edge: bool,
    /// Target reached (ZSW.10) follows the position window during a job too (C-35).
    pub target_reached_live: bool,
    /// STW.0 = 0 must be seen once in Data_Exchange before operation can be enabled (C-36).
    pub off1_must_be_seen: bool,
}

/// The control word of a drive and what it remembers of the one before; the status word that goes with it.
///
/// Once per application cycle: [`command`](Self::command), the drive's step, [`accept`](Self::accept).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Words {
    quirks: WordQuirks,
    /// The newest control word; 0 outside Data_Exchange.
    stw: Stw,
    /// What that came with; `None`: outside Data_Exchange.
    outputs: Option<(Stw, i32)>,
    /// They were the same the time before.
    repeated: bool,
    /// OFF1 was given in this Data_Exchange.
    off1_seen: bool,
    /// As the drive counted them last.
    jobs: u8,
    /// ZSW.12.
    acknowledge: bool,
}

/// Bits 0, 1 and 3: what operation needs.
const OPERATION: u16 = StwBit::On.mask() | StwBit::NoOff2.mask() | StwBit::EnableOperation.mask();

/// Whether a control word asks for operation that the one before did not ask for: by bit 3, or by all that it needs.
const fn asks_operation(stw: Stw, before: Stw) -> bool {
    let rose = stw.raw() & !before.raw() & OPERATION;
    rose & StwBit::EnableOperation.mask() != 0 || rose != 0 && stw.raw() & OPERATION == OPERATION
}

impl Words {
    /// Nothing was said yet.
    pub(crate) fn new(quirks: WordQuirks) -> Self {
        Self { quirks, ..Self::default() }
    }

    /// The newest control word; 0 outside Data_Exchange.
    pub(crate) const fn stw(&self) -> Stw {
        self.stw
    }

    /// Whether the newest control word is OFF1 as masters of the profile give it before ON: every other condition of
    /// operation is given, and bit 2, which is no OFF3 there, or no stop of any kind, as the manual has it. It asks for nothing.
    pub(super) const fn rests(&self) -> bool {
        let off3 = OPERATION | StwBit::Off3.mask();
        let stops = OPERATION | StwBit::NoStop.mask() | StwBit::NoIntermediateStop.mask();
        let word = self.stw.raw();
        word & off3 == off3 & !StwBit::On.mask() || word & stops == stops & !StwBit::On.mask()
    }

    /// Whether enabling waits for STW.0 = 0 (C-36).
    pub(crate) const fn awaits_off1(&self) -> bool {
        self.quirks.off1_must_be_seen && !self.off1_seen
    }

    /// Whether PNU 945 lists the oldest fault first (C-18).
    pub(super) const fn oldest_fault_first(&self) -> bool {
        self.quirks.oldest_fault_first
    }

    /// What the newest control word and setpoint ask of the drive; `None`: outside Data_Exchange, which acts as all-zero
    /// (row 50) and frees the keys (row 52).
    pub fn command(&mut self, outputs: Option<(Stw, i32)>) -> Command {
        let (stw, setpoint) = outputs.unwrap_or_default();
        self.repeated = core::mem::replace(&mut self.outputs, outputs) == outputs;
        let before = core::mem::replace(&mut self.stw, stw);
        self.off1_seen = outputs.is_some() && (self.off1_seen || !StwBit::On.is_set(stw));
        let operation = self.operation();
        let start = StwBit::Start.is_set(stw);
        let edge = start != StwBit::Start.is_set(before) && (start || !self.quirks.start_needs_rising_edge);
        Command {
            operation,
            enable: asks_operation(stw, before),
            // A falling edge on the way to OFF is none.
            travel: edge && (start || operation == Operation::Run),
            turn: start,
            setpoint,
            stop: !StwBit::NoStop.is_set(stw),
            pause: !StwBit::NoIntermediateStop.is_set(stw),
            inch_1: StwBit::Inching1.is_set(stw),
            inch_2: StwBit::Inching2.is_set(stw).then_some(if StwBit::Inching2Negative.is_set(stw) {
                Direction::Negative
            } else {
                Direction::Positive
            }),
            acknowledge: StwBit::Acknowledge.is_set(stw),
            rearm: !StwBit::On.is_set(stw) && (StwBit::On.is_set(before) || !self.quirks.off1_needs_edge),
            keys: outputs.is_none(),
        }
    }

    /// Whether these outputs ask what the last [`command`](Self::command) asked: the third time and each time after
    /// that, when no edge is left in it.
    #[inline]
    pub(super) fn is_held(&self, outputs: Option<(Stw, i32)>) -> bool {
        self.repeated && self.outputs == outputs
    }

    /// What bits 0 to 3 ask of the motor (rows 4 to 8).
    fn operation(&self) -> Operation {
        let WordQuirks { bit_2_must_be_0, off1_brakes, all_zero_brakes, .. } = self.quirks;
        let (on, no_off2) = (StwBit::On.is_set(self.stw), StwBit::NoOff2.is_set(self.stw));
        let enable =
            StwBit::EnableOperation.is_set(self.stw) && !(bit_2_must_be_0 && StwBit::Off3.is_set(self.stw));
        match (no_off2, on, enable) {
            (false, false, false) if all_zero_brakes => Operation::BrakeAndRelease,
            (false, _, _) => Operation::Release,
            (true, false, _) if off1_brakes => Operation::BrakeAndRelease,
            (true, false, _) => Operation::Release,
            (true, true, true) if !self.awaits_off1() => Operation::Run,
            (true, true, _) => Operation::BrakeAndHold,
        }
    }

    /// Takes note of what the step has made of the command: ZSW.12 changes with each accepted job (C-07).
    pub fn accept(&mut self, status: &Status) {
        if status.jobs != self.jobs {
            self.jobs = status.jobs;
            let toggled = !self.acknowledge;
            self.acknowledge =
                if self.quirks.acknowledge_mirrors_start { StwBit::Start.is_set(self.stw) } else { toggled };
        }
    }

    /// The status word.
    pub fn zsw(&self, status: &Status) -> Zsw {
        let status = &self.shown(status);
        let positioning = status.mode == Mode::Positioning;
        let beyond = status.above_upper_limit || status.below_lower_limit;
        Zsw::from_raw(
            ZswBit::ReadyToTurnOn.when(status.supply_ok)
                | ZswBit::Ready.when(status.supply_ok)
                | ZswBit::OperationEnabled.when(status.operation_enabled)
                | ZswBit::Fault.when(status.fault.is_some())
                | ZswBit::NoOff2.when(StwBit::NoOff2.is_set(self.stw))
                | ZswBit::NoOff3.mask()
                | ZswBit::TurnOnDisabled.when(status.turn_on_disabled)
                | ZswBit::Warning.when(status.warning)
                | ZswBit::NoLagError.when(if positioning { !status.lag_error } else { status.in_window })
                | ZswBit::ControlRequested.mask()
                | ZswBit::TargetReached.when(!positioning || status.target_reached)
                | ZswBit::ReferencePointSet.mask()
                | ZswBit::JobToggle.when(!positioning || self.acknowledge)
                | ZswBit::Standstill.when(status.standstill)
                | ZswBit::LimitExceeded.when(beyond || !positioning && self.quirks.velocity_bit_14)
                | ZswBit::ReadyToTravel.when(status.ready_to_travel),
        )
    }

    /// The system status word SSW, PNU 1020.
    pub(crate) fn system_status(&self, status: &Status) -> u16 {
        system_status(&self.shown(status))
    }

    /// The status as the quirks let the words show it.
    fn shown(&self, status: &Status) -> Status {
        let WordQuirks { paused_is_active, not_ready_in_fault, target_reached_live, .. } = self.quirks;
        let paused = paused_is_active && matches!(status.state, State::Pausing { .. } | State::Paused { .. });
        let in_fault = not_ready_in_fault && matches!(status.state, State::Fault | State::TurnOnDisabled);
        let live = target_reached_live && status.in_window && status.setpoint_programmed;
        Status {
            supply_ok: status.supply_ok && !in_fault,
            target_reached: status.target_reached || live,
            positioning_active: status.positioning_active || paused,
            start_conditions_met: status.start_conditions_met && !paused,
            ready_to_travel: status.ready_to_travel && !paused,
            ..*status
        }
    }
}

/// The actual value HIW: position in positioning mode, velocity in rpm in velocity mode.
pub(crate) fn hiw(status: &Status) -> i32 {
    match status.mode {
        Mode::Positioning => status.position,
        Mode::Velocity => status.velocity,
    }
}

/// The bits of the system status word, the same on every bus.
fn system_status(status: &Status) -> u16 {
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
pub(crate) fn general_status(status: &Status) -> u16 {
    GeneralStatusBit::OutputStage.when(status.output_stage_ok)
        | GeneralStatusBit::TorqueDeactivation.when(status.torque_tripped)
}

#[cfg(test)]
mod tests;
