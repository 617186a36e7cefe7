//! HTTP control of a running emulator: every endpoint, by what it does to the drive on the bus.

use crate::panel;
use crate::pty;

use panel::{Emulator, State};
use profidrive::profibus::ppo::{Ind, Inputs, JobId, Outputs, Pke, Pkw, Stw};
use pty::Master;
use serde_json::{Value, json};

/// Exchanges until the inputs are as wanted.
fn exchange_until(master: &mut Master, stw: u16, hsw: i32, wanted: impl Fn(Inputs<'_>) -> bool) {
    let start = std::time::Instant::now();
    let outputs = Outputs::octets(Pkw::ZERO, Stw::from_raw(stw), hsw);
    loop {
        let inputs = master.exchange(&outputs).unwrap();
        if wanted(Inputs::new(&inputs)) {
            return;
        }
        assert!(start.elapsed() < panel::PATIENCE, "{inputs:02X?}");
    }
}

fn enable(master: &mut Master) {
    exchange_until(master, 0x0000, 0, |inputs| inputs.zsw().bit(1));
    exchange_until(master, 0x003B, 0, |inputs| inputs.zsw().bit(2));
}

#[test]
fn the_state_of_a_drive_shows_what_the_master_has_made_of_it() {
    let emulator = Emulator::start();
    let state = emulator.get("/api/v1/stations/5");
    assert_eq!((&state["bus_state"], &state["owner_address"]), (&json!("WAIT-PRM"), &json!(null)));
    assert_eq!(state["exchanging"], json!(false));
    assert_eq!(state.led("bus orange")["glow"], json!("off"));
    assert_eq!(state["why"]["reasons"][0]["reason"], json!("NoDataExchange"));

    let mut master = Master::open(emulator.terminal());
    enable(&mut master);
    let state = emulator.get("/api/v1/stations/5");
    assert_eq!((&state["bus_state"], &state["owner_address"]), (&json!("DATA-EXCH"), &json!(2)));
    assert_eq!(state["exchanging"], json!(true));
    assert_eq!(state.led("bus orange")["glow"], json!("on"));
    assert_eq!(state.led("status green")["glow"], json!("on"));
    assert_eq!((&state["state"], &state["state_text"]), (&json!("enabled"), &json!("operation enabled")));
    assert_eq!(state.process("outputs")["octets_hex"], json!("00 00 00 00 00 00 00 00 00 3B 00 00 00 00"));
    assert_eq!(state.word("stw")["value"], json!(0x003B));
    let bit = &state.word("stw")["bits"][3];
    assert_eq!(
        (&bit["set"], &bit["name"], &bit["used"]),
        (&json!(true), &json!("enable operation"), &json!(true))
    );
    assert_eq!(state.word("zsw")["bits"][2]["set"], json!(true));
    assert_eq!(state.word("zsw")["bits"].as_array().unwrap().len(), 16);
    let position = state.entry("values", "key", "position");
    assert_eq!((&position["unit"], &position["value"]), (&json!("inc"), &json!(0)));
    assert_eq!(state["why"], json!({ "moving": false, "reasons": [], "next": "send STW 007B" }));
    assert_eq!(emulator.get("/api/v1/stations/5/parameters")["parameters"].as_array().unwrap().len(), 41);
    assert_eq!(state.value("control_supply"), &json!(24.0));
    assert_eq!(state.counter("faults"), &json!(0));
    assert_eq!(state["eeprom"], json!("in memory"));

    // A start beyond the limit: refused, and the panel says why.
    exchange_until(&mut master, 0x007B, 9_000_000, |inputs| inputs.zsw().bit(15));
    let state = emulator.wait_for("refused", |state| state["last_refusal"].is_object());
    let setpoint = |state: &Value| {
        let hsw = state.process("outputs").entry("entries", "name", "HSW");
        (hsw["value"].clone(), hsw["unit"].clone())
    };
    assert_eq!(setpoint(&state), (json!(9_000_000), json!("inc")));
    assert_eq!(state["last_refusal"]["reasons"][0]["reason"], json!("SetpointAboveUpperLimit"));
    assert!(state["last_refusal"]["text"].as_str().unwrap().starts_with("travel to 9000000 inc refused: "));
    assert_eq!(state["why"]["reasons"][0]["reason"], json!("SetpointAboveUpperLimit"), "{}", state["why"]);

    // The dialogue of the parameter channel.
    let job = Pkw::new(Pke::of_job(JobId::Read, 1018), Ind::from_raw(0), 0);
    master.job(job).unwrap();
    let state = emulator.get("/api/v1/stations/5");
    let said = |side: &str| state.process(side)["details"].as_str().unwrap().to_owned();
    assert!(said("outputs").ends_with("  PKW job: read PNU 1018 Calibration value"), "{}", said("outputs"));
    assert!(said("outputs").starts_with("13FA 0000 0000 0000"), "{}", said("outputs"));
    assert!(
        said("inputs").ends_with("  PKW reply: PNU 1018 Calibration value = 0 inc"),
        "{}",
        said("inputs")
    );
    assert!(said("inputs").starts_with("23FA "), "AK 2: {}", said("inputs"));

    exchange_until(&mut master, 0x0000, 30, |inputs| !inputs.zsw().bit(2));
    emulator.set("PUT", "/api/v1/stations/5/parameters/930", &json!({ "value": 1 }));
    let state = emulator.wait_for("in velocity mode", |state| setpoint(state).1 == json!("rpm"));
    assert_eq!(setpoint(&state), (json!(30), json!("rpm")));
}

#[test]
fn why_lists_what_keeps_a_drive_from_moving_and_the_words_to_send() {
    let emulator = Emulator::start();
    let why = emulator.get("/api/v1/stations/5/why");
    assert_eq!((&why["address"], &why["moving"]), (&json!(5), &json!(false)));
    assert_eq!(why["reasons"][0]["reason"], json!("NoDataExchange"));
    let mut master = Master::open(emulator.terminal());
    exchange_until(&mut master, 0x0000, 0, |inputs| inputs.zsw().bit(1));
    let why = emulator.get("/api/v1/stations/5/why");
    let reasons: Vec<_> = why["reasons"].as_array().unwrap().iter().map(|found| &found["reason"]).collect();
    assert_eq!(reasons[..3], ["OutputsZero", "Off2", "Off1"].map(|reason| json!(reason)).each_ref(), "{why}");
    let next = why["next"].as_str().unwrap();
    assert!(next.starts_with("send STW ") && why["text"].as_str().unwrap().ends_with(next), "{why}");
    enable(&mut master);
    exchange_until(&mut master, 0x007B, 100_000, |inputs| inputs.hiw() > 100);
    let why = emulator.get("/api/v1/stations/5/why");
    let moves = (&why["moving"], &why["reasons"], &why["next"], &why["text"]);
    assert_eq!(moves, (&json!(true), &json!([]), &json!(null), &json!("it moves")));
    let state = emulator.get("/api/v1/stations/5");
    assert_eq!((&state["moving"], &state["why"]["moving"]), (&json!(true), &json!(true)));
    assert_eq!(emulator.send("GET", "/api/v1/stations/9/why", &Value::Null).status, 404);
}

#[test]
fn a_block_in_mid_travel_makes_fault_b_and_the_master_acknowledges_it() {
    let emulator = Emulator::start();
    let mut master = Master::open(emulator.terminal());
    enable(&mut master);
    exchange_until(&mut master, 0x007B, 100_000, |inputs| inputs.hiw() > 100);
    emulator.set("PATCH", "/api/v1/stations/5/inputs", &json!({ "blocked": true }));
    exchange_until(&mut master, 0x007B, 100_000, |inputs| inputs.zsw().bit(3));
    let state = emulator.get("/api/v1/stations/5");
    assert_eq!(state["fault"], json!({ "fault": "B", "text": "B (shaft blocked)" }));
    let led = state.led("status green");
    assert_eq!((&led["blinks"], &led["glow"]), (&json!(2), &json!("blinking")));
    assert_eq!(state["history"][0]["text"], json!("B (shaft blocked)"));

    emulator.set("DELETE", "/api/v1/stations/5/inputs", &Value::Null);
    exchange_until(&mut master, 0x00FB, 0, |inputs| inputs.zsw().bit(6));
    let state = emulator.get("/api/v1/stations/5");
    assert_eq!((&state["fault"], &state["state_text"]), (&json!(null), &json!("turn-on disabled")));
}

/// The faults whose causes are there.
fn provoked_of(state: &Value) -> String {
    let faults = state["faults"].as_array().unwrap().iter();
    faults
        .filter(|fault| fault["provoked"] == json!(true))
        .map(|fault| fault["fault"].as_str().unwrap())
        .collect()
}

#[test]
fn every_fault_can_be_provoked_by_its_letter() {
    let emulator = Emulator::start();
    for fault in ["D", "E", "F", "G", "J"] {
        emulator.set("POST", "/api/v1/stations/5/provoke", &json!({ "fault": fault }));
        emulator.wait_for(fault, |state| state["fault"]["fault"] == json!(fault));
        let nominal = emulator.set("DELETE", "/api/v1/stations/5/inputs", &Value::Null);
        assert_eq!(nominal["battery_volts"], json!(3.0));
    }
    for (fault, provoked) in [("A", "A"), ("B", "AB"), ("C", "AB")] {
        emulator.set("POST", "/api/v1/stations/5/provoke", &json!({ "fault": fault }));
        let state = emulator.get("/api/v1/stations/5");
        assert_eq!(provoked_of(&state), provoked, "17 V give no current for C");
        assert_eq!(state["fault"]["fault"], json!("J"), "nothing turns");
    }
    for (drive, newton_metres) in [("5", 5.0), ("5,gear=24", 2.5), ("5,model=ag03,gear=24", 2.5)] {
        let emulator = Emulator::with(&["--drive", drive]);
        let inputs = emulator.set("POST", "/api/v1/stations/5/provoke", &json!({ "fault": "C" }));
        assert_eq!(inputs["friction_torque_newton_metres"], json!(newton_metres), "{drive}");
        assert_eq!(provoked_of(&emulator.get("/api/v1/stations/5")), "C", "{drive}");
    }
    let refused = emulator.send("POST", "/api/v1/stations/5/provoke", &json!({ "fault": "H" }));
    assert_eq!(refused.status, 422);
    let sentence = "'H' is no fault of this ag03-1; did you mean A? it has A, B, C, D, E, F, G, J";
    assert_eq!(refused.detail(), sentence);
}

#[test]
fn every_plant_input_is_set_by_itself_and_the_others_stay() {
    let emulator = Emulator::start();
    let mut expected = emulator.get("/api/v1/stations/5/inputs");
    for (name, value) in [
        ("control_supply_volts", json!(19.5)),
        ("output_supply_volts", json!(0.0)),
        ("battery_volts", json!(2.5)),
        ("load_torque_newton_metres", json!(-3.5)),
        ("friction_torque_newton_metres", json!(1.25)),
        ("blocked", json!(true)),
        ("ambient_temperature_celsius", json!(40.0)),
        ("stage_temperature_celsius", json!(80.5)),
        ("dc_link_volts", json!(30.0)),
        ("encoder_fault", json!(true)),
        ("internal_fault", json!(true)),
        ("stage_temperature_celsius", json!(null)),
        ("dc_link_volts", json!(null)),
    ] {
        expected[name] = value.clone();
        assert_eq!(
            emulator.set("PATCH", "/api/v1/stations/5/inputs", &json!({ name: value })),
            expected,
            "{name}"
        );
        let state = emulator.get("/api/v1/stations/5");
        for (name, value) in expected.as_object().unwrap() {
            assert_eq!(state.input(name), value, "{name}");
        }
    }
    let ag03 = Emulator::with(&["--drive", "5,model=ag03"]);
    assert_eq!(
        ag03.set("PATCH", "/api/v1/stations/5/inputs", &json!({ "enable": false }))["enable"],
        json!(false)
    );
    let ag03_state =
        ag03.wait_for("without enable input", |state| state.word("ssw")["bits"][10]["set"] == json!(true));
    assert_eq!(ag03_state.word("ssw")["bits"][10]["name"], json!("enable input"));
    assert_eq!(ag03_state.word("general_status")["bits"][4]["meaning"], json!("enable input not active"));
    let state = emulator.get("/api/v1/stations/5");
    assert_eq!(state.word("ssw")["bits"][10]["meaning"], json!("output stage not supplied"));
    for (emulator, input) in [(&ag03, "output_supply_volts"), (&ag03, "fault"), (&emulator, "enable")] {
        let answer = match input {
            "enable" => emulator.send("PATCH", "/api/v1/stations/5/inputs", &json!({ "enable": true })),
            "fault" => emulator.send("POST", "/api/v1/stations/5/provoke", &json!({ "fault": "J" })),
            _ => emulator.send("PATCH", "/api/v1/stations/5/inputs", &json!({ input: 24 })),
        };
        assert_eq!(answer.status, 409, "{input}");
        assert!(answer.detail().starts_with("an AG03"), "{}", answer.detail());
    }
}

#[test]
fn a_held_key_turns_the_shaft_until_it_is_released_and_not_in_data_exchange() {
    let emulator = Emulator::start();
    let keys = "/api/v1/stations/5/keys";
    let held = emulator.set("POST", keys, &json!({ "key": "key_2", "pressed": true }));
    let keys_held =
        json!({ "keys": [{ "key": "key_1", "pressed": false }, { "key": "key_2", "pressed": true }] });
    assert_eq!(held, keys_held);
    emulator.wait_for("turning", |state| state.value("position").as_i64() > Some(20));
    emulator.set("POST", keys, &json!({ "key": "key_2", "pressed": false }));
    let stopped = emulator.wait_for("stopped", |state| state.value("speed") == &json!(0));
    emulator.set("POST", keys, &json!({ "key": "key_1", "pressed": true }));
    emulator.wait_for("turning back", |state| {
        state.value("position").as_i64() < stopped.value("position").as_i64()
    });
    emulator.set("POST", keys, &json!({ "key": "key_1", "pressed": false }));
}

#[test]
fn switches_are_read_when_the_drive_is_switched_on_and_move_it_to_its_new_address() {
    let emulator = Emulator::with(&["--drives", "5-6"]);
    let positions =
        |address: u8| (0..10).map(|bit| address >> bit.min(7) & 1 != 0 && bit < 8).collect::<Vec<_>>();
    let put = |address| {
        let change = json!({ "positions": positions(address) });
        emulator.set("PUT", "/api/v1/stations/5/switches", &change)
    };
    let power = |address, on| {
        emulator.send("PUT", &format!("/api/v1/stations/{address}/power"), &json!({ "on": on }))
    };

    assert_eq!(put(9)["text"], json!("1001000 0 00: address 9 from the next power-on, terminator off"));
    assert_eq!(emulator.get("/api/v1/stations/5")["address"], json!(5), "not while it is on");
    assert_eq!(power(5, false).json(), json!({ "power": "off" }));
    let off = emulator.get("/api/v1/stations/5");
    assert_eq!((&off["power"], &off.led("status green")["glow"]), (&json!("off"), &json!("off")));
    let refused = emulator.send("PUT", "/api/v1/stations/5/parameters/1004", &json!({ "value": 50 }));
    assert_eq!((refused.status, refused.detail().contains("switch it on")), (409, true));

    put(6);
    let refused = power(5, true);
    assert_eq!(refused.status, 409);
    assert!(refused.detail().contains("address 6, which another station has"), "{}", refused.body);
    put(9);
    assert_eq!(power(5, true).json(), json!({ "power": "on" }));
    assert_eq!(emulator.get("/api/v1/stations/9")["switches"]["positions"], json!(positions(9)));
    assert_eq!(emulator.request("GET", "/api/v1/stations/5", "", "").status, 404);

    // SW8 with the pattern of all parameters.
    let reset = emulator.set("PUT", "/api/v1/stations/9/switches", &json!({ "positions": positions(0x81) }));
    let says = reset["text"].as_str().unwrap();
    assert!(says.contains("factory reset of all parameters") && says.ends_with("terminator off"), "{says}");
    power(9, false);
    power(9, true);
    let state = emulator.get("/api/v1/stations/9");
    assert_eq!(state["power"], json!("factory_reset"));
    assert_eq!(state.led("bus orange")["text"], json!("alternates: reset"));
}

#[test]
fn the_file_of_a_drive_that_was_moved_goes_to_no_other_and_the_refusal_names_the_drive() {
    let folder = tempfile::tempdir().unwrap();
    let emulator = Emulator::with(&["--state-dir", folder.path().to_str().unwrap()]);
    let write = |address, value| {
        let path = format!("/api/v1/stations/{address}/parameters/1004");
        emulator.set("PUT", &path, &json!({ "value": value }));
    };
    let v_pos =
        |address| emulator.get(&format!("/api/v1/stations/{address}/parameters/1004"))["value"].clone();
    write(5, 71);
    emulator.set("PUT", "/api/v1/stations/5/power", &json!({ "on": false }));
    let positions: Vec<_> = (0..10).map(|bit| bit == 1 || bit == 2).collect();
    emulator.set("PUT", "/api/v1/stations/5/switches", &json!({ "positions": positions }));
    emulator.set("PUT", "/api/v1/stations/5/power", &json!({ "on": true }));
    write(6, 72);

    let refused = emulator.send("POST", "/api/v1/stations", &json!({ "address": 5, "device": "ag03-1" }));
    assert_eq!(refused.status, 409);
    let detail = refused.detail();
    assert!(detail.contains("ag03-1-005.eeprom belongs to the drive at address 6"), "{detail}");
    assert!(detail.contains("move it back or remove it"), "{detail}");

    emulator.set("DELETE", "/api/v1/stations/6", &Value::Null);
    emulator.set("POST", "/api/v1/stations", &json!({ "address": 5, "device": "ag03-1" }));
    assert_eq!(v_pos(5), json!(72));
}

#[test]
fn drives_come_and_go_while_a_master_runs_another() {
    let emulator = Emulator::start();
    let mut master = Master::open(emulator.terminal());
    enable(&mut master);
    let added = emulator.send(
        "POST",
        "/api/v1/stations",
        &json!({ "address": 7, "device": "ag03", "gear_ratio": 24 }),
    );
    assert_eq!(added.status, 201);
    assert!(added.head.contains("location: /api/v1/lines/line/stations/7"), "{}", added.head);
    assert_eq!(
        (&added.json()["device"], &added.json()["product"]),
        (&json!("ag03"), &json!("AG03, gear 24:1"))
    );
    enable(&mut master);
    let bus = emulator.get("/api/v1/lines/line");
    assert_eq!(bus["stations"].as_array().unwrap().len(), 2);
    assert!(bus["stations"][0]["counters"]["replies"].as_u64() > Some(4));
    assert_eq!(bus["rate_bits_per_second"], json!(500_000));
    let taken = emulator.send("POST", "/api/v1/stations", &json!({ "address": 7, "device": "ag03-1" }));
    assert_eq!((taken.status, taken.detail().contains("address 7 is taken")), (409, true));

    assert_eq!(emulator.request("DELETE", "/api/v1/stations/7", "", "").status, 204);
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/7", "", "").status, 404);
    enable(&mut master);
    emulator.set("DELETE", "/api/v1/stations/5", &Value::Null);
    assert_eq!(emulator.get("/api/v1/stations")["stations"], json!([]));
    let none = emulator.request("GET", "/api/v1/stations/5", "", "");
    assert_eq!(none.detail(), "there is no station at address 5, nor at any other; add one first");
}

#[test]
fn faults_come_on_the_line_and_go_while_the_bus_runs() {
    let emulator = Emulator::start();
    let mut master = Master::open(emulator.terminal());
    let faults = "/api/v1/lines/line/faults";
    let first = emulator.send("POST", faults, &json!({ "fault": "noise=2,count=3" }));
    assert_eq!(first.status, 201);
    assert_eq!(
        first.json(),
        json!({ "number": 1, "fault": "noise=2,count=3", "injected": 0, "may_act": true })
    );
    // What a master makes of it is its concern: here it is only counted.
    let list = emulator.set(
        "PUT",
        faults,
        &json!({ "faults": ["late=1ms,station=5", "diag-announced,at=4000000000"] }),
    );
    let numbers: Vec<_> =
        list["faults"].as_array().unwrap().iter().map(|fault| fault["number"].as_u64().unwrap()).collect();
    assert_eq!(numbers, [2, 3]);
    enable(&mut master);
    let injected = emulator.get(faults);
    assert!(injected["faults"][0]["injected"].as_u64() > Some(2), "{injected}");
    assert_eq!(injected["faults"][1]["injected"], json!(0));
    assert_eq!(emulator.request("DELETE", &format!("{faults}/2"), "", "").status, 204);
    assert_eq!(emulator.request("DELETE", &format!("{faults}/2"), "", "").status, 404);
    assert_eq!(emulator.get("/api/v1/lines/line")["faults"].as_array().unwrap().len(), 1);
    emulator.set("DELETE", faults, &Value::Null);
    assert_eq!(emulator.get(faults), json!({ "faults": [] }));
    enable(&mut master);

    for (fault, sentence) in [
        ("flood", "fault 'flood': "),
        ("late", "a time such as 20ms"),
        ("", "fault ''"),
        ("no-reply,station=7", "is for station 7, which is not on the line; expected station 5"),
    ] {
        let refused = emulator.send("POST", faults, &json!({ "fault": fault }));
        assert_eq!(refused.status, 422, "{fault}");
        assert!(refused.detail().contains(sentence), "{}", refused.detail());
    }
    let too_many = emulator.send("PUT", faults, &json!({ "faults": vec!["no-reply"; 33] }));
    assert_eq!(too_many.status, 422);
    let one_wrong = emulator.send("PUT", faults, &json!({ "faults": ["no-reply", "x"] }));
    assert_eq!(
        (one_wrong.status, emulator.get(faults)),
        (422, json!({ "faults": [] })),
        "nothing is changed"
    );
}

#[test]
fn parameters_are_read_and_written_past_the_bus_by_its_rules() {
    let emulator = Emulator::start();
    let path = |pnu: &str| format!("/api/v1/stations/5/parameters/{pnu}").trim_end_matches('/').to_owned();
    let value = emulator.set("PUT", &path("1004"), &json!({ "value": 42 }));
    assert_eq!(
        value,
        json!({
            "key": "1004",
            "name": "v-Pos",
            "value": 42,
            "text": "42 rpm",
            "unit": "rpm",
        })
    );
    assert_eq!(emulator.get(&path(""))["parameters"].as_array().unwrap().len(), 41);
    assert_eq!(emulator.set("PUT", &path("1017"), &json!({ "value": -5000.0 }))["value"], json!(-5000));
    assert_eq!(emulator.get(&path("1017"))["text"], json!("-5000 inc"));
    assert_eq!(emulator.get(&path("945.3"))["value"], json!(0));

    // The master reads what was written.
    let mut master = Master::open(emulator.terminal());
    let job = Pkw::new(Pke::of_job(JobId::Read, 1004), Ind::from_raw(0), 0);
    assert_eq!(master.job(job).unwrap().word(), 42);

    for (method, pnu, value, status, sentence) in [
        ("PUT", "1004", json!(101), 422, "the value must be within 1 to 100, got 101"),
        ("PUT", "1004", json!(-1), 422, "PNU 1004 is a word, 0 to 65535; got -1"),
        ("PUT", "1017", json!(10_000_000_000_i64), 422, "the value must be within 32 bits"),
        ("PUT", "1027", json!(1), 409, "PNU 1027 (Device temperature): the parameter is read-only"),
        ("PUT", "1500", json!(1), 404, "PNU 1500: there is no parameter 1500"),
        ("PUT", "3000", json!(1), 400, "'3000' is no PNU; expected 0 to 2047"),
        ("PUT", "x", json!(1), 400, "'x' is no PNU"),
        ("PUT", "945", json!(1), 422, "needs an array access"),
        ("GET", "945", Value::Null, 422, "needs an array access"),
        ("GET", "945.10", Value::Null, 422, "10 elements counted from 0, got sub-index 10"),
        ("GET", "945.x", Value::Null, 400, "'945.x' is no PNU"),
        ("GET", "945?index=1", Value::Null, 400, "knows no parameter behind its '?'"),
        ("GET", "1004.0", Value::Null, 422, "no array"),
    ] {
        let answer = match method {
            "GET" => emulator.request("GET", &path(pnu), "", ""),
            _ => emulator.send("PUT", &path(pnu), &json!({ "value": value })),
        };
        assert_eq!(answer.status, status, "{pnu}: {}", answer.body);
        assert!(answer.detail().contains(sentence), "{pnu}: {}", answer.detail());
    }
    assert_eq!(master.job(job).unwrap().word(), 42, "nothing was changed");

    exchange_until(&mut master, 0x0000, 0, |inputs| inputs.zsw().bit(1));
    exchange_until(&mut master, 0x003B, 0, |inputs| inputs.zsw().bit(2));
    exchange_until(&mut master, 0x007B, 50_000, |inputs| inputs.hiw() > 10);
    let refused = emulator.send("PUT", &path("930"), &json!({ "value": 1 }));
    assert_eq!(refused.status, 409);
    assert!(
        refused.detail().starts_with("PNU 930 (Operating mode): not possible now: "),
        "{}",
        refused.detail()
    );
}

#[test]
fn the_stream_tells_states_refusals_with_reasons_and_telegrams_in_words() {
    let emulator = Emulator::with(&["--drives", "5-6"]);
    let mut all = emulator.stream("");
    let overview = all.find("state", |_| true);
    assert_eq!(overview["stations"].as_array().unwrap().len(), 2);
    let mut telegrams = emulator.stream("?kinds=telegram&address=5");
    let mut states = emulator.stream("?address=5&kinds=state&interval_milliseconds=20");
    assert_eq!(states.find("state", |_| true)["bus_state"], json!("WAIT-PRM"));

    let mut master = Master::open(emulator.terminal());
    let asked = telegrams.find("telegram", |telegram| telegram["direction"] == json!("heard"));
    assert!(asked["octets_hex"].as_str().is_some_and(|octets| octets.starts_with("68")), "{asked}");
    assert!(asked["text"].as_str().is_some_and(|text| text.starts_with("2 -> 5  Set_Prm: ")), "{asked}");
    assert_eq!(
        (&asked["from_address"], &asked["to_address"], &asked["mark"]),
        (&json!(2), &json!(5), &json!("plain"))
    );
    telegrams.find("telegram", |telegram| telegram["direction"] == json!("sent"));

    enable(&mut master);
    exchange_until(&mut master, 0x007B, 9_000_000, |inputs| inputs.zsw().bit(15));
    let refusal = all.find("news", |news| news["kind"] == json!("command_refused"));
    assert_eq!(
        (&refusal["address"], &refusal["reasons"][0]["reason"]),
        (&json!(5), &json!("SetpointAboveUpperLimit"))
    );
    exchange_until(&mut master, 0x003B, 5000, |inputs| !inputs.zsw().bit(13));
    let moving = states.find("state", |state| state["moving"] == json!(true));
    assert!(moving["parameters"].is_null(), "not in the stream");
    let later = states.find("state", |state| state.value("position").as_i64() > Some(100));
    assert!(later["time_seconds"].as_f64() > moving["time_seconds"].as_f64());

    // A state that does not change is sent all the same, so that the reader knows that the stream lives.
    let mut still = emulator.stream("?address=6&kinds=state");
    let times: Vec<f64> =
        (0..4).map(|_| still.find("state", |_| true)["time_seconds"].as_f64().unwrap()).collect();
    // The mean of three: a busy machine may be late with one.
    let passed = (times[3] - times[0]) / 3.0;
    assert!(passed >= 0.9, "{passed} s after nothing has happened: {times:?}");

    for (query, sentence) in [
        ("?kinds=states", "'states' is no kind of event; expected state, news, telegram"),
        ("?interval_milliseconds=1", "must be within 20 to 60000, got 1"),
        ("?address=127", "there is no station at address 127"),
        ("?address=9", "there is no station at address 9"),
        ("?adress=5", "unknown field `adress`"),
    ] {
        let answer = emulator.request("GET", &format!("/api/v1/events{query}"), "", "");
        assert!((400..500).contains(&answer.status), "{query}: {}", answer.status);
        assert!(answer.detail().contains(sentence), "{query}: {}", answer.detail());
    }
}

#[test]
fn telegrams_are_explained_in_the_mode_and_unit_of_the_drive_though_the_line_never_told() {
    let emulator = Emulator::start();
    let write = |pnu: u16, value: u16| {
        emulator.set("PUT", &format!("/api/v1/stations/5/parameters/{pnu}"), &json!({ "value": value }));
    };
    let mut master = Master::open(emulator.terminal());
    // What a subscriber is told of an exchange: the words of the request and of the reply.
    let mut words_of_exchange = |telegrams: &mut panel::Stream, pnu: u16| {
        let job = Pkw::new(Pke::of_job(JobId::Read, pnu), Ind::from_raw(0), 0);
        let outputs = Outputs::octets(job, Stw::from_raw(0x0040), 30);
        let replied = |inputs: [u8; 14]| u16::from_be_bytes([inputs[0], inputs[1]]) & 0x07FF == pnu;
        while !replied(master.exchange(&outputs).unwrap()) {}
        ["heard", "sent"].map(|direction| {
            let about = |telegram: &Value| {
                telegram["direction"] == json!(direction)
                    && telegram["text"].as_str().unwrap().contains(&format!("PNU {pnu}"))
            };
            telegrams.find("telegram", about)["text"].as_str().unwrap().to_owned()
        })
    };

    // Before anybody subscribes.
    write(930, 1);
    let mut telegrams = emulator.stream("?kinds=telegram&address=5");
    let [request, reply] = words_of_exchange(&mut telegrams, 1016);
    assert!(request.contains("STW 0040 (setpoint released)"), "{request}");
    assert!(reply.contains(" inc") && !reply.contains("or 0.01 mm"), "{reply}");

    // While somebody subscribes: from the very next telegram.
    write(930, 2);
    write(1012, 400);
    let [request, reply] = words_of_exchange(&mut telegrams, 1017);
    assert!(!request.contains("setpoint released"), "{request}");
    assert!(reply.contains(" mm") && !reply.contains(" inc"), "{reply}");
}

#[test]
fn the_stream_of_a_drive_ends_when_it_is_removed_and_says_so() {
    let emulator = Emulator::with(&["--drives", "5-6"]);
    let mut all = emulator.stream("");
    let mut told = ["state", "news", "state,news,telegram", "telegram"]
        .map(|kinds| (kinds, emulator.stream(&format!("?address=5&kinds={kinds}"))));
    emulator.set("DELETE", "/api/v1/stations/5", &Value::Null);
    for (kinds, stream) in &mut told {
        let mut last = None;
        while let Some((event, data)) = stream.next() {
            last = Some((event, data["kind"].clone(), data["address"].clone(), data["text"].clone()));
        }
        if kinds.contains("news") {
            let text = "station 5: there is no station any more; its stream ends here";
            assert_eq!(last, Some(("news".into(), json!("removed"), json!(5), json!(text))), "{kinds}");
        }
    }
    all.find("state", |state| state["stations"].as_array().unwrap().len() == 1);
    assert_eq!(emulator.request("GET", "/api/v1/events?address=5", "", "").status, 404);
}
