//! Boot-up and the states of the network.

use super::{row, sure};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::{Address, NmtState, cob_id};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::wire::Passed;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Boot-up, NMT",
    rows: &[
        row(
            "N-K01",
            "power-on: exactly one boot-up, nothing before it, then PRE-OPERATIONAL",
            "boot-up = 700h+n, 1 byte 00h, sent once, before anything else; then PRE-OPERATIONAL (3)",
            &["N-K06"],
            By::Trial(k01),
        ),
        row(
            "N-K02",
            "five commands from three states to its own number: the state table",
            "01h OPERATIONAL, 02h STOPPED, 80h PRE-OPERATIONAL, 81h and 82h reset (3)",
            &["N-K06"],
            By::Trial(k02),
        ),
        row(
            "N-K03",
            "the same to all nodes, number 0",
            "the node acts if byte 1 is 0 or its own number (3)",
            &["N-K02"],
            By::Trial(k03),
        ),
        row(
            "N-K04",
            "commands to other numbers, 128 to 255 too, have no effect",
            "the node acts if byte 1 is 0 or its own number (3)",
            &["N-K02"],
            By::Trial(k04),
        ),
        sure(
            row(
                "N-K05",
                "commands of 0, 1, 3 and 8 octets, unknown ones, remote frames, identifier 0 of 29 bits: no effect",
                "exactly 2 bytes; other commands, other lengths and remote frames: ignored (3)",
                &["N-K02"],
                By::Trial(k05),
            ),
            B,
        ),
        row(
            "N-K06",
            "81h and 82h: one boot-up each, then PRE-OPERATIONAL",
            "boot-up is sent once per (re)initialisation, before anything else (3)",
            &[],
            By::Trial(k06),
        ),
        row(
            "N-K08",
            "STOPPED: no answer to SDO, no PDO; error control goes on",
            "services in STOPPED: NMT, error control (3)",
            &["N-K02", "N-O01"],
            By::Trial(k08),
        ),
        sure(
            row(
                "N-K09",
                "an SDO transfer that is under way when the node is stopped is over, without a frame",
                "SDO transfers under way end without a frame when the node leaves PRE-OPERATIONAL or OPERATIONAL (3)",
                &["N-K08"],
                By::Trial(k09),
            ),
            B,
        ),
        row(
            "N-K07",
            "81h to all on a bus of many: every node boots, each its own frame",
            "every node boots (K-07)",
            &[],
            By::Nothing("only one node is under test"),
        ),
    ],
};

fn k01(tester: &mut Tester) -> Course {
    tester.act("power-cycle")?;
    tester.boot_up_first("power-on")?;
    not_again(tester, "power-on")?;
    tester.show_state()?;
    tester.must_be(NmtState::PreOperational, "after power-on")
}

/// No second boot-up.
fn not_again(tester: &mut Tester, what: &str) -> Course {
    let id = tester.id(cob_id::ERROR_CONTROL);
    let boots = |frame: &Frame| frame.id() == id && !frame.is_remote() && frame.octets() == [0];
    match tester.find(tester.silence() * 5, boots)? {
        None => Ok(()),
        Some(Passed { .. }) => broken(format!("a second boot-up after {what}")),
    }
}

const STATES: [NmtState; 3] = [NmtState::PreOperational, NmtState::Operational, NmtState::Stopped];

fn every_command(tester: &mut Tester, number: u8) -> Course {
    tester.show_state()?;
    for from in STATES {
        for (command, to) in
            [(0x01, NmtState::Operational), (0x02, NmtState::Stopped), (0x80, NmtState::PreOperational)]
        {
            tester.enter(from)?;
            tester.must_be(from, "after a command to its own number")?;
            tester.nmt(&[command, number])?;
            tester.collect(tester.moment())?;
            tester.must_be(to, &format!("after the command {command:02X} {number:02X} in {from}"))?;
        }
    }
    for command in [0x81, 0x82] {
        tester.enter(NmtState::Operational)?;
        tester.drain()?;
        tester.nmt(&[command, number])?;
        tester.boot_up(&format!("the command {command:02X} {number:02X}"))?;
        tester.forget_written();
        tester.collect(tester.moment())?;
        tester.show_state()?;
        tester.must_be(NmtState::PreOperational, "after a reset")?;
    }
    Ok(())
}

