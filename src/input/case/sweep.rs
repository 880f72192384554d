//! Keys that a sweep varies, given by `[[sweep]]` in a case or by `--sweep key=a,b,c`. A variant is the case with one
//! collision model and some settings.

use super::diagnostic::Diagnostic;
use super::source::{Source, SourceKind, Sources};
use super::tree::{self, CaseNode, KeyPart, Value};
use super::{Case, Checked, Setting, keys, quantity, value_of};
use std::path::PathBuf;

/// Key that a sweep varies, with its values in order.
pub struct SweepAxis {
    /// Full path of the key, such as `contact.restitution`.
    pub key: String,
    /// SI unit of the values of the key; `None` if the key has no unit.
    pub unit: Option<String>,
    /// Values of the key as the user typed them.
    pub typed: Vec<String>,
    /// Values as numbers in the SI unit of the key; `None` if any value is not a number.
    pub numbers: Option<Vec<f64>>,
    settings: Vec<Setting>,
}

impl SweepAxis {
    /// Last part of the key, used as its name in sentences: `restitution` for `contact.restitution`.
    pub fn name(&self) -> &str {
        self.key.rsplit('.').next().unwrap_or(&self.key)
    }

    fn new(key: String, settings: Vec<Setting>, sources: &Sources) -> Self {
        let unit = settings.first().and_then(|setting| unit(&setting.path));
        let typed = settings.iter().map(|setting| sources.typed(&setting.value.origin).trim_matches('"').to_owned());
        let numbers = settings.iter().map(|setting| number(&setting.value));
        Self { unit, typed: typed.collect(), numbers: numbers.collect(), key, settings }
    }
}

/// SI unit of the key at a path; `None` if the key has no unit or does not exist.
fn unit(path: &[KeyPart]) -> Option<String> {
    let step = |schema, segment: &KeyPart| match segment {
        KeyPart::Key(key) if segment.index().is_none() => keys::inner(schema, Some(key)),
        KeyPart::Key(_) | KeyPart::Index(_) => keys::inner(schema, None),
    };
    path.iter().try_fold(keys::root(), step).and_then(keys::unit).map(str::to_owned)
}

/// [SI] value of a number, with or without a unit; `None` for other values.
fn number(value: &CaseNode) -> Option<f64> {
    match &value.value {
        Value::Integer(number) => Some(*number as f64),
        Value::Float(number) => Some(*number),
        Value::String(text) => quantity::value(text),
        Value::Table(_) | Value::Array(_) | Value::Boolean(_) => None,
    }
}

impl Case {
    /// Keys that a sweep varies: first those of the case, then those of `arguments` (each `key=a,b,c`). For a key in
    /// both, the values in `arguments` replace those of the case.
    ///
    /// # Errors
    /// No key is varied, a key occurs twice, a value is empty, or an argument is not such a list.
    pub fn axes(&mut self, arguments: &[String]) -> Result<Vec<SweepAxis>, Diagnostic> {
        let mut axes = self.own_axes()?;
        let mut named: Vec<SweepAxis> = Vec::new();
        for text in arguments {
            let axis = argument(text, &mut self.sources)?;
            if named.iter().any(|other| other.key == axis.key) {
                let message = format!("two --sweep name `{}`", axis.key);
                return Err(Diagnostic::about(format!("--sweep {text}"), message).help("put all values into one"));
            }
            axes.retain(|other| other.key != axis.key);
            named.push(axis);
        }
        axes.extend(named);
        if axes.is_empty() {
            let message = "there is nothing to sweep: the case has no [[sweep]], and no --sweep is given";
            let help = "such as --sweep \"soft.linear_spring_dashpot.stiffness=300 N/m,1000 N/m,3000 N/m\"";
            return Err(Diagnostic::about(self.path.display().to_string(), message).help(help));
        }
        Ok(axes)
    }

