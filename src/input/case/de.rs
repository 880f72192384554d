//! Reads the tree of a case into the types of [`super::file`] by means of serde, a library that converts data to Rust
//! types. The source position of each value is kept.
//!
//! For each type, serde makes code that knows the keys of the type. The deserializer in this file walks through the
//! tree and gives the values to that code. If a value does not fit its type, the error contains the source position of
//! the value. A field of type [`Located`](super::located::Located) receives the source position of a value that fits.

use super::diagnostic::Diagnostic;
use super::located::LOCATED;
use super::source::{Origin, Sources};
use super::tree::{CaseNode, Entry, Value, child_place};
use crate::legible::quote;
use serde::de::value::{StrDeserializer, U64Deserializer};
use serde::de::{
    self, Deserialize, DeserializeSeed, Deserializer, EnumAccess, Error as _, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, VariantAccess, Visitor,
};
use std::fmt;

/// Text that separates the message from the remedy in an error text of serde, which has only one text for both.
pub(in crate::case) const HELP_MARK: &str = "\u{1}help: ";

/// Reason why a value does not fit its type. The source position of the value is added while the error is passed on to
/// the caller.
#[derive(Clone, Debug)]
pub struct Error {
    // both fields are boxed to keep the results of all functions small, because every function passes errors on
    kind: Box<ReadErrorKind>,
    at: Option<Box<(Origin, String)>>,
}

#[derive(Clone, Debug)]
enum ReadErrorKind {
    UnknownKey { key: String, known: &'static [&'static str] },
    UnknownName { name: String, known: &'static [&'static str] },
    WrongType { found: String, expected: String },
    Other(String),
}

impl Error {
    fn new(kind: ReadErrorKind) -> Self {
        Self { kind: Box::new(kind), at: None }
    }

    /// Adds the source position and the key path of the value that was being read. An error that already has a
    /// position stays unchanged: its position is that of an inner value, and therefore more precise.
    fn at(mut self, origin: &Origin, path: &str) -> Self {
        self.at.get_or_insert_with(|| Box::new((origin.clone(), path.to_string())));
        self
    }

    /// Turns the error into a message that quotes the source text of the value.
    pub fn diagnostic(self, sources: &Sources) -> Diagnostic {
        let (origin, path) = self.at.map_or((Origin { source: 0, span: 0..0 }, String::new()), |at| *at);
        let typed = sources.typed(&origin);
        let value = if typed.is_empty() || typed.starts_with('[') { String::new() } else { format!(" = {typed}") };
        match *self.kind {
            ReadErrorKind::UnknownKey { key, known } => {
                let table = if path.is_empty() { "the case".to_string() } else { format!("`{path}`") };
                let diagnostic = sources.error(&origin, format!("unknown key `{}` in {table}", quote(&key)));
                diagnostic.help(suggestion(&key, known, "known keys"))
            }
            ReadErrorKind::UnknownName { name, known } => {
                let diagnostic = sources.error(&origin, format!("`{path}`: unknown name `{}`", quote(&name)));
                diagnostic.help(suggestion(&name, known, "known names"))
            }
            ReadErrorKind::WrongType { found, expected } => {
                let message = format!("`{path}`{value}: {found} where {expected} belongs");
                let takes_list = expected.contains("array") || expected.starts_with("a list");
                let quoted = with_quotes(&typed).filter(|_| takes_list && found == "a string");
                let form = quoted.map(|list| format!("; texts in it need quotes: --set '{path}={list}'"));
                let help = format!("`{path}` takes {expected}{}", form.unwrap_or_default());
                sources.error(&origin, message).help(help)
            }
            ReadErrorKind::Other(text) => {
                let (message, help) = match text.split_once(HELP_MARK) {
                    Some((message, help)) => (message, Some(help.to_string())),
                    None => (text.as_str(), None),
                };
                let diagnostic = sources.error(&origin, format!("`{path}`{value} {message}"));
                match help {
                    Some(help) => diagnostic.help(help),
                    None => diagnostic,
                }
            }
        }
    }
}

