//! The judgement of a capture.

use std::path::Path;

use profidrive::host::capture::read;
use profidrive::host::link::tap::Direction;
use profidrive::judge::{Recording, Report, Row, Setup};
use profidrive::time::Instant;

use crate::command::Failure;

/// Reads a capture to its end and judges what was seen.
pub(super) fn judge(file: &Path, setup: Setup, rows: &[Row]) -> Result<Report, Failure> {
    let of_file = |error: &dyn core::error::Error| {
        let Failure::Other(line) = Failure::from_error(error) else { return Failure::from_error(error) };
        Failure::Other(format!("{}: {line}", file.display()))
    };
    let packets = read(file).map_err(|error| of_file(&error))?;
    let mut recording = Recording::new(setup);
    for packet in packets {
        let packet = packet.map_err(|error| of_file(&error))?;
        let at = Instant::from_nanos(u64::try_from(packet.time.as_nanos()).unwrap_or(u64::MAX));
        // What the emulator heard came from the master.
        let from_master = packet.direction.map(|direction| direction == Direction::Heard);
        recording.take(at, &packet.octets, from_master);
    }
    Ok(recording.report(rows))
}
