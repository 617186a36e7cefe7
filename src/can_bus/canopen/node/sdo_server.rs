//! The SDO server of a node: one transfer at a time, expedited and in segments; `sdo_block` has those in blocks.

use super::Node;
use super::sdo_block::Block;
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::abort::Abort;
use crate::can_bus::canopen::address::Address;
use crate::can_bus::canopen::application::{Application, Part, Source, Written};
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::dictionary::Home;
use crate::can_bus::canopen::event::{Event, NoEffect};
use crate::can_bus::canopen::refusal::{Broken, Refusal, Rule};
use crate::can_bus::canopen::sdo::{FRAME_LEN, MAX_VALUE_LEN, Response, SdoRequest};
use crate::time::Instant;

/// What is under way.
#[derive(Clone, Debug)]
pub(super) struct Server {
    pub(super) transfer: Transfer,
    /// The value on its way in or out, if it has room.
    pub(super) octets: [u8; MAX_VALUE_LEN],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transfer {
    /// None.
    Idle,
    /// Octets `sent..len` are still to be asked for.
    Upload { at: Address, len: usize, sent: usize, toggle: bool },
    /// So many octets have come.
    Download { at: Address, announced: Option<usize>, most: usize, came: usize, toggle: bool },
    /// In blocks.
    Block { at: Address, block: Block },
    /// The write is done; the answer waits.
    Held { at: Address, answer: Answer },
}

/// What says that a write is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// Of an expedited one.
    Expedited,
    /// Of the last segment, with this toggle bit.
    Segment(bool),
    /// Of the end of a block transfer.
    Block,
}

impl Server {
    pub(super) const IDLE: Self = Self { transfer: Transfer::Idle, octets: [0; MAX_VALUE_LEN] };

    /// What is under way ends without a frame.
    pub(super) const fn end(&mut self) {
        self.transfer = Transfer::Idle;
    }

    /// When segments of a block are to be sent, once those before are on the bus.
    pub(super) fn due(&self) -> Option<Instant> {
        match &self.transfer {
            Transfer::Block { block, .. } => block.due(),
            Transfer::Idle | Transfer::Upload { .. } | Transfer::Download { .. } | Transfer::Held { .. } => {
                None
            }
        }
    }
}

impl Node {
    /// A frame on 600h + node while SDOs are served.
    pub(super) fn sdo_request(&mut self, now: Instant, frame: &Frame, app: &mut dyn Application) {
        let Ok(octets) = <[u8; FRAME_LEN]>::try_from(frame.octets()) else {
            return self.no_effect(NoEffect::SdoLength { got: frame.octets().len() });
        };
        // Whatever the client wants, it does not wait for an older answer.
        self.storage.forget_answer();
        let [command, ..] = octets;
        if let Transfer::Block { block, .. } = self.sdo.transfer
            && block.takes(now, command)
        {
            if let Some(response) = self.block_segment(now, octets, app) {
                self.respond(response);
            }
            return;
        }
        let response = match SdoRequest::decode(octets) {
            SdoRequest::Expedited { at, octets, len } => self.expedited(now, at, &octets, len, app),
            SdoRequest::Upload { at } => {
                let response = self.upload(at, app);
                if matches!(response, Response::Expedited { .. }) {
                    app.read_by_client(at);
                }
                Some(response)
            }
            SdoRequest::UploadSegment { toggle } => Some(self.upload_segment(toggle, app)),
            SdoRequest::Download { at, len } => Some(self.download(at, len)),
            SdoRequest::DownloadSegment { toggle, octets, len, last } => {
                let octets = octets.get(..usize::from(len)).unwrap_or_default();
                self.download_segment(now, toggle, octets, last, app)
            }
            SdoRequest::Abort(code) => {
                self.sdo_aborted_by_client(code);
                None
            }
            SdoRequest::Block { .. } if self.policy.block => self.block_request(now, octets, app),
            SdoRequest::Block { at } | SdoRequest::Unknown { at } => {
                self.sdo.end();
                Some(self.refuse(at, self.policy.unknown_command))
            }
        };
        if let Some(response) = response {
            self.respond(response);
        }
    }

    /// The answer held by [`Written::Held`].
    pub(super) fn answer_held(&mut self, outcome: Result<(), Abort>) {
        let Transfer::Held { at, answer } = self.sdo.transfer else { return };
        self.sdo.end();
        let response = match outcome {
            Ok(()) => match done(at, answer) {
                Some(response) => response,
                None => return self.block_done(),
            },
            Err(code) => self.refuse(at, code),
        };
        self.respond(response);
    }

    fn expedited(
        &mut self,
        now: Instant,
        at: Address,
        octets: &[u8; 4],
        len: Option<u8>,
        app: &mut dyn Application,
    ) -> Option<Response> {
        self.sdo.end();
        // Without a length the entry says how much of the four octets counts.
        let len = match (len, self.entry(at)) {
            (Some(len), _) => usize::from(len),
            (None, Ok(entry)) => entry.lengths().1.min(octets.len()),
            (None, Err(_)) => octets.len(),
        };
        let octets = octets.get(..len).unwrap_or_default();
        self.written(now, at, octets, Answer::Expedited, app)
    }

