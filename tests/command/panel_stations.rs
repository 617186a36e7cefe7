//! HTTP control of a station from a GSD.

use std::time::Instant;

use serde_json::{Value, json};

use crate::panel::Emulator;
use crate::patience::PATIENCE;

fn emulator() -> Emulator {
    let gsd = format!("{}/tests/gsd/remote_io.gsd", env!("CARGO_MANIFEST_DIR"));
    Emulator::with(&["--drive", "5", "--station", &format!("7,gsd={gsd}")])
}

#[test]
fn stations_are_listed_beside_drives_and_removed() {
    let emulator = emulator();
    let list = emulator.get("/api/v1/stations");
    let station = &list["stations"][1];
    assert_eq!((&station["address"], &station["product"]), (&json!(7), &json!("profidrive Remote I/O")));
    let said = (&station["bus_state"], &station["state_text"]);
    assert_eq!(said, (&json!("WAIT-PRM"), &json!("no master exchanges data")));
    let devices: Vec<_> = emulator.get("/api/v1/lines/line")["stations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|station| station["device"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(devices, ["ag03-1", "gsd-station"]);
    let texts = emulator.get("/api/v1/stations/7/texts");
    assert_eq!(texts["bits"][0], json!({ "number": 0, "text": "no sensor supply" }));
    assert_eq!(texts["channel_errors"].as_array().unwrap().len(), 10);
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/7", "", "").status, 204);
    assert_eq!(emulator.get("/api/v1/stations")["stations"].as_array().unwrap().len(), 1);
}

#[test]
fn inputs_are_forced_and_read_by_slot_or_name_and_type() {
    let emulator = emulator();
    // Before a master comes, the modules are those that Get_Cfg reports.
    let state = emulator.get("/api/v1/stations/7");
    let module = &state["process"][0];
    assert_eq!((&module["name"], &module["octets_hex"]), (&json!("Slot 1: 8 DI"), &json!("00")));
    assert_eq!((&module["slot"], &module["from_master"]), (&json!(1), &json!(false)));
    let forced = emulator.set("PUT", "/api/v1/stations/7/inputs/1/0/bit3", &json!({ "value": 1 }));
    assert_eq!(forced, json!({ "value": 1.0, "forced": true }));
    let named = emulator.get("/api/v1/stations/7/inputs/8%20DI/0/unsigned8");
    assert_eq!(named, json!({ "value": 8.0, "forced": true }));
    let state = emulator.get("/api/v1/stations/7");
    let module = &state["process"][0];
    assert_eq!((&module["octets_hex"], &module["forced_hex"]), (&json!("08"), &json!("08")));
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/7/inputs/1/0/bit3", "", "").status, 204);
    let free = emulator.get("/api/v1/stations/7/inputs/1/0/unsigned8");
    assert_eq!(free, json!({ "value": 0.0, "forced": false }));
}

/// Asks for the inputs of slot 1 until they are these.
fn inputs_become(emulator: &Emulator, expected: f64) {
    let begun = std::time::Instant::now();
    loop {
        let value = emulator.get("/api/v1/stations/7/inputs/1/0/unsigned8")["value"].clone();
        if value == json!(expected) {
            return;
        }
        assert!(begun.elapsed() < PATIENCE, "{value}, expected {expected}");
        std::thread::yield_now();
    }
}

#[test]
fn signals_are_given_on_the_command_line_and_over_http_and_read_inputs_and_values_of_drives() {
    let gsd = format!("{}/tests/gsd/remote_io.gsd", env!("CARGO_MANIFEST_DIR"));
    let inputs = [
        "1/0/bit0:value=1",
        "1/0/bit1:not:of=input/1/0/bit0",
        "1/0/bit2:compare:of=5/control_supply:above=10",
        "1/0/bit4:compare:of=5/no-such-value:above=0",
    ];
    let inputs: String = inputs.iter().map(|input| format!(",input={input}")).collect();
    let emulator = Emulator::with(&["--drive", "5", "--station", &format!("7,gsd={gsd}{inputs}")]);
    inputs_become(&emulator, 5.0);
    let signal = "/api/v1/stations/7/inputs/1/0/bit3/signal";
    let of = json!(["input/1/0/bit0", { "input": true, "slot": 1, "type": "bit1" }]);
    emulator.set("PUT", signal, &json!({ "behaviour": "or", "of": of }));
    inputs_become(&emulator, 13.0);
    for (body, words) in [
        (json!({ "behaviour": "table", "file": "a.csv" }), "no file is read for who comes by HTTP"),
        (json!({ "behaviour": "rmap" }), "did you mean ramp?"),
        (json!({ "behaviour": "ramp", "from": 0, "to": 5, "time": "1s" }), "it reaches 5, bit3 has 0 to 1"),
        (json!({ "behaviour": "mirror", "of": "x" }), "'x' is no value"),
    ] {
        let refused =
            emulator.request("PUT", signal, "content-type: application/json\r\n", &body.to_string());
        assert!(refused.status == 422 && refused.body.contains(words), "{body}: {refused:?}");
    }
    assert_eq!(emulator.request("DELETE", signal, "", "").status, 204);
    assert_eq!(emulator.request("DELETE", signal, "", "").status, 404);
    inputs_become(&emulator, 13.0);
}

#[test]
fn stations_of_every_kind_are_added_and_removed_at_run_time() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    let emulator = Emulator::with(&["--drive", "5", "--panel-files", folder]);
    let json = "content-type: application/json\r\n";
    let add = |body: &Value| emulator.request("POST", "/api/v1/stations", json, &body.to_string());
    let input = json!([{ "slot": 1, "type": "bit0", "value": 1 }]);
    for (body, device) in [
        (json!({ "drive": { "address": 8, "model": "ag03" } }), "ag03"),
        (json!({ "ppo-drive": { "address": 8, "gsd": "gsd/compact.gsd" } }), "ppo-drive"),
        (json!({ "ppo-drive": { "address": 8, "ppo": 3 } }), "ppo-drive"),
        (json!({ "station": { "address": 8, "gsd": "gsd/remote_io.gsd", "input": input } }), "gsd-station"),
        (json!({ "address": 8, "device": "gsd-station", "gsd": "gsd/modular.gsd" }), "gsd-station"),
    ] {
        let added = add(&body);
        assert_eq!(added.status, 201, "{body}: {added:?}");
        let list = emulator.get("/api/v1/stations");
        assert_eq!(list["stations"][1]["address"], 8, "{list}");
        let devices = emulator.get("/api/v1/lines/line")["stations"].clone();
        assert_eq!(devices[1]["device"], device, "{body}: {devices}");
        assert_eq!(emulator.request("DELETE", "/api/v1/stations/8", "", "").status, 204);
    }
    for (gsd, words) in [
        ("../Cargo.toml", "'../Cargo.toml' leads out of the folder"),
        ("/etc/passwd", "leads out of the folder"),
        ("", "leads out of the folder"),
        ("no.gsd", "cannot read"),
    ] {
        let refused = add(&json!({ "station": { "address": 8, "gsd": gsd } }));
        assert!(refused.status == 422 && refused.body.contains(words), "{gsd}: {refused:?}");
    }
    let table = json!([{ "slot": 1, "type": "bit0", "behaviour": "table", "file": "../x.csv" }]);
    let refused = add(&json!({ "station": { "address": 8, "gsd": "gsd/remote_io.gsd", "input": table } }));
    assert!(refused.status == 422 && refused.body.contains("'../x.csv' leads out"), "{refused:?}");
    let closed = self::emulator();
    let body = json!({ "station": { "address": 8, "gsd": "gsd/remote_io.gsd" } }).to_string();
    let refused = closed.request("POST", "/api/v1/stations", json, &body);
    assert!(refused.status == 422 && refused.body.contains("gsd: no file is read"), "{refused:?}");
}

