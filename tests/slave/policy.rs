//! Every field of [`Policy`]: what the default does, and what the others do (`dp-v0.md` 16).

use std::time::Duration;

use profidrive::profibus::dp::policy::{
    ApplicationReady, DefaultAddress, EmptyRead, FeedsWatchdog, NoEffect, NotSupported, SetPrmInDataExch,
    ShortMinTsdr, WatchdogFactorZero, WrongOutputLength,
};
use profidrive::profibus::dp::{Description, Event, Fixed, Policy, State, Station};
use profidrive::profibus::fdl;
use profidrive::profibus::fdl::station::NotOffered;
use profidrive::profibus::fdl::{FrameCount, FunctionCode, Service};

use crate::slave_line;
use crate::slave_line::{
    ACCEPTS, Answer, BAUD, CFG, IO, MASTER, OTHER, PRM, RR, RS, SLAVE, SlaveLine, accepting, telegram,
};

const DEFAULT: Policy = Policy::PROPOSED;

/// Lock, and a watchdog of 100 ms.
const WATCHDOG: [u8; 7] = [0x88, 1, 10, 11, 0x12, 0x34, 0];

fn exchanging(policy: Policy) -> SlaveLine {
    let mut line = SlaveLine::exchanging(IO, policy);
    line.station.set_inputs(&[1, 2, 3, 4]);
    line.exchange(&[9; 4]);
    line
}

fn state(line: &SlaveLine) -> State {
    line.station.slave().state()
}

/// A request without SAPs, data and frame count.
fn plain(service: Service) -> Vec<u8> {
    telegram(SLAVE, MASTER, FunctionCode::request(service, FrameCount::Unused), None, &[])
}

#[test]
fn every_field_has_a_test_of_its_name_and_a_line_in_the_document() {
    let read = |file: &str| {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(root.join(file)).unwrap()
    };
    let (tests, document) = (read("tests/slave/policy.rs"), read("docs/conformance.md"));
    let mut fields = Vec::new();
    for (file, prefix) in [("src/profibus/dp/policy.rs", ""), ("src/profibus/fdl/station.rs", "fdl.")] {
        let text = read(file);
        let body = text.split_once("pub struct Policy {").unwrap().1.split_once("\n}").unwrap().0;
        let names = body.lines().filter_map(|line| line.trim().strip_prefix("pub ")?.split_once(':'));
        fields.extend(names.map(|(name, _)| format!("{prefix}{name}")));
    }
    assert_eq!(fields.len(), 24, "{fields:?}");
    for field in fields.iter().filter(|field| *field != "fdl") {
        assert!(document.contains(&format!("| `{field}` |")), "docs/conformance.md lacks {field}");
        let name = field.trim_start_matches("fdl.");
        let tested = tests.lines().any(|line| line.starts_with("fn ") && line.contains(name));
        assert!(tested, "no test of {field}");
    }
}

#[test]
fn the_default_is_what_the_reference_proposes() {
    assert_eq!(Policy::default(), Policy::PROPOSED);
    assert_eq!(*SlaveLine::new(IO).station.slave().policy(), Policy::PROPOSED);
}

#[test]
fn wrong_output_length() {
    let with = |wrong_output_length| Policy { wrong_output_length, ..DEFAULT };
    for (policy, reply) in [
        (DEFAULT, RS),
        (with(WrongOutputLength::NoResource), RR),
        (with(WrongOutputLength::Inputs), Answer::Low(vec![1, 2, 3, 4])),
    ] {
        let mut line = exchanging(policy);
        assert_eq!(line.exchange(&[9; 5]), reply);
        assert_eq!((state(&line), line.outputs()), (State::WaitPrm, &[0; 4][..]), "whichever it is");
        assert_eq!(line.exchange(&[9; 4]), RS, "from the next one on");
    }
    let mut line = SlaveLine::with(IO, with(WrongOutputLength::Inputs));
    line.station.set_inputs(&[1, 2, 3, 4]);
    line.request(MASTER, Some(61), &[0x90, 1, 1, 11, 0x12, 0x34, 0]);
    line.request(MASTER, Some(62), &CFG);
    line.sdn(MASTER, 127, 58, &[0x08, 0]);
    line.station.set_inputs(&[5, 6, 7, 8]);
    assert_eq!(line.exchange(&[9; 5]), Answer::Low(vec![1, 2, 3, 4]), "frozen as they were");
}

