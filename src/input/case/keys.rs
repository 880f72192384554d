//! Descriptions of all keys, derived from the JSON schema (machine-readable list of keys, types and ranges) of the
//! types in [`file`](mod@super::file).

use super::file::CaseFile;
use super::quantity::{QUANTITY, UNIT};
use super::schema::add_limits;
use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde_json::{Map, Value, json};
use std::sync::LazyLock;

/// Description of a table of a case for `diptych keys`: its name, purpose and keys.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyTable {
    /// Name of the table, such as `soft.hertz`; empty for the case as a whole.
    pub name: String,
    /// True if a case can have several tables of this name, such as `[[walls]]`.
    pub is_list: bool,
    /// Purpose of the table, in words.
    pub about: String,
    /// Condition under which the table is required, in words; `None` if it is never required.
    pub required: Option<String>,
    /// Keys of the table that are not tables themselves.
    pub keys: Vec<Key>,
}

/// Description of a key of a table for `diptych keys`: type, unit, default, range and meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Name of the key within its table, such as `diameter`.
    pub name: String,
    /// Type of the value, in words: "length", "list of 3: length", "whole number".
    pub kind: String,
    /// SI unit of a number typed without a unit; `None` if the key has no unit.
    pub unit: Option<String>,
    /// Default value as it would be typed, or the meaning of an absent key in words; `None` if there is neither.
    pub default: Option<String>,
    /// Allowed range, in the same words as in the message about a value out of range; `None` if the key has no fixed
    /// range.
    pub range: Option<String>,
    /// Condition under which the key is required, in words; `None` if it is never required.
    pub required: Option<String>,
    /// Example of a value, as it would be typed; `None` if there is none.
    pub example: Option<String>,
    /// Meaning of the key, in words.
    pub about: String,
    /// Names that the key accepts, each with its meaning; empty if it accepts other values.
    pub choices: Vec<(String, String)>,
}

impl KeyTable {
    /// Heading of the table in a case, such as `[[walls]]`.
    pub fn heading(&self) -> String {
        if self.is_list { format!("[[{}]]", self.name) } else { format!("[{}]", self.name) }
    }
}

/// JSON schema (machine-readable list of keys, types and ranges) of a case, made from the type [`CaseFile`].
static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    // TOML has no null: a key without a value is absent
    let generator = settings.with_transform(RecursiveTransform(without_null)).into_generator();
    generator.into_root_schema_for::<CaseFile>().to_value()
});

/// All tables of a case, in the order in which the types of a case declare them. Each table comes before the tables
/// within it.
static TABLES: LazyLock<Vec<KeyTable>> = LazyLock::new(|| {
    let mut tables = Vec::new();
    collect(&SCHEMA, &SCHEMA, "", false, &mut tables);
    // the table without a name is the case as a whole: all its keys are tables, which are described by themselves
    tables.retain(|table| !table.name.is_empty());
    tables
});

/// Removes the type `null` from a schema. schemars adds it for an `Option`, but TOML has no null.
fn without_null(schema: &mut Schema) {
    let is_null = |value: &Value| *value == json!("null") || *value == json!({ "type": "null" });
    let Some(map) = schema.as_object_mut() else { return };
    if let Some(Value::Array(types)) = map.get_mut("type") {
        types.retain(|one| !is_null(one));
        if let [one] = types.as_slice() {
            let one = one.clone();
            map.insert("type".into(), one);
        }
    }
    if let Some(Value::Array(choices)) = map.get_mut("anyOf") {
        choices.retain(|one| !is_null(one));
        if let [Value::Object(one)] = choices.as_slice() {
            let one = one.clone();
            map.remove("anyOf");
            one.into_iter().for_each(|(key, value)| {
                map.entry(key).or_insert(value);
            });
        }
    }
}

/// Descriptions of all tables of a case. Each table comes before the tables within it.
pub fn tables() -> &'static [KeyTable] {
    &TABLES
}

/// JSON schema of a case, for editors. In every table the schema allows the key `use` (name of a set of values) in
/// addition to the keys of [`file`](mod@super::file).
pub fn schema() -> Value {
    let mut schema = SCHEMA.clone();
    add_limits(&mut schema);
    allow_names(&mut schema);
    allow_use(&mut schema);
    schema["title"] = json!("A case of Diptych");
    schema
}

/// Changes a schema so that a choice of a law also accepts the name of a law without keys, as in `drag = "stokes"`.
fn allow_names(schema: &mut Value) {
    if let Some(Value::Object(properties)) = schema.get_mut("properties") {
        properties.values_mut().for_each(allow_names);
    }
    let Some(Value::Array(tables)) = schema.get_mut("oneOf") else { return };
    tables.iter_mut().for_each(allow_names);
    let name = |table: &Value| match table.get("properties")?.as_object()?.iter().collect::<Vec<_>>()[..] {
        [(name, table)] if properties(table).next().is_none() => {
            Some(json!({ "const": name, "description": words(table, "description") }))
        }
        _ => None,
    };
    let names: Vec<Value> = tables.iter().filter_map(name).collect();
    tables.extend(names);
}

fn allow_use(schema: &mut Value) {
    if let Value::Array(items) = schema {
        items.iter_mut().for_each(allow_use);
    }
    let Value::Object(map) = schema else { return };
    if let Some(Value::Object(properties)) = map.get_mut("properties") {
        properties.values_mut().for_each(allow_use);
        let about =
            "Name of a set of values, such as `fluids/air`; keys beside it win. `diptych cases` lists the sets.";
        properties.insert("use".into(), json!({ "type": "string", "description": about }));
    }
    for key in ["oneOf", "anyOf", "items"] {
        map.get_mut(key).into_iter().for_each(allow_use);
    }
}

