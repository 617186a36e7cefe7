//! From power-on to Data_Exchange: Set_Prm, Chk_Cfg, Get_Cfg and Slave_Diag (`dp-v0.md` 13: P, G, D).

use std::time::Duration;

use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::DESCRIPTION;
use profidrive::profibus::dp;
use profidrive::profibus::dp::State;

use crate::drive_line::{CFG, IDENT, Line, MASTER, RR, RS, Reply, hex};

const OTHER: u8 = 3;

fn prm(status: u8, min_tsdr: u8, ident: [u8; 2], group: u8) -> [u8; 7] {
    [status, 10, 10, min_tsdr, ident[0], ident[1], group]
}

fn good() -> [u8; 7] {
    prm(0x80, 11, IDENT, 0)
}

#[test]
fn t_01_the_start_up_octet_for_octet_at_every_rate() {
    for baud in DESCRIPTION.rates.iter() {
        let mut line = Line::at(baud);
        for (request, reply) in [
            ("10 05 02 49 50 16", "10 02 05 00 07 16"),
            ("68 05 05 68 85 82 6D 3C 3E EE 16", "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 0A C5 5E 16"),
            ("68 0C 0C 68 85 82 5D 3D 3E 88 0A 0A 0B 0A C5 00 55 16", "E5"),
            ("68 07 07 68 85 82 7D 3E 3E F3 F2 E5 16", "E5"),
            ("68 05 05 68 85 82 5D 3C 3E DE 16", "68 0B 0B 68 82 85 08 3E 3C 00 0C 00 02 0A C5 66 16"),
            (
                "68 11 11 68 05 02 7D 00 00 00 00 00 00 00 00 00 00 00 00 00 00 84 16",
                "68 11 11 68 02 05 08 00 00 00 00 00 00 00 00 2B 23 00 00 00 00 5D 16",
            ),
        ] {
            assert_eq!(line.send(&hex(request)), Some(hex(reply)), "{request} at {baud}");
        }
    }
}

#[test]
fn d_01_the_diagnosis_after_power_on() {
    assert_eq!(Line::new().diagnosis(MASTER), [0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5]);
}

#[test]
fn p_01_d_02_good_parameters_then_good_configuration() {
    let mut line = Line::new();
    assert_eq!(line.request(MASTER, Some(61), &prm(0x88, 11, IDENT, 0)), Reply::Sc);
    assert_eq!(line.diagnosis(MASTER), [0x02, 0x0C, 0x00, MASTER, 0x0A, 0xC5]);
    assert_eq!(line.request(MASTER, Some(62), &CFG), Reply::Sc);
    assert_eq!(line.diagnosis(MASTER), [0x00, 0x0C, 0x00, MASTER, 0x0A, 0xC5]);
    assert_eq!(line.device.dp_state(), State::DataExch);
}

#[test]
fn p_02_a_wrong_ident_number_is_acknowledged_and_shown() {
    let mut line = Line::new();
    assert_eq!(line.request(MASTER, Some(61), &prm(0x80, 11, [0x0A, 0xC6], 0)), Reply::Sc);
    assert_eq!(line.diagnosis(MASTER), [0x42, 0x05, 0x00, 0xFF, 0x0A, 0xC5]);
    let fault = dp::PrmFault::Ident { expected: 0x0AC5, got: 0x0AC6 };
    assert!(line.events.iter().any(
        |event| matches!(event, StationEvent::Dp(dp::Event::PrmRejected { fault: got, .. }) if *got == fault)
    ));
}

#[test]
fn p_03_a_wrong_length_is_acknowledged_and_shown() {
    let long = [good().as_slice(), &[0; 237]].concat();
    for octets in [&good()[..6], &[], &[good().as_slice(), &[0]].concat(), &long] {
        let mut line = Line::new();
        assert_eq!(line.request(MASTER, Some(61), octets), Reply::Sc);
        assert_eq!(line.diagnosis(MASTER)[..4], [0x42, 0x05, 0x00, 0xFF], "{} octets", octets.len());
    }
}

