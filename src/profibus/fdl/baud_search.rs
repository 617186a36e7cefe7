//! Which rate the line has, found by listening (`dp-v0.md` 8).
//!
//! ```text
//!            an error-free telegram               a DP watchdog runs
//! SEARCH ──────────────────────────▶ CONTROL ──────────────────────────▶ DP_CONTROL
//!   ▲  window over: next rate           │  ▲                                │
//!   └───────────────────────────────────┘  └────────────────────────────────┘
//!        nothing for us all the time            none runs any more: expired or given up
//! ```
//!
//! Pure: it is told what was heard and what time it is, and says which rate to listen at. Whoever owns the line
//! changes its rate; stations at this end send nothing while `BaudSearch::is_searching`. In CONTROL every
//! error-free telegram *to a station at this end* starts the time anew; its end does not touch the DP slave, which
//! keeps its state and outputs (row 26 of `dp-v0.md` 7).

use core::time::Duration;

use super::Rates;
use crate::time::{BaudRate, Instant};

/// How long CONTROL waits for a telegram to a station at this end before the search begins again, as the driver of a
/// common slave ASIC sets it (`dp-v0.md` 8).
pub(crate) const CONTROL_TIME: Duration = Duration::from_millis(2560);

/// The search for the rate of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BaudSearch {
    rates: Rates,
    rate: BaudRate,
    state: State,
    control_time: Duration,
}

/// What is going on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// BAUD_SEARCH: nothing error-free was heard at this rate yet; another one is tried after this time.
    Search { until: Instant },
    /// BAUD_CONTROL: the rate is right as long as somebody speaks to us.
    Control { until: Instant },
    /// DP_CONTROL: the watchdog of the DP slave minds the master, and with it the rate.
    DpControl,
}

/// What a call led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RateChange {
    /// Listen at this rate now.
    Try(BaudRate),
    /// The rate listened at is that of the line.
    Found(BaudRate),
}

impl BaudSearch {
    /// A search among `rates` that begins at `now` at the highest one; among every rate if there is none.
    /// `control_time` is usually [`CONTROL_TIME`].
    pub(crate) fn new(now: Instant, control_time: Duration, rates: Rates) -> Self {
        let rates = if rates == Rates::NONE { Rates::CUSTOMARY } else { rates };
        let rate = highest(rates);
        Self { rates, rate, state: State::Search { until: now.saturating_add(window(rate)) }, control_time }
    }

    /// Somebody takes part who knows these rates too.
    pub(crate) fn add_rates(&mut self, rates: Rates) {
        self.rates = self.rates.union(rates);
    }

    /// The rate to listen at.
    pub(crate) const fn rate(&self) -> BaudRate {
        self.rate
    }

    /// Whether the rate is unknown: stations at this end must not send.
    pub(crate) const fn is_searching(&self) -> bool {
        matches!(self.state, State::Search { .. })
    }

    /// An error-free SD1, SD2 or SD3 telegram ended at `now`; `ours` if it was for a station at this end. Tokens and
    /// SC have no check sequence and count for nothing.
    pub(crate) const fn heard(&mut self, now: Instant, ours: bool) -> Option<RateChange> {
        let control = State::Control { until: now.saturating_add(self.control_time) };
        match self.state {
            State::Search { .. } => {
                self.state = control;
                Some(RateChange::Found(self.rate))
            }
            State::Control { .. } if ours => {
                self.state = control;
                None
            }
            State::Control { .. } | State::DpControl => None,
        }
    }

    /// Whether a DP watchdog minds the master of any station at this end. To be told whenever that may have changed.
    pub(crate) const fn supervise(&mut self, now: Instant, watchdog_runs: bool) {
        match (self.state, watchdog_runs) {
            (State::Control { .. }, true) => self.state = State::DpControl,
            (State::DpControl, false) => {
                self.state = State::Control { until: now.saturating_add(self.control_time) };
            }
            // A slave whose master is minded has been parameterised, so its rate was found.
            (State::Search { .. }, _) | (State::Control { .. }, false) | (State::DpControl, true) => {}
        }
    }

    /// Time has passed. Harmless at any time.
    pub(crate) fn handle_timeout(&mut self, now: Instant) -> Option<RateChange> {
        match self.state {
            State::Search { until } if until <= now => Some(self.listen_at(now, self.next_lower())),
            State::Control { until } if until <= now => Some(self.listen_at(now, highest(self.rates))),
            State::Search { .. } | State::Control { .. } | State::DpControl => None,
        }
    }

    /// The line cannot be set to the rate to listen at: the next lower one is tried at once.
    pub(crate) fn skip(&mut self, now: Instant) -> RateChange {
        self.listen_at(now, self.next_lower())
    }

    /// The next lower rate; below the lowest the highest again.
    fn next_lower(&self) -> BaudRate {
        self.rates.iter().rev().find(|lower| *lower < self.rate).unwrap_or_else(|| highest(self.rates))
    }

    fn listen_at(&mut self, now: Instant, rate: BaudRate) -> RateChange {
        self.rate = rate;
        self.state = State::Search { until: now.saturating_add(window(rate)) };
        RateChange::Try(rate)
    }

    /// When to call [`BaudSearch::handle_timeout`]. Changes with every other call.
    #[must_use]
    pub(crate) const fn poll_timeout(&self) -> Option<Instant> {
        match self.state {
            State::Search { until } | State::Control { until } => Some(until),
            State::DpControl => None,
        }
    }
}

