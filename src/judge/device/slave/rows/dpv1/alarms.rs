//! Alarms and status messages. Only the device can raise them: `--ask raise-alarm`, `--ask send-status`.

use core::time::Duration;

use super::channel::{ACK_OF_NOTHING, is_of_read, must_refuse};
use super::{expected, likely, open, row};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::{Answer, Diagnosis};
use crate::judge::device::slave::tester::{Channel, DIAG_LEN, Prm, is_negative};
use crate::judge::device::slave::wire::Sight;
use crate::profibus::dp::Service;
use crate::profibus::dp::dpv1_status::{Status1, Status2};
use crate::profibus::dpv1::{
    ALARM_SAP, AlarmHead, AlarmType, MAX_PDU, MS1_SAP, RequestPdu, Specifier, StatusType, TypedBlock,
};
use crate::profibus::fdl::ReplyStatus;

pub(super) const GROUP: Group<Tester> = Group {
    title: "DP-V1: alarms",
    rows: &[
        row(
            "V1-R51",
            "an alarm: DH, and Slave_Diag has its block with type, slot, specifier and data",
            "block: 00llllll, type, slot, Seq_Nr with Add_Ack and specifier, data; announced like any diagnosis (dp-v1 6.1)",
            &["V1-R06", "S-D03"],
            By::Trial(r51),
        ),
        row(
            "V1-R52",
            "Alarm_Ack at SAP 51 is mirrored",
            "Alarm_Ack with the same slot, type, Seq_Nr: 5C .. mirrored, the alarm is over (dp-v1 6.2 rule 5)",
            &["V1-R51"],
            By::Trial(r52),
        ),
        row(
            "V1-R53",
            "Alarm_Ack at SAP 50 is mirrored",
            "with Extra_Alarm_SAP_supp either SAP takes it (dp-v1 6.2 rule 5)",
            &["V1-R51"],
            By::Trial(r53),
        ),
        likely(row(
            "V1-R54",
            "Alarm_Ack of no alarm, of another slot, and a second time: refused; the alarm stays",
            "ack of nothing, or twice: never positive (dp-v1 6.2 rule 6)",
            &["V1-R52"],
            By::Trial(r54),
        )),
        row(
            "V1-R55",
            "an alarm whose type Set_Prm has not enabled does not come",
            "allowed only if its type is enabled in DPV1_Status_2 (dp-v1 6.2 rule 1)",
            &["V1-R51"],
            By::Trial(r55),
        ),
        row(
            "V1-R56",
            "an alarm whose type the file does not offer does not come",
            "allowed only if the file offers it (dp-v1 6.2 rule 1)",
            &["V1-R51"],
            By::Trial(r56),
        ),
        row(
            "V1-R57",
            "without DPV1_Enable no alarm comes",
            "allowed only with DPV1_Enable, in data exchange (dp-v1 6.2 rule 1)",
            &["V1-R51", "V1-R03"],
            By::Trial(r57),
        ),
        row(
            "V1-R58",
            "Alarm_Mode 0: a second alarm of the same type does not come before the first is acknowledged",
            "type mode: at most one active alarm of a type (dp-v1 6.2 rule 2)",
            &["V1-R52"],
            By::Trial(r58),
        ),
        row(
            "V1-R59",
            "Alarm_Mode 0: an alarm of another type comes meanwhile",
            "type mode: at most one active alarm of a type (dp-v1 6.2 rule 2)",
            &["V1-R52"],
            By::Trial(r59),
        ),
        row(
            "V1-R60",
            "Alarm_Mode 1: two alarms with two numbers, a third not before an acknowledgement",
            "sequence mode: limit of Alarm_Mode and of the file, Seq_Nr unique (dp-v1 6.2 rule 3)",
            &["V1-R52"],
            By::Trial(r60),
        ),
        likely(row(
            "V1-R61",
            "two alarms are acknowledged in the other order",
            "an acknowledgement ends the alarm of its slot, type and Seq_Nr (dp-v1 6.2 rule 5)",
            &["V1-R60"],
            By::Trial(r61),
        )),
        row(
            "V1-R62",
            "Unlock with an open alarm: behind a new start it does not come, and its acknowledgement is refused",
            "not acknowledged alarms are dropped with data exchange, and not repeated (dp-v1 6.2 rule 9)",
            &["V1-R52", "V1-R54"],
            By::Trial(r62),
        ),
        expected(row(
            "V1-R63",
            "Add_Ack and each specifier are in the block as they were raised",
            "b2 Add_Ack, b1..b0 specifier (dp-v1 6.1)",
            &["V1-R52"],
            By::Trial(r63),
        )),
        open(row(
            "V1-R64",
            "the block leaves the diagnosis when the alarm is acknowledged, at the latest",
            "how long the block stays is open; at the latest until the acknowledgement (dp-v1 12 O-09)",
            &["V1-R52"],
            By::Trial(r64),
        )),
        row(
            "V1-R65",
            "another master reads Slave_Diag first: its master still gets DH and the block",
            "an alarm read by a foreign master is not delivered (dp-v1 6.1)",
            &["V1-R51"],
            By::Trial(r65),
        ),
        expected(row(
            "V1-R66",
            "a status message comes in a block of the type 80 or more, and wants no acknowledgement",
            "status messages need no enabling and no acknowledgement (dp-v1 6.1)",
            &["V1-R06", "S-D03"],
            By::Trial(r66),
        )),
        row(
            "V1-R67",
            "Alarm_Ack while the response to a Read waits: RR at SAP 51, served at SAP 50",
            "Alarm_Ack waits behind a running Read at SAP 51: that is what SAP 50 is for (dp-v1 6.2 rule 7)",
            &["V1-R09", "V1-R52", "V1-R53"],
            By::Trial(r67),
        ),
    ],
};

