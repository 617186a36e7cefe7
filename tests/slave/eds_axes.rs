//! A drive of CiA 402 with several axes from its file: each is a drive of its own, by the same code.
#![cfg(feature = "eds")]

use profidrive::devices::CanopenDevice;
use profidrive::face::DriveState;
use profidrive::face::surroundings::{Declined, Level};

use crate::file_drive::{Drive, ENABLED, FAULT, REACHED};

impl Drive {
    fn on_axis(&mut self, axis: u16) -> &mut Self {
        self.1 = axis;
        self
    }

    fn provoke(&mut self, fault: &str) -> (Result<(), Declined>, Vec<String>) {
        let now = self.0.now;
        let mut outcome = Ok(());
        self.0.device.act(now, &mut |device| outcome = device.provoke(now, fault));
        (outcome, self.0.drain())
    }
}

#[test]
fn each_of_eight_axes_is_enabled_and_moves_alone() {
    let mut drive = Drive::with_axes(8);
    for axis in 0..8 {
        assert_eq!(drive.on_axis(axis).state(), 0x40, "axis {axis}");
    }
    for axis in (0..8).rev() {
        let target = 1000 * (i32::from(axis) + 1);
        drive.on_axis(axis).enable(1);
        drive.go_to(target, 0x1F);
        drive.until(REACHED);
        drive.millis(50);
        assert!((drive.position() - target).abs() <= 2, "axis {axis} at {}", drive.position());
        for other in 0..axis {
            drive.on_axis(other);
            assert_eq!((drive.state(), drive.position()), (0x40, 0), "axis {other} while {axis} moves");
        }
    }
}

#[test]
fn axes_run_in_modes_of_their_own_and_stop_alone() {
    let mut drive = Drive::with_axes(2);
    drive.on_axis(0).enable(3);
    drive.put(0x60FF, 0, 20_000);
    drive.on_axis(1).enable(6);
    drive.word(0x1F);
    drive.until(1 << 12);
    assert_eq!(drive.signed(0x6061), 6);
    drive.millis(500);
    assert!(drive.on_axis(0).speed() > 19_000, "the homing of axis 2 does not touch axis 1");
    drive.word(0x02);
    drive.millis(500);
    assert_eq!((drive.state(), drive.speed()), (0x40, 0));
    assert_eq!(drive.on_axis(1).state(), ENABLED);
}

#[test]
fn pdos_of_axis_n_are_64_behind_those_of_the_axis_before() {
    let mut drive = Drive::with_axes(3);
    drive.on_axis(2).mode(1);
    // RPDO 129 and TPDO 129: 200h and 180h, and 100h for each axis before.
    for (word, answer) in [(0x06, "385#3102"), (0x07, "385#3302"), (0x0F, "385#3702")] {
        let sent = drive.0.data(0x405, &[word, 0, 0xE8, 3, 0, 0]);
        assert_eq!(sent, [answer], "{word:02X}h");
    }
    assert_eq!(drive.signed(0x607A), 1000);
    drive.0.data(0x405, &[0x1F, 0, 0xE8, 3, 0, 0]);
    drive.until(REACHED);
    assert!((drive.position() - 1000).abs() <= 2);
    for axis in [0, 1] {
        assert_eq!(drive.on_axis(axis).state(), 0x40);
    }
    assert_eq!(drive.0.write(0x1480, 1, &[5, 4, 0, 0x80]), Ok(()), "RPDO 129 off");
    assert_eq!(drive.0.data(0x405, &[0, 0, 0, 0, 0, 0]), [""; 0]);
    assert_eq!(drive.on_axis(2).state(), ENABLED);
}

