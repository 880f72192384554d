//! Writes a case with all changes as a new case file. A variant is the case with one collision model and some settings.

use super::Case;
use super::diagnostic::Diagnostic;
use super::tree::{CaseNode, Value, parse_path};
use crate::experiment::Model;

/// Variant of a case, for the `[[compare]]` list of the new file.
#[derive(Clone, Copy, Debug)]
pub struct Variant<'a> {
    /// Name of the variant.
    pub name: &'a str,
    /// Collision model of the variant.
    pub model: Model,
    /// Changes to the case for this variant, each of the form `key=value`.
    pub sets: &'a [&'a str],
}

impl Case {
    /// Text of a new case file: the case with the changes of the command line, below the comment `heading`. `variants`
    /// replace the `[[compare]]` list. Sets of values (parts of cases in `models/`) are not copied: the text names
    /// them by `use`, as the case does.
    ///
    /// # Errors
    /// A change of a key that does not fit the case.
    pub fn written(&self, heading: &str, variants: &[Variant]) -> Result<String, Diagnostic> {
        let mut tree = self.tree.clone();
        for setting in &self.sets {
            let why = |why: String| self.sources.error(&setting.key_origin, why);
            tree.set(&setting.path, setting.value.clone(), &setting.key_origin).map_err(why)?;
        }
        tree.remove("compare");
        let mut table = match value(&tree) {
            toml::Value::Table(table) => table,
            _ => toml::Table::new(),
        };
        let list = variants.iter().map(variant).collect::<Result<Vec<_>, _>>()?;
        table.insert("compare".into(), toml::Value::Array(list));
        let heading: String = heading.lines().map(|line| format!("# {line}").trim_end().to_owned() + "\n").collect();
        let text = toml::to_string(&table).map_err(|why| Diagnostic::about("case", why.to_string()))?;
        Ok(format!("{heading}\n{text}"))
    }
}

/// TOML value of a node of the tree of a case, without its source position.
fn value(node: &CaseNode) -> toml::Value {
    match &node.value {
        Value::Table(entries) => {
            entries.iter().map(|entry| (entry.key.clone(), value(&entry.node))).collect::<toml::Table>().into()
        }
        Value::Array(items) => toml::Value::Array(items.iter().map(value).collect()),
        Value::String(text) => text.clone().into(),
        Value::Integer(number) => (*number).into(),
        Value::Float(number) => (*number).into(),
        Value::Boolean(boolean) => (*boolean).into(),
    }
}

/// Entry for a variant in the `[[compare]]` list of the new case file.
fn variant(variant: &Variant) -> Result<toml::Value, Diagnostic> {
    let mut entry = toml::Table::new();
    entry.insert("name".into(), variant.name.into());
    entry.insert("model".into(), variant.model.name().into());
    let mut set = toml::Table::new();
    for change in variant.sets {
        let (key, text) = change.split_once('=').unwrap_or((change, ""));
        parse_path(key).map_err(|why| Diagnostic::about("set", why))?;
        let typed =
            toml::de::ValueDeserializer::parse(text).ok().and_then(|value| serde::Deserialize::deserialize(value).ok());
        set.insert(key.trim().to_owned(), typed.unwrap_or_else(|| toml::Value::String(text.to_owned())));
    }
    if !set.is_empty() {
        entry.insert("set".into(), set.into());
    }
    Ok(entry.into())
}
