//! Block transfers of the SDO server: up to 127 segments for one answer.
//!
//! ```text
//! download   C0 index sub length   ▶   ◀ A0 index sub size       upload   A0 index sub size threshold ▶  ◀ C0 index sub length
//!            01 .. 7F, 80 + n last ▶   ◀ A2 taken size                    A3                          ▶  ◀ 01 .. 7F, 80 + n last
//!            C1 unused, CRC        ▶   ◀ A1                               A2 taken size               ▶  ◀ .. C1 unused, CRC
//!                                                                         A1                          ▶
//! ```

use core::time::Duration;

use super::Node;
use super::sdo_server::{Answer, Transfer};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::abort::Abort;
use crate::can_bus::canopen::address::Address;
use crate::can_bus::canopen::application::{Application, Part};
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::event::Event;
use crate::can_bus::canopen::refusal::{Broken, Rule};
use crate::can_bus::canopen::sdo::block::{BlockRequest, LAST, MOST_SEGMENTS, SEGMENT_LEN, crc_16};
use crate::can_bus::canopen::sdo::{FRAME_LEN, MAX_VALUE_LEN, Response, addressed};
use crate::time::Instant;

/// A client that is silent for so long in the middle of a download has given up: what comes then is a new request.
const PATIENCE: Duration = Duration::from_secs(1);

/// Segments that are handed out at once; the others wait until those are on the bus.
const AT_ONCE: usize = 16;

