//! Errors with which a command ends, and the exit codes of these errors. A variant is one of the experiments of a case.

use crate::case::Diagnostic;
use crate::engine::Failure;
use crate::outcome::Outcome;
use crate::output::OutputError;
use serde::{Deserialize, Serialize};

/// Reason why a command has failed or was stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum StudyError {
    /// The input is wrong. Nothing has been computed or written. Exit code 2.
    #[error("{0}")]
    Input(String),
    /// The command failed after it had begun. Files that were written before the failure can be read. Exit code 1.
    #[error("{0}")]
    Failed(String),
    /// The user has stopped the command. Results so far have been written. The command can be resumed unless the user
    /// has switched checkpoints off. Exit code 130.
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

/// Returns an error if the run of at least one variant (experiment of a case) failed. `variants` gives the name of
/// each variant, and its failure if there is one.
pub fn failures_of<'a>(variants: impl Iterator<Item = (&'a str, Option<&'a Failure>)>) -> Result<(), StudyError> {
    let failed: Vec<String> =
        variants.filter_map(|(name, why)| Some(format!("error: \"{name}\" stopped: {}", why?))).collect();
    if failed.is_empty() { Ok(()) } else { Err(StudyError::Failed(failed.join("\n"))) }
}

/// Returns an error if at least one outcome (result of a run) contains a failure.
pub fn failures(outcomes: &[Outcome]) -> Result<(), StudyError> {
    failures_of(outcomes.iter().map(|o| (o.experiment.name.as_str(), o.failure.as_ref())))
}
