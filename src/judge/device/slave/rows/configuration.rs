//! Chk_Cfg and Get_Cfg.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::requirement::Confidence::{B, C};
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::fdl::ReplyStatus;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Chk_Cfg, Get_Cfg",
    rows: &[
        row(
            "S-G02",
            "a configuration with a wrong octet, too short, too long, empty: Cfg_Fault, then it waits for Set_Prm",
            "the reply is SC in all cases; mismatch: Cfg_Fault = 1, back to WAIT-PRM (6.1)",
            &["S-X01"],
            By::Trial(g02),
        ),
        softer(
            row(
                "S-G03",
                "Chk_Cfg before Set_Prm: no change of state",
                "in WAIT-PRM Chk_Cfg is closed (4.1)",
                &["S-G01", "S-D02"],
                By::Trial(g03),
            ),
            1,
            C,
        ),
        row(
            "S-G04",
            "Chk_Cfg of another master: nothing changes for its master",
            "Chk_Cfg is for the owner; else RS (4.1)",
            &["S-X01", "S-D02"],
            By::Trial(g04),
        ),
        row(
            "S-G05",
            "Chk_Cfg in data exchange: a good one leaves it there, a bad one leads to Cfg_Fault and WAIT-PRM",
            "match: stays in DATA-EXCH; mismatch: Cfg_Fault, Leave-Master (7 rows 20 and 21)",
            &["S-X01", "S-G02"],
            By::Trial(g05),
        ),
        row(
            "S-G06",
            "every form of identifiers is read",
            "general and special format, empty slot, two length octets, manufacturer octets (6.1)",
            &[],
            By::Nothing("a slave takes the configurations it has; other forms say nothing of it"),
        ),
        row(
            "S-G07",
            "244 octets in and out are exchanged, 245 are a fault",
            "the sums of inputs and of outputs are at most 244 octets (6.1)",
            &[],
            By::Nothing("a slave takes the configurations it has; few have 244 octets"),
        ),
        row(
            "S-G08",
            "Get_Cfg gives the configuration in each state, to any master",
            "Get_Cfg returns the actual configuration, in any state, to anybody (4.1, 6.1)",
            &["S-X01", "S-C01", "S-C02"],
            By::Trial(g08),
        ),
        softer(
            row(
                "S-G09",
                "Get_Cfg with data in the request: RR",
                "Get_Cfg has no data; other lengths: RR (4.1)",
                &["S-G08"],
                By::Trial(g09),
            ),
            2,
            B,
        ),
        softer(
            row(
                "S-G10",
                "while the application checks, the slave is not ready; a newer Chk_Cfg counts",
                "Station_Not_Ready stays until the check is done (7 row 9)",
                &[],
                By::Nothing("how long the application of a slave checks cannot be set from outside"),
            ),
            2,
            B,
        ),
    ],
};

/// A configuration that this slave cannot have, and its name.
pub(super) fn wrong_ones(tester: &Tester) -> Vec<(&'static str, Vec<u8>)> {
    let right = tester.cfg.clone();
    let is_modular = tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.is_modular());
    let mut wrong = Vec::new();
    let known: Vec<u8> = tester
        .setup
        .gsd
        .iter()
        .flat_map(|gsd| &gsd.modules)
        .flat_map(|module| module.identifiers.clone())
        .collect();
    // An identifier of nothing that it has, of one octet.
    let unknown = (0x10..=0xFF_u8).find(|id| id & 0x30 != 0 && !known.contains(id) && !right.contains(id));
    if let Some(unknown) = unknown {
        let mut other = right.clone();
        if let Some(last) = other.last_mut() {
            *last = unknown;
        }
        wrong.push(("with a wrong octet", other));
        wrong.push(("that is too long", [&right[..], &[unknown]].concat()));
    }
    if !is_modular && right.len() > 1 {
        wrong.push(("that is too short", right.get(..right.len() - 1).unwrap_or_default().to_vec()));
    }
    wrong
}

/// Cfg_Fault, and it waits for Set_Prm.
fn is_fault(tester: &mut Tester, what: &str) -> Course {
    let diagnosis = tester.diag()?;
    if !diagnosis.is(DiagBit::CfgFault) {
        return broken(format!("Cfg_Fault is 0 after {what}: {}", diagnosis.words()));
    }
    if !diagnosis.is(DiagBit::PrmReq) {
        return broken(format!("after {what} it does not wait for Set_Prm: {}", diagnosis.words()));
    }
    Ok(())
}

