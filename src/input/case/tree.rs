//! A case as a tree of values, each with its source position.
//!
//! A case file, the sets of `models/` that it uses, the `set` of a variant (an entry of `[[compare]]`) and the `--set`
//! arguments are all read into such trees. One function, [`CaseNode::overlay`], merges them.

use super::diagnostic::Diagnostic;
use super::source::{Origin, Sources};
use crate::legible::quote;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Value in a case, with its position in the source text.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseNode {
    /// Value: a table, a list or a single value.
    pub value: Value,
    /// Source position of the value.
    pub origin: Origin,
}

/// Value in a case, of one of the possible types. Dates are refused when the text is read.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Table, with its keys in the order of the file.
    Table(Vec<Entry>),
    /// List, written as `[..]` or `[[..]]`.
    Array(Vec<CaseNode>),
    /// Text, typed in quotes.
    String(String),
    /// Whole number.
    Integer(i64),
    /// Floating-point number; infinite if the typed number is too large for a double.
    Float(f64),
    /// Boolean, `true` or `false`.
    Boolean(bool),
}

impl Value {
    /// Type of the value, in words.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Table(_) => "a table",
            Self::Array(_) => "a list",
            Self::String(_) => "a string",
            Self::Integer(_) => "a whole number",
            Self::Float(_) => "a number",
            Self::Boolean(_) => "true or false",
        }
    }
}

/// Key of a table with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Name of the key.
    pub key: String,
    /// Source position of the key.
    pub key_origin: Origin,
    /// Value of the key.
    pub node: CaseNode,
}

/// Path of the key `key` in the table at the path `place`: `place.key`, or only `key` if the table is the case itself.
pub fn child_place(place: &str, key: &str) -> String {
    if place.is_empty() { key.to_string() } else { format!("{place}.{key}") }
}

impl CaseNode {
    /// Creates an empty table.
    pub fn empty_table(origin: Origin) -> Self {
        Self { value: Value::Table(Vec::new()), origin }
    }

    /// Value of a key; `None` if this node is not a table with that key.
    pub fn get(&self, key: &str) -> Option<&CaseNode> {
        self.entry(key).map(|entry| &entry.node)
    }

    /// Entry of a key; `None` if this node is not a table with that key.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|entry| entry.key == key),
            _ => None,
        }
    }

    /// Removes a key from a table and returns its entry. `None` if the table has no such key, or if the node is not a
    /// table.
    pub fn remove(&mut self, key: &str) -> Option<Entry> {
        match &mut self.value {
            Value::Table(entries) => {
                let at = entries.iter().position(|entry| entry.key == key)?;
                Some(entries.remove(at))
            }
            _ => None,
        }
    }
}

/// One step of a path such as `particles[0].count`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum KeyPart {
    /// Key of a table. A number is also accepted as the index of a list (`particles.0.count`).
    Key(String),
    /// Index `[n]` in a list.
    Index(usize),
}

impl KeyPart {
    /// True if this step of the path is the given key of a table.
    pub fn is_key(&self, key: &str) -> bool {
        matches!(self, Self::Key(known) if known == key)
    }

    /// Index in a list that this step of the path gives; `None` if the step cannot be an index.
    pub fn index(&self) -> Option<usize> {
        match self {
            Self::Key(key) => key.parse().ok(),
            Self::Index(index) => Some(*index),
        }
    }
}

/// Largest number of steps of a path. The paths of keys that exist have fewer than ten steps.
const DEEPEST: usize = 64;

/// Reads a path such as `a.b[0].c`.
///
/// # Errors
/// A message in words: the text is not such a path.
pub fn parse_path(text: &str) -> Result<Vec<KeyPart>, String> {
    let bad = |why: &str| format!("`{}` is not a key such as `particles[0].count`: {why}", quote(text));
    let mut path = Vec::new();
    for part in text.split('.') {
        // each step becomes a nested table, and recursive functions visit the tables: without a limit the stack could
        // overflow
        if path.len() >= DEEPEST {
            return Err(bad(&format!("it has more than {DEEPEST} parts")));
        }
        let part = part.trim();
        let (key, mut brackets) = part.split_at(part.find('[').unwrap_or(part.len()));
        let key = key.trim().trim_matches('"');
        if key.is_empty() {
            return Err(bad("a name is missing"));
        }
        path.push(KeyPart::Key(key.to_string()));
        while !brackets.is_empty() {
            let (index, after) = brackets
                .strip_prefix('[')
                .and_then(|inner| inner.split_once(']'))
                .ok_or_else(|| bad("brackets do not match"))?;
            if path.len() >= DEEPEST {
                return Err(bad(&format!("it has more than {DEEPEST} parts")));
            }
            path.push(KeyPart::Index(index.trim().parse().map_err(|_| bad("an index is a whole number from 0"))?));
            brackets = after.trim_start();
        }
    }
    Ok(path)
}

