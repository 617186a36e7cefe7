//! The test master in a ring: the token, the list of active stations, the GAP.

use core::time::Duration;
use std::collections::BTreeSet;

use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Function, Service, StationType, Telegram};
use profidrive::time::Instant;

use super::mistakes::Mistake;
use super::requests::short;
use super::{Beside, TestMaster};

/// A token is passed so often.
const ATTEMPTS: u32 = 3;

/// What it knows of the ring.
#[derive(Debug)]
pub(super) struct Ring {
    state: State,
    /// The list of active stations, its own address included.
    active: BTreeSet<u8>,
    /// The GAP address that was asked last.
    pub(super) gap: u8,
    /// It waits for the reply to a GAP poll.
    pub(super) polling: bool,
    heard: Vec<u8>,
    /// The last octet of anybody.
    activity: Instant,
    /// Who passed a token though it is not the one before in the ring.
    stranger: Option<u8>,
    /// Telegrams of others with its own address.
    doubles: u32,
    answer: Option<(Instant, Vec<u8>)>,
    /// A telegram that it has no right to send.
    intrusion: bool,
    intruded: bool,
    /// The last token was for itself.
    pub(super) own_token: bool,
    /// When the token came, and whether that was too late; cycles since.
    received: Instant,
    late: bool,
    pub(super) used: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Holds,
    /// The token was passed so often.
    Passed {
        attempt: u32,
        until: Option<Instant>,
    },
    /// In the ring, without the token.
    Idle,
    /// Not in the ring: so often it has seen the token go round.
    Listens {
        rounds: u32,
    },
}

impl Ring {
    pub(super) fn new(own: u8) -> Self {
        Self {
            state: State::Holds,
            active: BTreeSet::from([own]),
            gap: own,
            polling: false,
            heard: Vec::new(),
            activity: Instant::ZERO,
            stranger: None,
            doubles: 0,
            answer: None,
            intrusion: false,
            intruded: false,
            own_token: false,
            received: Instant::ZERO,
            late: false,
            used: 0,
        }
    }
}

impl TestMaster {
    pub(super) fn has_token(&self) -> bool {
        !self.settings.token || self.ring.state == State::Holds
    }

    /// It begins: it listens before it claims the token.
    pub(super) fn listen(&mut self, now: Instant) {
        if self.settings.token {
            let rounds = if self.does(Mistake::ReadyAtOnce) { 2 } else { 0 };
            (self.ring.state, self.ring.activity) = (State::Listens { rounds }, now);
            self.beside.clear();
        }
    }

    /// The station behind it in the ring.
    fn successor(&self) -> u8 {
        let own = self.settings.address;
        let behind = self.ring.active.range(own + 1..).next().or(self.ring.active.iter().next());
        behind.copied().unwrap_or(own)
    }

    fn predecessor(&self) -> u8 {
        let own = self.settings.address;
        let before = self.ring.active.range(..own).next_back().or(self.ring.active.iter().next_back());
        before.copied().unwrap_or(own)
    }

    /// Goes to the next address of the GAP; `false`: it is empty.
    pub(super) fn next_gap(&mut self) -> bool {
        let (own, next, hsa) = (self.settings.address, self.successor(), self.settings.hsa);
        let in_gap = |number: u8| match next {
            _ if self.does(Mistake::GapBeyondNext) => number != own,
            _ if self.does(Mistake::GapSkips) && number.is_multiple_of(2) => false,
            next if next > own => number > own && number < next,
            next if next < own => number > own || number < next,
            _ => number != own,
        };
        let around =
            (1..=hsa + 1).map(|step| (u16::from(self.ring.gap) + u16::from(step)) % (u16::from(hsa) + 1));
        let found = around.map(|number| number as u8).find(|number| in_gap(*number));
        self.ring.gap = found.unwrap_or(self.ring.gap);
        found.is_some() && !self.does(Mistake::NeverAsksGap)
    }

