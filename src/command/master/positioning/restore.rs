//! `restore`: a parameter set into a drive, and what became of each value.

use core::time::Duration;

use crate::devices::ag03::param::{Entry, Model, Parameter, Quirks, Value, entry, parameters};
use crate::explain::value::{Lengths, in_words};
use crate::host::{Clock, Link};
use crate::master::{Change, Drive, DriveError, Identity, Restored, WriteOutcome, changes};
use serde_json::json;

use super::access::about;
use super::set::{Origin, ParameterSet};
use super::status::travels;
use super::value::is_setting;
use crate::command::Failure;
use crate::command::master::{say, watch};

/// How long a drive that was released may turn.
const RUN_OUT: Duration = Duration::from_secs(10);

/// How far `restore` shall go.
#[derive(Clone, Copy, Debug)]
pub(super) struct How {
    /// Show what differs and write nothing.
    pub(super) dry_run: bool,
    /// Also a set of a drive of another kind.
    pub(super) yes: bool,
}

/// Shows what differs, writes that, reads all of it back.
pub(super) fn restore<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    wanted: &ParameterSet,
    How { dry_run, yes }: How,
    json: bool,
) -> Result<(), Failure> {
    let identity = drive.identify().map_err(nothing_written)?;
    fits(identity, wanted)?;
    let found = read_all(drive, wanted)?;
    let plan = Plan::of(wanted, &found);
    let other = other_drive(identity, &wanted.origin);
    if !json {
        plan.show()?;
        let kept = uncovered(identity, wanted);
        if !kept.is_empty() {
            let kept: Vec<_> = kept.iter().map(|entry| format!("{} {}", entry.pnu, entry.name)).collect();
            say(format_args!("not in the file, and left as they are: {}", kept.join(", ")))?;
        }
        if let Some(other) = &other {
            say(other)?;
        }
    }
    if dry_run || plan.changes.is_empty() {
        return if json { say(Report::nothing(&plan).json(identity, wanted)) } else { Ok(()) };
    }
    if let Some(other) = other.filter(|_| !yes) {
        return Err(Failure::Other(format!(
            "{other}; nothing was written; add --yes to write it nevertheless"
        )));
    }
    wait_for_standstill(drive)?;
    let report = carry_out(drive, plan.changes, wanted);
    let told = if json { say(report.json(identity, wanted)) } else { report.show() };
    match &report.restored.trouble {
        // What became of the drive is more than that nobody reads it.
        None => told,
        Some(trouble) => Err(Failure::Other(format!("{trouble}: {}", report.sum()))),
    }
}

fn nothing_written(trouble: DriveError) -> Failure {
    Failure::Other(format!("{trouble}; nothing was written"))
}

/// What differs between the drive the set is of and this one.
fn other_drive(Identity { model, gear }: Identity, origin: &Origin) -> Option<String> {
    let same_model = origin.model.as_ref().is_none_or(|name| *name == model.to_string());
    let same_gear = origin.gear.is_none_or(|ratio| ratio == gear.ratio());
    if same_model && same_gear {
        return None;
    }
    let known = Model::ALL.into_iter().find(|model| origin.model == Some(model.to_string()));
    let name = match (known, &origin.model) {
        (Some(model), _) => format!("an {}", model.product_name()),
        (None, Some(name)) => format!("a drive '{name}'"),
        (None, None) => "a drive".into(),
    };
    let ratio = origin.gear.map(|ratio| format!(" with gear {ratio}:1")).unwrap_or_default();
    let (here, gear) = (model.product_name(), gear.ratio());
    Some(format!("the file is of {name}{ratio}, this drive is an {here} with gear {gear}:1"))
}

/// The settings of this drive that the set says nothing of.
fn uncovered(identity: Identity, wanted: &ParameterSet) -> Vec<&'static Entry> {
    let is_there = |entry: &Entry| wanted.values.iter().any(|(other, _)| other.pnu == entry.pnu);
    parameters(identity.model).filter(|entry| is_setting(entry) && !is_there(entry)).collect()
}

/// Whether this drive can have all of it: nothing is written else.
fn fits(identity: Identity, wanted: &ParameterSet) -> Result<(), Failure> {
    let Identity { model, gear } = identity;
    let drive = format!("this {} with gear {}:1; nothing was written", model.product_name(), gear.ratio());
    for (parameter, value) in &wanted.values {
        let name = format!("{} (PNU {})", parameter.name, parameter.pnu);
        if entry(model, parameter.pnu).is_none() {
            return Err(Failure::Other(format!("{name} does not exist on {drive}")));
        }
        if let Some(range) =
            parameter.range(model, gear, Quirks::default()).filter(|range| !range.contains(*value))
        {
            return Err(Failure::Other(format!(
                "{name} is {value} in the file, but takes {range} on {drive}"
            )));
        }
    }
    Ok(())
}

