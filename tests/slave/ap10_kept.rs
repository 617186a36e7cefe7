//! What an AP10 keeps and forgets, its faults, Auto-ID and calibration (`canopen-ap10.md` 7, 8, 11, 12 and 18).

use profidrive::can_bus::can::ErrorState;
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::{NmtState, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ap10::canopen::{Ap10, Config, Quirks};
use profidrive::devices::ap10::{Fault, Key, Light, Turns};

use crate::ap10_node::Rig;

const RANGE: u32 = 0x0609_0030;

/// One entry of each group: index, another value, its default, octets, group of 1010h.
const ENTRIES: [(u16, u32, u32, u8, u8); 3] =
    [(0x1017, 1000, 0, 2, 2), (0x6001, 720, 880, 4, 3), (0x5F10, 7, 5, 2, 4)];

fn change(rig: &mut Rig) {
    for (index, value, _, len, _) in ENTRIES {
        rig.write(index, 0, value, len).unwrap();
    }
}

#[test]
fn ps_01_what_is_not_saved_is_lost_with_reset_node_and_stays_with_reset_communication() {
    let mut rig = Rig::new(125);
    change(&mut rig);
    assert_eq!(rig.data(0x000, &[0x82, 125]), ["77D#00"]);
    for (index, value, default, ..) in ENTRIES {
        let expected = if index < 0x2000 { default } else { value };
        assert_eq!(rig.read(index, 0), Ok(expected), "{index:04X}h after 82h");
    }
    rig.steps(100);
    assert_eq!(rig.data(0x000, &[0x81, 125]), ["77D#00"]);
    for (index, _, default, ..) in ENTRIES {
        assert_eq!(rig.read(index, 0), Ok(default), "{index:04X}h after 81h");
    }
    assert_eq!(rig.position(), 100, "the battery keeps the count");
    rig.write(0x5F0A, 1, 9, 1).unwrap();
    assert_eq!(rig.data(0x000, &[0x82, 125]), ["709#00"], "the number is applied again");
    assert_eq!(rig.data(0x000, &[0x81, 9]), ["77D#00"]);
}

#[test]
fn ps_02_save_keeps_by_group() {
    for group in 1..=4 {
        for restart in [true, false] {
            let mut rig = Rig::new(125);
            change(&mut rig);
            rig.save(group);
            let seen = if restart { rig.data(0x000, &[0x81, 0]) } else { rig.power_cycle() };
            assert_eq!(seen, ["77D#00"]);
            for (index, value, default, _, own) in ENTRIES {
                let expected = if group == 1 || group == own { value } else { default };
                assert_eq!(rig.read(index, 0), Ok(expected), "{index:04X}h after save {group}");
            }
        }
    }
    let mut rig = Rig::new(125);
    rig.write(0x5F1B, 2, 3, 1).unwrap();
    rig.write(0x5F0B, 0, 1, 1).unwrap();
    rig.save(4);
    rig.power_cycle();
    assert_eq!(rig.read(0x5F1B, 2), Ok(3), "CN-118");
    assert_eq!(rig.read(0x5F0B, 0), Ok(0), "row 2 is not kept");
    let mut rig = Rig::with(125, Quirks { keeps_mode: false, ..Quirks::DEFAULT });
    rig.write(0x5F1B, 2, 3, 1).unwrap();
    rig.save(4);
    rig.power_cycle();
    assert_eq!(rig.read(0x5F1B, 2), Ok(0), "CN-118 as printed");
}

#[test]
fn ps_03_load_brings_factory_values_once() {
    for group in 1..=4 {
        let mut rig = Rig::new(125);
        change(&mut rig);
        rig.save(1);
        rig.load(group);
        for (index, value, ..) in ENTRIES {
            assert_eq!(rig.read(index, 0), Ok(value), "not before the restart");
        }
        rig.data(0x000, &[0x81, 0]);
        for (index, value, default, _, own) in ENTRIES {
            let expected = if group == 1 || group == own { default } else { value };
            assert_eq!(rig.read(index, 0), Ok(expected), "{index:04X}h after load {group}");
        }
        rig.data(0x000, &[0x81, 0]);
        for (index, value, ..) in ENTRIES {
            assert_eq!(rig.read(index, 0), Ok(value), "the EEPROM had it all the time (CN-110)");
        }
        rig.load(group);
        rig.power_cycle();
        rig.save(1);
        rig.power_cycle();
        for (index, value, default, _, own) in ENTRIES {
            let expected = if group == 1 || group == own { default } else { value };
            assert_eq!(rig.read(index, 0), Ok(expected), "{index:04X}h after load {group} and save");
        }
    }
}

#[test]
fn ps_03_bus_parameters_are_a_group_of_their_own() {
    let mut rig = Rig::new(5);
    rig.write(0x5F09, 1, 100, 2).unwrap();
    rig.write(0x5F10, 0, 7, 2).unwrap();
    rig.save(1);
    rig.load(4);
    assert_eq!(rig.data(0x000, &[0x81, 0]), ["705#00"], "011102: all but bus");
    assert_eq!((rig.read(0x5F09, 1), rig.read(0x5F10, 0)), (Ok(100), Ok(5)));
    rig.load(2);
    assert_eq!(rig.data(0x000, &[0x81, 0]), ["77D#00"], "5F0Ah is a bus parameter (manual table 9)");
    assert_eq!((rig.read(0x5F09, 1), rig.read(0x5F10, 0)), (Ok(0), Ok(7)));
}

#[test]
fn ps_04_a_wrong_signature_does_nothing() {
    let mut rig = Rig::new(125);
    change(&mut rig);
    for sub in 1..=4 {
        assert_eq!(rig.write(0x1010, sub, 0x6461_6F6C, 4), Err(0x0800_0020));
        assert_eq!(rig.write(0x1011, sub, 0x6576_6173, 4), Err(0x0800_0020));
        assert_eq!((rig.read(0x1010, sub), rig.read(0x1011, sub)), (Ok(1), Ok(1)));
    }
    rig.data(0x000, &[0x81, 0]);
    assert_eq!(rig.read(0x5F10, 0), Ok(5));
}

/// The host takes the newest image.
fn host_keeps(rig: &mut Rig) -> Vec<u8> {
    let mut octets = [0; 2048];
    let request = rig.device.poll_image(&mut octets).unwrap().unwrap();
    let (generation, image) = (request.generation, request.octets.to_vec());
    rig.device.handle_stored(rig.now, generation, Ok(()));
    image
}

#[test]
fn auto_id_is_answered_when_the_host_keeps_the_number() {
    let mut rig = Rig::hosted(125);
    rig.data(0x67D, &[0x2F, 0x0A, 0x5F, 0x02, 5, 0, 0, 0]);
    assert!(rig.tap(Key::Left).is_empty());
    host_keeps(&mut rig);
    assert_eq!(rig.drain(), ["5FD#60 0A 5F 02 00 00 00 00"]);
    assert_eq!(rig.pass(1000), [(100, "705#00".to_owned())]);
}

#[test]
fn an_image_of_the_host_brings_everything_back() {
    let mut rig = Rig::hosted(125);
    rig.write(0x6003, 0, 510, 4).unwrap();
    rig.turns(2.0);
    assert!(rig.data(0x67D, &[0x2F, 0x02, 0x20, 0, 1, 0, 0, 0]).is_empty(), "waits for the host");
    host_keeps(&mut rig);
    assert_eq!(rig.drain(), ["5FD#60 02 20 00 00 00 00 00"]);
    rig.device.provoke(rig.now, Fault::Speed);
    rig.drain();
    assert!(rig.data(0x67D, &[0x23, 0x10, 0x10, 1, 0x73, 0x61, 0x76, 0x65]).is_empty(), "save waits, too");
    let image = host_keeps(&mut rig);
    assert_eq!(rig.drain(), ["5FD#60 10 10 01 00 00 00 00"]);
    let config = Config { memory: Eeprom::Host, ..Config::new(NodeId::new(7).unwrap()) };
    let mut other = Ap10::new(config);
    other.recall(rig.now, &image).unwrap();
    rig.device = other;
    assert_eq!(rig.power_on(), ["77D#00"], "the number of the image");
    assert_eq!(rig.position(), 510, "with the shaft where it was");
    assert_eq!(rig.read(0x2002, 0), Ok(2));
    assert_eq!(rig.read(0x1003, 1), Ok(0x0081_FF12), "the history is kept (CN-134)");
    for len in 0..image.len() {
        assert!(Ap10::new(config).recall(rig.now, &image[..len]).is_err());
    }
}

/// The device that begins with this image, switched on.
fn recalled(image: &[u8]) -> Rig {
    let mut rig = Rig::hosted(125);
    let config = Config { memory: Eeprom::Host, ..Config::new(NodeId::new(125).unwrap()) };
    rig.device = Ap10::new(config);
    rig.device.recall(rig.now, image).unwrap();
    assert_eq!(rig.power_on(), ["77D#00"]);
    rig
}

#[test]
fn the_encoder_and_the_battery_are_in_the_image_of_the_host() {
    let mut rig = Rig::hosted(125);
    rig.turns(-3.25);
    rig.device.provoke(rig.now, Fault::BatteryEmpty);
    let image = host_keeps(&mut rig);
    let mut other = recalled(&image);
    assert_eq!(other.position(), -2860);
    assert_eq!(other.display().battery, Light::Steady);
    assert_eq!((other.read(0x6503, 0), other.read(0x1001, 0)), (Ok(0x3001), Ok(0x81)));
    other.device.make_nominal(other.now);
    other.drain();
    let image = host_keeps(&mut other);
    let mut third = recalled(&image);
    assert_eq!(third.display().battery, Light::Steady, "until somebody acknowledges");
    third.tap(Key::Up);
    assert_eq!((third.display().battery, third.read(0x1001, 0)), (Light::Off, Ok(0)));
    let image = host_keeps(&mut third);
    assert_eq!(recalled(&image).display().battery, Light::Off);
    // The shaft turns without supply, too.
    third.device.power_off(third.now);
    third.device.turn_to(third.now, Turns::from_revolutions(1.0));
    let image = host_keeps(&mut third);
    assert_eq!(recalled(&image).position(), 880);
}

#[test]
fn a_load_that_waits_for_the_restart_is_in_the_image_of_the_host_and_acts_once() {
    for group in 1..=4 {
        let mut rig = Rig::hosted(125);
        change(&mut rig);
        for (index, at) in [(0x1010_u16, 1), (0x1011, group)] {
            let [low, high] = index.to_le_bytes();
            let [a, b, c, d] = if index == 0x1010 { *b"save" } else { *b"load" };
            rig.data(0x67D, &[0x23, low, high, at, a, b, c, d]);
            let image = host_keeps(&mut rig);
            assert_eq!(rig.drain().len(), 1, "answered when it is kept");
            if index == 0x1010 {
                continue;
            }
            let mut other = recalled(&image);
            for (index, value, default, _, own) in ENTRIES {
                let expected = if group == 1 || group == own { default } else { value };
                assert_eq!(other.read(index, 0), Ok(expected), "{index:04X}h after load {group} and a kill");
            }
            let image = host_keeps(&mut other);
            let mut third = recalled(&image);
            for (index, value, ..) in ENTRIES {
                assert_eq!(third.read(index, 0), Ok(value), "{index:04X}h: once, load {group} (CN-110)");
            }
        }
    }
}

#[test]
fn pe_01_battery_and_speed() {
    let mut rig = Rig::new(125);
    rig.write(0x1801, 2, 1, 1).unwrap();
    rig.start();
    let provoke = |rig: &mut Rig, fault| {
        rig.device.provoke(rig.now, fault);
        rig.drain()
    };
    let state = |rig: &mut Rig| {
        let [status, alarms, warnings, register] =
            [0x5F19, 0x6503, 0x6505, 0x1001].map(|index| rig.read(index, 0).unwrap());
        [status, alarms, warnings, register]
    };
    assert_eq!(provoke(&mut rig, Fault::BatteryCritical), ["0FD#20 FF 81 00 00 00 00 00"]);
    assert!(provoke(&mut rig, Fault::BatteryCritical).is_empty(), "once per event");
    assert_eq!(state(&mut rig), [0x0800, 0x1000, 0x0010, 0x81]);
    assert_eq!(rig.display().battery, Light::Blinking);
    assert_eq!(provoke(&mut rig, Fault::BatteryEmpty), ["0FD#00 32 81 00 00 00 00 00"]);
    assert_eq!(state(&mut rig), [0x0880, 0x3001, 0x0010, 0x81]);
    assert_eq!(rig.display().battery, Light::Steady);
    assert_eq!(provoke(&mut rig, Fault::Speed), ["0FD#12 FF 81 00 00 00 00 00"]);
    assert_eq!(state(&mut rig), [0x1880, 0x3001, 0x0010, 0x81]);
    assert_eq!(rig.rows(), ["SPEED", "---"]);
    assert_eq!(rig.data(0x080, &[]), ["2FD#00 00 00 00 00 00 80 18"]);
    // The history: the newest first, with the error register (CN-113).
    for (sub, entry) in [(1, 0x0081_FF12), (2, 0x0081_3200), (3, 0x0081_FF20)] {
        assert_eq!(rig.read(0x1003, sub), Ok(entry));
    }
    // A cause that is gone is said although another one lasts.
    rig.device.end_fault(rig.now, Fault::Speed);
    assert_eq!(rig.drain(), ["0FD#00 00 81 00 00 00 00 00"]);
    assert_eq!(state(&mut rig), [0x0880, 0x3001, 0x0010, 0x81]);
    assert_eq!(rig.rows(), ["SPEED", "---"], "until somebody acknowledges");
    rig.device.make_nominal(rig.now);
    assert_eq!(rig.drain(), ["0FD#00 00 00 00 00 00 00 00"]);
    assert_eq!(state(&mut rig), [0, 1, 0, 0], "the position may be wrong until it is acknowledged");
    assert_eq!(rig.display().battery, Light::Steady);
    rig.tap(Key::Up);
    assert_eq!(state(&mut rig), [0; 4]);
    assert_eq!((rig.rows(), rig.display().battery), (["0".to_owned(), "---".to_owned()], Light::Off));
    assert_eq!(rig.read(0x2002, 0), Ok(0), "that key press did not calibrate");
    assert_eq!(rig.read(0x1003, 0), Ok(3));
    rig.power_cycle();
    assert_eq!(rig.read(0x1003, 0), Ok(3), "kept (CN-134)");
    rig.write(0x1003, 0, 0, 1).unwrap();
    rig.power_cycle();
    assert_eq!(rig.read(0x1003, 0), Ok(0), "and cleared without save");
}

#[test]
fn pe_01_the_controller_has_codes_too_and_stopped_nodes_are_quiet() {
    let mut rig = Rig::new(125);
    rig.device.handle_error_state(rig.now, ErrorState::Active, ErrorState::Passive);
    assert_eq!(rig.drain(), ["0FD#20 81 11 00 00 00 00 00"]);
    rig.device.handle_error_state(rig.now, ErrorState::Passive, ErrorState::Active);
    assert_eq!(rig.drain(), ["0FD#00 00 00 00 00 00 00 00"]);
    rig.device.handle_error_state(rig.now, ErrorState::BusOff, ErrorState::Active);
    assert_eq!(rig.drain(), ["0FD#40 81 00 00 00 00 00 00"]);
    rig.data(0x000, &[0x02, 0]);
    rig.device.provoke(rig.now, Fault::Speed);
    assert!(rig.drain().is_empty());
    assert!(rig.data(0x000, &[0x80, 0]).is_empty(), "nor later");
    assert_eq!(rig.read(0x1003, 1), Ok(0x0081_FF12));
    for _ in 0..10 {
        rig.device.make_nominal(rig.now);
        rig.device.provoke(rig.now, Fault::Speed);
    }
    assert_eq!(rig.read(0x1003, 0), Ok(8));
}

#[test]
fn a_battery_that_is_empty_does_not_count_without_supply() {
    let mut rig = Rig::new(125);
    rig.steps(100);
    rig.device.power_off(rig.now);
    assert_eq!(rig.rows(), ["", ""]);
    rig.steps(150);
    rig.power_on();
    assert_eq!(rig.position(), 150);
    rig.device.provoke(rig.now, Fault::BatteryEmpty);
    rig.device.power_off(rig.now);
    rig.steps(900);
    rig.power_on();
    assert_eq!(rig.position(), 150);
}

#[test]
fn pa_01_auto_id_waits_for_the_key_and_an_illegal_number_ends_it() {
    let mut rig = Rig::new(125);
    let ask = |rig: &mut Rig, number| rig.data(0x67D, &[0x2F, 0x0A, 0x5F, 0x02, number, 0, 0, 0]);
    assert!(ask(&mut rig, 5).is_empty());
    assert_eq!(rig.rows(), ["New ID", ""]);
    assert!(rig.pass(600_000).is_empty(), "human time");
    assert!(rig.tap(Key::Up).is_empty() && rig.tap(Key::Star).is_empty(), "another key");
    for illegal in [0, 128, 255] {
        assert!(ask(&mut rig, 5).is_empty());
        assert_eq!(ask(&mut rig, illegal), ["5FD#80 0A 5F 02 30 00 09 06"]);
        assert_eq!(rig.rows(), ["0", "---"], "the function ends");
        assert!(rig.tap(Key::Left).is_empty());
        rig.tap(Key::Left);
    }
    assert!(ask(&mut rig, 5).is_empty());
    assert_eq!(rig.tap(Key::Left), ["5FD#60 0A 5F 02 00 00 00 00"], "with the old number");
    let seen: Vec<String> = rig.pass(1000).into_iter().map(|(_, frame)| frame).collect();
    assert_eq!(seen, ["705#00"], "initialised with the new one");
    assert_eq!((rig.read(0x5F0A, 1), rig.read(0x5F0A, 2)), (Ok(5), Ok(5)));
    assert_eq!(rig.power_cycle(), ["705#00"], "stored at once");
    // A reset of the other devices ends it, too.
    let mut rig = Rig::new(125);
    ask(&mut rig, 6);
    assert_eq!(rig.data(0x000, &[0x81, 0]), ["77D#00"]);
    assert!(rig.tap(Key::Left).is_empty());
    assert_eq!(rig.write(0x5F0A, 1, 128, 1), Err(RANGE));
}

#[test]
fn auto_baud_listens_first_if_that_is_wanted() {
    let quirks = Quirks { listens_first: true, ..Quirks::DEFAULT };
    let mut device = Ap10::new(Config { quirks, ..Config::new(NodeId::new(125).unwrap()) });
    let mut rig = Rig::new(125);
    device.power_on(rig.now);
    rig.device = device;
    assert!(rig.drain().is_empty());
    assert_eq!(rig.device.node().state(), None);
    assert_eq!(rig.data(0x080, &[]), ["77D#00"], "the first frame has the rate");
    assert_eq!(rig.device.node().state(), Some(NmtState::PreOperational));
    assert_eq!(rig.data(0x000, &[0x81, 0]), ["77D#00"], "the rate is known from now on");
    rig.write(0x5F0A, 3, 3, 1).unwrap();
    rig.save(1);
    assert_eq!(rig.power_cycle(), ["77D#00"], "a rate that is set is not searched for");
}

#[test]
fn pc_01_calibration_sets_the_position_to_preset_and_offset() {
    let mut rig = Rig::new(125);
    rig.write(0x6003, 0, 1000, 4).unwrap();
    rig.write(0x2001, 0, 0xFFF6, 2).unwrap();
    rig.turns(3.0);
    assert_eq!(rig.read(0x2002, 0), Ok(0));
    rig.write(0x2002, 0, 1, 1).unwrap();
    assert_eq!((rig.read(0x2002, 0), rig.position()), (Ok(2), 990));
    assert_eq!(rig.read(0x6509, 0), Ok(2640));
    rig.turns(4.0);
    assert_eq!(rig.position(), 1870);
    rig.write(0x6003, 0, 0, 4).unwrap();
    assert_eq!(rig.position(), 1870, "the preset is adopted by calibration only");
    rig.tap(Key::Up);
    assert_eq!(rig.position(), -10, "by key");
    rig.write(0x2003, 0, 0, 1).unwrap();
    rig.turns(5.0);
    rig.tap(Key::Up);
    assert_eq!(rig.position(), 870, "the key is locked");
    rig.write(0x6000, 0, 5, 2).unwrap();
    assert_eq!((rig.position(), rig.read(0x6500, 0)), (-890, Ok(5)));
    rig.write(0x6000, 0, 4, 2).unwrap();
    rig.write(0x5F13, 1, 1, 1).unwrap();
    assert_eq!((rig.position(), rig.rows()), (87, ["87".to_owned(), "---".to_owned()]));
    rig.write(0x5F13, 2, 1, 1).unwrap();
    assert_eq!((rig.position(), rig.rows()), (870, ["87".to_owned(), "---".to_owned()]));
    assert_eq!(rig.write(0x6000, 0, 6, 2), Err(RANGE));
    assert_eq!(rig.write(0x6000, 0, 0, 2), Err(RANGE), "scaling cannot be switched off (CN-121)");
}
