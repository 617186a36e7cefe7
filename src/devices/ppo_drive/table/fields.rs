//! A row from its named fields as text.

use crate::map::Map;

use super::{Channel, Kind, MAX_PNU, Row, TableError, Tie};
use crate::devices::ppo_drive::Quantity;

/// Every field of a row: a column of CSV, a key of TOML.
pub const FIELDS: [&str; 11] =
    ["pnu", "name", "type", "elements", "min", "max", "default", "unit", "scale", "access", "tie"];

/// The fields of one row, each with its line. An empty field is one that is not given.
#[derive(Clone, Debug)]
pub struct Fields {
    line: usize,
    /// The highest number that a parameter can have.
    most_pnu: u16,
    given: Map<String, (usize, String)>,
}

impl Fields {
    /// The fields of a row that is on one line.
    pub fn new<'a>(line: usize, fields: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let mut this = Self { line, most_pnu: MAX_PNU, given: Map::new() };
        for (name, text) in fields {
            this.put(line, name, text.to_owned());
        }
        this
    }

    /// The same of a parameter whose number is at most this, not that of a job.
    #[cfg(feature = "parameters")]
    pub(super) fn up_to(self, most_pnu: u16) -> Self {
        Self { most_pnu, ..self }
    }

    /// A field more.
    pub(super) fn put(&mut self, line: usize, name: &str, text: String) {
        if !text.trim().is_empty() {
            self.given.insert(name.to_owned(), (line, text.trim().to_owned()));
        }
    }

    /// Its line.
    #[cfg(feature = "parameters")]
    pub(super) const fn line(&self) -> usize {
        self.line
    }

    fn text(&self, name: &str) -> Option<&str> {
        self.given.get(name).map(|(_, text)| text.as_str())
    }

    fn needed(&self, name: &str) -> Result<&str, TableError> {
        self.text(name).ok_or_else(|| {
            self.error(name, format!("'{name}' is missing; every parameter needs pnu, name and type"))
        })
    }

    /// An error about a field, at its line or that of the row.
    fn error(&self, field: &str, what: impl Into<String>) -> TableError {
        let line = self.given.get(field).map_or(self.line, |(line, _)| *line);
        TableError { line, what: what.into() }
    }

    /// A number, decimal or 0x..
    fn number(&self, name: &str) -> Result<Option<f64>, TableError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        match number(text) {
            Some(number) => Ok(Some(number)),
            None => Err(self
                .error(name, format!("{name} '{text}' is no number; expected for example 100, 0.1 or 0xFF"))),
        }
    }
}

fn number(text: &str) -> Option<f64> {
    let text = text.replace('_', "");
    let hex = text.strip_prefix("0x").or(text.strip_prefix("0X"));
    let number = match hex {
        Some(hex) => u32::from_str_radix(hex, 16).ok()?.into(),
        None => text.parse().ok()?,
    };
    Some(number).filter(|number: &f64| number.is_finite())
}

impl Row {
    /// The parameter that these fields describe.
    ///
    /// # Errors
    /// [`TableError`]: the line, what is wrong and what to do about it.
    pub fn of(fields: &Fields) -> Result<Self, TableError> {
        for name in fields.given.keys() {
            if !FIELDS.contains(&name.as_str()) {
                let hint = nearest(name, FIELDS);
                return Err(fields.error(
                    name,
                    format!("there is no field '{name}'{hint}; the fields are {}", FIELDS.join(", ")),
                ));
            }
        }
        let pnu = pnu(fields)?;
        let name = fields.needed("name")?.to_owned();
        let kind = kind(fields)?;
        let tie = tie(fields)?;
        let elements = elements(fields, tie)?;
        let (low, high) = limits(fields, kind)?;
        let default = defaults(fields, kind, elements, (low, high))?;
        let scale = fields.number("scale")?.unwrap_or(1.0);
        if scale == 0.0 {
            return Err(fields.error("scale", "scale is 0; expected what 1 on the bus is, for example 0.1"));
        }
        let writable = writable(fields, tie)?;
        let unit = match (fields.text("unit"), tie) {
            (Some(unit), _) => unit,
            (None, Tie::Drive(quantity)) => quantity.unit(),
            (None, Tie::None | Tie::Channel(_)) => "",
        };
        let unit = unit.to_owned();
        Ok(Self { pnu, name, kind, elements, low, high, default, unit, scale, writable, tie })
    }
}

