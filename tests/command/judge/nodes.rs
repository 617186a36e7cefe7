//! `judge --node`: nodes of an emulator, over a terminal, and what is no node.

use std::process::{Child, Command, Stdio};

use profidrive::host::capture::{can, read_can};
use profidrive::host::link::tap::Direction;

use super::{run, start};
use crate::process::end_of;

const EDS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds/complete.eds");

/// A process that is killed with the test.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn emulate(link: &str) -> Killed {
    emulated(link).0
}

/// An emulator, and its line of readiness.
fn emulated(link: &str) -> (Killed, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command.args(["emulate", "--quiet", "--node", &format!("5,eds={EDS}"), "--link", link]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut ready = String::new();
    let stdout = child.stdout.take().unwrap();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(stdout), &mut ready).unwrap();
    assert!(ready.starts_with("ready "), "{ready}");
    (Killed(child), ready)
}

#[test]
fn a_node_behind_an_adapter_is_only_read_unless_more_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let bus = folder.path().join("can0");
    let _emulator = emulate(&format!("slcan-pty:{}", bus.display()));
    let (node, link) = (format!("5,eds={EDS}"), format!("slcan-tty:{}", bus.display()));
    let json = folder.path().join("report.json");
    let only = "N-R04,N-X21,N-O0*,N-K06,N-S00";
    let (status, out, error) =
        run(&["--node", &node, "--link", &link, "--only", only, "--json", json.to_str().unwrap()]);
    assert_eq!(status, Some(0), "{out}{error}");
    assert!(out.starts_with(&format!("ready link=slcan-tty:{} node=5\n", bus.display())), "{out}");
    let report: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let verdict = |id: &str| {
        let row = report["rows"].as_array().unwrap().iter().find(|row| row["id"] == id).unwrap().clone();
        (row["verdict"].as_str().unwrap().to_owned(), row["reason"].as_str().unwrap().to_owned())
    };
    assert_eq!(verdict("N-R04").0, "pass");
    let (written, reason) = verdict("N-O05");
    assert_eq!(written, "not_judged");
    assert!(reason.contains("needs --write"), "{reason}");
    let (status, out, error) = run(&["--node", &node, "--link", &link, "--only", "N-O05", "--write"]);
    assert_eq!(status, Some(0), "{out}{error}");
}

#[test]
fn the_adapter_is_the_judges_for_a_node_that_is_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let bus = folder.path().join("can0");
    let link = format!("slcan-pty:{}", bus.display());
    let (mut judge, ready, _out) =
        start(&["--node", &format!("5,eds={EDS}"), "--link", &link, "--only", "N-R04,N-O08,N-O15,N-O20"]);
    assert_eq!(ready, format!("ready link={} node=5\n", bus.display()));
    let _emulator = emulate(&format!("slcan-tty:{}", bus.display()));
    assert_eq!(end_of(&mut judge).code(), Some(0));
}

#[test]
fn a_node_behind_a_port_is_judged_and_a_capture_has_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let (_emulator, ready) = emulated("slcan-tcp:127.0.0.1:0");
    let link = ready.split_whitespace().find_map(|part| part.strip_prefix("link=")).unwrap();
    let file = folder.path().join("node.pcapng");
    let (status, out, error) = run(&[
        "--node",
        &format!("5,eds={EDS}"),
        "--link",
        link,
        "--only",
        "N-O01",
        "--capture",
        file.to_str().unwrap(),
    ]);
    assert_eq!(status, Some(0), "{out}{error}");
    let packets: Vec<_> = read_can(&file).unwrap().map(Result::unwrap).collect();
    let sent = |id, direction| {
        let of_it = |octets: &[u8]| can::frame(octets).is_some_and(|frame| frame.id().number() == id);
        packets.iter().filter(|packet| of_it(&packet.octets) && packet.direction == Some(direction)).count()
    };
    let requests = sent(0x605, Direction::Sent);
    assert!(requests > 5, "{requests} requests");
    assert_eq!(sent(0x585, Direction::Heard), requests);
}

#[test]
fn nobody_on_the_bus_is_no_pass() {
    let folder = tempfile::tempdir().unwrap();
    let bus = folder.path().join("can0");
    let _emulator = emulate(&format!("slcan-pty:{}", bus.display()));
    let (status, _, error) = run(&["--node", "6", "--link", &format!("slcan-tty:{}", bus.display())]);
    assert_eq!(status, Some(3), "{error}");
    assert!(error.contains("nobody answered"), "{error}");
}

#[test]
fn a_node_needs_a_link_of_a_can_bus_and_rows_of_nodes() {
    for (arguments, says) in [
        (&["--node", "5", "--link", "pty"][..], "a node is on a CAN bus"),
        (&["--node", "0", "--link", "slcan-tty:/x"], "1 to 127"),
        (&["--node", "5", "--link", "slcan-tty:/x", "--only", "M-C03"], "no row of a node"),
        (
            &["--node", "5", "--link", "slcan-tty:/x", "--station", "5,ident=1234,cfg=13"],
            "cannot be used with",
        ),
        (&["--slave", "5", "--link", "pty", "--node", "5"], "cannot be used with"),
        (&["--node", "5,eds=/no/such.eds", "--link", "slcan-tty:/x"], "/no/such.eds"),
    ] {
        let (status, _, error) = run(arguments);
        assert_eq!(status, Some(2), "{arguments:?}: {error}");
        assert!(error.contains(says), "{arguments:?}: {error}");
    }
}
