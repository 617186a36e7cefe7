//! The client's side of SDO, without I/O: one read or write at a time, expedited or in segments.
//!
//! After every call that gives a [`Step`], send its frame if there is one. Answers that are not about what was asked,
//! late ones for example, are ignored.

use core::time::Duration;

use super::MAX_VALUE_LEN;
use super::{FRAME_LEN, Response, addressed};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::abort::Abort;
use crate::can_bus::canopen::address::{Address, NodeId};
use crate::can_bus::canopen::cob_id;
use crate::time::Instant;

/// Reads and writes entries of one node.
#[derive(Clone, Debug)]
pub struct SdoClient {
    node: NodeId,
    time_limit: Duration,
    transfer: Transfer,
    deadline: Instant,
    octets: [u8; MAX_VALUE_LEN],
    len: usize,
}

/// What the client waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Transfer {
    /// Nothing.
    Idle,
    /// The answer to an initiate upload.
    Upload { at: Address },
    /// The next segment of a read; `announced` octets in all.
    UploadSegment { at: Address, announced: u32, toggle: bool },
    /// The answer to an expedited write.
    Expedited { at: Address },
    /// The answer to an initiate download.
    Download { at: Address },
    /// The answer to a segment of a write: octets up to `sent` are gone.
    DownloadSegment { at: Address, sent: usize, toggle: bool },
}

/// What follows from a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<'a> {
    /// Nothing: it waits.
    Wait,
    /// Send this; it goes on.
    Send(Frame),
    /// The value was read.
    Read(&'a [u8]),
    /// The value was written.
    Written,
    /// The server refused.
    Refused(Abort),
    /// The transfer failed at this end; the frame tells the server.
    Failed {
        /// Why.
        code: Abort,
        /// An abort.
        tell: Frame,
    },
}

impl SdoClient {
    /// A client of `node` that waits so long for each answer.
    pub const fn new(node: NodeId, time_limit: Duration) -> Self {
        Self {
            node,
            time_limit,
            transfer: Transfer::Idle,
            deadline: Instant::ZERO,
            octets: [0; MAX_VALUE_LEN],
            len: 0,
        }
    }

    /// Whether nothing is under way.
    pub fn is_idle(&self) -> bool {
        self.transfer == Transfer::Idle
    }

    /// Begins to read. What was under way is forgotten: a server ends it with the new request.
    pub fn read(&mut self, now: Instant, at: Address) -> Frame {
        self.len = 0;
        self.wait_for(now, Transfer::Upload { at });
        self.request(addressed(0x40, at, [0; 4]))
    }

    /// Begins to write; `None` for no octets or more than 256. What was under way is forgotten.
    pub fn write(&mut self, now: Instant, at: Address, octets: &[u8]) -> Option<Frame> {
        if octets.is_empty() {
            return None;
        }
        self.octets.get_mut(..octets.len())?.copy_from_slice(octets);
        self.len = octets.len();
        let announced = u32::try_from(octets.len()).ok()?;
        let mut data = [0; 4];
        let Some(front) = data.get_mut(..octets.len()) else {
            self.wait_for(now, Transfer::Download { at });
            return Some(self.request(addressed(0x21, at, announced.to_le_bytes())));
        };
        front.copy_from_slice(octets);
        let unused = 4_u8.saturating_sub(u8::try_from(octets.len()).unwrap_or(4));
        self.wait_for(now, Transfer::Expedited { at });
        Some(self.request(addressed(0x23 | unused << 2, at, data)))
    }