#[test]
fn foreign_set_prm() {
    let other = Policy { foreign_set_prm: NoEffect::NotActivated, ..DEFAULT };
    for (policy, reply) in [(DEFAULT, Answer::Sc), (other, RS)] {
        let mut line = exchanging(policy);
        assert_eq!(line.request(OTHER, Some(61), &PRM), reply);
        assert_eq!((state(&line), line.outputs()), (State::DataExch, &[9; 4][..]));
        assert_eq!(line.happened(|event| matches!(event, Event::PrmForeign { .. })), 1);
    }
}

#[test]
fn chk_cfg_in_wait_prm() {
    let other = Policy { chk_cfg_in_wait_prm: NoEffect::Acknowledged, ..DEFAULT };
    for (policy, reply) in [(DEFAULT, RS), (other, Answer::Sc)] {
        for cfg in [&CFG[..], &[0]] {
            let mut line = SlaveLine::with(IO, policy);
            assert_eq!(line.request(MASTER, Some(62), cfg), reply);
            assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x05, 0x00, 0xFF], "no effect");
        }
    }
}

#[test]
fn foreign_chk_cfg() {
    let other = Policy { foreign_chk_cfg: NoEffect::Acknowledged, ..DEFAULT };
    for (policy, reply) in [(DEFAULT, RS), (other, Answer::Sc)] {
        let mut line = exchanging(policy);
        assert_eq!(line.request(OTHER, Some(62), &[0]), reply);
        assert_eq!((state(&line), line.outputs()), (State::DataExch, &[9; 4][..]));
    }
}

#[test]
fn set_prm_in_data_exch() {
    let stay = Policy { set_prm_in_data_exch: SetPrmInDataExch::StayIfIdentical, ..DEFAULT };
    let mut changed = PRM;
    changed[6] = 1;
    for (policy, octets, expected) in [
        (DEFAULT, PRM, State::WaitCfg),
        (stay, PRM, State::DataExch),
        (stay, changed, State::WaitCfg),
        (stay, [0x40; 7], State::WaitPrm),
        (stay, [0x80; 7], State::WaitPrm),
    ] {
        let mut line = exchanging(policy);
        assert_eq!(line.request(MASTER, Some(61), &octets), Answer::Sc);
        assert_eq!(state(&line), expected, "{octets:02X?}");
        let outputs = if expected == State::DataExch { [9; 4] } else { [0; 4] };
        assert_eq!(line.outputs(), outputs);
    }
}

#[test]
fn p_12_sync_freeze_not_supported() {
    let device = Description { sync_mode: false, ..IO };
    let refuse = Policy { sync_freeze_not_supported: NotSupported::Fault, ..DEFAULT };
    for (policy, diagnosis) in [(DEFAULT, [0x12, 0x04, 0x00, MASTER]), (refuse, [0x52, 0x05, 0x00, 0xFF])] {
        let mut line = SlaveLine::with(device, policy);
        line.request(MASTER, Some(61), &[0xB0, 1, 1, 11, 0x12, 0x34, 0]);
        assert_eq!(line.diagnosis(MASTER)[..4], diagnosis);
        line.request(MASTER, Some(61), &[0x90, 1, 1, 11, 0x12, 0x34, 0]);
        assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x04, 0x00, MASTER], "cleared by a good one");
    }
}

