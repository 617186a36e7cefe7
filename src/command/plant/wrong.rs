//! What is wrong with the file, and where.

use core::fmt::Display;
use core::ops::Range;

use profidrive::gsd::did_you_mean;

use crate::command::Failure;

/// One thing that is wrong.
#[derive(Debug)]
pub(super) struct Wrong {
    span: Range<usize>,
    words: String,
}

impl Wrong {
    pub(super) fn at(span: Range<usize>, words: impl Display) -> Self {
        Self { span, words: words.to_string() }
    }

    /// What the parser of TOML says, with a cure where one word is near another.
    pub(super) fn of_toml(error: &toml::de::Error) -> Self {
        let said = error.message();
        let words: Vec<&str> = said.split('`').skip(1).step_by(2).collect();
        let near = match words.split_first() {
            Some((got, known)) if said.starts_with("unknown ") => did_you_mean(got, known.iter().copied()),
            Some(_) | None => None,
        };
        let cure = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        Self::at(error.span().unwrap_or_default(), format!("{}{cure}", said.replace('\n', " ")))
    }

    /// `plant.toml: line 3, column 5: ...`
    pub(super) fn in_file(&self, name: &dyn Display, text: &str) -> Failure {
        let before = text.get(..self.span.start).unwrap_or(text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        Failure::Usage(format!("{name}: line {line}, column {column}: {}", self.words))
    }
}

/// The words of a failure.
pub(super) fn words(failure: Failure) -> String {
    match failure {
        Failure::Usage(words) | Failure::Other(words) => words,
    }
}
