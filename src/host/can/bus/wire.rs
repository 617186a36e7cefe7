//! The wire: whose frame is on it, who is next, and what a frame comes to.

use super::{Bus, Damage, Event, Seat};
use crate::can_bus::can::timing;
use crate::can_bus::can::timing::{ERROR_FRAME, INTERMISSION, SUSPEND};
use crate::can_bus::can::{ErrorState, Frame, Priority};
use crate::host::can::fault::Strike;
use crate::time::Instant;

/// Frames held back or doubled by faults that wait at most; more are lost.
const MAX_LATE: usize = 256;

#[derive(Default)]
pub(super) struct Wire {
    transmission: Option<Transmission>,
    /// No frame begins before: the last one and its intermission.
    free: Instant,
    late: Vec<Late>,
}

/// A frame on the wire.
#[derive(Clone, Copy)]
struct Transmission {
    sender: Sender,
    frame: Frame,
    end: Instant,
    strike: Strike,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sender {
    Seat(Seat),
    /// A fault, with a frame of this station.
    Fault {
        of: Seat,
    },
}

/// A frame that a fault sends later or once more.
struct Late {
    due: Instant,
    of: Seat,
    frame: Frame,
}

/// Who wants the bus.
enum Bidder {
    Seat(usize),
    Late(usize),
}

impl Wire {
    pub(super) fn is_sending(&self, seat: Seat) -> bool {
        self.transmission.is_some_and(|transmission| transmission.sender == Sender::Seat(seat))
    }

    fn keep(&mut self, late: Late) {
        if self.late.len() < MAX_LATE {
            self.late.push(late);
        }
    }
}

impl<E: 'static> Bus<E> {
    /// When something happens on the wire by itself.
    pub(super) fn poll_wire(&self) -> Option<Instant> {
        if let Some(transmission) = &self.wire.transmission {
            return Some(transmission.end);
        }
        let waiting = self.seats.iter().flatten().filter_map(super::Occupant::may_bid);
        let late = self.wire.late.iter().map(|late| late.due);
        waiting.chain(late).min().map(|first| first.max(self.wire.free))
    }

    /// When a frame ends at the earliest. A fault may damage one, which ends it earlier.
    pub(super) fn poll_frame_end(&self) -> Option<Instant> {
        let begin = self.poll_wire()?;
        if self.wire.transmission.is_some() || !self.faults.is_empty() {
            return Some(begin);
        }
        let waiting = self.seats.iter().flatten().filter_map(super::Occupant::waiting_bits);
        let late = self.wire.late.iter().map(|late| timing::bits(&late.frame));
        let shortest = waiting.chain(late).min().unwrap_or_default();
        Some(begin.saturating_add(self.rate.bit_times(shortest)))
    }

    /// When the frame on the wire ends, if it is that of a port and no other port hears it.
    pub(super) fn unheard_end(&self) -> Option<Instant> {
        let Transmission { sender: Sender::Seat(from), strike: Strike::None, end, .. } =
            self.wire.transmission?
        else {
            return None;
        };
        let mut others = self.seats.iter().enumerate().filter(|(index, _)| *index != from.0);
        let unheard = others.all(|(_, seat)| seat.as_ref().is_none_or(|seat| !seat.is_listening_port()));
        (self.occupant(from)?.is_port() && unheard).then_some(end)
    }

    /// Ends the frame on the wire if its time is over: it is delivered, or it was damaged.
    pub(super) fn end_frame(&mut self, now: Instant) {
        let Some(transmission) = self.wire.transmission.filter(|transmission| transmission.end <= now) else {
            return;
        };
        self.wire.transmission = None;
        let intermission = self.rate.bit_times(INTERMISSION);
        self.wire.free = now.saturating_add(intermission);
        let Transmission { sender, frame, strike, .. } = transmission;
        let of = match sender {
            Sender::Seat(seat) | Sender::Fault { of: seat } => seat,
        };
        match (strike, sender) {
            (Strike::Damage(damage), Sender::Seat(seat)) => {
                return self.end_damaged(now, seat, frame, damage);
            }
            // What a fault sends gets no second fault.
            (Strike::Damage(_) | Strike::None, _) => self.deliver(now, of, &frame),
            (Strike::Lose, _) => {}
            (Strike::Delay(delay), _) => {
                self.wire.keep(Late { due: now.saturating_add(delay), of, frame });
            }
            (Strike::Double, _) => {
                self.deliver(now, of, &frame);
                self.wire.keep(Late { due: now, of, frame });
            }
        }
        if let Sender::Seat(seat) = sender {
            self.end_sent(now, seat);
        }
        if matches!(strike, Strike::None | Strike::Double) {
            self.counters.frames += 1;
            self.counters.remote += u64::from(frame.is_remote());
            if self.events.watched {
                let from = match sender {
                    Sender::Seat(seat) => Some(seat),
                    Sender::Fault { .. } => None,
                };
                let by_port = self.occupant(of).is_some_and(super::Occupant::is_port);
                self.events.push(Event::Passed { at: now, from, by_port, frame });
            }
        }
    }

