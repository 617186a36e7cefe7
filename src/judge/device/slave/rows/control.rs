//! Global_Control: Sync, Freeze, Clear, groups.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::bench::{
    CLEAR, FREEZE, FREEZE_COMMAND, Prm, SYNC, SYNC_COMMAND, UNFREEZE_COMMAND, UNSYNC_COMMAND,
};
use crate::judge::requirement::Confidence::U;
use crate::profibus::dp::DiagBit;
use crate::profibus::fdl::Address;

pub(super) const GROUP: Group<Bench> = Group {
    title: "Global_Control",
    rows: &[
        row(
            "S-S01",
            "Sync: outputs wait until the next Sync, or Unsync",
            "the outputs received last go out at once; then each Data_Exchange waits for a further Sync; Unsync ends it (6.3)",
            &["S-X07"],
            By::Trial(s01),
        ),
        row(
            "S-S02",
            "Freeze: the inputs are those of the last Freeze, until Unfreeze",
            "a snapshot; Data_Exchange returns it until the next Freeze or Unfreeze (6.3)",
            &["S-X01"],
            By::Trial(s02),
        ),
        row(
            "S-S03",
            "Sync with Unsync, Freeze with Unfreeze in one command: undo wins",
            "10 and 11 of a pair undo (6.3)",
            &["S-S05"],
            By::Trial(s03),
        ),
        row(
            "S-S04",
            "Clear_Data: the outputs are zero, and data exchange goes on",
            "outputs zeroed, the device stays in DATA-EXCH (6.3)",
            &["S-X07"],
            By::Trial(s04),
        ),
        row(
            "S-S05",
            "a group of the slave acts, another does not, 0 acts",
            "Group_Select 0 = all; else acts if Group_Select AND Group_Ident is not 0 (6.3)",
            &["S-X01"],
            By::Trial(s05),
        ),
        row(
            "S-S06",
            "of another master it is ignored",
            "Global_Control: own only, else ignored (4.1)",
            &["S-S05"],
            By::Trial(s06),
        ),
        row(
            "S-S07",
            "in WAIT-CFG it is ignored",
            "Global_Control: ignored in WAIT-PRM and WAIT-CFG (4.1)",
            &["S-S05"],
            By::Trial(s07),
        ),
        softer(
            row(
                "S-S08",
                "with a reserved bit, or with one or three octets, it is ignored",
                "reserved bits are 0; controllers of slaves ignore the command unless told not to (6.3)",
                &["S-S05"],
                By::Trial(s08),
            ),
            2,
            U,
        ),
        row(
            "S-S09",
            "to its own address it does what it does to 127",
            "DA 127 or unicast (6.3)",
            &["S-S05"],
            By::Trial(s09),
        ),
        softer(
            row(
                "S-S10",
                "Sync or Freeze that Set_Prm has not asked for is ignored",
                "Sync or Freeze not requested in Set_Prm: ignored (6.3)",
                &["S-S05"],
                By::Trial(s10),
            ),
            2,
            U,
        ),
        row(
            "S-S11",
            "Sync and Freeze end when the slave leaves its master",
            "Leave-Master, power-on, new WAIT-PRM: Sync and Freeze modes end (6.3)",
            &["S-S05", "S-P04"],
            By::Trial(s11),
        ),
    ],
};

fn s01(bench: &mut Bench) -> Course {
    bench.may_set_outputs()?;
    if !bench.offers(SYNC)? {
        return inapplicable("the slave has no Sync");
    }
    let prm = bench.prm().with(SYNC);
    bench.begin_with(&prm)?;
    let [a, b, c, d] = [0x11, 0x22, 0x33, 0x44].map(|seed| bench.pattern(seed));
    bench.exchanged(&a)?;
    bench.control(SYNC_COMMAND, 0)?;
    bench.exchanged(&b)?;
    bench.outputs_are(&a, "after Sync and one more exchange")?;
    bench.control(SYNC_COMMAND, 0)?;
    bench.outputs_are(&b, "after the second Sync")?;
    bench.exchanged(&c)?;
    bench.outputs_are(&b, "before Unsync")?;
    bench.control(UNSYNC_COMMAND, 0)?;
    bench.outputs_are(&c, "after Unsync")?;
    bench.exchanged(&d)?;
    bench.outputs_are(&d, "after Unsync and an exchange")
}

