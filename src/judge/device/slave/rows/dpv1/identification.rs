//! Identification and maintenance: I&M 0 to 4 in record 255.

use super::channel::must_refuse;
use super::records::{is_refused, may_write};
use super::{expected, likely, open, row};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::tester::{Channel, Granted};
use crate::profibus::dpv1::{CALL_INDEX, ErrorCode, Failure, Function, MAX_DATA, PARAMETER_INDEX};

pub(super) const GROUP: Group<Tester> = Group {
    title: "DP-V1: identification (I&M)",
    rows: &[
        row(
            "V1-R83",
            "I&M0 by record 255 of slot 0: header of the call, 64 octets, their fields; over a connection the same",
            "written 08 00 FDE8, read 08 00 FDE8 and 64 octets (dp-v1 7)",
            &["V1-R06", "V1-R70"],
            By::Trial(r83),
        ),
        open(row(
            "V1-R84",
            "record 255 read without a call: refused",
            "fetch without ask: DE 80 B5 (dp-v1 7)",
            &["V1-R83"],
            By::Trial(r84),
        )),
        open(row(
            "V1-R85",
            "a call of a block that is none of I&M: refused, at the Write or at the Read",
            "unknown IM index: DF 80 B0 or DE 80 B0 (dp-v1 7)",
            &["V1-R83"],
            By::Trial(r85),
        )),
        likely(row(
            "V1-I01",
            "each block that IM_SUPPORTED names can be read",
            "IM_SUPPORTED: bit n = I&Mn for 1 to 4 (dp-v1 7)",
            &["V1-R83"],
            By::Trial(i01),
        )),
        likely(row(
            "V1-R86",
            "I&M1 to I&M4 that are writable keep what is written; a Write of I&M0 is refused",
            "write I&M1..4: header and 64 octets; I&M0: DF 80 B6 (dp-v1 7)",
            &["V1-I01"],
            By::Trial(r86),
        )),
        expected(row(
            "V1-R87",
            "record 47 of a slave that is no drive: B0, invalid index",
            "record 47 has PROFIdrive parameters; slot known, index not: B0 (dp-v1 2.1, 3.1)",
            &["V1-R21"],
            By::Trial(r87),
        )),
    ],
};

/// The number of I&M0.
const FIRST: u16 = 65000;
const CALL_LEN: usize = 4;
const LEN: usize = 64;
const PLACE: (u8, u8) = (0, CALL_INDEX);

fn call(block: u16) -> [u8; CALL_LEN] {
    let [high, low] = (FIRST + block).to_be_bytes();
    [0x08, 0, high, low]
}

/// It has I&M.
fn has(tester: &Tester) -> Course {
    if tester.keywords()?.identification {
        Ok(())
    } else {
        inapplicable("the device file has no Ident_Maintenance_supp")
    }
}

/// What a call of a block gives.
fn called(tester: &mut Tester, channel: Channel, block: u16) -> Course<Result<Vec<u8>, Failure>> {
    match tester.write_record(channel, PLACE, &call(block))? {
        Err(failure) => Ok(Err(failure)),
        Ok(()) => tester.read_record(channel, PLACE, MAX_DATA),
    }
}

/// The 64 octets of a block that is there.
fn block_of(tester: &mut Tester, channel: Channel, block: u16) -> Course<[u8; LEN]> {
    let data = match called(tester, channel, block)? {
        Ok(data) => data,
        Err(failure) => return broken(format!("I&M{block} is refused: {failure}")),
    };
    match data.split_first_chunk::<CALL_LEN>() {
        Some((head, rest)) if *head == call(block) => match <[u8; LEN]>::try_from(rest) {
            Ok(octets) => Ok(octets),
            Err(_) => broken(format!("I&M{block} has {} octets, expected {LEN}", rest.len())),
        },
        Some(_) | None => {
            broken(format!("I&M{block} begins with another call: {}", crate::explain::hex(&data)))
        }
    }
}

