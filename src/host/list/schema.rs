//! The JSON Schema of a specification, from the rows of the list.

use serde_json::{Map, Value, json};
use utoipa::openapi::{RefOr, Schema};

use super::acyclic::ACCESS;
use super::signals::{BEHAVIOUR, Holds, KINDS, LIMITS};
use super::timed::{AREA, DIRECTIONS, KEYS, TIMES, WIDTHS};
use super::{Choice, Group, Takes};
use crate::host::fault::TIME_PATTERN;
use crate::process::ValueType;
use crate::profibus::dpv1::{AlarmType, PARAMETER_INDEX, Specifier};

/// The type of a value in a slot.
const TYPE: &str = "(bit[0-7]|(un)?signed(8|16|32)|float32)";

impl Group {
    /// The schema of a specification of the group, its own keys in `more`.
    pub(crate) fn schema(self) -> Value {
        let (least, most) = match self {
            Self::Drive | Self::PpoDrive | Self::Profidrive | Self::Station => (0, 126),
            Self::Node => (1, 127),
        };
        let place = json!({ "description": std::format!("{least} to {most}."), "type": "integer", "minimum": least, "maximum": most });
        let mut properties = Map::new();
        properties.insert(self.place_key().to_owned(), place);
        let mut rules = std::vec::Vec::new();
        let names = self.names();
        if names.len() > 1 {
            let usual = self.devices().next().map(super::Device::name);
            let device = json!({ "description": "Which device.", "enum": names, "default": usual });
            properties.insert(self.device_key().to_owned(), device);
            rules.extend(self.devices().enumerate().map(|(number, device)| self.rule(number == 0, device)));
        }
        let mut required = std::vec![self.place_key()];
        for choice in self.choices() {
            properties.insert(choice.key.to_owned(), choice.schema());
            if self.requires(choice) {
                required.push(choice.key);
            }
        }
        let mut schema = json!({
            "type": "object", "additionalProperties": false, "properties": properties, "required": required
        });
        if let Self::PpoDrive | Self::Profidrive = self {
            rules.push(json!({ "not": { "required": ["gsd", "ident"] } }));
        }
        if let (false, Some(schema)) = (rules.is_empty(), schema.as_object_mut()) {
            schema.insert("allOf".to_owned(), rules.into());
        }
        if let Some(quirks) = schema.pointer_mut("/properties/quirks").and_then(Value::as_object_mut)
            && let Value::Object(known) = quirks_schema(self.devices())
        {
            quirks.extend(known);
        }
        schema
    }

    /// What one of several devices has, and what it cannot be without.
    fn rule(self, is_usual: bool, device: &super::Device) -> Value {
        let key = self.device_key();
        let required = |device: &super::Device| -> std::vec::Vec<_> {
            device.choices().iter().filter(|choice| choice.required).map(|choice| choice.key).collect()
        };
        let named = json!({ "required": [key], "properties": { key: { "const": device.name() } } });
        // Unless it is named, a key that only one device cannot be without names it.
        let unnamed = if is_usual {
            let others = self.devices().filter(|other| other.name() != device.name());
            let others: std::vec::Vec<_> = others.flat_map(required).chain([key]).collect();
            json!({ "not": { "anyOf": others.iter().map(|key| json!({ "required": [key] })).collect::<Value>() } })
        } else {
            let own = required(device).into_iter().map(|own| json!({ "required": [own] }));
            json!({ "not": { "required": [key] }, "anyOf": own.chain([json!(false)]).collect::<Value>() })
        };
        let keys = device.choices().iter().map(|choice| choice.key).chain([self.place_key(), key]);
        let mut then = json!({
            "required": required(device), "propertyNames": { "enum": keys.collect::<std::vec::Vec<_>>() }
        });
        if let (Some(_), Some(then)) = (device.quirks().first(), then.as_object_mut()) {
            let names: std::vec::Vec<_> = device.quirks().iter().map(|row| row.name).collect();
            then.insert("properties".to_owned(), json!({ "quirks": { "propertyNames": { "enum": names } } }));
        }
        json!({ "if": { "anyOf": [named, unnamed] }, "then": then })
    }
}

/// The quirks of some devices.
pub(crate) fn quirks_schema(devices: impl Iterator<Item = &'static super::Device>) -> Value {
    let mut known = Map::new();
    for row in devices.flat_map(super::Device::quirks) {
        known.insert(row.name.to_owned(), json!({ "description": row.about, "enum": row.values }));
    }
    json!({ "type": "object", "additionalProperties": false, "properties": known })
}

impl Group {
    /// The same for the description of the HTTP interface.
    pub(crate) fn open_api(self) -> RefOr<Schema> {
        serde_json::from_value(without_rules(self.schema())).unwrap_or_else(|_| RefOr::T(Schema::default()))
    }
}

