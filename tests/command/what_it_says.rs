//! Command lines and files that do not work, and the words that appear: sections of `docs/what-it-says.md`.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::said::{Row, compare};

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
    ];
    table("Files", folder.path(), "D", lines);
}
