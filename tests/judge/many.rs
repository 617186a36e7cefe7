//! 32 stations, and as many as there are addresses beside that of the master and 126: the same rows are judged as with
//! five, in a time that is not that of as many judgements.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Ending, Report, Row, Setup, Verdict, simulated, simulated_until_breach};
use profidrive::profibus::fdl::Address;

use crate::configured::{LONGEST, setup};
use crate::test_master::habits::Habit;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{BAUD, Settings, TestMaster, UNHURRIED};
use crate::virtual_time::{broken, in_threads, is_long, names, rows};

fn judged(stations: &[u8], mistake: Option<Mistake>, wanted: &[Row]) -> Report {
    let slot = Duration::from_micros(600);
    let mut settings = Settings { token: true, pause: UNHURRIED, ..Settings::new(stations, slot) };
    // One of each kind, none of them the first: scenarios have to find theirs.
    let kinds: [&[u8]; 4] = [&[0x23, 0x17], &[0x23], &[0x13], &LONGEST];
    for (station, cfg) in settings.stations.iter_mut().skip(1).zip(kinds) {
        station.cfg = cfg.to_vec();
    }
    let setup = Setup { hsa: Address::station(settings.hsa).ok(), ..setup(&settings, &[]) };
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(slot);
    if mistake.is_some() {
        simulated_until_breach(&mut line, setup, wanted)
    } else {
        simulated(&mut line, setup, wanted)
    }
}

fn five() -> Vec<u8> {
    (10..15).collect()
}

fn many() -> Vec<u8> {
    (10..42).collect()
}

fn all() -> Vec<u8> {
    (0..=125).filter(|number| *number != 2).collect()
}

/// Of 125 stations some groups, every row with `PROFIDRIVE_LONG`.
#[test]
fn every_row_is_judged_of_32_and_of_125_stations() {
    let some = if is_long() { Row::ALL.to_vec() } else { rows(&["M-C*", "M-X*", "M-I*", "M-T*"]) };
    let lists = [(five(), Row::ALL), (many(), Row::ALL), (all(), &some)];
    let reports = std::sync::Mutex::new(Vec::new());
    in_threads(&lists, |(stations, wanted)| {
        let report = judged(stations, None, wanted);
        reports.lock().unwrap().push((stations.len(), report));
        None
    });
    let mut reports = reports.into_inner().unwrap();
    reports.sort_by_key(|(stations, _)| *stations);
    let expected = names(&reports[0].1, Verdict::NotJudged);
    for (stations, report) in &reports {
        assert_eq!((&report.ending, broken(report)), (&Ending::Done, Vec::new()), "{stations}: {report}");
        // M-I06 is about 32 and more. Where every address has a station, none is left for the GAP or another master.
        let missed = names(report, Verdict::NotJudged);
        let others =
            |row: &&str| ["M-K03", "M-K04", "M-K05", "M-K06"].contains(row) || row.starts_with("M-R");
        let gap = |row: &&str| *stations == 125 && others(row);
        let more: Vec<_> = missed.iter().filter(|row| !expected.contains(row) && !gap(row)).collect();
        assert!(more.is_empty(), "{stations} stations: {more:?}: {report}");
        assert_eq!(missed.contains(&"M-I06"), *stations < 32, "{stations} stations: {report}");
        // The cycle of 125 stations is about 0.1 s.
        assert!(report.took < Duration::from_secs(300), "{:?}", report.took);
    }
}

/// A mistake of each group; without `PROFIDRIVE_LONG` every fourth.
#[test]
fn mistakes_are_found_among_32_stations() {
    let found = [
        (Mistake::RetryToggles, "M-C03"),
        (Mistake::CommonBit, "M-C08"),
        (Mistake::BelievesFcs, "M-E01"),
        (Mistake::NoSecondDiag, "M-U04"),
        (Mistake::IgnoresPrmReq, "M-D02"),
        (Mistake::RestartsAll, "M-L04"),
        (Mistake::SkipsCycles, "M-X03"),
        (Mistake::Unequal, "M-I04"),
        (Mistake::StopsOthers, "M-I02"),
        (Mistake::NoStartUp, "M-L02"),
        (Mistake::AnnouncesOnce, "M-O01"),
        (Mistake::Pauses, "M-T08"),
        (Mistake::NeverPasses, "M-K01"),
        (Mistake::RejectsSc, "M-X06"),
        (Mistake::RejectsLong, "M-X08"),
        (Mistake::DiesOnManyErrors, "M-E17"),
    ];
    let found: Vec<_> = found.iter().step_by(if is_long() { 1 } else { 4 }).collect();
    let wrong = in_threads(&found, |(mistake, row)| {
        let report = judged(&many(), Some(*mistake), &rows(&[row]));
        (!broken(&report).contains(row)).then(|| format!("{mistake:?}: {report}"))
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// 125 stations on a machine that becomes slow: the cycle was measured as 0.1 s, and is 1.7 s when a station must come back. It is
/// asked once in a cycle, and its start-up and eight exchanges take 20 s.
#[test]
fn a_master_that_becomes_slow_is_not_accused() {
    let report = slowed(850, None, "M-C03");
    assert_eq!(names(&report, Verdict::Pass), ["M-C03"], "{report}");
    assert_eq!(report.ending, Ending::Done, "{report}");
}

/// A start-up that would take several minutes is not waited for: nobody knows what comes of it.
#[test]
fn a_start_up_that_is_still_under_way_is_not_judged() {
    let report = slowed(3300, None, "M-L01");
    let judgement = &report.judgements[0];
    assert_eq!(judgement.verdict, Verdict::NotJudged, "{report}");
    let reason = &judgement.reason;
    assert!(reason.contains("was asked") && reason.contains("times only in the 6"), "{reason}");
}

/// A station that the slow master asks no more is missed as fast as before.
#[test]
fn a_slow_master_that_forgets_a_station_fails() {
    let report = slowed(850, Some(Mistake::Forgets), "M-L06");
    assert_eq!(names(&report, Verdict::Fail), ["M-L06"], "{report}");
}

/// All addresses, by one row; after 20 cycles the pause of 2 ms becomes so many times as long.
fn slowed(times: u32, mistake: Option<Mistake>, row: &str) -> Report {
    let slot = Duration::from_micros(600);
    let habits = vec![Habit::SlowsAfter(20, times)];
    let watchdog = Duration::from_secs(20);
    let settings = Settings { habits, watchdog, ..Settings::new(&all(), slot) };
    let setup = setup(&settings, &[]);
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(slot);
    simulated(&mut line, setup, &rows(&[row]))
}
