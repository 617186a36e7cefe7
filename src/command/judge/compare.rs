//! `judge compare A.json B.json`: what the second judgement says that the first did not.

use core::fmt::Write as _;
use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::ExitCode;

use serde::Deserialize;
use serde_json::Value;

use crate::command::Failure;

/// The version of the form that is read.
const VERSION: u32 = 1;
/// A row takes longer if it takes twice as long, and so many seconds more.
const LONGER: f64 = 1.0;

/// A report, as far as it is compared.
#[derive(Debug, Deserialize)]
struct Report {
    version: u32,
    ended: String,
    #[serde(default)]
    date: String,
    #[serde(default)]
    program: String,
    #[serde(default)]
    seconds: f64,
    #[serde(default)]
    configuration: BTreeMap<String, Value>,
    rows: Vec<Row>,
}

#[derive(Debug, Deserialize)]
struct Row {
    id: String,
    verdict: Verdict,
    reason: String,
    #[serde(default)]
    seconds: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    Pass,
    Fail,
    Warn,
    NotJudged,
}

/// What became of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    NewFailure,
    StillFails,
    Mended,
    NotJudged,
    Judged,
}

/// In the order in which they are told.
const CHANGES: [(Change, &str); 5] = [
    (Change::NewFailure, "fails, and did not"),
    (Change::StillFails, "fails still"),
    (Change::Mended, "no longer fails"),
    (Change::NotJudged, "is no longer judged"),
    (Change::Judged, "is judged, and was not"),
];

impl Change {
    const fn of(before: Verdict, after: Verdict) -> Option<Self> {
        match (before, after) {
            (Verdict::Fail, Verdict::Fail) => Some(Self::StillFails),
            (Verdict::Pass | Verdict::Warn | Verdict::NotJudged, Verdict::Fail) => Some(Self::NewFailure),
            (Verdict::Fail, Verdict::Pass | Verdict::Warn) => Some(Self::Mended),
            (Verdict::Pass | Verdict::Fail | Verdict::Warn, Verdict::NotJudged) => Some(Self::NotJudged),
            (Verdict::NotJudged, Verdict::Pass | Verdict::Warn) => Some(Self::Judged),
            (Verdict::NotJudged, Verdict::NotJudged)
            | (Verdict::Pass | Verdict::Warn, Verdict::Pass | Verdict::Warn) => None,
        }
    }
}

/// Compares two reports. The status is 1 if a row fails that did not, 4 if less is known than before, otherwise 0.
pub(super) fn compare(before: &Path, after: &Path) -> Result<ExitCode, Failure> {
    let (before, after) = (read(before)?, read(after)?);
    let changes = changes(&before, &after);
    let mut stdout = io::stdout().lock();
    // Nobody may read it any more.
    let _ = stdout.write_all(told(&before, &after, &changes).as_bytes()).and_then(|()| stdout.flush());
    let has = |change: Change| changes.iter().any(|(of_row, _)| *of_row == change);
    Ok(ExitCode::from(match (has(Change::NewFailure), has(Change::NotJudged)) {
        (true, _) => 1,
        (false, true) => 4,
        (false, false) => 0,
    }))
}

/// The rows of the second report, and what became of each; then those that it has no more.
fn changes<'a>(before: &'a Report, after: &'a Report) -> Vec<(Change, &'a Row)> {
    let change = |row: &'a Row| {
        let was = before.row(&row.id).map_or(Verdict::NotJudged, |row| row.verdict);
        Change::of(was, row.verdict).map(|change| (change, row))
    };
    let gone = before.rows.iter().filter(|row| after.row(&row.id).is_none());
    let gone = gone.filter_map(|row| Change::of(row.verdict, Verdict::NotJudged).map(|change| (change, row)));
    after.rows.iter().filter_map(change).chain(gone).collect()
}

fn told(before: &Report, after: &Report, changes: &[(Change, &Row)]) -> String {
    let mut text = String::new();
    for (name, Report { date, program, seconds, ended, .. }) in [("before", before), ("after", after)] {
        // A string takes everything.
        let _ = writeln!(text, "{name}: {date} {program}, {seconds:.1} s, ended: {ended}");
    }
    tell_configuration(&mut text, before, after);
    for (change, words) in CHANGES {
        for (_, row) in changes.iter().filter(|(of_row, _)| *of_row == change) {
            let _ = writeln!(text, "{} {words}{}", row.id, why(change, row));
        }
    }
    for row in &after.rows {
        let was = before.row(&row.id).map_or(0.0, |row| row.seconds);
        if was > 0.0 && row.seconds > 2.0 * was && row.seconds > was + LONGER {
            let _ = writeln!(text, "{} takes {:.1} s, and took {was:.1} s", row.id, row.seconds);
        }
    }
    if changes.is_empty() {
        text.push_str("every row has the verdict that it had\n");
    }
    text
}

/// What was configured differently: then verdicts may differ though the master is the same.
fn tell_configuration(text: &mut String, before: &Report, after: &Report) {
    let names: std::collections::BTreeSet<&String> =
        before.configuration.keys().chain(after.configuration.keys()).collect();
    let value = |report: &Report, name: &str| {
        report.configuration.get(name).map_or("not given".into(), ToString::to_string)
    };
    for name in names {
        let (was, is) = (value(before, name), value(after, name));
        if was != is {
            let _ = writeln!(text, "configuration: {name} is {is}, and was {was}");
        }
    }
}

/// The reason, where it says why: that of a failure, or of no verdict.
fn why(change: Change, row: &Row) -> String {
    let says = match change {
        Change::NewFailure | Change::StillFails => true,
        Change::NotJudged => row.verdict == Verdict::NotJudged,
        Change::Mended | Change::Judged => false,
    };
    if says { format!(": {}", row.reason) } else { String::new() }
}

impl Report {
    fn row(&self, id: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.id == id)
    }
}

fn read(file: &Path) -> Result<Report, Failure> {
    let wrong = |error: String| Failure::Other(format!("{}: {error}", file.display()));
    let text = std::fs::read(file).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let report: Report = serde_json::from_slice(&text).map_err(|error| {
        wrong(format!("no report of a judgement, as `judge --json FILE` writes it: {error}"))
    })?;
    if report.version != VERSION {
        return Err(wrong(format!(
            "a report of version {}; this program reads version {VERSION}",
            report.version
        )));
    }
    Ok(report)
}
