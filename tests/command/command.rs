//! The command, run as a process: its one line on stdout, its exit codes, its one line per failure.

use core::time::Duration;
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;
use std::time::Instant;

use profidrive::host::Link;
use profidrive::host::link::pty::Pty;

use crate::emulator::{Emulator, output, profidrive};
use crate::patience::PATIENCE;
use crate::process::end_of;

fn open(terminal: &str) -> File {
    OpenOptions::new().read(true).write(true).open(terminal).unwrap()
}

#[test]
fn every_wrong_command_line_ends_with_2_and_one_line_that_says_what_to_do() {
    for (arguments, says) in [
        (&[][..], "a command is missing; see 'profidrive --help'"),
        (&["fly"], "'fly'"),
        (&["--foo"], "'--foo'"),
        (&["emulate", "--foo"], "'--foo' found; see 'profidrive emulate --help'"),
        (&["emulate", "stray"], "'stray'"),
        (&["emulate", "--drive"], "--drive"),
        (&["emulate", "--drive", ""], "--drive"),
        (&["emulate", "--drive", "127"], "address 127 is outside 0 to 126"),
        (&["emulate", "--drive", "-1"], "'-1'"),
        (
            &["emulate", "--drive", "five"],
            "'five' is no address; expected ADDRESS[,model=ag03|ag03-1][,gear=24|48]",
        ),
        (&["emulate", "--drive", "5;gear=24"], "'5;gear=24' is no address"),
        (&["emulate", "--drive", "5,gear=25"], "gear '25' is unknown; expected 24 or 48"),
        (&["emulate", "--drive", "5,model=x"], "model 'x' is unknown; expected ag03 or ag03-1"),
        (&["emulate", "--drive", "5,speed=1"], "'speed' is unknown; expected ADDRESS"),
        (&["emulate", "--drive", "5,a\nb"], "is not understood"),
        (&["emulate", "--drive", "5", "--drive", "5,gear=24"], "two drives have address 5"),
        (&["emulate", "--drives", "1-9", "--drive", "5"], "two drives have address 5"),
        (&["emulate", "--drives", "9-1"], "the range 9-1 is empty; expected FIRST-LAST"),
        (&["emulate", "--drives", "5"], "'5' is no range of addresses; expected FIRST-LAST"),
        (&["emulate", "--baud", "115200"], "expected auto or one of 9600, 19200, 31250, 45450, 93750"),
        (
            &["emulate", "--baud", "45450"],
            "--baud 45450: the drives do not know this rate; expected auto or one of 9600, 19200, 93750",
        ),
        (&["emulate", "--slot-time", "500"], "--slot-time needs a serial link"),
        (&["emulate", "--link", "serial:/dev/null", "--baud", "19200", "--slot-time", "36"], "36"),
        (&["emulate", "--link", "usb"], "expected pty, pty:PATH, serial:DEVICE or tcp:HOST:PORT"),
        (&["emulate", "--panel", "8080"], "for example 127.0.0.1:8080; expected ADDR:PORT"),
        (
            &["emulate", "--panel", "0.0.0.0:0"],
            "others than this machine can connect and control the stations; add --panel-allow-remote",
        ),
        (&["emulate", "--panel-allow-remote"], "--panel"),
        (&["emulate", "--metrics", "9187"], "for example 127.0.0.1:9187; expected ADDR:PORT"),
        (&["emulate", "--metrics", "127.0.0.1:66000"], "port 66000 is outside 0 to 65535"),
        (
            &["emulate", "--metrics", "0.0.0.0:0"],
            "others than this machine can connect and read the metrics; add --metrics-allow-remote",
        ),
        (&["emulate", "--metrics-allow-remote"], "--metrics"),
        (&["emulate", "--line", "line.toml", "--metrics", "127.0.0.1:0"], "--metrics"),
        (&["emulate", "--link", "pty:"], "the path is missing"),
        (&["emulate", "--link", "serial"], "the device is missing"),
        (&["emulate", "--link", "tcp"], "host and port are missing"),
        (&["emulate", "--link", "tcp:5000"], "host and port must be given, for example tcp:127.0.0.1:5050"),
        (&["emulate", "--link", "tcp:localhost:66000"], "port 66000 is outside 0 to 65535"),
        (
            &["emulate", "--link", "tcp:0.0.0.0:0"],
            "others than this machine can connect and command the drives; add --allow-remote",
        ),
        (&["emulate", "--link", "tcp:[::]:0"], "add --allow-remote if that is wanted"),
        (&["emulate", "--link", "tcp:localhost:0", "--baud", "auto"], "--baud auto needs a pty"),
        (&["emulate", "--allow-remote"], "--allow-remote needs a tcp link"),
        (&["emulate", "--fault", "never"], "'never' is no fault; expected no-reply, late=TIME"),
        (&["emulate", "--fault", "late"], "late has no value; expected a time such as 20ms"),
        (
            &["emulate", "--fault", "no-reply,station=9"],
            "is for station 9, which is not on the line; expected station 5",
        ),
        (&["emulate", "--fault", "no-reply,rate=2"], "'2' does not fit rate; expected a probability"),
        (&["emulate", "--link", "serial:/dev/null"], "--baud 19200"),
        (&["emulate", "--link", "pty", "--link", "pty"], "multiple times"),
        (&["emulate", "-q", "-v"], "cannot be used with"),
    ] {
        let output = output(arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{arguments:?}: {stderr}");
        assert!(stderr.starts_with("profidrive: ") && stderr.contains(says), "{arguments:?}: {stderr}");
        assert!(stderr.contains("--help'"), "{arguments:?}: {stderr}");
        assert_eq!(output.stdout, b"", "{arguments:?}");
    }
}

#[test]
fn a_link_that_does_not_open_ends_with_1_and_one_line_that_says_what_to_do() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    fs::write(&file, "precious").unwrap();
    let at = |kind: &str, name: &str| format!("{kind}:{}", dir.path().join(name).display());
    for (link, says) in [
        (at("pty", "file"), "is a file, which is not replaced; remove it or choose another path"),
        (at("pty", ""), "is a directory"),
        (at("pty", "missing/bus"), "No such file or directory"),
        (at("serial", "missing"), "plugged in"),
        (at("serial", "file"), "name a serial device"),
    ] {
        let output = output(&["emulate", "-q", "--baud", "19200", "--link", &link]);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{link}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{link}: {stderr}");
        assert!(stderr.starts_with("profidrive: ") && stderr.contains(says), "{link}: {stderr}");
        assert_eq!(output.stdout, b"", "{link}");
    }
    assert_eq!(fs::read_to_string(file).unwrap(), "precious");
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "nothing is left behind");
}

