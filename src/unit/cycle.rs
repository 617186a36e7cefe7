//! When the next application cycle runs.

use core::time::Duration;

use crate::time::{Instant, nanos};

/// How often a drive runs unless told otherwise. The manuals state no time.
pub const DEFAULT_APPLICATION_CYCLE: Duration = Duration::from_millis(1);

/// A late unit makes up for at most this much time; a process that slept longer has slept, not travelled.
const MOST_TIME_MADE_UP: Duration = Duration::from_secs(60);

/// The grid of application cycles since a unit was made. While nothing can change there is no next one.
#[derive(Clone, Debug)]
pub struct Cycles {
    length: Duration,
    start: Instant,
    next: Option<Instant>,
}

impl Cycles {
    /// A grid of cycles of this length that starts at `start`; the first is due one length later. A length of 0: there is
    /// no grid, the bus decides when a cycle runs.
    pub fn new(length: Duration, start: Instant) -> Self {
        let mut cycles = Self { length, start, next: None };
        cycles.wake(start);
        cycles
    }

    /// Where the grid starts.
    pub const fn start(&self) -> Instant {
        self.start
    }

    /// Whether there is no grid.
    pub const fn is_manual(&self) -> bool {
        self.length.is_zero()
    }

    /// How much time passes for the drive in one cycle.
    pub const fn step(&self) -> Duration {
        if self.is_manual() { DEFAULT_APPLICATION_CYCLE } else { self.length }
    }

    /// When the next cycle is due; `None` while nothing can change.
    pub const fn next(&self) -> Option<Instant> {
        self.next
    }

    /// Something has changed: the next point of the grid after `now` is due, unless one is due already.
    pub fn wake(&mut self, now: Instant) {
        let length = nanos(self.length);
        if self.next.is_some() || length == 0 {
            return;
        }
        let elapsed = nanos(now.saturating_since(self.start));
        let next = (elapsed / length + 1).saturating_mul(length);
        self.next = Some(self.start.saturating_add(Duration::from_nanos(next)));
    }

    /// The cycle that was due at `due` has run.
    pub const fn ran(&mut self, due: Instant, at_rest: bool) {
        self.next = if at_rest { None } else { Some(due.saturating_add(self.length)) };
    }

    /// Moves a cycle that is overdue beyond all measure up to the time that is made up for.
    pub fn forfeit(&mut self, now: Instant) {
        let overdue = self.next.map(|due| now.saturating_since(due));
        if overdue.is_some_and(|overdue| overdue > MOST_TIME_MADE_UP) {
            self.next = None;
            self.wake(Instant::from_nanos(now.as_nanos().saturating_sub(nanos(MOST_TIME_MADE_UP))));
        }
    }
}
