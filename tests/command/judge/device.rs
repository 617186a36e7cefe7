//! `profidrive judge --slave`: a device behind a terminal, TCP, or a terminal of the judge.

use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread;

use serde_json::Value;

use super::{run, start};

/// An emulator, and what a master opens.
struct Emulator(Child, String);

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn emulate(arguments: &[&str]) -> Emulator {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command.arg("emulate").args(arguments).env_remove("RUST_LOG");
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut ready = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut ready).unwrap();
    let link = ready.split_whitespace().find_map(|word| word.strip_prefix("link=")).unwrap().to_string();
    Emulator(child, link)
}

/// Rows that are judged in a moment.
const SOME: &str = "S-F01,S-F1*,S-C*,S-P0*,S-G*,S-D*,S-X*,S-T*";

#[test]
fn a_drive_at_a_terminal_passes_and_the_reports_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let (bus, json) = (folder.path().join("bus"), folder.path().join("verdicts.json"));
    let drive = emulate(&["--drive", "5", "--link", &format!("pty:{}", bus.display())]);
    let (status, stdout, stderr) =
        run(&["--slave", "5", "--link", &drive.1, "--only", SOME, "--json", json.to_str().unwrap()]);
    assert_eq!(status, Some(0), "{stdout}{stderr}");
    assert!(stdout.contains("slave=5") && stdout.contains("  pass       S-X01"), "{stdout}");
    let report: Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!((&report["status"], &report["configuration"]["ident"]), (&0.into(), &"0AC5".into()));
    let rows = report["rows"].as_array().unwrap();
    assert!(rows.iter().any(|row| row["id"] == "S-D08" && row["verdict"] == "pass"), "{report}");
    assert!(rows.iter().all(|row| row["rule"].is_string()), "{report}");
    // A serial line without times: no reply is too early on it.
    let serial = format!("serial:{}", bus.display());
    let (status, stdout, stderr) =
        run(&["--slave", "5", "--link", &serial, "--baud", "19200", "--only", "S-T*,S-F01", "--quick"]);
    assert_eq!(status, Some(0), "{stdout}{stderr}");
    assert!(stdout.contains("pass       S-T03") && stdout.contains("not_judged S-T01"), "{stdout}");
}

#[test]
fn a_slave_behind_tcp_and_one_that_opens_the_terminal_of_the_judge() {
    let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/gsd/PDRV494F.GSD");
    let spec = format!("7,gsd={gsd}");
    let station = emulate(&["--station", &spec, "--link", "tcp:127.0.0.1:0"]);
    let (status, stdout, stderr) =
        run(&["--slave", &spec, "--link", &station.1, "--only", "S-F14,S-P0*,S-K*", "--quick"]);
    assert_eq!(status, Some(0), "{stdout}{stderr}");

    let folder = tempfile::tempdir().unwrap();
    let link = format!("pty:{}", folder.path().join("bus").display());
    let (mut judge, ready, mut rest) =
        start(&["--slave", "5", "--link", &link, "--only", "S-X01,S-P0*,S-D01", "--moves-allowed"]);
    let bus = ready.split_whitespace().find_map(|word| word.strip_prefix("link=")).unwrap();
    let _drive = emulate(&["--drive", "5", "--link", &format!("serial:{bus}"), "--baud", "500000"]);
    let mut stdout = String::new();
    rest.read_to_string(&mut stdout).unwrap();
    assert_eq!(judge.wait().unwrap().code(), Some(0), "{stdout}");
}

/// The place behind `tcp:` in a ready line.
fn tcp_of(link: &str) -> TcpStream {
    TcpStream::connect(link.strip_prefix("tcp:").unwrap()).unwrap()
}

#[test]
fn a_slave_that_connects_to_the_judge() {
    let (mut judge, ready, mut rest) = start(&[
        "--slave",
        "5",
        "--link",
        "tcp-listen:127.0.0.1:0",
        "--only",
        "S-X01,S-P0*,S-D0*",
        "--quick",
    ]);
    let place = ready.split_whitespace().find_map(|word| word.strip_prefix("link=")).unwrap();
    let drive = emulate(&["--drive", "5", "--link", "tcp:127.0.0.1:0"]);
    // A gateway: it connects to both.
    let (to_judge, to_drive) = (tcp_of(place), tcp_of(&drive.1));
    for stream in [&to_judge, &to_drive] {
        stream.set_nodelay(true).unwrap();
    }
    for (mut from, mut to) in
        [(to_judge.try_clone().unwrap(), to_drive.try_clone().unwrap()), (to_drive, to_judge)]
    {
        thread::spawn(move || io::copy(&mut from, &mut to));
    }
    let mut stdout = String::new();
    rest.read_to_string(&mut stdout).unwrap();
    assert_eq!(judge.wait().unwrap().code(), Some(0), "{stdout}");
}

