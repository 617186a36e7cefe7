//! `emulate --node ... --panel`: what HTTP does to a node, seen on the bus, and what the bus does, seen by HTTP.

use serde_json::{Value, json};

use super::nodes::Master;
use super::panel::{Emulator, State};

/// An emulator with a panel and nodes, and a master on their bus.
pub(crate) struct Rig {
    pub(crate) emulator: Emulator,
    pub(crate) master: Master,
}

impl Rig {
    pub(crate) fn start(nodes: &[&str]) -> Self {
        let nodes = nodes.iter().flat_map(|node| ["--node", node]);
        let arguments: Vec<_> = nodes.chain(["--link", "slcan-tcp:127.0.0.1:0"]).collect();
        let emulator = Emulator::with(&arguments);
        let place = emulator.terminal().to_str().unwrap().strip_prefix("slcan-tcp:").unwrap().to_owned();
        Self { emulator, master: Master::open(&place) }
    }

    pub(crate) fn get(&self, path: &str) -> Value {
        self.emulator.get(&format!("/api/v1/stations/{path}"))
    }

    pub(crate) fn set(&self, method: &str, path: &str, body: &Value) -> Value {
        self.emulator.set(method, &format!("/api/v1/stations/{path}"), body)
    }

    pub(crate) fn refused(&self, method: &str, path: &str, body: &Value, status: u16, says: &str) {
        let answer = self.emulator.send(method, &format!("/api/v1/stations/{path}"), body);
        assert_eq!(answer.status, status, "{method} {path} {body}: {answer:?}");
        assert!(answer.detail().contains(says), "{method} {path} {body}: {}", answer.detail());
    }

    /// The number that a node answers to an SDO read with.
    pub(crate) fn read(&mut self, node: u16, object: &str) -> u32 {
        let answer = self.master.sdo(node, &format!("40{object}00000000"));
        assert!(answer.starts_with('4'), "{object}: {answer}");
        u32::from_str_radix(&answer[8..16], 16).unwrap().swap_bytes()
    }

    /// Waits until the state is as wanted; the device runs in real time.
    pub(crate) fn wait_for(&self, node: u16, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = std::time::Instant::now();
        loop {
            let state = self.get(&node.to_string());
            if wanted(&state) {
                return state;
            }
            assert!(start.elapsed() < super::panel::PATIENCE, "never {what}: {state}");
        }
    }
}

#[test]
fn every_node_is_listed_with_its_device_state_and_display() {
    let rig = Rig::start(&["5", "6,device=ap10", "7,device=asda-a2"]);
    rig.wait_for(6, "the end of its display test", |state| state.row(0) != "88888888");
    let listed = rig.emulator.get("/api/v1/stations");
    let nodes = listed["stations"].as_array().unwrap();
    let of = |name: &str| nodes.iter().map(|node| node[name].clone()).collect::<Vec<_>>();
    assert_eq!(of("address"), [5, 6, 7]);
    assert_eq!(of("device"), ["ag03-1", "ap10", "asda-a2"]);
    assert_eq!(of("bus"), ["canopen"; 3]);
    assert_eq!(of("bus_state"), ["PRE-OPERATIONAL"; 3]);
    assert_eq!(of("exchanging"), [false; 3]);
    assert_eq!(of("power"), ["on"; 3]);
    assert_eq!(nodes[0]["display"]["rows"], json!([]));
    assert_eq!(nodes[0]["display"]["leds"][1]["glow"], "blinking");
    assert_eq!((nodes[1].row(0), nodes[1].row(1)), ("0", "---"));
    assert_eq!(nodes[2].row(0), "    0");
    assert_eq!(rig.emulator.get("/api/v1/lines/line")["rate_bits_per_second"], 500_000);
    let lines = rig.emulator.get("/api/v1/lines");
    assert_eq!((&lines["lines"][0]["line"], &lines["lines"][0]["bus"]), (&json!("line"), &json!("canopen")));
    rig.refused(
        "PUT",
        "9/power",
        &json!({"on": true}),
        404,
        "there is no station at address 9; there are stations at 5, 6, 7",
    );
    rig.refused("PUT", "128/power", &json!({"on": true}), 400, "'128' is no address; expected 0 to 127");
}

