//! The stations of a bus: who hears what, who sends when.

use super::deadlines::Deadlines;
use super::event::News;
use super::hint::{Addresses, Watch};
use super::join::{Joining, Verdict};
use super::last_request::LastRequest;
use super::station_errors::StationErrors;
use super::{BusEvent, Presence, SlotTime};
use crate::devices::StationEvent;
use crate::host::{Error, Participant, ValueBoard};
use crate::profibus::fdl::station::TooLate;
use crate::profibus::fdl::{
    Address, BaudSearch, DataTelegram, FrameError, Function, LineCounters, MAX_TELEGRAM_LEN, Rates,
    StationCounters, Telegram, Timing,
};
use crate::time::{BaudRate, Instant};

/// Everything behind the framer.
pub(super) struct Stations {
    pub(super) baud: BaudRate,
    pub(super) timing: Timing,
    /// By address.
    slots: Vec<Option<Slot>>,
    /// Addresses in the order in which their stations were connected.
    order: Vec<Address>,
    deadlines: Deadlines,
    /// The station that may have a reply to send.
    awaited: Option<Address>,
    /// The address that a station gave up with its last request, and its new one: a retry of that request is still its
    /// to answer.
    moved: Option<(Address, Address)>,
    /// How many stations are joining.
    joining: usize,
    /// How many stations have a DP watchdog running, while the rate is searched for; nobody else asks.
    supervised: usize,
    pub(super) search: Option<BaudSearch>,
    pub(super) slot_time: Option<SlotTime>,
    /// The master changed and has not said anything yet: what a station still sends answers the one before.
    pub(super) silenced: bool,
    pub(super) counters: LineCounters,
    pub(super) watch: Watch,
    /// Where values are shown that somebody follows.
    pub(super) board: Option<ValueBoard>,
    pub(super) news: News,
}

/// A station and what the bus knows of it.
pub(super) struct Slot {
    pub(super) station: Box<dyn Participant>,
    pub(super) presence: Presence,
    /// What it has heard of its address, while it is joining.
    joining: Joining,
    supervised: bool,
    pub(super) counters: StationCounters,
    pub(super) errors: StationErrors,
    /// The newest request to it, to tell retries, and when its last octet was handed over.
    last: LastRequest,
    /// How often it came again without another one between.
    again: u8,
    asked: Instant,
}

impl Stations {
    pub(super) fn new(baud: BaudRate, timing: Timing) -> Self {
        let mut slots = Vec::new();
        slots.resize_with(Address::BROADCAST.number().into(), || None);
        Self {
            baud,
            timing,
            slots,
            order: Vec::new(),
            deadlines: Deadlines::new(),
            awaited: None,
            moved: None,
            joining: 0,
            supervised: 0,
            search: None,
            slot_time: None,
            silenced: false,
            counters: LineCounters::default(),
            watch: Watch::new(),
            board: None,
            news: News::default(),
        }
    }

