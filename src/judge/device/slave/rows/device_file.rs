//! What the device file promises, tried.

use super::{row, softer};
use crate::gsd::Gsd;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::tester::{
    FREEZE, FREEZE_COMMAND, SYNC, SYNC_COMMAND, UNFREEZE_COMMAND, UNSYNC_COMMAND,
};
use crate::judge::device::slave::wire::Sight;
use crate::judge::requirement::Confidence::{B, C};
use crate::profibus::dp::{DiagBit, IoLengths, Service};
use crate::profibus::fdl::ReplyStatus;
use core::time::Duration;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Device file",
    rows: &[
        row(
            "S-K01",
            "Ident_Number is that of the diagnosis",
            "the slave says the ident number of its file (14)",
            &[],
            By::Trial(k01),
        ),
        row(
            "S-K02",
            "the configuration is made of identifiers of the file, within Max_Input_Len, Max_Output_Len and Max_Data_Len",
            "the slave takes its limits from its file, so that both agree (14)",
            &["S-X01"],
            By::Trial(k02),
        ),
        row(
            "S-K03",
            "no diagnosis is longer than Max_Diag_Data_Len",
            "Slave_Diag has 6 to 244 octets, capped by Max_Diag_Data_Len (6.2)",
            &[],
            By::Watching(k03),
        ),
        softer(
            row(
                "S-K04",
                "Data_Exchange every Min_Slave_Intervall gives new inputs each time",
                "Min_Slave_Intervall: the least time between two Data_Exchange to the same slave (9)",
                &["S-X01"],
                By::Trial(k04),
            ),
            2,
            B,
        ),
        row(
            "S-K05",
            "Sync_Mode_supp and Freeze_Mode_supp: Set_Prm accepts them, and the diagnosis shows the mode",
            "Sync and Freeze that the file promises are carried out (6.3, 14)",
            &["S-X01"],
            By::Trial(k05),
        ),
        row(
            "S-K06",
            "Set_Slave_Add_supp: the service is there",
            "with Set_Slave_Add_supp the SAP is open in WAIT-PRM (6.4, 14)",
            &[],
            By::Trial(k06),
        ),
        row(
            "S-K07",
            "the rate at which it is judged is one of the file",
            "<rate>_supp (14)",
            &[],
            By::Trial(k07),
        ),
        softer(
            row(
                "S-K08",
                "each configuration of modules of the file that is tried is accepted",
                "a modular slave checks each module against what is plugged (6.1)",
                &["S-G01"],
                By::Trial(k08),
            ),
            2,
            C,
        ),
    ],
};

fn file(tester: &Tester) -> Course<Box<Gsd>> {
    match &tester.setup.gsd {
        Some(gsd) => Ok(gsd.clone()),
        None => inapplicable("needs the device file: gsd="),
    }
}

fn k01(tester: &mut Tester) -> Course {
    if tester.setup.gsd.is_none() && tester.setup.ident.is_none() {
        return inapplicable("needs the device file: gsd=");
    }
    let diagnosis = tester.diag()?;
    if diagnosis.ident() == tester.ident {
        return Ok(());
    }
    broken(format!("the diagnosis has {:04X}, expected {:04X}", diagnosis.ident(), tester.ident))
}

fn k02(tester: &mut Tester) -> Course {
    let gsd = file(tester)?;
    let mut rest = &tester.cfg[..];
    while !rest.is_empty() {
        let mut ids: Vec<&[u8]> = gsd.modules.iter().map(|module| &module.identifiers[..]).collect();
        ids.push(&[0x00]);
        let longest = ids
            .into_iter()
            .filter(|ids| !ids.is_empty() && rest.starts_with(ids))
            .max_by_key(|ids| ids.len());
        let Some(ids) = longest else {
            return broken(format!(
                "its configuration has {}, which is no module of the file",
                crate::explain::hex(rest)
            ));
        };
        rest = rest.get(ids.len()..).unwrap_or_default();
    }
    let IoLengths { inputs, outputs } = tester.lengths;
    let (inputs, outputs) = (u16::from(inputs), u16::from(outputs));
    for (keyword, most, got) in [
        ("Max_Input_Len", gsd.max_input_len, inputs),
        ("Max_Output_Len", gsd.max_output_len, outputs),
        ("Max_Data_Len", gsd.max_data_len, inputs + outputs),
    ] {
        if let Some(most) = most.filter(|most| gsd.is_modular() && got > *most) {
            return broken(format!("{keyword} is {most}, and {got} octets are exchanged"));
        }
    }
    Ok(())
}

fn k03(tester: &mut Tester) -> Course {
    file(tester)?;
    tester.watched("S-K03", "no diagnosis was read")
}

/// How often it is exchanged.
const EXCHANGES: u8 = 50;

