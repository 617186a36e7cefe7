//! A master of class 2 under test, in virtual time: the judge plays the one of class 1 that owns the slaves.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{
    Ending, MasterClass, Row, Setup, Verdict, simulated, simulated_until_breach, soaked,
};
use profidrive::profibus::fdl::Address;

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{BAUD, Settings, TestMaster};
use crate::virtual_time::{broken, in_threads, is_long, names};

const SLOT: Duration = Duration::from_micros(600);

/// What each mistake is found by.
const MISTAKES: &[(Mistake, Row)] = &[
    (Mistake::TakesOver, Row::R09),
    (Mistake::TakesOver, Row::U12),
    (Mistake::SendsSc, Row::F01),
    (Mistake::WrongFcs, Row::F02),
    (Mistake::BrokenLength, Row::F03),
    (Mistake::AsksItself, Row::F04),
    (Mistake::NoSsap, Row::F06),
    (Mistake::EmptySd2, Row::F07),
    (Mistake::HugeLength, Row::F08),
    (Mistake::Babbles, Row::F11),
    (Mistake::ShortIdle, Row::T01),
    (Mistake::ShortIdle, Row::T05),
    (Mistake::DoesNotWait, Row::T02),
    (Mistake::ShortSlot, Row::T03),
    (Mistake::SlowAfterLoss, Row::T04),
    (Mistake::NeverPasses, Row::K01),
    (Mistake::TokenToSlave, Row::K02),
    (Mistake::GapTwice, Row::K03),
    (Mistake::GapFalls, Row::K04),
    (Mistake::AlwaysAsksGap, Row::K05),
    (Mistake::GapRepeats, Row::K06),
    (Mistake::NoListening, Row::K07),
    (Mistake::NeverAsksGap, Row::K08),
    (Mistake::FirstCounted, Row::C01),
    (Mistake::NoToggle, Row::C02),
    (Mistake::RetryToggles, Row::C03),
    (Mistake::NoRetry, Row::C05),
    (Mistake::EndlessRetries, Row::C06),
    (Mistake::NoReset, Row::C07),
    (Mistake::CountedPoll, Row::C09),
    (Mistake::GivesUpOnFcs, Row::C12),
    (Mistake::DiesOnLongDiag, Row::D08),
    (Mistake::DiesOnMasterBits, Row::D16),
    (Mistake::BelievesFcs, Row::E01),
    (Mistake::BelievesTruncated, Row::E02),
    (Mistake::BelievesSource, Row::E05),
    (Mistake::KeepsReplies, Row::E06),
    (Mistake::DiesOnUserError, Row::E08),
    (Mistake::DiesOnRdl, Row::E09),
    (Mistake::BelievesNoise, Row::E12),
    (Mistake::BelievesFunction, Row::E13),
    (Mistake::DiesOnSaps, Row::E14),
    (Mistake::BelievesDelimiters, Row::E15),
    (Mistake::DiesOnFlood, Row::E16),
    (Mistake::DiesOnManyErrors, Row::E17),
    (Mistake::NoStatusReply, Row::R01),
    (Mistake::StatusAsSlave, Row::R01),
    (Mistake::IgnoresReady, Row::R02),
    (Mistake::TalksWithoutToken, Row::R03),
    (Mistake::PassesOnce, Row::R04),
    (Mistake::TakesFromStranger, Row::R05),
    (Mistake::StaysDespiteDouble, Row::R06),
    (Mistake::NeverClaims, Row::R07),
];

fn of_class_2() -> Settings {
    Settings { class_2: true, token: true, ..Settings::new(&[5, 6], SLOT) }
}

fn on_line(settings: Settings, mistake: Option<Mistake>) -> (Line<TestMaster>, Setup) {
    let setup = Setup {
        class: MasterClass::Two,
        hsa: Address::station(settings.hsa).ok(),
        watchdog: None,
        ..setup(&settings, &[])
    };
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(SLOT);
    (line, setup)
}

#[test]
fn a_correct_master_of_class_2_passes_what_applies() {
    let (mut line, setup) = on_line(of_class_2(), None);
    let report = simulated(&mut line, setup, Row::ALL);
    println!("{report}");
    assert_eq!((&report.ending, broken(&report)), (&Ending::Done, Vec::new()), "{report}");
    assert_eq!(report.outcome().status(), 0, "{report}");
    let passed = names(&report, Verdict::Pass);
    let missed: Vec<_> = MISTAKES.iter().filter(|(_, row)| !passed.contains(&row.id())).collect();
    assert!(missed.is_empty(), "{missed:?}: {report}");
    for judged in report.judgements.iter().filter(|judged| !judged.row.is_of_class_2()) {
        assert_eq!(judged.reason, "does not apply to a master of class 2", "{report}");
    }
}

/// Without `PROFIDRIVE_LONG` by its own row, until that is broken.
#[test]
fn each_mistake_of_a_master_of_class_2_is_found() {
    let wrong = in_threads(MISTAKES, |(mistake, row)| {
        // These pass their own tokens.
        let token = !matches!(
            mistake,
            Mistake::TokenToSlave | Mistake::GapTwice | Mistake::GapFalls | Mistake::GapRepeats
        );
        let (mut line, setup) = on_line(Settings { token, ..of_class_2() }, Some(*mistake));
        let report = if is_long() {
            simulated(&mut line, setup, Row::ALL)
        } else {
            simulated_until_breach(&mut line, setup, &[*row])
        };
        (!broken(&report).contains(&row.id())).then(|| format!("{mistake:?} {}: {report}", row.id()))
    });
    assert!(wrong.is_empty(), "{} missed\n{}", wrong.len(), wrong.join("\n"));
}

/// The other master is heard in the middle of every one of them. With `PROFIDRIVE_LONG` twenty seeds.
#[test]
fn scenarios_that_are_repeated_beside_another_master_accuse_nobody() {
    let seeds: Vec<u64> = (1..=if is_long() { 20 } else { 2 }).collect();
    let wrong = in_threads(&seeds, |seed| {
        let (mut line, setup) = on_line(of_class_2(), None);
        let report = soaked(&mut line, setup, Row::ALL, Duration::from_secs(10), *seed);
        let right = report.ending == Ending::Done && broken(&report).is_empty();
        (!right).then(|| format!("seed {seed}: {report}"))
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_master_of_class_2_that_reads_nothing_has_no_verdict() {
    let nobody = Settings { stations: Vec::new(), ..of_class_2() };
    let (mut line, _) = on_line(nobody, None);
    let (_, setup) = on_line(of_class_2(), None);
    let report = simulated(&mut line, setup, Row::ALL);
    let Ending::NotRead { why, after: None } = &report.ending else { panic!("{report}") };
    assert_eq!(why, "the master passes the token and asks no station");
    assert_eq!(report.outcome().status(), 3, "{report}");
}

#[test]
fn a_master_of_class_2_that_passes_no_token_reads_without_another_master() {
    let (mut line, setup) = on_line(Settings { token: false, ..of_class_2() }, None);
    let report = simulated(&mut line, setup, Row::ALL);
    assert_eq!((&report.ending, broken(&report)), (&Ending::Done, Vec::new()), "{report}");
    assert!(names(&report, Verdict::NotJudged).contains(&"M-R09"), "{report}");
}
