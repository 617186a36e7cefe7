//! Stops: what 605Ah to 605Eh choose.

use core::ops::RangeInclusive;
use core::time::Duration;

use super::*;
use crate::can_bus::canopen::NmtState;
use crate::can_bus::cia402::{self, Disabling, FaultReaction, QuickStop, Stop};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Stops of drives",
    rows: &[
        row(
            "N-D21",
            "605Ah, each value: 0 to 4 end in SWITCH ON DISABLED, 5 to 8 in QUICK STOP ACTIVE; at rest, on its ramp",
            "quick stop (02h): 07h, or 40h by 605Ah (eds E-53)",
            &["N-D04", "N-D07"],
            By::Trial(d21),
        ),
        row(
            "N-D22",
            "605Bh, each value: shutdown ends in READY TO SWITCH ON; at rest, on its ramp",
            "605Ah..605Eh if they are there (eds 4)",
            &["N-D03", "N-D07"],
            By::Trial(d22),
        ),
        row(
            "N-D23",
            "605Ch, each value: disable operation ends in SWITCHED ON; at rest, on its ramp",
            "605Ah..605Eh if they are there (eds 4)",
            &["N-D03", "N-D07"],
            By::Trial(d23),
        ),
        row(
            "N-D24",
            "605Dh, each value: halt stays in OPERATION ENABLED, at rest on its ramp with bit 10, and goes on when it is taken back",
            "halt ends at 0 (eds E-56); 605Ah..605Eh if they are there (eds 4)",
            &["N-D03", "N-D07"],
            By::Trial(d24),
        ),
        row(
            "N-D25",
            "605Eh, each value: a fault ends in FAULT, at rest; only an edge of bit 7 leads out, to SWITCH ON DISABLED",
            "605Ah..605Eh if they are there (eds 4); fault reset (eds E-53)",
            &["N-D03", "N-D07"],
            By::Trial(d25),
        ),
    ],
};

/// A way to stop.
struct Way {
    /// The object that chooses.
    option: u16,
    codes: RangeInclusive<i16>,
    stop: fn(i16) -> Option<Stop>,
    /// Has it stop.
    does: fn(&mut Tester) -> Course,
    /// It stands: the state that it must be in.
    ended: fn(&mut Tester, i16) -> Course,
}

fn d21(tester: &mut Tester) -> Course {
    let ended = |tester: &mut Tester, code| {
        if QuickStop::of(code).is_none_or(|option| !option.stays) {
            return comes_to(tester, CORE, 0x40, &format!("after quick stop with 605Ah = {code}"));
        }
        comes_to(tester, STATE, 0x07, &format!("after quick stop with 605Ah = {code}"))?;
        tester.collect(Duration::from_millis(100))?;
        comes_to(tester, STATE, 0x07, &format!("100 ms after quick stop with 605Ah = {code}"))
    };
    let stop = |code| QuickStop::of(code).map(|option| option.stop);
    tried(tester, &Way { option: 0x605A, codes: 0..=8, stop, does: |tester| control(tester, 0x02), ended })
}

fn d22(tester: &mut Tester) -> Course {
    let ended = |tester: &mut Tester, code| {
        comes_to(tester, STATE, 0x21, &format!("after shutdown with 605Bh = {code}"))
    };
    let stop = |code| Disabling::of(code).map(|Disabling(stop)| stop);
    tried(tester, &Way { option: 0x605B, codes: 0..=1, stop, does: |tester| control(tester, 0x06), ended })
}

fn d23(tester: &mut Tester) -> Course {
    let ended = |tester: &mut Tester, code| {
        comes_to(tester, STATE, 0x23, &format!("after disable operation with 605Ch = {code}"))
    };
    let stop = |code| Disabling::of(code).map(|Disabling(stop)| stop);
    tried(tester, &Way { option: 0x605C, codes: 0..=1, stop, does: |tester| control(tester, 0x07), ended })
}

fn d24(tester: &mut Tester) -> Course {
    let ended = |tester: &mut Tester, code| {
        let mask = STATE | TARGET_REACHED;
        comes_to(tester, mask, ENABLED | TARGET_REACHED, &format!("in halt with 605Dh = {code}"))?;
        let turns = offers(tester, 3, &[0x60FF, 0x606C])?;
        control(tester, 0x0F)?;
        if turns { velocity(tester, SPEED, "halt was taken back") } else { Ok(()) }
    };
    let stop = |code| cia402::Halt::of(code).map(|cia402::Halt(stop)| stop);
    tried(tester, &Way { option: 0x605D, codes: 1..=4, stop, does: |tester| control(tester, 0x010F), ended })
}

fn d25(tester: &mut Tester) -> Course {
    let ended = |tester: &mut Tester, code| {
        let when = format!("after a fault with 605Eh = {code}");
        comes_to(tester, CORE, 0x08, &when)?;
        control(tester, 0x06)?;
        tester.collect(Duration::from_millis(50))?;
        comes_to(tester, CORE, 0x08, &format!("{when} and shutdown"))?;
        control(tester, 0x00)?;
        control(tester, 0x80)?;
        comes_to(tester, CORE, 0x40, &format!("{when} and fault reset"))
    };
    let stop = |code| FaultReaction::of(code).map(|FaultReaction(stop)| stop);
    tried(tester, &Way { option: 0x605E, codes: 0..=4, stop, does: fault, ended })
}

