//! The symbolic link of `emulate --link pty:PATH` when the emulator ends in other ways than asked for.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use rustix::fd::OwnedFd;
use rustix::pty::OpenptFlags;

use crate::process::{end_of, hangup_ends_programs};

/// A running emulator with a link; dropped, it is killed.
struct Emulator(Child);

impl Emulator {
    /// `None` if it refused.
    fn start(link: &Path) -> Option<Self> {
        let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
        Self::spawn(command.args(["emulate", "--link", &format!("pty:{}", link.display())]))
    }

    fn spawn(command: &mut Command) -> Option<Self> {
        let command = command.env_remove("RUST_LOG").stdin(Stdio::null());
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut ready = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut ready).unwrap();
        let started = Self(process);
        ready.starts_with("ready ").then_some(started)
    }

    fn signal(mut self, signal: &str) -> Option<i32> {
        let command = format!("kill -{signal} {}", self.0.id());
        assert!(Command::new("sh").args(["-c", &command]).status().unwrap().success());
        end_of(&mut self.0).code()
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Everything in a folder, hidden or not.
fn names(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

/// Somebody else's terminals, the one that `link` leads to among them.
fn take_terminal(link: &Path) -> Vec<OwnedFd> {
    let mut taken = Vec::new();
    while !link.exists() && taken.len() < 100 {
        let terminal = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        rustix::pty::grantpt(&terminal).unwrap();
        rustix::pty::unlockpt(&terminal).unwrap();
        taken.push(terminal);
    }
    taken
}

/// How a master on the link ends, and what it says.
fn master(link: &Path) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command
        .args(["master", "--link", &format!("pty:{}", link.display()), "--address", "5", "diag"])
        .env_remove("RUST_LOG");
    let Output { status, stderr, .. } = command.stdin(Stdio::null()).output().unwrap();
    (status.code(), String::from_utf8(stderr).unwrap())
}

#[test]
fn every_way_to_end_it_removes_the_link() {
    hangup_ends_programs();
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("bus");
    for signal in ["INT", "TERM", "HUP"] {
        let emulator = Emulator::start(&link).unwrap();
        assert!(link.exists());
        assert_eq!(emulator.signal(signal), Some(0), "SIG{signal}");
        assert_eq!(names(folder.path()), [] as [PathBuf; 0], "after SIG{signal}");
    }
}

#[test]
fn under_nohup_it_stays_when_the_window_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("bus");
    let script = "trap '' HUP; exec \"$0\" emulate --link \"$1\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_profidrive"), &format!("pty:{}", link.display())]);
    let emulator = Emulator::spawn(&mut command).unwrap();
    let hang_up = format!("kill -HUP {}", emulator.0.id());
    assert!(Command::new("sh").args(["-c", &hang_up]).status().unwrap().success());
    assert_eq!(master(&link).0, Some(0));
    assert_eq!(emulator.signal("TERM"), Some(0));
}

#[test]
fn the_link_of_a_killed_emulator_is_not_taken_for_a_running_one_when_its_terminal_is_somebody_elses() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("bus");
    Emulator::start(&link).unwrap().signal("KILL");
    assert!(fs::symlink_metadata(&link).is_ok(), "left behind");
    let _strangers = take_terminal(&link);
    assert!(link.exists(), "the number of the terminal is used again");

    let (code, said) = master(&link);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("was left by an emulator that has ended"), "{said}");
    let emulator = Emulator::start(&link).expect("the link is replaced");
    assert_eq!(emulator.signal("TERM"), Some(0));
    assert_eq!(names(folder.path()), [] as [PathBuf; 0]);
}

#[test]
fn the_link_of_a_running_emulator_and_of_another_program_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("bus");
    let first = Emulator::start(&link).unwrap();
    let led = fs::read_link(&link).unwrap();
    assert!(Emulator::start(&link).is_none(), "two on one link");
    assert_eq!(fs::read_link(&link).unwrap(), led);
    assert_eq!(first.signal("TERM"), Some(0));

    let terminal = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    let name = rustix::pty::ptsname(&terminal, Vec::new()).unwrap().into_string().unwrap();
    std::os::unix::fs::symlink(&name, &link).unwrap();
    assert!(Emulator::start(&link).is_none(), "it leads to another program's terminal");
    assert_eq!(fs::read_link(&link).unwrap(), Path::new(&name));
    assert_eq!(names(folder.path()), [link]);
}
