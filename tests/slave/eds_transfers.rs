//! Values of a node from a file on their way: types, strings, domains, blocks (`eds.md` 6, E-09 to E-17).
#![cfg(feature = "eds")]

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::devices::CanopenDevice;

use crate::file_node::{NODE, Rig, var};

#[test]
fn eds_09_eds_17_every_type_is_read_and_written_in_its_length() {
    for (data, default, octets) in [
        (0x01, "1", vec![1]),
        (0x02, "-2", vec![0xFE]),
        (0x03, "-2", vec![0xFE, 0xFF]),
        (0x04, "-2", vec![0xFE, 0xFF, 0xFF, 0xFF]),
        (0x05, "200", vec![200]),
        (0x06, "0x1234", vec![0x34, 0x12]),
        (0x07, "$NODEID+0x100", vec![5, 1, 0, 0]),
        (0x08, "1.5", 1.5_f32.to_le_bytes().to_vec()),
        (0x09, "a text of some length", b"a text of some length".to_vec()),
        (0x0A, "0102030405", vec![1, 2, 3, 4, 5]),
        (0x0B, "AB", vec![0x41, 0, 0x42, 0]),
        (0x0C, "010203040506", vec![1, 2, 3, 4, 5, 6]),
        (0x0D, "", vec![0; 6]),
        (0x0F, "", vec![]),
        (0x10, "-1", vec![0xFF; 3]),
        (0x11, "-0.25", (-0.25_f64).to_le_bytes().to_vec()),
        (0x12, "-1", vec![0xFF; 5]),
        (0x13, "-1", vec![0xFF; 6]),
        (0x14, "-1", vec![0xFF; 7]),
        (0x15, "-1", vec![0xFF; 8]),
        (0x16, "0x010203", vec![3, 2, 1]),
        (0x18, "1", vec![1, 0, 0, 0, 0]),
        (0x19, "1", vec![1, 0, 0, 0, 0, 0]),
        (0x1A, "1", vec![1, 0, 0, 0, 0, 0, 0]),
        (0x1B, "0xFFFFFFFFFFFFFFFF", vec![0xFF; 8]),
    ] {
        let mut rig = Rig::text(&var(0x2000, data, "rw", &format!("DefaultValue={default}")));
        assert_eq!(rig.read(0x2000, 0), Ok(octets.clone()), "type {data:X}h");
        let new: Vec<u8> = octets.iter().map(|octet| octet / 2).collect();
        assert_eq!(rig.write(0x2000, 0, &new), Ok(()), "type {data:X}h");
        assert_eq!(rig.read(0x2000, 0), Ok(new.clone()), "type {data:X}h");
        if data == 0x0F {
            continue;
        }
        assert_eq!(rig.write_in_segments(0x2000, 0, &octets), Ok(()), "type {data:X}h");
        assert_eq!(rig.read(0x2000, 0), Ok(octets.clone()), "type {data:X}h");
        if !matches!(data, 0x09..=0x0B) {
            let mut long = octets.clone();
            long.push(0);
            assert_eq!(rig.write(0x2000, 0, &long), Err(0x0607_0012), "type {data:X}h");
            if octets.len() > 1 {
                assert_eq!(rig.write(0x2000, 0, &octets[1..]), Err(0x0607_0013), "type {data:X}h");
            }
            assert_eq!(rig.read(0x2000, 0), Ok(octets), "type {data:X}h");
        }
    }
}

#[test]
fn eds_11_a_domain_keeps_what_was_written_and_a_string_what_has_room() {
    let mut rig = Rig::text(&(var(0x2000, 0x0F, "rw", "DefaultValue=0102") + &var(0x2001, 9, "rw", "")));
    let program: Vec<u8> = (0..100_000_u32).map(|number| number.to_le_bytes()[0]).collect();
    assert_eq!(rig.read(0x2000, 0), Ok(vec![1, 2]));
    rig.write(0x2000, 0, &program).unwrap();
    assert_eq!(rig.read(0x2000, 0), Ok(program));
    rig.write_in_segments(0x2000, 0, &[]).unwrap();
    assert_eq!(rig.read(0x2000, 0), Ok(vec![]));
    rig.write(0x2001, 0, &[b'x'; 255]).unwrap();
    assert_eq!(rig.read(0x2001, 0), Ok(vec![b'x'; 255]));
    assert_eq!(rig.write(0x2001, 0, &[b'x'; 1025]), Err(0x0607_0012));
    assert_eq!(rig.write(0x2000, 0, &vec![0; (1 << 20) + 1]), Err(0x0607_0012));
    assert_eq!(rig.read(0x2001, 0), Ok(vec![b'x'; 255]), "as before");
}

/// All answers of the server to one frame, and to the time that passes.
fn block_frames(rig: &mut Rig, request: [u8; 8]) -> Vec<[u8; 8]> {
    let id = Id::base(0x600 + u16::from(NODE)).unwrap();
    rig.device.handle_frame(rig.now, &Frame::with(id, request));
    let mut answers = Vec::new();
    loop {
        while let Some(frame) = rig.device.poll_transmit(rig.now) {
            answers.push(frame.octets().try_into().unwrap());
        }
        if rig.device.poll_timeout().is_none_or(|due| due > rig.now) {
            return answers;
        }
        rig.device.handle_timeout(rig.now);
    }
}

fn crc(octets: &[u8]) -> [u8; 2] {
    let crc = octets.iter().fold(0_u16, |crc, octet| {
        (0..8).fold(crc ^ u16::from(*octet) << 8, |crc, _| {
            if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 }
        })
    });
    crc.to_le_bytes()
}

