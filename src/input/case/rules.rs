//! Rules for keys, which the types in [`file`](mod@super::file) declare: required keys, keys that exclude each other,
//! ranges of numbers. This module reads the rules from the JSON schema of these types, so that each rule is declared
//! only with its key.

use super::diagnostic::Diagnostic;
use super::keys::{inner, is_choice, properties, root};
use super::source::{Origin, Sources};
use super::tree::{CaseNode, Value, child_place};
use serde_json::Value as Schema;

/// Attribute of a key with the name of a group within the table. At most one key of a group may be given.
const GROUP: &str = "x-one-of";

/// Attribute of a key with the condition, in words, under which the key is required. The conditions `always` and
/// `or ...` (or another key of the group) are checked in this file. Other conditions are checked by the code that
/// turns the case into an experiment.
const REQUIRED: &str = "x-required";

/// Attribute of a key with the allowed range of its numbers, in the same words as in messages.
const RANGE: &str = "x-range";

/// Keys of one table that exclude each other: at most one of them may be given.
pub(super) struct KeyGroup<'a> {
    /// Keys of the group, in the order in which the types of a case declare them.
    pub keys: Vec<&'a str>,
    /// True if one of the keys must be given.
    pub required: bool,
}

/// Required key that a case lacks.
pub(super) struct MissingKey<'a> {
    /// Path of the missing key, such as `run.duration`.
    pub path: String,
    /// Keys of the same table that could be given instead of the missing key.
    pub alternatives: Vec<&'static str>,
    /// Source position of the table that lacks the key; `None` if the whole case lacks it.
    pub table: Option<&'a Origin>,
}

/// Groups of keys that exclude each other in the table with the schema `table`. If the table is a choice between laws,
/// all its keys are one group. Otherwise keys with the same name of a group belong together.
pub(super) fn groups(table: &Schema) -> Vec<KeyGroup<'_>> {
    if is_choice(table) {
        return vec![KeyGroup { keys: properties(table).map(|(key, _)| key.as_str()).collect(), required: false }];
    }
    let mut found: Vec<(&str, KeyGroup)> = Vec::new();
    for (key, schema) in properties(table) {
        let Some(name) = words(schema, GROUP) else { continue };
        let index = found.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
            found.push((name, KeyGroup { keys: Vec::new(), required: false }));
            found.len() - 1
        });
        found[index].1.keys.push(key);
        found[index].1.required |= words(schema, REQUIRED).is_some_and(|when| when.starts_with("or "));
    }
    found.into_iter().map(|(_, group)| group).collect()
}

/// Keys that exclude each other, among them `key`, in the table at the path `place`. The list is empty if `key`
/// excludes no other key. In `place`, `[]` means any element of a list.
pub(super) fn alternatives(place: &str, key: &str) -> Vec<&'static str> {
    let groups = schema_at(place).map(groups).unwrap_or_default();
    groups.into_iter().find(|group| group.keys.contains(&key)).map_or(Vec::new(), |group| group.keys)
}

/// Allowed range, in words, of the numbers of the key at `path`; `None` if the key has no range.
pub(super) fn range(path: &str) -> Option<&'static str> {
    // the range of a list is declared with the key of the list, not with its elements
    let key = path.strip_suffix(']').and_then(|path| path.rsplit_once('[')).map_or(path, |(list, _)| list);
    words(schema_at(key)?, RANGE)
}

/// True if a number is within a range given in words, such as "greater than 0, up to 10".
pub(super) fn is_within(range: &str, number: f64) -> bool {
    limits(range).iter().all(|(kind, limit)| {
        let limit = limit.as_f64().unwrap_or(f64::NAN);
        match *kind {
            "minimum" => number >= limit,
            "exclusiveMinimum" => number > limit,
            _ => number <= limit,
        }
    })
}

/// Schema of the value at a path such as `particles[].sizes`; `None` if there is no such key. Any index may stand in
/// the brackets.
fn schema_at(path: &str) -> Option<&'static Schema> {
    path.split('.').filter(|part| !part.is_empty()).try_fold(root(), |schema, part| {
        let (key, brackets) = part.split_at(part.find('[').unwrap_or(part.len()));
        let value = inner(schema, Some(key))?;
        brackets.matches('[').try_fold(value, |list, _| inner(list, None))
    })
}

fn words<'a>(schema: &'a Schema, attribute: &str) -> Option<&'a str> {
    schema.get(attribute)?.as_str()
}

/// Table of a case, with its schema and its key path.
struct TypedTable<'a> {
    node: &'a CaseNode,
    schema: &'static Schema,
    path: String,
}

impl<'a> TypedTable<'a> {
    fn lacks(&self, key: &str) -> bool {
        self.node.get(key).is_none()
    }

    /// Source position of the table, for messages; `None` for the case as a whole.
    fn origin(&self) -> Option<&'a Origin> {
        (!self.path.is_empty()).then_some(&self.node.origin)
    }
}

/// All tables of a case; each comes before the tables within it.
fn tables(tree: &CaseNode) -> Vec<TypedTable<'_>> {
    let mut found = Vec::new();
    collect(tree, root(), String::new(), &mut found);
    found
}

