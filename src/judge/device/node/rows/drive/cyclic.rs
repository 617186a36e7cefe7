//! Cyclic modes: a set-point in an RPDO with each SYNC.

use core::ops::Range;
use core::time::Duration;

use super::modes::{NEARLY, TORQUE};
use super::*;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::NmtState;
use crate::judge::device::node::pdo::{Pdo, Way};
use crate::judge::requirement::Confidence::{B, U};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Cyclic modes of drives",
    rows: &[
        sure(
            row(
                "N-D13",
                "cyclic position: 6064h follows 607Ah with each SYNC, and not before; bit 12 of 6041h is 1",
                "csp, csv: each SYNC or RPDO is followed (eds E-58)",
                &["N-D03", "N-D06"],
                By::Trial(d13),
            ),
            B,
        ),
        sure(
            row(
                "N-D14",
                "cyclic position: from one set-point to the next in a straight line, over the time of 60C2h",
                "60C2h is the time from set-point to set-point (eds E-58)",
                &["N-D13"],
                By::Trial(d14),
            ),
            U,
        ),
        sure(
            row(
                "N-D15",
                "cyclic velocity: 606Ch follows 60FFh with each SYNC, and not before; bit 12 of 6041h is 1",
                "csp, csv: each SYNC or RPDO is followed (eds E-58)",
                &["N-D07"],
                By::Trial(d15),
            ),
            B,
        ),
        sure(
            row(
                "N-D16",
                "cyclic torque: 6077h follows 6071h with each SYNC, and not before; bit 12 of 6041h is 1",
                "modes of 6502h: cst (eds 4)",
                &["N-D11"],
                By::Trial(d16),
            ),
            B,
        ),
        sure(
            row(
                "N-D32",
                "interpolated position: with bit 4 of 6040h, and not without, bit 12 of 6041h is 1 and 6064h follows 60C1h:1 with each SYNC",
                "modes of 6502h: 60C1h ip (eds 4)",
                &["N-D03", "N-D06"],
                By::Trial(d32),
            ),
            U,
        ),
    ],
};

/// A cyclic mode and how it is tried.
struct Cycle {
    mode: u8,
    /// What is sent, and what follows it.
    target: u16,
    sub: u8,
    actual: u16,
    /// What the control word has beside Enable operation.
    word: u16,
    /// From set-point to set-point.
    step: i32,
    count: i32,
    tolerance: i32,
}

const POSITION: Cycle =
    Cycle { mode: 8, target: 0x607A, sub: 0, actual: 0x6064, word: 0, step: 20, count: 40, tolerance: 10 };
/// Bit 4 starts it.
const INTERPOLATED: Cycle = Cycle { mode: 7, target: 0x60C1, sub: 1, word: 0x10, ..POSITION };
const VELOCITY: Cycle = Cycle {
    mode: 9,
    target: 0x60FF,
    actual: 0x606C,
    step: SPEED / 10,
    count: 10,
    tolerance: SPEED / 20,
    ..POSITION
};
const CYCLIC_TORQUE: Cycle =
    Cycle { mode: 10, target: 0x6071, actual: 0x6077, step: TORQUE, count: 1, tolerance: NEARLY, ..POSITION };

impl Cycle {
    const fn is_of_positions(&self) -> bool {
        self.actual == 0x6064
    }
}

/// An RPDO of type 1 with a set-point in it.
struct Carrier {
    pdo: Pdo,
    id: Id,
    octets: Vec<u8>,
    place: Range<usize>,
}

impl Carrier {
    fn send(&mut self, tester: &mut Tester, number: i32) -> Course {
        if let Some(place) = self.octets.get_mut(self.place.clone()) {
            place.iter_mut().zip(number.to_le_bytes()).for_each(|(to, octet)| *to = octet);
        }
        tester.send(self.id, &self.octets)
    }

