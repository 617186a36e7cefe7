//! Rows that need somebody who operates the master: what it does after it was asked.

use crate::map::Map;
use std::collections::BTreeSet;

use super::Observer;
use super::contents::{FREEZE_REQ, SYNC_REQ};
use super::cycle::Cycle;
use super::view::{Loss, Step, View};
use crate::explain::hex;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::scenario::Check;
use crate::judge::master::setup::Slave;
use crate::profibus::dp;
use crate::profibus::dp::SetPrm;
use crate::profibus::fdl::{Address, FrameCount};

const CLEAR_DATA: u8 = 0x02;
const FREEZE: u8 = 0x08;
const SYNC: u8 = 0x20;
const UNFREEZE: u8 = 0x04;
const UNSYNC: u8 = 0x10;
/// Global_Control kept since the master was asked.
const KEPT: usize = 256;

/// What was seen since the master was asked for something.
#[derive(Debug, Default)]
pub(in crate::judge) struct Asked {
    /// Global_Control: command and groups.
    commands: Vec<(u8, u8)>,
    /// Requests to slaves in all, and since the last look.
    requests: u32,
    /// Stations that were let go.
    released: BTreeSet<u8>,
    /// The last outputs of each station.
    outputs: Map<u8, Vec<u8>>,
    /// The outputs that each station is to get now.
    expected: Map<u8, Vec<u8>>,
    /// Stations that got some octets of the old outputs and some of the new.
    torn: BTreeSet<u8>,
    /// What the user has set, and each station got.
    users: Map<u8, Vec<u8>>,
    /// Stations whose next request must be a first one.
    begins: BTreeSet<u8>,
    /// Stations whose first request since a stop was seen.
    begun: BTreeSet<u8>,
    /// Requests of DP-V1, each once: the station and the octets.
    services: BTreeSet<(u8, Vec<u8>)>,
}

impl Observer {
    /// The master is asked for something: what comes now counts.
    pub(in crate::judge) fn begin_asking(&mut self) {
        let outputs = core::mem::take(&mut self.asked_for.outputs);
        let begins = core::mem::take(&mut self.asked_for.begins);
        let users = core::mem::take(&mut self.asked_for.users);
        self.asked_for = Asked { outputs, users, begins, ..Asked::default() };
    }

    /// The master is asked to send these outputs.
    pub(in crate::judge) fn expect_outputs(&mut self, wanted: &[(Address, Vec<u8>)]) {
        let wanted = wanted.iter().map(|(station, octets)| (station.number(), octets.clone()));
        self.asked_for.expected = wanted.collect();
    }

    /// The master has had time to stop: requests from now on count.
    pub(in crate::judge) const fn count_requests(&mut self) {
        self.asked_for.requests = 0;
    }

    /// The master is to begin anew. It may still go on for a while: the first request with FCV = 0 to a station is of its
    /// new life.
    pub(in crate::judge) fn expect_new_begin(&mut self) {
        let stations = self.setup.present().map(|slave| slave.address.number());
        self.asked_for.begins = stations.collect();
    }

    pub(super) fn note_command(&mut self, command: u8, groups: u8) {
        if self.asked_for.commands.len() < KEPT {
            self.asked_for.commands.push((command, groups));
        }
    }

    /// A request of DP-V1.
    pub(super) fn note_service(&mut self, cycle: &Cycle) {
        if self.asked_for.services.len() < KEPT {
            self.asked_for.services.insert((cycle.to.number(), cycle.data().to_vec()));
        }
    }

    pub(super) fn note_request(&mut self, cycle: &Cycle) {
        let asked = &mut self.asked_for;
        asked.requests = asked.requests.saturating_add(1);
        match cycle.service {
            Some(dp::Service::DataExchange) => {
                let (number, data) = (cycle.to.number(), cycle.data().to_vec());
                let (before, after) = (asked.outputs.get(&number), asked.expected.get(&number));
                if before.zip(after).is_some_and(|(before, after)| is_mixture(&data, before, after)) {
                    asked.torn.insert(number);
                }
                asked.outputs.insert(number, data);
            }
            Some(dp::Service::SetPrm) if SetPrm::parse(cycle.data()).is_ok_and(SetPrm::unlock_req) => {
                asked.released.insert(cycle.to.number());
            }
            Some(
                dp::Service::SetPrm
                | dp::Service::SetSlaveAdd
                | dp::Service::RdInp
                | dp::Service::RdOutp
                | dp::Service::GlobalControl
                | dp::Service::GetCfg
                | dp::Service::SlaveDiag
                | dp::Service::ChkCfg,
            )
            | None => {}
        }
    }

