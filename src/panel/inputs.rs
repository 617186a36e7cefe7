//! What acts on a drive from outside: supplies, load, temperatures, causes of faults; keys; the control supply.

use std::format;
use std::prelude::v1::*;

use axum::Json;
use axum::extract::State;
use serde::de::Error;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bus_access::Asking;
use super::problem::{Body, Problem, Problems, Station};
use super::state::{FaultName, PowerState};
use crate::devices::ag03::drive::{Fault, Inputs};
use crate::devices::ag03::param::Model;
use crate::devices::ag03::profibus::Device;

/// The plant inputs of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct PlantInputs {
    /// As set. Nothing of it reaches a drive that is switched off.
    control_supply_volts: f64,
    /// AG03/1 only.
    output_supply_volts: f64,
    /// The enable input, AG03 only.
    enable: bool,
    battery_volts: f64,
    /// Pulls the shaft clockwise, like a hanging weight; negative: the other way.
    load_torque_newton_metres: f64,
    /// Hinders turns in both directions.
    friction_torque_newton_metres: f64,
    blocked: bool,
    ambient_temperature_celsius: f64,
    /// Instead of the temperature that follows from the current; `null`: that one.
    stage_temperature_celsius: Option<f64>,
    /// Instead of the voltage that follows from supply and braking; `null`: that one.
    dc_link_volts: Option<f64>,
    /// AG03/1 only.
    encoder_fault: bool,
    internal_fault: bool,
}

/// Which plant inputs to change; what is left out stays. A wrong value changes none of them, nor does `null` where it is
/// not mentioned.
#[derive(Clone, Copy, Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct InputsChange {
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = f64, required = false, minimum = 0, maximum = 60)]
    control_supply_volts: Option<f64>,
    /// AG03/1 only.
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = f64, required = false, minimum = 0, maximum = 60)]
    output_supply_volts: Option<f64>,
    /// The enable input, AG03 only.
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = bool, required = false)]
    enable: Option<bool>,
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = f64, required = false, minimum = 0, maximum = 10)]
    battery_volts: Option<f64>,
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = f64, required = false, minimum = -1000, maximum = 1000)]
    load_torque_newton_metres: Option<f64>,
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = f64, required = false, minimum = 0, maximum = 1000)]
    friction_torque_newton_metres: Option<f64>,
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = bool, required = false)]
    blocked: Option<bool>,
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = f64, required = false, minimum = -50, maximum = 200)]
    ambient_temperature_celsius: Option<f64>,
    /// `null`: it is calculated from the plant again.
    #[serde(default, deserialize_with = "given")]
    #[schema(value_type = Option<f64>, minimum = -50, maximum = 200)]
    stage_temperature_celsius: Option<Option<f64>>,
    /// `null`: it is calculated from the plant again.
    #[serde(default, deserialize_with = "given")]
    #[schema(value_type = Option<f64>, minimum = 0, maximum = 100)]
    dc_link_volts: Option<Option<f64>>,
    /// AG03/1 only.
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = bool, required = false)]
    encoder_fault: Option<bool>,
    #[serde(default, deserialize_with = "not_null")]
    #[schema(value_type = bool, required = false)]
    internal_fault: Option<bool>,
}

/// The keys of the manual setup mode (manual chapter 2.2.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(super) struct Keys {
    /// Key 1, on an AG03 "right": clockwise.
    key_1_pressed: bool,
    /// Key 2, on an AG03 "left": counter-clockwise.
    key_2_pressed: bool,
}

/// A key that is pressed or released. It stays pressed until it is released.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyChange {
    key: KeyName,
    pressed: bool,
}

/// A key of the manual setup mode.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum KeyName {
    #[serde(rename = "key_1")]
    Clockwise,
    #[serde(rename = "key_2")]
    CounterClockwise,
}

/// A fault to provoke.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Provocation {
    fault: FaultName,
}

/// The switch of the control supply.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PowerChange {
    /// `true`: the drive gets `control_supply_volts`; `false`: nothing.
    on: bool,
}

/// What became of the control supply.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
pub(super) struct PowerAnswer {
    power: PowerState,
}

