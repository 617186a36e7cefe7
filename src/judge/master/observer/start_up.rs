//! Rows U, and those of D and L that show in a start-up: what is asked when.

use core::time::Duration;

use super::Observer;
use super::cycle::{Answer, Cycle};
use super::view::{Disturbance, Disturbed, Due, Loss, Shown, Step};
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::profibus::dp;
use crate::profibus::dp::{Diagnosis, SetPrm};

/// A new Set_Prm earlier than this shows no patience with a slave that is not ready.
const PATIENCE: Duration = Duration::from_millis(900);
/// Diagnoses in a row while data are exchanged: more are for ever.
const FOR_EVER: u32 = 40;
/// A diagnosis longer than this is a long one.
const LONG: usize = 200;
/// A slave that refused Chk_Cfg with RS is not ready: so many diagnoses are enough to see that it waits for another.
const WAITS: u32 = 60;

impl Observer {
    /// Whether a diagnosis names another owner than this master.
    pub(super) fn is_owned_by_other(&self, diag: &Diagnosis) -> bool {
        diag.master.is_some_and(|owner| Some(owner) != self.master)
    }

    /// The row about a station of another master.
    const fn taken_row(loss: Loss) -> Row {
        match loss {
            Loss::Refused => Row::L05,
            Loss::None | Loss::Silent => Row::D07,
        }
    }

    /// A Set_Prm begins.
    pub(super) fn judge_set_prm(&mut self, cycle: &Cycle) {
        let station = cycle.to;
        let from = cycle.serial.saturating_sub(6);
        let locks = SetPrm::parse(cycle.data()).is_ok_and(|prm| prm.lock_req() && !prm.unlock_req());
        self.judge_prm_contents(cycle);
        if !locks {
            return;
        }
        let view = self.view(station);
        let (diag_read, diag, loss, exchanging) = (view.diag_read, view.diag, view.loss, view.exchanging);
        let gave_up = view.gave_up;
        let not_ready = view.not_ready.take();
        let disturbed = view.disturbed.take();
        let restart_due = view.restart_due.take().map(|due| due.row).or(view.excused.take());
        let refused = view.refused.take();
        view.waits = 0;
        if diag_read {
            self.held(Row::U01);
        } else {
            let reason = "Set_Prm before the diagnosis of the slave was read";
            self.broken(Row::U01, Weight::Once, from, Some(station), reason);
        }
        if let Some(diag) = diag.filter(|diag| diag_read && self.is_owned_by_other(diag)) {
            let owner = diag.master.map_or(255, |owner| owner.number());
            let reason = format!("Set_Prm to a slave whose diagnosis says that master {owner} owns it");
            self.broken(Self::taken_row(loss), Weight::Once, from, Some(station), reason);
        }
        if let Some((since, serial)) = not_ready {
            let after = cycle.end.saturating_since(since);
            if after < PATIENCE {
                let reason =
                    format!("Set_Prm {} ms after the slave said it is not ready yet", after.as_millis());
                self.broken(Row::U06, Weight::Once, serial, Some(station), reason);
            } else {
                self.held(Row::U06);
            }
        }
        if let Some(row) = restart_due {
            self.held(row);
        }
        if refused.is_some() || loss == Loss::Refused {
            self.held(Row::L03);
        }
        if exchanging && !gave_up && loss == Loss::None && restart_due.is_none() {
            match disturbed {
                _ if self.is_other_lost(station) => self.judge_needless(cycle),
                Some(Disturbed { what, serial, .. }) => {
                    if let Some(row) = what.row() {
                        let reason = format!("Set_Prm although {}", words(what));
                        self.broken(row, Weight::Times(2), serial, Some(station), reason);
                    }
                }
                None => {}
            }
        }
        let view = self.view(station);
        view.shown = Shown::default();
        view.diag_after_cfg = false;
        view.short_diag = false;
    }

