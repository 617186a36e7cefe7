//! `emulate --node` and `eds`: CANopen devices behind slcan.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Instant;

use profidrive::host::can::Product;

use crate::emulator::{Emulator, output};
use crate::patience::PATIENCE;
use crate::process::{end_of, hangup_ends_programs};

/// Host and port of the ready line.
pub(super) fn adapter(emulator: &Emulator) -> &str {
    emulator.link().strip_prefix("slcan-tcp:").unwrap_or_else(|| panic!("{}", emulator.ready))
}

/// A master behind an adapter of its own.
pub(super) struct Master {
    stream: BufReader<TcpStream>,
}

impl Master {
    pub(super) fn open(place: &str) -> Self {
        let stream = TcpStream::connect(place).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        let mut master = Self { stream: BufReader::new(stream) };
        master.send("O");
        // What happens before the adapter is open is not seen.
        assert_eq!(master.line(), "\r");
        master
    }

    pub(super) fn send(&mut self, line: &str) {
        self.stream.get_mut().write_all(format!("{line}\r").as_bytes()).unwrap();
    }

    /// The next frame with this identifier: its octets in hexadecimal.
    pub(super) fn frame(&mut self, id: u16) -> String {
        let head = format!("t{id:03X}");
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < PATIENCE, "no frame {id:03X}");
            let line = self.line();
            // Behind acknowledgements of what was sent.
            if let Some((_, frame)) = line.split_once(&head) {
                return frame.trim_end()[1..].to_owned();
            }
        }
    }

    /// What comes up to the next CR, with it.
    fn line(&mut self) -> String {
        let mut line = Vec::new();
        self.stream.read_until(b'\r', &mut line).unwrap();
        String::from_utf8_lossy(&line).into_owned()
    }

    /// The answer to an SDO request of 8 octets.
    pub(super) fn sdo(&mut self, node: u16, request: &str) -> String {
        self.send(&format!("t{:03X}8{request}", 0x600 + node));
        self.frame(0x580 + node)
    }
}

/// The last boot-up of 127 nodes comes some 60 ms behind the first one at this rate.
#[test]
fn the_boot_ups_are_over_when_the_emulator_is_ready() {
    let nodes: Vec<String> = (1..=127).map(|id| format!("{id},device=ap10")).collect();
    let mut arguments = vec!["--link", "slcan-tcp:127.0.0.1:0", "--baud", "125000"];
    for node in &nodes {
        arguments.extend(["--node", node]);
    }
    let emulator = Emulator::start(&arguments);
    let mut master = Master::open(adapter(&emulator));
    // The boot-up of the node with the highest number comes behind all that wait.
    master.send("t0002817F");
    loop {
        let line = master.line();
        if line.contains("t77F") {
            break;
        }
        assert!(!line.contains("t7"), "{line}");
    }
}

