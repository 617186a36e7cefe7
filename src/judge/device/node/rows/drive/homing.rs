//! Homing: the methods of 6098h.

use core::time::Duration;

use super::*;
use crate::can_bus::canopen::value::ValueKind;
use crate::eds::Limit;
use crate::judge::requirement::Confidence::{B, U};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Homing of drives",
    rows: &[
        row(
            "N-D17",
            "methods 35 and 37: attained (bits 12 and 10, not 13), and 6064h is 607Ch",
            "hm method 35/37: bit 12 attained, 6064h = 607Ch (eds E-57)",
            &["N-D03", "N-D06"],
            By::Trial(d17),
        ),
        row(
            "N-D18",
            "each method that 60E3h or the limits of 6098h offer ends at rest with bit 12 or with bit 13, never with both",
            "17/18 end too (eds E-57)",
            &["N-D07", "N-D17"],
            By::Trial(d18),
        ),
        sure(
            row(
                "N-D19",
                "a method of 60E3h is taken by 6098h, and another one is not, or ends with bit 13",
                "60E3h: supported homing methods",
                &["N-D17"],
                By::Trial(d19),
            ),
            B,
        ),
        sure(
            row(
                "N-D20",
                "a homing whose bit 4 is taken back stops, and is not attained",
                "start by bit 4; 1 to 0 interrupts; devices differ",
                &["N-D07", "N-D17"],
                By::Trial(d20),
            ),
            U,
        ),
    ],
};

const ATTAINED: u64 = 1 << 12;
const ERROR: u64 = 1 << 13;
/// Methods that turn nothing.
const HERE: [i32; 2] = [35, 37];
/// Methods of CiA 402; 15, 16, 31 and 32 are reserved.
const METHODS: [(i32, i32); 4] = [(1, 14), (17, 30), (33, 35), (37, 37)];
/// A method that has not ended then is stopped.
const LONGEST: Duration = Duration::from_secs(30);
/// The same on a bus, where they have so long together, so that not the first one alone is tried.
const LONGEST_ON_A_BUS: Duration = Duration::from_secs(4);
const ALL: Duration = Duration::from_secs(8);

fn is_method(number: i32) -> bool {
    METHODS.iter().any(|(first, last)| (*first..=*last).contains(&number))
}

/// The methods of 60E3h; none without it.
fn listed(tester: &mut Tester) -> Course<Vec<i32>> {
    let mut methods = Vec::new();
    let count = tester.number_if(0x60E3, 0)?.unwrap_or_default();
    for sub in 1..=u8::try_from(count).unwrap_or_default() {
        let Some(method) = tester.number_if(0x60E3, sub)? else { continue };
        let [method, ..] = method.to_le_bytes();
        methods.push(i32::from(method.cast_signed()));
    }
    methods.retain(|method| *method != 0);
    Ok(methods)
}

/// The methods that 60E3h names, else those of CiA 402 within the limits of 6098h.
fn offered(tester: &mut Tester) -> Course<Vec<i32>> {
    let listed = listed(tester)?;
    if !listed.is_empty() {
        return Ok(listed);
    }
    let node = tester.node();
    let entry = tester.setup.eds.as_ref().and_then(|eds| eds.entry(0x6098, 0));
    let bound = |limit: Option<&Limit>, otherwise: i128| match limit {
        Some(Limit::Whole(number)) => number.at(node),
        Some(Limit::Real(_)) | None => otherwise,
    };
    let low = bound(entry.and_then(|entry| entry.low.as_ref()), i128::MIN);
    let mut high = bound(entry.and_then(|entry| entry.high.as_ref()), i128::MAX);
    // Some sheets have the limits of the type without its sign.
    if high < low && entry.is_some_and(|entry| entry.data.kind() == ValueKind::Signed) {
        high = i128::MAX;
    }
    Ok((1..=37).filter(|method| is_method(*method) && (low..=high).contains(&i128::from(*method))).collect())
}

fn in_homing(tester: &mut Tester) -> Course {
    in_mode(tester, 6, &[0x6098])?;
    writable(tester, 0x6098, 0)
}

fn d17(tester: &mut Tester) -> Course {
    in_homing(tester)?;
    let offered = offered(tester)?;
    let methods: Vec<i32> = HERE.into_iter().filter(|method| offered.contains(method)).collect();
    let steps = at_once(tester, &methods);
    over(tester, steps)
}

fn at_once(tester: &mut Tester, methods: &[i32]) -> Course {
    let mut tried = 0;
    for method in methods {
        if try_put(tester, 0x6098, 0, *method)?.is_err() {
            continue;
        }
        tried += 1;
        let offset = if tester.is_writable(0x607C, 0)? && try_put(tester, 0x607C, 0, 1234 + tried)?.is_ok() {
            1234 + tried
        } else if tester.has(0x607C, 0)? {
            signed(tester, 0x607C)?
        } else {
            0
        };
        enabled(tester)?;
        control(tester, 0x1F)?;
        let bits = ATTAINED | ERROR | TARGET_REACHED;
        comes_to(tester, bits, ATTAINED | TARGET_REACHED, &format!("after homing by method {method}"))?;
        if tester.has(0x6064, 0)? {
            let position = signed(tester, 0x6064)?;
            if (position - offset).abs() > 10 {
                return broken(format!(
                    "after homing by method {method} 6064h is {position}, and 607Ch is {offset}"
                ));
            }
        }
        off(tester)?;
    }
    if tried == 0 { inapplicable("it has neither method 35 nor 37") } else { Ok(()) }
}