#[test]
fn nodes_of_every_kind_are_added_and_removed_at_run_time() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds");
    let link = tempfile::tempdir().unwrap();
    let link = format!("slcan-pty:{}", link.path().join("can").display());
    let emulator = Emulator::with(&["--link", &link, "--node", "5", "--panel-files", folder]);
    let json = "content-type: application/json\r\n";
    for body in [
        json!({ "node": { "id": 8, "device": "ap10" } }),
        json!({ "node": { "id": 8, "device": "asda-a2" } }),
        json!({ "node": { "id": 8, "eds": "pump.eds" } }),
    ] {
        let added = emulator.request("POST", "/api/v1/stations", json, &body.to_string());
        assert_eq!(added.status, 201, "{body}: {added:?}");
        assert_eq!(emulator.get("/api/v1/stations")["stations"][1]["address"], 8);
        assert_eq!(emulator.request("DELETE", "/api/v1/stations/8", "", "").status, 204);
    }
}

#[test]
fn modules_are_pulled_and_plugged_as_faults_and_a_diagnosis_may_be_octets() {
    let emulator = emulator();
    let faults = &emulator.get("/api/v1/stations/7")["faults"];
    let missing = json!({ "fault": "slot1-missing", "text": "slot 1 '8 DI': the module is pulled", "present": false, "provoked": false });
    assert!(faults.as_array().is_some_and(|all| all.contains(&missing)), "{faults}");
    let octets = |emulator: &Emulator| emulator.get("/api/v1/stations/7/diagnosis")["octets"].clone();
    let before = octets(&emulator);
    emulator.set("POST", "/api/v1/stations/7/provoke", &json!({ "fault": "slot1-missing" }));
    let diagnosis = emulator.get("/api/v1/stations/7/diagnosis");
    assert_eq!(diagnosis["texts"], json!(["slot 1 '8 DI': has a diagnosis"]), "its GSD has no module status");
    assert_eq!(diagnosis["octets"].as_array().unwrap()[6..], [json!(0x42), json!(1)]);
    emulator.set(
        "POST",
        "/api/v1/stations/7/provoke",
        &json!({ "fault": "slot1-missing", "provoked": false }),
    );
    assert_eq!(octets(&emulator), before);
    emulator.set("PUT", "/api/v1/stations/7/diagnosis", &json!({ "octets": [0x42, 0x80, 0xC5] }));
    assert_eq!(octets(&emulator).as_array().unwrap()[6..], [json!(0x42), json!(0x80), json!(0xC5)]);
    for (wrong, words) in [
        (vec![0xC0; 27], "27 octets of diagnosis, Max_Diag_Data_Len leaves 26 behind the first six"),
        (vec![0x43, 1], "octet 0 of the diagnosis, 0x43, begins no whole block"),
    ] {
        let body = json!({ "octets": wrong }).to_string();
        let path = "/api/v1/stations/7/diagnosis";
        let refused = emulator.request("PUT", path, "content-type: application/json\r\n", &body);
        assert!(refused.status == 422 && refused.body.contains(words), "{refused:?}");
    }
    assert_eq!(octets(&emulator).as_array().unwrap()[6..], [json!(0x42), json!(0x80), json!(0xC5)]);
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/7/diagnosis", "", "").status, 200);
    assert_eq!(octets(&emulator), before);
}

