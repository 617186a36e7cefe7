//! Every path.

use std::collections::BTreeMap;

use axum::Router;
use axum::extract::{FromRef, FromRequestParts, Request};
use axum::http::request::Parts;
use axum::http::{Method, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, delete, get, post, put};
use tokio::time::{Duration, Instant as Moment, sleep_until};

#[cfg(test)]
use super::description::Problems;
use super::line::{Act, Acted, Line, Lines, OnLine, address, faults};
use super::modules::values;
use super::problem::{PathOf, Problem};
use super::station::handlers as stations;
use super::station::spec;
use super::{acyclic, history, inputs, line, master, modules, objects, page, parameters, stream, switches};
use crate::face::Description;

/// Where stations are.
pub(super) const STATIONS: &str = "/api/v1/lines/{line}/stations/{address}";

/// The same where an address is on one line only.
pub(super) const SHORT: &str = "/api/v1/stations/{address}";

/// How often it is looked whether the lease of a key has ended.
const LOOK: Duration = Duration::from_millis(50);

/// The line that the path names.
pub(super) struct OfLineName(pub(super) Line);

/// The station that the path names.
#[derive(Clone)]
pub(super) struct Place {
    pub(super) line: Line,
    pub(super) address: u8,
}

impl<S: Send + Sync> FromRequestParts<S> for OfLineName
where
    Lines: FromRef<S>,
{
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let PathOf(path) = PathOf::<BTreeMap<String, String>>::from_request_parts(parts, state).await?;
        let name = path.get("line").map(String::as_str).unwrap_or_default();
        Lines::from_ref(state).named(name).map(Self)
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Place
where
    Lines: FromRef<S>,
{
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let PathOf(path) = PathOf::<BTreeMap<String, String>>::from_request_parts(parts, state).await?;
        let lines = Lines::from_ref(state);
        let address = address(path.get("address").map(String::as_str).unwrap_or_default())?;
        let line = match path.get("line") {
            Some(name) => lines.named(name)?,
            None => lines.with(address).await?,
        };
        Ok(Self { line, address })
    }
}

