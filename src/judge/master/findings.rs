//! What was found of each row: how often it held, how it was broken, why it was not judged.

use crate::map::Map;

use super::Judgement;
use super::rows::{Place, Row};
use crate::judge::Verdict;
use crate::judge::moment::{Moment, explained};
use crate::profibus::fdl::Address;

/// How much it takes for a breach to count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weight {
    /// One is proof.
    Once,
    /// So many: a process that slept explains fewer.
    Times(u32),
    /// So many, and more than this share of all occasions, in thousandths.
    Share(u32, u32),
}

/// The first breach that was seen of a row.
#[derive(Clone, Debug)]
struct Breach {
    reason: String,
    moments: Vec<Moment>,
    scenario: Option<String>,
}

#[derive(Clone, Debug, Default)]
struct Record {
    held: u32,
    broken: u32,
    weight: Option<Weight>,
    first: Option<Breach>,
    obstacle: Option<Obstacle>,
}

/// Why nothing can be said of a row.
#[derive(Clone, Debug)]
struct Obstacle {
    reason: String,
    /// It could have been judged, and was not.
    missed: bool,
}

/// Every row.
#[derive(Clone, Debug)]
pub(super) struct Findings {
    /// In the order of [`Row::ALL`].
    records: Vec<Record>,
    /// Ident numbers of the stations, for the words beside their telegrams.
    idents: Map<u8, u16>,
    /// The scenario that is played.
    scenario: Option<String>,
    /// A row was broken since somebody looked.
    changed: bool,
    /// A soak gives so many occasions that some breaches by delays of a process are to be expected.
    soaks: bool,
}

impl Default for Findings {
    fn default() -> Self {
        Self {
            records: vec![Record::default(); Row::ALL.len()],
            idents: Map::new(),
            scenario: None,
            changed: false,
            soaks: false,
        }
    }
}

impl Findings {
    /// From now on this scenario is played, or none.
    pub(super) fn play(&mut self, scenario: Option<String>) {
        self.scenario = scenario;
    }

    /// From now on scenarios are repeated.
    pub(super) const fn soak(&mut self) {
        self.soaks = true;
    }

    /// Takes the ident number of a station, unless it is known.
    pub(super) fn identify(&mut self, station: Address, ident: u16) {
        self.idents.or_insert_with(station.number(), || ident);
    }

    fn record(&self, row: Row) -> Option<&Record> {
        self.records.get(row as usize)
    }

    fn change(&mut self, row: Row, change: impl FnOnce(&mut Record)) {
        if let Some(record) = self.records.get_mut(row as usize) {
            change(record);
        }
    }

    /// One occasion at which a row held.
    pub(super) fn held(&mut self, row: Row) {
        self.change(row, |record| record.held = record.held.saturating_add(1));
    }

    /// One occasion at which a row was broken.
    pub(super) fn broken(&mut self, row: Row, weight: Weight, reason: String, moments: Vec<Moment>) {
        let scenario = self.scenario.clone();
        self.changed = true;
        self.change(row, |record| {
            record.broken = record.broken.saturating_add(1);
            // What was proved once stays so.
            if record.weight != Some(Weight::Once) {
                record.weight = Some(weight);
            }
            record.first.get_or_insert(Breach { reason, moments, scenario });
        });
    }

    /// Why a row cannot be judged, if nothing else is said of it.
    pub(super) fn obstacle(&mut self, row: Row, reason: impl Into<String>) {
        let obstacle = Obstacle { reason: reason.into(), missed: false };
        self.change(row, |record| record.obstacle = Some(obstacle));
    }

    /// Why a row that could have been judged was not, if nothing else is said of it.
    pub(super) fn missed(&mut self, row: Row, reason: impl Into<String>) {
        let obstacle = Obstacle { reason: reason.into(), missed: true };
        self.change(row, |record| record.obstacle = Some(obstacle));
    }

    /// The same, unless there is such a reason already.
    pub(super) fn default_missed(&mut self, row: Row, reason: &str) {
        let record = self.record(row);
        if record.and_then(|record| record.obstacle.as_ref()).is_none_or(|obstacle| !obstacle.missed) {
            self.missed(row, reason);
        }
    }

    /// What was found against a row says nothing, for this reason.
    pub(super) fn void(&mut self, row: Row, reason: &str) {
        if self.has_failed(row) {
            self.change(row, |record| *record = Record::default());
            self.missed(row, reason);
        }
    }

    /// A row is about something that this master does not do: what was found of it says nothing.
    pub(super) fn inapplicable(&mut self, row: Row, reason: &str) {
        self.change(row, |record| *record = Record::default());
        self.obstacle(row, reason);
    }

    /// A reason for a row that has none.
    pub(super) fn default_obstacle(&mut self, row: Row, reason: &str) {
        if self.record(row).is_some_and(|record| record.obstacle.is_none()) {
            self.obstacle(row, reason);
        }
    }

    /// Whether anything was said of a row.
    pub(super) fn is_judged(&self, row: Row) -> bool {
        self.record(row).is_some_and(|record| record.held > 0 || self.fails(record))
    }

    /// Whether something was seen against a row that is no proof.
    pub(super) fn is_doubtful(&self, row: Row) -> bool {
        self.record(row).is_some_and(|record| record.broken > 0 && !self.fails(record))
    }

