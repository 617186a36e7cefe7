//! Masters that use the services of DP-V1, in virtual time: a correct one passes every row, and each of its mistakes is found
//! by its row and by no other.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{
    Ending, MasterClass, Report, Row, Setup, Slave, Verdict, simulated, simulated_until_breach,
    simulated_with,
};
use profidrive::profibus::fdl::Address;

use crate::configured::{configured, dpv1, setup};
use crate::test_master::acyclic::Uses;
use crate::test_master::mistakes::{MISTAKES, Mistake};
use crate::test_master::{BAUD, Settings, TestMaster, UNHURRIED};
use crate::virtual_time::{broken, in_threads, is_long, judged, names, rows};

const SLOT: Duration = Duration::from_micros(600);

/// What a mistake is found by if somebody operates the master, or if it is of class 2.
pub(crate) const OPERATED: (Mistake, Row) = (Mistake::OtherIndex, Row::V21);

fn unhurried() -> Settings {
    Settings { pause: UNHURRIED, ..Settings::new(&[5, 6], SLOT) }
}

fn line(settings: Settings, mistake: Option<Mistake>) -> Line<TestMaster> {
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(SLOT);
    line
}

fn operated(mistake: Option<Mistake>) -> Report {
    let settings = dpv1(unhurried(), Uses { ms1: true, ms2: true });
    let setup = setup(&settings, &[]);
    simulated_with(&mut line(settings, mistake), setup, Row::ALL, |master, action, now| {
        master.do_action(action, now)
    })
}

#[test]
fn a_correct_master_passes_the_rows_of_dp_v1() {
    let report = operated(None);
    println!("{report}");
    assert_eq!((&report.ending, broken(&report)), (&Ending::Done, Vec::new()), "{report}");
    let passed = names(&report, Verdict::Pass);
    // The device file has no SAP 50.
    let missed: Vec<_> =
        rows(&["M-V*"]).into_iter().filter(|row| *row != Row::V13 && !passed.contains(&row.id())).collect();
    assert!(missed.is_empty(), "{missed:?}: {report}");
}

#[test]
fn a_station_given_by_numbers_has_every_service() {
    let settings = dpv1(unhurried(), Uses { ms1: true, ms2: true });
    let numbers = |slave: Slave| Slave { gsd: None, dpv1: true, ..slave };
    let with_files = setup(&settings, &[]);
    let stations = with_files.stations.into_iter().map(numbers).collect();
    let setup = Setup { stations, ..with_files };
    let report = simulated(&mut line(settings, None), setup, Row::ALL);
    assert_eq!((&report.ending, broken(&report)), (&Ending::Done, Vec::new()), "{report}");
    let passed = names(&report, Verdict::Pass);
    for row in ["M-V03", "M-V05", "M-V07", "M-V10", "M-V12", "M-V17", "M-V19"] {
        assert!(passed.contains(&row), "{row}: {report}");
    }
    assert!(names(&report, Verdict::NotJudged).contains(&"M-V09"), "{report}");
}

/// By its rows; every eighth, and each with `PROFIDRIVE_LONG`, by every row.
#[test]
fn each_mistake_of_dp_v1_is_found_by_its_rows_and_by_no_other() {
    let only = std::env::var("MISTAKE").ok();
    let of_dpv1 = |rows: &[&str]| rows.first().is_some_and(|row| row.starts_with("M-V"));
    let mistakes: Vec<_> = MISTAKES
        .iter()
        .filter(|(_, rows)| of_dpv1(rows))
        .filter(|(mistake, _)| only.as_ref().is_none_or(|only| format!("{mistake:?}") == *only))
        .enumerate()
        .collect();
    let wrong = in_threads(&mistakes, |(number, (mistake, its_rows))| {
        let own = rows(its_rows);
        let by_all = is_long() || only.is_some() || number.is_multiple_of(8);
        let report = judged(Some(*mistake), if by_all { Row::ALL } else { &own });
        let found = broken(&report);
        let accused: Vec<_> = found.iter().filter(|row| !its_rows.contains(row)).collect();
        let right = found.contains(&its_rows[0]) && accused.is_empty();
        let shown = if only.is_some() { report.to_string() } else { String::new() };
        (!right)
            .then(|| format!("{mistake:?}: found {found:?}, accused {accused:?}, {:?}{shown}", report.ending))
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let report = operated(Some(OPERATED.0));
    assert_eq!(broken(&report), [OPERATED.1.id()], "{report}");
}

/// Its cycle is 10 ms: the slave gives its job up before the master has done much else.
#[test]
fn an_unhurried_master_that_never_polls_is_found() {
    let mistake = Some(Mistake::NeverPolls);
    let (settings, setup) = configured(mistake);
    let settings = Settings { pause: UNHURRIED, ..settings };
    let report = simulated_until_breach(&mut line(settings, mistake), setup, &[Row::V04]);
    assert_eq!(broken(&report), [Row::V04.id()], "{report}");
}

fn of_class_2(mistake: Option<Mistake>) -> Report {
    // What is wrong with it shows in the first cycles of a job.
    let pause = if mistake.is_none() { UNHURRIED } else { Duration::from_millis(2) };
    let settings = Settings { class_2: true, token: true, pause, ..Settings::new(&[5, 6], SLOT) };
    let settings = dpv1(settings, Uses { ms1: false, ms2: true });
    let setup = Setup {
        class: MasterClass::Two,
        hsa: Address::station(settings.hsa).ok(),
        watchdog: None,
        ..setup(&settings, &[])
    };
    simulated(&mut line(settings, mistake), setup, Row::ALL)
}

#[test]
fn a_master_of_class_2_is_judged_by_its_connections() {
    let report = of_class_2(None);
    assert_eq!((&report.ending, broken(&report)), (&Ending::Done, Vec::new()), "{report}");
    let passed = names(&report, Verdict::Pass);
    for row in ["M-V02", "M-V03", "M-V04", "M-V05", "M-V08", "M-V18", "M-V20"] {
        assert!(passed.contains(&row), "{row}: {report}");
    }
    let wrong = in_threads(
        &[
            // It aborts before the judge can tell that the job is slow, and opens the connection late.
            (Mistake::AbortsSlowJob, &["M-V19"][..]),
            (Mistake::AsksForeignSap, &["M-V18"][..]),
            (Mistake::NoReadWrite, &["M-V20"][..]),
        ],
        |(mistake, rows)| {
            let report = of_class_2(Some(*mistake));
            (broken(&report) != *rows).then(|| format!("{mistake:?}: {report}"))
        },
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
