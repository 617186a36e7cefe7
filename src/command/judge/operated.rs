//! `--ask`: a command of the user that operates the master.

use core::time::Duration;
use std::io::Read as _;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use crate::judge::Operator;
use tracing::{info, warn};

/// An action takes so long at most.
const LIMIT: Duration = Duration::from_secs(10);

/// Octets of what an action says at most.
const MOST_SAID: u64 = 4096;

/// Its end is looked for so often.
const PULSE: Duration = Duration::from_millis(20);

/// The command, and what it is doing.
pub(super) struct Operated {
    command: String,
    running: Option<(Child, Instant)>,
    /// It could not be started.
    failed: bool,
}

impl Operated {
    pub(super) fn new(command: &str) -> Self {
        Self { command: command.into(), running: None, failed: false }
    }
}

impl Operated {
    /// Runs an action to its end: whether it is done.
    pub(super) fn run(&mut self, action: &str) -> bool {
        self.begin(action);
        loop {
            match self.poll() {
                Some(done) => return done,
                None if self.running.is_none() => return false,
                None => std::thread::sleep(PULSE),
            }
        }
    }
}

/// The command with an action. It may have arguments of its own.
fn shell(command: &str, action: &str) -> Command {
    let script = format!("{command} \"$@\"");
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(script).arg("sh").args(action.split(' ')).stdin(Stdio::null());
    shell
}

/// What an action says to its end; `None`: it could not be done.
pub(super) fn output(command: &str, action: &str) -> Option<String> {
    let mut child = match shell(command, action).stdout(Stdio::piped()).spawn() {
        Ok(child) => child,
        Err(error) => {
            warn!("cannot run {command}: {error}");
            return None;
        }
    };
    let begun = Instant::now();
    let success = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status.success(),
            Ok(None) if begun.elapsed() < LIMIT => std::thread::sleep(PULSE),
            Ok(None) | Err(_) => {
                warn!("{command} does not end within {} s", LIMIT.as_secs());
                let _ = child.kill().and_then(|()| child.wait());
                break false;
            }
        }
    };
    let mut said = String::new();
    // What it left running may hold the pipe: only what it wrote itself is read.
    let octets = child.stdout.as_mut().map(|stdout| stdout.take(MOST_SAID).read_to_string(&mut said));
    (success && octets.is_none_or(|read| read.is_ok())).then_some(said)
}

impl Operator for Operated {
    fn begin(&mut self, action: &str) {
        info!("asking: {} {action}", self.command);
        match shell(&self.command, action).stdout(Stdio::null()).spawn() {
            Ok(child) => self.running = Some((child, Instant::now())),
            Err(error) => {
                warn!("cannot run {}: {error}", self.command);
                self.failed = true;
            }
        }
    }

    fn poll(&mut self) -> Option<bool> {
        if core::mem::take(&mut self.failed) {
            return Some(false);
        }
        let (child, begun) = self.running.as_mut()?;
        let success = match child.try_wait() {
            Ok(Some(status)) => status.success(),
            Ok(None) if begun.elapsed() < LIMIT => return None,
            Ok(None) | Err(_) => {
                warn!("{} does not end within {} s", self.command, LIMIT.as_secs());
                // It may have ended just now.
                let _ = child.kill().and_then(|()| child.wait());
                false
            }
        };
        self.running = None;
        Some(success)
    }
}
