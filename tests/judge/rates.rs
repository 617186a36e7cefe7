//! The judgement at several rates.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Report, Row, Verdict, at_rates};
use profidrive::time::BaudRate;

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{Settings, TestMaster};
use crate::virtual_time::{is_long, rows};

/// Mistakes that are made at some rate, and the row that finds each.
pub(crate) const AT_RATES: &[(Mistake, Row)] = &[
    (Mistake::NoControlAtTop, Row::B01),
    (Mistake::IdleOfTop, Row::B02),
    (Mistake::WatchdogOfTop, Row::B03),
];
const RATES: [BaudRate; 3] = [BaudRate::K500, BaudRate::K1500, BaudRate::K12000];
const OVER_RATES: [Row; 3] = [Row::B01, Row::B02, Row::B03];

/// Without `PROFIDRIVE_LONG` at two rates, and by few rows.
fn judged(mistake: Option<Mistake>) -> Report {
    let line = |baud: BaudRate| {
        let slot = baud.bit_times(u32::from(baud.max_tsdr_bits()) + 200);
        let settings = Settings { baud, ..Settings::new(&[5, 6], slot) };
        // The watchdog time may be rounded up, and nobody says here which one is configured.
        let setup = profidrive::judge::Setup { watchdog: None, ..setup(&settings, &[]) };
        let mut line = Line::with(baud, TestMaster::new(settings, mistake));
        line.set_slot_time(slot);
        (line, setup)
    };
    if is_long() {
        return at_rates(&RATES, &OVER_RATES, line).unwrap();
    }
    let few = [&OVER_RATES[..], &rows(&["M-T01", "M-T05", "M-O01", "M-C03"])].concat();
    at_rates(&[BaudRate::K500, BaudRate::K12000], &few, line).unwrap()
}

#[test]
fn a_correct_master_is_right_at_every_rate() {
    let report = judged(None);
    let passed = |row: &Row| {
        report.judgements.iter().any(|judged| judged.row == *row && judged.verdict == Verdict::Pass)
    };
    assert!(OVER_RATES.iter().all(passed), "{report}");
    assert!(report.watchdogs.iter().all(|(_, time)| *time == Duration::from_secs(1)), "{report}");
    assert_eq!(at_rates(&[], Row::ALL, |_| -> (Line<TestMaster>, _) { unreachable!() }), None);
}

#[test]
fn a_mistake_at_one_rate_is_found_by_its_row_alone() {
    for (mistake, row) in AT_RATES {
        let report = judged(Some(*mistake));
        let failed = report.judgements.iter().filter(|judged| judged.verdict == Verdict::Fail);
        let failed: Vec<Row> =
            failed.map(|judged| judged.row).filter(|row| OVER_RATES.contains(row)).collect();
        assert_eq!(failed, [*row], "{mistake:?}: {report}");
    }
}