#[test]
fn a_module_is_found_by_the_name_that_the_user_gave_it() {
    let folder = tempfile::tempdir().unwrap();
    let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gsd/twins.gsd");
    let file = folder.path().join("line.toml");
    let text = format!(
        "[[line]]\nlink = 'pty:bus'\npanel = '127.0.0.1:0'\n\
         [[line.station]]\naddress = 7\ngsd = '{gsd}'\nmodules = ['range', 'out']\n\
         [[line.station]]\naddress = 8\ngsd = '{gsd}'\n"
    );
    std::fs::write(&file, text).unwrap();
    let emulator = Emulator::of_file(file.to_str().unwrap());
    let texts = emulator.get("/api/v1/stations/7/texts");
    let named = json!([{ "slot": 1, "names": ["range"] }, { "slot": 2, "names": ["out"] }]);
    assert_eq!(texts["slots"], named);
    assert_eq!(emulator.get("/api/v1/stations/7")["process"][0]["name"], "Slot 1: range");
    assert_eq!(emulator.get("/api/v1/stations/7/inputs/range/0/unsigned8")["value"], 0.0);
    // Six modules have these octets, and no master has sent its parameters.
    let open = emulator.get("/api/v1/stations/8/texts");
    let names = ["plain", "plain HF", "filter", "range", "other", "keyed"];
    assert_eq!(open["slots"], json!([{ "slot": 1, "names": names }]));
    let name = "Slot 1: plain, plain HF, filter, range or one of 2 more";
    assert_eq!(emulator.get("/api/v1/stations/8")["process"][0]["name"], name);
    assert_eq!(emulator.get("/api/v1/stations/8/inputs/keyed/0/unsigned8")["value"], 0.0);
    let missing = emulator.request("GET", "/api/v1/stations/7/inputs/filter/0/unsigned8", "", "");
    assert_eq!(missing.status, 404, "another one is named");
}