#[test]
fn every_wrong_command_line_ends_with_2_and_one_line_that_says_what_to_do() {
    let tcp = &["--link", "slcan-tcp:127.0.0.1:0"][..];
    for (arguments, says) in [
        (&["--node", "0,device=ap10"][..], "node number 0 is outside 1 to 127"),
        (&["--node", "128,device=ap10"], "node number 128 is outside 1 to 127"),
        (&["--node", "five"], "'five' is no node number; expected ID"),
        (&["--node", "5,device=ap11"], "device 'ap11' is unknown; did you mean ap10?"),
        (&["--node", "5,device=ap10,gear=24"], "gear is for the device ag03-1 only"),
        (&["--node", "5,device=ap10,mode=half"], "mode is for the device asda-a2 only"),
        // CN-308: twice the same number.
        (
            &["--node", "5,device=ap10", "--node", "5,device=asda-a2"],
            "two nodes have the number 5; give each node its own",
        ),
        (
            &["--node", "5,device=ap10", "--drive", "5"],
            "start one emulator with --drive and another with --node",
        ),
        (
            &["--drive", "5"],
            "the drives of --drive are on PROFIBUS; name CANopen nodes, for example --node 5,device=",
        ),
        (&[], "name CANopen nodes"),
        (&["--node", "5,device=ap10", "--link", "slcan-tcp"], "--link"),
        (&["--node", "5,device=ap10,eds=x.eds"], "eds is for the device eds-node only, not for ap10"),
        (&["--node", "5,device=eds-node"], "no file is named; expected ID"),
        (
            &["--node", "5,device=ap10", "--fault", "no-reply"],
            "'no-reply' is no fault of a node; expected boot-up-missing",
        ),
        (
            &["--node", "5,device=ap10", "--fault", "sdo-lost,node=6"],
            "--fault names node 6, which is not on the bus; expected node 5",
        ),
        (&["--node", "5,device=ap10", "--fault", "sdo-lost,id=585"], "id is only for faults of frames"),
        (
            &["--node", "5,device=ap10", "--quirk", "x=y"],
            "no node has a quirk 'x'; ap10 has sdo-codes, ascii",
        ),
        (&["--node", "5,device=ap10", "--quirk", "x"], "expected NAME=VALUE"),
        (
            &["--node", "5,device=ap10", "--quirk", "load=never"],
            "quirk load cannot be 'never'; expected once or erase",
        ),
        (&["--node", "5,device=ap10", "--slot-time", "100"], "--slot-time is for drives on PROFIBUS"),
        (&["--node", "5,device=ap10", "--panel", "8080"], "expected ADDR:PORT"),
        (&["--node", "5,device=ap10", "--baud", "10000"], "expected --baud with one of 125000, 250000"),
        (&["--node", "5,device=ap10", "--baud", "auto"], "expected --baud with one of 125000"),
    ] {
        let mut all = vec!["emulate"];
        all.extend(tcp);
        all.extend(arguments);
        refused(&all, says);
    }
    refused(
        &["emulate", "--node", "5,device=ap10", "--link", "pty"],
        "CANopen nodes are on a CAN bus; use --link slcan-pty:PATH, slcan-tcp:HOST:PORT, slcan-tty:PATH or socketcan:INTERFACE",
    );
    refused(&["emulate", "--link", "slcan-pty:"], "the path is missing");
    refused(
        &["emulate", "--baud", "250000"],
        "--baud 250000 is no rate of PROFIBUS; expected auto or one of 9600",
    );
    refused(
        &["emulate", "--node", "5,device=ap10", "--link", "slcan-tcp:0.0.0.0:0"],
        "add --allow-remote if that is wanted, or use slcan-tcp:127.0.0.1:PORT",
    );
    refused(
        &["emulate", "--node", "5,device=ap10", "--allow-remote"],
        "--allow-remote needs an slcan-tcp link",
    );
    refused(&["eds", "ap-10"], "device 'ap-10' is unknown; did you mean ap10?");
    refused(&["eds"], "see 'profidrive eds --help'");
}

fn refused(arguments: &[&str], says: &str) {
    let output = output(arguments);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    let last = stderr.lines().last().unwrap();
    assert!(last.starts_with("profidrive: ") && last.contains(says), "{arguments:?}: {stderr}");
    assert!(last.contains("--help'"), "{arguments:?}: {stderr}");
    assert_eq!(output.stdout, b"", "{arguments:?}");
}

#[test]
fn the_ready_line_names_the_link_and_the_nodes_and_each_signal_ends_with_0() {
    hangup_ends_programs();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("can0");
    let link = format!("slcan-pty:{}", path.display());
    for signal in ["TERM", "INT", "HUP"] {
        let emulator =
            Emulator::start(&["--node", "9,device=ap10", "--node", "6,device=asda-a2", "--link", &link]);
        assert_eq!(emulator.ready, format!("ready link={} nodes=9,6\n", path.display()));
        assert!(fs::read_link(&path).unwrap().starts_with("/dev/pts"));
        emulator.signal(signal);
        let (code, stdout, stderr) = emulator.end();
        assert_eq!(code, Some(0), "{signal}: {stderr}");
        assert_eq!(stdout, "", "one line and no more");
        assert!(stderr.contains("node 9 (ap10): boot-up as node 9 after power-on"), "{stderr}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
    }
}

#[test]
fn a_signal_while_boot_ups_are_sent_ends_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let link = format!("slcan-pty:{}", folder.path().join("can0").display());
    let nodes = (1..=127).flat_map(|node| ["--node".to_owned(), format!("{node},device=ap10")]);
    let mut emulator = std::process::Command::new(env!("CARGO_BIN_EXE_profidrive"))
        .args(["emulate", "--link", &link])
        .args(nodes)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // One that does not end is killed, so that the log ends.
    let (ended, end) = std::sync::mpsc::channel::<()>();
    let kill = format!("kill -KILL {}", emulator.id());
    std::thread::spawn(move || {
        if end.recv_timeout(PATIENCE) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
            let _ = std::process::Command::new("sh").args(["-c", &kill]).status();
        }
    });
    let mut log = std::io::BufRead::lines(std::io::BufReader::new(emulator.stderr.take().unwrap()));
    assert!(log.by_ref().any(|line| line.unwrap().contains("boot-up as node")), "it has begun");
    let term = format!("kill -TERM {}", emulator.id());
    assert!(std::process::Command::new("sh").args(["-c", &term]).status().unwrap().success());
    let rest: Vec<_> = log.map(Result::unwrap).collect();
    drop(ended);
    assert_eq!(end_of(&mut emulator).code(), Some(0), "{rest:#?}");
    assert!(rest.last().unwrap().contains("ended by a signal"), "{:?}", rest.last());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
}

