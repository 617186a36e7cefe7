//! The run: rows one after the other, and what one says of the others.

use core::time::Duration;

use super::course::{Course, Halt};
use super::row::{By, Judge, Row, Table};
use super::{Ending, Soak};
use crate::chance::Random;
use crate::judge::Progress;
use crate::judge::moment::Telegram;
use crate::judge::report::ReportOf;
use crate::judge::requirement::Requirement as _;
use crate::judge::verdict::{JudgementOf, Verdict};
use crate::time::Instant;

/// A device under test, and the line to it.
pub(super) trait Trial: Table {
    /// The time now.
    fn now(&self) -> Instant;

    /// What was sent and heard since the last call, and since it was forgotten.
    fn take_shown(&mut self) -> Vec<Telegram>;

    /// What was sent and heard is of no interest any more.
    fn forget_shown(&mut self);

    /// Looks for the device, and learns what rows need to know of it.
    fn begin(&mut self) -> Course;

    /// Brings the device to where each row begins.
    fn settle(&mut self) -> Course;

    /// Waits until the device says nothing more.
    fn calm(&mut self) -> Course;

    /// Why nothing more may be tried: the time is over, somebody stopped it.
    fn must_end(&self) -> Option<Ending>;

    /// What was noticed against a row while others were judged.
    fn noted(&mut self, id: &str) -> Option<(String, Vec<Telegram>)>;

    /// Why data were never exchanged; `None`: they were, or nobody tried.
    fn never_exchanged(&self) -> Option<String>;

    /// How long rows are tried again; `None`: each is tried once.
    fn soak(&self) -> Option<Soak>;

    /// What was configured, for the report. Asked in the end.
    fn words(&self) -> Vec<(&'static str, String)>;
}

/// Judges the device by these rows.
pub(super) fn run<P: Trial>(
    device: &mut P,
    wanted: &[Row<P>],
    told: &mut dyn FnMut(&Progress),
) -> ReportOf<Row<P>> {
    let origin = device.now();
    let mut run = Run { wanted: wanted.to_vec(), judgements: Vec::new(), ending: None };
    run.begin(device);
    let (watched, tried): (Vec<_>, Vec<_>) =
        needs_first(wanted).into_iter().partition(|row| matches!(row.entry.by, By::Watching(_)));
    let of = tried.len();
    for (number, row) in (1..).zip(tried.iter().copied()) {
        if let Some(ending) = device.must_end() {
            run.end(ending);
        }
        if run.ending.is_none() {
            let spent = device.now().saturating_since(origin);
            let name = format!("{} {}", row.id(), row.text());
            told(&Progress { number, of, name, left: left(spent, number, of) });
        }
        run.row(device, row);
    }
    if let Some(soak) = device.soak() {
        run.soak(device, soak, &tried, told);
    }
    for row in watched {
        run.row(device, row);
    }
    run.note(device);
    if run.ending.is_none()
        && let Some(why) = device.never_exchanged()
    {
        run.end(Ending::NoExchange { why });
    }
    let mut judgements = run.judgements;
    judgements.sort_by_key(|judgement| judgement.row);
    let report = ReportOf::new(judgements, run.ending.unwrap_or(Ending::Done), origin);
    let took = device.now().saturating_since(origin);
    ReportOf { configuration: device.words(), took, ..report }
}

/// The rows in the order in which they are judged: those that others need are in front of them.
fn needs_first<P: Trial>(wanted: &[Row<P>]) -> Vec<Row<P>> {
    fn add<P: Trial>(row: Row<P>, wanted: &[Row<P>], ordered: &mut Vec<Row<P>>) {
        if ordered.contains(&row) {
            return;
        }
        for needed in wanted.iter().filter(|other| **other != row && row.needs().contains(&other.id())) {
            add(*needed, wanted, ordered);
        }
        ordered.push(row);
    }
    let mut ordered = Vec::new();
    for row in wanted {
        add(*row, wanted, &mut ordered);
    }
    ordered
}

/// How long the rest takes if it goes on so.
fn left(spent: Duration, number: usize, of: usize) -> Duration {
    let (done, rest) = (number.saturating_sub(1), of.saturating_sub(number) + 1);
    let (done, rest) = (u32::try_from(done).unwrap_or(u32::MAX), u32::try_from(rest).unwrap_or(u32::MAX));
    spent.checked_div(done).map_or(Duration::ZERO, |one| one.saturating_mul(rest))
}

struct Run<P: Trial> {
    wanted: Vec<Row<P>>,
    judgements: Vec<JudgementOf<Row<P>>>,
    ending: Option<Ending>,
}

impl<P: Trial> Run<P> {
    fn begin(&mut self, device: &mut P) {
        device.forget_shown();
        match device.begin() {
            Ok(()) => {}
            Err(Halt::Over(Ending::Died { .. })) => {
                self.end(Ending::NoExchange { why: "it answered, and then said nothing more".into() });
            }
            Err(Halt::Over(Ending::Babbles { .. })) => {
                self.end(Ending::NoExchange { why: "it sends without end and without being asked".into() });
            }
            Err(Halt::Over(ending)) => self.end(ending),
            Err(Halt::Broken { why, .. } | Halt::Missed(why) | Halt::Inapplicable(why)) => {
                self.end(Ending::NoExchange { why });
            }
        }
    }

