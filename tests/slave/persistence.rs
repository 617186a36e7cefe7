//! What survives power-off and what does not, and when a write is acknowledged, at the bus.

use std::time::Duration;

use profidrive::devices::ag03::drive::{Fault, Inputs};
use profidrive::devices::ag03::param::{DefaultSet, Gear, Model, Parameter, parameters};
use profidrive::devices::ag03::profibus::dip::Terminator;
use profidrive::devices::ag03::profibus::{
    Config, Device, DipSwitches, Eeprom, ImageError, ImageOctets, NotStored, Power, StoreRequest, Timing,
};
use profidrive::devices::ag03::unit;
use profidrive::face::EventKind;
use profidrive::profibus::dp;
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::{Ind, JobId, Pke, Pkw, ReplyId};
use proptest::prelude::*;

use crate::drive_line;
use crate::drive_line::{Line, MASTER, Reply};

mod switches;

const MS: Duration = Duration::from_millis(1);
const ENABLE: u16 = 0x000B;
const READY: u16 = 0x003B;
const START: u16 = 0x007B;
const ACKNOWLEDGE: u16 = 0x0080;

fn config(eeprom: Eeprom) -> Config {
    Config { timing: Timing::True, eeprom, ..Config::new(Address::station(5).unwrap()) }
}

fn line(eeprom: Eeprom) -> Line {
    let mut line = Line::with(config(eeprom));
    line.start_up();
    line
}

/// A line with the drive that the image makes.
fn restored(config: Config, image: &[u8]) -> Line {
    let mut line = Line::with(config);
    line.device = Device::restore(config, image, line.now).unwrap();
    line
}

fn outputs(job: Pkw, stw: u16, hsw: i32) -> Vec<u8> {
    job.to_octets().into_iter().chain(stw.to_be_bytes()).chain(hsw.to_be_bytes()).collect()
}

/// Two exchanges with an application cycle between them: PKW reply, ZSW and HIW to these outputs.
fn exchange(line: &mut Line, job: Pkw, stw: u16, hsw: i32) -> (Pkw, u16, i32) {
    line.exchange(&outputs(job, stw, hsw));
    line.wait(MS);
    let inputs = line.exchange(&outputs(job, stw, hsw));
    let zsw = u16::from_be_bytes([inputs[8], inputs[9]]);
    let hiw = i32::from_be_bytes(inputs[10..].try_into().unwrap());
    (Pkw::from_octets(inputs[..8].try_into().unwrap()), zsw, hiw)
}

/// Job 0, and then the reply to a job.
fn job(line: &mut Line, request: Pkw) -> Pkw {
    assert_eq!(exchange(line, Pkw::ZERO, 0, 0).0, Pkw::ZERO);
    exchange(line, request, 0, 0).0
}

fn write_word(pnu: u16, value: u16) -> Pkw {
    Pkw::new(Pke::of_job(JobId::WriteWord, pnu), Ind::default(), value.into())
}

fn read(pnu: u16) -> Pkw {
    Pkw::new(Pke::of_job(JobId::Read, pnu), Ind::default(), 0)
}

fn is_word(pnu: u16, value: u16) -> Pkw {
    Pkw::new(Pke::of_reply(ReplyId::Word, pnu), Ind::default(), value.into())
}

fn is_double(pnu: u16, value: i32) -> Pkw {
    Pkw::new(Pke::of_reply(ReplyId::DoubleWord, pnu), Ind::default(), value.cast_unsigned())
}

fn error_18(pnu: u16) -> Pkw {
    Pkw::new(Pke::of_reply(ReplyId::NotExecutable, pnu), Ind::default(), 18)
}

fn newest_fault() -> Pkw {
    Pkw::new(Pke::of_job(JobId::ReadElement, 945), Ind::default(), 0)
}

/// Travels to a position and stands there.
fn travel(line: &mut Line, target: i32) {
    exchange(line, Pkw::ZERO, ENABLE, 0);
    exchange(line, Pkw::ZERO, READY, target);
    exchange(line, Pkw::ZERO, START, target);
    line.wait(Duration::from_secs(60));
    assert_eq!(exchange(line, Pkw::ZERO, START, target).2, target);
}

