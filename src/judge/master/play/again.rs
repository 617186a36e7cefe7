//! What comes when every scenario was played once: again those whose rows are still open, and time without disturbance.

use crate::map::Map;
use core::time::Duration;
use std::collections::BTreeSet;

use super::{Judge, Phase, Progress};
use crate::judge::master::rows::Row;
use crate::judge::master::scenario::Scenario;
use crate::judge::master::setup::Slave;
use crate::time::Instant;

/// Scenarios are played so often more at most for a row of which something was seen that is no proof yet.
const FOR_DOUBT: u32 = 4;
/// And for one that nothing was seen of.
const FOR_NOTHING: u32 = 1;
/// Scenarios that are played again for such a row are not longer than this, unless few rows are wanted.
const SHORT: Duration = Duration::from_secs(2);
const FEW_ROWS: usize = 12;
/// So great a share of the time is played again with most masters.
const USUAL_SHARE: f64 = 0.1;
/// Between the seeds of a fault and of its repetition.
const RESEED: u64 = 1000;
/// Rows that no scenario is for are watched for so many cycles at least: what comes seldom comes three times.
const LEAST_CYCLES: u32 = 320;
/// And those of watchdog times for so many of these.
const WATCHDOGS: u32 = 8;

/// What was played again.
#[derive(Debug, Default)]
pub(super) struct Again {
    scenarios: Map<usize, u32>,
    rows: Map<Row, u32>,
    /// All of them.
    pub(super) count: usize,
    /// Watchdogs were watched without disturbance.
    watched: bool,
    /// Nothing is played again any more.
    pub(super) is_over: bool,
}

impl Judge {
    /// The scenario that is played again now.
    pub(super) fn again(&mut self, now: Instant) -> Option<usize> {
        if self.again.is_over {
            return None;
        }
        let left = self.time_left(now);
        let times = |number: &usize| self.again.scenarios.get(number).copied().unwrap_or_default();
        let scenarios = self.scenarios.iter().enumerate();
        let worth = scenarios.filter(|(_, scenario)| {
            let time = self.time_of(scenario);
            scenario.is_repeatable()
                && time * 2 < left
                && scenario.all_rows().any(|row| self.is_worth(row, time))
        });
        let number =
            worth.map(|(number, scenario)| (times(&number), self.time_of(scenario), number)).min()?.2;
        let scenario = self.scenarios.get_mut(number)?;
        scenario.reseed();
        let rows: BTreeSet<Row> = scenario.all_rows().collect();
        *self.again.scenarios.or_default(number) += 1;
        for row in rows {
            *self.again.rows.or_default(row) += 1;
        }
        self.again.count += 1;
        Some(number)
    }

    /// How long scenarios that will be played again take, about, when so many were played: those whose rows are open though no
    /// later one is for them, and as great a share of the others.
    pub(super) fn time_again(&self, played: usize) -> Duration {
        let (before, behind) = self.scenarios.split_at_checked(played).unwrap_or((&self.scenarios, &[]));
        let later = |row: Row| behind.iter().any(|scenario| scenario.all_rows().any(|other| other == row));
        let again = before.iter().filter(|scenario| {
            let time = self.time_of(scenario);
            scenario.is_repeatable() && scenario.all_rows().any(|row| !later(row) && self.is_worth(row, time))
        });
        let sum = |scenarios: &mut dyn Iterator<Item = &Scenario>| {
            scenarios.map(|scenario| self.time_of(scenario)).sum::<Duration>()
        };
        let (again, all) = (sum(&mut again.into_iter()), sum(&mut before.iter()));
        let share = if all.is_zero() { USUAL_SHARE } else { again.as_secs_f64() / all.as_secs_f64() };
        again + sum(&mut behind.iter()).mul_f64(share.min(1.0))
    }

    /// Whether a scenario of this time is played again for a row.
    fn is_worth(&self, row: Row, time: Duration) -> bool {
        let findings = &self.observer.findings;
        let times = self.again.rows.get(&row).copied().unwrap_or_default();
        // The more errors, the better; among many rows there is no time for more of them.
        if row == Row::E17 && self.is_one_of_few(row) {
            return times < FOR_DOUBT;
        }
        if !self.wanted.contains(&row) || !findings.is_open(row) || self.is_out_of_reach(row) {
            return false;
        }
        if findings.is_doubtful(row) {
            times < FOR_DOUBT
        } else {
            times < FOR_NOTHING && (time <= SHORT || self.is_one_of_few(row))
        }
    }

