//! Devices: their specifications, and what their inputs follow.

use std::path::Path;

use crate::host::list::inputs::{self, Direction};
use crate::host::list::{self, Group, Spec};
use crate::process::{Elsewhere, What};

use super::tables::{At, DeviceTable, LineTable};
use super::wrong::{TablePath, Wrong};
use crate::command::args::Emulate;
use crate::command::emulate::{LinePlan, SlavePlan};

/// The specification of each device of a group.
fn specs(
    (line, folder): (usize, &Path),
    table: &LineTable,
    group: Group,
) -> Result<Vec<(usize, TablePath, Spec)>, Wrong> {
    let spec = |(number, table): (usize, &At<DeviceTable>)| {
        let path = TablePath::new(line, group, number);
        match Spec::read(group, &table.get().given, folder) {
            Ok(spec) => Ok((table.span().start, path, spec)),
            Err(wrong) => Err(Wrong::of_spec(&path, wrong)),
        }
    };
    table.of(group).enumerate().map(spec).collect()
}

/// Everybody on a line of PROFIBUS; `args` has what all have.
pub(super) fn slaves(
    place: (usize, &Path),
    table: &LineTable,
    args: &Emulate,
) -> Result<Vec<SlavePlan>, Wrong> {
    let mut all = Vec::new();
    for group in Group::ALL.into_iter().filter(|group| !group.is_on_can()) {
        all.extend(specs(place, table, group)?);
    }
    distinct(
        &mut all.iter().map(|(start, path, spec)| (*start, path, spec)).collect(),
        "stations have address",
    )?;
    let mut plans = Vec::new();
    for (_, path, mut spec) in all.drain(..) {
        // Known to be right: those of the line are checked.
        let _ = args.choose_quirks(&mut spec);
        plans.push(SlavePlan::new(spec).map_err(|wrong| Wrong::of_spec(&path, wrong))?);
    }
    Ok(plans)
}

/// Whether what the inputs of each line follow on the others and on their own is there.
pub(super) fn check_followed(plans: &[LinePlan]) -> Result<(), Wrong> {
    for (number, plan) in plans.iter().enumerate() {
        let is_station = |slave: &&SlavePlan| slave.spec.device.group() == Group::Station;
        for (place, slave) in plan.slaves.iter().filter(is_station).enumerate() {
            let table = TablePath::new(number, Group::Station, place);
            for (input, elsewhere) in slave.prepared.followed() {
                let followed = followed(plans, number, elsewhere);
                followed.map_err(|wrong| wrong_within(&table, "input", input, wrong))?;
            }
        }
        for (place, spec) in plan.args.nodes().iter().enumerate() {
            let table = TablePath::new(number, Group::Node, place);
            let signals = spec.signals().map_err(|wrong| Wrong::of_spec(&table, wrong))?;
            for (value, signal) in signals.iter().enumerate() {
                for elsewhere in signal.elsewhere() {
                    let followed = followed(plans, number, elsewhere);
                    followed.map_err(|wrong| wrong_within(&table, "value", value, wrong))?;
                }
            }
        }
    }
    Ok(())
}

/// What is wrong with an entry of a list of a device.
fn wrong_within(table: &TablePath, list: &str, place: usize, wrong: list::Wrong) -> Wrong {
    let path = [list.to_owned(), place.to_string()].into_iter().chain(wrong.path).collect();
    Wrong::of_spec(table, list::Wrong { path, ..wrong })
}

/// Whether a value is there, for an input of the line of this number, from 0.
fn followed(plans: &[LinePlan], own: usize, elsewhere: &Elsewhere) -> Result<(), list::Wrong> {
    let wrong = |key: &str, words| list::Wrong { path: vec![key.to_owned()], is_key: false, words };
    let Elsewhere { line, station, what } = elsewhere;
    let number = line.map_or(own, |line| usize::from(line).wrapping_sub(1));
    let Some(plan) = plans.get(number) else {
        let words = format!("there is no line {}; expected 1 to {}", number.wrapping_add(1), plans.len());
        return Err(wrong("line", words));
    };
    if plan.args.nodes().iter().any(|node| node.place == *station) && matches!(what, What::Value(_)) {
        return Ok(());
    }
    let Some(slave) = plan.slaves.iter().find(|slave| slave.spec.place == *station) else {
        let nodes = plan.args.nodes().iter().map(|node| node.place);
        let there = plan.slaves.iter().map(|slave| slave.spec.place).chain(nodes);
        let there: Vec<_> = there.map(|place| place.to_string()).collect();
        let on = if number == own { "this line".into() } else { format!("line {}", number + 1) };
        let words = format!("there is no station {station} on {on}; expected one of {}", there.join(", "));
        return Err(wrong("station", words));
    };
    match (what, &slave.prepared.station) {
        (What::Value(_), _) => Ok(()),
        (What::Output(point), Some(gsd)) => inputs::check(gsd, *point, Direction::Output).map_err(|wrong| {
            let path = ["of".to_owned()].into_iter().chain(wrong.path).collect();
            list::Wrong { path, ..wrong }
        }),
        (What::Output(_), None) => {
            let words =
                format!("station {station} has no slots; name one of its values, of = {{ value = \"...\" }}");
            Err(wrong("of", words))
        }
    }
}

/// The nodes of a CAN bus.
pub(super) fn nodes(place: (usize, &Path), table: &LineTable) -> Result<Vec<Spec>, Wrong> {
    let all = specs(place, table, Group::Node)?;
    let alone = all.iter().filter(|(_, _, spec)| !spec.choices.flag("twin"));
    distinct(&mut alone.map(|(start, path, spec)| (*start, path, spec)).collect(), "nodes have the number")?;
    for (_, path, spec) in &all {
        spec.signals().map_err(|wrong| Wrong::of_spec(path, wrong))?;
    }
    Ok(all.into_iter().map(|(_, _, spec)| spec).collect())
}

/// No two at one place.
fn distinct(all: &mut Vec<(usize, &TablePath, &Spec)>, what: &str) -> Result<(), Wrong> {
    all.sort_by_key(|(start, _, _)| *start);
    for (before, (_, path, spec)) in all.iter().enumerate() {
        if all.iter().take(before).any(|(_, _, other)| other.place == spec.place) {
            return Err(Wrong::at_place(path, spec, format!("two {what} {}; give each its own", spec.place)));
        }
    }
    Ok(())
}
