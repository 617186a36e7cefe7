//! TPDOs: transmission types, SYNC, remote requests, timers.

use core::time::Duration;

use super::{row, sure};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::NmtState;
use crate::can_bus::canopen::cob_id::CobId;
use crate::explain::hex;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Bench;
use crate::judge::device::node::pdo::{Pdo, Way};
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::U;

pub(super) const GROUP: Group<Bench> = Group {
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
pub(super) fn on(bench: &mut Bench, kind: u8) -> Course<(Pdo, Id)> {
    let pdo = bench.a_pdo(Way::Sent)?;
    bench.alone(&pdo)?;
    quiet_timers(bench, &pdo)?;
    let id = bench.switch_on(&pdo, kind)?;
    bench.enter(NmtState::Operational)?;
    bench.collect(bench.silence())?;
    Ok((pdo, id))
}

/// No event timer of its own.
fn quiet_timers(bench: &mut Bench, pdo: &Pdo) -> Course {
    let parameters = pdo.parameters();
    if bench.is_writable(parameters, 5)? && bench.number_if(parameters, 5)?.is_some_and(|timer| timer != 0) {
        bench.switch_off(pdo)?;
        bench.set(parameters, 5, &[0, 0])?;
    }
    Ok(())
}

/// So many TPDOs come after a SYNC.
fn after_sync(bench: &mut Bench, id: Id) -> Course<Vec<Frame>> {
    bench.sync()?;
    let come = bench.come(id, bench.silence())?;
    Ok(come.into_iter().map(|passed| passed.frame).collect())
}

fn y02(bench: &mut Bench) -> Course {
    let (pdo, id) = on(bench, 1)?;
    for number in 1..=5 {
        let come = after_sync(bench, id)?;
        let [frame] = come.as_slice() else {
            return broken(format!("{} TPDOs come after SYNC {number}, expected 1", come.len()));
        };
        if frame.octets().len() != pdo.len() {
            return broken(format!("{frame} has {} octets, mapped are {}", frame.octets().len(), pdo.len()));
        }
    }
    let before = bench.shown_by_sdo(&pdo)?;
    let come = after_sync(bench, id)?;
    let after = bench.shown_by_sdo(&pdo)?;
    let Some(frame) = come.first() else { return broken("no TPDO after a SYNC") };
    match before {
        // What changes by itself cannot be compared.
        Some(before) if after.as_ref() == Some(&before) && frame.octets() != before => {
            broken(format!("the TPDO is {}, SDO shows {}", hex(frame.octets()), hex(&before)))
        }
        Some(_) | None => Ok(()),
    }
}

fn y22(bench: &mut Bench) -> Course {
    let counts: &[u8] = if bench.setup.quick { &[3] } else { &[2, 3, 10] };
    for count in counts {
        let (_, id) = on(bench, *count)?;
        // It may begin to count where it likes.
        for _ in 0..*count {
            if !after_sync(bench, id)?.is_empty() {
                break;
            }
        }
        for round in 1..=2 {
            for number in 1..=*count {
                let come = after_sync(bench, id)?.len();
                let expected = usize::from(number == *count);
                if come != expected {
                    return broken(format!(
                        "type {count}: {come} TPDOs after SYNC {number} of round {round}, expected {expected}"
                    ));
                }
            }
        }
        bench.enter(NmtState::PreOperational)?;
    }
    if bench.setup.quick { Ok(()) } else { every_240th(bench) }
}

/// So many SYNCs that not each can be waited for: only how many TPDOs come is judged.
fn every_240th(bench: &mut Bench) -> Course {
    let (_, id) = on(bench, 240)?;
    let sync = bench.sync_id()?;
    let mut come = 0;
    for _ in 0..480 {
        bench.send(sync, &[])?;
        come += bench.come(id, Duration::from_millis(2))?.len();
    }
    come += bench.come(id, bench.silence())?.len();
    if come == 2 {
        Ok(())
    } else {
        broken(format!("type 240: {come} TPDOs come after 480 SYNCs, expected 2"))
    }
}

/// Switches it off, in PRE-OPERATIONAL: some nodes allow it there only.
pub(super) fn off(bench: &mut Bench, pdo: &Pdo) -> Course {
    bench.enter(NmtState::PreOperational)?;
    bench.switch_off(pdo)
}

pub(super) fn nothing(bench: &mut Bench, id: Id, when: &str) -> Course {
    if let Some(frame) = after_sync(bench, id)?.first() {
        return broken(format!("{when} {frame} comes after a SYNC"));
    }
    bench.request(id, 8)?;
    if let Some(passed) = bench.come(id, bench.silence())?.first() {
        return broken(format!("{when} {} answers a remote request", passed.frame));
    }
    Ok(())
}

fn y01(bench: &mut Bench) -> Course {
    let (_, id) = on(bench, 1)?;
    bench.enter(NmtState::PreOperational)?;
    nothing(bench, id, "in PRE-OPERATIONAL")?;
    let sync = bench.sync_id()?;
    bench.enter(NmtState::Stopped)?;
    bench.send(sync, &[])?;
    bench.silent_on(id, "a SYNC comes in STOPPED")?;
    bench.enter(NmtState::PreOperational)
}

/// How many TPDOs answer a remote request, with bit 30 so.
fn answers(bench: &mut Bench, bit_30: bool) -> Course<usize> {
    let (pdo, id) = on(bench, 1)?;
    let cob_id = bench.cob_id(&pdo)?;
    let wanted = if bit_30 { cob_id | CobId::BIT_30 } else { cob_id & !CobId::BIT_30 };
    if wanted != cob_id {
        off(bench, &pdo)?;
        if let Err(code) = bench.try_set(pdo.parameters(), 1, &wanted.to_le_bytes())? {
            let why = super::super::sdo::refused(code);
            return inapplicable(format!(
                "{:04X}h:01 = {wanted:08X}h is refused with {why}",
                pdo.parameters()
            ));
        }
        bench.enter(NmtState::Operational)?;
        bench.collect(bench.silence())?;
    }
    bench.request(id, u8::try_from(pdo.len()).unwrap_or(8))?;
    Ok(bench.come(id, bench.silence())?.len())
}

fn y03(bench: &mut Bench) -> Course {
    match answers(bench, true)? {
        0 => Ok(()),
        count => broken(format!("bit 30 is set, and {count} TPDOs answer a remote request")),
    }
}

fn y33(bench: &mut Bench) -> Course {
    match answers(bench, false)? {
        1 => Ok(()),
        count => broken(format!("bit 30 is 0, and {count} TPDOs answer a remote request, expected 1")),
    }
}

fn y04(bench: &mut Bench) -> Course {
    let mut tried = 0;
    for kind in [252, 253] {
        let (pdo, id) = match on(bench, kind) {
            Ok(on) => on,
            Err(crate::judge::device::course::Halt::Inapplicable(_)) => continue,
            Err(halt) => return Err(halt),
        };
        tried += 1;
        if !after_sync(bench, id)?.is_empty() {
            return broken(format!("type {kind}: a TPDO comes after a SYNC"));
        }
        if !CobId(bench.cob_id(&pdo)?).bit_30() {
            bench.request(id, u8::try_from(pdo.len()).unwrap_or(8))?;
            let come = bench.come(id, bench.silence())?.len();
            if come != 1 {
                return broken(format!("type {kind}: {come} TPDOs answer a remote request, expected 1"));
            }
        }
        bench.enter(NmtState::PreOperational)?;
    }
    if tried == 0 { inapplicable("it refuses the types 252 and 253") } else { Ok(()) }
}

/// A TPDO of type 255 or 254 that is off, alone.
fn event_driven(bench: &mut Bench, timer: u16, inhibit: u16) -> Course<(Pdo, Id)> {
    let pdo = bench.a_pdo(Way::Sent)?;
    bench.alone(&pdo)?;
    bench.switch_off(&pdo)?;
    for (sub, value) in [(5, timer), (3, inhibit)] {
        if bench.is_writable(pdo.parameters(), sub)? {
            bench.set(pdo.parameters(), sub, &value.to_le_bytes())?;
        } else if value != 0 {
            return inapplicable(format!("{:04X}h:{sub} cannot be written", pdo.parameters()));
        }
    }
    let id = match bench.switch_on(&pdo, 255) {
        Ok(id) => id,
        Err(crate::judge::device::course::Halt::Inapplicable(_)) => bench.switch_on(&pdo, 254)?,
        Err(halt) => return Err(halt),
    };
    bench.enter(NmtState::Operational)?;
    Ok((pdo, id))
}

fn y05(bench: &mut Bench) -> Course {
    let period = bench.supervision();
    let ms = u16::try_from(period.as_millis()).unwrap_or(100);
    let (_, id) = event_driven(bench, ms, 0)?;
    let margin = period / 10 + bench.wire.latency;
    bench.collect(period * 2)?;
    let count = if bench.setup.quick { 6 } else { 11 };
    let come = bench.come(id, period * count)?;
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
fn change(bench: &mut Bench, pdo: &Pdo) -> Course<bool> {
    for (at, _) in pdo.places().unwrap_or_default() {
        let writable = at.index.0 >= 0x2000 && bench.is_writable(at.index.0, at.sub.0)?;
        if !writable {
            continue;
        }
        let Ok(mut octets) = bench.upload(at)? else { continue };
        if let Some(low) = octets.first_mut() {
            *low ^= 1;
        }
        if bench.try_set(at.index.0, at.sub.0, &octets)?.is_ok() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn y26(bench: &mut Bench) -> Course {
    bench.may_move()?;
    let (pdo, id) = event_driven(bench, 0, 0)?;
    bench.collect(bench.silence() * 3)?;
    let before = bench.shown_by_sdo(&pdo)?;
    let unasked = bench.come(id, Duration::from_millis(300))?.len();
    if unasked > 0 && before.is_some() && bench.shown_by_sdo(&pdo)? == before {
        return broken(format!("{unasked} TPDOs come without a change"));
    }
    bench.drain()?;
    let at = bench.wire.now();
    if !change(bench, &pdo)? {
        return inapplicable("no entry that its TPDO maps can be changed by SDO");
    }
    let _ = at;
    if bench.find(bench.silence() * 2, |frame| frame.id() == id)?.is_some() {
        return Ok(());
    }
    // It may have come before the answer to the write.
    let sent = bench.wire.last_passed(6).iter().any(|passed| !passed.ours && passed.frame.id() == id);
    if sent { Ok(()) } else { broken("no TPDO after a change of an entry that it maps") }
}

fn y25(bench: &mut Bench) -> Course {
    bench.may_move()?;
    // 100 us each.
    let (pdo, id) = event_driven(bench, 0, 1000)?;
    bench.collect(Duration::from_millis(200))?;
    let inhibit = Duration::from_millis(100);
    let mut come = Vec::new();
    for _ in 0..6 {
        let since = bench.wire.now();
        if !change(bench, &pdo)? {
            return inapplicable("no entry that its TPDO maps can be changed by SDO");
        }
        let heard = bench.wire.last_passed(6);
        let early =
            heard.iter().filter(|passed| !passed.ours && passed.frame.id() == id && passed.at >= since);
        come.extend(early.map(|passed| passed.at).collect::<Vec<_>>());
        come.extend(bench.come(id, Duration::from_millis(30))?.into_iter().map(|passed| passed.at));
    }
    come.extend(bench.come(id, inhibit * 2)?.into_iter().map(|passed| passed.at));
    come.dedup();
    let margin = Duration::from_millis(2) + bench.wire.latency;
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

fn y13(bench: &mut Bench) -> Course {
    let (pdo, id) = on(bench, 0)?;
    let before = bench.shown_by_sdo(&pdo)?;
    after_sync(bench, id)?;
    after_sync(bench, id)?;
    let come = after_sync(bench, id)?.len();
    let still = bench.shown_by_sdo(&pdo)? == before && before.is_some();
    if come > 0 && still {
        broken("type 0: a TPDO comes after each SYNC, and nothing changes")
    } else {
        Ok(())
    }
}

fn y17(bench: &mut Bench) -> Course {
    let (_, id) = event_driven(bench, 0, 0)?;
    bench.enter(NmtState::PreOperational)?;
    bench.collect(bench.silence() * 3)?;
    bench.nmt(&[0x01, bench.node().number()])?;
    let come = bench.come(id, bench.silence() * 2)?.len();
    if come == 1 {
        Ok(())
    } else {
        broken(format!("{come} TPDOs come when OPERATIONAL is entered, expected 1"))
    }
}
