//! A parameter of a table of the user, by number or by name.

use profidrive::devices::ppo_drive::table::{Row, Table};
use profidrive::gsd::did_you_mean;

use super::args::plain;

/// The parameter that `100`, `ramp-up time`, `30.2` or `fixed speeds.2` names, and its element. Of a name only letters and
/// digits count.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_is_its_number_or_its_name_with_its_element() {
        let table = Table::from_toml(include_str!("../../examples/ppo_drive.toml")).unwrap();
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