/// How long one rate is listened at: three of the longest telegrams, of which one at least is heard from its first
/// octet on where a master never pauses, and no less than 100 ms for masters that do.
const fn window(rate: BaudRate) -> Duration {
    const LEAST: Duration = Duration::from_millis(100);
    let three_telegrams = rate.octet_times(3 * 255);
    if three_telegrams.as_nanos() > LEAST.as_nanos() { three_telegrams } else { LEAST }
}

fn highest(rates: Rates) -> BaudRate {
    rates.iter().next_back().unwrap_or(BaudRate::K12000)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn searched(search: &mut BaudSearch, windows: usize) -> std::vec::Vec<BaudRate> {
        let mut tried = std::vec![];
        for _ in 0..windows {
            let due = search.poll_timeout().unwrap();
            assert_eq!(search.handle_timeout(Instant::from_nanos(due.as_nanos() - 1)), None);
            match search.handle_timeout(due) {
                Some(RateChange::Try(rate)) => tried.push(rate),
                other => panic!("{other:?}"),
            }
        }
        tried
    }

    #[test]
    fn the_search_begins_at_the_highest_rate_steps_down_and_wraps() {
        let mut search = BaudSearch::new(Instant::ZERO, CONTROL_TIME, Rates::CUSTOMARY);
        assert_eq!(search.rate(), BaudRate::K12000);
        let mut expected: std::vec::Vec<_> = Rates::CUSTOMARY.iter().rev().skip(1).collect();
        expected.extend([BaudRate::K12000, BaudRate::K6000]);
        assert_eq!(searched(&mut search, 11), expected);
        assert!(search.is_searching());
    }

    #[test]
    fn rates_that_nobody_knows_are_not_tried() {
        let rates = Rates::NONE.with(BaudRate::K1500, 150).with(BaudRate::K19_2, 60);
        let mut search = BaudSearch::new(Instant::ZERO, CONTROL_TIME, rates);
        assert_eq!(search.rate(), BaudRate::K1500);
        assert_eq!(searched(&mut search, 3), [BaudRate::K19_2, BaudRate::K1500, BaudRate::K19_2]);
        search.add_rates(Rates::NONE.with(BaudRate::K500, 100));
        assert_eq!(searched(&mut search, 2), [BaudRate::K1500, BaudRate::K500]);
        assert_eq!(BaudSearch::new(Instant::ZERO, CONTROL_TIME, Rates::NONE).rate(), BaudRate::K12000);
    }

    #[test]
    fn a_whole_sweep_takes_three_seconds_at_most() {
        let total: Duration = BaudRate::ALL.into_iter().map(window).sum();
        assert!(total < Duration::from_secs(3), "{total:?}");
    }

    #[test]
    fn a_rate_that_cannot_be_set_is_skipped_at_once() {
        let mut search = BaudSearch::new(Instant::ZERO, CONTROL_TIME, Rates::CUSTOMARY);
        assert_eq!(search.skip(Instant::ZERO), RateChange::Try(BaudRate::K6000));
        assert_eq!(search.skip(Instant::ZERO), RateChange::Try(BaudRate::K3000));
        assert_eq!(search.poll_timeout(), Some(Instant::from_millis(100)));
    }

    #[test]
    fn the_first_telegram_ends_the_search_whoever_it_is_for() {
        let mut search = BaudSearch::new(Instant::ZERO, CONTROL_TIME, Rates::CUSTOMARY);
        searched(&mut search, 4);
        let now = Instant::from_millis(450);
        assert_eq!(search.heard(now, false), Some(RateChange::Found(BaudRate::K500)));
        assert!(!search.is_searching());
        assert_eq!(search.poll_timeout(), Some(now.saturating_add(CONTROL_TIME)));
    }

    #[test]
    fn control_lasts_as_long_as_somebody_speaks_to_us() {
        let mut search = BaudSearch::new(Instant::ZERO, CONTROL_TIME, Rates::CUSTOMARY);
        search.heard(Instant::ZERO, true);
        search.heard(Instant::from_millis(2000), true);
        search.heard(Instant::from_millis(4000), false);
        assert_eq!(search.handle_timeout(Instant::from_millis(4559)), None);
        let change = search.handle_timeout(Instant::from_millis(4560));
        assert_eq!(change, Some(RateChange::Try(BaudRate::K12000)), "the search begins at the top again");
        assert!(search.is_searching());
    }

    #[test]
    fn a_dp_watchdog_replaces_control_until_it_expires() {
        let mut search = BaudSearch::new(Instant::ZERO, CONTROL_TIME, Rates::CUSTOMARY);
        search.supervise(Instant::ZERO, true);
        assert!(search.is_searching(), "nobody parameterises a slave that does not answer");
        search.heard(Instant::ZERO, true);
        search.supervise(Instant::from_millis(1), true);
        search.supervise(Instant::from_millis(2), true);
        assert_eq!(search.poll_timeout(), None, "650 s of watchdog are not cut short");
        assert_eq!(search.handle_timeout(Instant::from_millis(600_000)), None);
        search.supervise(Instant::from_millis(650_250), false);
        search.supervise(Instant::from_millis(651_000), false);
        assert_eq!(search.poll_timeout(), Some(Instant::from_millis(652_810)));
    }
}
