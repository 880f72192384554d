//! Limits for the JSON schema that editors use: ranges of numbers, units of quantities, and keys that exclude each
//! other.
//!
//! A schema can check a number, but cannot compute the dimension of a product of units. So the schema refuses only
//! single units of a wrong dimension, and words that are not units. The reader of the case checks all quantities.

use super::keys::is_choice;
use super::quantity::{Exponents, PREFIXES, UNITS, WHOLE_UNITS};
use super::rules::{groups, limits};
use serde_json::{Map, Value, json};

/// Regular expression (ECMA 262) that matches a quantity of the dimension `wanted`. If `word` is given, the expression
/// also matches this word.
pub fn pattern(wanted: Exponents, word: Option<&str>) -> String {
    let named = |only: Option<Exponents>| {
        let is_wanted = |exponents: &Exponents| only.is_none_or(|only| only == *exponents);
        let whole = WHOLE_UNITS.iter().filter(|(_, exponents, ..)| is_wanted(exponents)).map(|(name, ..)| *name);
        let bases = UNITS.iter().filter(|(_, exponents, _)| is_wanted(exponents)).map(|(name, ..)| *name);
        let prefixes: String = PREFIXES.iter().map(|(prefix, _)| *prefix).collect();
        let bases = bases.map(|base| format!("[{prefixes}]?{base}"));
        whole.map(str::to_owned).chain(bases).collect::<Vec<_>>().join("|")
    };
    let number = r"[-+\u2212]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?";
    let (any, power) = (format!("(?:{})", named(None)), r"(?:\^?[-\u2212⁻]?[0-9⁰¹²³⁴⁵⁶⁷⁸⁹]+)");
    let more = format!(r"(?:[\s*·⋅/]+{any}{power}?)");
    let product = format!(r"[*·⋅/]\s*{any}{power}?{more}*|{any}{power}{more}*|{any}{more}+");
    let single = named(Some(wanted));
    let single = if single.is_empty() { single } else { format!("{single}|") };
    let word = word.map_or(String::new(), |word| format!("|^{word}$"));
    format!(r"^\s*{number}\s*(?:{single}{product})\s*${word}")
}

/// Adds the allowed ranges of numbers, and the keys that exclude each other, to the schema of a case.
pub fn add_limits(schema: &mut Value) {
    add_ranges(schema);
    add_exclusions(schema);
}

/// Adds to the schema of every table the condition that at most one key of each group (keys that exclude each other)
/// is present. The schema of a choice between laws already contains this condition.
fn add_exclusions(schema: &mut Value) {
    let groups = if is_choice(schema) { Vec::new() } else { groups(schema) };
    let groups: Vec<Vec<String>> =
        groups.iter().map(|group| group.keys.iter().map(|key| (*key).to_owned()).collect()).collect();
    match schema {
        Value::Array(items) => items.iter_mut().for_each(add_exclusions),
        Value::Object(table) => {
            groups.iter().for_each(|keys| exclude(table, keys));
            table.iter_mut().filter(|(key, _)| *key != "examples").for_each(|(_, inner)| add_exclusions(inner));
        }
        _ => {}
    }
}

/// Adds to the schema of a table the condition that at most one of `keys` is present.
fn exclude(table: &mut Map<String, Value>, keys: &[String]) {
    let pairs = keys.iter().enumerate().flat_map(|(k, one)| keys[k + 1..].iter().map(move |other| [one, other]));
    let refused: Vec<Value> = pairs.map(|pair| json!({ "not": { "required": pair } })).collect();
    match table.entry("allOf").or_insert_with(|| json!([])) {
        Value::Array(all) => all.extend(refused),
        other => *other = Value::Array(refused),
    }
}

/// Adds the ranges that are given in words to the schema as limits of numbers, at every level. Limits that the schema
/// already has are not changed.
fn add_ranges(schema: &mut Value) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(add_ranges),
        Value::Object(map) => {
            if let Some(Value::String(words)) = map.get("x-range") {
                let limits = limits(words);
                // the limits of a list apply to each element; if a number or a list is allowed, they apply to both
                if let Some(Value::Object(items)) = map.get_mut("items") {
                    limit(items, &limits);
                }
                if map.get("type") != Some(&json!("array")) {
                    limit(map, &limits);
                }
            }
            map.iter_mut().filter(|(key, _)| *key != "examples").for_each(|(_, inner)| add_ranges(inner));
        }
        _ => {}
    }
}

/// Adds limits, such as `minimum`, to the schema of a number. Limits that the schema already has are not changed.
fn limit(numbers: &mut Map<String, Value>, limits: &[(&'static str, Value)]) {
    for (key, value) in limits {
        numbers.entry(*key).or_insert_with(|| value.clone());
    }
}
