//! Command lines and files that do not work, and the words that appear: sections of `docs/what-it-says.md`.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::panel;
use crate::sentences::{Row, compare};

/// What the command says to these arguments, with `folder` as the folder it works in. It must fail.
fn said(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command.args(arguments).env_remove("RUST_LOG").env("NO_COLOR", "1").current_dir(folder);
    let output = command.stdin(Stdio::null()).output().unwrap();
    assert!(!output.status.success(), "{arguments:?}");
    let text = String::from_utf8(output.stderr).unwrap();
    // The log before it has times.
    text.lines().rev().take(1).map(str::to_owned).collect()
}

/// One row for each line of arguments; a text before says what there is in the folder.
fn table(heading: &str, folder: &Path, letter: &str, lines: &[(&str, &[&str])]) {
    let number = |(number, (what, arguments)): (usize, &(&str, &[&str]))| {
        let done = if what.is_empty() { String::new() } else { format!("{what}: ") };
        (format!("{letter}-{:02}", number + 1), format!("{done}`profidrive {}`", arguments.join(" ")))
    };
    let named: Vec<_> = lines.iter().enumerate().map(number).collect();
    let mut rows: Vec<Row<'_>> = Vec::new();
    for ((id, done), (_, arguments)) in named.iter().zip(lines) {
        rows.push((id, done, Box::new(|| said(folder, arguments))));
    }
    compare(heading, rows);
}

#[test]
fn command_lines() {
    let folder = tempfile::tempdir().unwrap();
    let lines: &[(&str, &[&str])] = &[
        ("", &["fly"]),
        ("", &["emulate", "--drive", "127"]),
        ("", &["emulate", "--drive", "five"]),
        ("", &["emulate", "--drive", "5,gear=25"]),
        ("", &["emulate", "--drive", "5,model=x"]),
        ("", &["emulate", "--drive", "5", "--drive", "5"]),
        ("", &["emulate", "--drives", "9-1"]),
        ("", &["emulate", "--baud", "115200"]),
        ("", &["emulate", "--link", "usb"]),
        ("", &["emulate", "--link", "tcp:0.0.0.0:0"]),
        ("", &["emulate", "--panel", "0.0.0.0:0", "--link", "tcp:127.0.0.1:0"]),
        ("", &["emulate", "--fault", "drop"]),
        ("", &["emulate", "--fault", "drop-request,station=9", "--link", "tcp:127.0.0.1:0"]),
        ("", &["emulate", "--quirk", "x=y"]),
        ("", &["master", "status"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "status"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "126", "status"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "write", "1004", "9999"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "write", "1029", "1"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "read", "1"]),
        ("", &["decode", "10 05 02 49 51 16"]),
        ("", &["decode", "xyz"]),
        ("", &["encode", "stw", "fly"]),
        ("", &["emulate", "--drve", "5"]),
        ("", &["emulate", "--drive", "5,gera=24"]),
        ("", &["emulate", "--drive", "5,model=ag3"]),
        ("", &["emulate", "--station", "gsd=io.gsd"]),
        ("", &["emulate", "--ppo-drive", "7,ppo=9"]),
        ("", &["emulate", "--fault", "no-rply"]),
        ("", &["emulate", "--fault", "late"]),
        ("", &["emulate", "--fault", "late=20ms,rate=2"]),
        ("", &["emulate", "--quirk", "sdo-size=42"]),
        ("", &["emulate", "--quirk", "of1=brake"]),
        ("", &["emulate", "--slot-time", "20"]),
        ("", &["emulate", "--node", "5,device=ap11"]),
        ("", &["emulate", "--node", "5", "--link", "slcan-tcp:127.0.0.1:0", "--fault", "sdo-lost,node=6"]),
        ("", &["emulate", "--node", "5", "--drive", "6"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "status"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "velocity", "30mm", "--yes"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "move", "8,5mm", "--yes"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "write", "970", "1"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "write", "v-Poss", "60"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "write", "v-Pos", "60mm"]),
        ("", &["master", "--link", "tcp:127.0.0.1:1", "--address", "5", "--watchdog", "1ms", "status"]),
        ("", &["encode", "pkw", "write", "limit1", "99999999999"]),
        ("", &["decode", "10", "05"]),
    ];
    table("Command line", folder.path(), "K", lines);
}

