//! Drives of CiA 402. Nothing here is tried without `--moves-allowed` but what is only read.
//!
//! | file | holds |
//! | --- | --- |
//! | `states` | the state machine |
//! | `modes` | modes of 6502h, profiles of position, velocity and torque |
//! | `cyclic` | set-points with each SYNC |
//! | `homing` | the methods of 6098h |
//! | `stops` | what 605Ah to 605Eh choose |
//! | `limits` | limits of speed, position, torque and following error |

mod cyclic;
mod homing;
mod limits;
mod modes;
mod states;
mod stops;

use core::time::Duration;

use super::{row, sure};
use crate::can_bus::canopen::{Address, NmtState};
use crate::eds::Profile;
use crate::judge::device::course::{Course, Halt, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::objects::whole;
use crate::judge::device::node::sdo::refused;
use crate::judge::device::row::{By, Group};

pub(super) const GROUPS: [Group<Tester>; 6] =
    [states::GROUP, modes::GROUP, cyclic::GROUP, homing::GROUP, stops::GROUP, limits::GROUP];

const CONTROL: Address = Address::new(0x6040, 0);
/// A drive takes its time from state to state.
const PATIENCE: Duration = Duration::from_secs(2);
/// And to a speed or a position.
const LONG: Duration = Duration::from_secs(10);
/// Bits of 6041h that are the state.
const STATE: u64 = 0x6F;
/// The same without the bit of quick stop, which has no meaning in some states.
const CORE: u64 = 0x4F;
const ENABLED: u64 = 0x27;
const TARGET_REACHED: u64 = 1 << 10;
/// The speed that rows turn at, in units of the drive.
const SPEED: i32 = 1000;

fn a_drive(tester: &mut Tester) -> Course {
    let is_drive = match &tester.setup.eds {
        Some(eds) => eds.profile() == Profile::Drive,
        None => tester.number(0x1000, 0)? & 0xFFFF == 402,
    };
    if is_drive && tester.has(0x6040, 0)? && tester.has(0x6041, 0)? {
        Ok(())
    } else {
        inapplicable("it is no drive of CiA 402")
    }
}

fn control(tester: &mut Tester, word: u16) -> Course {
    match tester.download(CONTROL, &word.to_le_bytes())? {
        Ok(()) => Ok(()),
        Err(code) => broken(format!("6040h = {word:04X}h is refused with {}", refused(code))),
    }
}

/// How long it takes until that holds; `None`: longer than `limit`.
fn until(
    tester: &mut Tester,
    limit: Duration,
    mut holds: impl FnMut(&mut Tester) -> Course<bool>,
) -> Course<Option<Duration>> {
    let begun = tester.wire.now();
    loop {
        let holds = holds(tester)?;
        let spent = tester.wire.now().saturating_since(begun);
        if holds {
            return Ok(Some(spent));
        }
        if spent >= limit {
            return Ok(None);
        }
        tester.collect(Duration::from_millis(5))?;
    }
}

/// The status word comes to this under the mask.
fn comes_to(tester: &mut Tester, mask: u64, state: u64, when: &str) -> Course {
    let mut word = 0;
    let came = until(tester, PATIENCE, |tester| {
        word = tester.number(0x6041, 0)?;
        Ok(word & mask == state)
    })?;
    match came {
        Some(_) => Ok(()),
        None => broken(format!("{when} 6041h is {word:04X}h, expected {state:02X}h under {mask:02X}h")),
    }
}

/// Off again, whatever came.
fn off(tester: &mut Tester) -> Course {
    control(tester, 0x0000)?;
    // The reaction to a fault ends first.
    until(tester, PATIENCE, |tester| Ok(tester.number(0x6041, 0)? & CORE != 0x0F))?;
    if tester.number(0x6041, 0)? & CORE == 0x08 {
        control(tester, 0x0080)?;
        comes_to(tester, CORE, 0x40, "after fault reset")?;
        control(tester, 0x0000)?;
    }
    comes_to(tester, CORE, 0x40, "after disable voltage")?;
    // What runs out is none of the next row's.
    if tester.has(0x606C, 0)? {
        until(tester, PATIENCE, |tester| Ok(signed(tester, 0x606C)?.abs() <= SPEED / 20))?;
    }
    Ok(())
}

/// What a row has tried is over: the drive goes off, and what came is the row's.
fn over(tester: &mut Tester, steps: Course) -> Course {
    if let Err(Halt::Over(_)) = steps {
        return steps;
    }
    let off = off(tester);
    steps?;
    off
}

fn enabled(tester: &mut Tester) -> Course {
    for (word, state, what) in
        [(0x06, 0x21, "shutdown"), (0x07, 0x23, "switch on"), (0x0F, ENABLED, "enable operation")]
    {
        control(tester, word)?;
        comes_to(tester, STATE, state, &format!("after {what}"))?;
    }
    Ok(())
}

fn may_enable(tester: &mut Tester) -> Course {
    a_drive(tester)?;
    tester.may_move()?;
    tester.enter(NmtState::Operational)?;
    off(tester)
}

/// Whether 6502h offers a mode, and the drive has these objects for it.
fn offers(tester: &mut Tester, mode: u8, objects: &[u16]) -> Course<bool> {
    let modes = tester.number_if(0x6502, 0)?.unwrap_or_default();
    if modes >> (mode - 1) & 1 == 0 || !tester.has(0x6060, 0)? {
        return Ok(false);
    }
    for index in objects {
        if !tester.has(*index, 0)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// In that mode, off, in OPERATIONAL.
fn in_mode(tester: &mut Tester, mode: u8, objects: &[u16]) -> Course {
    may_enable(tester)?;
    if !offers(tester, mode, objects)? {
        let objects: Vec<String> = objects.iter().map(|index| format!("{index:04X}h")).collect();
        return inapplicable(format!(
            "6502h does not offer mode {mode}, or it lacks {}",
            objects.join(" or ")
        ));
    }
    tester.set(0x6060, 0, &[mode])
}

/// An entry that this row must be able to write.
fn writable(tester: &mut Tester, index: u16, sub: u8) -> Course {
    if tester.is_writable(index, sub)? {
        Ok(())
    } else {
        inapplicable(format!("it has no {} to write to", Address::new(index, sub)))
    }
}

/// Sets a number that rows set again and again; it must be taken.
fn put(tester: &mut Tester, index: u16, sub: u8, number: i32) -> Course {
    match try_put(tester, index, sub, number)? {
        Ok(()) => Ok(()),
        Err(code) => {
            let at = Address::new(index, sub);
            broken(format!("{at} = {number} is refused with {}", refused(code)))
        }
    }
}

/// The same, if it is taken. It has the length that the entry has.
fn try_put(tester: &mut Tester, index: u16, sub: u8, number: i32) -> Course<Result<(), u32>> {
    let at = Address::new(index, sub);
    let len = match tester.upload(at)? {
        Ok(held) => held.len().min(4),
        Err(code) => return Ok(Err(code)),
    };
    let octets = number.to_le_bytes();
    tester.put(at, octets.get(..len).unwrap_or(&octets))
}

/// An actual value with sign.
fn signed(tester: &mut Tester, index: u16) -> Course<i32> {
    let octets = tester.value(index, 0)?;
    let number = u32::try_from(whole(&octets)).unwrap_or(u32::MAX);
    match octets.len() {
        2 => Ok(i32::from(u16::try_from(number).unwrap_or_default().cast_signed())),
        4 => Ok(number.cast_signed()),
        _other => inapplicable(format!("{index:04X}h has neither two nor four octets")),
    }
}

/// 606Ch comes to this, within 5 %.
fn velocity(tester: &mut Tester, wanted: i32, when: &str) -> Course {
    let mut speed = 0;
    let came = until(tester, LONG, |tester| {
        speed = signed(tester, 0x606C)?;
        Ok((speed - wanted).abs() <= SPEED / 20)
    })?;
    match came {
        Some(_) => Ok(()),
        None => broken(format!("{} s after {when} 606Ch is {speed}", LONG.as_secs())),
    }
}

/// Enables it and, where it has profile velocity, has it turn at [`SPEED`]: whether it turns.
fn turns(tester: &mut Tester) -> Course<bool> {
    off(tester)?;
    let turns = offers(tester, 3, &[0x60FF, 0x606C])?;
    if turns {
        put(tester, 0x6060, 0, 3)?;
    }
    enabled(tester)?;
    if turns {
        put(tester, 0x60FF, 0, SPEED)?;
        velocity(tester, SPEED, "60FFh = 1000")?;
    }
    Ok(turns)
}

/// What comes of a number in so long: its largest amount.
fn most(tester: &mut Tester, index: u16, time: Duration) -> Course<i32> {
    let mut most = 0;
    until(tester, time, |tester| {
        most = signed(tester, index)?.abs().max(most);
        Ok(false)
    })?;
    Ok(most)
}
