//! Rows X, and those of D, E and L that show while data are exchanged.

use core::time::Duration;

use super::Observer;
use super::cycle::{Answer, Cycle};
use super::view::{Disturbed, Due, Loss, Refused, Step, WrongReplies};
use crate::judge::Verdict;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Slave;
use crate::profibus::dp;
use crate::profibus::fdl::ReplyStatus;
use crate::profibus::fdl::Telegram;
use crate::profibus::fdl::telegram::{Decoded, Format, decode};

/// Data_Exchange at most before an announced diagnosis is read.
pub(super) const MOST_BEFORE_DIAG: u32 = 12;
/// Data_Exchange at most before a start-up that a diagnosis asks for.
const MOST_BEFORE_RESTART: u32 = 8;
/// Replies that cannot be right, at least so many and for so long, before the diagnosis is read.
const MOST_WRONG: u32 = 8;
const WRONG_TIME: Duration = Duration::from_millis(1500);
/// Data_Exchange answered with RS, for so long, without a diagnosis.
const REFUSED_TIME: Duration = Duration::from_secs(1);
/// After so many good exchanges a disturbance is over.
const OVER: u32 = 6;
/// Kept to see how fast a station is asked.
const INTERVALS: usize = 4096;

impl Observer {
    /// A Data_Exchange begins.
    pub(super) fn judge_exchange(&mut self, cycle: &Cycle) {
        let station = cycle.to;
        let from = cycle.serial.saturating_sub(8);
        self.judge_outputs(cycle);
        let view = self.view(station);
        view.last_outputs = Some(cycle.data().to_vec());
        view.polled = view.polled.saturating_add(1);
        let (exchanging, gave_up, loss, prm) = (view.exchanging, view.gave_up, view.loss, view.prm);
        view.diagnoses = 0;
        view.not_ready = None;
        let now = cycle.end;
        if gave_up {
            let reason = "Data_Exchange after the retries to a silent slave were over";
            self.broken(Row::L01, Weight::Times(2), from, Some(station), reason);
        }
        // What the master can know from a diagnosis since it lost the slave.
        let view = self.view(station);
        let needs_start_up = view.diag_read
            && prm == Step::None
            && loss != Loss::None
            && view.diag.is_some_and(|diag| diag.prm_req);
        let taken = view.diag_read && loss == Loss::Refused && exchanging;
        let other = view.diag.filter(|_| taken);
        if needs_start_up {
            let row = if loss == Loss::Refused { Row::L03 } else { Row::L02 };
            let reason = "Data_Exchange although the diagnosis says that the slave must be parameterised";
            self.broken(row, Weight::Times(2), from, Some(station), reason);
        } else if let Some(owner) = other.and_then(|diag| diag.master)
            && Some(owner) != self.master
        {
            let reason =
                format!("Data_Exchange although the diagnosis says that master {owner} owns the slave");
            self.broken(Row::L05, Weight::Once, from, Some(station), reason);
        }
        if !exchanging {
            self.judge_first_exchange(cycle);
        }
        let view = self.view(station);
        if let Some(due) = &mut view.announced {
            due.exchanges += 1;
            if due.exchanges > MOST_BEFORE_DIAG {
                let Due { row, serial, .. } = *due;
                view.announced = None;
                let reason = format!(
                    "{MOST_BEFORE_DIAG} Data_Exchange after a reply of high priority, and no Slave_Diag"
                );
                self.broken(row, Weight::Once, serial, Some(station), reason);
            }
        }
        let view = self.view(station);
        if let Some(due) = &mut view.restart_due {
            due.exchanges += 1;
            if due.exchanges > MOST_BEFORE_RESTART {
                let Due { row, serial, .. } = *due;
                view.restart_due = None;
                let reason = format!(
                    "{MOST_BEFORE_RESTART} Data_Exchange after a diagnosis that asks for a new start-up, and no Set_Prm"
                );
                self.broken(row, Weight::Once, serial, Some(station), reason);
            }
        }
        let view = self.view(station);
        if let Some(WrongReplies { row, since, count, serial }) = view.wrong_replies
            && count >= MOST_WRONG
            && now.saturating_since(since) >= WRONG_TIME
        {
            view.wrong_replies = None;
            let reason = format!("{count} replies in a row that cannot be right, and no Slave_Diag");
            self.broken(row, Weight::Once, serial, Some(station), reason);
        }
        let view = self.view(station);
        if let Some(Refused { since, count, serial }) = view.refused
            && count >= MOST_WRONG
            && now.saturating_since(since) >= REFUSED_TIME
        {
            view.refused = None;
            let reason = format!("{count} Data_Exchange in a row are answered with RS, and no Slave_Diag");
            self.broken(Row::L03, Weight::Once, serial, Some(station), reason);
        }
    }

