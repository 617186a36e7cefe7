//! News of a bus, and the queue they wait in.

use core::fmt;
use std::collections::VecDeque;

use super::hint::{LineHint, Owned};
use super::join::Evidence;
use super::station_errors::StationErrors;
use crate::devices::StationEvent;
use crate::face::{Again, EventKind};
use crate::host::ByHand;
use crate::host::repeats::{Told, cause};
use crate::profibus::dp;
use crate::profibus::fdl::{Address, FrameError, RateChange, StationCounters};
use crate::time::{BaudRate, Instant};

/// News kept at most. When nobody takes them, newer ones are counted and dropped.
const CAPACITY: usize = 1024;

/// Something a user may want to read. `Display` is one line of plain English.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BusEvent {
    /// News of one station.
    Station {
        /// Which.
        address: Address,
        /// What.
        event: StationEvent,
    },
    /// A station has told the same again and again.
    Repeated {
        /// Which.
        address: Address,
        /// What.
        event: StationEvent,
        /// How often.
        again: Again,
    },
    /// What a user did to a station that a file describes.
    ByHand {
        /// Which.
        address: Address,
        /// What.
        what: ByHand,
    },
    /// Octets on the line were no telegram.
    TelegramRefused(FrameError),
    /// A station has listened, nobody else has its address, and it takes part from now on.
    Joined {
        /// Which.
        address: Address,
    },
    /// Somebody else has the address of a station that joined: it stays silent.
    AddressLive {
        /// Which.
        address: Address,
        /// What gave the other away.
        evidence: Evidence,
    },
    /// Set_Slave_Add gave a station the address of another station of this bus. It was disconnected.
    MovedToTakenAddress {
        /// Its address before.
        from: Address,
        /// The address of both.
        to: Address,
    },
    /// The search for the rate of the line: set the link to a rate, or the rate was found.
    Rate(RateChange),
    /// Nothing valid was heard at the rate that was found: it is searched for again.
    RateLost {
        /// The rate.
        rate: BaudRate,
    },
    /// Something on the line is odd.
    Hint(LineHint),
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u64,
    },
}

impl BusEvent {
    /// What it is about, for filters.
    pub fn kind(&self) -> EventKind {
        match self {
            Self::Station { event, .. } | Self::Repeated { event, .. } => event.kind(),
            Self::Hint(_) => EventKind::Hint,
            Self::ByHand { .. } => EventKind::Input,
            Self::Joined { .. }
            | Self::AddressLive { .. }
            | Self::MovedToTakenAddress { .. }
            | Self::TelegramRefused(_)
            | Self::Rate(_)
            | Self::RateLost { .. }
            | Self::Lost { .. } => EventKind::Line,
        }
    }

    /// The station it is about; `None`: the line.
    pub const fn address(&self) -> Option<Address> {
        match self {
            Self::Station { address, .. }
            | Self::Repeated { address, .. }
            | Self::ByHand { address, .. }
            | Self::Joined { address }
            | Self::AddressLive { address, .. } => Some(*address),
            Self::Hint(hint) => hint.station(),
            Self::MovedToTakenAddress { .. }
            | Self::TelegramRefused(_)
            | Self::Rate(_)
            | Self::RateLost { .. }
            | Self::Lost { .. } => None,
        }
    }

    /// Whether it is cyclic detail: a log leaves it out unless asked for more.
    pub fn is_detail(&self) -> bool {
        if let Self::Station { event, .. } = self {
            event.is_detail()
        } else {
            matches!(self, Self::Rate(RateChange::Try(_)))
        }
    }
}

impl fmt::Display for BusEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Station { address, event } => write!(f, "station {address}: {event}"),
            Self::Repeated { address, event, again } => write!(f, "station {address}: {again}: {event}"),
            Self::ByHand { address, what } => write!(f, "station {address}: {what}"),
            Self::TelegramRefused(error) => write!(f, "ignored octets: {error}"),
            Self::Joined { address } => write!(f, "station {address}: nobody else has this address; active"),
            Self::AddressLive { address, evidence } => {
                write!(f, "station {address} stays silent: another station has this address, {evidence}")
            }
            Self::MovedToTakenAddress { from, to } => {
                write!(f, "station {from} was given address {to}, which another station has; disconnected")
            }
            Self::Rate(RateChange::Try(rate)) => write!(f, "searching for the rate of the line at {rate}"),
            Self::Rate(RateChange::Found(rate)) => write!(f, "the rate of the line is {rate}"),
            Self::RateLost { rate } => {
                write!(
                    f,
                    "the rate of the line is lost: nothing valid was heard at {rate}; it is searched for again"
                )
            }
            Self::Hint(hint) => hint.fmt(f),
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}

/// How often what a master can cause in each of its cycles is told before it is counted; `None`: it is told each time.
fn told_each_time(event: &StationEvent) -> Option<u32> {
    let refused = matches!(event, StationEvent::Acyclic(event) if event.is_refusal());
    let times = match event.kind() {
        EventKind::Parameter | EventKind::Hint => 1,
        EventKind::CommandRefused | EventKind::JobRefused | EventKind::Dp
            if event.error().is_some() || refused =>
        {
            1
        }
        // A change of its state belongs between others; only a circle of them is counted.
        EventKind::CommandRefused | EventKind::JobRefused | EventKind::Dp => 3,
        EventKind::Fault
        | EventKind::Drive
        | EventKind::Input
        | EventKind::Power
        | EventKind::Nmt
        | EventKind::Sdo
        | EventKind::Pdo
        | EventKind::Emcy
        | EventKind::ErrorControl
        | EventKind::Line
        | EventKind::Removed => return None,
    };
    (!event.is_detail()).then_some(times)
}

