//! A slave of DP-V1 as its owner sees it: records at SAP 51, alarms, the life of the channel (`dp-v1.md` 11).

use std::time::Duration;

use profidrive::profibus::dp::{Description, State};
use profidrive::profibus::dpv1::{AlarmState, AlarmType, Event, NotRaised, Offer, Specifier, StatusType};
use profidrive::profibus::fdl::{FrameCount, Service};

use crate::dpv1_line::{CFG, DEVICE, FULL, OTHER, OWNER, PRM, Record, Request, V1Line};
use crate::slave_line::{Answer, RR, RS};
use crate::telegrams::hex;

const READ: [u8; 4] = [0x5E, 1, 10, 240];
const DATA: [u8; 8] = [0x5E, 1, 10, 4, 0x11, 0x22, 0x33, 0x44];

fn record(len: usize) -> Record {
    Record { data: (0..len).map(|octet| octet as u8).collect(), ..Record::default() }
}

#[test]
fn v1_r02_v1_r06_v1_r31_the_telegrams_are_those_of_the_reference() {
    let mut line = V1Line::new(FULL);
    for (request, reply) in [
        ("68 0F 0F 68 87 82 6D 3D 3E 88 0A 0A 0B C0 DE 00 80 60 00 16 16", "E5"),
        ("68 06 06 68 87 82 5D 3E 3E 31 13 16", "E5"),
        ("68 09 09 68 87 82 7D 33 33 5E 01 0A 08 5D 16", "E5"),
        ("68 05 05 68 87 82 5D 33 33 CC 16", "68 0D 0D 68 82 87 08 33 33 5E 01 0A 04 11 22 33 44 8E 16"),
        ("68 0D 0D 68 87 82 7D 33 33 5F 01 0A 04 AA BB CC DD 68 16", "E5"),
        ("68 05 05 68 87 82 5D 33 33 CC 16", "68 09 09 68 82 87 08 33 33 5F 01 0A 04 E5 16"),
        ("68 09 09 68 87 82 7D 33 33 5E 01 0B 08 5E 16", "E5"),
        ("68 05 05 68 87 82 5D 33 33 CC 16", "68 09 09 68 82 87 08 33 33 DE 80 B0 00 85 16"),
        ("68 0D 0D 68 87 82 7D 33 33 5F 00 FF 04 08 00 FD E8 3B 16", "E5"),
    ] {
        assert_eq!(line.send(&hex(request)), Some(hex(reply)), "{request}");
    }
}

#[test]
fn v1_r01_v1_r03_v1_r39_the_channel_is_there_in_data_exchange_with_dp_v1_enabled() {
    let mut line = V1Line::new(FULL);
    assert_eq!(line.ms1(&READ), RS, "WAIT-PRM");
    assert_eq!(line.dp(OWNER, 61, &PRM), Answer::Sc);
    assert_eq!(line.ms1(&READ), RS, "WAIT-CFG");
    let mut as_v0 = PRM;
    as_v0[7] = 0;
    line.start(OWNER, &as_v0);
    assert_eq!(line.ms1(&READ), RS, "DPV1_Enable is 0");
    assert_eq!(line.exchange(), Answer::Low(vec![0, 0]));
}

#[test]
fn v1_r04_v1_r40_only_the_owner_is_served() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ms1(&READ), Answer::Sc);
    assert_eq!(line.srd(OTHER, Some((51, 51)), Service::SrdLow, &READ), RS);
    assert_eq!(line.srd(OTHER, Some((51, 51)), Service::SrdLow, &[]), RS);
    assert_eq!(line.exchange(), Answer::Low(vec![0, 0]));
    assert_eq!(line.ms1(&[]), Answer::Low(DATA.to_vec()));
    let mut unlock = PRM;
    unlock[0] = 0x40;
    assert_eq!(line.dp(OWNER, 61, &unlock), Answer::Sc);
    line.start(OTHER, &PRM);
    assert_eq!(line.ms1(&READ), RS, "the old one");
    assert_eq!(line.srd(OTHER, Some((51, 51)), Service::SrdLow, &READ), Answer::Sc);
    assert_eq!(line.srd(OTHER, Some((51, 51)), Service::SrdLow, &[]), Answer::Low(DATA.to_vec()));
}

