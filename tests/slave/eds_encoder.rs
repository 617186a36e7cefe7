//! An encoder of CiA 406 that a file describes, as a master sees it (`eds.md` 4, E-63).
#![cfg(feature = "eds")]

use std::time::Duration;

use profidrive::devices::CanopenDevice;
use profidrive::face::surroundings::Level;

use crate::file_node::{NODE, Rig, array, pdo, var};

const U8: u16 = 5;
const U16: u16 = 6;
const U32: u16 = 7;
const I16: u16 = 3;
const I32: u16 = 4;

/// 4096 steps in each of 16 turns.
fn encoder() -> Rig {
    let cam = |index, default| array(index, I32, "rw", &[default]);
    let text = var(0x1000, U32, "ro", "DefaultValue=0x00020196")
        + &array(0x1010, U32, "rw", &["1"])
        + &array(0x1011, U32, "rw", &["1"])
        + &pdo(0x1800, "$NODEID+0x180", 254, &["0x60040020"])
        + &var(0x6000, U16, "rw", "")
        + &var(0x6001, U32, "rw", "DefaultValue=4096")
        + &var(0x6002, U32, "rw", "DefaultValue=65536")
        + &var(0x6003, U32, "rw", "")
        + &var(0x6004, U32, "ro", "PDOMapping=1")
        + &array(0x6030, I16, "ro", &[""])
        + &var(0x6200, U16, "rw", "DefaultValue=50")
        + &array(0x6300, U8, "ro", &[""])
        + &array(0x6301, U8, "rw", &["3"])
        + &array(0x6302, U8, "rw", &[""])
        + &cam(0x6310, "1000")
        + &cam(0x6311, "5000")
        + &cam(0x6320, "2000")
        + &cam(0x6321, "6000")
        + &cam(0x6330, "100")
        + &array(0x6400, U8, "ro", &[""])
        + &cam(0x6401, "100")
        + &cam(0x6402, "50000")
        + &var(0x6500, U16, "ro", "")
        + &var(0x6501, U32, "ro", "DefaultValue=4096")
        + &var(0x6502, U16, "ro", "DefaultValue=16")
        + &var(0x6509, I32, "ro", "");
    Rig::text(&text)
}

fn turn(rig: &mut Rig, steps: f64) -> Vec<String> {
    rig.set("6004h", Level::Number(steps))
}

fn set(rig: &mut Rig, index: u16, value: u32) -> Result<(), u32> {
    let len = rig.read(index, 0).unwrap().len();
    rig.write(index, 0, &value.to_le_bytes()[..len])
}

#[test]
fn eds_63_the_preset_is_the_position_at_once_and_is_kept_when_it_is_stored() {
    let mut rig = encoder();
    turn(&mut rig, 1000.0);
    assert_eq!(rig.number(0x6004, 0), 1000);
    set(&mut rig, 0x6003, 300).unwrap();
    assert_eq!((rig.number(0x6004, 0), rig.number(0x6003, 0)), (300, 300));
    assert_eq!(rig.number(0x6509, 0).cast_signed(), -700);
    turn(&mut rig, 500.0);
    assert_eq!(rig.number(0x6004, 0), 65536 - 200, "round its range");
    assert_eq!(set(&mut rig, 0x6003, 65536), Err(0x0609_0031));
    let mut rig = rig.again();
    assert_eq!(rig.number(0x6004, 0), 500, "it was not stored");
    set(&mut rig, 0x6003, 300).unwrap();
    rig.write(0x1010, 1, b"save").unwrap();
    let mut rig = rig.again();
    assert_eq!((rig.number(0x6004, 0), rig.number(0x6509, 0).cast_signed()), (300, -200));
    rig.write(0x1011, 1, b"load").unwrap();
    rig.data(0, &[0x81, NODE]);
    assert_eq!((rig.number(0x6004, 0), rig.number(0x6003, 0)), (500, 0));
}

