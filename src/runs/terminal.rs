//! Output to the user. This is the only file that writes to standard output and standard error.
//!
//! Either may be closed, full, or a pipe whose reader has gone (`diptych run CASE 2>&1 | head -1`). Rust's `println!`
//! and `eprintln!` end the program then. Here the work goes on and its files are written.

use super::error::StudyError;
use crate::case::{Checked, Diagnostic};
use crate::legible;
use std::fmt::Display;
use std::io::{ErrorKind, Write, stderr, stdout};
use std::path::Path;

/// Tells the user a line on standard error: progress, a warning, an error. If the line cannot be written, it is lost.
pub fn tell(line: impl Display) {
    let line = line.to_string();
    // there is no other place left to which a complaint could go
    let _ = writeln!(stderr().lock(), "{}", legible::lines(&line));
}

/// Prints the final sentences of a study and the file that holds all results, on standard output. If they cannot be
/// printed, everything is in the folder nevertheless: that is a warning.
pub fn conclude(sentences: &[String], what: &str, file: &Path) {
    let lines: String = sentences.iter().map(|sentence| format!("{sentence}\n")).collect();
    if let Err(why) = answer(&format!("{lines}{what}: {}\n", file.display())) {
        tell(format!("warning: {}", why.to_string().trim_start_matches("error: ")));
    }
}

/// Prints a text that is the whole result of a command, on standard output. A reader that closes the pipe early has
/// read enough: that is no error.
///
/// # Errors
/// [`StudyError::Failed`] if it cannot be written, for example because the disk is full: there is no other copy of it.
pub fn answer(text: &str) -> Result<(), StudyError> {
    print(&legible::lines(text))
}

/// Prints a JSON text that is the whole result of a command, as [`answer`] does.
///
/// # Errors
/// The errors of [`answer`].
pub fn answer_json(text: &str) -> Result<(), StudyError> {
    print(&legible::json(text))
}

fn print(text: &str) -> Result<(), StudyError> {
    let mut out = stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(why) if why.kind() != ErrorKind::BrokenPipe => {
            Err(StudyError::Failed(format!("error: cannot write to standard output: {why}")))
        }
        _ => Ok(()),
    }
}

/// Prints the warnings of all variants, each once.
pub fn warn(variants: &[Checked], quiet: bool) {
    let mut told: Vec<&Diagnostic> = Vec::new();
    for warning in variants.iter().flat_map(|(_, warnings)| warnings) {
        if !quiet && !told.contains(&warning) {
            tell(warning);
            told.push(warning);
        }
    }
}
