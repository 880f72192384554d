//! Rules of keys that the types in [`file`](mod@super::file) state: required keys, keys of which one at most may be
//! given, ranges of numbers. They are read off the schema, so that a rule stands at its key and nowhere else.

use super::diagnostic::Diagnostic;
use super::keys::{inner, is_choice, properties, root};
use super::source::{Origin, Sources};
use super::tree::{CaseNode, Value, child_place};
use serde_json::Value as Schema;

/// Attribute of a key: the name of its group within the table, of which one key at most may be given.
const GROUP: &str = "x-one-of";

/// Attribute of a key: the condition under which it is required, in words. `always` and `or ...` are judged here, other
/// conditions by the code that resolves the key.
const REQUIRED: &str = "x-required";

/// Attribute of a key: the range of its numbers, in the words of the message about a number out of range.
const RANGE: &str = "x-range";

/// Keys of a table of which one at most may be given.
pub(super) struct KeyGroup<'a> {
    /// The keys, in the order of the types.
    pub keys: Vec<&'a str>,
    /// True if one of them must be given.
    pub required: bool,
}

/// A required key that a case lacks.
pub(super) struct MissingKey<'a> {
    /// Path of the key.
    pub path: String,
    /// Keys of the same table that would do as well.
    pub alternatives: Vec<&'static str>,
    /// Source position of the table that lacks the key; `None` for the case as a whole.
    pub table: Option<&'a Origin>,
}

/// The groups of keys in the table with this schema: laws to choose from, and keys that name a common group.
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

/// The keys of which only one may stand in the table at `place`, `key` among them; empty if `key` excludes no other.
/// `[]` stands for any element of a list.
pub(super) fn alternatives(place: &str, key: &str) -> Vec<&'static str> {
    let groups = schema_at(place).map(groups).unwrap_or_default();
    groups.into_iter().find(|group| group.keys.contains(&key)).map_or(Vec::new(), |group| group.keys)
}

/// The range of the numbers of a key in words; `None` if it has none.
pub(super) fn range(path: &str) -> Option<&'static str> {
    // a range stands at the key of a list, not at its elements
    let key = path.strip_suffix(']').and_then(|path| path.rsplit_once('[')).map_or(path, |(list, _)| list);
    words(schema_at(key)?, RANGE)
}

/// True if a number is within a range in words.
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

/// The schema at a path such as `particles[].sizes`; any index may stand between the brackets.
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

/// A table of a case with its schema and its path.
struct TypedTable<'a> {
    node: &'a CaseNode,
    schema: &'static Schema,
    path: String,
}

impl<'a> TypedTable<'a> {
    fn lacks(&self, key: &str) -> bool {
        self.node.get(key).is_none()
    }

    /// Source position for messages; the case as a whole has none.
    fn origin(&self) -> Option<&'a Origin> {
        (!self.path.is_empty()).then_some(&self.node.origin)
    }
}

/// All tables of a case, each before the tables within it.
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

/// The keys that are always required and that a case lacks, in the order of the types.
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

/// The required keys of a table that is itself absent; the table, if it has none.
fn absent<'a>(schema: &'static Schema, path: String, table: Option<&'a Origin>) -> Vec<MissingKey<'a>> {
    let required = properties(schema).filter(|(_, inner)| is_required(inner));
    let keys: Vec<_> = required.flat_map(|(key, inner)| absent(inner, child_place(&path, key), table)).collect();
    if keys.is_empty() { vec![MissingKey { path, alternatives: Vec::new(), table }] } else { keys }
}

/// Refuses a table with several keys of which one at most may be given.
///
/// # Errors
/// Points at the second of these keys.
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

/// Keys in words: "`a`, `b` and `c`".
fn list(keys: &[&str]) -> String {
    match keys {
        [] => String::new(),
        [one] => format!("`{one}`"),
        [first @ .., last] => format!("`{}` and `{last}`", first.join("`, `")),
    }
}

/// The limits named by the words of a range.
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

/// The number at the beginning of a text.
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
