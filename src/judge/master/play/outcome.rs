//! What a scenario has shown beside single telegrams: whether data exchange came back, what the other stations noticed,
//! and why a row that nothing was seen of is not judged.

use core::time::Duration;

use super::baseline::{BASELINE, MANY};
use super::{Ending, Judge, Phase};
use crate::judge::Verdict;
use crate::judge::master::findings::Weight;
use crate::judge::master::observer::Sight;
use crate::judge::master::rows::Row;
use crate::judge::master::scenario::Scenario;
use crate::judge::master::setup::Slave;
use crate::profibus::fdl::Address;
use crate::time::Instant;

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
/// Why rows that nothing was seen of are not judged.
const UNSEEN: &[(Row, &str)] = &[
    (Row::C06, "no request was repeated until the retries were over and FCV = 0 followed"),
    (Row::U10, "no data were exchanged in CLEAR before OPERATE"),
    (Row::I01, "needs --min-interval, or min-interval=MS of a station"),
    (Row::I03, "needs an absent station that the master asks"),
    (Row::K08, "needs 500 tokens of the master"),
    (
        Row::C10,
        "the master sent no request with FCV = 0 to a silent station while another one exchanged data",
    ),
    (
        Row::C11,
        "the master sent no request with FCV = 0 to a silent station while another one exchanged data",
    ),
    (Row::X09, "needs a program that changes the outputs at full rate in a way the judge knows"),
    (Row::O04, "the master sent no Global_Control"),
    (Row::O05, "the master sent no Global_Control"),
    (Row::O08, "the master was not in OPERATE while a station was silent"),
    (Row::V01, "the master sent no request of DP-V1 to SAP 51 or 50"),
    (Row::V02, "the master sent no request of DP-V1"),
    (Row::V03, "the master sent no request of DP-V1"),
    (Row::V04, "the master sent no request of DP-V1"),
    (Row::V05, "the master sent no request of DP-V1 while jobs took long"),
    (Row::V06, "the master sent no request of DP-V1 while it exchanged data"),
    (Row::V07, "the master sent no request of DP-V1 while jobs were refused"),
    (Row::V08, "the master sent no Write of DP-V1"),
    (Row::V09, "the master sent no request of DP-V1 that got no response"),
    (Row::V10, "no job of DP-V1 ended with data exchange"),
    (Row::V11, "the master acknowledged no alarm"),
    (Row::V12, "no alarm: the master enables none in DPV1_Status_2, or the slave offers none"),
    (Row::V13, "the master sent no request to SAP 50"),
    (Row::V14, "needs a station of DP-V1: dpv1, or gsd=FILE"),
    (Row::V15, "needs a device file of DP-V1"),
    (Row::V16, "needs a device file of DP-V1"),
    (Row::V17, "no Set_Prm had Prm_Structure"),
    (Row::V18, "the master opened no connection (SAP 49)"),
    (Row::V19, "no connection was kept by Idle"),
    (Row::V20, "the master opened no connection (SAP 49)"),
    (Row::V21, "needs --ask with read and write, and a station of DP-V1"),
    (Row::S02, "needs --ask, and a Sync or Freeze that the master sends"),
    (Row::L04, "needs two stations that are present"),
    (
        Row::E11,
        "needs a second station in start-up at the same moment; the data link layer cannot tell whose SC it is",
    ),
    (Row::I02, "needs two stations that are present"),
    (Row::I05, "needs two stations that are present"),
    (Row::I06, "needs 32 stations that are present"),
    (Row::I07, "needs half of the stations absent"),
    (Row::R10, "needs --ask with the action restart, in virtual time"),
    (Row::B01, "needs several rates: --baud RATE,RATE.. with --ask"),
    (Row::B02, "needs several rates in virtual time: `judge::at_rates`"),
    (Row::B03, "needs several rates: --baud RATE,RATE.. with --ask"),
    (Row::Z05, "needs a person who switches the master off while it sends"),
    (Row::Z06, "needs --ask with the action restart"),
];
/// Exchanges at least to say something of random errors, and how many of a hundred must be good.
const RANDOM_CYCLES: u32 = 200;
const RANDOM_SHARE: u32 = 90;
/// A station that is not asked for so long is forgotten.
const FORGOTTEN: Duration = Duration::from_secs(8);
/// A lost station must be asked in this time.
const ASK_LIMIT: Duration = Duration::from_secs(3);

impl Judge {
    /// A step is over: what was to be seen during it.
    pub(super) fn step_ended(&mut self, now: Instant, scenario: usize, step: usize) {
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
                // Every slave answers here: the cycle is hardly longer than it was.
                let usual = (row == Row::I05 && !self.cycle().is_zero()).then(|| self.cycle());
                let lasts = played.steps.first().map_or(Duration::ZERO, |step| self.time(step));
                // Where time is that of a busy machine it may become much longer by itself.
                let part = if matches!(self.observer.sight(), Sight::Exact(_)) { 4 } else { 20 };
                let share = usual.map_or(0, |usual| lasts.as_micros() / usual.as_micros().max(1) / part);
                let least = least.max(u32::try_from(share).unwrap_or(u32::MAX));
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
        if played.rows.contains(&Row::O08) {
            self.observer.judge_mode_at_loss(subject);
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
            self.observer.findings.missed(Row::E17, reason);
        } else if good * 100 >= polled * RANDOM_SHARE {
            self.observer.findings.held(Row::E17);
        } else {
            let reason =
                format!("only {good} of {polled} Data_Exchange were good with one per cent of random errors");
            self.observer.show(Row::E17, Weight::Once, reason);
        }
    }