#[test]
fn help_and_version_are_answered_with_0() {
    for (arguments, says) in [
        (&["--help"][..], "profidrive emulate --link pty:/tmp/bus"),
        (&["emulate", "--help"], "--drive 5 --drive 6,model=ag03,gear=24"),
        (&["-h"], "emulate"),
        (&["--version"], env!("CARGO_PKG_VERSION")),
    ] {
        let output = output(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(String::from_utf8(output.stdout).unwrap().contains(says), "{arguments:?}");
        assert_eq!(output.stderr, b"", "{arguments:?}");
    }
}

#[test]
fn the_ready_line_names_the_link_and_the_drives_and_both_signals_end_with_0() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus");
    let link = format!("pty:{}", path.display());
    for signal in ["TERM", "INT"] {
        let emulator = Emulator::start(&["--drive", "9", "--drive", "6,model=ag03,gear=24", "--link", &link]);
        assert_eq!(emulator.ready, format!("ready link={} drives=9,6\n", path.display()));
        assert!(fs::read_link(&path).unwrap().starts_with("/dev/pts"));
        drop(open(path.to_str().unwrap()));
        emulator.signal(signal);
        let (code, stdout, stderr) = emulator.end();
        assert_eq!(code, Some(0), "{signal}: {stderr}");
        assert_eq!(stdout, "", "one line and no more");
        assert!(stderr.contains("SIKO AG03, gear 24:1, at address 6"), "{stderr}");
        assert!(!stderr.contains('\x1b'), "no colours outside a terminal: {stderr}");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0, "nothing is left behind");
    }
}