/// Code and error register of an EMCY frame.
fn emcy(frame: &str) -> (u16, u8) {
    let code = u16::from_str_radix(&frame[..4], 16).unwrap().swap_bytes();
    (code, u8::from_str_radix(&frame[4..6], 16).unwrap())
}

#[test]
fn a_fault_of_an_ag03_is_an_emcy_and_in_1003h_and_goes_when_it_is_reset() {
    // Those that follow at once; A, B and C need a shaft that is commanded to turn.
    for (fault, code, register) in [
        ("D", 0x4310, 0x09),
        ("E", 0x7300, 0x81),
        ("F", 0xFF01, 0x81),
        ("G", 0x3210, 0x05),
        ("J", 0xFF09, 0x05),
    ] {
        let mut rig = Rig::start(&["5"]);
        rig.master.send("t00020105");
        rig.set("POST", "5/provoke", &json!({"fault": fault}));
        assert_eq!(emcy(&rig.master.frame(0x085)), (code, register), "fault {fault}");
        assert_eq!(rig.read(5, "031001") & 0xFFFF, u32::from(code), "fault {fault}");
        let state = rig.get("5");
        assert_eq!(state["history"][0]["code"], format!("{code:04X}h"));
        assert_eq!(rig.get("5/objects/1001/0")["value"], register);
        assert_eq!(state["state"], "fault");
        assert_eq!(state["fault"]["fault"], fault);
        assert_eq!(state.fault(fault)["provoked"], true);
        assert!(state["why"]["reasons"].to_string().contains("FAULT"), "{}", state["why"]);
        // It stays latched when its cause is gone, until the master resets it.
        rig.set("DELETE", "5/inputs", &Value::Null);
        assert_eq!(rig.read(5, "011000"), u32::from(register));
        // The message comes before the answer.
        rig.master.send("t60582B40600080000000");
        assert_eq!(emcy(&rig.master.frame(0x085)), (0, 0), "fault {fault}");
        assert_eq!(rig.read(5, "011000"), 0);
    }
}

#[test]
fn what_acts_on_an_ag03_while_it_shall_turn_makes_faults_a_b_and_c() {
    for (fault, code, register) in [("A", 0x3120, 0x05), ("B", 0x7121, 0x21)] {
        let mut rig = Rig::start(&["5"]);
        rig.master.send("t00020105");
        rig.set("POST", "5/provoke", &json!({"fault": fault}));
        // Target 100000, then switch on, enable, start.
        rig.master.sdo(5, "237A6000A0860100");
        for word in ["0600", "0700", "0F01", "1F01"] {
            let answer = rig.master.sdo(5, &format!("2B406000{word}0000"));
            assert!(answer.starts_with("60"), "{word}: {answer}");
        }
        rig.master.sdo(5, "2B4060000F000000");
        rig.master.sdo(5, "2B4060001F000000");
        assert_eq!(emcy(&rig.master.frame(0x085)), (code, register), "fault {fault}");
    }
}

