//! Source texts of the values of a case: a case file, a file of `models/`, a table of numbers, or a `--set` argument.

use super::diagnostic::{Diagnostic, Severity, SourceLocation};
use crate::legible;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Text from which values of a case are read: a file, a built-in text or an argument.
#[derive(Clone, Debug)]
pub struct Source {
    /// Name of the text in messages: the path of a file, or `--set key=value`.
    pub name: String,
    /// Folder to which file names in the text are relative.
    pub folder: PathBuf,
    /// Whole text of the source.
    pub text: Arc<str>,
    /// Kind of the source text, such as a file or an argument.
    pub kind: SourceKind,
}

/// Kind of a source text, such as a file or an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// A file on the disk.
    File,
    /// Text that is built into the program; the files that it names are built in too.
    BuiltIn,
    /// An argument of the command line, which has no line numbers.
    Argument,
    /// Values of a calling program. They have no line numbers, and numbers without a unit are meant in SI.
    Values,
    /// Table of numbers of a calling program, in place of a file.
    Table,
}

/// Range of bytes in a source text, from which a value was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Index of the text in [`Sources`].
    pub source: usize,
    /// Range of the value in the text, from its first byte to the byte after its last.
    pub span: Range<usize>,
}

/// All texts from which a case was read, in the order of reading.
#[derive(Clone, Debug, Default)]
pub struct Sources(Vec<Arc<Source>>);

impl Sources {
    /// Adds a source text and returns its index in the list of texts.
    pub fn add(&mut self, source: Source) -> usize {
        self.0.push(Arc::new(source));
        self.0.len() - 1
    }

    /// Adds a file that has been read, and returns its index.
    pub fn add_file(&mut self, path: &Path, text: Arc<str>) -> usize {
        self.add_text(path, text, SourceKind::File)
    }

    /// Adds a text of the given kind, named by its path, and returns its index.
    pub fn add_text(&mut self, path: &Path, text: Arc<str>, kind: SourceKind) -> usize {
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        self.add(Source { name: path.display().to_string(), folder, text, kind })
    }

    /// Source text to which an origin (range of bytes in a source text) refers; `None` if the text is not in this list.
    pub fn get(&self, origin: &Origin) -> Option<&Source> {
        self.0.get(origin.source).map(AsRef::as_ref)
    }

    /// Names of all files from which values of the case have been read so far.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        let is_file = |source: &&Arc<Source>| matches!(source.kind, SourceKind::File | SourceKind::BuiltIn);
        self.0.iter().filter(is_file).map(|source| source.name.as_str())
    }

    /// Index and text of the table of a calling program with this name; `None` if there is no such table.
    pub fn table(&self, name: &str) -> Option<(usize, Arc<str>)> {
        let is_it = |source: &Arc<Source>| source.kind == SourceKind::Table && source.name == name;
        self.0.iter().position(is_it).map(|index| (index, self.0[index].text.clone()))
    }

    /// The `key=value` of every `--set` argument.
    pub fn set_arguments(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter(|source| source.kind == SourceKind::Argument).map(|source| source.text.as_ref())
    }

    /// Text that the user typed at an origin (range of bytes in a source text), cut after 60 characters.
    pub fn typed(&self, origin: &Origin) -> String {
        let text = self.get(origin).and_then(|source| source.text.get(origin.span.clone())).unwrap_or("").trim();
        let mut short: String = text.chars().take(60).map(|c| if legible::acts(c) { ' ' } else { c }).collect();
        if text.chars().nth(60).is_some() {
            short.push('…');
        }
        short
    }

    /// Line number of a value in its source text, counted from 1; 0 if the value was typed in an argument of the
    /// command line, or is a value of a calling program.
    pub fn line(&self, origin: &Origin) -> usize {
        self.place(origin).map_or(0, |place| place.line)
    }

    /// Name of the source text, line and column of a value. For an argument of the command line and for a value of a
    /// calling program only the name is set. `None` if the text is unknown.
    pub fn place(&self, origin: &Origin) -> Option<SourceLocation> {
        let source = self.get(origin)?;
        if matches!(source.kind, SourceKind::Argument | SourceKind::Values) {
            return Some(SourceLocation {
                name: legible::message(&source.name).into_owned(),
                ..SourceLocation::default()
            });
        }
        let text = &source.text;
        // the range in an empty or incomplete text may begin or end within a character of several bytes: both ends are
        // moved to a character boundary
        let mut start = origin.span.start.min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let mut end = origin.span.end.clamp(start, line_end);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        Some(SourceLocation {
            name: legible::message(&source.name).into_owned(),
            line: text[..start].matches('\n').count() + 1,
            column: text[line_start..start].chars().count() + 1,
            width: text[start..end].trim_end().chars().count().max(1),
            text: text[line_start..line_end].trim_end().to_string(),
        })
    }

    /// Creates an error about the text at `origin`.
    pub fn error(&self, origin: &Origin, message: impl Into<String>) -> Diagnostic {
        Diagnostic::at(self.place(origin), message)
    }

    /// Creates a warning about the text at `origin`.
    pub fn warning(&self, origin: &Origin, message: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..self.error(origin, message) }
    }
}
