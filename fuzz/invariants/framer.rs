//! A stream of octets in chunks with pauses: any cutting gives the same telegrams and refusals, each octet belongs to
//! at most one telegram, and the framer asks to be woken later than now.

use arbitrary::{Arbitrary, Unstructured};
use profidrive::fdl::{FrameError, Framer, Resync, Telegram};
use profidrive::time::{BaudRate, Instant};

#[derive(Arbitrary, Debug)]
struct Stream {
    idle: bool,
    rate: u8,
    bursts: Vec<Burst>,
}

/// Octets that arrive in one go for one listener and in pieces for another.
#[derive(Arbitrary, Debug)]
struct Burst {
    pause_micros: u32,
    octets: Vec<u8>,
    cuts: Vec<u8>,
}

#[derive(Debug, PartialEq)]
enum Heard {
    Telegram(Vec<u8>),
    Refused(FrameError),
}

pub(crate) fn check(data: &[u8]) {
    let Ok(stream) = Stream::arbitrary_take_rest(Unstructured::new(data)) else { return };
    let rate = BaudRate::ALL[usize::from(stream.rate) % BaudRate::ALL.len()];
    let resync = if stream.idle { Resync::Idle(rate) } else { Resync::SCAN };
    let (mut whole, mut cut) = (Framer::new(resync), Framer::new(resync));
    let mut now = Instant::ZERO;
    for burst in stream.bursts {
        now = Instant::from_nanos(now.as_nanos() + u64::from(burst.pause_micros) * 1_000);
        let mut heard_whole = Vec::new();
        whole.handle_timeout(now, |_, result| heard_whole.push(note(result)));
        let mut heard_cut = Vec::new();
        cut.handle_timeout(now, |_, result| heard_cut.push(note(result)));

        // Both begin when the first octet has come, so that the silence before is the same.
        let Some((first, octets)) = burst.octets.split_first() else { continue };
        for (framer, heard) in [(&mut whole, &mut heard_whole), (&mut cut, &mut heard_cut)] {
            framer.receive(now, &[*first], |at, result| {
                assert!(at <= now);
                heard.push(note(result));
            });
        }
        whole.receive(now, octets, |_, result| heard_whole.push(note(result)));
        let mut rest = octets;
        for piece in burst.cuts.iter().map(|piece| usize::from(*piece)).chain([usize::MAX]) {
            let (piece, behind) = rest.split_at(piece.min(rest.len()));
            cut.receive(now, piece, |_, result| heard_cut.push(note(result)));
            rest = behind;
        }
        let telegrams = heard_whole.iter().map(|heard| match heard {
            Heard::Telegram(octets) => octets.len(),
            Heard::Refused(_) => 0,
        });
        assert!(telegrams.sum::<usize>() <= burst.octets.len() + 254, "octets used twice");
        assert_eq!(heard_whole, heard_cut);
        assert_eq!(whole.poll_timeout(), cut.poll_timeout());
        assert!(whole.poll_timeout().is_none_or(|due| due > now));
    }
}

fn note(result: Result<Telegram<'_>, FrameError>) -> Heard {
    match result {
        Ok(telegram) => {
            let mut octets = [0; 255];
            Heard::Telegram(telegram.encode(&mut octets).expect("what was decoded can be encoded").to_vec())
        }
        Err(error) => Heard::Refused(error),
    }
}
