//! `emulate --line`: whole lines from a file, as their users run them, and profirust 0.6.0 as master of the example file.

use core::time::Duration;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Instant;

use gsd_parser::PrmBuilder;
use profidrive::host::link::serial::Serial;
use profidrive::host::{Clock, Link, Stop, SystemClock};
use profidrive::master::{LinkPhy, baudrate, instant, peripheral};
use profidrive::profibus::fdl::{FrameCount, FunctionCode, Service};
use profidrive::time::BaudRate;
use profirust::dp::{DpMaster, Peripheral, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use rustix::fs::OFlags;

use crate::emulator::{Emulator, output, profidrive};
use crate::panel;
use crate::patience::PATIENCE;
use crate::telegrams::telegram;

const BAUD: BaudRate = BaudRate::K500;
/// 50 ms at 500 kbit/s.
const SLOT_BITS: u16 = 25_000;

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/line")
}

/// A folder with a copy of the example, so that its links are nowhere else.
fn copy() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(example()).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    folder
}

fn written(folder: &Path, text: &str) -> String {
    let file = folder.join("line.toml");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

#[test]
fn a_file_is_checked_without_anything_being_opened() {
    let folder = copy();
    let file = folder.path().join("line.toml");
    let checked = output(&["emulate", "--line", file.to_str().unwrap(), "--check"]);
    let said = String::from_utf8(checked.stdout).unwrap();
    assert_eq!(checked.status.code(), Some(0), "{}", String::from_utf8_lossy(&checked.stderr));
    assert!(
        said.ends_with(" line 1: 2 drives, 10 stations with 7 moving inputs, 0 nodes, 2 faults\n"),
        "{said}"
    );
    assert!(!folder.path().join("bus").exists());
}

#[test]
fn what_is_wrong_is_one_line_with_its_place_and_nothing_is_started() {
    let folder = copy();
    let right = std::fs::read_to_string(folder.path().join("line.toml")).unwrap();
    for (text, words) in [
        (
            right.replacen("address = 4", "adress = 4", 1),
            "line.toml: line 11, column 1: 'adress' is unknown; did you mean address?",
        ),
        (right.replace("io.gsd", "no.gsd"), "no.gsd"),
        (format!("{right}\n[[line]]\nlink = 'pty:bus'\n"), "two lines have link 'pty:bus'"),
    ] {
        let output = output(&["emulate", "--line", &written(folder.path(), &text)]);
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{log}");
        assert!(log.lines().last().unwrap().contains(words), "{log}");
        assert!(output.stdout.is_empty() && !folder.path().join("bus").exists());
    }
    let file = written(folder.path(), &right);
    let both = output(&["emulate", "--line", &file, "--drive", "5"]);
    assert_eq!(both.status.code(), Some(2));
    let none = output(&["emulate", "--line", "/nowhere.toml"]);
    assert!(String::from_utf8(none.stderr).unwrap().contains("cannot read /nowhere.toml"));
}

#[test]
fn each_line_has_its_ready_line_in_order_and_a_signal_ends_all() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[[line]]\nlink = 'pty:one'\n[[line.drive]]\naddress = 5\n\
                [[line]]\nlink = 'tcp:127.0.0.1:0'\n[[line.drive]]\naddress = 5\n[[line.drive]]\naddress = 6\n\
                [[line]]\nlink = 'slcan-pty:can'\n[[line.node]]\nid = 5\ndevice = 'ap10'\n";
    let emulator = Emulator::start(&["--line", &written(folder.path(), text)]);
    assert!(emulator.ready.ends_with("/one drives=5\n"), "{}", emulator.ready);
    while !folder.path().join("can").exists() {
        std::thread::yield_now();
    }
    emulator.signal("TERM");
    let (code, rest, log) = emulator.end();
    assert_eq!(code, Some(0), "{log}");
    let rest: Vec<_> = rest.lines().collect();
    assert!(
        matches!(rest[..], [tcp, can] if tcp.ends_with(" drives=5,6") && can.ends_with("/can nodes=5")),
        "{rest:?}"
    );
    assert!(!folder.path().join("one").exists() && !folder.path().join("can").exists());
}

