//! A parameter as it was asked for.

use crate::devices::ag03::param::{Pnu, Subindex, Value};
use crate::devices::ppo_drive::table::{Kind, Row, Table};
use serde_json::json;

use crate::host::list::named;

use crate::command::Failure;
use crate::command::master::device::Shown;

/// A parameter as it was asked for, with its row if the table has it.
pub(super) struct Place<'t> {
    pub(super) pnu: Pnu,
    pub(super) element: Option<Subindex>,
    pub(super) row: Option<&'t Row>,
}

impl<'t> Place<'t> {
    /// By number or name; a number need not be in the table.
    pub(super) fn find(table: &'t Table, text: &str) -> Result<Self, Failure> {
        let error = match named::find(table.rows(), text) {
            Ok((row, element)) => return Ok(Self::of(row, element)),
            Err(error) => error,
        };
        let (number, element) = text.split_once('.').map_or((text, None), |(pnu, sub)| (pnu, Some(sub)));
        let pnu = number.parse().ok().filter(|pnu| table.row(*pnu).is_none());
        let element = element.map(str::parse).transpose();
        match (pnu.and_then(|pnu| Pnu::new(pnu).ok()), element) {
            (Some(pnu), Ok(element)) => Ok(Self { pnu, element: element.map(Subindex), row: None }),
            (Some(_) | None, _) => Err(Failure::Usage(error)),
        }
    }

    pub(super) fn of(row: &'t Row, element: Option<u8>) -> Self {
        Self { pnu: Pnu::from_low_bits(row.pnu), element: element.map(Subindex), row: Some(row) }
    }

    /// Whether a write can be right.
    pub(super) fn check(&self, value: f64) -> Result<(), Failure> {
        let whole =
            || Failure::Usage(format!("PNU {} takes a whole number of 32 bits, got {value}", self.pnu));
        let Some(row) = self.row else {
            let fits = value.fract() == 0.0 && (-2_147_483_648.0..=4_294_967_295.0).contains(&value);
            return if fits { Ok(()) } else { Err(whole()) };
        };
        if row.kind != Kind::Float && value.fract() != 0.0 {
            return Err(whole());
        }
        if !row.writable {
            return Err(Failure::Usage(format!("{} (PNU {}) can only be read", row.name, row.pnu)));
        }
        if !(row.low..=row.high).contains(&value) {
            let (low, high) = (row.low, row.high);
            return Err(Failure::Usage(format!(
                "{} (PNU {}) takes {low} to {high}, got {value}",
                row.name, row.pnu
            )));
        }
        Ok(())
    }

    /// `2`, `30.1`
    pub(super) fn number(&self) -> String {
        self.element.map_or_else(|| self.pnu.to_string(), |element| format!("{}.{element}", self.pnu))
    }

    pub(super) fn name(&self) -> &str {
        self.row.map_or("", |row| row.name.as_str())
    }

    /// The number on the bus, and with its unit.
    fn in_words(&self, value: Value) -> (f64, String) {
        let Some(row) = self.row else {
            let bits = value.bits();
            return (bits.into(), bits.to_string());
        };
        let number = row.kind.value(value.bits());
        if row.scale == 1.0 {
            return (number, format!("{number} {}", row.unit).trim_end().to_owned());
        }
        // As many digits as the scale has say nothing that is not so.
        let scaled = (number * row.scale * 1e6).round() / 1e6;
        (number, format!("{number} ({scaled} {})", row.unit).replace(" )", ")"))
    }

    /// As it is shown.
    pub(super) fn shown(&self, value: Value) -> Shown {
        let (number, text) = self.in_words(value);
        let head = format!("{:<6} {:<27}", self.number(), self.name());
        Shown { head, text, number: number.into(), json: self.json(value) }
    }

    fn json(&self, value: Value) -> serde_json::Value {
        let (number, text) = self.in_words(value);
        let mut object =
            json!({ "pnu": self.pnu.number(), "name": self.name(), "value": number, "text": text });
        if let (Some(element), Some(fields)) = (self.element, object.as_object_mut()) {
            fields.insert("element".into(), element.0.into());
        }
        object
    }
}
