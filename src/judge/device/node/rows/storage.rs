//! Saving, loading, and what a reset takes back.

use super::{row, sure};
use core::time::Duration;

use crate::can_bus::can::Frame;
use crate::can_bus::canopen::{Abort, Address, cob_id};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::sdo::refused;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Saving, loading, resets",
    rows: &[
        row(
            "N-R03",
            "1010h:1 and 1011h:1 with a wrong signature are refused: 08000020h",
            "wrong signature 08000020h (7)",
            &["N-O01"],
            By::Trial(r03),
        ),
        row(
            "N-R05",
            "1010h:1 and 1011h:1 say what they can: bit 0 or bit 1",
            "read bit 0: on command, bit 1: on its own (7)",
            &["N-O01"],
            By::Trial(r05),
        ),
        row(
            "N-R01",
            "what was saved is there after the supply was off and on, what was not saved is not",
            "save, restart / no save, restart: kept / lost (R-01)",
            &["N-R03"],
            By::Trial(r01),
        ),
        row(
            "N-R02",
            "after load and a reset the defaults are there",
            "load takes effect with the next reset (7)",
            &["N-R01"],
            By::Trial(r02),
        ),
        sure(
            row(
                "N-X46",
                "81h takes back what was written and not saved",
                "81h reset node: everything as after power-on (3)",
                &["N-O01"],
                By::Trial(x46),
            ),
            B,
        ),
    ],
};

const SAVE: [u8; 4] = *b"save";
const LOAD: [u8; 4] = *b"load";

fn r03(tester: &mut Tester) -> Course {
    tester.may_write()?;
    let mut tried = false;
    for (index, wrong) in [(0x1010, LOAD), (0x1011, SAVE)] {
        if !tester.is_writable(index, 1)? {
            continue;
        }
        tried = true;
        let got = tester.download(Address::new(index, 1), &wrong)?;
        let codes = [Abort::TRANSFER.code(), Abort::RANGE.code(), Abort::GENERAL.code()];
        tester.must_refuse(got, &codes, &format!("{index:04X}h:01 with a wrong signature"))?;
    }
    if tried { Ok(()) } else { inapplicable("it has neither 1010h:1 nor 1011h:1") }
}

fn r05(tester: &mut Tester) -> Course {
    let mut tried = false;
    for index in [0x1010, 0x1011] {
        let Some(bits) = tester.number_if(index, 1)? else { continue };
        tried = true;
        if bits == 0 || bits > 3 {
            return broken(format!("{index:04X}h:01 is {bits:08X}h, expected bit 0 or bit 1"));
        }
    }
    if tried { Ok(()) } else { inapplicable("it has neither 1010h:1 nor 1011h:1") }
}

/// The period of the heartbeat is what is changed; it is at hand in most nodes.
const AT: Address = Address::new(0x1017, 0);

fn may_save(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1010, 1)? || !tester.is_writable(0x1017, 0)? {
        return inapplicable("it has no 1010h:1, or no 1017h to change");
    }
    Ok(())
}

fn write(tester: &mut Tester, millis: u16) -> Course {
    match tester.download(AT, &millis.to_le_bytes())? {
        Ok(()) => Ok(()),
        Err(code) => broken(format!("1017h = {millis} is refused with {}", refused(code))),
    }
}

fn save(tester: &mut Tester) -> Course {
    match tester.download(Address::new(0x1010, 1), &SAVE)? {
        Ok(()) => Ok(()),
        Err(code) => broken(format!("1010h:01 = \"save\" is refused with {}", refused(code))),
    }
}

fn off_and_on(tester: &mut Tester) -> Course {
    tester.act("power-cycle")?;
    tester.boot_up("power-on")?;
    tester.collect(tester.silence()).map(drop)
}

fn r01(tester: &mut Tester) -> Course {
    may_save(tester)?;
    // Whoever stands beside it must be there before anything is saved.
    off_and_on(tester)?;
    let before = u16::try_from(tester.number(0x1017, 0)?).unwrap_or_default();
    let self_saving = tester.number_if(0x1010, 1)?.is_some_and(|bits| bits & 2 != 0);
    write(tester, 2500)?;
    save(tester)?;
    write(tester, 3500)?;
    off_and_on(tester)?;
    let kept = tester.number(0x1017, 0)?;
    write(tester, before)?;
    save(tester)?;
    tester.forget_written();
    tester.learn()?;
    match kept {
        2500 => Ok(()),
        3500 if self_saving => Ok(()),
        3500 => broken("1017h = 3500 was not saved, and is there after the supply was off and on"),
        other => broken(format!("1017h = 2500 was saved, and is {other} after the supply was off and on")),
    }
}

fn r02(tester: &mut Tester) -> Course {
    may_save(tester)?;
    if !tester.is_writable(0x1011, 1)? {
        return inapplicable("it has no 1011h:1");
    }
    let Some(eds) = &tester.setup.eds else {
        return inapplicable("needs eds=: the data sheet has the default");
    };
    let node = tester.node();
    let default =
        eds.entry(0x1017, 0).map(|entry| crate::judge::device::node::objects::whole(&entry.octets(node)));
    // What is loaded may be another number or rate: somebody must be able to take that back.
    tester.act("new-device")?;
    tester.boot_up("the action new-device")?;
    tester.collect(tester.silence())?;
    let loaded = load(tester, default);
    tester.act("new-device")?;
    tester.boot_up("the action new-device")?;
    tester.collect(tester.silence())?;
    tester.forget_written();
    tester.learn()?;
    loaded
}

fn load(tester: &mut Tester, default: Option<u64>) -> Course {
    write(tester, 2500)?;
    save(tester)?;
    if let Err(code) = tester.download(Address::new(0x1011, 1), &LOAD)? {
        return broken(format!("1011h:01 = \"load\" is refused with {}", refused(code)));
    }
    if tester.number(0x1017, 0)? != 2500 {
        return broken("1011h:01 = \"load\" changes 1017h before the reset");
    }
    tester.nmt(&[0x81, tester.node().number()])?;
    let boots = |frame: &Frame| (0x701..=0x77F).contains(&frame.id().number()) && frame.octets() == [0];
    let boot_up = tester.find(Duration::from_secs(10), boots)?;
    match boot_up {
        Some(passed) if passed.frame.id() != tester.id(cob_id::ERROR_CONTROL) => {
            return inapplicable(format!("load gives it another number: {}", passed.frame));
        }
        Some(_) => {}
        None => return broken("no boot-up after load and reset node"),
    }
    tester.collect(tester.silence())?;
    let after = tester.number(0x1017, 0)?;
    if Some(after) == default {
        return Ok(());
    }
    broken(format!("1017h is {after} after load and reset, the default is {default:?}"))
}

fn x46(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1017, 0)? {
        return inapplicable("it has no 1017h to change");
    }
    if tester.number_if(0x1010, 1)?.is_some_and(|bits| bits & 2 != 0) {
        return inapplicable("it stores by itself what is written (1010h:1 bit 1)");
    }
    let before = tester.number(0x1017, 0)?;
    tester.set(0x1017, 0, &2500_u16.to_le_bytes())?;
    tester.nmt(&[0x81, tester.node().number()])?;
    tester.boot_up("reset node")?;
    tester.collect(tester.silence())?;
    let after = tester.number(0x1017, 0)?;
    if after == before {
        tester.forget_written();
        return tester.learn();
    }
    broken(format!("1017h is {after} after reset node, it was {before} and 2500 was not saved"))
}
