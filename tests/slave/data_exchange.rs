//! Data_Exchange, RD_Inp, RD_Outp, Global_Control and the watchdog (`dp-v0.md` 13: X, S, W).

use std::time::Duration;

use profidrive::devices::StationEvent;
use profidrive::profibus::dp;
use profidrive::profibus::dp::State;

use crate::drive_line;
use crate::drive_line::{CFG, IDENT, Line, MASTER, RR, RS, Reply, SLAVE};

const OTHER: u8 = 3;
/// STW 000B: ON, no OFF2, enable operation.
const ENABLE: [u8; 14] = [0, 0, 0, 0, 0, 0, 0, 0, 0x00, 0x0B, 0, 0, 0, 0];
/// STW 0000 with something in HSW, to be told from cleared outputs.
const MARK: [u8; 14] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4];

/// Lock, Sync_Req and Freeze_Req, group 1 and 2, watchdog off.
const SYNC_FREEZE: [u8; 7] = [0xB0, 1, 1, 11, IDENT[0], IDENT[1], 0x03];

fn outputs(line: &mut Line) -> Vec<u8> {
    match line.request(OTHER, Some(57), &[]) {
        Reply::Data(outputs) => outputs,
        reply => panic!("RD_Outp answered {reply:?}"),
    }
}

fn zsw(inputs: [u8; 14]) -> u16 {
    u16::from_be_bytes([inputs[8], inputs[9]])
}

#[test]
fn x_01_outputs_are_applied_and_inputs_are_those_ready_before() {
    let mut line = Line::new();
    line.start_up();
    assert_eq!(outputs(&mut line), [0; 14], "cleared until the first Data_Exchange");
    assert_eq!(zsw(line.exchange(&ENABLE)), 0x2B23, "the reply was ready before the outputs were seen");
    assert_eq!(outputs(&mut line), ENABLE);
    line.wait(Duration::from_millis(2));
    assert_eq!(zsw(line.exchange(&ENABLE)), 0xAB37);
}

#[test]
fn c_03_a_retried_data_exchange_is_applied_once() {
    let mut line = Line::counting_exchanges();
    line.start_up();
    let octets = line.srd(MASTER, None, &ENABLE);
    let first = line.send(&octets).unwrap();
    assert_eq!(line.send(&octets), Some(first.clone()), "the same reply, although the inputs have changed");
    let next = line.exchange(&ENABLE);
    assert_ne!(first[7..21], next);
}

#[test]
fn x_02_a_wrong_length_leaves_data_exchange_and_is_never_silent() {
    for len in [0, 13, 15, 244] {
        let mut line = Line::new();
        line.start_up();
        line.exchange(&ENABLE);
        assert_eq!(line.request(MASTER, None, &vec![0; len]), RS, "{len} octets");
        assert_eq!(line.device.dp_state(), State::WaitPrm);
        assert_eq!(line.request(MASTER, None, &ENABLE), RS);
        assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x05, 0x00, 0xFF]);
    }
}

#[test]
fn x_04_another_master_is_refused_and_the_owner_unharmed() {
    let mut line = Line::new();
    line.start_up();
    line.exchange(&ENABLE);
    assert_eq!(line.request(OTHER, None, &MARK), RS);
    assert_eq!(outputs(&mut line), ENABLE);
    assert_eq!(line.device.dp_state(), State::DataExch);
}

#[test]
fn x_05_no_data_exchange_without_parameters_or_configuration() {
    let mut line = Line::new();
    assert_eq!(line.request(MASTER, None, &ENABLE), RS);
    line.request(MASTER, Some(61), &[0x80, 1, 1, 11, IDENT[0], IDENT[1], 0]);
    assert_eq!(line.request(MASTER, None, &ENABLE), RS);
}

