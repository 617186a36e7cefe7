//! The octets of a master at its slcan adapter: each line gets one answer, LF changes nothing, a frame goes out only if
//! it was answered and reads back as the line it came from, the channel follows O, L and C alone, and whatever came
//! before, the next line is obeyed.

use profidrive::can_bus::can::slcan::{Adapter, BEL, CR, Channel, Effect, FrameLine, LF, parse_frame};
use profidrive::time::Instant;

/// The first octet says when the bus has no room: before every so many lines.
pub(crate) fn check(data: &[u8]) {
    let Some((&scarce, octets)) = data.split_first() else { return };
    let (mut adapter, mut without_lf) = (Adapter::new(), Adapter::new());
    let (mut line, mut lines) = (Vec::new(), 0_u32);
    for &octet in octets {
        let room = scarce == 0 || lines % u32::from(scarce) != 0;
        let before = adapter.channel();
        let reaction = adapter.handle_octet(octet, room);
        let same = if octet == LF { None } else { without_lf.handle_octet(octet, room) };
        assert_eq!(reaction, same);
        assert_eq!(reaction.is_some(), octet == CR, "one answer to each line, and nothing else");
        let Some(reaction) = reaction else {
            line.extend(Some(octet).filter(|octet| *octet != LF));
            continue;
        };
        lines += 1;
        let answer = reaction.answer.as_octets();
        assert_eq!(answer == [BEL], reaction.refusal.is_some());
        assert!(answer == [BEL] || answer.iter().position(|octet| *octet == CR) == Some(answer.len() - 1));
        match reaction.effect {
            Some(Effect::Transmit(frame)) => {
                assert!(room && before == Channel::Open && reaction.refusal.is_none());
                assert_eq!(parse_frame(&line), Some(Ok(frame)));
                let again = FrameLine::new(&frame, None);
                assert!(again.as_octets().split_last().unwrap().1.eq_ignore_ascii_case(&line));
                assert_eq!(answer[0], if frame.id().is_extended() { b'Z' } else { b'z' });
                let heard = adapter.frame(Instant::ZERO, &frame).expect("open");
                assert!(heard.as_octets().starts_with(again.as_octets().split_last().unwrap().1));
            }
            Some(Effect::Channel(channel)) => {
                let expected = match &line[..] {
                    b"O" => Channel::Open,
                    b"L" => Channel::ListenOnly,
                    b"C" => Channel::Closed,
                    other => panic!("{other:?} switched the channel"),
                };
                assert_eq!((channel, adapter.channel()), (expected, expected));
            }
            Some(Effect::Rate(_)) => assert_eq!(before, Channel::Closed),
            None => assert_eq!(adapter.channel(), before),
        }
        line.clear();
    }
    adapter.handle_octet(CR, true);
    adapter.handle_octet(b'N', true);
    let serial = adapter.handle_octet(CR, true).expect("an answer");
    assert_eq!(serial.answer.as_octets(), b"NPD01\r");
}
