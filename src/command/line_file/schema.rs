//! The JSON Schema of the file, for editors. Only tests make it: they compare it with docs/line.schema.json.

use std::borrow::Cow;
use std::collections::BTreeSet;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::tables::{At, LineFile, LineKeys, LineTable};
use crate::command::args::{CAN_RATES, SLOT_TIMES};
use crate::host::fault::{Row, TIME_PATTERN};
use crate::host::list::Group;
use crate::time::BaudRate;

impl<T: JsonSchema> JsonSchema for At<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }

    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn schema_id() -> Cow<'static, str> {
        T::schema_id()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

impl JsonSchema for LineTable {
    fn schema_name() -> Cow<'static, str> {
        "LineTable".into()
    }

    /// The keys of a line, and a list of tables for each group.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut line = LineKeys::json_schema(generator);
        let about = "A line of PROFIBUS with drives and stations, or a CAN bus with nodes.";
        line.insert("description".to_owned(), about.into());
        for group in Group::ALL {
            let name = format!("{}Table", group.name());
            let mut schema = Schema::try_from(group.schema()).unwrap_or_default();
            schema.insert("description".to_owned(), format!("{}.", group.one()).into());
            let items = json!({ "$ref": format!("#/$defs/{name}") });
            generator.definitions_mut().insert(name, schema.to_value());
            let about = format!("{}{}; a table for each.", group.one(), group.page());
            let list = json!({ "description": about, "type": "array", "items": items });
            let properties = line.get_mut("properties").and_then(Value::as_object_mut).unwrap();
            properties.insert(group.name().to_owned(), list);
        }
        line
    }
}

/// Adds rules to a table, and more to its properties.
fn add(schema: &mut Schema, rules: Value, properties: Value) {
    let (Value::Object(rules), Value::Object(properties)) = (rules, properties) else { return };
    for (key, more) in properties {
        let property = schema.get_mut("properties").and_then(|all| all.get_mut(&key));
        if let (Some(property), Value::Object(more)) = (property.and_then(Value::as_object_mut), more) {
            property.extend(more);
        }
    }
    schema.ensure_object().extend(rules);
}

/// What others could reach needs a key that allows it.
fn allowed(key: &str, kind: &str, allow: &str) -> Value {
    let open = format!("^{kind}(0\\.0\\.0\\.0|\\[::\\]):");
    json!({
        "if": { "required": [key], "properties": { key: { "pattern": open } } },
        "then": { "required": [allow], "properties": { allow: { "const": true } } }
    })
}

const PLACE: &str = "^[^\\s]+:[0-9]{1,5}$";
const LINK: &str = "^(pty(:.+)?|serial:.+|tcp:.+:[0-9]{1,5}|slcan-pty(:.+)?|slcan-tcp:.+:[0-9]{1,5}|slcan-tty:.+|socketcan:.+)$";

pub(super) fn rules_of_file(schema: &mut Schema) {
    let rules = json!({
        "dependentRequired": { "metrics-allow-remote": ["metrics"] },
        "allOf": [allowed("metrics", "", "metrics-allow-remote")]
    });
    add(schema, rules, json!({ "line": { "minItems": 1 }, "metrics": { "pattern": PLACE } }));
}

pub(super) fn rules_of_line(schema: &mut Schema) {
    let none = |on_can| {
        let groups = Group::ALL.into_iter().filter(move |group| group.is_on_can() == on_can);
        groups.map(|group| (group.name().to_owned(), json!(false))).collect()
    };
    let (no_slaves, no_nodes): (Map<_, _>, Map<_, _>) = (none(false), none(true));
    let there: Vec<_> = Group::ALL.map(|group| json!({ "required": [group.name()] })).into();
    let rules = json!({
        "anyOf": there,
        "allOf": [
            allowed("panel", "", "panel-allow-remote"),
            allowed("link", "(slcan-)?tcp:", "allow-remote"),
            {
                "if": { "properties": { "link": { "pattern": "^(slcan|socketcan)" } } },
                "then": { "properties": no_slaves }
            },
            {
                "if": { "properties": { "link": { "not": { "pattern": "^(slcan|socketcan)" } } } },
                "then": { "properties": no_nodes }
            },
            {
                "if": { "required": ["slot-time"] },
                "then": { "properties": { "link": { "pattern": "^serial:" } } }
            }
        ]
    });
    let quirks = crate::host::list::quirks_schema(Group::ALL.into_iter().flat_map(Group::devices));
    let slot_time = json!({ "minimum": SLOT_TIMES.start(), "maximum": SLOT_TIMES.end() });
    let more = json!({
        "link": { "pattern": LINK }, "panel": { "pattern": PLACE }, "slot-time": slot_time, "quirks": quirks
    });
    add(schema, rules, more);
}

