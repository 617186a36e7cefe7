//! What can be chosen about a device, as rows, and what was chosen.

use core::fmt;
use std::path::{Path, PathBuf};

use super::Given;
use crate::face::{Quirk, QuirkError};
use crate::gsd::did_you_mean;

/// Something that can be chosen about a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Choice {
    /// Its key in `key=value`, in TOML and in JSON.
    pub(crate) key: &'static str,
    /// Another key that means the same.
    pub(crate) also: Option<&'static str>,
    /// What it decides.
    pub(crate) about: &'static str,
    /// What it may be.
    pub(crate) takes: Takes,
    /// Whether the device cannot be without it.
    pub(crate) required: bool,
}

/// What a [`Choice`] may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Takes {
    /// One of these words or numbers, and which it is unless given.
    OneOf(&'static [&'static str], Option<&'static str>),
    /// Up to four hexadecimal digits.
    Hexadecimal,
    /// The path of a file whose name has one of these endings; none: any.
    File(&'static [&'static str]),
    /// Yes, or no unless given.
    Flag,
    /// Names in an order.
    Names,
    /// Quirks of the device: name and value.
    Quirks,
    /// Parameters by number or name, and a number for each.
    Values,
    /// Inputs, each with what it follows.
    Inputs,
    /// Objects of a node, each with what it follows.
    Objects,
    /// Diagnoses, each with its time.
    Diagnosis,
    /// Records of DP-V1: a list of tables with the keys of `acyclic::RECORD`.
    Records,
    /// Alarms on the time line: a list of tables with the keys of `acyclic::ALARM`.
    Alarms,
}

impl Choice {
    /// One that need not be given.
    pub(super) const fn of(key: &'static str, takes: Takes, about: &'static str) -> Self {
        Self { key, also: None, about, takes, required: false }
    }

    /// Whether it has this key.
    pub(crate) fn is(&self, key: &str) -> bool {
        self.key == key || self.also == Some(key)
    }

    /// As in `[,gear=24|48]`, without brackets if it is required; nothing for what has no form in one line.
    pub(super) fn form(&self, required: bool) -> String {
        let key = self.key;
        let form = match self.takes {
            Takes::OneOf(known, _) => format!(",{key}={}", known.join("|")),
            Takes::Hexadecimal => format!(",{key}=HEX"),
            Takes::File([]) => format!(",{key}=FILE"),
            Takes::File(endings) => {
                let files: Vec<_> = endings.iter().map(|ending| format!("FILE.{ending}")).collect();
                format!(",{key}={}", files.join("|"))
            }
            Takes::Flag => format!(",{key}"),
            Takes::Inputs => return format!("[,{key}=SLOT/OCTET/TYPE:BEHAVIOUR:KEY=VALUE]..."),
            Takes::Names
            | Takes::Quirks
            | Takes::Values
            | Takes::Objects
            | Takes::Diagnosis
            | Takes::Records
            | Takes::Alarms => {
                return String::new();
            }
        };
        if required { form } else { format!("[{form}]") }
    }

    /// Takes what was given, if it is one of those that can be. Paths begin in `folder`.
    pub(super) fn pick(&self, given: &Given, folder: &Path) -> Result<Picked, String> {
        let key = self.key;
        match (self.takes, given) {
            (Takes::OneOf(known, _), Given::Text(_) | Given::Number(_)) => {
                let text = given.to_string();
                let found = known.iter().find(|word| **word == text).map(|word| Picked::Word(word));
                found.ok_or_else(|| {
                    let near = near(&text, known.iter().copied());
                    format!("{key} '{text}' is unknown; {near}expected {}", one_of(known))
                })
            }
            (Takes::Hexadecimal, Given::Text(text)) => {
                let digits = text.strip_prefix("0x").unwrap_or(text);
                u16::from_str_radix(digits, 16).map(Picked::Hexadecimal).map_err(|_| {
                    format!("{key} '{text}' is no {key} number; expected four hexadecimal digits, for example 5044")
                })
            }
            (Takes::File(_), Given::Text(text)) if text.is_empty() => {
                Err(format!("the name of the file of '{key}' is empty"))
            }
            (Takes::File(_), Given::Text(text)) => Ok(Picked::File(folder.join(text))),
            (Takes::Flag, Given::Flag(on)) => Ok(Picked::Flag(*on)),
            (Takes::Names, Given::List(names)) => {
                let name = |name: &Given| {
                    let Given::Text(text) = name else {
                        return Err(format!("{key}: {name} is no name; expected text"));
                    };
                    Ok(text.clone())
                };
                names.iter().map(name).collect::<Result<_, _>>().map(Picked::Names)
            }
            (takes, other) => Err(format!("{key}: expected {}, not {other}", takes.kind())),
        }
    }
}

impl Takes {
    /// What is expected, in words.
    const fn kind(self) -> &'static str {
        match self {
            Self::OneOf(..) => "a word or a number",
            Self::Hexadecimal => "text with four hexadecimal digits, for example \"5044\"",
            Self::File(_) => "the name of a file",
            Self::Flag => "true or false",
            Self::Names => "a list of names",
            Self::Quirks => "a table of names and values",
            Self::Values => "a table of names and numbers",
            Self::Inputs => "a list of inputs",
            Self::Objects => "a list of objects",
            Self::Diagnosis => "a list of diagnoses",
            Self::Records => "a list of records",
            Self::Alarms => "a list of alarms",
        }
    }
}

