//! Slaves unlike the drives: lengths up to 244, Fail_Safe, DP-V1 octets, user parameters, a slow application
//! (`dp-v0.md` 13).

use std::time::Duration;

use profidrive::profibus::dp::application::Expected;
use profidrive::profibus::dp::ext_diag::Block;
use profidrive::profibus::dp::policy::{ApplicationReady, SetPrmInDataExch};
use profidrive::profibus::dp::{
    Application, CfgFault, CfgTicket, Description, Event, ExtDiag, Fixed, Policy, PrmFault, Reason, Refusal,
    State, Station,
};
use profidrive::profibus::fdl::telegram::Format;
use profidrive::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, Sap, Service};
use profidrive::time::Instant;
use proptest::prelude::*;

use crate::slave_line;
use crate::slave_line::{
    ACCEPTS, Answer, BAUD, CFG, IO, MASTER, OTHER, PRM, RS, SLAVE, SlaveLine, accepting, hex, telegram,
};

mod formats;

const JUDGED: Policy = Policy { application_ready: ApplicationReady::WhenJudged, ..Policy::PROPOSED };

/// 244 octets each way: 64 + 64 + 64 + 52.
const FULL: Fixed<'static> =
    accepting(&[&[0xC0, 0xBF, 0xBF, 0xC0, 0xBF, 0xBF, 0xC0, 0xBF, 0xBF, 0xC0, 0xB3, 0xB3]]);

fn full() -> SlaveLine {
    let mut line = SlaveLine::judged_by(FULL, IO, Policy::PROPOSED);
    line.request(MASTER, Some(61), &PRM);
    assert_eq!(line.request(MASTER, Some(62), FULL.configurations[0]), Answer::Sc);
    line
}

#[test]
fn x_08_no_exchange_and_no_look_in_between_sees_half_a_pattern() {
    let mut line = full();
    let patterns = [[0x55_u8; 244], [0xAA; 244]];
    let uniform = |octets: &[u8]| octets.len() == 244 && octets.iter().all(|octet| *octet == octets[0]);
    for round in 0..300 {
        let pattern = patterns[round % 2];
        let octets = line.srd(SLAVE, MASTER, None, &pattern);
        // The application writes and reads after every few octets on the line.
        let mut framer =
            profidrive::profibus::fdl::Framer::new(profidrive::profibus::fdl::Resync::Idle(BAUD));
        line.now = line.now.saturating_add(Duration::from_micros(400));
        for (step, chunk) in octets.chunks(1 + round % 50).enumerate() {
            line.station.set_inputs(&[(step % 256) as u8; 244]);
            assert!(uniform(line.station.slave().outputs()), "round {round}");
            framer.handle_bytes(line.now, chunk, |at, result| {
                let _outcome = line.station.handle_telegram(at, &result.unwrap());
            });
        }
        assert_eq!(line.station.slave().outputs(), pattern);
        let due = line.station.poll_timeout().unwrap();
        line.station.set_inputs(&[0xEE; 244]);
        let reply = line.station.poll_transmit(due).unwrap().unwrap();
        assert!(uniform(&reply[7..251]), "round {round}: {reply:02X?}");
        assert_ne!(reply[7], 0xEE, "the inputs that were ready before");
    }
}

#[test]
fn x_03_no_outputs_to_a_slave_with_fail_safe_mean_the_safe_state() {
    let mut line = SlaveLine::exchanging(IO, Policy::PROPOSED);
    line.station.set_inputs(&[1, 2, 3, 4]);
    line.exchange(&[9; 4]);
    for _ in 0..3 {
        assert_eq!(line.exchange(&[]), Answer::Low(vec![1, 2, 3, 4]), "answered with inputs");
        assert_eq!(line.outputs(), [0; 4]);
        assert!(line.station.slave().safe_state());
    }
    assert_eq!(line.happened(|event| matches!(event, Event::SafeState { .. })), 1, "said once");
    assert_eq!(line.station.slave().state(), State::DataExch);
    line.exchange(&[9; 4]);
    assert_eq!((line.outputs(), line.station.slave().safe_state()), (&[9; 4][..], false));
    line.exchange(&[]);
    assert_eq!(line.happened(|event| matches!(event, Event::SafeState { .. })), 2);
}

