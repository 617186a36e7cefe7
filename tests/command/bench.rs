//! The master in this program: `profidrive try`, `emulate --bench`, over HTTP.

use std::time::Instant;

use serde_json::{Value, json};

use crate::emulator::{output, profidrive};
use crate::panel::{Emulator, PATIENCE};

pub(super) const MASTER: &str = "/api/v1/stations/5/master";

/// Asks for something and waits until it is over: whether it went well, and what was said.
pub(super) fn ask(emulator: &Emulator, order: &Value) -> (bool, String) {
    let mut state = emulator.set("POST", MASTER, order);
    let begun = Instant::now();
    while !state["doing"].is_null() {
        assert!(begun.elapsed() < PATIENCE, "{order} never ends: {state}");
        state = emulator.get(MASTER)["master"].clone();
    }
    let done = &state["done"];
    (done["well"].as_bool().unwrap(), done["text"].as_str().unwrap().to_owned())
}

fn does(emulator: &Emulator, order: &Value) -> String {
    let (well, text) = ask(emulator, order);
    assert!(well, "{order}: {text}");
    text
}

/// Every text that was sent.
fn sent(emulator: &Emulator) -> Vec<String> {
    let sent = emulator.get(MASTER)["master"]["sent"].clone();
    sent.as_array().unwrap().iter().map(|one| one["text"].as_str().unwrap().to_owned()).collect()
}

fn value(state: &Value, key: &str) -> f64 {
    let values = state["values"].as_array().unwrap();
    values.iter().find(|value| value["key"] == key).unwrap()["value"].as_f64().unwrap()
}

#[test]
fn a_positioning_drive_is_taken_over_moved_and_let_go() {
    let emulator = Emulator::trying(&[]);
    // Somebody who tries it sees it alive.
    emulator.wait_for("taken over", |state| state["owner_address"] == 1);
    does(&emulator, &json!({"act": "enable"}));
    assert!(does(&emulator, &json!({"act": "move", "value": 120})).starts_with("done, actual value 1"));
    let state = emulator.get("/api/v1/stations/5");
    assert!((value(&state, "position") - 120.0).abs() < 6.0, "{state}");
    assert_eq!(state["master"]["taken"], true);
    let words = sent(&emulator);
    assert!(words.iter().any(|text| text.contains("STW 000B")), "{words:?}");

    assert_eq!(
        does(&emulator, &json!({"act": "write", "place": "1004", "value": 33})),
        "PNU 1004 = 33 (0021h)"
    );
    assert_eq!(does(&emulator, &json!({"act": "read", "place": "1004"})), "PNU 1004 = 33 (0021h)");
    let (well, text) = ask(&emulator, &json!({"act": "read", "place": "999"}));
    assert!(!well && text.contains("parameter number"), "{text}");
    let (well, text) = ask(&emulator, &json!({"act": "write", "place": "1004", "value": 99999}));
    assert!(!well && text.contains("-32768 to 65535"), "{text}");

    emulator.set("DELETE", MASTER, &Value::Null);
    emulator.wait_for("let go", |state| state["owner_address"].is_null());
    assert_eq!(emulator.get(MASTER)["master"]["taken"], false);
}

#[test]
fn what_keeps_a_drive_from_it_is_said_and_a_lost_drive_is_taken_again() {
    let emulator = Emulator::trying(&["ag03"]);
    emulator.wait_for("taken over", |state| state["owner_address"] == 1);
    emulator.set("PATCH", "/api/v1/stations/5/inputs", &json!({"enable": false}));
    let (well, text) = ask(&emulator, &json!({"act": "move", "value": 100}));
    assert!(!well && text.contains("enable"), "{text}");
    emulator.set("PATCH", "/api/v1/stations/5/inputs", &json!({"enable": true}));
    emulator.set("PUT", "/api/v1/stations/5/power", &json!({"on": false}));
    let begun = Instant::now();
    while emulator.get(MASTER)["master"]["taken"] == true {
        assert!(begun.elapsed() < PATIENCE, "a drive that is off was never missed");
    }
    emulator.set("PUT", "/api/v1/stations/5/power", &json!({"on": true}));
    does(&emulator, &json!({"act": "enable"}));
}

#[test]
fn drives_of_the_profile_turn_with_a_part_of_their_speed() {
    for device in ["ppo-drive", "profidrive"] {
        let emulator = Emulator::trying(&[device]);
        does(&emulator, &json!({"act": "enable"}));
        let text = does(&emulator, &json!({"act": "speed", "value": -30}));
        assert!(text.starts_with("done, actual value -"), "{device}: {text}");
        assert!(sent(&emulator).iter().any(|text| text.contains("STW 047F, set-point -4915 (-30.0 %)")));
        does(&emulator, &json!({"act": "disable"}));
    }
}

#[test]
fn nodes_are_started_moved_and_released_and_their_objects_written() {
    for arguments in [&["asda-a2"][..], &["ag03-1", "--canopen"]] {
        let emulator = Emulator::trying(arguments);
        does(&emulator, &json!({"act": "enable"}));
        emulator.wait_for("enabled", |state| state["state"] == "enabled");
        does(&emulator, &json!({"act": "move", "value": 150}));
        let words = sent(&emulator);
        assert!(words.iter().any(|text| text.contains("6040h:00 = 000Fh")), "{words:?}");
        assert_eq!(
            does(&emulator, &json!({"act": "write", "place": "607A", "value": -77})),
            "607Ah:00 is written"
        );
        let text = does(&emulator, &json!({"act": "read", "place": "607Ah:0"}));
        assert_eq!(text, "607Ah:00 = 4294967219 or -77 (FFFFFFB3h)");
        does(&emulator, &json!({"act": "disable"}));
        emulator.wait_for("as before", |state| state["bus_state"] == "PRE-OPERATIONAL");
        does(&emulator, &json!({"act": "nmt_stop"}));
        emulator.wait_for("stopped", |state| state["bus_state"] == "STOPPED");
        let (well, text) = ask(&emulator, &json!({"act": "read", "place": "1000"}));
        assert!(!well && text.contains("STOPPED"), "{text}");
    }
}

