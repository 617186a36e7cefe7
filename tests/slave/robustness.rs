//! Damaged telegrams, noise and any cutting of the octets (`dp-v0.md` 13: F).

use std::time::Duration;

use profidrive::devices::ag03::drive::Inputs;
use profidrive::devices::ag03::profibus::{Config, DESCRIPTION, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::profibus::dp::State;
use profidrive::profibus::fdl::Address;
use profidrive::time::Instant;
use proptest::prelude::*;

use crate::drive_line;
use crate::drive_line::{Line, MASTER, Reply, hex};

/// Requests of all kinds to station 5, each of which is answered or has an effect.
const REQUESTS: [&str; 9] = [
    "10 05 02 49 50 16",
    "68 05 05 68 85 82 6D 3C 3E EE 16",
    "68 0C 0C 68 85 82 6D 3D 3E 80 01 01 0B 0A C5 00 4B 16",
    "68 07 07 68 85 82 6D 3E 3E F3 F2 D5 16",
    "68 05 05 68 85 82 6D 3B 3E ED 16",
    "68 11 11 68 05 02 6D 00 00 00 00 00 00 00 00 00 0B 00 00 00 00 7F 16",
    "68 07 07 68 FF 82 46 3A 3E 02 00 41 16",
    "A2 85 82 6D 3E 3E F3 F2 00 00 00 00 D5 16",
    "10 05 02 6D 74 16",
];

#[test]
fn f_03_f_04_f_05_no_damaged_request_is_answered_or_has_an_effect() {
    for request in REQUESTS {
        let whole = hex(request);
        let mut line = Line::new();
        line.start_up_with(&[0x88, 1, 255, 11, 0x0A, 0xC5, 0]);
        let before = line.diagnosis(MASTER);
        let check = |octets: &[u8], what: &str| {
            let mut line = line.clone();
            assert_eq!(line.send(octets), None, "{request}: {what}");
            line.wait(Duration::from_millis(60));
            assert_eq!(line.device.dp_state(), State::DataExch, "{request}: {what}");
            line.request(MASTER, Some(59), &[]);
            assert_eq!(line.diagnosis(MASTER), before, "{request}: {what}");
        };
        for len in 0..whole.len() {
            check(&whole[..len], &format!("first {len} octets"));
        }
        for bit in 0..whole.len() * 8 {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            check(&damaged, &format!("bit {bit} flipped"));
        }
    }
}

#[test]
fn f_05_lengths_that_no_telegram_has_are_refused_although_everything_else_fits() {
    // LE and LEr agree, both are 68, FCS and ED fit.
    let sd2 = |le: u8, body: &[u8]| {
        let fcs = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
        [&[0x68, le, le, 0x68], body, &[fcs, 0x16]].concat()
    };
    let slave_diag = [0x85, 0x82, 0x6D, 60, 62];
    let mut longest = [0x85, 0x82, 0x6D, 61, 62].to_vec();
    longest.resize(249, 0x40);
    let mut longer = longest.clone();
    longer.push(0x40);
    for (octets, what) in [
        (sd2(3, &[0x05, 0x02, 0x49]), "LE 3: an SD1 in the form of SD2"),
        (sd2(3, &[0x05, 0x02, 0x6D]), "LE 3: Data_Exchange"),
        (sd2(250, &longer), "LE 250"),
        ([&[0x68, 5, 6, 0x68], &slave_diag[..], &[0xEE, 0x16]].concat(), "LEr is not LE"),
        ([&[0x68, 5, 5, 0x10], &slave_diag[..], &[0xEE, 0x16]].concat(), "the fourth octet is not 68"),
    ] {
        let mut line = Line::new();
        line.start_up();
        let before = line.diagnosis(MASTER);
        assert_eq!(line.send(&octets), None, "{what}");
        line.wait(Duration::from_millis(60));
        assert_eq!(line.diagnosis(MASTER), before, "{what}");
    }
    let mut line = Line::new();
    assert!(line.send(&sd2(5, &slave_diag)).is_some(), "the same with its length is answered");
    assert_eq!(line.send(&sd2(249, &longest)), Some(vec![0xE5]), "LE 249");
}

#[test]
fn f_03_a_damaged_telegram_of_the_owner_does_not_feed_the_watchdog() {
    // Slave_Diag and a Chk_Cfg in SD3, whole and with a wrong checksum.
    for (octets, alive) in [
        ("68 05 05 68 85 82 6D 3C 3E EE 16", true),
        ("68 05 05 68 85 82 6D 3C 3E EF 16", false),
        ("A2 85 82 6D 3E 3E F3 F2 00 00 00 00 D6 16", false),
        ("10 05 02 6D 75 16", false),
    ] {
        let mut line = Line::new();
        line.start_up_with(&[0x88, 1, 10, 11, 0x0A, 0xC5, 0]);
        for _ in 0..4 {
            line.wait(Duration::from_millis(60));
            assert_eq!(line.send(&hex(octets)).is_some(), alive, "{octets}");
        }
        let expected = if alive { State::DataExch } else { State::WaitPrm };
        assert_eq!(line.device.dp_state(), expected, "{octets}");
    }
}

#[test]
fn f_07_f_09_noise_before_a_request_with_idle_time_between() {
    for noise in ["10", "68", "A2", "DC", "E5", "10 05 02 49 51 16", "68 F9 F9 68 00 00", "16 16 FF 00"] {
        for baud in DESCRIPTION.rates.iter() {
            let mut line = Line::at(baud);
            assert_eq!(line.send(&hex(noise)), None, "{noise}");
            let reply = line.send(&hex("10 05 02 49 50 16"));
            assert_eq!(reply, Some(hex("10 02 05 00 07 16")), "{noise} at {baud}");
        }
    }
}

#[test]
fn f_22_our_own_echo_is_not_answered() {
    let mut line = Line::new();
    let reply = line.send(&hex("68 05 05 68 85 82 6D 3C 3E EE 16")).unwrap();
    assert_eq!(line.send(&reply), None);
    assert_eq!(line.send(&hex("E5")), None);
}

#[test]
fn f_21_the_longest_requests_are_handled() {
    let mut line = Line::new();
    assert_eq!(line.request(MASTER, Some(61), &[0x80; 244]), Reply::Sc);
    assert_eq!(line.request(MASTER, Some(60), &[0; 244]), drive_line::RR);
    assert_eq!(line.request(MASTER, None, &[0; 246]), drive_line::RS);
}

#[test]
fn a_long_sleep_of_the_host_neither_hangs_nor_travels() {
    let mut line = Line::new();
    line.start_up();
    for stw in [0x0B, 0x3B, 0x7B] {
        line.exchange(&[0, 0, 0, 0, 0, 0, 0, 0, 0, stw, 0x00, 0x0F, 0x00, 0x00]);
        line.wait(Duration::from_millis(2));
    }
    let decades = Instant::from_nanos(u64::MAX / 2);
    line.device.handle_timeout(decades);
    let travelled = line.device.status().position;
    // 60 s at 800 inc/s and no more.
    assert!((40_000..50_000).contains(&travelled), "{travelled}");
    assert!(line.device.poll_timeout().is_some_and(|due| due > decades));
    line.device.handle_timeout(Instant::ZERO);
}

/// Feeds octets in chunks at one instant and collects the reply and what the drive is then.
fn replies(octets: &[u8], cuts: &[usize], timing: Timing) -> (Option<Vec<u8>>, State) {
    let now = Instant::from_millis(5);
    let mut device =
        Device::new(Config { timing, ..Config::new(Address::station(5).unwrap()) }, Instant::ZERO);
    let mut rest = octets;
    for cut in cuts.iter().copied().chain(std::iter::repeat(usize::MAX)) {
        let (chunk, behind) = rest.split_at(cut.min(rest.len()));
        device.handle_bytes(now, chunk);
        rest = behind;
        if rest.is_empty() {
            break;
        }
    }
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let later = now.saturating_add(Duration::from_micros(100));
    (device.poll_transmit(later, &mut buf).map(<[u8]>::to_vec), device.dp_state())
}

fn stream() -> impl Strategy<Value = Vec<u8>> {
    let part = prop_oneof![
        6 => (0..REQUESTS.len()).prop_map(|at| hex(REQUESTS[at])),
        1 => proptest::collection::vec(any::<u8>(), 0..30),
        1 => ((0..REQUESTS.len()), any::<prop::sample::Index>(), any::<u8>()).prop_map(|(request, at, octet)| {
            let mut octets = hex(REQUESTS[request]);
            let at = at.index(octets.len());
            octets[at] = octet;
            octets
        }),
    ];
    proptest::collection::vec(part, 1..8).prop_map(|parts| parts.concat())
}

proptest! {
    #[test]
    fn f_08_the_same_octets_cut_anywhere_get_the_same_reply(
        octets in stream(),
        cuts in proptest::collection::vec(1usize..30, 0..80),
        truthful: bool,
    ) {
        let timing = if truthful { Timing::True } else { Timing::Untrue };
        prop_assert_eq!(replies(&octets, &cuts, timing), replies(&octets, &[], timing));
    }

    #[test]
    fn f_08_a_session_cut_anywhere_gets_the_same_replies(
        cuts in proptest::collection::vec(1usize..10, 0..40),
    ) {
        let session = |cuts: &[usize]| {
            let config = Config { timing: Timing::Untrue, ..Config::new(Address::station(5).unwrap()) };
            let mut device = Device::new(config, Instant::ZERO);
            let mut buf = [0; MAX_TELEGRAM_LEN];
            let mut replies = Vec::new();
            let mut cuts = cuts.iter().copied();
            for (number, request) in REQUESTS.iter().enumerate() {
                let mut now = Instant::from_millis(10 * number as u64);
                let octets = hex(request);
                let mut rest = octets.as_slice();
                while !rest.is_empty() {
                    let (chunk, behind) = rest.split_at(cuts.next().unwrap_or(usize::MAX).min(rest.len()));
                    device.handle_bytes(now, chunk);
                    now = now.saturating_add(Duration::from_micros(10));
                    rest = behind;
                }
                now = now.saturating_add(Duration::from_millis(1));
                device.handle_timeout(now);
                replies.push(device.poll_transmit(now, &mut buf).map(<[u8]>::to_vec));
            }
            replies
        };
        prop_assert_eq!(session(&cuts), session(&[]));
    }

    #[test]
    fn f_23_random_octets_never_panic_and_never_grow_the_time_asked_for(
        chunks in proptest::collection::vec((proptest::collection::vec(any::<u8>(), 0..300), 0u64..100_000_000), 0..20),
        truthful: bool,
    ) {
        let timing = if truthful { Timing::True } else { Timing::Untrue };
        let mut device = Device::new(Config { timing, ..Config::new(Address::station(5).unwrap()) }, Instant::ZERO);
        let mut now = Instant::ZERO;
        let mut buf = [0; MAX_TELEGRAM_LEN];
        for (octets, pause) in chunks {
            now = now.saturating_add(Duration::from_nanos(pause));
            device.handle_bytes(now, &octets);
            while device.poll_transmit(now, &mut buf).is_some() {}
            while device.poll_event().is_some() {}
            prop_assert!(device.poll_timeout().is_none_or(|due| due > now));
        }
        // The next request after silence is answered.
        now = now.saturating_add(Duration::from_millis(100));
        device.handle_timeout(now);
        device.handle_bytes(now, &hex("10 05 02 49 50 16"));
        now = now.saturating_add(Duration::from_micros(50));
        prop_assert_eq!(device.poll_transmit(now, &mut buf).map(<[u8]>::to_vec), Some(hex("10 02 05 00 07 16")));
    }
}

proptest! {
    #![proptest_config(crate::long::cases(48, 20))]

    #[test]
    fn a_drive_part_that_sleeps_is_like_one_that_runs(
        exchanges in proptest::collection::vec(
            (
                prop_oneof![Just(0x0000_u16), Just(0x000B), Just(0x003B), Just(0x007B), Just(0x005B), any::<u16>()],
                prop_oneof![-5000..5000_i32, any::<i32>()],
                prop_oneof![
                    Just([0; 8]),
                    Just([0x14, 0x0C, 0, 0, 0, 0, 0, 0]),
                    Just([0x13, 0xFC, 0, 0, 0, 0, 0, 0]),
                    Just([0x33, 0xF8, 0, 0, 0, 0, 0x07, 0xD0]),
                    Just([0x23, 0xA2, 0, 0, 0, 0, 0, 1]),
                    Just([0x23, 0xCA, 0, 0, 0, 0, 0, 5]),
                ],
                0u64..2_000,
            ),
            1..20,
        ),
    ) {
        let mut sleeping = Line::new();
        sleeping.start_up();
        let mut running = sleeping.clone();
        for (stw, setpoint, pkw, pause) in exchanges {
            let mut outputs = [0; 14];
            outputs[..8].copy_from_slice(&pkw);
            outputs[8..10].copy_from_slice(&stw.to_be_bytes());
            outputs[10..].copy_from_slice(&setpoint.to_be_bytes());
            prop_assert_eq!(sleeping.exchange(&outputs), running.exchange(&outputs));
            sleeping.wait(Duration::from_millis(pause));
            for _ in 0..pause {
                // Setting the same inputs again keeps the drive part awake.
                running.device.set_inputs(running.now, Inputs::default());
                running.wait(Duration::from_millis(1));
            }
            prop_assert_eq!(sleeping.device.status(), running.device.status());
        }
    }
}
