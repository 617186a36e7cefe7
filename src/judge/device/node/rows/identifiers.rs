//! The identifiers of TPDOs and of SYNC, reserved types, and what a reset takes back.

use super::process_data::{nothing, off, on};
use super::{row, sure};
use crate::can_bus::can::Id;
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::{Abort, NmtState};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::pdo::Way;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::{B, C, U};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Identifiers of TPDOs and SYNC",
    rows: &[
        row(
            "N-Y06",
            "bit 31 of the identifier: no TPDO, and no answer to a remote request",
            "bit 31 = 1 not valid (6)",
            &["N-Y02"],
            By::Trial(y06),
        ),
        row(
            "N-Y07",
            "the identifier of a TPDO that is switched off, changed and switched on is the new one",
            "procedure: set bit 31, change, clear bit 31 (6)",
            &["N-Y02"],
            By::Trial(y07),
        ),
        sure(
            row(
                "N-Y47",
                "the identifier of a TPDO that is on is not changed",
                "while bit 31 = 0 bits 29..0 must not change (08000022h or 06090030h); some devices take it (6)",
                &["N-Y07"],
                By::Trial(y47),
            ),
            U,
        ),
        row(
            "N-Y12",
            "SYNC on a moved identifier acts, the old one does not",
            "SYNC 1005h; SYNC on a moved identifier (7, 14)",
            &["N-Y02"],
            By::Trial(y12),
        ),
        sure(
            row(
                "N-Y54",
                "an octet in a SYNC does not matter without 1019h",
                "a slave takes DLC 0 and ignores the data of longer ones (7); CiA 301 allows EMCY 8240h, and some devices ignore it",
                &["N-Y02"],
                By::Trial(y54),
            ),
            U,
        ),
        sure(
            row(
                "N-Y15",
                "transmission types 241 to 251 are refused",
                "241..251 reserved (6)",
                &["N-Y02"],
                By::Trial(y15),
            ),
            B,
        ),
        sure(
            row(
                "N-Y16",
                "identifiers that are restricted are refused for a TPDO",
                "restricted for free assignment: 000h, 001h..07Fh, 101h..180h, 581h.. (2)",
                &["N-Y07"],
                By::Trial(y16),
            ),
            C,
        ),
        row(
            "N-Y18",
            "SYNC and remote requests with an identifier of 29 bits do nothing",
            "29-bit COB-ID only from extended frames and vice versa (6)",
            &["N-Y02"],
            By::Trial(y18),
        ),
        row(
            "N-Y45",
            "a reset of the communication takes PDO parameters back",
            "82h: objects 1000h..1FFFh to power-on values (3)",
            &["N-K06", "N-Y02"],
            By::Trial(y45),
        ),
    ],
};

fn y06(tester: &mut Tester) -> Course {
    let (pdo, id) = on(tester, 1)?;
    off(tester, &pdo)?;
    tester.enter(NmtState::Operational)?;
    nothing(tester, id, "with bit 31")
}

/// An identifier that no service of the predefined connection set has.
const FREE: u32 = 0x3F0;

fn y07(tester: &mut Tester) -> Course {
    let (pdo, id) = on(tester, 1)?;
    tester.enter(NmtState::PreOperational)?;
    let cob_id = tester.cob_id(&pdo)?;
    let moved = cob_id & !0x1FFF_FFFF | FREE;
    tester.switch_off(&pdo)?;
    if let Err(code) = tester.try_set(pdo.parameters(), 1, &(moved | CobId::INVALID).to_le_bytes())? {
        let why = super::super::sdo::refused(code);
        return broken(format!("another identifier for a TPDO that is off is refused with {why}"));
    }
    tester.set(pdo.parameters(), 1, &moved.to_le_bytes())?;
    tester.enter(NmtState::Operational)?;
    tester.collect(tester.silence())?;
    let new = CobId(FREE).id().unwrap_or(id);
    tester.sync()?;
    let come = tester.collect(tester.silence())?;
    let count = |id: Id| come.iter().filter(|passed| passed.frame.id() == id).count();
    if count(id) > 0 {
        return broken("the TPDO comes with its former identifier");
    }
    if count(new) == 1 {
        Ok(())
    } else {
        broken(format!("{} TPDOs come with the new identifier, expected 1", count(new)))
    }
}

fn y47(tester: &mut Tester) -> Course {
    let (pdo, _) = on(tester, 1)?;
    tester.enter(NmtState::PreOperational)?;
    let moved = tester.cob_id(&pdo)? & !0x1FFF_FFFF | FREE;
    let got = tester.try_set(pdo.parameters(), 1, &moved.to_le_bytes())?;
    let codes = [
        Abort::DEVICE_STATE.code(),
        Abort::RANGE.code(),
        Abort::PARAMETER.code(),
        Abort::LOCAL_CONTROL.code(),
    ];
    tester.must_refuse(got, &codes, "another identifier for a TPDO that is on")?;
    Ok(())
}

