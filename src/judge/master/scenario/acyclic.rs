//! Scenarios for the services of DP-V1: what the slaves do while a master asks for them by itself, or because its user
//! wants it.

use core::time::Duration;

use super::{Act, Check, Need, Scenario, Step, Which};
use crate::judge::master::observer::MOST_BESIDE;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::{Setup, Slave};
use crate::profibus::dpv1::RequestPdu;
use crate::profibus::fdl::Address;

/// Cycles and time in which a master that asks from time to time has asked.
const CYCLES: u32 = 150;
const TIME: Duration = Duration::from_millis(1500);
/// In so many cycles it has asked, and the observer has found that it does not poll for that.
const FOUND: u32 = CYCLES + MOST_BESIDE;
/// So many times C1_Response_Timeout a job does not end.
const STUCK: u32 = 4;
/// An alarm is acknowledged in this time.
const ALARM: Duration = Duration::from_millis(2500);
/// The record that the user of the master reads and writes.
const RECORD: (u8, u8) = (1, 1);

fn step(act: Act, lasts: Duration) -> Step {
    Step { act: Some(act), lasts, cycles: CYCLES, ..Step::default() }
}

fn usual() -> Step {
    Step { cycles: 0, ..step(Act::UsualRecords, Duration::from_millis(100)) }
}

fn told(name: &str, rows: &[Row], steps: Vec<Step>) -> Scenario {
    Scenario { station: Which::Services, steps, ..Scenario::one(name, rows, &[]) }
}

/// What the slaves of DP-V1 do; nothing without one.
pub(in crate::judge::master) fn acyclic(setup: &Setup) -> Vec<Scenario> {
    let Some(slave) = setup.present().find(|slave| setup.has_services(slave)) else { return Vec::new() };
    let stuck = slave.response_timeout().unwrap_or(TIME) * STUCK;
    let lost = |number: &str| {
        let name = format!("the reply to a request or a poll of DP-V1 is lost ({number})");
        told(&name, &[Row::C03, Row::C04], vec![step(Act::LoseResponse, TIME)])
    };
    let forgets = Step {
        faults: vec!["lose-prm,count=1,station=S".to_owned()],
        until_injected: true,
        ..step(Act::StuckRecords, TIME)
    };
    let mut list = vec![
        told(
            "jobs of DP-V1 take a while",
            &[Row::V05, Row::V03, Row::V04, Row::V06],
            vec![Step { cycles: FOUND, ..step(Act::SlowRecords, TIME) }, usual()],
        ),
        told("jobs of DP-V1 are refused", &[Row::V07], vec![step(Act::RefuseRecords, TIME), usual()]),
        lost("first"),
        lost("second"),
    ];
    if !setup.is_class_2() {
        let before = Step { cycles: CYCLES / 3, ..step(Act::StuckRecords, TIME / 4) };
        let alarms = &[Row::V12, Row::V11, Row::V13];
        list.push(told("alarms of the slave", alarms, vec![step(Act::RaiseAlarms, ALARM)]));
        list.push(told(
            "a slave loses its parameters while a job runs",
            &[Row::V10],
            vec![before, forgets, step(Act::UsualRecords, TIME)],
        ));
        list.push(Scenario {
            needs: vec![Need::ResponseTimeout],
            ..told("a job of DP-V1 does not end", &[Row::V09], vec![step(Act::StuckRecords, stuck), usual()])
        });
    }
    list
}

/// What the user of a master asks for.
pub(super) fn asked(slave: &Slave) -> Vec<Scenario> {
    let (slot, index) = RECORD;
    let station = slave.address;
    let data = [0xC3, 0x5A];
    let request = |pdu: RequestPdu<'_>| {
        let mut buf = [0; crate::profibus::dpv1::MAX_PDU];
        pdu.encode(&mut buf).unwrap_or_default().to_vec()
    };
    let ask = |name: &str, action: String, pdu: RequestPdu<'_>| {
        let check = Some(Check::Service(station, request(pdu)));
        let step = Step { ask: Some(action), check, lasts: Duration::from_secs(1), ..Step::default() };
        told(name, &[Row::V21], vec![step])
    };
    let written: String = data.iter().map(|octet| format!("{octet:02X}")).collect();
    let place = |station: Address| format!("{station} {slot} {index}");
    vec![
        ask(
            "a record is written for the user",
            format!("write {} {written}", place(station)),
            RequestPdu::Write { slot, index, data: &data },
        ),
        ask(
            "a record is read for the user",
            format!("read {} 2", place(station)),
            RequestPdu::Read { slot, index, len: 2 },
        ),
    ]
}