/// Reads a whole TOML text into a tree.
///
/// # Errors
/// An error about the line that is not TOML, with a remedy for common mistakes.
pub fn parse(text: &str, source: usize, sources: &Sources) -> Result<CaseNode, Diagnostic> {
    match DeTable::parse(text) {
        Ok(table) => {
            let span = table.span();
            convert_table(table.into_inner(), span, source, sources)
        }
        Err(error) => {
            let origin = Origin { source, span: error.span().unwrap_or(0..0) };
            let diagnostic = sources.error(&origin, syntax_message(error.message(), &sources.typed(&origin)));
            let line = diagnostic.place.as_ref().map_or("", |place| place.text.as_str());
            let fallback = if diagnostic.message.contains("given twice") {
                "keep one of the two".to_string()
            } else {
                "a case is made of `[tables]` and lines `key = value`, see https://toml.io".to_string()
            };
            let help = syntax_help(line).unwrap_or(fallback);
            Err(diagnostic.help(help))
        }
    }
}

/// Reads one TOML value, which begins at the byte `offset` of its source. `None` if the text is not TOML, so that the
/// caller can read it as a string.
pub fn parse_value(
    text: &str,
    offset: usize,
    source: usize,
    sources: &Sources,
) -> Option<Result<CaseNode, Diagnostic>> {
    let value = DeValue::parse(text).ok()?;
    Some(convert(value, source, sources).map(|mut node| {
        shift(&mut node, offset);
        node
    }))
}

fn shift(node: &mut CaseNode, offset: usize) {
    node.origin.span = node.origin.span.start + offset..node.origin.span.end + offset;
    match &mut node.value {
        Value::Table(entries) => {
            for entry in entries {
                let span = &entry.key_origin.span;
                entry.key_origin.span = span.start + offset..span.end + offset;
                shift(&mut entry.node, offset);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| shift(item, offset)),
        _ => {}
    }
}

fn syntax_message(parser: &str, typed: &str) -> String {
    if parser.contains("duplicate key") {
        format!("the key `{typed}` is given twice")
    } else {
        format!("not TOML: {parser}")
    }
}

/// Remedy for a line that is not TOML, guessed from common mistakes; `None` if the line has none of these mistakes.
fn syntax_help(line: &str) -> Option<String> {
    if line.trim_start().starts_with('#') {
        return None;
    }
    let (key, value) = line.split_once('=')?;
    let (key, value) = (key.trim(), value.split('#').next().unwrap_or("").trim());
    let mut digits = value.trim_start_matches(['-', '+']).splitn(2, ',');
    if let (Some(whole), Some(fraction)) = (digits.next(), digits.next())
        && !whole.is_empty()
        && whole.bytes().all(|b| b.is_ascii_digit())
        && fraction.starts_with(|c: char| c.is_ascii_digit())
    {
        return Some(format!("the decimal mark is a point: {key} = {}", value.replacen(',', ".", 1)));
    }
    let plain = !value.is_empty() && !value.contains(['"', '\'', '[', '{']);
    if plain && value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) && value.parse::<f64>().is_err() {
        return Some(format!("a quantity with a unit is a string: {key} = \"{value}\""));
    }
    if plain && value.starts_with(char::is_alphabetic) {
        return Some(format!("a word is a string: {key} = \"{value}\""));
    }
    None
}

fn convert_table(
    table: DeTable<'_>,
    span: Range<usize>,
    source: usize,
    sources: &Sources,
) -> Result<CaseNode, Diagnostic> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        let key_origin = Origin { source, span: key.span() };
        let key = key.into_inner().into_owned();
        entries.push(Entry { key, key_origin, node: convert(value, source, sources)? });
    }
    // the parser returns keys in alphabetical order
    entries.sort_by_key(|entry| entry.key_origin.span.start);
    Ok(CaseNode { value: Value::Table(entries), origin: Origin { source, span } })
}

fn convert(value: Spanned<DeValue<'_>>, source: usize, sources: &Sources) -> Result<CaseNode, Diagnostic> {
    let span = value.span();
    let origin = Origin { source, span: span.clone() };
    let value = match value.into_inner() {
        DeValue::String(text) => Value::String(text.into_owned()),
        DeValue::Integer(number) => {
            let digits = number.as_str();
            match i64::from_str_radix(digits, number.radix()) {
                Ok(whole) => Value::Integer(whole),
                Err(_) => Value::Float(digits.parse().unwrap_or(f64::INFINITY)),
            }
        }
        DeValue::Float(number) => Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(yes) => Value::Boolean(yes),
        DeValue::Datetime(_) => {
            let message = format!("`{}` is a date; no key of a case is one", sources.typed(&origin));
            return Err(sources.error(&origin, message).help("put quotes around it if it is a name"));
        }
        DeValue::Array(items) => {
            let nodes: Result<Vec<CaseNode>, Diagnostic> =
                items.into_iter().map(|item| convert(item, source, sources)).collect();
            Value::Array(nodes?)
        }
        DeValue::Table(table) => return convert_table(table, span, source, sources),
    };
    Ok(CaseNode { value, origin })
}