    /// Writes a value that is complete, and answers.
    pub(super) fn written(
        &mut self,
        now: Instant,
        at: Address,
        octets: &[u8],
        answer: Answer,
        app: &mut dyn Application,
    ) -> Option<Response> {
        let outcome = self.write(now, at, octets, Source::Sdo, app);
        self.answer(at, octets, answer, outcome, app)
    }

    pub(super) fn answer(
        &mut self,
        at: Address,
        octets: &[u8],
        answer: Answer,
        outcome: Result<Written, Broken>,
        app: &dyn Application,
    ) -> Option<Response> {
        match outcome {
            Ok(Written::Done) => {
                let response = done(at, answer);
                if response.is_none() {
                    self.block_done();
                }
                response
            }
            Ok(Written::Held) => {
                self.sdo.transfer = Transfer::Held { at, answer };
                None
            }
            Err(broken) => {
                let refusal = self.refusal_of_write(at, broken, octets, app);
                Some(self.tell_refusal(refusal))
            }
        }
    }

    pub(super) fn upload(&mut self, at: Address, app: &dyn Application) -> Response {
        self.sdo.end();
        let mut octets = [0; 4];
        let outcome = self.read_with(at, app, |value| {
            if let Some(front) = octets.get_mut(..value.len()) {
                front.copy_from_slice(value);
                return Ok((value.len(), true));
            }
            Ok((value.len(), false))
        });
        match outcome {
            Ok((len @ 1..=4, true)) => {
                #[expect(clippy::cast_possible_truncation, reason = "at most four")]
                let len = len as u8;
                Response::Expedited { at, octets, len }
            }
            Ok(_) if !self.policy.segmented => self.refuse(at, self.policy.unknown_command),
            Ok(_) => self.begin_upload(at, app),
            Err(code) => self.refuse(at, code),
        }
    }

    /// A value of more than four octets, or of none.
    fn begin_upload(&mut self, at: Address, app: &dyn Application) -> Response {
        match self.take_value(at, app) {
            Ok(len) => {
                self.sdo.transfer = Transfer::Upload { at, len, sent: 0, toggle: false };
                Response::Upload { at, len: u32::try_from(len).unwrap_or(u32::MAX) }
            }
            Err(code) => self.refuse(at, code),
        }
    }

    /// Keeps a value for its transfer if there is room; says its length.
    pub(super) fn take_value(&mut self, at: Address, app: &dyn Application) -> Result<usize, Abort> {
        let mut kept = [0; MAX_VALUE_LEN];
        let outcome = self.read_with(at, app, |value| {
            if let Some(room) = kept.get_mut(..value.len()) {
                room.copy_from_slice(value);
            }
            Ok(value.len())
        });
        self.sdo.octets = kept;
        outcome
    }

    fn upload_segment(&mut self, toggle: bool, app: &dyn Application) -> Response {
        let Transfer::Upload { at, len, sent, toggle: expected } = self.sdo.transfer else {
            return self.no_transfer();
        };
        if toggle != expected {
            self.sdo.end();
            return self.refuse(at, Abort::TOGGLE);
        }
        let (octets, count) = match self.segment(at, sent, len, app) {
            Ok(segment) => segment,
            Err(code) => {
                self.sdo.end();
                return self.refuse(at, code);
            }
        };
        let sent = sent + usize::from(count);
        let last = sent >= len;
        self.sdo.transfer =
            if last { Transfer::Idle } else { Transfer::Upload { at, len, sent, toggle: !toggle } };
        Response::Segment { toggle, octets, len: count, last }
    }

    /// Up to seven octets of a value of `len`, and how many.
    pub(super) fn segment(
        &self,
        at: Address,
        sent: usize,
        len: usize,
        app: &dyn Application,
    ) -> Result<([u8; 7], u8), Abort> {
        let mut octets = [0; 7];
        let mut count = 0;
        let mut take = |value: &[u8]| {
            for (place, octet) in octets.iter_mut().zip(value.get(sent..len).unwrap_or_default()) {
                *place = *octet;
                count += 1;
            }
        };
        if len <= MAX_VALUE_LEN {
            take(&self.sdo.octets);
        } else {
            self.read_with(at, app, |value| {
                take(value);
                if value.len() == len { Ok(()) } else { Err(Abort::TRANSFER) }
            })?;
        }
        Ok((octets, count))
    }

    fn download(&mut self, at: Address, announced: Option<u32>) -> Response {
        self.sdo.end();
        if !self.policy.segmented {
            return self.refuse(at, self.policy.unknown_command);
        }
        let announced = announced.map(|len| usize::try_from(len).unwrap_or(usize::MAX));
        match self.may_download(at, announced) {
            Ok(most) => {
                self.sdo.transfer = Transfer::Download { at, announced, most, came: 0, toggle: false };
                Response::Downloaded { at }
            }
            Err(broken) => {
                let entry = self.entry(at).ok();
                let refusal = match announced {
                    Some(len) => Refusal::announced(at, broken, entry, len),
                    None => Refusal::new(at, broken.code, entry),
                };
                self.tell_refusal(refusal)
            }
        }
    }

