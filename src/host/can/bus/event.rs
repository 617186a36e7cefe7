//! News and counters of a bus.

use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;

use super::{Seat, push_bounded};
use crate::can_bus::can::{BitRate, ErrorState, Frame};
use crate::time::Instant;

/// News kept at most; more are counted.
const MAX_EVENTS: usize = 16_384;

/// Something that happened on a bus.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event<E> {
    /// News of a participant.
    Participant {
        /// Whose.
        seat: Seat,
        /// What it says.
        event: E,
    },
    /// A frame ended without error. Only if the bus is [watched](super::Bus::watch).
    Passed {
        /// When its last bit ended.
        at: Instant,
        /// Who sent it; `None`: a fault did, that held it back or doubled it.
        from: Option<Seat>,
        /// Whether it is the frame of a port: of a master, where masters have the ports.
        by_port: bool,
        /// The frame.
        frame: Frame,
    },
    /// A frame ended in an error frame, and is sent again.
    Damaged {
        /// When the error frame ended.
        at: Instant,
        /// Who sent it.
        from: Seat,
        /// What was to be sent.
        frame: Frame,
        /// What went wrong.
        damage: Damage,
    },
    /// The error counters of a station took it to another state.
    State {
        /// When.
        at: Instant,
        /// Whose.
        seat: Seat,
        /// To which state.
        state: ErrorState,
    },
    /// The rate of a station is another one than that of the bus, or the same again.
    Tuned(Tuned),
    /// News were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u64,
    },
}

/// How the rates of a station and of its bus are to each other from now on. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tuned {
    /// When that began.
    pub at: Instant,
    /// Whose.
    pub seat: Seat,
    /// The rate of the station in bit/s; `None`: that of the bus.
    pub station: Option<u32>,
    /// The rate of the bus.
    pub bus: BitRate,
}

impl fmt::Display for Tuned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { station, bus, .. } = self;
        match station {
            Some(station) if *station != bus.bits_per_second() => write!(
                f,
                "its rate is {station} bit/s and that of the bus {bus}: it is silent and hears nothing until the master uses \
                 {station} bit/s"
            ),
            Some(_) | None => write!(f, "its rate is that of the bus again, {bus}: it hears and answers"),
        }
    }
}

/// What ends a frame in an error frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Damage {
    /// A bit is the other way round.
    Bit,
    /// Nobody acknowledges.
    NotAcknowledged,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bit => "bit error",
            Self::NotAcknowledged => "not acknowledged",
        })
    }
}

/// What has passed on a bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Frames that ended without error.
    pub frames: u64,
    /// Remote requests among them.
    pub remote: u64,
    /// Error frames.
    pub errors: u64,
    /// How long bits were on the wire, without the three between two frames.
    pub busy: Duration,
}

impl Counters {
    /// The part of the `time` since `earlier` was read in which the bus was busy, 0 to 1.
    #[must_use]
    pub fn load_since(&self, earlier: &Self, time: Duration) -> f64 {
        let busy = self.busy.saturating_sub(earlier.busy);
        if time.is_zero() { 0.0 } else { (busy.as_secs_f64() / time.as_secs_f64()).min(1.0) }
    }
}

/// News in the order in which they came up.
pub(super) struct Events<E> {
    queue: VecDeque<Event<E>>,
    lost: u64,
    pub(super) watched: bool,
}

impl<E> Default for Events<E> {
    fn default() -> Self {
        Self { queue: VecDeque::new(), lost: 0, watched: false }
    }
}

impl<E> Events<E> {
    pub(super) fn push(&mut self, event: Event<E>) {
        if !push_bounded(&mut self.queue, MAX_EVENTS, event) {
            self.lost += 1;
        }
    }

    /// The oldest; that some were lost comes where they would have come.
    pub(super) fn pop(&mut self) -> Option<Event<E>> {
        let lost = |lost: &mut u64| match core::mem::take(lost) {
            0 => None,
            events => Some(Event::Lost { events }),
        };
        self.queue.pop_front().or_else(|| lost(&mut self.lost))
    }
}
