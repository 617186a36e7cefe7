//! MS2: connections of masters of class 2.

use core::time::Duration;

use super::channel::{is_of_read, must_refuse};
use super::records::{may_write, watched};
use super::{expected, likely, open, row};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::tester::{
    CLASS_2_SAP, Channel, Granted, Prm, UNIT, abort, initiate, service,
};
use crate::profibus::dpv1::connection::AbortReason;
use crate::profibus::dpv1::{Function, MAX_DATA, MS1_SAP, RESOURCE_MANAGER_SAP, ResponsePdu};
use crate::profibus::fdl::ReplyStatus;

pub(super) const GROUP: Group<Tester> = Group {
    title: "DP-V1: connections (MS2)",
    rows: &[
        row(
            "V1-R68",
            "without C2_Read_Write_supp: RS at SAP 49",
            "a slave without MS2: RS at SAP 0 to 49 (dp-v1 4.2)",
            &["S-F13"],
            By::Trial(r68),
        ),
        row(
            "V1-R69",
            "Initiate in WAIT-PRM of any master: SC, and a poll of SAP 49 brings the SAP of the connection",
            "RM: 56, Server_SAP 0 to 48, least Send_Timeout (dp-v1 4.1)",
            &["S-F13"],
            By::Trial(r69),
        ),
        row(
            "V1-R70",
            "a poll of that SAP brings the response to Initiate, with C2_Max_Data_Len",
            "Initiate.res: 57, Max_Len_Data_Unit, features with read and write, addresses (dp-v1 4.1)",
            &["V1-R69"],
            By::Trial(r70),
        ),
        row(
            "V1-R71",
            "Read over a connection gives what it gives at SAP 51, errors too",
            "Read and Write as MS1, same errors (dp-v1 4.2 rule 13)",
            &["V1-R70", "V1-R06"],
            By::Trial(r71),
        ),
        row(
            "V1-R72",
            "Idle is answered with Idle",
            "the slave answers Idle like a job: SC, later 48 (dp-v1 4.2 rule 9)",
            &["V1-R70"],
            By::Trial(r72),
        ),
        row(
            "V1-R73",
            "Abort: SC, then RS; another connection can be opened",
            "Abort from the master: SC, the SAP is closed at once and can be handed out again (dp-v1 4.2 rule 7)",
            &["V1-R70"],
            By::Trial(r73),
        ),
        likely(row(
            "V1-R74",
            "without a word a connection lives for Send_Timeout, and is gone after five times that",
            "no request and no Idle for about 3 x Send_Timeout: dropped (dp-v1 4.2 rule 10)",
            &["V1-R72"],
            By::Trial(r74),
        )),
        row(
            "V1-R75",
            "C2_Max_Count_Channels connections at once, each with its SAP; one more is refused",
            "each with its own SAP; no free one: the RM refuses, RS or RR (dp-v1 4.2 rules 2 and 3)",
            &["V1-R72", "V1-R73"],
            By::Trial(r75),
        ),
        row(
            "V1-R76",
            "another master, or another SSAP than 50, at the SAP of a connection: RS",
            "the owner of a server SAP sent the Initiate; else RS (dp-v1 4.2 rule 4)",
            &["V1-R72"],
            By::Trial(r76),
        ),
        row(
            "V1-R77",
            "Set_Prm, data exchange and Unlock of the owner: a connection stays",
            "MS2 works in every state and for any master (dp-v1 4.2 rule 1)",
            &["V1-R72", "S-P04"],
            By::Trial(r77),
        ),
        expected(row(
            "V1-R78",
            "Initiate with less than the least Send_Timeout: Abort, or a negative response",
            "Send_Timeout below the least: Abort STO (dp-v1 4.2 rule 12)",
            &["V1-R70"],
            By::Trial(r78),
        )),
        expected(row(
            "V1-R79",
            "Initiate without read and write, with an address of type 1, or too short: never accepted",
            "octet 6 bit 0 must be 1; type 1 is refused; least 20 octets (dp-v1 4.1)",
            &["V1-R70"],
            By::Trial(r79),
        )),
        open(row(
            "V1-R80",
            "Data_Transport: its response, or a refusal",
            "51 slot index n data, or D1 80 A9 without handler (dp-v1 4.2 rule 14)",
            &["V1-R70"],
            By::Trial(r80),
        )),
        row(
            "V1-R81",
            "a SAP that was not handed out: RS",
            "SAP 48 to 0 are handed out by the RM (dp-v1 1)",
            &["V1-R70"],
            By::Trial(r81),
        ),
        row(
            "V1-R82",
            "jobs at SAP 51 and on a connection at the same time: each gets its own response",
            "one job a SAP; MS1 and each connection are independent (dp-v1 1.1)",
            &["V1-R06", "V1-R72"],
            By::Trial(r82),
        ),
        expected(row(
            "V1-K02",
            "each response on a connection comes within C2_Response_Timeout",
            "a promise (dp-v1 8)",
            &[],
            By::Watching(k02),
        )),
    ],
};