#[test]
fn x_03_the_safe_state_clears_what_waits_for_sync_and_announces_a_diagnosis() {
    let mut line = SlaveLine::new(IO);
    line.request(MASTER, Some(61), &[0xA0, 1, 1, 11, 0x12, 0x34, 0]);
    line.request(MASTER, Some(62), &CFG);
    line.sdn(MASTER, 127, 58, &[0x20, 0]);
    line.exchange(&[9; 4]);
    line.file(&ExtDiag::fault());
    assert_eq!(line.exchange(&[]), Answer::High(vec![0; 4]));
    line.sdn(MASTER, 127, 58, &[0x20, 0]);
    assert_eq!(line.outputs(), [0; 4]);
}

#[test]
fn x_02_no_outputs_to_a_slave_without_fail_safe_are_a_wrong_length() {
    let mut line = SlaveLine::exchanging(Description { fail_safe: false, ..IO }, Policy::PROPOSED);
    assert_eq!(line.exchange(&[]), RS);
    assert_eq!(line.station.slave().state(), State::WaitPrm);
}

#[test]
fn g_07_244_octets_each_way_are_exchanged() {
    let mut line = full();
    line.station.set_inputs(&[0x33; 244]);
    assert_eq!(line.exchange(&[0x44; 244]), Answer::Low(vec![0x33; 244]));
    assert_eq!(line.outputs(), [0x44; 244]);
    assert_eq!(line.request(OTHER, Some(57), &[]), Answer::Low(vec![0x44; 244]));
    assert_eq!(line.exchange(&[0x44; 243]), RS);
}

#[test]
fn g_05_another_accepted_configuration_in_data_exchange_begins_with_cleared_outputs() {
    let mut line = SlaveLine::exchanging(IO, Policy::PROPOSED);
    line.exchange(&[9; 4]);
    assert_eq!(line.request(MASTER, Some(62), &CFG), Answer::Sc);
    assert_eq!(line.outputs(), [9; 4], "the same configuration changes nothing");
    assert_eq!(line.request(MASTER, Some(62), &[0x21, 0x11]), Answer::Sc);
    assert_eq!(line.outputs(), [0; 2], "octets of another layout are not reinterpreted");
    assert_eq!(line.exchange(&[7; 2]), Answer::Low(vec![0; 2]));
}

#[test]
fn p_03_user_parameters_are_measured_and_compared_and_the_refusal_says_what_to_change() {
    let device = Description { user_prm_len: 1, max_user_prm_len: 237, ..IO };
    let application = Fixed { user_prm: &[0..=3, 1..=1], prm_advice: "correct it", ..ACCEPTS };
    let refused = |index, expected: (u8, u8), got| {
        let expected = Expected::Range(expected.0, expected.1);
        let reason = Reason::Text("correct it");
        Some(PrmFault::UserPrm(Refusal { index, expected, got: Some(got), reason }))
    };
    for (user_prm, refused) in [
        (&[][..], Some(PrmFault::Length { expected: (8, 244), got: 7 })),
        (&[3], None),
        (&[4], refused(0, (0, 3), 4)),
        (&[0, 2], refused(1, (1, 1), 2)),
        (&[1; 237], None),
    ] {
        let mut line = SlaveLine::judged_by(application, device, Policy::PROPOSED);
        assert_eq!(line.request(MASTER, Some(61), &[&PRM, user_prm].concat()), Answer::Sc);
        let diagnosis = line.diagnosis(MASTER);
        if let Some(fault) = refused {
            assert_eq!(diagnosis[..4], [0x42, 0x05, 0x00, 0xFF]);
            let master = Address::station(MASTER).unwrap();
            assert_eq!(line.events, [Event::PrmRejected { master, fault }]);
            let words = ["check the user parameters in the master's project", "correct it"];
            assert!(words.iter().any(|words| fault.to_string().ends_with(words)), "{fault}");
        } else {
            assert_eq!(diagnosis[..4], [0x02, 0x04, 0x00, MASTER]);
            assert_eq!(line.station.slave().user_prm(), user_prm);
        }
    }
}

