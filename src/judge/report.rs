//! What a judgement says.
//!
//! | file | holds |
//! | --- | --- |
//! | here | [`ReportOf`]: JSON for programs, a table for a terminal |
//! | `outcome` | [`Outcome`]: whether the subject is right, and whether enough was judged to say so |
//! | `junit` | JUnit XML, for CI |
//! | `html` | one page for people |
//! | `diagram` | the telegrams of a verdict as a drawing |
//! | `figures` | the traffic in figures, and as a plot |
//! | `markup` | texts inside XML and HTML |

use core::fmt::{self, Write};
use core::time::Duration;

use super::figures::Figures;
use super::moment::Telegram;
use super::requirement::{Conclusion, Requirement, Standing};
use super::verdict::{JudgementOf, Verdict};
use crate::profibus::fdl::Address;
use crate::time::Instant;

mod diagram;
mod figures;
mod html;
mod junit;
mod markup;
mod outcome;

pub use outcome::Outcome;

/// This program and its version.
const PROGRAM: &str = concat!("profidrive ", env!("CARGO_PKG_VERSION"));
/// The option that may be given more than once.
const STATION: &str = "station";

/// The verdicts on the rows, and how the judgement ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportOf<R: Requirement> {
    /// One verdict a row, in the order of the table.
    pub judgements: Vec<JudgementOf<R>>,
    /// How it ended.
    pub ending: R::Ending,
    /// Rows that must be judged: without a verdict on each of them it is not finished.
    pub required: Vec<R>,
    /// When it began, in words; `None`: nobody said.
    pub date: Option<String>,
    /// What was configured: options of the command, and their values.
    pub configuration: Vec<(&'static str, String)>,
    /// Times of telegrams count from here.
    pub origin: Instant,
    /// How long it took; zero for a recording.
    pub took: Duration,
    /// The traffic in figures.
    pub figures: Figures,
    /// The watchdog time that the master has set in each station.
    pub watchdogs: Vec<(Address, Duration)>,
}

impl<R: Requirement> ReportOf<R> {
    pub(super) fn new(judgements: Vec<JudgementOf<R>>, ending: R::Ending, origin: Instant) -> Self {
        Self {
            judgements,
            ending,
            required: Vec::new(),
            date: None,
            configuration: Vec::new(),
            origin,
            took: Duration::ZERO,
            figures: Figures::default(),
            watchdogs: Vec::new(),
        }
    }

    /// How many rows have this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.judgements.iter().filter(|judgement| judgement.verdict == verdict).count()
    }

    /// Seconds since the origin.
    pub fn seconds(&self, telegram: &Telegram) -> f64 {
        telegram.at.saturating_since(self.origin).as_secs_f64()
    }

    /// The report as JSON: `{"version":1,"rows":[..]}`.
    pub fn json(&self) -> String {
        let mut text = String::from("{\"version\":1,");
        let _ = write!(text, "\"ended\":{},", Quoted(&std::format!("{}", self.ending)));
        let _ = write!(text, "\"status\":{},", self.outcome().status());
        let _ = write!(text, "\"program\":{},", Quoted(PROGRAM));
        let _ = write!(text, "\"seconds\":{:.3},", self.took.as_secs_f64());
        if let Some(date) = &self.date {
            let _ = write!(text, "\"date\":{},", Quoted(date));
        }
        self.write_configuration(&mut text);
        self.write_figures_json(&mut text);
        text.push_str("\"rows\":[");
        for (number, judgement) in self.judgements.iter().enumerate() {
            if number > 0 {
                text.push(',');
            }
            self.write_row(&mut text, judgement);
        }
        text.push_str("\n]}\n");
        text
    }

    /// The stations as a list, the rest by name.
    fn write_configuration(&self, text: &mut String) {
        let is_station = |(name, _): &&(&str, String)| *name == STATION;
        text.push_str("\"configuration\":{\"stations\":[");
        for (number, (_, value)) in self.configuration.iter().filter(is_station).enumerate() {
            let _ = write!(text, "{}{}", if number > 0 { "," } else { "" }, Quoted(value));
        }
        text.push(']');
        for (name, value) in self.configuration.iter().filter(|option| !is_station(option)) {
            let _ = write!(text, ",{}:{}", Quoted(name), Quoted(value));
        }
        text.push_str("},");
    }

    fn write_row(&self, text: &mut String, judgement: &JudgementOf<R>) {
        let JudgementOf { row, verdict, reason, telegrams, scenario, took, .. } = judgement;
        let _ = write!(
            text,
            "\n{{\"id\":\"{}\",\"verdict\":\"{}\",\"reason\":{},\"text\":{},\"seconds\":{:.3},",
            row.id(),
            verdict.name(),
            Quoted(reason),
            Quoted(row.text()),
            took.as_secs_f64()
        );
        if let Some(rule) = row.rule() {
            let _ = write!(text, "\"rule\":{},", Quoted(rule));
        }
        if let Some(scenario) = scenario {
            let _ = write!(text, "\"scenario\":{},", Quoted(scenario));
        }
        text.push_str("\"telegrams\":[");
        for (number, telegram) in telegrams.iter().enumerate() {
            let Telegram { side, hex, explained, .. } = telegram;
            let _ = write!(
                text,
                "{}{{\"t\":{:.6},\"from\":\"{}\",\"hex\":\"{}\",\"explained\":{}}}",
                if number > 0 { "," } else { "" },
                self.seconds(telegram),
                side,
                hex,
                Quoted(explained)
            );
        }
        text.push_str("]}");
    }
}

