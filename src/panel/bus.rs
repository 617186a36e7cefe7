//! The bus: its stations, its counters, the faults on its line.

use core::time::Duration;

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::bus_access::{Asking, BusAccess};
use super::faults::{self, FaultState};
use super::problem::{Problem, Problems};
use super::state::{Counters, PresenceState, seconds};
use crate::host::{GsdStation, HostedPpoDrive};
use crate::profibus::fdl::{Address, StationCounters};

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

/// Stations, counters and faults of the bus
#[utoipa::path(get, path = "/api/v1/bus", tag = "bus", responses((status = 200, body = BusState), Problems))]
pub(super) async fn state(State(asking): State<Asking>) -> Result<Json<BusState>, Problem> {
    asking.ask(|bench| Json(BusState::of(bench))).await
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
            faults: faults::states(bench).unwrap_or_default(),
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
