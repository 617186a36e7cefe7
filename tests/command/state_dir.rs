//! The directory of `emulate --state-dir`: what is refused, what is repaired, and that a full disk harms nothing.

use crate::drive_line;
use crate::patience::PATIENCE;
use crate::pty;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use drive_line::{CFG, IDENT, MASTER, SLAVE, telegram};
use profidrive::devices::ag03::param::{Gear, Model, Parameter, Pnu, Value};
use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN};
use profidrive::devices::ag03::unit::{IMAGE_LEN, Image};
use profidrive::host::{StateDir, StateDirError, Stored};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Service};
use profidrive::profibus::ppo::{Ind, JobId, Pke, Pkw};
use profidrive::time::Instant;
use pty::Master;

use crate::emulator::{Emulator, profidrive};

fn emulate(arguments: &[&str]) -> Command {
    let mut command = profidrive(&["emulate"]);
    command.args(arguments);
    command
}

/// Runs to its end, which is at once because it is refused.
fn refused(directory: &Path, arguments: &[&str]) -> String {
    let directory = directory.to_str().unwrap();
    let mut all = vec!["--state-dir", directory];
    all.extend(arguments);
    let Output { status, stdout, stderr } = emulate(&all).output().unwrap();
    let stderr = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(1), "{stderr}");
    assert_eq!(stdout, b"", "not ready");
    let last = stderr.lines().last().unwrap();
    assert!(last.starts_with("profidrive: "), "{stderr}");
    last.to_owned()
}

fn start(directory: &Path) -> Emulator {
    Emulator::start(&["--state-dir", directory.to_str().unwrap()])
}

/// Ended with SIGTERM: exit code and stderr.
fn ended(emulator: Emulator) -> (Option<i32>, String) {
    emulator.signal("TERM");
    let (code, _, stderr) = emulator.end();
    (code, stderr)
}

fn file(directory: &Path) -> PathBuf {
    directory.join("ag03-1-005.eeprom")
}

fn config() -> Config {
    Config::new(Address::station(SLAVE).unwrap())
}

/// The value of v-Pos in the file.
fn stored_v_pos(directory: &Path) -> i32 {
    let octets = fs::read(file(directory)).unwrap();
    Image::decode(&octets, Model::Ag03_1, Gear::Ratio48).unwrap().store.value(Parameter::VPos)
}

#[test]
fn a_missing_directory_is_made_and_its_file_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("a/b");
    let (code, _) = ended(start(&directory));
    assert_eq!(code, Some(0));
    let image = fs::read(file(&directory)).unwrap();
    assert_eq!(image.len(), IMAGE_LEN);
    assert_eq!(ended(start(&directory)).0, Some(0));
    assert_eq!(fs::read(file(&directory)).unwrap(), image);
}

#[test]
fn what_is_no_image_of_the_drive_is_refused_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    ended(start(folder.path()));
    let path = file(folder.path());
    let good = fs::read(&path).unwrap();
    let mut damaged = good.clone();
    damaged[40] ^= 0x10;
    for (octets, arguments, says) in [
        (damaged, &[][..], "it is damaged: its checksum is"),
        (good[..100].to_vec(), &[], "it has 100 octets, expected 142"),
        (Vec::new(), &[], "it has 0 octets, expected 142"),
        (b"#!/bin/sh\n".repeat(1000), &[], "it is no EEPROM image"),
        (good, &["--drive", "5,gear=24"], "it is of an ag03-1 with gear 48, expected an ag03-1 with gear 24"),
    ] {
        fs::write(&path, &octets).unwrap();
        let line = refused(folder.path(), arguments);
        assert!(line.contains(path.to_str().unwrap()) && line.contains(says), "{line}");
        assert!(line.contains("to start with factory settings move it away"), "{line}");
        assert_eq!(fs::read(&path).unwrap(), octets, "never overwritten");
    }
}

#[test]
fn a_directory_that_cannot_be_used_is_refused_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("taken");
    fs::write(&taken, "precious").unwrap();
    let line = refused(&taken, &[]);
    assert!(line.contains("cannot keep EEPROM images in") && line.contains("taken"), "{line}");
    assert_eq!(fs::read(&taken).unwrap(), b"precious");

    // Not even root writes here.
    let line = refused(Path::new("/proc/self"), &[]);
    assert!(line.contains("cannot keep EEPROM images in /proc/self"), "{line}");

    fs::create_dir_all(file(folder.path())).unwrap();
    let line = refused(folder.path(), &[]);
    assert!(
        line.contains("ag03-1-005.eeprom (move what is there away") && line.ends_with(": it is not a file"),
        "{line}"
    );
}