    fn end(&mut self, ending: Ending) {
        self.ending.get_or_insert(ending);
    }

    /// What was noticed against rows that held when they were tried.
    fn note(&mut self, device: &mut P) {
        for judgement in self.judgements.iter_mut().filter(|judgement| judgement.verdict == Verdict::Pass) {
            if let Some((reason, telegrams)) = device.noted(judgement.row.id()) {
                let verdict = against(judgement.row);
                *judgement = JudgementOf { verdict, reason, telegrams, ..judgement.clone() };
            }
        }
    }

    /// The verdict on a row.
    fn row(&mut self, device: &mut P, row: Row<P>) {
        let begun = device.now();
        device.forget_shown();
        let judgement = match (row.entry.by.judged(), self.failed_before(row)) {
            (Err(why), _) => JudgementOf { applies: false, ..JudgementOf::not_judged(row, why.into()) },
            (Ok(_), Some(before)) => JudgementOf {
                applies: false,
                ..JudgementOf::not_judged(row, format!("after {before}, which failed"))
            },
            (Ok((_, true)), None) if self.ending.is_some() => {
                JudgementOf::not_judged(row, "not tried".into())
            }
            (Ok((judge, tries)), None) => {
                let course = judge(device);
                self.judged(device, row, course, tries)
            }
        };
        let took = device.now().saturating_since(begun);
        self.judgements.push(JudgementOf { took, ..judgement });
    }

    /// Rows that held, tried again at random until the time is over. One that breaks is not tried any more.
    fn soak(&mut self, device: &mut P, soak: Soak, tried: &[Row<P>], told: &mut dyn FnMut(&Progress)) {
        let mut random = Random::new(soak.seed);
        let until = device.now().saturating_add(soak.lasts);
        let of = tried.len();
        for number in of + 1.. {
            if let Some(ending) = device.must_end() {
                self.end(ending);
            }
            let now = device.now();
            let held: Vec<usize> = self
                .judgements
                .iter()
                .enumerate()
                .filter(|(_, judgement)| judgement.verdict == Verdict::Pass)
                .map(|(place, _)| place)
                .collect();
            if self.ending.is_some() || now >= until || held.is_empty() {
                return;
            }
            let Some(place) = held.get(random.below(held.len())).copied() else { return };
            let Some(row) = self.judgements.get(place).map(|judgement| judgement.row) else { return };
            let name = format!("{} {}", row.id(), row.text());
            told(&Progress { number, of, name, left: until.saturating_since(now) });
            device.forget_shown();
            let Ok((judge, tries)) = row.entry.by.judged() else { return };
            let course = judge(device);
            let again = self.judged(device, row, course, tries);
            let took = device.now().saturating_since(now);
            if let Some(judgement) = self.judgements.get_mut(place) {
                judgement.took += took;
                if matches!(again.verdict, Verdict::Fail | Verdict::Warn) {
                    let reason = format!("when it was tried again: {}", again.reason);
                    let took = judgement.took;
                    *judgement = JudgementOf { reason, took, ..again };
                }
            }
        }
    }

