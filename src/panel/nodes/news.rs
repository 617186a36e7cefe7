//! What happens on the bus, from its thread to the readers of the stream.
//!
//! The thread of the bus puts copies into a ring that the readers share; who is slow loses what is oldest, and is told how
//! much. Words and JSON are made by the readers.

use core::sync::atomic::{AtomicUsize, Ordering};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use axum::body::Bytes;
use serde::Serialize;
use tokio::sync::broadcast;
use utoipa::ToSchema;

use super::super::history::Newest;
use super::super::state::seconds;
use super::super::stream::message_of;
use super::access::NodeAccess;
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen;
use crate::can_bus::canopen::NodeId;
use crate::devices::CanopenEvent;
use crate::face::EventKind;
use crate::host::can::{BusHint, Event, Seat, StoredNode};
use crate::time::Instant;

/// Events a reader may be behind at most.
const BEHIND: usize = 1024;

/// What happened, in words.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(in crate::panel) struct NodeNews {
    /// Counts up since the panel was started.
    number: u64,
    time_seconds: f64,
    /// The node it is about; `null`: the bus.
    address: Option<u8>,
    kind: EventKind,
    /// One line.
    text: String,
}

/// A frame on the bus.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(in crate::panel) struct FrameEvent {
    time_seconds: f64,
    /// The identifier, hexadecimal: three digits, or eight with 29 bits.
    id: String,
    remote: bool,
    /// Octets apart.
    octets_hex: String,
    /// Of a node of this bus, and not of a master.
    of_node: bool,
}

/// What the thread of the bus tells.
#[derive(Clone, Copy, Debug)]
pub(super) enum Told {
    Node { at: Instant, node: Option<NodeId>, event: CanopenEvent },
    State { at: Instant, node: Option<NodeId>, state: ErrorState },
    Frame { at: Instant, of_node: bool, frame: Frame },
    Hint { at: Instant, hint: BusHint },
    Lost { at: Instant, events: u64 },
}

/// What the thread of the bus told, and as which event of all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbered {
    /// `None`: a frame.
    number: Option<u64>,
    pub(super) told: Told,
}

/// The ring, who has which seat, and the newest events.
#[derive(Debug)]
pub(super) struct Feed {
    news: broadcast::Sender<Numbered>,
    started: SystemTime,
    newest: Mutex<Newest<Numbered>>,
    frames: AtomicUsize,
    numbers: Mutex<BTreeMap<Seat, NodeId>>,
}

impl Default for Feed {
    fn default() -> Self {
        let (news, _) = broadcast::channel(BEHIND);
        Self {
            news,
            started: SystemTime::now(),
            newest: Mutex::default(),
            frames: AtomicUsize::new(0),
            numbers: Mutex::default(),
        }
    }
}

impl Feed {
    /// Learns which number is at which seat.
    pub(super) fn know(&self, bench: &NodeAccess<'_>) {
        let mut numbers = self.numbers.lock().unwrap_or_else(PoisonError::into_inner);
        for seated in bench.nodes.iter() {
            if let Some(stored) = bench.bus.participant::<StoredNode>(seated.seat) {
                numbers.insert(seated.seat, stored.node_id());
            }
        }
    }

    pub(super) fn wants_frames(&self) -> bool {
        self.frames.load(Ordering::Relaxed) > 0
    }

    pub(super) fn tell(&self, now: Instant, event: &Event<CanopenEvent>) {
        let number = |seat: &Seat| {
            let mut numbers = self.numbers.lock().unwrap_or_else(PoisonError::into_inner);
            if let Event::Participant {
                event: CanopenEvent::Node(canopen::Event::BootUp { node, .. }), ..
            } = event
            {
                numbers.insert(*seat, *node);
            }
            numbers.get(seat).copied()
        };
        let told = match event {
            Event::Participant { seat, event } => Told::Node { at: now, node: number(seat), event: *event },
            Event::State { at, seat, state } => Told::State { at: *at, node: number(seat), state: *state },
            Event::Passed { at, by_port, frame, .. } if self.wants_frames() => {
                Told::Frame { at: *at, of_node: !*by_port, frame: *frame }
            }
            // Nobody reads frames.
            Event::Passed { .. } => return,
            // The bus counts them; the frame comes again.
            Event::Damaged { .. } => return,
            Event::Lost { events } => Told::Lost { at: now, events: *events },
        };
        self.send(told);
    }

