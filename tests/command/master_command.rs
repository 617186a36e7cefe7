//! `profidrive master`, run as a process against `profidrive emulate`: every subcommand over a pseudo-terminal and over
//! TCP, every failure with its exit code and its one line, and what happens to a drive when the command is interrupted.

pub(crate) mod rig;

use core::time::Duration;
use std::fs::{self, OpenOptions};
use std::io::Read;
use std::path::Path;
use std::thread;
use std::time::Instant;

use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::host::link::pty::Pty;
use profidrive::host::{Bus, Clock, Link, Received, Stop, SystemClock, run};
use profidrive::profibus::dp::{Description, Fixed, Station};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;
use rig::{Emulator, Running, fails, profidrive};
use serde_json::Value;

use crate::patience::PATIENCE;
use crate::process::hangup_ends_programs;

/// Each part has an emulator of its own, and all of them run at the same time: most of it is waiting for the token.
fn play_everything(link: &str) {
    let parts: [fn(&Emulator); 4] = [look, save_and_restore, travel, command_and_turn];
    thread::scope(|scope| {
        for part in parts {
            scope.spawn(move || part(&Emulator::start(link, &[])));
        }
    });
}

fn look(emulator: &Emulator) {
    let scan = |arguments: &[&str]| {
        let (code, stdout, stderr) = Running::start(emulator.patiently("5", arguments)).end();
        assert_eq!((code, stderr.as_str()), (Some(0), ""), "{stdout}");
        stdout
    };
    let text = scan(&["scan", "4-7"]);
    assert_eq!(text.matches("SIKO AG03 or AG03/1 (ident number 0AC5), no master").count(), 2, "{text}");
    let stations: Value = serde_json::from_str(&scan(&["scan", "6", "--json"])).unwrap();
    assert_eq!(stations["stations"][0]["address"], 6);
    let diag = emulator.works("5", &["diag"]);
    assert!(diag.contains("no master, ident 0AC5") && diag.contains("Prm_Req"), "{diag}");
    assert_eq!(emulator.json("5", &["diag"])["parameters_required"], true);
    for v_pos in ["1004", "0x3EC", "3ECh"] {
        assert!(
            emulator.works("5", &["read", v_pos]).contains("v-Pos                       30 rpm"),
            "{v_pos}"
        );
    }
    assert_eq!(emulator.json("5", &["write", "limit2", "-0x10"])["value"], -16);
    assert_eq!(emulator.json("6", &["read", "software version"])["text"], "3.00");
    assert!(emulator.works("5", &["read", "945.0"]).contains("no fault"));
    let written = emulator.works("5", &["write", "v-pos", "60"]);
    assert!(written.contains("60 rpm, was 30 rpm"), "{written}");
    assert_eq!(emulator.json("5", &["write", "limit2", "-250000"])["value"], -250_000);
    let params = emulator.works("5", &["params"]);
    assert_eq!(params.lines().count(), 49, "40 to read, one of them ten times: {params}");
    let params = emulator.json("6", &["params"]);
    assert_eq!(params["drive"]["model"], "ag03");
    assert_eq!(params["parameters"].as_array().unwrap().len(), 43);
}

/// Saved, lost, restored: the same.
fn save_and_restore(emulator: &Emulator) {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (before, after) = (file("before.json"), file("after.json"));
    emulator.works("5", &["write", "v-Pos", "60"]);
    emulator.works("5", &["write", "1017", "-250000"]);
    assert!(emulator.works("5", &["save", &before]).contains("25 parameters of drive 5 saved"));
    emulator.works("5", &["write", "970", "1", "--yes"]);
    assert!(emulator.works("5", &["read", "1004"]).contains("30 rpm"), "a factory reset");
    let dry = emulator.works("5", &["restore", &before, "--dry-run"]);
    assert!(dry.contains("v-Pos                       30 rpm -> 60 rpm") && dry.contains("2 of 25"), "{dry}");
    assert!(emulator.works("5", &["read", "1004"]).contains("30 rpm"), "a dry run");
    let restored = emulator.works("5", &["restore", &before]);
    assert!(restored.contains("2 written, all 25 read back as in the file"), "{restored}");
    emulator.works("5", &["save", &after]);
    assert_eq!(fs::read_to_string(&before).unwrap(), fs::read_to_string(&after).unwrap());
    // A pipe can be read once.
    let mut piped = emulator.command("5", &["restore", "-"]);
    piped.stdin(fs::File::open(&before).unwrap());
    let (code, stdout, stderr) = Running::start(piped).end();
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("all 25 parameters are as in the file"), "{stdout}");
}

