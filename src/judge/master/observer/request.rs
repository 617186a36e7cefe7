//! A request of the master: which rows look at it, and at what it has led to.

use super::cycle::{Answer, Cycle, Item};
use super::view::Loss;
use super::{Observer, Sight};
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::profibus::dp;
use crate::profibus::fdl::{DataTelegram, Service};
use crate::time::Instant;

impl Observer {
    pub(super) fn requested(&mut self, serial: u64, end: Instant, octets: &[u8], data: &DataTelegram<'_>) {
        let Some(cycle) = Cycle::new(serial, end, octets, data) else {
            return;
        };
        if self.master.is_some_and(|master| master != data.sa) {
            self.note_other_master(data.sa);
            return;
        }
        // What the GAP asks of every address is no asking for this one.
        let gap = cycle.kind == Service::FdlStatus && self.is_of_gap(data.da);
        if let Some(view) = self.views.get_mut(&data.da.number()).filter(|_| !gap) {
            view.spoken_to = Some(end);
        }
        match cycle.kind {
            Service::SdnLow | Service::SdnHigh => self.controlled(serial, end, data),
            Service::FdlStatus => {
                self.master.get_or_insert(data.sa);
                self.polled_status(serial, data.da);
                self.open = Some(cycle);
            }
            Service::SrdLow | Service::SrdHigh => {
                self.master.get_or_insert(data.sa);
                self.asked(cycle);
            }
            // Counted as well: what follows has nothing to be compared with.
            Service::SdaLow | Service::SdaHigh | Service::Msrd | Service::Ident | Service::LsapStatus => {
                self.view(data.da).last = None;
                self.open = Some(cycle);
            }
            Service::TimeEvent => {}
        }
    }

    /// An SRD request.
    fn asked(&mut self, mut cycle: Cycle) {
        let station = cycle.to;
        let known = self.setup.stations.is_empty() || self.setup.slave(station).is_some();
        if !known || self.is_of_owner(cycle.service) {
            self.stranger_asked(&cycle);
            self.open = Some(cycle);
            return;
        }
        if !self.setup.stations.is_empty() {
            self.held(Row::U12);
        }
        self.first_asked.get_or_insert(station);
        self.judge_rotation(cycle.serial);
        self.judge_new_begin(&cycle);
        self.note_request(&cycle);
        let before = self.view(station).last.take();
        // Behind noise the master asks again at once, and a retry cannot be told from a new request.
        let disturbed = before.as_ref().is_some_and(|before| before.items.len() > 1 || before.has_bad_item());
        self.judge_count(before.as_ref(), &mut cycle);
        let retry = cycle.retry > 0;
        self.measure_cycle(&cycle);
        self.judge_beside(&cycle);
        self.judge_interval(&cycle, retry || disturbed);
        if !retry {
            match cycle.service {
                Some(dp::Service::SetPrm) => self.judge_set_prm(&cycle),
                Some(dp::Service::ChkCfg) => self.judge_chk_cfg(&cycle),
                Some(dp::Service::DataExchange) => self.judge_exchange(&cycle),
                Some(dp::Service::SlaveDiag) => self.judge_diagnosis(&cycle),
                Some(dp::Service::GlobalControl) => self.judge_control_service(&cycle),
                Some(
                    dp::Service::SetSlaveAdd | dp::Service::RdInp | dp::Service::RdOutp | dp::Service::GetCfg,
                ) => {}
                None => self.judge_acyclic(&cycle),
            }
        }
        let reads = self.setup.is_class_2() && !retry;
        let view = self.view(station);
        view.asks = view.asks.saturating_add(1);
        view.polled = view.polled.saturating_add(u32::from(reads));
        if view.gave_up {
            view.asked_since = view.asked_since.saturating_add(1);
        }
        self.open = Some(cycle);
    }