impl Place {
    /// Has `act` done on the thread of the line, with what it lends and the address.
    ///
    /// # Errors
    /// 503 if the line has ended, or has no time; what `act` says.
    pub(super) async fn ask<R: Send + 'static>(
        &self,
        act: impl FnOnce(&mut (dyn OnLine + '_), u8) -> Result<R, Problem> + Send + 'static,
    ) -> Result<R, Problem> {
        let address = self.address;
        self.line.asking.ask(move |lent| act(lent, address)).await?
    }

    /// Does something to the station, and looks at it then.
    ///
    /// # Errors
    /// 404 if there is none; what `act` says.
    pub(super) async fn act<R: Send + 'static>(
        &self,
        act: impl Fn(&mut dyn Description, &Acted<'_>) -> Result<(), Problem> + Send + 'static,
        look: impl FnOnce(&dyn Description) -> R + Send + 'static,
    ) -> Result<R, Problem> {
        self.ask(move |lent, address| {
            lent.find(address)?;
            // By its switches it may be elsewhere then.
            let before = lent.addresses();
            lent.act(address, &act as &Act<'_>)?;
            let moved = || lent.addresses().into_iter().find(|there| !before.contains(there));
            let there = if lent.station(address).is_some() { address } else { moved().unwrap_or(address) };
            Ok(look(lent.find(there)?.description))
        })
        .await
    }

    /// Held from now on, a key is released when its lease has ended; without one it stays held.
    pub(super) fn lease(&self, key: &str, milliseconds: Option<u32>) {
        let at = (self.address, key.to_owned());
        let mut leases = self.line.leases();
        let Some(milliseconds) = milliseconds else {
            leases.remove(&at);
            return;
        };
        let end = Moment::now() + Duration::from_millis(milliseconds.into());
        if leases.insert(at.clone(), end).is_none() {
            tokio::spawn(self.clone().release_in_time(at.1));
        }
    }

    /// Waits until nobody renews the lease of a key, and releases it.
    async fn release_in_time(self, key: String) {
        let at = (self.address, key);
        loop {
            let end = self.line.leases().get(&at).copied();
            match end {
                // Another press may have brought the end forward.
                Some(end) if end > Moment::now() => sleep_until(end.min(Moment::now() + LOOK)).await,
                Some(_) => self.release(&at).await,
                // It was released, or is held without a lease.
                None => return,
            }
        }
    }

    /// Releases a key, unless its lease was renewed meanwhile. Whoever presses renews it first.
    async fn release(&self, at: &(u8, String)) {
        let (line, at) = (self.line.clone(), at.clone());
        let released = self.line.asking.ask(move |lent| {
            let mut leases = line.leases();
            if leases.get(&at).is_some_and(|end| *end <= Moment::now()) {
                leases.remove(&at);
                // Without the station, or its supply, the key is up.
                let _ = lent.act(at.0, &|station, acted| {
                    let _ = station.press(acted.now, &at.1, false);
                    Ok(())
                });
            }
        });
        if released.await.is_err() {
            // The line has no time.
            sleep_until(Moment::now() + LOOK).await;
        }
    }
}

/// A route of a station, by its line and by its address alone.
trait StationRoute {
    fn station(self, rest: &str, handlers: MethodRouter<Lines>) -> Self;
}

impl StationRoute for Router<Lines> {
    fn station(self, rest: &str, handlers: MethodRouter<Lines>) -> Self {
        self.route(&format!("{STATIONS}{rest}"), handlers.clone()).route(&format!("{SHORT}{rest}"), handlers)
    }
}

pub(super) fn router(lines: Lines) -> Router {
    Router::new()
        .route("/api/v1/openapi.json", get(description))
        .route("/api/v1/lines", get(line::state::list))
        .route("/api/v1/lines/{line}", get(line::state::state))
        .route(
            "/api/v1/lines/{line}/faults",
            get(faults::list).post(faults::add).put(faults::replace).delete(faults::clear),
        )
        .route("/api/v1/lines/{line}/faults/{number}", delete(faults::remove))
        .route("/api/v1/lines/{line}/capture.pcapng", get(history::capture))
        .route("/api/v1/stations", get(stations::list).post(spec::add))
        .station("", get(stations::state).delete(stations::remove))
        .station("/why", get(stations::why))
        .station("/inputs", get(inputs::read).patch(inputs::change).delete(inputs::nominal))
        .station("/provoke", post(inputs::provoke))
        .station("/keys", post(inputs::press))
        .station("/power", put(inputs::power))
        .station("/switches", get(switches::read).put(switches::set))
        .station("/parameters", get(parameters::list))
        .station("/parameters/{key}", get(parameters::read).put(parameters::write))
        .station("/objects", get(objects::list))
        .station("/objects/{index}/{sub}", get(objects::read).put(objects::write))
        .station("/texts", get(modules::texts))
        .station("/diagnosis", get(modules::diagnosis).put(modules::raise).delete(modules::end_diagnosis))
        .station(
            "/inputs/{slot}/{octet}/{type}",
            get(values::read_input).put(values::force).delete(values::release),
        )
        .station("/inputs/{slot}/{octet}/{type}/signal", put(values::follow).delete(values::stop_following))
        .station("/outputs/{slot}/{octet}/{type}", get(values::read_output))
        .station("/records", get(acyclic::records))
        .station("/records/{slot_number}/{record}", get(acyclic::record).put(acyclic::change_record))
        .station("/alarms", get(acyclic::alarms).post(acyclic::raise_alarm).delete(acyclic::forget_alarms))
        .station("/status-messages", post(acyclic::send_status))
        .station("/acyclic", get(acyclic::channels))
        .station("/master", get(master::read).post(master::order).delete(master::leave))
        .station("/samples", get(history::samples))
        .station("/samples.csv", get(history::samples_csv))
        .route_layer(middleware::from_fn(without_parameters))
        // These refuse parameters that they do not know themselves.
        .route("/api/v1/events", get(stream::events))
        .route("/api/v1/events/recent", get(history::events))
        .route("/", get(page::index))
        .route("/page/{name}", get(page::file))
        .fallback(nothing_there)
        .method_not_allowed_fallback(not_so)
        .with_state(lines)
}

/// The description of the API
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/openapi.json", tag = "description",
    responses((status = 200, description = "OpenAPI 3.1", body = serde_json::Value), Problems)))]
pub(super) async fn description() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], include_str!("openapi.json"))
}

/// Refuses what stands behind the question mark, for operations that know no parameter.
async fn without_parameters(request: Request, next: Next) -> Result<Response, Problem> {
    match request.uri().query() {
        None | Some("") => Ok(next.run(request).await),
        Some(query) => Err(Problem::new(
            StatusCode::BAD_REQUEST,
            format!(
                "{} knows no parameter behind its '?', got '{query}'; the API is described at /api/v1/openapi.json",
                request.uri().path()
            ),
        )),
    }
}

async fn nothing_there(uri: Uri) -> Problem {
    Problem::not_found(format!(
        "there is nothing at {}; the API is described at /api/v1/openapi.json",
        uri.path()
    ))
}

async fn not_so(method: Method, uri: Uri) -> Problem {
    Problem::new(
        StatusCode::METHOD_NOT_ALLOWED,
        format!(
            "{} does not take {method}; the header Allow says what it takes, the API is described at \
             /api/v1/openapi.json",
            uri.path()
        ),
    )
}