#[test]
fn v1_r05_v1_r07_v1_r08_v1_r12_a_request_is_acknowledged_and_its_response_handed_over_once() {
    for service in [Service::SrdLow, Service::SrdHigh] {
        let mut line = V1Line::exchanging(FULL);
        let saps = Some((51, 51));
        assert_eq!(line.srd(OWNER, saps, service, &[]), Answer::Sc, "no job");
        assert_eq!(line.srd(OWNER, saps, service, &READ), Answer::Sc);
        assert_eq!(line.srd(OWNER, saps, service, &[]), Answer::Low(DATA.to_vec()));
        assert_eq!(line.srd(OWNER, saps, service, &[]), Answer::Sc);
    }
}

#[test]
fn v1_r09_a_second_request_finds_no_resource_and_the_first_goes_on() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ms1(&READ), Answer::Sc);
    assert_eq!(line.ms1(&[0x5E, 0, 1, 1]), RR);
    assert_eq!(line.ms1(&[]), Answer::Low(DATA.to_vec()));
    assert_eq!(line.ask(&READ), DATA);
}

#[test]
fn v1_r10_v1_r11_a_retry_runs_nothing_twice() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ms1(&[0x5F, 1, 10, 4, 1, 2, 3, 4]), Answer::Sc);
    assert_eq!(line.retry(), Answer::Sc);
    assert_eq!(line.records.runs, 1);
    let written = Answer::Low(vec![0x5F, 1, 10, 4]);
    assert_eq!(line.ms1(&[]), written);
    assert_eq!(line.retry(), written);
    assert_eq!(line.retry(), written);
    assert_eq!((line.ms1(&[]), line.records.runs), (Answer::Sc, 1));
}

#[test]
fn v1_r13_a_write_in_sd3_is_taken() {
    let mut line = V1Line::exchanging(FULL);
    line.put(1, 11, record(2));
    // DA 87, SA 82, FC, DSAP 51, SSAP 51, 5F 01 0B 02 and two octets in eleven: SD3 has eight octets behind FC.
    let body = [0x87, 0x82, 0x5D, 51, 51, 0x5F, 1, 11, 2, 9, 8];
    let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    let octets = [&[0xA2][..], &body, &[sum, 0x16]].concat();
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    assert_eq!(line.records.records[&(1, 11)].data, [9, 8]);
}

#[test]
fn v1_r14_the_response_waits_while_data_and_diagnosis_are_exchanged() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ms1(&READ), Answer::Sc);
    for _ in 0..3 {
        assert_eq!(line.exchange(), Answer::Low(vec![0, 0]));
        assert_eq!(line.diagnosis(OWNER), [0; 0]);
    }
    assert_eq!(line.ms1(&[]), Answer::Low(DATA.to_vec()));
}

#[test]
fn v1_r15_v1_r16_v1_r17_what_is_not_offered_is_refused() {
    let mut line = V1Line::exchanging(Offer::NONE);
    for sap in [49, 50, 51, 48, 0] {
        assert_eq!(line.srd(OWNER, Some((sap, 50)), Service::SrdLow, &READ), RS, "SAP {sap}");
    }
    let mut offer = FULL;
    offer.alarms.extra_sap = false;
    let mut line = V1Line::exchanging(offer);
    assert_eq!(line.srd(OWNER, Some((50, 51)), Service::SrdLow, &[]), RS);
}

#[test]
fn v1_r18_v1_r19_v1_r20_v1_r23_a_record_is_read_and_written() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ask(&[0x5E, 1, 10, 4]), DATA, "exact");
    assert_eq!(line.ask(&READ), DATA, "240 asked");
    assert_eq!(line.ask(&[0x5E, 1, 10, 2]), [0x5E, 1, 10, 2, 0x11, 0x22], "fewer");
    assert_eq!(line.ask(&[0x5F, 1, 10, 4, 9, 8, 7, 6]), [0x5F, 1, 10, 4]);
    assert_eq!(line.ask(&READ), [0x5E, 1, 10, 4, 9, 8, 7, 6]);
    let words: Vec<_> = line.events.iter().map(ToString::to_string).collect();
    assert_eq!(words[3], "master 2 wrote record 10 of slot 1, 4 octets");
    assert_eq!(words[4], "master 2 read record 10 of slot 1, 4 octets");
}

