//! The events of the stream, and how they are written.

use axum::body::Bytes;
use serde::Serialize;
use utoipa::ToSchema;

use super::super::state::{ReasonText, reasons_of, seconds};
use crate::devices::StationEvent;
use crate::devices::ag03::profibus::Event;
use crate::explain::{self, Mark};
use crate::face::EventKind;
use crate::host::BusEvent;
use crate::host::link::tap::Direction;
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// What happened, in words.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(in crate::panel) struct NewsEvent {
    /// Counts up since the panel was started; `null`: the last news of a stream.
    number: Option<u64>,
    time_seconds: f64,
    /// The station it is about; `null`: the line.
    address: Option<u8>,
    kind: EventKind,
    /// One line.
    text: String,
    /// Of a refused command every unmet condition, else empty.
    reasons: Vec<ReasonText>,
}

/// A telegram in words.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(in crate::panel) struct TelegramEvent {
    time_seconds: f64,
    direction: DirectionName,
    /// Octets apart.
    octets_hex: String,
    /// One line.
    text: String,
    from_address: Option<u8>,
    to_address: Option<u8>,
    mark: MarkName,
}

/// Whether a telegram is in order.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum MarkName {
    /// In order.
    Plain,
    /// In order, and tells of trouble: a refused job, a fault, a diagnosis that is not good.
    Trouble,
    /// A mistake of whoever sent it: the drive refuses or ignores it.
    Mistake,
    /// No telegram.
    Invalid,
}

/// Which way a telegram went.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum DirectionName {
    /// Of a master or another station.
    Heard,
    /// Of a station of this bus.
    Sent,
}

impl From<Mark> for MarkName {
    fn from(mark: Mark) -> Self {
        match mark {
            Mark::Plain => Self::Plain,
            Mark::Trouble => Self::Trouble,
            Mark::Mistake => Self::Mistake,
            Mark::Invalid => Self::Invalid,
        }
    }
}

/// What a subscriber did not get because it read too slowly, since it was told last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub(in crate::panel) struct Lost {
    pub(in crate::panel) states: u64,
    pub(in crate::panel) news: u64,
    pub(in crate::panel) telegrams: u64,
}

/// A message to all subscribers that want it.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub(super) message: Bytes,
    /// Whom it is about; both `None`: the line.
    pub(super) about: [Option<Address>; 2],
}

impl Item {
    pub(super) fn concerns(&self, address: Option<Address>) -> bool {
        let of_line = self.about == [None, None];
        let all = self.about.into_iter().flatten().any(Address::is_broadcast);
        address.is_none_or(|address| of_line || all || self.about.contains(&Some(address)))
    }
}

impl NewsEvent {
    /// The last of the stream of one drive.
    pub(super) fn removed(at: Instant, address: Address) -> Bytes {
        message_of(
            "news",
            &Self {
                number: None,
                time_seconds: seconds(at),
                address: Some(address.number()),
                kind: EventKind::Removed,
                text: format!("station {address}: there is no drive any more; its stream ends here"),
                reasons: Vec::new(),
            },
        )
    }

    pub(super) fn of(number: u64, at: Instant, event: &BusEvent, words: Option<&str>) -> Self {
        let mut reasons = Vec::new();
        if let BusEvent::Station { event: StationEvent::Ag03(Event::CommandRefused(refusal)), .. } = event {
            reasons = reasons_of(refusal);
        }
        Self {
            number: Some(number),
            time_seconds: seconds(at),
            address: event.address().map(Address::number),
            kind: event.kind(),
            text: words.map_or_else(|| event.to_string(), |words| format!("{event}: {words}")),
            reasons,
        }
    }

    /// For subscribers.
    pub(super) fn item(&self) -> Item {
        Item { message: message_of("news", self), about: [self.address.map(Address::from_octet), None] }
    }

    /// Whether it is about this station, or the line.
    pub(in crate::panel) fn concerns(&self, address: Option<Address>) -> bool {
        let of = |address: Address| self.address.is_none_or(|about| about == address.number());
        address.is_none_or(of)
    }

    /// One line.
    pub(in crate::panel) fn text(&self) -> &str {
        &self.text
    }
}

impl TelegramEvent {
    pub(super) fn item(
        at: Instant,
        direction: Direction,
        octets: &[u8],
        context: &mut explain::Context,
    ) -> Item {
        let explanation = context.telegram(octets);
        let telegram = Self {
            time_seconds: seconds(at),
            direction: match direction {
                Direction::Heard => DirectionName::Heard,
                Direction::Sent => DirectionName::Sent,
            },
            octets_hex: explain::hex(octets),
            text: explanation.line(),
            from_address: explanation.from,
            to_address: explanation.to,
            mark: explanation.mark().into(),
        };
        let about = [explanation.from, explanation.to].map(|number| number.map(Address::from_octet));
        Item { message: message_of("telegram", &telegram), about }
    }
}

/// One event of the stream.
pub(in crate::panel) fn message_of(event: &str, data: &impl Serialize) -> Bytes {
    // Nothing here has a key that is no string, so this always works.
    let data = serde_json::to_string(data).unwrap_or_default();
    Bytes::from(format!("event: {event}\ndata: {data}\n\n"))
}