/// What the inputs become by a change, and by nothing.
fn s02(bench: &mut Bench) -> Course {
    if !bench.offers(FREEZE)? {
        return inapplicable("the slave has no Freeze");
    }
    if bench.lengths.inputs == 0 {
        return inapplicable("the slave has no inputs");
    }
    if bench.setup.mirror {
        bench.may_set_outputs()?;
    } else if !bench.is_attended() {
        return inapplicable("needs a slave whose inputs can be changed: mirror, or --ask set-input");
    }
    let prm = bench.prm().with(FREEZE);
    bench.begin_with(&prm)?;
    let first = inputs_become(bench, 0x11)?;
    bench.control(FREEZE_COMMAND, 0)?;
    are(bench, &first, "after Freeze")?;
    let held = inputs_become(bench, 0x22)?;
    if held != first {
        return broken("the inputs change after Freeze");
    }
    bench.control(FREEZE_COMMAND, 0)?;
    let second = settled(bench)?;
    if second == first {
        return broken("the second Freeze takes no new inputs");
    }
    inputs_become(bench, 0x33)?;
    are(bench, &second, "after the second Freeze")?;
    bench.control(UNFREEZE_COMMAND, 0)?;
    if settled(bench)? == second {
        return broken("the inputs do not change after Unfreeze");
    }
    Ok(())
}

/// The inputs follow this, by their outputs or by hand: what Data_Exchange then says.
fn inputs_become(bench: &mut Bench, seed: u8) -> Course<Vec<u8>> {
    if bench.setup.mirror {
        bench.frozen_outputs = Some(seed);
    } else {
        let inputs = vec![seed; bench.lengths.inputs.into()];
        let hex: String = inputs.iter().map(|octet| format!("{octet:02X}")).collect();
        bench.attend(&format!("set-input {hex}"))?;
        bench.pause(core::time::Duration::from_millis(20))?;
    }
    settled(bench)
}

/// The inputs after so many exchanges that they have followed.
fn settled(bench: &mut Bench) -> Course<Vec<u8>> {
    let outputs = bench.frozen_outputs.map_or_else(|| bench.zeros(), |seed| bench.pattern(seed));
    let mut inputs = Vec::new();
    for _ in 0..6 {
        inputs = bench.exchanged(&outputs)?;
    }
    Ok(inputs)
}

fn are(bench: &mut Bench, expected: &[u8], when: &str) -> Course {
    let inputs = settled(bench)?;
    if inputs == expected {
        return Ok(());
    }
    let hex = crate::explain::hex;
    broken(format!("{when} the inputs are {}, expected {}", hex(&inputs), hex(expected)))
}

fn s03(bench: &mut Bench) -> Course {
    let pairs = [
        (SYNC, SYNC_COMMAND, UNSYNC_COMMAND, DiagBit::SyncMode, "Sync"),
        (FREEZE, FREEZE_COMMAND, UNFREEZE_COMMAND, DiagBit::FreezeMode, "Freeze"),
    ];
    let mut tried = false;
    for (bits, on, off, bit, name) in pairs {
        if !bench.offers(bits)? {
            continue;
        }
        tried = true;
        let prm = bench.prm().with(bits);
        bench.begin_with(&prm)?;
        for before in [0, on] {
            bench.control(before, 0)?;
            bench.control(on | off, 0)?;
            if bench.diag()?.is(bit) {
                return broken(format!("{name} is active after {name} and its end in one command"));
            }
        }
        bench.release()?;
    }
    if tried { Ok(()) } else { inapplicable("the slave has neither Sync nor Freeze") }
}

fn s04(bench: &mut Bench) -> Course {
    bench.may_set_outputs()?;
    bench.start()?;
    let (pattern, zeros) = (bench.pattern(0x55), bench.zeros());
    bench.exchanged(&pattern)?;
    bench.outputs_are(&pattern, "after an exchange")?;
    bench.control(CLEAR, 0)?;
    bench.outputs_are(&zeros, "after Clear_Data")?;
    bench.still_exchanges("Clear_Data")
}