#[test]
fn v1_r21_v1_r22_v1_r24_v1_r25_v1_r26_v1_r27_what_cannot_be_is_refused_with_its_code() {
    let mut line = V1Line::exchanging(FULL);
    line.put(2, 1, Record { read_only: true, ..record(2) });
    line.put(2, 2, Record { write_only: true, ..record(2) });
    for (request, response) in [
        (&[0x5E, 1, 99, 8][..], [0xDE, 0x80, 0xB0, 0]),
        (&[0x5E, 9, 10, 8], [0xDE, 0x80, 0xB2, 0]),
        (&[0x5E, 255, 10, 8], [0xDE, 0x80, 0xB2, 0]),
        (&[0x5F, 1, 10, 3, 1, 2, 3], [0xDF, 0x80, 0xB1, 0]),
        (&[0x5F, 1, 10, 5, 1, 2, 3, 4, 5], [0xDF, 0x80, 0xB1, 0]),
        (&[0x5F, 2, 1, 2, 1, 2], [0xDF, 0x80, 0xB6, 0]),
        (&[0x5E, 2, 2, 8], [0xDE, 0x80, 0xB6, 0]),
        (&[0x5E, 1, 10, 0], [0xDE, 0x80, 0xB7, 0]),
    ] {
        assert_eq!(line.ask(request), response, "{request:02X?}");
    }
    assert_eq!(line.ask(&READ), DATA, "kept");
    assert_eq!(line.ask(&[0x5E, 2, 1, 8]), [0x5E, 2, 1, 2, 0, 1], "kept, read-only");
    let refused = line.events.iter().find(|event| event.is_refusal()).unwrap();
    assert_eq!(
        refused.to_string(),
        "refused Read of record 99 of slot 1 of master 2: access, invalid index (80 B0 00): the slot has no record of this index"
    );
}

#[test]
fn v1_r28_v1_r29_the_longest_record_and_what_the_gsd_cuts() {
    let mut line = V1Line::exchanging(FULL);
    line.put(1, 1, record(240));
    let data = record(240).data;
    let written = [&[0x5F, 1, 1, 240][..], &data].concat();
    assert_eq!(line.ask(&written), [0x5F, 1, 1, 240]);
    let read = [&[0x5E, 1, 1, 240][..], &data].concat();
    assert_eq!(line.ask(&[0x5E, 1, 1, 240]), read);
    // The octets on the line, both ways: LE 249, the most there is.
    let telegram = |count, data: Vec<u8>| {
        Request { sa: OWNER, saps: Some((51, 51)), service: Service::SrdLow, count, data }.octets()
    };
    let asked = telegram(FrameCount::Odd, written);
    assert_eq!((asked[1], asked.len(), line.send(&asked)), (249, 255, Some(vec![0xE5])));
    line.send(&telegram(FrameCount::Even, Vec::new()));
    line.send(&telegram(FrameCount::Odd, vec![0x5E, 1, 1, 240]));
    let reply = line.send(&telegram(FrameCount::Even, Vec::new())).unwrap();
    assert_eq!((reply[1], reply.len(), &reply[9..253]), (249, 255, &read[..]));
    let mut line = V1Line::exchanging(Offer { ms1: Some(32), ..FULL });
    line.put(1, 1, record(64));
    assert_eq!(line.ask(&[0x5E, 1, 1, 64]), [&[0x5E, 1, 1, 32][..], &data[..32]].concat());
    assert_eq!(line.ask(&[&[0x5F, 1, 1, 64][..], &data[..64]].concat()), [0xDF, 0x80, 0xB1, 0]);
}

