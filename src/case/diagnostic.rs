//! One message that says where, what, and what to do about it.

use serde::Serialize;
use std::fmt;

/// Whether a case can run in spite of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The case cannot be run.
    Error,
    /// It can, but the reader should know.
    Warning,
}

/// A place in a file, or a `--set` argument (which has no lines: `line` is 0).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Path, or `--set key=value`.
    pub name: String,
    /// First line is 1; 0: the whole of it.
    pub line: usize,
    /// In characters, first is 1.
    pub column: usize,
    /// Characters to underline.
    pub width: usize,
    /// The text of that line.
    pub text: String,
}

/// An error or a warning about a case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// What is wrong: key, value, allowed range.
    pub message: String,
    /// The place that the message is about.
    pub place: Option<Box<Place>>,
    /// The remedy.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error about a file as a whole.
    pub fn about(name: impl Into<String>, message: impl Into<String>) -> Self {
        let place = Some(Box::new(Place { name: name.into(), ..Place::default() }));
        Self { severity: Severity::Error, message: message.into(), place, help: None }
    }

    /// The same with a remedy.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same as a warning.
    pub fn into_warning(mut self) -> Self {
        self.severity = Severity::Warning;
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{word}: {}", self.message)?;
        if let Some(place) = &self.place {
            if place.line == 0 {
                write!(f, "\n --> {}", place.name)?;
            } else {
                write!(f, "\n --> {}:{}:{}", place.name, place.line, place.column)?;
                excerpt(f, place)?;
            }
        }
        if let Some(help) = &self.help {
            write!(f, "\nhelp: {help}")?;
        }
        Ok(())
    }
}

/// The line with the place underlined; long lines are shown around the place.
fn excerpt(f: &mut fmt::Formatter<'_>, place: &Place) -> fmt::Result {
    const SHOWN: usize = 110;
    let first = place.column.saturating_sub(SHOWN / 2).min(place.text.chars().count().saturating_sub(SHOWN));
    // tabs and control characters would move the underline
    let shown: String =
        place.text.chars().skip(first).take(SHOWN).map(|c| if c.is_control() { ' ' } else { c }).collect();
    let indent = place.column.saturating_sub(1 + first);
    let width = place.width.clamp(1, SHOWN.saturating_sub(indent).max(1));
    let number = place.line.to_string();
    let margin = " ".repeat(number.len());
    write!(f, "\n{margin} |\n{number} | {shown}\n{margin} | {}{}", " ".repeat(indent), "^".repeat(width))
}

impl std::error::Error for Diagnostic {}
