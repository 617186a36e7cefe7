//! The JSON Schema of a specification, from the rows of the list.

use serde_json::{Map, Value, json};
use utoipa::openapi::{RefOr, Schema};

use super::{Choice, Group, Takes};

impl Group {
    /// The schema of a specification of the group, its own keys in `more`.
    pub(crate) fn schema(self, more: impl IntoIterator<Item = (String, Value)>) -> Value {
        let (least, most) = match self {
            Self::Drive | Self::PpoDrive | Self::Station => (0, 126),
            Self::Node => (1, 127),
        };
        let place = json!({ "description": std::format!("{least} to {most}."), "type": "integer", "minimum": least, "maximum": most });
        let mut properties = Map::new();
        properties.insert(self.place_key().to_owned(), place);
        let names = self.names();
        if names.len() > 1 {
            let usual = self.devices().next().map(super::Device::name);
            let device = json!({ "description": "Which device.", "enum": names, "default": usual });
            properties.insert(self.device_key().to_owned(), device);
        }
        let mut required = std::vec![self.place_key()];
        for choice in self.choices() {
            properties.insert(choice.key.to_owned(), choice.schema());
            if self.requires(choice) {
                required.push(choice.key);
            }
        }
        properties.extend(more);
        json!({ "type": "object", "additionalProperties": false, "properties": properties, "required": required })
    }
}

impl Group {
    /// The same for the description of the HTTP interface.
    pub(crate) fn open_api(self) -> RefOr<Schema> {
        serde_json::from_value(self.schema([])).unwrap_or_else(|_| RefOr::T(Schema::default()))
    }
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
        };
        if let Some(schema) = schema.as_object_mut() {
            schema.insert("description".to_owned(), self.about.into());
        }
        schema
    }
}