    /// A set-point with its SYNC, and the rest of the cycle.
    fn cycle(&mut self, tester: &mut Tester, number: i32, time: Duration) -> Course {
        let end = tester.wire.now().saturating_add(time);
        self.send(tester, number)?;
        tester.sync()?;
        tester.collect(end.saturating_since(tester.wire.now())).map(drop)
    }
}

/// The RPDO for an object: one that maps it, or one that is mapped so.
fn carrier(tester: &mut Tester, target: Address) -> Course<Carrier> {
    let (index, sub) = (target.index.0, target.sub.0);
    let bits = tester.value(index, sub)?.len() * 8;
    let entry = u32::from(index) << 16 | u32::from(sub) << 8 | u32::try_from(bits).unwrap_or_default();
    let pdos = tester.pdos(Way::Received)?;
    let maps = pdos.iter().find(|pdo| pdo.entries.contains(&entry)).cloned();
    let pdo = match maps {
        Some(pdo) => pdo,
        None => {
            let mut mapped = None;
            for pdo in pdos {
                if tester.is_writable(pdo.mapping(), 0)? && tester.maps(&pdo, entry)? {
                    mapped = Some(pdo.of(entry));
                    break;
                }
            }
            match mapped {
                Some(pdo) => pdo,
                None => return inapplicable(format!("none of its RPDOs maps {index:04X}h, or can")),
            }
        }
    };
    let id = tester.switch_on(&pdo, 1)?;
    let octets = tester.shown_by_sdo(&pdo)?;
    let place = pdo.places().unwrap_or_default().into_iter().find(|(at, _)| *at == target);
    match (octets, place) {
        (Some(octets), Some((_, place))) => Ok(Carrier { pdo, id, octets, place }),
        (_, _) => inapplicable(format!("its RPDO with {index:04X}h maps what cannot be read")),
    }
}

/// Sets 60C2h to so many ms, if it is there: the time that it has then.
fn cycle_time(tester: &mut Tester, millis: u8) -> Course<Option<Duration>> {
    if !tester.is_writable(0x60C2, 1)? {
        return Ok(None);
    }
    let exponent = tester.number_if(0x60C2, 2)?.unwrap_or(0xFD);
    let taken = exponent == 0xFD || try_put(tester, 0x60C2, 2, -3)?.is_ok();
    let taken = taken && try_put(tester, 0x60C2, 1, millis.into())?.is_ok();
    Ok(taken.then(|| Duration::from_millis(millis.into())))
}

/// Enabled in that mode, with an RPDO for its set-points, and where it begins.
fn begun(tester: &mut Tester, cycle: &Cycle) -> Course<(Carrier, i32)> {
    a_drive(tester)?;
    tester.may_move()?;
    if !offers(tester, cycle.mode, &[cycle.target, cycle.actual])? {
        return inapplicable(format!("6502h does not offer mode {}", cycle.mode));
    }
    tester.enter(NmtState::PreOperational)?;
    if cycle.is_of_positions() && tester.value(cycle.target, cycle.sub)?.len() != 4 {
        return inapplicable(format!("{:04X}h:{} is no position of 32 bits", cycle.target, cycle.sub));
    }
    let mut carrier = carrier(tester, Address::new(cycle.target, cycle.sub))?;
    in_mode(tester, cycle.mode, &[])?;
    let from = if cycle.is_of_positions() { signed(tester, cycle.actual)? } else { 0 };
    put(tester, cycle.target, cycle.sub, from)?;
    enabled(tester)?;
    if cycle.word != 0 {
        let word = tester.number(0x6041, 0)?;
        if word & 0x1000 != 0 {
            let why = format!("6041h is {word:04X}h without bit 4 of 6040h, expected bit 12 = 0");
            over(tester, broken(why))?;
        }
        control(tester, 0x0F | cycle.word)?;
    }
    // A control word beside the set-point is that of an enabled drive now.
    if let Some(octets) = tester.shown_by_sdo(&carrier.pdo)? {
        carrier.octets = octets;
    }
    for _ in 0..3 {
        carrier.cycle(tester, from, CYCLE)?;
    }
    Ok((carrier, from))
}

