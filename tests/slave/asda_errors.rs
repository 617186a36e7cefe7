//! Alarms that the bus causes in the ASDA-A2 (`canopen-asda-a2.md` 4 to 7, 15).

use profidrive::can_bus::can::{ErrorState, Frame, Id};
use profidrive::can_bus::canopen::NmtState;
use profidrive::can_bus::cia402::{Mode, State, Statusword};
use profidrive::devices::CanopenDevice;
use profidrive::devices::asda_a2::canopen::Quirks;
use profidrive::devices::asda_a2::inputs::Closed;
use profidrive::devices::asda_a2::{Alarm, Config, Effect, Inputs};

use crate::asda_a2_node::{NODE, Rig, millis};

/// Guards the node once, then never again.
fn guard(rig: &mut Rig) {
    rig.set(0x100C, 0, 10);
    rig.set(0x100D, 0, 3);
    let frame = Frame::remote(Id::base(0x77F).unwrap(), 1).unwrap();
    rig.device.handle_frame(rig.now, &frame);
    assert_eq!(rig.drain().len(), 1);
}

/// Hears node 1 once, then never again.
fn hear(rig: &mut Rig) {
    rig.set(0x1016, 1, 0x0001_001E);
    rig.data(0x701, &[0x05]);
}

#[test]
fn dg_01_guarding_and_heartbeat_lead_to_al170_or_al180_and_1029h() {
    for supervise in [guard as fn(&mut Rig), hear] {
        for (behaviour, state) in
            [(0, NmtState::PreOperational), (1, NmtState::Operational), (2, NmtState::Stopped)]
        {
            for on in [false, true] {
                let mut rig = Rig::full();
                rig.set(0x1029, 1, behaviour);
                rig.start();
                if on {
                    rig.enable(Mode::ProfilePosition);
                }
                supervise(&mut rig);
                assert!(rig.pass(millis(29)).is_empty());
                let number = if on { "70" } else { "80" };
                let seen = rig.pass(millis(2));
                assert_eq!(
                    seen,
                    [(1000, format!("0FF#30 81 11 {number} 01 00 00 00"))],
                    "1029h:1 = {behaviour}"
                );
                assert_eq!(rig.device.node().state(), Some(state));
                assert_eq!(rig.servo().is_on(), on, "P3-10.Y = 0: the motor goes on (CN-224)");
            }
        }
    }
}

#[test]
fn digit_y_of_p3_10_switches_the_servo_off_when_the_master_is_lost() {
    let mut rig = Rig::full();
    rig.set(0x230A, 0, 0x10);
    rig.start();
    rig.enable(Mode::ProfilePosition);
    guard(&mut rig);
    rig.pass(millis(40));
    assert_eq!((rig.servo().state(), rig.servo().panel().to_string()), (State::Fault, "AL170".to_owned()));
    rig.control(0x80);
    assert_eq!(rig.servo().state(), State::SwitchOnDisabled);
}

#[test]
fn the_free_run_after_an_error_of_the_bus_can_be_coasting() {
    let quirks = Quirks { bus_error_coasts: true, ..Quirks::default() };
    let mut rig = Rig::with(Config::new(NODE), quirks);
    rig.start();
    rig.enable(Mode::ProfilePosition);
    guard(&mut rig);
    rig.pass(millis(40));
    assert_eq!(
        (rig.servo().state(), rig.servo().panel().to_string()),
        (State::SwitchOnDisabled, "AL170".to_owned()),
        "P3-10.Y = 0 (CN-224)"
    );
}

#[test]
fn cn_205_error_passive_is_al185_and_bus_off_al186() {
    let mut rig = Rig::full();
    rig.device.handle_error_state(rig.now, ErrorState::Active, ErrorState::Passive);
    assert_eq!(rig.drain(), ["0FF#20 81 11 85 01 00 00 00"]);
    assert!(rig.device.statusword().has(Statusword::WARNING));
    rig.device.handle_error_state(rig.now, ErrorState::Passive, ErrorState::Active);
    assert_eq!(rig.drain(), ["0FF#00 00 00 00 00 00 00 00"]);
    rig.device.handle_error_state(rig.now, ErrorState::Active, ErrorState::BusOff);
    rig.device.handle_error_state(rig.now, ErrorState::BusOff, ErrorState::Active);
    assert_eq!(rig.drain(), ["0FF#00 81 11 86 01 00 00 00"]);
    assert_eq!(rig.servo().alarms(), [Alarm::BusOff], "until a reset");
    rig.control(0x80);
    assert!(rig.servo().alarms().is_empty());
}

#[test]
fn a_limit_switch_that_is_pressed_stops_the_way_to_it() {
    let mut rig = Rig::full();
    rig.start();
    rig.enable(Mode::ProfileVelocity);
    rig.set(0x60FF, 0, 1000);
    rig.pass(millis(500));
    assert!(rig.signed(0x606C) > 900);
    let pressed = Closed { positive_limit: true, ..Closed::default() };
    let inputs = Inputs { pressed, ..*rig.device.inputs() };
    rig.device.set_inputs(rig.now, inputs);
    rig.pass(millis(500));
    assert_eq!((rig.signed(0x606C), rig.read(0x60FD, 0)), (0, Ok(2)));
    assert_eq!(rig.servo().alarms(), [Alarm::ForwardLimit]);
    rig.set(0x60FF, 0, -1000);
    rig.pass(millis(500));
    assert!(rig.signed(0x606C) < -900, "away from it");
    rig.device.set_inputs(rig.now, Inputs::NOMINAL);
    rig.pass(millis(2));
    assert!(rig.servo().alarms().is_empty());
}