/// A transfer under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    Download(Download),
    Upload(Upload),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Download {
    announced: Option<usize>,
    most: usize,
    /// Octets handed on.
    came: usize,
    /// The newest segment: how many of its octets count is said at the end.
    tail: Option<[u8; SEGMENT_LEN]>,
    /// Segments of this block in their order.
    taken: u8,
    /// Of what was handed on, if the client wants it.
    crc: Option<u16>,
    /// The last segment is here.
    complete: bool,
    heard: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Upload {
    len: usize,
    /// Segments that the client has.
    taken: usize,
    /// Segments of this block.
    size: u8,
    /// Those of them that are sent.
    sent: u8,
    stage: Stage,
    crc: bool,
    since: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The client has not begun.
    Offered,
    /// Segments are to be sent.
    Sending,
    /// The client has to say what it took.
    Waiting,
    /// It has everything, and has to say so.
    Complete,
}

impl Block {
    /// When segments are to be sent, once those before are on the bus.
    pub(super) fn due(&self) -> Option<Instant> {
        match self {
            Self::Upload(Upload { stage: Stage::Sending, since, .. }) => Some(*since),
            Self::Upload(_) | Self::Download(_) => None,
        }
    }

    /// Whether a frame at `now` is a segment, not a request.
    pub(super) fn takes(&self, now: Instant, command: u8) -> bool {
        match self {
            Self::Download(download) => {
                !download.complete && command & !LAST != 0 && now.saturating_since(download.heard) < PATIENCE
            }
            Self::Upload(_) => false,
        }
    }
}

impl Upload {
    fn segments(&self) -> usize {
        self.len.div_ceil(SEGMENT_LEN).max(1)
    }
}

impl Node {
    /// A command of a block transfer.
    pub(super) fn block_request(
        &mut self,
        now: Instant,
        octets: [u8; FRAME_LEN],
        app: &mut dyn Application,
    ) -> Option<Response> {
        match (BlockRequest::decode(octets), self.sdo.transfer) {
            (BlockRequest::Download { at, crc, len }, _) => self.begin_block_download(now, at, crc, len),
            (BlockRequest::Upload { at, crc, size, threshold }, _) => {
                self.begin_block_upload(now, at, (crc, size, threshold), app)
            }
            (
                BlockRequest::DownloadEnd { unused, crc },
                Transfer::Block { at, block: Block::Download(download @ Download { complete: true, .. }) },
            ) => self.end_block_download(now, at, (unused, crc), download, app),
            (BlockRequest::UploadStart, Transfer::Block { at, block: Block::Upload(upload) })
                if upload.stage == Stage::Offered =>
            {
                self.go_on(at, Upload { stage: Stage::Sending, since: now, ..upload });
                self.send_block(app);
                None
            }
            (
                BlockRequest::UploadTaken { count, size },
                Transfer::Block { at, block: Block::Upload(upload) },
            ) if upload.stage == Stage::Waiting => self.block_taken(now, at, (count, size), upload, app),
            (BlockRequest::UploadEnd, Transfer::Block { block: Block::Upload(upload), .. })
                if upload.stage == Stage::Complete =>
            {
                self.sdo.end();
                None
            }
            (
                BlockRequest::DownloadEnd { .. }
                | BlockRequest::UploadStart
                | BlockRequest::UploadTaken { .. }
                | BlockRequest::UploadEnd
                | BlockRequest::Unknown,
                _,
            ) => Some(self.no_transfer()),
        }
    }

    fn begin_block_download(
        &mut self,
        now: Instant,
        at: Address,
        crc: bool,
        len: Option<u32>,
    ) -> Option<Response> {
        self.sdo.end();
        let announced = len.map(|len| usize::try_from(len).unwrap_or(usize::MAX));
        match self.may_download(at, announced) {
            Ok(most) => {
                let (crc, heard) = (crc.then_some(0), now);
                let download =
                    Download { announced, most, came: 0, tail: None, taken: 0, crc, complete: false, heard };
                self.sdo.transfer = Transfer::Block { at, block: Block::Download(download) };
                self.send_sdo(addressed(0xA4, at, [MOST_SEGMENTS, 0, 0, 0]));
                None
            }
            Err(broken) => Some(self.refuse_announced(at, broken, announced)),
        }
    }

    /// A segment of a download.
    pub(super) fn block_segment(
        &mut self,
        now: Instant,
        [command, segment @ ..]: [u8; FRAME_LEN],
        app: &mut dyn Application,
    ) -> Option<Response> {
        let Transfer::Block { at, block: Block::Download(mut download) } = self.sdo.transfer else {
            return None;
        };
        let (number, last) = (command & !LAST, command & LAST != 0);
        if number == download.taken + 1 {
            if let Some(tail) = download.tail.replace(segment)
                && let Err(code) = self.hand_on(now, at, &mut download, &tail, app)
            {
                self.sdo.end();
                return Some(self.refuse(at, code));
            }
            download.taken = number;
            download.complete = last;
            download.heard = now;
        }
        // What is missing comes again, in the next block.
        if last || number == MOST_SEGMENTS {
            if download.taken != number {
                self.tell(Event::SegmentsMissed { at, taken: download.taken, number });
            }
            self.send_sdo([0xA2, download.taken, MOST_SEGMENTS, 0, 0, 0, 0, 0]);
            download.taken = 0;
        }
        self.sdo.transfer = Transfer::Block { at, block: Block::Download(download) };
        None
    }

    /// Octets that are known to count and are not the last ones.
    fn hand_on(
        &mut self,
        now: Instant,
        at: Address,
        download: &mut Download,
        octets: &[u8],
        app: &mut dyn Application,
    ) -> Result<(), Abort> {
        let (offset, end) = (download.came, download.came + octets.len());
        if end > download.announced.unwrap_or(download.most) {
            return Err(self.policy.too_long());
        }
        if download.most > MAX_VALUE_LEN {
            app.write_part(now, at, Part { offset, octets, last: false })?;
        } else {
            self.sdo.octets.get_mut(offset..end).ok_or(Abort::MEMORY)?.copy_from_slice(octets);
        }
        download.crc = download.crc.map(|crc| crc_16(crc, octets));
        download.came = end;
        Ok(())
    }

    fn end_block_download(
        &mut self,
        now: Instant,
        at: Address,
        (unused, crc): (u8, u16),
        download: Download,
        app: &mut dyn Application,
    ) -> Option<Response> {
        self.sdo.end();
        let tail = download.tail.unwrap_or_default();
        let tail = tail.get(..SEGMENT_LEN.saturating_sub(unused.into())).unwrap_or_default();
        let end = download.came + tail.len();
        let bounds = (download.announced.unwrap_or(0), download.announced.unwrap_or(download.most));
        let expected = download.crc.map(|before| crc_16(before, tail));
        if let Some(expected) = expected.filter(|expected| *expected != crc) {
            return Some(self.refuse_by(at, Abort::CRC, Rule::Crc { expected, got: crc }));
        }
        let code = if end > bounds.1 {
            Some(self.policy.too_long())
        } else if end < bounds.0 {
            Some(self.policy.too_short())
        } else {
            None
        };
        if let Some(code) = code {
            let broken = Broken::rule(code, Rule::Length(bounds.0, bounds.1));
            return Some(self.refuse_announced(at, broken, Some(end)));
        }
        if download.most > MAX_VALUE_LEN {
            let outcome =
                self.write_part(now, at, Part { offset: download.came, octets: tail, last: true }, app);
            return self.answer(at, tail, Answer::Block, outcome, app);
        }
        let mut value = self.sdo.octets;
        match value.get_mut(download.came..end) {
            Some(room) => room.copy_from_slice(tail),
            None => return Some(self.refuse(at, self.policy.too_long())),
        }
        self.written(now, at, value.get(..end).unwrap_or_default(), Answer::Block, app)
    }

    fn begin_block_upload(
        &mut self,
        now: Instant,
        at: Address,
        (crc, size, threshold): (bool, u8, u8),
        app: &dyn Application,
    ) -> Option<Response> {
        self.sdo.end();
        if !(1..=MOST_SEGMENTS).contains(&size) {
            return Some(self.refuse_by(at, Abort::BLOCK_SIZE, Rule::BlockSize(size)));
        }
        let len = match self.take_value(at, app) {
            Ok(len) => len,
            Err(code) => return Some(self.refuse(at, code)),
        };
        // The client prefers segments for values of up to so many octets.
        if len <= threshold.into() {
            return Some(self.upload(at, app));
        }
        let upload = Upload { len, taken: 0, size, sent: 0, stage: Stage::Offered, crc, since: now };
        self.go_on(at, upload);
        self.send_sdo(addressed(0xC6, at, u32::try_from(len).unwrap_or(u32::MAX).to_le_bytes()));
        None
    }

    /// Sends what has room of the block that is under way.
    pub(super) fn send_block(&mut self, app: &dyn Application) {
        let Transfer::Block { at, block: Block::Upload(mut upload) } = self.sdo.transfer else { return };
        while upload.stage == Stage::Sending && self.frames.len() < AT_ONCE {
            let number = upload.taken + usize::from(upload.sent);
            let last = number + 1 >= upload.segments();
            let segment = match self.segment(at, number * SEGMENT_LEN, upload.len, app) {
                Ok((segment, _)) => segment,
                Err(code) => {
                    self.sdo.end();
                    let refusal = self.refuse(at, code);
                    return self.respond(refusal);
                }
            };
            upload.sent += 1;
            let [a, b, c, d, e, f, g] = segment;
            self.send_sdo([upload.sent | if last { LAST } else { 0 }, a, b, c, d, e, f, g]);
            if last || upload.sent >= upload.size {
                upload.stage = Stage::Waiting;
            }
        }
        self.go_on(at, upload);
    }

    /// The client says how much of a block it took.
    fn block_taken(
        &mut self,
        now: Instant,
        at: Address,
        (count, size): (u8, u8),
        upload: Upload,
        app: &dyn Application,
    ) -> Option<Response> {
        if count > upload.sent {
            self.sdo.end();
            let rule = Rule::Taken { got: count, sent: upload.sent };
            return Some(self.refuse_by(at, Abort::SEQUENCE, rule));
        }
        let taken = upload.taken + usize::from(count);
        if taken < upload.segments() {
            if !(1..=MOST_SEGMENTS).contains(&size) {
                self.sdo.end();
                return Some(self.refuse_by(at, Abort::BLOCK_SIZE, Rule::BlockSize(size)));
            }
            self.go_on(at, Upload { taken, size, sent: 0, stage: Stage::Sending, since: now, ..upload });
            self.send_block(app);
            return None;
        }
        let unused = taken * SEGMENT_LEN - upload.len;
        let crc = if upload.crc { self.crc_of(at, upload.len, app) } else { 0 };
        let [low, high] = crc.to_le_bytes();
        let unused = u8::try_from(unused.min(SEGMENT_LEN)).unwrap_or_default();
        self.go_on(at, Upload { taken, stage: Stage::Complete, ..upload });
        self.send_sdo([0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]);
        None
    }

    fn crc_of(&self, at: Address, len: usize, app: &dyn Application) -> u16 {
        if len <= MAX_VALUE_LEN {
            return crc_16(0, self.sdo.octets.get(..len).unwrap_or_default());
        }
        self.read_with(at, app, |value| Ok(crc_16(0, value))).unwrap_or_default()
    }

    fn go_on(&mut self, at: Address, upload: Upload) {
        self.sdo.transfer = Transfer::Block { at, block: Block::Upload(upload) };
    }

    /// A write in blocks is done.
    pub(super) fn block_done(&mut self) {
        self.send_sdo([0xA1, 0, 0, 0, 0, 0, 0, 0]);
    }

    fn send_sdo(&mut self, octets: [u8; FRAME_LEN]) {
        self.send(Frame::with(cob_id::of_node(cob_id::SDO_SERVER, self.node_id), octets));
    }
}
