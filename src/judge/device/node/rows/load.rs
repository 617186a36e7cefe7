//! Load: requests without a pause, frames of others.

use super::{row, sure};
use crate::can_bus::can::Id;
use crate::can_bus::canopen::{Address, cob_id};
use crate::explain::hex;
use crate::judge::device::course::{Course, broken};
use crate::judge::device::node::Tester;
use crate::judge::device::node::sdo::{abort_of, address_of, addressed};
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Load",
    rows: &[
        row(
            "N-B01",
            "frames of others, remote frames and 29-bit identifiers beside it: no reaction, and it serves on",
            "a slave hears each frame and answers what is for it (1, 2)",
            &["N-O01"],
            By::Trial(b01),
        ),
        sure(
            row(
                "N-O15",
                "requests back to back are each answered once, in order",
                "each answered once, in order (O-15)",
                &["N-O01"],
                By::Trial(o15),
            ),
            B,
        ),
    ],
};

fn b01(tester: &mut Tester) -> Course {
    let count: u16 = if tester.setup.quick { 60 } else { 400 };
    let own = tester.node().number();
    tester.drain()?;
    for number in 0..count {
        // Identifiers that no service of the node has by the predefined connection set.
        let id = 0x6E0 + number % 0x20;
        let octets = number.to_le_bytes().repeat(4);
        let Ok(id) = Id::base(id) else { continue };
        match number % 4 {
            0 => tester.send(id, &octets)?,
            1 => tester.request(id, 8)?,
            2 => {
                let extended = Id::extended(0x600 + u32::from(own)).unwrap_or(id);
                tester.send(extended, &[0x40, 0, 0x10, 0, 0, 0, 0, 0])?;
            }
            _fourth => tester.send(id, octets.get(..usize::from(number % 9)).unwrap_or_default())?,
        }
    }
    if let Err(halt) = tester.silent_on(tester.id(cob_id::SDO_SERVER), "frames of others pass") {
        // What else comes belongs to this row.
        tester.collect(tester.silence() * 8)?;
        return Err(halt);
    }
    tester.value(0x1000, 0).map(drop)
}

fn o15(tester: &mut Tester) -> Course {
    // An overrun is an error of some drives, and of the judge's making.
    tester.leaves_errors();
    let pause = core::mem::take(&mut tester.pause);
    let asked = back_to_back(tester);
    tester.pause = pause;
    asked
}

fn back_to_back(tester: &mut Tester) -> Course {
    let count = if tester.setup.quick { 50 } else { 300 };
    for number in 0..count {
        let at = if number % 2 == 0 { Address::new(0x1000, 0) } else { Address::new(0x1018, 1) };
        let answer = tester.asked(addressed(0x40, at, [0; 4]), &format!("request {number} of many"))?;
        if abort_of(answer).is_some() || address_of(answer) != at {
            return broken(format!("request {number}, a read of {at}, is answered with {}", hex(&answer)));
        }
    }
    tester.silent_on(tester.id(cob_id::SDO_SERVER), "every request is answered")
}
