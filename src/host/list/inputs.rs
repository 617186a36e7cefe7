//! What moves the inputs of a station that a GSD describes.

use std::path::Path;

use super::signals::{BEHAVIOUR, read as read_signal, whole};
use super::{Given, Wrong};
use crate::gsd::Station;
use crate::process::{Elsewhere, Input, Origin, Point, Signal, Source, ValueType, What};
use crate::profibus::dp::Application as _;

/// The keys of an input besides those of its signal.
pub(crate) const OWN: &[&str] = &["slot", "octet", "type"];

/// The keys of a value elsewhere.
const ELSEWHERE: &[&str] = &["line", "station", "slot", "octet", "type", "input", "value"];

/// Where a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// Among the inputs.
    Input,
    /// Among the outputs.
    Output,
}

/// The inputs of a station, each with what it follows.
///
/// # Errors
/// [`Wrong`] says which input and which key.
pub(super) fn inputs(
    key: &str,
    given: &[Given],
    folder: &Path,
    station: &Station,
) -> Result<Vec<Input>, Wrong> {
    let mut inputs: Vec<Input> = Vec::new();
    for (number, given) in given.iter().enumerate() {
        let number = number.to_string();
        let input = of_given(given, folder, station).map_err(|wrong| wrong.under(&[key, &number]))?;
        let Point { slot, kind, offset } = input.point();
        let own = kind.places(offset);
        let shares = |other: &&Input| {
            let places = other.point().kind.places(other.point().offset);
            other.point().slot == slot && places.start < own.end && own.start < places.end
        };
        if let Some(other) = inputs.iter().find(shares).map(Input::point) {
            let words = format!(
                "another input is {} at octet {} of slot {slot}, the same bits; take one of the two out",
                other.kind, other.offset
            );
            return Err(Wrong::at("type", words).under(&[key, &number]));
        }
        inputs.push(input);
    }
    Ok(inputs)
}

/// One input: a table, or in one line `SLOT/OCTET/TYPE:BEHAVIOUR:KEY=VALUE:...`.
fn of_given(given: &Given, folder: &Path, station: &Station) -> Result<Input, Wrong> {
    let of_text;
    let table = match given {
        Given::Table(table) => table,
        Given::Text(text) => {
            of_text = of_line(text)?;
            &of_text
        }
        Given::Flag(_) | Given::Number(_) | Given::List(_) => {
            return Err(Wrong::whole(format!("{given} is no input; expected a table with slot and type")));
        }
    };
    let to = point(table)?;
    check(station, to, Direction::Input)?;
    let source = read_signal(table, OWN, folder)?;
    signal(source, to, station).map(|signal| Input::new(to, signal))
}

/// The signal of an input, checked.
///
/// # Errors
/// [`Wrong`] says which key.
pub(crate) fn signal(source: Source<Given>, to: Point, station: &Station) -> Result<Signal<Origin>, Wrong> {
    let source = source.try_named(|place, of| {
        origin(&of, station).map_err(|wrong| match place {
            Some(place) => wrong.under(&["of", &place.to_string()]),
            None => wrong.under(&["of"]),
        })
    })?;
    if let Source::Constant(value) = source {
        to.kind.write(&mut [0; 4], 0, value).map_err(|error| Wrong::at("value", error))?;
    }
    let signal = Signal::new(source).map_err(Wrong::whole)?;
    let ends = |origin: &Origin| match origin {
        Origin::Output(point) | Origin::Input(point) => ends(point),
        Origin::Elsewhere(elsewhere) => ends_elsewhere(elsewhere),
    };
    if let Some((low, high)) = signal.source().extremes(ends) {
        let (least, most) = to.kind.range();
        let beyond = |value: &f64| value.is_finite() && !(least..=most).contains(value);
        if let Some(got) = [low, high].into_iter().find(beyond) {
            let words = format!("it reaches {got}, {} has {least} to {most}", to.kind);
            return Err(Wrong::at(BEHAVIOUR, words));
        }
    }
    Ok(signal)
}

/// What a value surely reaches: a bit both its values, of others nobody knows.
const fn ends(point: &Point) -> Option<(f64, f64)> {
    if let ValueType::Bit(_) = point.kind { Some(point.kind.range()) } else { None }
}

/// The same of a value of another device.
pub(super) const fn ends_elsewhere(elsewhere: &Elsewhere) -> Option<(f64, f64)> {
    match &elsewhere.what {
        What::Output(point) => ends(point),
        What::Value(_) => None,
    }
}

/// The file that an input names.
pub(crate) fn file_of(given: &Given) -> Option<String> {
    let of_text;
    let table = match given {
        Given::Table(table) => table,
        Given::Text(text) => {
            of_text = of_line(text).ok()?;
            &of_text
        }
        Given::Flag(_) | Given::Number(_) | Given::List(_) => return None,
    };
    table.iter().find(|(key, _)| key == "file").map(|(_, name)| name.to_string())
}

