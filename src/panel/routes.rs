//! Every path, and the OpenAPI description of all of them.

use axum::extract::{FromRef, Request};
use axum::http::{Method, StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::Response;
use axum::routing::{delete, get, post, put};
use axum::{Json, Router};
use utoipa::OpenApi;

use super::bus_access::{Asking, OfBus};
use super::ppo_drives::parameters as ppo_parameters;
use super::problem::{Problem, Problems};
use super::stations::values;
use super::stream::{Hub, Lost, NewsEvent, TelegramEvent};
use super::{
    bus, drives, faults, history, inputs, page, parameters, ppo_drives, stations, stream, switches, why,
};

/// What the handlers share.
#[derive(Clone)]
pub(super) struct App {
    pub(super) asking: Asking,
    pub(super) hub: Hub,
}

impl FromRef<App> for Asking {
    fn from_ref(app: &App) -> Self {
        app.asking.clone()
    }
}

impl FromRef<App> for Hub {
    fn from_ref(app: &App) -> Self {
        app.hub.clone()
    }
}

pub(super) fn router(app: App) -> Router {
    Router::new()
        .route("/api/v1/openapi.json", get(description))
        .route("/api/v1/drives", get(drives::list).post(drives::add))
        .route("/api/v1/drives/{address}", get(drives::state).delete(drives::remove))
        .route(
            "/api/v1/drives/{address}/inputs",
            get(inputs::read::<OfBus>).patch(inputs::change::<OfBus>).delete(inputs::nominal::<OfBus>),
        )
        .route("/api/v1/drives/{address}/provoke", post(inputs::provoke::<OfBus>))
        .route("/api/v1/drives/{address}/keys", post(inputs::press::<OfBus>))
        .route("/api/v1/drives/{address}/power", put(inputs::power::<OfBus>))
        .route("/api/v1/drives/{address}/switches", get(switches::read).put(switches::set))
        .route("/api/v1/drives/{address}/parameters", get(parameters::list))
        .route("/api/v1/stations", get(stations::list))
        .route("/api/v1/stations/{address}", get(stations::state).delete(stations::remove))
        .route("/api/v1/stations/{address}/texts", get(stations::texts))
        .route("/api/v1/stations/{address}/inputs", delete(stations::release_all))
        .route("/api/v1/stations/{address}/diagnosis", put(stations::raise).delete(stations::end_diagnosis))
        .route(
            "/api/v1/stations/{address}/inputs/{slot}/{octet}/{type}",
            get(values::read_input).put(values::force).delete(values::release),
        )
        .route("/api/v1/stations/{address}/outputs/{slot}/{octet}/{type}", get(values::read_output))
        .route("/api/v1/ppo-drives", get(ppo_drives::list))
        .route("/api/v1/ppo-drives/{address}", get(ppo_drives::state).delete(ppo_drives::remove))
        .route("/api/v1/ppo-drives/{address}/fault", post(ppo_drives::fault))
        .route("/api/v1/ppo-drives/{address}/warning", put(ppo_drives::warning))
        .route("/api/v1/ppo-drives/{address}/load", put(ppo_drives::load))
        .route("/api/v1/ppo-drives/{address}/parameters", get(ppo_parameters::list))
        .route("/api/v1/ppo-drives/{address}/why", get(ppo_drives::why::why))
        .route("/api/v1/drives/{address}/why", get(why::why))
        .route("/api/v1/drives/{address}/samples", get(history::samples))
        .route("/api/v1/drives/{address}/samples.csv", get(history::samples_csv))
        .route("/api/v1/capture.pcapng", get(history::capture))
        .route("/api/v1/bus", get(bus::state))
        .route(
            "/api/v1/bus/faults",
            get(faults::list::<OfBus>)
                .post(faults::add::<OfBus>)
                .put(faults::replace::<OfBus>)
                .delete(faults::clear::<OfBus>),
        )
        .route("/api/v1/bus/faults/{number}", delete(faults::remove::<OfBus>))
        .route_layer(middleware::from_fn(without_parameters))
        // These refuse parameters that they do not know themselves.
        .route("/api/v1/drives/{address}/parameters/{pnu}", get(parameters::read).put(parameters::write))
        .route(
            "/api/v1/ppo-drives/{address}/parameters/{pnu}",
            get(ppo_parameters::read).put(ppo_parameters::write),
        )
        .route("/api/v1/events", get(stream::events))
        .route("/api/v1/events/recent", get(history::events))
        .route("/", get(page::index))
        .route("/page/{name}", get(page::file))
        .fallback(nothing_there)
        .method_not_allowed_fallback(not_so)
        .with_state(app)
}

/// The description of the API.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "profidrive",
        description = "See emulated PROFIBUS-DP drives and control what acts on them. Values carry their unit in their \
            name. A request that is refused changes nothing.",
    ),
    paths(
        description,
        drives::list,
        drives::add,
        drives::state,
        drives::remove,
        inputs::read,
        inputs::change,
        inputs::nominal,
        inputs::provoke,
        inputs::press,
        inputs::power,
        switches::read,
        switches::set,
        parameters::list,
        parameters::read,
        parameters::write,
        stations::list,
        stations::state,
        stations::texts,
        stations::remove,
        stations::release_all,
        stations::raise,
        stations::end_diagnosis,
        values::read_input,
        values::force,
        values::release,
        values::read_output,
        ppo_drives::list,
        ppo_drives::state,
        ppo_drives::remove,
        ppo_drives::fault,
        ppo_drives::warning,
        ppo_drives::load,
        ppo_drives::why::why,
        ppo_parameters::list,
        ppo_parameters::read,
        ppo_parameters::write,
        why::why,
        history::events,
        history::samples,
        history::samples_csv,
        history::capture,
        bus::state,
        faults::list,
        faults::add,
        faults::replace,
        faults::clear,
        faults::remove,
        stream::events,
    ),
    components(schemas(Problem, NewsEvent, TelegramEvent, Lost))
)]
struct Description;

