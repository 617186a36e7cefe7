use proptest::prelude::*;

use super::*;
use crate::profibus::fdl::Address;
use crate::profibus::fdl::telegram::tests::any_data_telegram;

const STATUS_5: [u8; 6] = [0x10, 5, 2, 0x49, 0x50, 0x16];
const STATUS_6: [u8; 6] = [0x10, 6, 2, 0x49, 0x51, 0x16];

/// What a framer says of a stream: telegrams as their octets, refusals as they are.
#[derive(Debug, PartialEq, Eq)]
enum Heard {
    Telegram(Vec<u8>),
    Refused(FrameError),
}

fn hear(framer: &mut Framer, now: Instant, octets: &[u8]) -> Vec<Heard> {
    let mut heard = Vec::new();
    framer.handle_bytes(now, octets, |_, result| heard.push(noted(result)));
    heard
}

fn hear_timeout(framer: &mut Framer, now: Instant) -> Vec<Heard> {
    let mut heard = Vec::new();
    framer.handle_timeout(now, |_, result| heard.push(noted(result)));
    heard
}

fn noted(result: Result<Telegram<'_>, FrameError>) -> Heard {
    match result {
        Ok(telegram) => Heard::Telegram(telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()),
        Err(error) => Heard::Refused(error),
    }
}

fn telegram(octets: &[u8]) -> Heard {
    Heard::Telegram(octets.to_vec())
}

#[test]
fn two_telegrams_in_one_read_are_two_telegrams() {
    let mut framer = Framer::new(Resync::SCAN);
    let both = [STATUS_5, STATUS_6].concat();
    assert_eq!(hear(&mut framer, Instant::ZERO, &both), [telegram(&STATUS_5), telegram(&STATUS_6)]);
    assert_eq!(framer.poll_timeout(), None);
}

#[test]
fn scanning_finds_the_telegram_behind_each_kind_of_noise() {
    for noise in
        [&[0x00][..], &[0x16, 0xFF, 0x68, 0x03], &[0x68, 0x68, 0x68], &[0x10, 0x00, 0x00, 0x00, 0x00, 0x01]]
    {
        let mut framer = Framer::new(Resync::SCAN);
        let heard = hear(&mut framer, Instant::ZERO, &[noise, &STATUS_5].concat());
        assert_eq!(heard.last(), Some(&telegram(&STATUS_5)), "{noise:02X?}");
    }
}

#[test]
fn scanning_gives_up_an_unfinished_telegram_and_finds_the_one_behind_its_start() {
    let mut framer = Framer::new(Resync::Scan(Duration::from_millis(50)));
    let start = Instant::from_millis(1);
    assert_eq!(hear(&mut framer, start, &[&[0xA2][..], &STATUS_5].concat()), []);
    let timeout = framer.poll_timeout().unwrap();
    assert_eq!(timeout, Instant::from_millis(51));
    assert_eq!(hear_timeout(&mut framer, Instant::from_millis(50)), []);
    assert_eq!(
        hear_timeout(&mut framer, timeout),
        [Heard::Refused(FrameError::BrokenOff { octets: 7 }), telegram(&STATUS_5)]
    );
    assert_eq!(framer.poll_timeout(), None);
}

#[test]
fn after_an_invalid_telegram_the_idle_rule_hears_nothing_until_the_line_was_silent() {
    let baud = BaudRate::K500;
    let mut framer = Framer::new(Resync::Idle(baud));
    // A damaged SD2 whose data hold a correct FDL status request to station 5.
    let mut damaged = vec![0x68, 9, 9, 0x68, 7, 2, 0x7D];
    damaged.extend(STATUS_5);
    damaged.extend([0x00, 0x16]);
    let mut now = Instant::from_millis(10);
    assert!(matches!(hear(&mut framer, now, &damaged)[..], [Heard::Refused(FrameError::Checksum { .. })]));
    // 32 bit times of silence are too few, whatever comes.
    now = now.saturating_add(baud.bit_times(32)).saturating_add(baud.octet_times(6));
    assert_eq!(hear(&mut framer, now, &STATUS_5), []);
    now = now.saturating_add(baud.bit_times(33)).saturating_add(baud.octet_times(6));
    assert_eq!(hear(&mut framer, now, &STATUS_5), [telegram(&STATUS_5)]);
}