#[test]
fn a_foreign_frame_is_no_overrun() {
    let quirks = Quirks { overrun_alarms: true, ..Quirks::default() };
    let mut rig = Rig::with(Config::new(NODE), quirks);
    rig.start();
    for _ in 0..3 {
        // A TPDO of node 1.
        rig.data(0x181, &[]);
    }
    assert!(rig.servo().alarms().is_empty());
}

#[test]
fn every_alarm_is_said_with_its_code_and_its_number() {
    for &alarm in Alarm::ALL {
        let mut rig = Rig::full();
        rig.device.provoke(rig.now, alarm);
        let [low, high] = alarm.code().to_le_bytes();
        let [number, number_high] = alarm.number().to_le_bytes();
        let register = alarm.register() | 1;
        let expected =
            format!("0FF#{low:02X} {high:02X} {register:02X} {number:02X} {number_high:02X} 00 00 00");
        assert_eq!(rig.drain(), [expected]);
        assert_eq!(rig.read(0x603F, 0), Ok(alarm.code().into()));
        assert_eq!(rig.read(0x1003, 1), Ok(u32::from(alarm.number()) << 16 | u32::from(alarm.code())));
        assert_eq!(rig.read(0x1001, 0), Ok(register.into()));
        assert_eq!(rig.servo().panel().to_string(), alarm.to_string());
        let by_bus = matches!(alarm.number(), 0x170 | 0x180 | 0x186);
        let is_fault = alarm.effect() == Effect::Fault && !by_bus;
        assert_eq!(rig.status() & 0x88, if is_fault { 0x08 } else { 0x80 }, "{alarm}");
    }
}

#[test]
fn rpdos_that_cannot_be_taken_are_al123_and_al124() {
    let mut rig = Rig::full();
    rig.set(0x1400, 1, 0x8000_027F);
    rig.set(0x1600, 1, 0x6060_0008);
    rig.set(0x1600, 0, 1);
    rig.set(0x1400, 2, 255);
    rig.set(0x1400, 1, 0x27F);
    rig.start();
    rig.data(0x27F, &[2]);
    assert_eq!(rig.servo().panel().to_string(), "AL124", "mode 2 by PDO");
    rig.control(0x80);
    rig.data(0x27F, &[]);
    assert_eq!(rig.servo().panel().to_string(), "AL123");
}

#[test]
fn overruns_are_alarms_where_they_are_wanted() {
    for wanted in [false, true] {
        let quirks = Quirks { overrun_alarms: wanted, ..Quirks::default() };
        let mut rig = Rig::with(Config::new(NODE), quirks);
        rig.read(0x1000, 0).unwrap();
        rig.pass(millis(1));
        rig.read(0x1000, 0).unwrap();
        assert!(rig.servo().alarms().is_empty());
        rig.read(0x1000, 0).unwrap();
        assert_eq!(rig.servo().alarms(), if wanted { &[Alarm::SdoOverrun][..] } else { &[] });
    }
}

#[test]
fn two_pdos_of_one_identifier_within_a_millisecond_are_al112() {
    let quirks = Quirks { overrun_alarms: true, ..Quirks::default() };
    let mut rig = Rig::with(Config::new(NODE), quirks);
    rig.start();
    rig.data(0x27F, &[]);
    rig.data(0x37F, &[]);
    assert!(rig.servo().alarms().is_empty());
    rig.data(0x27F, &[]);
    assert_eq!(rig.servo().alarms(), [Alarm::PdoOverrun]);
}

#[test]
fn the_history_keeps_five_and_0_clears_it() {
    let mut rig = Rig::full();
    for &alarm in &Alarm::ALL[..7] {
        rig.device.provoke(rig.now, alarm);
    }
    rig.drain();
    assert_eq!(rig.read(0x1003, 0), Ok(5));
    assert_eq!(rig.read(0x1003, 1), Ok(0x0007_8400));
    rig.set(0x1003, 0, 0);
    assert_eq!([rig.read(0x1003, 0), rig.read(0x1003, 1)], [Ok(0), Ok(0)]);
}

#[test]
fn whatever_frames_come_nothing_breaks() {
    let mut rig = Rig::full();
    let mut seed = 0x1234_5678_9ABC_DEF0_u64;
    for _ in 0..20_000 {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let octets = (seed >> 8).to_le_bytes();
        let id = [0x000, 0x080, 0x27F, 0x67F, 0x67F, 0x67F, 0x701, 0x77F][(seed >> 61) as usize];
        let len = (seed >> 56 & 0xF).min(8) as usize;
        let mut octets = octets;
        if id == 0x67F {
            octets[0] = [0x22, 0x23, 0x2B, 0x2F, 0x40][usize::from(octets[0]) % 5];
            octets[2] = [0x10, 0x14, 0x16, 0x20, 0x21, 0x60, 0x60, 0x60][usize::from(octets[2]) % 8];
        }
        rig.data(id, &octets[..len]);
        rig.pass(millis(seed >> 50 & 3));
    }
}
