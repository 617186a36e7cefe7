//! LSS, where the data sheet offers it.

use core::time::Duration;

use super::row;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::cob_id::{self, LSS_MASTER, LSS_SLAVE};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::row::{By, Group};

pub(super) const GROUP: Group<Tester> = Group {
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

fn id(number: u16, tester: &Tester) -> Id {
    Id::base(number).unwrap_or_else(|_| tester.id(0))
}

/// A request, and what is answered.
fn ask(tester: &mut Tester, octets: [u8; 8]) -> Course<Option<[u8; 8]>> {
    let (master, slave) = (id(LSS_MASTER, tester), id(LSS_SLAVE, tester));
    tester.drain()?;
    tester.send(master, &octets)?;
    let answer = tester.find(tester.silence() * 3, |frame| frame.id() == slave)?;
    match answer.map(|passed| <[u8; 8]>::try_from(passed.frame.octets())) {
        None => Ok(None),
        Some(Ok(octets)) => Ok(Some(octets)),
        Some(Err(_)) => broken("an LSS answer has not 8 octets"),
    }
}

/// Switches to the state of waiting or of configuration, which is not answered.
fn switch(tester: &mut Tester, state: [u8; 8]) -> Course {
    tester.drain()?;
    tester.send(id(LSS_MASTER, tester), &state)?;
    tester.collect(tester.moment()).map(drop)
}

const WAITING: [u8; 8] = [0x04, 0, 0, 0, 0, 0, 0, 0];
const CONFIGURATION: [u8; 8] = [0x04, 1, 0, 0, 0, 0, 0, 0];
const NODE: [u8; 8] = [0x5E, 0, 0, 0, 0, 0, 0, 0];

fn offered(tester: &Tester) -> Course<bool> {
    match &tester.setup.eds {
        Some(eds) => Ok(eds.device.lss),
        None => inapplicable("needs eds=: the data sheet says whether it has LSS"),
    }
}

fn an_lss(tester: &Tester) -> Course {
    if offered(tester)? { Ok(()) } else { inapplicable("the data sheet offers no LSS") }
}

fn s00(tester: &mut Tester) -> Course {
    if offered(tester)? {
        return inapplicable("the data sheet offers LSS");
    }
    for octets in [CONFIGURATION, NODE, WAITING] {
        if ask(tester, octets)?.is_some() {
            return broken("it answers LSS, which its data sheet does not offer");
        }
    }
    Ok(())
}

fn s01(tester: &mut Tester) -> Course {
    an_lss(tester)?;
    switch(tester, CONFIGURATION)?;
    let told = numbers(tester);
    switch(tester, WAITING)?;
    told
}

fn numbers(tester: &mut Tester) -> Course {
    let own = tester.node().number();
    match ask(tester, NODE)? {
        Some([0x5E, number, ..]) if number == own => {}
        Some(octets) => {
            return broken(format!(
                "the inquiry for its number is answered with {octets:02X?}, expected {own}"
            ));
        }
        None => return broken("the inquiry for its number is not answered in the configuration state"),
    }
    for (command, sub) in (0x5A..=0x5D).zip(1..) {
        let Some(expected) = tester.number_if(0x1018, sub)? else { continue };
        match ask(tester, [command, 0, 0, 0, 0, 0, 0, 0])? {
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

fn s02(tester: &mut Tester) -> Course {
    an_lss(tester)?;
    switch(tester, WAITING)?;
    match ask(tester, NODE)? {
        None => Ok(()),
        Some(_) => broken("the inquiry for its number is answered in the waiting state"),
    }
}

fn s03(tester: &mut Tester) -> Course {
    an_lss(tester)?;
    switch(tester, WAITING)?;
    let selected = select(tester, false);
    switch(tester, WAITING)?;
    let other = select(tester, true);
    switch(tester, WAITING)?;
    if !selected? {
        return broken("the selective switch with the four numbers of 1018h is not answered");
    }
    if other? { broken("the selective switch with another serial number is answered") } else { Ok(()) }
}

/// Whether the selective switch is answered; `wrong`: with another serial number.
fn select(tester: &mut Tester, wrong: bool) -> Course<bool> {
    let mut last = [0; 8];
    for (command, sub) in (0x40..=0x43).zip(1..) {
        let number = u32::try_from(tester.number_if(0x1018, sub)?.unwrap_or_default()).unwrap_or_default();
        let number = if wrong && sub == 4 { !number } else { number };
        let [a, b, c, d] = number.to_le_bytes();
        last = [command, a, b, c, d, 0, 0, 0];
        if sub < 4 {
            tester.send(id(LSS_MASTER, tester), &last)?;
            tester.collect(tester.moment())?;
        }
    }
    Ok(matches!(ask(tester, last)?, Some([0x44, ..])))
}

/// In the configuration state, and back whatever comes.
fn configured<T>(tester: &mut Tester, act: impl FnOnce(&mut Tester) -> Course<T>) -> Course<T> {
    an_lss(tester)?;
    switch(tester, CONFIGURATION)?;
    let done = act(tester);
    switch(tester, WAITING)?;
    done
}

/// Asks for another number: whether it is taken.
fn renumber(tester: &mut Tester, number: u8) -> Course<bool> {
    match ask(tester, [0x11, number, 0, 0, 0, 0, 0, 0])? {
        Some([0x11, error, ..]) => Ok(error == 0),
        Some(octets) => broken(format!("the number {number} is answered with {octets:02X?}")),
        None => broken(format!("the number {number} is not answered")),
    }
}

fn s04(tester: &mut Tester) -> Course {
    tester.may_write()?;
    let (own, other) = (tester.node(), tester.other());
    configured(tester, |tester| {
        for number in [0, 128] {
            if renumber(tester, number)? {
                return broken(format!("the number {number} is taken"));
            }
        }
        if renumber(tester, other.number())? {
            Ok(())
        } else {
            inapplicable(format!("it refuses the number {}", other.number()))
        }
    })?;
    let boots = |tester: &mut Tester, from: NodeId, to: NodeId| {
        let id = cob_id::of_node(cob_id::ERROR_CONTROL, to);
        tester.drain()?;
        tester.nmt(&[0x82, from.number()])?;
        let heard = tester.find(Duration::from_secs(2), |frame| frame.id() == id && frame.octets() == [0])?;
        tester.collect(tester.moment())?;
        Ok(heard.is_some())
    };
    let renumbered = boots(tester, own, other)?;
    configured(tester, |tester| renumber(tester, own.number()))?;
    let back = boots(tester, other, own)?;
    tester.forget_written();
    match (renumbered, back) {
        (true, true) => Ok(()),
        (false, _) => broken(format!("no boot-up of node {other} after it was given that number")),
        (true, false) => broken(format!("no boot-up of node {own} after it was given its number back")),
    }
}

fn s05(tester: &mut Tester) -> Course {
    configured(tester, |tester| match ask(tester, [0x13, 0, 200, 0, 0, 0, 0, 0])? {
        Some([0x13, 1..=0xFF, ..]) => Ok(()),
        Some(octets) => {
            broken(format!("rate 200 of table 0 is answered with {octets:02X?}, expected an error"))
        }
        None => inapplicable("it sets no rates: 13h is not answered"),
    })
}

fn s06(tester: &mut Tester) -> Course {
    an_lss(tester)?;
    if !identified(tester, false)? {
        return inapplicable("it does not identify itself by ranges: some nodes have fastscan alone");
    }
    if identified(tester, true)? {
        return broken("identify with serial numbers that it has not is answered");
    }
    Ok(())
}

/// Whether identify is answered; `beside`: with serial numbers that it has not.
fn identified(tester: &mut Tester, beside: bool) -> Course<bool> {
    let mut last = [0; 8];
    let subs = [1, 2, 3, 3, 4, 4];
    for (command, sub) in (0x46..=0x4B).zip(subs) {
        let number = u32::try_from(tester.number_if(0x1018, sub)?.unwrap_or_default()).unwrap_or_default();
        let number = if beside && sub == 4 { !number } else { number };
        let [a, b, c, d] = number.to_le_bytes();
        last = [command, a, b, c, d, 0, 0, 0];
        if command < 0x4B {
            tester.send(id(LSS_MASTER, tester), &last)?;
            tester.collect(tester.moment())?;
        }
    }
    Ok(matches!(ask(tester, last)?, Some([0x4F, ..])))
}
