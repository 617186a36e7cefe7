//! What keeps a drive of the profile from turning now, the first thing to do first.

use core::fmt;

use super::PpoDrive;
use crate::devices::ag03::profibus::why::{NOT_CONFIGURED, NOT_PARAMETERISED, PRM_REFUSED, SYNC_HOLDS};
use crate::devices::ppo_drive::State;
use crate::devices::ppo_drive::profile;
use crate::profibus::dp;
use crate::profibus::dp::Application;
use crate::profibus::ppo::{Stw, Zsw};

/// Why a drive of the profile does not turn ([`PpoDrive::why`]). `Display` is one line with every hindrance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PpoWhy {
    dp: dp::State,
    prm_fault: bool,
    cfg_fault: bool,
    sync: bool,
    turning: bool,
    setpoint_zero: bool,
    stw: Stw,
    zsw: Zsw,
}

/// One thing that keeps the drive from turning. `Display` is what, where, and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PpoHindrance {
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
    /// What the words say against it.
    Words(profile::ProfileHindrance),
    /// Operation is enabled, and the setpoint is 0.
    SetpointZero,
}

impl<A: Application> PpoDrive<A> {
    /// Everything that keeps the drive from turning now.
    pub(crate) fn why(&self) -> PpoWhy {
        let diagnosis = self.slave().diagnosis();
        let status = self.drive().status();
        PpoWhy {
            dp: self.slave().state(),
            prm_fault: diagnosis.prm_fault,
            cfg_fault: diagnosis.cfg_fault,
            sync: diagnosis.sync_mode,
            turning: status.actual != 0,
            setpoint_zero: status.state == State::Operation && self.command().setpoint == 0,
            stw: self.stw(),
            zsw: self.zsw(),
        }
    }
}

impl PpoWhy {
    /// Whether it turns, so that nothing keeps it from that.
    pub(crate) const fn is_turning(&self) -> bool {
        self.turning
    }

    /// What keeps it from turning, the first thing to do first. None: it turns, or would with the setpoint it has.
    pub fn hindrances(&self) -> impl Iterator<Item = PpoHindrance> + use<> {
        let Self { dp, prm_fault, cfg_fault, sync, turning, setpoint_zero, stw, zsw } = *self;
        let waits_for_prm = dp == dp::State::WaitPrm;
        let first = [
            (waits_for_prm, PpoHindrance::NoParameters { refused: prm_fault, cfg_refused: cfg_fault }),
            (dp == dp::State::WaitCfg, PpoHindrance::NoConfiguration),
            (sync, PpoHindrance::SyncHolds),
        ];
        // Outside Data_Exchange the control word counts as 0.
        let exchanging = dp == dp::State::DataExch;
        let words =
            profile::hindrances(stw, zsw).filter(move |hindrance| exchanging || is_of_drive(*hindrance));
        let applies = |(applies, hindrance): (bool, PpoHindrance)| applies.then_some(hindrance);
        let last = [(setpoint_zero, PpoHindrance::SetpointZero)];
        let all = first.into_iter().filter_map(applies).chain(words.map(PpoHindrance::Words));
        all.chain(last.into_iter().filter_map(applies)).filter(move |_| !turning)
    }
}

/// Whether it stands without a control word, too.
const fn is_of_drive(hindrance: profile::ProfileHindrance) -> bool {
    match hindrance {
        profile::ProfileHindrance::Fault | profile::ProfileHindrance::Inhibited => true,
        profile::ProfileHindrance::NotByPlc
        | profile::ProfileHindrance::Off2
        | profile::ProfileHindrance::Off3
        | profile::ProfileHindrance::NotReadyToSwitchOn
        | profile::ProfileHindrance::NotOn
        | profile::ProfileHindrance::NotEnabled
        | profile::ProfileHindrance::NotInOperation
        | profile::ProfileHindrance::RampDisabled
        | profile::ProfileHindrance::RampFrozen
        | profile::ProfileHindrance::SetpointDisabled => false,
    }
}

impl fmt::Display for PpoHindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoParameters { refused: true, .. } => f.write_str(PRM_REFUSED),
            Self::NoParameters { refused: false, cfg_refused: true } => f.write_str(
                "no master exchanges data with the drive, the last Chk_Cfg was refused (Slave_Diag octet 1 bit 2, \
                 Cfg_Fault): choose one of PPO 1 to 5 in the master's project",
            ),
            Self::NoParameters { refused: false, cfg_refused: false } => f.write_str(NOT_PARAMETERISED),
            Self::NoConfiguration => f.write_str(NOT_CONFIGURED),
            Self::SyncHolds => f.write_str(SYNC_HOLDS),
            Self::Words(hindrance) => hindrance.fmt(f),
            Self::SetpointZero => f.write_str("the setpoint is 0 (second word of process data): send another"),
        }
    }
}

impl fmt::Display for PpoWhy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.turning {
            return f.write_str("it turns");
        }
        let mut before = "it does not turn: ";
        for hindrance in self.hindrances() {
            write!(f, "{before}{hindrance}")?;
            before = "; ";
        }
        if self.hindrances().next().is_none() { f.write_str("nothing keeps it from turning") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    /// In operation under a full control word, not turning.
    const READY: PpoWhy = PpoWhy {
        dp: dp::State::DataExch,
        prm_fault: false,
        cfg_fault: false,
        sync: false,
        turning: false,
        setpoint_zero: false,
        stw: Stw::from_raw(0x047F),
        zsw: Zsw::from_raw(0x0337),
    };
    const SILENT: PpoWhy =
        PpoWhy { dp: dp::State::WaitPrm, stw: Stw::from_raw(0), zsw: Zsw::from_raw(0x0240), ..READY };

    #[test]
    fn what_comes_first_is_said_first() {
        let inhibited = PpoHindrance::Words(profile::ProfileHindrance::Inhibited);
        let refused = |refused, cfg_refused| PpoHindrance::NoParameters { refused, cfg_refused };
        for (why, expected) in [
            (READY, &[][..]),
            (PpoWhy { setpoint_zero: true, ..READY }, &[PpoHindrance::SetpointZero]),
            (PpoWhy { turning: true, sync: true, ..READY }, &[]),
            (PpoWhy { sync: true, ..READY }, &[PpoHindrance::SyncHolds]),
            (SILENT, &[refused(false, false), inhibited]),
            (PpoWhy { prm_fault: true, ..SILENT }, &[refused(true, false), inhibited]),
            (PpoWhy { cfg_fault: true, ..SILENT }, &[refused(false, true), inhibited]),
            (PpoWhy { dp: dp::State::WaitCfg, ..SILENT }, &[PpoHindrance::NoConfiguration, inhibited]),
            (
                PpoWhy { stw: Stw::from_raw(0x047E), zsw: Zsw::from_raw(0x0231), ..READY },
                &[PpoHindrance::Words(profile::ProfileHindrance::NotOn)],
            ),
        ] {
            assert_eq!(why.hindrances().collect::<Vec<_>>(), expected, "{why}");
        }
    }

    #[test]
    fn one_line_has_everything() {
        assert_eq!(READY.to_string(), "nothing keeps it from turning");
        assert_eq!(PpoWhy { turning: true, ..READY }.to_string(), "it turns");
        let silent = SILENT.to_string();
        assert!(
            silent.starts_with("it does not turn: no master exchanges data with the drive: "),
            "{silent}"
        );
        assert!(
            silent.ends_with("; switching on is inhibited: give OFF1 once (STW bit 0 = 0, bits 1 and 2 = 1)"),
            "{silent}"
        );
    }
}
