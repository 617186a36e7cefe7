//! SDO in segments and in blocks.

use super::{row, sure};
use crate::can_bus::canopen::sdo::block::{SEGMENT_LEN, crc_16};
use crate::can_bus::canopen::{Abort, Address};
use crate::explain::hex;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::objects::is_text;
use crate::judge::device::node::sdo::{abort_of, address_of, addressed, expedited, refused, segment};
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "SDO in segments and blocks",
    rows: &[
        row(
            "N-O08",
            "a read in segments: length, toggle bit, last segment, unused octets 0",
            "0x/1x: 000 t nnn c, t alternates from 0, nnn = unused bytes, c = 1 last (5)",
            &["N-O01"],
            By::Trial(o08),
        ),
        row(
            "N-O09",
            "a wrong toggle bit: 05030000h, the transfer is over, the next request is served",
            "a wrong toggle: abort 05030000h and the transfer is over (5)",
            &["N-O08"],
            By::Trial(o09),
        ),
        row(
            "N-O11",
            "a new request within a transfer is served, and the old transfer is over",
            "a new initiate during a transfer aborts the old one silently and starts the new one (5)",
            &["N-O08"],
            By::Trial(o11),
        ),
        row(
            "N-O17",
            "a read in blocks, where it is offered, gives the same octets and the right checksum",
            "block upload: segments numbered from 1, CRC x^16 + x^12 + x^5 + 1 (5)",
            &["N-O08"],
            By::Trial(o17),
        ),
        row(
            "N-O22",
            "a write in segments is taken: 60, then 20 and 30 in turn",
            "21h initiate download; segment answer 001 t 0000 (5)",
            &["N-O08"],
            By::Trial(o22),
        ),
        row(
            "N-O23",
            "a wrong toggle bit in a write: 05030000h, and nothing is written",
            "a wrong toggle: abort 05030000h and the transfer is over (5)",
            &["N-O22"],
            By::Trial(o23),
        ),
        row(
            "N-O18",
            "a write in blocks, where it is offered, is taken; with a wrong checksum it is refused",
            "05040004h CRC error (5)",
            &["N-O22"],
            By::Trial(o18),
        ),
        row(
            "N-O25",
            "a write in blocks of which a segment is lost: the node says which was the last one, and takes the rest again",
            "block download: A2, the last segment in order; the client goes on behind it (5)",
            &["N-O18"],
            By::Trial(o25),
        ),
        row(
            "N-O26",
            "a read in blocks of which the client takes fewer segments goes on behind the last one taken",
            "block upload: A2, the last segment in order; the server goes on behind it (5)",
            &["N-O17"],
            By::Trial(o26),
        ),
        sure(
            row(
                "N-O24",
                "a write in segments that is longer than it announced, or than the object, is refused",
                "longer than the object 06070012h (5)",
                &["N-O22"],
                By::Trial(o24),
            ),
            B,
        ),
    ],
};

/// A value with more octets takes its time in blocks of one segment.
const FEW: u32 = 1000;

/// An entry that is read in segments, if there is one: more than four octets, and not too many if that can be.
pub(super) fn long_one(tester: &mut Tester) -> Course<Option<Address>> {
    let mut candidates: Vec<Address> = [0x1008, 0x1009, 0x100A].map(|index| Address::new(index, 0)).to_vec();
    let longer =
        |listed: &crate::judge::device::node::objects::Listed| listed.size().is_none_or(|size| size > 4);
    candidates.extend(tester.listed().into_iter().filter(longer).map(|listed| listed.at).take(10));
    let mut longest = None;
    for at in candidates {
        if !tester.has(at.index.0, at.sub.0)? {
            continue;
        }
        let answer = tester.asked(addressed(0x40, at, [0; 4]), &format!("a read of {at}"))?;
        if abort_of(answer).is_some() || expedited(answer).is_some() {
            continue;
        }
        abort(tester, at)?;
        // A text without octets has no other way, and shows nothing.
        let [command, _, _, _, announced @ ..] = answer;
        match (command & 1, u32::from_le_bytes(announced)) {
            (1, 0) => {}
            (1, FEW..) => longest = longest.or(Some(at)),
            (_, _) => return Ok(Some(at)),
        }
    }
    Ok(longest)
}

fn abort(tester: &mut Tester, at: Address) -> Course {
    let id = tester.id(crate::can_bus::canopen::cob_id::SDO_CLIENT);
    tester.send(id, &addressed(0x80, at, Abort::GENERAL.code().to_le_bytes()))
}

