//! A line with many stations: octets and time in; replies, events and a deadline out.

use core::any::Any;
use core::fmt;
use core::time::Duration;
use std::path::PathBuf;

#[cfg(feature = "panel")]
use super::Startup;
use super::{Appearance, Error, GsdStation, Participant, ValueBoard};
use crate::face::{Description, Why};
use crate::profibus::fdl::baud_search::CONTROL_TIME;
use crate::profibus::fdl::{
    Address, BaudSearch, Framer, LineCounters, MAX_TELEGRAM_LEN, RateChange, StationCounters, Timing,
};
use crate::time::{BaudRate, Instant};

mod deadlines;
mod event;
mod hint;
mod join;
mod last_request;
mod station_errors;
mod stations;

pub use event::BusEvent;
pub use hint::{Addresses, LineHint};
pub use join::{Evidence, LISTEN_TIME};
pub(crate) use station_errors::StationErrors;
use stations::Stations;

/// The stations on one line: up to 127, drives and others, each with its own state.
///
/// Used like one [`Device`](crate::devices::ag03::profibus::Device), with the same contract: after every `handle_*`, drain
/// [`Bus::poll_transmit`] and [`Bus::poll_event`] to `None`, then wait for octets or [`Bus::poll_timeout`].
///
/// Octets are made into telegrams once for all stations, and a telegram goes to the station it is for: what one costs
/// does not grow with the number of stations. Stations come and go while the bus runs.
pub struct Bus {
    framer: Framer,
    stations: Stations,
}

impl fmt::Debug for Bus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stations: Vec<u8> = self.addresses().map(Address::number).collect();
        f.debug_struct("Bus").field("baud", &self.baud()).field("stations", &stations).finish_non_exhaustive()
    }
}

/// Whether a station takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum Presence {
    /// It hears its telegrams and answers them.
    Active,
    /// It listens whether somebody else has its address, and answers nothing.
    Joining,
    /// Somebody else has its address. It answers nothing until [`Bus::activate`].
    Refused,
}

/// How long a master waits for a reply, T_SL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotTime {
    /// The customary time of the rate ([`BaudRate::slot_bits`]).
    Customary,
    /// So many T_bit, 37 to 16383.
    Bits(u16),
}

impl SlotTime {
    /// The time at this rate.
    pub const fn at(self, baud: BaudRate) -> Duration {
        match self {
            Self::Customary => baud.bit_times(baud.slot_bits() as u32),
            Self::Bits(bits) => baud.bit_times(bits as u32),
        }
    }
}

impl Default for Bus {
    fn default() -> Self {
        Self::new()
    }
}

impl Bus {
    /// A line without stations and without true timing: pseudo-terminal, TCP, USB adapter, memory.
    pub fn new() -> Self {
        Self::on(BaudRate::K500, Timing::Untrue)
    }

    /// A line without stations at `baud`, with what can be known of the time of its octets.
    pub fn on(baud: BaudRate, timing: Timing) -> Self {
        Self { framer: Framer::new(timing.resync(baud)), stations: Stations::new(baud, timing) }
    }

    /// Connects a station that takes part at once, for lines where nobody else can be: a new pseudo-terminal, memory.
    ///
    /// # Errors
    /// [`Error::AddressTaken`] if another station of this bus has its address; the line is as before.
    pub fn add(&mut self, station: impl Participant) -> Result<(), Error> {
        self.stations.insert(Box::new(station), Presence::Active)
    }

    /// Connects a station that first listens whether its address is live, for lines where others may be.
    ///
    /// It answers nothing until [`BusEvent::Joined`], at most [`LISTEN_TIME`] from `now` (or from when the rate was
    /// found), earlier if a master asked the address twice in vain. If somebody else has the address,
    /// [`BusEvent::AddressLive`] comes instead and the station stays silent: [`Bus::remove`] it, or
    /// [`Bus::activate`] it all the same. Two that join one address at the same time do not hear each other.
    ///
    /// # Errors
    /// As [`Bus::add`].
    pub fn join(&mut self, now: Instant, station: impl Participant) -> Result<(), Error> {
        self.stations.join(now, Box::new(station))
    }

    /// Connects a station of any kind, as [`Bus::join`] does if it shall `listen` first, else as [`Bus::add`].
    ///
    /// # Errors
    /// As [`Bus::add`].
    pub(crate) fn connect(
        &mut self,
        now: Instant,
        station: Box<dyn Participant>,
        listen: bool,
    ) -> Result<(), Error> {
        if listen {
            self.stations.join(now, station)
        } else {
            self.stations.insert(station, Presence::Active)
        }
    }

    /// Shows the values of its stations that somebody follows.
    pub(crate) fn show_on(&mut self, board: ValueBoard) {
        self.stations.board = Some(board);
    }

