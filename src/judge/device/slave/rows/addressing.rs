//! Set_Slave_Add.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::request::Request;
use crate::judge::requirement::Confidence::B;
use crate::profibus::dp::Service;
use crate::profibus::fdl::{FrameCount, ReplyStatus};

pub(super) const GROUP: Group<Bench> = Group {
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
fn has(bench: &mut Bench) -> Course<bool> {
    if let Some(gsd) = &bench.setup.gsd {
        return Ok(gsd.flags.set_slave_add);
    }
    let wrong = octets(bench.slave(), !bench.ident, false);
    let answer = bench.serve(bench.owner(), Service::SetSlaveAdd, &wrong)?;
    Ok(!answer.is_status(ReplyStatus::NotActivated))
}

fn must_have(bench: &mut Bench) -> Course {
    if has(bench)? { Ok(()) } else { inapplicable("the slave has no Set_Slave_Add") }
}

/// The address may be changed.
fn may_change(bench: &mut Bench) -> Course {
    must_have(bench)?;
    if !bench.setup.moves_allowed {
        return inapplicable("needs --moves-allowed: the address of the slave is changed, and changed back");
    }
    Ok(())
}

/// Somebody answers at this address. Where nobody should, no late reply is waited for.
fn answers_at(bench: &mut Bench, address: u8) -> Course<bool> {
    let request = Request::of(address, bench.owner(), Service::SlaveDiag, FrameCount::First, &[]);
    bench.forget_count(bench.owner());
    let heard = if address == bench.slave() {
        bench.exchange_octets(request.sa, &request.octets())?.map(|heard| heard.octets)
    } else {
        bench.intruder(request.sa, &request.octets())?
    };
    Ok(heard.is_some_and(|octets| matches!(Answer::of(&octets), Answer::Data(..))))
}

/// It is where it was, and nowhere else.
fn has_not_moved(bench: &mut Bench, to: u8, after: &str) -> Course {
    if to < 126 && to != bench.slave() && answers_at(bench, to)? {
        bench.move_to(to);
        return broken(format!("after {after} it answers at address {to}"));
    }
    if answers_at(bench, bench.slave())? {
        return Ok(());
    }
    broken(format!("after {after} it no longer answers at its address"))
}

fn a02(bench: &mut Bench) -> Course {
    must_have(bench)?;
    let (to, ident) = (bench.setup.nobody(), bench.ident);
    for (address, ident, what) in [
        (to, !ident, "a Set_Slave_Add with another ident number"),
        (126, ident, "a Set_Slave_Add to 126"),
        (127, ident, "a Set_Slave_Add to 127"),
    ] {
        let data = octets(address, ident, false);
        bench.serve(bench.owner(), Service::SetSlaveAdd, &data)?;
        has_not_moved(bench, address, what)?;
    }
    bench.must_start()?;
    let data = octets(to, ident, false);
    bench.serve(bench.owner(), Service::SetSlaveAdd, &data)?;
    has_not_moved(bench, to, "a Set_Slave_Add in data exchange")?;
    bench.still_exchanges("a Set_Slave_Add")
}

/// From its address to another, and what answers then.
fn goes(bench: &mut Bench, to: u8, locked: bool) -> Course {
    let from = bench.slave();
    let data = octets(to, bench.ident, locked);
    bench.acknowledged(Service::SetSlaveAdd, &data)?;
    bench.move_to(to);
    bench.look_briefly()?;
    if from != to && answers_at(bench, from)? {
        return broken(format!("it still answers at {from} after Set_Slave_Add to {to}"));
    }
    let diagnosis = bench.waits_for_prm(&format!("Set_Slave_Add to {to}"))?;
    if diagnosis.ident() != bench.ident {
        return broken(format!("another device answers at {to}"));
    }
    Ok(())
}

/// There and back.
fn there_and_back(bench: &mut Bench, to: u8) -> Course {
    let home = bench.slave();
    let there = goes(bench, to, false).and_then(|()| bench.must_start()).and_then(|()| bench.release());
    if bench.slave() != home {
        goes(bench, home, false)?;
    }
    there
}

fn a01(bench: &mut Bench) -> Course {
    may_change(bench)?;
    let to = bench.setup.nobody();
    there_and_back(bench, to)
}

fn a03(bench: &mut Bench) -> Course {
    may_change(bench)?;
    if !bench.is_attended() {
        return inapplicable("needs --ask: new-device, which takes No_Add_Chg back");
    }
    let (home, to) = (bench.slave(), bench.setup.nobody());
    goes(bench, to, true)?;
    let data = octets(home, bench.ident, false);
    bench.serve(bench.owner(), Service::SetSlaveAdd, &data)?;
    let course = has_not_moved(bench, home, "a Set_Slave_Add behind No_Add_Chg");
    bench.attend("new-device")?;
    bench.attend(&format!("set-address {home}"))?;
    bench.move_to(home);
    bench.look_briefly()?;
    course
}

fn a04(bench: &mut Bench) -> Course {
    if bench.setup.gsd.is_none() || has(bench)? {
        return inapplicable("the device file has Set_Slave_Add, or there is none");
    }
    let data = octets(bench.setup.nobody(), bench.ident, false);
    let answer = bench.serve(bench.owner(), Service::SetSlaveAdd, &data)?;
    if answer.is_status(ReplyStatus::NotActivated) {
        return Ok(());
    }
    broken(format!("Set_Slave_Add is answered with {}, expected RS", answer.words()))
}

fn a05(bench: &mut Bench) -> Course {
    may_change(bench)?;
    if !bench.is_attended() {
        return inapplicable("needs --ask: power-cycle");
    }
    let (home, to) = (bench.slave(), bench.setup.nobody());
    goes(bench, to, false)?;
    let cycled = bench.attend("power-cycle");
    bench.pause(core::time::Duration::from_millis(1))?;
    let course = match cycled {
        Ok(_) if answers_at(bench, to)? => Ok(()),
        Ok(_) => {
            bench.move_to(home);
            return broken("after a power cycle it does not answer at its new address");
        }
        Err(halt) => Err(halt),
    };
    goes(bench, home, false)?;
    course
}

/// Addresses at the ends, and in the middle.
const SOME: [u8; 5] = [0, 1, 63, 64, 125];

fn a06(bench: &mut Bench) -> Course {
    may_change(bench)?;
    let taken = [bench.owner(), bench.other(), bench.slave()];
    for to in SOME.into_iter().filter(|to| !taken.contains(to)) {
        if bench.setup.quick && to > 0 {
            break;
        }
        there_and_back(bench, to)?;
    }
    Ok(())
}
