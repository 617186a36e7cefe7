//! The judge in virtual time, over the test master.

use core::time::Duration;
use std::sync::OnceLock;

use profidrive::bench::Line;
use profidrive::judge::{
    Ending, Report, Requirement as _, Row, Setup, Verdict, simulated, simulated_until_breach,
};
use profidrive::time::BaudRate;

use crate::configured::{configured, setup};
use crate::test_master::mistakes::{MISTAKES, Mistake};
use crate::test_master::{BAUD, Settings, TestMaster};

pub(crate) fn judged(mistake: Option<Mistake>, rows: &[Row]) -> Report {
    let (settings, setup) = configured(mistake);
    let slot = settings.slot;
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(slot);
    simulated(&mut line, setup, rows)
}

/// A correct master by every row, once for all tests.
pub(crate) fn correct() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| judged(None, Row::ALL))
}

/// A master that fails by every row, once for all tests.
pub(crate) fn failed() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| judged(Some(Mistake::RetryToggles), Row::ALL))
}

/// Over settings of its own.
fn judged_with(settings: Settings, mistake: Mistake, rows: &[Row]) -> Report {
    let setup = setup(&settings, &[9]);
    let slot = settings.slot;
    let mut line = Line::with(BAUD, TestMaster::new(settings, Some(mistake)));
    line.set_slot_time(slot);
    simulated_until_breach(&mut line, setup, rows)
}

/// Mistakes that a row did not see with a long slot time, or in a ring.
#[test]
fn a_mistake_is_found_however_the_master_is_configured() {
    let slow = Settings::new(&[5, 6, 9], Duration::from_millis(100));
    let ring = Settings { token: true, ..Settings::new(&[5, 6, 9], Duration::from_micros(600)) };
    for (settings, mistake, row) in [
        (&slow, Mistake::BelievesSource, Row::E05),
        (&slow, Mistake::KeepsReplies, Row::E06),
        (&ring, Mistake::Forgets, Row::L06),
        // Seen only if nothing is disturbed for long enough.
        (&slow, Mistake::NoControl, Row::O01),
    ] {
        let report = judged_with(settings.clone(), mistake, &[row]);
        assert_eq!(names(&report, Verdict::Fail), [row.id()], "{mistake:?}: {report}");
    }
}

/// With a min T_SDR of 200 bit times a reply that is half a slot time late comes behind the slot time.
#[test]
fn a_retry_is_one_whose_reply_came_too_late() {
    let report = judged(Some(Mistake::LongTsdr), Row::ALL);
    assert_eq!(broken(&report), [Row::P06.id()], "{report}");
}

pub(crate) fn rows(patterns: &[&str]) -> Vec<Row> {
    patterns.iter().flat_map(|pattern| Row::matching(pattern)).collect()
}

/// Whether the long tests run: they judge more masters by more rows.
pub(crate) fn is_long() -> bool {
    std::env::var_os("PROFIDRIVE_LONG").is_some()
}

/// A master with a cycle of 80 ms: nothing is left out.
#[test]
fn a_slow_master_is_judged_completely() {
    let of = |pause: u64| {
        let settings = Settings {
            pause: Duration::from_millis(pause),
            ..Settings::new(&[5, 6], Duration::from_micros(600))
        };
        let setup = setup(&settings, &[]);
        let mut line = Line::with(BAUD, TestMaster::new(settings, None));
        line.set_slot_time(Duration::from_micros(600));
        simulated(&mut line, setup, Row::ALL)
    };
    let fast = of(2);
    let slow = of(80);
    assert_eq!((&slow.ending, broken(&slow)), (&Ending::Done, Vec::new()), "{slow}");
    assert_eq!(names(&slow, Verdict::NotJudged), names(&fast, Verdict::NotJudged), "{slow}");
}

/// Failures and warnings.
pub(crate) fn broken(report: &Report) -> Vec<&'static str> {
    [names(report, Verdict::Fail), names(report, Verdict::Warn)].concat()
}

pub(crate) fn names(report: &Report, verdict: Verdict) -> Vec<&'static str> {
    let of = report.judgements.iter().filter(|judgement| judgement.verdict == verdict);
    of.map(|judgement| judgement.row.id()).collect()
}

#[test]
fn a_correct_master_is_not_accused() {
    let report = correct();
    println!("{report}");
    assert_eq!(names(report, Verdict::Fail), [""; 0], "{report}");
    assert_eq!(names(report, Verdict::Warn), [""; 0], "{report}");
}

