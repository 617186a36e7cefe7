//! Devices: their specifications, and what moves the inputs of stations.

use std::path::Path;

use crate::host::list::{Group, Spec};

use super::station::{self, Stations};
use super::tables::{At, DeviceTable, LineTable, OfGroup};
use super::wrong::{TablePath, Wrong};
use crate::command::args::Emulate;
use crate::command::emulate::SlavePlan;

/// The specification of each device of a group.
fn specs<G: OfGroup>(
    (line, folder): (usize, &Path),
    tables: &[At<DeviceTable<G>>],
) -> Result<Vec<(usize, TablePath, Spec)>, Wrong> {
    let spec = |(number, table): (usize, &At<DeviceTable<G>>)| {
        let path = TablePath::new(line, G::GROUP, number);
        match Spec::read(G::GROUP, &table.get().given, folder) {
            Ok(spec) => Ok((table.span().start, path, spec)),
            Err(wrong) => Err(Wrong::of_spec(&path, wrong)),
        }
    };
    tables.iter().enumerate().map(spec).collect()
}

/// Everybody on a line of PROFIBUS; `args` has what all have.
pub(super) fn slaves(
    place: (usize, &Path),
    table: &LineTable,
    args: &Emulate,
) -> Result<Vec<SlavePlan>, Wrong> {
    let drives = specs(place, &table.drive)?;
    let ppo_drives = specs(place, &table.ppo_drive)?;
    let stations = specs(place, &table.station)?;
    let mut all: Vec<_> = drives.into_iter().chain(ppo_drives).chain(stations).collect();
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
    let stations = Stations::of(&plans);
    let mut inputs = Vec::new();
    for (number, table) in table.station.iter().enumerate() {
        inputs.push(station::signals(&table.get().input, number, &stations, place.1)?);
    }
    let is_station = |plan: &&mut SlavePlan| plan.spec.device.group() == Group::Station;
    for (plan, signals) in plans.iter_mut().filter(is_station).zip(inputs) {
        plan.prepared.signals = signals;
    }
    Ok(plans)
}

/// The nodes of a CAN bus.
pub(super) fn nodes(place: (usize, &Path), table: &LineTable) -> Result<Vec<Spec>, Wrong> {
    let all = specs(place, &table.node)?;
    let alone = all.iter().filter(|(_, _, spec)| !spec.choices.flag("twin"));
    distinct(&mut alone.map(|(start, path, spec)| (*start, path, spec)).collect(), "nodes have the number")?;
    for (_, path, spec) in &all {
        spec.product().map_err(|wrong| Wrong::of_spec(path, wrong))?;
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