#[test]
fn a_diagnosis_is_raised_and_ended() {
    let emulator = emulator();
    let wanted = json!({
        "bits": [1],
        "areas": [{ "first_bit": 4, "value": 2 }],
        "channels": [{ "slot": 1, "channel": 0, "direction": "input", "width": "bit", "error": 16 }],
    });
    let state = emulator.set("PUT", "/api/v1/stations/7/diagnosis", &wanted);
    let texts = json!(["no load supply", "hot", "slot 1 '8 DI', channel 0: sensor broken (16)"]);
    assert_eq!(
        (&state["diagnosis"]["texts"], &state["fault"]),
        (&texts, &json!({ "fault": "diagnosis", "text": "raised" }))
    );
    let octets = state["diagnosis"]["octets"].as_array().unwrap();
    assert_eq!(octets[6..], [0x02, 0x22, 0x80, 0x40, 0x30].map(Value::from));
    let state = emulator.set("DELETE", "/api/v1/stations/7/diagnosis", &Value::Null);
    assert_eq!((&state["diagnosis"]["texts"], &state["fault"]), (&json!([]), &json!(null)));
}

#[test]
fn what_is_done_by_hand_is_in_the_log() {
    let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gsd/remote_io.gsd");
    let station = format!("7,gsd={gsd}");
    let emulator = Emulator::logging(&["--station", &station]);
    let input = "/api/v1/stations/7/inputs/1/0/bit3";
    emulator.set("PUT", input, &json!({ "value": 1 }));
    emulator.set("PUT", "/api/v1/stations/7/diagnosis", &json!({ "not_valid": true }));
    emulator.set("DELETE", "/api/v1/stations/7/diagnosis", &Value::Null);
    assert_eq!(emulator.request("DELETE", input, "", "").status, 204);
    for words in
        ["is forced to 1", "diagnosis raised by hand: the inputs are not valid", "is no longer forced"]
    {
        let start = std::time::Instant::now();
        let is_told = || {
            let told = emulator.get("/api/v1/events/recent?address=7");
            let is_one =
                |event: &Value| event["text"].as_str().unwrap().contains(words) && event["kind"] == "input";
            told["events"].as_array().unwrap().iter().any(is_one)
        };
        while !is_told() {
            assert!(start.elapsed() < PATIENCE, "{words}");
        }
    }
    let log = emulator.log();
    for words in [
        "station 7: input bit3 in octet 0 of slot 1 is forced to 1",
        "station 7: diagnosis raised by hand: the inputs are not valid",
        "station 7: no diagnosis is raised by hand any more",
        "station 7: input bit3 in octet 0 of slot 1 is no longer forced",
    ] {
        assert!(log.iter().any(|line| line.ends_with(words)), "{words}: {log:#?}");
    }
}

#[test]
fn what_is_not_there_is_said_with_what_is() {
    let emulator = emulator();
    for (method, path, body, status, words) in [
        (
            "GET",
            "/api/v1/stations/9",
            None,
            404,
            "there is no station at address 9; there are stations at 5, 7",
        ),
        (
            "GET",
            "/api/v1/stations/7/inputs/8%20DU/0/bit0",
            None,
            404,
            "there is no slot '8 DU'; did you mean '8 DI'?; there are 1 '8 DI'",
        ),
        (
            "GET",
            "/api/v1/stations/7/inputs/1/0/word",
            None,
            400,
            "'word' is no type; expected bit0 to bit7, unsigned8",
        ),
        (
            "GET",
            "/api/v1/stations/7/inputs/1/x/bit0",
            None,
            400,
            "'x' is no octet of a slot; expected 0 to 243",
        ),
        (
            "GET",
            "/api/v1/stations/7/outputs/1/0/bit0",
            None,
            422,
            "bit0 at octet 0 needs 1 octets, slot 1 has 0 of outputs",
        ),
        (
            "PUT",
            "/api/v1/stations/7/inputs/1/0/unsigned8",
            Some(json!({ "value": 256 })),
            422,
            "256 does not fit, expected 0 to 255",
        ),
        (
            "PUT",
            "/api/v1/stations/7/inputs/1/1/unsigned8",
            Some(json!({ "value": 1 })),
            422,
            "unsigned8 at octet 1 needs 2 octets, the slot has 1",
        ),
        (
            "PUT",
            "/api/v1/stations/7/diagnosis",
            Some(json!({ "identifiers": [4] })),
            422,
            "there is no slot 4; the configuration has 1 to 1",
        ),
        ("PUT", "/api/v1/stations/7/diagnosis", Some(json!({ "colour": 1 })), 422, "unknown field"),
    ] {
        let answer = match body {
            Some(body) => emulator.send(method, path, &body),
            None => emulator.request(method, path, "", ""),
        };
        let detail = answer.detail();
        assert_eq!(answer.status, status, "{path}: {detail}");
        assert!(detail.contains(words), "{path}: {detail}");
    }
}

