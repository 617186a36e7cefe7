//! Signals.

use core::ffi::c_int;
use std::io;
use std::sync::Arc;

use crate::host::Stop;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1};
use signal_hook::{flag, low_level::pipe};

use super::Signals;

/// SIGQUIT stays what it is: drives need no goodbye.
pub(super) fn register(signals: &Signals) -> io::Result<()> {
    let ends = [SIGINT, SIGTERM, SIGHUP].map(|signal| (signal, &signals.end));
    let asked = ends.into_iter().chain([(SIGUSR1, &signals.report)]);
    for (signal, wish) in asked.filter(|(signal, _)| *signal != SIGHUP || !hangup_is_ignored()) {
        // Before what ends the run, so that it is seen then.
        flag::register(signal, Arc::clone(wish))?;
        stops(signal, &signals.stop)?;
    }
    Ok(())
}

pub(super) fn stop_at_end(stop: &Stop) -> io::Result<()> {
    [SIGINT, SIGTERM, SIGHUP, SIGQUIT].into_iter().try_for_each(|signal| stops(signal, stop))
}

fn stops(signal: c_int, stop: &Stop) -> io::Result<()> {
    let (flag, stream) = stop.waker()?;
    flag::register(signal, flag)?;
    pipe::register(signal, stream)?;
    Ok(())
}

/// Whether whoever started this process had it ignore SIGHUP, as `nohup` does. Told only by Linux.
fn hangup_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    // The lowest bit is signal 1.
    ignored >> (SIGHUP - 1) & 1 == 1
}
