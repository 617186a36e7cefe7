//! Which stations there are, the complete state of each, why it does not move.

use axum::Json;
use axum::extract::State as Shared;
use axum::http::StatusCode;
use serde::Serialize;

use super::{Reasons, State, Summary, seconds};
use crate::face::Why;
#[cfg(test)]
use crate::panel::description::Problems;
use crate::panel::line::Lines;
use crate::panel::master::MasterState;
use crate::panel::problem::Problem;
use crate::panel::routes::Place;

/// Every station of every line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct Stations {
    /// When this was so, since the line was started.
    pub(in crate::panel) time_seconds: f64,
    pub(in crate::panel) stations: Vec<Summary>,
}

/// What keeps a station from moving.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct StationWhy {
    /// When this was so, since the line was started.
    time_seconds: f64,
    #[cfg_attr(test, schema(minimum = 0, maximum = 127))]
    address: u8,
    #[serde(flatten)]
    reasons: Reasons,
    /// All of it in one line.
    text: String,
}

impl Stations {
    /// Of all lines.
    pub(in crate::panel) async fn of(lines: &Lines) -> Result<Self, Problem> {
        let mut all = Self { time_seconds: 0.0, stations: Vec::new() };
        for line in lines.all() {
            let name = line.name.clone();
            let look = line.asking.ask(move |lent| (lent.now(), Summary::all(&name, lent)));
            let (now, stations) = look.await?;
            all.time_seconds = seconds(now).max(all.time_seconds);
            all.stations.extend(stations);
        }
        Ok(all)
    }

    /// Whether nothing has changed but time.
    pub(in crate::panel) fn is_same(&self, other: &Self) -> bool {
        self.stations == other.stations
    }
}

impl Place {
    /// The complete state of the station.
    pub(in crate::panel) async fn look(&self) -> Result<State, Problem> {
        let (name, address) = (self.line.name.clone(), self.address);
        let look = self.line.asking.ask(move |lent| {
            lent.find(address)?;
            State::of(&name, lent, address).ok_or_else(|| Problem::not_found("the station is gone"))
        });
        let mut state = look.await??;
        state.last_refusal = self.line.hub.last_refusal(address, state.summary.is_exchanging());
        state.master = self.line.master.as_ref().map(|master| MasterState::of(master, address));
        Ok(state)
    }
}

/// Every station of every line at a glance
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/stations", tag = "stations", responses((status = 200, body = Stations), Problems)))]
pub(in crate::panel) async fn list(Shared(lines): Shared<Lines>) -> Result<Json<Stations>, Problem> {
    Stations::of(&lines).await.map(Json)
}

/// The complete state of a station
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}", tag = "stations",
    responses((status = 200, body = State), Problems)))]
pub(in crate::panel) async fn state(place: Place) -> Result<Json<State>, Problem> {
    place.look().await.map(Json)
}

/// Removes a station
///
/// As if its plug were pulled: it says nothing more. Of two nodes with this number, the first one.
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/stations/{address}", tag = "stations",
    responses((status = 204), Problems)))]
pub(in crate::panel) async fn remove(place: Place) -> Result<StatusCode, Problem> {
    let removed = place.ask(|lent, address| {
        lent.find(address)?;
        Ok(lent.remove(address))
    });
    // Here, because a shaft runs out and the last image is handed over.
    drop(removed.await?);
    Ok(StatusCode::NO_CONTENT)
}

/// What keeps a station from moving
///
/// The most important first, with what to send.
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/why", tag = "stations",
    responses((status = 200, body = StationWhy), Problems)))]
pub(in crate::panel) async fn why(place: Place) -> Result<Json<StationWhy>, Problem> {
    let found = place.ask(|lent, address| {
        let time_seconds = seconds(lent.now());
        let description = lent.find(address)?.description;
        let why: Option<&dyn Why> = description.why();
        let mut text = why.map_or_else(|| "it has no drive that could move".into(), |why| format!("{why}"));
        let reasons = Reasons::of(description);
        reasons.say_services(&mut text);
        Ok(Json(StationWhy { time_seconds, address, reasons, text }))
    });
    found.await
}
