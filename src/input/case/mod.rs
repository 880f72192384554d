//! Reads a case from a TOML file, the sets of values that this file names by `use`, and the command line, and makes
//! checked experiments in SI.
//!
//! ```text
//!  text --tree--> CaseNode --overlay: use, set, --set--> CaseNode --de--> CaseFile --resolve--> Experiment
//! ```
//!
//! Every value keeps its source position through all steps, so that each message contains file and line. A variant is
//! the case with one collision model and some settings. A new key requires a field in [`mod@file`], and a check in the
//! corresponding file of `resolve/`.

mod against;
mod bare;
pub mod built_in;
pub mod de;
mod describe;
mod diagnostic;
pub mod file;
mod fluctuation;
mod given;
pub mod keys;
pub mod located;
mod merge;
mod models;
mod parameters;
pub mod quantity;
mod resolve;
mod rules;
pub mod saved;
mod schema;
mod source;
mod sweep;
mod time_or_word;
pub mod tree;
mod written;

pub use describe::{describe, describe_variants};
pub use diagnostic::{Diagnostic, Severity, SourceLocation};
pub use parameters::parameters;
pub use resolve::{FramesAndWarnings, ParticleFrame, particle_frames};
pub use source::{Origin, Source, SourceKind, Sources};
pub use sweep::SweepAxis;
pub use written::Variant;

use crate::experiment::{Experiment, Model, Trajectories};
use crate::legible::quote;
use crate::schedule::align;
use against::AgainstFile;
use bare::bare_numbers;
use built_in::BuiltIn;
pub use de::nearest;
use file::CaseFile;
use models::Library;
pub use resolve::read_text;
use resolve::{VariantChoice, model_name, resolve};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tree::{CaseNode, KeyPart, Value};

/// Experiment made from a case, with the warnings about the case.
pub type Checked = (Experiment, Vec<Diagnostic>);

/// Case that has been read, with the changes of the command line. Only the syntax of the case has been checked.
pub struct Case {
    /// Path of the case as the user typed it.
    pub path: PathBuf,
    /// Title: first paragraph of the comment at the beginning of the file, or the name of a file without such a
    /// comment. The changes of the command line follow.
    pub title: String,
    /// Whole comment at the beginning of the file, without `#`.
    pub heading: String,
    /// Text of the case file.
    pub text: Arc<str>,
    sources: Sources,
    tree: CaseNode,
    sets: Vec<Setting>,
    library: Library,
}

/// Change of one key of a case. It comes from `--set key=value`, from the `set` of a variant, or from a value of a
/// sweep.
struct Setting {
    path: Vec<KeyPart>,
    value: CaseNode,
    key_origin: Origin,
}

impl Case {
    /// Reads a case file, or the built-in case with this name if there is no such file. `sets` are arguments of the
    /// form `key=value`. A later argument replaces an earlier one.
    ///
    /// # Errors
    /// The file cannot be read or is not TOML, or an argument is not `key=value`.
    pub fn read(path: &Path, sets: &[String]) -> Result<Self, Diagnostic> {
        let name = path.to_string_lossy();
        match built_in::case(&name) {
            Some(case) if !path.is_file() => Self::built_in(&case, sets),
            _ => Self::from_text(path, read_text(path).map_err(|why| unreadable(&name, &why))?, sets),
        }
    }

    /// Reads a built-in case. The sets of values and the data files that the case uses are built-in ones too, and
    /// independent of the current folder.
    ///
    /// # Errors
    /// An argument is not `key=value`.
    pub fn built_in(case: &BuiltIn, sets: &[String]) -> Result<Self, Diagnostic> {
        Self::of_kind(SourceKind::BuiltIn, &case.path, Arc::from(case.text), sets)
    }

