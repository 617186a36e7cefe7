//! Rows V: what a master asks of a slave by the services of DP-V1, and how it waits for the response (`dp-v1.md` 1 to 4).
//!
//! ```text
//! request ──SC──▶ job ──poll, SC──▶ job ──poll, response──▶ over
//! ```

use core::time::Duration;
use std::collections::BTreeMap;

use super::cycle::{Answer, Cycle};
use super::view::{Disturbance, Disturbed};
use super::{Observer, Sight};
use crate::explain::hex;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Slave;
use crate::profibus::dp;
use crate::profibus::dp::dpv1_status::Status1;
use crate::profibus::dp::set_prm::FIXED_LEN;
use crate::profibus::dpv1::{ALARM_SAP, ErrorCode, MS1_SAP, RESOURCE_MANAGER_SAP, RequestPdu, ResponsePdu};
use crate::profibus::fdl::{Address, ReplyStatus};
use crate::time::Instant;

/// The SAP of a master of class 2.
pub(super) const CLASS_2_SAP: u8 = 50;
/// A job that is younger is not given up, unless C1_Response_Timeout says less.
const PATIENCE: Duration = Duration::from_secs(1);
/// So many times C1_Response_Timeout a job is no longer polled for.
const OVERDUE: u32 = 3;
/// Other requests at most, and for how long, before a poll.
pub(in crate::judge::master) const MOST_BESIDE: u32 = 200;
const MOST_TIME: Duration = Duration::from_secs(1);
/// Polls in a row without Data_Exchange.
const MOST_POLLS: u32 = 20;
/// Polls for a job that ended with data exchange.
const MOST_OLD_POLLS: u32 = 10;
/// A job that was waited for: so many polls and for so long.
const WAITED_POLLS: u32 = 3;
const WAITED: Duration = Duration::from_millis(50);

/// What is known of the services of one slave.
#[derive(Clone, Debug, Default)]
pub(super) struct Services {
    /// What runs at each SAP of the slave.
    jobs: BTreeMap<u8, Job>,
    pub(super) connections: super::connections::Connections,
    pub(super) alarms: super::alarms::Alarms,
    /// A job at SAP 51 ended with data exchange: polls and Data_Exchange since the next one began.
    left_over: Option<(u32, u32)>,
}

/// A request that was acknowledged and has no response yet.
#[derive(Clone, Copy, Debug)]
struct Job {
    serial: u64,
    since: Instant,
    /// When the master last asked for its response.
    looked: Instant,
    polls: u32,
    /// Polls since the last Data_Exchange.
    in_row: u32,
    /// Other requests to the station since the last poll.
    beside: u32,
    /// What is wrong with it was said.
    told: bool,
}

impl Services {
    /// Whether the owner's job has no response after this time.
    pub(super) fn is_overdue(&self, now: Instant, patience: Duration) -> bool {
        self.jobs.get(&MS1_SAP).is_some_and(|job| now.saturating_since(job.since) >= patience)
    }

    /// Data exchange is over: so are the job and the alarms of the owner.
    pub(super) fn end_owners(&mut self) {
        let ended = self.jobs.remove(&MS1_SAP).is_some();
        self.jobs.remove(&ALARM_SAP);
        self.alarms.forget();
        if ended {
            self.left_over = Some((0, 0));
        }
    }
}