    /// The first row that this one needs, and that failed or was not judged because of one.
    fn failed_before(&self, row: Row<P>) -> Option<&'static str> {
        let fails = |id: &&&'static str| {
            let of_row = self.judgements.iter().find(|judgement| judgement.row.id() == **id);
            of_row.is_some_and(|judgement| judgement.verdict == Verdict::Fail)
        };
        let of_need = |id: &&'static str| {
            let needed = self.wanted.iter().find(|row| row.id() == *id)?;
            self.failed_before(*needed)
        };
        let direct = row.needs().iter().find(fails).copied();
        direct.or_else(|| row.needs().iter().find_map(of_need))
    }

    fn judged(&mut self, device: &mut P, row: Row<P>, course: Course, tries: bool) -> JudgementOf<Row<P>> {
        let mut judgement = self.verdict(device, row, course);
        if tries && self.ending.is_none() {
            // What a row has left behind is its own.
            if let Err(halt) = device.settle() {
                let behind = self.verdict(device, row, Err(halt.behind()));
                if judgement.verdict != Verdict::Fail {
                    judgement = behind;
                }
                self.bring_back(device, row);
            }
        }
        judgement
    }

    /// Once more, after some silence: or nothing more can be said.
    fn bring_back(&mut self, device: &mut P, row: Row<P>) {
        let during = row.id();
        match device.calm().and_then(|()| device.settle()) {
            Ok(()) => {}
            Err(Halt::Over(Ending::Babbles { .. })) => self.end(Ending::Babbles { during }),
            Err(Halt::Over(ending @ (Ending::Broken { .. } | Ending::Stopped | Ending::TimeOver))) => {
                self.end(ending);
            }
            Err(Halt::Over(_)) => self.end(Ending::Died { during }),
            Err(Halt::Broken { .. } | Halt::Missed(_) | Halt::Inapplicable(_)) => {
                self.end(Ending::Stuck { during });
            }
        }
    }

    fn verdict(&mut self, device: &mut P, row: Row<P>, course: Course) -> JudgementOf<Row<P>> {
        let said = |verdict, reason: String, telegrams| JudgementOf {
            verdict,
            telegrams,
            ..JudgementOf::not_judged(row, reason)
        };
        match course {
            Ok(()) => said(Verdict::Pass, "held".into(), Vec::new()),
            Err(Halt::Broken { why, shown }) => {
                said(against(row), why, shown.unwrap_or_else(|| device.take_shown()))
            }
            Err(Halt::Missed(why)) => said(Verdict::NotJudged, why, Vec::new()),
            Err(Halt::Inapplicable(why)) => {
                JudgementOf { applies: false, ..said(Verdict::NotJudged, why, Vec::new()) }
            }
            Err(Halt::Over(ending)) => {
                let during = row.id();
                let (ending, is_its_own) = match ending {
                    Ending::Died { .. } | Ending::NoDevice => (Ending::Died { during }, true),
                    Ending::Babbles { .. } => (Ending::Babbles { during }, true),
                    Ending::Done
                    | Ending::Stuck { .. }
                    | Ending::NoExchange { .. }
                    | Ending::Broken { .. }
                    | Ending::TimeOver
                    | Ending::Stopped => (ending, false),
                };
                let why = ending.to_string();
                self.end(ending);
                if is_its_own {
                    said(Verdict::Fail, why, device.take_shown())
                } else {
                    said(Verdict::NotJudged, why, Vec::new())
                }
            }
        }
    }
}

/// The verdict on a row that is broken.
fn against<P: Trial>(row: Row<P>) -> Verdict {
    if row.only_warns() { Verdict::Warn } else { Verdict::Fail }
}

impl Halt {
    /// The same, of what comes behind a row.
    fn behind(self) -> Self {
        match self {
            Self::Broken { why, shown } => Self::Broken { why: format!("after it, {why}"), shown },
            Self::Missed(why) => Self::Missed(format!("after it, {why}")),
            Self::Inapplicable(_) | Self::Over(_) => self,
        }
    }
}

impl<P> By<P> {
    /// The function that judges, and whether it sends something; or why there is none.
    fn judged(&self) -> Result<(Judge<P>, bool), &'static str> {
        match self {
            Self::Trial(judge) => Ok((*judge, true)),
            Self::Watching(judge) => Ok((*judge, false)),
            Self::Nothing(why) => Err(why),
        }
    }
}
