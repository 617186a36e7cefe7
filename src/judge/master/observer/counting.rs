//! Rows C: the frame count bit, retries; and what the bit tells of bad replies (rows E).

use crate::map::Map;

use super::Observer;
use super::cycle::{Answer, Bad, Cycle, Relation};
use super::view::{Disturbance, Disturbed, Loss};
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Slave;
use crate::profibus::dp;
use crate::profibus::fdl::{FrameCount, Service};
use crate::time::Instant;

/// A master never repeats more often than this.
const MOST_RETRIES: u32 = 15;
/// Octets of the shortest diagnosis.
const LEAST_DIAG: usize = 6;
/// Cycles in a row with a good reply each, before a bit that stays is a mistake.
const SOUND: u32 = 3;

/// Rows about what a master makes of replies that are new.
const REPEATED: &[Row] = &[
    Row::D01,
    Row::D02,
    Row::D03,
    Row::D06,
    Row::D07,
    Row::D13,
    Row::D15,
    Row::E03,
    Row::E04,
    Row::L03,
    Row::L05,
    Row::U05,
    Row::U06,
];

/// One bit for all stations, as a wrong master has it.
#[derive(Debug, Default)]
pub(super) struct Common {
    bit: Option<bool>,
    /// How often it went on over all stations where that of the station did not.
    toggles: Map<u8, u32>,
    /// Counted requests, and how many had the other bit than the one before, whatever its station.
    all: u32,
    toggled: u32,
    /// How often it stayed from one service to another, by the second.
    stuck: Map<&'static str, u32>,
}

impl Observer {
    /// A request beside the one before to the same station.
    pub(super) fn judge_count(&mut self, before: Option<&Cycle>, cycle: &mut Cycle) {
        let station = cycle.to;
        if !matches!(cycle.kind, Service::SrdLow | Service::SrdHigh) {
            return;
        }
        let common = self.common_bit(cycle);
        if cycle.count == FrameCount::First {
            self.view(station).anew = true;
        }
        if cycle.count == FrameCount::Unused {
            self.broken(
                Row::C01,
                Weight::Once,
                cycle.serial,
                Some(station),
                "SRD with FCV = 0 and FCB = 0; expected FCB = 1 in a first cycle",
            );
        }
        let Some(before) = before else {
            if self.view(station).asked.is_some() {
                return;
            }
            match (cycle.count, self.sight) {
                (FrameCount::First, _) => self.held(Row::C01),
                (_, super::Sight::Recorded) | (FrameCount::Unused, _) => {}
                (FrameCount::Even | FrameCount::Odd, _) => {
                    let reason = format!("the first request to station {station} has FCV = 1");
                    self.broken(Row::C01, Weight::Once, cycle.serial, Some(station), reason);
                }
            }
            return;
        };
        cycle.tries = match before.answer() {
            Answer::Silence | Answer::Bad(_) => before.tries + 1,
            Answer::ShortAck | Answer::Data { .. } | Answer::Status(_) | Answer::Mixed => 0,
        };
        let relation = Relation::of(before, cycle);
        if before.void || before.answered_at.is_some_and(|at| self.is_late(before, at)) {
            // The reply may have come in the moment in which the master asked again.
            if relation == Relation::Repeated {
                cycle.retry = before.retry + 1;
            } else if relation == Relation::First {
                // It has given the station up, and a new start-up is right.
                self.view(station).disturbed = None;
            }
            return;
        }
        match before.answer() {
            Answer::Data { .. } if before.sd3 && self.is_plain(before) => {
                self.judge_sd3(before, cycle, relation);
            }
            Answer::ShortAck | Answer::Data { .. } if self.is_plain(before) => {
                self.judge_confirmed(before, cycle, relation, common);
            }
            // What is made of replies that cannot be right is judged elsewhere.
            Answer::ShortAck | Answer::Data { .. } | Answer::Status(_) | Answer::Mixed => {}
            Answer::Silence => self.judge_unanswered(before, cycle, relation, None),
            Answer::Bad(bad) => self.judge_unanswered(before, cycle, relation, Some(bad)),
        }
    }

