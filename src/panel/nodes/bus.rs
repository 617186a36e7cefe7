//! The bus as such: its rate and what has passed.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::super::faults::{self, FaultState};
use super::super::problem::{Problem, Problems};
use super::super::state::seconds;
use super::access::{Asking, Seated};
use crate::can_bus::can::ErrorState;
use crate::host::can::StoredNode;

/// The rate of the bus, and what has passed so far.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct CanBus {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    rate_bits_per_second: u32,
    /// Frames that ended without error.
    frames: u64,
    /// Remote requests among them.
    remote_requests: u64,
    error_frames: u64,
    /// How long bits were on the wire.
    busy_seconds: f64,
    nodes: Vec<BusNode>,
    /// The faults on purpose.
    faults: Vec<FaultState>,
}

/// A node as the bus sees it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct BusNode {
    address: u8,
    error_state: ErrorStateName,
}

/// Where the error counters of a CAN controller have taken it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum ErrorStateName {
    ErrorActive,
    ErrorPassive,
    BusOff,
}

impl From<ErrorState> for ErrorStateName {
    fn from(state: ErrorState) -> Self {
        match state {
            ErrorState::Active => Self::ErrorActive,
            ErrorState::Passive => Self::ErrorPassive,
            ErrorState::BusOff => Self::BusOff,
        }
    }
}

/// Rate and counters of the bus
#[utoipa::path(get, path = "/api/v1/bus", tag = "bus", responses((status = 200, body = CanBus), Problems))]
pub(super) async fn state(State(asking): State<Asking>) -> Result<Json<CanBus>, Problem> {
    asking
        .ask(|bench| {
            let counters = bench.bus.counters();
            let node = |seated: &Seated| {
                let address = bench.bus.participant::<StoredNode>(seated.seat)?.node_id().number();
                let error_state = bench.bus.confinement(seated.seat)?.state().into();
                Some(BusNode { address, error_state })
            };
            Json(CanBus {
                time_seconds: seconds(bench.now),
                rate_bits_per_second: bench.bus.rate().bits_per_second(),
                frames: counters.frames,
                remote_requests: counters.remote,
                error_frames: counters.errors,
                busy_seconds: counters.busy.as_secs_f64(),
                nodes: bench.nodes.iter().filter_map(node).collect(),
                faults: faults::states(bench).unwrap_or_default(),
            })
        })
        .await
}
