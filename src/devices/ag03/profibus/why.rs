//! Everything that keeps a drive from moving now, the most important first, and the control words to send.

use core::fmt;

use super::bits::StwBit;
use super::refusal::{self, Bit, Next};
use super::{APPLICATION, Device, Power};
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Mode, State};
use crate::devices::ag03::why::of_power;
use crate::devices::reasons;
use crate::face::{Reason, Why};
use crate::profibus::dp;
use crate::profibus::ppo;

impl Device {
    /// Tells what stands against another start now, whether or not it moves: an active travel job does, too.
    pub(crate) fn each_against_start(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        of_power(self.power(), tell);
        if self.power() != Power::On {
            return;
        }
        if self.at_126() {
            let text = "there is no Data_Exchange at address 126: set another address with SW1 to SW7 and switch off and on";
            tell(Reason::new("AddressNotSet", &text));
        } else {
            let slave = self.slave();
            let advice = APPLICATION.cfg_advice;
            reasons::of_slave(slave, advice, tell);
        }
        self.each_of_drive(tell);
    }

    /// Tells what the drive itself has against a start.
    fn each_of_drive(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        // Outside Data_Exchange the control word counts as 0.
        let exchanging = self.dp_state() == dp::State::DataExch;
        if let Some(start) = self.start_refusal() {
            for reason in start.reasons().filter(|reason| exchanging || !is_of_word(*reason)) {
                match reason {
                    refusal::Reason::Drive(drive::Reason::FaultLatched) => {
                        let text = Latched { refusal: start.drive, present: self.cause_present() };
                        tell(Reason::new(reason.name(), &text));
                    }
                    refusal::Reason::Off2
                    | refusal::Reason::Off1
                    | refusal::Reason::Off1NotSeen
                    | refusal::Reason::Drive(_) => {
                        tell(Reason::new(reason.name(), &start.text(reason)));
                    }
                }
            }
        }
    }

    /// Tells what keeps a drive in velocity mode from turning that would accept a setpoint.
    fn each_of_setpoint(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        if self.dp_state() != dp::State::DataExch || self.status().mode != Mode::Velocity {
            return;
        }
        if !StwBit::Start.is_set(self.commanded()) {
            tell(Reason::new(
                "NotReleased",
                &format_args!("the velocity setpoint is not released ({} = 0)", Bit(StwBit::Start)),
            ));
        }
        let outputs = self.slave().outputs().first_chunk().map(ppo::Outputs::new);
        if outputs.is_none_or(|outputs| outputs.hsw() == 0) {
            tell(Reason::new("SetpointZero", &"the velocity setpoint is 0 (HSW): send another"));
        }
    }

    /// Whether a start would lead nowhere.
    fn is_at_setpoint(&self) -> bool {
        let outputs = self.slave().outputs().first_chunk().map(ppo::Outputs::new);
        let is_there = outputs.is_some_and(|outputs| outputs.hsw() == self.status().position);
        self.dp_state() == dp::State::DataExch && is_there
    }

    /// At the address of stations that have none there is no Data_Exchange.
    fn at_126(&self) -> bool {
        self.address() == dp::StoredAddress::DELIVERED.address
    }

    fn cause_present(&self) -> bool {
        self.status().fault.is_some() && !self.drive().causes().is_empty()
    }

    fn travels(&self) -> bool {
        let status = self.status();
        status.moving && (status.positioning_active || status.state == State::VelocityTravelling)
    }
}

impl Why for Device {
    fn is_moving(&self) -> Option<bool> {
        Some(self.travels())
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        if !self.travels() {
            self.each_against_start(tell);
            self.each_of_setpoint(tell);
        }
    }

    fn next(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        let reached = self.power() == Power::On && !self.at_126() && !self.slave().diagnosis().sync_mode;
        if !reached || self.travels() {
            return;
        }
        let stw = self.commanded();
        match self.start_refusal() {
            Some(start) => {
                let next = start.next_with(!self.cause_present());
                next.iter().for_each(|next: &Next| say(next));
            }
            None if self.status().mode == Mode::Velocity && StwBit::Start.is_set(stw) => {}
            None => say(&format_args!("send STW {:04X}", stw.raw() ^ StwBit::Start.mask())),
        }
    }

    fn waits(&self) -> Option<&dyn fmt::Display> {
        Some(match self.status().mode {
            Mode::Positioning if self.is_at_setpoint() => &AtSetpoint,
            Mode::Positioning => &WaitsForStart,
            Mode::Velocity => &"nothing keeps it from turning",
        })
    }
}

/// Whether it comes from the control word alone.
const fn is_of_word(reason: refusal::Reason) -> bool {
    match reason {
        refusal::Reason::Off2 | refusal::Reason::Off1 | refusal::Reason::Off1NotSeen => true,
        refusal::Reason::Drive(reason) => matches!(
            reason,
            drive::Reason::NotAsked
                | drive::Reason::NotEnabled
                | drive::Reason::Stop
                | drive::Reason::IntermediateStop
        ),
    }
}

/// A latched fault, and what to do about it as long as its cause is present or when it is gone.
struct Latched {
    refusal: drive::Refusal,
    present: bool,
}

impl fmt::Display for Latched {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fault = self.refusal.text(drive::Reason::FaultLatched);
        let (cause, then) = match self.present {
            true => ("present", "remove it, then acknowledge"),
            false => ("gone", "acknowledge"),
        };
        write!(f, "{fault}, its cause is {cause}: {then} ({} from 0 to 1)", Bit(StwBit::Acknowledge))
    }
}

struct WaitsForStart;

impl fmt::Display for WaitsForStart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "it waits for a start: each change of {} starts a travel job", Bit(StwBit::Start))
    }
}

struct AtSetpoint;

impl fmt::Display for AtSetpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let start = Bit(StwBit::Start);
        write!(
            f,
            "the shaft is at its setpoint (HSW): give another, then change {start} to start a travel job"
        )
    }
}
