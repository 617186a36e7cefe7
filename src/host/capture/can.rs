//! Captures of a CAN bus, which Wireshark decodes as CANopen.
//!
//! A packet of LINKTYPE_CAN_SOCKETCAN (227), 16 octets as the Linux kernel gives them:
//!
//! ```text
//! octet 0..3  identifier, high octet first; bit 31 = 29 bits, bit 30 = remote request, bit 29 = error frame
//! octet 4     data length, 0..8
//! octet 5..7  0
//! octet 8..15 data, then zeros
//! ```
//!
//! An error frame has the identifier 20000008h (a bit error, with 01h in octet 10) or 20000020h (nobody acknowledged),
//! and a comment with the frame that was to be sent.

use std::borrow::Cow;
use std::io;
use std::path::Path;

use pcap_file::DataLink;
use pcap_file::pcapng::blocks::enhanced_packet::{EnhancedPacketBlock, EnhancedPacketOption};

use super::{Capture, CaptureError, flags, io_error};
use crate::can_bus::can::{BitRate, Frame, Id};
use crate::host::Clock;
use crate::host::can::Event;
use crate::host::can::bus::Damage;
use crate::host::link::tap::Direction;
use crate::time::Instant;

const EXTENDED: u32 = 1 << 31;
const REMOTE: u32 = 1 << 30;
const ERROR: u32 = 1 << 29;
/// Violation of the protocol, and which: a single bit.
const PROTOCOL: u32 = 1 << 3;
const SINGLE_BIT: u8 = 1;
/// No acknowledgement.
const NOT_ACKNOWLEDGED: u32 = 1 << 5;

const LENGTH: usize = 16;

/// What the file says of the bus.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CanInterface<'a> {
    /// What a master opens.
    pub name: &'a str,
    /// Who is on the bus, for people.
    pub description: &'a str,
    /// The rate of the bus.
    pub rate: BitRate,
}

impl Capture {
    /// Begins a capture of a CAN bus, as [`Capture::create`] does. `clock` is that of the bus.
    ///
    /// # Errors
    /// As [`Capture::create`].
    pub(crate) fn create_can(
        path: &Path,
        bus: &CanInterface<'_>,
        clock: &dyn Clock,
    ) -> Result<Self, CaptureError> {
        let speed = Some(bus.rate.bits_per_second());
        Self::begin(path, DataLink::CAN_SOCKETCAN, bus.name, bus.description, speed, clock)
    }

    /// Appends the event if it is a frame or an error frame of a bus that is
    /// [watched](crate::host::can::Bus::watch). When this returns, the operating system has it.
    ///
    /// # Errors
    /// As [`Capture::write`].
    pub(crate) fn write_can<E>(&mut self, event: &Event<E>) -> io::Result<()> {
        match event {
            Event::Passed { at, by_port, frame, .. } => {
                let direction = if *by_port { Direction::Heard } else { Direction::Sent };
                self.write_frame(*at, direction, frame)
            }
            Event::Damaged { at, frame, damage, .. } => {
                let comment = Some(format!("{damage}: {frame}"));
                self.write_octets(*at, Direction::Heard, error_octets(*damage), comment)
            }
            Event::Participant { .. } | Event::State { .. } | Event::Tuned(_) | Event::Lost { .. } => Ok(()),
        }
    }

    /// Appends a frame. When this returns, the operating system has it.
    ///
    /// # Errors
    /// As [`Capture::write`].
    pub(crate) fn write_frame(&mut self, at: Instant, direction: Direction, frame: &Frame) -> io::Result<()> {
        self.write_octets(at, direction, octets(frame), None)
    }

    fn write_octets(
        &mut self,
        at: Instant,
        direction: Direction,
        octets: [u8; LENGTH],
        comment: Option<String>,
    ) -> io::Result<()> {
        let mut options = vec![EnhancedPacketOption::Flags(flags(direction))];
        let comments = comment.into_iter().chain(self.remarks.drain(..));
        options.extend(comments.map(|comment| EnhancedPacketOption::Comment(Cow::Owned(comment))));
        let packet = EnhancedPacketBlock {
            interface_id: 0,
            timestamp: self.epoch.saturating_add(at.saturating_since(Instant::ZERO)),
            original_len: u32::try_from(octets.len()).unwrap_or(u32::MAX),
            data: Cow::Borrowed(&octets),
            options,
        };
        self.blocks.write_pcapng_block(packet).map_err(io_error)?;
        self.append()
    }
}

/// The octets of a frame in a capture.
#[must_use]
pub(crate) fn octets(frame: &Frame) -> [u8; LENGTH] {
    let kind = match frame.id() {
        Id::Base(_) => 0,
        Id::Extended(_) => EXTENDED,
    };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    written(frame.id().number() | kind | remote, frame.dlc(), frame.octets())
}

fn error_octets(damage: Damage) -> [u8; LENGTH] {
    match damage {
        Damage::Bit => written(ERROR | PROTOCOL, 8, &[0, 0, SINGLE_BIT]),
        Damage::NotAcknowledged => written(ERROR | NOT_ACKNOWLEDGED, 8, &[]),
    }
}

fn written(id: u32, length: u8, data: &[u8]) -> [u8; LENGTH] {
    let mut octets = [0; LENGTH];
    let front = id.to_be_bytes().into_iter().chain([length, 0, 0, 0]).chain(data.iter().copied());
    for (to, octet) in octets.iter_mut().zip(front) {
        *to = octet;
    }
    octets
}

