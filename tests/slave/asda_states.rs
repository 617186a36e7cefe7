//! States, faults and persistence of the ASDA-A2 (`canopen-asda-a2.md` 8, 10, 15).

use profidrive::can_bus::canopen::NmtState;
use profidrive::can_bus::cia402::{Mode, State};
use profidrive::devices::CanopenDevice;
use profidrive::devices::asda_a2::canopen::{AsdaA2, Quirks};
use profidrive::devices::asda_a2::{Alarm, Config, Inputs, Level};

use crate::asda_a2_node::{NODE, Rig, millis};

#[test]
fn ds_01_full_can_open_goes_state_by_state() {
    let mut rig = Rig::full();
    assert_eq!(rig.status(), 0x0050);
    rig.control(0x0F);
    assert_eq!(rig.servo().state(), State::SwitchOnDisabled, "0Fh alone");
    for (word, state, status) in [
        (0x06, State::ReadyToSwitchOn, 0x0031),
        (0x0F, State::ReadyToSwitchOn, 0x0031),
        (0x07, State::SwitchedOn, 0x0033),
        (0x0F, State::OperationEnabled, 0x0037),
        (0x07, State::OperationEnabled, 0x0037),
    ] {
        rig.control(word);
        assert_eq!((rig.servo().state(), rig.status()), (state, status), "{word:02X}h");
    }
    rig.pass(millis(2));
    assert_eq!(rig.servo().state(), State::SwitchedOn, "disable operation, after its ramp");
    for (word, state) in [
        (0x0F, State::OperationEnabled),
        (0x06, State::ReadyToSwitchOn),
        (0x07, State::SwitchedOn),
        (0x0F, State::OperationEnabled),
        (0x00, State::SwitchOnDisabled),
    ] {
        rig.control(word);
        assert_eq!(rig.servo().state(), state, "{word:02X}h");
    }
    rig.start();
    assert_eq!(rig.status(), 0x0250, "bit 9 in OPERATIONAL (CN-230)");
}

#[test]
fn ds_01_half_can_open_takes_0f_at_once() {
    let mut rig = Rig::new(Level::Half);
    rig.control(0x0F);
    assert_eq!(rig.servo().state(), State::OperationEnabled);
    rig.control(0x0F);
    assert_eq!(rig.servo().state(), State::OperationEnabled);
    rig.control(0x0B);
    assert_eq!(rig.servo().state(), State::OperationEnabled, "P3-12.X = 0: bit 3 alone");
    rig.control(0x06);
    assert_eq!(rig.servo().state(), State::ReadyToSwitchOn);
    rig.set(0x230C, 0, 0x001);
    rig.control(0x0F);
    rig.control(0x0B);
    assert_eq!(rig.servo().state(), State::QuickStopActive, "P3-12.X = 1: bit 2 is the quick stop (CN-206)");
}

#[test]
fn quick_stop_ramps_with_6085h_and_holds_until_disable_voltage() {
    let mut rig = Rig::full();
    rig.enable(Mode::ProfileVelocity);
    rig.set(0x6085, 0, 1000);
    rig.set(0x60FF, 0, 6000);
    rig.pass(millis(300));
    rig.control(0x0B);
    assert_eq!(rig.status() & 0x006F, 0x0007);
    assert_eq!(rig.signed(0x60FF), 0, "cleared by a quick stop");
    rig.pass(millis(100));
    let speed = rig.signed(0x606C);
    assert!((2900..=3100).contains(&speed), "{speed}: 300 of 600 rpm after 100 of 200 ms");
    rig.pass(millis(150));
    assert_eq!(rig.signed(0x606C), 0);
    assert_ne!(rig.status() & 0x0400, 0);
    rig.control(0x0F);
    assert_eq!(rig.servo().state(), State::QuickStopActive, "no transition 16 (CN-229)");
    rig.control(0x00);
    assert_eq!(rig.servo().state(), State::SwitchOnDisabled);
}

