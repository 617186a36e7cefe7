//! The table of parameters of a drive of PROFIDRIVE version 2. Values are numbers on the bus.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::super::bus_access::Asking;
use super::super::problem::{Body, PathOf, Problem, Problems, QueryOf, Station};
use crate::devices::ppo_drive::table::Row;
use crate::host::HostedPpoDrive;
use crate::profibus::pkw::{JobError, Value};

/// All parameters of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct PpoParameters {
    parameters: Vec<PpoParameter>,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct PpoParameter {
    pnu: u16,
    name: String,
    /// int16, uint16, v2, int32, uint32 or float.
    r#type: &'static str,
    /// The number of elements of an array; `null`: a single value.
    elements: Option<u8>,
    /// The numbers on the bus: one, or those of the elements from 1 on. `null`: no finite float.
    values: Vec<Option<f64>>,
    unit: String,
    /// What 1 on the bus is, in the unit.
    scale: f64,
    low: f64,
    high: f64,
    /// Whether a master can write it.
    writable: bool,
}

/// One value.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct PpoValue {
    pnu: u16,
    /// The element of an array, from 1.
    subindex: Option<u8>,
    name: String,
    /// The number on the bus. `null`: no finite float.
    value: Option<f64>,
    unit: String,
    /// What 1 on the bus is, in the unit.
    scale: f64,
}

/// A new value.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::panel) struct NewPpoValue {
    /// The number on the bus.
    value: f64,
}

/// Which parameter, as it is written.
#[derive(Clone, Debug, Deserialize)]
pub(in crate::panel) struct OfPpoParameter {
    pnu: String,
}

/// Which element.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::panel) struct PpoElement {
    subindex: Option<u8>,
}

/// Every parameter of the table
#[utoipa::path(get, path = "/api/v1/ppo-drives/{address}/parameters", tag = "ppo-drives", params(("address" = u8, Path, maximum = 126)),
    responses((status = 200, body = PpoParameters), Problems))]
pub(in crate::panel) async fn list(
    State(asking): State<Asking>,
    Station(address): Station,
) -> Result<Json<PpoParameters>, Problem> {
    asking
        .ask(move |bench| {
            let hosted: &HostedPpoDrive = bench.find(address)?;
            let parameters = hosted.drive().table().rows().map(|row| PpoParameter::of(hosted, row)).collect();
            Ok(Json(PpoParameters { parameters }))
        })
        .await?
}

/// One value
#[utoipa::path(get, path = "/api/v1/ppo-drives/{address}/parameters/{pnu}", tag = "ppo-drives",
    params(("address" = u8, Path, maximum = 126), ("pnu" = u16, Path, maximum = 2047), ("subindex" = Option<u8>, Query, maximum = 255, description = "Element of an array, from 1")),
    responses((status = 200, body = PpoValue), Problems))]
pub(in crate::panel) async fn read(
    State(asking): State<Asking>,
    Station(address): Station,
    PathOf(parameter): PathOf<OfPpoParameter>,
    QueryOf(PpoElement { subindex }): QueryOf<PpoElement>,
) -> Result<Json<PpoValue>, Problem> {
    let pnu = parameter.number()?;
    asking.ask(move |bench| PpoValue::read(bench.find(address)?, pnu, subindex)).await?.map(Json)
}

/// Writes a parameter
///
/// By the rules of the bus, but without a PKW job: no master sees it.
#[utoipa::path(put, path = "/api/v1/ppo-drives/{address}/parameters/{pnu}", tag = "ppo-drives",
    params(("address" = u8, Path, maximum = 126), ("pnu" = u16, Path, maximum = 2047), ("subindex" = Option<u8>, Query, maximum = 255, description = "Element of an array, from 1")),
    request_body = NewPpoValue, responses((status = 200, body = PpoValue), Problems))]
pub(in crate::panel) async fn write(
    State(asking): State<Asking>,
    Station(address): Station,
    PathOf(parameter): PathOf<OfPpoParameter>,
    QueryOf(PpoElement { subindex }): QueryOf<PpoElement>,
    Body(NewPpoValue { value }): Body<NewPpoValue>,
) -> Result<Json<PpoValue>, Problem> {
    let pnu = parameter.number()?;
    asking
        .ask(move |bench| {
            let now = bench.now;
            bench.change(address, |hosted: &mut HostedPpoDrive| {
                let row = hosted.drive().table().row(pnu);
                let row = row.ok_or_else(|| refusal(pnu, JobError::UnknownParameter { got: pnu }))?;
                let fits =
                    (row.low..=row.high).contains(&value) && (row.kind.bits(value) != 0 || value.abs() < 1.0);
                if !fits {
                    return Err(refusal(pnu, JobError::outside(row.low, row.high, value)));
                }
                let bits = row.kind.bits(value);
                let [_, _, high, low] = bits.to_be_bytes();
                let value = match row.kind.is_double() {
                    true => Value::Double(bits),
                    false => Value::Word(u16::from_be_bytes([high, low])),
                };
                let drive = hosted.drive_mut();
                drive.write_parameter(now, pnu, subindex, value).map_err(|error| refusal(pnu, error))?;
                PpoValue::read(hosted, pnu, subindex)
            })?
        })
        .await?
        .map(Json)
}

impl OfPpoParameter {
    fn number(&self) -> Result<u16, Problem> {
        let pnu = self.pnu.parse().ok().filter(|pnu| *pnu <= crate::devices::ppo_drive::table::MAX_PNU);
        pnu.ok_or_else(|| {
            Problem::new(StatusCode::BAD_REQUEST, format!("'{}' is no PNU; expected 0 to 2047", self.pnu))
        })
    }
}

/// What was wrong with an access, as a status.
fn refusal(pnu: u16, error: JobError) -> Problem {
    let detail = format!("PNU {pnu}: {error}");
    match error {
        JobError::UnknownParameter { .. } => Problem::not_found(detail),
        JobError::ReadOnly => Problem::conflict(detail),
        JobError::NoElement { .. } | _ => Problem::value(detail),
    }
}

impl PpoValue {
    fn read(hosted: &HostedPpoDrive, pnu: u16, subindex: Option<u8>) -> Result<Self, Problem> {
        let value = hosted.drive().read_parameter(pnu, subindex).map_err(|error| refusal(pnu, error))?;
        let row = hosted.drive().table().row(pnu);
        let row = row.ok_or_else(|| refusal(pnu, JobError::UnknownParameter { got: pnu }))?;
        Ok(Self {
            pnu,
            subindex,
            name: row.name.clone(),
            value: finite(row.kind.value(value.bits())),
            unit: row.unit.clone(),
            scale: row.scale,
        })
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl PpoParameter {
    fn of(hosted: &HostedPpoDrive, row: &Row) -> Self {
        let value = |element| {
            let value = hosted.drive().read_parameter(row.pnu, element);
            finite(row.kind.value(value.map_or(0, Value::bits)))
        };
        let values = match row.elements {
            Some(count) => (1..=count).map(|element| value(Some(element))).collect(),
            None => Vec::from([value(None)]),
        };
        Self {
            pnu: row.pnu,
            name: row.name.clone(),
            r#type: row.kind.name(),
            elements: row.elements,
            values,
            unit: row.unit.clone(),
            scale: row.scale,
            low: row.low,
            high: row.high,
            writable: row.writable,
        }
    }
}
