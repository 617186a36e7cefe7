//! Faults on purpose, for people who test masters: a layer between a node and the bus that spoils what the node sends
//! (`canopen-link.md` 15).
//!
//! A node that vanishes and returns is [`Node::power_off`] and [`Node::power_on`]; one that leaves OPERATIONAL by itself
//! is [`Request::Nmt`](super::Request::Nmt).

use core::time::Duration;

use heapless::{Deque, Vec};

use super::abort::Abort;
use super::cob_id;
use super::node::{Node, Service};
use super::pdo::{MAX_PDOS, PdoNumber};
use crate::can::Frame;
use crate::time::Instant;

/// Frames that wait; what is more is lost.
const MAX_WAITING: usize = 32;

/// What is spoiled. [`Faults::NONE`] spoils nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Of the boot-up frame.
    pub boot_up: Option<BootUpFault>,
    /// Of every SDO answer.
    pub sdo: Option<SdoFault>,
    /// Of the heartbeat.
    pub heartbeat: Option<HeartbeatFault>,
    /// Bit 7 of guarding answers stays 0.
    pub guarding_toggle_stuck: bool,
    /// Of every TPDO.
    pub tpdo: Option<TpdoFault>,
    /// EMCY FF00h again and again with this period.
    pub emcy_storm: Option<Duration>,
}

impl Faults {
    /// No fault.
    pub const NONE: Self = Self {
        boot_up: None,
        sdo: None,
        heartbeat: None,
        guarding_toggle_stuck: false,
        tpdo: None,
        emcy_storm: None,
    };
}

/// How boot-up is spoiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootUpFault {
    /// It is not sent.
    Missing,
    /// It is sent twice.
    Twice,
}

/// How SDO answers are spoiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoFault {
    /// Sent so much later.
    Late(Duration),
    /// Not sent.
    Lost,
    /// Sent twice.
    Twice,
    /// The index of another object: bit 0 of it is inverted. Segments, which have none, stay as they are.
    OtherIndex,
    /// The toggle bit of segments is inverted.
    WrongToggle,
    /// An abort in the place of every answer.
    Abort(Abort),
}

/// How heartbeats are spoiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeartbeatFault {
    /// Every second one comes so much later.
    Jitter(Duration),
    /// Not sent.
    Lost,
    /// Always this octet.
    Stuck(u8),
}

/// How TPDOs are spoiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TpdoFault {
    /// The last octet is missing.
    Short,
    /// Always the data of the first one after this was switched on.
    Stale,
}

/// Takes the frames of a node and sends them spoiled.
#[derive(Clone, Debug)]
pub struct Spoiler {
    faults: Faults,
    ready: Deque<Frame, MAX_WAITING>,
    late: Vec<(Instant, Frame), MAX_WAITING>,
    stale: [Option<Frame>; MAX_PDOS],
    heartbeats: u32,
    storm: Option<Instant>,
}

impl Spoiler {
    /// Spoils nothing yet.
    pub const fn new() -> Self {
        Self {
            faults: Faults::NONE,
            ready: Deque::new(),
            late: Vec::new(),
            stale: [None; MAX_PDOS],
            heartbeats: 0,
            storm: None,
        }
    }

    /// From now on these faults. What was delayed still comes.
    pub fn set(&mut self, now: Instant, faults: Faults) {
        self.stale = [None; MAX_PDOS];
        self.storm = faults.emcy_storm.map(|_| now);
        self.faults = faults;
    }

    /// A frame of [`Node::poll_transmit`].
    pub fn handle_frame(&mut self, now: Instant, frame: Frame, node: &Node) {
        match node.service_of(&frame) {
            Some(Service::BootUp) => match self.faults.boot_up {
                None => self.send(frame),
                Some(BootUpFault::Missing) => {}
                Some(BootUpFault::Twice) => self.send_twice(frame),
            },
            Some(Service::SdoAnswer) => self.spoil_sdo(now, frame),
            Some(Service::Heartbeat) => self.spoil_heartbeat(now, frame),
            Some(Service::Guarding) => {
                let octet = frame.octets().first().copied().unwrap_or_default();
                let octet = if self.faults.guarding_toggle_stuck { octet & 0x7F } else { octet };
                self.send(Frame::with(frame.id(), [octet]));
            }
            Some(Service::Tpdo(pdo)) => self.spoil_tpdo(pdo, frame),
            Some(Service::Emcy) | None => self.send(frame),
        }
    }