#[test]
fn p_17_the_dpv1_octets_choose_the_watchdog_base_and_are_checked() {
    let device = Description { dpv1_status: Some([0xC4, 0, 0]), ..IO };
    let request = |status: [u8; 3]| [&[0x88, 5, 10, 11, 0x12, 0x34, 0][..], &status].concat();
    for (status, time) in [([0x44, 0, 0], 50), ([0x40, 0, 0], 500)] {
        let mut line = SlaveLine::new(device);
        line.request(MASTER, Some(61), &request(status));
        line.wait(Duration::from_millis(time - 1));
        assert_eq!(line.station.slave().state(), State::WaitCfg);
        line.wait(Duration::from_millis(1));
        assert_eq!(line.station.slave().state(), State::WaitPrm);
    }
    for status in [[0x04, 0, 0], [0x60, 0, 0], [0x40, 1, 0], [0x40, 0, 8]] {
        let mut line = SlaveLine::new(device);
        line.request(MASTER, Some(61), &request(status));
        assert_eq!(line.diagnosis(MASTER)[..4], [0x42, 0x05, 0x00, 0xFF], "{status:02X?}");
    }
}

fn ticket(line: &SlaveLine) -> CfgTicket {
    line.station.slave().pending_configuration().unwrap().0
}

#[test]
fn g_10_the_slave_is_not_ready_until_the_application_has_judged() {
    let mut line = SlaveLine::with(IO, JUDGED);
    line.start_up();
    for _ in 0..3 {
        assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x04, 0x00, MASTER], "Station_Not_Ready, no fault");
        assert_eq!(line.exchange(&[0; 4]), RS);
    }
    let first = ticket(&line);
    assert!(line.station.judge_cfg(line.now, first, Ok(())).is_some());
    assert_eq!(line.diagnosis(MASTER)[..4], [0x00, 0x04, 0x00, MASTER]);
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)));
    assert_eq!(
        line.request(MASTER, Some(62), &CFG),
        Answer::Sc,
        "what is exchanged already is not judged again"
    );
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)));
}

#[test]
fn g_10_a_refusal_is_a_configuration_fault() {
    let mut line = SlaveLine::with(IO, JUDGED);
    line.start_up();
    let reason = Reason::Text("not plugged");
    let refusal = Refusal { index: 1, expected: Expected::Octet(0x00), got: Some(0x13), reason };
    let (now, fault) = (line.now, CfgFault::Refused(refusal));
    let refusal = line.station.judge_cfg(now, ticket(&line), Err(refusal));
    assert_eq!(refusal, Some(Event::CfgRejected { master: Address::station(MASTER).unwrap(), fault }));
    assert_eq!(line.diagnosis(MASTER)[..4], [0x06, 0x05, 0x00, 0xFF]);
}

#[test]
fn g_10_a_newer_chk_cfg_or_set_prm_makes_the_judgement_void() {
    type Newer = fn(&mut SlaveLine);
    let newer: [(&str, Newer, State); 4] = [
        (
            "Chk_Cfg",
            |line| assert_eq!(line.request(MASTER, Some(62), &[0x21, 0x11]), Answer::Sc),
            State::WaitCfg,
        ),
        ("Set_Prm", |line| assert_eq!(line.request(MASTER, Some(61), &PRM), Answer::Sc), State::WaitCfg),
        ("bad Chk_Cfg", |line| assert_eq!(line.request(MASTER, Some(62), &[0]), Answer::Sc), State::WaitPrm),
        ("unlock", |line| assert_eq!(line.request(MASTER, Some(61), &[0x40; 7]), Answer::Sc), State::WaitPrm),
    ];
    for (what, send, state) in newer {
        let mut line = SlaveLine::with(IO, JUDGED);
        line.start_up();
        let old = ticket(&line);
        send(&mut line);
        assert_eq!(line.station.judge_cfg(line.now, old, Ok(())), None, "{what}");
        assert_eq!(line.station.slave().state(), state, "{what}");
    }
    let mut line = SlaveLine::with(IO, JUDGED);
    line.start_up();
    line.request(MASTER, Some(62), &[0x21, 0x11]);
    let now = line.now;
    line.station.judge_cfg(now, ticket(&line), Ok(()));
    assert_eq!(line.exchange(&[1, 2]), Answer::Low(vec![0; 2]), "the newer one is what is exchanged");
    // Another configuration in Data_Exchange: nothing is exchanged until it is judged.
    line.request(MASTER, Some(62), &CFG);
    assert_eq!(line.outputs(), [0; 2], "cleared");
    assert_eq!(line.exchange(&[1, 2]), RS);
    let now = line.now;
    line.station.judge_cfg(now, ticket(&line), Ok(()));
    assert_eq!(line.exchange(&[1, 2, 3, 4]), Answer::Low(vec![0; 4]));
}