#[test]
fn p_14_watchdog_factor_zero() {
    let off = Policy { watchdog_factor_zero: WatchdogFactorZero::Off, ..DEFAULT };
    for factors in [[0, 10], [10, 0], [0, 0]] {
        for (policy, diagnosis) in [(DEFAULT, [0x42, 0x05, 0x00, 0xFF]), (off, [0x02, 0x04, 0x00, MASTER])] {
            let mut line = SlaveLine::with(IO, policy);
            line.request(MASTER, Some(61), &[0x88, factors[0], factors[1], 11, 0x12, 0x34, 0]);
            assert_eq!(line.diagnosis(MASTER)[..4], diagnosis, "{factors:?}");
        }
    }
}

#[test]
fn p_07_short_min_tsdr() {
    let fault = Policy { short_min_tsdr: ShortMinTsdr::Fault, ..DEFAULT };
    for bits in [1, 10] {
        let prm = [0x80, 1, 1, bits, 0x12, 0x34, 0];
        let mut line = SlaveLine::with(IO, DEFAULT);
        line.request(MASTER, Some(61), &prm);
        assert_eq!(state(&line), State::WaitCfg);
        let before = line.now.saturating_add(BAUD.bit_times(33)).saturating_add(BAUD.octet_times(11));
        line.diagnosis(MASTER);
        let reply = BAUD.octet_times(17);
        assert!(line.now.saturating_since(before) >= reply + BAUD.bit_times(11), "taken as 11 T_bit");
        let mut line = SlaveLine::with(IO, fault);
        line.request(MASTER, Some(61), &prm);
        assert_eq!(line.diagnosis(MASTER)[..4], [0x42, 0x05, 0x00, 0xFF]);
    }
    for bits in [0, 11] {
        let mut line = SlaveLine::with(IO, fault);
        line.request(MASTER, Some(61), &[0x80, 1, 1, bits, 0x12, 0x34, 0]);
        assert_eq!(state(&line), State::WaitCfg);
    }
}

#[test]
fn w_03_broadcast_feeds_watchdog() {
    let feeds = Policy { broadcast_feeds_watchdog: true, ..DEFAULT };
    for (policy, sender, sap, expected) in [
        (DEFAULT, MASTER, 58, State::WaitPrm),
        (feeds, MASTER, 58, State::DataExch),
        (feeds, MASTER, 60, State::WaitPrm),
        (feeds, OTHER, 58, State::WaitPrm),
    ] {
        let mut line = SlaveLine::with(IO, policy);
        line.request(MASTER, Some(61), &WATCHDOG);
        line.request(MASTER, Some(62), &CFG);
        for _ in 0..4 {
            line.wait(Duration::from_millis(60));
            line.sdn(sender, 127, sap, &[0, 0]);
        }
        assert_eq!(state(&line), expected);
    }
}