#[test]
fn x_07_anybody_reads_inputs_and_outputs_in_data_exchange_only() {
    let mut line = Line::new();
    let closed = |line: &mut Line| {
        for (sa, sap) in [(OTHER, 56), (OTHER, 57), (MASTER, 56), (MASTER, 57)] {
            assert_eq!(line.request(sa, Some(sap), &[]), RS, "{:?}", line.device.dp_state());
            assert_eq!(line.request(sa, Some(sap), &[0]), RS, "with data");
        }
    };
    closed(&mut line);
    line.request(MASTER, Some(61), &[0x80, 1, 1, 11, IDENT[0], IDENT[1], 0]);
    assert_eq!(line.device.dp_state(), State::WaitCfg);
    closed(&mut line);
    line.start_up();
    let inputs = line.exchange(&MARK);
    assert_eq!(line.request(OTHER, Some(56), &[]), Reply::Data(inputs.to_vec()));
    assert_eq!(line.request(OTHER, Some(57), &[]), Reply::Data(MARK.to_vec()));
    for sap in [56, 57] {
        assert_eq!(line.request(OTHER, Some(sap), &[0]), RR);
    }
    line.request(MASTER, Some(61), &[0x40, 1, 1, 11, IDENT[0], IDENT[1], 0]);
    assert_eq!(line.device.dp_state(), State::WaitPrm);
    closed(&mut line);
}

#[test]
fn s_01_sync_holds_the_outputs_until_the_next_sync_or_unsync() {
    let mut line = Line::new();
    line.start_up_with(&SYNC_FREEZE);
    line.exchange(&MARK);
    line.global_control(0x20, 0);
    assert_eq!(outputs(&mut line), MARK);
    line.exchange(&ENABLE);
    assert_eq!(outputs(&mut line), MARK, "held");
    assert_eq!(line.diagnosis(MASTER)[1], 0x24);
    line.global_control(0x20, 0);
    assert_eq!(outputs(&mut line), ENABLE, "passed on by the next Sync");
    line.exchange(&MARK);
    line.global_control(0x10, 0);
    assert_eq!(outputs(&mut line), MARK, "passed on by Unsync");
    line.exchange(&ENABLE);
    assert_eq!(outputs(&mut line), ENABLE, "no longer held");
}

#[test]
fn s_02_freeze_holds_the_inputs_until_the_next_freeze_or_unfreeze() {
    let mut line = Line::new();
    line.start_up_with(&SYNC_FREEZE);
    line.global_control(0x08, 0);
    line.exchange(&ENABLE);
    line.wait(Duration::from_millis(2));
    assert_eq!(zsw(line.exchange(&ENABLE)), 0x2B23, "frozen before the drive was enabled");
    assert_eq!(line.diagnosis(MASTER)[1], 0x14);
    line.global_control(0x08, 0);
    assert_eq!(zsw(line.exchange(&[0; 14])), 0xAB37, "the next snapshot");
    line.wait(Duration::from_millis(2));
    assert_eq!(zsw(line.exchange(&[0; 14])), 0xAB37);
    line.global_control(0x04, 0);
    assert_eq!(zsw(line.exchange(&[0; 14])), 0x2B23, "live again");
}

#[test]
fn s_03_sync_and_unsync_together_undo() {
    let mut line = Line::new();
    line.start_up_with(&SYNC_FREEZE);
    line.global_control(0x28, 0);
    assert_eq!(line.diagnosis(MASTER)[1], 0x34);
    line.global_control(0x3C, 0);
    assert_eq!(line.diagnosis(MASTER)[1], 0x04);
}

#[test]
fn s_04_clear_data_clears_the_outputs_and_stays_in_data_exchange() {
    let mut line = Line::new();
    line.start_up_with(&SYNC_FREEZE);
    line.exchange(&MARK);
    line.global_control(0x02, 0);
    assert_eq!(outputs(&mut line), [0; 14]);
    assert_eq!(line.device.dp_state(), State::DataExch);
    line.exchange(&MARK);
    line.global_control(0x20, 0);
    line.exchange(&ENABLE);
    line.global_control(0x02, 0);
    line.global_control(0x10, 0);
    assert_eq!(outputs(&mut line), [0; 14], "what waited for Sync is cleared too");
}

