//! Rows about TPDOs: transmission types, SYNC, remote requests, timers.

use core::time::Duration;

use super::{row, sure};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::NmtState;
use crate::can_bus::canopen::cob_id::CobId;
use crate::explain::hex;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::pdo::{Pdo, Way};
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::U;

pub(super) const GROUP: Group<Tester> = Group {
    title: "TPDOs, SYNC",
    rows: &[
        row(
            "N-Y02",
            "type 1: one TPDO after each SYNC, with the length of its mapping and the values that SDO shows",
            "1..240: after every n-th SYNC (6)",
            &["N-O01"],
            By::Trial(y02),
        ),
        row(
            "N-Y22",
            "type n: one TPDO after every n-th SYNC",
            "1..240: after every n-th SYNC (6)",
            &["N-Y02"],
            By::Trial(y22),
        ),
        row(
            "N-Y01",
            "outside OPERATIONAL: no TPDO, neither after SYNC nor at a remote request",
            "only in OPERATIONAL and only if bit 31 = 0 (6)",
            &["N-K02", "N-Y02"],
            By::Trial(y01),
        ),
        row(
            "N-Y03",
            "bit 30 of the identifier: a remote request is not answered",
            "bit 30 = 1 no RTR (6)",
            &["N-Y02"],
            By::Trial(y03),
        ),
        sure(
            row(
                "N-Y33",
                "without bit 30 a remote request is answered once",
                "bit 30 = 1 no RTR; some devices answer none (6)",
                &["N-Y02"],
                By::Trial(y33),
            ),
            U,
        ),
        row(
            "N-Y04",
            "types 252 and 253: no TPDO but at a remote request",
            "252 RTR only, data sampled at SYNC; 253 RTR only (6)",
            &["N-Y02"],
            By::Trial(y04),
        ),
        row(
            "N-Y05",
            "event timer: a TPDO every so many ms, within 10 %",
            "event timer: longest distance; every transmission restarts it (6)",
            &["N-Y02"],
            By::Trial(y05),
        ),
        row(
            "N-Y25",
            "inhibit time: TPDOs of changes are never closer",
            "least distance between two transmissions of one event-driven TPDO (6)",
            &["N-Y26"],
            By::Trial(y25),
        ),
        row(
            "N-Y26",
            "types 254 and 255: a TPDO on a change of a mapped entry, and none without",
            "254, 255: event (6)",
            &["N-Y02"],
            By::Trial(y26),
        ),
        sure(
            row(
                "N-Y13",
                "type 0: no TPDO after a SYNC without a change",
                "0: after a SYNC if an event happened since the last one (6; doubt 301)",
                &["N-Y02"],
                By::Trial(y13),
            ),
            U,
        ),
        sure(
            row(
                "N-Y17",
                "entering OPERATIONAL sends TPDOs of type 254 or 255 once",
                "entering OPERATIONAL sends event-driven TPDOs once (6; doubt 302)",
                &["N-K02", "N-Y26"],
                By::Trial(y17),
            ),
            U,
        ),
    ],
};

/// A TPDO of this type that is on, alone, in OPERATIONAL.
pub(super) fn on(tester: &mut Tester, kind: u8) -> Course<(Pdo, Id)> {
    let pdo = tester.a_pdo(Way::Sent)?;
    tester.alone(&pdo)?;
    quiet_timers(tester, &pdo)?;
    let id = tester.switch_on(&pdo, kind)?;
    tester.enter(NmtState::Operational)?;
    tester.collect(tester.silence())?;
    Ok((pdo, id))
}

/// No event timer of its own.
fn quiet_timers(tester: &mut Tester, pdo: &Pdo) -> Course {
    let parameters = pdo.parameters();
    if tester.is_writable(parameters, 5)? && tester.number_if(parameters, 5)?.is_some_and(|timer| timer != 0)
    {
        tester.switch_off(pdo)?;
        tester.set(parameters, 5, &[0, 0])?;
    }
    Ok(())
}

/// So many TPDOs come after a SYNC.
fn after_sync(tester: &mut Tester, id: Id) -> Course<Vec<Frame>> {
    tester.sync()?;
    let come = tester.come(id, tester.silence())?;
    Ok(come.into_iter().map(|passed| passed.frame).collect())
}

