//! The objects of the data sheet.

use super::{row, sure};
use crate::can_bus::canopen::value::ValueKind;
use crate::can_bus::canopen::{Abort, Address};
use crate::explain::hex;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::objects::Listed;
use crate::judge::device::node::sdo::refused;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::{B, U};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Objects of the data sheet",
    rows: &[
        row(
            "N-R04",
            "1000h, 1001h and 1018h:1 are there; 1000h is what the data sheet says",
            "mandatory objects 1000h, 1001h, 1018h (9, eds 4)",
            &["N-O01"],
            By::Trial(r04),
        ),
        row(
            "N-X21",
            "vendor, product and revision of 1018h are those of the data sheet",
            "1018h of the file; blanks from DeviceInfo (eds E-21)",
            &["N-R04"],
            By::Trial(x21),
        ),
        row(
            "N-X09",
            "every entry that can be read answers, with the octets of its type",
            "an SDO read has exactly the octets of the type; > 4 segmented (eds 3)",
            &["N-O01"],
            By::Trial(x09),
        ),
        row(
            "N-X04",
            "every entry has the default of the data sheet: constants always, the others as delivered",
            "each listed object with a default answers an SDO read with the default (eds E-04)",
            &["N-X09"],
            By::Trial(x04),
        ),
        row(
            "N-X12",
            "sub-index 0 of arrays and records is the highest sub-index",
            "sub 0 default = highest sub (9)",
            &["N-X09"],
            By::Trial(x12),
        ),
        row(
            "N-X14",
            "what the data sheet does not list does not answer",
            "index that the file lacks: 06020000h; sub that it lacks: 06090011h (eds E-14)",
            &["N-O03"],
            By::Trial(x14),
        ),
        row(
            "N-X15",
            "every entry that is ro or const refuses a write with 06010002h and keeps its value",
            "ro and const: write 06010002h, value unchanged (eds E-15)",
            &["N-X09"],
            By::Trial(x15),
        ),
        row(
            "N-X16",
            "every entry that is wo refuses a read with 06010001h",
            "wo: read 06010001h (eds E-16)",
            &["N-O01"],
            By::Trial(x16),
        ),
        sure(
            row(
                "N-X17",
                "every entry that is rw takes the value that it holds, and holds it then",
                "rw, rww, rwr: written value is read back (eds E-17)",
                &["N-X09"],
                By::Trial(x17),
            ),
            B,
        ),
        sure(
            row(
                "N-X60",
                "another value within the limits is read back as it was written",
                "rw, rww, rwr: written value is read back, outside the live ones (eds E-17)",
                &["N-X17"],
                By::Trial(x60),
            ),
            U,
        ),
        row(
            "N-X18",
            "a value of another length is refused, and the entry keeps its own",
            "another length than the type's: 06070010h, 12h, 13h, value unchanged (eds E-18)",
            &["N-X17"],
            By::Trial(x18),
        ),
        row(
            "N-X19",
            "a value beyond the limits of the data sheet is refused, and the entry keeps its own",
            "above HighLimit 06090031h, below LowLimit 06090032h (eds E-19)",
            &["N-X17"],
            By::Trial(x19),
        ),
        row(
            "N-X10",
            "texts have no zero at their end, and are those of the data sheet",
            "strings: their own length, no padding, no zero at the end (eds 3)",
            &["N-X09"],
            By::Trial(x10),
        ),
    ],
};

fn a_sheet(tester: &Tester) -> Course {
    if tester.setup.eds.is_some() { Ok(()) } else { inapplicable("needs eds=: the data sheet of the node") }
}

fn r04(tester: &mut Tester) -> Course {
    for (index, sub) in [(0x1000, 0), (0x1001, 0), (0x1018, 1)] {
        tester.value(index, sub)?;
    }
    let device_type = tester.number(0x1000, 0)?;
    let node = tester.node();
    let of_file = tester.setup.eds.as_ref().and_then(|eds| {
        eds.number(0x1000, 0)?;
        Some(crate::judge::device::node::objects::whole(&eds.entry(0x1000, 0)?.octets(node)))
    });
    match of_file {
        Some(expected) if expected != device_type => {
            broken(format!("1000h is {device_type:08X}h, the data sheet says {expected:08X}h"))
        }
        Some(_) | None => Ok(()),
    }
}

