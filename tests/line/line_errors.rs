//! A line full of errors, and octets of all kinds, on a simulated line that checks the rules of the bus all the time.
use core::sync::atomic::{AtomicU64, Ordering};
use std::sync::Arc;

use profidrive::bench::{Answer, Line, ScriptedMaster as Master};
use profidrive::devices::ag03::profibus::{Config, Device, Timing};
use profidrive::host::BusEvent;
use profidrive::profibus::dp::State;
use profidrive::profibus::fdl::ReplyStatus;
use profidrive::time::Instant;

use crate::mirror_slaves::{IDENT, SMALL, SMALL_LEN, address, inputs, line, long, mirror, outputs, start_up};

/// Numbers that look random and are the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

/// One error on the line: what any FCS and parity bit detect. Says which octet has wrong parity.
fn corrupt(random: &mut Random, octets: &mut Vec<u8>) -> Option<usize> {
    let at = random.below(octets.len());
    match random.below(5) {
        0 => octets[at] ^= 1 << random.below(8),
        1 => octets.truncate(at),
        2 => {
            octets.remove(at);
        }
        3 => octets.insert(0, random.next() as u8),
        _ => return Some(at),
    }
    None
}

/// For ten million exchanges set `PROFIDRIVE_LONG`, for any number `PROFIDRIVE_EXCHANGES`.
#[test]
fn one_percent_of_line_errors_costs_retries_and_nothing_else() {
    const STATIONS: core::ops::RangeInclusive<u8> = 1..=10;
    let limit: u32 = match std::env::var("PROFIDRIVE_EXCHANGES") {
        Ok(number) => number.parse().unwrap(),
        Err(_) => {
            if long() {
                10_000_000
            } else {
                15_000
            }
        }
    };
    let begun = std::time::Instant::now();
    let mut early = None;
    let mut line = line(STATIONS, &[SMALL]);
    let mut master = Master::new(address(0));
    master.retry_limit = 4;
    for number in STATIONS {
        start_up(&mut line, &mut master, number, 0, SMALL);
    }
    let errors = Arc::new(AtomicU64::new(0));
    let (counted, mut random) = (Arc::clone(&errors), Random(0x9E37_79B9_7F4A_7C15));
    line.disturb(Some(Box::new(move |_, octets| {
        if random.below(100) != 0 {
            return None;
        }
        counted.fetch_add(1, Ordering::Relaxed);
        corrupt(&mut random, octets)
    })));
    for exchange in 0..limit {
        if exchange == limit / 10 {
            early = resident();
        }
        let (number, round) = (*STATIONS.start() + (exchange % 10) as u8, exchange / 10);
        let outputs = outputs(number, round);
        let answer = master.srd(&mut line, address(number), None, &outputs[..SMALL_LEN]).unwrap();
        // Each exchange is carried out exactly once, however often it was said: the inputs count them.
        let expected = inputs(number, round);
        assert_eq!(
            answer,
            Answer::Data(ReplyStatus::DataLow, &expected[..SMALL_LEN]),
            "station {number}, exchange {round}"
        );
    }
    let errors = errors.load(Ordering::Relaxed);
    let (retries, bus) = (master.retries, line.bus(0).unwrap());
    // Recovery at the first valid request: a request goes unanswered only if it or its reply was disturbed.
    assert!(retries > 0 && retries <= errors, "{retries} retries of {errors} errors");
    let seen: u64 = STATIONS.map(|number| bus.station_counters(address(number)).unwrap().retries).sum();
    assert!(seen <= retries && seen > 0, "{seen} of {retries} retries followed a request that was heard");
    assert!(bus.counters().rejected.total() > 0 && bus.counters().rejected.parity > 0);
    if let (Some(early), Some(late)) = (early, resident()) {
        println!("resident after a tenth of the exchanges {early} KiB, after all of them {late} KiB");
        // The other test of this file runs beside a short run and has memory of its own.
        assert!(limit < 10_000_000 || late < early + 1024, "memory grew from {early} to {late} KiB");
    }
    println!(
        "{limit} exchanges, {errors} errors, {retries} retries in {:?}; {}",
        begun.elapsed(),
        bus.counters()
    );
}

/// Memory of this process in KiB, where Linux tells. Run this test alone to learn anything from it.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix(" kB")?.parse().ok()
}

