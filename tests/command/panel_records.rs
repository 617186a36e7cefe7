//! Records and alarms of a station over HTTP, with a master of DP-V1 at its line.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::panel::Emulator;
use crate::raw_master::{RawMaster, Said};

const GSD: &str = "#Profibus_DP\nVendor_Name=\"profidrive\"\nModel_Name=\"V1\"\nIdent_Number=0x1234\nDPV1_Slave=1\n\
    Max_Diag_Data_Len=60\nMax_User_Prm_Data_Len=30\nExt_User_Prm_Data_Const(0)=0x00,0x00,0x00\nC1_Read_Write_supp=1\n\
    C1_Max_Data_Len=240\nC2_Read_Write_supp=1\nC2_Max_Count_Channels=2\nOrderNumber=\"ABC-1\"\nIdent_Maintenance_supp=1\n\
    Process_Alarm_supp=1\nDiagnostic_Alarm_supp=1\nModule=\"io\" 0x31\nEndModule\n";
const RECORDS: &str = "[[record]]\nslot = 1\nindex = 10\ndata = \"41 42 00 44\"\n[[record]]\nslot = 1\nindex = 11\n\
    length = 2\naccess = \"r\"\n[im0]\nserial_number = \"S 1\"\nwritable = [1]\n";
const PRM: [u8; 10] = [0x80, 1, 1, 11, 0x12, 0x34, 0, 0x80, 0x60, 0];

/// The arguments of a station with records, whose files are in `folder`.
pub(crate) fn station(folder: &Path) -> String {
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    format!("7,gsd={},records={}", file("v1.gsd", GSD), file("records.toml", RECORDS))
}

fn emulator(folder: &Path) -> (Emulator, RawMaster) {
    let emulator = Emulator::with(&["--link", "tcp:127.0.0.1:0", "--station", &station(folder)]);
    let master = RawMaster::new(emulator.terminal().to_str().unwrap(), 2);
    (emulator, master)
}

/// A master in data exchange with DP-V1 and two types of alarms.
pub(crate) fn start(master: &mut RawMaster) {
    master.start(7, &PRM, &[0x31], &[0, 0]);
}

#[test]
fn v1_r33_a_record_is_changed_by_http_between_two_reads_and_a_write_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let (emulator, mut master) = emulator(folder.path());
    let all = emulator.get("/api/v1/stations/7/records");
    let first =
        json!({ "slot": 1, "index": 10, "length": 4, "access": "rw", "data": "41 42 00 44", "text": "AB.D" });
    assert_eq!(all["records"][0], first);
    assert_eq!(all["records"][1]["access"], "r");
    start(&mut master);
    assert_eq!(master.ms1(7, &[0x5E, 1, 10, 240]), [0x5E, 1, 10, 4, 0x41, 0x42, 0, 0x44]);
    let path = "/api/v1/stations/7/records/1/10";
    let changed = emulator.set("PUT", path, &json!({ "data": "AABBCCDD" }));
    assert_eq!(changed["data"], "AA BB CC DD");
    assert_eq!(master.ms1(7, &[0x5E, 1, 10, 240])[4..], [0xAA, 0xBB, 0xCC, 0xDD]);
    assert_eq!(master.ms1(7, &[0x5F, 1, 10, 4, 1, 2, 3, 4]), [0x5F, 1, 10, 4]);
    assert_eq!(emulator.get(path)["data"], "01 02 03 04");
    // One that a master cannot write belongs to the device.
    emulator.set("PUT", "/api/v1/stations/7/records/1/11", &json!({ "data": "00 09" }));
    assert_eq!(master.ms1(7, &[0x5E, 1, 11, 240])[4..], [0, 9]);
    assert_eq!(master.ms1(7, &[0x5F, 1, 11, 2, 0, 0]), [0xDF, 0x80, 0xB6, 0]);
    let events = emulator.get("/api/v1/events/recent?address=7");
    let texts: Vec<_> =
        events["events"].as_array().unwrap().iter().map(|event| event["text"].as_str().unwrap()).collect();
    for words in
        ["master 2 wrote record 10 of slot 1, 4 octets", "record 10 of slot 1 is changed by the device"]
    {
        assert!(texts.iter().any(|text| text.contains(words)), "{words}: {texts:?}");
    }
}

