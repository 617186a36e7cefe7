//! What was, over HTTP.

use core::fmt::Write;
use core::time::Duration;
use std::collections::BTreeMap;
use std::time::SystemTime;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};

#[cfg(test)]
use super::super::description::Problems;
use super::super::line::{Lines, lacks};
use super::super::problem::{Problem, QueryOf};
use super::super::routes::{OfLineName, Place};
use super::super::station::{AmountState, seconds};
use super::super::stream::NewsEvent;
use super::samples::{Curves, EVERY, of_station};
use crate::host::capture::{self, Wire};
use crate::time::Instant;

/// The newest events.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct RecentEvents {
    /// When the process was started, since 1970: another start has another history.
    started_unix_seconds: f64,
    /// Oldest first, 1000 at most.
    events: Vec<NewsEvent>,
}

/// The curves of a station.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct RecentSamples {
    /// Between two samples. Of a station at rest only the first and the newest are there.
    interval_milliseconds: u64,
    /// Oldest first, of five minutes.
    samples: Vec<Sample>,
}

/// What the values were at a moment, by their keys; `null`: there was none.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct Sample {
    /// Since the line was started.
    time_seconds: f64,
    #[serde(flatten)]
    #[cfg_attr(test, schema(value_type = std::collections::HashMap<String, Option<f64>>))]
    values: BTreeMap<&'static str, AmountState>,
}

/// No event has a greater number: what clients read as 64 bits with a sign.
const LAST_EVENT: u64 = i64::MAX.unsigned_abs();

/// Of whom, and since when.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::panel) struct OfWhom {
    line: Option<String>,
    address: Option<u8>,
    after: Option<u64>,
}

/// The newest events
///
/// What the stream has sent as `news`: for a reader that starts later.
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/events/recent", tag = "history",
    params(
        ("line" = Option<String>, Query, description = "Only what concerns this line"),
        ("address" = Option<u8>, Query, maximum = 127, description = "Only what concerns this station"),
        ("after" = Option<u64>, Query, description = "Only events with a greater number"),
    ),
    responses((status = 200, body = RecentEvents), Problems)))]
pub(in crate::panel) async fn events(
    State(lines): State<Lines>,
    QueryOf(OfWhom { line, address, after }): QueryOf<OfWhom>,
) -> Result<Json<RecentEvents>, Problem> {
    let line = line.map(|name| lines.named(&name)).transpose()?.map(|line| line.name);
    address.map_or(Ok(()), |address| lines.check(address))?;
    if let Some(after) = after.filter(|after| *after > LAST_EVENT) {
        let words = format!("after is outside 0 to {LAST_EVENT}, got {after}");
        return Err(Problem::new(StatusCode::BAD_REQUEST, words));
    }
    lines.all().iter().for_each(|line| line.hub.drain());
    let events = lines.readers().events(|events| {
        let events = events.iter().map(|(_, news)| news);
        let of = events.filter(|news| news.concerns(line.as_deref(), address));
        of.filter(|news| after.is_none_or(|after| news.is_after(after))).cloned().collect()
    });
    let started_unix_seconds = since_1970(lines.readers().started()).as_secs_f64();
    Ok(Json(RecentEvents { started_unix_seconds, events }))
}

/// The curves of a station of the last five minutes
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/samples", tag = "history",
    responses((status = 200, body = RecentSamples), Problems)))]
pub(in crate::panel) async fn samples(place: Place) -> Result<Json<RecentSamples>, Problem> {
    let Curves { columns, rows } = curves(&place).await?;
    let interval_milliseconds = u64::try_from(EVERY.as_millis()).unwrap_or(u64::MAX);
    let sample = |(at, row): (Instant, Box<[f64]>)| {
        let values = columns.iter().zip(row).map(|((key, digits), value)| (*key, cell(value, *digits)));
        Sample { time_seconds: seconds(at), values: values.collect() }
    };
    Ok(Json(RecentSamples { interval_milliseconds, samples: rows.into_iter().map(sample).collect() }))
}

/// A number, unless there was none.
fn cell(value: f64, digits: Option<u8>) -> AmountState {
    if value.is_nan() { AmountState::Unknown } else { AmountState::of_number(value, digits) }
}

/// The same as a table
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/samples.csv", tag = "history",
    responses((status = 200, content_type = "text/csv", body = String), Problems)))]
pub(in crate::panel) async fn samples_csv(place: Place) -> Result<Response, Problem> {
    let Curves { columns, rows } = curves(&place).await?;
    let mut table = String::from("time_seconds");
    columns.iter().for_each(|(key, _)| table.extend([",", *key]));
    table.push_str("\r\n");
    for (at, row) in rows {
        // Writing to a text works always.
        let _ = write!(table, "{}", seconds(at));
        for value in row {
            let _ = if value.is_nan() { table.write_str(",") } else { write!(table, ",{value}") };
        }
        table.push_str("\r\n");
    }
    let name = format!("station-{}.csv", place.address);
    Ok(saved_as(&name, "text/csv; charset=utf-8", table.into_bytes()))
}

/// The telegrams or frames of a line that were watched, with the events as comments
///
/// A capture for Wireshark. Telegrams are kept while a reader of the stream watches them, the newest 4 MiB. An event is a
/// comment of the telegram after it, or of the last one.
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/capture.pcapng", tag = "history", responses((status = 200, content_type = "application/octet-stream", body = String), Problems)))]
pub(in crate::panel) async fn capture(
    State(lines): State<Lines>,
    OfLineName(line): OfLineName,
) -> Result<Response, Problem> {
    let (now, baud, rate) =
        line.asking.ask(|lent| (lent.now(), lent.baud(), lent.state().rate_bits_per_second)).await?;
    let wire = baud.map_or(Wire::Can(rate), Wire::Profibus);
    let epoch = since_1970(SystemTime::now()).saturating_sub(now.saturating_since(Instant::ZERO));
    let batch = line.hub.history(|history| history.recording.batch());
    let happened: Vec<_> = lines.readers().events(|events| {
        let own = events.iter().filter(|(_, news)| news.concerns(Some(&line.name), None));
        own.map(|(at, news)| (*at, news.text().to_string())).collect()
    });
    let octets = capture::to_octets(wire, ("panel", "recorded in the panel"), epoch, &batch, happened);
    let octets = octets.map_err(|error| Problem::new(StatusCode::INTERNAL_SERVER_ERROR, error))?;
    Ok(saved_as("profidrive.pcapng", "application/octet-stream", octets))
}

async fn curves(place: &Place) -> Result<Curves, Problem> {
    let has = place.ask(|lent, address| Ok(!of_station(lent.find(address)?.description).0.is_empty()));
    if !has.await? {
        return Err(lacks(place.address, "samples"));
    }
    Ok(place.line.hub.history(|history| history.samples.of(place.address)))
}

/// How long a time is after the beginning of 1970.
fn since_1970(time: SystemTime) -> Duration {
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
