//! `judge compare A.json B.json`: what the second judgement says that the first did not.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use serde::Deserialize;

use crate::command::Failure;

/// A report, as far as it is compared.
#[derive(Debug, Deserialize)]
struct Report {
    ended: String,
    status: u8,
    #[serde(default)]
    date: String,
    #[serde(default)]
    program: String,
    rows: Vec<Row>,
}

#[derive(Debug, Deserialize)]
struct Row {
    id: String,
    verdict: String,
    reason: String,
}

/// What became of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    NewFailure,
    StillFails,
    Mended,
    NotJudged,
    Judged,
}

const CHANGES: [(Change, &str); 5] = [
    (Change::NewFailure, "fails, and did not"),
    (Change::StillFails, "fails still"),
    (Change::Mended, "no longer fails"),
    (Change::NotJudged, "is no longer judged"),
    (Change::Judged, "is judged, and was not"),
];

impl Change {
    fn of(before: &str, after: &str) -> Option<Self> {
        match (before, after) {
            ("fail", "fail") => Some(Self::StillFails),
            (_, "fail") => Some(Self::NewFailure),
            ("not_judged", "not_judged") => None,
            (_, "not_judged") => Some(Self::NotJudged),
            ("fail", _) => Some(Self::Mended),
            ("not_judged", _) => Some(Self::Judged),
            (_, _) => None,
        }
    }
}

/// Compares two reports. The status is 1 if a row fails that did not, 4 if less is known than before, otherwise 0.
pub(super) fn compare(before: &Path, after: &Path) -> Result<ExitCode, Failure> {
    let (before, after) = (read(before)?, read(after)?);
    let changes = changes(&before, &after);
    let mut text = Vec::new();
    // A vector takes everything.
    for (name, report) in [("before", &before), ("after", &after)] {
        let _ = writeln!(text, "{name}: {} {} ended: {}", report.date, report.program, report.ended);
    }
    for (change, words) in CHANGES {
        for (_, row) in changes.iter().filter(|(of_row, _)| *of_row == change) {
            let _ = writeln!(text, "{} {words}: {}", row.id, row.reason);
        }
    }
    if changes.is_empty() {
        let _ = writeln!(text, "every row has the verdict that it had");
    }
    let mut stdout = io::stdout().lock();
    // Nobody may read it any more.
    let _ = stdout.write_all(&text).and_then(|()| stdout.flush());
    let has = |change: Change| changes.iter().any(|(of_row, _)| *of_row == change);
    let less = has(Change::NotJudged) || after.status > before.status.max(1);
    Ok(ExitCode::from(if has(Change::NewFailure) { 1 } else { u8::from(less) * 4 }))
}

fn changes<'a>(before: &'a Report, after: &'a Report) -> Vec<(Change, &'a Row)> {
    let was: BTreeMap<&str, &str> =
        before.rows.iter().map(|row| (row.id.as_str(), row.verdict.as_str())).collect();
    let change = |row: &'a Row| {
        let was = was.get(row.id.as_str()).copied().unwrap_or("not_judged");
        Change::of(was, &row.verdict).map(|change| (change, row))
    };
    after.rows.iter().filter_map(change).collect()
}

fn read(file: &Path) -> Result<Report, Failure> {
    let wrong = |error: String| Failure::Other(format!("{}: {error}", file.display()));
    let text = std::fs::read(file).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    serde_json::from_slice(&text).map_err(|error| wrong(format!("no report of a judgement: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pair_of_verdicts_has_its_change() {
        for (before, after, change) in [
            ("pass", "fail", Some(Change::NewFailure)),
            ("not_judged", "fail", Some(Change::NewFailure)),
            ("fail", "fail", Some(Change::StillFails)),
            ("fail", "pass", Some(Change::Mended)),
            ("fail", "not_judged", Some(Change::NotJudged)),
            ("warn", "not_judged", Some(Change::NotJudged)),
            ("not_judged", "pass", Some(Change::Judged)),
            ("not_judged", "not_judged", None),
            ("pass", "warn", None),
        ] {
            assert_eq!(Change::of(before, after), change, "{before}, {after}");
        }
    }
}