#[test]
fn w_03_feeds_watchdog() {
    let any = Policy { feeds_watchdog: FeedsWatchdog::AnyTelegram, ..DEFAULT };
    // What the master says, and whether it shows that the DP layer of the master is alive.
    let telegrams: [(&str, bool, Say); 13] = [
        ("Data_Exchange", true, |line| drop(line.exchange(&[9; 4]))),
        ("Slave_Diag", true, |line| drop(line.request(MASTER, Some(60), &[]))),
        ("Get_Cfg", true, |line| drop(line.request(MASTER, Some(59), &[]))),
        ("RD_Inp", true, |line| drop(line.request(MASTER, Some(56), &[]))),
        ("Chk_Cfg", true, |line| drop(line.request(MASTER, Some(62), &CFG))),
        ("Global_Control to its own address", true, |line| line.sdn(MASTER, SLAVE, 58, &[0, 0])),
        ("FDL status", false, |line| drop(line.send(&plain(Service::FdlStatus)))),
        ("Ident", false, |line| drop(line.send(&plain(Service::Ident)))),
        ("SDA", false, |line| drop(line.send(&plain(Service::SdaHigh)))),
        ("a SAP where nothing listens", false, |line| assert_eq!(line.request(MASTER, Some(40), &[]), RS)),
        ("Set_Slave_Add", false, |line| assert_eq!(line.request(MASTER, Some(55), &[7, 0x12, 0x34, 0]), RS)),
        ("SDN to a SAP of SRD", false, |line| line.sdn(MASTER, SLAVE, 60, &[])),
        ("Global_Control with a reserved bit", false, |line| line.sdn(MASTER, SLAVE, 58, &[1, 0])),
    ];
    for (what, is_service, say) in telegrams {
        for (policy, feeds) in [(DEFAULT, is_service), (any, true)] {
            let mut line = SlaveLine::with(IO, policy);
            line.request(MASTER, Some(61), &WATCHDOG);
            line.request(MASTER, Some(62), &CFG);
            for _ in 0..4 {
                line.wait(Duration::from_millis(60));
                if state(&line) == State::DataExch {
                    say(&mut line);
                }
            }
            let expected = if feeds { State::DataExch } else { State::WaitPrm };
            assert_eq!(state(&line), expected, "{what}, {:?}", policy.feeds_watchdog);
        }
    }
}

type Say = fn(&mut SlaveLine);

#[test]
fn w_03_a_retry_feeds_no_more_than_what_it_repeats() {
    let mut line = SlaveLine::with(IO, DEFAULT);
    line.request(MASTER, Some(61), &WATCHDOG);
    line.request(MASTER, Some(62), &CFG);
    line.request(MASTER, Some(60), &[]);
    let octets = line.srd(SLAVE, MASTER, Some(40), &[]);
    for _ in 0..4 {
        line.wait(Duration::from_millis(30));
        line.send(&octets);
    }
    assert_eq!(state(&line), State::WaitPrm);
}

#[test]
fn a_01_default_address() {
    let everything = Policy { default_address: DefaultAddress::Everything, ..DEFAULT };
    for (policy, closed) in [(DEFAULT, true), (everything, false)] {
        let stored = profidrive::profibus::dp::StoredAddress::DELIVERED;
        let max_tsdr = Some(BAUD.max_tsdr_bits());
        let station = Station::restored(stored, &[], BAUD, max_tsdr, IO, ACCEPTS).with_policy(policy);
        let mut line = SlaveLine::of(station);
        let fdl_status =
            telegram(126, MASTER, FunctionCode::request(Service::FdlStatus, FrameCount::Unused), None, &[]);
        assert!(line.send(&fdl_status).is_some());
        assert!(matches!(line.request_to(126, MASTER, Some(60), &[]), Answer::Low(_)), "Slave_Diag");
        assert_eq!(line.request_to(126, MASTER, Some(59), &[]), Answer::Low(CFG.to_vec()), "Get_Cfg");
        let answer = if closed { RS } else { Answer::Sc };
        assert_eq!(line.request_to(126, MASTER, Some(61), &PRM), answer, "Set_Prm");
        assert_eq!(line.request_to(126, MASTER, Some(62), &CFG), answer, "Chk_Cfg");
        let inputs = if closed { RS } else { Answer::Low(vec![0; 4]) };
        assert_eq!(line.request_to(126, MASTER, None, &[9; 4]), inputs, "Data_Exchange");
        assert_eq!(line.request_to(126, MASTER, Some(56), &[]), inputs, "RD_Inp");
        assert_eq!(state(&line) == State::WaitPrm, closed);
        let mut line =
            SlaveLine::of(Station::restored(stored, &[], BAUD, max_tsdr, IO, ACCEPTS).with_policy(policy));
        assert_eq!(line.request_to(126, MASTER, Some(55), &[7, 0x12, 0x34, 0]), Answer::Sc, "Set_Slave_Add");
        assert_eq!(line.request_to(7, MASTER, Some(61), &PRM), Answer::Sc);
        assert_eq!(line.request_to(7, MASTER, Some(62), &CFG), Answer::Sc);
        assert_eq!(line.request_to(7, MASTER, None, &[9; 4]), Answer::Low(vec![0; 4]));
    }
}

