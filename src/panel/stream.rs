//! The live stream: states, news and telegrams as server-sent events.
//!
//! ```text
//! thread of the bus ──Entry──▶ ring ──▶ Hub ──Item──▶ broadcast ──▶ subscriber ──▶ socket
//!                 never waits        drained every 25 ms       lags: counts what it lost
//!                                             states are asked for when their time has come ──▶
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `feed` | the end at the thread of the bus |
//! | `hub` | the middle |
//! | `subscriber` | one reader |
//! | `event` | the events and how they are written |
//!
//! The middle also keeps what was, for who comes late: [`History`](super::history::History).
//!
//! The thread of the bus only puts fixed-size entries into a ring that was allocated before, and nothing of telegrams
//! unless somebody watches them; then it also tells mode and unit of the drives, in which telegrams are to be read. A subscriber whose reader is slow falls behind in the broadcast, asks for no states
//! meanwhile, and is told how many of each it lost as soon as it can be told.

mod event;
mod feed;
mod hub;
mod subscriber;

use core::pin::Pin;
use core::task::{Context, Poll};
use core::time::Duration;
use std::sync::Arc;

use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use futures_core::Stream;
use serde::Deserialize;
use tokio::sync::mpsc;

use super::bus_access::Asking;
use super::problem::{Problem, Problems, QueryOf};
use crate::profibus::fdl::Address;
use feed::Shared;
use hub::Place;
use subscriber::Subscriber;

pub(super) use event::{Lost, NewsEvent, TelegramEvent, message_of};
pub(super) use feed::{Feed, SentSettings};
pub(super) use hub::{Hub, MOST_SUBSCRIBERS};
pub(super) use subscriber::HEARTBEAT;

/// Messages written ahead for a subscriber at most.
pub(super) const WRITTEN_AHEAD: usize = 8;

const DEFAULT_INTERVAL: u64 = 100;
const SHORTEST_INTERVAL: u64 = 20;
const LONGEST_INTERVAL: u64 = 60_000;

/// The two ends of the stream.
pub(super) fn stream() -> (Feed, Hub) {
    let shared = Arc::new(Shared::default());
    let (feed, entries) = Feed::new(Arc::clone(&shared));
    (feed, Hub::new(entries, shared))
}

/// What to subscribe to.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Subscription {
    address: Option<u8>,
    kinds: Option<String>,
    interval_milliseconds: Option<u64>,
}

/// A subscription that can be.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    address: Option<Address>,
    states: bool,
    news: bool,
    telegrams: bool,
    interval: Duration,
}

/// The live stream, as server-sent events
///
/// `event: state` with a DriveState without parameters, a GsdStationState or a PpoDriveState if an address is given, else with Drives: when it has changed,
/// at most once per interval, and once a second at least. `event: news` with a NewsEvent. `event: telegram` with a
/// TelegramEvent. `event: lost` with what a slow reader did not get. The stream of a drive that is removed ends, its last
/// news says so.
#[utoipa::path(get, path = "/api/v1/events", tag = "stream",
    params(
        ("address" = Option<u8>, Query, maximum = 126, description = "Only this drive or station; telegrams from and to it"),
        ("kinds" = Option<String>, Query, pattern = "^(state|news|telegram)(,(state|news|telegram))*$", description = "state, news, telegram, with commas; without it state,news"),
        ("interval_milliseconds" = Option<u64>, Query, minimum = 20, maximum = 60000, description = "Between two states, 100 without it"),
    ),
    responses((status = 200, content_type = "text/event-stream", body = String), Problems))]
pub(super) async fn events(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    QueryOf(subscription): QueryOf<Subscription>,
) -> Result<Response, Problem> {
    let wanted = subscription.wanted()?;
    let place = Place::take(&hub).ok_or_else(|| {
        Problem::new(
            axum::http::StatusCode::SERVICE_UNAVAILABLE,
            format!("there are {MOST_SUBSCRIBERS} readers of the stream; close one"),
        )
    })?;
    let (out, messages) = mpsc::channel(WRITTEN_AHEAD);
    let (news, telegrams) = (hub.news(), hub.telegrams());
    let watch = wanted.telegrams.then(|| hub.watch());
    asking
        .ask(move |bench| match wanted.address {
            Some(address) if super::stations::look(bench, address).is_ok() => Ok(()),
            Some(address) if super::ppo_drives::look(bench, address).is_ok() => Ok(()),
            Some(address) => bench.drive(address).map(drop).ok_or_else(|| bench.no_drive(address)),
            None => Ok(()),
        })
        .await??;
    let lost = Lost::default();
    let subscriber =
        Subscriber { asking, hub, wanted, news, telegrams, out, lost, _place: place, _watch: watch };
    tokio::spawn(subscriber.run());
    Ok(response(messages))
}

/// An answer that lasts as long as its messages come.
pub(super) fn response(messages: mpsc::Receiver<Bytes>) -> Response {
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/event-stream")),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    ];
    (headers, Body::from_stream(Messages(messages))).into_response()
}

/// The time between two states, if it can be.
pub(super) fn interval(milliseconds: Option<u64>) -> Result<Duration, Problem> {
    let milliseconds = milliseconds.unwrap_or(DEFAULT_INTERVAL);
    if !(SHORTEST_INTERVAL..=LONGEST_INTERVAL).contains(&milliseconds) {
        return Err(Problem::value(format!(
            "interval_milliseconds must be within {SHORTEST_INTERVAL} to {LONGEST_INTERVAL}, got {milliseconds}"
        )));
    }
    Ok(Duration::from_millis(milliseconds))
}

impl Subscription {
    fn wanted(&self) -> Result<Wanted, Problem> {
        let address = self.address.map(Address::station).transpose().map_err(Problem::value)?;
        let interval = interval(self.interval_milliseconds)?;
        let mut wanted = Wanted { address, states: false, news: false, telegrams: false, interval };
        for kind in self.kinds.as_deref().unwrap_or("state,news").split(',') {
            match kind {
                "state" => wanted.states = true,
                "news" => wanted.news = true,
                "telegram" => wanted.telegrams = true,
                _ => {
                    return Err(Problem::value(format!(
                        "'{kind}' is no kind of event; expected state, news, telegram, with commas"
                    )));
                }
            }
        }
        Ok(wanted)
    }
}

/// The body of a stream.
struct Messages(mpsc::Receiver<Bytes>);

impl Stream for Messages {
    type Item = Result<Bytes, core::convert::Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_recv(context).map(|message| message.map(Ok))
    }
}
