//! Nodes that come and go while the bus runs.

use std::path::Path;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use super::super::bus_access::in_one_line;
use super::super::problem::{Body, Problem, Problems};
use super::access::{Asking, NodeAccess, Number, Seated};
use super::state::NodeSummary;
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::storage::Eeprom;
use crate::host::can::StoredNode;
use crate::host::list::{Given, Group, Spec};

/// Nodes of a bus at most, twins included.
const MOST_NODES: usize = 254;

/// A node to add: its specification, as in a line file (docs/line.md).
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct NewNode(Given);

impl ToSchema for NewNode {}

impl PartialSchema for NewNode {
    fn schema() -> RefOr<Schema> {
        Group::Node.open_api()
    }
}

/// Adds a node
///
/// A new one with factory settings, or, where EEPROMs are kept, the one of this device that had this number. It boots.
#[utoipa::path(post, path = "/api/v1/drives", tag = "nodes", request_body = NewNode,
    responses((status = 201, body = NodeSummary, headers(("location" = String, description = "Where its state is"))), Problems))]
pub(super) async fn add(State(asking): State<Asking>, Body(new): Body<NewNode>) -> Result<Response, Problem> {
    let spec =
        Spec::of_given(Group::Node, &new.0, Path::new("")).map_err(|wrong| Problem::value(wrong.words))?;
    let node = spec.node();
    let summary = asking.ask(move |bench| bench.add(spec)).await??;
    let location = HeaderValue::try_from(format!("/api/v1/drives/{node}")).map_err(Problem::value)?;
    Ok((StatusCode::CREATED, [(header::LOCATION, location)], Json(summary)).into_response())
}

/// Removes a node
///
/// As if its plug was pulled: it sends nothing more. Of two nodes with this number, the first one.
#[utoipa::path(delete, path = "/api/v1/drives/{address}", tag = "nodes",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), responses((status = 204), Problems))]
pub(super) async fn remove(
    State(asking): State<Asking>,
    Number(node): Number,
) -> Result<StatusCode, Problem> {
    asking.ask(move |bench| bench.remove(node)).await??;
    Ok(StatusCode::NO_CONTENT)
}

impl NodeAccess<'_> {
    fn add(&mut self, spec: Spec) -> Result<NodeSummary, Problem> {
        let node = spec.node();
        let product = spec.device.product();
        let product = product.ok_or_else(|| Problem::value(format!("{} is no node", spec.device.name())))?;
        let (twin, mut choices) = (spec.choices.flag("twin"), spec.choices);
        if !twin && self.device(node).is_ok() {
            return Err(Problem::conflict(format!(
                "the number {node} is taken; choose another, remove that node, or say \"twin\": true"
            )));
        }
        if self.nodes.len() >= MOST_NODES {
            return Err(Problem::conflict(format!("{MOST_NODES} nodes are on this bus; remove some")));
        }
        (self.choose)(product, &mut choices);
        let now = self.now;
        let mut stored = match self.state {
            Some(state) => state
                .load_node(product, node, &choices, now)
                .map_err(|error| Problem::conflict(in_one_line(&error)))?,
            None => StoredNode::new(product.make(node, &choices, Eeprom::Internal, now), now),
        };
        self.bus.spoil_joining(now, &mut stored);
        let summary = NodeSummary::of(product, stored.as_device(), now);
        let seat = self.bus.add(now, Box::new(stored));
        self.nodes.push(Seated { seat, product });
        self.bus.reseat_faults();
        Ok(summary)
    }

    fn remove(&mut self, node: NodeId) -> Result<(), Problem> {
        let is_it = |seated: &Seated| {
            let there = self.bus.participant::<StoredNode>(seated.seat);
            there.is_some_and(|there| there.node_id() == node)
        };
        let Some(place) = self.nodes.iter().position(is_it) else { return Err(self.no_node(node)) };
        let Seated { seat, .. } = self.nodes.remove(place);
        self.bus.remove(self.now, seat);
        self.bus.reseat_faults();
        // Those that wait for this node go on waiting.
        for (_, fault, _) in self.bus.faults().iter() {
            if let Err(absent) = fault.check(self.numbers()) {
                tracing::warn!("{absent}");
            }
        }
        Ok(())
    }
}