    /// Everybody but the sender hears the frame.
    fn deliver(&mut self, now: Instant, from: Seat, frame: &Frame) {
        for index in 0..self.seats.len() {
            let seat = Seat(index);
            let Some(occupant) = self.seats.get_mut(index).and_then(Option::as_mut) else { continue };
            if seat == from || !occupant.tuned || occupant.confinement.state() == ErrorState::BusOff {
                continue;
            }
            occupant.handle_frame(now, frame);
            if occupant.confinement.receive_errors() > 0 {
                self.change_confinement(now, seat, super::Confinement::received);
            }
            self.refresh(seat);
        }
    }

    fn end_sent(&mut self, now: Instant, seat: Seat) {
        self.change_confinement(now, seat, super::Confinement::sent);
        self.suspend(now, seat);
        self.refresh(seat);
    }

    /// An error frame ended: everybody counts it, and the frame waits again.
    fn end_damaged(&mut self, now: Instant, from: Seat, frame: Frame, damage: Damage) {
        self.counters.errors += 1;
        self.events.push(Event::Damaged { at: now, from, frame, damage });
        for index in 0..self.seats.len() {
            let seat = Seat(index);
            let Some(occupant) = self.seats.get_mut(index).and_then(Option::as_mut) else { continue };
            if seat == from {
                occupant.put_back(frame);
                occupant.notes.bus_error = true;
                self.change_confinement(
                    now,
                    seat,
                    match damage {
                        Damage::Bit => super::Confinement::sending_failed,
                        Damage::NotAcknowledged => super::Confinement::not_acknowledged,
                    },
                );
                self.suspend(now, seat);
            } else if damage == Damage::Bit && occupant.confinement.state() != ErrorState::BusOff {
                occupant.notes.bus_error = true;
                self.change_confinement(now, seat, super::Confinement::receiving_failed);
            }
        }
        self.refresh(from);
    }

    /// An error passive station leaves the bus to others for a while after it has sent.
    fn suspend(&mut self, now: Instant, seat: Seat) {
        let pause = self.rate.bit_times(INTERMISSION + SUSPEND);
        if let Some(occupant) = self.seats.get_mut(seat.0).and_then(Option::as_mut)
            && occupant.confinement.state() == ErrorState::Passive
        {
            occupant.suspended = now.saturating_add(pause);
        }
    }

    /// Begins the next frame, if the bus is free and one waits.
    pub(super) fn settle(&mut self, now: Instant) {
        if self.wire.transmission.is_some() || now < self.wire.free {
            return;
        }
        let stations = self
            .seats
            .iter()
            .enumerate()
            .filter_map(|(index, occupant)| Some((occupant.as_ref()?.bids(now)?, Bidder::Seat(index))));
        let late = self.wire.late.iter().enumerate().filter(|(_, late)| late.due <= now);
        let late = late.map(|(index, late)| (late.frame.priority(), Bidder::Late(index)));
        // Of two with the same bits, which real stations must not send, the first seat wins.
        let Some((won, winner)) = stations.chain(late).min_by_key(|(priority, _)| *priority) else { return };
        match winner {
            Bidder::Late(index) => {
                let late = self.wire.late.remove(index);
                self.begin(now, Sender::Fault { of: late.of }, late.frame, Strike::None);
            }
            Bidder::Seat(index) => {
                let occupant = self.seats.get_mut(index).and_then(Option::as_mut);
                let Some(frame) = occupant.and_then(super::Occupant::take_mailbox) else { return };
                let strike = self.faults.strike(now, &frame, Seat(index));
                self.begin(now, Sender::Seat(Seat(index)), frame, strike);
            }
        }
        self.note_losers(now, won);
    }

    fn begin(&mut self, now: Instant, sender: Sender, frame: Frame, strike: Strike) {
        let bits = timing::bits(&frame);
        let bits = match strike {
            // In the middle of the frame, say.
            Strike::Damage(Damage::Bit) => bits / 2 + ERROR_FRAME,
            // Behind the acknowledge slot: the end of frame is not reached.
            Strike::Damage(Damage::NotAcknowledged) => bits - 7 + ERROR_FRAME,
            Strike::None | Strike::Lose | Strike::Delay(_) | Strike::Double => bits,
        };
        let time = self.rate.bit_times(bits);
        self.counters.busy = self.counters.busy.saturating_add(time);
        self.wire.transmission = Some(Transmission { sender, frame, end: now.saturating_add(time), strike });
    }

    fn note_losers(&mut self, now: Instant, won: Priority) {
        for occupant in self.seats.iter_mut().flatten() {
            occupant.notes.arbitration_lost |= occupant.bids(now).is_some_and(|bid| bid > won);
        }
    }
}
