//! Read and Write of records. Which there are the judge knows from `records=`.

use core::time::Duration;

use super::channel::{is_of_read, must_refuse};
use super::{expected, likely, open, row};
use crate::host::StationRecord;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::tester::{Channel, is_negative};
use crate::profibus::dpv1::{ErrorCode, Failure, Function, MAX_DATA};

pub(super) const GROUP: Group<Tester> = Group {
    title: "DP-V1: Read and Write",
    rows: &[
        row(
            "V1-R18",
            "Read with the length of the record gives all of it",
            "Read.res: slot, index, n, n octets (dp-v1 3.1)",
            &["V1-R06"],
            By::Trial(r18),
        ),
        likely(row(
            "V1-R19",
            "Read with 240 gives as many octets as the record has",
            "n = min(length asked, length of the record), never an error (dp-v1 3.1)",
            &["V1-R18"],
            By::Trial(r19),
        )),
        likely(row(
            "V1-R20",
            "Read with fewer octets gives the first ones",
            "n = min(length asked, length of the record) (dp-v1 3.1)",
            &["V1-R18"],
            By::Trial(r20),
        )),
        row(
            "V1-R21",
            "Read of an index that is not there: B0, invalid index",
            "slot known, index not: B0 (dp-v1 2.1)",
            &["V1-R06"],
            By::Trial(r21),
        ),
        row(
            "V1-R22",
            "Read of slot 255, which no device has: B2, invalid slot",
            "slot unknown, 255: B2 (dp-v1 2.1)",
            &["V1-R06"],
            By::Trial(r22),
        ),
        row(
            "V1-R23",
            "a Write is answered with slot, index and length, and a Read gives the new octets",
            "Write.res: slot, index and length as in the request (dp-v1 3.1)",
            &["V1-R18"],
            By::Trial(r23),
        ),
        likely(row(
            "V1-R24",
            "Write with one octet less or more: B1, and the record stays",
            "a Write brings exactly the length of the record: else B1 (dp-v1 3.1)",
            &["V1-R23"],
            By::Trial(r24),
        )),
        likely(row(
            "V1-R25",
            "Write to a record that can only be read: B6, and it stays",
            "B6 access denied: Write to a record that is read only (dp-v1 2.1)",
            &["V1-R18"],
            By::Trial(r25),
        )),
        expected(row(
            "V1-R26",
            "Read of a record that can only be written: B6",
            "B6 access denied: Read of a record that is write only (dp-v1 2.1)",
            &["V1-R06"],
            By::Trial(r26),
        )),
        open(row(
            "V1-R27",
            "Read with length 0: B7, or a response without octets",
            "B7 invalid range: length 0 in Read (dp-v1 2.1)",
            &["V1-R18"],
            By::Trial(r27),
        )),
        row(
            "V1-R28",
            "a record of 240 octets is read and written whole",
            "most octets 240, PDU of 244 (dp-v1 3.1)",
            &["V1-R18"],
            By::Trial(r28),
        ),
        expected(row(
            "V1-R29",
            "no Read gives more octets than C1_Max_Data_Len",
            "longer requests: the length of a Read is cut to C1_Max_Data_Len (dp-v1 8)",
            &["V1-R06"],
            By::Trial(r29),
        )),
        open(row(
            "V1-R30",
            "what is no request is refused: an unknown function, one to three octets, a wrong length octet",
            "malformed: negative, RR, RS, or an end of data exchange; never silence, never a positive response (dp-v1 3.2)",
            &["V1-R06"],
            By::Trial(r30),
        )),
        row(
            "V1-R31",
            "a negative response has four octets, Error_Decode 80 and no reserved code",
            "negative: function with bit 7, Error_Decode, Error_Code_1, Error_Code_2 (dp-v1 2)",
            &[],
            By::Watching(r31),
        ),
        expected(row(
            "V1-R32",
            "a record that takes time: SC until then, then the response",
            "poll while the job runs: SC (dp-v1 1.1)",
            &["V1-R18"],
            By::Trial(r32),
        )),
        expected(row(
            "V1-R33",
            "what the device puts in a record is read next",
            "the whole record at the moment the job runs (dp-v1 3.1)",
            &["V1-R18"],
            By::Trial(r33),
        )),
        expected(row(
            "V1-K01",
            "each response at SAP 51 comes within C1_Response_Timeout",
            "a promise: no response in time, and the master stops the slave (dp-v1 3.2, 8)",
            &[],
            By::Watching(k01),
        )),
    ],
};

