//! A station as the bus sees it: its mailbox, its error counters, and for a port what waits in both directions.

use std::collections::VecDeque;

use thiserror::Error;

use super::{CanParticipant, push_bounded};
use crate::can_bus::can::{Confinement, ErrorState, Frame, Priority, timing};
use crate::time::Instant;

/// Frames of a port that wait for the bus at most.
const MAX_OUTBOX: usize = 64;

/// Frames that wait to be taken from a port at most: 0.1 s of a full bus at 1 Mbit/s and more.
const MAX_HEARD: usize = 4096;

/// A frame cannot be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the port is full, bus off or gone")]
pub struct Full;

/// A frame that a port has heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
    /// When its last bit ended.
    pub at: Instant,
    /// The frame.
    pub frame: Frame,
}

/// What happened to a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Notes {
    /// A frame of its own had to wait for one of higher priority.
    pub arbitration_lost: bool,
    /// It saw an error frame.
    pub bus_error: bool,
    /// Frames it heard were lost because nobody took them.
    pub overruns: u64,
}

pub(super) struct Occupant<E> {
    station: Station<E>,
    /// The frame that waits for the bus.
    mailbox: Option<Frame>,
    pub(super) confinement: Confinement,
    /// The bus is not for it before then: it is error passive and has just sent.
    pub(super) suspended: Instant,
    /// When it is back from bus off.
    recovers: Option<Instant>,
    /// Its rate is that of the bus.
    pub(super) tuned: bool,
    pub(super) notes: Notes,
}

pub(super) enum Station<E> {
    Participant(Box<dyn CanParticipant<Event = E>>),
    Port { outbox: VecDeque<Frame>, heard: VecDeque<Heard>, listens: bool },
}

impl<E> Station<E> {
    pub(super) const fn port() -> Self {
        Self::Port { outbox: VecDeque::new(), heard: VecDeque::new(), listens: true }
    }
}

