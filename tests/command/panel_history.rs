//! Who comes late sees over HTTP what was: events, curves, telegrams.

use crate::panel;
use crate::pty;

use core::time::Duration;
use std::fs;
use std::io::{Read, Write};
use std::thread;
use std::time::Instant;

use panel::{Emulator, PATIENCE, State};
use profidrive::host::capture;
use profidrive::profibus::ppo::{Outputs, Pkw, Stw};
use pty::Master;
use serde_json::{Value, json};

/// Exchanges with this control word and setpoint until the drive is as wanted.
fn exchange_until(
    emulator: &Emulator,
    master: &mut Master,
    stw: u16,
    hsw: i32,
    wanted: impl Fn(&Value) -> bool,
) {
    let start = Instant::now();
    loop {
        for _ in 0..5 {
            master.exchange(&Outputs::octets(Pkw::ZERO, Stw::from_raw(stw), hsw)).unwrap();
        }
        let state = emulator.get("/api/v1/stations/5");
        if wanted(&state) {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "{state}");
    }
}

#[test]
fn events_of_before_are_told_with_their_numbers() {
    let emulator = Emulator::with(&["--drives", "5-6"]);
    emulator.set("POST", "/api/v1/stations/5/provoke", &json!({"fault": "D"}));
    emulator.set("POST", "/api/v1/stations/6/provoke", &json!({"fault": "F"}));
    emulator.wait_for("in fault", |state| state["fault"]["fault"] == json!("D"));
    let start = Instant::now();
    let faults = |path: &str| -> Vec<(Value, String)> {
        let events = emulator.get(path)["events"].clone();
        let numbers: Vec<_> =
            events.as_array().unwrap().iter().map(|event| event["number"].as_u64()).collect();
        assert!(numbers.is_sorted_by(|one, next| one < next), "{numbers:?}");
        let faults = events.as_array().unwrap().iter().filter(|event| event["kind"] == json!("fault"));
        faults.map(|event| (event["address"].clone(), event["text"].as_str().unwrap().into())).collect()
    };
    while faults("/api/v1/events/recent").len() < 2 {
        assert!(start.elapsed() < PATIENCE);
    }
    let of_5 = faults("/api/v1/events/recent?address=5");
    assert_eq!(of_5.len(), 1, "{of_5:?}");
    assert!(of_5[0].1.contains("fault D (output stage too hot)"), "{of_5:?}");
    for (query, status) in [
        ("?address=127", 422),
        ("?since=3", 400),
        ("?address=x", 400),
        ("?after=9223372036854775807", 200),
        ("?after=9223372036854775808", 400),
    ] {
        assert_eq!(emulator.request("GET", &format!("/api/v1/events/recent{query}"), "", "").status, status);
    }
}

#[test]
fn a_travel_of_before_is_in_the_samples_and_in_the_table_with_its_target() {
    let emulator = Emulator::start();
    let mut master = Master::open(emulator.terminal());
    exchange_until(&emulator, &mut master, 0x0000, 0, |state| state["bus_state"] == json!("DATA-EXCH"));
    exchange_until(&emulator, &mut master, 0x003B, 1000, |state| state["state"] == json!("enabled"));
    exchange_until(&emulator, &mut master, 0x007B, 1000, |state| {
        state["state_text"] == json!("travel job active")
    });
    // The bus has another setpoint meanwhile: the target of the job stays.
    exchange_until(&emulator, &mut master, 0x007B, -77, |state| {
        let (Some(position), Some(to_go)) = (state.value("position").as_i64(), state.value("to_go").as_i64())
        else {
            return false;
        };
        assert_eq!((state.value("target").as_i64(), position + to_go), (Some(1000), 1000));
        state.process("outputs").entry("entries", "name", "HSW")["value"] == json!(-77)
    });
    exchange_until(&emulator, &mut master, 0x007B, -77, |state| state.value("position") == &json!(1000));
    exchange_until(&emulator, &mut master, 0x007B, -77, |state| {
        state.value("target").is_null() && state.value("to_go").is_null()
    });
    thread::sleep(Duration::from_millis(500));

    let recent = emulator.get("/api/v1/stations/5/samples");
    let samples = recent["samples"].as_array().unwrap();
    let on_the_way = |sample: &&Value| sample["target"] == json!(1000) && sample["speed"] != json!(0);
    assert!(samples.iter().filter(on_the_way).count() > 2, "{samples:?}");
    assert_eq!(samples.last().unwrap()["position"], json!(1000));
    assert!(samples.len() < 100, "a drive at rest takes no room, got {}", samples.len());

    let table = emulator.request("GET", "/api/v1/stations/5/samples.csv", "", "");
    assert!(
        table.head.contains("content-disposition: attachment; filename=\"station-5.csv\""),
        "{}",
        table.head
    );
    let mut rows = table.body.lines();
    let columns = rows.next().unwrap();
    assert_eq!(columns.split(',').next(), Some("time_seconds"));
    let place = |key: &str| columns.split(',').position(|column| column == key).unwrap();
    let (position, target) = (place("position"), place("target"));
    let count = columns.split(',').count();
    assert!(rows.clone().all(|row| row.split(',').count() == count), "{}", table.body);
    let cells = |row: &str| -> Vec<String> { row.split(',').map(str::to_owned).collect() };
    assert!(rows.clone().any(|row| cells(row)[target] == "1000"), "{}", table.body);
    assert_eq!(cells(rows.next_back().unwrap())[position], "1000", "{}", table.body);
    assert_eq!(emulator.request("GET", "/api/v1/stations/9/samples.csv", "", "").status, 404);
}

#[test]
fn telegrams_that_were_watched_are_a_capture_with_events_as_comments() {
    let emulator = Emulator::start();
    let mut stream = emulator.stream("?kinds=telegram");
    let mut master = Master::open(emulator.terminal());
    exchange_until(&emulator, &mut master, 0x0000, 0, |state| state["bus_state"] == json!("DATA-EXCH"));
    let shown = stream.find("telegram", |_| true);
    emulator.set("POST", "/api/v1/stations/5/provoke", &json!({"fault": "D"}));
    exchange_until(&emulator, &mut master, 0x0000, 0, |state| state["fault"]["fault"] == json!("D"));

    let mut answer = Vec::new();
    let start = Instant::now();
    let packets = loop {
        let mut connection = emulator.connect();
        let head = format!(
            "GET /api/v1/lines/line/capture.pcapng HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n",
            emulator.panel
        );
        connection.write_all(head.as_bytes()).unwrap();
        answer.clear();
        connection.read_to_end(&mut answer).unwrap();
        let body = answer.windows(4).position(|octets| octets == b"\r\n\r\n").unwrap() + 4;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("saved.pcapng");
        fs::write(&path, &answer[body..]).unwrap();
        let packets: Vec<_> = capture::read(&path).unwrap().map(Result::unwrap).collect();
        let remarked =
            |packet: &capture::Packet| packet.comment.as_deref().is_some_and(|text| text.contains("fault D"));
        if packets.iter().any(remarked) {
            break packets;
        }
        assert!(start.elapsed() < PATIENCE, "{packets:?}");
    };
    let first: Vec<_> = packets[0].octets.iter().map(|octet| format!("{octet:02X}")).collect();
    assert_eq!(shown["octets_hex"], json!(first.join(" ")));
}