    /// Reads a case from a text in memory. `path` is used in messages, and to find the files that the case names.
    ///
    /// # Errors
    /// The text is not TOML, or an argument is not `key=value`.
    pub fn from_text(path: &Path, text: Arc<str>, sets: &[String]) -> Result<Self, Diagnostic> {
        Self::of_kind(SourceKind::File, path, text, sets)
    }

    fn of_kind(kind: SourceKind, path: &Path, text: Arc<str>, sets: &[String]) -> Result<Self, Diagnostic> {
        let mut sources = Sources::default();
        let source = sources.add_text(path, text.clone(), kind);
        let tree = tree::parse(&text, source, &sources)?;
        let sets: Vec<Setting> = sets.iter().map(|set| argument(set, &mut sources)).collect::<Result<_, _>>()?;
        if sets.is_empty() && matches!(&tree.value, Value::Table(entries) if entries.is_empty()) {
            let message = format!("the case `{}` is empty", path.display());
            return Err(Diagnostic::about(path.display().to_string(), message)
                .help("it needs at least [domain], [[particles]], [contact] and [run]; `cases/quick.toml` is one"));
        }
        // the title describes the file alone, so the changes by the command line are added to it
        let typed: Vec<&str> = sources.set_arguments().collect();
        let changes = if typed.is_empty() { String::new() } else { format!(" [with {}]", typed.join(", ")) };
        let heading = heading(&text);
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let title =
            heading.split("\n\n").next().map(|first| first.replace('\n', " ")).filter(|title| !title.is_empty());
        Ok(Self {
            path: path.to_path_buf(),
            title: title.unwrap_or(stem) + &changes,
            heading,
            text,
            sources,
            tree,
            sets,
            library: if kind == SourceKind::BuiltIn { Library::built_in() } else { Library::beside(path) },
        })
    }

    /// Makes the experiment of the command `run`. If `model` and `seed` are given, they replace those of the case.
    ///
    /// # Errors
    /// The first error of the case, or all keys that are missing.
    pub fn experiment(&self, model: Option<Model>, seed: Option<u64>) -> Result<Checked, Diagnostic> {
        self.merged(self.tree.clone(), &self.sets.iter().collect::<Vec<_>>())?.resolve(&VariantChoice {
            model,
            seed,
            ..VariantChoice::default()
        })
    }

    /// Makes the experiment of the command `run` with the changes `more`, each of the form `key=value`, in addition to
    /// those of the command line. Without a `model` or a `seed`, those of the case are used. Studies use this function
    /// to vary a case.
    ///
    /// # Errors
    /// Errors of [`experiment`](Self::experiment).
    pub fn changed(&self, more: &[String], model: Option<Model>, seed: Option<u64>) -> Result<Checked, Diagnostic> {
        let mut sources = self.sources.clone();
        let more: Vec<Setting> = more.iter().map(|set| argument(set, &mut sources)).collect::<Result<_, _>>()?;
        let changes: Vec<&Setting> = self.sets.iter().chain(&more).collect();
        let choice = VariantChoice { model, seed, ..VariantChoice::default() };
        self.merged_with(sources, self.tree.clone(), &changes)?.resolve(&choice)
    }

    /// Makes the experiments of the command `compare`: those of the `[[compare]]` list or, without a list, one with
    /// soft and one with hard spheres. If `seed` is given, it replaces that of the case.
    ///
    /// # Errors
    /// Errors of [`experiment`](Self::experiment), for any variant. Also an error if two variants have the same name.
    pub fn variants(&self, seed: Option<u64>) -> Result<Vec<Checked>, Diagnostic> {
        self.variants_with(&self.sets.iter().collect::<Vec<_>>(), seed)
    }

