//! A line as JSON: its rate, what passed on it, who is on it, its faults on purpose.

use core::time::Duration;
use std::collections::BTreeMap;

use axum::Json;
use axum::extract::State;
use serde::Serialize;

#[cfg(test)]
use super::super::description::Problems;
use super::super::problem::Problem;
use super::super::station::seconds;
use super::faults::{self, FaultState};
use super::{Line, Lines, OnLine};
use crate::can_bus::can::ErrorState;
use crate::host::Presence;
use crate::host::can::bus;
use crate::host::fault::{BusKind, Row};
use crate::host::list::{DEVICES, Device, Group, Takes};
use crate::panel::routes::OfLineName;
use crate::profibus::fdl::{LineCounters, StationCounters};

/// The lines of the process.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct LineList {
    /// Since the first line was started.
    time_seconds: f64,
    lines: Vec<LineSummary>,
}

/// A line.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct LineSummary {
    /// Its name.
    line: String,
    bus: BusKind,
    /// What a master opens.
    link: String,
    rate_bits_per_second: u32,
}

/// A line with what passed on it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct LineState {
    #[serde(flatten)]
    summary: LineSummary,
    /// Since the line was started.
    time_seconds: f64,
    #[serde(flatten)]
    counters: Counters,
    stations: Vec<LineStation>,
    /// The faults on purpose.
    faults: Vec<FaultState>,
    /// What faults there can be.
    fault_kinds: Vec<FaultKind>,
    /// What may be added here without a file.
    devices: Vec<DeviceChoice>,
}

/// What passed on a line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(untagged)]
pub(in crate::panel) enum Counters {
    Profibus(ProfibusCounters),
    Can(FrameCounters),
}

/// What passed on a line of PROFIBUS.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct ProfibusCounters {
    telegrams_sent: u64,
    telegrams_heard: Vec<Count>,
    /// Octets that were no telegram, by reason.
    rejected: Vec<Count>,
    /// How often the next telegram had to be searched for.
    resyncs: u64,
}

/// What passed on a bus of CAN.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct FrameCounters {
    /// Frames that ended without error.
    frames: u64,
    /// Remote requests among them.
    remote_requests: u64,
    error_frames: u64,
    /// How long bits were on the wire.
    busy_seconds: f64,
}

/// How often something happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct Count {
    what: &'static str,
    count: u64,
}

/// A station as the line sees it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct LineStation {
    pub(super) address: u8,
    /// As on the command line.
    pub(super) device: &'static str,
    pub(super) presence: Option<Presence>,
    /// The master that owns the slave; `null`: none does, or it is no slave of ours.
    pub(super) owner_address: Option<u8>,
    /// What it was asked and answered, by names.
    pub(super) counters: BTreeMap<&'static str, u64>,
    /// How many replies took how long from the last octet of the request, the shortest first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reply_times: Option<Vec<ReplyTime>>,
    /// Where the error counters of its CAN controller have taken it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) error_state: Option<ErrorStateName>,
}

/// Replies that took about as long.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct ReplyTime {
    /// Up to and including this, and longer than the one before; `null`: any longer time.
    up_to_microseconds: Option<u64>,
    count: u64,
}

/// Where the error counters of a CAN controller have taken it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub(in crate::panel) enum ErrorStateName {
    ErrorActive,
    ErrorPassive,
    BusOff,
}

/// A kind of fault on purpose.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct FaultKind {
    /// How it is written: `late=20ms`.
    fault: String,
    /// What the master gets.
    text: &'static str,
}

/// A device that may be added.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct DeviceChoice {
    device: &'static str,
    text: &'static str,
}

/// What a line counts.
pub(in crate::panel) struct Counted {
    pub(in crate::panel) rate_bits_per_second: u32,
    pub(super) counters: Counters,
    pub(super) stations: Vec<LineStation>,
}