#[test]
fn scanning_does_not_answer_a_telegram_hidden_in_a_damaged_sd2() {
    let mut framer = Framer::new(Resync::SCAN);
    let mut damaged = vec![0x68, 9, 9, 0x68, 7, 2, 0x7D];
    damaged.extend(STATUS_5);
    damaged.extend([0x00, 0x16]);
    damaged.extend(STATUS_6);
    let heard = hear(&mut framer, Instant::ZERO, &damaged);
    assert!(matches!(heard[..], [Heard::Refused(FrameError::Checksum { .. }), Heard::Telegram(_)]));
    assert_eq!(heard[1], telegram(&STATUS_6));
}

#[test]
fn scanning_does_not_answer_a_telegram_hidden_in_a_damaged_sd3() {
    let mut framer = Framer::new(Resync::SCAN);
    let mut damaged = vec![0xA2, 5, 2, 0x6D];
    damaged.extend(STATUS_5);
    damaged.extend([0x00, 0x00, 0x3B, 0x16]);
    damaged.extend(STATUS_6);
    let heard = hear(&mut framer, Instant::ZERO, &damaged);
    assert!(
        matches!(heard[..], [Heard::Refused(FrameError::Checksum { .. }), Heard::Telegram(_)]),
        "{heard:?}"
    );
    assert_eq!(heard[1], telegram(&STATUS_6));
}

#[test]
fn a_damaged_telegram_is_one_refusal_and_so_is_a_row_of_noise() {
    let damaged_sd1 = [0x10, 5, 2, 0x49, 0x51, 0x16];
    let damaged_sd2 = [0x68, 5, 5, 0x68, 5, 2, 0x5D, 0x10, 0x68, 0xDD, 0x17];
    for (octets, expected) in [
        (damaged_sd1.to_vec(), 1),
        (damaged_sd2.to_vec(), 1),
        (vec![0x00; 1000], 1),
        ([damaged_sd1, damaged_sd1].concat(), 2),
        ([&damaged_sd1[..], &damaged_sd2, &damaged_sd1].concat(), 3),
        ([&[0x00; 5][..], &damaged_sd1, &[0x00; 5]].concat(), 2),
        ([&damaged_sd1[..], &STATUS_5, &damaged_sd1].concat(), 2),
    ] {
        let mut framer = Framer::new(Resync::SCAN);
        let mut heard = hear(&mut framer, Instant::ZERO, &octets);
        heard.extend(hear_timeout(&mut framer, Instant::from_millis(50)));
        let refused = heard.iter().filter(|heard| matches!(heard, Heard::Refused(_))).count();
        assert_eq!(refused, expected, "{octets:02X?}: {heard:?}");
        let again = hear(&mut framer, Instant::from_millis(200), &[0x00]);
        assert_eq!(again.len(), 1, "noise behind a silence is news");
    }
}

#[test]
fn the_idle_rule_ends_an_unfinished_telegram() {
    let baud = BaudRate::K19_2;
    let mut framer = Framer::new(Resync::Idle(baud));
    let start = Instant::from_millis(5);
    assert_eq!(hear(&mut framer, start, &STATUS_5[..4]), []);
    let timeout = start.saturating_add(baud.bit_times(33));
    assert_eq!(framer.poll_timeout(), Some(timeout));
    assert_eq!(hear_timeout(&mut framer, timeout), [Heard::Refused(FrameError::BrokenOff { octets: 4 })]);
    let later = timeout.saturating_add(baud.octet_times(6));
    assert_eq!(hear(&mut framer, later, &STATUS_5), [telegram(&STATUS_5)]);
}