pub(super) fn rules_of_baud(schema: &mut Schema) {
    let rates: BTreeSet<u32> =
        BaudRate::ALL.map(BaudRate::bits_per_second).into_iter().chain(CAN_RATES).collect();
    let known: Vec<_> = rates.into_iter().map(Value::from).chain(["auto".into()]).collect();
    let Some(object) = schema.as_object_mut() else { return };
    object.retain(|key, _| key == "description");
    object.insert("enum".to_owned(), known.into());
}

pub(super) fn rules_of_fault(schema: &mut Schema) {
    let names: Vec<_> = Row::all().iter().map(|row| row.name).collect();
    let fault = format!("^({})(=|,|$)", names.join("|"));
    let time = json!({ "pattern": TIME_PATTERN });
    add(schema, json!({}), json!({ "fault": { "pattern": fault }, "from": time, "until": time }));
}

pub(super) fn rules_of_condition(schema: &mut Schema) {
    let one: Vec<_> = ["is", "above", "below"].map(|key| json!({ "required": [key] })).into();
    let kind = json!({ "pattern": "^(bit[0-7]|(un)?signed(8|16|32)|float32)$" });
    add(schema, json!({ "oneOf": one }), json!({ "type": kind, "station": { "maximum": 126 } }));
}

#[test]
fn the_schema_in_the_repository_is_that_of_the_tables() {
    let mut schema = serde_json::to_string_pretty(&schemars::schema_for!(LineFile)).unwrap();
    schema.push('\n');
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/line.schema.json");
    if std::env::var_os("PROFIDRIVE_REWRITE").is_some() {
        std::fs::write(file, &schema).unwrap();
    }
    let kept = std::fs::read_to_string(file).unwrap_or_default();
    assert_eq!(kept, schema, "rewrite it with PROFIDRIVE_REWRITE=1");
}

#[test]
fn every_key_is_explained() {
    let page = include_str!("../../../docs/line.md");
    let schema = serde_json::to_value(schemars::schema_for!(LineFile)).unwrap();
    let tables = schema["$defs"].as_object().unwrap().values();
    let keys = tables.filter_map(|table| table["properties"].as_object()).flat_map(|keys| keys.keys());
    for key in keys {
        assert!(page.contains(&format!("`{key}`")), "{key}");
    }
}

/// What only somebody can find who reads the files that are named, or compares two places of the file.
const BEYOND: &[&str] = &[
    // Other files.
    "cannot read",
    "has no PPO: none of its configurations",
    "has PPO 1, not PPO 5; choose one that it has",
    "has PPO 3, not PPO 1; choose one that it has",
    "there is no parameter 99",
    "'1': 50 is outside 100 to 6000",
    "there is no module '2 AOO'; did you mean '2 AO'?",
    "the station takes 8 modules (Max_Module)",
    "there is no slot 3; expected 1 to 2",
    "there is no slot 3",
    "output of module '2 AO': unsigned32 at octet 3 needs 7 octets, the slot has 4",
    "needs 2 octets, the slot has 0",
    "it reaches",
    // Another place of the file.
    "two stations have address 5",
    "two stations have address 7",
    "two lines have panel",
    "another input is bit0 at octet 0 of slot 1, the same bits",
    "there is no station 8",
    "there is no line 2; expected 1 to 1",
    "station 5 has no slots; name one of its values",
    "which is not on the line",
    // Arithmetic.
    "until must be later than from",
    "counts nothing",
    "it reaches -1, bit0 has 0 to 1",
    "it reaches 3, bit0 has 0 to 1",
    "no whole block",
    // Names and values of parameters, which are found in any case of letters.
    "close to it are 1004 v-Pos",
    "'v-Pos': the value must be within",
    "is no setting; leave it out",
    "has no d-Pos",
];

/// What a schema finds wrong, as far as ours goes; `None`: nothing.
fn wrong(schema: &Value, root: &Value, value: &Value) -> Option<String> {
    let Value::Object(rules) = schema else {
        return (*schema == Value::Bool(false)).then(|| format!("{value} may not be there"));
    };
    rules.iter().find_map(|(rule, says)| breaks(rule, says, rules, root, value))
}

