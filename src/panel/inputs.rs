//! What acts on a station of either bus from outside: its inputs, faults made on purpose, keys, the supply. Which there
//! are, the station says itself ([`Surroundings`]).

use core::fmt;

use axum::Json;
use axum::extract::State;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use strsim::levenshtein;
use utoipa::ToSchema;

use super::problem::{Body, PathOf, Problem, Problems};
use super::queue::{Asking, Lends};
use crate::face::Surroundings;
use crate::face::surroundings::{Declined, Input, InputKind, Level};
use crate::time::Instant;

/// A bus whose stations can be asked and changed by their address.
pub(super) trait Stations: Lends {
    /// The address in a path.
    ///
    /// # Errors
    /// 400 if it is none.
    fn address(text: &str) -> Result<u8, Problem>;

    /// Looks at what acts on a station.
    ///
    /// # Errors
    /// 404 if there is none, with those that there are.
    fn look<R>(
        access: &Self::Access<'_>,
        address: u8,
        look: impl FnOnce(&dyn Surroundings) -> R,
    ) -> Result<R, Problem>;

    /// Does something to what acts on a station.
    ///
    /// # Errors
    /// 404 if there is none; what `act` says; 409 if it would take the address of another station. Nothing is changed then.
    fn act<R>(
        access: &mut Self::Access<'_>,
        address: u8,
        act: impl Fn(&mut dyn Surroundings, &Acted<'_>) -> Result<R, Problem>,
    ) -> Result<R, Problem>;

    /// Switches the supply of a station on or off.
    ///
    /// # Errors
    /// As [`Self::act`].
    fn switch(access: &mut Self::Access<'_>, address: u8, on: bool) -> Result<PowerName, Problem>;
}

/// When something is done, and to which device.
#[derive(Clone, Copy, Debug)]
pub(super) struct Acted<'a> {
    pub(super) now: Instant,
    /// As on the command line.
    pub(super) device: &'a str,
}

/// Which station, as the path says it.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct OfStation {
    address: String,
}

/// The inputs of a station: numbers, `true` or `false`, `null` for what follows from everything else. Which there are
/// depends on the device.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(value_type = std::collections::HashMap<String, Value>, example = json!({"blocked": false}))]
pub(super) struct InputValues(Map<String, Value>);

/// Which inputs to change; what is left out stays. A wrong value changes none of them.
#[derive(Clone, Debug, ToSchema)]
#[schema(value_type = std::collections::HashMap<String, Value>, example = json!({"shaft_revolutions": 2.5}))]
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
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultToMake {
    /// AG03, AG03/1: the letter, `D`. AP10: `battery-critical`, `battery-empty`, `speed`. ASDA-A2: the number on its panel, `011`.
    fault: String,
}

/// A key that is pressed or released. It stays pressed until it is released.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyPress {
    /// AG03, AG03/1: `key_1`, `key_2`. AP10: `left`, `up`, `star`.
    key: String,
    pressed: bool,
}

/// A key.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct KeyState {
    key: &'static str,
    pressed: bool,
}

/// The keys of a station.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct Keys {
    keys: Vec<KeyState>,
}

/// A fault that can be made.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Provocation {
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
pub(super) struct PowerChange {
    on: bool,
}

/// What became of the supply.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
pub(super) struct PowerAnswer {
    power: PowerName,
}

/// Whether a station is supplied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::panel) enum PowerName {
    Off,
    On,
    /// Switched on with the DIP switches of a factory reset: only the LEDs work.
    FactoryReset,
}

/// The inputs of a station
#[utoipa::path(get, path = "/api/v1/drives/{address}/inputs", tag = "station",
    params(("address" = u8, Path, maximum = 127)), responses((status = 200, body = InputValues), Problems))]
pub(super) async fn read<L: Stations>(
    State(asking): State<Asking<L>>,
    PathOf(of): PathOf<OfStation>,
) -> Result<Json<InputValues>, Problem> {
    let address = L::address(&of.address)?;
    asking.ask(move |bench| L::look(bench, address, |station| Json(InputValues::of(station)))).await?
}

/// Changes inputs
///
/// What is left out stays as it is.
#[utoipa::path(patch, path = "/api/v1/drives/{address}/inputs", tag = "station",
    params(("address" = u8, Path, maximum = 127)), request_body = InputsChange,
    responses((status = 200, body = InputValues), Problems))]
pub(super) async fn change<L: Stations>(
    State(asking): State<Asking<L>>,
    PathOf(of): PathOf<OfStation>,
    Body(InputsChange(changes)): Body<InputsChange>,
) -> Result<Json<InputValues>, Problem> {
    acted(&asking, &of, move |station, acted| {
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
/// The shaft of an AP10 stays where it is. A fault that is latched waits for the master.
#[utoipa::path(delete, path = "/api/v1/drives/{address}/inputs", tag = "station",
    params(("address" = u8, Path, maximum = 127)), responses((status = 200, body = InputValues), Problems))]
pub(super) async fn nominal<L: Stations>(
    State(asking): State<Asking<L>>,
    PathOf(of): PathOf<OfStation>,
) -> Result<Json<InputValues>, Problem> {
    acted(&asking, &of, |station, acted| {
        station.make_nominal(acted.now);
        Ok(())
    })
    .await
}

/// Makes a fault, or what it follows from
///
/// Of an AG03 and AG03/1, A, B and C follow once the shaft is commanded to turn, the others at once. `DELETE` of the inputs
/// takes the cause away.
#[utoipa::path(post, path = "/api/v1/drives/{address}/provoke", tag = "station",
    params(("address" = u8, Path, maximum = 127)), request_body = FaultToMake,
    responses((status = 200, body = InputValues), Problems))]
