//! Reasons why a command did not end well, with their exit codes.

use crate::case::Diagnostic;
use crate::output::OutputError;
use serde::{Deserialize, Serialize};

/// Why a command did not end well.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum StudyError {
    /// The input is at fault; nothing was computed and nothing written. Exit code 2.
    #[error("{0}")]
    Input(String),
    /// Something failed on the way; what was written before stays readable. Exit code 1.
    #[error("{0}")]
    Failed(String),
    /// The user stopped the command. Results so far have been written, and the command can be resumed. Exit code 130.
    #[error("{0}")]
    Stopped(String),
}

impl From<Diagnostic> for StudyError {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::Input(diagnostic.to_string())
    }
}

impl From<OutputError> for StudyError {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Occupied { .. } | OutputError::Unfinished { .. } | OutputError::InUse { .. } => {
                Self::Input(format!("error: {error}"))
            }
            other => Self::Failed(format!("error: {other}")),
        }
    }
}
