//! The master's own device file: what it does not offer is not judged, and nobody can have more than it offers.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::gsd::MasterGsd;
use profidrive::judge::{Report, Row, Setup, Verdict, simulated, simulated_with};
use profidrive::time::BaudRate;

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{BAUD, Settings, TestMaster};

const SLOT: Duration = Duration::from_micros(600);

fn gsd(lines: &str) -> Option<Box<MasterGsd>> {
    let file = format!("#Profibus_DP\nGSD_Revision=3\nStation_Type=1\n{lines}\n");
    Some(Box::new(MasterGsd::read(file.as_bytes()).unwrap()))
}

fn with(lines: &str) -> (Line<TestMaster>, Setup) {
    let settings = Settings::new(&[5, 6], SLOT);
    let setup = Setup { master_gsd: gsd(lines), ..setup(&settings, &[]) };
    let mut line = Line::with(BAUD, TestMaster::new(settings, None));
    line.set_slot_time(SLOT);
    (line, setup)
}

fn reason(report: &Report, row: Row) -> (Verdict, &str) {
    let judged = report.judgements.iter().find(|judged| judged.row == row).unwrap();
    (judged.verdict, judged.reason.as_str())
}

#[test]
fn a_diagnosis_that_the_master_cannot_take_is_not_sent() {
    for (lines, verdict) in [("Max_Lsdu_MS=100", Verdict::NotJudged), ("Max_Lsdu_MS=244", Verdict::Pass)] {
        let (mut line, setup) = with(lines);
        let report = simulated(&mut line, setup, &[Row::D08]);
        let (got, why) = reason(&report, Row::D08);
        assert_eq!(got, verdict, "{report}");
        assert_eq!(why.contains("Max_Lsdu_MS"), verdict == Verdict::NotJudged, "{why}");
    }
}

#[test]
fn a_master_without_sync_is_not_asked_for_it() {
    for (lines, asked) in [("Master_Freeze_Mode_supp=1", false), ("Master_Sync_Mode_supp=1", true)] {
        let (mut line, setup) = with(lines);
        let mut actions = Vec::new();
        let report = simulated_with(&mut line, setup, &[Row::S01], |master, action, now| {
            actions.push(action.to_owned());
            master.do_action(action, now)
        });
        assert_eq!(actions.iter().any(|action| action.starts_with("sync")), asked, "{actions:?}");
        assert_eq!(actions.iter().any(|action| action.starts_with("freeze")), !asked, "{actions:?}");
        assert_eq!(reason(&report, Row::S01).0, Verdict::Pass, "{report}");
    }
}

/// 40 bit times: more than T_SYN, less than what the file asks for.
#[test]
fn the_idle_time_before_a_request_is_that_of_the_file() {
    for (lines, verdict) in [("", Verdict::Pass), ("Tqui_500=255\nTset_500=255", Verdict::Fail)] {
        let (mut line, setup) = with(lines);
        let report = simulated(&mut line, setup, &[Row::T05]);
        assert_eq!(reason(&report, Row::T05).0, verdict, "{report}");
    }
}

#[test]
fn what_the_master_cannot_have_is_refused() {
    let admitted = |lines: &str| {
        let settings = Settings::new(&[5, 6], SLOT);
        Setup { master_gsd: gsd(lines), baud: Some(BaudRate::K500), ..setup(&settings, &[]) }.check_master()
    };
    assert_eq!(
        admitted(
            "500_supp=1\nMax_Slaves_supp=2\nMax_Master_Input_Len=4\nMax_Master_Data_Len=8\nMax_Lsdu_MS=9\nMax_MPS_Length=22"
        ),
        Ok(())
    );
    for (lines, words) in [
        ("1.5M_supp=1\n9.6_supp=1", "it offers no 500000 bit/s, but 9600 bit/s, 1500000 bit/s"),
        ("Max_Slaves_supp=1", "Max_Slaves_supp is 1, and there are 2 stations"),
        ("Max_Master_Input_Len=3", "Max_Master_Input_Len is 3, and station 5 has 4 octets of inputs"),
        ("Max_Master_Output_Len=3", "Max_Master_Output_Len is 3, and station 5 has 4 octets of outputs"),
        ("Max_Master_Data_Len=7", "Max_Master_Data_Len is 7, and station 5 has 8 octets both ways"),
        ("Max_Lsdu_MS=8", "Max_Lsdu_MS is 8, and station 5 has 9 octets in one telegram"),
        ("Max_MPS_Length=21", "Max_MPS_Length is 21, and Set_Prm and Chk_Cfg of all stations have 22 octets"),
    ] {
        assert_eq!(admitted(lines), Err(words.to_owned()));
    }
    assert_eq!(Setup { master_gsd: None, ..Setup::default() }.check_master(), Ok(()));
}

/// A mistake stays one, whatever the file says.
#[test]
fn a_file_excuses_no_mistake() {
    let settings = Settings::new(&[5, 6], SLOT);
    let setup = Setup { master_gsd: gsd("Max_Slaves_supp=32"), ..setup(&settings, &[]) };
    let mut line = Line::with(BAUD, TestMaster::new(settings, Some(Mistake::RetryToggles)));
    line.set_slot_time(SLOT);
    let report = simulated(&mut line, setup, &[Row::C03]);
    assert_eq!(reason(&report, Row::C03).0, Verdict::Fail, "{report}");
}
