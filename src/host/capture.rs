//! Captures: what passes on a line, in pcapng files that Wireshark and tcpdump open (feature `capture`).
//!
//! ```text
//! Section Header          shb_hardware, shb_os, shb_userappl
//! Interface Description   link type 257 or 227, if_name, if_description, if_speed, if_tsresol 9
//! Enhanced Packet         one telegram or one run of octets that are none, from its first octet to its last
//!   epb_flags             bits 1..0: 01 heard on the line, 10 sent by a station of ours
//!   opt_comment           of octets that are no telegram: "invalid: " and why
//!   opt_comment           each thing that happened since the packet before, with [`Capture::remark`]
//! ```
//!
//! 257 is LINKTYPE_PROFIBUS_DL in the registry of tcpdump.org: the octets of the data link layer from the start
//! delimiter to the end delimiter. 227 is LINKTYPE_CAN_SOCKETCAN: frames of a CAN bus, see [`can`]. Times are those of a [`Tap`](super::link::tap::Tap), in nanoseconds since 1970 UTC.
//!
//! A [`Capture`] is whole at any moment at which a process can be killed: with each [`Batch`] of a tap whole blocks are
//! appended, in one call of the operating system. [`read()`] reads such files back, and those of others.
//!
//! ```
//! use profidrive::host::capture::{self, Capture, Interface};
//! use profidrive::host::link::memory::Wire;
//! use profidrive::host::link::tap::{Batch, Direction, Tap};
//! use profidrive::host::{Link, SystemClock};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("bus.pcapng");
//! let clock = SystemClock::new();
//! let line = Interface { name: "memory", description: "an example", baud: None };
//! let mut file = Capture::create(&path, &line, &clock)?;
//!
//! let wire = Wire::new();
//! let mut drives = Tap::new(wire.end(), clock, |batch: &Batch| file.write(batch).unwrap());
//! drives.send(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16])?;
//!
//! let packet = capture::read(&path)?.next().expect("one telegram")?;
//! assert_eq!(packet.octets, [0x10, 0x02, 0x05, 0x00, 0x07, 0x16]);
//! assert_eq!((packet.direction, packet.comment), (Some(Direction::Sent), None));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use core::fmt;
use core::time::Duration;
use std::borrow::Cow;
use std::env;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use pcap_file::pcapng::PcapNgWriter;
use pcap_file::pcapng::blocks::enhanced_packet::{EnhancedPacketBlock, EnhancedPacketOption};
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption,
};
use pcap_file::pcapng::blocks::section_header::{SectionHeaderBlock, SectionHeaderOption};
use pcap_file::{DataLink, Endianness, PcapError};
use thiserror::Error;

use super::Clock;
use super::link::tap::{Batch, Direction, Seen};
use super::lock::locked;
use crate::time::{BaudRate, Instant};

pub mod can;
mod read;

pub use read::{LinkType, Packet, ReadError, Reader, read, read_can};

/// Bits 1..0 of epb_flags.
const INBOUND: u32 = 0b01;
const OUTBOUND: u32 = 0b10;

/// Comments of one packet at most.
const MOST_REMARKS: usize = 32;

/// if_tsresol: 10 to the power of -9 s.
const NANOSECONDS: u8 = 9;

/// What the file says of the line.
#[derive(Clone, Copy, Debug)]
pub struct Interface<'a> {
    /// What a master opens.
    pub name: &'a str,
    /// Who is on the line, for people.
    pub description: &'a str,
    /// The rate, if it stays one.
    pub baud: Option<BaudRate>,
}

/// Why a capture cannot be begun. The cause, where there is one, is the error's source.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CaptureError {
    /// The path is a directory, a pipe or a device. Who reads a pipe too slowly would stop the bus.
    #[error("cannot capture to {}: it is no regular file; name a regular file", path.display())]
    NoFile {
        /// The path.
        path: PathBuf,
    },
    /// Another process writes a capture to it.
    #[error("cannot capture to {}: another running emulator does; choose another file", path.display())]
    InUse {
        /// The path.
        path: PathBuf,
    },
    /// The file cannot be made or written.
    #[error("cannot capture to {}", path.display())]
    File {
        /// The path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
}

/// A capture being written. It needs no end: what is in the file is whole after each call.
pub struct Capture {
    file: File,
    /// How long the file is, blocks cut off by an error not counted.
    len: u64,
    /// Whole blocks on their way to the file.
    blocks: PcapNgWriter<Vec<u8>>,
    /// The time since 1970 at [`Instant::ZERO`].
    epoch: Duration,
    /// What happened since the last packet.
    remarks: Vec<String>,
}