fn x21(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    for sub in 1..=3 {
        let of_file = tester.setup.eds.as_ref().and_then(|eds| {
            let info = &eds.device;
            let of_info = [info.vendor_number, info.product_number, info.revision_number];
            let of_entry = eds.number(0x1018, sub).and_then(|number| u64::try_from(number).ok());
            of_entry.or_else(|| of_info.get(usize::from(sub) - 1).copied().flatten().map(u64::from))
        });
        let Some(expected) = of_file else { continue };
        let Some(got) = tester.number_if(0x1018, sub)? else { continue };
        if got != expected {
            return broken(format!("1018h:{sub} is {got:08X}h, the data sheet says {expected:08X}h"));
        }
    }
    Ok(())
}

/// 1003h has so many errors as sub-index 0 says; beyond that there may be no data.
fn may_be_empty(at: Address) -> bool {
    at.index.0 == 0x1003
}

fn x09(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    for listed in tester.some_listed(|listed| listed.entry.rights.is_readable()) {
        let at = listed.at;
        match tester.upload(at)? {
            Ok(octets) => {
                if let Some(size) = listed.size().filter(|size| *size != octets.len()) {
                    let data = listed.entry.data.name();
                    return broken(format!(
                        "{at}, {data}, is read with {} octets, expected {size}",
                        octets.len()
                    ));
                }
            }
            Err(_) if may_be_empty(at) => {}
            // A domain without contents.
            Err(code) if code == Abort::NO_DATA.code() && listed.size().is_none() => {}
            Err(code) => {
                return broken(format!(
                    "a read of {at} ({}) is refused with {}",
                    listed.entry.name,
                    refused(code)
                ));
            }
        }
    }
    Ok(())
}

/// Whether its value is the same in each device as delivered.
fn has_default(listed: &Listed) -> bool {
    use crate::eds::Content;
    let given = match listed.entry.content {
        Content::None => false,
        Content::Whole(_) | Content::Real(_) | Content::Octets(_) => true,
    };
    let of_unit = listed.at == Address::new(0x1018, 4);
    given && listed.entry.rights.is_readable() && !of_unit && !may_be_empty(listed.at)
}

fn x04(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    let node = tester.node();
    let as_delivered = match tester.act("new-device") {
        Ok(_) => {
            tester.boot_up("the action new-device")?;
            tester.collect(tester.moment())?;
            true
        }
        Err(crate::judge::device::course::Halt::Inapplicable(_)) => false,
        Err(other) => return Err(other),
    };
    let constant = |listed: &Listed| listed.entry.rights == crate::eds::Rights::Const;
    // What only can be read may be a measured value.
    let chosen = |listed: &Listed| constant(listed) || as_delivered && listed.entry.rights.is_writable();
    let listed: Vec<Listed> = tester.some_listed(chosen);
    for listed in listed.into_iter().filter(has_default) {
        let expected = listed.entry.octets(node);
        let got = tester.value(listed.at.index.0, listed.at.sub.0)?;
        // An object of the device may hold the number that it was given.
        let is_number = listed.is_application() && got == [node.number()];
        if got != expected && !is_number {
            return broken(format!(
                "{} ({}) is {}, the data sheet says {}",
                listed.at,
                listed.entry.name,
                hex(&got),
                hex(&expected)
            ));
        }
    }
    Ok(())
}

fn x12(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    let node = tester.node();
    let listed = tester.listed();
    for first in listed.iter().filter(|listed| listed.at.sub.0 == 0) {
        let index = first.at.index;
        let highest = listed.iter().filter(|other| other.at.index == index).map(|other| other.at.sub.0).max();
        let fixed = first.entry.data == crate::can_bus::canopen::value::DataType::U8
            && !first.entry.rights.is_writable();
        // Files may say another number than that of their sections.
        let of_file = first.entry.octets(node).first().copied();
        let Some(highest) = highest.filter(|highest| *highest > 0 && fixed && of_file == Some(*highest))
        else {
            continue;
        };
        if may_be_empty(first.at) {
            continue;
        }
        let got = tester.number(index.0, 0)?;
        if got != u64::from(highest) {
            return broken(format!("{} is {got}, and the highest sub-index is {highest}", first.at));
        }
    }
    Ok(())
}