fn y02(tester: &mut Tester) -> Course {
    let (pdo, id) = on(tester, 1)?;
    for number in 1..=5 {
        let come = after_sync(tester, id)?;
        let [frame] = come.as_slice() else {
            return broken(format!("{} TPDOs come after SYNC {number}, expected 1", come.len()));
        };
        if frame.octets().len() != pdo.len() {
            return broken(format!("{frame} has {} octets, mapped are {}", frame.octets().len(), pdo.len()));
        }
    }
    let before = tester.shown_by_sdo(&pdo)?;
    let come = after_sync(tester, id)?;
    let after = tester.shown_by_sdo(&pdo)?;
    let Some(frame) = come.first() else { return broken("no TPDO after a SYNC") };
    match before {
        // What changes by itself cannot be compared.
        Some(before) if after.as_ref() == Some(&before) && frame.octets() != before => {
            broken(format!("the TPDO is {}, SDO shows {}", hex(frame.octets()), hex(&before)))
        }
        Some(_) | None => Ok(()),
    }
}

fn y22(tester: &mut Tester) -> Course {
    let counts: &[u8] = if tester.setup.quick { &[3] } else { &[2, 3, 10] };
    for count in counts {
        let (_, id) = on(tester, *count)?;
        // It may begin to count where it likes.
        for _ in 0..*count {
            if !after_sync(tester, id)?.is_empty() {
                break;
            }
        }
        for round in 1..=2 {
            for number in 1..=*count {
                let come = after_sync(tester, id)?.len();
                let expected = usize::from(number == *count);
                if come != expected {
                    return broken(format!(
                        "type {count}: {come} TPDOs after SYNC {number} of round {round}, expected {expected}"
                    ));
                }
            }
        }
        tester.enter(NmtState::PreOperational)?;
    }
    if tester.setup.quick { Ok(()) } else { every_240th(tester) }
}

/// So many SYNCs that not each can be waited for: only how many TPDOs come is judged.
fn every_240th(tester: &mut Tester) -> Course {
    let (_, id) = on(tester, 240)?;
    let sync = tester.sync_id()?;
    let mut come = 0;
    for _ in 0..480 {
        tester.send(sync, &[])?;
        come += tester.come(id, Duration::from_millis(2))?.len();
    }
    come += tester.come(id, tester.silence())?.len();
    if come == 2 {
        Ok(())
    } else {
        broken(format!("type 240: {come} TPDOs come after 480 SYNCs, expected 2"))
    }
}

/// Switches it off, in PRE-OPERATIONAL: some nodes allow it there only.
pub(super) fn off(tester: &mut Tester, pdo: &Pdo) -> Course {
    tester.enter(NmtState::PreOperational)?;
    tester.switch_off(pdo)
}

pub(super) fn nothing(tester: &mut Tester, id: Id, when: &str) -> Course {
    if let Some(frame) = after_sync(tester, id)?.first() {
        return broken(format!("{when} {frame} comes after a SYNC"));
    }
    tester.request(id, 8)?;
    if let Some(passed) = tester.come(id, tester.silence())?.first() {
        return broken(format!("{when} {} answers a remote request", passed.frame));
    }
    Ok(())
}

fn y01(tester: &mut Tester) -> Course {
    let (_, id) = on(tester, 1)?;
    tester.enter(NmtState::PreOperational)?;
    nothing(tester, id, "in PRE-OPERATIONAL")?;
    let sync = tester.sync_id()?;
    tester.enter(NmtState::Stopped)?;
    tester.send(sync, &[])?;
    tester.silent_on(id, "a SYNC comes in STOPPED")?;
    tester.enter(NmtState::PreOperational)
}

