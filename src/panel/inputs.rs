//! What acts on a station of either bus from outside: its inputs, faults made on purpose, keys, the supply. Which there
//! are, the station says itself ([`Surroundings`]).

use core::fmt;

use axum::Json;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use strsim::levenshtein;

#[cfg(test)]
use super::description::Problems;
use super::line::Acted;
use super::problem::{Body, Problem};
use super::routes::Place;
use crate::face::Description;
use crate::face::description::Supply;
use crate::face::surroundings::{Declined, Input, InputKind, Level, Surroundings};

/// The longest lease of a key.
const LONGEST_LEASE: u32 = 60_000;

/// The inputs of a station: numbers, `true` or `false`, `null` for what follows from everything else. Which there are
/// depends on the device.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[cfg_attr(test, schema(value_type = std::collections::HashMap<String, Value>, example = json!({"blocked": false})))]
pub(super) struct InputValues(Map<String, Value>);

/// Which inputs to change; what is left out stays. A wrong value changes none of them.
#[derive(Clone, Debug)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[cfg_attr(test, schema(value_type = std::collections::HashMap<String, Value>, example = json!({"shaft_revolutions": 2.5})))]
pub(super) struct InputsChange(Map<String, Value>);

impl<'de> Deserialize<'de> for InputsChange {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OnceEach)
    }
}

/// A map that has no key twice: who writes one twice means two things.
struct OnceEach;

impl<'de> Visitor<'de> for OnceEach {
    type Value = InputsChange;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object {...}")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<InputsChange, A::Error> {
        let mut changes = Map::new();
        while let Some((name, value)) = entries.next_entry::<String, Value>()? {
            if changes.contains_key(&name) {
                return Err(A::Error::custom(format!("duplicate field `{name}`")));
            }
            changes.insert(name, value);
        }
        Ok(InputsChange(changes))
    }
}

/// A fault to make.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct FaultToMake {
    /// As the state of the station names it.
    fault: String,
    /// `false` takes its cause back.
    #[serde(default = "yes")]
    #[cfg_attr(test, schema(default = true))]
    provoked: bool,
}

const fn yes() -> bool {
    true
}

/// A key that is pressed or released.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct KeyPress {
    /// As the state of the station names it.
    key: String,
    pressed: bool,
    /// It is released by itself after this time, unless it is pressed again meanwhile; left out: it stays pressed.
    #[cfg_attr(test, schema(minimum = 1, maximum = 60000))]
    lease_milliseconds: Option<u32>,
}

/// A key.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct KeyState {
    key: &'static str,
    pressed: bool,
}

/// The keys of a station.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Keys {
    keys: Vec<KeyState>,
}

/// A fault that can be made.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Provocation {
    fault: String,
    text: String,
    /// Its cause is there now.
    present: bool,
    /// The inputs as they are set make it.
    provoked: bool,
}

/// An input with what it may be.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct InputState {
    input: &'static str,
    /// What it is.
    text: &'static str,
    /// `null`: calculated by the device.
    #[cfg_attr(test, schema(value_type = Option<Value>))]
    value: Value,
    /// What the device calculates while it is `null`.
    #[serde(skip_serializing_if = "Option::is_none")]
    calculated: Option<f64>,
    /// What it is when everything is as it should be.
    #[cfg_attr(test, schema(value_type = Option<Value>))]
    nominal: Value,
    /// The lowest number; `null`: it is `true` or `false`.
    low: Option<f64>,
    /// The highest number.
    high: Option<f64>,
    /// Whether it may be `null`.
    may_be_null: bool,
    unit: Option<&'static str>,
}

/// The switch of the supply.
#[derive(Clone, Copy, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct PowerChange {
    on: bool,
}

/// What became of the supply.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct PowerAnswer {
    power: Supply,
}

/// The inputs of a station
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/inputs", tag = "station",
    responses((status = 200, body = InputValues), Problems)))]
pub(super) async fn read(place: Place) -> Result<Json<InputValues>, Problem> {
    place.ask(|lent, address| Ok(Json(InputValues::of(lent.find(address)?.description)))).await
}