fn g02(tester: &mut Tester) -> Course {
    let prm = tester.prm();
    for (what, cfg) in wrong_ones(tester) {
        tester.set_prm(&prm)?;
        tester.acknowledged(Service::ChkCfg, &cfg)?;
        is_fault(tester, &format!("a Chk_Cfg {what}"))?;
    }
    tester.must_start()?;
    if tester.diag()?.is(DiagBit::CfgFault) {
        return broken("Cfg_Fault is 1 after a good Chk_Cfg");
    }
    tester.release()?;
    // What an empty one is answered with is open.
    tester.set_prm(&prm)?;
    tester.serve(tester.owner(), Service::ChkCfg, &[])?;
    let diagnosis = tester.diag()?;
    if !diagnosis.is(DiagBit::PrmReq) && !diagnosis.is(DiagBit::StationNotReady) {
        return broken(format!("an empty Chk_Cfg leads to data exchange: {}", diagnosis.words()));
    }
    Ok(())
}

fn g03(tester: &mut Tester) -> Course {
    let cfg = tester.cfg.clone();
    let answer = tester.serve(tester.owner(), Service::ChkCfg, &cfg)?;
    if matches!(answer, Answer::Data(..)) {
        return broken(format!("Chk_Cfg is answered with {}, expected RS or SC", answer.words()));
    }
    let diagnosis = tester.waits_for_prm("a Chk_Cfg without Set_Prm")?;
    if !diagnosis.is(DiagBit::StationNotReady) {
        return broken(format!("the diagnosis says {}", diagnosis.words()));
    }
    Ok(())
}

fn g04(tester: &mut Tester) -> Course {
    let (other, cfg) = (tester.other(), tester.cfg.clone());
    let wrong = [&cfg[..], &[0x7F]].concat();
    let prm = tester.prm();
    tester.set_prm(&prm)?;
    for cfg in [&wrong, &cfg] {
        tester.serve(other, Service::ChkCfg, cfg)?;
        let diagnosis = tester.diag()?;
        // Cfg_Fault may be left of a row before.
        if diagnosis.is(DiagBit::PrmReq) || !diagnosis.is(DiagBit::StationNotReady) {
            return broken(format!(
                "after a Chk_Cfg of master {other} in WAIT-CFG, the diagnosis says {}",
                diagnosis.words()
            ));
        }
    }
    tester.chk_cfg()?;
    tester.ready()?;
    tester.exchanged_zeros()?;
    tester.serve(other, Service::ChkCfg, &wrong)?;
    tester.still_exchanges("a Chk_Cfg of another master")
}

fn g05(tester: &mut Tester) -> Course {
    tester.start()?;
    tester.chk_cfg()?;
    tester.still_exchanges("a good Chk_Cfg in data exchange")?;
    let Some((what, cfg)) = wrong_ones(tester).into_iter().next() else {
        return inapplicable("the slave takes every identifier");
    };
    tester.acknowledged(Service::ChkCfg, &cfg)?;
    is_fault(tester, &format!("a Chk_Cfg {what} in data exchange"))
}

fn g08(tester: &mut Tester) -> Course {
    let expected = tester.cfg.clone();
    let masters = [tester.owner(), tester.other()];
    let says = |tester: &mut Tester, state: &str| -> Course {
        for sa in masters {
            let answer = tester.serve(sa, Service::GetCfg, &[])?;
            if answer != Answer::Data(ReplyStatus::DataLow, expected.clone()) {
                return broken(format!(
                    "in {state} master {sa} gets {} that are not its configuration",
                    answer.words()
                ));
            }
        }
        Ok(())
    };
    says(tester, "WAIT-PRM")?;
    let prm = tester.prm();
    tester.set_prm(&prm)?;
    says(tester, "WAIT-CFG")?;
    tester.chk_cfg()?;
    tester.ready()?;
    tester.exchanged_zeros()?;
    says(tester, "DATA-EXCH")
}

fn g09(tester: &mut Tester) -> Course {
    let answer = tester.serve(tester.owner(), Service::GetCfg, &[0x00])?;
    if answer.is_status(ReplyStatus::NoResource) {
        return Ok(());
    }
    broken(format!("Get_Cfg with an octet of data is answered with {}, expected RR", answer.words()))
}
