//! Slaves with one mistake each.

use std::time::Duration;

use profidrive::judge::device::Ending;
use profidrive::judge::{Requirement as _, Verdict};
use profidrive::profibus::dp::State;
use profidrive::profibus::dp::policy::{NoEffect, WatchdogFactorZero};
use profidrive::profibus::fdl::{Address, Function, FunctionCode, Sap, Service};

mod addressing;
mod configuration;
mod control;
mod counting;
mod diagnosis;
mod dpv1;
mod dpv1_alarms;
mod dpv1_connections;
mod dpv1_records;
mod exchange;
mod framing;
mod parameters;
mod times;
mod watchdog;

pub(super) use dpv1::V1;

use super::broken;
use super::rig::{FULL, Mistake, RIGHT, SLAVE, Slave, changed, judged, parsed};
use crate::virtual_time::is_long;
use profidrive::judge::device::slave::Row;

const SET_PRM: Option<u8> = Some(61);
const CHK_CFG: Option<u8> = Some(62);
const SLAVE_DIAG: Option<u8> = Some(60);
const GET_CFG: Option<u8> = Some(59);
const CONTROL: Option<u8> = Some(58);
const RD_OUTP: Option<u8> = Some(57);
const RD_INP: Option<u8> = Some(56);
const SET_SLAVE_ADD: Option<u8> = Some(55);

const OWNER: u8 = 2;
const OTHER: u8 = 4;

const RS: [u8; 6] = [0x10, 0x02, 0x05, 0x03, 0x0A, 0x16];

fn sa(octets: &[u8]) -> u8 {
    parsed(octets).map_or(0, |data| data.sa.number())
}

fn service(octets: &[u8]) -> Option<Service> {
    match parsed(octets)?.fc.function() {
        Function::Request(service, _) => Some(service),
        _ => None,
    }
}

/// A Data_Exchange.
fn is_exchange(octets: &[u8]) -> bool {
    let srd = matches!(service(octets), Some(Service::SrdHigh | Service::SrdLow));
    srd && Slave::dsap(octets).is_none()
}

fn data(octets: &[u8]) -> Vec<u8> {
    parsed(octets).map_or(Vec::new(), |data| data.data.to_vec())
}

fn is_wrong(octets: &[u8]) -> bool {
    parsed(octets).is_none()
}

/// Another address of the one that it is for.
fn to(octets: &[u8], address: u8) -> Vec<u8> {
    changed(octets, |data, _| data.da = Address::from_octet(address))
}

/// RS to whoever has asked.
fn refused(slave: &Slave) -> Vec<u8> {
    let sa = sa(&slave.request);
    changed(&RS, |data, _| data.da = Address::from_octet(sa))
}

/// The octet of a diagnosis.
fn diag(slave: &Slave, reply: &[u8], change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    if Slave::dsap(&slave.request) == SLAVE_DIAG && data(reply).len() >= 6 {
        changed(reply, |_, octets| change(octets))
    } else {
        reply.to_vec()
    }
}

/// The time that a mistake remembers.
fn before(slave: &Slave) -> u64 {
    slave.memory.iter().fold(0, |sum, octet| sum << 8 | u64::from(*octet))
}

fn drops(octets: Vec<u8>, is_dropped: bool) -> Vec<u8> {
    if is_dropped { Vec::new() } else { octets }
}

/// A Set_Prm of the owner, of which the slave knows nothing on the line.
fn prm(bits: u8, factors: [u8; 2]) -> Vec<u8> {
    let data = [bits, factors[0], factors[1], 11, 0x12, 0x34, 0, 1, 2];
    changed(&[0x68, 0x05, 0x05, 0x68, 0x85, 0x82, 0x6D, 0x3D, 0x3E, 0xEF, 0x16], |_, octets| {
        *octets = data.to_vec();
    })
}

