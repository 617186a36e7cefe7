//! The judge in virtual time, over the test master.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::fdl::Address;
use profidrive::judge::{Report, Row, Setup, Slave, Verdict, simulated};
use profidrive::time::BaudRate;

use crate::fixture::{Configured, Mistake, Settings, TestMaster};

const BAUD: BaudRate = BaudRate::K500;

pub(crate) fn settings(stations: &[u8], slot: Duration) -> Settings {
    let configured = |address: &u8| Configured {
        address: *address,
        ident: 0x1234,
        cfg: vec![0x23, 0x13],
        prm: vec![0x01, 0x02],
        groups: 0x01,
    };
    Settings {
        address: 2,
        baud: BAUD,
        slot,
        retries: 2,
        watchdog: Duration::from_millis(1000),
        pause: Duration::from_millis(2),
        stations: stations.iter().map(configured).collect(),
    }
}

pub(crate) fn setup(settings: &Settings, absent: &[u8]) -> Setup {
    let slave = |configured: &Configured| Slave {
        prm: Some(configured.prm.clone()),
        groups: Some(configured.groups),
        absent: absent.contains(&configured.address),
        ..Slave::new(Address::station(configured.address).unwrap(), configured.ident, configured.cfg.clone())
    };
    Setup {
        stations: settings.stations.iter().map(slave).collect(),
        master: Address::station(settings.address).ok(),
        watchdog: Some(settings.watchdog),
        retries: Some(settings.retries),
        slot: Some(settings.slot),
        ..Setup::default()
    }
}

fn judged(mistake: Option<Mistake>) -> Report {
    let slot = Duration::from_micros(600);
    let settings = settings(&[5, 6, 9], slot);
    let setup = setup(&settings, &[9]);
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(slot);
    simulated(&mut line, setup, Row::ALL)
}

fn names(report: &Report, verdict: Verdict) -> Vec<&'static str> {
    let of = report.judgements.iter().filter(|judgement| judgement.verdict == verdict);
    of.map(|judgement| judgement.row.id()).collect()
}

#[test]
fn a_correct_master_is_not_accused() {
    let begin = std::time::Instant::now();
    let report = judged(None);
    println!("{report}\n{:?}", begin.elapsed());
    assert_eq!(names(&report, Verdict::Fail), [""; 0], "{report}");
    assert_eq!(names(&report, Verdict::Warn), [""; 0], "{report}");
}

/// Each mistake, and the rows that may find it; the first must.
const MISTAKES: &[(Mistake, &[&str])] = &[
    (Mistake::WrongFcs, &["M-F02"]),
    (Mistake::WrongFunction, &["M-F05"]),
    (Mistake::CountedControl, &["M-C09"]),
    (Mistake::FirstCounted, &["M-C01", "M-C07"]),
    (Mistake::NoToggle, &["M-C02"]),
    (
        Mistake::RetryToggles,
        &["M-C03", "M-C12", "M-E01", "M-E02", "M-E05", "M-E12", "M-E13", "M-E14", "M-E15"],
    ),
    (Mistake::RetryChanges, &["M-C04"]),
    (Mistake::NoRetry, &["M-C05", "M-C12"]),
    (Mistake::EndlessRetries, &["M-C06", "M-I02", "M-T08"]),
    (Mistake::NoReset, &["M-C07"]),
    (Mistake::CommonBit, &["M-C08", "M-C02"]),
    (Mistake::BelievesFcs, &["M-E01"]),
    (Mistake::BelievesSource, &["M-E05"]),
    (Mistake::NoFirstDiag, &["M-U01"]),
    (Mistake::NoSecondDiag, &["M-U04"]),
    (Mistake::CfgFirst, &["M-U02"]),
    (Mistake::IgnoresNotReady, &["M-U05"]),
    (Mistake::Impatient, &["M-U06"]),
    (Mistake::IgnoresRefusal, &["M-U08"]),
    (Mistake::IgnoresStatDiag, &["M-D03"]),
    (Mistake::IgnoresPrmFault, &["M-D04"]),
    (Mistake::IgnoresCfgFault, &["M-D05"]),
    (Mistake::IgnoresOwner, &["M-D07", "M-L05"]),
    (Mistake::TakesShortDiag, &["M-D12"]),
    (Mistake::NoLock, &["M-P01"]),
    (Mistake::ZeroFactor, &["M-P02"]),
    (Mistake::ReservedPrm, &["M-P04"]),
    (Mistake::SwappedIdent, &["M-P05"]),
    (Mistake::ShortTsdr, &["M-P06"]),
    (Mistake::LongPrm, &["M-P07"]),
    (Mistake::OtherPrm, &["M-P08"]),
    (Mistake::OtherGroups, &["M-P09"]),
    (Mistake::ShortWatchdog, &["M-P03"]),
    (Mistake::LongOutputs, &["M-X01", "M-G02"]),
    (Mistake::IgnoresHigh, &["M-D01", "M-D13"]),
    (Mistake::IgnoresPrmReq, &["M-D02", "M-D15"]),
    (Mistake::RestartsOnDiag, &["M-D06", "M-D08", "M-D09"]),
    (Mistake::NoControl, &["M-O01"]),
    (Mistake::ReservedControl, &["M-O05"]),
    (Mistake::ClearsOnLoss, &["M-O08", "M-O03"]),
    (Mistake::OutputsInClear, &["M-U10"]),
    (Mistake::RestartsOnLoss, &["M-L08"]),
    (Mistake::StaysInExchange, &["M-L01"]),
    (Mistake::IgnoresRs, &["M-L03", "M-E07"]),
    (Mistake::Forgets, &["M-L06", "M-L02"]),
    (Mistake::StopsOthers, &["M-I02", "M-T08", "M-C11", "M-C10"]),
    (Mistake::RestartsAll, &["M-L04"]),
    (Mistake::IgnoresSc, &["M-E03"]),
    (Mistake::IgnoresLength, &["M-E04"]),
    (Mistake::DiesOnRs, &["M-E07", "M-L03"]),
    (Mistake::DoesNotWait, &["M-T02"]),
    (Mistake::ShortSlot, &["M-T03"]),
    (Mistake::Unequal, &["M-I04"]),
    (Mistake::Strangers, &["M-U12"]),
];

#[test]
fn each_mistake_is_found_by_its_rows_and_by_no_other() {
    let mut wrong = Vec::new();
    for (mistake, rows) in MISTAKES {
        if std::env::var("MISTAKE").is_ok_and(|only| format!("{mistake:?}") != only) {
            continue;
        }
        let report = judged(Some(*mistake));
        let found: Vec<_> = names(&report, Verdict::Fail);
        let missed = !found.contains(&rows[0]);
        let accused: Vec<_> = found.iter().filter(|row| !rows.contains(row)).collect();
        if missed || !accused.is_empty() {
            wrong.push(format!(
                "{mistake:?}: missed {missed}, accused {accused:?}, found {found:?}, {:?}",
                report.ending
            ));
        }
        if std::env::var("MISTAKE").is_ok() {
            println!("{report}");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
