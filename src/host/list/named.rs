//! Parameters by number or name: of the positioning drives, and of a table of the user.

use strsim::levenshtein;

use crate::devices::ag03::param::{Entry, Pnu, TABLE};
use crate::devices::ppo_drive::table::{Row, Table};
use crate::gsd::did_you_mean;

/// How many names are offered instead of one that is unknown.
const MOST_OFFERED: usize = 5;

/// The parameter with this number (decimal, or hexadecimal as `0x3EC` or `3ECh`) or name. Of a name only letters and digits
/// count.
///
/// # Errors
/// That there is none, and those near it.
pub(crate) fn parameter(text: &str) -> Result<&'static Entry, String> {
    if let Some(number) = text.parse().ok().or_else(|| hexadecimal(text)) {
        let known = Pnu::new(number).ok().and_then(|pnu| TABLE.iter().find(|entry| entry.pnu == pnu));
        return known.ok_or_else(|| {
            let near = nearest_entries(|entry| entry.pnu.number().abs_diff(number).into());
            format!("there is no parameter {number}; near it are {near}")
        });
    }
    let wanted = plain(text);
    let known = TABLE.iter().find(|entry| !wanted.is_empty() && plain(entry.name) == wanted);
    known.ok_or_else(|| {
        let near = nearest_entries(|entry| {
            let name = plain(entry.name);
            // Part of the name is as close as a slip of the pen.
            let part = !wanted.is_empty() && (name.contains(&wanted) || wanted.contains(&name));
            if part { 1 } else { levenshtein(&name, &wanted) + 1 }
        });
        format!("there is no parameter '{text}'; close to it are {near}")
    })
}

fn hexadecimal(text: &str) -> Option<u16> {
    let digits = text.strip_prefix("0x").or_else(|| text.strip_suffix(['h', 'H']))?;
    u16::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'))
}

/// The entries with the smallest distances.
fn nearest_entries(distance: impl Fn(&Entry) -> usize) -> String {
    let mut entries: Vec<&Entry> = TABLE.iter().collect();
    entries.sort_by_key(|entry| distance(entry));
    let names = entries.iter().take(MOST_OFFERED).map(|entry| format!("{} {}", entry.pnu, entry.name));
    names.collect::<Vec<_>>().join(", ")
}

/// Letters and digits of a name, in lower case.
pub(crate) fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The parameter that `100`, `ramp-up time`, `30.2` or `fixed speeds.2` names, and its element. Of a name only letters and
/// digits count.
///
/// # Errors
/// That there is none, or no such element.
pub(crate) fn find<'t>(table: &'t Table, text: &str) -> Result<(&'t Row, Option<u8>), String> {
    if let Some(row) = whole(table, text) {
        return match row.elements {
            Some(count) => Err(format!(
                "{} (PNU {}) is an array of {count}; name the element, for example {}.1",
                row.name, row.pnu, row.pnu
            )),
            None => Ok((row, None)),
        };
    }
    let split = text.rsplit_once('.').and_then(|(name, element)| Some((whole(table, name)?, element)));
    let Some((row, element)) = split else { return Err(unknown(table, text)) };
    match (row.elements, element.parse::<u8>()) {
        (None, _) => Err(format!("{} (PNU {}) is no array; leave '.{element}' out", row.name, row.pnu)),
        (Some(count), Ok(got)) if (1..=count).contains(&got) => Ok((row, Some(got))),
        (Some(count), _) => {
            Err(format!("{} (PNU {}) has the elements 1 to {count}, not {element}", row.name, row.pnu))
        }
    }
}

fn whole<'t>(table: &'t Table, text: &str) -> Option<&'t Row> {
    if let Ok(pnu) = text.trim().parse() {
        return table.row(pnu);
    }
    let wanted = plain(text);
    table.rows().find(|row| !wanted.is_empty() && plain(&row.name) == wanted)
}

fn unknown(table: &Table, text: &str) -> String {
    let near = did_you_mean(text, table.rows().map(|row| row.name.as_str()));
    let near = near.map(|name| format!("; did you mean '{name}'?")).unwrap_or_default();
    format!("the drive has no parameter '{text}'{near}")
}

#[cfg(all(test, feature = "parameters"))]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_is_its_number_or_its_name_with_its_element() {
        let table = Table::from_toml(include_str!("../../../examples/ppo_drive.toml")).unwrap();
        let found = |text| find(&table, text).map(|(row, element)| (row.pnu, element));
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
            ("99", "the drive has no parameter '99'"),
            ("ramp-up tme", "did you mean 'ramp-up time'?"),
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