    /// Makes the experiments of the command `compare`, with the changes `sets` in place of those of the command line.
    fn variants_with(&self, sets: &[&Setting], seed: Option<u64>) -> Result<Vec<Checked>, Diagnostic> {
        let whole = self.merged(self.tree.clone(), sets)?;
        let Some(list) = whole.file.compare.as_ref().filter(|list| !list.is_empty()) else {
            let choice = |model| VariantChoice { model: Some(model), seed, ..VariantChoice::default() };
            return [Model::Soft, Model::Hard].map(choice).iter().map(|choice| whole.resolve(choice)).collect();
        };
        let items = match whole.tree.get("compare").map(|node| &node.value) {
            Some(Value::Array(items)) => items.as_slice(),
            _ => &[],
        };
        // variants are made from the case without its `[[compare]]` list: with the list, each variant would read it
        // again
        let mut case = self.tree.clone();
        case.remove("compare");
        let of_the_case = |setting: &&Setting| setting.path.first().is_none_or(|first| !first.is_key("compare"));
        let mut names = HashSet::new();
        let mut variants = Vec::new();
        for (variant, item) in list.iter().zip(items) {
            let settings = settings(item.get("set"), &whole.sources)?;
            let output = |own: &&Setting| own.path.first().is_some_and(|first| first.is_key("output"));
            if let Some(own) = settings.iter().find(output) {
                let error = whole.sources.error(&own.key_origin, "`output` is the same for all variants");
                return Err(error.help("give it in the case itself, or on the command line"));
            }
            let settings: Vec<&Setting> = settings.iter().chain(sets.iter().copied()).filter(of_the_case).collect();
            let merged = self.merged(case.clone(), &settings)?;
            let model = variant.value.model.as_ref().map(|model| model.value);
            let typed = variant.value.name.as_ref();
            let against = variant.value.against.clone();
            let choice = VariantChoice { model, seed, name: typed.map(|name| name.value.clone()), against };
            let (experiment, warnings) = merged.resolve(&choice)?;
            if !names.insert(experiment.name.clone()) {
                let origin = typed.map_or(&variant.origin, |name| &name.origin);
                let message = format!("two variants are called \"{}\"", experiment.name);
                return Err(self.sources.error(origin, message).help("give each [[compare]] its own `name`"));
            }
            variants.push((experiment, warnings));
        }
        for against in list.iter().filter_map(|variant| variant.value.against.as_ref()) {
            if let AgainstFile::Variant(name) = &against.value {
                self.check_reference((name, &against.origin), &variants)?;
            }
        }
        align(&mut variants.iter_mut().map(|(experiment, _)| experiment).collect::<Vec<_>>());
        Ok(variants)
    }

    /// Settings of the trajectory files, common to all variants; `None` if no trajectories are written.
    ///
    /// # Errors
    /// Errors of [`experiment`](Self::experiment) that concern the table `[output]`.
    pub fn trajectories(&self) -> Result<Option<Trajectories>, Diagnostic> {
        let merged = self.merged(self.tree.clone(), &self.sets.iter().collect::<Vec<_>>())?;
        resolve::trajectories(&merged.file, merged.sources)
    }

    /// Keys that each variant sets in addition to its model, as typed in the case. The order is that of
    /// [`variants`](Self::variants). The text is empty for a variant that sets no key. The list is empty without a
    /// `[[compare]]` list.
    pub fn overrides(&self) -> Vec<String> {
        let Some(Value::Array(items)) = self.tree.get("compare").map(|node| &node.value) else { return Vec::new() };
        let typed = |entry: &tree::Entry| format!("{} = {}", entry.key, self.sources.typed(&entry.node.origin));
        let one = |item: &CaseNode| match item.get("set").map(|set| &set.value) {
            Some(Value::Table(entries)) => entries.iter().map(typed).collect::<Vec<_>>().join(", "),
            _ => String::new(),
        };
        items.iter().map(one).collect()
    }

    /// True if the case has a `[[compare]]` list. Without such a list, `compare` runs a soft and a hard variant.
    pub fn names_variants(&self) -> bool {
        matches!(self.tree.get("compare").map(|node| &node.value), Some(Value::Array(items)) if !items.is_empty())
    }

