//! A unit as a bus would use it, with no bus in scope.

use core::time::Duration;

use super::*;
use crate::devices::ag03::drive::{Direction, Fault, Motor, Operation, State};
use crate::devices::ag03::param::{DefaultSet, Effect, ParamError, Parameter, Write};

const MILLISECOND: Duration = Duration::from_millis(1);
const RUN: Command = Command { operation: Operation::Run, ..Command::UNATTENDED };

fn unit(eeprom: Eeprom) -> Unit {
    Unit::new(Config { eeprom, ..Config::new(Model::Ag03_1, Gear::Ratio48) })
}

fn run(unit: &mut Unit, command: Command, steps: u32) {
    for _ in 0..steps {
        unit.step(MILLISECOND, &command);
    }
}

/// Lets the host keep the newest image, or fail to.
fn stored(unit: &mut Unit, outcome: Result<(), NotStored>) -> (ImageOctets, Outcome) {
    let StoreRequest { generation, octets } = unit.poll_image().expect("there is something to store");
    (octets, unit.handle_stored(generation, outcome))
}

fn events(unit: &mut Unit) -> Vec<Event> {
    core::iter::from_fn(|| unit.poll_event()).collect()
}

#[test]
fn it_is_enabled_travels_fails_and_recovers() {
    let mut unit = unit(Eeprom::Internal);
    run(&mut unit, Command::UNATTENDED, 3);
    assert!(unit.is_at_rest());
    run(&mut unit, RUN, 1);
    assert_eq!(unit.status().state, State::OperationEnabled(Motor::InControl));
    run(&mut unit, Command { travel: true, setpoint: 1600, ..RUN }, 1);
    assert_eq!((unit.status().state, unit.status().jobs), (State::TravelActive, 1));
    run(&mut unit, RUN, 2300);
    assert_eq!((unit.status().position, unit.status().target_reached), (1600, true));

    let _before_the_fault = events(&mut unit);
    let _ = unit.set_inputs(unit.inputs().provoking(Fault::D));
    run(&mut unit, RUN, 1);
    assert!(events(&mut unit).contains(&Event::Fault(Fault::D)));
    let _ = unit.set_inputs(Inputs::default());
    run(&mut unit, Command { acknowledge: true, ..RUN }, 3);
    assert_eq!(
        unit.status().state,
        State::OperationEnabled(Motor::InControl),
        "acknowledged, armed, enabled"
    );
    assert_eq!(unit.drive().faults().codes()[0], b'D');
}

#[test]
fn it_brakes_and_holds_brakes_and_releases_or_runs_out() {
    for (operation, motor, steps) in [
        (Operation::BrakeAndHold, Motor::InControl, 130),
        (Operation::BrakeAndRelease, Motor::Released, 130),
        (Operation::Release, Motor::Released, 510),
    ] {
        let mut unit = unit(Eeprom::Internal);
        let inching = Command { inch_2: Some(Direction::Negative), ..RUN };
        run(&mut unit, RUN, 1);
        run(&mut unit, inching, 1000);
        assert_eq!(unit.status().velocity, -30);
        let end = Command { operation, ..RUN };
        run(&mut unit, end, steps - 20);
        assert!(unit.status().moving, "{operation:?}");
        run(&mut unit, end, 25);
        assert_eq!((unit.status().moving, unit.status().motor), (false, motor), "{operation:?}");
    }
}

#[test]
fn a_refused_request_says_why_without_bits_of_a_bus() {
    let mut unit = unit(Eeprom::Internal);
    run(&mut unit, Command { travel: true, setpoint: 5, ..Command::UNATTENDED }, 1);
    let Some(Event::CommandRefused(refusal)) = unit.poll_event() else { panic!("not refused") };
    let text = std::string::ToString::to_string(&refusal);
    assert_eq!(text, "travel to 5 inc refused: operation is not asked for; operation is not enabled");
}