#[test]
fn two_emulators_do_not_use_one_directory() {
    let folder = tempfile::tempdir().unwrap();
    let first = start(folder.path());
    let line = refused(folder.path(), &["--drive", "6"]);
    assert!(line.contains("is used by another running emulator"), "{line}");
    drop(first);
    ended(start(folder.path()));
}

#[test]
fn what_a_killed_emulator_left_half_written_is_removed_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let names = [".ag03-1-005.eeprom.tmp", ".ag03-009.eeprom.tmp", "notes.tmp", "x.eeprom.tmp"];
    for name in names {
        fs::write(folder.path().join(name), "half").unwrap();
    }
    drop(start(folder.path()));
    let left = names.map(|name| folder.path().join(name).exists());
    assert_eq!(left, [false, false, true, true]);
}

/// A drive on its own, asked by a scripted master.
struct Bench {
    drive: Stored<Device>,
    now: Instant,
    count: FrameCount,
}

impl Bench {
    fn new(state: &StateDir) -> Self {
        let now = Instant::from_millis(1);
        let drive = state.load(config(), now).unwrap();
        let mut bench = Self { drive, now, count: FrameCount::First };
        bench.request(Some(61), &[0x80, 1, 1, 11, IDENT[0], IDENT[1], 0]);
        bench.request(Some(62), &CFG);
        bench
    }

    /// The data of the reply, which comes within 5 ms whatever the disk does.
    fn request(&mut self, dsap: Option<u8>, data: &[u8]) -> Vec<u8> {
        let fc = FunctionCode::request(Service::SrdHigh, self.count);
        self.count = if self.count == FrameCount::Even { FrameCount::Odd } else { FrameCount::Even };
        self.now = self.now.saturating_add(Duration::from_millis(5));
        self.drive.act(self.now, |drive| drive.handle_timeout(self.now));
        self.drive
            .act(self.now, |drive| drive.handle_bytes(self.now, &telegram(SLAVE, MASTER, fc, dsap, data)));
        let due = self.drive.unit().poll_timeout().unwrap();
        self.drive.act(due, |drive| drive.handle_timeout(due));
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let reply =
            self.drive.unit_mut().poll_transmit(due, &mut buf).unwrap_or_else(|| panic!("no reply at {due}"));
        if reply.len() > 11 { reply[reply.len() - 16..reply.len() - 2].to_vec() } else { Vec::new() }
    }

    /// PKE and value of the reply to a write of v-Pos once it is there; the slave answers in every exchange before.
    fn write_v_pos(&mut self, value: u8) -> (u16, u8) {
        let outputs = |pke: [u8; 2], value| [pke[0], pke[1], 0, 0, 0, 0, 0, value, 0, 0, 0, 0, 0, 0];
        while self.request(None, &outputs([0, 0], 0))[..8] != [0; 8] {}
        let start = std::time::Instant::now();
        loop {
            let inputs = self.request(None, &outputs([0x23, 0xEC], value));
            if inputs[..8] != [0; 8] {
                return (u16::from_be_bytes([inputs[0], inputs[1]]), inputs[7]);
            }
            assert!(start.elapsed() < PATIENCE, "no reply");
            std::thread::yield_now();
        }
    }
}

#[test]
fn a_disk_that_takes_nothing_refuses_writes_and_harms_neither_drive_nor_file() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("state");
    let state = StateDir::open(&directory).unwrap();
    let mut bench = Bench::new(&state);
    assert_eq!(bench.write_v_pos(70), (0x13EC, 70));
    assert_eq!(stored_v_pos(&directory), 70);

    // Root writes to directories without permission, but not to those that are not there.
    let away = folder.path().join("away");
    fs::rename(&directory, &away).unwrap();
    for value in [71, 72] {
        assert_eq!(bench.write_v_pos(value), (0x73EC, 18));
        assert_eq!(bench.drive.unit().parameters().value(Parameter::VPos), 70);
    }
    assert_eq!(stored_v_pos(&away), 70);

    fs::rename(&away, &directory).unwrap();
    assert_eq!(bench.write_v_pos(73), (0x13EC, 73));
    assert_eq!(stored_v_pos(&directory), 73);
}