fn pnu(fields: &Fields) -> Result<u16, TableError> {
    fields.needed("pnu")?;
    let number = fields.number("pnu")?.unwrap_or(0.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "compared")]
    let pnu = number as u16;
    if f64::from(pnu) == number && (1..=fields.most_pnu).contains(&pnu) {
        return Ok(pnu);
    }
    let most = fields.most_pnu;
    Err(fields.error("pnu", format!("pnu {number} is outside 1 to {most}, which is what a job can name")))
}

fn kind(fields: &Fields) -> Result<Kind, TableError> {
    let text = fields.needed("type")?;
    Kind::ALL.iter().copied().find(|kind| kind.name() == text.to_lowercase()).ok_or_else(|| {
        let names: Vec<_> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        fields.error(
            "type",
            format!(
                "there is no type '{text}'{}; expected {}",
                nearest(text, names.iter().copied()),
                names.join(", ")
            ),
        )
    })
}

fn tie(fields: &Fields) -> Result<Tie, TableError> {
    let Some(text) = fields.text("tie") else { return Ok(Tie::None) };
    let channel = Channel::ALL.iter().copied().find(|channel| channel.name() == text);
    let tie = Quantity::named(text).map(Tie::Drive).or(channel.map(Tie::Channel));
    tie.ok_or_else(|| {
        let names: Vec<_> = Quantity::ALL
            .iter()
            .map(|quantity| quantity.name())
            .chain(Channel::ALL.iter().map(|channel| channel.name()))
            .collect();
        let hint = nearest(text, names.iter().copied());
        fields.error(
            "tie",
            format!("there is nothing called '{text}' to be tied to{hint}; there are {}", names.join(", ")),
        )
    })
}

fn elements(fields: &Fields, tie: Tie) -> Result<Option<u8>, TableError> {
    let given = match fields.number("elements")? {
        None => None,
        Some(number) if (1.0..=255.0).contains(&number) && number.fract() == 0.0 => {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 1 to 255")]
            let elements = number as u8;
            Some(elements)
        }
        Some(number) => {
            return Err(fields.error(
                "elements",
                format!("elements {number} is outside 1 to 255; leave it out for a single value"),
            ));
        }
    };
    let settles = |elements: Option<u8>| {
        elements.map_or("a single value".into(), |count| format!("an array of {count}"))
    };
    match (given, tie, tie.elements()) {
        (given, Tie::None, _) => Ok(given),
        (None, _, of_tie) => Ok(of_tie),
        (Some(given), _, Some(of_tie)) if given <= of_tie => Ok(Some(given)),
        (Some(_), _, of_tie) => Err(fields
            .error("elements", format!("what it is tied to is {}; leave elements out", settles(of_tie)))),
    }
}

fn limits(fields: &Fields, kind: Kind) -> Result<(f64, f64), TableError> {
    let (least, most) = kind.range();
    let low = fields.number("min")?.unwrap_or(least);
    let high = fields.number("max")?.unwrap_or(most);
    for (name, value) in [("min", low), ("max", high)] {
        fits(fields, name, value, kind)?;
    }
    if low > high {
        return Err(fields.error("min", format!("min {low} is above max {high}; exchange them")));
    }
    Ok((low, high))
}

/// A value that the kind can hold: in its range, and whole if that is needed.
fn fits(fields: &Fields, name: &str, value: f64, kind: Kind) -> Result<(), TableError> {
    let (least, most) = kind.range();
    if !(least..=most).contains(&value) {
        return Err(fields.error(
            name,
            format!("{name} {value} does not fit in {kind}, {least} to {most}; choose another type"),
        ));
    }
    if value.fract() != 0.0 && kind != Kind::Float {
        return Err(fields.error(
            name,
            format!("{name} {value} is no whole number; {kind} counts: give the number on the bus, and its size as scale"),
        ));
    }
    Ok(())
}