/// Slot and index.
type Place = (u8, u8);

/// The first record that is so.
fn known(
    tester: &Tester,
    what: &str,
    fits: impl Fn(&StationRecord) -> bool,
) -> Course<(Place, StationRecord)> {
    tester.has_ms1()?;
    let records = tester.setup.records.iter().flat_map(|records| records.iter());
    match records.into_iter().find(|(_, record)| fits(record)) {
        Some((place, record)) => Ok((place, record.clone())),
        None => inapplicable(format!("needs records= with a record {what}")),
    }
}

/// A record that can be read.
fn readable(tester: &Tester) -> Course<(Place, u8)> {
    let (place, record) = known(tester, "that can be read", |record| record.read)?;
    Ok((place, len_of(&record)))
}

fn len_of(record: &StationRecord) -> u8 {
    u8::try_from(record.data.len()).unwrap_or(MAX_DATA)
}

pub(super) fn may_write(tester: &Tester) -> Course {
    if tester.setup.writes_allowed {
        Ok(())
    } else {
        inapplicable("needs --write: records are written, and written back")
    }
}

/// What is in a record.
pub(super) fn content(tester: &mut Tester, channel: Channel, place: Place, len: u8) -> Course<Vec<u8>> {
    match tester.read_record(channel, place, len)? {
        Ok(data) => Ok(data),
        Err(failure) => {
            let (slot, index) = place;
            broken(format!("Read of slot {slot} index {index} is refused: {failure}"))
        }
    }
}

/// It is refused with this code.
pub(super) fn is_refused<T>(result: Result<T, Failure>, code: ErrorCode, what: &str) -> Course {
    match result {
        Err(failure) if failure.code == code => Ok(()),
        Err(failure) => broken(format!("{what} is refused with {failure}, expected {:02X}", code.0)),
        Ok(_) => broken(format!("{what} is carried out, expected {:02X}", code.0)),
    }
}

fn r18(tester: &mut Tester) -> Course {
    let (place, len) = readable(tester)?;
    has_len(tester, place, len, len)
}

/// Read with `asked` gives `len` octets.
fn has_len(tester: &mut Tester, place: Place, asked: u8, len: u8) -> Course {
    let channel = tester.open()?;
    let octets = content(tester, channel, place, asked)?;
    if octets.len() == usize::from(len) {
        return Ok(());
    }
    broken(format!("Read with length {asked} gives {} octets, expected {len}", octets.len()))
}

fn r19(tester: &mut Tester) -> Course {
    let (place, len) = readable(tester)?;
    let most = tester.keywords()?.c1_max_data_len.unwrap_or(MAX_DATA);
    has_len(tester, place, MAX_DATA, len.min(most))
}

fn r20(tester: &mut Tester) -> Course {
    let (place, record) = known(tester, "of two octets or more that can be read", |record| {
        record.read && record.data.len() > 1
    })?;
    let channel = tester.open()?;
    let whole = content(tester, channel, place, len_of(&record))?;
    let first = content(tester, channel, place, 1)?;
    if whole.starts_with(&first) && first.len() == 1 {
        return Ok(());
    }
    broken(format!("Read with length 1 gives {}", crate::explain::hex(&first)))
}

/// Places of slot 0 that few devices have.
const FEW_HAVE: [u8; 6] = [254, 253, 199, 151, 99, 3];

fn r21(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let mut first = None;
    let is_known = |tester: &Tester, index: u8| {
        tester.setup.records.as_ref().is_some_and(|records| records.record(0, index).is_some())
    };
    for index in FEW_HAVE {
        if is_known(tester, index) {
            continue;
        }
        match tester.read_record(channel, (0, index), MAX_DATA)? {
            Ok(_) => {}
            Err(failure) if failure.code == ErrorCode::INVALID_INDEX => return Ok(()),
            Err(failure) => {
                first.get_or_insert((index, failure));
            }
        }
    }
    match first {
        Some((index, failure)) => {
            broken(format!("Read of slot 0 index {index} is refused with {failure}, expected B0"))
        }
        None => broken("every index of slot 0 that was tried can be read"),
    }
}

fn r22(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let result = tester.read_record(channel, (255, 1), MAX_DATA)?;
    is_refused(result, ErrorCode::INVALID_SLOT, "Read of slot 255")
}

