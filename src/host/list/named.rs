//! Parameters by number or name: of the list of a device, and of a table of the user.

use core::str::FromStr;

use strsim::levenshtein;

use crate::devices::ag03::param::{Entry, Gear, Model, Quirks, Range, Subindex, TABLE, Width};
use crate::devices::ppo_drive::table::Row;

/// How many names are offered instead of one that is unknown.
const MOST_OFFERED: usize = 5;

/// What has a number and a name.
pub(crate) trait Named {
    /// The number that a master gives.
    fn number(&self) -> u16;

    /// What people call it.
    fn name(&self) -> &str;

    /// The first and the number of its elements, if it is an array.
    fn elements(&self) -> Option<(u8, u8)>;
}

impl Named for Entry {
    fn number(&self) -> u16 {
        self.pnu.number()
    }

    fn name(&self) -> &str {
        self.name
    }

    fn elements(&self) -> Option<(u8, u8)> {
        self.elements.map(|count| (0, count))
    }
}

impl Named for Row {
    fn number(&self) -> u16 {
        self.pnu
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn elements(&self) -> Option<(u8, u8)> {
        self.elements.map(|count| (1, count))
    }
}

/// The parameter of a positioning drive with this number (decimal, or hexadecimal as `0x3EC` or `3ECh`) or name. Of a name
/// only letters and digits count.
///
/// # Errors
/// That there is none, and those near it.
pub(crate) fn parameter(text: &str) -> Result<&'static Entry, String> {
    whole(TABLE.iter(), text).ok_or_else(|| unknown(TABLE.iter(), text))
}

/// What a job of the parameter channel has to know of a parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnChannel {
    pub(crate) number: u16,
    pub(crate) name: &'static str,
    /// How many elements it has, if it is an array.
    pub(crate) elements: Option<u8>,
    /// Its value is a double word.
    pub(crate) double: bool,
    pub(crate) signed: bool,
    /// Its lowest and highest value, the widest of all models.
    pub(crate) range: Option<(i64, i64)>,
}

/// The same as [`parameter`], for the parameter channel.
///
/// # Errors
/// As [`parameter`].
pub(crate) fn on_channel(text: &str) -> Result<OnChannel, String> {
    let entry = parameter(text)?;
    let range = entry.range(Model::Ag03_1, Gear::Ratio24, Quirks::default());
    Ok(OnChannel {
        number: entry.pnu.number(),
        name: entry.name,
        elements: entry.elements,
        double: entry.width == Width::Double,
        signed: entry.signed,
        range: range.map(|Range { low, high }| (low.into(), high.into())),
    })
}

/// A parameter of a positioning drive of either model, by number or by name, and an element if it is an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ParameterSpec {
    pub(crate) entry: &'static Entry,
    pub(crate) element: Option<Subindex>,
}

impl FromStr for ParameterSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (entry, element) = find(TABLE.iter(), text)?;
        Ok(Self { entry, element: element.map(Subindex) })
    }
}

/// The parameter that `100`, `ramp-up time`, `30.2` or `fixed speeds.2` names, and its element.
///
/// # Errors
/// That there is none and those near it, or no such element.
pub(crate) fn find<'t, P: Named + 't>(
    rows: impl Iterator<Item = &'t P> + Clone,
    text: &str,
) -> Result<(&'t P, Option<u8>), String> {
    let named = |row: &P| format!("{} (PNU {})", row.name(), row.number());
    if let Some(row) = whole(rows.clone(), text) {
        return match row.elements() {
            Some((first, count)) => Err(format!(
                "{} is an array of {count}; name the element, for example {}.{first}",
                named(row),
                row.number()
            )),
            None => Ok((row, None)),
        };
    }
    let split = text.rsplit_once('.').and_then(|(name, element)| Some((whole(rows.clone(), name)?, element)));
    let Some((row, element)) = split else { return Err(unknown(rows, text)) };
    let Some((first, count)) = row.elements() else {
        return Err(format!("{} is no array; leave '.{element}' out", named(row)));
    };
    let last = first.saturating_add(count.saturating_sub(1));
    match element.parse() {
        Ok(element) if (first..=last).contains(&element) => Ok((row, Some(element))),
        Ok(_) | Err(_) => Err(format!("{} has the elements {first} to {last}, not {element}", named(row))),
    }
}

