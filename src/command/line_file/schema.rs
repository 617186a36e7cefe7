//! The JSON Schema of the file, for editors. Only tests make it: they compare it with docs/line.schema.json.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator};

use super::tables::{At, DeviceTable, LineFile, OfGroup};
use crate::host::list::Group;

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

impl<G: OfGroup> JsonSchema for DeviceTable<G> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}Table", G::GROUP.name()).into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut schema = Schema::try_from(G::GROUP.schema()).unwrap_or_default();
        schema.insert("description".to_owned(), about(G::GROUP).into());
        schema
    }
}

const fn about(group: Group) -> &'static str {
    match group {
        Group::Drive => "A drive.",
        Group::PpoDrive => "A drive with variable speed of PROFIDRIVE version 2.",
        Group::Station => "A station that a GSD describes.",
        Group::Node => "A CANopen node.",
    }
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
