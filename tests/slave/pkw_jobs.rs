//! The parameter channel from the bus: the worked telegrams of the manual (chapter 7.6) and the vectors of
//! `ag03.md` 2.5 and 2.6, octet for octet.

use std::time::Duration;

use profidrive::devices::StationEvent;
use profidrive::devices::ag03::drive::{Fault, Inputs};
use profidrive::devices::ag03::param::{Model, Parameter};
use profidrive::devices::ag03::profibus::{ApplicationCycle, Config, Device, Event, Timing};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::pkw;

use crate::drive_line::{Line, hex};

/// STW 000B and 003B with a PKW job before them.
const ENABLE: u16 = 0x000B;
const READY: u16 = 0x003B;

fn ppo(pkw: &str, stw: u16, hsw: i32) -> Vec<u8> {
    let mut octets = Vec::new();
    for word in pkw.split_whitespace() {
        octets.extend(u16::from_str_radix(word, 16).unwrap().to_be_bytes());
    }
    assert_eq!(octets.len(), 8, "{pkw}");
    octets.extend(stw.to_be_bytes());
    octets.extend(hsw.to_be_bytes());
    octets
}

fn pkw_text(inputs: &[u8; 14]) -> String {
    let words = inputs[..8].chunks(2).map(|word| format!("{:02X}{:02X}", word[0], word[1]));
    words.collect::<Vec<_>>().join(" ")
}

/// Holds a job until the reply to it is there, as masters do.
fn job(line: &mut Line, request: &str, stw: u16, hsw: i32) -> String {
    line.exchange(&ppo(request, stw, hsw));
    line.wait(Duration::from_millis(1));
    let inputs = line.exchange(&ppo(request, stw, hsw));
    // Job 0 in between, so that the next job is a new one even if it is the same.
    line.exchange(&ppo("0000 0000 0000 0000", stw, hsw));
    line.wait(Duration::from_millis(1));
    pkw_text(&inputs)
}

fn ready(model: Model) -> Line {
    let config = Config { model, timing: Timing::True, ..Config::new(Address::station(5).unwrap()) };
    let mut line = Line::with(config);
    line.start_up();
    line
}

#[test]
fn the_two_examples_of_the_manual_octet_for_octet() {
    let mut line = ready(Model::Ag03_1);
    assert_eq!(
        job(&mut line, "33FA 0000 0000 2710", 0, 0),
        "23FA 0000 0000 2710",
        "set what the example reads"
    );
    assert_eq!(job(&mut line, "13FA 0000 0000 0000", 0, 0), "23FA 0000 0000 2710", "7.6.1 read PNU 1018");
    assert_eq!(job(&mut line, "33F8 0000 0003 D090", 0, 0), "23F8 0000 0003 D090", "7.6.2 write PNU 1016");
    assert_eq!(line.device.parameters().value(Parameter::Limit1), 250_000);
}

#[test]
fn every_derived_vector_of_the_reference() {
    let mut line = ready(Model::Ag03_1);
    for (request, reply) in [
        ("13F9 0000 0000 0000", "23F9 0000 FFF0 BDC0"),
        ("33F9 0000 FF67 6981", "23F9 0000 FF67 6981"),
        ("33FB 0000 FFFF F9C0", "23FB 0000 FFFF F9C0"),
        ("23A2 0000 0000 0001", "13A2 0000 0000 0001"),
        ("23A2 0000 0000 0002", "13A2 0000 0000 0002"),
        ("23EB 0000 0000 0065", "73EB 0000 0000 0002"),
        ("33E8 0000 0000 0064", "73E8 0000 0000 0005"),
        ("2396 0000 0000 0005", "7396 0000 0000 0001"),
        ("1396 0000 0000 0000", "1396 0000 0000 0005"),
        ("13E7 0000 0000 0000", "73E7 0000 0000 0000"),
        ("93B1 0000 0000 0000", "63B1 0000 0000 000A"),
        ("13C1 0000 0000 0000", "13C1 0000 0000 0003"),
        ("13C5 0000 0000 0000", "13C5 0000 0000 0101"),
        ("1409 0000 0000 0000", "2409 0000 0012 D687"),
        ("140A 0000 0000 0000", "240A 0000 1507 2009"),
    ] {
        assert_eq!(job(&mut line, request, 0, 0), reply, "{request}");
    }
    for (model, reply) in [(Model::Ag03, "13CA 0000 0000 0000"), (Model::Ag03_1, "23CA 0000 0000 0000")] {
        assert_eq!(job(&mut ready(model), "23CA 0000 0000 0005", 0, 0), reply, "calibrate");
    }
}

