//! What moves the inputs of a node: objects that it only tells, and whatever else surrounds it.

use std::path::Path;

use super::choice::near;
use super::inputs::ends_elsewhere;
use super::signals::{BEHAVIOUR, read as read_signal, whole};
use super::{Given, Wrong};
use crate::can_bus::canopen::{Address, dictionary};
use crate::devices::CanopenDevice;
use crate::face::surroundings::{Input, InputKind};
use crate::host::can::{NodeOrigin, NodeSignal};
use crate::process::{Elsewhere, Signal, What};

/// The keys of an input besides those of its signal.
pub(crate) const OWN: &[&str] = &["object"];

/// The keys of a value elsewhere.
const ELSEWHERE: &[&str] = &["object", "line", "station", "value"];

/// The inputs of a node, each with what it follows.
///
/// # Errors
/// [`Wrong`] says which input and which key.
pub(super) fn signals(
    key: &str,
    given: &[Given],
    folder: &Path,
    device: &dyn CanopenDevice,
) -> Result<Vec<NodeSignal>, Wrong> {
    let mut signals: Vec<NodeSignal> = Vec::new();
    for (number, given) in given.iter().enumerate() {
        let number = number.to_string();
        let under = |wrong: Wrong| wrong.under(&[key, &number]);
        let signal = of_given(given, folder, device).map_err(under)?;
        if signals.iter().any(|other| other.input() == signal.input()) {
            let words = format!("{} is there twice; take one of the two out", signal.input());
            return Err(under(Wrong::at("object", words)));
        }
        signals.push(signal);
    }
    Ok(signals)
}

