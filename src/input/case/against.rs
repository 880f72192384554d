//! Key `against` of a variant: the name of another variant, or a table of values. A variant is the case with one
//! collision model and some settings.

use super::located::Located;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{MapAccess, Visitor};
use std::borrow::Cow;

/// Reference with which a variant (the case with one model and some settings) is compared, as typed in the case.
#[derive(Clone, Debug)]
pub enum AgainstFile {
    /// Name of another variant.
    Variant(String),
    /// Path of a file with a table of values, relative to the folder of the case.
    Table(Located<String>),
}

/// Value `{ table = "points.csv" }` of the key `against`, which names a file with reference values.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableFile {
    table: Located<String>,
}

impl<'de> Deserialize<'de> for AgainstFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrTable;
        impl<'de> Visitor<'de> for NameOrTable {
            type Value = AgainstFile;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a name, such as \"hard\", or { table = \"points.csv\" }")
            }

            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<AgainstFile, E> {
                Ok(AgainstFile::Variant(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AgainstFile, A::Error> {
                let table = TableFile::deserialize(serde::de::value::MapAccessDeserializer::new(map))?.table;
                Ok(AgainstFile::Table(table))
            }
        }
        deserializer.deserialize_any(NameOrTable)
    }
}

impl JsonSchema for AgainstFile {
    fn schema_name() -> Cow<'static, str> {
        "NameOrTable".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let table = json_schema!({
            "type": "string",
            "description": "File with a table of values, relative to the case.",
            "examples": ["points.csv"]
        });
        json_schema!({ "type": ["string", "object"], "properties": { "table": table } })
    }
}
