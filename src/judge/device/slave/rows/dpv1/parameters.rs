//! The three octets of DP-V1 in Set_Prm, bit by bit, and Set_Ext_Prm.

use core::time::Duration;

use super::{expected, open, row, softer, watchdog};
use crate::gsd::AcyclicKeywords;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::request::MASTER_SAP;
use crate::judge::device::slave::rows::parameters::is_fault;
use crate::judge::device::slave::tester::{Channel, Prm};
use crate::judge::requirement::Confidence;
use crate::profibus::dp::dpv1_status::{Status1, Status2, Status3};
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::dpv1::EXT_PRM_SAP;

pub(super) const GROUP: Group<Tester> = Group {
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

fn r41(tester: &mut Tester) -> Course {
    tester.keywords()?;
    let mut octets = tester.prm_v1().octets();
    octets.truncate(9);
    tester.acknowledged(Service::SetPrm, &octets)?;
    is_fault(tester, "a Set_Prm of 9 octets")
}

fn r42(tester: &mut Tester) -> Course {
    tester.keywords()?;
    if !tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.watchdog_1ms) {
        return inapplicable("the device file has no WD_Base_1ms_supp");
    }
    for factors in [[200, 1], [2, 100], [25, 8]] {
        let prm = tester.prm_v1().status(0, Status1::WdBase1ms.mask(), 0).watched(factors);
        tester.begin_with(&prm)?;
        let time = Duration::from_millis(u64::from(factors[0]) * u64::from(factors[1]));
        let words = format!("{} times {} ms", factors[0], factors[1]);
        tester.exchanged_zeros()?;
        tester.pause(time * 4 / 5)?;
        tester.still_exchanges(&format!("four fifths of a watchdog of {words}"))?;
        let over = watchdog::over(tester, time);
        tester.pause(over)?;
        tester.waits_for_prm(&format!("a watchdog of {words}"))?;
    }
    Ok(())
}

/// What the file sets itself in this octet of DPV1_Status.
fn default_bits(tester: &Tester, octet: usize) -> u8 {
    tester.setup.user_prm().get(octet).copied().unwrap_or_default()
}

/// This bit alone more is a fault, unless the file sets it itself; `false`: it does.
fn bit_is_fault(tester: &mut Tester, octet: usize, bit: u8, name: &str) -> Course<bool> {
    if default_bits(tester, octet) & bit != 0 {
        return Ok(false);
    }
    let prm = tester.prm_v1().status(octet, bit, 0);
    tester.set_prm(&prm)?;
    is_fault(tester, &format!("a Set_Prm with {name}, which the device file does not offer"))?;
    Ok(true)
}

fn r43(tester: &mut Tester) -> Course {
    tester.keywords()?;
    if tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.watchdog_1ms) {
        return inapplicable("the device file has WD_Base_1ms_supp");
    }
    bit_is_fault(tester, 0, Status1::WdBase1ms.mask(), "WD_Base_1ms").map(|_| ())
}

fn r44(tester: &mut Tester) -> Course {
    tester.keywords()?;
    let flags = tester.setup.gsd.as_ref().map(|gsd| gsd.flags).unwrap_or_default();
    if flags.fail_safe_required {
        let prm = tester.prm_v1().status(0, 0, Status1::FailSafe.mask());
        tester.set_prm(&prm)?;
        return is_fault(tester, "a Set_Prm without Fail_Safe, which is required");
    }
    if flags.fail_safe {
        return inapplicable("the device file has Fail_Safe");
    }
    bit_is_fault(tester, 0, Status1::FailSafe.mask(), "Fail_Safe").map(|_| ())
}

/// Bits that need a keyword: octet of DPV1_Status, bit, name, and whether the file has the keyword.
fn bits_of_keywords(tester: &Tester) -> Course<[(usize, u8, &'static str, bool); 5]> {
    let AcyclicKeywords { publisher, check_cfg_mode, prm_cmd, isochron, .. } = tester.keywords()?;
    let blocks = tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.prm_blocks);
    Ok([
        (0, Status1::Publisher.mask(), Status1::Publisher.name(), publisher),
        (1, Status2::CheckCfgMode.mask(), Status2::CheckCfgMode.name(), check_cfg_mode),
        (2, Status3::PrmCmd.mask(), Status3::PrmCmd.name(), prm_cmd),
        (2, Status3::IsoMReq.mask(), Status3::IsoMReq.name(), isochron),
        (2, Status3::PrmStructure.mask(), Status3::PrmStructure.name(), blocks),
    ])
}

