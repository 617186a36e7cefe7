//! What the events of its slave mean for a station from a GSD: why its outputs are what they are.

use super::GsdStation;
use crate::profibus::dp;

/// Why the outputs are what they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputsAre {
    /// No master exchanges data: zeros.
    #[default]
    Unowned,
    /// What the master sends.
    Live,
    /// The master cleared them (Global_Control with Clear_Data), and has sent none but zeros since.
    Cleared,
    /// The master sends no outputs (Fail_Safe).
    FailSafe,
    /// The watchdog expired: zeros, and the slave waits for Set_Prm.
    WatchdogExpired,
}

impl GsdStation {
    pub(super) fn has_outputs_again(&self) -> bool {
        let slave = self.slave();
        match self.outputs_are {
            OutputsAre::FailSafe => !slave.safe_state(),
            OutputsAre::Cleared => slave.outputs().iter().any(|octet| *octet != 0),
            OutputsAre::Unowned | OutputsAre::Live | OutputsAre::WatchdogExpired => false,
        }
    }

    /// What an event of the slave means for the image and the log.
    pub(super) fn learn(&mut self, event: &dp::Event) {
        self.refusals.learn(self.station.address(), event, self.station.slave().application());
        match event {
            dp::Event::PrmRejected { .. }
            | dp::Event::CfgRejected { .. }
            | dp::Event::Parameterised { .. }
            | dp::Event::Released { .. }
            | dp::Event::WrongOutputLength { .. }
            | dp::Event::ApplicationSilent { .. }
            | dp::Event::ApplicationAborted { .. } => self.outputs_are = OutputsAre::Unowned,
            dp::Event::DataExchange { .. } => {
                self.outputs_are = OutputsAre::Live;
                self.lay_out(true);
                self.tell_open();
                self.prm = self.shown_prm();
                let slave = self.slave();
                for remark in slave.application().remarks(slave.configuration(), slave.user_prm()) {
                    tracing::warn!("station {}: {remark}", self.station.address());
                }
            }
            dp::Event::Controlled { command, .. } => {
                self.outputs_are = if command.clear_data { OutputsAre::Cleared } else { OutputsAre::Live };
            }
            dp::Event::SafeState { .. } => self.outputs_are = OutputsAre::FailSafe,
            dp::Event::WatchdogExpired { .. } => self.outputs_are = OutputsAre::WatchdogExpired,
            dp::Event::PrmForeign { .. }
            | dp::Event::MinTsdrOnly { .. }
            | dp::Event::LatchClosed { .. }
            | dp::Event::NotServed { .. }
            | dp::Event::CfgToJudge { .. }
            | dp::Event::Read { .. }
            | dp::Event::AddressRefused { .. } => {}
            dp::Event::AddressSet { .. } => self.keep(false),
        }
    }
}