#[test]
fn a_write_error_is_said_once_and_so_is_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let (directory, away) = (folder.path().join("state"), folder.path().join("away"));
    let emulator = start(&directory);
    let mut master = Master::open(Path::new(emulator.link()));
    let mut write_v_pos = |value| {
        let job = Pkw::new(Pke::of_job(JobId::WriteWord, 1004), Ind::default(), value);
        master.job(job).unwrap().to_string()
    };
    assert_eq!(write_v_pos(70), "13EC 0000 0000 0046");
    fs::rename(&directory, &away).unwrap();
    assert_eq!(write_v_pos(71), "73EC 0000 0000 0012");
    assert_eq!(write_v_pos(72), "73EC 0000 0000 0012");
    fs::rename(&away, &directory).unwrap();
    assert_eq!(write_v_pos(73), "13EC 0000 0000 0049");
    let (code, stderr) = ended(emulator);
    assert_eq!(code, Some(0), "{stderr}");
    let lines = |says: &str| stderr.lines().filter(|line| line.contains(says)).count();
    let name = file(&directory).display().to_string();
    assert_eq!(lines(&format!("ERROR cannot store {name}: No such file or directory")), 1, "{stderr}");
    assert_eq!(lines(&format!("{name} is stored again")), 1, "{stderr}");
    assert_eq!(lines("refused with error 18, other error: the EEPROM did not store it"), 2, "{stderr}");
    assert_eq!(stored_v_pos(&directory), 73);
}

#[test]
fn a_full_disk_at_the_start_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // No file may grow, which is the nearest to a full disk that needs no disk.
    let script = "trap '' XFSZ; ulimit -f 0; exec \"$0\" emulate --state-dir \"$1\"";
    let command = env!("CARGO_BIN_EXE_profidrive");
    let output = Command::new("sh").args(["-c", script, command]).arg(folder.path()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("cannot use the EEPROM image") && stderr.contains("File too large"), "{stderr}");
    let names: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, [".lock"]);
}

/// What is the same for every disk that stops taking data while the emulator runs: the write is refused with error
/// 18 and the log says why, the drive goes on, the image is as before; and it is stored when there is room again.
fn lives_through(
    directory: &Path,
    says: &str,
    emulator: Emulator,
    end: impl FnOnce(u32),
    relief: impl FnOnce(u32),
) {
    let process = emulator.process.id();
    let mut master = Master::open(Path::new(emulator.link()));
    let mut job = |id, value| {
        let job = Pkw::new(Pke::of_job(id, 1004), Ind::default(), value);
        master.job(job).unwrap().to_string()
    };
    assert_eq!(job(JobId::WriteWord, 70), "13EC 0000 0000 0046");
    end(process);
    for value in [71, 72] {
        assert_eq!(job(JobId::WriteWord, value), "73EC 0000 0000 0012");
        assert_eq!(job(JobId::Read, 0), "13EC 0000 0000 0046", "the value goes back");
    }
    assert_eq!(stored_v_pos(directory), 70, "nothing is damaged");
    relief(process);
    assert_eq!(job(JobId::WriteWord, 73), "13EC 0000 0000 0049");
    assert_eq!(stored_v_pos(directory), 73);
    let (code, stderr) = ended(emulator);
    assert_eq!(code, Some(0), "{stderr}");
    let name = file(directory).display().to_string();
    assert!(stderr.contains(&format!("ERROR cannot store {name}: {says}")), "{stderr}");
    assert!(stderr.contains(&format!("{name} is stored again")), "{stderr}");
    assert_eq!(ended(start(directory)).0, Some(0), "and it starts again");
    assert_eq!(stored_v_pos(directory), 73);
}

/// Runs a command of the system, and says whether it could.
fn can(command: &str, arguments: &[&str]) -> bool {
    let output = Command::new(command).args(arguments).output();
    output.is_ok_and(|output| output.status.success())
}

/// A small file system in memory, which only root may mount; unmounted when dropped.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    fn mount() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().to_str().unwrap();
        can("mount", &["-t", "tmpfs", "-o", "size=64k", "tmpfs", path]).then(|| Self(folder))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        can("umount", &["-l", self.0.path().to_str().unwrap()]);
    }
}

#[test]
fn a_disk_that_fills_up_refuses_writes_until_there_is_room() {
    let Some(disk) = SmallDisk::mount() else {
        println!("!! NOT TESTED: only root can mount the small disk that this test fills");
        return;
    };
    let (state, ballast) = (disk.0.path().join("state"), disk.0.path().join("ballast"));
    let fill = |_| {
        let filled = fs::write(&ballast, vec![0; 1 << 20]);
        assert_eq!(filled.unwrap_err().kind(), std::io::ErrorKind::StorageFull);
    };
    let empty = |_| fs::remove_file(&ballast).unwrap();
    lives_through(&state, "No space left on device", start(&state), fill, empty);
}

