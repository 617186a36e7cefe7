//! Limits of speed, position, following error and torque.

use core::time::Duration;

use super::modes::TORQUE;
use super::*;
use crate::judge::requirement::Confidence::{B, U};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Limits of drives",
    rows: &[
        sure(
            row(
                "N-D26",
                "607Fh: profile velocity is no faster, whatever 60FFh says",
                "motion with 607Fh (eds 4)",
                &["N-D07"],
                By::Trial(d26),
            ),
            B,
        ),
        sure(
            row(
                "N-D27",
                "6080h: half of it halves the highest speed",
                "max motor speed",
                &["N-D07"],
                By::Trial(d27),
            ),
            B,
        ),
        row(
            "N-D28",
            "607Dh: profile position goes no further, on either side",
            "607Dh limits: target beyond is clipped or refused, bit 11; both 0 = none (eds E-59)",
            &["N-D08"],
            By::Trial(d28),
        ),
        sure(
            row(
                "N-D29",
                "607Dh: profile velocity goes no further",
                "607Dh limits (eds E-59); other modes than pp: devices differ",
                &["N-D07"],
                By::Trial(d29),
            ),
            U,
        ),
        sure(
            row(
                "N-D30",
                "6065h: a following error beyond it for longer than 6066h sets bit 13 or is a fault, and else does not",
                "following error: |60F4h| > 6065h for 6066h ms: bit 13",
                &["N-D08"],
                By::Trial(d30),
            ),
            B,
        ),
        sure(
            row(
                "N-D31",
                "6072h: 6077h is no larger, whatever 6071h says",
                "max torque",
                &["N-D11"],
                By::Trial(d31),
            ),
            B,
        ),
    ],
};

fn d26(tester: &mut Tester) -> Course {
    in_mode(tester, 3, &[0x60FF, 0x606C])?;
    writable(tester, 0x607F, 0)?;
    let limit = SPEED / 2;
    let Ok(()) = try_put(tester, 0x607F, 0, limit)? else {
        return inapplicable(format!("607Fh does not take {limit}"));
    };
    let steps = enabled(tester).and_then(|()| {
        if try_put(tester, 0x60FF, 0, SPEED)?.is_err() {
            return Ok(());
        }
        let speed = most(tester, 0x606C, Duration::from_millis(500))?;
        if speed > limit + limit / 5 {
            return broken(format!("607Fh is {limit}, and 606Ch is {speed}"));
        }
        Ok(())
    });
    let _ = tester.download(Address::new(0x60FF, 0), &[0; 4])?;
    over(tester, steps)
}

fn d27(tester: &mut Tester) -> Course {
    in_mode(tester, 3, &[0x60FF, 0x606C])?;
    writable(tester, 0x6080, 0)?;
    // Turns in a minute.
    let limit = 60;
    let Ok(()) = try_put(tester, 0x6080, 0, limit)? else {
        return inapplicable(format!("6080h does not take {limit}"));
    };
    let steps = enabled(tester).and_then(|()| {
        let (mut target, mut speed) = (SPEED, SPEED);
        while speed > target * 9 / 10 {
            target = target.saturating_mul(4);
            if target > 1 << 28 || try_put(tester, 0x60FF, 0, target)?.is_err() {
                return inapplicable("60FFh takes no speed that 6080h = 60 holds back");
            }
            speed = settled(tester)?;
        }
        put(tester, 0x6080, 0, limit / 2)?;
        let half = settled(tester)?;
        if (half - speed / 2).abs() > speed / 20 {
            return broken(format!(
                "606Ch is {speed} with 6080h = {limit}, and {half} with 6080h = {}",
                limit / 2
            ));
        }
        Ok(())
    });
    let _ = tester.download(Address::new(0x60FF, 0), &[0; 4])?;
    over(tester, steps)
}

/// The speed that does not change any more.
fn settled(tester: &mut Tester) -> Course<i32> {
    let mut before = i32::MIN;
    for _ in 0..30 {
        tester.collect(Duration::from_millis(100))?;
        let speed = signed(tester, 0x606C)?;
        if (i64::from(speed) - i64::from(before)).abs() <= i64::from(speed.abs() / 100) {
            return Ok(speed);
        }
        before = speed;
    }
    Ok(before)
}

/// How far the limits of the position are from where it stands, and how far beyond them rows want to go.
const ROOM: i32 = 200;
const BEYOND: i32 = 1000;
/// A drive stops behind its limit by a bit.
const OVERRUN: i32 = 20;

/// Sets 607Dh around where it stands.
fn limits_around(tester: &mut Tester) -> Course<i32> {
    writable(tester, 0x607D, 1)?;
    writable(tester, 0x607D, 2)?;
    let from = signed(tester, 0x6064)?;
    let (low, high) = ((1, from - ROOM), (2, from + ROOM));
    // No step of it may have the limits the wrong way round.
    for (sub, limit) in if from > 0 { [high, low] } else { [low, high] } {
        if let Err(code) = try_put(tester, 0x607D, sub, limit)? {
            return inapplicable(format!("607Dh:{sub:02} does not take {limit}: {}", refused(code)));
        }
    }
    Ok(from)
}

