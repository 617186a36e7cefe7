//! The simulated line: its clock, its stations, and the master under test; who sends, and who hears it.

use core::fmt;
use core::ops::Range;
use core::time::Duration;
use std::collections::VecDeque;

use super::history::History;
use super::{Breach, Damage, Master, NoMaster, Passed, Sender};
use crate::host::link::fault::Faults;
use crate::host::{Bus, Clock};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Function, MAX_TELEGRAM_LEN, Telegram};
use crate::time::{BaudRate, Instant};

/// How the line treats octets on their way. Called once for each sending, with the time of its end and its octets,
/// which it may change; says which octet, if any, the receivers get with wrong parity.
pub type Disturbance = Box<dyn FnMut(Instant, &mut Vec<u8>) -> Option<usize> + Send>;

/// Octets that reach the master under test at once, after the first.
const OCTETS_AT_ONCE: usize = 8;

/// So many breaches are kept.
const BREACHES: usize = 256;

/// A line with its clock, the stations on it, and the master under test, if there is one.
pub struct Line<M = NoMaster> {
    /// The master under test, to look at and to command while time stands.
    pub master: M,
    pub(super) baud: BaudRate,
    pub(super) slot_time: Duration,
    pub(super) now: Instant,
    pub(super) buses: Vec<Bus>,
    pub(super) faults: Faults,
    /// Replies that a fault holds back.
    late: Vec<Late>,
    /// When the last octet on the line ended.
    pub(super) idle_since: Instant,
    pub(super) speaking: Option<Speaking>,
    pub(super) asked: Option<Asked>,
    pub(super) disturbance: Option<Disturbance>,
    /// What is being said, or was said last.
    pub(super) octets: Vec<u8>,
    pub(super) history: History,
    breaches: VecDeque<Breach>,
    /// How many breaches there were, those no longer kept included.
    pub(super) breach_count: usize,
    /// When the master was called last.
    called: Instant,
    /// When what the master sends ends.
    sends_until: Option<Instant>,
}

/// Somebody sends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Speaking {
    pub(super) sender: Sender,
    /// Which bus, of a station.
    pub(super) bus: Option<usize>,
    pub(super) begin: Instant,
    pub(super) end: Instant,
    pub(super) damage: Damage,
    /// A fault on purpose changed what is sent, or when.
    pub(super) injected: bool,
    breach: Option<Breach>,
    asks: Asks,
    /// How many octets have reached the master.
    arrived: usize,
}

/// What somebody is about to send.
#[derive(Clone, Copy)]
pub(super) struct Said<'a> {
    octets: &'a [u8],
    /// The telegram at its beginning, if there is one.
    pub(super) first: Decoded<'a>,
}

impl<'a> Said<'a> {
    fn of(octets: &'a [u8]) -> Self {
        Self { octets, first: decode(octets) }
    }

    /// Whether it is one telegram and nothing else.
    pub(super) const fn is_one_telegram(&self) -> bool {
        matches!(self.first, Decoded::Telegram { len, .. } if len == self.octets.len())
    }
}

/// Who must reply to a sending.
#[derive(Clone, Copy, Debug)]
enum Asks {
    /// This station, or nobody.
    Known(Option<Asked>),
    /// What is heard of it will say.
    AsHeard,
}

/// A request that wants a reply.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub(super) station: Address,
    pub(super) master: Address,
    pub(super) end: Instant,
}

/// A reply to be sent later.
#[derive(Debug)]
struct Late {
    due: Instant,
    bus: usize,
    octets: Vec<u8>,
}

/// What a step brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Nothing happens until the time given: it is that time now.
    Nothing,
    /// Somebody was called.
    Something,
    /// Somebody has come to the end of what he sent.
    Ended,
}

impl Line {
    /// A silent line at `baud`, nobody on it, at [`Instant::ZERO`].
    pub fn new(baud: BaudRate) -> Self {
        Self::with(baud, NoMaster)
    }
}

impl<M: Master> Line<M> {
    /// A line at `baud` with this master, without stations, at [`Instant::ZERO`]. The slot time is [the customary
    /// one](Self::slot_time).
    pub fn with(baud: BaudRate, master: M) -> Self {
        Self {
            master,
            baud,
            slot_time: customary_slot_time(baud),
            now: Instant::ZERO,
            buses: Vec::new(),
            faults: Faults::default(),
            late: Vec::new(),
            idle_since: Instant::ZERO,
            speaking: None,
            asked: None,
            disturbance: None,
            octets: Vec::with_capacity(MAX_TELEGRAM_LEN),
            history: History::new(),
            breaches: VecDeque::new(),
            breach_count: 0,
            called: Instant::ZERO,
            sends_until: None,
        }
    }

