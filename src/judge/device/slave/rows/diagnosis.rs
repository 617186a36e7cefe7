//! Slave_Diag.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::{Diagnosis, NO_MASTER};
use crate::judge::requirement::Confidence::{B, C};
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::fdl::ReplyStatus;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Slave_Diag",
    rows: &[
        row(
            "S-D01",
            "after power on the diagnosis is 02 05 00 FF and the ident number",
            "power-on: Station_Not_Ready, Prm_Req, the fixed 1, no master (6.2)",
            &[],
            By::Trial(d01),
        ),
        row(
            "S-D02",
            "the diagnosis follows start-up: Prm_Req until Set_Prm, Station_Not_Ready until Chk_Cfg; its reply is DL",
            "Prm_Req until a good Set_Prm; Station_Not_Ready in WAIT-PRM and WAIT-CFG; the reply is DL (6.2)",
            &["S-X01"],
            By::Trial(d02),
        ),
        row(
            "S-D03",
            "a new diagnosis in data exchange: DH with the right inputs until it is read",
            "the next Data_Exchange reply uses DH with the same inputs, until the owner has read Slave_Diag (6.2 rule 1)",
            &["S-X01"],
            By::Trial(d03),
        ),
        row(
            "S-D04",
            "DL again once its master has read the diagnosis; another master's reading does not count",
            "only a Slave_Diag from Master_Add clears the flag (6.2 rule 2)",
            &["S-D03", "S-D10"],
            By::Trial(d04),
        ),
        softer(
            row(
                "S-D05",
                "a fault that goes away is told, too: DH, and Ext_Diag 0",
                "when the fault goes away, file a new diagnosis and announce it (6.2 rule 4)",
                &["S-D03", "S-D10"],
                By::Trial(d05),
            ),
            1,
            C,
        ),
        row(
            "S-D06",
            "Stat_Diag keeps its master out until it is cleared",
            "Stat_Diag: the slave cannot deliver valid data, the flag stays (6.2)",
            &[],
            By::Nothing("when a slave sets Stat_Diag cannot be told from outside; its master waits for it"),
        ),
        softer(
            row(
                "S-D07",
                "the extended diagnosis is blocks with right headers, 238 octets at most",
                "blocks: device and identifier with their length, channel 3 octets, revision 1 octet (6.2)",
                &[],
                By::Watching(d07),
            ),
            2,
            B,
        ),
        row(
            "S-D08",
            "the bits that only masters set are 0 in every diagnosis",
            "1.0, 1.5, 1.7 and 2.7 are always 0 (6.2)",
            &[],
            By::Watching(d08),
        ),
        row("S-D09", "octet 2 bit 2 is 1 in every diagnosis", "2.2 is fixed 1 (6.2)", &[], By::Watching(d09)),
        softer(
            row(
                "S-D10",
                "a slave without inputs tells a diagnosis by a short reply with DH, not SC",
                "SC will not do: the reply must carry high priority (6.6)",
                &["S-X01"],
                By::Trial(d10),
            ),
            2,
            C,
        ),
    ],
};

/// Octets 1 to 4 after power on.
const POWER_ON: [u8; 4] = [0x02, 0x05, 0x00, NO_MASTER];

fn d01(tester: &mut Tester) -> Course {
    let is_right = |diagnosis: &Diagnosis| {
        // A slave may have something to say at once; other rows judge the bits of masters and the fixed one.
        let [first, second, third, master, ..] = *Tester::head(diagnosis) else { return false };
        let of_first = DiagBit::StationNotReady.mask() | DiagBit::CfgFault.mask() | DiagBit::PrmFault.mask();
        let of_second = !(DiagBit::Always1.mask() | DiagBit::Deactivated.mask() | DiagBit::StatDiag.mask());
        let got = [first & of_first, second & of_second, third & !DiagBit::ExtDiagOverflow.mask(), master];
        let [one, two, rest @ ..] = POWER_ON;
        let expected = [one, two & of_second];
        got.get(..2) == Some(&expected[..]) && got.get(2..) == Some(&rest[..])
    };
    let wrong = |tester: &Tester, diagnosis: &Diagnosis| {
        broken(format!(
            "the diagnosis is {}, expected 02 05 00 FF {:04X}",
            crate::explain::hex(Tester::head(diagnosis)),
            tester.ident
        ))
    };
    if tester.is_attended() {
        tester.power_cycle()?;
        let diagnosis = tester.diag()?;
        return if is_right(&diagnosis) { Ok(()) } else { wrong(tester, &diagnosis) };
    }
    // It may have been started long ago: then what another master has left says nothing.
    let Some(first) = tester.first.clone() else { return inapplicable("needs --ask: power-cycle") };
    if is_right(&first) {
        return Ok(());
    }
    let is_fresh = first.is(DiagBit::PrmReq) && !first.is(DiagBit::PrmFault) && !first.is(DiagBit::CfgFault);
    if is_fresh {
        return wrong(tester, &first);
    }
    inapplicable("needs --ask: power-cycle; the slave had been parameterised before")
}

