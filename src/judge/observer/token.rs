//! Rows K: the token, and the search for stations in the GAP.

use std::collections::BTreeSet;
use std::format;
use std::vec::Vec;

use super::Observer;
use super::cycle::{Cycle, Item};
use crate::judge::findings::Weight;
use crate::judge::moment::Side;
use crate::judge::rows::Row;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Function, StationType, Telegram};

/// What is known of the ring.
#[derive(Debug, Default)]
pub(super) struct Ring {
    tokens: u32,
    /// Stations that said they are masters that are ready.
    ready: BTreeSet<u8>,
    /// GAP polls since the last token.
    polls: u32,
    /// The last GAP address and whether somebody answered.
    last: Option<(u8, bool)>,
    /// GAP addresses in their order, as far as they differ from the one before.
    order: Vec<u8>,
}

/// GAP polls kept.
const KEPT: usize = 1024;
/// Steps at least before the order of the GAP is judged.
const LEAST_STEPS: usize = 4;

impl Ring {
    pub(super) const fn seen(&self) -> bool {
        self.tokens > 0
    }
}

impl Observer {
    /// The master passes the token.
    pub(super) fn token(&mut self, serial: u64, da: Address, sa: Address) {
        if self.master.is_some_and(|master| master != sa) {
            return;
        }
        self.master.get_or_insert(sa);
        self.ring.tokens = self.ring.tokens.saturating_add(1);
        self.ring.polls = 0;
        if da == sa || self.ring.ready.contains(&da.number()) {
            self.held(Row::K02);
            if self.ring.tokens > 2 {
                self.held(Row::K01);
            }
        } else {
            let reason = format!("the token goes to {da}, which never said that it is a master and ready");
            self.broken(Row::K02, Weight::Once, serial, None, reason);
        }
    }

    /// An FDL status request.
    pub(super) fn polled_status(&mut self, serial: u64, da: Address) {
        if let Some(moment) = self.recent.back()
            && moment.side == Side::Master
            && let Decoded::Telegram { telegram: Telegram::Data(data), .. } = decode(&moment.octets.clone())
        {
            self.judge_uncounted(serial, &data);
        }
        if let Some(view) = self.views.get_mut(&da.number()) {
            view.asked_since = view.asked_since.saturating_add(1);
        }
        // To a configured station it may have other reasons than the GAP.
        if self.setup.slave(da).is_some() || !self.ring.seen() || self.master == Some(da) {
            return;
        }
        self.ring.polls += 1;
        if self.ring.polls > 1 {
            let reason = "two FDL status requests between two tokens";
            self.broken(Row::K03, Weight::Times(3), serial.saturating_sub(4), None, reason);
        } else {
            self.held(Row::K03);
        }
        match self.ring.last {
            Some((last, false)) if last == da.number() => {
                let reason = format!("address {da} is asked again after it did not answer");
                self.broken(Row::K06, Weight::Times(2), serial.saturating_sub(4), None, reason);
            }
            Some((last, _)) if last != da.number() => {
                self.held(Row::K06);
                if self.ring.order.len() < KEPT {
                    self.ring.order.push(da.number());
                }
            }
            Some(_) => {}
            None => self.ring.order.push(da.number()),
        }
        if let Some(hsa) = self.setup.hsa.filter(|hsa| da > *hsa) {
            let reason = format!("address {da} is asked, which is above the highest station address {hsa}");
            self.broken(Row::K04, Weight::Once, serial, None, reason);
        }
        self.ring.last = Some((da.number(), false));
    }

    /// What an FDL status request led to.
    pub(super) fn status_answered(&mut self, cycle: &Cycle, answered: bool) {
        if let Some((last, was)) = &mut self.ring.last
            && *last == cycle.to.number()
        {
            *was = answered;
        }
        if !cycle.items.iter().any(|item| matches!(item, Item::Status(_))) {
            return;
        }
        let reply = self.recent.iter().rev().find_map(|moment| match decode(&moment.octets) {
            Decoded::Telegram { telegram: Telegram::Data(data), .. } if data.sa == cycle.to => Some(data.fc),
            Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => None,
        });
        match reply.map(|fc| fc.function()) {
            Some(Function::Response(StationType::MasterReady | StationType::MasterInRing, _)) => {
                self.ring.ready.insert(cycle.to.number());
            }
            Some(
                Function::Response(StationType::Slave | StationType::MasterNotReady, _)
                | Function::Request(..)
                | Function::Reserved,
            )
            | None => {}
        }
    }

    pub(super) fn finish_token(&mut self) {
        if !self.ring.seen() {
            let reason = "not applicable: the master never passes a token, so it works alone";
            for row in [Row::K01, Row::K02, Row::K03, Row::K04, Row::K05, Row::K06, Row::K07, Row::K08] {
                self.findings.inapplicable(row, reason);
            }
            for row in Row::ALL.iter().filter(|row| row.id().starts_with("M-R") && **row != Row::R09) {
                self.findings.obstacle(*row, reason);
            }
            return;
        }
        self.findings.obstacle(Row::K05, "the GAP factor of the master is not known");
        let steps: Vec<(u8, u8)> =
            self.ring.order.windows(2).filter_map(|pair| Some((*pair.first()?, *pair.get(1)?))).collect();
        if steps.len() < LEAST_STEPS {
            self.findings.obstacle(Row::K04, "too few addresses of the GAP were asked");
            return;
        }
        let falls = steps.iter().filter(|(one, next)| next < one).count();
        let distinct = self.ring.order.iter().collect::<BTreeSet<_>>().len();
        // Once around the GAP the addresses fall once.
        if distinct > 2 && falls * 2 > steps.len() {
            let reason = format!(
                "the addresses of the GAP fall at {falls} of {} steps; expected ascending",
                steps.len()
            );
            self.broken(Row::K04, Weight::Once, self.serial.saturating_sub(16), None, reason);
        } else if self.setup.hsa.is_some() || distinct > 2 {
            self.held(Row::K04);
        }
    }
}
