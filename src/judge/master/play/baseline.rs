//! Undisturbed data exchange with every station: what a scenario begins with, and whether it comes back behind it.

use super::patience::{LEAST_WAIT, SLOW_LIMIT};
use super::{Ending, Judge, Phase};
use crate::host::Bus;
use crate::host::link::fault::Faults;
use crate::judge::master::rows::Row;
use crate::judge::master::scenario::Course;
use crate::judge::master::station::{Act, act};
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// Good exchanges in a row with each station: nothing is wrong.
pub(super) const BASELINE: u32 = 8;
/// As many stations as row I06 asks for.
pub(super) const MANY: usize = 32;

/// What was counted of a station.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) exchanges: u32,
    pub(super) start_ups: u32,
    pub(super) polled: u32,
}

impl Judge {
    pub(super) fn come_back(
        &mut self,
        now: Instant,
        scenario: Option<usize>,
        until: Instant,
        revived: bool,
        bus: &mut Bus,
        faults: &mut Faults,
    ) {
        let first = self.reached.is_none();
        let Some(station) = self.missing() else {
            if let Some(scenario) = scenario.and_then(|scenario| self.scenarios.get(scenario)).cloned()
                && !revived
            {
                self.returned(&scenario);
            }
            if first && self.observer.setup.present().count() >= MANY {
                self.observer.findings.held(Row::I06);
            }
            if first {
                self.reached = Some(now);
                self.observer.watching = true;
                self.remember();
                self.measure();
                self.phase = Phase::Watching { until: now + self.watch() };
            } else {
                self.go_on(now, bus, faults);
            }
            return;
        };
        if now < until {
            return;
        }
        let is_under_way = self.is_under_way(now, station);
        if (is_under_way && self.returns_for(now) < SLOW_LIMIT) || self.is_silent(now) {
            self.phase = Phase::Returning { scenario, until: now + LEAST_WAIT, revived };
            return;
        }
        // Whoever hears his own address may wait for his user.
        let waits = |scenario: usize| {
            self.scenarios.get(scenario).is_some_and(|played| played.course() == Some(Course::Double))
        };
        if scenario.is_some_and(waits) {
            return self.go_on(now, bus, faults);
        }
        let after = scenario.and_then(|scenario| self.scenarios.get(scenario)).cloned();
        if let Some(scenario) = after.as_ref().filter(|_| !revived) {
            self.did_not_return(now, scenario, station);
            if self.next > 1 || !scenario.rows.contains(&Row::L09) {
                // Whatever the stations have become, they begin anew.
                let slaves: Vec<_> = self.observer.setup.present().cloned().collect();
                for slave in &slaves {
                    act(Act::PowerOn, slave, bus, now);
                }
                let number = self.scenarios.iter().position(|other| other == scenario);
                return self.begin_return(now, number, self.later_limit(), true);
            }
        }
        if first && !is_under_way {
            self.judge_unreached(station);
        }
        let ending = match after {
            after if self.observer.setup.is_class_2() => Ending::NotRead {
                why: self.observer.why_not_read(),
                after: after.map(|scenario| scenario.name),
            },
            Some(scenario) if self.observer.exchanges(station) > 0 => {
                Ending::Lost { station, after: scenario.name }
            }
            Some(_) | None => Ending::NoExchange { station, why: self.observer.why_no_exchange(station) },
        };
        self.end(ending);
    }

    /// The first station with which data are not exchanged as they should be.
    fn missing(&self) -> Option<Address> {
        let works = |station: &Address| self.observer.streak(*station) >= BASELINE;
        let mut present = self.observer.setup.present().map(|slave| slave.address);
        // Nobody says which of them one of class 2 reads now.
        if self.observer.setup.is_class_2() {
            let first = present.next()?;
            let reads = works(&first) || present.any(|station| works(&station));
            return (!reads).then_some(first);
        }
        present.find(|station| !works(station))
    }

    pub(super) fn others(&self, subject: Address) -> Vec<Address> {
        self.observer
            .setup
            .present()
            .map(|slave| slave.address)
            .filter(|station| *station != subject)
            .collect()
    }

    pub(super) fn counts(&self, station: Address) -> Counts {
        Counts {
            exchanges: self.observer.exchanges(station),
            start_ups: self.observer.start_ups(station),
            polled: self.observer.polled(station),
        }
    }

    pub(super) fn remember(&mut self) {
        let stations: Vec<Address> = self.observer.setup.present().map(|slave| slave.address).collect();
        self.before = stations.into_iter().map(|station| (station.number(), self.counts(station))).collect();
    }
}
