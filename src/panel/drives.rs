//! Which drives there are, and the complete state of each.

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bus_access::{Asking, BusAccess};
use super::problem::{Body, Problem, Problems, Station, whole};
use super::state::{DriveState, DriveSummary, ModelName, gear};
use super::stream::Hub;
use crate::devices::ag03::profibus::{Config, Device};
use crate::host::Stored;
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// The drives of a bus.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Drives {
    /// When this was so, since the bus was started.
    pub(super) time_seconds: f64,
    pub(super) drives: Vec<DriveSummary>,
}

/// A drive to add.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewDrive {
    #[serde(deserialize_with = "whole")]
    #[schema(minimum = 0, maximum = 126)]
    address: u8,
    #[serde(default)]
    model: ModelName,
    /// 24 or 48.
    #[serde(default = "usual_gear", deserialize_with = "whole")]
    #[schema(minimum = 24, maximum = 48, multiple_of = 24, default = 48)]
    gear_ratio: u16,
}

const fn usual_gear() -> u16 {
    48
}

/// All drives at a glance
#[utoipa::path(get, path = "/api/v1/drives", tag = "drives", responses((status = 200, body = Drives), Problems))]
pub(super) async fn list(State(asking): State<Asking>) -> Result<Json<Drives>, Problem> {
    asking.ask(|bench| Json(Drives::of(bench))).await
}

/// Adds a drive
///
/// A new one with factory settings, or, where EEPROMs are kept, the one that had this address.
#[utoipa::path(post, path = "/api/v1/drives", tag = "drives", request_body = NewDrive,
    responses((status = 201, body = DriveSummary, headers(("location" = String, description = "Where its state is"))), Problems))]
pub(super) async fn add(
    State(asking): State<Asking>,
    Body(new): Body<NewDrive>,
) -> Result<Response, Problem> {
    let address = Address::station(new.address)
        .map_err(|_| Problem::value(format!("address {} is outside 0 to 126", new.address)))?;
    let gear = gear(new.gear_ratio)
        .ok_or_else(|| Problem::value(format!("gear_ratio must be 24 or 48, got {}", new.gear_ratio)))?;
    let summary = asking
        .ask(move |bench| {
            if bench.bus.presence(address).is_some() {
                return Err(Problem::conflict(format!(
                    "address {address} is taken; choose another, or remove that one"
                )));
            }
            let config = Config { switches: address.into(), model: new.model.into(), gear, ..bench.config };
            let device: Stored<Device> = match bench.state {
                Some(state) => state.load(config, bench.now).map_err(|error| bench.not_loaded(&error))?,
                None => Device::new(config, bench.now).into(),
            };
            let added = if bench.listen { bench.bus.join(bench.now, device) } else { bench.bus.add(device) };
            added.map_err(Problem::conflict)?;
            bench.announce();
            // A factory reset by its DIP switches is no reason not to find it.
            let device = bench.drive(address).ok_or_else(|| bench.no_drive(address))?;
            Ok(DriveSummary::of(device, bench.bus.presence(address), bench.now))
        })
        .await??;
    let location = HeaderValue::try_from(format!("/api/v1/drives/{address}")).map_err(Problem::value)?;
    Ok((StatusCode::CREATED, [(header::LOCATION, location)], Json(summary)).into_response())
}

/// The complete state of a drive
#[utoipa::path(get, path = "/api/v1/drives/{address}", tag = "drives", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = DriveState), Problems))]
pub(super) async fn state(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
) -> Result<Json<DriveState>, Problem> {
    let snapshot = Snapshot::take(&asking, address).await?;
    Ok(Json(snapshot.state(&hub).with_parameters(&snapshot.device)))
}

/// Removes a drive
///
/// As if its plug were pulled: it answers nothing more.
#[utoipa::path(delete, path = "/api/v1/drives/{address}", tag = "drives", params(("address" = u8, Path, maximum = 126)),
    responses((status = 204), Problems))]
pub(super) async fn remove(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<StatusCode, Problem> {
    let removed = asking
        .ask(move |bench| {
            bench.drive(address).ok_or_else(|| bench.no_drive(address))?;
            let removed = bench.bus.remove(address).ok_or_else(|| bench.no_drive(address))?;
            bench.announce();
            Ok::<_, Problem>(removed)
        })
        .await??;
    // Here, because its shaft runs out and its last image is handed over.
    drop(removed);
    Ok(StatusCode::NO_CONTENT)
}

impl Drives {
    pub(super) fn of(bench: &BusAccess<'_>) -> Self {
        let summary = |address: Address| {
            let device = bench.drive(address)?;
            Some(DriveSummary::of(device, bench.bus.presence(address), bench.now))
        };
        Self {
            time_seconds: super::state::seconds(bench.now),
            drives: bench.bus.addresses().filter_map(summary).collect(),
        }
    }
}

/// A copy of a drive, to be looked at on another thread than that of the bus.
pub(super) struct Snapshot {
    pub(super) device: Box<Device>,
    presence: Option<crate::host::Presence>,
    counters: Option<crate::profibus::fdl::StationCounters>,
    now: Instant,
}

impl Snapshot {
    pub(super) async fn take(asking: &Asking, address: Address) -> Result<Self, Problem> {
        asking
            .ask(move |bench| {
                let device = bench.drive(address).ok_or_else(|| bench.no_drive(address))?;
                Ok(Self::of(bench, device))
            })
            .await?
    }

    /// Of a drive of the bus.
    pub(super) fn of(bench: &BusAccess<'_>, device: &Device) -> Self {
        let address = device.address();
        Self {
            device: Box::new(device.clone()),
            presence: bench.bus.presence(address),
            counters: bench.bus.station_counters(address).copied(),
            now: bench.now,
        }
    }

    /// Without parameters.
    pub(super) fn state(&self, hub: &Hub) -> DriveState {
        let mut state = DriveState::of(&self.device, self.presence, self.counters.as_ref(), self.now);
        state.last_refusal = hub.last_refusal(self.device.address());
        state
    }
}