#[test]
fn what_the_options_say_is_checked_without_a_line() {
    for (arguments, says) in [
        (&["--drive", "5", "--drive", "6"][..], "command line line 1: 2 drives, 0 stations"),
        (&["--node", "5,eds=tests/eds/pump.eds"], "1 nodes, 0 faults"),
    ] {
        let outcome = output(&[&["emulate", "--check"], arguments].concat());
        let (said, wrong) =
            (String::from_utf8(outcome.stdout).unwrap(), String::from_utf8(outcome.stderr).unwrap());
        assert_eq!((outcome.status.code(), wrong.as_str()), (Some(0), ""), "{arguments:?}");
        assert!(said.contains(says), "{said}");
    }
    for arguments in
        [["--node", "5,eds=Cargo.toml"], ["--station", "7,gsd=README.md"], ["--drive", "5,gear=7"]]
    {
        let outcome = output(&[&["emulate", "--check"][..], &arguments].concat());
        assert_eq!(outcome.status.code(), Some(2), "{arguments:?}");
    }
}

/// Also a file of several lines, and nodes.
#[test]
fn it_ends_with_its_standard_input_if_it_is_asked_to() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("lines.toml");
    fs::write(&file, "[[line]]\nlink = \"pty\"\n[[line.drive]]\naddress = 5\n".repeat(2)).unwrap();
    for what in [&["--drive", "5"][..], &["--node", "5"], &["--line", file.to_str().unwrap()]] {
        let arguments = [&["emulate"], what, &["--end-with-stdin"]].concat();
        let mut emulator = Emulator::spawn(profidrive(&arguments).stdin(Stdio::piped()));
        assert!(emulator.process.try_wait().unwrap().is_none(), "it runs as long as it is open");
        drop(emulator.process.stdin.take());
        let (code, _, stderr) = emulator.end();
        assert_eq!(code, Some(0), "{stderr}");
    }
    // Ended before anything was opened.
    let outcome = output(&["emulate", "--end-with-stdin"]);
    assert_eq!(outcome.status.code(), Some(0));
}

#[test]
fn without_arguments_one_drive_is_on_a_terminal_of_its_own() {
    let emulator = Emulator::start(&[]);
    let rest = emulator.ready.strip_prefix("ready link=/dev/pts/").unwrap();
    let (number, drives) = rest.split_once(' ').unwrap();
    assert!(number.parse::<u32>().is_ok() && drives == "drives=5\n", "{}", emulator.ready);
    assert!(Path::new(&format!("/dev/pts/{number}")).exists());
}

#[test]
fn a_killed_emulator_leaves_a_link_that_the_next_one_replaces() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus");
    let link = format!("pty:{}", path.display());
    drop(Emulator::start(&["--link", &link]));
    assert!(path.is_symlink() && !path.exists());
    let next = Emulator::start(&["--link", &link]);
    assert!(path.exists());
    next.signal("TERM");
    assert_eq!(next.end().0, Some(0));
    assert!(!path.is_symlink());
}

#[test]
fn unusual_addresses_are_warned_about() {
    let emulator = Emulator::start(&["-q", "--drive", "0", "--drive", "126"]);
    emulator.signal("TERM");
    let (code, _, stderr) = emulator.end();
    assert_eq!(code, Some(0));
    assert_eq!(stderr.lines().count(), 2, "{stderr}");
    assert!(stderr.contains("address 0 ") && stderr.contains("address 126 "), "{stderr}");
}