impl Observer {
    /// A request that is no service of DP, at a SAP of DP-V1.
    pub(super) fn judge_acyclic(&mut self, cycle: &Cycle) {
        let Some(sap) = cycle.dsap().filter(|sap| *sap <= MS1_SAP) else { return };
        let data = cycle.data().to_vec();
        if sap >= ALARM_SAP && !data.is_empty() {
            self.judge_channel(cycle, sap);
        }
        // From another SAP it is no request of DP-V1, which is row F06.
        if sap < ALARM_SAP && cycle.ssap() != Some(CLASS_2_SAP) {
            return;
        }
        self.note_service(cycle);
        if sap <= RESOURCE_MANAGER_SAP {
            self.judge_connection(cycle, sap, &data);
        }
        self.judge_order(cycle, sap, &data);
        if data.is_empty() {
            return;
        }
        let pdu = RequestPdu::parse(&data);
        let fits = match pdu {
            Ok(RequestPdu::AlarmAck(head)) => sap >= ALARM_SAP && head.slot != u8::MAX,
            Ok(RequestPdu::Read { slot, len, .. }) => sap != ALARM_SAP && slot != u8::MAX && len != 0,
            Ok(RequestPdu::Write { slot, data, .. }) => {
                sap != ALARM_SAP && slot != u8::MAX && !data.is_empty()
            }
            Ok(RequestPdu::DataTransport { .. } | RequestPdu::Idle | RequestPdu::Abort(_)) => {
                sap < RESOURCE_MANAGER_SAP
            }
            Ok(RequestPdu::Initiate(_)) => sap == RESOURCE_MANAGER_SAP,
            Err(_) => false,
        };
        let reason = (!fits).then(|| match pdu {
            Ok(_) => format!("SAP {sap} is asked with {}: not a request of that SAP", hex(&data)),
            Err(error) => format!("SAP {sap} is asked with {}: {error}", hex(&data)),
        });
        self.verdict_of(cycle, Row::V02, reason);
        match pdu {
            Ok(RequestPdu::AlarmAck(head)) if sap >= ALARM_SAP => self.judge_acknowledgement(cycle, head),
            Ok(RequestPdu::Write { data, .. }) => self.judge_write(cycle, sap, data.len()),
            Ok(
                RequestPdu::AlarmAck(_)
                | RequestPdu::Read { .. }
                | RequestPdu::DataTransport { .. }
                | RequestPdu::Idle
                | RequestPdu::Abort(_)
                | RequestPdu::Initiate(_),
            )
            | Err(_) => {}
        }
    }

    /// A request to the owner's channel.
    fn judge_channel(&mut self, cycle: &Cycle, sap: u8) {
        let view = self.view(cycle.to);
        let reason = match (view.exchanging, view.enables_dpv1()) {
            (true, true) => None,
            (false, _) => Some(format!("SAP {sap} is asked outside of data exchange")),
            (true, false) => Some(format!("SAP {sap} is asked, and DPV1_Enable in octet 8 of Set_Prm was 0")),
        };
        self.verdict_of(cycle, Row::V01, reason);
        let offer = self.setup.slave(cycle.to).map(Slave::offer);
        if let Some(offer) = offer.filter(|_| sap == ALARM_SAP) {
            let missing = !offer.alarms.extra_sap;
            let reason =
                missing.then(|| "SAP 50 is asked, and the slave has no Extra_Alarm_SAP_supp".to_owned());
            self.verdict_of(cycle, Row::V13, reason);
        }
    }

    /// How long a job of a station is waited for.
    pub(super) fn patience(&self, station: Address) -> Duration {
        let said = self.setup.slave(station).and_then(Slave::response_timeout);
        said.map_or(PATIENCE, |said| said.min(PATIENCE))
    }

