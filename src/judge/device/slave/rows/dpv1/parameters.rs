//! The three octets of DP-V1 in Set_Prm, bit by bit, and Set_Ext_Prm.

use core::time::Duration;

use super::{expected, open, row, softer, watchdog};
use crate::gsd::AcyclicKeywords;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::bench::{Channel, Prm};
use crate::judge::device::slave::request::MASTER_SAP;
use crate::judge::device::slave::rows::parameters::is_fault;
use crate::judge::requirement::Confidence;
use crate::profibus::dp::dpv1_status::{Status1, Status2, Status3};
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::dpv1::EXT_PRM_SAP;

pub(super) const GROUP: Group<Bench> = Group {
    title: "DP-V1: Set_Prm",
    rows: &[
        row(
            "V1-R41",
            "Set_Prm with two of the three octets of DPV1_Status: Prm_Fault",
            "shorter than 10 octets at a DPV1_Slave: Prm_Fault (dp-v1 5)",
            &["S-P03"],
            By::Trial(r41),
        ),
        row(
            "V1-R42",
            "WD_Base_1ms: the watchdog time is both factors times 1 ms",
            "T_WD = f1 x f2 x 1 ms (dp-v1 5)",
            &["S-P17", "S-W04"],
            By::Trial(r42),
        ),
        row(
            "V1-R43",
            "WD_Base_1ms without WD_Base_1ms_supp: Prm_Fault",
            "accepted if WD_Base_1ms_supp, else Prm_Fault (dp-v1 5)",
            &["S-P02"],
            By::Trial(r43),
        ),
        row(
            "V1-R44",
            "the bit Fail_Safe without the keyword Fail_Safe, or 0 with Fail_Safe_required: Prm_Fault",
            "accepted if the file has it; 0 although it is required: Prm_Fault (dp-v1 5)",
            &["S-P02"],
            By::Trial(r44),
        ),
        row(
            "V1-R45",
            "Publisher_Enable, Check_Cfg_Mode, PrmCmd, IsoM_Req, Prm_Structure without their keywords: Prm_Fault",
            "accepted if the file has the keyword, else Prm_Fault (dp-v1 5)",
            &["S-P02"],
            By::Trial(r45),
        ),
        open(row(
            "V1-P01",
            "reserved bits of DPV1_Status: Prm_Fault",
            "reserved bits are 0, else Prm_Fault; some only note it (dp-v1 5)",
            &["S-P02"],
            By::Nothing("a slave may refuse reserved bits or only note them: both are right"),
        )),
        row(
            "V1-P02",
            "each bit of DPV1_Status that the file offers is accepted, and each Alarm_Mode",
            "accepted if the file has the keyword; Alarm_Mode: any (dp-v1 5)",
            &["S-P01"],
            By::Trial(p02),
        ),
        row(
            "V1-R46",
            "with Prm_Structure, a block longer than the rest or shorter than its head: Prm_Fault",
            "lengths of blocks end exactly with Set_Prm, else Prm_Fault (dp-v1 5)",
            &["S-P02"],
            By::Trial(r46),
        ),
        open(row(
            "V1-R47",
            "alarms enabled that the file does not offer: no fault",
            "an enable that is not offered is ignored: the alarm never comes (dp-v1 5)",
            &["S-P01"],
            By::Trial(r47),
        )),
        open(row(
            "V1-R48",
            "C1_Read_Write_required, and DPV1_Enable is 0: Prm_Fault",
            "DPV1_Enable 0 although it is required: Prm_Fault (dp-v1 5)",
            &["S-P02"],
            By::Trial(r48),
        )),
        open(row(
            "V1-R49",
            "an alarm that is required is not enabled: Prm_Fault",
            "a keyword *_Alarm_required whose bit is 0: Prm_Fault (dp-v1 5)",
            &["S-P02"],
            By::Trial(r49),
        )),
        softer(
            row(
                "V1-R50",
                "Set_Ext_Prm: SC in WAIT-CFG and a wrong block is a Prm_Fault, RS in data exchange; RS if it is not offered",
                "SAP 53, from the owner, behind Set_Prm and before Chk_Cfg; other states: RS (dp-v1 5)",
                &["S-X01", "S-F13"],
                By::Trial(r50),
            ),
            3,
            Confidence::B,
        ),
        expected(row(
            "V1-P03",
            "a good Set_Ext_Prm leads on to data exchange",
            "behind Set_Prm and before Chk_Cfg (dp-v1 5)",
            &["V1-R50"],
            By::Nothing("which blocks a slave knows no file says"),
        )),
    ],
};

fn r41(bench: &mut Bench) -> Course {
    bench.keywords()?;
    let mut octets = bench.prm_v1().octets();
    octets.truncate(9);
    bench.acknowledged(Service::SetPrm, &octets)?;
    is_fault(bench, "a Set_Prm of 9 octets")
}

