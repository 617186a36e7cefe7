//! Rows about Set_Slave_Add: the slave takes another address, and keeps it.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::request::Request;
use crate::judge::requirement::Confidence::B;
use crate::profibus::dp::Service;
use crate::profibus::fdl::{FrameCount, ReplyStatus};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Set_Slave_Add",
    rows: &[
        row(
            "S-A01",
            "Set_Slave_Add: SC from the old address, then only the new one answers",
            "SC from the old address, then power-on with the new one (6.4)",
            &["S-A02"],
            By::Trial(a01),
        ),
        row(
            "S-A02",
            "a wrong ident number, address 126 or 127, and any in data exchange: no change",
            "only in WAIT-PRM, the ident number must match, else no change (6.4)",
            &["S-X01", "S-F02", "S-C07", "S-K06"],
            By::Trial(a02),
        ),
        row(
            "S-A03",
            "after No_Add_Chg no further change",
            "No_Add_Chg not 0: no further change until hardware reset (6.4)",
            &["S-A01"],
            By::Trial(a03),
        ),
        softer(
            row(
                "S-A04",
                "a slave without Set_Slave_Add: RS",
                "not supported: the SAP is closed, RS (6.4)",
                &[],
                By::Trial(a04),
            ),
            2,
            B,
        ),
        softer(
            row(
                "S-A05",
                "the address is kept over a power cycle",
                "needs non-volatile store for address and lock bit (6.4)",
                &["S-A01"],
                By::Trial(a05),
            ),
            2,
            B,
        ),
        row(
            "S-A06",
            "addresses from 0 to 125 work",
            "addresses of slaves: 0 to 125 (11)",
            &["S-A01"],
            By::Trial(a06),
        ),
    ],
};

/// What Set_Slave_Add says.
fn octets(address: u8, ident: u16, locked: bool) -> Vec<u8> {
    let [high, low] = ident.to_be_bytes();
    vec![address, high, low, if locked { 0xFF } else { 0 }]
}

/// Whether the slave has the service; a slave of which no file says it is asked with an ident number that is wrong.
fn has(tester: &mut Tester) -> Course<bool> {
    if let Some(gsd) = &tester.setup.gsd {
        return Ok(gsd.flags.set_slave_add);
    }
    let wrong = octets(tester.slave(), !tester.ident, false);
    let answer = tester.serve(tester.owner(), Service::SetSlaveAdd, &wrong)?;
    Ok(!answer.is_status(ReplyStatus::NotActivated))
}

fn must_have(tester: &mut Tester) -> Course {
    if has(tester)? { Ok(()) } else { inapplicable("the slave has no Set_Slave_Add") }
}

/// The address may be changed.
fn may_change(tester: &mut Tester) -> Course {
    must_have(tester)?;
    if !tester.setup.moves_allowed {
        return inapplicable("needs --moves-allowed: the address of the slave is changed, and changed back");
    }
    Ok(())
}

/// Somebody answers at this address. Where nobody should, no late reply is waited for.
fn answers_at(tester: &mut Tester, address: u8) -> Course<bool> {
    let request = Request::of(address, tester.owner(), Service::SlaveDiag, FrameCount::First, &[]);
    tester.forget_count(tester.owner());
    let heard = if address == tester.slave() {
        tester.exchange_octets(request.sa, &request.octets())?.map(|heard| heard.octets)
    } else {
        tester.intruder(request.sa, &request.octets())?
    };
    Ok(heard.is_some_and(|octets| matches!(Answer::of(&octets), Answer::Data(..))))
}

/// It is where it was, and nowhere else.
fn has_not_moved(tester: &mut Tester, to: u8, after: &str) -> Course {
    if to < 126 && to != tester.slave() && answers_at(tester, to)? {
        tester.move_to(to);
        return broken(format!("after {after} it answers at address {to}"));
    }
    if answers_at(tester, tester.slave())? {
        return Ok(());
    }
    broken(format!("after {after} it no longer answers at its address"))
}