/// A Send_Timeout that every slave takes, times 10 ms.
const LONG: u16 = 6000;
/// A row with longer pauses is left out with `--quick`.
const QUICK: u16 = 50;
const IDLE: [u8; 1] = [Function::Idle.number()];

fn r68(tester: &mut Tester) -> Course {
    if tester.keywords()?.c2 {
        return inapplicable("the device file has C2_Read_Write_supp");
    }
    let manager = Channel::ms2(tester.other(), RESOURCE_MANAGER_SAP);
    tester.closed(manager, &initiate(LONG), "Initiate, which the device file does not offer,")
}

fn r69(tester: &mut Tester) -> Course {
    tester.has_ms2()?;
    let granted = tester.ask_for_connection(tester.other(), &initiate(LONG))?;
    // What becomes of it is another row's.
    tester.put(granted.channel, &[])?;
    tester.disconnect(granted.channel)
}

fn r70(tester: &mut Tester) -> Course {
    tester.has_ms2()?;
    let expected = tester.keywords()?.c2_max_data_len.unwrap_or(MAX_DATA);
    let granted = tester.ask_for_connection(tester.other(), &initiate(LONG))?;
    let octets = tester.response(granted.channel)?;
    tester.disconnect(granted.channel)?;
    let hex = crate::explain::hex(&octets);
    match ResponsePdu::parse(&octets) {
        Ok(ResponsePdu::Initiate(response)) if response.terms.features & 0x0100 == 0 => {
            broken(format!("the response to Initiate has no read and write in its features: {hex}"))
        }
        Ok(ResponsePdu::Initiate(response)) if response.max_len != expected => broken(format!(
            "Max_Len_Data_Unit is {}, expected {expected} of C2_Max_Data_Len",
            response.max_len
        )),
        Ok(ResponsePdu::Initiate(_)) => Ok(()),
        Ok(_) | Err(_) => broken(format!("Initiate is answered with {hex}, expected 57 ..")),
    }
}

/// Reads whose responses must be alike: what there is, a slot and an index that there are not.
const READS: [[u8; 4]; 3] = [
    [Function::Read.number(), 0, 0, MAX_DATA],
    [Function::Read.number(), 255, 1, MAX_DATA],
    [Function::Read.number(), 0, 254, MAX_DATA],
];

fn r71(tester: &mut Tester) -> Course {
    let has_ms1 = tester.has_ms1().is_ok();
    tester.connected(|tester, Granted { channel, .. }| {
        let mut by_connection = Vec::new();
        for read in &READS {
            let octets = tester.carried_out(channel, read)?;
            is_of_read(&octets)?;
            by_connection.push(octets);
        }
        if !has_ms1 {
            return Ok(());
        }
        let owner = tester.open()?;
        for (read, octets) in READS.iter().zip(by_connection) {
            let by_owner = tester.carried_out(owner, read)?;
            // What is in a record may change meanwhile.
            let is_alike = octets == by_owner
                || octets.first() == by_owner.first()
                    && octets.first() == Some(&Function::Read.number())
                    && octets.len() == by_owner.len();
            if !is_alike {
                let (one, other) = (crate::explain::hex(&by_owner), crate::explain::hex(&octets));
                return broken(format!("the same Read gives {one} at SAP 51 and {other} over a connection"));
            }
        }
        Ok(())
    })
}

/// A connection is there: Idle is answered.
fn lives(tester: &mut Tester, channel: Channel, when: &str) -> Course {
    match tester.put(channel, &IDLE)? {
        Answer::Acknowledged => {}
        answer @ (Answer::Silence | Answer::Status(_) | Answer::Data(..) | Answer::Wrong(_)) => {
            return broken(format!("{when} Idle is answered with {}, expected SC", answer.words()));
        }
    }
    let octets = tester.response(channel)?;
    if octets.first() == Some(&Function::Idle.number()) {
        return Ok(());
    }
    broken(format!("{when} Idle is answered with {}", crate::explain::hex(&octets)))
}

fn r72(tester: &mut Tester) -> Course {
    tester.connected(|tester, Granted { channel, .. }| lives(tester, channel, "on a new connection"))
}

