//! Each mistake is found wherever it can be made: with one station and with five, with a long slot time, with its row
//! alone and with all of them. A row that was not put to its situation is not passed.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Ending, Report, Row, Verdict, simulated, simulated_until_breach};

use crate::configured::placed;
use crate::test_master::mistakes::{MISTAKES, Mistake};
use crate::test_master::{BAUD, TestMaster};
use crate::virtual_time::{in_threads, is_long, rows};

/// Where a mistake is made.
#[derive(Clone, Copy, Debug)]
struct Situation {
    name: &'static str,
    stations: &'static [u8],
    absent: &'static [u8],
    slot: Duration,
}

const SHORT: Duration = Duration::from_micros(600);
const LONG: Duration = Duration::from_millis(100);

const SITUATIONS: [Situation; 5] = [
    Situation { name: "usual", stations: &[5, 6, 9], absent: &[9], slot: SHORT },
    Situation { name: "one", stations: &[5], absent: &[], slot: SHORT },
    Situation { name: "two", stations: &[5, 6], absent: &[], slot: SHORT },
    Situation { name: "five", stations: &[5, 6, 7, 8, 10], absent: &[], slot: SHORT },
    Situation { name: "slow", stations: &[5, 6, 9], absent: &[9], slot: LONG },
];

impl Situation {
    fn judged(&self, mistake: Option<Mistake>, made: Option<Mistake>, rows: &[Row]) -> Report {
        let (settings, setup) = placed(mistake, self.stations, self.absent, self.slot);
        let slot = settings.slot;
        let mut line = Line::with(BAUD, TestMaster::new(settings, made));
        line.set_slot_time(slot);
        if rows.len() == 1 && made.is_some() {
            simulated_until_breach(&mut line, setup, rows)
        } else {
            simulated(&mut line, setup, rows)
        }
    }

    /// Mistakes that a master does not make here: there is nobody to make them with.
    const fn cannot_be_made(&self, mistake: Mistake) -> bool {
        match mistake {
            Mistake::Unequal
            | Mistake::SkipsCycles
            | Mistake::CommonBit
            | Mistake::TakesLate
            | Mistake::OperatesWithOne => self.stations.len() < 2,
            // Its pause is behind the only reply.
            Mistake::ShortIdle | Mistake::DoesNotWait => self.stations.len() < 2,
            // It is silent for four seconds in each cycle: data are never exchanged with everybody, and that is said.
            Mistake::SlowAfterLoss => !self.absent.is_empty() && self.slot.as_millis() > 10,
            // It waits for the absent one.
            Mistake::TooFast => !self.absent.is_empty() && self.slot.as_millis() > 10,
            // Each token comes later than T_TR, and then no address is asked.
            Mistake::AlwaysAsksGap => self.slot.as_millis() > 10,
            _ => false,
        }
    }
}

fn verdict(report: &Report, row: Row) -> Verdict {
    report
        .judgements
        .iter()
        .find(|judged| judged.row == row)
        .map_or(Verdict::NotJudged, |found| found.verdict)
}

/// What comes of a mistake in a situation.
enum Found {
    /// Its row is broken.
    Yes,
    /// It cannot be made or seen here, and the judge says so of a correct master, too.
    Excused,
    No(String),
}

fn found(situation: Situation, mistake: Mistake, row: Row, judged: &[Row]) -> Found {
    if situation.cannot_be_made(mistake) {
        return Found::Excused;
    }
    let report = situation.judged(Some(mistake), Some(mistake), judged);
    let complaint = match verdict(&report, row) {
        Verdict::Fail | Verdict::Warn => return Found::Yes,
        Verdict::NotJudged => {
            let correct = situation.judged(Some(mistake), None, judged);
            if verdict(&correct, row) == Verdict::NotJudged && correct.ending == Ending::Done {
                return Found::Excused;
            }
            "not judged"
        }
        Verdict::Pass => "passed",
    };
    let why = report.judgements.iter().find(|judged| judged.row == row).map(|judged| judged.reason.clone());
    let scope = if judged.len() == 1 { "alone" } else { "all rows" };
    let (ending, took, retries) = (&report.ending, report.took, report.figures.retries());
    Found::No(format!(
        "{mistake:?} {} {} {scope}: {complaint}: {why:?}, {ending:?}, {took:?}, {retries} retries",
        row.id(),
        situation.name
    ))
}

/// What is wrong with how a mistake is found: in every situation, by its row alone and by all of them.
fn everywhere(mistake: Mistake, row: Row) -> Option<String> {
    let mut complaints = Vec::new();
    let mut once = false;
    for situation in SITUATIONS {
        for judged in [core::slice::from_ref(&row), Row::ALL] {
            match found(situation, mistake, row, judged) {
                Found::Yes => once = true,
                Found::Excused => {}
                Found::No(complaint) => complaints.push(complaint),
            }
        }
    }
    if !once && complaints.is_empty() {
        complaints.push(format!("{mistake:?}: nowhere"));
    }
    (!complaints.is_empty()).then(|| complaints.join("\n"))
}

/// The same in one situation, that of its number or the next one where it can be made, by its row alone.
fn somewhere(number: usize, mistake: Mistake, row: Row) -> Option<String> {
    for situation in SITUATIONS.iter().cycle().skip(number % SITUATIONS.len()).take(SITUATIONS.len()) {
        match found(*situation, mistake, row, &[row]) {
            Found::Yes => return None,
            Found::Excused => {}
            Found::No(complaint) => return Some(complaint),
        }
    }
    Some(format!("{mistake:?}: nowhere"))
}

/// Without `PROFIDRIVE_LONG` each mistake is made in one situation, with its row alone.
#[test]
fn each_mistake_is_found_in_each_situation() {
    let only = std::env::var("MISTAKE").ok();
    let all = is_long() || only.is_some();
    let mistakes: Vec<(usize, Mistake, Row)> = MISTAKES
        .iter()
        .filter(|(mistake, _)| {
            only.as_ref().is_none_or(|only| only.split(',').any(|only| format!("{mistake:?}") == only))
        })
        .filter_map(|(mistake, its_rows)| Some((*mistake, rows(&[*its_rows.first()?])[0])))
        .enumerate()
        .map(|(number, (mistake, row))| (number, mistake, row))
        .collect();
    let wrong = in_threads(&mistakes, |(number, mistake, row)| {
        if all { everywhere(*mistake, *row) } else { somewhere(*number, *mistake, *row) }
    });
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), mistakes.len(), wrong.join("\n"));
}