/// The description of the API
#[utoipa::path(get, path = "/api/v1/openapi.json", tag = "description",
    responses((status = 200, description = "OpenAPI 3.1", body = serde_json::Value), Problems))]
async fn description() -> Json<utoipa::openapi::OpenApi> {
    Json(Description::openapi())
}

/// Refuses what stands behind the question mark, for operations that know no parameter.
pub(super) async fn without_parameters(request: Request, next: Next) -> Result<Response, Problem> {
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

pub(super) async fn nothing_there(uri: Uri) -> Problem {
    Problem::not_found(format!(
        "there is nothing at {}; the API is described at /api/v1/openapi.json",
        uri.path()
    ))
}

pub(super) async fn not_so(method: Method, uri: Uri) -> Problem {
    Problem::new(
        StatusCode::METHOD_NOT_ALLOWED,
        format!(
            "{} does not take {method}; the header Allow says what it takes, the API is described at \
             /api/v1/openapi.json",
            uri.path()
        ),
    )
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// The methods and paths of a router, by its text: the router does not tell them.
    pub(in crate::panel) fn routed(text: &str) -> BTreeSet<String> {
        let begin = text.find("Router::new()").unwrap();
        let end = begin + text[begin..].find(".fallback(").unwrap();
        let mut routes = BTreeSet::new();
        for route in text[begin..end].split(".route(").skip(1) {
            let path = route.split('"').nth(1).unwrap();
            for method in ["get", "post", "put", "patch", "delete"] {
                let handled = [" ", ".", "("].iter().any(|before| {
                    let call = format!("{before}{method}(");
                    route.split('"').nth(2).unwrap().contains(&call)
                });
                if handled && path.starts_with("/api/") {
                    routes.insert(format!("{method} {path}"));
                }
            }
        }
        routes
    }

    /// The methods and paths of a description.
    pub(in crate::panel) fn described(description: &utoipa::openapi::OpenApi) -> BTreeSet<String> {
        let description = serde_json::to_value(description).unwrap();
        let mut described = BTreeSet::new();
        for (path, methods) in description["paths"].as_object().unwrap() {
            described.extend(methods.as_object().unwrap().keys().map(|method| format!("{method} {path}")));
        }
        described
    }

    #[test]
    fn every_route_is_described_with_every_method() {
        let routes = routed(include_str!("routes.rs"));
        assert!(routes.len() >= 22, "{routes:?}");
        assert_eq!(routes, described(&Description::openapi()));
    }
}