/// Adds quotes around each word of a list whose words were typed without quotes, such as `[x, y]` in an argument
/// `--set`. Such a list is read as one string. `None` for other texts, and for lists of lists or tables.
fn with_quotes(typed: &str) -> Option<String> {
    let inside = typed.strip_prefix('[')?.strip_suffix(']').filter(|inside| !inside.contains(['[', '{', '\'']))?;
    let parts = inside.split(',').map(str::trim).filter(|part| !part.is_empty());
    let is_whole = |part: &str| part.starts_with('"') || part.parse::<f64>().is_ok();
    let quoted = parts.map(|part| if is_whole(part) { part.to_owned() } else { format!("\"{part}\"") });
    Some(format!("[{}]", quoted.collect::<Vec<_>>().join(", ")))
}

/// Known name nearest to a misspelt name; `None` if all known names are too different.
pub fn nearest<'a, S: AsRef<str>>(name: &str, known: &'a [S]) -> Option<&'a str> {
    // very long names are not compared, because the edit distance takes time and memory in proportion to the product
    // of both lengths
    if known.iter().all(|known| name.len() > 2 * known.as_ref().len() + 8) {
        return None;
    }
    let all = known.iter().map(AsRef::as_ref);
    let distances = all.map(|known| (strsim::damerau_levenshtein(&name.to_lowercase(), known), known));
    distances.min().filter(|(distance, known)| *distance <= 1 + known.len() / 3).map(|(_, known)| known)
}

/// Text that lists all known names. If a known name is similar to `name`, the question "did you mean `x`?" comes before
/// the list. `what` is the heading of the list.
pub(super) fn suggestion<S: AsRef<str>>(name: &str, known: &[S], what: &str) -> String {
    let list = known.iter().map(|known| format!("`{}`", known.as_ref())).collect::<Vec<_>>().join(", ");
    match nearest(name, known) {
        Some(known) => format!("did you mean `{known}`? ({what}: {list})"),
        None => format!("{what}: {list}"),
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.kind)
    }
}

impl std::error::Error for Error {}

fn found(unexpected: &Unexpected) -> String {
    match unexpected {
        Unexpected::Bool(_) => "true or false".into(),
        Unexpected::Unsigned(_) | Unexpected::Signed(_) => "a whole number".into(),
        // whole numbers in TOML have 64 bits
        Unexpected::Float(number) if number.abs() >= i64::MAX as f64 => {
            format!("a number beyond {}, the largest whole number", i64::MAX)
        }
        Unexpected::Float(_) => "a number".into(),
        Unexpected::Str(_) => "a string".into(),
        Unexpected::Seq => "a list".into(),
        Unexpected::Map => "a table".into(),
        Unexpected::UnitVariant => "a bare name".into(),
        other => other.to_string(),
    }
}

impl de::Error for Error {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(ReadErrorKind::Other(message.to_string()))
    }

    fn invalid_type(unexpected: Unexpected, expected: &dyn de::Expected) -> Self {
        let expected = expected.to_string();
        // serde describes the table of a struct by the name of the struct
        let expected =
            if expected.starts_with("struct ") || expected.starts_with("enum ") || expected.contains("variant") {
                "a table".to_string()
            } else {
                match expected.as_str() {
                    "a sequence" => "a list".to_string(),
                    "i64" | "u64" => "a whole number".to_string(),
                    "a boolean" => "true or false".to_string(),
                    _ => expected,
                }
            };
        Self::new(ReadErrorKind::WrongType { found: found(&unexpected), expected })
    }

    fn invalid_value(unexpected: Unexpected, expected: &dyn de::Expected) -> Self {
        Self::invalid_type(unexpected, expected)
    }

    fn invalid_length(length: usize, expected: &dyn de::Expected) -> Self {
        let expected = expected.to_string().replace("an array of length", "a list of length");
        Self::new(ReadErrorKind::WrongType { found: format!("a list of length {length}"), expected })
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        Self::new(ReadErrorKind::UnknownName { name: variant.into(), known: expected })
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self::new(ReadErrorKind::UnknownKey { key: field.into(), known: expected })
    }
}

