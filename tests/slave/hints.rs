//! Each hint comes once when something is odd, comes again after its pause, and never when nothing is.

use std::time::Duration;

use profidrive::devices::ag03::drive::{Fault, Inputs};
use profidrive::devices::ag03::param::Value;
use profidrive::devices::ag03::profibus::Config;
use profidrive::face::EventKind;

use crate::drive_line::{CFG, IDENT, MASTER, Reply};
use crate::drive_log::{CYCLE, PRM, Told, address};

/// Change PNU 1004 (v-Pos), a word, to 50; and PNU 1005 likewise.
const V_POS: [u8; 8] = [0x23, 0xEC, 0, 0, 0, 0, 0, 50];

#[test]
fn a_whole_commissioning_gives_no_hint() {
    let mut told = Told::enabled();
    told.say(0x007B, 1600, Duration::from_secs(4));
    told.say(0x003B, 0, Duration::from_secs(4));
    told.pkw = V_POS;
    told.say(0x003B, 0, CYCLE * 2);
    told.pkw[1] = 0xED;
    told.say(0x003B, 0, CYCLE * 2);
    told.pkw = [0; 8];
    told.say(0x007B, 3200, Duration::from_secs(1));
    told.inputs(Inputs::default().provoking(Fault::F));
    told.say(0x007B, 3200, CYCLE);
    told.inputs(Inputs::default());
    told.say(0x003B, 3200, CYCLE);
    told.say(0x00BB, 3200, CYCLE);
    told.say(0x003A, 3200, CYCLE);
    told.say(0x003B, 3200, CYCLE);
    told.say(0x007B, 0, Duration::from_secs(4));
    told.line.global_control(0x28, 0);
    told.say(0x007B, 0, Duration::from_secs(1));
    told.line.global_control(0x14, 0);
    told.say(0x0000, 0, CYCLE);
    told.write(930, Value::Word(1));
    told.say(0x000B, 0, CYCLE);
    told.say(0x004B, 100, Duration::from_secs(2));
    told.say(0x0000, 0, Duration::from_secs(2));
    // The master ends, and comes back later.
    told.line.wait(Duration::from_secs(3));
    told.line.start_up_with(&PRM);
    told.say(0x0000, 0, CYCLE);
    assert!(told.line.events.len() > 20);
    assert_eq!(told.hints(), Vec::<String>::new());
}

#[test]
fn the_address_of_stations_without_one_is_said_when_it_is_switched_on() {
    let mut told = Told::with(|config| Config { switches: address(126).into(), ..config });
    told.line.wait(CYCLE);
    let text = "hint: address 126 is for stations that have no address yet, there is no Data_Exchange at it; set another \
                address with SW1 to SW7 and switch off and on";
    assert_eq!(told.hints(), [text]);
    let mut told = Told::new();
    told.line.wait(CYCLE);
    assert_eq!(told.hints(), Vec::<String>::new());
}

#[test]
fn a_watchdog_shorter_than_the_cycle_of_the_master_is_said_at_the_second_expiry() {
    let mut told = Told::new();
    for round in 0..3 {
        // 10 ms, and the master comes every 25 ms.
        told.line.start_up_with(&[0x88, 1, 1, 11, IDENT[0], IDENT[1], 0]);
        told.line.wait(Duration::from_millis(25));
        let hints = told.hints();
        assert_eq!(hints.len(), usize::from(round == 2), "{hints:?}");
        if let Some(hint) = hints.first() {
            let [begin, end] = [
                "hint: the watchdog time 10ms is shorter than the cycle of master 2: 25.",
                "raise the \
                watchdog time in the master's project",
            ];
            assert!(hint.starts_with(begin) && hint.ends_with(end), "{hint}");
        }
    }

    // A master that is switched off and on.
    let mut told = Told::new();
    for _ in 0..4 {
        told.line.start_up_with(&PRM);
        told.line.wait(Duration::from_secs(3));
    }
    assert_eq!(told.hints(), Vec::<String>::new());
}

#[test]
fn pkw_words_that_change_in_the_middle_of_a_job_are_said() {
    let text = "hint: the PKW words changed in the middle of a job: 23EC 0000 0000 0007 was executed, then came 23ED 0000 \
                0000 0007 before there was a reply; write all four words in one Data_Exchange, and wait for the reply";
    // The value first and the number one exchange later.
    let mut told = Told::exchanging();
    told.pkw = V_POS;
    told.say(0, 0, CYCLE * 3);
    told.pkw[7] = 7;
    told.exchange(0, 0);
    told.line.wait(CYCLE);
    told.pkw[1] = 0xED;
    told.exchange(0, 0);
    told.line.wait(CYCLE);
    assert_eq!(told.hints(), [text]);

    // The number first and the value later.
    let mut told = Told::exchanging();
    told.pkw = V_POS;
    told.say(0, 0, CYCLE * 3);
    told.pkw[1] = 0xED;
    told.exchange(0, 0);
    told.line.wait(CYCLE);
    told.pkw[7] = 7;
    told.exchange(0, 0);
    told.line.wait(CYCLE);
    assert_eq!(told.hints().len(), 1);

    // One job after the other, each with its reply.
    let mut told = Told::exchanging();
    for (number, value) in [(0xEC, 50), (0xEC, 7), (0xED, 7), (0xED, 9)] {
        told.pkw = V_POS;
        (told.pkw[1], told.pkw[7]) = (number, value);
        told.say(0, 0, CYCLE);
    }
    assert_eq!(told.hints(), Vec::<String>::new());
}

