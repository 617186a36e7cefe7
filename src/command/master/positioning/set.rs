//! Parameter sets in files: `save`, and what `restore` reads.
//!
//! JSON with one parameter a line, so that people and `diff` can read it:
//!
//! ```json
//! {
//!   "format": "profidrive parameter set 1",
//!   "drive": {"gear":48,"model":"ag03-1"},
//!   "parameters": [
//!     {"name":"v-Pos","pnu":1004,"text":"30 rpm","unit":"rpm","value":30},
//!     ...
//!   ]
//! }
//! ```
//!
//! Only `format`, and of each parameter `pnu` and `value`, are needed to restore it. If `drive` is there, a drive of another
//! kind takes the set only when asked twice.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use crate::devices::ag03::param::{Entry, Pnu, TABLE, parameters};
use crate::host::list::named::ParameterSpec;
use crate::host::{Clock, Link};
use crate::master::Drive;
use serde::Deserialize;
use serde_json::json;

use super::access::{about, check};
use super::value::{Item, is_setting, lengths_in};
use crate::command::Failure;
use crate::command::master::file::put;
use crate::command::master::{say, watch};

const FORMAT: &str = "profidrive parameter set 1";

/// Saves every parameter that can be written.
pub(super) fn save<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    file: &Path,
    json: bool,
) -> Result<(), Failure> {
    let identity = drive.identify()?;
    let progress = watch("reading", parameters(identity.model).filter(|entry| is_setting(entry)).count());
    let settings = drive.settings(identity.model, &mut || progress.inc(1));
    progress.finish_and_clear();
    if drive.is_stopped() {
        return Err(Failure::Other("interrupted; nothing is saved".into()));
    }
    let items: Vec<_> =
        settings?.into_iter().map(|(entry, value)| Item { entry, element: None, value }).collect();
    let text = written(&items, &about(identity));
    if file == Path::new("-") {
        return say(text.trim_end());
    }
    put(file, &text).map_err(|error| Failure::Other(format!("cannot write {}: {error}", file.display())))?;
    let count = items.len();
    if json {
        return say(json!({ "saved": count, "file": file.display().to_string() }));
    }
    say(format_args!("{count} parameters of drive {} saved in {}", drive.address(), file.display()))
}

/// The text of a file.
fn written(items: &[Item], drive: &serde_json::Value) -> String {
    let lengths = lengths_in(items);
    let rows: Vec<String> = items
        .iter()
        .map(|item| {
            let mut row = item.json(lengths);
            if let Some(fields) = row.as_object_mut() {
                // All of them can be read and written.
                fields.remove("access");
            }
            format!("    {row}")
        })
        .collect();
    let format = json!(FORMAT);
    format!(
        "{{\n  \"format\": {format},\n  \"drive\": {drive},\n  \"parameters\": [\n{}\n  ]\n}}\n",
        rows.join(",\n")
    )
}

/// What a drive shall have.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ParameterSet {
    /// Which drive it was read from, as far as the file says.
    pub(super) origin: Origin,
    /// In the order of the numbers.
    pub(super) values: Vec<(&'static Entry, i32)>,
}

/// The drive that a file names. People write files too: what is not there fits every drive.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub(super) struct Origin {
    pub(super) model: Option<String>,
    pub(super) gear: Option<u16>,
}

/// A file as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    drive: Option<Origin>,
    parameters: Vec<Row>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    pnu: u16,
    value: i64,
    name: Option<String>,
    #[expect(dead_code, reason = "for the reader of the file")]
    unit: Option<String>,
    #[expect(dead_code, reason = "for the reader of the file")]
    text: Option<String>,
}

impl ParameterSet {
    /// Reads a file, or stdin for `-`, and checks that some drive can have these values.
    pub(super) fn load(file: &Path) -> Result<Self, Failure> {
        let name = file.display();
        let mut text = String::new();
        let outcome = match file == Path::new("-") {
            true => io::stdin().lock().read_to_string(&mut text).map(drop),
            false => fs::read_to_string(file).map(|read| text = read),
        };
        outcome.map_err(|error| Failure::Other(format!("cannot read {name}: {error}")))?;
        Self::parse(&text).map_err(|line| Failure::Usage(format!("{name}: {line}")))
    }