/// The keys of an input in one line. A part without `=` belongs to the one before, as in `file=C:\a.csv`.
fn of_line(text: &str) -> Result<Vec<(String, Given)>, Wrong> {
    let (place, rest) = text.split_once(':').unwrap_or((text, ""));
    let mut table = of_place(place).ok_or_else(|| {
        Wrong::whole(format!("'{text}' is no input; expected SLOT/OCTET/TYPE:BEHAVIOUR:KEY=VALUE:..."))
    })?;
    for part in rest.split(':').filter(|part| !part.is_empty()) {
        let has_keys = table.len() > OWN.len();
        if let Some((key, value)) = part.split_once('=') {
            table.push((key.to_owned(), Given::Text(value.to_owned())));
        } else if let Some((_, Given::Text(before))) = table.last_mut().filter(|_| has_keys) {
            before.push(':');
            before.push_str(part);
        } else {
            table.push((BEHAVIOUR.to_owned(), Given::Text(part.to_owned())));
        }
    }
    Ok(table)
}

/// `[LINE/][STATION/][input/]SLOT/OCTET/TYPE` or `[LINE/]STATION/VALUE`.
fn of_place(text: &str) -> Option<Vec<(String, Given)>> {
    let parts: Vec<&str> = text.split('/').collect();
    let (head, mut own) = match &*parts {
        [head @ .., slot, octet, kind] if kind.parse::<ValueType>().is_ok() => {
            (head, vec![("slot", *slot), ("octet", *octet), ("type", *kind)])
        }
        [head @ .., value] if !head.is_empty() => (head, vec![("value", *value)]),
        _ => return None,
    };
    let head = match head {
        [head @ .., "input"] => {
            own.push(("input", "true"));
            head
        }
        head => head,
    };
    match head {
        [] => {}
        [station] => own.push(("station", *station)),
        [line, station] => own.extend([("line", *line), ("station", *station)]),
        _ => return None,
    }
    Some(own.into_iter().map(|(key, value)| (key.to_owned(), Given::Text(value.to_owned()))).collect())
}

/// Where a signal reads.
fn origin(of: &Given, station: &Station) -> Result<Origin, Wrong> {
    let of_text;
    let table = match of {
        Given::Table(table) => table,
        Given::Text(text) => {
            of_text = of_place(text).ok_or_else(|| {
                Wrong::whole(format!("'{text}' is no value; expected SLOT/OCTET/TYPE or STATION/VALUE"))
            })?;
            &of_text
        }
        Given::Flag(_) | Given::Number(_) | Given::List(_) => {
            return Err(Wrong::whole(format!("{of} is no value; expected a table with slot and type")));
        }
    };
    if let Some((key, _)) = table.iter().find(|(key, _)| !ELSEWHERE.contains(&&**key)) {
        return Err(Wrong::key(key, format!("'{key}' is unknown; expected {}", ELSEWHERE.join(", "))));
    }
    let given = |key: &str| table.iter().find(|(known, _)| known == key).map(|(_, given)| given);
    let line = given("line").map(|line| whole("line", line)).transpose()?;
    let other = given("station").map(|other| whole("station", other)).transpose()?;
    let what = match given("value") {
        Some(value) => What::Value(value.to_string()),
        None => What::Output(point(table)?),
    };
    let is_input = given("input").is_some_and(|input| matches!(&*input.to_string(), "true"));
    match (other, what) {
        (Some(_), _) if is_input => {
            Err(Wrong::at("input", "inputs of other stations are not shown; follow an output of it"))
        }
        (Some(station), what) => Ok(Origin::Elsewhere(Elsewhere { line, station, what })),
        (None, What::Value(_)) => Err(Wrong::at("value", "a value by its name needs 'station'")),
        (None, What::Output(point)) if is_input => {
            check(station, point, Direction::Input).map(|()| Origin::Input(point))
        }
        (None, What::Output(point)) => {
            check(station, point, Direction::Output).map(|()| Origin::Output(point))
        }
    }
}

/// A value in a slot.
fn point(table: &[(String, Given)]) -> Result<Point, Wrong> {
    let given = |key: &str| table.iter().find(|(known, _)| known == key).map(|(_, given)| given);
    let needed = |key: &str| given(key).ok_or_else(|| Wrong::whole(format!("'{key}' is missing")));
    let slot = whole("slot", needed("slot")?)?;
    let offset = given("octet").map(|octet| whole::<u8>("octet", octet)).transpose()?.unwrap_or(0);
    let kind = needed("type")?.to_string().parse().map_err(|error| Wrong::at("type", error))?;
    Ok(Point { slot, offset: offset.into(), kind })
}

/// Whether the station has it. Where the master chooses the modules, it may.
///
/// # Errors
/// [`Wrong`] at `slot` or `type`.
pub(crate) fn check(station: &Station, point: Point, direction: Direction) -> Result<(), Wrong> {
    if !station.is_fixed() {
        return Ok(());
    }
    let layout = station.layout(station.configuration(None), None);
    let Some(placed) = layout.iter().find(|placed| placed.slot.number == point.slot) else {
        let ends = layout.first().zip(layout.last());
        let ends =
            ends.map(|(first, last)| format!("; expected {} to {}", first.slot.number, last.slot.number));
        return Err(Wrong::at(
            "slot",
            format!("there is no slot {}{}", point.slot, ends.unwrap_or_default()),
        ));
    };
    let (octets, name) = match direction {
        Direction::Input => (placed.slot.inputs.len(), "input"),
        Direction::Output => (placed.slot.outputs.len(), "output"),
    };
    let mut scratch = vec![0; octets];
    let read = point.kind.write(&mut scratch, point.offset, 0.0);
    let module = placed.name(station.gsd());
    let key = if octets == 0 { "slot" } else { "type" };
    read.map_err(|error| Wrong::at(key, format!("{name} of module '{module}': {error}")))
}
