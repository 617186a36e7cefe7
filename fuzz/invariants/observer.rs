//! What a judge hears of a master and its slaves, in any order: it never stops, a row that fails shows a telegram, and the
//! same recording is judged the same again.
//!
//! ```text
//! what is known (1): bit 0 station 5 is configured, bit 1 its watchdog, bit 2 retries, bit 3 slot, bit 4 interval, bit 5 master
//! then   who (1): 00..=7f the master, 80..=bf a station, c0.. nobody knows; microseconds (2), length (1), octets
//!        who with bit 4: a telegram of the master is built, not taken as it is: DA, SA, FC, SAP or 00, data
//! ```

use std::time::Duration;

use profidrive::judge::{Recording, Row, Setup, Slave, Verdict};
use profidrive::profibus::fdl::Address;
use profidrive::time::Instant;

pub(crate) fn check(data: &[u8]) {
    let Some((&known, steps)) = data.split_first() else { return };
    let report = judged(known, steps);
    for judged in &report.judgements {
        let shown = judged.verdict != Verdict::Fail || !judged.telegrams.is_empty();
        assert!(shown, "{:?} fails and shows no telegram", judged.row);
    }
    if data.len().is_multiple_of(16) {
        let verdicts = |report: profidrive::judge::Report| {
            report.judgements.into_iter().map(|judged| (judged.verdict, judged.reason)).collect::<Vec<_>>()
        };
        assert_eq!(verdicts(report), verdicts(judged(known, steps)), "judged the same again");
    }
}

fn judged(known: u8, mut steps: &[u8]) -> profidrive::judge::Report {
    let is = |bit: u8| known >> bit & 1 == 1;
    let mut setup = Setup::default();
    if is(0) {
        setup.stations.push(Slave::new(Address::from_octet(5), 0x1234, vec![0x23, 0x13]));
    }
    setup.watchdog = is(1).then(|| Duration::from_millis(100));
    setup.retries = is(2).then_some(1);
    setup.slot = is(3).then(|| Duration::from_micros(400));
    setup.min_interval = is(4).then(|| Duration::from_millis(1));
    setup.master = is(5).then(|| Address::from_octet(2));
    let mut recording = Recording::new(setup);
    let mut now = Instant::ZERO;
    while let Some(([who, high, low, length], rest)) = steps.split_first_chunk() {
        now = now.saturating_add(Duration::from_micros(u16::from_be_bytes([*high, *low]).into()));
        let (octets, rest) = rest.split_at(usize::from(*length).min(rest.len()));
        steps = rest;
        let from_master = match who {
            0..=0x7F => Some(true),
            0x80..=0xBF => Some(false),
            0xC0..=0xFF => None,
        };
        if who & 0x10 == 0 {
            recording.take(now, octets, from_master);
        } else {
            recording.take(now, &framed(octets), from_master);
        }
    }
    recording.report(Row::ALL)
}

/// The octets with start, length, checksum and end: fuzzers do not find these.
fn framed(octets: &[u8]) -> Vec<u8> {
    let octets = &octets[..octets.len().min(249)];
    let sum = octets.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    let length = u8::try_from(octets.len()).expect("249 at most");
    let mut telegram = match octets.len() {
        0 => return vec![0xE5],
        2 => return [&[0xDC], octets].concat(),
        3 => vec![0x10],
        _ => vec![0x68, length, length, 0x68],
    };
    telegram.extend_from_slice(octets);
    telegram.extend([sum, 0x16]);
    telegram
}
