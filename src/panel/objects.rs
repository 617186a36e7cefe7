//! The object dictionary of a node, read and written without the bus.

use core::fmt;

use axum::Json;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};

#[cfg(test)]
use super::description::Problems;
use super::inputs::switched_off;
use super::line::OnLine;
use super::problem::{Body, PathOf, Problem};
use super::routes::Place;
use crate::can_bus::canopen;
use crate::can_bus::canopen::dictionary::{self, Access};
use crate::can_bus::canopen::value::ValueKind;
use crate::can_bus::canopen::{Abort, Address, DataType, Entry, Object};
use crate::devices::CanopenDevice;

/// An entry of the dictionary.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct ObjectState {
    /// Four digits, hexadecimal.
    index: String,
    /// Two digits, hexadecimal.
    sub: String,
    /// The name of the object and that of its entry.
    name: String,
    /// The type of CiA 301.
    #[serde(rename = "type")]
    data: &'static str,
    access: Access,
    /// A number or a text; `null` if it cannot be read.
    value: Option<ObjectValue>,
    /// The value of a new device, of what can be written; `null`: nobody says it.
    default: Option<ObjectValue>,
    /// The octets as SDO carries them, low octet first.
    octets_hex: Option<String>,
    /// Why it cannot be read.
    refused: Option<String>,
}

/// The value of an entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum ObjectValue {
    Whole(i64),
    Real(f64),
    Text(String),
}

/// Every entry of the dictionary.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Objects {
    objects: Vec<ObjectState>,
}

/// A value to write.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct NewObjectValue {
    /// A whole number, a number or a text, as the type of the entry wants it.
    value: ObjectValue,
}

/// Which entry.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct OfObject {
    index: String,
    sub: String,
}

/// The object dictionary of a node with every value
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/objects", tag = "objects",
    responses((status = 200, body = Objects), Problems)))]
pub(super) async fn list(place: Place) -> Result<Json<Objects>, Problem> {
    let list = place.ask(|lent, address| {
        let device = node(lent, address)?;
        let entries = objects(device)?.iter().flat_map(|object| {
            object.entries.iter().map(move |entry| ObjectState::of(device, object, entry))
        });
        Ok(Json(Objects { objects: entries.collect() }))
    });
    list.await
}

/// Reads one entry, not over the bus
///
/// As an SDO client reads it, but no frame passes.
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/objects/{index}/{sub}", tag = "objects",
    responses((status = 200, body = ObjectState), Problems)))]
pub(super) async fn read(place: Place, PathOf(of): PathOf<OfObject>) -> Result<Json<ObjectState>, Problem> {
    let (number, at) = (place.address, address(&of)?);
    place.line.asking.ask(move |lent| ObjectState::at(node(lent, number)?, at).map(Json)).await?
}

/// Writes one entry, not over the bus
///
/// Checked as an SDO is. No client waits for it: what it stores is in the file a moment later.
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/objects/{index}/{sub}", tag = "objects", request_body = NewObjectValue,
    responses((status = 200, body = ObjectState), Problems)))]
pub(super) async fn write(
    place: Place,
    PathOf(of): PathOf<OfObject>,
    Body(NewObjectValue { value }): Body<NewObjectValue>,
) -> Result<Json<ObjectState>, Problem> {
    let (number, at) = (place.address, address(&of)?);
    let written = place.line.asking.ask(move |lent| {
        let (_, entry) = entry(node(lent, number)?, at)?;
        let octets = octets(at, entry.data, &value)?;
        let mut done = Ok(());
        lent.with_node(number, &mut |device, now| {
            let written = device.write_without_bus(now, at, &octets);
            done = written.map_err(|refusal| refused(at, refusal.code, &refusal.reason()));
        });
        done?;
        ObjectState::at(node(lent, number)?, at).map(Json)
    });
    written.await?
}

/// The node of that number.
fn node<'a>(lent: &'a (dyn OnLine + 'a), address: u8) -> Result<&'a dyn CanopenDevice, Problem> {
    lent.having(address, "objects", lent.node(address))
}

/// The dictionary of a node that is switched on.
fn objects(device: &dyn CanopenDevice) -> Result<&'static [Object], Problem> {
    device.node().state().map(|_| device.application().objects()).ok_or_else(switched_off)
}

/// A whole number of the dictionary.
pub(super) fn whole(device: &dyn CanopenDevice, at: Address) -> Option<i64> {
    let app = device.application();
    let entry = canopen::dictionary::entry(app.objects(), at).ok()?;
    let read = device
        .node()
        .read_with(at, app, |octets| Ok(entry.data.decode(octets).and_then(|value| value.number())));
    read.ok().flatten()
}

fn entry(device: &dyn CanopenDevice, at: Address) -> Result<(&'static Object, &'static Entry), Problem> {
    let objects = objects(device)?;
    let object = canopen::dictionary::object(objects, at.index)
        .ok_or_else(|| Problem::not_found(format!("there is no object {} in this node", at.index)))?;
    let entry = object.entry(at.sub).ok_or_else(|| {
        let subs: Vec<_> = object.entries.iter().map(|entry| entry.sub.to_string()).collect();
        Problem::not_found(format!(
            "object {} has no sub-index {}; it has {}",
            at.index,
            at.sub,
            subs.join(", ")
        ))
    })?;
    Ok((object, entry))
}

