//! `profidrive` as processes: an emulator, and commands of a master to its drives.

use core::time::Duration;
use std::fs;
use std::io::{BufRead, BufReader, Read, Seek};
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::thread;
use std::time::Instant;

use serde_json::Value;

use crate::patience::PATIENCE;

pub(crate) fn profidrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command.args(arguments).env_remove("RUST_LOG").stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A process that is ended with the test, by its own id.
pub(crate) struct Running {
    pub(crate) process: Child,
    pub(crate) stdout: BufReader<ChildStdout>,
}

impl Running {
    pub(crate) fn start(mut command: Command) -> Self {
        let mut process = command.spawn().unwrap();
        let stdout = BufReader::new(process.stdout.take().unwrap());
        Self { process, stdout }
    }

    /// Reads stdout up to a line with `part`.
    pub(crate) fn until(&mut self, part: &str) -> String {
        let mut line = String::new();
        while !line.contains(part) {
            line.clear();
            if self.stdout.read_line(&mut line).unwrap() == 0 {
                let (code, _, stderr) = self.end();
                panic!("ended with {code:?} without '{part}': {stderr}");
            }
        }
        line
    }

    /// Waits until the drive belongs to this master, whose log (`-v`) says so; gives the rest of the log.
    pub(crate) fn taken(&mut self) -> BufReader<ChildStderr> {
        let mut log = BufReader::new(self.process.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("becomes ready for data exchange") {
            line.clear();
            assert!(log.read_line(&mut line).unwrap() > 0, "ended before");
        }
        log
    }

    pub(crate) fn signal(&self, signal: &str) {
        let command = format!("kill -{signal} {}", self.process.id());
        assert!(Command::new("sh").args(["-c", &command]).status().unwrap().success());
    }

    /// Waits for the end: exit code, the rest of stdout, stderr.
    pub(crate) fn end(&mut self) -> (Option<i32>, String, String) {
        let start = Instant::now();
        let status = loop {
            match self.process.try_wait().unwrap() {
                Some(status) => break status,
                None if start.elapsed() > PATIENCE => panic!("still running"),
                None => thread::sleep(Duration::from_millis(5)),
            }
        };
        let (mut stdout, mut stderr) = (String::new(), String::new());
        self.stdout.read_to_string(&mut stdout).unwrap();
        if let Some(mut pipe) = self.process.stderr.take() {
            pipe.read_to_string(&mut stderr).unwrap();
        }
        (status.code(), stdout, stderr)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A running emulator and how a master reaches it.
pub(crate) struct Emulator {
    pub(crate) running: Running,
    pub(crate) link: String,
    /// What it has seen, for a test that fails.
    pub(crate) log: Option<fs::File>,
}

impl Drop for Emulator {
    fn drop(&mut self) {
        if let Some(log) = self.log.as_mut().filter(|_| thread::panicking()) {
            self.running.signal("USR1");
            thread::sleep(Duration::from_millis(200));
            let mut text = String::new();
            log.rewind().and_then(|()| log.read_to_string(&mut text)).unwrap();
            eprintln!("the emulator at {}:\n{text}", self.link);
        }
    }
}

impl Emulator {
    /// Drive 5 is an AG03/1, drive 6 an AG03 with gear 24:1.
    pub(crate) fn start(link: &str, arguments: &[&str]) -> Self {
        let mut command = profidrive(&["emulate", "--link", link]);
        command.args(["--drive", "5", "--drive", "6,model=ag03,gear=24"]).args(arguments);
        let log = tempfile::tempfile().unwrap();
        command.stderr(log.try_clone().unwrap());
        let mut running = Running::start(command);
        let ready = running.until("ready link=");
        let link = ready.split(' ').nth(1).unwrap().strip_prefix("link=").unwrap().to_owned();
        Self { running, link, log: Some(log) }
    }

    /// A link without an emulator of this test.
    pub(crate) fn nowhere(link: &str) -> Self {
        Self { running: Running::start(profidrive(&["--version"])), link: link.into(), log: None }
    }

    /// A command of a master to drive `address`. No busy machine makes its drive let go, and none keeps an emulator from
    /// answering for a second and a half.
    pub(crate) fn command(&self, address: &str, arguments: &[&str]) -> Command {
        let mut command = profidrive(&["master", "--link", &self.link, "--address", address]);
        command.args(["--watchdog", "30s", "--slot-time", "100ms"]).args(arguments);
        command
    }

    /// The same for a command that takes long: an emulator may be held up for four seconds, as it is now and then while
    /// many terminals are opened and closed.
    pub(crate) fn patiently(&self, address: &str, arguments: &[&str]) -> Command {
        let mut command = profidrive(&["master", "--link", &self.link, "--address", address]);
        command.args(["--watchdog", "60s", "--baud", "93750", "--slot-time", "300ms"]).args(arguments);
        command
    }

    /// What comes of it: exit code, stdout, stderr.
    pub(crate) fn master(&self, address: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
        Running::start(self.command(address, arguments)).end()
    }

    /// What it prints when it works.
    pub(crate) fn works(&self, address: &str, arguments: &[&str]) -> String {
        let (code, stdout, stderr) = self.master(address, arguments);
        assert_eq!((code, stderr.as_str()), (Some(0), ""), "{arguments:?}: {stdout}");
        stdout
    }

    pub(crate) fn json(&self, address: &str, arguments: &[&str]) -> Value {
        let arguments = [arguments, &["--json"]].concat();
        serde_json::from_str(&self.works(address, &arguments)).unwrap()
    }

    /// One line that says what went wrong.
    pub(crate) fn fails(&self, address: &str, arguments: &[&str], expected: i32, says: &str) {
        fails(self.command(address, arguments), expected, says);
    }
}

pub(crate) fn fails(command: Command, expected: i32, says: &str) {
    let what = format!("{command:?}");
    let (code, stdout, stderr) = Running::start(command).end();
    assert_eq!(code, Some(expected), "{what}: {stdout}{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{what}: {stderr}");
    assert!(stderr.starts_with("profidrive: ") && stderr.contains(says), "{what}: {stderr}");
}
