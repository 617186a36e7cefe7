//! The SDO server, octet for octet (`canopen-link.md` 5, 13 and 14).

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::policy::{OutOfRange, StateCheck, WrongLength};
use profidrive::can_bus::canopen::{Abort, Address, Policy, Request};

use crate::canopen_device::rig::Rig;

#[test]
fn o_08_o_09_the_golden_frames() {
    let mut rig = Rig::new(Policy::CIA_301);
    let frames: &[([u8; 8], [u8; 8])] = &[
        ([0x40, 0x00, 0x10, 0, 0, 0, 0, 0], [0x43, 0x00, 0x10, 0, 0x91, 0x01, 0x0F, 0x00]),
        ([0x40, 0x01, 0x10, 0, 0, 0, 0, 0], [0x4F, 0x01, 0x10, 0, 0, 0, 0, 0]),
        ([0x40, 0x99, 0x99, 0, 0, 0, 0, 0], [0x80, 0x99, 0x99, 0, 0, 0, 0x02, 0x06]),
        ([0x2F, 0x00, 0x10, 0, 0, 0, 0, 0], [0x80, 0x00, 0x10, 0, 0x02, 0, 0x01, 0x06]),
        ([0xE0, 0x00, 0x10, 0, 0, 0, 0, 0], [0x80, 0x00, 0x10, 0, 0x01, 0, 0x04, 0x05]),
        // Segmented upload of "Hello World".
        ([0x40, 0x00, 0x20, 0, 0, 0, 0, 0], [0x41, 0x00, 0x20, 0, 0x0B, 0, 0, 0]),
        ([0x60, 0, 0, 0, 0, 0, 0, 0], [0x00, 0x48, 0x65, 0x6C, 0x6C, 0x6F, 0x20, 0x57]),
        ([0x70, 0, 0, 0, 0, 0, 0, 0], [0x17, 0x6F, 0x72, 0x6C, 0x64, 0, 0, 0]),
        // Segmented download of the same.
        ([0x21, 0x00, 0x20, 0, 0x0B, 0, 0, 0], [0x60, 0x00, 0x20, 0, 0, 0, 0, 0]),
        ([0x00, 0x48, 0x65, 0x6C, 0x6C, 0x6F, 0x20, 0x57], [0x20, 0, 0, 0, 0, 0, 0, 0]),
        ([0x17, 0x6F, 0x72, 0x6C, 0x64, 0, 0, 0], [0x30, 0, 0, 0, 0, 0, 0, 0]),
        // Wrong toggle.
        ([0x40, 0x00, 0x20, 0, 0, 0, 0, 0], [0x41, 0x00, 0x20, 0, 0x0B, 0, 0, 0]),
        ([0x60, 0, 0, 0, 0, 0, 0, 0], [0x00, 0x48, 0x65, 0x6C, 0x6C, 0x6F, 0x20, 0x57]),
        ([0x60, 0, 0, 0, 0, 0, 0, 0], [0x80, 0x00, 0x20, 0, 0, 0, 0x03, 0x05]),
    ];
    for &(request, expected) in frames {
        assert_eq!(rig.sdo(request), expected, "{request:02X?}");
    }
}

#[test]
fn a_held_answer_comes_when_the_device_gives_it_and_a_new_request_drops_it() {
    let mut rig = Rig::new(Policy::CIA_301);
    let request = [0x2F, 0x0E, 0x20, 0, 9, 0, 0, 0];
    assert!(rig.sdo_frames(request).is_empty());
    rig.device.requests.push_back(Request::AnswerSdo(Ok(())));
    assert_eq!(rig.change(), ["585#60 0E 20 00 00 00 00 00"]);
    rig.device.requests.push_back(Request::AnswerSdo(Ok(())));
    assert!(rig.change().is_empty(), "answered once");

    assert!(rig.sdo_frames(request).is_empty());
    rig.device.requests.push_back(Request::AnswerSdo(Err(Abort::HARDWARE)));
    assert_eq!(rig.change(), ["585#80 0E 20 00 00 00 06 06"]);

    assert!(rig.sdo_frames(request).is_empty());
    assert_eq!(rig.read(0x1001, 0), Ok(0));
    rig.device.requests.push_back(Request::AnswerSdo(Ok(())));
    assert!(rig.change().is_empty(), "the client has given up");
}