/// How many TPDOs answer a remote request, with bit 30 so.
fn answers(tester: &mut Tester, bit_30: bool) -> Course<usize> {
    let (pdo, id) = on(tester, 1)?;
    let cob_id = tester.cob_id(&pdo)?;
    let wanted = if bit_30 { cob_id | CobId::BIT_30 } else { cob_id & !CobId::BIT_30 };
    if wanted != cob_id {
        off(tester, &pdo)?;
        if let Err(code) = tester.try_set(pdo.parameters(), 1, &wanted.to_le_bytes())? {
            let why = super::super::sdo::refused(code);
            return inapplicable(format!(
                "{:04X}h:01 = {wanted:08X}h is refused with {why}",
                pdo.parameters()
            ));
        }
        tester.enter(NmtState::Operational)?;
        tester.collect(tester.silence())?;
    }
    tester.request(id, u8::try_from(pdo.len()).unwrap_or(8))?;
    Ok(tester.come(id, tester.silence())?.len())
}

fn y03(tester: &mut Tester) -> Course {
    match answers(tester, true)? {
        0 => Ok(()),
        count => broken(format!("bit 30 is set, and {count} TPDOs answer a remote request")),
    }
}

fn y33(tester: &mut Tester) -> Course {
    match answers(tester, false)? {
        1 => Ok(()),
        count => broken(format!("bit 30 is 0, and {count} TPDOs answer a remote request, expected 1")),
    }
}

fn y04(tester: &mut Tester) -> Course {
    let mut tried = 0;
    for kind in [252, 253] {
        let (pdo, id) = match on(tester, kind) {
            Ok(on) => on,
            Err(crate::judge::device::course::Halt::Inapplicable(_)) => continue,
            Err(halt) => return Err(halt),
        };
        tried += 1;
        if !after_sync(tester, id)?.is_empty() {
            return broken(format!("type {kind}: a TPDO comes after a SYNC"));
        }
        if !CobId(tester.cob_id(&pdo)?).bit_30() {
            tester.request(id, u8::try_from(pdo.len()).unwrap_or(8))?;
            let come = tester.come(id, tester.silence())?.len();
            if come != 1 {
                return broken(format!("type {kind}: {come} TPDOs answer a remote request, expected 1"));
            }
        }
        tester.enter(NmtState::PreOperational)?;
    }
    if tried == 0 { inapplicable("it refuses the types 252 and 253") } else { Ok(()) }
}

/// A TPDO of type 255 or 254 that is off, alone.
fn event_driven(tester: &mut Tester, timer: u16, inhibit: u16) -> Course<(Pdo, Id)> {
    let pdo = tester.a_pdo(Way::Sent)?;
    tester.alone(&pdo)?;
    tester.switch_off(&pdo)?;
    for (sub, value) in [(5, timer), (3, inhibit)] {
        if tester.is_writable(pdo.parameters(), sub)? {
            tester.set(pdo.parameters(), sub, &value.to_le_bytes())?;
        } else if value != 0 {
            return inapplicable(format!("{:04X}h:{sub} cannot be written", pdo.parameters()));
        }
    }
    let id = match tester.switch_on(&pdo, 255) {
        Ok(id) => id,
        Err(crate::judge::device::course::Halt::Inapplicable(_)) => tester.switch_on(&pdo, 254)?,
        Err(halt) => return Err(halt),
    };
    tester.enter(NmtState::Operational)?;
    Ok((pdo, id))
}

fn y05(tester: &mut Tester) -> Course {
    let period = tester.supervision();
    let ms = u16::try_from(period.as_millis()).unwrap_or(100);
    let (_, id) = event_driven(tester, ms, 0)?;
    let margin = period / 10 + tester.wire.latency;
    tester.collect(period * 2)?;
    let count = if tester.setup.quick { 6 } else { 11 };
    let come = tester.come(id, period * count)?;
    for pair in come.windows(2) {
        if let [one, next] = pair {
            let apart = next.at.saturating_since(one.at);
            if apart > period + margin {
                return broken(format!(
                    "the event timer is {ms} ms, and TPDOs are {} ms apart",
                    apart.as_millis()
                ));
            }
        }
    }
    // A change may send one between, and restart the timer.
    let number = u32::try_from(come.len()).unwrap_or(u32::MAX);
    if (count - 2..=count + 3).contains(&number) {
        return Ok(());
    }
    broken(format!("the event timer is {ms} ms, and {number} TPDOs come in {} ms", count * u32::from(ms)))
}

