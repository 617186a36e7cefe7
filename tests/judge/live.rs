//! The judge in real time: the test master on a link in memory, on a thread of its own.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::sync::Arc;

use profidrive::host::link::memory::Wire;
use profidrive::host::{Stop, SystemClock};
use profidrive::judge::{Judge, Progress, Report, Requirement as _, Row, Setup, Verdict, live};
use profidrive::time::BaudRate;

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{Settings, TestMaster, serve};
use crate::virtual_time::rows;

fn judged(mistake: Option<Mistake>, rows: &[Row]) -> Report {
    judged_as(Settings::new(&[5, 6, 9], Duration::from_millis(100)), mistake, rows)
}

fn judged_as(settings: Settings, mistake: Option<Mistake>, rows: &[Row]) -> Report {
    let setup = Setup { ttr: settings.ttr, ..setup(&settings, &[9]) };
    let wire = Wire::new();
    let (mut master_end, judge_end) = (wire.end(), wire.end());
    let end = Arc::new(AtomicBool::new(false));
    let ends = Arc::clone(&end);
    let master = TestMaster::new(settings, mistake);
    let thread = std::thread::spawn(move || serve(master, &mut master_end, &ends, |_, _| {}));
    let judge = Judge::new(setup, rows);
    let stop = Stop::new().unwrap();
    let begin = std::time::Instant::now();
    let mut tell = |progress: &Progress| {
        let Progress { number, of, name, left } = progress;
        println!(
            "{:6.1} s: {number} of {of}, about {} s left: {name}",
            begin.elapsed().as_secs_f64(),
            left.as_secs()
        );
    };
    let report = live(judge, judge_end, &SystemClock::new(), BaudRate::K500, &stop, None, &mut tell).unwrap();
    end.store(true, Ordering::Relaxed);
    thread.join().unwrap();
    report
}

#[test]
fn a_correct_master_is_not_accused_in_real_time() {
    let all = std::env::var_os("PROFIDRIVE_EVERY_ROW").is_some();
    // Several at the same time: most of it is waiting.
    let parts = if all {
        vec![Row::ALL.to_vec()]
    } else {
        // Rows whose mistakes are seldom are watched for half a minute: they are left to the long form.
        [
            &["M-C03", "M-C04", "M-C05", "M-C06"][..],
            &["M-C07", "M-C08"],
            &["M-C1*"],
            &["M-T02", "M-T03", "M-T04"],
            &["M-E01", "M-E06"],
        ]
        .map(rows)
        .to_vec()
    };
    let passed: usize = std::thread::scope(|scope| {
        let threads: Vec<_> =
            parts.iter().map(|rows| scope.spawn(|| not_accused(&judged(None, rows)))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    assert!(passed > 10, "{passed}");
}

/// How many rows passed.
fn not_accused(report: &Report) -> usize {
    let accused =
        report.judgements.iter().any(|judged| matches!(judged.verdict, Verdict::Fail | Verdict::Warn));
    assert!(!accused, "{report}");
    report.count(Verdict::Pass)
}

#[test]
fn a_retry_that_toggles_is_found_in_real_time() {
    let report = judged(Some(Mistake::RetryToggles), &[Row::C03]);
    assert_eq!(report.judgements[0].verdict, Verdict::Fail, "{report}");
    assert!(!report.judgements[0].telegrams.is_empty());
}

#[test]
fn no_master_ends_the_judgement_after_ten_seconds() {
    let settings = Settings::new(&[5], Duration::from_millis(100));
    let judge = Judge::new(setup(&settings, &[]), Row::ALL);
    let wire = Wire::new();
    let (_other, end) = (wire.end(), wire.end());
    let begin = std::time::Instant::now();
    let stop = Stop::new().unwrap();
    let report = live(judge, end, &SystemClock::new(), BaudRate::K500, &stop, None, &mut |_| {}).unwrap();
    assert_eq!(report.ending, profidrive::judge::Ending::NoMaster);
    assert!(begin.elapsed() >= Duration::from_secs(9));
}

/// The ring alone takes less than 15 s, four times that on a busy machine: it is a part of every judgement of a master that passes
/// the token.
#[test]
fn a_second_master_is_played_in_real_time() {
    let settings = || Settings {
        token: true,
        ttr: Some(Duration::from_millis(500)),
        ..Settings::new(&[5, 6], Duration::from_millis(50))
    };
    let seen = ["M-R01", "M-R02", "M-R03", "M-R04", "M-R05", "M-R06", "M-R07", "M-R08", "M-R09"]
        .map(|id| Row::named(id).unwrap());
    let begin = std::time::Instant::now();
    let report = judged_as(settings(), None, &seen);
    assert!(report.judgements.iter().all(|judged| judged.verdict == Verdict::Pass), "{report}");
    assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", begin.elapsed());
    let mistakes = [
        (Mistake::PassesOnce, Row::R04, Verdict::Fail),
        (Mistake::TakesFromStranger, Row::R05, Verdict::Warn),
        (Mistake::StaysDespiteDouble, Row::R06, Verdict::Warn),
        (Mistake::HoldsLong, Row::R08, Verdict::Fail),
    ];
    std::thread::scope(|scope| {
        for (mistake, row, verdict) in mistakes {
            scope.spawn(move || {
                let report = judged_as(settings(), Some(mistake), &[row]);
                assert_eq!(report.judgements[0].verdict, verdict, "{mistake:?}: {report}");
            });
        }
    });
}