/// Changes inputs
///
/// What is left out stays as it is.
#[cfg_attr(test, utoipa::path(patch, path = "/api/v1/lines/{line}/stations/{address}/inputs", tag = "station",
    request_body = InputsChange, responses((status = 200, body = InputValues), Problems)))]
pub(super) async fn change(
    place: Place,
    Body(InputsChange(changes)): Body<InputsChange>,
) -> Result<Json<InputValues>, Problem> {
    acted(&place, move |station, acted| {
        let inputs = inputs(station);
        let levels = changes.iter().map(|(name, value)| {
            let found = inputs.iter().find(|(input, _)| input.name == name);
            let names = || inputs.iter().map(|(input, _)| input.name.to_owned()).collect::<Vec<_>>();
            let (input, _) = found.ok_or_else(|| lacking(station, "input", name, acted.device, &names()))?;
            Ok((input.name, level(input, value)?))
        });
        // All of them, before the first acts.
        for (name, level) in levels.collect::<Result<Vec<_>, Problem>>()? {
            station.set_input(acted.now, name, level);
        }
        Ok(())
    })
    .await
}

/// Sets every input to nominal, and takes back the causes of provoked faults
///
/// A shaft stays where it is. A fault that is latched waits for the master.
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/stations/{address}/inputs", tag = "station",
    responses((status = 200, body = InputValues), Problems)))]
pub(super) async fn nominal(place: Place) -> Result<Json<InputValues>, Problem> {
    acted(&place, |station, acted| {
        station.make_nominal(acted.now);
        Ok(())
    })
    .await
}

/// Makes a fault, or what it follows from, or takes its cause back
///
/// Some follow once the shaft is commanded to turn, others at once. A fault that is latched waits for the master.
#[cfg_attr(test, utoipa::path(post, path = "/api/v1/lines/{line}/stations/{address}/provoke", tag = "station",
    request_body = FaultToMake, responses((status = 200, body = InputValues), Problems)))]
pub(super) async fn provoke(
    place: Place,
    Body(FaultToMake { fault, provoked }): Body<FaultToMake>,
) -> Result<Json<InputValues>, Problem> {
    acted(&place, move |station, acted| {
        let done = match provoked {
            true => station.provoke(acted.now, &fault),
            false => station.take_back(acted.now, &fault),
        };
        done.map_err(|declined| match declined {
            Declined::SwitchedOff => switched_off(),
            Declined::Unknown => {
                let known = Provocation::all(station);
                let names: Vec<_> = known.into_iter().map(|known| known.fault).collect();
                lacking(station, "fault", &fault, acted.device, &names)
            }
        })
    })
    .await
}

/// Presses or releases a key
///
/// A key stays pressed until it is released, or until its lease has ended.
#[cfg_attr(test, utoipa::path(post, path = "/api/v1/lines/{line}/stations/{address}/keys", tag = "station",
    request_body = KeyPress, responses((status = 200, body = Keys), Problems)))]
pub(super) async fn press(
    place: Place,
    Body(KeyPress { key, pressed, lease_milliseconds }): Body<KeyPress>,
) -> Result<Json<Keys>, Problem> {
    if let Some(wrong) = lease_milliseconds.filter(|lease| !(1..=LONGEST_LEASE).contains(lease)) {
        return Err(Problem::value(format!(
            "lease_milliseconds must be within 1 to {LONGEST_LEASE}, got {wrong}"
        )));
    }
    // Before it is pressed, so that no lease that has ended releases it.
    place.lease(&key, lease_milliseconds.filter(|_| pressed));
    let press = move |station: &mut dyn Description, acted: &Acted<'_>| {
        station.press(acted.now, &key, pressed).map_err(|declined| match declined {
            Declined::SwitchedOff => switched_off(),
            Declined::Unknown => {
                let known = KeyState::all(station);
                let names: Vec<_> = known.iter().map(|known| known.key.to_owned()).collect();
                lacking(station, "key", &key, acted.device, &names)
            }
        })
    };
    place.act(press, |station| Json(Keys { keys: KeyState::all(station) })).await
}

/// Switches the supply on or off
///
/// Off: what is not stored is lost. On: the station starts as its EEPROM and its DIP switches say, and is found at the address
/// that they say; where another station has that one, 409.
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/power", tag = "station",
    request_body = PowerChange, responses((status = 200, body = PowerAnswer), Problems)))]