#[test]
fn s_05_p_16_groups_decide_and_come_with_lock_only() {
    let mut line = Line::new();
    line.start_up_with(&SYNC_FREEZE);
    // Neither lock nor unlock: the group stays.
    line.request(MASTER, Some(61), &[0x00, 1, 1, 0, IDENT[0], IDENT[1], 0x80]);
    for (groups, obeys) in [(0x00, true), (0x01, true), (0x03, true), (0x04, false), (0x80, false)] {
        line.exchange(&MARK);
        line.global_control(0x02, groups);
        assert_eq!(outputs(&mut line) == [0; 14], obeys, "groups {groups:02X}");
    }
}

#[test]
fn s_06_s_07_another_master_or_another_state_has_no_effect() {
    let mut line = Line::new();
    line.request(MASTER, Some(61), &SYNC_FREEZE);
    line.global_control(0x28, 0);
    line.request(MASTER, Some(62), &CFG);
    assert_eq!(line.diagnosis(MASTER)[1], 0x04, "ignored in WAIT-CFG");
    line.exchange(&MARK);
    line.sdn(OTHER, 127, 58, &[0x02, 0]);
    assert_eq!(outputs(&mut line), MARK, "ignored from another master");
}

#[test]
fn s_08_a_malformed_command_has_no_effect() {
    let mut line = Line::new();
    line.start_up_with(&SYNC_FREEZE);
    line.exchange(&MARK);
    for data in [&[0x03, 0][..], &[0x42, 0], &[0x82, 0], &[0x02], &[0x02, 0, 0], &[]] {
        line.sdn(MASTER, 127, 58, data);
    }
    assert_eq!(outputs(&mut line), MARK);
}

#[test]
fn s_09_a_command_to_this_station_alone_works_too() {
    let mut line = Line::new();
    line.start_up();
    line.exchange(&MARK);
    line.sdn(MASTER, 9, 58, &[0x02, 0]);
    assert_eq!(outputs(&mut line), MARK);
    line.sdn(MASTER, SLAVE, 58, &[0x02, 0]);
    assert_eq!(outputs(&mut line), [0; 14]);
}

#[test]
fn s_10_a_mode_not_asked_for_in_set_prm_stays_closed() {
    let mut line = Line::new();
    line.start_up();
    line.global_control(0x28, 0);
    assert_eq!(line.diagnosis(MASTER)[1], 0x04);
}

#[test]
fn s_11_sync_and_freeze_end_with_the_owner() {
    let mut watched = SYNC_FREEZE;
    watched[..3].copy_from_slice(&[SYNC_FREEZE[0] | 0x08, 1, 10]);
    type Leave = fn(&mut Line);
    let leave: [(&str, Leave); 5] = [
        ("released", |line| drop(line.request(MASTER, Some(61), &[0x40, 1, 1, 11, IDENT[0], IDENT[1], 0]))),
        ("watchdog expired", |line| line.wait(Duration::from_millis(101))),
        ("wrong length", |line| assert_eq!(line.request(MASTER, None, &[0; 3]), RS)),
        ("wrong Set_Prm", |line| drop(line.request(MASTER, Some(61), &[0x80]))),
        ("wrong Chk_Cfg", |line| drop(line.request(MASTER, Some(62), &[0x00]))),
    ];
    for (what, leave) in leave {
        let mut line = Line::new();
        line.start_up_with(&watched);
        line.exchange(&MARK);
        line.global_control(0x28, 0);
        assert_eq!(line.diagnosis(MASTER)[1], 0x3C, "WD_On, Freeze_Mode, Sync_Mode");
        leave(&mut line);
        assert_eq!(line.device.dp_state(), State::WaitPrm, "{what}");
        assert_eq!(line.diagnosis(MASTER)[1] & 0x30, 0, "{what}");
        line.start_up_with(&watched);
        assert_eq!(line.diagnosis(MASTER)[1] & 0x30, 0, "{what}: off after the restart");
        line.exchange(&MARK);
        assert_eq!(outputs(&mut line), MARK, "{what}: outputs are not held");
        line.exchange(&ENABLE);
        line.wait(Duration::from_millis(2));
        assert_eq!(zsw(line.exchange(&ENABLE)), 0xAB37, "{what}: inputs are not held");
    }
}