    /// Checks that the reference of a variant (the variant `name`, with which it is compared) exists and is not itself
    /// compared with another variant.
    fn check_reference(&self, (name, origin): (&str, &Origin), variants: &[Checked]) -> Result<(), Diagnostic> {
        let error = |message: String, help: String| Err(self.sources.error(origin, message).help(help));
        match variants.iter().find(|(experiment, _)| experiment.name == name) {
            None => {
                let names: Vec<_> = variants.iter().map(|(experiment, _)| format!("\"{}\"", experiment.name)).collect();
                error(format!("no variant is called \"{name}\""), format!("there are {}", names.join(", ")))
            }
            Some((experiment, _)) if experiment.against.is_some() => {
                let help = "name a [[compare]] that has no `against` of its own".to_owned();
                error(format!("\"{name}\" is itself compared with another variant"), help)
            }
            Some(_) => Ok(()),
        }
    }

    /// All parameters of an experiment in SI, for `summary.json`.
    pub fn parameters(&self, experiment: &Experiment) -> serde_json::Value {
        parameters(experiment)
    }

    /// Applies changes to the tree of a case, and then inserts the sets of values that the case names with `use`.
    fn merged(&self, tree: CaseNode, changes: &[&Setting]) -> Result<Merged, Diagnostic> {
        self.merged_with(self.sources.clone(), tree, changes)
    }

    /// Applies changes to the tree of a case, and then inserts the sets of values that the case names with `use`.
    /// `sources` contains the texts of the changes.
    fn merged_with(
        &self,
        mut sources: Sources,
        mut tree: CaseNode,
        changes: &[&Setting],
    ) -> Result<Merged, Diagnostic> {
        for setting in changes {
            tree.set(&setting.path, setting.value.clone(), &setting.key_origin).map_err(|why| {
                let help = "keys of a set that the case uses can be given whole, but not element by element";
                sources.error(&setting.key_origin, why).help(help)
            })?;
        }
        self.library.expand(&mut tree, &mut sources)?;
        let file = de::read(&tree).map_err(|error| error.diagnostic(&sources))?;
        Ok(Merged { tree, file, sources })
    }
}

/// Case after all changes: as a tree of values, as a [`CaseFile`], and its source texts.
struct Merged {
    tree: CaseNode,
    file: CaseFile,
    sources: Sources,
}

impl Merged {
    /// Makes the experiment of one variant, with all warnings. `choice` contains the model, seed, name and reference of
    /// the variant.
    fn resolve(&self, choice: &VariantChoice) -> Result<Checked, Diagnostic> {
        rules::refuse_conflicts(&self.tree, &self.sources)?;
        let (experiment, warnings) = resolve((&self.file, &self.tree), choice, self.sources.clone())?;
        Ok((experiment, bare_numbers(&self.tree, &self.sources).into_iter().chain(warnings).collect()))
    }
}

/// Error for a case that cannot be read. If the name is similar to that of a built-in case, the remedy contains this
/// name.
fn unreadable(name: &str, why: &str) -> Diagnostic {
    let known: Vec<String> = built_in::cases().into_iter().map(|case| case.name).collect();
    let stem = name.trim_end_matches(".toml");
    let help = match built_in::case(stem.trim_start_matches("cases/")) {
        Some(case) => format!("`{}` without `.toml` is the built-in case of that name", case.name),
        None => match nearest(stem, &known) {
            Some(known) => format!("did you mean the built-in case `{known}`? `diptych cases` lists them"),
            None => "a case is a TOML file, or the name of one that `diptych cases` lists".into(),
        },
    };
    Diagnostic::about(name, format!("the case `{name}` cannot be read: {why}")).help(help)
}

