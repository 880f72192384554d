//! Invocation of a command: it begins, or it resumes one that was stopped.

use super::session::{self, StudyError, quoted};
use crate::case::Case;
use crate::checkpoint::StoredCommand;
use crate::cli::Output;
use crate::output::{Folder, Provenance};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Origin of a command.
pub enum Invocation {
    /// The user typed the command.
    First,
    /// `resume` goes on with the command.
    Resumed {
        /// Folder of the results of the command.
        folder: PathBuf,
        /// Command line as it was typed when the command began.
        command: StoredCommand,
        /// True if the command prints nothing while it runs.
        quiet: bool,
    },
}

impl Invocation {
    /// Command line with which the command began.
    pub fn arguments(&self) -> Vec<OsString> {
        match self {
            Self::First => std::env::args_os().collect(),
            Self::Resumed { command, .. } => command.arguments.clone(),
        }
    }

    /// True if the command does not report the stored states that it finds.
    pub fn quiet(&self) -> bool {
        matches!(self, Self::Resumed { quiet: true, .. })
    }

    /// Path of the folder for the results of the command.
    pub fn place(&self, output: &Output, case: &Path, command: &str) -> PathBuf {
        match self {
            Self::First => session::place(output, case, command),
            Self::Resumed { folder, .. } => folder.clone(),
        }
    }

    /// Folder for the results of the command.
    ///
    /// # Errors
    /// The folder is in use, cannot be written to, or, for a command that begins, holds results.
    pub fn folder(&self, output: &Output, case: &Path, command: &str) -> Result<Folder, StudyError> {
        match self {
            Self::First => session::folder(output, case, command),
            Self::Resumed { folder, .. } => {
                Folder::resume(folder).map_err(|error| StudyError::Input(format!("error: {error}")))
            }
        }
    }

    /// Provenance of the results; `scene`: description of the scene.
    pub fn provenance(&self, case: &Case, scene: String) -> Provenance {
        Provenance { command: quoted(self.arguments()), ..session::provenance(case, scene) }
    }
}
