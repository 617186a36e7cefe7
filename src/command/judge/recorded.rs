//! The judgement of a capture: pcapng, the older pcap, or lines of octets in hexadecimal.

use core::time::Duration;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::explain::HexText;
use crate::host::capture::{ReadError, read};
use crate::host::link::tap::Direction;
use crate::judge::{Recording, Report, Row, Setup};
use crate::time::Instant;
use pcap_file::DataLink;
use pcap_file::pcap::PcapReader;

use crate::command::Failure;

/// Lines without times are judged as if they came one after the other.
const STEP: Duration = Duration::from_millis(1);

/// Reads a capture to its end, or as far as it is whole, and judges what was seen.
pub(super) fn judge(file: &Path, setup: Setup, rows: &[Row]) -> Result<Report, Failure> {
    let mut recording = Recording::new(setup);
    match read(file) {
        Ok(packets) => take_packets(packets, &mut recording).map_err(|error| of_file(file, &error))?,
        Err(ReadError::Classic) => take_classic(file, &mut recording)?,
        Err(ReadError::Foreign) => take_lines(file, &mut recording)?,
        Err(error) => return Err(of_file(file, &error)),
    }
    Ok(recording.report(rows))
}

fn of_file(file: &Path, error: &dyn core::error::Error) -> Failure {
    Failure::Other(format!("{}: {}", file.display(), Failure::from_error(error).into_line()))
}

/// A file that is cut off, as a copy that was not finished is, is judged up to there.
fn take_packets(
    packets: impl Iterator<Item = Result<crate::host::capture::Packet, ReadError>>,
    recording: &mut Recording,
) -> Result<(), ReadError> {
    for packet in packets {
        let packet = match packet {
            Ok(packet) => packet,
            Err(ref error @ (ReadError::CutShort { packets } | ReadError::Damaged { packets, .. }))
                if packets > 0 =>
            {
                recording.cut_off(&error.to_string());
                return Ok(());
            }
            Err(error) => return Err(error),
        };
        // What the emulator heard came from the master.
        let from_master = packet.direction.map(|direction| direction == Direction::Heard);
        recording.take(instant(packet.time), &packet.octets, from_master);
    }
    Ok(())
}

/// The older format says nothing of directions.
fn take_classic(file: &Path, recording: &mut Recording) -> Result<(), Failure> {
    let source = File::open(file).map_err(|error| of_file(file, &error))?;
    let mut packets = PcapReader::new(source).map_err(|error| of_file(file, &error))?;
    let link = packets.header().datalink;
    if link != DataLink::PROFIBUS_DL {
        let (got, expected) = (u32::from(link), u32::from(DataLink::PROFIBUS_DL));
        let line = format!("{}: the link type is {got}, expected {expected} (PROFIBUS_DL)", file.display());
        return Err(Failure::Other(line));
    }
    let mut whole = 0_u64;
    while let Some(packet) = packets.next_packet() {
        match packet {
            Ok(packet) => recording.take(instant(packet.timestamp), &packet.data, None),
            Err(error) if whole > 0 => {
                recording.cut_off(&format!("{error}; the {whole} packets before it are whole"));
                return Ok(());
            }
            Err(error) => return Err(of_file(file, &error)),
        }
        whole += 1;
    }
    Ok(())
}

/// Octets in hexadecimal, a telegram or more a line.
fn take_lines(file: &Path, recording: &mut Recording) -> Result<(), Failure> {
    let mut text = Vec::new();
    let read = File::open(file).and_then(|mut source| source.read_to_end(&mut text));
    read.map_err(|error| of_file(file, &error))?;
    let neither = |line: usize, why: &str| {
        let file = file.display();
        Failure::Other(format!("{file}: neither a capture nor octets in hexadecimal: line {line}: {why}"))
    };
    let text = String::from_utf8(text).map_err(|_| neither(1, "it is no text"))?;
    recording.without_times();
    let (mut hex, mut at) = (HexText::default(), Instant::ZERO);
    for (number, line) in (1..).zip(text.lines()) {
        let octets = hex.octets(line).map_err(|error| neither(number, &error.to_string()))?;
        if !octets.is_empty() {
            at = at + STEP;
            recording.take(at, &octets, None);
        }
    }
    Ok(())
}

fn instant(time: Duration) -> Instant {
    Instant::from_nanos(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX))
}