#[test]
fn the_fault_buffer_is_read_element_by_element() {
    let mut line = ready(Model::Ag03_1);
    for _ in 0..4 {
        // Holding 1 Nm takes 500 mA, too much on a weak supply.
        let weak = Inputs { load_torque: 1.0, ..Inputs::default().provoking(Fault::A) };
        line.device.set_inputs(line.now, weak);
        line.exchange(&ppo("0000 0000 0000 0000", ENABLE, 0));
        line.wait(Duration::from_millis(4));
        line.device.set_inputs(line.now, Inputs::default());
        for stw in [0x0080, 0x0000] {
            line.exchange(&ppo("0000 0000 0000 0000", stw, 0));
            line.wait(Duration::from_millis(2));
        }
    }
    assert_eq!(job(&mut line, "63B1 0300 0000 0000", 0, 0), "43B1 0300 0000 0041");
    assert_eq!(job(&mut line, "63B1 0400 0000 0000", 0, 0), "43B1 0400 0000 0000");
    assert_eq!(job(&mut line, "13B8 0000 0000 0000", 0, 0), "13B8 0000 0000 0004");
    assert_eq!(job(&mut line, "23CA 0000 0000 0004", 0, 0), "23CA 0000 0000 0000");
    assert_eq!(job(&mut line, "63B1 0000 0000 0000", 0, 0), "43B1 0000 0000 0000");
    assert_eq!(job(&mut line, "13B8 0000 0000 0000", 0, 0), "13B8 0000 0000 0000");
}

#[test]
fn calibration_is_refused_while_travelling_and_the_reason_is_told() {
    let mut line = ready(Model::Ag03_1);
    for stw in [ENABLE, READY, 0x007B] {
        line.exchange(&ppo("0000 0000 0000 0000", stw, 5000));
        line.wait(Duration::from_millis(2));
    }
    assert_eq!(job(&mut line, "23CA 0000 0000 0005", 0x007B, 5000), "73CA 0000 0000 0011");
    assert_eq!(
        job(&mut line, "23F0 0000 0000 0014", 0x007B, 5000),
        "73F0 0000 0000 0011",
        "v-Inch while moving"
    );
    let refused = line.events.iter().filter_map(|event| match event {
        StationEvent::Device(Event::JobRefused(refusal)) => Some(refusal.number),
        _ => None,
    });
    assert_eq!(refused.collect::<Vec<_>>(), [pkw::ErrorNumber::OperatingState; 2]);
}

#[test]
fn calibration_sets_the_position() {
    let mut line = ready(Model::Ag03_1);
    assert_eq!(job(&mut line, "33FA 0000 0000 2710", 0, 0), "23FA 0000 0000 2710");
    assert_eq!(job(&mut line, "23CA 0000 0000 0005", 0, 0), "23CA 0000 0000 0000");
    assert_eq!(job(&mut line, "140C 0000 0000 0000", 0, 0), "240C 0000 0000 2710", "PNU 1036");
    let inputs = line.exchange(&[0; 14]);
    assert_eq!(inputs[10..], 10_000_i32.to_be_bytes(), "HIW");
}

#[test]
fn a_reply_never_comes_in_the_exchange_that_brought_its_job() {
    let mut line = Line::counting_exchanges();
    line.start_up();
    let read = ppo("13F8 0000 0000 0000", 0, 0);
    assert_eq!(pkw_text(&line.exchange(&read)), "0000 0000 0000 0000");
    assert_eq!(pkw_text(&line.exchange(&read)), "23F8 0000 000F 4240");
    assert_eq!(pkw_text(&line.exchange(&[0; 14])), "23F8 0000 000F 4240", "kept until the next job");
    assert_eq!(pkw_text(&line.exchange(&[0; 14])), "0000 0000 0000 0000", "job 0");
}

