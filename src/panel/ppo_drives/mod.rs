//! Drives of PROFIDRIVE version 2: their words, what acts on them, their parameters.
//!
//! | file | holds |
//! | --- | --- |
//! | `state` | a drive as JSON |
//! | `parameters` | its table |
//! | `why` | what keeps it from turning |

pub(super) mod parameters;
mod state;
pub(super) mod why;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Deserialize;
use utoipa::ToSchema;

use super::bus_access::{Asking, BusAccess};
use super::problem::{Body, Problem, Problems, Station, whole};
use super::stream::Hub;
use crate::host::HostedPpoDrive;
use crate::profibus::fdl::Address;
use crate::time::Instant;

pub(super) use state::{PpoDriveState, PpoDrives};

/// A number of a fault or a warning.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Number {
    /// Of a fault from 1; a warning 0 ends it.
    #[serde(deserialize_with = "whole")]
    #[schema(minimum = 0, maximum = 65535)]
    number: u16,
}

/// What the machine takes.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Load {
    /// In % of the rated torque, against the motion.
    #[schema(minimum = 0.0)]
    percent: f64,
}

/// All drives of PROFIDRIVE version 2 at a glance
#[utoipa::path(get, path = "/api/v1/ppo-drives", tag = "ppo-drives", responses((status = 200, body = PpoDrives), Problems))]
pub(super) async fn list(State(asking): State<Asking>) -> Result<Json<PpoDrives>, Problem> {
    asking.ask(|bench| Json(PpoDrives::of(bench))).await
}

/// The complete state of such a drive
#[utoipa::path(get, path = "/api/v1/ppo-drives/{address}", tag = "ppo-drives", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = PpoDriveState), Problems))]
pub(super) async fn state(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
) -> Result<Json<PpoDriveState>, Problem> {
    asked(&asking, &hub, address, |_, _| Ok(())).await
}

/// Removes such a drive
///
/// As if its plug were pulled: it answers nothing more.
#[utoipa::path(delete, path = "/api/v1/ppo-drives/{address}", tag = "ppo-drives", params(("address" = u8, Path, maximum = 126)),
    responses((status = 204), Problems))]
pub(super) async fn remove(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<StatusCode, Problem> {
    asking.ask(move |bench| bench.unplug::<HostedPpoDrive>(address)).await?
}

/// Raises a fault: the motor is released
#[utoipa::path(post, path = "/api/v1/ppo-drives/{address}/fault", tag = "ppo-drives", params(("address" = u8, Path, maximum = 126)),
    request_body = Number, responses((status = 200, body = PpoDriveState), Problems))]
pub(super) async fn fault(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
    Body(Number { number }): Body<Number>,
) -> Result<Json<PpoDriveState>, Problem> {
    if number == 0 {
        return Err(Problem::value("a fault has a number from 1 to 65535, got 0"));
    }
    asked(&asking, &hub, address, move |drive, now| {
        drive.drive_mut().raise_fault(now, number);
        Ok(())
    })
    .await
}

/// Raises a warning, or ends it with 0
#[utoipa::path(put, path = "/api/v1/ppo-drives/{address}/warning", tag = "ppo-drives", params(("address" = u8, Path, maximum = 126)),
    request_body = Number, responses((status = 200, body = PpoDriveState), Problems))]
pub(super) async fn warning(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
    Body(Number { number }): Body<Number>,
) -> Result<Json<PpoDriveState>, Problem> {
    asked(&asking, &hub, address, move |drive, now| {
        drive.drive_mut().raise_warning(now, number);
        Ok(())
    })
    .await
}

/// Sets the load of the shaft
#[utoipa::path(put, path = "/api/v1/ppo-drives/{address}/load", tag = "ppo-drives", params(("address" = u8, Path, maximum = 126)),
    request_body = Load, responses((status = 200, body = PpoDriveState), Problems))]
pub(super) async fn load(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
    Body(Load { percent }): Body<Load>,
) -> Result<Json<PpoDriveState>, Problem> {
    asked(&asking, &hub, address, move |drive, now| {
        let set = drive.drive_mut().set_load(now, percent);
        set.map_err(|_| Problem::value(format!("percent must be 0 or more, got {percent}")))
    })
    .await
}

/// Does something to a drive and says how it is then.
async fn asked(
    asking: &Asking,
    hub: &Hub,
    address: Address,
    act: impl FnOnce(&mut HostedPpoDrive, Instant) -> Result<(), Problem> + Send + 'static,
) -> Result<Json<PpoDriveState>, Problem> {
    let state = asking.ask(move |bench| {
        let now = bench.now;
        bench.change(address, |drive| act(drive, now))??;
        look(bench, address)
    });
    Ok(Json(state.await??.with_refusal(hub.last_station_refusal(address))))
}

/// A drive as it is, without its last refusal.
pub(super) fn look(bench: &BusAccess<'_>, address: Address) -> Result<PpoDriveState, Problem> {
    Ok(PpoDriveState::of(bench, address, bench.find(address)?))
}
