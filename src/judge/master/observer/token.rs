//! Rows K: the token, and the search for stations in the GAP.

use core::time::Duration;
use std::collections::BTreeSet;

use super::cycle::{Cycle, Item};
use super::{Observer, Sight};
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::moment::Side;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Function, StationType, Telegram};
use crate::time::Instant;

/// What is known of the ring.
#[derive(Debug, Default)]
pub(super) struct Ring {
    tokens: u32,
    /// Requests to slaves since the last token.
    requests: u32,
    passed: Option<Instant>,
    /// The first token.
    first: Option<Instant>,
    /// Stations that said they are masters that are ready.
    ready: BTreeSet<u8>,
    /// GAP polls since the last token.
    polls: u32,
    /// The address that was asked last, and all of them, and how often they began anew.
    polled: Option<u8>,
    asked: BTreeSet<u8>,
    turns: u32,
    /// Who got the last token.
    next: Option<u8>,
    /// The last GAP address and whether somebody answered.
    last: Option<(u8, bool)>,
    /// GAP addresses in their order, as far as they differ from the one before.
    order: Vec<u8>,
    /// Another master is played, or about to be: the GAP is another one.
    is_shared: bool,
    /// What the search in the GAP left out before that.
    left_out: Search,
    /// An FDL status of the GAP was asked for since the last token.
    has_asked: bool,
    /// Rotations without one since the first, while the master was alone.
    quiet: u32,
}

/// GAP polls kept.
const KEPT: usize = 1024;
/// Requests to each station in a rotation at most: a start-up with retries has fewer. And for so long.
const LONGEST_ROTATION: u32 = 100;
const ROTATION_TIME: Duration = Duration::from_secs(3);
/// So many tokens must bring a GAP poll: the GAP factor is at most 100.
const MANY_TOKENS: u32 = 500;
/// Why a row about what is left out has no verdict.
const NOT_ROUND: &str = "the master was not round its GAP twice";
/// The highest address of a master.
const HIGHEST: u8 = 125;
/// Steps at least before the order of the GAP is judged.
const LEAST_STEPS: usize = 4;

/// What is known of the search in the whole GAP, with the master alone in its ring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Search {
    /// It was not round twice.
    #[default]
    Unknown,
    /// Every address was asked.
    Complete,
    /// This one is never asked.
    LeavesOut(u8),
}

impl Ring {
    /// Whether the search in the GAP was round twice, so that what it left out it leaves out.
    const fn is_round(&self) -> bool {
        self.turns >= 2
    }

    pub(super) const fn seen(&self) -> bool {
        self.tokens > 0
    }
}

impl Observer {
    /// The master passes the token.
    pub(super) fn token(&mut self, serial: u64, da: Address, sa: Address) {
        if self.master.is_some_and(|master| master != sa) {
            self.note_other_master(sa);
            return;
        }
        let alone = da == sa && !self.ring.is_shared && !self.ring.asked.is_empty();
        self.ring.quiet += u32::from(!core::mem::take(&mut self.ring.has_asked) && alone);
        self.ring.next = Some(da.number());
        self.master.get_or_insert(sa);
        self.ring.tokens = self.ring.tokens.saturating_add(1);
        self.ring.polls = 0;
        self.ring.requests = 0;
        self.ring.passed = self.last_heard;
        self.ring.first = self.ring.first.or(self.last_heard);
        // A recording may begin when the ring runs already: only a slave is none of it.
        let runs = self.sight == Sight::Recorded && !self.is_slave(da);
        if da == sa || runs || self.ring.ready.contains(&da.number()) {
            self.held(Row::K02);
            if self.ring.tokens > 2 {
                self.held(Row::K01);
            }
        } else {
            let reason = format!("the token goes to {da}, which never said that it is a master and ready");
            self.broken(Row::K02, Weight::Once, serial, None, reason);
        }
    }

    /// A request to a slave: each rotation ends with a token.
    pub(super) fn judge_rotation(&mut self, serial: u64) {
        if !self.ring.seen() {
            return;
        }
        self.ring.requests += 1;
        let stations = u32::try_from(self.setup.stations.len()).unwrap_or(u32::MAX).saturating_add(1);
        let long = self.ring.passed.is_some_and(|passed| self.is_long_ago(passed, ROTATION_TIME));
        if self.ring.requests > LONGEST_ROTATION.saturating_mul(stations) && long {
            let reason = format!("{} requests to slaves since the last token", self.ring.requests);
            self.ring.requests = 0;
            self.broken(Row::K01, Weight::Once, serial.saturating_sub(4), None, reason);
        }
    }