    /// What a Data_Exchange carries.
    fn judge_outputs(&mut self, cycle: &Cycle) {
        let station = cycle.to;
        let data = cycle.data().to_vec();
        self.held(Row::X02);
        let slave = self.setup.slave(station).cloned();
        let lengths = slave.as_ref().and_then(Slave::lengths);
        let sent = self.view(station).lengths;
        self.judge_clear(cycle, &data, slave.as_ref());
        let empty = data.is_empty() && lengths.is_some_and(|lengths| lengths.outputs > 0);
        if empty {
            return;
        }
        if let Some(lengths) = lengths {
            let right = data.len() == usize::from(lengths.outputs);
            if lengths.outputs == 0 {
                let sd1 = matches!(
                    decode(&cycle.octets),
                    Decoded::Telegram { telegram: Telegram::Data(data), .. } if data.format == Format::Sd1
                );
                if right && sd1 {
                    self.held(Row::X05);
                } else {
                    let reason = "Data_Exchange with data to a station that has inputs only";
                    self.broken(Row::X05, Weight::Once, cycle.serial, Some(station), reason);
                }
            }
            if right {
                self.held(Row::X01);
            } else {
                let reason = format!("{} octets of outputs, expected {}", data.len(), lengths.outputs);
                self.broken(Row::X01, Weight::Once, cycle.serial, Some(station), reason);
            }
        }
        if let Some(sent) = sent {
            if data.len() == usize::from(sent.outputs) {
                self.held(Row::G02);
            } else {
                let reason = format!(
                    "{} octets of outputs; the identifiers of Chk_Cfg have {}",
                    data.len(),
                    sent.outputs
                );
                self.broken(Row::G02, Weight::Once, cycle.serial, Some(station), reason);
            }
        }
    }

    /// What a Data_Exchange led to.
    pub(super) fn exchanged(&mut self, cycle: &Cycle, answer: &Answer) {
        let lengths = self.setup.slave(cycle.to).and_then(Slave::lengths);
        let known = self.view(cycle.to).lengths;
        let inputs = lengths.or(known).map(|lengths| usize::from(lengths.inputs));
        let view = self.view(cycle.to);
        let now = cycle.end;
        match answer {
            Answer::Data { high, octets } if inputs.is_none_or(|inputs| octets.len() == inputs) => {
                self.good_exchange(cycle, *high, octets.len());
            }
            Answer::ShortAck if inputs.is_none_or(|inputs| inputs == 0) => {
                self.good_exchange(cycle, false, 0)
            }
            Answer::Data { .. } | Answer::ShortAck => {
                let row = if *answer == Answer::ShortAck { Row::E03 } else { Row::E04 };
                view.trouble();
                view.exchanging = true;
                let wrong_replies = view.wrong_replies.get_or_insert(WrongReplies {
                    row,
                    since: now,
                    count: 0,
                    serial: cycle.serial,
                });
                wrong_replies.count += 1;
            }
            Answer::Status(ReplyStatus::NotActivated) => {
                view.trouble();
                let first = Refused { since: now, count: 0, serial: cycle.serial };
                view.refused.get_or_insert(first).count += 1;
                if view.loss == Loss::None {
                    view.lose(Loss::Refused);
                }
            }
            Answer::Status(_) => {
                view.trouble();
                // It is a reason of its own for a new start-up.
                view.disturbed = None;
            }
            Answer::Silence | Answer::Bad(_) | Answer::Mixed => view.trouble(),
        }
    }

