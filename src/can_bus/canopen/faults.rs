//! Faults on purpose, for people who test masters: a layer between a node and the bus that changes what the node sends
//! (`canopen-link.md` 15).
//!
//! ```text
//! Node ──frame──▶ the first fault that is for it and injected now ──▶ changed ──▶ bus
//! ```
//!
//! A node that vanishes and returns, and one that leaves OPERATIONAL by itself, is asked for as an [`Action`], which the
//! host carries out.

use core::time::Duration;

use heapless::{Deque, Vec};
use thiserror::Error;

use super::abort::Abort;
use super::cob_id;
use super::node::{Node, Service};
use super::pdo::MAX_PDOS;
use crate::can_bus::can::Frame;
use crate::chance::Chance;
pub use crate::chance::When;
use crate::time::Instant;

/// Frames that wait; what is more is lost.
const MAX_WAITING: usize = 32;

/// Faults of one node at most.
pub const MAX_FAULTS: usize = 32;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// What happens to a boot-up frame.
    BootUp(BootUpFault),
    /// What happens to an SDO answer.
    Sdo(SdoFault),
    /// What happens to a heartbeat.
    Heartbeat(HeartbeatFault),
    /// Bit 7 of a guarding answer is 0.
    GuardingToggleStuck,
    /// What happens to a TPDO.
    Tpdo(TpdoFault),
    /// EMCY FF00h once in this period; each period is an occasion.
    EmcyEach(Duration),
    /// The node goes to PRE-OPERATIONAL by itself, behind a TPDO.
    LeaveOperational,
    /// The supply fails for so long. Each frame of the node is an occasion; it is not sent.
    BrownOut(Duration),
}

/// What happens to a boot-up frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootUpFault {
    /// It is not sent.
    Missing,
    /// It is sent twice.
    Twice,
}

/// What happens to an SDO answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoFault {
    /// Sent so much later.
    Late(Duration),
    /// Not sent.
    Lost,
    /// Sent twice.
    Twice,
    /// The index of another object: bit 0 of it is inverted. Segments, which have none, are no occasion.
    OtherIndex,
    /// The toggle bit is inverted. Only segments are an occasion.
    WrongToggle,
    /// An abort in the place of the answer.
    Abort(Abort),
}

/// What happens to a heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeartbeatFault {
    /// It comes so much later. Every second heartbeat is an occasion.
    Jitter(Duration),
    /// Not sent.
    Lost,
    /// This octet in the place of the state.
    Stuck(u8),
}

/// What happens to a TPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TpdoFault {
    /// The last octet is missing.
    Short,
    /// The data of the first TPDO with this fault, for ever.
    Stale,
    /// It is sent behind the next TPDO of the node.
    Swapped,
}

/// What the host is to do to the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// To take it to PRE-OPERATIONAL.
    LeaveOperational,
    /// To switch it off.
    Off,
    /// To switch it on again.
    On,
}

/// The node has [`MAX_FAULTS`] already.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a node has {MAX_FAULTS} faults at most; remove some")]
pub struct TooMany;

/// Takes the frames of a node and sends them with the faults that are injected.
///
/// After each call drain [`poll_transmit`](Self::poll_transmit) and [`poll_action`](Self::poll_action).
#[derive(Clone, Debug)]
pub struct FaultInjector {
    rules: Vec<Rule, MAX_FAULTS>,
    ready: Deque<Frame, MAX_WAITING>,
    late: Vec<(Instant, Frame), MAX_WAITING>,
    /// The TPDO that goes behind the next one.
    held: Option<Frame>,
    heartbeats: u32,
    leaves: bool,
    supply: Supply,
}

/// A fault, and what it has done so far.
#[derive(Clone, Debug)]
struct Rule {
    number: u32,
    kind: Kind,
    chance: Chance,
    /// The first data of each TPDO that had this fault.
    stale: Vec<Frame, MAX_PDOS>,
    /// When the next EMCY of [`Kind::EmcyEach`] is due.
    next_emcy: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Supply {
    Good,
    /// It is to fail for so long.
    Failing(Duration),
    /// It failed and returns then.
    Failed(Instant),
}

impl FaultInjector {
    /// Without faults.
    pub const fn new() -> Self {
        Self {
            rules: Vec::new(),
            ready: Deque::new(),
            late: Vec::new(),
            held: None,
            heartbeats: 0,
            leaves: false,
            supply: Supply::Good,
        }
    }

