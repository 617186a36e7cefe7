//! Times and values from a CSV file.
//!
//! ```text
//! seconds;value        a first line without numbers is a heading
//! 0;20.5               from 0 s on
//! 1.5;21               from 1.5 s on
//! ```
//!
//! Columns are separated by `;`, `,` or a tab. Empty lines and lines that begin with `#` are left out.

use core::time::Duration;

use thiserror::Error;

/// The most rows of a table.
const MAX_ROWS: usize = 100_000;

/// Values over time: each holds until the next one.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Rising times, the first one first.
    rows: Vec<(Duration, f64)>,
}

/// Why a text is no table.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TableError {
    /// A line without two numbers.
    #[error("line {line}: '{got}' is not SECONDS;VALUE, for example 1.5;20")]
    Row {
        /// Which, from 1.
        line: usize,
        /// The line.
        got: String,
    },
    /// A time that is not behind the one before.
    #[error("line {line}: the time is not behind that of the row before; sort the rows by time")]
    Order {
        /// Which, from 1.
        line: usize,
    },
    /// No row, or too many.
    #[error("the table has {got} rows, expected 1 to {MAX_ROWS}")]
    Rows {
        /// Rows.
        got: usize,
    },
}

impl Table {
    /// Reads a CSV file. Never panics.
    ///
    /// # Errors
    /// [`TableError`].
    pub(crate) fn read(text: &str) -> Result<Self, TableError> {
        let mut rows: Vec<(Duration, f64)> = Vec::new();
        let lines = text.trim_start_matches('\u{feff}').lines().zip(1..);
        let mut lines =
            lines.filter(|(line, _)| !line.trim().is_empty() && !line.starts_with('#')).peekable();
        lines.next_if(|(line, _)| !line.chars().any(|c| c.is_ascii_digit()));
        for (line, number) in lines {
            let row = row(line)
                .ok_or_else(|| TableError::Row { line: number, got: line.chars().take(60).collect() })?;
            if rows.last().is_some_and(|last| last.0 >= row.0) {
                return Err(TableError::Order { line: number });
            }
            rows.push(row);
            if rows.len() > MAX_ROWS {
                break;
            }
        }
        if rows.is_empty() || rows.len() > MAX_ROWS {
            return Err(TableError::Rows { got: rows.len() });
        }
        Ok(Self { rows })
    }

    /// Its least and its greatest value.
    pub(super) fn extremes(&self) -> (f64, f64) {
        let values = self.rows.iter().map(|row| row.1);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| {
            (least.min(value), most.max(value))
        })
    }

    /// When the last row begins.
    pub fn last(&self) -> Duration {
        self.rows.last().map(|row| row.0).unwrap_or_default()
    }

    /// The value at a time, before the first row that of the first row; and when the next row begins.
    pub(super) fn at(&self, time: Duration) -> (f64, Option<Duration>) {
        let behind = self.rows.partition_point(|row| row.0 <= time);
        let row = self.rows.get(behind.saturating_sub(1)).or(self.rows.first());
        (row.map(|row| row.1).unwrap_or_default(), self.rows.get(behind).map(|row| row.0))
    }
}

fn row(line: &str) -> Option<(Duration, f64)> {
    let mut cells = line.split([';', ',', '\t']).map(str::trim);
    let seconds: f64 = cells.next()?.parse().ok()?;
    let value: f64 = cells.next()?.parse().ok()?;
    let rest_is_empty = cells.all(str::is_empty);
    let time = Duration::try_from_secs_f64(seconds).ok()?;
    (value.is_finite() && rest_is_empty).then_some((time, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_until_the_next_one() {
        let table = Table::read("\u{feff}seconds;value\n# oven\n0.5;20\n\n1, 21.5\n2\t-3\n").unwrap();
        let ms = Duration::from_millis;
        for (time, value, next) in [
            (0, 20.0, Some(ms(500))),
            (500, 20.0, Some(ms(1000))),
            (1999, 21.5, Some(ms(2000))),
            (2000, -3.0, None),
            (9000, -3.0, None),
        ] {
            assert_eq!(table.at(ms(time)), (value, next), "{time}");
        }
        assert_eq!(table.last(), ms(2000));
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_line() {
        for (text, words) in [
            ("", "the table has 0 rows, expected 1 to 100000"),
            ("time;value\n", "the table has 0 rows, expected 1 to 100000"),
            ("0;1\n1", "line 2: '1' is not SECONDS;VALUE, for example 1.5;20"),
            ("0;1;2", "line 1: '0;1;2' is not SECONDS;VALUE, for example 1.5;20"),
            ("-1;1", "line 1: '-1;1' is not SECONDS;VALUE, for example 1.5;20"),
            ("1;inf", "line 1: '1;inf' is not SECONDS;VALUE, for example 1.5;20"),
            ("1;1\n1;2", "line 2: the time is not behind that of the row before; sort the rows by time"),
        ] {
            assert_eq!(Table::read(text).unwrap_err().to_string(), words);
        }
    }
}
