//! The mapping of a TPDO: how it is changed, and what is refused.

use super::{row, sure};
use crate::can_bus::canopen::{Abort, NmtState};
use crate::judge::device::course::{Course, Halt, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::pdo::{Pdo, Way};
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Mapping",
    rows: &[
        row(
            "N-Y10",
            "a mapping that is changed by the rule has its new length and content",
            "PDO not valid, sub 0 := 0, entries, sub 0 := count (6)",
            &["N-Y02"],
            By::Trial(y10),
        ),
        row(
            "N-Y41",
            "an entry of a mapping is refused: object missing 06020000h, not mappable 06040041h",
            "object missing 06020000h, not mappable or wrong direction 06040041h (6)",
            &["N-O03", "N-Y02"],
            By::Trial(y41),
        ),
        row(
            "N-Y42",
            "a mapping of more than 64 bits is refused: 06040042h",
            "longer than 8 bytes 06040042h (6)",
            &["N-Y10"],
            By::Trial(y42),
        ),
        sure(
            row(
                "N-Y43",
                "an entry of a mapping that is on is not changed",
                "writing an entry while sub 0 != 0: 08000022h (6)",
                &["N-Y10"],
                By::Trial(y43),
            ),
            B,
        ),
    ],
};

/// A TPDO whose mapping can be changed, switched off.
fn changeable(tester: &mut Tester) -> Course<Pdo> {
    let pdo = tester.a_pdo(Way::Sent)?;
    if !tester.is_writable(pdo.mapping(), 0)? || !tester.is_writable(pdo.mapping(), 1)? {
        return inapplicable("its mappings cannot be written");
    }
    tester.switch_off(&pdo)?;
    match tester.try_set(pdo.mapping(), 0, &[0])? {
        Ok(()) => Ok(pdo),
        Err(code) if code == Abort::READ_ONLY.code() => inapplicable("its mappings cannot be written"),
        Err(code) => {
            let why = super::super::sdo::refused(code);
            broken(format!("{:04X}h:00 = 0 of a TPDO that is off is refused with {why}", pdo.mapping()))
        }
    }
}

fn y10(tester: &mut Tester) -> Course {
    let pdo = changeable(tester)?;
    let Some(first) = pdo.entries.first().copied() else { return inapplicable("it maps nothing") };
    tester.set(pdo.mapping(), 1, &first.to_le_bytes())?;
    tester.set(pdo.mapping(), 0, &[1])?;
    let mut fewer = pdo.clone();
    fewer.entries.truncate(1);
    tester.alone(&pdo)?;
    let id = tester.switch_on(&pdo, 1)?;
    tester.enter(NmtState::Operational)?;
    tester.collect(tester.silence())?;
    tester.sync()?;
    let come = tester.come(id, tester.silence())?;
    let expected = fewer.len();
    match come.first().map(|passed| passed.frame.octets().len()) {
        Some(len) if len == expected => Ok(()),
        Some(len) => broken(format!("mapped are {expected} octets, and the TPDO has {len}")),
        None => broken("no TPDO comes after its mapping was changed"),
    }
}

/// An entry must be refused, when it is written or when it is counted.
fn refuses(tester: &mut Tester, pdo: &Pdo, entry: u32, codes: &[Abort], what: &str) -> Course {
    let got = match tester.try_set(pdo.mapping(), 1, &entry.to_le_bytes())? {
        Ok(()) => tester.try_set(pdo.mapping(), 0, &[1])?,
        refused => refused,
    };
    let codes: Vec<u32> = codes.iter().map(|abort| abort.code()).collect();
    let held = tester.must_refuse(got, &codes, what);
    if got.is_ok() {
        tester.set(pdo.mapping(), 0, &[0])?;
    }
    held
}

fn y41(tester: &mut Tester) -> Course {
    let pdo = changeable(tester)?;
    if !tester.has(0x5FFE, 0)? {
        refuses(
            tester,
            &pdo,
            0x5FFE_0008,
            &[Abort::NO_OBJECT, Abort::NOT_MAPPABLE],
            "an entry that maps 5FFEh, which is not there,",
        )?;
    }
    refuses(
        tester,
        &pdo,
        0x1000_0020,
        &[Abort::NOT_MAPPABLE],
        "an entry that maps 1000h, which cannot be mapped,",
    )
}

fn y42(tester: &mut Tester) -> Course {
    let pdo = changeable(tester)?;
    let Some(longest) = pdo.entries.iter().max_by_key(|entry| **entry & 0xFF).copied() else {
        return inapplicable("it maps nothing");
    };
    let bits = longest & 0xFF;
    let needed = u8::try_from(64 / bits.max(1) + 1).unwrap_or(u8::MAX);
    if !tester.has(pdo.mapping(), needed)? {
        return inapplicable("its mapping has too few entries for more than 64 bits");
    }
    for sub in 1..=needed {
        match tester.try_set(pdo.mapping(), sub, &longest.to_le_bytes())? {
            Ok(()) => {}
            Err(code) if code == Abort::PDO_LENGTH.code() => return Ok(()),
            Err(code) => {
                let why = super::super::sdo::refused(code);
                return inapplicable(format!("it refuses to map an entry more than once with {why}"));
            }
        }
    }
    let got = tester.try_set(pdo.mapping(), 0, &[needed])?;
    let held = tester.must_refuse(got, &[Abort::PDO_LENGTH.code()], "a mapping of more than 64 bits");
    if got.is_ok() {
        tester.set(pdo.mapping(), 0, &[0])?;
    }
    held
}

fn y43(tester: &mut Tester) -> Course {
    let pdo = changeable(tester)?;
    let Some(first) = pdo.entries.first().copied() else { return inapplicable("it maps nothing") };
    tester.set(pdo.mapping(), 1, &first.to_le_bytes())?;
    tester.set(pdo.mapping(), 0, &[1])?;
    let got = tester.try_set(pdo.mapping(), 1, &first.to_le_bytes())?;
    let codes = [
        Abort::DEVICE_STATE,
        Abort::NOT_MAPPABLE,
        Abort::PARAMETER,
        Abort::UNSUPPORTED_ACCESS,
        Abort::LOCAL_CONTROL,
    ];
    let codes: Vec<u32> = codes.iter().map(|abort| abort.code()).collect();
    match tester.must_refuse(got, &codes, "an entry of a mapping whose sub-index 0 is 1") {
        // The value is the same, and some devices take it.
        Err(Halt::Broken { why, .. }) => broken(why),
        other => other,
    }
}