#[test]
fn v1_r30_what_is_no_request_is_refused_and_nothing_breaks() {
    let mut line = V1Line::exchanging(FULL);
    for octets in [
        &[0x99][..],
        &[0x42, 1, 2, 3],
        &[0x5E],
        &[0x5E, 1],
        &[0x5E, 1, 10],
        &[0x5E, 1, 10, 4, 4],
        &[0x5F, 1, 10, 5, 1],
        &[0x5F, 1, 10, 0],
        &[0x48],
        &[0x51, 0, 0, 1, 1],
        &[0x57; 20],
        &[0xDE, 0x80, 0xB0, 0],
    ] {
        let answer = line.ask(octets);
        assert!(matches!(answer[..], [0x80..=0xFF, 0x80, 0xA9 | 0xB7, 0]), "{octets:02X?}: {answer:02X?}");
        assert_eq!(answer[0] & 0x7F, octets[0] & 0x7F);
    }
    assert_eq!((line.ask(&READ), line.station.slave().state()), (DATA.to_vec(), State::DataExch));
}

#[test]
fn v1_r32_a_slow_record_is_polled_until_it_is_there() {
    let mut line = V1Line::exchanging(FULL);
    line.put(1, 1, Record { delay: Duration::from_millis(50), ..record(1) });
    assert_eq!(line.ms1(&[0x5E, 1, 1, 1]), Answer::Sc);
    for _ in 0..4 {
        line.wait(Duration::from_millis(10));
        assert_eq!(line.ms1(&[]), Answer::Sc);
    }
    line.wait(Duration::from_millis(20));
    assert_eq!(line.ms1(&[]), Answer::Low(vec![0x5E, 1, 1, 1, 0]));
}

#[test]
fn v1_r34_v1_r35_v1_r36_v1_r37_the_channel_ends_with_the_data_exchange_and_forgets() {
    type End = fn(&mut V1Line);
    let unlock: End = |line| {
        let mut unlock = PRM;
        unlock[0] = 0x40;
        assert_eq!(line.dp(OWNER, 61, &unlock), Answer::Sc);
    };
    let silence: End = |line| line.wait(Duration::from_millis(1100));
    let bad_prm: End = |line| assert_eq!(line.dp(OWNER, 61, &PRM[..9]), Answer::Sc);
    let bad_cfg: End = |line| assert_eq!(line.dp(OWNER, 62, &[0x99]), Answer::Sc);
    let outputs: End = |line| assert_eq!(line.srd(OWNER, None, Service::SrdHigh, &[0; 3]), RS);
    for (place, end) in [unlock, silence, bad_prm, bad_cfg, outputs].into_iter().enumerate() {
        let mut line = V1Line::exchanging(FULL);
        assert_eq!(line.ms1(&READ), Answer::Sc);
        end(&mut line);
        assert_eq!(line.ms1(&[]), RS, "end {place}");
        line.start(OWNER, &PRM);
        assert_eq!(line.ms1(&[]), Answer::Sc, "nothing old: end {place}");
        assert_eq!(line.ask(&READ), DATA);
    }
    // The same from the start.
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ms1(&READ), Answer::Sc);
    line.start(OWNER, &PRM);
    assert_eq!(line.ms1(&[]), Answer::Sc);
    assert_eq!(line.ask(&READ), DATA);
}

#[test]
fn v1_r38_clear_and_fail_safe_change_nothing() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ms1(&READ), Answer::Sc);
    line.control(0x02);
    assert_eq!(line.ms1(&[]), Answer::Low(DATA.to_vec()));
    assert_eq!(line.ask(&READ), DATA);
    // Data_Exchange without outputs: the safe state.
    let device = Description { fail_safe: true, dpv1_status: Some([0xFF; 3]), ..DEVICE };
    let mut line = V1Line::of(device, FULL);
    let mut prm = PRM;
    prm[7] |= 0x40;
    line.start(OWNER, &prm);
    assert_eq!(line.ms1(&READ), Answer::Sc);
    assert_eq!(line.srd(OWNER, None, Service::SrdHigh, &[]), Answer::Low(vec![0, 0]));
    assert!(line.station.slave().safe_state());
    assert_eq!(line.ms1(&[]), Answer::Low(DATA.to_vec()));
    assert_eq!(line.ask(&READ), DATA);
}

const ACK: [u8; 4] = [0x5C, 1, 2, 1];

