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
//! unless somebody watches them; then it also tells what the words of each station depend on, in which telegrams are to be
//! read. A subscriber whose reader is slow falls behind in the broadcast, asks for no states meanwhile, and is told how many of each it lost as soon as it can be told.

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

#[cfg(test)]
use super::description::Problems;
use super::line::Lines;
use super::problem::{Problem, QueryOf};
use super::routes::Place;
use event::Item;
use feed::Shared;
use hub::{MOST_SUBSCRIBERS, Seat};
use subscriber::Subscriber;

#[cfg(test)]
pub(super) use event::TelegramEvent;
pub(super) use event::{LastRefusal, Lost, NewsEvent};
pub(super) use feed::{Feed, SentSettings};
pub(super) use hub::{Hub, Readers};

/// Messages written ahead for a subscriber at most.
const WRITTEN_AHEAD: usize = 8;

const DEFAULT_INTERVAL: u64 = 100;
const SHORTEST_INTERVAL: u64 = 20;
const LONGEST_INTERVAL: u64 = 60_000;

/// The two ends of the stream of a line.
pub(super) fn stream(line: Arc<str>, readers: Arc<Readers>) -> (Feed, Hub) {
    let shared = Arc::new(Shared::default());
    let (feed, entries) = Feed::new(Arc::clone(&shared));
    (feed, Hub::new(line, entries, shared, readers))
}

/// What to subscribe to.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Subscription {
    line: Option<String>,
    address: Option<u8>,
    kinds: Option<String>,
    interval_milliseconds: Option<u64>,
}

/// A subscription that can be.
struct Wanted {
    line: Option<Arc<str>>,
    station: Option<Place>,
    states: bool,
    news: bool,
    telegrams: bool,
    interval: Duration,
}

/// The live stream, as server-sent events
///
/// `event: state` with a State if an address is given, else with Stations: when it has changed, at most once per interval,
/// and once a second at least. `event: news` with a NewsEvent. `event: telegram` with a TelegramEvent, of frames too.
/// `event: lost` with what a slow reader did not get. The stream of a station that is removed ends, its last news says so.
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/events", tag = "stream",
    params(
        ("line" = Option<String>, Query, description = "Only this line"),
        ("address" = Option<u8>, Query, maximum = 127, description = "Only this station; telegrams from and to it"),
        ("kinds" = Option<String>, Query, pattern = "^(state|news|telegram)(,(state|news|telegram))*$", description = "state, news, telegram, with commas; without it state,news"),
        ("interval_milliseconds" = Option<u64>, Query, minimum = 20, maximum = 60000, description = "Between two states, 100 without it"),
    ),
    responses((status = 200, content_type = "text/event-stream", body = String), Problems)))]
pub(super) async fn events(
    State(lines): State<Lines>,
    QueryOf(subscription): QueryOf<Subscription>,
) -> Result<Response, Problem> {
    let wanted = subscription.wanted(&lines).await?;
    let seat = Seat::take(lines.readers()).ok_or_else(|| {
        Problem::new(
            axum::http::StatusCode::SERVICE_UNAVAILABLE,
            format!("there are {MOST_SUBSCRIBERS} readers of the stream; close one"),
        )
    })?;
    // What was told before is among the recent events.
    lines.all().iter().for_each(|line| line.hub.drain());
    let (out, messages) = mpsc::channel(WRITTEN_AHEAD);
    let (news, telegrams) = (lines.readers().news.subscribe(), lines.readers().telegrams.subscribe());
    let on =
        lines.all().into_iter().filter(|line| wanted.line.as_ref().is_none_or(|name| *name == line.name));
    let mut watches = Vec::new();
    for line in on {
        if wanted.telegrams {
            watches.push(line.hub.watch());
        }
        let address = wanted.station.as_ref().map(|place| place.address);
        let there = line.asking.ask(move |lent| match address {
            Some(address) => lent.find(address).map(drop),
            None => Ok(()),
        });
        there.await??;
    }
    let lost = Lost::default();
    let subscriber = Subscriber { lines, wanted, news, telegrams, out, lost, _seat: seat, _watches: watches };
    tokio::spawn(subscriber.run());
    Ok(response(messages))
}

/// An answer that lasts as long as its messages come.
fn response(messages: mpsc::Receiver<Bytes>) -> Response {
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/event-stream")),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    ];
    (headers, Body::from_stream(Messages(messages))).into_response()
}

/// The time between two states, if it can be.
fn interval(milliseconds: Option<u64>) -> Result<Duration, Problem> {
    let milliseconds = milliseconds.unwrap_or(DEFAULT_INTERVAL);
    if !(SHORTEST_INTERVAL..=LONGEST_INTERVAL).contains(&milliseconds) {
        return Err(Problem::value(format!(
            "interval_milliseconds must be within {SHORTEST_INTERVAL} to {LONGEST_INTERVAL}, got {milliseconds}"
        )));
    }
    Ok(Duration::from_millis(milliseconds))
}

impl Subscription {
    async fn wanted(self, lines: &Lines) -> Result<Wanted, Problem> {
        let interval = interval(self.interval_milliseconds)?;
        let named = self.line.map(|name| lines.named(&name)).transpose()?;
        let station = match (self.address, named.clone()) {
            (None, _) => None,
            (Some(address), Some(line)) => Some(Place { line, address }),
            (Some(address), None) => Some(Place { line: lines.with(address).await?, address }),
        };
        let line = named.or_else(|| station.as_ref().map(|place| place.line.clone())).map(|line| line.name);
        let mut wanted = Wanted { line, station, states: false, news: false, telegrams: false, interval };
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

impl Wanted {
    fn concerns(&self, item: &Item) -> bool {
        item.concerns(self.line.as_deref(), self.station.as_ref().map(|place| place.address))
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
