//! What acts on a node from outside: its inputs, faults made on purpose, keys, the supply.

use std::format;
use std::prelude::v1::*;

use axum::Json;
use axum::extract::State;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::super::problem::{Body, Problem, Problems};
use super::access::{Asking, Number, unknown};
use crate::devices::CanopenDevice;
use crate::face::surroundings::{Declined, Input, InputKind, Level};

/// The inputs of a node: numbers, `true` or `false`, `null` for what follows from everything else. Which there are
/// depends on the device.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(value_type = std::collections::HashMap<String, Value>, example = json!({"blocked": false}))]
pub(super) struct NodeInputs(Map<String, Value>);

/// Which inputs to change; what is left out stays. A wrong value changes none of them.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[schema(value_type = std::collections::HashMap<String, Value>, example = json!({"shaft_revolutions": 2.5}))]
pub(super) struct NodeInputsChange(Map<String, Value>);

/// A fault to make.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultName {
    /// AG03/1: the letter, `D`. AP10: `battery-critical`, `battery-empty`, `speed`. ASDA-A2: the number on its panel, `011`.
    fault: String,
}

/// A key that is pressed or released. It stays pressed until it is released.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyPress {
    /// AG03/1: `key_1`, `key_2`. AP10: `left`, `up`, `star`.
    key: String,
    pressed: bool,
}

/// A key.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct KeyState {
    key: &'static str,
    pressed: bool,
}

/// The keys of a node.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct NodeKeys {
    keys: Vec<KeyState>,
}

/// A fault that can be made.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct NodeFault {
    fault: String,
    text: String,
    /// Its cause is there now.
    present: bool,
}

/// What an input may be.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct InputRange {
    input: &'static str,
    /// What it is.
    text: &'static str,
    /// The lowest number; `null`: it is `true` or `false`.
    low: Option<f64>,
    /// The highest number.
    high: Option<f64>,
    /// Whether it may be `null`.
    may_be_null: bool,
}

/// The switch of the supply.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NodePowerChange {
    on: bool,
}

/// What became of the supply.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
pub(super) struct NodePower {
    power: PowerName,
}

/// Whether a node is supplied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PowerName {
    Off,
    On,
}

impl PowerName {
    pub(super) fn of(device: &dyn CanopenDevice) -> Self {
        if device.is_on() { Self::On } else { Self::Off }
    }
}

/// The inputs of a node
#[utoipa::path(get, path = "/api/v1/drives/{address}/inputs", tag = "node",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), responses((status = 200, body = NodeInputs), Problems))]
pub(super) async fn read(
    State(asking): State<Asking>,
    Number(node): Number,
) -> Result<Json<NodeInputs>, Problem> {
    asking.ask(move |bench| Ok(Json(NodeInputs::of(bench.device(node)?.1)))).await?
}

/// Changes inputs
///
/// What is left out stays as it is.
#[utoipa::path(patch, path = "/api/v1/drives/{address}/inputs", tag = "node",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), request_body = NodeInputsChange,
    responses((status = 200, body = NodeInputs), Problems))]
pub(super) async fn change(
    State(asking): State<Asking>,
    Number(node): Number,
    Body(NodeInputsChange(changes)): Body<NodeInputsChange>,
) -> Result<Json<NodeInputs>, Problem> {
    asking
        .ask(move |bench| {
            bench.act(node, |product, device, now| {
                let inputs = inputs(device);
                let levels = changes.iter().map(|(name, value)| {
                    let found = inputs.iter().find(|(input, _)| input.name == name);
                    let names = || inputs.iter().map(|(input, _)| input.name.to_owned()).collect::<Vec<_>>();
                    let (input, _) = found.ok_or_else(|| unknown("input", name, product.name, &names()))?;
                    Ok((input.name, level(input, value)?))
                });
                // All of them, before the first acts.
                for (name, level) in levels.collect::<Result<Vec<_>, Problem>>()? {
                    device.set_input(now, name, level);
                }
                Ok(Json(NodeInputs::of(device)))
            })
        })
        .await?
}

/// Sets every input to nominal, and takes back the causes of provoked faults
///
/// The shaft of an AP10 stays where it is. A fault that is latched waits for the master.
#[utoipa::path(delete, path = "/api/v1/drives/{address}/inputs", tag = "node",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), responses((status = 200, body = NodeInputs), Problems))]
pub(super) async fn nominal(
    State(asking): State<Asking>,
    Number(node): Number,
) -> Result<Json<NodeInputs>, Problem> {
    asking
        .ask(move |bench| {
            bench.act(node, |_, device, now| {
                device.make_nominal(now);
                Ok(Json(NodeInputs::of(device)))
            })
        })
        .await?
}

/// Makes a fault
///
/// `faults` of the state lists them. On an AG03/1, A, B and C follow once the shaft is commanded to turn, the others at once.
#[utoipa::path(post, path = "/api/v1/drives/{address}/provoke", tag = "node",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), request_body = FaultName,
    responses((status = 200, body = NodeInputs), Problems))]