    /// Whether the token came too late for more than one cycle, and that was done.
    pub(super) fn is_too_late(&self) -> bool {
        let open = self.slaves.get(self.turn).is_some_and(|slave| slave.open.is_some());
        self.settings.token && self.ring.late && self.ring.used > 0 && !open && !self.does(Mistake::HoldsLong)
    }

    pub(super) fn pass_token(&mut self) -> Vec<u8> {
        let (own, next) = (self.settings.address, self.successor());
        self.ring.own_token = next == own;
        if next != own {
            self.ring.state = State::Passed { attempt: 1, until: None };
        }
        vec![0xDC, next, own]
    }

    /// Its last telegram has ended.
    pub(super) fn ring_sent(&mut self, now: Instant) {
        self.ring.heard.clear();
        self.ring.activity = now;
        match self.ring.state {
            State::Passed { attempt, .. } => {
                self.ring.state = State::Passed { attempt, until: Some(now + self.settings.slot) };
            }
            // The token to itself: nothing else ends a rotation.
            State::Holds if core::mem::take(&mut self.ring.own_token) => self.received(now),
            State::Holds | State::Idle | State::Listens { .. } => {}
        }
    }

    fn received(&mut self, now: Instant) {
        let rotation = now.saturating_since(self.ring.received);
        self.ring.late = self.settings.ttr.is_some_and(|ttr| rotation > ttr);
        (self.ring.received, self.ring.used) = (now, 0);
    }

    fn time_out(&self) -> Duration {
        self.settings.slot * (6 + 2 * u32::from(self.settings.address))
    }

    /// When something is to be done without the token.
    pub(super) fn ring_due(&self) -> Option<Instant> {
        if let Some((due, _)) = &self.ring.answer {
            return Some(*due);
        }
        match self.ring.state {
            State::Passed { until, .. } => until,
            State::Idle | State::Listens { .. } if self.does(Mistake::NeverClaims) => None,
            State::Idle | State::Listens { .. } => Some(self.ring.activity + self.time_out()),
            State::Holds => None,
        }
    }

    /// What it sends without the token.
    pub(super) fn without_token(&mut self, now: Instant) -> Option<Vec<u8>> {
        if self.ring_due().is_none_or(|due| due > now) {
            return None;
        }
        if let Some((_, octets)) = self.ring.answer.take() {
            if core::mem::take(&mut self.ring.intrusion) {
                let (slave, own) = (self.slaves[0].configured.address, self.settings.address);
                let due = now + self.settings.baud.octet_times(6) + self.syn();
                self.ring.answer = Some((due, short(slave, own, 0x49)));
            }
            return Some(octets);
        }
        let own = self.settings.address;
        match self.ring.state {
            State::Passed { attempt, .. } => {
                let limit = match self.mistake {
                    Some(Mistake::PassesOnce) => 1,
                    Some(Mistake::PassesForEver) => u32::MAX,
                    _ => ATTEMPTS,
                };
                let next = self.successor();
                if attempt < limit {
                    self.ring.state = State::Passed { attempt: attempt + 1, until: None };
                    return Some(vec![0xDC, next, own]);
                }
                self.ring.active.remove(&next);
                let octets = self.pass_token();
                if self.successor() == own {
                    self.ring.state = State::Holds;
                }
                Some(octets)
            }
            State::Idle | State::Listens { .. } => {
                self.ring.state = State::Holds;
                self.ring.doubles = 0;
                self.beside.clear();
                self.beside.push_back(Beside::Claim);
                Some(vec![0xDC, own, own])
            }
            State::Holds => None,
        }
    }

    /// Octets of anybody else.
    pub(super) fn hear_ring(&mut self, now: Instant, octets: &[u8]) {
        if !self.settings.token {
            return;
        }
        self.ring.activity = now;
        if let State::Passed { .. } = self.ring.state {
            self.ring.state = State::Idle;
        }
        self.ring.heard.extend_from_slice(octets);
        let heard = core::mem::take(&mut self.ring.heard);
        let mut rest = &heard[..];
        loop {
            match decode(rest) {
                Decoded::Telegram { telegram, len } => {
                    self.ring_hears(now, &telegram);
                    rest = &rest[len..];
                }
                Decoded::Invalid { skip, .. } => rest = &rest[skip..],
                Decoded::Incomplete => break,
            }
        }
        self.ring.heard = rest.to_vec();
    }

