//! SAP 51 and its neighbours: who is served, and how one job runs.

use super::{expected, likely, row};
use crate::explain::hex;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::tester::{CLASS_2_SAP, Channel, Prm, is_negative, service};
use crate::profibus::dp::dpv1_status::Status1;
use crate::profibus::dpv1::{ALARM_SAP, Function, MS1_SAP, RESOURCE_MANAGER_SAP};
use crate::profibus::fdl::{self, ReplyStatus};

pub(super) const GROUP: Group<Tester> = Group {
    title: "DP-V1: SAPs, and how a job runs",
    rows: &[
        row(
            "V1-R01",
            "Read at SAP 51 in WAIT-PRM: RS",
            "power on, WAIT-PRM: SAP 50 and 51 are closed (dp-v1 3.2)",
            &["S-F13"],
            By::Trial(r01),
        ),
        row(
            "V1-R02",
            "a start with DPV1_Enable: SAP 51 is open",
            "SAP 51 needs an owner, DPV1_Enable and data exchange (dp-v1 1)",
            &["S-X01", "S-F13"],
            By::Trial(r02),
        ),
        row(
            "V1-R03",
            "a start without DPV1_Enable: RS at SAP 51, and data exchange works",
            "DPV1_Enable 0: SAP 50 and 51 are closed (dp-v1 3.2)",
            &["V1-R02"],
            By::Trial(r03),
        ),
        row(
            "V1-R04",
            "Read at SAP 51 of another master: RS; the job and the data exchange of its master go on",
            "another source address at SAP 51: RS (dp-v1 1.1)",
            &["V1-R06"],
            By::Trial(r04),
        ),
        likely(row(
            "V1-R05",
            "a request is answered with SC, its response comes to a poll",
            "never the response in the reply to the request itself (dp-v1 1.1)",
            &["V1-R02"],
            By::Trial(r05),
        )),
        row(
            "V1-R06",
            "polls are answered with SC until the response comes: that of the service that was asked",
            "poll: SC while the job runs, then the response once (dp-v1 1.1)",
            &["V1-R05"],
            By::Trial(r06),
        ),
        likely(row(
            "V1-R07",
            "a poll behind the response: SC",
            "the response is handed over once; nothing pending: SC (dp-v1 1.1)",
            &["V1-R06", "V1-R08"],
            By::Trial(r07),
        )),
        row(
            "V1-R08",
            "a poll without a job: SC",
            "nothing pending: SC (dp-v1 1.1)",
            &["V1-R02"],
            By::Trial(r08),
        ),
        row(
            "V1-R09",
            "a second request before the response is fetched: RR, and the first response comes",
            "one job at a SAP: RR, the first job goes on (dp-v1 1.1)",
            &["V1-R06"],
            By::Trial(r09),
        ),
        row(
            "V1-R10",
            "a request repeated with the same frame count: SC, and one response",
            "same frame count and octets: the reply is repeated, the job runs once (dp-v1 1.1)",
            &["V1-R07"],
            By::Trial(r10),
        ),
        row(
            "V1-R11",
            "the poll that brought the response, repeated: the same response octet by octet",
            "the response must survive until the master toggles (dp-v1 1.1)",
            &["V1-R06"],
            By::Trial(r11),
        ),
        row(
            "V1-R12",
            "SRD high does the same as SRD low",
            "frames: SRD, low or high (dp-v1 1)",
            &["V1-R06"],
            By::Trial(r12),
        ),
        expected(row(
            "V1-R13",
            "a Write of two octets as SD3 does what it does as SD2",
            "an SD3 request is legal for a PDU of 8 octets (dp-v1 1)",
            &["V1-R06", "S-F11"],
            By::Trial(r13),
        )),
        row(
            "V1-R14",
            "Data_Exchange and Slave_Diag between request and poll: all three are right",
            "any number of cycles may come between the polls (dp-v1 1.1)",
            &["V1-R06"],
            By::Trial(r14),
        ),
        row(
            "V1-R15",
            "without C1_Read_Write_supp and alarms: RS at SAP 51",
            "not offered: RS (dp-v1 1)",
            &["S-X01"],
            By::Trial(r15),
        ),
        row(
            "V1-R16",
            "without DPV1_Slave: RS at SAP 49, 50 and 51",
            "not offered: RS (dp-v1 1)",
            &["S-X01", "S-F12", "S-F13"],
            By::Trial(r16),
        ),
        row(
            "V1-R17",
            "without Extra_Alarm_SAP_supp: RS at SAP 50",
            "Extra_Alarm_SAP_supp = 0: SAP 50 is closed (dp-v1 1)",
            &["V1-R02"],
            By::Trial(r17),
        ),
    ],
};