/// 2000 rpm, and then what ends the operation.
fn off_while_turning(ramp: u16, millis_of_ramp: i64, off: impl FnOnce(&mut Rig)) -> Rig {
    let mut rig = Rig::full();
    rig.enable(Mode::ProfileVelocity);
    rig.set(0x60FF, 0, 20_000);
    rig.pass(millis(500));
    rig.set(ramp, 0, millis_of_ramp);
    off(&mut rig);
    rig
}

#[test]
fn a_fault_brakes_the_shaft_before_the_servo_goes_off() {
    for (reaction, ramp, time) in [(2, 0x6085, 0), (1, 0x6084, 1), (2, 0x6085, 100)] {
        let mut rig = off_while_turning(ramp, time, |rig| {
            rig.set(0x605E, 0, reaction);
            rig.device.set_inputs(rig.now, Inputs { emergency_stop_released: false, ..Inputs::NOMINAL });
        });
        rig.pass(millis(250));
        assert_eq!(rig.status() & 0x4F, 0x08, "605Eh = {reaction}");
        assert_eq!(rig.signed(0x606C), 0, "605Eh = {reaction}");
    }
    let mut rig = off_while_turning(0x6085, 0, |rig| {
        rig.set(0x605E, 0, 0);
        rig.device.provoke(rig.now, Alarm::Encoder);
    });
    rig.pass(millis(250));
    assert_eq!(rig.status() & 0x4F, 0x08, "605Eh = 0");
    assert!(rig.signed(0x606C) > 10_000, "605Eh = 0: the motor coasts");
}

#[test]
fn disable_operation_brakes_the_shaft_before_the_servo_goes_off() {
    let mut rig = off_while_turning(0x6084, 1, |rig| rig.control(0x07));
    rig.pass(millis(250));
    assert_eq!((rig.servo().state(), rig.signed(0x606C)), (State::SwitchedOn, 0));
}

#[test]
fn a_shaft_that_a_load_turns_does_not_keep_the_servo_on() {
    let mut rig = off_while_turning(0x6085, 0, |rig| {
        rig.device.set_inputs(rig.now, Inputs { load_torque: 50.0, ..Inputs::NOMINAL });
        rig.device.provoke(rig.now, Alarm::Encoder);
    });
    rig.pass(millis(100));
    assert_eq!(rig.status() & 0x4F, 0x0F, "fault reaction active");
    rig.pass(millis(1000));
    assert_eq!(rig.status() & 0x4F, 0x08);
}

#[test]
fn digit_y_of_p3_12_lets_a_fault_reset_end_the_quick_stop() {
    let mut rig = Rig::full();
    rig.set(0x230C, 0, 0x010);
    rig.enable(Mode::ProfilePosition);
    rig.control(0x0B);
    rig.control(0x8B);
    assert_eq!(rig.servo().state(), State::SwitchOnDisabled);
}

#[test]
fn ds_02_a_fault_is_reported_and_reset() {
    let mut rig = Rig::full();
    rig.start();
    rig.enable(Mode::ProfilePosition);
    rig.device.provoke(rig.now, Alarm::Encoder);
    assert_eq!(rig.drain(), ["0FF#05 73 81 11 00 00 00 00".replace("81", "21")]);
    rig.pass(millis(2));
    assert_eq!(rig.status() & 0x4F, 0x08);
    assert_eq!(rig.read(0x603F, 0), Ok(0x7305));
    assert_eq!(rig.sdo([0x40, 0x03, 0x10, 1, 0, 0, 0, 0]), [0x43, 0x03, 0x10, 1, 0x05, 0x73, 0x11, 0x00]);
    assert_eq!(rig.servo().panel().to_string(), "AL011");
    rig.control(0x0F);
    assert_eq!(rig.status() & 0x4F, 0x08, "only a reset");
    let [a, b] = 0x6040_u16.to_le_bytes();
    rig.data(0x67F, &[0x2B, a, b, 0, 0x00, 0, 0, 0]);
    let seen = rig.data(0x67F, &[0x2B, a, b, 0, 0x80, 0, 0, 0]);
    assert!(seen.contains(&"0FF#00 00 00 00 00 00 00 00".to_owned()), "{seen:?}");
    assert_eq!(rig.servo().state(), State::SwitchOnDisabled);
    assert_eq!([rig.read(0x603F, 0), rig.read(0x1001, 0), rig.read(0x1003, 0)], [Ok(0), Ok(0), Ok(1)]);
    rig.enable(Mode::ProfilePosition);
}

