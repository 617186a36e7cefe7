//! The run: scenarios one after the other, with undisturbed data exchange between them. Sans-I/O.
//!
//! ```text
//! Waiting ─▶ (the station that joins late) ─▶ Returning ─▶ Watching ─▶ Playing ─▶ Returning ─▶ Playing … ─▶ Over
//! ```

use core::fmt;
use core::time::Duration;
use std::collections::BTreeMap;
use std::format;
use std::string::String;
use std::vec::Vec;

use super::findings::{Judgement, Weight};
use super::moment::Moment;
use super::observer::{Observer, Sight};
use super::rows::Row;
use super::scenario::{Check, Scenario, asking, built_in};
use super::setup::Setup;
use super::station::{Act, act, connect};
use crate::fdl::Address;
use crate::host::Bus;
use crate::host::link::fault::Faults;
use crate::time::Instant;

/// Good exchanges in a row with each station: nothing is wrong.
const BASELINE: u32 = 8;
/// How long a master may take until it exchanges data with every station at first.
const FIRST_LIMIT: Duration = Duration::from_secs(15);
/// How long it may take to come back.
const LIMIT: Duration = Duration::from_secs(8);
/// How long nothing is disturbed.
const WATCH: Duration = Duration::from_secs(3);
/// A master that says nothing for so long is gone.
const SILENCE: Duration = Duration::from_secs(10);
/// Octets without a telegram among them: another rate, or no master.
const NOISE: usize = 8192;
/// The whole judgement, and that of one row.
const TOTAL: Duration = Duration::from_secs(192);
const ONE_ROW: Duration = Duration::from_secs(56);
/// A lost station must be asked in this time.
const ASK_LIMIT: Duration = Duration::from_secs(3);
/// Exchanges at least to say something of random errors, and how many of a hundred must be good.
const RANDOM_CYCLES: u32 = 1000;
const RANDOM_SHARE: u32 = 90;
/// Rows that hold if nothing was seen against them at their occasion.
const BY_NOTHING_SEEN: &[Row] = &[
    Row::D02,
    Row::D07,
    Row::D12,
    Row::D14,
    Row::D15,
    Row::E14,
    Row::L01,
    Row::L05,
    Row::U05,
    Row::U06,
    Row::U07,
    Row::U08,
];
/// Why rows that nothing here gives an occasion to are not judged.
const NEVER: &[(Row, &str)] = &[
    (
        Row::E11,
        "needs a second slave in start-up at the same moment; the data link layer cannot tell whose SC it is",
    ),
    (Row::K08, "needs many slaves in virtual time"),
    (Row::I06, "needs 32 stations"),
    (Row::I07, "needs a line on which half of the stations are absent"),
    (Row::R09, "needs a line on which a second master may speak"),
    (Row::R01, "the judge plays no second master"),
    (Row::R02, "the judge plays no second master"),
    (Row::R03, "the judge plays no second master"),
    (Row::R04, "the judge plays no second master"),
    (Row::B01, "a judgement is at one rate; repeat it at each"),
    (Row::B02, "a judgement is at one rate; repeat it at each"),
    (Row::B03, "a judgement is at one rate; repeat it at each"),
    (Row::Z05, "needs --ask with restart"),
    (Row::Z06, "needs --ask with restart"),
];
/// As many stations as row I06 asks for.
const MANY: usize = 32;

/// The judge of one master.
#[derive(Debug)]
pub struct Judge {
    observer: Observer,
    wanted: Vec<Row>,
    scenarios: Vec<Scenario>,
    next: usize,
    phase: Phase,
    /// The first telegram of the master.
    started: Option<Instant>,
    begun: Option<Instant>,
    ending: Option<Ending>,
    progress: Option<Progress>,
    /// The faults of the step that is played.
    faults: Vec<u32>,
    /// What they have done in the scenario.
    struck: u32,
    /// Exchanges with each station when the scenario began.
    before: BTreeMap<u8, Counts>,
    limit: Duration,
    /// Somebody operates the master.
    operated: bool,
    /// What the master is to be asked for, to be fetched.
    ask: Option<String>,
    /// An action is under way.
    asking: bool,
    /// When requests of a master that was stopped begin to count.
    stopped: Option<Instant>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    exchanges: u32,
    start_ups: u32,
    polled: u32,
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

/// What is being tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The number of the scenario, from 1 on.
    pub number: usize,
    /// How many there are.
    pub of: usize,
    /// What is tried.
    pub name: String,
    /// How long all that is left takes, about.
    pub left: Duration,
}

