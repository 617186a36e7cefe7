//! The object dictionary of nodes over HTTP: entries, words and PDOs, inputs that follow signals.

use serde_json::json;

use super::node_panel::Rig;
use super::panel::{Emulator, State};

#[test]
fn the_dictionary_is_read_and_written_past_the_bus_by_the_rules_of_the_bus() {
    let mut rig = Rig::start(&["5", "6,device=ap10"]);
    let device_type = rig.get("5/objects/1000/0");
    assert_eq!(
        (&device_type["value"], &device_type["type"], &device_type["access"]),
        (&json!(0x192), &json!("UNSIGNED32"), &json!("ro"))
    );
    assert_eq!(rig.get("5/objects/0x1000/00h"), device_type);
    let written = rig.set("PUT", "6/objects/1017/0", &json!({"value": 250}));
    assert_eq!((&written["value"], &written["octets_hex"]), (&json!(250), &json!("FA 00")));
    assert_eq!(rig.read(6, "171000") & 0xFFFF, 250);
    assert_eq!(rig.master.frame(0x706), "7F", "the heartbeat begins");
    let all = rig.get("5/objects");
    assert!(all["objects"].as_array().unwrap().len() > 130, "every entry");
    for (path, body, status, says) in [
        ("6/objects/6004/0", json!({"value": 1}), 422, "6004h:00 cannot be written"),
        (
            "6/objects/1017/0",
            json!({"value": 65536}),
            422,
            "is UNSIGNED16: expected a whole number that fits",
        ),
        ("6/objects/1017/0", json!({"value": "x"}), 422, "expected a whole number, got \"x\""),
        ("6/objects/1018/9", json!({"value": 1}), 404, "has no sub-index 09"),
        ("6/objects/9999/0", json!({"value": 1}), 404, "there is no object 9999h"),
        ("6/objects/10000/0", json!({"value": 1}), 400, "'10000' is no index"),
        ("6/objects/1017/g", json!({"value": 1}), 400, "'g' is no sub-index"),
    ] {
        rig.refused("PUT", path, &body, status, says);
    }
}

#[test]
fn words_and_pdos_are_shown_bit_by_bit_with_what_they_carry() {
    let mut rig = Rig::start(&["5"]);
    rig.master.send("t00020105");
    rig.master.sdo(5, "2B40600006000000");
    let state = rig.wait_for(5, "OPERATIONAL", |state| state["bus_state"] == "OPERATIONAL");
    assert_eq!(state["exchanging"], true);
    let status = state.word("6041");
    assert!(status["name"].as_str().unwrap().starts_with("6041h:00"), "{status}");
    let bit = &status["bits"][0];
    assert_eq!(
        (&bit["bit"], &bit["set"], &bit["name"]),
        (&json!(0), &json!(true), &json!("ready to switch on"))
    );
    assert_eq!(state.word("6040")["value"], 6);
    assert_eq!(state["words"][0]["key"], "6040", "commanded words first");
    let first = state["process"].as_array().unwrap().iter().find(|pdo| pdo["key"] == "TPDO1").unwrap();
    assert!(first["name"].as_str().unwrap().contains("COB-ID 185h"), "{first}");
    assert_eq!(first["from_master"], false);
    assert_eq!(
        (&first["entries"][0]["place"], &first["entries"][0]["value"]),
        (&json!("6041h:00"), &status["value"])
    );
}

#[test]
fn objects_of_a_file_are_set_and_follow_signals_over_http() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds");
    let pump = format!("5,eds={folder}/pump.eds");
    let mut rig = Rig::start(&[&pump]);
    rig.set("PATCH", "5/inputs", &json!({ "2001h": 1.5 }));
    assert_eq!(rig.read(5, "012000"), 1.5_f32.to_bits());
    assert_eq!(rig.get("5/objects/2001/0")["value"], 1.5);
    rig.refused("PATCH", "5/inputs", &json!({ "2000h": 1 }), 422, "2000h");
    let count =
        json!([{ "object": "2002h", "behaviour": "count", "from": 0, "to": 100_000, "every": "10ms" }]);
    let node = json!({ "node": { "id": 6, "eds": "pump.eds", "profile": "none", "value": count } });
    let refused = rig.emulator.send("POST", "/api/v1/stations", &node);
    assert_eq!(refused.status, 422, "no folder is named for files over HTTP: {refused:?}");
    let emulator =
        Emulator::with(&["--node", &pump, "--link", "slcan-tcp:127.0.0.1:0", "--panel-files", folder]);
    let added = emulator.send("POST", "/api/v1/stations", &node);
    assert_eq!(added.status, 201, "{added:?}");
    let value = || emulator.get("/api/v1/stations/6/objects/2002/0")["value"].as_i64();
    let (first, start) = (value(), std::time::Instant::now());
    while value() == first {
        assert!(start.elapsed() < super::panel::PATIENCE, "{first:?}");
    }
}
