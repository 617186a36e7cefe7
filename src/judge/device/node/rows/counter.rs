//! The counter of SYNC, SYNC of the node itself, TIME.

use core::time::Duration;

use super::{row, sure};
use crate::can_bus::can::Id;
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::{Abort, NmtState};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::pdo::Way;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "SYNC counter, TIME",
    rows: &[
        row(
            "N-Y50",
            "1019h takes 0 and 2 to 240, and refuses 1 and 241 to 255",
            "1019h: 0 no counter, 2..240; 1 and 241..255 reserved (7)",
            &["N-O01"],
            By::Trial(y50),
        ),
        sure(
            row(
                "N-Y51",
                "1019h does not change while 1006h is not 0: 08000022h",
                "1019h is fixed while 1006h is not 0 (7)",
                &["N-Y50"],
                By::Trial(y51),
            ),
            B,
        ),
        row(
            "N-Y52",
            "with 1019h a TPDO with a SYNC start value does not come before the SYNC with that counter, then after each",
            "18xxh:6 SYNC start value (6); with 1019h > 0 a counter octet (eds 4)",
            &["N-Y22", "N-Y50"],
            By::Trial(y52),
        ),
        sure(
            row(
                "N-Y53",
                "bit 30 of 1005h: a SYNC each 1006h us, within 10 %; with 1019h they count from 1",
                "the node as producer (bit 30, 1006h) when written (eds 4)",
                &["N-O01"],
                By::Trial(y53),
            ),
            B,
        ),
        row(
            "N-T01",
            "TIME with six octets, with others, as a remote frame: no frame, and it serves on",
            "TIME 100h, 1012h: six octets are taken; nothing else (2, eds 4)",
            &["N-O01"],
            By::Trial(t01),
        ),
    ],
};

fn a_counter(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if tester.is_writable(0x1019, 0)? { Ok(()) } else { inapplicable("it has no 1019h to write to") }
}

fn y50(tester: &mut Tester) -> Course {
    a_counter(tester)?;
    if tester.is_writable(0x1006, 0)? {
        tester.set(0x1006, 0, &[0; 4])?;
    }
    for value in [2, 240, 0] {
        tester.set(0x1019, 0, &[value])?;
    }
    let codes = [Abort::RANGE, Abort::TOO_LOW, Abort::TOO_HIGH].map(Abort::code);
    for value in [1, 241, 255] {
        let got = tester.try_set(0x1019, 0, &[value])?;
        tester.must_refuse(got, &codes, &format!("1019h = {value}"))?;
    }
    Ok(())
}

fn y51(tester: &mut Tester) -> Course {
    a_counter(tester)?;
    if !tester.is_writable(0x1006, 0)? {
        return inapplicable("it has no 1006h to write to");
    }
    tester.set(0x1006, 0, &50_000_u32.to_le_bytes())?;
    let got = tester.try_set(0x1019, 0, &[10])?;
    tester.must_refuse(got, &[Abort::DEVICE_STATE.code()], "1019h = 10 while 1006h is 50000")
}

fn y52(tester: &mut Tester) -> Course {
    const HIGHEST: u8 = 10;
    const START: u8 = 5;
    a_counter(tester)?;
    let pdo = tester.a_pdo(Way::Sent)?;
    if !tester.is_writable(pdo.parameters(), 6)? {
        return inapplicable(format!("it has no {:04X}h:06 to write to", pdo.parameters()));
    }
    tester.alone(&pdo)?;
    tester.switch_off(&pdo)?;
    tester.set(0x1019, 0, &[HIGHEST])?;
    tester.set(pdo.parameters(), 6, &[START])?;
    // With larger types stacks differ: whether that SYNC is the first or the last one of n.
    let id = tester.switch_on(&pdo, 1)?;
    tester.enter(NmtState::Operational)?;
    tester.collect(tester.silence())?;
    let sync = tester.sync_id()?;
    for (number, counter) in (1..).zip((1..=HIGHEST).chain(1..=4)) {
        tester.send(sync, &[counter])?;
        let come = tester.come(id, tester.silence())?.len();
        // Once it has begun it goes on, through the end of the counter.
        let due = number >= START;
        if come != usize::from(due) {
            return broken(format!(
                "type 1, SYNC start value {START}: {come} TPDOs come after the SYNC with the counter {counter}, expected {}",
                u8::from(due)
            ));
        }
    }
    Ok(())
}

fn y53(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1006, 0)? || !tester.is_writable(0x1005, 0)? {
        return inapplicable("it has no 1005h and 1006h to write to");
    }
    let period = Duration::from_millis(50);
    let counts = tester.is_writable(0x1019, 0)?;
    if counts {
        tester.set(0x1019, 0, &[3])?;
    }
    tester.set(0x1006, 0, &50_000_u32.to_le_bytes())?;
    let own = u32::try_from(tester.number(0x1005, 0)?).unwrap_or(0x80);
    if tester.try_set(0x1005, 0, &(own | CobId::BIT_30).to_le_bytes())?.is_err() {
        return inapplicable("it sends no SYNC: 1005h refuses bit 30");
    }
    let Some(id) = CobId(own & !CobId::BIT_30 & !CobId::INVALID).id() else {
        return inapplicable("1005h has no identifier");
    };
    let come = tester.come(id, period * 6 + tester.wire.latency)?;
    if come.len() < 5 {
        return broken(format!("1006h is 50000, and {} SYNCs come in 300 ms", come.len()));
    }
    let margin = period / 10 + tester.wire.latency;
    for (number, pair) in come.windows(2).enumerate() {
        let [one, next] = pair else { continue };
        let apart = next.at.saturating_since(one.at);
        if apart + margin < period || apart > period + margin {
            return broken(format!("1006h is 50000, and SYNCs are {} us apart", apart.as_micros()));
        }
        let expected = [u8::try_from(number % 3).unwrap_or_default() + 1];
        let expected = if counts { expected.as_slice() } else { &[] };
        if one.frame.octets() != expected {
            return broken(format!("SYNC {} is {}, expected {expected:02X?}", number + 1, one.frame));
        }
    }
    Ok(())
}

fn t01(tester: &mut Tester) -> Course {
    const PREDEFINED: u32 = 0x100;
    let number = tester.number_if(0x1012, 0)?.and_then(|number| u32::try_from(number).ok());
    let id = CobId(number.unwrap_or(PREDEFINED) & !CobId::INVALID & !CobId::BIT_30).id();
    let Some(id) = id.or_else(|| Id::base(0x100).ok()) else {
        return inapplicable("1012h has no identifier");
    };
    tester.drain()?;
    for octets in [&[0x10, 0x27, 0, 0, 1, 0][..], &[0xFF; 6], &[], &[1], &[0; 8]] {
        tester.send(id, octets)?;
    }
    tester.request(id, 6)?;
    let heartbeat = tester.id(crate::can_bus::canopen::cob_id::ERROR_CONTROL);
    for passed in tester.collect(tester.silence() * 2)? {
        if passed.frame.id() != heartbeat {
            return broken(format!("{} comes after a TIME", passed.frame));
        }
    }
    tester.value(0x1000, 0).map(drop)
}