/// Who may answer octets, by rules written down once more: whom the last valid request among the valid telegrams at
/// their front wants a reply from.
fn may_answer(octets: &[u8]) -> Option<u8> {
    let (mut rest, mut last) = (octets, None);
    loop {
        let len = match rest {
            [0xE5, ..] => 1,
            [0xDC, da, sa, ..] if *da < 127 && *sa < 127 => 3,
            [0x10, ..] => 6,
            [0xA2, ..] => 14,
            [0x68, le, ..] => usize::from(*le) + 6,
            _ => return last,
        };
        match (rest.get(..len), rest[0]) {
            (Some(_), 0xE5 | 0xDC) => {}
            // Anything else that is not a request either ends what can be understood or changes nothing.
            (Some(telegram), _) => last = asked(telegram).or(last),
            (None, _) => return last,
        }
        rest = &rest[len..];
    }
}

/// Whom one valid request wants a reply from.
fn asked(octets: &[u8]) -> Option<u8> {
    let (body, format_ok) = match octets {
        [0x10, body @ .., fcs, 0x16] if body.len() == 3 => (body, sum(body) == *fcs),
        [0xA2, body @ .., fcs, 0x16] if body.len() == 11 => (body, sum(body) == *fcs),
        [0x68, le, ler, 0x68, body @ .., fcs, 0x16] => {
            let le_ok = le == ler && (4..=249).contains(le) && usize::from(*le) == body.len();
            (body, le_ok && sum(body) == *fcs)
        }
        _ => return None,
    };
    let &[da, sa, fc, ref pdu @ ..] = body else { return None };
    let saps = usize::from(da >> 7) + usize::from(sa >> 7);
    let saps_ok = pdu.len() >= saps && pdu[..saps].iter().all(|sap| *sap < 64);
    // Request, not reserved, one of SDA, MSRD, FDL status, SRD, ident, LSAP status.
    let fc_ok = fc & 0xC0 == 0x40 && [0x3, 0x5, 0x7, 0x9, 0xC, 0xD, 0xE, 0xF].contains(&(fc & 0x0F));
    let addresses_ok = da & 0x7F != 127 && sa & 0x7F != 127 && (da & 0x7F) != (sa & 0x7F);
    (format_ok && saps_ok && fc_ok && addresses_ok).then_some(da & 0x7F)
}

fn sum(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |sum, octet| sum.wrapping_add(*octet))
}

/// A telegram of any format with likely and unlikely contents, right in every octet.
fn telegram(random: &mut Random) -> Vec<u8> {
    let pick = |random: &mut Random, likely: &[u8]| {
        if random.below(8) == 0 { random.next() as u8 } else { likely[random.below(likely.len())] }
    };
    let sap = random.below(4) != 0;
    let da = pick(random, &[1, 2, 3, 4, 127]) & 0x7F | if sap { 0x80 } else { 0 };
    let sa = pick(random, &[0, 0, 0, 100]) & 0x7F | if sap { 0x80 } else { 0 };
    let fc = pick(random, &[0x6D, 0x5D, 0x7D, 0x4D, 0x6C, 0x5C, 0x7C, 0x49, 0x46, 0x44, 0x08]);
    let mut body = vec![da, sa, fc];
    if sap {
        body.push(pick(random, &[55, 56, 57, 58, 59, 60, 60, 61, 61, 62, 62, 40]));
        body.push(62);
    }
    let [high, low] = IDENT.to_be_bytes();
    // Half of the services have the data that belong to them.
    let fitting = random.below(2) == 0;
    match (fitting, body.get(3)) {
        (true, Some(61)) => body.extend_from_slice(&[0xB8, 1, 1, 11, high, low, 0]),
        (true, Some(62)) => body.extend_from_slice(SMALL),
        (true, Some(58)) => body.extend_from_slice(&[random.next() as u8 & 0x3E, 0]),
        (true, Some(_)) => {}
        (true, None) => body.extend_from_slice(&[0; SMALL_LEN]),
        (false, _) => likely_data(random, &mut body),
    }
    let fcs = sum(&body);
    let mut octets = match body.len() {
        3 => vec![0x10],
        11 if random.below(2) == 0 => vec![0xA2],
        len => vec![0x68, len as u8, len as u8, 0x68],
    };
    octets.append(&mut body);
    octets.extend([fcs, 0x16]);
    octets
}

