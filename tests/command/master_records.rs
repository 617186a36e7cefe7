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
            "Read: access, invalid index (80 B0 00): the slot has no record of this index",
        ),
        (&["record", "write", "1", "11", "0000"], 1, "Write: access, access denied (80 B6 00)"),
        (
            &["record", "write", "1", "10", "00"],
            1,
            "Write: access, write length error (80 B1 00): write as many octets as the record has",
        ),
        (&["im", "2"], 1, "Write: access, invalid index (80 B0 00)"),
        (&["param", "read", "922"], 1, "Write: access, invalid index (80 B0 00)"),
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
