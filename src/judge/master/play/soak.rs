//! A soak: when everything was tried once, scenarios are repeated at random.

use core::time::Duration;

use super::{Judge, Phase};
use crate::chance::Random;
use crate::host::Bus;
use crate::host::link::fault::Faults;
use crate::time::Instant;

/// How long scenarios are repeated, and which comes next.
#[derive(Debug)]
pub(super) struct Soak {
    lasts: Duration,
    seed: u64,
    random: Random,
    /// Known once everything was tried.
    until: Option<Instant>,
    /// Scenarios that were repeated.
    pub(super) repeated: usize,
}

impl Soak {
    const fn new(lasts: Duration, seed: u64) -> Self {
        Self { lasts, seed, random: Random::new(seed), until: None, repeated: 0 }
    }

    const fn lasts(&self) -> Duration {
        self.lasts
    }

    /// How long it still takes.
    pub(super) fn left(&self, now: Option<Instant>) -> Duration {
        match (self.until, now) {
            (Some(until), Some(now)) => until.saturating_since(now),
            (None, _) | (_, None) => self.lasts,
        }
    }
}

impl Judge {
    /// When everything was tried once, scenarios are repeated at random for so long. The same seed repeats the same ones.
    #[must_use]
    pub(crate) fn soaking(mut self, lasts: Duration, seed: u64) -> Self {
        self.soak = Some(Soak::new(lasts, seed));
        self
    }

    pub(in crate::judge) fn soak_time(&self) -> Duration {
        self.soak.as_ref().map_or(Duration::ZERO, Soak::lasts)
    }

    /// Everything was tried: the next scenario of the soak, or nothing is disturbed if there is none. `false`: it is over.
    pub(super) fn soak_on(&mut self, now: Instant, bus: &mut Bus, faults: &mut Faults) -> bool {
        let scenarios = self.scenarios.iter().enumerate().filter(|(_, scenario)| scenario.is_repeatable());
        let again: Vec<usize> = scenarios.map(|(number, _)| number).collect();
        let Some(soak) = &mut self.soak else { return false };
        let until = *soak.until.get_or_insert(now + soak.lasts);
        if now >= until {
            return false;
        }
        self.observer.findings.soak();
        let drawn = soak.random.below(again.len());
        match again.get(drawn) {
            Some(scenario) => {
                soak.repeated += 1;
                self.begin_scenario(now, *scenario, bus, faults);
            }
            None => {
                self.remember();
                self.observer.watching = true;
                self.phase = Phase::Watching { until };
            }
        }
        true
    }

    /// What was asked for, as options of the command.
    pub(super) fn soak_words(&self) -> Vec<(&'static str, String)> {
        let Some(soak) = &self.soak else { return Vec::new() };
        vec![("soak", format!("{}s", soak.lasts.as_secs())), ("seed", soak.seed.to_string())]
    }
}
