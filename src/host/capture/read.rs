//! Reading captures, ours and those of others.

use core::time::Duration;
use std::fs::File;
use std::io::{self, Chain, Cursor, ErrorKind, Read};
use std::path::Path;

use pcap_file::pcapng::blocks::enhanced_packet::{EnhancedPacketBlock, EnhancedPacketOption};
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption,
};
use pcap_file::pcapng::{Block, PcapNgReader};
use pcap_file::{DataLink, PcapError};
use thiserror::Error;

use super::{INBOUND, OUTBOUND};
use crate::host::link::tap::Direction;

/// The first four octets of a pcapng file.
const SECTION_HEADER: [u8; 4] = [0x0A, 0x0D, 0x0D, 0x0A];
/// Those of the older format, in both orders of octets, with microseconds and with nanoseconds.
const CLASSIC: [[u8; 4]; 4] =
    [[0xA1, 0xB2, 0xC3, 0xD4], [0xD4, 0xC3, 0xB2, 0xA1], [0xA1, 0xB2, 0x3C, 0x4D], [0x4D, 0x3C, 0xB2, 0xA1]];

const NANOS_PER_SECOND: u128 = 1_000_000_000;

/// Why a capture, or the rest of it, cannot be read. The cause, where there is one, is the error's source.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file begins with something else.
    #[error("this is no pcapng capture")]
    Foreign,
    /// The older format of captures.
    #[error("this capture has the older format pcap; convert it with: editcap -F pcapng OLD NEW")]
    Classic,
    /// Packets of another kind of line.
    #[error("packet {packet} has link type {got}, expected {}", names(*expected))]
    LinkType {
        /// Its number, from 1 on.
        packet: u64,
        /// The link type that is read; `None` for either.
        expected: Option<LinkType>,
        /// The link type of its interface.
        got: u32,
    },
    /// A packet without time, or of an obsolete kind.
    #[error(
        "packet {packet} is no Enhanced Packet Block; convert the capture with: editcap -F pcapng OLD NEW"
    )]
    Block {
        /// Its number, from 1 on.
        packet: u64,
    },
    /// The file ends in the middle of a block, as a copy that was not finished does.
    #[error("the capture is cut short in the middle of a block; the {packets} packets before it are whole")]
    CutShort {
        /// How many packets were read.
        packets: u64,
    },
    /// Something in the file contradicts the format.
    #[error("the capture is damaged after packet {packets}: {reason}")]
    Damaged {
        /// How many packets were read.
        packets: u64,
        /// What is wrong.
        reason: PcapError,
    },
    /// The file cannot be read.
    #[error("cannot read the capture")]
    File {
        /// What the operating system says.
        #[from]
        source: io::Error,
    },
}

/// What kind of line a packet is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LinkType {
    /// 257, PROFIBUS.
    ProfibusDl,
    /// 227, CAN.
    CanSocketCan,
}

impl LinkType {
    fn of(kind: DataLink) -> Option<Self> {
        [Self::ProfibusDl, Self::CanSocketCan].into_iter().find(|this| this.kind() == kind)
    }

    const fn kind(self) -> DataLink {
        match self {
            Self::ProfibusDl => DataLink::PROFIBUS_DL,
            Self::CanSocketCan => DataLink::CAN_SOCKETCAN,
        }
    }

    /// The number in the registry of tcpdump.org, and its name.
    const fn name(self) -> &'static str {
        match self {
            Self::ProfibusDl => "257 (PROFIBUS_DL)",
            Self::CanSocketCan => "227 (CAN_SOCKETCAN)",
        }
    }
}

/// One packet of a capture: a telegram, or octets that are none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// What kind of line it is of.
    pub link: LinkType,
    /// When, since 1970-01-01 00:00:00 UTC.
    pub time: Duration,
    /// Which way it passed the one who captured, if that is said.
    pub direction: Option<Direction>,
    /// Its octets: on PROFIBUS from the start delimiter to the end delimiter, on CAN as [`super::can`] says.
    pub octets: Vec<u8>,
    /// What was said of it; our captures say why octets are no telegram.
    pub comment: Option<String>,
}

/// The packets of a capture in their order. After an error there is nothing more.
pub struct Reader<R: Read> {
    expected: Option<LinkType>,
    blocks: PcapNgReader<Chain<Cursor<[u8; 4]>, R>>,
    packets: u64,
    failed: bool,
}

/// Opens a capture.
///
/// # Errors
/// As [`Reader::new`].
pub fn read(path: &Path) -> Result<Reader<File>, ReadError> {
    Reader::new(File::open(path)?)
}

/// Opens a capture of a CAN bus. [`Frame`](crate::can_bus::can::Frame)s are in its packets: [`super::can::frame`].
///
/// # Errors
/// As [`Reader::new`].
pub fn read_can(path: &Path) -> Result<Reader<File>, ReadError> {
    Reader::of_kind(File::open(path)?, Some(LinkType::CanSocketCan))
}

fn names(expected: Option<LinkType>) -> String {
    match expected {
        Some(link) => link.name().into(),
        None => format!("{} or {}", LinkType::ProfibusDl.name(), LinkType::CanSocketCan.name()),
    }
}

impl<R: Read> Reader<R> {
    /// Reads the beginning of a capture.
    ///
    /// # Errors
    /// [`ReadError`]; the most likely are [`ReadError::Foreign`] and [`ReadError::Classic`].
    pub fn new(source: R) -> Result<Self, ReadError> {
        Self::of_kind(source, Some(LinkType::ProfibusDl))
    }

