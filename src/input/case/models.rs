//! Sets of values: parts of cases in `models/`, each with a name and a citation. A case includes a set by
//! `use = "particles/polystyrene-406um"`.

use super::built_in;
use super::de::suggestion;
use super::diagnostic::Diagnostic;
use super::resolve::{leads_out, read_text};
use super::source::{Origin, SourceKind, Sources};
use super::tree::{self, CaseNode, Value, child_place};
use crate::legible::quote;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Largest number of nested `use`: a set of values may use further sets.
const DEEPEST: usize = 8;

/// Folders in which sets of values (parts of cases) are searched for: `models/` in the folder of the case and in each
/// folder above it, then `models/` in the current folder. Built-in sets are searched last.
pub struct Library {
    folders: Vec<PathBuf>,
}

impl Library {
    /// Makes the search path for the sets of values that a case file uses.
    pub fn beside(case: &Path) -> Self {
        let folder = case.parent().unwrap_or(Path::new(""));
        let mut folders: Vec<PathBuf> = folder.ancestors().map(|ancestor| ancestor.join("models")).collect();
        if let Ok(absolute) = std::path::absolute(folder) {
            folders.extend(absolute.ancestors().map(|ancestor| ancestor.join("models")));
        }
        folders.push(PathBuf::from("models"));
        folders.retain(|folder| folder.is_dir());
        Self { folders }
    }

    /// Makes a search path without folders, so that only the built-in sets of values are found.
    pub fn built_in() -> Self {
        Self { folders: Vec::new() }
    }

    /// Replaces every `use` in the tree, except in the list `[[compare]]`, by the values of the named set. Keys in the
    /// same table as `use` replace those of the set.
    ///
    /// # Errors
    /// A set that does not exist or cannot be read, with the source position of its `use`.
    pub fn expand(&self, node: &mut CaseNode, sources: &mut Sources) -> Result<(), Diagnostic> {
        self.expand_at(node, "", 0, sources)
    }

    fn expand_at(
        &self,
        node: &mut CaseNode,
        place: &str,
        depth: usize,
        sources: &mut Sources,
    ) -> Result<(), Diagnostic> {
        if let Some(used) = node.remove("use") {
            let mut set = self.load(&used.node, sources)?;
            if depth >= DEEPEST {
                let message = "sets use one another in a circle, or too deep";
                return Err(sources.error(&used.node.origin, message).help("at most eight levels of `use`"));
            }
            // the key `source` is a citation, which is only for human readers
            set.remove("source");
            self.expand_at(&mut set, place, depth + 1, sources)?;
            let own = std::mem::replace(node, set);
            // the node keeps the source position of the table that uses the set
            node.origin = own.origin.clone();
            node.overlay(own, place);
        }
        match &mut node.value {
            Value::Table(entries) => {
                // the list `[[compare]]` is left out, because the changes of a variant must be applied to the case
                // before its sets are read
                for entry in entries.iter_mut().filter(|entry| !(place.is_empty() && entry.key == "compare")) {
                    self.expand_at(&mut entry.node, &child_place(place, &entry.key), depth, sources)?;
                }
            }
            Value::Array(items) => {
                let place = format!("{place}[]");
                for item in items {
                    self.expand_at(item, &place, depth, sources)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn load(&self, used: &CaseNode, sources: &mut Sources) -> Result<CaseNode, Diagnostic> {
        let Value::String(name) = &used.value else {
            let message = format!("`use` = {} is {}", sources.typed(&used.origin), used.value.kind());
            return Err(sources.error(&used.origin, message).help("name a set of models/: use = \"fluids/air\""));
        };
        let relative = Path::new(name);
        if name.is_empty() || relative.components().any(|part| !matches!(part, Component::Normal(_))) {
            let message = format!("`use` = \"{}\" is no name of a set in models/", quote(name));
            return Err(sources.error(&used.origin, message).help("such as \"fluids/air\", without `.toml`"));
        }
        let found = self.folders.iter().map(|folder| folder.join(format!("{name}.toml"))).find(|path| path.is_file());
        let (path, text, kind) = match (found, built_in::set(name)) {
            (Some(path), _) => {
                // root is the folder that contains `models/`
                let root =
                    self.folders.iter().find(|folder| path.starts_with(folder)).and_then(|folder| folder.parent());
                if root.is_some_and(|root| leads_out(&path, root)) {
                    let message = format!("`{}` is a link that leads out of the folder of `models/`", path.display());
                    return Err(sources.error(&used.origin, message).help("put a copy of the set there"));
                }
                let text = read_text(&path).map_err(|why| {
                    sources.error(&used.origin, format!("`{}` cannot be read: {why}", path.display()))
                })?;
                (path, text, SourceKind::File)
            }
            (None, Some(set)) => (set.path, Arc::from(set.text), SourceKind::BuiltIn),
            (None, None) => return Err(self.not_found(name, &used.origin, sources)),
        };
        let source = sources.add_text(&path, text.clone(), kind);
        tree::parse(&text, source, sources)
    }

    fn not_found(&self, name: &str, origin: &Origin, sources: &Sources) -> Diagnostic {
        let mut known: Vec<String> = built_in::sets().into_iter().map(|set| set.name).collect();
        for folder in &self.folders {
            list(folder, folder, 0, &mut known);
        }
        known.sort();
        known.dedup();
        let short = quote(name);
        sources
            .error(
                origin,
                format!("`use` = \"{short}\": there is no `models/{short}.toml`, and no such set is built in"),
            )
            .help(suggestion(name, &known, "sets"))
    }
}

/// Adds the names of all sets of values in `folder` and its subfolders to `names`. A name is the path relative to the
/// folder `root`. `depth` is the number of folders from `root` down to `folder`.
fn list(root: &Path, folder: &Path, depth: usize, names: &mut Vec<String>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() && depth < 4 {
            list(root, &path, depth + 1, names);
        } else if path.extension().is_some_and(|extension| extension == "toml")
            && let Ok(relative) = path.strip_prefix(root)
        {
            names.push(relative.with_extension("").to_string_lossy().replace('\\', "/"));
        }
    }
}