fn r42(bench: &mut Bench) -> Course {
    bench.keywords()?;
    if !bench.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.watchdog_1ms) {
        return inapplicable("the device file has no WD_Base_1ms_supp");
    }
    for factors in [[200, 1], [2, 100], [25, 8]] {
        let prm = bench.prm_v1().status(0, Status1::WdBase1ms.mask(), 0).watched(factors);
        bench.begin_with(&prm)?;
        let time = Duration::from_millis(u64::from(factors[0]) * u64::from(factors[1]));
        let words = format!("{} times {} ms", factors[0], factors[1]);
        bench.exchanged_zeros()?;
        bench.pause(time * 4 / 5)?;
        bench.still_exchanges(&format!("four fifths of a watchdog of {words}"))?;
        let over = watchdog::over(bench, time);
        bench.pause(over)?;
        bench.waits_for_prm(&format!("a watchdog of {words}"))?;
    }
    Ok(())
}

/// What the file sets itself in this octet of DPV1_Status.
fn default_bits(bench: &Bench, octet: usize) -> u8 {
    bench.setup.user_prm().get(octet).copied().unwrap_or_default()
}

/// This bit alone more is a fault, unless the file sets it itself; `false`: it does.
fn bit_is_fault(bench: &mut Bench, octet: usize, bit: u8, name: &str) -> Course<bool> {
    if default_bits(bench, octet) & bit != 0 {
        return Ok(false);
    }
    let prm = bench.prm_v1().status(octet, bit, 0);
    bench.set_prm(&prm)?;
    is_fault(bench, &format!("a Set_Prm with {name}, which the device file does not offer"))?;
    Ok(true)
}

fn r43(bench: &mut Bench) -> Course {
    bench.keywords()?;
    if bench.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.watchdog_1ms) {
        return inapplicable("the device file has WD_Base_1ms_supp");
    }
    bit_is_fault(bench, 0, Status1::WdBase1ms.mask(), "WD_Base_1ms").map(|_| ())
}

fn r44(bench: &mut Bench) -> Course {
    bench.keywords()?;
    let flags = bench.setup.gsd.as_ref().map(|gsd| gsd.flags).unwrap_or_default();
    if flags.fail_safe_required {
        let prm = bench.prm_v1().status(0, 0, Status1::FailSafe.mask());
        bench.set_prm(&prm)?;
        return is_fault(bench, "a Set_Prm without Fail_Safe, which is required");
    }
    if flags.fail_safe {
        return inapplicable("the device file has Fail_Safe");
    }
    bit_is_fault(bench, 0, Status1::FailSafe.mask(), "Fail_Safe").map(|_| ())
}

/// Bits that need a keyword: octet of DPV1_Status, bit, name, and whether the file has the keyword.
fn bits_of_keywords(bench: &Bench) -> Course<[(usize, u8, &'static str, bool); 5]> {
    let AcyclicKeywords { publisher, check_cfg_mode, prm_cmd, isochron, .. } = bench.keywords()?;
    let blocks = bench.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.prm_blocks);
    Ok([
        (0, Status1::Publisher.mask(), Status1::Publisher.name(), publisher),
        (1, Status2::CheckCfgMode.mask(), Status2::CheckCfgMode.name(), check_cfg_mode),
        (2, Status3::PrmCmd.mask(), Status3::PrmCmd.name(), prm_cmd),
        (2, Status3::IsoMReq.mask(), Status3::IsoMReq.name(), isochron),
        (2, Status3::PrmStructure.mask(), Status3::PrmStructure.name(), blocks),
    ])
}

fn r45(bench: &mut Bench) -> Course {
    let mut tried = false;
    for (octet, bit, name, is_offered) in bits_of_keywords(bench)? {
        if !is_offered {
            tried |= bit_is_fault(bench, octet, bit, name)?;
        }
    }
    if tried {
        Ok(())
    } else {
        inapplicable("the device file has all five keywords, or sets the bits itself")
    }
}

/// Bits 2 to 0 of DPV1_Status_3.
const ALARM_MODE: u8 = 0x07;

/// Set_Prm is accepted.
fn is_accepted(bench: &mut Bench, prm: &Prm, what: &str) -> Course {
    bench.set_prm(prm)?;
    let diagnosis = bench.diag()?;
    if diagnosis.is(DiagBit::PrmFault) || diagnosis.is(DiagBit::PrmReq) {
        return broken(format!("{what} is not accepted: {}", diagnosis.words()));
    }
    bench.release()
}