#[test]
fn v1_r51_v1_r52_v1_r64_an_alarm_is_announced_read_and_acknowledged() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.diagnosis(OWNER), [0; 0]);
    line.raise(AlarmType::Process, &[0x50]).unwrap();
    assert_eq!(line.exchange(), Answer::High(vec![0, 0]));
    assert_eq!(line.ms1(&ACK), Answer::Sc, "not read yet");
    assert_eq!(line.ms1(&[]), Answer::Low(vec![0xDC, 0x80, 0xB5, 0]));
    assert_eq!(line.diagnosis(OWNER), [5, 2, 1, 1, 0x50]);
    assert_eq!(line.acyclic.alarms()[0].state, AlarmState::Delivered);
    assert_eq!(line.exchange(), Answer::Low(vec![0, 0]));
    assert_eq!(line.diagnosis(OWNER), [0; 0], "it was read");
    assert_eq!(line.ask(&ACK), ACK);
    assert!(line.acyclic.alarms().is_empty());
    let words: Vec<_> = line.events.iter().map(ToString::to_string).collect();
    assert_eq!(words[1], "master 2 has read the process alarm of slot 1 appears, number 0");
    assert_eq!(words[2], "master 2 has acknowledged the process alarm of slot 1 appears, number 0");
}

#[test]
fn v1_r53_v1_r67_sap_50_acknowledges_beside_a_running_read() {
    let mut line = V1Line::exchanging(FULL);
    line.raise(AlarmType::Process, &[]).unwrap();
    assert_eq!(line.diagnosis(OWNER), [4, 2, 1, 1]);
    assert_eq!(line.ms1(&READ), Answer::Sc);
    assert_eq!(line.ms1(&ACK), RR);
    let saps = Some((50, 51));
    assert_eq!(line.srd(OWNER, saps, Service::SrdLow, &ACK), Answer::Sc);
    assert_eq!(line.srd(OWNER, saps, Service::SrdLow, &[]), Answer::Low(ACK.to_vec()));
    assert!(line.acyclic.alarms().is_empty());
    assert_eq!(line.ms1(&[]), Answer::Low(DATA.to_vec()));
    assert_eq!(line.srd(OWNER, saps, Service::SrdLow, &READ), Answer::Sc, "no records there");
    assert_eq!(line.srd(OWNER, saps, Service::SrdLow, &[]), Answer::Low(vec![0xDE, 0x80, 0xA9, 0]));
}

#[test]
fn v1_r54_an_acknowledgement_of_nothing_is_refused_and_the_alarm_stays() {
    let mut line = V1Line::exchanging(FULL);
    line.raise(AlarmType::Process, &[]).unwrap();
    line.diagnosis(OWNER);
    for wrong in [[0x5C, 2, 2, 1], [0x5C, 1, 1, 1], [0x5C, 1, 2, 0x09]] {
        assert_eq!(line.ask(&wrong), [0xDC, 0x80, 0xB5, 0]);
    }
    assert_eq!(line.acyclic.alarms().len(), 1);
    assert_eq!(line.ask(&ACK), ACK);
    assert_eq!(line.ask(&ACK), [0xDC, 0x80, 0xB5, 0], "twice");
}

#[test]
fn v1_r55_v1_r56_v1_r57_an_alarm_that_may_not_come_is_refused_with_the_reason() {
    let mut prm = PRM;
    prm[8] = 0x20;
    let mut line = V1Line::new(FULL);
    assert_eq!(line.raise(AlarmType::Process, &[]), Err(NotRaised::NoExchange));
    line.start(OWNER, &prm);
    let refused = line.raise(AlarmType::Process, &[]).unwrap_err();
    let words = "the master did not enable this alarm: Enable_Process_Alarm in octet 9 of Set_Prm is 0";
    assert_eq!(refused.to_string(), words);
    assert!(line.raise(AlarmType::Diagnostic, &[]).is_ok());
    let mut v0 = PRM;
    v0[7] = 0;
    line.start(OWNER, &v0);
    assert_eq!(line.raise(AlarmType::Process, &[]), Err(NotRaised::NotEnabled));
    let mut offer = FULL;
    offer.alarms.types = 0x20;
    let mut line = V1Line::exchanging(offer);
    assert_eq!(line.raise(AlarmType::Process, &[]), Err(NotRaised::NotOffered(AlarmType::Process)));
    assert!(line.raise(AlarmType::numbered(7), &[]).is_err(), "a reserved type");
    assert_eq!(line.diagnosis(OWNER), [0; 0]);
}