    /// Lets a station take part whether or not somebody else has its address. `false`: there is no such station.
    pub fn activate(&mut self, address: Address) -> bool {
        self.stations.set_presence(address, Presence::Active)
    }

    /// Disconnects a station and returns it; the others do not notice. A reply it has not sent is never sent.
    pub fn remove(&mut self, address: Address) -> Option<Box<dyn Participant>> {
        self.stations.remove(address).map(|slot| slot.station)
    }

    /// The addresses of the stations, in the order in which they were connected.
    pub fn addresses(&self) -> impl Iterator<Item = Address> + '_ {
        self.stations.addresses()
    }

    /// Whether the station at `address` takes part; `None`: there is none.
    pub fn presence(&self, address: Address) -> Option<Presence> {
        self.stations.slot(address).map(|slot| slot.presence)
    }

    /// How a master takes the station at `address` over; `None`: there is none, or nobody can say.
    #[cfg(feature = "panel")]
    pub(crate) fn startup(&self, address: Address) -> Option<Startup> {
        self.stations.slot(address)?.station.startup()
    }

    /// What keeps the drive at `address` from moving now; `None`: there is none.
    pub fn why(&self, address: Address) -> Option<&dyn Why> {
        self.stations.slot(address)?.station.why()
    }

    /// The station at `address`, if there is one and it is a `T`.
    pub fn station<T: Participant>(&self, address: Address) -> Option<&T> {
        let station = &*self.stations.slot(address)?.station;
        let station: &dyn Any = station.stored().unwrap_or(station);
        station.downcast_ref()
    }

    /// Does something to the station at `address`, if there is one and it is a `T`: sets its inputs, say. Counts as a
    /// `handle_*` call.
    pub fn with<T: Participant, R>(&mut self, address: Address, act: impl FnOnce(&mut T) -> R) -> Option<R> {
        let station = &mut *self.stations.slot_mut(address)?.station;
        let is_stored = station.stored().is_some();
        let station: &mut dyn Any = if is_stored { station.stored_mut()? } else { station };
        let result = act(station.downcast_mut()?);
        self.stations.tell_by_hand(address);
        self.stations.settle(address);
        Some(result)
    }

    /// What acts on the station at `address` from outside and what it tells of itself; `None`: there is none, or nothing.
    pub fn description(&self, address: Address) -> Option<&dyn Description> {
        self.stations.slot(address)?.station.description()
    }

    /// Does something to the station at `address`. Counts as a `handle_*` call.
    pub(crate) fn with_description<R>(
        &mut self,
        address: Address,
        act: impl FnOnce(&mut dyn Description) -> R,
    ) -> Option<R> {
        let result = act(self.stations.slot_mut(address)?.station.description_mut()?);
        self.stations.tell_by_hand(address);
        self.stations.settle(address);
        Some(result)
    }

    /// The modules of the station at `address`; `None`: there is none, or no file describes it.
    pub fn modules(&self, address: Address) -> Option<&GsdStation> {
        self.stations.slot(address)?.station.modules()
    }

    /// Does something to the modules of the station at `address`. Counts as a `handle_*` call.
    pub(crate) fn with_modules<R>(
        &mut self,
        address: Address,
        act: impl FnOnce(&mut GsdStation) -> R,
    ) -> Option<R> {
        let result = act(self.stations.slot_mut(address)?.station.modules_mut()?);
        self.stations.tell_by_hand(address);
        self.stations.settle(address);
        Some(result)
    }

    /// The file in which the station at `address` keeps its memory.
    pub fn path(&self, address: Address) -> Option<PathBuf> {
        self.stations.slot(address)?.station.path()
    }

    /// The address that the station at `address` would have after `act` ([`Participant::address_after`]).
    pub(crate) fn address_after(
        &self,
        address: Address,
        act: &dyn Fn(&mut dyn Description),
    ) -> Option<Address> {
        self.stations.slot(address).map(|slot| slot.station.address_after(act))
    }

    /// What was heard on the line.
    pub const fn counters(&self) -> &LineCounters {
        &self.stations.counters
    }

    /// What the station at `address` was asked and answered; `None`: there is none.
    pub fn station_counters(&self, address: Address) -> Option<&StationCounters> {
        self.stations.slot(address).map(|slot| &slot.counters)
    }

    /// What went wrong at the station at `address`; `None`: there is none.
    pub(crate) fn station_errors(&self, address: Address) -> Option<&StationErrors> {
        self.stations.slot(address).map(|slot| &slot.errors)
    }

    /// What the station at `address` is and how it is; `None`: there is none.
    pub(crate) fn appearance(&self, address: Address) -> Option<Appearance<'_>> {
        self.stations.slot(address).map(|slot| slot.station.appearance())
    }

    /// The rate of the line, or the one listened at while it is being searched for.
    pub const fn baud(&self) -> BaudRate {
        self.stations.baud
    }

    /// The line has another rate now.
    pub(crate) fn set_baud(&mut self, baud: BaudRate) {
        self.stations.set_baud(baud);
        self.framer = Framer::new(self.stations.timing.resync(baud));
    }

    /// Searches for the rate of the line from `now` on, among those that one of its stations knows, and again whenever it is lost (see `crate::profibus::fdl::baud_search`).
    ///
    /// The link must be set to the rate of each [`BusEvent::Rate`] with [`RateChange::Try`], of which the first comes
    /// at once; [`run`](super::run()) does that. While the rate is unknown no station hears or sends anything.
    pub fn search_baud(&mut self, now: Instant) {
        let search = BaudSearch::new(now, CONTROL_TIME, self.stations.rates());
        self.stations.search = Some(search);
        self.try_rate(RateChange::Try(search.rate()));
    }

    /// What comes again is told as something new.
    #[cfg(test)]
    pub(crate) fn forget_told(&mut self) {
        self.stations.news.forget_told();
    }

    /// The link cannot be set to the rate of the last [`RateChange::Try`]: another one is tried at once.
    pub(crate) fn skip_rate(&mut self, now: Instant) {
        if let Some(change) = self.stations.search.as_mut().map(|search| search.skip(now)) {
            self.try_rate(change);
        }
    }

    /// How long the master waits for a reply to begin, on a line where a later one does harm: it would be credited to
    /// another station. Such a reply is dropped, counted in [`StationCounters::too_late`], and told as
    /// [`StationEvent::ReplyTooLate`](crate::devices::StationEvent::ReplyTooLate). `None`, as at first: every reply is sent.
    ///
    /// Counts from when the last octet of the request was handed over; time that octets spent in an adapter before
    /// cannot be seen.
    pub const fn set_slot_time(&mut self, slot_time: Option<SlotTime>) {
        self.stations.slot_time = slot_time;
    }

    /// Octets that ended to arrive at `now`, cut anywhere.
    pub fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        let Self { framer, stations } = self;
        stations.silenced = false;
        if stations.watch.hears_noise() {
            stations.watch.overhear(octets);
        }
        framer.handle_bytes(now, octets, |at, result| stations.hear(at, now, &result));
    }

    /// An octet with a wrong parity or stop bit that ended at `now`, on links that can tell.
    pub(crate) fn handle_damaged(&mut self, now: Instant) {
        let Self { framer, stations } = self;
        framer.handle_damaged(now, |at, result| stations.hear(at, now, &result));
    }

    /// No octet continues those that were heard: half a telegram is given up now, and counts as what it is.
    pub fn handle_broken_off(&mut self, now: Instant) {
        let Self { framer, stations } = self;
        // What is left of it may begin another one.
        for _ in 0..MAX_TELEGRAM_LEN {
            let Some(end) = framer.poll_timeout() else { return };
            framer.handle_timeout(end, |at, result| stations.hear(at, now, &result));
        }
    }

    /// The master has gone: half a telegram is forgotten, and until octets arrive again nothing is sent. It would
    /// reach somebody who did not ask.
    pub fn handle_reset(&mut self) {
        self.stations.silenced = true;
        self.framer.clear();
    }

    /// Time passed without octets. Only the stations whose deadline is reached are told.
    pub fn handle_timeout(&mut self, now: Instant) {
        let Self { framer, stations } = self;
        stations.news.advance(now);
        framer.handle_timeout(now, |at, result| stations.hear(at, now, &result));
        let searched = stations.search.is_some_and(|search| search.is_searching());
        if let Some(change) = stations.search.as_mut().and_then(|search| search.handle_timeout(now)) {
            if !searched {
                stations.news.push(BusEvent::RateLost { rate: stations.baud });
            }
            self.try_rate(change);
        }
        self.stations.end_joining(now);
        self.stations.wake(now);
    }

    /// The octets to send now, if any.
    ///
    /// The answer can change after every `handle_*` and after every `Some`.
    #[must_use]
    pub fn poll_transmit<'b>(
        &mut self,
        now: Instant,
        buf: &'b mut [u8; MAX_TELEGRAM_LEN],
    ) -> Option<&'b [u8]> {
        let len = self.stations.transmit(now, buf)?;
        buf.get(..len)
    }

    /// When to call `handle_timeout` and `poll_transmit` again; `None`: only after octets arrived.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.framer.poll_timeout(), self.stations.poll_timeout())
    }

    /// The oldest news not taken yet.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<BusEvent> {
        self.stations.news.pop()
    }

    fn try_rate(&mut self, change: RateChange) {
        if let RateChange::Try(rate) = change {
            self.set_baud(rate);
        }
        self.stations.news.push(BusEvent::Rate(change));
    }
}