/// RS, or an Abort that waits.
fn is_gone(tester: &mut Tester, channel: Channel, when: &str) -> Course {
    for _ in 0..2 {
        match tester.put(channel, &[])? {
            Answer::Status(ReplyStatus::NotActivated) => return Ok(()),
            Answer::Data(_, octets) if service(&octets) == Some(Function::Abort) => return Ok(()),
            Answer::Acknowledged => {}
            answer @ (Answer::Silence | Answer::Status(_) | Answer::Data(..) | Answer::Wrong(_)) => {
                return broken(format!("{when} a poll is answered with {}, expected RS", answer.words()));
            }
        }
    }
    broken(format!("{when} a poll is answered with SC, expected RS"))
}

fn r73(tester: &mut Tester) -> Course {
    tester.has_ms2()?;
    let other = tester.other();
    let Granted { channel, .. } = tester.connect(other, LONG)?;
    tester.taken(channel, &abort(), "Abort")?;
    tester.closed(channel, &[], "a poll behind Abort")?;
    let Granted { channel, .. } = tester.connect(other, LONG)?;
    tester.disconnect(channel)
}

fn r74(tester: &mut Tester) -> Course {
    tester.has_ms2()?;
    let other = tester.other();
    let first = tester.connect(other, LONG)?;
    tester.disconnect(first.channel)?;
    let units = first.least.max(20);
    if tester.setup.quick && units > QUICK {
        return inapplicable("takes long, and --quick is given");
    }
    let time = UNIT * u32::from(units);
    let Granted { channel, .. } = tester.connect(other, units)?;
    let course = lives_and_goes(tester, channel, time);
    tester.disconnect(channel)?;
    course
}

/// It is there after one Send_Timeout, and gone after five more.
fn lives_and_goes(tester: &mut Tester, channel: Channel, time: Duration) -> Course {
    tester.pause(time)?;
    lives(tester, channel, "after one Send_Timeout")?;
    tester.pause(time * 5)?;
    is_gone(tester, channel, "after five Send_Timeout without a word")
}

fn r75(tester: &mut Tester) -> Course {
    tester.has_ms2()?;
    let count = tester.keywords()?.c2_channels.unwrap_or(1);
    let mut opened = Vec::new();
    let course = many(tester, count, &mut opened);
    for channel in opened {
        tester.disconnect(channel)?;
    }
    course
}

fn many(tester: &mut Tester, count: u8, opened: &mut Vec<Channel>) -> Course {
    let other = tester.other();
    for number in 1..=count {
        let channel = tester.connect(other, LONG)?.channel;
        if opened.contains(&channel) {
            return broken(format!("SAP {} is handed out a second time", channel.dsap));
        }
        opened.push(channel);
        lives(tester, channel, &format!("on connection {number} of {count}"))?;
    }
    let manager = Channel::ms2(other, RESOURCE_MANAGER_SAP);
    match tester.put(manager, &initiate(LONG))? {
        Answer::Status(ReplyStatus::NotActivated | ReplyStatus::NoResource) => Ok(()),
        Answer::Acknowledged => {
            // Taken, and refused then.
            let octets = tester.response(manager)?;
            if service(&octets) == Some(Function::ResourceManager)
                && let Ok(ResponsePdu::ResourceManager { sap, .. }) = ResponsePdu::parse(&octets)
            {
                let channel = Channel::ms2(other, sap);
                opened.push(channel);
                let octets = tester.response(channel)?;
                if octets.first() == Some(&Function::Initiate.number()) {
                    return broken(format!(
                        "connection {} is opened, C2_Max_Count_Channels is {count}",
                        count + 1
                    ));
                }
            }
            Ok(())
        }
        answer @ (Answer::Silence | Answer::Status(_) | Answer::Data(..) | Answer::Wrong(_)) => {
            broken(format!("one Initiate too many is answered with {}", answer.words()))
        }
    }
}

fn r76(tester: &mut Tester) -> Course {
    tester.connected(|tester, Granted { channel, .. }| {
        let foreign = Channel { sa: tester.owner(), ..channel };
        tester.closed(foreign, &IDLE, "Idle of another master")?;
        let elsewhere = Channel { ssap: MS1_SAP, ..channel };
        tester.closed(elsewhere, &IDLE, &format!("Idle from SSAP {MS1_SAP} instead of {CLASS_2_SAP}"))?;
        lives(tester, channel, "behind telegrams of others")
    })
}