#[test]
fn p_04_lock_and_unlock_all_four() {
    for (status, state, owner) in [
        (0x00, State::DataExch, MASTER),
        (0x40, State::WaitPrm, 0xFF),
        (0x80, State::WaitCfg, MASTER),
        (0xC0, State::WaitPrm, 0xFF),
    ] {
        let mut line = Line::new();
        line.start_up();
        assert_eq!(line.request(MASTER, Some(61), &prm(status, 11, IDENT, 0)), Reply::Sc);
        assert_eq!(line.device.dp_state(), state, "{status:02X}");
        assert_eq!(line.diagnosis(MASTER)[3], owner, "{status:02X}");
    }
}

#[test]
fn p_05_neither_lock_nor_unlock_sets_min_tsdr_only_whatever_the_ident() {
    let mut line = Line::new();
    assert_eq!(line.request(MASTER, Some(61), &prm(0x00, 60, [0, 0], 0xFF)), Reply::Sc);
    line.min_tsdr = 60;
    assert_eq!(line.diagnosis(MASTER), [0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5]);
}

#[test]
fn p_06_min_tsdr_zero_keeps_the_old_one() {
    let mut line = Line::new();
    line.request(MASTER, Some(61), &prm(0x80, 77, IDENT, 0));
    line.min_tsdr = 77;
    line.request(MASTER, Some(61), &prm(0x80, 0, IDENT, 0));
    line.diagnosis(MASTER);
}

#[test]
fn p_08_another_master_changes_nothing_while_the_slave_is_locked() {
    // The owner: watchdog 100 ms, group 1. The other: watchdog off or 10 ms, all groups, min T_SDR 200.
    let owners = [0x88, 1, 10, 11, IDENT[0], IDENT[1], 0x01];
    for status in [0x00, 0x40, 0x80, 0x88, 0xC0] {
        let mut line = Line::new();
        line.start_up_with(&owners);
        let before = line.diagnosis(MASTER);
        let user_prm = line.device.slave().user_prm().to_vec();
        assert_eq!(line.request(OTHER, Some(61), &[status, 1, 1, 200, IDENT[0], IDENT[1], 0xFF]), Reply::Sc);
        assert_eq!(line.request(OTHER, Some(61), &[0x80]), Reply::Sc);
        assert_eq!(line.diagnosis(MASTER), before, "state, faults, WD_On, Master_Add");
        assert_eq!(line.device.dp_state(), State::DataExch);
        let slave = line.device.slave();
        assert_eq!((slave.min_tsdr(), slave.user_prm()), (Some(11), &user_prm[..]));
        assert_eq!(slave.watchdog().unwrap().0, Duration::from_millis(100));
        // Group 2 is the other's wish only.
        line.exchange(&[9; 14]);
        line.global_control(0x02, 0x02);
        assert_eq!(line.device.slave().outputs(), [9; 14]);
        line.global_control(0x02, 0x01);
        assert_eq!(line.device.slave().outputs(), [0; 14]);
        // The watchdog is the owner's: not 10 ms, and not off.
        line.exchange(&[9; 14]);
        line.wait(Duration::from_millis(90));
        assert_eq!(line.device.dp_state(), State::DataExch);
        line.wait(Duration::from_millis(11));
        assert_eq!(line.device.dp_state(), State::WaitPrm);
    }
}

#[test]
fn p_09_another_master_is_accepted_after_release_and_after_the_watchdog() {
    let watchdog = [0x88, 1, 10, 11, IDENT[0], IDENT[1], 0];
    let leave: [fn(&mut Line); 2] = [
        |line| assert_eq!(line.request(MASTER, Some(61), &prm(0x40, 0, IDENT, 0)), Reply::Sc),
        |line| line.wait(Duration::from_millis(101)),
    ];
    for leave in leave {
        let mut line = Line::new();
        line.start_up_with(&watchdog);
        assert_eq!(line.request(OTHER, Some(61), &good()), Reply::Sc);
        assert_eq!(line.diagnosis(OTHER)[3], MASTER, "locked until then");
        leave(&mut line);
        assert_eq!(line.diagnosis(OTHER)[..4], [0x02, 0x05, 0x00, 0xFF]);
        assert_eq!(line.request(OTHER, Some(61), &good()), Reply::Sc);
        assert_eq!(line.request(OTHER, Some(62), &CFG), Reply::Sc);
        assert_eq!(line.diagnosis(OTHER)[..4], [0x00, 0x04, 0x00, OTHER]);
        assert!(matches!(line.request(OTHER, None, &[0; 14]), Reply::Data(_)));
        assert_eq!(line.request(MASTER, None, &[0; 14]), RS, "the former owner is any other master now");
    }
}

