//! Tables of parameters from files.
//!
//! ```text
//! TOML   [[parameter]]                CSV   pnu,name,type,min,max,default,scale,tie
//!        pnu = 100                          100,ramp-up,uint16,0,6500,100,0.1,ramp-up-time
//!        name = "ramp-up"
//!        type = "uint16"
//! ```

use toml::de::{DeTable, DeValue};

use super::{Fields, Row, Table, TableError};

impl Table {
    /// The parameters of a TOML file: a `[[parameter]]` each, with the keys of [`FIELDS`](super::FIELDS).
    ///
    /// # Errors
    /// [`TableError`] with the line.
    pub fn from_toml(text: &str) -> Result<Self, TableError> {
        of_fields(fields_of_toml(text)?)
    }

    /// The parameters of a CSV file: the first line names the columns, which are [`FIELDS`](super::FIELDS) in any order;
    /// lines that begin with `#` are comments. Of a first line with semicolons those are the separators.
    ///
    /// # Errors
    /// [`TableError`] with the line.
    pub fn from_csv(text: &str) -> Result<Self, TableError> {
        of_fields(fields_of_csv(text)?)
    }
}

impl Row {
    /// The parameters of a TOML file alone, with numbers up to 65535.
    ///
    /// # Errors
    /// As [`Table::from_toml`].
    pub(crate) fn all_of_toml(text: &str) -> Result<Vec<Self>, TableError> {
        all(fields_of_toml(text)?)
    }

    /// The parameters of a CSV file alone, with numbers up to 65535.
    ///
    /// # Errors
    /// As [`Table::from_csv`].
    pub(crate) fn all_of_csv(text: &str) -> Result<Vec<Self>, TableError> {
        all(fields_of_csv(text)?)
    }
}

/// The rows of a file, each number once.
fn all(fields: Vec<Fields>) -> Result<Vec<Row>, TableError> {
    let fields: Vec<_> = fields.into_iter().map(|fields| fields.up_to(u16::MAX)).collect();
    let rows = fields.iter().map(Row::of).collect::<Result<Vec<_>, _>>()?;
    of_fields_checked(&fields, rows.clone())?;
    Ok(rows)
}

fn fields_of_toml(text: &str) -> Result<Vec<Fields>, TableError> {
    let line = |at: usize| 1 + text.get(..at).unwrap_or(text).matches('\n').count();
    let root = DeTable::parse(text).map_err(|error| TableError {
        line: error.span().map_or(1, |span| line(span.start)),
        what: format!("this is no TOML: {}", error.message()),
    })?;
    let mut rows = Vec::new();
    for (key, value) in root.get_ref() {
        let at = line(key.span().start);
        let DeValue::Array(list) =
            (if key.get_ref() == "parameter" { value.get_ref() } else { &DeValue::Boolean(false) })
        else {
            let what =
                format!("'{}' is not known here; a parameter begins with [[parameter]]", key.get_ref());
            return Err(TableError { line: at, what });
        };
        for entry in list {
            let at = line(entry.span().start);
            let DeValue::Table(table) = entry.get_ref() else {
                return Err(TableError {
                    line: at,
                    what: "a parameter begins with [[parameter]]".to_owned(),
                });
            };
            let mut fields = Fields::new(at, []);
            for (name, value) in table {
                let at = line(value.span().start);
                let text = text_of(value.get_ref()).map_err(|what| TableError { line: at, what })?;
                fields.put(line(name.span().start), name.get_ref(), text);
            }
            rows.push(fields);
        }
    }
    Ok(rows)
}

fn fields_of_csv(text: &str) -> Result<Vec<Fields>, TableError> {
    let text = text.trim_start_matches('\u{FEFF}');
    let first = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let delimiter = if first.contains(';') { b';' } else { b',' };
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let wrong = |error: &csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        let what = if let csv::ErrorKind::UnequalLengths { expected_len, len, .. } = error.kind() {
            format!(
                "this line has {len} columns and the first one {expected_len}; a text with a separator belongs in quotes"
            )
        } else {
            format!("this is no CSV: {error}")
        };
        TableError { line: usize::try_from(line).unwrap_or(usize::MAX), what }
    };
    let names = reader.headers().map_err(|error| wrong(&error))?.clone();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| wrong(&error))?;
        let line = record.position().map_or(1, csv::Position::line);
        let line = usize::try_from(line).unwrap_or(usize::MAX);
        rows.push(Fields::new(line, names.iter().zip(&record)));
    }
    Ok(rows)
}