#[test]
fn v1_r58_v1_r59_in_type_mode_there_is_one_of_each_type() {
    let mut line = V1Line::exchanging(FULL);
    line.raise(AlarmType::Process, &[1]).unwrap();
    assert!(matches!(line.raise(AlarmType::Process, &[2]), Err(NotRaised::Limit(_))));
    line.raise(AlarmType::Pull, &[]).unwrap();
    assert!(matches!(line.raise(AlarmType::Plug, &[]), Err(NotRaised::Limit(_))), "one type (O-13)");
    assert_eq!(line.diagnosis(OWNER), [5, 2, 1, 1, 1]);
    assert_eq!(line.exchange(), Answer::High(vec![0, 0]), "the next one waits");
    assert_eq!(line.diagnosis(OWNER), [4, 3, 1, 1]);
    assert_eq!(line.ask(&ACK), ACK);
    line.raise(AlarmType::Process, &[2]).unwrap();
}

#[test]
fn v1_r60_v1_r61_in_sequence_mode_each_has_a_number_and_ends_by_itself() {
    let mut prm = PRM;
    prm[9] = 0x01;
    let mut line = V1Line::new(FULL);
    line.start(OWNER, &prm);
    let first = line.raise(AlarmType::Process, &[]).unwrap();
    let second = line.raise(AlarmType::Process, &[]).unwrap();
    assert_ne!(first.sequence, second.sequence);
    assert!(matches!(line.raise(AlarmType::Process, &[]), Err(NotRaised::Limit(_))), "Alarm_Mode 1: two");
    assert_eq!(line.diagnosis(OWNER), [4, 2, 1, 0x01]);
    assert_eq!(line.diagnosis(OWNER), [4, 2, 1, 0x09]);
    assert_eq!(line.ask(&[0x5C, 1, 2, 0x09]), [0x5C, 1, 2, 0x09]);
    assert_eq!(line.acyclic.alarms().iter().map(|alarm| alarm.head).collect::<Vec<_>>(), [first]);
    assert_eq!(line.ask(&[0x5C, 1, 2, 0x01]), [0x5C, 1, 2, 0x01]);
    assert_eq!(line.raise(AlarmType::Process, &[]).unwrap().sequence, 2);
    // A slave without sequence mode stays with one of each type.
    let mut offer = FULL;
    offer.alarms.sequence = 0;
    let mut line = V1Line::new(offer);
    line.start(OWNER, &prm);
    line.raise(AlarmType::Process, &[]).unwrap();
    assert!(line.raise(AlarmType::Process, &[]).is_err());
}

#[test]
fn v1_r62_an_alarm_ends_with_the_data_exchange() {
    let mut line = V1Line::exchanging(FULL);
    line.raise(AlarmType::Process, &[]).unwrap();
    line.diagnosis(OWNER);
    line.raise(AlarmType::Update, &[]).unwrap();
    let mut unlock = PRM;
    unlock[0] = 0x40;
    assert_eq!(line.dp(OWNER, 61, &unlock), Answer::Sc);
    line.start(OWNER, &PRM);
    assert_eq!(line.diagnosis(OWNER), [0; 0]);
    assert_eq!(line.ask(&ACK), [0xDC, 0x80, 0xB5, 0]);
}

#[test]
fn v1_r63_add_ack_and_specifier_are_in_the_third_octet() {
    for (specifier, ext_diag) in [
        (Specifier::None, 0),
        (Specifier::Appears, 0x08),
        (Specifier::Disappears, 0),
        (Specifier::StillDisturbed, 0x08),
    ] {
        let mut line = V1Line::exchanging(FULL);
        line.acyclic.raise(&mut line.station, AlarmType::Diagnostic, (2, specifier, true), &[9]).unwrap();
        let Answer::Low(octets) = line.dp(OWNER, 60, &[]) else { panic!() };
        assert_eq!(octets[6..], [5, 1, 2, 4 | specifier as u8, 9]);
        assert_eq!(octets[0] & 0x08, ext_diag, "{specifier:?}");
    }
}

