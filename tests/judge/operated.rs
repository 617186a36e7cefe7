//! Rows that need somebody who operates the master, in virtual time.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Report, Row, Verdict, simulated_with};

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{BAUD, Settings, TestMaster};
use crate::virtual_time::is_long;

/// Rows that `--ask` gives an occasion to.
const ROWS: &[Row] = &[
    Row::X04,
    Row::O02,
    Row::O03,
    Row::O10,
    Row::O11,
    Row::O12,
    Row::S01,
    Row::S02,
    Row::S03,
    Row::Z01,
    Row::Z02,
    Row::Z03,
    Row::Z04,
    Row::Z06,
];

/// What each mistake is found by, alone: with the other rows of what it breaks.
pub(crate) const ASKED: &[(Mistake, &[Row])] = &[
    (Mistake::TornOutputs, &[Row::X04]),
    (Mistake::OtherOutputs, &[Row::X04]),
    (Mistake::ZerosAfterClear, &[Row::O10]),
    (Mistake::NoClearData, &[Row::O02]),
    (Mistake::OutputsInClear, &[Row::O03]),
    (Mistake::DoesNotStop, &[Row::Z02, Row::O11, Row::Z01, Row::Z04]),
    (Mistake::NoRelease, &[Row::Z01, Row::Z03]),
    // Between two cycles all slaves are released, within one only those that come behind.
    (Mistake::StopsFromOperate, &[Row::Z03, Row::Z01]),
    (Mistake::BeginsWithOperate, &[Row::O12]),
    (Mistake::SyncUntold, &[Row::S02]),
    (Mistake::OtherGroup, &[Row::S01]),
    (Mistake::UndoesSync, &[Row::S03]),
    (Mistake::DoesNotRestart, &[Row::Z04]),
    (Mistake::WaitsForWatchdog, &[Row::Z06]),
];

fn judged(mistake: Option<Mistake>, rows: &[Row]) -> Report {
    let settings = Settings::new(&[5, 6], Duration::from_micros(600));
    let setup = setup(&settings, &[]);
    let slot = settings.slot;
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(slot);
    simulated_with(&mut line, setup, rows, |master, action, now| master.do_action(action, now))
}

#[test]
fn a_correct_master_passes_every_row() {
    let report = judged(None, Row::ALL);
    assert_eq!(report.count(Verdict::Fail) + report.count(Verdict::Warn), 0, "{report}");
    let passed = |row: &&Row| {
        report.judgements.iter().any(|judged| judged.row == **row && judged.verdict == Verdict::Pass)
    };
    assert_eq!(ROWS.iter().filter(passed).count(), ROWS.len(), "{report}");
}

/// Judged by its own rows; with `PROFIDRIVE_LONG` by all of them.
#[test]
fn each_mistake_is_found_by_its_rows_and_by_no_other_when_it_is_operated() {
    for (mistake, rows) in ASKED {
        let report = judged(Some(*mistake), if is_long() { ROWS } else { rows });
        let broken = |verdict| matches!(verdict, Verdict::Fail | Verdict::Warn);
        let found: Vec<Row> = report
            .judgements
            .iter()
            .filter(|judgement| broken(judgement.verdict))
            .map(|found| found.row)
            .collect();
        assert!(found.contains(&rows[0]), "{mistake:?} is missed: {report}");
        assert!(found.iter().all(|row| rows.contains(row)), "{mistake:?}: {found:?}: {report}");
    }
}