pub(super) async fn provoke<L: Stations>(
    State(asking): State<Asking<L>>,
    PathOf(of): PathOf<OfStation>,
    Body(FaultToMake { fault }): Body<FaultToMake>,
) -> Result<Json<InputValues>, Problem> {
    acted(&asking, &of, move |station, acted| {
        station.provoke(acted.now, &fault).map_err(|declined| match declined {
            Declined::SwitchedOff => switched_off(),
            Declined::Unknown => {
                let names: Vec<_> = faults(station).into_iter().map(|known| known.fault).collect();
                lacking(station, "fault", &fault, acted.device, &names)
            }
        })
    })
    .await
}

/// Presses or releases a key
///
/// A key stays pressed until it is released.
#[utoipa::path(post, path = "/api/v1/drives/{address}/keys", tag = "station",
    params(("address" = u8, Path, maximum = 127)), request_body = KeyPress,
    responses((status = 200, body = Keys), Problems))]
pub(super) async fn press<L: Stations>(
    State(asking): State<Asking<L>>,
    PathOf(of): PathOf<OfStation>,
    Body(KeyPress { key, pressed }): Body<KeyPress>,
) -> Result<Json<Keys>, Problem> {
    let address = L::address(&of.address)?;
    let press = move |station: &mut dyn Surroundings, acted: &Acted<'_>| {
        station.press(acted.now, &key, pressed).map_err(|declined| match declined {
            Declined::SwitchedOff => switched_off(),
            Declined::Unknown => {
                let names: Vec<_> = keys(station).iter().map(|known| known.key.to_owned()).collect();
                lacking(station, "key", &key, acted.device, &names)
            }
        })?;
        Ok(Json(Keys { keys: keys(station) }))
    };
    asking.ask(move |bench| L::act(bench, address, press)).await?
}

/// Switches the supply on or off
///
/// Off: what is not stored is lost. On: the station starts as its EEPROM and its DIP switches say, and is found at the address
/// that they say; where another station has that one, 409.
#[utoipa::path(put, path = "/api/v1/drives/{address}/power", tag = "station",
    params(("address" = u8, Path, maximum = 127)), request_body = PowerChange,
    responses((status = 200, body = PowerAnswer), Problems))]
pub(super) async fn power<L: Stations>(
    State(asking): State<Asking<L>>,
    PathOf(of): PathOf<OfStation>,
    Body(PowerChange { on }): Body<PowerChange>,
) -> Result<Json<PowerAnswer>, Problem> {
    let address = L::address(&of.address)?;
    let power = asking.ask(move |bench| L::switch(bench, address, on)).await??;
    Ok(Json(PowerAnswer { power }))
}

/// Does something to a station, and says what its inputs are then.
async fn acted<L: Stations>(
    asking: &Asking<L>,
    of: &OfStation,
    act: impl Fn(&mut dyn Surroundings, &Acted<'_>) -> Result<(), Problem> + Send + 'static,
) -> Result<Json<InputValues>, Problem> {
    let address = L::address(&of.address)?;
    let done = asking.ask(move |bench| {
        L::act(bench, address, |station, acted| {
            act(station, acted)?;
            Ok(Json(InputValues::of(station)))
        })
    });
    done.await?
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

impl InputValues {
    pub(super) fn of(device: &dyn Surroundings) -> Self {
        let value = |level| match level {
            Level::Switch(on) => Value::Bool(on),
            Level::Number(number) => Value::from(number),
            Level::Own => Value::Null,
        };
        let fields = inputs(device).into_iter().map(|(input, level)| (input.name.to_owned(), value(level)));
        Self(fields.collect())
    }
}

pub(super) fn ranges(device: &dyn Surroundings) -> Vec<InputRange> {
    let range = |(input, _): (Input, Level)| {
        let (low, high, may_be_null) = match input.kind {
            InputKind::Switch => (None, None, false),
            InputKind::Number { low, high, own } => (Some(low), Some(high), own),
        };
        InputRange { input: input.name, text: input.about, low, high, may_be_null }
    };
    inputs(device).into_iter().map(range).collect()
}

pub(super) fn faults(device: &dyn Surroundings) -> Vec<Provocation> {
    let mut faults = Vec::new();
    device.each_fault(&mut |fault| {
        faults.push(Provocation {
            fault: fault.name.to_string(),
            text: fault.text.to_string(),
            present: fault.present,
        });
    });
    faults
}

pub(super) fn keys(device: &dyn Surroundings) -> Vec<KeyState> {
    let mut keys = Vec::new();
    device.each_key(&mut |key, pressed| keys.push(KeyState { key, pressed }));
    keys
}