fn read_all<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    wanted: &ParameterSet,
) -> Result<Vec<Value>, Failure> {
    let progress = watch("reading", wanted.values.len());
    let found = drive.read_wanted(&wanted.values, &mut || progress.inc(1));
    progress.finish_and_clear();
    if drive.is_stopped() {
        return Err(Failure::Other("interrupted; nothing was written".into()));
    }
    found.map_err(nothing_written)
}

/// Some parameters take no value while the shaft turns.
fn wait_for_standstill<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<(), Failure> {
    let begun = drive.session.now();
    while travels(drive).map_err(nothing_written)? {
        if drive.is_stopped() {
            return Err(Failure::Other("interrupted; nothing was written".into()));
        }
        if drive.session.now().saturating_since(begun) > RUN_OUT {
            return Err(Failure::Other("the drive does not come to rest; nothing was written".into()));
        }
    }
    Ok(())
}

/// What is to be done.
struct Plan {
    changes: Vec<Change>,
    total: usize,
    /// What positions count in before and after.
    lengths: (Lengths, Lengths),
}

impl Plan {
    fn of(wanted: &ParameterSet, found: &[Value]) -> Self {
        let changes = changes(&wanted.values, found);
        let pitch = Parameter::SpindlePitch.entry();
        let mut read = wanted.values.iter().zip(found);
        let before = read.find(|((entry, _), _)| entry.pnu == pitch.pnu).map(|(_, value)| *value);
        let after = wanted.values.iter().find(|(entry, _)| entry.pnu == pitch.pnu);
        let after = after.map(|(_, value)| Value::of(pitch.width, *value));
        let lengths = |pitch: Option<Value>| {
            pitch.map_or(Lengths::Unknown, |pitch| Lengths::of_spindle_pitch(pitch.bits()))
        };
        Self { changes, total: wanted.values.len(), lengths: (lengths(before), lengths(after.or(before))) }
    }

    fn show(&self) -> Result<(), Failure> {
        for Change { entry, before, after } in &self.changes {
            let before = in_words(entry, *before, self.lengths.0);
            let after = in_words(entry, *after, self.lengths.1);
            say(format_args!("{:<6} {:<27} {before} -> {after}", entry.pnu, entry.name))?;
        }
        match self.changes.len() {
            0 => say(format_args!("all {} parameters are as in the file", self.total)),
            count => say(format_args!("{count} of {} parameters differ", self.total)),
        }
    }
}

/// What became of all of it.
#[derive(Debug)]
pub(super) struct Report {
    pub(super) restored: Restored,
    total: usize,
}

/// Writes until it is done or something comes between, then reads everything back.
pub(super) fn carry_out<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    changes: Vec<Change>,
    wanted: &ParameterSet,
) -> Report {
    let progress = watch("writing", changes.len());
    let mut restored = drive.write_changes(changes, &mut || progress.inc(1));
    progress.finish_and_clear();
    let progress = watch("verifying", wanted.values.len());
    drive.verify(&wanted.values, &mut restored, &mut || progress.inc(1));
    progress.finish_and_clear();
    Report { restored, total: wanted.values.len() }
}

impl Report {
    /// For a drive that has everything, or shall only be looked at.
    fn nothing(plan: &Plan) -> Self {
        let outcomes = plan.changes.iter().map(|change| (*change, WriteOutcome::NotWritten)).collect();
        let restored = Restored { outcomes, verified: plan.changes.is_empty(), trouble: None };
        Self { restored, total: plan.total }
    }

    fn count(&self, of: impl Fn(&WriteOutcome) -> bool) -> usize {
        self.restored.outcomes.iter().filter(|(_, outcome)| of(outcome)).count()
    }

    /// `2 of 5 parameters that differ were written, 1 not confirmed, 2 not written; ...`
    pub(super) fn sum(&self) -> String {
        let all = self.restored.outcomes.len();
        let written = self.count(|outcome| *outcome == WriteOutcome::Written);
        let unconfirmed = self.count(|outcome| *outcome == WriteOutcome::Unconfirmed);
        let mut line = format!("{written} of {all} parameters that differ were written");
        if unconfirmed > 0 {
            line += &format!(", {unconfirmed} not confirmed");
        }
        line += &format!(", {} not written", all - written - unconfirmed);
        line + "; run restore again to write the rest"
    }

    fn show(&self) -> Result<(), Failure> {
        if self.restored.trouble.is_none() {
            let count = self.restored.outcomes.len();
            return say(format_args!("{count} written, all {} read back as in the file", self.total));
        }
        for (Change { entry, .. }, outcome) in &self.restored.outcomes {
            let reason = match outcome {
                WriteOutcome::Refused(reason) => format!("  {reason}"),
                WriteOutcome::Written | WriteOutcome::Unconfirmed | WriteOutcome::NotWritten => String::new(),
            };
            say(format_args!("{outcome:<14} {:<6} {}{reason}", entry.pnu, entry.name))?;
        }
        Ok(())
    }