fn d18(tester: &mut Tester) -> Course {
    in_homing(tester)?;
    let mut methods = offered(tester)?;
    methods.retain(|method| !HERE.contains(method));
    if methods.is_empty() {
        return inapplicable("it has no method that turns anything");
    }
    let begun = tester.wire.now();
    let all = match (tester.wire.latency.is_zero(), tester.setup.quick) {
        (true, _) => Duration::MAX,
        (false, true) => ALL / 6,
        (false, false) => ALL,
    };
    let longest = if tester.wire.latency.is_zero() { LONGEST } else { LONGEST_ON_A_BUS };
    let longest = if tester.setup.quick { longest / 10 } else { longest };
    for method in methods {
        let left = all.saturating_sub(tester.wire.now().saturating_since(begun));
        if left.is_zero() {
            break;
        }
        if try_put(tester, 0x6098, 0, method)?.is_ok() {
            let steps = enabled(tester).and_then(|()| ends(tester, method, longest.min(left)));
            over(tester, steps)?;
        }
    }
    Ok(())
}

/// A homing ends at rest, by one of its two bits, or nothing is said of it: its switch may be far away.
fn ends(tester: &mut Tester, method: i32, limit: Duration) -> Course {
    control(tester, 0x1F)?;
    let mut word = 0;
    let ended = until(tester, limit, |tester| {
        word = tester.number(0x6041, 0)?;
        Ok(word & (ATTAINED | ERROR) != 0 && word & TARGET_REACHED != 0)
    })?;
    if word & ATTAINED != 0 && word & ERROR != 0 {
        return broken(format!("homing by method {method} is attained and wrong: 6041h is {word:04X}h"));
    }
    if word & CORE != ENABLED & CORE {
        return broken(format!("homing by method {method} ends the operation: 6041h is {word:04X}h"));
    }
    if ended.is_none() || !tester.has(0x606C, 0)? {
        return Ok(());
    }
    let speed = most(tester, 0x606C, Duration::from_millis(20))?;
    if speed > SPEED / 20 {
        return broken(format!("homing by method {method} has ended, and 606Ch is {speed}"));
    }
    Ok(())
}

fn d19(tester: &mut Tester) -> Course {
    in_homing(tester)?;
    let listed = listed(tester)?;
    if listed.is_empty() {
        return inapplicable("it has no 60E3h");
    }
    for method in &listed {
        if let Err(code) = try_put(tester, 0x6098, 0, *method)? {
            return broken(format!(
                "60E3h names method {method}, and 6098h refuses it with {}",
                refused(code)
            ));
        }
    }
    let others: Vec<i32> = (1..=37).filter(|method| !listed.contains(method)).take(3).collect();
    let steps = enabled(tester).and_then(|()| {
        for method in others {
            if try_put(tester, 0x6098, 0, method)?.is_err() {
                continue;
            }
            control(tester, 0x1F)?;
            let what = format!("after a homing by method {method}, which 60E3h does not name,");
            comes_to(tester, ATTAINED | ERROR, ERROR, &what)?;
            control(tester, 0x0F)?;
        }
        Ok(())
    });
    over(tester, steps)
}

fn d20(tester: &mut Tester) -> Course {
    in_homing(tester)?;
    if !tester.has(0x606C, 0)? {
        return inapplicable("it lacks 606Ch");
    }
    let offered = offered(tester)?;
    // Those without a switch of its own first.
    let methods = [33, 34, 17, 18, 1, 2].into_iter().filter(|method| offered.contains(method));
    let steps = enabled(tester).and_then(|()| {
        for method in methods {
            if try_put(tester, 0x6098, 0, method)?.is_err() {
                continue;
            }
            control(tester, 0x1F)?;
            let speed = most(tester, 0x606C, Duration::from_millis(100))?;
            let word = tester.number(0x6041, 0)?;
            control(tester, 0x0F)?;
            if word & (ATTAINED | ERROR) != 0 || speed == 0 {
                continue;
            }
            tester.collect(Duration::from_millis(500))?;
            let word = tester.number(0x6041, 0)?;
            if word & ATTAINED != 0 {
                return broken(format!("homing by method {method} was taken back, and 6041h is {word:04X}h"));
            }
            let after = most(tester, 0x606C, Duration::from_millis(20))?;
            return if after > speed / 2 {
                broken(format!(
                    "half a second after homing by method {method} was taken back 606Ch is {after}"
                ))
            } else {
                Ok(())
            };
        }
        inapplicable("no homing lasts so long that it can be taken back")
    });
    over(tester, steps)
}