fn x14(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    let Some(eds) = tester.setup.eds.clone() else { return Ok(()) };
    let near = eds.objects.keys().map(|index| index.saturating_add(1));
    let known = [0x1002, 0x1005, 0x1006, 0x1008, 0x100C, 0x1010, 0x1014, 0x1016, 0x1017, 0x1029, 0x1200];
    let known = known.into_iter().chain([0x1400, 0x1600, 0x1800, 0x1A00, 0x2000, 0x6000, 0x6040, 0x6041]);
    let most = if tester.setup.quick { 30 } else { 300 };
    let missing = known.chain(near).filter(|index| !eds.objects.contains_key(index) && *index >= 0x1000);
    for index in missing.take(most) {
        let got = tester.upload(Address::new(index, 0))?.map(drop);
        tester.must_refuse(
            got,
            &[Abort::NO_OBJECT.code()],
            &format!("a read of {index:04X}h, which the data sheet lacks,"),
        )?;
    }
    for (index, object) in eds.objects.iter().filter(|(index, _)| **index >= 0x1000).take(most) {
        let Some(sub) = object.entries.keys().max().and_then(|sub| sub.checked_add(1)) else { continue };
        if sub == u8::MAX || object.refuses_scan {
            continue;
        }
        let got = tester.upload(Address::new(*index, sub))?.map(drop);
        let codes = [Abort::NO_SUB.code()];
        tester.must_refuse(
            got,
            &codes,
            &format!("a read of {index:04X}h:{sub:02X}, which the data sheet lacks,"),
        )?;
    }
    Ok(())
}

fn x15(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    tester.may_write()?;
    for listed in tester.some_listed(|listed| !listed.entry.rights.is_writable()) {
        let at = listed.at;
        let Ok(before) = tester.upload(at)? else { continue };
        if before.is_empty() {
            continue;
        }
        let got = tester.download(at, &before)?;
        tester.must_refuse(
            got,
            &[Abort::READ_ONLY.code()],
            &format!("a write of {at} ({}), which is ro,", listed.entry.name),
        )?;
    }
    Ok(())
}

fn x16(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    let listed = tester.some_listed(|listed| !listed.entry.rights.is_readable());
    if listed.is_empty() {
        return inapplicable("the data sheet has no entry that is wo");
    }
    for listed in listed {
        let at = listed.at;
        let got = tester.upload(at)?.map(drop);
        tester.must_refuse(
            got,
            &[Abort::WRITE_ONLY.code()],
            &format!("a read of {at} ({}), which is wo,", listed.entry.name),
        )?;
    }
    Ok(())
}

/// Entries of the application that may be written: process data only where something may move.
fn own_values(tester: &Tester) -> Vec<Listed> {
    let moves = tester.setup.moves_allowed;
    tester.some_listed(|listed| {
        let readable = listed.entry.rights.is_readable() && listed.entry.rights.is_writable();
        readable && listed.is_application() && (moves || !listed.is_process_data())
    })
}

/// What a device may say to a value for reasons of its own.
fn is_of_its_own(code: u32) -> bool {
    let allowed = [
        Abort::RANGE,
        Abort::TOO_HIGH,
        Abort::TOO_LOW,
        Abort::PARAMETER,
        Abort::INTERNAL,
        Abort::RESOURCE,
        Abort::GENERAL,
        Abort::TRANSFER,
        Abort::LOCAL_CONTROL,
        Abort::DEVICE_STATE,
    ];
    allowed.iter().any(|abort| abort.code() == code)
}

fn x17(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    tester.may_write()?;
    for listed in own_values(tester) {
        let at = listed.at;
        let Ok(before) = tester.upload(at)? else { continue };
        if before.is_empty() {
            continue;
        }
        match tester.download(at, &before)? {
            Ok(()) => super::sdo::unchanged(tester, at, &before, "a write of the value that it holds")?,
            Err(code) if is_of_its_own(code) => {}
            Err(code) => {
                let name = &listed.entry.name;
                return broken(format!(
                    "a write of {at} ({name}), which is rw, is refused with {}",
                    refused(code)
                ));
            }
        }
    }
    Ok(())
}