/// What is raised.
#[derive(Clone, Copy, Debug)]
struct Raised {
    kind: &'static str,
    specifier: &'static str,
    additional_ack: bool,
}

impl Raised {
    const fn of(kind: &'static str) -> Self {
        Self { kind, specifier: "appears", additional_ack: false }
    }
}

/// What it says besides.
const DATA: u8 = 0x50;

/// The words of a type of alarms that the file offers, for each bit that enables some.
fn offered(tester: &Tester) -> Course<Vec<&'static str>> {
    let alarms = tester.keywords()?.alarms;
    let mut bits = Vec::new();
    let mut words = Vec::new();
    for (word, kind) in AlarmType::NAMED {
        if let Some(bit) = kind.enabled_by().filter(|bit| bit.is_set(alarms) && !bits.contains(bit)) {
            bits.push(bit);
            words.push(word);
        }
    }
    Ok(words)
}

/// In data exchange, where alarms may be raised: MS1 and the first type of alarms.
fn alarming(tester: &mut Tester) -> Course<(Channel, &'static str)> {
    let Some(kind) = offered(tester)?.first().copied() else {
        return inapplicable("the device file offers no alarms");
    };
    if !tester.is_attended() {
        return inapplicable("needs --ask: raise-alarm");
    }
    let channel = tester.open()?;
    Ok((channel, kind))
}

fn slot(tester: &Tester) -> u8 {
    u8::from(tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.is_modular()))
}

/// The data of alarms, as far as Slave_Diag has room.
fn data(tester: &Tester) -> Vec<u8> {
    let room = tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.max_diag_len > 10);
    if room { vec![DATA] } else { Vec::new() }
}

/// Asks the device for an alarm.
fn raise(tester: &mut Tester, raised: Raised) -> Course {
    let (slot, data) = (slot(tester), data(tester));
    let hex: String = data.iter().map(|octet| format!("{octet:02X}")).collect();
    let ack = u8::from(raised.additional_ack);
    let action = format!("raise-alarm {} {slot} {} {ack} {hex}", raised.kind, raised.specifier);
    tester.attend(action.trim_end()).map(|_| ())
}

/// Asks for one that must not come: a device may say so.
fn raise_in_vain(tester: &mut Tester, raised: Raised) -> Course {
    match raise(tester, raised) {
        Err(crate::judge::device::course::Halt::Inapplicable(_)) => Ok(()),
        course => course,
    }
}

/// The effect of an action is there within so long.
fn effect(tester: &Tester) -> Duration {
    match tester.wire.sight {
        Sight::Exact => Duration::from_millis(50),
        Sight::Measured | Sight::Untimed => Duration::from_secs(1),
    }
}