fn of_given(given: &Given, folder: &Path, device: &dyn CanopenDevice) -> Result<NodeSignal, Wrong> {
    let Given::Table(table) = given else {
        return Err(Wrong::whole(format!(
            "{given} is no object; expected a table with object and behaviour"
        )));
    };
    let name = table.iter().find(|(key, _)| key == "object").map(|(_, name)| name.to_string());
    let name = name.ok_or_else(|| Wrong::whole("'object' is missing; expected for example \"6064h\""))?;
    let (mut found, mut all): (Option<Input>, Vec<&'static str>) = (None, Vec::new());
    device.description().each_input(&mut |input, _| {
        all.push(input.name);
        if input.name == name || address(input.name).is_some_and(|at| address(&name) == Some(at)) {
            found = Some(*input);
        }
    });
    let Some(input) = found else {
        let cure = match &*all {
            [] => "this node has none".to_owned(),
            all => format!("{}expected one of {}", near(&name, all.iter().copied()), all.join(", ")),
        };
        let words = format!("'{name}' is no input of this node, a number that can only be read; {cure}");
        return Err(Wrong::at("object", words));
    };
    let source = read_signal(table, OWN, folder)?.try_named(|place, of| {
        origin(&of, device).map_err(|wrong| match place {
            Some(place) => wrong.under(&["of", &place.to_string()]),
            None => wrong.under(&["of"]),
        })
    })?;
    let signal = Signal::new(source).map_err(Wrong::whole)?;
    let ends = |origin: &NodeOrigin| match origin {
        NodeOrigin::Object(_) => None,
        NodeOrigin::Elsewhere(elsewhere) => ends_elsewhere(elsewhere),
    };
    if let (Some((low, high)), InputKind::Number { low: least, high: most, .. }) =
        (signal.source().extremes(ends), input.kind)
    {
        let beyond = |value: &f64| value.is_finite() && !(least..=most).contains(value);
        if let Some(got) = [low, high].into_iter().find(beyond) {
            let words = format!("it reaches {got}, {} has {least} to {most}", input.name);
            return Err(Wrong::at(BEHAVIOUR, words));
        }
    }
    Ok(NodeSignal::new(input.name.to_owned(), input.kind == InputKind::Switch, signal))
}

/// Where a signal reads: an object of this node, `[LINE/]STATION/VALUE`, or a table.
fn origin(of: &Given, device: &dyn CanopenDevice) -> Result<NodeOrigin, Wrong> {
    let of_text;
    let table = match of {
        Given::Table(table) => table,
        Given::Text(text) => {
            let keys: &[&str] = match text.matches('/').count() {
                0 => &["object"],
                1 => &["station", "value"],
                _more => &["line", "station", "value"],
            };
            let parts = text.splitn(3, '/').map(|part| Given::Text(part.to_owned()));
            of_text = keys.iter().map(|key| (*key).to_owned()).zip(parts).collect();
            &of_text
        }
        Given::Flag(_) | Given::Number(_) | Given::List(_) => {
            return Err(Wrong::whole(format!("{of} is no value; expected an object, or a table")));
        }
    };
    if let Some((key, _)) = table.iter().find(|(key, _)| !ELSEWHERE.contains(&&**key)) {
        return Err(Wrong::key(key, format!("'{key}' is unknown; expected {}", ELSEWHERE.join(", "))));
    }
    let given = |key: &str| table.iter().find(|(known, _)| known == key).map(|(_, given)| given);
    if let Some(object) = given("object") {
        let name = object.to_string();
        let at = address(&name).filter(|at| dictionary::entry(device.application().objects(), *at).is_ok());
        return at.map(NodeOrigin::Object).ok_or_else(|| {
            Wrong::at("object", format!("'{name}' is no object of this node; expected for example \"6064h\""))
        });
    }
    let line = given("line").map(|line| whole("line", line)).transpose()?;
    match (given("station"), given("value")) {
        (Some(station), Some(value)) => Ok(NodeOrigin::Elsewhere(Elsewhere {
            line,
            station: whole("station", station)?,
            what: What::Value(value.to_string()),
        })),
        (None, _) | (_, None) => Err(Wrong::whole("expected object, or station and value")),
    }
}

/// `6064h`, `0x6064`, `6401h:01`.
fn address(text: &str) -> Option<Address> {
    let hexadecimal = |text: &str| {
        let digits = text.strip_prefix("0x").unwrap_or(text);
        let digits = digits.strip_suffix(['h', 'H']).unwrap_or(digits);
        let is_number = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        is_number.then(|| u16::from_str_radix(digits, 16).ok()).flatten()
    };
    let (index, sub) = text.trim().split_once(':').unwrap_or((text, "0"));
    Some(Address::new(hexadecimal(index)?, u8::try_from(hexadecimal(sub)?).ok()?))
}

#[cfg(test)]
#[cfg(feature = "eds")]
mod tests {
    use super::*;
    use crate::can_bus::canopen::NodeId;
    use crate::can_bus::canopen::node::storage::Eeprom;
    use crate::devices::from_eds::{Dictionary, FromEds};
    use crate::eds::Eds;

    fn read(text: &str) -> Result<Vec<NodeSignal>, Wrong> {
        let eds = Eds::read(include_bytes!("../../../tests/eds/pump.eds")).unwrap();
        let device = FromEds::on_node(Dictionary::hold(eds), NodeId::MIN, Eeprom::Internal);
        let parts = text.split(' ').filter_map(|part| part.split_once('='));
        let table = parts.map(|(key, value)| (key.to_owned(), Given::Text(value.to_owned()))).collect();
        signals("value", &[Given::Table(table)], Path::new(""), &device)
    }

    #[test]
    fn an_object_is_named_in_any_form_and_follows_every_kind_of_value() {
        for text in [
            "object=2001h value=2",
            "object=0x2001 behaviour=sine amplitude=1 period=1s",
            "object=2002 behaviour=count from=0 to=9 every=1s",
            "object=2002h:00 behaviour=mirror of=2000h",
            "object=2002h behaviour=scale of=9/position factor=2",
            "object=2002h behaviour=follow station=9 of=position",
        ] {
            let signals = read(text).map_err(|wrong| wrong.to_string());
            assert_eq!(signals.map(|signals| signals.len()), Ok(1), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_key() {
        for (text, path, words) in [
            ("value=2", "value.0", "'object' is missing"),
            ("object=2000h value=2", "value.0.object", "'2000h' is no input of this node"),
            ("object=2001h behaviour=ramp", "value.0.behaviour", "ramp needs 'from'"),
            (
                "object=2002h value=1e9",
                "value.0.behaviour",
                "it reaches 1000000000, 2002h has -8388608 to 8388607",
            ),
            (
                "object=2001h behaviour=mirror of=2100h",
                "value.0.of.object",
                "'2100h' is no object of this node",
            ),
            ("object=2001h behaviour=mirror of=x/position", "value.0.of.station", "expected a number, not x"),
            ("object=2001h sped=2", "value.0.sped", "'sped' is unknown"),
        ] {
            let wrong = read(text).unwrap_err();
            assert!(wrong.words.contains(words), "{text}: {}", wrong.words);
            assert_eq!(wrong.path.join("."), path, "{text}");
        }
    }
}
