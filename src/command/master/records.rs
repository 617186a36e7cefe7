//! `record`, `param`, `im`: records of a slave of DP-V1, over a connection of a master of class 2.

use core::time::Duration;

use serde_json::json;

use super::super::args::{ParamAction, ParamChange, ParamPlace, Reach, RecordAction};
use super::say;
use crate::client::{ParameterRefused, ParameterRequest};
use crate::command::Failure;
use crate::explain::{description_text, hex, values_text};
use crate::host::{Clock, Link};
use crate::master::{Connection, RecordError, Session};
use crate::profibus::dpv1::Identification;
use crate::profibus::dpv1::base_mode::{Attribute, Format, ParameterAddress, Values};
use crate::profibus::fdl::Address;

/// How long a job of the slave may take.
const PATIENCE: Duration = Duration::from_secs(10);

/// References of requests, so that no response is taken for one to another request.
const READ: u8 = 1;
const CHANGE: u8 = 2;

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        Self::Other(error.to_string())
    }
}

/// What is asked over one connection.
fn connected<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    address: Address,
    act: impl FnOnce(&mut Connection<'_, L, C>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut connection = Connection::open(session, address, PATIENCE)?;
    let done = act(&mut connection);
    let closed = connection.close();
    done?;
    closed.map_err(Failure::from)
}

/// `record read`, `record write`.
pub(super) fn record<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    address: Address,
    action: &RecordAction,
    json: bool,
) -> Result<(), Failure> {
    connected(session, address, |connection| match action {
        RecordAction::Read { slot, index } => {
            let data = connection.read(*slot, *index)?;
            if json {
                let (length, data) = (data.len(), hex(&data));
                return say(json!({ "slot": slot, "index": index, "length": length, "data": data }));
            }
            say(format_args!("record {index} of slot {slot}: {}", hex(&data)))
        }
        RecordAction::Write { slot, index, data } => {
            connection.write(*slot, *index, &data.0)?;
            if json {
                let (length, data) = (data.0.len(), hex(&data.0));
                return say(json!({ "slot": slot, "index": index, "length": length, "data": data }));
            }
            say(format_args!("record {index} of slot {slot} written: {}", hex(&data.0)))
        }
    })
}

/// `im`: a block of identification and maintenance.
pub(super) fn identification<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    address: Address,
    (slot, block): (u8, u16),
    json: bool,
) -> Result<(), Failure> {
    connected(session, address, |connection| {
        let octets = connection.identification(slot, block)?;
        let own = Identification::parse(&octets).filter(|_| block == 0);
        let text =
            own.map_or_else(|| String::from_utf8_lossy(&octets).trim().to_owned(), |own| own.to_string());
        if json {
            return say(json!({ "slot": slot, "block": block, "text": text, "data": hex(&octets) }));
        }
        say(format_args!("I&M{block} of slot {slot}: {text}"))
    })
}

/// `param read`, `param write`, `param describe`.
pub(super) fn param<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    address: Address,
    action: &ParamAction,
    json: bool,
) -> Result<(), Failure> {
    connected(session, address, |connection| match action {
        ParamAction::Read { places, reach } => {
            let addresses: Vec<_> = places.iter().map(|place| place.address(Attribute::Value)).collect();
            show(places, &read(connection, *reach, &addresses)?, json)
        }
        ParamAction::Describe { places, reach } => {
            let addresses: Vec<_> =
                places.iter().map(|place| place.address(Attribute::Description)).collect();
            show_as(places, &read(connection, *reach, &addresses)?, json, description_text)
        }
        ParamAction::Text { places, reach } => {
            let addresses: Vec<_> = places.iter().map(|place| place.address(Attribute::Text)).collect();
            show(places, &read(connection, *reach, &addresses)?, json)
        }
        ParamAction::Write { changes, reach } => {
            // The format of each is that of its value.
            let places: Vec<_> = changes.iter().map(|change| change.place).collect();
            let addresses: Vec<_> = places.iter().map(|place| place.address(Attribute::Value)).collect();
            let before = read(connection, *reach, &addresses)?;
            let octets: Vec<_> = changes.iter().zip(&before).map(encoded).collect::<Result<_, _>>()?;
            let values = octets.iter().map(|(format, octets)| Values { format: *format, count: 1, octets });
            let changes: Vec<_> = addresses.into_iter().zip(values).collect();
            let request = ParameterRequest::change(CHANGE, reach.axis, &changes).ok_or_else(too_many)?;
            let response = connection.parameters(reach.slot, &request)?;
            let results: Vec<_> = request.results(&response).map_err(RecordError::from)?.collect();
            let after = results.into_iter().zip(&changes).map(|(result, (_, values))| {
                result.map(|_| (values.format, values.octets.to_vec(), values.count))
            });
            show(&places, &after.collect::<Vec<_>>(), json)
        }
    })
}