    /// Whether a reply is the one that the service has: a master may reject any other.
    fn is_plain(&self, cycle: &Cycle) -> bool {
        let answer = cycle.answer();
        match cycle.service {
            Some(dp::Service::DataExchange) => {}
            Some(dp::Service::SlaveDiag) => {
                return matches!(answer, Answer::Data { octets, .. } if octets.len() >= LEAST_DIAG);
            }
            Some(
                dp::Service::SetSlaveAdd
                | dp::Service::RdInp
                | dp::Service::RdOutp
                | dp::Service::GlobalControl
                | dp::Service::GetCfg
                | dp::Service::SetPrm
                | dp::Service::ChkCfg,
            )
            | None => return true,
        }
        let configured = self.setup.slave(cycle.to).and_then(Slave::lengths);
        let sent = self.views.get(&cycle.to.number()).and_then(|view| view.lengths);
        let inputs = configured.or(sent).map(|lengths| usize::from(lengths.inputs));
        match answer {
            Answer::Data { octets, .. } => inputs.is_none_or(|inputs| octets.len() == inputs),
            Answer::ShortAck => inputs == Some(0),
            Answer::Silence | Answer::Status(_) | Answer::Bad(_) | Answer::Mixed => true,
        }
    }

    /// The request before was answered well.
    fn judge_confirmed(&mut self, before: &Cycle, cycle: &mut Cycle, relation: Relation, common: bool) {
        let station = cycle.to;
        let from = before.serial;
        let name = cycle.service.map_or("a request", dp::Service::name);
        // Behind something bad a receiver may need a telegram to find the beginning of the next.
        let sound = self.view(station).sound >= SOUND;
        match relation {
            Relation::Repeated if !sound => cycle.retry = before.retry + 1,
            Relation::SameBit if !sound => {}
            Relation::Toggled => self.held(Row::C02),
            // The user ends the master, or it gives the slave up.
            Relation::First if self.is_release(cycle) => {}
            Relation::First => match cycle.service {
                Some(dp::Service::DataExchange | dp::Service::ChkCfg | dp::Service::SetPrm) => {
                    let reason = format!("{name} with FCV = 0 after an answered cycle");
                    self.broken(Row::C02, Weight::Times(2), from, Some(station), reason);
                }
                Some(
                    dp::Service::SlaveDiag
                    | dp::Service::SetSlaveAdd
                    | dp::Service::RdInp
                    | dp::Service::RdOutp
                    | dp::Service::GlobalControl
                    | dp::Service::GetCfg,
                )
                | None => {}
            },
            Relation::Repeated => {
                cycle.retry = before.retry + 1;
                self.count_common(common, station.number());
                let reason = format!("{name} with the FCB of the cycle before, which was answered");
                self.broken(Row::C02, Weight::Share(3, 100), from, Some(station), reason);
            }
            Relation::SameBit => {
                self.count_common(common, station.number());
                let reason = format!("{name} with the FCB of the cycle before, which was answered");
                self.broken(Row::C02, Weight::Share(3, 100), from, Some(station), reason);
                // Between services nothing but a mistake explains it.
                if before.service != cycle.service {
                    self.stuck_bit(from, cycle);
                }
            }
            Relation::Uncounted => {}
        }
    }

    /// A reply of eight octets came as SD3, which is as right as SD2.
    fn judge_sd3(&mut self, before: &Cycle, cycle: &mut Cycle, relation: Relation) {
        match relation {
            Relation::Toggled => self.held(Row::X07),
            Relation::Repeated | Relation::SameBit | Relation::First => {
                if relation == Relation::Repeated {
                    cycle.retry = before.retry + 1;
                }
                let reason = "a reply of eight octets as SD3 is not accepted";
                self.broken(Row::X07, Weight::Share(2, 300), before.serial, Some(cycle.to), reason);
            }
            Relation::Uncounted => {}
        }
    }

    /// The bit stayed from one service to the next.
    fn stuck_bit(&mut self, from: u64, cycle: &Cycle) {
        let name = cycle.service.map_or("a request", dp::Service::name);
        let stuck = self.common.stuck.or_default(name);
        *stuck += 1;
        if *stuck >= 3 {
            let reason = format!("{name} has the FCB of the service before it, which was answered");
            self.broken(Row::C02, Weight::Once, from, Some(cycle.to), reason);
        }
    }

