//! Each row is broken by a planted mistake, or docs/judge.md says why it cannot be seen on the wire.

use std::collections::BTreeSet;

use profidrive::judge::{Requirement as _, Row, Verdict};

use crate::operated::ASKED;
use crate::rates::AT_RATES;
use crate::ring::AT_RESTART;
use crate::test_master::mistakes::{MISTAKES, Mistake};
use crate::virtual_time::{is_long, judged};

/// Rows that a mistake of another row always breaks, too.
const BESIDE: &[(Row, Mistake)] = &[
    (Row::T05, Mistake::ShortIdle),
    (Row::G02, Mistake::LongOutputs),
    (Row::G03, Mistake::OtherSpecial),
    (Row::B04, Mistake::ForgetsAbsent),
];
/// The same for a mistake that is seen only if somebody operates the master: its main row is Z02.
const BESIDE_ASKED: &[Row] = &[Row::O11];

/// The rows of the table in the documentation.
fn unseen() -> BTreeSet<&'static str> {
    let manual = include_str!("../../docs/judge.md");
    let (_, section) = manual.split_once("## Rows that cannot be seen on the wire").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let rows = section
        .lines()
        .filter_map(|line| line.strip_prefix("| M-"))
        .filter_map(|line| line.split_once(" | "));
    let rows = rows.flat_map(|(rows, why)| {
        assert!(why.len() > 20, "{rows} has no reason");
        rows.split(", ").map(|row| row.trim_start_matches("M-"))
    });
    rows.map(|id| Row::named(&format!("M-{id}")).unwrap_or_else(|| panic!("M-{id} is no row")).id()).collect()
}

#[test]
fn every_row_has_a_mistake_or_a_reason() {
    let unseen = unseen();
    let mut found: BTreeSet<&str> = MISTAKES.iter().filter_map(|(_, rows)| rows.first()).copied().collect();
    found.extend(ASKED.iter().filter_map(|(_, rows)| rows.first()).map(|row| row.id()));
    found.extend(BESIDE.iter().map(|(row, _)| row.id()).chain(BESIDE_ASKED.iter().map(|row| row.id())));
    found.insert(AT_RESTART.1.id());
    found.insert(crate::acyclic::OPERATED.1.id());
    found.extend(AT_RATES.iter().map(|(_, row)| row.id()));
    for row in Row::ALL {
        let (seen, excused) = (found.contains(row.id()), unseen.contains(row.id()));
        assert!(seen || excused, "{} has neither a planted mistake nor a reason in docs/judge.md", row.id());
        assert!(
            !(seen && excused),
            "{} has a planted mistake; docs/judge.md says it cannot be seen",
            row.id()
        );
    }
}

#[test]
fn rows_beside_others_are_broken_with_them() {
    for (row, mistake) in BESIDE {
        let report = judged(Some(*mistake), if is_long() { Row::ALL } else { core::slice::from_ref(row) });
        let judgement = report.judgements.iter().find(|judgement| judgement.row == *row).unwrap();
        assert!(matches!(judgement.verdict, Verdict::Fail | Verdict::Warn), "{mistake:?}: {report}");
    }
}
