//! `profidrive try` with each device of its list: everything that its master offers is asked. A new device is tried without a
//! new line here; one that needs a file is tried with each of `FILES` for its option.

use std::collections::BTreeSet;
use std::time::Instant;

use serde_json::{Value, json};

use crate::bench::{MASTER, ask};
use crate::emulator::output;
use crate::panel::{Emulator, PATIENCE};

const STATION: &str = "/api/v1/stations/5";

/// Options that name a file: the part of the name of a device that takes it, and the files.
const FILES: [(&str, &[&str]); 2] = [
    ("gsd", &["tests/gsd/remote_io.gsd"]),
    (
        "eds",
        &["tests/eds/drive.eds", "tests/eds/two-axes.eds", "tests/eds/terminal.eds", "tests/eds/encoder.eds"],
    ),
];

/// What is asked, in this order, and the state of NMT that follows; what is not here fails the test.
const ACTS: [(&str, Option<&str>); 17] = [
    ("enable", None),
    ("move", None),
    ("jog_positive", None),
    ("jog_negative", None),
    ("velocity", None),
    ("speed", None),
    ("move", None),
    ("home", None),
    ("stop", None),
    ("enable", None),
    ("disable", None),
    ("acknowledge", None),
    ("nmt_start", Some("OPERATIONAL")),
    ("nmt_stop", Some("STOPPED")),
    ("nmt_pre_operational", Some("PRE-OPERATIONAL")),
    ("nmt_reset_node", Some("PRE-OPERATIONAL")),
    ("nmt_reset_communication", Some("PRE-OPERATIONAL")),
];

/// The names that the help lists.
fn names() -> Vec<String> {
    let help = String::from_utf8(output(&["try", "--help"]).stdout).unwrap();
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let (_, list) = help.split_once("The device: ").unwrap();
    let (list, _) = list.split_once(';').unwrap();
    list.split(", ").map(str::to_owned).collect()
}

/// What `try` is told for a device of this name.
fn specs(name: &str) -> Vec<String> {
    let files = FILES.iter().find(|(option, _)| name.contains(option));
    let Some((option, files)) = files else { return vec![name.to_owned()] };
    let root = env!("CARGO_MANIFEST_DIR");
    files.iter().map(|file| format!("{name},{option}={root}/{file}")).collect()
}

/// A number near zero within the bounds of an act.
fn number(act: &Value) -> Value {
    let quantity = &act["quantity"];
    if quantity.is_null() {
        return Value::Null;
    }
    let within =
        |number: f64| number.clamp(quantity["low"].as_f64().unwrap(), quantity["high"].as_f64().unwrap());
    json!(within(if act["act"] == "move" { 120.0 } else { 20.0 }))
}

/// Makes a fault that the drive goes to, and takes its cause away.
fn fail(emulator: &Emulator) {
    let faults = emulator.get(STATION)["faults"].clone();
    for fault in faults.as_array().into_iter().flatten() {
        emulator.set("POST", &format!("{STATION}/provoke"), &json!({ "fault": fault["fault"] }));
        let begun = Instant::now();
        let failed = loop {
            let failed = emulator.get(STATION)["state"] == "fault";
            if failed || begun.elapsed().as_millis() > 300 {
                break failed;
            }
        };
        emulator.set("DELETE", &format!("{STATION}/inputs"), &Value::Null);
        if failed {
            return;
        }
    }
}

/// Reads a value that can be written over the bus, and writes it as it is.
fn read_and_write(emulator: &Emulator) {
    let has = emulator.get(STATION)["has"].clone();
    let place = if has["objects"] == true {
        let objects = emulator.get(&format!("{STATION}/objects"))["objects"].clone();
        let rows = objects.as_array().unwrap().clone();
        let found = rows
            .iter()
            .find(|row| row["access"] == "rw" && row["value"].is_i64() && row["index"] != "1003")
            .cloned();
        found.map(|row| (format!("{}:{}", row["index"].as_str().unwrap(), row["sub"].as_str().unwrap()), row))
    } else if has["parameters"] == true {
        let rows = emulator.get(&format!("{STATION}/parameters"));
        let rows = rows.as_array().or(rows["parameters"].as_array()).unwrap().clone();
        let found = rows.iter().find(|row| {
            row["access"] == "read_write" && row["value"].is_number() && row["elements"].is_null()
        });
        found.cloned().map(|row| (row["key"].to_string().replace('"', ""), row))
    } else {
        None
    };
    let Some((place, row)) = place else { return };
    let (well, text) = ask(emulator, &json!({"act": "read", "place": place}));
    assert!(well, "read {place}: {text}");
    let value = row["value"].as_f64().unwrap();
    let (well, text) = ask(emulator, &json!({"act": "write", "place": place, "value": value}));
    assert!(well, "write {value} to {place}: {text}");
}

/// Everything that the master offers of the device.
fn operate(emulator: &Emulator) -> usize {
    let offered = emulator.get(MASTER);
    assert!(!offered["master"].is_null(), "{offered}");
    let acts = offered["acts"].as_array().unwrap().clone();
    for act in &acts {
        assert!(ACTS.iter().any(|(key, _)| act["act"] == *key), "nothing here asks {act}");
    }
    let mut asked = 0;
    for (key, nmt) in ACTS {
        let Some(act) = acts.iter().find(|act| act["act"] == key) else { continue };
        if key == "acknowledge" {
            fail(emulator);
        }
        let (well, text) = ask(emulator, &json!({"act": key, "value": number(act)}));
        // Method of homing and mode on PROFIBUS are for its owner to choose; the answer says how.
        let chosen =
            ["6098h says by which method", "write 1 to PNU 930 first"].iter().any(|way| text.contains(way));
        assert!(well || chosen, "{key}: {text}");
        asked += 1;
        if let Some(state) = nmt {
            emulator.wait_for(key, |now| now["bus_state"].as_str().is_some_and(|now| now.starts_with(state)));
        }
        if key == "acknowledge" {
            emulator.wait_for("no fault", |state| state["state"] != "fault");
        }
    }
    if offered["reads"] == true {
        read_and_write(emulator);
        asked += 1;
    }
    if let Some(outputs) = offered["outputs"].as_u64() {
        let octets = "5A".repeat(usize::try_from(outputs).unwrap());
        let (well, text) = ask(emulator, &json!({"act": "outputs", "octets_hex": octets}));
        assert!(well, "outputs: {text}");
        asked += 1;
    }
    asked
}

#[test]
fn each_device_of_the_list_is_operated_by_everything_that_its_master_offers() {
    let mut tried = BTreeSet::new();
    for spec in names().iter().flat_map(|name| specs(name)) {
        for canopen in [&[][..], &["--canopen"]] {
            let emulator = Emulator::trying(&[&[spec.as_str()], canopen].concat());
            let begun = Instant::now();
            while emulator.get(MASTER)["master"]["taken"] == false
                && begun.elapsed() < PATIENCE
                && emulator.get(STATION)["bus"] == "profibus"
            {}
            let bus = emulator.get(STATION)["bus"].as_str().unwrap().to_owned();
            if tried.insert((spec.clone(), bus.clone())) {
                let asked = operate(&emulator);
                assert!(asked > 0, "{spec} on {bus}: nothing can be asked");
                eprintln!("{spec} on {bus}: {asked} requests");
            }
        }
    }
    assert!(tried.len() > 8, "{tried:?}");
}
