//! `--ask`: a command of the user that operates the master.

use std::process::{Child, Command, Stdio};

use profidrive::judge::Operator;
use tracing::{info, warn};

/// The command, and what it is doing.
pub(super) struct Operated {
    command: String,
    running: Option<Child>,
    /// It could not be started.
    failed: bool,
}

impl Operated {
    pub(super) fn new(command: &str) -> Self {
        Self { command: command.into(), running: None, failed: false }
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
            Ok(child) => self.running = Some(child),
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
        let status = self.running.as_mut()?.try_wait().ok()??;
        self.running = None;
        Some(status.success())
    }
}