    fn parse(text: &str) -> Result<Self, String> {
        // Editors of other systems put a mark before UTF-8.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let file: File = serde_json::from_str(text).map_err(|error| format!("no parameter set: {error}"))?;
        if file.format != FORMAT {
            return Err(format!("the format is '{}', expected '{FORMAT}'", file.format));
        }
        let mut values: Vec<(&'static Entry, i32)> = Vec::new();
        for row in file.parameters {
            let (entry, value) = row.checked()?;
            if values.iter().any(|(other, _)| other.pnu == entry.pnu) {
                return Err(format!("{} (PNU {}) is there twice", entry.name, entry.pnu));
            }
            values.push((entry, value));
        }
        if values.is_empty() {
            return Err("there is no parameter in it".into());
        }
        values.sort_by_key(|(entry, _)| entry.pnu);
        Ok(Self { origin: file.drive.unwrap_or_default(), values })
    }
}

impl Row {
    /// The parameter and the value, if some drive can have it.
    fn checked(&self) -> Result<(&'static Entry, i32), String> {
        let pnu = Pnu::new(self.pnu).ok();
        let entry = pnu.and_then(|pnu| TABLE.iter().find(|entry| entry.pnu == pnu));
        let entry = entry.ok_or_else(|| format!("there is no parameter {}", self.pnu))?;
        if self.name.as_ref().is_some_and(|name| name != entry.name) {
            let name = self.name.as_deref().unwrap_or_default();
            return Err(format!("PNU {} is {}, not {name}", entry.pnu, entry.name));
        }
        if !is_setting(entry) {
            return Err(format!("{} (PNU {}) is no setting of the drive", entry.name, entry.pnu));
        }
        match check(&ParameterSpec { entry, element: None }, self.value, "restore") {
            Ok(()) => Ok((entry, i32::try_from(self.value).unwrap_or(i32::MAX))),
            Err(Failure::Usage(line) | Failure::Other(line)) => {
                Err(line.split(';').next().unwrap_or_default().into())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::devices::ag03::param::{Model, Value};

    use super::*;

    #[test]
    fn a_written_set_is_read_as_it_was() {
        let items: Vec<Item> = parameters(Model::Ag03_1)
            .filter(|entry| is_setting(entry))
            .map(|entry| Item { entry, element: None, value: Value::of(entry.width, 50) })
            .filter(|item| ![930, 1013, 1014, 1021, 1022].contains(&item.entry.pnu.number()))
            .collect();
        let text = written(&items, &json!({ "model": "ag03-1", "gear": 48 }));
        let values: Vec<_> = items.iter().map(|item| (item.entry, 50)).collect();
        let origin = Origin { model: Some("ag03-1".into()), gear: Some(48) };
        let expected = Ok(ParameterSet { origin, values });
        assert_eq!(ParameterSet::parse(&text), expected);
        assert_eq!(ParameterSet::parse(&format!("\u{feff}{text}")), expected, "with a byte order mark");
        assert!(text.contains("\n    {\"name\":\"v-Pos\",\"pnu\":1004,\"text\":\"50 rpm\""), "{text}");
    }

    #[test]
    fn what_is_no_set_is_refused_with_the_wrong_part() {
        let rows = |rows: &str| format!(r#"{{"format":"{FORMAT}","parameters":[{rows}]}}"#);
        for (text, says) in [
            ("".into(), "no parameter set: EOF"),
            ("[]".into(), "no parameter set: "),
            (rows(""), "there is no parameter in it"),
            (r#"{"format":"x","parameters":[]}"#.into(), "the format is 'x', expected 'profidrive parameter"),
            (rows(r#"{"pnu":999,"value":1}"#), "there is no parameter 999"),
            (rows(r#"{"pnu":1004,"value":201}"#), "v-Pos (PNU 1004) takes 1 to 200, got 201"),
            (rows(r#"{"pnu":1004,"value":1,"name":"v-Inch"}"#), "PNU 1004 is v-Pos, not v-Inch"),
            (rows(r#"{"pnu":952,"value":1}"#), "Number of faults (PNU 952) is no setting"),
            (rows(r#"{"pnu":970,"value":1}"#), "is no setting"),
            (rows(r#"{"pnu":1004,"value":1},{"pnu":1004,"value":1}"#), "is there twice"),
            (rows(r#"{"pnu":1004}"#), "missing field `value`"),
            (rows(r#"{"pnu":1004,"value":1,"speed":2}"#), "unknown field `speed`"),
        ] {
            let error = ParameterSet::parse(&text).unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