fn r45(tester: &mut Tester) -> Course {
    let mut tried = false;
    for (octet, bit, name, is_offered) in bits_of_keywords(tester)? {
        if !is_offered {
            tried |= bit_is_fault(tester, octet, bit, name)?;
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
fn is_accepted(tester: &mut Tester, prm: &Prm, what: &str) -> Course {
    tester.set_prm(prm)?;
    let diagnosis = tester.diag()?;
    if diagnosis.is(DiagBit::PrmFault) || diagnosis.is(DiagBit::PrmReq) {
        return broken(format!("{what} is not accepted: {}", diagnosis.words()));
    }
    tester.release()
}

fn p02(tester: &mut Tester) -> Course {
    let keywords = tester.keywords()?;
    let flags = tester.setup.gsd.as_ref().map(|gsd| gsd.flags).unwrap_or_default();
    let plain = tester.prm_v1();
    is_accepted(tester, &plain, "DPV1_Enable with the alarms that are offered")?;
    for (is_offered, octet, bit, name) in [
        (flags.watchdog_1ms, 0, Status1::WdBase1ms.mask(), Status1::WdBase1ms.name()),
        (flags.fail_safe, 0, Status1::FailSafe.mask(), Status1::FailSafe.name()),
        (keywords.check_cfg_mode, 1, Status2::CheckCfgMode.mask(), Status2::CheckCfgMode.name()),
    ] {
        if is_offered {
            is_accepted(tester, &plain.clone().status(octet, bit, 0), &format!("{name}, which is offered,"))?;
        }
    }
    for mode in 1..=ALARM_MODE {
        let prm = plain.clone().status(2, mode, 0);
        is_accepted(tester, &prm, &format!("Alarm_Mode {mode}"))?;
    }
    let each_alone = Status2::ALL.iter().filter(|bit| bit.is_set(keywords.alarms));
    for bit in each_alone.filter(|_| keywords.alarms_required == 0) {
        let prm = plain.clone().status(1, bit.mask(), keywords.alarms & !bit.mask());
        is_accepted(tester, &prm, &format!("{} alone", bit.name()))?;
    }
    Ok(())
}

fn r46(tester: &mut Tester) -> Course {
    tester.keywords()?;
    if !tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.prm_blocks) {
        return inapplicable("the device file has no Prm_Block_Structure_supp");
    }
    let plain = tester.prm_v1().status(2, Status3::PrmStructure.mask(), 0);
    let len = plain.user.len().saturating_sub(3);
    if len == 0 {
        return inapplicable("the device file has no user parameters behind DPV1_Status");
    }
    for (first, what) in [(u8::MAX, "longer than the rest"), (3, "of three octets, shorter than its head")] {
        let mut prm = plain.clone();
        if let Some(head) = prm.user.get_mut(3) {
            *head = first;
        }
        tester.set_prm(&prm)?;
        is_fault(tester, &format!("a Set_Prm whose first block is {what}"))?;
    }
    Ok(())
}

fn r47(tester: &mut Tester) -> Course {
    let keywords = tester.keywords()?;
    let not_offered = Status2::ALL
        .iter()
        .filter(|bit| **bit != Status2::CheckCfgMode && !bit.is_set(keywords.alarms))
        .fold(0, |bits, bit| bits | bit.mask());
    if not_offered == 0 {
        return inapplicable("the device file offers every alarm");
    }
    let prm = tester.prm_v1().status(1, not_offered, 0);
    is_accepted(tester, &prm, "a Set_Prm that enables alarms which are not offered")
}

fn r48(tester: &mut Tester) -> Course {
    if !tester.keywords()?.c1_required {
        return inapplicable("the device file has no C1_Read_Write_required");
    }
    let prm = tester.prm_v1().status(0, 0, Status1::Enable.mask());
    tester.set_prm(&prm)?;
    is_fault(tester, "a Set_Prm without DPV1_Enable, which is required")
}

fn r49(tester: &mut Tester) -> Course {
    let required = tester.keywords()?.alarms_required;
    let Some(bit) = Status2::ALL.iter().find(|bit| bit.is_set(required)) else {
        return inapplicable("the device file requires no alarm");
    };
    let prm = tester.prm_v1().status(1, 0, bit.mask());
    tester.set_prm(&prm)?;
    is_fault(tester, &format!("a Set_Prm without {}, which is required", bit.name()))
}

/// A block of the type of the user's parameters, without data: four octets of head.
const BLOCK: [u8; 4] = [4, 0x81, 0, 0];
/// A block that is longer than what is there.
const LONG_BLOCK: [u8; 4] = [9, 0x81, 0, 0];

fn r50(tester: &mut Tester) -> Course {
    tester.keywords()?;
    let is_offered = tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.prm_blocks);
    let channel = Channel { sa: tester.owner(), dsap: EXT_PRM_SAP, ssap: MASTER_SAP };
    let foreign = Channel { sa: tester.other(), ..channel };
    let prm = tester.prm_v1();
    tester.set_prm(&prm)?;
    if is_offered {
        tester.closed(foreign, &BLOCK, "Set_Ext_Prm of another master")?;
        let answer = tester.put(channel, &LONG_BLOCK)?;
        // Controllers of slaves offer it although their firmware may not.
        if answer == Answer::Acknowledged {
            is_fault(tester, "a Set_Ext_Prm whose block is longer than it")?;
            tester.set_prm(&prm)?;
        }
        tester.taken(channel, &BLOCK, "Set_Ext_Prm in WAIT-CFG")?;
        tester.release()?;
    } else {
        tester.closed(channel, &BLOCK, "Set_Ext_Prm, which the device file does not offer,")?;
        tester.release()?;
    }
    tester.begin_with(&prm)?;
    tester.closed(channel, &BLOCK, "Set_Ext_Prm in data exchange")
}