fn r77(tester: &mut Tester) -> Course {
    tester.connected(|tester, Granted { channel, .. }| {
        let prm = tester.prm_v1();
        tester.set_prm(&prm)?;
        lives(tester, channel, "behind Set_Prm of the owner")?;
        tester.chk_cfg()?;
        tester.ready()?;
        tester.exchanged_zeros()?;
        lives(tester, channel, "in data exchange")?;
        let unlock = Prm::unlock(tester.ident, tester.setup.user_prm());
        tester.set_prm(&unlock)?;
        lives(tester, channel, "behind Unlock of the owner")
    })
}

/// What an Initiate that cannot be accepted is answered with in the end.
fn is_not_accepted(tester: &mut Tester, data: &[u8], what: &str) -> Course<Option<AbortReason>> {
    let other = tester.other();
    let manager = Channel::ms2(other, RESOURCE_MANAGER_SAP);
    if tester.put(manager, data)? != Answer::Acknowledged {
        return Ok(None);
    }
    let octets = tester.response(manager)?;
    let Ok(ResponsePdu::ResourceManager { sap, .. }) = ResponsePdu::parse(&octets) else { return Ok(None) };
    let channel = Channel::ms2(other, sap);
    let octets = tester.response(channel)?;
    let parsed = ResponsePdu::parse(&octets);
    match parsed {
        Ok(ResponsePdu::Abort(abort)) => Ok(Some(abort.reason)),
        Ok(ResponsePdu::Negative { .. }) => Ok(None),
        Ok(_) | Err(_) => {
            tester.disconnect(channel)?;
            broken(format!("{what} is answered with {}", crate::explain::hex(&octets)))
        }
    }
}

fn r78(tester: &mut Tester) -> Course {
    tester.has_ms2()?;
    let first = tester.connect(tester.other(), LONG)?;
    tester.disconnect(first.channel)?;
    let Some(less @ 1..) = first.least.checked_sub(1) else {
        return inapplicable("the slave takes every Send_Timeout");
    };
    let what = format!("Initiate with a Send_Timeout of {less}, and the least is {},", first.least);
    match is_not_accepted(tester, &initiate(less), &what)? {
        None | Some(AbortReason::SEND_TIMEOUT) => Ok(()),
        Some(reason) => broken(format!("{what} is aborted because of {}, expected STO", reason.words())),
    }
}

fn r79(tester: &mut Tester) -> Course {
    tester.has_ms2()?;
    let right = initiate(LONG);
    let with = |place: usize, octet: u8| {
        let mut octets = right.clone();
        if let Some(own) = octets.get_mut(place) {
            *own = octet;
        }
        octets
    };
    let short = right.get(..12).unwrap_or_default().to_vec();
    for (data, what) in [
        (with(6, 0), "Initiate without read and write"),
        (with(12, 1), "Initiate with a source address of type 1 and two octets"),
        (short, "Initiate of 12 octets"),
    ] {
        is_not_accepted(tester, &data, what)?;
    }
    let granted = tester.connect(tester.other(), LONG)?;
    tester.disconnect(granted.channel)
}

fn r80(tester: &mut Tester) -> Course {
    may_write(tester)?;
    tester.connected(|tester, Granted { channel, .. }| {
        let octets = tester.carried_out(channel, &[Function::DataTransport.number(), 0, 0, 1, 0])?;
        if service(&octets) == Some(Function::DataTransport) {
            return Ok(());
        }
        must_refuse(&octets, "Data_Transport")
    })
}

fn r81(tester: &mut Tester) -> Course {
    tester.connected(|tester, Granted { channel, .. }| {
        for sap in (0..RESOURCE_MANAGER_SAP).step_by(7).filter(|sap| *sap != channel.dsap) {
            let closed = Channel { dsap: sap, ..channel };
            tester.closed(closed, &IDLE, &format!("Idle at SAP {sap}, which was not handed out,"))?;
        }
        Ok(())
    })
}

fn r82(tester: &mut Tester) -> Course {
    tester.has_ms1()?;
    tester.connected(|tester, Granted { channel, .. }| {
        let owner = tester.open()?;
        tester.taken(owner, &Tester::probe(), "a Read at SAP 51")?;
        tester.taken(channel, &IDLE, "Idle on a connection while a Read runs at SAP 51")?;
        let octets = tester.response(owner)?;
        is_of_read(&octets)?;
        let octets = tester.response(channel)?;
        if service(&octets) == Some(Function::Idle) {
            return Ok(());
        }
        broken(format!("Idle is answered with {}", crate::explain::hex(&octets)))
    })
}

fn k02(tester: &mut Tester) -> Course {
    if tester.has_ms2().is_ok() && tester.keywords()?.c2_response.is_none() {
        return inapplicable("the device file has no C2_Response_Timeout");
    }
    watched(tester, "V1-K02", "no response came on a connection")
}
