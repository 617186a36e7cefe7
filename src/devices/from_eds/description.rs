//! Values and inputs of a node from a file. Those that the device only tells are set from outside: what it measures is the
//! business of whoever tests a master.

use super::FromEds;
use super::dictionary::{Dictionary, Row};
use crate::can_bus::canopen::value::{DataType, ValueKind};
use crate::can_bus::canopen::{Address, Value};
use crate::face::description::{self, Amount, Curve, Description, Group};
use crate::face::surroundings::{Input, Level, Surroundings};
use crate::time::Instant;

impl FromEds {
    fn number(&self, place: usize, row: &Row) -> Option<f64> {
        self.memory.read(place, row).and_then(as_f64)
    }
}

/// What is set from outside.
fn inputs(dictionary: &'static Dictionary) -> impl Iterator<Item = (usize, &'static Row, &'static Input)> {
    let rows = dictionary.rows.iter().enumerate();
    rows.filter_map(|(place, row)| Some((place, row, row.input.as_ref()?)))
}

impl Surroundings for FromEds {
    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        for (place, row, input) in inputs(self.dictionary) {
            let number = self.number(place, row).unwrap_or_default();
            let is_switch = row.table.data == DataType::Boolean;
            tell(input, if is_switch { Level::Switch(number != 0.0) } else { Level::Number(number) });
        }
    }

    fn set_input(&mut self, _: Instant, name: &str, level: Level) {
        let Some((place, row, _)) = inputs(self.dictionary).find(|(_, _, input)| input.name == name) else {
            return;
        };
        let number = match level {
            Level::Switch(on) => f64::from(u8::from(on)),
            Level::Number(number) => number,
            Level::Own => return,
        };
        // A number is never too long.
        let _ = of_f64(row.table.data, number)
            .map(|value| value.with_octets(|octets| self.memory.set(place, row, octets)));
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        let (_, row, _) = inputs(self.dictionary).find(|(_, _, input)| input.name == name)?;
        let octets = row.file.octets(self.node);
        let number = row.table.data.decode(&octets).and_then(as_f64)?;
        let is_switch = row.table.data == DataType::Boolean;
        Some(if is_switch { Level::Switch(number != 0.0) } else { Level::Number(number) })
    }

    fn make_nominal(&mut self, _: Instant) {
        for (place, row, _) in inputs(self.dictionary) {
            self.memory.make_default(place, row);
        }
    }

    fn words(&self) -> &'static [Address] {
        &self.dictionary.words
    }

    fn mode(&self) -> i64 {
        let shown = self.dictionary.place(Address::new(0x6061, 0));
        let value = shown.and_then(|place| self.memory.read(place, self.dictionary.rows.get(place)?));
        value.and_then(Value::number).unwrap_or_default()
    }
}

impl Description for FromEds {
    fn each_value(&self, tell: &mut dyn FnMut(description::Value<'_>)) {
        for (place, row) in self.dictionary.rows.iter().enumerate() {
            let Some(key) = row.key else { continue };
            let amount = Amount::from(self.number(place, row));
            let value = description::Value::new(key, row.table.name, Group::Measured, amount);
            let curve = if row.curve { Curve::Own } else { Curve::None };
            tell(description::Value { headline: row.headline, ..value.curve(curve) });
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "for people")]
fn as_f64(value: Value<'_>) -> Option<f64> {
    if let Value::Real32(number) = value {
        Some(number.into())
    } else if let Value::Real64(number) = value {
        Some(number)
    } else if let Value::U64(number) = value {
        Some(number as f64)
    } else {
        value.number().map(|number| number as f64)
    }
}

/// The nearest value of a type.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "casts of numbers saturate")]
fn of_f64(data: DataType, number: f64) -> Option<Value<'static>> {
    Some(match (data.kind(), data) {
        (ValueKind::Real, DataType::Real32) => Value::Real32(number as f32),
        (ValueKind::Real, _) => Value::Real64(number),
        (_, DataType::U64) => Value::U64(number.round() as u64),
        (ValueKind::Boolean | ValueKind::Signed | ValueKind::Unsigned, _) => {
            let (low, high) = data.range()?;
            Value::whole(data, (number.round() as i64).clamp(low, high))?
        }
        (ValueKind::Text | ValueKind::Octets, _) => return None,
    })
}