/// The checksum of a telegram is made right, and its end.
fn mended(octets: &[u8]) -> Vec<u8> {
    let mut octets = octets.to_vec();
    let len = octets.len();
    if len < 6 {
        return octets;
    }
    let begin = if octets[0] == 0x68 { 4 } else { 1 };
    octets[len - 2] = octets[begin..len - 2].iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    octets
}

const MORE_INPUTS: &str = "Freeze_Mode_supp=1\nSync_Mode_supp=1\nModule=\"out\" 0x21\nEndModule\n";
const EIGHT: &str = "Freeze_Mode_supp=1\nSync_Mode_supp=1\nModule=\"8 octets\" 0xF3\nEndModule\n";
const PLAIN: &str = "Module=\"2 words\" 0xF1\nEndModule\n";
const SAFE: &str = "Fail_Safe=1\nFreeze_Mode_supp=1\nSync_Mode_supp=1\nModule=\"2 words\" 0xF1\nEndModule\n";
const MODULAR: &str = "Modular_Station=1\nMax_Module=2\nMax_Input_Len=8\nMax_Output_Len=8\nMax_Data_Len=16\nSync_Mode_supp=1\n\
     Freeze_Mode_supp=1\nModule=\"2 words\" 0xF1\nEndModule\nModule=\"1 word\" 0xF0\nEndModule\n";

/// Slaves that are right, of every kind.
static RIGHT_ONES: [Mistake; 8] = [
    RIGHT,
    Mistake { name: "without inputs", file: MORE_INPUTS, ..RIGHT },
    Mistake { name: "with eight octets", file: EIGHT, ..RIGHT },
    Mistake { name: "without Sync and Freeze", file: PLAIN, ..RIGHT },
    Mistake { name: "with Fail_Safe", file: SAFE, ..RIGHT },
    Mistake { name: "modular", file: MODULAR, ..RIGHT },
    Mistake { name: "with DP-V1", file: dpv1::V1, ..RIGHT },
    Mistake { name: "with required services of DP-V1", file: dpv1_alarms::REQUIRED, ..RIGHT },
];

/// The frame count is not wanted any more.
fn leaves(slave: &mut Slave) {
    slave.station().abort();
}

fn controls(octets: &[u8]) -> bool {
    Slave::dsap(octets) == CONTROL
}

/// The mistakes, by the rows that they are about.
fn lists() -> [&'static [Mistake]; 17] {
    [
        framing::FRAMING,
        counting::COUNTING,
        parameters::PARAMETERS,
        configuration::CONFIGURATION,
        diagnosis::DIAGNOSIS,
        exchange::EXCHANGE,
        control::CONTROLLED,
        addressing::ADDRESSES,
        watchdog::WATCHDOG,
        times::TIMES,
        dpv1::CHANNEL,
        dpv1_records::RECORDS,
        dpv1_records::LIFE,
        dpv1_records::IDENTIFIED,
        dpv1_alarms::PARAMETERS_V1,
        dpv1_alarms::ALARMS,
        dpv1_connections::CONNECTIONS,
    ]
}

fn all() -> impl Iterator<Item = &'static Mistake> {
    lists().into_iter().flatten()
}

#[test]
fn correct_slaves_of_every_kind_are_not_accused() {
    for right in &RIGHT_ONES {
        let report = judged(right, &Row::all());
        assert!(broken(&report).is_empty(), "{}: {report}", right.name);
        assert_eq!(report.outcome().status(), 0, "{}: {report}", right.name);
    }
}

/// A row and those that it needs.
fn with_needs(id: &str) -> Vec<Row> {
    let row = Row::named(id).unwrap_or_else(|| panic!("there is no row {id}"));
    let needed = row.needs().iter().copied().flat_map(with_needs);
    needed.chain([row]).collect()
}