    /// What was delayed, and the storm.
    pub fn handle_timeout(&mut self, now: Instant, node: &Node) {
        while let Some(place) = self.late.iter().position(|(due, _)| *due <= now) {
            let (_, frame) = self.late.remove(place);
            self.send(frame);
        }
        if let (Some(due), Some(period)) = (self.storm, self.faults.emcy_storm)
            && due <= now
        {
            self.storm = Some(now.saturating_add(period.max(Duration::from_micros(1))));
            if node.state().is_some() {
                let id = cob_id::of_node(cob_id::EMCY, node.node_id());
                self.send(Frame::with(id, [0x00, 0xFF, 0x81, 0, 0, 0, 0, 0]));
            }
        }
    }

    /// The next frame for the bus.
    pub fn poll_transmit(&mut self) -> Option<Frame> {
        self.ready.pop_front()
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called.
    pub fn poll_timeout(&self) -> Option<Instant> {
        let late = self.late.iter().map(|(due, _)| *due).min();
        Instant::first_of(late, self.storm)
    }

    fn spoil_sdo(&mut self, now: Instant, frame: Frame) {
        let Ok([command, a, b, c, d, e, f, g]) = <[u8; 8]>::try_from(frame.octets()) else { return };
        let id = frame.id();
        // Answers to segments: 0 and 1 in bits 7..5.
        let is_segment = command < 0x40;
        match self.faults.sdo {
            None => self.send(frame),
            Some(SdoFault::Late(delay)) => self.send_later(now, delay, frame),
            Some(SdoFault::Lost) => {}
            Some(SdoFault::Twice) => self.send_twice(frame),
            Some(SdoFault::OtherIndex) if is_segment => self.send(frame),
            Some(SdoFault::OtherIndex) => self.send(Frame::with(id, [command, a ^ 1, b, c, d, e, f, g])),
            Some(SdoFault::WrongToggle) if is_segment => {
                self.send(Frame::with(id, [command ^ 0x10, a, b, c, d, e, f, g]));
            }
            Some(SdoFault::WrongToggle) => self.send(frame),
            Some(SdoFault::Abort(code)) => {
                let [d, e, f, g] = code.code().to_le_bytes();
                let [a, b, c] = if is_segment { [0; 3] } else { [a, b, c] };
                self.send(Frame::with(id, [0x80, a, b, c, d, e, f, g]));
            }
        }
    }

    fn spoil_heartbeat(&mut self, now: Instant, frame: Frame) {
        self.heartbeats = self.heartbeats.wrapping_add(1);
        match self.faults.heartbeat {
            None => self.send(frame),
            Some(HeartbeatFault::Jitter(delay)) if self.heartbeats.is_multiple_of(2) => {
                self.send_later(now, delay, frame);
            }
            Some(HeartbeatFault::Jitter(_)) => self.send(frame),
            Some(HeartbeatFault::Lost) => {}
            Some(HeartbeatFault::Stuck(octet)) => self.send(Frame::with(frame.id(), [octet])),
        }
    }

    fn spoil_tpdo(&mut self, pdo: PdoNumber, frame: Frame) {
        match self.faults.tpdo {
            None => self.send(frame),
            Some(TpdoFault::Short) => {
                let octets = frame.octets().split_last().map_or(&[][..], |(_, front)| front);
                if let Ok(frame) = Frame::data(frame.id(), octets) {
                    self.send(frame);
                }
            }
            Some(TpdoFault::Stale) => {
                let first = self.stale.get_mut(pdo.place()).map(|first| *first.get_or_insert(frame));
                self.send(first.unwrap_or(frame));
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

impl Default for Spoiler {
    fn default() -> Self {
        Self::new()
    }
}