    /// The request before was not answered, or badly.
    fn judge_unanswered(&mut self, before: &Cycle, cycle: &mut Cycle, relation: Relation, bad: Option<Bad>) {
        let station = cycle.to;
        let from = before.serial;
        let name = cycle.service.map_or("a request", dp::Service::name);
        let same_service = before.service == cycle.service;
        let what = if bad.is_some() { "a bad reply" } else { "no reply" };
        let broken = |observer: &mut Self, row: Row, reason| {
            // One may be due to a reply from before that was still under way.
            let may_be_late = [Row::C03, Row::C05, Row::C12].contains(&row);
            let weight = if may_be_late { Weight::Times(2) } else { Weight::Once };
            observer.broken(row, weight, from, Some(station), reason);
        };
        let bad_row = bad.map(row_of);
        match relation {
            Relation::Repeated => {
                cycle.retry = before.retry + 1;
                self.held(Row::C03);
                self.held(Row::C04);
                self.held(Row::C05);
                if let Some(row) = bad_row {
                    self.held(row);
                    self.held(Row::C12);
                }
                self.judge_retries(before, cycle);
                self.note_lost_reply(before, bad);
                return;
            }
            Relation::First if before.is_counted() => {
                self.held(Row::C07);
                if let Some(row) = bad_row.filter(|row| *row != Row::E01) {
                    self.held(row);
                }
                // The replies to the tries before may have come too late.
                if before.tries > 0 || before.retry > 0 {
                    self.held(Row::C06);
                } else if self.setup.retries != Some(0) && self.view(station).answered {
                    let row = if bad == Some(Bad::Fcs) { Row::C12 } else { Row::C05 };
                    if bad.is_none() || bad == Some(Bad::Fcs) {
                        let reason = format!(
                            "{name} with FCV = 0 after {what}: the station is given up without a retry"
                        );
                        broken(self, row, reason);
                    }
                }
            }
            Relation::First => {
                if before.octets == cycle.octets {
                    self.judge_first_again(before, cycle);
                }
                if let Some(row) = bad_row {
                    self.held(row);
                }
                return;
            }
            Relation::Toggled | Relation::SameBit if !before.is_counted() => {
                let reason = format!("{name} with FCV = 1 after a first cycle with {what}");
                broken(self, bad_row.unwrap_or(Row::C07), reason);
            }
            // The data link layer may take it, DP must not.
            Relation::Toggled if bad == Some(Bad::Saps) && cycle.service == Some(dp::Service::SlaveDiag) => {
                self.held(Row::E14);
            }
            Relation::Toggled => {
                let reason = format!("{name} with the other FCB after {what} to {}", name_of(before));
                let row = match bad_row {
                    Some(row) => row,
                    None if same_service => Row::C03,
                    None => Row::C07,
                };
                broken(self, row, reason);
            }
            Relation::SameBit if same_service => {
                self.held(Row::C03);
                self.held(Row::C05);
                if let Some(row) = bad_row {
                    self.held(row);
                    self.held(Row::C12);
                }
                let reason =
                    format!("{name} with the FCB of the request that got {what}, and with other octets");
                broken(self, Row::C04, reason);
                self.note_lost_reply(before, bad);
            }
            Relation::SameBit => {
                let reason = format!(
                    "{name} with FCV = 1 after {} got {what}: expected FCV = 0, FCB = 1",
                    name_of(before)
                );
                broken(self, Row::C07, reason);
            }
            Relation::Uncounted => {}
        }
        // The master has gone on.
        if relation == Relation::First || !same_service {
            self.note_loss(cycle);
            let view = self.view(station);
            let prm = view.prm;
            view.gave_up = true;
            view.over = true;
            view.lose(Loss::Silent);
            // That it got no answer is what the next step is judged by.
            if before.service == Some(dp::Service::SetPrm) {
                view.prm = prm;
            }
        }
    }

    /// From now on a new start-up shows whether one lost reply is a reason for it.
    fn note_lost_reply(&mut self, before: &Cycle, bad: Option<Bad>) {
        let view = self.view(before.to);
        if view.exchanging {
            let what = if bad.is_none() { Disturbance::LostReply } else { Disturbance::BadReply };
            view.disturbed = Some(Disturbed { what, age: 0, serial: before.serial });
        }
    }

    fn judge_retries(&mut self, before: &Cycle, cycle: &Cycle) {
        let limit = self.setup.retries.unwrap_or(MOST_RETRIES);
        // Once it should have given up, the wrong bit is what is wrong (C07).
        if cycle.retry > limit && before.is_counted() && !self.view(cycle.to).over {
            let expected = if self.setup.retries.is_some() { "as configured" } else { "at most" };
            let reason = format!(
                "{} is repeated for the {}th time; expected {limit} retries {expected}",
                name_of(cycle),
                cycle.retry
            );
            let from = cycle.serial.saturating_sub(u64::from(cycle.retry));
            self.broken(Row::C06, Weight::Once, from, Some(cycle.to), reason);
        }
    }