fn a02(tester: &mut Tester) -> Course {
    must_have(tester)?;
    let (to, ident) = (tester.setup.nobody(), tester.ident);
    for (address, ident, what) in [
        (to, !ident, "a Set_Slave_Add with another ident number"),
        (126, ident, "a Set_Slave_Add to 126"),
        (127, ident, "a Set_Slave_Add to 127"),
    ] {
        let data = octets(address, ident, false);
        tester.serve(tester.owner(), Service::SetSlaveAdd, &data)?;
        has_not_moved(tester, address, what)?;
    }
    tester.must_start()?;
    let data = octets(to, ident, false);
    tester.serve(tester.owner(), Service::SetSlaveAdd, &data)?;
    has_not_moved(tester, to, "a Set_Slave_Add in data exchange")?;
    tester.still_exchanges("a Set_Slave_Add")
}

/// From its address to another, and what answers then.
fn goes(tester: &mut Tester, to: u8, locked: bool) -> Course {
    let from = tester.slave();
    let data = octets(to, tester.ident, locked);
    tester.acknowledged(Service::SetSlaveAdd, &data)?;
    tester.move_to(to);
    tester.look_briefly()?;
    if from != to && answers_at(tester, from)? {
        return broken(format!("it still answers at {from} after Set_Slave_Add to {to}"));
    }
    let diagnosis = tester.waits_for_prm(&format!("Set_Slave_Add to {to}"))?;
    if diagnosis.ident() != tester.ident {
        return broken(format!("another device answers at {to}"));
    }
    Ok(())
}

/// There and back.
fn there_and_back(tester: &mut Tester, to: u8) -> Course {
    let home = tester.slave();
    let there = goes(tester, to, false).and_then(|()| tester.must_start()).and_then(|()| tester.release());
    if tester.slave() != home {
        goes(tester, home, false)?;
    }
    there
}

fn a01(tester: &mut Tester) -> Course {
    may_change(tester)?;
    let to = tester.setup.nobody();
    there_and_back(tester, to)
}

fn a03(tester: &mut Tester) -> Course {
    may_change(tester)?;
    if !tester.is_attended() {
        return inapplicable("needs --ask: new-device, which takes No_Add_Chg back");
    }
    let (home, to) = (tester.slave(), tester.setup.nobody());
    goes(tester, to, true)?;
    let data = octets(home, tester.ident, false);
    tester.serve(tester.owner(), Service::SetSlaveAdd, &data)?;
    let course = has_not_moved(tester, home, "a Set_Slave_Add behind No_Add_Chg");
    tester.attend("new-device")?;
    tester.attend(&format!("set-address {home}"))?;
    tester.move_to(home);
    tester.look_briefly()?;
    course
}

fn a04(tester: &mut Tester) -> Course {
    if tester.setup.gsd.is_none() || has(tester)? {
        return inapplicable("the device file has Set_Slave_Add, or there is none");
    }
    let data = octets(tester.setup.nobody(), tester.ident, false);
    let answer = tester.serve(tester.owner(), Service::SetSlaveAdd, &data)?;
    if answer.is_status(ReplyStatus::NotActivated) {
        return Ok(());
    }
    broken(format!("Set_Slave_Add is answered with {}, expected RS", answer.words()))
}

fn a05(tester: &mut Tester) -> Course {
    may_change(tester)?;
    if !tester.is_attended() {
        return inapplicable("needs --ask: power-cycle");
    }
    let (home, to) = (tester.slave(), tester.setup.nobody());
    goes(tester, to, false)?;
    let cycled = tester.attend("power-cycle");
    tester.pause(core::time::Duration::from_millis(1))?;
    let course = match cycled {
        Ok(_) if answers_at(tester, to)? => Ok(()),
        Ok(_) => {
            tester.move_to(home);
            return broken("after a power cycle it does not answer at its new address");
        }
        Err(halt) => Err(halt),
    };
    goes(tester, home, false)?;
    course
}

/// Addresses at the ends, and in the middle.
const SOME: [u8; 5] = [0, 1, 63, 64, 125];

fn a06(tester: &mut Tester) -> Course {
    may_change(tester)?;
    let taken = [tester.owner(), tester.other(), tester.slave()];
    for to in SOME.into_iter().filter(|to| !taken.contains(to)) {
        if tester.setup.quick && to > 0 {
            break;
        }
        there_and_back(tester, to)?;
    }
    Ok(())
}