#[test]
fn what_is_wrong_with_a_record_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let (emulator, _) = emulator(folder.path());
    let put = |path: &str, body: &Value| emulator.send("PUT", path, body);
    for (path, data, status, words) in [
        ("records/1/10", "01", 422, "1 octets, expected 4: record 10 of slot 1 has as many"),
        ("records/1/10", "0x01", 422, "'0x01' is no hexadecimal octets"),
        ("records/1/12", "01", 404, "slot 1 has no record 12; it has 10, 11"),
        ("records/3/1", "01", 404, "slot 3 has no records"),
    ] {
        let refused = put(&format!("/api/v1/stations/7/{path}"), &json!({ "data": data }));
        assert!(refused.status == status && refused.body.contains(words), "{path} {data}: {refused:?}");
    }
    let plain = Emulator::with(&["--drive", "5"]);
    for path in ["records", "alarms", "acyclic"] {
        let refused = plain.request("GET", &format!("/api/v1/stations/5/{path}"), "", "");
        assert!(refused.status == 409 && refused.body.contains("no services of DP-V1"), "{refused:?}");
    }
}

#[test]
fn v1_r51_v1_r52_v1_r55_v1_r56_v1_r57_an_alarm_is_raised_by_http_delivered_and_acknowledged() {
    let folder = tempfile::tempdir().unwrap();
    let (emulator, mut master) = emulator(folder.path());
    let alarm = json!({ "type": "process", "slot": 1, "specifier": "appears", "data": "50" });
    let path = "/api/v1/stations/7/alarms";
    let refused = emulator.send("POST", path, &alarm);
    assert!(refused.status == 409 && refused.body.contains("not in data exchange"), "{refused:?}");
    start(&mut master);
    let raised = emulator.set("POST", path, &alarm);
    let expected = json!({
        "type": 2, "slot": 1, "sequence": 0, "specifier": "appears", "additional_ack": false, "data": "50",
        "state": "pending", "text": "process alarm of slot 1 appears, number 0"
    });
    assert_eq!(raised, expected);
    let again = emulator.send("POST", path, &json!({ "type": 2, "slot": 1 }));
    assert!(again.status == 409 && again.body.contains("not acknowledged yet"), "{again:?}");
    assert!(matches!(master.ask(7, None, &[0, 0]), Said::Data(10, _)), "answered high: there is a diagnosis");
    let Said::Data(_, diagnosis) = master.ask(7, Some((60, 62)), &[]) else { panic!() };
    assert_eq!(diagnosis[6..], [5, 2, 1, 1, 0x50]);
    assert_eq!(emulator.get(path)["alarms"][0]["state"], "delivered");
    assert_eq!(emulator.get(path)["types"], json!([1, 2]));
    assert_eq!(master.ms1(7, &[0x5C, 1, 2, 1]), [0x5C, 1, 2, 1]);
    assert_eq!(emulator.get(path)["alarms"], json!([]));
    for (alarm, status, words) in [
        (json!({ "type": "update", "slot": 1 }), 409, "the slave has no update alarm"),
        (json!({ "type": "x", "slot": 1 }), 422, "'x' is no type of an alarm; expected diagnostic, process"),
        (json!({ "type": 7, "slot": 1 }), 422, "'7' is no type of an alarm"),
        (json!({ "type": 1, "slot": 255 }), 422, "slot 255 is none"),
        (json!({ "type": 1, "slot": 1, "data": "5" }), 422, "'5' is no hexadecimal octets"),
        (
            json!({ "type": 1, "slot": 1, "data": "00".repeat(60) }),
            409,
            "60 octets of data, expected at most 50",
        ),
    ] {
        let refused = emulator.send("POST", path, &alarm);
        assert!(refused.status == status && refused.body.contains(words), "{alarm}: {refused:?}");
    }
    emulator.set("POST", path, &json!({ "type": "diagnostic", "slot": 0 }));
    assert_eq!(emulator.request("DELETE", path, "", "").status, 204);
    assert_eq!(emulator.get(path)["alarms"], json!([]));
    // What Set_Prm does not enable.
    for (status, words) in [
        ([0x80, 0x20, 0], "Enable_Process_Alarm in octet 9 of Set_Prm is 0"),
        ([0x00, 0x60, 0], "DPV1_Enable in octet 8 of Set_Prm is 0"),
    ] {
        master.start(7, &[&PRM[..7], &status].concat(), &[0x31], &[0, 0]);
        let refused = emulator.send("POST", path, &alarm);
        assert!(refused.status == 409 && refused.body.contains(words), "{refused:?}");
        let Said::Data(_, diagnosis) = master.ask(7, Some((60, 62)), &[]) else { panic!() };
        assert_eq!(diagnosis[6..], [0; 0]);
    }
}

