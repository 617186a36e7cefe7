//! A station that is added, by the specification that line files have (docs/line.md).

use std::path::Path;

use axum::Json;
use axum::extract::State as Shared;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;

use super::Summary;
use crate::host::fault::BusKind;
use crate::host::list::inputs::file_of;
use crate::host::list::{DEVICES, Device, Given, Group, Spec, Takes};
#[cfg(test)]
use crate::panel::description::Problems;
use crate::panel::line::{Line, Lines};
use crate::panel::problem::{Body, Problem};

/// A station to add: `{"address": 6, "device": "ag03-1"}` with what else is chosen about it, or `{"drive": {..}}`,
/// `{"ppo-drive": {..}}`, `{"station": {..}}`, `{"node": {..}}` as in a line file; `line` where there are several.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(in crate::panel) struct NewStation(Given);

impl NewStation {
    /// The name of its line.
    fn line(&self) -> Result<Option<String>, Problem> {
        match self.entries()?.iter().find(|(key, _)| key == "line") {
            Some((_, Given::Text(name))) => Ok(Some(name.clone())),
            Some((_, other)) => Err(Problem::value(format!("line must be the name of a line, got {other}"))),
            None => Ok(None),
        }
    }

    fn entries(&self) -> Result<&[(String, Given)], Problem> {
        let Given::Table(entries) = &self.0 else {
            return Err(Problem::value("the body must be a JSON object, {...}"));
        };
        Ok(entries)
    }

    /// The specification, for this line.
    fn spec(&self, line: &Line) -> Result<Spec, Problem> {
        let bus = line.kind;
        let entries: Vec<_> = self.entries()?.iter().filter(|(key, _)| key != "line").cloned().collect();
        let of_key = |key: &str| Group::ALL.into_iter().find(|group| group.name() == key.replace('_', "-"));
        let (group, given) = match &*entries {
            [(key, given @ Given::Table(_))] if of_key(key).is_some() => {
                (of_key(key).unwrap_or(Group::Drive), given.clone())
            }
            _ => Self::named(bus, entries)?,
        };
        // Before any is read.
        let folders = files(group, &given).into_iter().map(|(key, name)| line.folder(&key, &name));
        let folders: Vec<_> = folders.collect::<Result<_, _>>()?;
        let folder = folders.first().map_or(Path::new(""), |folder| folder);
        Spec::of_given(group, &given, folder).map_err(|wrong| Problem::value(wrong.words))
    }

    /// A device by its name, and its group.
    fn named(bus: BusKind, mut entries: Vec<(String, Given)>) -> Result<(Group, Given), Problem> {
        let usual = if bus == BusKind::Can { Group::Node } else { Group::Drive };
        let is_name = |key: &str| key == "device" || key == "model";
        let named = entries.iter_mut().find(|(key, _)| is_name(key));
        let group = named.map_or(usual, |(key, name)| {
            let name = format!("{name}");
            let is_here = |device: &&Device| {
                device.name() == name && (device.group() == Group::Node) == (bus == BusKind::Can)
            };
            let group = DEVICES.iter().find(is_here).map_or(usual, Device::group);
            group.device_key().clone_into(key);
            group
        });
        Ok((group, Given::Table(entries)))
    }
}

/// The files that a specification names, with their keys.
fn files(group: Group, given: &Given) -> Vec<(String, String)> {
    let Given::Table(table) = given else { return Vec::new() };
    let choices = group.choices();
    let takes = |key: &str| choices.iter().find(|choice| choice.is(key)).map(|choice| choice.takes);
    let mut files = Vec::new();
    for (key, value) in table {
        match (takes(key), value) {
            (Some(Takes::File(_)), name) => files.push((key.clone(), name.to_string())),
            (Some(Takes::Inputs), Given::List(inputs)) => {
                files.extend(inputs.iter().filter_map(file_of).map(|name| (key.clone(), name)));
            }
            (Some(_) | None, _) => {}
        }
    }
    files
}

/// Adds a station
///
/// A new one with factory settings, or, where memories are kept, the one of this device that had this address.
#[cfg_attr(test, utoipa::path(post, path = "/api/v1/stations", tag = "stations", request_body = NewStation,
    responses((status = 201, body = Summary, headers(("location" = String, description = "Where its state is"))), Problems)))]
pub(in crate::panel) async fn add(
    Shared(lines): Shared<Lines>,
    Body(new): Body<NewStation>,
) -> Result<Response, Problem> {
    let line = match new.line()? {
        Some(name) => lines.named(&name)?,
        None => only(&lines)?,
    };
    let spec = new.spec(&line)?;
    let name = line.name.clone();
    let summary = line.asking.ask(move |lent| {
        let address = lent.add(spec)?;
        Ok::<_, Problem>((address, Summary::of(&name, lent, address)))
    });
    let (address, summary) = summary.await??;
    let location = format!("/api/v1/lines/{}/stations/{address}", line.name);
    let location = HeaderValue::try_from(location).map_err(Problem::value)?;
    Ok((StatusCode::CREATED, [(header::LOCATION, location)], Json(summary)).into_response())
}

/// The only line.
fn only(lines: &Lines) -> Result<Line, Problem> {
    let mut all = lines.all();
    let names: Vec<String> = all.iter().map(|line| line.name.to_string()).collect();
    match (all.pop(), all.is_empty()) {
        (Some(line), true) => Ok(line),
        (Some(_), false) | (None, _) => {
            Err(Problem::value(format!("'line' is missing; there are the lines {}", names.join(", "))))
        }
    }
}