/// Exchanges until DH comes; whether it came.
fn is_announced(tester: &mut Tester) -> Course<bool> {
    let until = tester.wire.now().saturating_add(effect(tester));
    let outputs = tester.zeros();
    while tester.wire.now() < until {
        let answer = tester.serve(tester.owner(), Service::DataExchange, &outputs)?;
        if tester.inputs_of(answer)?.0 == ReplyStatus::DataHigh {
            return Ok(true);
        }
        tester.pause(Duration::from_millis(2))?;
    }
    Ok(false)
}

/// The blocks of the device in a diagnosis, behind their headers.
fn blocks(diagnosis: &Diagnosis) -> Vec<Vec<u8>> {
    let mut rest = diagnosis.0.get(DIAG_LEN..).unwrap_or_default();
    let mut blocks = Vec::new();
    while let [header, ..] = rest {
        let len = match header >> 6 {
            0 | 1 => usize::from(header & 0x3F).max(1),
            2 => 3,
            _ => 1,
        };
        let (block, behind) = rest.split_at_checked(len).unwrap_or((rest, &[]));
        if header >> 6 == 0 {
            blocks.push(block.get(1..).unwrap_or_default().to_vec());
        }
        rest = behind;
    }
    blocks
}

/// The alarm in a diagnosis, and its data.
fn alarm_in(diagnosis: &Diagnosis) -> Option<(AlarmHead, Vec<u8>)> {
    blocks(diagnosis).iter().find_map(|block| match TypedBlock::parse(block) {
        Some(TypedBlock::Alarm { head, data }) => Some((head, data.to_vec())),
        Some(TypedBlock::Status { .. }) | None => None,
    })
}

/// The alarm that is announced and read.
fn read_alarm(tester: &mut Tester, what: &str) -> Course<(AlarmHead, Vec<u8>)> {
    if !is_announced(tester)? {
        return broken(format!("{what} is raised, and Data_Exchange does not answer with DH"));
    }
    let diagnosis = tester.diag()?;
    match alarm_in(&diagnosis) {
        Some(alarm) => Ok(alarm),
        None => broken(format!("{what} is raised, and Slave_Diag has no block of an alarm")),
    }
}

/// Nothing is announced, and no alarm stands in the diagnosis.
fn none_comes(tester: &mut Tester, what: &str) -> Course {
    is_announced(tester)?;
    match alarm_in(&tester.diag()?) {
        None => Ok(()),
        Some((head, _)) => broken(format!("{what}, and Slave_Diag has a {head}")),
    }
}

/// Raises it and reads it.
fn raise_and_read(tester: &mut Tester, raised: Raised) -> Course<AlarmHead> {
    raise(tester, raised)?;
    read_alarm(tester, &format!("a {} alarm", raised.kind)).map(|(head, _)| head)
}

fn ack(head: AlarmHead) -> Vec<u8> {
    let mut buf = [0; MAX_PDU];
    RequestPdu::AlarmAck(head).encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
}

/// It is acknowledged, and the slave takes it.
fn acknowledge(tester: &mut Tester, sap: u8, head: AlarmHead) -> Course {
    let channel = Channel { sa: tester.owner(), dsap: sap, ssap: MS1_SAP };
    let request = ack(head);
    let octets = tester.carried_out(channel, &request)?;
    if octets == request {
        return Ok(());
    }
    let (got, asked) = (crate::explain::hex(&octets), crate::explain::hex(&request));
    broken(format!("Alarm_Ack {asked} is answered with {got}, expected the same"))
}

fn r51(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    raise(tester, Raised::of(kind))?;
    let (head, octets) = read_alarm(tester, &format!("a {kind} alarm"))?;
    let expected = (AlarmType::named(kind), slot(tester), Specifier::Appears, data(tester));
    let got = (Some(head.kind), head.slot, head.specifier, octets);
    if got == expected {
        return Ok(());
    }
    broken(format!("the block says: {head}, data {}", crate::explain::hex(&got.3)))
}

fn r52(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    let head = raise_and_read(tester, Raised::of(kind))?;
    acknowledge(tester, MS1_SAP, head)
}

fn r53(tester: &mut Tester) -> Course {
    if !tester.keywords()?.extra_alarm_sap {
        return inapplicable("the device file has no Extra_Alarm_SAP_supp");
    }
    let (_, kind) = alarming(tester)?;
    let head = raise_and_read(tester, Raised::of(kind))?;
    acknowledge(tester, ALARM_SAP, head)
}