impl fmt::Debug for Capture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, len, epoch, .. } = self;
        f.debug_struct("Capture")
            .field("file", file)
            .field("len", len)
            .field("epoch", epoch)
            .finish_non_exhaustive()
    }
}

impl Capture {
    /// Begins a capture in a file, which is emptied if it exists, as tcpdump does. `clock` is that of the tap; what the
    /// time of day is, is asked once, now: later settings of that clock do not make times jump.
    ///
    /// # Errors
    /// [`CaptureError`]; what was in the file may be lost only with [`CaptureError::File`].
    pub fn create(path: &Path, line: &Interface<'_>, clock: &dyn Clock) -> Result<Self, CaptureError> {
        let speed = line.baud.map(BaudRate::bits_per_second);
        Self::begin(path, DataLink::PROFIBUS_DL, line.name, line.description, speed, clock)
    }

    /// A capture of lines of this kind.
    fn begin(
        path: &Path,
        kind: DataLink,
        name: &str,
        description: &str,
        speed: Option<u32>,
        clock: &dyn Clock,
    ) -> Result<Self, CaptureError> {
        let failed = |source| CaptureError::File { path: path.to_path_buf(), source };
        // To open a pipe would wait for somebody who reads it.
        if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(CaptureError::NoFile { path: path.to_path_buf() });
        }
        let file = OpenOptions::new().create(true).truncate(false).write(true).open(path).map_err(failed)?;
        if !locked(&file).map_err(failed)? {
            return Err(CaptureError::InUse { path: path.to_path_buf() });
        }
        file.set_len(0).map_err(failed)?;
        let mut blocks = begun(kind, name, description, speed).map_err(io_error).map_err(failed)?;
        // A system whose clock is before 1970 gets times from 1970 on.
        let today = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let epoch = today.saturating_sub(clock.now().saturating_since(Instant::ZERO));
        let (len, written) = append(&file, 0, &mut blocks);
        written.map_err(failed)?;
        Ok(Self { file, len, blocks, epoch, remarks: Vec::new() })
    }

    /// Something happened: the next packet carries it as a comment. Of many before one packet the first 32 are kept.
    pub(crate) fn remark(&mut self, text: &str) {
        if self.remarks.len() < MOST_REMARKS {
            self.remarks.push(short(text));
        }
    }

    /// Appends what a tap has seen. When this returns, the operating system has it.
    ///
    /// # Errors
    /// The file cannot be written, for example because the disk is full. What it holds then ends before this batch.
    pub fn write(&mut self, batch: &Batch) -> io::Result<()> {
        for seen in batch.iter() {
            let remarks = invalid(&seen).into_iter().chain(self.remarks.drain(..));
            self.blocks.write_pcapng_block(packet(&seen, self.epoch, remarks)).map_err(io_error)?;
        }
        self.append()
    }

    fn append(&mut self) -> io::Result<()> {
        let (len, written) = append(&self.file, self.len, &mut self.blocks);
        self.len = len;
        written
    }
}

/// Of which bus a capture in memory is, and its rate.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wire {
    /// PROFIBUS.
    Profibus(BaudRate),
    /// CAN, with [octets](can::octets) as packets, in bit/s.
    Can(u32),
}

/// A whole capture in memory: what a batch holds, with what `happened`, in the order of time. A happening is a comment of
/// the packet after it, or of the last one; of many at one packet the newest 32 are kept. `epoch` is the time since 1970 at
/// [`Instant::ZERO`].
///
/// # Errors
/// Never for a reason of the operating system's.
pub(crate) fn to_octets(
    wire: Wire,
    (name, description): (&str, &str),
    epoch: Duration,
    batch: &Batch,
    happened: impl IntoIterator<Item = (Instant, String)>,
) -> io::Result<Vec<u8>> {
    let (kind, speed) = match wire {
        Wire::Profibus(baud) => (DataLink::PROFIBUS_DL, baud.bits_per_second()),
        Wire::Can(bits) => (DataLink::CAN_SOCKETCAN, bits),
    };
    let mut blocks = begun(kind, name, description, Some(speed)).map_err(io_error)?;
    let mut happened = happened.into_iter().peekable();
    let mut packets = batch.iter().peekable();
    while let Some(seen) = packets.next() {
        let last = packets.peek().is_none();
        let mut remarks = Vec::new();
        while let Some((_, text)) = happened.next_if(|(at, _)| last || *at <= seen.at) {
            remarks.push(short(&text));
        }
        let newest = remarks.len().saturating_sub(MOST_REMARKS);
        let invalid = match wire {
            Wire::Profibus(_) => invalid(&seen),
            Wire::Can(_) => None,
        };
        let remarks = invalid.into_iter().chain(remarks.into_iter().skip(newest));
        blocks.write_pcapng_block(packet(&seen, epoch, remarks)).map_err(io_error)?;
    }
    Ok(blocks.into_inner())
}

