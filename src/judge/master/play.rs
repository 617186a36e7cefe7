//! The run: scenarios one after the other, with undisturbed data exchange between them. Sans-I/O.
//!
//! ```text
//! Waiting ─▶ (the station that joins late) ─▶ Returning ─▶ Watching ─▶ Playing ─▶ Returning ─▶ Playing … ─▶ Over
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | here | [`Judge`]: what is played when |
//! | `steps` | a scenario, step by step |
//! | `baseline` | undisturbed data exchange, and whether it comes back |
//! | `outcome` | what a scenario has shown, and why a row is not judged |
//! | `ending` | [`Ending`] |
//! | `operator` | who operates the master is asked for what a scenario needs |
//! | `patience` | how long it waits |
//! | `record` | what was played how long, and how long the rest takes |
//! | `second` | a second master on the line |
//! | `again` | scenarios once more, for rows that are still open |
//! | `soak` | scenarios repeated at random |

use crate::map::Map;
use core::time::Duration;

use super::observer::{Observer, Sight};
use super::rows::Row;
use super::scenario::{Scenario, acyclic, asking, built_in, double, joining, reading, ring};
use super::second::Second;
use super::setup::Setup;
use super::station::connect;
use super::{Judgement, Report};
use crate::host::Bus;
use crate::host::link::fault::Faults;
use crate::judge::Progress;
use crate::judge::moment::Moment;
use crate::profibus::fdl::Address;
use crate::time::Instant;

mod again;
mod baseline;
mod ending;
mod operator;
mod outcome;
mod patience;
mod record;
mod second;
mod soak;
mod steps;

use again::Again;
use baseline::Counts;
pub use ending::Ending;
use patience::FIRST_LIMIT;
use record::Record;
use soak::Soak;

/// A master that says nothing for so long is gone.
const SILENCE: Duration = Duration::from_secs(10);
/// Octets without a telegram among them: another rate, or no master.
const NOISE: usize = 8192;
/// So many telegrams, and it is a master.
const LEAST_TELEGRAMS: u64 = 2;

/// The judge of one master.
#[derive(Debug)]
pub struct Judge {
    observer: Observer,
    wanted: Vec<Row>,
    scenarios: Vec<Scenario>,
    next: usize,
    /// What is played when everything else was.
    last: Option<Scenario>,
    phase: Phase,
    /// The first telegram of the master.
    started: Option<Instant>,
    begun: Option<Instant>,
    /// Data are exchanged with every station since then.
    reached: Option<Instant>,
    /// Data exchange is expected to come back since then.
    returning: Option<Instant>,
    ending: Option<Ending>,
    record: Record,
    progress: Option<Progress>,
    /// The faults of the step that is played.
    faults: Vec<u32>,
    /// What they have done in the scenario.
    injected: u32,
    /// Exchanges with each station when the scenario began.
    before: Map<u8, Counts>,
    /// How long the whole judgement may take, where the user says it.
    limit: Option<Duration>,
    again: Again,
    soak: Option<Soak>,
    /// The first breach ends it.
    hasty: bool,
    /// Somebody operates the master.
    operated: bool,
    /// What the master is to be asked for, to be fetched.
    ask: Option<String>,
    /// An action is under way.
    asking: bool,
    /// When requests of a master that was stopped begin to count.
    stopped: Option<Instant>,
    /// The second master, and its address or that of the last one.
    second: Option<Second>,
    /// It has read a slave in this scenario.
    has_read: bool,
    second_at: Option<Address>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing was heard yet.
    Waiting,
    Watching {
        until: Instant,
    },
    Playing {
        scenario: usize,
        step: usize,
        until: Instant,
    },
    /// Data exchange with every station must come back.
    Returning {
        /// Behind which scenario.
        scenario: Option<usize>,
        until: Instant,
        /// Every station was switched off and on.
        revived: bool,
    },
    Over,
}

impl Judge {
    /// A judge of these rows, live.
    pub fn new(setup: Setup, wanted: &[Row]) -> Self {
        Self::seeing(setup, wanted, Sight::Untimed)
    }

    pub(super) fn seeing(setup: Setup, wanted: &[Row], sight: Sight) -> Self {
        let mut scenarios = if setup.is_class_2() { reading(&setup) } else { built_in(&setup) };
        scenarios.extend(acyclic(&setup));
        scenarios.extend(ring());
        scenarios.retain(|scenario| scenario.is_for(wanted));
        let mut observer = Observer::new(setup, sight);
        let scenarios = playable(scenarios, &mut observer);
        let last =
            Some(double()).filter(|last| last.is_for(wanted) && last.obstacle(&observer.setup).is_none());
        Self {
            observer,
            wanted: wanted.to_vec(),
            scenarios,
            next: 0,
            last,
            phase: Phase::Waiting,
            started: None,
            begun: None,
            reached: None,
            returning: None,
            ending: None,
            record: Record::default(),
            progress: None,
            faults: Vec::new(),
            injected: 0,
            before: Map::new(),
            limit: None,
            again: Again::default(),
            soak: None,
            hasty: false,
            operated: false,
            ask: None,
            asking: false,
            stopped: None,
            second: None,
            has_read: false,
            second_at: None,
        }
    }