/// How a judgement ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Everything was tried.
    Done,
    /// No master came.
    NoMaster,
    /// The master said nothing more.
    Silent {
        /// What was being tried.
        during: String,
    },
    /// Nothing but octets that are no telegrams.
    Noise,
    /// Data exchange with a station was not reached, or did not come back.
    NoExchange {
        /// Which station.
        station: Address,
        /// What had been tried.
        after: String,
    },
    /// The time was over.
    TimeOver,
    /// Somebody stopped it.
    Stopped,
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("everything was tried"),
            Self::NoMaster => f.write_str("no master was heard"),
            Self::Silent { during } => write!(f, "the master said nothing more for ten seconds: {during}"),
            Self::Noise => f.write_str(
                "only octets that are no telegrams were heard: the master has another rate or no even parity, or is none",
            ),
            Self::NoExchange { station, after } => {
                write!(f, "data exchange with station {station} was not reached within the time: {after}")
            }
            Self::TimeOver => f.write_str("the time for the judgement was over"),
            Self::Stopped => f.write_str("the judgement was stopped"),
        }
    }
}

impl Judge {
    /// A judge of these rows, live.
    pub fn new(setup: Setup, wanted: &[Row]) -> Self {
        Self::seeing(setup, wanted, Sight::Untimed)
    }

    pub(super) fn seeing(setup: Setup, wanted: &[Row], sight: Sight) -> Self {
        let mut scenarios = built_in(&setup);
        scenarios.retain(|scenario| {
            let mut rows = scenario.rows.iter().chain(&scenario.returns);
            rows.any(|row| wanted.contains(row))
        });
        let limit = if wanted.len() == 1 { ONE_ROW } else { TOTAL };
        let mut observer = Observer::new(setup, sight);
        scenarios.retain(|scenario| {
            let obstacle = scenario.obstacle(&observer.setup);
            if let Some(reason) = obstacle {
                for row in &scenario.rows {
                    observer.findings.obstacle(*row, reason);
                }
            }
            obstacle.is_none()
        });
        Self {
            observer,
            wanted: wanted.to_vec(),
            scenarios,
            next: 0,
            phase: Phase::Waiting,
            started: None,
            begun: None,
            ending: None,
            progress: None,
            faults: Vec::new(),
            struck: 0,
            before: BTreeMap::new(),
            limit,
            operated: false,
            ask: None,
            asking: false,
            stopped: None,
        }
    }

    /// Somebody operates the master: who runs the line calls [`Judge::poll_ask`] and [`Judge::asked`].
    #[must_use]
    pub fn operated(mut self) -> Self {
        let mut scenarios = asking(&self.observer.setup);
        scenarios.retain(|scenario| scenario.rows.iter().any(|row| self.wanted.contains(row)));
        self.scenarios.extend(scenarios);
        self.operated = true;
        self
    }

    /// What the master is to be asked for now, as `--ask` takes it.
    #[must_use]
    pub fn poll_ask(&mut self) -> Option<String> {
        self.ask.take()
    }

    /// Whether an action is under way.
    pub const fn is_asking(&self) -> bool {
        self.asking
    }

    /// The action is done, or could not be.
    pub fn asked(&mut self, now: Instant, done: bool) {
        self.asking = false;
        let Phase::Playing { scenario, step, .. } = self.phase else { return };
        let Some(played) = self.scenarios.get_mut(scenario) else { return };
        let Some(begun) = played.steps.get_mut(step) else { return };
        if !done {
            begun.check = None;
            let reason =
                format!("the command of --ask could not do: {}", begun.ask.clone().unwrap_or_default());
            for row in &played.rows {
                self.observer.findings.default_obstacle(*row, &reason);
            }
        }
        let lasts = if done { begun.lasts } else { Duration::ZERO };
        self.stopped = (begun.check == Some(Check::Stop)).then(|| now + Duration::from_secs(1));
        self.phase = Phase::Playing { scenario, step, until: now + lasts };
    }