fn refused(at: Address, code: Abort, reason: &dyn fmt::Display) -> Problem {
    match code {
        Abort::DEVICE_STATE => Problem::conflict(format!("{at} cannot be written now: {reason}")),
        _ => Problem::value(format!("{at} cannot be written: {reason}")),
    }
}

fn address(of: &OfObject) -> Result<Address, Problem> {
    let digits = |text: &str, most: usize| {
        let digits = text.strip_prefix("0x").unwrap_or(text);
        let digits = digits.strip_suffix('h').unwrap_or(digits);
        let are_digits = digits.bytes().all(|octet| octet.is_ascii_hexdigit()) && digits.len() <= most;
        u16::from_str_radix(digits, 16).ok().filter(|_| are_digits)
    };
    let wrong = |text: &str, what: &str, most| {
        Problem::new(
            StatusCode::BAD_REQUEST,
            format!("'{text}' is no {what}; expected hexadecimal digits, {most} at most, as objects/6041/0"),
        )
    };
    let index = digits(&of.index, 4).ok_or_else(|| wrong(&of.index, "index", 4))?;
    let sub = digits(&of.sub, 2).and_then(|sub| u8::try_from(sub).ok());
    Ok(Address::new(index, sub.ok_or_else(|| wrong(&of.sub, "sub-index", 2))?))
}

/// A value as octets of its type; the range is the device's business.
fn octets(at: Address, data: DataType, value: &ObjectValue) -> Result<Vec<u8>, Problem> {
    let wrong = |expected: &str| {
        let got = serde_json::to_string(value).unwrap_or_default();
        Problem::value(format!("{at} is {}: expected {expected}, got {got}", data.name()))
    };
    match (data.kind(), value) {
        (ValueKind::Text, ObjectValue::Text(text)) => Ok(text.as_bytes().to_vec()),
        (ValueKind::Octets, ObjectValue::Text(text)) if data.octets().is_none() => {
            Ok(text.as_bytes().to_vec())
        }
        (ValueKind::Text | ValueKind::Octets, _) => Err(wrong("a text")),
        (ValueKind::Real, ObjectValue::Real(number)) => Ok(real(data, *number)),
        #[expect(clippy::cast_precision_loss, reason = "to the precision that the entry has")]
        (ValueKind::Real, ObjectValue::Whole(number)) => Ok(real(data, *number as f64)),
        (ValueKind::Real, ObjectValue::Text(_)) => Err(wrong("a number")),
        (ValueKind::Boolean | ValueKind::Signed | ValueKind::Unsigned, ObjectValue::Whole(number)) => {
            match canopen::Value::whole(data, *number).filter(|_| fits(data, *number)) {
                Some(value) => Ok(value.with_octets(<[u8]>::to_vec)),
                None => Err(wrong("a whole number that fits into it")),
            }
        }
        (
            ValueKind::Boolean | ValueKind::Signed | ValueKind::Unsigned,
            ObjectValue::Real(_) | ObjectValue::Text(_),
        ) => Err(wrong("a whole number")),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "to the precision that the entry has")]
fn real(data: DataType, number: f64) -> Vec<u8> {
    match data.octets() {
        Some(4) => (number as f32).to_le_bytes().to_vec(),
        Some(_) | None => number.to_le_bytes().to_vec(),
    }
}

/// Whether a whole number is one of its type.
fn fits(data: DataType, number: i64) -> bool {
    match data.range() {
        Some((low, high)) => (low..=high).contains(&number),
        None => number >= 0,
    }
}

impl ObjectState {
    fn at(device: &dyn CanopenDevice, at: Address) -> Result<Self, Problem> {
        let (object, entry) = entry(device, at)?;
        Ok(Self::of(device, object, entry))
    }

    fn of(device: &dyn CanopenDevice, object: &'static Object, entry: &'static Entry) -> Self {
        let has_default = entry.access == Access::Rw && entry.default != dictionary::Default::None;
        let at = Address { index: object.index, sub: entry.sub };
        let read = device.node().read_with(at, device.application(), |octets| Ok(octets.to_vec()));
        let name = if object.name == entry.name || object.entries.len() == 1 {
            object.name.into()
        } else {
            format!("{}: {}", object.name, entry.name)
        };
        let (octets, refused) = match read {
            Ok(octets) => (Some(octets), None),
            Err(abort) => (None, Some(abort.to_string())),
        };
        Self {
            index: format!("{:04X}", object.index.0),
            sub: format!("{:02X}", entry.sub.0),
            name,
            data: entry.data.name(),
            access: entry.access,
            value: octets.as_deref().and_then(|octets| ObjectValue::of(entry.data, octets)),
            default: has_default.then(|| ObjectValue::told(entry.default_value(device.node_id()))),
            octets_hex: octets.as_deref().map(crate::explain::hex),
            refused,
        }
    }
}

impl ObjectValue {
    /// The value of octets of a type.
    pub(super) fn of(data: DataType, octets: &[u8]) -> Option<Self> {
        data.decode(octets).map(Self::told)
    }

    fn told(value: canopen::Value<'_>) -> Self {
        if let canopen::Value::Real32(number) = value {
            Self::Real(number.into())
        } else if let canopen::Value::Real64(number) = value {
            Self::Real(number)
        } else if let canopen::Value::Octets(octets) = value {
            Self::Text(String::from_utf8_lossy(octets).into_owned())
        } else if let Some(number) = value.number() {
            Self::Whole(number)
        } else {
            Self::Text(format!("{value:?}"))
        }
    }
}
