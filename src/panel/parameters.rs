//! Parameters, read and written without the bus.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bus_access::Asking;
use super::drives::Snapshot;
use super::problem::{Body, PathOf, Problem, Problems, QueryOf, Station, whole};
use super::state::lengths;
use crate::devices::ag03::param;
use crate::devices::ag03::param::{
    Access, Entry, Kind, ParamError, Pnu, Subindex, Unit, Value, WritableWhen,
};
use crate::devices::ag03::profibus::{Device, Power, Values};
use crate::explain::value::in_words;

/// A parameter, its value and what the table says about it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct ParameterState {
    pnu: u16,
    /// The name in the English manual.
    name: &'static str,
    /// The value, in `unit`; of an array the first element.
    value: i64,
    /// The value with its unit, or what it stands for; of an array every element.
    text: String,
    /// Every element, if it is an array.
    elements: Option<Vec<i64>>,
    /// The unit of one step of the value; empty for a coding.
    unit: String,
    /// The choices, if the value is one of a few.
    choices: Option<Vec<Choice>>,
    /// 16 or 32.
    width_bits: u8,
    access: AccessName,
    low: Option<i32>,
    high: Option<i32>,
    default: Option<i32>,
    /// The EEPROM keeps it.
    persistent: bool,
    writable_when: Option<WritableName>,
}

/// One of the values of a coded parameter.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Choice {
    value: u16,
    text: &'static str,
}

/// Whether a parameter can be read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum AccessName {
    ReadOnly,
    ReadWrite,
    /// A command: it reads as 0.
    WriteOnly,
}

/// When a parameter may be written (`ag03.md` 3.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum WritableName {
    Always,
    Standstill,
    NoJob,
}

/// All parameters of a drive.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct Parameters {
    parameters: Vec<ParameterState>,
}

/// A value to write.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewValue {
    /// In the unit of the parameter.
    #[serde(deserialize_with = "whole")]
    value: i64,
}

/// One value, and where it came from.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct ParameterValue {
    pnu: u16,
    subindex: Option<u8>,
    name: &'static str,
    value: i64,
    /// The value with its unit, or what it stands for.
    text: String,
    unit: String,
    /// Always `bench`: read and written, not over the bus. No master sees a reply to it.
    source: Source,
}

/// Who accesses a parameter.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum Source {
    Bench,
}

/// Which parameter.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct OfParameter {
    pnu: String,
}

/// Which element.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Element {
    subindex: Option<u8>,
}

/// Every parameter of the drive
#[utoipa::path(get, path = "/api/v1/drives/{address}/parameters", tag = "parameters", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = Parameters), Problems))]
pub(super) async fn list(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<Parameters>, Problem> {
    let parameters = all(&Snapshot::take(&asking, address).await?.device);
    Ok(Json(Parameters { parameters }))
}

/// Reads a parameter, not over the bus
#[utoipa::path(get, path = "/api/v1/drives/{address}/parameters/{pnu}", tag = "parameters",
    params(("address" = u8, Path, maximum = 126), ("pnu" = u16, Path, maximum = 2047), ("subindex" = Option<u8>, Query, maximum = 255, description = "Element of an array, from 0")),
    responses((status = 200, body = ParameterValue), Problems))]
pub(super) async fn read(
    State(asking): State<Asking>,
    Station(address): Station,
    PathOf(parameter): PathOf<OfParameter>,
    QueryOf(Element { subindex }): QueryOf<Element>,
) -> Result<Json<ParameterValue>, Problem> {
    let pnu = parameter.number()?;
    let snapshot = Snapshot::take(&asking, address).await?;
    ParameterValue::read(&snapshot.device, pnu, subindex).map(Json)
}

/// Writes a parameter, not over the bus
///
/// By the rules of the bus (range, operating state), but without a PKW job: no master sees it, and nothing waits for the
/// EEPROM. The PKW dialogue of the master is in the state of the drive and in the stream.
#[utoipa::path(put, path = "/api/v1/drives/{address}/parameters/{pnu}", tag = "parameters",
    params(("address" = u8, Path, maximum = 126), ("pnu" = u16, Path, maximum = 2047), ("subindex" = Option<u8>, Query, maximum = 255, description = "Element of an array, from 0")),
    request_body = NewValue, responses((status = 200, body = ParameterValue), Problems))]
pub(super) async fn write(
    State(asking): State<Asking>,
    Station(address): Station,
    PathOf(parameter): PathOf<OfParameter>,
    QueryOf(Element { subindex }): QueryOf<Element>,
    Body(NewValue { value }): Body<NewValue>,
) -> Result<Json<ParameterValue>, Problem> {
    let pnu = parameter.number()?;
    asking
        .ask(move |bench| {
            let now = bench.now;
            bench.with_drive(address, |device| {
                if device.power() != Power::On {
                    return Err(Problem::conflict(
                        "the drive is switched off, or in a factory reset; switch it on",
                    ));
                }
                let entry = entry(device, pnu)?;
                let number = i32::try_from(value)
                    .map_err(|_| Problem::value(format!("the value must be within 32 bits, got {value}")))?;
                if entry.width == param::Width::Word && !(0..=0xFFFF).contains(&number) {
                    return Err(Problem::value(format!("PNU {pnu} is a word, 0 to 65535; got {value}")));
                }
                let value = Value::of(entry.width, number);
                device
                    .write_parameter(now, pnu, subindex.map(Subindex), value)
                    .map_err(|error| refusal(device, pnu, error))?;
                ParameterValue::read(device, pnu, subindex)
            })?
        })
        .await?
        .map(Json)
}

