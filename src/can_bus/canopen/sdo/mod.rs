//! Service data: requests and answers of one entry (`canopen-link.md` 5).
//!
//! ```text
//! octet 0      command
//! octets 1..3  index, low octet first; sub-index     (segments: data in octets 1..7)
//! octets 4..7  data, length or abort code, low octet first
//!
//!              7 6 5   4   3 2   1   0
//! 2x request   0 0 1   0   n n   e   s    initiate download      answer 60
//! 0x 1x        0 0 0   t   n n n     c    download segment       answer 20, 30
//! 40           0 1 0   0 0 0 0 0          initiate upload        answer 4x: n n e s as above
//! 60 70        0 1 1   t   0 0 0 0        upload segment         answer 0x, 1x: t n n n c
//! 80           1 0 0   0 0 0 0 0          abort
//! ```
//!
//! Every frame has eight octets; frames of other lengths are ignored.
//!
//! | file | holds |
//! | --- | --- |
//! | `block` | requests of block transfers, and their checksum |
//! | [`client`] | the other end, for those who write masters |

pub(crate) mod block;
pub mod client;

use super::abort::Abort;
use super::address::Address;

/// Octets of every SDO frame.
pub(crate) const FRAME_LEN: usize = 8;

/// The most octets of a value that a node holds itself; longer ones go between client and device part by part.
pub(crate) const MAX_VALUE_LEN: usize = 256;

/// What a client wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoRequest {
    /// Write up to four octets.
    Expedited {
        /// Where.
        at: Address,
        /// The octets, `len` of them if that is said.
        octets: [u8; 4],
        /// How many, if said.
        len: Option<u8>,
    },
    /// Write in segments.
    Download {
        /// Where.
        at: Address,
        /// How many octets, if said.
        len: Option<u32>,
    },
    /// The next segment of a write.
    DownloadSegment {
        /// Alternates, false at first.
        toggle: bool,
        /// The octets, the first `len` of them.
        octets: [u8; 7],
        /// How many, 0 to 7.
        len: u8,
        /// No segment follows.
        last: bool,
    },
    /// Read.
    Upload {
        /// Where.
        at: Address,
    },
    /// The next segment of a read, please.
    UploadSegment {
        /// Alternates, false at first.
        toggle: bool,
    },
    /// The client gave up.
    Abort(Abort),
    /// Block transfer.
    Block {
        /// The octets in the place of an address.
        at: Address,
    },
    /// A command without meaning.
    Unknown {
        /// The octets in the place of an address.
        at: Address,
    },
}

impl SdoRequest {
    /// Every eight octets are a request.
    pub const fn decode(frame: [u8; FRAME_LEN]) -> Self {
        let [command, a, b, c, d, e, f, g] = frame;
        let at = Address::new(u16::from_le_bytes([a, b]), c);
        let data = [d, e, f, g];
        let toggle = command & 0x10 != 0;
        match command >> 5 {
            0 => Self::DownloadSegment {
                toggle,
                octets: [a, b, c, d, e, f, g],
                len: 7 - (command >> 1 & 7),
                last: command & 1 == 1,
            },
            1 => match (command & 0x02 != 0, command & 0x01 != 0) {
                (true, true) => Self::Expedited { at, octets: data, len: Some(4 - (command >> 2 & 3)) },
                (true, false) => Self::Expedited { at, octets: data, len: None },
                (false, true) => Self::Download { at, len: Some(u32::from_le_bytes(data)) },
                (false, false) => Self::Download { at, len: None },
            },
            2 => Self::Upload { at },
            3 => Self::UploadSegment { toggle },
            4 => Self::Abort(Abort::from_code(u32::from_le_bytes(data))),
            5 | 6 => Self::Block { at },
            7.. => Self::Unknown { at },
        }
    }
}

/// What a server answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// The write was begun, and if it was expedited, done.
    Downloaded {
        /// Where.
        at: Address,
    },
    /// A segment of a write was taken.
    SegmentTaken {
        /// That of the segment.
        toggle: bool,
    },
    /// A value of up to four octets, the first `len` of `octets`.
    Expedited {
        /// Where.
        at: Address,
        /// The octets; those behind `len` are zero.
        octets: [u8; 4],
        /// How many, 1 to 4.
        len: u8,
    },
    /// Segments can be asked for.
    Upload {
        /// Where.
        at: Address,
        /// How many octets there are; 0 if that is not said.
        len: u32,
    },
    /// A segment of a read.
    Segment {
        /// That of the request.
        toggle: bool,
        /// The octets; those behind `len` are zero.
        octets: [u8; 7],
        /// How many, 0 to 7.
        len: u8,
        /// No segment follows.
        last: bool,
    },
    /// The transfer is over without result.
    Abort {
        /// Where.
        at: Address,
        /// Why.
        code: Abort,
    },
}

impl Response {
    /// What eight octets of a server are; `None` for a command that is no answer here.
    pub(crate) const fn decode(frame: [u8; FRAME_LEN]) -> Option<Self> {
        let [command, a, b, c, d, e, f, g] = frame;
        let at = Address::new(u16::from_le_bytes([a, b]), c);
        let data = [d, e, f, g];
        let toggle = command & 0x10 != 0;
        Some(match (command >> 5, command & 0x02 != 0, command & 0x01 != 0) {
            (0, _, last) => {
                Self::Segment { toggle, octets: [a, b, c, d, e, f, g], len: 7 - (command >> 1 & 7), last }
            }
            (1, _, _) => Self::SegmentTaken { toggle },
            (2, true, true) => Self::Expedited { at, octets: data, len: 4 - (command >> 2 & 3) },
            (2, true, false) => Self::Expedited { at, octets: data, len: 4 },
            (2, false, true) => Self::Upload { at, len: u32::from_le_bytes(data) },
            (2, false, false) => Self::Upload { at, len: 0 },
            (3, _, _) => Self::Downloaded { at },
            (4, _, _) => Self::Abort { at, code: Abort::from_code(u32::from_le_bytes(data)) },
            (5.., _, _) => return None,
        })
    }

    /// As on the bus.
    pub(crate) const fn encode(self) -> [u8; FRAME_LEN] {
        match self {
            Self::Downloaded { at } => addressed(0x60, at, [0; 4]),
            Self::SegmentTaken { toggle } => [0x20 | toggled(toggle), 0, 0, 0, 0, 0, 0, 0],
            Self::Expedited { at, octets, len } => {
                addressed(0x43 | (4_u8.saturating_sub(len) & 3) << 2, at, octets)
            }
            Self::Upload { at, len } => addressed(0x41, at, len.to_le_bytes()),
            Self::Segment { toggle, octets: [a, b, c, d, e, f, g], len, last } => {
                let command = toggled(toggle) | (7_u8.saturating_sub(len) & 7) << 1 | last as u8;
                [command, a, b, c, d, e, f, g]
            }
            Self::Abort { at, code } => addressed(0x80, at, code.code().to_le_bytes()),
        }
    }
}

const fn toggled(toggle: bool) -> u8 {
    (toggle as u8) << 4
}

pub(super) const fn addressed(command: u8, at: Address, [d, e, f, g]: [u8; 4]) -> [u8; FRAME_LEN] {
    let [a, b] = at.index.0.to_le_bytes();
    [command, a, b, at.sub.0, d, e, f, g]
}
