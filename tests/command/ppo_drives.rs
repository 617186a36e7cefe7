//! `emulate --ppo-drive`: drives of the profile, as their users run them.

use serde_json::Value;

use crate::emulator::{Emulator, output};

fn file(name: &str) -> String {
    format!("{}/examples/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn drives_of_the_profile_are_drives_of_the_ready_line() {
    let described = format!("7,gsd={},parameters={}", file("ppo_drive.gsd"), file("ppo_drive.toml"));
    let table = format!("8,ppo=2,ident=80D1,parameters={}", file("ppo_drive.csv"));
    let one = format!("9,gsd={}/tests/gsd/compact.gsd", env!("CARGO_MANIFEST_DIR"));
    let drives = ["--drive", "5", "--ppo-drive", &described, "--ppo-drive", &table, "--ppo-drive", &one];
    let emulator = Emulator::start(&drives);
    assert!(emulator.ready.ends_with(" drives=5,7,8,9\n"), "{}", emulator.ready);
    emulator.signal("TERM");
    let (code, _, log) = emulator.end();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("drive of PROFIDRIVE version 2, PPO 2, ident 0x80D1, at address 8"), "{log}");
    // What its file has.
    assert!(log.contains("drive of PROFIDRIVE version 2, PPO 1, ident 0x0A01, at address 9"), "{log}");
}

#[test]
fn what_is_wrong_with_a_drive_is_one_line_and_nothing_is_started() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let twice = place("twice.csv", "pnu,name,type\n1,a,int16\n1,b,int16\n");
    let tie = place("tie.toml", "[[parameter]]\npnu = 1\nname = \"a\"\ntype = \"int16\"\ntie = \"lod\"\n");
    let zero = place("zero.csv", "pnu,name,type,default,tie\n1,a,int16,0,reference-speed\n");
    let text = place("table.txt", "");
    for (drives, words) in [
        (vec!["7,parameters=/nowhere.csv".to_owned()], "cannot read /nowhere.csv: "),
        (vec![format!("7,parameters={twice}")], "twice.csv: line 3: PNU 1 is in the table twice"),
        (vec![format!("7,parameters={tie}")], "tie.toml: line 5: there is nothing called 'lod'"),
        (vec![format!("7,parameters={zero}")], "PNU 1 a: the drive does not take its default"),
        (vec![format!("7,parameters={text}")], "the name of a table ends in .toml or .csv"),
        (vec!["7".into(), "7".into()], "two drives have address 7; give each drive its own"),
        (vec!["7,ppo=6".into()], "ppo '6' is unknown; expected 1, 2, 3, 4 or 5"),
    ] {
        let mut arguments = vec!["emulate"];
        arguments.extend(drives.iter().flat_map(|drive| ["--ppo-drive", drive]));
        let output = output(&arguments);
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{log}");
        assert!(log.contains(words), "{log}");
    }
}