impl Verdict {
    /// As JSON has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Warn => "warn",
            Self::NotJudged => "not_judged",
        }
    }
}

/// Telegrams of one failure on a terminal.
const SHOWN: usize = 8;

impl<R: Requirement> fmt::Display for ReportOf<R> {
    /// Failures and warnings first, with their telegrams; then a line a row.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for verdict in [Verdict::Fail, Verdict::Warn] {
            for judgement in self.judgements.iter().filter(|judgement| judgement.verdict == verdict) {
                let JudgementOf { row, reason, telegrams, .. } = judgement;
                writeln!(f, "{} {}  {}", verdict.name().to_uppercase(), row.id(), row.text())?;
                writeln!(f, "     {reason}")?;
                if let Some(rule) = row.rule() {
                    writeln!(f, "     the rule: {rule}")?;
                }
                if let Some(scenario) = &judgement.scenario {
                    writeln!(f, "     while: {scenario}")?;
                }
                for telegram in telegrams.iter().skip(telegrams.len().saturating_sub(SHOWN)) {
                    let Telegram { side, hex, explained, .. } = telegram;
                    let at = self.seconds(telegram);
                    writeln!(f, "     {at:>10.6}  {side:<4} {explained}  [{hex}]")?;
                }
                writeln!(f)?;
            }
        }
        let mut group = None;
        for JudgementOf { row, verdict, reason, .. } in &self.judgements {
            if group.replace(row.group()) != Some(row.group()) {
                writeln!(f, "{}", row.group())?;
            }
            writeln!(f, "  {:<10} {}  {}", verdict.name(), row.id(), row.text())?;
            if *verdict == Verdict::NotJudged {
                writeln!(f, "             {reason}")?;
            }
        }
        let count = |verdict| self.count(verdict);
        let took = (!self.took.is_zero()).then(|| std::format!(", {:.1} s", self.took.as_secs_f64()));
        writeln!(
            f,
            "\n{} passed, {} failed, {} warnings, {} not judged{}",
            count(Verdict::Pass),
            count(Verdict::Fail),
            count(Verdict::Warn),
            count(Verdict::NotJudged),
            took.unwrap_or_default()
        )?;
        self.write_figures_line(f)?;
        if let Outcome::NotFinished(why) = self.outcome()
            && self.ending.standing() != Standing::Partial
        {
            writeln!(f, "not finished: {why}")?;
        }
        writeln!(f, "ended: {}", self.ending)
    }
}

/// A text as JSON has it.
struct Quoted<'a>(&'a str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_char('"')?;
        for c in self.0.chars() {
            match c {
                '"' => f.write_str("\\\"")?,
                '\\' => f.write_str("\\\\")?,
                c if c.is_control() => write!(f, "\\u{:04x}", u32::from(c))?,
                c => f.write_char(c)?,
            }
        }
        f.write_char('"')
    }
}
