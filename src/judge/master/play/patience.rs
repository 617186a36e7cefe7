//! How long the judge waits: for data exchange, for its return, for what nothing provokes.

use core::time::Duration;

use super::{Judge, Phase, SILENCE};
use crate::judge::master::rows::Row;
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// How long a master may take until it exchanges data with every station at first.
pub(super) const FIRST_LIMIT: Duration = Duration::from_secs(15);
/// So many requests to a station are enough for its start-up, and a slow master gets so much time for them.
const ENOUGH_ASKS: u32 = 60;
pub(super) const SLOW_LIMIT: Duration = Duration::from_secs(60);
/// And is looked at again so often.
pub(super) const LEAST_WAIT: Duration = Duration::from_secs(1);
/// How long it may take to come back.
const LIMIT: Duration = Duration::from_secs(8);
/// How long nothing is disturbed, and so many cycles at least: M-O01 needs three seconds.
const WATCH: Duration = Duration::from_millis(3500);
const WATCH_CYCLES: u32 = 60;
/// And so many cycles at least: a start-up, the next one if something was wrong with it, and good exchanges.
const RETURN_CYCLES: u32 = 50;
/// A master that says nothing for so long may be gone.
const QUIET: Duration = Duration::from_secs(4);

impl Judge {
    /// How long nothing is disturbed: rows that scenarios are for are seen later.
    pub(super) fn watch(&self) -> Duration {
        // Which mode a loss leads to is seen only if OPERATE was announced before.
        let later = |row: &Row| self.is_provoked(*row) && !matches!(row, Row::O07 | Row::O08);
        if self.wanted.iter().all(later) { Duration::ZERO } else { WATCH.max(self.cycle() * WATCH_CYCLES) }
    }

    /// The first time takes longer: the master begins.
    pub(super) fn return_limit(&self, scenario: usize) -> Duration {
        if scenario == 0 && self.reached.is_none() { FIRST_LIMIT } else { self.later_limit() }
    }

    /// How long data exchange may take to come back.
    pub(super) fn later_limit(&self) -> Duration {
        LIMIT.max(self.cycle() * RETURN_CYCLES)
    }

    /// Whether the master may have ended: [`SILENCE`] will tell.
    pub(super) fn is_silent(&self, now: Instant) -> bool {
        let heard = self.observer.last_heard();
        heard.is_some_and(|heard| (QUIET..SILENCE).contains(&now.saturating_since(heard)))
    }

    /// From now on data exchange with every station must come back.
    pub(super) fn begin_return(
        &mut self,
        now: Instant,
        scenario: Option<usize>,
        limit: Duration,
        revived: bool,
    ) {
        self.observer.begin_streaks();
        self.returning = Some(now);
        self.phase = Phase::Returning { scenario, until: now + limit, revived };
    }

    /// How long data exchange has been on its way back.
    pub(super) fn returns_for(&self, now: Instant) -> Duration {
        self.returning.map_or(Duration::ZERO, |since| now.saturating_since(since))
    }

    /// Whether the master has asked a station so seldom that its start-up may still be under way: its cycle, or the machine,
    /// may have become slower than it was when it was measured.
    pub(super) fn is_under_way(&self, now: Instant, station: Address) -> bool {
        let asked = self.observer.last_asked(station).map(|asked| now.saturating_since(asked));
        (1..ENOUGH_ASKS).contains(&self.observer.asks(station)) && asked.is_some_and(|asked| asked < LIMIT)
    }
}