fn r54(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let octets = tester.carried_out(channel, &ACK_OF_NOTHING)?;
    must_refuse(&octets, "Alarm_Ack of an alarm that there is not")?;
    let Some(kind) = offered(tester)?.first().copied().filter(|_| tester.is_attended()) else {
        return Ok(());
    };
    let head = match raise(tester, Raised::of(kind)) {
        Err(crate::judge::device::course::Halt::Inapplicable(_)) => return Ok(()),
        course => course.and_then(|()| read_alarm(tester, &format!("a {kind} alarm")))?.0,
    };
    let other = AlarmHead { slot: head.slot.wrapping_add(77), ..head };
    let octets = tester.carried_out(channel, &ack(other))?;
    must_refuse(&octets, "Alarm_Ack of another slot")?;
    let octets = tester.carried_out(channel, &ack(head))?;
    if is_negative(&octets) {
        return broken("behind an Alarm_Ack of another slot the alarm can no longer be acknowledged");
    }
    let octets = tester.carried_out(channel, &ack(head))?;
    must_refuse(&octets, "a second Alarm_Ack")
}

fn r55(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    if tester.keywords()?.alarms_required != 0 {
        return inapplicable("the device file requires alarms");
    }
    tester.release()?;
    let prm = tester.prm_v1().status(1, 0, !Status2::CheckCfgMode.mask());
    tester.begin_with(&prm)?;
    raise_in_vain(tester, Raised::of(kind))?;
    none_comes(tester, &format!("a {kind} alarm is raised that Set_Prm has not enabled"))
}

fn r56(tester: &mut Tester) -> Course {
    alarming(tester)?;
    let alarms = tester.keywords()?.alarms;
    let not_offered =
        AlarmType::NAMED.iter().find(|(_, kind)| kind.enabled_by().is_some_and(|bit| !bit.is_set(alarms)));
    let Some((kind, bit)) = not_offered.and_then(|(word, kind)| Some((*word, kind.enabled_by()?))) else {
        return inapplicable("the device file offers every alarm");
    };
    tester.release()?;
    let prm = tester.prm_v1().status(1, bit.mask(), 0);
    tester.begin_with(&prm)?;
    raise_in_vain(tester, Raised::of(kind))?;
    none_comes(tester, &format!("a {kind} alarm is raised that the device file does not offer"))
}

fn r57(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    let keywords = tester.keywords()?;
    if keywords.c1_required || keywords.alarms_required != 0 {
        return inapplicable("the device file requires DPV1_Enable");
    }
    tester.release()?;
    let prm = tester.prm_v1().status(0, 0, Status1::Enable.mask());
    tester.begin_with(&prm)?;
    raise_in_vain(tester, Raised::of(kind))?;
    none_comes(tester, &format!("a {kind} alarm is raised without DPV1_Enable"))
}

fn r58(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    let head = raise_and_read(tester, Raised::of(kind))?;
    raise_in_vain(tester, Raised { specifier: "disappears", ..Raised::of(kind) })?;
    is_announced(tester)?;
    if let Some((second, _)) = alarm_in(&tester.diag()?).filter(|(second, _)| *second != head) {
        return broken(format!("{second} comes before {head} is acknowledged"));
    }
    acknowledge(tester, MS1_SAP, head)
}

fn r59(tester: &mut Tester) -> Course {
    let (_, first) = alarming(tester)?;
    let Some(second) = offered(tester)?.get(1).copied() else {
        return inapplicable("the device file offers one type of alarms only");
    };
    let first = raise_and_read(tester, Raised::of(first))?;
    let second = raise_and_read(tester, Raised::of(second))?;
    acknowledge(tester, MS1_SAP, first)?;
    acknowledge(tester, MS1_SAP, second)
}

/// In data exchange in sequence mode, two alarms at once.
fn in_sequence(tester: &mut Tester) -> Course<(Channel, &'static str)> {
    let (channel, kind) = alarming(tester)?;
    if tester.keywords()?.sequence < 2 {
        return inapplicable("the device file has no Alarm_Sequence_Mode_Count of 2 or more");
    }
    tester.release()?;
    let prm = tester.prm_v1().status(2, 1, 0);
    tester.begin_with(&prm)?;
    Ok((channel, kind))
}

