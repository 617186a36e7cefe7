//! Faults on purpose of the bus and of what its nodes send.

use std::format;
use std::prelude::v1::*;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Deserialize;
use utoipa::ToSchema;

use super::super::bus::{FaultList, FaultState, OfFault};
use super::super::problem::{Body, PathOf, Problem, Problems};
use super::access::{Asking, NodeAccess};
use crate::can_bus::canopen::faults::MAX_FAULTS;
use crate::host::can::NodeFault;

/// A fault to add.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewNodeFault {
    /// `FAULT[=VALUE][,node=ID][,id=HEX][,rate=P][,count=N][,at=N][,seed=N]`, as for `emulate --fault`.
    #[schema(example = "sdo-late=20ms,node=5")]
    fault: String,
}

/// All faults that are to act.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewNodeFaults {
    /// Each as for `emulate --fault`.
    #[schema(example = json!(["tpdo-short,rate=0.1"]), max_items = 32)]
    faults: Vec<String>,
}

/// The faults on the bus
#[utoipa::path(get, path = "/api/v1/bus/faults", tag = "bus", responses((status = 200, body = FaultList), Problems))]
pub(super) async fn list(State(asking): State<Asking>) -> Result<Json<FaultList>, Problem> {
    asking.ask(|bench| Json(bench.fault_list())).await
}

/// Puts a fault on the bus, behind those that are there
#[utoipa::path(post, path = "/api/v1/bus/faults", tag = "bus", request_body = NewNodeFault,
    responses((status = 201, body = FaultState), Problems))]
pub(super) async fn add(
    State(asking): State<Asking>,
    Body(NewNodeFault { fault }): Body<NewNodeFault>,
) -> Result<(StatusCode, Json<FaultState>), Problem> {
    let fault = parse(&fault)?;
    let number = asking
        .ask(move |bench| {
            bench.knows(&fault)?;
            let text = fault.to_string();
            let number = bench.faults.add(bench.now, bench.bus, fault).map_err(Problem::conflict)?;
            tracing::warn!("fault on purpose: {text}");
            Ok::<_, Problem>(number)
        })
        .await??;
    Ok((StatusCode::CREATED, Json(FaultState { number, fault: fault.to_string(), injected: 0 })))
}

/// Replaces all faults on the bus
#[utoipa::path(put, path = "/api/v1/bus/faults", tag = "bus", request_body = NewNodeFaults,
    responses((status = 200, body = FaultList), Problems))]
pub(super) async fn replace(
    State(asking): State<Asking>,
    Body(NewNodeFaults { faults }): Body<NewNodeFaults>,
) -> Result<Json<FaultList>, Problem> {
    if faults.len() > MAX_FAULTS {
        return Err(Problem::value(format!(
            "at most {MAX_FAULTS} faults are possible, got {}",
            faults.len()
        )));
    }
    let new = faults.iter().map(|fault| parse(fault)).collect::<Result<Vec<_>, _>>()?;
    asking
        .ask(move |bench| {
            new.iter().try_for_each(|fault| bench.knows(fault))?;
            bench.faults.clear(bench.now, bench.bus);
            for fault in new {
                let text = fault.to_string();
                bench.faults.add(bench.now, bench.bus, fault).map_err(Problem::conflict)?;
                tracing::warn!("fault on purpose: {text}");
            }
            Ok(Json(bench.fault_list()))
        })
        .await?
}

/// Takes all faults off the bus
#[utoipa::path(delete, path = "/api/v1/bus/faults", tag = "bus", responses((status = 204), Problems))]
pub(super) async fn clear(State(asking): State<Asking>) -> Result<StatusCode, Problem> {
    asking
        .ask(|bench| {
            bench.faults.clear(bench.now, bench.bus);
            tracing::info!("all faults on purpose are taken off the bus");
        })
        .await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Takes one fault off the bus
#[utoipa::path(delete, path = "/api/v1/bus/faults/{number}", tag = "bus", params(("number" = u32, Path)),
    responses((status = 204), Problems))]
pub(super) async fn remove(
    State(asking): State<Asking>,
    PathOf(of): PathOf<OfFault>,
) -> Result<StatusCode, Problem> {
    let number = of.number()?;
    asking
        .ask(move |bench| match bench.faults.remove(bench.now, bench.bus, number) {
            Some(fault) => {
                tracing::info!("fault on purpose taken off the bus: {fault}");
                Ok(StatusCode::NO_CONTENT)
            }
            None => Err(Problem::not_found(format!("there is no fault number {number} on the bus"))),
        })
        .await?
}

impl NodeAccess<'_> {
    /// Every fault with how often it was injected.
    pub(super) fn fault_list(&self) -> FaultList {
        let state = |(number, fault, injected): (u32, NodeFault, u32)| FaultState {
            number,
            fault: fault.to_string(),
            injected,
        };
        FaultList { faults: self.faults.list(self.bus).into_iter().map(state).collect() }
    }

    /// Whether the node that a fault is for is on the bus.
    fn knows(&self, fault: &NodeFault) -> Result<(), Problem> {
        self.absent(fault).map_or(Ok(()), |words| Err(Problem::value(words)))
    }

    /// Says so if the node that a fault is for is not on the bus.
    pub(super) fn absent(&self, fault: &NodeFault) -> Option<String> {
        let node = fault.node.filter(|node| self.device(*node).is_err())?;
        Some(format!("fault '{fault}' is for node {node}, which is not on the bus"))
    }
}

fn parse(fault: &str) -> Result<NodeFault, Problem> {
    fault.parse::<NodeFault>().map_err(|error| Problem::value(format!("fault '{fault}': {error}")))
}
