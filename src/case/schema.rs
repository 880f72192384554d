//! Limits in the schema for editors, in addition to the list of keys: ranges of numbers, units of quantities, and keys
//! that exclude each other.
//!
//! A schema can judge a number, but not a product of units. For quantities with units it refuses single units of
//! another dimension, and words that are not units. The reader of the case checks everything.

use super::quantity::{Exponents, PREFIXES, UNITS, WHOLE_UNITS};
use super::tree::ALTERNATIVES;
use serde_json::{Map, Value, json};

/// Keys that exclude each other in the reader although a later source does not replace an earlier one.
const BOTH_REFUSED: (&str, &[&str]) = ("soft", &["linear_spring_dashpot", "hertz"]);

/// A pattern (ECMA 262) of quantities of a dimension; a fixed `word` is also accepted.
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

/// Adds the allowed ranges of numbers and the keys that exclude each other to the schema of a case.
pub fn add_limits(schema: &mut Value) {
    add_ranges(schema);
    for (place, keys) in ALTERNATIVES.iter().chain([&BOTH_REFUSED]) {
        if let Some(table) = at(schema, place) {
            exclude(table, keys);
        }
    }
}

/// The schema of the table at a position such as `particles[].sizes`.
fn at<'a>(schema: &'a mut Value, place: &str) -> Option<&'a mut Map<String, Value>> {
    let mut schema = schema;
    for part in place.split('.') {
        let (key, is_list) = part.strip_suffix("[]").map_or((part, false), |key| (key, true));
        schema = schema.get_mut("properties")?.get_mut(key)?;
        if is_list {
            schema = schema.get_mut("items")?;
        }
    }
    // one of several branches contains the properties
    schema.as_object_mut().filter(|table| table.contains_key("properties"))
}

/// Requires that no two of these keys stand in the table.
fn exclude(table: &mut Map<String, Value>, keys: &[&str]) {
    let pairs = keys.iter().enumerate().flat_map(|(k, one)| keys[k + 1..].iter().map(move |other| [one, other]));
    let refused: Vec<Value> = pairs.map(|pair| json!({ "not": { "required": pair } })).collect();
    match table.entry("allOf").or_insert_with(|| json!([])) {
        Value::Array(all) => all.extend(refused),
        other => *other = Value::Array(refused),
    }
}

/// Adds the ranges given in words as numbers, at every level; existing numbers stay.
fn add_ranges(schema: &mut Value) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(add_ranges),
        Value::Object(map) => {
            if let Some(Value::String(words)) = map.get("x-range") {
                let limits = limits(words);
                // in a list each element is limited, and in a number or a list both
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

/// Sets limits that are not yet set.
fn limit(numbers: &mut Map<String, Value>, limits: &[(&'static str, Value)]) {
    for (key, value) in limits {
        numbers.entry(*key).or_insert_with(|| value.clone());
    }
}

/// The limits named by the words of a range.
fn limits(words: &str) -> Vec<(&'static str, Value)> {
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
fn first(text: &str) -> Option<Value> {
    let word = text.split_whitespace().next()?;
    word.parse::<i64>().map(Value::from).or_else(|_| word.parse::<f64>().map(Value::from)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_ranges_are_numbers() {
        assert_eq!(limits("0 ..= 1"), [("minimum", json!(0)), ("maximum", json!(1))]);
        assert_eq!(limits("1e-6 m ..= 1e4 m"), [("minimum", json!(1e-6)), ("maximum", json!(1e4))]);
        assert_eq!(limits("more than -1, up to 0.5"), [("exclusiveMinimum", json!(-1)), ("maximum", json!(0.5))]);
        assert_eq!(limits("greater than 0 s"), [("exclusiveMinimum", json!(0))]);
        assert_eq!(limits("up to 1e9 s"), [("maximum", json!(1e9))]);
    }
}