    /// More scenarios, behind those of the judge itself.
    pub fn add(&mut self, scenarios: impl IntoIterator<Item = Scenario>) {
        let wanted = |scenario: &Scenario| {
            scenario.rows.is_empty() || scenario.rows.iter().any(|row| self.wanted.contains(row))
        };
        let playable: Vec<Scenario> = scenarios
            .into_iter()
            .filter(wanted)
            .filter(|scenario| scenario.obstacle(&self.observer.setup).is_none())
            .collect();
        self.scenarios.extend(playable);
    }

    /// Takes what was sent on the line.
    pub fn hear(&mut self, moment: Moment) {
        self.observer.take(moment);
    }

    /// The judge could not look at the line for a while: what happened meanwhile proves less.
    pub fn paused(&mut self) {
        self.observer.paused();
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
    pub fn poll_progress(&mut self) -> Option<Progress> {
        self.progress.take()
    }

    /// Whether a reply is held back now: who runs the line looks often.
    pub const fn is_waiting(&self) -> bool {
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
            self.inject(0, 0, faults);
        }
    }

    /// Does what is to be done now: call it after everything heard, and at [`Judge::poll_timeout`].
    pub fn step(&mut self, now: Instant, bus: &mut Bus, faults: &mut Faults) {
        if self.ending.is_some() {
            return;
        }
        if self.observer.noise_octets() > NOISE {
            return self.end(Ending::Noise);
        }
        let heard = self.observer.last_heard();
        let begun = self.started.or(self.begun).unwrap_or(now);
        if heard.is_some() && now.saturating_since(begun) >= self.limit {
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

    /// The verdicts on the rows wanted.
    pub fn judgements(mut self) -> Vec<Judgement> {
        if self.observer.telegrams() > 0 {
            self.observer.finish();
        }
        self.explain_the_rest();
        self.wanted.iter().map(|row| self.observer.findings.judgement(*row)).collect()
    }

    fn wait(&mut self, now: Instant, heard: Option<Instant>, faults: &mut Faults) {
        if self.observer.telegrams() == 0 {
            let waited = now.saturating_since(self.begun.unwrap_or(now));
            if waited >= SILENCE {
                self.end(if heard.is_some() { Ending::Noise } else { Ending::NoMaster });
            }
            return;
        }
        self.started = Some(now);
        let late = self.scenarios.first().filter(|scenario| scenario.rows.contains(&Row::L09));
        match late {
            Some(scenario) => {
                let lasts =
                    scenario.steps.first().map_or(Duration::ZERO, |step| step.time(&self.observer.setup));
                self.next = 1;
                self.tell(0);
                self.phase = Phase::Playing { scenario: 0, step: 0, until: now + lasts };
            }
            None => {
                faults.clear();
                self.observer.begin_streaks();
                self.phase = Phase::Returning { scenario: None, until: now + FIRST_LIMIT, revived: true };
            }
        }
    }

    fn play(
        &mut self,
        now: Instant,
        scenario: usize,
        step: usize,
        until: Instant,
        bus: &mut Bus,
        faults: &mut Faults,
    ) {
        let Some(played) = self.scenarios.get(scenario) else {
            return self.go_on(now, bus, faults);
        };
        if self.stopped.is_some_and(|stopped| stopped <= now) {
            self.stopped = None;
            self.observer.count_requests();
        }
        if self.asking {
            return;
        }
        let until_injected = played.steps.get(step).is_some_and(|step| step.until_injected);
        let done = faults
            .iter()
            .filter(|(number, ..)| self.faults.contains(number))
            .all(|(_, fault, struck)| fault.count.is_some_and(|count| struck >= count));
        if now < until && !(until_injected && done) {
            return;
        }
        let more = step + 1 < played.steps.len();
        self.end_faults(faults);
        self.step_ended(now, scenario, step);
        if more {
            return self.begin_step(now, scenario, step + 1, bus, faults);
        }
        self.observer.begin_streaks();
        self.phase = Phase::Returning {
            scenario: Some(scenario),
            until: now + self.return_limit(scenario),
            revived: false,
        };
    }

    /// The first time takes longer: the master begins.
    fn return_limit(&self, scenario: usize) -> Duration {
        if scenario == 0 && self.next == 1 { FIRST_LIMIT } else { LIMIT }
    }

    /// A step is over: what was to be seen during it.
    fn step_ended(&mut self, now: Instant, scenario: usize, step: usize) {
        let Some(played) = self.scenarios.get(scenario).cloned() else {
            return;
        };
        if let Some(check) = played.steps.get(step).and_then(|step| step.check.clone()) {
            self.observer.check(&check);
        }
        let Some(subject) = played.subject(&self.observer.setup).map(|slave| slave.address) else {
            return;
        };
        if let Some(row) = played.asked.filter(|_| step == 0) {
            let asked = self.observer.last_asked(subject);
            if asked.is_some_and(|asked| now.saturating_since(asked) < ASK_LIMIT) {
                self.observer.findings.held(row);
            } else {
                let reason = format!(
                    "station {subject} is silent, and is not asked again for {} s",
                    ASK_LIMIT.as_secs()
                );
                self.observer.show(row, Weight::Once, reason);
            }
        }
        if step > 0 {
            return;
        }
        let others: Vec<Address> = self.others(subject);
        for other in others {
            let counts = self.counts(other);
            let before = self.before.get(&other.number()).copied().unwrap_or_default();
            let exchanges = counts.exchanges.saturating_sub(before.exchanges);
            if let Some((row, least)) = played.others {
                if exchanges >= least {
                    self.observer.findings.held(row);
                } else {
                    let reason = format!(
                        "only {exchanges} Data_Exchange with station {other} meanwhile: {}",
                        played.name
                    );
                    self.observer.show(row, Weight::Once, reason);
                }
            }
            if played.rows.contains(&Row::L04) && counts.start_ups == before.start_ups {
                self.observer.findings.held(Row::L04);
            }
        }
        if played.rows.contains(&Row::O08) && self.observer.is_operating() {
            self.observer.findings.held(Row::O08);
        }
        if played.rows.contains(&Row::E17) {
            self.judge_random(subject);
        }
    }

    fn judge_random(&mut self, subject: Address) {
        let (counts, before) =
            (self.counts(subject), self.before.get(&subject.number()).copied().unwrap_or_default());
        let polled = counts.polled.saturating_sub(before.polled);
        let good = counts.exchanges.saturating_sub(before.exchanges);
        if polled < RANDOM_CYCLES {
            let reason = format!(
                "only {polled} cycles with random errors were seen; expected at least {RANDOM_CYCLES}"
            );
            self.observer.findings.obstacle(Row::E17, reason);
        } else if good * 100 >= polled * RANDOM_SHARE {
            self.observer.findings.held(Row::E17);
        } else {
            let reason =
                format!("only {good} of {polled} Data_Exchange were good with one per cent of random errors");
            self.observer.show(Row::E17, Weight::Once, reason);
        }
    }

    fn come_back(
        &mut self,
        now: Instant,
        scenario: Option<usize>,
        until: Instant,
        revived: bool,
        bus: &mut Bus,
        faults: &mut Faults,
    ) {
        let missing = self.missing();
        let Some(station) = missing else {
            if let Some(scenario) = scenario.and_then(|scenario| self.scenarios.get(scenario)).cloned()
                && !revived
            {
                self.returned(&scenario);
            }
            let first = scenario.is_none() || (scenario == Some(0) && self.next == 1);
            if first && self.observer.setup.present().count() >= MANY {
                self.observer.findings.held(Row::I06);
            }
            if first {
                self.observer.watching = true;
                self.remember();
                self.phase = Phase::Watching { until: now + WATCH };
            } else {
                self.go_on(now, bus, faults);
            }
            return;
        };
        if now < until {
            return;
        }
        let after = scenario.and_then(|scenario| self.scenarios.get(scenario)).cloned();
        if let Some(scenario) = after.as_ref().filter(|_| !revived) {
            self.did_not_return(scenario, station);
            if self.next > 1 || !scenario.rows.contains(&Row::L09) {
                // Whatever the stations have become, they begin anew.
                let slaves: Vec<_> = self.observer.setup.present().cloned().collect();
                for slave in &slaves {
                    act(Act::PowerOn, slave, bus, now);
                }
                self.observer.begin_streaks();
                let number = self.scenarios.iter().position(|other| other == scenario);
                self.phase = Phase::Returning { scenario: number, until: now + LIMIT, revived: true };
                return;
            }
        }
        let after = after.map_or("at the beginning".into(), |scenario| format!("after: {}", scenario.name));
        self.end(Ending::NoExchange { station, after });
    }

    /// Data exchange has come back.
    fn returned(&mut self, scenario: &Scenario) {
        let acted = scenario.steps.iter().any(|step| step.act.is_some() || step.ask.is_some());
        if self.struck == 0 && !acted {
            for row in &scenario.rows {
                if !self.observer.findings.is_judged(*row) {
                    let reason = format!("the master gave no occasion: {}", scenario.name);
                    self.observer.findings.obstacle(*row, reason);
                }
            }
            return;
        }
        for row in scenario.returns.iter().filter(|row| **row != Row::E17) {
            self.observer.findings.held(*row);
        }
        // It had its occasion, and nothing was seen against it.
        for row in scenario.rows.iter().filter(|row| BY_NOTHING_SEEN.contains(row)) {
            self.observer.findings.held(*row);
        }
    }

    /// It has not.
    fn did_not_return(&mut self, scenario: &Scenario, station: Address) {
        if scenario.rows.contains(&Row::L09) {
            let others = self.others(station);
            let works =
                !others.is_empty() && others.iter().all(|other| self.observer.streak(*other) >= BASELINE);
            if !works {
                return;
            }
        }
        let reason = format!(
            "no data exchange with station {station} within {} s after: {}",
            LIMIT.as_secs(),
            scenario.name
        );
        for row in &scenario.returns {
            self.observer.show(*row, Weight::Once, reason.clone());
        }
        let asked = self.observer.last_asked(station);
        if scenario.returns.is_empty() && asked.is_none_or(|asked| self.observer.is_long_ago(asked, LIMIT)) {
            self.observer.show(
                Row::L06,
                Weight::Once,
                format!("station {station} is never asked again after: {}", scenario.name),
            );
        }
    }

    fn lost_master(&mut self) {
        let scenario = match self.phase {
            Phase::Playing { scenario, .. } | Phase::Returning { scenario: Some(scenario), .. } => {
                self.scenarios.get(scenario).cloned()
            }
            Phase::Waiting
            | Phase::Watching { .. }
            | Phase::Returning { scenario: None, .. }
            | Phase::Over => None,
        };
        let during =
            scenario.as_ref().map_or("nothing was disturbed".into(), |scenario| scenario.name.clone());
        if let Some(scenario) = scenario {
            for row in &scenario.returns {
                let reason = format!("the master said nothing more after: {}", scenario.name);
                self.observer.show(*row, Weight::Once, reason);
            }
        }
        self.end(Ending::Silent { during });
    }

    /// What was seen while nothing was wrong.
    fn watched(&mut self) {
        self.observer.watching = false;
        let stations: Vec<Address> = self.observer.setup.present().map(|slave| slave.address).collect();
        let counts: Vec<(Address, u32)> = stations
            .iter()
            .map(|station| {
                let before = self.before.get(&station.number()).copied().unwrap_or_default();
                (*station, self.counts(*station).polled.saturating_sub(before.polled))
            })
            .collect();
        let most = counts.iter().map(|(_, count)| *count).max().unwrap_or(0);
        for (station, count) in counts {
            if count > 0 {
                self.observer.findings.held(Row::X03);
            } else if most >= BASELINE {
                let reason =
                    format!("no Data_Exchange with station {station} for three seconds; another had {most}");
                self.observer.show(Row::X03, Weight::Once, reason);
            }
        }
    }

    /// The next scenario, or the end.
    fn go_on(&mut self, now: Instant, bus: &mut Bus, faults: &mut Faults) {
        let scenario = self.next;
        if scenario >= self.scenarios.len() {
            return self.end(Ending::Done);
        }
        self.next += 1;
        self.struck = 0;
        self.tell(scenario);
        self.remember();
        let played = self.scenarios.get(scenario);
        self.observer.held_back = played.is_some_and(|scenario| scenario.holds);
        let floods = |scenario: &Scenario| scenario.rows.iter().any(|row| matches!(row, Row::E16 | Row::E17));
        self.observer.blind = self.scenarios.get(scenario).is_some_and(floods);
        self.begin_step(now, scenario, 0, bus, faults);
    }

    fn begin_step(&mut self, now: Instant, scenario: usize, step: usize, bus: &mut Bus, faults: &mut Faults) {
        let Some(played) = self.scenarios.get(scenario) else { return };
        let Some(begun) = played.steps.get(step) else { return };
        if let (Some(wanted), Some(subject)) = (begun.act, played.subject(&self.observer.setup)) {
            act(wanted, &subject.clone(), bus, now);
        }
        let (ask, until) = (begun.ask.clone(), now + begun.time(&self.observer.setup));
        if let Some(action) = ask {
            let clear = action == "clear" || action == "stop";
            self.observer.begin_asking();
            self.observer.want_clear(clear || action == "restart");
            if action == "restart" || (action == "operate" && step > 0) {
                self.observer.expect_new_begin();
            }
            self.ask = Some(action);
            self.asking = true;
        }
        self.inject(scenario, step, faults);
        self.phase = Phase::Playing { scenario, step, until };
    }

    fn inject(&mut self, scenario: usize, step: usize, faults: &mut Faults) {
        let Some(played) = self.scenarios.get(scenario) else { return };
        let setup = &self.observer.setup;
        let (Some(step), Some(subject)) = (played.steps.get(step), played.subject(setup)) else {
            return;
        };
        for fault in step.compiled(setup, subject.address).unwrap_or_default() {
            self.faults.push(faults.add(fault));
        }
    }

    fn end_faults(&mut self, faults: &mut Faults) {
        for (number, _, struck) in faults.iter() {
            if self.faults.contains(&number) {
                self.struck = self.struck.saturating_add(struck);
            }
        }
        for number in self.faults.drain(..) {
            faults.remove(number);
        }
        self.observer.held_back = false;
    }

    fn end(&mut self, ending: Ending) {
        if self.ending.is_none() {
            self.ending = Some(ending);
        }
        self.phase = Phase::Over;
    }

    /// Why what was not tried is not judged.
    fn explain_the_rest(&mut self) {
        for (row, reason) in NEVER {
            self.observer.findings.default_obstacle(*row, reason);
        }
        let Some(ending) = self.ending.clone().filter(|ending| *ending != Ending::Done) else {
            return;
        };
        let left: Vec<Scenario> = self.scenarios.iter().skip(self.next).cloned().collect();
        for row in left.iter().flat_map(|scenario| scenario.rows.iter().chain(&scenario.returns)) {
            if !self.observer.findings.is_judged(*row) {
                self.observer.findings.obstacle(*row, format!("not tried: {ending}"));
            }
        }
    }

    fn tell(&mut self, scenario: usize) {
        let left = self.scenarios.iter().skip(scenario);
        let time = |scenario: &Scenario| {
            let steps: Duration = scenario
                .steps
                .iter()
                .map(|step| if step.until_injected { Duration::ZERO } else { step.lasts })
                .sum();
            steps + Duration::from_millis(600)
        };
        let left: Duration = left.map(time).sum();
        if let Some(played) = self.scenarios.get(scenario) {
            self.progress = Some(Progress {
                number: scenario + 1,
                of: self.scenarios.len(),
                name: played.name.clone(),
                left,
            });
        }
    }

    /// The first station with which data are not exchanged as they should be.
    fn missing(&self) -> Option<Address> {
        let mut present = self.observer.setup.present().map(|slave| slave.address);
        present.find(|station| self.observer.streak(*station) < BASELINE)
    }

    fn others(&self, subject: Address) -> Vec<Address> {
        self.observer
            .setup
            .present()
            .map(|slave| slave.address)
            .filter(|station| *station != subject)
            .collect()
    }

    fn counts(&self, station: Address) -> Counts {
        Counts {
            exchanges: self.observer.exchanges(station),
            start_ups: self.observer.start_ups(station),
            polled: self.observer.polled(station),
        }
    }

    fn remember(&mut self) {
        let stations: Vec<Address> = self.observer.setup.present().map(|slave| slave.address).collect();
        self.before = stations.into_iter().map(|station| (station.number(), self.counts(station))).collect();
    }
}