fn travel(emulator: &Emulator) {
    let moved = emulator.json("5", &["move", "--yes", "300"]);
    assert_eq!(moved["outcome"], "reached");
    assert!((290..=310).contains(&moved["position"].as_i64().unwrap()), "{moved}");
    let jogged = emulator.json("5", &["jog", "-", "--yes", "--for", "300ms"]);
    assert!(jogged["position"].as_i64().unwrap() < 300, "{jogged}");
    assert_eq!(emulator.json("5", &["jog", "+", "--yes", "--for", "300ms"])["outcome"], "turned");
    assert!(emulator.works("5", &["stop"]).contains("the drive stands"));
    emulator.fails("5", &["move", "--yes", "3mm"], 2, "the drive counts positions in increments");
    emulator.works("5", &["write", "spindle pitch", "4mm"]);
    assert!(emulator.works("5", &["write", "limit1", "800.5mm"]).contains("800.50 mm"));
    assert!(emulator.works("5", &["move", "--yes", "1.25mm"]).contains("reached; position 1.2"));
    emulator.fails("5", &["move", "--yes", "300inc"], 2, "the drive counts positions in 0.01 mm");
    emulator.fails("5", &["write", "limit1", "9inc"], 2, "the drive counts positions in 0.01 mm");
    emulator.works("5", &["write", "spindle pitch", "0"]);
    assert!(emulator.works("5", &["calibrate", "-7inc", "--yes"]).contains("calibrated: position -7 inc"));
    assert_eq!(emulator.json("5", &["calibrate", "--yes"])["position"], -7);
}

fn command_and_turn(emulator: &Emulator) {
    let status = emulator.works("5", &["status"]);
    let parts = [
        "positioning mode: ready to turn on, stands still; position 0 inc",
        "STW 0000",
        "ZSW 2",
        "SSW 0",
        "GSR 0010",
        "does not move: operation is not enabled (ZSW.2 = 0)",
        "next: send STW 003B, wait for ZSW.2 = 1, then 007B with the target in HSW",
    ];
    for part in parts {
        assert!(status.contains(part), "{status}");
    }
    let why = &emulator.json("5", &["status"])["why"];
    assert_eq!(why["hindrances"].as_array().unwrap().len(), 1, "{why}");
    assert_eq!(emulator.json("5", &["status"])["zsw"]["bits"]["operation-enabled"], false);
    assert!(emulator.works("5", &["enable", "--yes", "--for", "50ms"]).contains("held enabled"));
    assert!(emulator.works("5", &["ack"]).contains("no fault is latched"));
    assert_eq!(emulator.json("5", &["faults"])["count"], 0);
    assert!(emulator.works("5", &["faults", "--clear"]).contains("cleared; 0 faults"));
    emulator.works("6", &["write", "operating mode", "1"]);
    assert_eq!(emulator.json("6", &["velocity", "-120", "--yes", "--for", "300ms"])["outcome"], "turned");
    let monitor = emulator.works("6", &["monitor", "--for", "50ms"]);
    assert!(monitor.contains("velocity 0 rpm"), "{monitor}");
}

#[test]
fn every_subcommand_works_over_a_pseudo_terminal() {
    play_everything("pty");
}

#[test]
fn every_subcommand_works_over_tcp() {
    play_everything("tcp:127.0.0.1:0");
}