#[test]
fn a_velocity_setpoint_beyond_the_gear_is_said() {
    let mut told = Told::enabled();
    told.write(930, Value::Word(1));
    told.say(0x000B, 0, CYCLE);
    told.line.events.clear();
    told.say(0x004B, -170, Duration::from_secs(1));
    let texts = told.texts();
    assert_eq!(
        texts,
        [
            "turning with -100 rpm, the setpoint -170 rpm is limited: the gear allows at most 100 rpm",
            "hint: the velocity setpoint -170 rpm is more than the gear allows, the shaft turns with -100 rpm; give at \
             most 100 rpm"
        ]
    );
    told.say(0x004B, 50, Duration::from_secs(2));
    told.say(0x004B, 180, Duration::from_secs(2));
    assert_eq!(told.hints(), Vec::<String>::new(), "said a moment ago");
}

#[test]
fn equal_and_exchanged_limits_are_said_when_operation_is_enabled() {
    for (limits, hint) in [
        (
            (500, 500),
            Some(
                "hint: both limits are 500 (PNU 1016, 1017): equal limits switch the monitoring off; set two \
                           different limits",
            ),
        ),
        (
            (-500, 500),
            Some(
                "hint: limit 1 is -500 (PNU 1016) and limit 2 is 500 (PNU 1017): the drive takes 500 as the \
                            upper limit; exchange them if that is not meant",
            ),
        ),
        ((500, -500), None),
    ] {
        let mut told = Told::exchanging();
        told.say(0, 0, CYCLE);
        for (pnu, limit) in [(1016, limits.0), (1017, limits.1)] {
            told.write(pnu, Value::Double(i32::cast_unsigned(limit)));
        }
        assert_eq!(told.hints(), Vec::<String>::new(), "limits are changed one after the other");
        told.say(0x003B, 0, CYCLE);
        told.say(0x0000, 0, CYCLE);
        told.say(0x003B, 0, CYCLE);
        assert_eq!(told.hints(), Vec::from_iter(hint), "{limits:?}");
    }
}

#[test]
fn an_acknowledgement_given_again_is_said_with_what_to_send() {
    let mut told = Told::enabled();
    told.inputs(Inputs::default().provoking(Fault::F));
    told.say(0x003B, 0, CYCLE);
    told.inputs(Inputs::default());
    for stw in [0x003B, 0x00BB, 0x003B] {
        told.say(stw, 0, CYCLE);
    }
    assert_eq!(told.hints(), Vec::<String>::new());
    told.say(0x00BB, 0, CYCLE);
    let text = "hint: STW.7 = 1 does nothing now: the fault is acknowledged and turning on is disabled until OFF1 is given \
                once (STW.0 = 0); next: send STW 003A, then 003B";
    assert_eq!(told.hints(), [text]);
    for stw in [0x003A, 0x003B] {
        told.say(stw, 0, CYCLE);
    }
    assert!(told.line.device.status().operation_enabled);
}

#[test]
fn a_start_bit_that_is_1_before_operation_is_enabled_is_said() {
    let mut told = Told::exchanging();
    told.say(0x0070, 1600, CYCLE);
    told.line.events.clear();
    told.say(0x007B, 1600, Duration::from_secs(1));
    let text = "hint: STW.6 is 1 already, so no travel begins: only a change of STW.6 starts one; next: send STW 003B";
    assert_eq!(told.hints(), [text]);
    assert!(!told.line.device.status().travelling);
    told.say(0x003B, 1600, Duration::from_secs(1));
    assert!(told.line.device.status().travelling, "as the hint says");
}

#[test]
fn a_hint_hides_no_event() {
    let mut told = Told::new();
    assert_eq!(told.line.request(MASTER, Some(61), &[0x88, 1, 1, 11, IDENT[0], IDENT[1], 0]), Reply::Sc);
    assert_eq!(told.line.request(MASTER, Some(62), &CFG), Reply::Sc);
    for _ in 0..9 {
        told.line.start_up_with(&[0x88, 1, 1, 11, IDENT[0], IDENT[1], 0]);
        told.line.wait(Duration::from_millis(30));
    }
    let expired =
        told.line.events.iter().filter(|event| event.to_string().contains("watchdog expired")).count();
    let hints = told.line.events.iter().filter(|event| event.kind() == EventKind::Hint).count();
    assert_eq!((expired, hints), (9, 1));
}
