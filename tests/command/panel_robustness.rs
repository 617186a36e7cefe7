//! What hostile, careless and slow clients of the panel get, while a master runs the drive undisturbed.

use crate::panel;
use crate::pty;

use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use core::time::Duration;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use panel::{Answer, Emulator, PATIENCE};
use profidrive::profibus::ppo::{Outputs, Pkw, Stw};
use pty::Master;
use serde_json::json;

/// A master that exchanges data all the time on a thread of its own.
struct Busy {
    end: Arc<AtomicBool>,
    exchanges: Arc<AtomicU64>,
    thread: JoinHandle<u64>,
}

impl Busy {
    /// Returns when it runs.
    fn start(terminal: PathBuf, stw: impl Fn(u64) -> u16 + Send + 'static) -> Self {
        let (running, runs) = mpsc::channel();
        let end = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&end);
        let exchanges = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&exchanges);
        let thread = thread::spawn(move || {
            let mut master = Master::open(&terminal);
            let mut exchanges = 0;
            while !ended.load(Ordering::SeqCst) {
                let outputs = Outputs::octets(Pkw::ZERO, Stw::from_raw(stw(exchanges)), 0);
                master.exchange(&outputs).expect("the emulator is gone");
                exchanges += 1;
                counted.store(exchanges, Ordering::SeqCst);
                // Only the first is waited for.
                let _ = running.send(());
            }
            exchanges
        });
        runs.recv().expect("no exchange was answered");
        Self { end, exchanges, thread }
    }

    /// Ends it: every exchange was answered, and how many there were.
    fn end(self) -> u64 {
        self.end.store(true, Ordering::SeqCst);
        self.thread.join().expect("an exchange was not answered")
    }
}