#[test]
fn what_a_kind_of_station_does_not_have_is_refused_by_name() {
    let emulator = emulator();
    for (method, path, body, has) in [
        ("GET", "7/parameters", Value::Null, "parameters"),
        ("GET", "7/parameters/1004", Value::Null, "parameters"),
        ("GET", "7/samples", Value::Null, "samples"),
        ("GET", "7/samples.csv", Value::Null, "samples"),
        ("PUT", "7/power", json!({ "on": false }), "power"),
        ("GET", "7/switches", Value::Null, "switches"),
        ("GET", "5/objects", Value::Null, "objects"),
        ("GET", "5/objects/1017/0", Value::Null, "objects"),
        ("GET", "5/texts", Value::Null, "modules"),
        ("GET", "5/outputs/1/0/bit0", Value::Null, "modules"),
        ("PUT", "5/diagnosis", json!({}), "modules"),
    ] {
        let address = &path[..1];
        let state = emulator.get(&format!("/api/v1/stations/{address}"));
        assert_eq!(state["has"][has], json!(false), "{path}");
        let answer = emulator.send(method, &format!("/api/v1/stations/{path}"), &body);
        assert_eq!(answer.status, 409, "{path}: {}", answer.body);
        assert!(answer.detail().contains(has) || answer.detail().contains(address), "{}", answer.detail());
    }
}

#[test]
fn the_stream_of_a_station_tells_its_state_and_ends_with_it() {
    let emulator = emulator();
    let mut stream = emulator.stream("?address=7&kinds=state,news");
    let (event, state) = stream.next().unwrap();
    assert_eq!((event.as_str(), &state["process"][0]["octets_hex"]), ("state", &json!("00")));
    emulator.set("PUT", "/api/v1/stations/7/inputs/1/0/unsigned8", &json!({ "value": 9 }));
    stream.find("state", |state| state["process"][0]["octets_hex"] == json!("09"));
    emulator.request("DELETE", "/api/v1/stations/7", "", "");
    let mut last = Value::Null;
    while let Some((_, data)) = stream.next() {
        last = data;
    }
    assert_eq!(last["kind"], json!("removed"));
}

fn may_act(emulator: &Emulator, wanted: &[bool]) {
    let start = Instant::now();
    loop {
        let list = emulator.get("/api/v1/lines/line/faults");
        let told = list["faults"].as_array().unwrap().iter().map(|fault| fault["may_act"].as_bool().unwrap());
        if told.eq(wanted.iter().copied()) {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "{wanted:?}: {list}");
    }
}

/// Though no master says anything, HTTP and log tell when a fault may act.
#[test]
fn the_times_and_the_condition_of_a_fault_are_told_on_a_silent_line() {
    let gsd = format!("7,gsd={}/tests/gsd/remote_io.gsd", env!("CARGO_MANIFEST_DIR"));
    let emulator = Emulator::logging(&[
        "--station",
        &gsd,
        "--fault",
        "no-reply,from=100ms",
        "--fault",
        "no-reply,until=100ms",
        "--fault",
        "no-reply,while=7/1/0/bit0=1",
    ]);
    may_act(&emulator, &[true, false, false]);
    let input = "/api/v1/stations/7/inputs/1/0/bit0";
    emulator.set("PUT", input, &json!({ "value": 1 }));
    may_act(&emulator, &[true, false, true]);
    emulator.set("PUT", input, &json!({ "value": 0 }));
    may_act(&emulator, &[true, false, false]);
    let log = emulator.log().join("\n");
    for words in
        ["from=100ms: may act from now on", "until=100ms: acts no longer", "=1: may act", "=1: acts no"]
    {
        assert!(log.contains(words), "{words}: {log}");
    }

    let node = ["--link", "slcan-tcp:127.0.0.1:0", "--node", "5"];
    let times = ["--fault", "frame-lost,from=100ms", "--fault", "sdo-lost,until=100ms"];
    let emulator = Emulator::logging(&[node, times].concat());
    may_act(&emulator, &[true, false]);
    let log = emulator.log().join("\n");
    for words in ["from=100ms: may act from now on", "until=100ms: acts no longer"] {
        assert!(log.contains(words), "{words}: {log}");
    }
}
