//! How the process is told from outside to end: signals of Unix, events of the console of Windows.
//!
//! | wish | Unix | Windows |
//! | --- | --- | --- |
//! | end | SIGINT, SIGTERM, SIGHUP (a closed terminal), SIGQUIT (no core dump) | Ctrl-C, Ctrl-Break, closed console, log-off, shutdown |
//! | report | SIGUSR1 | none |
//!
//! Where it is asked for, the end of the standard input wishes the end, too.

use core::sync::atomic::{AtomicBool, Ordering};
use std::io;
use std::sync::Arc;
use std::thread;

use crate::host::Stop;

#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

#[cfg(unix)]
use unix as system;
#[cfg(windows)]
use windows as system;

/// How wishes reach a loop that also ends for other reasons: each ends the run, and the flag says what for.
pub(crate) struct Signals {
    pub(crate) stop: Stop,
    /// The end is wished.
    pub(crate) end: Arc<AtomicBool>,
    /// A report is wished.
    pub(crate) report: Arc<AtomicBool>,
}

impl Signals {
    /// From now on no wish ends the process by itself.
    pub(crate) fn register() -> io::Result<Self> {
        let signals = Self { stop: Stop::new()?, end: Arc::default(), report: Arc::default() };
        system::register(&signals)?;
        Ok(signals)
    }

    /// As if the end were wished.
    pub(crate) fn end(&self) {
        self.end.store(true, Ordering::SeqCst);
        self.stop.request();
    }
}

/// Calls `act` when the standard input has ended, as it does with the program that holds its other end.
pub(crate) fn when_stdin_ends(act: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let wait = move || {
        // What comes is for nobody; what fails has ended.
        let _ = io::copy(&mut io::stdin().lock(), &mut io::sink());
        act();
    };
    thread::Builder::new().name("stdin".into()).spawn(wait).map(drop)
}

/// Requested when the end is wished; from now on that does not end the process by itself.
pub(crate) fn stop_at_end() -> io::Result<Stop> {
    let stop = Stop::new()?;
    system::stop_at_end(&stop)?;
    Ok(stop)
}
