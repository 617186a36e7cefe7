//! Inputs and outputs by slot, octet and type.

use std::path::Path;

use axum::Json;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};

#[cfg(test)]
use super::super::description::Problems;
use super::super::line::OnLine;
use super::super::problem::{Body, PathOf, Problem};
use super::super::routes::Place;
use super::{bus, missing};
use crate::gsd::{Gsd, Placed};
use crate::host::list::{Given, Wrong, inputs, signals};
use crate::process::{Input, Point, ValueType};
use crate::profibus::fdl::Address;

/// A value in a module.
#[derive(Clone, Debug, Deserialize)]
pub(in crate::panel) struct OfValue {
    slot: String,
    octet: String,
    #[serde(rename = "type")]
    kind: String,
}

/// An input or output.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct ChannelState {
    /// A number; of a bit 0 or 1. `null`: the octets are no finite float.
    value: Option<f64>,
    /// Some of its bits are forced.
    forced: bool,
}

/// A value for an input.
#[derive(Clone, Copy, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(in crate::panel) struct NewChannelValue {
    /// A number that its type can hold; of a bit 0 or 1.
    value: f64,
}

/// An input as the master gets it
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/inputs/{slot}/{octet}/{type}", tag = "modules",
    responses((status = 200, body = ChannelState), Problems)))]
pub(in crate::panel) async fn read_input(
    place: Place,
    PathOf(of): PathOf<OfValue>,
) -> Result<Json<ChannelState>, Problem> {
    read(&place, of, true).await
}

/// An output as the station has it
///
/// 0 while no master exchanges data, and in the safe state.
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/outputs/{slot}/{octet}/{type}", tag = "modules",
    responses((status = 200, body = ChannelState), Problems)))]
pub(in crate::panel) async fn read_output(
    place: Place,
    PathOf(of): PathOf<OfValue>,
) -> Result<Json<ChannelState>, Problem> {
    read(&place, of, false).await
}

async fn read(place: &Place, of: OfValue, input: bool) -> Result<Json<ChannelState>, Problem> {
    let read = place.ask(move |lent, address| {
        let point = of.find(lent, address)?;
        state(lent, address, point, input)
    });
    read.await
}

/// Forces an input
///
/// It keeps this value, whatever moves it by itself, until it is released.
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/inputs/{slot}/{octet}/{type}", tag = "modules",
    request_body = NewChannelValue, responses((status = 200, body = ChannelState), Problems)))]
pub(in crate::panel) async fn force(
    place: Place,
    PathOf(of): PathOf<OfValue>,
    Body(NewChannelValue { value }): Body<NewChannelValue>,
) -> Result<Json<ChannelState>, Problem> {
    let forced = place.ask(move |lent, address| {
        let point = of.find(lent, address)?;
        let forced = bus(lent, address)?
            .with_modules(Address::from_octet(address), |modules| modules.force(point, value));
        forced.ok_or_else(|| missing(address))?.map_err(Problem::value)?;
        state(lent, address, point, true)
    });
    forced.await
}

/// Gives an input back to what moves it by itself
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/stations/{address}/inputs/{slot}/{octet}/{type}", tag = "modules",
    responses((status = 204), Problems)))]
pub(in crate::panel) async fn release(
    place: Place,
    PathOf(of): PathOf<OfValue>,
) -> Result<StatusCode, Problem> {
    let released = place.ask(move |lent, address| {
        let point = of.find(lent, address)?;
        let released =
            bus(lent, address)?.with_modules(Address::from_octet(address), |modules| modules.release(point));
        released.ok_or_else(|| missing(address))?.map_err(Problem::value)?;
        Ok(StatusCode::NO_CONTENT)
    });
    released.await
}

/// Has an input follow a signal
///
/// The body has the keys of `[[line.station.input]]` of a line file (docs/line.md) but `slot`, `octet` and `type`. The
/// signal takes the place of those that moved the same bits.
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/inputs/{slot}/{octet}/{type}/signal", tag = "modules",
    request_body = serde_json::Value, responses((status = 200, body = ChannelState), Problems)))]
pub(in crate::panel) async fn follow(
    place: Place,
    PathOf(of): PathOf<OfValue>,
    Body(given): Body<Given>,
) -> Result<Json<ChannelState>, Problem> {
    let Given::Table(given) = given else {
        return Err(Problem::value("the body must be a JSON object, {...}"));
    };
    let wrong = |wrong: Wrong| Problem::value(wrong.words);
    let file = given.iter().find(|(key, _)| key == "file");
    let folder = file.map(|(key, name)| place.line.folder(key, &name.to_string())).transpose()?;
    let source = signals::read(&given, &[], folder.as_deref().unwrap_or(Path::new(""))).map_err(wrong)?;
    let followed = place.ask(move |lent, address| {
        let to = of.find(lent, address)?;
        // The octets must be there.
        let _ = state(lent, address, to, true)?;
        let connected = bus(lent, address)?.with_modules(Address::from_octet(address), |modules| {
            let signal = inputs::signal(source, to, modules.slave().application())?;
            modules.connect_input(Input::new(to, signal));
            Ok(())
        });
        connected.ok_or_else(|| missing(address))?.map_err(wrong)?;
        state(lent, address, to, true)
    });
    followed.await
}