#[test]
fn two_lines_with_the_same_addresses_have_a_master_each_at_the_same_time() {
    let folder = tempfile::tempdir().unwrap();
    let line = |name: &str, model: &str| {
        format!("[[line]]\nlink = 'pty:{name}'\n[[line.drive]]\naddress = 5\nmodel = '{model}'\n")
    };
    let text = [line("one", "ag03"), line("two", "ag03-1")].concat();
    let emulator = Emulator::start(&["--line", &written(folder.path(), &text)]);
    while !folder.path().join("two").exists() {
        std::thread::yield_now();
    }
    let masters = ["one", "two"].map(|name| {
        let link = folder.path().join(name);
        let arguments =
            ["master", "--link", link.to_str().unwrap(), "--address", "5", "--json", "read", "d-Pos"];
        let mut command = profidrive(&arguments);
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap()
    });
    let [first, second] = masters.map(|master| {
        let output = master.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8([output.stdout, output.stderr].concat()).unwrap())
    });
    // Only the AG03/1 has d-Pos: each master has met the drive of its own line.
    assert!(first.0 == Some(1) && first.1.contains("only the AG03/1 has d-Pos"), "{first:?}");
    assert_eq!(second.0, Some(0), "{second:?}");
    emulator.signal("TERM");
    assert_eq!(emulator.end().0, Some(0));
}

#[test]
fn every_panel_shows_the_lines_of_the_file_in_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let line = |drive: u8| {
        format!("[[line]]\nlink = 'pty'\npanel = '127.0.0.1:0'\n[[line.drive]]\naddress = {drive}\n")
    };
    // Each line opens on a thread of its own; two have a drive at address 5.
    let text: String = [5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 5].map(line).concat();
    let emulator = panel::Emulator::of_file(&written(folder.path(), &text));
    let all = emulator.get("/api/v1/lines");
    let names: Vec<_> = all["lines"].as_array().unwrap().iter().map(|line| line["line"].clone()).collect();
    let expected: Vec<_> = (1..=11).map(|number| serde_json::json!(format!("line-{number}"))).collect();
    assert_eq!(names, expected);
    assert_eq!(emulator.get("/api/v1/stations/9")["line"], "line-5");
    let ambiguous = emulator.request("GET", "/api/v1/stations/5", "", "");
    assert_eq!(ambiguous.status, 409, "{}", ambiguous.body);
    assert!(ambiguous.body.contains("line-1") && ambiguous.body.contains("line-11"), "{}", ambiguous.body);
    assert_eq!(emulator.get("/api/v1/lines/line-11/stations/5")["line"], "line-11");
}

#[test]
fn a_line_that_cannot_be_opened_keeps_the_others_from_starting() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[[line]]\nlink = 'pty:one'\n[[line.drive]]\naddress = 5\n\
                [[line]]\nlink = 'pty:missing/two'\n[[line.drive]]\naddress = 5\n";
    let output = output(&["emulate", "--line", &written(folder.path(), text)]);
    let log = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{log}");
    assert!(output.stdout.is_empty() && log.contains("missing/two"), "{log}");
    assert!(!folder.path().join("one").exists());
}