const READ: &str = "a Read at SAP 51";

/// The response is one to a Read.
pub(super) fn is_of_read(octets: &[u8]) -> Course {
    if service(octets) == Some(Function::Read) {
        return Ok(());
    }
    broken(format!("the response to a Read is {}", crate::explain::hex(octets)))
}

fn r01(tester: &mut Tester) -> Course {
    let channel = tester.has_ms1()?;
    tester.closed(channel, &Tester::probe(), "a Read at SAP 51 in WAIT-PRM")
}

fn r02(tester: &mut Tester) -> Course {
    let channel = tester.has_ms1()?;
    let prm = tester.prm_v1();
    tester.start_with(&prm)?;
    let answer = tester.put(channel, &Tester::probe())?;
    if answer.is_status(ReplyStatus::NotActivated) {
        return broken("C1_Read_Write_supp = 1, and a Read at SAP 51 is answered with RS");
    }
    Ok(())
}

fn r03(tester: &mut Tester) -> Course {
    let channel = tester.has_ms1()?;
    let keywords = tester.keywords()?;
    if keywords.c1_required || keywords.alarms_required != 0 {
        return inapplicable("the device file requires DPV1_Enable");
    }
    let prm = tester.prm_v1().status(0, 0, Status1::Enable.mask()).status(1, 0, 0xFC);
    tester.start_with(&prm)?;
    tester.closed(channel, &Tester::probe(), "a Read at SAP 51 without DPV1_Enable")?;
    tester.still_exchanges("a Read without DPV1_Enable")
}

fn r04(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &Tester::probe(), READ)?;
    let foreign = Channel::ms1(tester.other());
    tester.closed(foreign, &Tester::probe(), &format!("a Read of master {} at SAP 51", foreign.sa))?;
    tester.closed(foreign, &[], &format!("a poll of master {} at SAP 51", foreign.sa))?;
    let octets = tester.response(channel)?;
    is_of_read(&octets)?;
    tester.still_exchanges("a Read of another master")
}

fn r05(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &Tester::probe(), READ)
}

fn r06(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let octets = tester.carried_out(channel, &Tester::probe())?;
    is_of_read(&octets)
}

fn r07(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.carried_out(channel, &Tester::probe())?;
    tester.taken(channel, &[], "a poll behind the response")
}

fn r08(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &[], "a poll without a job")
}

/// Alarm_Ack of an alarm that there is not: a request without effect.
pub(super) const ACK_OF_NOTHING: [u8; 4] = [Function::AlarmAck.number(), 0, 1, 31 << 3];

fn r09(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &Tester::probe(), READ)?;
    let busy = Answer::Status(ReplyStatus::NoResource);
    tester.put_is(
        channel,
        &ACK_OF_NOTHING,
        &busy,
        "a second request before the first response is fetched",
    )?;
    let octets = tester.response(channel)?;
    is_of_read(&octets)
}

fn r10(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let request = tester.telegram(channel, &Tester::probe());
    for what in ["a Read", "the same Read again"] {
        let answer = tester.must_answer(&request)?;
        if answer != Answer::Acknowledged {
            return broken(format!("{what} is answered with {}, expected SC", answer.words()));
        }
    }
    let octets = tester.response(channel)?;
    is_of_read(&octets)?;
    tester.taken(channel, &[], "a poll behind the response to a repeated request")
}

