//! What the log and the panel tell of stations and nodes that come, go, and are asked for without being there.

use std::time::Instant;

use serde_json::{Value, json};

use super::nodes::Master;
use super::panel::{Emulator, PATIENCE};

/// The lines with these words, in order.
fn lines<'a>(log: &'a [String], words: &str) -> Vec<&'a str> {
    log.iter().map(String::as_str).filter(|line| line.contains(words)).collect()
}

/// The events kept by the emulator whose text begins so.
fn told(emulator: &Emulator, begin: &str) -> Vec<String> {
    let events = emulator.get("/api/v1/events/recent");
    let texts = events["events"].as_array().unwrap().iter().map(|event| event["text"].as_str().unwrap());
    texts.filter(|text| text.starts_with(begin)).map(str::to_owned).collect()
}

/// Waits for such an event.
fn wait_for(emulator: &Emulator, begin: &str) -> Vec<String> {
    let start = Instant::now();
    loop {
        let told = told(emulator, begin);
        if !told.is_empty() {
            return told;
        }
        assert!(start.elapsed() < PATIENCE, "{begin}");
    }
}

fn remove(emulator: &Emulator, address: u8) {
    let path = format!("/api/v1/stations/{address}");
    assert_eq!(emulator.request("DELETE", &path, "", "").status, 204, "{path}");
}

#[test]
fn who_is_on_the_line_is_logged_and_a_fault_whose_station_goes_is_a_warning() {
    let gsd = format!("7,gsd={}/tests/gsd/remote_io.gsd", env!("CARGO_MANIFEST_DIR"));
    let emulator = Emulator::logging(&[
        "--drive",
        "5",
        "--drive",
        "6",
        "--station",
        &gsd,
        "--ppo-drive",
        "8",
        "--fault",
        "no-reply,station=6",
        "--fault",
        "late=2ms,station=5",
    ]);
    emulator.set("POST", "/api/v1/stations", &json!({"address": 9, "device": "ag03-1"}));
    for address in [7, 8, 6, 9] {
        remove(&emulator, address);
    }
    let log = emulator.log();
    let now = lines(&log, "on the line now: ");
    let who: Vec<_> = now.iter().map(|line| line.split_once("now: ").unwrap().1).collect();
    assert_eq!(who, ["5, 6, 7, 8, 9", "5, 6, 8, 9", "5, 6, 9", "5, 9", "5"], "{log:#?}");
    let gone = lines(&log, "which is not on the line");
    // With each change that leaves it without its station.
    assert_eq!(gone.len(), 2, "{log:#?}");
    assert!(
        gone[0].starts_with("WARN") && gone[0].contains("fault 'no-reply,station=6' is for station 6"),
        "{gone:?}"
    );
}

#[test]
fn who_is_on_the_bus_is_logged_and_a_fault_whose_node_goes_is_a_warning() {
    let emulator = Emulator::logging(&[
        "--node",
        "5",
        "--node",
        "6,device=ap10",
        "--link",
        "slcan-tcp:127.0.0.1:0",
        "--fault",
        "sdo-lost,node=6",
    ]);
    remove(&emulator, 6);
    emulator.set("POST", "/api/v1/stations", &json!({"address": 9, "device": "ap10"}));
    let log = emulator.log();
    let now = lines(&log, "on the bus now: ");
    let who: Vec<_> = now.iter().map(|line| line.split_once("now: ").unwrap().1).collect();
    assert_eq!(who, ["5 (ag03-1)", "5 (ag03-1), 9 (ap10)"], "{log:#?}");
    let gone = lines(&log, "which is not on the bus");
    assert_eq!(gone.len(), 1, "{log:#?}");
    assert!(
        gone[0].starts_with("WARN") && gone[0].contains("fault 'sdo-lost,node=6' is for node 6"),
        "{gone:?}"
    );
}

/// A master on the bus of an emulator.
fn master(emulator: &Emulator) -> Master {
    let place = emulator.terminal().to_str().unwrap();
    Master::open(place.strip_prefix("slcan-tcp:").unwrap())
}

