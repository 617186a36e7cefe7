//! What was, over HTTP.

use core::fmt::Write;
use core::time::Duration;
use std::time::SystemTime;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::super::bus_access::Asking;
use super::super::problem::{Problem, Problems, QueryOf, Station};
use super::super::stream::{Hub, NewsEvent};
use super::samples::{EVERY, Sample};
use crate::host::capture::{self, Interface};
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// The newest events.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(in crate::panel) struct RecentEvents {
    /// When the panel was started, since 1970: another start has another history.
    started_unix_seconds: f64,
    /// Oldest first, 1000 at most.
    events: Vec<NewsEvent>,
}

/// The samples of a drive.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(in crate::panel) struct RecentSamples {
    /// Between two samples. Of a drive at rest only the first and the newest are there.
    interval_milliseconds: u64,
    /// Oldest first, of five minutes.
    samples: Vec<Sample>,
}

/// Of whom.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::panel) struct OfWhom {
    pub(in crate::panel) address: Option<u8>,
}

/// The newest events
///
/// What the stream has sent as `news`: for a reader that starts later.
#[utoipa::path(get, path = "/api/v1/events/recent", tag = "history",
    params(("address" = Option<u8>, Query, maximum = 126, description = "Only what concerns this station")),
    responses((status = 200, body = RecentEvents), Problems))]
pub(in crate::panel) async fn events(
    State(hub): State<Hub>,
    QueryOf(of): QueryOf<OfWhom>,
) -> Result<Json<RecentEvents>, Problem> {
    let address = of.address.map(Address::station).transpose().map_err(Problem::value)?;
    let events = hub.history(|history| {
        let events = history.events.iter().map(|(_, news)| news);
        events.filter(|news| news.concerns(address)).cloned().collect()
    });
    let started_unix_seconds = since_1970(hub.started()).as_secs_f64();
    Ok(Json(RecentEvents { started_unix_seconds, events }))
}

/// The curves of a drive of the last five minutes
#[utoipa::path(get, path = "/api/v1/drives/{address}/samples", tag = "history", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = RecentSamples), Problems))]
pub(in crate::panel) async fn samples(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
) -> Result<Json<RecentSamples>, Problem> {
    let samples = samples_of(&asking, &hub, address).await?;
    let interval_milliseconds = u64::try_from(EVERY.as_millis()).unwrap_or(u64::MAX);
    Ok(Json(RecentSamples { interval_milliseconds, samples }))
}

/// The same as a table
#[utoipa::path(get, path = "/api/v1/drives/{address}/samples.csv", tag = "history", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, content_type = "text/csv", body = String), Problems))]
pub(in crate::panel) async fn samples_csv(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
    Station(address): Station,
) -> Result<Response, Problem> {
    let mut table = String::from(
        "time_seconds,position_user_units,user_unit,target_user_units,velocity_rpm,setpoint_rpm,current_milliamperes\r\n",
    );
    let cell = |value: Option<i32>| value.map(|value| value.to_string()).unwrap_or_default();
    for sample in samples_of(&asking, &hub, address).await? {
        let Sample { time_seconds, position_user_units, user_unit, target_user_units, .. } = &sample;
        let (target, rpm) = (cell(*target_user_units), cell(sample.setpoint_rpm));
        let Sample { velocity_rpm, current_milliamperes, .. } = sample;
        // Writing to a text works always.
        let _ = write!(
            table,
            "{time_seconds},{position_user_units},{user_unit},{target},{velocity_rpm},{rpm},{current_milliamperes}\r\n"
        );
    }
    Ok(saved_as(&format!("drive-{address}.csv"), "text/csv; charset=utf-8", table.into_bytes()))
}

/// The telegrams that were watched, with the events as comments
///
/// A capture for Wireshark. Telegrams are kept while a reader of the stream watches them, the newest 4 MiB. An event is a
/// comment of the telegram after it, or of the last one.
#[utoipa::path(get, path = "/api/v1/capture.pcapng", tag = "history",
    responses((status = 200, content_type = "application/octet-stream", body = String), Problems))]
pub(in crate::panel) async fn capture(
    State(asking): State<Asking>,
    State(hub): State<Hub>,
) -> Result<Response, Problem> {
    let (now, baud) = asking.ask(|bench| (bench.now, bench.bus.baud())).await?;
    let epoch = since_1970(SystemTime::now()).saturating_sub(now.saturating_since(Instant::ZERO));
    let (batch, events) = hub.history(|history| {
        let events: Vec<_> = history.events.iter().map(|(at, news)| (*at, news.text().to_string())).collect();
        (history.recording.batch(), events)
    });
    let line = Interface { name: "panel", description: "recorded in the panel", baud: Some(baud) };
    let octets = capture::to_octets(&line, epoch, &batch, events);
    let octets = octets.map_err(|error| Problem::new(StatusCode::INTERNAL_SERVER_ERROR, error))?;
    Ok(saved_as("profidrive.pcapng", "application/octet-stream", octets))
}

async fn samples_of(asking: &Asking, hub: &Hub, address: Address) -> Result<Vec<Sample>, Problem> {
    asking.ask(move |bench| bench.drive(address).map(drop).ok_or_else(|| bench.no_drive(address))).await??;
    Ok(hub.history(|history| history.samples.of(address).cloned().collect()))
}

/// How long a time is after the beginning of 1970.
pub(in crate::panel) fn since_1970(time: SystemTime) -> Duration {
    time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default()
}

/// An answer that a browser saves as a file.
fn saved_as(name: &str, media_type: &'static str, octets: Vec<u8>) -> Response {
    let disposition = HeaderValue::try_from(format!("attachment; filename=\"{name}\""))
        .unwrap_or(HeaderValue::from_static("attachment"));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static(media_type)),
        (header::CONTENT_DISPOSITION, disposition),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    ];
    (headers, octets).into_response()
}