const CYCLE: Duration = Duration::from_millis(10);

/// What is followed with each SYNC.
fn follows(tester: &mut Tester, cycle: &Cycle) -> Course {
    // A drive without it, or with another time in it, follows the cycle that comes.
    cycle_time(tester, 10)?;
    let (mut carrier, from) = begun(tester, cycle)?;
    let (target, actual) = (cycle.target, cycle.actual);
    let steps = (|| {
        let mut to = from;
        for _ in 0..cycle.count {
            to = to.saturating_add(cycle.step);
            carrier.cycle(tester, to, CYCLE)?;
        }
        let off = still(tester, &mut carrier, actual, to)?;
        if off > cycle.tolerance {
            return broken(format!(
                "{target:04X}h came to {to} with a SYNC each 10 ms, and {actual:04X}h is {off} off"
            ));
        }
        if tester.number(0x6041, 0)? & 0x1000 == 0 {
            return broken("bit 12 of 6041h is 0: the drive does not follow the command");
        }
        // Without its SYNC a drive may end an interpolation.
        if cycle.word != 0 {
            return Ok(());
        }
        let beyond = to.saturating_sub(2 * cycle.step);
        let before = signed(tester, actual)?;
        carrier.send(tester, beyond)?;
        let early = tester.collect(CYCLE * 5).and_then(|_| signed(tester, actual))?;
        if (early - before).abs() > cycle.tolerance {
            return broken(format!(
                "a set-point of {target:04X}h acts before its SYNC: {actual:04X}h went from {before} to {early}"
            ));
        }
        let off = still(tester, &mut carrier, actual, beyond)?;
        if off > cycle.tolerance {
            return broken(format!(
                "{target:04X}h is {beyond}, and {actual:04X}h is {off} off after 10 SYNCs"
            ));
        }
        Ok(())
    })();
    let rest = if cycle.is_of_positions() { signed(tester, actual) } else { Ok(0) };
    if let Ok(rest) = rest {
        carrier.cycle(tester, rest, CYCLE)?;
    }
    over(tester, steps)
}

/// How far the actual value is off after some cycles with the same set-point.
fn still(tester: &mut Tester, carrier: &mut Carrier, actual: u16, to: i32) -> Course<i32> {
    for _ in 0..10 {
        carrier.cycle(tester, to, CYCLE)?;
    }
    Ok((signed(tester, actual)? - to).abs())
}

fn d13(tester: &mut Tester) -> Course {
    follows(tester, &POSITION)
}

fn d14(tester: &mut Tester) -> Course {
    const WAY: i32 = 100;
    let time = Duration::from_millis(100);
    a_drive(tester)?;
    tester.may_move()?;
    if !offers(tester, POSITION.mode, &[])? || cycle_time(tester, 100)?.is_none() {
        return inapplicable("it has no mode 8, or 60C2h does not take 100 ms");
    }
    let (mut carrier, from) = begun(tester, &POSITION)?;
    let mut to = from;
    let steps = (|| {
        for number in 1..=4 {
            to = to.saturating_add(WAY);
            carrier.send(tester, to)?;
            tester.sync()?;
            let begun = tester.wire.now();
            tester.collect(time / 2)?;
            let left = to - signed(tester, 0x6064)?;
            tester.collect(begun.saturating_add(time).saturating_since(tester.wire.now()))?;
            // The first is where the cycle is not known yet.
            if number > 1 && !(WAY / 5..=WAY * 6 / 5).contains(&left) {
                return broken(format!("half of 60C2h after a SYNC 6064h has {left} of {WAY} left"));
            }
        }
        Ok(())
    })();
    over(tester, steps)
}

fn d15(tester: &mut Tester) -> Course {
    follows(tester, &VELOCITY)
}

fn d16(tester: &mut Tester) -> Course {
    follows(tester, &CYCLIC_TORQUE)
}

fn d32(tester: &mut Tester) -> Course {
    follows(tester, &INTERPOLATED)
}
