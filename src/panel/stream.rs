//! The live stream: states, news and telegrams as server-sent events.
//!
//! ```text
//! thread of the bus ──Entry──▶ ring ──▶ Hub ──Item──▶ broadcast ──▶ subscriber ──▶ socket
//!                 never waits        drained every 25 ms       lags: counts what it lost
//!                                             states are asked for when their time has come ──▶
//! ```
//!
//! The thread of the bus only puts fixed-size entries into a ring that was allocated before, and nothing of telegrams
//! unless somebody watches them. A subscriber whose reader is slow falls behind in the broadcast, asks for no states
//! meanwhile, and is told how many of each it lost as soon as it can be told.

use core::pin::Pin;
use core::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use core::task::{Context, Poll};
use core::time::Duration;
use std::collections::BTreeMap;
use std::format;
use std::string::{String, ToString};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::vec::Vec;

use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use futures_core::Stream;
use serde::{Deserialize, Serialize};
use tokio::sync::{broadcast, mpsc};
use tokio::time::{Instant as Moment, MissedTickBehavior, interval, sleep};
use utoipa::ToSchema;

use super::bench::Asking;
use super::drives::{Drives, Snapshot};
use super::problem::{Problem, Problems, QueryOf};
use super::state::{DriveState, DriveSummary, LastRefusal, ReasonText, reasons_of, seconds};
use crate::device::Event;
use crate::explain::{self, Mark};
use crate::fdl::{Address, MAX_TELEGRAM_LEN};
use crate::host::BusEvent;
use crate::host::link::tap::{Batch, Direction};
use crate::time::Instant;

/// Entries that wait in the ring at most; more are counted and lost.
const RING: usize = 1024;

/// Items a subscriber may be behind at most.
const BEHIND: usize = 1024;

/// Subscribers at most.
const MOST_SUBSCRIBERS: usize = 16;

/// Messages written ahead for a subscriber at most.
const WRITTEN_AHEAD: usize = 8;

/// How often the ring is looked at while somebody subscribes, and while nobody does.
const LOOK: Duration = Duration::from_millis(25);
const LOOK_IDLE: Duration = Duration::from_millis(250);

/// A state that has not changed is sent again after this time, so that a reader knows that the stream lives.
const HEARTBEAT: Duration = Duration::from_secs(1);

const DEFAULT_INTERVAL: u64 = 100;
const SHORTEST_INTERVAL: u64 = 20;
const LONGEST_INTERVAL: u64 = 60_000;

/// What the thread of the bus tells.
#[expect(clippy::large_enum_variant, reason = "a ring of fixed size, so that telling never allocates")]
enum Entry {
    News(Instant, BusEvent),
    Telegram { at: Instant, direction: Direction, len: usize, octets: [u8; MAX_TELEGRAM_LEN] },
}

/// The end of the stream at the thread of the bus. Nothing here waits or allocates.
#[derive(Clone, Debug)]
pub(super) struct Feed {
    ring: SyncSender<Entry>,
    shared: Arc<Shared>,
}

/// What both ends know.
#[derive(Debug, Default)]
struct Shared {
    /// Somebody watches telegrams.
    telegrams_watched: AtomicBool,
    news_lost: AtomicU64,
    telegrams_lost: AtomicU64,
}

