//! A CAN bus in memory: arbitration, bit times, errors; without a clock and without I/O.
//!
//! ```text
//! frames offered ──▶ lowest identifier first ──▶ on the wire, bit by bit of time ──▶ everybody but the sender
//!                          ▲                               │ error frame
//!                          └───────── again ───────────────┘
//! ```
//!
//! There is one order of frames for everybody. A frame takes the time of its bits, stuff bits included; the next one
//! begins three bits later. Frames that wait when the bus becomes free go out lowest identifier first. All times are
//! those of the bits: who calls late finds the same frames at the same times, up to `CATCH_UP`.
//!
//! Frames on purpose corrupted are in [`fault`](super::fault).

use core::any::Any;
use core::time::Duration;
use std::collections::VecDeque;

use super::CanParticipant;
use super::fault::Faults;
use crate::can_bus::can::{BitRate, Confinement, ErrorState, Frame};
use crate::host::ValueBoard;
use crate::time::Instant;

mod event;
mod occupant;
mod wire;

pub use event::{Counters, Damage, Event, Tuned};
pub(crate) use occupant::Notes;
pub use occupant::{Full, Heard};

use event::Events;
use occupant::{Occupant, Station};
use wire::Wire;

/// How far behind `now` frames and deadlines are still worked off at their own times. Whoever calls later than that
/// (a process that was stopped for a minute) finds the bus as if it had stood still meanwhile.
pub(crate) const CATCH_UP: Duration = Duration::from_millis(100);

/// How far [`Bus::look_ahead`] goes at most: what acts on a station by hand comes so much later than the clock says.
const LOOK_AHEAD: Duration = Duration::from_millis(1);

/// How much later a station is called again that was called at its time and wants to be called at that time still.
const AGAIN: Duration = Duration::from_micros(100);

/// What became of the rate that a master uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeOver {
    /// The bus has it already.
    Same,
    /// The bus has it now.
    Taken,
    /// No station has it: the bus keeps its own.
    Kept,
}

/// The place of a station at a bus. It can go to another station after [`Bus::remove`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Seat(usize);

impl Seat {
    /// The seat that nobody has.
    pub(crate) const NOBODY: Self = Self(usize::MAX);
}

/// A bus, and the stations at it. `E` is the news of its participants.
///
/// Calls: `handle_timeout` when [`Bus::poll_timeout`] has come, others when there is something to do; then drain
/// [`Bus::poll_event`].
pub struct Bus<E> {
    rate: BitRate,
    seats: Vec<Option<Occupant<E>>>,
    /// When each seat wants to be called.
    deadlines: Vec<Option<Instant>>,
    wire: Wire,
    faults: Faults,
    events: Events<E>,
    counters: Counters,
    /// Where values are shown that somebody follows.
    pub(super) board: Option<ValueBoard>,
    now: Instant,
}

