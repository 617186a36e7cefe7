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

use crate::drive::{Command, Direction, Mode, Motor, Operation, State, Status};
use crate::ppo::{Stw, Zsw};

/// The bits of STW that have a meaning; STW.2 only by a quirk (C-21).
pub const EVALUATED: u16 = 0x83FB;

/// Where the manuals leave the bits open; each is off by default (`ag03.md` 15).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// C-03: ZSW.14 is 1 in velocity mode, not 0.
    pub velocity_bit_14: bool,
    /// C-05: a paused job counts as active positioning: not ready-to-travel (ZSW.15 = 0, SSW.14 = 1).
    pub paused_is_active: bool,
    /// C-06: turn-on disabled is left only by a change of STW.0 from 1 to 0, not by its being 0.
    pub off1_needs_edge: bool,
    /// C-07: ZSW.12 takes the level of STW.6 when a job is accepted, instead of toggling.
    pub acknowledge_mirrors_start: bool,
    /// C-09: ready to turn on (ZSW.0, ZSW.1) is 0 in fault and turn-on disabled.
    pub not_ready_in_fault: bool,
    /// C-18: PNU 945 lists the oldest fault first.
    pub oldest_fault_first: bool,
    /// C-21, C-37: STW.2 = 1 takes operation enabled away instead of being ignored.
    pub bit_2_must_be_0: bool,
    /// C-23: OFF1 brakes with maximum deceleration and then releases the motor, instead of releasing at once.
    pub off1_brakes: bool,
    /// C-24: OFF1, OFF2 and disable together (STW = 0) brake with maximum deceleration and then release.
    pub all_zero_brakes: bool,
    /// C-32: only a change of STW.6 from 0 to 1 starts a travel job.
    pub start_needs_rising_edge: bool,
    /// C-35: target reached (ZSW.10) follows the position window during a job too.
    pub target_reached_live: bool,
    /// C-36: STW.0 = 0 must be seen once in Data_Exchange before operation can be enabled.
    pub off1_must_be_seen: bool,
}

/// The control word of a drive and what it remembers of the one before; the status word that goes with it.
///
/// Once per application cycle: [`command`](Self::command), the drive's step, [`accept`](Self::accept).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Words {
    quirks: Quirks,
    /// The newest control word; 0 outside Data_Exchange.
    stw: Stw,
    /// OFF1 was given in this Data_Exchange.
    off1_seen: bool,
    /// As the drive counted them last.
    jobs: u8,
    /// ZSW.12.
    acknowledge: bool,
}

impl Words {
    /// Nothing was said yet.
    pub fn new(quirks: Quirks) -> Self {
        Self { quirks, ..Self::default() }
    }

    /// The newest control word; 0 outside Data_Exchange.
    pub const fn stw(&self) -> Stw {
        self.stw
    }

    /// Whether enabling waits for STW.0 = 0 (C-36).
    pub const fn awaits_off1(&self) -> bool {
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
        let before = core::mem::replace(&mut self.stw, stw);
        self.off1_seen = outputs.is_some() && (self.off1_seen || !stw.bit(0));
        let operation = self.operation();
        let start = stw.bit(6);
        let edge = start != before.bit(6) && (start || !self.quirks.start_needs_rising_edge);
        Command {
            operation,
            enable: stw.bit(3) && !before.bit(3),
            // A falling edge on the way to OFF is none.
            travel: edge && (start || operation == Operation::Run),
            turn: start,
            setpoint,
            stop: !stw.bit(4),
            pause: !stw.bit(5),
            inch_1: stw.bit(8),
            inch_2: stw.bit(9).then_some(if stw.bit(15) { Direction::Negative } else { Direction::Positive }),
            acknowledge: stw.bit(7),
            rearm: !stw.bit(0) && (before.bit(0) || !self.quirks.off1_needs_edge),
            keys: outputs.is_none(),
        }
    }

    /// What bits 0 to 3 ask of the motor (rows 4 to 8).
    fn operation(&self) -> Operation {
        let Quirks { bit_2_must_be_0, off1_brakes, all_zero_brakes, .. } = self.quirks;
        let (on, no_off2) = (self.stw.bit(0), self.stw.bit(1));
        let enable = self.stw.bit(3) && !(bit_2_must_be_0 && self.stw.bit(2));
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
            self.acknowledge = if self.quirks.acknowledge_mirrors_start { self.stw.bit(6) } else { toggled };
        }
    }

    /// The status word.
    pub fn zsw(&self, status: &Status) -> Zsw {
        let status = &self.shown(status);
        let positioning = status.mode == Mode::Positioning;
        let beyond = status.above_upper_limit || status.below_lower_limit;
        word([
            status.supply_ok,
            status.supply_ok,
            status.operation_enabled,
            status.fault.is_some(),
            self.stw.bit(1),
            true,
            status.turn_on_disabled,
            status.warning,
            if positioning { !status.lag_error } else { status.in_window },
            true,
            if positioning { status.target_reached } else { true },
            true,
            if positioning { self.acknowledge } else { true },
            status.standstill,
            beyond || !positioning && self.quirks.velocity_bit_14,
            status.ready_to_travel,
        ])
    }

    /// The system status word SSW, PNU 1020.
    pub fn system_status(&self, status: &Status) -> u16 {
        system_status(&self.shown(status))
    }

    /// The status as the quirks let the words show it.
    fn shown(&self, status: &Status) -> Status {
        let Quirks { paused_is_active, not_ready_in_fault, target_reached_live, .. } = self.quirks;
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
pub fn hiw(status: &Status) -> i32 {
    match status.mode {
        Mode::Positioning => status.position,
        Mode::Velocity => status.velocity,
    }
}

/// The bits of the system status word, the same on every bus.
fn system_status(status: &Status) -> u16 {
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
mod tests;