/// Whether a value breaks one rule.
fn breaks(
    rule: &str,
    says: &Value,
    rules: &Map<String, Value>,
    root: &Value,
    value: &Value,
) -> Option<String> {
    let inner = |schema: &Value, value: &Value| wrong(schema, root, value);
    let fails = |holds: bool| (!holds).then(|| format!("{value}: {rule} {says}"));
    let list = |says: &Value| says.as_array().unwrap().clone();
    match rule {
        "$ref" => inner(root.pointer(&says.as_str().unwrap()[1..]).unwrap(), value),
        "type" => {
            let types = says.as_array().cloned().unwrap_or_else(|| vec![says.clone()]);
            fails(types.iter().any(|kind| match kind.as_str().unwrap() {
                "object" => value.is_object(),
                "array" => value.is_array(),
                "string" => value.is_string(),
                "boolean" => value.is_boolean(),
                "null" => value.is_null(),
                "number" => value.is_number(),
                "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
                other => panic!("{other}"),
            }))
        }
        "enum" => fails(list(says).contains(value)),
        "const" => fails(says == value),
        "minimum" => fails(value.as_f64().is_none_or(|got| got >= says.as_f64().unwrap())),
        "maximum" => fails(value.as_f64().is_none_or(|got| got <= says.as_f64().unwrap())),
        "minLength" => fails(value.as_str().is_none_or(|text| text.len() as u64 >= says.as_u64().unwrap())),
        "minItems" => fails(value.as_array().is_none_or(|all| all.len() as u64 >= says.as_u64().unwrap())),
        "pattern" => {
            let pattern = regex::Regex::new(says.as_str().unwrap()).unwrap();
            fails(value.as_str().is_none_or(|text| pattern.is_match(text)))
        }
        "required" => fails(
            value
                .as_object()
                .is_none_or(|object| list(says).iter().all(|key| object.contains_key(key.as_str().unwrap()))),
        ),
        "properties" => value.as_object().and_then(|object| {
            says.as_object().unwrap().iter().find_map(|(key, schema)| inner(schema, object.get(key)?))
        }),
        "additionalProperties" => value.as_object().and_then(|object| {
            let known = rules.get("properties").and_then(Value::as_object);
            let more = object.iter().filter(|(key, _)| known.is_none_or(|known| !known.contains_key(*key)));
            more.map(|(_, value)| value).find_map(|value| inner(says, value))
        }),
        "propertyNames" => value
            .as_object()
            .and_then(|object| object.keys().find_map(|key| inner(says, &Value::String(key.clone())))),
        "items" => value.as_array().and_then(|all| all.iter().find_map(|one| inner(says, one))),
        "allOf" => list(says).iter().find_map(|schema| inner(schema, value)),
        "anyOf" => fails(list(says).iter().any(|schema| inner(schema, value).is_none())),
        "oneOf" => fails(list(says).iter().filter(|schema| inner(schema, value).is_none()).count() == 1),
        "not" => fails(inner(says, value).is_some()),
        "if" if inner(says, value).is_none() => rules.get("then").and_then(|then| inner(then, value)),
        "dependentRequired" => value.as_object().and_then(|object| {
            says.as_object().unwrap().iter().find_map(|(key, needed)| {
                let all = list(needed).iter().all(|key| object.contains_key(key.as_str().unwrap()));
                fails(!object.contains_key(key) || all)
            })
        }),
        "if" | "then" | "title" | "description" | "default" | "$schema" | "$defs" | "format" => None,
        other => panic!("{other} is not understood by this test"),
    }
}

/// The files and pages of ours, and every device of the list with what only it cannot be without.
fn right_files() -> Vec<String> {
    let page = include_str!("../../../docs/line.md");
    let block = |first: &str| {
        let begin = page.find(&format!("```toml\n{first}")).unwrap() + "```toml\n".len();
        page[begin..].split("```").next().unwrap().to_owned()
    };
    let mut all = vec![
        include_str!("../../../examples/line/line.toml").to_owned(),
        include_str!("../../../packages/debian/example.toml").to_owned(),
        block("#:schema"),
        format!("[[line]]\nlink = 'slcan-pty:x'\n{}", block("[[line.node]]")),
        format!(
            "[[line]]\nlink = 'pty'\n[[line.station]]\naddress = 7\ngsd = 'x.gsd'\n{}",
            block("[[line.station.record]]")
        ),
    ];
    for group in Group::ALL {
        let link = if group.is_on_can() { "slcan-pty:x" } else { "pty" };
        for device in group.devices() {
            let own = device.choices().iter().filter(|choice| choice.required);
            let own: String = own.map(|choice| format!("{} = 'x.eds'\n", choice.key)).collect();
            let (table, place, key) = (group.name(), group.place_key(), group.device_key());
            let head = format!("[[line]]\nlink = '{link}'\n[[line.{table}]]\n{place} = 5\n{own}");
            let named = format!("{head}{key} = '{}'\n", device.name());
            all.extend((group.names().len() > 1).then_some(named));
            let is_usual = group.devices().next().is_some_and(|first| first.name() == device.name());
            all.extend((is_usual || !own.is_empty()).then_some(head));
        }
    }
    all
}

#[test]
fn the_schema_finds_what_needs_no_other_file_and_no_second_place() {
    let schema = serde_json::to_value(schemars::schema_for!(LineFile)).unwrap();
    let mut missed = Vec::new();
    for (text, _, words) in super::tests::wrong_files() {
        let Ok(value) = toml::from_str::<Value>(&text) else { continue };
        let beyond = BEYOND.iter().any(|beyond| words.ends_with(beyond));
        let found = wrong(&schema, &schema, &value);
        if found.is_some() == beyond {
            missed.push((words, found));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
    for right in right_files() {
        let value = toml::from_str::<Value>(&right).unwrap();
        assert_eq!(wrong(&schema, &schema, &value), None, "{right}");
    }
}