    /// Somebody operates the master: who runs the line asks that person.
    #[must_use]
    pub fn operated(mut self) -> Self {
        let mut scenarios = asking(&self.observer.setup);
        // The ring begins before the master may claim the token.
        scenarios.extend(matches!(self.observer.sight(), Sight::Exact(_)).then(joining));
        scenarios.retain(|scenario| scenario.rows.iter().any(|row| self.wanted.contains(row)));
        self.scenarios.extend(playable(scenarios, &mut self.observer));
        self.operated = true;
        self
    }

    /// The whole judgement takes so long at most.
    #[must_use]
    pub const fn within(mut self, limit: Duration) -> Self {
        self.limit = Some(limit);
        self
    }

    /// It ends with the first row that is broken, by a failure or a warning.
    #[must_use]
    pub(crate) const fn until_breach(mut self) -> Self {
        self.hasty = true;
        self
    }

    /// More scenarios, behind those of the judge itself.
    pub fn add(&mut self, scenarios: impl IntoIterator<Item = Scenario>) {
        let wanted = |scenario: &Scenario| scenario.is_for(&self.wanted);
        let playable: Vec<Scenario> = scenarios
            .into_iter()
            .filter(wanted)
            .filter(|scenario| scenario.obstacle(&self.observer.setup).is_none())
            .collect();
        self.scenarios.extend(playable);
    }

    /// Takes what was sent on the line.
    pub fn hear(&mut self, moment: Moment) {
        let heard = self.second.is_some().then(|| moment.clone());
        self.observer.take(moment);
        if let Some(heard) = heard {
            self.second_hears(&heard);
        }
    }

    /// The judge could not look at the line for a while: what happened meanwhile proves less.
    pub fn paused(&mut self) {
        self.observer.paused();
        if let Some(second) = &mut self.second {
            second.paused();
        }
    }

    /// Somebody stops the judgement.
    pub fn stop(&mut self) {
        self.end(Ending::Stopped);
    }

    /// Whether it is over, and how it ended.
    pub const fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    /// What is tried now, once.
    #[must_use]
    pub(crate) fn poll_progress(&mut self) -> Option<Progress> {
        self.progress.take()
    }

    /// Whether a reply is held back now: who runs the line looks often.
    pub(crate) const fn is_waiting(&self) -> bool {
        self.observer.held_back
    }

    /// When to call [`Judge::step`] although nothing was heard.
    pub fn poll_timeout(&self) -> Option<Instant> {
        let phase = match self.phase {
            Phase::Waiting => self.begun.map(|begun| begun + SILENCE),
            Phase::Watching { until } | Phase::Playing { until, .. } | Phase::Returning { until, .. } => {
                Some(until)
            }
            Phase::Over => None,
        };
        Instant::first_of(phase, self.observer.last_heard().map(|heard| heard + SILENCE))
    }

    /// Connects the stations and begins to wait for a master.
    pub fn begin(&mut self, now: Instant, bus: &mut Bus, faults: &mut Faults) {
        self.begun = Some(now);
        connect(&self.observer.setup, bus);
        // The station that joins late is silent from the beginning.
        if self.scenarios.first().is_some_and(|scenario| scenario.rows.contains(&Row::L09)) {
            self.inject(now, 0, 0, faults);
        }
    }

    /// Does what is to be done now: call it after everything heard, and at [`Judge::poll_timeout`].
    pub fn step(&mut self, now: Instant, bus: &mut Bus, faults: &mut Faults) {
        if self.ending.is_some() {
            return;
        }
        self.record.at(now);
        if self.hasty && self.observer.findings.take_change() && self.has_failed() {
            return self.end(Ending::Breach);
        }
        if self.observer.noise_octets() > NOISE {
            return self.end(if self.is_master_known() { Ending::Flood } else { self.noise() });
        }
        let heard = self.observer.last_heard();
        let begun = self.started.or(self.begun).unwrap_or(now);
        if heard.is_some() && now.saturating_since(begun) >= self.limit() {
            return self.end(Ending::TimeOver);
        }
        match self.phase {
            Phase::Waiting => self.wait(now, heard, faults),
            Phase::Watching { until } => {
                if now >= until {
                    self.watched();
                    self.go_on(now, bus, faults);
                }
            }
            Phase::Playing { scenario, step, until } => self.play(now, scenario, step, until, bus, faults),
            Phase::Returning { scenario, until, revived } => {
                self.come_back(now, scenario, until, revived, bus, faults);
            }
            Phase::Over => {}
        }
        let silent = heard.is_some_and(|heard| now.saturating_since(heard) >= SILENCE);
        if silent && self.ending.is_none() {
            self.lost_master();
        }
    }