#[test]
fn w_01_a_silent_master_costs_it_the_slave() {
    let mut line = Line::new();
    // 10 ms * 3 * 5.
    line.start_up_with(&[0x88, 3, 5, 11, IDENT[0], IDENT[1], 0]);
    line.exchange(&ENABLE);
    line.wait(Duration::from_millis(148));
    assert_eq!(zsw(line.exchange(&ENABLE)), 0xAB37);
    line.wait(Duration::from_millis(151));
    assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x05, 0x00, 0xFF]);
    assert!(line.events.iter().any(|event| matches!(
        event,
        StationEvent::Dp(dp::Event::WatchdogExpired { after, .. }) if *after == Duration::from_millis(150)
    )));
    assert_eq!(words(&line), 0x2B23, "the drive has lost its enable");
}

#[test]
fn w_02_without_watchdog_everything_is_held() {
    let mut line = Line::new();
    line.start_up();
    line.exchange(&ENABLE);
    line.wait(Duration::from_secs(3600));
    assert_eq!(outputs(&mut line), ENABLE);
    assert_eq!(zsw(line.exchange(&ENABLE)), 0xAB37);
}

#[test]
fn w_03_only_telegrams_of_the_owner_to_this_slave_feed_the_watchdog() {
    type Feed = fn(&mut Line);
    let fed: [(&str, Feed, bool); 6] = [
        ("Slave_Diag of the owner", |line| assert_eq!(line.diagnosis(MASTER)[3], MASTER), true),
        ("Data_Exchange of the owner", |line| assert_eq!(line.exchange(&ENABLE).len(), 14), true),
        ("FDL status of the owner", |line| drop(line.send(&drive_line::hex("10 05 02 49 50 16"))), false),
        ("Slave_Diag of another master", |line| assert_eq!(line.diagnosis(OTHER)[4], 0x0A), false),
        ("the owner to another slave", |line| drop(line.send(&drive_line::hex("10 06 02 49 51 16"))), false),
        ("a broadcast of the owner", |line| line.global_control(0, 0), false),
    ];
    for (what, feed, alive) in fed {
        let mut line = Line::new();
        line.start_up_with(&[0x88, 1, 10, 11, IDENT[0], IDENT[1], 0]);
        for _ in 0..4 {
            line.wait(Duration::from_millis(60));
            feed(&mut line);
        }
        assert_eq!(line.device.dp_state() == State::DataExch, alive, "{what}");
    }
}

#[test]
fn w_04_watchdog_times_up_to_eleven_minutes() {
    for (first, second) in [(1, 1), (1, 255), (255, 1), (255, 255)] {
        let mut line = Line::new();
        line.start_up_with(&[0x88, first, second, 11, IDENT[0], IDENT[1], 0]);
        line.exchange(&ENABLE);
        let time = Duration::from_millis(10) * u32::from(first) * u32::from(second);
        line.wait(time - Duration::from_millis(1));
        assert_eq!(line.device.dp_state(), State::DataExch);
        line.wait(Duration::from_millis(1));
        assert_eq!(line.device.dp_state(), State::WaitPrm);
    }
}

#[test]
fn w_06_a_cable_put_back_in_time_goes_on() {
    let mut line = Line::new();
    line.start_up_with(&[0x88, 1, 10, 11, IDENT[0], IDENT[1], 0]);
    for (away, inside) in [(90, true), (110, false)] {
        line.wait(Duration::from_millis(away));
        let reply = line.request(MASTER, None, &ENABLE);
        assert_eq!(matches!(reply, Reply::Data(_)), inside, "{away} ms");
    }
    line.start_up();
    line.exchange(&ENABLE);
}

/// The status word as the drive part has it now.
fn words(line: &Line) -> u16 {
    line.device.zsw().raw()
}
