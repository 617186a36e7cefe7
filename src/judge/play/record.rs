//! What was played how long, and how long the rest takes.

use core::time::Duration;
use std::collections::{BTreeMap, BTreeSet};

use super::{Judge, Progress};
use crate::judge::rows::Row;
use crate::judge::scenario::Scenario;
use crate::time::Instant;

/// A scenario takes so long beside its steps, until data exchange has come back.
const RETURN: Duration = Duration::from_millis(600);

/// Times of a judgement.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// The last time that is known.
    now: Option<Instant>,
    /// The scenario that is played, and since when.
    playing: Option<(usize, Instant)>,
    /// How long scenarios of a row were played.
    spent: BTreeMap<Row, Duration>,
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
    /// The scenario that was played is over.
    pub(super) fn end_record(&mut self) {
        let (Some((scenario, since)), Some(now)) = (self.record.playing.take(), self.record.now) else {
            return;
        };
        let Some(played) = self.scenarios.get(scenario) else { return };
        let time = now.saturating_since(since);
        let rows: BTreeSet<Row> = played.rows.iter().chain(&played.returns).copied().collect();
        for row in rows {
            *self.record.spent.entry(row).or_default() += time;
        }
    }

    /// A scenario begins.
    pub(super) fn tell(&mut self, scenario: usize) {
        self.end_record();
        self.record.playing = self.record.now.map(|now| (scenario, now));
        let left = self.scenarios.iter().skip(scenario).map(time).sum();
        let name = self.scenarios.get(scenario).map(|played| played.name.clone());
        self.observer.findings.play(name);
        if let Some(played) = self.scenarios.get(scenario) {
            let (number, of, name) = (scenario + 1, self.scenarios.len(), played.name.clone());
            self.progress = Some(Progress { number, of, name, left });
        }
    }
}

/// How long a scenario takes, about.
fn time(scenario: &Scenario) -> Duration {
    let steps = scenario.steps.iter().filter(|step| !step.until_injected);
    steps.map(|step| step.lasts).sum::<Duration>() + RETURN
}