#[test]
fn c_05_a_retried_chk_cfg_is_not_carried_out_twice() {
    let mut line = SlaveLine::with(IO, JUDGED);
    line.request(MASTER, Some(61), &PRM);
    let octets = line.srd(SLAVE, MASTER, Some(62), &CFG);
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    let first = ticket(&line);
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    assert_eq!(ticket(&line), first, "the application is asked once");
    assert_eq!(line.happened(|event| matches!(event, Event::CfgToJudge { .. })), 1);
}

#[test]
fn w_09_a_silent_application_costs_the_master_its_slave() {
    let time = Duration::from_millis(20);
    let mut line = SlaveLine::exchanging(Description { user_watchdog: Some(time), ..IO }, Policy::PROPOSED);
    line.exchange(&[9; 4]);
    for _ in 0..5 {
        line.wait(Duration::from_millis(15));
        line.station.application_alive(line.now);
        assert!(matches!(line.exchange(&[9; 4]), Answer::Low(_)));
    }
    line.wait(Duration::from_millis(10));
    line.exchange(&[9; 4]);
    line.wait(Duration::from_millis(10));
    assert_eq!(line.outputs(), [0; 4], "exchanges alone do not help");
    assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x05, 0x00, 0xFF]);
    assert_eq!(
        line.happened(|event| matches!(event, Event::ApplicationSilent { after, .. } if *after == time)),
        1
    );
    line.station.application_alive(line.now);
    assert_eq!(line.station.poll_timeout(), None, "nothing to watch without an owner");
    line.start_up();
    assert!(matches!(line.exchange(&[9; 4]), Answer::Low(_)));
}

#[test]
fn w_09_an_application_that_gives_up_leaves_its_master() {
    for stage in 0..3 {
        let mut line = SlaveLine::new(IO);
        let requests: [(u8, &[u8]); 2] = [(61, &PRM), (62, &CFG)];
        for (sap, data) in &requests[..stage] {
            line.request(MASTER, Some(*sap), data);
        }
        let event = line.station.abort();
        let master = Address::station(MASTER).unwrap();
        assert_eq!(event, (stage > 0).then_some(Event::ApplicationAborted { master }));
        assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x05, 0x00, 0xFF]);
        line.start_up();
    }
}

#[test]
fn w_05_a_slave_switched_off_and_on_in_data_exchange_is_started_again() {
    let mut line = SlaveLine::exchanging(IO, Policy::PROPOSED);
    line.exchange(&[9; 4]);
    let stored = line.station.stored_address();
    line.station = Station::restored(stored, &[], BAUD, Some(BAUD.max_tsdr_bits()), IO, ACCEPTS);
    assert_eq!(line.exchange(&[9; 4]), RS);
    assert_eq!(line.diagnosis(MASTER), [0x02, 0x05, 0x00, 0xFF, 0x12, 0x34]);
    line.start_up();
    assert!(matches!(line.exchange(&[9; 4]), Answer::Low(_)));
}

#[test]
fn w_07_a_second_master_takes_over_only_after_release() {
    let mut line = SlaveLine::exchanging(IO, Policy::PROPOSED);
    line.exchange(&[9; 4]);
    // Watchdog off: the first master stays owner however long it is silent.
    line.wait(Duration::from_secs(3600));
    assert_eq!(line.request(OTHER, Some(61), &PRM), Answer::Sc);
    assert_eq!(line.request(OTHER, Some(62), &CFG), RS);
    assert_eq!((line.diagnosis(OTHER)[3], line.outputs()), (MASTER, &[9; 4][..]));
    assert_eq!(line.request(OTHER, Some(61), &[0x40, 1, 1, 11, 0x12, 0x34, 0]), Answer::Sc);
    assert_eq!(line.diagnosis(OTHER)[3], MASTER, "nor can another master release it");
    assert_eq!(line.request(MASTER, Some(61), &[0x40, 1, 1, 11, 0x12, 0x34, 0]), Answer::Sc);
    assert_eq!(line.request(OTHER, Some(61), &PRM), Answer::Sc);
    assert_eq!(line.request(OTHER, Some(62), &CFG), Answer::Sc);
    assert_eq!(line.request(OTHER, None, &[7; 4]), Answer::Low(vec![0; 4]));
    assert_eq!(line.exchange(&[9; 4]), RS);
    assert_eq!(line.outputs(), [7; 4]);
}