    /// Adds a fault behind the others, under a number of the caller's.
    ///
    /// # Errors
    /// [`TooMany`].
    pub fn add(&mut self, now: Instant, number: u32, kind: Kind, when: When) -> Result<(), TooMany> {
        let next_emcy = matches!(kind, Kind::EmcyEach(_)).then_some(now.saturating_add(when.from));
        let rule = Rule { number, kind, chance: Chance::new(when, now), stale: Vec::new(), next_emcy };
        self.rules.push(rule).map_err(|_| TooMany)
    }

    /// Ends the fault of that number. What was delayed still comes.
    pub fn remove(&mut self, number: u32) {
        self.rules.retain(|rule| rule.number != number);
    }

    /// How often the fault of that number was injected; 0 if there is none.
    pub fn injected(&self, number: u32) -> u32 {
        self.rules.iter().find(|rule| rule.number == number).map_or(0, |rule| rule.chance.injected())
    }

    /// A frame of [`Node::poll_transmit`].
    pub fn handle_frame(&mut self, now: Instant, frame: Frame, node: &Node) {
        let service = node.service_of(&frame);
        if let Some(Service::Heartbeat) = service {
            self.heartbeats = self.heartbeats.wrapping_add(1);
        }
        let even = self.heartbeats.is_multiple_of(2);
        let found = self.rules.iter_mut().find_map(|rule| {
            let injected = rule.kind.concerns(service, &frame, even) && rule.strikes(now);
            injected.then_some((rule.kind, &mut rule.stale))
        });
        match found {
            None => self.pass(service, frame),
            Some((Kind::BootUp(BootUpFault::Missing), _)) => {}
            Some((Kind::BootUp(BootUpFault::Twice), _)) => self.send_twice(frame),
            Some((Kind::Sdo(fault), _)) => self.change_sdo(now, fault, frame),
            Some((Kind::Heartbeat(HeartbeatFault::Jitter(delay)), _)) => self.send_later(now, delay, frame),
            Some((Kind::Heartbeat(HeartbeatFault::Lost), _)) => {}
            Some((Kind::Heartbeat(HeartbeatFault::Stuck(octet)), _)) => {
                self.send(Frame::with(frame.id(), [octet]));
            }
            Some((Kind::GuardingToggleStuck, _)) => {
                let octet = frame.octets().first().copied().unwrap_or_default();
                self.send(Frame::with(frame.id(), [octet & 0x7F]));
            }
            Some((Kind::Tpdo(TpdoFault::Short), _)) => {
                let octets = frame.octets().split_last().map_or(&[][..], |(_, front)| front);
                if let Ok(short) = Frame::data(frame.id(), octets) {
                    self.pass(service, short);
                }
            }
            Some((Kind::Tpdo(TpdoFault::Stale), stale)) => {
                let first =
                    stale.iter().find(|first| first.id() == frame.id()).copied().unwrap_or_else(|| {
                        let _ = stale.push(frame);
                        frame
                    });
                self.pass(service, first);
            }
            Some((Kind::Tpdo(TpdoFault::Swapped), _)) => match self.held {
                None => self.held = Some(frame),
                Some(_) => self.pass(service, frame),
            },
            Some((Kind::LeaveOperational, _)) => {
                self.pass(service, frame);
                self.leaves = true;
            }
            Some((Kind::BrownOut(time), _)) => self.supply = Supply::Failing(time),
            // Concerns no frame.
            Some((Kind::EmcyEach(_), _)) => self.pass(service, frame),
        }
    }

    /// What was delayed, EMCYs that are due, and the supply that returns.
    pub fn handle_timeout(&mut self, now: Instant, node: &Node) {
        while let Some(place) = self.late.iter().position(|(due, _)| *due <= now) {
            let (_, frame) = self.late.remove(place);
            self.send(frame);
        }
        let Self { rules, ready, .. } = self;
        for rule in rules {
            let Kind::EmcyEach(period) = rule.kind else { continue };
            if rule.next_emcy.is_none_or(|due| due > now) {
                continue;
            }
            rule.next_emcy = Some(now.saturating_add(period.max(Duration::from_micros(1))));
            if node.state().is_some() && rule.strikes(now) {
                let id = cob_id::of_node(cob_id::EMCY, node.node_id());
                let _ = ready.push_back(Frame::with(id, [0x00, 0xFF, 0x81, 0, 0, 0, 0, 0]));
            }
        }
    }

    /// The next frame for the bus.
    pub fn poll_transmit(&mut self) -> Option<Frame> {
        self.ready.pop_front()
    }