#[test]
fn keys_and_supplies_act_on_an_ag03() {
    let mut rig = Rig::start(&["5"]);
    let before = rig.read(5, "646000").cast_signed();
    let keys = rig.set("POST", "5/keys", &json!({"key": "key_1", "pressed": true}));
    assert_eq!(keys["keys"][0], json!({"key": "key_1", "pressed": true}));
    let start = std::time::Instant::now();
    while rig.read(5, "646000").cast_signed() == before {
        assert!(start.elapsed() < super::panel::PATIENCE, "the key does not turn the shaft");
    }
    rig.set("POST", "5/keys", &json!({"key": "key_1", "pressed": false}));

    let inputs =
        rig.set("PATCH", "5/inputs", &json!({"output_supply_volts": 0, "stage_temperature_celsius": 50}));
    assert_eq!(
        (&inputs["output_supply_volts"], &inputs["stage_temperature_celsius"]),
        (&json!(0.0), &json!(50.0))
    );
    // 6041h bit 4, voltage enabled.
    assert_eq!(rig.read(5, "416000") & 0x10, 0);
    let inputs = rig.set("DELETE", "5/inputs", &Value::Null);
    assert_eq!(
        (&inputs["output_supply_volts"], &inputs["stage_temperature_celsius"]),
        (&json!(24.0), &Value::Null)
    );
    assert_eq!(rig.read(5, "416000") & 0x10, 0x10);

    for (body, says) in [
        (json!({"output_supply_volts": 61}), "output_supply_volts must be a number within 0 to 60, got 61"),
        (json!({"blocked": 1}), "blocked must be true or false, got 1"),
        (json!({"blocked": true, "bloked": true}), "did you mean blocked?"),
        (json!({"enable": true}), "'enable' is no input of this ag03-1"),
        (json!({"battery_volts": null}), "must be a number within 0 to 10, got null"),
    ] {
        rig.refused("PATCH", "5/inputs", &body, 422, says);
    }
    assert_eq!(rig.get("5/inputs")["blocked"], false, "refused as a whole");
    rig.refused("POST", "5/provoke", &json!({"fault": "d"}), 422, "did you mean D?");
    rig.refused("POST", "5/provoke", &json!({"fault": "H"}), 422, "it has A, B, C, D, E, F, G, J");
    rig.refused("POST", "5/keys", &json!({"key": "key1", "pressed": true}), 422, "did you mean key_1?");
}

#[test]
fn a_node_that_is_switched_off_is_silent_and_boots_when_it_is_switched_on() {
    let mut rig = Rig::start(&["5", "6,device=ap10", "7,device=asda-a2"]);
    for (node, boot_up) in [(5, 0x705), (6, 0x706), (7, 0x707)] {
        let power = format!("{node}/power");
        assert_eq!(rig.set("PUT", &power, &json!({"on": false}))["power"], "off");
        let state = rig.get(&node.to_string());
        assert_eq!((&state["bus_state"], &state["power"]), (&Value::Null, &json!("off")));
        rig.refused("PUT", &format!("{node}/objects/1017/0"), &json!({"value": 10}), 409, "switched off");
        assert_eq!(rig.set("PUT", &power, &json!({"on": true}))["power"], "on");
        assert_eq!(rig.master.frame(boot_up), "00");
        // Not once more while it is on.
        rig.set("PUT", &power, &json!({"on": true}));
        assert_eq!(rig.get(&node.to_string())["bus_state"], "PRE-OPERATIONAL");
    }
    rig.set("PUT", "7/power", &json!({"on": false}));
    rig.refused("POST", "7/provoke", &json!({"fault": "011"}), 409, "switched off");
}

