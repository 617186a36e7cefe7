//! `emulate --capture`: what a master has sent and received is in the file, however the run ends.
//!
//! What Wireshark's own programs make of such files is tested by `tests/wireshark/run.sh`.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use crate::panel::Emulator as PanelEmulator;
use crate::patience::PATIENCE;
use crate::process::end_of;
use profidrive::devices::ag03::param::{Model, parameters};
use profidrive::host::capture::{self, Packet};
use profidrive::host::link::tap::Direction;
use profidrive::profibus::fdl::{FrameCount, FunctionCode, Service};
use profidrive::profibus::pkw::ErrorNumber;
use profidrive::profibus::ppo::{Ind, JobId, Pke, Pkw};
use serde_json::json;

use crate::pty::Master;
use crate::telegrams;

/// How often the emulator is killed, each time a little later.
const KILLS: u64 = 12;

/// A running emulator; dropped, it is killed with SIGKILL.
struct Emulator(Child);

impl Emulator {
    fn start(capture: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
        command.args(["emulate", "--capture"]).arg(capture).args(arguments);
        Self::spawn(command)
    }

    fn spawn(mut command: Command) -> Self {
        command.env_remove("RUST_LOG").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().unwrap())
    }

    /// What a master opens, once it is there.
    fn link(&mut self) -> String {
        let mut ready = String::new();
        BufReader::new(self.0.stdout.take().unwrap()).read_line(&mut ready).unwrap();
        match ready.split(' ').nth(1).and_then(|word| word.strip_prefix("link=")) {
            Some(link) => link.to_owned(),
            None => panic!("no ready line but {}", self.complaint()),
        }
    }

    fn master(&mut self) -> Master {
        Master::open(Path::new(&self.link()))
    }

    /// What it says on stderr until it ends.
    fn complaint(&mut self) -> String {
        let mut text = String::new();
        self.0.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        text
    }

    /// Asks it to end: its exit code and what it said.
    fn end(mut self) -> (Option<i32>, String) {
        let command = format!("kill -TERM {}", self.0.id());
        assert!(Command::new("sh").args(["-c", &command]).status().unwrap().success());
        let said = self.complaint();
        (end_of(&mut self.0).code(), said)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn packets(path: &Path) -> Vec<Packet> {
    capture::read(path).unwrap().map(Result::unwrap).collect()
}

/// Sent by the master, as in the log of [`Master`].
fn is_sent(packet: &Packet) -> bool {
    packet.direction == Some(Direction::Heard)
}

/// Reads a parameter `times` times; `false` if the emulator ended before.
fn read(master: &mut Master, times: usize) -> bool {
    let job = Pkw::new(Pke::of_job(JobId::Read, 930), Ind::default(), 0);
    (0..times).all(|_| master.job(job).is_some())
}

fn folder_and_file() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bus.pcapng");
    (folder, path)
}

#[test]
fn after_sigkill_every_telegram_that_the_master_sent_and_saw_answered_is_there() {
    let (_folder, path) = folder_and_file();
    let mut answered = 0;
    for kill in 0..KILLS {
        let mut emulator = Emulator::start(&path, &[]);
        let mut master = emulator.master();
        let (done, jobs) = mpsc::channel();
        let log = thread::scope(|scope| {
            let traffic = scope.spawn(|| {
                while read(&mut master, 1) {
                    let _ = done.send(());
                }
                master.log
            });
            jobs.iter().take(3).for_each(drop);
            thread::sleep(Duration::from_micros(300 * kill));
            drop(emulator);
            traffic.join().unwrap()
        });
        // Whether the last request has reached the emulator, and how much of its reply the master, nobody knows.
        let known: Vec<_> = log.into_iter().filter(|(_, octets)| !octets.is_empty()).collect();
        let last_reply = known.iter().rposition(|(sent, _)| !sent).unwrap();
        let captured: Vec<_> =
            packets(&path).into_iter().map(|packet| (is_sent(&packet), packet.octets)).collect();
        assert!(captured.len() <= known.len() + 2, "{} of {}", captured.len(), known.len());
        assert_eq!(captured[..last_reply], known[..last_reply], "kill {kill}");
        assert!(captured[last_reply].1.starts_with(&known[last_reply].1), "kill {kill}");
        answered += last_reply;
    }
    println!("{KILLS} kills, {answered} telegrams");
}

#[test]
fn a_corrupted_reply_is_captured_as_it_was_sent_and_says_why_it_is_no_telegram() {
    let (_folder, path) = folder_and_file();
    let mut emulator = Emulator::start(&path, &["--fault", "noise=3,at=2", "--link", "tcp:127.0.0.1:0"]);
    let mut line = TcpStream::connect(emulator.link().strip_prefix("tcp:").unwrap()).unwrap();
    line.set_read_timeout(Some(PATIENCE)).unwrap();
    let ask = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
    let answer = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];
    let (mut first, mut corrupted) = ([0; 6], [0; 9]);
    line.write_all(&ask).unwrap();
    line.read_exact(&mut first).unwrap();
    line.write_all(&ask).unwrap();
    line.read_exact(&mut corrupted).unwrap();
    assert_eq!((first, &corrupted[3..]), (answer, &answer[..]));
    let (code, _) = emulator.end();
    assert_eq!(code, Some(0));
    let found: Vec<_> = packets(&path)
        .into_iter()
        .map(|packet| {
            (
                is_sent(&packet),
                packet.octets,
                packet.comment.is_some_and(|text| text.starts_with("invalid: ")),
            )
        })
        .collect();
    let expected = [
        (true, ask.to_vec(), false),
        (false, answer.to_vec(), false),
        (true, ask.to_vec(), false),
        (false, corrupted[..3].to_vec(), true),
        (false, answer.to_vec(), false),
    ];
    assert_eq!(found, expected);
}

