//! Parameters of a station, read and written without the bus.

use axum::Json;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};

#[cfg(test)]
use super::description::Problems;
use super::line::{Acted, OnLine, lacks};
use super::problem::{Body, PathOf, Problem};
use super::routes::Place;
use super::station::AmountState;
use crate::face::Description;
use crate::face::description::{Denied, Parameter, ParameterAccess, ParameterPlace};

/// The highest number of a parameter.
const HIGHEST: u16 = 2047;

/// A parameter, its value and what the table says about it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct ParameterState {
    /// Its number; that of an element has the element behind a point.
    key: String,
    /// The name in the manual or the table.
    name: String,
    /// The value, in `unit`; of an array that of the first element.
    value: AmountState,
    /// The value with its unit, or what it stands for; of an array every element.
    text: String,
    /// Every element, if it is an array.
    elements: Option<Vec<AmountState>>,
    /// The number of the first element.
    first_element: Option<u8>,
    /// The unit of one step of the value; empty for a coding.
    unit: String,
    /// The choices, if the value is one of a few.
    choices: Option<Vec<Choice>>,
    access: ParameterAccess,
    low: Option<f64>,
    high: Option<f64>,
    default: Option<f64>,
    /// It is kept while the station is off.
    persistent: bool,
    /// When it may be written: `standstill`, `no_job`; `null`: always.
    writable_when: Option<&'static str>,
}

/// One of the values of a coded parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct Choice {
    value: u16,
    text: &'static str,
}

/// All parameters of a station.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Parameters {
    parameters: Vec<ParameterState>,
}

/// A value to write.
#[derive(Clone, Copy, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct NewParameterValue {
    /// In the unit of the parameter.
    value: f64,
}

/// One value.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct ParameterValue {
    /// The number of the parameter, with the element of an array behind a point.
    key: String,
    name: String,
    value: AmountState,
    /// The value with its unit, or what it stands for.
    text: String,
    unit: String,
}

/// Which parameter.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct OfParameter {
    key: String,
}

/// Every parameter of a station
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/parameters", tag = "parameters",
    responses((status = 200, body = Parameters), Problems)))]
pub(super) async fn list(place: Place) -> Result<Json<Parameters>, Problem> {
    let list = place.ask(|lent, address| {
        let mut parameters = Vec::new();
        let description = lent.find(address)?.description;
        description.each_parameter(&mut |parameter| parameters.push(ParameterState::of(&parameter)));
        Ok(parameters)
    });
    let parameters: Vec<_> = list.await?;
    if parameters.is_empty() {
        Err(lacks(place.address, "parameters"))
    } else {
        Ok(Json(Parameters { parameters }))
    }
}

/// Reads a parameter, not over the bus
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/parameters/{key}", tag = "parameters",
    responses((status = 200, body = ParameterValue), Problems)))]
pub(super) async fn read(
    place: Place,
    PathOf(parameter): PathOf<OfParameter>,
) -> Result<Json<ParameterValue>, Problem> {
    let (address, at) = (place.address, parameter.place()?);
    place.line.asking.ask(move |lent| ParameterValue::read(lent, address, at)).await?.map(Json)
}

/// Writes a parameter, not over the bus
///
/// By the rules of the bus (range, operating state), but without a job: no master sees it, and nothing waits for the memory.
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/parameters/{key}", tag = "parameters",
    request_body = NewParameterValue, responses((status = 200, body = ParameterValue), Problems)))]
pub(super) async fn write(
    place: Place,
    PathOf(parameter): PathOf<OfParameter>,
    Body(NewParameterValue { value }): Body<NewParameterValue>,
) -> Result<Json<ParameterValue>, Problem> {
    let (address, at) = (place.address, parameter.place()?);
    let written = place.line.asking.ask(move |lent| {
        has_parameters(lent, address)?;
        let write = |station: &mut dyn Description, acted: &Acted<'_>| {
            let mut words = String::new();
            let say = &mut |said: &dyn core::fmt::Display| words = said.to_string();
            let written = station.write_parameter(acted.now, at, value, say);
            written.map_err(|denied| refusal(denied, words))
        };
        lent.act(address, &write)?;
        ParameterValue::read(lent, address, at)
    });
    written.await?.map(Json)
}

