//! Faults on purpose of a line of either bus: listed, added, replaced, removed.

use axum::Json;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};

#[cfg(test)]
use super::super::description::Problems;
use super::super::problem::{Body, PathOf, Problem};
use super::OnLine;
use crate::host::fault::{Listed, Rule};
use crate::panel::routes::OfLineName;

/// Faults of a line at most.
const MOST_FAULTS: usize = 32;

/// A fault on the line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct FaultState {
    /// Its number, with which it is removed.
    number: u32,
    /// As on the command line, `emulate --fault`.
    fault: String,
    /// How often it was injected.
    injected: u32,
    /// Whether its times and its condition let it act now.
    may_act: bool,
}

impl From<Listed> for FaultState {
    fn from(listed: Listed) -> Self {
        let Listed { number, rule, injected, may_act } = listed;
        Self { number, fault: rule.to_string(), injected, may_act }
    }
}

/// The faults on the line.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct FaultList {
    faults: Vec<FaultState>,
}

/// A fault to add.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(in crate::panel) struct NewFault {
    /// As for `emulate --fault` (docs/faults.md).
    #[cfg_attr(test, schema(example = "late=20ms,station=5"))]
    fault: String,
}

/// All faults that are to act.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(in crate::panel) struct NewFaults {
    /// Each as for `emulate --fault`.
    #[cfg_attr(test, schema(example = json!(["no-reply,rate=0.1"]), max_items = 32))]
    faults: Vec<String>,
}

/// The faults on the line
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/faults", tag = "lines", responses((status = 200, body = FaultList), Problems)))]
pub(in crate::panel) async fn list(OfLineName(line): OfLineName) -> Result<Json<FaultList>, Problem> {
    line.asking.ask(|lent| Ok(Json(FaultList { faults: states(lent)? }))).await?
}

/// Adds a fault to the line
#[cfg_attr(test, utoipa::path(post, path = "/api/v1/lines/{line}/faults", tag = "lines", request_body = NewFault,
    responses((status = 201, body = FaultState), Problems)))]
pub(in crate::panel) async fn add(
    OfLineName(line): OfLineName,
    Body(NewFault { fault }): Body<NewFault>,
) -> Result<(StatusCode, Json<FaultState>), Problem> {
    let added = line.asking.ask(move |lent| {
        let rule = read(lent, &fault)?;
        lent.check_fault(&rule)?;
        add_one(lent, rule)
    });
    Ok((StatusCode::CREATED, Json(added.await??)))
}

/// Replaces all faults on the line
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/faults", tag = "lines", request_body = NewFaults,
    responses((status = 200, body = FaultList), Problems)))]
pub(in crate::panel) async fn replace(
    OfLineName(line): OfLineName,
    Body(NewFaults { faults }): Body<NewFaults>,
) -> Result<Json<FaultList>, Problem> {
    if faults.len() > MOST_FAULTS {
        return Err(Problem::value(format!(
            "at most {MOST_FAULTS} faults are possible, got {}",
            faults.len()
        )));
    }
    let replaced = line.asking.ask(move |lent| {
        let rules: Vec<Rule> = faults.iter().map(|fault| read(lent, fault)).collect::<Result<_, _>>()?;
        rules.iter().try_for_each(|rule| lent.check_fault(rule))?;
        remove_all(lent)?;
        for rule in rules {
            add_one(lent, rule)?;
        }
        Ok(Json(FaultList { faults: states(lent)? }))
    });
    replaced.await?
}

/// Removes all faults of the line
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/faults", tag = "lines", responses((status = 204), Problems)))]
pub(in crate::panel) async fn clear(OfLineName(line): OfLineName) -> Result<StatusCode, Problem> {
    let cleared = line.asking.ask(|lent| {
        remove_all(lent)?;
        tracing::info!("all faults on purpose are taken off the {}", lent.kind().name());
        Ok(StatusCode::NO_CONTENT)
    });
    cleared.await?
}

/// Which fault.
#[derive(Debug, Deserialize)]
pub(in crate::panel) struct OfFault {
    number: String,
}

/// Removes one fault of the line
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/faults/{number}", tag = "lines", responses((status = 204), Problems)))]
pub(in crate::panel) async fn remove(
    OfLineName(line): OfLineName,
    PathOf(OfFault { number }): PathOf<OfFault>,
) -> Result<StatusCode, Problem> {
    let wrong = |_| Problem::new(StatusCode::BAD_REQUEST, format!("'{number}' is no number of a fault"));
    let number: u32 = number.parse().map_err(wrong)?;
    let removed = line.asking.ask(move |lent| {
        lent.faults()?;
        let on = lent.kind().name();
        let none = || Problem::not_found(format!("there is no fault number {number} on the {on}"));
        let rule = lent.remove_fault(number).ok_or_else(none)?;
        tracing::info!("fault on purpose taken off the {on}: {rule}");
        Ok(StatusCode::NO_CONTENT)
    });
    removed.await?
}

fn read(lent: &dyn OnLine, fault: &str) -> Result<Rule, Problem> {
    Rule::on(lent.kind(), fault).map_err(|error| Problem::value(format!("fault '{fault}': {error}")))
}

fn add_one(lent: &mut dyn OnLine, rule: Rule) -> Result<FaultState, Problem> {
    if lent.faults()?.len() >= MOST_FAULTS {
        let on = lent.kind().name();
        return Err(Problem::conflict(format!("there are {MOST_FAULTS} faults on the {on}; remove some")));
    }
    let number = lent.add_fault(rule)?;
    tracing::warn!("fault on purpose: {rule}");
    let added = lent.faults()?.into_iter().find(|listed| listed.number == number);
    added.map(FaultState::from).ok_or_else(|| Problem::not_found(format!("fault {number} is gone again")))
}

fn remove_all(lent: &mut dyn OnLine) -> Result<(), Problem> {
    for listed in lent.faults()? {
        lent.remove_fault(listed.number);
    }
    Ok(())
}

/// The faults as they are shown.
pub(super) fn states(lent: &dyn OnLine) -> Result<Vec<FaultState>, Problem> {
    Ok(lent.faults()?.into_iter().map(FaultState::from).collect())
}
