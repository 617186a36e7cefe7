//! A judgement at several rates (rows B01 to B03).

use super::Judgement;
use super::Report;
use super::rows::{Group, Row};
use super::setup::Setup;
use super::simulated::simulated;
use crate::bench::{Line, Master};
use crate::judge::Verdict;
use crate::time::BaudRate;

/// Judges a master at each of these rates by these rows, or by all if none but M-B01 to B03 is wanted. `line` gives the master on
/// a new line at a rate, and how it is configured there. The report has the rows of all rates.
pub fn at_rates<M: Master>(
    rates: &[BaudRate],
    wanted: &[Row],
    mut line: impl FnMut(BaudRate) -> (Line<M>, Setup),
) -> Option<Report> {
    let rows = rows_at_each(wanted);
    let runs: Vec<(BaudRate, Report)> = rates
        .iter()
        .map(|rate| {
            let (mut line, setup) = line(*rate);
            (*rate, simulated(&mut line, setup, rows))
        })
        .collect();
    Report::over_rates(&runs, wanted)
}

/// The rows by which a master is judged at each rate: all if none but M-B01 to B03 is wanted.
pub fn rows_at_each(wanted: &[Row]) -> &[Row] {
    if wanted.iter().all(|row| OWN.contains(row)) { Row::ALL } else { wanted }
}

impl Report {
    /// One report of judgements of a master at several rates; `None`: there are none.
    ///
    /// It has the worst verdict on each row, with the rate in its reason. M-B01: what passes at one rate fails at no
    /// other, and data are exchanged at each; M-B02: the same for the rows of timing; M-B03: the watchdog time is the same.
    pub(crate) fn over_rates(runs: &[(BaudRate, Self)], wanted: &[Row]) -> Option<Self> {
        let worst_run = runs.iter().find(|(_, run)| !run.ending.is_complete()).or(runs.first())?;
        let judgements = wanted.iter().filter_map(|row| {
            let is_own = OWN.contains(row) && runs.len() > 1;
            if is_own { Some(over_rates(*row, runs)) } else { worst(*row, runs) }
        });
        let took = runs.iter().map(|(_, run)| run.took).sum();
        Some(Self { judgements: judgements.collect(), took, ..worst_run.1.clone() })
    }
}

/// Rows that are about all rates.
const OWN: [Row; 3] = [Row::B01, Row::B02, Row::B03];

fn of(run: &Report, row: Row) -> Option<&Judgement> {
    run.judgements.iter().find(|judgement| judgement.row == row)
}

fn at(rate: BaudRate, judgement: &Judgement) -> Judgement {
    Judgement { reason: format!("at {rate}: {}", judgement.reason), ..judgement.clone() }
}

/// The worst verdict on a row.
fn worst(row: Row, runs: &[(BaudRate, Report)]) -> Option<Judgement> {
    let with = |verdict| {
        let said = runs.iter().filter_map(|(rate, run)| Some((*rate, of(run, row)?)));
        said.filter(|(_, judgement)| judgement.verdict == verdict)
            .map(|(rate, judgement)| at(rate, judgement))
            .next()
    };
    [Verdict::Fail, Verdict::Warn, Verdict::Pass, Verdict::NotJudged].into_iter().find_map(with)
}

/// The verdict on a row about all rates.
fn over_rates(row: Row, runs: &[(BaudRate, Report)]) -> Judgement {
    let is_exact = |(_, run): &(BaudRate, Report)| {
        of(run, Row::T01).is_some_and(|judged| judged.verdict != Verdict::NotJudged)
    };
    if row == Row::B02 && !runs.iter().all(is_exact) {
        return Judgement::not_judged(row, "needs M-T01 at each rate, in virtual time".into());
    }
    let broken = if row == Row::B03 {
        other_watchdog(runs)
    } else {
        unfinished(runs).filter(|_| row == Row::B01).or_else(|| only_somewhere(row == Row::B02, runs))
    };
    match broken {
        Some(reason) => Judgement { verdict: Verdict::Fail, ..Judgement::not_judged(row, reason) },
        None => Judgement {
            verdict: Verdict::Pass,
            ..Judgement::not_judged(row, format!("held at {} rates", runs.len()))
        },
    }
}

fn unfinished(runs: &[(BaudRate, Report)]) -> Option<String> {
    let (rate, run) = runs.iter().find(|(_, run)| !run.ending.is_complete())?;
    Some(format!("at {rate}: {}", run.ending))
}

/// A row that fails at one rate and passes at another: of timing, or any other.
fn only_somewhere(timing: bool, runs: &[(BaudRate, Report)]) -> Option<String> {
    Row::ALL.iter().find_map(|row| {
        let is_timing = row.about().group == Group::Timing;
        let with = |verdict| {
            let said =
                |(_, run): &&(BaudRate, Report)| of(run, *row).is_some_and(|said| said.verdict == verdict);
            runs.iter().find(said)
        };
        let ((bad, run), (good, _)) = (with(Verdict::Fail)?, with(Verdict::Pass)?);
        let why = of(run, *row).map(|judgement| judgement.reason.as_str()).unwrap_or_default();
        (is_timing == timing).then(|| format!("{} fails at {bad} and passes at {good}: {why}", row.id()))
    })
}

fn other_watchdog(runs: &[(BaudRate, Report)]) -> Option<String> {
    let ((first, expected), others) = runs.split_first()?;
    let other = others.iter().find(|(_, run)| run.watchdogs != expected.watchdogs)?;
    let (rate, run) = other;
    let words = |run: &Report| {
        let times = run
            .watchdogs
            .iter()
            .map(|(station, time)| format!("{} ms of station {station}", time.as_millis()));
        times.collect::<Vec<_>>().join(", ")
    };
    Some(format!("the watchdog time is {} at {first}, and {} at {rate}", words(expected), words(run)))
}
