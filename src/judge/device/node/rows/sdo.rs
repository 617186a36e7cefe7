//! SDO: what every server must do with requests, right and wrong.

use super::{row, sure};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::{Abort, Address, cob_id};
use crate::explain::hex;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::sdo::{abort_of, address_of, addressed, expedited, refused};
use crate::judge::device::node::tester::LATE;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::{B, C};

pub(super) const GROUP: Group<Tester> = Group {
    title: "SDO",
    rows: &[
        row(
            "N-O01",
            "a read of 1, 2 and 4 octets: 4F, 4B, 43; the address repeated, unused octets 0",
            "40h initiate upload: answer 010 x nn e s; 43 4 bytes, 4B 2, 4F 1 (5)",
            &[],
            By::Trial(o01),
        ),
        sure(
            row(
                "N-O02",
                "a write without a size (22h) is taken with the length of the object",
                "22h expedited without size: server takes the object's length (5)",
                &["N-O01"],
                By::Trial(o02),
            ),
            B,
        ),
        row(
            "N-O03",
            "an object that is not there: 06020000h; a sub-index that is not there: 06090011h",
            "abort codes (5)",
            &[],
            By::Trial(o03),
        ),
        row(
            "N-O04",
            "a write of what can only be read: 06010002h",
            "06010002h write of read-only (5)",
            &["N-O01"],
            By::Trial(o04),
        ),
        row(
            "N-O05",
            "a write that is too short or too long is refused, the value stays",
            "longer than the object 06070012h, shorter 06070013h, simply wrong 06070010h (5)",
            &["N-O01"],
            By::Trial(o05),
        ),
        row(
            "N-O07",
            "an unknown command, and a segment request without a transfer: an abort",
            "05040001h command specifier invalid; a segment request without a transfer: 05040001h (5)",
            &[],
            By::Trial(o07),
        ),
        row(
            "N-O10",
            "an abort of the client: silence, and the next request is served",
            "abort: never answered (5)",
            &["N-O01"],
            By::Trial(o10),
        ),
        sure(
            row(
                "N-O12",
                "SDO frames of 0 to 7 octets, remote frames, 29-bit identifiers: silence, and the next request is served",
                "frames of other lengths are ignored (5)",
                &["N-O01"],
                By::Trial(o12),
            ),
            B,
        ),
        row(
            "N-O14",
            "a request to another node's server: silence",
            "each node has a server of its own, 600h+n (2)",
            &[],
            By::Trial(o14),
        ),
        sure(
            row(
                "N-O20",
                "every answer comes within 300 ms",
                "python-canopen and others wait 0.3 s (12)",
                &[],
                By::Watching(o20),
            ),
            C,
        ),
    ],
};

const DEVICE_TYPE: Address = Address::new(0x1000, 0);

fn o01(tester: &mut Tester) -> Course {
    for (index, sub, len) in [(0x1000, 0, 4), (0x1001, 0, 1), (0x1018, 0, 1), (0x1018, 1, 4), (0x1017, 0, 2)]
    {
        let optional = index == 0x1017;
        if optional && !tester.has(index, sub)? {
            continue;
        }
        let at = Address::new(index, sub);
        let answer = tester.asked(addressed(0x40, at, [0; 4]), &format!("a read of {at}"))?;
        if let Some(code) = abort_of(answer) {
            return broken(format!("a read of {at} is refused with {}", refused(code)));
        }
        let Some(octets) = expedited(answer) else {
            return broken(format!(
                "a read of {at} is answered with {}, expected an expedited value",
                hex(&answer)
            ));
        };
        let [command, ..] = answer;
        let expected = 0x43 | (4 - len) << 2;
        let without_size = command == 0x42 && len == 4;
        if command != expected && !without_size {
            return broken(format!(
                "a read of {at} is answered with command {command:02X}h, expected {expected:02X}h"
            ));
        }
        if address_of(answer) != at {
            return broken(format!("a read of {at} is answered with {}", address_of(answer)));
        }
        let unused = answer.iter().skip(4 + octets.len());
        if unused.into_iter().any(|octet| *octet != 0) {
            return broken(format!(
                "unused octets of the answer to a read of {at} are not 0: {}",
                hex(&answer)
            ));
        }
    }
    Ok(())
}

/// What a write of a wrong length is refused with; the last one is that of some drives.
pub(super) const WRONG_LENGTH: [u32; 4] =
    [Abort::LENGTH.code(), Abort::TOO_LONG.code(), Abort::TOO_SHORT.code(), Abort::UNSUPPORTED_ACCESS.code()];

/// Something that can be written without harm, of at least two octets, and what it holds.
fn writable(tester: &mut Tester) -> Course<(Address, Vec<u8>)> {
    tester.may_write()?;
    for index in [0x1017, 0x100C, 0x1006, 0x1014] {
        if tester.is_writable(index, 0)?
            && let Ok(octets) = tester.upload(Address::new(index, 0))?
        {
            return Ok((Address::new(index, 0), octets));
        }
    }
    inapplicable("it has none of 1017h, 100Ch, 1006h and 1014h to write to")
}

fn o02(tester: &mut Tester) -> Course {
    let (at, octets) = writable(tester)?;
    let mut data = [0; 4];
    for (to, octet) in data.iter_mut().zip(&octets) {
        *to = *octet;
    }
    let answer = tester.asked(addressed(0x22, at, data), &format!("a write of {at} without a size"))?;
    if let Some(code) = abort_of(answer) {
        return broken(format!("a write of {at} without a size is refused with {}", refused(code)));
    }
    unchanged(tester, at, &octets, "a write of the value it holds, without a size")
}