    fn good_exchange(&mut self, cycle: &Cycle, high: bool, inputs: usize) {
        // One that is off, or comes later, is asked less.
        let all = self.setup.present().all(|slave| {
            slave.address == cycle.to
                || self.views.get(&slave.address.number()).is_some_and(|view| view.calm > 0)
        });
        let watching = u32::from(self.watching && all);
        let view = self.view(cycle.to);
        view.undisturbed += watching;
        let begins = !view.exchanging;
        view.exchanging = true;
        view.loss = Loss::None;
        view.refused = None;
        view.wrong_replies = None;
        view.streak = view.streak.saturating_add(1);
        view.calm = view.calm.saturating_add(1);
        view.exchanges = view.exchanges.saturating_add(1);
        if begins {
            view.start_ups += 1;
            view.anew = false;
        }
        let mut over = None;
        if let Some(Disturbed { what, age, .. }) = &mut view.disturbed {
            *age += 1;
            if *age >= OVER {
                over = Some(what.proves());
            }
        }
        if over.is_some() {
            view.disturbed = None;
        }
        if view.calm >= OVER {
            view.excused = None;
        }
        let shown = view.shown;
        if begins {
            for (seen, row) in [(shown.prm_fault, Row::D04), (shown.cfg_fault, Row::D05)] {
                if seen {
                    self.held(row);
                }
            }
        }
        let view = self.view(cycle.to);
        if high {
            view.dh_in_row = view.dh_in_row.saturating_add(1);
            let faulty = view.diag.is_some_and(|diag| diag.ext_diag);
            let row = match inputs {
                0 => Row::D11,
                _ if faulty => Row::D13,
                _ => Row::D01,
            };
            view.announced.get_or_insert(Due::new(row, cycle.serial));
        } else {
            view.dh_in_row = 0;
            view.announced = None;
        }
        if let Some(row) = over.flatten() {
            self.held(row);
        }
        let lengths = self.view(cycle.to).lengths;
        if lengths.is_some_and(|lengths| lengths.inputs == 244 && lengths.outputs == 244) {
            self.held(Row::X08);
        }
        if lengths.is_some_and(|lengths| lengths.inputs == 0) && self.view(cycle.to).calm == OVER {
            self.held(Row::X06);
        }
    }

    /// The time since a station was asked.
    pub(super) fn judge_interval(&mut self, cycle: &Cycle, retry: bool) {
        let now = cycle.end;
        let away = self.timing.away_since();
        let view = self.view(cycle.to);
        let before = view.asked.replace(now);
        let before_len = core::mem::replace(&mut view.asked_len, cycle.octets.len());
        let (exchanging, watchdog) = (view.exchanging && view.loss == Loss::None, view.watchdog);
        let Some(before) = before.filter(|before| away.is_none_or(|away| away < *before)) else { return };
        let interval = now.saturating_since(before);
        if !retry && cycle.service.is_some() {
            if view.intervals.len() < INTERVALS {
                view.intervals.push(interval);
            }
            self.judge_exact_interval(cycle, interval, before_len);
        }
        if !exchanging || cycle.service != Some(dp::Service::DataExchange) {
            return;
        }
        if let Some(watchdog) = watchdog {
            if self.timing.was_paused() {
                return;
            }
            if interval > watchdog {
                let reason = format!(
                    "station {} was not asked for {} ms; its watchdog time is {} ms",
                    cycle.to,
                    interval.as_millis(),
                    watchdog.as_millis()
                );
                // A process that sleeps now and then explains fewer.
                self.broken(Row::T08, Weight::Share(3, 3), cycle.serial.saturating_sub(8), None, reason);
            } else {
                self.held(Row::T08);
            }
        }
    }

    pub(super) fn finish_exchange(&mut self) {
        self.finish_absent();
        let with = |observer: &Self, fits: &dyn Fn(&Slave) -> bool| observer.setup.present().any(fits);
        let lengths = |slave: &Slave| slave.lengths().unwrap_or_default();
        for (row, there, what) in [
            (Row::X05, with(self, &|slave| lengths(slave).outputs == 0), "a station with inputs only"),
            (Row::X06, with(self, &|slave| lengths(slave).inputs == 0), "a station with outputs only"),
            (Row::D11, with(self, &|slave| lengths(slave).inputs == 0), "a station with outputs only"),
            (
                Row::X07,
                with(self, &|slave| lengths(slave).inputs == 8),
                "a station with eight octets of inputs",
            ),
            (
                Row::X08,
                with(self, &|slave| lengths(slave).inputs == 244 && lengths(slave).outputs == 244),
                "a station with 244 octets each way",
            ),
        ] {
            if !there {
                self.findings.obstacle(row, format!("needs {what}"));
            }
        }
    }

    /// With half of the stations absent the watchdogs of the others are at stake.
    fn finish_absent(&mut self) {
        let (all, present) = (self.setup.stations.len(), self.setup.present().count());
        if all == 0 || present * 2 > all {
            return;
        }
        let watchdogs = self.findings.judgement(Row::T08);
        match watchdogs.verdict {
            Verdict::Pass => self.held(Row::I07),
            Verdict::Fail | Verdict::Warn => {
                let moments = self.findings.moments(Row::T08);
                self.findings.broken(Row::I07, Weight::Once, watchdogs.reason, moments);
            }
            Verdict::NotJudged => {}
        }
    }
}
