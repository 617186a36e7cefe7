//! Alarms and status messages. Only the device can raise them: `--ask raise-alarm`, `--ask send-status`.

use core::time::Duration;

use super::channel::{ACK_OF_NOTHING, is_of_read, must_refuse};
use super::{expected, likely, open, row};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::answer::{Answer, Diagnosis};
use crate::judge::device::slave::bench::{Channel, DIAG_LEN, Prm, is_negative};
use crate::judge::device::slave::wire::Sight;
use crate::profibus::dp::Service;
use crate::profibus::dp::dpv1_status::{Status1, Status2};
use crate::profibus::dpv1::{
    ALARM_SAP, AlarmHead, AlarmType, MAX_PDU, MS1_SAP, RequestPdu, Specifier, StatusType, TypedBlock,
};
use crate::profibus::fdl::ReplyStatus;

pub(super) const GROUP: Group<Bench> = Group {
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
fn offered(bench: &Bench) -> Course<Vec<&'static str>> {
    let alarms = bench.keywords()?.alarms;
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
fn alarming(bench: &mut Bench) -> Course<(Channel, &'static str)> {
    let Some(kind) = offered(bench)?.first().copied() else {
        return inapplicable("the device file offers no alarms");
    };
    if !bench.is_attended() {
        return inapplicable("needs --ask: raise-alarm");
    }
    let channel = bench.open()?;
    Ok((channel, kind))
}

fn slot(bench: &Bench) -> u8 {
    u8::from(bench.setup.gsd.as_ref().is_some_and(|gsd| gsd.is_modular()))
}

/// The data of alarms, as far as Slave_Diag has room.
fn data(bench: &Bench) -> Vec<u8> {
    let room = bench.setup.gsd.as_ref().is_some_and(|gsd| gsd.max_diag_len > 10);
    if room { vec![DATA] } else { Vec::new() }
}

/// Asks the device for an alarm.
fn raise(bench: &mut Bench, raised: Raised) -> Course {
    let (slot, data) = (slot(bench), data(bench));
    let hex: String = data.iter().map(|octet| format!("{octet:02X}")).collect();
    let ack = u8::from(raised.additional_ack);
    let action = format!("raise-alarm {} {slot} {} {ack} {hex}", raised.kind, raised.specifier);
    bench.attend(action.trim_end()).map(|_| ())
}

/// Asks for one that must not come: a device may say so.
fn raise_in_vain(bench: &mut Bench, raised: Raised) -> Course {
    match raise(bench, raised) {
        Err(crate::judge::device::course::Halt::Inapplicable(_)) => Ok(()),
        course => course,
    }
}

/// The effect of an action is there within so long.
fn effect(bench: &Bench) -> Duration {
    match bench.wire.sight {
        Sight::Exact => Duration::from_millis(50),
        Sight::Measured | Sight::Untimed => Duration::from_secs(1),
    }
}

/// Exchanges until DH comes; whether it came.
fn is_announced(bench: &mut Bench) -> Course<bool> {
    let until = bench.wire.now().saturating_add(effect(bench));
    let outputs = bench.zeros();
    while bench.wire.now() < until {
        let answer = bench.serve(bench.owner(), Service::DataExchange, &outputs)?;
        if bench.inputs_of(answer)?.0 == ReplyStatus::DataHigh {
            return Ok(true);
        }
        bench.pause(Duration::from_millis(2))?;
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
fn read_alarm(bench: &mut Bench, what: &str) -> Course<(AlarmHead, Vec<u8>)> {
    if !is_announced(bench)? {
        return broken(format!("{what} is raised, and Data_Exchange does not answer with DH"));
    }
    let diagnosis = bench.diag()?;
    match alarm_in(&diagnosis) {
        Some(alarm) => Ok(alarm),
        None => broken(format!("{what} is raised, and Slave_Diag has no block of an alarm")),
    }
}

/// Nothing is announced, and no alarm stands in the diagnosis.
fn none_comes(bench: &mut Bench, what: &str) -> Course {
    is_announced(bench)?;
    match alarm_in(&bench.diag()?) {
        None => Ok(()),
        Some((head, _)) => broken(format!("{what}, and Slave_Diag has a {head}")),
    }
}

/// Raises it and reads it.
fn raise_and_read(bench: &mut Bench, raised: Raised) -> Course<AlarmHead> {
    raise(bench, raised)?;
    read_alarm(bench, &format!("a {} alarm", raised.kind)).map(|(head, _)| head)
}

fn ack(head: AlarmHead) -> Vec<u8> {
    let mut buf = [0; MAX_PDU];
    RequestPdu::AlarmAck(head).encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
}

/// It is acknowledged, and the slave takes it.
fn acknowledge(bench: &mut Bench, sap: u8, head: AlarmHead) -> Course {
    let channel = Channel { sa: bench.owner(), dsap: sap, ssap: MS1_SAP };
    let request = ack(head);
    let octets = bench.carried_out(channel, &request)?;
    if octets == request {
        return Ok(());
    }
    let (got, asked) = (crate::explain::hex(&octets), crate::explain::hex(&request));
    broken(format!("Alarm_Ack {asked} is answered with {got}, expected the same"))
}

fn r51(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    raise(bench, Raised::of(kind))?;
    let (head, octets) = read_alarm(bench, &format!("a {kind} alarm"))?;
    let expected = (AlarmType::named(kind), slot(bench), Specifier::Appears, data(bench));
    let got = (Some(head.kind), head.slot, head.specifier, octets);
    if got == expected {
        return Ok(());
    }
    broken(format!("the block says: {head}, data {}", crate::explain::hex(&got.3)))
}

fn r52(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    let head = raise_and_read(bench, Raised::of(kind))?;
    acknowledge(bench, MS1_SAP, head)
}

fn r53(bench: &mut Bench) -> Course {
    if !bench.keywords()?.extra_alarm_sap {
        return inapplicable("the device file has no Extra_Alarm_SAP_supp");
    }
    let (_, kind) = alarming(bench)?;
    let head = raise_and_read(bench, Raised::of(kind))?;
    acknowledge(bench, ALARM_SAP, head)
}

fn r54(bench: &mut Bench) -> Course {
    let channel = bench.open()?;
    let octets = bench.carried_out(channel, &ACK_OF_NOTHING)?;
    must_refuse(&octets, "Alarm_Ack of an alarm that there is not")?;
    let Some(kind) = offered(bench)?.first().copied().filter(|_| bench.is_attended()) else { return Ok(()) };
    let head = match raise(bench, Raised::of(kind)) {
        Err(crate::judge::device::course::Halt::Inapplicable(_)) => return Ok(()),
        course => course.and_then(|()| read_alarm(bench, &format!("a {kind} alarm")))?.0,
    };
    let other = AlarmHead { slot: head.slot.wrapping_add(77), ..head };
    let octets = bench.carried_out(channel, &ack(other))?;
    must_refuse(&octets, "Alarm_Ack of another slot")?;
    let octets = bench.carried_out(channel, &ack(head))?;
    if is_negative(&octets) {
        return broken("behind an Alarm_Ack of another slot the alarm can no longer be acknowledged");
    }
    let octets = bench.carried_out(channel, &ack(head))?;
    must_refuse(&octets, "a second Alarm_Ack")
}

fn r55(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    if bench.keywords()?.alarms_required != 0 {
        return inapplicable("the device file requires alarms");
    }
    bench.release()?;
    let prm = bench.prm_v1().status(1, 0, !Status2::CheckCfgMode.mask());
    bench.begin_with(&prm)?;
    raise_in_vain(bench, Raised::of(kind))?;
    none_comes(bench, &format!("a {kind} alarm is raised that Set_Prm has not enabled"))
}

fn r56(bench: &mut Bench) -> Course {
    alarming(bench)?;
    let alarms = bench.keywords()?.alarms;
    let not_offered =
        AlarmType::NAMED.iter().find(|(_, kind)| kind.enabled_by().is_some_and(|bit| !bit.is_set(alarms)));
    let Some((kind, bit)) = not_offered.and_then(|(word, kind)| Some((*word, kind.enabled_by()?))) else {
        return inapplicable("the device file offers every alarm");
    };
    bench.release()?;
    let prm = bench.prm_v1().status(1, bit.mask(), 0);
    bench.begin_with(&prm)?;
    raise_in_vain(bench, Raised::of(kind))?;
    none_comes(bench, &format!("a {kind} alarm is raised that the device file does not offer"))
}

fn r57(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    let keywords = bench.keywords()?;
    if keywords.c1_required || keywords.alarms_required != 0 {
        return inapplicable("the device file requires DPV1_Enable");
    }
    bench.release()?;
    let prm = bench.prm_v1().status(0, 0, Status1::Enable.mask());
    bench.begin_with(&prm)?;
    raise_in_vain(bench, Raised::of(kind))?;
    none_comes(bench, &format!("a {kind} alarm is raised without DPV1_Enable"))
}

fn r58(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    let head = raise_and_read(bench, Raised::of(kind))?;
    raise_in_vain(bench, Raised { specifier: "disappears", ..Raised::of(kind) })?;
    is_announced(bench)?;
    if let Some((second, _)) = alarm_in(&bench.diag()?).filter(|(second, _)| *second != head) {
        return broken(format!("{second} comes before {head} is acknowledged"));
    }
    acknowledge(bench, MS1_SAP, head)
}

fn r59(bench: &mut Bench) -> Course {
    let (_, first) = alarming(bench)?;
    let Some(second) = offered(bench)?.get(1).copied() else {
        return inapplicable("the device file offers one type of alarms only");
    };
    let first = raise_and_read(bench, Raised::of(first))?;
    let second = raise_and_read(bench, Raised::of(second))?;
    acknowledge(bench, MS1_SAP, first)?;
    acknowledge(bench, MS1_SAP, second)
}

/// In data exchange in sequence mode, two alarms at once.
fn in_sequence(bench: &mut Bench) -> Course<(Channel, &'static str)> {
    let (channel, kind) = alarming(bench)?;
    if bench.keywords()?.sequence < 2 {
        return inapplicable("the device file has no Alarm_Sequence_Mode_Count of 2 or more");
    }
    bench.release()?;
    let prm = bench.prm_v1().status(2, 1, 0);
    bench.begin_with(&prm)?;
    Ok((channel, kind))
}

fn r60(bench: &mut Bench) -> Course {
    let (_, kind) = in_sequence(bench)?;
    let first = raise_and_read(bench, Raised::of(kind))?;
    let second = raise_and_read(bench, Raised::of(kind))?;
    if first.sequence == second.sequence {
        return broken(format!("two open alarms have the number {}", first.sequence));
    }
    raise_in_vain(bench, Raised::of(kind))?;
    is_announced(bench)?;
    match alarm_in(&bench.diag()?).filter(|(third, _)| ![first, second].contains(third)) {
        Some((third, _)) => broken(format!("{third} comes while two are open, and Alarm_Mode 1 allows two")),
        None => Ok(()),
    }
}

fn r61(bench: &mut Bench) -> Course {
    let (_, kind) = in_sequence(bench)?;
    let first = raise_and_read(bench, Raised::of(kind))?;
    let second = raise_and_read(bench, Raised::of(kind))?;
    acknowledge(bench, MS1_SAP, second)?;
    acknowledge(bench, MS1_SAP, first)
}

fn r62(bench: &mut Bench) -> Course {
    let (channel, kind) = alarming(bench)?;
    let head = raise_and_read(bench, Raised::of(kind))?;
    let unlock = Prm::unlock(bench.ident, bench.setup.user_prm());
    bench.set_prm(&unlock)?;
    bench.open()?;
    none_comes(bench, "data exchange has ended and begun anew")?;
    let octets = bench.carried_out(channel, &ack(head))?;
    must_refuse(&octets, "Alarm_Ack of an alarm from before the new start")
}

fn r63(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    for (number, (specifier, expected)) in Specifier::NAMED.into_iter().enumerate() {
        let additional_ack = number % 2 == 1;
        let head = raise_and_read(bench, Raised { specifier, additional_ack, kind })?;
        if (head.specifier, head.additional_ack) != (expected, additional_ack) {
            let ack = u8::from(additional_ack);
            return broken(format!(
                "raised with specifier {specifier} and Add_Ack {ack}, the block says: {head}"
            ));
        }
        acknowledge(bench, MS1_SAP, head)?;
    }
    Ok(())
}

fn r64(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    let head = raise_and_read(bench, Raised::of(kind))?;
    acknowledge(bench, MS1_SAP, head)?;
    none_comes(bench, &format!("a {kind} alarm is acknowledged"))
}

fn r65(bench: &mut Bench) -> Course {
    let (_, kind) = alarming(bench)?;
    raise(bench, Raised::of(kind))?;
    if !is_announced(bench)? {
        return broken(format!("a {kind} alarm is raised, and Data_Exchange does not answer with DH"));
    }
    let other = bench.other();
    bench.diag_of(other)?;
    read_alarm(bench, &format!("a {kind} alarm that another master has read")).map(|_| ())
}

fn r66(bench: &mut Bench) -> Course {
    bench.has_ms1()?;
    if !bench.is_attended() {
        return inapplicable("needs --ask: send-status");
    }
    bench.open()?;
    let number = StatusType::Message.number();
    bench.attend(&format!("send-status {number} {} none", slot(bench)))?;
    if !is_announced(bench)? {
        return broken("a status message is sent, and Data_Exchange does not answer with DH");
    }
    let diagnosis = bench.diag()?;
    let is_message = |block: &Vec<u8>| {
        matches!(TypedBlock::parse(block), Some(TypedBlock::Status { kind: StatusType::Message, .. }))
    };
    if blocks(&diagnosis).iter().any(is_message) {
        return bench.still_exchanges("a status message");
    }
    broken("a status message is sent, and Slave_Diag has no block of the type 81")
}

fn r67(bench: &mut Bench) -> Course {
    let (channel, kind) = alarming(bench)?;
    let head = raise_and_read(bench, Raised::of(kind))?;
    bench.taken(channel, &Bench::probe(), "a Read at SAP 51")?;
    let busy = Answer::Status(ReplyStatus::NoResource);
    bench.put_is(channel, &ack(head), &busy, "Alarm_Ack while the response to a Read waits")?;
    if bench.keywords()?.extra_alarm_sap {
        acknowledge(bench, ALARM_SAP, head)?;
    }
    let octets = bench.response(channel)?;
    is_of_read(&octets)
}