/// Section header and interface description.
fn begun(
    kind: DataLink,
    name: &str,
    description: &str,
    speed: Option<u32>,
) -> Result<PcapNgWriter<Vec<u8>>, PcapError> {
    let application = concat!("profidrive ", env!("CARGO_PKG_VERSION"));
    let section = SectionHeaderBlock {
        endianness: Endianness::Little,
        options: vec![
            SectionHeaderOption::Hardware(Cow::Borrowed(env::consts::ARCH)),
            SectionHeaderOption::OS(Cow::Borrowed(env::consts::OS)),
            SectionHeaderOption::UserApplication(Cow::Borrowed(application)),
        ],
        ..SectionHeaderBlock::default()
    };
    let mut options = vec![
        InterfaceDescriptionOption::IfName(Cow::Owned(short(name))),
        InterfaceDescriptionOption::IfDescription(Cow::Owned(short(description))),
        InterfaceDescriptionOption::IfTsResol(NANOSECONDS),
    ];
    options.extend(speed.map(|bits| InterfaceDescriptionOption::IfSpeed(u64::from(bits))));
    let interface = InterfaceDescriptionBlock { linktype: kind, snaplen: 0, options };
    let mut blocks = PcapNgWriter::with_section_header(Vec::new(), section)?;
    blocks.write_pcapng_block(interface)?;
    Ok(blocks)
}

/// An option holds 65535 octets.
fn short(text: &str) -> String {
    text.chars().take(4096).collect()
}

/// epb_flags of a packet.
const fn flags(direction: Direction) -> u32 {
    match direction {
        Direction::Heard => INBOUND,
        Direction::Sent => OUTBOUND,
    }
}

/// What is wrong with a telegram.
fn invalid(seen: &Seen<'_>) -> Option<String> {
    seen.telegram.as_ref().err().map(|reason| format!("invalid: {reason}"))
}

fn packet<'a>(
    seen: &Seen<'a>,
    epoch: Duration,
    remarks: impl Iterator<Item = String>,
) -> EnhancedPacketBlock<'a> {
    let mut options = vec![EnhancedPacketOption::Flags(flags(seen.direction))];
    options.extend(remarks.map(|text| EnhancedPacketOption::Comment(Cow::Owned(text))));
    EnhancedPacketBlock {
        interface_id: 0,
        timestamp: epoch.saturating_add(seen.at.saturating_since(Instant::ZERO)),
        original_len: u32::try_from(seen.octets.len()).unwrap_or(u32::MAX),
        data: Cow::Borrowed(seen.octets),
        options,
    }
}

/// Moves `blocks` to the end of a file of `len` octets: its new length, and whether that went well.
fn append(mut file: &File, len: u64, blocks: &mut PcapNgWriter<Vec<u8>>) -> (u64, io::Result<()>) {
    let octets = blocks.get_mut();
    let written = file.write_all(octets);
    let added = u64::try_from(octets.len()).unwrap_or(u64::MAX);
    octets.clear();
    match written {
        Ok(()) => (len.saturating_add(added), Ok(())),
        Err(error) => {
            // Half a block would make the file end in an error. If even this fails, readers cope with that.
            let _ = file.set_len(len).and_then(|()| file.seek(SeekFrom::Start(len)));
            (len, Err(error))
        }
    }
}

/// Writing to memory fails for no reason of the operating system's.
fn io_error(error: PcapError) -> io::Error {
    match error {
        PcapError::IoError(error) => error,
        error @ (PcapError::IncompleteBuffer
        | PcapError::InvalidField(_)
        | PcapError::Utf8Error(_)
        | PcapError::FromUtf8Error(_)
        | PcapError::InvalidInterfaceId(_)) => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests;
