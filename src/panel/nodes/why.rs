//! What keeps the drive of a node from moving, on request.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::super::problem::{Problem, Problems};
use super::super::state::seconds;
use super::access::{Asking, Number};
use crate::devices::CanopenDevice;
use crate::time::Instant;

/// What keeps the drive of a node from moving.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct NodeWhy {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    #[schema(minimum = 1, maximum = 127)]
    address: u8,
    /// Whether it has a drive that could move.
    is_drive: bool,
    /// What keeps it from moving, the most important first; none: it moves, or waits for a start.
    hindrances: Vec<HindranceText>,
    /// All of it in one line.
    text: String,
}

/// One thing that keeps it from moving.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct HindranceText {
    text: String,
}

impl NodeWhy {
    fn of(device: &dyn CanopenDevice, now: Instant) -> Self {
        let mut hindrances = Vec::new();
        if let Some(why) = device.why() {
            why.each_reason(&mut |reason| hindrances.push(HindranceText { text: reason.to_string() }));
        }
        let all: Vec<&str> = hindrances.iter().map(|hindrance| hindrance.text.as_str()).collect();
        let text = match (&all[..], device.is_drive()) {
            (_, false) => "it has no drive: its shaft is turned by hand".into(),
            ([], true) => "nothing keeps it from moving".into(),
            (all, true) => all.join("; "),
        };
        Self {
            time_seconds: seconds(now),
            address: device.node_id().number(),
            is_drive: device.is_drive(),
            hindrances,
            text,
        }
    }
}

/// What keeps the drive of a node from moving
///
/// The most important first.
#[utoipa::path(get, path = "/api/v1/drives/{address}/why", tag = "nodes",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), responses((status = 200, body = NodeWhy), Problems))]
pub(super) async fn why(
    State(asking): State<Asking>,
    Number(node): Number,
) -> Result<Json<NodeWhy>, Problem> {
    asking.ask(move |bench| Ok(Json(NodeWhy::of(bench.device(node)?.1, bench.now)))).await?
}
