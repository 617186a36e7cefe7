//! Records of a station, and the alarms on its time line.

use super::signals::whole;
use super::timed::{find, flag, needed, table, time, word};
use super::{Given, Wrong};
use crate::gsd::Gsd;
use crate::host::{StationRecord, StationRecords, TimedAlarm, octets_of_hex};
use crate::profibus::dpv1::{AlarmType, CALL_INDEX, MAX_DATA, PARAMETER_INDEX, Specifier};

/// The keys of a record, and of an alarm.
pub(crate) const RECORD: &[&str] = &["slot", "index", "length", "data", "access", "delay"];
pub(crate) const ALARM: &[&str] = &["at", "every", "type", "slot", "specifier", "additional-ack", "data"];

/// What a master may do to a record: read and write.
pub(crate) const ACCESS: [(&str, (bool, bool)); 3] =
    [("rw", (true, true)), ("r", (true, false)), ("w", (false, true))];

/// Adds the records that were given.
///
/// # Errors
/// [`Wrong`] says which and which key.
pub(super) fn records(key: &str, given: &[Given], records: &mut StationRecords) -> Result<(), Wrong> {
    for (number, given) in given.iter().enumerate() {
        let under = |wrong: Wrong| wrong.under(&[key, &number.to_string()]);
        let (place, record) = record(given).map_err(under)?;
        if records.record(place.0, place.1).is_some() {
            let words = format!("slot {} has a record {} already", place.0, place.1);
            return Err(under(Wrong::whole(words)));
        }
        records.insert(place, record);
    }
    Ok(())
}

/// The alarms that were given.
///
/// # Errors
/// [`Wrong`] says which and which key.
pub(super) fn alarms(key: &str, given: &[Given], gsd: &Gsd) -> Result<Vec<TimedAlarm>, Wrong> {
    let one = |(number, given): (usize, &Given)| {
        alarm(given, gsd).map_err(|wrong| wrong.under(&[key, &number.to_string()]))
    };
    given.iter().enumerate().map(one).collect()
}

fn record(given: &Given) -> Result<((u8, u8), StationRecord), Wrong> {
    let table = table(given, RECORD)?;
    let index: u8 = whole("index", needed(table, "index")?)?;
    if [CALL_INDEX, PARAMETER_INDEX].contains(&index) {
        return Err(Wrong::at(
            "index",
            format!("index {index} has a meaning of its own; choose another one"),
        ));
    }
    let length: Option<u8> = find(table, "length").map(|given| whole("length", given)).transpose()?;
    let data = match (find(table, "data"), length) {
        (Some(given), _) => hex("data", given)?,
        (None, Some(length)) => vec![0; length.into()],
        (None, None) => return Err(Wrong::whole("the record has no length and no data; add one")),
    };
    if data.is_empty() || data.len() > usize::from(MAX_DATA) {
        return Err(Wrong::whole(format!("the record has {} octets, expected 1 to 240", data.len())));
    }
    if length.is_some_and(|length| data.len() != usize::from(length)) {
        let words = format!("data has {} octets; leave length out", data.len());
        return Err(Wrong::at("length", words));
    }
    let (read, write) = word(table, "access", &ACCESS)?;
    let delay = time(table, "delay")?.unwrap_or_default();
    Ok(((slot(needed(table, "slot")?)?, index), StationRecord { data, read, write, delay }))
}

fn alarm(given: &Given, gsd: &Gsd) -> Result<TimedAlarm, Wrong> {
    let table = table(given, ALARM)?;
    let every = time(table, "every")?;
    let text = needed(table, "type")?.to_string();
    let kind = AlarmType::named(&text).ok_or_else(|| {
        let names = AlarmType::NAMED.map(|(name, _)| name).join(", ");
        let words = format!("'{text}' is no type of an alarm; expected {names}, or a number from 32 to 126");
        Wrong::at("type", words)
    })?;
    if !gsd.acyclic.offer(0).alarms.has(kind) {
        return Err(Wrong::at("type", format!("the GSD has no {kind}; choose another type")));
    }
    let data = find(table, "data").map(|given| hex("data", given)).transpose()?.unwrap_or_default();
    Ok(TimedAlarm {
        at: time(table, "at")?.unwrap_or_default(),
        every,
        kind,
        slot: find(table, "slot").map(slot).transpose()?.unwrap_or_default(),
        specifier: word(table, "specifier", &Specifier::NAMED)?,
        additional_ack: flag(table, "additional-ack"),
        data,
    })
}

