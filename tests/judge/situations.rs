//! Each mistake is found wherever it can be made: with one station and with five, with a long slot time, with its row
//! alone and with all of them. A row that was not put to its situation is not passed.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Ending, Report, Row, Verdict, simulated};

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
        simulated(&mut line, setup, rows)
    }

    /// Mistakes that a master does not make here: there is nobody to make them with.
    const fn cannot_be_made(&self, mistake: Mistake) -> bool {
        match mistake {
            Mistake::Unequal | Mistake::SkipsCycles | Mistake::CommonBit | Mistake::TakesLate => {
                self.stations.len() < 2
            }
            // In a ring of two: tests/judge/ring.rs makes them.
            Mistake::HoldsLong | Mistake::TokenToNotReady | Mistake::GapBeyondNext => true,
            // Its pause is behind the only reply.
            Mistake::ShortIdle | Mistake::DoesNotWait => self.stations.len() < 2,
            // It is silent for four seconds in each cycle: data are never exchanged with everybody, and that is said.
            Mistake::SlowAfterLoss => !self.absent.is_empty() && self.slot.as_millis() > 10,
            // It waits for the absent one.
            Mistake::TooFast => !self.absent.is_empty() && self.slot.as_millis() > 10,
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

/// One mistake in one situation. What the judge says of a correct master there tells whether the row can be seen.
fn complaint(situation: Situation, mistake: Mistake, row: Row, judged: &[Row]) -> Option<String> {
    if situation.cannot_be_made(mistake) {
        return None;
    }
    let report = situation.judged(Some(mistake), Some(mistake), judged);
    let complaint = match verdict(&report, row) {
        Verdict::Fail | Verdict::Warn => return None,
        Verdict::NotJudged => {
            let correct = situation.judged(Some(mistake), None, judged);
            if verdict(&correct, row) == Verdict::NotJudged && correct.ending == Ending::Done {
                return None;
            }
            "not judged"
        }
        Verdict::Pass => "passed",
    };
    let why = report.judgements.iter().find(|judged| judged.row == row).map(|judged| judged.reason.clone());
    let scope = if judged.len() == 1 { "alone" } else { "all rows" };
    let (ending, took, retries) = (&report.ending, report.took, report.figures.retries());
    Some(format!(
        "{mistake:?} {} {} {scope}: {complaint}: {why:?}, {ending:?}, {took:?}, {retries} retries",
        row.id(),
        situation.name
    ))
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
    let mut cases = Vec::new();
    for (number, mistake, row) in mistakes {
        for (which, situation) in SITUATIONS.iter().enumerate() {
            if all || number % SITUATIONS.len() == which {
                cases.push((*situation, mistake, row, vec![row]));
            }
            if all {
                cases.push((*situation, mistake, row, Row::ALL.to_vec()));
            }
        }
    }
    let wrong =
        in_threads(&cases, |(situation, mistake, row, judged)| complaint(*situation, *mistake, *row, judged));
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), cases.len(), wrong.join("\n"));
}