/// Reads an argument of the form `key=value` into a change of one key, and adds its text to `sources`.
fn argument(text: &str, sources: &mut Sources) -> Result<Setting, Diagnostic> {
    let name = format!("--set {text}");
    let source = sources.add(Source { name, folder: PathBuf::new(), text: text.into(), kind: SourceKind::Argument });
    let (path, key_origin, start) = key_of(text, source, sources)?;
    let value = value_of(&text[start..], start, source, sources)?;
    Ok(Setting { path, value, key_origin })
}

/// Key of an argument `key=value`, its source position, and the position at which the value begins.
fn key_of(text: &str, source: usize, sources: &Sources) -> Result<(Vec<KeyPart>, Origin, usize), Diagnostic> {
    let help = "such as --set particles[0].count=100 or --set \"run.duration=2 s\"";
    let end = text.find('=').unwrap_or(text.len());
    let origin = Origin { source, span: 0..end };
    if end == text.len() {
        return Err(sources.error(&origin, format!("`{}` is not key=value", quote(text))).help(help));
    }
    let path = tree::parse_path(&text[..end]).map_err(|why| sources.error(&origin, why).help(help))?;
    Ok((path, origin, end + 1))
}

/// Reads the value of an argument from the byte position `start` on. A text that is not a TOML value is read as a
/// string.
fn value_of(text: &str, start: usize, source: usize, sources: &Sources) -> Result<CaseNode, Diagnostic> {
    let start = start + text.len() - text.trim_start().len();
    let text = text.trim();
    match tree::parse_value(text, start, source, sources) {
        Some(value) => value,
        None => Ok(CaseNode {
            value: Value::String(text.to_string()),
            origin: Origin { source, span: start..start + text.len() },
        }),
    }
}

/// Reads the table `set` of a variant into a list of changes. The list is empty without such a table.
fn settings(set: Option<&CaseNode>, sources: &Sources) -> Result<Vec<Setting>, Diagnostic> {
    let Some(set) = set else { return Ok(Vec::new()) };
    let Value::Table(entries) = &set.value else {
        let message = format!("`set` is {}, a table belongs here", set.value.kind());
        return Err(sources.error(&set.origin, message).help("set = { \"contact.restitution\" = 0.9 }"));
    };
    entries
        .iter()
        .map(|entry| {
            let path = tree::parse_path(&entry.key).map_err(|why| sources.error(&entry.key_origin, why))?;
            Ok(Setting { path, value: entry.node.clone(), key_origin: entry.key_origin.clone() })
        })
        .collect()
}

/// Comment lines at the beginning of the text of a case, without `#`.
fn heading(text: &str) -> String {
    let lines: Vec<&str> = text
        .lines()
        .map_while(|line| line.trim_start().strip_prefix('#'))
        .map(|line| line.strip_prefix(' ').unwrap_or(line).trim_end())
        .collect();
    lines.join("\n").trim().to_string()
}

/// Hash of all data that determine the results of a run: the experiment and the version of the program. Names of
/// variants, their references (variants or tables with which they are compared) and the settings of unused models are
/// left out. Runs with equal hashes must give equal results.
///
/// # Errors
/// The experiment cannot be written as JSON, which would be an error of the program.
pub fn fingerprint(experiment: &Experiment) -> Result<String, serde_json::Error> {
    let mut json = serde_json::to_value(experiment)?;
    let others: &[&str] = match experiment.model() {
        Model::Soft => &["hard", "hybrid", "dsmc"],
        Model::Hard => &["soft", "hybrid", "dsmc"],
        Model::Hybrid => &["hard", "dsmc"],
        Model::Dsmc => &["soft", "hard", "hybrid"],
    };
    if let Some(table) = json.as_object_mut() {
        table.retain(|key, _| !["name", "against"].iter().chain(others).any(|other| other == key));
    }
    Ok(format!("{:016x}", saved::checksum(&format!("{} {json}", env!("CARGO_PKG_VERSION")))))
}

/// Name of a collision model in messages, such as `soft`.
pub fn name_of(model: Model) -> &'static str {
    model_name(model)
}