#[test]
fn the_shaft_the_battery_and_the_keys_of_an_ap10_are_seen_on_the_bus_and_on_its_display() {
    let mut rig = Rig::start(&["6,device=ap10"]);
    rig.set("PATCH", "6/inputs", &json!({"shaft_revolutions": -2.5}));
    assert_eq!(rig.read(6, "046000").cast_signed(), -2200);
    rig.wait_for(6, "its position behind the display test", |state| state.row(0) == "-2200");
    for (fault, code, shown) in [
        ("battery-critical", 0xFF20, "battery critical"),
        ("battery-empty", 0x3200, "battery empty"),
        ("speed", 0xFF12, ""),
    ] {
        rig.set("POST", "6/provoke", &json!({"fault": fault}));
        assert_eq!(emcy(&rig.master.frame(0x086)), (code, 0x81), "{fault}");
        assert_eq!(rig.read(6, "031001") & 0xFFFF, u32::from(code), "{fault}");
        let display = rig.get("6")["display"].clone();
        assert!(display["signs"].to_string().contains(shown), "{fault}: {display}");
        rig.set("DELETE", "6/inputs", &Value::Null);
        assert_eq!(emcy(&rig.master.frame(0x086)), (0, 0), "{fault}");
    }
    assert_eq!(rig.get("6/inputs")["shaft_revolutions"], -2.5, "the shaft stays where it is");
    // Acknowledged by hand; then the star key shows number and rate, and held it opens the menu.
    let key = |rig: &Rig, key: &str, pressed: bool| {
        rig.set("POST", "6/keys", &json!({"key": key, "pressed": pressed}))
    };
    key(&rig, "up", true);
    key(&rig, "up", false);
    key(&rig, "star", true);
    assert_eq!(rig.read(6, "195F00") & 1 << 13, 1 << 13, "5F19h: star key");
    assert_eq!(rig.get("6").row(0), "ID 6");
    let menu = rig.wait_for(6, "in the menu", |state| state.row(0) != "ID 6");
    key(&rig, "star", false);
    assert_ne!(menu.row(0), "-2200", "{menu}");
    rig.refused("POST", "6/keys", &json!({"key": "down", "pressed": true}), 422, "it has left, up, star");
    rig.refused("POST", "6/provoke", &json!({"fault": "battery-emty"}), 422, "did you mean battery-empty?");
}

#[test]
fn an_alarm_of_an_asda_is_an_emcy_in_603fh_and_on_its_panel() {
    let mut rig = Rig::start(&["7,device=asda-a2"]);
    rig.set("POST", "7/provoke", &json!({"fault": "011"}));
    let frame = rig.master.frame(0x087);
    assert_eq!((emcy(&frame).0, &frame[6..10]), (0x7305, "1100"));
    assert_eq!(rig.read(7, "3F6000") & 0xFFFF, 0x7305);
    assert_eq!(rig.read(7, "031001"), 0x0011_7305);
    let state = rig.get("7");
    assert_eq!(state.row(0), "AL011");
    assert_eq!(state["history"][0]["text"], "encoder error");
    assert!(state["why"]["reasons"].to_string().contains("alarm AL011: encoder error"), "{}", state["why"]);
    rig.set("PATCH", "7/inputs", &json!({"blocked": true}));
    assert_eq!(rig.get("7/inputs")["blocked"], true);
    rig.set("DELETE", "7/inputs", &Value::Null);
    assert_eq!(rig.get("7/inputs")["blocked"], false);
    rig.master.sdo(7, "2B40600080000000");
    rig.wait_for(7, "reset", |state| state.row(0) == "    0");
    // Its button takes an alarm back.
    rig.set("POST", "7/provoke", &json!({"fault": "011", "provoked": true}));
    rig.wait_for(7, "the alarm", |state| state.row(0) == "AL011");
    rig.set("POST", "7/provoke", &json!({"fault": "011", "provoked": false}));
    rig.wait_for(7, "no alarm", |state| state.row(0) == "    0");
    rig.refused("POST", "7/provoke", &json!({"fault": "010"}), 422, "did you mean 0");
    rig.refused(
        "POST",
        "7/keys",
        &json!({"key": "star", "pressed": true}),
        422,
        "mode, shift, up, down, set",
    );
}