    /// The master goes on: the open request has led to what it has led to.
    pub(super) fn close(&mut self) {
        let Some(cycle) = self.open.take() else {
            return;
        };
        let sound = cycle.items.len() == 1 && !cycle.has_bad_item();
        let view = self.view(cycle.to);
        view.sound = if sound { view.sound.saturating_add(1) } else { 0 };
        if cycle.kind == Service::FdlStatus {
            let answered = cycle.items.iter().any(|item| matches!(item, Item::Status(_)));
            self.status_answered(&cycle, answered);
            if answered && let Some(view) = self.views.get_mut(&cycle.to.number()) {
                view.gave_up = false;
            }
            return;
        }
        if !matches!(cycle.kind, Service::SrdLow | Service::SrdHigh) {
            return;
        }
        // Who did not wait may have got the reply later. In virtual time it is known that there was none.
        let may_come = cycle.void && cycle.items.is_empty() && !matches!(self.sight, Sight::Exact(_));
        let answer = if may_come { Answer::Mixed } else { cycle.answer() };
        self.note_trouble(&cycle, &answer);
        self.settle(&cycle, &answer);
        let station = cycle.to;
        self.view(station).last = Some(cycle);
    }

    /// Whether only the master that owns a slave may ask it for that.
    fn is_of_owner(&self, service: Option<dp::Service>) -> bool {
        let reads = match service {
            Some(dp::Service::SetPrm | dp::Service::ChkCfg | dp::Service::DataExchange) => false,
            Some(
                dp::Service::SetSlaveAdd
                | dp::Service::RdInp
                | dp::Service::RdOutp
                | dp::Service::GlobalControl
                | dp::Service::GetCfg
                | dp::Service::SlaveDiag,
            )
            | None => true,
        };
        self.setup.is_class_2() && !reads
    }

    /// Takes over what a request has led to.
    fn settle(&mut self, cycle: &Cycle, answer: &Answer) {
        let reads = self.setup.is_class_2();
        match answer {
            Answer::ShortAck | Answer::Data { .. } | Answer::Status(_) => {
                let view = self.view(cycle.to);
                view.answered = true;
                view.gave_up = false;
                view.over = false;
                view.asked_since = 0;
                view.first_run = 0;
                if reads {
                    view.streak = view.streak.saturating_add(1);
                    view.exchanges = view.exchanges.saturating_add(1);
                }
                if view.loss == Loss::Silent && cycle.service == Some(dp::Service::DataExchange) {
                    view.loss = Loss::None;
                }
            }
            Answer::Silence | Answer::Bad(_) => self.view(cycle.to).trouble(),
            // It may have taken some of it for the reply.
            Answer::Mixed => {
                let view = self.view(cycle.to);
                view.gave_up = false;
                view.trouble();
            }
        }
        match cycle.service {
            Some(dp::Service::SlaveDiag) => self.diagnosed(cycle, answer),
            Some(dp::Service::SetPrm) => self.parameterised(cycle, answer),
            Some(dp::Service::ChkCfg) => self.configured(cycle, answer),
            Some(dp::Service::DataExchange) => self.exchanged(cycle, answer),
            Some(
                dp::Service::SetSlaveAdd
                | dp::Service::RdInp
                | dp::Service::RdOutp
                | dp::Service::GlobalControl
                | dp::Service::GetCfg,
            ) => {}
            None => self.acyclic_answered(cycle, answer),
        }
    }

    /// A request to a station that is not configured in the master.
    fn stranger_asked(&mut self, cycle: &Cycle) {
        self.strangers.insert(cycle.to.number());
        let weight = match cycle.service {
            Some(
                dp::Service::SetPrm
                | dp::Service::ChkCfg
                | dp::Service::DataExchange
                | dp::Service::SetSlaveAdd,
            ) => Weight::Once,
            Some(dp::Service::SlaveDiag) => Weight::Times(5),
            Some(
                dp::Service::RdInp | dp::Service::RdOutp | dp::Service::GlobalControl | dp::Service::GetCfg,
            )
            | None => return,
        };
        let name = cycle.service.map_or("", dp::Service::name);
        if self.is_of_owner(cycle.service) {
            let reason =
                format!("{name} to station {}, which only the master that owns it may send", cycle.to);
            self.broken(Row::R09, weight, cycle.serial, None, reason.clone());
            return self.broken(Row::U12, weight, cycle.serial, None, reason);
        }
        let reason = format!("{name} to station {}, which is not configured in the master", cycle.to);
        self.broken(Row::U12, weight, cycle.serial, None, reason);
    }
}