/// An entry holds what it held.
pub(super) fn unchanged(tester: &mut Tester, at: Address, before: &[u8], what: &str) -> Course {
    match tester.upload(at)? {
        Ok(octets) if octets == before => Ok(()),
        Ok(octets) => broken(format!("after {what} {at} is {}, it was {}", hex(&octets), hex(before))),
        Err(code) => broken(format!("after {what} a read of {at} is refused with {}", refused(code))),
    }
}

fn o03(tester: &mut Tester) -> Course {
    for index in [0x0FFF, 0x1FFF, 0x9999, 0xFFFF] {
        if tester.has(index, 0)? && tester.setup.eds.is_some() {
            continue;
        }
        let got = tester.upload(Address::new(index, 0))?.map(drop);
        tester.must_refuse(
            got,
            &[Abort::NO_OBJECT.code()],
            &format!("a read of {index:04X}h, which is not there,"),
        )?;
    }
    let got = tester.upload(Address::new(0x1018, 0x40))?.map(drop);
    tester.must_refuse(got, &[Abort::NO_SUB.code()], "a read of 1018h:40, which is not there,")
}

fn o04(tester: &mut Tester) -> Course {
    tester.may_write()?;
    let before = tester.value(0x1000, 0)?;
    let mut other = before.clone();
    other.iter_mut().for_each(|octet| *octet = !*octet);
    let got = tester.download(DEVICE_TYPE, &other)?;
    tester.must_refuse(got, &[Abort::READ_ONLY.code()], "a write of 1000h")?;
    unchanged(tester, DEVICE_TYPE, &before, "a write that was refused")
}

fn o05(tester: &mut Tester) -> Course {
    let (at, before) = writable(tester)?;
    let long = [before.clone(), vec![0; 2]].concat();
    let short = before.get(1..).unwrap_or_default().to_vec();
    for octets in [long, short] {
        let what = format!("a write of {} octets to {at}, which has {},", octets.len(), before.len());
        let got = tester.download(at, &octets)?;
        tester.must_refuse(got, &WRONG_LENGTH, &what)?;
        unchanged(tester, at, &before, &what)?;
    }
    Ok(())
}

fn o07(tester: &mut Tester) -> Course {
    let requests = [
        (addressed(0xE0, DEVICE_TYPE, [0; 4]), "an unknown command (E0h)"),
        ([0x60, 0, 0, 0, 0, 0, 0, 0], "a segment request without a transfer"),
        ([0x00, 0, 0, 0, 0, 0, 0, 0], "a segment without a transfer"),
    ];
    for (request, what) in requests {
        let answer = tester.asked(request, what)?;
        if abort_of(answer).is_none() {
            return broken(format!("{what} is answered with {}, expected an abort", hex(&answer)));
        }
    }
    Ok(())
}

fn o10(tester: &mut Tester) -> Course {
    let abort = addressed(0x80, DEVICE_TYPE, Abort::GENERAL.code().to_le_bytes());
    tester.drain()?;
    tester.send(tester.id(cob_id::SDO_CLIENT), &abort)?;
    tester.silent_on(tester.id(cob_id::SDO_SERVER), "the client aborts without a transfer")?;
    if let Some(at) = super::segments::long_one(tester)? {
        super::segments::begin(tester, at)?;
        tester
            .send(tester.id(cob_id::SDO_CLIENT), &addressed(0x80, at, Abort::GENERAL.code().to_le_bytes()))?;
        tester.silent_on(tester.id(cob_id::SDO_SERVER), "the client aborts a transfer")?;
        let answer = tester.asked([0x60, 0, 0, 0, 0, 0, 0, 0], "a segment request after an abort")?;
        if abort_of(answer).is_none() {
            return broken(format!("a transfer of {at} goes on after the client has aborted it"));
        }
    }
    tester.value(0x1000, 0).map(drop)
}

fn o12(tester: &mut Tester) -> Course {
    let (client, server) = (tester.id(cob_id::SDO_CLIENT), tester.id(cob_id::SDO_SERVER));
    let read = addressed(0x40, DEVICE_TYPE, [0; 4]);
    tester.drain()?;
    let step = if tester.setup.quick { 7 } else { 1 };
    for len in (0..8).step_by(step) {
        tester.send(client, read.get(..len).unwrap_or_default())?;
        tester.silent_on(server, &format!("an SDO request of {len} octets is sent"))?;
    }
    tester.request(client, 8)?;
    tester.silent_on(server, "a remote frame with the identifier of the SDO is sent")?;
    if let Ok(extended) = Id::extended(client.number())
        && let Ok(frame) = Frame::data(extended, &read)
    {
        tester.wire.send(frame)?;
        tester.silent_on(server, "an SDO request with an identifier of 29 bits is sent")?;
    }
    tester.value(0x1000, 0).map(drop)
}

fn o14(tester: &mut Tester) -> Course {
    tester.drain()?;
    let other = tester.other();
    tester.send(cob_id::of_node(cob_id::SDO_CLIENT, other), &addressed(0x40, DEVICE_TYPE, [0; 4]))?;
    tester.silent_on(tester.id(cob_id::SDO_SERVER), &format!("node {other} is asked"))?;
    tester.silent_on(
        cob_id::of_node(cob_id::SDO_SERVER, other),
        &format!("node {other}, which is not there, is asked"),
    )
}

fn o20(tester: &mut Tester) -> Course {
    if tester.longest > LATE {
        return broken(format!("the longest took {} ms", tester.longest.as_millis()));
    }
    Ok(())
}