#[test]
fn t_04_exchanges_faster_than_the_application_are_answered_with_old_inputs() {
    let mut line = SlaveLine::exchanging(IO, Policy::PROPOSED);
    line.station.set_inputs(&[1; 4]);
    let start = line.now;
    for number in 0..200 {
        assert_eq!(line.exchange(&[number; 4]), Answer::Low(vec![1; 4]));
        assert_eq!(line.outputs(), [number; 4]);
    }
    assert!(line.now.saturating_since(start) < Duration::from_millis(10), "back to back");
}

#[test]
fn f_10_of_two_requests_without_pause_the_second_is_answered_or_none() {
    let srd =
        |sap, count| telegram(SLAVE, MASTER, FunctionCode::request(Service::SrdHigh, count), Some(sap), &[]);
    let first = srd(60, FrameCount::First);
    let second = srd(59, FrameCount::Even);
    for gap in 0..33 {
        let mut station = SlaveLine::new(IO);
        let mut framer =
            profidrive::profibus::fdl::Framer::new(profidrive::profibus::fdl::Resync::Idle(BAUD));
        let mut now = Instant::from_millis(1);
        let mut replies = Vec::new();
        for octets in [&first, &second] {
            now = now.saturating_add(BAUD.bit_times(gap));
            now = now.saturating_add(BAUD.octet_times(octets.len() as u32));
            let station = &mut station.station;
            framer.handle_bytes(now, octets, |at, result| {
                let _outcome = station.handle_telegram(at, &result.unwrap());
            });
        }
        while let Some(due) = station.station.poll_timeout() {
            replies.push(slave_line::answer(station.station.poll_transmit(due).unwrap().map(<[u8]>::to_vec)));
        }
        assert_eq!(replies, [Answer::Low(CFG.to_vec())], "gap {gap}");
    }
}

#[test]
fn f_10_a_request_cut_short_by_the_next_one_is_never_answered() {
    let diagnosis = hex("68 05 05 68 85 82 6D 3C 3E EE 16");
    for len in 1..diagnosis.len() {
        let mut line = SlaveLine::new(IO);
        let octets = [&diagnosis[..len], &hex("68 05 05 68 85 82 6D 3B 3E ED 16")].concat();
        assert_eq!(line.send(&octets), None, "{len} octets");
        assert_eq!(line.diagnosis(MASTER)[0], 0x02, "and the next one is answered");
    }
}