/// The plant inputs of a drive
#[utoipa::path(get, path = "/api/v1/drives/{address}/inputs", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = PlantInputs), Problems))]
pub(super) async fn read(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<PlantInputs>, Problem> {
    asking.ask(move |bench| bench.with_drive(address, |device| Json(device.inputs().into()))).await?
}

/// Changes plant inputs
///
/// What is left out stays as it is.
#[utoipa::path(patch, path = "/api/v1/drives/{address}/inputs", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    request_body = InputsChange, responses((status = 200, body = PlantInputs), Problems))]
pub(super) async fn change(
    State(asking): State<Asking>,
    Station(address): Station,
    Body(change): Body<InputsChange>,
) -> Result<Json<PlantInputs>, Problem> {
    set(&asking, address, move |device| change.applied(*device.inputs(), device.config().model)).await
}

/// Sets the plant inputs back to nominal: 24 V, enabled, a good battery, no load, 25 degC, nothing wrong
#[utoipa::path(delete, path = "/api/v1/drives/{address}/inputs", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = PlantInputs), Problems))]
pub(super) async fn nominal(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<PlantInputs>, Problem> {
    set(&asking, address, |device| {
        let Inputs { key_clockwise, key_counter_clockwise, .. } = *device.inputs();
        Ok(Inputs { key_clockwise, key_counter_clockwise, ..Inputs::default() })
    })
    .await
}

/// Changes plant inputs such that a fault follows
///
/// D, E, F, G and J follow at once, A, B and C once the shaft is commanded to turn. `DELETE` of the inputs takes the cause away.
#[utoipa::path(post, path = "/api/v1/drives/{address}/provoke", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    request_body = Provocation, responses((status = 200, body = PlantInputs), Problems))]
pub(super) async fn provoke(
    State(asking): State<Asking>,
    Station(address): Station,
    Body(Provocation { fault }): Body<Provocation>,
) -> Result<Json<PlantInputs>, Problem> {
    set(&asking, address, move |device| {
        let fault = Fault::from(fault);
        if !fault.exists_on(device.config().model) {
            return Err(Problem::conflict(format!("an AG03 has no fault {fault}; an AG03/1 has")));
        }
        Ok(device.drive().provoking(device.inputs(), fault))
    })
    .await
}

/// Presses or releases a key
///
/// The keys work only outside Data_Exchange. A key stays pressed until it is released; both pressed are none.
#[utoipa::path(post, path = "/api/v1/drives/{address}/keys", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    request_body = KeyChange, responses((status = 200, body = Keys), Problems))]
pub(super) async fn press(
    State(asking): State<Asking>,
    Station(address): Station,
    Body(KeyChange { key, pressed }): Body<KeyChange>,
) -> Result<Json<Keys>, Problem> {
    asking
        .ask(move |bench| {
            let now = bench.now;
            bench.with_drive(address, |device| {
                let mut inputs = *device.inputs();
                match key {
                    KeyName::Clockwise => inputs.key_clockwise = pressed,
                    KeyName::CounterClockwise => inputs.key_counter_clockwise = pressed,
                }
                device.set_inputs(now, inputs);
                Json(device.inputs().into())
            })
        })
        .await?
}

/// Switches the control supply on or off
///
/// `control_supply_volts` stays as it is set, but is 24 where it is too low to switch on. On: the DIP switches are read and the EEPROM is loaded. A
/// drive that is switched on at another address is found there; where another station has that one, 409.
#[utoipa::path(put, path = "/api/v1/drives/{address}/power", tag = "drive", params(("address" = u8, Path, maximum = 126)),
    request_body = PowerChange, responses((status = 200, body = PowerAnswer), Problems))]
pub(super) async fn power(
    State(asking): State<Asking>,
    Station(address): Station,
    Body(PowerChange { on }): Body<PowerChange>,
) -> Result<Json<PowerAnswer>, Problem> {
    asking
        .ask(move |bench| {
            let now = bench.now;
            bench.with_supply(address, |device| {
                if on {
                    device.power_on(now);
                } else {
                    device.power_off(now);
                }
                Json(PowerAnswer { power: device.power().into() })
            })
        })
        .await?
}

async fn set(
    asking: &Asking,
    address: crate::profibus::fdl::Address,
    change: impl FnOnce(&Device) -> Result<Inputs, Problem> + Send + 'static,
) -> Result<Json<PlantInputs>, Problem> {
    asking
        .ask(move |bench| {
            let now = bench.now;
            let inputs = change(bench.drive(address).ok_or_else(|| bench.no_drive(address))?)?;
            bench.with_supply(address, |device| {
                device.set_inputs(now, inputs);
                Json(device.inputs().into())
            })
        })
        .await?
}

