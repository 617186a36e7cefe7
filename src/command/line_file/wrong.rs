//! What is wrong with the file, and where.

use core::fmt::Display;
use core::ops::Range;

use crate::gsd::did_you_mean;
use crate::host::list::{self, Group, Spec};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::command::Failure;

/// One thing that is wrong.
#[derive(Debug)]
pub(super) struct Wrong {
    place: Place,
    words: String,
}

/// Where it stands.
#[derive(Debug)]
enum Place {
    Span(Range<usize>),
    /// Keys and places in lists, from the outside in.
    Path {
        path: Vec<String>,
        is_key: bool,
    },
}

impl Wrong {
    pub(super) fn at(span: Range<usize>, words: impl Display) -> Self {
        Self { place: Place::Span(span), words: words.to_string() }
    }

    /// What is wrong with the specification of a device, whose table is at `table`.
    pub(super) fn of_spec(table: &TablePath, wrong: list::Wrong) -> Self {
        let list::Wrong { path, is_key, words } = wrong;
        let path = table.0.iter().cloned().chain(path).collect();
        Self { place: Place::Path { path, is_key }, words }
    }

    /// What is wrong with the place of a device.
    pub(super) fn at_place(table: &TablePath, spec: &Spec, words: String) -> Self {
        let path = table.0.iter().cloned().chain([spec.device.group().place_key().to_owned()]).collect();
        Self { place: Place::Path { path, is_key: false }, words }
    }

    /// What the parser of TOML says, with a cure where one word is near another.
    pub(super) fn of_toml(error: &toml::de::Error, text: &str) -> Self {
        let span = error.span().unwrap_or_default();
        let said = match error.message() {
            "duplicate key" => format!("'{}' is there twice", text.get(span.clone()).unwrap_or_default()),
            said => plain(said).unwrap_or_else(|| said.replace('\n', " ")),
        };
        let words: Vec<&str> = said.split('`').skip(1).step_by(2).collect();
        let near = match words.split_first() {
            Some((got, known)) if said.starts_with("unknown ") => did_you_mean(got, known.iter().copied()),
            Some(_) | None => None,
        };
        let cure = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        if text.trim_start().starts_with('{') {
            return Self::at(span, format!("this looks like JSON, and a line file is TOML: {said}{cure}"));
        }
        Self::at(span, format!("{said}{cure}"))
    }

    /// `line.toml: line 3, column 5: ...`
    pub(super) fn in_file(&self, name: &dyn Display, text: &str) -> Failure {
        let start = match &self.place {
            Place::Span(span) => span.start,
            Place::Path { path, is_key } => start(text, path, *is_key).unwrap_or_default(),
        };
        let before = text.get(..start).unwrap_or(text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        Failure::Usage(format!("{name}: line {line}, column {column}: {}", self.words))
    }
}

/// What the parser says of a value of another type, in the words of a person who writes the file.
fn plain(said: &str) -> Option<String> {
    let (got, expected) = said.strip_prefix("invalid type: ")?.split_once(", expected ")?;
    let expected = match expected {
        "f64" | "f32" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" | "i16" | "i32" | "i64" => "a whole number",
        "a boolean" => "true or false",
        "a string" => "a text in quotation marks",
        "a sequence" => "a list in brackets",
        other => other,
    };
    let got = match got.split_once(' ') {
        None if got == "map" => "a table".to_owned(),
        None if got == "sequence" => "a list".to_owned(),
        Some(("string", text)) => format!("the text {text}"),
        Some(("integer" | "boolean", value)) => value.replace('`', ""),
        Some(("floating", value)) => value.replace("point ", "").replace('`', ""),
        Some(_) | None => got.to_owned(),
    };
    Some(format!("expected {expected}, got {got}"))
}

/// Where the table of a device is.
pub(super) struct TablePath(Vec<String>);

impl TablePath {
    /// The device of this number in its list, of the line of this number; both from 0.
    pub(super) fn new(line: usize, group: Group, device: usize) -> Self {
        let [line, device] = [line, device].map(|number| number.to_string());
        Self(vec!["line".to_owned(), line, group.name().to_owned(), device])
    }
}

/// Where the last key of a path stands, or its value; of the longest part of the path that is there.
fn start(text: &str, path: &[String], is_key: bool) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let mut start = None;
    let mut within: Option<&Spanned<DeValue<'_>>> = None;
    for (depth, step) in path.iter().enumerate() {
        let entry = match within.map(Spanned::get_ref) {
            None => table.get_ref().get_key_value(step.as_str()),
            Some(DeValue::Table(table)) => table.get_key_value(step.as_str()),
            Some(DeValue::Array(list)) => {
                within = step.parse().ok().and_then(|place: usize| list.get(place));
                start = within.map(|value| value.span().start).or(start);
                continue;
            }
            Some(_) => None,
        };
        let Some((key, value)) = entry else { break };
        let wants_key = is_key && depth + 1 == path.len();
        start = Some(if wants_key { key.span().start } else { value.span().start });
        within = Some(value);
    }
    start
}
