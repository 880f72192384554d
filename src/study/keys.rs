//! `diptych keys`: prints every key of a case. The list is made from the types that read a case.

use crate::case::keys::{Key, KeyTable, schema, tables};
use crate::case::nearest;
use crate::cli::Keys;
use crate::runs::{StudyError, answer, answer_json};
use std::fmt::Write;

/// Text above the tables of the page of keys, in Markdown.
const INTRODUCTION: &str = "\
# Keys of a case

Made by `diptych keys --markdown` from the types that read a case; do not edit.

A case is one TOML file. A quantity is a string with its unit, such as `\"406 um\"`, `\"1.205 kg/m^3\"` or `\"-9.81 m/s^2\"`; units are m, g, s, N, Pa,
J, W, Hz and l with the prefixes p n u m c d k M G, and min, h, deg and %. A number without quotes is taken in the SI unit given below, with a
warning unless it is 0. The names of other files are relative to the file that names them.

Every table takes `use = \"NAME\"`, a named set of values; keys beside it win. `diptych cases` lists the sets that are built in. Any key can be
set from the command line, as in `--set soft.steps_per_contact=50` or `--set 'particles[0].diameter=300 um'`; lists count from 0.

An editor that knows JSON schemas completes and checks keys with the output of `diptych keys --schema`.
";

/// Prints the keys of a case, as text, as Markdown or as a JSON schema.
///
/// # Errors
/// Returns an error if the named table does not exist, or if the text cannot be written.
pub fn keys(args: &Keys) -> Result<(), StudyError> {
    if args.schema {
        return answer_json(&format!("{:#}\n", schema()));
    }
    let wanted = args.table.as_deref().map(|name| name.trim_matches(['[', ']']));
    let shown: Vec<&KeyTable> =
        tables().iter().filter(|table| wanted.is_none_or(|name| is_within(table, name))).collect();
    if let (true, Some(name)) = (shown.is_empty(), wanted) {
        let names: Vec<&str> = tables().iter().map(|table| table.name.as_str()).collect();
        let help = nearest(name, &names).map(|name| format!("did you mean `{name}`? ")).unwrap_or_default();
        let list = names.join(", ");
        return Err(StudyError::Input(format!("error: there is no table `{name}`\nhelp: {help}tables: {list}")));
    }
    answer(&if args.markdown { page(&shown) } else { shown.iter().map(|table| text(table)).collect() })
}

/// True if `table` has the name `name`, or lies within the table with this name.
fn is_within(table: &KeyTable, name: &str) -> bool {
    table.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Page of all keys in Markdown, which is stored as `docs/keys.md`.
pub fn markdown() -> String {
    page(&tables().iter().collect::<Vec<_>>())
}

/// One table of a case as lines for a terminal: each key with its properties and its meaning.
fn text(table: &KeyTable) -> String {
    let mut text = format!("{}{}\n  {}\n", table.heading(), required(table.required.as_ref()), table.about);
    for key in &table.keys {
        let _ = writeln!(text, "\n  {}: {}", key.name, facts(key).join("; "));
        let _ = writeln!(text, "    {}", key.about);
        for (name, about) in &key.choices {
            let _ = writeln!(text, "    \"{name}\": {about}");
        }
        if let Some(example) = &key.example {
            let _ = writeln!(text, "    {} = {example}", key.name);
        }
    }
    text + "\n"
}

/// Remark in brackets that a table is required under the condition `when`; empty if `when` is `None`.
fn required(when: Option<&String>) -> String {
    when.map_or(String::new(), |when| format!(" (required {when})").replace(" always", ""))
}

/// Type, unit, range, condition and default of a key, each in a few words.
fn facts(key: &Key) -> Vec<String> {
    let kind = match &key.unit {
        Some(unit) => format!("{} [{unit}]", key.kind),
        None => key.kind.clone(),
    };
    let mut facts = vec![kind];
    facts.extend(key.range.clone());
    facts.extend(key.required.as_ref().map(|when| format!("required {when}").replace(" always", "")));
    facts.extend(key.default.as_ref().map(|default| format!("default {default}")));
    facts
}

fn page(tables: &[&KeyTable]) -> String {
    let mut page = String::from(INTRODUCTION);
    for table in tables {
        let _ = writeln!(page, "\n## `{}`{}\n\n{}", table.heading(), required(table.required.as_ref()), table.about);
        if table.keys.is_empty() {
            continue;
        }
        page.push_str("\n| key | type | unit | default | range | example | meaning |\n|---|---|---|---|---|---|---|\n");
        table.keys.iter().for_each(|key| page += &row(key));
    }
    page
}

/// Row for one key in a Markdown table of keys.
fn row(key: &Key) -> String {
    let code = |text: &Option<String>| text.as_ref().map_or(String::new(), |text| format!("`{text}`"));
    // a default in words is written as text; a default that a user could type is written as code, in backquotes
    let default = match (&key.required, &key.default) {
        (Some(when), _) => format!("required {when}").replace(" always", ""),
        (None, Some(default)) if !default.starts_with(['"', '[']) && default.contains([' ', '`']) => default.clone(),
        (None, default) => code(default),
    };
    let choices = key.choices.iter().map(|(name, about)| format!(" `\"{name}\"`: {about}")).collect::<String>();
    let cells = [
        format!("`{}`", key.name),
        key.kind.clone(),
        key.unit.clone().unwrap_or_default(),
        default,
        key.range.clone().unwrap_or_default(),
        code(&key.example),
        format!("{}{choices}", key.about),
    ];
    format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | "))
}
