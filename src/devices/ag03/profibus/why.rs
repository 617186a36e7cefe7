//! Everything that keeps a drive from moving now, the most important first, and the control words to send.

use core::fmt;

use super::bits::StwBit;
use super::refusal::Bit;
use super::{Device, Power, Reason, Refusal};
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Mode, State};
use crate::profibus::dp;
use crate::profibus::ppo::Stw;

// What the slave says, whichever drive is behind it.
pub(in crate::devices) const PRM_REFUSED: &str = "no master exchanges data with the drive, the last Set_Prm was refused (Slave_Diag \
    octet 1 bit 6, Prm_Fault): correct the master's project, the log says what is wrong";
pub(in crate::devices) const NOT_PARAMETERISED: &str = "no master exchanges data with the drive: it waits for Set_Prm; start the \
    master, check its station list and the rate of the line";
pub(in crate::devices) const NOT_CONFIGURED: &str =
    "no master exchanges data with the drive: it was parameterised and waits for Chk_Cfg";
pub(in crate::devices) const SYNC_HOLDS: &str =
    "Sync holds the outputs, new control words do not reach the drive: send Global_Control with Unsync";

/// Why a drive does not move ([`Device::why`]).
///
/// `Display` is one line: every hindrance, then the control words that help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Why {
    power: Power,
    dp: dp::State,
    prm_fault: bool,
    cfg_fault: bool,
    at_126: bool,
    sync: bool,
    mode: Mode,
    moving: bool,
    cause_present: bool,
    setpoint_zero: bool,
    stw: Stw,
    refusal: Option<Refusal>,
}

/// One thing that keeps the drive from moving.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Hindrance {
    /// The control has no supply.
    SwitchedOff,
    /// Switched on with the DIP switches of a factory reset.
    FactoryReset,
    /// At address 126 there is no Data_Exchange.
    AddressNotSet,
    /// The slave waits for Set_Prm.
    NoParameters {
        /// The last one was refused.
        refused: bool,
        /// The last Chk_Cfg was refused.
        cfg_refused: bool,
    },
    /// The slave waits for Chk_Cfg.
    NoConfiguration,
    /// Sync holds the outputs: new control words do not reach the drive.
    SyncHolds,
    /// What the drive itself has against a start.
    Drive(Reason),
    /// Velocity mode: the setpoint is not released.
    NotReleased,
    /// Velocity mode: the setpoint is 0.
    SetpointZero,
}

impl Device {
    /// Everything that keeps the drive from moving now.
    pub fn why(&self) -> Why {
        let diagnosis = self.slave().diagnosis();
        let status = self.status();
        let outputs = self.slave().outputs().first_chunk().map(crate::profibus::ppo::Outputs::new);
        Why {
            power: self.power(),
            dp: self.dp_state(),
            prm_fault: diagnosis.prm_fault,
            cfg_fault: diagnosis.cfg_fault,
            at_126: self.address() == dp::StoredAddress::DELIVERED.address,
            sync: diagnosis.sync_mode,
            mode: status.mode,
            moving: status.moving && (status.positioning_active || status.state == State::VelocityTravelling),
            cause_present: status.fault.is_some() && !self.drive().causes().is_empty(),
            setpoint_zero: outputs.is_none_or(|outputs| outputs.hsw() == 0),
            stw: self.commanded(),
            refusal: self.start_refusal(),
        }
    }
}

impl Why {
    /// Whether it moves, so that nothing keeps it from that.
    pub(crate) const fn is_moving(&self) -> bool {
        self.moving
    }

    /// What keeps it from moving, the most important first. None: it moves, or waits for a start.
    pub fn hindrances(&self) -> impl Iterator<Item = Hindrance> + use<> {
        let moving = self.moving;
        self.against_start().filter(move |_| !moving)
    }

    /// What stands against another start now, whether or not it moves: an active travel job does, too.
    pub(crate) fn against_start(&self) -> impl Iterator<Item = Hindrance> + use<> {
        let Self { power, dp, prm_fault, cfg_fault, at_126, sync, mode, .. } = *self;
        let on = power == Power::On;
        let waits_for_prm = on && !at_126 && dp == dp::State::WaitPrm;
        let velocity = on && mode == Mode::Velocity && dp == dp::State::DataExch && !self.moving;
        let first = [
            (power == Power::Off, Hindrance::SwitchedOff),
            (matches!(power, Power::FactoryReset(_)), Hindrance::FactoryReset),
            (on && at_126, Hindrance::AddressNotSet),
            (waits_for_prm, Hindrance::NoParameters { refused: prm_fault, cfg_refused: cfg_fault }),
            (on && dp == dp::State::WaitCfg, Hindrance::NoConfiguration),
            (on && sync, Hindrance::SyncHolds),
        ];
        let last = [
            (velocity && !StwBit::Start.is_set(self.stw), Hindrance::NotReleased),
            (velocity && self.setpoint_zero, Hindrance::SetpointZero),
        ];
        let refusal = self.refusal.filter(|_| on);
        // Outside Data_Exchange the control word counts as 0.
        let exchanging = dp == dp::State::DataExch;
        let reasons = refusal.into_iter().flat_map(Refusal::into_reasons);
        let reasons = reasons.filter(move |reason| exchanging || !is_of_word(*reason)).map(Hindrance::Drive);
        let applies = |(applies, hindrance): (bool, Hindrance)| applies.then_some(hindrance);
        first.into_iter().filter_map(applies).chain(reasons).chain(last.into_iter().filter_map(applies))
    }