#[test]
fn the_stream_tells_states_news_and_frames_of_a_node() {
    let mut rig = Rig::start(&["5", "6,device=ap10"]);
    let mut stream = rig.emulator.stream("?address=6&kinds=state,news,telegram&interval_milliseconds=20");
    assert_eq!(stream.find("state", |_| true)["address"], 6);
    rig.set("POST", "6/provoke", &json!({"fault": "battery-critical"}));
    let news = stream.find("news", |news| news["kind"] == "emcy");
    let text = "EMCY FF20h sent, battery critical; error register 81h, generic error, manufacturer";
    assert_eq!((&news["address"], &news["text"]), (&json!(6), &json!(text)));
    stream.find("state", |state| state["warning"].to_string().contains("battery"));
    rig.master.sdo(6, "4000100000000000");
    let request = stream.find("telegram", |telegram| telegram["text"].as_str().unwrap().starts_with("606"));
    assert_eq!(
        (&request["octets_hex"], &request["to_address"]),
        (&json!("40 00 10 00 00 00 00 00"), &json!(6))
    );
    assert_eq!(
        (&request["line"], &request["from_address"], &request["direction"]),
        (&json!("line"), &json!(null), &json!("heard"))
    );
    assert!(request["text"].as_str().unwrap().contains("SDO"), "in words: {request}");
    let answer = stream.find("telegram", |telegram| telegram["text"].as_str().unwrap().starts_with("586"));
    assert_eq!((&answer["from_address"], &answer["direction"]), (&json!(6), &json!("sent")));
    let mut all = rig.emulator.stream("");
    assert_eq!(all.find("state", |_| true)["stations"].as_array().unwrap().len(), 2);
    for query in ["?address=9", "?address=0", "?kinds=frame", "?interval_milliseconds=1"] {
        let answer = rig.emulator.request("GET", &format!("/api/v1/events{query}"), "", "");
        assert!((400..500).contains(&answer.status), "{query}: {answer:?}");
    }
}

#[test]
fn events_of_before_are_told_to_who_comes_late() {
    let rig = Rig::start(&["5", "7,device=asda-a2"]);
    let news = |query: &str| -> Vec<Value> {
        rig.emulator.get(&format!("/api/v1/events/recent{query}"))["events"].as_array().unwrap().clone()
    };
    rig.set("POST", "7/provoke", &json!({"fault": "011"}));
    let start = std::time::Instant::now();
    while !news("?address=7").iter().any(|event| event["kind"] == "emcy") {
        assert!(start.elapsed() < super::panel::PATIENCE, "{:?}", news(""));
    }
    let all = news("");
    let numbers: Vec<_> = all.iter().map(|event| event["number"].as_u64().unwrap()).collect();
    assert!(numbers.is_sorted_by(|one, next| one < next), "{numbers:?}");
    assert!(all.iter().any(|event| event["address"] == 5 && event["kind"] == "nmt"), "{all:?}");
    let emcy = news("?address=7").into_iter().find(|event| event["kind"] == "emcy").unwrap();
    assert!(emcy["text"].as_str().unwrap().contains("7305h"), "{emcy}");
    assert!(news("?address=5").iter().all(|event| event["address"] != 7));
    // The stream tells them with the same numbers.
    let mut stream = rig.emulator.stream("?kinds=news");
    rig.set("PUT", "5/power", &json!({"on": false}));
    rig.set("PUT", "5/power", &json!({"on": true}));
    let (_, told) = stream.next().unwrap();
    assert!(
        news("").iter().any(|event| event["number"] == told["number"] && event["text"] == told["text"]),
        "{told}"
    );
    for (query, status) in [
        ("?line=cellar", 404),
        ("?address=0", 422),
        ("?address=128", 422),
        ("?since=3", 400),
        ("?address=x", 400),
    ] {
        let answer = rig.emulator.request("GET", &format!("/api/v1/events/recent{query}"), "", "");
        assert_eq!(answer.status, status, "{query}: {answer:?}");
    }
}

#[test]
fn what_an_ap10_has_confirmed_and_where_its_shaft_is_survive_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().to_str().unwrap();
    for round in 0..5_i32 {
        let emulator = Emulator::with(&[
            "--node",
            "6,device=ap10",
            "--link",
            "slcan-tcp:127.0.0.1:0",
            "--state-dir",
            state,
        ]);
        let place = emulator.terminal().to_str().unwrap().strip_prefix("slcan-tcp:").unwrap().to_owned();
        let mut rig = Rig { master: Master::open(&place), emulator };
        if round > 0 {
            assert_eq!(rig.get("6/inputs")["shaft_revolutions"], f64::from(round - 1) + 0.5, "round {round}");
            assert_eq!(rig.read(6, "046000"), 0, "calibrated there, round {round}");
        }
        rig.set("PATCH", "6/inputs", &json!({"shaft_revolutions": f64::from(round) + 0.5}));
        // 2002h = 1: the zero point is here. Confirmed, it is on the disk; dropped, the emulator is killed.
        assert_eq!(rig.master.sdo(6, "2F02200001000000"), "6002200000000000");
    }
}

