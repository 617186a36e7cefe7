//! Every station of either bus is asked in the same way, and answers in the same form.

use core::time::Duration;
use std::collections::BTreeSet;
use std::time::Instant;

use serde_json::{Value, json};

use super::panel::{Emulator, PATIENCE, State};

/// One of each kind on either bus.
fn both_buses() -> [Emulator; 2] {
    let gsd = format!("7,gsd={}/tests/gsd/remote_io.gsd", env!("CARGO_MANIFEST_DIR"));
    let table = format!("8,parameters={}/examples/ppo_drive.toml", env!("CARGO_MANIFEST_DIR"));
    let profibus =
        ["--drive", "5", "--drive", "6,model=ag03,gear=24", "--station", &gsd, "--ppo-drive", &table];
    let nodes = ["--node", "5", "--node", "6,device=ap10", "--node", "7,device=asda-a2"];
    let link = ["--link", "slcan-tcp:127.0.0.1:0"];
    [Emulator::with(&profibus), Emulator::with(&[&nodes[..], &link].concat())]
}

fn names(object: &Value) -> BTreeSet<String> {
    object.as_object().unwrap().keys().cloned().collect()
}

fn stations(emulator: &Emulator) -> Vec<Value> {
    emulator.get("/api/v1/stations")["stations"].as_array().unwrap().clone()
}

#[test]
fn every_kind_of_station_tells_the_same_fields_and_the_list_is_a_part_of_them() {
    let mut fields = BTreeSet::new();
    for (emulator, devices) in both_buses()
        .iter()
        .zip([&["ag03-1", "ag03", "ppo-drive", "gsd-station"][..], &["ag03-1", "ap10", "asda-a2"]])
    {
        let listed = stations(emulator);
        assert_eq!(
            listed.iter().map(|station| station["device"].as_str().unwrap()).collect::<Vec<_>>(),
            devices
        );
        for seen in listed {
            let address = &seen["address"];
            let state = emulator.get(&format!("/api/v1/stations/{address}"));
            let with_line = emulator.get(&format!("/api/v1/lines/line/stations/{address}"));
            assert_eq!(names(&state), names(&with_line));
            for name in names(&seen) {
                assert!(!state[&name].is_null() || seen[&name].is_null(), "{name} of {address}: {state}");
            }
            for constant in ["line", "bus", "address", "device", "product"] {
                assert_eq!(state[constant], seen[constant]);
                assert!(!seen[constant].is_null(), "{constant}");
            }
            fields.insert((names(&seen), names(&state)));
        }
    }
    assert_eq!(fields.len(), 1, "{fields:#?}");
}

#[test]
fn what_a_station_says_that_it_has_is_answered_and_the_rest_is_refused() {
    for emulator in both_buses() {
        for station in stations(&emulator) {
            let path = format!("/api/v1/stations/{}", station["address"]);
            let has = emulator.get(&path)["has"].clone();
            for (part, route) in [
                ("parameters", "parameters"),
                ("objects", "objects"),
                ("modules", "texts"),
                ("samples", "samples"),
                ("switches", "switches"),
            ] {
                let answer = emulator.request("GET", &format!("{path}/{route}"), "", "");
                let status = if has[part] == json!(true) { 200 } else { 409 };
                assert_eq!(answer.status, status, "{path}/{route}: {} {has}", answer.body);
            }
            assert_eq!(emulator.get(&format!("{path}/why"))["address"], station["address"]);
            assert_eq!(has["power"] == json!(true), !station["power"].is_null(), "{station}");
        }
    }
}

#[test]
fn what_acts_on_a_station_is_told_with_its_range_and_is_as_before_after_a_change_and_back() {
    for emulator in both_buses() {
        for station in stations(&emulator) {
            let path = format!("/api/v1/stations/{}", station["address"]);
            let inputs = format!("{path}/inputs");
            let state = emulator.get(&path);
            let before = emulator.get(&inputs);
            for input in state["inputs"].as_array().unwrap() {
                let name = input["input"].as_str().unwrap();
                assert_eq!(&before[name], state.input(name), "{path} {name}");
                // A fault that was raised stays until the master acknowledges it.
                if name == "fault_number" {
                    continue;
                }
                let wanted = match input["high"].as_f64() {
                    Some(high) => json!(high.min(3.0)),
                    None => json!(input["value"] != json!(true)),
                };
                let changed = emulator.set("PATCH", &inputs, &json!({ name: wanted }));
                assert_eq!(changed[name], wanted, "{path} {name}");
                emulator.set("DELETE", &inputs, &Value::Null);
            }
        }
    }
}

#[test]
fn a_key_with_a_lease_is_released_by_itself_unless_it_is_pressed_again() {
    for emulator in both_buses() {
        let keys = "/api/v1/stations/5/keys";
        let pressed = || emulator.get("/api/v1/stations/5").entry("keys", "key", "key_1")["pressed"].clone();
        let press = |lease: u64| {
            emulator.set(
                "POST",
                keys,
                &json!({ "key": "key_1", "pressed": true, "lease_milliseconds": lease }),
            )
        };
        // A second press prolongs it.
        press(60);
        press(2000);
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(pressed(), json!(true));
        let start = Instant::now();
        while pressed() == json!(true) {
            assert!(start.elapsed() < PATIENCE, "the key stays pressed");
        }
        // Without a lease it stays.
        emulator.set("POST", keys, &json!({ "key": "key_1", "pressed": true }));
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(pressed(), json!(true));
        emulator.set("POST", keys, &json!({ "key": "key_1", "pressed": false }));
        assert_eq!(pressed(), json!(false));
    }
}

#[test]
fn the_cause_of_a_fault_is_provoked_and_taken_back() {
    for emulator in both_buses() {
        for station in stations(&emulator) {
            let path = format!("/api/v1/stations/{}", station["address"]);
            let faults = emulator.get(&path)["faults"].as_array().unwrap().clone();
            for fault in faults.iter().take(9) {
                let name = fault["fault"].as_str().unwrap();
                let provoke = |provoked: bool| {
                    let body = json!({ "fault": name, "provoked": provoked });
                    emulator.set("POST", &format!("{path}/provoke"), &body);
                    let start = Instant::now();
                    while emulator.get(&path).fault(name)["provoked"] != json!(provoked) {
                        assert!(
                            start.elapsed() < PATIENCE,
                            "{path} {name} {provoked}: {}",
                            emulator.get(&path)["faults"]
                        );
                    }
                };
                assert_eq!(fault["provoked"], json!(false), "{path} {name}");
                provoke(true);
                provoke(false);
            }
        }
    }
}
