//! Drives of CiA 402. Nothing here is tried without `--moves-allowed` but what is only read.

use core::time::Duration;

use super::{row, sure};
use crate::can_bus::canopen::{Address, NmtState};
use crate::eds::Profile;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Bench;
use crate::judge::device::node::sdo::refused;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::B;

pub(super) const GROUP: Group<Bench> = Group {
    title: "Drives of CiA 402",
    rows: &[
        row(
            "N-D01",
            "after a reset of the node: SWITCH ON DISABLED",
            "power-up in SWITCH ON DISABLED: 6041h & 4Fh = 40h (eds E-53)",
            &["N-O01"],
            By::Trial(d01),
        ),
        row(
            "N-D02",
            "shutdown, switch on, enable operation, and back step by step",
            "06h 21h, 07h 23h, 0Fh 27h; and back (eds E-53)",
            &["N-D01"],
            By::Trial(d02),
        ),
        row(
            "N-D03",
            "disable voltage leads to SWITCH ON DISABLED from each state",
            "disable voltage (00h): 40h (eds E-53)",
            &["N-D02"],
            By::Trial(d03),
        ),
        row(
            "N-D04",
            "quick stop leaves OPERATION ENABLED",
            "quick stop (02h): 07h, or 40h by 605Ah (eds E-53)",
            &["N-D02"],
            By::Trial(d04),
        ),
        row(
            "N-D05",
            "in SWITCH ON DISABLED neither switch on nor enable operation does anything",
            "shutdown first (eds E-53)",
            &["N-D01"],
            By::Trial(d05),
        ),
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
            &["N-D02", "N-D06"],
            By::Trial(d07),
        ),
        row(
            "N-D08",
            "profile position: the set-point is acknowledged, the target reached",
            "new set-point acknowledged (bit 12), target reached (bit 10), 6064h = target (eds E-55)",
            &["N-D02", "N-D06"],
            By::Trial(d08),
        ),
        row(
            "N-D09",
            "homing methods, limits of positions, option codes, modes that follow SYNC",
            "homing, 607Dh, 605Ah..605Eh, csp, csv (eds E-57 to E-59)",
            &[],
            By::Nothing("they depend on the machine: switches, index pulses, and what its limits are for"),
        ),
    ],
};

const CONTROL: Address = Address::new(0x6040, 0);
/// A drive takes its time from state to state.
const PATIENCE: Duration = Duration::from_secs(2);
/// Bits of 6041h that are the state.
const STATE: u64 = 0x6F;
/// The same without the bit of quick stop, which has no meaning in some states.
const CORE: u64 = 0x4F;

fn a_drive(bench: &mut Bench) -> Course {
    let is_drive = match &bench.setup.eds {
        Some(eds) => eds.profile() == Profile::Drive,
        None => bench.number(0x1000, 0)? & 0xFFFF == 402,
    };
    if is_drive && bench.has(0x6040, 0)? && bench.has(0x6041, 0)? {
        Ok(())
    } else {
        inapplicable("it is no drive of CiA 402")
    }
}

fn control(bench: &mut Bench, word: u16) -> Course {
    match bench.download(CONTROL, &word.to_le_bytes())? {
        Ok(()) => Ok(()),
        Err(code) => broken(format!("6040h = {word:04X}h is refused with {}", refused(code))),
    }
}

/// The status word comes to this under the mask.
fn comes_to(bench: &mut Bench, mask: u64, state: u64, when: &str) -> Course {
    let until = bench.wire.now().saturating_add(PATIENCE);
    loop {
        let word = bench.number(0x6041, 0)?;
        if word & mask == state {
            return Ok(());
        }
        if bench.wire.now() >= until {
            return broken(format!("{when} 6041h is {word:04X}h, expected {state:02X}h under {mask:02X}h"));
        }
        bench.collect(Duration::from_millis(10))?;
    }
}