#[test]
fn a_full_bus_is_one_argument_and_counts_what_it_hears() {
    let emulator = Emulator::start(&["--drives", "1-125"]);
    let rest = emulator.ready.trim_end().split_once("drives=").unwrap().1;
    assert_eq!(rest.split(',').count(), 125);
    let terminal = emulator.ready.split(' ').nth(1).unwrap().strip_prefix("link=").unwrap();
    let mut master = open(terminal);
    master.write_all(&[0x10, 125, 0, 0x49, 0xC6, 0x16]).unwrap();
    let mut reply = [0; 6];
    master.read_exact(&mut reply).unwrap();
    assert_eq!(reply, [0x10, 0, 125, 0, 125, 0x16]);
    emulator.signal("USR1");
    // It goes on after the signal.
    thread::sleep(Duration::from_millis(50));
    master.write_all(&[0x10, 124, 0, 0x49, 0xC5, 0x16]).unwrap();
    master.read_exact(&mut reply).unwrap();
    assert_eq!(reply, [0x10, 0, 124, 0, 124, 0x16]);
    emulator.signal("TERM");
    let (code, _, stderr) = emulator.end();
    assert_eq!(code, Some(0), "{stderr}");
    let line: Vec<_> = stderr.lines().filter(|line| line.contains("line: heard ")).collect();
    assert!(line[0].contains("heard 1 telegrams (FDL status 1); sent 1;"), "on SIGUSR1: {line:?}");
    assert!(line[1].contains("heard 2 telegrams") && line.len() == 2, "at the end: {line:?}");
    let of_123: Vec<_> = stderr.lines().filter(|line| line.contains("station 123: ")).collect();
    assert!(stderr.contains("station 125: 1 telegrams") && of_123.len() == 1, "{stderr}");
    let why = "station 123: it does not move: no master exchanges data with the drive: it waits for Set_Prm; start the \
               master, ";
    assert!(of_123[0].contains(why), "on SIGUSR1: {of_123:?}");
}

/// An emulator on a "serial" line that is a terminal, whose other end the test has.
struct OnSerial {
    process: Child,
    stdout: BufReader<ChildStdout>,
    stderr: BufReader<std::process::ChildStderr>,
    line: Pty,
}

impl OnSerial {
    /// Started, and past the line of its log that contains `until`.
    fn start(arguments: &[&str], until: &str) -> Self {
        let line = Pty::open(None).unwrap();
        let link = format!("serial:{}", line.path().display());
        // A busy machine takes longer for a reply than the usual slot time.
        let mut command = profidrive(&["emulate", "--link", &link, "--slot-time", "16383"]);
        command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().unwrap();
        let stdout = BufReader::new(process.stdout.take().unwrap());
        let stderr = BufReader::new(process.stderr.take().unwrap());
        let mut emulator = Self { process, stdout, stderr, line };
        emulator.logs(until);
        emulator
    }

    fn logs(&mut self, part: &str) {
        let mut line = String::new();
        while !line.contains(part) {
            line.clear();
            assert!(self.stderr.read_line(&mut line).unwrap() > 0, "ended without '{part}'");
        }
    }

    fn ready(&mut self) -> String {
        let mut line = String::new();
        self.stdout.read_line(&mut line).unwrap();
        line.rsplit(' ').next().unwrap().trim_end().to_owned()
    }
}

impl Drop for OnSerial {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// FDL status of master 2 to a station, and its answer.
fn status(station: u8) -> [u8; 6] {
    [0x10, station, 2, 0x49, 0x4B + station, 0x16]
}
fn answer(station: u8) -> [u8; 6] {
    [0x10, 2, station, 0, 2 + station, 0x16]
}

#[test]
fn n_04_on_a_serial_line_a_drive_listens_first_and_stays_silent_if_its_address_is_live() {
    let arguments = ["--baud", "19200", "--drive", "5", "--drive", "6"];
    let mut emulator = OnSerial::start(&arguments, "listening whether the addresses are free");
    emulator.line.send(&[status(5), answer(5), status(6), status(6), status(6)].concat()).unwrap();
    assert_eq!(emulator.ready(), "drives=6");
    emulator
        .logs("WARN station 5 stays silent: another station has this address, which answers; choose another");
    emulator.logs("station 6: nobody else has this address; active");

    let mut emulator = OnSerial::start(&arguments, "listening whether");
    emulator.line.send(&[answer(6), answer(5)].concat()).unwrap();
    emulator.logs("profidrive: every address is taken by another station; choose others, or --force-address");
    assert_eq!(end_of(&mut emulator.process).code(), Some(1));

    let forced = [&arguments[..], &["--force-address"]].concat();
    let mut emulator = OnSerial::start(&forced, "at address 6");
    assert_eq!(emulator.ready(), "drives=5,6");
}

#[test]
fn on_a_serial_line_the_rate_is_searched_for_and_a_master_need_not_wait() {
    let mut emulator = OnSerial::start(&["--baud", "auto"], "searching for the rate of the line");
    assert_eq!(emulator.ready(), "drives=5");
    // A terminal hears everything at any rate. What is heard while the rate is being set is thrown away: say it again.
    for _ in 0..3 {
        emulator.line.send(&status(9)).unwrap();
        thread::sleep(Duration::from_millis(30));
    }
    emulator.logs("the rate of the line is ");
}

#[test]
fn a_closed_stdout_is_no_reason_to_end() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus");
    let link = format!("pty:{}", path.display());
    let mut command = profidrive(&["emulate", "--link", &link]);
    // A pipe whose reader is gone before the ready line.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut process = command.stdout(writer).stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(process.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("cannot say on stdout") {
        line.clear();
        assert!(stderr.read_line(&mut line).unwrap() > 0, "ended without the warning");
    }
    assert!(path.exists());
    let kill = format!("kill -TERM {}", process.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    assert_eq!(end_of(&mut process).code(), Some(0));
    assert!(!path.is_symlink());
}