/// The same without what the description of the HTTP interface cannot say.
fn without_rules(mut schema: Value) -> Value {
    if let Some(object) = schema.as_object_mut() {
        object.retain(|key, _| key != "allOf");
        for value in object.values_mut() {
            *value = without_rules(value.take());
        }
    }
    schema
}

/// An input with its signal.
fn inputs() -> Value {
    let kind = json!({
        "description": "bit0 to bit7, unsigned8, unsigned16, unsigned32, signed8, signed16, signed32 or float32.",
        "type": "string",
        "pattern": std::format!("^{TYPE}$")
    });
    let slot = json!({ "description": "The number of the slot.", "type": "integer", "minimum": 0, "maximum": 65535 });
    let octet = json!({
        "description": "Its first octet in the slot, from 0; 0 unless given.",
        "type": "integer", "minimum": 0, "maximum": 255
    });
    let value = json!({
        "description": "A value elsewhere: SLOT/OCTET/TYPE, STATION/VALUE, or a table.",
        "type": ["string", "object"],
        "additionalProperties": false,
        "properties": {
            "line": { "description": "The number of the line, from 1.", "type": "integer", "minimum": 1 },
            "station": { "description": "The address on the line.", "type": "integer", "minimum": 0, "maximum": 127 },
            "slot": slot, "octet": octet, "type": kind,
            "input": { "description": "An input of the same station, not an output.", "type": "boolean" },
            "value": { "description": "The name of a value that the device tells of itself.", "type": "string" }
        },
        "anyOf": [{ "required": ["slot", "type"] }, { "required": ["value"] }]
    });
    let own = [("slot", &slot), ("octet", &octet), ("type", &kind)];
    let place = std::format!("[0-9]+/[0-9]+/{TYPE}");
    let of = Elsewhere {
        value,
        text: std::format!("^(([0-9]+/){{0,2}}(input/)?{place}|([0-9]+/){{1,2}}[^/]+)$"),
        beside_a_station: std::format!("^({place}|[^/]+)$"),
    };
    signal(&own, &["slot", "type"], &of)
}

/// An object of a node with its signal.
fn node_objects() -> Value {
    let object = json!({
        "description": "The object, as 6064h or 6401h:01, or another input of the node.", "type": "string", "minLength": 1
    });
    let value = json!({
        "description": "A value elsewhere: an object of the node, STATION/VALUE, or a table.",
        "type": ["string", "object"],
        "additionalProperties": false,
        "properties": {
            "object": { "description": "An object of the same node.", "type": "string" },
            "line": { "description": "The number of the line, from 1.", "type": "integer", "minimum": 1 },
            "station": { "description": "The address on the line.", "type": "integer", "minimum": 0, "maximum": 127 },
            "value": { "description": "The name of a value that the device tells of itself.", "type": "string" }
        },
        "anyOf": [{ "required": ["object"] }, { "required": ["value"] }]
    });
    let number = "(0x)?[0-9A-Fa-f]{1,4}[hH]?";
    let of = Elsewhere {
        value,
        text: std::format!("^({number}(:{number})?|([0-9]+/){{1,2}}.+)$"),
        beside_a_station: ".".to_owned(),
    };
    signal(&[("object", &object)], &["object"], &of)
}

/// How a value elsewhere is given.
struct Elsewhere {
    /// Text or a table.
    value: Value,
    /// The pattern of the text, and where a key beside it names the station.
    text: std::string::String,
    beside_a_station: std::string::String,
}