    /// Until when nothing is disturbed at the end; `None`: it was long enough.
    pub(super) fn watch_on(&mut self, now: Instant) -> Option<Phase> {
        let begun = self.reached.filter(|_| !self.again.is_over)?;
        let mut until = begun;
        if self.wanted.iter().any(|row| !self.is_provoked(*row)) {
            until = begun + self.cycle() * LEAST_CYCLES;
        }
        let watchdogs = [Row::T08, Row::I07].into_iter().any(|row| self.is_one_of_few(row));
        if watchdogs && !core::mem::replace(&mut self.again.watched, true) {
            let watchdog = self.observer.setup.longest_watchdog().unwrap_or_default();
            until = now + self.cycle() * LEAST_CYCLES + watchdog * WATCHDOGS;
        }
        if self.wanted.contains(&Row::O01) {
            until = until.max(self.observer.operate_due().map_or(until, |due| due + self.cycle() * 2));
        }
        let until = until.min(now + self.time_left(now));
        if until <= now {
            return None;
        }
        self.end_record();
        self.observer.findings.play(None);
        let (of, left) = (self.scenarios.len(), until.saturating_since(now));
        let number = of + self.again.count + 1;
        self.progress = Some(Progress { number, of, name: "nothing is disturbed".into(), left });
        self.remember();
        self.observer.watching = true;
        Some(Phase::Watching { until })
    }

    /// Whether few rows are wanted, and this is one of them: it gets more time.
    fn is_one_of_few(&self, row: Row) -> bool {
        self.wanted.len() <= FEW_ROWS && self.wanted.contains(&row)
    }

    /// Whether a scenario is for a row. With another master in the ring the GAP is only a part of it.
    pub(super) fn is_provoked(&self, row: Row) -> bool {
        !matches!(row, Row::K02 | Row::K04)
            && self
                .scenarios
                .iter()
                .chain(&self.last)
                .any(|scenario| scenario.all_rows().any(|other| other == row))
    }

    /// Rows that need what is not there, however often their scenarios are played.
    fn is_out_of_reach(&self, row: Row) -> bool {
        let setup = &self.observer.setup;
        let alone = setup.present().count() < 2;
        let most_there = setup.present().count() * 2 > setup.stations.len();
        let inputs = |slave: &Slave| slave.lengths().is_none_or(|lengths| lengths.inputs > 0);
        (alone && matches!(row, Row::C08 | Row::C10 | Row::C11 | Row::L04 | Row::I02 | Row::I05))
            || (row == Row::I03 && !setup.stations.iter().any(|slave| slave.absent))
            || (row == Row::I07 && most_there)
            || (row == Row::O07 && setup.auto_clear.is_none())
            || (row == Row::O08 && setup.auto_clear.is_some())
            || (row == Row::D11 && setup.present().all(inputs))
    }
}

impl Scenario {
    /// The rows it gives an occasion to, and those of coming back.
    pub(super) fn all_rows(&self) -> impl Iterator<Item = Row> {
        self.rows.iter().chain(&self.returns).copied()
    }

    /// What is at random comes at other times than before.
    fn reseed(&mut self) {
        for fault in self.steps.iter_mut().flat_map(|step| &mut step.faults) {
            let Some((kind, seed)) = fault.rsplit_once(",seed=") else { continue };
            if let Ok(seed) = seed.parse::<u64>() {
                *fault = format!("{kind},seed={}", seed.wrapping_add(RESEED));
            }
        }
    }

    /// A station joins late only once, and what the master is asked for has its order.
    pub(super) fn is_repeatable(&self) -> bool {
        !self.rows.contains(&Row::L09)
            && self.steps.iter().all(|step| step.ask.is_none() && step.second.is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::master::setup::Setup;
    use crate::profibus::fdl::Address;

    #[test]
    fn what_is_played_again_is_in_the_forecast() {
        let slave = |number| Slave::new(Address::from_octet(number), 0x1234, vec![0x23, 0x13]);
        let setup = Setup { stations: vec![slave(5), slave(6)], ..Setup::default() };
        let mut judge = Judge::new(setup, &[Row::C03, Row::E01]);
        let all: Duration = judge.scenarios.iter().map(|scenario| judge.time_of(scenario)).sum();
        assert_eq!(judge.time_again(0), all.mul_f64(USUAL_SHARE));
        // Every row is still open, then one of them.
        let of_both = judge.time_again(judge.scenarios.len());
        assert_eq!(of_both, all);
        judge.observer.findings.held(Row::C03);
        let of_one = judge.time_again(judge.scenarios.len());
        assert!(of_one > Duration::ZERO && of_one < of_both, "{of_one:?} of {of_both:?}");
        judge.observer.findings.held(Row::E01);
        judge.observer.findings.held(Row::C12);
        assert_eq!(judge.time_again(judge.scenarios.len()), Duration::ZERO);
    }
}