impl<E: 'static> Bus<E> {
    /// A bus without stations.
    #[must_use]
    pub fn new(rate: BitRate) -> Self {
        Self {
            rate,
            seats: Vec::new(),
            deadlines: Vec::new(),
            wire: Wire::default(),
            faults: Faults::default(),
            events: Events::default(),
            counters: Counters::default(),
            board: None,
            now: Instant::ZERO,
        }
    }

    /// Shows the values of nodes that come from now on, if somebody follows them.
    pub(crate) fn show_on(&mut self, board: ValueBoard) {
        self.board = Some(board);
    }

    /// The rate of every station.
    pub(crate) const fn rate(&self) -> BitRate {
        self.rate
    }

    /// A master uses one of these rates from now on. The bus takes it if a station has it, or if no station has a rate of
    /// its own; else everybody goes on at the rate before, which real stations would not.
    pub(crate) fn change_over(&mut self, now: Instant, rates: &[u32]) -> ChangeOver {
        if rates.contains(&self.rate.bits_per_second()) {
            return ChangeOver::Same;
        }
        self.advance(now);
        let own = || self.seats.iter().flatten().filter_map(Occupant::bits_per_second);
        let known = rates.iter().find(|rate| own().any(|own| own == **rate));
        let any = rates.first().filter(|_| own().next().is_none());
        let Some(rate) = known.or(any).and_then(|rate| BitRate::from_bits_per_second(*rate).ok()) else {
            return ChangeOver::Kept;
        };
        self.rate = rate;
        for place in 0..self.seats.len() {
            self.refresh(Seat(place));
        }
        ChangeOver::Taken
    }

    /// Puts a station on the bus at `now`.
    pub fn add(&mut self, now: Instant, participant: Box<dyn CanParticipant<Event = E>>) -> Seat {
        self.seat(now, Station::Participant(participant))
    }

    /// Puts a port on the bus: a station whose frames come from outside, with [`Bus::send`], and go there, with
    /// [`Bus::poll_heard`].
    pub fn connect(&mut self, now: Instant) -> Seat {
        self.seat(now, Station::port())
    }

    /// Takes a station off the bus. A frame of it that is on the wire ends as it would have.
    pub fn remove(&mut self, now: Instant, seat: Seat) {
        self.advance(now);
        if let (Some(place), Some(deadline)) = (self.seats.get_mut(seat.0), self.deadlines.get_mut(seat.0)) {
            *place = None;
            *deadline = None;
        }
    }

    /// Whether a frame of a port could be taken now. False for what is no port.
    pub(crate) fn has_room(&self, seat: Seat) -> bool {
        self.occupant(seat).is_some_and(Occupant::has_room)
    }

    /// Whether every frame of a station has been sent.
    pub(crate) fn is_idle(&self, seat: Seat) -> bool {
        !self.wire.is_sending(seat) && self.occupant(seat).is_none_or(Occupant::is_idle)
    }

    /// Whether every frame of every station has been sent.
    pub(crate) fn is_quiet(&self) -> bool {
        self.seats().all(|seat| self.is_idle(seat))
    }

    /// Has a port send a frame.
    ///
    /// # Errors
    /// [`Full`] if the port is bus off, has as many frames as it holds, or is none.
    pub fn send(&mut self, now: Instant, seat: Seat, frame: Frame) -> Result<(), Full> {
        self.advance(now);
        let now = self.now;
        self.seats.get_mut(seat.0).and_then(Option::as_mut).ok_or(Full)?.offer(frame)?;
        self.refresh(seat);
        self.settle(now);
        Ok(())
    }

    /// Whether a port collects what it hears. At first it does.
    pub(crate) fn listen(&mut self, seat: Seat, listens: bool) {
        if let Some(occupant) = self.seats.get_mut(seat.0).and_then(Option::as_mut) {
            occupant.listen(listens);
        }
    }

    /// The oldest frame that a port has heard and nobody has taken yet.
    pub fn poll_heard(&mut self, seat: Seat) -> Option<Heard> {
        self.seats.get_mut(seat.0)?.as_mut()?.poll_heard()
    }

    /// Whether there is one.
    pub(crate) fn has_heard(&self, seat: Seat) -> bool {
        self.occupant(seat).is_some_and(Occupant::has_heard)
    }

    /// What happened to a port since this was asked before.
    pub(crate) fn take_notes(&mut self, seat: Seat) -> Notes {
        let occupant = self.seats.get_mut(seat.0).and_then(Option::as_mut);
        occupant.map(|occupant| core::mem::take(&mut occupant.notes)).unwrap_or_default()
    }

    /// The error counters of a station.
    pub(crate) fn confinement(&self, seat: Seat) -> Option<Confinement> {
        self.occupant(seat).map(|occupant| occupant.confinement)
    }

    /// Takes a station to an error state, as if it had seen so many errors.
    pub fn provoke(&mut self, now: Instant, seat: Seat, state: ErrorState) {
        self.advance(now);
        let now = self.now;
        self.change_confinement(now, seat, |confinement| *confinement = Confinement::in_state(state));
        self.settle(now);
    }

    /// Every seat that is taken.
    pub(crate) fn seats(&self) -> impl Iterator<Item = Seat> + '_ {
        self.seats.iter().enumerate().filter(|(_, place)| place.is_some()).map(|(index, _)| Seat(index))
    }

    /// The faults that strike frames.
    pub(crate) const fn faults(&self) -> &Faults {
        &self.faults
    }

    /// The faults that strike frames, to change them while the bus runs.
    pub(crate) const fn faults_mut(&mut self) -> &mut Faults {
        &mut self.faults
    }

    /// The participant at a seat, if it is a `T`.
    pub fn participant<T: CanParticipant<Event = E>>(&self, seat: Seat) -> Option<&T> {
        let participant: &dyn Any = self.occupant(seat)?.participant()?;
        participant.downcast_ref()
    }

    /// Does something to the participant at a seat, if it is a `T`: turns its shaft, say.
    pub fn with<T: CanParticipant<Event = E>, R>(
        &mut self,
        now: Instant,
        seat: Seat,
        act: impl FnOnce(&mut T, Instant) -> R,
    ) -> Option<R> {
        self.advance(now);
        let now = self.now;
        let participant: &mut dyn Any = self.seats.get_mut(seat.0)?.as_mut()?.participant_mut()?;
        let result = act(participant.downcast_mut()?, now);
        self.refresh(seat);
        self.settle(now);
        Some(result)
    }

    /// Whether [`Event::Passed`] is reported for each frame. At first not.
    pub const fn watch(&mut self, watched: bool) {
        self.events.watched = watched;
    }

    /// What has passed on the bus so far.
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Time has come to `now`: everything that was due until then happens, each at its time.
    pub fn handle_timeout(&mut self, now: Instant) {
        self.advance(now);
    }

    /// When to call `handle_timeout` again; `None`: nothing happens by itself.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let stations = self.deadlines.iter().flatten().min().copied();
        Instant::first_of(Instant::first_of(stations, self.poll_wire()), self.faults.next_change())
    }

    /// Takes the bus ahead of the clock, to the end of the frame on the wire, if that is soon and no port hears it: what
    /// the stations answer is known then before anybody outside can see it, and who runs the bus sleeps once for both.
    /// What ports send meanwhile still takes part in the next arbitration.
    pub(crate) fn look_ahead(&mut self) {
        let latest = self.now.saturating_add(LOOK_AHEAD);
        if let Some(end) = self.unheard_end().filter(|end| *end <= latest) {
            self.advance(end);
        }
    }

    /// As [`Bus::poll_timeout`], for who only wants to know what ports hear: of a frame that waits for the bus the
    /// earliest end counts, not the beginning.
    #[must_use]
    pub(crate) fn poll_noticed(&self) -> Option<Instant> {
        let stations = self.deadlines.iter().flatten().min().copied();
        Instant::first_of(Instant::first_of(stations, self.poll_frame_end()), self.faults.next_change())
    }

    /// The oldest news not taken yet.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<Event<E>> {
        self.events.pop()
    }

    fn seat(&mut self, now: Instant, station: Station<E>) -> Seat {
        self.advance(now);
        let now = self.now;
        let free = self.seats.iter().enumerate().position(|(index, place)| {
            // A frame on the wire still has its sender's seat.
            place.is_none() && !self.wire.is_sending(Seat(index))
        });
        let seat = Seat(free.unwrap_or_else(|| {
            self.seats.push(None);
            self.deadlines.push(None);
            self.seats.len() - 1
        }));
        if let Some(place) = self.seats.get_mut(seat.0) {
            *place = Some(Occupant::new(station));
        }
        self.refresh(seat);
        self.settle(now);
        seat
    }

    fn occupant(&self, seat: Seat) -> Option<&Occupant<E>> {
        self.seats.get(seat.0)?.as_ref()
    }

    /// Works off what is due until `now`, each at its own time.
    fn advance(&mut self, now: Instant) {
        while let Some(due) = self.poll_timeout().filter(|due| *due <= now) {
            // Far behind: not one moment after the other, but from here on.
            let oldest = Instant::from_nanos(now.as_nanos().saturating_sub(crate::time::nanos(CATCH_UP)));
            let at = due.max(oldest).max(self.now);
            self.now = at;
            self.faults.look(at);
            self.end_frame(at);
            self.wake(at);
            self.settle(at);
        }
        self.now = self.now.max(now);
    }

    /// Calls every station whose deadline is reached.
    fn wake(&mut self, now: Instant) {
        for index in 0..self.seats.len() {
            if self.deadlines.get(index).copied().flatten().is_none_or(|deadline| deadline > now) {
                continue;
            }
            let seat = Seat(index);
            let recovered = match self.seats.get_mut(index).and_then(Option::as_mut) {
                Some(occupant) => occupant.wake(now),
                None => false,
            };
            if recovered {
                self.change_confinement(now, seat, |confinement| *confinement = Confinement::default());
            }
            self.refresh(seat);
            // Who still wants to be called at once waits for the bus, most likely; time must go on.
            let later = now.saturating_add(AGAIN);
            if let Some(Some(deadline)) = self.deadlines.get_mut(index)
                && *deadline <= now
            {
                *deadline = later;
            }
        }
    }

    /// Takes the frame, the news and the deadline of a station that was called.
    fn refresh(&mut self, seat: Seat) {
        let is_sending = self.wire.is_sending(seat);
        let Self { seats, deadlines, events, now, rate, .. } = self;
        let (Some(occupant), Some(deadline)) =
            (seats.get_mut(seat.0).and_then(Option::as_mut), deadlines.get_mut(seat.0))
        else {
            return;
        };
        let station = occupant.bits_per_second();
        let tuned = station.is_none_or(|station| station == rate.bits_per_second());
        if core::mem::replace(&mut occupant.tuned, tuned) != tuned {
            events.push(Event::Tuned(Tuned { at: *now, seat, station, bus: *rate }));
        }
        // A frame on the wire may have to wait there again.
        if !is_sending {
            occupant.fill_mailbox(*now);
        }
        while let Some(event) = occupant.poll_event() {
            events.push(Event::Participant { seat, event });
        }
        *deadline = occupant.poll_timeout();
    }

    fn change_confinement(&mut self, now: Instant, seat: Seat, change: impl FnOnce(&mut Confinement)) {
        let Some(occupant) = self.seats.get_mut(seat.0).and_then(Option::as_mut) else {
            return;
        };
        let before = occupant.confinement.state();
        change(&mut occupant.confinement);
        let state = occupant.confinement.state();
        if state != before {
            let recovery = self.rate.bit_times(crate::can_bus::can::confinement::RECOVERY);
            occupant.enter(now, state, now.saturating_add(recovery));
            self.events.push(Event::State { at: now, seat, state });
            self.refresh(seat);
        }
    }
}

/// Frames that wait to be heard, news that wait to be taken: what nobody takes does not grow for ever.
fn push_bounded<T>(queue: &mut VecDeque<T>, most: usize, item: T) -> bool {
    let fits = queue.len() < most;
    if fits {
        queue.push_back(item);
    }
    fits
}

#[cfg(test)]
mod tests;
