//! The schema for editors refuses bad values. It must accept everything that the reader accepts.

use diptych::case::built_in;
use diptych::case::keys::schema;
use regex_lite::Regex;
use serde_json::{Value, json};

const BASE: &str = include_str!("inputs/good/base.toml");

/// Reason why a value does not fit a schema, for the kinds of rules that schemas of cases contain.
fn misfit(value: &Value, schema: &Value, path: &str) -> Option<String> {
    let kinds = schema["type"].as_array().cloned().unwrap_or_else(|| match &schema["type"] {
        Value::Null => Vec::new(),
        one => vec![one.clone()],
    });
    let kind = |kind: &Value| match kind.as_str().unwrap() {
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64(),
        "boolean" => value.is_boolean(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("{other}"),
    };
    let wrong = |what: &str| Some(format!("{path} = {value}: {what}"));
    if !kinds.is_empty() && !kinds.iter().any(kind) {
        return wrong("type");
    }
    if let (Some(text), Some(pattern)) = (value.as_str(), schema["pattern"].as_str()) {
        // the pattern \s means ASCII white space in this crate, and the tested texts are ASCII
        if !Regex::new(pattern).unwrap().is_match(text) {
            return wrong("pattern");
        }
    }
    if let Some(number) = value.as_f64() {
        let limit =
            |key: &str, good: fn(f64, f64) -> bool| schema[key].as_f64().is_none_or(|limit| good(number, limit));
        if !limit("minimum", |a, b| a >= b)
            || !limit("maximum", |a, b| a <= b)
            || !limit("exclusiveMinimum", |a, b| a > b)
        {
            return wrong("range");
        }
    }
    if schema.get("const").is_some_and(|only| only != value) {
        return wrong("const");
    }
    for all in schema["allOf"].as_array().into_iter().flatten() {
        let required = all["not"]["required"].as_array().unwrap();
        if required.iter().all(|key| value.get(key.as_str().unwrap()).is_some()) {
            return wrong("two of which one belongs here");
        }
    }
    for key in ["oneOf", "anyOf"] {
        let Some(branches) = schema[key].as_array() else { continue };
        let fits = branches.iter().filter(|branch| misfit(value, branch, path).is_none()).count();
        if fits == 0 || key == "oneOf" && fits > 1 {
            return wrong(key);
        }
    }
    for item in value.as_array().into_iter().flatten() {
        if let Some(why) = schema.get("items").and_then(|items| misfit(item, items, &format!("{path}[]"))) {
            return Some(why);
        }
    }
    for (key, inner) in value.as_object().into_iter().flatten() {
        let found = match schema["properties"].get(key) {
            Some(schema) => misfit(inner, schema, &format!("{path}.{key}")),
            None if schema["additionalProperties"] == json!(false) => wrong("unknown key"),
            None => None,
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

fn of(text: &str) -> Option<String> {
    let case: toml::Table = text.parse().unwrap();
    misfit(&serde_json::to_value(case).unwrap(), &schema(), "")
}

#[test]
fn the_schema_takes_every_case_of_the_project() {
    for case in built_in::cases() {
        assert_eq!(of(case.text), None, "{}", case.name);
    }
    assert_eq!(of(BASE), None);
}

#[test]
fn the_schema_refuses_what_no_reader_takes() {
    for (good, bad, why) in [
        ("duration = \"0.1 s\"", "duration = \"1 kg\"", "pattern"),
        ("duration = \"0.1 s\"", "duration = \"soon\"", "pattern"),
        ("duration = \"0.1 s\"", "duration = \"1 furlong\"", "pattern"),
        ("count = 100", "count = -1", "range"),
        ("count = 100", "count = 100\nvolume_fraction = 0.1", "two of which"),
        ("restitution = 0.9\n", "restitution = 2\n", "range"),
        ("slices = 10", "slices = 0", "range"),
        ("steps_per_contact = 20", "steps_per_contact = 20\ntime_step = \"1 us\"", "two of which"),
        ("restitution = 0.94\n", "sphere = { radius = 1.0 }\nrestitution = 0.94\n", "two of which"),
        ("size = [\"12 mm\", ", "size = [1e9, ", "range"),
    ] {
        let text = BASE.replacen(good, bad, 1);
        assert_ne!(text, BASE, "{good}");
        let found = of(&text);
        assert!(found.as_ref().is_some_and(|found| found.contains(why)), "{bad}: {found:?}");
    }
    for duration in ["90 s", "2 min", "1e3 ms", "1 m s m^-1", "3 N/m*m/N*s", "1 1/Hz", "+.5 h", " 7 µs "] {
        assert_eq!(of(&BASE.replace("\"0.1 s\"", &format!("{duration:?}"))), None, "{duration}");
    }
}