#[test]
fn w_03_retry_feeds_watchdog() {
    let starves = Policy { retry_feeds_watchdog: false, ..DEFAULT };
    for (policy, expected) in [(DEFAULT, State::DataExch), (starves, State::WaitPrm)] {
        let mut line = SlaveLine::with(IO, policy);
        line.request(MASTER, Some(61), &WATCHDOG);
        line.request(MASTER, Some(62), &CFG);
        let octets = line.srd(SLAVE, MASTER, None, &[9; 4]);
        for _ in 0..4 {
            assert!(line.send(&octets).is_some());
            line.wait(Duration::from_millis(60));
        }
        assert_eq!(state(&line), expected);
    }
}

#[test]
fn a_02_refused_set_slave_add() {
    let refuses = Policy { refused_set_slave_add: NoEffect::NotActivated, ..DEFAULT };
    for (policy, reply) in [(DEFAULT, Answer::Sc), (refuses, RS)] {
        let mut line = SlaveLine::with(IO, policy);
        assert_eq!(line.request(MASTER, Some(55), &[7, 0x12, 0x35, 0]), reply);
        assert_eq!(line.request(MASTER, Some(55), &[126, 0x12, 0x34, 0]), reply);
        assert_eq!(line.request(MASTER, Some(55), &[7, 0x12, 0x34, 0]), Answer::Sc);
    }
}

#[test]
fn a_02_late_set_slave_add() {
    let acknowledges = Policy { late_set_slave_add: NoEffect::Acknowledged, ..DEFAULT };
    for (policy, reply) in [(DEFAULT, RS), (acknowledges, Answer::Sc)] {
        let mut line = exchanging(policy);
        assert_eq!(line.request(MASTER, Some(55), &[7, 0x12, 0x34, 0]), reply);
        assert_eq!(line.station.address().number(), SLAVE);
        assert_eq!(state(&line), State::DataExch);
    }
}

#[test]
fn x_06_empty_read() {
    const NOTHING: Fixed<'static> = accepting(&[&[0x23, 0x13], &[0x00]]);
    let no_data = Policy { empty_read: EmptyRead::NoReplyData, ..DEFAULT };
    for (policy, reply) in [(DEFAULT, Answer::Sc), (no_data, Answer::Sd1(0x09))] {
        let mut line = SlaveLine::judged_by(NOTHING, IO, policy);
        line.request(MASTER, Some(61), &PRM);
        line.request(MASTER, Some(62), &[0x00]);
        for sap in [56, 57] {
            assert_eq!(line.request(OTHER, Some(sap), &[]), reply);
        }
        line.request(MASTER, Some(62), &CFG);
        assert_eq!(line.request(OTHER, Some(56), &[]), Answer::Low(vec![0; 4]));
    }
}

#[test]
fn p_13_check_reserved_prm_bits() {
    let lenient = Policy { check_reserved_prm_bits: false, ..DEFAULT };
    for (policy, diagnosis) in [(DEFAULT, [0x42, 0x05, 0x00, 0xFF]), (lenient, [0x02, 0x04, 0x00, MASTER])] {
        for bit in [0x01, 0x02, 0x04] {
            let mut line = SlaveLine::with(IO, policy);
            line.request(MASTER, Some(61), &[0x80 | bit, 1, 1, 11, 0x12, 0x34, 0]);
            assert_eq!(line.diagnosis(MASTER)[..4], diagnosis);
        }
    }
}