fn of_fields(fields: Vec<Fields>) -> Result<Table, TableError> {
    let rows = fields.iter().map(Row::of).collect::<Result<Vec<_>, _>>()?;
    of_fields_checked(&fields, rows)
}

/// The table of these rows, each of these fields.
fn of_fields_checked(fields: &[Fields], rows: Vec<Row>) -> Result<Table, TableError> {
    Table::new(rows).map_err(|error| TableError {
        line: error.line.checked_sub(1).and_then(|place| fields.get(place)).map_or(1, Fields::line),
        ..error
    })
}

/// A value of TOML as the text that CSV has for it.
fn text_of(value: &DeValue<'_>) -> Result<String, String> {
    match value {
        DeValue::String(text) => Ok(text.clone().into_owned()),
        DeValue::Integer(integer) => {
            let (digits, radix) = (integer.as_str(), integer.radix());
            match i64::from_str_radix(digits, radix) {
                Ok(number) => Ok(number.to_string()),
                Err(_) => Err(format!("{digits} is too large")),
            }
        }
        DeValue::Float(float) => Ok(float.as_str().to_owned()),
        DeValue::Array(list) => {
            let words = list.iter().map(|value| text_of(value.get_ref())).collect::<Result<Vec<_>, _>>()?;
            Ok(words.join(" "))
        }
        DeValue::Boolean(_) | DeValue::Datetime(_) | DeValue::Table(_) => {
            Err("expected a number, a text, or a list of numbers".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOML: &str = "# ours\n[[parameter]]\npnu = 100\nname = \"ramp\"\ntype = \"uint16\"\nscale = 0.1\n\
                        tie = \"ramp-up-time\"\n\n[[parameter]]\npnu = 0x65\nname = \"speeds\"\ntype = \"int32\"\n\
                        elements = 3\ndefault = [1, -2, 3]\n";
    const CSV: &str = "# ours\npnu,name,type,scale,tie,elements,default\n100,ramp,uint16,0.1,ramp-up-time,,\n\
                       101,speeds,int32,,,3,1 -2 3\n";

    #[test]
    fn both_formats_say_the_same() {
        let toml = Table::from_toml(TOML).unwrap();
        let rows: Vec<_> = toml.rows().cloned().collect();
        assert_eq!(rows, Table::from_csv(CSV).unwrap().rows().cloned().collect::<Vec<_>>());
        assert_eq!(
            rows,
            Table::from_csv(&CSV.replace(',', ";")).unwrap().rows().cloned().collect::<Vec<_>>()
        );
        assert_eq!(toml.kept(101, 1), Some(0xFFFF_FFFE));
        assert!(toml.row(945).is_some() && toml.row(102).is_none());
    }

    #[test]
    fn mistakes_have_their_line() {
        for (text, line, part) in [
            (TOML.replace("0x65", "100"), 9, "PNU 100 is in the table twice"),
            (TOML.replace("int32", "long"), 12, "there is no type 'long'"),
            (TOML.replace("scale = 0.1", "scale = true"), 6, "expected a number"),
            (TOML.replace("scale = 0.1", "scale ="), 6, "this is no TOML"),
            (TOML.replace("[[parameter]]\npnu = 100", "[[paramter]]\npnu = 100"), 2, "[[parameter]]"),
        ] {
            let error = Table::from_toml(&text).unwrap_err();
            assert!(error.line == line && error.what.contains(part), "{error}");
        }
        for (text, line, part) in [
            (CSV.replace("101", "100"), 4, "PNU 100 is in the table twice"),
            (CSV.replace("int32", "long"), 4, "there is no type 'long'"),
            (CSV.replace("1 -2 3", "1,2"), 4, "this line has 8 columns and the first one 7"),
            (CSV.replace(",tie", ",tied"), 3, "did you mean 'tie'?"),
        ] {
            let error = Table::from_csv(&text).unwrap_err();
            assert!(error.line == line && error.what.contains(part), "{error}");
        }
    }
}