    fn json(&self, identity: Identity, wanted: &ParameterSet) -> serde_json::Value {
        let changes: Vec<_> = self
            .restored
            .outcomes
            .iter()
            .map(|&(Change { entry, before, after }, ref outcome)| {
                json!({
                    "pnu": entry.pnu.number(),
                    "name": entry.name,
                    "before": entry.number(before),
                    "after": entry.number(after),
                    "outcome": outcome.to_string(),
                })
            })
            .collect();
        json!({
            "drive": about(identity),
            "file_drive": { "model": wanted.origin.model, "gear": wanted.origin.gear },
            "not_in_file": uncovered(identity, wanted).iter().map(|entry| entry.pnu.number()).collect::<Vec<_>>(),
            "total": self.total,
            "differing": changes,
            "verified": self.restored.verified,
            "trouble": self.restored.trouble,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::devices::ag03::param::Gear;

    use super::*;
    use crate::command::master::positioning::rig::{Cut, Rig};

    /// Some parameters of every kind: words, double words, with and without conditions.
    const CHANGED: [(Parameter, i32); 6] = [
        (Parameter::OperatingMode, 1),
        (Parameter::VPos, 77),
        (Parameter::VInch, 44),
        (Parameter::SpindlePitch, 200),
        (Parameter::Limit2, -123_456),
        (Parameter::LoopLength, 9),
    ];

    fn set(values: &[(Parameter, i32)]) -> ParameterSet {
        let mut values: Vec<_> =
            values.iter().map(|(parameter, value)| (parameter.entry(), *value)).collect();
        values.sort_by_key(|(entry, _)| entry.pnu);
        ParameterSet { origin: Origin::default(), values }
    }

    /// What `restore` does, without its page.
    fn restored(rig: &Rig, wanted: &ParameterSet, cut: Option<(usize, Cut)>) -> Report {
        let mut drive = rig.drive();
        let found = read_all(&mut drive, wanted).unwrap();
        let plan = Plan::of(wanted, &found);
        if let Some((telegrams, cut)) = cut {
            rig.cut(telegrams, cut);
        }
        carry_out(&mut drive, plan.changes, wanted)
    }

    /// The report says of each parameter what is the case.
    fn assert_true(rig: &Rig, report: &Report, context: &str) {
        assert_eq!(report.restored.outcomes.len(), CHANGED.len(), "{context}");
        for (change, outcome) in &report.restored.outcomes {
            let (parameter, _) =
                CHANGED.into_iter().find(|(parameter, _)| parameter.entry().pnu == change.entry.pnu).unwrap();
            let has = i64::from(rig.value(parameter));
            let (before, after) = (change.entry.number(change.before), change.entry.number(change.after));
            match outcome {
                WriteOutcome::Written => assert_eq!(has, after, "{context}: {parameter}"),
                WriteOutcome::NotWritten | WriteOutcome::Refused(_) => {
                    assert_eq!(has, before, "{context}: {parameter}")
                }
                WriteOutcome::Unconfirmed => assert!(has == before || has == after, "{context}: {parameter}"),
            }
        }
        // Nothing is written behind the first that was not.
        let written: Vec<bool> =
            report.restored.outcomes.iter().map(|(_, outcome)| *outcome == WriteOutcome::Written).collect();
        assert!(written.is_sorted_by(|a, b| a >= b), "{context}: {written:?}");
        let all = written.iter().all(|written| *written);
        assert!(!report.restored.verified || all && report.restored.trouble.is_none(), "{context}");
        assert_eq!(
            report.restored.verified,
            report.restored.trouble.is_none(),
            "{context}: {:?}",
            report.restored.trouble
        );
    }

    #[test]
    fn interrupted_at_any_telegram_it_says_what_was_written_and_what_was_not() {
        for cut in [Cut::Stop, Cut::Link, Cut::Answers] {
            let (mut telegrams, mut unconfirmed, mut counts) = (0, 0, Vec::new());
            loop {
                let rig = Rig::new(Model::Ag03_1);
                let report = restored(&rig, &set(&CHANGED), Some((telegrams, cut)));
                assert_true(&rig, &report, &format!("{cut:?} at {telegrams}"));
                unconfirmed += report.count(|outcome| *outcome == WriteOutcome::Unconfirmed);
                counts.push(report.count(|outcome| *outcome == WriteOutcome::Written));
                if rig.is_whole() {
                    assert!(report.restored.verified, "{:?}", report.restored.trouble);
                    break;
                }
                telegrams += 1;
            }
            assert!(telegrams > 20, "{cut:?}: only {telegrams} telegrams");
            assert!(counts.is_sorted(), "{counts:?}");
            assert_eq!(counts.last(), Some(&CHANGED.len()));
            // A job that is under way is finished before Ctrl-C counts.
            assert_eq!(unconfirmed > 0, cut != Cut::Stop, "{cut:?}");
        }
    }

    #[test]
    fn a_refused_value_ends_it_and_leaves_the_rest() {
        for refused in 0..CHANGED.len() {
            let mut values = CHANGED;
            values[refused].1 = 20_000_000;
            let rig = Rig::new(Model::Ag03_1);
            let report = restored(&rig, &set(&values), None);
            assert_true(&rig, &report, &format!("refused {refused}"));
            assert_eq!(report.count(|outcome| matches!(outcome, WriteOutcome::Refused(_))), 1);
            assert!(
                report.sum().starts_with(&format!("{refused} of 6 parameters that differ")),
                "{}",
                report.sum()
            );
            assert!(report.restored.trouble.unwrap().contains("error 2"));
        }
    }

    #[test]
    fn a_whole_set_is_what_the_drive_had_before_a_factory_reset() {
        for model in Model::ALL {
            let rig = Rig::new(model);
            let mut drive = rig.drive();
            for (parameter, value) in CHANGED {
                let entry = parameter.entry();
                drive.write(entry.pnu, Value::of(entry.width, value)).unwrap();
            }
            let settings: Vec<_> = Parameter::all()
                .filter(|parameter| entry(model, parameter.entry().pnu).is_some())
                .map(|parameter| (parameter, rig.value(parameter)))
                .collect();
            drive.write(crate::devices::ag03::param::Pnu::from_low_bits(970), Value::Word(1)).unwrap();
            assert_eq!(rig.value(Parameter::VPos), 30);
            drop(drive);
            let report = restored(&rig, &set(&settings), None);
            assert!(report.restored.verified, "{:?}", report.restored.trouble);
            assert_eq!(report.restored.outcomes.len(), CHANGED.len(), "only what differs is written");
            for (parameter, value) in settings {
                assert_eq!(rig.value(parameter), value, "{parameter}");
            }
        }
    }

    #[test]
    fn a_set_of_another_drive_is_refused_before_anything_is_written() {
        let (model, gear) = (Model::Ag03, Gear::Ratio48);
        for (values, says) in [
            (
                [(Parameter::DPos, 50)],
                "d-Pos (PNU 1039) does not exist on this AG03 with gear 48:1; nothing was written",
            ),
            ([(Parameter::VPos, 150)], "v-Pos (PNU 1004) is 150 in the file, but takes 1..100 on this AG03"),
        ] {
            let Err(Failure::Other(line)) = fits(Identity { model, gear }, &set(&values)) else {
                panic!("fits")
            };
            assert!(line.contains(says), "{line}");
        }
    }

    #[test]
    fn a_set_of_another_kind_of_drive_is_written_only_when_asked_twice() {
        let origin = |model: &str, gear| Origin { model: Some(model.into()), gear };
        let (yes, no) = (How { dry_run: false, yes: true }, How { dry_run: false, yes: false });
        let wrong =
            "the file is of an AG03 with gear 24:1, this drive is an AG03/1 with gear 48:1; nothing was";
        for (origin, how, says) in [
            (origin("ag03", Some(24)), no, Some(wrong)),
            (origin("ag03-1", Some(24)), no, Some("the file is of an AG03/1 with gear 24:1, this drive")),
            (origin("ag04", None), no, Some("the file is of a drive 'ag04', this drive is an AG03/1")),
            (origin("ag03", Some(24)), How { dry_run: true, yes: false }, None),
            (origin("ag03", Some(24)), yes, None),
            (origin("ag03-1", Some(48)), no, None),
            (Origin { model: None, gear: Some(48) }, no, None),
            (Origin::default(), no, None),
        ] {
            let rig = Rig::new(Model::Ag03_1);
            let wanted = ParameterSet { origin, ..set(&CHANGED) };
            let outcome = restore(&mut rig.drive(), &wanted, how, true);
            match (outcome, says) {
                (Err(Failure::Other(line)), Some(says)) => assert!(line.contains(says), "{line}"),
                (Ok(()), None) => {}
                (outcome, _) => panic!("{outcome:?}, expected {says:?}"),
            }
            let written = rig.value(Parameter::VPos) == 77;
            assert_eq!(written, says.is_none() && !how.dry_run, "{:?}", wanted.origin);
        }
    }

    #[test]
    fn the_settings_that_a_set_says_nothing_of_are_named() {
        let identity = Identity { model: Model::Ag03_1, gear: Gear::Ratio48 };
        let kept = uncovered(identity, &set(&CHANGED));
        assert_eq!(kept.len(), 25 - CHANGED.len());
        assert!(kept.iter().all(|entry| is_setting(entry)));
    }
}
