//! The events of the stream, and how they are written.

use std::sync::Arc;

use axum::body::Bytes;
use serde::Serialize;

use super::super::history::Weight;
use super::super::station::{ReasonText, seconds};
use super::feed::Told;
use crate::explain::{self, Explanation, Mark};
use crate::face::EventKind;
use crate::host::BusEvent;
use crate::host::link::tap::Direction;
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// What happened, in words.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct NewsEvent {
    /// Counts up since the process was started; `null`: the last news of a stream.
    number: Option<u64>,
    time_seconds: f64,
    /// The line it is about.
    line: String,
    /// The station it is about; `null`: the line.
    address: Option<u8>,
    kind: EventKind,
    class: ClassName,
    /// One line.
    text: String,
    /// Of a refused command every unmet condition, else empty.
    reasons: Vec<ReasonText>,
}

/// How much an event matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
enum ClassName {
    Fault,
    Refusal,
    Event,
    /// Cyclic detail.
    Detail,
}

/// A request of the master that a station refused, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct LastRefusal {
    time_seconds: f64,
    /// One line: the request and every unmet condition.
    text: String,
    reasons: Vec<ReasonText>,
    /// Whether it keeps the master from exchanging data, and is no more worth telling once it does.
    #[serde(skip)]
    pub(super) of_slave: bool,
}

/// A telegram or a frame in words.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct TelegramEvent {
    time_seconds: f64,
    line: String,
    direction: Direction,
    /// Octets apart; of a frame its data.
    octets_hex: String,
    /// One line.
    text: String,
    from_address: Option<u8>,
    to_address: Option<u8>,
    mark: Mark,
}

impl ClassName {
    const fn of(kind: EventKind, is_detail: bool) -> Self {
        match kind {
            EventKind::CommandRefused | EventKind::JobRefused => Self::Refusal,
            EventKind::Fault | EventKind::Emcy | EventKind::ErrorControl => Self::Fault,
            EventKind::Drive
            | EventKind::Parameter
            | EventKind::Input
            | EventKind::Power
            | EventKind::Dp
            | EventKind::Nmt
            | EventKind::Sdo
            | EventKind::Pdo
            | EventKind::Hint
            | EventKind::Line
            | EventKind::Removed => {
                if is_detail {
                    Self::Detail
                } else {
                    Self::Event
                }
            }
        }
    }
}

/// What a subscriber did not get because it read too slowly, since it was told last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct Lost {
    pub(in crate::panel) states: u64,
    pub(in crate::panel) news: u64,
    pub(in crate::panel) telegrams: u64,
}

/// A message to all subscribers that want it.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub(super) message: Bytes,
    pub(super) line: Arc<str>,
    /// Whom it is about; both `None`: everybody on the line.
    pub(super) about: [Option<u8>; 2],
}

impl Item {
    pub(super) fn concerns(&self, line: Option<&str>, address: Option<u8>) -> bool {
        let of_line = self.about == [None, None];
        line.is_none_or(|line| line == &*self.line)
            && address.is_none_or(|address| of_line || self.about.contains(&Some(address)))
    }
}

impl Told {
    fn address(&self) -> Option<u8> {
        match self {
            Self::Line(
                BusEvent::Station { address, .. }
                | BusEvent::Joined { address }
                | BusEvent::AddressLive { address, .. },
                _,
            ) => Some(address.number()),
            Self::Node(address, _) | Self::State(address, _) | Self::Tuned(address, _) => *address,
            Self::Line(..) | Self::Hint(_) | Self::Lost(_) => None,
            #[cfg(feature = "emulator")]
            Self::Trouble(_) => None,
        }
    }

    fn kind(&self) -> (EventKind, bool) {
        match self {
            Self::Line(event, _) => (event.kind(), event.is_detail()),
            Self::Node(_, event) => (event.kind(), event.is_detail()),
            Self::Hint(_) => (EventKind::Hint, false),
            Self::State(..) | Self::Tuned(..) | Self::Lost(_) => (EventKind::Line, false),
            #[cfg(feature = "emulator")]
            Self::Trouble(_) => (EventKind::Fault, false),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Line(event, None) => event.to_string(),
            Self::Line(event, Some(words)) => format!("{event}: {words}"),
            Self::Node(_, event) => event.to_string(),
            Self::State(_, state) => state.to_string(),
            Self::Tuned(_, tuned) => tuned.to_string(),
            Self::Hint(hint) => hint.to_string(),
            #[cfg(feature = "emulator")]
            Self::Trouble(text) => text.clone(),
            Self::Lost(events) => format!("{events} events were too many for the log and are lost"),
        }
    }

