//! DIP switches of an AG03/1 on CANopen over HTTP, and what else a node has of a station (FC-9).

use std::io::{Read, Write};

use serde_json::{Value, json};

use super::nodes::Master;
use super::panel::{Emulator, PATIENCE, State};

struct Rig {
    emulator: Emulator,
    master: Master,
}

impl Rig {
    fn start(nodes: &[&str]) -> Self {
        let nodes = nodes.iter().flat_map(|node| ["--node", node]);
        let arguments: Vec<_> = nodes.chain(["--link", "slcan-tcp:127.0.0.1:0"]).collect();
        let emulator = Emulator::with(&arguments);
        let place = emulator.terminal().to_str().unwrap().strip_prefix("slcan-tcp:").unwrap().to_owned();
        Self { emulator, master: Master::open(&place) }
    }

    fn put(&self, path: &str, body: &Value) -> Value {
        self.emulator.set("PUT", &format!("/api/v1/stations/{path}"), body)
    }

    /// Sets SW1 to SW8.
    fn switches(&self, node: u8, bits: u8) -> Value {
        let positions = (0..10).map(|bit| bit < 8 && bits >> bit.min(7) & 1 != 0).collect::<Vec<_>>();
        self.put(&format!("{node}/switches"), &json!({ "positions": positions }))
    }

    fn power(&self, node: u8, on: bool) -> Value {
        self.put(&format!("{node}/power"), &json!({ "on": on }))
    }
}

#[test]
fn switches_of_a_node_are_read_when_it_is_switched_on_and_give_it_its_number() {
    let mut rig = Rig::start(&["5", "6"]);
    assert_eq!(
        rig.switches(5, 9)["text"],
        json!("1001000 0 00: node number 9 from the next power-on, terminator off")
    );
    rig.power(5, false);
    rig.switches(5, 6);
    let refused = rig.emulator.send("PUT", "/api/v1/stations/5/power", &json!({ "on": true }));
    assert_eq!(refused.status, 409);
    let sentence = "the DIP switches say node number 6, which another node has; set them to a free one";
    assert!(refused.detail().contains(sentence), "{}", refused.body);
    rig.switches(5, 9);
    assert_eq!(rig.power(5, true), json!({ "power": "on" }));
    assert_eq!(rig.master.frame(0x709), "00");
    assert_eq!(rig.master.sdo(9, "4001210000000000"), "4F01210009000000", "2101h");
    assert_eq!(rig.emulator.request("GET", "/api/v1/stations/5", "", "").status, 404);
}

#[test]
fn a_factory_reset_of_a_node_by_its_switches_loads_defaults() {
    let mut rig = Rig::start(&["5"]);
    let v_pos = |rig: &mut Rig| rig.master.sdo(5, "4010240500000000");
    assert_eq!(rig.master.sdo(5, "2F1024054D000000"), "6010240500000000");
    assert_eq!(v_pos(&mut rig), "4F1024054D000000");
    let says = rig.switches(5, 0x81)["text"].as_str().unwrap().to_owned();
    assert!(says.contains("factory reset of all parameters"), "{says}");
    rig.power(5, false);
    assert_eq!(rig.power(5, true), json!({ "power": "factory_reset" }));
    let state = rig.emulator.get("/api/v1/stations/5");
    assert_eq!((&state["power"], &state["bus_state"]), (&json!("factory_reset"), &Value::Null));
    assert_eq!(state.led("bus orange")["text"], json!("alternates: reset"));
    rig.power(5, false);
    rig.switches(5, 5);
    rig.power(5, true);
    assert_eq!(rig.master.frame(0x705), "00");
    assert_eq!(v_pos(&mut rig), "4F1024051E000000");
}

/// The same from the command line: reset, then started as usual.
#[test]
fn a_factory_reset_of_a_node_from_the_command_line_is_in_its_image() {
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().to_str().unwrap();
    let start = |node: &str| {
        let link = ["--link", "slcan-tcp:127.0.0.1:0", "--state-dir", state];
        let emulator = Emulator::with(&[&["--node", node], &link[..]].concat());
        let place = emulator.terminal().to_str().unwrap().strip_prefix("slcan-tcp:").unwrap().to_owned();
        Rig { emulator, master: Master::open(&place) }
    };
    let v_pos = |rig: &mut Rig| rig.master.sdo(5, "4010240500000000");
    let mut rig = start("5");
    assert_eq!(rig.master.sdo(5, "2F1024054D000000"), "6010240500000000");
    drop(rig);
    let mut rig = start("5");
    assert_eq!(v_pos(&mut rig), "4F1024054D000000", "kept");
    drop(rig);
    let image = || std::fs::read(folder.path().join("ag03-1-node-005.eeprom")).unwrap();
    let before = image();
    let rig = start("5,reset=all");
    let node = rig.emulator.get("/api/v1/stations/5");
    assert_eq!((&node["power"], &node["bus_state"]), (&json!("factory_reset"), &Value::Null));
    let switches = rig.emulator.get("/api/v1/stations/5/switches");
    assert!(switches["text"].as_str().unwrap().contains("factory reset of all parameters"), "{switches}");
    let begin = std::time::Instant::now();
    while image() == before {
        assert!(begin.elapsed() < PATIENCE, "the image is as before");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    drop(rig);
    assert_eq!(v_pos(&mut start("5")), "4F1024051E000000");
}

#[test]
fn nodes_have_samples_a_table_of_them_and_their_parameters() {
    let rig = Rig::start(&["5", "6,device=ap10", "7,device=asda-a2"]);
    for (node, curve, object) in
        [(5, "position", "2410/5"), (6, "position", "5F10/0"), (7, "position", "6081/0")]
    {
        let path = format!("/api/v1/stations/{node}");
        let start = std::time::Instant::now();
        loop {
            let samples = rig.emulator.get(&format!("{path}/samples"));
            if samples.to_string().contains(curve) && !samples["samples"].as_array().is_none_or(Vec::is_empty)
            {
                break;
            }
            assert!(start.elapsed() < PATIENCE, "{node}: {samples}");
        }
        let table = rig.emulator.request("GET", &format!("{path}/samples.csv"), "", "");
        assert!(table.head.contains(&format!("filename=\"station-{node}.csv\"")), "{}", table.head);
        assert!(table.body.lines().count() > 1 && table.body.contains(curve), "{}", table.body);
        let value = rig.emulator.get(&format!("{path}/objects/{object}"))["value"].clone();
        assert!(value.is_number(), "{node} {object}: {value}");
    }
}

#[test]
fn frames_that_were_watched_are_a_capture() {
    let mut rig = Rig::start(&["5"]);
    let mut stream = rig.emulator.stream("?kinds=telegram");
    assert!(rig.master.sdo(5, "4001210000000000").starts_with("4F"));
    stream.find("telegram", |_| true);
    let start = std::time::Instant::now();
    loop {
        let mut connection = rig.emulator.connect();
        let head = "GET /api/v1/lines/line/capture.pcapng HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n";
        connection
            .write_all(head.replace("Host: a", &format!("Host: {}", rig.emulator.panel)).as_bytes())
            .unwrap();
        let mut answer = Vec::new();
        connection.read_to_end(&mut answer).unwrap();
        // The answer of 2101h.
        let octets = [0x4F, 0x01, 0x21, 0x00, 0x05, 0, 0, 0];
        if answer.windows(octets.len()).any(|part| part == octets) {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "{}", String::from_utf8_lossy(&answer));
    }
}