    /// A request or a poll beside what runs at its SAP.
    fn judge_order(&mut self, cycle: &Cycle, sap: u8, data: &[u8]) {
        let (now, patience) = (cycle.end, self.patience(cycle.to));
        let limit = self.setup.slave(cycle.to).and_then(Slave::response_timeout).filter(|_| sap >= ALARM_SAP);
        let view = self.view(cycle.to);
        let exchanging = view.exchanging;
        let services = &mut view.services;
        let Some(job) = services.jobs.get_mut(&sap) else {
            match (data.is_empty(), &mut services.left_over) {
                (true, Some((polls, _))) if sap == MS1_SAP && exchanging => {
                    *polls += 1;
                    if *polls > MOST_OLD_POLLS {
                        services.left_over = None;
                        let reason =
                            format!("{MOST_OLD_POLLS} polls for a job that ended with data exchange");
                        self.verdict_of(cycle, Row::V10, Some(reason));
                    }
                }
                (false, left_over) => {
                    let ended = sap == MS1_SAP && left_over.take().is_some();
                    self.held(Row::V03);
                    if ended {
                        self.held(Row::V10);
                    }
                }
                (true, _) => {}
            }
            return;
        };
        let age = now.saturating_since(job.since);
        let from = job.serial;
        if data.is_empty() {
            (job.looked, job.beside) = (now, 0);
            job.in_row += 1;
            let starves = exchanging && job.in_row > MOST_POLLS;
            let late = limit.is_some_and(|limit| age > limit * OVERDUE) && !job.told;
            job.told |= late;
            if starves {
                job.in_row = 0;
                let reason =
                    format!("{MOST_POLLS} polls in a row, and no Data_Exchange with the slave between");
                self.broken(Row::V06, Weight::Once, from, Some(cycle.to), reason);
            }
            if late {
                let (age, limit) = (age.as_millis(), limit.unwrap_or_default().as_millis());
                let reason = format!("polls {age} ms after the request; C1_Response_Timeout is {limit} ms");
                self.broken(Row::V09, Weight::Once, cycle.serial, Some(cycle.to), reason);
            }
            return;
        }
        let (is_young, told) = (age < patience, job.told);
        services.jobs.remove(&sap);
        let abort = matches!(RequestPdu::parse(data), Ok(RequestPdu::Abort(_)));
        if !is_young || told {
            return;
        }
        let (row, what) = if abort { (Row::V05, "Abort") } else { (Row::V03, "another request") };
        let reason =
            format!("{what} {} ms after a request at SAP {sap} that has no response yet", age.as_millis());
        self.broken(row, Weight::Once, from, Some(cycle.to), reason);
    }

    /// More data than the slave takes.
    fn judge_write(&mut self, cycle: &Cycle, sap: u8, octets: usize) {
        let offered = self.setup.slave(cycle.to).and_then(|slave| slave.offer().ms1);
        let most = match sap {
            MS1_SAP => offered,
            _ => self.view(cycle.to).services.connections.most_data(sap),
        };
        let Some(most) = most else { return };
        let reason = (octets > usize::from(most))
            .then(|| format!("Write with {octets} octets of data, the slave takes {most} at most"));
        self.verdict_of(cycle, Row::V08, reason);
    }

    /// Any request to a station, beside what runs at its SAPs.
    pub(super) fn judge_beside(&mut self, cycle: &Cycle) {
        let exchange = cycle.service == Some(dp::Service::DataExchange);
        let begins = cycle.service == Some(dp::Service::SetPrm);
        let limit = self.setup.slave(cycle.to).and_then(Slave::response_timeout);
        self.judge_idle(cycle);
        let services = &mut self.view(cycle.to).services;
        let (mut unpolled, mut given_up, mut forgotten) = (None, false, false);
        for (sap, job) in services.jobs.iter_mut().filter(|(sap, _)| cycle.dsap() != Some(**sap)) {
            job.beside += 1;
            if exchange {
                job.in_row = 0;
            }
            let silent = cycle.end.saturating_since(job.looked);
            if job.beside > MOST_BESIDE && silent > MOST_TIME && job.polls == 0 && !job.told {
                job.told = true;
                unpolled = Some((job.serial, *sap, silent));
            }
            given_up |= *sap == MS1_SAP
                && limit.is_some_and(|limit| {
                    let age = cycle.end.saturating_since(job.since);
                    let waited = job.polls > 0 && age > limit * OVERDUE && silent > limit;
                    !job.told && (waited || begins && age >= limit)
                });
        }
        if given_up {
            services.jobs.remove(&MS1_SAP);
        }
        if let Some((_, exchanges)) = services.left_over.as_mut().filter(|_| exchange) {
            *exchanges += 1;
            forgotten = *exchanges > MOST_BESIDE;
        }
        if forgotten {
            services.left_over = None;
            self.held(Row::V10);
        }
        if given_up {
            self.held(Row::V09);
        }
        if let Some((serial, sap, silent)) = unpolled {
            let reason = format!("no poll at SAP {sap} within {} ms after a request", silent.as_millis());
            self.broken(Row::V04, Weight::Once, serial, Some(cycle.to), reason);
        }
        if exchange {
            self.judge_alarms(cycle);
        }
    }