/// A record that can be read and written.
fn writable(tester: &Tester) -> Course<(Place, u8)> {
    may_write(tester)?;
    let (place, record) =
        known(tester, "that can be read and written", |record| record.read && record.write)?;
    Ok((place, len_of(&record)))
}

/// Other octets are written, and come back; then those of before.
fn there_and_back(tester: &mut Tester, place: Place, len: u8) -> Course {
    let channel = tester.open()?;
    let before = content(tester, channel, place, len)?;
    let other: Vec<u8> = before.iter().map(|octet| !octet).collect();
    for data in [&other, &before] {
        if let Err(failure) = tester.write_record(channel, place, data)? {
            return broken(format!("Write of slot {} index {} is refused: {failure}", place.0, place.1));
        }
        let now = content(tester, channel, place, len)?;
        if now != *data {
            let (got, expected) = (crate::explain::hex(&now), crate::explain::hex(data));
            return broken(format!("behind a Write the record has {got}, expected {expected}"));
        }
    }
    Ok(())
}

fn r23(tester: &mut Tester) -> Course {
    let (place, len) = writable(tester)?;
    there_and_back(tester, place, len)
}

/// This Write is refused, and the record stays.
fn stays(
    tester: &mut Tester,
    channel: Channel,
    (place, len): (Place, u8),
    data: &[u8],
    (code, what): (ErrorCode, &str),
) -> Course {
    let before = content(tester, channel, place, len)?;
    let result = tester.write_record(channel, place, data)?;
    let after = content(tester, channel, place, len)?;
    if after != before {
        tester.write_record(channel, place, &before)?.ok();
        return broken(format!("{what} changes the record"));
    }
    is_refused(result, code, what)
}

fn r24(tester: &mut Tester) -> Course {
    let (place, len) = writable(tester)?;
    let channel = tester.open()?;
    let before = content(tester, channel, place, len)?;
    let other: Vec<u8> = before.iter().map(|octet| !octet).collect();
    let short = other.get(..other.len().saturating_sub(1)).unwrap_or_default();
    let long = [&other[..], &[0]].concat();
    for data in [short, &long] {
        if data.is_empty() || data.len() > MAX_DATA.into() {
            continue;
        }
        let what = format!("Write of {} octets to a record of {len}", data.len());
        stays(tester, channel, (place, len), data, (ErrorCode::WRITE_LENGTH, &what))?;
    }
    Ok(())
}

fn r25(tester: &mut Tester) -> Course {
    may_write(tester)?;
    let (place, record) = known(tester, "that can only be read", |record| record.read && !record.write)?;
    let channel = tester.open()?;
    let len = len_of(&record);
    let other: Vec<u8> = content(tester, channel, place, len)?.iter().map(|octet| !octet).collect();
    let what = "Write to a record that can only be read";
    stays(tester, channel, (place, len), &other, (ErrorCode::ACCESS_DENIED, what))
}

fn r26(tester: &mut Tester) -> Course {
    let (place, _) = known(tester, "that can only be written", |record| record.write && !record.read)?;
    let channel = tester.open()?;
    let result = tester.read_record(channel, place, MAX_DATA)?;
    is_refused(result, ErrorCode::ACCESS_DENIED, "Read of a record that can only be written")
}

fn r27(tester: &mut Tester) -> Course {
    let (place, _) = readable(tester)?;
    let channel = tester.open()?;
    match tester.read_record(channel, place, 0)? {
        Ok(data) if data.is_empty() => Ok(()),
        Ok(data) => broken(format!("Read with length 0 gives {} octets", data.len())),
        Err(failure) => is_refused::<()>(Err(failure), ErrorCode::INVALID_RANGE, "Read with length 0"),
    }
}

fn r28(tester: &mut Tester) -> Course {
    if tester.keywords()?.c1_max_data_len.is_some_and(|most| most < MAX_DATA) {
        return inapplicable("C1_Max_Data_Len is less than 240");
    }
    let long = |record: &StationRecord| record.read && record.data.len() == usize::from(MAX_DATA);
    let (place, record) = known(tester, "of 240 octets that can be read", long)?;
    has_len(tester, place, MAX_DATA, MAX_DATA)?;
    if record.write && tester.setup.writes_allowed {
        tester.release()?;
        there_and_back(tester, place, MAX_DATA)?;
    }
    Ok(())
}