    pub(super) fn addresses(&self) -> impl Iterator<Item = Address> + '_ {
        self.order.iter().copied()
    }

    pub(super) fn slot(&self, address: Address) -> Option<&Slot> {
        self.slots.get(index(address))?.as_ref()
    }

    pub(super) fn slot_mut(&mut self, address: Address) -> Option<&mut Slot> {
        self.slots.get_mut(index(address))?.as_mut()
    }

    pub(super) fn join(&mut self, now: Instant, station: Box<dyn Participant>) -> Result<(), Error> {
        let address = station.address();
        self.insert(station, Presence::Joining)?;
        if let Some(slot) = self.slot_mut(address) {
            slot.joining = Joining::from(now);
            self.joining += 1;
        }
        Ok(())
    }

    /// When something is to be done without octets.
    #[inline]
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        let search = self.search.and_then(|search| search.poll_timeout());
        let first = Instant::first_of(Instant::first_of(self.deadlines.first(), search), self.joining_ends());
        Instant::first_of(first, self.news.poll_timeout())
    }

    pub(super) fn insert(
        &mut self,
        mut station: Box<dyn Participant>,
        presence: Presence,
    ) -> Result<(), Error> {
        let address = station.address();
        let place = self.slots.get_mut(index(address)).filter(|place| place.is_none());
        let Some(place) = place else {
            return Err(Error::AddressTaken { address });
        };
        station.set_baud(self.baud);
        if let Some(search) = &mut self.search {
            search.add_rates(station.rates());
        }
        *place = Some(Slot {
            station,
            presence,
            joining: Joining::from(Instant::ZERO),
            supervised: false,
            counters: StationCounters::default(),
            errors: StationErrors::default(),
            last: LastRequest::NONE,
            again: 0,
            asked: Instant::ZERO,
        });
        self.order.push(address);
        self.settle(address);
        Ok(())
    }

    pub(super) fn remove(&mut self, address: Address) -> Option<Slot> {
        let slot = self.slots.get_mut(index(address))?.take()?;
        self.order.retain(|other| *other != address);
        if let Some(board) = &self.board {
            board.withdraw(address.number());
        }
        self.deadlines.set(address, None);
        self.joining -= usize::from(slot.presence == Presence::Joining);
        self.supervised -= usize::from(slot.supervised);
        self.awaited = self.awaited.filter(|awaited| *awaited != address);
        Some(slot)
    }

    pub(super) fn set_presence(&mut self, address: Address, presence: Presence) -> bool {
        let Some(slot) = self.slot_mut(address) else {
            return false;
        };
        let before = core::mem::replace(&mut slot.presence, presence);
        self.joining -= usize::from(before == Presence::Joining);
        true
    }

    pub(super) fn set_baud(&mut self, baud: BaudRate) {
        self.baud = baud;
        for slot in self.slots.iter_mut().flatten() {
            slot.station.set_baud(baud);
        }
        for at in 0..self.order.len() {
            if let Some(address) = self.order.get(at).copied() {
                self.settle(address);
            }
        }
    }

    /// The rates that one of the stations knows.
    pub(super) fn rates(&self) -> Rates {
        self.slots.iter().flatten().fold(Rates::NONE, |rates, slot| rates.union(slot.station.rates()))
    }

    /// A telegram or a refusal from the line, whose last octet came at `at` and which is known of at `now`.
    pub(super) fn hear(&mut self, at: Instant, now: Instant, result: &Result<Telegram<'_>, FrameError>) {
        self.news.advance(now);
        self.counters.hear(result);
        let telegram = match result {
            Ok(telegram) => telegram,
            Err(error) => return self.refuse(now, *error),
        };
        if self.is_searching_after(now, telegram) {
            return;
        }
        let Self { watch, slots, order, news, .. } = self;
        let presence = |address| Some(slots.get(index(address))?.as_ref()?.presence);
        let there = || Addresses::of(order.iter().copied());
        if let Some(hint) = watch.heard(now, telegram, presence, there, &mut news.owned) {
            news.push(BusEvent::Hint(hint));
        }
        if self.joining > 0 {
            self.hear_while_joining(telegram);
        }
        let to = match telegram {
            Telegram::Data(data) => Some(self.station_for(data)),
            Telegram::Token { .. } | Telegram::ShortAcknowledge => None,
        };
        // A request on the line ends the time of a reply that has not been sent: the station it is from must know.
        let ends_reply = match telegram {
            Telegram::Data(data) => matches!(data.fc.function(), Function::Request(..)),
            Telegram::Token { .. } => true,
            Telegram::ShortAcknowledge => false,
        };
        if let Some(awaited) = self.awaited.filter(|_| ends_reply) {
            self.awaited = None;
            if to.is_none_or(|to| to != awaited && !to.is_broadcast()) {
                self.deliver(now, awaited, telegram);
            }
        }
        match to {
            Some(to) if to.is_broadcast() => {
                for at in 0..self.order.len() {
                    if let Some(address) = self.order.get(at).copied() {
                        self.deliver(now, address, telegram);
                    }
                }
            }
            Some(to) => {
                if self.count_request(at, to, telegram) && ends_reply {
                    self.awaited = Some(to);
                }
                self.deliver(now, to, telegram);
            }
            None => {}
        }
    }

    /// Octets that are no telegram. While the rate is searched for they are to be expected, but not for long.
    fn refuse(&mut self, now: Instant, error: FrameError) {
        self.news.push(BusEvent::TelegramRefused(error));
        let searching = self.search.is_some_and(|search| search.is_searching());
        if let Some(hint) = self.watch.refused(now, (!searching).then_some(self.baud)) {
            self.news.push(BusEvent::Hint(hint));
        }
    }

    /// Tells the search for the rate; whether the rate is unknown, or was until this telegram.
    fn is_searching_after(&mut self, now: Instant, telegram: &Telegram<'_>) -> bool {
        let Some(search) = &mut self.search else {
            return false;
        };
        let was_searching = search.is_searching();
        let Telegram::Data(data) = telegram else {
            return was_searching;
        };
        let ours = self.slots.get(index(data.da)).is_some_and(Option::is_some);
        if let Some(found) = search.heard(now, ours) {
            self.news.push(BusEvent::Rate(found));
            for slot in self.slots.iter_mut().flatten() {
                slot.joining = Joining::from(now);
            }
        }
        was_searching
    }

    /// Where the station is that a telegram is for: the retry of the request that moved it goes to its new address.
    fn station_for(&mut self, request: &DataTelegram<'_>) -> Address {
        let Some((from, to)) = self.moved.filter(|(from, to)| [*from, *to].contains(&request.da)) else {
            return request.da;
        };
        let is_retry = |slot: &Slot| slot.last.is_repeated_by(request);
        if request.da == from && self.slot(from).is_none() && self.slot(to).is_some_and(is_retry) {
            return to;
        }
        self.moved = None;
        request.da
    }

    /// Counts a telegram to a station. Whether that station is there and takes part.
    fn count_request(&mut self, at: Instant, to: Address, telegram: &Telegram<'_>) -> bool {
        let (Some(slot), Telegram::Data(data)) = (self.slot_mut(to), telegram) else {
            return false;
        };
        if slot.presence != Presence::Active {
            return false;
        }
        let retry = slot.last.take(data);
        slot.again = if retry { slot.again.saturating_add(1) } else { 0 };
        let again = slot.again;
        slot.asked = at;
        slot.counters.request(telegram, retry);
        if retry && let Some(hint) = self.watch.asked_again(at, data, again) {
            self.news.push(BusEvent::Hint(hint));
        }
        true
    }

    fn deliver(&mut self, now: Instant, to: Address, telegram: &Telegram<'_>) {
        if self.slot(to).is_some_and(|slot| slot.presence == Presence::Active) {
            self.call(now, to, |station, news| station.handle_telegram(now, telegram, news));
        }
    }

    /// Calls every station whose deadline is reached.
    #[inline]
    pub(super) fn wake(&mut self, now: Instant) {
        let mut due = self.deadlines.due(now);
        while let Some(address) = due.next(&self.deadlines) {
            self.call(now, address, |station, news| station.handle_timeout(now, news));
        }
    }

    /// At most one station has a reply to send: a newer request has ended the time of every other.
    pub(super) fn transmit(&mut self, now: Instant, buf: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize> {
        // Nearly always nobody is due.
        self.deadlines.first().filter(|first| *first <= now)?;
        let limit = self.slot_time.map(|slot_time| slot_time.at(self.baud));
        let mut due = self.deadlines.due(now);
        // A station that is due and has nothing to send waits for `handle_timeout`: go on behind it.
        while let Some(address) = due.next(&self.deadlines) {
            let Self { slots, news, .. } = self;
            let slot = slots.get_mut(index(address)).and_then(Option::as_mut)?;
            let Slot { station, counters, errors, asked, .. } = slot;
            let len = station.poll_transmit(now, buf, &mut |event| {
                news.tell(now, address, (&mut *counters, errors), event)
            });
            let after = now.saturating_since(*asked);
            let searching = self.search.is_some_and(|search| search.is_searching());
            let too_late = limit.filter(|limit| len.is_some() && after > *limit);
            let silent = self.silenced || searching || too_late.is_some();
            if let Some(limit) = too_late {
                news.tell(
                    now,
                    address,
                    (&mut *counters, errors),
                    StationEvent::ReplyTooLate(TooLate { after, limit }),
                );
            }
            if let (Some(_), false) = (len, silent) {
                counters.reply(after);
                self.counters.reply(after);
            }
            self.awaited = self.awaited.filter(|awaited| *awaited != address || len.is_none());
            self.settle_at(now, address);
            if len.is_some() && !silent {
                return len;
            }
        }
        None
    }

    /// Lets the station at `address` do something.
    #[inline]
    fn call(
        &mut self,
        now: Instant,
        address: Address,
        act: impl FnOnce(&mut dyn Participant, &mut dyn FnMut(StationEvent)),
    ) {
        let Self { slots, deadlines, news, search, board, .. } = self;
        let Some(slot) = slots.get_mut(index(address)).and_then(Option::as_mut) else {
            return;
        };
        let Slot { station, counters, errors, .. } = slot;
        act(station.as_mut(), &mut |event| news.tell(now, address, (&mut *counters, &mut *errors), event));
        if let Some(board) = board {
            board.show(address.number(), &|| station.description());
        }
        // As `settle_at`, with the slot at hand: this runs in each application cycle of each station.
        if search.is_none() && station.address() == address {
            deadlines.set(address, station.poll_timeout());
        } else {
            self.settle_at(now, address);
        }
    }

    /// Puts the deadline of a station in its place after it was called, and tells the search for the rate whether a
    /// watchdog runs.
    fn settle_at(&mut self, now: Instant, address: Address) {
        self.settle(address);
        if let Some(search) = &mut self.search {
            search.supervise(now, self.supervised > 0);
        }
    }

    /// What a user did to a station that a file describes.
    pub(super) fn tell_by_hand(&mut self, address: Address) {
        let modules = self.slots.get_mut(index(address)).and_then(Option::as_mut);
        let Some(modules) = modules.and_then(|slot| slot.station.modules_mut()) else { return };
        while let Some(what) = modules.poll_by_hand() {
            self.news.push(BusEvent::ByHand { address, what });
        }
    }

    pub(super) fn settle(&mut self, address: Address) {
        let Self { slots, deadlines, supervised, search, .. } = self;
        let Some(slot) = slots.get_mut(index(address)).and_then(Option::as_mut) else {
            return;
        };
        deadlines.set(address, slot.station.poll_timeout());
        let watched = search.is_some() && slot.station.watchdog_on();
        *supervised = *supervised + usize::from(watched) - usize::from(slot.supervised);
        slot.supervised = watched;
        if slot.station.address() != address {
            self.move_station(address);
        }
    }

    /// Follows a station that has another address now (Set_Slave_Add). If that is taken, the station is disconnected:
    /// two at one address would answer at the same time.
    fn move_station(&mut self, from: Address) {
        let awaited = self.awaited == Some(from);
        let Some(slot) = self.remove(from) else {
            return;
        };
        let (to, presence) = (slot.station.address(), slot.presence);
        match self.insert(slot.station, presence) {
            Ok(()) => {
                self.joining += usize::from(presence == Presence::Joining);
                if let Some(moved) = self.slot_mut(to) {
                    moved.counters = slot.counters;
                    moved.errors = slot.errors;
                    moved.joining = slot.joining;
                    moved.last = slot.last;
                    moved.asked = slot.asked;
                }
                self.moved = awaited.then_some((from, to));
                if awaited {
                    self.awaited = Some(to);
                }
            }
            Err(_) => self.news.push(BusEvent::MovedToTakenAddress { from, to }),
        }
    }

    /// Lets stations that join draw their conclusions from a telegram.
    fn hear_while_joining(&mut self, telegram: &Telegram<'_>) {
        for at in 0..self.order.len() {
            let Some(address) = self.order.get(at).copied() else {
                return;
            };
            let Some(slot) = self.slot_mut(address).filter(|slot| slot.presence == Presence::Joining) else {
                continue;
            };
            match slot.joining.hear(address, telegram) {
                Verdict::Undecided => {}
                Verdict::Free => self.finish_joining(address, Presence::Active, BusEvent::Joined { address }),
                Verdict::Live(evidence) => {
                    let event = BusEvent::AddressLive { address, evidence };
                    self.finish_joining(address, Presence::Refused, event);
                }
            }
        }
    }

    fn finish_joining(&mut self, address: Address, presence: Presence, event: BusEvent) {
        self.set_presence(address, presence);
        self.news.push(event);
    }

    /// When the next station has listened long enough. While the rate is unknown nobody has.
    fn joining_ends(&self) -> Option<Instant> {
        if self.joining == 0 || self.search.is_some_and(|search| search.is_searching()) {
            return None;
        }
        let joining = self.slots.iter().flatten().filter(|slot| slot.presence == Presence::Joining);
        joining.map(|slot| slot.joining.ends()).min()
    }

    pub(super) fn end_joining(&mut self, now: Instant) {
        while self.joining_ends().is_some_and(|ends| ends <= now) {
            let done = self.order.iter().copied().find(|address| {
                let slot = self.slots.get(index(*address)).and_then(Option::as_ref);
                slot.is_some_and(|slot| slot.presence == Presence::Joining && slot.joining.ends() <= now)
            });
            let Some(address) = done else {
                return;
            };
            self.finish_joining(address, Presence::Active, BusEvent::Joined { address });
        }
    }
}

/// The place of a station in the table.
fn index(address: Address) -> usize {
    address.number().into()
}
