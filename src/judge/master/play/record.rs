//! What was played how long, and how long the rest takes.

use crate::map::Map;
use core::time::Duration;
use std::collections::BTreeSet;

use super::baseline::BASELINE;
use super::patience::SLOW_LIMIT;
use super::{Judge, Progress};
use crate::judge::master::rows::Row;
use crate::judge::master::scenario::{Scenario, Step};
use crate::judge::master::setup::Slave;
use crate::time::Instant;

/// The whole judgement, and that of one row, takes so long at most; and so many cycles of the master more.
const TOTAL: Duration = Duration::from_secs(180);
const ONE_ROW: Duration = Duration::from_secs(50);
const MORE_CYCLES: u32 = 5000;
/// A scenario takes so many cycles beside its steps, and so long at least, until data exchange has come back.
const RETURN: u32 = 14;
const LEAST_RETURN: Duration = Duration::from_millis(150);
/// The longest cycle that is waited for.
const LONGEST_CYCLE: Duration = Duration::from_secs(2);

/// Times of a judgement.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// The last time that is known.
    now: Option<Instant>,
    /// The scenario that is played, and since when.
    playing: Option<(usize, Instant)>,
    /// How long scenarios of a row were played.
    spent: Map<Row, Duration>,
    /// How long a cycle of the master takes, once data are exchanged.
    cycle: Duration,
}

impl Record {
    pub(super) const fn at(&mut self, now: Instant) {
        self.now = Some(now);
    }

    pub(super) fn spent(&self, row: Row) -> Duration {
        self.spent.get(&row).copied().unwrap_or_default()
    }

    /// The whole of it.
    pub(super) fn took(&self, origin: Instant) -> Duration {
        self.now.map_or(Duration::ZERO, |now| now.saturating_since(origin))
    }
}

impl Judge {
    /// How long a cycle of the master takes; zero until it is known.
    pub(super) const fn cycle(&self) -> Duration {
        self.record.cycle
    }

    /// Measures the cycle when every station has just exchanged data without disturbance: that of the one that is asked least.
    pub(super) fn measure(&mut self) {
        if self.record.cycle.is_zero() {
            let stations = self.observer.setup.present();
            let newest = |slave: &Slave| self.observer.newest_interval(slave.address, BASELINE - 1);
            let longest = stations.filter_map(newest).max();
            self.record.cycle = longest.unwrap_or_default().min(LONGEST_CYCLE);
        }
    }

    /// How long the judgement may take.
    pub(super) fn limit(&self) -> Duration {
        let own = if self.wanted.len() == 1 { ONE_ROW } else { TOTAL };
        let slow = if self.reached.is_none() { SLOW_LIMIT } else { Duration::ZERO };
        self.limit.unwrap_or_else(|| own + slow + self.cycle() * MORE_CYCLES + self.soak_time())
    }

    /// How long it may still take.
    pub(super) fn time_left(&self, now: Instant) -> Duration {
        let begun = self.started.or(self.begun).unwrap_or(now);
        self.limit().saturating_sub(now.saturating_since(begun))
    }

    /// How long a step lasts with this master.
    pub(super) fn time(&self, step: &Step) -> Duration {
        step.time(&self.observer.setup, self.cycle())
    }

    /// How long a scenario takes, about.
    pub(super) fn time_of(&self, scenario: &Scenario) -> Duration {
        let steps = scenario.steps.iter().filter(|step| !step.until_injected);
        steps.map(|step| self.time(step)).sum::<Duration>() + LEAST_RETURN.max(self.cycle() * RETURN)
    }

    /// The scenario that was played is over.
    pub(super) fn end_record(&mut self) {
        let (Some((scenario, since)), Some(now)) = (self.record.playing.take(), self.record.now) else {
            return;
        };
        let Some(played) = self.scenarios.get(scenario) else { return };
        let time = now.saturating_since(since);
        let rows: BTreeSet<Row> = played.rows.iter().chain(&played.returns).copied().collect();
        for row in rows {
            *self.record.spent.or_default(row) += time;
        }
    }

    /// A scenario begins.
    pub(super) fn tell(&mut self, scenario: usize) {
        self.end_record();
        self.record.playing = self.record.now.map(|now| (scenario, now));
        let repeated = self.again.count + self.soak.as_ref().map_or(0, |soak| soak.repeated);
        // What is repeated comes behind all of them.
        let rest = if repeated == 0 { self.scenarios.len() } else { 1 };
        let rest = self.scenarios.iter().skip(scenario).take(rest);
        let soak = self.soak.as_ref().map_or(Duration::ZERO, |soak| soak.left(self.record.now));
        let rest = rest.map(|scenario| self.time_of(scenario)).sum::<Duration>();
        let played = if repeated == 0 { scenario } else { self.scenarios.len() };
        let left = rest + self.time_again(played) + soak;
        let name = self.scenarios.get(scenario).map(|played| played.name.clone());
        self.observer.findings.play(name);
        if let Some(played) = self.scenarios.get(scenario) {
            let (of, name) = (self.scenarios.len(), played.name.clone());
            let number = if repeated == 0 { scenario + 1 } else { of + repeated };
            self.progress = Some(Progress { number, of, name, left });
        }
    }
}