#[test]
fn an_idle_emulator_uses_next_to_no_processor_time() {
    let emulator = Emulator::start(&[]);
    let terminal = emulator.ready.split(' ').nth(1).unwrap().strip_prefix("link=").unwrap();
    let used_in_400_ms = |state: &str| {
        let before = emulator.cpu_time();
        thread::sleep(Duration::from_millis(400));
        let used = emulator.cpu_time() - before;
        assert!(used <= Duration::from_millis(100), "{state}: {used:?} of 400 ms");
    };
    used_in_400_ms("no master yet");
    let master = open(terminal);
    used_in_400_ms("a silent master");
    drop(master);
    used_in_400_ms("a master has come and gone");
}

#[test]
fn a_bus_full_of_drives_is_small_and_sleeps_while_no_master_talks() {
    let drives: Vec<String> = (1..=125).map(|number| number.to_string()).collect();
    let arguments: Vec<&str> = drives.iter().flat_map(|drive| ["--drive", drive]).collect();
    let emulator = Emulator::start(&arguments);
    assert!(emulator.ready.trim().ends_with(",124,125"), "{}", emulator.ready);
    thread::sleep(Duration::from_millis(300));
    let before = emulator.cpu_time();
    thread::sleep(Duration::from_secs(2));
    let used = emulator.cpu_time() - before;
    // 1 % of a core; the system counts in ticks of 10 ms.
    assert!(used <= Duration::from_millis(20), "{used:?} in 2 s");
    assert!(emulator.resident() < 8 * 1024, "{} KiB", emulator.resident());
    println!("125 drives: {} KiB, {used:?} of processor time in 2 s without a master", emulator.resident());
}

/// Random octets that are no telegram by the laws of chance: the sequence is fixed, and holds none.
struct Noise(u64);

impl Noise {
    fn fill(&mut self, octets: &mut [u8]) {
        for octet in octets {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            *octet = (self.0 >> 32) as u8;
        }
    }
}

#[test]
fn a_port_that_another_program_has_is_refused_with_what_to_do() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let place = taken.local_addr().unwrap().to_string();
    for (arguments, code) in
        [(["--link", &format!("tcp:{place}")], 1), (["--panel", &place], 1), (["--metrics", &place], 2)]
    {
        let output = profidrive(&["emulate"]).args(arguments).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{stderr}");
        assert!(stderr.contains(&place) && stderr.contains("another program listens there"), "{stderr}");
    }
}

#[test]
fn a_mebibyte_of_noise_is_a_line_of_the_log_a_second() {
    let emulator = Emulator::start(&[]);
    let terminal = emulator.ready.split([' ', '=']).nth(2).unwrap().to_owned();
    let mut master = open(&terminal);
    let mut noise = Noise(0x9E37_79B9_7F4A_7C15);
    let start = Instant::now();
    let mut octets = [0; 512];
    for _ in 0..2048 {
        noise.fill(&mut octets);
        master.write_all(&octets).unwrap();
    }
    emulator.signal("TERM");
    let seconds = start.elapsed().as_secs();
    let (code, _, stderr) = emulator.end();
    assert_eq!(code, Some(0));
    let lines = stderr.lines().filter(|line| line.contains("octet") || line.contains("lost"));
    // The last lines are counters.
    let said = lines.filter(|line| !line.contains("line:")).count() as u64;
    assert!((1..=seconds + 2).contains(&said), "{said} lines in {seconds} s:\n{stderr}");
}

