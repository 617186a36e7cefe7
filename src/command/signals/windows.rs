//! Events of the console.
//!
//! After the console is closed, at log-off and at shutdown Windows ends the process when its handler returns, and after 5 s in
//! any case. That of tokio does not return, so the process has this time to end by itself.

use core::sync::atomic::Ordering;
use std::io;
use std::sync::Arc;
use std::thread;

use crate::host::Stop;
use tokio::runtime::Builder;
use tokio::signal::windows::{ctrl_break, ctrl_c, ctrl_close, ctrl_logoff, ctrl_shutdown};

use super::Signals;

pub(super) fn register(signals: &Signals) -> io::Result<()> {
    let (end, stop) = (Arc::clone(&signals.end), signals.stop.clone());
    at_end(move || {
        end.store(true, Ordering::SeqCst);
        stop.request();
    })
}

pub(super) fn stop_at_end(stop: &Stop) -> io::Result<()> {
    let stop = stop.clone();
    at_end(move || stop.request())
}

/// Calls `act` on a thread of its own each time the end is wished.
fn at_end(act: impl Fn() + Send + 'static) -> io::Result<()> {
    let runtime = Builder::new_current_thread().build()?;
    // Taken before this returns, so that no event is missed.
    let (mut c, mut pause) = (ctrl_c()?, ctrl_break()?);
    let (mut close, mut logoff, mut shutdown) = (ctrl_close()?, ctrl_logoff()?, ctrl_shutdown()?);
    let wait = move || {
        runtime.block_on(async {
            loop {
                tokio::select! {
                    _ = c.recv() => {}
                    _ = pause.recv() => {}
                    _ = close.recv() => {}
                    _ = logoff.recv() => {}
                    _ = shutdown.recv() => {}
                }
                act();
            }
        });
    };
    thread::Builder::new().name("console".into()).spawn(wait).map(drop)
}