/// FC-11
#[test]
fn a_node_whose_image_has_a_number_that_is_taken_is_no_twin_unless_it_shall_be() {
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().to_str().unwrap();
    let arguments = ["--node", "5", "--link", "slcan-tcp:127.0.0.1:0", "--state-dir", state];
    let emulator = Emulator::with(&arguments);
    let place = emulator.terminal().to_str().unwrap().strip_prefix("slcan-tcp:").unwrap().to_owned();
    let mut rig = Rig { master: Master::open(&place), emulator };
    let add = |rig: &Rig, body: Value| rig.emulator.send("POST", "/api/v1/stations", &body);
    let remove = |rig: &Rig, node: &str| {
        let path = format!("/api/v1/stations/{node}");
        assert_eq!(rig.emulator.send("DELETE", &path, &Value::Null).status, 204, "{node}");
    };
    assert_eq!(add(&rig, json!({"address": 7, "device": "ap10"})).status, 201);
    assert_eq!(rig.master.frame(0x707), "00");
    // 5F0Ah:1 := 12, saved.
    assert_eq!(rig.master.sdo(7, "2F0A5F010C000000"), "600A5F0100000000");
    assert_eq!(rig.master.sdo(7, "2310100173617665"), "6010100100000000");
    remove(&rig, "7");
    assert_eq!(add(&rig, json!({"address": 12, "device": "ag03-1"})).status, 201);
    let refused = add(&rig, json!({"address": 7, "device": "ap10"}));
    let sentence = "its EEPROM has the node number 12, which another node has; remove that one";
    assert!(refused.status == 409 && refused.detail().contains(sentence), "{refused:?}");
    remove(&rig, "12");
    let added = add(&rig, json!({"address": 7, "device": "ap10"}));
    assert_eq!((added.status, &added.json()["address"]), (201, &json!(12)), "{added:?}");
}

#[test]
fn faults_come_and_go_while_the_bus_runs_and_are_counted() {
    let mut rig = Rig::start(&["5", "6,device=ap10"]);
    let bus = "/api/v1/lines/line/faults";
    assert_eq!(rig.emulator.get(bus), json!({"faults": []}));
    let added = rig.emulator.send("POST", bus, &json!({"fault": "sdo-abort=08000020,node=6,count=2"}));
    assert_eq!(added.status, 201, "{added:?}");
    let refusal = "8000100020000008";
    let read = "4000100000000000";
    assert_eq!((rig.master.sdo(6, read), rig.master.sdo(6, read)), (refusal.to_owned(), refusal.to_owned()));
    assert!(rig.master.sdo(6, read).starts_with("43"), "twice and no more");
    assert!(rig.master.sdo(5, read).starts_with("43"));
    let listed =
        json!({"number": 1, "fault": "sdo-abort=08000020,count=2,node=6", "injected": 2, "may_act": true});
    assert_eq!(rig.emulator.get(bus)["faults"], json!([listed]));
    assert_eq!(rig.emulator.get("/api/v1/lines/line")["faults"], json!([listed]));

    let all = json!({"faults": ["tpdo-short,rate=0.5,seed=3", "frame-lost,id=585"]});
    let replaced = rig.emulator.set("PUT", bus, &all);
    assert_eq!(replaced["faults"].as_array().unwrap().len(), 2, "{replaced}");
    rig.master.send(&format!("t6058{read}"));
    assert!(rig.master.sdo(6, read).starts_with("43"), "of node 5 nobody hears an answer");
    assert_eq!(rig.emulator.get(bus)["faults"][1]["injected"], 1);
    let number = rig.emulator.get(bus)["faults"][1]["number"].clone();
    assert_eq!(rig.emulator.send("DELETE", &format!("{bus}/{number}"), &Value::Null).status, 204);
    assert!(rig.master.sdo(5, read).starts_with("43"));
    assert_eq!(rig.emulator.send("DELETE", bus, &Value::Null).status, 204);

    // 32 damaged frames in a row take a node off the bus; it comes back.
    rig.emulator.set("PUT", bus, &json!({"faults": ["frame-damaged,node=5,count=32"]}));
    rig.master.send(&format!("t6058{read}"));
    let start = std::time::Instant::now();
    // A fault is counted when it changes its frame, the error frame when the bus has carried it.
    while rig.emulator.get(bus)["faults"][0]["injected"] != 32
        || rig.emulator.get("/api/v1/lines/line")["error_frames"].as_u64().unwrap() < 32
    {
        assert!(start.elapsed() < super::panel::PATIENCE);
    }

    for (body, says) in [
        (json!({"fault": "no-reply"}), "'no-reply' is no fault of a node"),
        (json!({"fault": "sdo-lost,node=9"}), "is for node 9, which is not on the bus"),
    ] {
        let answer = rig.emulator.send("POST", bus, &body);
        assert_eq!(answer.status, 422, "{answer:?}");
        assert!(answer.detail().contains(says), "{}", answer.detail());
    }
    assert_eq!(rig.emulator.send("DELETE", &format!("{bus}/99"), &Value::Null).status, 404);
}