/// Begins to read it.
pub(super) fn begin(tester: &mut Tester, at: Address) -> Course<[u8; 8]> {
    let answer = tester.asked(addressed(0x40, at, [0; 4]), &format!("a read of {at}"))?;
    if answer.first().is_some_and(|command| command & 0xE2 == 0x40) && address_of(answer) == at {
        return Ok(answer);
    }
    broken(format!("a read of {at} is answered with {}", hex(&answer)))
}

fn a_long_one(tester: &mut Tester) -> Course<Address> {
    match long_one(tester)? {
        Some(at) => Ok(at),
        None => inapplicable("it has no object that is read in segments"),
    }
}

fn o08(tester: &mut Tester) -> Course {
    let at = a_long_one(tester)?;
    match tester.upload(at)? {
        Ok(octets) if octets.len() <= 4 => {
            broken(format!("{at} has {} octets and is read in segments", octets.len()))
        }
        Ok(_) => Ok(()),
        Err(code) => broken(format!("a read of {at} in segments is refused with {}", refused(code))),
    }
}

fn o09(tester: &mut Tester) -> Course {
    let at = a_long_one(tester)?;
    begin(tester, at)?;
    let answer = tester.asked([0x70, 0, 0, 0, 0, 0, 0, 0], "a segment request with a wrong toggle bit")?;
    let code = abort_of(answer);
    if code != Some(Abort::TOGGLE.code()) {
        return broken(format!(
            "a segment request with a wrong toggle bit is answered with {}",
            hex(&answer)
        ));
    }
    let answer = tester.asked([0x60, 0, 0, 0, 0, 0, 0, 0], "a segment request after an abort")?;
    if abort_of(answer).is_none() {
        return broken("a transfer goes on after a wrong toggle bit");
    }
    tester.value(at.index.0, at.sub.0).map(drop)
}

fn o11(tester: &mut Tester) -> Course {
    let at = a_long_one(tester)?;
    begin(tester, at)?;
    let read = addressed(0x40, Address::new(0x1000, 0), [0; 4]);
    let answer = tester.asked(read, "a new request within a transfer")?;
    if expedited(answer).is_none() {
        return broken(format!("a new request within a transfer is answered with {}", hex(&answer)));
    }
    let answer = tester.asked([0x60, 0, 0, 0, 0, 0, 0, 0], "a segment request of the transfer before")?;
    if abort_of(answer).is_none() {
        return broken("the old transfer goes on after a new request");
    }
    Ok(())
}

fn o17(tester: &mut Tester) -> Course {
    let at = a_long_one(tester)?;
    let expected = tester.value(at.index.0, at.sub.0)?;
    for size in [127, 1, 3] {
        match tester.upload_in_blocks(at, size)? {
            None => return inapplicable("it reads nothing in blocks"),
            Some(octets) if octets == expected => {}
            Some(octets) => {
                return broken(format!(
                    "{at} read in blocks of {size} is {}, in segments {}",
                    hex(&octets),
                    hex(&expected)
                ));
            }
        }
    }
    tester.value(at.index.0, at.sub.0).map(drop)
}

/// An entry that can be written with more than four octets, what it holds, and other octets of the same length.
fn a_long_writable(tester: &mut Tester) -> Course<(Address, Vec<u8>, Vec<u8>)> {
    tester.may_write()?;
    let wanted = |listed: &crate::judge::device::node::objects::Listed| {
        let fits = match listed.size() {
            Some(size) => size > 4 && listed.entry.low.is_none() && listed.entry.high.is_none(),
            None => is_text(listed.entry.data),
        };
        fits && listed.entry.rights.is_writable() && listed.is_application() && !listed.is_process_data()
    };
    for listed in tester.listed().into_iter().filter(wanted) {
        if let Ok(before) = tester.upload(listed.at)? {
            let len = listed.size().unwrap_or_else(|| before.len().max(20));
            let other = (b'A'..=b'Z').cycle().take(len).collect();
            return Ok((listed.at, before, other));
        }
    }
    inapplicable("it has no object of more than four octets that can be written, or --node has no eds=")
}

/// Writes back what was there.
fn restore(tester: &mut Tester, at: Address, before: &[u8]) -> Course {
    let back = tester.download_in_segments(at, before)?;
    match back {
        Ok(()) => Ok(()),
        Err(code) => broken(format!("{at} cannot be given its former value: {}", refused(code))),
    }
}

fn o22(tester: &mut Tester) -> Course {
    let (at, before, other) = a_long_writable(tester)?;
    if let Err(code) = tester.download_in_segments(at, &other)? {
        return broken(format!("a write of {at} in segments is refused with {}", refused(code)));
    }
    let read = tester.value(at.index.0, at.sub.0)?;
    restore(tester, at, &before)?;
    if read == other {
        Ok(())
    } else {
        broken(format!("{at} is {}, written was {}", hex(&read), hex(&other)))
    }
}

