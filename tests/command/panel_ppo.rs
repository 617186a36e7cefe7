//! HTTP control of a drive of PROFIDRIVE version 2.

use crate::panel;

use panel::Emulator;
use serde_json::{Value, json};

fn emulator() -> Emulator {
    let table = format!("{}/examples/ppo_drive.toml", env!("CARGO_MANIFEST_DIR"));
    Emulator::with(&["--drive", "5", "--ppo-drive", &format!("7,parameters={table}")])
}

#[test]
fn drives_of_the_profile_are_listed_beside_others_and_removed() {
    let emulator = emulator();
    let drives = emulator.get("/api/v1/ppo-drives");
    let drive = &drives["ppo_drives"][0];
    assert_eq!((&drive["address"], &drive["state"]), (&json!(7), &json!("switching on inhibited")));
    let kinds: Vec<Value> = emulator.get("/api/v1/bus")["stations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|station| station["kind"].clone())
        .collect();
    assert_eq!(kinds, [json!("drive"), json!("ppo_drive")]);
    assert_eq!(emulator.get("/api/v1/drives")["drives"].as_array().unwrap().len(), 1);
    assert_eq!(emulator.request("DELETE", "/api/v1/ppo-drives/7", "", "").status, 204);
    assert_eq!(emulator.get("/api/v1/ppo-drives")["ppo_drives"], json!([]));
    let answer = emulator.request("GET", "/api/v1/ppo-drives/7", "", "");
    assert_eq!(answer.status, 404);
    assert!(answer.body.contains("start one with emulate --ppo-drive"), "{}", answer.body);
}

#[test]
fn faults_warnings_and_load_act_on_the_drive_and_are_seen() {
    let emulator = emulator();
    emulator.set("POST", "/api/v1/ppo-drives/7/fault", &json!({ "number": 77 }));
    emulator.set("PUT", "/api/v1/ppo-drives/7/warning", &json!({ "number": 5 }));
    let state = emulator.set("PUT", "/api/v1/ppo-drives/7/load", &json!({ "percent": 40.0 }));
    assert_eq!(
        (&state["state"], &state["fault"], &state["warning"]),
        (&json!("fault"), &json!(true), &json!(true))
    );
    assert_eq!((&state["faults"], &state["warnings"]), (&json!([77]), &json!([5])));
    assert_eq!(state["load_percent"], json!(40.0));
    assert_eq!(state["zsw_bits"][3], json!({ "bit": 3, "set": true, "name": "fault" }));
    assert!(state["why"][1].as_str().unwrap().starts_with("a fault: "), "{}", state["why"]);
    for (method, path, body, status) in [
        ("POST", "fault", json!({ "number": 0 }), 422),
        ("POST", "fault", json!({ "number": 65536 }), 422),
        ("PUT", "load", json!({ "percent": -1.0 }), 422),
        ("PUT", "warning", json!({ "nmber": 1 }), 422),
    ] {
        let answer = emulator.send(method, &format!("/api/v1/ppo-drives/7/{path}"), &body);
        assert_eq!(answer.status, status, "{path} {body}: {}", answer.body);
    }
}

#[test]
fn parameters_are_read_and_written_by_the_rules_of_the_bus() {
    let emulator = emulator();
    let list = emulator.get("/api/v1/ppo-drives/7/parameters");
    let ramp = list["parameters"].as_array().unwrap().iter().find(|row| row["pnu"] == 2).unwrap();
    assert_eq!((&ramp["values"], &ramp["scale"], &ramp["unit"]), (&json!([20.0]), &json!(0.1), &json!("s")));
    let written = emulator.set("PUT", "/api/v1/ppo-drives/7/parameters/2", &json!({ "value": 5 }));
    assert_eq!((&written["value"], &written["name"]), (&json!(5.0), &json!("ramp-up time")));
    let element =
        emulator.set("PUT", "/api/v1/ppo-drives/7/parameters/30?subindex=2", &json!({ "value": -7 }));
    assert_eq!(element["value"], json!(-7.0));
    assert_eq!(emulator.get("/api/v1/ppo-drives/7/parameters/30?subindex=2")["value"], json!(-7.0));
    for (path, value, status) in
        [("2", 6501.0, 422), ("10", 1.0, 409), ("99", 1.0, 404), ("30", 1.0, 422), ("x", 1.0, 400)]
    {
        let path = format!("/api/v1/ppo-drives/7/parameters/{path}");
        let answer = emulator.send("PUT", &path, &json!({ "value": value }));
        assert_eq!(answer.status, status, "{path}: {}", answer.body);
    }
}

#[test]
fn why_a_drive_does_not_turn_is_said_on_request() {
    let emulator = emulator();
    let why = emulator.get("/api/v1/ppo-drives/7/why");
    assert_eq!((&why["address"], &why["turning"]), (&json!(7), &json!(false)));
    let text = |why: &Value, place: usize| why["hindrances"][place]["text"].as_str().unwrap().to_owned();
    assert!(
        text(&why, 0).starts_with("no master exchanges data with the drive: it waits for Set_Prm"),
        "{why}"
    );
    assert!(text(&why, 1).starts_with("switching on is inhibited: give OFF1 once"), "{why}");
    assert_eq!(why["text"], json!(format!("it does not turn: {}; {}", text(&why, 0), text(&why, 1))));
    let state = emulator.set("POST", "/api/v1/ppo-drives/7/fault", &json!({ "number": 77 }));
    let why = emulator.get("/api/v1/ppo-drives/7/why");
    assert!(text(&why, 1).starts_with("a fault: remove its cause"), "{why}");
    assert_eq!(state["why"], json!([text(&why, 0), text(&why, 1)]), "the page says the same");
    for (path, status) in [("5/why", 404), ("9/why", 404), ("7/why?all=1", 400), ("127/why", 400)] {
        let answer = emulator.request("GET", &format!("/api/v1/ppo-drives/{path}"), "", "");
        assert_eq!(answer.status, status, "{path}: {}", answer.body);
    }
}

#[test]
fn the_stream_shows_what_changes() {
    let emulator = emulator();
    let mut stream = emulator.stream("?address=7");
    emulator.set("POST", "/api/v1/ppo-drives/7/fault", &json!({ "number": 9 }));
    stream.find("state", |state| state["faults"] == json!([9]));
}