#[test]
fn a_node_leaves_operational_and_browns_out_by_itself() {
    let mut rig = Rig::start(&["7,device=ap10"]);
    let bus = "/api/v1/lines/line/faults";
    rig.master.send("t00020107");
    rig.wait_for(7, "OPERATIONAL", |state| state["bus_state"] == "OPERATIONAL");
    rig.emulator.set("PUT", bus, &json!({"faults": ["pre-operational,at=2"]}));
    // TPDO 2 after each SYNC.
    rig.master.send("t0800");
    rig.master.frame(0x287);
    assert_eq!(rig.get("7")["bus_state"], "OPERATIONAL");
    rig.master.send("t0800");
    rig.wait_for(7, "PRE-OPERATIONAL", |state| state["bus_state"] == "PRE-OPERATIONAL");
    rig.emulator.set("PUT", bus, &json!({"faults": ["brown-out=20ms,at=1"]}));
    rig.master.send("t60784000100000000000");
    assert_eq!(rig.master.frame(0x707), "00", "no answer, but a boot-up");
    assert!(rig.master.sdo(7, "4000100000000000").starts_with("43"));
}

#[test]
fn nodes_come_and_go_while_the_bus_runs() {
    let mut rig = Rig::start(&["5"]);
    let add = |rig: &Rig, body: &Value| rig.emulator.send("POST", "/api/v1/stations", body);
    let added = add(&rig, &json!({"address": 6, "device": "asda-a2", "mode": "half"}));
    assert_eq!(added.status, 201, "{added:?}");
    assert!(added.head.contains("location: /api/v1/lines/line/stations/6"), "{added:?}");
    for (body, status, says) in [
        (json!({"address": 6, "device": "ag03-1"}), 409, "the number 6 is taken"),
        (json!({"address": 7, "device": "ap11"}), 422, "did you mean ap10?"),
        (
            json!({"address": 7, "device": "ap10", "gear_ratio": 24}),
            422,
            "gear_ratio is for the device ag03-1 only, not for ap10",
        ),
        (
            json!({"address": 7, "device": "ag03-1", "gear_ratio": 12}),
            422,
            "gear '12' is unknown; expected 24 or 48",
        ),
        (json!({"address": 128, "device": "ag03-1"}), 422, "node number 128 is outside 1 to 127"),
    ] {
        let answer = add(&rig, &body);
        assert_eq!(answer.status, status, "{body}: {answer:?}");
        assert!(answer.detail().contains(says), "{body}: {}", answer.detail());
    }
    // The boot-up of a node that comes is on the bus.
    assert_eq!(rig.master.frame(0x706), "00");
    assert_eq!(rig.read(6, "012100"), 0x0B, "P1-01");
    assert_eq!(rig.emulator.get("/api/v1/stations")["stations"].as_array().unwrap().len(), 2);
    // Two of one number: both answer.
    assert_eq!(add(&rig, &json!({"address": 6, "device": "ap10", "twin": true})).status, 201);
    assert_eq!(rig.master.frame(0x706), "00");
    rig.master.send("t60684000100000000000");
    let answers = [rig.master.frame(0x586), rig.master.frame(0x586)];
    assert_ne!(answers[0], answers[1], "{answers:?}");
    for _ in 0..2 {
        assert_eq!(rig.emulator.send("DELETE", "/api/v1/stations/6", &Value::Null).status, 204);
    }
    rig.refused(
        "DELETE",
        "6",
        &Value::Null,
        404,
        "there is no station at address 6; there are stations at 5",
    );
}

