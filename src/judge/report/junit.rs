//! JUnit XML: a suite a group, a case a row.

use core::fmt::Write;

use super::markup::Text;
use super::{PROGRAM, ReportOf};
use crate::judge::requirement::Requirement;
use crate::judge::verdict::{JudgementOf, Verdict};

impl<R: Requirement> ReportOf<R> {
    /// The report as JUnit XML, for CI. A row is a test case and its group the suite; a row that was not judged is
    /// skipped, a warning passes and is told in `system-out`. Where there is no verdict as a whole, because
    /// nobody came or the judgement was not finished, the first case is an error.
    pub fn junit(&self) -> String {
        let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        let outcome = self.outcome();
        let trouble = outcome.trouble();
        let mut all = Counts::of(self.judgements.iter());
        all.tests += 1;
        all.errors += usize::from(trouble.is_some());
        let date = self.date.as_ref().map(|date| format!(" timestamp=\"{}\"", Text(date)));
        let _ = writeln!(
            text,
            "<testsuites name=\"{PROGRAM} judge\"{all} time=\"{:.3}\"{}>",
            self.took.as_secs_f64(),
            date.unwrap_or_default()
        );
        self.write_ending(&mut text, trouble);
        let mut groups: Vec<&str> = self.judgements.iter().map(|judgement| judgement.row.group()).collect();
        groups.dedup();
        for group in groups {
            let rows = || self.judgements.iter().filter(|judgement| judgement.row.group() == group);
            let _ = writeln!(text, "<testsuite name=\"{}\"{}>", Text(group), Counts::of(rows()));
            for judgement in rows() {
                self.write_case(&mut text, judgement);
            }
            text.push_str("</testsuite>\n");
        }
        text.push_str("</testsuites>\n");
        text
    }

    /// A suite of its own says what was configured, and whether the judgement came to its end: what is missing is an error.
    fn write_ending(&self, text: &mut String, trouble: Option<&str>) {
        let counts = Counts { tests: 1, failures: 0, errors: usize::from(trouble.is_some()), skipped: 0 };
        let _ = writeln!(text, "<testsuite name=\"The judgement\"{counts}>\n<properties>");
        for (name, value) in &self.configuration {
            let _ = writeln!(text, "<property name=\"{name}\" value=\"{}\"/>", Text(value));
        }
        text.push_str("</properties>\n<testcase classname=\"judge.The judgement\" name=\"came to its end\"");
        let _ = match trouble {
            None => writeln!(text, "/>"),
            Some(why) => {
                writeln!(text, "><error type=\"not finished\" message=\"{}\"/></testcase>", Text(why))
            }
        };
        text.push_str("</testsuite>\n");
    }

    fn write_case(&self, text: &mut String, judgement: &JudgementOf<R>) {
        let JudgementOf { row, verdict, reason, took, .. } = judgement;
        let _ = write!(
            text,
            "<testcase classname=\"judge.{}\" name=\"{} {}\" time=\"{:.3}\"",
            Text(row.group()),
            row.id(),
            Text(row.text()),
            took.as_secs_f64()
        );
        let reason = Text(reason);
        let _ = match verdict {
            Verdict::Pass => writeln!(text, "/>"),
            Verdict::NotJudged => writeln!(text, "><skipped message=\"{reason}\"/></testcase>"),
            Verdict::Fail => writeln!(
                text,
                "><failure type=\"{}\" message=\"{reason}\">{}</failure></testcase>",
                row.id(),
                Text(&self.telegram_lines(judgement))
            ),
            Verdict::Warn => writeln!(
                text,
                "><system-out>warning: {reason}\n{}</system-out></testcase>",
                Text(&self.telegram_lines(judgement))
            ),
        };
    }

    fn telegram_lines(&self, judgement: &JudgementOf<R>) -> String {
        let mut lines = String::new();
        if let Some(rule) = judgement.row.rule() {
            let _ = writeln!(lines, "the rule: {rule}");
        }
        if let Some(scenario) = &judgement.scenario {
            let _ = writeln!(lines, "while: {scenario}");
        }
        for telegram in &judgement.telegrams {
            let (at, side) = (self.seconds(telegram), telegram.side);
            let _ = writeln!(lines, "{at:>10.6}  {side:<4} {}  [{}]", telegram.explained, telegram.hex);
        }
        lines
    }
}

/// The figures of a suite.
struct Counts {
    tests: usize,
    failures: usize,
    errors: usize,
    skipped: usize,
}

impl Counts {
    fn of<'a, R: Requirement>(judgements: impl Iterator<Item = &'a JudgementOf<R>>) -> Self {
        let mut counts = Self { tests: 0, failures: 0, errors: 0, skipped: 0 };
        for judgement in judgements {
            counts.tests += 1;
            match judgement.verdict {
                Verdict::Fail => counts.failures += 1,
                Verdict::NotJudged => counts.skipped += 1,
                Verdict::Pass | Verdict::Warn => {}
            }
        }
        counts
    }
}

impl core::fmt::Display for Counts {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { tests, failures, errors, skipped } = self;
        write!(f, " tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\"")
    }
}