#[test]
fn each_node_answers_for_itself_and_boots_when_it_is_told() {
    let products: Vec<_> = Product::all().collect();
    for (index, product) in products.iter().enumerate() {
        let other = products[(index + 1) % products.len()];
        let (node, beside) = (format!("5,device={}", product.name), format!("127,device={}", other.name));
        let emulator =
            Emulator::start(&["--node", &node, "--node", &beside, "--link", "slcan-tcp:127.0.0.1:0"]);
        assert!(emulator.ready.ends_with(" nodes=5,127\n"), "{}", emulator.ready);
        let mut master = Master::open(adapter(&emulator));
        let vendor = u32::swap_bytes(product.sheet.vendor_number);
        assert_eq!(master.sdo(5, "4018100100000000"), format!("43181001{vendor:08X}"), "{}", product.name);
        master.send("t00028105");
        assert_eq!(master.frame(0x705), "00", "{}", product.name);
        master.send("t0002817F");
        assert_eq!(master.frame(0x77F), "00", "{}", product.name);
    }
}

/// FR-7
#[test]
fn a_plant_that_moves_all_the_time_leaves_the_log_small_and_its_faults_in_it() {
    let emulator = Emulator::start(&["--node", "5", "--link", "slcan-tcp:127.0.0.1:0"]);
    let mut master = Master::open(adapter(&emulator));
    master.send("t00020105");
    for word in ["06", "07", "0F"] {
        master.send(&format!("t2052{word}01"));
    }
    for target in ["0A", "00"].into_iter().cycle().take(40) {
        master.send(&format!("t40561F00{target}000000"));
        // Until the target is reached: bit 14 of 6041h.
        while master.sdo(5, "4041600000000000").as_bytes()[10] & 4 != 0 {}
        master.send("t20520F00");
    }
    // Too short, which is told.
    master.send("t205100");
    master.sdo(5, "4000100000000000");
    emulator.signal("TERM");
    let (_, _, log) = emulator.end();
    assert!(log.contains("more lines about motion; -v logs each of them"), "{log}");
    assert!((5..=20).contains(&log.matches(": travel to ").count()), "{log}");
    assert!(log.contains("RPDO1 ignored: it has 1 octet, expected 2"), "{log}");
}

/// FR-7
#[test]
fn twins_keep_what_they_store_each_for_itself() {
    let folder = tempfile::tempdir().unwrap();
    for _ in ["made", "loaded"] {
        let state = folder.path().to_str().unwrap();
        let link = ["--link", "slcan-tcp:127.0.0.1:0", "--state-dir", state];
        let emulator = Emulator::start(&[&["--node", "5", "--node", "5,twin"][..], &link].concat());
        assert!(emulator.ready.ends_with(" nodes=5,5\n"), "{}", emulator.ready);
        let mut master = Master::open(adapter(&emulator));
        assert_eq!(master.sdo(5, "2F1024054D000000"), "6010240500000000");
        emulator.signal("TERM");
        assert_eq!(emulator.end().0, Some(0));
        for file in ["ag03-1-node-005.eeprom", "ag03-1-node-005-twin.eeprom"] {
            assert!(folder.path().join(file).exists(), "{}", listing(folder.path()));
        }
    }
}

