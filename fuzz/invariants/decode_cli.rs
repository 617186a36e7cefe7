//! What `profidrive decode` does with a file: hexadecimal lines, lines of CAN frames or raw octets. Every octet is explained once, in order, by
//! fields that leave none out; the text is bounded by the octets; what is called a valid telegram is encoded to the same
//! octets.

use profidrive::can_bus::can::Frame;
use profidrive::devices::ag03;
use profidrive::devices::ag03::drive::Mode;
use profidrive::devices::ap10;
use profidrive::devices::asda_a2;
use profidrive::explain::canopen::{Network, frame_in};
use profidrive::explain::{Context, Decoder, Explanation, Field, HexText, Kind, Mark, Sender, Taking};
use profidrive::profibus::fdl::telegram::{Decoded, decode};

/// The first octet says how, the others are the file.
pub(crate) fn check(data: &[u8]) {
    let Some((&how, file)) = data.split_first() else { return };
    let context = match how & 0x03 {
        0 => Context::with_mode(Mode::Velocity),
        1 => Context::with_mode(Mode::Positioning),
        _ => Context::default(),
    };
    let taking = match how >> 2 & 0x07 {
        0 => Taking::Telegrams,
        1 => Taking::Words(None),
        2 => Taking::Words(Some(Sender::Master)),
        3 => Taking::Words(Some(Sender::Slave)),
        _ => Taking::Auto,
    };
    let mut decoder = Decoder::new(context, taking);
    let mut given = Vec::new();
    let mut explained = Vec::new();
    let mut sink = |at: u64, explanation: Explanation| {
        assert_eq!(at, explained.len() as u64, "octets left out or told twice");
        check_explanation(&explanation);
        explained.extend_from_slice(&explanation.octets);
    };
    if how & 0x20 == 0 {
        let mut text = HexText::default();
        let mut network = match how >> 6 {
            0 => Network::default(),
            1 => Network::of(&ag03::canopen::VOCABULARY),
            2 => Network::of(&ap10::canopen::VOCABULARY),
            _ => Network::of(&asda_a2::canopen::VOCABULARY),
        };
        for line in String::from_utf8_lossy(file).lines() {
            if let Some(frame) = frame_in(line) {
                if let Ok(frame) = frame {
                    check_frame(&network.frame(&frame), &frame);
                }
                continue;
            }
            let Ok(octets) = text.octets(line) else { continue };
            assert!(octets.len() <= line.len());
            decoder.line(&octets, &mut sink);
            given.extend(octets);
        }
    } else {
        for piece in file.chunks(usize::from(how >> 6) * 100 + 1) {
            decoder.octets(piece, &mut sink);
            given.extend_from_slice(piece);
        }
    }
    decoder.finish(&mut sink);
    assert_eq!(explained, given);
}

fn check_frame(explanation: &Explanation, frame: &Frame) {
    assert_eq!((explanation.octets.as_slice(), explanation.id), (frame.octets(), Some(frame.id())));
    check_cover(&explanation.fields, 0, explanation.octets.len());
    assert!(!explanation.line().contains('\n'));
    let text = explanation.to_string();
    assert!(text.len() <= 40_000, "{frame} makes {}", text.len());
}

fn check_explanation(explanation: &Explanation) {
    let octets = &explanation.octets;
    assert!(!octets.is_empty());
    check_cover(&explanation.fields, 0, octets.len());
    assert!(!explanation.summary.contains('\n'));
    // A word of 16 bits has at most 17 fields; each takes a line, and the names in it are as long as the longest.
    let text = explanation.to_string();
    assert!(text.len() <= 4_000 + octets.len() * 800, "{} octets make {}", octets.len(), text.len());
    let valid = explanation.mark() != Mark::Invalid;
    if matches!(explanation.kind, Kind::Telegram | Kind::Token) && valid {
        let Decoded::Telegram { telegram, len } = decode(octets) else {
            panic!("{octets:02X?} is no telegram")
        };
        assert_eq!(len, octets.len());
        let mut buf = [0; 255];
        assert_eq!(telegram.encode(&mut buf).expect("what was decoded can be encoded"), octets);
    }
}

/// Fields of octets lie beside each other from `at` on, fields of bits from the highest to bit 0.
fn check_cover(fields: &[Field], at: usize, len: usize) {
    let mut next = at;
    let mut above = None;
    for field in fields {
        match field.bits {
            Some(bits) => {
                assert_eq!((field.at, field.len), (at, len), "{field:?}");
                assert_eq!(above.unwrap_or(len * 8), usize::from(bits.high) + 1, "{field:?}");
                above = Some(usize::from(bits.low));
            }
            None => {
                assert_eq!(field.at, next, "{field:?}");
                next += field.len;
            }
        }
        if !field.fields.is_empty() {
            check_cover(&field.fields, field.at, field.len);
        }
    }
    match above {
        Some(lowest) => assert_eq!(lowest, 0),
        None => assert_eq!(next, at + len),
    }
}