/// Changes a mapped entry; false: there is none that can be changed.
fn change(tester: &mut Tester, pdo: &Pdo) -> Course<bool> {
    for (at, _) in pdo.places().unwrap_or_default() {
        let writable = at.index.0 >= 0x2000 && tester.is_writable(at.index.0, at.sub.0)?;
        if !writable {
            continue;
        }
        let Ok(mut octets) = tester.upload(at)? else { continue };
        if let Some(low) = octets.first_mut() {
            *low ^= 1;
        }
        if tester.try_set(at.index.0, at.sub.0, &octets)?.is_ok() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn y26(tester: &mut Tester) -> Course {
    tester.may_move()?;
    let (pdo, id) = event_driven(tester, 0, 0)?;
    tester.collect(tester.silence() * 3)?;
    let before = tester.shown_by_sdo(&pdo)?;
    let unasked = tester.come(id, Duration::from_millis(300))?.len();
    if unasked > 0 && before.is_some() && tester.shown_by_sdo(&pdo)? == before {
        return broken(format!("{unasked} TPDOs come without a change"));
    }
    tester.drain()?;
    let at = tester.wire.now();
    if !change(tester, &pdo)? {
        return inapplicable("no entry that its TPDO maps can be changed by SDO");
    }
    let _ = at;
    if tester.find(tester.silence() * 2, |frame| frame.id() == id)?.is_some() {
        return Ok(());
    }
    // It may have come before the answer to the write.
    let sent = tester.wire.last_passed(6).iter().any(|passed| !passed.ours && passed.frame.id() == id);
    if sent { Ok(()) } else { broken("no TPDO after a change of an entry that it maps") }
}

fn y25(tester: &mut Tester) -> Course {
    tester.may_move()?;
    // 100 us each.
    let (pdo, id) = event_driven(tester, 0, 1000)?;
    tester.collect(Duration::from_millis(200))?;
    let inhibit = Duration::from_millis(100);
    let mut come = Vec::new();
    for _ in 0..6 {
        let since = tester.wire.now();
        if !change(tester, &pdo)? {
            return inapplicable("no entry that its TPDO maps can be changed by SDO");
        }
        let heard = tester.wire.last_passed(6);
        let early =
            heard.iter().filter(|passed| !passed.ours && passed.frame.id() == id && passed.at >= since);
        come.extend(early.map(|passed| passed.at).collect::<Vec<_>>());
        come.extend(tester.come(id, Duration::from_millis(30))?.into_iter().map(|passed| passed.at));
    }
    come.extend(tester.come(id, inhibit * 2)?.into_iter().map(|passed| passed.at));
    come.dedup();
    let margin = Duration::from_millis(2) + tester.wire.latency;
    for pair in come.windows(2) {
        if let [one, next] = pair {
            let apart = next.saturating_since(*one);
            if apart + margin < inhibit {
                return broken(format!(
                    "the inhibit time is 100 ms, and TPDOs are {} us apart",
                    apart.as_micros()
                ));
            }
        }
    }
    if come.len() >= 2 {
        Ok(())
    } else {
        broken("after changes within the inhibit time no TPDO comes at its end")
    }
}

fn y13(tester: &mut Tester) -> Course {
    let (pdo, id) = on(tester, 0)?;
    let before = tester.shown_by_sdo(&pdo)?;
    after_sync(tester, id)?;
    after_sync(tester, id)?;
    let come = after_sync(tester, id)?.len();
    let still = tester.shown_by_sdo(&pdo)? == before && before.is_some();
    if come > 0 && still {
        broken("type 0: a TPDO comes after each SYNC, and nothing changes")
    } else {
        Ok(())
    }
}

fn y17(tester: &mut Tester) -> Course {
    let (_, id) = event_driven(tester, 0, 0)?;
    tester.enter(NmtState::PreOperational)?;
    tester.collect(tester.silence() * 3)?;
    tester.nmt(&[0x01, tester.node().number()])?;
    let come = tester.come(id, tester.silence() * 2)?.len();
    if come == 1 {
        Ok(())
    } else {
        broken(format!("{come} TPDOs come when OPERATIONAL is entered, expected 1"))
    }
}
