//! Who asks, and in which order: one scrape after the other, one line after the other.

use crate::map::Map;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use axum::Router;
use axum::extract::State;
use axum::http::{StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use super::PATH;
use super::families;
use super::line::{Line, Member, Of, OfBus, OfNodes};
use super::series::Labels;
use crate::host::can::Seat;
use crate::panel::problem::Problem;
use crate::panel::queue::Asking;

/// OpenMetrics 1.0, text.
const MEDIA_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// The lines that are asked.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines(Arc<Mutex<Vec<Source>>>);

/// A line that is asked.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) number: usize,
    pub(super) link: String,
    pub(super) asked: Asked,
}

/// The way to the thread of a line.
#[derive(Clone, Debug)]
pub(super) enum Asked {
    Bus(Asking<OfBus>),
    Nodes(Asking<OfNodes>),
}

/// What one scrape has found.
#[derive(Debug)]
pub(super) struct Scrape {
    /// When the metrics began, in seconds of Unix.
    pub(super) started: f64,
    /// By number.
    pub(super) lines: Vec<Found>,
}

/// What was found of a line.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) number: usize,
    pub(super) link: String,
    pub(super) line: Line,
}

impl Lines {
    pub(super) fn add(&self, source: Source) {
        let mut lines = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        lines.push(source);
        lines.sort_by_key(|source| source.number);
    }

    /// Those that are still there.
    fn there(&self) -> Vec<Source> {
        let mut lines = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        lines.retain(|source| !source.asked.has_ended());
        lines.clone()
    }
}

impl Asked {
    fn has_ended(&self) -> bool {
        match self {
            Self::Bus(asking) => asking.has_ended(),
            Self::Nodes(asking) => asking.has_ended(),
        }
    }

    async fn ask(&self) -> Result<Line, Problem> {
        match self {
            Self::Bus(asking) => asking.ask(|bus| Line::of_bus(bus)).await,
            Self::Nodes(asking) => asking.ask(|(bus, nodes)| Line::of_nodes(bus, nodes)).await,
        }
    }
}

impl Scrape {
    pub(super) fn new(started: f64) -> Self {
        Self { started, lines: Vec::new() }
    }

    /// Puts a line behind the others.
    pub(super) fn add(&mut self, number: usize, link: String, mut line: Line, twins: &mut Twins) {
        twins.tell_apart(number, &mut line.members);
        self.lines.push(Found { number, link, line });
    }

    /// Every station and node with what it is known by.
    pub(super) fn members(&self) -> impl Iterator<Item = (Labels, &Member)> {
        let of_line = |found: &Found, member: &Member| {
            let labels = Labels::of_line(found.number).and("address", member.address);
            if member.twin > 0 { labels.and("twin", member.twin) } else { labels }
        };
        self.lines.iter().flat_map(move |found| {
            found.line.members.iter().map(move |member| (of_line(found, member), member))
        })
    }
}

/// Which of the nodes with the same number is which. A node keeps its place among them as long as it keeps its number,
/// whoever comes and goes: its counters stay its own.
#[derive(Debug, Default)]
pub(super) struct Twins(Map<(usize, Seat), (u8, u8)>);

impl Twins {
    fn tell_apart(&mut self, line: usize, members: &mut [Member]) {
        let mut now = Map::new();
        let is_taken = |now: &Map<_, _>, place| now.values().any(|taken| *taken == place);
        let seats: Vec<_> = members.iter().map(|member| (member.seat(), member.address)).collect();
        // First those that were there.
        for (seat, address) in &seats {
            let kept = seat.and_then(|seat| self.0.get(&(line, seat)));
            if let (Some(seat), Some(place)) = (*seat, kept.filter(|place| place.0 == *address)) {
                now.insert((line, seat), *place);
            }
        }
        for (seat, address) in seats {
            if let Some(seat) = seat.filter(|seat| !now.contains_key(&(line, *seat))) {
                let free = (0..=u8::MAX).find(|twin| !is_taken(&now, (address, *twin)));
                now.insert((line, seat), (address, free.unwrap_or(u8::MAX)));
            }
        }
        for member in members {
            if let Some(seat) = member.seat() {
                member.twin = now.get(&(line, seat)).map_or(0, |(_, twin)| *twin);
            }
        }
        self.0.retain(|(of, _), _| *of != line);
        self.0.extend(now);
    }
}

impl Member {
    const fn seat(&self) -> Option<Seat> {
        match self.of {
            Of::Profibus { .. } => None,
            Of::Can { seat, .. } => Some(seat),
        }
    }
}

/// What the handlers share.
#[derive(Clone)]
struct App {
    lines: Lines,
    started: f64,
    /// Locked during a scrape: however many ask, a line is asked by one.
    twins: Arc<tokio::sync::Mutex<Twins>>,
}

pub(super) fn router(lines: Lines) -> Router {
    let started = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64();
    Router::new()
        .route(PATH, get(metrics))
        .fallback(nothing_there)
        .method_not_allowed_fallback(not_so)
        .with_state(App { lines, started, twins: Arc::default() })
}

async fn metrics(State(app): State<App>) -> Result<Response, Problem> {
    let mut twins = app.twins.lock().await;
    let mut scrape = Scrape::new(app.started);
    for Source { number, link, asked } in app.lines.there() {
        let line = asked.ask().await?;
        scrape.add(number, link, line, &mut twins);
    }
    let text = families::text(scrape)
        .map_err(|error| Problem::new(StatusCode::INTERNAL_SERVER_ERROR, format!("no metrics: {error}")))?;
    Ok(([(header::CONTENT_TYPE, MEDIA_TYPE)], text).into_response())
}

async fn nothing_there(uri: Uri) -> Problem {
    Problem::not_found(format!("there is nothing at {}; the metrics are at {PATH}", uri.path()))
}

async fn not_so() -> Problem {
    Problem::new(StatusCode::METHOD_NOT_ALLOWED, format!("{PATH} is only read: GET {PATH}"))
}
