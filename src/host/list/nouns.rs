//! Each noun that a device is asked for, walked over every device of the list: through the same traits, whatever it is.

use std::collections::BTreeSet;

use super::{DEVICES, Device, Ground, Group, Spec};
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::face::Description;
use crate::host::{Refusals, ValueBoard};
use crate::time::{BaudRate, Instant};

/// The nouns that each device has at least; of a node its parameters are objects.
const HAVE: &[(&str, Group, &str, &[&str])] = &[
    (
        "ag03-1",
        Group::Drive,
        "5",
        &["display", "faults", "inputs", "keys", "parameters", "reasons", "state", "values", "words"],
    ),
    (
        "ag03",
        Group::Drive,
        "5,model=ag03",
        &["display", "faults", "inputs", "keys", "parameters", "reasons", "state", "values", "words"],
    ),
    (
        "ppo-drive",
        Group::PpoDrive,
        "5",
        &["exchanged", "inputs", "parameters", "reasons", "state", "values", "words"],
    ),
    ("profidrive", Group::Profidrive, "5", &["parameters", "reasons", "state", "values", "words"]),
    ("gsd-station", Group::Station, "5,gsd=tests/gsd/modular.gsd", &["state"]),
    (
        "ag03-1",
        Group::Node,
        "5",
        &["display", "faults", "inputs", "keys", "parameters", "reasons", "state", "values", "words"],
    ),
    (
        "ap10",
        Group::Node,
        "5,device=ap10",
        &["display", "faults", "inputs", "keys", "parameters", "values", "words"],
    ),
    (
        "asda-a2",
        Group::Node,
        "5,device=asda-a2",
        &["display", "faults", "inputs", "parameters", "reasons", "state", "values", "words"],
    ),
    ("eds-node", Group::Node, "5,eds=tests/eds/pump.eds", &["parameters"]),
    ("eds-node", Group::Node, "5,eds=tests/eds/servo.dcf", &["faults", "parameters", "reasons", "state"]),
];

#[test]
fn every_noun_is_asked_of_every_device_in_the_same_way() {
    for device in DEVICES {
        let listed = HAVE.iter().any(|(name, group, ..)| (*name, *group) == (device.name(), device.group()));
        assert!(listed, "{} has no row", device.name());
    }
    let mut lacks = Vec::new();
    for (name, group, spec, have) in HAVE {
        let spec = Spec::parse(*group, spec).unwrap();
        assert_eq!(spec.device.name(), *name);
        let told = match spec.device {
            Device::Slave(_) => slave(&spec),
            Device::Node(_) | Device::NodeFile(_) => node(&spec),
        };
        let missing = have.iter().filter(|noun| !told.contains(*noun));
        lacks.extend(missing.map(|noun| format!("{name} lacks {noun}, it has {told:?}")));
    }
    assert!(lacks.is_empty(), "{lacks:#?}");
}

fn slave(spec: &Spec) -> BTreeSet<&'static str> {
    let ground = Ground {
        now: Instant::ZERO,
        rate: BaudRate::K500,
        state: None,
        refusals: &Refusals::default(),
        board: &ValueBoard::default(),
    };
    let mut station = spec.prepare().unwrap().make(&ground).unwrap();
    nouns(station.description_mut().unwrap(), Instant::ZERO)
}

fn node(spec: &Spec) -> BTreeSet<&'static str> {
    let product = spec.product().unwrap();
    let mut device = product.make(spec.node(), &spec.choices, Eeprom::Internal, Instant::ZERO);
    device.power_on(Instant::ZERO);
    let mut told = BTreeSet::new();
    device.act(Instant::ZERO, &mut |description| told = nouns(description, Instant::ZERO));
    if !product.objects(&spec.choices).is_empty() {
        told.insert("parameters");
    }
    told
}

/// What it tells something of. What is offered is also done: each fault is made and taken back, each key goes down and up,
/// each input takes its nominal value.
fn nouns(device: &mut dyn Description, now: Instant) -> BTreeSet<&'static str> {
    let mut told = BTreeSet::new();
    device.each_parameter(&mut |_| _ = told.insert("parameters"));
    device.each_value(&mut |_| _ = told.insert("values"));
    device.each_word(&mut |_| _ = told.insert("words"));
    device.each_exchange(&mut |_| _ = told.insert("exchanged"));
    device.say_state(&mut |_| _ = told.insert("state"));
    if !device.words().is_empty() {
        told.insert("words");
    }
    let seen = device.face(now);
    if !seen.rows.is_empty() || !seen.leds.is_empty() {
        told.insert("display");
    }
    if let Some(why) = device.why() {
        why.each_reason(&mut |reason| assert!(!reason.name.is_empty() && !reason.to_string().is_empty()));
        told.insert("reasons");
    }
    let mut inputs = Vec::new();
    device.each_input(&mut |input, _| inputs.push(input.name.to_string()));
    for name in inputs {
        if let Some(level) = device.nominal(&name) {
            device.set_input(now, &name, level);
        }
        told.insert("inputs");
    }
    let mut faults = Vec::new();
    device.each_fault(&mut |fault| faults.push(fault.name.to_string()));
    for name in faults {
        assert_eq!(device.provoke(now, &name), Ok(()), "{name}");
        assert_eq!(device.take_back(now, &name), Ok(()), "{name}");
        told.insert("faults");
    }
    let mut keys = Vec::new();
    device.each_key(&mut |key, _| keys.push(key));
    for key in keys {
        assert_eq!(device.press(now, key, true), Ok(()), "{key}");
        assert_eq!(device.press(now, key, false), Ok(()), "{key}");
        told.insert("keys");
    }
    told
}