    /// What can be judged before the value is there. Says how long it may be.
    pub(super) fn may_download(&self, at: Address, announced: Option<usize>) -> Result<usize, Broken> {
        let entry = self.entry(at)?;
        if !entry.is_writable() {
            return Err(Abort::READ_ONLY.into());
        }
        let (_, most) = entry.lengths();
        if let Some(len) = announced {
            self.judge_length(entry, len)?;
        }
        if most > MAX_VALUE_LEN && entry.home != Home::Application {
            return Err(Abort::MEMORY.into());
        }
        Ok(most)
    }

    fn download_segment(
        &mut self,
        now: Instant,
        toggle: bool,
        octets: &[u8],
        last: bool,
        app: &mut dyn Application,
    ) -> Option<Response> {
        let Transfer::Download { at, announced, most, came, toggle: expected } = self.sdo.transfer else {
            return Some(self.no_transfer());
        };
        self.sdo.end();
        if toggle != expected {
            return Some(self.refuse(at, Abort::TOGGLE));
        }
        let end = came + octets.len();
        if end > announced.unwrap_or(most) {
            return Some(self.refuse(at, self.policy.too_long()));
        }
        if last && let Some(announced) = announced.filter(|announced| *announced != end) {
            let broken = Broken::rule(self.policy.too_short(), Rule::Length(announced, announced));
            return Some(self.refuse_announced(at, broken, Some(end)));
        }
        let next = Transfer::Download { at, announced, most, came: end, toggle: !toggle };
        if most > MAX_VALUE_LEN {
            let outcome = self.write_part(now, at, Part { offset: came, octets, last }, app);
            if outcome.is_ok() && !last {
                self.sdo.transfer = next;
                return Some(Response::SegmentTaken { toggle });
            }
            return self.answer(at, octets, Answer::Segment(toggle), outcome, app);
        }
        let Some(room) = self.sdo.octets.get_mut(came..end) else {
            return Some(self.refuse(at, self.policy.too_long()));
        };
        room.copy_from_slice(octets);
        if !last {
            self.sdo.transfer = next;
            return Some(Response::SegmentTaken { toggle });
        }
        let value = self.sdo.octets;
        let value = value.get(..end).unwrap_or_default();
        self.written(now, at, value, Answer::Segment(toggle), app)
    }

    /// A segment of nothing. The frame has no address to repeat.
    pub(super) fn no_transfer(&mut self) -> Response {
        self.sdo.end();
        let refusal = Refusal::new(Address::new(0, 0), self.policy.unknown_command, None);
        self.tell_refusal(refusal.with(Rule::NoTransfer))
    }

    pub(super) fn refuse(&mut self, at: Address, code: Abort) -> Response {
        self.tell_refusal(Refusal::new(at, code, self.entry(at).ok()))
    }

    /// The same, with the rule that the request breaks.
    pub(super) fn refuse_by(&mut self, at: Address, code: Abort, rule: Rule) -> Response {
        self.tell_refusal(Refusal::new(at, code, self.entry(at).ok()).with(rule))
    }

    /// Refuses a write whose length alone is known, if it is.
    pub(super) fn refuse_announced(&mut self, at: Address, broken: Broken, len: Option<usize>) -> Response {
        let entry = self.entry(at).ok();
        self.tell_refusal(match len {
            Some(len) => Refusal::announced(at, broken, entry, len),
            None => Refusal::new(at, broken.code, entry),
        })
    }

    pub(super) fn tell_refusal(&mut self, refusal: Refusal) -> Response {
        let Address { index, sub } = refusal.at;
        let meant = Address::new(index.0.swap_bytes(), sub.0);
        let is_exchanged = refusal.code == Abort::NO_OBJECT && self.entry(meant).is_ok();
        let refusal = if is_exchanged { refusal.with(Rule::Exchanged(meant)) } else { refusal };
        self.tell(Event::SdoRefused(refusal));
        Response::Abort { at: refusal.at, code: refusal.code }
    }

    fn sdo_aborted_by_client(&mut self, code: Abort) {
        match self.sdo.transfer {
            Transfer::Idle => {}
            Transfer::Upload { at, .. }
            | Transfer::Download { at, .. }
            | Transfer::Block { at, .. }
            | Transfer::Held { at, .. } => {
                self.sdo.end();
                self.tell(Event::SdoAbortedByClient { at, code });
            }
        }
    }

    pub(super) fn respond(&mut self, response: Response) {
        let mut octets = response.encode();
        if let (Response::Expedited { len: 4, .. }, false, [command, ..]) =
            (response, self.policy.four_octets_say_size, &mut octets)
        {
            *command = 0x42;
        }
        self.send(Frame::with(cob_id::of_node(cob_id::SDO_SERVER, self.node_id), octets));
    }
}

/// `None`: the end of a block transfer.
const fn done(at: Address, answer: Answer) -> Option<Response> {
    match answer {
        Answer::Expedited => Some(Response::Downloaded { at }),
        Answer::Segment(toggle) => Some(Response::SegmentTaken { toggle }),
        Answer::Block => None,
    }
}