pub(super) async fn power(
    place: Place,
    Body(PowerChange { on }): Body<PowerChange>,
) -> Result<Json<PowerAnswer>, Problem> {
    let power = place.ask(move |lent, address| {
        lent.find(address)?;
        lent.switch(address, on)
    });
    Ok(Json(PowerAnswer { power: power.await? }))
}

/// Does something to a station, and says what its inputs are then.
async fn acted(
    place: &Place,
    act: impl Fn(&mut dyn Description, &Acted<'_>) -> Result<(), Problem> + Send + 'static,
) -> Result<Json<InputValues>, Problem> {
    place.act(act, |station| Json(InputValues::of(station))).await
}

/// Says that a name is none of those that there are: 409 if a device next to it has it, else which is near.
fn lacking(station: &dyn Surroundings, what: &str, got: &str, of: &str, known: &[String]) -> Problem {
    let mut lack = None;
    station.each_lack(got, &mut |sentence| lack = Some(sentence.to_string()));
    lack.map_or_else(|| unknown(what, got, of, known), Problem::conflict)
}

/// Says that a name is none of those that there are, and which is near.
pub(super) fn unknown(what: &str, got: &str, of: &str, known: &[String]) -> Problem {
    let nearest =
        known.iter().map(|name| (levenshtein(&name.to_lowercase(), &got.to_lowercase()), name)).min();
    let near = match nearest {
        Some((distance, name)) if distance * 2 <= name.len().max(2) => format!("did you mean {name}? "),
        Some(_) | None => String::new(),
    };
    let there = match known {
        [] => "it has none".into(),
        known => format!("it has {}", known.join(", ")),
    };
    Problem::value(format!("'{got}' is no {what} of this {of}; {near}{there}"))
}

pub(super) fn switched_off() -> Problem {
    Problem::conflict("the node is switched off; switch it on with PUT power {\"on\": true}")
}

fn inputs(device: &dyn Surroundings) -> Vec<(Input, Level)> {
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
    let hint = match value {
        Value::Null => ": null is not possible for this input; leave it out to keep its value",
        Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) | Value::Object(_) => "",
    };
    Err(Problem::value(format!("{name} must be {expected}, got {value}{hint}")))
}

fn value_of(level: Level) -> Value {
    match level {
        Level::Switch(on) => Value::Bool(on),
        Level::Number(number) => Value::from(number),
        Level::Own => Value::Null,
    }
}

impl InputValues {
    pub(super) fn of(device: &dyn Surroundings) -> Self {
        let field = |(input, level): (Input, Level)| (input.name.to_owned(), value_of(level));
        Self(inputs(device).into_iter().map(field).collect())
    }
}

impl InputState {
    pub(super) fn all(device: &dyn Surroundings) -> Vec<Self> {
        let one = |(input, level): (Input, Level)| {
            let (low, high, may_be_null) = match input.kind {
                InputKind::Switch => (None, None, false),
                InputKind::Number { low, high, own } => (Some(low), Some(high), own),
            };
            Self {
                input: input.name,
                text: input.about,
                value: value_of(level),
                calculated: device.calculated(input.name).filter(|_| level == Level::Own),
                nominal: device.nominal(input.name).map_or(Value::Null, value_of),
                low,
                high,
                may_be_null,
                unit: input.unit(),
            }
        };
        inputs(device).into_iter().map(one).collect()
    }
}

impl Provocation {
    pub(super) fn all(device: &dyn Surroundings) -> Vec<Self> {
        let mut faults = Vec::new();
        device.each_fault(&mut |fault| {
            let (present, provoked) = (fault.present, fault.provoked);
            faults.push(Self {
                fault: fault.name.to_string(),
                text: fault.text.to_string(),
                present,
                provoked,
            });
        });
        faults
    }
}

impl KeyState {
    pub(super) fn all(device: &dyn Surroundings) -> Vec<Self> {
        let mut keys = Vec::new();
        device.each_key(&mut |key, pressed| keys.push(Self { key, pressed }));
        keys
    }
}