    /// A first cycle is sent again after silence.
    fn judge_first_again(&mut self, before: &Cycle, cycle: &Cycle) {
        let station = cycle.to;
        let others = self.setup.stations.iter().any(|slave| {
            slave.address != station
                && self.views.get(&slave.address.number()).is_some_and(|view| view.calm > 4)
        });
        if !others {
            let reason = "with no other station in data exchange a retry cannot be told from the next cycle";
            self.findings.obstacle(Row::C10, reason);
            self.findings.obstacle(Row::C11, reason);
            return;
        }
        let view = self.view(station);
        view.first_run += 1;
        let first = view.first_run == 1;
        let at_once = cycle.serial == before.serial + 1;
        let rows: &[Row] = if first { &[Row::C10, Row::C11] } else { &[Row::C10] };
        for row in rows {
            if at_once {
                let reason = format!("{} with FCV = 0 is repeated at once after no reply", name_of(cycle));
                self.broken(*row, Weight::Share(3, 400), before.serial, None, reason);
            } else {
                self.held(*row);
            }
        }
    }

    /// Whether the bit goes on as if all stations had one. Only telling where the station's own does not.
    fn common_bit(&mut self, cycle: &Cycle) -> bool {
        let bit = match cycle.count {
            FrameCount::Odd => true,
            FrameCount::Even => false,
            FrameCount::First | FrameCount::Unused => return false,
        };
        let toggled = self.common.bit.replace(bit).is_some_and(|last| last != bit);
        self.common.all += 1;
        self.common.toggled += u32::from(toggled);
        toggled
    }

    fn count_common(&mut self, common: bool, station: u8) {
        if common {
            *self.common.toggles.or_default(station) += 1;
        }
    }

    /// A slave answers a request with the FCB of before from its buffer: the master never learns of what is new.
    fn void_what_repeats(&mut self) {
        let reason = "void: the FCB of the master does not toggle, so slaves repeat old replies (M-C02)";
        for row in REPEATED {
            self.findings.void(*row, reason);
        }
    }

    pub(super) fn finish_counting(&mut self) {
        let stations = self.common.toggles.values().filter(|count| **count >= 3).count();
        let c02 = self.findings.judgement(Row::C02);
        if c02.verdict == crate::judge::Verdict::Fail {
            self.void_what_repeats();
        }
        let present = self.setup.stations.len();
        let common = self.common.toggled * 10 > self.common.all * 9;
        if stations >= 2 && common {
            let reason = "the FCB toggles over the requests to all stations, not for each station by itself";
            match c02.verdict {
                crate::judge::Verdict::Fail => {
                    let moments = self.findings.moments(Row::C02);
                    self.findings.broken(Row::C08, Weight::Once, reason.into(), moments);
                }
                crate::judge::Verdict::Pass
                | crate::judge::Verdict::Warn
                | crate::judge::Verdict::NotJudged => self.show(Row::C08, Weight::Once, reason.into()),
            }
        } else if c02.verdict == crate::judge::Verdict::Fail {
            self.findings.obstacle(Row::C08, "the FCB is wrong in another way, see M-C02");
        } else if present >= 2 && common {
            let reason = "with an odd number of stations one FCB for all of them looks the same";
            self.findings.missed(Row::C08, reason);
        } else if present >= 2 && self.findings.is_judged(Row::C02) {
            self.held(Row::C08);
        } else {
            self.findings.obstacle(Row::C08, "needs two stations in data exchange");
        }
    }

    /// Whether the reply came so late that the master may have stopped waiting.
    pub(super) fn is_late(&self, cycle: &Cycle, answered: Instant) -> bool {
        let after = answered.saturating_since(cycle.end);
        let slot = self.setup.slot.or(self.timing.usual_wait());
        slot.is_some_and(|slot| after * 4 > slot)
    }
}

fn name_of(cycle: &Cycle) -> &'static str {
    cycle.service.map_or("the request", dp::Service::name)
}

/// The row about a bad reply.
const fn row_of(bad: Bad) -> Row {
    match bad {
        Bad::Fcs => Row::E01,
        Bad::Truncated => Row::E02,
        Bad::Delimiters => Row::E15,
        Bad::WrongSource | Bad::WrongDestination => Row::E05,
        Bad::RequestBit | Bad::StationType => Row::E13,
        Bad::Saps => Row::E14,
        Bad::Noise | Bad::Ambiguous => Row::E12,
    }
}
