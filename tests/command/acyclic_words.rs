//! What is told of the services of DP-V1 are the same sentences wherever they are told: in the list of the panel and its live
//! stream, which the page and Python show as they come, in the log, in `why`; and of each telegram in the stream, in what
//! `decode` says of the capture, and of the octets alone.

use std::io::Write as _;
use std::process::Stdio;

use serde_json::{Value, json};

use crate::emulator::{output, profidrive};
use crate::panel::{Emulator, Stream};
use crate::panel_records;
use crate::raw_master::{RawMaster, Said};

/// Every event that the master below leads to, in order.
const EVENTS: [&str; 11] = [
    "master 2 read record 10 of slot 1, 4 octets",
    "master 2 wrote record 10 of slot 1, 4 octets",
    "refused Read of record 99 of slot 1 of master 2: access, invalid index (80 B0 00): the slot has no record of this index",
    "master 2 read I&M0 (65000) of slot 0",
    "master 2 has read the process alarm of slot 1 appears, number 0",
    "master 2 has acknowledged the process alarm of slot 1 appears, number 0",
    "refused Alarm_Ack of master 2: access, state conflict (80 B5 00)",
    "opened a connection for master 2 at SAP 48",
    "master 2 read record 10 of slot 1, 4 octets (connection at SAP 48)",
    "the connection of master 2 at SAP 48 has ended: the master closed it",
    "refused a connection of master 2",
];

/// Records, identification, an alarm and a connection; as many connections as there are, and one more.
fn work(emulator: &Emulator, master: &mut RawMaster) {
    master.ms1(7, &[0x5E, 1, 10, 240]);
    // Base mode parameter access to a station without parameters.
    master.ms1(7, &[0x5F, 0, 47, 10, 1, 1, 0, 1, 0x10, 1, 0x03, 0xA2, 0, 0]);
    master.ms1(7, &[0x5F, 1, 10, 4, 9, 8, 7, 6]);
    master.ms1(7, &[0x5E, 1, 99, 240]);
    master.ms1(7, &[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE8]);
    master.ms1(7, &[0x5E, 0, 255, 240]);
    let alarm = json!({ "type": "process", "slot": 1, "specifier": "appears", "data": "50" });
    emulator.set("POST", "/api/v1/stations/7/alarms", &alarm);
    master.ask(7, Some((60, 62)), &[]);
    master.ms1(7, &[0x5C, 1, 2, 1]);
    master.ms1(7, &[0x5C, 1, 2, 1]);
    let initiate = [0x57, 0, 0, 0, 0, 100, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    let mut ms2 = |sap, data: &[u8]| master.ask(7, Some((sap, 50)), data);
    ms2(49, &initiate);
    ms2(49, &[]);
    ms2(48, &[]);
    ms2(48, &[0x5E, 1, 10, 240]);
    assert!(matches!(ms2(48, &[]), Said::Data(8, _)));
    ms2(48, &[0x58, 0, 0x20]);
    for _ in 0..2 {
        ms2(49, &initiate);
        ms2(49, &[]);
    }
    ms2(49, &initiate);
}

/// The texts of a stream to the one that begins so.
fn texts(stream: &mut Stream, name: &str, last: &str) -> Vec<Value> {
    let mut texts = Vec::new();
    loop {
        let found = stream.find(name, |_| true);
        let is_last = found["text"].as_str().unwrap().contains(last);
        texts.push(found);
        if is_last {
            return texts;
        }
    }
}

fn strings<'a>(values: impl IntoIterator<Item = &'a Value>, key: &str) -> Vec<String> {
    values.into_iter().map(|value| value[key].as_str().unwrap().to_owned()).collect()
}

/// What `decode --json` says of each telegram.
fn summaries(stdout: &[u8]) -> Vec<String> {
    let lines = std::str::from_utf8(stdout).unwrap().lines();
    let values: Vec<Value> = lines.map(|line| serde_json::from_str(line).unwrap()).collect();
    strings(values.iter().filter(|value| value["kind"] == json!("telegram")), "summary")
}

/// What `decode` says of octets that it gets as text.
fn decoded(octets: &[String]) -> Vec<String> {
    let mut process =
        profidrive(&["decode", "--json", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    process.stdin.take().unwrap().write_all(octets.join("\n").as_bytes()).unwrap();
    summaries(&process.wait_with_output().unwrap().stdout)
}

#[test]
fn records_alarms_and_connections_have_the_same_words_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let station = panel_records::station(folder.path());
    let capture = folder.path().join("all.pcapng");
    let emulator = Emulator::logging(&[
        "-v",
        "--link",
        "tcp:127.0.0.1:0",
        "--station",
        &station,
        "--capture",
        capture.to_str().unwrap(),
    ]);
    let mut master = RawMaster::new(emulator.terminal().to_str().unwrap(), 2);
    panel_records::start(&mut master);
    let mut news = emulator.stream("?kinds=news&address=7");
    let mut telegrams = emulator.stream("?kinds=telegram");
    work(&emulator, &mut master);
    // Events: the stream, the list, the log.
    let in_stream = strings(&texts(&mut news, "news", EVENTS[10]), "text");
    let told: Vec<_> =
        EVENTS.iter().map(|words| in_stream.iter().find(|text| text.contains(words))).collect();
    assert!(told.iter().all(Option::is_some), "{in_stream:#?}");
    let listed = emulator.get("/api/v1/events/recent?address=7");
    let listed = strings(listed["events"].as_array().unwrap(), "text");
    let is_there = listed.windows(in_stream.len()).any(|part| part == in_stream);
    assert!(is_there, "{listed:#?} {in_stream:#?}");
    // Telegrams: the stream and its octets, to the last reply.
    let mut shown = Vec::new();
    for _ in 0..4 {
        shown.extend(texts(&mut telegrams, "telegram", "asks for a connection"));
    }
    let words = strings(&shown, "text");
    let alone = decoded(&strings(&shown, "octets_hex"));
    let pairs: Vec<_> = words.iter().zip(&alone).filter(|(words, alone)| !words.ends_with(*alone)).collect();
    assert!(pairs.is_empty() && words.len() == alone.len(), "{pairs:#?}");
    for sentence in [
        "Read record 10 of slot 1",
        "Write record 47 (parameters of a drive) of slot 0, request 1: reads PNU 930",
        "record 10 of slot 1: 09 08 07 06",
        "Read of record 99 of slot 1 refused: access, invalid index (80 B0 00)",
        "took the acknowledgement of the process alarm of slot 1 appears, number 0",
        "the connection is at SAP 48",
    ] {
        assert!(words.iter().any(|words| words.contains(sentence)), "{sentence}: {words:#?}");
    }
    // What was refused last is why nothing came.
    master.ms1(7, &[0x5E, 1, 99, 240]);
    let why = emulator.get("/api/v1/stations/7/why").to_string();
    assert!(why.contains(EVENTS[2].split_once(": ").unwrap().1), "{why}");
    let log = emulator.log();
    for text in &in_stream {
        assert!(log.iter().any(|line| line.ends_with(text.as_str())), "{text}: {log:#?}");
    }
    // The capture, from the start of the master on.
    let captured = summaries(&output(&["decode", "--json", capture.to_str().unwrap()]).stdout);
    let first = words[0].rsplit_once("  ").map_or(&*words[0], |(_, words)| words);
    let begin = captured.iter().position(|summary| summary == first).unwrap();
    let wrong = words.iter().zip(&captured[begin..]).find(|(words, summary)| !words.ends_with(*summary));
    assert_eq!(wrong, None);
}
