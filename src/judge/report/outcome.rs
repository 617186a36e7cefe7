//! Whether a judgement says that the subject is right: no row failed, and enough was judged to say so.

use super::ReportOf;
use crate::judge::requirement::{Conclusion, Requirement, Standing};
use crate::judge::verdict::{JudgementOf, Verdict};

/// What a judgement as a whole says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It went to its end, a row of each group that applies was judged, and none failed.
    Passed,
    /// A row failed.
    Failed,
    /// Nobody came, or data exchange was never reached.
    NoExchange(String),
    /// It did not go to its end, or what must be judged was not.
    NotFinished(String),
}

impl Outcome {
    /// The exit status of the command.
    pub const fn status(&self) -> u8 {
        match self {
            Self::Passed => 0,
            Self::Failed => 1,
            Self::NoExchange(_) => 3,
            Self::NotFinished(_) => 4,
        }
    }

    /// Why there is no verdict as a whole.
    pub fn trouble(&self) -> Option<&str> {
        match self {
            Self::Passed | Self::Failed => None,
            Self::NoExchange(why) | Self::NotFinished(why) => Some(why),
        }
    }
}

impl<R: Requirement> ReportOf<R> {
    /// What the judgement as a whole says. A row that failed only because the subject ended is no verdict of a whole run.
    pub fn outcome(&self) -> Outcome {
        let standing = self.ending.standing();
        if standing == Standing::Nothing {
            return Outcome::NoExchange(self.ending.to_string());
        }
        let fails = |row: R, verdict| verdict == Verdict::Fail && !self.ending.explains(row.id());
        if self.judgements.iter().any(|judgement| fails(judgement.row, judgement.verdict)) {
            return Outcome::Failed;
        }
        if standing == Standing::Partial {
            return Outcome::NotFinished(self.ending.to_string());
        }
        self.missing().map_or(Outcome::Passed, Outcome::NotFinished)
    }

    /// What must have been judged, and was not.
    fn missing(&self) -> Option<String> {
        let judged = |row: &R| {
            let mut judged =
                self.judgements.iter().filter(|judgement| judgement.verdict != Verdict::NotJudged);
            judged.any(|judgement| judgement.row == *row)
        };
        let required: Vec<&str> =
            self.required.iter().filter(|row| !judged(row)).map(|row| row.id()).collect();
        if !required.is_empty() {
            return Some(format!("rows that must be judged were not: {}", required.join(", ")));
        }
        if self.count(Verdict::NotJudged) == self.judgements.len() {
            return Some("no row was judged".into());
        }
        // Nothing is provoked for a recording.
        if self.ending.standing() == Standing::Read {
            return None;
        }
        if R::EACH_COUNTS {
            let open = |judged: &&JudgementOf<R>| judged.verdict == Verdict::NotJudged && judged.applies;
            let open = self.judgements.iter().find(open);
            return open.map(|judged| format!("{} was not judged: {}", judged.row.id(), judged.reason));
        }
        let mut groups: Vec<&str> = self.judgements.iter().map(|judgement| judgement.row.group()).collect();
        groups.dedup();
        let unjudged: Vec<&str> = groups.into_iter().filter(|group| self.is_missed(group)).collect();
        (!unjudged.is_empty()).then(|| format!("no row of these groups was judged: {}", unjudged.join(", ")))
    }

    /// Whether rows of a group could have been judged, and none was.
    fn is_missed(&self, group: &str) -> bool {
        let rows = || self.judgements.iter().filter(move |judgement| judgement.row.group() == group);
        rows().all(|judgement| judgement.verdict == Verdict::NotJudged)
            && rows().any(|judgement| judgement.applies)
    }
}
