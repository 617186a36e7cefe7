//! Modes of operation, and what a profile of each does.

use core::time::Duration;

use super::*;
use crate::can_bus::cia402::Mode;
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Modes of drives",
    rows: &[
        sure(
            row(
                "N-D06",
                "each mode of 6502h can be set and 6061h follows; others are refused or leave 6061h as it is",
                "6060h write, 6061h follows; a mode that it lacks is refused (eds E-54)",
                &["N-O01"],
                By::Trial(d06),
            ),
            B,
        ),
        row(
            "N-D07",
            "profile velocity: 606Ch comes to 60FFh, and to 0 with halt",
            "606Ch reaches 60FFh; halt ends at 0 (eds E-56)",
            &["N-D03", "N-D06"],
            By::Trial(d07),
        ),
        row(
            "N-D08",
            "profile position: the set-point is acknowledged, the target reached",
            "new set-point acknowledged (bit 12), target reached (bit 10), 6064h = target (eds E-55)",
            &["N-D03", "N-D06"],
            By::Trial(d08),
        ),
        row(
            "N-D10",
            "profile position, relative: two set-points of 100 end 200 further",
            "relative (bit 6) (eds E-55)",
            &["N-D08"],
            By::Trial(d10),
        ),
        sure(
            row(
                "N-D11",
                "profile torque: 6077h comes to 6071h, and to 0 with it",
                "modes of 6502h: 6071h tq (eds 4)",
                &["N-D03", "N-D06"],
                By::Trial(d11),
            ),
            B,
        ),
        row(
            "N-D12",
            "velocity mode of frequency converters: 6044h comes to 6042h with bits 4 to 6, and to 0 without bit 6",
            "modes of 6502h: 6042h vl (eds 4)",
            &["N-D03", "N-D06"],
            By::Trial(d12),
        ),
    ],
};

fn d06(tester: &mut Tester) -> Course {
    a_drive(tester)?;
    tester.may_move()?;
    if !tester.has(0x6502, 0)? || !tester.has(0x6060, 0)? || !tester.has(0x6061, 0)? {
        return inapplicable("it lacks 6502h, 6060h or 6061h");
    }
    let modes = tester.number(0x6502, 0)?;
    if modes & 0x3FF == 0 {
        return inapplicable("6502h names no mode");
    }
    for mode in (1..=10).filter(|code| Mode::of(*code).is_some()) {
        let shown_of = u64::from(mode.cast_unsigned());
        let offered = modes >> (mode - 1) & 1 == 1;
        let taken = tester.try_set(0x6060, 0, &mode.to_le_bytes())?;
        tester.collect(Duration::from_millis(if tester.setup.quick { 30 } else { 100 }))?;
        let shown = tester.number(0x6061, 0)?;
        match (offered, taken) {
            (true, Err(code)) => {
                return broken(format!(
                    "6502h offers mode {mode}, and 6060h refuses it with {}",
                    refused(code)
                ));
            }
            (true, Ok(())) if shown != shown_of => {
                return broken(format!("6060h = {mode}, and 6061h is {shown}"));
            }
            (false, Ok(())) if shown == shown_of => {
                return broken(format!("6502h does not offer mode {mode}, and 6061h shows it"));
            }
            (true | false, Ok(())) | (false, Err(_)) => {}
        }
    }
    Ok(())
}

fn d07(tester: &mut Tester) -> Course {
    in_mode(tester, 3, &[0x60FF, 0x606C])?;
    let steps = turn(tester);
    let _ = tester.download(Address::new(0x60FF, 0), &[0; 4])?;
    over(tester, steps)
}

fn turn(tester: &mut Tester) -> Course {
    // Some drives forget it when they are enabled.
    enabled(tester)?;
    tester.set(0x60FF, 0, &SPEED.to_le_bytes())?;
    velocity(tester, SPEED, "60FFh = 1000")?;
    control(tester, 0x010F)?;
    velocity(tester, 0, "halt")
}

fn d08(tester: &mut Tester) -> Course {
    in_mode(tester, 1, &[0x607A, 0x6064])?;
    let steps = travel(tester, 0x0F, 1);
    over(tester, steps)
}

fn d10(tester: &mut Tester) -> Course {
    in_mode(tester, 1, &[0x607A, 0x6064])?;
    let steps = travel(tester, 0x4F, 2);
    over(tester, steps)
}

/// How far a set-point is from the last one.
const WAY: i32 = 100;

/// So many ways, one after the other. `word`: what the control word has beside the new set-point.
fn travel(tester: &mut Tester, word: u16, count: i32) -> Course {
    const RELATIVE: u16 = 1 << 6;
    let from = signed(tester, 0x6064)?;
    if tester.number_if(0x6081, 0)? == Some(0) {
        tester.set(0x6081, 0, &SPEED.to_le_bytes())?;
    }
    enabled(tester)?;
    for number in 1..=count {
        let target = from.saturating_add(WAY * number);
        put(tester, 0x607A, 0, if word & RELATIVE == 0 { target } else { WAY })?;
        control(tester, word | 0x10)?;
        comes_to(tester, 0x1000, 0x1000, "after a new set-point")?;
        control(tester, word)?;
        comes_to(tester, 0x1000, 0, "after the set-point was taken back")?;
        let limit = LONG * 2;
        let reached =
            until(tester, limit, |tester| Ok(tester.number(0x6041, 0)? & TARGET_REACHED != 0))?.is_some();
        if !reached {
            return broken(format!(
                "target reached (6041h bit 10) does not come within {} s",
                limit.as_secs()
            ));
        }
        let position = signed(tester, 0x6064)?;
        if (position - target).abs() > 10 {
            return broken(format!("the target is {target}, and 6064h is {position}"));
        }
    }
    Ok(())
}

/// Target and tolerance of torques, in thousandths of the rated one.
pub(super) const TORQUE: i32 = 50;
pub(super) const NEARLY: i32 = 20;

fn d11(tester: &mut Tester) -> Course {
    in_mode(tester, 4, &[0x6071, 0x6077])?;
    let steps = enabled(tester).and_then(|()| {
        for torque in [TORQUE, 0] {
            put(tester, 0x6071, 0, torque)?;
            comes_near(tester, 0x6077, torque, NEARLY, &format!("6071h = {torque}"))?;
        }
        Ok(())
    });
    over(tester, steps)
}

/// An actual value comes to this.
fn comes_near(tester: &mut Tester, index: u16, wanted: i32, off: i32, when: &str) -> Course {
    let mut got = 0;
    let came = until(tester, PATIENCE, |tester| {
        got = signed(tester, index)?;
        Ok((got - wanted).abs() <= off)
    })?;
    match came {
        Some(_) => Ok(()),
        None => broken(format!("{} s after {when} {index:04X}h is {got}", PATIENCE.as_secs())),
    }
}

fn d12(tester: &mut Tester) -> Course {
    in_mode(tester, 2, &[0x6042, 0x6044])?;
    let rpm = 60;
    let steps = enabled(tester).and_then(|()| {
        put(tester, 0x6042, 0, rpm)?;
        control(tester, 0x7F)?;
        comes_near(tester, 0x6044, rpm, 5, "6042h = 60 with bits 4 to 6 of 6040h")?;
        control(tester, 0x3F)?;
        comes_near(tester, 0x6044, 0, 5, "bit 6 of 6040h was taken back")
    });
    over(tester, steps)
}
