//! One node on a bus of the test's own: frames in, frames out, and a clock that the test sets.

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::{Event, NmtState, Node, Policy};
use profidrive::time::Instant;

use super::Plain;

/// A frame as text, so that a difference is readable: `705#00`.
pub(crate) type Seen = String;

pub(crate) struct Rig {
    pub(crate) now: Instant,
    pub(crate) node: Node,
    pub(crate) device: Plain,
}

impl Rig {
    /// Node 5, switched on, boot-up taken.
    pub(crate) fn new(policy: Policy) -> Self {
        let mut rig = Self::off(policy, Plain::new(5));
        assert_eq!(rig.power_on(), ["705#00"]);
        rig
    }

    pub(crate) fn off(policy: Policy, device: Plain) -> Self {
        Self { now: Instant::from_millis(1), node: Node::new(policy), device }
    }

    pub(crate) fn operational() -> Self {
        let mut rig = Self::new(Policy::CIA_301);
        rig.start();
        rig
    }

    pub(crate) fn start(&mut self) -> Vec<Seen> {
        let seen = self.data(0x000, &[0x01, 0x05]);
        assert_eq!(self.node.state(), Some(NmtState::Operational));
        seen
    }

    pub(crate) fn power_on(&mut self) -> Vec<Seen> {
        self.node.power_on(self.now, &mut self.device);
        self.drain()
    }

    pub(crate) fn frame(&mut self, frame: &Frame) -> Vec<Seen> {
        self.node.handle_frame(self.now, frame, &mut self.device);
        self.drain()
    }

    /// A data frame with an 11-bit identifier.
    pub(crate) fn data(&mut self, id: u16, octets: &[u8]) -> Vec<Seen> {
        self.frame(&Frame::data(Id::base(id).unwrap(), octets).unwrap())
    }

    /// A data frame with a 29-bit identifier.
    pub(crate) fn extended(&mut self, id: u32, octets: &[u8]) -> Vec<Seen> {
        self.frame(&Frame::data(Id::extended(id).unwrap(), octets).unwrap())
    }

    /// A remote request with an 11-bit identifier.
    pub(crate) fn remote(&mut self, id: u16, dlc: u8) -> Vec<Seen> {
        self.frame(&Frame::remote(Id::base(id).unwrap(), dlc).unwrap())
    }

    pub(crate) fn sync(&mut self) -> Vec<Seen> {
        self.data(0x080, &[])
    }

    /// The device went on.
    pub(crate) fn change(&mut self) -> Vec<Seen> {
        self.node.handle_change(self.now, &mut self.device);
        self.drain()
    }

    /// One SDO request and its answer.
    pub(crate) fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        let answers = self.sdo_frames(request);
        let [answer] = answers[..] else { panic!("{request:02X?} got {answers:?}") };
        answer
    }

    /// One SDO request and all frames on 580h + node that it causes.
    pub(crate) fn sdo_frames(&mut self, request: [u8; 8]) -> Vec<[u8; 8]> {
        let node = u16::from(self.node.node_id().number());
        let frame = Frame::with(Id::base(0x600 + node).unwrap(), request);
        self.node.handle_frame(self.now, &frame, &mut self.device);
        let mut answers = Vec::new();
        while let Some(frame) = self.node.poll_transmit() {
            if frame.id().number() == u32::from(0x580 + node) {
                answers.push(frame.octets().try_into().unwrap());
            }
        }
        answers
    }

    /// Reads up to four octets.
    pub(crate) fn read(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        let [a, b] = index.to_le_bytes();
        let [command, _, _, _, data @ ..] = self.sdo([0x40, a, b, sub, 0, 0, 0, 0]);
        let data = u32::from_le_bytes(data);
        if command == 0x80 { Err(data) } else { Ok(data) }
    }

    /// Writes `len` octets of `value`.
    pub(crate) fn write(&mut self, index: u16, sub: u8, value: u32, len: u8) -> Result<(), u32> {
        let [a, b] = index.to_le_bytes();
        let [d, e, f, g] = value.to_le_bytes();
        let answer = self.sdo([0x23 | (4 - len) << 2, a, b, sub, d, e, f, g]);
        let [command, ra, rb, rsub, data @ ..] = answer;
        assert_eq!([ra, rb, rsub], [a, b, sub], "the answer is about another entry");
        let data = u32::from_le_bytes(data);
        match command {
            0x60 => {
                assert_eq!(data, 0);
                Ok(())
            }
            0x80 => Err(data),
            _ => panic!("{answer:02X?}"),
        }
    }

    /// Time passes; every deadline on the way is met. Says when each frame was sent, in microseconds from the call.
    pub(crate) fn pass(&mut self, time: Duration) -> Vec<(u64, Seen)> {
        let begin = self.now;
        let end = begin.saturating_add(time);
        let mut seen = Vec::new();
        for _ in 0..1_000_000 {
            match self.node.poll_timeout() {
                Some(due) if due <= end => {
                    self.now = self.now.max(due);
                    self.node.handle_timeout(self.now, &mut self.device);
                    let at = u64::try_from(self.now.saturating_since(begin).as_micros()).unwrap();
                    seen.extend(self.drain().into_iter().map(|frame| (at, frame)));
                }
                Some(_) | None => {
                    self.now = end;
                    return seen;
                }
            }
        }
        panic!("the node asks for time without end");
    }

    pub(crate) fn drain(&mut self) -> Vec<Seen> {
        let mut seen = Vec::new();
        while let Some(frame) = self.node.poll_transmit() {
            seen.push(frame.to_string());
        }
        seen
    }

    pub(crate) fn events(&mut self) -> Vec<Event> {
        std::iter::from_fn(|| self.node.poll_event()).collect()
    }
}