    /// The same for a capture of either bus; each packet says which.
    ///
    /// # Errors
    /// As [`Reader::new`].
    pub fn of_any(source: R) -> Result<Self, ReadError> {
        Self::of_kind(source, None)
    }

    fn of_kind(mut source: R, expected: Option<LinkType>) -> Result<Self, ReadError> {
        let mut magic = [0; 4];
        match source.read_exact(&mut magic) {
            Ok(()) if magic == SECTION_HEADER => {}
            Ok(()) if CLASSIC.contains(&magic) => return Err(ReadError::Classic),
            Ok(()) => return Err(ReadError::Foreign),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Err(ReadError::Foreign),
            Err(error) => return Err(error.into()),
        }
        let source = Cursor::new(magic).chain(source);
        let blocks = PcapNgReader::new(source).map_err(|error| damaged(error, 0))?;
        Ok(Self { expected, blocks, packets: 0, failed: false })
    }

    fn next_packet(&mut self) -> Option<Result<Packet, ReadError>> {
        loop {
            let Self { expected, blocks, packets, .. } = self;
            let packet = match blocks.next_block()? {
                Ok(Block::EnhancedPacket(packet)) => packet,
                Ok(Block::Packet(_) | Block::SimplePacket(_)) => {
                    return Some(Err(ReadError::Block { packet: *packets + 1 }));
                }
                Ok(
                    Block::SectionHeader(_)
                    | Block::InterfaceDescription(_)
                    | Block::NameResolution(_)
                    | Block::InterfaceStatistics(_)
                    | Block::SystemdJournalExport(_)
                    | Block::Unknown(_),
                ) => continue,
                Err(error) => return Some(Err(damaged(error, *packets))),
            };
            let (id, ticks) = (packet.interface_id, packet.timestamp.as_nanos());
            let (direction, octets, comment) = contents(packet);
            let interface = usize::try_from(id).ok().and_then(|id| blocks.interfaces().get(id));
            let Some(interface) = interface else {
                return Some(Err(damaged(PcapError::InvalidInterfaceId(id), *packets)));
            };
            *packets += 1;
            let time = time(interface, ticks);
            let link = LinkType::of(interface.linktype);
            let Some(link) = link.filter(|link| expected.is_none_or(|expected| expected == *link)) else {
                let (expected, got) = (*expected, interface.linktype.into());
                return Some(Err(ReadError::LinkType { packet: *packets, expected, got }));
            };
            return Some(Ok(Packet { link, time, direction, octets, comment }));
        }
    }
}

impl<R: Read> Iterator for Reader<R> {
    type Item = Result<Packet, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let next = self.next_packet();
        self.failed = matches!(next, Some(Err(_)));
        next
    }
}

/// Direction, octets, comment.
fn contents(packet: EnhancedPacketBlock<'_>) -> (Option<Direction>, Vec<u8>, Option<String>) {
    let (mut direction, mut comment) = (None, None);
    for option in packet.options {
        match option {
            EnhancedPacketOption::Comment(text) => {
                let all: &mut String = comment.get_or_insert_default();
                if !all.is_empty() {
                    all.push('\n');
                }
                all.push_str(&text);
            }
            EnhancedPacketOption::Flags(flags) => {
                direction = match flags & (INBOUND | OUTBOUND) {
                    INBOUND => Some(Direction::Heard),
                    OUTBOUND => Some(Direction::Sent),
                    _ => None,
                }
            }
            EnhancedPacketOption::Hash(_)
            | EnhancedPacketOption::DropCount(_)
            | EnhancedPacketOption::CustomBinary(_)
            | EnhancedPacketOption::CustomUtf8(_)
            | EnhancedPacketOption::Unknown(_) => {}
        }
    }
    (direction, packet.data.into_owned(), comment)
}

/// The time of `ticks` in the unit of an interface. `pcap-file` takes every unit for nanoseconds.
fn time(interface: &InterfaceDescriptionBlock<'_>, ticks: u128) -> Duration {
    // Microseconds, unless the interface says something else.
    let (mut per_second, mut offset) = (1_000_000, 0);
    for option in &interface.options {
        if let InterfaceDescriptionOption::IfTsResol(unit) = option {
            let exponent = u32::from(unit & 0x7F);
            let base: u128 = if unit & 0x80 == 0 { 10 } else { 2 };
            per_second = base.saturating_pow(exponent);
        } else if let InterfaceDescriptionOption::IfTsOffset(seconds) = option {
            offset = *seconds;
        }
    }
    let seconds = u64::try_from(ticks / per_second).unwrap_or(u64::MAX);
    let nanos = (ticks % per_second).saturating_mul(NANOS_PER_SECOND) / per_second;
    Duration::from_secs(seconds.saturating_add(offset))
        .saturating_add(Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX)))
}

fn damaged(error: PcapError, packets: u64) -> ReadError {
    match error {
        PcapError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            ReadError::CutShort { packets }
        }
        PcapError::IoError(source) => ReadError::File { source },
        reason @ (PcapError::IncompleteBuffer
        | PcapError::InvalidField(_)
        | PcapError::Utf8Error(_)
        | PcapError::FromUtf8Error(_)
        | PcapError::InvalidInterfaceId(_)) => ReadError::Damaged { packets, reason },
    }
}
