//! The bus: its stations, its counters, the faults on its line.

use core::time::Duration;
use std::format;
use std::prelude::v1::*;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bus_access::{Asking, BusAccess};
use super::problem::{Body, PathOf, Problem, Problems};
use super::state::{Counters, PresenceState, seconds};
use crate::host::link::fault::{Fault, Faults};
use crate::host::{GsdStation, HostedPpoDrive};
use crate::profibus::fdl::{Address, StationCounters};

/// Faults on the line at most.
const MOST_FAULTS: usize = 32;

/// The bus as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct BusState {
    /// Since the bus was started.
    time_seconds: f64,
    rate_bits_per_second: u32,
    telegrams_sent: u64,
    telegrams_heard: Vec<Count>,
    /// Octets that were no telegram, by reason.
    rejected: Vec<Count>,
    /// How often the next telegram had to be searched for.
    resyncs: u64,
    stations: Vec<StationState>,
    faults: Vec<FaultState>,
}

/// How often something happened.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Count {
    what: &'static str,
    count: u64,
}

/// A station of this bus, drive or not.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct StationState {
    address: u8,
    kind: StationKind,
    presence: PresenceState,
    /// The master that owns the slave; `null`: none does, or it is no DP slave of ours.
    owner_address: Option<u8>,
    counters: Counters,
    /// How many replies took how long from the last octet of the request, the shortest first.
    reply_times: Vec<ReplyTime>,
}

/// Replies that took about as long.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct ReplyTime {
    /// Up to and including this, and longer than the one before; `null`: any longer time.
    up_to_microseconds: Option<u64>,
    count: u64,
}

/// What a station is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum StationKind {
    Drive,
    /// From a GSD.
    GsdStation,
    /// A drive of PROFIDRIVE version 2.
    PpoDrive,
    Other,
}

/// A fault on the line.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct FaultState {
    /// Its number, with which it is removed.
    pub(super) number: u32,
    /// As on the command line, `emulate --fault`.
    pub(super) fault: String,
    /// How often it was injected.
    pub(super) injected: u32,
}

/// The faults on the line.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct FaultList {
    pub(super) faults: Vec<FaultState>,
}

/// A fault to add.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewFault {
    /// `FAULT[=VALUE][,rate=P][,count=N][,at=N][,seed=N][,station=ADDRESS][,service=NAME][,state=NAME][,retry=N]`, as for `emulate --fault`.
    #[schema(example = "late=20ms,station=5")]
    fault: String,
}

/// All faults that are to act.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewFaults {
    /// Each as for `emulate --fault`.
    #[schema(example = json!(["no-reply,rate=0.1"]), max_items = 32)]
    faults: Vec<String>,
}

/// Stations, counters and faults of the bus
#[utoipa::path(get, path = "/api/v1/bus", tag = "bus", responses((status = 200, body = BusState), Problems))]
pub(super) async fn state(State(asking): State<Asking>) -> Result<Json<BusState>, Problem> {
    asking.ask(|bench| Json(BusState::of(bench))).await
}

/// The faults on the line
#[utoipa::path(get, path = "/api/v1/bus/faults", tag = "bus", responses((status = 200, body = FaultList), Problems))]
pub(super) async fn faults(State(asking): State<Asking>) -> Result<Json<FaultList>, Problem> {
    asking.ask(|bench| Ok(Json(FaultList::of(line(bench)?)))).await?
}

/// Adds a fault to the line
#[utoipa::path(post, path = "/api/v1/bus/faults", tag = "bus", request_body = NewFault,
    responses((status = 201, body = FaultState), Problems))]
pub(super) async fn add_fault(
    State(asking): State<Asking>,
    Body(NewFault { fault }): Body<NewFault>,
) -> Result<(StatusCode, Json<FaultState>), Problem> {
    let fault = parse(&fault)?;
    let number = asking
        .ask(move |bench| {
            known(bench, &fault)?;
            let faults = line(bench)?;
            if faults.iter().count() >= MOST_FAULTS {
                return Err(Problem::conflict(format!(
                    "there are {MOST_FAULTS} faults on the line; remove some"
                )));
            }
            tracing::warn!("fault on purpose: {fault}");
            Ok(faults.add(fault))
        })
        .await??;
    Ok((StatusCode::CREATED, Json(FaultState { number, fault: fault.to_string(), injected: 0 })))
}

/// Replaces all faults on the line
#[utoipa::path(put, path = "/api/v1/bus/faults", tag = "bus", request_body = NewFaults,
    responses((status = 200, body = FaultList), Problems))]
pub(super) async fn replace_faults(
    State(asking): State<Asking>,
    Body(NewFaults { faults }): Body<NewFaults>,
) -> Result<Json<FaultList>, Problem> {
    if faults.len() > MOST_FAULTS {
        return Err(Problem::value(format!(
            "at most {MOST_FAULTS} faults are possible, got {}",
            faults.len()
        )));
    }
    let new = faults.iter().map(|fault| parse(fault)).collect::<Result<Vec<_>, _>>()?;
    asking
        .ask(move |bench| {
            new.iter().try_for_each(|fault| known(bench, fault))?;
            let faults = line(bench)?;
            faults.clear();
            for fault in new {
                tracing::warn!("fault on purpose: {fault}");
                faults.add(fault);
            }
            Ok(Json(FaultList::of(faults)))
        })
        .await?
}

