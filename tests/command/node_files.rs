//! `profidrive eds`, and nodes from files on the command line and in a line file.

use std::fs;
use std::path::Path;
use std::time::Instant;

use crate::emulator::{Emulator, output};
use crate::nodes::{Master, adapter};
use crate::patience::PATIENCE;

#[test]
fn a_file_of_a_node_is_explained_checked_and_given_as_json() {
    let pump = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds/pump.eds");
    let text = |arguments: &[&str]| String::from_utf8(output(arguments).stdout).unwrap();
    let explained = text(&["eds", pump]);
    for words in [
        "profidrive Pump, no profile",
        "identity: vendor 195h, product 7h, revision 10002h",
        "Services: heartbeat, SYNC, EMCY, store, restore, LSS",
        "  1: $NODEID+0x200, type 255: 0005h:00 gap (8 bits), 2000h:00 Speed wanted (16 bits)",
        "  1: $NODEID+0x40000180, type 1: 2001h:00 Pressure (32 bits), 2002h:00 Position (24 bits)",
    ] {
        assert!(explained.contains(words), "{words}\n{explained}");
    }
    assert!(!explained.contains("Warnings") && !explained.contains("Object dictionary"), "{explained}");
    let objects = text(&["eds", "--objects", pump]);
    assert!(
        objects.contains("  2000h    Speed wanted: INTEGER16 rww = -100; -32767..32767, in PDOs"),
        "{objects}"
    );
    let json: serde_json::Value = serde_json::from_str(&text(&["eds", "--json", pump])).unwrap();
    assert_eq!((&json["vendor_number"], &json["lss"]), (&serde_json::json!(0x195), &serde_json::json!(true)));
    let heartbeat =
        json["objects"].as_array().unwrap().iter().find(|object| object["index"] == "1017").unwrap();
    assert_eq!(heartbeat["entries"][0]["value"], 500);
    assert!(objects.contains("  2007h    Label: UNICODE_STRING rw = \"AB\""), "{objects}");

    assert_eq!(output(&["eds", "check", pump]).status.code(), Some(0));
    let folder = tempfile::tempdir().unwrap();
    let odd = folder.path().join("odd.eds");
    std::fs::write(&odd, "[1017]\nDataType=6\nAccessType=rw\nDefaultValue=70000\n").unwrap();
    let checked = output(&["eds", "check", odd.to_str().unwrap()]);
    let said = String::from_utf8(checked.stdout).unwrap();
    assert!(
        said.contains("odd.eds: line 4, column 14: warning: DefaultValue: '70000' is beyond its type"),
        "{said}"
    );
    assert_eq!(checked.status.code(), Some(1));
    let modular = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gsd/modular.gsd");
    for (arguments, says) in [
        (&["eds", "missing.eds"][..], "profidrive: cannot read missing.eds: "),
        (&["eds", "check", modular], "this is a GSD of a PROFIBUS slave"),
    ] {
        let refused = output(arguments);
        let stderr = String::from_utf8(refused.stderr).unwrap();
        assert!(stderr.contains(says) && stderr.lines().count() == 1, "{stderr}");
        assert_eq!((refused.status.code(), &refused.stdout[..]), (Some(2), &b""[..]), "{arguments:?}");
    }
}