/// Reads the tree of a case into a value of type `T`, such as the type of a whole case.
///
/// # Errors
/// The first value that does not fit, with its source position.
pub fn read<'de, T: Deserialize<'de>>(root: &'de CaseNode) -> Result<T, Error> {
    T::deserialize(NodeDeserializer::new(root, String::new()))
}

/// Empty table. It stands for the parameters of a law that is typed by its name alone, as in `drag = "stokes"`.
static NO_ENTRIES: Value = Value::Table(Vec::new());

/// Value of a case to be read, with its source position and its key path. Code that depends on no type is in functions
/// that are not generic, because the compiler makes each generic function once for every type in a case file.
#[derive(Clone)]
struct NodeDeserializer<'de> {
    value: &'de Value,
    origin: &'de Origin,
    path: String,
}

impl<'de> NodeDeserializer<'de> {
    fn new(node: &'de CaseNode, path: String) -> Self {
        Self { value: &node.value, origin: &node.origin, path }
    }

    fn wrong_type(&self, expected: String) -> Error {
        Error::new(ReadErrorKind::WrongType { found: self.value.kind().into(), expected }).at(self.origin, &self.path)
    }

    /// Keys and values of this value, which must be a table.
    ///
    /// # Errors
    /// The value is not a table.
    fn table(&self) -> Result<TableAccess<'de, '_>, Error> {
        match self.value {
            Value::Table(entries) => Ok(TableAccess { entries: entries.iter(), value: None, path: &self.path }),
            _ => Err(self.wrong_type("a table".into())),
        }
    }

    /// Name of a law in the value, with the table of its parameters. `names` are the allowed names, for the message.
    ///
    /// # Errors
    /// The value is neither a name nor a table with exactly one key.
    fn name(&self, names: &[&str]) -> Result<NameAccess<'de, '_>, Error> {
        let path = &self.path;
        match self.value {
            Value::String(name) => Ok(NameAccess { name, origin: self.origin, content: None, path }),
            Value::Table(entries) => match entries.as_slice() {
                [Entry { key, key_origin, node }] => {
                    Ok(NameAccess { name: key, origin: key_origin, content: Some(node), path })
                }
                _ => {
                    let typed =
                        entries.iter().map(|entry| format!("`{}`", entry.key)).collect::<Vec<_>>().join(" and ");
                    let typed = if typed.is_empty() { "nothing".to_string() } else { typed };
                    let names = names.join("`, `");
                    let message = format_args!("names {typed}{HELP_MARK}choose exactly one of `{names}`");
                    Err(Error::custom(message).at(self.origin, path))
                }
            },
            _ => Err(self.wrong_type(format!("one of `{}`", names.join("`, `")))),
        }
    }
}

impl<'de> Deserializer<'de> for NodeDeserializer<'de> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let Self { value, origin, path } = self;
        let result = match value {
            Value::Table(entries) => {
                visitor.visit_map(TableAccess { entries: entries.iter(), value: None, path: &path })
            }
            Value::Array(items) => {
                let mut access = ListAccess { items, next: 0, path: &path };
                visitor.visit_seq(&mut access).and_then(|value| access.end().map(|()| value))
            }
            Value::String(text) => visitor.visit_borrowed_str(text),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Boolean(yes) => visitor.visit_bool(*yes),
        };
        result.map_err(|error| error.at(origin, &path))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_map(self.table()?).map_err(|error| error.at(self.origin, &self.path))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        match name {
            LOCATED => visitor.visit_seq(SameValue(self)),
            _ => Err(self.wrong_type(format!("`{name}`, which no case can hold,"))),
        }
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(PlaceAccess { place: self, field: 0 })
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_enum(self.name(names)?).map_err(|error| error.at(self.origin, &self.path))
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit seq tuple map
        identifier
    }
}

struct TableAccess<'de, 'p> {
    entries: std::slice::Iter<'de, Entry>,
    value: Option<&'de Entry>,
    path: &'p str,
}

impl<'de> MapAccess<'de> for TableAccess<'de, '_> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Error> {
        let Some(entry) = self.entries.next() else { return Ok(None) };
        self.value = Some(entry);
        let key: StrDeserializer<'_, Error> = entry.key.as_str().into_deserializer();
        seed.deserialize(key).map(Some).map_err(|error| error.at(&entry.key_origin, self.path))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Error> {
        let entry = self.value.take().ok_or_else(|| Error::custom("a value without a key"))?;
        seed.deserialize(NodeDeserializer::new(&entry.node, child_place(self.path, &entry.key)))
    }
}