/// Permissions do not hold root back, but an immutable directory does, on file systems that know that.
#[test]
fn a_directory_that_becomes_read_only_refuses_writes_until_it_can_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("state");
    let path = directory.to_str().unwrap();
    let emulator = start(&directory);
    assert!(can("chmod", &["a-w", path]));
    let (says, undo) = if fs::write(directory.join("x"), "").is_err() {
        ("Permission denied", ["chmod", "u+w"])
    } else if can("chattr", &["+i", path]) {
        ("Operation not permitted", ["chattr", "-i"])
    } else {
        println!("!! NOT TESTED: nothing makes a directory read-only for root here");
        return;
    };
    let change = |[command, mode]: [&str; 2]| assert!(can(command, &[mode, path]), "{command} {mode} {path}");
    change(undo);
    let again = [undo[0], if undo[0] == "chmod" { "a-w" } else { "+i" }];
    lives_through(&directory, says, emulator, |_| change(again), |_| change(undo));
}

/// Nobody needs to be root for this one: no file may grow any more, in a process whose limit is lowered while it runs.
#[test]
fn a_limit_on_the_size_of_files_refuses_writes_until_it_is_lifted() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("state");
    if !can("prlimit", &["--version"]) {
        println!("!! NOT TESTED: there is no prlimit to set a limit with");
        return;
    }
    // The signal that comes with it would end the process.
    let mut command = Command::new("sh");
    command.args([
        "-c",
        r#"trap '' XFSZ; exec "$0" emulate --state-dir "$1""#,
        env!("CARGO_BIN_EXE_profidrive"),
    ]);
    let emulator = Emulator::spawn(command.arg(&directory).stdin(Stdio::null()).env_remove("RUST_LOG"));
    let limit = |process: u32, bytes: &str| {
        let arguments = ["--pid", &process.to_string(), &format!("--fsize={bytes}:unlimited")];
        assert!(can("prlimit", &arguments), "{arguments:?}");
    };
    lives_through(
        &directory,
        "File too large",
        emulator,
        |pid| limit(pid, "0"),
        |pid| limit(pid, "unlimited"),
    );
}

#[test]
fn a_file_is_replaced_and_never_written_through_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let precious = folder.path().join("precious");
    fs::write(&precious, "precious").unwrap();
    let state = opened(folder.path());
    let mut bench = Bench::new(&state);
    symlink(&precious, folder.path().join(".ag03-1-005.eeprom.tmp")).unwrap();
    assert_eq!(bench.write_v_pos(70), (0x13EC, 70));
    assert_eq!(fs::read(&precious).unwrap(), b"precious");
}

#[test]
fn a_drive_that_is_dropped_runs_out_and_is_found_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let state = opened(folder.path());
    let mut bench = Bench::new(&state);
    let exchange =
        |bench: &mut Bench, stw| bench.request(None, &[0, 0, 0, 0, 0, 0, 0, 0, 0, stw, 0, 1, 0, 0]);
    for stw in [0x0B, 0x3B, 0x7B] {
        exchange(&mut bench, stw);
    }
    bench.now = bench.now.saturating_add(Duration::from_secs(3));
    let inputs = exchange(&mut bench, 0x7B);
    let travelled = bench.drive.unit().status().position;
    assert!(travelled > 1000, "{travelled}, {inputs:02X?}");
    drop(bench);
    drop(state);
    let state = opened(folder.path());
    let found = state.load(config(), Instant::ZERO).unwrap().unit().status().position;
    assert!(found > travelled && found < travelled + 1000, "{travelled}, then {found}");
    assert!(matches!(StateDir::open(folder.path()), Err(StateDirError::InUse { .. })));
}

/// The folder, once it is free: a program that another test starts right now has its lock until it runs.
fn opened(folder: &Path) -> StateDir {
    let start = std::time::Instant::now();
    loop {
        match StateDir::open(folder) {
            Err(StateDirError::InUse { .. }) if start.elapsed() < PATIENCE => {
                std::thread::yield_now();
            }
            opened => return opened.unwrap(),
        }
    }
}

/// Writes v-Pos as the panel does, without the bus.
fn set_v_pos(drive: &mut Stored<Device>, value: u16) {
    let pnu = Pnu::new(1004).unwrap();
    let now = Instant::from_millis(10);
    drive.unit_mut().write_parameter(now, pnu, None, Value::Word(value)).unwrap();
    drive.act(now, |drive| drive.handle_timeout(now));
}