    pub(super) fn judge_new_begin(&mut self, cycle: &Cycle) {
        let number = cycle.to.number();
        let begins = cycle.count == FrameCount::First;
        let parameterises = cycle.service == Some(dp::Service::SetPrm)
            && SetPrm::parse(cycle.data()).is_ok_and(SetPrm::lock_req);
        if !(begins || parameterises) || !self.asked_for.begins.remove(&number) {
            return;
        }
        self.asked_for.begun.insert(number);
        // What was before is of another life.
        let view = self.view(cycle.to);
        view.last = None;
        view.lose(Loss::None);
        view.gave_up = false;
        view.exchanging = false;
        view.cfg = Step::None;
        view.services = Default::default();
        if begins && cycle.service == Some(dp::Service::SlaveDiag) {
            self.held(Row::Z04);
        } else {
            let reason = "the first request after a stop is not Slave_Diag with FCV = 0, FCB = 1";
            self.broken(Row::Z04, Weight::Once, cycle.serial, Some(cycle.to), reason);
        }
    }

    /// The master says it has begun anew. One that exchanges data as before has not.
    fn check_new_begin(&mut self) {
        let silent = self.asked_for.requests == 0;
        let goes_on: Vec<u8> = self
            .asked_for
            .begins
            .iter()
            .copied()
            .filter(|number| self.views.get(number).is_some_and(|view| view.exchanging && view.streak > 0))
            .collect();
        for number in goes_on.into_iter().filter(|_| !silent) {
            let reason = format!(
                "asked for a restart, and Data_Exchange with station {number} goes on without a start-up"
            );
            self.show(Row::Z04, Weight::Once, reason);
        }
        self.asked_for.begins.clear();
    }

    fn expect(&mut self, row: Row, holds: bool, reason: &str) {
        if holds {
            self.held(row);
        } else {
            self.show(row, Weight::Once, String::from(reason));
        }
    }

    /// What the master has done since it was asked.
    pub(in crate::judge) fn check(&mut self, check: &Check) {
        match check {
            Check::Clear => {
                let announced = self.asked_for.commands.iter().any(|(command, _)| command & CLEAR_DATA != 0);
                self.expect(
                    Row::O02,
                    announced,
                    "asked for CLEAR, and no Global_Control with Clear_Data came",
                );
                let zero = self.asked_for.outputs.values().all(|data| data.iter().all(|octet| *octet == 0));
                self.expect(Row::O03, zero, "asked for CLEAR, and outputs are not zero after a second");
            }
            Check::Operate => {
                let last = self.asked_for.commands.last().map(|(command, _)| command & CLEAR_DATA == 0);
                self.expect(
                    Row::O10,
                    last == Some(true),
                    "asked for OPERATE, and no Global_Control without Clear_Data came",
                );
                self.check_users_outputs();
                // Only after a stop is the way to OPERATE that of row O12.
                let cleared =
                    self.asked_for.commands.first().is_some_and(|(command, _)| command & CLEAR_DATA != 0);
                if !self.asked_for.begun.is_empty() && last == Some(true) {
                    self.expect(Row::O12, cleared, "from STOP to OPERATE, and no Clear_Data came first");
                }
            }
            Check::Outputs(wanted) => self.check_outputs(wanted),
            Check::Stop => {
                let requests = self.asked_for.requests;
                let silent = requests == 0;
                let reason = format!("{requests} requests to slaves after the master was asked to stop");
                self.expect(Row::Z02, silent, &reason);
                self.expect(Row::O11, silent, &reason);
                let stations: Vec<u8> = self.setup.present().map(|slave| slave.address.number()).collect();
                let released = stations.iter().all(|station| self.asked_for.released.contains(station));
                self.expect(
                    Row::Z01,
                    released,
                    "asked to stop, and not every slave got a Set_Prm with Unlock_Req",
                );
                let cleared = self.asked_for.commands.iter().any(|(command, _)| command & CLEAR_DATA != 0);
                if silent {
                    self.expect(Row::Z03, cleared, "from OPERATE to STOP, and no Clear_Data came first");
                }
            }
            Check::Begun => self.check_new_begin(),
            Check::Service(station, wanted) => {
                let seen = self.asked_for.services.contains(&(station.number(), wanted.clone()));
                let reason = format!("station {station} did not get the request {}", hex(wanted));
                self.expect(Row::V21, seen, &reason);
            }
            Check::AutoClear => self.note_auto_clear(),
            Check::StaysClear => self.judge_auto_clear(),
            Check::Command { wanted, undo, groups } => self.check_command(*wanted, *undo, *groups),
        }
    }