#[test]
fn a_line_has_what_its_file_says_of_drives_faults_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let root = env!("CARGO_MANIFEST_DIR");
    let text = format!(
        "[[line]]\nlink = 'pty:bus'\npanel = '127.0.0.1:0'\nstate-dir = 'kept'\ncapture = 'bus.pcapng'\n\
         quirks = {{ off1 = 'brake' }}\n\
         [[line.drive]]\naddress = 5\nmodel = 'ag03'\nvalues = {{ v-Pos = 20 }}\n\
         [[line.drive]]\naddress = 6\nquirks = {{ off1 = 'release' }}\n\
         [[line.ppo-drive]]\naddress = 8\nppo = 1\nparameters = '{root}/examples/ppo_drive.toml'\n\
         values = {{ 'ramp-up time' = 7, 'fixed speeds.2' = -1 }}\n\
         [[line.station]]\naddress = 7\ngsd = '{root}/tests/gsd/remote_io.gsd'\nmodules = ['8 DI', '8 DO']\n\
         [[line.fault]]\nfault = 'no-reply,station=7'\nwhile = {{ station = 7, slot = 1, type = 'bit0', is = 1 }}\n\
         [[line.fault]]\nfault = 'no-reply,station=8,service=Slave_Diag,at=2'\n\
         [[line.fault]]\nfault = 'no-reply,station=5'\nfrom = '3600s'\n\
         [[line.fault]]\nfault = 'no-reply,station=6'\nuntil = '3600s'\n"
    );
    let emulator = panel::Emulator::of_file(&written(folder.path(), &text));
    let value = |path: &str| emulator.get(&format!("/api/v1/{path}"))["value"].as_f64();
    assert_eq!(value("stations/5/parameters/1004"), Some(20.0));
    assert_eq!(value("stations/8/parameters/2"), Some(7.0));
    assert_eq!(value("stations/8/parameters/30.2"), Some(-1.0));
    let injected =
        |place: usize| emulator.get("/api/v1/lines/line")["faults"][place]["injected"].as_u64().unwrap();
    let mut asked = Asked::at(emulator.terminal());
    // While an input has a value.
    asked.answers(7);
    let bit = "/api/v1/stations/7/inputs/1/0/bit0";
    emulator.set("PUT", bit, &serde_json::json!({ "value": 1 }));
    asked.is_silent(7, || injected(0));
    assert_eq!(emulator.request("DELETE", bit, "", "").status, 204);
    asked.answers(7);
    // At the second request of a service.
    asked.answers(8);
    assert_eq!(injected(1), 0);
    asked.is_silent(8, || injected(1));
    asked.answers(8);
    assert_eq!(injected(1), 1);
    // Not yet; and for an hour.
    asked.answers(5);
    assert_eq!(injected(2), 0);
    asked.is_silent(6, || injected(3));
    // Written by threads of their own.
    let capture = folder.path().join("bus.pcapng");
    eventually("a capture", || std::fs::metadata(&capture).is_ok_and(|file| file.len() > 0));
    let kept = folder.path().join("kept");
    eventually("two images", || std::fs::read_dir(&kept).is_ok_and(|kept| kept.count() >= 2));
}

/// Waits until `is_so`; the machine may be busy.
fn eventually(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "no {what}");
        thread::sleep(Duration::from_millis(5));
    }
}

/// A master that asks for Slave_Diag, each time once, and waits as long as the emulator takes.
struct Asked(File);

impl Asked {
    fn at(terminal: &Path) -> Self {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().cast_signed();
        Self(OpenOptions::new().read(true).write(true).custom_flags(flags).open(terminal).unwrap())
    }

    fn ask(&mut self, address: u8) {
        let request = FunctionCode::request(Service::SrdHigh, FrameCount::First);
        self.0.write_all(&telegram(address, 2, request, Some(60), &[])).unwrap();
    }

    /// Everything that has come.
    fn heard(&mut self) -> Vec<u8> {
        let mut octets = [0; 512];
        let count = self.0.read(&mut octets).unwrap_or(0);
        octets[..count].to_vec()
    }

    fn answers(&mut self, address: u8) {
        self.ask(address);
        let mut heard = Vec::new();
        eventually("answer", || {
            heard.extend(self.heard());
            heard.ends_with(&[0x16])
        });
        // SD2, its lengths, and from whom.
        assert_eq!((heard[0], heard[5] & 0x7F), (0x68, address), "{heard:02X?}");
    }

    /// The fault of which `injected` counts takes the answer.
    fn is_silent(&mut self, address: u8, injected: impl Fn() -> u64) {
        let before = injected();
        self.ask(address);
        eventually("fault", || injected() > before);
        let heard = self.heard();
        assert!(heard.is_empty(), "station {address}: {heard:02X?}");
    }
}