#[test]
fn nodes_from_files_answer_as_their_files_say() {
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds");
    let (pump, servo) = (files.join("pump.eds"), files.join("servo.dcf"));
    let state = tempfile::tempdir().unwrap();
    let (pump_node, servo_node) = (format!("5,eds={}", pump.display()), format!("6,eds={}", servo.display()));
    let arguments = [
        &["--node", &pump_node, "--node", &servo_node, "--link", "slcan-tcp:127.0.0.1:0"][..],
        &["--state-dir", state.path().to_str().unwrap()],
    ]
    .concat();
    let emulator = Emulator::start(&arguments);
    assert!(emulator.ready.contains(" nodes=5,6"), "{}", emulator.ready);
    let mut master = Master::open(adapter(&emulator));
    assert_eq!(master.sdo(5, "4018100100000000"), "4318100195010000");
    assert_eq!(master.sdo(6, "4060600000000000"), "4F60600001000000");
    assert_eq!(master.sdo(5, "2B00200007000000"), "6000200000000000");
    assert_eq!(master.sdo(5, "2310100173617665"), "6010100100000000", "it is stored when it is answered");
    assert_eq!(master.sdo(5, "2B00200008000000"), "6000200000000000");
    drop(emulator);
    let emulator = Emulator::start(&arguments);
    let mut master = Master::open(adapter(&emulator));
    assert_eq!(master.sdo(5, "4000200000000000"), "4B00200007000000");
}

#[test]
fn a_file_that_is_no_eds_ends_with_2_and_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let (file, line) = (folder.path().join("no.eds"), folder.path().join("line.toml"));
    fs::write(&file, "#Profibus_DP\n").unwrap();
    fs::write(&line, "[[line]]\nlink = 'slcan-tcp:127.0.0.1:0'\n[[line.node]]\nid = 5\neds = 'no.eds'\n")
        .unwrap();
    let node = format!("5,eds={}", file.display());
    for (arguments, says) in [
        (&["emulate", "--node", &node, "--link", "slcan-tcp:127.0.0.1:0"][..], "no.eds: line 1, column 1: "),
        (
            &["emulate", "--node", "5,eds=/nowhere.eds", "--link", "slcan-tcp:127.0.0.1:0"],
            "cannot read /nowhere.eds: ",
        ),
        (&["emulate", "--line", line.to_str().unwrap(), "--check"], "line.toml: line 5, column 7: "),
    ] {
        let output = output(arguments);
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.is_empty()), (Some(2), true), "{log}");
        assert!(log.lines().last().unwrap().contains(says), "{log}");
    }
}

#[test]
fn objects_follow_signals_and_other_objects() {
    let folder = tempfile::tempdir().unwrap();
    let eds = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds/pump.eds");
    let line = folder.path().join("line.toml");
    let node = |values: &str| {
        let eds = eds.display();
        fs::write(
            &line,
            format!(
                "[[line]]\nlink = 'slcan-tcp:127.0.0.1:0'\n[[line.node]]\nid = 5\neds = '{eds}'\n{values}"
            ),
        )
        .unwrap();
    };
    node(
        "[[line.node.value]]\nobject = '2002h'\nbehaviour = 'count'\nfrom = 0\nto = 100000\nevery = '10ms'\n\
         [[line.node.value]]\nobject = '2001h'\nbehaviour = 'scale'\nof = '2000h'\nfactor = 0.5\n",
    );
    let emulator = Emulator::start(&["--line", line.to_str().unwrap()]);
    let mut master = Master::open(adapter(&emulator));
    let position = |master: &mut Master| master.sdo(5, "4002200000000000");
    let first = position(&mut master);
    let start = Instant::now();
    while position(&mut master) == first {
        assert!(start.elapsed() < PATIENCE, "{first}");
    }
    assert_eq!(master.sdo(5, "2B00200003000000"), "6000200000000000");
    // 1.5
    while master.sdo(5, "4001200000000000") != "430120000000C03F" {
        assert!(start.elapsed() < PATIENCE);
    }
    drop(emulator);
    for (value, says) in [
        ("object = '2000h'\nvalue = 1\n", "line 7, column 10: '2000h' is no input of this node"),
        ("object = '2001h'\nbehaviour = 'mirror'\nof = '9/position'\n", "there is no station 9 on this line"),
    ] {
        node(&format!("[[line.node.value]]\n{value}"));
        let output = output(&["emulate", "--line", line.to_str().unwrap(), "--check"]);
        let log = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && log.contains(says), "{log}");
    }
}
