//! A capture of a stranger, whole or damaged: reading ends, gives no more octets than the file has, and says why it stops.
//! What it gives of PROFIBUS is judged as a recording of a master.

use profidrive::host::capture::{LinkType, Reader, can};
use profidrive::judge::{Recording, Row, Setup, Verdict};
use profidrive::time::Instant;

/// The file.
pub(crate) fn check(data: &[u8]) {
    let mut reader = match Reader::of_any(data) {
        Ok(reader) => reader,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let mut recording = Recording::new(Setup::default());
    let (mut last, mut given) = (Instant::ZERO, 0);
    for packet in reader.by_ref() {
        let packet = match packet {
            Ok(packet) => packet,
            Err(error) => {
                assert!(!error.to_string().is_empty());
                break;
            }
        };
        given += packet.octets.len();
        match packet.link {
            LinkType::ProfibusDl => {
                last = last.max(Instant::ZERO.saturating_add(packet.time));
                recording.take(last, &packet.octets, None);
            }
            LinkType::CanSocketCan => {
                if let Some(frame) = can::frame(&packet.octets) {
                    assert!(usize::from(frame.dlc()) <= packet.octets.len(), "{frame}");
                }
            }
        }
    }
    assert!(reader.next().is_none() || given > 0, "behind an error there is nothing");
    assert!(given <= data.len(), "{given} octets of {}", data.len());
    if recording.telegrams() == 0 {
        return;
    }
    for judged in recording.report(Row::ALL).judgements {
        let shown = judged.verdict != Verdict::Fail || !judged.telegrams.is_empty();
        assert!(shown, "{:?} fails and shows no telegram", judged.row);
    }
}