/// What `profidrive master` says to a drive: exit code, stdout as JSON if it is, stderr.
fn asked(link: &str, arguments: &[&str]) -> (Option<i32>, Value, String) {
    let common = ["master", "--link", link, "--address", "7", "--ppo", "1", "--json"];
    let gsd = file("ppo_drive.gsd");
    let table = file("ppo_drive.toml");
    let output = output(&[&common[..], &["--gsd", &gsd, "--parameters", &table], arguments].concat());
    let said = String::from_utf8(output.stdout).unwrap();
    let last = said.lines().last().unwrap_or_default();
    let json = serde_json::from_str(&said).or_else(|_| serde_json::from_str(last)).unwrap_or(Value::Null);
    (output.status.code(), json, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn the_master_commissions_a_drive_of_the_profile() {
    let drive = format!("7,gsd={},parameters={}", file("ppo_drive.gsd"), file("ppo_drive.toml"));
    let emulator = Emulator::start(&["--ppo-drive", &drive]);
    let ask = |arguments: &[&str]| asked(emulator.link(), arguments);
    let done = |arguments: &[&str]| {
        let (code, json, log) = ask(arguments);
        assert_eq!(code, Some(0), "{arguments:?}: {log}");
        json
    };
    let status = done(&["status"]);
    assert_eq!(status["state"], "ready for switching on");
    assert_eq!(status["why"][0], "OFF1: set STW bit 0 (ON)");
    let written = done(&["write", "ramp-up time", "3"]);
    assert_eq!((&written["value"], &written["before"]), (&3.0.into(), &20.0.into()));
    assert_eq!(done(&["read", "2"])["text"], "3 (0.3 s)");
    assert_eq!(done(&["read", "fixed speeds.3"])["value"], 70000.0);
    assert_eq!(done(&["write", "load", "12.5"])["value"], 12.5);
    let params = done(&["params"]);
    assert!(params["parameters"].as_array().unwrap().len() > 20, "{params}");
    let turned = done(&["velocity", "750", "--for", "1s", "--yes"]);
    assert_eq!(turned["outcome"], "turned");
    assert!((turned["actual"].as_f64().unwrap() - 8192.0).abs() < 500.0, "{turned}");
    assert_eq!(done(&["enable", "--for", "100ms", "--yes"])["outcome"], "held enabled");

    // A fault on purpose, by the parameter that is tied to it.
    done(&["write", "raise a fault", "77"]);
    let status = done(&["status"]);
    assert_eq!((&status["state"], &status["faults"][0]), (&"fault".into(), &77.into()));
    let (code, _, log) = ask(&["velocity", "750", "--yes"]);
    assert_eq!(code, Some(1));
    assert!(log.contains("the drive is in fault") && log.contains("77"), "{log}");
    assert_eq!(done(&["faults"])["standing"][0], 77);
    done(&["ack"]);
    assert_eq!(done(&["faults"])["acknowledged"][0], 77);
    assert_eq!(done(&["stop"])["outcome"], "OFF1, operation is disabled");

    for (arguments, code, words) in [
        (&["read", "rampup tim"][..], 2, "close to it are 2 ramp-up time"),
        (&["write", "2", "6501"], 2, "takes 0 to 6500, got 6501"),
        (&["write", "2", "0.5"], 2, "takes a whole number"),
        (&["write", "10", "1"], 2, "can only be read"),
        (&["read", "999"], 1, "no such parameter number"),
        (&["velocity", "9999", "--yes"], 1, "199.99 %"),
        (&["velocity", "9"], 2, "needs --yes"),
        (&["move", "9", "--yes"], 2, "with --ppo there are read"),
    ] {
        let (got, _, log) = ask(arguments);
        assert_eq!(got, Some(code), "{arguments:?}: {log}");
        assert!(log.contains(words), "{arguments:?}: {log}");
    }
}

#[test]
fn a_drive_without_table_is_read_by_number_and_one_without_ppo_is_not_asked() {
    let emulator = Emulator::start(&["--ppo-drive", "7,ppo=1"]);
    let master = |arguments: &[&str]| {
        let common = ["master", "--link", emulator.link(), "--address", "7"];
        let output = output(&[&common[..], arguments].concat());
        let said = [output.stdout, output.stderr].map(|octets| String::from_utf8(octets).unwrap());
        (output.status.code(), said.concat())
    };
    let (code, said) = master(&["--ppo", "1", "read", "918"]);
    assert_eq!((code, said.contains("node address") && said.contains(" 7")), (Some(0), true), "{said}");
    let (code, said) = master(&["--ppo", "1", "params"]);
    assert!(code == Some(0) && said.contains("930"), "{said}");
    for (arguments, code, words) in [
        (&["--ppo", "1", "velocity", "9", "--yes"][..], 2, "add --reference-speed RPM"),
        (&["--ppo", "3", "read", "918"], 2, "has no parameter channel"),
        (&["--ppo", "2", "status"], 1, "refuses its configuration"),
        (&["--parameters", "x.toml", "status"], 2, "add --ppo"),
        (&["status"], 1, "its ident number is 5044, expected 0AC5"),
    ] {
        let (got, said) = master(arguments);
        assert_eq!(got, Some(code), "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
}