#[test]
fn the_rates_of_a_serial_line_and_a_soak() {
    let folder = tempfile::tempdir().unwrap();
    let bus = folder.path().join("bus");
    let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/gsd/PDRV494F.GSD");
    let spec = format!("7,gsd={gsd}");
    let _station = emulate(&["--station", &spec, "--link", &format!("pty:{}", bus.display())]);
    let serial = format!("serial:{}", bus.display());
    // The file has no Auto_Baud_supp; the station hears every rate of a terminal, so there is nothing to do for it.
    let rows = "S-X01,S-P01,S-G01,S-R*";
    let (status, stdout, stderr) = run(&[
        "--slave",
        &spec,
        "--link",
        &serial,
        "--baud",
        "19200,500000",
        "--only",
        rows,
        "--soak",
        "2s",
        "--seed",
        "7",
        "--ask",
        "true",
    ]);
    assert_eq!(status, Some(0), "{stdout}{stderr}");
    assert!(stdout.contains("pass       S-R07"), "{stdout}");
    assert!(stdout.contains("not_judged S-R08"), "{stdout}");
    assert!(stderr.contains("again, about"), "{stderr}");
    // Each rate of its file.
    let (status, stdout, stderr) =
        run(&["--slave", &spec, "--link", &serial, "--baud", "gsd", "--only", rows, "--ask", "true"]);
    assert_eq!(status, Some(0), "{stdout}{stderr}");
    let judged = stdout.lines().filter(|line| line.contains("pass       S-R")).count();
    assert!(judged >= 6, "{stdout}");
}

#[test]
fn records_of_a_slave_of_dp_v1_are_judged() {
    let folder = tempfile::tempdir().unwrap();
    let [bus, gsd, records] = ["bus", "v1.gsd", "records.toml"].map(|name| folder.path().join(name));
    let text = "#Profibus_DP\nIdent_Number=0x1234\n500_supp=1\nDPV1_Slave=1\nC1_Read_Write_supp=1\nC2_Read_Write_supp=1\n\
        C2_Max_Count_Channels=2\nMax_User_Prm_Data_Len=3\nExt_User_Prm_Data_Const(0)=0x80,0,0\nModule=\"word\" 0x70\nEndModule\n";
    fs::write(&gsd, text).unwrap();
    fs::write(&records, "[[record]]\nslot = 1\nindex = 10\ndata = \"01 02 03 04\"\n").unwrap();
    let spec = format!("7,gsd={},records={}", gsd.display(), records.display());
    let station = emulate(&["--station", &spec, "--link", &format!("pty:{}", bus.display())]);
    let (status, stdout, stderr) =
        run(&["--slave", &spec, "--link", &station.1, "--only", "S-X01,S-F13,V1-*", "--write", "--quick"]);
    assert_eq!(status, Some(0), "{stdout}{stderr}");
    for row in ["V1-R06", "V1-R23", "V1-R70", "V1-R75"] {
        assert!(stdout.contains(&format!("pass       {row}")), "{row}: {stdout}");
    }
}

#[test]
fn nobody_is_no_verdict_and_a_failure_shows_what_was_expected() {
    let folder = tempfile::tempdir().unwrap();
    let bus = folder.path().join("bus");
    let drive = emulate(&["--drive", "5", "--link", &format!("pty:{}", bus.display())]);
    let (status, stdout, stderr) = run(&["--slave", "6", "--link", &drive.1]);
    assert_eq!(status, Some(3), "{stdout}");
    assert!(stderr.contains("profidrive: nobody answered at this address"), "{stderr}");
    // Another ident number than the drive has.
    let (status, stdout, _) =
        run(&["--slave", "5,ident=1234", "--link", &drive.1, "--only", "S-P01,S-G01,S-X01"]);
    assert_eq!(status, Some(3), "{stdout}");
    assert!(stdout.contains("the rule: all good: Master_Add = SA"), "{stdout}");
    assert!(stdout.contains("after S-P01, which failed"), "{stdout}");
}

#[test]
fn who_stands_beside_the_slave_is_asked() {
    let folder = tempfile::tempdir().unwrap();
    let bus = folder.path().join("bus");
    let log = folder.path().join("log");
    let drive = emulate(&["--drive", "5", "--link", &format!("pty:{}", bus.display())]);
    // Nothing is switched off, and it does not know how to file a diagnosis.
    let ask = format!("echo \"$@\" >>{}; test power-cycle =", log.display());
    let (status, stdout, stderr) =
        run(&["--slave", "5", "--link", &drive.1, "--only", "S-D03,S-W05", "--ask", &ask]);
    assert_eq!(status, Some(1), "{stdout}{stderr}");
    assert!(stdout.contains("--ask does not do 'set-diag 0201'"), "{stdout}");
    assert!(stdout.contains("after a power cycle it does not wait for Set_Prm"), "{stdout}");
    let asked = fs::read_to_string(&log).unwrap();
    assert!(asked.lines().any(|line| line == "power-cycle"), "{asked}");
}

#[test]
fn a_command_line_that_cannot_be_is_refused() {
    for (arguments, words) in [
        (&["--slave", "5", "--station", "5,ident=1234,cfg=2313"][..], "cannot be used with"),
        (&["--slave", "5", "--link", "serial:/dev/null"][..], "needs its rate"),
        (&["--slave", "5", "--only", "M-C03"][..], "no row of a slave is named 'M-C03'"),
        (&["--slave", "2", "--master", "2"][..], "is the address of the slave"),
        (&["--quick", "--station", "5,ident=1234,cfg=2313"][..], "--slave"),
        (&["--slave", "5,modules='A'"][..], "gsd=FILE"),
        (&["--slave", "5", "--baud", "gsd"][..], "needs the device file"),
        (&["--station", "5,ident=1234,cfg=2313", "--baud", "gsd"][..], "is for judge --slave"),
    ] {
        let (status, _, stderr) = run(arguments);
        assert_eq!(status, Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(words), "{arguments:?}: {stderr}");
    }
}
