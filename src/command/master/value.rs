//! Values of parameters: read, with their unit, and as JSON.

use crate::devices::ag03::param::{Access, Entry, Parameter, Subindex, Unit, Value};
use crate::explain::value::{Lengths, in_words};
use crate::host::{Clock, Link};
use crate::master::{Drive, DriveError};
use serde_json::json;

use super::device::Shown;

/// A value that was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Item {
    pub(super) entry: &'static Entry,
    pub(super) element: Option<Subindex>,
    pub(super) value: Value,
}

impl Item {
    /// Reads a parameter, or an element of one.
    pub(super) fn read<L: Link, C: Clock>(
        drive: &mut Drive<L, C>,
        entry: &'static Entry,
        element: Option<Subindex>,
    ) -> Result<Self, DriveError> {
        let value = drive.read(entry.pnu, element, entry.width)?;
        Ok(Self { entry, element, value })
    }

    /// The number it stands for.
    pub(super) fn number(&self) -> i64 {
        self.entry.number(self.value)
    }

    /// `1004`, `945.3`
    pub(super) fn place(&self) -> String {
        match self.element {
            Some(element) => format!("{}.{element}", self.entry.pnu),
            None => self.entry.pnu.to_string(),
        }
    }

    /// With its unit.
    pub(super) fn text(&self, lengths: Lengths) -> String {
        in_words(self.entry, self.value, lengths)
    }

    /// As it is shown: `1004  v-Pos  30 rpm`, in columns.
    pub(super) fn shown(&self, lengths: Lengths) -> Shown {
        Shown {
            head: format!("{:<6} {:<27}", self.place(), self.entry.name),
            text: self.text(lengths),
            number: self.number().into(),
            json: self.json(lengths),
        }
    }

    /// With the access: `1004   r/w v-Pos  30 rpm`.
    pub(super) fn row(&self, lengths: Lengths) -> String {
        let access = self.entry.access().to_string();
        format!("{:<6} {access:<3} {:<27} {}", self.place(), self.entry.name, self.text(lengths))
    }

    pub(super) fn json(&self, lengths: Lengths) -> serde_json::Value {
        let mut object = json!({
            "pnu": self.entry.pnu.number(),
            "name": self.entry.name,
            "value": self.number(),
            "unit": unit(self.entry, lengths),
            "text": self.text(lengths),
            "access": self.entry.access().to_string(),
        });
        if let (Some(element), Some(fields)) = (self.element, object.as_object_mut()) {
            fields.insert("element".into(), element.0.into());
        }
        object
    }
}

/// The unit of the number, empty for codings.
pub(super) fn unit(entry: &Entry, lengths: Lengths) -> String {
    match (entry.unit, lengths) {
        (Unit::Position, Lengths::Increments) => "inc".into(),
        (Unit::Position, Lengths::HundredthMillimetres) => "0.01 mm".into(),
        (unit, _) => unit.to_string(),
    }
}

/// Whether a value is a position, whose unit another parameter decides.
pub(super) fn is_length(entry: &Entry) -> bool {
    matches!(entry.unit, Unit::Position | Unit::Window)
}

/// What the drive counts positions in.
pub(super) fn lengths<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<Lengths, DriveError> {
    let pitch = Parameter::SpindlePitch.entry();
    Ok(Lengths::of_spindle_pitch(drive.read(pitch.pnu, None, pitch.width)?.bits()))
}

/// What a set of values says of it.
pub(super) fn lengths_in(items: &[Item]) -> Lengths {
    let pitch = items.iter().find(|item| item.entry.pnu == Parameter::SpindlePitch.entry().pnu);
    pitch.map_or(Lengths::Unknown, |item| Lengths::of_spindle_pitch(item.value.bits()))
}

/// Whether a parameter is part of a parameter set: it can be read and written.
pub(super) fn is_setting(entry: &Entry) -> bool {
    entry.access() == Access::ReadWrite
}