/// Fault F comes, and goes with its cause.
fn fail_internally(line: &mut Line) {
    let failing = Inputs::default().provoking(Fault::F);
    line.device.set_inputs(line.now, failing);
    line.wait(2 * MS);
    line.device.set_inputs(line.now, Inputs::default());
    line.wait(2 * MS);
}

fn power_cycle(line: &mut Line) {
    line.device.power_off(line.now);
    line.wait(MS);
    line.device.power_on(line.now);
    line.wait(MS);
}

/// The image the host is asked to keep.
fn request(line: &mut Line) -> StoreRequest {
    line.device.poll_image().expect("there is something to store")
}

fn stored(line: &mut Line, outcome: Result<(), NotStored>) -> ImageOctets {
    let StoreRequest { generation, octets } = request(line);
    line.device.handle_stored(line.now, generation, outcome);
    octets
}

#[test]
fn every_parameter_but_1035_survives_power_off_and_an_image() {
    for (model, gear) in Model::ALL.into_iter().flat_map(|model| Gear::ALL.map(|gear| (model, gear))) {
        let config = Config { model, gear, ..config(Eeprom::Internal) };
        let mut line = Line::with(config);
        line.start_up();
        let mut written = Vec::new();
        for parameter in Parameter::all() {
            let entry = parameter.entry();
            let range = line.device.parameters().range(parameter);
            // Not the default, and not velocity mode, which has another setpoint.
            let value = if range.low == parameter.setting().default { range.high } else { range.low };
            let value = if parameter == Parameter::OperatingMode { 2 } else { value };
            if !entry.models.contain(model) {
                continue;
            }
            let id = if range.high > 0xFFFF { JobId::WriteDoubleWord } else { JobId::WriteWord };
            let write = Pkw::new(Pke::of_job(id, entry.pnu.number()), Ind::default(), value.cast_unsigned());
            assert_eq!(job(&mut line, write).double_word(), value.cast_unsigned(), "{parameter}");
            written.push((parameter, if parameter == Parameter::OffsetInch2 { 100 } else { value }));
        }
        let image = line.device.image();
        power_cycle(&mut line);
        for line in [line, restored(config, &image)] {
            for (parameter, value) in &written {
                assert_eq!(line.device.parameters().value(*parameter), *value, "{model} {gear}: {parameter}");
            }
        }
    }
}

#[test]
fn a_drive_without_supply_is_silent_and_wakes_up_as_row_1_says() {
    let mut line = line(Eeprom::Internal);
    assert_eq!(job(&mut line, write_word(1035, 50)), is_word(1035, 50));
    assert_eq!(exchange(&mut line, Pkw::ZERO, ENABLE, 0).1 & 0x0004, 0x0004, "enabled");
    line.device.power_off(line.now);
    line.device.power_off(line.now);
    assert_eq!(line.device.power(), Power::Off);
    assert_eq!(line.request(MASTER, Some(60), &[]), Reply::Silence);
    line.wait(Duration::from_secs(1));
    assert_eq!(line.device.poll_timeout(), None, "nothing can change");

    line.device.power_on(line.now);
    assert_eq!(line.device.dp_state(), dp::State::WaitPrm);
    assert_eq!(
        line.request(MASTER, None, &outputs(Pkw::ZERO, ENABLE, 0)),
        drive_line::RS,
        "no Data_Exchange"
    );
    assert_eq!(line.diagnosis(MASTER), [0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5], "waits for parameters");
    line.start_up();
    let (reply, zsw, _) = exchange(&mut line, Pkw::ZERO, 0, 0);
    assert_eq!((reply, zsw & 0x0007), (Pkw::ZERO, 0x0003), "ready to run");
    assert_eq!(job(&mut line, read(1035)), is_word(1035, 100));
    let switched: Vec<_> = line
        .events
        .iter()
        .filter(|event| event.kind() == EventKind::Power)
        .map(ToString::to_string)
        .collect();
    assert_eq!(switched, ["switched off", "switched on at address 5, bus terminator off"]);
}

