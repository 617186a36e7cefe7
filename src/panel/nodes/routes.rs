//! Every path of the panel of a bus of CAN, and the OpenAPI description of all of them.

use axum::extract::FromRef;
use axum::middleware;
use axum::routing::{delete, get, post, put};
use axum::{Json, Router};
use std::sync::Arc;
use utoipa::OpenApi;

use super::super::inputs;
use super::super::problem::{Problem, Problems};
use super::super::routes::{not_so, nothing_there, without_parameters};
use super::super::stream::Lost;
use super::access::{Asking, OfNodes};
use super::news::{Feed, FrameEvent, NodeNews};
use super::{bus, fleet, history, objects, state, stream, why};
use crate::panel::{faults, page};

/// What the handlers share.
#[derive(Clone)]
pub(super) struct App {
    pub(super) asking: Asking,
    pub(super) feed: Arc<Feed>,
}

impl FromRef<App> for Asking {
    fn from_ref(app: &App) -> Self {
        app.asking.clone()
    }
}

impl FromRef<App> for Arc<Feed> {
    fn from_ref(app: &App) -> Self {
        Self::clone(&app.feed)
    }
}

pub(super) fn router(app: App) -> Router {
    Router::new()
        .route("/api/v1/openapi.json", get(description))
        .route("/api/v1/drives", get(state::list).post(fleet::add))
        .route("/api/v1/drives/{address}", get(state::state).delete(fleet::remove))
        .route("/api/v1/drives/{address}/why", get(why::why))
        .route(
            "/api/v1/drives/{address}/inputs",
            get(inputs::read::<OfNodes>).patch(inputs::change::<OfNodes>).delete(inputs::nominal::<OfNodes>),
        )
        .route("/api/v1/drives/{address}/provoke", post(inputs::provoke::<OfNodes>))
        .route("/api/v1/drives/{address}/keys", post(inputs::press::<OfNodes>))
        .route("/api/v1/drives/{address}/power", put(inputs::power::<OfNodes>))
        .route("/api/v1/drives/{address}/objects", get(objects::list))
        .route("/api/v1/drives/{address}/objects/{index}/{sub}", get(objects::read).put(objects::write))
        .route("/api/v1/bus", get(bus::state))
        .route(
            "/api/v1/bus/faults",
            get(faults::list::<OfNodes>)
                .post(faults::add::<OfNodes>)
                .put(faults::replace::<OfNodes>)
                .delete(faults::clear::<OfNodes>),
        )
        .route("/api/v1/bus/faults/{number}", delete(faults::remove::<OfNodes>))
        .route_layer(middleware::from_fn(without_parameters))
        // These refuse parameters that they do not know themselves.
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
        description = "See emulated CANopen nodes and control what acts on them; the node number is the address. Values \
            carry their unit in their name. A request that is refused changes nothing.",
    ),
    paths(
        description,
        state::list,
        state::state,
        fleet::add,
        fleet::remove,
        why::why,
        inputs::read,
        inputs::change,
        inputs::nominal,
        inputs::provoke,
        inputs::press,
        inputs::power,
        objects::list,
        objects::read,
        objects::write,
        bus::state,
        faults::list,
        faults::add,
        faults::replace,
        faults::clear,
        faults::remove,
        stream::events,
        history::events,
    ),
    components(schemas(Problem, NodeNews, FrameEvent, Lost))
)]
pub(super) struct Description;

/// The description of the API
#[utoipa::path(get, path = "/api/v1/openapi.json", tag = "description",
    responses((status = 200, description = "OpenAPI 3.1", body = serde_json::Value), Problems))]
async fn description() -> Json<utoipa::openapi::OpenApi> {
    Json(Description::openapi())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::routes::tests::{described, routed};

    #[test]
    fn every_route_is_described_with_every_method() {
        let routes = routed(include_str!("routes.rs"));
        assert!(routes.len() >= 23, "{routes:?}");
        assert_eq!(routes, described(&Description::openapi()));
    }
}