fn k02(tester: &mut Tester) -> Course {
    every_command(tester, tester.node().number())
}

fn k03(tester: &mut Tester) -> Course {
    every_command(tester, 0)
}

fn k04(tester: &mut Tester) -> Course {
    tester.show_state()?;
    let own = tester.node().number();
    for number in [tester.other().number(), own | 0x80, 128, 255] {
        for command in [0x01, 0x02, 0x81, 0x82] {
            tester.nmt(&[command, number])?;
        }
        not_again(tester, &format!("commands to number {number}"))?;
        tester.must_be(NmtState::PreOperational, &format!("after commands to number {number}"))?;
    }
    Ok(())
}

fn k05(tester: &mut Tester) -> Course {
    tester.show_state()?;
    let own = tester.node().number();
    let wrong: [&[u8]; 7] = [
        &[],
        &[0x01],
        &[0x01, own, 0],
        &[0x01, own, 0, 0, 0, 0, 0, 0],
        &[0x00, own],
        &[0x03, own],
        &[0xFF, own],
    ];
    for octets in wrong {
        tester.nmt(octets)?;
        tester.must_be(NmtState::PreOperational, &format!("after an NMT frame {octets:02X?}"))?;
    }
    tester.request(cob_id::NMT_ID, 2)?;
    tester.must_be(NmtState::PreOperational, "after a remote frame with identifier 0")?;
    if let Ok(extended) = crate::can_bus::can::Id::extended(0) {
        tester.send(extended, &[0x01, own])?;
        tester.must_be(NmtState::PreOperational, "after a frame with identifier 0 of 29 bits")?;
    }
    Ok(())
}

fn k06(tester: &mut Tester) -> Course {
    let own = tester.node().number();
    for command in [0x82, 0x81] {
        tester.collect(tester.silence())?;
        tester.nmt(&[command, own])?;
        tester.boot_up_first(&format!("the command {command:02X}"))?;
        not_again(tester, &format!("the command {command:02X}"))?;
    }
    Ok(())
}

fn k08(tester: &mut Tester) -> Course {
    tester.show_state()?;
    let sync = tester.sync_id()?;
    tester.enter(NmtState::Stopped)?;
    tester.must_be(NmtState::Stopped, "after the command 02")?;
    tester.drain()?;
    tester.send(tester.id(cob_id::SDO_CLIENT), &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0])?;
    tester.silent_on(tester.id(cob_id::SDO_SERVER), "an SDO is asked in STOPPED")?;
    tester.send(sync, &[])?;
    for pdo in [0x180, 0x280, 0x380, 0x480] {
        tester.silent_on(tester.id(pdo), "a SYNC in STOPPED asks for nothing")?;
    }
    tester.must_be(NmtState::Stopped, "after an SDO and a SYNC")
}

fn k09(tester: &mut Tester) -> Course {
    let Some(at) = super::segments::long_one(tester)? else {
        return inapplicable("it has no object that is read in segments");
    };
    super::segments::begin(tester, at)?;
    tester.drain()?;
    tester.nmt(&[0x02, tester.node().number()])?;
    tester.silent_on(tester.id(cob_id::SDO_SERVER), "the node is stopped within a transfer")?;
    tester.enter(NmtState::PreOperational)?;
    let answer = tester.asked([0x60, 0, 0, 0, 0, 0, 0, 0], "a segment request after STOPPED")?;
    let read = super::super::sdo::abort_of(answer);
    if read.is_none() {
        return broken(format!("a transfer of {at} goes on after the node was stopped"));
    }
    tester.upload(Address::new(0x1000, 0)).map(drop)
}