impl OfParameter {
    fn number(&self) -> Result<Pnu, Problem> {
        let wrong =
            || Problem::new(StatusCode::BAD_REQUEST, format!("'{}' is no PNU; expected 0 to 2047", self.pnu));
        self.pnu.parse().ok().and_then(|number| Pnu::new(number).ok()).ok_or_else(wrong)
    }
}

fn entry(device: &Device, pnu: Pnu) -> Result<&'static Entry, Problem> {
    device.parameters().entry(pnu).map_err(|error| refusal(device, pnu, error))
}

/// What was wrong with an access, as a status.
fn refusal(device: &Device, pnu: Pnu, error: ParamError) -> Problem {
    let detail = match device.parameters().entry(pnu) {
        Ok(entry) if matches!(error, ParamError::OutOfRange { .. }) => {
            format!("PNU {pnu} ({}): {error}{}", entry.name, Values(entry))
        }
        Ok(entry) => format!("PNU {pnu} ({}): {error}", entry.name),
        Err(_) => format!("PNU {pnu}: {error}"),
    };
    match error {
        ParamError::UnknownParameter { .. } => Problem::not_found(detail),
        ParamError::ReadOnly | ParamError::NotNow(_) => Problem::conflict(detail),
        ParamError::OutOfRange { .. }
        | ParamError::SubindexOutOfRange { .. }
        | ParamError::NotAnArray
        | ParamError::IsArray { .. }
        | ParamError::WrongWidth { .. } => Problem::value(detail),
    }
}

impl ParameterValue {
    fn read(device: &Device, pnu: Pnu, subindex: Option<u8>) -> Result<Self, Problem> {
        let entry = entry(device, pnu)?;
        let value = device.read_parameter(pnu, subindex.map(Subindex));
        let value = value.map_err(|error| refusal(device, pnu, error))?;
        Ok(Self {
            pnu: pnu.number(),
            subindex,
            name: entry.name,
            value: entry.number(value),
            text: in_words(entry, value, lengths(device)),
            unit: entry.unit.to_string(),
            source: Source::Bench,
        })
    }
}

/// Every parameter of the model.
pub(super) fn all(device: &Device) -> Vec<ParameterState> {
    param::parameters(device.config().model).map(|entry| ParameterState::of(device, entry)).collect()
}

impl ParameterState {
    fn of(device: &Device, entry: &Entry) -> Self {
        // What cannot be read, as a command, is 0.
        let read = |element| {
            let value = device.read_parameter(entry.pnu, element);
            value.unwrap_or_else(|_| Value::of(entry.width, 0))
        };
        let values: Vec<_> = match entry.elements {
            Some(count) => (0..count).map(|element| read(Some(Subindex(element)))).collect(),
            None => Vec::from([read(None)]),
        };
        let numbers: Vec<_> = values.iter().map(|value| entry.number(*value)).collect();
        let texts: Vec<_> = values.iter().map(|value| in_words(entry, *value, lengths(device))).collect();
        let range = device.parameters().range_of(entry);
        let setting = match entry.kind {
            Kind::Setting(setting) => Some(setting),
            Kind::Reading(_) | Kind::LoadParameterSet => None,
        };
        Self {
            pnu: entry.pnu.number(),
            name: entry.name,
            value: numbers.first().copied().unwrap_or_default(),
            text: texts.join(", "),
            elements: entry.elements.map(|_| numbers),
            unit: entry.unit.to_string(),
            choices: choices(entry.unit),
            width_bits: match entry.width {
                param::Width::Word => 16,
                param::Width::Double => 32,
            },
            access: entry.access().into(),
            low: range.map(|range| range.low),
            high: range.map(|range| range.high),
            default: setting.map(|setting| setting.default),
            persistent: entry.persistent,
            writable_when: setting.map(|setting| setting.writable.into()),
        }
    }
}

fn choices(unit: Unit) -> Option<Vec<Choice>> {
    let Unit::Choice(choices) = unit else { return None };
    Some(choices.iter().map(|(value, text)| Choice { value: *value, text }).collect())
}

impl From<Access> for AccessName {
    fn from(access: Access) -> Self {
        match access {
            Access::ReadOnly => Self::ReadOnly,
            Access::ReadWrite => Self::ReadWrite,
            Access::WriteOnly => Self::WriteOnly,
        }
    }
}

impl From<WritableWhen> for WritableName {
    fn from(writable: WritableWhen) -> Self {
        match writable {
            WritableWhen::Always => Self::Always,
            WritableWhen::Standstill => Self::Standstill,
            WritableWhen::NoJob => Self::NoJob,
        }
    }
}
