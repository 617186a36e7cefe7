//! `profidrive master` over CANopen, with `profidrive emulate` as another process; `decode` of what the emulator captured.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::emulator::{Emulator, output};

/// An emulator of an AG03/1 as node 5 and an ASDA-A2 as node 7.
struct Bus(Emulator);

impl Bus {
    fn start(more: &[&str]) -> Self {
        let arguments = ["--node", "5", "--node", "7,device=asda-a2", "--link", "slcan-tcp:127.0.0.1:0"];
        Self(Emulator::start(&[&arguments[..], more].concat()))
    }

    fn run(&self, node: &str, arguments: &[&str]) -> Output {
        output(&[&["master", "--link", self.0.link(), "--node", node], arguments].concat())
    }

    fn says(&self, node: &str, arguments: &[&str]) -> String {
        let output = self.run(node, arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    fn fails(&self, node: &str, arguments: &[&str], code: i32) -> String {
        let output = self.run(node, arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {output:?}");
        String::from_utf8(output.stderr).unwrap()
    }
}

impl Bus {
    /// Asks the panel.
    fn http(&self, method: &str, path: &str, body: &str) {
        let (_, place) = self.0.ready.trim_end().split_once("panel=http://").unwrap();
        let mut stream = TcpStream::connect(place).unwrap();
        let head = format!("Host: {place}\r\nConnection: close\r\nContent-Type: application/json");
        let length = body.len();
        write!(
            stream,
            "{method} /api/v1/stations/{path} HTTP/1.1\r\n{head}\r\nContent-Length: {length}\r\n\r\n{body}"
        )
        .unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }

    fn provoke(&self, node: &str, fault: &str) {
        self.http("POST", &format!("{node}/provoke"), &format!("{{\"fault\":\"{fault}\"}}"));
    }

    fn nominal(&self, node: &str) {
        self.http("DELETE", &format!("{node}/inputs"), "");
    }
}

fn decode(arguments: &[&str], file: &Path) -> Output {
    output(&[&["decode"], arguments, &[file.to_str().unwrap()]].concat())
}

#[test]
fn entries_are_read_and_written_by_index_by_name_and_by_the_name_of_the_parameter() {
    let emulator = Bus::start(&[]);
    for name in ["2410:05", "2410h:5", "v-Pos"] {
        assert_eq!(
            emulator.says("5", &["read", name]),
            "2410h:05 Controller parameters: v-Pos rpm = 30 rpm\n",
            "{name}"
        );
    }
    assert!(
        emulator
            .says("5", &["read", "Statusword"])
            .starts_with("6041h:00 Statusword = 0070h, switch on disabled")
    );
    assert_eq!(
        emulator.says("5", &["write", "v-Pos", "60"]),
        "2410h:05 Controller parameters: v-Pos rpm = 60 rpm, was 30 rpm\n"
    );
    // What it can is read back, not the signature.
    for (object, signature) in [("1010:1", "0x65766173"), ("1011:1", "0x64616f6c")] {
        let said = emulator.says("7", &["write", object, signature]);
        assert!(said.ends_with(" written\n") && said.contains(&object[..4]), "{said}");
        let said = emulator.says("7", &["write", object, signature, "--json"]);
        let written: Value = serde_json::from_str(&said).unwrap();
        assert_eq!(written["value"], u32::from_str_radix(&signature[2..], 16).unwrap());
    }
    let object: Value = serde_json::from_str(&emulator.says("5", &["read", "6060", "--json"])).unwrap();
    assert_eq!((&object["object"], &object["value"]), (&"6060h:00".into(), &1.into()));
    assert_eq!(object["text"], "1 (positioning mode)");
    assert_eq!(emulator.says("5", &["write", "limit 1", "-5"]).lines().count(), 1, "a negative number");
    assert_eq!(emulator.says("7", &["read", "6502"]), "6502h:00 Supported drive modes = 109\n");
    let refused = emulator.fails("5", &["write", "2410:05", "0"], 1);
    let expected =
        "value range of the parameter exceeded (06090030h): expected 1 to 100, got 0 rpm: send a value";
    assert!(refused.contains(expected), "the limits of this gear, {refused}");
    let refused = emulator.fails("5", &["write", "6041", "1"], 1);
    assert!(refused.contains("(06010002h): got 0001h: it can only be read"), "{refused}");
    let refused = emulator.fails("5", &["read", "2410:07"], 1);
    assert!(refused.contains("sub-index does not exist"), "{refused}");
    let wide = emulator.fails("5", &["write", "2410:05", "256"], 2);
    assert!(wide.contains("takes 0 to 255, got 256"), "{wide}");
    let unknown = emulator.fails("5", &["read", "no such"], 2);
    assert!(unknown.contains("neither an index such as 6041"), "{unknown}");
    let many = emulator.fails("5", &["read", "COB-ID"], 2);
    assert!(many.contains("is the name of several objects"), "{many}");
    let nobody = emulator.fails("9", &["read", "6041"], 1);
    assert!(nobody.contains("no answer to the access to 1000h:00"), "{nobody}");
}

#[test]
fn both_drives_travel_and_are_left_as_they_were_and_the_capture_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("bus.pcapng");
    let emulator = Bus::start(&["--capture", capture.to_str().unwrap()]);
    emulator.says("5", &["write", "v-Pos", "100"]);
    assert_eq!(emulator.says("5", &["move", "800", "--yes"]).split(';').next(), Some("reached"));
    let object: Value = serde_json::from_str(&emulator.says("5", &["read", "6064", "--json"])).unwrap();
    assert!((object["value"].as_i64().unwrap() - 800).abs() <= 10, "{object}");
    let status = emulator.says("5", &["status"]);
    assert!(status.starts_with("node 5, AG03/1, NMT PRE-OPERATIONAL\n"), "{status}");
    assert!(status.contains("6041h:00 Statusword = ") && status.contains("ready to travel"), "{status}");
    emulator.says("7", &["write", "6081", "12800000"]);
    let moved: Value =
        serde_json::from_str(&emulator.says("7", &["move", "1280000", "--yes", "--json"])).unwrap();
    assert_eq!(moved["outcome"], "reached");
    let beyond = emulator.fails("5", &["move", "2000000", "--yes"], 1);
    assert!(beyond.contains("does not acknowledge the target"), "{beyond}");
    assert!(emulator.says("5", &["stop"]).starts_with("stopped"), "nothing to stop");
    let asked = emulator.fails("5", &["move", "0"], 2);
    assert!(asked.contains("--yes"), "{asked}");
    drop(emulator);

    let output = decode(&["--brief", "--node", "5=ag03-1", "--node", "7=asda-a2"], &capture);
    let text = String::from_utf8(output.stdout).unwrap();
    for line in [
        "605  SDO to 5: write 607Ah:00 Target position = 800 inc or 0.01 mm",
        "000  NMT to node 5: start: to OPERATIONAL",
        "705  guarding request to 5",
        "605  SDO to 5: write 6040h:00 Controlword = 001Fh, enable operation, new setpoint",
        "607  SDO to 7: write 6040h:00 Controlword = 001Fh, enable operation, new set-point",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let output = decode(&["--json", "--device", "ag03-1"], &capture);
    let first: Value =
        serde_json::from_slice(output.stdout.split(|octet| *octet == b'\n').next().unwrap()).unwrap();
    assert_eq!((&first["kind"], &first["packet"]), (&"frame".into(), &1.into()));
}

#[test]
fn a_person_sees_why_nothing_moves_homes_and_acknowledges() {
    let emulator = Bus::start(&["--node", "6,device=ap10", "--panel", "127.0.0.1:0"]);
    let status = emulator.says("7", &["status"]);
    assert!(status.contains("it does not move: NMT state PRE-OPERATIONAL"), "{status}");
    assert!(status.contains("it does not move: no mode of operation is chosen: write 6060h"), "{status}");
    assert!(status.contains("'switch on disabled': send 6040h = 0006h, then 0007h, then 000Fh"), "{status}");
    let status: Value = serde_json::from_str(&emulator.says("6", &["status", "--json"])).unwrap();
    assert_eq!((&status["device"], &status["does_not_move"]), (&"AP10".into(), &Value::Null));

    let none = emulator.fails("7", &["home", "--yes"], 1);
    assert!(none.contains("the homing failed"), "{none}");
    emulator.says("7", &["write", "6098", "35"]);
    emulator.says("7", &["write", "607C", "5000"]);
    let homed: Value = serde_json::from_str(&emulator.says("7", &["home", "--yes", "--json"])).unwrap();
    assert_eq!((&homed["outcome"], &homed["position"]), (&"reached".into(), &5000.into()));

    for (node, fault) in [("5", "F"), ("7", "011")] {
        emulator.provoke(node, fault);
        let status = emulator.says(node, &["status"]);
        assert!(status.contains("it does not move: fault (bit 3 of 6041h)"), "{status}");
        assert!(emulator.says(node, &["faults"]).starts_with("1 errors in 1003h"), "{node}");
        emulator.nominal(node);
        let state = emulator.says(node, &["ack"]);
        assert_eq!(state, "acknowledged; the drive is in 'switch on disabled'\n", "{node}");
        assert_eq!(emulator.says(node, &["faults", "--clear"]).lines().count(), 2, "{node}");
    }
    let indicator = emulator.fails("6", &["ack"], 2);
    assert!(indicator.contains("the AP10 has no control word"), "{indicator}");
}

#[test]
fn what_does_not_fit_together_on_the_command_line_is_said() {
    let run = |arguments: &[&str]| {
        let output = output(&[&["master"], arguments].concat());
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for (arguments, says) in [
        (&["--link", "slcan-tcp:127.0.0.1:1", "status"][..], "add --node N"),
        (
            &["--link", "slcan-tcp:127.0.0.1:1", "--node", "5", "--address", "5", "status"],
            "--address is for PROFIBUS",
        ),
        (
            &["--link", "slcan-tcp:127.0.0.1:1", "--node", "5", "params"],
            "there are read, write, status, move, home, stop, ack and faults",
        ),
        (&["--link", "slcan-tcp:127.0.0.1:1", "--node", "0", "status"], "1 to 127"),
        (
            &["--link", "slcan-tcp:127.0.0.1:1", "--node", "5", "--baud", "19200", "status"],
            "no rate of a CAN bus",
        ),
        (&["--link", "slcan-tty:", "--node", "5", "status"], "the name is missing"),
        (&["--link", "tcp:127.0.0.1:1", "--node", "5", "status"], "--node is for CANopen"),
        (
            &["--link", "tcp:127.0.0.1:1", "--address", "5", "--baud", "250000", "status"],
            "no rate of PROFIBUS",
        ),
        (&["--link", "tcp:127.0.0.1:1", "--address", "5", "read", "6041:00"], "invalid value '6041:00'"),
    ] {
        let (code, stderr) = run(arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(says), "{arguments:?}: {stderr}");
    }
    let (code, stderr) = run(&["--link", "socketcan:no-such0", "--node", "5", "status"]);
    assert_eq!(code, Some(1));
    assert!(stderr.contains("cannot open the CAN interface no-such0"), "{stderr}");
}

/// Index, type, access, default: a drive that nobody has.
const DRIVE: &[(u16, u16, &str, &str)] = &[
    (0x1000, 7, "ro", "0x00020192"),
    (0x1001, 5, "ro", "0"),
    (0x6040, 6, "rw", "0"),
    (0x6041, 6, "ro", ""),
    (0x6060, 2, "rw", "0"),
    (0x6061, 2, "ro", ""),
    (0x6064, 4, "ro", ""),
    (0x607A, 4, "rw", "0"),
    (0x6081, 7, "rw", "100000"),
    (0x6083, 7, "rw", "1000000"),
    (0x6502, 7, "ro", "1"),
];

/// A drive and a pump of which nobody knows more than their files say.
#[test]
fn a_node_is_commissioned_by_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("drive.eds");
    let objects = DRIVE.iter().map(|(index, data, access, default)| {
        format!(
            "[{index:04X}]\nParameterName=O{index:04X}\nDataType={data}\nAccessType={access}\nDefaultValue={default}\n"
        )
    });
    let head = "[DeviceInfo]\nVendorName=Somebody\nVendorNumber=0x77\nProductName=Feeder\n";
    std::fs::write(&drive, head.to_owned() + &objects.collect::<String>()).unwrap();
    let drive = drive.to_str().unwrap();
    let pump = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds/pump.eds");
    let (of_drive, of_pump) = (format!("9,eds={drive}"), format!("5,eds={pump}"));
    let bus =
        Bus(Emulator::start(&["--node", &of_drive, "--node", &of_pump, "--link", "slcan-tcp:127.0.0.1:0"]));
    let by_file = |file, arguments: &[&'static str]| [&["--eds", file], arguments].concat();
    let status = bus.says("9", &by_file(drive, &["status"]));
    assert!(status.starts_with("node 9, Feeder, NMT PRE-OPERATIONAL"), "{status}");
    assert!(status.contains("it does not move: "), "{status}");
    let moved = bus.says("9", &by_file(drive, &["move", "500", "--yes"]));
    assert!(moved.starts_with("reached; position"), "{moved}");
    let position = bus.says("9", &by_file(drive, &["read", "o6064", "--json"]));
    let position: Value = serde_json::from_str(&position).unwrap();
    assert_eq!((&position["object"], &position["value"]), (&"6064h:00".into(), &500.into()));
    // The names are those of the file.
    let wrong = bus.fails("5", &by_file(pump, &["read", "no such object"]), 2);
    assert!(wrong.contains("of the Pump"), "{wrong}");
    let other = bus.run("5", &by_file(drive, &["read", "1000"]));
    let told = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(
        told.contains(
            "the file is of another device: 1018h:01 is 00000195h in the node and 00000077h in the file"
        ),
        "{told}"
    );
    let nowhere = bus.fails("5", &["--eds", "/nowhere.eds", "read", "1000"], 2);
    assert!(nowhere.contains("cannot read /nowhere.eds"), "{nowhere}");
}
