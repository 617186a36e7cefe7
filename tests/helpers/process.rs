//! Programs that a test starts.

use std::process::{Child, ExitStatus};
use std::thread;
use std::time::{Duration, Instant};

use crate::patience::PATIENCE;

/// How `child` has ended. One that does not end is killed, and the test fails.
pub(crate) fn end_of(child: &mut Child) -> ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("still running after {PATIENCE:?}, killed");
        }
        thread::sleep(Duration::from_millis(2));
    }
}

/// From now on SIGHUP ends programs that this one starts. Where it is ignored (`nohup`, many CI runners), they would
/// ignore it, too; what is handled here is not ignored there.
#[cfg(unix)]
pub(crate) fn hangup_ends_programs() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        signal_hook::flag::register(signal_hook::consts::SIGHUP, std::sync::Arc::default()).unwrap();
    });
}