/// What is wrong with the fields of I&M0.
fn wrong_field(octets: &[u8; LEN]) -> Option<String> {
    let of = |from: usize, len: usize| octets.get(from..from + len).unwrap_or_default();
    let is_text = |octets: &[u8]| octets.iter().all(|octet| (0x20..0x7F).contains(octet) || *octet == 0);
    for (from, len, name) in [(12, 20, "ORDER_ID"), (32, 16, "SERIAL_NUMBER")] {
        if !is_text(of(from, len)) {
            return Some(format!("{name} is no text: {}", crate::explain::hex(of(from, len))));
        }
    }
    match of(50, 1) {
        [b'V' | b'R' | b'P' | b'U' | b'T'] => {}
        other => {
            return Some(format!("SOFTWARE_REVISION begins with {other:02X?}, expected V, R, P, U or T"));
        }
    }
    match of(60, 2) {
        [1, version] if *version > 0 => None,
        other => Some(format!("IM_VERSION is {other:02X?}, expected 01 01 or 01 02")),
    }
}

fn r83(tester: &mut Tester) -> Course {
    has(tester)?;
    let channel = tester.open()?;
    let octets = block_of(tester, channel, 0)?;
    if let Some(why) = wrong_field(&octets) {
        return broken(why);
    }
    if tester.has_ms2().is_err() {
        return Ok(());
    }
    tester.connected(|tester, Granted { channel, .. }| {
        if block_of(tester, channel, 0)? == octets {
            return Ok(());
        }
        broken("I&M0 over a connection is another one than at SAP 51")
    })
}

fn r84(tester: &mut Tester) -> Course {
    has(tester)?;
    let channel = tester.open()?;
    let octets = tester.carried_out(channel, &[Function::Read.number(), 0, CALL_INDEX, MAX_DATA])?;
    must_refuse(&octets, "Read of record 255 without a call")
}

fn r85(tester: &mut Tester) -> Course {
    has(tester)?;
    let channel = tester.open()?;
    match called(tester, channel, 199)? {
        Err(_) => Ok(()),
        Ok(data) => broken(format!("a call of 65199 gives {}", crate::explain::hex(&data))),
    }
}

/// The blocks 1 to 4 that I&M0 names.
fn named(octets: &[u8; LEN]) -> Vec<u16> {
    let supported = octets
        .get(62..64)
        .map_or(0, |pair| pair.iter().fold(0_u16, |sum, octet| sum << 8 | u16::from(*octet)));
    (1..=4).filter(|block| supported >> block & 1 == 1).collect()
}

fn i01(tester: &mut Tester) -> Course {
    has(tester)?;
    let channel = tester.open()?;
    let first = block_of(tester, channel, 0)?;
    for block in named(&first) {
        block_of(tester, channel, block)?;
    }
    Ok(())
}

fn r86(tester: &mut Tester) -> Course {
    has(tester)?;
    may_write(tester)?;
    let channel = tester.open()?;
    let first = block_of(tester, channel, 0)?;
    for block in named(&first) {
        let before = block_of(tester, channel, block)?;
        let other = before.map(|octet| if octet == b'x' { b'y' } else { b'x' });
        let mut is_kept = true;
        for octets in [&other, &before] {
            let data = [&call(block)[..], octets].concat();
            match tester.write_record(channel, PLACE, &data)? {
                // It can be read only.
                Err(failure) if failure.code == ErrorCode::ACCESS_DENIED => break,
                Err(failure) => return broken(format!("Write of I&M{block} is refused: {failure}")),
                Ok(()) => is_kept &= block_of(tester, channel, block)? == *octets,
            }
        }
        if !is_kept {
            return broken(format!("I&M{block} is written, and read it is another one"));
        }
    }
    let data = [&call(0)[..], &first].concat();
    let result = tester.write_record(channel, PLACE, &data)?;
    if result.is_ok() {
        return is_refused(result, ErrorCode::ACCESS_DENIED, "Write of I&M0");
    }
    Ok(())
}

fn r87(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let is_known =
        tester.setup.records.as_ref().is_some_and(|records| records.record(0, PARAMETER_INDEX).is_some());
    if tester.setup.profidrive || is_known {
        return inapplicable("the slave has a record 47");
    }
    let result = tester.read_record(channel, (0, PARAMETER_INDEX), MAX_DATA)?;
    is_refused(result, ErrorCode::INVALID_INDEX, "Read of record 47")
}