#[test]
fn s_08_check_reserved_control_bits() {
    let lenient = Policy { check_reserved_control_bits: false, ..DEFAULT };
    for (policy, outputs) in [(DEFAULT, [9; 4]), (lenient, [0; 4])] {
        for bit in [0x01, 0x40, 0x80] {
            let mut line = exchanging(policy);
            line.sdn(MASTER, 127, 58, &[0x02 | bit, 0]);
            assert_eq!(line.outputs(), outputs);
        }
    }
}

#[test]
fn check_ssap() {
    let strict = Policy { check_ssap: true, ..DEFAULT };
    let octets = |ssap: u8| {
        let mut octets = telegram(SLAVE, MASTER, FunctionCode::from_octet(0x6D), Some(59), &[]);
        octets[8] = ssap;
        octets[9] = octets[4..9].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
        octets
    };
    for (policy, ssap, reply) in [
        (DEFAULT, 62, Answer::Low(CFG.to_vec())),
        (DEFAULT, 41, Answer::Low(CFG.to_vec())),
        (strict, 62, Answer::Low(CFG.to_vec())),
        (strict, 41, RS),
    ] {
        let mut line = SlaveLine::with(IO, policy);
        assert_eq!(slave_line::answer(line.send(&octets(ssap))), reply, "{ssap}");
    }
    let mut line = exchanging(strict);
    assert!(matches!(line.exchange(&[9; 4]), Answer::Low(_)), "no SAPs, nothing to check");
}

#[test]
fn application_ready() {
    let judged = Policy { application_ready: ApplicationReady::WhenJudged, ..DEFAULT };
    for (policy, expected) in [(DEFAULT, State::DataExch), (judged, State::WaitCfg)] {
        let mut line = SlaveLine::with(IO, policy);
        line.start_up();
        assert_eq!(state(&line), expected);
        assert_eq!(line.station.slave().pending_configuration().is_some(), expected == State::WaitCfg);
    }
}

#[test]
fn c_10_status_drops_reply() {
    let keeps = Policy { fdl: fdl::station::Policy { status_drops_reply: false, ..DEFAULT.fdl }, ..DEFAULT };
    for (policy, applied_again) in [(DEFAULT, true), (keeps, false)] {
        let mut line = exchanging(policy);
        let octets = line.srd(SLAVE, MASTER, None, &[8; 4]);
        let first = line.send(&octets);
        let passed = line.station.slave().output_updates();
        line.station.set_inputs(&[5; 4]);
        assert_eq!(line.send(&plain(Service::FdlStatus)), Some(slave_line::hex("10 02 05 00 07 16")));
        let second = line.send(&octets);
        assert_eq!(line.station.slave().output_updates() != passed, applied_again);
        assert_eq!(second != first, applied_again, "the stored reply, octet for octet");
    }
}

#[test]
fn f_19_ident() {
    const IDENT: &[u8] = b"\x04\x02\x01\x01SIKOAG11";
    let offers = Policy { fdl: fdl::station::Policy { ident: Some(IDENT), ..DEFAULT.fdl }, ..DEFAULT };
    for (policy, reply) in [(DEFAULT, RS), (offers, Answer::Low(IDENT.to_vec()))] {
        let mut line = SlaveLine::with(IO, policy);
        assert_eq!(slave_line::answer(line.send(&plain(Service::Ident))), reply);
    }
}

#[test]
fn f_19_f_20_lsap_status_and_sda() {
    let silent = Policy {
        fdl: fdl::station::Policy {
            lsap_status: NotOffered::Silence,
            sda: NotOffered::Silence,
            ..DEFAULT.fdl
        },
        ..DEFAULT
    };
    for (policy, reply) in [(DEFAULT, RS), (silent, Answer::Silence)] {
        for service in [Service::LsapStatus, Service::SdaLow, Service::SdaHigh] {
            let mut line = exchanging(policy);
            assert_eq!(slave_line::answer(line.send(&plain(service))), reply, "{service:?}");
            assert_eq!(state(&line), State::DataExch);
        }
    }
}
