//! Global_Control: Sync, Freeze, Clear, groups.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::tester::{
    CLEAR, FREEZE, FREEZE_COMMAND, Prm, SYNC, SYNC_COMMAND, UNFREEZE_COMMAND, UNSYNC_COMMAND,
};
use crate::judge::requirement::Confidence::U;
use crate::profibus::dp::DiagBit;
use crate::profibus::fdl::Address;

pub(super) const GROUP: Group<Tester> = Group {
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

fn s01(tester: &mut Tester) -> Course {
    tester.may_set_outputs()?;
    if !tester.offers(SYNC)? {
        return inapplicable("the slave has no Sync");
    }
    let prm = tester.prm().with(SYNC);
    tester.begin_with(&prm)?;
    let [a, b, c, d] = [0x11, 0x22, 0x33, 0x44].map(|seed| tester.pattern(seed));
    tester.exchanged(&a)?;
    tester.control(SYNC_COMMAND, 0)?;
    tester.exchanged(&b)?;
    tester.outputs_are(&a, "after Sync and one more exchange")?;
    tester.control(SYNC_COMMAND, 0)?;
    tester.outputs_are(&b, "after the second Sync")?;
    tester.exchanged(&c)?;
    tester.outputs_are(&b, "before Unsync")?;
    tester.control(UNSYNC_COMMAND, 0)?;
    tester.outputs_are(&c, "after Unsync")?;
    tester.exchanged(&d)?;
    tester.outputs_are(&d, "after Unsync and an exchange")
}

/// What the inputs become by a change, and by nothing.
fn s02(tester: &mut Tester) -> Course {
    if !tester.offers(FREEZE)? {
        return inapplicable("the slave has no Freeze");
    }
    if tester.lengths.inputs == 0 {
        return inapplicable("the slave has no inputs");
    }
    if tester.setup.mirror {
        tester.may_set_outputs()?;
    } else if !tester.is_attended() {
        return inapplicable("needs a slave whose inputs can be changed: mirror, or --ask set-input");
    }
    let prm = tester.prm().with(FREEZE);
    tester.begin_with(&prm)?;
    let first = inputs_become(tester, 0x11)?;
    tester.control(FREEZE_COMMAND, 0)?;
    are(tester, &first, "after Freeze")?;
    let held = inputs_become(tester, 0x22)?;
    if held != first {
        return broken("the inputs change after Freeze");
    }
    tester.control(FREEZE_COMMAND, 0)?;
    let second = settled(tester)?;
    if second == first {
        return broken("the second Freeze takes no new inputs");
    }
    inputs_become(tester, 0x33)?;
    are(tester, &second, "after the second Freeze")?;
    tester.control(UNFREEZE_COMMAND, 0)?;
    if settled(tester)? == second {
        return broken("the inputs do not change after Unfreeze");
    }
    Ok(())
}

/// The inputs follow this, by their outputs or by hand: what Data_Exchange then says.
fn inputs_become(tester: &mut Tester, seed: u8) -> Course<Vec<u8>> {
    if tester.setup.mirror {
        tester.frozen_outputs = Some(seed);
    } else {
        let inputs = vec![seed; tester.lengths.inputs.into()];
        let hex: String = inputs.iter().map(|octet| format!("{octet:02X}")).collect();
        tester.attend(&format!("set-input {hex}"))?;
        tester.pause(core::time::Duration::from_millis(20))?;
    }
    settled(tester)
}

/// The inputs after so many exchanges that they have followed.
fn settled(tester: &mut Tester) -> Course<Vec<u8>> {
    let outputs = tester.frozen_outputs.map_or_else(|| tester.zeros(), |seed| tester.pattern(seed));
    let mut inputs = Vec::new();
    for _ in 0..6 {
        inputs = tester.exchanged(&outputs)?;
    }
    Ok(inputs)
}

fn are(tester: &mut Tester, expected: &[u8], when: &str) -> Course {
    let inputs = settled(tester)?;
    if inputs == expected {
        return Ok(());
    }
    let hex = crate::explain::hex;
    broken(format!("{when} the inputs are {}, expected {}", hex(&inputs), hex(expected)))
}

fn s03(tester: &mut Tester) -> Course {
    let pairs = [
        (SYNC, SYNC_COMMAND, UNSYNC_COMMAND, DiagBit::SyncMode, "Sync"),
        (FREEZE, FREEZE_COMMAND, UNFREEZE_COMMAND, DiagBit::FreezeMode, "Freeze"),
    ];
    let mut tried = false;
    for (bits, on, off, bit, name) in pairs {
        if !tester.offers(bits)? {
            continue;
        }
        tried = true;
        let prm = tester.prm().with(bits);
        tester.begin_with(&prm)?;
        for before in [0, on] {
            tester.control(before, 0)?;
            tester.control(on | off, 0)?;
            if tester.diag()?.is(bit) {
                return broken(format!("{name} is active after {name} and its end in one command"));
            }
        }
        tester.release()?;
    }
    if tried { Ok(()) } else { inapplicable("the slave has neither Sync nor Freeze") }
}

fn s04(tester: &mut Tester) -> Course {
    tester.may_set_outputs()?;
    tester.start()?;
    let (pattern, zeros) = (tester.pattern(0x55), tester.zeros());
    tester.exchanged(&pattern)?;
    tester.outputs_are(&pattern, "after an exchange")?;
    tester.control(CLEAR, 0)?;
    tester.outputs_are(&zeros, "after Clear_Data")?;
    tester.still_exchanges("Clear_Data")
}

fn s05(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    let prm = Prm { groups: 0x05, ..tester.prm().with(effect.request_bits()) };
    tester.begin_with(&prm)?;
    effect.try_group(tester, 0x01, true, "a group of the slave")?;
    effect.try_group(tester, 0x04, true, "the other group of the slave")?;
    effect.try_group(tester, 0x0F, true, "several groups with one of the slave")?;
    effect.try_group(tester, 0xFA, false, "groups that are not the slave's")?;
    effect.try_group(tester, 0x00, true, "all groups")
}

fn s06(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    let prm = tester.prm().with(effect.request_bits());
    tester.begin_with(&prm)?;
    let (other, everybody) = (tester.other(), Address::BROADCAST.number());
    for da in [everybody, tester.slave()] {
        effect.must_be(tester, false, "another master", |tester| {
            tester.control_of(other, da, &[effect.command(), 0])
        })?;
    }
    Ok(())
}

fn s07(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    if effect.request_bits() == 0 {
        return inapplicable("the slave has neither Sync nor Freeze");
    }
    let prm = tester.prm().with(effect.request_bits());
    tester.set_prm(&prm)?;
    tester.control(effect.command(), 0)?;
    let diagnosis = tester.diag()?;
    tester.chk_cfg()?;
    let ready = tester.ready()?;
    for diagnosis in [diagnosis, ready] {
        if diagnosis.is(DiagBit::SyncMode) || diagnosis.is(DiagBit::FreezeMode) {
            return broken(format!("{effect:?} in WAIT-CFG is carried out: {}", diagnosis.words()));
        }
    }
    tester.still_exchanges("Global_Control in WAIT-CFG")
}

fn s08(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    let prm = tester.prm().with(effect.request_bits());
    tester.begin_with(&prm)?;
    let (owner, everybody, command) = (tester.owner(), Address::BROADCAST.number(), effect.command());
    let cases: [(&str, &[u8]); 5] = [
        ("a command with bit 0", &[command | 0x01, 0]),
        ("a command with bit 6", &[command | 0x40, 0]),
        ("a command with bit 7", &[command | 0x80, 0]),
        ("one octet", &[command]),
        ("three octets", &[command, 0, 0]),
    ];
    for (what, data) in cases {
        effect.must_be(tester, false, what, |tester| tester.control_of(owner, everybody, data))?;
    }
    Ok(())
}

fn s09(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    let prm = tester.prm().with(effect.request_bits());
    tester.begin_with(&prm)?;
    let (owner, everybody) = (tester.owner(), Address::BROADCAST.number());
    for (da, what) in [(tester.slave(), "a command to its own address"), (everybody, "a command to 127")] {
        effect.must_be(tester, true, what, |tester| tester.control_of(owner, da, &[effect.command(), 0]))?;
    }
    Ok(())
}

fn s10(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    if effect.request_bits() == 0 {
        return inapplicable("the slave has neither Sync nor Freeze");
    }
    tester.start()?;
    effect.try_group(tester, 0, false, "a slave that was not asked for it in Set_Prm")
}

fn s11(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    if effect.request_bits() == 0 {
        return inapplicable("the slave has neither Sync nor Freeze");
    }
    let prm = tester.prm().with(effect.request_bits());
    tester.begin_with(&prm)?;
    tester.control(effect.command(), 0)?;
    let unlock = Prm::unlock(tester.ident, tester.setup.user_prm());
    tester.set_prm(&unlock)?;
    tester.start_with(&prm)?;
    let diagnosis = tester.diag()?;
    if diagnosis.is(DiagBit::SyncMode) || diagnosis.is(DiagBit::FreezeMode) {
        return broken(format!("{effect:?} is active after a new start-up: {}", diagnosis.words()));
    }
    Ok(())
}