impl Feed {
    pub(super) fn tell(&self, now: Instant, event: &BusEvent) {
        if self.ring.try_send(Entry::News(now, *event)).is_err() {
            self.shared.news_lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    pub(super) fn show(&self, batch: &Batch) {
        if !self.shared.telegrams_watched.load(Ordering::Relaxed) {
            return;
        }
        for seen in batch.iter() {
            for piece in seen.octets.chunks(MAX_TELEGRAM_LEN) {
                let mut octets = [0; MAX_TELEGRAM_LEN];
                for (to, octet) in octets.iter_mut().zip(piece) {
                    *to = *octet;
                }
                let entry =
                    Entry::Telegram { at: seen.at, direction: seen.direction, len: piece.len(), octets };
                if self.ring.try_send(entry).is_err() {
                    self.shared.telegrams_lost.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }
}

/// Takes what the bus tells and passes it on to subscribers.
#[derive(Clone)]
pub(super) struct Hub(Arc<Inner>);

struct Inner {
    ring: Mutex<Ring>,
    shared: Arc<Shared>,
    news: broadcast::Sender<Item>,
    telegrams: broadcast::Sender<Item>,
    subscribers: AtomicUsize,
}

/// The ring, and what was learned from what was in it.
struct Ring {
    entries: Receiver<Entry>,
    last_refusals: BTreeMap<u8, LastRefusal>,
    context: explain::Context,
}

/// A message to all subscribers that want it.
#[derive(Clone, Debug)]
struct Item {
    message: Bytes,
    /// Whom it is about; both `None`: the line.
    about: [Option<Address>; 2],
}

/// What happened, in words.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct NewsEvent {
    time_seconds: f64,
    /// The station it is about; `null`: the line.
    address: Option<u8>,
    kind: NewsKind,
    /// One line.
    text: String,
    /// Of a refused command every unmet condition, else empty.
    reasons: Vec<ReasonText>,
}

/// What happened, for filters.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum NewsKind {
    /// The drive did not do what the control word asked for.
    CommandRefused,
    /// A PKW job was answered with an error number.
    JobRefused,
    /// The drive went to fault.
    Fault,
    /// The DP slave: parameters, configuration, Data_Exchange, watchdog.
    Dp,
    /// Switched on or off, factory reset.
    Power,
    /// Stations, rate, octets that are no telegram, replies too late.
    Line,
}

/// A telegram in words.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct TelegramEvent {
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
pub(super) struct Lost {
    states: u64,
    news: u64,
    telegrams: u64,
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
/// `event: state` with a DriveState without parameters if an address is given, else with Drives: when it has changed,
/// at most once per interval, and once a second at least. `event: news` with a NewsEvent. `event: telegram` with a
/// TelegramEvent. `event: lost` with what a slow reader did not get.
#[utoipa::path(get, path = "/api/v1/events", tag = "stream",
    params(
        ("address" = Option<u8>, Query, maximum = 126, description = "Only this drive; telegrams from and to it"),
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
    if let Some(address) = wanted.address {
        asking
            .ask(move |bench| bench.drive(address).map(drop).ok_or_else(|| bench.no_drive(address)))
            .await??;
    }
    let place = Place::take(&hub).ok_or_else(|| {
        Problem::new(
            axum::http::StatusCode::SERVICE_UNAVAILABLE,
            format!("there are {MOST_SUBSCRIBERS} readers of the stream; close one"),
        )
    })?;
    let (out, messages) = mpsc::channel(WRITTEN_AHEAD);
    let news = hub.0.news.subscribe();
    let telegrams = hub.0.telegrams.subscribe();
    let subscriber =
        Subscriber { asking, hub, wanted, news, telegrams, out, lost: Lost::default(), _place: place };
    tokio::spawn(subscriber.run());
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/event-stream")),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    ];
    Ok((headers, Body::from_stream(Messages(messages))).into_response())
}

impl Subscription {
    fn wanted(&self) -> Result<Wanted, Problem> {
        let address = self.address.map(Address::station).transpose().map_err(Problem::value)?;
        let milliseconds = self.interval_milliseconds.unwrap_or(DEFAULT_INTERVAL);
        if !(SHORTEST_INTERVAL..=LONGEST_INTERVAL).contains(&milliseconds) {
            return Err(Problem::value(format!(
                "interval_milliseconds must be within {SHORTEST_INTERVAL} to {LONGEST_INTERVAL}, got {milliseconds}"
            )));
        }
        let interval = Duration::from_millis(milliseconds);
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

/// One of the places for subscribers.
struct Place(Hub);

impl Place {
    fn take(hub: &Hub) -> Option<Self> {
        let taken = hub.0.subscribers.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |count| {
            (count < MOST_SUBSCRIBERS).then_some(count + 1)
        });
        taken.ok().map(|_| Self(hub.clone()))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.0.subscribers.fetch_sub(1, Ordering::SeqCst);
    }
}

/// One reader of the stream.
struct Subscriber {
    asking: Asking,
    hub: Hub,
    wanted: Wanted,
    news: broadcast::Receiver<Item>,
    telegrams: broadcast::Receiver<Item>,
    out: mpsc::Sender<Bytes>,
    lost: Lost,
    _place: Place,
}

/// What a subscriber does next.
enum Next {
    State(Moment),
    News(Result<Item, broadcast::error::RecvError>),
    Telegram(Result<Item, broadcast::error::RecvError>),
    Gone,
}

impl Subscriber {
    async fn run(mut self) {
        let _watching = self.wanted.telegrams.then(|| Watching::begin(&self.hub));
        let mut ticks = interval(self.wanted.interval);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut last_tick: Option<Moment> = None;
        let mut sent = Sent::default();
        loop {
            let next = tokio::select! {
                () = self.out.closed() => Next::Gone,
                item = self.news.recv(), if self.wanted.news => Next::News(item),
                item = self.telegrams.recv(), if self.wanted.telegrams => Next::Telegram(item),
                tick = ticks.tick(), if self.wanted.states => Next::State(tick),
            };
            let message = match next {
                Next::Gone => return,
                Next::News(Ok(item)) | Next::Telegram(Ok(item)) => {
                    item.concerns(self.wanted.address).then_some(item.message)
                }
                Next::News(Err(broadcast::error::RecvError::Lagged(count))) => {
                    self.lost.news = self.lost.news.saturating_add(count);
                    None
                }
                Next::Telegram(Err(broadcast::error::RecvError::Lagged(count))) => {
                    self.lost.telegrams = self.lost.telegrams.saturating_add(count);
                    None
                }
                Next::News(Err(broadcast::error::RecvError::Closed))
                | Next::Telegram(Err(broadcast::error::RecvError::Closed)) => return,
                Next::State(tick) => {
                    let late = last_tick
                        .map_or(0, |last| intervals(tick.duration_since(last), self.wanted.interval));
                    self.lost.states = self.lost.states.saturating_add(late.saturating_sub(1));
                    last_tick = Some(tick);
                    match self.state(&mut sent).await {
                        Ok(message) => message,
                        // The bus has no time: this state is not sent, the next may be.
                        Err(_) if !self.asking.has_ended() => None,
                        Err(_) => return,
                    }
                }
            };
            if self.lost != Lost::default() {
                let lost = core::mem::take(&mut self.lost);
                if self.out.send(message_of("lost", &lost)).await.is_err() {
                    return;
                }
            }
            if let Some(message) = message
                && self.out.send(message).await.is_err()
            {
                return;
            }
        }
    }

    /// The state, if it has changed or was not sent for a while.
    async fn state(&self, sent: &mut Sent) -> Result<Option<Bytes>, Problem> {
        match self.wanted.address {
            Some(address) => {
                let state = Snapshot::take(&self.asking, address).await?.state(&self.hub);
                Ok(sent.drive(state))
            }
            None => Ok(sent.drives(self.asking.ask(|bench| Drives::of(bench)).await?)),
        }
    }
}

/// Between two ticks; a late one counts as many.
fn intervals(time: Duration, interval: Duration) -> u64 {
    let half = interval / 2;
    u64::try_from(time.saturating_add(half).as_nanos() / interval.as_nanos().max(1)).unwrap_or(u64::MAX)
}

/// What was sent last, and when.
#[derive(Default)]
struct Sent {
    drive: Option<DriveState>,
    drives: Option<Drives>,
    at: Option<Moment>,
}

impl Sent {
    fn drive(&mut self, state: DriveState) -> Option<Bytes> {
        let still = self.drive.as_ref().is_some_and(|before| state.is_same(before));
        let message = self.due(still).then(|| message_of("state", &state))?;
        self.drive = Some(state);
        Some(message)
    }

    fn drives(&mut self, drives: Drives) -> Option<Bytes> {
        let timeless = |drives: &Drives| drives.drives.iter().map(DriveSummary::timeless).collect::<Vec<_>>();
        let still = self.drives.as_ref().is_some_and(|before| timeless(before) == timeless(&drives));
        let message = self.due(still).then(|| message_of("state", &drives))?;
        self.drives = Some(drives);
        Some(message)
    }

    /// Whether to send, given that nothing has changed.
    fn due(&mut self, still: bool) -> bool {
        let now = Moment::now();
        let due = !still || self.at.is_none_or(|at| now.duration_since(at) >= HEARTBEAT);
        if due {
            self.at = Some(now);
        }
        due
    }
}

/// Somebody watches telegrams as long as this lives.
struct Watching(Hub);

impl Watching {
    fn begin(hub: &Hub) -> Self {
        hub.0.shared.telegrams_watched.store(true, Ordering::Relaxed);
        Self(hub.clone())
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        // The receiver of this subscriber still counts.
        let others = self.0.0.telegrams.receiver_count() > 1;
        self.0.0.shared.telegrams_watched.store(others, Ordering::Relaxed);
    }
}

impl Item {
    fn concerns(&self, address: Option<Address>) -> bool {
        let of_line = self.about == [None, None];
        let all = self.about.into_iter().flatten().any(Address::is_broadcast);
        address.is_none_or(|address| of_line || all || self.about.contains(&Some(address)))
    }
}

/// The two ends of the stream.
pub(super) fn stream() -> (Feed, Hub) {
    let (ring, entries) = sync_channel(RING);
    let shared = Arc::new(Shared::default());
    let ring_end = Ring { entries, last_refusals: BTreeMap::new(), context: explain::Context::default() };
    let hub = Hub(Arc::new(Inner {
        ring: Mutex::new(ring_end),
        shared: Arc::clone(&shared),
        news: broadcast::channel(BEHIND).0,
        telegrams: broadcast::channel(BEHIND).0,
        subscribers: AtomicUsize::new(0),
    }));
    (Feed { ring, shared }, hub)
}

impl Hub {
    /// Passes on what the bus tells, for ever.
    pub(super) async fn run(self) {
        loop {
            let idle = self.0.subscribers.load(Ordering::SeqCst) == 0;
            sleep(if idle { LOOK_IDLE } else { LOOK }).await;
            drop(self.drained());
        }
    }

    /// The newest request that a drive refused.
    pub(super) fn last_refusal(&self, address: Address) -> Option<LastRefusal> {
        self.drained().last_refusals.get(&address.number()).cloned()
    }

    fn drained(&self) -> MutexGuard<'_, Ring> {
        let Inner { ring, shared, news, telegrams, .. } = &*self.0;
        let mut ring = ring.lock().unwrap_or_else(PoisonError::into_inner);
        // No more than there can be: the bus may go on telling.
        for _ in 0..RING {
            let Ok(entry) = ring.entries.try_recv() else { break };
            // Whether somebody hears it is not our concern.
            let _ = match entry {
                Entry::News(at, event) => {
                    ring.remember(at, &event);
                    news.send(NewsEvent::item(at, &event))
                }
                Entry::Telegram { at, direction, len, octets } => {
                    let octets = octets.get(..len).unwrap_or_default();
                    telegrams.send(TelegramEvent::item(at, direction, octets, &mut ring.context))
                }
            };
        }
        let lost = Lost {
            states: 0,
            news: shared.news_lost.swap(0, Ordering::Relaxed),
            telegrams: shared.telegrams_lost.swap(0, Ordering::Relaxed),
        };
        let message = |lost: &Lost| Item { message: message_of("lost", lost), about: [None, None] };
        if lost.news > 0 {
            let _ = news.send(message(&Lost { telegrams: 0, ..lost }));
        }
        if lost.telegrams > 0 {
            let _ = telegrams.send(message(&Lost { news: 0, ..lost }));
        }
        ring
    }
}

impl Ring {
    fn remember(&mut self, at: Instant, event: &BusEvent) {
        if let BusEvent::Station { address, event: Event::CommandRefused(refusal) } = event {
            self.last_refusals.insert(address.number(), LastRefusal::of(refusal, at));
        }
    }
}

impl NewsEvent {
    fn item(at: Instant, event: &BusEvent) -> Item {
        let (address, kind) = match event {
            BusEvent::Station { address, event } => (Some(*address), NewsKind::of(event)),
            BusEvent::Joined { address } | BusEvent::AddressLive { address, .. } => {
                (Some(*address), NewsKind::Line)
            }
            BusEvent::TelegramRefused(_)
            | BusEvent::MovedToTakenAddress { .. }
            | BusEvent::Rate(_)
            | BusEvent::Lost { .. } => (None, NewsKind::Line),
        };
        let mut reasons = Vec::new();
        if let BusEvent::Station { event: Event::CommandRefused(refusal), .. } = event {
            reasons = reasons_of(refusal);
        }
        let news = Self {
            time_seconds: seconds(at),
            address: address.map(Address::number),
            kind,
            text: event.to_string(),
            reasons,
        };
        Item { message: message_of("news", &news), about: [address, None] }
    }
}

impl NewsKind {
    const fn of(event: &Event) -> Self {
        match event {
            Event::CommandRefused(_) => Self::CommandRefused,
            Event::JobRefused(_) => Self::JobRefused,
            Event::Fault(_) => Self::Fault,
            Event::Dp(_) => Self::Dp,
            Event::SwitchedOff | Event::SwitchedOn(_) | Event::FactoryReset(_) => Self::Power,
            Event::TelegramRefused(_) | Event::ReplyTooLate(_) | Event::Lost { .. } => Self::Line,
        }
    }
}

impl TelegramEvent {
    fn item(at: Instant, direction: Direction, octets: &[u8], context: &mut explain::Context) -> Item {
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
fn message_of(event: &str, data: &impl Serialize) -> Bytes {
    // Nothing here has a key that is no string, so this always works.
    let data = serde_json::to_string(data).unwrap_or_default();
    Bytes::from(format!("event: {event}\ndata: {data}\n\n"))
}

/// The body of a stream.
struct Messages(mpsc::Receiver<Bytes>);

impl Stream for Messages {
    type Item = Result<Bytes, core::convert::Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_recv(context).map(|message| message.map(Ok))
    }
}
