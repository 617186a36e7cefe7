//! Drives and nodes: what they are, their quirks, what their parameters begin with.

use std::collections::BTreeMap;
use std::path::Path;

use profidrive::devices::ag03::param::{Access, Model, Pnu, Value, Width};
use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::devices::ppo_drive::table::Table;
use profidrive::profibus::fdl::Address;
use profidrive::time::Instant;

use super::line::spec;
use super::tables::{At, DriveTable, NodeTable, PpoDriveTable};
use super::wrong::{Wrong, words};
use crate::command::args::{DriveSpec, NodeSpec, PpoDriveSpec, QuirkSpec, find_parameter, quirk_refusal};
use crate::command::emulate::{DrivePlan, PpoDrivePlan, ppo_drive};
use crate::command::named;

/// Quirks of drives, each checked.
pub(super) fn quirks(table: &BTreeMap<String, At<String>>) -> Result<Vec<QuirkSpec>, Wrong> {
    let quirk = |(name, value): (&String, &At<String>)| {
        format!("{name}={}", value.get()).parse().map_err(|error| Wrong::at(value.span(), error))
    };
    table.iter().map(quirk).collect()
}

/// A drive; `common` are the quirks of all.
pub(super) fn plan(table: &DriveTable, common: &[QuirkSpec]) -> Result<DrivePlan, Wrong> {
    let gear = table.gear.as_ref().map(At::in_words);
    let spec: DriveSpec = spec(&table.address, [("model", table.model.clone()), ("gear", gear), ("", None)])?;
    let quirks = common.iter().cloned().chain(quirks(&table.quirks)?).collect();
    let mut plan = DrivePlan { spec, quirks, values: Vec::new() };
    let config = plan.config(Config::new(spec.address));
    let config = config.map_err(|failure| Wrong::at(table.address.span(), words(failure)))?;
    // One that nobody sees takes the values first.
    let mut trial = Device::new(config, Instant::ZERO);
    for (name, value) in &table.values {
        let wrong = |words: String| Wrong::at(value.span(), words);
        let (pnu, value) = first_value(name, *value.get(), spec.model).map_err(wrong)?;
        let written = trial.write_parameter(Instant::ZERO, pnu, None, value);
        written.map_err(|error| wrong(format!("'{name}': {error}")))?;
        plan.values.push((pnu, value));
    }
    Ok(plan)
}

fn first_value(name: &str, number: i64, model: Model) -> Result<(Pnu, Value), String> {
    let entry = find_parameter(name)?;
    match entry.access() {
        Access::ReadWrite => {}
        Access::ReadOnly | Access::WriteOnly => {
            return Err(format!("{} (PNU {}) is no setting; leave it out", entry.name, entry.pnu));
        }
    }
    if profidrive::devices::ag03::param::entry(model, entry.pnu).is_none() {
        return Err(format!("an {} has no {} (PNU {})", model.product_name(), entry.name, entry.pnu));
    }
    let fits = match entry.width {
        Width::Word => u16::try_from(number).is_ok() || i16::try_from(number).is_ok(),
        Width::Double => true,
    };
    let number = i32::try_from(number).ok().filter(|_| fits);
    let number =
        number.ok_or_else(|| format!("the value does not fit in {} (PNU {})", entry.name, entry.pnu))?;
    Ok((entry.pnu, Value::of(entry.width, number)))
}

/// A drive of the profile.
pub(super) fn ppo_plan(table: &PpoDriveTable, folder: &Path) -> Result<PpoDrivePlan, Wrong> {
    let ppo = table.ppo.as_ref().map(At::in_words);
    let mut drive: PpoDriveSpec =
        spec(&table.address, [("ppo", ppo), ("ident", table.ident.clone()), ("", None)])?;
    drive.gsd = table.gsd.as_ref().map(|file| folder.join(file.get()));
    if let (Some(ident), Err(error)) = (&table.ident, drive.check()) {
        return Err(Wrong::at(ident.span(), error));
    }
    let slave = ppo_drive::slave(&drive).map_err(|failure| {
        Wrong::at(table.gsd.as_ref().map_or_else(|| table.address.span(), At::span), words(failure))
    })?;
    let mut parameters = match &table.parameters {
        Some(file) => ppo_drive::parameters(&folder.join(file.get()))
            .map_err(|failure| Wrong::at(file.span(), words(failure)))?,
        None => Table::profile(),
    };
    for (name, value) in &table.values {
        let wrong = |words: String| Wrong::at(value.span(), words);
        let (pnu, element) =
            named::find(&parameters, name).map(|(row, element)| (row.pnu, element)).map_err(wrong)?;
        let begun = parameters.begin_with(pnu, element, *value.get());
        begun.map_err(|error| wrong(format!("'{name}': {error}")))?;
        ppo_drive::try_out(&parameters).map_err(wrong)?;
    }
    let address: Address = drive.address;
    Ok(PpoDrivePlan { address, slave, only: drive.ppo, table: parameters })
}

/// A node of CANopen.
pub(super) fn node(table: &NodeTable) -> Result<NodeSpec, Wrong> {
    let gear = table.gear.as_ref().map(At::in_words);
    let mut node: NodeSpec =
        spec(&table.id, [("device", table.device.clone()), ("mode", table.mode.clone()), ("gear", gear)])?;
    for (name, value) in &table.quirks {
        let mut choices = node.choices;
        node.product.choose(&mut choices, name, value.get()).map_err(|error| {
            let known: Vec<_> = node.product.quirks().iter().map(|row| row.name).collect();
            let words = match error {
                profidrive::face::QuirkError::Unknown => {
                    format!(
                        "an {} has no quirk '{name}'; expected one of {}",
                        node.product.name,
                        known.join(", ")
                    )
                }
                profidrive::face::QuirkError::Value { .. } => quirk_refusal(name, value.get(), &error),
            };
            Wrong::at(value.span(), words)
        })?;
        node.quirks.push(format!("{name}={}", value.get()));
    }
    Ok(node)
}