/// For a minute of it: `PROFIDRIVE_NOISE_SECONDS=60 cargo test --all-features --test command noise`.
#[test]
fn noise_is_not_answered_does_not_grow_the_process_and_ends_with_it() {
    let seconds = std::env::var("PROFIDRIVE_NOISE_SECONDS").map_or(2, |seconds| seconds.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("bus").display().to_string();
    let emulator = Emulator::start(&["--link", &format!("pty:{link}"), "-q"]);
    let mut master = open(&link);
    let replies = thread::spawn({
        let mut master = open(&link);
        move || {
            // The only reply there will be is that to the valid request at the end.
            let mut reply = [0; 6];
            master.read_exact(&mut reply).unwrap();
            reply
        }
    });
    let mut noise = Noise(0x9E37_79B9_7F4A_7C15);
    let mut octets = [0; 512];
    let mut push = |duration: Duration| {
        let start = Instant::now();
        let mut pushed = 0;
        while start.elapsed() < duration {
            noise.fill(&mut octets);
            master.write_all(&octets).unwrap();
            pushed += octets.len();
        }
        pushed
    };
    push(Duration::from_millis(500));
    let before = emulator.resident();
    let pushed = push(Duration::from_secs(seconds));
    assert!(pushed > 100_000, "only {pushed} octets of noise went out");
    let after = emulator.resident();
    assert!(after <= before + 256, "grew from {before} to {after} KiB");
    assert!(!replies.is_finished(), "noise was answered");
    // A request after noise is answered once the noise before it has been given up.
    let start = Instant::now();
    while !replies.is_finished() {
        assert!(start.elapsed() < PATIENCE, "the request after the noise was not answered");
        master.write_all(&[0x10, 5, 2, 0x49, 0x50, 0x16]).unwrap();
        thread::sleep(Duration::from_millis(200));
    }
    assert_eq!(replies.join().unwrap(), [0x10, 2, 5, 0, 7, 0x16]);
}

#[test]
fn drives_on_a_tcp_port_are_corrupted_as_asked_and_end_with_a_signal() {
    let emulator = Emulator::start(&[
        "--link",
        "tcp:127.0.0.1:0",
        "--fault",
        "wrong-fcs,at=2",
        "--fault",
        "no-reply,station=5,from=10s",
        "--fault",
        "no-reply,until=1ms,at=999",
        "--drive",
        "5",
    ]);
    let (ready, drives) = emulator.ready.trim().split_once(" drives=").unwrap();
    assert_eq!(drives, "5");
    let address = ready.strip_prefix("ready link=tcp:").unwrap();
    assert!(!address.ends_with(":0"), "{address}");
    let mut master = std::net::TcpStream::connect(address).unwrap();
    master.set_read_timeout(Some(PATIENCE)).unwrap();
    for fcs in [0x07, 0x08, 0x07] {
        master.write_all(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16]).unwrap();
        let mut reply = [0; 6];
        master.read_exact(&mut reply).unwrap();
        assert_eq!(reply, [0x10, 0x02, 0x05, 0x00, fcs, 0x16]);
    }
    let before = emulator.cpu_time();
    thread::sleep(Duration::from_millis(100));
    assert!(emulator.cpu_time() - before <= Duration::from_millis(10), "an idle port uses no time");
    emulator.signal("TERM");
    let (code, stdout, stderr) = emulator.end();
    assert_eq!((code, &stdout[..]), (Some(0), ""));
    assert!(stderr.contains("fault on purpose: wrong-fcs,count=1,at=2: 1st time"), "{stderr}");
    assert!(stderr.contains("until=1ms: acts no longer"), "{stderr}");
    assert!(stderr.contains("fault on purpose: no-reply,station=5,from=10s"), "{stderr}");
    assert!(stderr.contains("connected, 1 of 32"), "{stderr}");
}
