//! What was on the bus, over HTTP.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::super::history::{OfWhom, since_1970};
use super::super::problem::{Problem, Problems, QueryOf};
use super::news::{Feed, NodeNews};
use crate::can_bus::canopen::NodeId;

/// The newest events.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct RecentNodeEvents {
    /// When the panel was started, since 1970: another start has another history.
    started_unix_seconds: f64,
    /// Oldest first, 1000 at most.
    events: Vec<NodeNews>,
}

/// The newest events
///
/// What the stream told as `news`, for who comes late.
#[utoipa::path(get, path = "/api/v1/events/recent", tag = "history",
    params(("address" = Option<u8>, Query, minimum = 1, maximum = 127, description = "Only what concerns this node")),
    responses((status = 200, body = RecentNodeEvents), Problems))]
pub(super) async fn events(
    State(feed): State<Arc<Feed>>,
    QueryOf(of): QueryOf<OfWhom>,
) -> Result<Json<RecentNodeEvents>, Problem> {
    let node = of.address.map(NodeId::new).transpose().map_err(Problem::value)?;
    let started_unix_seconds = since_1970(feed.started()).as_secs_f64();
    Ok(Json(RecentNodeEvents { started_unix_seconds, events: feed.recent(node) }))
}
