//! RPDOs: what they write, when, and what is wrong in them.

use super::{row, sure};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::{Address, NmtState};
use crate::explain::hex;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::pdo::{Pdo, Way};
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "RPDOs",
    rows: &[
        row(
            "N-Y08",
            "type 254 or 255: what an RPDO carries is taken at once",
            "254, 255: at once (6)",
            &["N-O01"],
            By::Trial(y08),
        ),
        row(
            "N-Y28",
            "types 0 to 240: what an RPDO carries is taken at the next SYNC, not before",
            "0..240: at the next SYNC (6)",
            &["N-Y08"],
            By::Trial(y28),
        ),
        row(
            "N-Y09",
            "an RPDO that is too short is not taken",
            "RPDO shorter than its mapping: not taken, EMCY 8210h once (6)",
            &["N-Y08"],
            By::Trial(y09),
        ),
        sure(
            row(
                "N-Y29",
                "an RPDO that is too long is taken, its surplus is not looked at",
                "longer: surplus ignored (8220h optional) (6)",
                &["N-Y08"],
                By::Trial(y29),
            ),
            B,
        ),
        row(
            "N-Y30",
            "outside OPERATIONAL, with bit 31, of 29 bits, as a remote frame: an RPDO is not taken",
            "only in OPERATIONAL and only if bit 31 = 0; 29-bit only from extended frames and vice versa (6)",
            &["N-K02", "N-Y08"],
            By::Trial(y30),
        ),
    ],
};

/// An RPDO that is on, an entry of it that can be read, and two contents that differ in that entry.
struct Carrier {
    pdo: Pdo,
    id: Id,
    at: Address,
    place: core::ops::Range<usize>,
    /// What is there.
    held: Vec<u8>,
    other: Vec<u8>,
}

impl Carrier {
    fn of<'a>(&self, octets: &'a [u8]) -> &'a [u8] {
        octets.get(self.place.clone()).unwrap_or_default()
    }
}

/// In OPERATIONAL, with an RPDO of this type.
fn carrier(tester: &mut Tester, kind: u8) -> Course<Carrier> {
    tester.may_move()?;
    let pdo = tester.a_pdo(Way::Received)?;
    let Some(held) = tester.shown_by_sdo(&pdo)? else {
        return inapplicable("what its RPDO carries cannot be read");
    };
    let places = pdo.places().unwrap_or_default();
    let id = match tester.switch_on(&pdo, kind) {
        Err(crate::judge::device::course::Halt::Inapplicable(_)) if kind == 255 => {
            tester.switch_on(&pdo, 254)?
        }
        other => other?,
    };
    tester.enter(NmtState::Operational)?;
    for (at, place) in places.into_iter().filter(|(at, _)| at.index.0 >= 0x2000) {
        for bit in [0x01, 0x02, 0x10] {
            let mut other = held.clone();
            if let Some(low) = other.get_mut(place.start) {
                *low ^= bit;
            }
            // A value that SDO refuses an RPDO cannot write either.
            let value = other.get(place.clone()).unwrap_or_default().to_vec();
            let before = held.get(place.clone()).unwrap_or_default().to_vec();
            let taken = tester.download(at, &value)?.is_ok();
            let shown = tester.upload(at)?;
            let _ = tester.download(at, &before)?;
            if taken && shown == Ok(value) && tester.upload(at)? == Ok(before) {
                return Ok(Carrier { pdo, id, at, place, held, other });
            }
        }
    }
    inapplicable("no entry that its RPDO carries holds what is written")
}

/// The entry is this.
fn is(tester: &mut Tester, carrier: &Carrier, octets: &[u8], when: &str) -> Course {
    let (got, expected) = (tester.value(carrier.at.index.0, carrier.at.sub.0)?, carrier.of(octets));
    if got == expected {
        return Ok(());
    }
    broken(format!("{when} {} is {}, expected {}", carrier.at, hex(&got), hex(expected)))
}

/// Writes back what was there.
fn back(tester: &mut Tester, carrier: &Carrier) -> Course {
    let held = carrier.of(&carrier.held).to_vec();
    tester.download(carrier.at, &held).map(drop)
}

fn y08(tester: &mut Tester) -> Course {
    let carrier = carrier(tester, 255)?;
    tester.send(carrier.id, &carrier.other)?;
    let taken = is(tester, &carrier, &carrier.other, "after an RPDO");
    tester.send(carrier.id, &carrier.held)?;
    let held = is(tester, &carrier, &carrier.held, "after a second RPDO");
    back(tester, &carrier)?;
    taken.and(held)
}

fn y28(tester: &mut Tester) -> Course {
    let carrier = carrier(tester, 1)?;
    tester.send(carrier.id, &carrier.other)?;
    let before = is(tester, &carrier, &carrier.held, "after an RPDO of type 1 and before SYNC");
    tester.sync()?;
    let after = is(tester, &carrier, &carrier.other, "after an RPDO of type 1 and SYNC");
    tester.send(carrier.id, &carrier.held)?;
    tester.sync()?;
    back(tester, &carrier)?;
    before.and(after)
}

fn y09(tester: &mut Tester) -> Course {
    let carrier = carrier(tester, 255)?;
    tester.leaves_errors();
    let short = carrier.other.get(..carrier.other.len() - 1).unwrap_or_default().to_vec();
    tester.send(carrier.id, &short)?;
    tester.collect(tester.silence())?;
    let held = is(tester, &carrier, &carrier.held, "after an RPDO that is too short");
    back(tester, &carrier)?;
    held
}

fn y29(tester: &mut Tester) -> Course {
    let carrier = carrier(tester, 255)?;
    if carrier.pdo.len() > 7 {
        return inapplicable("its RPDO has eight octets");
    }
    tester.leaves_errors();
    let long = [carrier.other.clone(), vec![0x55]].concat();
    tester.send(carrier.id, &long)?;
    tester.collect(tester.silence())?;
    let taken = is(tester, &carrier, &carrier.other, "after an RPDO with one octet more");
    back(tester, &carrier)?;
    taken
}

fn y30(tester: &mut Tester) -> Course {
    let carrier = carrier(tester, 255)?;
    let wrong = refused_ways(tester, &carrier);
    tester.enter(NmtState::PreOperational)?;
    back(tester, &carrier)?;
    wrong
}

fn refused_ways(tester: &mut Tester, carrier: &Carrier) -> Course {
    if let Ok(extended) = Id::extended(carrier.id.number())
        && let Ok(frame) = Frame::data(extended, &carrier.other)
    {
        tester.wire.send(frame)?;
        is(tester, carrier, &carrier.held, "after a frame with its identifier, of 29 bits,")?;
    }
    tester.request(carrier.id, u8::try_from(carrier.other.len()).unwrap_or(8))?;
    tester.collect(tester.silence())?;
    is(tester, carrier, &carrier.held, "after a remote frame with its identifier")?;
    tester.enter(NmtState::PreOperational)?;
    tester.send(carrier.id, &carrier.other)?;
    is(tester, carrier, &carrier.held, "after an RPDO in PRE-OPERATIONAL")?;
    tester.switch_off(&carrier.pdo)?;
    tester.enter(NmtState::Operational)?;
    tester.send(carrier.id, &carrier.other)?;
    is(tester, carrier, &carrier.held, "after an RPDO whose identifier has bit 31")
}
