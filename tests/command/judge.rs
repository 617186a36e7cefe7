//! `profidrive judge` as a process: ready line, exit codes, reports, captures, a master that never comes.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rustix::fs::OFlags;
use serde_json::Value;
use std::os::unix::fs::OpenOptionsExt;

use crate::process::end_of;

mod action;
mod compared;
mod configured;
mod device;
mod gitlab;
mod masters;
mod nodes;
mod rates;
mod rings;
mod wide;

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command.arg("judge").args(arguments).env_remove("RUST_LOG");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Exit code, stdout, stderr.
fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = command(arguments).output().unwrap();
    (
        output.status.code(),
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// Started, and its ready line read.
fn start(arguments: &[&str]) -> (Child, String, BufReader<std::process::ChildStdout>) {
    let mut child = command(arguments).spawn().unwrap();
    let mut stdout = BufReader::new(child.stdout.take().unwrap());
    let mut ready = String::new();
    stdout.read_line(&mut ready).unwrap();
    (child, ready, stdout)
}

/// Slave_Diag of station 5 by master 2, with FCV = 0, FCB = 1.
const DIAG: [u8; 11] = [0x68, 0x05, 0x05, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16];

/// A master that asks some times, at first with this error in the checksum, and is silent then.
fn ask(link: &Path, error: u8) {
    let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().cast_signed();
    let mut bus = fs::OpenOptions::new().read(true).write(true).custom_flags(flags).open(link).unwrap();
    let mut octets = [0; 256];
    for error_bits in [error, error, 0, 0, 0] {
        let mut diag = DIAG;
        diag[9] ^= error_bits;
        bus.write_all(&diag).unwrap();
        thread::sleep(Duration::from_millis(150));
        let _ = bus.read(&mut octets);
    }
    // The terminal stays open until the judge has read everything.
    thread::sleep(Duration::from_millis(300));
}

const STATION: &str = "5,ident=1234,cfg=2313";

#[test]
fn wrong_command_lines_are_told_in_one_line_and_end_with_2() {
    for (arguments, part) in [
        (&[][..], "a station is missing"),
        (&["--station", "5,ident=1234"], "ident and cfg must be given"),
        (&["--station", STATION, "--station", STATION], "two stations have address 5"),
        (&["--station", "5,ident=1234,cfg=2313,absent"], "every station is absent"),
        (&["--station", STATION, "--only", "M-Q*"], "no row has this name"),
        (&["--station", STATION, "--master", "5"], "station 5 has the address of the master"),
        (&["--station", STATION, "--master", "126"], "126 is no address of a master; expected 0 to 125"),
        (&["--station", STATION, "--retries", "16"], "16 is not in 0..=15"),
        (&["--station", STATION, "--baud", "500000,1500000"], "--baud with several rates needs --ask"),
        (&["--station", STATION, "--baud", "500000,auto", "--ask", "true"], "give the rates as numbers"),
        (&["--station", STATION, "--baud", "500000,500000", "--ask", "true"], "names 500000 bit/s twice"),
        (&["--station", "5,gsd=missing.gsd"], "cannot read missing.gsd"),
    ] {
        let (code, stdout, stderr) = run(arguments);
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    }
}

#[test]
fn a_master_that_never_comes_ends_it_with_3_after_ten_seconds() {
    let dir = tempfile::tempdir().unwrap();
    let link = dir.path().join("bus");
    let spec = format!("pty:{}", link.display());
    let begin = Instant::now();
    let (mut child, ready, _stdout) =
        start(&["--link", &spec, "--station", STATION, "--station", "7,ident=1234,cfg=2313,absent"]);
    assert_eq!(ready, format!("ready link={} stations=5,7\n", link.display()));
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    let status: ExitStatus = end_of(&mut child);
    assert_eq!(status.code(), Some(3), "{stderr}");
    assert!(stderr.contains("no master was heard within 10 s"), "{stderr}");
    assert!(begin.elapsed() >= Duration::from_secs(9));
}

#[test]
fn a_failure_is_in_every_report_and_again_in_the_capture() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (link, json, junit, html, capture) =
        (file("bus"), file("v.json"), file("v.xml"), file("v.html"), file("v.pcapng"));
    let spec = format!("pty:{link}");
    let (mut child, _, mut stdout) = start(&[
        "--link",
        &spec,
        "--station",
        STATION,
        "--only",
        "M-F*",
        "--json",
        &json,
        "--junit",
        &junit,
        "--html",
        &html,
        "--capture",
        &capture,
    ]);
    ask(Path::new(&link), 0x01);
    let mut table = String::new();
    stdout.read_to_string(&mut table).unwrap();
    assert_eq!(end_of(&mut child).code(), Some(1), "{table}");
    assert!(table.starts_with("FAIL M-F02"), "{table}");
    check_json(&fs::read_to_string(&json).unwrap());
    let junit = fs::read_to_string(&junit).unwrap();
    assert!(junit.contains("<failure type=\"M-F02\"") && junit.contains("failures=\"1\""), "{junit}");
    let html = fs::read_to_string(&html).unwrap();
    assert!(html.contains("<section id=\"M-F02\" class=\"fail\">") && html.contains("<svg"), "{html}");
    assert!(!html.contains("<script"));

    let (code, table, stderr) = run(&[&capture, "--only", "M-F02"]);
    assert_eq!(code, Some(1), "{table}{stderr}");
    assert!(table.contains("FAIL M-F02"), "{table}");
    let (code, table, stderr) = run(&[&capture, "--only", "M-F06"]);
    assert_eq!(code, Some(0), "{table}{stderr}");
    assert!(table.contains("pass       M-F06"), "{table}");
    judge_other_forms(dir.path(), &capture);
}