struct ListAccess<'de, 'p> {
    items: &'de [CaseNode],
    next: usize,
    path: &'p str,
}

impl<'de> ListAccess<'de, '_> {
    fn next(&mut self) -> Option<NodeDeserializer<'de>> {
        let node = self.items.get(self.next)?;
        let path = format!("{}[{}]", self.path, self.next);
        self.next += 1;
        Some(NodeDeserializer::new(node, path))
    }

    /// Checks that all elements of the list have been read.
    ///
    /// # Errors
    /// The list has more elements than its type takes.
    fn end(&self) -> Result<(), Error> {
        let (read, all) = (self.next, self.items.len());
        if read == all {
            return Ok(());
        }
        let elements = if read == 1 { "element" } else { "elements" };
        Err(Error::new(ReadErrorKind::WrongType {
            found: format!("a list of {all} elements"),
            expected: format!("a list of {read} {elements}"),
        }))
    }
}

impl<'de> SeqAccess<'de> for &mut ListAccess<'de, '_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Error> {
        self.next().map(|element| seed.deserialize(element)).transpose()
    }
}

/// Sequence that yields the same value again and again. From this sequence serde reads a
/// [`Located`](super::located::Located): first the source position of the value, then the value.
struct SameValue<'de>(NodeDeserializer<'de>);

impl<'de> SeqAccess<'de> for SameValue<'de> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Error> {
        seed.deserialize(self.0.clone()).map(Some)
    }
}

/// Sequence of the four fields of a [`Place`](super::located::Place): source, start, end, path.
struct PlaceAccess<'de> {
    place: NodeDeserializer<'de>,
    field: usize,
}

impl<'de> SeqAccess<'de> for PlaceAccess<'de> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Error> {
        let NodeDeserializer { origin, path, .. } = &self.place;
        let number = |number: usize| U64Deserializer::<Error>::new(number as u64);
        self.field += 1;
        match self.field {
            1 => seed.deserialize(number(origin.source)),
            2 => seed.deserialize(number(origin.span.start)),
            3 => seed.deserialize(number(origin.span.end)),
            4 => seed.deserialize(path.as_str().into_deserializer()),
            _ => return Ok(None),
        }
        .map(Some)
    }
}

/// Name of a law, with or without a table of its parameters. From this pair serde reads an enum of laws.
struct NameAccess<'de, 'p> {
    name: &'de str,
    origin: &'de Origin,
    content: Option<&'de CaseNode>,
    path: &'p str,
}

impl<'de, 'p> EnumAccess<'de> for NameAccess<'de, 'p> {
    type Error = Error;
    type Variant = ContentAccess<'de>;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, ContentAccess<'de>), Error> {
        let name: StrDeserializer<'_, Error> = self.name.into_deserializer();
        let variant = seed.deserialize(name).map_err(|error| error.at(self.origin, self.path))?;
        let content = match self.content {
            Some(node) => NodeDeserializer::new(node, child_place(self.path, self.name)),
            None => NodeDeserializer { value: &NO_ENTRIES, origin: self.origin, path: self.path.to_owned() },
        };
        Ok((variant, ContentAccess { content, is_typed: self.content.is_some() }))
    }
}

/// Table of the parameters of a law. From this table serde reads the variant of the enum that stands for the law.
struct ContentAccess<'de> {
    content: NodeDeserializer<'de>,
    /// True if the case contains a table of parameters for the law, false if it contains the name of the law alone.
    is_typed: bool,
}

impl<'de> VariantAccess<'de> for ContentAccess<'de> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        let NodeDeserializer { origin, path, .. } = &self.content;
        if self.is_typed { Err(Error::custom("takes no table").at(origin, path)) } else { Ok(()) }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Error> {
        seed.deserialize(self.content)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Error> {
        self.content.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Error> {
        self.content.deserialize_struct("", &[], visitor)
    }
}