/// Removes all faults of the line
#[utoipa::path(delete, path = "/api/v1/bus/faults", tag = "bus", responses((status = 204), Problems))]
pub(super) async fn clear_faults(State(asking): State<Asking>) -> Result<StatusCode, Problem> {
    asking
        .ask(|bench| {
            line(bench)?.clear();
            tracing::info!("all faults on purpose are taken off the line");
            Ok(StatusCode::NO_CONTENT)
        })
        .await?
}

/// Which fault.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct OfFault {
    number: String,
}

impl OfFault {
    pub(super) fn number(&self) -> Result<u32, Problem> {
        let Self { number } = self;
        let wrong = |_| Problem::new(StatusCode::BAD_REQUEST, format!("'{number}' is no number of a fault"));
        number.parse().map_err(wrong)
    }
}

/// Removes one fault of the line
#[utoipa::path(delete, path = "/api/v1/bus/faults/{number}", tag = "bus", params(("number" = u32, Path)),
    responses((status = 204), Problems))]
pub(super) async fn remove_fault(
    State(asking): State<Asking>,
    PathOf(of): PathOf<OfFault>,
) -> Result<StatusCode, Problem> {
    let number = of.number()?;
    asking
        .ask(move |bench| match line(bench)?.remove(number) {
            Some(fault) => {
                tracing::info!("fault on purpose taken off the line: {fault}");
                Ok(StatusCode::NO_CONTENT)
            }
            None => Err(Problem::not_found(format!("there is no fault number {number} on the line"))),
        })
        .await?
}

/// The faults of the line, if it can have some.
fn line<'a>(bench: &'a mut BusAccess<'_>) -> Result<&'a mut Faults, Problem> {
    bench.faults.as_deref_mut().ok_or_else(|| Problem::conflict("this line cannot have faults"))
}

/// Whether the station that a fault is for is on the line.
fn known(bench: &BusAccess<'_>, fault: &Fault) -> Result<(), Problem> {
    fault.check(bench.bus.addresses()).map_err(|error| Problem::value(error.to_string()))
}

fn parse(fault: &str) -> Result<Fault, Problem> {
    fault.parse::<Fault>().map_err(|error| Problem::value(format!("fault '{fault}': {error}")))
}

impl BusState {
    fn of(bench: &BusAccess<'_>) -> Self {
        let counters = bench.bus.counters();
        let counts = |named: &[(&'static str, u64)]| {
            named.iter().map(|(what, count)| Count { what, count: *count }).collect()
        };
        Self {
            time_seconds: seconds(bench.now),
            rate_bits_per_second: bench.bus.baud().bits_per_second(),
            telegrams_sent: counters.sent,
            telegrams_heard: counts(&counters.heard.kinds()),
            rejected: counts(&counters.rejected.reasons()),
            resyncs: counters.resyncs,
            stations: bench.bus.addresses().map(|address| StationState::of(bench, address)).collect(),
            faults: bench.faults.as_deref().map(FaultList::of).map(|list| list.faults).unwrap_or_default(),
        }
    }
}

impl StationKind {
    fn of(bench: &BusAccess<'_>, address: Address) -> Self {
        if bench.drive(address).is_some() {
            Self::Drive
        } else if bench.bus.station::<GsdStation>(address).is_some() {
            Self::GsdStation
        } else if bench.bus.station::<HostedPpoDrive>(address).is_some() {
            Self::PpoDrive
        } else {
            Self::Other
        }
    }
}

impl StationState {
    fn of(bench: &BusAccess<'_>, address: Address) -> Self {
        Self {
            address: address.number(),
            kind: StationKind::of(bench, address),
            presence: bench.bus.presence(address).into(),
            owner_address: owner(bench, address).map(Address::number),
            counters: bench.bus.station_counters(address).map(Counters::from).unwrap_or_default(),
            reply_times: bench.bus.station_counters(address).map(ReplyTime::of).unwrap_or_default(),
        }
    }
}

impl ReplyTime {
    fn of(counters: &StationCounters) -> Vec<Self> {
        let microseconds = |limit: Duration| u64::try_from(limit.as_micros()).unwrap_or(u64::MAX);
        let times = counters.latency.buckets();
        times.map(|(limit, count)| Self { up_to_microseconds: limit.map(microseconds), count }).collect()
    }
}

/// The master that owns a slave of this bus.
fn owner(bench: &BusAccess<'_>, address: Address) -> Option<Address> {
    if let Some(station) = bench.bus.station::<GsdStation>(address) {
        station.slave().owner()
    } else if let Some(hosted) = bench.bus.station::<HostedPpoDrive>(address) {
        hosted.drive().slave().owner()
    } else {
        bench.drive(address)?.slave().owner()
    }
}

impl FaultList {
    fn of(faults: &Faults) -> Self {
        let state = |(number, fault, injected): (u32, Fault, u32)| FaultState {
            number,
            fault: fault.to_string(),
            injected,
        };
        Self { faults: faults.iter().map(state).collect() }
    }
}