#[test]
fn every_wrong_request_is_refused_with_a_sentence_and_changes_nothing() {
    let emulator = Emulator::start();
    let json_type = "Content-Type: application/json\r\n";
    let inputs = "/api/v1/stations/5/inputs";
    let before = emulator.get(inputs);
    for (method, path, head, body, status, sentence) in [
        // Malformed, of the wrong type, of the wrong media type.
        ("PATCH", inputs, json_type, "", 400, "the body is no JSON: it is empty, expected an object {...}"),
        ("PATCH", inputs, json_type, "{", 400, "EOF"),
        ("PATCH", inputs, json_type, r#"{"blocked": tru}"#, 400, "expected ident"),
        ("PATCH", inputs, json_type, r#"{"blocked": true} x"#, 400, "trailing"),
        ("PATCH", inputs, json_type, "{\u{fffd}", 400, "key must be a string"),
        ("PATCH", inputs, json_type, "[]", 422, "must be a JSON object"),
        ("PATCH", inputs, json_type, r#" "blocked""#, 422, "must be a JSON object"),
        ("PUT", "/api/v1/stations/5/power", json_type, "[true]", 422, "must be a JSON object"),
        ("PATCH", inputs, json_type, r#"{"blocked": 1}"#, 422, "must be true or false, got 1"),
        ("PATCH", inputs, json_type, r#"{"battery_volts": "3"}"#, 422, "must be a number within 0 to 10"),
        ("PATCH", inputs, json_type, r#"{"blocked": true, "blocked": false}"#, 422, "duplicate field"),
        ("PATCH", inputs, "", r#"{"blocked": true}"#, 415, "Content-Type"),
        ("PATCH", inputs, "Content-Type: text/plain\r\n", r#"{"blocked": true}"#, 415, "Content-Type"),
        // Unknown fields and names.
        ("PATCH", inputs, json_type, r#"{"blocked": true, "voltage": 24}"#, 422, "'voltage' is no input"),
        (
            "POST",
            "/api/v1/stations/5/keys",
            json_type,
            r#"{"key": "key_3", "pressed": true}"#,
            422,
            "'key_3' is no key of this ag03-1; did you mean key_1? it has key_1, key_2",
        ),
        ("POST", "/api/v1/stations/5/keys", json_type, r#"{"key": "key_1"}"#, 422, "missing field `pressed`"),
        // Out of range; the right half of a wrong change is not made.
        (
            "PATCH",
            inputs,
            json_type,
            r#"{"blocked": true, "battery_volts": 10.1}"#,
            422,
            "within 0 to 10, got 10.1",
        ),
        ("PATCH", inputs, json_type, r#"{"control_supply_volts": -0.1}"#, 422, "within 0 to 60, got -0.1"),
        ("PATCH", inputs, json_type, r#"{"load_torque_newton_metres": 1e300}"#, 422, "within -1000 to 1000"),
        ("PATCH", inputs, json_type, r#"{"battery_volts": 1e999}"#, 400, "out of range"),
        ("PATCH", inputs, json_type, r#"{"battery_volts": NaN}"#, 400, "expected value"),
        ("PATCH", inputs, json_type, r#"{"stage_temperature_celsius": 201}"#, 422, "within -50 to 200"),
        ("PATCH", inputs, json_type, r#"{"dc_link_volts": -1}"#, 422, "within 0 to 100"),
        (
            "PUT",
            "/api/v1/stations/5/switches",
            json_type,
            r#"{"positions": [true]}"#,
            422,
            "must have 10 values",
        ),
        (
            "POST",
            "/api/v1/stations",
            json_type,
            r#"{"address": 127, "device": "ag03-1"}"#,
            422,
            "address 127 is outside 0 to 126",
        ),
        (
            "POST",
            "/api/v1/stations",
            json_type,
            r#"{"address": 300, "device": "ag03-1"}"#,
            422,
            "address 300 is outside 0 to 126",
        ),
        (
            "POST",
            "/api/v1/stations",
            json_type,
            r#"{"address": 9, "device": "ag03-1", "gear_ratio": 36}"#,
            422,
            "gear '36' is unknown; expected 24 or 48",
        ),
        (
            "POST",
            "/api/v1/stations",
            json_type,
            r#"{"address": 9, "device": "ag04"}"#,
            422,
            "did you mean ag03?",
        ),
        // Drives and things that are not there.
        (
            "PATCH",
            "/api/v1/stations/6/inputs",
            json_type,
            r#"{"blocked": true}"#,
            404,
            "there are stations at 5",
        ),
        (
            "PATCH",
            "/api/v1/stations/128/inputs",
            json_type,
            r#"{"blocked": true}"#,
            400,
            "'128' is no address",
        ),
        ("GET", "/api/v1/stations/%00", "", "", 400, "is no address"),
        ("GET", "/api/v1/stations/%ff", "", "", 400, "UTF-8"),
        ("GET", "/api/v1/stations/05x", "", "", 400, "'05x' is no address"),
        ("GET", "/api/v2/stations", "", "", 404, "the API is described at /api/v1/openapi.json"),
        ("GET", "/api/v1/stations/5/", "", "", 404, "there is nothing at"),
        ("GET", "/api/v1/lines/cellar", "", "", 404, "there is no line 'cellar'; there is line"),
        ("GET", "/api/v1/lines/cellar/stations/5", "", "", 404, "there is no line 'cellar'; there is line"),
        ("GET", "/api/v1/events?line=cellar", "", "", 404, "there is no line 'cellar'; there is line"),
        // What the interface was before.
        ("GET", "/api/v1/drives/5", "", "", 404, "there is nothing at"),
        ("GET", "/api/v1/bus", "", "", 404, "there is nothing at"),
        (
            "DELETE",
            "/api/v1/lines/line",
            "",
            "",
            405,
            "does not take DELETE; the header Allow says what it takes",
        ),
        // Other web sites, and names that lead here.
        ("GET", "/api/v1/stations", "Host: example.com\r\n", "", 403, "Host must be localhost"),
        ("GET", "/api/v1/stations", "Host: 127.0.0.1.example.com:80\r\n", "", 403, "Host must be localhost"),
        ("GET", "/api/v1/stations", "Host: a\r\nHost: localhost\r\n", "", 403, "Host must be localhost"),
        (
            "GET",
            "http://example.com/api/v1/stations",
            "Host: localhost\r\n",
            "",
            403,
            "Host must be localhost",
        ),
        ("GET", "/", "Host: example.com\r\n", "", 403, "Host must be localhost"),
        ("DELETE", inputs, "Origin: http://example.com\r\n", "", 403, "other web sites are refused"),
        ("DELETE", inputs, "Origin: null\r\n", "", 403, "other web sites are refused"),
        ("DELETE", inputs, "Origin: http://127.0.0.1:1\r\n", "", 403, "other web sites are refused"),
        (
            "GET",
            "/api/v1/events",
            "Origin: http://localhost:3000\r\n",
            "",
            403,
            "other web sites are refused",
        ),
        ("OPTIONS", inputs, "Origin: http://example.com\r\n", "", 403, "other web sites are refused"),
    ] {
        let answer = emulator.request(method, path, head, body);
        assert_eq!(answer.status, status, "{method} {path} {head}{body}: {}", answer.body);
        assert!(answer.detail().contains(sentence), "{method} {path} {head}{body}: {}", answer.detail());
        assert!(!answer.head.contains("access-control-"), "{}", answer.head);
    }
    assert_eq!(emulator.get(inputs), before);
    assert_eq!(emulator.get("/api/v1/stations")["stations"].as_array().unwrap().len(), 1);

    // What a browser on the page sends, and a name that cannot be another's.
    let origin = format!("Origin: http://{}\r\n", emulator.panel);
    assert_eq!(emulator.request("DELETE", inputs, &origin, "").status, 200);
    assert_eq!(emulator.request("GET", "/api/v1/lines/line", "Host: localhost\r\n", "").status, 200);
}

#[test]
fn what_is_no_http_is_turned_away() {
    let emulator = Emulator::start();
    for octets in [
        &b"\x68\x05\x05\x68\x85\x82\x6d\x3c\x3e\xee\x16"[..],
        b"GET\r\n\r\n",
        b"\0\0\0\0\r\n\r\n",
        b"GET /api/v1/stations HTTP/9.9\r\n\r\n",
        b"GET /api/v1/stations HTTP/1.1\r\nHost: localhost\r\nContent-Length: x\r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    ] {
        let mut stream = emulator.connect();
        stream.write_all(octets).unwrap();
        stream.shutdown(std::net::Shutdown::Write).unwrap();
        let answer = Answer::read(stream);
        assert!(answer.head.is_empty() || (400..500).contains(&answer.status), "{octets:?}: {answer:?}");
    }
    let without_host = emulator.raw(b"GET /api/v1/stations HTTP/1.0\r\n\r\n");
    assert_eq!(without_host.status, 403);
}

#[test]
fn huge_heads_and_bodies_are_refused_and_not_kept() {
    let emulator = Emulator::start();
    let busy = Busy::start(emulator.terminal().into(), |_| 0);
    let huge = "x".repeat(1 << 20);
    let body = format!("{{\"fault\": \"{huge}\"}}");
    let answer =
        emulator.request("POST", "/api/v1/lines/line/faults", "Content-Type: application/json\r\n", &body);
    assert_eq!(answer.status, 413, "{answer:?}");
    // A body that says to be huge, and one that never says how long it is.
    let head = format!(
        "POST /api/v1/lines/line/faults HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\n",
        emulator.panel
    );
    let announced = emulator.raw(format!("{head}Content-Length: 99999999999\r\n\r\n").as_bytes());
    assert_eq!(announced.status, 413, "{announced:?}");
    let chunks = format!("{head}Transfer-Encoding: chunked\r\n\r\n");
    let mut stream = emulator.connect();
    stream.write_all(chunks.as_bytes()).unwrap();
    while stream
        .write_all(b"1000\r\n")
        .and_then(|()| stream.write_all(&[b'x'; 0x1000]))
        .and_then(|()| stream.write_all(b"\r\n"))
        .is_ok()
    {}
    // A head without an end.
    let mut stream = emulator.connect();
    stream.write_all(b"GET / HTTP/1.1\r\n").unwrap();
    while stream.write_all(format!("X-Filler: {huge}\r\n").as_bytes()).is_ok() {}

    assert!(memory_of(&emulator) < 64 << 20, "{} octets", memory_of(&emulator));
    assert_eq!(emulator.request("GET", "/api/v1/lines/line", "", "").status, 200);
    assert!(busy.end() > 0);
}

#[test]
fn a_client_that_dribbles_is_cut_off() {
    let emulator = Emulator::start();
    let busy = Busy::start(emulator.terminal().into(), |_| 0);
    let dribble = |first: String| {
        let mut stream = emulator.connect();
        stream.write_all(first.as_bytes()).unwrap();
        let mut reader = stream.try_clone().unwrap();
        let answered = thread::spawn(move || {
            let mut octets = Vec::new();
            let _ = reader.read_to_end(&mut octets);
            String::from_utf8(octets).unwrap()
        });
        thread::spawn(move || {
            // An octet now and then, as long as somebody takes it.
            while stream.write_all(b"x").is_ok() {
                thread::sleep(Duration::from_millis(50));
            }
        });
        answered
    };
    let start = Instant::now();
    let head = dribble("GET / HTTP/1.1\r\nX-Slow: ".into());
    let body = dribble(format!(
        "PATCH /api/v1/stations/5/inputs HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: 4000\r\n\r\n",
        emulator.panel
    ));
    let silent = dribble(String::new());
    assert_eq!(head.join().unwrap().lines().next().unwrap_or_default(), "", "no head, no answer");
    let refused = body.join().unwrap();
    assert!(refused.starts_with("HTTP/1.1 408"), "{refused}");
    assert!(refused.contains("the request took longer than 5s"), "{refused}");
    let _ = silent.join().unwrap();
    assert!(start.elapsed() < PATIENCE);
    assert!(busy.end() > 0);
}

#[test]
fn a_thousand_idle_connections_cost_little_and_let_others_in_again() {
    let emulator = Emulator::start();
    let busy = Busy::start(emulator.terminal().into(), |_| 0);
    let files = open_files(&emulator);
    let idle: Vec<TcpStream> = (0..1000).map(|_| emulator.connect()).collect();
    // Those beyond the bound are told, and closed. On a busy machine a late one may have got the place of an early one
    // that had to go meanwhile.
    let mut answers = idle.iter().rev().map(|idle| Answer::read(idle.try_clone().unwrap()));
    let refused = answers.find(|answer| answer.status != 0).expect("nobody is told");
    assert_eq!((refused.status, refused.detail().contains("too many connections")), (503, true));
    assert!(open_files(&emulator) <= files + 64 + 8, "{} files", open_files(&emulator));
    assert!(memory_of(&emulator) < 64 << 20, "{} octets", memory_of(&emulator));
    // The idle ones have to go before long, although nobody closes them.
    let start = Instant::now();
    while emulator.request("GET", "/api/v1/lines/line", "", "").status != 200 {
        assert!(start.elapsed() < PATIENCE, "the panel stays full");
        thread::sleep(Duration::from_millis(50));
    }
    drop(idle);
    assert!(busy.end() > 0);
}

#[test]
fn a_reader_that_does_not_read_loses_samples_and_is_told_how_many() {
    let emulator = Emulator::start();
    // Telegrams as fast as they can be made; refused commands are told once and counted.
    let busy =
        Busy::start(emulator.terminal().into(), |exchange| if exchange % 2 == 0 { 0x0000 } else { 0x0008 });
    let mut slow = emulator.stream("?kinds=state,news,telegram&address=5&interval_milliseconds=20");
    // The slow one reads nothing until it must have lost something: far more was told than fits anywhere. A busy machine
    // may take its time for that, as long as it goes on.
    let (mut start, mut before) = (Instant::now(), 0);
    while before < 3000 {
        let exchanges = busy.exchanges.load(Ordering::SeqCst);
        if exchanges > before {
            (start, before) = (Instant::now(), exchanges);
        }
        assert!(start.elapsed() < PATIENCE, "the line stands still");
        thread::sleep(Duration::from_millis(20));
    }
    let lost = slow.find("lost", |_| true);
    let lost_anything = ["states", "news", "telegrams"].iter().any(|kind| lost[*kind].as_u64() > Some(0));
    assert!(lost_anything, "{lost}");
    // And it is back.
    slow.find("telegram", |_| true);
    slow.find("state", |state| state["bus_state"] == json!("DATA-EXCH"));
    assert!(memory_of(&emulator) < 64 << 20, "{} octets", memory_of(&emulator));
    assert!(busy.end() > 1000);
}

#[test]
fn there_are_only_so_many_readers_of_the_stream() {
    let emulator = Emulator::start();
    let readers: Vec<_> = (0..16).map(|_| emulator.stream("?kinds=news")).collect();
    let refused = emulator.request("GET", "/api/v1/events", "", "");
    assert_eq!((refused.status, refused.detail().contains("there are 16 readers")), (503, true));
    drop(readers);
    let start = Instant::now();
    let subscribe = format!("GET /api/v1/events HTTP/1.1\r\nHost: {}\r\n\r\n", emulator.panel);
    loop {
        let mut stream = emulator.connect();
        stream.write_all(subscribe.as_bytes()).unwrap();
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        if status.ends_with(b"200") {
            break;
        }
        assert!(start.elapsed() < PATIENCE, "no place is free again");
        thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn readers_that_never_read_lose_their_places() {
    let emulator = Emulator::start();
    let busy =
        Busy::start(emulator.terminal().into(), |exchange| if exchange % 2 == 0 { 0x0000 } else { 0x0008 });
    let ask = "?kinds=state,news,telegram&address=5&interval_milliseconds=20";
    let silent: Vec<_> = (0..16).map(|_| emulator.stream(ask)).collect();
    let start = Instant::now();
    // None of them goes by itself: only that nobody reads frees a place.
    while emulator.request("GET", "/api/v1/events?address=99", "", "").status == 503 {
        assert!(start.elapsed() < PATIENCE, "no place is free again");
        thread::sleep(Duration::from_millis(200));
    }
    drop(silent);
    assert!(memory_of(&emulator) < 64 << 20, "{} octets", memory_of(&emulator));
    assert!(busy.end() > 0);
}

#[test]
fn the_emulator_ends_at_once_whoever_is_connected() {
    let mut emulator = Emulator::start();
    let mut stream = emulator.stream("");
    let _idle = emulator.connect();
    let command = format!("kill -TERM {}", emulator.process.id());
    assert!(std::process::Command::new("sh").args(["-c", &command]).status().unwrap().success());
    while stream.next().is_some() {}
    let start = Instant::now();
    let status = loop {
        if let Some(status) = emulator.process.try_wait().unwrap() {
            break status;
        }
        assert!(start.elapsed() < PATIENCE, "still running");
        thread::sleep(Duration::from_millis(5));
    };
    assert_eq!(status.code(), Some(0));
}

/// Resident memory of the emulator in octets.
fn memory_of(emulator: &Emulator) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", emulator.process.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
}

fn open_files(emulator: &Emulator) -> usize {
    fs::read_dir(format!("/proc/{}/fd", emulator.process.id())).unwrap().count()
}