#[test]
fn v1_r66_a_status_message_and_the_channels_over_http() {
    let folder = tempfile::tempdir().unwrap();
    let (emulator, mut master) = emulator(folder.path());
    let path = "/api/v1/stations/7/status-messages";
    let message = json!({ "type": 1, "slot": 1, "data": "05 00" });
    assert_eq!(emulator.send("POST", path, &message).status, 409);
    let closed = emulator.get("/api/v1/stations/7/acyclic");
    assert_eq!(closed["ms1"], json!({ "open": false, "owner": null, "busy": false }));
    start(&mut master);
    assert_eq!(emulator.send("POST", path, &message).status, 201);
    let Said::Data(_, diagnosis) = master.ask(7, Some((60, 62)), &[]) else { panic!() };
    assert_eq!(diagnosis[6..], [6, 0x81, 1, 0, 5, 0]);
    let initiate = [0x57, 0, 0, 0, 0, 100, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    assert_eq!(master.ask(7, Some((49, 50)), &initiate), Said::Sc);
    assert_eq!(master.ask(7, Some((49, 50)), &[]), Said::Data(8, vec![0x56, 48, 0, 100]));
    assert!(matches!(master.ask(7, Some((48, 50)), &[]), Said::Data(8, _)));
    let open = emulator.get("/api/v1/stations/7/acyclic");
    assert_eq!(open["ms1"], json!({ "open": true, "owner": 2, "busy": false }));
    assert_eq!(open["ms2"], json!([{ "sap": 48, "master": 2, "send_timeout_ms": 1000, "busy": false }]));
    assert_eq!(open["max"], 2);
    let text = open["identification"][0]["text"].as_str().unwrap();
    assert!(text.contains("serial number S 1"), "{text}");
    assert_eq!(
        (&open["identification"][1]["block"], &open["identification"][1]["writable"]),
        (&json!(1), &json!(true))
    );
}

#[test]
fn a_line_file_has_records_and_alarms_that_come_by_themselves() {
    let folder = tempfile::tempdir().unwrap();
    station(folder.path());
    let file = |more: &str| {
        let path = folder.path().join("line.toml");
        let text = format!(
            "[[line]]\nlink = \"tcp:127.0.0.1:0\"\npanel = \"127.0.0.1:0\"\n[[line.station]]\naddress = 7\ngsd = \"v1.gsd\"\n\
             [[line.station.record]]\nslot = 1\nindex = 20\ndata = \"05 06\"\naccess = \"r\"\n{more}"
        );
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let alarm = "[[line.station.alarm]]\ntype = \"process\"\nevery = \"20ms\"\nslot = 1\nspecifier = \"appears\"\ndata = \"50\"\n";
    let emulator = Emulator::of_file(&file(alarm));
    let mut master = RawMaster::new(emulator.terminal().to_str().unwrap(), 2);
    start(&mut master);
    assert_eq!(master.ms1(7, &[0x5E, 1, 20, 240]), [0x5E, 1, 20, 2, 5, 6]);
    let begun = std::time::Instant::now();
    while !matches!(master.ask(7, None, &[0, 0]), Said::Data(10, _)) {
        assert!(begun.elapsed() < crate::panel::PATIENCE, "no alarm is announced");
    }
    let Said::Data(_, diagnosis) = master.ask(7, Some((60, 62)), &[]) else { panic!() };
    assert_eq!(diagnosis[6..], [5, 2, 1, 1, 0x50]);
    let wrong = file("[[line.station.alarm]]\ntype = \"update\"\n");
    let output = crate::emulator::output(&["emulate", "--line", &wrong, "--check"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("the GSD has no update alarm"), "{said}");
}

/// What the station says keeps masters from its services: names and sentences.
fn services(emulator: &Emulator) -> Vec<(String, String)> {
    let why = emulator.get("/api/v1/stations/7/why");
    let text = why["text"].as_str().unwrap();
    let word = |value: &Value| value.as_str().unwrap().to_owned();
    let told: Vec<_> = why["services"]
        .as_array()
        .unwrap()
        .iter()
        .map(|told| (word(&told["reason"]), word(&told["text"])))
        .collect();
    assert!(told.iter().all(|(_, sentence)| text.contains(sentence)), "{why}");
    told
}

/// The sentence of the reason of this name.
fn sentence(emulator: &Emulator, name: &str) -> String {
    let told = services(emulator);
    let found = told.iter().find(|(reason, _)| reason == name);
    found.unwrap_or_else(|| panic!("no {name}: {told:?}")).1.clone()
}

/// What the log, the panel and decode say of a refused request are the same words.
fn refused_alike(emulator: &Emulator, master: &mut RawMaster, request: &[u8], words: &str) {
    let answer = master.ms1(7, request);
    assert_eq!((answer.len(), answer[0] & 0x80), (4, 0x80), "{words}: {answer:02X?}");
    let sentence = sentence(emulator, "ServiceRefused");
    assert!(sentence.ends_with(words), "{words}: {sentence}");
    let events = emulator.get("/api/v1/events/recent?address=7");
    let told = events["events"].as_array().unwrap();
    assert!(
        told.iter().any(|event| event["text"] == format!("station 7: {sentence}").as_str()),
        "{sentence}: {told:?}"
    );
    let telegram = |da: u8, sa: u8, fc: u8, data: &[u8]| {
        let body = [&[0x80 | da, 0x80 | sa, fc, 51, 51][..], data].concat();
        let len = u8::try_from(body.len()).unwrap();
        let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
        let octets = [&[0x68, len, len, 0x68][..], &body, &[sum, 0x16]].concat();
        octets.iter().map(|octet| format!("{octet:02X} ")).collect::<String>()
    };
    let both = [telegram(7, 2, 0x5D, request), telegram(2, 7, 0x08, &answer)];
    let output = crate::emulator::output(&["decode", "--brief", &both[0], &both[1]]);
    let decoded = String::from_utf8(output.stdout).unwrap();
    let (slot, index) = (request[1], request[2]);
    let (what, cure) = words.split_once("): ").unwrap();
    let of = format!("of record {index} of slot {slot} refused: {what})");
    assert!(decoded.contains(&of) && decoded.contains(&format!("^ {cure}")), "{of}: {decoded}");
}

#[test]
fn why_log_and_decode_say_alike_what_keeps_a_master_from_records() {
    let folder = tempfile::tempdir().unwrap();
    let (emulator, mut master) = emulator(folder.path());
    assert!(sentence(&emulator, "Ms1NoExchange").contains("the slave waits for Set_Prm"));
    let mut plain = PRM;
    plain[7] = 0;
    master.start(7, &plain, &[0x31], &[0, 0]);
    assert!(sentence(&emulator, "Ms1NotEnabled").contains("DPV1_Enable in octet 8 of Set_Prm is 0"));
    start(&mut master);
    assert_eq!(services(&emulator), []);
    for (request, words) in [
        (
            &[0x5E, 9, 10, 240][..],
            "access, invalid slot (80 B2 00): the device has no such slot; slot 0 is the station itself",
        ),
        (&[0x5E, 1, 99, 240], "access, invalid index (80 B0 00): the slot has no record of this index"),
        (
            &[0x5F, 1, 10, 1, 0],
            "access, write length error (80 B1 00): write as many octets as the record has",
        ),
        (
            &[0x5F, 1, 11, 2, 0, 0],
            "access, access denied (80 B6 00): the record can only be read, or only be written",
        ),
    ] {
        refused_alike(&emulator, &mut master, request, words);
    }
    assert_eq!(master.ms1(7, &[0x5E, 1, 10, 240]).len(), 8);
    assert_eq!(services(&emulator), [], "a service was carried out");
    emulator.set(
        "POST",
        "/api/v1/stations/7/alarms",
        &json!({ "type": "process", "slot": 1, "specifier": "appears" }),
    );
    assert!(
        sentence(&emulator, "AlarmNotRead")
            .starts_with("the process alarm of slot 1 appears, number 0 waits until")
    );
    master.ask(7, Some((60, 62)), &[]);
    assert!(sentence(&emulator, "AlarmNotAcknowledged").contains("waits for its acknowledgement"));
    master.ms1(7, &[0x5C, 1, 2, 1]);
    assert_eq!(services(&emulator), []);
}

#[test]
fn why_of_a_drive_names_the_parameter_that_was_refused_with_its_cure() {
    let emulator = Emulator::with(&["--link", "tcp:127.0.0.1:0", "--profidrive", "7,telegram=1"]);
    let mut master = RawMaster::new(emulator.terminal().to_str().unwrap(), 2);
    let configuration = [0xC3, 0xC1, 0xC1, 0xFD, 0, 1];
    master.start(7, &[0x80, 1, 1, 11, 0x50, 0x34, 0, 0x80, 0, 0], &configuration, &[0, 0, 0, 0]);
    for (address, axis, words) in [
        (
            [0x10, 1, 0x12, 0x67, 0, 0],
            1,
            "PNU 4711.0 of axis 1: error 00h, no such parameter: read the list of parameters, PNU 980",
        ),
        (
            [0x10, 1, 0x03, 0xC4, 0, 99],
            1,
            "PNU 964.99 of axis 1: error 03h, no such sub-index (sub-index 99): read its description",
        ),
        (
            [0x10, 1, 0x03, 0x9A, 0, 0],
            9,
            "PNU 922.0 of axis 9: error 19h, no such axis: choose another axis (DO-ID)",
        ),
    ] {
        let request = [&[0x5F, 0, 47, 10, 1, 1, axis, 1][..], &address].concat();
        assert_eq!(master.ms1(7, &request)[0], 0x5F);
        let refused = sentence(&emulator, "ParameterRefused");
        assert!(refused.starts_with(&format!("record 47 of slot 0 does not read {words}")), "{refused}");
    }
    assert_eq!(master.ms1(7, &[0x5F, 0, 47, 10, 1, 1, 1, 1, 0x10, 1, 0x03, 0x9A, 0, 0])[0], 0x5F);
    assert_eq!(services(&emulator), []);
    let channels = emulator.get("/api/v1/stations/7/acyclic");
    assert_eq!(channels["ms1"], json!({ "open": true, "owner": 2, "busy": false }));
    assert_eq!(channels["identification"][0]["block"], 0);
    assert_eq!(emulator.get("/api/v1/stations/7/records")["records"], json!([]));
}
