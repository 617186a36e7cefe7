//! Which nodes there are, and the complete state of each.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::super::inputs::{self, InputRange, InputValues, KeyState, PowerName, Provocation};
use super::super::problem::{Problem, Problems};
use super::super::state::seconds;
use super::access::{Asking, NodeAccess, Number, power};
use super::words::{self, HistoryEntry, NodeWord, Pdo, whole};
use crate::can_bus::canopen::Address;
use crate::devices::CanopenDevice;
use crate::face::surroundings::{Face, Glow};
use crate::host::can::Product;
use crate::time::Instant;

/// The nodes of a bus.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Nodes {
    /// When this was so, since the bus was started.
    pub(super) time_seconds: f64,
    pub(super) drives: Vec<NodeSummary>,
}

/// What is to be known about a node at a glance.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct NodeSummary {
    /// The node number.
    #[schema(minimum = 1, maximum = 127)]
    pub(super) address: u8,
    /// As on the command line: `ag03-1`, `ap10`, `asda-a2`.
    device: &'static str,
    /// The name of the product.
    product: &'static str,
    power: PowerName,
    /// `PRE-OPERATIONAL`, `OPERATIONAL` or `STOPPED`; `null` while it is switched off.
    nmt_state: Option<String>,
    /// 1001h; `null` while it is switched off.
    error_register: Option<u8>,
    display: DisplayState,
}

/// What a person sees of the device.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct DisplayState {
    /// All of it in one line.
    text: String,
    /// The rows of the display from above: of the AP10 two, of the ASDA-A2 its five digits, of the AG03/1 none.
    lines: Vec<DisplayLine>,
    /// `clockwise` or `counter-clockwise`: which way to turn the shaft of an AP10.
    arrow: Option<&'static str>,
    /// What else is lit on the display, as `battery empty`.
    signs: Vec<&'static str>,
    leds: Vec<LedState>,
}

/// A row of a display.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct DisplayLine {
    text: String,
    flashing: bool,
}

/// An LED.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct LedState {
    /// Which, with its colour: `left green`.
    led: &'static str,
    glow: GlowName,
    /// How often it blinks before the pause: the code of a fault; 0 unless it does.
    blinks: u8,
}

/// What an LED does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum GlowName {
    Off,
    On,
    Blinking,
}

/// The complete state of a node.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct NodeState {
    /// When this was so, since the bus was started.
    pub(super) time_seconds: f64,
    #[serde(flatten)]
    pub(super) summary: NodeSummary,
    /// The control word and the status word.
    words: Vec<NodeWord>,
    pdos: Vec<Pdo>,
    /// 1003h, the newest first.
    emcy_history: Vec<HistoryEntry>,
    /// Why it would not move now; `null` for a device that cannot move.
    does_not_move: Option<Vec<String>>,
    inputs: InputValues,
    input_ranges: Vec<InputRange>,
    keys: Vec<KeyState>,
    /// The faults that can be made.
    faults: Vec<Provocation>,
}

/// All nodes at a glance
#[utoipa::path(get, path = "/api/v1/drives", tag = "nodes", responses((status = 200, body = Nodes), Problems))]
pub(super) async fn list(State(asking): State<Asking>) -> Result<Json<Nodes>, Problem> {
    asking.ask(|bench| Json(Nodes::of(bench))).await
}

/// The complete state of a node
#[utoipa::path(get, path = "/api/v1/drives/{address}", tag = "nodes",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), responses((status = 200, body = NodeState), Problems))]
pub(super) async fn state(
    State(asking): State<Asking>,
    Number(node): Number,
) -> Result<Json<NodeState>, Problem> {
    asking
        .ask(move |bench| {
            let (product, device) = bench.device(node)?;
            Ok(Json(NodeState::of(product, device, bench.now)))
        })
        .await?
}

impl Nodes {
    pub(super) fn of(bench: &NodeAccess<'_>) -> Self {
        let summary = |(product, device)| NodeSummary::of(product, device, bench.now);
        Self { time_seconds: seconds(bench.now), drives: bench.devices().map(summary).collect() }
    }

    /// Whether nothing has changed but time.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.drives == other.drives
    }
}

impl NodeSummary {
    pub(super) fn of(product: &'static Product, device: &dyn CanopenDevice, now: Instant) -> Self {
        let state = device.node().state();
        let register = state.and_then(|_| whole(device, Address::new(0x1001, 0)));
        Self {
            address: device.node_id().number(),
            device: product.name,
            product: product.sheet.product_name,
            power: power(device),
            nmt_state: state.map(|state| state.to_string()),
            error_register: register.and_then(|register| u8::try_from(register).ok()),
            display: DisplayState::of(&device.face(now)),
        }
    }
}

impl NodeState {
    pub(super) fn of(product: &'static Product, device: &dyn CanopenDevice, now: Instant) -> Self {
        let is_on = device.node().state().is_some();
        let mut reasons = Vec::new();
        if let Some(why) = device.why() {
            why.each_reason(&mut |reason| reasons.push(reason.to_string()));
        }
        Self {
            time_seconds: seconds(now),
            summary: NodeSummary::of(product, device, now),
            words: if is_on { words::words(product.vocabulary, device) } else { Vec::new() },
            pdos: if is_on { words::pdos(device) } else { Vec::new() },
            emcy_history: if is_on { words::history(product.vocabulary, device) } else { Vec::new() },
            does_not_move: device.is_drive().then_some(reasons),
            inputs: InputValues::of(device),
            input_ranges: inputs::ranges(device),
            keys: inputs::keys(device),
            faults: inputs::faults(device),
        }
    }

    /// Whether nothing has changed but time.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let timeless = |state: &Self| Self { time_seconds: 0.0, ..state.clone() };
        timeless(self) == timeless(other)
    }
}

impl DisplayState {
    fn of(face: &Face) -> Self {
        const ARROW: &str = "arrow ";
        let arrow = face.signs.iter().find_map(|sign| sign.strip_prefix(ARROW));
        let led = |led: &crate::face::surroundings::FaceLed| {
            let (glow, blinks) = match led.glow {
                Glow::Off => (GlowName::Off, 0),
                Glow::On => (GlowName::On, 0),
                Glow::Blinking => (GlowName::Blinking, 0),
                Glow::Code(times) => (GlowName::Blinking, times),
            };
            LedState { led: led.name, glow, blinks }
        };
        let line = |row: &crate::face::surroundings::FaceRow| DisplayLine {
            text: row.text.as_str().to_owned(),
            flashing: row.flashing,
        };
        Self {
            text: format!("{face}"),
            lines: face.rows.iter().map(line).collect(),
            arrow,
            signs: face.signs.iter().copied().filter(|sign| !sign.starts_with(ARROW)).collect(),
            leds: face.leds.iter().map(led).collect(),
        }
    }
}