/// The same capture cut off, as lines of octets, and in the older format.
fn judge_other_forms(dir: &Path, capture: &str) {
    let whole = fs::read(capture).unwrap();
    let (cut, lines, classic) = (dir.join("cut.pcapng"), dir.join("lines.txt"), dir.join("old.pcap"));
    fs::write(&cut, &whole[..whole.len() - 10]).unwrap();
    let hex: Vec<String> = DIAG.iter().map(|octet| format!("{octet:02X}")).collect();
    fs::write(&lines, format!("# two requests\n{0}\n\n{0}\n", hex.join(" "))).unwrap();
    let record = |at: u32| {
        let len = u32::try_from(DIAG.len()).unwrap();
        [at, 0, len, len].iter().flat_map(|word| word.to_le_bytes()).chain(DIAG).collect::<Vec<u8>>()
    };
    let header = [0xA1B2_C3D4_u32, 0x0004_0002, 0, 0, 65535, 257];
    let header: Vec<u8> = header.iter().flat_map(|word| word.to_le_bytes()).collect();
    fs::write(&classic, [header, record(1), record(2)].concat()).unwrap();
    for file in [&lines, &classic] {
        let (code, table, stderr) = run(&[file.to_str().unwrap(), "--only", "M-F06,M-T02"]);
        assert_eq!(code, Some(0), "{table}{stderr}");
        assert!(table.contains("pass       M-F06"), "{table}");
        assert!(table.contains("ended: the capture was read to its end"), "{table}");
    }
    let cut_classic = dir.join("cut.pcap");
    let whole = fs::read(&classic).unwrap();
    fs::write(&cut_classic, &whole[..whole.len() - 3]).unwrap();
    judge_cut(dir, &cut, 1);
    judge_cut(dir, &cut_classic, 4);
    fs::write(&lines, "no request").unwrap();
    let (code, _, stderr) = run(&[lines.to_str().unwrap()]);
    assert_eq!(code, Some(5), "{stderr}");
    assert!(stderr.contains("neither a capture nor octets in hexadecimal"), "{stderr}");
    // Nobody speaks in it.
    fs::write(&lines, "E5\n").unwrap();
    let (code, _, stderr) = run(&[lines.to_str().unwrap()]);
    assert_eq!(code, Some(3), "{stderr}");
    assert!(stderr.contains("no master was heard in the capture"), "{stderr}");
}

