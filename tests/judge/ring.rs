//! A second master, which the judge plays, in the ring of the master under test.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Ending, Report, Row, Setup, Verdict, simulated, simulated_with};
use profidrive::profibus::fdl::Address;

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{BAUD, Settings, TestMaster};
use crate::virtual_time::{is_long, rows};

const SLOT: Duration = Duration::from_micros(600);
/// The rows that a second master shows. R08 needs a target rotation time.
const SHOWN: [Row; 8] = [Row::R01, Row::R02, Row::R03, Row::R04, Row::R05, Row::R06, Row::R07, Row::R09];

fn in_ring() -> Settings {
    Settings { token: true, ..Settings::new(&[5, 6, 9], SLOT) }
}

fn judged(settings: Settings, rows: &[Row]) -> Report {
    let setup =
        Setup { hsa: Address::station(settings.hsa).ok(), ttr: settings.ttr, ..setup(&settings, &[9]) };
    let mut line = Line::with(BAUD, TestMaster::new(settings, None));
    line.set_slot_time(SLOT);
    simulated(&mut line, setup, rows)
}

fn verdict(report: &Report, row: Row) -> Verdict {
    report.judgements.iter().find(|judged| judged.row == row).unwrap().verdict
}

/// Judged by the rows of the ring; with `PROFIDRIVE_LONG` by all of them.
#[test]
fn correct_masters_of_many_habits_pass_the_rows_of_the_ring() {
    let ttr = |millis| Some(Duration::from_millis(millis));
    let judged_by = if is_long() { Row::ALL.to_vec() } else { rows(&["M-K*", "M-R*"]) };
    for (words, settings) in [
        ("as most are", in_ring()),
        ("a GAP that ends soon", Settings { hsa: 12, ..in_ring() }),
        ("the highest address", Settings { address: 30, ..in_ring() }),
        ("address 0", Settings { address: 0, ..in_ring() }),
        ("a GAP poll in each rotation", Settings { gap_factor: 1, ..in_ring() }),
        ("a GAP poll in a hundred rotations", Settings { gap_factor: 100, ..in_ring() }),
        ("a short T_TR", Settings { ttr: ttr(4), ..in_ring() }),
        ("a long T_TR", Settings { ttr: ttr(100), ..in_ring() }),
    ] {
        let has_ttr = settings.ttr.is_some();
        let report = judged(settings, &judged_by);
        let accused: Vec<_> = report
            .judgements
            .iter()
            .filter(|judged| matches!(judged.verdict, Verdict::Fail | Verdict::Warn))
            .map(|judged| judged.row.id())
            .collect();
        assert!(accused.is_empty() && report.ending == Ending::Done, "{words}: {accused:?}\n{report}");
        for row in SHOWN {
            assert_eq!(verdict(&report, row), Verdict::Pass, "{words}, {}: {report}", row.id());
        }
        let r08 = if has_ttr { Verdict::Pass } else { Verdict::NotJudged };
        assert_eq!(verdict(&report, Row::R08), r08, "{words}: {report}");
    }
}

#[test]
fn a_row_of_the_ring_is_judged_alone() {
    for row in SHOWN {
        let report = judged(in_ring(), &[row]);
        assert_eq!(verdict(&report, row), Verdict::Pass, "{report}");
    }
}

/// When a configured station is asked for its FDL status tells nothing of the GAP factor.
#[test]
fn a_gap_of_configured_stations_has_no_gap_factor() {
    for (hsa, expected) in [(5, Verdict::NotJudged), (12, Verdict::Pass)] {
        let settings = Settings { token: true, hsa, ..Settings::new(&[0, 1, 3, 4, 5], SLOT) };
        let report = judged(settings, &[Row::K05]);
        assert_eq!(verdict(&report, Row::K05), expected, "HSA {hsa}: {report}");
        let says_so =
            report.judgements[0].reason.starts_with("does not apply: every address of the GAP is one");
        assert_eq!(says_so, expected == Verdict::NotJudged, "HSA {hsa}: {report}");
    }
}

#[test]
fn a_master_that_passes_no_token_has_no_second_master() {
    let report = judged(Settings { token: false, ..in_ring() }, &rows(&["M-R*"]));
    assert!(report.judgements.iter().all(|judged| judged.verdict == Verdict::NotJudged), "{report}");
    assert!(report.judgements[0].reason.contains("works alone"), "{report}");
}

/// Seen only if somebody restarts the master, and its row.
pub(crate) const AT_RESTART: (Mistake, Row) = (Mistake::ReadyAtOnce, Row::R10);

#[test]
fn a_master_that_is_switched_on_listens_to_the_ring_first() {
    let (mistake, row) = AT_RESTART;
    for (mistake, expected) in [(None, Verdict::Pass), (Some(mistake), Verdict::Fail)] {
        let settings = in_ring();
        let setup = setup(&settings, &[9]);
        let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
        line.set_slot_time(SLOT);
        let report = simulated_with(&mut line, setup, &rows(&["M-R*", "M-Z04"]), |master, action, now| {
            master.do_action(action, now)
        });
        assert_eq!(verdict(&report, row), expected, "{report}");
        assert_eq!(report.count(Verdict::Fail), usize::from(mistake.is_some()), "{report}");
        assert_eq!(report.ending, Ending::Done, "{report}");
    }
}