/// What an input follows; `own` are its keys besides.
fn signal(own: &[(&str, &Value)], required: &[&str], of: &Elsewhere) -> Value {
    let value = &of.value;
    let of_key = |holds: Holds| match holds {
        Holds::Number => json!({ "type": "number" }),
        Holds::Step => json!({ "type": "number", "not": { "const": 0 } }),
        Holds::Whole => json!({ "type": "integer", "minimum": 0 }),
        Holds::Time => json!({ "type": "string", "pattern": TIME_PATTERN }),
        Holds::OneOf(words) => json!({ "enum": words }),
        Holds::File => json!({ "type": "string", "minLength": 1 }),
        Holds::Value | Holds::Values => {
            json!({ "anyOf": [value, { "type": "array", "minItems": 1, "items": value }] })
        }
    };
    let names: std::vec::Vec<_> = KINDS.iter().map(|kind| kind.name).collect();
    let behaviour = json!({ "description": "What it follows.", "enum": names, "default": names.first() });
    let mut properties = Map::new();
    for (key, schema) in own.iter().copied().chain([(BEHAVIOUR, &behaviour)]) {
        properties.insert(key.to_owned(), schema.clone());
    }
    for key in KINDS.iter().flat_map(|kind| kind.keys) {
        properties.entry(key.name).or_insert_with(|| of_key(key.holds));
    }
    let mut rules = std::vec::Vec::new();
    for (place, kind) in KINDS.iter().enumerate() {
        let is_needed = if place == 0 { json!([]) } else { json!([BEHAVIOUR]) };
        let keys = kind.keys.iter().map(|key| key.name);
        let keys: std::vec::Vec<_> = own.iter().map(|(key, _)| *key).chain([BEHAVIOUR]).chain(keys).collect();
        let needed = kind.keys.iter().filter(|key| key.required).map(|key| key.name);
        let needed: std::vec::Vec<_> = needed.collect();
        let text = if keys.contains(&"station") { &of.beside_a_station } else { &of.text };
        let single = match kind.keys.iter().find(|key| key.name == "of").map(|key| key.holds) {
            Some(Holds::Value) => json!({ "of": { "type": ["string", "object"], "pattern": text } }),
            Some(_) => json!({ "of": { "type": "array", "items": { "pattern": text } } }),
            None => json!({}),
        };
        let compares = LIMITS.iter().all(|limit| keys.contains(limit));
        let mut then = json!({
            "description": kind.about, "required": needed, "propertyNames": { "enum": keys }, "properties": single
        });
        if let (true, Some(then)) = (compares, then.as_object_mut()) {
            then.insert("oneOf".to_owned(), LIMITS.map(|limit| json!({ "required": [limit] })).into());
        }
        rules.push(json!({
            "if": { "properties": { BEHAVIOUR: { "const": kind.name } }, "required": is_needed }, "then": then
        }));
    }
    // What a value of each type may be, where no arithmetic decides it.
    for kind in ValueType::all() {
        let (least, most) = kind.range();
        let is_float = kind == ValueType::Float32;
        let within = if is_float { json!({}) } else { json!({ "minimum": least, "maximum": most }) };
        let whole = if is_float { "number" } else { "integer" };
        rules.push(json!({
            "if": { "properties": { "type": { "const": kind.to_string() } }, "required": ["type"] },
            "then": {
                "properties": {
                    "value": { "type": whole, "allOf": [within] },
                    "high": within, "low": within, "least": within, "most": within
                },
                "allOf": [{
                    "if": { "properties": { BEHAVIOUR: { "const": "ramp" } }, "required": [BEHAVIOUR] },
                    "then": { "properties": { "from": within, "to": within } }
                }]
            }
        }));
    }
    json!({
        "type": "object", "additionalProperties": false, "properties": properties, "required": required,
        "allOf": rules
    })
}

/// A diagnosis on the time line.
fn diagnosis() -> Value {
    let time = json!({ "type": "string", "pattern": TIME_PATTERN });
    let slot = json!({ "type": "integer", "minimum": 0, "maximum": 65535 });
    let up_to = |most: u32| json!({ "type": "integer", "minimum": 0, "maximum": most });
    let list = |items: &Value| json!({ "type": "array", "items": items });
    let table = |properties: Value, required: &[&str]| json!({ "type": "object", "additionalProperties": false, "properties": properties, "required": required });
    let words = |known: std::vec::Vec<&str>| json!({ "enum": known, "default": known.first() });
    let errors: std::vec::Vec<u8> = (1..=9).chain(16..=31).collect();
    let channel = json!({
        "slot": slot, "channel": up_to(63), "error": { "enum": errors },
        "direction": words(DIRECTIONS.iter().map(|(word, _)| *word).collect()),
        "width": words(WIDTHS.iter().map(|(word, _)| *word).collect()),
    });
    let about = |about: &str, mut schema: Value| {
        if let Some(schema) = schema.as_object_mut() {
            schema.insert("description".to_owned(), about.into());
        }
        schema
    };
    let mut rows = table(
        json!({
            "from": about("When it begins, from the start of the line on; at once unless given.", time.clone()),
            "until": about("When it ends.", time),
            "bits": about("Unit_Diag_Bit: the bits whose text applies.", list(&up_to(495))),
            "areas": about(
                "Unit_Diag_Area.",
                list(&table(json!({ "first-bit": up_to(495), "value": up_to(u32::MAX) }), AREA)),
            ),
            "identifiers": about("Slots of the identifier-related diagnosis.", list(&slot)),
            "invalid": about("Slots whose module has a fault (module status).", list(&slot)),
            "wrong": about("Slots in which another module is plugged.", list(&slot)),
            "missing": about("Slots whose module is pulled.", list(&slot)),
            "channels": about(
                "Channel-related diagnosis.",
                list(&table(channel, &["slot", "channel", "error"])),
            ),
            "octets": about("Blocks as octets, behind the others.", list(&up_to(255))),
            "not-valid": about("Stat_Diag: the inputs are not valid.", json!({ "type": "boolean" })),
        }),
        &[],
    );
    let one: std::vec::Vec<_> = KEYS.iter().skip(TIMES).map(|key| json!({ "required": [key] })).collect();
    if let Some(rows) = rows.as_object_mut() {
        rows.insert("allOf".to_owned(), json!([{ "anyOf": one }]));
    }
    rows
}