#[test]
fn the_supply_that_is_set_outlasts_the_switch_and_decides_only_while_that_is_closed() {
    let mut line = line(Eeprom::Internal);
    let set = |line: &mut Line, control_supply| {
        line.device.set_inputs(line.now, Inputs { control_supply, ..*line.device.inputs() });
    };
    let is = |line: &Line| (line.device.power(), line.device.inputs().control_supply);
    set(&mut line, 20.0);
    line.device.power_on(line.now);
    assert_eq!(is(&line), (Power::On, 20.0), "it was on");
    line.device.power_off(line.now);
    assert_eq!(is(&line), (Power::Off, 20.0));
    assert_eq!(line.device.drive().measured().control_supply, 0, "nothing of it reaches the drive");
    set(&mut line, 21.0);
    assert_eq!(is(&line), (Power::Off, 21.0), "the switch is open");
    line.device.power_on(line.now);
    assert_eq!(is(&line), (Power::On, 21.0));

    // With the switch closed the supply decides.
    set(&mut line, 0.0);
    assert_eq!(is(&line), (Power::Off, 0.0));
    set(&mut line, 22.0);
    assert_eq!(is(&line), (Power::On, 22.0));
    set(&mut line, 0.0);
    line.device.power_on(line.now);
    assert_eq!(is(&line), (Power::On, 24.0), "switched on without any supply it gets the usual one");
}

#[test]
fn a_factory_reset_does_not_change_the_address_that_its_switches_no_longer_say() {
    let mut line = line(Eeprom::Internal);
    let at = line.device.address();
    line.device.power_off(line.now);
    line.device.set_switches(DipSwitches::from_bits(0x81));
    line.device.power_on(line.now);
    assert_eq!((line.device.power(), line.device.address()), (Power::FactoryReset(DefaultSet::All), at));
    line.device.power_off(line.now);
    line.device.set_switches(Address::station(9).unwrap().into());
    line.device.power_on(line.now);
    assert_eq!(line.device.address().number(), 9);
}

#[test]
fn off_and_on_in_the_same_instant_restarts_the_drive_and_forgets_a_reply_not_sent() {
    let mut line = line(Eeprom::Internal);
    exchange(&mut line, Pkw::ZERO, ENABLE, 0);
    let octets = line.srd(MASTER, Some(60), &[]);
    line.wait(MS);
    line.device.handle_bytes(line.now, &octets[..3]);
    line.device.power_off(line.now);
    line.device.power_on(line.now);
    line.device.handle_bytes(line.now, &octets[3..]);
    // `wait` would find a reply.
    line.wait(10 * MS);
    assert_eq!((line.device.dp_state(), line.device.power()), (dp::State::WaitPrm, Power::On));
    assert!(!line.device.status().operation_enabled);
    line.start_up();
}

#[test]
fn in_mid_travel_the_shaft_runs_out_and_is_found_where_it_stopped() {
    let mut line = line(Eeprom::Internal);
    exchange(&mut line, Pkw::ZERO, ENABLE, 0);
    exchange(&mut line, Pkw::ZERO, READY, 100_000);
    exchange(&mut line, Pkw::ZERO, START, 100_000);
    line.wait(Duration::from_secs(2));
    let at_failure = line.device.status().position;
    line.device.power_off(line.now);
    line.wait(Duration::from_secs(20));
    let stopped = line.device.status().position;
    assert!(stopped > at_failure && !line.device.status().moving, "{at_failure} to {stopped}");
    line.device.power_on(line.now);
    line.start_up();
    let (_, zsw, position) = exchange(&mut line, Pkw::ZERO, 0, 0);
    assert_eq!((position, zsw & 0x0004), (stopped, 0));
    line.wait(Duration::from_secs(5));
    assert_eq!(line.device.status().position, stopped, "the job is forgotten");
}

#[test]
fn a_battery_keeps_the_shaft_and_the_eeprom_its_zero_point() {
    let mut line = line(Eeprom::Internal);
    travel(&mut line, 4321);
    job(&mut line, Pkw::new(Pke::of_job(JobId::WriteDoubleWord, 1018), Ind::default(), 1000));
    job(&mut line, write_word(970, 5));
    travel(&mut line, -250);
    let image = line.device.image();
    power_cycle(&mut line);
    for mut line in [line, restored(config(Eeprom::Internal), &image)] {
        line.start_up();
        assert_eq!(exchange(&mut line, Pkw::ZERO, 0, 0).2, -250);
        assert_eq!(job(&mut line, read(1036)), is_double(1036, -250));
        travel(&mut line, 1000);
    }
}