/// Judged by every row, of which no other may accuse it. Without `PROFIDRIVE_LONG` one mistake in twenty; each of them by
/// its own row in tests/judge/situations.rs.
#[test]
fn each_mistake_is_found_by_its_rows_and_by_no_other() {
    assert!(MISTAKES.len() >= 60, "{}", MISTAKES.len());
    let only = std::env::var("MISTAKE").ok();
    let wanted: Vec<_> = MISTAKES
        .iter()
        .filter(|(_, rows)| !rows.is_empty())
        .filter(|(mistake, _)| only.as_ref().is_none_or(|only| format!("{mistake:?}") == *only))
        .step_by(if is_long() || only.is_some() { 1 } else { 20 })
        .collect();
    let wrong = in_threads(&wanted, |(mistake, its_rows)| {
        let report = judged(Some(*mistake), Row::ALL);
        if only.is_some() {
            println!("{report}");
        }
        let found = broken(&report);
        let missed = !found.contains(&its_rows[0]);
        let accused: Vec<_> = found.iter().filter(|row| !its_rows.contains(row)).collect();
        let ending = &report.ending;
        (missed || !accused.is_empty()).then(|| {
            format!("{mistake:?}: missed {missed}, accused {accused:?}, found {found:?}, {ending:?}")
        })
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A correct master, configured in another way for each seed.
fn varied(seed: u32) -> (Settings, Vec<u8>) {
    const RATES: [BaudRate; 5] =
        [BaudRate::K93_75, BaudRate::K187_5, BaudRate::K500, BaudRate::K1500, BaudRate::K12000];
    // Any numbers that differ: a step of a linear congruential generator each.
    let mut state = seed;
    let mut below = |limit: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) % limit
    };
    let baud = RATES[below(5) as usize];
    let stations: Vec<u8> = (0..=below(5) as u8).map(|station| 5 + 3 * station).collect();
    let slot = baud.bit_times(u32::from(baud.max_tsdr_bits()) + 100 + below(400));
    let absent = if stations.len() > 2 && below(2) == 0 {
        stations[stations.len() - 1..].to_vec()
    } else {
        Vec::new()
    };
    let settings = Settings {
        baud,
        retries: 1 + below(4),
        watchdog: Duration::from_millis(u64::from(500 + 10 * below(200))),
        pause: Duration::from_micros(u64::from(1500 + below(4000))),
        token: below(2) == 0,
        ..Settings::new(&stations, slot)
    };
    (settings, absent)
}

/// Five configurations, a hundred with `PROFIDRIVE_LONG`. With 17 a station that is asked for its FDL status in the GAP is
/// made a master by a fault, with 19 the late reply of a lost cycle met the next one.
#[test]
fn correct_masters_of_many_configurations_are_not_accused() {
    let only = std::env::var("SEED").ok().and_then(|seed| seed.parse::<u32>().ok());
    let seeds: Vec<u32> = match only {
        Some(seed) => vec![seed],
        None if is_long() => (1..=100).collect(),
        None => vec![1, 2, 3, 17, 19],
    };
    let wrong = in_threads(&seeds, |seed| {
        let (settings, absent) = varied(*seed);
        let words = format!("seed {seed}: {settings:?}, absent {absent:?}");
        let setup = Setup { min_interval: Some(settings.pause), ..setup(&settings, &absent) };
        let (baud, slot) = (settings.baud, settings.slot);
        let mut line = Line::with(baud, TestMaster::new(settings, None));
        line.set_slot_time(slot);
        let report = simulated(&mut line, setup, Row::ALL);
        let accused = [names(&report, Verdict::Fail), names(&report, Verdict::Warn)].concat();
        (!accused.is_empty() || report.ending != Ending::Done)
            .then(|| format!("{words}: {accused:?}, {:?}\n{report}", report.ending))
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What `complaint` says of each, on every core.
pub(crate) fn in_threads<T: Sync>(
    list: &[T],
    complaint: impl Fn(&T) -> Option<String> + Sync,
) -> Vec<String> {
    let cores = std::thread::available_parallelism().map_or(1, core::num::NonZero::get);
    std::thread::scope(|scope| {
        let complaint = &complaint;
        let of_core = |core: usize| {
            move || list.iter().skip(core).step_by(cores).filter_map(complaint).collect::<Vec<_>>()
        };
        let threads: Vec<_> = (0..cores).map(|core| scope.spawn(of_core(core))).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    })
}
