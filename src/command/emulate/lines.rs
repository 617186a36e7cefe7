//! Several lines in one process, each on a thread of its own: all of them or none.

use core::sync::atomic::{AtomicBool, Ordering};
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use crate::host::{Reach, Stop, ValueBoard};
use crate::metrics::{LineMetrics, Metrics, MetricsError, NodeMetrics, PATH};
use crate::panel::Lines;
use tracing::{error_span, info, warn};

use super::{LinePlan, LinesPlan, run_line};
use crate::command::Failure;
use crate::command::args::MetricsSpec;
use crate::command::signals::{Signals, when_stdin_ends};

/// Runs all lines until a signal, or until one of them fails, or until the standard input ends if they shall end with it.
pub(super) fn run(plan: LinesPlan, end_with_stdin: bool) -> Result<(), Failure> {
    let LinesPlan { lines: mut plans, metrics } = plan;
    // Before any line, so that a refusal leaves nothing behind.
    let metrics = metrics.as_ref().map(start_metrics).transpose()?;
    let common = Arc::new(Common {
        count: plans.len(),
        metrics,
        panel_lines: Lines::default(),
        board: ValueBoard::default(),
        state: Mutex::default(),
        changed: Condvar::new(),
    });
    if end_with_stdin {
        let all = Arc::clone(&common);
        when_stdin_ends(move || all.end()).map_err(|error| Failure::from_error(&error))?;
    }
    let starts = |number| Start { number, common: Arc::clone(&common) };
    if plans.len() == 1
        && let Some(plan) = plans.pop()
    {
        return run_line(plan, &starts(0));
    }
    let line = |(number, plan): (usize, LinePlan)| {
        let start = starts(number);
        thread::spawn(move || {
            let _line = error_span!("line", number = number + 1).entered();
            // A thread that panics ends the others, too.
            let end = EndAll(&start.common);
            let outcome = run_line(plan, &start);
            if outcome.is_ok() {
                core::mem::forget(end);
            }
            outcome
        })
    };
    let threads: Vec<_> = plans.into_iter().enumerate().map(line).collect();
    let outcomes: Vec<_> = threads.into_iter().map(thread::JoinHandle::join).collect();
    let panicked = |_| Err(Failure::Other("the thread of a line has panicked".into()));
    outcomes.into_iter().try_for_each(|outcome| outcome.unwrap_or_else(panicked))
}

/// Says where the metrics are, or why there are none.
fn start_metrics(spec: &MetricsSpec) -> Result<Metrics, Failure> {
    let reach = if spec.allow_remote { Reach::Network } else { Reach::ThisMachine };
    let metrics = Metrics::start(&spec.place, reach).map_err(|error| match error {
        MetricsError::TooFar { .. } => Failure::Usage(format!(
            "{error}; add --metrics-allow-remote if that is wanted, or use --metrics 127.0.0.1:PORT; see 'profidrive \
             emulate --help'"
        )),
        // The address is wrong, or taken.
        MetricsError::Listen { .. } => Failure::Usage(Failure::from_error(&error).into_line()),
        MetricsError::Thread { .. } => Failure::from_error(&error),
    })?;
    let address = metrics.address();
    info!("the metrics are at http://{address}{PATH}");
    if !address.ip().is_loopback() {
        warn!("other machines can connect to {address} and read the metrics");
    }
    Ok(metrics)
}

/// What a line knows of the others.
pub(super) struct Start {
    /// From 0.
    number: usize,
    common: Arc<Common>,
}

struct Common {
    count: usize,
    metrics: Option<Metrics>,
    panel_lines: Lines,
    board: ValueBoard,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// How many lines are open.
    open: usize,
    /// All lines end: one has failed, or the end is wished.
    ended: bool,
    /// How the lines are ended.
    ends: Vec<(Arc<AtomicBool>, Stop)>,
    /// Ready lines that wait for those before them, by number.
    ready: Vec<(usize, String)>,
    /// How many were said.
    said: usize,
}

impl Common {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends every line, also one that has not begun.
    fn end(&self) {
        let mut state = self.state();
        state.ended = true;
        state.ends.iter().for_each(end_line);
        self.changed.notify_all();
    }
}

fn end_line((end, stop): &(Arc<AtomicBool>, Stop)) {
    end.store(true, Ordering::SeqCst);
    stop.request();
}

impl Start {
    /// Of the only line.
    #[cfg(test)]
    pub(super) fn alone() -> Self {
        let common = Common {
            count: 1,
            metrics: None,
            panel_lines: Lines::default(),
            board: ValueBoard::default(),
            state: Mutex::default(),
            changed: Condvar::new(),
        };
        Self { number: 0, common: Arc::new(common) }
    }

    /// What this line is called: `line`, where there are several with its number.
    pub(super) fn name(&self) -> String {
        match self.common.count {
            1 => "line".into(),
            _ => format!("line-{}", self.number + 1),
        }
    }

    /// What the devices of all lines show to each other, as this line sees it.
    pub(super) fn board(&self) -> ValueBoard {
        self.common.board.of_line(u16::try_from(self.number + 1).unwrap_or(u16::MAX))
    }

    /// The lines that every panel of the process shows.
    pub(super) fn panel_lines(&self) -> &Lines {
        &self.common.panel_lines
    }

    /// The place of this line among the metrics, if there are any. `link` is what a master opens.
    pub(super) fn line_metrics(&self, link: &str, wake: &Stop) -> Option<LineMetrics> {
        Some(self.common.metrics.as_ref()?.line(self.number + 1, link, wake.clone()))
    }

    /// The same for a bus of CAN.
    pub(super) fn node_metrics(&self, link: &str, wake: &Stop) -> Option<NodeMetrics> {
        Some(self.common.metrics.as_ref()?.can_line(self.number + 1, link, wake.clone()))
    }

    /// These end this line when all end.
    pub(super) fn ends_with(&self, signals: &Signals) {
        let line = (Arc::clone(&signals.end), signals.stop.clone());
        let mut state = self.common.state();
        if state.ended {
            end_line(&line);
        }
        state.ends.push(line);
    }

    /// Waits until every line is open. `false`: all end before that.
    pub(super) fn all_are_open(&self) -> bool {
        let mut state = self.common.state();
        state.open += 1;
        self.common.changed.notify_all();
        while state.open < self.common.count && !state.ended {
            state = self.common.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        !state.ended
    }

    /// Says on stdout that a master can begin, behind the lines before it.
    pub(super) fn announce(&self, ready: &str) {
        let metrics = self.common.metrics.as_ref();
        let metrics = metrics.map(|metrics| format!(" metrics=http://{}{PATH}", metrics.address()));
        let mut state = self.common.state();
        state.ready.push((self.number, format!("{ready}{}", metrics.unwrap_or_default())));
        while let Some(place) = state.ready.iter().position(|(number, _)| *number == state.said) {
            let (_, ready) = state.ready.swap_remove(place);
            state.said += 1;
            let mut stdout = io::stdout().lock();
            if let Err(error) = writeln!(stdout, "{ready}").and_then(|()| stdout.flush()) {
                // Whoever started this may not care; the line is there all the same.
                warn!("cannot say on stdout '{ready}': {error}");
            }
        }
    }
}

/// Ends every line when it is dropped.
struct EndAll<'a>(&'a Common);

impl Drop for EndAll<'_> {
    fn drop(&mut self) {
        self.0.end();
    }
}
