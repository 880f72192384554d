//! Cases, and particles at the start, from values that a calling program passes in place of files.

use super::diagnostic::Diagnostic;
use super::source::{Origin, Source, SourceKind};
use super::tree::{CaseNode, KeyPart, Value};
use super::{Case, Setting};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name, in messages, of a case that was made from values. It is also the title of such a case.
const SCENE: &str = "scene";

/// Name, in messages, of the table of the particles at the start.
pub(super) const START: &str = "particles at the start";

impl Case {
    /// Reads a case from values of a calling program, written as TOML. Numbers without a unit are in SI. Files that the
    /// case names are relative to the current folder. `sets` are arguments as in [`read`](Self::read).
    ///
    /// # Errors
    /// The text is not TOML, or an argument is not `key=value`.
    pub fn from_values(text: Arc<str>, sets: &[String]) -> Result<Self, Diagnostic> {
        Self::of_kind(SourceKind::Values, Path::new(SCENE), text, sets)
    }

    /// Replaces the particles at the start by those of a `table`. The table is the text of a CSV file in SI, as for the
    /// key `particles.file`. It has the columns x, y, z and, as far as they are known, id, vx, vy, vz, diameter,
    /// species, wx, wy, wz.
    ///
    /// # Errors
    /// The case has several kinds of particles, and the table has no column `species`.
    pub fn with_start(mut self, table: Arc<str>) -> Result<Self, Diagnostic> {
        let kinds = match self.tree.get("particles").map(|node| &node.value) {
            Some(Value::Array(kinds)) => kinds.len(),
            _ => 0,
        };
        let header = table.lines().next().unwrap_or_default();
        if kinds > 1 && header.split(',').all(|column| column != "species") {
            let message = format!("the case has {kinds} kinds of particles, and `species` is not given");
            return Err(
                Diagnostic::about(START, message).help("give the name or the index of the kind of each particle")
            );
        }
        let source = |text: Arc<str>, kind| Source { name: START.to_owned(), folder: PathBuf::new(), text, kind };
        self.sources.add(source(table, SourceKind::Table));
        let named = self.sources.add(source(START.into(), SourceKind::Values));
        let origin = Origin { source: named, span: 0..START.len() };
        for kind in 0..kinds {
            let path = [KeyPart::Key("particles".into()), KeyPart::Index(kind), KeyPart::Key("file".into())];
            let value = CaseNode { value: Value::String(START.into()), origin: origin.clone() };
            self.sets.push(Setting { path: path.into(), value, key_origin: origin.clone() });
        }
        Ok(self)
    }
}