    /// Whether more occasions would say more of a row.
    pub(super) fn is_open(&self, row: Row) -> bool {
        let Some(record) = self.record(row) else { return true };
        let may_come = record.obstacle.as_ref().is_none_or(|obstacle| obstacle.missed);
        self.is_doubtful(row) || (record.broken == 0 && record.held == 0 && may_come)
    }

    /// What shows the first breach of a row.
    pub(super) fn moments(&self, row: Row) -> Vec<Moment> {
        let first = self.record(row).and_then(|record| record.first.as_ref());
        first.map(|breach| breach.moments.clone()).unwrap_or_default()
    }

    /// Whether a row was broken since the last call.
    pub(super) const fn take_change(&mut self) -> bool {
        core::mem::replace(&mut self.changed, false)
    }

    /// Whether a row has failed.
    pub(super) fn has_failed(&self, row: Row) -> bool {
        self.record(row).is_some_and(|record| self.fails(record))
    }

    fn fails(&self, record: &Record) -> bool {
        proves(record, self.soaks)
    }

    /// The verdict on a row.
    pub(super) fn judgement(&self, row: Row) -> Judgement {
        let none = Record::default();
        let record = self.record(row).unwrap_or(&none);
        let judged = |verdict, reason, telegrams| Judgement {
            verdict,
            telegrams,
            ..Judgement::not_judged(row, reason)
        };
        match &record.first {
            Some(Breach { reason, moments, scenario }) if self.fails(record) => {
                let verdict = if row.only_warns() { Verdict::Warn } else { Verdict::Fail };
                let times =
                    if record.broken > 1 { format!(" ({} times)", record.broken) } else { String::new() };
                let shown = explained(moments.iter().cloned(), &self.idents);
                Judgement { scenario: scenario.clone(), ..judged(verdict, format!("{reason}{times}"), shown) }
            }
            _ if record.held > 0 => {
                let times = if record.held == 1 { "once".into() } else { format!("{} times", record.held) };
                judged(Verdict::Pass, format!("held {times}"), Vec::new())
            }
            _ => {
                let doubtful = record.first.as_ref().map(|breach| {
                    format!(
                        "not proved: {} ({} times, which a delay of the process may explain)",
                        breach.reason, record.broken
                    )
                });
                let (reason, applies) = match (doubtful, &record.obstacle) {
                    (Some(doubtful), _) => (doubtful, true),
                    (None, Some(Obstacle { reason, missed })) => (reason.clone(), *missed),
                    (None, None) => no_occasion(row),
                };
                Judgement { applies, ..Judgement::not_judged(row, reason) }
            }
        }
    }
}

/// Whether the breaches are enough. In a soak those that a delay explains must be one in a hundred occasions.
fn proves(record: &Record, soaks: bool) -> bool {
    let least = if soaks { 10 } else { 0 };
    match record.weight {
        None => false,
        Some(Weight::Once) => record.broken > 0,
        Some(Weight::Times(times)) => record.broken >= times && is_share(record, least),
        Some(Weight::Share(times, share)) => record.broken >= times && is_share(record, share.max(least)),
    }
}

/// Whether more than so many in a thousand occasions were breaches.
fn is_share(record: &Record, thousandths: u32) -> bool {
    let all = u64::from(record.broken) + u64::from(record.held);
    u64::from(record.broken) * 1000 > u64::from(thousandths) * all
}

/// Why a row that nothing was said of is not judged, and whether it could have been.
fn no_occasion(row: Row) -> (String, bool) {
    let places = row.about().places;
    let seen_here = |place: &Place| matches!(place, Place::Pty | Place::Margin);
    let (reason, applies) = match places {
        [] => ("the user is responsible for it; it is never judged", false),
        [Place::Ask] => ("needs --ask: a command that operates the master", false),
        places if places.iter().any(seen_here) => ("no telegram gave an occasion to judge it", true),
        [Place::Serial] => ("needs a real line that shows parity and pauses", false),
        [Place::Virtual] => ("needs virtual time: the library function in a Rust test", false),
        [..] => ("needs a real line or virtual time: no bit times are seen on this link", false),
    };
    (reason.into(), applies)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_breach_counts_when_its_weight_is_reached() {
        let mut findings = Findings::default();
        let broken = |findings: &mut Findings, weight| {
            findings.broken(Row::C02, weight, "why".into(), Vec::new());
            findings.judgement(Row::C02).verdict
        };
        assert_eq!(findings.judgement(Row::C02).verdict, Verdict::NotJudged);
        findings.held(Row::C02);
        assert_eq!(findings.judgement(Row::C02).verdict, Verdict::Pass);
        assert_eq!(broken(&mut findings, Weight::Times(2)), Verdict::Pass);
        assert_eq!(broken(&mut findings, Weight::Times(2)), Verdict::Fail);
        assert_eq!(broken(&mut findings, Weight::Share(3, 750)), Verdict::Pass);
        assert_eq!(broken(&mut findings, Weight::Share(3, 750)), Verdict::Fail);
    }

    #[test]
    fn an_uncertain_row_only_warns() {
        let mut findings = Findings::default();
        findings.broken(Row::U07, Weight::Once, "why".into(), Vec::new());
        assert_eq!(findings.judgement(Row::U07).verdict, Verdict::Warn);
    }
}