    /// Whether the master has lost another station, or still looks for one that is switched on late.
    fn is_other_lost(&self, station: crate::profibus::fdl::Address) -> bool {
        let lost = |view: &super::view::View| view.gave_up || view.loss != Loss::None;
        let others = self.views.iter().filter(|(other, _)| *other != station.number());
        let mut present = self.setup.present().filter(|slave| slave.address != station);
        let unseen = |number: u8| self.views.get(&number).is_none_or(|view| !view.answered);
        others.map(|(_, view)| view).any(lost) || present.any(|slave| unseen(slave.address.number()))
    }

    /// A new start-up without a reason of its own, while another station is lost.
    fn judge_needless(&mut self, cycle: &Cycle) {
        let view = self.view(cycle.to);
        // A user may have started it anew.
        let anew = view.anew && self.sight == super::Sight::Recorded;
        if self.view(cycle.to).calm > 0 && !anew {
            let reason =
                format!("Set_Prm to station {}, which has no fault; another station is lost", cycle.to);
            self.broken(Row::L04, Weight::Times(2), cycle.serial.saturating_sub(8), None, reason);
        }
    }

    /// A Chk_Cfg begins.
    pub(super) fn judge_chk_cfg(&mut self, cycle: &Cycle) {
        let station = cycle.to;
        self.view(station).cfg_data = Some(cycle.data().to_vec());
        let from = cycle.serial.saturating_sub(6);
        self.judge_cfg_contents(cycle);
        let view = self.view(station);
        let (prm, diag, loss, diag_read) = (view.prm, view.diag, view.loss, view.diag_read);
        view.waits = 0;
        view.diag_after_cfg = false;
        if let Some(diag) = diag.filter(|diag| diag_read && self.is_owned_by_other(diag)) {
            let owner = diag.master.map_or(255, |owner| owner.number());
            let reason = format!("Chk_Cfg to a slave whose diagnosis says that master {owner} owns it");
            self.broken(Self::taken_row(loss), Weight::Once, from, Some(station), reason);
        }
        let (row, reason) = match prm {
            Step::Acknowledged => return self.held(Row::U02),
            Step::None => (Row::U02, "Chk_Cfg, and no Set_Prm was acknowledged before it"),
            Step::Refused => (Row::U08, "Chk_Cfg after a Set_Prm that got a negative answer"),
            Step::Unanswered => (Row::U09, "Chk_Cfg after a Set_Prm that got no answer"),
        };
        if self.sight == super::Sight::Recorded && prm == Step::None && self.view(station).start_ups == 0 {
            return;
        }
        self.broken(row, Weight::Once, from, Some(station), reason);
    }

    /// A Slave_Diag begins.
    pub(super) fn judge_diagnosis(&mut self, cycle: &Cycle) {
        let view = self.view(cycle.to);
        if let Some(due) = view.announced.take()
            && due.exchanges <= super::exchange::MOST_BEFORE_DIAG
        {
            self.held(due.row);
        }
        let view = self.view(cycle.to);
        view.refused = None;
        if let Some(wrong_replies) = view.wrong_replies.take() {
            self.held(wrong_replies.row);
        }
    }

