//! What keeps a drive of the profile from turning now, the first thing to do first.

use super::PpoDrive;
use crate::devices::ppo_drive::State;
use crate::devices::ppo_drive::profile::{reasons, reasons_of_drive};
use crate::devices::reasons::of_slave;
use crate::face::{Reason, Why};
use crate::profibus::dp;
use crate::profibus::dp::Application;
use crate::profibus::ppo::{Stw, Zsw};

/// What is to be done about a refused Chk_Cfg.
const CFG_ADVICE: &str = "choose one of PPO 1 to 5 in the master's project";

impl<A: Application> Why for PpoDrive<A> {
    fn verb(&self) -> &'static str {
        "turn"
    }

    fn is_moving(&self) -> Option<bool> {
        Some(self.drive().status().actual != 0)
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        let status = self.drive().status();
        if status.actual != 0 {
            return;
        }
        let state = self.slave().state();
        of_slave(self.slave(), CFG_ADVICE, tell);
        each_of_words(state, self.stw(), self.zsw(), tell);
        if status.state == State::Operation && self.command().setpoint == 0 {
            let text = "the setpoint is 0 (second word of process data): send another";
            tell(Reason::new("SetpointZero", &text));
        }
    }
}

/// Outside Data_Exchange the control word counts as 0 and says nothing.
fn each_of_words(state: dp::State, stw: Stw, zsw: Zsw, tell: &mut dyn FnMut(Reason<'_>)) {
    match state {
        dp::State::DataExch => reasons(stw, zsw).for_each(tell),
        dp::State::WaitPrm | dp::State::WaitCfg => reasons_of_drive(zsw).for_each(tell),
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::devices::reasons::of_parts;

    fn of_words(state: dp::State, stw: u16, zsw: u16) -> Vec<&'static str> {
        let mut told = Vec::new();
        each_of_words(state, Stw::from_raw(stw), Zsw::from_raw(zsw), &mut |reason| told.push(reason.name));
        told
    }

    #[test]
    fn without_data_exchange_only_the_drive_itself_says_something() {
        assert_eq!(of_words(dp::State::DataExch, 0x047F, 0x0337), [""; 0]);
        assert_eq!(of_words(dp::State::DataExch, 0x047E, 0x0231), ["NotOn"]);
        assert_eq!(of_words(dp::State::WaitPrm, 0, 0x0240), ["Inhibited"]);
        assert_eq!(of_words(dp::State::WaitCfg, 0, 0x0248), ["Fault", "Inhibited"]);
    }

    #[test]
    fn what_the_slave_waits_for_is_said_first() {
        let of = |state, change: fn(&mut dp::Diagnosis)| {
            let mut diagnosis = dp::Diagnosis::default();
            change(&mut diagnosis);
            let mut told = Vec::new();
            of_parts(state, &diagnosis, None, &[0, 1], CFG_ADVICE, &mut |reason| {
                told.push(reason.to_string())
            });
            told.join("; ")
        };
        assert_eq!(of(dp::State::DataExch, |_| {}), "");
        assert!(of(dp::State::DataExch, |diagnosis| diagnosis.sync_mode = true).starts_with("Sync holds"));
        assert!(
            of(dp::State::DataExch, |diagnosis| diagnosis.freeze_mode = true).starts_with("Freeze holds")
        );
        assert!(of(dp::State::WaitPrm, |_| {}).ends_with("check its station list and the rate of the line"));
        assert!(of(dp::State::WaitPrm, |diagnosis| diagnosis.prm_fault = true).contains("Prm_Fault"));
        assert!(of(dp::State::WaitPrm, |diagnosis| diagnosis.cfg_fault = true).ends_with(CFG_ADVICE));
        assert!(of(dp::State::WaitCfg, |_| {}).ends_with("waits for Chk_Cfg"));
    }
}