/// A fault of the connection: 6007h says that its loss is one, and the node is stopped for a moment.
fn fault(tester: &mut Tester) -> Course {
    tester.enter(NmtState::Stopped)?;
    tester.enter(NmtState::Operational)?;
    let word = tester.number(0x6041, 0)?;
    if word & STATE == ENABLED {
        return inapplicable(
            "it takes the loss of its master (STOPPED) for no fault, and the judge knows no other",
        );
    }
    Ok(())
}

fn tried(tester: &mut Tester, way: &Way) -> Course {
    may_enable(tester)?;
    writable(tester, way.option, 0)?;
    let steps = each(tester, way);
    let _ = tester.download(Address::new(0x60FF, 0), &[0; 4])?;
    over(tester, steps)
}

fn each(tester: &mut Tester, way: &Way) -> Course {
    let mut count = 0;
    if way.option == 0x605E && tester.is_writable(0x6007, 0)? {
        put(tester, 0x6007, 0, 1)?;
    }
    let ramps = if tester.setup.quick && !tester.wire.latency.is_zero() { None } else { ramps(tester)? };
    for code in way.codes.clone() {
        let Some(stop) = (way.stop)(code) else { continue };
        if try_put(tester, way.option, 0, code.into())?.is_err() {
            continue;
        }
        count += 1;
        let turns = turns(tester)?;
        (way.does)(tester)?;
        if turns {
            stands(tester, stop, ramps.as_ref(), &format!("{:04X}h = {code}", way.option))?;
        }
        (way.ended)(tester, code)?;
    }
    if count == 0 {
        inapplicable(format!("it takes no value of CiA 402 for {:04X}h", way.option))
    } else {
        Ok(())
    }
}

/// It comes to rest, as fast as its ramp says.
fn stands(tester: &mut Tester, stop: Stop, ramps: Option<&Duration>, option: &str) -> Course {
    // Without torque friction alone stops it.
    if stop == Stop::Coast {
        return Ok(());
    }
    let took = until(tester, LONG, |tester| Ok(signed(tester, 0x606C)?.abs() <= SPEED / 20))?;
    let (Some(took), Some(slow)) = (took, ramps.copied()) else {
        return if took.is_some() {
            Ok(())
        } else {
            broken(format!("{} s after a stop with {option} it still turns", LONG.as_secs()))
        };
    };
    let late = tester.wire.latency + Duration::from_millis(10);
    let (least, longest, on) = match stop {
        Stop::Coast => return Ok(()),
        Stop::SlowDownRamp => (slow * 6 / 10, slow * 16 / 10, "on the ramp of 6084h"),
        Stop::QuickStopRamp => (Duration::ZERO, slow / 2, "on the ten times steeper ramp of 6085h"),
        Stop::CurrentLimit | Stop::VoltageLimit => (Duration::ZERO, slow * 12 / 10, "at a limit"),
    };
    if took + late < least || took > longest + late {
        let [took, least, longest] = [took, least, longest].map(|time| time.as_millis());
        return broken(format!(
            "a stop with {option} takes {took} ms, expected {least} to {longest} ms {on}"
        ));
    }
    Ok(())
}

/// Sets 6084h to what stops it in a part of a second, 6085h to what stops it ten times faster: how long the slower one
/// takes. `None`: it has no such ramps, or what it has cannot be found. Units of ramps differ: it is measured.
fn ramps(tester: &mut Tester) -> Course<Option<Duration>> {
    if !tester.is_writable(0x6084, 0)? || !tester.is_writable(0x6085, 0)? {
        return Ok(None);
    }
    for value in [2_000, 20_000, 200] {
        let Some(slow) = brakes_in(tester, value)? else { continue };
        if !(Duration::from_millis(200)..Duration::from_millis(1500)).contains(&slow) {
            continue;
        }
        let Some(steeper) = brakes_in(tester, value * 10)? else { return Ok(None) };
        // Times are ramps of some drives.
        let quick = if steeper < slow / 2 { value * 10 } else { value / 10 };
        let set = try_put(tester, 0x6084, 0, value)?.is_ok() && try_put(tester, 0x6085, 0, quick)?.is_ok();
        return Ok(set.then_some(slow));
    }
    Ok(None)
}

/// How long 60FFh = 0 takes with this 6084h; `None`: it turns not, the number is refused, or it takes too long.
fn brakes_in(tester: &mut Tester, value: i32) -> Course<Option<Duration>> {
    if try_put(tester, 0x6084, 0, value)?.is_err() || !turns(tester)? {
        return Ok(None);
    }
    put(tester, 0x60FF, 0, 0)?;
    until(tester, Duration::from_secs(3), |tester| Ok(signed(tester, 0x606C)?.abs() <= SPEED / 20))
}
