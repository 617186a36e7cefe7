//! Any frames, times and events of the device: no frame that is not the node's, no PDO outside OPERATIONAL, at most one
//! answer to an SDO request and none to those of others, no deadline that has passed.
//!
//! An input is a row of steps:
//!
//! ```text
//! 0..=3f  frame: flags (bit 0 extended, bit 1 remote), DLC, identifier (2), data
//! 40..=5f time passes: milliseconds (2)
//! 60..=7f an input of the device changes: value
//! 80..=8f emergency: code (2), register
//! 90..=9f what the device wants: which
//! a0      switched off and on
//! f0      as the first octet: the rest is for the AG03/1, see `ag03_node`
//! ```

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::cob_id::CobId;
use profidrive::can_bus::canopen::{
    Abort, Address, Emergency, NmtState, Node, PdoNumber, Policy, Request, Reset, Value,
};
use profidrive::time::Instant;

use super::canopen_device::Plain;

const NODE: u8 = 5;
const SDO_CLIENT: u32 = 0x600;
const SDO_SERVER: u32 = 0x580;

pub(crate) fn check(data: &[u8]) {
    if let Some((0xF0, rest)) = data.split_first() {
        return super::ag03_node::check(rest);
    }
    let mut rig = Rig { now: Instant::ZERO, device: Plain::new(NODE), node: Node::new(Policy::CIA_301) };
    rig.node.power_on(rig.now, &mut rig.device);
    rig.drain();
    let mut rest = data;
    for _ in 0..1000 {
        let Some(behind) = rig.step(rest) else { return };
        rest = behind;
    }
}

struct Rig {
    now: Instant,
    device: Plain,
    node: Node,
}

impl Rig {
    fn step<'a>(&mut self, steps: &'a [u8]) -> Option<&'a [u8]> {
        let (&kind, rest) = steps.split_first()?;
        match kind {
            0x00..=0x3F => return self.frame(rest),
            0x40..=0x5F => {
                let ([low, high], rest) = rest.split_first_chunk()?;
                let end =
                    self.now.saturating_add(Duration::from_millis(u16::from_le_bytes([*low, *high]).into()));
                self.pass(end);
                return Some(rest);
            }
            0x60..=0x7F => {
                let (value, rest) = rest.split_first()?;
                self.device.set(Address::new(0x6000, 1 + (kind & 1)), Value::U8(*value));
                self.node.handle_change(self.now, &mut self.device);
                self.drain();
                return Some(rest);
            }
            0x80..=0x8F => {
                let ([low, high, register], rest) = rest.split_first_chunk()?;
                let emergency = Emergency::new(u16::from_le_bytes([*low, *high]), *register);
                self.want(Request::Emergency(emergency));
                return Some(rest);
            }
            0x90 => self.want(Request::Nmt(NmtState::Stopped)),
            0x91 => self.want(Request::Nmt(NmtState::PreOperational)),
            0x92 => self.want(Request::Nmt(NmtState::Operational)),
            0x93 => self.want(Request::Tpdo(PdoNumber::P1)),
            0x94 => self.want(Request::AnswerSdo(Ok(()))),
            0x95 => self.want(Request::AnswerSdo(Err(Abort::HARDWARE))),
            0x96 => self.want(Request::Reset(Reset::Communication)),
            0x97 => self.want(Request::Store),
            _ => {
                self.node.power_off();
                assert!(self.node.poll_transmit().is_none() && self.node.poll_timeout().is_none());
                self.node.power_on(self.now, &mut self.device);
                self.drain();
            }
        }
        Some(rest)
    }

    fn want(&mut self, request: Request) {
        self.device.requests.push_back(request);
        self.node.handle_change(self.now, &mut self.device);
        self.drain();
    }

    fn frame<'a>(&mut self, rest: &'a [u8]) -> Option<&'a [u8]> {
        let ([flags, dlc, low, high], rest) = rest.split_first_chunk()?;
        let number = u16::from_le_bytes([*low, *high]);
        let id = if flags & 1 == 1 {
            Id::extended(number.into()).unwrap()
        } else {
            Id::base(number & 0x7FF).unwrap()
        };
        let (frame, rest) = if flags & 2 == 2 {
            (Frame::remote(id, dlc % 16).unwrap(), rest)
        } else {
            let (octets, rest) = rest.split_at_checked(usize::from(dlc % 9))?;
            (Frame::data(id, octets).unwrap(), rest)
        };
        let own = id == Id::base(0x600 + u16::from(NODE)).unwrap();
        let serves = matches!(self.node.state(), Some(NmtState::Operational | NmtState::PreOperational));
        self.node.handle_frame(self.now, &frame, &mut self.device);
        let sent = self.drain();
        let answers = sent.iter().filter(|frame| frame.id().number() == SDO_SERVER + u32::from(NODE)).count();
        let may = own && serves && !frame.is_remote() && frame.dlc() == 8;
        assert!(answers <= usize::from(may), "{frame} got {answers} SDO answers");
        let others = SDO_CLIENT + 1..=SDO_CLIENT + 127;
        if !id.is_extended() && !own && others.contains(&id.number()) {
            assert!(sent.is_empty(), "{frame} is for another node");
        }
        Some(rest)
    }

    fn pass(&mut self, end: Instant) {
        // Heartbeats each millisecond of a minute are the most there can be, but the fuzzer need not wait for them.
        for _ in 0..300 {
            match self.node.poll_timeout() {
                Some(due) if due <= end => {
                    self.now = self.now.max(due);
                    self.node.handle_timeout(self.now, &mut self.device);
                    self.drain();
                    assert!(self.node.poll_timeout().is_none_or(|due| due > self.now), "nothing moves on");
                }
                Some(_) | None => break,
            }
        }
        self.now = self.now.max(end);
        self.node.handle_timeout(self.now, &mut self.device);
        self.drain();
    }

    /// Takes what the node sends, and judges it.
    fn drain(&mut self) -> Vec<Frame> {
        let mut sent = Vec::new();
        while let Some(frame) = self.node.poll_transmit() {
            let node = u32::from(NODE);
            let id = frame.id().number();
            let service = !frame.id().is_extended() && (id == SDO_SERVER + node || id == 0x700 + node);
            let operational = self.node.state() == Some(NmtState::Operational);
            let emcy = frame.dlc() == 8;
            assert!(!frame.is_remote() && id != 0);
            // A node may have gone to another state behind a PDO it still sent: by an error of its own.
            assert!(service || operational || emcy || !sent.is_empty(), "{frame} outside OPERATIONAL");
            assert!(service || !CobId(id).is_restricted() || frame.id().is_extended(), "{frame}");
            sent.push(frame);
        }
        while self.node.poll_event().is_some() {}
        sent
    }
}
