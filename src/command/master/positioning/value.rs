//! Values of parameters: read, with their unit, and as JSON.

use crate::devices::ag03::param::{Access, Entry, Parameter, Subindex, Unit, Value};
use crate::explain::value::{Lengths, in_words};
use crate::host::{Clock, Link};
use crate::master::{Drive, DriveError};
use serde_json::json;

use crate::command::Failure;
use crate::command::args::Quantity;
use crate::command::master::device::Shown;

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

/// The number that a master writes.
pub(super) fn number_of(value: &Quantity, entry: &Entry) -> Result<i64, Failure> {
    let name = format!("{} (PNU {})", entry.name, entry.pnu);
    value.number_in(&name, entry.unit.written()).map_err(Failure::Usage)
}

/// Refuses a position in a unit that the drive does not count in.
pub(super) fn fits(value: &Quantity, lengths: Lengths) -> Result<(), Failure> {
    let pitch = Parameter::SpindlePitch.entry().pnu;
    match (value.unit(), lengths) {
        (Some("mm"), Lengths::Increments) => Err(Failure::Usage(format!(
            "the drive counts positions in increments, because its spindle pitch (PNU {pitch}) is 0; give inc, or write the \
             pitch first; got {value}"
        ))),
        (Some("inc"), Lengths::HundredthMillimetres) => Err(Failure::Usage(format!(
            "the drive counts positions in 0.01 mm, because its spindle pitch (PNU {pitch}) is set; give mm, got {value}"
        ))),
        (Some(_) | None, Lengths::Increments | Lengths::HundredthMillimetres | Lengths::Unknown) => Ok(()),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(text: &str) -> Quantity {
        text.parse().unwrap()
    }

    fn is_refused(outcome: Result<(), Failure>, says: &str) -> bool {
        matches!(outcome, Err(Failure::Usage(line)) if line.contains(says))
    }

    #[test]
    fn a_drive_takes_the_unit_that_it_counts_in() {
        let (pitch, none) = (Lengths::HundredthMillimetres, Lengths::Increments);
        for (text, lengths) in [("8mm", pitch), ("8", pitch), ("8inc", none), ("8", none)] {
            assert!(fits(&quantity(text), lengths).is_ok(), "{text}");
        }
        assert!(is_refused(fits(&quantity("8mm"), none), "spindle pitch"));
        assert!(is_refused(fits(&quantity("8inc"), pitch), "give mm"));
    }

    #[test]
    fn a_parameter_takes_its_own_units() {
        let number = |text, parameter: Parameter| number_of(&quantity(text), parameter.entry());
        assert!(matches!(number("8.25mm", Parameter::Limit1), Ok(825)));
        assert!(matches!(number("60rpm", Parameter::VPos), Ok(60)));
        let wrong = number("60mm", Parameter::VPos).map(drop);
        assert!(is_refused(wrong, "v-Pos (PNU 1004) has not the unit mm; expected rpm, got 60 mm"));
        assert!(is_refused(number("1inc", Parameter::OperatingMode).map(drop), "expected no unit"));
    }
}