    /// The verdicts on the rows wanted. Times of telegrams count from `origin`. A judge that has not come to its end was
    /// out of time.
    pub fn report(mut self, origin: Instant) -> Report {
        self.end(Ending::TimeOver);
        let ending = self.ending.clone().unwrap_or(Ending::TimeOver);
        let mut configuration = self.observer.setup.words();
        configuration.extend(self.soak_words());
        let figures = self.observer.figures.clone();
        let watchdogs = self.observer.watchdogs();
        self.end_record();
        let took = self.record.took(origin);
        Report { configuration, took, figures, watchdogs, ..Report::new(self.judgements(), ending, origin) }
    }

    fn judgements(mut self) -> Vec<Judgement> {
        // Octets at another rate say nothing of the rows.
        if let Some(ending @ (Ending::Noise | Ending::Foreign(_) | Ending::NoMaster)) = &self.ending {
            let reason = ending.to_string();
            let not_judged = |row: &Row| Judgement::not_judged(*row, reason.clone());
            return self.wanted.iter().map(not_judged).collect();
        }
        self.observer.findings.play(None);
        if self.observer.telegrams() > 0 {
            self.observer.finish();
        }
        self.leave_out();
        self.explain_the_rest();
        let judgement =
            |row: &Row| Judgement { took: self.record.spent(*row), ..self.observer.findings.judgement(*row) };
        self.wanted.iter().map(judgement).collect()
    }

    fn has_failed(&self) -> bool {
        self.wanted.iter().any(|row| self.observer.findings.has_failed(*row))
    }

    /// Whether somebody speaks as a master does. In noise some octets may look like a short telegram.
    const fn is_master_known(&self) -> bool {
        self.observer.telegrams() >= LEAST_TELEGRAMS
    }

    /// What was heard is no DP.
    fn noise(&self) -> Ending {
        self.observer.overheard.foreign().map_or(Ending::Noise, Ending::Foreign)
    }

    fn wait(&mut self, now: Instant, heard: Option<Instant>, faults: &mut Faults) {
        if !self.is_master_known() {
            let waited = now.saturating_since(self.begun.unwrap_or(now));
            if waited >= SILENCE {
                self.end(if heard.is_some() { self.noise() } else { Ending::NoMaster });
            }
            return;
        }
        self.started = Some(now);
        let late = self.scenarios.first().filter(|scenario| scenario.rows.contains(&Row::L09));
        match late {
            Some(scenario) => {
                let lasts = scenario.steps.first().map_or(Duration::ZERO, |step| self.time(step));
                self.next = 1;
                self.tell(0);
                self.phase = Phase::Playing { scenario: 0, step: 0, until: now + lasts };
            }
            None => {
                faults.clear();
                self.begin_return(now, None, FIRST_LIMIT, true);
            }
        }
    }

    /// The next scenario, or the end.
    fn go_on(&mut self, now: Instant, bus: &mut Bus, faults: &mut Faults) {
        self.skip_impossible();
        let scenario = self.next;
        if scenario < self.scenarios.len() {
            self.next += 1;
            self.begin_scenario(now, scenario, bus, faults);
        } else if let Some(scenario) = self.again(now) {
            self.begin_scenario(now, scenario, bus, faults);
        } else if let Some(watching) = self.watch_on(now) {
            self.phase = watching;
        } else if !self.soak_on(now, bus, faults) {
            match self.last.take() {
                Some(last) => {
                    self.scenarios.push(last);
                    self.again.is_over = true;
                    self.go_on(now, bus, faults);
                }
                None => self.end(Ending::Done),
            }
        }
    }

    fn end(&mut self, ending: Ending) {
        if self.ending.is_none() {
            self.ending = Some(ending);
        }
        self.phase = Phase::Over;
    }
}

/// The scenarios that can be played with this master. Why the others cannot is the reason of their rows.
fn playable(mut scenarios: Vec<Scenario>, observer: &mut Observer) -> Vec<Scenario> {
    scenarios.retain(|scenario| {
        let obstacle = scenario.obstacle(&observer.setup);
        if let Some(reason) = obstacle {
            for row in &scenario.rows {
                observer.findings.obstacle(*row, reason);
            }
        }
        obstacle.is_none()
    });
    scenarios
}
