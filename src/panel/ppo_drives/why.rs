//! What keeps a drive of the profile from turning, on request.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::super::bus_access::Asking;
use super::super::problem::{Problem, Problems, Station};
use super::super::state::seconds;
use crate::face::Why;
use crate::host::HostedPpoDrive;
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// What keeps a drive of PROFIDRIVE version 2 from turning.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct PpoWhy {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    #[schema(minimum = 0, maximum = 126)]
    address: u8,
    /// It turns: nothing keeps it from that.
    turning: bool,
    /// What keeps it from turning, the first thing to do first.
    hindrances: Vec<PpoHindrance>,
    /// All of it in one line.
    text: String,
}

/// One thing that keeps it from turning.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct PpoHindrance {
    /// What, and what to do about it.
    text: String,
}

impl PpoWhy {
    fn of(address: Address, hosted: &HostedPpoDrive, now: Instant) -> Self {
        let why: &dyn Why = hosted.drive();
        let mut hindrances = Vec::new();
        why.each_reason(&mut |reason| hindrances.push(PpoHindrance { text: reason.to_string() }));
        Self {
            time_seconds: seconds(now),
            address: address.number(),
            turning: why.is_moving() == Some(true),
            hindrances,
            text: why.to_string(),
        }
    }
}

/// What keeps such a drive from turning
///
/// The first thing to do first.
#[utoipa::path(get, path = "/api/v1/ppo-drives/{address}/why", tag = "ppo-drives", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = PpoWhy), Problems))]
pub(in crate::panel) async fn why(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<PpoWhy>, Problem> {
    asking.ask(move |bench| Ok(Json(PpoWhy::of(address, bench.find(address)?, bench.now)))).await?
}