/// `did you mean X? `, or nothing.
pub(super) fn near<'a>(text: &str, known: impl Iterator<Item = &'a str>) -> String {
    did_you_mean(text, known).map(|near| format!("did you mean {near}? ")).unwrap_or_default()
}

/// `a`, `a or b`, `a, b or c`.
pub(super) fn one_of(known: &[&str]) -> String {
    match known.split_last() {
        Some((last, [])) => (*last).to_owned(),
        Some((last, first)) => format!("{} or {last}", first.join(", ")),
        None => String::new(),
    }
}

/// One thing that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Picked {
    Word(&'static str),
    Hexadecimal(u16),
    File(PathBuf),
    Flag(bool),
    Names(Vec<String>),
}

/// What is chosen about a device; what is not, is as its rows say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choices {
    pub(super) picked: Vec<(&'static str, Picked)>,
    /// Its quirks, by name.
    pub(super) quirks: Vec<(&'static str, &'static str)>,
    /// What its parameters begin with, by number or name.
    pub(super) values: Vec<(String, f64)>,
    /// Its inputs, as they were given, and where paths in them begin.
    pub(super) inputs: (Vec<Given>, PathBuf),
    /// What its diagnosis reports, as it was given.
    pub(super) diagnoses: Vec<Given>,
    /// Its records and its alarms on the time line, as they were given.
    pub(super) records: Vec<Given>,
    pub(super) alarms: Vec<Given>,
}

impl Choices {
    /// One word, of these choices.
    pub(in crate::host) fn of_word(choices: &[Choice], key: &str, word: &str) -> Option<Self> {
        let choice = choices.iter().find(|choice| choice.is(key))?;
        let picked = choice.pick(&Given::Text(word.to_owned()), Path::new("")).ok()?;
        Some(Self { picked: std::vec![(choice.key, picked)], ..Self::default() })
    }

    fn picked(&self, key: &str) -> Option<&Picked> {
        self.picked.iter().find(|(known, _)| *known == key).map(|(_, picked)| picked)
    }

    /// The word of a choice, if one was chosen.
    pub(crate) fn word(&self, key: &str) -> Option<&'static str> {
        let Picked::Word(word) = self.picked(key)? else { return None };
        Some(word)
    }

    /// The number of a choice, if one was chosen.
    pub(super) fn hexadecimal(&self, key: &str) -> Option<u16> {
        let Picked::Hexadecimal(number) = self.picked(key)? else { return None };
        Some(*number)
    }

    /// The file of a choice, if one was chosen.
    pub(crate) fn file(&self, key: &str) -> Option<&Path> {
        let Picked::File(file) = self.picked(key)? else { return None };
        Some(file)
    }

    /// The names of a choice, if some were chosen.
    pub(super) fn names(&self, key: &str) -> Option<&[String]> {
        let Picked::Names(names) = self.picked(key)? else { return None };
        Some(names)
    }

    /// Whether a flag was set.
    pub(crate) fn flag(&self, key: &str) -> bool {
        matches!(self.picked(key), Some(Picked::Flag(true)))
    }

    /// Chooses the value of a quirk of `rows`.
    pub(in crate::host) fn quirk(
        &mut self,
        rows: &[QuirkRow],
        name: &str,
        value: &str,
    ) -> Result<(), QuirkError> {
        let row = rows.iter().find(|row| row.name == name).ok_or(QuirkError::Unknown)?;
        let refused = QuirkError::Value { name: row.name, values: row.values };
        let value = row.values.iter().find(|known| **known == value).ok_or(refused)?;
        self.quirks.retain(|(known, _)| *known != row.name);
        self.quirks.push((row.name, value));
        Ok(())
    }

    /// Sets the quirks that are chosen.
    pub(super) fn apply<C>(&self, table: &[Quirk<C>], config: &mut C) {
        for (name, value) in &self.quirks {
            // Both are of the table.
            let _ = Quirk::set(table, config, name, value);
        }
    }
}

/// A point on which the manual of a device contradicts itself or leaves a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct QuirkRow {
    /// Its name in `NAME=VALUE`.
    pub(crate) name: &'static str,
    /// What it decides.
    pub(crate) about: &'static str,
    /// What it may be; the first is the default.
    pub(crate) values: &'static [&'static str],
}

/// The rows of a table.
pub(super) fn rows<C>(table: &'static [Quirk<C>]) -> Vec<QuirkRow> {
    table.iter().map(|Quirk { name, about, values, .. }| QuirkRow { name, about, values }).collect()
}

/// Why a quirk cannot be chosen. `device` is who has the `rows`.
pub(super) fn quirk_refusal(
    device: &str,
    rows: &[QuirkRow],
    name: &str,
    value: &str,
    error: QuirkError,
) -> String {
    match error {
        QuirkError::Unknown if rows.is_empty() => format!("quirk '{name}' is unknown; {device} has none"),
        QuirkError::Unknown => {
            let names: Vec<_> = rows.iter().map(|row| row.name).collect();
            let near = near(name, names.iter().copied());
            format!("quirk '{name}' is unknown; {near}{device} has {}", names.join(", "))
        }
        QuirkError::Value { name, values } => {
            format!("quirk {name} cannot be '{value}'; expected {}", values.join(" or "))
        }
    }
}

impl fmt::Display for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(on) => on.fmt(f),
            Self::Number(number) => number.fmt(f),
            Self::Text(text) => text.fmt(f),
            Self::List(_) => f.write_str("a list"),
            Self::Table(_) => f.write_str("a table"),
        }
    }
}