#[test]
fn p_10_parameters_twice_raise_no_fault() {
    let mut line = Line::new();
    line.request(MASTER, Some(61), &good());
    line.request(MASTER, Some(61), &good());
    assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x04, 0x00, MASTER]);
    line.request(MASTER, Some(62), &CFG);
    line.request(MASTER, Some(61), &good());
    assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x04, 0x00, MASTER]);
    line.request(MASTER, Some(62), &CFG);
    assert_eq!(line.diagnosis(MASTER)[..4], [0x00, 0x04, 0x00, MASTER]);
}

#[test]
fn p_11_of_two_masters_the_first_stays_owner() {
    let mut line = Line::new();
    line.request(MASTER, Some(61), &good());
    line.request(OTHER, Some(61), &good());
    assert_eq!(line.diagnosis(OTHER)[..4], [0x02, 0x04, 0x00, MASTER]);
}

#[test]
fn p_13_p_14_reserved_bits_and_a_watchdog_of_no_time_are_faults() {
    let mut zero = prm(0x88, 11, IDENT, 0);
    zero[1] = 0;
    for octets in [prm(0x81, 11, IDENT, 0), prm(0x82, 11, IDENT, 0), prm(0x84, 11, IDENT, 0), zero] {
        let mut line = Line::new();
        assert_eq!(line.request(MASTER, Some(61), &octets), Reply::Sc);
        assert_eq!(line.diagnosis(MASTER)[..4], [0x42, 0x05, 0x00, 0xFF]);
    }
}

#[test]
fn p_15_good_parameters_clear_the_fault() {
    let mut line = Line::new();
    line.request(MASTER, Some(61), &[]);
    assert_eq!(line.diagnosis(MASTER)[0], 0x42);
    line.request(MASTER, Some(61), &good());
    assert_eq!(line.diagnosis(MASTER)[0], 0x02);
}

#[test]
fn g_01_both_accepted_configurations_lead_to_data_exchange() {
    for cfg in [&[0xF3, 0xF2][..], &[0xF6]] {
        let mut line = Line::new();
        line.request(MASTER, Some(61), &good());
        assert_eq!(line.request(MASTER, Some(62), cfg), Reply::Sc);
        assert_eq!(line.diagnosis(MASTER)[..2], [0x00, 0x04]);
        line.exchange(&[0; 14]);
        assert_eq!(line.request(MASTER, Some(59), &[]), Reply::Data(cfg.to_vec()), "Get_Cfg");
    }
}

#[test]
fn g_02_a_wrong_configuration_is_acknowledged_and_shown() {
    for cfg in [&[0xF3, 0xF1][..], &[0xF3], &[0xF3, 0xF2, 0x00], &[], &[0xF2, 0xF3], &[0x00; 244]] {
        let mut line = Line::new();
        line.request(MASTER, Some(61), &good());
        assert_eq!(line.request(MASTER, Some(62), cfg), Reply::Sc);
        assert_eq!(line.diagnosis(MASTER)[..4], [0x06, 0x05, 0x00, 0xFF]);
        assert!(line.events.iter().any(|event| event.to_string().contains("Chk_Cfg octet")));
    }
}

#[test]
fn g_03_a_configuration_without_parameters_is_not_activated() {
    let mut line = Line::new();
    assert_eq!(line.request(MASTER, Some(62), &CFG), RS);
    assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x05, 0x00, 0xFF]);
}