fn k04(tester: &mut Tester) -> Course {
    let gsd = file(tester)?;
    if tester.wire.sight == Sight::Untimed {
        return inapplicable("needs a real line or virtual time: no bit times are seen on this link");
    }
    if !tester.setup.mirror || tester.lengths.inputs == 0 {
        return inapplicable("needs a slave whose inputs follow its outputs: mirror");
    }
    tester.may_set_outputs()?;
    tester.start()?;
    let interval = Duration::from_micros(100) * u32::from(gsd.min_slave_interval);
    let mut before: Option<u8> = None;
    for seed in 1..=EXCHANGES {
        let pattern = tester.pattern(seed);
        let begun = tester.wire.now();
        let inputs = tester.exchanged(&pattern)?;
        // What was sent last time, or this time already.
        let seen = inputs.first().copied();
        if before.is_some_and(|before| ![Some(before), Some(seed)].contains(&seen)) {
            return broken(format!(
                "every {} us the inputs are older than the outputs of the exchange before",
                interval.as_micros()
            ));
        }
        before = Some(seed);
        tester.wire.pass(begun.saturating_add(interval))?;
    }
    let zeros = tester.zeros();
    tester.exchanged(&zeros).map(|_| ())
}

fn k05(tester: &mut Tester) -> Course {
    let gsd = file(tester)?;
    if !gsd.flags.sync && !gsd.flags.freeze {
        return inapplicable("the file has neither Sync_Mode_supp nor Freeze_Mode_supp");
    }
    for (promised, bits, on, off, bit, keyword) in [
        (gsd.flags.sync, SYNC, SYNC_COMMAND, UNSYNC_COMMAND, DiagBit::SyncMode, "Sync_Mode_supp"),
        (gsd.flags.freeze, FREEZE, FREEZE_COMMAND, UNFREEZE_COMMAND, DiagBit::FreezeMode, "Freeze_Mode_supp"),
    ] {
        if !promised {
            continue;
        }
        let prm = tester.prm().with(bits);
        tester.set_prm(&prm)?;
        let diagnosis = tester.diag()?;
        if diagnosis.is(DiagBit::NotSupported) || diagnosis.is(DiagBit::PrmFault) {
            return broken(format!("{keyword} = 1, and the diagnosis says {}", diagnosis.words()));
        }
        tester.chk_cfg()?;
        tester.ready()?;
        tester.exchanged_zeros()?;
        for (command, expected) in [(on, true), (off, false)] {
            tester.control(command, 0)?;
            let diagnosis = tester.diag()?;
            if diagnosis.is(bit) != expected {
                return broken(format!(
                    "{keyword} = 1, and {} is {} after the command {command:02X}",
                    bit.name(),
                    u8::from(diagnosis.is(bit))
                ));
            }
        }
        tester.release()?;
    }
    Ok(())
}

fn k06(tester: &mut Tester) -> Course {
    let gsd = file(tester)?;
    if !gsd.flags.set_slave_add {
        return inapplicable("the file has no Set_Slave_Add_supp");
    }
    let [high, low] = (!tester.ident).to_be_bytes();
    let data = [tester.slave(), high, low, 0];
    let answer = tester.serve(tester.owner(), Service::SetSlaveAdd, &data)?;
    if answer.is_status(ReplyStatus::NotActivated) {
        return broken("Set_Slave_Add_supp = 1, and the service is answered with RS");
    }
    Ok(())
}

fn k07(tester: &mut Tester) -> Course {
    let gsd = file(tester)?;
    if tester.wire.sight == Sight::Untimed {
        return inapplicable("there is no rate on this link");
    }
    if gsd.rates.contains(tester.wire.baud) {
        return Ok(());
    }
    broken(format!("it answers at {}, which the file does not have", tester.wire.baud))
}

/// So many modules are tried one by one.
const MODULES: usize = 12;

fn k08(tester: &mut Tester) -> Course {
    let gsd = file(tester)?;
    if !gsd.is_modular() || !tester.setup.modules.is_empty() {
        return inapplicable("the slave has the modules that it has");
    }
    if gsd.flags.fixed_presets || !gsd.slots.is_empty() {
        return inapplicable("a module alone is no configuration of this file");
    }
    let one = |tester: &mut Tester, place: usize, cfg: &[u8]| -> Course {
        let user = gsd.default_user_prm(&[place]);
        let prm = crate::judge::device::slave::tester::Prm::lock(tester.ident, user);
        tester.set_prm(&prm)?;
        tester.acknowledged(Service::ChkCfg, cfg)?;
        tester.ready().map(|_| ())
    };
    let usable = gsd.modules.iter().enumerate().filter(|(_, module)| !module.safety);
    for (place, module) in usable.take(MODULES) {
        if let Err(crate::judge::device::course::Halt::Broken { why, shown }) =
            one(tester, place, &module.identifiers)
        {
            let why = format!("module '{}': {why}", module.name);
            return Err(crate::judge::device::course::Halt::Broken { why, shown });
        }
        tester.release()?;
    }
    Ok(())
}