    /// The time now.
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// The rate of the masters.
    pub const fn baud(&self) -> BaudRate {
        self.baud
    }

    /// The masters have another rate from now on, and its customary slot time. A bus keeps its own rate, and at another
    /// one hears damaged octets.
    pub const fn set_baud(&mut self, baud: BaudRate) {
        self.baud = baud;
        self.slot_time = customary_slot_time(baud);
    }

    /// How long a master waits for the first octet of a reply, T_SL; by the customary table (`dp-v0.md` 1.1) unless
    /// [`Line::set_slot_time`] has set it.
    pub const fn slot_time(&self) -> Duration {
        self.slot_time
    }

    /// The masters wait so long for a reply.
    pub const fn set_slot_time(&mut self, slot_time: Duration) {
        self.slot_time = slot_time;
    }

    /// What has passed, oldest first: the last 256 sendings, or as many as [`Line::keep`] says.
    pub fn history(&self) -> impl DoubleEndedIterator<Item = &Passed> + ExactSizeIterator {
        self.history.iter()
    }

    /// Keeps so many sendings, at least one.
    pub fn keep(&mut self, sendings: usize) {
        self.history.keep(sendings);
    }

    /// The oldest sending that was not polled yet, of those kept. It is there once it has ended.
    #[must_use]
    pub fn poll_telegram(&mut self) -> Option<Passed> {
        self.history.poll()
    }

    /// The rules that were broken, oldest first; the last 256 are kept.
    pub fn breaches(&self) -> impl ExactSizeIterator<Item = &Breach> {
        self.breaches.iter()
    }

    /// The first breach after the first `count` there ever were.
    pub(super) fn breach_after(&self, count: usize) -> Option<Breach> {
        let new = self.breach_count.checked_sub(count).filter(|new| *new > 0)?;
        self.breaches.get(self.breaches.len().saturating_sub(new)).copied()
    }

    /// When something happens next.
    pub(super) fn next(&self) -> Option<Instant> {
        let speaking = Instant::first_of(self.speaking.map(|speaking| speaking.end), self.next_arrival());
        let stations =
            Instant::first_of(self.next_late(), self.buses.iter().filter_map(Bus::poll_timeout).min());
        let master = Instant::first_of(self.sends_until, self.master_due());
        let next = Instant::first_of(speaking, Instant::first_of(stations, master));
        next.map(|next| next.max(self.now))
    }

    /// Goes to the next thing that happens, at most to `until`, and lets it happen.
    pub(super) fn step_until(&mut self, until: Instant) -> Step {
        let Some(next) = self.next().filter(|next| *next <= until) else {
            self.now = self.now.max(until);
            return Step::Nothing;
        };
        self.now = next;
        let due = |time: Option<Instant>| time.is_some_and(|time| time <= next);
        // The end of what is said comes before what a station does at the same time: it has heard it.
        if due(self.speaking.as_ref().map(|speaking| speaking.end)) {
            self.finish();
            return Step::Ended;
        }
        if due(self.next_arrival()) {
            self.arrive();
            self.drain_master();
        } else if due(self.sends_until) {
            self.sends_until = None;
            self.master.handle_sent(next);
            self.drain_master();
        } else if due(self.next_late()) {
            self.send_late();
        } else if due(self.master_due()) {
            self.master.handle_timeout(next);
            self.drain_master();
        } else {
            for number in 0..self.buses.len() {
                let bus = self.buses.get_mut(number).filter(|bus| due(bus.poll_timeout()));
                if let Some(bus) = bus {
                    bus.handle_timeout(next);
                    self.drain(number);
                }
            }
        }
        Step::Something
    }

    /// Begins what the master has to send now.
    pub(super) fn drain_master(&mut self) {
        self.called = self.now;
        let mut buf = [0; MAX_TELEGRAM_LEN];
        // What it gives while it still sends waits in its port, as behind a UART.
        if self.sends_until.is_some() {
            return;
        }
        let sent = self.master.poll_transmit(self.now, &mut buf).and_then(|len| buf.get(..len));
        if let Some(octets) = sent.filter(|octets| !octets.is_empty()) {
            self.begin(Sender::Master, None, octets, false);
            self.sends_until = self.speaking.map(|speaking| speaking.end);
        }
    }