#[test]
fn g_04_another_masters_configuration_is_not_activated() {
    for (configured, state) in [(false, State::WaitCfg), (true, State::DataExch)] {
        for configuration in [&CFG[..], &[0x00]] {
            let mut line = Line::new();
            line.request(MASTER, Some(61), &good());
            if configured {
                line.request(MASTER, Some(62), &CFG);
                line.exchange(&[9; 14]);
            }
            let before = line.diagnosis(MASTER);
            assert_eq!(line.request(OTHER, Some(62), configuration), RS);
            assert_eq!((line.device.dp_state(), line.diagnosis(MASTER)), (state, before));
            if configured {
                assert_eq!(line.device.slave().outputs(), [9; 14]);
                line.exchange(&[8; 14]);
            } else {
                assert_eq!(line.request(MASTER, Some(62), &CFG), Reply::Sc, "the owner goes on");
                line.exchange(&[9; 14]);
            }
        }
    }
}

#[test]
fn g_05_a_configuration_in_data_exchange() {
    let mut line = Line::new();
    line.start_up();
    assert_eq!(line.request(MASTER, Some(62), &CFG), Reply::Sc);
    assert_eq!(line.device.dp_state(), State::DataExch);
    assert_eq!(line.request(MASTER, Some(62), &[0xF1]), Reply::Sc);
    assert_eq!(line.diagnosis(MASTER)[..4], [0x06, 0x05, 0x00, 0xFF]);
}

#[test]
fn g_08_g_09_get_cfg_in_each_state_from_any_master() {
    let mut line = Line::new();
    let states: [fn(&mut Line); 3] = [
        |_| {},
        |line| assert_eq!(line.request(MASTER, Some(61), &good()), Reply::Sc),
        |line| assert_eq!(line.request(MASTER, Some(62), &CFG), Reply::Sc),
    ];
    for reach in states {
        reach(&mut line);
        for sa in [MASTER, OTHER] {
            assert_eq!(line.request(sa, Some(59), &[]), Reply::Data(CFG.to_vec()));
            assert_eq!(line.request(sa, Some(59), &[1]), RR);
            assert_eq!(line.request(sa, Some(60), &[1]), RR);
        }
    }
}

#[test]
fn c_04_a_retried_diagnosis_is_the_same_diagnosis() {
    let mut line = Line::new();
    line.request(MASTER, Some(61), &[]);
    line.request(MASTER, Some(61), &[]);
    let octets = line.srd(MASTER, Some(60), &[]);
    let first = line.send(&octets);
    assert!(first.is_some());
    assert_eq!(line.send(&octets), first);
}

#[test]
fn c_05_a_retried_set_prm_is_not_carried_out_twice() {
    let mut line = Line::new();
    // A first cycle is never a retry; the next one can be.
    line.diagnosis(MASTER);
    let octets = line.srd(MASTER, Some(61), &good());
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    let accepted =
        line.events.iter().filter(|event| matches!(event, StationEvent::Dp(dp::Event::Parameterised { .. })));
    assert_eq!(accepted.count(), 1);
}

#[test]
fn f_01_fdl_status_is_answered_in_each_state() {
    let mut line = Line::new();
    let status = hex("10 05 02 49 50 16");
    let reply = Some(hex("10 02 05 00 07 16"));
    assert_eq!(line.send(&status), reply);
    line.request(MASTER, Some(61), &good());
    assert_eq!(line.send(&status), reply);
    line.request(MASTER, Some(62), &CFG);
    assert_eq!(line.send(&status), reply);
}

#[test]
fn f_13_a_sap_where_nothing_listens_is_not_activated() {
    let mut line = Line::new();
    for sap in (0..=55).chain([58, 63]) {
        assert_eq!(line.request(MASTER, Some(sap), &[0x01]), RS, "SAP {sap}");
    }
}

#[test]
fn a_04_set_slave_add_is_closed() {
    let mut line = Line::new();
    assert_eq!(line.request(MASTER, Some(55), &[7, IDENT[0], IDENT[1], 0]), RS);
    assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x05, 0x00, 0xFF]);
}