/// Off again, whatever came.
fn off(bench: &mut Bench) -> Course {
    control(bench, 0x0000)?;
    comes_to(bench, CORE, 0x40, "after disable voltage")
}

fn d01(bench: &mut Bench) -> Course {
    a_drive(bench)?;
    bench.nmt(&[0x81, bench.node().number()])?;
    bench.boot_up("reset node")?;
    bench.collect(bench.silence())?;
    comes_to(bench, CORE, 0x40, "after a reset of the node")
}

fn enabled(bench: &mut Bench) -> Course {
    for (word, mask, state, what) in [
        (0x06, STATE, 0x21, "shutdown"),
        (0x07, STATE, 0x23, "switch on"),
        (0x0F, STATE, 0x27, "enable operation"),
    ] {
        control(bench, word)?;
        comes_to(bench, mask, state, &format!("after {what}"))?;
    }
    Ok(())
}

fn may_enable(bench: &mut Bench) -> Course {
    a_drive(bench)?;
    bench.may_move()?;
    bench.enter(NmtState::Operational)?;
    off(bench)
}

fn d02(bench: &mut Bench) -> Course {
    may_enable(bench)?;
    let steps = enabled(bench).and_then(|()| {
        control(bench, 0x07)?;
        comes_to(bench, STATE, 0x23, "after disable operation")?;
        control(bench, 0x06)?;
        comes_to(bench, STATE, 0x21, "after shutdown")
    });
    // Whether that does anything is another row.
    control(bench, 0x0000)?;
    steps
}

fn d03(bench: &mut Bench) -> Course {
    may_enable(bench)?;
    for words in [&[0x06][..], &[0x06, 0x07], &[0x06, 0x07, 0x0F]] {
        for word in words {
            control(bench, *word)?;
            bench.collect(Duration::from_millis(50))?;
        }
        off(bench)?;
    }
    Ok(())
}

fn d04(bench: &mut Bench) -> Course {
    may_enable(bench)?;
    let steps = enabled(bench).and_then(|()| {
        control(bench, 0x02)?;
        let until = bench.wire.now().saturating_add(PATIENCE);
        loop {
            let word = bench.number(0x6041, 0)?;
            if word & STATE == 0x07 || word & CORE == 0x40 {
                return Ok(());
            }
            if bench.wire.now() >= until {
                return broken(format!("after quick stop 6041h is {word:04X}h, expected 07h or 40h"));
            }
            bench.collect(Duration::from_millis(10))?;
        }
    });
    off(bench)?;
    steps
}

fn d05(bench: &mut Bench) -> Course {
    may_enable(bench)?;
    for word in [0x07, 0x0F, 0x80, 0x00] {
        control(bench, word)?;
        bench.collect(Duration::from_millis(100))?;
        let status = bench.number(0x6041, 0)?;
        if status & CORE != 0x40 {
            off(bench)?;
            return broken(format!("in SWITCH ON DISABLED after 6040h = {word:04X}h 6041h is {status:04X}h"));
        }
    }
    Ok(())
}

fn d06(bench: &mut Bench) -> Course {
    a_drive(bench)?;
    bench.may_move()?;
    if !bench.has(0x6502, 0)? || !bench.has(0x6060, 0)? || !bench.has(0x6061, 0)? {
        return inapplicable("it lacks 6502h, 6060h or 6061h");
    }
    let modes = bench.number(0x6502, 0)?;
    if modes & 0x3FF == 0 {
        return inapplicable("6502h names no mode");
    }
    for mode in [1_u8, 2, 3, 4, 6, 7, 8, 9, 10] {
        let offered = modes >> (mode - 1) & 1 == 1;
        let taken = bench.try_set(0x6060, 0, &[mode])?;
        bench.collect(Duration::from_millis(100))?;
        let shown = bench.number(0x6061, 0)?;
        match (offered, taken) {
            (true, Err(code)) => {
                return broken(format!(
                    "6502h offers mode {mode}, and 6060h refuses it with {}",
                    refused(code)
                ));
            }
            (true, Ok(())) if shown != u64::from(mode) => {
                return broken(format!("6060h = {mode}, and 6061h is {shown}"));
            }
            (false, Ok(())) if shown == u64::from(mode) => {
                return broken(format!("6502h does not offer mode {mode}, and 6061h shows it"));
            }
            (true | false, Ok(())) | (false, Err(_)) => {}
        }
    }
    Ok(())
}