fn r11(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &Tester::probe(), READ)?;
    let (request, _) = tester.polled(channel)?;
    let first = tester.last_reply.clone();
    tester.must_answer(&request)?;
    if tester.last_reply == first {
        return Ok(());
    }
    broken(format!("the same poll brings {} at first, then {}", hex(&first), hex(&tester.last_reply)))
}

fn r12(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let mut request = tester.telegram(channel, &Tester::probe());
    request.service = fdl::Service::SrdHigh;
    let answer = tester.must_answer(&request)?;
    if answer != Answer::Acknowledged {
        return broken(format!("a Read with SRD high is answered with {}, expected SC", answer.words()));
    }
    let octets = tester.response(channel)?;
    is_of_read(&octets)
}

/// A Write of two octets, with its SAPs eight: to slot 255, which no device has.
const TO_NO_SLOT: [u8; 6] = [Function::Write.number(), 255, 0, 2, 0, 0];

fn r13(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let as_sd2 = tester.carried_out(channel, &TO_NO_SLOT)?;
    let mut request = tester.telegram(channel, &TO_NO_SLOT);
    request.as_sd3 = true;
    let answer = tester.must_answer(&request)?;
    if answer != Answer::Acknowledged {
        return broken(format!("a Write as SD3 is answered with {}, expected SC", answer.words()));
    }
    let as_sd3 = tester.response(channel)?;
    if as_sd3 == as_sd2 {
        return Ok(());
    }
    broken(format!("the response is {} to SD3 and {} to SD2", hex(&as_sd3), hex(&as_sd2)))
}

fn r14(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &Tester::probe(), READ)?;
    tester.exchanged_zeros()?;
    tester.diag()?;
    tester.exchanged_zeros()?;
    let octets = tester.response(channel)?;
    is_of_read(&octets)
}

/// These SAPs are closed in data exchange.
fn closed_sap(tester: &mut Tester, sap: u8, ssap: u8) -> Course {
    let channel = Channel { sa: tester.owner(), dsap: sap, ssap };
    for data in [&Tester::probe()[..], &[]] {
        tester.closed(
            channel,
            data,
            &format!("a telegram at SAP {sap}, which the device file does not offer"),
        )?;
    }
    Ok(())
}

fn started(tester: &mut Tester, prm: &Prm) -> Course {
    tester.begin_with(prm)
}

fn r15(tester: &mut Tester) -> Course {
    let keywords = tester.keywords()?;
    if keywords.c1 || keywords.alarms != 0 {
        return inapplicable("the device file has C1_Read_Write_supp, or alarms");
    }
    let prm = tester.prm_v1();
    started(tester, &prm)?;
    closed_sap(tester, MS1_SAP, MS1_SAP)
}

fn r16(tester: &mut Tester) -> Course {
    if tester.setup.gsd.as_ref().is_none_or(|gsd| gsd.flags.dpv1) {
        return inapplicable("the device file has DPV1_Slave, or there is none");
    }
    tester.start()?;
    closed_sap(tester, RESOURCE_MANAGER_SAP, CLASS_2_SAP)?;
    closed_sap(tester, ALARM_SAP, MS1_SAP)?;
    closed_sap(tester, MS1_SAP, MS1_SAP)
}

fn r17(tester: &mut Tester) -> Course {
    if tester.keywords()?.extra_alarm_sap {
        return inapplicable("the device file has Extra_Alarm_SAP_supp");
    }
    tester.open()?;
    closed_sap(tester, ALARM_SAP, MS1_SAP)
}

/// A response that must refuse what was asked.
pub(super) fn must_refuse(octets: &[u8], what: &str) -> Course {
    if is_negative(octets) {
        return Ok(());
    }
    broken(format!("{what} is answered with {}, expected a negative response", hex(octets)))
}