/// The rows by which a mistake is judged: with `PROFIDRIVE_LONG` every one, else those that it breaks, a share that goes
/// round, and what they need.
fn rows_for(number: usize, mistake: &Mistake) -> Vec<Row> {
    const SHARES: usize = 8;
    if is_long() {
        return Row::all();
    }
    let share = Row::all().into_iter().skip(number % SHARES).step_by(SHARES).map(|row| row.id());
    let mut rows: Vec<Row> = mistake.rows.iter().copied().chain(share).flat_map(with_needs).collect();
    rows.sort();
    rows.dedup();
    rows
}

fn each_is_found(mistakes: impl Iterator<Item = &'static Mistake>) {
    let mut wrong = Vec::new();
    for (number, mistake) in mistakes.enumerate() {
        let mut report = judged(mistake, &rows_for(number, mistake));
        // What is noticed on the way may need rows that are not in the share.
        if broken(&report) != mistake.rows {
            report = judged(mistake, &Row::all());
        }
        if broken(&report) != mistake.rows {
            wrong.push(format!("{}: {:?}, expected {:?}", mistake.name, broken(&report), mistake.rows));
        }
    }
    assert!(wrong.is_empty(), "{} mistakes:\n{}", wrong.len(), wrong.join("\n"));
}

// Two tests, so that two cores share them.
#[test]
fn each_mistake_is_found_by_its_rows_and_by_no_other() {
    assert_eq!(all().count(), 249);
    each_is_found(all().step_by(2));
}

#[test]
fn each_other_mistake_is_found_by_its_rows_and_by_no_other() {
    each_is_found(all().skip(1).step_by(2));
}

/// Rows that no mistake of these slaves breaks: they need what these slaves do not have.
const UNPROVED: [&str; 2] = ["S-F08", "S-T03"];

#[test]
fn every_row_that_is_judged_has_a_mistake() {
    // Those of drives and of rates have mistakes of their own.
    let judged = |row: &Row| {
        row.unseen().is_none()
            && !["P-", "S-R"].iter().any(|own| row.id().starts_with(own))
            && row.group() != super::drives::GROUP
    };
    for row in Row::all().into_iter().filter(judged) {
        let has = all().any(|mistake| mistake.rows.contains(&row.id()));
        assert_ne!(has, UNPROVED.contains(&row.id()), "{row:?}");
    }
}

#[test]
fn whoever_dies_or_babbles_fails_the_row_that_was_tried() {
    static DIES: Mistake = Mistake {
        name: "a wrong checksum kills it",
        does: |slave, octets| {
            if is_wrong(octets) && octets.len() > 5 {
                slave.dead = true;
            }
        },
        ..RIGHT
    };
    static BABBLES: Mistake = Mistake {
        name: "a wrong checksum makes it babble",
        does: |slave, octets| {
            if is_wrong(octets) && octets.len() > 5 {
                for at in 0..5000 {
                    slave.say(Duration::from_micros(400 * at), &[0x55; 3]);
                }
            }
        },
        ..RIGHT
    };
    let died = judged(&DIES, &Row::all());
    assert!(matches!(died.ending, Ending::Died { during: "S-F03" }), "{died}");
    assert_eq!((broken(&died), died.outcome().status()), (vec!["S-F03"], 1), "{died}");
    let babbled = judged(&BABBLES, &Row::all());
    assert!(matches!(babbled.ending, Ending::Babbles { during: "S-F03" }), "{babbled}");
    assert_eq!(babbled.outcome().status(), 1, "{babbled}");
}

#[test]
fn nobody_and_no_data_exchange_are_no_verdict_on_the_slave() {
    static NOBODY: Mistake = Mistake { name: "nobody", hears: |_, _| Vec::new(), ..RIGHT };
    let report = judged(&NOBODY, &Row::all());
    assert_eq!((&report.ending, report.outcome().status()), (&Ending::NoDevice, 3), "{report}");
    assert!(report.judgements.iter().all(|judgement| judgement.verdict == Verdict::NotJudged), "{report}");
    let report =
        judged(exchange::EXCHANGE.iter().find(|mistake| mistake.rows == ["S-G01"]).unwrap(), &Row::all());
    assert_eq!(report.outcome().status(), 3, "{report}");
}
