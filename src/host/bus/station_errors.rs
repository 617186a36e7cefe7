//! Counters of the errors of a station, by kind of error.

use crate::devices::StationEvent;
use crate::face::ErrorKind;

/// How often which error happened at a station, beside what [`StationCounters`](crate::profibus::fdl::StationCounters) have: numbers
/// that only grow. They begin at 0 when the station is connected, and a power cycle leaves them as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StationErrors {
    counts: [u64; ErrorKind::ALL.len()],
}

impl StationErrors {
    /// How often this happened.
    pub(crate) fn of(&self, kind: ErrorKind) -> u64 {
        self.counts.get(kind as usize).copied().unwrap_or_default()
    }

    /// Counts what a station tells, if it is an error.
    pub(super) fn count(&mut self, event: &StationEvent) {
        if let Some(count) = event.error().and_then(|kind| self.counts.get_mut(kind as usize)) {
            *count = count.saturating_add(1);
        }
    }
}