/// Reads 1001h: a request that works.
const WORKS: ([u8; 8], [u8; 8]) = ([0x40, 0x01, 0x10, 0, 0, 0, 0, 0], [0x4F, 0x01, 0x10, 0, 0, 0, 0, 0]);

fn works(rig: &mut Rig) {
    assert_eq!(rig.sdo(WORKS.0), WORKS.1);
}

#[test]
fn o_01_reads_and_writes_of_each_width_echo_the_multiplexer_and_leave_the_rest_zero() {
    let mut rig = Rig::new(Policy::CIA_301);
    let cases: &[(u16, u8, [u8; 4], [u8; 4])] = &[
        (0x2009, 1, [7, 0, 0, 0], [200, 0, 0, 0]),
        (0x200A, 2, [0xE8, 0x03, 0, 0], [0x34, 0x12, 0, 0]),
        (0x200B, 4, [0x70, 0x11, 0x01, 0], [0x78, 0x56, 0x34, 0x12]),
        (0x2006, 1, [0xFD, 0, 0, 0], [0x9C, 0, 0, 0]),
        (0x2007, 2, [0xD4, 0xFE, 0, 0], [0x18, 0xFC, 0, 0]),
        (0x2008, 4, [0x90, 0xEE, 0xFE, 0xFF], [0x01, 0, 0, 0]),
    ];
    for &(index, len, default, new) in cases {
        let [a, b] = index.to_le_bytes();
        let read = [0x40, a, b, 0, 0xAA, 0xBB, 0xCC, 0xDD];
        let command = 0x43 | (4 - len) << 2;
        let answer = |[d, e, f, g]: [u8; 4]| [command, a, b, 0, d, e, f, g];
        assert_eq!(rig.sdo(read), answer(default), "{index:04X}h");
        // What is behind the value is ignored.
        let mut data = [0x5A; 4];
        data[..usize::from(len)].copy_from_slice(&new[..usize::from(len)]);
        let [d, e, f, g] = data;
        let write = [0x23 | (4 - len) << 2, a, b, 0, d, e, f, g];
        assert_eq!(rig.sdo(write), [0x60, a, b, 0, 0, 0, 0, 0], "{index:04X}h");
        assert_eq!(rig.sdo(read), answer(new), "{index:04X}h");
    }
    let three = rig.sdo([0x27, 0x0D, 0x20, 0, 1, 2, 3, 9]);
    assert_eq!(three, [0x60, 0x0D, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(rig.sdo([0x40, 0x0D, 0x20, 0, 0, 0, 0, 0]), [0x47, 0x0D, 0x20, 0, 1, 2, 3, 0]);
}

#[test]
fn o_02_without_a_size_the_length_of_the_object_counts() {
    let mut rig = Rig::new(Policy::CIA_301);
    for (index, expected) in [(0x2009, 0x11), (0x200A, 0x2211), (0x200B, 0x4433_2211)] {
        let [a, b] = u16::to_le_bytes(index);
        assert_eq!(rig.sdo([0x22, a, b, 0, 0x11, 0x22, 0x33, 0x44]), [0x60, a, b, 0, 0, 0, 0, 0]);
        assert_eq!(rig.read(index, 0), Ok(expected));
    }
    assert_eq!(rig.sdo([0x22, 0x99, 0x99, 0, 1, 0, 0, 0])[4..], [0x00, 0x00, 0x02, 0x06]);
    assert_eq!(rig.sdo([0x22, 0x02, 0x20, 0, 1, 0, 0, 0])[4..], [0x13, 0x00, 0x07, 0x06], "8 octets");
}

#[test]
fn o_03_unknown_objects_and_subs() {
    let mut rig = Rig::new(Policy::CIA_301);
    for index in [0x0000, 0x0005, 0x0FFF, 0x1004, 0x1500, 0x1FFF, 0x2012, 0x5FFF, 0x9999, 0xFFFF] {
        assert_eq!(rig.read(index, 0), Err(Abort::NO_OBJECT.code()), "{index:04X}h");
        assert_eq!(rig.write(index, 0, 0, 1), Err(Abort::NO_OBJECT.code()), "{index:04X}h");
    }
    for (index, sub) in [(0x1000, 1), (0x1018, 5), (0x1018, 255), (0x1400, 4), (0x2011, 1), (0x2011, 8)] {
        assert_eq!(rig.read(index, sub), Err(Abort::NO_SUB.code()), "{index:04X}h:{sub}");
        assert_eq!(rig.write(index, sub, 0, 1), Err(Abort::NO_SUB.code()), "{index:04X}h:{sub}");
    }
    assert_eq!(rig.read(0x2011, 2), Ok(2), "behind a gap");
    assert_eq!(rig.read(0x2011, 9), Ok(9));
}

#[test]
fn o_04_access() {
    let mut rig = Rig::new(Policy::CIA_301);
    for (index, sub, len) in [(0x1000, 0, 4), (0x1000, 0, 1), (0x1009, 0, 2), (0x6000, 1, 1), (0x1018, 4, 4)]
    {
        assert_eq!(rig.write(index, sub, 0, len), Err(Abort::READ_ONLY.code()), "{index:04X}h");
    }
    assert_eq!(rig.read(0x200C, 0), Err(Abort::WRITE_ONLY.code()));
    rig.write(0x200C, 0, 0x1234, 2).unwrap();
    assert_eq!(rig.device.ram[&Address::new(0x200C, 0)], [0x34, 0x12]);
    let begin = rig.sdo([0x21, 0x00, 0x10, 0, 4, 0, 0, 0]);
    assert_eq!(begin, [0x80, 0x00, 0x10, 0, 0x02, 0, 0x01, 0x06], "segmented as well");
}

#[test]
fn o_05_wrong_lengths_change_nothing() {
    let one = WrongLength::One(Abort::LENGTH);
    for policy in [Policy::CIA_301, Policy { wrong_length: one, ..Policy::CIA_301 }] {
        let (long, short) = match policy.wrong_length {
            WrongLength::TooLongTooShort => (Abort::TOO_LONG, Abort::TOO_SHORT),
            WrongLength::One(code) => (code, code),
        };
        let mut rig = Rig::new(policy);
        for (index, len) in [(0x2009, 1), (0x200A, 2), (0x200B, 4)] {
            let before = rig.read(index, 0);
            for wrong in (1..=4).filter(|wrong| *wrong != len) {
                let code = if wrong > len { long } else { short };
                assert_eq!(rig.write(index, 0, 0x0101_0101, wrong), Err(code.code()), "{index:04X}h {wrong}");
                assert_eq!(rig.read(index, 0), before);
            }
        }
        let [d, e, f, g] = long.code().to_le_bytes();
        assert_eq!(rig.sdo([0x21, 0x0A, 0x20, 0, 3, 0, 0, 0]), [0x80, 0x0A, 0x20, 0, d, e, f, g]);
        assert_eq!(rig.sdo([0x21, 0x00, 0x20, 0, 65, 0, 0, 0]), [0x80, 0x00, 0x20, 0, d, e, f, g]);
        // Announced 11, sent 9: too short. Announced nothing, sent too much: too long.
        rig.sdo([0x21, 0x00, 0x20, 0, 11, 0, 0, 0]);
        rig.sdo([0x00, 1, 2, 3, 4, 5, 6, 7]);
        let [d, e, f, g] = short.code().to_le_bytes();
        assert_eq!(rig.sdo([0x1B, 8, 9, 0, 0, 0, 0, 0]), [0x80, 0x00, 0x20, 0, d, e, f, g]);
        rig.sdo([0x20, 0x0A, 0x20, 0, 0, 0, 0, 0]);
        let [d, e, f, g] = long.code().to_le_bytes();
        assert_eq!(rig.sdo([0x09, 1, 2, 3, 0, 0, 0, 0]), [0x80, 0x0A, 0x20, 0, d, e, f, g]);
        assert_eq!(rig.device.ram[&Address::new(0x2000, 0)], b"Hello World");
        works(&mut rig);
    }
}

#[test]
fn o_06_values_beside_their_range_change_nothing() {
    let each = OutOfRange::TooHighTooLow;
    for policy in [Policy::CIA_301, Policy { out_of_range: each, ..Policy::CIA_301 }] {
        let (low, high) = match policy.out_of_range {
            OutOfRange::TooHighTooLow => (Abort::TOO_LOW, Abort::TOO_HIGH),
            OutOfRange::One(code) => (code, code),
        };
        let mut rig = Rig::new(policy);
        for (index, len, lowest, highest) in [
            (0x2009, 1, 1, 200),
            (0x200A, 2, 10, 60_000),
            (0x2007, 2, -1000, 1000),
            (0x2008, 4, -100_000, 100_000),
        ] {
            let before = rig.read(index, 0);
            let write = |rig: &mut Rig, value: i32| rig.write(index, 0, value.cast_unsigned(), len);
            assert_eq!(write(&mut rig, lowest - 1), Err(low.code()), "{index:04X}h");
            assert_eq!(write(&mut rig, highest + 1), Err(high.code()), "{index:04X}h");
            assert_eq!(rig.read(index, 0), before);
            write(&mut rig, lowest).unwrap();
            write(&mut rig, highest).unwrap();
        }
    }
}

#[test]
fn o_06_a_boolean_is_0_or_1() {
    let mut rig = Rig::new(Policy::CIA_301);
    for (value, expected) in [(1, Ok(())), (2, Err(Abort::RANGE.code())), (185, Err(Abort::RANGE.code()))] {
        assert_eq!(rig.write(0x2005, 0, value, 1), expected);
        assert_eq!(rig.read(0x2005, 0), Ok(1));
    }
}

#[test]
fn o_06_entries_for_pre_operational_only() {
    let state = Err(Abort::DEVICE_STATE.code());
    for (state_check, first) in
        [(StateCheck::Last, Abort::RANGE), (StateCheck::BeforeLength, Abort::DEVICE_STATE)]
    {
        let mut rig = Rig::new(Policy { state_check, ..Policy::CIA_301 });
        rig.write(0x2010, 0, 3, 1).unwrap();
        rig.start();
        assert_eq!(rig.write(0x2010, 0, 4, 1), state);
        assert_eq!(rig.write(0x2010, 0, 99, 1), Err(first.code()), "which check comes first");
        assert_eq!(rig.read(0x2010, 0), Ok(3));
    }
}

#[test]
fn o_07_unknown_commands_segments_of_nothing_and_block_transfer() {
    for unknown_command in [Abort::COMMAND, Abort::UNSUPPORTED_ACCESS] {
        let mut rig = Rig::new(Policy { unknown_command, ..Policy::CIA_301 });
        let [d, e, f, g] = unknown_command.code().to_le_bytes();
        for command in 0xA0..=0xFF {
            let answer = rig.sdo([command, 0x00, 0x10, 0, 0, 0, 0, 0]);
            assert_eq!(answer, [0x80, 0x00, 0x10, 0, d, e, f, g], "{command:02X}");
        }
        for command in [0x00, 0x10, 0x0F, 0x60, 0x70] {
            let answer = rig.sdo([command, 1, 2, 3, 4, 5, 6, 7]);
            assert_eq!(answer, [0x80, 0, 0, 0, d, e, f, g], "{command:02X}");
        }
        works(&mut rig);
    }
    let mut rig = Rig::new(Policy { segmented: false, ..Policy::CIA_301 });
    for request in [[0x21, 0x0B, 0x20, 0, 4, 0, 0, 0], [0x20, 0x0B, 0x20, 0, 0, 0, 0, 0]] {
        assert_eq!(rig.sdo(request), [0x80, 0x0B, 0x20, 0, 0x01, 0, 0x04, 0x05], "no segments here");
    }
}

#[test]
fn o_08_segmented_transfers_of_every_length() {
    let mut rig = Rig::new(Policy::CIA_301);
    for len in 0..=200_usize {
        let value: Vec<u8> = (0..len).map(|place| (place * 7) as u8).collect();
        let announced = len % 2 == 0;
        let [d, e] = (if announced { len as u16 } else { 0 }).to_le_bytes();
        let begin = [0x20 | u8::from(announced), 0x01, 0x20, 0, d, e, 0, 0];
        assert_eq!(rig.sdo(begin), [0x60, 0x01, 0x20, 0, 0, 0, 0, 0]);
        let mut toggle = 0;
        let mut chunks: Vec<&[u8]> = value.chunks(7).collect();
        if chunks.is_empty() {
            chunks.push(&[]);
        }
        for (place, chunk) in chunks.iter().enumerate() {
            let mut segment = [0; 8];
            let last = place + 1 == chunks.len();
            segment[0] = toggle | (7 - chunk.len() as u8) << 1 | u8::from(last);
            segment[1..=chunk.len()].copy_from_slice(chunk);
            assert_eq!(rig.sdo(segment), [0x20 | toggle, 0, 0, 0, 0, 0, 0, 0]);
            toggle ^= 0x10;
        }
        assert_eq!(rig.device.ram[&Address::new(0x2001, 0)], value);

        let answer = rig.sdo([0x40, 0x01, 0x20, 0, 0, 0, 0, 0]);
        if (1..=4).contains(&len) {
            assert_eq!(answer[0], 0x43 | (4 - len as u8) << 2);
            assert_eq!(answer[4..4 + len], value);
            continue;
        }
        assert_eq!(answer, [0x41, 0x01, 0x20, 0, len as u8, 0, 0, 0]);
        let (mut read, mut toggle) = (Vec::<u8>::new(), 0);
        loop {
            let segment = rig.sdo([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
            assert_eq!(segment[0] & 0xF0, toggle);
            let count = 7 - usize::from(segment[0] >> 1 & 7);
            read.extend(&segment[1..=count]);
            assert!(segment[1 + count..].iter().all(|octet| *octet == 0));
            if segment[0] & 1 == 1 {
                break;
            }
            toggle ^= 0x10;
        }
        assert_eq!(read, value);
    }
}

#[test]
fn o_09_a_wrong_toggle_ends_the_transfer() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.sdo([0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(
        rig.sdo([0x70, 0, 0, 0, 0, 0, 0, 0]),
        [0x80, 0x00, 0x20, 0, 0, 0, 0x03, 0x05],
        "begins with 0"
    );
    assert_eq!(rig.sdo([0x60, 0, 0, 0, 0, 0, 0, 0])[4..], [0x01, 0x00, 0x04, 0x05], "it is over");
    rig.sdo([0x20, 0x00, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(rig.sdo([0x00, b'A', b'B', b'C', b'D', b'E', b'F', b'G'])[0], 0x20);
    assert_eq!(
        rig.sdo([0x00, b'A', b'B', b'C', b'D', b'E', b'F', b'G'])[4..],
        [0, 0, 0x03, 0x05],
        "repeated"
    );
    assert_eq!(rig.device.ram[&Address::new(0x2000, 0)], b"Hello World");
    works(&mut rig);
}

#[test]
fn o_10_an_abort_of_the_client_is_not_answered() {
    let abort = [0x80, 0x00, 0x20, 0, 0, 0, 0x04, 0x05];
    for begin in [None, Some([0x40, 0x00, 0x20, 0, 0, 0, 0, 0]), Some([0x21, 0x00, 0x20, 0, 5, 0, 0, 0])] {
        let mut rig = Rig::new(Policy::CIA_301);
        if let Some(begin) = begin {
            rig.sdo(begin);
        }
        assert!(rig.sdo_frames(abort).is_empty());
        assert_eq!(rig.sdo([0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x80, "the transfer is over");
        works(&mut rig);
    }
}

#[test]
fn o_11_a_new_request_inside_a_transfer_is_served_and_ends_it() {
    let mut rig = Rig::new(Policy::CIA_301);
    for begin in [[0x40, 0x00, 0x20, 0, 0, 0, 0, 0], [0x21, 0x00, 0x20, 0, 5, 0, 0, 0]] {
        rig.sdo(begin);
        works(&mut rig);
        assert_eq!(rig.sdo([0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x80);
        assert_eq!(rig.sdo([0x01, 1, 2, 3, 4, 5, 6, 7])[0], 0x80);
    }
}

#[test]
fn o_12_frames_of_wrong_length_remote_and_extended_ones_are_ignored() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.sdo([0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    for len in 0..8 {
        assert!(rig.data(0x605, &WORKS.0[..len]).is_empty(), "{len} octets");
    }
    for dlc in 0..=8 {
        assert!(rig.remote(0x605, dlc).is_empty());
    }
    assert!(rig.extended(0x605, &WORKS.0).is_empty());
    assert_eq!(rig.sdo([0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x00, "the transfer goes on");
    works(&mut rig);
}

#[test]
fn o_13_silence_in_stopped_and_the_transfer_is_over() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.sdo([0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
    rig.data(0x000, &[0x02, 5]);
    assert!(rig.data(0x605, &WORKS.0).is_empty());
    rig.data(0x000, &[0x80, 5]);
    assert_eq!(rig.sdo([0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x80);
    works(&mut rig);
}

#[test]
fn o_14_requests_for_other_nodes_and_answers_of_others_are_not_answered() {
    let mut rig = Rig::new(Policy::CIA_301);
    for node in (1..=127).filter(|node| *node != 5) {
        assert!(rig.data(0x600 + node, &WORKS.0).is_empty());
        assert!(rig.data(0x580 + node, &WORKS.0).is_empty());
    }
    assert!(rig.data(0x585, &WORKS.0).is_empty());
}

#[test]
fn o_15_a_thousand_requests_back_to_back_are_answered_in_order() {
    let mut rig = Rig::new(Policy::CIA_301);
    let id = Id::base(0x605).unwrap();
    let mut answers = Vec::new();
    for request in 0..1000_u16 {
        let [d, e] = (1000 + request).to_le_bytes();
        let octets = if request % 2 == 0 {
            [0x2B, 0x0A, 0x20, 0, d, e, 0, 0]
        } else {
            [0x40, 0x0A, 0x20, 0, 0, 0, 0, 0]
        };
        rig.node.handle_frame(rig.now, &Frame::with(id, octets), &mut rig.device);
        // The host takes frames in batches.
        if request % 8 == 7 {
            answers.extend(rig.drain());
        }
    }
    let expected: Vec<String> = (0..1000_u16)
        .map(|request| {
            let [d, e] = (1000 + request - 1).to_le_bytes();
            if request % 2 == 0 {
                "585#60 0A 20 00 00 00 00 00".to_owned()
            } else {
                format!("585#4B 0A 20 00 {d:02X} {e:02X} 00 00")
            }
        })
        .collect();
    assert_eq!(answers, expected);
}

#[test]
fn another_name_of_an_entry_is_the_same_value() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x200F, 0, 250, 2).unwrap();
    assert_eq!(rig.read(0x1800, 5), Ok(250));
    rig.write(0x1800, 5, 40, 2).unwrap();
    assert_eq!(rig.read(0x200F, 0), Ok(40));
}
