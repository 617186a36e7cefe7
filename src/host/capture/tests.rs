use super::*;
use proptest::prelude::*;
use std::io::Cursor;

use crate::host::link::memory::{End, Wire};
use crate::host::link::tap::Tap;
use crate::host::{Link, ManualClock};
use crate::time::BaudRate;

const ASK: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
const ANSWER: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];
const LINE: Interface<'_> =
    Interface { name: "/dev/pts/7", description: "drives 5", baud: Some(BaudRate::K500) };

fn read_all(octets: &[u8]) -> Result<Vec<Packet>, ReadError> {
    Reader::new(Cursor::new(octets))?.collect()
}

/// What a capture of these telegrams to and from a drive holds, and when it began.
fn captured(play: impl FnOnce(&mut End, &mut dyn Link, &ManualClock)) -> (Vec<u8>, Duration) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bus.pcapng");
    let clock = ManualClock::new();
    clock.advance(Duration::from_secs(1));
    let mut file = Capture::create(&path, &LINE, &clock).unwrap();
    let epoch = file.epoch;
    let wire = Wire::new();
    let mut master = wire.end();
    let mut drives = Tap::new(wire.end(), clock.clone(), |batch: &Batch| file.write(batch).unwrap());
    play(&mut master, &mut drives, &clock);
    drop(drives);
    (fs::read(path).unwrap(), epoch)
}

fn hear(drives: &mut dyn Link) {
    drives.receive(&mut [0; 4096]).unwrap();
}

#[test]
fn what_is_written_is_read_back_with_time_direction_and_reason() {
    let (octets, epoch) = captured(|master, drives, clock| {
        master.send(&ASK).unwrap();
        hear(drives);
        clock.advance(Duration::from_nanos(22_333));
        drives.send(&ANSWER).unwrap();
        drives.send(&ANSWER[..3]).unwrap();
    });
    let at = |nanos| epoch + Duration::from_secs(1) + Duration::from_nanos(nanos);
    let packet = |nanos, direction, octets: &[u8], comment: Option<&str>| Packet {
        link: LinkType::ProfibusDl,
        time: at(nanos),
        direction: Some(direction),
        octets: octets.to_vec(),
        comment: comment.map(Into::into),
    };
    let expected = [
        packet(0, Direction::Heard, &ASK, None),
        packet(22_333, Direction::Sent, &ANSWER, None),
        packet(22_333, Direction::Sent, &ANSWER[..3], Some("invalid: telegram broken off after 3 octets")),
    ];
    assert_eq!(read_all(&octets).unwrap(), expected);
    let today = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap();
    assert!(at(0) <= today && today - at(0) < Duration::from_secs(600), "{:?} is not now", at(0));
}

#[test]
fn the_blocks_are_as_the_format_says() {
    let (octets, _) = captured(|master, drives, _| {
        master.send(&ASK).unwrap();
        hear(drives);
    });
    let number = |at: usize| u32::from_le_bytes(octets[at..at + 4].try_into().unwrap());
    assert_eq!(
        (number(0), number(8)),
        (0x0A0D_0D0A, 0x1A2B_3C4D),
        "a section, least significant octet first"
    );
    let interface = number(4) as usize;
    assert_eq!((number(interface), number(interface + 8) & 0xFFFF), (1, 257));
    let packet = interface + number(interface + 4) as usize;
    assert_eq!(
        (number(packet), number(packet + 8), number(packet + 20)),
        (6, 0, 6),
        "6 octets of interface 0"
    );
    assert_eq!(octets[packet + 28..packet + 34], ASK);
    assert_eq!(number(packet + 36), 0x0004_0002, "epb_flags");
    assert_eq!(number(packet + 40), 1, "inbound");
    assert_eq!(packet + number(packet + 4) as usize, octets.len());
    let text = std::string::String::from_utf8_lossy(&octets);
    for expected in ["profidrive 0.", "/dev/pts/7", "drives 5"] {
        assert!(text.contains(expected), "no {expected:?}");
    }
}

#[test]
fn every_batch_is_in_the_file_as_soon_as_it_was_seen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bus.pcapng");
    let clock = ManualClock::new();
    let mut file = Capture::create(&path, &LINE, &clock).unwrap();
    let mut drives = Tap::new(Wire::new().end(), clock, |batch: &Batch| file.write(batch).unwrap());
    for sent in 1..=3 {
        drives.send(&ANSWER).unwrap();
        assert_eq!(read(&path).unwrap().map(Result::unwrap).count(), sent);
    }
}