#[test]
fn i_03_the_requests_seen_at_an_et200s_get_its_replies() {
    // dp-v0.md 10, [T-ET200S]: master 1, slave 8; sync, freeze, watchdog 1.95 s, DPV1_Enable and Fail_Safe.
    let et200s = Description {
        ident: 0x80E0,
        dpv1_status: Some([0xC4, 0x00, 0x00]),
        user_prm_len: 0,
        max_user_prm_len: 234,
        ..IO
    };
    let modules = accepting(&[&[0x00, 0x10, 0x10]]);
    let address = Address::station(8).unwrap();
    let mut line = SlaveLine::of(Station::new(address, BAUD, Some(BAUD.max_tsdr_bits()), et200s, modules));
    let srd = |fc: u8, sap: Option<u8>, data: &[u8]| telegram(8, 1, FunctionCode::from_octet(fc), sap, data);
    let low = |line: &mut SlaveLine, octets: &[u8]| slave_line::answer(line.send(octets));
    line.sdn(1, 127, 58, &[0, 0]);
    let power_on = vec![0x02, 0x05, 0x00, 0xFF, 0x80, 0xE0];
    assert_eq!(low(&mut line, &srd(0x6D, Some(60), &[])), Answer::Low(power_on));
    assert_eq!(low(&mut line, &srd(0x5D, Some(59), &[])), Answer::Low(vec![0x00, 0x10, 0x10]));
    let prm = hex("B8 0D 0F 0B 80 E0 00 C0 00 00");
    assert_eq!(low(&mut line, &srd(0x7D, Some(61), &prm)), Answer::Sc);
    let mut modules = ExtDiag::NONE.with_stat_diag();
    modules.push(Block::Modules(&[0; 8])).unwrap();
    modules.push(Block::Device(&[0x82; 19])).unwrap();
    line.file(&modules);
    assert_eq!(low(&mut line, &srd(0x5D, Some(62), &[0x00, 0x10, 0x10])), Answer::Sc);
    for fc in [0x7D, 0x5D, 0x7D, 0x5D] {
        let Answer::Low(diagnosis) = low(&mut line, &srd(fc, Some(60), &[])) else { panic!() };
        assert_eq!(diagnosis[..7], [0x00, 0x0E, 0x00, 0x01, 0x80, 0xE0, 0x49]);
        assert_eq!((diagnosis[15], diagnosis.len()), (0x14, 35));
    }
    line.file(&ExtDiag::NONE);
    let ready = vec![0x00, 0x0C, 0x00, 0x01, 0x80, 0xE0];
    assert_eq!(low(&mut line, &srd(0x7D, Some(60), &[])), Answer::Low(ready));
    line.station.set_inputs(&[0xA5, 0x5A]);
    for fc in [0x5D, 0x7D, 0x5D] {
        line.sdn(1, 127, 58, &[0, 0]);
        assert_eq!(low(&mut line, &srd(fc, None, &[])), Answer::Low(vec![0xA5, 0x5A]));
    }
    line.wait(Duration::from_millis(1951));
    assert_eq!(line.station.slave().state(), State::WaitPrm, "13 * 15 * 10 ms");
}

#[test]
fn a_description_without_configurations_accepts_none() {
    let device = Description { ident: 0x1234, ..Description::PLAIN };
    let mut line = SlaveLine::judged_by(Fixed::PLAIN, device, Policy::PROPOSED);
    line.request(MASTER, Some(61), &PRM);
    assert_eq!(line.request(MASTER, Some(62), &[0x00]), Answer::Sc);
    assert_eq!(line.diagnosis(MASTER)[..4], [0x06, 0x05, 0x00, 0xFF], "no configuration is accepted");
}

/// One thing that happens to a slave.
#[derive(Clone, Debug)]
enum Happening {
    Request { sa: u8, dsap: Option<u8>, data: Vec<u8> },
    Control { sa: u8, data: Vec<u8> },
    Wait(u64),
    File { blocks: Vec<Vec<u8>>, stat_diag: bool },
    Judge(bool),
    Alive,
    Abort,
}

fn happening() -> impl Strategy<Value = Happening> {
    let sa = prop_oneof![4 => Just(MASTER), 1 => Just(OTHER)];
    let prm = (0u8.., any::<[u8; 2]>(), 0..12u8, prop_oneof![4 => Just(0x34), 1 => any::<u8>()]).prop_map(
        |(status, factors, min_tsdr, ident)| {
            let status = if status < 100 { 0x88 } else { status };
            (Some(61), vec![status, factors[0], factors[1], min_tsdr, 0x12, ident, 0xFF])
        },
    );
    let service = prop_oneof![
        4 => prm,
        3 => Just((Some(62), CFG.to_vec())),
        1 => Just((Some(62), vec![0x21, 0x11])),
        4 => proptest::collection::vec(any::<u8>(), 0..6).prop_map(|data| (None, data)),
        4 => Just((None, vec![1, 2, 3, 4])),
        2 => Just((Some(60), Vec::new())),
        1 => (5u8..7).prop_map(|new| (Some(55), vec![new, 0x12, 0x34, 0])),
        2 => (50u8..64, proptest::collection::vec(any::<u8>(), 0..245)).prop_map(|(sap, data)| (Some(sap), data)),
    ];
    prop_oneof![
        12 => (sa.clone(), service).prop_map(|(sa, (dsap, data))| Happening::Request { sa, dsap, data }),
        2 => (sa, proptest::collection::vec(0u8..64, 0..4)).prop_map(|(sa, data)| Happening::Control { sa, data }),
        1 => (0u64..400).prop_map(Happening::Wait),
        1 => (proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..64), 0..6), any::<bool>())
            .prop_map(|(blocks, stat_diag)| Happening::File { blocks, stat_diag }),
        2 => any::<bool>().prop_map(Happening::Judge),
        2 => Just(Happening::Alive),
        1 => Just(Happening::Abort),
    ]
}

