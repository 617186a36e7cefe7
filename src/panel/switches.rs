//! The ten DIP switches under the cover.

use axum::Json;
use axum::extract::State;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bus_access::Asking;
use super::problem::{Body, Problem, Problems, Station};
use crate::devices::ag03::param::DefaultSet;
use crate::devices::ag03::profibus::dip::Terminator;
use crate::devices::ag03::profibus::{Device, DipSwitches};

/// The DIP switches of a drive and what they mean. They are read when the drive is switched on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(super) struct Switches {
    /// SW1 to SW10, `true` = ON.
    #[schema(min_items = 10, max_items = 10)]
    positions: Vec<bool>,
    /// The address they say. The drive has the one it was switched on with.
    address: u8,
    /// SW8 is ON with a pattern of these parameters: they are reset when the drive is switched on.
    factory_reset: Option<ResetSet>,
    /// What SW9 and SW10 make of the bus terminator.
    terminator: TerminatorState,
}

/// The parameters of a factory reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum ResetSet {
    All,
    Standard,
    Controller,
}

/// The bus terminator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum TerminatorState {
    Inactive,
    Active,
    /// Only one of SW9 and SW10 is ON: the manual warns of it (chapter 7.10).
    Half,
}

/// New positions of all ten DIP switches.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SwitchesChange {
    /// SW1 to SW10, `true` = ON.
    #[schema(min_items = 10, max_items = 10)]
    positions: Vec<bool>,
}

/// The DIP switches
#[utoipa::path(get, path = "/api/v1/drives/{address}/switches", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = Switches), Problems))]
pub(super) async fn read(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<Switches>, Problem> {
    asking.ask(move |bench| bench.with_drive(address, |device| Json(Switches::of(device)))).await?
}

/// Sets all ten DIP switches
///
/// They are read when the drive is switched on next.
#[utoipa::path(put, path = "/api/v1/drives/{address}/switches", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    request_body = SwitchesChange, responses((status = 200, body = Switches), Problems))]
pub(super) async fn set(
    State(asking): State<Asking>,
    Station(address): Station,
    Body(SwitchesChange { positions }): Body<SwitchesChange>,
) -> Result<Json<Switches>, Problem> {
    if positions.len() != SWITCHES {
        let got = positions.len();
        return Err(Problem::value(format!("positions must have {SWITCHES} values, SW1 first, got {got}")));
    }
    let bits = positions.iter().rev().fold(0, |bits, on| bits << 1 | u16::from(*on));
    asking
        .ask(move |bench| {
            bench.with_drive(address, |device| {
                device.set_switches(DipSwitches::from_bits(bits));
                Json(Switches::of(device))
            })
        })
        .await?
}

/// How many there are.
const SWITCHES: usize = 10;

impl Switches {
    pub(super) fn of(device: &Device) -> Self {
        let config = device.config();
        let switches = config.switches;
        Self {
            positions: (0..SWITCHES).map(|switch| switches.bits() >> switch & 1 != 0).collect(),
            address: switches.address().number(),
            factory_reset: config.reset_patterns.requested(switches).map(ResetSet::from),
            terminator: switches.terminator().into(),
        }
    }
}

impl From<DefaultSet> for ResetSet {
    fn from(set: DefaultSet) -> Self {
        match set {
            DefaultSet::All => Self::All,
            DefaultSet::Standard => Self::Standard,
            DefaultSet::Controller => Self::Controller,
        }
    }
}

impl From<Terminator> for TerminatorState {
    fn from(terminator: Terminator) -> Self {
        match terminator {
            Terminator::Inactive => Self::Inactive,
            Terminator::Active => Self::Active,
            Terminator::Half => Self::Half,
        }
    }
}
