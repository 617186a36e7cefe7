//! `profidrive` as a process, and a running emulator.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::patience::PATIENCE;

pub(crate) fn profidrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command.args(arguments).env_remove("RUST_LOG").stdin(Stdio::null());
    command
}

/// Runs to its end.
pub(crate) fn output(arguments: &[&str]) -> Output {
    profidrive(arguments).output().unwrap()
}

/// A running emulator; dropped, it is killed.
pub(crate) struct Emulator {
    pub(crate) process: Child,
    stdout: BufReader<ChildStdout>,
    /// Its first line.
    pub(crate) ready: String,
}

impl Emulator {
    /// Started, and past its ready line.
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::spawn(profidrive(&["emulate"]).args(arguments))
    }

    /// The same of a command that runs an emulator.
    pub(crate) fn spawn(command: &mut Command) -> Self {
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stdout = BufReader::new(process.stdout.take().unwrap());
        let mut ready = String::new();
        stdout.read_line(&mut ready).unwrap();
        if ready.is_empty() {
            let mut stderr = String::new();
            process.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
            panic!("{stderr}");
        }
        Self { process, stdout, ready }
    }

    /// The next line that it says: of another line of PROFIBUS.
    pub(crate) fn line(&mut self) -> String {
        let mut line = String::new();
        self.stdout.read_line(&mut line).unwrap();
        line
    }

    /// What a master opens.
    pub(crate) fn link(&self) -> &str {
        let link = self.ready.split(' ').nth(1).and_then(|word| word.strip_prefix("link="));
        link.unwrap_or_else(|| panic!("{:?}", self.ready)).trim_end()
    }

    pub(crate) fn signal(&self, signal: &str) {
        let command = format!("kill -{signal} {}", self.process.id());
        assert!(Command::new("sh").args(["-c", &command]).status().unwrap().success());
    }

    /// Waits for its end: exit code, the rest of stdout, stderr.
    pub(crate) fn end(mut self) -> (Option<i32>, String, String) {
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
        self.process.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        (status.code(), stdout, stderr)
    }

    /// Memory of its own that it holds now, KiB. Without the pages of the program's file: how many of those of a debug
    /// build are in memory is the system's choice.
    pub(crate) fn resident(&self) -> u64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.process.id())).unwrap();
        let line = status.lines().find(|line| line.starts_with("RssAnon")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    }

    /// Processor time used so far, user and system.
    pub(crate) fn cpu_time(&self) -> Duration {
        let stat = fs::read_to_string(format!("/proc/{}/stat", self.process.id())).unwrap();
        let (_, fields) = stat.rsplit_once(')').unwrap();
        let ticks: u64 = fields.split_whitespace().skip(11).take(2).map(|t| t.parse::<u64>().unwrap()).sum();
        Duration::from_millis(ticks * 10)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