#[test]
fn a_station_from_a_gsd_gets_its_outputs() {
    let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gsd/remote_io.gsd");
    let emulator = Emulator::trying(&[&format!("gsd-station,gsd={gsd}")]);
    emulator.wait_for("taken over", |state| state["owner_address"] == 1);
    does(&emulator, &json!({"act": "outputs", "octets_hex": "5A"}));
    let output = |wanted: i64| {
        emulator.wait_for("outputs", |state| {
            let process = state["process"].as_array().unwrap();
            process
                .iter()
                .any(|one| one["from_master"] == true && one["octets_hex"] == format!("{wanted:02X}"))
        })
    };
    output(0x5A);
    let (well, text) = ask(&emulator, &json!({"act": "outputs", "octets_hex": "5A00"}));
    assert!(!well && text.contains("1 octets"), "{text}");
    assert_eq!(emulator.get(MASTER)["outputs"], 1);
}

#[test]
fn each_act_has_the_command_that_does_the_same() {
    let emulator = Emulator::with(&["--link", "tcp:127.0.0.1:0"]);
    let offered = emulator.get(MASTER);
    assert_eq!(offered["master"], Value::Null, "there is none without --bench");
    let command = |name: &str| {
        let acts = offered["acts"].as_array().unwrap();
        acts.iter().find(|act| act["act"] == name).unwrap()["command"].as_str().unwrap().replace("{}", "90")
    };
    assert_eq!(offered["next_command"].as_str().unwrap(), command("enable"));
    for name in ["move", "stop", "acknowledge"] {
        let command =
            format!("{} --yes", command(name)).replace("stop --yes", "stop").replace("ack --yes", "ack");
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        let done = output(&words);
        assert!(done.status.success(), "{command}: {}", String::from_utf8_lossy(&done.stderr));
    }
    let refused = emulator.send("POST", MASTER, &json!({"act": "enable"}));
    assert_eq!(refused.status, 409);
    assert!(refused.body.contains("--bench"), "{}", refused.body);
}

#[test]
fn a_drive_of_another_master_is_left_alone_and_wrong_orders_are_refused() {
    let emulator = Emulator::with(&["--link", "tcp:127.0.0.1:0", "--bench"]);
    let wrong = [
        (json!({"act": "fly"}), "take, enable"),
        (json!({"act": "move"}), "needs a value"),
        (json!({"act": "read", "place": "x"}), "1004 or 945.0"),
        (json!({"act": "write", "place": "1004"}), "value is missing"),
        (json!({"act": "outputs", "octets_hex": "5"}), "01 FF"),
    ];
    for (order, words) in wrong {
        let answer = emulator.send("POST", MASTER, &order);
        assert_eq!(answer.status, 422, "{order}");
        assert!(answer.body.contains(words), "{order}: {}", answer.body);
    }
    let link = emulator.terminal().display().to_string();
    let enable = ["master", "--link", &link, "--address", "5", "enable", "--for", "3s", "--yes"];
    let mut other = profidrive(&enable);
    let mut other =
        other.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap();
    emulator.wait_for("owned", |state| state["owner_address"] == 0);
    let refused = emulator.send("POST", MASTER, &json!({"act": "enable"}));
    assert_eq!(refused.status, 409, "{}", refused.body);
    assert!(refused.body.contains("master 0 owns station 5"), "{}", refused.body);
    assert!(other.wait().unwrap().success(), "the other master was not disturbed");
    does(&emulator, &json!({"act": "enable"}));
}

#[test]
fn two_drives_of_a_line_are_operated_at_the_same_time() {
    let emulator = Emulator::with(&["--drives", "5-6", "--bench"]);
    does(&emulator, &json!({"act": "enable"}));
    let other = "/api/v1/stations/6/master";
    let ends = |what: &str| {
        let begun = Instant::now();
        while emulator.get(other)["master"]["done"]["what"] != what {
            assert!(begun.elapsed() < PATIENCE, "{what}");
        }
    };
    emulator.set("POST", other, &json!({"act": "enable"}));
    ends("enable");
    emulator.set("POST", other, &json!({"act": "move", "value": 400}));
    does(&emulator, &json!({"act": "move", "value": 60}));
    ends("move to 400");
    for address in [5, 6] {
        let state = emulator.get(&format!("/api/v1/stations/{address}"));
        assert_eq!(state["owner_address"], 1, "address 1 is free for the master");
        assert_eq!(state["master"]["done"]["well"], true, "{state}");
    }
}

#[test]
fn it_is_not_offered_on_a_real_bus_and_an_unknown_device_is_named() {
    let refused = output(&["emulate", "--link", "serial:/dev/null", "--panel", "127.0.0.1:0", "--bench"]);
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{words}");
    assert!(words.contains("not for a real bus"), "{words}");
    let refused = output(&["try", "ag04"]);
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{words}");
    assert!(words.contains("there is no device 'ag04'"), "{words}");
}
