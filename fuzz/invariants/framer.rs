//! A stream of octets in chunks with pauses: any cutting gives the same telegrams and refusals, telegrams lie one
//! behind the other in the octets that came, the framer asks to be woken later than now and never holds more than
//! one telegram, and after silence it hears again.

use arbitrary::{Arbitrary, Unstructured};
use profidrive::profibus::fdl::telegram::{Decoded, MAX_TELEGRAM_LEN, decode};
use profidrive::profibus::fdl::{FrameError, Framer, Resync, Telegram};
use profidrive::time::{BaudRate, Instant};

use super::Octets;

#[derive(Arbitrary, Debug)]
struct Stream<'a> {
    idle: bool,
    rate: u8,
    bursts: Vec<Burst<'a>>,
}

/// Octets that arrive in one go for one listener and in pieces for another.
#[derive(Arbitrary, Debug)]
struct Burst<'a> {
    pause_micros: u32,
    octets: Octets<'a>,
    cuts: [u8; 4],
    /// One more octet comes with wrong parity.
    damaged: bool,
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
    let mut unheard = Vec::new();
    for burst in &stream.bursts {
        now = Instant::from_nanos(now.as_nanos() + u64::from(burst.pause_micros) * 1_000);
        let (mut heard_whole, mut heard_cut) = (Vec::new(), Vec::new());
        whole.handle_timeout(now, |_, result| heard_whole.push(note(result)));
        cut.handle_timeout(now, |_, result| heard_cut.push(note(result)));

        // Both begin when the first octet has come, so that the silence before is the same.
        if let Some((first, octets)) = burst.octets.0.split_first() {
            for (framer, heard) in [(&mut whole, &mut heard_whole), (&mut cut, &mut heard_cut)] {
                framer.handle_bytes(now, &[*first], |at, result| {
                    assert!(at <= now);
                    heard.push(note(result));
                });
            }
            whole.handle_bytes(now, octets, |_, result| heard_whole.push(note(result)));
            let mut rest = octets;
            for piece in burst.cuts.iter().map(|piece| usize::from(*piece)).chain([usize::MAX]) {
                let (piece, behind) = rest.split_at(piece.min(rest.len()));
                cut.handle_bytes(now, piece, |_, result| heard_cut.push(note(result)));
                rest = behind;
            }
        }
        unheard.extend_from_slice(burst.octets.0);
        if burst.damaged {
            whole.handle_damaged(now, |_, result| heard_whole.push(note(result)));
            cut.handle_damaged(now, |_, result| heard_cut.push(note(result)));
        }
        assert_eq!(heard_whole, heard_cut);
        for heard in &heard_whole {
            if let Heard::Telegram(octets) = heard {
                let at = unheard.windows(octets.len()).position(|window| window == octets);
                unheard.drain(..at.expect("octets used twice, or never heard") + octets.len());
            }
        }
        assert_eq!(whole.poll_timeout(), cut.poll_timeout());
        assert!(whole.poll_timeout().is_none_or(|due| due > now));
        let held = unheard.len().saturating_sub(MAX_TELEGRAM_LEN);
        unheard.drain(..held);
    }
    hears_again(&mut whole, stream.idle, now);
}

/// Whatever came before, a telegram after a second of silence is heard. Silence alone tells of no telegram where the
/// line can be trusted; a scan looks once more at the octets of a telegram that is broken off.
fn hears_again(framer: &mut Framer, idle: bool, now: Instant) {
    const REQUEST: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
    let now = Instant::from_nanos(now.as_nanos() + 1_000_000_000);
    framer.handle_timeout(now, |_, result| assert!(!idle || result.is_err(), "out of silence"));
    assert_eq!(framer.poll_timeout(), None);
    let mut heard = 0;
    framer.handle_bytes(now, &REQUEST, |_, result| {
        heard += 1;
        let Decoded::Telegram { telegram, .. } = decode(&REQUEST) else { unreachable!() };
        assert_eq!(result, Ok(telegram));
    });
    assert_eq!(heard, 1);
}

fn note(result: Result<Telegram<'_>, FrameError>) -> Heard {
    match result {
        Ok(telegram) => {
            let mut octets = [0; MAX_TELEGRAM_LEN];
            Heard::Telegram(telegram.encode(&mut octets).expect("what was decoded can be encoded").to_vec())
        }
        Err(error) => Heard::Refused(error),
    }
}