    /// One hindrance in words: what, where, and what to do about it.
    pub(crate) const fn text(&self, hindrance: Hindrance) -> impl fmt::Display + use<> {
        Text { why: *self, hindrance }
    }

    /// The control words to send one after the other in Data_Exchange until it moves; `None`: it moves, or no control
    /// word helps before what [`Why::hindrances`] names is changed.
    pub fn next(&self) -> Option<impl fmt::Display + use<>> {
        let power = match self.power {
            Power::On => !self.at_126 && !self.sync,
            Power::Off | Power::FactoryReset(_) => false,
        };
        if !power || self.moving {
            return None;
        }
        match &self.refusal {
            Some(refusal) => refusal.next_with(!self.cause_present).map(Next::Refused),
            None if self.mode == Mode::Velocity && StwBit::Start.is_set(self.stw) => None,
            None => Some(Next::Start(self.stw.raw() ^ StwBit::Start.mask())),
        }
    }
}

/// Whether it comes from the control word alone.
const fn is_of_word(reason: Reason) -> bool {
    match reason {
        Reason::Off2 | Reason::Off1 | Reason::Off1NotSeen => true,
        Reason::Drive(reason) => matches!(
            reason,
            drive::Reason::NotAsked
                | drive::Reason::NotEnabled
                | drive::Reason::Stop
                | drive::Reason::IntermediateStop
        ),
    }
}

enum Next {
    Refused(super::refusal::Next),
    Start(u16),
}

impl fmt::Display for Next {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(next) => next.fmt(f),
            Self::Start(stw) => write!(f, "send STW {stw:04X}"),
        }
    }
}

impl Hindrance {
    /// A name that stays, for programs: `NoDataExchange`.
    pub(crate) const fn name(self) -> HindranceName {
        HindranceName(self)
    }
}

/// The name of a hindrance ([`Hindrance::name`]).
#[derive(Clone, Copy, Debug)]
pub(crate) struct HindranceName(Hindrance);

impl fmt::Display for HindranceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Hindrance::SwitchedOff => f.write_str("SwitchedOff"),
            Hindrance::FactoryReset => f.write_str("FactoryReset"),
            Hindrance::AddressNotSet => f.write_str("AddressNotSet"),
            Hindrance::NoParameters { .. } | Hindrance::NoConfiguration => f.write_str("NoDataExchange"),
            Hindrance::SyncHolds => f.write_str("SyncHolds"),
            Hindrance::Drive(reason) => write!(f, "{reason:?}"),
            Hindrance::NotReleased => f.write_str("NotReleased"),
            Hindrance::SetpointZero => f.write_str("SetpointZero"),
        }
    }
}

struct Text {
    why: Why,
    hindrance: Hindrance,
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.hindrance {
            Hindrance::SwitchedOff => f.write_str("the drive is switched off: switch its supply on"),
            Hindrance::FactoryReset => f.write_str(
                "the drive is in a factory reset: switch it off, put SW8 to OFF and switch it on",
            ),
            Hindrance::AddressNotSet => f.write_str(
                "there is no Data_Exchange at address 126: set another address with SW1 to SW7 and switch off and on",
            ),
            Hindrance::NoParameters { refused: true, .. } => f.write_str(PRM_REFUSED),
            Hindrance::NoParameters { refused: false, cfg_refused: true } => f.write_str(
                "no master exchanges data with the drive, the last Chk_Cfg was refused (Slave_Diag octet 1 bit 2, \
                 Cfg_Fault): choose the module of the drive's GSD (SIKO0AC5.GSD) in the master's project",
            ),
            Hindrance::NoParameters { refused: false, cfg_refused: false } => f.write_str(NOT_PARAMETERISED),
            Hindrance::NoConfiguration => f.write_str(NOT_CONFIGURED),
            Hindrance::SyncHolds => f.write_str(SYNC_HOLDS),
            Hindrance::Drive(Reason::Drive(drive::Reason::FaultLatched)) => {
                let Some(refusal) = self.why.refusal else { return Ok(()) };
                let cause = if self.why.cause_present { "present" } else { "gone" };
                let fault = refusal.drive.text(drive::Reason::FaultLatched);
                let then = if self.why.cause_present { "remove it, then acknowledge" } else { "acknowledge" };
                write!(f, "{fault}, its cause is {cause}: {then} ({} from 0 to 1)", Bit(StwBit::Acknowledge))
            }
            Hindrance::Drive(reason) => match self.why.refusal {
                Some(refusal) => refusal.text(reason).fmt(f),
                None => Ok(()),
            },
            Hindrance::NotReleased => write!(f, "the velocity setpoint is not released ({} = 0)", Bit(StwBit::Start)),
            Hindrance::SetpointZero => f.write_str("the velocity setpoint is 0 (HSW): send another"),
        }
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.moving {
            return f.write_str("it moves");
        }
        let mut count = 0;
        for hindrance in self.hindrances() {
            count += 1;
            let before = if count == 1 { "it does not move: " } else { "; " };
            write!(f, "{before}{}", self.text(hindrance))?;
        }
        match (count, self.mode) {
            (0, Mode::Positioning) => {
                write!(f, "it waits for a start: each change of {} starts a travel job", Bit(StwBit::Start))?;
            }
            (0, Mode::Velocity) => f.write_str("nothing keeps it from turning")?,
            (_, Mode::Positioning | Mode::Velocity) => {}
        }
        match self.next() {
            Some(next) => write!(f, "; next: {next}"),
            None => Ok(()),
        }
    }
}