    fn reasons(&self) -> Vec<ReasonText> {
        let mut reasons = Vec::new();
        if let Self::Line(BusEvent::Station { event, .. }, _) = self {
            event.each_reason(&mut |reason| {
                reasons.push(ReasonText { reason: reason.name, text: reason.to_string() });
            });
        }
        reasons
    }

    /// The refusal that it tells, and of which station.
    pub(super) fn refusal(&self, at: Instant) -> Option<(u8, LastRefusal)> {
        let of_slave = matches!(self, Self::Line(_, Some(_)));
        let (kind, _) = self.kind();
        if kind != EventKind::CommandRefused && !of_slave {
            return None;
        }
        let text = match self {
            Self::Line(BusEvent::Station { event, .. }, None) => event.to_string(),
            Self::Line(..)
            | Self::Node(..)
            | Self::State(..)
            | Self::Tuned(..)
            | Self::Hint(_)
            | Self::Lost(_) => self.text(),
            #[cfg(feature = "emulator")]
            Self::Trouble(_) => self.text(),
        };
        let refusal = LastRefusal { time_seconds: seconds(at), text, reasons: self.reasons(), of_slave };
        Some((self.address()?, refusal))
    }
}

impl NewsEvent {
    /// How much it matters that it is kept.
    pub(super) const fn weight(&self) -> Weight {
        match self.kind {
            EventKind::Line => Weight::Noise,
            EventKind::CommandRefused
            | EventKind::JobRefused
            | EventKind::Drive
            | EventKind::Parameter
            | EventKind::Sdo
            | EventKind::Pdo
            | EventKind::Hint => Weight::Traffic,
            EventKind::Fault
            | EventKind::Input
            | EventKind::Power
            | EventKind::Dp
            | EventKind::Nmt
            | EventKind::Emcy
            | EventKind::ErrorControl
            | EventKind::Removed => Weight::State,
        }
    }

    /// The last of the stream of one station.
    pub(super) fn removed(at: Instant, line: &str, address: u8) -> Bytes {
        message_of(
            "news",
            &Self {
                number: None,
                time_seconds: seconds(at),
                line: line.into(),
                address: Some(address),
                kind: EventKind::Removed,
                class: ClassName::Event,
                text: format!("station {address}: there is no station any more; its stream ends here"),
                reasons: Vec::new(),
            },
        )
    }

    pub(super) fn of(number: u64, at: Instant, line: &str, told: &Told) -> Self {
        let (kind, is_detail) = told.kind();
        Self {
            number: Some(number),
            time_seconds: seconds(at),
            line: line.into(),
            address: told.address(),
            kind,
            class: ClassName::of(kind, is_detail),
            text: told.text(),
            reasons: told.reasons(),
        }
    }

    /// For subscribers.
    pub(super) fn item(&self) -> Item {
        let line = self.line.as_str().into();
        Item { message: message_of("news", self), line, about: [self.address, None] }
    }

    /// Whether it is about this line, and this station or the line as a whole.
    pub(in crate::panel) fn concerns(&self, line: Option<&str>, address: Option<u8>) -> bool {
        let of = |address: u8| self.address.is_none_or(|about| about == address);
        line.is_none_or(|line| line == self.line) && address.is_none_or(of)
    }

    /// Whether it came behind that number.
    pub(in crate::panel) fn is_after(&self, number: u64) -> bool {
        self.number.is_some_and(|own| own > number)
    }

    /// One line.
    pub(in crate::panel) fn text(&self) -> &str {
        &self.text
    }
}

impl TelegramEvent {
    pub(super) fn item(
        line: Arc<str>,
        (at, direction): (Instant, Direction),
        octets: &[u8],
        explanation: &Explanation,
    ) -> Item {
        let Explanation { from, to, .. } = *explanation;
        let telegram = Self {
            time_seconds: seconds(at),
            line: line.as_ref().into(),
            direction,
            octets_hex: explain::hex(octets),
            text: explanation.line(),
            from_address: from,
            to_address: to,
            mark: explanation.mark(),
        };
        Item { message: message_of("telegram", &telegram), line, about: [from, to] }
    }

    /// The same of a telegram of PROFIBUS, which may be for everybody.
    pub(super) fn of_profibus(mut item: Item) -> Item {
        if item.about.contains(&Some(Address::BROADCAST.number())) {
            item.about = [None, None];
        }
        item
    }
}

/// One event of the stream.
pub(in crate::panel) fn message_of(event: &str, data: &impl Serialize) -> Bytes {
    // Nothing here has a key that is no string, so this always works.
    let data = serde_json::to_string(data).unwrap_or_default();
    Bytes::from(format!("event: {event}\ndata: {data}\n\n"))
}