#[test]
fn an_existing_capture_is_replaced_but_not_one_being_written_and_nothing_but_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bus.pcapng");
    fs::write(&path, [0xA5; 10_000]).unwrap();
    let clock = ManualClock::new();
    let create = |path: &Path| Capture::create(path, &LINE, &clock);
    let first = create(&path).unwrap();
    assert_eq!(read(&path).unwrap().count(), 0);
    assert!(matches!(create(&path), Err(CaptureError::InUse { .. })));
    drop(first);
    assert!(create(&path).is_ok());
    assert!(matches!(create(folder.path()), Err(CaptureError::NoFile { .. })));
    assert!(matches!(create(Path::new("/dev/null")), Err(CaptureError::NoFile { .. })));
    assert!(matches!(create(&folder.path().join("no/such")), Err(CaptureError::File { .. })));
}

#[test]
fn foreign_files_are_refused_with_the_reason() {
    let refusal = |octets: &[u8]| read_all(octets).unwrap_err().to_string();
    assert_eq!(refusal(b""), "this is no pcapng capture");
    assert_eq!(refusal(b"10 05 02 49 50 16\n"), "this is no pcapng capture");
    assert_eq!(
        refusal(&[0xD4, 0xC3, 0xB2, 0xA1, 2, 0, 4, 0]),
        "this capture has the older format pcap; convert it with: editcap -F pcapng OLD NEW"
    );
    let (octets, _) = captured(|_, drives, _| {
        drives.send(&ANSWER).unwrap();
        drives.send(&ANSWER).unwrap();
    });
    assert_eq!(
        refusal(&octets[..octets.len() - 1]),
        "the capture is cut short in the middle of a block; the 1 packets before it are whole"
    );
    let link_type = octets.windows(4).position(|octets| octets == [1, 1, 0, 0]).unwrap();
    let mut ethernet = octets.clone();
    ethernet[link_type..link_type + 2].copy_from_slice(&[1, 0]);
    assert_eq!(refusal(&ethernet), "packet 1 has link type 1, expected 257 (PROFIBUS_DL)");
}

#[test]
fn times_of_other_units_are_read() {
    let (octets, _) = captured(|_, drives, _| drives.send(&ANSWER).unwrap());
    // if_tsresol: option 9, one octet.
    let unit = octets.windows(5).position(|octets| octets == [9, 0, 1, 0, 9]).unwrap() + 4;
    let packet =
        octets.windows(12).position(|octets| octets[..4] == [6, 0, 0, 0] && octets[8..] == [0; 4]).unwrap();
    for (resolution, ticks, expected) in [
        (6, 1_000_001_u64, Duration::new(1, 1_000)),
        (9, 1_000_001, Duration::from_nanos(1_000_001)),
        (0, 7, Duration::from_secs(7)),
        (12, 1_500_000, Duration::from_nanos(1_500)),
        (0x80 | 10, 1024 + 512, Duration::new(1, 500_000_000)),
        (0x7F, u64::MAX, Duration::ZERO),
    ] {
        let mut octets = octets.clone();
        octets[unit] = resolution;
        let ticks = ticks.to_le_bytes();
        octets[packet + 12..packet + 16].copy_from_slice(&ticks[4..]);
        octets[packet + 16..packet + 20].copy_from_slice(&ticks[..4]);
        let read = read_all(&octets).unwrap();
        assert_eq!(read[0].time, expected, "if_tsresol {resolution:#04X}");
    }
}

/// One of our captures with some octets changed and its end cut off.
fn damaged_capture() -> impl Strategy<Value = Vec<u8>> {
    let (octets, _) = captured(|master, drives, _| {
        for _ in 0..3 {
            master.send(&[&ASK[..], &[0x55; 3]].concat()).unwrap();
            hear(drives);
            drives.send(&ANSWER).unwrap();
        }
    });
    let len = octets.len();
    let change = (0..len, prop_oneof![any::<u8>(), Just(0), Just(0xFF), 0..8_u8]);
    (prop::collection::vec(change, 0..6), 0..=len).prop_map(move |(changes, cut)| {
        let mut octets = octets.clone();
        for (at, octet) in changes {
            octets[at] = octet;
        }
        octets.truncate(cut.max(len / 2));
        octets
    })
}

proptest! {
    /// A damaged capture is refused or read as far as it is whole; nothing panics and reading ends.
    #[test]
    fn a_damaged_capture_is_read_to_its_end(octets in damaged_capture()) {
        if let Ok(reader) = Reader::new(Cursor::new(&octets[..])) {
            let packets: Vec<_> = reader.take(100).collect();
            prop_assert!(packets.len() < 100);
            let errors = packets.iter().filter(|packet| packet.is_err()).count();
            prop_assert!(errors == 0 || errors == 1 && packets.last().is_some_and(Result::is_err));
        }
    }

    #[test]
    fn whatever_passes_is_read_back(
        sent in prop::collection::vec(prop::collection::vec(any::<u8>(), 1..300), 0..8),
    ) {
        let (octets, _) = captured(|_, drives, _| sent.iter().for_each(|octets| drives.send(octets).unwrap()));
        let read: Vec<_> = read_all(&octets).unwrap().into_iter().flat_map(|packet| packet.octets).collect();
        prop_assert_eq!(read, sent.concat());
    }
}
