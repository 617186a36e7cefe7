//! LSS, where the data sheet offers it.

use core::time::Duration;

use super::row;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::cob_id::{self, LSS_MASTER, LSS_SLAVE};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Bench;
use crate::judge::device::row::{By, Group};

pub(super) const GROUP: Group<Bench> = Group {
    title: "LSS",
    rows: &[
        row(
            "N-S00",
            "a node without LSS is silent on 7E4h",
            "0 in the file: silence on 7E4h (eds E-52)",
            &[],
            By::Trial(s00),
        ),
        row(
            "N-S01",
            "in the configuration state it tells its number and the four numbers of 1018h",
            "inquire in configuration state gives 1018h and the number (eds E-52)",
            &["N-R04"],
            By::Trial(s01),
        ),
        row(
            "N-S02",
            "in the waiting state it tells nothing",
            "inquire in configuration state (eds E-52)",
            &["N-S01"],
            By::Trial(s02),
        ),
        row(
            "N-S03",
            "the selective switch needs all four numbers",
            "selective needs all four (eds E-52)",
            &["N-S01"],
            By::Trial(s03),
        ),
        row(
            "N-S04",
            "numbers 0 and 128 are refused; another one is its own after a reset of the communication, and back",
            "new number after reset (eds E-52)",
            &["N-K06", "N-S01"],
            By::Trial(s04),
        ),
        row(
            "N-S05",
            "a rate that the table has not is refused",
            "set node number and bit rate (eds 4)",
            &["N-S01"],
            By::Trial(s05),
        ),
        row(
            "N-S06",
            "identify is not answered beside the ranges of 1018h, where it is answered at all",
            "switch global and selective, inquire all, store, identify (eds 4)",
            &["N-S01"],
            By::Trial(s06),
        ),
    ],
};

fn id(number: u16, bench: &Bench) -> Id {
    Id::base(number).unwrap_or_else(|_| bench.id(0))
}

/// A request, and what is answered.
fn ask(bench: &mut Bench, octets: [u8; 8]) -> Course<Option<[u8; 8]>> {
    let (master, slave) = (id(LSS_MASTER, bench), id(LSS_SLAVE, bench));
    bench.drain()?;
    bench.send(master, &octets)?;
    let answer = bench.find(bench.silence() * 3, |frame| frame.id() == slave)?;
    match answer.map(|passed| <[u8; 8]>::try_from(passed.frame.octets())) {
        None => Ok(None),
        Some(Ok(octets)) => Ok(Some(octets)),
        Some(Err(_)) => broken("an LSS answer has not 8 octets"),
    }
}

/// Switches to the state of waiting or of configuration, which is not answered.
fn switch(bench: &mut Bench, state: [u8; 8]) -> Course {
    bench.drain()?;
    bench.send(id(LSS_MASTER, bench), &state)?;
    bench.collect(bench.moment()).map(drop)
}

const WAITING: [u8; 8] = [0x04, 0, 0, 0, 0, 0, 0, 0];
const CONFIGURATION: [u8; 8] = [0x04, 1, 0, 0, 0, 0, 0, 0];
const NODE: [u8; 8] = [0x5E, 0, 0, 0, 0, 0, 0, 0];

fn offered(bench: &Bench) -> Course<bool> {
    match &bench.setup.eds {
        Some(eds) => Ok(eds.device.lss),
        None => inapplicable("needs eds=: the data sheet says whether it has LSS"),
    }
}

fn an_lss(bench: &Bench) -> Course {
    if offered(bench)? { Ok(()) } else { inapplicable("the data sheet offers no LSS") }
}

fn s00(bench: &mut Bench) -> Course {
    if offered(bench)? {
        return inapplicable("the data sheet offers LSS");
    }
    for octets in [CONFIGURATION, NODE, WAITING] {
        if ask(bench, octets)?.is_some() {
            return broken("it answers LSS, which its data sheet does not offer");
        }
    }
    Ok(())
}

fn s01(bench: &mut Bench) -> Course {
    an_lss(bench)?;
    switch(bench, CONFIGURATION)?;
    let told = numbers(bench);
    switch(bench, WAITING)?;
    told
}

fn numbers(bench: &mut Bench) -> Course {
    let own = bench.node().number();
    match ask(bench, NODE)? {
        Some([0x5E, number, ..]) if number == own => {}
        Some(octets) => {
            return broken(format!(
                "the inquiry for its number is answered with {octets:02X?}, expected {own}"
            ));
        }
        None => return broken("the inquiry for its number is not answered in the configuration state"),
    }
    for (command, sub) in (0x5A..=0x5D).zip(1..) {
        let Some(expected) = bench.number_if(0x1018, sub)? else { continue };
        match ask(bench, [command, 0, 0, 0, 0, 0, 0, 0])? {
            Some([said, a, b, c, d, ..]) if said == command => {
                let got = u32::from_le_bytes([a, b, c, d]);
                if u64::from(got) != expected {
                    return broken(format!("LSS says {got:08X}h for 1018h:{sub}, which is {expected:08X}h"));
                }
            }
            Some(octets) => {
                return broken(format!("the inquiry {command:02X}h is answered with {octets:02X?}"));
            }
            None => return broken(format!("the inquiry {command:02X}h is not answered")),
        }
    }
    Ok(())
}