#[test]
fn a_write_says_what_it_did() {
    let mut unit = unit(Eeprom::Host);
    let _ = stored(&mut unit, Ok(()));
    let written = unit.write_safely(Write::Set(Parameter::VPos, 77)).unwrap();
    assert_eq!((written.effect, written.before, written.waits), (Effect::SettingsChanged, Some(30), true));
    let (_, outcome) = stored(&mut unit, Ok(()));
    assert_eq!(outcome, Outcome::Safe);
    let same = unit.write_safely(Write::Set(Parameter::VPos, 77)).unwrap();
    assert_eq!((same.effect, same.before, same.waits), (Effect::None, Some(77), false));
    let volatile = unit.write_safely(Write::Set(Parameter::OffsetInch2, 50)).unwrap();
    assert_eq!((volatile.effect, volatile.waits), (Effect::SettingsChanged, false));
    assert_eq!(unit.poll_image(), None);
    let refused = unit.write(Write::Set(Parameter::VPos, 101));
    assert_eq!(refused, Err(ParamError::OutOfRange { low: 1, high: 100, got: 101 }));
}

#[test]
fn what_cannot_be_stored_is_undone_and_nothing_else() {
    let mut unit = unit(Eeprom::Host);
    let _ = stored(&mut unit, Ok(()));
    let _ = unit.write_safely(Write::Set(Parameter::OffsetInch2, 50)).unwrap();
    let _ = unit.write_safely(Write::Set(Parameter::VPos, 77)).unwrap();
    let _ = unit.write(Write::Set(Parameter::APos, 60)).unwrap();
    assert_eq!(stored(&mut unit, Err(NotStored)).1, Outcome::Undone);
    let values = [Parameter::OffsetInch2, Parameter::VPos, Parameter::APos];
    assert_eq!(values.map(|parameter| unit.parameters().value(parameter)), [50, 30, 60]);

    let _ = unit.write_safely(Write::Load(DefaultSet::All)).unwrap();
    assert_eq!(stored(&mut unit, Err(NotStored)).1, Outcome::Undone);
    assert_eq!(values.map(|parameter| unit.parameters().value(parameter)), [50, 30, 60]);
    assert!(unit.write(Write::Calibrate).is_ok());
}

#[test]
fn it_is_switched_off_and_on_and_restored_from_its_image() {
    let mut unit = unit(Eeprom::Host);
    let _ = unit.write(Write::Set(Parameter::OffsetInch2, 50)).unwrap();
    run(&mut unit, RUN, 1);
    run(&mut unit, Command { travel: true, setpoint: 800, ..RUN }, 2000);
    assert_eq!(unit.power_off(), Switched::Off);
    assert_eq!((unit.power(), unit.status().state), (Power::Off, State::Off));
    assert_eq!(unit.power_off(), Switched::No);
    unit.set_switches(DipSwitches::from_bits(1).with_reset(true));
    assert_eq!(unit.power_on(), Switched::On);
    assert_eq!(unit.power(), Power::FactoryReset(DefaultSet::All));
    run(&mut unit, RUN, 1);
    assert_eq!(unit.status().state, State::Off, "in a factory reset nothing else works");
    unit.set_switches(DipSwitches::default());
    assert_eq!((unit.power_off(), unit.power_on()), (Switched::Off, Switched::On));
    assert_eq!((unit.power(), unit.status().position), (Power::On, 800));
    assert_eq!(unit.parameters().value(Parameter::OffsetInch2), 100);

    let (image, _) = stored(&mut unit, Ok(()));
    let again = Unit::restore(Config::new(Model::Ag03_1, Gear::Ratio48), &image).unwrap();
    assert_eq!((again.image(), again.status().position), (image, 800));
}

#[test]
fn a_bus_keeps_its_own_settings_in_the_eeprom() {
    let mut unit = unit(Eeprom::Host);
    let _ = stored(&mut unit, Ok(()));
    let kept = BusSettings::new(&[0x20, 5]).unwrap();
    assert!(unit.keep_bus_settings(kept), "waits");
    assert_eq!(stored(&mut unit, Err(NotStored)).1, Outcome::Undone);
    assert_eq!(*unit.bus_settings(), BusSettings::EMPTY);
    assert!(unit.keep_bus_settings(kept), "waits");
    let (image, outcome) = stored(&mut unit, Ok(()));
    assert_eq!(outcome, Outcome::Safe);
    let again = Unit::restore(Config::new(Model::Ag03_1, Gear::Ratio48), &image).unwrap();
    assert_eq!(again.bus_settings()[..], [0x20, 5]);
}