/// Octets in hexadecimal.
const HEX: &str = "^( *[0-9A-Fa-f]{2})* *$";

/// A record of DP-V1.
fn record() -> Value {
    let up_to = |about: &str, least: u32, most: u32| json!({ "description": about, "type": "integer", "minimum": least, "maximum": most });
    let access: std::vec::Vec<_> = ACCESS.iter().map(|(word, _)| *word).collect();
    json!({
        "type": "object", "additionalProperties": false, "required": ["slot", "index"],
        "properties": {
            "slot": up_to("0: the station; from 1: its modules.", 0, 254),
            "index": up_to("Which record; 47 and 255 have a meaning of their own.", 0, 254),
            "length": up_to("How many octets, of a record without data.", 1, 240),
            "data": { "description": "Its octets, hexadecimal.", "type": "string", "pattern": HEX },
            "access": { "description": "What a master may do: read, write.", "enum": access, "default": access.first() },
            "delay": { "description": "How long a job takes.", "type": "string", "pattern": TIME_PATTERN },
        },
        "anyOf": [{ "required": ["length"] }, { "required": ["data"] }],
        "allOf": [{ "properties": { "index": { "not": { "const": PARAMETER_INDEX } } } }],
    })
}

/// An alarm on the time line.
fn alarm() -> Value {
    let time = |about: &str| json!({ "description": about, "type": "string", "pattern": TIME_PATTERN });
    let specifiers = Specifier::NAMED.map(|(word, _)| word);
    let types = AlarmType::NAMED.map(|(word, _)| word);
    json!({
        "type": "object", "additionalProperties": false, "required": ["type"],
        "properties": {
            "at": time("When it comes, from the start of the line on; at once unless given."),
            "every": time("It comes again after each such time."),
            "type": {
                "description": "Its type, a number for one of the manufacturer.",
                "anyOf": [{ "enum": types }, { "type": "integer", "minimum": 1, "maximum": 126 }],
            },
            "slot": { "description": "Of which slot; 0 unless given: the station.", "type": "integer", "minimum": 0, "maximum": 254 },
            "specifier": { "description": "Whether it begins or ends.", "enum": specifiers, "default": "none" },
            "additional-ack": { "description": "The user of the master shall acknowledge it, too.", "type": "boolean", "default": false },
            "data": { "description": "What the manufacturer says, hexadecimal, at most 59 octets.", "type": "string", "pattern": HEX },
        },
    })
}

impl Choice {
    fn schema(&self) -> Value {
        let mut schema = match self.takes {
            Takes::OneOf(known, usual) => {
                let as_written =
                    |word: &&str| word.parse::<u64>().map_or_else(|_| json!(word), |number| json!(number));
                let known: std::vec::Vec<_> = known.iter().map(as_written).collect();
                let usual = usual.map(|usual| as_written(&usual));
                match usual {
                    Some(usual) => json!({ "enum": known, "default": usual }),
                    None => json!({ "enum": known }),
                }
            }
            Takes::Hexadecimal => json!({ "type": "string", "pattern": "^(0x)?[0-9A-Fa-f]{1,4}$" }),
            Takes::File([]) => json!({ "type": "string", "minLength": 1 }),
            Takes::File(endings) => {
                json!({ "type": "string", "pattern": std::format!("\\.({})$", endings.join("|")) })
            }
            Takes::Flag => json!({ "type": "boolean", "default": false }),
            Takes::Names => json!({ "type": "array", "items": { "type": "string" } }),
            Takes::Quirks => json!({ "type": "object", "additionalProperties": { "type": "string" } }),
            Takes::Values => json!({ "type": "object", "additionalProperties": { "type": "number" } }),
            Takes::Records => json!({ "type": "array", "items": record() }),
            Takes::Alarms => json!({ "type": "array", "items": alarm() }),
            Takes::Diagnosis => json!({ "type": "array", "items": diagnosis() }),
            Takes::Inputs => json!({ "type": "array", "items": inputs() }),
            Takes::Objects => json!({ "type": "array", "items": node_objects() }),
        };
        if let Some(schema) = schema.as_object_mut() {
            schema.insert("description".to_owned(), self.about.into());
        }
        schema
    }
}