fn x60(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    tester.may_write()?;
    let node = tester.node();
    for listed in own_values(tester).into_iter().filter(Listed::is_whole) {
        let at = listed.at;
        let Ok(before) = tester.upload(at)? else { continue };
        let (low, high) = listed.limits(node);
        let number = listed.number_of(&before);
        let within =
            |number: &i128| low.is_none_or(|low| *number >= low) && high.is_none_or(|high| *number <= high);
        let other =
            [number + 1, number - 1].into_iter().filter(within).find_map(|number| listed.octets_of(number));
        let Some(other) = other else { continue };
        // What cannot be written back is not touched.
        if tester.download(at, &before)?.is_err() {
            continue;
        }
        if tester.try_set(at.index.0, at.sub.0, &other)?.is_err() {
            continue;
        }
        let got = tester.value(at.index.0, at.sub.0)?;
        if got != other {
            return broken(format!(
                "{at} ({}) is {}, written was {}",
                listed.entry.name,
                hex(&got),
                hex(&other)
            ));
        }
    }
    Ok(())
}

fn x18(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    tester.may_write()?;
    for listed in own_values(tester) {
        let at = listed.at;
        let Some(size) = listed.size().filter(|size| *size <= 4) else { continue };
        let Ok(before) = tester.upload(at)? else { continue };
        for len in [size - 1, size + 1].into_iter().filter(|len| (1..=4).contains(len)) {
            let octets: Vec<u8> = before.iter().copied().chain([0]).take(len).collect();
            let what = format!("a write of {len} octets to {at}, which has {size},");
            let got = tester.download(at, &octets)?;
            if let Err(code) = got
                && (code == Abort::DEVICE_STATE.code() || code == Abort::LOCAL_CONTROL.code())
            {
                continue;
            }
            let back = got.is_ok();
            let held = tester.must_refuse(got, &super::sdo::WRONG_LENGTH, &what);
            if back {
                let _ = tester.download(at, &before)?;
            }
            held?;
            super::sdo::unchanged(tester, at, &before, &what)?;
        }
    }
    Ok(())
}

fn x19(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    tester.may_write()?;
    let node = tester.node();
    let mut tried = 0;
    for listed in own_values(tester).into_iter().filter(Listed::is_whole) {
        let at = listed.at;
        let (low, high) = listed.limits(node);
        let above = high.and_then(|high| listed.octets_of(high + 1)).map(|octets| (octets, Abort::TOO_HIGH));
        let below = low.and_then(|low| listed.octets_of(low - 1)).map(|octets| (octets, Abort::TOO_LOW));
        for (octets, abort) in above.into_iter().chain(below) {
            let Ok(before) = tester.upload(at)? else { continue };
            tried += 1;
            let what = format!(
                "a write of {} to {at} ({}), which is beyond its limits,",
                hex(&octets),
                listed.entry.name
            );
            let got = tester.download(at, &octets)?;
            if let Err(code) = got
                && (code == Abort::DEVICE_STATE.code() || code == Abort::LOCAL_CONTROL.code())
            {
                continue;
            }
            let back = got.is_ok();
            let held =
                tester.must_refuse(got, &[abort.code(), Abort::RANGE.code(), Abort::PARAMETER.code()], &what);
            if back {
                let _ = tester.download(at, &before)?;
            }
            held?;
            super::sdo::unchanged(tester, at, &before, &what)?;
        }
    }
    if tried == 0 {
        inapplicable("no entry that may be written has limits in the data sheet")
    } else {
        Ok(())
    }
}

fn x10(tester: &mut Tester) -> Course {
    a_sheet(tester)?;
    let node = tester.node();
    for listed in tester.some_listed(|listed| listed.entry.data.kind() == ValueKind::Text) {
        let at = listed.at;
        let Ok(octets) = tester.upload(at)? else { continue };
        if octets.contains(&0) {
            return broken(format!("{at} ({}) has a zero: {}", listed.entry.name, hex(&octets)));
        }
        let expected = listed.entry.octets(node);
        let fixed = !listed.entry.rights.is_writable() && !expected.is_empty();
        if fixed && expected != octets {
            let text = |octets: &[u8]| String::from_utf8_lossy(octets).into_owned();
            return broken(format!(
                "{at} is \"{}\", the data sheet says \"{}\"",
                text(&octets),
                text(&expected)
            ));
        }
    }
    Ok(())
}