    /// A frame was received.
    pub fn handle_frame(&mut self, now: Instant, frame: &Frame) -> Step<'_> {
        let own = frame.id() == cob_id::of_node(cob_id::SDO_SERVER, self.node) && !frame.is_remote();
        let octets = <[u8; FRAME_LEN]>::try_from(frame.octets()).ok().filter(|_| own);
        let Some(response) = octets.and_then(Response::decode) else { return Step::Wait };
        if let (Some(at), Response::Abort { at: about, code }) = (self.at(), response) {
            // A server that met a segment of nothing has no address to repeat.
            if about == at || about == Address::new(0, 0) {
                self.transfer = Transfer::Idle;
                return Step::Refused(code);
            }
            return Step::Wait;
        }
        match self.transfer {
            Transfer::Idle => Step::Wait,
            Transfer::Upload { at } => self.upload(now, at, response),
            Transfer::UploadSegment { at, announced, toggle } => {
                self.upload_segment(now, at, announced, toggle, response)
            }
            Transfer::Expedited { at } => {
                if response == (Response::Downloaded { at }) {
                    self.transfer = Transfer::Idle;
                    return Step::Written;
                }
                Step::Wait
            }
            Transfer::Download { at } => {
                if response == (Response::Downloaded { at }) {
                    return Step::Send(self.send_segment(now, at, 0, false));
                }
                Step::Wait
            }
            Transfer::DownloadSegment { at, sent, toggle } => {
                let Response::SegmentTaken { toggle: answered } = response else { return Step::Wait };
                if answered != toggle {
                    return self.fail(at, Abort::TOGGLE);
                }
                if sent >= self.len {
                    self.transfer = Transfer::Idle;
                    return Step::Written;
                }
                Step::Send(self.send_segment(now, at, sent, !toggle))
            }
        }
    }

    /// The deadline has come, or any other instant.
    pub fn handle_timeout(&mut self, now: Instant) -> Step<'_> {
        match self.at() {
            Some(at) if self.deadline <= now => self.fail(at, Abort::TIMEOUT),
            Some(_) | None => Step::Wait,
        }
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called.
    pub fn poll_timeout(&self) -> Option<Instant> {
        self.at().map(|_| self.deadline)
    }

    const fn at(&self) -> Option<Address> {
        match self.transfer {
            Transfer::Idle => None,
            Transfer::Upload { at }
            | Transfer::UploadSegment { at, .. }
            | Transfer::Expedited { at }
            | Transfer::Download { at }
            | Transfer::DownloadSegment { at, .. } => Some(at),
        }
    }

    fn upload(&mut self, now: Instant, at: Address, response: Response) -> Step<'_> {
        match response {
            Response::Expedited { at: about, octets, len } if about == at => {
                self.transfer = Transfer::Idle;
                self.len = usize::from(len);
                for (place, octet) in self.octets.iter_mut().zip(octets) {
                    *place = octet;
                }
                Step::Read(self.octets.get(..self.len).unwrap_or_default())
            }
            Response::Upload { at: about, len } if about == at => {
                self.wait_for(now, Transfer::UploadSegment { at, announced: len, toggle: false });
                Step::Send(self.request([0x60, 0, 0, 0, 0, 0, 0, 0]))
            }
            Response::Expedited { .. }
            | Response::Upload { .. }
            | Response::Downloaded { .. }
            | Response::Segment { .. }
            | Response::SegmentTaken { .. }
            | Response::Abort { .. } => Step::Wait,
        }
    }

    fn upload_segment(
        &mut self,
        now: Instant,
        at: Address,
        announced: u32,
        expected: bool,
        response: Response,
    ) -> Step<'_> {
        let Response::Segment { toggle, octets, len, last } = response else { return Step::Wait };
        let len = usize::from(len);
        if toggle != expected {
            return self.fail(at, Abort::TOGGLE);
        }
        let end = self.len + len;
        let Some(room) = self.octets.get_mut(self.len..end) else { return self.fail(at, Abort::MEMORY) };
        room.copy_from_slice(octets.get(..len).unwrap_or_default());
        self.len = end;
        if !last {
            self.wait_for(now, Transfer::UploadSegment { at, announced, toggle: !expected });
            return Step::Send(self.request([0x60 | u8::from(!expected) << 4, 0, 0, 0, 0, 0, 0, 0]));
        }
        // 0 stands for a length that was not said.
        if announced != 0 && u32::try_from(end) != Ok(announced) {
            return self.fail(at, Abort::LENGTH);
        }
        self.transfer = Transfer::Idle;
        Step::Read(self.octets.get(..end).unwrap_or_default())
    }

    fn send_segment(&mut self, now: Instant, at: Address, begin: usize, toggle: bool) -> Frame {
        let rest = self.octets.get(begin..self.len).unwrap_or_default();
        let mut frame = [0; FRAME_LEN];
        let mut count: u8 = 0;
        for (place, octet) in frame.iter_mut().skip(1).zip(rest) {
            *place = *octet;
            count += 1;
        }
        let sent = begin + usize::from(count);
        let [command, ..] = &mut frame;
        *command = u8::from(toggle) << 4 | (7 - count) << 1 | u8::from(sent >= self.len);
        self.wait_for(now, Transfer::DownloadSegment { at, sent, toggle });
        self.request(frame)
    }

    fn fail(&mut self, at: Address, code: Abort) -> Step<'_> {
        self.transfer = Transfer::Idle;
        Step::Failed { code, tell: self.request(Response::Abort { at, code }.encode()) }
    }

    fn wait_for(&mut self, now: Instant, transfer: Transfer) {
        self.transfer = transfer;
        self.deadline = now.saturating_add(self.time_limit);
    }

    fn request(&self, octets: [u8; FRAME_LEN]) -> Frame {
        Frame::with(cob_id::of_node(cob_id::SDO_CLIENT, self.node), octets)
    }
}
