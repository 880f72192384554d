//! Message about a case: its position, the problem and a remedy.

use crate::legible;
use serde::Serialize;
use std::fmt;

/// Severity of a message: error or warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The case cannot be run.
    Error,
    /// The case can be run, but the user should be informed.
    Warning,
}

/// Position in a file or in a `--set` argument. An argument has no lines, so that its line number is 0.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SourceLocation {
    /// Path of the file, or `--set key=value`.
    pub name: String,
    /// Line number, 1 for the first; 0 for the file as a whole.
    pub line: usize,
    /// Column in characters, 1 for the first.
    pub column: usize,
    /// Number of characters, from the column on, that are underlined in the message.
    pub width: usize,
    /// Text of the line that contains the position.
    pub text: String,
}

/// An error or a warning about a case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Severity of the message: error or warning.
    pub severity: Severity,
    /// Problem in words: key, value, allowed range.
    pub message: String,
    /// Position to which the message refers; `None` if it refers to no position in a text.
    pub place: Option<Box<SourceLocation>>,
    /// Remedy in words; `None` if there is none.
    pub help: Option<String>,
}

impl Diagnostic {
    /// Creates an error about a file as a whole.
    pub fn about(name: impl Into<String>, message: impl Into<String>) -> Self {
        let place = SourceLocation { name: legible::message(&name.into()).into_owned(), ..SourceLocation::default() };
        Self::at(Some(place), message)
    }

    /// Creates an error about the position `place`, or about no position with `None`. Control characters in quoted
    /// texts are made visible.
    pub fn at(place: Option<SourceLocation>, message: impl Into<String>) -> Self {
        let message = legible::message(&message.into()).into_owned();
        Self { severity: Severity::Error, message, place: place.map(Box::new), help: None }
    }

    /// Returns the message with a remedy added.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(legible::message(&help.into()).into_owned());
        self
    }

    /// Returns the message as a warning instead of an error.
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

/// Writes the line of the position with an underline. If the line is long, only its part near the position is written.
fn excerpt(f: &mut fmt::Formatter<'_>, place: &SourceLocation) -> fmt::Result {
    const SHOWN: usize = 110;
    let first = place.column.saturating_sub(SHOWN / 2).min(place.text.chars().count().saturating_sub(SHOWN));
    // tabs and control characters would move the underline
    let seen = |c: char| if legible::acts(c) { ' ' } else { c };
    let shown: String = place.text.chars().skip(first).take(SHOWN).map(seen).collect();
    let indent = place.column.saturating_sub(1 + first);
    let width = place.width.clamp(1, SHOWN.saturating_sub(indent).max(1));
    let number = place.line.to_string();
    let margin = " ".repeat(number.len());
    write!(f, "\n{margin} |\n{number} | {shown}\n{margin} | {}{}", " ".repeat(indent), "^".repeat(width))
}

impl std::error::Error for Diagnostic {}
