//! What is said of a row.

use core::time::Duration;

use super::moment::Telegram;
use super::requirement::Requirement;

/// What is said of a row in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Verdict {
    /// It held at every occasion.
    Pass,
    /// It was broken.
    Fail,
    /// It was broken, and the sources are not sure of it.
    Warn,
    /// There was no occasion, or it cannot be seen here.
    NotJudged,
}

/// The verdict on a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JudgementOf<R> {
    /// The row.
    pub row: R,
    /// What is said of it.
    pub verdict: Verdict,
    /// Why, in plain words.
    pub reason: String,
    /// The telegrams that show it.
    pub telegrams: Vec<Telegram>,
    /// Whether it could have been judged here. `false` where it needs something that is not there: an option, another
    /// station, a link that shows bit times.
    pub applies: bool,
    /// The scenario in which it was broken first; `None`: nothing was disturbed, or it was not broken.
    pub scenario: Option<String>,
    /// How long scenarios of this row were played, with those that other rows share.
    pub took: Duration,
}

impl<R: Requirement> JudgementOf<R> {
    /// A row of which nothing can be said, and why.
    pub(super) const fn not_judged(row: R, reason: String) -> Self {
        Self {
            row,
            verdict: Verdict::NotJudged,
            reason,
            telegrams: Vec::new(),
            applies: true,
            scenario: None,
            took: Duration::ZERO,
        }
    }
}