    /// Whether an FDL status request follows on the one before as the search in the GAP does.
    pub(super) fn is_of_gap(&mut self, da: Address) -> bool {
        self.ring.asked.insert(da.number());
        let own = self.master.map(Address::number);
        let skipped = |number: u8| if Some(number) == own { number + 1 } else { number };
        let next = self.ring.polled.is_some_and(|before| skipped(before + 1) == da.number());
        // Some masters look in this way for a station that they have lost.
        if !next && self.setup.slave(da).is_some() {
            return false;
        }
        self.ring.has_asked = true;
        let before = self.ring.polled.replace(da.number());
        let follows = next || before.is_some_and(|before| da.number() < before);
        let falls = before.is_some_and(|before| da.number() < before);
        // With another master in the ring the GAP is shorter.
        self.ring.turns += u32::from(falls && !self.ring.is_shared);
        self.ring.seen() && follows
    }

    /// What the search in the GAP leaves out, once it was round twice.
    fn left_out(&self) -> Search {
        let top = self.setup.hsa.map(Address::number).or(self.ring.asked.last().copied());
        let (Some(top), Some(own)) = (top, self.master.map(Address::number)) else {
            return Search::Unknown;
        };
        let alone = self.ring.next == Some(own) && self.ring.ready.is_empty();
        if !alone || !self.ring.is_round() {
            return Search::Unknown;
        }
        let configured =
            |number: u8| self.setup.stations.iter().any(|slave| slave.address.number() == number);
        let expected =
            |number: &u8| *number != own && !self.ring.asked.contains(number) && !configured(*number);
        (0..top).find(expected).map_or(Search::Complete, Search::LeavesOut)
    }

    /// An FDL status request.
    pub(super) fn polled_status(&mut self, serial: u64, da: Address) {
        if let Some(moment) = self.recent.last()
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
        match self.ring.last.filter(|_| !self.ring.is_shared) {
            Some((last, false)) if last == da.number() && self.ring.polls == 1 && self.may_be_alone(da) => {}
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
            None if self.ring.is_shared => {}
            None => self.ring.order.push(da.number()),
        }
        if self.ring.is_shared && !self.is_in_gap(da.number()) {
            let reason = format!(
                "address {da} is asked, which is not between the master and the next one in the ring"
            );
            self.broken(Row::K04, Weight::Times(2), serial, None, reason);
        }
        if let Some(hsa) = self.setup.hsa.filter(|hsa| da > *hsa) {
            let reason = format!("address {da} is asked, which is above the highest station address {hsa}");
            self.broken(Row::K04, Weight::Once, serial, None, reason);
        }
        self.ring.last = Some((da.number(), false));
    }

    /// Somebody else speaks as a master does.
    pub(super) fn note_other_master(&mut self, sa: Address) {
        self.ring.ready.insert(sa.number());
    }

    /// A second master is about to come.
    pub(in crate::judge) fn begin_ring(&mut self) {
        if self.ring.ready.is_empty() {
            self.ring.left_out = self.left_out();
        }
        self.ring.is_shared = true;
    }

    /// It has left.
    pub(in crate::judge) const fn end_ring(&mut self) {
        self.ring.is_shared = false;
        self.ring.last = None;
    }

    /// The master, if it takes part in a ring.
    pub(in crate::judge) fn ring_master(&self) -> Option<Address> {
        self.master.filter(|_| self.ring.seen())
    }

    /// An address that the master is to ask soon in its GAP, and one behind it that is in nobody's ring.
    pub(in crate::judge) fn free_addresses(&self) -> Option<(Address, Address)> {
        let own = self.ring_master()?.number();
        // Up to which address it asks its last round has shown.
        let asked = self.ring.asked.last().copied().filter(|_| self.ring.turns > 0);
        // Some masters ask up to the address before HSA.
        let configured = self.setup.hsa.map(|hsa| hsa.number().saturating_sub(1));
        let top = asked.max(configured).unwrap_or(HIGHEST).min(HIGHEST);
        let from = self.ring.polled.unwrap_or(own);
        let is_free = |number: &u8| {
            *number != own
                && self.setup.stations.iter().all(|slave| slave.address.number() != *number)
                && !self.is_slave(Address::from_octet(*number))
        };
        let around = |from: u8| (1..=top).map(move |step| (from.min(top) + step) % (top + 1));
        // The next one may be asked at this moment.
        let second = around(from).skip(1).chain(around(from).take(1)).find(is_free)?;
        let behind = around(second).take_while(|number| *number != own).find(is_free);
        let stranger = behind.unwrap_or(if top < HIGHEST { top + 1 } else { second });
        Some((Address::from_octet(second), Address::from_octet(stranger)))
    }

    /// Whether an address is one of a slave: it is configured, or answered as one.
    fn is_slave(&self, address: Address) -> bool {
        self.setup.slave(address).is_some()
            || self.views.get(&address.number()).is_some_and(|view| view.answered)
    }

    /// Whether an address is between the master and the one that got the last token.
    fn is_in_gap(&self, number: u8) -> bool {
        let (Some(master), Some(next)) = (self.master.map(Address::number), self.ring.next) else {
            return true;
        };
        if next > master { number > master && number < next } else { number > master || number < next }
    }

    /// Whether each address up to the highest one is that of the master or of a configured station.
    fn is_gap_configured(&self, hsa: Address) -> bool {
        let stations = self.setup.stations.iter().map(|slave| slave.address).chain(self.master);
        let configured: BTreeSet<u8> = stations.map(Address::number).collect();
        (0..=hsa.number()).all(|number| configured.contains(&number))
    }