    /// Somebody begins to send now. Who still does so is no longer understood, nor is the new one.
    pub(super) fn begin(&mut self, sender: Sender, bus: Option<usize>, octets: &[u8], injected: bool) {
        let begin = self.now;
        let said = Said::of(octets);
        let breach = self.breach_of(sender, bus, said, injected);
        if let Some(breach) = breach {
            if self.breaches.len() == BREACHES {
                self.breaches.pop_front();
            }
            self.breaches.push_back(breach);
            self.breach_count += 1;
        }
        let end = begin.saturating_add(octet_times(self.baud, octets.len()));
        let asks = match said.first {
            Decoded::Telegram { telegram, .. } if said.is_one_telegram() && self.disturbance.is_none() => {
                Asks::Known(asked_by(&telegram, end, None))
            }
            Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => Asks::AsHeard,
        };
        let mut speaking =
            Speaking { sender, bus, begin, end, damage: Damage::None, injected, breach, asks, arrived: 0 };
        if let Some(before) = self.speaking.take() {
            speaking.damage = Damage::Collision;
            speaking.end = end.max(before.end);
            speaking.asks = Asks::Known(None);
            self.remember(&Speaking { damage: Damage::Collision, ..before });
        }
        self.octets.clear();
        self.octets.extend_from_slice(octets);
        if speaking.damage != Damage::Collision
            && let Some(disturbance) = &mut self.disturbance
        {
            let parity = disturbance(end, &mut self.octets).filter(|at| *at < self.octets.len());
            speaking.damage = parity.map_or(Damage::None, Damage::Parity);
        }
        self.speaking = Some(speaking);
    }

    /// A sending has ended: everybody else has heard it.
    fn finish(&mut self) {
        self.arrive();
        let Some(speaking) = self.speaking.take() else { return };
        self.idle_since = speaking.end;
        self.remember(&speaking);
        let from_master = speaking.sender != Sender::Station;
        if from_master {
            self.asked = match speaking.asks {
                Asks::Known(asked) => asked,
                Asks::AsHeard => self.asked_as_heard(&speaking),
            };
        }
        let sound = speaking.damage == Damage::None;
        // What a fault makes of it only the stations hear.
        let changed = (from_master && sound && !self.faults.is_empty() && is_one_telegram(&self.octets))
            .then(|| self.faults.request(self.now, self.octets.clone()));
        for number in 0..self.buses.len() {
            if speaking.bus == Some(number) {
                continue;
            }
            if let Some(bus) = self.buses.get_mut(number) {
                hear(bus, self.baud, &speaking, changed.as_deref().unwrap_or(&self.octets));
            }
            self.drain(number);
        }
        if speaking.sender != Sender::Master && M::LISTENS {
            self.drain_master();
        }
    }

    /// Brings the octets that have ended by now to the master under test.
    fn arrive(&mut self) {
        let Some(mut speaking) =
            self.speaking.filter(|speaking| M::LISTENS && speaking.sender != Sender::Master)
        else {
            return;
        };
        if speaking.damage == Damage::Collision {
            return;
        }
        let from = speaking.arrived;
        while speaking.arrived < self.octets.len()
            && speaking.begin.saturating_add(octet_times(self.baud, speaking.arrived + 1)) <= self.now
        {
            speaking.arrived += 1;
        }
        let to = speaking.arrived;
        self.speaking = Some(speaking);
        match speaking.damage {
            Damage::Parity(at) if (from..to).contains(&at) => {
                self.bring(from..at);
                self.master.handle_damaged(self.now);
                self.bring(at + 1..to);
            }
            Damage::Parity(_) | Damage::None | Damage::Collision => self.bring(from..to),
        }
    }

    /// Lets the master under test hear some of what is being said.
    fn bring(&mut self, octets: Range<usize>) {
        if let Some(octets) = self.octets.get(octets).filter(|octets| !octets.is_empty()) {
            self.master.handle_bytes(self.now, octets);
        }
    }

    /// When the next octets reach the master under test: the first, then some at once. The last come with the end.
    fn next_arrival(&self) -> Option<Instant> {
        let speaking = self.speaking.filter(|speaking| M::LISTENS && speaking.sender != Sender::Master)?;
        if speaking.damage == Damage::Collision {
            return None;
        }
        let next = if speaking.arrived == 0 { 1 } else { speaking.arrived + OCTETS_AT_ONCE };
        (next < self.octets.len()).then(|| speaking.begin.saturating_add(octet_times(self.baud, next)))
    }

    /// When the master under test wants to be called; always later than it was.
    fn master_due(&self) -> Option<Instant> {
        let earliest = self.called.saturating_add(self.baud.bit_times(1));
        self.master.poll_timeout().map(|due| if due <= self.called { earliest } else { due })
    }