#[test]
fn clearing_forgets_the_unfinished_telegram() {
    let mut framer = Framer::new(Resync::SCAN);
    assert_eq!(hear(&mut framer, Instant::ZERO, &STATUS_5[..3]), []);
    framer.clear();
    assert_eq!(hear(&mut framer, Instant::ZERO, &STATUS_5), [telegram(&STATUS_5)]);
}

#[test]
fn a_short_acknowledge_and_a_token_are_telegrams() {
    let mut framer = Framer::new(Resync::SCAN);
    let mut kinds = Vec::new();
    framer.handle_bytes(Instant::ZERO, &[0xE5, 0xDC, 2, 3], |_, result| {
        kinds.push(match result.unwrap() {
            Telegram::ShortAcknowledge => 1,
            Telegram::Token { da, sa } if (da, sa) == (Address::from_octet(2), Address::from_octet(3)) => 4,
            Telegram::Token { .. } | Telegram::Data(_) => 0,
        });
    });
    assert_eq!(kinds, [1, 4]);
}

/// Telegrams and noise in any order.
fn stream() -> impl Strategy<Value = Vec<u8>> {
    let part = prop_oneof![
        3 => any_data_telegram(),
        1 => proptest::collection::vec(any::<u8>(), 0..20),
        1 => Just(vec![0xE5]),
        1 => Just(vec![0xDC, 2, 3]),
        1 => (any_data_telegram(), any::<prop::sample::Index>(), any::<u8>()).prop_map(|(mut octets, at, value)| {
            let at = at.index(octets.len());
            octets[at] = value;
            octets
        }),
    ];
    proptest::collection::vec(part, 0..6).prop_map(|parts| parts.concat())
}

proptest! {
    #[test]
    fn the_same_octets_cut_anywhere_are_the_same_telegrams(
        stream in stream(),
        cuts in proptest::collection::vec(1usize..40, 0..60),
        idle: bool,
    ) {
        let resync = if idle { Resync::Idle(BaudRate::K500) } else { Resync::SCAN };
        let now = Instant::from_millis(1);
        let whole = hear(&mut Framer::new(resync), now, &stream);
        let mut framer = Framer::new(resync);
        let mut heard = Vec::new();
        let mut rest = stream.as_slice();
        for cut in cuts.into_iter().chain(core::iter::repeat(1)) {
            if rest.is_empty() {
                break;
            }
            let (chunk, behind) = rest.split_at(cut.min(rest.len()));
            heard.extend(hear(&mut framer, now, chunk));
            rest = behind;
        }
        prop_assert_eq!(heard, whole);
    }
}

#[test]
fn f_06_an_octet_with_wrong_parity_ends_its_telegram_under_both_rules() {
    for at in 0..STATUS_5.len() {
        let baud = BaudRate::K500;
        let time = |octets: usize| {
            Instant::from_millis(1).saturating_add(baud.octet_times(u32::try_from(octets).unwrap()))
        };
        let next =
            time(STATUS_5.len()).saturating_add(baud.bit_times(33)).saturating_add(baud.octet_times(6));
        for resync in [Resync::Idle(baud), Resync::SCAN] {
            let mut framer = Framer::new(resync);
            assert_eq!(hear(&mut framer, time(at), &STATUS_5[..at]), []);
            let mut heard = Vec::new();
            framer.handle_damaged(time(at + 1), |_, result| heard.push(noted(result)));
            assert_eq!(heard, [Heard::Refused(FrameError::Parity)]);
            let rest = hear(&mut framer, time(STATUS_5.len()), &STATUS_5[at + 1..]);
            assert!(!rest.iter().any(|heard| matches!(heard, Heard::Telegram(_))), "{rest:?}");
            if resync == Resync::Idle(baud) {
                assert_eq!(rest, [], "wait_for_idle until the line was idle");
                assert_eq!(hear(&mut framer, next, &STATUS_6), [telegram(&STATUS_6)]);
            }
        }
    }
}
