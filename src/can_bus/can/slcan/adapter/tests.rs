use proptest::prelude::*;

use super::*;
use crate::can_bus::can::{Frame, Id};

/// What the master reads, and what reaches the bus.
fn play(adapter: &mut Adapter, octets: &[u8]) -> (Vec<u8>, Vec<Effect>) {
    let (mut read, mut effects) = (Vec::new(), Vec::new());
    for octet in octets {
        if let Some(reaction) = adapter.handle_octet(*octet, true) {
            read.extend_from_slice(reaction.answer.as_octets());
            effects.extend(reaction.effect);
            assert_eq!(reaction.answer == Answer::REFUSED, reaction.refusal.is_some());
        }
    }
    (read, effects)
}

fn read(adapter: &mut Adapter, octets: &[u8]) -> Vec<u8> {
    play(adapter, octets).0
}

fn opened() -> Adapter {
    let mut adapter = Adapter::new();
    assert_eq!(read(&mut adapter, b"O\r"), b"\r");
    adapter
}

#[test]
fn a_session_of_python_can() {
    let mut adapter = Adapter::new();
    let (answers, effects) = play(&mut adapter, b"C\rS6\r\rO\rO\rt00020105\rC\r");
    assert_eq!(answers, b"\r\r\r\r\rz\r\r");
    let frame = Frame::with(Id::base(0).unwrap(), [1, 5]);
    assert_eq!(
        effects,
        [
            Effect::Channel(Channel::Closed),
            Effect::Rate(BusTiming::Standard(6)),
            Effect::Channel(Channel::Open),
            Effect::Channel(Channel::Open),
            Effect::Transmit(frame),
            Effect::Channel(Channel::Closed),
        ]
    );
}

#[test]
fn frames_are_answered_by_their_kind() {
    let mut adapter = opened();
    assert_eq!(read(&mut adapter, b"t1230\rr1230\rT000001230\rR000001230\r"), b"z\rz\rZ\rZ\r");
    assert_eq!(read(&mut adapter, b"t123900\rt12320\rT123\r\r"), b"\x07\x07\x07\r");
}

#[test]
fn what_the_channel_allows() {
    // Line, then the answers while closed, open, listening only.
    let table: [(&[u8], [&[u8]; 3]); 6] = [
        (b"S6\r", [b"\r", b"\x07", b"\x07"]),
        (b"s031C\r", [b"\r", b"\x07", b"\x07"]),
        (b"t1230\r", [b"\x07", b"z\r", b"\x07"]),
        (b"R000001230\r", [b"\x07", b"Z\r", b"\x07"]),
        (b"V\r", [b"V1010\r", b"V1010\r", b"V1010\r"]),
        (b"Z1\r", [b"\r", b"\r", b"\r"]),
    ];
    for (line, answers) in table {
        for (before, answer) in [&b"C\r"[..], b"O\r", b"L\r"].iter().zip(answers) {
            let mut adapter = Adapter::new();
            read(&mut adapter, before);
            assert_eq!(
                read(&mut adapter, line),
                answer,
                "{} after {}",
                line.escape_ascii(),
                before.escape_ascii()
            );
        }
    }
}

#[test]
fn what_an_adapter_tells_of_itself() {
    let mut adapter = Adapter::new();
    assert_eq!(read(&mut adapter, b"V\rv\rN\rF\r"), b"V1010\rv1010\rNPD01\rF00\r");
    adapter.raise(Flags::BUS_ERROR.with(Flags::OVERRUN).with(Flags::PASSIVE));
    assert_eq!(read(&mut adapter, b"F\rF\r"), b"FA8\rF00\r", "reading clears");
}

#[test]
fn frames_of_the_bus_reach_a_master_that_is_open() {
    let frame = Frame::with(Id::base(0x705).unwrap(), [0x7F]);
    let mut adapter = Adapter::new();
    let now = Instant::from_millis(258);
    assert!(adapter.frame(now, &frame).is_none());
    for (line, expected) in [
        (&b"O\r"[..], &b"t70517F\r"[..]),
        (b"L\r", b"t70517F\r"),
        (b"Z1\r", b"t70517F0102\r"),
        (b"Z0\r", b"t70517F\r"),
    ] {
        read(&mut adapter, line);
        assert_eq!(adapter.frame(now, &frame).unwrap().as_octets(), expected);
    }
    read(&mut adapter, b"C\r");
    assert!(adapter.frame(now, &frame).is_none());
}

#[test]
fn a_frame_without_room_is_refused_and_flagged() {
    let mut adapter = opened();
    let mut answers = Vec::new();
    for octet in b"t1230\r\n" {
        answers
            .extend(adapter.handle_octet(*octet, false).map(|reaction| (reaction.answer, reaction.refusal)));
    }
    assert_eq!(answers, [(Answer::REFUSED, Some(Refusal::Full))]);
    assert_eq!(read(&mut adapter, b"F\r"), b"F02\r");
}

#[test]
fn line_feeds_mean_nothing() {
    let mut adapter = Adapter::new();
    assert_eq!(read(&mut adapter, b"\nO\r\n\nt12\n31\n0A\r\n"), b"\rz\r");
}

#[test]
fn noise_and_a_line_of_10_kb_are_refused_once_and_the_next_line_works() {
    let mut adapter = opened();
    assert_eq!(play(&mut adapter, &[b'0'; 10_000]), (Vec::new(), Vec::new()));
    assert_eq!(read(&mut adapter, b"\rt1230\r"), b"\x07z\r");
    let noise: Vec<u8> = (0..=255).filter(|octet| *octet != CR).cycle().take(10_000).collect();
    assert_eq!(play(&mut adapter, &noise), (Vec::new(), Vec::new()));
    assert_eq!(read(&mut adapter, b"\rt1230\r"), b"\x07z\r");
    // The longest command, and one more character.
    assert_eq!(read(&mut adapter, b"T000001238AABBCCDDEEFF0011\r"), b"Z\r");
    assert_eq!(read(&mut adapter, b"T000001238AABBCCDDEEFF00110\r"), b"\x07");
}

#[test]
fn half_a_line_of_a_master_that_left_is_forgotten() {
    let mut adapter = opened();
    read(&mut adapter, b"t123");
    adapter.break_line();
    assert_eq!(read(&mut adapter, b"F\r"), b"F00\r");
}

proptest! {
    #[test]
    fn each_line_gets_one_answer_whatever_it_is(
        lines in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..40), 0..20)
    ) {
        let mut adapter = Adapter::new();
        for line in lines {
            let line: Vec<u8> = line.into_iter().filter(|octet| *octet != CR).collect();
            prop_assert_eq!(play(&mut adapter, &line).0.len(), 0);
            let (answer, _) = play(&mut adapter, b"\r");
            prop_assert!(answer == b"\x07" || answer.iter().filter(|octet| **octet == CR).count() == 1);
        }
    }
}
