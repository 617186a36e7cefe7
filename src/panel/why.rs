//! What keeps a drive from moving, on request.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::bus_access::Asking;
use super::problem::{Problem, Problems, Station};
use super::state::{ReasonText, next_of, seconds};
use crate::devices::ag03::profibus::Device;
use crate::face::Why;
use crate::time::Instant;

/// What keeps a drive from moving.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct DriveWhy {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    #[schema(minimum = 0, maximum = 126)]
    address: u8,
    /// It moves: nothing keeps it from that.
    moving: bool,
    /// What keeps it from moving, the most important first.
    hindrances: Vec<ReasonText>,
    /// The control words to send one after the other; `null`: it moves, or no control word helps before the hindrances
    /// are removed.
    next: Option<String>,
    /// All of it in one line.
    text: String,
}

impl DriveWhy {
    fn of(device: &Device, now: Instant) -> Self {
        Self {
            time_seconds: seconds(now),
            address: device.address().number(),
            moving: device.is_moving() == Some(true),
            hindrances: ReasonText::all(|tell| device.each_reason(tell)),
            next: next_of(device),
            text: (device as &dyn Why).to_string(),
        }
    }
}

/// What keeps a drive from moving
///
/// The most important first, with the control words to send.
#[utoipa::path(get, path = "/api/v1/drives/{address}/why", tag = "drives", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = DriveWhy), Problems))]
pub(super) async fn why(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<DriveWhy>, Problem> {
    let found = asking.ask(move |bench| {
        let device = bench.drive(address).ok_or_else(|| bench.no_drive(address))?;
        Ok(Json(DriveWhy::of(device, bench.now)))
    });
    found.await?
}