pub(super) async fn provoke(
    State(asking): State<Asking>,
    Number(node): Number,
    Body(FaultName { fault }): Body<FaultName>,
) -> Result<Json<NodeInputs>, Problem> {
    asking
        .ask(move |bench| {
            bench.act(node, |product, device, now| {
                device.provoke(now, &fault).map_err(|declined| match declined {
                    Declined::SwitchedOff => switched_off(),
                    Declined::Unknown => {
                        let names: Vec<_> = faults(device).into_iter().map(|known| known.fault).collect();
                        unknown("fault", &fault, product.name, &names)
                    }
                })?;
                Ok(Json(NodeInputs::of(device)))
            })
        })
        .await?
}

/// Presses or releases a key
///
/// A key stays pressed until it is released.
#[utoipa::path(post, path = "/api/v1/drives/{address}/keys", tag = "node",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), request_body = KeyPress,
    responses((status = 200, body = NodeKeys), Problems))]
pub(super) async fn press(
    State(asking): State<Asking>,
    Number(node): Number,
    Body(KeyPress { key, pressed }): Body<KeyPress>,
) -> Result<Json<NodeKeys>, Problem> {
    asking
        .ask(move |bench| {
            bench.act(node, |product, device, now| {
                device.press(now, &key, pressed).map_err(|declined| match declined {
                    Declined::SwitchedOff => switched_off(),
                    Declined::Unknown => {
                        let names: Vec<_> = keys(device).iter().map(|known| known.key.to_owned()).collect();
                        unknown("key", &key, product.name, &names)
                    }
                })?;
                Ok(Json(NodeKeys { keys: keys(device) }))
            })
        })
        .await?
}

/// Switches the supply on or off
///
/// Off: what is not stored is lost. On: the node boots as its EEPROM or its DIP switches say.
#[utoipa::path(put, path = "/api/v1/drives/{address}/power", tag = "node",
    params(("address" = u8, Path, minimum = 1, maximum = 127)), request_body = NodePowerChange,
    responses((status = 200, body = NodePower), Problems))]
pub(super) async fn power(
    State(asking): State<Asking>,
    Number(node): Number,
    Body(NodePowerChange { on }): Body<NodePowerChange>,
) -> Result<Json<NodePower>, Problem> {
    asking
        .ask(move |bench| {
            bench.act(node, |_, device, now| {
                match (on, device.is_on()) {
                    (true, false) => device.power_on(now),
                    (false, true) => device.power_off(now),
                    (true, true) | (false, false) => {}
                }
                Ok(Json(NodePower { power: PowerName::of(device) }))
            })
        })
        .await?
}

pub(super) fn switched_off() -> Problem {
    Problem::conflict("the node is switched off; switch it on with PUT power {\"on\": true}")
}

fn inputs(device: &dyn CanopenDevice) -> Vec<(Input, Level)> {
    let mut inputs = Vec::new();
    device.each_input(&mut |input, level| inputs.push((*input, level)));
    inputs
}

/// What a value means for an input.
fn level(input: &Input, value: &Value) -> Result<Level, Problem> {
    let name = input.name;
    let expected = match (input.kind, value) {
        (InputKind::Switch, Value::Bool(on)) => return Ok(Level::Switch(*on)),
        (InputKind::Number { own: true, .. }, Value::Null) => return Ok(Level::Own),
        (InputKind::Number { low, high, own }, value) => {
            let number = value.as_f64();
            if let Some(number) = number.filter(|number| (low..=high).contains(number)) {
                return Ok(Level::Number(number));
            }
            let or_null = if own { ", or null" } else { "" };
            format!("a number within {low} to {high}{or_null}")
        }
        (InputKind::Switch, _) => "true or false".into(),
    };
    Err(Problem::value(format!("{name} must be {expected}, got {value}")))
}

impl NodeInputs {
    pub(super) fn of(device: &dyn CanopenDevice) -> Self {
        let value = |level| match level {
            Level::Switch(on) => Value::Bool(on),
            Level::Number(number) => Value::from(number),
            Level::Own => Value::Null,
        };
        let fields = inputs(device).into_iter().map(|(input, level)| (input.name.to_owned(), value(level)));
        Self(fields.collect())
    }
}

pub(super) fn ranges(device: &dyn CanopenDevice) -> Vec<InputRange> {
    let range = |(input, _): (Input, Level)| {
        let (low, high, may_be_null) = match input.kind {
            InputKind::Switch => (None, None, false),
            InputKind::Number { low, high, own } => (Some(low), Some(high), own),
        };
        InputRange { input: input.name, text: input.about, low, high, may_be_null }
    };
    inputs(device).into_iter().map(range).collect()
}

pub(super) fn faults(device: &dyn CanopenDevice) -> Vec<NodeFault> {
    let mut faults = Vec::new();
    device.each_fault(&mut |fault| {
        faults.push(NodeFault {
            fault: fault.name.to_string(),
            text: fault.text.to_string(),
            present: fault.present,
        });
    });
    faults
}

pub(super) fn keys(device: &dyn CanopenDevice) -> Vec<KeyState> {
    let mut keys = Vec::new();
    device.each_key(&mut |key, pressed| keys.push(KeyState { key, pressed }));
    keys
}