impl InputsChange {
    /// The inputs with the change.
    fn applied(self, inputs: Inputs, model: Model) -> Result<Inputs, Problem> {
        let Self { enable, output_supply_volts, encoder_fault, .. } = self;
        match model {
            Model::Ag03 if output_supply_volts.is_some() => {
                return Err(Problem::conflict("an AG03 has one supply only; set control_supply_volts"));
            }
            Model::Ag03 if encoder_fault.is_some() => {
                return Err(Problem::conflict(
                    "an AG03 has no SIN/COS monitoring of its encoder; an AG03/1 has",
                ));
            }
            Model::Ag03_1 if enable.is_some() => {
                return Err(Problem::conflict("an AG03/1 has no enable input; set output_supply_volts to 0"));
            }
            Model::Ag03 | Model::Ag03_1 => {}
        }
        let volts = |name, value, now, most| within(name, value, now, 0.0, most);
        let torque = |name, value, now, least| within(name, value, now, least, 1000.0);
        let celsius = |name, value, now| within(name, value, now, -50.0, 200.0);
        Ok(Inputs {
            control_supply: volts(
                "control_supply_volts",
                self.control_supply_volts,
                inputs.control_supply,
                60.0,
            )?,
            output_supply: volts("output_supply_volts", output_supply_volts, inputs.output_supply, 60.0)?,
            enable_input: enable.unwrap_or(inputs.enable_input),
            battery: volts("battery_volts", self.battery_volts, inputs.battery, 10.0)?,
            load_torque: torque(
                "load_torque_newton_metres",
                self.load_torque_newton_metres,
                inputs.load_torque,
                -1000.0,
            )?,
            friction_torque: torque(
                "friction_torque_newton_metres",
                self.friction_torque_newton_metres,
                inputs.friction_torque,
                0.0,
            )?,
            blocked: self.blocked.unwrap_or(inputs.blocked),
            ambient: celsius(
                "ambient_temperature_celsius",
                self.ambient_temperature_celsius,
                inputs.ambient,
            )?,
            stage_temperature: match self.stage_temperature_celsius {
                None => inputs.stage_temperature,
                Some(None) => None,
                Some(value) => Some(celsius("stage_temperature_celsius", value, 0.0)?),
            },
            dc_link: match self.dc_link_volts {
                None => inputs.dc_link,
                Some(None) => None,
                Some(value) => Some(volts("dc_link_volts", value, 0.0, 100.0)?),
            },
            encoder_fault: encoder_fault.unwrap_or(inputs.encoder_fault),
            internal_fault: self.internal_fault.unwrap_or(inputs.internal_fault),
            ..inputs
        })
    }
}

/// The value if there is one, else what it is now.
fn within(name: &str, value: Option<f64>, now: f64, low: f64, high: f64) -> Result<f64, Problem> {
    match value {
        None => Ok(now),
        Some(value) if (low..=high).contains(&value) => Ok(value),
        Some(value) => Err(Problem::value(format!("{name} must be within {low} to {high}, got {value}"))),
    }
}

/// What cannot be `null`: somebody who writes it means something, and nothing would happen.
fn not_null<'de, T: Deserialize<'de>, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    let value = Option::deserialize(deserializer)?;
    value.map(Some).ok_or_else(|| {
        D::Error::custom(
            "null is not possible for this input; leave it out to keep its value. Only stage_temperature_celsius and \
             dc_link_volts can be null: they are calculated again",
        )
    })
}

/// Tells `null` from a field that is not there.
fn given<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

impl From<&Inputs> for PlantInputs {
    fn from(inputs: &Inputs) -> Self {
        Self {
            control_supply_volts: inputs.control_supply,
            output_supply_volts: inputs.output_supply,
            enable: inputs.enable_input,
            battery_volts: inputs.battery,
            load_torque_newton_metres: inputs.load_torque,
            friction_torque_newton_metres: inputs.friction_torque,
            blocked: inputs.blocked,
            ambient_temperature_celsius: inputs.ambient,
            stage_temperature_celsius: inputs.stage_temperature,
            dc_link_volts: inputs.dc_link,
            encoder_fault: inputs.encoder_fault,
            internal_fault: inputs.internal_fault,
        }
    }
}

impl From<&Inputs> for Keys {
    fn from(inputs: &Inputs) -> Self {
        Self { key_1_pressed: inputs.key_clockwise, key_2_pressed: inputs.key_counter_clockwise }
    }
}