#[test]
fn fault_buffer_and_counter_survive_until_they_are_cleared() {
    let mut line = line(Eeprom::Internal);
    for _ in 0..2 {
        fail_internally(&mut line);
        exchange(&mut line, Pkw::ZERO, 0, 0);
        exchange(&mut line, Pkw::ZERO, ACKNOWLEDGE, 0);
        exchange(&mut line, Pkw::ZERO, 0, 0);
    }
    let image = line.device.image();
    power_cycle(&mut line);
    for mut line in [line, restored(config(Eeprom::Internal), &image)] {
        line.start_up();
        assert_eq!(job(&mut line, read(952)), is_word(952, 2));
        assert_eq!(job(&mut line, newest_fault()).word(), 0x46);
        job(&mut line, write_word(970, 4));
        power_cycle(&mut line);
        line.start_up();
        assert_eq!(job(&mut line, read(952)), is_word(952, 0));
        assert_eq!(job(&mut line, newest_fault()).word(), 0);
    }
}

#[test]
fn an_image_of_another_drive_is_refused() {
    let image = Line::with(config(Eeprom::Internal)).device.image();
    let other = Config { gear: Gear::Ratio24, ..config(Eeprom::Internal) };
    let error = Device::restore(other, &image, profidrive::time::Instant::ZERO).unwrap_err();
    let expected = (Model::Ag03_1, Gear::Ratio24);
    assert_eq!(error, ImageError::OtherDrive { expected, got: (Model::Ag03_1, Gear::Ratio48) });
}

#[test]
fn a_write_is_acknowledged_when_its_image_is_safe_and_not_before() {
    let mut line = line(Eeprom::Host);
    stored(&mut line, Ok(()));
    assert_eq!(job(&mut line, read(1004)), is_word(1004, 30));
    for _ in 0..10 {
        assert_eq!(exchange(&mut line, write_word(1004, 77), 0, 0).0, is_word(1004, 30), "the reply before");
    }
    assert_eq!(line.device.parameters().value(Parameter::VPos), 77, "but it acts already");
    let image = stored(&mut line, Ok(()));
    assert_eq!(line.device.poll_image(), None, "it was executed once");
    line.wait(MS);
    assert_eq!(exchange(&mut line, write_word(1004, 77), 0, 0).0, is_word(1004, 77));
    let line = restored(config(Eeprom::Host), &image);
    assert_eq!(line.device.parameters().value(Parameter::VPos), 77);
}

#[test]
fn what_the_eeprom_does_not_keep_is_acknowledged_at_once() {
    let mut line = line(Eeprom::Host);
    stored(&mut line, Ok(()));
    assert_eq!(job(&mut line, write_word(1035, 50)), is_word(1035, 50));
    assert_eq!(job(&mut line, write_word(1004, 30)), is_word(1004, 30), "as it was");
    assert_eq!(job(&mut line, write_word(1004, 101)).word(), 2);
    assert_eq!(line.device.poll_image(), None);

    let mut line = self::line(Eeprom::Internal);
    assert_eq!(job(&mut line, write_word(1004, 77)), is_word(1004, 77));
    assert_eq!(line.device.poll_image(), None);
}

#[test]
fn a_write_that_cannot_be_stored_is_refused_with_18_and_changes_nothing() {
    let mut line = line(Eeprom::Host);
    stored(&mut line, Ok(()));
    // So that each of the jobs below has something to change.
    travel(&mut line, 500);
    for write in [write_word(1000, 400), write_word(1009, 500)] {
        assert_eq!(job(&mut line, write), Pkw::ZERO);
        stored(&mut line, Ok(()));
    }
    fail_internally(&mut line);
    let before = stored(&mut line, Ok(()));
    let jobs = (1..=5).map(|command| (970, command)).chain([(1004, 77)]);
    for (pnu, value) in jobs {
        let request = write_word(pnu, value);
        assert_eq!(job(&mut line, request), Pkw::ZERO, "{request}");
        assert_ne!(line.device.image(), before, "{request}");
        stored(&mut line, Err(NotStored));
        line.wait(MS);
        assert_eq!(exchange(&mut line, request, 0, 0).0, error_18(pnu), "{request}");
        assert_eq!(line.device.image(), before, "{request}");
        assert_eq!(stored(&mut line, Ok(())), before, "{request}: offered as it was");
    }
    assert_eq!(
        line.events.last().unwrap().to_string(),
        "job 23EC 0000 0000 004D (write word, PNU 1004 v-Pos) refused with error 18, other error: the EEPROM did not \
         store it, so nothing was changed; write it again, and check the place where the images are kept"
    );
}