#[test]
fn files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("nothing.gsd", "");
    write("other.gsd", "#Profibus_DP\nProtocol_Ident = 1\n");
    write("text.pcapng", "no capture");
    write("busy", "");
    fs::create_dir(folder.path().join("images")).unwrap();
    fs::write(folder.path().join("images/drive-5.img"), "no image").unwrap();
    let lines: &[(&str, &[&str])] = &[
        ("no such file", &["gsd", "missing.gsd"]),
        ("an empty file", &["gsd", "nothing.gsd"]),
        ("the file of no slave", &["gsd", "other.gsd"]),
        ("no such file", &["emulate", "--station", "7,gsd=missing.gsd", "--link", "tcp:127.0.0.1:0"]),
        ("no such folder", &["emulate", "--capture", "missing/bus.pcapng", "--link", "tcp:127.0.0.1:0"]),
        ("a folder", &["emulate", "--capture", "images", "--link", "tcp:127.0.0.1:0"]),
        ("a file", &["emulate", "--state-dir", "busy", "--link", "tcp:127.0.0.1:0"]),
        ("a file is there", &["emulate", "--link", "pty:busy"]),
        ("no such device", &["emulate", "--link", "serial:missing", "--baud", "19200"]),
        ("no such file", &["decode", "missing.pcapng"]),
        ("no capture", &["decode", "text.pcapng"]),
        ("no such device", &["emulate", "--link", "slcan-tty:missing", "--node", "5"]),
        ("no such file", &["emulate", "--line", "missing.toml"]),
        ("an empty file", &["emulate", "--line", "busy"]),
        ("no such folder", &["emulate", "--link", "pty:missing/bus"]),
        ("no such folder", &["man", "missing"]),
    ];
    table("Files", folder.path(), "D", lines);
}

/// A request of HTTP: method, path and body.
type Asked<'a> = (&'a str, &'a str, &'a str);

#[test]
fn http() {
    let asked: &[Asked<'_>] = &[
        ("GET", "stations/6", ""),
        ("GET", "stations/five", ""),
        ("POST", "stations", r#"{"address": 5, "device": "ag03-1"}"#),
        ("POST", "stations", r#"{"address": 127, "device": "ag03-1"}"#),
        ("POST", "stations", r#"{"address": 9, "device": "ag9"}"#),
        ("DELETE", "stations/5/power", ""),
        ("PUT", "stations/5/power", ""),
        ("PUT", "stations/5/power", "{on: true}"),
        ("PUT", "stations/5/power", "{}"),
        ("PUT", "stations/5/power", r#"{"on": "yes"}"#),
        ("PATCH", "stations/5/inputs", r#"{"battery_vots": 2}"#),
        ("PATCH", "stations/5/inputs", r#"{"battery_volts": -5}"#),
        ("POST", "stations/5/provoke", r#"{"fault": "Q"}"#),
        ("PUT", "stations/5/parameters/1004", r#"{"value": 101}"#),
        ("PUT", "stations/5/parameters/1012", r#"{"value": 1001}"#),
        ("PUT", "stations/5/parameters/1029", r#"{"value": 1}"#),
        ("PUT", "stations/5/parameters/1", r#"{"value": 1}"#),
        ("GET", "stations/5/parameters/1004?sub=1", ""),
        ("GET", "events?address=x", ""),
        ("POST", "lines/line/faults", r#"{"fault": "no-rply"}"#),
        ("POST", "lines/line/faults", r#"{"fault": "no-reply,station=9"}"#),
        ("DELETE", "lines/line/faults/9", ""),
    ];
    let emulator = panel::Emulator::start();
    let named: Vec<_> = asked
        .iter()
        .enumerate()
        .map(|(number, (method, path, body))| {
            (
                format!("Q-{:02}", number + 1),
                format!("`{method} /api/v1/{path}` {body}").trim_end().to_owned(),
            )
        })
        .collect();
    let mut rows: Vec<Row<'_>> = Vec::new();
    for ((id, done), (method, path, body)) in named.iter().zip(asked) {
        let emulator = &emulator;
        let ask = move || {
            let json = "Content-Type: application/json\r\n";
            let answer = emulator.request(method, &format!("/api/v1/{path}"), json, body);
            vec![format!("{}: {}", answer.status, answer.json()["detail"].as_str().unwrap())]
        };
        rows.push((id, done, Box::new(ask)));
    }
    compare("HTTP", rows);
}