fn r60(tester: &mut Tester) -> Course {
    let (_, kind) = in_sequence(tester)?;
    let first = raise_and_read(tester, Raised::of(kind))?;
    let second = raise_and_read(tester, Raised::of(kind))?;
    if first.sequence == second.sequence {
        return broken(format!("two open alarms have the number {}", first.sequence));
    }
    raise_in_vain(tester, Raised::of(kind))?;
    is_announced(tester)?;
    match alarm_in(&tester.diag()?).filter(|(third, _)| ![first, second].contains(third)) {
        Some((third, _)) => broken(format!("{third} comes while two are open, and Alarm_Mode 1 allows two")),
        None => Ok(()),
    }
}

fn r61(tester: &mut Tester) -> Course {
    let (_, kind) = in_sequence(tester)?;
    let first = raise_and_read(tester, Raised::of(kind))?;
    let second = raise_and_read(tester, Raised::of(kind))?;
    acknowledge(tester, MS1_SAP, second)?;
    acknowledge(tester, MS1_SAP, first)
}

fn r62(tester: &mut Tester) -> Course {
    let (channel, kind) = alarming(tester)?;
    let head = raise_and_read(tester, Raised::of(kind))?;
    let unlock = Prm::unlock(tester.ident, tester.setup.user_prm());
    tester.set_prm(&unlock)?;
    tester.open()?;
    none_comes(tester, "data exchange has ended and begun anew")?;
    let octets = tester.carried_out(channel, &ack(head))?;
    must_refuse(&octets, "Alarm_Ack of an alarm from before the new start")
}

fn r63(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    for (number, (specifier, expected)) in Specifier::NAMED.into_iter().enumerate() {
        let additional_ack = number % 2 == 1;
        let head = raise_and_read(tester, Raised { specifier, additional_ack, kind })?;
        if (head.specifier, head.additional_ack) != (expected, additional_ack) {
            let ack = u8::from(additional_ack);
            return broken(format!(
                "raised with specifier {specifier} and Add_Ack {ack}, the block says: {head}"
            ));
        }
        acknowledge(tester, MS1_SAP, head)?;
    }
    Ok(())
}

fn r64(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    let head = raise_and_read(tester, Raised::of(kind))?;
    acknowledge(tester, MS1_SAP, head)?;
    none_comes(tester, &format!("a {kind} alarm is acknowledged"))
}

fn r65(tester: &mut Tester) -> Course {
    let (_, kind) = alarming(tester)?;
    raise(tester, Raised::of(kind))?;
    if !is_announced(tester)? {
        return broken(format!("a {kind} alarm is raised, and Data_Exchange does not answer with DH"));
    }
    let other = tester.other();
    tester.diag_of(other)?;
    read_alarm(tester, &format!("a {kind} alarm that another master has read")).map(|_| ())
}

fn r66(tester: &mut Tester) -> Course {
    tester.has_ms1()?;
    if !tester.is_attended() {
        return inapplicable("needs --ask: send-status");
    }
    tester.open()?;
    let number = StatusType::Message.number();
    tester.attend(&format!("send-status {number} {} none", slot(tester)))?;
    if !is_announced(tester)? {
        return broken("a status message is sent, and Data_Exchange does not answer with DH");
    }
    let diagnosis = tester.diag()?;
    let is_message = |block: &Vec<u8>| {
        matches!(TypedBlock::parse(block), Some(TypedBlock::Status { kind: StatusType::Message, .. }))
    };
    if blocks(&diagnosis).iter().any(is_message) {
        return tester.still_exchanges("a status message");
    }
    broken("a status message is sent, and Slave_Diag has no block of the type 81")
}

fn r67(tester: &mut Tester) -> Course {
    let (channel, kind) = alarming(tester)?;
    let head = raise_and_read(tester, Raised::of(kind))?;
    tester.taken(channel, &Tester::probe(), "a Read at SAP 51")?;
    let busy = Answer::Status(ReplyStatus::NoResource);
    tester.put_is(channel, &ack(head), &busy, "Alarm_Ack while the response to a Read waits")?;
    if tester.keywords()?.extra_alarm_sap {
        acknowledge(tester, ALARM_SAP, head)?;
    }
    let octets = tester.response(channel)?;
    is_of_read(&octets)
}