/// Has an input follow no signal any more
///
/// It keeps its value.
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/stations/{address}/inputs/{slot}/{octet}/{type}/signal", tag = "modules",
    responses((status = 204), Problems)))]
pub(in crate::panel) async fn stop_following(
    place: Place,
    PathOf(of): PathOf<OfValue>,
) -> Result<StatusCode, Problem> {
    let stopped = place.ask(move |lent, address| {
        let point = of.find(lent, address)?;
        let stopped = bus(lent, address)?
            .with_modules(Address::from_octet(address), |modules| modules.disconnect_input(point));
        match stopped.ok_or_else(|| missing(address))? {
            true => Ok(StatusCode::NO_CONTENT),
            false => Err(Problem::not_found("no signal moves this input")),
        }
    });
    stopped.await
}

impl OfValue {
    /// The place in the station.
    fn find(&self, lent: &mut dyn OnLine, address: u8) -> Result<Point, Problem> {
        let wrong = |detail: String| Problem::new(StatusCode::BAD_REQUEST, detail);
        let kind: ValueType = self.kind.parse().map_err(|error| wrong(format!("{error}")))?;
        let offset = self.octet.parse::<u8>().ok().filter(|octet| *octet < 244);
        let offset = offset
            .ok_or_else(|| wrong(format!("'{}' is no octet of a slot; expected 0 to 243", self.octet)))?;
        let modules = bus(lent, address)?.modules(Address::from_octet(address));
        let modules = modules.ok_or_else(|| missing(address))?;
        let slot = self.slot_of(modules.layout(), modules.gsd())?;
        Ok(Point { slot, offset: offset.into(), kind })
    }

    /// By number or by name.
    fn slot_of(&self, layout: &[Placed], gsd: &Gsd) -> Result<u16, Problem> {
        let wanted = self.slot.as_str();
        if let Ok(number) = wanted.parse::<u16>()
            && layout.iter().any(|placed| placed.slot.number == number)
        {
            return Ok(number);
        }
        let is_named = |placed: &&Placed| placed.name(gsd) == wanted || placed.names(gsd).contains(&wanted);
        let mut named = layout.iter().filter(is_named);
        match (named.next(), named.next()) {
            (Some(placed), None) => Ok(placed.slot.number),
            (Some(first), Some(second)) => Err(Problem::conflict(format!(
                "'{wanted}' is in the slots {}, {} and perhaps more; name the slot by its number",
                first.slot.number, second.slot.number
            ))),
            (None, _) => {
                let names = layout.iter().flat_map(|placed| placed.names(gsd));
                let hint = crate::gsd::did_you_mean(wanted, names)
                    .map_or_else(String::new, |near| format!("; did you mean '{near}'?"));
                let slots: Vec<_> = layout
                    .iter()
                    .map(|placed| format!("{} '{}'", placed.slot.number, placed.name(gsd)))
                    .collect();
                Err(Problem::not_found(format!(
                    "there is no slot '{wanted}'{hint}; there are {}",
                    slots.join(", ")
                )))
            }
        }
    }
}

fn state(
    lent: &mut dyn OnLine,
    address: u8,
    point: Point,
    input: bool,
) -> Result<Json<ChannelState>, Problem> {
    let station = bus(lent, address)?.modules(Address::from_octet(address));
    let station = station.ok_or_else(|| missing(address))?;
    let placed = station.layout().iter().find(|placed| placed.slot.number == point.slot);
    let slot = &placed.ok_or_else(|| missing(address))?.slot;
    let (octets, mask) = match input {
        true => (station.inputs(slot), station.forced(slot).to_vec()),
        false => (station.outputs(slot).to_vec(), Vec::new()),
    };
    let Point { offset, kind, .. } = point;
    let value = kind.read(&octets, offset).ok_or_else(|| {
        let needed = offset + kind.octets();
        let what = if input { "inputs" } else { "outputs" };
        Problem::value(format!(
            "{kind} at octet {offset} needs {needed} octets, slot {} has {} of {what}",
            point.slot,
            octets.len()
        ))
    })?;
    let bits = ValueType::of_octets(kind.octets()).read(&mask, offset).unwrap_or_default();
    let forced = whole(bits) & kind.mask() != 0;
    Ok(Json(ChannelState { value: value.is_finite().then_some(value), forced }))
}

#[expect(clippy::cast_possible_truncation, reason = "read from at most four octets")]
const fn whole(value: f64) -> u32 {
    value as u32
}