#[test]
fn a_fault_with_a_cause_that_stays_is_not_reset() {
    let mut rig = Rig::full();
    rig.device.set_inputs(rig.now, Inputs { emergency_stop_released: false, ..Inputs::NOMINAL });
    rig.pass(millis(5));
    assert_eq!(rig.servo().panel().to_string(), "AL013");
    rig.control(0x80);
    rig.pass(millis(5));
    assert_eq!(rig.servo().state(), State::Fault);
    rig.device.set_inputs(rig.now, Inputs::NOMINAL);
    rig.control(0x00);
    rig.control(0x80);
    rig.pass(millis(5));
    assert_eq!(rig.servo().state(), State::SwitchOnDisabled);
}

#[test]
fn al201_is_cleared_by_p2_08_only() {
    for writes in [&[10][..], &[30, 28]] {
        let mut rig = Rig::full();
        rig.device.provoke(rig.now, Alarm::CanopenData);
        rig.control(0x80);
        assert_eq!(rig.servo().panel().to_string(), "AL201");
        rig.set(0x2208, 0, 28);
        assert_eq!(rig.servo().panel().to_string(), "AL201");
        for value in writes {
            rig.set(0x2208, 0, *value);
        }
        assert!(rig.servo().alarms().is_empty());
    }
}

#[test]
fn the_fault_reaction_of_605eh() {
    for (code, most, least) in [(0, 5, 0), (1, 110, 90), (2, 60, 40)] {
        let mut rig = Rig::full();
        rig.set(0x605E, 0, code);
        rig.set(0x6084, 0, 500);
        rig.set(0x6085, 0, 250);
        rig.enable(Mode::ProfileVelocity);
        rig.set(0x60FF, 0, 6000);
        rig.pass(millis(300));
        rig.device.provoke(rig.now, Alarm::Encoder);
        let begin = rig.now;
        rig.until(0x4F, 0x08, millis(200));
        let took = rig.now.saturating_since(begin);
        assert!(took <= millis(most) && took >= millis(least), "605Eh = {code}: {took:?}");
    }
}

#[test]
fn de_01_save_load_and_a_wrong_signature() {
    let mut rig = Rig::full();
    let restart = |rig: &mut Rig| assert_eq!(rig.nmt(0x81), ["77F#00"]);
    // Kept once stored, else lost.
    rig.set(0x6067, 0, 777);
    restart(&mut rig);
    assert_eq!(rig.read(0x6067, 0), Ok(100));
    rig.set(0x6067, 0, 777);
    rig.set(0x6083, 0, 555);
    rig.set(0x1017, 0, 50);
    rig.set(0x1010, 1, 0x6576_6173);
    restart(&mut rig);
    assert_eq!([rig.read(0x6067, 0), rig.read(0x1017, 0)], [Ok(777), Ok(50)]);
    assert_eq!(rig.read(0x6083, 0), Ok(200), "P3-12.Z = 0 reloads it");
    rig.set(0x230C, 0, 0x100);
    rig.set(0x6083, 0, 555);
    rig.set(0x1010, 1, 0x6576_6173);
    restart(&mut rig);
    assert_eq!(rig.read(0x6083, 0), Ok(555), "P3-12.Z = 1 keeps it");
    assert_eq!([rig.write(0x1010, 1, 0), rig.write(0x1011, 1, 0x6576_6173)], [Err(0x0800_0020); 2]);
    // Defaults come with the next start (CN-233); the drive stays on its network.
    rig.set(0x1011, 1, 0x6461_6F6C);
    assert_eq!(rig.read(0x6067, 0), Ok(777));
    restart(&mut rig);
    assert_eq!([rig.read(0x6067, 0), rig.read(0x6083, 0), rig.read(0x1017, 0)], [Ok(100), Ok(200), Ok(0)]);
    assert_eq!([rig.read(0x2300, 0), rig.read(0x2101, 0)], [Ok(0x7F), Ok(0x0C)]);
}