    /// What a request or a poll at a SAP of DP-V1 led to.
    pub(super) fn acyclic_answered(&mut self, cycle: &Cycle, answer: &Answer) {
        let Some(sap) = cycle.dsap().filter(|sap| *sap <= MS1_SAP) else { return };
        let data = cycle.data().to_vec();
        let (now, patience) = (cycle.end, self.patience(cycle.to));
        let view = self.view(cycle.to);
        let calm = view.calm > 0 && view.exchanging;
        match answer {
            Answer::ShortAck if data.is_empty() => {
                let Some(job) = view.services.jobs.get_mut(&sap) else { return };
                job.polls += 1;
                // Who starts the slave anew now does it because the job takes long.
                let age = now.saturating_since(job.since);
                let serial = job.serial;
                if age >= patience {
                    view.disturbed =
                        view.disturbed.filter(|disturbed| disturbed.what != Disturbance::SlowJob);
                } else if calm && sap >= ALARM_SAP {
                    view.disturb(Disturbance::SlowJob, serial);
                }
            }
            Answer::ShortAck => {
                if !matches!(RequestPdu::parse(&data), Ok(RequestPdu::Abort(_))) {
                    let job = Job {
                        serial: cycle.serial,
                        since: now,
                        looked: now,
                        polls: 0,
                        in_row: 0,
                        beside: 0,
                        told: false,
                    };
                    view.services.jobs.insert(sap, job);
                }
            }
            Answer::Data { octets, .. } => {
                let job = view.services.jobs.remove(&sap);
                let refused = match ResponsePdu::parse(octets) {
                    Ok(ResponsePdu::Negative { failure, .. }) => {
                        ![ErrorCode::STATE_CONFLICT, ErrorCode::BUSY].contains(&failure.code)
                    }
                    Ok(_) | Err(_) => false,
                };
                if refused && calm && sap >= ALARM_SAP {
                    view.disturb(Disturbance::RefusedJob, cycle.serial);
                }
                self.connection_answered(cycle, sap, octets);
                if let Ok(ResponsePdu::AlarmAck(head)) = ResponsePdu::parse(octets)
                    && self.view(cycle.to).services.alarms.acknowledged(head)
                {
                    self.held(Row::V12);
                }
                let Some(job) = job else { return };
                self.held(Row::V04);
                if self.view(cycle.to).exchanging && sap >= ALARM_SAP {
                    self.held(Row::V06);
                }
                if job.polls >= WAITED_POLLS && now.saturating_since(job.since) >= WAITED {
                    self.held(Row::V05);
                }
            }
            Answer::Status(ReplyStatus::NotActivated) => {
                view.services.jobs.remove(&sap);
                view.services.connections.end(sap);
            }
            // Not what a slave of DP-V1 says to a poll: what the master makes of it is not known.
            Answer::Status(_) if data.is_empty() => {
                view.services.jobs.remove(&sap);
                view.services.connections.doubt();
            }
            Answer::Status(_) => {}
            // Whether the slave has taken it, or still has it, nobody knows.
            Answer::Silence | Answer::Bad(_) | Answer::Mixed => {
                view.services.connections.doubt();
                view.services.jobs.remove(&sap);
            }
        }
    }

    pub(super) fn verdict_of(&mut self, cycle: &Cycle, row: Row, broken: Option<String>) {
        match broken {
            None => self.held(row),
            Some(reason) => self.broken(row, Weight::Once, cycle.serial, Some(cycle.to), reason),
        }
    }

    /// Whether what was before the recording is not known.
    pub(super) fn is_recorded(&self) -> bool {
        self.sight == Sight::Recorded
    }
}

impl super::view::View {
    /// Whether the last Set_Prm enabled DP-V1.
    pub(super) fn enables_dpv1(&self) -> bool {
        let status = self.prm_data.as_ref().and_then(|prm| prm.get(FIXED_LEN).copied());
        status.is_some_and(|status| Status1::Enable.is_set(status))
    }

    /// Something to which a new start-up would be no right reaction, unless something is there already.
    fn disturb(&mut self, what: Disturbance, serial: u64) {
        self.disturbed.get_or_insert(Disturbed { what, age: 0, serial });
    }
}