#[test]
fn nodes_take_part_in_a_bus_that_another_process_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("can0").display().to_string();
    let host = Emulator::with(&["--node", "5", "--link", &format!("slcan-pty:{path}")]);
    let guest = Emulator::with(&["--node", "6,device=ap10", "--link", &format!("slcan-tty:{path}")]);
    assert_eq!(guest.terminal().display().to_string(), format!("slcan-tty:{path}"));
    for (node, here, there) in [("6", &guest, &host), ("5", &host, &guest)] {
        let frames = || there.get("/api/v1/lines/line")["frames"].as_u64().unwrap();
        let before = frames();
        for on in [false, true] {
            here.set("PUT", &format!("/api/v1/stations/{node}/power"), &json!({"on": on}));
        }
        let start = std::time::Instant::now();
        while frames() == before {
            assert!(start.elapsed() < super::panel::PATIENCE, "the boot-up of node {node} is not heard");
        }
    }
}

#[test]
fn why_a_node_does_not_move_is_said_on_request() {
    let rig = Rig::start(&["5", "6,device=ap10", "7,device=asda-a2"]);
    for (node, says) in [("5", "PRE-OPERATIONAL"), ("7", "no mode of operation is chosen")] {
        let why = rig.get(&format!("{node}/why"));
        assert_eq!(why["moving"], false);
        assert!(why["text"].as_str().unwrap().contains(says), "{why}");
        assert!(!why["reasons"].as_array().unwrap().is_empty());
        assert_eq!(rig.get(node)["why"]["reasons"], why["reasons"], "the page says the same");
    }
    let why = rig.get("6/why");
    assert_eq!((&why["moving"], &why["reasons"]), (&json!(null), &json!([])), "it is no drive");
    rig.refused(
        "GET",
        "9/why",
        &Value::Null,
        404,
        "there is no station at address 9; there are stations at 5, 6, 7",
    );
}

#[test]
fn faults_on_purpose_change_what_their_node_sends() {
    let emulator = Emulator::with(&[
        "--node",
        "5",
        "--node",
        "6,device=ap10",
        "--link",
        "slcan-tcp:127.0.0.1:0",
        "--fault",
        "sdo-abort=08000020,node=6",
        "--fault",
        "boot-up-twice,node=6",
        "--quirk",
        "sdo-unknown=cia-301",
    ]);
    let place = emulator.terminal().to_str().unwrap().strip_prefix("slcan-tcp:").unwrap().to_owned();
    let mut rig = Rig { master: Master::open(&place), emulator };
    assert_eq!(rig.master.sdo(6, "4000100000000000"), "8000100020000008");
    assert!(rig.master.sdo(5, "4000100000000000").starts_with("43"), "the other node is sound");
    // An unknown command: 05040001h instead of 06010000h, and only of the device that has this quirk.
    assert_eq!(rig.master.sdo(5, "E000100000000000"), "8000100001000405");
    rig.master.send("t00028106");
    assert_eq!((rig.master.frame(0x706), rig.master.frame(0x706)), ("00".to_owned(), "00".to_owned()));
}
