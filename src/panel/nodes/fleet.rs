//! Nodes that come and go while the bus runs.

use std::boxed::Box;
use std::format;
use std::prelude::v1::*;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::ToSchema;

use super::super::bus_access::in_one_line;
use super::super::problem::{Body, Problem, Problems, whole};
use super::super::state::gear;
use super::access::{Asking, NodeAccess, Number, Seated, number, unknown};
use super::state::NodeSummary;
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::storage::Eeprom;
use crate::devices::asda_a2::canopen::Level;
use crate::host::can::{Choices, OptionName, PRODUCTS, Product, StoredNode};

/// Nodes of a bus at most, twins included.
const MOST_NODES: usize = 254;

/// A node to add.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewNode {
    /// The node number.
    #[serde(deserialize_with = "whole")]
    #[schema(minimum = 1, maximum = 127)]
    address: u8,
    /// `ag03-1` (unless given), `ap10` or `asda-a2`.
    device: Option<String>,
    /// 24 or 48 (unless given); AG03/1 only.
    gear_ratio: Option<u16>,
    /// How much of CiA 402 it follows; ASDA-A2 only.
    mode: Option<LevelName>,
    /// Also if another node has this number: a fault on purpose.
    #[serde(default)]
    twin: bool,
}

/// How much of CiA 402 an ASDA-A2 follows.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum LevelName {
    Full,
    Half,
}

/// Adds a node
///
/// A new one with factory settings, or, where EEPROMs are kept, the one of this device that had this number. It boots.
#[utoipa::path(post, path = "/api/v1/drives", tag = "nodes", request_body = NewNode,
    responses((status = 201, body = NodeSummary, headers(("location" = String, description = "Where its state is"))), Problems))]
pub(super) async fn add(State(asking): State<Asking>, Body(new): Body<NewNode>) -> Result<Response, Problem> {
    let node = number(&new.address.to_string())?;
    let (product, choices) = new.product()?;
    let summary = asking.ask(move |bench| bench.add(node, product, choices, new.twin)).await??;
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

impl NewNode {
    /// Which device, and what is chosen about it.
    fn product(&self) -> Result<(&'static Product, Choices), Problem> {
        let names: Vec<_> = PRODUCTS.iter().map(|product| product.name.to_owned()).collect();
        let product = match &self.device {
            Some(name) => Product::named(name).ok_or_else(|| unknown("device", name, "list", &names))?,
            None => PRODUCTS.first().ok_or_else(|| Problem::not_found("there are no devices"))?,
        };
        let only = |option, what: &str| {
            product
                .options
                .contains(&option)
                .then_some(())
                .ok_or_else(|| Problem::value(format!("{what} is not for {}", product.name)))
        };
        let mut choices = Choices::default();
        if let Some(ratio) = self.gear_ratio {
            only(OptionName::Gear, "gear_ratio")?;
            choices.gear = gear(ratio)
                .ok_or_else(|| Problem::value(format!("gear_ratio must be 24 or 48, got {ratio}")))?;
        }
        if let Some(level) = self.mode {
            only(OptionName::Mode, "mode")?;
            choices.level = match level {
                LevelName::Full => Level::Full,
                LevelName::Half => Level::Half,
            };
        }
        Ok((product, choices))
    }
}

impl NodeAccess<'_> {
    fn add(
        &mut self,
        node: NodeId,
        product: &'static Product,
        mut choices: Choices,
        twin: bool,
    ) -> Result<NodeSummary, Problem> {
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
                .load_node(product, node, choices, now)
                .map_err(|error| Problem::conflict(in_one_line(&error)))?,
            None => StoredNode::new(product.make(node, choices, Eeprom::Internal, now), now),
        };
        self.faults.join(now, &mut stored);
        let summary = NodeSummary::of(product, stored.as_device(), now);
        let seat = self.bus.add(now, Box::new(stored));
        self.nodes.push(Seated { seat, product });
        self.faults.reseat(self.bus);
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
        self.faults.reseat(self.bus);
        // Those that wait for this node go on waiting.
        for (_, fault, _) in self.faults.list(self.bus) {
            if let Some(words) = self.absent(&fault) {
                tracing::warn!("{words}");
            }
        }
        Ok(())
    }
}