/// What a drive says of one parameter.
type Told = Result<(Format, Vec<u8>, u8), ParameterRefused>;

fn too_many() -> Failure {
    Failure::Usage(
        "these are more parameters than one request has room for (38); ask for fewer at once".into(),
    )
}

fn read<L: Link, C: Clock>(
    connection: &mut Connection<'_, L, C>,
    reach: Reach,
    addresses: &[ParameterAddress],
) -> Result<Vec<Told>, Failure> {
    let request = ParameterRequest::read(READ, reach.axis, addresses).ok_or_else(too_many)?;
    let response = connection.parameters(reach.slot, &request)?;
    let results = request.results(&response).map_err(RecordError::from)?;
    let told =
        results.map(|result| result.map(|values| (values.format, values.octets.to_vec(), values.count)));
    Ok(told.collect())
}

/// A new value in the format that the parameter has now.
fn encoded((change, before): (&ParamChange, &Told)) -> Result<(Format, Vec<u8>), Failure> {
    let place = change.place;
    let (format, ..) = before.as_ref().map_err(|refused| {
        Failure::Other(format!("{place} cannot be read, so its format is not known: {refused}"))
    })?;
    let wrong = |expected: &str| {
        Failure::Usage(format!("{place} is {}: expected {expected}, got {}", format.words(), change.value))
    };
    let octets = match *format {
        Format::FLOAT => {
            #[expect(clippy::cast_possible_truncation, reason = "to the precision that the parameter has")]
            let number = change.value as f32;
            number.to_be_bytes().to_vec()
        }
        format => {
            let size = format.size().filter(|size| matches!(size, 1 | 2 | 4));
            let size = size.ok_or_else(|| wrong("a parameter that is one number"))?;
            let signed = matches!(
                format,
                Format::INTEGER8 | Format::INTEGER16 | Format::INTEGER32 | Format::N2 | Format::N4
            );
            let bits = 8 * u32::try_from(size).unwrap_or(4);
            let span = 2_f64.powi(i32::try_from(bits).unwrap_or(32));
            let (least, end) = if signed { (-span / 2.0, span / 2.0) } else { (0.0, span) };
            if change.value.fract() != 0.0 || !(least..end).contains(&change.value) {
                return Err(wrong(&format!("a whole number from {least} to {}", end - 1.0)));
            }
            #[expect(clippy::cast_possible_truncation, reason = "whole, and within 32 bits")]
            let number = change.value as i64;
            number.to_be_bytes().into_iter().skip(8 - size).collect()
        }
    };
    Ok((*format, octets))
}

/// Shows what the drive said of each; what it refused makes the command fail.
fn show(places: &[ParamPlace], told: &[Told], json: bool) -> Result<(), Failure> {
    show_as(places, told, json, |_| None)
}

/// The same, where octets may have a meaning of their own.
fn show_as(
    places: &[ParamPlace],
    told: &[Told],
    json: bool,
    meaning: impl Fn(&[u8]) -> Option<String>,
) -> Result<(), Failure> {
    let meant = |value: &(Format, Vec<u8>, u8)| meaning(&value.1).filter(|_| value.0 == Format::OCTET_STRING);
    let text = |value: &(Format, Vec<u8>, u8)| {
        let (format, octets, count) = value;
        let plain = || values_text(&Values { format: *format, count: *count, octets });
        meant(value).unwrap_or_else(plain)
    };
    if json {
        let one = |(place, told): (&ParamPlace, &Told)| match told {
            Ok(value) => {
                let (format, octets, _) = value;
                json!({ "parameter": place.to_string(), "format": format.words(), "text": text(value), "data": hex(octets) })
            }
            Err(refused) => json!({
                "parameter": place.to_string(), "error": refused.error.0, "info": refused.info, "text": refused.to_string(),
            }),
        };
        say(serde_json::Value::from_iter(places.iter().zip(told).map(one)))?;
    }
    let mut refused = Vec::new();
    for (place, told) in places.iter().zip(told) {
        match told {
            Ok(value) if !json => match meant(value) {
                Some(text) => say(format_args!("{place}: {text}"))?,
                None => say(format_args!("{place}: {} ({})", text(value), value.0.words()))?,
            },
            Ok(_) => {}
            Err(error) => {
                let cure = match error.error.cure() {
                    "" => String::new(),
                    cure => format!(": {cure}"),
                };
                refused.push(format!("{place}: {error}{cure}"));
            }
        }
    }
    if refused.is_empty() { Ok(()) } else { Err(Failure::Other(format!("refused: {}", refused.join("; ")))) }
}