fn d02(tester: &mut Tester) -> Course {
    let says = |tester: &mut Tester, state: &str, prm_req: bool, not_ready: bool| -> Course {
        let diagnosis = tester.diag()?;
        let got = (diagnosis.is(DiagBit::PrmReq), diagnosis.is(DiagBit::StationNotReady));
        if got == (prm_req, not_ready) {
            return Ok(());
        }
        broken(format!("in {state} the diagnosis says {}", diagnosis.words()))
    };
    says(tester, "WAIT-PRM", true, true)?;
    let prm = tester.prm();
    tester.set_prm(&prm)?;
    says(tester, "WAIT-CFG", false, true)?;
    tester.chk_cfg()?;
    tester.ready()?;
    tester.exchanged_zeros()?;
    says(tester, "DATA-EXCH", false, false)
}

/// The status of the next Data_Exchange, and the inputs.
fn exchange(tester: &mut Tester) -> Course<(ReplyStatus, Vec<u8>)> {
    let zeros = tester.zeros();
    let answer = tester.serve(tester.owner(), Service::DataExchange, &zeros)?;
    tester.inputs_of(answer)
}

/// The next Data_Exchange replies are all of this status.
fn all_are(tester: &mut Tester, expected: ReplyStatus, when: &str) -> Course {
    for _ in 0..3 {
        let (status, _) = exchange(tester)?;
        if status != expected {
            let is_high = status == ReplyStatus::DataHigh;
            return broken(format!(
                "{when} Data_Exchange is answered with {}",
                if is_high { "DH" } else { "DL" }
            ));
        }
    }
    Ok(())
}

/// In data exchange, with a diagnosis to tell.
fn with_diagnosis(tester: &mut Tester) -> Course {
    if !tester.is_attended() {
        return inapplicable("needs --ask: set-diag");
    }
    tester.start()?;
    tester.diag()?;
    tester.raise_diagnosis()
}

fn d03(tester: &mut Tester) -> Course {
    if tester.lengths.inputs == 0 {
        return inapplicable("S-D10 is about slaves without inputs");
    }
    with_diagnosis(tester)?;
    let announced = all_are(tester, ReplyStatus::DataHigh, "with a new diagnosis");
    tester.diag()?;
    tester.drop_diagnosis()?;
    announced
}

fn d04(tester: &mut Tester) -> Course {
    with_diagnosis(tester)?;
    let diagnosis = tester.diag_of(tester.other())?;
    let course = all_are(tester, ReplyStatus::DataHigh, "after another master has read the diagnosis")
        .and_then(|()| {
            let diagnosis = tester.diag()?;
            if !diagnosis.is(DiagBit::ExtDiag) {
                return broken("Ext_Diag is 0 in the diagnosis of a fault");
            }
            all_are(tester, ReplyStatus::DataLow, "after its master has read the diagnosis")
        });
    tester.drop_diagnosis()?;
    tester.diag()?;
    if !diagnosis.is(DiagBit::ExtDiag) && course.is_ok() {
        return broken("Ext_Diag is 0 for another master");
    }
    course
}

fn d05(tester: &mut Tester) -> Course {
    with_diagnosis(tester)?;
    tester.diag()?;
    tester.drop_diagnosis()?;
    all_are(tester, ReplyStatus::DataHigh, "when the fault has gone")?;
    let diagnosis = tester.diag()?;
    if diagnosis.is(DiagBit::ExtDiag) {
        return broken("Ext_Diag is 1 although the fault has gone");
    }
    Ok(())
}

fn watched(tester: &mut Tester, id: &'static str) -> Course {
    tester.watched(id, "no diagnosis was read")
}

fn d07(tester: &mut Tester) -> Course {
    watched(tester, "S-D07")
}

fn d08(tester: &mut Tester) -> Course {
    watched(tester, "S-D08")
}

fn d09(tester: &mut Tester) -> Course {
    watched(tester, "S-D09")
}

fn d10(tester: &mut Tester) -> Course {
    if tester.lengths.inputs > 0 {
        return inapplicable("the slave has inputs");
    }
    with_diagnosis(tester)?;
    let announced = all_are(tester, ReplyStatus::DataHigh, "with a new diagnosis");
    tester.diag()?;
    tester.drop_diagnosis()?;
    announced
}