/// Writes in blocks; the client forgets the segments of `lost` the first time.
fn write_block(rig: &mut Rig, value: &[u8], lost: &[usize], checksum: [u8; 2]) -> Vec<[u8; 8]> {
    let [d, e, f, g] = u32::try_from(value.len()).unwrap().to_le_bytes();
    let [answer] = block_frames(rig, [0xC6, 0, 0x20, 0, d, e, f, g])[..] else { panic!() };
    assert_eq!(answer, [0xA4, 0, 0x20, 0, 127, 0, 0, 0]);
    let segments: Vec<_> = value.chunks(7).collect();
    let (mut taken, mut lost) = (0, lost.to_vec());
    while taken < segments.len() {
        let block = (1..=127_u8).zip(taken..segments.len());
        let mut answers = Vec::new();
        for (number, place) in block {
            // Without the last one of a block nobody answers.
            let is_end = number == 127 || place + 1 == segments.len();
            if let Some(at) = lost.iter().position(|lost| *lost == place && !is_end) {
                lost.remove(at);
                continue;
            }
            let last = if place + 1 == segments.len() { 0x80 } else { 0 };
            let mut frame = [0; 8];
            frame[0] = number | last;
            frame[1..=segments[place].len()].copy_from_slice(segments[place]);
            answers.extend(block_frames(rig, frame));
        }
        let [[0xA2, count, 127, ..]] = answers[..] else { return answers };
        taken += usize::from(count);
    }
    let unused = u8::try_from(segments.len() * 7 - value.len()).unwrap();
    block_frames(rig, [0xC1 | unused << 2, checksum[0], checksum[1], 0, 0, 0, 0, 0])
}

fn read_block(rig: &mut Rig, size: u8, loses: Option<u8>) -> Vec<u8> {
    let [offer] = block_frames(rig, [0xA4, 0, 0x20, 0, size, 0, 0, 0])[..] else { panic!() };
    assert_eq!(offer[..4], [0xC6, 0, 0x20, 0]);
    let len = u32::from_le_bytes(offer[4..].try_into().unwrap()) as usize;
    let (mut value, mut loses) = (Vec::new(), loses);
    let mut frames = block_frames(rig, [0xA3, 0, 0, 0, 0, 0, 0, 0]);
    loop {
        assert!(frames.len() <= usize::from(size));
        let (mut count, mut is_last) = (0, false);
        for (number, [head, segment @ ..]) in (1..=127).zip(&frames) {
            assert_eq!(head & 0x7F, number);
            if loses == Some(number) {
                loses = None;
                break;
            }
            (count, is_last) = (number, head & 0x80 != 0);
            value.extend_from_slice(segment);
        }
        frames = block_frames(rig, [0xA2, count, size, 0, 0, 0, 0, 0]);
        if is_last {
            break;
        }
    }
    let [[end, low, high, ..]] = frames[..] else { panic!("{frames:02X?}") };
    value.truncate(value.len() - usize::from(end >> 2 & 7));
    assert_eq!((end & 0xE3, [low, high], value.len()), (0xC1, crc(&value), len));
    assert_eq!(block_frames(rig, [0xA1, 0, 0, 0, 0, 0, 0, 0]), [[0; 8]; 0]);
    value
}

#[test]
fn values_go_in_blocks_also_when_segments_are_lost() {
    let mut rig = Rig::text(&(var(0x2000, 0x0F, "rw", "") + &var(0x2001, 7, "ro", "DefaultValue=1")));
    for len in [1, 6, 7, 8, 200, 256, 257, 889, 890, 5000] {
        let value: Vec<u8> = (0..len).map(|number: u32| number.to_le_bytes()[0] ^ 0x5A).collect();
        for lost in [&[][..], &[0], &[3, 100], &[125], &[700]] {
            let done = write_block(&mut rig, &value, lost, crc(&value));
            assert_eq!(done, [[0xA1, 0, 0, 0, 0, 0, 0, 0]], "{len} octets without {lost:?}");
            assert_eq!(rig.read(0x2000, 0), Ok(value.clone()), "{len} octets without {lost:?}");
        }
        for (size, loses) in [(127, None), (1, None), (40, Some(3)), (127, Some(20))] {
            assert_eq!(read_block(&mut rig, size, loses), value, "{len} octets in blocks of {size}");
        }
    }
    let aborted = |answers: Vec<[u8; 8]>| u32::from_le_bytes(answers[0][4..].try_into().unwrap());
    assert_eq!(aborted(write_block(&mut rig, &[1, 2, 3], &[], [0, 0])), 0x0504_0004, "the checksum");
    assert_eq!(aborted(block_frames(&mut rig, [0xC6, 1, 0x20, 0, 4, 0, 0, 0])), 0x0601_0002);
    assert_eq!(aborted(block_frames(&mut rig, [0xA4, 0, 0x20, 0, 128, 0, 0, 0])), 0x0504_0002);
    assert_eq!(aborted(block_frames(&mut rig, [0xA3, 0, 0, 0, 0, 0, 0, 0])), 0x0504_0001);
    // The client prefers an ordinary upload of four octets.
    assert_eq!(block_frames(&mut rig, [0xA4, 1, 0x20, 0, 9, 4, 0, 0]), [[0x43, 1, 0x20, 0, 1, 0, 0, 0]]);
    // A client that died in the middle of a block: a second later somebody else is answered.
    block_frames(&mut rig, [0xC6, 0, 0x20, 0, 100, 0, 0, 0]);
    assert_eq!(block_frames(&mut rig, [0x40, 1, 0x20, 0, 0, 0, 0, 0]), [[0; 8]; 0]);
    rig.pass(Duration::from_secs(1));
    assert_eq!(rig.read(0x2001, 0), Ok(vec![1, 0, 0, 0]));
}