    /// The first Data_Exchange of a start-up.
    pub(super) fn judge_first_exchange(&mut self, cycle: &Cycle) {
        let station = cycle.to;
        let from = cycle.serial.saturating_sub(8);
        let ident = self.setup.slave(station).map(|slave| slave.ident);
        let view = self.view(station);
        let (cfg, diag_after_cfg, diag, shown) = (view.cfg, view.diag_after_cfg, view.diag, view.shown);
        let (short, loss, begun) = (view.short_diag, view.loss, view.start_ups > 0);
        if self.sight == super::Sight::Recorded && cfg == Step::None && !begun {
            return;
        }
        let once = |observer: &mut Self, row, reason: &str| {
            observer.broken(row, Weight::Once, from, Some(station), reason);
        };
        match cfg {
            Step::Acknowledged => self.held(Row::U03),
            Step::None => {
                return once(self, Row::U03, "Data_Exchange, and no Chk_Cfg was acknowledged since Set_Prm");
            }
            Step::Refused => {
                return once(self, Row::U08, "Data_Exchange after a Chk_Cfg that got a negative answer");
            }
            Step::Unanswered => {
                return once(self, Row::U09, "Data_Exchange after a Chk_Cfg that got no answer");
            }
        }
        if short {
            return once(self, Row::D12, "Data_Exchange after a diagnosis of less than six octets");
        }
        if !diag_after_cfg {
            return once(self, Row::U04, "Data_Exchange, and the diagnosis was not read after Chk_Cfg");
        }
        self.held(Row::U04);
        let Some(diag) = diag else { return };
        if diag.prm_fault {
            once(self, Row::D04, "Data_Exchange although the diagnosis says Prm_Fault");
        } else if diag.cfg_fault {
            once(self, Row::D05, "Data_Exchange although the diagnosis says Cfg_Fault");
        } else if diag.station_not_ready {
            once(self, Row::U05, "Data_Exchange although the diagnosis says Station_Not_Ready");
        } else if self.is_owned_by_other(&diag) {
            let row = Self::taken_row(loss);
            once(self, row, "Data_Exchange with a slave whose diagnosis names another master");
        } else if diag.stat_diag {
            once(self, Row::D03, "Data_Exchange although the diagnosis says Stat_Diag");
        }
        if ident.is_some_and(|ident| ident != diag.ident) {
            once(self, Row::U07, "Data_Exchange with a slave whose diagnosis has another ident number");
        }
        let seen = [
            (shown.not_ready && !diag.station_not_ready, Row::U05),
            (shown.not_ready && !diag.station_not_ready, Row::U06),
            (shown.stat_diag && !diag.stat_diag, Row::D03),
            (shown.short, Row::D12),
        ];
        for (_, row) in seen.into_iter().filter(|(seen, _)| *seen) {
            self.held(row);
        }
    }

    /// What a Slave_Diag led to.
    pub(super) fn diagnosed(&mut self, cycle: &Cycle, answer: &Answer) {
        if *answer == Answer::Mixed {
            // It may have taken some of it for the diagnosis.
            let view = self.view(cycle.to);
            view.diag_read = true;
            view.diag_after_cfg |= view.cfg == Step::Acknowledged;
        }
        let Answer::Data { octets, .. } = answer else {
            return;
        };
        let known = self.setup.slave(cycle.to).map(|slave| slave.ident);
        let Some(diag) = Diagnosis::parse(octets) else {
            let view = self.view(cycle.to);
            view.diag_read = true;
            view.diag_after_cfg |= view.cfg == Step::Acknowledged;
            view.short_diag = view.cfg == Step::Acknowledged;
            view.shown.short = true;
            return;
        };
        self.note_alarms(cycle, octets);
        let patience = self.patience(cycle.to);
        let owned_by_other = self.is_owned_by_other(&diag);
        let view = self.view(cycle.to);
        let faults = diag.prm_fault || diag.cfg_fault;
        if faults {
            view.fault = Some((diag.prm_fault, diag.cfg_fault));
        }
        let ready = !diag.station_not_ready && !diag.prm_req && !faults && !owned_by_other;
        view.diag_read = true;
        view.short_diag = false;
        if view.cfg == Step::Acknowledged {
            view.diag_after_cfg = true;
        }
        view.shown.not_ready |= diag.station_not_ready && !diag.prm_req && !faults;
        view.shown.stat_diag |= diag.stat_diag;
        view.shown.prm_fault |= diag.prm_fault;
        view.shown.cfg_fault |= diag.cfg_fault;
        view.shown.other_ident |= known.is_some_and(|ident| ident != diag.ident);
        view.shown.other_master |= owned_by_other;
        let configured = view.cfg == Step::Acknowledged && !view.cfg_in_doubt;
        // With FCV = 0 the master begins anew already.
        let begins = configured && cycle.is_counted() && !view.exchanging && view.loss == Loss::None;
        if begins && diag.station_not_ready && !diag.prm_req && !faults {
            view.not_ready.get_or_insert((cycle.end, cycle.serial));
        }
        view.diag = Some(diag);
        if view.cfg == Step::Refused {
            view.waits += 1;
            if view.waits == WAITS {
                let reason =
                    "Chk_Cfg got a negative answer, and the master only waits until the slave is ready";
                self.broken(Row::U08, Weight::Once, cycle.serial.saturating_sub(10), Some(cycle.to), reason);
            }
            return;
        }
        if !view.exchanging || view.loss != Loss::None {
            return;
        }
        if cycle.is_counted() {
            view.diagnoses += 1;
        }
        if view.diagnoses == FOR_EVER && ready && !diag.stat_diag {
            let reason =
                format!("{FOR_EVER} times Slave_Diag without Data_Exchange; the diagnosis shows no fault");
            self.broken(Row::D06, Weight::Once, cycle.serial.saturating_sub(12), Some(cycle.to), reason);
            return;
        }
        if diag.prm_req {
            view.restart_due = Some(Due::new(Row::D02, cycle.serial));
        } else if diag.station_not_ready || diag.master.is_none() {
            view.restart_due = Some(Due::new(Row::D15, cycle.serial));
        } else if ready {
            if let Some(due) = view.restart_due.take() {
                view.excused = Some(due.row);
            }
            // After a bad reply a new start-up is right.
            // So it is when a job of DP-V1 got no response in time.
            let given_up = view.services.is_overdue(cycle.end, patience);
            if view.excused.is_some() || view.calm == 0 || given_up || !cycle.is_counted() {
                return;
            }
            let disturbance = match octets.len() {
                LONG.. => Disturbance::LongDiagnosis,
                _ if diag.ext_diag_overflow => Disturbance::Overflow,
                _ if diag.not_supported || octets.first().is_some_and(|octet| octet & MASTER_BITS != 0) => {
                    return;
                }
                _ => Disturbance::CleanDiagnosis,
            };
            view.disturbed.get_or_insert(Disturbed { what: disturbance, age: 0, serial: cycle.serial });
        }
    }

