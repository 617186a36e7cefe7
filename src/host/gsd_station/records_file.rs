//! The records of a station from their file.
//!
//! ```text
//! min_send_timeout = 10        of a connection, times 10 ms
//! [[record]]                   one for each record
//! slot = 1
//! index = 10
//! length = 4                   or data
//! access = "rw"                r, w or rw
//! data = "01 02 03 04"
//! delay_ms = 0
//! [im0]                        I&M0
//! order_id = "6ES7 000-0AA00"
//! writable = [1, 2]            which of I&M1 to I&M4 can be written
//! ```

use core::time::Duration;

use toml::de::{DeTable, DeValue};

use super::{StationRecord, StationRecords};
use crate::host::octets_of_hex;
use crate::host::station_file::MAX_RECORDS;
use crate::profibus::dpv1::identification::LEN;
use crate::profibus::dpv1::{CALL_INDEX, Identification, MAX_DATA, PARAMETER_INDEX, Revision, Text};

/// A mistake, and its line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}")]
pub struct RecordsError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong, and the cure.
    pub what: String,
}

type Part<'a, 'b> = (&'a str, &'a DeValue<'b>, usize);

impl StationRecords {
    /// Reads a file.
    ///
    /// # Errors
    /// `RecordsError`
    pub fn from_toml(text: &str) -> Result<Self, RecordsError> {
        let line = |at: usize| 1 + text.get(..at).unwrap_or(text).matches('\n').count();
        let root = DeTable::parse(text).map_err(|error| {
            let at = error.span().map_or(1, |span| line(span.start));
            wrong(at, format!("this is no TOML: {}", error.message()))
        })?;
        let mut records = Self::default();
        for (key, value) in root.get_ref() {
            let at = line(key.span().start);
            match (&**key.get_ref(), value.get_ref()) {
                ("min_send_timeout", value) => records.min_send_timeout = number(value, at, 1, u16::MAX)?,
                ("record", DeValue::Array(list)) => {
                    for entry in list {
                        let at = line(entry.span().start);
                        let parts = parts(entry.get_ref(), at, line)?;
                        let (place, record) = record(&parts, at)?;
                        if records.records.insert(place, record).is_some() {
                            let (slot, index) = place;
                            return Err(wrong(at, format!("slot {slot} has a record {index} already")));
                        }
                    }
                }
                ("im0", value @ DeValue::Table(_)) => identification(&mut records, &parts(value, at, line)?)?,
                (other, _) => {
                    let what = format!(
                        "'{other}' is not known here; expected [[record]], [im0] or min_send_timeout"
                    );
                    return Err(wrong(at, what));
                }
            }
        }
        let count = records.records.len();
        if count > MAX_RECORDS {
            return Err(wrong(1, format!("{count} records, expected at most {MAX_RECORDS}")));
        }
        Ok(records)
    }
}

fn wrong(line: usize, what: String) -> RecordsError {
    RecordsError { line, what }
}

/// The keys of a table, each with its line.
fn parts<'a, 'b>(
    value: &'a DeValue<'b>,
    at: usize,
    line: impl Fn(usize) -> usize,
) -> Result<Vec<Part<'a, 'b>>, RecordsError> {
    let DeValue::Table(table) = value else {
        return Err(wrong(at, "a record begins with [[record]]".into()));
    };
    Ok(table.iter().map(|(key, value)| (&**key.get_ref(), value.get_ref(), line(key.span().start))).collect())
}

fn record(parts: &[Part<'_, '_>], at: usize) -> Result<((u8, u8), StationRecord), RecordsError> {
    let (mut slot, mut index, mut len, mut data) = (None, None, None, None);
    let mut record = StationRecord { data: Vec::new(), read: true, write: true, delay: Duration::ZERO };
    for &(key, value, at) in parts {
        match key {
            "slot" => slot = Some(number(value, at, 0, 254)?),
            "index" => index = Some((number(value, at, 0, 255)?, at)),
            "length" => len = Some((number(value, at, 1, u16::from(MAX_DATA))?, at)),
            "delay_ms" => record.delay = Duration::from_millis(number(value, at, 0, u16::MAX)?.into()),
            "access" => {
                (record.read, record.write) = match text(value, at)? {
                    "r" => (true, false),
                    "w" => (false, true),
                    "rw" => (true, true),
                    other => return Err(wrong(at, format!("access is '{other}', expected r, w or rw"))),
                }
            }
            "data" => {
                data = Some((
                    octets_of_hex(text(value, at)?).ok_or_else(|| {
                        wrong(at, "data is no hexadecimal octets, expected \"01 02 FF\"".into())
                    })?,
                    at,
                ))
            }
            other => {
                let what = format!(
                    "'{other}' is not known here; expected slot, index, length, access, data or delay_ms"
                );
                return Err(wrong(at, what));
            }
        }
    }
    let missing = |what: &str| wrong(at, format!("the record has no {what}; add it"));
    let slot = u8::try_from(slot.ok_or_else(|| missing("slot"))?).unwrap_or(u8::MAX);
    let (index, index_at) = index.ok_or_else(|| missing("index"))?;
    let index = u8::try_from(index).unwrap_or(u8::MAX);
    if [CALL_INDEX, PARAMETER_INDEX].contains(&index) {
        let what = format!("index {index} has a meaning of its own; choose another one");
        return Err(wrong(index_at, what));
    }
    record.data = match (data, len) {
        (Some((data, at)), _) if data.is_empty() || data.len() > usize::from(MAX_DATA) => {
            return Err(wrong(at, format!("data has {} octets, expected 1..240", data.len())));
        }
        (Some((data, _)), Some((len, at))) if data.len() != usize::from(len) => {
            return Err(wrong(
                at,
                format!("length is {len}, and data has {} octets; leave length out", data.len()),
            ));
        }
        (Some((data, _)), _) => data,
        (None, Some((len, _))) => vec![0; len.into()],
        (None, None) => return Err(missing("length and no data")),
    };
    Ok(((slot, index), record))
}

fn identification(records: &mut StationRecords, parts: &[Part<'_, '_>]) -> Result<(), RecordsError> {
    let mut own = Identification::PLAIN;
    for &(key, value, at) in parts {
        match key {
            "manufacturer_id" => own.manufacturer_id = number(value, at, 0, u16::MAX)?,
            "order_id" => own.order_id = Text::of(text(value, at)?),
            "serial_number" => own.serial_number = Text::of(text(value, at)?),
            "hardware_revision" => own.hardware_revision = number(value, at, 0, u16::MAX)?,
            "software_revision" => {
                own.software_revision = revision(text(value, at)?)
                    .ok_or_else(|| wrong(at, "expected a letter and three numbers: \"V1.2.3\"".into()))?;
            }
            "revision_counter" => own.revision_counter = number(value, at, 0, u16::MAX)?,
            "profile_id" => own.profile_id = number(value, at, 0, u16::MAX)?,
            "profile_specific_type" => own.profile_specific_type = number(value, at, 0, u16::MAX)?,
            "writable" => {
                let DeValue::Array(list) = value else {
                    return Err(wrong(at, "writable is no list; expected some of [1, 2, 3, 4]".into()));
                };
                for value in list {
                    let block = number(value.get_ref(), at, 1, 4)?;
                    records.blocks.insert(block, [b' '; LEN]);
                    own.supported |= 1 << block;
                }
            }
            other => return Err(wrong(at, format!("'{other}' is not known here; see docs/stations.md"))),
        }
    }
    records.identification = Some(own);
    Ok(())
}

/// `V1.2.3`
fn revision(text: &str) -> Option<Revision> {
    let letter = *text.as_bytes().first()?;
    let numbers =
        text.get(1..)?.split('.').map(|number| number.parse::<u8>().ok()).collect::<Option<Vec<u8>>>()?;
    let numbers = numbers.try_into().ok()?;
    b"VRPUT".contains(&letter).then_some(Revision { letter, numbers })
}

fn text<'a>(value: &'a DeValue<'_>, at: usize) -> Result<&'a str, RecordsError> {
    let DeValue::String(text) = value else { return Err(wrong(at, "expected a text in quotes".into())) };
    Ok(text)
}

fn number(value: &DeValue<'_>, at: usize, least: u16, most: u16) -> Result<u16, RecordsError> {
    let number = if let DeValue::Integer(integer) = value {
        u16::from_str_radix(integer.as_str(), integer.radix()).ok()
    } else {
        None
    };
    let number = number.filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| wrong(at, format!("expected a number from {least} to {most}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_records_and_identification() {
        let file = "min_send_timeout = 10\n[[record]]\nslot = 1\nindex = 10\ndata = \"01 0203\"\naccess = \"r\"\n\
            delay_ms = 20\n[[record]]\nslot = 0\nindex = 0x0B\nlength = 2\n[im0]\nmanufacturer_id = 42\n\
            order_id = \"6ES7\"\nsoftware_revision = \"V1.2.3\"\nwritable = [1, 3]\n";
        let records = StationRecords::from_toml(file).unwrap();
        let delay = Duration::from_millis(20);
        let first = StationRecord { data: vec![1, 2, 3], read: true, write: false, delay };
        assert_eq!((records.record(1, 10), records.min_send_timeout), (Some(&first), 10));
        assert_eq!(records.record(0, 11).map(|record| &*record.data), Some(&[0, 0][..]));
        let own = records.identification.unwrap();
        assert_eq!(
            (own.manufacturer_id, own.supported, own.software_revision.numbers),
            (42, 0b1010, [1, 2, 3])
        );
    }

    #[test]
    fn a_mistake_is_told_with_its_line_and_the_cure() {
        let head = "[[record]]\nslot = 1\nindex = 10\n";
        for (file, words) in [
            (
                "x = 1\n".to_owned(),
                "line 1: 'x' is not known here; expected [[record]], [im0] or min_send_timeout",
            ),
            ("[[record]]\nslot = 1\n".to_owned(), "line 1: the record has no index; add it"),
            (head.to_owned(), "line 1: the record has no length and no data; add it"),
            (format!("{head}length = 241\n"), "line 4: expected a number from 1 to 240"),
            (format!("{head}data = \"1\"\n"), "line 4: data is no hexadecimal octets, expected \"01 02 FF\""),
            (format!("{head}data = \"\"\n"), "line 4: data has 0 octets, expected 1..240"),
            (
                format!("{head}length = 3\ndata = \"01\"\n"),
                "line 4: length is 3, and data has 1 octets; leave length out",
            ),
            (format!("{head}access = \"x\"\n"), "line 4: access is 'x', expected r, w or rw"),
            (format!("{head}length = 1\n{head}length = 1\n"), "line 5: slot 1 has a record 10 already"),
            (
                "[[record]]\nslot = 1\nindex = 47\nlength = 1\n".to_owned(),
                "line 3: index 47 has a meaning of its own; choose another one",
            ),
            (
                "[im0]\nsoftware_revision = \"1.2\"\n".to_owned(),
                "line 2: expected a letter and three numbers: \"V1.2.3\"",
            ),
        ] {
            assert_eq!(StationRecords::from_toml(&file).unwrap_err().to_string(), words, "{file}");
        }
    }
}
