//! `profidrive master record`, `im` and `param` with a station of DP-V1 that another master may own.

use serde_json::{Value, json};

use crate::emulator::{Emulator, output};
use crate::panel_records;
use crate::raw_master::RawMaster;

/// What a command says, and its exit code.
fn said(emulator: &Emulator, arguments: &[&str]) -> (Option<i32>, String, String) {
    let common = ["master", "--link", emulator.link(), "--address", "7", "--master-address", "3"];
    let output = output(&[&common[..], arguments].concat());
    let text = |octets: Vec<u8>| String::from_utf8(octets).unwrap().trim().to_owned();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn done(emulator: &Emulator, arguments: &[&str]) -> String {
    let (code, out, error) = said(emulator, arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {error}");
    out
}

#[test]
fn records_and_identification_are_read_and_written_over_a_connection() {
    let folder = tempfile::tempdir().unwrap();
    let station = panel_records::station(folder.path());
    let emulator = Emulator::start(&["--link", "tcp:127.0.0.1:0", "--station", &station]);
    assert_eq!(done(&emulator, &["record", "read", "1", "10"]), "record 10 of slot 1: 41 42 00 44");
    let written = done(&emulator, &["record", "write", "1", "10", "01 02 03 04"]);
    assert_eq!(written, "record 10 of slot 1 written: 01 02 03 04");
    let read: Value =
        serde_json::from_str(&done(&emulator, &["record", "read", "1", "10", "--json"])).unwrap();
    assert_eq!(read, json!({ "slot": 1, "index": 10, "length": 4, "data": "01 02 03 04" }));
    let identification = done(&emulator, &["im"]);
    assert!(
        identification.starts_with("I&M0 of slot 0: order") && identification.contains("serial number S 1"),
        "{identification}"
    );
    for (arguments, code, words) in [
        (
            &["record", "read", "1", "99"][..],
            1,
            "Read of record 99 of slot 1: access, invalid index (80 B0 00): the slot has no record of this index",
        ),
        (
            &["record", "write", "1", "11", "0000"],
            1,
            "Write of record 11 of slot 1: access, access denied (80 B6 00)",
        ),
        (
            &["record", "write", "1", "10", "00"],
            1,
            "Write of record 10 of slot 1: access, write length error (80 B1 00): write as many octets as the record has",
        ),
        (&["im", "2"], 1, "Write of I&M (record 255) of slot 0: access, invalid index (80 B0 00)"),
        (&["param", "read", "922"], 1, "Write of record 47 of slot 0: access, invalid index (80 B0 00)"),
        (&["record", "read", "255", "1"], 2, "255"),
        (&["record", "write", "1", "1", "0"], 2, "expected 1 to 240 octets"),
        (&["param", "read", "0"], 2, "'0' is no parameter; expected 922, 944.1 or 964.0-5"),
    ] {
        let (got, _, error) = said(&emulator, arguments);
        assert!(got == Some(code) && error.contains(words), "{arguments:?}: {got:?} {error}");
    }
}

#[test]
fn a_station_that_another_master_owns_is_not_disturbed_and_one_without_connections_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let station = panel_records::station(folder.path());
    let plain = format!("7,gsd={}/tests/gsd/remote_io.gsd", env!("CARGO_MANIFEST_DIR"));
    let emulator = Emulator::start(&["--link", "tcp:127.0.0.1:0", "--station", &station]);
    let mut owner = RawMaster::new(emulator.link(), 2);
    panel_records::start(&mut owner);
    drop(owner);
    assert_eq!(done(&emulator, &["record", "read", "1", "10"]), "record 10 of slot 1: 41 42 00 44");
    let (_, diagnosis, _) = said(&emulator, &["diag", "--json"]);
    assert!(diagnosis.contains("\"master\":2"), "{diagnosis}");
    let emulator = Emulator::start(&["--link", "tcp:127.0.0.1:0", "--station", &plain]);
    let (code, _, error) = said(&emulator, &["record", "read", "1", "10"]);
    assert!(code == Some(1) && error.contains("no connections of DP-V1 (SAP 49)"), "{error}");
}

#[test]
fn parameters_of_a_drive_of_profidrive_are_read_and_written_by_record_47() {
    let emulator = Emulator::start(&["--link", "tcp:127.0.0.1:0", "--profidrive", "7"]);
    let read = done(&emulator, &["param", "read", "922", "964.0-5"]);
    let lines: Vec<_> = read.lines().collect();
    assert!(lines[0].starts_with("PNU 922: ") && lines[1].starts_with("PNU 964.0-5: "), "{read}");
    assert_eq!(lines[1].matches(", ").count(), 5, "six elements: {read}");
    let (code, out, error) = said(&emulator, &["param", "read", "922", "1999"]);
    assert!(code == Some(1) && out.starts_with("PNU 922: "), "what is good is told: {out}");
    assert!(error.contains("PNU 1999: no such parameter (error 00)"), "{error}");
    let described = done(&emulator, &["param", "describe", "922", "--json"]);
    assert!(described.contains("\"parameter\":\"PNU 922\""), "{described}");
}

/// Raises a process alarm of slot 1 by HTTP.
fn raise(emulator: &crate::panel::Emulator, data: &str) {
    let alarm = json!({ "type": "process", "slot": 1, "specifier": "appears", "data": data });
    let begun = std::time::Instant::now();
    // Until the master has taken the slave over there is nobody who would read it.
    while emulator.send("POST", "/api/v1/stations/7/alarms", &alarm).status != 201 {
        assert!(begun.elapsed() < crate::panel::PATIENCE, "no alarm is taken");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

#[test]
fn alarms_are_shown_and_acknowledged_over_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let station = panel_records::station(folder.path());
    let emulator = crate::panel::Emulator::with(&["--link", "pty", "--station", &station]);
    let gsd = folder.path().join("v1.gsd");
    let alarms = |more: &[&str]| {
        let terminal = emulator.terminal();
        let common = ["master", "--link", terminal.to_str().unwrap(), "--address", "7", "--gsd"];
        let arguments =
            [&common[..], &[gsd.to_str().unwrap(), "alarms", "--modules", "io", "--for", "1500ms"], more];
        let arguments: Vec<_> = arguments.concat().into_iter().map(str::to_owned).collect();
        std::thread::spawn(move || output(&arguments.iter().map(String::as_str).collect::<Vec<_>>()))
    };
    let shown = alarms(&[]);
    raise(&emulator, "50");
    let path = "/api/v1/stations/7/alarms";
    let begun = std::time::Instant::now();
    while emulator.get(path)["alarms"] != json!([]) {
        assert!(begun.elapsed() < crate::panel::PATIENCE, "{}", emulator.get(path));
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    raise(&emulator, "51");
    emulator.set(
        "POST",
        "/api/v1/stations/7/status-messages",
        &json!({ "type": 1, "slot": 1, "data": "05" }),
    );
    let done = shown.join().unwrap();
    assert_eq!(
        (done.status.code(), String::from_utf8(done.stdout).unwrap().lines().collect::<Vec<_>>()),
        (
            Some(0),
            vec![
                "process alarm of slot 1 appears, number 0: 50; acknowledged",
                "process alarm of slot 1 appears, number 0: 51; acknowledged",
                "status message of slot 1: 05",
            ]
        ),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    // It is free for another master; this one leaves the alarm where it is.
    let shown = alarms(&["--keep", "--json"]);
    raise(&emulator, "52");
    let done = shown.join().unwrap();
    let out = String::from_utf8(done.stdout).unwrap();
    let error = String::from_utf8(done.stderr).unwrap();
    let told: Value = serde_json::from_str(out.trim()).unwrap_or_else(|_| panic!("{out} {error}"));
    assert_eq!(
        (&told["type"], &told["data"], &told["acknowledged"]),
        (&json!(2), &json!("52"), &json!(false))
    );
}

#[test]
fn alarms_say_what_is_missing_and_who_owns_the_slave() {
    let folder = tempfile::tempdir().unwrap();
    let station = panel_records::station(folder.path());
    let emulator = Emulator::start(&["--link", "tcp:127.0.0.1:0", "--station", &station]);
    let gsd = folder.path().join("v1.gsd").display().to_string();
    let plain = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gsd/remote_io.gsd");
    let modular = folder.path().join("modular.gsd").display().to_string();
    let text = std::fs::read_to_string(&gsd).unwrap();
    std::fs::write(&modular, text.replace("Module=", "Modular_Station=1\nMax_Module=2\nModule=")).unwrap();
    for (arguments, code, words) in [
        (&["alarms"][..], 2, "add --gsd FILE"),
        (&["alarms", "--gsd", &modular], 2, "which modules has the slave? Add --modules; the file has io"),
        (&["alarms", "--gsd", &gsd, "--modules", "oi"], 2, "there is no module 'oi'"),
        (&["alarms", "--gsd", plain], 2, "the slave has no DP-V1"),
    ] {
        let (got, _, error) = said(&emulator, arguments);
        assert!(got == Some(code) && error.contains(words), "{arguments:?}: {got:?} {error}");
    }
    let mut owner = RawMaster::new(emulator.link(), 2);
    panel_records::start(&mut owner);
    drop(owner);
    let (got, _, error) = said(&emulator, &["alarms", "--gsd", &gsd, "--modules", "io", "--for", "1s"]);
    assert!(got == Some(1) && error.contains("belongs to master 2"), "{got:?} {error}");
}