/// Every parameter as PKW shows it, of an array every element.
fn readable(line: &mut Line) -> Vec<(u16, u32)> {
    let mut values = Vec::new();
    for entry in parameters(Model::Ag03_1) {
        let number = entry.pnu.number();
        let read = |line: &mut Line, id, element: u8| {
            job(line, Pkw::new(Pke::of_job(id, number), Ind::in_high_octet(element), 0)).double_word()
        };
        match entry.elements {
            None => values.push((number, read(line, JobId::Read, 0))),
            Some(count) => {
                values.extend((0..count).map(|element| (number, read(line, JobId::ReadElement, element))));
            }
        }
    }
    values
}

#[test]
fn a_write_that_cannot_be_stored_changes_nothing_that_a_master_can_read() {
    let mut line = line(Eeprom::Host);
    stored(&mut line, Ok(()));
    travel(&mut line, 500);
    for write in [write_word(1000, 400), write_word(1009, 500)] {
        job(&mut line, write);
        stored(&mut line, Ok(()));
    }
    fail_internally(&mut line);
    stored(&mut line, Ok(()));
    // What the EEPROM does not keep.
    assert_eq!(job(&mut line, write_word(1035, 50)), is_word(1035, 50));
    exchange(&mut line, Pkw::ZERO, 0, 0);
    let before = readable(&mut line);
    let jobs = (1..=5).map(|command| (970, command)).chain([(1004, 77), (1018, 100)]);
    for (pnu, value) in jobs {
        let mut request = write_word(pnu, value);
        if pnu == 1018 {
            request = Pkw::new(Pke::of_job(JobId::WriteDoubleWord, pnu), Ind::default(), value.into());
        }
        job(&mut line, request);
        let image = stored(&mut line, Err(NotStored));
        assert_ne!(image, line.device.image(), "{request}");
        line.wait(MS);
        assert_eq!(exchange(&mut line, request, 0, 0).0, error_18(pnu), "{request}");
        assert_eq!(readable(&mut line), before, "{request}");
        stored(&mut line, Ok(()));
    }
    assert!(before.contains(&(1035, 50)));
}

#[test]
fn a_write_past_the_bus_stays_when_one_before_it_cannot_be_stored() {
    let mut line = line(Eeprom::Host);
    stored(&mut line, Ok(()));
    job(&mut line, write_word(1004, 77));
    for (number, value) in [(1003, 60), (1035, 70)] {
        let number = profidrive::devices::ag03::param::Pnu::new(number).unwrap();
        line.device
            .write_parameter(line.now, number, None, profidrive::devices::ag03::param::Value::Word(value))
            .unwrap();
    }
    stored(&mut line, Err(NotStored));
    let store = line.device.parameters();
    assert_eq!(
        [Parameter::VPos, Parameter::APos, Parameter::OffsetInch2].map(|of| store.value(of)),
        [30, 60, 70]
    );
}

#[test]
fn after_a_failure_the_same_write_is_tried_again_and_never_acknowledged_from_memory() {
    let mut line = line(Eeprom::Host);
    stored(&mut line, Ok(()));
    job(&mut line, write_word(1004, 77));
    stored(&mut line, Err(NotStored));
    stored(&mut line, Err(NotStored));
    assert_eq!(line.device.poll_image(), None, "the host is not flooded");
    // What is in memory is 30 again, and may not be what is in the file.
    line.wait(MS);
    exchange(&mut line, write_word(1004, 77), 0, 0);
    assert_eq!(job(&mut line, write_word(1004, 30)), Pkw::ZERO);
    stored(&mut line, Ok(()));
    line.wait(MS);
    assert_eq!(exchange(&mut line, write_word(1004, 30), 0, 0).0, is_word(1004, 30));
}

