//! The drive under a master's commands.

use proptest::prelude::*;

use super::*;

const CYCLE: Duration = Duration::from_millis(1);
const FAST: Settings =
    Settings { ramp_up: 1.0, ramp_down: 2.0, quick_stop: 0.5, load: 10.0, ..Settings::DEFAULT };

fn run(drive: &mut Drive, millis: u32, command: Command) {
    for _ in 0..millis {
        drive.step(CYCLE, Some(&command));
    }
}

/// In operation at this setpoint for so long.
fn running(settings: Settings, setpoint: i16, millis: u32) -> Drive {
    let mut drive = Drive::new(settings);
    run(&mut drive, 1, Command { on: false, ..Command::run(0) });
    run(&mut drive, millis, Command::run(setpoint));
    drive
}

#[test]
fn ramps_take_their_times() {
    // 1 s from 0 to 4000h, behind the cycle that switches on.
    let mut drive = running(FAST, 0x4000, 502);
    assert!((drive.status().actual - 0x2000).abs() < 40, "{}", drive.status().actual);
    run(&mut drive, 600, Command::run(0x4000));
    assert_eq!(drive.status().actual, 0x4000);
    // OFF1: 2 s.
    run(&mut drive, 1000, Command { on: false, ..Command::run(0x4000) });
    assert!((drive.status().actual - 0x2000).abs() < 40);
    assert_eq!(drive.status().state, State::SwitchingOff(Off::Off1));
    run(&mut drive, 1001, Command { on: false, ..Command::run(0x4000) });
    assert_eq!((drive.status().state, drive.status().actual), (State::ReadyToSwitchOn, 0));
    // OFF3: 0.5 s.
    let mut drive = running(FAST, -0x4000, 1100);
    assert_eq!(drive.status().actual, -0x4000);
    run(&mut drive, 250, Command { no_off3: false, ..Command::run(-0x4000) });
    assert!((drive.status().actual + 0x2000).abs() < 80, "{}", drive.status().actual);
    run(&mut drive, 252, Command { no_off3: false, ..Command::run(-0x4000) });
    assert_eq!((drive.status().state, drive.status().actual), (State::SwitchingOnInhibited, 0));
}

#[test]
fn the_ramp_generator_is_enabled_held_and_cut_off() {
    let mut drive = running(FAST, 0x4000, 502);
    let half = drive.status().actual;
    run(&mut drive, 300, Command { run_ramp: false, ..Command::run(0x4000) });
    assert_eq!(drive.status().actual, half);
    // No setpoint: 0.5 s at the ramp-down time 2 s are a quarter.
    run(&mut drive, 500, Command { enable_setpoint: false, ..Command::run(0x4000) });
    assert!((drive.status().actual - half / 2).abs() < 40);
    // No ramp generator: as fast as the torque allows.
    run(&mut drive, 100, Command { enable_ramp: false, ..Command::run(0x4000) });
    assert_eq!((drive.status().state, drive.status().actual), (State::Operation, 0));
}

#[test]
fn off2_and_a_fault_release_the_motor() {
    for fault in [false, true] {
        let mut drive = running(FAST, 0x4000, 1100);
        if fault {
            drive.raise(Fault::Raised(42));
        }
        run(&mut drive, 100, Command { no_off2: fault, ..Command::run(0x4000) });
        let actual = drive.status().actual;
        assert!(actual > 0 && actual < 0x4000, "{actual}");
        let expected = if fault { State::Fault } else { State::SwitchingOnInhibited };
        assert_eq!(drive.status().state, expected);
        assert_eq!(drive.quantity(Quantity::Current, 0), 0.0);
    }
}

#[test]
fn a_fault_is_acknowledged_by_an_edge_and_moves_in_the_buffer() {
    let mut drive = running(FAST, 0x4000, 100);
    drive.raise(Fault::Raised(42));
    run(&mut drive, 5, Command::run(0));
    assert_eq!((drive.status().state, drive.faults().number(1)), (State::Fault, Some(42)));
    run(&mut drive, 1, Command { acknowledge: true, ..Command::run(0) });
    assert_eq!((drive.faults().number(1), drive.faults().number(9)), (Some(0), Some(42)));
    // ON is still there: OFF1 must be given once.
    assert_eq!(drive.status().state, State::SwitchingOnInhibited);
    drive.raise(Fault::Raised(43));
    run(&mut drive, 5, Command { acknowledge: true, ..Command::run(0) });
    assert_eq!(drive.status().state, State::Fault, "a level acknowledges nothing");
}