fn collect<'a>(node: &'a CaseNode, schema: &'static Schema, path: String, found: &mut Vec<TypedTable<'a>>) {
    match &node.value {
        Value::Table(_) => {
            found.push(TypedTable { node, schema, path: path.clone() });
            for (key, schema) in properties(schema) {
                if let Some(node) = node.get(key) {
                    collect(node, schema, child_place(&path, key), found);
                }
            }
        }
        Value::Array(items) => {
            for (schema, (index, item)) in std::iter::repeat(inner(schema, None)).zip(items.iter().enumerate()) {
                schema.into_iter().for_each(|schema| collect(item, schema, format!("{path}[{index}]"), found));
            }
        }
        Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Boolean(_) => {}
    }
}

/// Required keys that a case lacks: keys that are always required, and groups of which one key is required and none is
/// given. They are in the order in which the types of a case declare them.
pub(super) fn missing(tree: &CaseNode) -> Vec<MissingKey<'_>> {
    let mut found = Vec::new();
    for table in tables(tree) {
        for (key, schema) in properties(table.schema).filter(|(key, schema)| is_required(schema) && table.lacks(key)) {
            found.extend(absent(schema, child_place(&table.path, key), table.origin()));
        }
        let needed = groups(table.schema).into_iter().filter(|group| group.required);
        for group in needed.filter(|group| group.keys.iter().all(|key| table.lacks(key))) {
            let path = child_place(&table.path, group.keys[0]);
            found.push(MissingKey { path, alternatives: group.keys[1..].to_vec(), table: table.origin() });
        }
    }
    found
}

fn is_required(schema: &Schema) -> bool {
    words(schema, REQUIRED) == Some("always")
}

/// Required keys of an absent table at the key path `path`, for a message. If the key at `path` is not a table, or the
/// table requires no keys, the result is that key itself.
fn absent<'a>(schema: &'static Schema, path: String, table: Option<&'a Origin>) -> Vec<MissingKey<'a>> {
    let required = properties(schema).filter(|(_, inner)| is_required(inner));
    let keys: Vec<_> = required.flat_map(|(key, inner)| absent(inner, child_place(&path, key), table)).collect();
    if keys.is_empty() { vec![MissingKey { path, alternatives: Vec::new(), table }] } else { keys }
}

/// Refuses a table that has several keys of one group, which exclude each other.
///
/// # Errors
/// An error about the second of these keys.
pub(super) fn refuse_conflicts(tree: &CaseNode, sources: &Sources) -> Result<(), Diagnostic> {
    for table in tables(tree) {
        for group in groups(table.schema) {
            let given: Vec<_> = group.keys.iter().filter_map(|key| table.node.entry(key)).collect();
            let [_, second, ..] = given.as_slice() else { continue };
            let named: Vec<_> = given.iter().map(|entry| entry.key.as_str()).collect();
            let message = format!("`{}` has {}, which exclude each other", table.path, list(&named));
            let help = format!("keep one of {}", list(&group.keys));
            return Err(sources.error(&second.key_origin, message).help(help));
        }
    }
    Ok(())
}

/// List of keys as a text: "`a`, `b` and `c`".
fn list(keys: &[&str]) -> String {
    match keys {
        [] => String::new(),
        [one] => format!("`{one}`"),
        [first @ .., last] => format!("`{}` and `{last}`", first.join("`, `")),
    }
}

/// Limits of a range that is given in words, such as "0 ..= 1", as entries of a JSON schema such as `minimum`.
pub(super) fn limits(words: &str) -> Vec<(&'static str, Schema)> {
    if let Some((low, high)) = words.split_once("..=") {
        return [("minimum", low), ("maximum", high)]
            .into_iter()
            .filter_map(|(key, text)| Some((key, first(text)?)))
            .collect();
    }
    let one = |part: &str| {
        let kinds = [("greater than ", "exclusiveMinimum"), ("more than ", "exclusiveMinimum"), ("up to ", "maximum")];
        kinds.into_iter().find_map(|(begin, key)| Some((key, first(part.trim().strip_prefix(begin)?)?)))
    };
    words.split(',').filter_map(one).collect()
}

/// Number at the beginning of a text; `None` if the text does not begin with a number.
fn first(text: &str) -> Option<Schema> {
    let word = text.split_whitespace().next()?;
    word.parse::<i64>().map(Schema::from).or_else(|_| word.parse::<f64>().map(Schema::from)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn words_of_ranges_are_numbers() {
        assert_eq!(limits("0 ..= 1"), [("minimum", json!(0)), ("maximum", json!(1))]);
        assert_eq!(limits("1e-6 m ..= 1e4 m"), [("minimum", json!(1e-6)), ("maximum", json!(1e4))]);
        assert_eq!(limits("more than -1, up to 0.5"), [("exclusiveMinimum", json!(-1)), ("maximum", json!(0.5))]);
        assert_eq!(limits("greater than 0 s"), [("exclusiveMinimum", json!(0))]);
        assert_eq!(limits("up to 1e9 s"), [("maximum", json!(1e9))]);
    }
}