    /// Keys that the `[[sweep]]` list of the case varies, with their values.
    ///
    /// # Errors
    /// An entry has no key or no values, or a key occurs twice.
    pub fn own_axes(&self) -> Result<Vec<SweepAxis>, Diagnostic> {
        let whole = self.merged(self.tree.clone(), &self.sets.iter().collect::<Vec<_>>())?;
        let items = match whole.tree.get("sweep").map(|node| &node.value) {
            Some(Value::Array(items)) => items.as_slice(),
            _ => &[],
        };
        let mut axes: Vec<SweepAxis> = Vec::new();
        for (typed, item) in whole.file.sweep.iter().flatten().zip(items) {
            let fault = |message: &str| {
                let help = "key = \"contact.restitution\" and values = [0.9, 0.95], for example";
                whole.sources.error(&typed.origin, format!("`{}` {message}", typed.path)).help(help)
            };
            let key = typed.value.key.as_ref().ok_or_else(|| fault("names no `key`"))?;
            let values = match item.get("values").map(|values| &values.value) {
                Some(Value::Array(values)) if !values.is_empty() => values,
                _ => return Err(fault("has no `values`")),
            };
            if axes.iter().any(|axis| axis.key == key.value) {
                return Err(fault("names a key that another [[sweep]] has"));
            }
            let path = tree::parse_path(&key.value).map_err(|why| whole.sources.error(&key.origin, why))?;
            let setting =
                |value: &CaseNode| Setting { path: path.clone(), value: value.clone(), key_origin: key.origin.clone() };
            axes.push(SweepAxis::new(key.value.clone(), values.iter().map(setting).collect(), &whole.sources));
        }
        Ok(axes)
    }

    /// Makes the experiments of all variants of the case at one point of a sweep. `at` contains, for each of `axes`
    /// (keys of the sweep), the index of the value. If `seed` is given, it replaces that of the case.
    ///
    /// # Errors
    /// Errors of [`variants`](Self::variants).
    pub fn point(&self, axes: &[SweepAxis], at: &[usize], seed: Option<u64>) -> Result<Vec<Checked>, Diagnostic> {
        let point = axes.iter().zip(at).filter_map(|(axis, &value)| axis.settings.get(value));
        self.variants_with(&self.sets.iter().chain(point).collect::<Vec<_>>(), seed)
    }
}

/// Reads an argument of the form `key=a,b,c` into a key and its values, and adds its text to `sources`.
fn argument(text: &str, sources: &mut Sources) -> Result<SweepAxis, Diagnostic> {
    let name = format!("--sweep {text}");
    let source = sources.add(Source { name, folder: PathBuf::new(), text: text.into(), kind: SourceKind::Argument });
    let (path, key_origin, start) = super::key_of(text, source, sources)?;
    let mut settings = Vec::new();
    for (place, part) in split(&text[start..]) {
        if part.trim().is_empty() {
            let help = "values stand between commas, as in contact.restitution=0.9,0.95";
            return Err(sources.error(&key_origin, format!("`{text}` has an empty value")).help(help));
        }
        let value = value_of(part, start + place, source, sources)?;
        settings.push(Setting { path: path.clone(), value, key_origin: key_origin.clone() });
    }
    Ok(SweepAxis::new(text[..start - 1].trim().to_owned(), settings, sources))
}

/// Parts of a text between commas, each with its byte position in the text. A comma inside brackets or quotes does not
/// end a part.
fn split(text: &str) -> Vec<(usize, &str)> {
    let (mut parts, mut begin, mut depth, mut quote) = (Vec::new(), 0, 0, None);
    for (place, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            (None, ',') if depth <= 0 => {
                parts.push((begin, &text[begin..place]));
                begin = place + 1;
            }
            (None, _) => {}
        }
    }
    parts.push((begin, &text[begin..]));
    parts
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn commas_in_brackets_and_quotes_divide_nothing() {
        for (text, parts) in [
            ("1,2", &["1", "2"][..]),
            ("300 N/m, 1 kN/m", &["300 N/m", " 1 kN/m"]),
            ("[0, 0, 1],[0, 0, 2]", &["[0, 0, 1]", "[0, 0, 2]"]),
            ("\"a,b\",'c,'", &["\"a,b\"", "'c,'"]),
            ("{ x = [1, 2] }", &["{ x = [1, 2] }"]),
            ("1,,", &["1", "", ""]),
            ("", &[""]),
        ] {
            let found: Vec<&str> = split(text).into_iter().map(|(_, part)| part).collect();
            assert_eq!(found, parts, "{text}");
        }
    }
}