#[test]
fn dr_01_nmt_reset_and_stop_while_enabled_are_al401() {
    for command in [0x02, 0x81, 0x82] {
        let mut rig = Rig::full();
        rig.start();
        rig.enable(Mode::ProfilePosition);
        let seen = rig.nmt(command);
        rig.pass(millis(2));
        assert_eq!(rig.servo().panel().to_string(), "AL401", "{command:02X}h");
        assert!(!rig.servo().is_on());
        match command {
            0x02 => {
                assert!(seen.is_empty(), "no EMCY in STOPPED");
                assert_eq!(rig.device.node().state(), Some(NmtState::Stopped));
                rig.nmt(0x01);
                assert_eq!(rig.read(0x1003, 1), Ok(0x0401_8100));
            }
            _ => assert_eq!(seen, ["77F#00", "0FF#00 81 11 01 04 00 00 00"], "{command:02X}h"),
        }
        rig.nmt(0x81);
        assert!(rig.servo().alarms().is_empty(), "the next reset clears it");
    }
}

#[test]
fn an_image_brings_settings_back() {
    let mut rig = Rig::full();
    rig.set(0x230C, 0, 0x100);
    // Wider than P1-34, and no multiple of P1-47.
    let written = [(0x607C, -5), (0x6083, 100_000), (0x606D, 105), (0x605B, -1), (0x1017, 77)];
    for (index, value) in written {
        rig.set(index, 0, value);
    }
    rig.set(0x6067, 0, 9);
    rig.set(0x1010, 1, 0x6576_6173);
    rig.set(0x6067, 0, 10);
    let mut room = [0; 4000];
    let (node, app) = rig.device.parts();
    let len = node.image(app, &mut room).unwrap();

    let mut device = AsdaA2::new(Config::new(NODE), Quirks::default(), rig.now);
    let now = rig.now;
    device.recall(now, &room[..len]).unwrap();
    device.power_on(now);
    let mut rig = Rig { now, device };
    rig.drain();
    for (index, value) in written {
        let read = rig.read(index, 0).unwrap();
        let width = if index == 0x605B { 0xFFFF } else { u32::MAX };
        assert_eq!(read, value as u32 & width, "{index:04X}h");
    }
    assert_eq!(rig.read(0x6067, 0), Ok(9), "what was not stored is lost");
}

#[test]
fn power_off_ends_everything_without_an_alarm() {
    let mut rig = Rig::full();
    rig.enable(Mode::ProfileVelocity);
    rig.set(0x60FF, 0, 10_000);
    rig.pass(millis(300));
    rig.device.power_off(rig.now);
    assert!(rig.sdo_is_silent());
    rig.pass(millis(5000));
    rig.device.power_on(rig.now);
    assert_eq!(rig.drain(), ["77F#00"]);
    assert_eq!((rig.status(), rig.signed(0x606C)), (0x0050, 0));
}

#[test]
fn shutdown_lets_the_shaft_run_out_or_brakes_it_by_605bh() {
    let way = |code: i64| {
        let mut rig = Rig::full();
        rig.set(0x605B, 0, code);
        rig.enable(Mode::ProfileVelocity);
        rig.set(0x60FF, 0, 10_000);
        rig.pass(millis(300));
        let begin = rig.position();
        rig.control(0x06);
        rig.pass(millis(9000));
        assert_eq!(rig.signed(0x606C), 0);
        rig.position() - begin
    };
    let (free, braked) = (way(0), way(-1));
    assert!(free > 3 * braked && braked > 0, "{free} {braked}");
}