fn whole<'t, P: Named + 't>(mut rows: impl Iterator<Item = &'t P>, text: &str) -> Option<&'t P> {
    if let Some(number) = number(text) {
        return rows.find(|row| row.number() == number);
    }
    let wanted = plain(text);
    rows.find(|row| !wanted.is_empty() && plain(row.name()) == wanted)
}

fn number(text: &str) -> Option<u16> {
    text.trim().parse().ok().or_else(|| hexadecimal(text))
}

fn hexadecimal(text: &str) -> Option<u16> {
    let digits = text.strip_prefix("0x").or_else(|| text.strip_suffix(['h', 'H']))?;
    u16::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'))
}

fn unknown<'t, P: Named + 't>(rows: impl Iterator<Item = &'t P>, text: &str) -> String {
    if let Some(number) = number(text) {
        let near = nearest(rows, |row| row.number().abs_diff(number).into());
        return format!("there is no parameter {number}; near it are {near}");
    }
    let wanted = plain(text);
    let near = nearest(rows, |row| {
        let name = plain(row.name());
        // Part of the name is as close as a slip of the pen.
        let part = !wanted.is_empty() && (name.contains(&wanted) || wanted.contains(&name));
        if part { 1 } else { levenshtein(&name, &wanted) + 1 }
    });
    format!("there is no parameter '{text}'; close to it are {near}")
}

/// Those with the smallest distances.
fn nearest<'t, P: Named + 't>(rows: impl Iterator<Item = &'t P>, distance: impl Fn(&P) -> usize) -> String {
    let mut rows: Vec<&P> = rows.collect();
    rows.sort_by_key(|row| distance(row));
    let names = rows.iter().take(MOST_OFFERED).map(|row| format!("{} {}", row.number(), row.name()));
    names.collect::<Vec<_>>().join(", ")
}

/// Letters and digits of a name, in lower case.
pub(crate) fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pnu(text: &str) -> Result<(u16, Option<u8>), String> {
        let spec: ParameterSpec = text.parse()?;
        Ok((spec.entry.pnu.number(), spec.element.map(|element| element.0)))
    }

    #[test]
    fn a_parameter_is_its_number_or_its_name_however_written() {
        for (text, found) in [
            ("1004", (1004, None)),
            ("v-Pos", (1004, None)),
            ("VPOS", (1004, None)),
            ("limit 1", (1016, None)),
            ("limit_2", (1017, None)),
            ("0x3EC", (1004, None)),
            ("3ech", (1004, None)),
            ("3B1h.2", (945, Some(2))),
            ("945.9", (945, Some(9))),
            ("fault-buffer.0", (945, Some(0))),
        ] {
            assert_eq!(pnu(text), Ok(found), "{text}");
        }
        for entry in TABLE {
            let suffix = if entry.elements.is_some() { ".0" } else { "" };
            assert_eq!(pnu(&format!("{}{suffix}", entry.name)).map(|found| found.0), Ok(entry.pnu.number()));
        }
    }

    #[test]
    fn what_is_no_parameter_is_answered_with_those_close_to_it() {
        for (text, says) in [
            ("999", "there is no parameter 999; near it are 1000 Controller parameter P"),
            ("2048", "there is no parameter 2048; near it are 1042 Battery voltage"),
            ("0x3E7", "there is no parameter 999; near it are 1000"),
            ("v-Poss", "close to it are 1004 v-Pos"),
            ("limit", "close to it are 1016 Limit 1, 1017 Limit 2"),
            ("tempreature", "1027 Device temperature"),
            ("", "there is no parameter ''"),
            ("945", "is an array of 10; name the element, for example 945.0"),
            ("945.10", "has the elements 0 to 9, not 10"),
            ("945.x", "has the elements 0 to 9, not x"),
            ("1004.1", "is no array; leave '.1' out"),
        ] {
            let error = pnu(text).unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    #[cfg(feature = "parameters")]
    #[test]
    fn a_parameter_is_its_number_or_its_name_with_its_element() {
        let table = crate::devices::ppo_drive::table::Table::from_toml(include_str!(
            "../../../examples/ppo_drive.toml"
        ))
        .unwrap();
        let found = |text| find(table.rows(), text).map(|(row, element)| (row.pnu, element));
        for (text, place) in [
            ("2", (2, None)),
            ("ramp-up time", (2, None)),
            ("Ramp_Up_Time", (2, None)),
            ("30.3", (30, Some(3))),
            ("fixed speeds.1", (30, Some(1))),
            ("947.64", (947, Some(64))),
        ] {
            assert_eq!(found(text), Ok(place), "{text}");
        }
        for (text, words) in [
            ("99", "there is no parameter 99; near it are "),
            ("ramp-up tme", "close to it are 2 ramp-up time"),
            ("30", "is an array of 3; name the element, for example 30.1"),
            ("30.4", "has the elements 1 to 3, not 4"),
            ("30.x", "has the elements 1 to 3, not x"),
            ("2.1", "is no array; leave '.1' out"),
            ("", "no parameter ''"),
        ] {
            let error = found(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