    /// Whether the GAP may be this address alone: then it is asked once in each GAP cycle.
    fn may_be_alone(&self, address: Address) -> bool {
        let (Some(master), Some(next)) = (self.master, self.ring.next) else { return true };
        let top = match self.setup.hsa {
            Some(hsa) => hsa.number(),
            None if next > master.number() => next,
            // Up to where it asks is not known: one that asked others asks those.
            None => return self.ring.order.iter().all(|other| *other == address.number()),
        };
        let is_configured =
            |number: u8| self.setup.stations.iter().any(|slave| slave.address.number() == number);
        (0..=top).filter(|number| self.is_in_gap(*number) && !is_configured(*number)).count() <= 1
    }

    /// What an FDL status request led to.
    pub(super) fn status_answered(&mut self, cycle: &Cycle, answered: bool) {
        if let Some((last, was)) = &mut self.ring.last
            && *last == cycle.to.number()
        {
            *was = answered;
        }
        if !cycle.items.iter().any(|item| matches!(item, Item::Status(_) | Item::Data { .. })) {
            return;
        }
        let reply = self.recent.backwards().find_map(|moment| match decode(&moment.octets) {
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

    /// Whether so much time has gone that an address of the GAP must have been asked: tokens alone tell it in virtual time.
    fn has_gap_come(&mut self) -> bool {
        let known = self.setup.gap_factor.zip(self.setup.ttr);
        let Some((factor, ttr)) = known else {
            let reason = "needs --gap-factor and --ttr: how seldom the master asks an address of its GAP";
            self.findings.default_obstacle(Row::K08, reason);
            return matches!(self.sight, Sight::Exact(_));
        };
        let (first, last) = (self.ring.first, self.ring.passed);
        let seen = first.zip(last).map(|(first, last)| last.saturating_since(first));
        self.sight != Sight::Recorded && seen.is_some_and(|seen| seen >= ttr * factor * 2)
    }

    /// Behind the last address of the GAP the master waits until it begins anew.
    fn judge_gap_factor(&mut self) {
        match self.setup.gap_factor {
            None => self.findings.obstacle(Row::K05, "needs --gap-factor: the GAP factor of the master"),
            Some(0 | 1) => {
                let reason =
                    "does not apply: with a GAP factor of 1 an address may be asked in every rotation";
                self.findings.obstacle(Row::K05, reason);
            }
            Some(_) if self.setup.hsa.is_some_and(|hsa| self.is_gap_configured(hsa)) => {
                let reason = "does not apply: every address of the GAP is one of a configured station, and when one of \
                              these is asked tells nothing of the GAP factor";
                self.findings.obstacle(Row::K05, reason);
            }
            Some(_) if !self.ring.is_round() => self.findings.default_missed(Row::K05, NOT_ROUND),
            Some(factor) if self.ring.quiet < self.ring.turns => {
                let reason = format!(
                    "an address of the GAP is asked in every rotation, and the GAP factor is {factor}"
                );
                self.show(Row::K05, Weight::Once, reason);
            }
            Some(_) => self.held(Row::K05),
        }
    }

    pub(super) fn finish_token(&mut self) {
        if !self.ring.seen() {
            let reason = "not applicable: the master never passes a token, so it works alone";
            for row in [Row::K01, Row::K02, Row::K03, Row::K04, Row::K05, Row::K06, Row::K07, Row::K08] {
                self.findings.inapplicable(row, reason);
            }
            for row in Row::ALL.iter().filter(|row| row.id().starts_with("M-R")) {
                self.findings.obstacle(*row, reason);
            }
            return;
        }
        let has_gap = self.master.is_none_or(|master| self.setup.hsa != Some(master) || master.number() > 0);
        if self.ring.tokens >= MANY_TOKENS && has_gap && self.has_gap_come() {
            if self.ring.asked.is_empty() {
                let reason =
                    format!("{} tokens were passed, and no address of the GAP was asked", self.ring.tokens);
                self.show(Row::K08, Weight::Once, reason);
            } else {
                self.held(Row::K08);
            }
        }
        self.judge_gap_factor();
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
            self.broken(Row::K04, Weight::Once, self.recent.newest().saturating_sub(16), None, reason);
            return;
        }
        let search = match self.ring.left_out {
            Search::Unknown => self.left_out(),
            Search::Complete | Search::LeavesOut(_) => self.ring.left_out,
        };
        match search {
            Search::Unknown => self.findings.default_missed(Row::K04, NOT_ROUND),
            Search::LeavesOut(number) => {
                let reason = format!("address {number} of the GAP is never asked");
                self.broken(Row::K04, Weight::Once, self.recent.newest().saturating_sub(16), None, reason);
            }
            Search::Complete if self.setup.hsa.is_some() || distinct > 2 => self.held(Row::K04),
            Search::Complete => {}
        }
    }
}