impl Counters {
    pub(super) fn of_profibus(counters: &LineCounters) -> Self {
        let counts = |named: &[(&'static str, u64)]| {
            named.iter().map(|(what, count)| Count { what, count: *count }).collect()
        };
        Self::Profibus(ProfibusCounters {
            telegrams_sent: counters.sent,
            telegrams_heard: counts(&counters.heard.kinds()),
            rejected: counts(&counters.rejected.reasons()),
            resyncs: counters.resyncs,
        })
    }

    pub(super) const fn of_can(counters: &bus::Counters) -> Self {
        Self::Can(FrameCounters {
            frames: counters.frames,
            remote_requests: counters.remote,
            error_frames: counters.errors,
            busy_seconds: counters.busy.as_secs_f64(),
        })
    }
}

impl ReplyTime {
    pub(super) fn of(counters: &StationCounters) -> Vec<Self> {
        let microseconds = |limit: Duration| u64::try_from(limit.as_micros()).unwrap_or(u64::MAX);
        let times = counters.latency.buckets();
        times.map(|(limit, count)| Self { up_to_microseconds: limit.map(microseconds), count }).collect()
    }
}

impl ErrorStateName {
    pub(super) const fn of(state: ErrorState) -> Self {
        match state {
            ErrorState::Active => Self::ErrorActive,
            ErrorState::Passive => Self::ErrorPassive,
            ErrorState::BusOff => Self::BusOff,
        }
    }
}

impl FaultKind {
    fn of(bus: BusKind) -> Vec<Self> {
        let rows = Row::all().iter().filter(|row| row.way.bus() == bus);
        rows.map(|row| Self { fault: row.example(), text: row.effect }).collect()
    }
}

impl DeviceChoice {
    /// What needs no file, on this bus.
    fn of(bus: BusKind) -> Vec<Self> {
        let is_here = |device: &&Device| (device.group() == Group::Node) == (bus == BusKind::Can);
        let needs_none = |device: &&Device| {
            device.choices().iter().all(|choice| !(choice.required && matches!(choice.takes, Takes::File(_))))
        };
        let choice = |device: &'static Device| {
            let text = device.product().map_or(device.name(), |product| product.sheet.product_name);
            Self { device: device.name(), text }
        };
        DEVICES.iter().filter(is_here).filter(needs_none).map(choice).collect()
    }
}

impl LineSummary {
    fn of(line: &Line, rate_bits_per_second: u32) -> Self {
        let Line { name, kind, link, .. } = line;
        Self { line: name.as_ref().into(), bus: *kind, link: link.as_ref().into(), rate_bits_per_second }
    }
}

/// The lines of the process
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines", tag = "lines", responses((status = 200, body = LineList), Problems)))]
pub(in crate::panel) async fn list(State(lines): State<Lines>) -> Result<Json<LineList>, Problem> {
    let mut all = LineList { time_seconds: 0.0, lines: Vec::new() };
    for line in lines.all() {
        let (now, counted) = line.asking.ask(|line| (line.now(), line.state())).await?;
        all.time_seconds = seconds(now).max(all.time_seconds);
        all.lines.push(LineSummary::of(&line, counted.rate_bits_per_second));
    }
    Ok(Json(all))
}

/// Stations, counters and faults of a line
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}", tag = "lines", responses((status = 200, body = LineState), Problems)))]
pub(in crate::panel) async fn state(OfLineName(line): OfLineName) -> Result<Json<LineState>, Problem> {
    let look =
        |line: &mut (dyn OnLine + '_)| (line.now(), line.state(), faults::states(line).unwrap_or_default());
    let (now, Counted { rate_bits_per_second, counters, stations }, faults) = line.asking.ask(look).await?;
    Ok(Json(LineState {
        summary: LineSummary::of(&line, rate_bits_per_second),
        time_seconds: seconds(now),
        counters,
        stations,
        faults,
        fault_kinds: FaultKind::of(line.kind),
        devices: DeviceChoice::of(line.kind),
    }))
}
