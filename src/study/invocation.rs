//! Whether a command begins, or goes on with one that was stopped.

use super::session::{self, StudyError, quoted};
use crate::case::Case;
use crate::checkpoint::StoredCommand;
use crate::cli::Output;
use crate::output::{Folder, Provenance};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Why a command runs.
pub enum Invocation {
    /// The user typed the command.
    First,
    /// `resume` goes on with the command.
    Resumed {
        /// The folder of its results.
        folder: PathBuf,
        /// What was typed when it began.
        command: StoredCommand,
        /// Whether it says nothing on the way.
        quiet: bool,
    },
}

impl Invocation {
    /// The command line with which it began.
    pub fn arguments(&self) -> Vec<OsString> {
        match self {
            Self::First => std::env::args_os().collect(),
            Self::Resumed { command, .. } => command.arguments.clone(),
        }
    }

    /// Whether it says nothing on the way of what it finds stored.
    pub fn quiet(&self) -> bool {
        matches!(self, Self::Resumed { quiet: true, .. })
    }

    /// Where the folder of its results is.
    pub fn place(&self, output: &Output, case: &Path, command: &str) -> PathBuf {
        match self {
            Self::First => session::place(output, case, command),
            Self::Resumed { folder, .. } => folder.clone(),
        }
    }

    /// The folder of its results.
    ///
    /// # Errors
    /// The folder is in use, cannot be written to, or, for one that begins, holds results.
    pub fn folder(&self, output: &Output, case: &Path, command: &str) -> Result<Folder, StudyError> {
        match self {
            Self::First => session::folder(output, case, command),
            Self::Resumed { folder, .. } => {
                Folder::resume(folder).map_err(|error| StudyError::Input(format!("error: {error}")))
            }
        }
    }

    /// Where results come from; `scene`: in words.
    pub fn provenance(&self, case: &Case, scene: String) -> Provenance {
        Provenance { command: quoted(self.arguments()), ..session::provenance(case, scene) }
    }
}