/// 409 if the station has no parameters.
fn has_parameters(lent: &dyn OnLine, address: u8) -> Result<(), Problem> {
    let mut has = None;
    lent.find(address)?.description.each_parameter(&mut |_| has = Some(()));
    lent.having(address, "parameters", has)
}

/// What was wrong with an access, as a status.
fn refusal(denied: Denied, words: String) -> Problem {
    match denied {
        Denied::Unknown => Problem::not_found(words),
        Denied::NotNow => Problem::conflict(words),
        Denied::Value => Problem::value(words),
    }
}

impl OfParameter {
    fn place(&self) -> Result<ParameterPlace, Problem> {
        let Self { key } = self;
        let wrong = || {
            let detail = format!("'{key}' is no PNU; expected 0 to {HIGHEST}, of an array as 945.0");
            Problem::new(StatusCode::BAD_REQUEST, detail)
        };
        let (number, element) =
            key.split_once('.').map_or((&**key, None), |(pnu, element)| (pnu, Some(element)));
        let number = number.parse().ok().filter(|number| *number <= HIGHEST).ok_or_else(wrong)?;
        let element = element.map(|element| element.parse().map_err(|_| wrong())).transpose()?;
        Ok(ParameterPlace { number, element })
    }
}

/// The text of a value.
fn text(parameter: &Parameter<'_>, element: Option<u8>) -> String {
    let mut text = String::new();
    (parameter.say)(element, &mut |words| text = words.to_string());
    text
}

fn number(parameter: &Parameter<'_>, element: Option<u8>) -> AmountState {
    let number = (parameter.value)(element);
    number.map_or(AmountState::Unknown, |number| AmountState::of_number(number, None))
}

impl ParameterValue {
    fn read(lent: &dyn OnLine, address: u8, at: ParameterPlace) -> Result<Self, Problem> {
        has_parameters(lent, address)?;
        let ParameterPlace { number: wanted, element } = at;
        let (mut found, mut words) = (None, String::new());
        let description = lent.find(address)?.description;
        let checked = description.check_parameter(at, &mut |said| words = said.to_string());
        description.each_parameter(&mut |parameter| {
            if parameter.number == wanted {
                let key = element.map_or_else(|| wanted.to_string(), |element| format!("{wanted}.{element}"));
                found = Some(Self {
                    key,
                    name: parameter.name.into(),
                    value: number(&parameter, element),
                    text: text(&parameter, element),
                    unit: parameter.unit.to_string(),
                });
            }
        });
        checked.map_err(|denied| refusal(denied, words))?;
        found.ok_or_else(|| Problem::not_found(format!("there is no parameter {wanted}")))
    }
}

impl ParameterState {
    fn of(parameter: &Parameter<'_>) -> Self {
        let elements: Vec<_> = match parameter.elements {
            Some((first, count)) => (first..first.saturating_add(count)).map(Some).collect(),
            None => Vec::from([None]),
        };
        let values: Vec<_> = elements.iter().map(|element| number(parameter, *element)).collect();
        let texts: Vec<_> = elements.iter().map(|element| text(parameter, *element)).collect();
        let choice = |(value, text): &(u16, &'static str)| Choice { value: *value, text };
        Self {
            key: parameter.number.to_string(),
            name: parameter.name.into(),
            value: values.first().cloned().unwrap_or(AmountState::Unknown),
            text: texts.join(", "),
            elements: parameter.elements.map(|_| values),
            first_element: parameter.elements.map(|(first, _)| first),
            unit: parameter.unit.to_string(),
            choices: (!parameter.choices.is_empty()).then(|| parameter.choices.iter().map(choice).collect()),
            access: parameter.access,
            low: parameter.low,
            high: parameter.high,
            default: parameter.usual,
            persistent: parameter.kept,
            writable_when: Some(parameter.writable_when).filter(|when| !when.is_empty()),
        }
    }
}