/// FC-8
#[test]
fn a_node_at_another_rate_is_silent_until_the_master_changes_over() {
    let emulator =
        Emulator::start(&["--node", "5", "--node", "6,device=asda-a2", "--link", "slcan-tcp:127.0.0.1:0"]);
    let mut master = Master::open(adapter(&emulator));
    // A rate that no node has is none of the bus.
    for line in ["C", "S3", "O"] {
        master.send(line);
    }
    assert_eq!(master.sdo(5, "2F00210007000000"), "6000210000000000", "2100h = 125 kbit/s");
    master.send("t00028105");
    master.send("t60584000100000000000");
    assert_eq!(&master.sdo(6, "4000100000000000")[..8], "43001000", "node 5 would have answered before");
    for line in ["C", "S4", "O"] {
        master.send(line);
    }
    master.send("t00028105");
    assert_eq!(master.frame(0x705), "00");
    master.send("t60684000100000000000");
    assert_eq!(&master.sdo(5, "4000100000000000")[..8], "43001000");
    emulator.signal("TERM");
    let (_, _, log) = emulator.end();
    for said in [
        "rate set to 100 kbit/s (S3), which no node has; the bus in memory keeps 500000 bit/s, on a real bus the nodes would be \
         silent",
        "node 5 (ag03-1): its rate is 125000 bit/s and that of the bus 500000 bit/s: it is silent and hears nothing until the \
         master uses 125000 bit/s",
        "rate set to 125 kbit/s (S4), which the bus has now",
        "node 5 (ag03-1): its rate is that of the bus again, 125000 bit/s: it hears and answers",
        "node 6 (asda-a2): its rate is 500000 bit/s and that of the bus 125000 bit/s",
    ] {
        assert!(log.contains(said), "{said}\n{log}");
    }
}

/// FC-8
#[test]
fn the_rate_of_the_command_line_is_one_of_the_nodes_and_theirs() {
    let emulator = Emulator::start(&["--node", "5", "--baud", "100000", "--link", "slcan-tcp:127.0.0.1:0"]);
    let mut master = Master::open(adapter(&emulator));
    assert_eq!(master.sdo(5, "4000210000000000"), "4F00210006000000", "2100h = 100 kbit/s");
    drop(emulator);
    // Kept: at the next start it is silent at 500 kbit/s, and with --baud it has this rate again.
    let folder = tempfile::tempdir().unwrap();
    let start = |more: &[&str]| {
        let state = ["--state-dir", folder.path().to_str().unwrap(), "--link", "slcan-tcp:127.0.0.1:0"];
        Emulator::start(&[&["--node", "5"][..], &state, more].concat())
    };
    let emulator = start(&[]);
    let mut master = Master::open(adapter(&emulator));
    assert_eq!(master.sdo(5, "2F00210007000000"), "6000210000000000", "2100h = 125 kbit/s");
    drop((master, emulator));
    let emulator = start(&[]);
    emulator.signal("TERM");
    let (_, _, log) = emulator.end();
    assert!(log.contains("its rate is 125000 bit/s and that of the bus 500000 bit/s"), "{log}");
    let emulator = start(&["--baud", "250000"]);
    let mut master = Master::open(adapter(&emulator));
    assert_eq!(master.sdo(5, "4000210000000000"), "4F00210009000000", "2100h = 250 kbit/s");
    drop((master, emulator));
    refused(
        &["emulate", "--node", "5", "--baud", "800000"],
        "the CAN bus of an ag03-1 has another rate; expected --baud with one of 15625, 20000, 25000, 40000, 50000, 62500, \
         100000, 125000, 200000, 250000, 500000, 1000000",
    );
    refused(
        &["emulate", "--node", "5", "--baud", "300000"],
        "expected --baud with one of 15625, 20000, 25000, 40000,",
    );
}

#[test]
fn a_can_interface_that_is_not_there_is_an_error_that_says_where_to_look() {
    let output = crate::emulator::output(&["emulate", "--node", "5", "--link", "socketcan:no-such0"]);
    assert_eq!(output.status.code(), Some(1));
    let stderr = String::from_utf8(output.stderr).unwrap();
    let says =
        "cannot open the CAN interface no-such0 ('ip link show no-such0' says whether it is there and up)";
    assert!(stderr.contains(says), "{stderr}");
}