#[test]
fn a_fault_is_of_one_axis_and_the_register_is_of_all() {
    let mut drive = Drive::with_axes(2);
    drive.on_axis(0).enable(3);
    drive.on_axis(1).enable(3);
    let (outcome, sent) = drive.provoke("axis_2_4310");
    assert_eq!(outcome, Ok(()));
    assert!(sent.contains(&"085#1043090000000000".to_owned()), "{sent:?}");
    drive.millis(500);
    assert_eq!((drive.state(), drive.0.number(0x683F, 0)), (FAULT, 0x4310));
    assert_eq!((drive.on_axis(0).state(), drive.0.number(0x603F, 0)), (ENABLED, 0));
    assert_eq!(drive.0.device.description().drive_state(), Some(DriveState::Fault));
    let mut told = Vec::new();
    let description = drive.0.device.description();
    description.tell_fault(&mut |code, text| told.push(format!("{code} {text}")));
    assert_eq!(told, ["4310 axis 2: the motor is too hot"]);
    let (_, sent) = drive.provoke("3210");
    assert!(sent.contains(&"085#10320D0000000000".to_owned()), "the bits of both: {sent:?}");
    drive.millis(500);
    drive.word(0x80);
    assert_eq!(drive.state(), 0x40);
    assert_eq!(drive.0.number(0x1001, 0), 0x09, "what is left is of axis 2");
    let reset = drive.0.data(0x605, &[0x2B, 0x40, 0x68, 0, 0x80, 0, 0, 0]);
    assert!(reset.contains(&"085#0000000000000000".to_owned()), "{reset:?}");
    assert_eq!(drive.provoke("axis_3_4310").0, Err(Declined::Unknown));
}

#[test]
fn what_an_axis_tells_and_takes_has_its_number() {
    let mut drive = Drive::with_axes(2);
    let description = drive.0.device.description();
    let (mut inputs, mut values, mut reasons, mut states) = (vec![], vec![], vec![], vec![]);
    description.each_input(&mut |input, _| inputs.push(format!("{}: {}", input.name, input.about)));
    description.each_value(&mut |value| values.push((value.key, value.name, value.headline)));
    description.why().unwrap().each_reason(&mut |reason| reasons.push(reason.to_string()));
    description.say_state(&mut |state| states.push(state.to_string()));
    assert!(inputs.contains(&"blocked: the shaft cannot turn".into()), "{inputs:?}");
    assert!(inputs.contains(&"axis_2_blocked: axis 2: the shaft cannot turn".into()), "{inputs:?}");
    assert!(
        values.contains(&("position", "Position", true))
            && values.contains(&("axis_2_position", "axis 2: Position", false))
    );
    let why = "axis 2: drive state 'switch on disabled': send 6840h = 0006h, then 0007h, then 000Fh";
    assert!(reasons.contains(&why.into()), "{reasons:?}");
    assert_eq!(states, ["axis 1: switch on disabled, axis 2: switch on disabled"]);
    let words: Vec<_> = description.words().iter().map(ToString::to_string).collect();
    assert_eq!(words, ["6040h:00", "6041h:00", "6840h:00", "6841h:00"]);

    drive.set("axis_2_main_circuit", Level::Switch(false));
    assert_eq!(drive.0.device.description().nominal("axis_2_main_circuit"), Some(Level::Switch(true)));
    drive.on_axis(0).enable(3);
    drive.on_axis(1).mode(3);
    drive.word(0x06);
    drive.word(0x07);
    drive.word(0x0F);
    assert_eq!(drive.state(), 0x23, "axis 2 has no supply");
    let mut news = Vec::new();
    let now = drive.0.now;
    let frame = profidrive::can_bus::can::Frame::data(
        profidrive::can_bus::can::Id::base(0x605).unwrap(),
        &[0x2B, 0x40, 0x68, 0, 0x06, 0, 0, 0],
    );
    drive.0.device.handle_frame(now, &frame.unwrap());
    while let Some(event) = drive.0.device.poll_event() {
        news.push(event.to_string());
    }
    assert!(news.contains(&"axis 2: drive state 'switched on' -> 'ready to switch on'".into()), "{news:?}");
}

#[test]
fn the_option_code_of_an_axis_acts_on_it_alone() {
    let mut drive = Drive::with_axes(2);
    drive.on_axis(1).put(0x605A, 0, 6);
    // 6 keeps the drive in QUICK STOP ACTIVE; the first axis has 2.
    for (axis, state) in [(0, 0x40), (1, 0x07)] {
        drive.on_axis(axis).enable(3);
        drive.word(0x02);
        drive.millis(50);
        assert_eq!(drive.state(), state, "axis {axis}");
    }
}