/// In that mode, enabled.
fn in_mode(bench: &mut Bench, mode: u8) -> Course {
    may_enable(bench)?;
    let modes = bench.number_if(0x6502, 0)?.unwrap_or_default();
    if modes >> (mode - 1) & 1 == 0 {
        return inapplicable(format!("6502h does not offer mode {mode}"));
    }
    bench.set(0x6060, 0, &[mode])
}

fn signed(bench: &mut Bench, index: u16) -> Course<i32> {
    let octets = bench.value(index, 0)?;
    match <[u8; 4]>::try_from(octets) {
        Ok(octets) => Ok(i32::from_le_bytes(octets)),
        Err(_) => inapplicable(format!("{index:04X}h has not four octets")),
    }
}

fn d07(bench: &mut Bench) -> Course {
    in_mode(bench, 3)?;
    if !bench.has(0x60FF, 0)? || !bench.has(0x606C, 0)? {
        return inapplicable("it lacks 60FFh or 606Ch");
    }
    let steps = turn(bench);
    let _ = bench.download(Address::new(0x60FF, 0), &[0; 4])?;
    off(bench)?;
    steps
}

fn turn(bench: &mut Bench) -> Course {
    let target = 1000_i32;
    // Some drives forget it when they are enabled.
    enabled(bench)?;
    bench.set(0x60FF, 0, &target.to_le_bytes())?;
    let reached = |speed: i32| (speed - target).abs() <= target / 20;
    velocity(bench, reached, "60FFh = 1000")?;
    control(bench, 0x010F)?;
    velocity(bench, |speed| speed.abs() <= target / 20, "halt")
}

fn velocity(bench: &mut Bench, wanted: impl Fn(i32) -> bool, when: &str) -> Course {
    let until = bench.wire.now().saturating_add(Duration::from_secs(10));
    loop {
        let speed = signed(bench, 0x606C)?;
        if wanted(speed) {
            return Ok(());
        }
        if bench.wire.now() >= until {
            return broken(format!("10 s after {when} 606Ch is {speed}"));
        }
        bench.collect(Duration::from_millis(20))?;
    }
}

fn d08(bench: &mut Bench) -> Course {
    in_mode(bench, 1)?;
    if !bench.has(0x607A, 0)? || !bench.has(0x6064, 0)? {
        return inapplicable("it lacks 607Ah or 6064h");
    }
    let steps = travel(bench);
    off(bench)?;
    steps
}

fn travel(bench: &mut Bench) -> Course {
    let target = signed(bench, 0x6064)?.saturating_add(100);
    bench.set(0x607A, 0, &target.to_le_bytes())?;
    if bench.number_if(0x6081, 0)? == Some(0) {
        bench.set(0x6081, 0, &1000_u32.to_le_bytes())?;
    }
    enabled(bench)?;
    control(bench, 0x1F)?;
    comes_to(bench, 0x1000, 0x1000, "after a new set-point")?;
    control(bench, 0x0F)?;
    comes_to(bench, 0x1000, 0, "after the set-point was taken back")?;
    let until = bench.wire.now().saturating_add(Duration::from_secs(20));
    while bench.number(0x6041, 0)? & 0x0400 == 0 {
        if bench.wire.now() >= until {
            return broken("target reached (6041h bit 10) does not come within 20 s");
        }
        bench.collect(Duration::from_millis(20))?;
    }
    let position = signed(bench, 0x6064)?;
    if (position - target).abs() <= 10 {
        Ok(())
    } else {
        broken(format!("the target is {target}, and 6064h is {position}"))
    }
}
