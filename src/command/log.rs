//! The log on stderr. Writing it never holds up the line.

use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use std::io::{self, IsTerminal, Write};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use super::args::Verbosity;

/// Lines kept for a stderr that is slow or not read at all. More are dropped and counted.
const BACKLOG: usize = 1024;

/// How long the end of the command waits at most for a stderr that does not take the last lines.
const PATIENCE: Duration = Duration::from_millis(500);

/// A running log.
pub(crate) struct Log {
    lines: SyncSender<Entry>,
    finished: Receiver<()>,
}

enum Entry {
    Line(Vec<u8>),
    Finish,
}

/// Starts the log: level from `-v` and `-q`, else from `RUST_LOG`, else info.
pub(crate) fn start(verbosity: Verbosity) -> Log {
    let (lines, entries) = sync_channel(BACKLOG);
    let (done, finished) = sync_channel(1);
    let dropped = Arc::new(AtomicU64::new(0));
    let writer = Lines { lines: lines.clone(), dropped: Arc::clone(&dropped) };
    thread::spawn(move || {
        write(&entries, &dropped);
        let _ = done.send(());
    });

    let (targets, complaint) = targets(verbosity, std::env::var("RUST_LOG").ok());
    let format = tracing_subscriber::fmt::layer()
        .with_writer(writer)
        .with_ansi(io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|no| no.is_empty()))
        .with_target(false)
        .log_internal_errors(false);
    tracing_subscriber::registry().with(targets).with(format).init();
    if let Some(complaint) = complaint {
        tracing::warn!("{complaint}");
    }
    Log { lines, finished }
}

/// What to log, and what was not understood.
fn targets(verbosity: Verbosity, rust_log: Option<String>) -> (Targets, Option<String>) {
    let level = |level: LevelFilter| Targets::new().with_default(level);
    match (verbosity.verbose, verbosity.quiet, rust_log) {
        // A repeated telegram is a warning to profirust, and nothing to a person.
        (_, true, _) => (level(LevelFilter::WARN).with_target("profirust", LevelFilter::ERROR), None),
        (2.., false, _) => (level(LevelFilter::TRACE), None),
        (1, false, _) => (level(LevelFilter::DEBUG), None),
        (0, false, Some(wanted)) if !wanted.is_empty() => match wanted.parse() {
            Ok(targets) => (targets, None),
            Err(error) => (level(LevelFilter::INFO), Some(format!("RUST_LOG is not understood: {error}"))),
        },
        (0, false, Some(_) | None) => (level(LevelFilter::INFO), None),
    }
}

impl Log {
    /// Waits until everything logged is written, but not for ever.
    pub(crate) fn finish(self) {
        if self.lines.try_send(Entry::Finish).is_ok() {
            let _ = self.finished.recv_timeout(PATIENCE);
        }
    }
}

/// Writes lines as they come, until the end of the log.
fn write(entries: &Receiver<Entry>, dropped: &AtomicU64) {
    while let Ok(Entry::Line(line)) = entries.recv() {
        let lost = dropped.swap(0, Ordering::Relaxed);
        let mut stderr = io::stderr().lock();
        // Nobody is left to tell when stderr does not work.
        if lost > 0 {
            let _ =
                writeln!(stderr, "({lost} lines of the log were dropped: stderr is not read fast enough)");
        }
        let _ = stderr.write_all(&line);
    }
}

/// Where `tracing` puts its lines, one per write.
struct Lines {
    lines: SyncSender<Entry>,
    dropped: Arc<AtomicU64>,
}

impl<'a> MakeWriter<'a> for Lines {
    type Writer = &'a Self;

    fn make_writer(&'a self) -> &'a Self {
        self
    }
}

impl Write for &Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        if self.lines.try_send(Entry::Line(line.to_vec())).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing::Level;

    fn enabled(verbose: u8, quiet: bool, rust_log: Option<&str>) -> Vec<Level> {
        let (targets, _) = targets(Verbosity { verbose, quiet }, rust_log.map(Into::into));
        let all = [Level::ERROR, Level::WARN, Level::INFO, Level::DEBUG, Level::TRACE];
        all.into_iter().filter(|level| targets.would_enable("profidrive", level)).collect()
    }

    #[test]
    fn flags_win_over_the_environment_and_info_is_the_default() {
        assert_eq!(enabled(0, false, None).last(), Some(&Level::INFO));
        assert_eq!(enabled(0, false, Some("")).last(), Some(&Level::INFO));
        assert_eq!(enabled(0, false, Some("debug")).last(), Some(&Level::DEBUG));
        assert_eq!(enabled(0, false, Some("profidrive=error")).last(), Some(&Level::ERROR));
        assert_eq!(enabled(0, true, Some("trace")).last(), Some(&Level::WARN));
        assert_eq!(enabled(1, false, Some("error")).last(), Some(&Level::DEBUG));
        assert_eq!(enabled(9, false, None).last(), Some(&Level::TRACE));
    }

    #[test]
    fn a_line_nobody_takes_is_dropped_and_counted() {
        let (lines, entries) = sync_channel(1);
        let sink = Lines { lines, dropped: Arc::default() };
        for _ in 0..3 {
            (&sink).write_all(b"line\n").unwrap();
        }
        assert_eq!(sink.dropped.load(Ordering::Relaxed), 2);
        assert!(matches!(entries.try_recv(), Ok(Entry::Line(line)) if line == b"line\n"));
    }
}
