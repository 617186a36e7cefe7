//! A correct node with one mistake: what it hears and says passes a hook.

use std::collections::VecDeque;
use std::time::Duration;

use profidrive::can_bus::can::{ErrorState, Frame, Id};
use profidrive::devices::CanopenEvent;
use profidrive::host::can::{CanParticipant, StoredNode};
use profidrive::time::Instant;

use super::NODE;

/// What becomes of a frame: those that the node hears, or those that it sends.
pub(crate) type Hook = Box<dyn FnMut(&mut Mind, Frame) -> Vec<Frame> + Send>;

/// What a mistake may need to know.
#[derive(Default)]
pub(crate) struct Mind {
    pub(crate) now: Instant,
    /// The state, as NMT commands say: 7Fh, 05h, 04h.
    pub(crate) state: u8,
    /// The last SDO request.
    pub(crate) sdo: [u8; 8],
    /// When it answered an SDO last.
    pub(crate) said_at: Instant,
    /// Frames to send besides.
    pub(crate) inject: Vec<Frame>,
    /// How long what it says is held back.
    pub(crate) delay: Duration,
    pub(crate) count: u32,
    pub(crate) flag: bool,
    pub(crate) reset: u8,
    /// The mode of operation that was written last.
    pub(crate) mode: u8,
    /// The drive was enabled: before that its objects are judged as such.
    pub(crate) was_enabled: bool,
    /// A set-point in an RPDO, and that of the last SYNC.
    pub(crate) set_point: [i32; 2],
}

impl Mind {
    /// Index and sub-index of the last SDO request.
    pub(crate) fn at(&self) -> (u16, u8) {
        let [_, a, b, sub, ..] = self.sdo;
        (u16::from_le_bytes([a, b]), sub)
    }

    /// The last SDO request is a write to this entry.
    pub(crate) fn writes(&self, index: u16, sub: u8) -> bool {
        self.at() == (index, sub) && self.sdo[0] >> 5 == 1
    }

    /// The last SDO request is a read of this entry.
    pub(crate) fn reads(&self, index: u16, sub: u8) -> bool {
        self.at() == (index, sub) && self.sdo[0] == 0x40
    }

    /// Says that the last write is done.
    pub(crate) fn done(&mut self) {
        let [_, a, b, c, ..] = self.sdo;
        self.inject.push(answer([0x60, a, b, c, 0, 0, 0, 0]));
    }

    /// Refuses the last request.
    pub(crate) fn abort(&mut self, code: u32) {
        let ([_, a, b, c, ..], [d, e, f, g]) = (self.sdo, code.to_le_bytes());
        self.inject.push(answer([0x80, a, b, c, d, e, f, g]));
    }

    fn follow(&mut self, frame: &Frame) {
        match (frame.id().number(), frame.octets()) {
            (0, [command, number]) if [0, NODE].contains(number) && !frame.id().is_extended() => {
                match command {
                    1 => self.state = 0x05,
                    2 => self.state = 0x04,
                    0x80 => self.state = 0x7F,
                    0x81 | 0x82 => {
                        self.state = 0x7F;
                        self.reset = *command;
                    }
                    _ => {}
                }
            }
            (0x605, octets) if octets.len() == 8 && !frame.id().is_extended() => {
                self.sdo.copy_from_slice(octets);
                self.was_enabled |= self.writes(0x6040, 0) && self.sdo[..6] == [0x2B, 0x40, 0x60, 0, 0x0F, 0];
                if self.writes(0x6060, 0) {
                    self.mode = self.sdo[4];
                }
            }
            _ => {}
        }
    }
}

pub(crate) fn base(id: u16) -> Id {
    Id::base(id).unwrap()
}

pub(crate) fn data(id: u16, octets: &[u8]) -> Frame {
    Frame::data(base(id), octets).unwrap()
}

/// An answer of the SDO server.
pub(crate) fn answer(octets: [u8; 8]) -> Frame {
    data(0x580 + u16::from(NODE), &octets)
}

/// The octets of an answer of the SDO server.
pub(crate) fn answered(frame: &Frame) -> Option<[u8; 8]> {
    let own = frame.id() == base(0x580 + u16::from(NODE)) && !frame.is_remote();
    own.then(|| frame.octets().try_into().ok()).flatten()
}

/// A write of up to four octets that the node is to take.
pub(crate) fn write(index: u16, sub: u8, octets: &[u8]) -> Frame {
    let ([a, b], mut all) = (index.to_le_bytes(), [0; 8]);
    let unused = 4 - octets.len() as u8;
    all[..4].copy_from_slice(&[0x23 | unused << 2, a, b, sub]);
    all[4..4 + octets.len()].copy_from_slice(octets);
    data(0x605, &all)
}

pub(crate) struct Wrong {
    node: StoredNode,
    mind: Mind,
    hear: Hook,
    say: Hook,
    /// How often it wakes by itself: `say` is asked with an empty frame of identifier 7FFh.
    every: Option<Duration>,
    next: Instant,
    out: VecDeque<(Instant, Frame)>,
}

impl Wrong {
    pub(crate) fn new(node: StoredNode, hear: Hook, say: Hook, every: Option<Duration>) -> Self {
        let mind = Mind { state: 0x7F, ..Mind::default() };
        Self { node, mind, hear, say, every, next: Instant::ZERO, out: VecDeque::new() }
    }

    pub(crate) fn node(&mut self) -> &mut StoredNode {
        self.mind.state = 0x7F;
        self.mind.reset = 0;
        &mut self.node
    }

    fn say(&mut self, now: Instant, frame: Frame) {
        self.mind.now = now;
        let said = (self.say)(&mut self.mind, frame);
        let due = now.saturating_add(self.mind.delay);
        self.out.extend(said.into_iter().map(|frame| (due, frame)));
        self.out.extend(self.mind.inject.drain(..).map(|frame| (now, frame)));
    }

    fn collect(&mut self, now: Instant) {
        while let Some(frame) = self.node.poll_transmit(now) {
            self.say(now, frame);
        }
    }
}

impl CanParticipant for Wrong {
    type Event = CanopenEvent;

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        self.mind.now = now;
        let state = self.mind.state;
        self.mind.follow(frame);
        let after = core::mem::replace(&mut self.mind.state, state);
        let heard = (self.hear)(&mut self.mind, *frame);
        self.mind.state = after;
        self.out.extend(self.mind.inject.drain(..).map(|frame| (now, frame)));
        for frame in heard {
            self.node.handle_frame(now, &frame);
        }
        self.collect(now);
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.node.handle_timeout(now);
        self.collect(now);
        if let Some(every) = self.every.filter(|_| self.next <= now) {
            self.next = now.saturating_add(every);
            self.say(now, data(0x7FF, &[]));
        }
    }

    fn set_error_state(&mut self, now: Instant, state: ErrorState) {
        self.node.set_error_state(now, state);
    }

    fn poll_transmit(&mut self, now: Instant) -> Option<Frame> {
        self.collect(now);
        let place = self.out.iter().position(|(due, _)| *due <= now)?;
        let frame = self.out.remove(place).map(|(_, frame)| frame)?;
        if answered(&frame).is_some() {
            self.mind.said_at = now;
        }
        Some(frame)
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        self.node.poll_event()
    }

    fn poll_timeout(&self) -> Option<Instant> {
        let held = self.out.iter().map(|(due, _)| *due).min();
        let own = self.every.map(|_| self.next);
        [self.node.poll_timeout(), held, own].into_iter().flatten().min()
    }
}