/// A station of the example and what a project of a master has of it: file, modules, octets out and in.
const STATIONS: [(u8, &str, &[&str], usize, usize); 10] = [
    (5, "io.gsd", IO, 1, 5),
    (6, "io.gsd", IO, 1, 5),
    (7, "io.gsd", IO, 1, 5),
    (8, "io.gsd", IO, 1, 5),
    (9, "io.gsd", IO, 1, 5),
    (10, "io.gsd", IO, 1, 5),
    (11, "valves.gsd", &["16 valves, 8 switches"], 2, 1),
    (12, "valves.gsd", &["16 valves, 8 switches"], 2, 1),
    (13, "scale.gsd", &["weight and status"], 1, 5),
    (14, "scale.gsd", &["weight and status"], 1, 5),
];
const IO: &[&str] = &["8 DI", "8 DO", "2 AI"];

#[test]
fn profirust_exchanges_data_with_every_station_of_the_example() {
    let folder = copy();
    let file = folder.path().join("line.toml");
    let emulator = Emulator::start(&["--line", file.to_str().unwrap()]);
    let ready = format!(
        "ready link={} drives=3,4 stations=5,6,7,8,9,10,11,12,13,14\n",
        folder.path().join("bus").display()
    );
    assert_eq!(emulator.ready, ready);

    let projects: Vec<_> = STATIONS
        .into_iter()
        .map(|(address, name, modules, outputs, inputs)| {
            let path = example().join(name);
            let text = std::fs::read_to_string(&path).unwrap();
            let description = gsd_parser::parser::parse(&path, &text).unwrap();
            let module = |wanted: &&str| {
                description
                    .available_modules
                    .iter()
                    .find(|module| module.name == *wanted)
                    .unwrap()
                    .config
                    .clone()
            };
            let config: Vec<u8> = modules.iter().flat_map(module).collect();
            let prm = PrmBuilder::new(&description.user_prm_data).into_bytes();
            (address, description, config, prm, outputs, inputs)
        })
        .collect();
    let mut dp = DpMaster::new(Vec::new());
    let drives = [3, 4].map(|address| dp.add(peripheral(address, BAUD)));
    let handles: Vec<_> = projects
        .iter()
        .map(|(address, description, config, prm, outputs, inputs)| {
            let options = PeripheralOptions {
                ident_number: description.ident_number,
                max_tsdr: description.max_tsdr.b500000,
                user_parameters: Some(prm),
                config: Some(config),
                ..PeripheralOptions::default()
            };
            dp.add(Peripheral::new(*address, options, vec![0; *inputs], vec![0; *outputs]))
        })
        .collect();
    dp.enter_operate();
    let parameters = ParametersBuilder::new(2, baudrate(BAUD))
        .slot_bits(SLOT_BITS)
        .max_retry_limit(15)
        .highest_station_address(20)
        .build_verified(&dp);
    let mut fdl = FdlActiveStation::new(parameters);
    fdl.set_online();
    let mut phy = LinkPhy::new(Serial::open(emulator.link(), BAUD).unwrap(), BAUD);
    let (clock, stop) = (SystemClock::new(), Stop::new().unwrap());
    let done = loop {
        fdl.poll(instant(clock.now()), &mut phy, &mut dp);
        assert!(phy.take_error().is_none());
        // Outputs of stations 5 and 6: a mirrored bit, and what station 7 follows.
        for (place, octet) in [(0, 1), (1, 0xA5)] {
            dp.get_mut(handles[place]).pi_q_mut()[0] = octet;
        }
        let all = handles.iter().chain(&drives).all(|handle| dp.get_mut(*handle).is_running());
        let mut input = |place: usize| dp.get_mut(handles[place]).pi_i().to_vec();
        let moved = input(0)[0] == 1
            && input(1)[0] > 0
            && input(2)[0] == 0xA5
            && input(6)[0] == 129
            && f32::from_be_bytes(input(8)[..4].try_into().unwrap()) > 0.0;
        if all && moved {
            break true;
        }
        if u128::from(clock.now().as_nanos()) > PATIENCE.as_nanos() {
            break false;
        }
        phy.link_mut().wait(Some(Duration::from_micros(200)), &stop).unwrap();
    };
    emulator.signal("TERM");
    let (code, _, log) = emulator.end();
    assert!(done, "{log}");
    assert_eq!(code, Some(0), "{log}");
}