#[test]
fn v1_r65_a_foreign_master_takes_no_alarm_away() {
    let mut line = V1Line::exchanging(FULL);
    line.raise(AlarmType::Process, &[]).unwrap();
    assert_eq!(line.diagnosis(OTHER), [4, 2, 1, 1]);
    assert_eq!(line.exchange(), Answer::High(vec![0, 0]));
    assert_eq!(line.diagnosis(OWNER), [4, 2, 1, 1]);
}

#[test]
fn v1_r66_a_status_message_needs_no_acknowledgement_and_is_sent_once() {
    let mut line = V1Line::exchanging(FULL);
    let send = |line: &mut V1Line, data: &[u8]| {
        let (kind, specifier) = (StatusType::Message, Specifier::None);
        line.acyclic.send_status(&mut line.station, kind, 1, specifier, data)
    };
    send(&mut line, &[5, 0]).unwrap();
    send(&mut line, &[6]).unwrap();
    assert_eq!(line.exchange(), Answer::High(vec![0, 0]));
    assert_eq!(line.diagnosis(OWNER), [6, 0x81, 1, 0, 5, 0]);
    assert_eq!(line.exchange(), Answer::High(vec![0, 0]), "the other one");
    assert_eq!(line.diagnosis(OWNER), [5, 0x81, 1, 0, 6]);
    assert_eq!(line.diagnosis(OWNER), [0; 0]);
    assert_eq!(send(&mut line, &[0; 60]), Err(NotRaised::TooLong { got: 60, most: 59 }));
}

#[test]
fn v1_r83_v1_r84_v1_r85_v1_r86_identification_is_called_and_fetched() {
    let mut line = V1Line::exchanging(FULL);
    assert_eq!(line.ask(&[0x5E, 0, 255, 68]), [0xDE, 0x80, 0xB5, 0], "without a call");
    assert_eq!(line.ask(&[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE8]), [0x5F, 0, 255, 4]);
    let answer = line.ask(&[0x5E, 0, 255, 240]);
    assert_eq!(answer[..8], [0x5E, 0, 255, 68, 8, 0, 0xFD, 0xE8]);
    assert_eq!((answer.len(), &answer[18..20], &answer[20..34]), (72, &[0, 42][..], &b"6ES7 000-0AA00"[..]));
    assert_eq!(line.ask(&[0x5E, 0, 255, 68]), [0xDE, 0x80, 0xB5, 0], "fetched already");
    for unknown in [[0xFD, 0xF0], [0, 1]] {
        let call = [&[0x5F, 0, 255, 4, 8, 0][..], &unknown].concat();
        assert_eq!(line.ask(&call), [0xDF, 0x80, 0xB0, 0]);
    }
    let block = |number: u8| [&[0x5F, 0, 255, 68, 8, 0, 0xFD, number][..], &[7; 64]].concat();
    assert_eq!(line.ask(&block(0xE9)), [0x5F, 0, 255, 68]);
    assert_eq!(line.ask(&[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE9]), [0x5F, 0, 255, 4]);
    assert_eq!(line.ask(&[0x5E, 0, 255, 68])[8..], [7; 64]);
    assert_eq!(line.ask(&block(0xE8)), [0xDF, 0x80, 0xB6, 0], "I&M0");
    assert!(line.events.iter().any(|event| event.to_string() == "master 2 wrote I&M1 (65001) of slot 0"));
    assert!(matches!(line.events.last(), Some(Event::Refused { .. })));
}

#[test]
fn v1_r41_v1_r87_a_short_set_prm_is_refused_and_a_plain_station_has_no_record_47() {
    let mut line = V1Line::new(FULL);
    assert_eq!(line.dp(OWNER, 61, &PRM[..9]), Answer::Sc);
    assert!(line.station.slave().diagnosis().octets()[0] & 0x40 != 0, "Prm_Fault");
    line.start(OWNER, &PRM);
    assert_eq!(line.ask(&[0x5E, 0, 47, 240]), [0xDE, 0x80, 0xB0, 0]);
    assert_eq!(line.dp(OWNER, 62, &CFG), Answer::Sc);
    assert_eq!(line.ask(&READ), DATA, "Chk_Cfg again changes nothing");
}
