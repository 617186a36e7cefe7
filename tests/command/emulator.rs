//! `profidrive` as a process, and a running emulator.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

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
        let mut command = profidrive(&["emulate"]);
        let mut process =
            command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
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

    pub(crate) fn signal(&self, signal: &str) {
        let command = format!("kill -{signal} {}", self.process.id());
        assert!(Command::new("sh").args(["-c", &command]).status().unwrap().success());
    }

    /// Waits for its end: exit code, the rest of stdout, stderr.
    pub(crate) fn end(mut self, within: Duration) -> (Option<i32>, String, String) {
        let start = Instant::now();
        let status = loop {
            match self.process.try_wait().unwrap() {
                Some(status) => break status,
                None if start.elapsed() > within => panic!("still running"),
                None => thread::sleep(Duration::from_millis(5)),
            }
        };
        let (mut stdout, mut stderr) = (String::new(), String::new());
        self.stdout.read_to_string(&mut stdout).unwrap();
        self.process.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        (status.code(), stdout, stderr)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