fn o23(tester: &mut Tester) -> Course {
    let (at, before, other) = a_long_writable(tester)?;
    let len = u32::try_from(other.len()).unwrap_or_default();
    tester.asked(addressed(0x21, at, len.to_le_bytes()), "a write in segments")?;
    let first = other.get(..7.min(other.len())).unwrap_or_default();
    let answer = tester
        .asked(segment(0x10, first, first.len() == other.len()), "a segment with a wrong toggle bit")?;
    let code = abort_of(answer);
    if code != Some(Abort::TOGGLE.code()) {
        let _ = tester.download_in_segments(at, &before)?;
        return broken(format!("a segment with a wrong toggle bit is answered with {}", hex(&answer)));
    }
    super::sdo::unchanged(tester, at, &before, "a write with a wrong toggle bit")
}

fn o18(tester: &mut Tester) -> Course {
    let (at, before, other) = a_long_writable(tester)?;
    match tester.download_in_blocks(at, &other, crc_16(0, &other))? {
        None => return inapplicable("it takes nothing in blocks"),
        Some(Err(code)) => return broken(format!("a block write of {at} is refused with {}", refused(code))),
        Some(Ok(())) => {}
    }
    let read = tester.value(at.index.0, at.sub.0)?;
    restore(tester, at, &before)?;
    if read != other {
        return broken(format!("{at} is {}, written in blocks was {}", hex(&read), hex(&other)));
    }
    let got = tester.download_in_blocks(at, &other, crc_16(0, &other) ^ 1)?;
    match got {
        Some(Err(code)) if code == Abort::CRC.code() => {
            super::sdo::unchanged(tester, at, &before, "a block write with a wrong checksum")
        }
        Some(Err(code)) => {
            broken(format!("a wrong checksum is refused with {}, expected 05040004h", refused(code)))
        }
        Some(Ok(())) | None => {
            restore(tester, at, &before)?;
            // A server that says that it has no checksum looks at none.
            broken("a block write with a wrong checksum is taken")
        }
    }
}

fn o25(tester: &mut Tester) -> Course {
    let (at, before, other) = a_long_writable(tester)?;
    if other.len() <= 2 * SEGMENT_LEN {
        return inapplicable("the value that it can be written has less than three segments");
    }
    tester.lose_segment = true;
    let done = tester.download_in_blocks(at, &other, crc_16(0, &other));
    tester.lose_segment = false;
    match done? {
        None => return inapplicable("it takes nothing in blocks"),
        Some(Err(code)) => {
            return broken(format!(
                "a block write of {at} with a lost segment is refused with {}",
                refused(code)
            ));
        }
        Some(Ok(())) => {}
    }
    let read = tester.value(at.index.0, at.sub.0)?;
    restore(tester, at, &before)?;
    if read == other {
        Ok(())
    } else {
        broken(format!("{at} is {}, written in blocks with a lost segment was {}", hex(&read), hex(&other)))
    }
}

fn o26(tester: &mut Tester) -> Course {
    let at = a_long_one(tester)?;
    let expected = tester.value(at.index.0, at.sub.0)?;
    if expected.len() <= SEGMENT_LEN {
        return inapplicable("its longest value is one segment");
    }
    tester.lose_segment = true;
    let read = tester.upload_in_blocks(at, 127);
    tester.lose_segment = false;
    match read? {
        None => inapplicable("it reads nothing in blocks"),
        Some(octets) if octets == expected => Ok(()),
        Some(octets) => broken(format!(
            "{at} read in blocks with a segment twice is {}, expected {}",
            hex(&octets),
            hex(&expected)
        )),
    }
}

fn o24(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1017, 0)? {
        return inapplicable("it has no 1017h to write to");
    }
    let at = Address::new(0x1017, 0);
    let before = tester.value(0x1017, 0)?;
    let answer = tester.asked(addressed(0x21, at, 2_u32.to_le_bytes()), "a write of 1017h in segments")?;
    if abort_of(answer).is_some() {
        return inapplicable("it takes no short value in segments");
    }
    let answer = tester.asked(segment(0, &[0; 7], true), "a segment that is longer than was announced")?;
    if abort_of(answer).is_none() {
        let _ = tester.download(at, &before)?;
        return broken("seven octets for an object of two are taken in segments");
    }
    super::sdo::unchanged(tester, at, &before, "a write of seven octets in segments")
}