fn s05(bench: &mut Bench) -> Course {
    let effect = bench.effect_of_control()?;
    let prm = Prm { groups: 0x05, ..bench.prm().with(effect.request_bits()) };
    bench.begin_with(&prm)?;
    effect.try_group(bench, 0x01, true, "a group of the slave")?;
    effect.try_group(bench, 0x04, true, "the other group of the slave")?;
    effect.try_group(bench, 0x0F, true, "several groups with one of the slave")?;
    effect.try_group(bench, 0xFA, false, "groups that are not the slave's")?;
    effect.try_group(bench, 0x00, true, "all groups")
}

fn s06(bench: &mut Bench) -> Course {
    let effect = bench.effect_of_control()?;
    let prm = bench.prm().with(effect.request_bits());
    bench.begin_with(&prm)?;
    let (other, everybody) = (bench.other(), Address::BROADCAST.number());
    for da in [everybody, bench.slave()] {
        effect.must_be(bench, false, "another master", |bench| {
            bench.control_of(other, da, &[effect.command(), 0])
        })?;
    }
    Ok(())
}

fn s07(bench: &mut Bench) -> Course {
    let effect = bench.effect_of_control()?;
    if effect.request_bits() == 0 {
        return inapplicable("the slave has neither Sync nor Freeze");
    }
    let prm = bench.prm().with(effect.request_bits());
    bench.set_prm(&prm)?;
    bench.control(effect.command(), 0)?;
    let diagnosis = bench.diag()?;
    bench.chk_cfg()?;
    let ready = bench.ready()?;
    for diagnosis in [diagnosis, ready] {
        if diagnosis.is(DiagBit::SyncMode) || diagnosis.is(DiagBit::FreezeMode) {
            return broken(format!("{effect:?} in WAIT-CFG is carried out: {}", diagnosis.words()));
        }
    }
    bench.still_exchanges("Global_Control in WAIT-CFG")
}

fn s08(bench: &mut Bench) -> Course {
    let effect = bench.effect_of_control()?;
    let prm = bench.prm().with(effect.request_bits());
    bench.begin_with(&prm)?;
    let (owner, everybody, command) = (bench.owner(), Address::BROADCAST.number(), effect.command());
    let cases: [(&str, &[u8]); 5] = [
        ("a command with bit 0", &[command | 0x01, 0]),
        ("a command with bit 6", &[command | 0x40, 0]),
        ("a command with bit 7", &[command | 0x80, 0]),
        ("one octet", &[command]),
        ("three octets", &[command, 0, 0]),
    ];
    for (what, data) in cases {
        effect.must_be(bench, false, what, |bench| bench.control_of(owner, everybody, data))?;
    }
    Ok(())
}

fn s09(bench: &mut Bench) -> Course {
    let effect = bench.effect_of_control()?;
    let prm = bench.prm().with(effect.request_bits());
    bench.begin_with(&prm)?;
    let (owner, everybody) = (bench.owner(), Address::BROADCAST.number());
    for (da, what) in [(bench.slave(), "a command to its own address"), (everybody, "a command to 127")] {
        effect.must_be(bench, true, what, |bench| bench.control_of(owner, da, &[effect.command(), 0]))?;
    }
    Ok(())
}

fn s10(bench: &mut Bench) -> Course {
    let effect = bench.effect_of_control()?;
    if effect.request_bits() == 0 {
        return inapplicable("the slave has neither Sync nor Freeze");
    }
    bench.start()?;
    effect.try_group(bench, 0, false, "a slave that was not asked for it in Set_Prm")
}

fn s11(bench: &mut Bench) -> Course {
    let effect = bench.effect_of_control()?;
    if effect.request_bits() == 0 {
        return inapplicable("the slave has neither Sync nor Freeze");
    }
    let prm = bench.prm().with(effect.request_bits());
    bench.begin_with(&prm)?;
    bench.control(effect.command(), 0)?;
    let unlock = Prm::unlock(bench.ident, bench.setup.user_prm());
    bench.set_prm(&unlock)?;
    bench.start_with(&prm)?;
    let diagnosis = bench.diag()?;
    if diagnosis.is(DiagBit::SyncMode) || diagnosis.is(DiagBit::FreezeMode) {
        return broken(format!("{effect:?} is active after a new start-up: {}", diagnosis.words()));
    }
    Ok(())
}