fn r29(tester: &mut Tester) -> Course {
    let most = tester.keywords()?.c1_max_data_len.unwrap_or(MAX_DATA);
    let longer = |record: &StationRecord| record.read && record.data.len() > most.into();
    if most == MAX_DATA {
        return inapplicable("C1_Max_Data_Len is 240");
    }
    let (place, _) = known(tester, &format!("of more than {most} octets that can be read"), longer)?;
    let channel = tester.open()?;
    let got = content(tester, channel, place, MAX_DATA)?.len();
    if got <= most.into() {
        return Ok(());
    }
    broken(format!("a Read gives {got} octets, C1_Max_Data_Len is {most}"))
}

/// Octets that are no request, and what they are.
const NO_REQUESTS: [(&[u8], &str); 6] = [
    (&[0x4D, 0, 0, 1], "the function 4D"),
    (&[Function::Read.number()], "a Read of one octet"),
    (&[Function::Read.number(), 0], "a Read of two octets"),
    (&[Function::Read.number(), 0, 1], "a Read of three octets"),
    (&[Function::Write.number(), 255, 0, 9, 1, 2], "a Write with a wrong length octet"),
    (&[Function::Read.number() | Function::NEGATIVE, 0, 0, 1], "a negative response"),
];

fn r30(tester: &mut Tester) -> Course {
    tester.has_ms1()?;
    for (octets, what) in NO_REQUESTS {
        let channel = tester.open()?;
        match tester.put(channel, octets)? {
            Answer::Status(_) => {}
            Answer::Acknowledged => {
                // It may end the data exchange instead of a response.
                let request = tester.telegram(channel, &[]);
                let answer = tester.must_answer(&request)?;
                if answer == Answer::Acknowledged {
                    let response = tester.response(channel)?;
                    must_refuse(&response, what)?;
                } else if let Answer::Data(_, response) = answer {
                    must_refuse(&response, what)?;
                }
            }
            Answer::Data(_, response) if is_negative(&response) => {}
            answer @ (Answer::Data(..) | Answer::Silence | Answer::Wrong(_)) => {
                return broken(format!("{what} is answered with {}", answer.words()));
            }
        }
        tester.release()?;
    }
    let channel = tester.open()?;
    let octets = tester.carried_out(channel, &Tester::probe())?;
    is_of_read(&octets)
}

fn r31(tester: &mut Tester) -> Course {
    tester.keywords()?;
    watched(tester, "V1-R31", "no service was refused")
}

/// A row that is watched; without an occasion it does not apply.
pub(super) fn watched(tester: &mut Tester, id: &'static str, nothing: &str) -> Course {
    if tester.notes.occasions(id) == 0 { inapplicable(nothing) } else { tester.watched(id, nothing) }
}

fn k01(tester: &mut Tester) -> Course {
    if tester.has_ms1().is_ok() && tester.keywords()?.c1_response.is_none() {
        return inapplicable("the device file has no C1_Response_Timeout");
    }
    watched(tester, "V1-K01", "no response came at SAP 51")
}

/// The shortest delay that is seen.
const SLOW: Duration = Duration::from_millis(100);

fn r32(tester: &mut Tester) -> Course {
    let (place, record) = known(tester, "with a delay_ms of 100 or more that can be read", |record| {
        record.read && record.delay >= SLOW
    })?;
    let channel = tester.open()?;
    let request = [Function::Read.number(), place.0, place.1, MAX_DATA];
    tester.taken(channel, &request, "a Read at SAP 51")?;
    tester.taken(channel, &[], "a poll while a slow record is read")?;
    tester.pause(record.delay / 2)?;
    tester.taken(channel, &[], "a poll while a slow record is read")?;
    let octets = tester.response(channel)?;
    is_of_read(&octets)
}

fn r33(tester: &mut Tester) -> Course {
    let (place, len) = readable(tester)?;
    if !tester.is_attended() {
        return inapplicable("needs --ask: set-record");
    }
    let channel = tester.open()?;
    let before = content(tester, channel, place, len)?;
    let other: Vec<u8> = before.iter().map(|octet| octet ^ 0x5A).collect();
    for data in [&other, &before] {
        let hex: String = data.iter().map(|octet| format!("{octet:02X}")).collect();
        tester.attend(&format!("set-record {} {} {hex}", place.0, place.1))?;
        tester.effect()?;
        let now = content(tester, channel, place, len)?;
        if now != *data {
            return broken(format!(
                "the record has {}, and the device has put {hex} there",
                crate::explain::hex(&now)
            ));
        }
    }
    Ok(())
}