proptest! {
    #[test]
    fn whatever_happens_the_slave_answers_and_stays_lawful(
        happenings in proptest::collection::vec(happening(), 0..60),
        judged: bool,
        stay: bool,
    ) {
        let policy = Policy {
            application_ready: if judged { ApplicationReady::WhenJudged } else { ApplicationReady::AtOnce },
            set_prm_in_data_exch: if stay { SetPrmInDataExch::StayIfIdentical } else { SetPrmInDataExch::WaitCfg },
            ..Policy::PROPOSED
        };
        let device = Description { user_watchdog: Some(Duration::from_millis(300)), max_diag_len: 100, ..IO };
        let mut line = SlaveLine::with(device, policy);
        for happening in happenings {
            match happening {
                Happening::Request { sa, dsap, data } => {
                    let da = line.station.address().number();
                    let reply = line.request_to(da, sa, dsap, &data);
                    prop_assert_ne!(reply, Answer::Silence);
                }
                Happening::Control { sa, data } => line.sdn(sa, 127, 58, &data),
                Happening::Wait(time) => line.wait(Duration::from_millis(time)),
                Happening::File { blocks, stat_diag } => {
                    let mut diagnosis = ExtDiag::fault();
                    for block in &blocks {
                        let _refused = diagnosis.push(Block::Device(block));
                    }
                    line.file(&if stat_diag { diagnosis.with_stat_diag() } else { diagnosis });
                }
                Happening::Judge(good) => {
                    if let Some((ticket, _)) = line.station.slave().pending_configuration() {
                        let verdict = if good { Ok(()) } else { ACCEPTS.judge_cfg(&[], &[]) };
                        prop_assert!(line.station.judge_cfg(line.now, ticket, verdict).is_some());
                        prop_assert_eq!(line.station.judge_cfg(line.now, ticket, Ok(())), None);
                    }
                }
                Happening::Alive => line.station.application_alive(line.now),
                Happening::Abort => drop(line.station.abort()),
            }
            let slave = line.station.slave();
            let diagnosis = slave.diagnosis().octets();
            prop_assert_eq!(slave.owner().is_none(), slave.state() == State::WaitPrm);
            prop_assert_eq!(diagnosis[1] & 0x01 != 0, slave.state() == State::WaitPrm, "Prm_Req");
            prop_assert_eq!(diagnosis[0] & 0x02 != 0, slave.state() != State::DataExch, "Station_Not_Ready");
            prop_assert_eq!((diagnosis[0] & 0xA1, diagnosis[1] & 0xC4), (0, 0x04), "bits of masters, the fixed one");
            prop_assert!(slave.state() == State::DataExch || slave.outputs().iter().all(|octet| *octet == 0));
            prop_assert!(slave.pending_configuration().is_none() || slave.state() == State::WaitCfg);
            prop_assert!(slave.ext_diag().octets().len() <= 94);
            prop_assert!(line.station.poll_timeout().is_none_or(|due| due > line.now));
        }
    }
}

#[test]
fn f_15_what_is_sent_to_everybody_is_never_answered() {
    for policy in [Policy::PROPOSED, JUDGED] {
        let mut line = SlaveLine::with(IO, policy);
        line.start_up();
        let before = (line.station.slave().state(), line.station.slave().diagnosis());
        for sap in 0..=63 {
            for service in [Service::SdnLow, Service::SdnHigh, Service::SrdLow, Service::SrdHigh] {
                let srd = matches!(service, Service::SrdLow | Service::SrdHigh);
                let count = if srd { FrameCount::First } else { FrameCount::Unused };
                let fc = FunctionCode::request(service, count);
                for data in [&[][..], &PRM, &CFG] {
                    let octets = telegram(127, MASTER, fc, Some(sap), data);
                    assert_eq!(line.send(&octets), None, "{service:?} to SAP {sap}");
                }
            }
        }
        assert_eq!((line.station.slave().state(), line.station.slave().diagnosis()), before);
        assert_eq!(line.request(MASTER, Some(60), &[]), Answer::Low(before.1.octets().to_vec()));
    }
}