    fn check_outputs(&mut self, wanted: &[(Address, Vec<u8>)]) {
        for (station, octets) in wanted {
            let got = self.asked_for.outputs.get(&station.number()).cloned().unwrap_or_default();
            let reason = format!("outputs of station {station} are {}, asked for {}", hex(&got), hex(octets));
            self.expect(Row::X04, got == *octets, &reason);
            if self.asked_for.torn.contains(&station.number()) {
                let reason =
                    format!("station {station} got some octets of the old outputs and some of the new");
                self.show(Row::X04, Weight::Once, reason);
            }
            if got == *octets {
                self.asked_for.users.insert(station.number(), got);
            }
        }
    }

    /// Back in OPERATE the stations get what the user has set. A master that began anew need not know it any more.
    fn check_users_outputs(&mut self) {
        if !self.asked_for.begun.is_empty() {
            return;
        }
        for (number, octets) in self.asked_for.users.clone() {
            let got = self.asked_for.outputs.get(&number).cloned().unwrap_or_default();
            let reason = format!(
                "in OPERATE again the outputs of station {number} are {}, set were {}",
                hex(&got),
                hex(&octets)
            );
            self.expect(Row::O10, got == octets, &reason);
        }
    }

    fn check_command(&mut self, wanted: u8, undo: u8, groups: u8) {
        let commands = self.asked_for.commands.clone();
        let came =
            commands.iter().any(|(command, group)| command & (wanted | undo) == wanted && *group == groups);
        let reason =
            format!("no Global_Control with command bit 0x{wanted:02X} to groups 0x{groups:02X} came");
        self.expect(Row::S01, came, &reason);
        if came && wanted & (SYNC | FREEZE) != 0 {
            self.judge_prepared(if wanted & SYNC != 0 { SYNC_REQ } else { FREEZE_REQ }, groups);
        }
        // The cyclic ones that follow.
        if wanted & (UNSYNC | UNFREEZE) == 0 {
            let undone = commands.iter().any(|(command, _)| command & undo != 0);
            let reason = format!("a Global_Control has the bit 0x{undo:02X} that undoes it");
            self.expect(Row::S03, !undone, &reason);
        }
    }

    /// Whether the stations of these groups were told in Set_Prm that Sync or Freeze may come.
    fn judge_prepared(&mut self, bit: u8, groups: u8) {
        let told = |view: &View| {
            view.prm_data.as_ref().and_then(|prm| prm.first()).is_some_and(|status| status & bit != 0)
        };
        let meant = |slave: &&Slave| groups == 0 || slave.groups.unwrap_or(0) & groups != 0;
        let untold = self
            .setup
            .present()
            .filter(meant)
            .map(|slave| slave.address)
            .find(|station| self.views.get(&station.number()).is_some_and(|view| !told(view)));
        match untold {
            None => self.held(Row::S02),
            Some(station) => {
                let reason = format!(
                    "the command went to station {station}, whose Set_Prm does not have the bit for it"
                );
                self.show(Row::S02, Weight::Once, reason);
            }
        }
    }
}

/// Whether outputs have octets of both, and are neither.
fn is_mixture(data: &[u8], before: &[u8], after: &[u8]) -> bool {
    let of_one = |((octet, before), after): ((&u8, &u8), &u8)| octet == before || octet == after;
    data.len() == before.len()
        && data.len() == after.len()
        && data != before
        && data != after
        && data.iter().zip(before).zip(after).all(of_one)
}
