//! Emergencies and the list of errors.

use core::time::Duration;

use super::error_control::{consumer, emergencies, emergency_id, event};
use super::{row, sure};
use crate::can_bus::can::Id;
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::{Abort, Address, NmtState, cob_id};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::sdo::refused;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "EMCY, errors",
    rows: &[
        row(
            "N-M01",
            "an emergency has 8 octets, the code, and 1001h; the code is then 1003h:1",
            "EMCY 8 bytes: code (LE), 1001h, 5 manufacturer; 1003h sub 1 newest (7)",
            &["N-E05"],
            By::Trial(m01),
        ),
        row(
            "N-M02",
            "an emergency is sent once for each event",
            "once per event (7)",
            &["N-M01"],
            By::Trial(m02),
        ),
        row(
            "N-E08",
            "1014h with bit 31: no emergency; with another identifier: emergencies there",
            "1014h bit 31 / other id: silent / moved (E-08)",
            &["N-K06", "N-M01"],
            By::Trial(e08),
        ),
        row(
            "N-M03",
            "1003h:0 := 0 clears the list; another value is refused",
            "writing 0 to sub 0 clears, other values 06090030h (7)",
            &["N-O01"],
            By::Trial(m03),
        ),
        row(
            "N-M04",
            "1003h beyond its count: 08000024h, or 0",
            "reading beyond the count: 08000024h or 0 (7)",
            &["N-O01"],
            By::Trial(m04),
        ),
        sure(
            row(
                "N-M05",
                "no emergency in STOPPED, nor later for what happened there",
                "sent in PRE-OPERATIONAL and OPERATIONAL; events in other states are not sent later (7)",
                &["N-K02", "N-M01"],
                By::Trial(m05),
            ),
            B,
        ),
        sure(
            row(
                "N-M06",
                "1015h: emergencies are never closer",
                "EMCY 1015h inhibit time, 100 us (eds 4)",
                &["N-M02"],
                By::Trial(m06),
            ),
            B,
        ),
        row(
            "N-B02",
            "in PRE-OPERATIONAL, asked nothing, it sends nothing but its heartbeat",
            "services of PRE-OPERATIONAL: NMT, SDO, EMCY, error control (3)",
            &[],
            By::Trial(b02),
        ),
    ],
};

/// Provokes EMCY 8130h by heartbeats that stop, and waits for what comes.
fn provoke(tester: &mut Tester) -> Course<Id> {
    tester.may_write()?;
    if !tester.is_writable(0x1016, 1)? {
        return inapplicable("it has no 1016h:1 by which an emergency could be provoked");
    }
    tester.leaves_errors();
    let node = tester.other();
    let consumer = consumer(tester);
    tester.set(0x1016, 1, &consumer)?;
    let id = emergency_id(tester)?;
    tester.send(cob_id::of_node(cob_id::ERROR_CONTROL, node), &[0x05])?;
    Ok(id)
}

/// In which an emergency must have come.
fn time(tester: &Tester) -> Duration {
    tester.supervision() * 4 + tester.wire.latency
}

fn m01(tester: &mut Tester) -> Course {
    let id = provoke(tester)?;
    let heard = tester.find(time(tester), |frame| frame.id() == id)?;
    let Some(heard) = heard else { return broken("no emergency") };
    let octets = heard.frame.octets();
    let [low, high, register, ..] = octets else {
        return broken(format!("an emergency of {} octets", octets.len()));
    };
    if octets.len() != 8 {
        return broken(format!("an emergency has {} octets, expected 8", octets.len()));
    }
    let (code, register) = (u16::from_le_bytes([*low, *high]), u64::from(*register));
    // A device may have a code of its own, but not of another class.
    if code == 0 || code >> 12 != 8 && code >> 12 != 0xF {
        return broken(format!("the code of the emergency is {code:04X}h, expected 8130h"));
    }
    let now = tester.number(0x1001, 0)?;
    if now != register {
        return broken(format!("the emergency says {register:02X}h for 1001h, which is {now:02X}h"));
    }
    if tester.has(0x1003, 0)? {
        if tester.number(0x1003, 0)? == 0 {
            return broken("1003h:0 is 0 after an emergency");
        }
        let newest = tester.number(0x1003, 1)?;
        if newest & 0xFFFF != u64::from(code) {
            return broken(format!("1003h:1 is {newest:08X}h after EMCY {code:04X}h"));
        }
    }
    Ok(())
}

fn m02(tester: &mut Tester) -> Course {
    let id = provoke(tester)?;
    let codes = emergencies(tester, id, time(tester) * if tester.setup.quick { 2 } else { 3 })?;
    let count = codes.iter().filter(|code| **code != 0).count();
    if count == 1 { Ok(()) } else { broken(format!("{count} emergencies come for one event")) }
}