    /// Lets a bus send what it has to send now.
    fn drain(&mut self, number: usize) {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        while let Some(octets) =
            self.buses.get_mut(number).and_then(|bus| bus.poll_transmit(self.now, &mut buf))
        {
            if self.faults.is_empty() {
                self.begin(Sender::Station, Some(number), octets, false);
                continue;
            }
            let reply = self.faults.reply(octets);
            let injected = reply.is_changed(octets);
            if reply.delay().is_zero() {
                let said: Vec<u8> = reply.telegrams().flatten().copied().collect();
                if !said.is_empty() {
                    self.begin(Sender::Station, Some(number), &said, injected);
                }
            } else {
                let due = self.now.saturating_add(reply.delay());
                let octets = reply.telegrams().flatten().copied().collect();
                self.late.push(Late { due, bus: number, octets });
            }
        }
    }

    fn next_late(&self) -> Option<Instant> {
        self.late.iter().map(|late| late.due).min()
    }

    /// Begins the reply that is due first.
    fn send_late(&mut self) {
        let first = self.next_late();
        if let Some(place) = self.late.iter().position(|late| Some(late.due) == first) {
            let Late { bus, octets, .. } = self.late.remove(place);
            self.begin(Sender::Station, Some(bus), &octets, true);
        }
    }

    fn remember(&mut self, speaking: &Speaking) {
        let Speaking { begin, end, sender, damage, breach, .. } = *speaking;
        let mut octets = self.history.room();
        octets.extend_from_slice(&self.octets);
        self.history.push(Passed { at: begin, end, sender, octets, damage, breach });
    }

    /// Who must reply to what was heard: the last of several requests, octets behind it notwithstanding.
    fn asked_as_heard(&self, speaking: &Speaking) -> Option<Asked> {
        let whole = match speaking.damage {
            Damage::None => &self.octets[..],
            Damage::Parity(at) => self.octets.get(..at)?,
            Damage::Collision => return None,
        };
        let (mut rest, mut asked) = (whole, None);
        while let Decoded::Telegram { telegram, len } = decode(rest) {
            asked = asked_by(&telegram, speaking.end, asked);
            rest = rest.get(len..).unwrap_or_default();
            if rest.is_empty() {
                break;
            }
        }
        asked
    }
}

/// Who must reply to a telegram that ends at `end`, who was asked `before` notwithstanding.
fn asked_by(telegram: &Telegram<'_>, end: Instant, before: Option<Asked>) -> Option<Asked> {
    match telegram {
        Telegram::Data(data) => match data.fc.function() {
            Function::Request(service, _) if service.wants_reply() && !data.da.is_broadcast() => {
                Some(Asked { station: data.da, master: data.sa, end })
            }
            Function::Request(..) => None,
            Function::Response(..) | Function::Reserved => before,
        },
        Telegram::Token { .. } => None,
        Telegram::ShortAcknowledge => before,
    }
}

impl<M: Master> Clock for Line<M> {
    fn now(&self) -> Instant {
        self.now
    }
}

impl<M: fmt::Debug> fmt::Debug for Line<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { master, baud, now, buses, faults, speaking, asked, .. } = self;
        f.debug_struct("Line")
            .field("now", now)
            .field("baud", baud)
            .field("master", master)
            .field("buses", buses)
            .field("faults", faults)
            .field("speaking", speaking)
            .field("asked", asked)
            .finish_non_exhaustive()
    }
}

/// T_SL by the customary table (`dp-v0.md` 1.1).
const fn customary_slot_time(baud: BaudRate) -> Duration {
    baud.bit_times(baud.slot_bits() as u32)
}

pub(super) fn octet_times(baud: BaudRate, octets: usize) -> Duration {
    baud.octet_times(u32::try_from(octets).unwrap_or(u32::MAX))
}

fn is_one_telegram(octets: &[u8]) -> bool {
    matches!(decode(octets), Decoded::Telegram { len, .. } if len == octets.len())
}

/// Lets a bus hear octets that ended now.
fn hear(bus: &mut Bus, baud: BaudRate, speaking: &Speaking, octets: &[u8]) {
    if bus.baud() != baud {
        // Bits of another length: no octet has its stop bit where it belongs.
        return bus.handle_damaged(speaking.end);
    }
    let damaged = match speaking.damage {
        Damage::None => None,
        Damage::Parity(at) => octets.get(..at).zip(octets.get(at + 1..)),
        Damage::Collision => return bus.handle_damaged(speaking.end),
    };
    match damaged {
        None => bus.handle_bytes(speaking.end, octets),
        Some((before, behind)) => {
            // Backwards from the end: how long the octets behind last.
            let back = |octets: usize| {
                let time = octet_times(baud, octets);
                Instant::from_nanos(speaking.end.as_nanos().saturating_sub(crate::time::nanos(time)))
            };
            bus.handle_bytes(back(behind.len() + 1), before);
            bus.handle_damaged(back(behind.len()));
            bus.handle_bytes(speaking.end, behind);
        }
    }
}