/// Data of any service, or of none.
fn likely_data(random: &mut Random, body: &mut Vec<u8>) {
    let [high, low] = IDENT.to_be_bytes();
    match random.below(8) {
        0 => body.extend_from_slice(&[0xB8, 1, 1, 11, high, low, 0]),
        1 => body.extend_from_slice(&[0x80, 0, 0, 0, 0x0A, 0xC5, 0]),
        2 => body.extend_from_slice(SMALL),
        3 => body.extend_from_slice(&[0xF3, 0xF2]),
        4 => body.extend_from_slice(&[0; SMALL_LEN]),
        5 => body.extend((0..random.below(244)).map(|_| random.next() as u8)),
        _ => {}
    }
}

/// What comes next: a telegram, a telegram with one octet or more wrong, or noise.
fn utterance(random: &mut Random) -> Vec<u8> {
    let mut octets = telegram(random);
    match random.below(4) {
        0 | 1 => {}
        2 => {
            for _ in 0..=random.below(3) {
                let at = random.below(octets.len().max(1));
                match (random.below(4), octets.get_mut(at)) {
                    (0, Some(octet)) => *octet = random.next() as u8,
                    (1, Some(octet)) => *octet ^= 1 << random.below(8),
                    (2, Some(_)) => octets.truncate(at.max(1)),
                    _ => octets.insert(0, random.next() as u8),
                }
            }
        }
        _ => {
            octets.clear();
            octets.extend((0..1 + random.below(40)).map(|_| random.next() as u8));
            if random.below(2) == 0 {
                octets[0] = [0x10, 0x68, 0xA2, 0xDC, 0xE5][random.below(5)];
            }
        }
    }
    octets
}

/// For ten million of them set `PROFIDRIVE_LONG`.
#[test]
fn f_23_random_and_damaged_telegrams_get_no_reply_they_must_not_have() {
    let limit: u32 = if long() { 10_000_000 } else { 15_000 };
    let begun = std::time::Instant::now();
    let mut line = line([1, 2], &[SMALL]);
    let bus = line.bus_mut(0).unwrap();
    bus.add(Device::new(Config { timing: Timing::True, ..Config::new(address(3)) }, Instant::ZERO)).unwrap();
    let states = |line: &Line| {
        let bus = line.bus(0).unwrap();
        [
            mirror(line, 1).state(),
            mirror(line, 2).state(),
            bus.station::<Device>(address(3)).unwrap().dp_state(),
        ]
    };
    let mut random = Random(0xD1B5_4A32_D192_ED03);
    let (mut replies, mut entered, mut before) = (0_u32, 0_u32, states(&line));
    for number in 0..limit {
        let octets = utterance(&mut random);
        // The line refuses a reply that is early, late, unasked, from the wrong station, to the wrong master, or no
        // telegram, by our own decoder; and the rules above refuse it once more.
        let reply = line.request(&octets).unwrap_or_else(|breach| panic!("{octets:02X?}: {breach}"));
        let replied = reply.is_some();
        let may = may_answer(&octets).is_some_and(|station| (1..=3).contains(&station));
        assert!(may || !replied, "{octets:02X?} got {reply:02X?}");
        replies += u32::from(replied);
        let now = states(&line);
        for (before, now) in before.into_iter().zip(now) {
            assert!(
                (before, now) != (State::WaitPrm, State::DataExch),
                "Data_Exchange without parameters: {octets:02X?}"
            );
            entered += u32::from(before != State::DataExch && now == State::DataExch);
        }
        before = now;
        // Whatever came before, the first valid request is answered.
        if number % 4 == 0 {
            let station = 1 + (number / 4 % 3) as u8;
            let status = [0x10, station, 100, 0x49, sum(&[station, 100, 0x49]), 0x16];
            let answer = [0x10, 100, station, 0, sum(&[100, station]), 0x16];
            let reply = line.request(&status).unwrap();
            assert_eq!(reply, Some(&answer[..]), "behind {octets:02X?}");
        }
    }
    assert!(replies > limit / 10 && entered > 0, "{replies} replies, Data_Exchange entered {entered} times");
    let bus = line.bus_mut(0).unwrap();
    assert!(
        bus.counters().rejected.reasons().iter().all(|(reason, times)| *reason == "parity" || *times > 0)
    );
    while let Some(event) = bus.poll_event() {
        assert!(!matches!(event, BusEvent::MovedToTakenAddress { .. }), "{event}");
    }
    if long() {
        println!(
            "{limit} telegrams and noise, {replies} replies, Data_Exchange entered {entered} times, in {:?}; {}",
            begun.elapsed(),
            bus.counters()
        );
    }
}