#[test]
fn a_value_whose_first_master_has_gone_is_not_acknowledged_to_the_next_before_it_is_safe() {
    let mut line = line(Eeprom::Host);
    stored(&mut line, Ok(()));
    job(&mut line, write_word(1004, 77));
    let StoreRequest { generation, .. } = request(&mut line);
    // A new Set_Prm ends the job, not the writing.
    line.start_up();
    assert_eq!(job(&mut line, write_word(1004, 77)), Pkw::ZERO);
    line.device.handle_stored(line.now, generation, Ok(()));
    line.wait(MS);
    assert_eq!(exchange(&mut line, write_word(1004, 77), 0, 0).0, is_word(1004, 77));
}

#[test]
fn faults_and_standstills_are_offered_without_a_job() {
    let mut line = line(Eeprom::Host);
    let fresh = stored(&mut line, Ok(()));
    exchange(&mut line, Pkw::ZERO, ENABLE, 0);
    exchange(&mut line, Pkw::ZERO, READY, 2000);
    exchange(&mut line, Pkw::ZERO, START, 2000);
    line.wait(Duration::from_secs(1));
    assert!(line.device.status().moving);
    assert_eq!(line.device.poll_image(), None, "not while it moves");
    line.wait(Duration::from_secs(10));
    let travelled = stored(&mut line, Err(NotStored));
    assert_ne!(travelled, fresh);
    assert_eq!(line.device.poll_image(), None, "not again by itself");
    fail_internally(&mut line);
    let image = request(&mut line).octets;
    let line = restored(config(Eeprom::Host), &image);
    assert_eq!(line.device.status().position, 2000);
}

/// What may happen to a drive with a host that keeps its images.
#[derive(Clone, Copy, Debug)]
enum Happening {
    Write(u16),
    Stored,
    NotStored,
    NewMaster,
    PowerCycle,
    /// The process is killed, and started with the image that was stored last.
    Killed,
}

fn happenings() -> impl Strategy<Value = Vec<Happening>> {
    let one = prop_oneof![
        4 => (1..=5u16).prop_map(Happening::Write),
        4 => Just(Happening::Stored),
        2 => Just(Happening::NotStored),
        1 => Just(Happening::NewMaster),
        1 => Just(Happening::PowerCycle),
        2 => Just(Happening::Killed),
    ];
    proptest::collection::vec(one, 1..40)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn an_acknowledged_value_is_in_the_image_stored_last_and_a_refused_one_is_not(all in happenings()) {
        let mut line = line(Eeprom::Host);
        let mut safe = stored(&mut line, Ok(()));
        let mut held = Pkw::ZERO;
        for happening in all {
            match happening {
                Happening::Write(value) if held == Pkw::ZERO => {
                    held = write_word(1004, value);
                    line.exchange(&outputs(held, 0, 0));
                }
                // The master waits for its reply.
                Happening::Write(_) => {}
                Happening::Stored => {
                    if let Some(StoreRequest { generation, octets }) = line.device.poll_image() {
                        safe = octets;
                        line.device.handle_stored(line.now, generation, Ok(()));
                    }
                }
                Happening::NotStored => {
                    if let Some(StoreRequest { generation, .. }) = line.device.poll_image() {
                        line.device.handle_stored(line.now, generation, Err(NotStored));
                    }
                }
                Happening::NewMaster => {
                    line.start_up();
                    held = Pkw::ZERO;
                }
                Happening::PowerCycle => {
                    power_cycle(&mut line);
                    line.start_up();
                    held = Pkw::ZERO;
                }
                Happening::Killed => {
                    line.device = Device::restore(config(Eeprom::Host), &safe, line.now).unwrap();
                    line.start_up();
                    held = Pkw::ZERO;
                }
            }
            let (reply, ..) = exchange(&mut line, held, 0, 0);
            let kept = Device::restore(config(Eeprom::Host), &safe, line.now).unwrap();
            let kept = kept.parameters().value(Parameter::VPos);
            if reply != Pkw::ZERO {
                let executed = reply == is_word(1004, held.word());
                prop_assert!(executed || reply == error_18(1004), "{}", reply);
                if executed {
                    prop_assert_eq!(kept, i32::from(held.word()));
                } else {
                    prop_assert_eq!(line.device.parameters().value(Parameter::VPos), kept);
                }
                prop_assert_eq!(exchange(&mut line, Pkw::ZERO, 0, 0).0, Pkw::ZERO);
                held = Pkw::ZERO;
            }
        }
    }
}