fn s02(bench: &mut Bench) -> Course {
    an_lss(bench)?;
    switch(bench, WAITING)?;
    match ask(bench, NODE)? {
        None => Ok(()),
        Some(_) => broken("the inquiry for its number is answered in the waiting state"),
    }
}

fn s03(bench: &mut Bench) -> Course {
    an_lss(bench)?;
    switch(bench, WAITING)?;
    let selected = select(bench, false);
    switch(bench, WAITING)?;
    let other = select(bench, true);
    switch(bench, WAITING)?;
    if !selected? {
        return broken("the selective switch with the four numbers of 1018h is not answered");
    }
    if other? { broken("the selective switch with another serial number is answered") } else { Ok(()) }
}

/// Whether the selective switch is answered; `wrong`: with another serial number.
fn select(bench: &mut Bench, wrong: bool) -> Course<bool> {
    let mut last = [0; 8];
    for (command, sub) in (0x40..=0x43).zip(1..) {
        let number = u32::try_from(bench.number_if(0x1018, sub)?.unwrap_or_default()).unwrap_or_default();
        let number = if wrong && sub == 4 { !number } else { number };
        let [a, b, c, d] = number.to_le_bytes();
        last = [command, a, b, c, d, 0, 0, 0];
        if sub < 4 {
            bench.send(id(LSS_MASTER, bench), &last)?;
            bench.collect(bench.moment())?;
        }
    }
    Ok(matches!(ask(bench, last)?, Some([0x44, ..])))
}

/// In the configuration state, and back whatever comes.
fn configured<T>(bench: &mut Bench, act: impl FnOnce(&mut Bench) -> Course<T>) -> Course<T> {
    an_lss(bench)?;
    switch(bench, CONFIGURATION)?;
    let done = act(bench);
    switch(bench, WAITING)?;
    done
}

/// Asks for another number: whether it is taken.
fn renumber(bench: &mut Bench, number: u8) -> Course<bool> {
    match ask(bench, [0x11, number, 0, 0, 0, 0, 0, 0])? {
        Some([0x11, error, ..]) => Ok(error == 0),
        Some(octets) => broken(format!("the number {number} is answered with {octets:02X?}")),
        None => broken(format!("the number {number} is not answered")),
    }
}

fn s04(bench: &mut Bench) -> Course {
    bench.may_write()?;
    let (own, other) = (bench.node(), bench.other());
    configured(bench, |bench| {
        for number in [0, 128] {
            if renumber(bench, number)? {
                return broken(format!("the number {number} is taken"));
            }
        }
        if renumber(bench, other.number())? {
            Ok(())
        } else {
            inapplicable(format!("it refuses the number {}", other.number()))
        }
    })?;
    let boots = |bench: &mut Bench, from: NodeId, to: NodeId| {
        let id = cob_id::of_node(cob_id::ERROR_CONTROL, to);
        bench.drain()?;
        bench.nmt(&[0x82, from.number()])?;
        let heard = bench.find(Duration::from_secs(2), |frame| frame.id() == id && frame.octets() == [0])?;
        bench.collect(bench.moment())?;
        Ok(heard.is_some())
    };
    let renumbered = boots(bench, own, other)?;
    configured(bench, |bench| renumber(bench, own.number()))?;
    let back = boots(bench, other, own)?;
    bench.forget_written();
    match (renumbered, back) {
        (true, true) => Ok(()),
        (false, _) => broken(format!("no boot-up of node {other} after it was given that number")),
        (true, false) => broken(format!("no boot-up of node {own} after it was given its number back")),
    }
}

fn s05(bench: &mut Bench) -> Course {
    configured(bench, |bench| match ask(bench, [0x13, 0, 200, 0, 0, 0, 0, 0])? {
        Some([0x13, 1..=0xFF, ..]) => Ok(()),
        Some(octets) => {
            broken(format!("rate 200 of table 0 is answered with {octets:02X?}, expected an error"))
        }
        None => inapplicable("it sets no rates: 13h is not answered"),
    })
}

fn s06(bench: &mut Bench) -> Course {
    an_lss(bench)?;
    if !identified(bench, false)? {
        return inapplicable("it does not identify itself by ranges: some nodes have fastscan alone");
    }
    if identified(bench, true)? {
        return broken("identify with serial numbers that it has not is answered");
    }
    Ok(())
}

/// Whether identify is answered; `beside`: with serial numbers that it has not.
fn identified(bench: &mut Bench, beside: bool) -> Course<bool> {
    let mut last = [0; 8];
    let subs = [1, 2, 3, 3, 4, 4];
    for (command, sub) in (0x46..=0x4B).zip(subs) {
        let number = u32::try_from(bench.number_if(0x1018, sub)?.unwrap_or_default()).unwrap_or_default();
        let number = if beside && sub == 4 { !number } else { number };
        let [a, b, c, d] = number.to_le_bytes();
        last = [command, a, b, c, d, 0, 0, 0];
        if command < 0x4B {
            bench.send(id(LSS_MASTER, bench), &last)?;
            bench.collect(bench.moment())?;
        }
    }
    Ok(matches!(ask(bench, last)?, Some([0x4F, ..])))
}