#[test]
fn what_happened_is_a_comment_of_its_packet_or_of_the_next() {
    let (_folder, path) = folder_and_file();
    let mut emulator = Emulator::start(&path, &["--link", "tcp:127.0.0.1:0"]);
    let mut line = TcpStream::connect(emulator.link().strip_prefix("tcp:").unwrap()).unwrap();
    line.set_read_timeout(Some(PATIENCE)).unwrap();
    // Set_Prm with ident number 1234, answered with SC, then FDL status.
    let prm = telegrams::telegram(
        5,
        2,
        FunctionCode::request(Service::SrdHigh, FrameCount::First),
        Some(61),
        &[0x80, 1, 1, 11, 0x12, 0x34, 0],
    );
    line.write_all(&prm).unwrap();
    line.read_exact(&mut [0; 1]).unwrap();
    line.write_all(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16]).unwrap();
    line.read_exact(&mut [0; 6]).unwrap();
    let (code, said) = emulator.end();
    assert_eq!(code, Some(0), "{said}");
    let comments: Vec<_> = packets(&path).into_iter().map(|packet| packet.comment).collect();
    let text = "station 5: refused the parameters of master 2: Set_Prm octets 5-6: ident number 0x1234, expected 0x0AC5: the \
                master's project has another device at this address";
    // The request itself if it is not written yet when it has been judged, else one behind it.
    let said_by: Vec<_> = (0..).zip(&comments).filter(|(_, comment)| comment.is_some()).collect();
    assert!(matches!(said_by[..], [(0..=2, Some(comment))] if comment == text), "{comments:?}");
    assert!(said.contains(text), "the log says the same: {said}");
}

#[test]
fn when_the_disk_is_full_the_capture_ends_with_one_warning_and_the_drives_go_on() {
    let (_folder, path) = folder_and_file();
    let mut command = Command::new("bash");
    command.args(["-c", "trap '' XFSZ; ulimit -f 8; exec \"$0\" emulate --capture \"$1\""]);
    command.arg(env!("CARGO_BIN_EXE_profidrive")).arg(&path);
    let mut emulator = Emulator::spawn(command);
    let mut master = emulator.master();
    assert!(read(&mut master, 100));
    let exchanged = master.log.len();
    let (code, said) = emulator.end();
    assert_eq!(code, Some(0), "{said}");
    let warnings: Vec<_> = said.lines().filter(|line| line.contains("WARN")).collect();
    assert_eq!(warnings.len(), 1, "{said}");
    assert!(warnings[0].contains("ends here, the drives go on: File too large"), "{said}");
    let captured = packets(&path);
    assert!(captured.len() > 20 && captured.len() < exchanged, "{} of {exchanged}", captured.len());
    let len = fs::metadata(&path).unwrap().len();
    assert!(len <= 8 * 1024 && len > 7 * 1024, "{len} octets");
}

#[test]
fn what_cannot_be_captured_to_is_said_in_one_line() {
    let (folder, path) = folder_and_file();
    let mut first = Emulator::start(&path, &[]);
    let _master = first.master();
    let no_such = folder.path().join("no/such.pcapng");
    for (file, expected) in [
        (folder.path(), "it is no regular file; name a regular file"),
        (&no_such, "No such file or directory"),
        (&path, "another running emulator does; choose another file"),
        (Path::new("/dev/full"), "it is no regular file; name a regular file"),
    ] {
        let mut emulator = Emulator::start(file, &["-q"]);
        let said = emulator.complaint();
        assert_eq!(end_of(&mut emulator.0).code(), Some(1), "{said}");
        assert!(said.starts_with("profidrive: cannot capture to ") && said.contains(expected), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    assert!(!packets(&path).is_empty(), "what the first captures is not lost");
}

#[test]
fn the_dissector_knows_every_parameter_and_every_error_number() {
    let lua =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/wireshark/profibus.lua")).unwrap();
    for entry in parameters(Model::Ag03_1) {
        let row = format!("[{}] = \"{}\"", entry.pnu, entry.name);
        assert!(lua.contains(&row), "no {row}");
    }
    for &error in ErrorNumber::ALL {
        let row = format!("[{}] = \"{}\"", error.number(), error.text());
        assert!(lua.contains(&row), "no {row}");
    }
}

#[test]
fn a_capture_that_cannot_be_written_is_told_where_people_look() {
    let folder = tempfile::tempdir().unwrap();
    for (name, link, options) in
        [("dp", "tcp:127.0.0.1:0", ["--drive", "5"]), ("can", "slcan-tcp:127.0.0.1:0", ["--node", "5"])]
    {
        let file = format!("{}/{name}.pcapng", folder.path().display());
        let arguments = [&["--link", link, "--bench", "--capture", &file][..], &options].concat();
        let emulator = PanelEmulator::with_small_files(8, &arguments);
        emulator.set("POST", "/api/v1/stations/5/master", &json!({"act": "enable"}));
        let begun = std::time::Instant::now();
        let told = loop {
            let events = emulator.get("/api/v1/events/recent")["events"].clone();
            let told = events
                .as_array()
                .unwrap()
                .iter()
                .find(|event| event["text"].to_string().contains("ends here"))
                .cloned();
            if let Some(told) = told {
                break told;
            }
            assert!(begun.elapsed() < PATIENCE, "{name}: {events}");
        };
        assert_eq!((told["class"].as_str(), told["line"].as_str()), (Some("fault"), Some("line")), "{told}");
        assert!(told["text"].as_str().unwrap().contains("too large"), "{told}");
        assert!(std::fs::metadata(&file).unwrap().len() > 0);
    }
}
