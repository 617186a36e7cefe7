//! Faults on purpose of a line of either bus: listed, added, replaced, removed.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::problem::{Body, PathOf, Problem, Problems};
use super::queue::{Asking, Lends};
use crate::host::fault::{BusKind, Rule};

/// Faults of a line at most.
const MOST_FAULTS: usize = 32;

/// What the thread of a bus lends to change its faults.
pub(super) trait FaultAccess {
    /// Which faults it can have.
    const BUS: BusKind;

    /// Every fault with its number and how often it was injected.
    ///
    /// # Errors
    /// The line cannot have faults.
    fn faults(&self) -> Result<Vec<(u32, Rule, u32)>, Problem>;

    /// Whether those are there that a fault is for.
    ///
    /// # Errors
    /// They are not.
    fn check_fault(&self, rule: &Rule) -> Result<(), Problem>;

    /// Adds one and returns its number.
    ///
    /// # Errors
    /// The line cannot have faults, or not one more.
    fn add_fault(&mut self, rule: Rule) -> Result<u32, Problem>;

    /// Ends one.
    fn remove_fault(&mut self, number: u32) -> Option<Rule>;
}

/// A fault on the line.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct FaultState {
    /// Its number, with which it is removed.
    number: u32,
    /// As on the command line, `emulate --fault`.
    fault: String,
    /// How often it was injected.
    injected: u32,
}

/// The faults on the line.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct FaultList {
    faults: Vec<FaultState>,
}

/// A fault to add.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewFault {
    /// As for `emulate --fault` (docs/faults.md).
    #[schema(example = "late=20ms,station=5")]
    fault: String,
}

/// All faults that are to act.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewFaults {
    /// Each as for `emulate --fault`.
    #[schema(example = json!(["no-reply,rate=0.1"]), max_items = 32)]
    faults: Vec<String>,
}

/// The faults on the line
#[utoipa::path(get, path = "/api/v1/bus/faults", tag = "bus", responses((status = 200, body = FaultList), Problems))]
pub(super) async fn list<L: Lends>(State(asking): State<Asking<L>>) -> Result<Json<FaultList>, Problem>
where
    for<'a> L::Access<'a>: FaultAccess,
{
    asking.ask(|bench| Ok(Json(FaultList { faults: states(bench)? }))).await?
}

/// Adds a fault to the line
#[utoipa::path(post, path = "/api/v1/bus/faults", tag = "bus", request_body = NewFault,
    responses((status = 201, body = FaultState), Problems))]
pub(super) async fn add<L: Lends>(
    State(asking): State<Asking<L>>,
    Body(NewFault { fault }): Body<NewFault>,
) -> Result<(StatusCode, Json<FaultState>), Problem>
where
    for<'a> L::Access<'a>: FaultAccess,
{
    let added = asking.ask(move |bench| {
        let rule = read(bench, &fault)?;
        bench.check_fault(&rule)?;
        add_one(bench, rule)
    });
    Ok((StatusCode::CREATED, Json(added.await??)))
}

/// Replaces all faults on the line
#[utoipa::path(put, path = "/api/v1/bus/faults", tag = "bus", request_body = NewFaults,
    responses((status = 200, body = FaultList), Problems))]
pub(super) async fn replace<L: Lends>(
    State(asking): State<Asking<L>>,
    Body(NewFaults { faults }): Body<NewFaults>,
) -> Result<Json<FaultList>, Problem>
where
    for<'a> L::Access<'a>: FaultAccess,
{
    if faults.len() > MOST_FAULTS {
        return Err(Problem::value(format!(
            "at most {MOST_FAULTS} faults are possible, got {}",
            faults.len()
        )));
    }
    let replaced = asking.ask(move |bench| {
        let rules: Vec<Rule> = faults.iter().map(|fault| read(bench, fault)).collect::<Result<_, _>>()?;
        rules.iter().try_for_each(|rule| bench.check_fault(rule))?;
        remove_all(bench)?;
        for rule in rules {
            add_one(bench, rule)?;
        }
        Ok(Json(FaultList { faults: states(bench)? }))
    });
    replaced.await?
}

/// Removes all faults of the line
#[utoipa::path(delete, path = "/api/v1/bus/faults", tag = "bus", responses((status = 204), Problems))]
pub(super) async fn clear<L: Lends>(State(asking): State<Asking<L>>) -> Result<StatusCode, Problem>
where
    for<'a> L::Access<'a>: FaultAccess,
{
    let cleared = asking.ask(|bench| {
        remove_all(bench)?;
        tracing::info!("all faults on purpose are taken off the {}", on::<L>());
        Ok(StatusCode::NO_CONTENT)
    });
    cleared.await?
}

/// Which fault.
#[derive(Debug, Deserialize)]
pub(super) struct OfFault {
    number: String,
}

/// Removes one fault of the line
#[utoipa::path(delete, path = "/api/v1/bus/faults/{number}", tag = "bus", params(("number" = u32, Path)),
    responses((status = 204), Problems))]
pub(super) async fn remove<L: Lends>(
    State(asking): State<Asking<L>>,
    PathOf(OfFault { number }): PathOf<OfFault>,
) -> Result<StatusCode, Problem>
where
    for<'a> L::Access<'a>: FaultAccess,
{
    let wrong = |_| Problem::new(StatusCode::BAD_REQUEST, format!("'{number}' is no number of a fault"));
    let number: u32 = number.parse().map_err(wrong)?;
    let removed = asking.ask(move |bench| {
        bench.faults()?;
        let none = || Problem::not_found(format!("there is no fault number {number} on the {}", on::<L>()));
        let rule = bench.remove_fault(number).ok_or_else(none)?;
        tracing::info!("fault on purpose taken off the {}: {rule}", on::<L>());
        Ok(StatusCode::NO_CONTENT)
    });
    removed.await?
}

/// What faults are on.
fn on<L: Lends>() -> &'static str
where
    for<'a> L::Access<'a>: FaultAccess,
{
    <L::Access<'_> as FaultAccess>::BUS.name()
}

fn read<A: FaultAccess>(_: &A, fault: &str) -> Result<Rule, Problem> {
    Rule::on(A::BUS, fault).map_err(|error| Problem::value(format!("fault '{fault}': {error}")))
}

fn add_one<A: FaultAccess>(bench: &mut A, rule: Rule) -> Result<FaultState, Problem> {
    if bench.faults()?.len() >= MOST_FAULTS {
        let on = A::BUS.name();
        return Err(Problem::conflict(format!("there are {MOST_FAULTS} faults on the {on}; remove some")));
    }
    let number = bench.add_fault(rule)?;
    tracing::warn!("fault on purpose: {rule}");
    Ok(FaultState { number, fault: rule.to_string(), injected: 0 })
}

fn remove_all<A: FaultAccess>(bench: &mut A) -> Result<(), Problem> {
    for (number, ..) in bench.faults()? {
        bench.remove_fault(number);
    }
    Ok(())
}

/// The faults as they are shown.
pub(super) fn states<A: FaultAccess>(bench: &A) -> Result<Vec<FaultState>, Problem> {
    let state =
        |(number, rule, injected): (u32, Rule, u32)| FaultState { number, fault: rule.to_string(), injected };
    Ok(bench.faults()?.into_iter().map(state).collect())
}