/// A capture that is cut off is judged, and is no complete judgement; `of_checksums` is the status by M-F02 alone.
fn judge_cut(dir: &Path, cut: &Path, of_checksums: i32) {
    const CUT: &str = "the capture is cut off, and was judged as far as it goes: ";
    let (cut, json, junit) = (cut.to_str().unwrap(), dir.join("cut.json"), dir.join("cut.xml"));
    let reports = ["--json", json.to_str().unwrap(), "--junit", junit.to_str().unwrap()];
    let (code, table, stderr) = run(&[&[cut, "--only", "M-F06,M-T02"][..], &reports].concat());
    assert_eq!(code, Some(4), "{table}{stderr}");
    assert!(stderr.contains(&format!("profidrive: {CUT}")), "{stderr}");
    assert!(table.contains("pass       M-F06") && table.contains(&format!("ended: {CUT}")), "{table}");
    let json: Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
    assert_eq!(json["status"], 4, "{json}");
    assert!(json["ended"].as_str().unwrap().starts_with(CUT), "{json}");
    let junit = fs::read_to_string(junit).unwrap();
    assert!(junit.contains(&format!("<error type=\"not finished\" message=\"{CUT}")), "{junit}");
    let (code, table, stderr) = run(&[cut, "--only", "M-F02"]);
    assert_eq!(code, Some(of_checksums), "{table}{stderr}");
}

/// The contract for programs that read the verdicts.
fn check_json(text: &str) {
    let report: Value = serde_json::from_str(text).unwrap();
    assert_eq!(report["version"], 1);
    assert_eq!(report["program"], concat!("profidrive ", env!("CARGO_PKG_VERSION")));
    assert_eq!(report["configuration"]["stations"], serde_json::json!(["5,ident=1234,cfg=2313"]));
    let date = report["date"].as_str().unwrap();
    assert!(date.len() == 20 && date.ends_with('Z'), "{date}");
    assert!(report["seconds"].as_f64().unwrap() > 0.0);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 11);
    for row in rows {
        let verdict = row["verdict"].as_str().unwrap();
        assert!(["pass", "fail", "warn", "not_judged"].contains(&verdict), "{row}");
        assert!(
            row["id"].as_str().unwrap().starts_with("M-F") && !row["reason"].as_str().unwrap().is_empty()
        );
        assert!(row["seconds"].is_f64(), "{row}");
        let telegrams = row["telegrams"].as_array().unwrap();
        assert!(verdict != "fail" || !telegrams.is_empty(), "{row}");
        for telegram in telegrams {
            assert!(
                telegram["t"].is_f64() && ["M", "S", "S5"].contains(&telegram["from"].as_str().unwrap()),
                "{telegram}"
            );
            let hex = telegram["hex"].as_str().unwrap();
            assert!(hex.split(' ').all(|octet| u8::from_str_radix(octet, 16).is_ok()), "{telegram}");
        }
    }
    let failed: Vec<_> = rows.iter().filter(|row| row["verdict"] == "fail").map(|row| &row["id"]).collect();
    assert_eq!(failed, ["M-F02"]);
}

#[test]
fn a_report_that_cannot_be_written_is_told_at_the_beginning() {
    let (code, stdout, stderr) = run(&["--station", STATION, "--html", "/nowhere/report.html"]);
    assert_eq!((code, stdout.as_str()), (Some(5), ""), "{stderr}");
    assert!(stderr.contains("cannot write /nowhere/report.html"), "{stderr}");
}