#[test]
fn eds_63_code_sequence_and_scaling_are_those_of_6000h_to_6002h() {
    let mut rig = encoder();
    turn(&mut rig, 1024.0);
    set(&mut rig, 0x6000, 1).unwrap();
    assert_eq!((rig.number(0x6004, 0), rig.number(0x6500, 0)), (65536 - 1024, 1));
    set(&mut rig, 0x6001, 360).unwrap();
    set(&mut rig, 0x6002, 3600).unwrap();
    assert_eq!(rig.number(0x6004, 0), 65536 - 1024, "scaling is off");
    set(&mut rig, 0x6000, 4).unwrap();
    assert_eq!((rig.number(0x6004, 0), rig.number(0x6500, 0)), (90, 4));
    turn(&mut rig, 4096.0 * 10.25);
    assert_eq!(rig.number(0x6004, 0), 90, "round the measuring range");
    set(&mut rig, 0x6003, 10).unwrap();
    assert_eq!(rig.number(0x6004, 0), 10);
}

#[test]
fn eds_63_the_cyclic_timer_is_the_event_timer_of_the_first_tpdo() {
    let mut rig = encoder();
    assert_eq!((rig.number(0x6200, 0), rig.number(0x1800, 5)), (50, 50));
    rig.start();
    assert_eq!(rig.pass(Duration::from_millis(100)).len(), 2);
    set(&mut rig, 0x6200, 10).unwrap();
    assert_eq!(rig.number(0x1800, 5), 10);
    assert_eq!(rig.pass(Duration::from_millis(100)).len(), 10);
    rig.write(0x1800, 5, &[0, 0]).unwrap();
    assert_eq!((rig.number(0x6200, 0), rig.pass(Duration::from_millis(100)).len()), (0, 0));
    assert_eq!(turn(&mut rig, 77.0), ["185#4D000000"]);
}

#[test]
fn a_preset_while_the_cyclic_timer_is_due_is_sent_once_and_keeps_the_pace() {
    let mut rig = encoder();
    rig.start();
    turn(&mut rig, 1000.0);
    rig.write(0x1800, 2, &[255]).unwrap();
    // To the moment when the timer is due, before it was handled.
    let due = rig.device.poll_timeout().unwrap();
    rig.now = due;
    set(&mut rig, 0x6003, 300).unwrap();
    assert_eq!(rig.number(0x6004, 0), 300);
    rig.device.handle_timeout(due);
    let sent = rig.drain();
    assert!(
        sent.iter().all(|frame| frame == "185#2C010000") && sent.len() <= 1,
        "the new position: {sent:?}"
    );
    assert_eq!(rig.pass(Duration::from_millis(200)).len(), 4, "each 50 ms from then on");
}

#[test]
fn the_speed_is_that_of_the_shaft_and_ends_with_it() {
    let mut rig = encoder();
    for step in 1..=50 {
        turn(&mut rig, f64::from(65536 + 20 - 2 * step));
        rig.pass(Duration::from_millis(1));
    }
    assert_eq!(rig.number(0x6030, 1), 0xFFFF & (-2000_i32).cast_unsigned(), "through zero of the range");
    rig.pass(Duration::from_millis(200));
    assert_eq!(rig.number(0x6030, 1), 0);
}

#[test]
fn cams_and_the_work_area_follow_the_position() {
    let mut rig = encoder();
    for (position, cams, area) in [
        (0.0, 0, 0b101),
        (999.0, 0, 0),
        (1000.0, 1, 0),
        (2100.0, 1, 0),
        (2101.0, 0, 0),
        (2050.0, 0, 0),
        (6000.0, 2, 0),
        (50001.0, 0, 0b011),
    ] {
        turn(&mut rig, position);
        assert_eq!((rig.number(0x6300, 1), rig.number(0x6400, 1)), (cams, area), "{position}");
    }
    rig.write(0x6302, 1, &[1]).unwrap();
    assert_eq!(rig.number(0x6300, 1), 1);
    rig.write(0x6301, 1, &[2]).unwrap();
    assert_eq!(rig.number(0x6300, 1), 0);
    set(&mut rig, 0x6003, 5500).unwrap();
    assert_eq!(rig.number(0x6300, 1), 2);
}