fn v_pos(drive: &Stored<Device>) -> i32 {
    drive.unit().parameters().value(Parameter::VPos)
}

#[test]
fn a_drive_removed_and_added_again_is_as_it_was_however_slow_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let state = opened(folder.path());
    for round in 0..100 {
        let mut drive = state.load(config(), Instant::ZERO).unwrap();
        set_v_pos(&mut drive, 50 + round % 50);
        drop(drive);
        let found = v_pos(&state.load(config(), Instant::ZERO).unwrap());
        assert_eq!(found, i32::from(50 + round % 50), "in round {round}");
    }
    drop(state);
    assert_eq!(stored_v_pos(folder.path()), 99);
}

/// As with the DIP switches: silent, its parameters reset, its address as before.
#[test]
fn a_factory_reset_of_a_drive_from_the_command_line_is_in_its_image() {
    let folder = tempfile::tempdir().unwrap();
    let state = opened(folder.path());
    let mut drive = state.load(config(), Instant::ZERO).unwrap();
    set_v_pos(&mut drive, 71);
    drop(drive);
    drop(state);
    assert_eq!(stored_v_pos(folder.path()), 71);
    let arguments = ["--state-dir", folder.path().to_str().unwrap()];
    let with = |drive: &str| Emulator::start(&[&arguments[..], &["--drive", drive]].concat());
    let (code, log) = ended(with("5,reset=all"));
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("all parameters are back at their factory settings"), "{log}");
    assert_eq!(stored_v_pos(folder.path()), 30);
    assert_eq!(ended(with("5")).0, Some(0));
    assert_eq!(stored_v_pos(folder.path()), 30);
    let line = folder.path().join("line.toml");
    let drive = "[[line.drive]]\naddress = 5\nreset = \"all\"\nvalues = { v-Pos = 40 }\n";
    fs::write(&line, format!("[[line]]\nlink = \"tcp:127.0.0.1:0\"\n{drive}")).unwrap();
    let output = emulate(&["--line", line.to_str().unwrap(), "--check"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("a drive with 'reset' has its defaults"), "{said}");
}

#[test]
fn a_file_belongs_to_one_drive_wherever_its_dip_switches_take_it() {
    let folder = tempfile::tempdir().unwrap();
    let state = opened(folder.path());
    let mut moved = state.load(config(), Instant::ZERO).unwrap();
    moved.unit_mut().power_off(Instant::from_millis(1));
    moved.unit_mut().set_switches(Address::station(6).unwrap().into());
    moved.unit_mut().power_on(Instant::from_millis(2));
    assert_eq!(moved.unit().address().number(), 6);

    let error = state.load(config(), Instant::from_millis(3)).unwrap_err();
    assert!(error.to_string().contains("ag03-1-005.eeprom"), "{error}");
    // Its name is its own again when it is gone, and with it all it was told.
    set_v_pos(&mut moved, 71);
    drop(moved);
    assert_eq!(v_pos(&state.load(config(), Instant::from_millis(4)).unwrap()), 71);
}

#[test]
fn a_lock_that_is_no_file_is_refused_at_once_and_made_nothing_of() {
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = folder.path().join("elsewhere");
    for (kind, says) in
        [("fifo", "is a pipe"), ("directory", "is a directory"), ("link", "is a symbolic link")]
    {
        let directory = folder.path().join(kind);
        fs::create_dir(&directory).unwrap();
        let lock = directory.join(".lock");
        match kind {
            "fifo" => assert!(can("mkfifo", &[lock.to_str().unwrap()])),
            "directory" => fs::create_dir(&lock).unwrap(),
            _ => symlink(&elsewhere, &lock).unwrap(),
        }
        let mut command = Command::new("timeout");
        command
            .args(["--signal=KILL", "10", env!("CARGO_BIN_EXE_profidrive"), "emulate", "--state-dir"])
            .arg(&directory);
        let Output { status, stderr, .. } = command.env_remove("RUST_LOG").output().unwrap();
        let stderr = String::from_utf8(stderr).unwrap();
        assert_eq!(status.code(), Some(1), "{kind}: {stderr}");
        let line = stderr.lines().last().unwrap();
        assert!(line.contains(lock.to_str().unwrap()) && line.contains(says), "{line}");
        assert!(line.contains("remove it"), "{line}");
        assert!(!elsewhere.exists());
    }
}