#[test]
fn inching_begins_at_standstill_with_the_setpoint_locked() {
    let locked = Command { enable_ramp: false, run_ramp: false, enable_setpoint: false, ..Command::run(0) };
    let mut drive = running(FAST, 0, 10);
    run(&mut drive, 500, Command { inching_1: true, ..locked });
    assert_eq!(drive.status().actual, 0x4000 / 10, "150 of 1500 rpm");
    run(&mut drive, 500, locked);
    assert_eq!(drive.status().actual, 0);
    run(&mut drive, 500, Command { inching_2: true, ..locked });
    assert_eq!(drive.status().actual, -0x4000 / 10);
    run(&mut drive, 500, Command { inching_1: true, inching_2: true, ..locked });
    assert_eq!(drive.status().actual, 0);
    // From one to the other without release, on the ramp.
    run(&mut drive, 500, locked);
    run(&mut drive, 500, Command { inching_1: true, ..locked });
    run(&mut drive, 500, Command { inching_2: true, ..locked });
    assert_eq!(drive.status().actual, -0x4000 / 10);
    run(&mut drive, 500, locked);
    // With the setpoint released it is refused.
    while drive.poll_event().is_some() {}
    run(&mut drive, 500, Command { inching_1: true, ..Command::run(0) });
    assert_eq!((drive.status().actual, drive.poll_event()), (0, Some(Event::InchingRefused)));
}

#[test]
fn on_while_it_switches_off_is_told() {
    let mut drive = running(Settings { ramp_down: 10.0, ..FAST }, 0x4000, 2000);
    run(&mut drive, 10, Command { on: false, ..Command::run(0) });
    while drive.poll_event().is_some() {}
    run(&mut drive, 10, Command::run(0));
    assert_eq!(drive.poll_event(), Some(Event::OnWhileSwitchingOff));
    assert_eq!(
        (drive.status().state, drive.poll_event()),
        (State::SwitchingOff(Off::Off1), None),
        "told once"
    );
}

#[test]
fn a_master_that_goes_is_a_fault_only_while_switched_on() {
    let mut drive = Drive::new(FAST);
    drive.step(CYCLE, None);
    assert_eq!(drive.status().state, State::SwitchingOnInhibited);
    let mut drive = running(FAST, 0x1000, 10);
    drive.step(CYCLE, None);
    assert_eq!((drive.status().state, drive.faults().number(1)), (State::Fault, Some(1)));
    assert_eq!(drive.faults().count(), 1);
}

#[test]
fn too_much_load_is_a_warning_and_then_a_fault() {
    let mut drive = running(FAST, 0x4000, 1100);
    drive.set_quantity(Quantity::Load, 200.0).unwrap();
    run(&mut drive, 600, Command::run(0x4000));
    assert!(drive.status().warning && !drive.status().in_tolerance);
    assert_eq!(drive.warnings().number(0), Some(Warnings::OVERLOAD));
    run(&mut drive, 4500, Command::run(0x4000));
    assert_eq!((drive.status().state, drive.faults().number(1)), (State::Fault, Some(2)));
    assert_eq!(drive.status().actual, 0, "the load has stopped it");
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let mut drive = Drive::new(FAST);
    for (quantity, value) in [
        (Quantity::ReferenceSpeed, 0.0),
        (Quantity::RampUp, -1.0),
        (Quantity::Load, f64::NAN),
        (Quantity::FaultCount, 1.0),
        (Quantity::Fault, 65536.0),
    ] {
        assert_eq!(drive.set_quantity(quantity, value), Err(SetError::Value), "{quantity}");
    }
    assert_eq!(drive.set_quantity(Quantity::ActualSpeed, 1.0), Err(SetError::ReadOnly));
    assert_eq!(*drive.settings(), FAST);
}

fn command() -> impl Strategy<Value = Command> {
    (any::<u16>(), any::<i16>()).prop_map(|(bits, setpoint)| {
        let bit = |n: u8| bits >> n & 1 == 1;
        Command {
            on: bit(0),
            no_off2: bit(1) || bit(11),
            no_off3: bit(2) || bit(12),
            enable_operation: bit(3),
            enable_ramp: bit(4),
            run_ramp: bit(5),
            enable_setpoint: bit(6),
            acknowledge: bit(7),
            inching_1: bit(8),
            inching_2: bit(9),
            setpoint,
        }
    })
}

proptest! {
    #[test]
    fn whatever_is_commanded_the_speed_stays_within_its_limit(
        commands in proptest::collection::vec((command(), 1..50_u32), 1..40),
        load in 0.0..300.0,
        ramp in 0.0..2.0,
    ) {
        let mut drive = Drive::new(Settings { ramp_up: ramp, ramp_down: ramp, load, ..Settings::DEFAULT });
        for (command, millis) in commands {
            run(&mut drive, millis, command);
            let speed = drive.quantity(Quantity::ActualSpeed, 0);
            prop_assert!(speed.abs() <= drive.settings().max_speed * 1.01, "{speed}");
            if drive.is_at_rest() {
                let (before, motion) = (drive.status(), drive.motion);
                drive.step(CYCLE, Some(&command));
                prop_assert_eq!((before, motion), (drive.status(), drive.motion));
            }
        }
    }
}