fn p02(bench: &mut Bench) -> Course {
    let keywords = bench.keywords()?;
    let flags = bench.setup.gsd.as_ref().map(|gsd| gsd.flags).unwrap_or_default();
    let plain = bench.prm_v1();
    is_accepted(bench, &plain, "DPV1_Enable with the alarms that are offered")?;
    for (is_offered, octet, bit, name) in [
        (flags.watchdog_1ms, 0, Status1::WdBase1ms.mask(), Status1::WdBase1ms.name()),
        (flags.fail_safe, 0, Status1::FailSafe.mask(), Status1::FailSafe.name()),
        (keywords.check_cfg_mode, 1, Status2::CheckCfgMode.mask(), Status2::CheckCfgMode.name()),
    ] {
        if is_offered {
            is_accepted(bench, &plain.clone().status(octet, bit, 0), &format!("{name}, which is offered,"))?;
        }
    }
    for mode in 1..=ALARM_MODE {
        let prm = plain.clone().status(2, mode, 0);
        is_accepted(bench, &prm, &format!("Alarm_Mode {mode}"))?;
    }
    let each_alone = Status2::ALL.iter().filter(|bit| bit.is_set(keywords.alarms));
    for bit in each_alone.filter(|_| keywords.alarms_required == 0) {
        let prm = plain.clone().status(1, bit.mask(), keywords.alarms & !bit.mask());
        is_accepted(bench, &prm, &format!("{} alone", bit.name()))?;
    }
    Ok(())
}

fn r46(bench: &mut Bench) -> Course {
    bench.keywords()?;
    if !bench.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.prm_blocks) {
        return inapplicable("the device file has no Prm_Block_Structure_supp");
    }
    let plain = bench.prm_v1().status(2, Status3::PrmStructure.mask(), 0);
    let len = plain.user.len().saturating_sub(3);
    if len == 0 {
        return inapplicable("the device file has no user parameters behind DPV1_Status");
    }
    for (first, what) in [(u8::MAX, "longer than the rest"), (3, "of three octets, shorter than its head")] {
        let mut prm = plain.clone();
        if let Some(head) = prm.user.get_mut(3) {
            *head = first;
        }
        bench.set_prm(&prm)?;
        is_fault(bench, &format!("a Set_Prm whose first block is {what}"))?;
    }
    Ok(())
}

fn r47(bench: &mut Bench) -> Course {
    let keywords = bench.keywords()?;
    let not_offered = Status2::ALL
        .iter()
        .filter(|bit| **bit != Status2::CheckCfgMode && !bit.is_set(keywords.alarms))
        .fold(0, |bits, bit| bits | bit.mask());
    if not_offered == 0 {
        return inapplicable("the device file offers every alarm");
    }
    let prm = bench.prm_v1().status(1, not_offered, 0);
    is_accepted(bench, &prm, "a Set_Prm that enables alarms which are not offered")
}

fn r48(bench: &mut Bench) -> Course {
    if !bench.keywords()?.c1_required {
        return inapplicable("the device file has no C1_Read_Write_required");
    }
    let prm = bench.prm_v1().status(0, 0, Status1::Enable.mask());
    bench.set_prm(&prm)?;
    is_fault(bench, "a Set_Prm without DPV1_Enable, which is required")
}

fn r49(bench: &mut Bench) -> Course {
    let required = bench.keywords()?.alarms_required;
    let Some(bit) = Status2::ALL.iter().find(|bit| bit.is_set(required)) else {
        return inapplicable("the device file requires no alarm");
    };
    let prm = bench.prm_v1().status(1, 0, bit.mask());
    bench.set_prm(&prm)?;
    is_fault(bench, &format!("a Set_Prm without {}, which is required", bit.name()))
}

/// A block of the type of the user's parameters, without data: four octets of head.
const BLOCK: [u8; 4] = [4, 0x81, 0, 0];
/// A block that is longer than what is there.
const LONG_BLOCK: [u8; 4] = [9, 0x81, 0, 0];

fn r50(bench: &mut Bench) -> Course {
    bench.keywords()?;
    let is_offered = bench.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.prm_blocks);
    let channel = Channel { sa: bench.owner(), dsap: EXT_PRM_SAP, ssap: MASTER_SAP };
    let foreign = Channel { sa: bench.other(), ..channel };
    let prm = bench.prm_v1();
    bench.set_prm(&prm)?;
    if is_offered {
        bench.closed(foreign, &BLOCK, "Set_Ext_Prm of another master")?;
        let answer = bench.put(channel, &LONG_BLOCK)?;
        // Controllers of slaves offer it although their firmware may not.
        if answer == Answer::Acknowledged {
            is_fault(bench, "a Set_Ext_Prm whose block is longer than it")?;
            bench.set_prm(&prm)?;
        }
        bench.taken(channel, &BLOCK, "Set_Ext_Prm in WAIT-CFG")?;
        bench.release()?;
    } else {
        bench.closed(channel, &BLOCK, "Set_Ext_Prm, which the device file does not offer,")?;
        bench.release()?;
    }
    bench.begin_with(&prm)?;
    bench.closed(channel, &BLOCK, "Set_Ext_Prm in data exchange")
}
