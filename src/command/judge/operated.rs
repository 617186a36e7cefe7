//! `--ask`: a command of the user that operates the master.

use core::time::Duration;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use crate::judge::Operator;
use tracing::{info, warn};

/// An action takes so long at most.
const LIMIT: Duration = Duration::from_secs(10);

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

impl Operator for Operated {
    fn begin(&mut self, action: &str) {
        info!("asking: {} {action}", self.command);
        // The command may have arguments of its own.
        let script = format!("{} \"$@\"", self.command);
        let mut command = Command::new("sh");
        command
            .arg("-c")
            .arg(script)
            .arg("sh")
            .args(action.split(' '))
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        match command.spawn() {
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