#[test]
fn a_file_that_is_no_capture_ends_it_with_5() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("text.pcapng");
    fs::write(&file, "no capture").unwrap();
    for file in [file.to_str().unwrap(), "/nowhere/line.pcapng"] {
        let (code, _, stderr) = run(&[file]);
        assert_eq!(code, Some(5), "{stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }
    let (code, _, stderr) = run(&["--link", "serial:/nowhere/tty", "--station", STATION]);
    assert_eq!(code, Some(5), "{stderr}");
}

/// A master whose stations are configured to something else, until it has heard that no data exchange comes.
#[test]
fn no_data_exchange_ends_it_with_3_and_the_reason() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (link, json, junit) = (file("bus"), file("v.json"), file("v.xml"));
    let spec = format!("pty:{link}");
    let station = ["--station", "5,ident=9999,cfg=2313", "--only", "M-U*,M-P05"];
    let (mut child, _, mut stdout) =
        start(&[&["--link", &spec, "--json", &json, "--junit", &junit][..], &station].concat());
    let _master = masters::Running::on_terminal_with(Path::new(&link), &[5]);
    let mut table = String::new();
    stdout.read_to_string(&mut table).unwrap();
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!(end_of(&mut child).code(), Some(3), "{table}{stderr}");
    let why = "data exchange with station 5 was not reached: Set_Prm refused: ident 1234, configured 9999";
    assert!(stderr.contains(why) && table.contains(why), "{table}{stderr}");
    let report: Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!((&report["ended"], &report["status"]), (&Value::from(why), &Value::from(3)));
    let junit = fs::read_to_string(&junit).unwrap();
    assert!(junit.contains("errors=\"1\"") && junit.contains("<error type=\"not finished\""), "{junit}");
}

#[test]
fn a_judgement_that_is_interrupted_ends_with_4() {
    let dir = tempfile::tempdir().unwrap();
    let link = dir.path().join("bus");
    let spec = format!("pty:{}", link.display());
    let (mut child, _, mut stdout) = start(&["--link", &spec, "--station", STATION]);
    let _master = masters::Running::on_terminal_with(&link, &[5]);
    thread::sleep(Duration::from_secs(1));
    let pid = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let mut table = String::new();
    stdout.read_to_string(&mut table).unwrap();
    assert_eq!(end_of(&mut child).code(), Some(4), "{table}");
    assert!(table.ends_with("ended: the judgement was stopped\n"), "{table}");
}

#[test]
fn a_judgement_out_of_time_ends_with_4() {
    let dir = tempfile::tempdir().unwrap();
    let link = dir.path().join("bus");
    let spec = format!("pty:{}", link.display());
    let (mut child, _, mut stdout) = start(&["--link", &spec, "--station", STATION, "--time", "2"]);
    let _master = masters::Running::on_terminal_with(&link, &[5]);
    let mut table = String::new();
    stdout.read_to_string(&mut table).unwrap();
    assert_eq!(end_of(&mut child).code(), Some(4), "{table}");
    assert!(table.ends_with("ended: the time for the judgement was over\n"), "{table}");
}

#[test]
fn what_must_be_judged_and_is_not_ends_it_with_4() {
    let dir = tempfile::tempdir().unwrap();
    let link = dir.path().join("bus");
    let spec = format!("pty:{}", link.display());
    // Rows of a ring, which the master does not have; the other row is judged.
    for (only, require, why) in [
        ("M-K01", "M-K01", "rows that must be judged were not: M-K01"),
        ("M-K01", "", "no row was judged"),
        ("M-F01,M-T01", "M-T*", "rows that must be judged were not: M-T01"),
    ] {
        let require = if require.is_empty() { vec![] } else { vec!["--require", require] };
        let more = ["--link", &spec, "--station", STATION, "--only", only];
        if require == ["--require", "M-T*"] {
            let (code, _, stderr) = run(&[&more[..], &require].concat());
            assert_eq!(code, Some(2), "{stderr}");
            assert!(stderr.contains("--require names M-T02, which --only does not"), "{stderr}");
            continue;
        }
        let (mut child, _, mut stdout) = start(&[&more[..], &require].concat());
        let _master = masters::Running::on_terminal_with(&link, &[5]);
        let mut table = String::new();
        stdout.read_to_string(&mut table).unwrap();
        assert_eq!(end_of(&mut child).code(), Some(4), "{table}");
        assert!(table.contains(why), "{table}");
    }
}