fn e08(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1014, 0)? {
        return inapplicable("it has no 1014h to write to");
    }
    let old = CobId(u32::try_from(tester.number(0x1014, 0)?).unwrap_or_default());
    let Some(id) = old.active() else { return inapplicable("1014h is switched off") };
    tester.set(0x1014, 0, &(old.0 | CobId::INVALID).to_le_bytes())?;
    provoke(tester)?;
    if tester.find(time(tester), |frame| frame.id() == id)?.is_some() {
        return broken("an emergency comes although 1014h has bit 31");
    }
    tester.reset()?;
    tester.forget_written();
    tester.set(0x1014, 0, &(old.0 | CobId::INVALID).to_le_bytes())?;
    let moved = 0x0F0_u32;
    tester.set(0x1014, 0, &moved.to_le_bytes())?;
    provoke(tester)?;
    let new = Id::base(0x0F0).unwrap_or(id);
    let heard = tester.find(time(tester), |frame| frame.id() == id || frame.id() == new)?;
    match heard {
        Some(passed) if passed.frame.id() == new => Ok(()),
        Some(passed) => broken(format!("1014h is 0F0h, and the emergency comes as {}", passed.frame)),
        None => broken("1014h is 0F0h, and no emergency comes"),
    }
}

fn m03(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1003, 0)? {
        return inapplicable("it has no 1003h:0 to write to");
    }
    let at = Address::new(0x1003, 0);
    let size = tester.value(0x1003, 0)?.len();
    let one: Vec<u8> = [1, 0, 0, 0].into_iter().take(size).collect();
    let got = tester.download(at, &one)?;
    let codes = [Abort::RANGE.code(), Abort::TOO_HIGH.code(), Abort::GENERAL.code()];
    tester.must_refuse(got, &codes, "1003h:0 = 1")?;
    if let Err(code) = tester.download(at, &vec![0; size])? {
        return broken(format!("1003h:0 = 0 is refused with {}", refused(code)));
    }
    let count = tester.number(0x1003, 0)?;
    if count == 0 { Ok(()) } else { broken(format!("1003h:0 is {count} after it was set to 0")) }
}

fn m04(tester: &mut Tester) -> Course {
    if !tester.has(0x1003, 1)? {
        return inapplicable("it has no 1003h");
    }
    let count = tester.number(0x1003, 0)?;
    let Ok(beyond) = u8::try_from(count + 1) else { return inapplicable("1003h is full") };
    if !tester.has(0x1003, beyond)? {
        return inapplicable("1003h is full");
    }
    match tester.upload(Address::new(0x1003, beyond))? {
        Err(code) if code == Abort::NO_DATA.code() => Ok(()),
        Ok(octets) if octets.iter().all(|octet| *octet == 0) => Ok(()),
        Ok(octets) => broken(format!("1003h:{beyond} is {octets:02X?}, and 1003h:0 is {count}")),
        Err(code) => broken(format!("a read of 1003h:{beyond} is refused with {}", refused(code))),
    }
}

fn m05(tester: &mut Tester) -> Course {
    let id = provoke(tester)?;
    tester.enter(NmtState::Stopped)?;
    if !emergencies(tester, id, time(tester))?.is_empty() {
        return broken("an emergency comes in STOPPED");
    }
    tester.enter(NmtState::PreOperational)?;
    if event(&emergencies(tester, id, tester.silence())?).is_some() {
        return broken("an emergency of STOPPED comes later");
    }
    Ok(())
}

fn m06(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1015, 0)? {
        return inapplicable("it has no 1015h to write to");
    }
    let inhibit = Duration::from_millis(500);
    tester.set(0x1015, 0, &5000_u16.to_le_bytes())?;
    let id = provoke(tester)?;
    let Some(first) = tester.find(time(tester), |frame| frame.id() == id)? else {
        return broken("no emergency with 1015h = 5000");
    };
    // The error is gone: that is the second one.
    let node = tester.other();
    tester.send(cob_id::of_node(cob_id::ERROR_CONTROL, node), &[0x05])?;
    match tester.find(inhibit * 2, |frame| frame.id() == id)? {
        None => inapplicable("no second emergency comes when the heartbeats come back"),
        Some(next) => {
            let apart = next.at.saturating_since(first.at);
            if apart + Duration::from_millis(2) + tester.wire.latency < inhibit {
                return broken(format!(
                    "1015h is 500 ms, and emergencies are {} ms apart",
                    apart.as_millis()
                ));
            }
            Ok(())
        }
    }
}

fn b02(tester: &mut Tester) -> Course {
    tester.drain()?;
    let heartbeat = tester.id(cob_id::ERROR_CONTROL);
    let time = Duration::from_millis(if tester.setup.quick { 300 } else { 1000 });
    for passed in tester.collect(time)? {
        if passed.frame.id() != heartbeat {
            return broken(format!("{} comes, and nobody asked for it", passed.frame));
        }
    }
    Ok(())
}
