//! The live stream: states, news and frames as server-sent events.

use core::time::Duration;
use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use serde::Deserialize;
use tokio::sync::{broadcast, mpsc};
use tokio::time::{Instant as Moment, MissedTickBehavior, interval};

use super::super::problem::{Problem, Problems, QueryOf};
use super::super::stream::{self, HEARTBEAT, Lost, WRITTEN_AHEAD, message_of};
use super::access::Asking;
use super::news::{Feed, FrameReader, Numbered};
use super::state::{NodeState, Nodes};
use crate::can_bus::canopen::NodeId;

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
    node: Option<NodeId>,
    states: bool,
    news: bool,
    frames: bool,
    interval: Duration,
}

/// The live stream, as server-sent events
///
/// `event: state` with a NodeState if an address is given, else with Nodes: when it has changed, at most once per interval,
/// and once a second at least. `event: news` with a NodeNews. `event: frame` with a FrameEvent. `event: lost` with what a slow
/// reader did not get.
#[utoipa::path(get, path = "/api/v1/events", tag = "stream",
    params(
        ("address" = Option<u8>, Query, minimum = 1, maximum = 127, description = "Only this node"),
        ("kinds" = Option<String>, Query, pattern = "^(state|news|frame)(,(state|news|frame))*$", description = "state, news, frame, with commas; without it state,news"),
        ("interval_milliseconds" = Option<u64>, Query, minimum = 20, maximum = 60000, description = "Between two states, 100 without it"),
    ),
    responses((status = 200, content_type = "text/event-stream", body = String), Problems))]
pub(super) async fn events(
    State(asking): State<Asking>,
    State(feed): State<Arc<Feed>>,
    QueryOf(subscription): QueryOf<Subscription>,
) -> Result<Response, Problem> {
    let wanted = subscription.wanted()?;
    if feed.readers() >= stream::MOST_SUBSCRIBERS {
        return Err(Problem::new(
            StatusCode::SERVICE_UNAVAILABLE,
            format!("there are {} readers of the stream; close one", stream::MOST_SUBSCRIBERS),
        ));
    }
    let (out, messages) = mpsc::channel(WRITTEN_AHEAD);
    let news = feed.subscribe();
    let _frames = wanted.frames.then(|| feed.watch_frames());
    // Also has the thread of the bus see whether frames are wanted.
    asking
        .ask(move |bench| match wanted.node {
            Some(node) => bench.device(node).map(drop),
            None => Ok(()),
        })
        .await??;
    tokio::spawn(Reader { asking, wanted, news, out, lost: Lost::default(), _frames }.run());
    Ok(stream::response(messages))
}

impl Subscription {
    fn wanted(&self) -> Result<Wanted, Problem> {
        let node = self.address.map(NodeId::new).transpose().map_err(Problem::value)?;
        let interval = stream::interval(self.interval_milliseconds)?;
        let mut wanted = Wanted { node, states: false, news: false, frames: false, interval };
        for kind in self.kinds.as_deref().unwrap_or("state,news").split(',') {
            match kind {
                "state" => wanted.states = true,
                "news" => wanted.news = true,
                "frame" => wanted.frames = true,
                _ => {
                    return Err(Problem::value(format!(
                        "'{kind}' is no kind of event; expected state, news, frame, with commas"
                    )));
                }
            }
        }
        Ok(wanted)
    }
}

/// One reader of the stream.
struct Reader {
    asking: Asking,
    wanted: Wanted,
    news: broadcast::Receiver<Numbered>,
    out: mpsc::Sender<Bytes>,
    lost: Lost,
    _frames: Option<FrameReader>,
}

/// What was sent last, and when.
#[derive(Default)]
struct Sent {
    node: Option<NodeState>,
    nodes: Option<Nodes>,
    at: Option<Moment>,
}

impl Reader {
    async fn run(mut self) {
        let mut ticks = interval(self.wanted.interval);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut sent = Sent::default();
        loop {
            let message = tokio::select! {
                () = self.out.closed() => return,
                told = self.news.recv() => match told {
                    Ok(told) => self.told(&told),
                    Err(broadcast::error::RecvError::Lagged(count)) => {
                        self.lost.news = self.lost.news.saturating_add(count);
                        None
                    }
                    Err(broadcast::error::RecvError::Closed) => return,
                },
                _ = ticks.tick(), if self.wanted.states => match self.look(&mut sent).await {
                    Ok(message) => message,
                    // The bus has no time, or the node has another number: the next look may find it.
                    Err(_) if !self.asking.has_ended() => None,
                    Err(_) => return,
                },
            };
            let lost =
                (self.lost != Lost::default()).then(|| message_of("lost", &core::mem::take(&mut self.lost)));
            for message in lost.into_iter().chain(message) {
                if self.out.send(message).await.is_err() {
                    return;
                }
            }
        }
    }

    fn told(&self, event: &Numbered) -> Option<Bytes> {
        let kind = if event.told.is_frame() { self.wanted.frames } else { self.wanted.news };
        let concerns = self.wanted.node.is_none_or(|node| event.told.concerns(node));
        (kind && concerns).then(|| event.message())
    }

    /// The state, if it has changed or was not sent for a while.
    async fn look(&self, sent: &mut Sent) -> Result<Option<Bytes>, Problem> {
        let Some(node) = self.wanted.node else {
            let nodes = self.asking.ask(|bench| Nodes::of(bench)).await?;
            let still = sent.nodes.as_ref().is_some_and(|before| before.is_same(&nodes));
            let message = sent.due(still).then(|| message_of("state", &nodes));
            if message.is_some() {
                sent.nodes = Some(nodes);
            }
            return Ok(message);
        };
        let state = self.asking.ask(move |bench| {
            let (product, device) = bench.device(node)?;
            Ok::<_, Problem>(NodeState::of(product, device, bench.now))
        });
        let state = state.await??;
        let still = sent.node.as_ref().is_some_and(|before| before.is_same(&state));
        let message = sent.due(still).then(|| message_of("state", &state));
        if message.is_some() {
            sent.node = Some(state);
        }
        Ok(message)
    }
}

impl Sent {
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