#[test]
fn a_node_that_is_asked_but_not_there_is_told_once_in_the_log_and_in_the_panel() {
    const HINT: &str = "hint: node 9 is asked (SDO) but not there; nodes on this bus: 5, 6; change the node number in the \
         master's project or that of the node";
    let emulator = Emulator::logging(&["--node", "5", "--node", "6", "--link", "slcan-tcp:127.0.0.1:0"]);
    let mut bus = master(&emulator);
    for _ in 0..20 {
        bus.send("t60984000100000000000");
        bus.send("t00020109");
    }
    bus.send("t00020C0A");
    // What came before its answer has passed.
    bus.sdo(5, "4000100000000000");
    assert_eq!(wait_for(&emulator, "hint: node 9"), [HINT]);
    assert_eq!(wait_for(&emulator, "hint: node 10").len(), 1);
    // Once it is there it answers, and its number is told anew when it is gone.
    emulator.set("POST", "/api/v1/stations", &json!({"address": 9, "device": "ag03-1"}));
    bus.frame(0x709);
    bus.sdo(9, "4000100000000000");
    let log = emulator.log();
    assert_eq!(lines(&log, "hint: node 9").len(), 1, "{log:#?}");
}

#[test]
fn an_nmt_command_that_a_node_ignores_is_told_once() {
    let emulator = Emulator::logging(&["--node", "5", "--link", "slcan-tcp:127.0.0.1:0"]);
    let mut bus = master(&emulator);
    bus.sdo(5, "4000100000000000");
    bus.send("t00020705");
    bus.send("t00020705");
    let unknown = wait_for(&emulator, "NMT command 07h ignored: there is no such command; send 01h (start)");
    assert_eq!(unknown.len(), 1);
    emulator.set("PUT", "/api/v1/stations/5/power", &json!({"on": false}));
    bus.send("t00020105");
    bus.send("t00020105");
    let off = wait_for(&emulator, "NMT command 01h ignored: the node is switched off; switch its supply on");
    assert_eq!(off.len(), 1);
    let log = emulator.log();
    assert_eq!(lines(&log, "NMT command 01h ignored").len(), 1, "{log:#?}");
}

#[test]
fn a_load_at_a_drive_of_the_profile_is_told_when_it_changes() {
    let emulator = Emulator::logging(&["--drive", "5", "--ppo-drive", "7"]);
    for percent in [40.0, 40.0, 12.5] {
        emulator.set("PATCH", "/api/v1/stations/7/inputs", &json!({"load_percent": percent}));
    }
    wait_for(&emulator, "station 7: load changed from 40 % to 12.5 % of the rated torque");
    assert_eq!(told(&emulator, "station 7: load changed from").len(), 2);
    let log = emulator.log();
    assert_eq!(
        lines(&log, "station 7: load changed from 10 % to 40 % of the rated torque").len(),
        1,
        "{log:#?}"
    );
}

#[test]
fn an_event_told_before_the_stream_is_open_is_among_the_recent_ones_asked_for_behind_it() {
    let emulator = Emulator::with(&["--drives", "5-6"]);
    let faults = || -> Vec<Value> {
        let recent = emulator.get("/api/v1/events/recent");
        recent["events"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|event| event["kind"] == "fault")
            .cloned()
            .collect()
    };
    assert_eq!(faults(), Vec::<Value>::new());
    // Between an answer and the stream.
    emulator.set("POST", "/api/v1/stations/5/provoke", &json!({"fault": "F"}));
    let start = Instant::now();
    while faults().is_empty() {
        assert!(start.elapsed() < PATIENCE);
    }
    let mut stream = emulator.stream("?kinds=news");
    let between = faults();
    emulator.set("POST", "/api/v1/stations/6/provoke", &json!({"fault": "F"}));
    // The stream has only what came behind it; a page that asks behind its opening misses nothing and sees nothing twice.
    let behind = stream.find("news", |news| news["kind"] == "fault");
    assert_eq!((&between[0]["address"], &behind["address"]), (&json!(5), &json!(6)));
    let all = faults();
    assert_eq!(all.len(), 2);
    assert_eq!((&all[0]["number"], &all[1]["number"]), (&between[0]["number"], &behind["number"]));
    assert!(between[0]["number"].as_u64() < behind["number"].as_u64());
}