/// Alternatives that a schema allows: the list of its alternatives if it is a choice, else the schema itself.
fn branches(schema: &Value) -> &[Value] {
    match schema.get("oneOf").or_else(|| schema.get("anyOf")) {
        Some(Value::Array(branches)) => branches,
        _ => std::slice::from_ref(schema),
    }
}

/// Keys of a table with the schemas of their values. There are none if `schema` does not describe a table, or describes
/// a table with arbitrary keys.
pub(super) fn properties(schema: &Value) -> impl Iterator<Item = (&String, &Value)> {
    let of = |branch| Value::as_object(Value::get(branch, "properties")?);
    branches(schema).iter().filter_map(of).flat_map(Map::iter)
}

/// Schema of the value of a key in a table, or of the elements of a list if `key` is `None`. The result is `None` if
/// the table lacks the key, or if the value is no list.
pub(super) fn inner<'a>(schema: &'a Value, key: Option<&str>) -> Option<&'a Value> {
    match key {
        Some(key) => properties(schema).find(|(name, _)| *name == key).map(|(_, inner)| inner),
        None => schema.get("items"),
    }
}

/// True if a schema is a choice between tables, each with the name of a law as its key.
pub(super) fn is_choice(schema: &Value) -> bool {
    schema.get("oneOf").is_some() && properties(schema).next().is_some()
}

/// JSON schema of a whole case, without the key `use`.
pub(super) fn root() -> &'static Value {
    &SCHEMA
}

/// SI unit that a schema gives for numbers typed without a unit; `None` if the value has no unit.
pub(super) fn unit(schema: &Value) -> Option<&str> {
    schema.get(UNIT)?.as_str().filter(|unit| !unit.is_empty())
}

fn words(schema: &Value, key: &str) -> Option<String> {
    schema.get(key).and_then(Value::as_str).map(|text| text.replace('\n', " "))
}

fn is_table(schema: &Value) -> bool {
    branches(schema)
        .iter()
        .any(|branch| branch.get("properties").is_some() || branch.get("additionalProperties") == Some(&json!(false)))
}

/// Adds to `tables` the table whose keys `schema` lists, and the tables within it. The schema `about` contains the text
/// that explains the table to users. `is_list` is true for a list of such tables, false for a single table.
fn collect(schema: &Value, about: &Value, name: &str, is_list: bool, tables: &mut Vec<KeyTable>) {
    let holds_table = |value: &Value| is_table(value) || value.get("items").is_some_and(is_table);
    let inner = properties(schema).filter(|(_, value)| holds_table(value));
    // a number that can be replaced by a table, such as a restitution, is both a key and a table
    let keys = properties(schema).filter(|(_, value)| !holds_table(value) || value.get(QUANTITY).is_some());
    // a table that can take the place of a number is described with the key of that number
    if schema.get(QUANTITY).is_none() {
        tables.push(KeyTable {
            name: name.to_owned(),
            is_list,
            about: words(about, "description").unwrap_or_default(),
            required: words(about, "x-required"),
            keys: keys.map(|(name, schema)| key(name, schema)).collect(),
        });
    }
    for (key, value) in inner {
        let name = super::tree::child_place(name, key);
        // the table of a law is described by the alternative that contains it in the choice between laws
        let law = branches(schema)
            .iter()
            .find(|branch| schema.get("oneOf").is_some() && branch["properties"].get(key).is_some());
        let about = law.filter(|law| law.get("description").is_some()).unwrap_or(value);
        match value.get("items").filter(|items| is_table(items)) {
            Some(items) => collect(items, about, &name, true, tables),
            None => collect(value, about, &name, false, tables),
        }
    }
}

fn key(name: &str, schema: &Value) -> Key {
    let element = schema.get("items").unwrap_or(schema);
    let choices = branches(element).iter().filter_map(|branch| {
        let name = branch.get("const")?.as_str()?;
        Some((name.to_owned(), words(branch, "description").unwrap_or_default()))
    });
    let example = schema.get("examples").and_then(|examples| examples.get(0)).map(typed);
    Key {
        name: name.to_owned(),
        kind: kind(schema),
        unit: unit(element).map(str::to_owned),
        default: words(schema, "x-default").or_else(|| schema.get("default").map(typed)),
        range: words(schema, "x-range"),
        required: words(schema, "x-required"),
        example,
        about: words(schema, "description").unwrap_or_default(),
        choices: choices.collect(),
    }
}

/// Type of a value, in words such as "list of 3: length".
fn kind(schema: &Value) -> String {
    if let Some(quantity) = words(schema, QUANTITY) {
        return quantity;
    }
    if branches(schema).iter().any(|branch| branch.get("const").is_some()) {
        return "name".into();
    }
    match schema.get("type").and_then(Value::as_str) {
        Some("array") => {
            let element = schema.get("items").map(kind).unwrap_or_default();
            match schema.get("maxItems").and_then(Value::as_u64) {
                Some(count) => format!("list of {count}: {element}"),
                None => format!("list: {element}"),
            }
        }
        Some("integer") => "whole number".into(),
        Some("boolean") => "true or false".into(),
        Some("object") => "table of keys".into(),
        Some("string") => "text".into(),
        other => other.unwrap_or("any value").into(),
    }
}

/// Text of a JSON value as a user would type it in a case.
fn typed(value: &Value) -> String {
    toml::Value::try_from(value).map_or_else(|_| value.to_string(), |value| value.to_string())
}