impl<E: 'static> Occupant<E> {
    pub(super) fn new(station: Station<E>) -> Self {
        Self {
            station,
            mailbox: None,
            confinement: Confinement::default(),
            suspended: Instant::ZERO,
            recovers: None,
            tuned: true,
            notes: Notes::default(),
        }
    }

    pub(super) fn participant(&self) -> Option<&dyn CanParticipant<Event = E>> {
        match &self.station {
            Station::Participant(participant) => Some(&**participant),
            Station::Port { .. } => None,
        }
    }

    pub(super) fn participant_mut(&mut self) -> Option<&mut dyn CanParticipant<Event = E>> {
        match &mut self.station {
            Station::Participant(participant) => Some(&mut **participant),
            Station::Port { .. } => None,
        }
    }

    /// Its bit rate; `None`: that of the bus.
    pub(super) fn bits_per_second(&self) -> Option<u32> {
        self.participant()?.bits_per_second()
    }

    pub(super) const fn is_port(&self) -> bool {
        match self.station {
            Station::Participant(_) => false,
            Station::Port { .. } => true,
        }
    }

    /// Whether somebody outside gets what it hears.
    pub(super) const fn is_listening_port(&self) -> bool {
        match self.station {
            Station::Participant(_) => false,
            Station::Port { listens, .. } => listens,
        }
    }

    fn is_on_bus(&self) -> bool {
        self.confinement.state() != ErrorState::BusOff
    }

    pub(super) fn has_room(&self) -> bool {
        match &self.station {
            Station::Participant(_) => false,
            Station::Port { outbox, .. } => self.is_on_bus() && outbox.len() < MAX_OUTBOX,
        }
    }

    pub(super) fn is_idle(&self) -> bool {
        let empty = match &self.station {
            Station::Participant(_) => true,
            Station::Port { outbox, .. } => outbox.is_empty(),
        };
        self.mailbox.is_none() && empty
    }

    /// Puts a frame of a port behind the others.
    pub(super) fn offer(&mut self, frame: Frame) -> Result<(), Full> {
        let on_bus = self.is_on_bus();
        let taken = match &mut self.station {
            Station::Port { outbox, .. } => on_bus && push_bounded(outbox, MAX_OUTBOX, frame),
            Station::Participant(_) => false,
        };
        taken.then_some(()).ok_or(Full)
    }

    pub(super) fn listen(&mut self, listens: bool) {
        if let Station::Port { listens: now, heard, .. } = &mut self.station {
            *now = listens;
            heard.clear();
        }
    }

    pub(super) fn poll_heard(&mut self) -> Option<Heard> {
        match &mut self.station {
            Station::Participant(_) => None,
            Station::Port { heard, .. } => heard.pop_front(),
        }
    }

    pub(super) fn has_heard(&self) -> bool {
        matches!(&self.station, Station::Port { heard, .. } if !heard.is_empty())
    }

    /// Takes a frame of another station.
    pub(super) fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        match &mut self.station {
            Station::Participant(participant) => participant.handle_frame(now, frame),
            Station::Port { heard, listens, .. } => {
                if *listens && !push_bounded(heard, MAX_HEARD, Heard { at: now, frame: *frame }) {
                    self.notes.overruns += 1;
                }
            }
        }
    }

    /// Its time has come. True if it was bus off until now.
    pub(super) fn wake(&mut self, now: Instant) -> bool {
        if let Station::Participant(participant) = &mut self.station {
            participant.handle_timeout(now);
        }
        let recovered = self.recovers.is_some_and(|recovers| recovers <= now);
        if recovered {
            self.recovers = None;
        }
        recovered
    }

    /// Its error counters have taken it to `state`; if that is bus off, it is back at `recovers`.
    pub(super) fn enter(&mut self, now: Instant, state: ErrorState, recovers: Instant) {
        self.recovers = None;
        if state == ErrorState::BusOff {
            self.recovers = Some(recovers);
            if let Some(frame) = self.mailbox.take() {
                self.give_back(frame);
            }
            if let Station::Port { outbox, .. } = &mut self.station {
                outbox.clear();
            }
        }
        if let Station::Participant(participant) = &mut self.station {
            participant.set_error_state(now, state);
        }
    }

    /// Asks for a frame, if none waits.
    pub(super) fn fill_mailbox(&mut self, now: Instant) {
        if !self.tuned {
            // Nobody hears it, whatever it sends.
            self.mailbox = None;
            while self.participant_mut().is_some_and(|participant| participant.poll_transmit(now).is_some()) {
            }
            return;
        }
        if self.mailbox.is_none() && self.is_on_bus() {
            self.mailbox = match &mut self.station {
                Station::Participant(participant) => participant.poll_transmit(now),
                Station::Port { outbox, .. } => outbox.pop_front(),
            };
        }
    }

    /// What it puts into the arbitration at `now`.
    pub(super) fn bids(&self, now: Instant) -> Option<Priority> {
        self.mailbox.as_ref().filter(|_| self.suspended <= now).map(Frame::priority)
    }

    /// When its waiting frame may go, if one waits.
    pub(super) fn may_bid(&self) -> Option<Instant> {
        self.mailbox.is_some().then_some(self.suspended)
    }

    /// How many bits the frame has that waits, if one waits.
    pub(super) fn waiting_bits(&self) -> Option<u32> {
        self.mailbox.as_ref().map(timing::bits)
    }

    pub(super) const fn take_mailbox(&mut self) -> Option<Frame> {
        self.mailbox.take()
    }

    /// The frame could not be sent and waits again.
    pub(super) fn put_back(&mut self, frame: Frame) {
        if self.is_on_bus() {
            self.mailbox = Some(frame);
        } else {
            self.give_back(frame);
        }
    }

    fn give_back(&mut self, frame: Frame) {
        if let Station::Participant(participant) = &mut self.station {
            participant.take_back(frame);
        }
    }

    pub(super) fn poll_event(&mut self) -> Option<E> {
        match &mut self.station {
            Station::Participant(participant) => participant.poll_event(),
            Station::Port { .. } => None,
        }
    }

    /// When it wants to be called.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        let own = match &self.station {
            Station::Participant(participant) => participant.poll_timeout(),
            Station::Port { .. } => None,
        };
        Instant::first_of(own, self.recovers)
    }
}