#[test]
fn what_cannot_be_is_refused_with_2_before_anything_is_sent() {
    let nowhere = Emulator::nowhere("/dev/pts/none");
    for (arguments, says) in [
        (&["read", "999"][..], "there is no parameter 999; near it are 1000 Controller parameter P"),
        (&["read", "v-Poss"], "close to it are 1004 v-Pos"),
        (&["read", "945"], "is an array of 10; name the element, for example 945.0"),
        (&["write", "1004", "201"], "v-Pos (PNU 1004) takes 1 to 200, got 201"),
        (&["write", "952", "0"], "Number of faults (PNU 952) can only be read"),
        (&["write", "1004", "fast"], "expected a number such as 60"),
        (&["write", "1004", "-x"], "expected a number such as 60"),
        (&["calibrate", "9999999"], "Calibration value (PNU 1018) takes -999999 to 999999, got 9999999"),
        (&["calibrate"], "replaces what the drive keeps needs --yes"),
        (&["write", "970", "1"], "replaces what the drive keeps needs --yes"),
        (&["write", "v-Pos", "60mm"], "v-Pos (PNU 1004) has not the unit mm; expected rpm, got 60 mm"),
        (&["move", "0.005mm", "--yes"], "the smallest step is 0.01 mm"),
        (&["move", "5"], "can turn a shaft needs --yes"),
        (&["velocity", "30"], "needs --yes"),
        (&["velocity", "201", "--yes"], "a drive turns with at most 200 rpm, got 201"),
        (&["jog", "up", "--yes"], "expected + or -"),
        (&["scan", "9-1"], "the range 9-1 is empty"),
        (&["monitor", "--for", "5"], "expected a time such as 500ms or 2s"),
        (&["fly"], "'fly'"),
        (&["stauts"], "did you mean 'faults' or 'status'?"),
        (&["status", "--watchdgo", "1s"], "did you mean '--watchdog'?"),
        (&["status", "--master-address", "5"], "address 5 is that of this master"),
        (&["status", "--baud", "115200"], "expected one of 9600, 19200"),
    ] {
        nowhere.fails("5", arguments, 2, says);
    }
    nowhere.fails("126", &["status"], 2, "set the DIP switches");
    nowhere.fails("127", &["status"], 2, "expected an address from 0 to 126");
    for (arguments, says) in [
        (&["master", "status"][..], "add --link with what 'profidrive emulate' prints as link="),
        (&["master", "--link", "/dev/pts/none", "status"], "the drive is missing; add --address N"),
        (&["master", "--link", "usb", "status"], "pty:PATH, serial:DEVICE or tcp:HOST:PORT"),
        (&["master", "--link", "serial:/dev/null", "--address", "5", "status"], "--baud 19200"),
        (&["master"], "a command is missing"),
    ] {
        let (code, _, stderr) = Running::start(profidrive(arguments)).end();
        assert_eq!(code, Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(says) && stderr.lines().count() == 1, "{arguments:?}: {stderr}");
        assert!(stderr.contains("see 'profidrive master --help'"), "{stderr}");
    }
}