    pub(super) fn hint(&self, at: Instant, hint: BusHint) {
        self.send(Told::Hint { at, hint });
    }

    fn send(&self, told: Told) {
        // Whether somebody hears it is not our concern.
        let event = if told.is_frame() {
            Numbered { number: None, told }
        } else {
            self.newest().keep(|number| Numbered { number: Some(number), told })
        };
        let _ = self.news.send(event);
    }

    /// The events that are kept, oldest first; `wanted`: only those about this node or the bus.
    pub(super) fn recent(&self, wanted: Option<NodeId>) -> Vec<NodeNews> {
        let events: Vec<Numbered> = self.newest().iter().copied().collect();
        let concerned = events.iter().filter(|event| wanted.is_none_or(|node| event.told.concerns(node)));
        concerned.filter_map(Numbered::news).collect()
    }

    /// When the panel was started.
    pub(super) const fn started(&self) -> SystemTime {
        self.started
    }

    fn newest(&self) -> MutexGuard<'_, Newest<Numbered>> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn subscribe(&self) -> broadcast::Receiver<Numbered> {
        self.news.subscribe()
    }

    pub(super) fn readers(&self) -> usize {
        self.news.receiver_count()
    }

    /// Somebody reads frames as long as what this returns lives.
    pub(super) fn watch_frames(self: Arc<Self>) -> FrameReader {
        self.frames.fetch_add(1, Ordering::Relaxed);
        FrameReader(self)
    }
}

/// Somebody who reads frames.
pub(super) struct FrameReader(Arc<Feed>);

impl Drop for FrameReader {
    fn drop(&mut self) {
        self.0.frames.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Told {
    /// Whether it is a frame.
    pub(super) const fn is_frame(&self) -> bool {
        matches!(self, Self::Frame { .. })
    }

    /// Whether it is about this node, or about the bus.
    pub(super) fn concerns(&self, wanted: NodeId) -> bool {
        match self {
            Self::Node { node, .. } | Self::State { node, .. } => node.is_none_or(|node| node == wanted),
            Self::Frame { .. } | Self::Hint { .. } | Self::Lost { .. } => true,
        }
    }
}

impl Numbered {
    /// As an event of the stream.
    pub(super) fn message(&self) -> Bytes {
        match (&self.told, self.news()) {
            (Told::Frame { at, of_node, frame }, _) => FrameEvent::message(*at, *of_node, frame),
            (_, news) => message_of("news", &news),
        }
    }

    /// In words; `None`: a frame.
    fn news(&self) -> Option<NodeNews> {
        let number = self.number?;
        let (at, node, kind, text) = match &self.told {
            Told::Frame { .. } => return None,
            Told::Node { at, node, event } => (*at, *node, event.kind(), event.to_string()),
            Told::State { at, node, state } => (*at, *node, EventKind::Line, state.to_string()),
            Told::Hint { at, hint } => (*at, None, EventKind::Line, hint.to_string()),
            Told::Lost { at, events } => (
                *at,
                None,
                EventKind::Line,
                format!("{events} events were too many for the log and are lost"),
            ),
        };
        let address = node.map(NodeId::number);
        Some(NodeNews { number, time_seconds: seconds(at), address, kind, text })
    }
}

impl FrameEvent {
    fn message(at: Instant, of_node: bool, frame: &Frame) -> Bytes {
        let id = frame.id();
        let digits = match id {
            crate::can_bus::can::Id::Base(_) => 3,
            crate::can_bus::can::Id::Extended(_) => 8,
        };
        let event = Self {
            time_seconds: seconds(at),
            id: format!("{:0digits$X}", id.number()),
            remote: frame.is_remote(),
            octets_hex: crate::explain::hex(frame.octets()),
            of_node,
        };
        message_of("frame", &event)
    }
}