/// The frame that the octets of a packet are; `None`: an error frame, CAN FD, or fewer octets than the frame has. Never
/// panics.
#[must_use]
pub fn frame(octets: &[u8]) -> Option<Frame> {
    let (id, rest) = octets.split_first_chunk::<4>()?;
    let ([length, _, _, _], data) = rest.split_first_chunk::<4>()?;
    let id = u32::from_be_bytes(*id);
    if id & ERROR != 0 {
        return None;
    }
    let number = id & !(EXTENDED | REMOTE);
    let id_of = if id & EXTENDED != 0 { Id::extended(number) } else { Id::base(u16::try_from(number).ok()?) };
    let id_of = id_of.ok()?;
    if id & REMOTE != 0 {
        return Frame::remote(id_of, *length).ok();
    }
    Frame::data(id_of, data.get(..usize::from(*length))?).ok()
}

/// Whether the octets of a packet are an error frame, which stands for an error that a controller has seen.
#[must_use]
pub(crate) fn is_error(octets: &[u8]) -> bool {
    octets.first_chunk().is_some_and(|id| u32::from_be_bytes(*id) & ERROR != 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::can::Bus;
    use crate::host::{ManualClock, capture};
    use proptest::prelude::*;

    #[test]
    fn golden_octets() {
        let base = |number| Id::base(number).unwrap();
        let sdo = Frame::with(base(0x605), [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
        assert_eq!(octets(&sdo), [0, 0, 6, 5, 8, 0, 0, 0, 0x40, 0, 0x10, 0, 0, 0, 0, 0]);
        let guard = Frame::remote(base(0x705), 1).unwrap();
        assert_eq!(octets(&guard), [0x40, 0, 7, 5, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        let long = Frame::with(Id::extended(0x1234_5678).unwrap(), [0xAB]);
        assert_eq!(octets(&long)[..9], [0x92, 0x34, 0x56, 0x78, 1, 0, 0, 0, 0xAB]);
        assert_eq!(error_octets(Damage::NotAcknowledged)[..5], [0x20, 0, 0, 0x20, 8]);
        assert_eq!(error_octets(Damage::Bit)[..11], [0x20, 0, 0, 8, 8, 0, 0, 0, 0, 0, 1]);
        assert_eq!(frame(&error_octets(Damage::Bit)), None);
        assert!(is_error(&error_octets(Damage::Bit)) && !is_error(&octets(&sdo)));
        for part in 0..16 {
            assert_eq!(frame(&octets(&sdo)[..part]), None, "{part} octets");
        }
        assert_eq!(frame(&octets(&sdo)[..]), Some(sdo));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(id in 0_u32..=0x1FFF_FFFF, remote: bool, dlc in 0_u8..=8, data: [u8; 8]) {
            for id in [Id::extended(id), Id::base(u16::try_from(id & 0x7FF).unwrap())] {
                let id = id.unwrap();
                let one = if remote {
                    Frame::remote(id, dlc)
                } else {
                    Frame::data(id, &data[..usize::from(dlc)])
                };
                prop_assert_eq!(frame(&octets(&one.unwrap())), one.ok());
            }
        }

        #[test]
        fn any_octets_are_a_frame_or_none(octets in proptest::collection::vec(any::<u8>(), 0..80)) {
            if let Some(read) = frame(&octets) {
                prop_assert_eq!(frame(&super::octets(&read)), Some(read));
            }
        }
    }

    #[test]
    fn a_capture_of_a_bus_holds_frames_with_direction_and_error_frames() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bus.pcapng");
        let about =
            CanInterface { name: "slcan-tcp:127.0.0.1:1", description: "node 5", rate: BitRate::K500 };
        let mut file = Capture::create_can(&path, &about, &ManualClock::new()).unwrap();
        let mut bus: Bus<()> = Bus::new(BitRate::K500);
        bus.watch(true);
        let one = bus.connect(Instant::ZERO);
        bus.faults_mut().add(Instant::ZERO, "frame-damaged,count=1".parse().unwrap());
        let sync = Frame::with(Id::base(0x080).unwrap(), []);
        bus.send(Instant::ZERO, one, sync).unwrap();
        bus.handle_timeout(Instant::from_millis(5));
        while let Some(event) = bus.poll_event() {
            file.write_can(&event).unwrap();
        }
        let packets: Vec<_> = capture::read_can(&path).unwrap().map(Result::unwrap).collect();
        let comments: Vec<_> = packets.iter().map(|packet| packet.comment.as_deref()).collect();
        assert_eq!(comments, [Some("bit error: 080#"), None]);
        assert_eq!(frame(&packets[1].octets), Some(sync));
        assert_eq!(packets[1].direction, Some(Direction::Heard));
        // A damaged half, 20 bits and 3 bits, then the frame: 24 + 20 + 3 + 48 bits of 2 us.
        assert_eq!((packets[1].time - packets[0].time).as_micros(), 2 * (3 + 48));
        let refused = capture::read(&path).unwrap().next().unwrap().unwrap_err();
        assert_eq!(
            std::string::ToString::to_string(&refused),
            "packet 1 has link type 227, expected 257 (PROFIBUS_DL)"
        );
    }
}