/// Marks the changed parameters of a station among the places of what is told.
const PARAMETERS: u64 = 1 << 8;

/// A parameter was changed: a master may do that all the time, and to many of them.
fn is_parameter(event: &StationEvent) -> bool {
    event.kind() == EventKind::Parameter
}

/// News in the order they came.
#[derive(Debug, Default)]
pub(super) struct News {
    waiting: VecDeque<BusEvent>,
    repeats: Told<(Address, StationEvent)>,
    /// Whose the stations are.
    pub(super) owned: Owned,
    lost: u64,
}

impl News {
    #[cfg(test)]
    pub(super) fn forget_told(&mut self) {
        self.repeats = Told::default();
    }

    /// News of a station, counted where they count.
    pub(super) fn tell(
        &mut self,
        now: Instant,
        address: Address,
        (counters, errors): (&mut StationCounters, &mut StationErrors),
        event: StationEvent,
    ) {
        errors.count(&event);
        if let StationEvent::Dp(event) = &event {
            self.owned.told(now, address, event);
        }
        if matches!(event, StationEvent::ReplyTooLate(_)) {
            counters.too_late = counters.too_late.saturating_add(1);
        }
        if matches!(event, StationEvent::Dp(dp::Event::WatchdogExpired { .. })) {
            counters.watchdog_expiries = counters.watchdog_expiries.saturating_add(1);
        }
        let each = told_each_time(&event);
        let told = (address, event);
        let of = |told: &(Address, StationEvent)| {
            let (station, cause) = (u64::from(told.0.number()), cause(&told.1));
            // Changed parameters count beside complaints.
            (if is_parameter(&told.1) { station | PARAMETERS } else { station }, cause)
        };
        if each.is_none_or(|each| self.repeats.is_new(now, &told, PartialEq::eq, each, of)) {
            self.push(BusEvent::Station { address, event: told.1 });
        }
    }

    /// When something is to be told though nothing happens.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        self.repeats.poll_timeout()
    }

    /// Time has passed. Counts that are due wait with the other news from now on, whether somebody takes them or not.
    pub(super) fn advance(&mut self, now: Instant) {
        while let Some(((address, event), again)) = self.repeats.poll(now) {
            self.push(BusEvent::Repeated { address, event, again });
        }
    }

    pub(super) fn push(&mut self, event: BusEvent) {
        if self.waiting.len() < CAPACITY {
            self.waiting.push_back(event);
        } else {
            self.lost = self.lost.saturating_add(1);
        }
    }

    pub(super) fn pop(&mut self) -> Option<BusEvent> {
        self.waiting.pop_front().or_else(|| {
            let events = core::mem::take(&mut self.lost);
            (events > 0).then_some(BusEvent::Lost { events })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_master_does_wrong_in_each_cycle_is_told_once_and_counted() {
        let mut news = News::default();
        let address = Address::station(5).unwrap();
        let event = StationEvent::Dp(dp::Event::PrmForeign { master: address, owner: address });
        let (mut counters, mut errors) = (StationCounters::default(), StationErrors::default());
        let mut told = std::vec::Vec::new();
        for cycle in 0..1000 {
            let now = Instant::ZERO.saturating_add(core::time::Duration::from_millis(5 * cycle));
            news.tell(now, address, (&mut counters, &mut errors), event.clone());
            told.extend(news.pop());
        }
        assert_eq!(told, [BusEvent::Station { address, event }]);
        assert_eq!(errors.of(crate::face::ErrorKind::PrmRefused), 1000, "each is counted");
        news.advance(Instant::ZERO.saturating_add(core::time::Duration::from_secs(10)));
        let text = news.pop().map(|event| std::string::ToString::to_string(&event)).unwrap_or_default();
        assert!(text.starts_with("station 5: 999 times more in 5.0 s: ignored the parameters"), "{text}");
        assert_eq!(news.pop(), None);
    }

    #[test]
    fn a_count_that_nobody_takes_wakes_the_bus_once() {
        let mut news = News::default();
        let address = Address::station(5).unwrap();
        let event = StationEvent::Dp(dp::Event::PrmForeign { master: address, owner: address });
        let (mut counters, mut errors) = (StationCounters::default(), StationErrors::default());
        for _ in 0..2 {
            news.tell(Instant::ZERO, address, (&mut counters, &mut errors), event.clone());
        }
        let due = news.poll_timeout().unwrap();
        news.advance(due);
        assert_eq!(news.poll_timeout(), None);
    }

    #[test]
    fn a_full_queue_keeps_the_oldest_and_counts_what_it_loses() {
        let mut news = News::default();
        for octet in 0..=u8::MAX {
            for _ in 0..5 {
                news.push(BusEvent::TelegramRefused(FrameError::StartDelimiter { got: octet }));
            }
        }
        for _ in 0..CAPACITY {
            assert!(matches!(news.pop(), Some(BusEvent::TelegramRefused(_))));
        }
        assert_eq!(news.pop(), Some(BusEvent::Lost { events: 256 }));
        assert_eq!(news.pop(), None);
    }
}