    /// Data exchange has come back.
    pub(super) fn returned(&mut self, scenario: &Scenario) {
        // The second master says itself what it has seen.
        if scenario.course().is_some() {
            if let Some(slave) = scenario.subject(&self.observer.setup).map(|slave| slave.address) {
                self.judge_after_reading(slave);
            }
            return;
        }
        // Where faults are to act the master must have given them an occasion.
        let acted = scenario.steps.iter().all(|step| step.faults.is_empty());
        if self.injected == 0 && !acted {
            for row in &scenario.rows {
                if !self.observer.findings.is_judged(*row) {
                    let reason = format!("the master gave no occasion: {}", scenario.name);
                    self.observer.findings.missed(*row, reason);
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
    pub(super) fn did_not_return(&mut self, now: Instant, scenario: &Scenario, station: Address) {
        if scenario.rows.contains(&Row::L09) {
            let others = self.others(station);
            let is_late = scenario.subject(&self.observer.setup).is_some_and(|late| late.address == station);
            let works = is_late && others.iter().all(|other| self.observer.streak(*other) >= BASELINE);
            let asked = self.observer.last_asked(station);
            let forgotten = asked.is_some_and(|asked| self.observer.is_long_ago(asked, FORGOTTEN));
            if !works || (others.is_empty() && !forgotten) {
                return;
            }
        }
        let waited = self.returns_for(now).as_secs();
        if self.is_under_way(now, station) {
            let asks = self.observer.asks(station);
            let reason = format!(
                "station {station} was asked {asks} times only in the {waited} s after: {}",
                scenario.name
            );
            for row in self.at_stake(scenario) {
                self.observer.findings.missed(row, reason.clone());
            }
            return;
        }
        let reason =
            format!("no data exchange with station {station} within {waited} s after: {}", scenario.name);
        for row in self.at_stake(scenario) {
            self.observer.show(row, Weight::Once, reason.clone());
        }
        let asked = self.observer.last_asked(station);
        if scenario.returns.is_empty()
            && asked.is_none_or(|asked| self.observer.is_long_ago(asked, self.later_limit()))
        {
            self.observer.show(
                Row::L06,
                Weight::Once,
                format!("station {station} is never asked again after: {}", scenario.name),
            );
        }
    }

    /// Data exchange with a station was never reached: the rows that want nothing else.
    pub(super) fn judge_unreached(&mut self, station: Address) {
        let setup = &self.observer.setup;
        let lengths = setup.slave(station).and_then(Slave::lengths).unwrap_or_default();
        let tried = self.observer.polled(station) > 0;
        let many = setup.present().count() >= MANY;
        for (row, concerns, what) in [
            (Row::X06, tried && lengths.inputs == 0, "has outputs only and answers with SC"),
            (Row::X08, tried && lengths.inputs == 244 && lengths.outputs == 244, "has 244 octets each way"),
            (Row::I06, many, "is one of 32 and more"),
        ] {
            if concerns {
                let reason = format!("no lasting data exchange with station {station}, which {what}");
                self.observer.show(row, Weight::Once, reason);
            }
        }
    }

    pub(super) fn lost_master(&mut self) {
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
        let mut rows = scenario.as_ref().map(|scenario| self.at_stake(scenario)).unwrap_or_default();
        rows.retain(|row| self.observer.findings.judgement(*row).verdict != Verdict::Fail);
        for row in &rows {
            let reason = format!("the master said nothing more after: {during}");
            self.observer.show(*row, Weight::Once, reason);
        }
        self.end(Ending::Silent { during, rows });
    }

    /// The rows that a scenario breaks if the master does not survive it: those about coming back, or its first one.
    fn at_stake(&self, scenario: &Scenario) -> Vec<Row> {
        let wanted = |row: &&Row| self.wanted.contains(row);
        let returns: Vec<Row> = scenario.returns.iter().filter(wanted).copied().collect();
        if returns.is_empty() {
            scenario.rows.iter().find(wanted).copied().into_iter().collect()
        } else {
            returns
        }
    }

    /// What was seen while nothing was wrong.
    pub(super) fn watched(&mut self) {
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
            let seldom = count * 3 < most * 2;
            if !seldom && count > 0 {
                self.observer.findings.held(Row::X03);
            } else if most >= BASELINE * 2 {
                let reason = format!(
                    "undisturbed, {count} Data_Exchange with station {station}; another had {most} in the same time"
                );
                self.observer.show(Row::X03, Weight::Once, reason);
            }
        }
    }

    /// Rows that are not about a master of this class.
    pub(super) fn leave_out(&mut self) {
        if self.observer.setup.is_class_2() {
            for row in self.wanted.iter().filter(|row| !row.is_of_class_2()) {
                self.observer.findings.inapplicable(*row, "does not apply to a master of class 2");
            }
        }
    }

    /// Why what was not tried is not judged.
    pub(super) fn explain_the_rest(&mut self) {
        for (row, reason) in UNSEEN {
            self.observer.findings.default_obstacle(*row, reason);
        }
        let Some(ending) = self.ending.clone().filter(|ending| *ending != Ending::Done) else {
            return;
        };
        let left: Vec<Scenario> = self.scenarios.iter().skip(self.next).cloned().collect();
        for row in left.iter().flat_map(|scenario| scenario.rows.iter().chain(&scenario.returns)) {
            if !self.observer.findings.is_judged(*row) {
                self.observer.findings.missed(*row, format!("not tried: {ending}"));
            }
        }
    }
}