fn y54(tester: &mut Tester) -> Course {
    if tester.number_if(0x1019, 0)?.is_some_and(|highest| highest != 0) {
        return inapplicable("1019h is not 0: its SYNC has a counter");
    }
    let (_, id) = on(tester, 1)?;
    let sync = tester.sync_id()?;
    tester.send(sync, &[1])?;
    match tester.come(id, tester.silence())?.len() {
        1 => Ok(()),
        come => broken(format!("{come} TPDOs come after a SYNC with one octet, expected 1")),
    }
}

fn y12(tester: &mut Tester) -> Course {
    let (_, id) = on(tester, 1)?;
    let sync = tester.sync_id()?;
    if !tester.is_writable(0x1005, 0)? {
        return inapplicable("it has no 1005h to write to");
    }
    let moved = Id::base(0x0F8).unwrap_or(sync);
    tester.enter(NmtState::PreOperational)?;
    if tester.try_set(0x1005, 0, &0x0F8_u32.to_le_bytes())?.is_err() {
        return inapplicable("it refuses another identifier in 1005h");
    }
    tester.enter(NmtState::Operational)?;
    tester.collect(tester.silence())?;
    tester.send(sync, &[])?;
    tester.silent_on(id, "SYNC is moved by 1005h, and the old one is sent")?;
    tester.send(moved, &[])?;
    let come = tester.come(id, tester.silence())?.len();
    if come == 1 {
        Ok(())
    } else {
        broken(format!("SYNC is moved by 1005h, and {come} TPDOs come after the new one"))
    }
}

fn y15(tester: &mut Tester) -> Course {
    let pdo = tester.a_pdo(Way::Sent)?;
    tester.switch_off(&pdo)?;
    for kind in [241, 245, 251] {
        let got = tester.try_set(pdo.parameters(), 2, &[kind])?;
        let codes =
            [Abort::RANGE.code(), Abort::TOO_HIGH.code(), Abort::TOO_LOW.code(), Abort::PARAMETER.code()];
        tester.must_refuse(got, &codes, &format!("transmission type {kind}"))?;
    }
    Ok(())
}

fn y16(tester: &mut Tester) -> Course {
    let pdo = tester.a_pdo(Way::Sent)?;
    tester.switch_off(&pdo)?;
    for number in [0x001_u32, 0x101, 0x601, 0x701] {
        let cob_id = CobId::BIT_30 | number;
        let got = tester.try_set(pdo.parameters(), 1, &cob_id.to_le_bytes())?;
        let codes =
            [Abort::RANGE.code(), Abort::PARAMETER.code(), Abort::TOO_LOW.code(), Abort::TOO_HIGH.code()];
        tester.must_refuse(got, &codes, &format!("the identifier {number:03X}h, which is restricted,"))?;
    }
    Ok(())
}

fn y18(tester: &mut Tester) -> Course {
    let (_, id) = on(tester, 1)?;
    let sync = tester.sync_id()?;
    if let Ok(extended) = Id::extended(sync.number()) {
        tester.send(extended, &[])?;
        tester.silent_on(id, "a frame with the identifier of SYNC, of 29 bits, is sent")?;
    }
    if let Ok(extended) = Id::extended(id.number()) {
        tester.request(extended, 8)?;
        tester.silent_on(id, "a remote request of 29 bits is sent")?;
    }
    tester.request(sync, 0)?;
    tester.silent_on(id, "a remote frame with the identifier of SYNC is sent")
}

fn y45(tester: &mut Tester) -> Course {
    let pdo = tester.a_pdo(Way::Sent)?;
    let before = tester.number(pdo.parameters(), 2)?;
    tester.switch_off(&pdo)?;
    let other = if before == 7 { 8 } else { 7 };
    if tester.try_set(pdo.parameters(), 2, &[other])?.is_err() {
        return inapplicable("it refuses another transmission type");
    }
    let self_saving = tester.number_if(0x1010, 1)?.is_some_and(|bits| bits & 2 != 0);
    if self_saving {
        return inapplicable("it stores by itself what is written (1010h:1 bit 1)");
    }
    tester.reset()?;
    let after = tester.number(pdo.parameters(), 2)?;
    if after == before {
        tester.forget_written();
        return Ok(());
    }
    broken(format!(
        "{:04X}h:02 is {after} after a reset of the communication, it was {before}",
        pdo.parameters()
    ))
}
