//! A slave as the test master sees it.

use profidrive::profibus::dp::{Diagnosis, IoLengths};
use profidrive::time::Instant;

use super::Configured;
use super::acyclic::{Services, Uses};
use super::mistakes::Mistake;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Diag1,
    Prm,
    Cfg,
    Diag2,
    Exchange,
}

#[derive(Debug)]
pub(super) struct Slave {
    pub(super) configured: Configured,
    pub(super) lengths: IoLengths,
    pub(super) state: State,
    pub(super) count: Option<bool>,
    pub(super) operational: bool,
    pub(super) retries: u32,
    /// The request that has no reply yet.
    pub(super) open: Option<Vec<u8>>,
    pub(super) wants_diag: bool,
    pub(super) not_ready: u32,
    pub(super) wrong_replies: u32,
    pub(super) forgotten: bool,
    pub(super) restarts: bool,
    pub(super) turns: u32,
    /// A reply that it has sent twice.
    pub(super) kept: bool,
    pub(super) start_ups: u32,
    pub(super) output: u8,
    /// What the user wants to send; otherwise it counts.
    pub(super) user_outputs: Option<Vec<u8>>,
    pub(super) sent_outputs: Vec<u8>,
    /// Half of it is sent once.
    pub(super) torn: bool,
    /// It was lost while data were exchanged.
    pub(super) lost: bool,
    /// It has answered RS since the last start-up.
    pub(super) refused: bool,
    /// Its last diagnosis has Ext_Diag.
    pub(super) faulty: bool,
    /// Unanswered first requests in a row.
    pub(super) first_asks: u32,
    /// Start-ups in a row with nothing unusual.
    pub(super) plain: u32,
    /// What a master of class 2 has read of it.
    pub(super) reads: usize,
    /// The last good exchange.
    pub(super) exchanged: Instant,
    /// It is being asked for its FDL status, and has answered.
    pub(super) asks_status: bool,
    pub(super) is_there: bool,
    /// Get_Cfg, and the first of two Slave_Diags, were answered in this start-up.
    pub(super) has_read_cfg: bool,
    pub(super) has_diagnosed: bool,
    /// DP-V1.
    pub(super) services: Option<Services>,
}

impl Slave {
    pub(super) fn new(configured: &Configured, uses: Uses, mistake: Option<Mistake>) -> Self {
        Self {
            configured: configured.clone(),
            lengths: IoLengths::of(&configured.cfg).unwrap(),
            state: State::Diag1,
            count: None,
            operational: false,
            retries: 0,
            open: None,
            wants_diag: false,
            not_ready: 0,
            wrong_replies: 0,
            forgotten: false,
            restarts: false,
            turns: 0,
            kept: false,
            start_ups: 0,
            output: 0,
            user_outputs: None,
            sent_outputs: Vec::new(),
            torn: false,
            lost: false,
            refused: false,
            faulty: false,
            first_asks: 0,
            plain: 0,
            reads: 0,
            exchanged: Instant::ZERO,
            asks_status: false,
            is_there: false,
            has_read_cfg: false,
            has_diagnosed: false,
            services: (uses != Uses::NOTHING).then(|| Services::new(uses, mistake)),
        }
    }

    pub(super) fn restart(&mut self, mistake: Option<Mistake>) {
        self.state = if mistake == Some(Mistake::NoFirstDiag) { State::Prm } else { State::Diag1 };
        self.wants_diag = false;
        self.not_ready = 0;
        self.wrong_replies = 0;
        self.restarts = false;
        (self.has_read_cfg, self.has_diagnosed) = (false, false);
        if let Some(services) = &mut self.services {
            services.begin(mistake);
        }
    }

    pub(super) fn count_wrong_reply(&mut self) {
        self.wrong_replies += 1;
        if self.wrong_replies >= 3 {
            self.wrong_replies = 0;
            self.wants_diag = true;
        }
    }

    /// The diagnosis behind Chk_Cfg.
    pub(super) fn judge_second(&mut self, diag: Diagnosis, mistake: Option<Mistake>) {
        let faults = (diag.prm_fault && mistake != Some(Mistake::IgnoresPrmFault))
            || (diag.cfg_fault && mistake != Some(Mistake::IgnoresCfgFault));
        let prm_req = diag.prm_req
            && !(diag.prm_fault && mistake == Some(Mistake::IgnoresPrmFault))
            && !(diag.cfg_fault && mistake == Some(Mistake::IgnoresCfgFault));
        let not_ready = diag.station_not_ready
            && mistake != Some(Mistake::IgnoresNotReady)
            && !(diag.prm_fault && mistake == Some(Mistake::IgnoresPrmFault))
            && !(diag.cfg_fault && mistake == Some(Mistake::IgnoresCfgFault));
        let stat_diag = diag.stat_diag && mistake != Some(Mistake::IgnoresStatDiag);
        let other = diag.ident != self.configured.ident && mistake != Some(Mistake::IgnoresIdent);
        if faults || prm_req || other {
            self.plain = 0;
            self.restart(mistake);
        } else if not_ready || stat_diag {
            self.plain = 0;
            self.not_ready += 1;
            if mistake == Some(Mistake::Impatient) && self.not_ready > 2 {
                self.restart(mistake);
            }
        } else {
            (self.lost, self.refused) = (false, false);
            self.plain += 1;
            self.state = State::Exchange;
        }
    }
}