fn defaults(
    fields: &Fields,
    kind: Kind,
    elements: Option<u8>,
    (low, high): (f64, f64),
) -> Result<Option<Vec<f64>>, TableError> {
    let Some(text) = fields.text("default") else { return Ok(None) };
    let count = usize::from(elements.unwrap_or(1));
    let mut values = Vec::new();
    for word in text.split_whitespace() {
        let value = number(word).ok_or_else(|| {
            fields.error("default", format!("default '{word}' is no number; expected for example 100"))
        })?;
        fits(fields, "default", value, kind)?;
        if !(low..=high).contains(&value) {
            return Err(
                fields.error("default", format!("default {value} is outside {low} to {high} (min and max)"))
            );
        }
        values.push(value);
    }
    match values[..] {
        // One for all.
        [one] => Ok(Some([one].repeat(count))),
        _ if values.len() == count => Ok(Some(values)),
        _ => Err(fields.error(
            "default",
            format!("default has {} values, expected 1 or {count}, with spaces between them", values.len()),
        )),
    }
}

fn writable(fields: &Fields, tie: Tie) -> Result<bool, TableError> {
    match (fields.text("access"), tie.is_settable()) {
        (None, settable) => Ok(settable),
        (Some("r"), _) => Ok(false),
        (Some("rw"), true) => Ok(true),
        (Some("rw"), false) => {
            Err(fields.error("access", "what it is tied to can only be read; give access r or leave it out"))
        }
        (Some(other), _) => {
            Err(fields.error("access", format!("access '{other}' is not known; expected r or rw")))
        }
    }
}

/// `, did you mean 'x'?` if one of the names is near.
fn nearest<'a>(text: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let near =
        names.into_iter().map(|name| (strsim::damerau_levenshtein(name, &text.to_lowercase()), name)).min();
    match near {
        Some((distance, name)) if distance <= 3 => format!(", did you mean '{name}'?"),
        Some(_) | None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(fields: &[(&str, &str)]) -> Result<Row, TableError> {
        Row::of(&Fields::new(7, fields.iter().copied()))
    }

    const RAMP: [(&str, &str); 3] = [("pnu", "100"), ("name", "ramp"), ("type", "uint16")];

    #[test]
    fn a_row_takes_what_is_not_given_from_its_type_and_tie() {
        let plain = row(&RAMP).unwrap();
        assert_eq!((plain.low, plain.high, plain.elements, plain.writable), (0.0, 65535.0, None, true));
        let tied = row(&[&RAMP[..], &[("tie", "fault-buffer")]].concat()).unwrap();
        assert_eq!((tied.elements, tied.writable), (Some(64), false));
        let array = row(&[&RAMP[..], &[("elements", "3"), ("default", "1 0x10 3")]].concat()).unwrap();
        assert_eq!(array.default, Some([1.0, 16.0, 3.0].to_vec()));
    }

    #[test]
    fn every_mistake_is_said_with_its_cure() {
        for (field, text, part) in [
            ("pnu", "", "'pnu' is missing"),
            ("pnu", "4000", "pnu 4000 is outside 1 to 3999"),
            ("pnu", "x", "pnu 'x' is no number"),
            ("type", "unit16", "there is no type 'unit16', did you mean 'uint16'?; expected int16"),
            ("tie", "ramp-up", "nothing called 'ramp-up' to be tied to"),
            ("tie", "ramp-up-tme", "did you mean 'ramp-up-time'?"),
            ("elements", "0", "elements 0 is outside 1 to 255"),
            ("min", "-1", "min -1 does not fit in uint16, 0 to 65535"),
            ("default", "1 2", "default has 2 values, expected 1 or 1"),
            ("default", "0.5", "default 0.5 is no whole number; uint16 counts"),
            ("scale", "0", "scale is 0"),
            ("access", "w", "access 'w' is not known; expected r or rw"),
            ("acces", "r", "there is no field 'acces', did you mean 'access'?"),
        ] {
            let mut fields = Fields::new(7, RAMP);
            fields.given.remove(field);
            fields.put(9, field, text.to_owned());
            let error = Row::of(&fields).unwrap_err();
            let line = if text.is_empty() { 7 } else { 9 };
            assert!(error.line == line && error.what.contains(part), "{field} = {text}: {error}");
        }
        let error = row(&[&RAMP[..], &[("min", "9"), ("max", "8")]].concat()).unwrap_err();
        assert_eq!(std::format!("{error}"), "line 7: min 9 is above max 8; exchange them");
        let error = row(&[&RAMP[..], &[("tie", "load"), ("elements", "2")]].concat()).unwrap_err();
        assert!(error.what.contains("a single value; leave elements out"), "{error}");
        let error = row(&[&RAMP[..], &[("tie", "torque"), ("access", "rw")]].concat()).unwrap_err();
        assert!(error.what.contains("can only be read"), "{error}");
    }
}
