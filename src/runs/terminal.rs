//! Output to the user. Apart from the progress bar and the messages of the command-line parser, no other file writes to
//! standard output or standard error.
//!
//! Standard output or standard error may be closed, full, or a pipe whose reader has ended (`diptych run CASE 2>&1 |
//! head -1`). Rust's `println!` and `eprintln!` would then end the program. The functions in this file return instead,
//! so that the work continues and its files are written.

use super::error::StudyError;
use crate::case::{Checked, Diagnostic};
use crate::legible;
use std::fmt::Display;
use std::io::{ErrorKind, Write, stderr, stdout};
use std::path::Path;

/// Prints a line on standard error: progress, a warning, or an error. If the line cannot be printed, it is lost.
pub fn tell(line: impl Display) {
    let line = line.to_string();
    // if standard error fails, there is no other stream for a message
    let _ = writeln!(stderr().lock(), "{}", legible::lines(&line));
}

/// Prints the final sentences of a study on standard output, then a line with the word `what` (such as "Report") and
/// the path `file` of the file with all results. If the sentences cannot be printed, a warning is printed; all results
/// are in the folder nevertheless.
pub fn conclude(sentences: &[String], what: &str, file: &Path) {
    let lines: String = sentences.iter().map(|sentence| format!("{sentence}\n")).collect();
    if let Err(why) = answer(&format!("{lines}{what}: {}\n", file.display())) {
        tell(format!("warning: {}", why.to_string().trim_start_matches("error: ")));
    }
}

/// Prints a text that is the whole result of a command on standard output. It is no error if the reader closes the pipe
/// before the end.
///
/// # Errors
/// Returns [`StudyError::Failed`] if the text cannot be printed, for example because the disk is full. There is no
/// other copy of the text.
pub fn answer(text: &str) -> Result<(), StudyError> {
    print(&legible::lines(text))
}

/// Prints a JSON text that is the whole result of a command, like [`answer`].
///
/// # Errors
/// Returns the errors of [`answer`].
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

/// Prints the warnings about all variants (experiments of a case), equal warnings once. Nothing is printed if `quiet`
/// is true.
pub fn warn(variants: &[Checked], quiet: bool) {
    let mut told: Vec<&Diagnostic> = Vec::new();
    for warning in variants.iter().flat_map(|(_, warnings)| warnings) {
        if !quiet && !told.contains(&warning) {
            tell(warning);
            told.push(warning);
        }
    }
}