/// The position is beyond no limit.
fn within(tester: &mut Tester, from: i32, what: &str) -> Course {
    let mut position = from;
    let time = Duration::from_millis(if tester.setup.quick { 600 } else { 1500 });
    let passed = until(tester, time, |tester| {
        position = signed(tester, 0x6064)?;
        Ok((position - from).abs() > ROOM + OVERRUN)
    })?;
    match passed {
        None => Ok(()),
        Some(_) => {
            broken(format!("{what}: 607Dh is {} to {}, and 6064h is {position}", from - ROOM, from + ROOM))
        }
    }
}

fn d28(tester: &mut Tester) -> Course {
    in_mode(tester, 1, &[0x607A, 0x6064])?;
    let from = limits_around(tester)?;
    if tester.number_if(0x6081, 0)? == Some(0) {
        put(tester, 0x6081, 0, SPEED)?;
    }
    for target in [from + BEYOND, from - BEYOND] {
        let steps = enabled(tester).and_then(|()| {
            if try_put(tester, 0x607A, 0, target)?.is_err() {
                return Ok(());
            }
            control(tester, 0x3F)?;
            within(tester, from, &format!("607Ah is {target}"))
        });
        over(tester, steps)?;
    }
    Ok(())
}

fn d29(tester: &mut Tester) -> Course {
    in_mode(tester, 3, &[0x60FF, 0x606C, 0x6064])?;
    let from = limits_around(tester)?;
    let steps = enabled(tester).and_then(|()| {
        if try_put(tester, 0x60FF, 0, SPEED)?.is_err() {
            return Ok(());
        }
        within(tester, from, "60FFh is 1000")
    });
    let _ = tester.download(Address::new(0x60FF, 0), &[0; 4])?;
    over(tester, steps)
}

/// A travel with this window and time out: the largest following error, and whether it was taken for one.
fn follow(tester: &mut Tester, window: i32, time_out: i32) -> Course<(i32, bool)> {
    const FAR: i32 = 5000;
    put(tester, 0x6065, 0, window)?;
    if tester.is_writable(0x6066, 0)? {
        put(tester, 0x6066, 0, time_out)?;
    }
    off(tester)?;
    enabled(tester)?;
    let target = signed(tester, 0x6064)?.saturating_add(FAR);
    put(tester, 0x607A, 0, target)?;
    control(tester, 0x1F)?;
    let (mut largest, mut is_error) = (0, false);
    let time = Duration::from_millis(if tester.setup.quick { 400 } else { 1000 });
    until(tester, time, |tester| {
        largest = signed(tester, 0x60F4)?.saturating_abs().max(largest);
        let word = tester.number(0x6041, 0)?;
        is_error = word & 0x2000 != 0 || [0x08, 0x0F].contains(&(word & CORE));
        Ok(is_error || word & TARGET_REACHED != 0)
    })?;
    Ok((largest, is_error))
}

fn d30(tester: &mut Tester) -> Course {
    in_mode(tester, 1, &[0x607A, 0x6064, 0x60F4])?;
    writable(tester, 0x6065, 0)?;
    // With hardly any torque it cannot follow.
    if tester.is_writable(0x6072, 0)? {
        let _ = try_put(tester, 0x6072, 0, 10)?;
    }
    let steps = supervised(tester);
    over(tester, steps)
}

fn supervised(tester: &mut Tester) -> Course {
    let (largest, is_error) = follow(tester, i32::MAX, 0)?;
    if is_error {
        return broken("6065h is 7FFFFFFFh, and a travel ends with a following error");
    }
    if largest < 10 {
        return inapplicable("it follows so well that 6065h cannot be tried");
    }
    let window = largest / 2;
    if !follow(tester, window, 0)?.1 {
        return broken(format!("6065h is {window}, and a following error of {largest} is taken for none"));
    }
    if tester.is_writable(0x6066, 0)? && follow(tester, window, 60_000)?.1 {
        return broken("6066h is 60000 ms, and a following error of less than a second is taken for one");
    }
    Ok(())
}

fn d31(tester: &mut Tester) -> Course {
    in_mode(tester, 4, &[0x6071, 0x6077])?;
    writable(tester, 0x6072, 0)?;
    let Ok(()) = try_put(tester, 0x6072, 0, TORQUE)? else {
        return inapplicable(format!("6072h does not take {TORQUE}"));
    };
    let steps = enabled(tester).and_then(|()| {
        if try_put(tester, 0x6071, 0, TORQUE * 3)?.is_err() {
            return Ok(());
        }
        let torque = most(tester, 0x6077, Duration::from_millis(200))?;
        put(tester, 0x6071, 0, 0)?;
        if torque > TORQUE * 3 / 2 {
            return broken(format!("6072h is {TORQUE}, and 6077h is {torque}"));
        }
        Ok(())
    });
    over(tester, steps)
}