    /// What a Set_Prm led to.
    pub(super) fn parameterised(&mut self, cycle: &Cycle, answer: &Answer) {
        let prm = SetPrm::parse(cycle.data());
        let view = self.view(cycle.to);
        if prm.is_ok_and(|prm| prm.unlock_req()) {
            view.lose(Loss::None);
            view.prm = step(answer);
            view.exchanging = false;
            view.cfg = Step::None;
            return;
        }
        view.prm = step(answer);
        view.cfg = Step::None;
        view.exchanging = false;
        view.trouble();
        view.wrong_replies = None;
        view.announced = None;
        view.disturbed = None;
        view.dh_in_row = 0;
        view.services.end_owners();
        view.diagnoses = 0;
        view.watchdog = prm.ok().and_then(SetPrm::watchdog);
        view.loss = Loss::None;
    }

    /// What a Chk_Cfg led to.
    pub(super) fn configured(&mut self, cycle: &Cycle, answer: &Answer) {
        let view = self.view(cycle.to);
        view.cfg = step(answer);
        view.cfg_in_doubt = *answer == Answer::Mixed;
        view.exchanging = false;
        view.lengths = dp::IoLengths::of(cycle.data()).ok();
        view.not_ready = None;
    }
}

/// Bits of the first octet of a diagnosis that only masters set.
const MASTER_BITS: u8 = 0xA1;

const fn step(answer: &Answer) -> Step {
    match answer {
        Answer::ShortAck => Step::Acknowledged,
        Answer::Data { .. } | Answer::Status(_) => Step::Refused,
        Answer::Silence | Answer::Bad(_) => Step::Unanswered,
        // It may have taken the acknowledge.
        Answer::Mixed => Step::Acknowledged,
    }
}

const fn words(disturbance: Disturbance) -> &'static str {
    match disturbance {
        Disturbance::BadReply => "one reply was bad",
        Disturbance::LostReply => "only one reply was lost",
        Disturbance::CleanDiagnosis => "the diagnosis shows no fault",
        Disturbance::LongDiagnosis => "the diagnosis, a long one, shows no fault",
        Disturbance::Overflow => "the diagnosis shows only Ext_Diag_Overflow",
        Disturbance::SlowJob => "a job of DP-V1 takes a while",
        Disturbance::RefusedJob => "only a job of DP-V1 was refused",
    }
}
