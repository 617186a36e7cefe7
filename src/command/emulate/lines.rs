//! Several lines in one process, each on a thread of its own: all of them or none.

use core::sync::atomic::{AtomicBool, Ordering};
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use profidrive::host::Stop;
use tracing::{error_span, warn};

use super::{LinePlan, run_line};
use crate::command::Failure;
use crate::command::signals::Signals;

/// Runs all lines until a signal, or until one of them fails.
pub(super) fn run(mut plans: Vec<LinePlan>) -> Result<(), Failure> {
    let common = Arc::new(Common { count: plans.len(), state: Mutex::default(), changed: Condvar::new() });
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
            let end = EndAll(&start);
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

/// What a line knows of the others.
pub(super) struct Start {
    /// From 0.
    number: usize,
    common: Arc<Common>,
}

struct Common {
    count: usize,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// How many lines are open.
    open: usize,
    /// One has failed.
    failed: bool,
    /// How the lines are ended.
    ends: Vec<(Arc<AtomicBool>, Stop)>,
    /// Ready lines that wait for those before them, by number.
    ready: Vec<(usize, String)>,
    /// How many were said.
    said: usize,
}

impl Start {
    fn state(&self) -> MutexGuard<'_, State> {
        self.common.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// These end this line when another one fails.
    pub(super) fn ends_with(&self, signals: &Signals) {
        self.state().ends.push((Arc::clone(&signals.end), signals.stop.clone()));
    }

    /// Waits until every line is open. `false`: one cannot be opened.
    pub(super) fn all_are_open(&self) -> bool {
        let mut state = self.state();
        state.open += 1;
        self.common.changed.notify_all();
        while state.open < self.common.count && !state.failed {
            state = self.common.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        !state.failed
    }

    /// Says on stdout that a master can begin, behind the lines before it.
    pub(super) fn announce(&self, ready: &str) {
        let mut state = self.state();
        state.ready.push((self.number, ready.to_owned()));
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
struct EndAll<'a>(&'a Start);

impl Drop for EndAll<'_> {
    fn drop(&mut self) {
        let mut state = self.0.state();
        state.failed = true;
        for (end, stop) in &state.ends {
            end.store(true, Ordering::SeqCst);
            stop.request();
        }
        self.0.common.changed.notify_all();
    }
}
