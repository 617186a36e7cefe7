//! HTTP control of a drive of PROFIDRIVE version 2.

use serde_json::{Value, json};

use crate::panel::{Emulator, State};

fn emulator() -> Emulator {
    let table = format!("{}/examples/ppo_drive.toml", env!("CARGO_MANIFEST_DIR"));
    Emulator::with(&["--drive", "5", "--ppo-drive", &format!("7,parameters={table}")])
}

#[test]
fn drives_of_the_profile_are_listed_beside_others_and_removed() {
    let emulator = emulator();
    let listed = emulator.get("/api/v1/stations");
    let drive = &listed["stations"][1];
    assert_eq!((&drive["address"], &drive["state_text"]), (&json!(7), &json!("switching on inhibited")));
    let devices: Vec<Value> = emulator.get("/api/v1/lines/line")["stations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|station| station["device"].clone())
        .collect();
    assert_eq!(devices, [json!("ag03-1"), json!("ppo-drive")]);
    assert_eq!(listed["stations"].as_array().unwrap().len(), 2);
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/7", "", "").status, 204);
    assert_eq!(emulator.get("/api/v1/stations")["stations"].as_array().unwrap().len(), 1);
    let answer = emulator.request("GET", "/api/v1/stations/7", "", "");
    assert_eq!(answer.status, 404);
    assert_eq!(answer.detail(), "there is no station at address 7; there are stations at 5");
}

#[test]
fn faults_warnings_and_load_act_on_the_drive_and_are_seen() {
    let emulator = emulator();
    let inputs = "/api/v1/stations/7/inputs";
    emulator.set("PATCH", inputs, &json!({ "fault_number": 77 }));
    emulator.set("PATCH", inputs, &json!({ "warning_number": 5 }));
    let answer = emulator.set("PATCH", inputs, &json!({ "load_percent": 40.0 }));
    assert_eq!(answer["load_percent"], json!(40.0));
    let state = emulator.get("/api/v1/stations/7");
    assert_eq!((&state["state"], &state["fault"]["fault"]), (&json!("fault"), &json!("77")));
    assert!(state["warning"].as_str().unwrap().contains('5'), "{}", state["warning"]);
    let codes: Vec<_> =
        state["history"].as_array().unwrap().iter().map(|entry| entry["code"].to_string()).collect();
    assert_eq!(codes.iter().map(|code| code.trim_matches('"')).collect::<Vec<_>>(), ["77", "5"]);
    assert_eq!(state.input("load_percent"), &json!(40.0));
    let bit = &state.word("zsw")["bits"][3];
    assert_eq!((&bit["bit"], &bit["set"], &bit["name"]), (&json!(3), &json!(true), &json!("fault")));
    let reason = state["why"]["reasons"][1]["text"].as_str().unwrap();
    assert!(reason.starts_with("a fault: "), "{}", state["why"]);
    for body in [
        json!({ "fault_number": -1 }),
        json!({ "fault_number": 65536 }),
        json!({ "load_percent": -1.0 }),
        json!({ "warning_nmber": 1 }),
    ] {
        let answer = emulator.send("PATCH", inputs, &body);
        assert_eq!(answer.status, 422, "{body}: {}", answer.body);
    }
    let nominal = emulator.set("DELETE", inputs, &Value::Null);
    assert_eq!((&nominal["warning_number"], &nominal["load_percent"]), (&json!(0.0), &json!(10.0)));
}

#[test]
fn parameters_are_read_and_written_by_the_rules_of_the_bus() {
    let emulator = emulator();
    let list = emulator.get("/api/v1/stations/7/parameters");
    let ramp = list.entry("parameters", "key", "2");
    assert_eq!((&ramp["name"], &ramp["unit"]), (&json!("ramp-up time"), &json!("s")));
    assert_eq!(ramp["text"], json!("20 (2) s"), "as on the bus, and with its scale");
    let written = emulator.set("PUT", "/api/v1/stations/7/parameters/2", &json!({ "value": 5 }));
    assert_eq!((&written["value"].as_f64(), &written["name"]), (&Some(5.0), &json!("ramp-up time")));
    let element = emulator.set("PUT", "/api/v1/stations/7/parameters/30.2", &json!({ "value": -7 }));
    assert_eq!(element["value"].as_f64(), Some(-7.0));
    assert_eq!(emulator.get("/api/v1/stations/7/parameters/30.2")["value"].as_f64(), Some(-7.0));
    for (path, value, status) in
        [("2", 6501.0, 422), ("10", 1.0, 409), ("99", 1.0, 404), ("30", 1.0, 422), ("x", 1.0, 400)]
    {
        let path = format!("/api/v1/stations/7/parameters/{path}");
        let answer = emulator.send("PUT", &path, &json!({ "value": value }));
        assert_eq!(answer.status, status, "{path}: {}", answer.body);
    }
}

#[test]
fn why_a_drive_does_not_turn_is_said_on_request() {
    let emulator = emulator();
    let why = emulator.get("/api/v1/stations/7/why");
    assert_eq!((&why["address"], &why["moving"]), (&json!(7), &json!(false)));
    let text = |why: &Value, place: usize| why["reasons"][place]["text"].as_str().unwrap().to_owned();
    assert!(
        text(&why, 0).starts_with("no master exchanges data with the drive: it waits for Set_Prm"),
        "{why}"
    );
    assert!(text(&why, 1).starts_with("switching on is inhibited: give OFF1 once"), "{why}");
    assert!(why["text"].as_str().unwrap().contains(&text(&why, 1)), "{why}");
    emulator.set("PATCH", "/api/v1/stations/7/inputs", &json!({ "fault_number": 77 }));
    let why = emulator.get("/api/v1/stations/7/why");
    assert!(text(&why, 1).starts_with("a fault: remove its cause"), "{why}");
    assert_eq!(
        emulator.get("/api/v1/stations/7")["why"]["reasons"],
        why["reasons"],
        "the page says the same"
    );
    for (path, status) in [("9/why", 404), ("7/why?all=1", 400), ("128/why", 400)] {
        let answer = emulator.request("GET", &format!("/api/v1/stations/{path}"), "", "");
        assert_eq!(answer.status, status, "{path}: {}", answer.body);
    }
}

#[test]
fn the_stream_shows_what_changes() {
    let emulator = emulator();
    let mut stream = emulator.stream("?address=7");
    emulator.set("PATCH", "/api/v1/stations/7/inputs", &json!({ "fault_number": 9 }));
    stream.find("state", |state| state["fault"]["fault"] == json!("9"));
}