    fn ring_hears(&mut self, now: Instant, telegram: &Telegram<'_>) {
        let own = self.settings.address;
        match telegram {
            Telegram::Token { da, sa } => self.token_heard(now, da.number(), sa.number()),
            Telegram::ShortAcknowledge => {}
            Telegram::Data(data) => match data.fc.function() {
                Function::Response(kind, _) if data.da.number() == own => {
                    let ready = match kind {
                        StationType::MasterReady | StationType::MasterInRing => {
                            !self.does(Mistake::IgnoresReady)
                        }
                        StationType::MasterNotReady => self.does(Mistake::TokenToNotReady),
                        StationType::Slave => false,
                    };
                    if core::mem::take(&mut self.ring.polling) && ready && data.sa.number() == self.ring.gap {
                        self.ring.active.insert(self.ring.gap);
                    }
                }
                Function::Request(Service::FdlStatus, _) if data.da.number() == own => {
                    let kind = match self.ring.state {
                        State::Listens { rounds } if rounds < 2 => 0x10,
                        State::Listens { .. } => 0x20,
                        State::Holds | State::Passed { .. } | State::Idle => 0x30,
                    };
                    let kind = if self.does(Mistake::StatusAsSlave) { 0x00 } else { kind };
                    if !self.does(Mistake::NoStatusReply) {
                        let due = now + self.settings.baud.bit_times(20);
                        self.ring.answer = Some((due, short(data.sa.number(), own, kind)));
                        self.ring.intrusion = self.does(Mistake::TalksWithoutToken) && !self.ring.intruded;
                        self.ring.intruded |= self.ring.intrusion;
                    }
                    if matches!(self.ring.state, State::Listens { rounds: 2.. }) {
                        self.ring.state = State::Idle;
                    }
                }
                Function::Request(Service::SrdHigh | Service::SrdLow, _)
                    if self.does(Mistake::RestartsOnForeign) =>
                {
                    let mistake = self.mistake;
                    let asked = |slave: &&mut super::Slave| slave.configured.address == data.da.number();
                    if let Some(slave) = self.slaves.iter_mut().find(asked) {
                        slave.restart(mistake);
                    }
                }
                Function::Response(..) | Function::Request(..) | Function::Reserved => {}
            },
        }
    }

    fn token_heard(&mut self, now: Instant, da: u8, sa: u8) {
        let own = self.settings.address;
        if sa == own {
            self.ring.doubles += 1;
            if self.ring.doubles >= 2 && !self.does(Mistake::StaysDespiteDouble) {
                self.ring.state = State::Listens { rounds: 0 };
                self.ring.active = BTreeSet::from([own]);
            }
            return;
        }
        if self.ring.state == State::Holds {
            return;
        }
        self.ring.doubles = 0;
        if let State::Listens { rounds } = &mut self.ring.state {
            *rounds += u32::from(da <= sa);
            self.ring.active.insert(sa);
            return;
        }
        if da != own && !self.does(Mistake::TakesForeignToken) {
            self.ring.active.insert(sa);
            return;
        }
        let known = sa == self.predecessor() || self.does(Mistake::TakesFromStranger);
        if known || self.ring.stranger == Some(sa) {
            // Between it and this master is nobody.
            let between = |other: &u8| match sa < own {
                true => *other > sa && *other < own,
                false => *other > sa || *other < own,
            };
            let gone: Vec<u8> = self.ring.active.iter().copied().filter(between).collect();
            self.ring.active.retain(|other| !gone.contains(other));
            self.ring.active.insert(sa);
            self.ring.stranger = None;
            self.ring.state = State::Holds;
            self.received(now);
            self.next = self.next.max(now + self.syn());
        } else {
            self.ring.stranger = Some(sa);
        }
    }
}