#[test]
fn a_latency_of_application_cycles_delays_the_reply() {
    for latency in [0, 1, 5] {
        let config = Config {
            timing: Timing::True,
            application_cycle: ApplicationCycle::EACH_EXCHANGE,
            pkw: pkw::Config { latency, ..pkw::Config::default() },
            ..Config::new(Address::station(5).unwrap())
        };
        let mut line = Line::with(config);
        line.start_up();
        let read = ppo("13F8 0000 0000 0000", 0, 0);
        let silent = (0..20).take_while(|_| pkw_text(&line.exchange(&read)) == "0000 0000 0000 0000").count();
        assert_eq!(silent, 1 + usize::from(latency));
    }
}

#[test]
fn a_held_write_is_carried_out_once() {
    let mut line = ready(Model::Ag03_1);
    assert_eq!(job(&mut line, "33F8 0000 0000 0064", 0, 0), "23F8 0000 0000 0064");
    let write = ppo("33F8 0000 0000 00C8", 0, 0);
    line.exchange(&write);
    line.wait(Duration::from_millis(2));
    assert_eq!(line.device.parameters().value(Parameter::Limit1), 200);
    // Another way changes the value; the held write must not change it back.
    let mut store = line.device.parameters().clone();
    store.set(Parameter::Limit1, 300).unwrap();
    for _ in 0..50 {
        line.exchange(&write);
        line.wait(Duration::from_millis(2));
    }
    assert_eq!(job(&mut line, "13F8 0000 0000 0000", 0, 0), "23F8 0000 0000 00C8");
}

#[test]
fn a_held_read_follows_the_value() {
    let mut line = ready(Model::Ag03_1);
    for stw in [ENABLE, READY] {
        line.exchange(&ppo("140C 0000 0000 0000", stw, 1600));
        line.wait(Duration::from_millis(2));
    }
    let travel = ppo("140C 0000 0000 0000", 0x007B, 1600);
    let mut last = 0;
    for _ in 0..100 {
        line.wait(Duration::from_millis(30));
        let inputs = line.exchange(&travel);
        let pwe = i32::from_be_bytes(inputs[4..8].try_into().unwrap());
        assert_eq!(inputs[4..8], inputs[10..14], "PNU 1036 and HIW agree");
        assert!(pwe >= last);
        last = pwe;
    }
    assert_eq!(last, 1600);
}

#[test]
fn jobs_of_no_meaning_are_refused_with_other_error() {
    let mut line = ready(Model::Ag03_1);
    for ak in 10..16 {
        let reply = job(&mut line, &format!("{ak:X}3E8 0000 0000 0000"), 0, 0);
        assert_eq!(reply, "73E8 0000 0000 0012", "job {ak}");
    }
}

#[test]
fn leaving_data_exchange_forgets_the_job() {
    let mut line = ready(Model::Ag03_1);
    let read = ppo("13F8 0000 0000 0000", 0, 0);
    line.exchange(&read);
    line.wait(Duration::from_millis(2));
    assert_eq!(pkw_text(&line.exchange(&read)), "23F8 0000 000F 4240");
    line.start_up();
    assert_eq!(pkw_text(&line.exchange(&read)), "0000 0000 0000 0000");
}

#[test]
fn the_examples_as_telegrams_on_the_wire() {
    let mut line = Line::counting_exchanges();
    for request in [
        "68 05 05 68 85 82 6D 3C 3E EE 16",
        "68 0C 0C 68 85 82 5D 3D 3E 80 01 01 0B 0A C5 00 3B 16",
        "68 07 07 68 85 82 7D 3E 3E F3 F2 E5 16",
    ] {
        assert!(line.send(&hex(request)).is_some(), "{request}");
    }
    let write = "68 11 11 68 05 02 5D 33 F8 00 00 00 03 D0 90 00 00 00 00 00 00 F2 16";
    assert!(line.send(&hex(write)).is_some());
    assert_eq!(
        line.send(&hex("68 11 11 68 05 02 7D 33 F8 00 00 00 03 D0 90 00 00 00 00 00 00 12 16")),
        Some(hex("68 11 11 68 02 05 08 23 F8 00 00 00 03 D0 90 2B 23 00 00 00 00 DB 16"))
    );
}

#[test]
fn a_device_can_be_cloned_to_try_something() {
    let line = ready(Model::Ag03_1);
    let copy: Device = line.device.clone();
    assert_eq!(copy.dp_state(), line.device.dp_state());
}