/// A value with its own row: a write that the device keeps by itself or by 1010h.
fn stored_value(master: &mut Master, place: &str) -> u16 {
    let answer = master.sdo(5, &format!("40{place}00000000"));
    assert!(answer.starts_with("4B"), "{answer}");
    u16::from_str_radix(&answer[8..12], 16).unwrap().swap_bytes()
}

#[test]
fn what_is_stored_is_there_after_a_kill_and_what_is_not_is_not() {
    for product in Product::all() {
        // 1017h, the heartbeat time, is kept by 1010h:1. The AG03/1 keeps each write by itself: 2410h:1, controller P.
        let keeps_by_itself = product.name == "ag03-1";
        let place = if keeps_by_itself { "102401" } else { "171000" };
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().to_str().unwrap();
        let node = format!("5,device={}", product.name);
        let arguments = ["--node", &node, "--link", "slcan-tcp:127.0.0.1:0", "--state-dir", state];
        for round in 1..=5_u16 {
            let emulator = Emulator::start(&arguments);
            let mut master = Master::open(adapter(&emulator));
            let before = stored_value(&mut master, place);
            let kept = if round == 1 { before } else { 200 + round - 1 };
            assert_eq!(before, kept, "{}, round {round}", product.name);
            let octets = |value: u16| format!("{:04X}0000", value.swap_bytes());
            let done = format!("60{place}00000000");
            let written = master.sdo(5, &format!("2B{place}{}", octets(200 + round)));
            assert_eq!(written, done, "{}", product.name);
            if !keeps_by_itself {
                assert_eq!(master.sdo(5, "2310100173617665"), "6010100100000000", "{}: save", product.name);
                // Not stored.
                master.sdo(5, &format!("2B{place}{}", octets(7)));
            }
            drop(emulator);
            let image = folder.path().join(format!("{}-node-005.eeprom", product.name));
            assert!(image.exists(), "{}: {}", product.name, listing(folder.path()));
        }
    }
}

fn listing(folder: &Path) -> String {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    names.map(|name| name.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_damaged_image_is_refused_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("ap10-node-005.eeprom");
    fs::write(&image, "no image").unwrap();
    let state = folder.path().to_str().unwrap();
    let link = "slcan-tcp:127.0.0.1:0";
    let output = output(&["emulate", "--node", "5,device=ap10", "--link", link, "--state-dir", state]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.lines().last().unwrap().contains("is refused and left as it is"), "{stderr}");
    assert_eq!(output.stdout, b"", "not ready");
    assert_eq!(fs::read(&image).unwrap(), b"no image");
}

#[test]
fn a_capture_holds_every_frame_as_the_kernel_gives_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("can.pcapng");
    let capture = file.to_str().unwrap();
    let link = "slcan-tcp:127.0.0.1:0";
    let emulator = Emulator::start(&["--node", "5,device=ap10", "--link", link, "--capture", capture]);
    let mut master = Master::open(adapter(&emulator));
    master.sdo(5, "4000100000000000");
    emulator.signal("TERM");
    let (code, _, stderr) = emulator.end();
    assert_eq!(code, Some(0), "{stderr}");
    let octets = fs::read(&file).unwrap();
    let holds = |part: &[u8]| octets.windows(part.len()).any(|window| window == part);
    // Behind the section header the interface, whose link type is in octets 8 and 9.
    let interface = u32::from_le_bytes(octets[4..8].try_into().unwrap()) as usize;
    assert_eq!(octets[interface..interface + 4], [1, 0, 0, 0]);
    assert_eq!(octets[interface + 8..interface + 10], [227, 0], "SocketCAN");
    assert!(holds(&[0, 0, 6, 5, 8, 0, 0, 0, 0x40, 0, 0x10, 0, 0, 0, 0, 0]), "the request");
    assert!(holds(&[0, 0, 5, 0x85, 8, 0, 0, 0, 0x43, 0, 0x10, 0]), "the answer");
}

#[test]
fn the_data_sheet_of_each_device_is_on_stdout() {
    for product in Product::all() {
        let output = output(&["eds", product.name]);
        assert_eq!(output.status.code(), Some(0), "{}", product.name);
        assert_eq!(output.stderr, b"", "{}", product.name);
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text, product.eds());
        assert!(text.contains("$NODEID+0x") && text.contains("[1018sub1]"), "{}", product.name);
    }
}
