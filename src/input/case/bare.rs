//! Finds numbers without a unit as values of keys that require a unit.
//!
//! A number without a unit is read as SI, with a warning: a diameter of 406 that was meant in micrometres is read as
//! 406 m. There is no warning for keys without a unit, or for the number 0, which is 0 in every unit.

use super::diagnostic::Diagnostic;
use super::keys::{inner, root, unit};
use super::source::{SourceKind, Sources};
use super::tree::{CaseNode, Value, child_place};

/// Warnings about all keys that require a unit but whose value has a number without a unit.
pub fn bare_numbers(tree: &CaseNode, sources: &Sources) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    visit(tree, root(), "", sources, &mut found);
    found
}

fn visit(node: &CaseNode, schema: &serde_json::Value, path: &str, sources: &Sources, found: &mut Vec<Diagnostic>) {
    match &node.value {
        Value::Table(entries) => {
            for entry in entries {
                if let Some(schema) = inner(schema, Some(&entry.key)) {
                    visit(&entry.node, schema, &child_place(path, &entry.key), sources, found);
                }
            }
        }
        Value::Array(items) => match inner(schema, None) {
            // one warning for a whole vector, because all its components have the same unit
            Some(element) if unit(element).is_some() => {
                if let Some(bare) = items.iter().find(|item| is_bare(item, sources)) {
                    let typed: Vec<String> = items.iter().map(|item| with_unit(item, unit(element), sources)).collect();
                    found.push(warning(bare, path, unit(element), &format!("[{}]", typed.join(", ")), sources));
                }
            }
            Some(element) => items.iter().enumerate().for_each(|(place, item)| {
                visit(item, element, &format!("{path}[{place}]"), sources, found);
            }),
            None => {}
        },
        Value::Integer(_) | Value::Float(_) if is_bare(node, sources) && unit(schema).is_some() => {
            found.push(warning(node, path, unit(schema), &with_unit(node, unit(schema), sources), sources));
        }
        Value::Integer(_) | Value::Float(_) | Value::String(_) | Value::Boolean(_) => {}
    }
}

/// True if the value of a node is a number without a unit, other than 0. False for a number from a calling program,
/// which is in SI.
fn is_bare(node: &CaseNode, sources: &Sources) -> bool {
    let is_typed = sources.get(&node.origin).is_none_or(|source| source.kind != SourceKind::Values);
    match node.value {
        Value::Integer(number) => is_typed && number != 0,
        Value::Float(number) => is_typed && number != 0.0,
        Value::Table(_) | Value::Array(_) | Value::String(_) | Value::Boolean(_) => false,
    }
}

/// Text of a number that was typed without a unit, with `unit` added, as a user would type it. If the value is not a
/// number, the text is returned as it was typed.
fn with_unit(node: &CaseNode, unit: Option<&str>, sources: &Sources) -> String {
    let typed = sources.typed(&node.origin);
    match node.value {
        Value::Integer(_) | Value::Float(_) => format!("\"{typed} {}\"", unit.unwrap_or_default()),
        Value::Table(_) | Value::Array(_) | Value::String(_) | Value::Boolean(_) => typed,
    }
}

fn warning(node: &CaseNode, path: &str, unit: Option<&str>, instead: &str, sources: &Sources) -> Diagnostic {
    let (typed, unit) = (sources.typed(&node.origin), unit.unwrap_or_default());
    let message = format!("`{path}`: the number {typed} has no unit and is taken as {typed} {unit}");
    let key = path.rsplit('.').next().unwrap_or(path);
    sources.warning(&node.origin, message).help(format!("write {key} = {instead}"))
}
