//! HTTP control of a running emulator: what acts on a drive from outside, and what is refused.

use serde_json::{Value, json};

use crate::panel::{Answer, Emulator, State};

const INPUTS: &str = "/api/v1/stations/5/inputs";
const POWER: &str = "/api/v1/stations/5/power";

/// SW1 to SW10 from a number, SW1 = bit 0.
fn switches(emulator: &Emulator, bits: u16) {
    let positions: Vec<_> = (0..10).map(|bit| bits >> bit & 1 != 0).collect();
    emulator.set("PUT", "/api/v1/stations/5/switches", &json!({ "positions": positions }));
}

fn power(emulator: &Emulator, on: bool) -> Answer {
    emulator.send("PUT", POWER, &json!({ "on": on }))
}

#[test]
fn nothing_switches_a_drive_on_at_the_address_of_another() {
    let emulator = Emulator::with(&["--drive", "5", "--drive", "1,model=ag03"]);
    switches(&emulator, 1);
    // The switch of the supply is closed, so the supply decides.
    emulator.set("PATCH", INPUTS, &json!({ "control_supply_volts": 0 }));
    let before = emulator.get("/api/v1/stations/5");
    assert_eq!(before["power"], json!("off"));
    let inputs = emulator.get(INPUTS);
    for (method, path, body) in [
        ("PATCH", INPUTS, json!({ "control_supply_volts": 24, "blocked": true })),
        ("DELETE", INPUTS, Value::Null),
        ("POST", "/api/v1/stations/5/provoke", json!({ "fault": "A" })),
        ("PUT", POWER, json!({ "on": true })),
    ] {
        let refused = emulator.send(method, path, &body);
        assert_eq!(refused.status, 409, "{method} {path}: {}", refused.body);
        let sentence = "the DIP switches say address 1, which another station has; set them to a free one";
        assert_eq!(refused.detail(), sentence);
        assert_eq!(emulator.get(INPUTS), inputs, "{method} {path}");
    }
    switches(&emulator, 7);
    assert_eq!(emulator.send("DELETE", INPUTS, &Value::Null).status, 200);
    assert_eq!(emulator.get("/api/v1/stations/7")["power"], json!("on"));
    assert_eq!(emulator.get("/api/v1/stations/1")["power"], json!("on"), "it never noticed");
}

#[test]
fn the_switch_of_the_supply_and_its_voltage_are_two_things() {
    let emulator = Emulator::with(&["--drive", "5", "--drive", "1,model=ag03"]);
    let volts = || emulator.get(INPUTS)["control_supply_volts"].clone();
    emulator.set("PATCH", INPUTS, &json!({ "control_supply_volts": 20 }));
    assert_eq!(power(&emulator, true).json(), json!({ "power": "on" }));
    assert_eq!(volts(), json!(20.0), "it was on");
    power(&emulator, false);
    let off = emulator.get("/api/v1/stations/5");
    let volts_off = (off.input("control_supply_volts"), off.value("control_supply"));
    assert_eq!(volts_off, (&json!(20.0), &json!(0.0)));
    let only =
        json!([{ "reason": "SwitchedOff", "text": "the drive is switched off: switch its supply on" }]);
    assert_eq!(off["why"]["reasons"], only);
    // A voltage behind an open switch moves no drive to a foreign address.
    switches(&emulator, 1);
    emulator.set("PATCH", INPUTS, &json!({ "control_supply_volts": 21 }));
    emulator.set("DELETE", INPUTS, &Value::Null);
    emulator.set("PATCH", INPUTS, &json!({ "control_supply_volts": 19 }));
    assert_eq!(emulator.get("/api/v1/stations/5")["power"], json!("off"));
    switches(&emulator, 5);
    assert_eq!(power(&emulator, true).json(), json!({ "power": "on" }));
    assert_eq!(volts(), json!(19.0));
    assert_eq!(emulator.get("/api/v1/stations/5").value("control_supply"), &json!(19.0));
}

#[test]
fn a_factory_reset_needs_no_address_and_takes_none() {
    let emulator = Emulator::with(&["--drive", "5", "--drive", "1,model=ag03"]);
    // SW8, and the pattern that would be the address of the neighbour.
    switches(&emulator, 0x81);
    power(&emulator, false);
    assert_eq!(power(&emulator, true).json(), json!({ "power": "factory_reset" }));
    let state = emulator.get("/api/v1/stations/5");
    assert_eq!(state["address"], json!(5));
    assert_eq!(state.led("bus orange")["text"], json!("alternates: reset"));
    assert_eq!(emulator.get("/api/v1/stations/1")["power"], json!("on"));
    let reasons = state["why"]["reasons"].as_array().unwrap();
    assert_eq!((reasons.len(), &reasons[0]["reason"]), (1, &json!("FactoryReset")));
    power(&emulator, false);
    switches(&emulator, 5);
    assert_eq!(power(&emulator, true).json(), json!({ "power": "on" }));
    assert_eq!(emulator.get("/api/v1/stations")["stations"].as_array().unwrap().len(), 2);
}

#[test]
fn null_gives_two_inputs_back_to_the_plant_and_is_refused_for_all_others() {
    let emulator = Emulator::start();
    let before = emulator.get(INPUTS);
    let state = emulator.get("/api/v1/stations/5");
    let ranges = state["inputs"].as_array().unwrap();
    assert_eq!(ranges.len(), before.as_object().unwrap().len());
    for range in ranges {
        let input = range["input"].as_str().unwrap();
        let answer =
            emulator.send("PATCH", INPUTS, &json!({ "friction_torque_newton_metres": 1, input: null }));
        let nullable = range["may_be_null"] == json!(true);
        assert_eq!(nullable, ["stage_temperature_celsius", "dc_link_volts"].contains(&input), "{input}");
        if nullable {
            assert_eq!(answer.status, 200, "{input}: {}", answer.body);
            emulator.set("DELETE", INPUTS, &Value::Null);
            continue;
        }
        assert_eq!(answer.status, 422, "{input}: {}", answer.body);
        let sentence = "got null: null is not possible for this input; leave it out to keep its value";
        assert!(answer.detail().ends_with(sentence), "{}", answer.detail());
        assert!(answer.detail().starts_with(&format!("{input} must be ")), "{}", answer.detail());
        assert_eq!(emulator.get(INPUTS), before, "{input}");
    }
}

#[test]
fn an_input_that_the_model_does_not_have_is_refused() {
    for (model, input, value) in [
        ("ag03", "output_supply_volts", json!(24)),
        ("ag03", "encoder_fault", json!(true)),
        ("ag03", "encoder_fault", json!(false)),
        ("ag03-1", "enable", json!(true)),
    ] {
        let emulator = Emulator::with(&["--drive", &format!("5,model={model}")]);
        let refused = emulator.send("PATCH", INPUTS, &json!({ "blocked": true, input: value }));
        assert_eq!(refused.status, 409, "{model} {input}: {}", refused.body);
        assert!(refused.detail().starts_with("an AG03"), "{}", refused.detail());
        assert_eq!(emulator.get(INPUTS)["blocked"], json!(false));
    }
}
