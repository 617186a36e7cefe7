//! Stations from GSDs: which there are, their modules with inputs and outputs, their diagnosis.
//!
//! | file | holds |
//! | --- | --- |
//! | `state` | a station as JSON |
//! | `values` | inputs and outputs by slot, octet and type |
//! | `diagnosis` | the diagnosis that is raised |

mod diagnosis;
mod state;
pub(super) mod values;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;

use super::bus_access::{Asking, BusAccess};
use super::problem::{Body, Problem, Problems, Station};
use super::stream::Hub;
use crate::host::GsdStation;
use crate::profibus::fdl::Address;
use diagnosis::RaisedDiagnosis;
use state::GsdTexts;

pub(super) use state::{GsdStationState, GsdStations};

/// All stations from GSDs at a glance
#[utoipa::path(get, path = "/api/v1/stations", tag = "stations", responses((status = 200, body = GsdStations), Problems))]
pub(super) async fn list(State(asking): State<Asking>) -> Result<Json<GsdStations>, Problem> {
    asking.ask(|bench| Json(GsdStations::of(bench))).await
}

/// The complete state of a station from a GSD
#[utoipa::path(get, path = "/api/v1/stations/{address}", tag = "stations", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = GsdStationState), Problems))]
pub(super) async fn state(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
) -> Result<Json<GsdStationState>, Problem> {
    asked(&asking, &hub, address, |_| Ok(())).await
}

/// The texts of its GSD: what a diagnosis may say, and the modules
#[utoipa::path(get, path = "/api/v1/stations/{address}/texts", tag = "stations", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = GsdTexts), Problems))]
pub(super) async fn texts(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<GsdTexts>, Problem> {
    asking.ask(move |bench| Ok(Json(GsdTexts::of(bench.find(address)?)))).await?
}

/// Removes a station
///
/// As if its plug were pulled: it answers nothing more.
#[utoipa::path(delete, path = "/api/v1/stations/{address}", tag = "stations", params(("address" = u8, Path, maximum = 126)),
    responses((status = 204), Problems))]
pub(super) async fn remove(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<StatusCode, Problem> {
    asking.ask(move |bench| bench.unplug::<GsdStation>(address)).await?
}

/// Gives all inputs back to what moves them by itself
#[utoipa::path(delete, path = "/api/v1/stations/{address}/inputs", tag = "stations", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = GsdStationState), Problems))]
pub(super) async fn release_all(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
) -> Result<Json<GsdStationState>, Problem> {
    let release = |station: &mut GsdStation| {
        station.release_all();
        Ok(())
    };
    asked(&asking, &hub, address, release).await
}

/// Has the diagnosis report this and nothing else
#[utoipa::path(put, path = "/api/v1/stations/{address}/diagnosis", tag = "stations", params(("address" = u8, Path, maximum = 126)),
    request_body = RaisedDiagnosis, responses((status = 200, body = GsdStationState), Problems))]
pub(super) async fn raise(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
    Body(wanted): Body<RaisedDiagnosis>,
) -> Result<Json<GsdStationState>, Problem> {
    let raised = wanted.raised()?;
    asked(&asking, &hub, address, move |station| station.raise(raised).map_err(Problem::value)).await
}

/// Ends the diagnosis
#[utoipa::path(delete, path = "/api/v1/stations/{address}/diagnosis", tag = "stations", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = GsdStationState), Problems))]
pub(super) async fn end_diagnosis(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
) -> Result<Json<GsdStationState>, Problem> {
    let end = |station: &mut GsdStation| station.raise(crate::gsd::Raised::default()).map_err(Problem::value);
    asked(&asking, &hub, address, end).await
}

/// Does something to a station and says how it is then.
async fn asked(
    asking: &Asking,
    hub: &Hub,
    address: Address,
    act: impl FnOnce(&mut GsdStation) -> Result<(), Problem> + Send + 'static,
) -> Result<Json<GsdStationState>, Problem> {
    let state = asking.ask(move |bench| {
        bench.change(address, act)??;
        look(bench, address)
    });
    Ok(Json(state.await??.with_refusal(hub.last_station_refusal(address))))
}

/// A station as it is, without its last refusal.
pub(super) fn look(bench: &BusAccess<'_>, address: Address) -> Result<GsdStationState, Problem> {
    Ok(GsdStationState::of(bench, address, bench.find(address)?))
}
