//! `read`, `write`, `params`.

use crate::client::PkwError;
use crate::devices::ag03::param::{
    Access, Entry, Gear, Model, Quirks, Range, Subindex, Value, entry, parameters,
};
use crate::explain::value::Lengths;
use crate::host::list::named::ParameterSpec;
use crate::host::{Clock, Link};
use crate::master::{Drive, Identity};
use crate::profibus::pkw::ErrorNumber;
use serde_json::json;

use super::value::{Item, fits, is_length, lengths, lengths_in, number_of};
use crate::command::Failure;
use crate::command::args::Quantity;
use crate::command::master::device::Shown;
use crate::command::master::trouble::Trouble;
use crate::command::master::{say, watch};

/// Whether a write can be right for any drive. `command` is whose help says more.
pub(super) fn check(parameter: &ParameterSpec, value: i64, command: &str) -> Result<(), Failure> {
    let entry = parameter.entry;
    let usage =
        |line: String| Err(Failure::Usage(format!("{line}; see 'profidrive master {command} --help'")));
    match entry.access() {
        Access::ReadOnly => return usage(format!("{} (PNU {}) can only be read", entry.name, entry.pnu)),
        Access::ReadWrite | Access::WriteOnly => {}
    }
    let drives = Model::ALL.into_iter().flat_map(|model| Gear::ALL.map(|gear| (model, gear)));
    let ranges: Vec<Range> =
        drives.filter_map(|(model, gear)| entry.range(model, gear, Quirks::default())).collect();
    let low = ranges.iter().map(|range| range.low).min().unwrap_or(i32::MIN);
    let high = ranges.iter().map(|range| range.high).max().unwrap_or(i32::MAX);
    if !(i64::from(low)..=i64::from(high)).contains(&value) {
        return usage(format!("{} (PNU {}) takes {low} to {high}, got {value}", entry.name, entry.pnu));
    }
    Ok(())
}

/// One parameter.
pub(super) fn read<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    parameter: &ParameterSpec,
    json: bool,
) -> Result<(), Failure> {
    let item = Item::read(drive, parameter.entry, parameter.element)
        .map_err(|trouble| refusal(drive, trouble, parameter.entry, None))?;
    let lengths = if is_length(parameter.entry) { lengths(drive)? } else { Lengths::Unknown };
    item.shown(lengths).say(json)
}

/// Writes, reads back, and says both.
pub(super) fn write<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    parameter: &ParameterSpec,
    wanted: Quantity,
    json: bool,
) -> Result<(), Failure> {
    let entry = parameter.entry;
    let number = number_of(&wanted, entry)?;
    if is_length(entry) {
        fits(&wanted, lengths(drive)?)?;
    }
    let is_command = entry.access() == Access::WriteOnly;
    let before = if is_command { None } else { Some(Item::read(drive, entry, None)) };
    let before = before.transpose().map_err(|trouble| refusal(drive, trouble, entry, Some(number)))?;
    let value = Value::of(entry.width, i32::try_from(number).unwrap_or(i32::MAX));
    drive.write(entry.pnu, value).map_err(|trouble| refusal(drive, trouble, entry, Some(number)))?;
    let Some(before) = before else {
        let done = Item { entry, element: None, value }.shown(Lengths::Unknown);
        return Shown { text: format!("{} done", done.text), ..done }.say(json);
    };
    let after = Item::read(drive, entry, None)?;
    let lengths = if is_length(entry) { lengths(drive)? } else { Lengths::Unknown };
    if after.value != value {
        return Err(Failure::Other(format!(
            "{} (PNU {}) was written, but reads back as {} instead of {number}",
            entry.name,
            entry.pnu,
            after.number()
        )));
    }
    after.shown(lengths).say_changed(&before.shown(lengths), "", json)
}

/// Everything.
pub(super) fn params<L: Link, C: Clock>(drive: &mut Drive<L, C>, json: bool) -> Result<(), Failure> {
    let identity = drive.identify()?;
    let all: Vec<_> = parameters(identity.model).flat_map(places).collect();
    let progress = watch("reading", all.len());
    let mut items = Vec::new();
    for (entry, element) in all {
        if drive.is_stopped() {
            return Err(Failure::Other("interrupted".into()));
        }
        items.push(Item::read(drive, entry, element)?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let lengths = lengths_in(&items);
    if json {
        let parameters: Vec<_> = items.iter().map(|item| item.json(lengths)).collect();
        return say(format_args!("{:#}", json!({ "drive": about(identity), "parameters": parameters })));
    }
    for item in items {
        say(item.row(lengths))?;
    }
    Ok(())
}

/// The parameter, or each element of an array. A command has nothing to read.
fn places(entry: &'static Entry) -> Vec<(&'static Entry, Option<Subindex>)> {
    match (entry.access(), entry.elements) {
        (Access::WriteOnly, _) => Vec::new(),
        (Access::ReadOnly | Access::ReadWrite, None) => vec![(entry, None)],
        (Access::ReadOnly | Access::ReadWrite, Some(count)) => {
            (0..count).map(|element| (entry, Some(Subindex(element)))).collect()
        }
    }
}

/// Which drive it is, as JSON.
pub(super) fn about(Identity { model, gear }: Identity) -> serde_json::Value {
    json!({ "model": model.to_string(), "gear": gear.ratio() })
}

/// What a refused access means for somebody who looks at this drive.
pub(super) fn refusal<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    trouble: impl Into<Trouble>,
    parameter: &Entry,
    value: Option<i64>,
) -> Failure {
    let trouble = trouble.into();
    let Some(PkwError::Refused(code)) = trouble.job() else {
        return trouble.into();
    };
    let name = format!("{} (PNU {})", parameter.name, parameter.pnu);
    let line = match (ErrorNumber::from_number(code.number()), drive.identify()) {
        (Some(ErrorNumber::IllegalParameterNumber), Ok(Identity { model, .. })) => {
            let here = entry(model, parameter.pnu).is_some();
            let reason = if here { "the drive has no" } else { "only the AG03/1 has" };
            format!("{reason} {name}; this drive is an {}", model.product_name())
        }
        (Some(ErrorNumber::LimitExceeded), Ok(Identity { model, gear })) => {
            let range =
                parameter.range(model, gear, Quirks::default()).map(|range| format!(", it takes {range}"));
            let got = value.map(|value| format!(", got {value}")).unwrap_or_default();
            let drive = format!("{} with gear {}:1", model.product_name(), gear.ratio());
            format!("the drive refuses {name}: {code}{} on an {drive}{got}", range.unwrap_or_default())
        }
        (Some(ErrorNumber::OperatingState), _) => {
            format!("the drive refuses {name} now: {code}; wait until it stands still and no job is active")
        }
        (_, _) => format!("the drive refuses {name}: {code}"),
    };
    Failure::Other(line)
}