    /// What the host is to do now.
    #[must_use = "it is not asked for again"]
    pub fn poll_action(&mut self, now: Instant) -> Option<Action> {
        match self.supply {
            Supply::Good => {}
            Supply::Failing(time) => {
                self.supply = Supply::Failed(now.saturating_add(time));
                self.ready.clear();
                self.late.clear();
                (self.held, self.leaves) = (None, false);
                return Some(Action::Off);
            }
            Supply::Failed(returns) if returns <= now => {
                self.supply = Supply::Good;
                return Some(Action::On);
            }
            Supply::Failed(_) => return None,
        }
        core::mem::take(&mut self.leaves).then_some(Action::LeaveOperational)
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called.
    pub fn poll_timeout(&self) -> Option<Instant> {
        let late = self.late.iter().map(|(due, _)| *due).min();
        let next_emcy = self.rules.iter().filter_map(|rule| rule.next_emcy).min();
        let supply = match self.supply {
            Supply::Good | Supply::Failing(_) => None,
            Supply::Failed(returns) => Some(returns),
        };
        Instant::first_of(Instant::first_of(late, next_emcy), supply)
    }

    /// A frame goes out; a TPDO that waited for it goes behind it.
    fn pass(&mut self, service: Option<Service>, frame: Frame) {
        self.send(frame);
        if let Some(Service::Tpdo(_)) = service
            && let Some(held) = self.held.take()
        {
            self.send(held);
        }
    }

    fn change_sdo(&mut self, now: Instant, fault: SdoFault, frame: Frame) {
        let Ok([command, a, b, c, d, e, f, g]) = <[u8; 8]>::try_from(frame.octets()) else { return };
        let id = frame.id();
        match fault {
            SdoFault::Late(delay) => self.send_later(now, delay, frame),
            SdoFault::Lost => {}
            SdoFault::Twice => self.send_twice(frame),
            SdoFault::OtherIndex => self.send(Frame::with(id, [command, a ^ 1, b, c, d, e, f, g])),
            SdoFault::WrongToggle => self.send(Frame::with(id, [command ^ 0x10, a, b, c, d, e, f, g])),
            SdoFault::Abort(code) => {
                let [d, e, f, g] = code.code().to_le_bytes();
                let [a, b, c] = if is_segment(&frame) { [0; 3] } else { [a, b, c] };
                self.send(Frame::with(id, [0x80, a, b, c, d, e, f, g]));
            }
        }
    }

    fn send(&mut self, frame: Frame) {
        let _ = self.ready.push_back(frame);
    }

    fn send_twice(&mut self, frame: Frame) {
        self.send(frame);
        self.send(frame);
    }

    fn send_later(&mut self, now: Instant, delay: Duration, frame: Frame) {
        let _ = self.late.push((now.saturating_add(delay), frame));
    }
}

impl Default for FaultInjector {
    fn default() -> Self {
        Self::new()
    }
}

impl Rule {
    /// Counts an occasion while its times allow it, and says whether the fault is injected now.
    fn strikes(&mut self, now: Instant) -> bool {
        self.chance.is_open(now) && self.chance.strikes()
    }
}

impl Kind {
    /// Whether a frame is an occasion. `even`: it would be every second heartbeat.
    fn concerns(self, service: Option<Service>, frame: &Frame, even: bool) -> bool {
        match self {
            Self::BootUp(_) => service == Some(Service::BootUp),
            Self::Sdo(fault) => {
                service == Some(Service::SdoAnswer)
                    && match fault {
                        SdoFault::OtherIndex => !is_segment(frame),
                        SdoFault::WrongToggle => is_segment(frame),
                        SdoFault::Late(_) | SdoFault::Lost | SdoFault::Twice | SdoFault::Abort(_) => true,
                    }
            }
            Self::Heartbeat(HeartbeatFault::Jitter(_)) => service == Some(Service::Heartbeat) && even,
            Self::Heartbeat(HeartbeatFault::Lost | HeartbeatFault::Stuck(_)) => {
                service == Some(Service::Heartbeat)
            }
            Self::GuardingToggleStuck => service == Some(Service::Guarding),
            Self::Tpdo(_) | Self::LeaveOperational => matches!(service, Some(Service::Tpdo(_))),
            Self::EmcyEach(_) => false,
            Self::BrownOut(_) => true,
        }
    }
}

/// Whether an SDO answer is one to a segment: 0 or 1 in bits 7 to 5.
fn is_segment(frame: &Frame) -> bool {
    frame.octets().first().is_some_and(|command| *command < 0x40)
}