fn slot(given: &Given) -> Result<u8, Wrong> {
    let slot: u8 = whole("slot", given)?;
    if slot == u8::MAX { Err(Wrong::at("slot", "slot 255 is none; expected 0 to 254")) } else { Ok(slot) }
}

fn hex(key: &str, given: &Given) -> Result<Vec<u8>, Wrong> {
    let text = given.to_string();
    octets_of_hex(&text).ok_or_else(|| {
        Wrong::at(
            key,
            format!("{key}: '{text}' is no hexadecimal octets; expected two digits each, \"01 FF\""),
        )
    })
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use super::*;

    fn row(keys: &[(&str, Given)]) -> Given {
        Given::Table(keys.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect())
    }

    fn text(text: &str) -> Given {
        Given::Text(text.to_owned())
    }

    #[test]
    fn records_and_alarms_are_read_and_mistakes_are_told_with_their_key() {
        let (slot, index) = (("slot", Given::Number(1.0)), ("index", Given::Number(10.0)));
        let mut all = StationRecords::default();
        let good = row(&[
            slot.clone(),
            index.clone(),
            ("data", text("01 02")),
            ("access", text("r")),
            ("delay", text("20ms")),
        ]);
        records("record", core::slice::from_ref(&good), &mut all).unwrap();
        let record = all.record(1, 10).unwrap();
        assert_eq!(
            (&record.data[..], record.write, record.delay),
            (&[1, 2][..], false, Duration::from_millis(20))
        );
        for (given, words) in [
            (good, "slot 1 has a record 10 already"),
            (
                row(&[slot.clone(), ("index", Given::Number(47.0)), ("length", Given::Number(1.0))]),
                "index 47 has a meaning of its own; choose another one",
            ),
            (row(&[slot.clone(), index.clone()]), "the record has no length and no data; add one"),
            (
                row(&[slot.clone(), index.clone(), ("data", text("1"))]),
                "data: '1' is no hexadecimal octets; expected two digits each, \"01 FF\"",
            ),
            (
                row(&[slot, index, ("length", Given::Number(0.0))]),
                "the record has 0 octets, expected 1 to 240",
            ),
        ] {
            assert_eq!(records("record", &[given], &mut all).unwrap_err().words, words);
        }
        let gsd = Gsd::read(b"#Profibus_DP\nIdent_Number=1\nDPV1_Slave=1\nC1_Read_Write_supp=1\nProcess_Alarm_supp=1\nModule=\"a\" 0x10\nEndModule\n").unwrap();
        let alarm = row(&[
            ("at", text("5s")),
            ("type", text("process")),
            ("slot", Given::Number(1.0)),
            ("data", text("50")),
        ]);
        let timed = alarms("alarm", &[alarm], &gsd).unwrap();
        assert_eq!(
            (timed[0].at, timed[0].every, timed[0].kind),
            (Duration::from_secs(5), None, AlarmType::Process)
        );
        for (given, words) in [
            (row(&[("type", text("update"))]), "the GSD has no update alarm; choose another type"),
            (
                row(&[("type", text("x"))]),
                "'x' is no type of an alarm; expected diagnostic, process, pull, plug, status, update, or a number from 32 to 126",
            ),
            (row(&[("slot", Given::Number(1.0))]), "'type' is missing"),
        ] {
            assert_eq!(alarms("alarm", &[given], &gsd).unwrap_err().words, words);
        }
    }
}