#[test]
fn a_file_that_is_no_parameter_set_is_refused_before_the_drive_is_taken() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("set.json");
    let nowhere = Emulator::start("pty", &[]);
    let path = file.to_str().unwrap();
    nowhere.fails("5", &["restore", path], 1, "No such file or directory");
    fs::write(&file, "{}").unwrap();
    nowhere.fails("5", &["restore", path], 2, "no parameter set");
    let set = |row: &str| format!(r#"{{"format":"profidrive parameter set 1","parameters":[{row}]}}"#);
    fs::write(&file, set(r#"{"pnu":1004,"value":0}"#)).unwrap();
    nowhere.fails("5", &["restore", path], 2, "v-Pos (PNU 1004) takes 1 to 200, got 0");
    // For one drive, but not for this one.
    fs::write(&file, set(r#"{"pnu":1004,"value":150}"#)).unwrap();
    nowhere.fails(
        "5",
        &["restore", path],
        1,
        "takes 1..100 on this AG03/1 with gear 48:1; nothing was written",
    );
    nowhere.works("6", &["restore", path]);
    nowhere.fails("5", &["save", "/no/such/folder/set.json"], 1, "cannot write /no/such/folder/set.json");
}

#[test]
fn every_subcommand_has_help_with_an_example() {
    let help = |arguments: &[&str]| {
        let arguments = [&["master"], arguments, &["--help"]].concat();
        let (code, stdout, stderr) = Running::start(profidrive(&arguments)).end();
        assert_eq!((code, stderr.as_str()), (Some(0), ""), "{arguments:?}");
        stdout
    };
    let all = help(&[]);
    for action in [
        "scan",
        "diag",
        "read",
        "write",
        "params",
        "save",
        "restore",
        "status",
        "enable",
        "move",
        "jog",
        "velocity",
        "stop",
        "ack",
        "faults",
        "calibrate",
        "monitor",
    ] {
        assert!(all.contains(&format!("\n  {action} ")), "{action}: {all}");
        let help = help(&[action]);
        assert!(help.contains("Example") && help.contains(&format!(" {action}")), "{help}");
    }
}

/// A program that reads JSON gets JSON from a failure too.
#[test]
fn with_json_a_failure_is_an_object() {
    let nowhere = Emulator::nowhere("/dev/pts/none");
    for (arguments, code, says) in [
        (&["status"][..], 1, "check the name"),
        (&["read", "v-Poss"], 2, "close to it are 1004 v-Pos"),
        (&["stauts"], 2, "did you mean 'faults' or 'status'?"),
    ] {
        let (ended, stdout, stderr) = nowhere.master("5", &[arguments, &["--json"]].concat());
        let object: serde_json::Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!((ended, &object["exit_code"]), (Some(code), &code.into()), "{stdout}{stderr}");
        let line = object["error"].as_str().unwrap();
        assert!(line.contains(says) && stderr.contains(line), "{line}: {stderr}");
    }
}

#[test]
fn a_link_that_does_not_open_ends_with_1_and_one_line() {
    let mut nowhere = Emulator::nowhere("");
    for (link, says) in [
        ("/dev/pts/none", "check the name, that the adapter is plugged in or the emulator runs"),
        ("pty:/dev/null", "name the terminal that 'profidrive emulate' prints"),
        ("tcp:127.0.0.1:9", "cannot connect to tcp:127.0.0.1:9 (check that the emulator runs there)"),
    ] {
        nowhere.link = link.into();
        nowhere.fails("5", &["status"], 1, says);
    }
}

#[test]
fn a_drive_that_is_not_there_or_refuses_is_explained() {
    type Part = (&'static [&'static str], fn(&Emulator));
    let parts: [Part; 4] = [
        (&[], |emulator| {
            emulator.fails("7", &["status"], 1, "no answer from station 7; check that it is switched on");
            emulator.fails(
                "5",
                &["write", "1004", "150"],
                1,
                "it takes 1..100 on an AG03/1 with gear 48:1, got 150",
            );
            emulator.fails(
                "6",
                &["read", "1039"],
                1,
                "only the AG03/1 has d-Pos (PNU 1039); this drive is an AG03",
            );
            emulator.fails(
                "5",
                &["velocity", "30", "--yes"],
                1,
                "write 1 to PNU 930 first; the drive stands",
            );
            emulator.works("5", &["write", "limit1", "100"]);
            fails(emulator.patiently("5", &["move", "101", "--yes"]), 1, "the target is beyond a limit");
        }),
        (&["--fault", "refuse-cfg"], |emulator| {
            emulator.fails(
                "5",
                &["status"],
                1,
                "drive 5 refuses its configuration (Chk_Cfg): it is not what its GSD says",
            );
        }),
        (&["--fault", "refuse-prm"], |emulator| {
            emulator.fails("5", &["status"], 1, "drive 5 refuses its parameters (Set_Prm)");
        }),
        (&["--fault", "not-ready=100s"], |emulator| {
            emulator.fails("5", &["status"], 1, "drive 5 answers, but does not begin to exchange data");
        }),
    ];
    thread::scope(|scope| {
        for (faults, part) in parts {
            scope.spawn(move || part(&Emulator::start("pty", faults)));
        }
    });
}

/// Another device at the address, in this process.
#[test]
fn another_device_at_the_address_is_named_by_its_ident_number() {
    const OTHER: Description = Description { ident: 0x1234, ..Description::PLAIN };
    const ACCEPTS: Fixed<'static> = Fixed { configurations: &[&[0x20, 0x10]], ..Fixed::PLAIN };
    let mut pty = Pty::open(None).unwrap();
    let link = pty.path().to_str().unwrap().to_owned();
    let (stop, clock, mut bus) = (Stop::new().unwrap(), SystemClock::new(), Bus::new());
    bus.add(Station::new(Address::from_octet(5), BaudRate::K500, None, OTHER, ACCEPTS)).unwrap();
    bus.add(Device::new(Config::new(Address::from_octet(6)), clock.now())).unwrap();
    thread::scope(|scope| {
        let line = scope.spawn(|| run(&mut pty, &mut bus, &clock, &stop, &mut |_| {}));
        let outcome = scope.spawn(|| {
            let emulator = Emulator::nowhere(&link);
            let says = "station 5 is another device: its ident number is 1234, expected 0AC5";
            emulator.fails("5", &["status"], 1, says);
            let (_, scan, _) = Running::start(emulator.patiently("5", &["scan", "5-6"])).end();
            assert!(scan.contains("another slave (ident number 1234), no master"), "{scan}");
            // A master that has gone without a word still owns drive 6.
            let mut owner = Running::start(emulator.command("6", &["monitor", "--master-address", "3"]));
            owner.until("position");
            owner.signal("KILL");
            owner.end();
            emulator.fails(
                "6",
                &["move", "5", "--yes"],
                1,
                "drive 6 belongs to master 3; stop that master first",
            );
            assert!(emulator.works("6", &["diag"]).contains("master 3"));
        });
        let outcome = outcome.join();
        stop.request();
        line.join().unwrap().unwrap();
        if let Err(panic) = outcome {
            std::panic::resume_unwind(panic);
        }
    });
}

#[test]
fn every_signal_that_ends_the_command_stops_the_drive_before() {
    hangup_ends_programs();
    let cases = [
        ("INT", &["move", "900000", "--yes"][..], 1),
        ("TERM", &["move", "-900000", "--yes"], 1),
        ("INT", &["jog", "+", "--yes"], 0),
        ("TERM", &["enable", "--yes"], 0),
        ("HUP", &["move", "900000", "--yes"], 1),
        ("QUIT", &["move", "-900000", "--yes"], 1),
    ];
    thread::scope(|scope| {
        for (signal, arguments, code) in cases {
            scope.spawn(move || ended_by(signal, arguments, code));
        }
    });
}

fn ended_by(signal: &str, arguments: &[&str], code: i32) {
    let emulator = Emulator::start("pty", &[]);
    emulator.works("5", &["write", "1003", "100"]);
    let mut moving = Running::start(emulator.command("5", &[arguments, &["-v"]].concat()));
    let mut stderr = moving.taken();
    if code == 0 {
        moving.until("Ctrl-C ends it");
    } else {
        // So that it is seen turning; when it is stopped earlier, that is as well.
        thread::sleep(Duration::from_millis(500));
    }
    moving.signal(signal);
    let (ended, stdout, _) = moving.end();
    let mut rest = String::new();
    stderr.read_to_string(&mut rest).unwrap();
    assert_eq!(ended, Some(code), "{arguments:?}: {stdout}{rest}");
    if code == 1 {
        assert!(rest.contains("profidrive: interrupted; the drive stands, position"), "{rest}");
    }
    let status = emulator.json("5", &["status"]);
    assert_eq!(status["ssw"]["bits"]["travels"], false, "{arguments:?}");
}

#[test]
fn an_interrupted_scan_has_said_who_is_there() {
    let emulator = Emulator::start("pty", &[]);
    let mut scan = Running::start(emulator.patiently("5", &["scan"]));
    scan.until("  5  SIKO AG03 or AG03/1");
    scan.signal("INT");
    let (code, stdout, stderr) = scan.end();
    assert_eq!(code, Some(1), "{stdout}{stderr}");
    assert!(stderr.contains("profidrive: interrupted; asked up to address "), "{stderr}");
}

#[test]
fn a_terminal_in_use_is_refused_until_its_master_is_gone() {
    let emulator = Emulator::start("pty", &[]);
    let mut first = Running::start(emulator.command("5", &["monitor"]));
    first.until("position");
    emulator.fails("6", &["status", "--master-address", "1"], 1, "it is in use by another program");
    first.signal("KILL");
    first.end();
    emulator.works("6", &["status"]);
}

#[test]
fn two_masters_share_a_line_over_tcp() {
    let emulator = Emulator::start("tcp:127.0.0.1:0", &[]);
    let mut first = Running::start(emulator.command("5", &["monitor"]));
    first.until("position");
    let mut second = emulator.command("6", &["status"]);
    second.args(["--master-address", "1"]);
    let (code, stdout, stderr) = Running::start(second).end();
    assert_eq!((code, stderr.as_str()), (Some(0), ""), "{stdout}");
    first.signal("INT");
    assert_eq!(first.end().0, Some(0), "the first has kept its drive");
}

#[test]
fn a_killed_master_lets_the_watchdog_release_the_motor() {
    let emulator = Emulator::start("pty", &[]);
    let mut command =
        profidrive(&["master", "--link", &emulator.link, "--address", "5", "--watchdog", "100ms"]);
    command.args(["jog", "+", "--yes"]);
    let mut moving = Running::start(command);
    moving.until("turning; Ctrl-C");
    moving.signal("KILL");
    assert_eq!(moving.end().0, None, "killed");
    // The diagnosis touches nothing: it says when the drive has let its master go.
    let start = Instant::now();
    while emulator.json("5", &["diag"])["master"] != Value::Null {
        assert!(start.elapsed() < PATIENCE);
    }
    let status = emulator.json("5", &["status"]);
    assert_eq!(status["ssw"]["bits"]["motor-released"], true);
    assert!(emulator.works("5", &["stop"]).contains("the drive stands"));
}

#[test]
fn a_lost_line_is_said_and_so_is_what_the_drive_does_then() {
    let cases = [
        (&["monitor"][..], "position", "the connection is lost: "),
        (
            &["jog", "+", "--yes"],
            "turning; Ctrl-C",
            "its watchdog releases the motor within 30s, and the shaft coasts",
        ),
    ];
    thread::scope(|scope| {
        for (arguments, begun, says) in cases {
            scope.spawn(move || lost_line(arguments, begun, says));
        }
    });
}

fn lost_line(arguments: &[&str], begun: &str, says: &str) {
    let mut emulator = Emulator::start("tcp:127.0.0.1:0", &[]);
    let mut master = Running::start(emulator.command("5", arguments));
    master.until(begun);
    emulator.running.signal("KILL");
    emulator.running.end();
    let (code, _, stderr) = master.end();
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.contains(says) && stderr.lines().count() == 1, "{arguments:?}: {stderr}");
}

#[test]
fn an_interrupted_restore_says_what_was_written_and_what_was_not() {
    hangup_ends_programs();
    thread::scope(|scope| {
        for signal in ["INT", "HUP"] {
            scope.spawn(move || interrupted_restore(signal));
        }
    });
}

fn interrupted_restore(signal: &str) {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("set.json");
    let rows: Vec<String> = (1000..=1005).map(|pnu| format!(r#"{{"pnu":{pnu},"value":77}}"#)).collect();
    let text = format!(r#"{{"format":"profidrive parameter set 1","parameters":[{}]}}"#, rows.join(","));
    fs::write(&file, text).unwrap();
    // Each answer takes 30 exchanges more, so that there is time for a signal.
    let emulator = Emulator::start("pty", &["--fault", "pkw-delay=30"]);
    let mut restore = Running::start(emulator.patiently("5", &["restore", file.to_str().unwrap()]));
    restore.until("6 of 6 parameters differ");
    restore.signal(signal);
    let (code, stdout, stderr) = restore.end();
    assert_eq!(code, Some(1), "{stderr}");
    assert!(
        stderr.contains("profidrive: interrupted: ") && stderr.contains("of 6 parameters that differ"),
        "{stderr}"
    );
    let written = stdout.lines().filter(|line| line.starts_with("written ")).count();
    let not = stdout.lines().filter(|line| line.starts_with("not written ")).count();
    assert_eq!(written + not, 6, "{stdout}");
    assert!(not > 0, "{stdout}");
}

/// A terminal whose other end the test has, as stdin and stderr of the command.
#[test]
fn somebody_at_a_terminal_is_asked_before_the_drive_moves() {
    let emulator = Emulator::start("pty", &[]);
    for (answer, code) in [("y\n", 0), ("n\n", 1)] {
        let mut person = Pty::open(None).unwrap();
        let open = |path: &Path| OpenOptions::new().read(true).write(true).open(path).unwrap();
        let mut command = emulator.command("5", &["move", "50"]);
        command.stdin(open(person.path())).stderr(open(person.path()));
        let mut moving = Running::start(command);
        let (mut asked, stop) = (Vec::new(), Stop::new().unwrap());
        while !String::from_utf8_lossy(&asked).contains("[y/N]") {
            person.wait(Some(PATIENCE), &stop).unwrap();
            let mut buf = [0; 256];
            if let Received::Octets(count) = person.receive(&mut buf).unwrap() {
                asked.extend_from_slice(&buf[..count]);
            }
        }
        assert!(String::from_utf8_lossy(&asked).contains("Drive 5 will travel to 50"));
        person.send(answer.as_bytes()).unwrap();
        assert_eq!(moving.end().0, Some(code), "{answer}");
    }
}
